"""Differences of two budgets: beyond rounding, and beyond what two seeds may give."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isinf, sqrt
from typing import TYPE_CHECKING, TypeVar

from budget.references.records import (
    EXACT,
    Key,
    Move,
    Number,
    Snapshot,
    Word,
    finite,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# Probability that the numbers of one reference differ between two seeds by so much
# that one of them counts as moved, at the most.
FALSE_ALARM = 1e-4

SPREAD = "standard_uncertainty"
NOT_GIVEN = "not_given"

One = TypeVar("One", Number, Word)


def find_moves(
    before: Snapshot, after: Snapshot, *, false_alarm: float = FALSE_ALARM
) -> tuple[Move, ...]:
    """Compare two results number by number and word by word.

    A number that no trial touches has moved beyond a relative difference of 1e-9 and
    its floor. A sampled one has moved where a difference that large has a probability
    below `false_alarm` over the number of sampled numbers (Bonferroni): by Student's t
    on the standard errors of both, or, for a proportion, exactly on the counts.

    Parameters
    ----------
    before, after : Snapshot
        Results of the same job.
    false_alarm : float
        Probability of any move where nothing but the seed has changed [1].

    Returns
    -------
    tuple of Move
        In the order of the results; what is gone or new counts as moved.
    """
    old, new = before.by_key(), after.by_key()
    number = sum(
        old[key].is_sampled or new[key].is_sampled for key in old.keys() & new.keys()
    )
    level = false_alarm / max(number, 1)
    moves = [
        move
        for one, other in _pairs(before.numbers, after.numbers, before)
        if (move := _number_move(one, other, level, old, new))
    ]
    moved = {move.key for move in moves}
    moves += [
        move
        for word, later in _pairs(before.words, after.words, before)
        if (move := _word_move(word, later, before, moved))
    ]
    return tuple(moves)


def count_compared(before: Snapshot, after: Snapshot) -> int:
    """Return how many numbers and words `find_moves` compares, of either side."""
    return len(_pairs(before.numbers, after.numbers, before)) + len(
        _pairs(before.words, after.words, before)
    )


def probability_of(before: Number, after: Number) -> float:
    """Return how probable a difference as large is between two seeds, two-sided [1].

    1 for numbers that trials do not touch.
    """
    if not (before.is_sampled or after.is_sampled):
        return 1.0
    if before.trials is not None and after.trials is not None:
        return _of_counts(before, after)
    spread = _spread(before, after)
    difference = abs(after.value - before.value)
    if spread == 0.0 or isinf(difference):
        return 1.0 if difference == 0.0 else 0.0
    if isinf(spread):
        return 1.0
    return _two_sided(difference / spread, _freedom(before, after))


def _pairs(
    before: Sequence[One], after: Sequence[One], stored: Snapshot
) -> list[tuple[One | None, One | None]]:
    """Return what is compared, as it is on both sides.

    What a later version computes beside what was `stored` is not compared.
    """
    old: dict[Key, One] = {one.key: one for one in before}
    new: dict[Key, One] = {one.key: one for one in after}
    quantities = {key.quantity for key in old}
    return [
        (old.get(key), new.get(key))
        for key in dict.fromkeys((*old, *new))
        if key in old or (key.quantity in quantities and stored.knows(key))
    ]


def _number_move(
    before: Number | None,
    after: Number | None,
    level: float,
    old: Mapping[Key, Number],
    new: Mapping[Key, Number],
) -> Move | None:
    """Return the move of one number, None where it stays."""
    one = before or after
    if one is None:
        return None
    move = Move(
        key=one.key,
        unit=(after or one).unit,
        before=None if before is None else before.value,
        after=None if after is None else after.value,
        scale=_scale(one, old, new),
        bounds=(
            before is not None and before.lower_bound,
            after is not None and after.lower_bound,
        ),
    )
    if before is None or after is None:
        return move
    difference = abs(after.value - before.value)
    tolerance = max(
        EXACT * max(abs(before.value), abs(after.value)), before.floor, after.floor
    )
    sampled = before.is_sampled or after.is_sampled
    same_unit = before.unit == after.unit
    if same_unit and difference <= tolerance:
        return None
    if same_unit and sampled and probability_of(before, after) >= level:
        return None
    spread = _spread(before, after) if sampled else tolerance
    times = finite(difference / spread) if spread > 0.0 else None
    return replace(move, is_sampled=sampled, times=times)


def _word_move(
    before: Word | None, after: Word | None, stored: Snapshot, moved: set[Key]
) -> Move | None:
    """Return the move of one word, None where it stays.

    Where a number that has not moved decides it, it fell the other way by chance.
    """
    one = before or after
    if one is None:
        return None
    if before is not None and after is not None:
        text = after.text
        if one.quantity == NOT_GIVEN:
            text = stored.known_part(text)
        decided = Key(subject=one.subject, quantity=before.rests_on)
        if text == before.text or (before.rests_on and decided not in moved):
            return None
        after = replace(after, text=text)
    return Move(
        key=one.key,
        unit="",
        before=None if before is None else before.text,
        after=None if after is None else after.text,
    )


def _scale(
    one: Number, old: Mapping[Key, Number], new: Mapping[Key, Number]
) -> float | None:
    """Return what the size of a difference is measured by [unit of the number]."""
    spread = Key(subject=one.key.subject, quantity=SPREAD)
    for key in (spread, one.key):
        own = [numbers[key] for numbers in (old, new) if key in numbers]
        if own and own[0].unit == one.unit and own[0].value != 0.0:
            return abs(own[0].value)
    return None


def _spread(before: Number, after: Number) -> float:
    """Return the standard error of a difference [unit of the number]."""
    counted = [one for one in (before, after) if one.trials is not None]
    trials = sum(one.trials or 0 for one in counted)
    p = sum(one.value * (one.trials or 0) for one in counted) / max(trials, 1)
    variance = 0.0
    for one in (before, after):
        if one.trials is not None:
            variance += max(p * (1.0 - p), 0.0) / one.trials
        elif one.standard_error is not None:
            variance += one.standard_error * one.standard_error
    return sqrt(variance)


def _freedom(before: Number, after: Number) -> float:
    """Return the degrees of freedom of a difference (Welch and Satterthwaite)."""
    # As parts of the larger one: a file may hold errors whose squares overflow.
    errors = [(one, one.standard_error or 0.0) for one in (before, after)]
    largest = max(error for _, error in errors)
    total = parts = 0.0
    for one, error in errors:
        variance = (error / largest) ** 2 if largest > 0.0 else 0.0
        total += variance
        parts += variance**2 / (one.degrees_of_freedom or inf)
    return total**2 / parts if parts > 0.0 else inf


def _two_sided(t: float, freedom: float) -> float:
    """Return the probability beyond +-t of Student's law, of the normal at infinity."""
    from scipy.special import ndtr, stdtr

    tail = ndtr(-t) if freedom == inf else stdtr(freedom, -t)
    return min(2.0 * float(tail), 1.0)


def _of_counts(before: Number, after: Number) -> float:
    """Return how probable two counts as different are, given their sum (Fisher)."""
    from scipy.stats import hypergeom

    n, m = before.trials or 0, after.trials or 0
    first, second = round(before.value * n), round(after.value * m)
    # Counted from the rarer side: the law is the same, the numbers are small.
    if first + second > (n + m) / 2:
        first, second = n - first, m - second
    law = hypergeom(n + m, first + second, n)
    tail = min(float(law.cdf(first)), float(law.sf(first - 1)))
    return min(2.0 * tail, 1.0)
