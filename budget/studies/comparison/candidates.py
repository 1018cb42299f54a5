"""Candidates of a comparison: what would mend them, and what they lack."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.missing import REFUSE
from budget.studies.comparison.records import MissingLines
from budget.ties import settle

if TYPE_CHECKING:
    from budget.question import Question
    from budget.results import Verdict


def missing_lines(one: Question, verdict: Verdict) -> MissingLines | None:
    """Return what lines that are not given could do to limits; None where none can."""
    missing = verdict.matter(one.bare.missing)
    if not missing:
        return None
    used = verdict.at_ceilings
    is_bound = one.filled.mode == REFUSE
    return MissingLines(
        lines=missing,
        filling=one.filled,
        utilisation=used if is_bound else None,
        verdict=""
        if used is None or not is_bound
        else ("meets" if settle(used) <= 1.0 else "fails"),
        is_bound=is_bound,
    )
