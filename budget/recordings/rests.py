"""Rests in a long recording, and the turns between them.

A rest is where the gyro is quiet and reads what it reads at rest; what is between two
rests is a turn, by the angle that its rates add up to.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import cos, degrees, inf, radians
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.source import ACCELEROMETER, GYRO
from budget.names import AXES
from budget.recordings.health import AT_END, MOST_JITTER, saturated_in
from budget.recordings.track import LEAST_SAMPLES, RecordedTrack

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.windows import Window

LOOK = 0.25  # s over which it is quiet or not, and that ends of rests are trimmed by
QUIET = 4.0  # times the lower decile of the scatter [1]
STILL = radians(1.0)  # rate that a rest may be off the others [rad/s]
SIGMAS = 5.0  # times the scatter, likewise [1]
STEPS = 0.02  # of the range, that a step of readings may be [1]
LEAST_REST = 1.0  # [s]
NEAR = radians(25.0)  # of a face
MOVING = 0.02  # of the largest rate, from which a turn has begun [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class RestOrTurn:
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


def rests_and_turns(
    track: RecordedTrack, windows: Sequence[Window], still: float, *, is_joined: bool
) -> list[RestOrTurn]:
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
    found: list[RestOrTurn] = []
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
            RestOrTurn(
                track=track.number,
                start=float(times[a]) + LOOK,
                end=float(times[b - 1]) + 1.0 / track.rate - LOOK,
                is_rest=True,
                force=forces[k],
            )
        )
    return [one for one in found if one.length > 0.0]


def _rest_of(
    track: RecordedTrack,
    kind: str,
    values: Array,
    windows: Sequence[Window],
    still: float,
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


def _coarseness(track: RecordedTrack, kind: str, values: Array) -> float:
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


def _forces(
    track: RecordedTrack, spans: Sequence[tuple[float, float]]
) -> list[Array | None]:
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
    track: RecordedTrack,
    rates: Array,
    places: tuple[tuple[int, int], tuple[int, int]],
    forces: Sequence[Array | None],
) -> RestOrTurn:
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
    return RestOrTurn(
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


def _is_clipped(track: RecordedTrack, values: Array) -> bool:
    """Whether readings of a turn are at the end of the range, (3, n)."""
    stated = track.range_end.get(GYRO)
    return any(
        saturated_in(own, usual, stated).sum() >= AT_END
        for own, usual in zip(values, track.usual[GYRO], strict=True)
        if usual is not None and own.size
    )
