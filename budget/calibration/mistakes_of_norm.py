"""Mistakes of a calibration by the norm of gravity, where no attitude is known.

A dwell's F = |s|^2 - g^2 of what the calibrated triad shows is 0 but for noise
(budget.model.norm). At the nominal values p0 it is F0 = F + J (p0 - p) with J the
sensitivity, of covariance V = C + J U0 J': as budget.calibration.mistakes has it of
readings. A reversal, an exchange or a rotation of axes leaves F as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mistakes import (
    GRAVITIES,
    SUSPECT,
    ChiSquare,
    LooksLike,
    Mistake,
    likeliest,
    of_axes,
    of_units,
    prior_of,
    root_of,
    rounded,
    seen_with,
)
from budget.calibration.schemes.covariance import joint_covariance
from budget.model.norm import sensitivity
from budget.model.response import BIAS, tilt_matrix
from budget.names import AXES
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.model.norm import NormScheme
    from budget.model.place import Place

CONVERGED = 1e-10  # of a gravity that is fitted [m/s^2]


@dataclass(frozen=True, kw_only=True, eq=False)
class NormRun:
    """Dwells of one triad at unknown attitudes, with what is known of them.

    Attributes
    ----------
    owner : str
        'accelerometer'.
    numbers : tuple of int
        Of each window among all of the procedure, from 1.
    place : Place
    sample_rate : float
        [Hz].
    squares : ndarray, shape (n,)
        |s|^2 of what the calibrated triad shows [m^2/s^4].
    covariance : ndarray, shape (n, n)
        Of these.
    sensitivity : ndarray, shape (n, m)
        Of F by the parameters that are estimated.
    spread : ndarray, shape (n, 12)
        Of F by all of them, times what each is known to before.
    off : ndarray, shape (m,)
        Values that were found less nominal ones [1, rad, m/s^2].
    scales : ndarray of int
        Which of them are scale factors.
    wide : int
        How many of them nothing is known of.
    """

    owner: str
    numbers: tuple[int, ...]
    place: Place
    sample_rate: float
    squares: Array
    covariance: Array = field(repr=False)
    sensitivity: Array = field(repr=False)
    spread: Array = field(repr=False)
    off: Array
    scales: NDArray[np.intp]
    wide: int

    @classmethod
    def of(
        cls,
        sensor: Sensor,
        procedure: Procedure,
        scheme: NormScheme,
        readings: Array,
        *,
        numbers: Sequence[int],
        is_scaled: bool = True,
        rounding: Array | None = None,
    ) -> NormRun:
        """Put together what a device and a procedure say of readings, (3, n).

        With the variance that their steps add to each, (3,).
        """
        found = scheme.estimate(readings)
        M = np.eye(3) + tilt_matrix(found.mounting_angle)
        inner = readings / found.scale_factor[:, None] - found.bias[:, None]
        shown = np.linalg.solve(M, inner)  # s
        seen = 2.0 * np.linalg.solve(M.T, shown)  # of an error of y/K
        C = rounded(joint_covariance(sensor, procedure, scheme.schedule), rounding)
        n = shown.shape[1]
        blocks = C.reshape(3, n, 3, n)
        value = np.column_stack([M, found.bias])
        free = replace(scheme.held, which=np.zeros((3, 4), dtype=bool), value=value)
        whole = sensitivity(np.asarray(shown.T), free)
        estimated = scheme.held.estimated
        prior = prior_of(sensor, procedure.gravity, is_scaled=is_scaled)
        every = np.concatenate(
            [
                found.scale_factor - 1.0,
                found.mounting_angle - sensor.nominal_mounting_angle,
                found.bias - sensor.nominal_bias,
            ]
        )
        return cls(
            owner=sensor.kind,
            numbers=tuple(numbers),
            place=procedure.place,
            sample_rate=procedure.sample_rate,
            squares=(shown**2).sum(axis=0),
            covariance=np.einsum("aw,awbv,bv->wv", seen, blocks, seen),
            sensitivity=whole[:, estimated],
            spread=whole * prior.u,
            off=every[estimated],
            scales=np.flatnonzero(estimated < BIAS),
            wide=int((~prior.is_known[estimated]).sum()),
        )

    @cached_property
    def root(self) -> Array:
        """Cholesky root of the covariance."""
        return root_of(self.covariance, self.owner)

    @cached_property
    def whole_root(self) -> Array:
        """Cholesky root of V."""
        return root_of(self.covariance + self.spread @ self.spread.T, self.owner)

    def _at_nominal(self, gravity: float, off: Array) -> Array:
        """Return F of the nominal values, over the root of V."""
        F = self.squares - gravity**2 - self.sensitivity @ off
        return np.asarray(np.linalg.solve(self.whole_root, F))

    def _off(self, mistake: Mistake) -> Array:
        """Return what is found less the nominal values, of true readings."""
        off = self.off.copy()
        off[self.scales] = (1.0 + off[self.scales]) / mistake.factor - 1.0
        return off

    def _gravity(self, mistake: Mistake) -> float:
        """Return the gravity that it really was."""
        return (mistake.place or self.place).gravity

    @cached_property
    def residual(self) -> ChiSquare:
        """What least squares leaves of F, weighed by its covariance."""
        F = self.squares - self.place.gravity**2
        z = np.linalg.solve(self.root, F)
        B = np.linalg.solve(self.root, self.sensitivity)
        size = np.linalg.norm(B, axis=0)
        found, _, rank, _ = np.linalg.lstsq(B / size, z)
        left = z - (B / size) @ found
        return ChiSquare(value=float(left @ left), degrees_of_freedom=len(z) - rank)

    @cached_property
    def prior(self) -> ChiSquare:
        """What F of the nominal values is off 0."""
        return self._left(Mistake(name=""))

    def _left(self, mistake: Mistake) -> ChiSquare:
        """Return the same with a mistake."""
        z = self._at_nominal(self._gravity(mistake), self._off(mistake))
        nu = len(z) - self.wide - mistake.is_free
        return ChiSquare(value=float(z @ z), degrees_of_freedom=nu)

    def fit(self, mistake: Mistake) -> tuple[float, float]:
        """Return -2 ln L with a mistake, less what all have in common, and its p."""
        n, left = len(self.squares), self._left(mistake)
        own = 2.0 * n * log(abs(mistake.factor))
        cost = log(n) if mistake.is_free else 0.0
        return left.value + own + cost, left.p

    @cached_property
    def is_sound(self) -> bool:
        """Whether nothing in it is less likely than it may be."""
        return min(self.residual.p, self.prior.p) >= SUSPECT

    @cached_property
    def known(self) -> tuple[Mistake, ...]:
        """Mistakes that are known of it, those of a size apart."""
        standard = replace(self.place, gravity=STANDARD_GRAVITY)
        return (
            Mistake(
                name="gravity", what=(("value", STANDARD_GRAVITY),), place=standard
            ),
            *of_units(self.owner, self.sample_rate),
            *of_axes(),
        )

    def is_seen(self, mistake: Mistake) -> bool:
        """Whether it changes anything."""
        is_same = self._gravity(mistake) == self.place.gravity
        return mistake.factor != 1.0 or not is_same

    def shown(self, mistake: Mistake) -> float:
        """Return the probability that a run with a mistake is not found sound [1]."""
        shift = np.zeros_like(self.squares)
        if mistake.factor != 1.0:
            own = np.zeros_like(self.off)
            own[self.scales] = mistake.factor - 1.0
            shift -= self.sensitivity @ own
        shift += self._gravity(mistake) ** 2 - self.place.gravity**2
        z = np.linalg.solve(self.whole_root, shift)
        return seen_with(float(z @ z), self.prior.degrees_of_freedom)

    @cached_property
    def looks_like(self) -> LooksLike | None:
        """What it looks like if it is not sound; None where no known mistake fits."""
        from scipy.optimize import minimize_scalar

        if self.is_sound:
            return None
        sound, _ = self.fit(Mistake(name=""))

        def of(gravity: float) -> Mistake:
            return Mistake(
                name="gravity",
                what=(("value", gravity),),
                place=replace(self.place, gravity=gravity),
                is_free=True,
            )

        best = minimize_scalar(
            lambda x: self.fit(of(float(x)))[0],
            bounds=GRAVITIES,
            method="bounded",
            options={"xatol": CONVERGED},
        )
        every = [*filter(self.is_seen, self.known), of(float(best.x))]
        found = [(*self.fit(one), one) for one in every]
        return likeliest(sound, [*found, *self._moved(sound)])

    def _moved(self, sound: float) -> list[tuple[float, float, Mistake]]:
        """Return -2 ln L and p of one dwell that is off, for each of them."""
        z = self._at_nominal(self.place.gravity, self.off)
        back = np.linalg.inv(self.whole_root)
        off, own = back.T @ z, (back**2).sum(axis=0)
        found = []
        for number, value, size in zip(
            self.numbers, off.tolist(), own.tolist(), strict=True
        ):
            gain = value**2 / size
            left = ChiSquare(
                value=self.prior.value - gain,
                degrees_of_freedom=self.prior.degrees_of_freedom - 1,
            )
            what = (
                ("window", number),
                ("axis", "".join(AXES)),
                ("value", value / size / (2.0 * self.place.gravity)),
            )
            mistake = Mistake(
                name="window_motion", what=what, added=(0, 0), is_free=True
            )
            found.append((sound - gain + log(len(z)), left.p, mistake))
        return found
