"""Exact restricted likelihood of block means of noise, by a banded Cholesky factor.

The mean of a block of length D of a first-order Gauss-Markov process, sigma s and
correlation time t, x = D/t, is tanh(x/2)/x times the sum of the process at both ends,
and what these leave: independent from block to block, as the process is Markov. So is
that of a random walk of coefficient K, half their sum and a variance of K^2 D/12; that
of white noise is white, N^2/D. Many processes that make up flicker stand by their means
instead, autoregressions e^-x of variance A = s^2 (2 sinh(x/2)/x)^2 beside white of
g - A, g = 2 s^2 (x - 1 + e^-x)/x^2: of fewer bands, if their white is not negative in
all. So with states z of all these processes

    y = X b + H z + e,  Var e = R,  z of a precision P of few bands,

and with M = P + H'H/R, of as many bands (Rue and Held 2005, 2.3.3; Patterson and
Thompson 1971 for the restricted likelihood)

    log|V| = n log R + log|M| - log|P|,  V^-1 v = v/R - H M^-1 H'v/R^2,
    l_R = -(log|V| + log|X' V^-1 X| + r' V^-1 r + (n - p) log 2 pi)/2 .

It does not depend on what X takes up: the start of a walk is its mean's.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, expm1, inf, log, pi, sinh, tanh
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array

# D/t, below which a mean of a process is it, to the rounding of a double; and below
# which what its ends leave of it is by its series.
SMALL, SHORT = 1e-4, 1e-3


@dataclass(frozen=True)
class BlockProcess:
    """Means of blocks of one process: of an autoregression, and white beside it.

    A mean is `ends` times the sum of the process at both ends of its block and what
    these leave, which is independent from block to block; or, without `ends`, an
    autoregression of block to block, and white that may be of negative variance: of
    fewer bands, where other white noise is larger.

    Attributes
    ----------
    decay : float
        Correlation of neighbours; 1 of a random walk [1].
    variance : float
        Of an autoregression; of a walk that of its steps [unit squared].
    white : float
        Variance of what is white beside it [unit squared].
    ends : float
        Part of each end in a mean; 0 of an autoregression of means [1].
    """

    decay: float
    variance: float
    white: float
    ends: float = 0.0

    @classmethod
    def markov(cls, sigma: float, time: float, block: float) -> BlockProcess:
        """Return a Gauss-Markov process by its ends: sigma [unit], times [s].

        With x = D/t a mean is tanh(x/2)/x times their sum and what is left, of variance
        s^2 (g - 2 (tanh(x/2)/x)^2 (1 + e^-x)), g = 2 (x - 1 + e^-x)/x^2.
        """
        x = block / time
        if x < SHORT:
            ends, left = 0.5 - x * x / 24.0, x / 6.0 * (1.0 - x * x / 10.0)
        else:
            ends = tanh(x / 2.0) / x
            left = 2.0 * (1.0 + expm1(-x) / x) / x - 2.0 * ends**2 * (1.0 + exp(-x))
        return cls(decay=exp(-x), variance=sigma**2, white=sigma**2 * left, ends=ends)

    @classmethod
    def walk(cls, coefficient: float, block: float) -> BlockProcess:
        """Return a random walk by its ends: coefficient [unit/sqrt(s)], block [s]."""
        step = coefficient**2 * block
        return cls(decay=1.0, variance=step, white=step / 12.0, ends=0.5)

    @classmethod
    def of_means(cls, sigma: float, time: float, block: float) -> BlockProcess:
        """Return a Gauss-Markov process that is no faster than a block, by its means.

        A/s^2 = (2 sinh(x/2)/x)^2 of the autoregression, and white g - A.
        """
        x = block / time
        if x < SMALL:  # A/s^2 = 1 + x^2/12, g/s^2 = 1 - x/3 + x^2/12
            shared, whole = 1.0 + x * x / 12.0, 1.0 - x / 3.0 + x * x / 12.0
        else:
            shared = (2.0 * sinh(x / 2.0) / x) ** 2
            whole = 2.0 * (x + expm1(-x)) / x**2
        return cls(
            decay=exp(-x),
            variance=sigma**2 * shared,
            white=sigma**2 * (whole - shared),
        )

    @classmethod
    def walk_of_means(cls, coefficient: float, block: float) -> BlockProcess:
        """Return a random walk by its means."""
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
        What the mean is of, 1 in its first column; of the missing it does not matter.
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
    if R <= 0.0 or any(one.innovation <= 0.0 for one in processes):
        return None
    # Off their mean, which the first column of X takes up: squares of 1 g beside noise
    # of 1 ug would leave no digits of it.
    level = float(y[is_there].mean()) if is_there.any() else 0.0
    known = np.where(is_there, y - level, 0.0)
    Z = np.concatenate([known[:, None], X * is_there[:, None]], axis=1)  # [y X]
    log_V = is_there.sum() * log(R)
    inner = Z.T @ Z / R
    if processes:
        bands, b, log_P = _information(processes, Z, is_there, R)
        try:
            root = cholesky_banded(bands, lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            return None
        log_V += 2.0 * float(np.log(root[0]).sum()) - log_P
        half = _forward(root, b)
        inner -= half.T @ half
    p = X.shape[1]
    information = inner[1:, 1:]
    sign, log_X = np.linalg.slogdet(information)
    if sign <= 0.0:
        return None
    fit = np.linalg.solve(information, inner[1:, 0])
    squares = float(inner[0, 0] - inner[0, 1:] @ fit)
    fit[0] += level
    if not 0.0 < squares < inf:
        return None
    return Restricted(
        log_determinant=float(log_V + log_X),
        squares=squares,
        freedom=int(is_there.sum()) - p,
        fit=fit,
        covariance=np.linalg.inv(information),
    )


def _information(
    processes: Sequence[BlockProcess], Z: Array, is_there: NDArray[np.bool_], R: float
) -> tuple[Array, Array, float]:
    """Return M, H' Z/R and log|P| of the states of all processes, place by place.

    M by its lower bands, (w, states). A block sees the states of its ends or, of means,
    those of its place.
    """
    m = len(processes)
    has_ends = any(one.ends for one in processes)
    sees = np.array([one.ends if has_ends else 1.0 for one in processes])
    n = len(Z) + has_ends
    bands = np.zeros((2 * m if has_ends else m + 1, n, m))
    log_P = 0.0
    for c, one in enumerate(processes):
        q, a = one.innovation, one.decay
        bands[0, :, c] = (1.0 + a * a) / q
        bands[0, -1, c] = 1.0 / q
        bands[m, :-1, c] = -a / q
        # The first state: stationary, or of a walk what the mean takes up.
        first = one.variance if a < 1.0 else q
        bands[0, 0, c] = 1.0 / first + (a * a / q if n > 1 else 0.0)
        log_P -= log(first) + (n - 1) * log(q)
    b = np.zeros((n, m, Z.shape[1]))
    seen = is_there / R
    seen_Z = sees[:, None] * Z[:, None] / R
    for place in (slice(0, len(Z)), slice(1, None))[: 1 + has_ends]:
        b[place] += seen_Z
        for c in range(m):
            for k in range(m - c):  # what is seen of all at once
                bands[k, place, c] += sees[c] * sees[c + k] * seen
    for c in range(m if has_ends else 0):
        for k in range(m):  # and of one end beside the other
            bands[m + k - c, : len(Z), c] += sees[c] * sees[k] * seen
    return bands.reshape(-1, n * m), b.reshape(n * m, -1), log_P


def _forward(root: Array, b: Array) -> Array:
    """Return L^-1 b of a lower factor by its bands, same shape."""
    from scipy.linalg.lapack import dtbtrs

    found, failed = dtbtrs(root, b, uplo="L")
    if failed:
        raise np.linalg.LinAlgError("a banded factor is singular")
    return np.asarray(found)
