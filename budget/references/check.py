"""Hold a reference against its files as they are now; hold two budgets together.

What moved is attributed: to the tool, by computing what is stored again with it, and to
the inputs, by exchanging them one key at a time.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING

from budget.errors import BudgetError, CallError
from budget.references.difference import (
    EXACT,
    TOOL,
    Cause,
    Change,
    Difference,
    compared,
    find_moves,
    finite,
    tolerance_of,
)
from budget.references.exchange import input_changes
from budget.references.files import present_documents, stored_documents
from budget.references.jobs import by_law, check_asked, compute
from budget.references.records import QuantityValue, ReferenceBudget
from budget.references.store import present_versions

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from budget.references.difference import Move
    from budget.references.records import Asked, Item, Job, Snapshot, StoredInput
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
    effects: list[_Effect] = []
    for change, side in _exchanges(before, after):
        alone = side.law() if law is not None and side is not None else None
        if law is None or alone is None:
            effects.append(_Effect(change=change))
        else:
            effects.append(_Effect.of(change, find_moves(law, alone)))
    together = _together(moves, effects, law, after.law())
    effects += _effects_of_tool(before, after, law)
    told = (
        replace(
            move,
            causes=tuple(
                Cause(change=effect.change, amount=effect.amounts[move.item])
                for effect in effects
                if move.item in effect.amounts
            ),
            together=together.get(move.item),
        )
        for move in moves
    )
    changes = [effect.change for effect in effects]
    # What acts comes first, so that a reader meets the numbers that moves refer to;
    # what by design never does comes last.
    changes.sort(key=lambda one: (one.acts is False, one.is_text))
    return tuple(changes), tuple(told)


@dataclass(frozen=True, kw_only=True)
class _Effect:
    """One change, and by how much it alone moves each number [its unit]."""

    change: Change
    amounts: Mapping[Item, float] = field(default_factory=dict)

    @classmethod
    def of(cls, change: Change, moves: Sequence[Move]) -> _Effect:
        """Return that of a change with which these numbers and words moved."""
        return cls(
            change=replace(change, acts=bool(moves)),
            amounts={
                move.item: move.difference
                for move in moves
                if move.difference is not None
            },
        )


def _effects_of_tool(
    before: Side, after: Side, law: Snapshot | None
) -> Iterator[_Effect]:
    """Yield what the tool as it is does to the side before.

    Versions cannot be exchanged: what they moved, they moved together.
    """
    versions = _version_changes(before.budget.versions, after.budget.versions)
    asked = before.budget.settings
    again = law if asked == by_law(asked) else before.again()
    moves = () if again is None else find_moves(before.budget, again)
    if moves and not versions:
        versions = (
            Change(where=TOOL, key="code", before="as stored", after="as it is"),
        )
    for place, one in enumerate(versions):
        effect = _Effect.of(one, moves if place == 0 else ())
        acts = None if moves or again is None else False
        yield replace(effect, change=replace(one, acts=acts))


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


def _together(
    moves: Sequence[Move],
    effects: Sequence[_Effect],
    law: Snapshot | None,
    both: Snapshot | None,
) -> dict[Item, float]:
    """Return what all changes do at once beyond the sum of their parts, by the law."""
    if law is None or both is None:
        return {}
    pairs = compared(law, both)
    found: dict[Item, float] = {}
    for item in (move.item for move in moves):
        one, other = pairs.get(item, (None, None))
        if not isinstance(one, QuantityValue) or not isinstance(other, QuantityValue):
            continue
        parts = sum(effect.amounts.get(item, 0.0) for effect in effects)
        rest = finite(other.value - one.value - parts)
        rounding = max(tolerance_of(one, other), EXACT * abs(parts))
        if one.unit == other.unit and rest is not None and abs(rest) > rounding:
            found[item] = rest
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
        compared=len(compared(before, after)),
        sampled=sum(number.is_sampled for number in before.numbers),
        moves=moves,
        changes=changes,
    )
