"""Why numbers moved: the tool, or the inputs, exchanged one key at a time."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

from budget.errors import BudgetError
from budget.references.difference import find_moves
from budget.references.exchange import (
    differences,
    exchange,
    is_text,
    show_change,
)
from budget.references.jobs import by_law, compute
from budget.references.records import EXACT, TOOL, Cause, Change, Move, finite

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.references.records import Asked, Key, ReferenceBudget, Snapshot
    from budget.spec.tree import Document

MOST_CHANGES = 200  # keys that are exchanged one by one; more is another file


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


@dataclass(frozen=True, kw_only=True)
class _Exchanged:
    """A change, and the side before with it alone; None where it cannot be tried."""

    change: Change
    side: Side | None = None


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
    for one in _exchanges(before, after):
        alone = one.side.law() if law is not None and one.side is not None else None
        acts = None
        if law is not None and alone is not None:
            acts = _note(causes, len(changes), find_moves(law, alone))
        changes.append(replace(one.change, acts=acts))
    together = _together(causes, law, after.law())
    versions = list(version_changes(before.budget.versions, after.budget.versions))
    again = before.again()
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


def input_changes(
    before: Sequence[Document], after: Sequence[Document]
) -> tuple[Change, ...]:
    """Return what differs between the files, where no number moved."""
    return tuple(
        replace(change, acts=False) for change, _ in _input_changes(before, after)
    )


def version_changes(
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


def _exchanges(before: Side, after: Side) -> Iterator[_Exchanged]:
    """Yield every difference of files and settings, each with the side to try it on."""
    found = _input_changes(before.inputs, after.inputs)
    few = sum(inputs is not None for _, inputs in found) <= MOST_CHANGES
    for change, inputs in found:
        side = None if inputs is None or not few else replace(before, inputs=inputs)
        yield _Exchanged(change=change, side=side)
    asked = before.budget.settings
    new = asdict(after.budget.settings)
    for name, old in asdict(asked).items():
        if old != new[name]:
            change = Change(
                where="settings", key=name, before=_word(old), after=_word(new[name])
            )
            side = before.asking(replace(asked, **{name: new[name]}))
            yield _Exchanged(change=change, side=side)


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


def _input_changes(
    before: Sequence[Document], after: Sequence[Document]
) -> list[tuple[Change, tuple[Document, ...] | None]]:
    """Return what differs between files, with the inputs before that have it alone.

    Files that the other side has not come first, and cannot be tried.
    """
    pairs = _pairs(before, after)
    gone = [p for k, p in enumerate(before) if all(k != old for old, _ in pairs)]
    new = [p for k, p in enumerate(after) if all(k != one for _, one in pairs)]
    found: list[tuple[Change, tuple[Document, ...] | None]] = [
        *(
            (Change(where=p.kind, key=p.base_name, before="there", after=""), None)
            for p in gone
        ),
        *(
            (Change(where=p.kind, key=p.base_name, before="", after="there"), None)
            for p in new
        ),
    ]
    for old, place in pairs:
        own, other = before[old], after[place]
        for key in differences(own, other):
            was, now = show_change(key)
            change = Change(
                where=f"{own.kind} {own.base_name}"
                if own.base_name == other.base_name
                else own.kind,
                key=key.path,
                before=was,
                after=now,
                is_text=is_text(own.kind, key.steps),
            )
            alone = exchange(own, key)
            found.append((change, (*before[:old], alone, *before[old + 1 :])))
    return found


def _pairs(
    before: Sequence[Document], after: Sequence[Document]
) -> list[tuple[int, int]]:
    """Return which file is which: by role and name, a lone one of a role by role."""
    pairs: list[tuple[int, int]] = []
    free = list(range(len(after)))
    for same_name in (True, False):
        for old, own in enumerate(before):
            if any(old == one for one, _ in pairs):
                continue
            fits = [
                new
                for new in free
                if after[new].kind == own.kind
                and (after[new].base_name == own.base_name or not same_name)
            ]
            # Of several devices without a name in common none is the other's successor.
            if fits and (same_name or _is_lone(own, before, after)):
                pairs.append((old, fits[0]))
                free.remove(fits[0])
    return sorted(pairs)


def _is_lone(
    own: Document, before: Sequence[Document], after: Sequence[Document]
) -> bool:
    """Whether a role has one file on each side."""
    return all(
        sum(one.kind == own.kind for one in side) == 1 for side in (before, after)
    )


def _word(value: object) -> str:
    """Write a setting."""
    if isinstance(value, tuple):
        return ", ".join(map(str, value))
    return "" if value is None else str(value)
