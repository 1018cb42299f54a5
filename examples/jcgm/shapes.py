"""Shapes of input quantities that no device file names: JCGM 101:2008, 6.4 and 6.5.

As those of `budget.distributions` they have expectation 0 and standard uncertainty 1:
estimate and u are the Group's.
"""

from __future__ import annotations

from itertools import pairwise
from math import exp, expm1, inf, isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import MOST, NORMAL, Distribution
from budget.errors import ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from budget.arrays import Array

# Of a quantile function of the user's own: moments by Gauss-Legendre on panels that
# halve towards 0 and 1, each in PARTS parts of NODES points.
HALVINGS = 53
PARTS, NODES = 32, 16
OUTERMOST = 2.0**-40  # what lies beyond this probability on each side is the far tail
FAR_TAIL = 1e-3  # [1] most of a moment that may come from there

# Below the least a shape is a spike with a tail that no draw of doubles shows; above
# the largest it is normal to more digits than its quantile function has.
LEAST_SHAPE, LARGEST_SHAPE = 0.01, 1e8
LARGEST_LOG_SIGMA = 3.0  # beyond, the variance lies where doubles are too near to 1
NEAR_BRANCH = 1e-10  # [1] where three terms of a series have the digits of a double
FEWEST_MOMENTS = 2.0  # degrees of freedom up to which Student's t has no variance


def student_t(degrees_of_freedom: float) -> Distribution:
    """Return the shape of a mean of few readings, s/sqrt(n) being its u.

    JCGM 101:2008, 6.4.9: the density is Student's t scaled by u. Its own standard
    deviation is larger than u, sqrt(v/(v - 2)) u, and infinite up to v = 2; the law of
    propagation counts u and carries v (JCGM 100:2008, G.4), as the guide does.

    Parameters
    ----------
    degrees_of_freedom : float
        v, above 0.

    Raises
    ------
    ProblemError
        v is not above 0.
    """
    if not degrees_of_freedom > 0.0:
        raise ProblemError(
            f"{degrees_of_freedom} degrees of freedom, expected a number above 0"
        )
    v = float(degrees_of_freedom)
    return Distribution("student_t", inf, 3.0, _student_t, (v,), v)


def _student_t(p: Array, v: float) -> Array:
    from scipy.special import stdtrit

    return np.asarray(stdtrit(v, p))


def scaled_student_t(degrees_of_freedom: float) -> Distribution:
    """Return Student's t scaled so that its standard deviation is the given u.

    As NIST Technical Note 1900 states a t distribution: by mean, standard deviation
    and degrees of freedom. u is then known: the law carries no degrees of freedom.

    Parameters
    ----------
    degrees_of_freedom : float
        v, above 2; the kurtosis 3 (v - 2)/(v - 4) is infinite up to v = 4.

    Raises
    ------
    ProblemError
        There is no standard deviation to scale to.
    """
    v = float(degrees_of_freedom)
    if not v > FEWEST_MOMENTS:
        raise ProblemError(
            f"Student's t of {degrees_of_freedom:g} degrees of freedom has no finite "
            "standard deviation to scale; allowed: above 2. For a mean of few readings "
            "take student_t"
        )
    if v == inf:
        return NORMAL
    kurtosis = 3.0 * (v - 2.0) / (v - 4.0) if v > 4.0 else inf  # noqa: PLR2004
    return Distribution("scaled_student_t", inf, kurtosis, _scaled_student_t, (v,))


def _scaled_student_t(p: Array, v: float) -> Array:
    return _student_t(p, v) * sqrt(1.0 - 2.0 / v)


def trapezoidal(top: float) -> Distribution:
    """Return the shape of a sum of two uniform quantities, JCGM 101:2008, 6.4.4.

    The variance is a^2 (1 + beta^2)/6 for the half-width a: 6.4.4.4.

    Parameters
    ----------
    top : float
        beta, width of the top over that of the base: 1 is uniform, 0 triangular.

    Raises
    ------
    ProblemError
        beta is not between 0 and 1.
    """
    beta = _within("top of a trapezoid over its base", top, 0.0, 1.0)
    long, short = (1.0 + beta) / 2.0, (1.0 - beta) / 2.0  # the two uniform half-widths
    kurtosis = 3.0 - 1.2 * (long**4 + short**4) / (long**2 + short**2) ** 2
    half_width = sqrt(6.0 / (1.0 + beta**2))
    return Distribution("trapezoidal", half_width, kurtosis, _trapezoidal, (beta,))


def _trapezoidal(p: Array, beta: float) -> Array:
    tail = np.minimum(p, 1.0 - p)
    side = 1.0 - np.sqrt(2.0 * tail * (1.0 - beta**2))
    flat = (1.0 + beta) * (0.5 - tail)
    on_side = tail < (1.0 - beta) / (2.0 * (1.0 + beta))
    x = np.where(on_side, side, flat)
    return np.copysign(x, p - 0.5) * sqrt(6.0 / (1.0 + beta**2))


def curvilinear_trapezoid(inexactness: float) -> Distribution:
    """Return a uniform shape whose limits are not known exactly, JCGM 101:2008, 6.4.3.

    Limits a +- d and b +- d with a fixed middle: given its half-width w, which is
    uniform on (b - a)/2 +- d, the quantity is uniform. u^2 = (b - a)^2/12 + d^2/9.

    Parameters
    ----------
    inexactness : float
        d over the half-width (b - a)/2, above 0 and below 1.

    Raises
    ------
    ProblemError
        It is not.
    """
    r = float(inexactness)
    if not 0.0 < r < 1.0:
        raise ProblemError(
            f"inexactness of limits is {inexactness}, allowed: above 0 and below 1; "
            "limits that are known exactly are UNIFORM"
        )
    w2, w4 = 1.0 + r**2 / 3.0, 1.0 + 2.0 * r**2 + r**4 / 5.0  # E[w^2], E[w^4]
    return Distribution(
        "curvilinear_trapezoid",
        (1.0 + r) / sqrt(w2 / 3.0),
        (w4 / 5.0) / (w2 / 3.0) ** 2,
        _curvilinear_trapezoid,
        (r,),
    )


def _curvilinear_trapezoid(p: Array, r: float) -> Array:
    """Invert the tail, (1 + r)/(4 r) (1 - s + s ln s) at s = x/(1 + r) beyond 1 - r."""
    from scipy.special import lambertw

    tail = np.minimum(p, 1.0 - p)
    y = 4.0 * r / (1.0 + r) * tail
    # ln(s/e) = W_-1((y - 1)/e); next to its branch point y = 0 the first terms.
    inner = np.clip(y, NEAR_BRANCH, MOST)
    s = np.exp(1.0 + np.real(lambertw((inner - 1.0) / np.e, k=-1)))
    s = np.where(y > NEAR_BRANCH, s, 1.0 - np.sqrt(2.0 * y) + y / 3.0)
    flat = (0.5 - tail) * 4.0 * r / np.log((1.0 + r) / (1.0 - r))
    x = np.where(flat < 1.0 - r, flat, s * (1.0 + r))
    return np.copysign(x, p - 0.5) / sqrt((1.0 + r**2 / 3.0) / 3.0)


def lognormal(log_sigma: float) -> Distribution:
    """Return the shape of a quantity whose logarithm is normal.

    Its lower end is the estimate minus u/sqrt(exp(s^2) - 1): 0 for
    s = sqrt(ln(1 + (u/x)^2)) with the estimate x.

    Parameters
    ----------
    log_sigma : float
        s, standard deviation of the natural logarithm, above 0 and up to 3.

    Raises
    ------
    ProblemError
        It is not.
    """
    s = float(log_sigma)
    if not 0.0 < s <= LARGEST_LOG_SIGMA:
        raise ProblemError(
            f"standard deviation of the logarithm is {log_sigma}, allowed: above 0 and "
            f"up to {LARGEST_LOG_SIGMA:g}"
        )
    v = s**2
    return Distribution(
        "lognormal",
        inf,
        exp(4.0 * v) + 2.0 * exp(3.0 * v) + 3.0 * exp(2.0 * v) - 3.0,
        _lognormal,
        (s,),
        skewness=(exp(v) + 2.0) * sqrt(expm1(v)),
    )


def _lognormal(p: Array, s: float) -> Array:
    return np.asarray(np.expm1(s * NORMAL.quantile(p) - s**2 / 2.0) / sqrt(expm1(s**2)))


def gamma(shape: float) -> Distribution:
    """Return the gamma shape of parameter k, JCGM 101:2008, 6.4.11 (k = q + 1 counts).

    Its lower end is the estimate minus sqrt(k) u: 0 for k = (x/u)^2.

    Parameters
    ----------
    shape : float
        k, from 0.01 to 1e8.

    Raises
    ------
    ProblemError
        It is not.
    """
    k = _within("shape of a gamma distribution", shape, LEAST_SHAPE, LARGEST_SHAPE)
    return Distribution(
        "gamma", inf, 3.0 + 6.0 / k, _gamma, (k,), skewness=2.0 / sqrt(k)
    )


def _gamma(p: Array, k: float) -> Array:
    from scipy.special import gammaincinv

    return np.asarray((gammaincinv(k, p) - k) / sqrt(k))


def _exponential(p: Array) -> Array:
    """JCGM 101:2008, 6.4.10; its lower end is the estimate minus u."""
    return np.asarray(-np.log1p(-p) - 1.0)


EXPONENTIAL = Distribution("exponential", inf, 9.0, _exponential, skewness=2.0)


def beta(a: float, b: float) -> Distribution:
    """Return the beta shape, a density on an interval: t^(a - 1) (1 - t)^(b - 1).

    Parameters
    ----------
    a, b : float
        From 0.01 to 1e8: 1, 1 is uniform, 1/2, 1/2 the arcsine.

    Raises
    ------
    ProblemError
        They are not.
    """
    a, b = (
        _within(f"{name} of a beta distribution", value, LEAST_SHAPE, LARGEST_SHAPE)
        for name, value in (("a", a), ("b", b))
    )
    n = a + b
    u = sqrt(a * b / (n + 1.0)) / n
    excess = 6.0 * ((a - b) ** 2 * (n + 1.0) - a * b * (n + 2.0))
    return Distribution(
        "beta",
        0.5 / u,
        3.0 + excess / (a * b * (n + 2.0) * (n + 3.0)),
        _beta,
        (a, b),
        skewness=2.0 * (b - a) * sqrt(n + 1.0) / ((n + 2.0) * sqrt(a * b)),
    )


def _beta(p: Array, a: float, b: float) -> Array:
    from scipy.special import betaincinv

    n = a + b
    return np.asarray((betaincinv(a, b, p) - a / n) * n / sqrt(a * b / (n + 1.0)))


def samples(values: ArrayLike) -> Distribution:
    """Return the shape of a sample: each of its values is equally probable.

    For a quantity that an earlier evaluation gave as trials (JCGM 101:2008, 6.5), with
    `mean=values.mean(), u=values.std()`. It is no shape for the mean of few readings:
    that is `student_t`.

    Parameters
    ----------
    values : array_like, shape (n,)
        Two or more that differ.

    Raises
    ------
    ProblemError
        They are not one row of finite numbers that differ.
    """
    try:
        x = np.sort(np.array(values, dtype=float))
    except (TypeError, ValueError):
        x = np.empty(0)
    if x.ndim != 1 or not x.size or not np.isfinite(x).all() or x[0] == x[-1]:
        raise ProblemError(
            "a shape from samples needs one row of two or more finite numbers that "
            "are not all equal"
        )
    x = x / max(abs(x[0]), abs(x[-1]))
    x -= x.mean()
    x /= sqrt(np.mean(x**2))
    return Distribution(
        "samples",
        float(x[-1] - x[0]) / 2.0,
        float(np.mean(x**4)),
        _samples,
        (x.tobytes(),),
        skewness=float(np.mean(x**3)),
    )


def _samples(p: Array, values: bytes) -> Array:
    x = np.frombuffer(values)
    return x[np.clip(np.ceil(p * x.size).astype(np.intp) - 1, 0, x.size - 1)]


def from_quantile(
    function: Callable[[Array], Array], *, name: str = "own"
) -> Distribution:
    """Return the shape of a quantile function of one's own.

    Its mean and standard deviation are found by quadrature and taken out, so that the
    Group's estimate and u hold; third and fourth moments serve the law.

    Parameters
    ----------
    function : callable, (p) -> array
        Inverse of a distribution function: takes an array of probabilities, does not
        fall, is finite within (0, 1). To be sent to other processes it stands at the
        top of a module.
    name : str
        What the shape is called.

    Raises
    ------
    ProblemError
        It is no quantile function, or has no finite variance.
    """
    where = f"quantile function {name!r}"
    p, w = _panels()
    q = np.asarray(function(p), dtype=float)
    if q.shape != p.shape:
        raise ProblemError(
            f"{where} returned shape {q.shape} for {p.shape}; expected one value for "
            "each probability"
        )
    if not np.isfinite(q).all() or (np.diff(q) < 0.0).any():
        raise ProblemError(
            f"{where} is not finite or falls somewhere within (0, 1); expected the "
            "inverse of a distribution function"
        )
    middle = float(q[q.size // 2])
    scale = float(np.abs(q - middle).max())
    if not 0.0 < scale < inf:
        raise ProblemError(f"{where} is {middle:g} everywhere; expected one that rises")
    q = (q - middle) / scale  # moments of what is far from 1 would overflow
    mean = float(w @ q)
    far = np.minimum(p, 1.0 - p) < OUTERMOST

    def moment(power: int) -> float:
        parts = w * (q - mean) ** power
        tail = float(np.abs(parts[far]).sum())
        return float(parts.sum()) if tail <= FAR_TAIL * np.abs(parts).sum() else inf

    variance = moment(2)
    if not isfinite(variance):
        raise ProblemError(
            f"{where} has no finite variance (its far tails hold more than "
            f"{FAR_TAIL:g} of it), so that no standard uncertainty describes it; cut "
            "its tails"
        )
    u = sqrt(variance)
    return Distribution(
        name,
        float(q[-1] - q[0]) / (2.0 * u),  # as far as doubles reach
        moment(4) / u**4,
        _standardised,
        (function, middle + scale * mean, scale * u),
        skewness=moment(3) / u**3,
    )


def _standardised(
    p: Array, function: Callable[[Array], Array], mean: float, u: float
) -> Array:
    return (np.asarray(function(p), dtype=float) - mean) / u


def _panels() -> tuple[Array, Array]:
    """Return probabilities, ascending, and their weights; both ends are approached."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    ends = 0.5 ** np.arange(HALVINGS, 0, -1.0)  # up to 1/2
    edges = np.concatenate(
        [np.linspace(a, b, PARTS, endpoint=False) for a, b in pairwise(ends)] + [[0.5]]
    )
    half = np.diff(edges)[:, None] / 2.0
    p = ((edges[:-1, None] + half) + half * node).ravel()
    w = (half * weight).ravel()
    return np.concatenate([p, 1.0 - p[::-1]]), np.concatenate([w, w[::-1]])


def _within(what: str, value: float, low: float, high: float) -> float:
    """Return a parameter as a float."""
    if not low <= value <= high:
        raise ProblemError(f"{what} is {value}, allowed: {low:g} to {high:g}")
    return float(value)
