"""Decision rules for conformity: guard bands, specific and global risks, JCGM 106:2012.

A quantity conforms where it lies in the tolerance interval T; an item is accepted where
its measured value lies in the acceptance interval A. The specific risk is that of one
decision whose measured value is known, the global risks are those of a rule before
anything is measured: with the density g of the quantity over all items and the density
h of measured values of a quantity eta,

    R_C = integral outside T of g(eta) P(measured value in A | eta) ,   consumer's ,
    R_P = integral within  T of g(eta) P(measured value not in A | eta) , producer's ,

JCGM 106:2012, 9.5.2: both are probabilities of all items, of those accepted or not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, isnan
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import LEAST, MOST, NORMAL
from budget.errors import CallError

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array
    from budget.distributions import Distribution

Limits = tuple[float, float]

# Quadrature over probabilities of the prior: even panels, panels that halve towards
# both ends, and some around every acceptance limit, where measured values decide.
EVEN_PANELS, HALVINGS, NODES = 1024, 54, 8
AROUND_LIMIT = np.linspace(-9.0, 9.0, 37)  # [standard uncertainties of measurement]
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


@dataclass(frozen=True, kw_only=True)
class GlobalRisks:
    """What a rule does to all items.

    Attributes
    ----------
    consumer : float
        R_C: part of all items that is accepted and does not conform [1].
    producer : float
        R_P: part of all items that is rejected and conforms [1].
    conforming : float
        Part of all items that conforms [1].
    accepted : float
        Part of all items that is accepted [1].
    """

    consumer: float
    producer: float
    conforming: float
    accepted: float


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
    low, high = _limits(tolerance, "tolerance")
    _positive(u, "u")
    inside = np.diff(distribution.probability([(low - y) / u, (high - y) / u]))
    return float(inside[0])


def acceptance_interval(tolerance: Limits, guard_band: float) -> Limits:
    """Return [T_L + w, T_U - w]: JCGM 106:2012, 8.3.

    Parameters
    ----------
    tolerance : tuple of float
        T_L and T_U.
    guard_band : float
        w: above 0 guards acceptance (8.3.2; often U = 2 u), below 0 rejection (8.3.3),
        0 is simple acceptance (8.2).

    Raises
    ------
    CallError
        Nothing would be accepted.
    """
    low, high = _limits(tolerance, "tolerance")
    if not isfinite(guard_band) or not low + guard_band < high - guard_band:
        raise CallError(
            f"a guard band of {guard_band:g} within {low:g} to {high:g} leaves nothing "
            "to accept; take a smaller one, or measure with less uncertainty"
        )
    return low + guard_band, high - guard_band


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
    low, high = _limits(acceptance, "acceptance")
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
    low, high = _limits(tolerance, "tolerance")
    _positive(u, "u")
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


def global_risks(
    tolerance: Limits,
    acceptance: Limits,
    *,
    mean: float,
    u: float,
    u_measurement: float,
    distribution: Distribution = NORMAL,
    measurement: Distribution = NORMAL,
) -> GlobalRisks:
    """Return consumer's and producer's risk of a rule: JCGM 106:2012, 9.5.2.

    By quadrature over the prior distribution: to 1e-10 for smooth shapes, to 1e-4 for
    a prior of samples.

    Parameters
    ----------
    tolerance, acceptance : tuple of float
        T_L and T_U, A_L and A_U; -inf or inf where there is no limit.
    mean, u : float
        Of the quantity over all items (the prior).
    u_measurement : float
        Standard uncertainty of the measurement, u_m.
    distribution, measurement : Distribution
        Shapes of the quantity over all items, and of the error of measurement.

    Returns
    -------
    GlobalRisks

    Raises
    ------
    CallError
        An uncertainty is not above 0, or an interval is none.
    """
    t, a = _limits(tolerance, "tolerance"), _limits(acceptance, "acceptance")
    _positive(u, "u")
    _positive(u_measurement, "u_measurement")
    limits = np.array([x for x in a if isfinite(x)])
    near = (limits[:, None] + AROUND_LIMIT * u_measurement).ravel()
    inner = distribution.probability((near - mean) / u)
    p_low, p_high = distribution.probability((np.array(t) - mean) / u)
    eta, weight, p = _nodes(np.concatenate([inner, [p_low, p_high]]), distribution)
    eta = mean + u * eta
    accepted = measurement.probability((a[1] - eta) / u_measurement)
    accepted -= measurement.probability((a[0] - eta) / u_measurement)
    conforms = (p > p_low) & (p < p_high)
    return GlobalRisks(
        consumer=float(weight @ np.where(conforms, 0.0, accepted)),
        producer=float(weight @ np.where(conforms, 1.0 - accepted, 0.0)),
        conforming=float(p_high - p_low),
        accepted=float(weight @ accepted),
    )


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
    low, high = _limits(tolerance, "tolerance")
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


def _nodes(inner: Array, distribution: Distribution) -> tuple[Array, Array, Array]:
    """Return quantiles, weights and probabilities of a quadrature over a shape."""
    tails = 0.5 ** np.arange(2.0, HALVINGS)
    edges = np.concatenate(
        [np.linspace(0.0, 1.0, EVEN_PANELS + 1), tails, 1.0 - tails, inner]
    )
    edges = np.unique(edges)
    node, weight = np.polynomial.legendre.leggauss(NODES)
    half = np.diff(edges)[:, None] / 2.0
    p = np.clip(edges[:-1, None] + half + half * node, LEAST, MOST).ravel()
    return distribution.quantile(p), (half * weight).ravel(), p


def _limits(limits: Limits, name: str) -> Limits:
    """Return the ends of an interval as floats."""
    try:
        low, high = (float(end) for end in limits)
    except (TypeError, ValueError):
        low = high = inf
    if not low < high:
        raise CallError(
            f"{name} is {limits!r}; expected a lower and a larger upper limit, -inf "
            "or inf where there is none"
        )
    return low, high


def _positive(u: float, name: str) -> None:
    if not 0.0 < u < inf:
        raise CallError(f"{name} is {u!r}, allowed: above 0")


def _probability(risk: float) -> None:
    if isnan(risk) or not 0.0 < risk < 1.0:
        raise CallError(f"risk is {risk!r}, allowed: above 0 and below 1")
