"""Why numbers moved: the tool, or the inputs, exchanged one key at a time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from budget.errors import BudgetError
from budget.studies.reference.exchange import (
    differences,
    exchange,
    is_text,
    show_change,
)
from budget.studies.reference.jobs import by_law, compute
from budget.studies.reference.moves import find_moves
from budget.studies.reference.records import EXACT, TOOL, Cause, Change, Move, finite

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.studies.reference.exchange import KeyChange
    from budget.studies.reference.records import Asked, Key, Part, Snapshot

MOST_CHANGES = 200  # keys that are exchanged one by one; more is another file


@dataclass(frozen=True, kw_only=True, eq=False)
class Side:
    """One of two budgets: how it was made, and what came out."""

    parts: tuple[Part, ...]
    asked: Asked
    snapshot: Snapshot
    versions: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """Everything that differs between two sides, and the moves with their causes."""

    changes: tuple[Change, ...]
    moves: tuple[Move, ...]


@dataclass(frozen=True, kw_only=True)
class _Key:
    """A key of one part that differs."""

    part: int  # place among the parts before
    role: str
    where: str
    change: KeyChange


def input_changes(before: Sequence[Part], after: Sequence[Part]) -> tuple[Change, ...]:
    """Return what differs between the files, where no number moved."""
    pairs = _pairs(before, after)
    return tuple(
        replace(change, acts=False)
        for change in (
            *_lone_parts(before, after, pairs),
            *(_as_change(key) for key in _keys(before, after, pairs)),
        )
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


def explain(job: str, before: Side, after: Side, moves: Sequence[Move]) -> Explanation:
    """Say what each change did to each number that moved.

    The side before is computed again with the tool as it is: what that moves is the
    tool's doing. Then its keys are exchanged one at a time for those after, and every
    result by the law is held against the one without. What all of them do at once, by
    the law too, beyond the sum of that is their doing together.

    Parameters
    ----------
    job : str
        Of both sides.
    before, after : Side
        With the parts as they were and as they are.
    moves : sequence of Move
        From the one to the other.

    Returns
    -------
    Explanation
        Changes that act on a number first; among them of files, settings, versions.
    """
    pairs = _pairs(before.parts, after.parts)
    lone = _lone_parts(before.parts, after.parts, pairs)
    keys = _keys(before.parts, after.parts, pairs)
    settings = _setting_changes(before.asked, after.asked)
    versions = version_changes(before.versions, after.versions)
    changes = [*lone, *(_as_change(key) for key in keys)]
    causes: dict[Key, list[Cause]] = {move.key: [] for move in moves}

    law = _try(job, before.parts, by_law(before.asked))
    if law is not None and len(keys) <= MOST_CHANGES:
        for place, key in enumerate(keys, start=len(lone)):
            parts = list(before.parts)
            part = parts[key.part]
            parts[key.part] = replace(
                part, document=exchange(part.document, key.change)
            )
            alone = _try(job, parts, by_law(before.asked))
            changes[place] = replace(
                changes[place], acts=_add(causes, place, law, alone)
            )
    changes.extend(settings)
    for place, change in enumerate(settings, start=len(lone) + len(keys)):
        asked = replace(before.asked, **{change.key: getattr(after.asked, change.key)})
        alone = _try(job, before.parts, by_law(asked))
        changes[place] = replace(change, acts=_add(causes, place, law, alone))
    together = _together(
        causes, law, _try(job, after.parts, by_law(after.asked)), moves
    )
    changes.extend(versions)
    again = _try(job, before.parts, before.asked)
    if again is not None:
        tool = find_moves(before.snapshot, again)
        acts = bool(tool)
        first = len(lone) + len(keys) + len(settings)
        if acts and not versions:
            changes.append(
                Change(where=TOOL, key="code", before="as stored", after="as it is")
            )
        for place in range(first, len(changes)):
            # Versions cannot be exchanged: what they moved, they moved together.
            changes[place] = replace(changes[place], acts=None if acts else False)
        _note(causes, first, tool)
    # What acts comes first, so that a reader meets the numbers that moves refer to;
    # what by design never does comes last.
    order = sorted(
        range(len(changes)),
        key=lambda k: (changes[k].acts is False, changes[k].is_text),
    )
    place_of = {old: new for new, old in enumerate(order)}
    return Explanation(
        changes=tuple(changes[k] for k in order),
        moves=tuple(
            replace(
                move,
                causes=tuple(
                    replace(cause, change=place_of[cause.change])
                    for cause in causes[move.key]
                ),
                together=together.get(move.key),
            )
            for move in moves
        ),
    )


def _add(
    causes: dict[Key, list[Cause]],
    place: int,
    law: Snapshot | None,
    alone: Snapshot | None,
) -> bool | None:
    """Note what one change does to each number; say whether it does anything."""
    if law is None or alone is None:
        return None
    found = find_moves(law, alone)
    _note(causes, place, found)
    return bool(found)


def _note(causes: dict[Key, list[Cause]], place: int, found: Sequence[Move]) -> None:
    """Note what moved with one change as its doing."""
    for move in found:
        if move.key in causes and move.difference is not None:
            causes[move.key].append(Cause(change=place, amount=move.difference))


def _together(
    causes: Mapping[Key, Sequence[Cause]],
    law: Snapshot | None,
    both: Snapshot | None,
    moves: Sequence[Move],
) -> dict[Key, float]:
    """Return what all changes do at once beyond the sum of their parts, by the law."""
    if law is None or both is None:
        return {}
    old, new = law.by_key(), both.by_key()
    found: dict[Key, float] = {}
    for key in (move.key for move in moves):
        if key not in old or key not in new or old[key].unit != new[key].unit:
            continue
        one, other = old[key], new[key]
        parts = sum(cause.amount for cause in causes[key])
        rest = finite(other.value - one.value - parts)
        rounding = max(
            EXACT * max(abs(one.value), abs(other.value), abs(parts)),
            *(one.floor, other.floor),
        )
        if rest is not None and abs(rest) > rounding:
            found[key] = rest
    return found


def _try(job: str, parts: Sequence[Part], asked: Asked) -> Snapshot | None:
    """Compute, or return None where one key alone makes no sound file."""
    try:
        return compute(job, parts, asked)
    except BudgetError:
        return None


def _pairs(before: Sequence[Part], after: Sequence[Part]) -> list[tuple[int, int]]:
    """Return which part is which: by role and name, a lone one of a role by role."""
    pairs: list[tuple[int, int]] = []
    free = list(range(len(after)))
    for same_name in (True, False):
        for old, part in enumerate(before):
            if any(old == one for one, _ in pairs):
                continue
            fits = [
                new
                for new in free
                if after[new].role == part.role
                and (after[new].name == part.name or not same_name)
            ]
            # Of several devices without a name in common none is the other's successor.
            if fits and (same_name or _is_lone(part, before, after)):
                pairs.append((old, fits[0]))
                free.remove(fits[0])
    return sorted(pairs)


def _is_lone(part: Part, before: Sequence[Part], after: Sequence[Part]) -> bool:
    """Whether a role has one part on each side."""
    return all(
        sum(one.role == part.role for one in side) == 1 for side in (before, after)
    )


def _lone_parts(
    before: Sequence[Part], after: Sequence[Part], pairs: Sequence[tuple[int, int]]
) -> list[Change]:
    """Return the parts that the other side has not."""
    gone = [p for k, p in enumerate(before) if all(k != old for old, _ in pairs)]
    new = [p for k, p in enumerate(after) if all(k != one for _, one in pairs)]
    return [
        *(Change(where=p.role, key=p.name, before="there", after="") for p in gone),
        *(Change(where=p.role, key=p.name, before="", after="there") for p in new),
    ]


def _keys(
    before: Sequence[Part], after: Sequence[Part], pairs: Sequence[tuple[int, int]]
) -> list[_Key]:
    """Return every key that differs between parts that are the same."""
    return [
        _Key(
            part=old,
            role=before[old].role,
            where=f"{before[old].role} {before[old].name}"
            if before[old].name == after[new].name
            else before[old].role,
            change=change,
        )
        for old, new in pairs
        for change in differences(before[old].document, after[new].document)
    ]


def _as_change(key: _Key) -> Change:
    """Say a change of a key."""
    before, after = show_change(key.change)
    return Change(
        where=key.where,
        key=key.change.path,
        before=before,
        after=after,
        is_text=is_text(key.role, key.change.steps),
    )


def _setting_changes(before: Asked, after: Asked) -> list[Change]:
    """Return the settings that differ."""
    found = []
    for name in before.__dataclass_fields__:
        old, new = getattr(before, name), getattr(after, name)
        if old != new:
            found.append(
                Change(where="settings", key=name, before=_word(old), after=_word(new))
            )
    return found


def _word(value: object) -> str:
    """Write a setting."""
    if isinstance(value, tuple):
        return ", ".join(map(str, value))
    return "" if value is None else str(value)
