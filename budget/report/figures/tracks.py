"""Turns and dwells of each triad with their names and averages, for a time line."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from math import degrees
from typing import TYPE_CHECKING

from budget.calibration.schemes import schedule_accelerometer, schedule_gyro
from budget.report.tables import print_given
from budget.spec.records import AXES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.model.windows import Window
    from budget.spec.records import Procedure

MINUTE, HOUR = 60.0, 3600.0  # [s]
IN_MINUTES, IN_HOURS = 120.0, 18000.0  # [s] from which times are printed so
FACES = {  # j of N(j): Zhao 2019, eq. (5)
    (axis, sign): 2 * place + (1 if sign > 0 else 2)
    for place, axis in enumerate(("z", "x", "y"))
    for sign in (1, -1)
}
COUNTED_TURNS = {"z": 1, "x": 2, "y": 3}  # j of n_ij: Zhao 2019, eq. (3)
SIGNS = {1: "+", -1: "\N{MINUS SIGN}"}


@dataclass(frozen=True, kw_only=True)
class Track:
    """The windows of one triad, and the averages that are taken of them."""

    sensor: str
    windows: tuple[Window, ...]
    labels: tuple[str, ...]  # as they stand in the bars
    averages: tuple[tuple[str, int, int], ...]  # name, first and last window
    pause: float  # [s]

    @property
    def end(self) -> float:
        """When the last window ends [s]."""
        return self.windows[-1].start + self.windows[-1].length

    @property
    def turns(self) -> tuple[int, ...]:
        """Places of the turns; a gyro turns where its axis is named."""
        if self.sensor != "gyro":
            return ()
        return tuple(k for k, window in enumerate(self.windows) if window.sign)


def make_tracks(procedure: Procedure, sensors: Sequence[str]) -> tuple[Track, ...]:
    """Lay out the triads that there are, gyro first."""
    makers = {"gyro": _gyro_track, "accelerometer": _accelerometer_track}
    return tuple(make(procedure) for name, make in makers.items() if name in sensors)


def print_time(seconds: float) -> str:
    """Print a time that was given: '18 s', '5 min', '2.5 h'."""
    if seconds >= IN_HOURS:
        return f"{print_given(seconds / HOUR)} h"
    if seconds >= IN_MINUTES:
        return f"{print_given(seconds / MINUTE)} min"
    return f"{print_given(seconds)} s"


def made_of(track: Track) -> str:
    """Say what a test consists of: '6 turns of 18 s and 4 dwells of 5 min'."""
    turns = [track.windows[k] for k in track.turns]
    dwells = [w for k, w in enumerate(track.windows) if k not in set(track.turns)]
    parts = [
        f"{len(windows)} {word} of {print_time(windows[0].length)}"
        for windows, word in ((turns, "turns"), (dwells, "dwells"))
        if windows
    ]
    return " and ".join(parts)


def window_name(track: Track, place: int) -> str:
    """Name one window in words: 'turn about z+'."""
    window = track.windows[place]
    if window.azimuth is not None:
        return f"dwell at azimuth {degrees(window.azimuth):.6g} deg"
    if track.sensor == "gyro":
        return f"turn about {window.name.removeprefix('turn ')}"
    return f"dwell with {window.name}"


def _gyro_track(procedure: Procedure) -> Track:
    """Lay out turns, a pair for each axis, and the dwells at all azimuths."""
    windows = schedule_gyro(procedure.gyro).windows
    turns = [window for window in windows if window.axis is not None]
    labels = [_gyro_label(window) for window in windows]
    averages = [
        (f"n, j = {COUNTED_TURNS[axis]}", 2 * place, 2 * place + 1)
        for place, axis in enumerate(procedure.gyro.order)
    ]
    averages.append(("N, mean of all azimuths, z up", len(turns), len(windows) - 1))
    return Track(
        sensor="gyro",
        windows=windows,
        labels=tuple(labels),
        averages=tuple(averages),
        pause=procedure.gyro.pause,
    )


def _gyro_label(window: Window) -> str:
    """Return axis and sense of a turn, or the azimuth of a dwell."""
    if window.azimuth is not None:
        return f"{degrees(window.azimuth):.4g}\N{DEGREE SIGN}"
    return f"{AXES[window.axis or 0]} {SIGNS[window.sign]}"


def _accelerometer_track(procedure: Procedure) -> Track:
    """Lay out the faces, each held twice."""
    windows = schedule_accelerometer(procedure.accelerometer).windows
    faces = [(AXES[window.axis or 0], window.sign) for window in windows]
    averages = []
    for face, own in groupby(range(len(windows)), key=lambda place: faces[place]):
        places = list(own)
        averages.append((f"N({FACES[face]})", places[0], places[-1]))
    return Track(
        sensor="accelerometer",
        windows=windows,
        labels=tuple(f"{axis} {'up' if sign > 0 else 'down'}" for axis, sign in faces),
        averages=tuple(averages),
        pause=procedure.accelerometer.pause,
    )
