"""Mistakes of a gyro that is calibrated by its turns between dwells.

What the directions of gravity and the dwells leave, F (budget.model.rotation), is 0 but
for noise of the gyro and of the accelerometers, of covariance C; at the nominal values
p0 it is F0 = F + J (p0 - p), of covariance C + J U0 J' and what the others hold.
A leg's F lies across gravity: two of its three components count. A mistake is solved
anew, as it changes the attitudes that the turns are followed through.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mistakes import (
    EQUAL,
    SUSPECT,
    ChiSquare,
    LooksLike,
    Mistake,
    likeliest,
    moved_to,
    of_axes,
    of_units,
    prior_of,
    root_of,
    seen_with,
)
from budget.calibration.schemes.covariance import joint_covariance
from budget.model.measured import nominal_of, triad_of, turns_of_rows
from budget.model.norm import sensitivity, shown_of_errors
from budget.model.response import tilt_matrix
from budget.model.windows import Schedule, dwells_of

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.model.measured import FollowedTurns, MeasuredTurns
    from budget.model.norm import NormScheme
    from budget.model.place import Place
    from budget.model.response import CalibratedTriad
    from budget.model.scheme import Held

LIKELY = 8  # mistakes with the least misfit of nominal values, that are solved
CLOSE = 3  # mistakes with the least misfit, that are held against the covariance


@dataclass(frozen=True, kw_only=True, eq=False)
class _Solved:
    """F of the values found, whitened by nothing yet, with its covariance.

    Attributes
    ----------
    misfit : ndarray, shape (m,)
        F, of each leg across gravity [rad].
    slope : ndarray, shape (m, 12)
        J.
    level : ndarray, shape (m, 2), or (m, 0)
        The same of the earth rate that nobody knows [s].
    covariance : ndarray, shape (m, m)
    spread : ndarray, shape (m, k)
        Of F by parameters of both triads times what each is known to before.
    off : ndarray, shape (12,)
        Values found less nominal ones.
    """

    misfit: Array
    slope: Array
    level: Array
    covariance: Array
    spread: Array
    off: Array

    def fitted(self, held: Held) -> Array:
        """Return the columns of all that is found."""
        return np.hstack([self.slope[:, held.estimated], self.level])


@dataclass(frozen=True, kw_only=True, eq=False)
class RotationRun:
    """A gyro in dwells and turns between them, with what is known of it.

    Attributes
    ----------
    sensor, beside : Sensor
        The gyro, and the accelerometers.
    procedure : Procedure
        With dwells as they were.
    norm : NormScheme
        Of the accelerometers.
    held : Held
        Of the gyro.
    turns : MeasuredTurns
        With the earth rate that is found, where values are given.
    found : CalibratedTriad, optional
        What these give.
    """

    sensor: Sensor
    beside: Sensor
    procedure: Procedure
    norm: NormScheme
    held: Held
    turns: MeasuredTurns = field(repr=False)
    found: CalibratedTriad | None = None

    @property
    def place(self) -> Place:
        """Where it is."""
        return self.procedure.place

    @cached_property
    def _solved(self) -> _Solved:
        """What is left with the values that are found."""
        return self._put_together(*self._found, np.eye(3))

    @cached_property
    def _found(self) -> tuple[MeasuredTurns, CalibratedTriad]:
        """The values that are found, and before them turns with their earth rate."""
        if self.found is not None:
            return self.turns, self.found
        turns, found, _ = self.turns.solve(self.held)
        return turns, found

    def _turns(self, mistake: Mistake) -> MeasuredTurns:
        """Return the turns with a mistake undone."""
        place = mistake.place or self.place
        turns = replace(self.turns, down=self.turns.down @ _of_unit(mistake))
        undone = _mix(mistake).T / mistake.factor
        return replace(turns.scaled(undone), earth=place.earth)

    def _solve(self, mistake: Mistake) -> _Solved:
        """Return what is left with a mistake undone."""
        turns = self._turns(mistake)
        turns, found, _ = turns.solve(self.held)
        return self._put_together(turns, found, _of_unit(mistake))

    def _put_together(
        self, turns: MeasuredTurns, found: CalibratedTriad, mix: Array
    ) -> _Solved:
        """Return F of turns with its covariance, at values of the gyro.

        The accelerometers read their directions, (n, 3), by a mistake's `mix`.
        """
        now = turns.follow(found)
        windows, by_mean = now.of_means
        schedule = Schedule(windows=windows)
        n, n_a = len(windows), len(self.turns.dwells)
        M = np.eye(3) + tilt_matrix(found.mounting_angle)
        by_rate = np.asarray(by_mean @ np.linalg.inv(M))  # of y/K
        B = np.swapaxes(by_rate, 1, 2).reshape(-1, 3 * n)
        C = B @ joint_covariance(self.sensor, self.procedure, schedule) @ B.T
        dwells = Schedule(windows=tuple(dwells_of(windows)))
        own, kept = self._of_directions(now, mix)
        C_a = joint_covariance(self.beside, self.procedure, dwells)
        G = own.reshape(-1, 3 * n_a)
        C = C + G @ C_a @ G.T
        across = _across(turns)
        g = float(np.linalg.norm(self.norm.gravity))
        prior = prior_of(self.beside, g).u[self.norm.held.held]
        largest = max(float(np.abs(one.rates).max()) for one in self.turns.turns)
        before = prior_of(self.sensor, largest).u
        spread = np.hstack([now.slope * before, kept * prior])
        p = np.concatenate([found.scale_factor, found.mounting_angle, found.bias])
        return _Solved(
            misfit=across @ now.misfit,
            slope=across @ now.slope,
            level=across @ now.level,
            covariance=across @ C @ across.T,
            spread=across @ spread,
            off=p - nominal_of(self.held),
        )

    def _of_directions(self, now: FollowedTurns, mix: Array) -> tuple[Array, Array]:
        """Return dF/de of the accelerometers, (rows, 3, n_a), e of y/K; and by held.

        A direction is off by its own reading and by what all make of the values: ds =
        M^-1 e + S dp, dp = -W 2 f.(M^-1 e + S_h dh), of held dh besides S_h dh.
        """
        g = float(np.linalg.norm(self.norm.gravity))
        down, value = self.turns.down, self.norm.held.value
        n = len(down)
        back = np.linalg.inv(value[:, :3])
        shown = shown_of_errors(down * g, value)  # (n, 3, 12)
        J = sensitivity(down * g, self.norm.held)
        size = np.linalg.norm(J, axis=0)
        W = np.linalg.pinv(J / size) / size[:, None]
        dp = -2.0 * np.einsum("pw,wi->pwi", W, down * g @ back)  # (m, n, 3)
        ds = np.einsum("vip,pwj->viwj", shown[:, :, self.norm.held.estimated], dp)
        for k in range(n):
            ds[k, :, k] += back
        by_direction = now.by_direction @ mix.T  # of what is read
        own = np.einsum("rvi,viwj->rjw", by_direction, ds) / g
        held = shown[:, :, self.norm.held.held]
        by_held = -2.0 * W @ np.einsum("wi,wip->wp", down * g, held)
        held = held + shown[:, :, self.norm.held.estimated] @ by_held
        kept = np.einsum("rvi,vip->rp", by_direction, held) / g
        return own, kept

    # ---- is it sound -----------------------------------------------------------------

    @cached_property
    def residual(self) -> ChiSquare:
        """What least squares leaves of F, weighed by its covariance."""
        of = self._solved
        root = root_of(of.covariance, self.sensor.kind)
        z = np.linalg.solve(root, of.misfit)
        B = np.linalg.solve(root, of.fitted(self.held))
        size = np.linalg.norm(B, axis=0)
        found, _, rank, _ = np.linalg.lstsq(B / size, z)
        left = z - (B / size) @ found
        return ChiSquare(
            value=float(left @ left), degrees_of_freedom=len(z) - int(rank)
        )

    @cached_property
    def prior(self) -> ChiSquare:
        """What F of the nominal values is off 0."""
        return self._prior(self._solved)

    def _prior(self, of: _Solved) -> ChiSquare:
        """Return the same of any."""
        F = of.misfit - of.slope @ of.off
        V = of.covariance + of.spread @ of.spread.T
        z = np.linalg.solve(root_of(V, self.sensor.kind), F)
        known = prior_of(self.sensor, 1.0).is_known[self.held.estimated]
        return ChiSquare(
            value=float(z @ z),
            degrees_of_freedom=len(z) - int((~known).sum()) - of.level.shape[1],
        )

    @cached_property
    def _left_u(self) -> Array:
        """Standard uncertainties of what least squares leaves of F, (m,)."""
        of = self._solved
        J = of.fitted(self.held)
        size = np.linalg.norm(J, axis=0)
        R = np.eye(len(J)) - (J / size) @ np.linalg.pinv(J / size)
        return np.asarray(np.sqrt(np.maximum(np.diag(R @ of.covariance @ R.T), 0.0)))

    def residual_u(self) -> Array:
        """Return standard uncertainties of what is left in dwells, (3, n) [rad/s]."""
        n = len(self.turns.dwells)
        own = self._left_u[-3 * n :].reshape(n, 3).T
        return np.asarray(own / self.turns.lengths)

    def of_turns(self) -> tuple[Array, Array]:
        """Return what is left after each turn across gravity, and its u, (n, 2) [rad].

        Down as the gyro has it, less as the accelerometers see it, the other way.
        """
        n = 2 * len(self.turns.turns)
        left, u = (x[:n].reshape(-1, 2) for x in (self._solved.misfit, self._left_u))
        return left, u

    @cached_property
    def is_sound(self) -> bool:
        """Whether nothing in it is less likely than it may be."""
        return min(self.residual.p, self.prior.p) >= SUSPECT

    # ---- which mistake ---------------------------------------------------------------

    @cached_property
    def known(self) -> tuple[Mistake, ...]:
        """Mistakes that are known of it."""
        place = self.place
        return (
            Mistake(
                name="earth_rate_sign",
                place=replace(place, earth_rate=-place.earth_rate),
            ),
            Mistake(name="earth_rate_missing", place=replace(place, earth_rate=0.0)),
            Mistake(name="latitude_sign", place=moved_to(place, -place.latitude)),
            *of_axes(),
            *(replace(one, is_of_unit=True) for one in of_axes()),
            *of_units(self.sensor.kind, self.procedure.sample_rate),
        )

    def is_seen(self, mistake: Mistake) -> bool:
        """Whether it changes anything."""
        place = mistake.place
        is_same = place is None or np.array_equal(place.earth, self.place.earth)
        return bool(mistake.mix) or mistake.factor != 1.0 or not is_same

    @cached_property
    def _nominal(self) -> tuple[MeasuredTurns, Array, Array]:
        """What a nominal unit reads of these turns, the root of V, and its F."""
        there, found = self._found
        windows = there.follow(found).windows
        schedule, value = Schedule(windows=windows), self.held.value
        inputs = schedule.rates + schedule.to_body @ there.earth
        rates = value[:, :3] @ inputs.T + value[:, 3:]
        still, turns = turns_of_rows(windows, rates)
        own = replace(there, still=rates[:, still], turns=turns)
        nominal = triad_of(nominal_of(self.held))
        of = self._put_together(own, nominal, np.eye(3))
        V = of.covariance + of.spread @ of.spread.T
        return own, root_of(V, self.sensor.kind), of.misfit

    def shown(self, mistake: Mistake) -> float:
        """Return the probability that a run with a mistake is not found sound [1].

        Of one that reads what the nominal unit would.
        """
        turns, root, base = self._nominal
        turns = turns.scaled(_mix(mistake) * mistake.factor)
        turns = replace(turns, down=turns.down @ _of_unit(mistake).T)
        if mistake.place is not None:
            # What it reads of its true earth rate the procedure's does not take off.
            earth = turns.earth + self.place.earth - mistake.place.earth
            turns = replace(turns, earth=earth)
        misfit = turns.misfit(triad_of(nominal_of(self.held)))
        shift = _across(turns) @ misfit - base
        z = np.linalg.solve(root, shift)
        return seen_with(float(z @ z), self.prior.degrees_of_freedom)

    def fit(self, mistake: Mistake) -> tuple[float, float]:
        """Return -2 ln L with a mistake, less what all have in common, and its p."""
        of = self._solve(mistake)
        left = self._prior(of)
        return left.value + 2.0 * len(of.misfit) * log(abs(mistake.factor)), left.p

    @cached_property
    def looks_like(self) -> LooksLike | None:
        """What it looks like if it is not sound; None where no known mistake fits.

        Those of the least misfit at the nominal values are solved; of these the least
        are held against the covariance, with all that leave as little.
        """
        if self.is_sound:
            return None
        nominal = triad_of(nominal_of(self.held))

        def left(one: Mistake) -> float:
            return float(np.linalg.norm(self._turns(one).misfit(nominal)))

        likely = sorted(filter(self.is_seen, self.known), key=left)[:LIKELY]
        tried = []
        for one in likely:
            turns = self._turns(one)
            turns, found, is_found = turns.solve(self.held)
            if is_found:
                tried.append((float(np.linalg.norm(turns.misfit(found))), one))
        tried.sort(key=lambda each: each[0])
        most = max((size for size, _ in tried[:CLOSE]), default=0.0) * (1.0 + EQUAL)
        found_ = [(*self.fit(one), one) for size, one in tried if size <= most]
        return likeliest(self.prior.value, found_)


def _across(turns: MeasuredTurns) -> Array:
    """Return what takes of F of each leg two components across gravity."""
    legs, rest = len(turns.turns), 3 * len(turns.dwells)
    found = np.zeros((2 * legs + rest, 3 * legs + rest))
    for k, leg in enumerate(turns.turns):
        _, _, axes = np.linalg.svd(turns.down[leg.last][None])
        found[2 * k : 2 * k + 2, 3 * k : 3 * k + 3] = axes[1:]
    found[2 * legs :, 3 * legs :] = np.eye(rest)
    return found


def _mix(mistake: Mistake) -> Array:
    """Return readings of true axes, (3, 3)."""
    return np.array(mistake.mix) if mistake.mix else np.eye(3)


def _of_unit(mistake: Mistake) -> Array:
    """Return those of the accelerometers, where both triads have a mistake."""
    return _mix(mistake) if mistake.is_of_unit else np.eye(3)
