"""Stored budgets against present ones: on a terminal, as JSON and as CSV."""
