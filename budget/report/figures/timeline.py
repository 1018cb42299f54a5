"""The schedule of a procedure to scale: tracks of turns and dwells along time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby, pairwise
from math import degrees
from typing import TYPE_CHECKING, Any

from budget.calibration.schemes import schedule_of
from budget.inputs.records import AXES
from budget.report.figures.rows import (
    Bar,
    Chart,
    ChartGroup,
    ChartPanel,
    ChartRow,
    Stroke,
)
from budget.report.figures.style import BLUE, PAPER, WIDE, WIDTH, Scale, fits
from budget.report.figures.tabled import entries
from budget.report.pages import figure, line, sections

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

    from budget.inputs.records import Procedure
    from budget.model.windows import Window
    from budget.report.blocks import Section
    from budget.report.figures.rows import ChartMark

PAGE = "figures_timeline"
BESIDE = 80.0  # of the width that an axis leaves at most [pt]
TURN, DWELL = 0.68, 0.18  # opacities of the one hue
MINUTE, HOUR = 60.0, 3600.0  # [s]
IN_HOURS = 18000.0  # [s] from which times are printed so
FACES = {  # j of N(j): Zhao 2019, eq. (5)
    (axis, sign): 2 * place + (1 if sign > 0 else 2)
    for place, axis in enumerate(("z", "x", "y"))
    for sign in (1, -1)
}
COUNTED_TURNS = {"z": 1, "x": 2, "y": 3}  # j of n_ij: Zhao 2019, eq. (3)
BY_NAME = {"corrected", "paper"}  # formulas with an average for each of their letters
SIGNS = {1: "+", -1: "\N{MINUS SIGN}"}


@dataclass(frozen=True, kw_only=True)
class TriadSchedule:
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
        """Places of the turns."""
        return tuple(k for k, window in enumerate(self.windows) if window.sense)


def schedule_chart(procedure: Procedure, sensors: Sequence[str]) -> Chart | None:
    """Show turns and dwells of some triads to scale, None where there are none.

    Turns that are too short to name are shown once more, larger.
    """
    tracks = make_tracks(procedure, sensors)
    if not tracks:
        return None
    longest = max(track.end for track in tracks)
    unit, size = ("h", HOUR) if longest >= IN_HOURS else ("min", MINUTE)
    said, table = figure(PAGE, "schedule", tracks=tracks, unit=unit)
    whole = Scale(low=0.0, high=longest / size, label=said.label)

    def drawn(width: float) -> Chart:
        """Return the figure of a width [pt]."""
        scale = (width - BESIDE) / longest  # [pt/s]
        groups, panels = [], []
        for track, (_, own) in zip(tracks, entries(table), strict=True):
            rows = partial(_rows, track, [one.tip for one in own], said)
            title = line(PAGE, "track", track=track)
            every = rows(range(len(track.windows)), size=size, scale=scale)
            groups.append(ChartGroup(title=title, rows=every))
            turns = [track.windows[k] for k in track.turns]
            if all(
                fits(track.labels[k], scale * track.windows[k].length)
                for k in track.turns
            ):
                continue
            start, end = turns[0].start, turns[-1].end
            times = longest / (end - start)
            title = line(PAGE, "turns", track=track, times=times)
            group = ChartGroup(
                title=title, rows=rows(track.turns, size=1.0, scale=times * scale)
            )
            enlarged = Scale(low=start, high=end, label=said.seconds)
            panels.append(ChartPanel(scale=enlarged, groups=(group,)))
        return Chart(
            name="schedule",
            title=said.title,
            panels=(*panels, ChartPanel(scale=whole, groups=tuple(groups))),
            table=table,
            caption=said.caption,
            pitch=20.0,
            data_on_paper=bool(procedure.windows),
            width=width,
        )

    return replace(drawn(WIDE), narrow=drawn(WIDTH))


def _rows(
    track: TriadSchedule,
    tips: Sequence[str],
    said: SimpleNamespace,
    places: Sequence[int],
    *,
    size: float,
    scale: float,
) -> tuple[ChartRow, ChartRow]:
    """Return some windows of a triad, and below them the averages taken of them.

    `size` is the unit of the axis [s], `scale` that of the drawing [pt/s].
    """
    averages: list[ChartMark] = []
    for name, first, last in track.averages:
        if first not in places:
            continue
        start, end = track.windows[first].start, track.windows[last].end
        text = name if fits(name, (end - start) * scale) else name.partition(",")[0]
        gap = 2.0 / scale
        averages += [
            Stroke(start=(start + gap) / size, end=(end - gap) / size, lift=-7.0),
            Bar(
                start=start / size,
                end=end / size,
                colour=PAPER,  # no line of the grid runs through its name
                edge="none",
                lift=1.0,
                text=text,
            ),
        ]
    # Some named and others not would look as if those were something else.
    named = {
        is_turn: all(
            fits(label, window.length * scale)
            for window, label in zip(track.windows, track.labels, strict=True)
            if bool(window.sense) == is_turn
        )
        for is_turn in (False, True)
    }
    windows = [
        Bar(
            start=window.start / size,
            end=window.end / size,
            colour=BLUE,
            opacity=TURN if window.sense else DWELL,
            height=18.0,
            text=track.labels[place] if named[bool(window.sense)] else "",
            tip=tips[place],
        )
        for place in places
        for window in [track.windows[place]]
    ]
    return (
        ChartRow(label=said.windows, marks=tuple(windows)),
        ChartRow(label=said.averages, marks=tuple(averages)),
    )


TEXT_TRACK = 38  # characters that the longest test is drawn with
MOST_DRAWN = 100  # windows that are drawn one by one


def schedule_sections(
    procedure: Procedure, sensors: Sequence[str]
) -> tuple[Section, ...]:
    """Draw the schedule of each triad as text: '#' turns, '=' stands."""
    tracks = make_tracks(procedure, sensors)
    scale = TEXT_TRACK / max((track.end for track in tracks), default=1.0)
    return sections("schedule", tracks=tracks, scale=scale, most_drawn=MOST_DRAWN)


def make_tracks(
    procedure: Procedure, sensors: Sequence[str]
) -> tuple[TriadSchedule, ...]:
    """Lay out the windows of the triads that there are, gyro first."""
    found = []
    for sensor in ("gyro", "accelerometer"):
        if sensor not in sensors:
            continue
        windows = schedule_of(sensor, procedure).windows
        own = TriadSchedule(
            sensor=sensor,
            windows=windows,
            labels=tuple(window.name.partition(",")[0] for window in windows),
            averages=(
                (
                    line(PAGE, "average", formulas=procedure.formulas),
                    0,
                    len(windows) - 1,
                ),
            ),
            pause=min([b.start - a.end for a, b in pairwise(windows)], default=0.0),
        )
        if not procedure.windows and procedure.formulas in BY_NAME:
            named = _gyro_named if sensor == "gyro" else _accelerometer_named
            own = replace(own, **named(procedure, windows))
        found.append(own)
    return tuple(found)


def print_time(seconds: float) -> str:
    """Print a time that was given: '18 s', '5 min', '2.5 h'."""
    return line(PAGE, "time", seconds=seconds)


def made_of(track: TriadSchedule) -> str:
    """Say what a test consists of: '6 turns of 18 s and 4 dwells of 5 min'."""
    return line(PAGE, "made_of", track=track)


def _gyro_named(procedure: Procedure, windows: Sequence[Window]) -> dict[str, Any]:
    """Name turns, a pair for each axis, and the dwells at all azimuths."""
    name = partial(line, PAGE, "turns_average")
    dwells = line(PAGE, "dwells_average", azimuths=procedure.gyro.azimuths)
    pairs = enumerate(procedure.gyro.order)
    return {
        "labels": tuple(map(_gyro_label, windows)),
        "averages": (
            *((name(number=COUNTED_TURNS[a]), 2 * k, 2 * k + 1) for k, a in pairs),
            (dwells, sum(bool(one.sense) for one in windows), len(windows) - 1),
        ),
        "pause": procedure.gyro.pause,
    }


def _gyro_label(window: Window) -> str:
    """Return axis and sense of a turn, or the azimuth of a dwell."""
    if window.azimuth is not None:
        return f"{degrees(window.azimuth):.4g}\N{DEGREE SIGN}"
    if not window.sense:
        return window.name[:-2]  # without the number of the visit
    return f"{AXES[window.axis or 0]} {SIGNS[window.sign]}"


def _accelerometer_named(
    procedure: Procedure, windows: Sequence[Window]
) -> dict[str, Any]:
    """Name the faces, each held twice."""
    faces = [(AXES[window.axis or 0], window.sign) for window in windows]
    runs = [[*own] for _, own in groupby(range(len(faces)), key=lambda k: faces[k])]
    return {
        "labels": tuple(
            line(PAGE, "face", axis=axis, sign=sign) for axis, sign in faces
        ),
        "averages": tuple((f"N({FACES[faces[k[0]]]})", k[0], k[-1]) for k in runs),
        "pause": procedure.accelerometer.pause,
    }
