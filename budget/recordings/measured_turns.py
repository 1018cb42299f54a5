"""Samples of the gyro between the dwells of a recording, where it turns any way."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from budget.model.measured import MeasuredTurn
from budget.model.source import GYRO
from budget.recordings.health import SPIKE, WindowReadings, spikes
from budget.recordings.track import LEAST_SAMPLES, limits_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.recordings.track import RecordedTrack, WindowSpan

CLEAR = 0.01  # of the largest rate, that a spike in a turn is off by at the least [1]


def measured_turns(
    tracks: Sequence[RecordedTrack], spans: Sequence[WindowSpan], begin: float
) -> tuple[tuple[MeasuredTurn, ...], tuple[int, ...]]:
    """Return the turns between dwells one after the other, and those left out.

    These by the number of the dwell before, from 1: a turn from one file to another,
    with a gap, or with saturated or stuck samples; how it was turned there nobody
    knows. A sample is the mean rate until the next. `begin` is when the first window
    does, on the clock of the run [s].
    """
    found, left_out = [], []
    for number, (one, other) in enumerate(pairwise(spans), start=1):
        track = tracks[one.track]
        if GYRO not in track.values:
            continue
        if one.track != other.track:
            left_out.append(number)
            continue
        times, values = track.values[GYRO]
        limits = limits_of(track, one)[1], limits_of(track, other)[0]
        a, b = np.searchsorted(times, limits).tolist()
        if b - a < LEAST_SAMPLES or not np.isfinite(values[:, a:b]).all():
            left_out.append(number)
            continue
        before, after = max(a - 1, 0), min(b + 1, len(times))
        readings = WindowReadings(
            times=times[before:after],
            values=values[:, before:after],
            first=a - before,
            last=b - before,
            rate=track.rate,
            is_turn=True,
            has_angle=True,
        )
        own = readings.own
        ends = (own.min(axis=1) - 1.0, own.max(axis=1) + 1.0)
        _, health = readings.mean(track.usual[GYRO], ends, track.range_end.get(GYRO))
        if health.missing or health.is_spoilt or any(health.stuck):
            left_out.append(number)
            continue
        rates = _without_spikes(own, track)
        steps = np.diff(np.append(times[a:b], times[b - 1] + 1.0 / track.rate))
        found.append(
            MeasuredTurn(
                first=number - 1,
                last=number,
                start=float(times[a]) + track.offset - begin,
                lengths=steps,
                rates=rates,
            )
        )
    return tuple(found), tuple(left_out)


def _without_spikes(values: Array, track: RecordedTrack) -> Array:
    """Return readings, (3, n), with the median of those beside a spike in its place."""
    from scipy.ndimage import median_filter

    least = CLEAR * float(np.abs(values).max())
    rows = []
    for own, usual in zip(values, track.usual[GYRO], strict=True):
        step = usual.step if usual is not None else 0.0
        is_spike = spikes(own, step, least)
        middle = median_filter(own, SPIKE, mode="nearest")
        rows.append(np.where(is_spike, middle, own))
    return np.array(rows)
