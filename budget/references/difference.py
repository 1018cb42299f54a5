"""Differences of two budgets: what changed, what moved beyond its tolerance, and why.

The tolerance of a number follows from what it is. By the law it is 1e-9 of the number,
or the rounding of its computation; by trials, what two seeds may give.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, inf, isfinite, isinf, sqrt
from typing import TYPE_CHECKING

from budget.documents import written
from budget.language import term
from budget.references.records import Item, NominalProperty, QuantityValue

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.references.records import ReferenceBudget, Snapshot

# Relative difference at which a number that no trial touches has moved [1].
EXACT = 1e-9
# Probability that the numbers of one reference differ between two seeds by so much
# that one of them counts as moved, at the most.
FALSE_ALARM = 1e-4
TOOL = term("tool")  # where a change is that no file made

SPREAD = "standard_uncertainty"
NOT_GIVEN = "not_given"

Stated = QuantityValue | NominalProperty
Pair = tuple[Stated | None, Stated | None]  # of one item, before and after


@written(
    "change",
    """
    where: 'device imu.yaml', 'tool', ...
    key: of a file or setting, or of what the tool stands on
    before: as the file spells it; '' where it was not there
    after: likewise
    acts: whether it alone moves any number; null where it cannot be tried alone
    is_text: whether by design it moves no number
    """,
)
@dataclass(frozen=True, kw_only=True)
class Alteration:
    """One thing that is not what it was: a key of a file, a file, a version."""

    where: str  # 'device imu.yaml', or 'tool'
    key: str  # 'gyro.errors.bias_stability', or 'numpy'
    before: str  # as the file spells it; '' where it was not there
    after: str
    acts: bool | None = None  # on any number, alone; None: it cannot be tried alone
    is_text: bool = False  # a key that by design moves no number

    def __str__(self) -> str:
        """Say it in one line."""
        return (
            f"{self.where}: {self.key}: {self.before or '(not there)'} -> "
            f"{self.after or '(not there)'}"
        )


@written(
    "cause",
    """
    change (str): in one line
    amount [unit]: how much of the move it explains, by the law
    """,
    said="One thing that is not what it was: a key of a file, a file, a version.",
)
@dataclass(frozen=True, kw_only=True)
class Cause:
    """How much of a move one change explains."""

    change: Alteration
    amount: float  # [unit of the number], by the law


@dataclass(frozen=True, kw_only=True)
class Move:
    """One number or word that is not what it was."""

    item: Item
    unit: str
    before: float | str | None  # a Known of a number; None where there is none
    after: float | str | None
    is_sampled: bool = False
    # Its difference over its tolerance or, of a sampled number, over the standard error
    # of a difference; None for a word and what is gone or new.
    times: float | None = None
    # What the size of a difference is measured by, as it was before: the standard
    # uncertainty of the output, of what has none the number itself [unit].
    scale: float | None = None
    causes: tuple[Cause, ...] = ()
    # What all changes do at once beyond the sum of what each does alone, by the law
    # [unit]; None where that is nothing, or not known.
    together: float | None = None

    @property
    def difference(self) -> float | None:
        """After minus before [unit]; None where one of them is no number."""
        if isinstance(self.before, float) and isinstance(self.after, float):
            return finite(self.after - self.before)
        return None

    @property
    def relative(self) -> float | None:
        """Difference over the value before [1]; None where that is 0 or no number."""
        if self.difference is None or not self.before or isinstance(self.before, str):
            return None
        return finite(self.difference / abs(self.before))

    @property
    def size(self) -> float:
        """Absolute difference over `scale`; infinite for a word, gone or new [1]."""
        if self.difference is None or not self.scale:
            return inf
        return abs(self.difference) / self.scale


@written(
    "reference",
    """
    name = first
    kind = job: 'analyze', 'mission', 'compare' or 'allocate'
    holds: whether nothing moved
    compared: how many numbers and words
    sampled: how many of the numbers trials made
    changes: of files, settings and versions
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Difference:
    """Two budgets side by side: a reference and what it is now, or any two."""

    first: str  # how it is called
    second: str
    before: ReferenceBudget
    after: ReferenceBudget
    moves: tuple[Move, ...]
    changes: tuple[Alteration, ...]

    @property
    def job(self) -> str:
        """What both are of: analyze, compare, allocate."""
        return self.before.job

    @property
    def compared(self) -> int:
        """How many numbers and words."""
        return len(compared(self.before, self.after))

    @property
    def sampled(self) -> int:
        """Of those of the first, how many numbers trials made."""
        return sum(number.is_sampled for number in self.before.numbers)

    @property
    def holds(self) -> bool:
        """Whether nothing moved."""
        return not self.moves


def find_moves(
    before: Snapshot, after: Snapshot, *, false_alarm: float = FALSE_ALARM
) -> tuple[Move, ...]:
    """Compare two results number by number and word by word.

    A number that no trial touches has moved beyond a relative difference of 1e-9 and
    its floor. A sampled one has moved where a difference that large has a probability
    below `false_alarm` over the number of sampled numbers (Bonferroni): by Student's t
    on the standard errors of both, or, for a proportion, exactly on the
    counts (Fisher).

    What is gone or new has moved. `false_alarm` is the probability of any move where
    nothing but the seed has changed [1].
    """
    pairs = compared(before, after)
    both = [(one, other) for one, other in pairs.values() if one and other]
    number = sum(one.is_sampled or other.is_sampled for one, other in both)
    level = false_alarm / max(number, 1)
    moves: dict[Item, Move] = {}
    for item, (one, other) in pairs.items():
        text = other.known if other else None
        sampled, times = False, None
        if isinstance(one, QuantityValue) and isinstance(other, QuantityValue):
            if is_within(one, other, level):
                continue
            sampled = one.is_sampled or other.is_sampled
            unit = (_standard_error if sampled else tolerance_of)(one, other)
            difference = abs(other.value - one.value)
            times = finite(difference / unit) if unit > 0.0 else None
        elif isinstance(one, NominalProperty) and isinstance(other, NominalProperty):
            if item.quantity == NOT_GIVEN:
                text = before.known_part(other.text)
            # Where a number that has not moved decides it, it fell so by chance.
            decided = Item(subject=item.subject, quantity=one.rests_on)
            if text == one.text or (one.rests_on and decided not in moves):
                continue
        moves[item] = Move(
            item=item,
            unit=_unit(pairs[item]),
            before=one.known if one else None,
            after=text,
            is_sampled=sampled,
            times=times,
            scale=_scale(item, pairs),
        )
    return tuple(moves.values())


def compared(before: Snapshot, after: Snapshot) -> dict[Item, Pair]:
    """Return what is compared, as it is on both sides, numbers first.

    What a later version states beside what was stored is not compared.
    """
    old, new = before.by_item, after.by_item
    quantities = {item.quantity for item in old}
    stated = {**old, **new}
    return {
        item: (was, new.get(item))
        for item, _ in sorted(stated.items(), key=lambda pair: not pair[1].unit)
        if (was := old.get(item))
        or (item.quantity in quantities and before.knows(item))
    }


def is_within(before: QuantityValue, after: QuantityValue, level: float) -> bool:
    """Whether a number stays: within rounding, or as seeds at that level differ."""
    if before.unit != after.unit:
        return False
    if abs(after.value - before.value) <= tolerance_of(before, after):
        return True
    is_sampled = before.is_sampled or after.is_sampled
    return is_sampled and probability_of(before, after) >= level


def tolerance_of(before: QuantityValue, after: QuantityValue) -> float:
    """Return what may differ without a trial: 1e-9 of the larger, or rounding."""
    largest = max(abs(before.value), abs(after.value))
    return max(EXACT * largest, before.floor, after.floor)


def probability_of(before: QuantityValue, after: QuantityValue) -> float:
    """Return how probable a difference as large is between two seeds, two-sided [1].

    1 for numbers that trials do not touch.
    """
    if not (before.is_sampled or after.is_sampled):
        return 1.0
    if before.trials and after.trials:
        import numpy as np
        from scipy.stats import fisher_exact

        n = np.array([before.trials, after.trials])
        # A file may hold any double in the place of a probability.
        hits = np.round(n * np.clip([before.value, after.value], 0.0, 1.0)).astype(int)
        return float(fisher_exact(np.stack([hits, n - hits])).pvalue)
    spread = _standard_error(before, after)
    difference = abs(after.value - before.value)
    if spread == 0.0 or isinf(difference):
        return 1.0 if difference == 0.0 else 0.0
    if isinf(spread):
        return 1.0
    from scipy.special import stdtr

    return min(2.0 * float(stdtr(_freedom(before, after), -difference / spread)), 1.0)


def finite(value: float) -> float | None:
    """Return a number, or None where it overflowed: a file may hold any double."""
    return value if isfinite(value) else None


def _unit(pair: Pair) -> str:
    """Return the unit of a number, as it is now; '' of a word."""
    return next(one.unit for one in reversed(pair) if one)


def _scale(item: Item, pairs: Mapping[Item, Pair]) -> float | None:
    """Return what the size of a difference is measured by [unit of the number]."""
    unit = next(one.unit for one in pairs[item] if one)
    for key in (Item(subject=item.subject, quantity=SPREAD), item):
        own = next((one for one in pairs.get(key, ()) if one), None)
        if isinstance(own, QuantityValue) and own.unit == unit and own.value != 0.0:
            return abs(own.value)
    return None


def _standard_error(before: QuantityValue, after: QuantityValue) -> float:
    """Return the standard error of a difference [unit of the number]."""
    both = (before, after)
    trials = sum(one.trials or 0 for one in both)
    p = sum(one.value * (one.trials or 0) for one in both) / max(trials, 1)
    binomial = sqrt(max(p * (1.0 - p), 0.0))
    return hypot(
        *(
            binomial / sqrt(one.trials) if one.trials else one.standard_error or 0.0
            for one in both
        )
    )


def _freedom(before: QuantityValue, after: QuantityValue) -> float:
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
