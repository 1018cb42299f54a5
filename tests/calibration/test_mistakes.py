"""Mistakes of recorded calibrations: planted, found by their names, rarely without."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import binom, chi2, ncx2

from budget.calibration.mistakes import (
    SUSPECT,
    Mistake,
    TriadRun,
    inputs_of,
    moved_to,
    prior_of,
    seen_with,
)
from budget.calibration.schemes import schedule_of
from budget.inputs import load_device, load_procedure

MEMS = {
    "format": "budget-device/1",
    "name": "MEMS",
    "gyro": {
        "errors": {
            "bias_repeatability": "200 deg/h",
            "scale_factor_repeatability": "2000 ppm",
            "mounting_repeatability": "400 arcsec",
            "angle_random_walk": "0.3 deg/sqrt(h)",
            "bias_stability": {
                "value": "3 deg/h",
                "definition": "sigma",
                "correlation_time": "100 s",
            },
        }
    },
    "accelerometer": {
        "errors": {
            "bias_repeatability": "5 mg",
            "scale_factor_repeatability": "2000 ppm",
            "mounting_repeatability": "400 arcsec",
            "velocity_random_walk": "0.05 m/s/sqrt(h)",
            "bias_stability": {
                "value": "50 ug",
                "definition": "sigma",
                "correlation_time": "100 s",
            },
        }
    },
}
DEVICES = {"zhao-2019": "zhao-2019", "MEMS": MEMS}
PROCEDURES = ("zhao-2019", "six-positions-and-turns")
PLANTS, SOUND = 40, 200
# Named first, or among those that it is not told from, in all of 40.
ALWAYS = (
    *("earth_rate_sign", "earth_rate_missing", "turn_sense", "axes_swapped"),
    *("axes_rotated", "axis_reversed", "degrees_radians", "gravity_unit"),
    *("per_sample", "window_turn_sense"),
)


class Plants:
    """Runs of one triad, drawn of all that the budget knows, by plain numpy."""

    def __init__(self, device, procedure, kind, seed=1):
        """Draw from one seed."""
        unit, how = load_device(DEVICES[device]), load_procedure(procedure)
        self.sensor = next(one for one in unit.sensors if one.kind == kind)
        self.how = how
        schedule = schedule_of(kind, how)
        n = len(schedule.windows)
        self.run = TriadRun.of(
            self.sensor, how, schedule, np.zeros((3, n)), range(1, n + 1)
        )
        self.rng = np.random.default_rng(seed)
        self.spread = np.linalg.cholesky(np.linalg.inv(self.run.information))
        self.noise = np.linalg.cholesky(self.run.covariance)

    def draw(self, mistake=None):
        """Return a run with a mistake, or a sound one."""
        mistake = mistake or Mistake(name="")
        run, normal = self.run, self.rng.normal
        p = run.nominal.ravel() + self.spread @ normal(size=12)
        y = run.columns_of(mistake) @ p + self.noise @ normal(size=run.readings.size)
        return replace(run, readings=mistake.done(y.reshape(3, -1)))

    def planted(self, name):
        """Return mistakes of a name that are seen at all."""
        own = [x for x in self.run.known if x.name == name and self.run.is_seen(x)]
        return [own[k] for k in self.rng.integers(len(own), size=PLANTS)] if own else []


def named(run):
    """Return what a run looks like: the first, and those it is not told from."""
    found = run.looks_like
    return [] if found is None else [found.mistake, *found.also]


def is_one_of(mistake, others):
    """Whether it is among others, whatever size was fitted."""
    return any((x.name, x.what) == (mistake.name, mistake.what) for x in others)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("device", "procedure", "kind"),
    [
        ("zhao-2019", "zhao-2019", "gyro"),
        ("MEMS", "six-positions-and-turns", "gyro"),
        ("zhao-2019", "six-positions-and-turns", "accelerometer"),
        ("MEMS", "zhao-2019", "accelerometer"),
    ],
)
def test_planted_mistakes_are_named(device, procedure, kind):
    """Of 40 of each that changes every reading all are named, with what it is."""
    plants = Plants(device, procedure, kind)
    for name in ALWAYS:
        for mistake in plants.planted(name):
            assert is_one_of(mistake, named(plants.draw(mistake))), (name, mistake.what)


@pytest.mark.slow
def test_faces_and_orders_are_named():
    """A wrong face of a dwell, or two of them exchanged, is named in 39 of 40."""
    for device, procedure, kind, least in (
        ("zhao-2019", "zhao-2019", "accelerometer", 39),
        ("MEMS", "six-positions-and-turns", "accelerometer", 39),
        ("zhao-2019", "six-positions-and-turns", "gyro", 37),
    ):
        plants = Plants(device, procedure, kind, seed=2)
        found = [
            is_one_of(one, named(plants.draw(one)))
            for one in plants.planted("window_face")
        ]
        assert sum(found) >= least, (device, procedure, kind, sum(found))


@pytest.mark.slow
def test_sound_runs_are_sound():
    """Of 1,600 sound runs no more are suspect than two tests at 0.001 would have."""
    alarms = sum(
        not plants.draw().is_sound
        for device in DEVICES
        for procedure in PROCEDURES
        for kind in ("gyro", "accelerometer")
        for plants in [Plants(device, procedure, kind, seed=3)]
        for _ in range(SOUND)
    )
    assert alarms <= binom.isf(1e-3, 8 * SOUND, 2.0 * SUSPECT)


def test_halved_noise_is_suspect():
    """The control: of a device with half the noise in its file runs are not sound."""
    plants = Plants("zhao-2019", "zhao-2019", "gyro")
    half = replace(plants.run, covariance=plants.run.covariance / 4.0)
    runs = 20
    found = [replace(half, readings=plants.draw().readings) for _ in range(runs)]
    # Of 18 degrees a quarter of the limit is not reached by one in 200.
    missed = chi2.cdf(chi2.isf(SUSPECT, 18) / 4.0, 18)
    most = binom.isf(1e-3, runs, missed)
    assert sum(one.is_sound for one in found) <= most < runs / 2


def test_a_latitude_is_found_wherever_it_is():
    """39.9 for 34.2 deg, and -60, by the gyro's readings; of a device of the paper."""
    for degrees in (39.9, -60.0):
        plants = Plants("zhao-2019", "zhao-2019", "gyro")
        place = moved_to(plants.run.place, radians(degrees))
        found = named(plants.draw(Mistake(name="latitude", place=place)))
        assert found[0].name == "latitude"
        assert_allclose(dict(found[0].what)["value"], degrees, rtol=0, atol=0.2)


def test_a_reading_that_is_off_is_named_with_its_size():
    """Motion in a window adds to one axis what is named, to its noise."""
    plants = Plants("zhao-2019", "zhao-2019", "gyro")
    sound = plants.draw()
    readings = sound.readings.copy()
    readings[1, 7] += 1e-5  # 2 deg/h of rad/s, of dwells with some 0.05
    found = named(replace(sound, readings=readings))
    what = dict(found[0].what)
    assert (found[0].name, what["window"], what["axis"]) == ("window_motion", 8, "y")
    assert_allclose(what["value"], 1e-5, rtol=0.1)


def test_what_cannot_be_seen_is_known_before():
    """Azimuths that are all 0, and an accelerometer's azimuth, change no reading."""
    six = Plants("MEMS", "six-positions-and-turns", "gyro").run
    assert {x.name for x in six.known if not six.is_seen(x)} == {"azimuth_sense"}
    accelerometer = Plants("zhao-2019", "zhao-2019", "accelerometer").run
    unseen = {x.name for x in accelerometer.known if not accelerometer.is_seen(x)}
    assert unseen == {"azimuth_sense", "window_azimuth", "windows_order"}
    # Gravity of the place of an axis that is known to 2000 ppm, 200 times the change.
    mems = Plants("MEMS", "six-positions-and-turns", "accelerometer").run
    (gravity,) = [x for x in mems.known if x.name == "gravity"]
    assert mems.shown(gravity) < 0.01


def test_what_is_shown_is_as_often_seen():
    """The probability that is told before is the frequency of being suspect."""
    plants = Plants("MEMS", "zhao-2019", "gyro", seed=5)
    (sign,) = [x for x in plants.run.known if x.name == "latitude_sign"]
    p = plants.run.shown(sign)
    runs = 200
    seen = sum(not plants.draw(sign).is_sound for _ in range(runs))
    # Drawn units differ from the nominal one, for which p is: 4 standard deviations.
    assert abs(seen - runs * p) <= 4.0 * (runs * p * (1.0 - p)) ** 0.5 + 0.05 * runs
    assert_allclose(
        seen_with(30.0, 12), ncx2.sf(32.909490407360204, 12, 30.0), rtol=1e-9
    )


def test_the_sense_of_azimuths_is_their_order():
    """In the paper's test both have the same inputs: it says A or B."""
    plants = Plants("zhao-2019", "zhao-2019", "gyro")
    (sense,) = [x for x in plants.run.known if x.name == "azimuth_sense"]
    assert {x.name for x in named(plants.draw(sense))} >= {
        "azimuth_sense",
        "windows_order",
    }


def test_the_joint_covariance_has_that_of_each_axis():
    """By blocks it is that of least squares' weights, to rounding."""
    from budget.calibration.schemes.covariance import covariances_of, joint_covariance
    from budget.model.scheme import Held

    unit = load_device(MEMS)
    how = load_procedure("six-positions-and-turns")
    schedule = schedule_of("gyro", how)
    none = Held(which=np.zeros((3, 4), dtype=bool), value=np.zeros((3, 4)))
    joint = joint_covariance(unit.gyro, how, schedule)
    n = len(schedule.windows)
    for axis, own in enumerate(covariances_of(unit.gyro, how, schedule, none)):
        part = joint[axis * n : (axis + 1) * n, axis * n : (axis + 1) * n]
        assert_allclose(part, own, rtol=1e-9, atol=1e-11 * np.abs(own).max())


def test_inputs_are_those_of_the_table():
    """A face up reads the vertical earth rate, a turn its rate besides."""
    how = load_procedure("six-positions-and-turns")
    windows = schedule_of("gyro", how).windows
    u = inputs_of("gyro", windows, how.place)
    vertical = 7.292115e-5 * np.sin(how.latitude)
    assert_allclose(u[0, 2], vertical, rtol=1e-12)
    assert_allclose(u[1, 2], -vertical, rtol=1e-12)
    assert_allclose(u[6, 2], vertical + radians(20.0), rtol=1e-12)


def test_what_nothing_is_given_of_is_wide():
    """A parameter without a line is not known to be nominal."""
    sheet = {
        "format": "budget-device/1",
        "name": "bare",
        "gyro": {"errors": {"bias_repeatability": "1 deg/h"}},
    }
    prior = prior_of(load_device(sheet).gyro, 1.0)
    assert prior.is_known.tolist() == [False] * 9 + [True] * 3
    assert (prior.u[:9] >= 0.1).all()


@pytest.mark.parametrize("has_tolerance", [False, True])
def test_a_nonlinearity_is_no_tolerance_of_a_scale_factor(has_tolerance):
    """A sheet with that alone knows nothing of it; beside a tolerance it adds to it."""
    errors = dict(MEMS["gyro"]["errors"], scale_factor_nonlinearity="100 ppm")
    if not has_tolerance:
        del errors["scale_factor_repeatability"]
    sheet = {**MEMS, "gyro": {"errors": errors}}
    prior = prior_of(load_device(sheet).gyro, 1.0)
    u = np.hypot(2000e-6, 100e-6) if has_tolerance else 0.1
    assert prior.is_known[:3].tolist() == [has_tolerance] * 3
    assert_allclose(prior.u[:3], u, rtol=1e-12)
