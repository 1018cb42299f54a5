"""Hold a reference against its files as they are now; hold two budgets together.

What moved is attributed: to the tool, by computing what is stored again with it, and to
the inputs, by exchanging them one key at a time.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

from budget.errors import BudgetError, CallError
from budget.references.difference import count_compared, find_moves
from budget.references.exchange import input_changes
from budget.references.files import present_documents, stored_documents
from budget.references.jobs import by_law, check_asked, compute
from budget.references.records import (
    EXACT,
    TOOL,
    Cause,
    Change,
    Difference,
    ReferenceBudget,
    finite,
)
from budget.references.store import present_versions

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from budget.references.records import (
        Asked,
        Job,
        Key,
        Move,
        Snapshot,
        StoredInput,
    )
    from budget.spec.tree import Document

MOST_CHANGES = 200  # keys that are exchanged one by one; more is another file
# What takes the place of causes where the stored inputs cannot be read.
_UNREADABLE = Change(
    where=TOOL,
    key="stored inputs",
    before="read when stored",
    after="not read by this version",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Side:
    """One of two budgets, with its inputs read."""

    name: str
    inputs: tuple[Document, ...]
    budget: ReferenceBudget

    def again(self) -> Snapshot | None:
        """Compute it again; None where its inputs make no sound files."""
        try:
            return compute(self.budget.job, self.inputs, self.budget.settings)
        except BudgetError:
            return None

    def law(self) -> Snapshot | None:
        """Compute it again by the law; None where its inputs make no sound files."""
        return self.asking(by_law(self.budget.settings)).again()

    def asking(self, settings: Asked) -> Side:
        """Return the same with other settings."""
        return replace(self, budget=replace(self.budget, settings=settings))


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
    changes = _version_changes(reference.versions, now.versions)
    moves = find_moves(reference, now)
    try:
        then = side_of(reference, name=name)
    except BudgetError:  # stored inputs only explain: they stop no check
        changes = (_UNREADABLE, *changes)
    else:
        files = (one.change for one in input_changes(then.inputs, inputs))
        changes = (*(replace(one, acts=False) for one in files), *changes)
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


def explain(
    before: Side, after: Side, moves: Sequence[Move]
) -> tuple[tuple[Change, ...], tuple[Move, ...]]:
    """Say what differs between two sides, and what each change did to each number.

    The side before is computed again with the tool as it is: what that moves is the
    tool's doing. Then its keys are exchanged one at a time for those after, and every
    result by the law is held against the one without. What all of them do at once, by
    the law too, beyond the sum of that is their doing together.

    Parameters
    ----------
    before, after : Side
    moves : sequence of Move
        From the one to the other.

    Returns
    -------
    changes : tuple of Change
        Those that act on a number first; among them of files, settings, versions.
    moves : tuple of Move
        The same with their causes.
    """
    law = before.law()
    changes: list[Change] = []
    causes: dict[Key, list[Cause]] = {move.key: [] for move in moves}
    for change, side in _exchanges(before, after):
        alone = side.law() if law is not None and side is not None else None
        acts = None
        if law is not None and alone is not None:
            acts = _note(causes, len(changes), find_moves(law, alone))
        changes.append(replace(change, acts=acts))
    together = _together(causes, law, after.law())
    versions = list(_version_changes(before.budget.versions, after.budget.versions))
    by_law_already = before.budget.settings == by_law(before.budget.settings)
    again = law if by_law_already else before.again()
    if again is not None:
        acts = _note(causes, len(changes), find_moves(before.budget, again))
        if acts and not versions:
            versions = [
                Change(where=TOOL, key="code", before="as stored", after="as it is")
            ]
        # Versions cannot be exchanged: what they moved, they moved together.
        versions = [replace(one, acts=None if acts else False) for one in versions]
    changes += versions
    # What acts comes first, so that a reader meets the numbers that moves refer to;
    # what by design never does comes last.
    order = sorted(
        range(len(changes)),
        key=lambda k: (changes[k].acts is False, changes[k].is_text),
    )
    told = (
        replace(
            move,
            causes=tuple(
                replace(cause, change=order.index(cause.change))
                for cause in causes[move.key]
            ),
            together=together.get(move.key),
        )
        for move in moves
    )
    return tuple(changes[k] for k in order), tuple(told)


def _version_changes(
    before: Mapping[str, str], after: Mapping[str, str]
) -> tuple[Change, ...]:
    """Return the versions that differ."""
    return tuple(
        Change(
            where=TOOL, key=name, before=before.get(name, ""), after=after.get(name, "")
        )
        for name in dict.fromkeys((*after, *before))
        if before.get(name) != after.get(name)
    )


def _exchanges(before: Side, after: Side) -> Iterator[tuple[Change, Side | None]]:
    """Yield every difference of files and settings, and the side before with it alone.

    None in the place of a side where a change cannot be tried.
    """
    found = input_changes(before.inputs, after.inputs)
    few = sum(one.inputs is not None for one in found) <= MOST_CHANGES
    for one in found:
        alone = None if one.inputs is None or not few else one.inputs
        yield one.change, None if alone is None else replace(before, inputs=alone)
    asked, new = before.budget.settings, asdict(after.budget.settings)
    for name, old in asdict(asked).items():
        if old != new[name]:
            change = Change(
                where="settings", key=name, before=_word(old), after=_word(new[name])
            )
            yield change, before.asking(replace(asked, **{name: new[name]}))


def _note(causes: Mapping[Key, list[Cause]], place: int, found: Sequence[Move]) -> bool:
    """Note what moved with one change as its doing; say whether anything did."""
    for move in found:
        if move.key in causes and move.difference is not None:
            causes[move.key].append(Cause(change=place, amount=move.difference))
    return bool(found)


def _together(
    causes: Mapping[Key, Sequence[Cause]], law: Snapshot | None, both: Snapshot | None
) -> dict[Key, float]:
    """Return what all changes do at once beyond the sum of their parts, by the law."""
    if law is None or both is None:
        return {}
    old, new = law.by_key(), both.by_key()
    found: dict[Key, float] = {}
    for key, own in causes.items():
        if key not in old or key not in new or old[key].unit != new[key].unit:
            continue
        one, other = old[key], new[key]
        parts = sum(cause.amount for cause in own)
        rest = finite(other.value - one.value - parts)
        rounding = max(
            EXACT * max(abs(one.value), abs(other.value), abs(parts)),
            *(one.floor, other.floor),
        )
        if rest is not None and abs(rest) > rounding:
            found[key] = rest
    return found


def _word(value: object) -> str:
    """Write a setting."""
    if isinstance(value, tuple):
        return ", ".join(map(str, value))
    return "" if value is None else str(value)


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
