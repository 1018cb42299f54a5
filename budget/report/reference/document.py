"""Checks and differences for other programs: what their documents have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.documents import written
from budget.references.difference import Difference, Move
from budget.report.reference.sections import cause_texts, together_text

if TYPE_CHECKING:
    from collections.abc import Sequence


def moved(differences: Sequence[Difference]) -> list[tuple[str, Move]]:
    """Return what moved, each with the name of what it is in."""
    return [(one.first, move) for one in differences for move in one.moves]


def _because(move: Move) -> str:
    """Say which changes explain how much of a move."""
    because = [f"{one.key} {part}" for one, part in cause_texts(move)]
    if together := together_text(move):
        because.append(f"together {together}")
    return "; ".join(because)


written(
    "difference_moved",
    """
    subject = item.subject: what it is of, 'gyro.bias.x', 'hg4930.yaml#C gyro'
    quantity = item.quantity: 'standard_uncertainty', 'verdict', ...
    partner = item.partner: a source, or the other output of a correlation
    unit: of a number
    before: null where there was none
    after: null where there is none
    difference [unit]: null of words
    relative [1]: difference over the value before
    sampled = is_sampled: whether another seed gives another value
    times [1]: difference over its tolerance or, of a sampled number, over the standard
      error of a difference
    causes not in CSV: changes that explain some of it
    together not in CSV [unit]: what all changes do at once beyond the sum of what each
      does alone
    because: in words, which changes explain it
    """,
    because=_because,
)(Move)
written(
    "moved",
    """
    reference = 0 (str): in which
    *1 as difference_moved
    """,
    said="One number or word that is not what it was.",
)(tuple)
written(
    "difference",
    """
    first: how it is called
    second
    kind = job: 'analyze', 'mission', 'compare' or 'allocate'
    compared: how many numbers and words
    changes: of files, settings and versions
    moved = moves as difference_moved: the largest change first
    """,
    commands="diff",
)(Difference)
written(
    "check",
    """
    holds (bool): whether nothing moved and nothing is wrong with a reference
    references = 0 as reference (tuple[Difference, ...])
    moved as moved (tuple[Move, ...]): in all of them
    errors = 1 (list[str]): of references that are none
    """,
    said="Two budgets side by side: a reference and what it is now, or any two.",
    commands="check",
    holds=lambda found: not found[1] and all(one.holds for one in found[0]),
    moved=lambda found: moved(found[0]),
)(tuple)
