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

A length sqrt(y_1^2 + y_2^2) has V = V_1 + V_2 and no mean; its k goes with the ellipse,
whose principal variances are V/2 +- hypot(D/2, W), D = V_1 - V_2 and W the covariance
of the two, which are sums over the sources as V is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import normal_coverage_factor
from budget.errors import ProblemError
from budget.methods.gum import derivatives, higher_moments, refuse_no_number
from budget.methods.jets import Expansion
from budget.methods.radius import radius_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from budget.arrays import Array
    from budget.methods.gum import Propagation
    from budget.names import Name
    from budget.problem import Problem

# A source does not count at an output where its variance alone is below this part of
# the squared limit [1].
NEGLIGIBLE = 1e-12
ROUNDING = 1e-9  # of two laws that are one, of each standard uncertainty [1]
STEP = 1e-4  # in e = (a - b)/(a + b) of an ellipse, of a difference [1]


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
    # Of outputs that are lengths D/2 and W in the place of V, of others 0; () where
    # there is no length.
    ellipse: tuple[ScaledLaw, ...] = ()
    is_length: NDArray[np.bool_] | None = None  # shape (n_out,); None: no output is

    def in_units(self, sizes: ArrayLike) -> ScaledLaw:
        """Return it in other units of the outputs, of these sizes [SI]."""
        unit = np.asarray(sizes)[:, None]
        return replace(
            self,
            value=self.value / unit[:, 0],
            shift=self.shift / unit,
            first=self.first / unit**2,
            second=self.second / unit[:, None] ** 2,
            ellipse=tuple(one.in_units(sizes) for one in self.ellipse),
        )

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

    def roundness(self, s: Array, coverage: Array) -> Array:
        """Return k of each length over that of the normal law, shape (n_out,) [1].

        Coverages have shape (n_out,). 1 for what is no length, and for a length that
        lies along one axis.
        """
        found = np.ones(len(self.outputs))
        if self.is_length is None or not self.is_length.any():
            return found
        rows = np.flatnonzero(self.is_length)
        middle = self.variance(s)[rows] / 2.0
        half = np.hypot(*(one.variance(s)[rows] for one in self.ellipse))
        ends = np.stack([middle + half, np.maximum(middle - half, 0.0)])
        along = normal_coverage_factor(coverage[rows]) * np.sqrt(2.0 * middle)
        there = along > 0.0
        found[rows[there]] = radius_of(coverage[rows], ends)[there] / along[there]
        return found

    def log_roundness_gradient(self, s: Array, coverage: Array) -> Array:
        """Return d log(roundness) / d log(s), shape (n_out, n_src) [1].

        The roundness goes with e = hypot(D/2, W)/(V/2) alone; its slope there is a
        difference, as it has no simple form.
        """
        found = np.zeros(self.first.shape)
        if self.is_length is None or not self.is_length.any():
            return found
        rows = np.flatnonzero(self.is_length)
        V, dV = self.variance(s)[rows], self.variance_gradient(s)[rows]
        x, y = (one.variance(s)[rows] for one in self.ellipse)
        dx, dy = (one.variance_gradient(s)[rows] for one in self.ellipse)
        half = np.hypot(x, y)
        safe = np.where(half > 0.0, half, np.inf)[:, None]
        V = np.where(V > 0.0, V, np.inf)
        e = 2.0 * half / V
        de = 2.0 * (x[:, None] * dx + y[:, None] * dy) / safe - e[:, None] * dV
        ends = [np.clip(e + step, 0.0, 1.0) for step in (STEP, -STEP)]
        log_radius = [
            np.log(radius_of(coverage[rows], np.stack([1.0 + end, 1.0 - end])))
            for end in ends
        ]
        slope = (log_radius[0] - log_radius[1]) / (ends[0] - ends[1])
        found[rows] = slope[:, None] * de / V[:, None]
        return found

    def variance_gradient(self, s: Array) -> Array:
        """Return d V / d log(s), shape (n_out, n_src) [SI squared]."""
        q = s**2
        return np.asarray(2.0 * q * (self.first + 2.0 * self.second @ q))

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

    def with_source(self, name: Name, variances: Array) -> ScaledLaw:
        """Return the law with one more source, of the first order alone.

        `variances`, shape (3, n_out), are V and, of lengths, D/2 and W [SI squared].
        """

        def wider(law: ScaledLaw, first: Array) -> ScaledLaw:
            return replace(
                law,
                sources=(*law.sources, name),
                shift=np.pad(law.shift, ((0, 0), (0, 1))),
                first=np.column_stack([law.first, first]),
                second=np.pad(law.second, ((0, 0), (0, 1), (0, 1))),
            )

        bent = zip(self.ellipse, variances[1:], strict=False)  # () without a length
        return replace(
            wider(self, variances[0]), ellipse=tuple(wider(*one) for one in bent)
        )

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
            ellipse=tuple(one.select(outputs) for one in self.ellipse),
            is_length=None if self.is_length is None else self.is_length[rows],
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
            ellipse=tuple(one.select_sources(sources) for one in self.ellipse),
        )

    def over(self, sources: Sequence[Name]) -> ScaledLaw:
        """Return the law as one of more sources, of which the others do nothing."""
        columns = [sources.index(name) for name in self.sources]
        n_out, n_src = len(self.outputs), len(sources)
        shift, first = np.zeros((2, n_out, n_src))
        second = np.zeros((n_out, n_src, n_src))
        shift[:, columns], first[:, columns] = self.shift, self.first
        second[np.ix_(range(n_out), columns, columns)] = self.second
        return replace(
            self,
            sources=tuple(sources),
            shift=shift,
            first=first,
            second=second,
            ellipse=tuple(one.over(sources) for one in self.ellipse),
        )

    def beside(self, other: ScaledLaw) -> ScaledLaw:
        """Return the law of the outputs of both, with a factor on all their sources.

        A source of one alone adds nothing to the outputs of the other.
        """
        sources = tuple(dict.fromkeys((*self.sources, *other.sources)))
        both = self.over(sources), other.over(sources)
        first, second = both
        bent = tuple(one.ellipse or (_nothing(one),) * 2 for one in both)
        is_length = [
            np.zeros(len(one.outputs), bool) if one.is_length is None else one.is_length
            for one in both
        ]
        return ScaledLaw(
            sources=sources,
            outputs=(*self.outputs, *other.outputs),
            value=np.concatenate([one.value for one in both]),
            shift=np.concatenate([one.shift for one in both]),
            first=np.concatenate([one.first for one in both]),
            second=np.concatenate([one.second for one in both]),
            ellipse=tuple(a.beside(b) for a, b in zip(*bent, strict=True))
            if first.ellipse or second.ellipse
            else (),
            is_length=np.concatenate(is_length),
        )

    def resized(self, factors: Array) -> ScaledLaw:
        """Return the law whose s = 1 is at these factors, shape (n_src,)."""
        q = factors**2
        return replace(
            self,
            shift=self.shift * q,
            first=self.first * q,
            second=self.second * np.outer(q, q),
            ellipse=tuple(one.resized(factors) for one in self.ellipse),
        )

    def is_like(self, other: ScaledLaw) -> bool:
        """Whether another law of the same sources says the same, but for rounding."""
        V = self.variance(np.ones(len(self.sources)))[:, None]
        pairs = (
            (self.shift, other.shift, np.sqrt(V)),
            (self.first, other.first, V),
            (self.second, other.second, V[:, None]),
        )
        return self.sources == other.sources and all(
            bool((np.abs(one - two) <= ROUNDING * size).all())
            for one, two, size in pairs
        )

    def centred(self) -> ScaledLaw:
        """Return the law of the deviations from the mean: what is asked of u alone."""
        return replace(
            self, value=np.zeros_like(self.value), shift=np.zeros_like(self.shift)
        )


def scaled_law(problem: Problem, law: Propagation | None = None) -> ScaledLaw:
    """Build the law of a Problem as a function of the sizes of its sources.

    Its present sizes are s = 1, where it is `propagate(problem)`: the given law, if it
    is there already; else the derivatives are taken, and no more of it.

    Raises
    ------
    ProblemError
        A shape is skewed, which adds a term in q^(3/2), or has no finite kurtosis; or
        as for any law.
    """
    skew, excess = higher_moments(problem)
    if skew.any() or not np.isfinite(excess).all():
        raise ProblemError(
            "the law as a function of the sizes of its sources is for symmetric shapes "
            "of finite kurtosis; take other shapes, or propagate every size by itself"
        )
    taylor = _derivatives(problem) if law is None else law
    n_out, n_src = len(problem.outputs), len(problem.groups)
    a, b = problem.legs
    lengths = slice(n_out - a.size, None)
    shift = np.zeros((n_out, n_src))
    first = np.zeros((n_out, n_src))
    second = np.zeros((n_out, n_src, n_src))
    between = np.zeros((n_out, n_src)), np.zeros((n_out, n_src, n_src))
    HU = np.concatenate(
        [
            np.zeros((n_out, problem.n_inputs, 0)),  # there may be no source at all
            *(
                taylor.H[:, :, rows] @ group.covariance
                for rows, group in zip(problem.slices, problem.groups, strict=True)
            ),
        ],
        axis=2,
    )
    pair = 0.5 * HU * HU.transpose(0, 2, 1)
    mixed = 0.5 * HU[a] * HU[b].transpose(0, 2, 1)
    for g, (rows, group) in enumerate(zip(problem.slices, problem.groups, strict=True)):
        C = taylor.C[:, rows]
        curvature = np.einsum("kii->ki", taylor.H[:, rows, rows])
        first[:, g] = np.einsum("ki,ij,kj->k", C, group.covariance, C)
        shift[:, g] = 0.5 * np.einsum("kii->k", HU[:, rows, rows])
        between[0][lengths, g] = np.einsum("ki,ij,kj->k", C[a], group.covariance, C[b])
        for h, others in enumerate(problem.slices):
            second[:, g, h] = pair[:, rows, others].sum(axis=(1, 2))
            between[1][lengths, g, h] = mixed[:, rows, others].sum(axis=(1, 2))
        second[:, g, g] += curvature**2 @ excess[rows]
        between[1][lengths, g, g] += (curvature[a] * curvature[b]) @ excess[rows]
    first[lengths], second[lengths] = first[a] + first[b], second[a] + second[b]
    refuse_no_number(problem, "variance", first, second)
    found = ScaledLaw(
        sources=tuple(group.name for group in problem.groups),
        outputs=tuple(output.name for output in problem.outputs),
        value=taylor.value,
        shift=shift,
        first=first,
        second=second,
    )
    if not a.size:
        return found
    half = np.zeros_like(first), np.zeros_like(second)
    for array, of in zip(half, (first, second), strict=True):
        array[lengths] = (of[a] - of[b]) / 2.0
    return replace(
        found,
        is_length=np.arange(n_out) >= n_out - a.size,
        ellipse=tuple(
            replace(
                found, value=0.0 * taylor.value, shift=0.0 * shift, first=x, second=y
            )
            for x, y in (half, between)
        ),
    )


def _derivatives(problem: Problem) -> Expansion:
    """Return value and derivatives of all outputs, with 0 for lengths."""
    found, lengths = derivatives(problem), problem.legs.shape[1]
    if not lengths:
        return found
    value, C, H = (
        np.concatenate([array, np.zeros((lengths, *array.shape[1:]))])
        for array in (found.value, found.C, found.H)
    )
    return Expansion(value=value, C=C, H=H)


def _nothing(law: ScaledLaw) -> ScaledLaw:
    """Return the law of outputs that are 0."""
    return replace(
        law,
        value=np.zeros_like(law.value),
        shift=np.zeros_like(law.shift),
        first=np.zeros_like(law.first),
        second=np.zeros_like(law.second),
        ellipse=(),
        is_length=None,
    )
