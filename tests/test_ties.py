"""Equal quantities are named together; no digit hangs on the rounding of doubles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from report_examples import make_assessment, make_budget

from budget.inputs.records import ANGLES
from budget.known import Known
from budget.names import Name
from budget.report.analysis.verdict import verdict_cards
from budget.report.figures.outputs import utilisation_chart
from budget.report.tables import (
    join_outputs,
    print_given,
    print_share,
    print_stop,
    print_utilisation,
    round_uncertainty,
    round_value,
)
from budget.ties import equal_to, first_largest, from_largest, largest, settle

NOISE = 1e-12  # relative: what other processors and other orders of a sum may change


def shake(rng, value):
    """Change a number by no more than NOISE of it."""
    return value * (1.0 + NOISE * rng.uniform(-1.0, 1.0))


def test_the_largest_are_all_that_are_equal():
    """Ties to 1e-6 are found in their order; the first stands for them."""
    values = [0.5, 2.0, 2.0 * (1 - 1e-9), 2.0 * (1 - 1e-5), 0.0]

    assert largest(values) == (1, 2)
    assert first_largest([2.0 * (1 - 1e-9), 2.0]) == 0
    assert from_largest(values) == (1, 2, 3, 0, 4)
    assert equal_to(values, 2) == (1, 2)
    assert largest([0.0, 0.0]) == (0, 1)
    assert largest([]) == ()
    assert from_largest([-1e-20, 1.0, 0.0]) == (1, 2, 0)
    with pytest.raises(ValueError, match="of no values"):
        first_largest([])


def test_noise_changes_no_place():
    """Equal, zero and unequal values keep their order whatever the last digits are."""
    rng = np.random.default_rng(5)
    values = [3.0, 3.0, 1.0, 3.0, 1.0, 0.0, 2.0]
    orders = {from_largest([shake(rng, v) for v in values]) for _ in range(200)}
    by_max = {int(np.argmax([shake(rng, v) for v in values])) for _ in range(200)}

    assert orders == {(0, 1, 3, 6, 2, 4, 5)}
    assert by_max == {0, 1, 3}  # the control: plain argmax names each of them


@pytest.mark.parametrize(
    "write",
    [
        lambda x: round_uncertainty(x(0.125)),
        lambda x: round_value(x(2.5), x(10.0)),
        lambda x: round_value(x(-0.0005), x(0.0995)),
        lambda x: print_given(x(1.2345)),
        lambda x: print_share(x(0.125)),
        lambda x: print_share(x(0.001)),
        lambda x: print_utilisation(x(1.0)),
        lambda x: print_utilisation(x(0.9985)),
        lambda x: print_utilisation(x(1.2345)),
    ],
)
def test_a_digit_on_the_edge_does_not_flip(write):
    """A value half-way between two digits prints the same, a bit up or down."""
    texts = {write(lambda v, up=up: v * (1.0 + up * 1e-14)) for up in (-1, 0, 1)}

    assert len(texts) == 1


def test_settling_keeps_twelve_digits():
    """What is cut off is below the twelfth digit, and 0 stays 0."""
    assert settle(0.1 + 0.2) == 0.3
    assert settle(1.00000000001) != 1.0
    assert settle(0.0) == 0.0


def test_outputs_are_named_together():
    """Axes of one parameter stand behind its name; all six are 'every axis'."""
    angles = [Name("mounting_angle", owner="gyro", axis=axis) for axis in ANGLES]
    biases = [Name("bias", owner="gyro", axis=axis) for axis in "xyz"]

    assert join_outputs(biases) == "gyro bias x, y, z"
    assert join_outputs(angles) == "gyro mounting angle (every axis)"
    assert print_stop(biases[:2], "gyro") == "bias x, y"
    assert print_stop([], "gyro") == "-"


def shaken(budget, seed):
    """Return a budget as another processor would compute it."""
    rng = np.random.default_rng(seed)
    return replace(
        budget,
        outputs=tuple(
            replace(
                row,
                standard_uncertainty=Known(shake(rng, row.standard_uncertainty)),
                interval=tuple(shake(rng, end) for end in row.interval),
                contributions=tuple(
                    replace(
                        part,
                        standard_uncertainty=Known(
                            shake(rng, part.standard_uncertainty)
                        ),
                        share=shake(rng, part.share),
                    )
                    for part in row.contributions
                ),
            )
            for row in budget.outputs
        ),
    )


def test_words_of_a_report_do_not_hang_on_noise():
    """Cards and titles of equal axes read the same for budgets 1e-12 apart."""
    said = set()
    for seed in range(8):
        budget = shaken(make_budget(), seed)
        assessment = make_assessment(budget)
        cards = verdict_cards(budget, assessment)
        said.add((repr_texts(cards), utilisation_chart(assessment).title))

    assert len(said) == 1


def repr_texts(cards):
    """Return all that cards say, without the exact numbers behind the words."""
    return "\n".join(
        "".join(run if isinstance(run, str) else run.text for run in line)
        for card in cards
        for line in card.lines
    )
