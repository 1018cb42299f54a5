"""Recordings with a slip of their user in them, which is told, and sound ones."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import put

from budget.earth import meridian_radius, normal_radius
from budget.inputs import load_mission
from budget.inputs.trajectory import ground
from budget.studies.cautions import of_no_vehicle
from budget.units import STANDARD_GRAVITY

COLUMNS = ("time", "latitude", "longitude", "height", "roll", "pitch", "heading")
UNITS = {"time": "s", "height": "m"}
ROWS, DT = 400, 1.0
KINDS = ("aircraft", "car", "ship", "drone")
SOUND = 50  # random trajectories of each kind


def wave(rng, t, size):
    """Return a smooth random function of time, of about that size."""
    periods = rng.uniform(40.0, 200.0, 3)
    phases, sizes = rng.uniform(0.0, 2.0 * np.pi, 3), rng.normal(size=3)
    parts = np.sin(2.0 * np.pi * t[:, None] / periods + phases)
    return size * parts @ sizes / np.sqrt(3.0)


def trajectory(kind, seed):
    """Return the columns of a sound recording, angles in deg.

    An aircraft leans into its turns, a car a little out of them, a ship out of them and
    with the slope of waves that it meets or that overtake it; a drone as it likes.
    """
    rng = np.random.default_rng([KINDS.index(kind), seed])
    t = DT * np.arange(ROWS)
    speed = {
        "aircraft": rng.uniform(50.0, 230.0),
        "car": rng.uniform(8.0, 40.0),
        "ship": rng.uniform(4.0, 15.0),
        "drone": rng.uniform(5.0, 20.0),
    }[kind] * (1.0 + 0.05 * np.tanh(wave(rng, t, 1.0)))
    most = {"aircraft": 3.0, "car": 2.5, "ship": 0.4, "drone": 4.0}[kind]  # [m/s^2]
    aside = np.clip(wave(rng, t, most), -2.0 * most, 2.0 * most)
    turning = aside / speed
    heading = rng.uniform(0.0, 6.0) + np.cumsum(turning) * DT
    slope = np.clip(wave(rng, t, 0.06), -0.15, 0.15)  # of the path
    lean = np.arctan(aside / STANDARD_GRAVITY)
    roll, pitch = {
        "aircraft": (lean, np.arctan(slope) + rng.uniform(0.0, 0.08)),
        "car": (-0.08 * lean, np.arctan(slope)),
        "ship": (rng.uniform(-4.0, 0.0) * lean, np.arctan(slope)),
        "drone": (wave(rng, t, 0.15), wave(rng, t, 0.15)),
    }[kind]
    if kind == "ship":  # the slope met by the speed of the waves: 5 to 15 s
        swell = 0.05 * np.sin(2.0 * np.pi * t / rng.uniform(6.0, 15.0))
        waves = rng.uniform(7.0, 23.0) * rng.choice([-1.0, 1.0])
        pitch = np.arctan(swell)
        slope = swell * (speed + waves) / speed
    height = rng.uniform(200.0, 9000.0) + np.cumsum(speed * slope) * DT
    north, east = speed * np.cos(heading), speed * np.sin(heading)
    latitude = [radians(rng.uniform(-65.0, 65.0))]
    longitude = [radians(rng.uniform(-170.0, 170.0))]
    for k in range(ROWS - 1):
        here = latitude[-1]
        a = meridian_radius(here) + height[k]
        b = (normal_radius(here) + height[k]) * np.cos(here)
        latitude.append(here + 0.5 * (north[k] + north[k + 1]) * DT / a)
        longitude.append(longitude[-1] + 0.5 * (east[k] + east[k + 1]) * DT / b)
    noise = rng.normal(scale=radians(0.2), size=(2, ROWS))
    return dict(
        zip(
            COLUMNS,
            (
                t,
                np.degrees(latitude),
                np.degrees(longitude),
                height,
                np.degrees(roll + noise[0]),
                np.degrees(pitch + noise[1]),
                np.degrees(heading) % 360.0,
            ),
            strict=True,
        )
    )


@pytest.fixture
def said(tmp_path):
    """Return a function that writes columns and says what is doubted of them."""

    def of(columns):
        heads = ",".join(f"{name} [{UNITS.get(name, 'deg')}]" for name in columns)
        rows = zip(*columns.values(), strict=True)
        lines = [",".join(f"{one:.12g}" for one in row) for row in rows]
        (tmp_path / "t.csv").write_text("\n".join([heads, *lines]) + "\n")
        path = put(
            tmp_path / "m.yaml",
            "format: budget-mission/1\nmission: {trajectory: t.csv}\n",
        )
        return of_no_vehicle(load_mission(path))

    return of


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_sound_recording_is_not_doubted(said, kind):
    """Random ones of each kind, with and without a heading."""
    for seed in range(SOUND):
        columns = trajectory(kind, seed)
        if seed % 2:
            del columns["heading"]
        assert said(columns) == (), seed


def test_the_recordings_are_what_they_say():
    """The track on the ground has the speed and the turns that they were made of."""
    columns = trajectory("aircraft", 3)
    place = [np.radians(columns[name]) for name in ("latitude", "longitude")]
    north, east = (np.gradient(x, DT) for x in ground(*place, columns["height"]))
    heading = np.degrees(np.arctan2(east, north)) % 360.0
    off = (heading - columns["heading"] + 180.0) % 360.0 - 180.0
    assert_allclose(off[1:-1], 0.0, rtol=0, atol=0.5)


def swapped(columns):
    """Return it with latitude for longitude and no heading, within bounds."""
    shift = -0.5 * columns["longitude"][0]  # to less than 85 deg
    found = columns | {
        "latitude": columns["longitude"] + shift,
        "longitude": columns["latitude"],
    }
    return {name: one for name, one in found.items() if name != "heading"}


SLIPS = {
    "latitude for longitude": (swapped, "roll", "latitude and longitude swapped"),
    "the left side down": (
        lambda columns: columns | {"roll": -columns["roll"]},
        "roll",
        "left side down",
    ),
    "roll in rad": (
        lambda columns: columns | {"roll": np.radians(columns["roll"])},
        "roll",
        "numbers rad, under [deg]",
    ),
    "pitch in rad": (
        lambda columns: columns | {"pitch": np.radians(columns["pitch"])},
        "pitch",
        "numbers rad, under [deg]",
    ),
    "nose down": (
        lambda columns: columns | {"pitch": -columns["pitch"]},
        "pitch",
        "nose down",
    ),
    "height in ft": (
        lambda columns: columns | {"height": columns["height"] / 0.3048},
        "pitch",
        "height ft, under [m]",
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_of_an_aircraft_is_told(said, slip):
    """In nine of ten recordings at least: some fly too straight to tell.

    Latitude for longitude stretches the track, the more the farther north it is.
    """
    make, name, words = SLIPS[slip]
    told = [said(make(trajectory("aircraft", seed))) for seed in range(20)]
    least = 12 if make is swapped else 18
    assert sum(any(words in one for one in found) for found in told) >= least
    assert all(
        one.startswith(f"trajectory.{name}:")
        for found in told
        for one in found
        if "times what the track" in one
    )


def test_a_height_that_no_aircraft_reaches_may_be_feet(said):
    """Flight level 350 is 10.7 km, and 35 km under [m]."""
    columns = trajectory("aircraft", 1)
    del columns["pitch"]
    level = columns | {"height": 0.0 * columns["height"] + 35_000.0}
    (text,) = said(level)
    assert "35000 m" in text
    assert "ft" in text
    assert not said(columns | {"height": 0.0 * columns["height"] + 25_900.0})
