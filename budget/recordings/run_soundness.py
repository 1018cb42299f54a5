"""Whether a recorded run is sound: what is left, and mistakes that it looks like."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from budget.calibration.mistakes import TriadRun
from budget.calibration.mistakes_of_norm import NormRun
from budget.calibration.mistakes_of_rotation import RotationRun
from budget.calibration.problem import BIAS_UNITS
from budget.calibration.schemes import (
    calibrates,
    is_beside,
    orders_of,
    schemes_of,
    windows_of,
)
from budget.errors import BudgetError
from budget.model.measured import MeasuredTurns, turns_of_rows
from budget.model.norm import NormScheme
from budget.model.response import response
from budget.model.rotation import RotationScheme
from budget.model.source import GYRO
from budget.recordings.calibrated import (
    MistakeRow,
    RunChiSquare,
    RunTurn,
    RunWindow,
    Suspicion,
    UnseenMistake,
)
from budget.recordings.run_triads import by_norm, run_triad
from budget.recordings.run_values import residual_weights
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.calibration.mistakes import ChiSquare, Mistake
    from budget.inputs.records import Device, Procedure, Sensor
    from budget.model.scheme import Scheme
    from budget.recordings.run_triads import RunTriad
    from budget.recordings.window_table import RecordedWindows

AnyRun = TriadRun | NormRun | RotationRun
SHOWN = 0.95  # probability of being seen, below which a mistake may be missed [1]
WORST = 3  # windows that are named
TINY = 1e-9  # of a reading's uncertainty, below which nothing can be left of it [1]


def run_of(triad: RunTriad, triads: Sequence[RunTriad], procedure: Procedure) -> AnyRun:
    """Return what mistakes are looked for in."""
    beside = by_norm(triads)
    if isinstance(triad.scheme, RotationScheme) and triad.turns and beside:
        return RotationRun(
            sensor=triad.sensor,
            beside=beside.sensor,
            procedure=procedure,
            norm=cast("NormScheme", beside.scheme),
            held=triad.scheme.held,
            turns=triad.turns,
            found=triad.found,
        )
    if isinstance(triad.scheme, NormScheme):
        return NormRun.of(
            triad.sensor,
            procedure,
            triad.scheme,
            triad.scaled,
            numbers=triad.numbers,
            is_scaled=not triad.has_counts,
            rounding=triad.rounding,
        )
    return TriadRun.of(
        triad.sensor,
        procedure,
        triad.scheme.schedule,
        triad.scaled,
        triad.numbers,
        is_scaled=not triad.has_counts,
        orders=orders_of(triad.kind, procedure),
        rounding=triad.rounding,
    )


def chi_square(kind: str, one: ChiSquare) -> RunChiSquare:
    """Return a chi-square as a row."""
    nu = one.degrees_of_freedom
    return RunChiSquare(sensor=kind, value=one.value, degrees_of_freedom=nu, p=one.p)


def suspicion(kind: str, run: AnyRun) -> Suspicion | None:
    """Return what a triad's run looks like; None where no known mistake fits."""
    found = run.looks_like
    if found is None:
        return None
    return Suspicion(
        mistake=MistakeRow.of(kind, found.mistake),
        evidence=found.evidence,
        also=tuple(MistakeRow.of(kind, one) for one in found.also),
    )


def unseen_of(kind: str, run: AnyRun) -> Iterator[UnseenMistake]:
    """Yield the kinds of mistakes that may be missed, with the windows of each."""
    groups: dict[str, list[Mistake]] = {}
    for one in run.known:
        groups.setdefault(one.name, []).append(one)
    for name, every in groups.items():
        # Two windows of equal inputs may be exchanged without harm.
        own = [one for one in every if name != "windows_order" or run.is_seen(one)]
        seen = [run.shown(one) if run.is_seen(one) else 0.0 for one in own]
        missed = [one for one, p in zip(own, seen, strict=True) if p < SHOWN]
        if missed:
            yield UnseenMistake(
                name=name,
                sensor=kind,
                probability=min(seen),
                windows=tuple(sorted({x for one in missed for x in one.numbers})),
            )


@dataclass(frozen=True, kw_only=True)
class UnseenMistakes:
    """What a run of a procedure with a device may not show, or why that is not told."""

    unseen: tuple[UnseenMistake, ...]
    why: str = ""


def unseen_mistakes(device: Device, procedure: Procedure) -> UnseenMistakes:
    """Tell before a run which known mistakes it may not show.

    By a run that reads what the nominal unit would.
    """
    found: list[UnseenMistake] = []
    try:
        for sensor in device.sensors:
            kind = sensor.kind
            if not calibrates(kind, procedure):
                continue
            if kind == GYRO and is_beside(procedure):
                run = _nominal_rotation(sensor, procedure)
                found += unseen_of(kind, run) if run else ()
                continue
            scheme = schemes_of([sensor], procedure)[kind]
            readings = _nominal(sensor, scheme)
            every = enumerate(windows_of(procedure))
            own = [k for k, one in every if one.use in {kind, "both"}]
            triad = run_triad(sensor, scheme, own, readings, is_counted=False)
            found += unseen_of(kind, run_of(triad, (), procedure))
    except BudgetError as error:
        return UnseenMistakes(unseen=(), why=str(error))
    return UnseenMistakes(unseen=tuple(found))


def _nominal(sensor: Sensor, scheme: Scheme) -> Array:
    """Return what the nominal unit would read in windows, (3, n) [SI]."""
    inputs = (scheme.turn + scheme.standing).T
    M = response(sensor.nominal_mounting_angle)
    return np.asarray(M @ inputs + sensor.nominal_bias[:, None])


def _nominal_rotation(gyro: Sensor, procedure: Procedure) -> RotationRun | None:
    """Return the turns of a procedure as the nominal gyro would read them."""
    if gyro.beside is None:
        return None
    schemes = schemes_of([gyro, gyro.beside], procedure)
    scheme = cast("RotationScheme", schemes[GYRO])
    norm = cast("NormScheme", schemes[gyro.beside.kind])
    windows, rates = scheme.schedule.windows, _nominal(gyro, scheme)
    still, turns = turns_of_rows(windows, rates)
    return RotationRun(
        sensor=gyro,
        beside=gyro.beside,
        procedure=procedure,
        norm=norm,
        held=scheme.held,
        turns=MeasuredTurns(
            dwells=tuple(windows[k] for k in still),
            down=norm.force / procedure.gravity,
            still=rates[:, still],
            turns=turns,
            earth=procedure.place.earth,
            knows_azimuth=procedure.place.azimuth is not None,
        ),
    )


def window_rows(
    triad: RunTriad, read: RecordedWindows, run: AnyRun | None
) -> Iterator[RunWindow]:
    """Yield the windows of a triad, with what is left of each."""
    kind, (unit, size) = triad.kind, triad.unit
    own_unit, own_size = BIAS_UNITS[kind]
    left = triad.residuals
    z = None if run is None else left / _residual_u(triad, run)
    own = read.health.get(kind)
    for k, number in enumerate(triad.numbers):
        window = read.windows[number - 1]
        health = None if own is None else own[number - 1]
        yield RunWindow(
            window=number,
            name=window.name,
            sensor=kind,
            start=window.start,
            length=window.length,
            unit=unit,
            mean=triad.readings[:, k] / size,
            residual=left[:, k] / own_size,
            residual_unit=own_unit,
            z=None if z is None else z[:, k],
            gaps=health.gaps if health else None,
            missing=health.missing if health else None,
            saturated=health.saturated if health else (),
            stuck=health.stuck if health else (),
            outliers=health.outliers if health else (),
            is_spoilt=health.is_spoilt if health else None,
        )


def turn_rows(triad: RunTriad, run: AnyRun | None) -> Iterator[RunTurn]:
    """Yield the turns that a gyro is found by, with what is left after each."""
    if triad.turns is None or not isinstance(run, RotationRun) or not triad.is_found:
        return
    for turn, left, u in zip(triad.turns.turns, *run.of_turns(), strict=True):
        rates = triad.found.shown(turn.rates)
        turned = float(np.linalg.norm(rates, axis=0) @ turn.lengths)
        yield RunTurn(
            first=turn.first + 1,
            last=turn.last + 1,
            start=turn.start,
            length=float(turn.lengths.sum()),
            turned=turned / size_of("deg"),
            residual=left / size_of("arcsec"),
            z=left / u,
        )


def _residual_u(triad: RunTriad, run: AnyRun) -> Array:
    """Return standard uncertainties of residuals, (3, n): of (1 - A W) C (1 - A W)'."""
    if isinstance(run, RotationRun):
        return run.residual_u()
    own = np.sqrt(np.diag(run.covariance))
    if isinstance(run, NormRun):
        J = run.sensitivity
        R = np.eye(len(J)) - J @ np.linalg.pinv(J)
        size = 2.0 * run.place.gravity
        found, noise = _root(R @ run.covariance @ R.T)[None] / size, own[None] / size
    else:
        n = triad.readings.shape[1]
        C = run.covariance.reshape(3, n, 3, n)
        each = enumerate(residual_weights(triad))
        found = np.array([_root(R @ C[axis, :, axis] @ R.T) for axis, R in each])
        noise = own.reshape(3, n)
    return np.asarray(np.where(found > TINY * noise, found, np.inf))


def _root(covariance: Array) -> Array:
    """Return standard uncertainties, of what rounding may have made negative too."""
    return np.asarray(np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def worst_windows(rows: Sequence[RunWindow], kinds: Sequence[str]) -> tuple[int, ...]:
    """Return the windows of triads that are farthest off, the farthest first."""
    sizes = [
        (float(np.abs(one.z).max()), one.window)
        for one in rows
        if one.sensor in kinds and one.z is not None
    ]
    found = dict.fromkeys(number for _, number in sorted(sizes, reverse=True))
    return tuple(found)[:WORST]
