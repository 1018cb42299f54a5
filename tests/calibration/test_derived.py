"""Derived outputs: rotation and shape of a triad, gyros against accelerometers."""

from __future__ import annotations

from dataclasses import replace
from math import radians, sqrt

import numpy as np
import pytest
from builders import line, procedure, sensor
from numpy.testing import assert_allclose
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

from budget.calibration.derived import combination, known_outputs, parts_of
from budget.calibration.problem import calibration_problem
from budget.inputs import load_procedure
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.model.response import COLUMN, ROW, SIGN
from budget.names import ANGLES, Name, every_output, parameters_of
from budget.units import ARCSEC

TRIADS = ("gyro", "accelerometer")
GEOMETRY = tuple(
    name
    for name in every_output("gyro")
    if name.quantity in {"rotation", "non_orthogonality"}
)
SHAPE = ("rotation", "non_orthogonality")
DEGREE = radians(1.0)
TRIALS = 40_000
SIGMAS = 5.0  # a bound that a sound estimate misses once in a million


def at(angles):
    """Return the derived outputs of a triad of these angles, in the order of ANGLES."""
    y = np.zeros((12, 1))
    y[3:9, 0] = angles
    return combination(parameters_of("gyro"), GEOMETRY)(y)[:, 0]


def matrix(angles):
    """Return I + dT."""
    M = np.eye(3)
    M[ROW, COLUMN] = SIGN * np.asarray(angles)
    return M


def of_geometry(angles):
    """Return the same of the nearest rotation, and of the angles between the axes."""
    M = matrix(angles)
    nearest, _ = polar(M)
    axes = M / np.linalg.norm(M, axis=1)[:, None]
    between = [np.arccos(axes[i] @ axes[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    # Rows of M are the sensitive axes: the rotation takes e_i there.
    right = [np.pi / 2.0 - angle for angle in between]
    return np.r_[Rotation.from_matrix(nearest.T).as_rotvec(), right]


def problem(sensors, plan, *texts):
    """Return the calibration with outputs of these groups."""
    known = known_outputs([one.kind for one in sensors], plan)
    chosen = [name for name in known if name.group in texts]
    return calibration_problem(sensors, plan, outputs=chosen)


def spread(found):
    """Return the standard uncertainties of a problem by the law [arcsec]."""
    return propagate(found).standard_uncertainty / ARCSEC


def mounted(kind, u):
    """Return a triad whose mounting repeatability is all that varies [arcsec]."""
    return sensor(kind, {"mounting_repeatability": np.asarray(u) * ARCSEC})


def test_a_small_turn_of_the_triad_is_its_rotation_by_the_right_hand_rule():
    """Sensitive axes turned by theta: rotation theta, all non-orthogonalities 0."""
    theta = np.array([3.0, -2.0, 1.0]) * 1e-8
    axes = Rotation.from_rotvec(theta).apply(np.eye(3))  # row i: where e_i goes
    angles = SIGN * axes[ROW, COLUMN]

    assert_allclose(at(angles)[:3], theta, rtol=1e-7)
    assert_allclose(at(angles)[3:], 0.0, atol=1e-15)
    assert_allclose(at(-angles)[:3], -theta, rtol=1e-7)


@pytest.mark.parametrize(("pair", "place"), [("xy", 3), ("xz", 4), ("yz", 5)])
def test_axes_that_lean_together_are_less_than_a_right_angle_apart(pair, place):
    """One axis leaned to the other by 1e-6 rad is that much, and no other pair."""
    i, j = ("xyz".index(axis) for axis in pair)
    M = np.zeros((3, 3))
    M[i, j] = 1e-6
    found = at(SIGN * M[ROW, COLUMN])

    assert_allclose(found[place], 1e-6, rtol=1e-12)
    assert np.flatnonzero(found[3:]).tolist() == [place - 3]


def test_first_order_leaves_products_of_two_angles():
    """Up to 1 deg: 32 arcsec of a rotation, 66 of a non-orthogonality; errors 2, 4 %.

    Against the polar decomposition and the angles between the axes. Each bound is
    reached to nine tenths, so none is loose.
    """
    rng = np.random.default_rng(1)
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 6)).reshape(6, -1).T
    points = DEGREE * np.vstack([corners, rng.uniform(-1.0, 1.0, (200, 6))])
    missed = np.array([np.abs(at(a) - of_geometry(a)) for a in points]) / ARCSEC
    largest = missed.reshape(-1, 2, 3).max(axis=(0, 2))
    assert (largest < [32.0, 66.0]).all()
    assert (largest > [28.8, 59.4]).all()

    step, worst = 1e-6, np.zeros(2)
    for a in points:
        for error in corners[:32] if a is points[0] else rng.uniform(-1.0, 1.0, (2, 6)):
            ends = [of_geometry(a + sign * step * error) for sign in (1.0, -1.0)]
            off = np.abs((ends[0] - ends[1]) / (2.0 * step) - at(error))
            worst = np.maximum(worst, off.reshape(2, 3).max(axis=1))
    assert (worst < [0.022, 0.044]).all()
    assert (worst > [0.008, 0.016]).all()


def test_independent_angles_by_hand():
    """U 2 arcsec each: rotation 2/sqrt 2, non-orthogonality 2 sqrt 2; misalignment 2.

    An angle of its own size shows the halves: xz 6 and yz 8 make a rotation z of 5.
    """
    plan = procedure()
    both = tuple(mounted(kind, 2.0) for kind in TRIADS)
    found = problem(
        both, plan, "gyro.rotation", "gyro.non_orthogonality", "imu.misalignment"
    )
    expected = [2.0 / sqrt(2.0)] * 3 + [2.0 * sqrt(2.0)] * 3 + [2.0] * 3
    assert_allclose(spread(found), expected, rtol=1e-9)

    sizes = [{"xz": 6.0, "yz": 8.0}.get(axis, 0.0) for axis in ANGLES]
    found = problem((mounted("gyro", sizes),), plan, "gyro.rotation")
    assert_allclose(spread(found), [0.0, 0.0, 5.0], rtol=1e-9, atol=1e-9)


def test_monte_carlo_agrees_with_the_law_and_marginals_do_not():
    """Angles that share a source are correlated: without that the law is far off."""
    tilt = line("levelling.east", 60.0 * ARCSEC)
    plan = replace(load_procedure("six-positions"), station=(tilt,))
    device = mounted("accelerometer", 20.0)
    found = problem((device,), plan, "accelerometer.rotation")
    law = propagate(found)
    drawn = sample(found, trials=TRIALS, seed=3)
    bound = SIGMAS / sqrt(2.0 * TRIALS)
    # Of the rotation about x: the tilt in both angles, and half of two independent.
    assert_allclose(spread(found)[0], sqrt(60.0**2 + 20.0**2 / 2.0), rtol=1e-6)

    assert_allclose(drawn.standard_uncertainty, law.standard_uncertainty, rtol=bound)
    angles = propagate(calibration_problem((device,), plan))
    names = parameters_of("accelerometer")
    C = combination(names, [output.name for output in found.outputs])(np.eye(12))
    assert_allclose(
        law.covariance, C @ angles.covariance @ C.T, rtol=0.0, atol=1e-9 * ARCSEC**2
    )
    marginal = np.sqrt(C**2 @ np.diag(angles.covariance))
    assert abs(marginal[0] / drawn.standard_uncertainty[0] - 1.0) > 10.0 * bound


def test_what_turns_both_triads_alike_misaligns_nothing():
    """A triad that another one repeats, angle by angle, is aligned with it."""
    names = [*parameters_of("gyro"), *parameters_of("accelerometer")]
    outputs = every_output("imu")
    angles = np.random.default_rng(0).normal(size=(12, 50)) * ARCSEC
    alike = combination(names, outputs)(np.concatenate([angles, angles]))
    unlike = combination(names, outputs)(np.concatenate([angles, -angles]))

    assert not alike.any()
    assert unlike.all()


def test_a_tilted_base_turns_the_accelerometers_and_leaves_their_shape():
    """Six faces see a tilt about east as yx = zx, a rotation; gyros do not feel it.

    About north zy alone: half a rotation, half of a shape. Faces at four azimuths undo
    both.
    """
    wanted = ("gyro.rotation", "accelerometer.rotation", "imu.misalignment")
    wanted += ("accelerometer.non_orthogonality",)
    u = {
        (plan, axis): tilted(plan, axis, wanted)
        for plan in ("six-positions-and-turns", "twenty-four-positions")
        for axis in ("east", "north")
    }
    six = "six-positions-and-turns"

    east = {"accelerometer.rotation.x": 60.0, "imu.misalignment.x": 60.0}
    assert u[six, "east"] == pytest.approx(east, rel=1e-4, abs=0.0)
    north = {
        "accelerometer.rotation.y": 30.0,
        "accelerometer.non_orthogonality.xz": 60.0,
        "imu.misalignment.y": 30.0,
    }
    assert u[six, "north"] == pytest.approx(north, rel=1e-4, abs=0.0)
    assert u["twenty-four-positions", "east"] == {}
    assert u["twenty-four-positions", "north"] == {}


def tilted(plan, axis, wanted):
    """Return what a tilt of 60 arcsec makes more than 0.1 arcsec of, by output."""
    tilt = line(f"levelling.{axis}", 60.0 * ARCSEC)
    found = problem(
        tuple(sensor(kind, {}) for kind in TRIADS),
        replace(load_procedure(plan), station=(tilt,)),
        *wanted,
    )
    names = [output.name for output in found.outputs]
    return {n: u for n, u in zip(names, spread(found), strict=True) if u > 0.1}


@pytest.mark.parametrize("kind", TRIADS)
def test_an_output_is_known_where_all_its_angles_are_estimated(kind):
    """Without yx there is no rotation about x, no yz, no misalignment about x."""
    held = Name("mounting_angle", owner=kind, axis="yx")
    plan = replace(procedure(), held=(held,))
    found = {str(name) for name in known_outputs(TRIADS, plan)}
    every = {str(name) for name in known_outputs(TRIADS, procedure())}

    assert every - found == {
        held,
        f"{kind}.rotation.x",
        f"{kind}.non_orthogonality.yz",
        "imu.misalignment.x",
    }
    assert set(parts_of(Name("rotation", owner=kind, axis="x"))) == {
        held,
        f"{kind}.mounting_angle.zx",
    }


@pytest.mark.parametrize(
    ("flip", "of_accelerometers", "apart", "between"),
    [("inner", 1.0, 0.0, 0.5), ("middle", 0.5, 1.0, 0.0)],
)
def test_axes_out_of_square_turn_one_triad_and_shear_the_other(
    flip, of_accelerometers, apart, between
):
    """Outer to middle axis mu: of gyros yx = mu, rotation mu/2, non-orthogonality mu.

    With z down by the inner axis the accelerometers have yx = zx = mu, a rotation, and
    the triads stand mu/2 apart; by the middle axis zx alone, and they do not.
    """
    mu = 2.0
    plan = procedure(
        station=(line("orthogonality.outer_middle", [mu * ARCSEC]),), flip_axis=flip
    )
    groups = [f"{kind}.{one}" for kind in TRIADS for one in SHAPE]
    triads = tuple(mounted(kind, 0.0) for kind in TRIADS)
    found = problem(triads, plan, *groups, "imu.misalignment")
    u = dict(zip((one.name for one in found.outputs), spread(found), strict=True))
    expected = dict.fromkeys(u, 0.0) | {
        "gyro.rotation.x": 0.5 * mu,
        "gyro.non_orthogonality.yz": mu,
        "accelerometer.rotation.x": of_accelerometers * mu,
        "accelerometer.non_orthogonality.yz": apart * mu,
        "imu.misalignment.x": between * mu,
    }
    # What is left beside them are products with the nominal angles.
    assert_allclose(list(u.values()), list(expected.values()), rtol=1e-4, atol=1e-3)
