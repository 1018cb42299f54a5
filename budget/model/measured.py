"""Turns by hand as a gyro has measured them, between dwells of measured directions.

Between two dwells the attitude is followed sample by sample, C' = exp(-[w t]x) C with
w what the gyro shows less the earth rate there; at a dwell it is leaned to where the
calibrated accelerometers see down. Heading is that of the first dwell and what the
gyro has followed since; where nobody knows that of the first, the horizontal earth rate
is found with the parameters, as two more. For the weights samples are joined to steps
of 15 deg at the most, each the rotation vector of its samples' product: what its axis
does within a step is in the angle, and no error of the estimate, which is of the
samples themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import asin, atan2, cos, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.norm import shown_of_errors
from budget.model.response import BIAS, COLUMN, ROW, SIGN, CalibratedTriad
from budget.model.rotation import (
    RotationLeg,
    mean_rotation,
    rotation,
    sensitivities,
)
from budget.model.windows import INNER, POINTS, STEP, Setting, Window
from budget.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.model.scheme import Held

LEAST = 1e-12  # angle of a step, so that it is none of a dwell [rad]
STEPS = 30  # of Gauss and Newton at the most; 6 where the nominal values are near
DONE = 1e-12  # part of a parameter that the last step changes [1]
FAR = 1.0  # change of a parameter beyond which it is no solution [1]
MOST_TURNED = 1e4  # of a move that is a row of a table [rad]
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class FreeSetting(Setting):
    """An attitude by its angles, and a turn about any axis of the body from there.

    Attributes
    ----------
    about : tuple of float
        Axis of the turn in body axes; zeros of a dwell [1].
    """

    about: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def first(self) -> Array:
        """Matrix from east-north-up to body axes where the turn begins, (3, 3)."""
        return self.table.to_body

    def after(self, angle: float) -> Setting:
        """Return how it stands when it has turned by an angle [rad]."""
        there = _standing(rotation(-angle * np.array(self.about)) @ self.first)
        return replace(there, about=self.about)

    @property
    def to_body(self) -> Array:
        """Mean over the turn."""
        return np.asarray(
            mean_rotation(-self.angle * np.array(self.about)) @ self.first
        )

    @property
    def around(self) -> Array:
        """At POINTS angles spread evenly over a whole turn, (POINTS, 3, 3)."""
        steps = 2.0 * np.pi / POINTS * np.arange(POINTS)
        return np.asarray(rotation(-steps[:, None] * np.array(self.about)) @ self.first)

    @property
    def turn_axis(self) -> Array:
        """Axis of the turn in body axes, shape (3,)."""
        return np.array(self.about)

    def turn_axis_after(self, number: int) -> Array:
        """Axis of the turn in the body; no axis of a table turns."""
        return self.turn_axis if number == len(self.angles) else np.zeros(3)

    def between(self, first: int, last: int) -> Array:
        """Matrix between frames of the table: all of the turn is the body's."""
        if last < len(self.angles):
            return self.table.between(first, last)
        return np.asarray(
            mean_rotation(-self.angle * np.array(self.about))
            @ self.table.between(first, last)
        )

    @property
    def table(self) -> Setting:
        """The attitude as a table would hold it."""
        return Setting(outer=self.outer, middle=self.middle, inner=self.inner)


def _standing(to_body: Array) -> FreeSetting:
    """Return an attitude by the angles of a table: outer, middle, inner."""
    # to_body = X'(inner) Y'(middle) Z'(outer); up is (-sin m, sin i cos m, cos i cos m)
    up = to_body[:, 2]
    middle = asin(float(np.clip(-up[0], -1.0, 1.0)))
    inner = atan2(float(up[1]), float(up[2])) if np.hypot(up[1], up[2]) > LEAST else 0.0
    rest = Setting(middle=middle, inner=inner).to_body.T @ to_body
    return FreeSetting(
        outer=atan2(float(rest[0, 1]), float(rest[0, 0])), middle=middle, inner=inner
    )


def leaned(to_body: Array, down: Array) -> Array:
    """Return an attitude turned by the least angle so that up is at `down`, (3,)."""
    up = to_body @ UP
    axis = np.cross(up, down)
    size, along = float(np.linalg.norm(axis)), float(up @ down)
    if size < LEAST:
        if along > 0.0:
            return to_body
        axis, size = np.cross(up, np.eye(3)[int(np.abs(up).argmin())]), 0.0
    angle = atan2(size, along)
    return np.asarray(rotation(axis / np.linalg.norm(axis) * angle) @ to_body)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTurn:
    """Samples of the gyro from one dwell to another.

    Attributes
    ----------
    first, last : int
        Places of the dwells.
    start : float
        [s].
    lengths : ndarray, shape (n,)
        Of each sample, or of each turn about an axis that stays [s].
    rates : ndarray, shape (3, n)
        Means over these [rad/s].
    """

    first: int
    last: int
    start: float
    lengths: Array
    rates: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _TracedStep:
    """A dwell, a step of a turn, or where a turn has led to.

    Attributes
    ----------
    attitude : ndarray, shape (3, 3)
        From east-north-up to body axes, before it.
    start, length : float
        [s].
    vector : ndarray, shape (3,)
        Turn of the body [rad].
    is_more : bool
        Whether it is of the mean reading that the step before it is of.
    leg : MeasuredTurn or None
        The turn that has led here.
    """

    attitude: Array
    start: float
    length: float = 0.0
    vector: Array = field(default_factory=lambda: np.zeros(3))
    is_more: bool = False
    leg: MeasuredTurn | None = None

    @property
    def is_dwell(self) -> bool:
        """Whether it is none of a turn."""
        return self.leg is None and self.length == 0.0

    def window(self, name: str) -> Window:
        """Return a step as a window."""
        angle = float(np.linalg.norm(self.vector))
        about = (self.vector / angle if angle else UP).tolist()
        return Window(
            name=name,
            start=self.start,
            length=self.length,
            setting=replace(
                _standing(self.attitude),
                turning=INNER,
                angle=max(angle, LEAST),
                about=tuple(about),
            ),
            use="gyro",
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class FollowedTurns:
    """Turns followed with the parameters of a gyro.

    Attributes
    ----------
    dwells : tuple of Window
        At nominal attitudes.
    steps : tuple of _TracedStep
        Dwells and steps in the order of time.
    legs : tuple of RotationLeg
        By places among these.
    misfit : ndarray, shape (rows,)
        F [rad].
    by_rate, by_direction : ndarray
        As `sensitivities` has them.
    slope : ndarray, shape (rows, 12)
        J, of F by errors of parameters.
    level : ndarray, shape (rows, 2), or (rows, 0)
        The same of F by the earth rate to east and north that nobody knows [s].
    """

    dwells: tuple[Window, ...]
    steps: tuple[_TracedStep, ...]
    legs: tuple[RotationLeg, ...]
    misfit: Array
    by_rate: Array
    by_direction: Array
    slope: Array
    level: Array

    @property
    def windows(self) -> tuple[Window, ...]:
        """Dwells and steps in the order of time, at measured attitudes."""
        return self._windows(self.steps)

    @cached_property
    def of_means(self) -> tuple[tuple[Window, ...], Array]:
        """Windows that have one mean reading each, and the derivatives by these.

        The noise of a mean is one for all parts of its turn: shape (rows, n, 3) [s].
        """
        starts = [k for k, one in enumerate(self.steps) if not one.is_more]
        ends = [*starts[1:], len(self.steps)]
        means = [
            replace(
                self.steps[a],
                length=sum(one.length for one in self.steps[a:b]),
                vector=np.sum([one.vector for one in self.steps[a:b]], axis=0),
            )
            for a, b in zip(starts, ends, strict=True)
        ]
        return self._windows(means), np.add.reduceat(self.by_rate, starts, axis=1)

    def _windows(self, steps: Sequence[_TracedStep]) -> tuple[Window, ...]:
        """Return dwells and steps as windows."""
        found: list[Window] = []
        dwells, number = iter(self.dwells), 0
        for one in steps:
            if one.is_dwell:
                dwell, number = next(dwells), 0
                setting = _standing(one.attitude)
                found.append(replace(dwell, setting=setting, use="both"))
            else:
                number += 1
                found.append(one.window(f"{dwell.name} on, {number}"))
        return tuple(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTurns:
    """What a gyro has read in dwells at unknown attitudes and from one to the next.

    Attributes
    ----------
    dwells : tuple of Window
        With start and length as they were; their attitudes are nominal.
    down : ndarray, shape (n, 3)
        Directions of the specific force in the dwells, of calibrated accelerometers.
    still : ndarray, shape (3, n)
        Mean rates of the dwells [rad/s].
    turns : tuple of MeasuredTurn
    earth : ndarray, shape (3,)
        Earth rate that is known, or has been found, east-north-up [rad/s].
    knows_azimuth : bool
        Whether the horizontal part is known.
    """

    dwells: tuple[Window, ...]
    down: Array
    still: Array
    turns: tuple[MeasuredTurn, ...]
    earth: Array
    knows_azimuth: bool = True

    @cached_property
    def lengths(self) -> Array:
        """Of the dwells [s]."""
        return np.array([one.length for one in self.dwells])

    def _trace(self, found: CalibratedTriad) -> Iterator[_TracedStep]:
        """Yield dwells and what is between them, each with how it stands before it."""
        by_first = {one.first: one for one in self.turns}
        last = len(self.dwells) - 1
        C = leaned(self.dwells[0].setting.to_body, self.down[0])
        for k in range(len(self.dwells)):
            yield _TracedStep(attitude=C, start=self.dwells[k].start)
            turn = by_first.get(k)
            if turn is not None:
                start = turn.start
                own = found.shown(turn.rates).T
                parts = _steps(own, turn.lengths, C, self.earth)
                for length, product, is_more in parts:
                    yield _TracedStep(
                        attitude=C,
                        start=start,
                        length=length,
                        vector=_vector(product),
                        is_more=is_more,
                    )
                    start += length
                    C = product @ C
                yield _TracedStep(attitude=C, start=start, leg=turn)
                C = leaned(C, self.down[turn.last])
            elif k < last:
                C = leaned(self.dwells[k + 1].setting.to_body, self.down[k + 1])

    def misfit(self, found: CalibratedTriad) -> Array:
        """Return F of parameters of the gyro, (12,): (3 turns + 3 dwells,) [rad]."""
        return self._misfit(found, tuple(self._trace(found)))

    def _misfit(self, found: CalibratedTriad, parts: Sequence[_TracedStep]) -> Array:
        """Return the same of parts."""
        legs = [self.down[one.leg.last] - one.attitude @ UP for one in parts if one.leg]
        standing = np.array([one.attitude for one in parts if one.is_dwell])
        off = found.shown(self.still).T - standing @ self.earth
        return np.concatenate([*legs, *(off * self.lengths[:, None])])

    def follow(self, found: CalibratedTriad) -> FollowedTurns:
        """Follow the turns by the parameters of the gyro, (12,)."""
        parts = tuple(self._trace(found))
        steps: list[_TracedStep] = []
        legs: list[RotationLeg] = []
        first = 0  # step of the turn
        for one in parts:
            if one.leg:
                own = tuple(range(first, len(steps)))
                legs.append(
                    RotationLeg(first=one.leg.first, last=one.leg.last, steps=own)
                )
                continue
            steps.append(one)
            if one.is_dwell:
                first = len(steps)
        is_dwell = np.array([one.is_dwell for one in steps])
        vectors = np.array([one.vector for one in steps])
        lengths = np.array([one.length for one in steps])
        lengths[is_dwell] = self.lengths
        attitudes = np.array([one.attitude for one in steps])
        rates = vectors / lengths[:, None]
        means = mean_rotation(-vectors) @ attitudes
        rates += means @ self.earth
        rates[is_dwell] = found.shown(self.still).T
        by_rate, by_direction = sensitivities(lengths, vectors, self.down, tuple(legs))
        value = np.column_stack([found.response, found.bias])
        slope = np.einsum("rwi,wip->rp", by_rate, shown_of_errors(rates, value))
        unknown = means[..., : 0 if self.knows_azimuth else 2]
        return FollowedTurns(
            dwells=self.dwells,
            steps=tuple(steps),
            legs=tuple(legs),
            misfit=self._misfit(found, parts),
            by_rate=by_rate,
            by_direction=by_direction,
            slope=slope,
            level=np.einsum("rwi,wij->rj", by_rate, unknown),
        )

    def solve(self, held: Held) -> tuple[MeasuredTurns, CalibratedTriad, bool]:
        """Return the least squares of F from the nominal values, and whether found.

        Before them the same turns with the earth rate that is found. Steps of Gauss and
        Newton, with the attitudes followed anew in each.
        """
        p = nominal_of(held)
        first = triad_of(p)
        places = held.estimated
        turns, longest = self, self.lengths.max()
        size = np.where(places < 9, 1.0, 1.0 / longest)  # noqa: PLR2004
        for _ in range(STEPS):
            now = turns.follow(triad_of(p))
            J = np.hstack([now.slope[:, places] * size, now.level / longest])
            found = np.linalg.lstsq(J, now.misfit)[0]
            level = found[len(places) :] / longest
            turns = replace(
                turns, earth=turns.earth + np.pad(level, (0, 3 - len(level)))
            )
            step = np.zeros(12)
            step[places] = size * found[: len(places)]
            step[:3] *= p[:3]
            p = p - step
            if not np.isfinite(p).all() or (np.abs(p[:3] - 1.0) > FAR).any():
                return self, first, False
            if (np.abs(step[places]) <= DONE * np.maximum(size, DEG_PER_HOUR)).all():
                return turns, triad_of(p), True
        is_found = bool((np.abs(step[places]) <= 1e-6 * size).all())
        return turns, triad_of(p), is_found

    def scaled(self, undone: Array) -> MeasuredTurns:
        """Return the same with readings multiplied by a matrix, (3, 3)."""
        turns = tuple(replace(one, rates=undone @ one.rates) for one in self.turns)
        return replace(self, still=undone @ self.still, turns=turns)


def nominal_of(held: Held) -> Array:
    """Return the nominal parameters, (12,): K 1, angles, biases."""
    value = held.value
    return np.concatenate([np.ones(3), SIGN * value[ROW, COLUMN], value[:, BIAS]])


def triad_of(p: Array) -> CalibratedTriad:
    """Return parameters (12,) as those of a triad."""
    return CalibratedTriad(scale_factor=p[:3], mounting_angle=p[3:9], bias=p[9:])


def _steps(
    rates: Array, lengths: Array, C: Array, earth: Array
) -> Iterator[tuple[float, Array, bool]]:
    """Yield length and product, (3, 3), of parts of a turn, none over STEP.

    And whether a part is of the same mean reading as the one before it. Of a turn about
    an axis that stays the earth rate is taken off as its mean is, by the way that it
    takes through the body.
    """
    length, angle, product, is_more = 0.0, 0.0, np.eye(3), False
    sizes = np.linalg.norm(rates, axis=1) * lengths
    parts = np.maximum(1, np.ceil(sizes / STEP)).astype(int)
    for rate, whole, size, n in zip(
        rates, lengths.tolist(), (sizes / parts).tolist(), parts.tolist(), strict=True
    ):
        mean = mean_rotation(-rate * whole) if n > 1 else np.eye(3)
        own = (rate - mean @ C @ earth) * (whole / n)
        R = _small_rotation(-own)
        for part in range(n):
            if length and (n > 1 or angle + size > STEP):
                yield length, product, is_more
                length, angle, product = 0.0, 0.0, np.eye(3)
            is_more = part > 0
            product, C = R @ product, R @ C
            length, angle = length + whole / n, angle + size
        if n > 1:
            yield length, product, is_more
            length, angle, product, is_more = 0.0, 0.0, np.eye(3), False
    if length:
        yield length, product, is_more


def _small_rotation(v: Array) -> Array:
    """Return exp([v]x), (3, 3), of one vector: Rodrigues."""
    x, y, z = v.tolist()
    a2 = x * x + y * y + z * z
    if a2 < 1e-16:  # noqa: PLR2004 - its square is rounding
        s, c = 1.0, 0.5
    else:
        a = a2**0.5
        s, c = sin(a) / a, (1.0 - cos(a)) / a2
    return np.array(
        [
            [1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
            [c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x],
            [c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)],
        ]
    )


def _vector(product: Array) -> Array:
    """Return the turn of the body, (3,) [rad], of exp(-[v]x), below half a turn."""
    twice = np.array(
        [
            product[1, 2] - product[2, 1],
            product[2, 0] - product[0, 2],
            product[0, 1] - product[1, 0],
        ]
    )
    size = float(np.linalg.norm(twice)) / 2.0
    angle = atan2(size, (float(np.trace(product)) - 1.0) / 2.0)
    return np.asarray(twice / 2.0 * (angle / size if size > LEAST else 1.0))


def turns_of_rows(
    windows: Sequence[Window], rates: Array
) -> tuple[list[int], tuple[MeasuredTurn, ...]]:
    """Return the places of dwells, and what is between them by mean rates, (3, n).

    A mean rate is that about an axis which stays as it is; without one there is no
    turn.

    Raises
    ------
    CallError
        A turn is of more than MOST_TURNED.
    """
    still = [k for k, one in enumerate(windows) if not one.sense]
    found = []
    for number, (a, b) in enumerate(pairwise(still)):
        own = rates[:, a + 1 : b]
        lengths = np.array([one.length for one in windows[a + 1 : b]])
        if not own.size or not np.isfinite(own).all():
            continue
        angles = np.linalg.norm(own, axis=0) * lengths
        if (angles > MOST_TURNED).any():
            k = a + 1 + int(angles.argmax())
            raise CallError(
                f"window {k + 1} ({windows[k].name}) turns by {angles.max():.3g} rad, "
                f"expected {MOST_TURNED:g} at the most; is its unit the right one?"
            )
        found.append(
            MeasuredTurn(
                first=number,
                last=number + 1,
                start=windows[a + 1].start,
                lengths=lengths,
                rates=own,
            )
        )
    return still, tuple(found)
