"""Aided navigation: what a Kalman filter leaves of errors, source by source.

A filter estimates the navigator's states, constants and states of noises from what aids
measure at some times. Its gains K follow from what it believes: the covariance P of its
errors, carried forward by Growth's steps and updated in Joseph's form, P <- (I - KH) P
(I - KH)' + K R K' (Bucy and Joseph 1968), symmetric by construction. What is true is
linear in every source once the gains are known. So one sweep backward, for rows C that
are asked for of the truth and D of the filter's estimates, gives the part of each
exactly: at an update L = DK takes the noise of the measurement, C gains L M and D loses
L H; over a step C takes the noise of that step. The optimal filter is the one that
believes what is true: there D = -C, and the parts add up to its own covariance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.navigation.dynamics import ATTITUDE, INPUTS, POSITION, VELOCITY
from budget.navigation.growth import begun, driven, variances_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.arrays import Array
    from budget.navigation.dynamics import Moment
    from budget.navigation.growth import AxisNoise, Driven, Growth

SEEN = 9  # rows of Moment.seen
# Of Moment.measured: units, and standard uncertainties above which rounding moves what
# an update leaves by more than 1e-4 of it.
UNITS = ("m",) * 3 + ("m/s",) * 3 + ("rad",) * 3 + ("m/s",)
MOST = {"m": 1e8, "m/s": 1e5, "rad": 1e3}
# What an alignment knows, by the rows of Moment.given.
KNOWN = {
    "position": POSITION,
    "velocity": VELOCITY,
    "level": slice(ATTITUDE.start, ATTITUDE.stop - 1),
    "heading": slice(ATTITUDE.stop - 1, ATTITUDE.stop),
}


@dataclass(frozen=True, kw_only=True)
class Drift:
    """An error of an aid that fades: stationary, of first order (Gauss-Markov)."""

    u: tuple[float, ...]  # by row [SI]
    correlation_time: float  # [s]

    def fade(self, time: Array) -> Array:
        """Return what is left of it after these times [1]."""
        return np.exp(-time / self.correlation_time)


@dataclass(frozen=True, kw_only=True)
class Aid:
    """What is measured of a navigator, at some times, with white noise.

    Attributes
    ----------
    name : str
    rows : tuple of int
        Of Moment.measured.
    u : tuple of float
        Of each row at one time [SI].
    ends : tuple of int
        Which of the steps' ends it is measured at, rising.
    drift : Drift or None
        What is in all of them besides.
    """

    name: str
    rows: tuple[int, ...]
    u: tuple[float, ...]
    ends: tuple[int, ...]
    drift: Drift | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Belief:
    """What a filter believes.

    Attributes
    ----------
    covariance : ndarray, shape (m, m)
        Of constants that it estimates, as they begin [SI squared].
    columns : callable, Moment -> (..., 6, m)
        Errors of gyros and accelerometers that each constant is.
    biases : ndarray, shape (6, m)
        Those that are the same at all times; 0 of other constants.
    noises : tuple of AxisNoise
    aids : tuple of Aid
    start : ndarray, shape (9,)
        Standard uncertainties of Moment.given when it begins [SI].
    """

    covariance: Array
    columns: Callable[[Moment], Array]
    biases: Array
    noises: tuple[AxisNoise, ...]
    aids: tuple[Aid, ...]
    start: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class KalmanFilter:
    """A Kalman filter on a route: its states and its gains.

    States are the navigator's, n of them, then the constants, then those of noises and
    drifts. An error of rounding is one that every sample draws anew.

    Attributes
    ----------
    growth : Growth
        Whose steps end at every update, and where something is asked for.
    belief : Belief
    kept : frozenset of int
        Ends at which its covariance is asked for.
    """

    growth: Growth
    belief: Belief
    kept: frozenset[int]

    @property
    def n(self) -> int:
        """Number of the navigator's states."""
        return int(self.growth.moves.shape[1])

    @cached_property
    def size(self) -> int:
        """Number of all states."""
        return int(self.steps.moves.shape[2])

    @cached_property
    def ends(self) -> Array:
        """The navigator's errors of all states at the ends, shape (ends, n, N)."""
        entry = self.growth.steps.ends.entry(aided=self.growth.aided)
        T = np.zeros((len(entry), self.n, self.size))
        T[..., : self.n] = np.eye(self.n)
        for place, row in self.steps.rounded:
            T[..., place] = entry[..., row]
        return T

    @cached_property
    def seen(self) -> Array:
        """What is seen of its states at the ends, shape (ends, 9, N)."""
        return self.growth.steps.ends.seen(aided=self.growth.aided) @ self.ends

    @cached_property
    def measured(self) -> tuple[tuple[Array, Array, Array], ...]:
        """Of each end, what aids measure, of the navigator's and of all states.

        M, shape (m, n), H, shape (m, N), and variances, shape (m,); m is 0 without.
        """
        every, T = self.growth.steps.ends.measured(aided=self.growth.aided), self.ends
        found = []
        for end, aids in enumerate(self.at):
            M = every[end, [row for aid in aids for row in aid.rows]]
            H = M @ T[end]
            at = 0
            for aid in aids:
                place = self.steps.drifts.get(aid.name)
                if place is not None:
                    own = np.arange(len(aid.rows))
                    H[at + own, place + own] = 1.0
                at += len(aid.rows)
            found.append((M, H, np.array([one for aid in aids for one in aid.u]) ** 2))
        return tuple(found)

    @cached_property
    def at(self) -> tuple[tuple[Aid, ...], ...]:
        """Aids that are there at each end."""
        found: list[list[Aid]] = [[] for _ in self.growth.steps.asked]
        for aid in self.belief.aids:
            for end in aid.ends:
                found[end].append(aid)
        return tuple(map(tuple, found))

    @property
    def updates(self) -> int:
        """At how many times it is updated."""
        return sum(map(bool, self.at))

    @cached_property
    def run(self) -> FilterRun:
        """Gains, and what it believes of its errors."""
        steps, n = self.steps, self.n
        P: Array = steps.begin.copy()
        gains: list[Array] = []
        covariances: dict[int, Array] = {}
        ended = dict(zip(self.growth.steps.asked, self.measured, strict=True))
        for step, (move, fade) in enumerate(zip(steps.moves, steps.fades, strict=True)):
            top = move @ P
            P[n:, n:] *= fade[:, None] * fade
            P[:n, :n] = top @ move.T + steps.added[step]
            P[:n, n:] = top[:, n:] * fade + steps.joint[step]
            P[n:, :n] = P[:n, n:].T
            np.einsum("ii->i", P)[n:] += steps.own[step]
            if step not in ended:
                continue
            _, H, variances = ended[step]
            K: Array = np.empty((self.size, 0))
            if len(H):
                HP = H @ P
                S = HP @ H.T
                self._check_bounds(len(gains), np.diag(S))
                np.einsum("ii->i", S)[:] += variances
                K = np.linalg.solve(S, HP).T.astype(float)
                P -= K @ HP
                P -= (P @ H.T - K * variances) @ K.T
                P[:] = 0.5 * (P + P.T)
            gains.append(K)
            if len(gains) - 1 in self.kept:
                covariances[len(gains) - 1] = P.copy()
        return FilterRun(gains=tuple(gains), covariances=covariances)

    def _check_bounds(self, end: int, variances: Array) -> None:
        """Refuse to measure what is off by so much that rounding decides.

        Raises
        ------
        CallError
            As of a height that nothing has measured for hours.
        """
        rows = [row for aid in self.at[end] for row in aid.rows]
        for row, one in zip(rows, variances.tolist(), strict=True):
            unit = UNITS[row]
            if one > MOST[unit] ** 2:
                steps = self.growth.steps
                t = steps.durations[: steps.asked[end] + 1].sum()
                raise CallError(
                    f"mission.aiding: what is measured {t:.6g} s after the begin finds "
                    f"errors of {one**0.5:.2g} {unit} (1 sigma), expected "
                    f"{MOST[unit]:g} {unit} at the most, above which rounding "
                    "decides; let aids begin earlier, say 'altitude: aided', or look "
                    "for a slip in the sizes of the mission"
                )

    @cached_property
    def steps(self) -> FilterSteps:
        """Transitions and noise of all states in the steps, and how they begin."""
        from scipy.linalg import block_diag

        growth, belief = self.growth, self.belief
        U, found = belief.covariance, growth.found(belief.columns)
        blocks = [_of_constants(growth.gained(belief.columns), found, U)]
        start = growth.first.given(aided=growth.aided) * belief.start
        P = start @ start.T + found @ U @ found.T
        added = np.zeros((len(growth.moves), self.n, self.n))
        rounded: list[tuple[int, int]] = []
        noises: list[tuple[int, int, int]] = []
        drifts: dict[str, int] = {}
        number = self.n + len(U)
        drives = {
            noise: driven(growth, noise)
            for noise in dict.fromkeys(part.noise for part in belief.noises)
        }
        for part in belief.noises:
            block, of_begin, gained = _of_noise(growth, part, drives[part.noise])
            P, added = P + of_begin, added + gained
            if part.noise.edge:
                rounded.append((number, part.row))
            else:
                noises.append((number, number + len(block.begin), part.row))
            blocks.append(block)
            number += len(block.begin)
        for aid in belief.aids:
            if aid.drift is not None:
                drifts[aid.name] = number
                blocks.append(_of_drift(growth, aid.drift))
                number += len(aid.rows)
        begin = block_diag(P, *(block.begin for block in blocks))
        begin[self.n :, : self.n] = np.concatenate([block.crossed for block in blocks])
        begin[: self.n, self.n :] = begin[self.n :, : self.n].T
        moves = [growth.moves, *(block.gains for block in blocks)]
        return FilterSteps(
            moves=np.concatenate(moves, axis=2),
            fades=np.concatenate([block.fades for block in blocks], axis=1),
            added=added,
            joint=np.concatenate([block.joint for block in blocks], axis=2),
            own=np.concatenate([block.own for block in blocks], axis=1),
            begin=begin,
            rounded=tuple(rounded),
            noises=tuple(noises),
            drifts=drifts,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class FilterRun:
    """What a filter finds on the way.

    Attributes
    ----------
    gains : tuple of ndarray, shape (N, m)
        Of each end.
    covariances : dict of ndarray, shape (N, N)
        That it believes, by the ends that are kept, after the update.
    """

    gains: tuple[Array, ...]
    covariances: dict[int, Array]


@dataclass(frozen=True, kw_only=True, eq=False)
class FilterSteps:
    """All states of a filter in steps: N of them, n of the navigator.

    Attributes
    ----------
    moves : ndarray, shape (s, n, N)
        What the navigator's states become.
    fades : ndarray, shape (s, N - n)
        What is left of each other one.
    added : ndarray, shape (s, n, n)
        Covariance that the navigator's states gain.
    joint : ndarray, shape (s, n, N - n)
        That with the other ones.
    own : ndarray, shape (s, N - n)
        Variances that these gain.
    begin : ndarray, shape (N, N)
        Covariance of all when it begins.
    rounded : tuple of (int, int)
        Errors of rounding: which state, of which input.
    noises : tuple of (int, int, int)
        Noises with a memory: the first state, the one after the last, of which input.
    drifts : dict
        The first state of the drift of each aid that has one.
    """

    moves: Array
    fades: Array
    added: Array
    joint: Array
    own: Array
    begin: Array
    rounded: tuple[tuple[int, int], ...]
    noises: tuple[tuple[int, int, int], ...]
    drifts: dict[str, int]


@dataclass(frozen=True, kw_only=True, eq=False)
class Aided:
    """What is left of errors of a navigator with a filter, by source.

    It answers as Growth does for a unit by itself.

    Attributes
    ----------
    filter : KalmanFilter
    asked : tuple of int
        Which ends of the steps are asked for, rising.
    aids : tuple of Aid
        As they are.
    start : ndarray, shape (9,)
        Standard uncertainties of Moment.given when it begins [SI].
    """

    filter: KalmanFilter
    asked: tuple[int, ...]
    aids: tuple[Aid, ...]
    start: Array

    def of_constants(self, columns: Callable[[Moment], Array]) -> Array:
        """Return what is asked for, of constants, shape (times, 9, m); see Growth."""
        return self._sweep.of_constants(columns).reshape(len(self.asked), SEEN, -1)

    def of_noise(self, parts: Sequence[AxisNoise]) -> Array:
        """Return the covariance of what is asked for, (times, 9, times, 9); see Growth.

        Parameters
        ----------
        parts : sequence of AxisNoise
            Independent of each other.
        """
        return self._by_time(self._sweep.of_noise(parts))

    def of_aids(self) -> Iterator[tuple[str, Array]]:
        """Yield each source of the aids, with the covariance that it leaves.

        Shape (times, 9, times, 9), as of_noise.
        """
        for name, C in self._sweep.of_aids(self.aids):
            yield name, self._by_time(C)

    def of_start(self) -> Iterator[tuple[str, Array]]:
        """Yield what an alignment knows, with the covariance that it leaves."""
        for name, C in self._sweep.of_start(self.start):
            yield name, self._by_time(C)

    def of_inputs(self, end: int) -> Sweep:
        """Return what a filter has wrong of slow errors of the inputs at an end.

        Six rows: the biases of gyros and accelerometers with the states of their noise.
        """
        kalman = self.filter
        estimated = np.zeros((INPUTS, kalman.size))
        m = len(kalman.belief.covariance)
        estimated[:, kalman.n : kalman.n + m] = -kalman.belief.biases
        for first, last, row in kalman.steps.noises:
            estimated[row, first:last] = -1.0
        rows = (end, np.zeros((INPUTS, kalman.n)), estimated)
        return replace(Sweep.of(kalman, [rows]), direct=np.eye(INPUTS))

    @cached_property
    def believed(self) -> Array:
        """Covariance of what is asked for as the filter has it, (times, 9, 9)."""
        places = list(self.asked)
        seen, P = self.filter.seen[places], self.filter.run.covariances
        U = np.array([P[place] for place in places])
        return np.asarray(seen @ U @ seen.swapaxes(1, 2))

    def _by_time(self, C: Array) -> Array:
        """Return a covariance with an index for the times."""
        shape = (len(self.asked), SEEN)
        return C.reshape(*shape, *shape)

    @cached_property
    def _sweep(self) -> Sweep:
        """What is asked for, traced back to its sources."""
        r = SEEN * len(self.asked)
        growth = self.filter.growth
        seen = growth.steps.ends.seen(aided=growth.aided)
        asked = []
        for number, end in enumerate(self.asked):
            true = np.zeros((r, self.filter.n))
            estimated = np.zeros((r, self.filter.size))
            own = slice(SEEN * number, SEEN * (number + 1))
            true[own], estimated[own] = seen[end], -self.filter.seen[end]
            asked.append((end, true, estimated))
        return Sweep.of(self.filter, asked)


@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """Rows of what is asked for, traced back: r of them.

    Attributes
    ----------
    rows : ndarray, shape (s, r, n)
        Of the navigator's true states at the end of each step, before an update.
    first : ndarray, shape (r, n)
        Of them when it begins.
    at_ends : ndarray, shape (ends, r, n)
        What is taken of them at each end.
    noise : tuple of ndarray, shape (r, m)
        Of the noise of what is measured at each end.
    places : tuple of dict
        Columns of each aid in that, by its name.
    direct : ndarray, shape (r, 6)
        Of the states of noise of each input, at the end of the last step.
    growth : Growth
    """

    growth: Growth
    rows: Array
    first: Array
    at_ends: Array
    noise: tuple[Array, ...]
    places: tuple[dict[str, slice], ...]
    direct: Array

    @classmethod
    def of(
        cls, kalman: KalmanFilter, asked: Sequence[tuple[int, Array, Array]]
    ) -> Sweep:
        """Trace rows back that are asked for.

        Parameters
        ----------
        kalman : KalmanFilter
        asked : sequence of (int, ndarray, ndarray)
            An end, and all rows as they begin there: of the true states, shape (r, n),
            and of the filter's estimates, shape (r, N).
        """
        growth, steps, gains = kalman.growth, kalman.steps, kalman.run.gains
        begins = {end: (true, estimated) for end, true, estimated in asked}
        last = max(begins)
        n, r = kalman.n, len(asked[0][1])
        number = growth.steps.asked[last] + 1
        end_of = {step: end for end, step in enumerate(growth.steps.asked)}
        C, D = np.zeros((r, n)), np.zeros((r, kalman.size))
        rows = np.zeros((number, r, n))
        at_ends = np.zeros((len(growth.steps.asked), r, n))
        noise: list[Array] = [np.empty((r, 0))] * len(growth.steps.asked)
        for step in range(number - 1, -1, -1):
            end = end_of.get(step)
            if end is not None:
                if end in begins:
                    at_ends[end] += begins[end][0]
                    D = D + begins[end][1]
                M, H, variances = kalman.measured[end]
                if len(variances):
                    noise[end] = L = D @ gains[end]
                    at_ends[end] += L @ M
                    D = D - L @ H
                C = C + at_ends[end]
            rows[step] = C
            C = C @ growth.moves[step]
            move, others = steps.moves[step], D[:, n:] * steps.fades[step]
            D = D[:, :n] @ move
            D[:, n:] += others
        places = []
        for aids in kalman.at:
            ends = np.cumsum([0, *(len(aid.rows) for aid in aids)]).tolist()
            found = zip(aids, pairwise(ends), strict=True)
            places.append({aid.name: slice(*both) for aid, both in found})
        return cls(
            growth=growth,
            direct=np.zeros((r, INPUTS)),
            rows=rows,
            first=C,
            at_ends=at_ends,
            noise=tuple(noise),
            places=tuple(places),
        )

    def of_constants(self, columns: Callable[[Moment], Array]) -> Array:
        """Return what the rows are of constants, by navigation, shape (r, m)."""
        gains = self.growth.gained(columns)[: len(self.rows)]
        found = np.tensordot(self.rows, gains, axes=((0, 2), (0, 1)))
        return np.asarray(found + self.first @ self.growth.found(columns))

    def of_noise(self, parts: Sequence[AxisNoise]) -> Array:
        """Return the covariance of the rows by independent noises, shape (r, r)."""
        growth, C, first = self.growth, self.rows, self.first
        s, r, _ = C.shape
        found = np.zeros((r, r))
        for noise in dict.fromkeys(part.noise for part in parts):
            variances = variances_of(parts, noise)
            drive = driven(growth, noise)
            P, R, p = begun(growth, noise)
            added = np.einsum("i,sinm->snm", variances, drive.added[:s])
            found += _summed(C @ added, C)
            found += first @ np.einsum("i,inm->nm", variances, P) @ first.T
            if noise.edge:
                G = self.at_ends @ growth.steps.ends.entry(aided=growth.aided)
                G = G * np.sqrt(noise.edge * variances)
                found += _summed(G, G)
            for row in np.flatnonzero(variances) if len(p) else ():
                taken = C @ drive.gains[:s, row].swapaxes(1, 2)
                own = _behind(taken, drive.over.fade, self.direct[:, row, None])
                ends, begin = own[1:], own[0]
                # Half of what is symmetric, with what is not: both come back below.
                half = C @ drive.joint[:s, row].swapaxes(1, 2)
                half += ends * (0.5 * drive.over.end[:s, None])
                one = _summed(half, ends)
                one += (first @ R[row].T + 0.5 * begin * p) @ begin.T
                found += variances[row] * (one + one.T)
        return found

    def of_aids(self, aids: Iterable[Aid]) -> Iterator[tuple[str, Array]]:
        """Yield each source of aids with the covariance of the rows, shape (r, r)."""
        t = np.cumsum(self.growth.steps.durations)[list(self.growth.steps.asked)]
        for aid in aids:
            ends = [end for end in aid.ends if self.noise[end].shape[1]]
            taken = [self.noise[end][:, self.places[end][aid.name]] for end in ends]
            L = np.array(taken).reshape(-1, len(self.first), len(aid.rows))
            white = L * np.array(aid.u)
            yield aid.name, _summed(white, white)
            if aid.drift is not None:
                fade = aid.drift.fade(np.diff(t[ends], prepend=-np.inf))
                later = np.append(fade[1:], 0.0)[:, None] * np.ones(L.shape[2])
                gained = _behind(L, later)[:-1] * np.array(aid.drift.u)
                gained *= np.sqrt(1.0 - fade**2)[:, None, None]
                yield f"{aid.name}_drift", _summed(gained, gained)

    def of_start(self, start: Array) -> Iterator[tuple[str, Array]]:
        """Yield what an alignment knows, with the covariance of the rows, (r, r)."""
        given = self.first @ self.growth.first.given(aided=self.growth.aided)
        for name, rows in KNOWN.items():
            C = given[:, rows] * start[rows]
            if start[rows].any():
                yield name, C @ C.T


@dataclass(frozen=True, kw_only=True, eq=False)
class _Block:
    """States beside the navigator's, k of them, that fade each by itself.

    Attributes
    ----------
    gains : ndarray, shape (s, n, k)
        What the navigator's states gain of them in a step.
    fades : ndarray, shape (s, k)
        What is left of them.
    joint : ndarray, shape (s, n, k)
        Covariance of what both gain.
    own : ndarray, shape (s, k)
        Variances that they gain.
    crossed, begin : ndarray, shapes (k, n), (k, k)
        Covariance with the navigator's states when it begins, and their own.
    """

    gains: Array
    fades: Array
    joint: Array
    own: Array
    crossed: Array
    begin: Array


def _of_constants(gains: Array, found: Array, covariance: Array) -> _Block:
    """Return states of constants of a covariance, shape (m, m).

    Of what the navigator's states gain of them, shape (s, n, m), and begin with, (n,
    m).
    """
    s, _, m = gains.shape
    return _Block(
        gains=gains,
        fades=np.ones((s, m)),
        joint=np.zeros_like(gains),
        own=np.zeros((s, m)),
        crossed=covariance @ found.T,
        begin=covariance,
    )


def _of_noise(
    growth: Growth, part: AxisNoise, drive: Driven
) -> tuple[_Block, Array, Array]:
    """Return states of a noise; what it adds to the navigator's, at first, in steps.

    An error of rounding is a state that each step draws anew.
    """
    row = part.row
    P, R, p = (part.u**2 * one for one in begun(growth, part.noise))
    own = part.u**2 * drive.over.end
    fades, gains, joint = drive.over.fade, drive.gains[:, row], drive.joint[:, row]
    crossed = R[row]
    if part.noise.edge:
        s, n = len(growth.moves), growth.moves.shape[1]
        fades, own = np.zeros((s, 1)), np.full((s, 1), part.u**2 * part.noise.edge)
        gains = joint = np.zeros((s, 1, n))
        crossed, p = np.zeros((1, n)), own[0]
    block = _Block(
        gains=gains.swapaxes(1, 2),
        fades=fades,
        joint=part.u**2 * joint.swapaxes(1, 2),
        own=own,
        crossed=crossed,
        begin=np.diag(p),
    )
    return block, P[row], part.u**2 * drive.added[:, row]


def _of_drift(growth: Growth, drift: Drift) -> _Block:
    """Return states of a drift of an aid."""
    s, n = growth.moves.shape[:2]
    variances = np.square(drift.u)
    fades = drift.fade(growth.steps.durations)[:, None] * np.ones_like(variances)
    nothing = np.zeros((s, n, len(variances)))
    return _Block(
        gains=nothing,
        fades=fades,
        joint=nothing,
        own=(1.0 - fades**2) * variances,
        crossed=nothing[0].T,
        begin=np.diag(variances),
    )


def _summed(A: Array, B: Array) -> Array:
    """Return the sum over steps of A B', shapes (s, r, k)."""
    return np.tensordot(A, B, axes=((0, 2), (0, 2)))


def _behind(taken: Array, fade: Array, last: Array | float = 0.0) -> Array:
    """Return rows of states that fade, traced back, from what is taken of them.

    Parameters
    ----------
    taken : ndarray, shape (s, r, k)
        In each step, of what they are at its begin.
    fade : ndarray, shape (s or more, k)
        What is left of them at its end.
    last : ndarray, shape (r, k), or 0
        What is taken of them when all is over.

    Returns
    -------
    ndarray, shape (s + 1, r, k)
        At the begin of each step, and at the end of the last.
    """
    found = np.zeros((len(taken) + 1, *taken.shape[1:]))
    found[-1] = last
    for step in range(len(taken) - 1, -1, -1):
        found[step] = found[step + 1] * fade[step] + taken[step]
    return found
