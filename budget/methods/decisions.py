"""Decision rules for conformity: acceptance intervals, global risks, JCGM 106:2012.

A quantity conforms where it lies in the tolerance interval T; an item is accepted where
its measured value lies in the acceptance interval A. The global risks are those of a
rule before anything is measured: with the density g of the quantity over all items and
the density h of measured values of a quantity eta,

    R_C = integral outside T of g(eta) P(measured value in A | eta) ,   consumer's ,
    R_P = integral within  T of g(eta) P(measured value not in A | eta) , producer's ,

JCGM 106:2012, 9.5.2: both are probabilities of all items, of those accepted or not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import LEAST, MOST, NORMAL
from budget.errors import CallError

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.distributions import Distribution

Limits = tuple[float, float]

# Quadrature over probabilities of the prior: even panels, panels that halve towards
# both ends, and some around every acceptance limit, where measured values decide.
EVEN_PANELS, HALVINGS, NODES = 1024, 54, 8
AROUND_LIMIT = np.linspace(-9.0, 9.0, 37)  # [standard uncertainties of measurement]


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
    low, high = interval(tolerance, "tolerance")
    if not isfinite(guard_band) or not low + guard_band < high - guard_band:
        raise CallError(
            f"a guard band of {guard_band:g} within {low:g} to {high:g} leaves nothing "
            "to accept; take a smaller one, or measure with less uncertainty"
        )
    return low + guard_band, high - guard_band


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
    t, a = interval(tolerance, "tolerance"), interval(acceptance, "acceptance")
    check_positive(u, "u")
    check_positive(u_measurement, "u_measurement")
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


def interval(limits: Limits, name: str) -> Limits:
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


def check_positive(u: float, name: str) -> None:
    """Refuse what is no standard uncertainty."""
    if not 0.0 < u < inf:
        raise CallError(f"{name} is {u!r}, allowed: above 0")
