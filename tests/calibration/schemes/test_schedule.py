"""Schedules: order, times and pauses of turns and dwells."""

from __future__ import annotations

from math import radians

from builders import procedure
from numpy.testing import assert_allclose

from budget.calibration.schemes import schedule_accelerometer, schedule_gyro


def test_gyro_turns_come_before_dwells_plus_before_minus():
    """The paper's gyro test is z+ z- x+ x- y+ y- and four dwells, back to back."""
    plan = schedule_gyro(procedure().gyro)
    assert [w.name for w in plan.windows] == [
        *("turn z+", "turn z-", "turn x+", "turn x-", "turn y+", "turn y-"),
        *("azimuth 0", "azimuth 180", "azimuth 270", "azimuth 450"),
    ]
    assert_allclose(plan.lengths, [18.0] * 6 + [300.0] * 4, rtol=1e-14)
    assert_allclose(
        plan.starts, [0, 18, 36, 54, 72, 90, 108, 408, 708, 1008], rtol=1e-14
    )


def test_order_moves_a_turn_in_time_but_keeps_its_name():
    """With order y, z, x the first turn is about y and still called so."""
    plan = schedule_gyro(procedure(order=("y", "z", "x")).gyro)
    assert plan.windows[0].name == "turn y+"
    assert plan.pick(1, 1) == (0,)


def test_pause_lies_between_all_windows():
    """A pause of 5 s shifts the k-th window by 5 k seconds."""
    without = schedule_gyro(procedure(turns=3).gyro)
    with_pause = schedule_gyro(procedure(turns=3, pause=5.0).gyro)
    assert_allclose(
        with_pause.starts - without.starts, [5.0 * k for k in range(10)], rtol=1e-13
    )
    assert_allclose(with_pause.lengths, without.lengths, rtol=1e-14)


def test_accelerometer_holds_each_face_twice_in_a_row():
    """Twelve dwells: z up, z down, x up, x down, y up, y down, each twice."""
    plan = schedule_accelerometer(procedure().accelerometer)
    assert [(w.axis, w.sign) for w in plan.windows] == [
        (axis, sign) for axis in (2, 0, 1) for sign in (1, -1) for _ in range(2)
    ]
    assert_allclose(plan.starts, [300.0 * k for k in range(12)], rtol=1e-14)


def test_azimuths_are_kept_as_given():
    """450 deg stays 450 deg."""
    plan = schedule_gyro(procedure().gyro)
    assert plan.windows[-1].azimuth == radians(450.0)
