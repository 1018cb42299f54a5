"""The schedule of a procedure to scale: tracks of turns and dwells along time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby
from math import degrees
from typing import TYPE_CHECKING

from budget.calibration.schemes import schedule_accelerometer, schedule_gyro
from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.style import (
    BLUE,
    INK,
    MUTED,
    SMALL,
    TEXT,
    WIDE,
    as_picture,
    canvas,
    capital,
    house_style,
    text_width,
)
from budget.report.tables import print_given
from budget.spec.records import AXES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.model.windows import Window
    from budget.report.blocks import Picture
    from budget.spec.records import Procedure


LEFT, RIGHT, TOP, BELOW = 84.0, 10.0, 4.0, 32.0  # [pt]
BAR, NAMES = 18.0, 18.0  # height of a bar, and of the names of averages below it [pt]
LENS = 54.0  # height of the turns drawn larger, above their bar [pt]
GAP = 10.0  # between triads [pt]
SPAN = WIDE - LEFT - RIGHT  # of the whole time [pt]
AIR = 8.0  # around a name in a bar [pt]
TURN, DWELL = 0.68, 0.18  # opacities of the one hue


@dataclass(frozen=True, kw_only=True)
class Row:
    """Where the windows of a triad are drawn; places on paper in points."""

    axes: Axes
    track: Track
    top: float
    origin: float  # [s] at its left end
    scale: float  # [pt/s]

    def at(self, seconds: float) -> float:
        """Return the place of a moment [pt]."""
        return (seconds - self.origin) * self.scale


def schedule_picture(procedure: Procedure, sensors: Sequence[str]) -> Picture | None:
    """Return the time line of some triads as a block, None where there are none."""
    tracks = make_tracks(procedure, sensors)
    if not tracks:
        return None
    return as_picture(
        schedule_bars(procedure, sensors),
        name="schedule",
        title=schedule_title(procedure, sensors),
        alt=schedule_alt(procedure, sensors),
        tips={
            _gid(track, place): f"{track.sensor}, {window_name(track, place)}: from "
            f"{print_time(window.start)} for {print_time(window.length)}"
            for track in tracks
            for place, window in enumerate(track.windows)
        },
        caption=(
            "To scale; the time of each triad counts from its first window. Turns in "
            "full colour, dwells faint. Below them the averages as formulas name them."
        ),
        data=_data(tracks),
        is_wide=True,
    )


@house_style()
def schedule_bars(procedure: Procedure, sensors: Sequence[str]) -> Figure:
    """Draw turns and dwells to scale; turns too short to name once more, larger."""
    from matplotlib.ticker import MaxNLocator

    tracks = make_tracks(procedure, sensors)
    longest = max(track.end for track in tracks)
    scale = SPAN / longest  # [pt/s]
    heights = [_height(track, scale) for track in tracks]
    inner = sum(heights) + GAP * (len(tracks) - 1)
    figure, axes = canvas(
        TOP + inner + BELOW, left=LEFT, right=RIGHT, top=TOP, below=BELOW, width=WIDE
    )
    figure.set_label(schedule_title(procedure, sensors))
    axes.set_xlim(0.0, SPAN)
    axes.set_ylim(inner, 0.0)
    axes.set_yticks([])
    unit, size = ("h", HOUR) if longest >= IN_HOURS else ("min", MINUTE)
    marks = [
        float(mark)
        for mark in MaxNLocator(nbins=10, steps=[1, 2, 5, 10]).tick_values(
            0.0, longest / size
        )
        if mark * size <= longest
    ]
    axes.set_xticks([mark * size * scale for mark in marks], [f"{m:g}" for m in marks])
    axes.set_xlabel(
        f"time from the first window of the triad [{unit}]",
        fontsize=SMALL,
        color=MUTED,
    )
    top = 0.0
    for track, own in zip(tracks, heights, strict=True):
        _draw_track(axes, track, top, scale)
        top += own + GAP
    return figure


def schedule_title(procedure: Procedure, sensors: Sequence[str]) -> str:
    """State the finding: how long it takes, and what it consists of."""
    texts = []
    for track in make_tracks(procedure, sensors):
        text = f"{track.sensor} {print_time(track.end)}: {made_of(track)}"
        texts.append(
            f"{text}, pauses of {print_time(track.pause)}" if track.pause else text
        )
    return capital("; ".join(texts))


def schedule_alt(procedure: Procedure, sensors: Sequence[str]) -> str:
    """Say in words with numbers what the time line shows."""
    texts = []
    for track in make_tracks(procedure, sensors):
        steps = ", ".join(
            f"{window_name(track, place)} at {print_time(window.start)}"
            for place, window in enumerate(track.windows)
        )
        texts.append(f"{capital(track.sensor)}: {steps}")
    return f"{schedule_title(procedure, sensors)}. {'. '.join(texts)}."


def _needs_lens(track: Track, scale: float) -> bool:
    """Whether a turn is too short for its name; `scale` in pt/s."""
    return any(
        track.windows[k].length * scale < text_width(track.labels[k]) + AIR
        for k in track.turns
    )


def _height(track: Track, scale: float) -> float:
    """Return the height of the bars of a triad [pt]."""
    return BAR + NAMES + (LENS if _needs_lens(track, scale) else 0.0)


def _draw_track(axes: Axes, track: Track, top: float, scale: float) -> None:
    """Draw one triad: its bar, its averages, and where needed its turns larger."""
    enlarged = track.turns if _needs_lens(track, scale) else ()
    bar = top + LENS if enlarged else top
    row = Row(axes=axes, track=track, top=bar, origin=0.0, scale=scale)
    for place in range(len(track.windows)):
        _draw_window(row, place, has_tip=place not in enlarged)
    for average in track.averages:
        if average[1] not in enlarged:
            _draw_average(row, average)
    for text, lift, size, weight, colour in (
        (track.sensor, 5.0, TEXT, "bold", INK),
        (print_time(track.end), -6.5, SMALL, "normal", MUTED),
    ):
        axes.annotate(
            text,
            (0.0, bar + BAR / 2.0),
            xytext=(-8.0, lift),
            textcoords="offset points",
            ha="right",
            va="center_baseline",
            fontsize=size,
            fontweight=weight,
            color=colour,
        )
    if enlarged:
        _draw_lens(row, top)


def _draw_lens(row: Row, top: float) -> None:
    """Draw the turns as wide as their names need, with lines down to their place."""
    track = row.track
    turns = [track.windows[k] for k in track.turns]
    start, end = turns[0].start, turns[-1].start + turns[-1].length
    # A pair of turns carries the name of its average.
    names = [track.labels[k] for k in track.turns]
    named = [name for name, first, _ in track.averages if first in track.turns]
    room = max(
        max(map(text_width, names)) + AIR, max(map(text_width, named)) / 2.0 + AIR
    )
    shortest = min(window.length for window in turns)
    lens = replace(
        row, top=top, origin=start, scale=min(room / shortest, SPAN / (end - start))
    )
    for place in track.turns:
        _draw_window(lens, place, has_tip=True)
    for average in track.averages:
        if average[1] in track.turns:
            _draw_average(lens, average)
    for seconds in (start, end):
        row.axes.plot(
            [lens.at(seconds), row.at(seconds)],
            [top + BAR + NAMES, row.top],
            color=MUTED,
            linewidth=0.6,
            linestyle=(0.0, (2.0, 2.0)),
            clip_on=False,
        )
    times = print_given(lens.scale / row.scale, digits=2)
    row.axes.annotate(
        f"the {len(turns)} turns, {times} times as long",
        (lens.at(end), top + BAR / 2.0),
        xytext=(6.0, 0.0),
        textcoords="offset points",
        fontsize=SMALL,
        color=MUTED,
        va="center_baseline",
    )


def _draw_window(row: Row, place: int, *, has_tip: bool) -> None:
    """Draw one window, named where its name fits."""
    from matplotlib.patches import Rectangle

    window, label = row.track.windows[place], row.track.labels[place]
    start, end = row.at(window.start), row.at(window.start + window.length)
    row.axes.add_patch(
        Rectangle(
            (start, row.top),
            end - start,
            BAR,
            facecolor=BLUE,
            alpha=TURN if place in row.track.turns else DWELL,
            linewidth=0.0,
            gid=_gid(row.track, place) if has_tip else None,
        )
    )
    for x in (start, end):
        row.axes.plot(
            [x, x], [row.top, row.top + BAR], color=INK, linewidth=0.5, clip_on=False
        )
    # Some named and others not would look as if those were something else.
    alike = [
        text
        for k, text in enumerate(row.track.labels)
        if (k in row.track.turns) == (place in row.track.turns)
    ]
    if end - start >= max(map(text_width, alike)) + AIR / 2.0:
        row.axes.text(
            (start + end) / 2.0,
            row.top + BAR / 2.0,
            label,
            fontsize=SMALL,
            color=INK,
            ha="center",
            va="center_baseline",
        )


def _draw_average(row: Row, average: tuple[str, int, int]) -> None:
    """Draw a bracket below the windows of one average, with its name."""
    name, first, last = average
    windows = row.track.windows
    start = row.at(windows[first].start)
    end = row.at(windows[last].start + windows[last].length)
    y = row.top + BAR + 4.0
    row.axes.plot([start + 2.0, end - 2.0], [y, y], color=MUTED, linewidth=0.8)
    short = name.partition(",")[0]
    fitting = next((t for t in (name, short) if text_width(t) <= end - start), "")
    if fitting:
        row.axes.text(
            (start + end) / 2.0,
            y + 2.0,
            fitting,
            fontsize=SMALL,
            color=INK,
            ha="center",
            va="top",
        )


def _data(tracks: Sequence[Track]) -> Table:
    """Return the windows with their times."""
    groups = []
    for track in tracks:
        used = {
            place: name
            for name, first, last in track.averages
            for place in range(first, last + 1)
        }
        rows = tuple(
            (
                Cell(text=window_name(track, place)),
                Cell(text=print_given(window.start, digits=7), exact=window.start),
                Cell(text=print_given(window.length, digits=7), exact=window.length),
                Cell(text=used[place]),
            )
            for place, window in enumerate(track.windows)
        )
        groups.append(RowGroup(title=track.sensor, rows=rows))
    return Table(
        name="schedule-data",
        caption="Turns and dwells with their times",
        columns=(
            Column(head="window"),
            Column(head="start [s]", kind="number"),
            Column(head="length [s]", kind="number"),
            Column(head="average"),
        ),
        groups=tuple(groups),
    )


def _gid(track: Track, place: int) -> str:
    """Name a window."""
    return f"tip-{track.sensor}-{place}"


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
