"""A finding of the paper as texts: its place and numbers, the same in every form."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.figures.picture import capital
from budget.report.tables import print_given, round_uncertainty
from budget.studies.paper.findings import VALUE, Verdict, say

if TYPE_CHECKING:
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

NEAR_ONE = 1e-3  # a ratio this close to 1 is printed with all its digits [1]
LEAST_P = 1e-6  # [1]; below it a probability is printed as such
WHOLE = "Table 1 as a whole"
# Where the head of a row ends: what follows stands below it, in a narrow column.
SPECIAL = re.compile(r" (?=(?:from|beyond|of|random|with) )")


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a finding stands in its table.

    Attributes
    ----------
    group : str
        Title of the rows that it belongs to: 'Bias stability'.
    name : str
        Head of its row: 'mounting angle xy'.
    note : str
        What is special about it: 'from its angles'.
    """

    group: str
    name: str
    note: str = ""


def place_of(row: Finding) -> Place:
    """Split the place of a finding into that of its group and its own."""
    text = shorten(row)
    if row.section == "readings":  # of what entries: which reading
        entries, _, reading = text.partition(": ")
        group, _, name = entries.rpartition(", ")
        return Place(group=capital(f"{group}: {reading}"), name=name)
    if row.section == "conclusions":  # sentences, under the section they stand in
        group, _, name = text.partition(": ")
        return Place(group=group, name=name)
    if row.section == "text":
        group, _, name = text.rpartition(", ")
    else:
        group, _, name = text.partition(", ")
    head, *special = SPECIAL.split(name or group, maxsplit=1)
    return Place(
        group=capital(group) if name else WHOLE, name=head, note="".join(special)
    )


def shorten(row: Finding) -> str:
    """Name the place without what the title of its section says already."""
    if row.section == "readings":
        return row.where
    return row.where.removeprefix("Table 1, ").removeprefix("section ")


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


def unexplained(study: PaperStudy) -> tuple[Finding, ...]:
    """Return what nothing explains, entries of one row gathered."""
    return tuple(
        row
        for row in study.findings
        if row.verdict == Verdict.UNEXPLAINED and row.is_summary
    )
