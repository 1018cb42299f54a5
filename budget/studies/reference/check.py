"""Hold a reference against its files as they are now; hold two budgets together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.errors import BudgetError, CallError
from budget.studies.reference.explain import (
    Side,
    explain,
    input_changes,
    version_changes,
)
from budget.studies.reference.jobs import check_asked, compute
from budget.studies.reference.moves import count_compared, find_moves
from budget.studies.reference.parts import present_parts, stored_parts
from budget.studies.reference.records import (
    TOOL,
    Change,
    Checked,
    Difference,
    ReferenceBudget,
)
from budget.studies.reference.store import present_versions

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from budget.studies.reference.records import Asked, Job, Part, StoredInput

# What takes the place of causes where the stored inputs cannot be read.
_UNREADABLE = Change(
    where=TOOL,
    key="stored inputs",
    before="read when stored",
    after="not read by this version",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class NamedSide:
    """One side of a difference, as a user named it."""

    name: str
    side: Side


def make_reference(
    job: Job,
    inputs: Sequence[StoredInput],
    asked: Asked,
    *,
    workers: int = 1,
) -> ReferenceBudget:
    """Compute a reference from its inputs.

    Raises
    ------
    CallError, SpecError
        Inputs or settings that do not fit together.
    """
    check_asked(job, asked)
    parts = stored_parts(inputs, reference="", job=job)
    computed = compute(job, parts, asked, workers=workers)
    return ReferenceBudget(
        job=job,
        inputs=tuple(inputs),
        settings=asked,
        numbers=computed.numbers,
        words=computed.words,
        versions=present_versions(),
    )


def check(
    reference: ReferenceBudget,
    folder: Path,
    *,
    name: str,
    workers: int = 1,
    root: Path | None = None,
) -> Checked:
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
        Folder that its files must be in; see `parts.tree_of`.

    Raises
    ------
    ReferenceFileError, SpecError, CallError
        A file is gone, is outside the tree, or cannot be computed with.
    """
    job, asked = reference.job, reference.settings
    check_asked(job, asked)
    now = present_parts(reference.inputs, folder, reference=name, job=job, root=root)
    snapshot = compute(job, now, asked, workers=workers)
    moves = find_moves(reference, snapshot)
    stored = reference
    versions = present_versions()
    then = _parts_then(reference, name)
    if then is None:
        changes: tuple[Change, ...] = (
            _UNREADABLE,
            *version_changes(reference.versions, versions),
        )
    elif moves:
        told = explain(
            job,
            Side(parts=then, asked=asked, snapshot=stored, versions=reference.versions),
            Side(parts=now, asked=asked, snapshot=snapshot, versions=versions),
            moves,
        )
        changes, moves = told.changes, told.moves
    else:
        changes = (
            *input_changes(then, now),
            *version_changes(reference.versions, versions),
        )
    return Checked(
        name=name,
        job=job,
        compared=count_compared(stored, snapshot),
        sampled=sum(number.is_sampled for number in stored.numbers),
        moves=moves,
        changes=changes,
    )


def _parts_then(reference: ReferenceBudget, name: str) -> tuple[Part, ...] | None:
    """Return the stored inputs; None where this version reads them no longer.

    They only explain: that they cannot be read stops no check.
    """
    try:
        return stored_parts(reference.inputs, reference=name, job=reference.job)
    except BudgetError:
        return None


def stored_side(reference: ReferenceBudget, *, name: str) -> NamedSide:
    """Return a reference as one side of a difference."""
    return NamedSide(
        name=name,
        side=Side(
            parts=stored_parts(reference.inputs, reference=name, job=reference.job),
            asked=reference.settings,
            snapshot=reference,
            versions=reference.versions,
        ),
    )


def computed_side(
    inputs: Sequence[StoredInput], asked: Asked, *, name: str
) -> NamedSide:
    """Analyze a device now, as one side of a difference."""
    parts = stored_parts(inputs, reference="", job="analyze")
    return NamedSide(
        name=name,
        side=Side(
            parts=parts,
            asked=asked,
            snapshot=compute("analyze", parts, asked),
            versions=present_versions(),
        ),
    )


def compare_sides(
    first: NamedSide, second: NamedSide, jobs: tuple[str, str]
) -> Difference:
    """Hold two budgets side by side, the largest change first.

    Largest is by the difference over the first side's standard uncertainty of the
    output; of a number that belongs to no output over itself.

    Raises
    ------
    CallError
        They are of different kinds.
    """
    if jobs[0] != jobs[1]:
        raise CallError(
            f"{first.name} is of kind {jobs[0]}, {second.name} of kind {jobs[1]}: they "
            "have no numbers in common; give two of one kind"
        )
    a, b = first.side, second.side
    told = explain(jobs[0], a, b, find_moves(a.snapshot, b.snapshot))
    return Difference(
        first=first.name,
        second=second.name,
        job=jobs[0],
        compared=count_compared(a.snapshot, b.snapshot),
        moves=tuple(sorted(told.moves, key=lambda move: -move.size)),
        changes=told.changes,
    )
