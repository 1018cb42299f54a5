"""Tables of a recorded calibration: means of its windows, or when each was."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import Issue, SpecError, UnitError
from budget.inputs.reader import refuse
from budget.inputs.tree import describe
from budget.journal import note_read
from budget.model.measured import turns_of_rows
from budget.model.source import GYRO, SENSORS
from budget.model.windows import dwells_of
from budget.names import AXES
from budget.recordings.columns import CHANNELS, COUNTS, TIME, read_head
from budget.recordings.tables import ARRAYS
from budget.recordings.track import MOST, MOST_ISSUES, WindowSpan

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from budget.arrays import Array
    from budget.inputs.records import Recording
    from budget.model.measured import MeasuredTurn
    from budget.model.windows import Window
    from budget.recordings.health import ReadingSteps, WindowHealth

WINDOW, DURATION, START, END = "window", "duration", "start", "end"
MOST_BYTES = 16 * 1024 * 1024  # of a table of windows
LEAST_LENGTH = 1e-3  # of a window [s]
SAME_TIME = 1e-6  # that windows given may lie over each other [s]


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
    steps : mapping of str to tuple of ReadingSteps
        By triad, of each axis; likewise.
    turns : tuple of MeasuredTurn
        From one dwell to another, where attitudes are unknown; windows are then dwells.
    turns_left_out : tuple of int
        Numbers, from 1, of the dwells before those that have too little that is sound.
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
    steps: Mapping[str, tuple[ReadingSteps, ...]] = field(default_factory=dict)
    turns: tuple[MeasuredTurn, ...] = ()
    turns_left_out: tuple[int, ...] = ()


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


def read_table(path: Path, shown: str, recording: Recording) -> _WindowTable | None:
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


def windows_of_table(
    table: _WindowTable,
    windows: Sequence[Window],
    name: str,
    file: tuple[Path, str],
    *,
    knows_attitudes: bool,
) -> RecordedWindows:
    """Return the means of a table, a row for each window of the procedure.

    Of unknown attitudes those of moves are turns between dwells, or there are none.

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
    dwells = dwells_of(windows)
    if not knows_attitudes and len(table.rows) == len(dwells):
        windows = dwells
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
    means = {
        kind: np.array([values.get(f"{kind}_{axis}", nothing) for axis in AXES])
        for kind in kinds
    }
    turns: tuple[MeasuredTurn, ...] = ()
    if not knows_attitudes:
        rates = means.get(GYRO, np.full((3, len(there)), np.nan))
        still, turns = turns_of_rows(there, rates)
        there = [there[k] for k in still]
        means = {kind: mean[:, still] for kind, mean in means.items()}
    return RecordedWindows(
        name=path.name,
        sha256=((path.name, sha256(path.read_bytes()).hexdigest()),),
        windows=tuple(there),
        turns=turns,
        means=means,
        has_counts={
            kind: any(columns[one].has_counts for one in own if one.startswith(kind))
            for kind in kinds
        },
    )


def given_spans(
    path: Path, shown: str, windows: Sequence[Window]
) -> Iterator[WindowSpan]:
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
        yield WindowSpan(track=0, start=start, end=end)


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
