"""Ties: one rule for the largest of quantities that are equal but for rounding.

Equal axes are the rule, not the exception, and rounding tells them apart in a way that
differs between processors. So two quantities count as equal where they differ by less
than ALIKE of the larger one; of equal ones all are named, and where one has to stand
for them it is the first.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

ALIKE = 1e-6  # relative difference of quantities that count as equal [1]
DIGITS = 12  # significant ones that no processor and no order of a sum changes


def settle(value: float) -> float:
    """Return a number without the last digits, which differ between processors.

    What is rounded for people or held against a limit goes through here first, so that
    0.5 less the rounding of doubles is 0.5.
    """
    return float(f"{value:.{DIGITS - 1}e}")


def largest(values: Sequence[float]) -> tuple[int, ...]:
    """Return the places of the largest value and of all that are equal to it, in order.

    Values are not negative; () where there are none.
    """
    top = max(values, default=0.0)
    return tuple(k for k, value in enumerate(values) if _is_equal(value, top))


def smallest(values: Sequence[float]) -> tuple[int, ...]:
    """Return the places of the smallest value and of all that are equal to it."""
    return equal_to(values, values.index(min(values))) if values else ()


def equal_to(values: Sequence[float], place: int) -> tuple[int, ...]:
    """Return the place and those of all values that are equal to the one there."""
    own = values[place]
    return tuple(
        k
        for k, value in enumerate(values)
        if k == place or _is_equal(min(value, own), max(value, own))
    )


def first_largest(values: Sequence[float]) -> int:
    """Return the first place of the largest value; ValueError without values."""
    if len(values) == 0:
        raise ValueError("the largest of no values, expected one at least")
    return largest(values)[0]


def from_largest(values: Sequence[float]) -> tuple[int, ...]:
    """Return all places from the largest value down; equal ones keep their order."""
    down = sorted(range(len(values)), key=lambda k: -values[k])
    found: list[int] = []
    while down:
        top = values[down[0]]
        equal = [k for k in down if _is_equal(values[k], top)]
        found += sorted(equal)
        down = down[len(equal) :]
    return tuple(found)


def foremost(ranked: Sequence[float], number: int) -> int:
    """Return how many of values from the largest down are the first, ties with them."""
    if not ranked:
        return 0
    return equal_to(ranked, min(number, len(ranked)) - 1)[-1] + 1


def _is_equal(value: float, top: float) -> bool:
    """Whether a value is as large as the largest; 0 equals 0 only."""
    return value == top or value > top * (1.0 - ALIKE) > 0.0
