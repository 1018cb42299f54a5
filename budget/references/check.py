"""Hold a reference against its files as they are now; hold two budgets together."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from budget.errors import BudgetError, CallError
from budget.references.attribution import (
    Side,
    explain,
    input_changes,
    version_changes,
)
from budget.references.difference import count_compared, find_moves
from budget.references.files import present_documents, stored_documents
from budget.references.jobs import check_asked, compute
from budget.references.records import (
    TOOL,
    Change,
    Difference,
    ReferenceBudget,
)
from budget.references.store import present_versions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from budget.references.records import Asked, Job, Move, StoredInput

# What takes the place of causes where the stored inputs cannot be read.
_UNREADABLE = Change(
    where=TOOL,
    key="stored inputs",
    before="read when stored",
    after="not read by this version",
)


def make_reference(
    job: Job, inputs: Sequence[StoredInput], asked: Asked, *, workers: int = 1
) -> ReferenceBudget:
    """Compute a reference from its inputs.

    Raises
    ------
    CallError, SpecError
        Inputs or settings that do not fit together.
    """
    check_asked(job, asked)
    read = stored_documents(inputs, reference="", job=job)
    computed = compute(job, read, asked, workers=workers)
    return ReferenceBudget(
        job=job,
        inputs=tuple(inputs),
        settings=asked,
        numbers=computed.numbers,
        words=computed.words,
        versions=present_versions(),
    )


def side_of(budget: ReferenceBudget, *, name: str) -> Side:
    """Return a reference as one side of a difference.

    Raises
    ------
    SpecError
        A stored input cannot be read.
    """
    inputs = stored_documents(budget.inputs, reference=name, job=budget.job)
    return Side(name=name, inputs=inputs, budget=budget)


def check(
    reference: ReferenceBudget,
    folder: Path,
    *,
    name: str,
    workers: int = 1,
    root: Path | None = None,
) -> Difference:
    """Compute a reference again from its files as they are now, and compare.

    Parameters
    ----------
    reference : ReferenceBudget
        What is stored; its texts serve to explain, never to compute what is compared.
    folder : Path
        Where it stands.
    name : str
        How it is called in the result.
    workers : int
        Number of processes; changes no number.
    root : Path, optional
        Folder that its files must be in; see `files.tree_of`.

    Returns
    -------
    Difference
        Moves in the order of the result.

    Raises
    ------
    ReferenceFileError, SpecError, CallError
        A file is gone, is outside the tree, or cannot be computed with.
    """
    job, asked = reference.job, reference.settings
    check_asked(job, asked)
    inputs = present_documents(
        reference.inputs, folder, reference=name, job=job, root=root
    )
    computed = compute(job, inputs, asked, workers=workers)
    now = replace(
        reference,
        numbers=computed.numbers,
        words=computed.words,
        known=computed.known,
        versions=present_versions(),
    )
    changes = version_changes(reference.versions, now.versions)
    moves = find_moves(reference, now)
    try:
        then = side_of(reference, name=name)
    except BudgetError:  # stored inputs only explain: they stop no check
        changes = (_UNREADABLE, *changes)
    else:
        changes = (*input_changes(then.inputs, inputs), *changes)
        if moves:
            side = Side(name=name, inputs=inputs, budget=now)
            changes, moves = explain(then, side, moves)
    return _difference((name, name), reference, now, moves, changes)


def compare_sides(first: Side, second: Side) -> Difference:
    """Hold two budgets side by side, the largest change first.

    Largest is by the difference over the first side's standard uncertainty of the
    output; of a number that belongs to no output over itself.

    Raises
    ------
    CallError
        They are of different kinds.
    """
    a, b = first.budget, second.budget
    if a.job != b.job:
        raise CallError(
            f"{first.name} is of kind {a.job}, {second.name} of kind {b.job}: they "
            "have no numbers in common; give two of one kind"
        )
    changes, moves = explain(first, second, find_moves(a, b))
    largest = tuple(sorted(moves, key=lambda move: -move.size))
    return _difference((first.name, second.name), a, b, largest, changes)


def _difference(
    names: tuple[str, str],
    before: ReferenceBudget,
    after: ReferenceBudget,
    moves: tuple[Move, ...],
    changes: tuple[Change, ...],
) -> Difference:
    """Put together what differs between two budgets."""
    return Difference(
        first=names[0],
        second=names[1],
        job=before.job,
        compared=count_compared(before, after),
        sampled=sum(number.is_sampled for number in before.numbers),
        moves=moves,
        changes=changes,
    )
