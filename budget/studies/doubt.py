"""Doubt in a verdict that rests on predicted lines, and which line to ask for.

Of given sizes s of the missing lines, by the law of propagation with the coverage
factor k of each output as it was judged, a device meets where

    |mean| + k sqrt(V_0 + sum_m c_m s_m^2) <= limit   of every required output,

c_m being the variance that a missing line of size 1 makes, and V_0 all the rest, with
products of two lines as they are at the medians. With ln s of a joint Student t
(budget.missing.prediction), p = P(meets) and the doubt is D = min(p, 1 - p), the risk
of the likelier verdict. Knowledge of line m is worth

    D(p) - E[ D( P(meets | s_m) ) ] >= 0,

the expected value of partial perfect information of that loss, by strata of s_m as in
Strong, Oakley 2013. The points are those of a Kronecker sequence, the
same for all devices: the same numbers on every machine.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import small_blocks
from budget.missing.prediction import stand_in
from budget.names import Name
from budget.results import Ask, Doubt
from budget.ties import from_largest, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.methods.gum import Propagation
    from budget.missing.prediction import Prediction
    from budget.question import Limited
    from budget.studies.judgement import Judged

STRATA = 64  # of equal probability, of the line that becomes known
POINTS = 2**15  # in all of them
STRIDE = 4  # every so manieth point is enough for a range


def doubt_of(
    prediction: Prediction, held: Limited, law: Propagation, judged: Judged
) -> Doubt | None:
    """Return the probability to meet, and what each missing line is worth.

    None where the given lines are beyond a limit by themselves: nothing is in doubt.

    Parameters
    ----------
    prediction : Prediction
        Of the missing lines.
    held, law, judged
        With the lines at the medians of the prediction.
    """
    unit, room = rooms(prediction, held, law, judged)
    if (room < 0.0).any():
        return None
    ends = np.column_stack(
        [np.abs(law.mean[held.rows]), judged.factor, held.limits, unit.T, room]
    )
    # Equal axes are looked at once.
    unlike = {tuple(map(settle, row)): k for k, row in enumerate(ends.tolist())}
    kept = sorted(unlike.values())
    with small_blocks():
        p, reductions = weigh(prediction, unit[:, kept], room[kept])
        used = _range(prediction, ends[kept])
    return Doubt(
        probability=p,
        utilisation_90=used,
        asks=tuple(
            Ask(source=prediction.names[m], reduction=reductions[m])
            for m in from_largest(reductions)
        ),
    )


def rooms(
    prediction: Prediction, held: Limited, law: Propagation, judged: Judged
) -> tuple[Array, Array]:
    """Return what missing lines do to the outputs, and what these have room for.

    Returns
    -------
    ndarray, shape (n_missing, n_required)
        Variance for a line at its median [SI squared].
    ndarray, shape (n_required,)
        Variance that all of them may make together; below 0 where the other lines are
        beyond the limit by themselves [SI squared].
    """
    places = {group.name: place for place, group in enumerate(held.problem.groups)}
    filled = np.array(
        [
            places[Name(stand_in(name).name, owner=name.owner)]
            for name in prediction.names
        ]
    )
    unit = law.source_variance[np.ix_(filled, held.rows)]
    total = np.diag(law.covariance)[held.rows]
    left = held.limits - np.abs(law.mean[held.rows])
    allowed = np.where(
        judged.factor > 0.0,
        np.square(
            np.maximum(left, 0.0) / np.where(judged.factor > 0.0, judged.factor, 1.0)
        ),
        np.inf,
    )
    return unit, np.where(left < 0.0, -np.inf, allowed - (total - unit.sum(axis=0)))


def weigh(
    prediction: Prediction, unit: Array, room: Array
) -> tuple[float, list[float]]:
    """Return P(meets), and by how much each line would reduce the doubt.

    `unit` and `room` are those of `rooms`.
    """
    n = len(prediction.names)
    p, reductions = 0.0, []
    for m in range(n):
        # The line that becomes known comes first: draws are in the order of its size.
        order = [m, *(k for k in range(n) if k != m)]
        squared = squared_lines(prediction, order)
        meets = np.ones(POINTS, dtype=bool)
        for k in range(room.size):
            if unit[:, k].any():
                meets &= unit[order, k] @ squared <= room[k]
        known = meets.reshape(STRATA, -1).mean(axis=1)
        own = float(meets.mean())
        if m == 0:
            p = own
        after = float(np.minimum(known, 1.0 - known).mean()) if n > 1 else 0.0
        felt = bool(unit[m].any())
        reductions.append(max(min(own, 1.0 - own) - after, 0.0) if felt else 0.0)
    return p, reductions


def _range(prediction: Prediction, ends: Array) -> tuple[float, float]:
    """Return the central 90 % of the utilisation over the missing lines.

    A row of `ends` has |mean|, k, limit, unit variances and room of one output.
    """
    squared = squared_lines(prediction, range(len(prediction.names)))[:, ::STRIDE]
    used = np.zeros(squared.shape[1])
    for mean, k, limit, *unit, room in ends.tolist():
        rest = max(((limit - mean) / k) ** 2 - room, 0.0) if k > 0.0 else 0.0
        end = k * np.sqrt(rest + np.array(unit) @ squared)
        used = np.maximum(used, (mean + end) / limit)
    low, high = np.quantile(used, [0.05, 0.95])
    return float(low), float(high)


def squared_lines(prediction: Prediction, order: Sequence[int]) -> Array:
    """Return draws of squared lines over their medians, by the first of the order.

    Shape (n_missing, POINTS).
    """
    root = np.linalg.cholesky(prediction.scale[np.ix_(order, order)])
    return np.asarray(np.exp(2.0 * (root @ standard(len(order), prediction.df))))


@lru_cache(maxsize=16)
def standard(n: int, df: float) -> Array:
    """Return points of n uncorrelated Student t, by the first one, (n, POINTS).

    Normals over the root of chi^2/df, through their inverse distributions at the
    points (1/2 + i a_k) mod 1, a_k = g^-k with g^(n + 2) = g + 1: of low discrepancy.
    """
    from scipy.special import gammaincinv, ndtri

    g = 2.0
    for _ in range(64):  # the fixed point
        g = (1.0 + g) ** (1.0 / (n + 2))
    steps = g ** -np.arange(1.0, n + 2.0)
    u = np.mod(0.5 + np.outer(steps, np.arange(1, POINTS + 1)), 1.0)
    t = ndtri(u[:n]) / np.sqrt(2.0 * gammaincinv(df / 2.0, u[n]) / df)
    t = np.ascontiguousarray(t[:, np.argsort(t[0], kind="stable")])
    t.flags.writeable = False
    return t
