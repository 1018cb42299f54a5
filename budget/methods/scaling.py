"""The law of propagation as a function of the sizes of the sources.

Let every standard uncertainty of source g be s_g times its present one, so that its
covariance is q_g U_g with q_g = s_g^2. The law of budget.methods.gum then reads, for
one output,

    V(s) = sum_g a_g q_g + sum_gh P_gh q_g q_h ,    m(s) = m_0 + sum_g d_g q_g ,

    a_g  = C U_g C^T ,
    P_gh = 1/2 sum over i in g, j in h of (H U)_ij (H U)_ji + [g = h] excess ,
    d_g  = 1/2 tr(H U_g) ,

so one expansion of the model gives the law of every allocation. All a and P are
non-negative: log V is convex in log s, and so is the end |m| + k sqrt(V) of a coverage
interval wherever the shifts of the mean that count have one sign.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import ProblemError
from budget.methods.gum import higher_moments, propagate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.methods.gum import Propagation
    from budget.names import Name
    from budget.problem import Problem

# A source does not count at an output where its variance alone is below this part of
# the squared limit [1].
NEGLIGIBLE = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False)
class ScaledLaw:
    """Mean and variance of every output for any factors s on the sources."""

    # Names, in the order of the arrays.
    sources: tuple[Name, ...]
    outputs: tuple[Name, ...]
    value: Array  # m_0, the outputs at the best estimates, shape (n_out,) [SI]
    # d, what each source at its present size adds to the mean, shape (n_out, n_src)
    # [SI].
    shift: Array
    first: Array  # a, variance to first order, shape (n_out, n_src) [SI squared]
    # P, symmetric; variance to second order, shape (n_out, n_src, n_src) [SI squared].
    second: Array

    def mean(self, s: Array) -> Array:
        """Return m(s), shape (n_out,), for factors s, shape (n_src,)."""
        return np.asarray(self.value + self.shift @ s**2)

    def variance(self, s: Array) -> Array:
        """Return V(s), shape (n_out,)."""
        q = s**2
        return np.asarray((self.first + self.second @ q) @ q)

    def variance_alone(self, s: Array) -> Array:
        """Return the variance from each source alone, shape (n_out, n_src)."""
        q = s**2
        return np.asarray(self.first * q + np.einsum("kgg->kg", self.second) * q**2)

    def end(self, s: Array, k: Array) -> Array:
        """Return the largest absolute end |m| + k u of each interval, shape (n_out,).

        k, shape (n_out,), are the coverage factors [1].
        """
        return np.abs(self.mean(s)) + k * np.sqrt(self.variance(s))

    def log_end_gradient(self, s: Array, k: Array) -> Array:
        """Return d log(end) / d log(s), shape (n_out, n_src) [1].

        It is 0 for an output whose end is 0.
        """
        q = s**2
        mean, u = self.mean(s), np.sqrt(self.variance(s))
        spread = np.where(u > 0.0, u, np.inf)[:, None]
        end = np.abs(mean) + k * u
        d_mean = 2.0 * self.shift * q
        d_u = q * (self.first + 2.0 * self.second @ q) / spread
        safe = np.where(end > 0.0, end, np.inf)[:, None]
        return np.asarray((np.sign(mean)[:, None] * d_mean + k[:, None] * d_u) / safe)

    def select(self, outputs: Sequence[Name]) -> ScaledLaw:
        """Return the law of some outputs, in the order of their names."""
        rows = [self.outputs.index(name) for name in outputs]
        return replace(
            self,
            outputs=tuple(outputs),
            value=self.value[rows],
            shift=self.shift[rows],
            first=self.first[rows],
            second=self.second[rows],
        )

    def select_sources(self, sources: Sequence[Name]) -> ScaledLaw:
        """Return the law of some sources in the order of names; the others are 0."""
        columns = [self.sources.index(name) for name in sources]
        return replace(
            self,
            sources=tuple(sources),
            shift=self.shift[:, columns],
            first=self.first[:, columns],
            second=self.second[:, columns][:, :, columns],
        )

    def resized(self, factors: Array) -> ScaledLaw:
        """Return the law whose s = 1 is at these factors, shape (n_src,)."""
        q = factors**2
        return replace(
            self,
            shift=self.shift * q,
            first=self.first * q,
            second=self.second * np.outer(q, q),
        )

    def centred(self) -> ScaledLaw:
        """Return the law of the deviations from the mean: what is asked of u alone."""
        return replace(
            self, value=np.zeros_like(self.value), shift=np.zeros_like(self.shift)
        )


def scaled_law(problem: Problem, law: Propagation | None = None) -> ScaledLaw:
    """Build the law of a Problem as a function of the sizes of its sources.

    Its present sizes are s = 1, where it is `propagate(problem)`: the given law, if it
    is there already.

    Raises
    ------
    ProblemError
        A shape is skewed, which adds a term in q^(3/2), or has no finite kurtosis.
    """
    skew, excess = higher_moments(problem)
    if skew.any() or not np.isfinite(excess).all():
        raise ProblemError(
            "the law as a function of the sizes of its sources is for symmetric shapes "
            "of finite kurtosis; take other shapes, or propagate every size by itself"
        )
    law = propagate(problem) if law is None else law
    n_out, n_src = len(problem.outputs), len(problem.groups)
    shift = np.zeros((n_out, n_src))
    first = np.zeros((n_out, n_src))
    second = np.zeros((n_out, n_src, n_src))
    HU = np.concatenate(
        [
            np.zeros((n_out, problem.n_inputs, 0)),  # there may be no source at all
            *(
                law.H[:, :, rows] @ group.covariance
                for rows, group in zip(problem.slices, problem.groups, strict=True)
            ),
        ],
        axis=2,
    )
    pair = 0.5 * HU * HU.transpose(0, 2, 1)
    for g, (rows, group) in enumerate(zip(problem.slices, problem.groups, strict=True)):
        C = law.C[:, rows]
        curvature = np.einsum("kii->ki", law.H[:, rows, rows])
        first[:, g] = np.einsum("ki,ij,kj->k", C, group.covariance, C)
        shift[:, g] = 0.5 * np.einsum("kii->k", HU[:, rows, rows])
        for h, others in enumerate(problem.slices):
            second[:, g, h] = pair[:, rows, others].sum(axis=(1, 2))
        second[:, g, g] += curvature**2 @ excess[rows]
    return ScaledLaw(
        sources=tuple(group.name for group in problem.groups),
        outputs=tuple(output.name for output in problem.outputs),
        value=law.value,
        shift=shift,
        first=first,
        second=second,
    )
