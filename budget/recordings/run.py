"""A recorded calibration read: its windows, found by rest and turn, and their means.

A table has a row of means for each window of the procedure. In a long recording a rest
is where the gyro is quiet and reads what it reads at rest; what is between two rests is
a turn where its angle is that of whole turns. Rests and turns are matched to the
windows of the procedure in their order.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from itertools import pairwise, permutations, product
from math import acos, cos, degrees, inf, log, pi, radians, remainder
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError, Issue, SpecError, UnitError
from budget.inputs.reader import refuse
from budget.inputs.tree import describe
from budget.journal import note_read
from budget.model.source import ACCELEROMETER, GYRO, SENSORS
from budget.names import AXES
from budget.recordings.columns import (
    CHANNELS,
    COUNTER,
    COUNTS,
    TIME,
    RecordedColumn,
    read_head,
)
from budget.recordings.health import (
    AT_END,
    MOST_JITTER,
    SPIKE,
    UsualSteps,
    WindowHealth,
    WindowReadings,
    ends_of,
    saturated_in,
    spikes,
)
from budget.recordings.log import (
    SAME_RATE,
    check_stamps,
    likely_unit,
    open_table,
    stated_end,
)
from budget.recordings.tables import ARRAYS, NumberTable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Recording
    from budget.model.windows import Window

WINDOW, DURATION, START, END = "window", "duration", "start", "end"
MOST_ROWS = 10_000_000  # of a recording that is kept whole: some 3 GB
MOST_BYTES = 16 * 1024 * 1024  # of a table of windows
LOOK = 0.25  # s over which it is quiet or not, and that ends of rests are trimmed by
QUIET = 4.0  # times the lower decile of the scatter [1]
STILL = radians(1.0)  # rate that a rest may be off the others [rad/s]
STILLER = radians(0.02)  # the same, where units may be wrong: the earth's is below it
SIGMAS = 5.0  # likewise, of the scatter
STEPS = 0.02  # of the range, that a step of readings may be [1]
LEAST_REST = 1.0  # [s]
NEAR = radians(25.0)  # of a face
SAME_TURN = 0.1  # of whole turns [1]
MOVING = 0.02  # of the largest rate, from which a turn has begun [1]
FARTHEST = 1.0  # into a rest, that motion beyond the edge of a turn is looked for [s]
UNEVEN = 1e-3  # of a circle's radius, that means over a turn may be off its middle [1]
MARGIN = 0.1  # beyond what is seen of that [s]
MOST_ISSUES = 5
MOST = 1e12  # of a reading or a time, as it is written
LEAST_LENGTH = 1e-3  # of a window [s]
LEAST_SAMPLES = 3  # of a window
EARLY = 0.25  # intervals that a sample may be before a span and be of it [1]
SAME_TIME = 1e-6  # that windows given may lie over each other [s]
ON_TIME = 0.5  # intervals that the first sample of the next file may be off [1]
LONG = 0.7  # ln of a length over the right one, of a rest that may be at another face
MOST_PACE = 1.2  # ln of the length of a turn over the right one, at the most
ELSEWHERE = 10.0  # price of such a rest


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedWindows:
    """What was recorded of the windows of a procedure.

    Attributes
    ----------
    name : str
    sha256 : tuple of (str, str)
        Names of its files, and what they hold.
    windows : tuple of Window
        Of the procedure, with start and length as they were.
    means : mapping of str to ndarray, shape (3, n)
        By triad [SI, or counts]; nan where a window has none.
    has_counts : mapping of str to bool
    passed_over : tuple of (float, float)
        Begins and ends of rests that are no window [s].
    is_as_planned : bool
        Whether the unit rested at the attitudes of the procedure.
    has_one_clock : bool
        Whether the stamps of all recordings go on, if there are several.
    health : mapping of str to tuple of WindowHealth
        By triad, of each window; of a table of means nothing is known of it.
    """

    name: str
    sha256: tuple[tuple[str, str], ...]
    windows: tuple[Window, ...]
    means: Mapping[str, Array]
    has_counts: Mapping[str, bool]
    passed_over: tuple[tuple[float, float], ...] = ()
    is_as_planned: bool = True
    has_one_clock: bool = True
    health: Mapping[str, tuple[WindowHealth, ...]] = field(default_factory=dict)


def read_windows(
    recordings: Sequence[Recording],
    windows: Sequence[Window],
    *,
    name: str,
    times: tuple[Path, str] | None = None,
    knows_attitudes: bool = True,
) -> RecordedWindows:
    """Read a run: a table of means, or recordings one after the other.

    Parameters
    ----------
    windows : sequence of Window
        Of the procedure, on one clock.
    name : str
        Of the procedure.
    times : (Path, str), optional
        Table of when windows begin and end, in the place of rests and turns.
    knows_attitudes : bool
        Whether the table's angles are known; else any rest will do.

    Raises
    ------
    SpecError
        What is wrong with a file, each at its line.
    CallError
        The windows of the procedure are not in it.
    """
    first = recordings[0]
    paths = [pair for one in recordings for pair in one.files]
    if len(paths) == 1 and (table := _read_table(*paths[0], first)) is not None:
        return _of_table(table, windows, name, paths[0])
    spans: Sequence[_Span]
    found: Sequence[_Segment] = ()
    is_as_planned = True
    tracks = [*_on_one_clock([_read_track(one) for one in recordings])]
    if times is not None:
        if len(tracks) > 1:
            raise CallError(
                "a table of windows is of one recording, and several are given; join "
                "them, or leave --windows out"
            )
        spans = list(_given_spans(*times, windows))
    else:
        fit = _found(tracks, windows, name, knows_attitudes=knows_attitudes)
        found, spans, is_as_planned = fit.found, fit.spans, fit.is_as_planned
    kinds = [kind for kind in SENSORS if any(kind in one.values for one in tracks)]
    parts = _parts(first.name, tracks, spans, windows)
    means = {kind: np.full((3, len(windows)), np.nan) for kind in kinds}
    health = {kind: [WindowHealth()] * len(windows) for kind in kinds}
    for kind in kinds:
        ends = ends_of([own[kind].own for own in parts if kind in own])
        for k, own in enumerate(parts):
            if kind in own:
                track, span = tracks[spans[k].track], spans[k]
                mean, health[kind][k] = own[kind].mean(
                    track.usual[kind], ends, track.range_end.get(kind)
                )
                if kind == GYRO and span.rests is not None:
                    angle = windows[k].setting.angle
                    mean = mean + _of_ramps(track, span, angle, health[kind][k])
                means[kind][:, k] = mean
    there = []
    begin = 0.0
    for k, (span, window) in enumerate(zip(spans, windows, strict=True)):
        start = span.start + tracks[span.track].offset
        begin = start if k == 0 else begin
        length = span.end - span.start
        if not window.sense:  # what a mean is of, so that its noise is that of so long
            kept = min(health[kind][k].kept for kind in kinds)
            length = max(length * kept, LEAST_LENGTH)
        there.append(replace(window, start=start - begin, length=length))
    return RecordedWindows(
        name=", ".join(one.name for one in recordings),
        sha256=tuple(pair for one in tracks for pair in one.sha256),
        windows=tuple(there),
        means=means,
        has_counts={
            kind: any(track.counts.get(kind, False) for track in tracks)
            for kind in kinds
        },
        passed_over=tuple(_passed_over(found, spans)),
        is_as_planned=is_as_planned,
        has_one_clock=not any(one.offset for one in tracks),
        health={kind: tuple(own) for kind, own in health.items()},
    )


def _limits(track: _Track, span: _Span) -> tuple[float, float]:
    """Return the ends of a span: a stamp is one to rounding, a quarter of a sample."""
    early = EARLY / track.rate
    return span.start - early, span.end - early


def _parts(
    name: str,
    tracks: Sequence[_Track],
    spans: Sequence[_Span],
    windows: Sequence[Window],
) -> list[dict[str, WindowReadings]]:
    """Return the readings of each triad in each window.

    Raises
    ------
    CallError
        There are too few.
    """
    found = []
    for k, (span, window) in enumerate(zip(spans, windows, strict=True)):
        own = {}
        track = tracks[span.track]
        for kind, (times, values) in track.values.items():
            limits = _limits(track, span)
            a, b = np.searchsorted(times, limits).tolist()
            if b - a < LEAST_SAMPLES:
                raise CallError(
                    f"{name}: window {k + 1} ({window.name}) has {b - a} samples "
                    f"between {span.start:.6g} and {span.end:.6g} s; give other times"
                )
            before, after = max(a - 1, 0), min(b + 1, len(times))
            own[kind] = WindowReadings(
                times=times[before:after],
                values=values[:, before:after],
                first=a - before,
                last=b - before,
                rate=track.rate,
                is_turn=bool(window.sense),
                has_angle=kind == GYRO,
            )
        found.append(own)
    return found


def _passed_over(
    found: Sequence[_Segment], spans: Sequence[_Span]
) -> Iterator[tuple[float, float]]:
    """Yield rests that are no window, nor before or after a turn that is one."""
    used = [
        any(
            s.track == one.track and s.start < one.end and s.end > one.start
            for s in spans
        )
        for one in found
    ]
    for k, one in enumerate(found):
        beside = (j for j in (k - 1, k + 1) if 0 <= j < len(found))
        is_held = any(used[j] and not found[j].is_rest for j in beside)
        if one.is_rest and not used[k] and not is_held:
            yield one.start, one.end


# ---- tables --------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class _WindowTable:
    """A table with a column of windows."""

    heads: tuple[str, ...]
    rows: list[tuple[int, list[str]]]  # with their lines


def _read_text(path: Path, shown: str) -> str:
    """Read a small text.

    Raises
    ------
    SpecError
        It cannot be read, or is none.
    """
    try:
        note_read(path)
        if path.stat().st_size > MOST_BYTES:
            raise refuse(shown, f"has more than {MOST_BYTES} bytes of windows")
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise refuse(shown, f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise refuse(shown, "is not UTF-8; save the file as UTF-8") from None


def _read_table(path: Path, shown: str, recording: Recording) -> _WindowTable | None:
    """Return a table of windows; None of any other recording."""
    if path.suffix.lower() in ARRAYS:
        return None
    try:
        with path.open("rb") as stream:
            head = stream.readline(4096).decode("utf-8-sig", errors="replace")
    except OSError:
        return None  # said by who reads it
    first = head.lstrip("#% ").split(",")[0].strip().strip('"').casefold()
    if first != WINDOW:
        return None
    text = _read_text(path, shown)
    if text and not text.endswith("\n"):
        line = text.count("\n") + 1
        raise _fault(
            shown,
            line,
            1,
            "the last row has no end of line, so that it may have been cut off; take "
            "the row out, or end it",
        )
    rows = _rows(shown, text)
    heads = recording.columns or tuple(rows[0][1])
    return _WindowTable(heads=tuple(heads), rows=rows[1:])


def _rows(shown: str, text: str) -> list[tuple[int, list[str]]]:
    """Return the rows of a table with their lines, heads first.

    Raises
    ------
    SpecError
        A line is no row.
    """
    lines = csv.reader(io.StringIO(text, newline=""))
    found = []
    try:
        for row in lines:
            cells = [cell.strip() for cell in row]
            if any(cells):
                found.append((lines.line_num, cells))
    except csv.Error as error:
        message = f"is no row of a table ({error}); write one in a line, with commas"
        raise _fault(shown, lines.line_num + 1, 1, message) from None
    return found


def _fault(shown: str, line: int, column: int, message: str) -> SpecError:
    """Return the error of one row."""
    issue = Issue(file=shown, line=line, column=column, field="", message=message)
    return SpecError((issue,))


def _number(shown: str, line: int, place: int, head: str, cell: str) -> float:
    """Read a cell; nan of an empty one.

    Raises
    ------
    SpecError
        It is no finite number.
    """
    if not cell:
        return np.nan
    try:
        value = float(cell) if "_" not in cell else np.nan
    except ValueError:
        value = np.nan
    if not abs(value) < MOST:
        raise _fault(
            shown,
            line,
            place + 1,
            f"{head}: found {describe(cell)}, expected a number below {MOST:.0e}, or "
            "nothing where a window is not used",
        )
    return value


def _columns(
    shown: str, table: _WindowTable, wanted: Mapping[str, str]
) -> dict[str, _Head]:
    """Return what the columns are, by name; `wanted` are names with their units.

    Raises
    ------
    SpecError
        A head is none.
    """
    found: dict[str, _Head] = {}
    issues = []
    for place, head in enumerate(table.heads):
        name = head.split("[")[0].strip().casefold()
        try:
            if wanted.get(name):
                # Read as a time is, whatever it is called.
                column = read_head(head.replace(head.split("[")[0].strip(), TIME, 1))
            elif name in wanted:
                column = replace(read_head("_"), head=head)
            else:
                column = read_head(head)
                name = column.name
        except UnitError as error:
            issues.append(
                Issue(
                    file=shown,
                    line=1,
                    column=place + 1,
                    field="",
                    message=f"head {place + 1}: {error}",
                )
            )
            continue
        if name in found:
            raise refuse(shown, f"names two columns {name!r}, expected one")
        if name:
            found[name] = _Head(
                place=place,
                head=head,
                size=column.sign * (column.size or 1.0),
                has_counts=column.unit == COUNTS,
            )
    if issues:
        raise SpecError(tuple(issues[:MOST_ISSUES]))
    return found


@dataclass(frozen=True, kw_only=True)
class _Head:
    """Where a column stands, and its unit [SI]."""

    place: int
    head: str
    size: float
    has_counts: bool


def _of_table(
    table: _WindowTable,
    windows: Sequence[Window],
    name: str,
    file: tuple[Path, str],
) -> RecordedWindows:
    """Return the means of a table, a row for each window of the procedure.

    Raises
    ------
    SpecError
        Rows that are none, or more or fewer than windows.
    """
    path, shown = file
    columns = _columns(shown, table, {WINDOW: "", DURATION: "s"})
    own = [one for one in columns if one in CHANNELS]
    if not own:
        raise refuse(
            shown,
            "names no column of a gyro or an accelerometer, expected heads as "
            "window,duration [s],gyro_x [deg/s],...,accelerometer_z [m/s^2]",
        )
    if len(table.rows) != len(windows):
        listed = "; ".join(f"{k + 1} {one.name}" for k, one in enumerate(windows))
        raise refuse(
            shown,
            f"has {len(table.rows)} rows, and {name} has {len(windows)} windows, "
            f"expected a row for each, in their order: {listed}",
        )
    values: dict[str, list[float]] = {one: [] for one in (*own, DURATION)}
    for line, cells in table.rows:
        if len(cells) != len(table.heads):
            hint = "; a decimal comma is a second field: write 0.5, not 0,5"
            raise _fault(
                shown,
                line,
                1,
                f"has {len(cells)} fields, expected {len(table.heads)}"
                f"{hint if len(cells) > len(table.heads) else ''}",
            )
        for key, into in values.items():
            at = columns.get(key)
            cell = "" if at is None else cells[at.place]
            read = (
                np.nan
                if at is None
                else _number(shown, line, at.place, at.head, cell) * at.size
            )
            if key == DURATION and read < LEAST_LENGTH:
                raise _fault(
                    shown,
                    line,
                    at.place + 1 if at else 1,
                    f"found {describe(cell)}, expected a duration of 1 ms or more",
                )
            into.append(read)
    there, delay = [], 0.0
    for window, length in zip(windows, values[DURATION], strict=True):
        took = window.length if np.isnan(length) else length
        there.append(replace(window, start=window.start + delay, length=took))
        delay += took - window.length
    kinds = [kind for kind in SENSORS if any(one.startswith(kind) for one in own)]
    nothing = [np.nan] * len(windows)
    return RecordedWindows(
        name=path.name,
        sha256=((path.name, sha256(path.read_bytes()).hexdigest()),),
        windows=tuple(there),
        means={
            kind: np.array([values.get(f"{kind}_{axis}", nothing) for axis in AXES])
            for kind in kinds
        },
        has_counts={
            kind: any(columns[one].has_counts for one in own if one.startswith(kind))
            for kind in kinds
        },
    )


def _given_spans(path: Path, shown: str, windows: Sequence[Window]) -> Iterator[_Span]:
    """Yield when each window begins and ends, of a table.

    Raises
    ------
    SpecError
        Rows that are none, or more or fewer than windows.
    """
    text = _read_text(path, shown)
    rows = _rows(shown, text)
    if not rows:
        raise refuse(shown, "is empty, expected heads window,start [s],end [s]")
    table = _WindowTable(heads=tuple(rows[0][1]), rows=rows[1:])
    columns = _columns(shown, table, {WINDOW: "", START: "s", END: "s"})
    if not {START, END} <= columns.keys():
        raise refuse(shown, "expected heads window,start [s],end [s]")
    if len(table.rows) != len(windows):
        raise refuse(
            shown,
            f"has {len(table.rows)} rows, expected one for each of {len(windows)} "
            "windows, in their order",
        )
    there: dict[int, tuple[float, float]] = {}
    for line, cells in table.rows:
        if len(cells) != len(table.heads):
            message = f"has {len(cells)} fields, expected {len(table.heads)}"
            raise _fault(shown, line, 1, message)
        edges = [columns[START], columns[END]]
        for at in edges:
            if not cells[at.place]:
                message = f"{at.head} is empty, expected when the window begins or ends"
                raise _fault(shown, line, at.place + 1, message)
        start, end = (
            _number(shown, line, at.place, at.head, cells[at.place]) * at.size
            for at in edges
        )
        if not start < end:
            raise _fault(shown, line, 1, "ends before it begins")
        _check_apart(shown, line, (start, end), there)
        there[line] = start, end
        yield _Span(track=0, start=start, end=end)


def _check_apart(
    shown: str,
    line: int,
    own: tuple[float, float],
    there: Mapping[int, tuple[float, float]],
) -> None:
    """Refuse a window that lies over one of those before it, by line.

    Raises
    ------
    SpecError
        It does.
    """
    start, end = own
    for other, (begin, over) in there.items():
        if start < over - SAME_TIME and begin < end - SAME_TIME:
            raise _fault(
                shown,
                line,
                1,
                f"{start:.6g} to {end:.6g} s is over that of line {other}, "
                f"{begin:.6g} to {over:.6g} s; give each window a time of its own",
            )


# ---- recordings ----------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class _Track:
    """A recording kept whole: times (n,) and readings (3, n) of each triad."""

    values: Mapping[str, tuple[Array, Array]]
    counts: Mapping[str, bool]
    rate: float
    sha256: tuple[tuple[str, str], ...]
    range_end: Mapping[str, float]  # that is stated [SI]
    likely_unit: str = ""  # of stamps that come seldom
    number: int = 0
    offset: float = 0.0  # of the clock of the run to its own [s]

    @property
    def begin(self) -> float:
        """When its first sample was [s]."""
        return min(float(times[0]) for times, _ in self.values.values())

    @property
    def end(self) -> float:
        """One interval after its last sample [s]."""
        last = max(float(times[-1]) for times, _ in self.values.values())
        return last + 1.0 / self.rate

    @cached_property
    def usual(self) -> Mapping[str, tuple[UsualSteps | None, ...]]:
        """What is usual of each axis; None of one that was not recorded."""
        return {
            kind: tuple(
                UsualSteps.of(one) if np.isfinite(one).all() else None for one in values
            )
            for kind, (_, values) in self.values.items()
        }

    @cached_property
    def smooth(self) -> tuple[Array, Array]:
        """Times and rates that rests are found by, else forces: less their spikes."""
        from scipy.ndimage import median_filter

        kind = GYRO if GYRO in self.values else ACCELEROMETER
        times, values = self.values[kind]
        found = []
        for own, usual in zip(values, self.usual[kind], strict=True):
            if usual is not None:
                is_spike = spikes(own, usual.step)
                middle = median_filter(own, SPIKE, mode="nearest")
                found.append(np.where(is_spike, middle, own))
        return times, np.array(found)

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """Samples after which some are missing, of those of `smooth`."""
        return np.flatnonzero(np.diff(self.smooth[0]) > MOST_JITTER / self.rate)


def _read_track(recording: Recording) -> _Track:
    """Read a recording whole.

    Raises
    ------
    SpecError, CallError
        As budget.recordings.log has it.
    """
    values: dict[str, tuple[Array, Array]] = {}
    counts: dict[str, bool] = {}
    ends: dict[str, float] = {}
    files, rates, unit = [], [], ""
    for path, shown in recording.files:
        table = NumberTable(path, shown)
        opened = open_table(table, recording)
        rows = [piece.values for piece in opened.pieces()]
        if sum(map(len, rows)) > MOST_ROWS:
            raise refuse(
                shown, f"has more than {MOST_ROWS:.0e} rows; cut it to the run"
            )
        every = np.concatenate(rows)
        read = opened.read
        for place in (place for name, (place, _) in read.items() if name != TIME):
            row = int(np.abs(every[:, place]).argmax()) if len(every) else 0
            if len(every) and abs(every[row, place]) >= MOST:
                raise refuse(
                    shown,
                    f"row {row + 1} has {abs(every[row, place]):.3g}, expected numbers "
                    f"below {MOST:.0e}; leave such rows out",
                )
        files.append((path.name, table.sha256))
        times, rate = _times(every, opened.read, recording, shown)
        rates.append(rate)
        if TIME in read and not recording.rate:
            unit = likely_unit(read[TIME][1], 1.0 / rate)
        for kind in SENSORS:
            own = [read.get(f"{kind}_{axis}") for axis in AXES]
            if not any(own):
                continue
            if kind in values:
                raise refuse(shown, f"has the {kind} once more; name one of them")
            steps_ = rate if recording.increments else 1.0
            values[kind] = (
                times,
                np.array(
                    [
                        np.full(len(every), np.nan)
                        if one is None
                        else every[:, one[0]]
                        * (one[1].sign * (one[1].size or 1.0) * steps_)
                        for one in own
                    ]
                ),
            )
            counts[kind] = any(one is not None and one[1].size is None for one in own)
            stated = [stated_end(recording, one[1]) for one in own if one]
            if stated[0] is not None:
                ends[kind] = stated[0]
    return _Track(
        values=values,
        counts=counts,
        rate=min(rates),
        sha256=tuple(files),
        range_end=ends,
        likely_unit=unit,
    )


def _on_one_clock(tracks: Sequence[_Track]) -> Iterator[_Track]:
    """Yield recordings of one run on one clock; those without a pause are one.

    Where stamps of one do not go on after those of the one before, it begins where
    that ended.
    """
    last: _Track | None = None
    number = 0
    for own in tracks:
        if last is None:
            last = own
            continue
        step = own.begin - last.end
        if _goes_on(last, own):
            last = _joined(last, own)
            continue
        yield last
        number += 1
        offset = last.offset if step >= -ON_TIME / last.rate else last.offset - step
        last = replace(own, number=number, offset=offset)
    if last is not None:
        yield last


def _goes_on(last: _Track, own: _Track) -> bool:
    """Whether a recording is the next piece of one, without a sample between them."""
    return (
        last.values.keys() == own.values.keys()
        and last.counts == own.counts
        and last.range_end == own.range_end
        and abs(own.rate / last.rate - 1.0) <= SAME_RATE
        and all(
            abs((own.values[kind][0][0] - times[-1]) * last.rate - 1.0) <= ON_TIME
            for kind, (times, _) in last.values.items()
        )
    )


def _joined(last: _Track, own: _Track) -> _Track:
    """Return two pieces as one recording."""
    values = {
        kind: (
            np.concatenate([times, own.values[kind][0]]),
            np.concatenate([readings, own.values[kind][1]], axis=1),
        )
        for kind, (times, readings) in last.values.items()
    }
    usual = [float(np.median(np.diff(times))) for times, _ in values.values()]
    return replace(
        last,
        values=values,
        rate=1.0 / max(usual),
        sha256=(*last.sha256, *own.sha256),
    )


def _times(
    rows: Array,
    read: Mapping[str, tuple[int, RecordedColumn]],
    recording: Recording,
    shown: str,
) -> tuple[Array, float]:
    """Return when each sample was, and how many came in a second.

    Raises
    ------
    SpecError
        Stamps do not go on, are in another unit, or not at the rate that is stated.
    CallError
        There are none, and no rate.
    """
    if TIME not in read:
        if not recording.rate:
            raise CallError(
                f"{recording.name}: nothing says how fast it was sampled; give "
                "--rate, as --rate 100, or a column time [s]"
            )
        return _counted(rows, read, recording, shown) / recording.rate, recording.rate
    place, column = read[TIME]
    times = rows[:, place] * (column.size or 1.0)
    steps = np.diff(times)
    if len(times) < LEAST_SAMPLES or not (steps > 0.0).all():
        back = int(np.argmin(steps > 0.0)) if len(steps) else 0
        raise refuse(
            shown,
            f"time does not go on from row {back + 1} to the next; leave out "
            "what was written twice, or give --rate and skip the column",
        )
    usual = float(np.median(steps))
    check_stamps(shown, column, usual, recording)
    found = 1.0 / float(steps[steps <= MOST_JITTER * usual].mean())
    if recording.rate and abs(recording.rate / found - 1.0) > SAME_RATE:
        raise refuse(
            shown,
            f"the rate is given as {recording.rate:.6g} Hz, and its stamps come at "
            f"{found:.6g} Hz; leave the rate out, or skip the column of stamps "
            "(--columns with _ in its place)",
        )
    if np.abs(times).max() >= MOST:
        raise refuse(
            shown,
            f"has stamps of {np.abs(times).max():.3g} s, expected times below "
            f"{MOST:.0e} s; let them begin elsewhere, or say their unit in the head",
        )
    return times, 1.0 / usual


def _counted(
    rows: Array,
    read: Mapping[str, tuple[int, RecordedColumn]],
    recording: Recording,
    shown: str,
) -> Array:
    """Return the places of samples by their counter, if there is one.

    Raises
    ------
    SpecError
        The counter does not go on.
    """
    if COUNTER not in read:
        return np.arange(len(rows), dtype=float)
    steps = np.diff(rows[:, read[COUNTER][0]])
    if recording.counter:
        steps = np.mod(steps, recording.counter[1])
    if back := np.flatnonzero(steps <= 0.0).tolist():
        raise refuse(
            shown,
            f"the counter does not go on from row {back[0] + 1} to the next; leave out "
            "what was written twice, or skip the column (--columns with _)",
        )
    usual = float(np.median(steps)) if len(steps) else 1.0
    return np.concatenate([[0.0], np.cumsum(steps) / usual])


@dataclass(frozen=True, kw_only=True)
class _Span:
    """When one window was, and of a turn the rests before and after it."""

    track: int
    start: float
    end: float
    rests: tuple[tuple[float, float], tuple[float, float]] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Segment:
    """A rest, or what is between two of them."""

    track: int
    start: float
    end: float
    is_rest: bool
    force: Array | None = None  # its direction in body axes, shape (3,)
    angle: float = 0.0  # that it turned by [rad, or counts s]
    is_back: bool = False  # whether it stands after it as before
    has_counts: bool = False
    missing: int = 0  # samples
    is_clipped: bool = False  # whether some are at the end of the range
    rests: tuple[tuple[float, float], tuple[float, float]] | None = None  # beside it

    @property
    def length(self) -> float:
        """How long it is [s]."""
        return self.end - self.start

    @property
    def said(self) -> str:
        """What it is, in words."""
        when = f"{self.start:.2f} to {self.end:.2f} s"
        if self.is_rest:
            if self.force is None:
                return f"rest {when}"
            axis = int(np.abs(self.force).argmax())
            up = "up" if self.force[axis] > 0.0 else "down"
            return f"rest {when}, {AXES[axis]} {up}"
        angle = "" if self.has_counts else f", {degrees(self.angle):.1f} deg"
        lacks = f", {self.missing} samples missing" if self.missing else ""
        clipped = ", at the end of the range" if self.is_clipped else ""
        return f"turn {when}{angle}{lacks}{clipped}"


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """Segments matched to windows: when each was, and how badly they fit."""

    found: Sequence[_Segment]
    spans: Sequence[_Span]
    is_as_planned: bool
    price: float


def _segments(
    track: _Track, windows: Sequence[Window], still: float, *, is_joined: bool
) -> list[_Segment]:
    """Find rests and what is between them, in the order of time.

    In a rest the rate is no more off the others' than `still` [rad/s]; where it
    `is_joined` it goes on after a gap.
    """
    kind = GYRO if GYRO in track.values else ACCELEROMETER
    times, values = track.smooth
    starts, ends = _runs(_rest_of(track, kind, values, windows, still))
    gaps = () if is_joined else track.places
    cut: list[tuple[int, int]] = []
    for start, end in zip(starts, ends, strict=True):
        inside = [int(g) + 1 for g in gaps if start <= g < end - 1]
        edges = [start, *inside, end]
        cut += pairwise(edges)
    rests = [
        (int(a), int(b))
        for a, b in cut
        if times[b - 1] - times[a] >= LEAST_REST - 1.0 / track.rate
    ]
    forces = _forces(track, [(times[a], times[b - 1]) for a, b in rests])
    found: list[_Segment] = []
    level = (
        np.mean([values[:, a:b].mean(axis=1) for a, b in rests], axis=0)
        if rests and kind == GYRO
        else None
    )
    for k, (a, b) in enumerate(rests):
        if k and level is not None:
            found.append(
                _between(
                    track,
                    values - level[:, None],
                    (rests[k - 1], (a, b)),
                    forces[k - 1 : k + 1],
                )
            )
        found.append(
            _Segment(
                track=track.number,
                start=float(times[a]) + LOOK,
                end=float(times[b - 1]) + 1.0 / track.rate - LOOK,
                is_rest=True,
                force=forces[k],
            )
        )
    return [one for one in found if one.length > 0.0]


def _rest_of(
    track: _Track, kind: str, values: Array, windows: Sequence[Window], still: float
) -> NDArray[np.bool_]:
    """Say of each sample whether the unit rests.

    Raises
    ------
    CallError
        The recording is too short to say.
    """
    width = max(LEAST_SAMPLES, round(LOOK * track.rate)) | 1
    n = values.shape[1]
    if n <= 4 * width:
        raise CallError(
            f"the recording has {n} samples, too few to find rests in; "
            "give one of the whole run"
        )
    middle = np.median(values, axis=1)[:, None]
    mean = _rolling(values - middle, width)
    square = _rolling((values - middle) ** 2, width)
    scatter = np.sqrt(np.maximum(square - mean**2, 0.0).sum(axis=0))
    decile = max(float(np.quantile(scatter, 0.1)), _coarseness(track, kind, values))
    quiet = scatter <= QUIET * decile
    if kind != GYRO:
        return np.asarray(quiet)
    level = np.median(mean[:, quiet], axis=1)[:, None]
    off = np.abs(mean - level).max(axis=0)
    allowed = SIGMAS * decile
    if not track.counts[GYRO]:
        slowest = min(
            (float(np.linalg.norm(one.rate)) for one in windows if one.sense),
            default=inf,
        )
        usual = min(STILL, slowest / 2.0)
        least = SIGMAS * decile / np.sqrt(width)
        if still < STILL:
            usual = min(usual, max(still, SIGMAS * decile))
        allowed = max(usual, least)
    return np.asarray(quiet & (off <= allowed))


def _coarseness(track: _Track, kind: str, values: Array) -> float:
    """Return what the steps of readings scatter by, q^2/12 of each axis.

    A reading without noise has the jumps of the motion alone: no more than a part of
    the range.
    """
    steps = [one.step for one in track.usual[kind] if one is not None]
    least = np.minimum(steps, STEPS * np.ptp(values, axis=1))
    return float(np.sqrt((least**2).sum() / 12.0))


def _rolling(values: Array, width: int) -> Array:
    """Return means over `width` samples about each, fewer at the ends, (3, n)."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(values, width, axis=1, mode="nearest"))


def _runs(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return begins and ends of runs of what is true."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)


def _forces(track: _Track, spans: Sequence[tuple[float, float]]) -> list[Array | None]:
    """Return the direction of the specific force in each rest; None if unknown.

    Of counts, whose zero is not known, from the middle between the largest and the
    smallest rest of each axis, over half the range.
    """
    if ACCELEROMETER not in track.values:
        return [None] * len(spans)
    times, values = track.values[ACCELEROMETER]
    means = []
    for start, end in spans:
        inside = (times >= start) & (times <= end)
        means.append(
            values[:, inside].mean(axis=1) if inside.any() else np.full(3, np.nan)
        )
    every = np.array(means).reshape(-1, 3)
    if track.counts[ACCELEROMETER] and len(every):
        low, high = np.nanmin(every, axis=0), np.nanmax(every, axis=0)
        size = np.where(high > low, (high - low) / 2.0, 1.0)
        every = (every - (high + low) / 2.0) / size
    found: list[Array | None] = []
    for one in every:
        length = float(np.linalg.norm(one))
        found.append(one / length if np.isfinite(length) and length > 0.0 else None)
    return found


def _between(
    track: _Track,
    rates: Array,
    places: tuple[tuple[int, int], tuple[int, int]],
    forces: Sequence[Array | None],
) -> _Segment:
    """Return what is between two rests, from where it begins to move.

    `rates` are those over the rests, (3, n); `places` those of the rests.
    """
    times, values = track.values[GYRO]
    first, last = places[0][1], places[1][0]
    one, other = ((float(times[a]), float(times[b - 1])) for a, b in places)
    rests = (one, other)
    pad = max(1, round(LOOK * track.rate))
    a, b = max(first - pad, 0), min(last + pad, len(times))
    moved = rates[:, a:b]
    size = np.abs(moved).max(axis=0)
    edge = MOVING * float(size.max(initial=0.0))
    noise = SIGMAS * float(np.std(moved[:, :pad], axis=1).max()) if b > a else 0.0
    moving = np.flatnonzero(size > max(edge, noise))
    a, b = (
        (a + int(moving[0]), a + int(moving[-1]) + 1) if moving.size else (first, last)
    )
    steps = np.diff(times[a : b + 1])
    own, after_ = rates[:, a : a + len(steps)], rates[:, a + 1 : a + 1 + len(steps)]
    is_gap = steps > MOST_JITTER / track.rate
    own = np.where(is_gap, (own + after_) / 2.0, own)
    angle = np.abs((own * steps).sum(axis=1)).max() if len(steps) else 0.0
    missing = int((np.rint(steps[is_gap] * track.rate) - 1.0).sum())
    before, after = forces
    is_back = before is None or after is None or float(before @ after) > cos(NEAR)
    return _Segment(
        track=track.number,
        start=float(times[a]),
        end=float(times[b - 1]) + 1.0 / track.rate,
        is_rest=False,
        angle=float(angle),
        is_back=is_back,
        has_counts=track.counts[GYRO],
        missing=missing,
        is_clipped=_is_clipped(track, values[:, a:b]),
        rests=rests,
    )


def _of_ramps(track: _Track, span: _Span, angle: float, health: WindowHealth) -> Array:
    """Return what the mean of a turn would read more, were its rate one, (3,)."""
    found = _edges(track, span) / (span.end - span.start)
    return found if health.missing else found - _uneven(track, span, angle)


def _edges(track: _Track, span: _Span) -> Array:
    """Return the angle of a turn beyond its edges, over what it reads at rest, (3,).

    From each edge to where the mean over LOOK is within its noise of that of the rest,
    and MARGIN on; a turn that begins at once has none. Only so is the angle whole
    turns, and none of the earth rate at rest is taken for motion.
    """
    times, values = track.values[GYRO]
    values = values.copy()
    values[np.isfinite(values).all(axis=1)] = track.smooth[1]
    total = np.zeros(3)
    for (start, end), at, side in zip(
        span.rests or (), (span.start, span.end), (-1, 1), strict=True
    ):
        # Outwards: the outer half of the rest, or what is beyond FARTHEST, is still.
        reach = min((end - start) / 2.0, LOOK + FARTHEST)
        low, high = (
            (start + LOOK, end - reach) if side < 0 else (start + reach, end - LOOK)
        )
        still = values[:, slice(*np.searchsorted(times, (low, high)).tolist())]
        edge = at - EARLY / track.rate
        a, b = np.searchsorted(
            times, (high, edge) if side < 0 else (edge, low)
        ).tolist()
        if still.shape[1] < LEAST_SAMPLES or b <= a:
            continue
        middle = np.median(still, axis=1)[:, None]
        noise = np.std(still, axis=1)[:, None]
        level = np.where(np.abs(still - middle) <= SIGMAS * noise, still, middle).mean(
            axis=1
        )[:, None]
        width = max(1, round(LOOK * track.rate))
        places = np.arange(a, b)[::side]
        moved = values[:, places] - level
        steps = np.abs(np.diff(times, append=times[-1] + 1.0 / track.rate))[places]
        sums = np.cumsum(np.pad(moved, ((0, 0), (1, width))), axis=1)
        counts = np.minimum(width, len(places) - np.arange(len(places)))
        mean = (sums[:, width : width + len(places)] - sums[:, : len(places)]) / counts
        is_moving = (np.abs(mean) > SIGMAS * noise / np.sqrt(counts)).any(axis=0)
        seen = np.flatnonzero(is_moving)
        if seen.size:
            last = int(seen[-1]) + 1 + round(MARGIN * track.rate)
            total += (moved[:, :last] * steps[:last]).sum(axis=1)
    return total


def _uneven(track: _Track, span: _Span, angle: float) -> Array:
    """Return what the mean of a turn has of what goes round with it, (3,).

    Of whole turns at one rate that is nothing; in ramps the unit is longer at the
    angles where it begins and ends. With theta its angle and w the rate about its axis,
    the other axes read c + M w + A cos theta + B sin theta, of which A and B are taken
    times the means of cos and sin.
    """
    times, values = track.values[GYRO]
    none = np.zeros(3)
    if not np.isfinite(values[:, 0]).all() or abs(remainder(angle, 2.0 * pi)) > UNEVEN:
        return none
    a, b = np.searchsorted(times, _limits(track, span)).tolist()
    own = track.smooth[1][:, a:b]
    axis = int(np.abs(own.mean(axis=1)).argmax())
    theta = np.cumsum(own[axis]) - own[axis] / 2.0
    theta *= angle / own[axis].sum()
    waves = np.array([np.cos(theta), np.sin(theta)])
    middle = waves.mean(axis=1)
    if np.hypot(*middle) < UNEVEN:
        return none
    rate = own[axis] / np.abs(own[axis]).max()
    design = np.vstack([np.ones(b - a), rate, waves]).T
    found = np.linalg.lstsq(design, own.T, rcond=None)[0][2:]
    found[:, axis] = 0.0
    return np.asarray(middle @ found)


def _is_clipped(track: _Track, values: Array) -> bool:
    """Whether readings of a turn are at the end of the range, (3, n)."""
    stated = track.range_end.get(GYRO)
    return any(
        saturated_in(own, usual, stated).sum() >= AT_END
        for own, usual in zip(values, track.usual[GYRO], strict=True)
        if usual is not None and own.size
    )


def _found(
    tracks: Sequence[_Track],
    windows: Sequence[Window],
    name: str,
    *,
    knows_attitudes: bool,
) -> _Fit:
    """Find rests and turns, and match them.

    Where what should be a turn is so slow that it passes for a rest, units may be
    wrong: a rest is then what is still by its own noise. Over gaps rests go on, unless
    the windows are so far from fitting by then that each part is one of its own.

    Raises
    ------
    CallError
        Some window is not there.
    """
    first: CallError | None = None
    for still in (STILL, STILLER):
        fits: list[_Fit] = []
        has_gaps = any(one.places.size for one in tracks)
        for is_joined in (True, False) if has_gaps else (False,):
            found = [
                one
                for each in tracks
                for one in _segments(each, windows, still, is_joined=is_joined)
            ]
            try:
                fit = _matched(found, windows, name, knows_attitudes=knows_attitudes)
            except CallError as error:
                first = first or error
            else:
                more = 0.0 if is_joined else LONG
                fits.append(replace(fit, price=fit.price + more))
        if fits:
            return min(fits, key=lambda one: (not one.is_as_planned, one.price))
    raise CallError(f"{first or name}{_of_gaps(tracks)}{_of_stamps(tracks)}")


def _of_gaps(tracks: Sequence[_Track]) -> str:
    """Say where samples are missing, if some are."""
    found = [
        f"{(times[k + 1] - times[k]) * one.rate - 1.0:.0f} after {times[k]:.2f} s"
        for one in tracks
        for times in [one.smooth[0]]
        for k in one.places.tolist()[:MOST_ISSUES]
    ]
    return f". Samples are missing: {', '.join(found[:MOST_ISSUES])}" if found else ""


def _of_stamps(tracks: Sequence[_Track]) -> str:
    """Say that stamps may be in another unit, where they are far apart."""
    for one in tracks:
        if unit := one.likely_unit:
            return (
                f". Stamps come every {1.0 / one.rate:.3g} s: if they are in {unit}, "
                f"write 'time [{unit}]' in the head or in --columns"
            )
    return ""


def _matched(
    found: Sequence[_Segment],
    windows: Sequence[Window],
    name: str,
    *,
    knows_attitudes: bool,
) -> _Fit:
    """Return when each window was, in order.

    Where attitudes are those of the procedure with axes exchanged or reversed, or a few
    windows are at others though they last as long, they are taken as they come: what is
    wrong the readings will say.

    Raises
    ------
    CallError
        Some window is not there: what is, and what should be.
    """
    spans, price = _match(found, windows, turned=np.eye(3), knows=knows_attitudes)
    if spans is not None:
        return _Fit(spans=spans, is_as_planned=True, price=price, found=found)
    tried = [
        _match(found, windows, turned=np.array(turned), knows=True)
        for turned in _turned_axes()
    ]
    tried += [_match(found, windows, turned=np.eye(3), knows=True, strict=False)]
    best = min((price, k) for k, (_, price) in enumerate(tried))
    spans, price = tried[best[1]]
    if spans is not None and price < inf:
        return _Fit(spans=spans, is_as_planned=False, price=price, found=found)
    wanted = "; ".join(f"{k + 1} {one.name}" for k, one in enumerate(windows))
    there = "; ".join(one.said for one in found if one.is_rest or one.is_back)
    raise CallError(
        f"the windows of {name} are not all in the recording, in their order.\n"
        f"wanted: {wanted}\nfound: {there or 'no rest of 1 s or more'}\n"
        "Record what is missing, give the times of windows (--windows), or the "
        "procedure that was run"
    )


def _turned_axes() -> Iterator[Array]:
    """Yield axes that are exchanged or reversed, as matrices (3, 3)."""
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            matrix = np.eye(3)[list(order)] * np.array(signs)[:, None]
            if not np.array_equal(matrix, np.eye(3)):
                yield matrix


def _match(
    found: Sequence[_Segment],
    windows: Sequence[Window],
    *,
    turned: Array,
    knows: bool,
    strict: bool = True,
) -> tuple[list[_Span] | None, float]:
    """Return the cheapest match in order, and its price; None without any.

    Dwells one after the other at the same angles may be one rest. Of forces, turned
    into body axes, it `knows` where they should point; where it is not `strict`, a few
    may point elsewhere.
    """
    n, m = len(windows), len(found)
    cost = np.full((n + 1, m + 1), inf)
    cost[0] = 0.0
    last: dict[tuple[int, int], int] = {}  # windows of the last segment, by state
    groups = [_alike(windows, j) for j in range(n)]
    unit = _turn_unit(found, windows)
    for s in range(1, m + 1):
        segment = found[s - 1]
        for j in range(1, n + 1):
            cost[j, s] = cost[j, s - 1]
            for g in range(1, groups[j - 1] + 1):
                own = windows[j - g : j]
                price = cost[j - g, s - 1] + _price(segment, own, unit)
                if price < inf and knows:
                    price += _askew(segment, own, turned, strict=strict)
                if price < cost[j, s]:
                    cost[j, s], last[j, s] = price, g
    price = float(cost[n, m])
    most = max(2, n // 4) * (ELSEWHERE + LONG) + n * LONG
    if price == inf or (not strict and price > most):
        return None, inf
    return _traced(found, windows, last), price


def _traced(
    found: Sequence[_Segment],
    windows: Sequence[Window],
    last: Mapping[tuple[int, int], int],
) -> list[_Span]:
    """Return the spans of a match, from its end."""
    spans: list[_Span] = []
    j, s = len(windows), len(found)
    while j:
        taken = last.get((j, s), 0)
        if taken:
            spans = [*_split(found[s - 1], windows[j - taken : j]), *spans]
            j -= taken
        s -= 1
    return spans


def _alike(windows: Sequence[Window], last: int) -> int:
    """Return how many dwells up to one stand as it does, without a move."""
    count = 1
    while (
        last - count >= 0
        and not windows[last].sense
        and not windows[last - count].sense
        and windows[last - count].setting == windows[last].setting
    ):
        count += 1
    return count


def _turn_unit(found: Sequence[_Segment], windows: Sequence[Window]) -> float:
    """Return the size of a turn as it is integrated over the true one [1].

    Of counts, whose gain is not known, or of other units, by the largest of both.
    """
    turns = [abs(one.setting.angle) for one in windows if one.sense]
    seen = [one.angle for one in found if not one.is_rest and one.is_back]
    if not turns or not seen:
        return 1.0
    unit = float(np.median(sorted(seen)[-len(turns) :])) / float(np.median(turns))
    return unit if abs(unit - 1.0) > SAME_TURN and unit > 0.0 else 1.0


def _price(segment: _Segment, windows: Sequence[Window], unit: float) -> float:
    """Return how badly a segment fits windows by length, infinite if not at all."""
    window = windows[0]
    if bool(window.sense) == segment.is_rest:
        return inf
    price = abs(log(segment.length / sum(one.length for one in windows)))
    if window.sense:
        off = segment.angle / unit / abs(window.setting.angle) - 1.0
        is_whole = abs(off) <= SAME_TURN or (segment.is_clipped and off < 0.0)
        is_it = is_whole and segment.is_back and price <= MOST_PACE
        if not is_it:
            return inf
        return price + abs(off) if segment.is_clipped else price
    return price


def _askew(
    segment: _Segment, windows: Sequence[Window], turned: Array, *, strict: bool
) -> float:
    """Return how far a rest is off the attitude of windows [rad]; infinite if far."""
    window = windows[0]
    if segment.force is None or window.sense:
        return 0.0
    up = window.setting.to_body @ np.array([0.0, 0.0, 1.0])
    off = acos(float(np.clip(up @ turned @ segment.force, -1.0, 1.0)))
    if off <= NEAR:
        return off
    long = abs(log(segment.length / sum(one.length for one in windows)))
    return inf if strict or long > LONG else ELSEWHERE


def _split(segment: _Segment, windows: Sequence[Window]) -> Iterator[_Span]:
    """Yield parts of a segment, as long beside each other as the windows are."""
    total = sum(one.length for one in windows)
    begin = segment.start
    for one in windows:
        end = begin + segment.length * one.length / total
        yield _Span(track=segment.track, start=begin, end=end, rests=segment.rests)
        begin = end
