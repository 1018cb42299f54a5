"""Fit of noise models to block means: BIC, profile intervals, upper bounds.

White noise N [unit sqrt(s)] alone, or with a random walk K [unit/sqrt(s)], with a
first-order Gauss-Markov process sigma [unit], tau [s], or with flicker B [unit]: a sum
of such processes of correlation times D 4^k, each of variance B^2 ln 4/pi
(S(f) = B^2/(2 pi f) between them). Values are those of the largest restricted
likelihood; an interval of a value ends where twice what its profile falls short is the
quantile of chi-square with one degree of freedom (Wilks), and models are compared by
BIC = -2 l + k ln n.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import exp, hypot, inf, log, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.restricted import (
    BlockProcess,
    Restricted,
    restricted,
    together,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from budget.arrays import Array

WHITE, WALK, SIGMA, TIME, FLICKER = "N", "K", "sigma", "tau", "B"
SLOW = "slow"  # sigma sqrt(2/tau) of a Gauss-Markov process, in the place of sigma
MODELS: Mapping[str, tuple[str, ...]] = {
    "white": (),
    "rw": (WALK,),
    "gm": (SIGMA, TIME),
    "flicker": (FLICKER,),
    "gm+rw": (SIGMA, TIME, WALK),
    "flicker+rw": (FLICKER, WALK),
}
RATIO = 4.0  # of the correlation times that make up flicker [1]
LONGEST = 4.0  # of them, over the length of the record [1]
SHAPE = log(RATIO) / pi  # variance of each, over B^2 [1]
# Of a correlation time over the record, from which the process is the random walk that
# it is there: l differs by 1e-5, and by rounding at a million times as much [1].
SLOWEST = 1e4
NOT_TOLD = 6.0  # of two models whose BIC differ by less, neither is told [1]
AT_95, AT_68, ONE_SIDED_95 = 3.841458820694124, 0.9889464815, 2.705543454095404
BELOW = 1e300  # in the place of a likelihood that is none
STEPS = 40  # of a search for an end, at the most
CLOSE = 1e-3  # of 2 l, in which an end may be off [1]
# Of logarithms: of what is told, and of what is fitted beside it, which moves l by its
# square.
TOLD, NUISANCE = 1e-4, 5e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class BlockMeans:
    """What is fitted.

    Attributes
    ----------
    y : ndarray, shape (n,)
        Means of blocks in their order; nan where one is missing [unit].
    X : ndarray, shape (n, p)
        What their mean is of: 1, and what is regressed on.
    block, sample : float
        Lengths of a block and of a sample [s].
    """

    y: Array
    X: Array
    block: float
    sample: float

    @property
    def number(self) -> int:
        """Blocks that are there."""
        return int((~np.isnan(self.y)).sum())

    @property
    def duration(self) -> float:
        """From the first block to the last [s]."""
        return len(self.y) * self.block

    def likelihood(self, values: Mapping[str, float]) -> Restricted | None:
        """Return the restricted likelihood of a model with these values."""
        D, processes, white = self.block, [], values[WHITE] ** 2 / self.block
        has_flicker = FLICKER in values
        walk = values.get(WALK, 0.0)
        if TIME in values:
            time = values[TIME]
            sigma = values.get(SIGMA) or values[SLOW] * sqrt(time / 2.0)
            if time > SLOWEST * self.duration:
                walk = hypot(walk, sigma * sqrt(2.0 / time))
            else:
                processes.append(BlockProcess.markov(sigma, time, D))
        if walk:
            by = BlockProcess.walk_of_means if has_flicker else BlockProcess.walk
            processes.insert(0, by(walk, D))
        if has_flicker:
            own = values[FLICKER] * sqrt(SHAPE)
            time = D / RATIO
            while time >= self.sample:  # gone within a block: white
                x = D / time
                white += own**2 * 2.0 * (x - 1.0 + exp(-x)) / x**2
                time /= RATIO
            time = D
            while time <= LONGEST * self.duration:
                processes.append(BlockProcess.of_means(own, time, D))
                time *= RATIO
        return restricted(self.y, self.X, processes, white)

    def coarser(self, number: int) -> BlockMeans:
        """Return means of so many blocks each; a rest is left out."""
        n = len(self.y) // number
        y, X = (
            one[: n * number].reshape(n, number, -1).mean(axis=1)
            for one in (self.y, self.X)
        )
        return replace(self, y=y[:, 0], X=X, block=number * self.block)


@dataclass(frozen=True, eq=False)
class Runs:
    """Several records of one device, blocks of one length: one noise, a mean each."""

    records: tuple[BlockMeans, ...]

    @property
    def block(self) -> float:
        """Length of a block [s]."""
        return self.records[0].block

    @property
    def number(self) -> int:
        """Blocks that are there."""
        return sum(one.number for one in self.records)

    @property
    def duration(self) -> float:
        """Of the longest record [s]."""
        return max(one.duration for one in self.records)

    def coarser(self, number: int) -> Runs:
        """Return means of so many blocks each."""
        return Runs(tuple(one.coarser(number) for one in self.records))

    def likelihood(self, values: Mapping[str, float]) -> Restricted | None:
        """Return the restricted likelihood of a model with these values."""
        found = []
        for one in self.records:
            part = one.likelihood(values)
            if part is None:
                return None
            found.append(part)
        return found[0] if len(found) == 1 else together(found)


@dataclass(frozen=True, eq=False, kw_only=True)
class NoiseFit:
    """A model at its largest likelihood.

    Attributes
    ----------
    model : str
        Of MODELS.
    values : mapping of str to float
        By parameter.
    log_likelihood, bic : float
    mean, mean_uncertainty : ndarray, shape (p,)
        Of what the mean is of, with standard uncertainties.
    """

    model: str
    values: Mapping[str, float]
    log_likelihood: float
    bic: float
    mean: Array
    mean_uncertainty: Array
    data: BlockMeans | Runs = field(repr=False)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names, N first."""
        return (WHITE, *MODELS[self.model])


def fit_noise(data: BlockMeans | Runs, model: str) -> NoiseFit:
    """Return a model at its largest restricted likelihood.

    The scale of all is found exactly, by generalised least squares; what else there is
    by a search from the best of a grid.
    """
    names = MODELS[model]
    D, T = data.block, data.duration
    grids: dict[str, Array] = {
        WALK: np.geomspace(0.01, 3.0, 7) / sqrt(D * 100.0),
        SIGMA: np.geomspace(0.02, 1.5, 6) / sqrt(D),
        TIME: np.geomspace(3.0 * D, max(T / 5.0, 10.0 * D), 7),
        FLICKER: np.geomspace(0.02, 2.0, 8) / sqrt(D),
    }

    def relative(logs: Array) -> dict[str, float]:
        return {WHITE: 1.0} | dict(zip(names, np.exp(logs).tolist(), strict=True))

    def cost(logs: Array) -> float:
        found = data.likelihood(relative(logs))
        return BELOW if found is None else -found.profiled

    best = np.empty(0)
    if names:
        points = np.log(
            np.stack(np.meshgrid(*(grids[x] for x in names)), axis=-1).reshape(
                -1, len(names)
            )
        )
        if len(points) > 60:  # noqa: PLR2004 - of three parameters a third
            points = points[::3]
        best = _search(cost, min(points, key=cost))
    found = data.likelihood(relative(best))
    if found is None:
        raise ArithmeticError("no noise model has a likelihood for this record")
    size = sqrt(found.scale)
    values = {
        name: value if name == TIME else value * size
        for name, value in relative(best).items()
    }
    k = len(values)
    return NoiseFit(
        model=model,
        values=values,
        log_likelihood=found.profiled,
        bic=-2.0 * found.profiled + k * log(data.number),
        mean=found.fit,
        mean_uncertainty=np.sqrt(np.diag(found.covariance) * found.scale),
        data=data,
    )


def fit_models(
    data: BlockMeans | Runs, models: Sequence[str] = tuple(MODELS)
) -> list[NoiseFit]:
    """Return models by their BIC, the least first."""
    return sorted((fit_noise(data, one) for one in models), key=lambda one: one.bic)


def profile_interval(
    fit: NoiseFit, name: str, quantile: float = AT_95
) -> tuple[float, float]:
    """Return the profile interval of a value; 0 or inf where it has no end."""
    profile = LikelihoodProfile(fit, name)
    return profile.end(-1, quantile), profile.end(1, quantile)


def slow_interval(
    fit: NoiseFit, quantile: float = AT_95
) -> tuple[float, tuple[float, float]]:
    """Return sigma sqrt(2/tau) of a Gauss-Markov process, and its profile interval.

    What is known of one too slow for its time to be told: a random walk of so much
    [unit/sqrt(s)].
    """
    values = {name: x for name, x in fit.values.items() if name != SIGMA}
    values[SLOW] = fit.values[SIGMA] * sqrt(2.0 / fit.values[TIME])
    same = replace(fit, values=values)
    return values[SLOW], profile_interval(same, SLOW, quantile)


def allan_variance(values: Mapping[str, float], times: Array, longest: float) -> Array:
    """Return the Allan variance of a model, by process summed, shape (n,) [unit^2].

    N^2/t + K^2 t/3, of a Gauss-Markov process (2 s^2 T/t) (1 - (T/2t)(3 - 4 e^(-t/T)
    + e^(-2t/T))) (IEEE Std 952-2020, annex C), of flicker the sum of such ones.

    Parameters
    ----------
    values : mapping of str to float
        By parameter.
    times : ndarray, shape (n,)
        Averaging times [s].
    longest : float
        Correlation time up to which flicker has components [s].
    """
    t = np.asarray(times, dtype=float)
    found = values.get(WHITE, 0.0) ** 2 / t + values.get(WALK, 0.0) ** 2 * t / 3.0
    if TIME in values:
        found = found + _markov(values[SIGMA], values[TIME], t)
    if FLICKER in values:
        time = float(t.min()) / RATIO
        while time <= longest:
            found = found + _markov(values[FLICKER] * sqrt(SHAPE), time, t)
            time *= RATIO
    return np.asarray(found)


def spectral_density(values: Mapping[str, float], frequencies: Array) -> Array:
    """Return the one-sided power spectral density of a model, (n,) [unit^2/Hz].

    2 N^2, 2 K^2/w^2, of a Gauss-Markov process 4 s^2 T/(1 + w^2 T^2), of flicker
    B^2/(pi f), w = 2 pi f (IEEE Std 952-2020, annex C, whose densities are two-sided).

    Parameters
    ----------
    values : mapping of str to float
        By parameter.
    frequencies : ndarray, shape (n,)
        Above 0 [Hz].
    """
    f = np.asarray(frequencies, dtype=float)
    w = 2.0 * np.pi * f
    found = 2.0 * values.get(WHITE, 0.0) ** 2 + 2.0 * (values.get(WALK, 0.0) / w) ** 2
    found = found + values.get(FLICKER, 0.0) ** 2 / (np.pi * f)
    if TIME in values:
        time = values[TIME]
        found = found + 4.0 * values[SIGMA] ** 2 * time / (1.0 + (w * time) ** 2)
    return np.asarray(found)


def _markov(sigma: float, time: float, t: Array) -> Array:
    """Return the Allan variance of a Gauss-Markov process, shape (n,) [unit^2]."""
    x = t / time
    exact = (
        2.0
        * sigma**2
        / x
        * (1.0 - (3.0 - 4.0 * np.exp(-x) + np.exp(-2.0 * x)) / (2.0 * x))
    )
    return np.where(x > 1e-4, exact, 2.0 * sigma**2 * x / 3.0)  # noqa: PLR2004


def upper_bound(fit: NoiseFit, name: str, quantile: float = ONE_SIDED_95) -> float:
    """Return the bound of a line beside a model that has it not, at 95 % [its unit].

    From its value of the largest likelihood up, which is mostly 0.
    """
    D = fit.data.block
    floor = fit.values[WHITE] * {WALK: 1e-4 / D, FLICKER: 1e-3 / sqrt(D)}[name]
    with_it = LikelihoodProfile(fit, name)
    at, step = log(floor), log(4.0)
    top = -with_it.cost(at)
    wanted, places = sqrt(quantile), [(0.0, at)]
    for _ in range(STEPS):
        at += step
        value = -with_it.cost(at)
        top = max(top, value)
        root = sqrt(2.0 * (top - value))
        if root >= wanted:
            places.append((root, at))
            break
        places = [(root, at)]
    else:
        return inf
    # The root of what is short is nearly as the value, or its square.
    (low, a), (high, b) = places
    for _ in range(STEPS):
        part = log((wanted - low) / (high - low) * (exp(b - a) - 1.0) + 1.0) / (b - a)
        at = a + min(max(part, 0.05), 0.95) * (b - a)
        root = sqrt(max(2.0 * (top + with_it.cost(at)), 0.0))
        if abs(root**2 - quantile) < CLOSE or b - a < CLOSE:
            return exp(at)
        (low, a), (high, b) = (
            ((root, at), (high, b)) if root < wanted else ((low, a), (root, at))
        )
    return exp(at)


class LikelihoodProfile:
    """The likelihood of a model over the logarithm of one of its values."""

    def __init__(self, fit: NoiseFit, name: str) -> None:
        """Begin at the largest likelihood, for a line that is in it or is not."""
        self.fit, self.name = fit, name
        values = dict(fit.values)
        self.others = [one for one in values if one != name]
        self.at = np.log([values[one] for one in self.others])

    def cost(self, place: float) -> float:
        """Return -l at the best of all others; the place is ln of the value."""

        def of(logs: Array) -> float:
            own = dict(zip(self.others, np.exp(logs).tolist(), strict=True))
            found = self.fit.data.likelihood(own | {self.name: exp(place)})
            return BELOW if found is None else -found.log_likelihood

        best = _search(of, self.at, step=0.1, close=NUISANCE)
        value = of(best)
        if value < BELOW:
            self.at = best
        return value

    def root(self, place: float) -> float:
        """Return the root of twice what the profile is short of its top there."""
        short = 2.0 * (self.fit.log_likelihood + self.cost(place))
        return sqrt(max(short, 0.0)) if short < BELOW else inf

    def end(self, side: int, quantile: float) -> float:
        """Return where the profile is short by a quantile of 2 l, below or above."""
        start = log(self.fit.values[self.name])
        self.at = np.log([self.fit.values[one] for one in self.others])
        # The signed root of twice what is short is nearly linear in the logarithm.
        wanted = sqrt(quantile)
        ends = [(0.0, start)]
        step = 0.1
        for _ in range(STEPS):
            place = ends[-1][1] + side * step
            root = self.root(place)
            ends.append((root, place))
            if root >= wanted:
                break
            if abs(place - start) > log(1e4):
                return 0.0 if side < 0 else inf
            gained = root - ends[-2][0]
            step = (
                min(max((wanted - root) * step / gained * 1.05, 0.3 * step), 3.0 * step)
                if gained > 0.0
                else 3.0 * step
            )
        (low, a), (high, b) = ends[-2:]
        for _ in range(STEPS):
            part = (wanted - low) / (high - low) if high < inf else 0.5
            place = a + min(max(part, 0.02), 0.98) * (b - a)
            root = self.root(place)
            if abs(root**2 - quantile) < CLOSE or abs(b - a) < CLOSE:
                return exp(place)
            if root < wanted:
                low, a = root, place
            else:
                high, b = root, place
        return exp(0.5 * (a + b))


def _search(
    cost: Callable[[Array], float],
    start: Array,
    *,
    step: float = 0.3,
    close: float = TOLD,
) -> Array:
    """Return where a function of a few logarithms is least, by a simplex."""
    from scipy.optimize import minimize

    if not start.size:
        return start
    simplex = start + np.concatenate(
        [np.zeros((1, start.size)), step * np.eye(start.size)]
    )
    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        options={"xatol": close, "fatol": min(close, 1e-4), "initial_simplex": simplex},
    )
    return np.asarray(found.x)
