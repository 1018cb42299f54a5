"""Growth of errors along a route: what constants and noise do to a navigator.

Errors e of the six inputs act in a short step by x(h) = Phi(h, 0) x(0) + the integral
of K(t) e(t), where K(t) = Phi(h, t) G(t). Transitions Phi are matrix exponentials of
the navigator's equations (budget.navigation.dynamics): exact where nothing changes, of
fourth order in the step where velocity or attitude do (Magnus). K is smooth whatever e
is, so it is taken as a cubic, by Legendre's polynomials, and noise enters by its
moments with those, whose covariance is known in closed form. So a step need not be
short beside a correlation time, and all noises share one set of exponentials.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, comb, log2
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.polynomial import Polynomial

from budget.navigation.dynamics import INPUTS
from budget.navigation.route import NODES, WEIGHTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.arrays import Array
    from budget.navigation.dynamics import Moment
    from budget.navigation.route import Steps

AT_A_TIME = 256  # steps, for which arrays are made [1]
KEPT = 16  # noises of journeys that are remembered
DRIVEN = 8  # of what noises do in the steps of a route
STEEP = 20.0  # h/tau from which on moments come by recursion [1]
# Of an exponential: Taylor's terms, and the norm to which the last is below 1e-19.
TERMS, HALVED = 14, 0.25
GAUSS_POINTS = 24  # of the rule below

# Legendre's polynomials on [0, 1], of mean square 1.
LEGENDRE = (
    Polynomial([1.0]),
    3.0**0.5 * Polynomial([-1.0, 2.0]),
    5.0**0.5 * Polynomial([1.0, -6.0, 6.0]),
    7.0**0.5 * Polynomial([-1.0, 12.0, -30.0, 20.0]),
)
ORDER = len(LEGENDRE)
COEFFICIENTS = np.array([np.pad(p.coef, (0, ORDER - len(p.coef))) for p in LEGENDRE])


def _lags() -> Array:
    """Return the integrals of p(u) q(u + v) over u from 0 to 1 - v, and of q and p.

    Of all pairs of Legendre's polynomials, by powers of v, shape (4, 4, 8): of u^a (u +
    v)^b it is the sum over k of C(b, k) v^(b - k) (1 - v)^n / n, n = a + k + 1.
    """
    powers = np.zeros((ORDER, ORDER, 2 * ORDER))
    for a in range(ORDER):
        for b in range(ORDER):
            for k in range(b + 1):
                n = a + k + 1
                for j in range(n + 1):
                    powers[a, b, b - k + j] += (-1) ** j * comb(n, j) * comb(b, k) / n
    one = np.einsum("pa,qb,abj->pqj", COEFFICIENTS, COEFFICIENTS, powers)
    return np.asarray(one + one.swapaxes(0, 1))


def _pairs(functions: Iterable[Polynomial]) -> Array:
    """Return the integrals over [0, 1] of the products of all pairs."""
    f = tuple(functions)
    return np.array([[(a * b).integ()(1.0) for b in f] for a in f])


AT_NODES = np.array([p(np.array(NODES)) for p in LEGENDRE]) * WEIGHTS  # to coefficients
REST = tuple(p.integ()(1.0) - p.integ() for p in LEGENDRE)  # integrals from s to 1
LAGS = _lags()
OF_WALK = _pairs(REST)
OF_SLOPE = _pairs(p.deriv() for p in LEGENDRE)


@dataclass(frozen=True, kw_only=True)
class NoiseMoments:
    """What a noise of one input does in steps: `s` of them, `k` states of the noise.

    Attributes
    ----------
    fade : ndarray, shape (s, k)
        Of a state, what is left at the end of a step.
    first : ndarray, shape (s, k, 4)
        Its moments, for 1 at the begin.
    end : ndarray, shape (s, k)
        Variance that it gains.
    joint : ndarray, shape (s, k, 4)
        Covariance of that with the moments.
    own : ndarray, shape (s, 4, 4)
        Covariance of the moments, of what the step adds.
    """

    fade: Array
    first: Array
    end: Array
    joint: Array
    own: Array


class UnitNoise(Protocol):
    """Noise of one input, of unit size; two that are equal are one."""

    @abstractmethod
    def __hash__(self) -> int:
        """Return one number for equal ones."""

    @property
    def begins(self) -> Array:
        """Variances of its states when the unit is turned on, shape (k,)."""

    @property
    def edge(self) -> float:
        """Variance of its integral's error at any one moment, without a memory."""

    def over(self, h: Array) -> NoiseMoments:
        """Return its moments in steps of these durations [s]."""


@dataclass(frozen=True)
class UnitWhiteNoise:
    """Angle or velocity random walk, of density 1."""

    @property
    def begins(self) -> Array:
        """It has no state."""
        return np.empty(0)

    edge = 0.0

    def over(self, h: Array) -> NoiseMoments:
        """Return orthogonal moments."""
        return _stateless(h[:, None, None] * np.eye(ORDER))


@dataclass(frozen=True)
class Rounding:
    """Rounding of increments of angle or velocity to a step of 1, every period.

    The integral of the input is off by e, of variance 1/12, anew at every sample: by
    parts, x = G e at the end, less Phi G e at the start, less the integral of K'(t) e,
    where e acts as white noise of density sqrt(period/12).
    """

    period: float  # of the samples [s]
    edge = 1.0 / 12.0

    @property
    def begins(self) -> Array:
        """It has no state."""
        return np.empty(0)

    def over(self, h: Array) -> NoiseMoments:
        """Return the moments with the slopes of the polynomials."""
        return _stateless(self.edge * self.period * OF_SLOPE / h[:, None, None])


@dataclass(frozen=True)
class UnitRandomWalk:
    """Rate or acceleration random walk of density 1, 0 when the unit is turned on."""

    @property
    def begins(self) -> Array:
        """It begins at 0."""
        return np.zeros(1)

    edge = 0.0

    def over(self, h: Array) -> NoiseMoments:
        """Return the moments of white noise's integral."""
        one = np.eye(ORDER)[0]
        grows = np.array([rest.integ()(1.0) for rest in REST])
        h = h[:, None, None]
        return NoiseMoments(
            fade=np.ones_like(h[..., 0]),
            first=h * one,
            end=h[..., 0],
            joint=h**2 * grows,
            own=h**3 * OF_WALK,
        )


@dataclass(frozen=True)
class Markov:
    """Sum of stationary first-order Gauss-Markov processes, each of unit variance."""

    times: tuple[float, ...]  # correlation times [s]
    edge = 0.0

    @property
    def begins(self) -> Array:
        """All are stationary."""
        return np.ones(len(self.times))

    def over(self, h: Array) -> NoiseMoments:
        """Return the moments of exp(-|t - t'|/tau), without those of the begin."""
        r = h[:, None] / np.array(self.times)
        fade = np.exp(-r)
        powers = _exponential_moments(r, 2 * ORDER)
        first = powers[..., :ORDER] @ COEFFICIENTS.T
        mirrored = first * (-1.0) ** np.arange(ORDER)
        whole = np.einsum("skj,pqj->skpq", powers, LAGS)
        own = whole - first[..., :, None] * first[..., None, :]
        h = h[:, None, None]
        return NoiseMoments(
            fade=fade,
            first=h * first,
            end=-np.expm1(-2.0 * r),
            joint=h * (mirrored - fade[..., None] * first),
            own=h**2 * own.sum(axis=1),
        )


@dataclass(frozen=True, kw_only=True)
class AxisNoise:
    """A noise of one input."""

    row: int  # of the six inputs
    noise: UnitNoise
    u: float  # its size: sigma, or density [SI]


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """What a noise of unit size does in steps, for each input by itself.

    Attributes
    ----------
    over : NoiseMoments
    gains : ndarray, shape (s, 6, k, n)
        What the navigator's states gain of each state of the noise.
    joint : ndarray, shape (s, 6, k, n)
        Covariance of what both gain.
    added : ndarray, shape (s, 6, n, n)
        That of what the navigator's states gain, without the noise's state.
    """

    over: NoiseMoments
    gains: Array
    joint: Array
    added: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Growth:
    """A route in steps, how it begins, and when something is asked for.

    Attributes
    ----------
    first : Moment
        When the mission begins.
    alignment : float
        How long the unit finds level and north by itself before [s]; 0: it knows them.
    steps : Steps
    aided : bool
        Whether height and vertical velocity are known.
    """

    first: Moment
    alignment: float
    steps: Steps
    aided: bool

    def of_constants(self, columns: Callable[[Moment], Array]) -> Array:
        """Return what is asked for, of constants, shape (times, 9, m) [SI].

        Parameters
        ----------
        columns : callable, Moment -> (..., 6, m)
            Errors of gyros and accelerometers that each constant is at these moments.
        """
        S = self.found(columns)
        found = []
        for own in self.parts:
            h = self.steps.durations[own, None, None, None]
            weights = h * np.array(WEIGHTS)[:, None, None]
            D = columns(self.steps.nodes.some(own))
            gains = (weights * self._responses[own] @ D).sum(axis=1)
            for place, gain in enumerate(gains, start=own.start):
                S = self.moves[place] @ S + gain
                if place in self.steps.asked:
                    found.append(S)
        return np.asarray(self._seen @ np.array(found))

    def gained(self, columns: Callable[[Moment], Array]) -> Array:
        """Return what constants add to the states in each step, (steps, n, m) [SI]."""
        h = self.steps.durations[:, None, None, None]
        weights = h * np.array(WEIGHTS)[:, None, None]
        D = columns(self.steps.nodes)
        return np.asarray((weights * self._responses @ D).sum(axis=1))

    def found(self, columns: Callable[[Moment], Array]) -> Array:
        """Return what constants make of the states at the begin, (n, m) [SI]."""
        return np.asarray(self._aligned @ columns(self.first.at_rest))

    def of_noise(self, parts: Sequence[AxisNoise]) -> Array:
        """Return the covariance of what is asked for, (times, 9, times, 9) [SI^2].

        Parameters
        ----------
        parts : sequence of AxisNoise
            Independent of each other.
        """
        seen = self._seen
        T, rows = seen.shape[:2]
        C = np.zeros((T, rows, T, rows))
        for noise in dict.fromkeys(part.noise for part in parts):
            variances = variances_of(parts, noise)
            used = np.flatnonzero(variances)
            spread = _spread(self, noise)
            for e, states in enumerate(spread.states):
                P = np.einsum("i,inm->nm", variances[used], states[used])
                with_noise = variances[used, None, None] * spread.with_noise[e][used]
                right = np.concatenate([P, np.concatenate([*with_noise, P[:0]])])
                later = spread.later[e][:, :, used]
                left = np.concatenate(
                    [self._passed[e], later.reshape(*later.shape[:2], -1)], axis=2
                )
                C[e:, :, e] += left @ (right @ seen[e].T)
            if noise.edge:
                for e, G in enumerate(seen @ self.steps.ends.entry(aided=self.aided)):
                    C[e, :, e] += noise.edge * (variances * G) @ G.T
        for e in range(T):
            C[e, :, e + 1 :] = np.moveaxis(C[e + 1 :, :, e], 2, 0)
        return C

    @property
    def parts(self) -> Iterator[slice]:
        """The steps, AT_A_TIME of them each."""
        n = len(self.steps.durations)
        return (slice(k, min(k + AT_A_TIME, n)) for k in range(0, n, AT_A_TIME))

    @cached_property
    def _flows(self) -> tuple[Array, Array]:
        """Transitions of the steps, (steps, n, n), and K at the nodes.

        K has the shape (steps, 4, n, 6). Magnus, order 4: Phi(h, t) is the exponential
        of the integral of F from t on and the commutator of its two first moments.
        """
        moves, responses = zip(*map(self._flows_of, self.parts), strict=True)
        return np.concatenate(moves), np.concatenate(responses)

    def _flows_of(self, own: slice) -> tuple[Array, Array]:
        """Return the same of some steps."""
        nodes = self.steps.nodes.some(own)
        F, G = nodes.dynamics(aided=self.aided), nodes.entry(aided=self.aided)
        h = self.steps.durations[own, None, None]
        flows = []
        for begin in (0.0, *NODES):
            middle = Polynomial([-0.5 * (1.0 + begin), 1.0])
            mean, lever = (
                np.array([_from(begin, weight * p) for p in LEGENDRE]) @ AT_NODES
                for weight in (Polynomial([1.0]), middle)
            )
            A, B = (np.einsum("j,sjnm->snm", w, F) for w in (mean, lever))
            bent = h**2 / (1.0 - begin) * (B @ A - A @ B)
            flows.append(_exponentials(h * A + bent))
        return flows[0], np.stack(flows[1:], axis=1) @ G

    @property
    def moves(self) -> Array:
        """Transitions of the steps, shape (steps, n, n)."""
        return self._flows[0]

    @property
    def _responses(self) -> Array:
        """What a unit of each input at a node is at the end, (steps, 4, n, 6)."""
        return self._flows[1]

    @cached_property
    def _seen(self) -> Array:
        """What is asked for, of the states, shape (times, 9, n)."""
        return self.steps.ends.seen(aided=self.aided)

    @cached_property
    def _passed(self) -> list[Array]:
        """Of each asked time's states, what is seen then and later, (later, 9, n)."""
        found: list[list[Array]] = []
        n = self.moves.shape[1]
        since = np.empty((0, n, n))
        for place, move in enumerate(self.moves):
            since = move @ since
            if place in self.steps.asked:
                since = np.concatenate([since, np.eye(n)[None]])
                found.append([])
                rows = self._seen[len(found) - 1] @ since
                for then, one in zip(found, rows, strict=True):
                    then.append(one)
        return [np.array(rows) for rows in found]

    @cached_property
    def _aligned(self) -> Array:
        """States that self-alignment finds, of mean errors, shape (n, 6)."""
        if not self.alignment:
            return np.zeros((self.moves.shape[1], INPUTS))
        return self.first.at_rest.aligned(aided=self.aided)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Spread:
    """What a noise of unit size does on a journey, for each input by itself.

    Attributes
    ----------
    states : ndarray, shape (times, 6, n, n)
        Covariance of the navigator's states at the asked times.
    with_noise : ndarray, shape (times, 6, k, n)
        That of the noise's states with them.
    later : list of ndarray, shape (later, 9, 6, k)
        What is seen at an asked time and the later ones, of the noise's states then.
    """

    states: Array
    with_noise: Array
    later: list[Array]


def variances_of(parts: Sequence[AxisNoise], noise: UnitNoise) -> Array:
    """Return what some parts add to the variance of each input, of one noise, (6,)."""
    found = np.zeros(INPUTS)
    for part in parts:
        found[part.row] += part.u**2 if part.noise == noise else 0.0
    return found


@lru_cache(maxsize=KEPT)
def _spread(growth: Growth, noise: UnitNoise) -> _Spread:
    """Return what a noise does, once for all devices that have it."""
    over = noise.over(growth.steps.durations)
    P, R, p = begun(growth, noise)
    number, seen = 0, growth._seen  # noqa: SLF001
    since = np.empty((0, *R.shape))
    left = np.empty((0, len(p)))
    states, with_noise = [], []
    later: list[list[Array]] = []
    for place, (move, gain, joint, added) in enumerate(_gains(growth, over)):
        fade = over.fade[place]
        crossed = move @ R.swapaxes(1, 2) @ gain
        P = move @ P @ move.T + crossed + crossed.swapaxes(1, 2) + added
        P += gain.swapaxes(1, 2) @ (p[:, None] * gain)
        R = fade[:, None] * (R @ move.T + p[:, None] * gain) + joint
        p = fade**2 * p + over.end[place]
        since = since @ move.T + left[:, None, :, None] * gain
        left = left * fade
        if place in growth.steps.asked:
            since = np.concatenate([since, np.zeros((1, *R.shape))])
            left = np.concatenate([left, np.ones((1, len(p)))])
            states.append(P)
            with_noise.append(R)
            later.append([])
            rows = np.moveaxis(since @ seen[number].T, 3, 1)
            for then, one in zip(later, rows, strict=True):
                then.append(one)
            number += 1
    return _Spread(
        states=np.array(states),
        with_noise=np.array(with_noise),
        later=[np.array(rows) for rows in later],
    )


def _gains(
    growth: Growth, over: NoiseMoments
) -> Iterator[tuple[Array, Array, Array, Array]]:
    """Yield the transition of each step, and what its noise does for each input.

    Gains of its states, (6, k, n), their covariance with the states, alike, and what
    the step adds, (6, n, n).
    """
    for own in growth.parts:
        K = np.einsum("kj,sjni->sikn", AT_NODES, growth._responses[own])  # noqa: SLF001
        yield from zip(
            growth.moves[own],
            over.first[own, None] @ K,
            over.joint[own, None] @ K,
            K.swapaxes(2, 3) @ over.own[own, None] @ K,
            strict=True,
        )


@lru_cache(maxsize=DRIVEN)
def driven(growth: Growth, noise: UnitNoise) -> Driven:
    """Return what a noise of unit size does in each step of a route."""
    over = noise.over(growth.steps.durations)
    K = np.einsum("kj,sjni->sikn", AT_NODES, growth._responses)  # noqa: SLF001
    return Driven(
        over=over,
        gains=over.first[:, None] @ K,
        joint=over.joint[:, None] @ K,
        added=K.swapaxes(2, 3) @ over.own[:, None] @ K,
    )


def begun(growth: Growth, noise: UnitNoise) -> tuple[Array, Array, Array]:
    """Return covariances of the states, with the noise and of it, at the begin.

    Self-alignment takes the mean of the noise, which goes on from there.
    """
    p, M, T = noise.begins, growth._aligned.T, growth.alignment  # noqa: SLF001
    n = M.shape[1]
    P, R = np.zeros((INPUTS, n, n)), np.zeros((INPUTS, len(p), n))
    wrong = np.zeros_like(M)
    if T:
        over = noise.over(np.array([T]))
        fade, first = over.fade[0], over.first[0, :, 0] / T
        mean = first**2 @ p + (over.own[0, 0, 0] + 2.0 * noise.edge) / T**2
        P = mean * M[:, :, None] * M[:, None, :]
        R = (fade * first * p + over.joint[0, :, 0] / T)[:, None] * M[:, None]
        p = fade**2 * p + over.end[0]
        wrong = M / T
    if noise.edge:
        # The mean is (e - e before)/T, and e goes on with the opposite sign.
        G = growth.first.entry(aided=growth.aided).T
        both = wrong[:, :, None] * G[:, None, :]
        P += noise.edge * (G[:, :, None] * G[:, None, :] - both - both.swapaxes(1, 2))
    return P, R, p


def _exponentials(M: Array) -> Array:
    """Return the exponentials of matrices, shape (s, n, n), all at once.

    In units of the states in which no element is large (balancing), by Taylor's series
    of what is halved until it is small, then squared as often.
    """
    from scipy.linalg import matrix_balance

    _, (scale, _) = matrix_balance(np.abs(M).max(axis=0), permute=False, separate=True)
    B = M / scale[:, None] * scale
    norm = np.abs(B).sum(axis=-1).max(initial=0.0)
    halved = max(ceil(log2(norm / HALVED)), 0) if norm else 0
    B = B / 2.0**halved
    one = np.eye(M.shape[-1])
    E = one + B / TERMS
    for k in range(TERMS - 1, 0, -1):
        E = one + B @ E / k
    for _ in range(halved):
        E = E @ E
    return np.asarray(E * scale[:, None] / scale)


def _stateless(own: Array) -> NoiseMoments:
    """Return the moments of a noise that has no state."""
    s = len(own)
    none, nothing = np.empty((s, 0)), np.empty((s, 0, ORDER))
    return NoiseMoments(fade=none, first=nothing, end=none, joint=nothing, own=own)


def _from(begin: float, p: Polynomial) -> float:
    """Return the integral of a polynomial from there to 1."""
    whole = p.integ()
    return float(whole(1.0) - whole(begin))


def _exponential_moments(r: Array, number: int) -> Array:
    """Return the integrals over [0, 1] of v^j exp(-r v), shape (*r, number).

    By Gauss' rule where r is small; else from one to the next, (j J - exp(-r))/r, which
    keeps its accuracy for r above j.
    """
    v, w = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    v, w = 0.5 * (v + 1.0), 0.5 * w
    powers = v[:, None] ** np.arange(number) * w[:, None]
    J = np.exp(-np.minimum(r, STEEP)[..., None] * v) @ powers
    steep = np.maximum(r, STEEP)
    last = -np.expm1(-steep) / steep
    for j in range(number):
        J[..., j] = np.where(r > STEEP, last, J[..., j])
        last = ((j + 1) * last - np.exp(-steep)) / steep
    return J
