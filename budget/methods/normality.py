"""Error of the law's interval ends for outputs that are not quite normal.

The law takes an output for normal. With g1 = k3/u^3 and g2 = k4/u^4 its skewness and
excess kurtosis, the quantile of an almost normal quantity is, by Cornish and Fisher
(Abramowitz and Stegun, 26.2.49),

    mean + u (z + (z^2 - 1) g1/6 + (z^3 - 3 z) g2/24 - (2 z^3 - 5 z) g1^2/36 + ...) .

The cumulants are those of the second-order expansion y = c x + x^T H x/2 with the input
covariance U (Mathai and Provost, Quadratic Forms in Random Variables, 3.2b), and of the
shapes of the inputs,

    k3 = 3 c U H U c + tr (H U)^3 ,
    k4 = 12 c U H U H U c + 3 tr (H U)^4 + sum_i c_i^4 u_i^4 (kurtosis_i - 3) ,

where the inputs that are not normal have symmetric shapes. The estimate takes every
term without its sign and 2.5 times the sum: the polynomials pass zero at coverages
where the next term decides, and symmetric shapes are off there all the same. What the
second order leaves out is seen at trials: the largest deviation from it is added.

A radius is off by no more than its components together, in their proportion to it, and
by how far their mean is from 0.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL, normal_coverage_factor
from budget.methods.execution import draw, small_blocks

if TYPE_CHECKING:
    from collections.abc import Hashable

    from budget.arrays import Array
    from budget.distributions import Distribution
    from budget.methods.gum import Propagation
    from budget.problem import Problem

SAFETY = 2.5  # on the terms of the expansion [1]
PROBES = 256  # trials at which the expansion is held against the function
PROBE_SEED = 0  # whatever the run's is: the law depends on no seed
KEPT = 128  # sources of one size, whose probes are kept
ROUNDING = 1e-12  # of doubles, over the sums of a problem [1]


def end_accuracy(problem: Problem, law: Propagation, coverage: float | Array) -> Array:
    """Estimate by how much the true interval ends can differ from the law's.

    Shape (n_out,) [SI unit of the output]. Where inputs have few degrees of freedom k
    is a convention and no quantile of the output: it can be off by what it is more than
    the normal one, and that SAFETY times. The coverage is that of all, or of each.
    """
    z = normal_coverage_factor(coverage)
    u = law.standard_uncertainty
    g1, g2 = _shape(problem, law, np.where(u > 0.0, u, 1.0))
    terms = (
        (z**2 + 1.0) / 6.0 * g1
        + (z**3 + 3.0 * z) / 24.0 * g2
        + (2.0 * z**3 + 5.0 * z) / 36.0 * g1**2
    )
    size = np.abs(law.mean) + z * u
    found = SAFETY * terms * u + _deviation(problem, law) + ROUNDING * size
    if law.legs.size:
        lengths = slice(found.size - law.legs.shape[1], None)
        wide = np.hypot(*u[law.legs])
        part = np.hypot(*found[law.legs]) / np.where(wide > 0.0, wide, 1.0)
        radius = (law.coverage_factor(coverage) * u)[lengths]
        within = np.broadcast_to(z, found.shape)[lengths]
        found[lengths] = part / within * radius + np.hypot(*law.mean[law.legs])
    few = np.isfinite(law.degrees_of_freedom)
    if few.any():
        from scipy.special import stdtrit

        p = (1.0 + np.broadcast_to(coverage, found.shape)[few]) / 2.0
        normal = np.broadcast_to(z, found.shape)[few]
        more = stdtrit(law.degrees_of_freedom[few], p) / normal - 1.0
        found[few] += SAFETY * more * (law.coverage_factor(coverage) * u)[few]
    return found


def _shape(problem: Problem, law: Propagation, u: Array) -> tuple[Array, Array]:
    """Return bounds of |skewness| and |excess kurtosis|, shape (n_out,) each [1]."""
    U = problem.input_covariance
    excess = np.concatenate(
        [np.empty(0), *(_excess(group.distributions) for group in problem.groups)]
    )
    # Rows of H U that are 0 take no part: of each output the others, as many of each.
    is_there = law.H.any(axis=2)
    most = int(is_there.sum(axis=1).max(initial=0))
    bent = np.argsort(~is_there, axis=1, kind="stable")[:, :most]  # (n_out, most)
    outputs = np.arange(len(bent))[:, None]
    with small_blocks():
        # Over u first: cubes and fourth powers of 1e-8 rad/s leave few digits.
        C, wide = law.C / u[:, None], law.H[outputs, bent] @ U / u[:, None, None]
        HU = wide[outputs[:, :, None], np.arange(most)[:, None], bent[:, None, :]]
        once = (wide @ C[:, :, None])[:, :, 0]  # H U c
        squared = HU @ HU
        k3 = 3.0 * ((C @ U)[outputs, bent] * once).sum(axis=1) + np.einsum(
            "kij,kji->k", squared, HU
        )
        among = U[bent[:, :, None], bent[:, None, :]]
        k4 = 12.0 * np.einsum("ki,kij,kj->k", once, among, once) + 3.0 * np.einsum(
            "kij,kji->k", squared, squared
        )
    return np.abs(k3), np.abs(k4) + C**4 @ (np.diag(U) ** 2 * excess)


@lru_cache(maxsize=256)
def _excess(shapes: tuple[Distribution, ...]) -> Array:
    """Return |excess kurtosis| of some inputs, shape (n,) [1]."""
    return np.array([abs(one.kurtosis - NORMAL.kurtosis) for one in shapes])


# Devices have the same sources, whose probes are drawn once.
_DRAWN: dict[Hashable, Array] = {}


def _deviation(problem: Problem, law: Propagation) -> Array:
    """Return the largest deviation of trials from the expansion, (n_out,) [SI]."""
    if len(_DRAWN) > KEPT:
        _DRAWN.clear()
    x = np.empty((problem.n_inputs, PROBES))
    x = draw(problem, PROBE_SEED, 0, x, kept=_DRAWN)
    with small_blocks():
        y = problem.evaluate(x)
        dx = x - problem.mean[:, None]
        expanded = law.value[:, None] + law.C @ dx
        k, i = np.nonzero(law.H.any(axis=2))
        bent = 0.5 * dx[i] * (law.H[k, i] @ dx)
        expanded += (np.arange(len(expanded))[:, None] == k).astype(float) @ bent
    return np.asarray(np.abs(y - expanded).max(axis=1))
