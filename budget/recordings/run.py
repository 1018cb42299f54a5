"""A recorded calibration read: its windows, found by rest and turn, and their means.

A table has a row of means for each window of the procedure. In a long recording a rest
is where the gyro is quiet and reads what it reads at rest; what is between two rests is
a turn where its angle is that of whole turns. Rests and turns are matched to the
windows of the procedure in their order.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.source import GYRO, SENSORS
from budget.model.windows import dwells_of
from budget.recordings.health import (
    ReadingSteps,
    WindowHealth,
    WindowReadings,
    ends_of,
)
from budget.recordings.matching import matched_windows
from budget.recordings.measured_turns import measured_turns
from budget.recordings.track import (
    LEAST_SAMPLES,
    RecordedTrack,
    WindowSpan,
    limits_of,
    on_one_clock,
    read_track,
)
from budget.recordings.turn_edges import mean_in_ramps
from budget.recordings.window_table import (
    LEAST_LENGTH,
    RecordedWindows,
    given_spans,
    read_table,
    windows_of_table,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from budget.inputs.records import Recording
    from budget.model.windows import Window
    from budget.recordings.rests import RestOrTurn


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
    if len(paths) == 1 and (table := read_table(*paths[0], first)) is not None:
        return windows_of_table(
            table, windows, name, paths[0], knows_attitudes=knows_attitudes
        )
    windows = windows if knows_attitudes else dwells_of(windows)
    spans: Sequence[WindowSpan]
    found: Sequence[RestOrTurn] = ()
    is_as_planned = True
    tracks = [*on_one_clock([read_track(one) for one in recordings])]
    if times is not None:
        if len(tracks) > 1:
            raise CallError(
                "a table of windows is of one recording, and several are given; join "
                "them, or leave --windows out"
            )
        spans = list(given_spans(*times, windows))
    else:
        fit = matched_windows(tracks, windows, name, knows_attitudes=knows_attitudes)
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
                    mean = mean + mean_in_ramps(track, span, angle, health[kind][k])
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
    between = () if knows_attitudes else spans
    turns, left_out = measured_turns(tracks, between, begin)
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
        steps={kind: tuple(_steps(kind, tracks, parts)) for kind in kinds},
        turns=turns,
        turns_left_out=left_out,
    )


def _parts(
    name: str,
    tracks: Sequence[RecordedTrack],
    spans: Sequence[WindowSpan],
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
            limits = limits_of(track, span)
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


def _steps(
    kind: str,
    tracks: Sequence[RecordedTrack],
    parts: Sequence[Mapping[str, WindowReadings]],
) -> Iterator[ReadingSteps]:
    """Yield the steps of a triad's readings beside their noise at rest, by axis."""
    usual = next(one.usual[kind] for one in tracks if kind in one.values)
    rests = [one[kind].own for one in parts if kind in one and not one[kind].is_turn]
    for axis, common in enumerate(usual):
        step = 0.0 if common is None else common.step
        yield ReadingSteps.of([one[axis] for one in rests], step)


def _passed_over(
    found: Sequence[RestOrTurn], spans: Sequence[WindowSpan]
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
