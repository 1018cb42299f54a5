"""Figures of noise of one axis: which model, which values, how sure, what is not told.

Models are fitted to means of blocks of a 4096th of the record by their exact restricted
likelihood, whatever the Allan curve looks like; the curve is its picture. What a record
is too short to tell is not told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, hypot, inf, isfinite, log, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.allan import WALK as ALPHA_WALK
from budget.methods.allan import WHITE as ALPHA_WHITE
from budget.methods.allan import allan_curve, interval_of
from budget.methods.noise_fit import (
    AT_68,
    AT_95,
    FLICKER,
    MODELS,
    NOT_TOLD,
    SIGMA,
    TIME,
    WALK,
    WHITE,
    BlockMeans,
    NoiseFit,
    Runs,
    allan_variance,
    fit_models,
    profile_interval,
    slow_interval,
    spectral_density,
    upper_bound,
)
from budget.recordings.log import FIRST_BLOCK, HEAD
from budget.recordings.periodic import (
    periodic_lines,
    residual_spectrum,
    welch_spectrum,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.arrays import Array
    from budget.methods.allan import AllanPoint
    from budget.recordings.log import Channel, Log

BLOCKS = 4096  # of the longest record
LEAST_BLOCKS = 1000  # of 10 samples: of a shorter record N alone is told
LEAST_FIT = 8  # blocks
THERE = 0.9  # part of a block's samples that have to be there [1]
FAST = 10.0  # blocks: a correlation time below is fitted to shorter ones, once [1]
FINER = 4
COARSER, LEAST_COARSE = 4, 256  # blocks of a bound; how many there are at the least
SHORTEST, LONGEST = 3.0, 0.1  # of a correlation time that is told: blocks, record [1]
ENOUGH = 50.0  # correlation times, of a record that tells them [1]
LITTLE = 0.1  # of an Allan variance, that is not of white noise [1]
OFF = 3.0  # standard uncertainties, from which the curve differs from the model [1]
LEVEL = 0.95
QUANTISATION = "Q"
TWO_SIDED, UPPER, REFUSED = "two-sided", "upper", "refused"


@dataclass(frozen=True, kw_only=True)
class FittedValue:
    """One parameter of one axis.

    Attributes
    ----------
    parameter : str
        'N', 'K', 'sigma', 'tau', 'B' or 'Q'.
    value : float
        [SI, or counts]; the bound of an upper one.
    interval : (float, float)
        At 95 %; 0 and the bound of an upper one.
    relative : float or None
        Standard uncertainty of its logarithm, of half the 68 % interval [1].
    bound : str
        'two-sided', 'upper' or 'refused'.
    needs : float
        How long a record would tell it [s]; 0 of what is told.
    """

    parameter: str
    value: float
    interval: tuple[float, float]
    relative: float | None = None
    bound: str = TWO_SIDED
    needs: float = 0.0

    @property
    def degrees_of_freedom(self) -> float | None:
        """1/(2 u_r^2) (JCGM 100, G.3), of what is told."""
        return None if not self.relative else max(0.5 / self.relative**2, 1.0)


@dataclass(frozen=True, kw_only=True)
class CurvePoint:
    """The Allan deviation over one averaging time, measured and of the model."""

    tau: float  # [s]
    deviation: float  # [SI, or counts]
    edf: float
    low: float  # interval at 95 %
    high: float
    model: float
    white: float  # of the model, by its white noise alone
    slow: float  # by what is slow in it


@dataclass(frozen=True, kw_only=True, eq=False)
class FittedNoise:
    """What the noise of one axis is.

    Attributes
    ----------
    channel : str
        'gyro_x'.
    models : tuple of (str, float, float)
        Name, log likelihood and BIC, the least BIC first.
    chosen : str
        The model whose values are told.
    block : float
        Length of the blocks that were fitted [s].
    estimates : tuple of FittedValue
    curve : tuple of CurvePoint
    white_from : float
        Averaging time below which it is not white [s]; 0 where it is.
    means : tuple of (float, float)
        Of each run, with standard uncertainties by the model [SI, or counts].
    temperature : (float, float) or None
        Change with temperature, and its standard uncertainty [SI/degC].
    levels : tuple of float
        Of each run, white noise over that of all [1].
    periodic : tuple of tuple of (float, float)
        Of each run, frequency [Hz] and amplitude [SI, or counts] of periodic lines.
    spectrum : tuple of (float, float)
        Frequency [Hz], and the spectrum of the first run over that of the model [1].
    """

    channel: str
    models: tuple[tuple[str, float, float], ...]
    chosen: str
    block: float
    estimates: tuple[FittedValue, ...]
    curve: tuple[CurvePoint, ...]
    white_from: float
    means: tuple[tuple[float, float], ...]
    temperature: tuple[float, float] | None
    levels: tuple[float, ...]
    periodic: tuple[tuple[tuple[float, float], ...], ...]
    spectrum: tuple[tuple[float, float], ...]

    @property
    def not_told_apart(self) -> tuple[str, ...]:
        """Other models that the record allows too."""
        least = self.models[0][2]
        return tuple(
            name
            for name, _, bic in self.models
            if name != self.chosen and bic - least < NOT_TOLD
        )

    @property
    def white(self) -> float:
        """N, or the bound of it; inf where there is none [SI sqrt(s), or counts]."""
        every = (one.value for one in self.estimates if one.parameter == WHITE)
        return next(every, inf)


def noise_of(channel: str, logs: Sequence[Log]) -> FittedNoise:
    """Fit the noise of one axis to all runs of it.

    Raises
    ------
    ArithmeticError
        It does not vary, or too little of it is there.
    """
    own = [(one, one.channels[channel]) for one in logs]
    dt = 1.0 / logs[0].rate
    base = max(one.block for one in logs)
    longest = max(one.samples for one in logs)
    is_short = longest < LEAST_BLOCKS * base
    size = base * max(-(-longest // (BLOCKS * base)), 1)
    models = ("white",) if is_short else tuple(MODELS)
    runs = block_means(own, size)
    fits = fit_models(runs, models)
    if fits[0].values.get(TIME, inf) < FAST * size * dt and size > base:
        size = max(size // FINER // base, 1) * base
        runs = block_means(own, size)
        fits = fit_models(runs, models)
    chosen, estimates = _estimates(fits, runs)
    curve = _curve(own, dt)
    if any(x.parameter == WHITE and x.bound == UPPER for x in estimates):
        chosen, estimates = _with_white_of(curve, chosen, estimates)
    # Where N is not told there is nothing to hold short times against.
    of_white = [x.relative for x in estimates if x.parameter == WHITE and x.relative]
    quantisation, white_from = (
        _below(curve, chosen, of_white[0], size) if of_white else (None, 0.0)
    )
    if quantisation is not None:
        estimates = (*estimates, quantisation)
    spectra = [welch_spectrum(channel.head, log_.rate) for log_, channel in own]
    steps = 0.0 if quantisation is None else quantisation.value

    def density(f: Array) -> Array:
        rounding = 8.0 * steps**2 / dt * np.sin(np.pi * f * dt) ** 2
        return spectral_density(chosen.values, f) + rounding

    return FittedNoise(
        channel=channel,
        models=tuple((one.model, one.log_likelihood, one.bic) for one in fits),
        chosen=chosen.model,
        block=size * dt,
        estimates=estimates,
        curve=tuple(_points(curve, chosen.values, longest * dt, quantisation)),
        white_from=white_from,
        means=_means(chosen, len(own)),
        temperature=_temperature(chosen, len(own)),
        levels=_levels(own, base),
        periodic=tuple(tuple(periodic_lines(x)) if x else () for x in spectra),
        spectrum=tuple(residual_spectrum(spectra[0], density)) if spectra[0] else (),
    )


def block_means(own: Sequence[tuple[Log, Channel]], size: int) -> Runs:
    """Return means of blocks of so many samples.

    Raises
    ------
    ArithmeticError
        There are too few, or all are equal.
    """
    found = []
    for log_, channel in own:
        dt = 1.0 / log_.rate
        sums, counts = (
            _gathered(one, size // log_.block) for one in (channel.sums, channel.counts)
        )
        y = np.full(len(sums), np.nan)
        is_there = counts >= THERE * size
        y[is_there] = sums[is_there] / counts[is_there]
        columns = [np.ones(len(y))]
        if log_.temperature is not None:
            known = np.isfinite(log_.temperature)
            warm, there = (
                _gathered(one, size // log_.block)
                for one in (np.where(known, log_.temperature, 0.0), known.astype(float))
            )
            warm /= np.maximum(there, 1.0)  # of what is there: a gap is no 0 degC
            if is_there.sum() > 1 and np.ptp(warm[is_there]) > 0.0:
                columns.append(warm - warm[is_there].mean())
        found.append(
            BlockMeans(y=y, X=np.stack(columns, axis=1), block=size * dt, sample=dt)
        )
    number = min(one.number for one in found)
    if number < LEAST_FIT:
        raise ArithmeticError(
            f"has {number} whole blocks of {size} samples, expected {LEAST_FIT} or more"
        )
    if any(np.nanmax(one.y) == np.nanmin(one.y) for one in found):
        raise ArithmeticError("does not vary: all its readings are equal")
    return Runs(tuple(found))


def _gathered(values: Array, number: int) -> Array:
    """Sum blocks, so many one after the other; a rest is left out."""
    n = len(values) // number
    return np.asarray(values[: n * number].reshape(n, number).sum(axis=1))


def _estimates(
    fits: Sequence[NoiseFit], runs: Runs
) -> tuple[NoiseFit, tuple[FittedValue, ...]]:
    """Return the model that is told, and its values with intervals and bounds."""
    chosen, refused = _told(fits, runs)
    found = [
        _two_sided(
            name, value, *(profile_interval(chosen, name, x) for x in (AT_95, AT_68))
        )
        for name, value in chosen.values.items()
        if refused is None or name not in {SIGMA, TIME}
    ]
    if refused is not None and TIME in chosen.values:
        (value, ends), (_, near) = (slow_interval(chosen, x) for x in (AT_95, AT_68))
        found.append(_two_sided(WALK, value, ends, near))
    there = {one.parameter for one in found}
    if refused is not None:
        found.append(refused)
    # What is slow is seen in longer blocks as well.
    times = max(min(COARSER, runs.number // LEAST_COARSE), 1)
    slower = replace(chosen, data=runs.coarser(times))
    for name in (WALK, FLICKER) if len(fits) > 1 else ():
        if name not in there and (name == WALK or TIME not in chosen.values):
            bound = upper_bound(slower, name)
            found.append(
                FittedValue(
                    parameter=name, value=bound, interval=(0.0, bound), bound=UPPER
                )
            )
    # Without an end a line is not given.
    return chosen, tuple(one for one in found if one.value < inf)


def _told(fits: Sequence[NoiseFit], runs: Runs) -> tuple[NoiseFit, FittedValue | None]:
    """Return the best model, and its correlation time if that is refused.

    One of a process too slow for its time stays, for what it is over the record: a
    random walk; beside another walk, or where it is too fast, the best without it.
    """
    best = fits[0]
    if TIME not in best.values:
        return best, None
    low, high = profile_interval(best, TIME)
    if SHORTEST * runs.block <= low and high <= LONGEST * runs.duration:
        return best, None
    time = best.values[TIME]
    refused = FittedValue(
        parameter=TIME,
        value=time,
        interval=(low, high),
        bound=REFUSED,
        needs=ENOUGH * time,
    )
    if best.model == "gm" and high > LONGEST * runs.duration:
        return best, refused
    return next(one for one in fits if TIME not in one.values), refused


def _two_sided(
    name: str, value: float, ends: tuple[float, float], near: tuple[float, float]
) -> FittedValue:
    """Return what is told of a parameter, of its intervals at 95 and 68 %.

    One that may be 0 is at most the upper end.
    """
    if ends[0] <= 0.0:
        return FittedValue(
            parameter=name, value=ends[1], interval=(0.0, ends[1]), bound=UPPER
        )
    is_closed = near[0] > 0.0 and isfinite(near[1])
    relative = 0.5 * log(near[1] / near[0]) if is_closed else 1.0 / sqrt(2.0)
    return FittedValue(parameter=name, value=value, interval=ends, relative=relative)


def _curve(
    own: Sequence[tuple[Log, Channel]], dt: float
) -> list[tuple[AllanPoint, float]]:
    """Return the Allan deviation at octaves, of several runs their mean square.

    Each with the degrees of freedom of all runs over those of the first.
    """
    found: dict[int, list[AllanPoint]] = {}
    for log_, channel in own:
        points = allan_curve(channel.head, dt)
        if log_.samples > HEAD:  # longer ones of blocks, which begin a block apart
            counts = channel.counts
            means = np.full(len(counts), np.nan)
            some = counts >= THERE * log_.block
            means[some] = channel.sums[some] / counts[some]
            blocks = allan_curve(means, dt * log_.block)
            last = HEAD // BLOCKS
            points = [one for one in points if one.samples <= last]
            points += [one for one in blocks if one.tau > last * dt]
        for one in points:
            found.setdefault(round(one.tau / dt), []).append(one)
    curve = []
    for points in found.values():
        weights = [one.terms for one in points]
        square = sum(
            w * one.deviation**2 for w, one in zip(weights, points, strict=True)
        )
        first = points[0]
        mean = sqrt(square / sum(weights))
        merged = replace(first, deviation=mean)
        curve.append((merged, sum(weights) / first.terms))
    return curve


def _with_white_of(
    curve: Sequence[tuple[AllanPoint, float]],
    chosen: NoiseFit,
    estimates: Sequence[FittedValue],
) -> tuple[NoiseFit, tuple[FittedValue, ...]]:
    """Take N from the Allan deviation over short times, as blocks do not show it.

    N^2 = t s^2(t) over some ten samples, less what is slow there, as sure as its
    degrees of freedom and that; where that is more than a tenth it stays a bound.
    """
    point, times = next(one for one in curve if 2 * one[0].samples > FIRST_BLOCK)
    tau = point.tau
    others = {**chosen.values, WHITE: 0.0}
    slow = float(allan_variance(others, np.array([tau]), tau * BLOCKS)[0])
    square = point.deviation**2
    if slow > LITTLE * square:
        return chosen, tuple(estimates)
    N = sqrt((square - slow) * tau)
    edf = point.edf(ALPHA_WHITE) * times
    of_slow = LITTLE * slow / (square - slow)  # which is known to a tenth itself
    relative = hypot(1.0 / sqrt(2.0 * edf), 0.5 * of_slow)
    reach = exp(1.959964 * relative)
    told = FittedValue(
        parameter=WHITE, value=N, interval=(N / reach, N * reach), relative=relative
    )
    found = tuple(told if one.parameter == WHITE else one for one in estimates)
    return replace(chosen, values={**chosen.values, WHITE: N}), found


def _points(
    curve: Sequence[tuple[AllanPoint, float]],
    values: Mapping[str, float],
    longest: float,
    quantisation: FittedValue | None,
) -> list[CurvePoint]:
    """Return the curve with intervals, by the slope of the model, beside the model."""
    taus = np.array([one.tau for one, _ in curve])
    model = allan_variance(values, taus, 4.0 * longest)
    slow = allan_variance({**values, WHITE: 0.0}, taus, 4.0 * longest)
    slope = np.gradient(np.log(model), np.log(taus)) if len(taus) > 1 else [-1.0]
    if quantisation is not None:
        model = model + 3.0 * quantisation.value**2 / taus**2
    found = []
    for k, (point, times) in enumerate(curve):
        alpha = max(ALPHA_WALK, min(ALPHA_WHITE, round(-float(slope[k])) - 1))
        edf = point.edf(alpha) * times
        low, high = interval_of(point.deviation, edf, LEVEL)
        found.append(
            CurvePoint(
                tau=point.tau,
                deviation=point.deviation,
                edf=edf,
                low=low,
                high=high,
                model=float(np.sqrt(model[k])),
                white=values[WHITE] / sqrt(point.tau),
                slow=float(np.sqrt(slow[k])),
            )
        )
    return found


def _below(
    curve: Sequence[tuple[AllanPoint, float]],
    chosen: NoiseFit,
    of_white: float,
    size: int,
) -> tuple[FittedValue | None, float]:
    """Hold the curve below a block against the model: quantisation, or not white.

    Rounding of increments adds 3 Q^2/tau^2: the excess over the model is that at one
    sample, and a quarter at two.
    """
    short = [(one, times) for one, times in curve if one.samples <= size]
    if not short:
        return None, 0.0
    taus = np.array([one.tau for one, _ in short])
    model = allan_variance(chosen.values, taus, taus[-1] * BLOCKS)
    square = np.array([one.deviation**2 for one, _ in short])
    edf = np.array([one.edf(ALPHA_WHITE) * times for one, times in short])
    # Of the deviation's square, and of the model by its white noise.
    u = square * np.sqrt(2.0 / edf + (2.0 * of_white) ** 2)
    excess = square - model
    is_off = np.abs(excess) > OFF * u
    if not is_off.any():
        return None, 0.0
    steps = excess * taus**2 / 3.0
    if excess[0] > OFF * u[0]:
        off = np.abs(steps - steps[0]) > OFF * u * taus**2 / 3.0
        if not off.any():
            spread = u[0] / excess[0] / 2.0  # relative, of Q
            q = sqrt(steps[0])
            reach = 1.959964 * spread
            told = FittedValue(
                parameter=QUANTISATION,
                value=q,
                interval=(q * np.exp(-reach), q * np.exp(reach)),
                relative=spread,
            )
            return told, 0.0
    return None, float(taus[np.flatnonzero(is_off)[-1]])


def _means(fit: NoiseFit, runs: int) -> tuple[tuple[float, float], ...]:
    """Return the mean of each run, and its standard uncertainty by the model."""
    wide = len(fit.mean) // runs
    return tuple(
        (float(fit.mean[k * wide]), float(fit.mean_uncertainty[k * wide]))
        for k in range(runs)
    )


def _temperature(fit: NoiseFit, runs: int) -> tuple[float, float] | None:
    """Return the change with temperature, of several runs weighed by 1/u^2."""
    wide = len(fit.mean) // runs
    if wide == 1 or wide * runs != len(fit.mean):
        return None
    values, u = fit.mean[1::wide], fit.mean_uncertainty[1::wide]
    weights = 1.0 / u**2
    return float(weights @ values / weights.sum()), float(weights.sum() ** -0.5)


def _levels(own: Sequence[tuple[Log, Channel]], base: int) -> tuple[float, ...]:
    """Return the white noise of each run over that of all, of neighbouring blocks."""
    if len(own) == 1:
        return (1.0,)
    found = []
    for log_, channel in own:
        sums, counts = (
            _gathered(one, base // log_.block) for one in (channel.sums, channel.counts)
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            y = np.where(counts >= THERE * base, sums / counts, np.nan)
        found.append(float(np.nanmean(np.diff(y) ** 2)))
    middle = float(np.median(found))
    return tuple(sqrt(one / middle) for one in found)
