"""Motion at the edges of a recorded turn, which is part of its whole turns."""

from __future__ import annotations

from math import pi, remainder
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import GYRO
from budget.recordings.rests import LOOK, SIGMAS
from budget.recordings.track import (
    EARLY,
    LEAST_SAMPLES,
    RecordedTrack,
    WindowSpan,
    limits_of,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.recordings.health import WindowHealth

FARTHEST = 1.0  # into a rest, that motion beyond the edge of a turn is looked for [s]
UNEVEN = 1e-3  # of a circle's radius, that means over a turn may be off its middle [1]
MARGIN = 0.1  # beyond what is seen of that [s]


def mean_in_ramps(
    track: RecordedTrack, span: WindowSpan, angle: float, health: WindowHealth
) -> Array:
    """Return what the mean of a turn would read more, were its rate one, (3,)."""
    found = _edges(track, span) / (span.end - span.start)
    return found if health.missing else found - _uneven(track, span, angle)


def _edges(track: RecordedTrack, span: WindowSpan) -> Array:
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


def _uneven(track: RecordedTrack, span: WindowSpan, angle: float) -> Array:
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
    a, b = np.searchsorted(times, limits_of(track, span)).tolist()
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
