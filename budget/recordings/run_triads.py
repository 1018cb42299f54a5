"""Triads of a recorded run, each with the values that its readings give."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mistakes import prior_of
from budget.calibration.schemes import calibrates, held_of, schemes_of
from budget.errors import CallError
from budget.inputs.records import Sensor
from budget.model.measured import MeasuredTurns
from budget.model.norm import NormScheme
from budget.model.source import GYRO, SENSORS
from budget.names import AXES
from budget.recordings.columns import COUNTS, LIKE
from budget.sentences import sentence
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Device, Procedure
    from budget.model.response import CalibratedTriad
    from budget.model.scheme import Scheme
    from budget.recordings.window_table import RecordedWindows


@dataclass(frozen=True, kw_only=True, eq=False)
class RunTriad:
    """One triad of a run.

    Attributes
    ----------
    sensor : Sensor
    scheme : Scheme
    numbers : tuple of int
        Of its windows in the procedure, from 1.
    readings : ndarray, shape (3, n)
        Means [SI or counts].
    scale, zero : ndarray, shape (3,)
        What readings are taken over and from, so that their scale factors are near 1.
    found : CalibratedTriad
        Of readings so scaled.
    has_counts : bool
    turns : MeasuredTurns or None
        Of a gyro that is found by them; its windows are dwells.
    is_found : bool
        Whether they fit any values; else those are nominal, and not given out.
    rounding : ndarray, shape (3,), or None
        Variance of what steps of the readings put into a scaled mean; None where they
        are fine or not known, or of a gyro that is found by turns.
    """

    sensor: Sensor
    scheme: Scheme
    numbers: tuple[int, ...]
    readings: Array
    scale: Array
    zero: Array
    found: CalibratedTriad
    has_counts: bool
    turns: MeasuredTurns | None = None
    is_found: bool = True
    rounding: Array | None = None

    @property
    def kind(self) -> str:
        """Of its sensor."""
        return self.sensor.kind

    @property
    def unit(self) -> tuple[str, float]:
        """Of readings, with its size: counts, or that of the input."""
        like = LIKE[self.kind]
        return (COUNTS, 1.0) if self.has_counts else (like, size_of(like))

    @property
    def unit_of_scale(self) -> tuple[str, float]:
        """Of readings over inputs, with what it is times of that in SI."""
        like = LIKE[self.kind]
        return (f"{COUNTS}/({like})", size_of(like)) if self.has_counts else ("1", 1.0)

    @property
    def inputs(self) -> Array:
        """Mean inputs of the windows as planned, (n, 3) [SI]."""
        return self.scheme.turn + self.scheme.standing

    @property
    def shown(self) -> Array:
        """Inputs that the readings show, (3, n) [SI]."""
        return self.found.shown(self.scaled)

    @property
    def scaled(self) -> Array:
        """Readings over their scale, (3, n) [unit of the input]."""
        return np.asarray((self.readings - self.zero[:, None]) / self.scale[:, None])

    @property
    def scale_factor(self) -> Array:
        """K of readings over the input, (3,) [1, or counts per unit of the input]."""
        return np.asarray(self.scale * self.found.scale_factor)

    @property
    def is_left_handed(self) -> bool:
        """Whether S = K M turns a right-handed triad of inputs into a left-handed."""
        size = np.linalg.det(self.found.response)
        return float(np.prod(self.scale_factor) * size) < 0.0

    @property
    def bias(self) -> Array:
        """B of K (M u + b), (3,) [unit of the input]."""
        return np.asarray(self.found.bias + self.zero / self.scale_factor)

    @property
    def values(self) -> Array:
        """Parameters in the order of names: k or K, angles, biases, higher orders."""
        own = self.scale_factor if self.has_counts else self.scale_factor - 1.0
        return replace(self.found, scale_factor=own, bias=self.bias).vector

    @property
    def nominal(self) -> Array:
        """What the design has of them; nan of the scale factors of counts."""
        found = np.full(len(self.values), np.nan)
        found[3:9] = self.sensor.nominal_mounting_angle
        if not self.has_counts:  # nobody knows where these begin
            found[:3], found[9:12] = 0.0, self.sensor.nominal_bias
        return found

    @property
    def prior(self) -> Array:
        """Standard uncertainties before, by the data sheet; nan of what it has not."""
        found = np.full(len(self.values), np.nan)
        largest = float(np.abs(self.inputs).max())
        own = prior_of(self.sensor, largest, is_scaled=not self.has_counts)
        found[:12] = np.where(own.is_known, own.u, np.nan)
        return found

    @property
    def residuals(self) -> Array:
        """Readings less those of what was found, (3, n) [unit of the input].

        By the norm of gravity, of what the calibrated triad shows along its length.
        """
        K, b = self.found.scale_factor[:, None], self.found.bias[:, None]
        if isinstance(self.scheme, NormScheme):
            g = float(np.linalg.norm(self.scheme.gravity))
            return np.asarray(np.linalg.norm(self.shown, axis=0)[None] - g)
        if self.turns is not None:
            left = self.turns.misfit(self.found)[-self.readings.size :]
            return np.asarray(left.reshape(-1, 3).T / self.turns.lengths)
        true = self.found.response @ self.inputs.T + b
        if self.scheme.orders and self.found.higher is not None:
            K_p = self.found.higher.reshape(-1, 3)
            true = true + np.einsum("inm,mi->in", self.scheme.powers, K_p)
        return np.asarray(self.scaled / K - true)


def run_triads(
    read: RecordedWindows, procedure: Procedure, unit: Device | None
) -> Iterator[RunTriad]:
    """Yield the triads that were recorded, calibrated.

    Raises
    ------
    CallError
        A window has no reading, or the gyro is found by what is between windows.
    """
    there = {one.kind: one for one in (unit.sensors if unit else ())}
    for kind in SENSORS:
        if kind not in read.means or not calibrates(kind, procedure):
            continue
        if unit is not None and kind not in there:
            continue
        sensor = there.get(kind) or Sensor.bare(kind)
        own = [k for k, one in enumerate(read.windows) if one.use in {kind, "both"}]
        readings = read.means[kind][:, own]
        if not np.isfinite(readings).all():
            axis, k = np.argwhere(~np.isfinite(readings))[0]
            raise CallError(
                f"{read.name}: window {own[k] + 1} ({read.windows[own[k]].name}) has "
                f"no reading of {kind}_{'xyz'[axis]}, which the procedure uses; give "
                f"it, or let the window be of the other triad alone (use)"
            )
        scheme = schemes_of([sensor], procedure)[kind]
        _check_connected(f"{read.name}: {kind}", readings)
        found = run_triad(
            sensor, scheme, own, readings, is_counted=read.has_counts[kind]
        )
        steps = read.steps.get(kind, ())
        if any(one.is_coarse for one in steps):
            u = np.array([one.u for one in steps]) / found.scale
            found = replace(found, rounding=u**2)
        yield found


def _check_connected(name: str, readings: Array) -> None:
    """Refuse a channel that reads the same all the time, (3, n)."""
    still = np.flatnonzero(np.ptp(readings, axis=1) == 0.0)
    if len(still):
        channel = f"{name}_{AXES[still[0]]}"
        raise CallError(sentence("calibrations.dead", channel=channel))


def run_triad(
    sensor: Sensor,
    scheme: Scheme,
    own: Sequence[int],
    readings: Array,
    *,
    is_counted: bool,
) -> RunTriad:
    """Calibrate one triad."""
    scale, zero = np.ones(3), np.zeros(3)
    if is_counted:
        size = float(np.abs(scheme.turn + scheme.standing).max())
        low, high = readings.min(axis=1), readings.max(axis=1)
        scale, zero = (high - low) / (2.0 * size), (high + low) / 2.0
        if not isinstance(scheme, NormScheme):
            found = scheme.estimate((readings - zero[:, None]) / scale[:, None])
            scale = scale * found.scale_factor
    scaled = (readings - zero[:, None]) / scale[:, None]
    return RunTriad(
        sensor=sensor,
        scheme=scheme,
        numbers=tuple(k + 1 for k in own),
        readings=readings,
        scale=scale,
        zero=zero,
        found=scheme.estimate(scaled),
        has_counts=is_counted,
    )


def by_norm(triads: Iterable[RunTriad]) -> RunTriad | None:
    """Return the triad that the norm of gravity calibrates; None of none."""
    return next((one for one in triads if isinstance(one.scheme, NormScheme)), None)


def with_gyro(
    read: RecordedWindows,
    planned: Procedure,
    there: Procedure,
    unit: Device | None,
    triads: Sequence[RunTriad],
) -> tuple[Procedure, list[RunTriad]]:
    """Return a procedure with turns as they were, and triads with the gyro by them.

    Raises
    ------
    CallError
        There is no turn, nothing that they are held against, or they are too few.
    """
    norm = by_norm(triads)
    sensors = {one.kind: one for one in (unit.sensors if unit else ())}
    if norm is None or GYRO not in sensors:
        raise CallError(sentence("calibrations.needs_device"))
    if not read.turns and read.turns_left_out:
        raise CallError(sentence("calibrations.no_sound_turn"))
    if not read.turns:
        raise CallError(sentence("calibrations.no_moves"))
    if read.has_counts[GYRO]:
        raise CallError(sentence("calibrations.needs_gain"))
    held = held_of(GYRO, planned, sensors[GYRO])
    turns = MeasuredTurns(
        dwells=read.windows,
        down=(norm.shown / np.linalg.norm(norm.shown, axis=0)).T,
        still=read.means[GYRO],
        turns=read.turns,
        earth=there.place.earth,
        knows_azimuth=there.place.azimuth is not None,
    )
    if not np.isfinite(turns.still).all():
        raise CallError(sentence("calibrations.no_moves"))
    every = np.hstack([turns.still, *(one.rates for one in turns.turns)])
    _check_connected(GYRO, every)
    turns, found, is_found = turns.solve(held)
    there = replace(there, windows=turns.follow(found).windows)
    schemes = schemes_of([sensors[GYRO], norm.sensor], there)
    still = RunTriad(
        sensor=sensors[GYRO],
        scheme=schemes[GYRO],
        numbers=tuple(range(1, len(read.windows) + 1)),
        readings=turns.still,
        scale=np.ones(3),
        zero=np.zeros(3),
        found=found,
        has_counts=False,
        turns=turns,
        is_found=is_found,
    )
    return there, [still, replace(norm, scheme=schemes[norm.kind])]
