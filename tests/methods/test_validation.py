"""The law against Monte Carlo: confirmed where it holds, refused where it fails."""

from __future__ import annotations

import numpy as np
import pytest
from builders import line, paper_accelerometer, paper_gyro, procedure, sensor

from budget.calibration.problem import calibration_problem
from budget.distributions import NORMAL, UNIFORM
from budget.methods.gum import propagate
from budget.methods.validation import MAX_TRIALS, validate
from budget.problem import Group, Output, Problem
from budget.units import DEG_PER_HOUR


def judge(problem, **how):
    """Return the validations of the law."""
    return validate(problem, propagate(problem), **how)


def sum_of(*u):
    """Return Y = X1 + ... of rectangular inputs."""
    return Problem(
        groups=tuple(
            Group.independent(f"X{i}", u=size, distribution=UNIFORM)
            for i, size in enumerate(u)
        ),
        outputs=(Output(name="Y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )


def test_the_built_in_device_is_confirmed():
    """All 24 outputs hold, with at most 250,000 trials."""
    found = judge(
        calibration_problem((paper_gyro(), paper_accelerometer()), procedure())
    )
    assert len(found) == 24
    assert all(v.holds for v in found)
    assert found[0].trials <= MAX_TRIALS


def test_jcgm_101_9_2_4_is_refused():
    """One rectangular input dominates: the law's 19.9 against 17.0, d = 2.9: 9.2.4."""
    (found,) = judge(sum_of(1.0, 1.0, 1.0, 10.0), digits=2)
    assert not found.holds
    assert abs(found.difference_low - 2.9) < 0.1
    assert abs(found.difference_high - 2.9) < 0.1


def test_jcgm_101_9_2_2_is_confirmed():
    """Normal inputs are confirmed to two digits."""
    problem = Problem(
        groups=tuple(Group.independent(n, u=1.0) for n in "abcd"),
        outputs=(Output(name="Y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )
    (found,) = judge(problem, digits=2, max_trials=2_000_000)
    assert found.holds


def test_products_of_sources_alone_are_refused():
    """Zero bias and angles, large asymmetry: only Ka times bias is left, no normal law.

    First-order terms vanish for K_x and the six angles; the second order has their
    standard uncertainty right, but the law of a product of normals is not normal.
    """
    gyro = sensor(
        "gyro",
        {"bias_repeatability": 2.5 * DEG_PER_HOUR, "scale_factor_asymmetry": 5e-2},
    )
    problem = calibration_problem((gyro,), procedure())
    law = propagate(problem)
    assert law.first_order[0, 0] == 0.0
    assert law.standard_uncertainty[0] > 0.0
    found = dict(
        zip([o.name for o in problem.outputs], judge(problem, digits=2), strict=True)
    )
    for name in ("scale_factor.x", "mounting_angle.xy", "mounting_angle.zy"):
        assert not found[f"gyro.{name}"].holds
    assert found["gyro.bias.x"].holds


@pytest.mark.parametrize(("shape", "confirmed"), [(UNIFORM, False), (NORMAL, True)])
def test_a_uniform_figure_that_dominates_is_refused(shape, confirmed):
    """A 'max' repeatability of 50 ppm makes the scale factor uniform, not normal."""
    lines = [
        line("scale_factor_repeatability", 50e-6, distribution=shape),
        line("bias_stability", 0.04 * DEG_PER_HOUR),
    ]
    problem = calibration_problem((sensor("gyro", lines),), procedure())
    found = judge(problem, digits=1)
    # +-98 by the law, +-82 in truth: three tolerances of 5 ppm apart.
    assert [v.holds for v in found[:3]] == [confirmed] * 3


def test_an_output_without_spread_holds_and_has_no_nan():
    """With one source alone the other outputs are constant: they hold, no NaN."""
    problem = calibration_problem(
        (paper_gyro(),),
        procedure(),
        only=frozenset({"gyro.scale_factor_repeatability"}),
    )
    for v in judge(problem)[3:]:
        assert v.holds
        assert np.isfinite([v.difference_low, v.difference_high, v.tolerance]).all()
