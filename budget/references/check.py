"""Hold a reference against its files as they are now; hold two budgets together.

What moved is attributed: to the tool, by computing what is stored again with it, and to
the inputs, by exchanging them one key at a time.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

from budget.errors import BudgetError, CallError
from budget.language import term
from budget.references.difference import (
    EXACT,
    TOOL,
    Alteration,
    Cause,
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
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from budget.inputs.tree import YamlFile
    from budget.references.difference import Move
    from budget.references.records import Item, Job, Snapshot, Stored, StoredInput

MOST_CHANGES = 200  # keys that are exchanged one by one; more is another file
# What takes the place of causes where the stored inputs cannot be read.
_UNREADABLE = Alteration(
    where=TOOL,
    key=term("stored inputs"),
    before=term("read when stored"),
    after=term("not read by this version"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class ReadBudget:
    """One of two budgets, with its inputs read."""

    name: str
    inputs: tuple[YamlFile, ...]
    budget: ReferenceBudget
    is_fresh: bool = False  # just computed of these inputs, not stored some time ago

    def again(
        self, asked: Stored | None = None, inputs: tuple[YamlFile, ...] | None = None
    ) -> Snapshot | None:
        """Compute it with other settings or inputs; None where these are not sound."""
        own = self.budget.settings
        if self.is_fresh and inputs is None and asked in {None, own}:
            return self.budget
        try:
            return compute(self.budget.job, inputs or self.inputs, asked or own)
        except BudgetError:
            return None


def make_reference(
    job: Job, inputs: Sequence[StoredInput], asked: Stored, *, workers: int = 1
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


def side_of(
    budget: ReferenceBudget, *, name: str, is_fresh: bool = False
) -> ReadBudget:
    """Return a reference, or what was just computed, as one side of a difference.

    Raises
    ------
    SpecError
        A stored input cannot be read.
    """
    inputs = stored_documents(budget.inputs, reference=name, job=budget.job)
    return ReadBudget(name=name, inputs=inputs, budget=budget, is_fresh=is_fresh)


def check(
    reference: ReferenceBudget,
    folder: Path,
    *,
    name: str,
    workers: int = 1,
    root: Path | None = None,
) -> Difference:
    """Compute a reference again from its files as they are now, and compare.

    What is stored explains what moved, and is never computed with to find it. `folder`
    is where the reference stands; its files must be in `root` (see `files.tree_of`).

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
    moves = find_moves(reference, now)
    versions = _changes(TOOL, reference.versions, now.versions)
    try:
        then = side_of(reference, name=name)
    except BudgetError:  # stored inputs only explain: they stop no check
        changes = (_UNREADABLE, *versions)
    else:
        if moves:
            side = ReadBudget(name=name, inputs=inputs, budget=now, is_fresh=True)
            changes, moves = explain(then, side, moves)
        else:
            files = (one.change for one in input_changes(then.inputs, inputs))
            changes = (*(replace(one, acts=False) for one in files), *versions)
    return Difference(
        first=name,
        second=name,
        before=reference,
        after=now,
        moves=moves,
        changes=changes,
    )


def compare_sides(first: ReadBudget, second: ReadBudget) -> Difference:
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
    return Difference(
        first=first.name,
        second=second.name,
        before=a,
        after=b,
        moves=tuple(sorted(moves, key=lambda move: -settle(move.size))),
        changes=changes,
    )


def explain(
    before: ReadBudget, after: ReadBudget, moves: Sequence[Move]
) -> tuple[tuple[Alteration, ...], tuple[Move, ...]]:
    """Say what differs between two sides, and what each change did to each number.

    The side before is computed again with the tool as it is: what that moves is the
    tool's doing. Then its keys are exchanged one at a time for those after, and every
    result by the law is held against the one without. What all of them do at once, by
    the law too, beyond the sum of that is their doing together.

    Changes that act on a number come first; moves are the same with their causes.
    """
    asked = before.budget.settings
    law = before.again(by_law(asked))
    effects = [_effect(change, law, alone) for change, alone in _tried(before, after)]
    both = after.again(by_law(after.budget.settings))
    together = _together(moves, effects, law, both)
    again = law if asked == by_law(asked) else before.again()
    effects += _effects_of_tool(before.budget, after.budget, again)
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

    change: Alteration
    amounts: Mapping[Item, float]


def _effect(
    change: Alteration, before: Snapshot | None, alone: Snapshot | None
) -> _Effect:
    """Return what a change alone does; where it cannot be tried, that is not known."""
    if before is None or alone is None:
        return _Effect(change=change, amounts={})
    moves = find_moves(before, alone)
    return _Effect(
        change=replace(change, acts=bool(moves)),
        amounts={
            move.item: move.difference for move in moves if move.difference is not None
        },
    )


def _effects_of_tool(
    before: ReferenceBudget, after: ReferenceBudget, again: Snapshot | None
) -> Iterator[_Effect]:
    """Yield what the tool as it is does to what is stored.

    Versions cannot be exchanged: what they moved, they moved together.
    """
    versions = _changes(TOOL, before.versions, after.versions)
    code = Alteration(
        where=TOOL,
        key=term("code"),
        before=term("as stored"),
        after=term("as it is"),
    )
    tool = _effect(code, before, again)
    if tool.change.acts and not versions:
        versions = (code,)
    for place, one in enumerate(versions):
        acts = False if tool.change.acts is False else None
        amounts = tool.amounts if place == 0 else {}
        yield _Effect(change=replace(one, acts=acts), amounts=amounts)


def _tried(
    before: ReadBudget, after: ReadBudget
) -> Iterator[tuple[Alteration, Snapshot | None]]:
    """Yield every difference of files and settings, and what it alone makes by the law.

    None where it cannot be tried.
    """
    asked, new = before.budget.settings, after.budget.settings
    found = input_changes(before.inputs, after.inputs)
    few = sum(one.inputs is not None for one in found) <= MOST_CHANGES
    for one in found:
        can = few and one.inputs is not None
        yield one.change, before.again(by_law(asked), one.inputs) if can else None
    for change in _changes("settings", _words(asked), _words(new)):
        alone = replace(asked, **{change.key: getattr(new, change.key)})
        yield change, before.again(by_law(alone))


def _changes(
    where: str, before: Mapping[str, str], after: Mapping[str, str]
) -> tuple[Alteration, ...]:
    """Return what differs between versions, or settings."""
    return tuple(
        Alteration(
            where=where, key=key, before=before.get(key, ""), after=after.get(key, "")
        )
        for key in dict.fromkeys((*after, *before))
        if before.get(key) != after.get(key)
    )


def _words(asked: Stored) -> dict[str, str]:
    """Write settings."""
    return {
        name: ", ".join(value)
        if isinstance(value, tuple)
        else ""
        if value is None
        else str(value)
        for name, value in asdict(asked).items()
    }


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
