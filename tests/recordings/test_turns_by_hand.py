"""A gyro calibrated by turns by hand: followed, solved, refused, mistakes named."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from calibration.test_mistakes import MEMS
from numpy.testing import assert_allclose

from budget.calibration.schemes import held_of
from budget.errors import CallError
from budget.inputs import load_device, load_procedure
from budget.model.measured import MeasuredTurn, MeasuredTurns, nominal_of, triad_of
from budget.model.response import tilt_matrix
from budget.model.rotation import rotation
from budget.model.windows import Setting, Window
from budget.recordings import calibrate as module
from budget.recordings.calibrate import calibrate
from budget.recordings.run_soundness import unseen_mistakes
from budget.recordings.simulated_run import simulated_run
from budget.report.calibrated import residual_charts

BY_HAND = "norm-and-turns-by-hand"
QUARTER = np.pi / 2.0


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with the device."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "unseen_of", lambda *_: ())
    (tmp_path / "mems.yaml").write_text(json.dumps(MEMS), encoding="utf-8")
    return tmp_path


@cache
def table(blunders=(), seed=5, azimuth="zero_unknown"):
    """Return the rows of a simulated table of means."""
    made = simulated_run(
        load_device(MEMS),
        procedure=replace(load_procedure(BY_HAND), azimuth=azimuth),
        seed=seed,
        means=True,
        rate=2.0,
        blunders=blunders,
    )
    return tuple("".join(made.csv()).splitlines())


def north():
    """Return the procedure of one who knows the heading of the first rest."""
    return replace(load_procedure(BY_HAND), azimuth="")


def found_of(folder, rows, **more):
    """Calibrate from rows."""
    (folder / "run.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    how = {"procedure": BY_HAND, "device": "mems.yaml"} | more
    return calibrate("run.csv", **how)


def quarter(axis, samples=90):
    """Return the rates of a quarter turn about a body axis in 9 s, (3, n)."""
    rates = np.zeros((3, samples))
    rates[axis] = QUARTER / 9.0
    return rates


def two_quarters(earth=(0.0, 0.0, 0.0)):
    """Return a unit turned by 90 deg about x, then by 90 deg about y."""
    # Up is z; it is y after the first, and stays y after the second about y.
    down = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    dwells = tuple(
        Window(name=str(k), start=20.0 * k, length=10.0, setting=Setting(), use="both")
        for k in range(3)
    )
    turns = tuple(
        MeasuredTurn(
            first=k,
            last=k + 1,
            start=20.0 * k + 10.0,
            lengths=np.full(90, 0.1),
            rates=quarter(k),
        )
        for k in range(2)
    )
    return MeasuredTurns(
        dwells=dwells,
        down=down,
        still=np.zeros((3, 3)),
        turns=turns,
        earth=np.array(earth),
    )


def test_two_quarter_turns_by_hand():
    """Each leads to where down is seen; a scale factor misses by its part of 90 deg."""
    turns = two_quarters()
    nominal = np.concatenate([np.ones(3), np.zeros(9)])
    assert_allclose(turns.misfit(triad_of(nominal)), 0.0, atol=1e-12)
    off = nominal.copy()
    off[0] = 1.0 + 1e-4  # x: less angle is seen, and up does not come to y
    misfit = turns.misfit(triad_of(off))
    angle = QUARTER * (1.0 - 1.0 / (1.0 + 1e-4))
    assert_allclose(misfit[:3], [0.0, 1.0 - np.cos(angle), -np.sin(angle)], atol=1e-13)
    assert_allclose(misfit[3:6], 0.0, atol=1e-12)  # the second turns about up


def test_the_slope_is_that_of_differences():
    """J of all twelve, of steps of both signs, with the earth's rate."""
    turns = two_quarters(earth=(0.0, 5e-5, 4e-5))
    nominal = np.concatenate([np.ones(3), np.zeros(9)])
    now = turns.follow(triad_of(nominal))
    assert_allclose(now.misfit, turns.misfit(triad_of(nominal)), rtol=1e-12)
    step = 1e-6
    found = np.empty_like(now.slope)
    for p in range(12):
        more = step * np.eye(12)[p]
        high, low = (turns.misfit(triad_of(nominal + s * more)) for s in (1, -1))
        found[:, p] = (high - low) / (2.0 * step)
    # J leaves out what is of the size of F itself, here the earth's 6e-4 rad in 9 s.
    assert_allclose(now.slope, found, rtol=0.0, atol=2e-3 * np.abs(found).max())


@pytest.mark.parametrize("knows_azimuth", [True, False])
def test_turns_without_noise_give_what_was_drawn(knows_azimuth):
    """The least squares of exact readings are the parameters, to rounding."""
    earth = 1e-5 * np.array([3.6, 4.8, 4.0])  # [rad/s]
    gyro = load_device(MEMS).sensors[0]
    held = held_of("gyro", load_procedure(BY_HAND), gyro)
    rng = np.random.default_rng(3)
    rates = rng.normal(0.0, 1.0, (18, 3))

    true = triad_of(
        nominal_of(held)
        + np.concatenate([rng.normal(0.0, 1e-3, 9), rng.normal(0.0, 1e-4, 3)])
    )
    M = np.eye(3) + tilt_matrix(true.mounting_angle)

    def read(w):
        return true.scale_factor[:, None] * (M @ w + true.bias[:, None])

    C, standing, dwells, turns = np.eye(3), [], [], []
    for k in range(18):
        standing.append(C)
        dwells.append(
            Window(
                name=str(k),
                start=20.0 * k,
                length=10.0,
                setting=Setting(),
                use="both",
            )
        )
        if k == 17:
            break
        own = 0.3 * rates[k] / np.linalg.norm(rates[k])
        seen = []
        for _ in range(80):
            seen.append(own + C @ earth)
            C = rotation(-own * 0.1) @ C
        turns.append(
            MeasuredTurn(
                first=k,
                last=k + 1,
                start=20.0 * k + 10.0,
                lengths=np.full(80, 0.1),
                rates=read(np.transpose(seen)),
            )
        )
    measured = MeasuredTurns(
        dwells=tuple(dwells),
        down=np.array(standing)[:, :, 2],
        still=read((np.array(standing) @ earth).T),
        turns=tuple(turns),
        earth=earth if knows_azimuth else earth * [0.0, 0.0, 1.0],
        knows_azimuth=knows_azimuth,
    )
    turns, found, is_found = measured.solve(held)
    assert is_found
    assert_allclose(found.scale_factor, true.scale_factor, rtol=1e-9)
    assert_allclose(found.mounting_angle, true.mounting_angle, atol=1e-9)
    assert_allclose(found.bias, true.bias, atol=1e-12)
    assert_allclose(turns.earth, earth, atol=1e-12)
    assert_allclose(turns.misfit(found), 0.0, atol=1e-9)


# ---- what is missing is said ---------------------------------------------------------


def said_of(found):
    """Return cautions as one text."""
    return " ".join(found.warnings)


def test_without_moves_the_gyro_is_left_out(folder):
    """Rows of dwells alone: accelerometers as ever, and why the gyro has none."""
    rows = table()
    how = load_procedure(BY_HAND)
    senses = [one.sense for one in module.windows_of(how)]
    dwells = [rows[0], *(row for row, s in zip(rows[1:], senses, strict=True) if not s)]
    found = found_of(folder, dwells)
    assert {one.sensor for one in found.outputs} == {"accelerometer"}
    assert "found by the turns between rests" in said_of(found)


def test_without_a_device_the_gyro_is_left_out(folder):
    """Nobody can say how large its errors may be."""
    found = found_of(folder, table(), device=None)
    assert {one.sensor for one in found.outputs} == {"accelerometer"}
    assert "give a data sheet of both" in said_of(found)


def changed(rows, change):
    """Return rows with another gyro."""
    head = rows[0].split(",")
    own = [k for k, one in enumerate(head) if one.startswith("gyro")]
    found = [rows[0]]
    for row in rows[1:]:
        cells = row.split(",")
        for axis, k in enumerate(own):
            if cells[k]:
                cells[k] = repr(change(axis, float(cells[k])))
        found.append(",".join(cells))
    return found


def test_a_dead_axis_is_named(folder):
    """No scale factor of nothing."""
    rows = changed(table(), lambda axis, value: 0.0 if axis == 1 else value)
    assert "gyro_y reads the same" in said_of(found_of(folder, rows))


def test_a_dead_axis_of_a_recording_is_named(folder):
    """Its turns are not seen, and the windows do not fit: it is said why."""
    (folder / "short.yaml").write_text(
        "name: short\nlatitude: 34 deg\ngravity: normal\nsample_rate: 20 Hz\n"
        "estimator: norm\npause: 0 s\nmoves: 60 deg/s\nwindows:\n"
        + "".join(
            f"  - {{middle: {m} deg, inner: {i} deg, dwell: 5 s}}\n"
            for m, every in (
                (0, range(0, 360, 45)),
                (45, range(0, 360, 90)),
                (-45, range(0, 360, 90)),
                (90, (0,)),
                (-90, (0,)),
            )
            for i in every
        ),
        encoding="utf-8",
    )
    made = simulated_run("mems.yaml", procedure="short.yaml", seed=2)
    rows = "".join(made.csv()).splitlines()
    rows = changed(rows, lambda axis, value: 0.0 if axis == 0 else value)
    with pytest.raises(CallError, match="gyro_x reads the same in all windows"):
        found_of(folder, rows, procedure="short.yaml")


@pytest.mark.slow
def test_readings_that_fit_nothing_give_no_values(folder):
    """Three times the rates: not sound, and no value of the gyro with a small u."""
    found = found_of(folder, changed(table(), lambda _, value: 3.0 * value))
    assert found.is_sound is False
    assert {one.sensor for one in found.outputs} == {"accelerometer"}
    assert "fit no values near its nominal ones" in said_of(found)


# ---- mistakes ------------------------------------------------------------------------


def test_a_sound_run_is_sound(folder):
    """All of both triads, and nothing looks like a mistake."""
    found = found_of(folder, table())
    assert found.is_sound
    assert len({one.sensor for one in found.outputs}) == 2
    assert not any("heading" in one for one in found.assumptions)


@pytest.mark.slow
def test_a_heading_that_is_taken_as_known_is_said(folder):
    """By a procedure whose azimuths are from north."""
    known = found_of(folder, table(), procedure=north())
    assert any("heading of the first rest" in one for one in known.assumptions)


@pytest.mark.slow
@pytest.mark.parametrize(
    "blunder",
    [
        *("earth_rate_missing", "earth_rate_sign", "latitude_sign", "degrees_radians"),
        *("axis_reversed=x", "axis_reversed=xyz", "axes_swapped=xy"),
    ],
)
def test_a_mistake_is_named(folder, blunder):
    """First, or among those that these attitudes do not tell it from."""
    check_named(found_of(folder, table((blunder,))), blunder)


def check_named(found, blunder):
    """Fail unless a mistake is the first that it looks like, or not told from it."""
    assert found.is_sound is False
    (one,) = found.looks_like
    name, _, axes = blunder.partition("=")
    assert any(
        each.name == name and (not axes or each.axes == axes)
        for each in (one.mistake, *one.also)
    )


@pytest.mark.slow
def test_a_rotation_of_both_triads_is_seen_against_north_alone(folder):
    """It is another body frame: of an azimuth that nobody knows it is no mistake."""
    rotated = ("axes_rotated=yzx",)
    assert found_of(folder, table(rotated)).is_sound
    rows = table(rotated, azimuth="")
    check_named(found_of(folder, rows, procedure=north()), *rotated)


@pytest.mark.slow
@pytest.mark.parametrize("azimuth", ["zero_unknown", ""])
def test_a_rotation_of_both_triads_is_said_not_to_be_shown(azimuth):
    """Before the run, where nobody knows the azimuth."""
    how = replace(load_procedure(BY_HAND), azimuth=azimuth)
    found = unseen_mistakes(load_device(MEMS), how).unseen
    gyro = {x.name: x.probability for x in found if x.sensor == "gyro"}
    assert (gyro.get("axes_rotated", 1.0) < 0.002) == bool(azimuth)


def test_turns_stand_in_the_result_and_on_the_page(folder):
    """All 17, by the angles that they were, with what is left beside its u."""
    found = found_of(folder, table())
    turns = found.turns
    assert [(one.first, one.last) for one in turns] == [
        (k, k + 1) for k in range(1, 18)
    ]
    angles = np.array([one.turned for one in turns])
    # Half turns mostly; some by way of another axis. A gyro reads them to 1 %.
    assert_allclose(angles / 45.0, np.rint(angles / 45.0), rtol=0.01)
    z = np.array([one.z for one in turns])
    assert 0.3 < np.mean(z**2) < 2.0  # of 34, less what 12 parameters take up
    charts = [*residual_charts(found)]
    assert len(charts) == 3
    titles = [str(one.title) for one in charts]
    assert titles[1].startswith("Gyro: the turn from rest")
    assert "axis" not in titles[2]
