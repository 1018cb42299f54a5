"""The texts of a drawn figure, for tests that ask what it says and whether it fits."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from budget.report.figures.style import to_svg

VEILED = 0.1  # opacity of a bar from which a line behind it is hidden or faint [1]
SLACK = 2.0  # for the font of whoever shows the figure [pt]


def texts(figure):
    """Return all texts that stand in the SVG of a figure."""
    root = ET.fromstring(to_svg(figure, name="f"))  # noqa: S314 - our own
    return [
        "".join(e.itertext()) for e in root.iter("{http://www.w3.org/2000/svg}text")
    ]


def cut_texts(figure):
    """Return the texts that do not lie within the figure."""
    figure.draw_without_rendering()  # labels of axes have their place only then
    width, height = (72.0 * inches for inches in figure.get_size_inches())
    found = [t for t in figure.findobj(Text) if t.get_text() and t.get_visible()]
    assert found
    cut = []
    for text in found:
        box = text.get_window_extent()
        x0, y0, x1, y1 = (72.0 / figure.dpi * float(x) for x in box.extents)
        beyond = max(-x0, -y0, x1 - width, y1 - height)
        if beyond > SLACK:
            cut.append((text.get_text(), beyond))
    return cut


def crossed_texts(figure):
    """Return the texts that a line runs through, and those that lie on another text.

    Lines are those of axes and grids that nothing is drawn over where the text stands,
    and those that are drawn as such.
    """
    figure.draw_without_rendering()
    found = [t for t in figure.findobj(Text) if t.get_text() and t.get_visible()]
    boxes = [(t, t.get_window_extent().padded(-1.5)) for t in found]
    crossed = [
        (text.get_text(), "line")
        for text, box in boxes
        for axes in figure.axes
        if text.get_bbox_patch() is None and _crosses(axes, box)
    ]
    crossed += [
        (one.get_text(), other.get_text())
        for place, (one, box) in enumerate(boxes)
        for other, beside in boxes[:place]
        if box.overlaps(beside)
    ]
    return crossed


def _crosses(axes, box):
    """Whether a line of these axes runs through a box and no bar covers it there."""
    covered = any(
        bar.get_window_extent().padded(1.5).containsx(x)
        and bar.get_window_extent().padded(1.5).containsy((box.y0 + box.y1) / 2.0)
        for bar in axes.patches
        if bar.get_facecolor()[3] > VEILED
        for x in ((box.x0 + box.x1) / 2.0,)
    )
    segments = [
        line.get_transform().transform(line.get_xydata())
        for line in axes.lines
        if line.get_linestyle() != "None"
    ]
    if not covered:
        segments += [
            collection.get_transform().transform(path.vertices)
            for collection in axes.collections
            if isinstance(collection, LineCollection)
            for path in collection.get_paths()
        ]
    frame = axes.get_window_extent()
    for line in segments:
        for start, end in pairwise(line):
            low, high = np.minimum(start, end), np.maximum(start, end)
            low = np.maximum(low, (frame.x0, frame.y0))
            high = np.minimum(high, (frame.x1, frame.y1))
            inside = high[0] >= low[0] and high[1] >= low[1]
            if inside and box.overlaps(Bbox([low - 0.01, high + 0.01])):
                return True
    return False
