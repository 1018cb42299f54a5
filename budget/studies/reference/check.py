"""Hold a reference against its files as they are now; hold two budgets together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.errors import BudgetError, CallError
from budget.studies.reference.explain import (
    Side,
    explain,
    input_changes,
    version_changes,
)
from budget.studies.reference.files import present_documents, stored_documents
from budget.studies.reference.jobs import check_asked, compute
from budget.studies.reference.moves import count_compared, find_moves
from budget.studies.reference.records import (
    TOOL,
    Change,
    Difference,
    ReferenceBudget,
)
from budget.studies.reference.store import present_versions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from budget.spec.tree import Document
    from budget.studies.reference.records import Asked, Job, StoredInput

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
    documents = stored_documents(inputs, reference="", job=job)
    side = computed_side(job, documents, asked, name="", workers=workers)
    return ReferenceBudget(
        job=job,
        inputs=tuple(inputs),
        settings=asked,
        numbers=side.snapshot.numbers,
        words=side.snapshot.words,
        versions=side.versions,
    )


def computed_side(
    job: Job, inputs: tuple[Document, ...], asked: Asked, *, name: str, workers: int = 1
) -> Side:
    """Compute a budget now. Raises as make_reference."""
    check_asked(job, asked)
    return Side(
        name=name,
        job=job,
        inputs=inputs,
        asked=asked,
        snapshot=compute(job, inputs, asked, workers=workers),
        versions=present_versions(),
    )


def stored_side(reference: ReferenceBudget, *, name: str) -> Side:
    """Return a reference as one side of a difference.

    Raises
    ------
    SpecError
        A stored input cannot be read.
    """
    return Side(
        name=name,
        job=reference.job,
        inputs=stored_documents(reference.inputs, reference=name, job=reference.job),
        asked=reference.settings,
        snapshot=reference,
        versions=reference.versions,
    )


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
    now = computed_side(job, inputs, asked, name=name, workers=workers)
    versions = version_changes(reference.versions, now.versions)
    moves = find_moves(reference, now.snapshot)
    try:
        then = stored_side(reference, name=name)
    except BudgetError:  # stored inputs only explain: they stop no check
        changes: tuple[Change, ...] = (_UNREADABLE, *versions)
    else:
        changes = (*input_changes(then.inputs, now.inputs), *versions)
        if moves:
            changes, moves = explain(then, now, moves)
    return Difference(
        first=name,
        second=name,
        job=job,
        compared=count_compared(reference, now.snapshot),
        sampled=sum(number.is_sampled for number in reference.numbers),
        moves=moves,
        changes=changes,
    )


def compare_sides(first: Side, second: Side) -> Difference:
    """Hold two budgets side by side, the largest change first.

    Largest is by the difference over the first side's standard uncertainty of the
    output; of a number that belongs to no output over itself.

    Raises
    ------
    CallError
        They are of different kinds.
    """
    if first.job != second.job:
        raise CallError(
            f"{first.name} is of kind {first.job}, {second.name} of kind {second.job}: "
            "they have no numbers in common; give two of one kind"
        )
    a, b = first.snapshot, second.snapshot
    changes, moves = explain(first, second, find_moves(a, b))
    return Difference(
        first=first.name,
        second=second.name,
        job=first.job,
        compared=count_compared(a, b),
        sampled=sum(number.is_sampled for number in a.numbers),
        moves=tuple(sorted(moves, key=lambda move: -move.size)),
        changes=changes,
    )
