"""What counts as moved: never another seed, always another device."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import isinf, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reference_examples import DEVICE, snapshot

from budget.methods.trials import first_trials
from budget.names import Name
from budget.references import sampling
from budget.references.difference import (
    EXACT,
    FALSE_ALARM,
    compared,
    find_moves,
    probability_of,
)
from budget.references.records import (
    KNOWN_FIRST,
    NominalProperty,
    QuantityValue,
    Snapshot,
    known_now,
)
from budget.report.reference import move_table

PAIRS = 30
TRIALS = 2000


def number(value, **more):
    """Return a number of one output."""
    one = {"subject": "gyro.bias.x", "quantity": "mean", "unit": "deg/h"}
    return QuantityValue(value=value, **(one | more))


def of(*numbers, words=()):
    """Return a result that says just this."""
    return Snapshot(numbers=numbers, words=tuple(words))


@pytest.fixture(scope="module")
def seeds():
    """Provide the budget of one device by trials with many seeds.

    What standard errors are taken from is of one seed, and so drawn once.
    """
    drawn = cache(lambda trials, seed: first_trials(*problem, trials=trials, seed=seed))
    problem = []

    def draw_once(one, *, trials, seed):
        problem[:] = problem or [one]
        assert [g.covariance.tolist() for g in one.groups] == [
            g.covariance.tolist() for g in problem[0].groups
        ]
        return drawn(trials, seed)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sampling, "first_trials", draw_once)
        return [
            snapshot(method="monte-carlo", trials=TRIALS, seed=seed)
            for seed in range(2 * PAIRS)
        ]


@pytest.mark.slow
class TestSeeds:
    """Another seed is no move."""

    def test_no_pair_of_seeds_moves(self, seeds):
        """At the level of the check, 30 pairs of seeds give no move at all."""
        assert FALSE_ALARM == 1e-4
        for one, other in zip(seeds[::2], seeds[1::2], strict=True):
            assert find_moves(one, other) == ()
            assert one != other

    def test_false_alarms_are_as_rare_as_told(self, seeds):
        """At 5 % a pair, no more pairs raise an alarm than 4 standard errors allow."""
        alarms = sum(
            bool(find_moves(one, other, false_alarm=0.05))
            for one, other in zip(seeds[::2], seeds[1::2], strict=True)
        )
        assert alarms <= 0.05 * PAIRS + 4.0 * sqrt(0.05 * 0.95 * PAIRS)

    def test_probabilities_are_uniform(self, seeds):
        """Of all single numbers about 5 % differ at 5 %, and about 1 % at 1 %."""
        found = [
            probability_of(a, b)
            for one, other in zip(seeds[::2], seeds[1::2], strict=True)
            for a, b in zip(one.numbers, other.numbers, strict=True)
            if a.is_sampled and a.value != b.value
        ]
        # Numbers of one output hang together; some 30 of a pair do not.
        error = 4.0 * np.sqrt(0.05 * 0.95 / (30 * PAIRS))
        assert len(found) > 200 * PAIRS
        assert_allclose(np.mean(np.array(found) < 0.05), 0.05, rtol=0, atol=error)
        assert np.mean(np.array(found) < 0.01) < 0.02

    def test_another_device_moves(self, seeds):
        """Control: 25 % more of one line moves u of its outputs beyond two seeds."""
        worse = snapshot(
            DEVICE.replace("37 ppm", "46 ppm"),
            method="monte-carlo",
            trials=TRIALS,
            seed=1,
        )
        moved = {
            (move.item.subject, move.item.quantity)
            for move in find_moves(seeds[0], worse)
            if move.is_sampled
        }
        axes = [f"accelerometer.scale_factor.{axis}" for axis in "xyz"]
        assert {(axis, "standard_uncertainty") for axis in axes} <= moved
        assert not any(subject.startswith("gyro") for subject, _ in moved)

    def test_comparisons_hold_with_another_seed(self):
        """Utilisations, conformances, verdicts: seed 1 is no move from seed 0."""
        more = [("requirement", "navigation-grade")]
        one, other = (
            snapshot(
                job="compare",
                more=more,
                method="monte-carlo",
                trials=4096,
                max_trials=4096,
                seed=seed,
            )
            for seed in (0, 1)
        )
        assert {n.item.quantity for n in one.numbers if n.trials} == {"conformance"}
        assert one != other
        assert find_moves(one, other) == ()

    def test_indices_hold_with_another_seed(self):
        """Sobol' indices with seed 1 are no move from seed 0; fewer samples neither."""
        one, other = (snapshot(samples=n, seed=s) for n, s in ((128, 0), (64, 1)))
        indices = [n for n in one.numbers if n.item.quantity.startswith("sobol")]
        assert len(indices) > 100
        assert one != other
        assert find_moves(one, other) == ()


class TestExact:
    """Numbers that no trial touches."""

    @pytest.mark.parametrize(("factor", "moves"), [(0.5, 0), (2.0, 1)])
    def test_relative(self, factor, moves):
        """Half of 1e-9 is no move, twice of it is one."""
        one, other = number(3.0), number(3.0 * (1.0 + factor * EXACT))
        assert len(find_moves(of(one), of(other))) == moves

    def test_rounding(self):
        """A difference below the floor is rounding, however large relatively."""
        one, other = number(1e-20, floor=1e-15), number(9e-16, floor=1e-15)
        assert find_moves(of(one), of(other)) == ()
        assert find_moves(of(replace(one, floor=0.0)), of(replace(other, floor=0.0)))

    def test_what_a_move_says(self):
        """Before, after, tolerances, relative difference and size over u."""
        u = number(2.0, quantity="standard_uncertainty")
        (move,) = find_moves(of(number(1.0), u), of(number(1.1), u))
        assert (move.before, move.after, move.is_sampled) == (1.0, 1.1, False)
        assert_allclose(move.relative, 0.1, rtol=1e-12)
        assert_allclose(move.size, 0.05, rtol=1e-12)
        assert_allclose(move.times, 0.1 / 1.1e-9, rtol=1e-9)

    def test_gone_and_new(self):
        """A number that is gone or new moved; a quantity never stored did not."""
        a, b = number(1.0), number(1.0, quantity="contribution")
        (gone,) = find_moves(of(a, b), of(a))
        assert (gone.before, gone.after) == (1.0, None)
        assert isinf(replace(gone, scale=None).size)
        third = replace(b, partner="gyro.new")
        (new,) = find_moves(of(a, b), of(a, b, third))
        assert (new.before, new.after) == (None, 1.0)
        assert find_moves(of(a), of(a, b)) == ()

    def test_another_unit_is_a_move(self):
        """The same number in another unit is another number."""
        one = number(1.0)
        assert find_moves(of(one), of(replace(one, unit="rad/s")))


class TestSampled:
    """Numbers with standard errors."""

    def test_students_law(self):
        """Few degrees of freedom ask for more: t(14) at 2.9768 is 1 %."""
        few = {"standard_error": 1.0, "degrees_of_freedom": 7.0}
        p = probability_of(number(0.0, **few), number(2.97684 * sqrt(2.0), **few))
        assert_allclose(p, 0.01, rtol=1e-5)
        many = probability_of(
            number(0.0, standard_error=1.0),
            number(1.959964 * sqrt(2.0), standard_error=1.0),
        )
        assert_allclose(many, 0.05, rtol=1e-6)

    @pytest.mark.parametrize("error", [0.0, 1e-320, 1e-200, 1e200, 1.7e308])
    def test_no_double_overflows(self, error):
        """Whatever doubles a file holds, there is an answer, and it is finite."""
        for value in (0.0, 5e-324, 1e-300, -1.7e308, 1.7e308):
            a = number(1.0, standard_error=error, degrees_of_freedom=1e-300)
            b = number(value, standard_error=error, degrees_of_freedom=7.0)
            assert 0.0 <= probability_of(a, b) <= 1.0
            for move in find_moves(of(a), of(b)):
                assert move.times is None or np.isfinite(move.times)
                assert move.relative is None or np.isfinite(move.relative)
                assert move_table([move]).rest == 0

    def test_counts_are_compared_exactly(self):
        """0 of 100 against 6 of 100: two-sided Fisher, 2 C(194,100)/C(200,100)."""
        one, other = number(0.0, trials=100), number(0.06, trials=100)
        p = 2.0 * np.prod([(100.0 - k) / (200.0 - k) for k in range(6)])
        assert_allclose(probability_of(one, other), p, rtol=1e-10)
        assert_allclose(
            probability_of(
                replace(one, value=1.0), replace(other, value=1.0 - other.value)
            ),
            p,
            rtol=1e-10,
        )

    @pytest.mark.parametrize("value", [-1.0, 1.5, 1e100])
    def test_what_is_no_probability_is_compared(self, value):
        """A file may hold any double beside a number of trials."""
        one, other = number(0.5, trials=100), number(value, trials=10**8)
        assert probability_of(one, other) < 1e-10
        assert len(find_moves(of(one), of(other))) == 1

    def test_rare_events_raise_no_alarm(self):
        """Counts of a rare event from two seeds differ at 5 % in 5 % at the most."""
        rng = np.random.default_rng(3)
        pairs = rng.binomial(5000, 4e-4, (400, 2)) / 5000
        alarms = [
            probability_of(number(a, trials=5000), number(b, trials=5000)) < 0.05
            for a, b in pairs
        ]
        assert np.mean(alarms) <= 0.05
        # Control: a rate ten times as high is seen.
        assert (
            probability_of(number(4e-4, trials=5000), number(4e-3, trials=5000)) < 1e-3
        )

    def test_more_numbers_ask_for_more(self):
        """Bonferroni: a difference that one number shows is chance among thousands."""
        one = number(0.0, standard_error=1.0)
        other = number(4.5 * sqrt(2.0), standard_error=1.0)
        crowd = [replace(one, partner=str(k)) for k in range(3000)]
        assert find_moves(of(one), of(other))
        assert find_moves(of(one, *crowd), of(other, *crowd)) == ()


class TestWords:
    """Verdicts and other words."""

    def word(self, text, rests_on=""):
        """Return the verdict of a gyro."""
        return NominalProperty(
            subject="gyro.bias.x", quantity="verdict", text=text, rests_on=rests_on
        )

    def test_a_word_that_rests_on_no_trial_moves(self):
        """Meets to fails is a move."""
        (move,) = find_moves(
            of(words=[self.word("meets")]), of(words=[self.word("fails")])
        )
        assert (move.before, move.after) == ("meets", "fails")

    def test_a_word_moves_with_its_number(self):
        """A verdict that trials decide moved where the utilisation did."""
        low, near, high = (
            number(v, quantity="utilisation", standard_error=0.01)
            for v in (0.99, 1.01, 1.2)
        )
        meets, fails = (self.word(t, "utilisation") for t in ("meets", "fails"))
        assert find_moves(of(low, words=[meets]), of(near, words=[fails])) == ()
        assert len(find_moves(of(low, words=[meets]), of(high, words=[fails]))) == 2


def test_never_more_moves_than_comparisons():
    """What one side alone has is compared too, as gone or new."""
    word = NominalProperty(subject="gyro", quantity="verdict", text="meets")
    other = NominalProperty(subject="accelerometer", quantity="verdict", text="fails")
    far = number(1.0, subject="accelerometer.bias.x")
    before = of(number(1.0), words=[word])
    after = of(far, number(1.0, quantity="u"), words=[other])
    assert len(find_moves(before, after)) == 4
    assert len(compared(before, after)) == 4  # the quantity u came later


# ---- references of an older tool: what it has learnt since is no move ----------------

BIAS = Name("bias", owner="gyro", axis="x")


def contribution(subject, *, partner="", value=1.0):
    """Return one number of a result."""
    return QuantityValue(
        subject=subject,
        quantity="contribution",
        partner=partner,
        unit="deg/h",
        value=value,
    )


def not_given(text):
    """Return the word on what a gyro does not give."""
    return NominalProperty(subject="gyro", quantity="not_given", text=text)


OLD = Snapshot(
    numbers=(contribution(BIAS, partner=Name("bias_stability", owner="gyro")),),
    words=(not_given("gyro.rate_random_walk"),),
    known=KNOWN_FIRST,
)
GROWN = Snapshot(
    numbers=(
        *OLD.numbers,
        contribution(BIAS, partner=Name("g_sensitivity", owner="gyro")),
        contribution(Name("non_orthogonality", owner="gyro", axis="xy")),
    ),
    words=(not_given("gyro.rate_random_walk, gyro.g_sensitivity"),),
)


def test_a_new_source_and_a_new_parameter_do_not_move_an_old_reference():
    """Neither counts as compared, and nothing has moved."""
    assert find_moves(OLD, GROWN) == ()
    assert compared(OLD, GROWN).keys() == compared(OLD, OLD).keys()


def test_what_the_tool_had_then_still_moves():
    """Control: a reference of a tool that knew the source sees it come."""
    knew = replace(OLD, known=known_now() | {"non_orthogonality"})
    moved = {str(move.item) for move in find_moves(knew, GROWN)}
    assert moved == {
        "gyro.bias.x contribution gyro.g_sensitivity",
        "gyro.non_orthogonality.xy contribution",
        "gyro not_given",
    }


def test_a_line_that_is_gone_from_the_sheet_moves_an_old_reference():
    """Control: a line that was known and given then, and is not now, is a move."""
    gone = replace(
        GROWN,
        words=(not_given("gyro.rate_random_walk, gyro.bias_stability"),),
    )
    assert [move.item.quantity for move in find_moves(OLD, gone)] == ["not_given"]


def test_the_first_references_knew_eleven_sources():
    """What a reference without the word knew is part of what is known now."""
    assert known_now() > KNOWN_FIRST
    assert len(KNOWN_FIRST) == 11 + 3


def test_a_word_on_a_new_source_does_not_move_an_old_reference():
    """The status of a line that the tool did not have then is not compared."""
    lines = [
        NominalProperty(
            subject=Name(source, owner="gyro"), quantity="status", text="free"
        )
        for source in ("bias_stability", "g_sensitivity")
    ]
    old, grown = replace(OLD, words=lines[:1]), replace(OLD, words=lines)
    assert find_moves(old, grown) == ()
    assert len(find_moves(replace(old, known=known_now()), grown)) == 1
