"""Numbers that are known in part: their ends, their order, how they are printed."""

from __future__ import annotations

import copy
from math import inf

import pytest

from budget.known import Known
from budget.names import Name

NOISE = Name("noise", owner="gyro")
BIAS = Name("bias_repeatability", owner="gyro")


@pytest.mark.parametrize(
    ("number", "printed"),
    [
        (Known(0.42), "0.42"),
        (Known.at_least(0.42), "≥ 0.42"),
        (Known(0.42, low=-inf), "≤ 0.42"),
        (Known.of(0.42, ()), "0.42"),
        (Known.of(0.42, (NOISE,)), "≥ 0.42"),
        (Known.of(0.42, (NOISE,)).falling, "≤ 0.42"),
        (Known.of(0.42, (NOISE,), is_felt=False), "?"),
        (Known.of(0.42, (NOISE,)) / 2.0, "≥ 0.42"),
    ],
)
def test_a_number_is_printed_as_it_is_known(number, printed):
    """Ends that are infinite make it a bound, both of them nothing."""
    assert number.written("0.42") == printed
    assert number.is_bound == (printed != "0.42")
    assert number.is_unknown == (printed == "?")


@pytest.mark.parametrize("is_felt", [True, False])
def test_other_sizes_are_known_as_the_first(is_felt):
    """What would widen u would widen what is made of it, by the same lines."""
    u = Known.of(1.0, (NOISE,), is_felt=is_felt)
    other = u.like(3.0)

    assert other == 3.0
    assert (other.is_bound, other.is_unknown) == (u.is_bound, u.is_unknown)
    assert other.why == u.why
    assert not Known(1.0).like(3.0).is_bound


def test_the_largest_is_known_no_better_than_any():
    """A bound that is smaller may be larger; lines of all stand once."""
    found = Known.largest(
        [Known(2.0), Known.of(1.0, (NOISE, BIAS)), Known.of(1.5, (BIAS,))]
    )

    assert found == 2.0
    assert found.is_bound
    assert found.why == (NOISE, BIAS)
    assert not Known.largest([Known(2.0), Known(1.0)]).is_bound


def test_of_equal_digits_a_bound_ranks_after_a_full_value():
    """What is hidden is no better, and three digits decide what is equal."""
    full, bound = Known(0.41231), Known.at_least(0.41229)

    assert sorted([bound, full], key=lambda one: one.order) == [full, bound]
    assert Known.at_least(0.40).order < full.order


def test_it_goes_to_another_process_as_it_is():
    """With its ends and its lines."""
    one = Known.of(0.42, (NOISE,))
    back = copy.copy(one)  # by what it is pickled with

    assert (back, back.low, back.high, back.why) == (one, 0.42, inf, (NOISE,))
