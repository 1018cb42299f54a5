"""Recorded calibrations: windows found, values with their uncertainties, said so."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import yaml
from calibration.test_mistakes import MEMS
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS
from scipy.stats import binom, kstest, norm

from budget.calibration.schemes import windows_of
from budget.errors import CallError, SpecError
from budget.inputs import load_device, load_procedure
from budget.names import ANGLES, AXES
from budget.recordings import calibrate as module
from budget.recordings.calibrate import calibrate
from budget.recordings.simulated_run import simulated_run
from budget.units import size_of

RUN = TESTS / "data" / "run.csv"
SIX = "six-positions-and-turns"
PARAMETERS = ("scale_factor", "mounting_angle", "bias")
STATED = {"scale_factor_repeatability": {"value": "500 ppm", "meaning": "1 sigma"}}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with the device and a short procedure of six faces and turns."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mems.yaml").write_text(json.dumps(MEMS), encoding="utf-8")
    (tmp_path / "six.yaml").write_text(
        "name: six faces\nlatitude: 34.2394 deg\ngravity: normal\n"
        "sample_rate: 50 Hz\nestimator: least_squares\npause: 4 s\nwindows:\n"
        "  - {face: all, dwell: 10 s}\n"
        + "".join(
            f"  - {{face: {axis} up, turn: vertical, turns: 1, rate: 45 deg/s, "
            "back: true, use: gyro}\n"
            for axis in "zxy"
        ),
        encoding="utf-8",
    )
    return tmp_path


def written(folder, made, name="run.csv"):
    """Write a simulated run."""
    path = folder / name
    path.write_text("".join(made.csv()), encoding="utf-8")
    return path


def truth_of(made, output):
    """Return what was drawn of a parameter [SI]."""
    own = made.turn_ons[output.sensor]
    axes = ANGLES if output.parameter == "mounting_angle" else AXES
    values = {"scale_factor": own.k, "mounting_angle": own.angle, "bias": own.bias}
    return values[output.parameter][axes.index(output.axis)]


def pulls(made, found):
    """Return errors over standard uncertainties, of parameters."""
    return np.array(
        [
            (one.value - truth_of(made, one)) / one.standard_uncertainty
            for one in found.outputs
            if one.parameter in PARAMETERS
        ]
    )


def test_a_recording_gives_what_was_drawn(folder):
    """Windows are found by rest and turn; values are what was drawn, to their U."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2)
    path = written(folder, made)
    found = calibrate(path, procedure="six.yaml", device="mems.yaml")
    assert found.is_sound
    # Of 24 the largest, by the law: 1 - (1 - p)^24 of 0.001.
    assert np.abs(pulls(made, found)).max() < norm.isf(0.5 * 0.001 / 24)
    own = [one for one in found.windows if one.sensor == "gyro"]
    assert [one.window for one in own] == list(range(1, 13))
    assert_allclose([one.length for one in own[6:]], 8.0, atol=0.05)
    assert not found.passed_over


def test_a_rest_too_many_is_listed_and_one_missing_refused(folder):
    """What is no window is passed over; without a window there is no calibration."""
    long = simulated_run("mems.yaml", procedure=SIX, seed=1, rate=50.0)
    assert len(windows_of(load_procedure(SIX))) == 12
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2)
    text = "".join(made.csv()).splitlines(keepends=True)
    first = next(x for x in made.steps if x.place == 1).window  # z down
    rate = 50
    cut = [
        text[0],
        *text[1 : 1 + int((first.start - 5.0) * rate)],
        *text[1 + int((first.end + 5.0) * rate) :],
    ]
    (folder / "cut.csv").write_text("".join(cut), encoding="utf-8")
    with pytest.raises(CallError, match=r"(?s)wanted: 1 z up; 2 z down.*found: rest"):
        calibrate("cut.csv", procedure="six.yaml", device="mems.yaml")
    before = "".join(long.csv()).splitlines(keepends=True)[1 : 50 * 8]
    times = [
        f"{k / 50.0 - 100.0:.6g}," + x.split(",", 1)[1] for k, x in enumerate(before)
    ]
    more = [text[0], *times, *text[1:]]
    (folder / "more.csv").write_text("".join(more), encoding="utf-8")
    found = calibrate("more.csv", procedure="six.yaml", device="mems.yaml")
    assert len(found.passed_over) == 1
    assert found.passed_over[0].end < 0.0


def test_several_recordings_are_one_after_the_other(folder):
    """In parts a run says what it says as a whole, at the times at which it was.

    Lines of correlated noise hang on the time between windows: parts that all began at
    0 were not sound, by a mistake that nobody had committed.
    """
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2)
    head, *rows = "".join(made.csv()).splitlines(keepends=True)
    (folder / "whole.csv").write_text("".join([head, *rows]), encoding="utf-8")
    ends = [x.window.end for x in made.steps if x.place in {3, 5}]
    cuts = [0, *(int((end + 2.5) * 50.0) for end in sorted(ends)), len(rows)]
    names = []
    for k, (a, b) in enumerate(pairwise(cuts)):
        names.append(f"part-{k}.csv")
        (folder / names[-1]).write_text("".join([head, *rows[a:b]]), encoding="utf-8")
    for k, name in enumerate(names):
        own = (folder / name).read_text(encoding="utf-8").splitlines()[1:]
        bare = [one.split(",", 1)[1] for one in own]
        text = [head.split(",", 1)[1].strip(), *bare]
        (folder / f"bare-{k}.csv").write_text("\n".join(text) + "\n", encoding="utf-8")
    given = {"procedure": "six.yaml", "device": "mems.yaml"}
    whole = calibrate("whole.csv", **given)
    parts = calibrate(*names, **given)
    bare = calibrate(*(f"bare-{k}.csv" for k in range(3)), rate=50.0, **given)
    for found in (parts, bare):
        for field in ("start", "length"):
            assert_allclose(
                [getattr(x, field) for x in found.windows],
                [getattr(x, field) for x in whole.windows],
                rtol=0.0,
                atol=0.1,  # s: edges of rests by the scatter of each part
            )
        assert_allclose(
            [x.p for x in found.chi_square], [x.p for x in whole.chi_square], rtol=0.2
        )
        assert found.is_sound
    assert not any("pauses" in x for x in (*whole.warnings, *parts.warnings))
    assert any("pauses" in x for x in bare.warnings)


def test_least_squares_by_hand(folder):
    """Values are those of numpy's least squares of the window means, to rounding."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    found = calibrate(written(folder, made), procedure="six.yaml", device="mems.yaml")
    own = [one for one in found.windows if one.sensor == "accelerometer"]
    g = made.procedure.gravity
    inputs = g * np.array(
        [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]
    )
    order = [
        ["z up", "z down", "x up", "x down", "y up", "y down"].index(x.name)
        for x in own
    ]
    A = np.column_stack([inputs[order], np.ones(6)])
    fitted = np.linalg.lstsq(A, np.array([one.mean for one in own]))[0].T
    (matrix,) = [x for x in found.matrix if x.sensor == "accelerometer"]
    assert_allclose(matrix.sensor_from_body, fitted[:, :3], rtol=1e-9, atol=1e-10)
    assert_allclose(matrix.bias, fitted[:, 3], rtol=1e-7)
    assert_allclose(
        matrix.body_from_sensor @ matrix.sensor_from_body, np.eye(3), atol=1e-12
    )
    assert_allclose(
        matrix.triangle @ matrix.rotation, matrix.sensor_from_body, atol=1e-12
    )
    assert_allclose(np.triu(matrix.triangle, 1), 0.0, atol=1e-15)
    assert_allclose(matrix.rotation @ matrix.rotation.T, np.eye(3), atol=1e-12)


def test_counts_without_a_gain_stay_counts(folder):
    """Scale factors are in counts per unit, and nothing is said in ppm."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    gain, zero = 2048.0 / 9.80665, 32768.0
    rows = [x.split(",") for x in "".join(made.csv()).splitlines()]
    place = [k for k, head in enumerate(rows[0]) if head.startswith("acc")]
    for row in rows[1:]:
        for k in place:
            row[k] = f"{float(row[k]) * gain + zero:.9g}" if row[k] else ""
    rows[0] = [x.replace("[m/s^2]", "[counts]") for x in rows[0]]
    (folder / "c.csv").write_text(
        "".join(",".join(row) + "\n" for row in rows), encoding="utf-8"
    )
    plain = calibrate(written(folder, made), procedure="six.yaml", device="mems.yaml")
    found = calibrate("c.csv", procedure="six.yaml", device="mems.yaml")
    assert found.is_sound
    for one, other in zip(plain.outputs, found.outputs, strict=True):
        if one.sensor != "accelerometer":
            continue
        if one.parameter == "scale_factor":
            assert other.unit == "counts/(m/s^2)"
            assert other.prior is None
            value = other.value / other.si_per_unit
            assert_allclose(value, gain * (1.0 + one.value), rtol=1e-7)
            u = other.standard_uncertainty / other.si_per_unit
            assert_allclose(u, gain * one.standard_uncertainty, rtol=1e-2)
        elif one.parameter == "mounting_angle":
            assert_allclose(other.value, one.value, rtol=0, atol=1e-7)
    (matrix,) = [x for x in found.matrix if x.sensor == "accelerometer"]
    assert_allclose(matrix.bias, zero, rtol=1e-3)


def test_without_a_device_the_scatter_says_how_sure(folder):
    """Student's t of the degrees that are left; whether it was sound nobody knows."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    found = calibrate(written(folder, made), procedure="six.yaml")
    assert found.is_sound is None
    own = [one for one in found.outputs if one.parameter == "bias"]
    nu = {one.sensor: one.degrees_of_freedom for one in own}
    assert nu["accelerometer"] == pytest.approx(2.0, rel=1e-6, abs=0.0)
    assert 2.0 < nu["gyro"] < 8.0  # turns are of other lengths than dwells
    k = {one.sensor: one.coverage_factor for one in own}
    assert_allclose(k["accelerometer"], 4.302653, rtol=1e-6)
    # By hand: u of a bias of six faces is s/sqrt(6), s^2 the sum of squares over 2.
    left = np.array([x.residual for x in found.windows if x.sensor == "accelerometer"])
    s = np.sqrt((left**2).sum(axis=0) / 2.0)
    u = [
        one.standard_uncertainty / one.si_per_unit
        for one in own
        if one.sensor == "accelerometer"
    ]
    assert_allclose(u, s / np.sqrt(6.0), rtol=1e-2)  # of K and b besides


@pytest.mark.parametrize(
    ("blunder", "said"),
    [
        ("earth_rate_sign", "the earth rate with the wrong sign"),
        ("axes_swapped=xy", "axes x and y exchanged"),
        ("axis_reversed=y", "axis y reversed"),
        ("window_face=3:y up", "window 3 at y up"),
        ("windows_order=2,5", "windows 2 and 5 in the other order"),
        ("turn_sense", "all turns in the other sense"),
        ("degrees_radians", "degrees and radians exchanged"),
        ("latitude=-50 deg", "latitude -"),
    ],
)
@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_a_mistake_in_a_long_recording_is_named(blunder, said):
    """From simulate to the words on a terminal, with exit code 1."""
    words = ("simulate", "mems.yaml", "--procedure", SIX, "--rate", "20", "--seed", "4")
    assert call(*words, "--blunder", blunder, "-o", "r.csv").code == 0
    found = call("calibrate", "r.csv", "--procedure", SIX, "--device", "mems.yaml")
    assert found.code == 1
    assert "NOT SOUND" in found.out
    assert said in " ".join(found.out.split())


@pytest.mark.usefixtures("folder")
def test_motion_at_the_end_of_a_dwell_is_named():
    """A dwell of the paper's test, read half a second into the move after it."""
    words = ("simulate", "zhao-2019", "--means", "--blunder", "window_motion=8:0.5 s")
    assert call(*words, "--rate", "20", "-o", "r.csv").code == 0
    found = call(
        "calibrate", "r.csv", "--procedure", "zhao-2019", "--device", "zhao-2019"
    )
    assert found.code == 1
    assert "in window 8: axis z off" in " ".join(found.out.split())


def test_one_seed_gives_one_run(folder):
    """The same bytes; the table of means is of the same unit as the recording."""
    words = ("simulate", "mems.yaml", "--procedure", "six.yaml", "--truth", "t.yaml")
    texts = []
    for more in ((), (), ("--seed", "1"), ("--means",)):
        assert call(*words, *more, "-o", "a.csv").code == 0
        texts.append((folder / "a.csv").read_bytes())
    assert texts[0] == texts[1] != texts[2]
    made = simulated_run("mems.yaml", procedure="six.yaml")
    rows = np.loadtxt(folder / "a.csv", delimiter=",", skiprows=1, usecols=(2, 3, 4))
    every = np.concatenate(list(made.pieces()))
    first = next(x.window for x in made.steps if x.place == 0)
    inside = (every[:, 0] >= first.start - 1e-9) & (every[:, 0] < first.end - 1e-9)
    mean = every[inside, 1:4].mean(axis=0) / size_of("deg/s")
    assert_allclose(rows[0], mean, rtol=1e-7)


# Published by imucal for its annotated session: K_a, R_a and K_g, of S = K R.
K_A = (208.54567263762615, 208.0011341167055, 214.78455364603022)
R_A = (
    (0.9999125214309234, 0.007122056140390757, -0.011145662922687352),
    (-0.007947378455060604, 0.9996887358297629, 0.023648903373787954),
    (0.021342900724016442, -0.010781879507682177, 0.9997140749549175),
)
K_G = (16.67769558952488,)


def test_a_published_calibration_comes_out():
    """Raw counts of a Ferraris session: its K and R to rounding, its bias another's."""
    folder = TESTS / "data" / "imucal"
    found = calibrate(folder / "run.csv", procedure=folder / "procedure.yaml")
    assert found.is_sound is None
    gyro, accelerometer = found.matrix
    S = accelerometer.sensor_from_body
    assert_allclose(np.linalg.norm(S, axis=1), K_A, rtol=1e-9)
    assert_allclose(S / np.linalg.norm(S, axis=1)[:, None], R_A, rtol=0, atol=1e-9)
    # Its own bias is the mean of two faces, -6.019, -48.288, -28.966 counts.
    assert_allclose(accelerometer.bias, [-7.873920, -55.943248, -31.030893], atol=1e-6)
    assert_allclose(
        accelerometer.bias_standard_uncertainty, [2.05, 8.57, 1.19], atol=0.01
    )
    assert_allclose(
        np.diag(accelerometer.standard_uncertainty), [0.363, 1.512, 0.210], atol=1e-3
    )
    # It leaves the earth rate out.
    rows = np.linalg.norm(gyro.sensor_from_body, axis=1)
    assert_allclose(rows[0], K_G[0], rtol=3e-4)
    assert_allclose(
        np.diag(gyro.sensor_from_body), [16.6765, 16.1766, 16.2404], rtol=3e-4
    )
    assert gyro.unit == "counts/(deg/s)"


# imu_tk's program of its Xsens recording: 1/K and T of T K (reading - bias), upper.
XSENS_SCALE = (414.459, 412.01, 414.649)
XSENS_T = (-0.0033593, -0.00890639, -0.0213341)
XSENS_BIAS = (33124.2, 33275.2, 32364.4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("table", "scale", "angle", "bias"),
    [
        # It takes every sample for a residual: noise enters it by its square.
        ("means-first-100.csv", 6e-6, 3e-5, 1.2e-6),
        # Of more samples of the same rests: up to 1.8 u.
        ("means-whole.csv", 1e-4, 3e-4, 1.2e-5),
    ],
)
def test_a_published_calibration_by_the_norm_comes_out(table, scale, angle, bias):
    """Raw counts of 38 rests by hand, no gyro and no gain."""
    folder = TESTS / "data" / "imu_tk"
    found = calibrate(folder / table, procedure=folder / "procedure.yaml")
    (triad,) = found.matrix
    assert (triad.unit, triad.bias_unit) == ("counts/(m/s^2)", "counts")
    inverse = np.linalg.inv(triad.sensor_from_body)
    K, u = np.diag(inverse), np.diag(triad.standard_uncertainty)
    T = inverse / K
    assert_allclose(1.0 / K, XSENS_SCALE, rtol=scale)
    assert_allclose(T[(0, 0, 1), (1, 2, 2)], XSENS_T, rtol=0, atol=angle)
    assert_allclose(triad.bias, XSENS_BIAS, rtol=bias)
    assert (np.abs(1.0 / K - XSENS_SCALE) < 1.9 * u).all()
    off = np.abs(np.array(triad.bias) - XSENS_BIAS)
    assert (off < 1.9 * np.array(triad.bias_standard_uncertainty)).all()
    assert {one.degrees_of_freedom for one in found.outputs} == {29}


# Published by imu-calib for five MPU-9150: s_x, s_y, s_z [%], m_yz, m_xy, m_xz [deg]
# and b_x, b_y, b_z [m/s^2] of ((1 + s_x, m_xy, m_xz), (0, 1 + s_y, m_yz), ...).
LOT = (
    (0.363, 0.315, 0.647, 0.123, 0.02, 0.317, 0.103, 0.097, 0.344),
    (0.471, 0.482, 0.932, -0.284, -0.01, 0.145, 0.09, 0.07, 0.338),
    (0.382, 0.355, 0.78, 0.26, -0.012, 0.282, 0.096, 0.008, -0.045),
    (0.263, 0.448, 0.721, -0.009, -0.028, -0.104, 0.065, 0.092, -0.009),
    (0.251, 0.286, 0.804, 0.056, 0.0, 0.191, 0.07, 0.036, 0.182),
)


@pytest.mark.slow
@pytest.mark.parametrize("unit", range(5))
def test_a_published_lot_comes_out(unit):
    """Rests by hand of five units: all 45 figures within 1.5 u."""
    folder = TESTS / "data" / "mpu-9150" / "rests"
    how = folder / f"procedure-{24 if unit == 3 else 22}.yaml"
    found = calibrate(folder / f"unit-{unit}.csv", procedure=how)
    (triad,) = found.matrix
    S, u = np.array(triad.sensor_from_body), np.array(triad.standard_uncertainty)
    rows, columns = (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 1, 2)
    size = np.repeat([1e-2, np.pi / 180.0, 1.0], 3)
    value = np.concatenate([(S - np.eye(3))[rows, columns], triad.bias])
    off = value - np.array(LOT[unit]) * size
    assert_allclose(off[:6], 0.0, atol=2e-4)
    assert_allclose(off[6:], 0.0, atol=1.5e-3)
    of_u = off / np.concatenate([u[rows, columns], triad.bias_standard_uncertainty])
    assert np.abs(of_u).max() < 1.5


def test_validate_says_before_what_a_run_may_not_show():
    """As calibrate does after it; of a device without noise that it is not told."""
    found = call("validate", "zhao-2019", "six-positions-and-turns")
    assert found.code == 0
    said = " ".join(found.out.split())
    assert "Mistakes that a run with Zhao 2019 optical IMU may not show" in said
    assert "Gyro: azimuths counted the other way" in said


def test_the_correction_gives_back_the_input(folder):
    """As Python, C and YAML: what the unit read in a turn is the turn."""
    words = ("calibrate", str(RUN), "--procedure", "zhao-2019", "--device", "zhao-2019")
    own: dict = {}
    exec(call(*words, "--to", "python").out, own)  # noqa: S102 - what is tested
    reading = np.array([0.000542274525, 0.000900769801, 20.0021196])  # turn z+
    earth = np.degrees(7.292115e-5) * np.sin(np.radians(34.2394))
    assert_allclose(own["gyro"](reading), [0.0, 0.0, 20.0 + earth], rtol=0, atol=1e-4)
    made = yaml.safe_load(call(*words, "--to", "yaml").out)
    inverse, bias = (np.array(made["gyro"][key]) for key in ("inverse", "bias"))
    assert_allclose(inverse @ (reading - bias), own["gyro"](reading), rtol=1e-12)
    assert made["accelerometer"]["input"] == "m/s^2"
    (folder / "c.h").write_text(call(*words, "--to", "c").out, encoding="utf-8")
    if shutil.which("gcc"):
        (folder / "c.c").write_text(
            '#include <stdio.h>\n#include "c.h"\nint main(void) {\n'
            f"double r[3] = {{{', '.join(map(repr, reading.tolist()))}}}, u[3];\n"
            "gyro_correct(r, u); gyro_correct(r, r);  // in place too\n"
            'for (int i = 0; i < 6; ++i) printf("%.17g ", i < 3 ? u[i] : r[i - 3]);\n'
            "return 0; }\n",
            encoding="utf-8",
        )
        subprocess.run(
            ["gcc", "-std=c99", "-Wall", "-Werror", "-Wno-unused", "c.c", "-o", "c"],
            check=True,
        )
        printed = subprocess.run(["./c"], check=True, capture_output=True).stdout
        assert_allclose(
            np.array(printed.split(), dtype=float),
            np.tile(own["gyro"](reading), 2),
            rtol=1e-9,
        )
    assert call(*words, "--to", "cobol").code == 2


def test_a_triad_without_noise_is_calibrated_and_its_soundness_not_told(folder):
    """Of the other it is told; what nobody knows is said."""
    sheet = {**MEMS, "accelerometer": {"errors": {"bias_repeatability": "5 mg"}}}
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    found = calibrate(written(folder, made), procedure="six.yaml", device=sheet)
    assert [one.sensor for one in found.chi_square] == ["gyro"]
    assert any("soundness is not told" in str(one) for one in found.warnings)
    assert found.is_sound is None
    assert {one.sensor for one in found.outputs} == {"gyro", "accelerometer", "imu"}


@pytest.mark.parametrize(("line", "is_sound"), [({}, True), (STATED, False)])
def test_a_unit_is_not_held_against_what_its_sheet_does_not_say(folder, line, is_sound):
    """5000 ppm of a sheet with a nonlinearity alone; a stated tolerance is one."""
    own = dict(MEMS["gyro"]["errors"], scale_factor_nonlinearity="100 ppm")
    del own["scale_factor_repeatability"]
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    rows = [x.split(",") for x in "".join(made.csv()).splitlines()]
    for row in rows[1:]:
        row[2:5] = [f"{1.005 * float(x):.9g}" for x in row[2:5]]
    text = "".join(",".join(row) + "\n" for row in rows)
    (folder / "off.csv").write_text(text, encoding="utf-8")
    sheet = {**MEMS, "gyro": {"errors": {**own, **line}}}
    found = calibrate("off.csv", procedure="six.yaml", device=sheet)
    assert found.is_sound is is_sound


@pytest.mark.parametrize(
    ("factor", "name"), [(np.pi / 180.0, "degrees_radians"), (0.4, None)]
)
def test_a_unit_without_a_tolerance_is_not_far_from_its_gain(folder, factor, name):
    """Nothing is known of it to 10 %: radians are named, 40 % of it is not sound."""
    own = dict(MEMS["gyro"]["errors"])
    del own["scale_factor_repeatability"]
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    rows = [x.split(",") for x in "".join(made.csv()).splitlines()]
    for row in rows[1:]:
        row[2:5] = [f"{factor * float(x):.9g}" for x in row[2:5]]
    text = "".join(",".join(row) + "\n" for row in rows)
    (folder / "off.csv").write_text(text, encoding="utf-8")
    sheet = {**MEMS, "gyro": {"errors": own}}
    found = calibrate("off.csv", procedure="six.yaml", device=sheet)
    assert found.is_sound is False
    assert [x.mistake.name for x in found.looks_like] == ([name] if name else [])
    far = [x for x in found.warnings if "by more than half" in str(x)]
    assert len(far) == 1


def test_limits_beside_lower_bounds_are_not_decided(folder):
    """A sheet without in-run bias: U is a lower bound, and nothing meets by it."""
    (folder / "r.yaml").write_text(
        "name: wide\nreference: as_tested\nlimits:\n  gyro:\n    bias: 100 deg/h\n",
        encoding="utf-8",
    )
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    written(folder, made)
    sheet = {**MEMS, "gyro": {"errors": {**MEMS["gyro"]["errors"]}}}
    del sheet["gyro"]["errors"]["bias_stability"]
    (folder / "less.yaml").write_text(json.dumps(sheet), encoding="utf-8")
    words = (
        "calibrate",
        "run.csv",
        "--procedure",
        "six.yaml",
        "--requirement",
        "r.yaml",
    )
    assert call(*words, "--device", "mems.yaml").code == 0
    found = call(*words, "--device", "less.yaml", "--json", "a.json")
    assert found.code == 1
    assert "whether limits are met is not decided" in " ".join(found.out.split())
    document = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert document["lower_bound"] is True


def test_a_repeatability_that_is_not_given_widens_no_value_of_the_run(folder):
    """It cancels: U is the same and no bound, limits are met, and it is said."""
    (folder / "r.yaml").write_text(
        "name: wide\nreference: as_tested\nlimits:\n  gyro:\n    bias: 100 deg/h\n",
        encoding="utf-8",
    )
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    file = written(folder, made)
    sheet = {**MEMS, "gyro": {"errors": {**MEMS["gyro"]["errors"]}}}
    for name in ("bias", "scale_factor", "mounting"):
        del sheet["gyro"]["errors"][f"{name}_repeatability"]
    rest = {"procedure": "six.yaml", "requirement": "r.yaml"}
    less, whole = (calibrate(file, device=x, **rest) for x in (sheet, "mems.yaml"))
    assert not less.lacks
    assert not less.is_open
    assert not any("lower bound" in str(one) for one in less.warnings)
    for one, other in zip(less.outputs, whole.outputs, strict=True):
        u = (one.standard_uncertainty, other.standard_uncertainty)
        assert_allclose(*u, rtol=1e-5)  # products with it are of second order
        assert one.left_standing == other.left_standing
    (folder / "less.yaml").write_text(json.dumps(sheet), encoding="utf-8")
    words = ("calibrate", "run.csv", "--procedure", "six.yaml", "--requirement")
    found = call(*words, "r.yaml", "--device", "less.yaml")
    assert found.code == 0
    said = " ".join(found.out.split())
    assert "sound, and every parameter is known as well as required" in said


def test_limits_on_other_errors_are_refused():
    """Of the next turn-on, say: the run does not know it, and so nothing is met."""
    words = ("calibrate", str(RUN), "--procedure", "zhao-2019", "--device", "zhao-2019")
    found = call(*words, "--requirement", "navigation-grade")
    assert found.code == 2
    assert "reference next_turn_on" in found.err
    assert call(*words, "--date", "2026-02-30").code == 2


def test_a_triad_that_is_not_recorded_is_said(folder):
    """Sound, and half of the device is not calibrated; another pace is said too."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    rows = [x.split(",")[:5] for x in "".join(made.csv()).splitlines()]
    for row in rows[1:]:
        row[1] = f"{2.0 * float(row[1]):g}"
    (folder / "g.csv").write_text(
        "".join(",".join(row) + "\n" for row in rows), encoding="utf-8"
    )
    found = calibrate("g.csv", procedure="six.yaml", device="mems.yaml")
    said = [str(one) for one in found.warnings]
    assert any("not recorded, and so not calibrated: accelerometer" in x for x in said)
    assert any("windows took 2 times as long as in the procedure" in x for x in said)


# ---- round trip ----------------------------------------------------------------------

SEEDS = 200


@pytest.mark.slow
@pytest.mark.parametrize(
    ("procedure", "device", "seeds"),
    [
        ("zhao-2019", "zhao-2019", SEEDS),
        (SIX, MEMS, SEEDS),
        ("norm-icosahedron", MEMS, SEEDS),
        ("norm-and-turns-by-hand", MEMS, SEEDS // 2),
        ("norm-and-turns-by-hand", "zhao-2019", SEEDS // 4),
    ],
)
def test_intervals_hold_what_was_drawn(procedure, device, seeds, tmp_path, monkeypatch):
    """95 and 68 % of each kind of parameter, p uniform; halved intervals fail."""
    monkeypatch.setattr(module, "unseen_of", lambda *_: ())
    unit = load_device(device)
    how = replace(load_procedure(procedure), sample_rate=2.0)
    every, p = [], {}
    for seed in range(seeds):
        made = simulated_run(unit, procedure=how, means=True, seed=seed)
        found = calibrate(written(tmp_path, made), procedure=how, device=unit)
        every.append(pulls(made, found))
        for what in ("chi_square", "prior"):
            for one in getattr(found, what):
                p.setdefault((one.sensor, what), []).append(one.p)
    off = np.abs(np.array(every))
    n = off.size
    # Values of one run are correlated: three groups of axes are as good as alone.
    for level, reach in ((0.95, norm.isf(0.025)), (0.6827, 1.0)):
        inside = int((off <= reach).sum())
        spread = np.sqrt(n * level * (1.0 - level) * 3.0)
        assert abs(inside - n * level) <= 3.29 * spread, (level, inside / n)
        by_parameter = (off <= reach).sum(axis=0)
        low, high = binom.ppf([5e-5, 1.0 - 5e-5], seeds, level)
        assert (by_parameter >= low).all()
        assert (by_parameter <= high).all()
    assert (off <= norm.isf(0.025) / 2.0).sum() < n * 0.75  # the control
    for key, values in p.items():
        assert kstest(values, "uniform").pvalue > 0.01 / len(p), key


# ---- bad input -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda t: t.replace("turn z+,18,", "turn z+,18,x", 1),
            "2:3: gyro_x [deg/s]: found",
        ),
        (lambda t: t.replace("turn z+,18,", "turn z+,18,nan,", 1), "has 9 fields"),
        (lambda t: t.replace("turn z+,18,", "turn z+,-18,", 1), "of 1 ms or more"),
        (lambda t: t.replace("[deg/s]", "", 1), "without a unit"),
        (lambda t: t.rsplit("\n", 2)[0] + "\n", "has 21 rows, and Zhao 2019 has 22"),
        (lambda t: t[:-1], "has no end of line"),
        (lambda t: t.replace("gyro_y", "gyro_x"), "two columns 'gyro_x'"),
        (lambda t: t.replace("gyro_", "w_"), "did you mean"),
        (lambda t: t.splitlines()[0] + "\n", "has 0 rows"),
    ],
)
def test_what_is_wrong_with_a_table_is_said_at_its_place(tmp_path, change, said):
    """File and line, what was found, what is allowed."""
    text = change(RUN.read_text(encoding="utf-8"))
    path = tmp_path / "r.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((SpecError, CallError)) as caught:
        calibrate(path, procedure="zhao-2019", device="zhao-2019")
    assert said in str(caught.value)


def test_a_window_without_reading_is_refused(tmp_path):
    """Where the procedure uses it; where it does not nothing need stand."""
    lines = RUN.read_text(encoding="utf-8").splitlines()
    cells = lines[7].split(",")
    cells[2] = ""
    lines[7] = ",".join(cells)
    path = tmp_path / "r.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(CallError, match=r"window 7 .* has no reading of gyro_x"):
        calibrate(path, procedure="zhao-2019", device="zhao-2019")


def test_a_run_needs_its_procedure():
    """A name is asked for; what tests nothing is refused."""
    assert call("calibrate", str(RUN)).code == 2
    with pytest.raises(CallError, match="needs procedure="):
        calibrate(RUN)


def test_a_limit_that_is_missed_is_exit_1(tmp_path):
    """Values are written all the same; what is not known well enough is said."""
    (tmp_path / "r.yaml").write_text(
        "name: tight\nreference: as_tested\nlimits:\n  gyro:\n    bias: 0.01 deg/h\n",
        encoding="utf-8",
    )
    words = ("calibrate", str(RUN), "--procedure", "zhao-2019", "--device", "zhao-2019")
    found = call(*words, "--requirement", str(tmp_path / "r.yaml"))
    assert found.code == 1
    assert "3 parameters are not known as well" in " ".join(found.out.split())


# What hostile and careless people write into a table, or cut out of it.
PIECES = (
    *("", ",", ",,", "\n", "\n\n", "\r", "\0", "nan", "inf", "-", "1e999", "1_0", "x"),
    *(
        "[deg/s]",
        "[counts]",
        "[m]",
        "window",
        "gyro_x",
        '"',
        "0,5",
        ";",
        "\ufeff",
        "9" * 400,
    ),
    *(
        "1e-300",
        "1e300",
        "-1",
        "\N{DEGREE SIGN}",
        "#",
        "duration [h]",
        "\u202e",
        "=1+1",
    ),
)
MUTATED = 2000


@pytest.mark.slow
def test_mutated_runs_are_read_or_refused(tmp_path, monkeypatch):
    """Of 2,000 tables none ends otherwise; a refusal says where, or what is missing."""
    monkeypatch.setattr(module, "unseen_of", lambda *_: ())
    text = RUN.read_text(encoding="utf-8")
    random = np.random.default_rng(38)
    unit, how = load_device("zhao-2019"), load_procedure("zhao-2019")
    path = tmp_path / "r.csv"
    read = longest = 0
    for _ in range(MUTATED):
        made = text
        for _ in range(random.integers(1, 4)):
            at, gone = random.integers(len(made) + 1), random.integers(0, 12)
            piece = PIECES[random.integers(len(PIECES))]
            made = made[:at] + piece + made[at + gone :]
        path.write_bytes(made.encode("utf-8", errors="replace"))
        try:
            found = calibrate(path, procedure=how, device=unit)
        except (SpecError, CallError) as error:
            longest = max(longest, len(str(error)))
        else:
            read += 1
            assert all(np.isfinite(one.value) for one in found.outputs)
            json.dumps(found.to_dict(), allow_nan=False)
    assert read > MUTATED / 50
    assert 0 < longest < 4000


@pytest.mark.slow
def test_mutated_recordings_are_read_or_refused(folder):
    """Of a long recording likewise: rows cut, put in, damaged, turned round."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, rate=10.0)
    head, *rows = "".join(made.csv()).splitlines()
    random = np.random.default_rng(39)
    unit, how = load_device("mems.yaml"), load_procedure("six.yaml")
    longest = 0
    for _ in range(200):
        own = list(rows)
        for _ in range(random.integers(1, 4)):
            at = int(random.integers(len(own)))
            n = int(random.integers(1, 200))
            own[at : at + n] = (
                [],
                own[at : at + n] * 2,
                [PIECES[random.integers(len(PIECES))]],
                [one.replace(".", ",") for one in own[at : at + n]],
                [
                    ",".join([one.split(",")[0], *["1e9"] * 6])
                    for one in own[at : at + n]
                ],
            )[random.integers(5)]
        (folder / "r.csv").write_text("\n".join([head, *own]) + "\n", encoding="utf-8")
        try:
            found = calibrate("r.csv", procedure=how, device=unit)
        except (SpecError, CallError) as error:
            longest = max(longest, len(str(error)))
        else:
            json.dumps(found.to_dict(), allow_nan=False)
    assert 0 < longest < 8000


@pytest.mark.slow
def test_without_a_device_turns_are_not_taken_for_dwells(folder):
    """White noise of short turns beside long dwells: 95 % at their rate.

    The residual mean square of both would be a variance that neither has.
    """
    (folder / "white.yaml").write_text(
        "name: White\ngyro:\n  errors:\n    angle_random_walk: 0.3 deg/sqrt(h)\n",
        encoding="utf-8",
    )
    inside: dict[str, list[bool]] = {}
    for seed in range(60):
        made = simulated_run(
            "white.yaml", procedure="six-positions-and-turns", seed=seed, means=True
        )
        found = calibrate(written(folder, made), procedure="six-positions-and-turns")
        for one in found.outputs:
            size = one.coverage_factor * one.standard_uncertainty
            inside.setdefault(one.parameter, []).append(abs(one.value) <= size)
    for parameter, own in inside.items():
        n = 60  # runs: axes of one run may share what is off
        rate = sum(own) / len(own)
        assert rate > 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / n), (parameter, rate)


def test_a_bias_far_from_the_middle_of_counts_is_known_no_better_than_they_are(folder):
    """U of K adds to u of the bias, and nothing to that of the offset."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    rows = written(folder, made).read_text(encoding="utf-8").splitlines()
    head = [one.split(" ")[0] for one in rows[0].split(",")]
    places = [k for k, one in enumerate(head) if one.startswith("gyro")]
    found = {}
    for zero in (0.0, 32768.0):
        text = [
            ",".join(
                f"{one} [counts]" if k in places else all_
                for k, (one, all_) in enumerate(
                    zip(head, rows[0].split(","), strict=True)
                )
            )
        ]
        for row in rows[1:]:
            cells = row.split(",")
            for k in places:
                if cells[k]:
                    cells[k] = repr(float(cells[k]) * 16.4 + zero)
            text.append(",".join(cells))
        path = folder / f"counts-{zero:g}.csv"
        path.write_text("\n".join(text) + "\n", encoding="utf-8")
        found[zero] = calibrate(path, procedure="six.yaml", device="mems.yaml")
    one, other = (found[zero] for zero in (0.0, 32768.0))

    def of(run, parameter):
        return next(
            x
            for x in run.outputs
            if (x.sensor, x.parameter, x.axis) == ("gyro", parameter, "x")
        )

    K = of(other, "scale_factor")
    by_hand = np.hypot(
        of(one, "bias").standard_uncertainty,
        32768.0 * K.standard_uncertainty / K.value**2,
    )
    assert of(other, "bias").standard_uncertainty == pytest.approx(
        by_hand, rel=1e-3, abs=0.0
    )
    offsets = [
        next(x for x in run.matrix if x.sensor == "gyro").bias_standard_uncertainty
        for run in (one, other)
    ]
    assert_allclose(offsets[1], offsets[0], rtol=1e-3)
    assert other.is_sound
    assert all(
        x.prior is None
        for x in other.outputs
        if x.parameter == "bias" and x.sensor == "gyro"
    )


def test_a_run_of_no_more_windows_than_parameters_is_not_told(folder):
    """What least squares leaves nothing of says nothing of the run."""
    (folder / "four.yaml").write_text(
        "name: four\nlatitude: 34.2394 deg\ngravity: normal\n"
        "estimator: least_squares\nwindows:\n"
        + "".join(
            f"  - {{face: {face}, dwell: 10 s, use: accelerometer}}\n"
            for face in ("z up", "z down", "x up", "y up")
        ),
        encoding="utf-8",
    )
    sheet = {k: MEMS[k] for k in MEMS if k != "gyro"}
    (folder / "acc.yaml").write_text(json.dumps(sheet), encoding="utf-8")
    made = simulated_run("acc.yaml", procedure="four.yaml", seed=1, means=True)
    found = calibrate(written(folder, made), procedure="four.yaml", device="acc.yaml")
    assert found.is_sound is None
    assert any("no more windows than parameters" in x for x in found.warnings)


def test_a_limit_that_is_not_judged_is_not_met(folder):
    """Of a sensor that was not recorded: listed, and exit code 1."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    rows = [x.split(",") for x in "".join(made.csv()).splitlines()]
    own = [k for k, one in enumerate(rows[0]) if not one.startswith("gyro")]
    text = "\n".join(",".join(row[k] for k in own) for row in rows)
    (folder / "acc.csv").write_text(text + "\n", encoding="utf-8")
    (folder / "limits.yaml").write_text(
        "name: limits\nreference: as_tested\nlimits:\n  gyro:\n    bias: 1000 deg/h\n",
        encoding="utf-8",
    )
    words = ("calibrate", "acc.csv", "--procedure", "six.yaml", "--device", "mems.yaml")
    found = call(*words, "--requirement", "limits.yaml")
    assert found.code == 1
    assert "cannot judge: gyro bias" in " ".join(found.out.split()).replace(".", " ")


def test_a_channel_that_reads_the_same_in_all_windows_is_refused(folder):
    """It is not connected: no scale factor of -100 % that is known to 1e-11 ppm."""
    made = simulated_run("mems.yaml", procedure="six.yaml", seed=2, means=True)
    rows = [x.split(",") for x in "".join(made.csv()).splitlines()]
    place = next(k for k, one in enumerate(rows[0]) if one.startswith("gyro_x"))
    for row in rows[1:]:
        row[place] = row[place] and "0.25"
    (folder / "dead.csv").write_text(
        "\n".join(map(",".join, rows)) + "\n", encoding="utf-8"
    )
    with pytest.raises(CallError, match="gyro_x reads the same in all windows"):
        calibrate("dead.csv", procedure="six.yaml")
