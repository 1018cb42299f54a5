"""A recording read once: means of blocks, the first samples, and its health.

Samples stand on a grid of equal intervals: stamps, or a counter, say where some are
missing. A sample that is stuck, saturated or an outlier is kept out as if it were
missing, and counted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from budget.errors import CallError, Issue, SpecError, UnitError
from budget.inputs.reader import refuse
from budget.recordings.columns import (
    CHANNELS,
    COUNTER,
    COUNTS,
    EXAMPLE,
    SKIPPED,
    TEMPERATURE,
    TIME,
    RecordedColumn,
    read_head,
    twice,
)
from budget.recordings.health import (
    FAR,
    MOST_JITTER,
    MOST_LISTED,
    MOST_OUTLIERS,
    KeptOut,
    Look,
)
from budget.recordings.tables import NumberTable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Recording
    from budget.recordings.tables import TablePiece

    Progress = Callable[[float], None]

LEAST_ROWS = 100
SHORTEST, LONGEST = 1e-5, 10.0  # between two samples [s]
LIKELY = 1e-4, 0.2  # likewise, of most recordings [s]
SLOW, LONG = 1.0, 172800.0  # interval and duration, up to which seconds are likely [s]
FACTORS = (1e3, 1e6, 1e9, 1e-3, 1e-6, 1e-9)  # of one unit of time over another [1]
STAMPS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # [s]
SAME_UNIT = 0.05  # of such a factor [1]
FIRST_BLOCK = 10  # samples
MOST_BLOCKS = 2**17  # before two of them become one
HEAD = 2**21  # samples that are kept singly
MOST_GAPS = 0.05  # of steps, from where stamps are those of something else [1]
MOST_MISSING = 3.0  # samples, over those that are there [1]
SAME_RATE = 5e-3  # of a rate that is stated and that of stamps [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One axis of one sensor as it was recorded.

    Attributes
    ----------
    name : str
        'gyro_x'.
    sums, counts : ndarray, shape (n,)
        Of the samples of each block that are there [SI, or counts].
    head : ndarray, shape (k,)
        The first samples, nan where one is missing or kept out.
    kept_out : KeptOut
    has_counts : bool
        Whether it is in counts, as no gain is known.
    """

    name: str
    sums: Array
    counts: Array
    head: Array
    kept_out: KeptOut
    has_counts: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """A recording at rest.

    Attributes
    ----------
    name : str
        Of its file.
    sha256 : tuple of (str, str)
        Names of its files, and what they hold.
    rate : float
        [Hz].
    rows : int
        Samples that were read.
    samples : int
        Places of the grid from the first to the last.
    gaps, missing : int
        Steps over more than one place, and places that are empty.
    block : int
        Samples of a block.
    channels : mapping of str to Channel
    temperature : ndarray or None, shape (n,)
        Means of blocks, nan where there is none [degC].
    skipped : tuple of str
        Heads of columns that are not read.
    has_stamps : bool
        Whether stamps or a counter say where samples are missing.
    likely_unit : str
        That stamps may be in, which come seldom where their head is right; else ''.
    """

    name: str
    sha256: tuple[tuple[str, str], ...]
    rate: float
    rows: int
    samples: int
    gaps: int
    missing: int
    block: int
    channels: Mapping[str, Channel]
    temperature: Array | None
    skipped: tuple[str, ...]
    has_stamps: bool
    likely_unit: str = ""

    @property
    def duration(self) -> float:
        """From the first sample to the end of the last [s]."""
        return self.samples / self.rate


def read_logs(
    recording: Recording, progress: Progress | None = None
) -> tuple[Log, ...]:
    """Read a recording: files of the same columns one after the other in time.

    Files of different columns, a triad each, are logs of their own.

    Raises
    ------
    SpecError
        What is wrong with its files, each at its line.
    CallError
        Columns or rate are not known.
    """
    tables = [NumberTable(path, shown) for path, shown in recording.files]
    groups: dict[tuple[str, ...], list[_Opened]] = {}
    for table in tables:
        opened = open_table(table, recording)
        key = tuple(sorted(one.name for one in opened.columns if one.name))
        groups.setdefault(key, []).append(opened)
    names = [name for key in groups for name in key if name in CHANNELS]
    if len(names) > len({*names}):
        raise CallError(
            f"{recording.name}: its files share some columns and not all, expected "
            "the same in each, or none twice"
        )
    sizes = sum(table.size for table in tables)
    found, done = [], 0.0
    for group in groups.values():
        group.sort(key=lambda one: one.first)
        reading = _Reading(recording, group)
        for opened in group:
            part = opened.table.size / max(sizes, 1)
            for piece in opened.pieces():
                reading.take(opened, piece)
                if progress:
                    progress(min(done + part * piece.done, 1.0))
            done += part
        found.append(reading.log())
    return tuple(found)


class _Opened(NamedTuple):
    """A table and what its columns are."""

    table: NumberTable
    columns: tuple[RecordedColumn, ...]

    @property
    def wanted(self) -> list[int]:
        """Places of the columns that are read."""
        return [k for k, one in enumerate(self.columns) if one.name]

    @property
    def read(self) -> dict[str, tuple[int, RecordedColumn]]:
        """What is read, by name, and at which place of a piece."""
        kept = [self.columns[k] for k in self.wanted]
        return {one.name: (k, one) for k, one in enumerate(kept)}

    @property
    def first(self) -> float:
        """The first stamp, 0 without stamps."""
        if TIME not in self.read:
            return 0.0
        place, column = self.read[TIME]
        piece = next(self.pieces())
        return float(piece.values[0, place]) * (column.size or 1.0)

    def pieces(self) -> Iterator[TablePiece]:
        """Yield what is read."""
        return self.table.pieces(self.wanted)


def open_table(table: NumberTable, recording: Recording) -> _Opened:
    """Find what the columns of a table are.

    Raises
    ------
    SpecError
        Heads that are none, or nothing that is to be read.
    """
    heads: Sequence[str] = recording.columns or table.heads
    if not heads:
        raise refuse(
            table.shown,
            f"has {table.width} columns without heads; name them with --columns "
            f"'{EXAMPLE}', _ for one that is not to be read",
        )
    if len(heads) != table.width:
        raise refuse(
            table.shown,
            f"has {table.width} columns, and {len(heads)} are named by --columns or "
            "its recording file; name each, _ for one that is not to be read",
        )
    columns, issues = [], []
    counter = recording.counter[0] if recording.counter else COUNTER
    for place, head in enumerate(heads):
        try:
            if head.strip() == counter:
                column = RecordedColumn(name=COUNTER, head=head)
            elif head.strip() == SKIPPED:
                column = RecordedColumn(head="")
            else:
                column = read_head(head, increments=recording.increments)
        except UnitError as error:
            message = f"head {place + 1}: {error}; or name columns with --columns"
            issues.append(
                Issue(file=table.shown, line=1, column=1, field="", message=message)
            )
            continue
        columns.append(_with_gain(column, recording))
    if issues:
        raise SpecError(tuple(issues[:MOST_LISTED]))
    if again := twice(columns):
        message = f"names two columns {again!r}, expected one; skip one with _"
        raise refuse(table.shown, message)
    if not any(one.name in CHANNELS for one in columns):
        raise refuse(
            table.shown,
            "names no column of a gyro or an accelerometer, expected heads as "
            f"{EXAMPLE}, or --columns with them",
        )
    return _Opened(table, tuple(columns))


def _with_gain(column: RecordedColumn, recording: Recording) -> RecordedColumn:
    """Return a column in counts with its gain, if that is known."""
    gain = recording.gain.get(column.sensor)
    if column.unit != COUNTS or gain is None:
        return column
    return replace(column, size=1.0 / gain)


def stated_end(recording: Recording, column: RecordedColumn) -> float | None:
    """Return the end of the range that is stated [rad/s, m/s^2]; None of counts."""
    return None if column.size is None else recording.saturation.get(column.sensor)


def check_stamps(
    shown: str, column: RecordedColumn, interval: float, recording: Recording
) -> None:
    """Refuse stamps that are not in the unit of their head.

    Parameters
    ----------
    interval : float
        Usual step of the stamps, in the unit of their head [s].

    Raises
    ------
    SpecError
        The interval is that of no recording, or a thousand times that of the rate.
    """
    size = column.size or 1.0
    if recording.rate:
        off = interval * recording.rate
        near = [x for x in FACTORS if abs(off / x - 1.0) < SAME_UNIT]
        if not near:
            return
        said = f"and the rate is given as {recording.rate:.6g} Hz"
        remedy = "leave the rate out"
    elif SHORTEST <= interval < LONGEST:
        return
    else:
        near = _likely(interval)
        said = f"expected {SHORTEST:g} to {LONGEST:g} s"
        remedy = "give --rate if that is so"
    if units := _units(size, near):
        remedy = (
            f"they look like {units[0]}: write 'time [{units[0]}]' in the head, or in "
            f"--columns; or {remedy}"
        )
    raise refuse(
        shown,
        f"stamps come every {interval:.6g} s, {said}; {remedy}, or skip the column "
        "(--columns with _ in its place)",
    )


def likely_unit(column: RecordedColumn, interval: float, duration: float = inf) -> str:
    """Return the unit that stamps may be in, which come seldom; '' of all others.

    A second and less between two is that of slow recordings, unless of days.

    Parameters
    ----------
    interval : float
        Usual step of the stamps, in the unit of their head [s].
    duration : float
        Of the recording likewise [s].
    """
    if interval <= LIKELY[1] or (interval <= SLOW and duration <= LONG):
        return ""
    return next(iter(_units(column.size or 1.0, _likely(interval))), "")


def _likely(interval: float) -> list[float]:
    """Return the factors by which stamps would be those of most recordings."""
    return [x for x in FACTORS if LIKELY[0] <= interval / x < LIKELY[1]]


def _units(size: float, factors: Sequence[float]) -> list[str]:
    """Return the units of stamps that are so much smaller than the one of the head."""
    return [
        name
        for name, own in STAMPS.items()
        for factor in factors
        if abs(size / factor / own - 1.0) < SAME_UNIT
    ]


class _Reading:
    """Sums over one recording while its pieces come."""

    def __init__(self, recording: Recording, group: Sequence[_Opened]) -> None:
        """Begin, with what its first file has."""
        first = group[0]
        self.recording, self.group = recording, group
        self.names = [one.name for one in first.columns if one.name in CHANNELS]
        self.of = {name: column for name, (_, column) in first.read.items()}
        has_rows = {TIME, COUNTER} & {*self.of}
        self.clock = TIME if TIME in has_rows else COUNTER if has_rows else ""
        if not recording.rate and self.clock != TIME:
            raise CallError(
                f"{recording.name}: nothing says how fast it was sampled; give "
                "--rate, as --rate 100, or a column time [s]"
            )
        if len(group) > 1 and self.clock != TIME:
            raise CallError(
                f"{recording.name}: several files of the same columns are joined by "
                "their stamps; give a column time [s], or name each as a log of its own"
            )
        k = len(self.names) + (TEMPERATURE in self.of)
        self.block = FIRST_BLOCK
        self.sums = np.zeros((k, MOST_BLOCKS))
        self.counts = np.zeros((k, MOST_BLOCKS))
        self.heads: list[Array] = []
        self.head_size = 0
        self.rows = self.gaps = self.missing = 0
        self.last = -1  # place of the last sample
        self.last_time = np.nan
        self.interval = 0.0  # usual step of the clock [s, or counts]
        self.regular, self.steps = 0.0, 0  # sum of usual steps, and how many
        self.looks: list[Look] = []
        self.kept = [KeptOut() for _ in self.names]

    def take(self, opened: _Opened, piece: TablePiece) -> None:
        """Add a piece."""
        read = opened.read
        values = np.stack(
            [
                piece.values[:, read[name][0]]
                * (read[name][1].sign * (read[name][1].size or 1.0))
                for name in self.names
            ]
        )
        place = self._places(opened, piece)
        self.rows += place.size
        if not self.looks:
            self.looks = [Look.of(one) for one in values]
        for k, name in enumerate(self.names):
            stated = stated_end(self.recording, self.of[name])
            if stated is not None and self.recording.increments:
                stated *= self._step()
            values[k], self.kept[k] = self.looks[k].clean(
                values[k], place, self.kept[k], stated
            )
        self._keep_head(values, place)
        if TEMPERATURE in read:
            at, column = read[TEMPERATURE]
            own = piece.values[:, at] * column.sign * (column.size or 1.0)
            values = np.vstack([values, own])
        while place[-1] // self.block >= MOST_BLOCKS:
            self._coarsen()
        number, start = place // self.block, int(place[0] // self.block)
        n = int(number[-1]) - start + 1
        for k, own in enumerate(values):
            there = np.isfinite(own)
            at = number[there] - start
            self.sums[k, start : start + n] += np.bincount(at, own[there], n)
            self.counts[k, start : start + n] += np.bincount(at, minlength=n)

    def _places(self, opened: _Opened, piece: TablePiece) -> NDArray[np.int64]:
        """Return where the samples of a piece stand on the grid."""
        n = len(piece.values)
        if not self.clock:
            found = self.last + 1 + np.arange(n, dtype=np.int64)
            self.last = int(found[-1])
            return found
        at, column = opened.read[self.clock]
        time = piece.values[:, at] * (column.size or 1.0)
        step = np.diff(time, prepend=self.last_time)
        if self.clock == COUNTER and self.recording.counter:
            step = np.mod(step, self.recording.counter[1])
        if np.isnan(self.last_time):
            step = step[1:]
        if back := np.flatnonzero(step <= 0.0).tolist():
            row = piece.line + back[0] + (1 if np.isnan(self.last_time) else 0)
            raise opened.table.fault(row, 1, self._back(step[back[0]]))
        if not self.interval:
            if step.size < LEAST_ROWS - 1:
                raise self._too_short(n)
            usual = float(np.median(step))
            self.interval = (
                1.0
                if self.clock == COUNTER
                else float(step[step <= MOST_JITTER * usual].mean())
            )
            if self.clock == TIME:
                check_stamps(opened.table.shown, column, self.interval, self.recording)
        is_gap = step > MOST_JITTER * self.interval
        if is_gap.sum() > max(MOST_GAPS * step.size, 1):
            unit = " s" if self.clock == TIME else ""
            raise refuse(
                opened.table.shown,
                f"from line {piece.line} on {is_gap.sum()} of {step.size} steps of its "
                f"{self.clock} are longer than {MOST_JITTER:g} times the usual one, "
                f"{self.interval:.6g}{unit}: these are not the times of samples; skip "
                "the column (--columns with _ in its place) and give --rate",
            )
        self.regular += float(step[~is_gap].sum())
        self.steps += int((~is_gap).sum())
        ahead = np.where(is_gap, np.rint(step / self.interval), 1.0).astype(np.int64)
        self.gaps += int(is_gap.sum())
        self.missing += int((ahead - 1).sum())
        if self.missing > MOST_MISSING * max(self.rows + n, LEAST_ROWS):
            raise refuse(
                opened.table.shown,
                f"leaves {self.missing} samples out beside {self.rows + n}: these are "
                "several recordings; give each as a log of its own",
            )
        begins = 0 if np.isnan(self.last_time) else None
        found = np.concatenate([[0], ahead]) if begins == 0 else ahead
        found = np.cumsum(found) + (0 if begins == 0 else self.last)
        self.last, self.last_time = int(found[-1]), float(time[-1])
        return np.asarray(found)

    def _step(self) -> float:
        """Return the time between two samples [s]."""
        rate = self.recording.rate
        return 1.0 / rate if rate else self.interval

    def _back(self, step: float) -> str:
        """Say what is wrong with a clock that does not go on."""
        what = "stands" if step == 0.0 else "goes back"
        return (
            f"{self.clock} {what} from the row before; leave out what was written "
            "twice, or skip the column (--columns with _ in its place) and give --rate"
        )

    def _too_short(self, rows: int) -> SpecError:
        """Return the error of a recording of a few rows."""
        shown = self.group[0].table.shown
        return refuse(shown, f"has {rows} rows, expected {LEAST_ROWS} at the least")

    def _keep_head(self, values: Array, place: NDArray[np.int64]) -> None:
        """Keep the first samples, nan where there is none."""
        start = int(place[0])
        if start >= HEAD:
            return
        some = place < HEAD
        n = int(place[some][-1]) + 1 - self.head_size
        own = np.full((len(self.names), n), np.nan)
        own[:, place[some] - self.head_size] = values[:, some]
        self.heads.append(own)
        self.head_size += n

    def _coarsen(self) -> None:
        """Make one block of two."""
        for one in (self.sums, self.counts):
            one[:, : MOST_BLOCKS // 2] = one[:, ::2] + one[:, 1::2]
            one[:, MOST_BLOCKS // 2 :] = 0.0
        self.block *= 2

    def log(self) -> Log:
        """Return what has been read.

        Raises
        ------
        SpecError
            Too few rows, or too many outliers.
        CallError
            The rate that is stated is not that of the stamps.
        """
        if self.rows < LEAST_ROWS:
            raise self._too_short(self.rows)
        rate = self._rate()
        shown = self.group[0].table.shown
        for name, kept in zip(self.names, self.kept, strict=True):
            if kept.outliers > MOST_OUTLIERS * self.rows:
                raise refuse(
                    shown,
                    f"{100.0 * kept.outliers / self.rows:.3g} % of {name} lie more "
                    f"than {FAR:g} robust sigmas off their neighbours, 1 % at the "
                    "most are outliers: it was not at rest, or is no {name}; cut the "
                    "recording to where it is at rest".replace("{name}", name),
                )
        n = self.last // self.block + 1
        head = np.concatenate(self.heads, axis=1)
        steps = rate if self.recording.increments else 1.0
        channels = {}
        for k, name in enumerate(self.names):
            kept = self.kept[k]
            if not self.counts[k, :n].sum():
                raise refuse(
                    shown,
                    f"{name} has no sound sample: {kept.stuck} are stuck and "
                    f"{kept.saturated} saturated; skip it (--columns with _)",
                )
            first = tuple((at / rate, v * steps) for at, v in kept.first)
            channels[name] = Channel(
                name=name,
                sums=self.sums[k, :n] * steps,
                counts=self.counts[k, :n].copy(),
                head=head[k] * steps,
                kept_out=replace(kept, first=first),
                has_counts=self.of[name].unit == COUNTS and self.of[name].size is None,
            )
        temperature = None
        if TEMPERATURE in self.of:
            own = self.counts[-1, :n]
            temperature = np.full(n, np.nan)
            np.divide(self.sums[-1, :n], own, out=temperature, where=own > 0)
        return Log(
            name=self.recording.name,
            sha256=tuple((one.table.path.name, one.table.sha256) for one in self.group),
            rate=rate,
            rows=self.rows,
            samples=self.last + 1,
            gaps=self.gaps,
            missing=self.missing,
            block=self.block,
            channels=channels,
            temperature=temperature,
            skipped=tuple(
                one.head for one in self.group[0].columns if not one.name and one.head
            ),
            has_stamps=bool(self.clock),
            likely_unit=""
            if self.recording.rate or self.clock != TIME
            else likely_unit(
                self.of[TIME], self.interval, (self.last + 1) * self.interval
            ),
        )

    def _rate(self) -> float:
        """Return the sampling rate, that is stated or that of the stamps [Hz]."""
        stated = self.recording.rate
        if self.clock != TIME:
            return float(stated or 0.0)
        found = self.steps / self.regular
        if stated and abs(stated / found - 1.0) > SAME_RATE:
            raise CallError(
                f"{self.recording.name}: the rate is given as {stated:.6g} Hz, and "
                f"its stamps come at {found:.6g} Hz; leave the rate out, or skip the "
                "column of stamps (--columns with _ in its place)"
            )
        return float(stated or found)
