"""A recording of a calibration kept whole, and recordings put on one clock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.inputs.reader import refuse
from budget.model.source import ACCELEROMETER, GYRO, SENSORS
from budget.names import AXES
from budget.recordings.columns import COUNTER, TIME, RecordedColumn
from budget.recordings.health import MOST_JITTER, SPIKE, UsualSteps, spikes
from budget.recordings.log import (
    SAME_RATE,
    check_stamps,
    likely_unit,
    open_table,
    stated_end,
)
from budget.recordings.tables import NumberTable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Recording

MOST_ROWS = 10_000_000  # of a recording that is kept whole: some 3 GB
MOST_ISSUES = 5
MOST = 1e12  # of a reading or a time, as it is written
LEAST_SAMPLES = 3  # of a window
EARLY = 0.25  # intervals that a sample may be before a span and be of it [1]
ON_TIME = 0.5  # intervals that the first sample of the next file may be off [1]


def limits_of(track: RecordedTrack, span: WindowSpan) -> tuple[float, float]:
    """Return the ends of a span: a stamp is one to rounding, a quarter of a sample."""
    early = EARLY / track.rate
    return span.start - early, span.end - early


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedTrack:
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


def read_track(recording: Recording) -> RecordedTrack:
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
    return RecordedTrack(
        values=values,
        counts=counts,
        rate=min(rates),
        sha256=tuple(files),
        range_end=ends,
        likely_unit=unit,
    )


def on_one_clock(tracks: Sequence[RecordedTrack]) -> Iterator[RecordedTrack]:
    """Yield recordings of one run on one clock; those without a pause are one.

    Where stamps of one do not go on after those of the one before, it begins where
    that ended.
    """
    last: RecordedTrack | None = None
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


def _goes_on(last: RecordedTrack, own: RecordedTrack) -> bool:
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


def _joined(last: RecordedTrack, own: RecordedTrack) -> RecordedTrack:
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
class WindowSpan:
    """When one window was, and of a turn the rests before and after it."""

    track: int
    start: float
    end: float
    rests: tuple[tuple[float, float], tuple[float, float]] | None = None
