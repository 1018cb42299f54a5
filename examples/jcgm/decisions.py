"""Decisions on single items, and guard bands that keep a risk: JCGM 106:2012.

What a rule does to all items, before anything is measured, are the global risks of
`budget.global_risks`. The specific risk is that of one decision whose measured value is
known; a guard band is found that keeps the one or the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, isnan
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.errors import CallError
from budget.methods.decisions import check_positive, global_risks, interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.distributions import Distribution
    from budget.methods.decisions import Limits

BISECTIONS = 80
WIDEST = 1e6  # [u] of a guard band that is looked for


@dataclass(frozen=True, kw_only=True)
class Decision:
    """A decision on one item, and the risk that it is wrong.

    Attributes
    ----------
    is_accepted : bool
    conformance_probability : float
        Of the item, by what the measurement says of it [1].
    """

    is_accepted: bool
    conformance_probability: float

    @property
    def risk(self) -> float:
        """Specific risk: the consumer's of an accepted item, else the producer's."""
        p = self.conformance_probability
        return 1.0 - p if self.is_accepted else p


def conformance_probability(
    y: float, u: float, tolerance: Limits, *, distribution: Distribution = NORMAL
) -> float:
    """Return the probability that a quantity lies within its tolerance.

    JCGM 106:2012, clause 7; for a normal distribution
    Phi((T_U - y)/u) - Phi((T_L - y)/u).

    Parameters
    ----------
    y, u : float
        Estimate and standard uncertainty of the quantity, after the measurement.
    tolerance : tuple of float
        T_L and T_U; -inf or inf where there is no limit.
    distribution : Distribution
        Shape of the quantity.

    Raises
    ------
    CallError
        u is not above 0, or the tolerance is no interval.
    """
    low, high = interval(tolerance, "tolerance")
    check_positive(u, "u")
    inside = np.diff(distribution.probability([(low - y) / u, (high - y) / u]))
    return float(inside[0])


def decide(
    y: float,
    u: float,
    *,
    tolerance: Limits,
    acceptance: Limits,
    distribution: Distribution = NORMAL,
) -> Decision:
    """Accept or reject one item by its measured value: JCGM 106:2012, 9.3.

    Parameters
    ----------
    y, u : float
        Measured value and its standard uncertainty.
    tolerance, acceptance : tuple of float
        T_L and T_U, A_L and A_U; both ends belong to them.
    distribution : Distribution
        Shape of what the measurement says of the quantity.

    Returns
    -------
    Decision

    Raises
    ------
    CallError
        u is not above 0, or an interval is none.
    """
    low, high = interval(acceptance, "acceptance")
    return Decision(
        is_accepted=low <= y <= high,
        conformance_probability=conformance_probability(
            y, u, tolerance, distribution=distribution
        ),
    )


def specific_guard_band(
    u: float, tolerance: Limits, risk: float, *, distribution: Distribution = NORMAL
) -> float:
    """Return the least guard band that keeps the specific consumer's risk.

    At both acceptance limits the probability of conformity is 1 - risk at least. With
    one limit and a normal distribution it is u times the quantile of 1 - risk. For a
    producer's risk q of what is rejected take risk = 1 - q: w is then below 0.

    Parameters
    ----------
    u : float
        Standard uncertainty of the quantity, after the measurement.
    tolerance : tuple of float
        T_L and T_U; -inf or inf where there is no limit.
    risk : float
        Above 0 and below 1.
    distribution : Distribution
        Shape of the quantity, of one top.

    Raises
    ------
    CallError
        No guard band keeps the risk at both limits, or an argument means nothing.
    """
    low, high = interval(tolerance, "tolerance")
    check_positive(u, "u")
    _probability(risk)
    # Each limit by itself, then both together.
    ends = distribution.quantile(np.array([1.0 - risk, risk]))
    least = u * max(
        float(ends[0]) if isfinite(high) else -inf,
        -float(ends[1]) if isfinite(low) else -inf,
    )
    half = (high - low) / 2.0
    if half == inf:
        return least

    def worst(w: float) -> float:
        return min(
            conformance_probability(y, u, tolerance, distribution=distribution)
            for y in (low + w, high - w)
        )

    if least >= half or worst(half) < 1.0 - risk:
        raise CallError(
            f"with u = {u:g} no guard band keeps a risk of {risk:g} at both limits of "
            f"{low:g} to {high:g}: in the middle of them it is {1.0 - worst(half):.4g}"
            ". Measure with less uncertainty, or allow more risk"
        )
    return _rising(lambda w: worst(w) - (1.0 - risk), least, half)


def global_guard_band(
    tolerance: Limits,
    risk: float,
    *,
    mean: float,
    u: float,
    u_measurement: float,
    distribution: Distribution = NORMAL,
    measurement: Distribution = NORMAL,
) -> float:
    """Return the guard band at which the global consumer's risk is the given one.

    The least w whose rule `acceptance_interval(tolerance, w)` accepts no more than
    that part of all items wrongly (JCGM 106:2012, 9.5); below 0 where that much risk
    is left even if more than the tolerance is accepted.

    Parameters
    ----------
    tolerance : tuple of float
        T_L and T_U; -inf or inf where there is no limit.
    risk : float
        R_C, above 0 and below the part of all items that does not conform.
    mean, u, u_measurement, distribution, measurement
        As of `global_risks`.

    Raises
    ------
    CallError
        All items may be accepted at that risk, or an argument means nothing.
    """
    low, high = interval(tolerance, "tolerance")
    _probability(risk)

    def left(w: float) -> float:
        return (
            risk
            - global_risks(
                tolerance,
                (low + w, high - w),
                mean=mean,
                u=u,
                u_measurement=u_measurement,
                distribution=distribution,
                measurement=measurement,
            ).consumer
        )

    everything = global_risks(
        tolerance,
        (-inf, inf),
        mean=mean,
        u=u,
        u_measurement=u_measurement,
        distribution=distribution,
        measurement=measurement,
    )
    if everything.consumer <= risk:
        raise CallError(
            f"of all items {everything.consumer:.4g} do not conform: a risk of "
            f"{risk:g} is kept without a measurement. Ask for less risk"
        )
    step = u + u_measurement
    narrow = (high - low) / 2.0
    wide = -step
    while left(wide) > 0.0 and wide > -WIDEST * step:
        wide *= 2.0
    if narrow == inf:
        narrow = step
        while left(narrow) < 0.0 and narrow < WIDEST * step:
            narrow *= 2.0
    else:
        # At half the tolerance nothing is accepted, and there is no risk.
        narrow = np.nextafter(narrow, -inf)
        narrow -= 1e-12 * abs(narrow)
    return _rising(left, wide, narrow)


def _rising(excess: Callable[[float], float], low: float, high: float) -> float:
    """Return the least place at which a rising function is not below 0."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if excess(middle) < 0.0:
            low = middle
        else:
            high = middle
    return high


def _probability(risk: float) -> None:
    if isnan(risk) or not 0.0 < risk < 1.0:
        raise CallError(f"risk is {risk!r}, allowed: above 0 and below 1")
