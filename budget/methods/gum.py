"""The law of propagation of uncertainty, second-order terms always carried.

With c the sensitivities, H the second derivatives, U_x the input covariance:

    E[y] - y(x)  = 1/2 tr(H U_x)
    cov(y_k, y_l) = c_k^T U_x c_l + 1/2 tr(H_k U_x H_l U_x) + quartic term ,

JCGM 100:2008, eq. (13) and the note to 5.1.2, for normal inputs. An input of another
shape adds skewness/2 (c_ki H_lii + c_li H_kii) u_i^3 and
(kurtosis - 3)/4 H_kii H_lii u_i^4; a group whose inputs are correlated counts as
jointly normal in the terms of second order, whatever its shapes. The third derivatives
of that note are left out. For a calibration they are of no weight: its outputs are
products of two sources over (1 + e), and e is far below 1. For a model that bends more
(x1 x2^2, the sine of a wide angle) they are not, and validation says so.

A length has no tangent at 0, where its components lie at the best estimates. Its
variance is the sum of theirs, source by source, and its interval the circle of that
coverage (budget.methods.radius), to either side.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from statistics import NormalDist
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from budget.distributions import COVERAGES, is_coverage
from budget.errors import CallError, ProblemError
from budget.methods.jets import Expansion, expand
from budget.methods.radius import circles, plane_variances, probability_within

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    import pandas as pd
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.distributions import Distribution
    from budget.names import Name
    from budget.problem import Function, Output, Problem


ROUNDING = 1e-9  # [1], relative, of effective degrees of freedom
AT_ONCE = 32  # Problems of one structure in one computation


@dataclass(frozen=True, kw_only=True, eq=False)
class Propagation:
    """What the law says of every output, and what each source adds.

    Attributes
    ----------
    value : ndarray, shape (n_out,)
        Outputs at the best estimates.
    mean : ndarray, shape (n_out,)
        The same with the second-order mean.
    covariance : ndarray, shape (n_out, n_out)
        First and second order.
    first_order : ndarray, shape (n_out, n_out)
        First order alone, C U_x C^T.
    source_variance : ndarray, shape (n_groups, n_out)
        Variance from each source alone, its own second order included.
    source_first_order : ndarray, shape (n_groups, n_out)
        The part of it that is of first order; summed, the diagonal of `first_order`.
    interaction_variance : ndarray, shape (n_out,)
        Variance from products of two sources; with the rows above it adds up to the
        diagonal of `covariance`.
    degrees_of_freedom : ndarray, shape (n_out,)
        Effective ones, JCGM 100:2008, eq. (G.2b); infinite where all inputs' are.
    C : ndarray, shape (n_out, n_in)
        Sensitivities.
    H : ndarray, shape (n_out, n_in, n_in)
        Second derivatives.
    outputs : tuple of Output
        What the rows are of.
    sources : tuple of Name
        The groups, in the order of `source_variance`.
    legs : ndarray, shape (2, n_lengths)
        Rows of the components of the last outputs, which are lengths. Of these C holds
        the root sum of squares of their sensitivities, H nothing, and no covariance
        with other outputs is known.
    """

    value: Array
    mean: Array
    covariance: Array
    first_order: Array
    source_variance: Array
    source_first_order: Array
    interaction_variance: Array
    degrees_of_freedom: Array
    C: Array
    H: Array
    outputs: tuple[Output, ...] = ()
    sources: tuple[Name, ...] = ()
    legs: NDArray[np.intp] = field(
        default_factory=lambda: np.empty((2, 0), dtype=np.intp)
    )

    @property
    def standard_uncertainty(self) -> Array:
        """Standard uncertainties of the outputs, shape (n_out,)."""
        return np.sqrt(np.diag(self.covariance))

    def coverage_factor(self, coverage: float | Array) -> Array:
        """Return k of every output, shape (n_out,) [1].

        Of the normal law, or of Student's t for the effective degrees of freedom,
        cut to the integer below: JCGM 100:2008, G.4. Of a length, the radius over its
        standard uncertainty. The coverage is that of all, or of each output.

        Raises
        ------
        CallError
            The coverage is none that intervals can be computed for.
        """
        known = np.isinf(self.degrees_of_freedom)
        each = np.broadcast_to(np.asarray(coverage, dtype=float), known.shape)
        if wrong := [one for one in each.tolist() if not is_coverage(one)]:
            raise CallError(f"coverage is {wrong[0]!r}, allowed: {COVERAGES}")
        p = (1.0 + each) / 2.0
        normal = np.array([NormalDist().inv_cdf(one) for one in p.tolist()])
        if self.legs.size:
            first = known.size - self.legs.shape[1]
            u = self.standard_uncertainty[first:]
            radius = circles(self.covariance, self.legs, each[first:])
            normal[first:] = np.divide(
                radius, u, out=normal[first:].copy(), where=u > 0.0
            )
        if known.all():
            return normal
        from scipy.special import stdtrit

        # A whole number of degrees of freedom must not fall short of it by rounding.
        v = np.where(known, 1.0, self.degrees_of_freedom) * (1.0 + ROUNDING)
        k = stdtrit(np.maximum(np.floor(v), 1.0), p)
        if self.legs.size:  # a radius grows as k does
            usual = np.array([NormalDist().inv_cdf(one) for one in p[first:].tolist()])
            k[first:] *= normal[first:] / usual
        return np.asarray(np.where(known, normal, k))

    def probability_of_length(self, place: int, radius: float) -> float:
        """Return the probability that a length is within a radius [1].

        Of the length of that place among the lengths.
        """
        variances = plane_variances(self.covariance, self.legs[:, [place]])
        return float(probability_within(np.array([radius]), variances)[0])

    def interval(self, coverage: float | Array) -> Array:
        """Return mean +- k u, shape (n_out, 2)."""
        U = self.coverage_factor(coverage) * self.standard_uncertainty
        return np.stack([self.mean - U, self.mean + U], axis=1)

    def to_frame(self, coverage: float = 0.95) -> pd.DataFrame:
        """Return a pandas table, in the units of the outputs.

        A row for each output and source, one for `interaction` (products of two
        sources) and one for `total`: output, unit, source, standard_uncertainty and
        share of the variance [1]; mean and interval stand on the totals alone.

        Raises
        ------
        CallError
            As of `coverage_factor`.
        """
        import pandas as pd

        interval = self.interval(coverage)
        names = (*map(str, self.sources), "interaction", "total")
        rows = []
        for k, output in enumerate(self.outputs):
            total = float(self.covariance[k, k])
            parts = [*self.source_variance[:, k], self.interaction_variance[k], total]
            for name, part in zip(names, parts, strict=True):
                ends = interval[k] if name == "total" else (np.nan, np.nan)
                rows.append(
                    {
                        "output": str(output.name),
                        "unit": output.unit,
                        "source": name,
                        "standard_uncertainty": np.sqrt(max(part, 0.0))
                        / output.si_per_unit,
                        "share": part / total if total > 0.0 else 0.0,
                        "mean": (self.mean[k] if name == "total" else np.nan)
                        / output.si_per_unit,
                        "interval_low": ends[0] / output.si_per_unit,
                        "interval_high": ends[1] / output.si_per_unit,
                    }
                )
        return pd.DataFrame.from_records(rows)


def propagate(problem: Problem) -> Propagation:
    """Propagate means and covariances through a Problem to second order.

    Parameters
    ----------
    problem : Problem
        Any; its function must be made of numpy arithmetic that jets.Jet knows.

    Returns
    -------
    Propagation
        [SI units of the outputs].

    Raises
    ------
    ProblemError
        The model bends in an input whose shape has no finite kurtosis, has no
        derivatives at the best estimates, or overflows.
    """
    return propagate_together([problem])[0]


def propagate_together(problems: Sequence[Problem]) -> list[Propagation]:
    """Propagate through several Problems, those of one structure at once.

    Of one structure are those of one function and the same estimates, whose sources
    have the same names and sizes: they share the derivatives, and differ in the
    covariances of their inputs alone. Each law is that of its Problem alone.

    Raises
    ------
    ProblemError
        As propagate.
    """
    alike: dict[Hashable, list[int]] = {}
    for place, one in enumerate(problems):
        alike.setdefault(_structure(one), []).append(place)
    found: dict[int, Propagation] = {}
    for places in alike.values():
        for start in range(0, len(places), AT_ONCE):
            some = places[start : start + AT_ONCE]
            laws = _propagated([problems[place] for place in some])
            found |= dict(zip(some, laws, strict=True))
    return [found[place] for place in range(len(problems))]


def _structure(problem: Problem) -> Hashable:
    """Return what Problems have in common whose derivatives are the same."""
    if not getattr(problem.function, "is_steady", False):
        return id(problem)
    groups = tuple((group.name, group.size, group.pool) for group in problem.groups)
    shared = (id(problem.function), id(problem.outputs))
    return *shared, problem.mean.tobytes(), groups


def _propagated(problems: Sequence[Problem]) -> list[Propagation]:
    """Propagate through Problems of one structure; n of them in what follows."""
    first = problems[0]
    taylor = derivatives(first)
    C, H, slices = taylor.C, taylor.H, first.slices
    U_x = np.zeros((len(problems), C.shape[1], C.shape[1]))
    for g, rows in enumerate(slices):  # all else is 0: groups are independent
        U_x[:, rows, rows] = [one.groups[g].covariance for one in problems]
    CU = C @ U_x
    first_order = CU @ C.T  # JCGM 102:2011, 6.2.1.3, shape (n, n_out, n_out)
    # H U, of which the rows (k, i) alone are not 0 that H has.
    k, i = np.nonzero(H.any(axis=2))
    HU = np.zeros((len(problems), *H.shape))
    HU[:, k, i] = H[k, i] @ U_x
    UH = HU.transpose(0, 1, 3, 2)
    flat = (len(problems), len(C), H.shape[1] * H.shape[2])
    second = 0.5 * HU.reshape(flat) @ UH.reshape(flat).transpose(0, 2, 1)
    skew, excess = map(np.array, zip(*map(higher_moments, problems), strict=True))
    diagonal = np.einsum("kii->ki", H)
    for one, own in zip(problems, excess, strict=True):
        _refuse_infinite(one, diagonal, own)
    excess = np.where(np.isfinite(excess), excess, 0.0)[:, None]
    skew = np.where(np.isfinite(skew), skew, 0.0)[:, None]
    if excess.any() or skew.any():
        second += (diagonal * excess) @ diagonal.T
        leaning = (C * (0.5 * skew)) @ diagonal.T
        second += leaning + leaning.transpose(0, 2, 1)
    # Per pair of sources: 1/2 sum over i in one, j in the other of (HU)_ij (HU)_ji.
    pair = 0.5 * HU[:, k, i] * UH[:, k, i]
    source = np.repeat(np.arange(len(slices)), [x.stop - x.start for x in slices])
    is_own = source[i, None] == source
    own, between = (
        (pair * chosen).sum(axis=-1)[:, None] for chosen in (is_own, ~is_own)
    )
    of_output = (k[:, None] == np.arange(len(C))).astype(float)
    linear = np.zeros((len(problems), len(slices), len(C)))
    alone = np.zeros_like(linear)
    by_shape = diagonal**2 * excess + C * diagonal * skew
    for g, rows in enumerate(slices):
        linear[:, g] = (CU[:, :, rows] * C[:, rows]).sum(axis=-1)
        chosen = of_output * (source[i] == g)[:, None]
        alone[:, g] = linear[:, g] + (own @ chosen)[:, 0]
        alone[:, g] += by_shape[:, :, rows].sum(axis=-1)
    covariance = first_order + second
    mean = taylor.value + 0.5 * np.einsum("nkii->nk", HU)
    interaction = (between @ of_output)[:, 0]
    found = []
    for n, one in enumerate(problems):
        refuse_no_number(
            one, "variance", np.sqrt(np.diag(covariance[n])), covariance[n]
        )
        law = Propagation(
            value=taylor.value,
            mean=mean[n],
            covariance=covariance[n],
            first_order=first_order[n],
            source_variance=alone[n],
            source_first_order=linear[n],
            interaction_variance=interaction[n],
            degrees_of_freedom=_effective_degrees_of_freedom(one, C, first_order[n]),
            C=C,
            H=H,
            outputs=tuple(one.outputs),
            sources=tuple(group.name for group in one.groups),
        )
        found.append(_with_lengths(law, one.legs) if one.legs.size else law)
    return found


def derivatives(problem: Problem) -> Expansion:
    """Return the outputs that are no lengths and their derivatives by all inputs.

    Raises
    ------
    ProblemError
        The model has no derivatives at the best estimates, or overflows.
    """
    # Derivatives by the function's arguments; inputs of a pool share them.
    point = problem.add_up(problem.mean[:, None])[:, 0]
    if getattr(problem.function, "is_steady", False):
        kept = _KEPT.setdefault(problem.function, {})
        if (key := point.tobytes()) not in kept:
            kept[key] = _Thin.of(expand(problem.components, point))
        taylor = kept[key].whole
    else:
        taylor = expand(problem.components, point)
    columns = problem.columns
    C, H = taylor.C[:, columns], taylor.H[:, columns[:, None], columns]
    refuse_no_number(problem, "value", taylor.value)
    refuse_no_number(problem, "derivative", C, H)
    return Expansion(value=taylor.value, C=C, H=H)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Thin:
    """An expansion without the zeros of its second derivatives, which most of it is."""

    value: Array
    C: Array
    shape: tuple[int, ...]
    places: NDArray[np.intp]
    second: Array

    @classmethod
    def of(cls, taylor: Expansion) -> _Thin:
        """Leave the zeros out."""
        places = np.flatnonzero(taylor.H)
        return cls(
            value=taylor.value,
            C=taylor.C,
            shape=taylor.H.shape,
            places=places,
            second=taylor.H.ravel()[places],
        )

    @property
    def whole(self) -> Expansion:
        """The expansion with them."""
        H = np.zeros(self.shape)
        H.ravel()[self.places] = self.second
        return Expansion(value=self.value, C=self.C, H=H)


# By functions that are the same whenever they are called, for as long as these are
# there: devices of one structure have one function.
_KEPT: WeakKeyDictionary[Function, dict[bytes, _Thin]] = WeakKeyDictionary()


def covariance_by_source(problem: Problem, law: Propagation | Expansion) -> Array:
    """Return the covariance that each source alone makes, and products of two.

    Shape (n_groups + 1, n, n) [SI squared], products last, of the outputs that are no
    lengths; their sum is the law's covariance, their diagonals `source_variance` and
    `interaction_variance`. The law, or the derivatives alone, are of the Problem.

    Raises
    ------
    ProblemError
        The model bends in an input whose shape has no finite kurtosis, or overflows.
    """
    n = len(problem.outputs) - problem.legs.shape[1]
    C, H = law.C[:n], law.H[:n]
    skew, excess = higher_moments(problem)
    _refuse_infinite(problem, np.einsum("kii->ki", H), excess)
    found = np.zeros((len(problem.groups) + 1, n, n))
    products = np.zeros(H.shape)
    for g, (rows, group) in enumerate(zip(problem.slices, problem.groups, strict=True)):
        products[:, :, rows] = H[:, :, rows] @ group.covariance
        HU = products[:, rows, rows]
        within = 0.5 * np.tensordot(HU, HU, axes=((1, 2), (2, 1)))
        found[-1] -= within
        diagonal = np.einsum("kii->ki", H[:, rows, rows])
        leaning = (C[:, rows] * (0.5 * np.nan_to_num(skew[rows]))) @ diagonal.T
        found[g] = (
            C[:, rows] @ group.covariance @ C[:, rows].T
            + within
            + (diagonal * np.nan_to_num(excess[rows], posinf=0.0)) @ diagonal.T
            + (leaning + leaning.T)
        )
    found[-1] += 0.5 * np.tensordot(products, products, axes=((1, 2), (2, 1)))
    refuse_no_number(problem, "variance", found.sum(axis=0))
    return found


def _with_lengths(law: Propagation, legs: NDArray[np.intp]) -> Propagation:
    """Add lengths to the law of their components."""

    def added(rows: Array) -> Array:
        """Append sums over the two components, outputs standing first."""
        return np.concatenate([rows, rows[legs[0]] + rows[legs[1]]])

    nothing = np.zeros(legs.shape[1])

    def bordered(covariance: Array) -> Array:
        """Append variances to a covariance."""
        n = len(covariance)
        found = np.diag(added(np.diag(covariance)))
        found[:n, :n] = covariance
        return found

    return replace(
        law,
        value=np.concatenate([law.value, nothing]),
        mean=np.concatenate([law.mean, nothing]),
        covariance=bordered(law.covariance),
        first_order=bordered(law.first_order),
        source_variance=added(law.source_variance.T).T,
        source_first_order=added(law.source_first_order.T).T,
        interaction_variance=added(law.interaction_variance),
        degrees_of_freedom=np.concatenate(
            [law.degrees_of_freedom, law.degrees_of_freedom[legs].min(axis=0)]
        ),
        C=np.concatenate([law.C, np.hypot(*law.C[legs])]),
        H=np.concatenate([law.H, np.zeros((legs.shape[1], *law.H.shape[1:]))]),
        legs=legs,
    )


def _effective_degrees_of_freedom(
    problem: Problem, C: Array, first_order: Array
) -> Array:
    """Return the Welch-Satterthwaite formula, shape (n_out,): (G.2b).

    What one scale is of is one term: it is off as a whole.
    """
    few = [_few(group.distributions) for group in problem.groups]
    scales = any(group.scales for group in problem.groups)
    if not (scales or any(one.any() for one in few)):
        return np.full(len(C), np.inf)
    over_v = np.concatenate(few)
    u = np.sqrt(np.concatenate([np.diag(g.covariance) for g in problem.groups]))
    parts = ((C * u) ** 4 * over_v).sum(axis=1)
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        for scale in group.scales:
            own = list(scale.rows)
            c, U_x = C[:, rows][:, own], group.covariance[np.ix_(own, own)]
            parts += np.einsum("ki,ij,kj->k", c, U_x, c) ** 2 / scale.degrees_of_freedom
    combined = np.diag(first_order) ** 2
    is_few = parts > 0.0
    return np.where(is_few, combined / np.where(is_few, parts, 1.0), np.inf)


@lru_cache(maxsize=256)
def _few(shapes: tuple[Distribution, ...]) -> Array:
    """Return one over the degrees of freedom of some inputs, shape (n,) [1]."""
    return 1.0 / np.array([shape.degrees_of_freedom for shape in shapes])


@lru_cache(maxsize=256)
def _of_shapes(shapes: tuple[Distribution, ...]) -> tuple[Array, Array]:
    """Return skewness and (kurtosis - 3)/4 of some inputs, shape (n,) each [1]."""
    gamma = np.array([shape.skewness for shape in shapes])
    return gamma, (np.array([shape.kurtosis for shape in shapes]) - 3.0) / 4.0


def higher_moments(problem: Problem) -> tuple[Array, Array]:
    """Return skewness u^3 and (kurtosis - 3)/4 u^4 of every input, each shape (n_in,).

    Both are 0 in groups whose inputs are correlated.
    """
    skew, excess = [np.empty(0)], [np.empty(0)]
    for group in problem.groups:
        u2 = np.diag(group.covariance)
        gamma, kurtosis = _of_shapes(group.distributions)
        # An infinite moment of what does not vary counts nothing.
        counts = (u2 > 0.0) & group.is_independent
        skew.append(np.where(counts, gamma, 0.0) * u2**1.5)
        excess.append(np.where(counts, kurtosis, 0.0) * u2**2)
    return np.concatenate(skew), np.concatenate(excess)


def refuse_no_number(problem: Problem, what: str, *found: Array) -> None:
    """Refuse what is not finite, an array having a row for each output."""
    bad = np.zeros(len(found[0]), dtype=bool)
    for array in found:
        bad |= ~np.isfinite(array.reshape(len(bad), -1)).all(axis=1)
    if bad.any():
        names = ", ".join(
            output.name
            for output, is_bad in zip(problem.outputs, bad, strict=False)
            if is_bad
        )
        raise ProblemError(
            f"the law of propagation finds no finite {what} of {names} at the best "
            "estimates; mend the function where it overflows or divides by zero, or "
            "use sample() (Monte Carlo)"
        )


def _refuse_infinite(problem: Problem, diagonal: Array, excess: Array) -> None:
    """Refuse second-order terms that are infinite, by the name of the source."""
    infinite = ~np.isfinite(excess) & diagonal.any(axis=0)
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        if infinite[rows].any():
            shape = group.distributions[int(np.argmax(infinite[rows]))].name
            raise ProblemError(
                f"input group {group.name!r}: the model is not linear in an input of "
                f"shape {shape}, whose kurtosis is infinite, and so is the variance "
                "to second order; take Monte Carlo (budget.sample), or a shape with "
                "lighter tails"
            )
