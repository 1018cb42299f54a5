"""Figures: result in, drawing out; each with a finding and words for it.

One module for each question that a figure answers, `rows` for all that are rows of
marks, `style` for what all share. Widths are those of a column (330 pt) or of the page
(700 pt).
"""
