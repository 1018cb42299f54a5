"""Values of a recorded run, and how sure they are: by the budget's law, or by scatter.

The covariance is that of the budget, of errors against the values during the test
(budget.calibration.problem). Without a device it is that of the scatter: with s^2 the
residual sum of squares over n - m degrees of freedom, and J the derivative of the
estimate by the readings, J s^2 J'.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import hypot, inf, isnan, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import known_outputs, parts_of
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import estimated, windows_of
from budget.errors import CallError
from budget.methods.gum import propagate
from budget.model.norm import NormScheme
from budget.model.response import COLUMN, ROW, SIGN
from budget.names import ANGLES, AXES, ORDERS, Name, parameters_of
from budget.recordings.calibrated import CalibratedOutput, CompensationMatrix

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Device, Procedure
    from budget.problem import Output
    from budget.recordings.run_triads import RunTriad

STEP = 1e-4  # of readings over the largest, that the estimate is differentiated by [1]
AS_TESTED, SCALE_FACTOR = "as_tested", "scale_factor"


@dataclass(frozen=True, kw_only=True, eq=False)
class RunValues:
    """Outputs of all triads, with values and how sure these are [SI]."""

    triads: Mapping[str, RunTriad]
    outputs: tuple[Output, ...]
    value: Array
    covariance: Array
    degrees_of_freedom: Array
    nominal: Array
    prior: Array  # standard uncertainties before; nan where nothing is known

    @classmethod
    def of(
        cls, triads: Sequence[RunTriad], procedure: Procedure, unit: Device | None
    ) -> RunValues:
        """Put values, and the law of the budget or the scatter, together."""
        kinds = [one.kind for one in triads]
        wanted = known_outputs(kinds, procedure)
        if not wanted:
            raise CallError(f"{procedure.name} estimates nothing of the {kinds[0]}")
        sensors = tuple(one.sensor for one in triads)
        problem = calibration_problem(
            sensors, procedure, reference=AS_TESTED, outputs=wanted
        )
        values: dict[Name, float] = {}
        nominal: dict[Name, float] = {}
        prior: dict[Name, float] = {}
        for one in triads:
            names = _names(one, procedure)
            values |= zip(names, one.values.tolist(), strict=True)
            nominal |= zip(names, one.nominal.tolist(), strict=True)
            prior |= zip(names, one.prior.tolist(), strict=True)
        if unit is None:
            covariance, nu = _by_scatter(triads, procedure, wanted)
        else:
            law = propagate(problem)
            from_zero = _from_zero(triads, wanted)
            covariance = from_zero @ law.covariance @ from_zero.T
            covariance += _by_steps(triads, procedure, wanted)
            nu = law.degrees_of_freedom
        before = [
            sqrt(sum((x * prior[part]) ** 2 for part, x in parts_of(name).items()))
            for name in wanted
        ]
        return cls(
            triads={one.kind: one for one in triads},
            outputs=tuple(problem.outputs),
            value=_summed(wanted, values),
            covariance=np.asarray(covariance),
            degrees_of_freedom=np.asarray(nu),
            nominal=_summed(wanted, nominal),
            prior=np.array(before) if unit else np.full(len(wanted), nan),
        )

    @cached_property
    def of_scale(self) -> tuple[RunTriad | None, ...]:
        """The triads whose scale factors outputs are; None of all others."""
        return tuple(
            self.triads.get(one.name.owner if one.name.quantity == SCALE_FACTOR else "")
            for one in self.outputs
        )

    @property
    def units(self) -> Iterator[tuple[str, float]]:
        """Units of outputs with their sizes, of counts over the input's."""
        for output, one in zip(self.outputs, self.of_scale, strict=True):
            if one is None or not one.has_counts:
                yield output.unit, output.si_per_unit
            else:
                unit, size = one.unit_of_scale
                yield unit, 1.0 / size

    @cached_property
    def factors(self) -> Array:
        """What the law's errors are times of those of the values: K of counts."""
        return np.array(
            [
                1.0 if one is None else abs(one.scale_factor[AXES.index(own.name.axis)])
                for own, one in zip(self.outputs, self.of_scale, strict=True)
            ]
        )

    @property
    def printed_covariance(self) -> Array:
        """Covariance of the values, in their units."""
        change = self.factors / np.array([size for _, size in self.units])
        return np.asarray(self.covariance * np.outer(change, change))

    def rows(
        self, coverage: float, limits: Mapping[Name, float]
    ) -> Iterator[CalibratedOutput]:
        """Yield the values, each with how sure it is and what was known before."""
        u = np.sqrt(np.diag(self.covariance)) * self.factors
        k = _coverage_factors(self.degrees_of_freedom, coverage)
        for row, (output, (unit, size)) in enumerate(
            zip(self.outputs, self.units, strict=True)
        ):
            prior, nominal = float(self.prior[row]), float(self.nominal[row])
            is_known = np.isfinite(prior) and np.isfinite(nominal) and prior > 0.0
            off = self.value[row] - nominal
            yield CalibratedOutput(
                sensor=output.name.owner,
                parameter=output.name.quantity,
                axis=output.name.axis,
                unit=unit,
                si_per_unit=size,
                value=float(self.value[row]),
                standard_uncertainty=float(u[row]),
                coverage_factor=float(k[row]),
                degrees_of_freedom=float(self.degrees_of_freedom[row]),
                prior=prior if is_known else None,
                prior_z=float(off / hypot(prior, u[row])) if is_known else None,
                limit=limits.get(output.name) if unit == output.unit else None,
            )

    def matrix(self, triad: RunTriad) -> CompensationMatrix:
        """Return S, its inverse and its parts, with what these are not known to."""
        (unit, of_scale), (bias_unit, size) = triad.unit_of_scale, triad.unit
        K, M = triad.scale_factor, triad.found.response
        S = K[:, None] * M * of_scale
        rows = {one.name: k for k, one in enumerate(self.outputs)}
        u_S, u_b = np.full((3, 3), np.nan), np.full(3, np.nan)  # of what is held

        def covariance(a: Name, b: Name) -> float:
            return (
                float(self.covariance[rows[a], rows[b]]) if {a, b} <= {*rows} else 0.0
            )

        def u(name: Name, other: Name, x: float) -> float:
            """Return that of a parameter and x times another; nan if it is held."""
            square = (
                x**2 * covariance(other, other)
                + 2.0 * x * covariance(other, name)
                + covariance(name, name)
            )
            return sqrt(max(square, 0.0)) if name in rows else nan

        names = [Name(SCALE_FACTOR, owner=triad.kind, axis=axis) for axis in AXES]
        for i, (axis, own) in enumerate(zip(AXES, names, strict=True)):
            u_S[i, i] = u(own, own, 0.0)
            bias = Name("bias", owner=triad.kind, axis=axis)
            u_b[i] = u(bias, own, triad.bias[i])
        for axis, i, j, sign in zip(ANGLES, ROW, COLUMN, SIGN, strict=True):
            angle = Name("mounting_angle", owner=triad.kind, axis=axis)
            u_S[i, j] = u(angle, names[i], sign * M[i, j])
        q, r = np.linalg.qr(S.T)
        # The sign of an axis that is reversed is that of its scale factor, so that R is
        # a rotation.
        signs = np.where(np.diag(r) * K < 0.0, -1.0, 1.0)
        scale = np.abs(K)
        (u_bias,) = _or_none([u_b * scale / size])
        return CompensationMatrix(
            sensor=triad.kind,
            unit=unit,
            sensor_from_body=S,
            body_from_sensor=np.asarray(np.linalg.inv(S), dtype=float),
            bias=K * triad.bias / size,
            bias_unit=bias_unit,
            standard_uncertainty=_or_none(u_S * scale[:, None] * of_scale),
            bias_standard_uncertainty=u_bias,
            triangle=r.T * signs,
            rotation=(q * signs).T,
        )


def _from_zero(triads: Sequence[RunTriad], wanted: Sequence[Name]) -> Array:
    """Return derivatives of outputs by those of readings taken from their zero.

    B = b + zero/K: a bias that is far from the middle of the readings is known no
    better than K is.
    """
    rows = {name: row for row, name in enumerate(wanted)}
    found = np.eye(len(wanted))
    for one in triads:
        for i, axis in enumerate(AXES):
            bias = rows.get(Name("bias", owner=one.kind, axis=axis))
            scale = rows.get(Name(SCALE_FACTOR, owner=one.kind, axis=axis))
            if bias is not None and scale is not None:
                found[bias, scale] = -one.zero[i] / one.scale_factor[i]
    return found


def _names(triad: RunTriad, procedure: Procedure) -> list[Name]:
    """Return the names of a triad's values, in their order."""
    kind = triad.kind
    more = [one for one in estimated(kind, procedure) if one.quantity in ORDERS]
    return [*parameters_of(kind), *more][: len(triad.values)]


def _summed(names: Sequence[Name], values: Mapping[Name, float]) -> Array:
    """Return outputs of parameters, each a sum of its parts."""
    return np.array(
        [sum(x * values[part] for part, x in parts_of(one).items()) for one in names]
    )


def _by_scatter(
    triads: Sequence[RunTriad], procedure: Procedure, wanted: Sequence[Name]
) -> tuple[Array, Array]:
    """Return covariance and degrees of freedom of outputs by the scatter of readings.

    Means have variances s^2 T0/T of white noise, T the median length of turns, or of
    dwells; s^2 is the sum of squares of the residuals R y over tr(A), with
    tr(A)^2/tr(A^2) degrees of freedom, A = D^1/2 R'R D^1/2, D = T0/T (Welch and
    Satterthwaite). Dwells alone have the residual mean square, with n less the
    parameters.

    Raises
    ------
    CallError
        There are no more readings than parameters.
    """
    n = len(wanted)
    windows = windows_of(procedure)
    covariance, nu = np.zeros((n, n)), np.full(n, inf)
    for triad in triads:
        names = _names(triad, procedure)
        left = triad.residuals
        held = triad.scheme.held
        D = np.ones(left.shape[1])
        if isinstance(triad.scheme, NormScheme):
            free = np.full(3, left.shape[1] - len(triad.scheme.held.estimated))
        else:
            which = np.zeros((3, 4), dtype=bool) if held is None else held.which
            fitted = (~which).sum(axis=1) + len(triad.scheme.orders)
            free = left.shape[1] - fitted
            own = [windows[k - 1] for k in triad.numbers]
            times: dict[bool, list[float]] = {}
            for one in own:
                times.setdefault(bool(one.sense), []).append(one.length)
            D = 1.0 / np.array([np.median(times[bool(one.sense)]) for one in own])
            D /= D.min()
        if min(free) <= 0:
            raise CallError(
                f"{procedure.name} has no more windows than parameters of the "
                f"{triad.kind}, so that no scatter says how sure they are; "
                "give the device (--device), or repeat windows"
            )
        variance = (left**2).sum(axis=1) * triad.found.scale_factor**2 / free
        if not isinstance(triad.scheme, NormScheme):
            R = residual_weights(triad)
            A = np.sqrt(D)[:, None] * np.einsum("iab,iac->ibc", R, R) * np.sqrt(D)
            trace = np.einsum("ibb->i", A)
            variance *= free / trace
            # Whole degrees are not to fall to the next lower by rounding.
            free = np.round(trace**2 / (A**2).sum(axis=(1, 2)), 9)
        J = _derivative(triad)  # (values, 3, n)
        of_values = np.einsum("pin,i,n,qin->pq", J, variance, D, J)
        change = _of_values(wanted, names)
        covariance += change @ of_values @ change.T
        for place in np.flatnonzero(change.any(axis=1)).tolist():
            axes = {AXES.index(names[k].axis[0]) for k in np.flatnonzero(change[place])}
            nu[place] = min(nu[place], *(free[axis] for axis in axes))
    return covariance, nu


def _by_steps(
    triads: Sequence[RunTriad], procedure: Procedure, wanted: Sequence[Name]
) -> Array:
    """Return the covariance of outputs by what steps of readings put into means."""
    found = np.zeros((len(wanted), len(wanted)))
    for one in triads:
        if one.rounding is not None:
            J = _derivative(one)  # (values, 3, n)
            change = _of_values(wanted, _names(one, procedure))
            of_values = np.einsum("pin,i,qin->pq", J, one.rounding, J)
            found += change @ of_values @ change.T
    return found


def _of_values(wanted: Sequence[Name], names: Sequence[Name]) -> Array:
    """Return the derivatives of outputs by a triad's values."""
    change = np.zeros((len(wanted), len(names)))
    for row, name in enumerate(wanted):
        for part, x in parts_of(name).items():
            if part in names:
                change[row, names.index(part)] = x
    return change


def _derivative(triad: RunTriad) -> Array:
    """Return the derivatives of relative values by scaled readings, (values, 3, n)."""
    y = triad.scaled
    step = STEP * float(np.abs(y).max())
    found = np.zeros((len(triad.values), *y.shape))
    for axis in range(3):
        for k in range(y.shape[1]):
            ends = []
            for sign in (1.0, -1.0):
                moved = y.copy()
                moved[axis, k] += sign * step
                one = triad.scheme.estimate(moved)
                relative = one.scale_factor / triad.found.scale_factor
                bias = one.bias + triad.zero / (triad.scale * one.scale_factor)
                ends.append(replace(one, scale_factor=relative, bias=bias).vector)
            found[:, axis, k] = (ends[0] - ends[1])[: len(found)] / (2.0 * step)
    return found


def residual_weights(triad: RunTriad) -> Array:
    """Return R of residuals R y, 1 - A W of each axis, (3, n, n)."""
    scheme = triad.scheme
    n = triad.readings.shape[1]
    A = np.column_stack([triad.inputs, np.ones(n)])
    columns = [
        np.column_stack([A, scheme.powers[axis]]) if scheme.orders else A
        for axis in range(3)
    ]
    return np.asarray(np.eye(n) - np.array(columns) @ np.array(scheme.weights))


def _coverage_factors(degrees_of_freedom: Array, coverage: float) -> Array:
    """Return k of the t distribution, for the integer below: JCGM 100, G.4."""
    from scipy.special import ndtri, stdtrit

    p = (1.0 + coverage) / 2.0
    nu = np.floor(np.where(np.isinf(degrees_of_freedom), 1.0, degrees_of_freedom))
    return np.asarray(
        np.where(
            np.isinf(degrees_of_freedom), ndtri(p), stdtrit(np.maximum(nu, 1.0), p)
        )
    )


def _or_none(rows: Iterable[Array]) -> tuple[tuple[float | None, ...], ...]:
    """Return rows of numbers, None where nothing was estimated."""
    return tuple(tuple(None if isnan(x) else x for x in one.tolist()) for one in rows)
