"""Sampling interval of the largest of several interval ends that trials estimate.

The largest of n estimates lies too high, the more the more of them tie; so does the
largest of any resampling of them. What is wanted is an interval for the largest of the
true ends. With T the estimates, s their standard errors and Z their joint normal noise,

    low = max_k (T_k - c s_k) ,  c the 97.5 % quantile of max_k Z_k/s_k ,
    high = max_k (T_k + z s_k) ,  z the 97.5 % quantile of one normal :

all T_k - c s_k lie below their true values together with 97.5 %, and so does the
largest of them; T_k + z s_k of the truly largest lies above it with 97.5 %, and the
largest of them is no smaller. Ends that are too far below to be the largest are left
out of c (intersection bounds with selection: Chernozhukov, Lee and Rosen 2013).

Ends that the law gives have no noise but a bound, which both limits count in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import normal_coverage_factor
from budget.methods.execution import small_blocks, stream
from budget.methods.intervals import interval_of_values, sort_tails

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array

BATCH = 512  # trials that are one point of the noise
CONFIDENCE = 0.95  # of sampling intervals
FAR = 3.0  # standard errors of each of two ends that cannot be equal [1]
DRAWS = 2048  # of the joint noise
CHUNK = 256  # batches that are drawn for at once
SPACING = 0.125  # of a tail, to either side, over which a density is taken [1]
SLACK = 4  # trials, by which places in a tail are rounded


@dataclass(frozen=True, kw_only=True, eq=False)
class Ends:
    """Ends of coverage intervals over their limits."""

    value: Array  # [1], shape (n,)
    # What each batch of trials moves an end by; times independent unit normals and
    # summed it is the joint noise, shape (n_batches, n). 0 where the law gave the end
    # [1].
    noise: Array
    # What the law can be off by; 0 where trials gave the end, shape (n,) [1].
    bound: Array

    @property
    def error(self) -> Array:
        """Standard errors, shape (n,) [1]."""
        return np.asarray(np.sqrt((self.noise**2).sum(axis=0)))

    @property
    def largest(self) -> float:
        """The largest end [1]."""
        return float(self.value.max())


def ends_of_trials(
    values: Array, ordered: Array, limits: Array, coverage: float | Array
) -> Ends:
    """Find the ends of symmetric intervals over their limits, and how trials move them.

    The influence of one trial y on the quantile q of probability p is
    (p - [y <= q])/(f M), f the density there; the upper and the negative lower ends of
    all outputs stand one after another. Trials have the shape (n_out, M), in their
    order and ascending (`ends_in_order` of them), limits (n_out,) [SI], as the
    coverages [1].
    """
    M = values.shape[1]
    tail = (1.0 - np.broadcast_to(coverage, len(values))) / 2.0
    ends = interval_of_values(ordered, coverage, "symmetric")
    reach = np.maximum(np.round(tail * M * SPACING).astype(int), 1)
    rows = np.arange(len(values))
    starts = np.arange(0, M, BATCH)
    size = np.diff(np.append(starts, M))
    noise = []
    for sign, p, end in ((1.0, 1.0 - tail, ends[:, 1]), (-1.0, tail, ends[:, 0])):
        place = np.round(p * M).astype(int)
        first, last = np.maximum(place - reach, 0), np.minimum(place + reach, M - 1)
        rise = ordered[rows, last] - ordered[rows, first]
        slope = rise / np.maximum(last - first, 1)  # 1/(f M)
        below = np.add.reduceat(values <= end[:, None], starts, axis=1, dtype=float)
        moved = sign * slope[:, None] * (p[:, None] * size - below)
        # Counts of few batches are a rough variance; the binomial one is known.
        found = np.sqrt((moved**2).sum(axis=1))
        known = slope * np.sqrt(M * p * (1.0 - p))
        moved *= (known / np.where(found > 0.0, found, 1.0))[:, None]
        noise.append(moved / limits[:, None])
    return Ends(
        value=np.concatenate([ends[:, 1] / limits, -ends[:, 0] / limits]),
        noise=np.concatenate(noise).T,
        bound=np.zeros(2 * len(limits)),
    )


def ends_in_order(values: Array, coverage: float | Array) -> Array:
    """Return trials, shape (n_out, M), ascending as far as `ends_of_trials` looks."""
    tail = (1.0 - np.broadcast_to(coverage, len(values))) / 2.0 * values.shape[1]
    return sort_tails(values, np.ceil(tail * (1.0 + SPACING)).astype(int) + SLACK)


def half_widths(ends: Ends) -> Array:
    """Return half the 95 % sampling interval of each end, shape (n,) [1]."""
    return normal_coverage_factor(CONFIDENCE) * ends.error


def sampling_interval(ends: Ends) -> tuple[float, float]:
    """Return the 95 % interval of the largest of the true ends [1]."""
    z = normal_coverage_factor(CONFIDENCE)
    error = ends.error
    near = np.logical_and(_candidates(ends), error > 0.0)
    c = z
    if near.sum() > 1:
        largest = _noise(ends.noise[:, near] / error[near]).max(axis=1)
        c = max(z, float(np.quantile(largest, (1.0 + CONFIDENCE) / 2.0)))
    low = float((ends.value - c * error - ends.bound).max())
    return max(low, 0.0), float((ends.value + z * error + ends.bound).max())


def joined(parts: Sequence[Ends]) -> Ends:
    """Return the ends of several problems, found on the same trials, as one."""
    return Ends(
        value=np.concatenate([one.value for one in parts]),
        noise=np.concatenate(_as_long([one.noise for one in parts]), axis=1),
        bound=np.concatenate([one.bound for one in parts]),
    )


def _as_long(noises: Sequence[Array]) -> list[Array]:
    """Bring noise to as many batches as the longest has; nothing moves in the rest."""
    n = max(map(len, noises))
    return [np.pad(noise, ((0, n - len(noise)), (0, 0))) for noise in noises]


def probability_smaller(a: Ends, b: Ends) -> float:
    """Return the probability that the largest of a's true ends is the smaller one.

    Both were found on the same trials, so batches of the same place move both. It is
    taken once with each largest end as it was found, which ties lift, and once as
    if all ends that could be the largest were equal, which lowers it by what such a
    tie lifts; and over what the law can be off by. The least decided of these counts:
    0.5 where they do not agree on which is the smaller one.
    """
    noise_a, noise_b = _as_long([a.noise, b.noise])
    difference = a.largest - b.largest
    bound = _reach(a) + _reach(b)
    near_a, near_b = _candidates(a), _candidates(b)
    single = noise_a[:, a.value.argmax()] - noise_b[:, b.value.argmax()]
    found = [
        _below(difference + side * bound, float(np.sqrt((single**2).sum())))
        for side in (-1.0, 1.0)
    ]
    if near_a.sum() > 1 or near_b.sum() > 1:
        both = np.concatenate([noise_a[:, near_a], noise_b[:, near_b]], axis=1)
        if both.any():
            drawn = _noise(both)
            first = int(near_a.sum())
            lifted = drawn[:, :first].max(axis=1) - drawn[:, first:].max(axis=1)
            found += [
                float((difference + side * bound - lifted < 0.0).mean())
                for side in (-1.0, 1.0)
            ]
    if min(found) <= 0.5 <= max(found):  # noqa: PLR2004 - they do not agree
        return 0.5
    return min(found, key=lambda p: abs(p - 0.5))


def is_same(a: Ends, b: Ends) -> bool:
    """Whether all ends that could be the largest are the same, trial by trial.

    Then `probability_smaller` is 0.5 with any number of trials: the others are too far
    below to count in it, and more trials draw nothing that moves one alone.
    """
    near_a, near_b = _candidates(a), _candidates(b)
    noise_a, noise_b = _as_long([a.noise, b.noise])
    return (
        np.array_equal(a.value[near_a], b.value[near_b])
        and np.array_equal(a.bound[near_a], b.bound[near_b])
        and np.array_equal(noise_a[:, near_a], noise_b[:, near_b])
    )


def _candidates(ends: Ends) -> Array:
    """Return which ends could be the largest, shape (n,)."""
    reach = FAR * ends.error + ends.bound
    return np.asarray(ends.value + reach >= (ends.value - reach).max())


def _reach(ends: Ends) -> float:
    """Return by how much the largest end can be off by the law [1]."""
    return max(
        float((ends.value + ends.bound).max()) - ends.largest,
        ends.largest - float((ends.value - ends.bound).max()),
    )


def _below(difference: float, error: float) -> float:
    """Return the probability that a difference so found is below 0 in truth."""
    from scipy.special import ndtr

    if error > 0.0:
        return float(ndtr(-difference / error))
    return 0.5 if difference == 0.0 else float(difference < 0.0)


def _noise(per_batch: Array) -> Array:
    """Draw joint noise, shape (DRAWS, n), from that of batches, (n_batches, n)."""
    total = np.zeros((DRAWS, per_batch.shape[1]))
    with small_blocks():
        for chunk, start in enumerate(range(0, len(per_batch), CHUNK)):
            part = per_batch[start : start + CHUNK]
            total += _multipliers(chunk)[:, : len(part)] @ part
    return total


@lru_cache(maxsize=2)
def _multipliers(chunk: int) -> Array:
    """Draw unit normals, shape (DRAWS, CHUNK), the same in every comparison."""
    drawn = stream(0, "noise of ends", chunk).standard_normal((DRAWS, CHUNK))
    drawn.flags.writeable = False
    return drawn
