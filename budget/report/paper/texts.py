"""Numbers and reasons of a finding as texts, the same in every form."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.tables import print_given, round_uncertainty
from budget.studies.paper.printed import VALUE, say

if TYPE_CHECKING:
    from budget.studies.paper.printed import Finding

NEAR_ONE = 1e-3  # a ratio this close to 1 is printed with all its digits [1]
LEAST_P = 1e-6  # [1]; below it a probability is printed as such


def print_ours(row: Finding) -> str:
    """Print ours: six digits of a value, two of a standard uncertainty, or a word."""
    if isinstance(row.ours, str):
        return row.ours
    if row.quantity == VALUE:
        return print_given(row.ours, digits=6)
    return round_uncertainty(row.ours)


def print_ratio(ratio: float | None) -> str:
    """Print ours over printed, '' where there is none."""
    if ratio is None:
        return ""
    if abs(ratio - 1.0) < NEAR_ONE:
        return f"{ratio:.6f}"
    return print_given(ratio, digits=3)


def print_probability(p: float | None) -> str:
    """Print a probability to two digits, '' where there is none."""
    if p is None:
        return ""
    return f"<{say(LEAST_P)}" if p < LEAST_P else say(p)


def reason(row: Finding) -> str:
    """Say why, but where the row of all the entries judged together says it."""
    return "" if row.why.startswith("judged with") else row.why
