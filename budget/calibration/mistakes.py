"""Mistakes of a recorded calibration: what each makes of it, and which one fits.

A window's reading of axis i over its scale factor is (M u)_i + b_i + e_i, linear in
the 12 statistics (K M, K b), of which the nominal values p0 and the tolerances U0 of a
device are known, as is the covariance C of all readings (schemes.covariance). With A
the matrix of the inputs, r = y - A p0 has the covariance V = C + A U0 A'. A run is as
it should be where r' V^-1 r is chi-square of as many degrees as it has readings, and
what least squares leaves of it, of four less an axis.

A mistake is a hypothesis refitted: it changes the inputs A, or the readings y, which
multiplied by f have -6 n ln f more of -2 ln L (Jacobian), or adds an amplitude, which
costs ln 3n. The least of -2 ln L = r' V^-1 r + ln det V is what the run looks like.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations, permutations
from math import degrees, inf, isclose, log, pi, radians
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.schemes.covariance import joint_covariance
from budget.earth import normal_gravity
from budget.errors import CallError
from budget.model.response import BIAS, COLUMN, ROW, SIGN, STATISTICS
from budget.model.scheme import mean_powers
from budget.model.source import GYRO, Nonlinearity, Offset, TurnOnChange
from budget.model.sources import source_of
from budget.model.windows import FACES, OUTER, Schedule, Setting
from budget.names import AXES
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.model.place import Place
    from budget.model.windows import Window

SUSPECT = 1e-3  # probability of a sound run below which mistakes are looked for [1]
FITS = 1e-6  # that a run with a mistake has at the least [1]
TOLD_APART = 9.2  # in -2 ln L: a hundred times as likely
# What nothing is given of is known to this: of a relative scale factor, an angle [rad],
# a bias over the largest input [1].
WIDE = {"scale_factor": 0.1, "mounting_angle": 0.2, "bias": 1.0}
LEAST_U = 1e-12  # of what is known exactly, over the same
ROUNDING = 1e-13  # of a correlation [1]
EQUAL = 1e-9  # of the largest input, below which inputs are the same [1]
MOST_WINDOWS = 400  # of which the covariance of all readings is kept
MOST_PAIRS = 40  # windows of which every two may have been exchanged
MOST_KEPT = 2000  # geometries, which runs of the same windows share
STEP = radians(5.0)  # of latitudes that are tried first
HALF, FULL = pi / 2.0, pi
GRAVITIES = (9.5, 10.1)  # of any place that a run may have been at [m/s^2]
OF_WINDOW = "window"


@dataclass(frozen=True, kw_only=True)
class Mistake:
    """One thing that may have gone wrong, as a hypothesis about one triad.

    Attributes
    ----------
    name : str
        'earth_rate_sign', 'window_face', ...
    what : tuple of (str, object)
        Which one, and how large: ('window', 7), ('face', 'x up').
    settings : tuple of (int, Setting)
        How the table really stood, by the place of the window among the triad's.
    place : Place or None
        Where it really was, or with what earth; None: where the procedure says.
    order : tuple of int
        Whose readings each place has; () its own.
    mix : tuple of tuple of float
        Readings of true axes, (3, 3); () as they are.
    factor : float
        Readings over true ones [1].
    added : tuple of (int, int) or None
        Place and axis of a reading that is off by any amount.
    is_free : bool
        Whether an amplitude was fitted.
    is_of_unit : bool
        Whether both triads have it.
    """

    name: str
    what: tuple[tuple[str, object], ...] = ()
    settings: tuple[tuple[int, Setting], ...] = ()
    place: Place | None = None
    order: tuple[int, ...] = ()
    mix: tuple[tuple[float, ...], ...] = ()
    factor: float = 1.0
    added: tuple[int, int] | None = None
    is_free: bool = False
    is_of_unit: bool = False

    @property
    def numbers(self) -> tuple[int, ...]:
        """Of the windows that it is of; () of one of the whole run."""
        of: Any = dict(self.what)
        return of.get("windows") or ((of[OF_WINDOW],) if OF_WINDOW in of else ())

    def really(self, windows: Sequence[Window]) -> list[Window]:
        """Return windows as they really were."""
        found = list(windows)
        for place, setting in self.settings:
            found[place] = replace(found[place], setting=setting)
        return found

    def done(self, readings: Array) -> Array:
        """Return what true readings, (3, n), are recorded as."""
        found = readings[:, list(self.order)] if self.order else readings
        if self.mix:
            found = np.array(self.mix) @ found
        return np.asarray(self.factor * found)

    def undone(self, readings: Array) -> Array:
        """Return the true readings of those that were recorded, (3, n)."""
        found = readings / self.factor
        if self.mix:
            found = np.array(self.mix).T @ found
        if self.order:
            back = np.empty(len(self.order), dtype=np.intp)
            back[list(self.order)] = np.arange(len(self.order))
            found = found[:, back]
        return np.asarray(found)


@dataclass(frozen=True, kw_only=True)
class LooksLike:
    """A mistake that a run looks like."""

    mistake: Mistake
    evidence: float  # -2 ln L of a sound run less that with the mistake
    also: tuple[Mistake, ...] = ()  # that it is not told from


@dataclass(frozen=True, kw_only=True)
class ChiSquare:
    """A sum of squares against what it should be."""

    value: float
    degrees_of_freedom: int

    @property
    def p(self) -> float:
        """Probability of one as large or larger [1]."""
        from scipy.special import chdtrc

        if self.degrees_of_freedom <= 0:
            return 1.0
        return float(chdtrc(self.degrees_of_freedom, self.value))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Geometry:
    """What inputs make of readings, over the root of the covariance.

    Attributes
    ----------
    nominal : ndarray, shape (3 n,)
        A p0 [unit of the input].
    columns : ndarray, shape (3 n, m)
        A over the root.
    root : ndarray, shape (m, m), or None
        Cholesky root of U0^-1 + A' C^-1 A; None: it has none.
    """

    nominal: Array
    columns: Array
    root: Array | None


@dataclass(frozen=True, kw_only=True, eq=False)
class TriadRun:
    """Readings of one triad in the windows of a test, with what is known of them.

    Attributes
    ----------
    owner : str
        'gyro' or 'accelerometer'.
    windows : tuple of Window
        The triad's own, as they should have been.
    numbers : tuple of int
        Of each among all windows of the procedure, from 1.
    place : Place
    sample_rate : float
        [Hz].
    readings : ndarray, shape (3, n)
        Means, over the nominal scale factor [unit of the input].
    covariance : ndarray, shape (3 n, 3 n)
        Of all of them, axis after axis.
    nominal : ndarray, shape (3, 4)
        Responses and biases by design.
    information : ndarray, shape (12, 12)
        Inverse of their covariance U0, axis after axis.
    wide : int
        How many of them nothing is known of.
    orders : tuple of int
        Powers of an axis' own input that are estimated besides.
    """

    owner: str
    windows: tuple[Window, ...]
    numbers: tuple[int, ...]
    place: Place
    sample_rate: float
    readings: Array
    covariance: Array = field(repr=False)
    nominal: Array
    information: Array = field(repr=False)
    wide: int
    orders: tuple[int, ...] = ()
    _kept: dict[object, _Geometry] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls,
        sensor: Sensor,
        procedure: Procedure,
        schedule: Schedule,
        readings: Array,
        numbers: Sequence[int],
        *,
        is_scaled: bool = True,
        orders: tuple[int, ...] = (),
        rounding: Array | None = None,
    ) -> TriadRun:
        """Put together what a device and a procedure say of readings.

        Parameters
        ----------
        is_scaled : bool
            Whether readings are over a nominal scale factor that is known; else
            nothing is known of the scale factors.
        rounding : ndarray, shape (3,), optional
            Variance that steps of readings add to each, by axis.

        Raises
        ------
        CallError
            The windows are too many for a covariance of all.
        """
        if len(schedule.windows) > MOST_WINDOWS:
            raise CallError(
                f"{procedure.name} has {len(schedule.windows)} windows of the "
                f"{sensor.kind}, {MOST_WINDOWS} at the most can be held against each "
                "other; join repeated windows"
            )
        inputs = inputs_of(sensor.kind, schedule.windows, procedure.place)
        largest = float(np.abs(inputs).max())
        information, wide = _information(sensor, largest, is_scaled=is_scaled)
        return cls(
            owner=sensor.kind,
            windows=schedule.windows,
            numbers=tuple(numbers),
            place=procedure.place,
            sample_rate=procedure.sample_rate,
            readings=readings,
            covariance=rounded(joint_covariance(sensor, procedure, schedule), rounding),
            nominal=_nominal(sensor),
            information=information,
            wide=wide,
            orders=orders,
        )

    @cached_property
    def root(self) -> Array:
        """Cholesky root of the covariance, (3 n, 3 n).

        Raises
        ------
        CallError
            Some readings have no uncertainty at all.
        """
        return root_of(self.covariance, self.owner)

    @cached_property
    def columns(self) -> Array:
        """A of the procedure, (3 n, 12 and orders)."""
        return self.columns_of(Mistake(name=""))

    def columns_of(self, mistake: Mistake) -> Array:
        """Return A with a mistake, axis after axis."""
        windows = mistake.really(self.windows)
        place = mistake.place or self.place
        n = len(windows)
        u = inputs_of(self.owner, windows, place)
        own = np.column_stack([u, np.ones(n)])
        found = np.zeros((3, n, 3, STATISTICS))
        for axis in range(3):
            found[axis, :, axis] = own
        columns = found.reshape(3 * n, -1)
        if not self.orders:
            return columns
        spread = Schedule(windows=tuple(windows)).spread(place.force)
        powers = mean_powers(spread, self.orders)  # (3, n, m)
        more = np.zeros((3, n, 3, len(self.orders)))
        for axis in range(3):
            more[axis, :, axis] = powers[axis]
        return np.hstack([columns, more.reshape(3 * n, -1)])

    def whitened(self, values: Array) -> Array:
        """Return values, (3 n, ...), over the root of the covariance."""
        return np.asarray(self.back @ values)

    @cached_property
    def back(self) -> Array:
        """Inverse of that root, (3 n, 3 n)."""
        from scipy.linalg import solve_triangular

        return np.asarray(
            solve_triangular(self.root, np.eye(len(self.root)), lower=True)
        )

    @cached_property
    def residual(self) -> ChiSquare:
        """What least squares leaves of the readings, weighed by their covariance."""
        B, y = self.whitened(self.columns), self.whitened(self.readings.ravel())
        size = np.linalg.norm(B, axis=0)
        size[size == 0.0] = 1.0
        found, _, rank, _ = np.linalg.lstsq(B / size, y)
        left = y - (B / size) @ found
        return ChiSquare(value=float(left @ left), degrees_of_freedom=len(y) - rank)

    @cached_property
    def prior(self) -> ChiSquare:
        """What the readings are off those of the nominal values."""
        degrees_of_freedom = self.readings.size - self.wide - 3 * len(self.orders)
        value, _ = self._square(Mistake(name=""))
        return ChiSquare(value=value, degrees_of_freedom=degrees_of_freedom)

    def _inner(self, B: Array) -> Array:
        """Return U0^-1 + A' C^-1 A."""
        inner = B.T @ B
        m = len(self.information)
        inner[:m, :m] += self.information
        return np.asarray(inner)

    def _geometry(self, mistake: Mistake) -> _Geometry:
        """Return what a mistake makes of the inputs; of few it is kept."""
        key = mistake.settings, mistake.place
        found = self._kept.get(key)
        if found is None:
            columns = self.columns_of(mistake) if any(key) else self.columns
            nominal = columns[:, : self.nominal.size] @ self.nominal.ravel()
            B = self.whitened(columns)
            try:
                root = np.asarray(np.linalg.cholesky(self._inner(B)), dtype=float)
            except np.linalg.LinAlgError:
                root = None
            found = _Geometry(nominal=nominal, columns=B, root=root)
            if len(self._kept) < MOST_KEPT:
                self._kept[key] = found
        return found

    def _square(self, mistake: Mistake) -> tuple[float, float]:
        """Return r' V^-1 r and ln det V, less what all have, with a mistake."""
        of = self._geometry(mistake)
        if of.root is None:
            return inf, 0.0
        z = self.whitened(mistake.undone(self.readings).ravel() - of.nominal)
        half = np.linalg.solve(of.root, of.columns.T @ z)
        size = 2.0 * float(np.log(np.diag(of.root)).sum())
        return float(z @ z - half @ half), size

    def fit(self, mistake: Mistake) -> tuple[float, float]:
        """Return -2 ln L with a mistake, less what all have in common, and its p."""
        square, size = self._square(mistake)
        own = 2.0 * self.readings.size * log(abs(mistake.factor))
        cost = log(self.readings.size) if mistake.is_free else 0.0
        nu = self.prior.degrees_of_freedom - mistake.is_free
        left = ChiSquare(value=square, degrees_of_freedom=nu)
        return square + size + own + cost, left.p

    # ---- which mistake ---------------------------------------------------------------

    @cached_property
    def is_sound(self) -> bool:
        """Whether nothing in it is less likely than SUSPECT."""
        return min(self.residual.p, self.prior.p) >= SUSPECT

    @cached_property
    def looks_like(self) -> LooksLike | None:
        """What it looks like if it is not sound; None where no known mistake fits."""
        if self.is_sound:
            return None
        sound, _ = self.fit(Mistake(name=""))
        found = [(*self.fit(one), one) for one in self.hypotheses]
        return likeliest(sound, [*found, *self._added(sound)])

    def _added(self, sound: float) -> Iterator[tuple[float, float, Mistake]]:
        """Yield -2 ln L and p of one reading that is off, for each of them."""
        B = self.whitened(self.columns)
        r = self.readings.ravel() - self.columns[:, :12] @ self.nominal.ravel()
        back = self.back
        inverse = back.T @ back
        seen = back.T @ B
        inverse -= seen @ np.linalg.solve(self._inner(B), seen.T)
        off = inverse @ r
        own = np.diag(inverse)
        prior = self.prior
        n = len(self.windows)
        for k, (value, size) in enumerate(zip(off, own, strict=True)):
            axis, place = divmod(k, n)
            gain = float(value**2 / size)
            left = ChiSquare(
                value=prior.value - gain,
                degrees_of_freedom=prior.degrees_of_freedom - 1,
            )
            mistake = Mistake(
                name="window_motion",
                what=(
                    (OF_WINDOW, self.numbers[place]),
                    ("axis", AXES[axis]),
                    ("value", float(value / size)),
                ),
                added=(place, axis),
                is_free=True,
            )
            yield sound - gain + log(r.size), left.p, mistake

    @cached_property
    def hypotheses(self) -> tuple[Mistake, ...]:
        """Mistakes that change what is read or put in, those of free size fitted."""
        known = [one for one in self.known if self.is_seen(one)]
        return tuple(known + list(self._fitted()))

    @cached_property
    def known(self) -> tuple[Mistake, ...]:
        """Mistakes that are known of these windows, those of a size apart."""
        return tuple(
            mistakes_of(
                self.owner, self.windows, self.numbers, self.place, self.sample_rate
            )
        )

    def is_seen(self, mistake: Mistake) -> bool:
        """Whether it changes anything."""
        if mistake.mix or mistake.factor != 1.0 or mistake.added:
            return True
        if mistake.order:
            u = inputs_of(self.owner, self.windows, self.place)
            changed = u[list(mistake.order)]
        else:
            u = inputs_of(self.owner, self.windows, self.place)
            where = mistake.place or self.place
            changed = inputs_of(self.owner, mistake.really(self.windows), where)
        return bool(np.abs(changed - u).max() > EQUAL * np.abs(u).max())

    def _fitted(self) -> Iterator[Mistake]:
        """Yield mistakes of a size that the run tells: latitude, gravity."""
        from scipy.optimize import minimize_scalar

        def at(latitude: float) -> Mistake:
            return Mistake(
                name="latitude",
                what=(("value", degrees(latitude)),),
                place=moved_to(self.place, latitude),
                is_free=True,
            )

        def of(gravity: float) -> Mistake:
            return Mistake(
                name="gravity",
                what=(("value", gravity),),
                place=replace(self.place, gravity=gravity),
                is_free=True,
            )

        def least(
            make: Callable[[float], Mistake], tried: Array, low: float, high: float
        ) -> Mistake:
            sizes = [self.fit(make(one))[0] for one in tried.tolist()]
            k = int(np.argmin(sizes))
            ends = (
                max(low, tried[max(k - 1, 0)]),
                min(high, tried[min(k + 1, len(tried) - 1)]),
            )
            best = minimize_scalar(
                lambda x: self.fit(make(float(x)))[0],
                bounds=ends,
                method="bounded",
                options={"xatol": 1e-9},
            )
            return make(float(best.x))

        if self.owner == GYRO or self.place.is_normal:
            yield least(at, np.arange(-HALF, HALF + STEP / 2.0, STEP), -HALF, HALF)
        if self.owner != GYRO:
            yield least(of, np.linspace(*GRAVITIES, 31), *GRAVITIES)

    # ---- which cannot be seen --------------------------------------------------------

    def shown(self, mistake: Mistake) -> float:
        """Return the probability that a run with a mistake is found not to be sound.

        Of one with nominal values, by the noncentral chi-square distribution of the
        readings against the nominal ones, or of what least squares leaves [1].
        """
        p0 = self.nominal.ravel()
        there = self.columns_of(mistake)[:, : p0.size] @ p0
        read = mistake.done(there.reshape(3, -1)).ravel()
        shift = read - self.columns[:, : p0.size] @ p0
        z, B = self.whitened(shift), self.whitened(self.columns)
        seen = B.T @ z
        by_prior = float(z @ z - seen @ np.linalg.solve(self._inner(B), seen))
        fitted = np.linalg.lstsq(B, z)[0]
        by_residual = float(((z - B @ fitted) ** 2).sum())
        return max(
            seen_with(by_prior, self.prior.degrees_of_freedom),
            seen_with(by_residual, self.residual.degrees_of_freedom),
        )


def root_of(covariance: Array, owner: str) -> Array:
    """Return the Cholesky root of a covariance, to rounding of correlations.

    Raises
    ------
    CallError
        Some readings have no uncertainty at all.
    """
    size = np.sqrt(np.diag(covariance))
    if not (size > 0.0).all():
        raise CallError(
            f"nothing that the {owner} is known by varies in these windows, so that no "
            f"reading can be held against another; give its noise ({owner}.errors)"
        )
    scaled = covariance / np.outer(size, size)
    for least in (EQUAL * EQUAL, ROUNDING, EQUAL):  # of correlations that are 1
        scaled[np.diag_indices_from(scaled)] += least
        try:
            return np.asarray(size[:, None] * np.linalg.cholesky(scaled))
        except np.linalg.LinAlgError:
            continue
    raise CallError(
        f"the readings of the {owner} are one and the same in these windows, so that "
        f"none can be held against another; give its noise ({owner}.errors)"
    )


def likeliest(
    sound: float, found: Sequence[tuple[float, float, Mistake]]
) -> LooksLike | None:
    """Return the mistake of the least -2 ln L with those that it is not told from.

    Of those that fit, each with its -2 ln L and p; None where a sound run, with its
    own, is not told from it.
    """
    fitting = sorted(
        ((size, mistake) for size, p, mistake in found if p > FITS),
        key=lambda one: one[0],
    )
    if not fitting or sound - fitting[0][0] <= TOLD_APART:
        return None
    least, best = fitting[0]
    also = (mistake for size, mistake in fitting[1:] if size - least <= TOLD_APART)
    return LooksLike(mistake=best, evidence=sound - least, also=tuple(also))


def seen_with(size: float, degrees_of_freedom: int) -> float:
    """Return the probability that a sum of squares of so much more is suspect [1].

    Of the noncentral chi-square distribution.
    """
    from scipy.special import chdtri, chndtr

    if degrees_of_freedom <= 0:
        return 0.0
    limit = float(chdtri(degrees_of_freedom, SUSPECT))
    found = 1.0 - float(chndtr(limit, degrees_of_freedom, size))
    return found if np.isfinite(found) else 1.0


def mistakes_of(
    owner: str,
    windows: Sequence[Window],
    numbers: Sequence[int],
    place: Place,
    sample_rate: float,
) -> Iterator[Mistake]:
    """Yield the mistakes that are known of a triad's windows, those of a size apart.

    Each is a change of inputs or readings; `numbers` are those of the windows in the
    procedure.
    """
    turns = [k for k, one in enumerate(windows) if one.sense]
    if owner == GYRO:
        yield from _of_earth(place)
        if turns:
            yield Mistake(
                name="turn_sense",
                settings=tuple((k, _turned_back(windows[k])) for k in turns),
            )
    else:
        yield Mistake(
            name="gravity",
            what=(("value", STANDARD_GRAVITY),),
            place=replace(place, gravity=STANDARD_GRAVITY, is_normal=False),
        )
    yield Mistake(
        name="azimuth_sense",
        settings=tuple(
            (k, replace(one.setting, outer=-one.setting.outer))
            for k, one in enumerate(windows)
        ),
    )
    yield from of_axes()
    yield from of_units(owner, sample_rate)
    for k, one in enumerate(windows):
        yield from _of_window(numbers[k], k, one)
    n = len(windows)
    for i, j in combinations(range(n), 2):
        if n <= MOST_PAIRS or j == i + 1:
            order = list(range(n))
            order[i], order[j] = j, i
            yield Mistake(
                name="windows_order",
                what=(("windows", (numbers[i], numbers[j])),),
                order=tuple(order),
            )


def of_units(owner: str, sample_rate: float) -> Iterator[Mistake]:
    """Yield units of readings that are exchanged: what they are over true ones."""
    name, size = ("gravity_unit", STANDARD_GRAVITY)
    if owner == GYRO:
        name, size = "degrees_radians", 180.0 / pi
    for what, factor in ((name, size), ("per_sample", sample_rate)):
        for one in (1.0 / factor, factor) if factor != 1.0 else ():
            yield Mistake(name=what, what=(("factor", one),), factor=one)


def _of_earth(place: Place) -> Iterator[Mistake]:
    """Yield mistakes about the earth rate."""
    yield Mistake(
        name="earth_rate_sign", place=replace(place, earth_rate=-place.earth_rate)
    )
    yield Mistake(name="earth_rate_missing", place=replace(place, earth_rate=0.0))
    yield Mistake(name="latitude_sign", place=moved_to(place, -place.latitude))


def moved_to(place: Place, latitude: float) -> Place:
    """Return a place at another latitude, with the gravity of there if it is normal."""
    gravity = place.gravity
    if place.is_normal:
        gravity = normal_gravity(latitude, place.height)
    return replace(place, latitude=latitude, gravity=gravity)


def of_axes() -> Iterator[Mistake]:
    """Yield axes that are exchanged, rotated or reversed."""
    eye = np.eye(3)
    for order in permutations(range(3)):
        moved = [k for k in range(3) if order[k] != k]
        if not moved:
            continue
        is_swap = len(moved) == len(("one", "other"))
        axes = "".join(AXES[k] for k in (moved if is_swap else order))
        yield Mistake(
            name="axes_swapped" if is_swap else "axes_rotated",
            what=(("axes", axes),),
            mix=_rows(eye[list(order)]),
        )
    for size in (1, 2, 3):
        for reversed_ in combinations(range(3), size):
            signs = np.ones(3)
            signs[list(reversed_)] = -1.0
            yield Mistake(
                name="axis_reversed",
                what=(("axes", "".join(AXES[k] for k in reversed_)),),
                mix=_rows(np.diag(signs)),
            )


def _rows(matrix: Array) -> tuple[tuple[float, ...], ...]:
    """Return a matrix that can be a key."""
    return tuple(map(tuple, matrix.tolist()))


def _of_window(number: int, k: int, one: Window) -> Iterator[Mistake]:
    """Yield mistakes of one window: another face, azimuth, or sense of its turn."""
    where = ((OF_WINDOW, number),)
    setting = one.setting
    for (axis, sign), (middle, inner) in FACES.items():
        if _alike(setting.middle, middle) and _alike(setting.inner, inner):
            continue
        yield Mistake(
            name="window_face",
            what=(*where, ("face", f"{AXES[axis]} {'up' if sign > 0 else 'down'}")),
            settings=((k, replace(setting, middle=middle, inner=inner)),),
        )
    for turned in (HALF, FULL, -HALF):
        if setting.turning != OUTER:
            azimuth = degrees(setting.outer + turned) % 360.0
            yield Mistake(
                name="window_azimuth",
                what=(*where, ("azimuth", round(azimuth, 9))),
                settings=((k, replace(setting, outer=setting.outer + turned)),),
            )
    if one.sense:
        yield Mistake(
            name="window_turn_sense", what=where, settings=((k, _turned_back(one)),)
        )


def _turned_back(one: Window) -> Setting:
    """Return the setting of a turn in the other sense."""
    return replace(one.setting, angle=-one.setting.angle)


def _alike(a: float, b: float) -> bool:
    """Whether two angles are the same [rad]."""
    return isclose(np.cos(a - b), 1.0, abs_tol=EQUAL)


def inputs_of(owner: str, windows: Sequence[Window], place: Place) -> Array:
    """Return mean inputs in body axes, shape (n, 3) [unit of the input]."""
    schedule = Schedule(windows=tuple(windows))
    if owner == GYRO:
        return np.asarray(schedule.rates + schedule.to_body @ place.earth)
    return np.asarray(schedule.to_body @ place.force)


def _nominal(sensor: Sensor) -> Array:
    """Return responses and biases by design, shape (3, 4)."""
    found = np.zeros((3, STATISTICS))
    found[[0, 1, 2], [0, 1, 2]] = 1.0
    found[ROW, COLUMN] = SIGN * sensor.nominal_mounting_angle
    found[:, BIAS] = sensor.nominal_bias
    return found


def rounded(C: Array, rounding: Array | None) -> Array:
    """Return a covariance of readings, (3 n, 3 n), with that of their steps."""
    if rounding is None:
        return C
    return C + np.diag(np.repeat(rounding, len(C) // 3))


def prior_of(sensor: Sensor, largest: float, *, is_scaled: bool = True) -> Prior:
    """Return how well parameters of a unit are known before a calibration.

    Of offsets, tolerances of a new unit and changes with what the test is done in; what
    nothing is given of is known as WIDE says. How far a scale factor is off its line at
    another input is no tolerance of it.

    Parameters
    ----------
    largest : float
        Input of the test [unit of the input].
    """
    shapes = {"scale_factor": 3, "mounting_angle": 6, "bias": 3}
    variance = {key: np.zeros(n) for key, n in shapes.items()}
    given = set()
    known = {line.name: line for line in sensor.lines}
    for line in (*sensor.lines, *sensor.initial):
        effect = source_of(sensor.kind, line.name).meant(line).effect
        if isinstance(effect, Offset):
            variance[effect.target] += line.u**2
            if not isinstance(effect, Nonlinearity):
                given.add(effect.target)
        elif isinstance(effect, TurnOnChange):
            for target, gains in effect.gains(known).items():
                variance[target] += (gains[0] ** 2) @ line.u**2
    if not is_scaled:
        given -= {"scale_factor", "bias"}  # nobody knows where counts begin
    size = {"scale_factor": 1.0, "mounting_angle": 1.0, "bias": largest}
    parts, is_known = [], []
    for key, n in shapes.items():
        wide = WIDE[key] * size[key]
        u = np.sqrt(variance[key]) if key in given else np.full(n, wide)
        parts.append(np.maximum(u, LEAST_U * size[key]))
        is_known.append(np.full(n, key in given))
    return Prior(u=np.concatenate(parts), is_known=np.concatenate(is_known))


@dataclass(frozen=True, kw_only=True, eq=False)
class Prior:
    """How well the 12 parameters of a triad are known, shapes (12,) [SI]."""

    u: Array
    is_known: NDArray[np.bool_]


def _information(
    sensor: Sensor, largest: float, *, is_scaled: bool
) -> tuple[Array, int]:
    """Return the inverse of U0 of the statistics, (12, 12), and how many are wide."""
    prior = prior_of(sensor, largest, is_scaled=is_scaled)
    M_b = _nominal(sensor)
    change = np.zeros((3, STATISTICS, 12))
    for axis in range(3):
        change[axis, :, axis] = M_b[axis]  # of K
        change[axis, BIAS, 9 + axis] = 1.0
    change[ROW, COLUMN, 3 + np.arange(6)] = SIGN
    back = np.linalg.inv(change.reshape(12, 12))
    scaled = back / prior.u[:, None]
    return scaled.T @ scaled, int((~prior.is_known).sum())
