"""The schedule of a procedure to scale: tracks of turns and dwells along time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from math import degrees
from typing import TYPE_CHECKING

from budget.calibration.schemes import schedule_of
from budget.calibration.schemes.zhao_2019 import (
    schedule_accelerometer,
)
from budget.inputs.records import AXES
from budget.language import counted, say, term
from budget.report.blocks import Cell, Field, Section, table_of
from budget.report.figures.rows import (
    Bar,
    Chart,
    Group,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import BLUE, PAPER, WIDE, fits
from budget.report.tables import print_given
from budget.report.wording import capital

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Procedure
    from budget.model.windows import Window
    from budget.report.blocks import Table
    from budget.report.figures.rows import Mark

SPAN = WIDE - 80.0  # of an axis at least [pt]
TURN, DWELL = 0.68, 0.18  # opacities of the one hue
MINUTE, HOUR = 60.0, 3600.0  # [s]
IN_MINUTES, IN_HOURS = 120.0, 18000.0  # [s] from which times are printed so
FACES = {  # j of N(j): Zhao 2019, eq. (5)
    (axis, sign): 2 * place + (1 if sign > 0 else 2)
    for place, axis in enumerate(("z", "x", "y"))
    for sign in (1, -1)
}
COUNTED_TURNS = {"z": 1, "x": 2, "y": 3}  # j of n_ij: Zhao 2019, eq. (3)
BY_NAME = {"corrected", "paper"}  # formulas with an average for each of their letters
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
    whole = Scale(
        low=0.0,
        high=longest / size,
        label=say("time from the first window of the triad [{unit}]", unit=unit),
    )
    panels = [
        panel for track in tracks for panel in _enlarged(track, SPAN / longest)
    ] + [
        Panel(
            scale=whole,
            groups=tuple(
                Group(
                    title=say(
                        "{sensor}, {end}",
                        sensor=say(track.sensor),
                        end=print_time(track.end),
                    ),
                    said=capital(say(track.sensor)),
                    rows=_rows(track, range(len(track.windows)), size, SPAN / longest),
                )
                for track in tracks
            ),
        )
    ]
    return Chart(
        name="schedule",
        title=_title(tracks),
        sides=(Side(panels=tuple(panels)),),
        caption=(
            say(
                "To scale; the time of each triad counts from its first window. "
                "Turns in full colour, dwells faint. Below them the averages as "
                "formulas name them."
            )
        ),
        pitch=20.0,
        data=_data(tracks),
        data_on_paper=bool(procedure.windows),
        width=WIDE,
    )


def _title(tracks: Sequence[Track]) -> str:
    """State the finding: how long it takes, and what it consists of."""
    texts = []
    for track in tracks:
        text = say(
            "{sensor} {end}: {made_of}",
            sensor=say(track.sensor),
            end=print_time(track.end),
            made_of=made_of(track),
        )
        texts.append(
            say("{text}, pauses of {pause}", text=text, pause=print_time(track.pause))
            if track.pause
            else text
        )
    return capital(say("; ").join(texts))


def _enlarged(track: Track, scale: float) -> tuple[Panel, ...]:
    """Return the turns on an axis of their own where one is too short for its name.

    `scale` is that of the whole [pt/s].
    """
    turns = [track.windows[k] for k in track.turns]
    if all(fits(track.labels[k], track.windows[k].length * scale) for k in track.turns):
        return ()
    start, end = turns[0].start, turns[-1].start + turns[-1].length
    times = print_given(SPAN / (end - start) / scale, digits=2)
    rows = _rows(track, track.turns, 1.0, SPAN / (end - start))
    title = say(
        "{sensor}, the {turns} turns, {times} times as long",
        sensor=say(track.sensor),
        turns=len(turns),
        times=times,
    )
    return (
        Panel(
            scale=Scale(low=start, high=end, label=say("time [s]")),
            groups=(
                Group(
                    title=title,
                    rows=tuple(replace(row, said="") for row in rows),
                ),
            ),
        ),
    )


def _rows(
    track: Track, places: Sequence[int], size: float, scale: float
) -> tuple[Row, Row]:
    """Return some windows of a triad, and below them the averages taken of them.

    `size` is the unit of the axis [s], `scale` that of the drawing [pt/s].
    """
    said = say(", ").join(
        say(
            "{window_name} at {start}",
            window_name=window_name(track, place),
            start=print_time(track.windows[place].start),
        )
        for place in places
    )
    averages: list[Mark] = []
    for name, first, last in track.averages:
        if first not in places:
            continue
        start = track.windows[first].start
        end = track.windows[last].start + track.windows[last].length
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
    return (
        Row(
            label=say("windows"),
            marks=tuple(_window(track, place, size, scale) for place in places),
            said=said,
        ),
        Row(label=say("averages"), marks=tuple(averages)),
    )


def _window(track: Track, place: int, size: float, scale: float) -> Bar:
    """Return one window, named where its name and those like it fit."""
    window = track.windows[place]
    is_turn = place in track.turns
    # Some named and others not would look as if those were something else.
    are_named = all(
        fits(label, window.length * scale)
        for k, label in enumerate(track.labels)
        if (k in track.turns) == is_turn
    )
    start, length = print_time(window.start), print_time(window.length)
    return Bar(
        start=window.start / size,
        end=(window.start + window.length) / size,
        colour=BLUE,
        opacity=TURN if is_turn else DWELL,
        height=18.0,
        text=track.labels[place] if are_named else "",
        tip=say(
            "{sensor}, {window_name}: from {start} for {length}",
            sensor=say(track.sensor),
            window_name=window_name(track, place),
            start=start,
            length=length,
        ),
    )


def _data(tracks: Sequence[Track]) -> Table:
    """Return the windows with their times."""
    return table_of(
        [(track, place) for track in tracks for place in range(len(track.windows))],
        (*TIMES, Field(head=say("average"), cell=_average)),
        name="schedule-data",
        caption=say("Turns and dwells with their times"),
        by=lambda one: say(one[0].sensor),
        titled=True,
    )


def _average(one: tuple[Track, int]) -> str:
    """Name the average that a window goes into."""
    track, place = one
    return next(name for name, low, high in track.averages if low <= place <= high)


def _given(value: float) -> Cell:
    """Print a time of a procedure [s]."""
    return Cell(text=print_given(value, digits=7), exact=value)


TIMES: tuple[Field[tuple[Track, int]], ...] = (  # of a window, by track and place
    Field(head=term("window"), cell=lambda one: window_name(*one)),
    Field(
        head=term("start [s]"),
        kind="number",
        cell=lambda one: _given(one[0].windows[one[1]].start),
    ),
    Field(
        head=term("length [s]"),
        kind="number",
        cell=lambda one: _given(one[0].windows[one[1]].length),
    ),
)


TEXT_TRACK = 38  # characters that the longest test is drawn with
MOST_DRAWN = 100  # windows that are drawn one by one


def schedule_sections(
    procedure: Procedure, sensors: Sequence[str]
) -> tuple[Section, ...]:
    """Draw the schedule of each triad as text: '#' turns, '=' stands."""
    tracks = make_tracks(procedure, sensors)
    longest = max((track.end for track in tracks), default=0.0)
    return tuple(_drawn_as_text(track, TEXT_TRACK / longest) for track in tracks)


def _drawn_as_text(track: Track, scale: float) -> Section:
    """Return the windows of a triad with their times; `scale` is in characters/s."""

    def bar(one: tuple[Track, int]) -> str:
        window = track.windows[one[1]]
        sign = "#" if window.sense else "="
        start = int(window.start * scale)
        return " " * start + sign * max(1, int(window.end * scale) - start)

    drawing = Field(
        head=say("0 to {end}", end=print_time(track.end)), kind="drawing", cell=bar
    )
    title = say(
        "{sensor}: {made_of}, in {end}",
        sensor=capital(say(track.sensor)),
        made_of=made_of(track),
        end=print_time(track.end),
    )
    return Section(
        name=f"schedule-{track.sensor}",
        title=title,
        in_brief=title if len(track.windows) > MOST_DRAWN else None,
        blocks=(
            table_of(
                [(track, place) for place in range(len(track.windows))],
                (*TIMES, drawing),
                name=f"schedule-{track.sensor}-table",
                caption=say("Windows of the {sensor}", sensor=say(track.sensor)),
            ),
        ),
    )


def make_tracks(procedure: Procedure, sensors: Sequence[str]) -> tuple[Track, ...]:
    """Lay out the triads that there are, gyro first."""
    makers = {"gyro": _gyro_track, "accelerometer": _accelerometer_track}
    if procedure.windows or procedure.formulas not in BY_NAME:
        return tuple(_any_track(name, procedure) for name in makers if name in sensors)
    return tuple(make(procedure) for name, make in makers.items() if name in sensors)


def print_time(seconds: float) -> str:
    """Print a time that was given: '18 s', '5 min', '2.5 h'."""
    if seconds >= IN_HOURS:
        return f"{print_given(seconds / HOUR)} h"
    if seconds >= IN_MINUTES:
        return say("{seconds} min", seconds=print_given(seconds / MINUTE))
    return f"{print_given(seconds)} s"


TURN_OF, TURNS_OF = (
    term("{windows} turn of {lengths}"),
    term("{windows} turns of {lengths}"),
)
DWELL_OF = term("{windows} dwell of {lengths}")
DWELLS_OF = term("{windows} dwells of {lengths}")


def made_of(track: Track) -> str:
    """Say what a test consists of: '6 turns of 18 s and 4 dwells of 5 min'."""
    turns = [window for window in track.windows if window.sense]
    dwells = [window for window in track.windows if not window.sense]
    parts = [
        counted(
            len(windows), one, many, windows=len(windows), lengths=_lengths(windows)
        )
        for windows, one, many in (
            (turns, TURN_OF, TURNS_OF),
            (dwells, DWELL_OF, DWELLS_OF),
        )
        if windows
    ]
    return say(" and ").join(parts)


def _lengths(windows: Sequence[Window]) -> str:
    """Say how long windows are: '18 s', '18 s to 5 min'."""
    texts = [print_time(end(window.length for window in windows)) for end in (min, max)]
    return say(" to ").join(dict.fromkeys(texts))


def window_name(track: Track, place: int) -> str:
    """Name one window in words: 'turn about z+'."""
    window = track.windows[place]
    if window.axis is None and window.azimuth is None:
        return (
            window.name if window.sense else say("dwell with {name}", name=window.name)
        )
    if window.azimuth is not None:
        return say(
            "dwell at azimuth {azimuth:.6g} deg", azimuth=degrees(window.azimuth)
        )
    if track.sensor == "gyro" and window.sense:
        return say("turn about {name}", name=window.name.removeprefix("turn "))
    return say("dwell with {name}", name=window.name)


def _any_track(sensor: str, procedure: Procedure) -> Track:
    """Lay out windows that all go into one estimate."""
    how = (
        say("the norm of gravity")
        if procedure.formulas == "norm"
        else say("least squares")
    )
    windows = schedule_of(sensor, procedure).windows
    gaps = [b.start - a.end for a, b in pairwise(windows)]
    return Track(
        sensor=sensor,
        windows=windows,
        labels=tuple(window.name.partition(",")[0] for window in windows),
        averages=((say("all, by {how}", how=how), 0, len(windows) - 1),),
        pause=min(gaps, default=0.0),
    )


def _gyro_track(procedure: Procedure) -> Track:
    """Lay out turns, a pair for each axis, and the dwells at all azimuths."""
    windows = schedule_of("gyro", procedure).windows
    turns = [window for window in windows if window.sense]
    labels = [_gyro_label(window) for window in windows]
    averages = [
        (
            say("n, j = {counted_turns}", counted_turns=COUNTED_TURNS[axis]),
            2 * place,
            2 * place + 1,
        )
        for place, axis in enumerate(procedure.gyro.order)
    ]
    what = (
        say("all azimuths, z up")
        if procedure.gyro.azimuths
        else say("an axis up and down")
    )
    averages.append((say("N, mean of {what}", what=what), len(turns), len(windows) - 1))
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
    if not window.sense:
        return window.name[:-2]  # without the number of the visit
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
        labels=tuple(
            say("{axis} up", axis=axis) if sign > 0 else say("{axis} down", axis=axis)
            for axis, sign in faces
        ),
        averages=tuple(averages),
        pause=procedure.accelerometer.pause,
    )
