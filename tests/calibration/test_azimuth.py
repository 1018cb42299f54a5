"""An azimuth that nobody knows: the horizontal earth rate as a source, by hand."""

from __future__ import annotations

from math import cos, pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import binom, chi2

from budget import analyze
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import schedule_of
from budget.calibration.schemes.covariance import joint_covariance
from budget.calibration.simulation import simulate
from budget.earth import ROTATION_RATE
from budget.errors import SpecError
from budget.inputs import load_device, load_procedure
from budget.methods.gum import propagate
from budget.recordings import calibrate as module
from budget.recordings.calibrate import calibrate
from budget.recordings.simulated_run import simulated_run
from budget.units import ARCSEC, DEG_PER_HOUR

LATITUDE = radians(34.2394)
LEVEL = ROTATION_RATE * cos(LATITUDE)  # w_h [rad/s]
FACES = "{face: all, dwell: 60 s}"
GOOD = """\
name: good
gyro: {errors: {angle_random_walk: 0.001 deg/sqrt(h), bias_repeatability: 0.1 deg/h,
  scale_factor_repeatability: 100 ppm, mounting_repeatability: 20 arcsec}}
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Provide what writes a procedure, with a good gyro beside it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "good.yaml").write_text(GOOD, encoding="utf-8")

    def write(windows, azimuth="unknown", estimate="[bias]", more=""):
        text = (
            "name: by hand\nlatitude: 34.2394 deg\ngravity: normal\nsample_rate: 2 Hz\n"
            f"estimate: {{gyro: {estimate}}}\n{more}windows:\n"
        )
        text += "".join(f"  - {one}\n" for one in windows)
        if azimuth:
            text += f"azimuth: {azimuth}\n"
        path = tmp_path / f"{azimuth or 'known'}.yaml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def of_law(path, only="procedure.heading"):
    """Return u of the gyro's outputs by one source, by name [SI]."""
    how, unit = load_procedure(path), load_device("good.yaml")
    problem = calibration_problem(
        unit.sensors,
        how,
        reference="as_tested",
        only=None if only is None else frozenset({only}),
    )
    u = propagate(problem).standard_uncertainty
    return {str(x.name): y for x, y in zip(problem.outputs, u, strict=True)}


def test_a_level_axis_has_it_and_the_vertical_one_none(written):
    """One dwell: 8.792418 deg/h; z is known as it is with a known azimuth."""
    u = of_law(written(["{face: z up, dwell: 60 s}"]))
    assert_allclose(u["gyro.bias.x"] / DEG_PER_HOUR, 8.792418, rtol=1e-6)
    assert_allclose(u["gyro.bias.y"], LEVEL / sqrt(2.0), rtol=1e-12)
    assert u["gyro.bias.z"] == 0.0
    alone = "[bias.z, bias.x]"
    unknown, known = (
        of_law(written(["{face: z up, dwell: 60 s}"], word, alone), None)
        for word in ("unknown", "")
    )
    assert_allclose(unknown["gyro.bias.z"], known["gyro.bias.z"], rtol=1e-9)
    assert unknown["gyro.bias.x"] > 100.0 * known["gyro.bias.x"]


@pytest.mark.parametrize(
    ("azimuth", "parts"),
    [("unknown", (1 / 3, 1 / 3, 1 / 3)), ("zero_unknown", (2 / 3, 1 / 3, 0.0))],
)
def test_six_faces_by_hand(written, azimuth, parts):
    """A bias is the mean of six, of which four are level.

    Four headings: sqrt(4)/6. One: x keeps its direction in all four, 4/6; z goes
    east, west, ... and back; y lies along two of z, and against in none of them.
    """
    u = of_law(written([FACES], azimuth))
    for axis, part in zip("xyz", parts, strict=True):
        found = u[f"gyro.bias.{axis}"]
        assert_allclose(found, part * LEVEL / sqrt(2.0), rtol=1e-9, atol=1e-18)


def test_windows_at_one_stop_have_one_heading(written):
    """Two dwells one after the other: as one; about the vertical: none."""
    u = of_law(written(["{face: z up, dwell: 60 s, repeat: 2}"]))
    assert_allclose(u["gyro.bias.x"], LEVEL / sqrt(2.0), rtol=1e-12)
    round_ = "{face: z up, azimuths: [0 deg, 90 deg, 180 deg, 270 deg], dwell: 60 s}"
    u = of_law(written([round_], "zero_unknown"))
    assert u["gyro.bias.x"] < 1e-15 * LEVEL
    u = of_law(written([round_]))
    assert_allclose(u["gyro.bias.x"], LEVEL / sqrt(8.0), rtol=1e-12)
    turn = "{face: z up, turn: vertical, turns: 1, rate: 20 deg/s, back: true}"
    u = of_law(written([turn], estimate="[scale_factor.z, bias]"))
    assert max(u.values()) < 1e-18


@pytest.mark.parametrize("azimuth", ["unknown", "zero_unknown"])
def test_covariance_of_windows_is_that_of_random_headings(written, azimuth):
    """10,000 headings of each stop, by rotation: no more than 5 % off."""
    how = load_procedure(written([FACES, "{face: x up, dwell: 9 s}"], azimuth))
    (sensor,) = load_device("good.yaml").sensors
    schedule = schedule_of("gyro", how)
    C = joint_covariance(sensor, how, schedule)
    C -= joint_covariance(sensor, load_procedure(written([FACES], "")), schedule)
    rng = np.random.default_rng(5)
    own = list(schedule.stops.values())
    a = rng.uniform(0.0, 2.0 * pi, (10_000, max(own) + 1))
    a = a[:, own] if azimuth == "unknown" else np.tile(a[:, :1], len(own))
    e = LEVEL * np.stack([np.sin(a), np.cos(a), 0.0 * a], axis=-1)
    seen = np.einsum("wij,twj->tiw", schedule.to_body, e).reshape(len(a), -1)
    assert_allclose(C, np.cov(seen.T), rtol=0.0, atol=0.05 * LEVEL**2 / 2.0)


@pytest.mark.slow
@pytest.mark.parametrize("azimuth", ["unknown", "zero_unknown"])
def test_pulses_at_random_headings_agree(written, azimuth):
    """Standard deviations of 400 runs, sample by sample: chi-square at 1e-4."""
    how, unit = load_procedure(written([FACES], azimuth)), load_device("good.yaml")
    runs = [
        simulate(unit.sensors, how, run=k, reference="as_tested") for k in range(400)
    ]
    u = np.array([*of_law(written([FACES], azimuth), None).values()])
    n = len(runs)
    ratio = np.mean(np.square(runs), axis=0) / u**2
    low, high = chi2.ppf([5e-5, 1.0 - 5e-5], n) / n
    assert ((low < ratio) & (ratio < high)).all(), ratio


@pytest.mark.slow
def test_what_a_tilt_makes_of_it(written):
    """By 1 deg about east z takes up w_h/sqrt(2) of it; pulses say the same."""
    path = written(
        ["{face: z up, dwell: 60 s}"],
        estimate="[bias.z]",
        more="station: {levelling: {east: 1 deg}, azimuth: 1 deg}\n",
    )
    u = of_law(path, "station.levelling.east")["gyro.bias.z"]
    assert_allclose(u, radians(1.0) * LEVEL / sqrt(2.0), rtol=1e-3)
    assert of_law(path, "station.azimuth")["gyro.bias.z"] == 0.0
    how, unit = load_procedure(path), load_device("good.yaml")
    only = frozenset({"procedure.heading", "station.levelling.east"})
    runs = [simulate(unit.sensors, how, run=k, only=only) for k in range(400)]
    low, high = chi2.ppf([5e-5, 1.0 - 5e-5], 200) / 200  # products have heavier tails
    assert low < np.mean(np.square(runs)) / u**2 < high


def test_latitude_moves_the_vertical_part_alone(written):
    """+1 arcmin: -3.617010e-3 deg/h of the vertical axis, as where north is known."""
    path = written(
        ["{face: z up, dwell: 60 s}"], more="station: {latitude: 60 arcsec}\n"
    )
    u = of_law(path, "station.latitude")
    assert_allclose(u["gyro.bias.z"] / DEG_PER_HOUR, 3.617010e-3, rtol=1e-6)
    assert u["gyro.bias.x"] < 60.0 * ARCSEC * LEVEL * 1e-9


@pytest.mark.slow
def test_it_is_a_row_of_the_budget(written):
    """It has a name and a share, in `analyze` as in `calibrate`."""
    path = written([FACES])
    found = analyze("good.yaml", procedure=path, reference="as_tested", method="gum")
    row = next(x for x in found.outputs if x.output.name == "gyro.bias.x")
    first = row.ranked[0]
    assert first.source == "procedure.heading"
    assert first.share > 0.99


def recorded(path, seed, name="run.csv"):
    """Write the means of a run."""
    made = simulated_run("good.yaml", procedure=path, means=True, seed=seed, rate=2.0)
    Path(name).write_text("".join(made.csv()), encoding="utf-8")
    return name


def test_a_run_has_the_uncertainty_of_the_budget_and_says_what_it_does_not_show(
    written,
):
    """U is that of the law; mistakes of azimuths are not proposed, and not shown."""
    path = written([FACES])
    found = calibrate(recorded(path, 1), procedure=path, device="good.yaml")
    assert found.is_sound
    u = of_law(path, None)
    for one in found.outputs:
        name = f"{one.sensor}.{one.parameter}.{one.axis}"
        assert_allclose(one.standard_uncertainty, u[name], rtol=1e-9)
    unseen = {one.name: one.probability for one in found.unseen}
    assert unseen["azimuth_sense"] == unseen["window_azimuth"] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("azimuth", ["unknown", "zero_unknown"])
def test_runs_at_random_headings_are_sound_and_not_with_north(
    written, azimuth, monkeypatch
):
    """200 seeds: at most two tests of 0.001 each suspect; by a known azimuth all."""
    monkeypatch.setattr(module, "unseen_of", lambda *_: ())
    path, north = written([FACES], azimuth), written([FACES], "")
    sound = suspect = 0
    for seed in range(200):
        run = recorded(path, seed)
        found = calibrate(run, procedure=path, device="good.yaml")
        sound += found.is_sound
        wrong = calibrate(run, procedure=north, device="good.yaml")
        suspect += not wrong.is_sound
        assert not any("azimuth" in x.mistake.name for x in found.looks_like)
    assert 200 - sound <= binom.ppf(0.9999, 200, 0.002)
    assert suspect == 200


def test_words_that_are_none_are_refused(written):
    """The allowed ones are said."""
    path = written([FACES], "north")
    with pytest.raises(SpecError, match="expected 'unknown' or 'zero_unknown'"):
        load_procedure(path)
