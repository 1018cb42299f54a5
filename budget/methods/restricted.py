"""Exact restricted likelihood of block means of noise, by a banded Cholesky factor.

Means of blocks of length D of a first-order Gauss-Markov process, sigma s and
correlation time t, x = D/t, are a first-order autoregression e^-x of variance
A = s^2 (2 sinh(x/2)/x)^2 beside white of variance g_0 - A, with
g_0 = 2 s^2 (x - 1 + e^-x)/x^2 the variance of a mean. Those of a random walk of
coefficient K are a walk of steps K^2 D beside white of -K^2 D/6, those of white noise
white, N^2/D. So with states z of all these processes

    y = X b + H z + e,  Var e = R,  z of a precision P of few bands,

and with M = P + H'H/R, of as many bands (Rue and Held 2005, 2.3.3; Patterson and
Thompson 1971 for the restricted likelihood)

    log|V| = n log R + log|M| - log|P|,  V^-1 v = v/R - H M^-1 H'v/R^2,
    l_R = -(log|V| + log|X' V^-1 X| + r' V^-1 r + (n - p) log 2 pi)/2 .

It does not depend on what X takes up: the start of a walk is its mean's.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import expm1, inf, log, pi, sinh
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array

# D/t above which its neighbours have t/2D in common at the most, and are as white: the
# variance of the autoregression, e^(D/t), would leave no digits of the whole.
LARGE = 20.0
SMALL = 1e-4  # D/t, below which a mean of a process is it, to the rounding of a double


@dataclass(frozen=True)
class BlockProcess:
    """Means of blocks of one process: an autoregression, and white beside it.

    Attributes
    ----------
    decay : float
        Correlation of neighbours; 1 of a random walk [1].
    variance : float
        Of an autoregression; of a walk that of its steps [unit squared].
    white : float
        Variance of what is white beside it, which may be negative [unit squared].
    """

    decay: float
    variance: float
    white: float

    @classmethod
    def markov(cls, sigma: float, time: float, block: float) -> BlockProcess:
        """Return a Gauss-Markov process: sigma [unit], correlation time, block [s]."""
        x = block / time
        if x > LARGE:
            return cls(
                decay=0.0, variance=0.0, white=2.0 * sigma**2 * (1.0 - 1.0 / x) / x
            )
        if x < SMALL:  # A/s^2 = 1 + x^2/12, g_0/s^2 = 1 - x/3 + x^2/12
            shared, whole = 1.0 + x * x / 12.0, 1.0 - x / 3.0 + x * x / 12.0
        else:
            shared = (2.0 * sinh(x / 2.0) / x) ** 2
            whole = 2.0 * (x + expm1(-x)) / x**2
        return cls(
            decay=float(np.exp(-x)),
            variance=sigma**2 * shared,
            white=sigma**2 * (whole - shared),
        )

    @classmethod
    def walk(cls, coefficient: float, block: float) -> BlockProcess:
        """Return a random walk: its coefficient [unit/sqrt(s)], block [s]."""
        step = coefficient**2 * block
        return cls(decay=1.0, variance=step, white=-step / 6.0)

    @property
    def innovation(self) -> float:
        """Variance of a step [unit squared]."""
        if self.decay == 1.0:
            return self.variance
        return self.variance * (1.0 - self.decay) * (1.0 + self.decay)


@dataclass(frozen=True, eq=False)
class Restricted:
    """What of a restricted likelihood is not of its scale.

    Attributes
    ----------
    log_determinant : float
        log|V| + log|X' V^-1 X|.
    squares : float
        r' V^-1 r, of the residuals from the generalised least squares fit.
    freedom : int
        n - p.
    fit : ndarray, shape (p,)
        b.
    covariance : ndarray, shape (p, p)
        (X' V^-1 X)^-1.
    """

    log_determinant: float
    squares: float
    freedom: int
    fit: Array
    covariance: Array

    @property
    def log_likelihood(self) -> float:
        """l_R."""
        whole = self.log_determinant + self.squares + self.freedom * log(2.0 * pi)
        return -0.5 * whole

    @property
    def scale(self) -> float:
        """The factor on V of the largest likelihood [1]."""
        return self.squares / self.freedom

    @property
    def profiled(self) -> float:
        """l_R with V times that factor."""
        whole = self.log_determinant + self.freedom * (
            1.0 + log(2.0 * pi) + log(self.scale)
        )
        return -0.5 * whole


def together(parts: Sequence[Restricted]) -> Restricted:
    """Return the likelihood of independent records, each with a mean of its own."""
    from scipy.linalg import block_diag

    return Restricted(
        log_determinant=sum(one.log_determinant for one in parts),
        squares=sum(one.squares for one in parts),
        freedom=sum(one.freedom for one in parts),
        fit=np.concatenate([one.fit for one in parts]),
        covariance=block_diag(*(one.covariance for one in parts)),
    )


def restricted(
    y: Array, X: Array, processes: Sequence[BlockProcess], white: float
) -> Restricted | None:
    """Return the restricted likelihood of block means.

    Parameters
    ----------
    y : ndarray, shape (n,)
        Means of blocks in their order; nan where one is missing [unit].
    X : ndarray, shape (n, p)
        What the mean is of; of the missing it does not matter.
    processes : sequence of BlockProcess
        Independent.
    white : float
        Variance of what is white, besides what is white beside them [unit squared].

    Returns
    -------
    Restricted or None
        None where these variances can be of no such means.
    """
    from scipy.linalg import cholesky_banded

    is_there = ~np.isnan(y)
    R = white + sum(one.white for one in processes)
    processes = [one for one in processes if one.decay]  # the others are white
    if R <= 0.0 or any(one.innovation <= 0.0 for one in processes):
        return None
    n, m = len(y), len(processes)
    known = np.where(is_there, y, 0.0)
    Z = np.concatenate([known[:, None], X * is_there[:, None]], axis=1)  # [y X]
    log_V = is_there.sum() * log(R)
    inner = Z.T @ Z / R
    if m:
        # Lower bands: of state j, place by place those of all processes.
        bands = np.zeros((m + 1, n, m))
        for c, one in enumerate(processes):
            q, a = one.innovation, one.decay
            bands[0, :, c] = (1.0 + a * a) / q
            bands[0, -1, c] = 1.0 / q
            bands[m, :-1, c] = -a / q
            # The first state: stationary, or of a walk what the mean takes up.
            first = one.variance if a < 1.0 else q
            bands[0, 0, c] = 1.0 / first + (a * a / q if n > 1 else 0.0)
            log_V += log(first) + (n - 1) * log(q)
        for c in range(m):
            for k in range(m - c):  # what is seen of all at once
                bands[k, is_there, c] += 1.0 / R
        flat = bands.reshape(m + 1, n * m)
        b = np.repeat(Z / R, m, axis=0)
        try:
            root = cholesky_banded(flat, lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            return None
        log_V += 2.0 * float(np.log(root[0]).sum())
        half = _forward(root, b)
        inner -= half.T @ half
    p = X.shape[1]
    information = inner[1:, 1:]
    sign, log_X = np.linalg.slogdet(information)
    if sign <= 0.0:
        return None
    fit = np.linalg.solve(information, inner[1:, 0])
    squares = float(inner[0, 0] - inner[0, 1:] @ fit)
    if not 0.0 < squares < inf:
        return None
    return Restricted(
        log_determinant=float(log_V + log_X),
        squares=squares,
        freedom=int(is_there.sum()) - p,
        fit=fit,
        covariance=np.linalg.inv(information),
    )


def _forward(root: Array, b: Array) -> Array:
    """Return L^-1 b of a lower factor by its bands, same shape."""
    from scipy.linalg.lapack import dtbtrs

    found, failed = dtbtrs(root, b, uplo="L")
    if failed:
        raise np.linalg.LinAlgError("a banded factor is singular")
    return np.asarray(found)
