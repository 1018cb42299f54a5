"""The cheapest allocation: cost a (u_ref/u)^p of each source, limits on the outputs.

With x = log s the cost is a sum of exponentials and the logarithm of each interval end
is convex (budget.methods.scaling), so what is found is the optimum, and how far a point
is from it can be bounded without trusting the solver: by the residual of the conditions
of Karush, Kuhn and Tucker and by the duality gap.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.methods.allocation import SMALLEST, TARGET, TOUCHES, grow, proportional

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.methods.allocation import Task

GOOD = 1e-6  # residual and gap that are as good as none [1]
ROUNDS = 6  # of the solver, each from the point before
ITERATIONS = 500  # of the solver in one round
NEAR = 1e-5  # an output this close to its limit may have a multiplier [1]
SHARPENED = 1e-2  # the most that factors and multipliers move to be exact [1]
ALIKE = 1e-12  # limits closer than this have one multiplier [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Prices:
    """Cost of each source as a function of its factor: c s^-p."""

    c: Array  # cost at the present size, a (u_ref/u)^p, shape (n_src,) [unit of cost]
    p: Array  # powers, shape (n_src,) [1]

    def each(self, s: Array) -> Array:
        """Return the cost of each source, shape (n_src,)."""
        return np.asarray(self.c * np.maximum(s, SMALLEST) ** -self.p)


@dataclass(frozen=True, kw_only=True, eq=False)
class LeastCost:
    """The cheapest allocation, and what shows that it is one."""

    s: Array  # factors, shape (n_src,) [1]
    cost: float  # of the free sources [unit of cost]
    # Fall of the cost for a relative rise of each limit, - d cost / d log(limit), shape
    # (n_out,) [unit of cost]. Where several outputs bind in the same way only their sum
    # is determined.
    multiplier: Array
    # Largest component of the gradient that the multipliers leave, over the cost [1].
    residual: float
    gap: float  # the cost is at most this part above the least possible one [1]
    solver: str  # what the solver said of itself; it decides nothing

    @property
    def is_optimal(self) -> bool:
        """Whether residual and gap show the optimum, whatever the solver said."""
        return self.residual <= GOOD and self.gap <= GOOD


def least_cost(task: Task, prices: Prices) -> LeastCost:
    """Find the cheapest factors that keep every output within its limit.

    The task is feasible; prices of held sources count for nothing. Of the best point
    found `is_optimal` says whether it is good enough.
    """
    start = proportional(task)
    free = np.flatnonzero(task.free)
    if free.size == 0:
        return judge(task, prices, start, "nothing to choose")
    best = judge(task, prices, start, "not started")
    s = start
    for _ in range(ROUNDS):
        found, message = _solve(task, prices, s, free)
        # The solver keeps constraints to its own tolerance; ours is the limit itself.
        s = grow(task, task.clip(found), task.free)
        judged = judge(task, prices, s, message)
        if max(judged.residual, judged.gap) < max(best.residual, best.gap):
            best = judged
        if best.is_optimal:
            break
    sharp = grow(task, task.clip(_sharpen(task, prices, best)), task.free)
    sharper = judge(task, prices, sharp, best.solver)
    return sharper if sharper.is_optimal else best


def judge(task: Task, prices: Prices, s: Array, solver: str = "") -> LeastCost:
    """Find the multipliers that explain factors s best, and how much they leave.

    s, shape (n_src,), is within the limits [1]; `solver` says where it comes from.
    """
    from scipy.optimize import nnls

    free = np.flatnonzero(task.free)
    each = prices.each(s)[free]
    cost = float(each.sum())
    multiplier = np.zeros(len(task.limit))
    if free.size == 0 or cost == 0.0:
        return LeastCost(
            s=s, cost=cost, multiplier=multiplier, residual=0.0, gap=0.0, solver=solver
        )
    used = task.utilisation(s)
    active = np.flatnonzero(used > 1.0 - NEAR)
    # Everything relative to the cost, so that its unit cancels.
    slope = -prices.p[free] * each / cost
    ends = task.log_end_gradient(s)[active][:, free]
    at_high = s[free] >= task.high[free] * (1.0 - TOUCHES)
    at_low = (s[free] <= task.low[free] * (1.0 + TOUCHES)) & (s[free] > 0.0)
    unit = np.eye(free.size)
    # slope + ends^T mu + nu_high - nu_low = 0, all multipliers from 0 up.
    pushes = np.column_stack([ends.T, unit[:, at_high], -unit[:, at_low]])
    forces, _ = nnls(pushes, -slope) if pushes.size else (np.zeros(0), 0.0)
    left = slope + pushes @ forces
    multiplier[active] = cost * forces[: active.size]
    # The Lagrangian is convex: over any box it is above its tangent plane. Outside
    # this box one source alone costs more than all do here.
    x = np.log(s[free])
    high = np.log(task.high[free])
    low = np.maximum(
        np.log(np.maximum(task.low[free], SMALLEST)),
        np.log(np.maximum(prices.c[free], SMALLEST) / cost) / prices.p[free],
    )
    tilt = slope + ends.T @ forces[: active.size]
    fall = np.minimum(tilt * (high - x), tilt * (np.minimum(low, x) - x)).sum()
    slack = forces[: active.size] @ np.log(used[active])
    return LeastCost(
        s=s,
        cost=cost,
        multiplier=multiplier,
        residual=float(np.abs(left).max()),
        gap=float(max(-fall - slack, 0.0)),
        solver=solver,
    )


def _sharpen(task: Task, prices: Prices, found: LeastCost) -> Array:
    """Solve the conditions of the optimum that was found as equations, to rounding.

    A minimiser stops at 1e-6 of the least cost, where processors part. With the
    binding outputs A and the sources between their bounds known, x = log s and the
    multipliers mu of A, those that are as good as equal once, follow from

        d log(cost)/dx + sum_A mu d log(end)/dx = 0,    log(end / limit) = 0 in A.
    """
    from scipy.optimize import nnls, root
    from scipy.special import softmax

    s = found.s
    bound = (s >= task.high * (1.0 - TOUCHES)) | (s <= task.low * (1.0 + TOUCHES))
    inner = np.flatnonzero(task.free & ~bound)
    binding = np.flatnonzero(task.utilisation(s) > 1.0 - NEAR)
    rows = np.intersect1d(_different(task, s, alike=NEAR), binding)
    if inner.size == 0 or rows.size == 0:
        return s
    free = np.flatnonzero(task.free)
    among = np.searchsorted(free, inner)
    log_c, p = np.log(prices.c[free]), prices.p[free]
    size = softmax(log_c - p * np.log(s[free]))[among]
    slopes = task.log_end_gradient(s)[rows][:, inner]
    multiplier, _ = nnls(slopes.T, p[among] * size)
    rows, multiplier = rows[multiplier > GOOD], multiplier[multiplier > GOOD]

    def factors(x: Array) -> Array:
        moved = s.copy()
        moved[inner] = np.exp(x)
        return moved

    def left(unknown: Array) -> Array:
        moved, mu = factors(unknown[: inner.size]), unknown[inner.size :]
        share = softmax(log_c - p * np.log(moved[free]))[among]
        slopes = task.log_end_gradient(moved)
        return np.concatenate(
            [
                (mu @ slopes[rows][:, inner] - p[among] * share) / size,
                np.log(task.utilisation(moved)[rows] / TARGET),
            ]
        )

    start = np.concatenate([np.log(s[inner]), multiplier])
    with np.errstate(all="ignore"):  # a step may go far; what it leads to is judged
        sharp = root(left, start, tol=1e-15)
    near = np.isfinite(sharp.x).all() and np.abs(sharp.x - start).max() < SHARPENED
    return factors(sharp.x[: inner.size]) if near else s


def _solve(
    task: Task, prices: Prices, start: Array, free: NDArray[np.intp]
) -> tuple[Array, str]:
    """Minimise log(cost) over x = log s of the free sources, by SLSQP."""
    from scipy.optimize import Bounds, minimize
    from scipy.special import logsumexp, softmax

    log_c, p = np.log(prices.c[free] / prices.each(start)[free].sum()), prices.p[free]

    def factors(x: Array) -> Array:
        s = start.copy()
        s[free] = np.exp(x)
        return s

    def cost(x: Array) -> float:
        return float(logsumexp(log_c - p * x))

    def cost_gradient(x: Array) -> Array:
        return np.asarray(-p * softmax(log_c - p * x))

    def room(x: Array) -> Array:
        used = task.utilisation(factors(x))[rows]
        return np.asarray(-np.log(np.maximum(used, SMALLEST)))

    def room_gradient(x: Array) -> Array:
        return np.asarray(-task.log_end_gradient(factors(x))[rows][:, free])

    rows = _different(task, start, alike=ALIKE)
    low = np.log(np.maximum(task.low[free], SMALLEST))
    high = np.log(task.high[free])
    inside: Any = {"type": "ineq", "fun": room, "jac": room_gradient}
    found = minimize(
        cost,
        np.clip(np.log(np.maximum(start[free], SMALLEST)), low, high),
        jac=cost_gradient,
        method="SLSQP",
        bounds=Bounds(low, high),
        constraints=inside,
        options={"ftol": 1e-15, "maxiter": ITERATIONS},
    )
    return factors(np.clip(found.x, low, high)), str(found.message)


def _different(task: Task, s: Array, *, alike: float) -> NDArray[np.intp]:
    """Return places of outputs, of those with the same conditions at s the largest.

    Within its limit, it keeps those like it within theirs.
    """
    used = np.log(np.maximum(task.utilisation(s), SMALLEST))
    rows = np.column_stack([used, task.log_end_gradient(s)])
    kept: list[int] = []
    for place in np.argsort(-used, kind="stable"):
        if not any(np.abs(rows[place] - rows[one]).max() < alike for one in kept):
            kept.append(int(place))
    return np.array(sorted(kept), dtype=np.intp)
