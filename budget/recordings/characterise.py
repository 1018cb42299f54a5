"""Recordings at rest to figures of noise: read, fitted axis by axis, put together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.inputs import load_procedure
from budget.inputs.windows import FACES
from budget.language import term
from budget.methods.execution import in_order, local_executor
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS, source_of
from budget.names import AXES
from budget.recordings.columns import CHANNELS, COUNTS
from budget.recordings.log import SAME_RATE, read_logs
from budget.recordings.noise import (
    LEAST_BLOCKS,
    REFUSED,
    TWO_SIDED,
    UPPER,
    noise_of,
)
from budget.recordings.records import (
    AllanRow,
    Characterisation,
    NoiseCandidate,
    NoiseLine,
    NoiseModels,
    PeriodicLine,
    RecordedChannel,
    RecordedConditions,
    RecordHealth,
    SpectrumRow,
)
from budget.results import numbered_files
from budget.sentences import sentence
from budget.settings import Engine, Inputs, RecordingSettings, asking
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import Recording
    from budget.recordings.log import Log
    from budget.recordings.noise import FittedNoise, FittedValue
    from budget.results import InputFile

TIME_LINE, NOMINAL = "bias_stability.correlation_time", "nominal.bias"
REPEATABILITY, CHANGE = "R", "C"
# By parameter: the line of a device file, and its value over the parameter.
FIGURES: Mapping[str, tuple[str, float]] = {
    "N": ("angle_random_walk", 1.0),
    "K": ("rate_random_walk", 1.0),
    "sigma": ("bias_stability", 1.0),
    "tau": (TIME_LINE, 1.0),
    "B": ("flicker", 1.0),
    "Q": ("quantization", sqrt(12.0)),
    REPEATABILITY: ("bias_repeatability", 1.0),
    CHANGE: ("bias_temperature_coefficient", 1.0),
}
# What an accelerometer has in the place of a line of a gyro.
OF_ACCELERATION = {
    "angle_random_walk": "velocity_random_walk",
    "rate_random_walk": "acceleration_random_walk",
}
# A noise per root of hertz could be one-sided: this is not.
UNITS = {"velocity_random_walk": "m/s/sqrt(h)", TIME_LINE: "s"}
IN_COUNTS = {
    "N": "counts sqrt(s)",
    "K": "counts/sqrt(s)",
    "tau": "s",
    "Q": "counts s",
    CHANGE: "counts/degC",
}
MODEL_NAMES = {
    "white": term("white noise alone"),
    "rw": term("random walk"),
    "gm": term("Gauss-Markov"),
    "flicker": term("flicker"),
    "gm+rw": term("Gauss-Markov with random walk"),
    "flicker+rw": term("flicker with random walk"),
}
EIGHTHS = 8
LOUDER = 5.0  # standard uncertainties of a level, from which one is named
LEAST_CHANGE = 2.0  # standard uncertainties of a change with temperature
ONE_SIDED = 1.644854  # of the normal distribution, 95 %
LEAST_LEAK = 0.01  # of N, by lines, from which they are named
MOST_NAMED = 3  # lines


@dataclass(frozen=True, kw_only=True)
class Rest:
    """What a unit at rest is put in: by sensor the axes, and what is not known of them.

    The azimuth is not: an axis that is level has a part of the horizontal earth rate,
    of standard uncertainty w cos L/sqrt 2.
    """

    inputs: Mapping[str, Array]  # [rad/s, m/s^2]
    unknown: Mapping[str, Array]


@asking("characterise")
def characterise(
    *logs: Recording | File,
    recorded: RecordingSettings,
    attitude: str | None = None,
    inputs: Inputs,
    engine: Engine,
) -> Characterisation:
    """Find figures of noise in recordings of one device at rest, one for each turn-on.

    Parameters
    ----------
    *logs : str, Path or Recording
        Recordings, or recording files (YAML) that say what their columns are.
    attitude : str, optional
        How the unit rested, 'z up' or 'x down': with it and the place of a procedure
        the mean less the input is the bias.

    Returns
    -------
    Characterisation

    Raises
    ------
    CallError
        The recordings do not belong together, or nothing says how fast they are; the
        attitude is none, or no procedure says where it was; or one says it of none.
    SpecError
        Everything that is wrong with a file, each at its line.
    """
    if not logs:
        raise CallError("no recording is given; name the file of one")
    if attitude is None and inputs.procedure is not None:
        raise CallError(
            "a procedure says at what place a bias is found, of which there is none "
            "without --attitude; add it, or leave --procedure out"
        )
    rest = None if attitude is None else _rest(attitude, inputs)
    recordings = recorded.load(*logs)
    runs = _read(recordings, engine)
    channels = _channels(recordings, runs)
    tasks = [
        (
            name,
            [_alone(log, name) for own in runs for log in own if name in log.channels],
        )
        for name in channels
    ]
    step = engine.stage("fit of noise")
    found: list[FittedNoise] = []
    with local_executor(min(engine.workers, len(tasks))) as pool:
        each = in_order(_fitted, tasks, engine.executor or pool, ahead=len(tasks))
        for one in each:
            found.append(one)
            if step:
                step(len(found), len(tasks))
    fitted = dict(zip(channels, found, strict=True))
    return _put_together(recordings, runs, fitted, rest)


def _rest(attitude: str, inputs: Inputs) -> Rest:
    """Return the input of each axis of a unit at rest.

    Raises
    ------
    CallError
        The attitude is none, or no procedure says where it was.
    """
    words = attitude.casefold().split()
    if len(words) != len(("axis", "sense")) or " ".join(words) not in FACES:
        raise CallError(f"attitude is {attitude!r}, allowed: {', '.join(FACES)}")
    if inputs.procedure is None:
        raise CallError(
            "an attitude needs latitude and gravity of the place; name a procedure "
            "that has them (--procedure)"
        )
    place = load_procedure(inputs.procedure).place
    axis = AXES.index(words[0])
    up = np.zeros(len(AXES))
    up[axis] = 1.0 if words[1] == "up" else -1.0
    vertical = place.earth[2]
    level = np.where(up == 0.0, place.horizontal / sqrt(2.0), 0.0)
    return Rest(
        inputs={GYRO: vertical * up, ACCELEROMETER: place.gravity * up},
        unknown={GYRO: level, ACCELEROMETER: np.zeros(len(AXES))},
    )


def _read(recordings: Sequence[Recording], engine: Engine) -> list[tuple[Log, ...]]:
    """Read all recordings."""
    step = engine.stage("reading of recordings")
    found = []
    for k, one in enumerate(recordings):

        def told(part: float, k: int = k) -> None:
            if step:
                step(round(100.0 * (k + part)), 100 * len(recordings))

        found.append(read_logs(one, told))
    return found


def _channels(
    recordings: Sequence[Recording], runs: Sequence[tuple[Log, ...]]
) -> list[str]:
    """Return the channels, which all recordings have.

    Raises
    ------
    CallError
        They have different ones, or different rates or units.
    """
    by_run = [{x: log for log in own for x in log.channels} for own in runs]
    first = by_run[0]
    for recording, other in zip(recordings[1:], by_run[1:], strict=True):
        before = recordings[0].name
        if {*other} != {*first}:
            raise CallError(
                f"{recording.name} has the columns {', '.join(sorted(other))}, and "
                f"{before} {', '.join(sorted(first))}; turn-ons of one device have the "
                "same"
            )
        for name, log in other.items():
            if abs(log.rate / first[name].rate - 1.0) > SAME_RATE:
                raise CallError(
                    f"{recording.name} was sampled at {log.rate:.6g} Hz, and {before} "
                    f"at {first[name].rate:.6g} Hz; turn-ons of one device have one "
                    "rate"
                )
            if log.channels[name].has_counts != first[name].channels[name].has_counts:
                raise CallError(
                    f"{name} is in counts in one of {recording.name} and {before} "
                    "alone; give a gain for both"
                )
    return [name for name in CHANNELS if name in first]


def _alone(log: Log, name: str) -> Log:
    """Return a log with one channel, which is all that is sent to a worker."""
    return replace(log, channels={name: log.channels[name]})


def _fitted(task: tuple[str, Sequence[Log]]) -> FittedNoise:
    """Fit one axis.

    Raises
    ------
    CallError
        Nothing can be fitted.
    """
    name, logs = task
    try:
        return noise_of(name, logs)
    except ArithmeticError as error:
        raise CallError(
            f"{logs[0].name}: {name} {error}; skip the column (--columns with _ in "
            "its place), or give a longer recording"
        ) from None


# ---- what is said of it --------------------------------------------------------------


def _put_together(
    recordings: Sequence[Recording],
    runs: Sequence[tuple[Log, ...]],
    found: Mapping[str, FittedNoise],
    rest: Rest | None,
) -> Characterisation:
    """Return what has been found, in rows, and what has to be said of it."""
    health = tuple(
        _health(one, own, place, found)
        for place, (one, own) in enumerate(zip(recordings, runs, strict=True))
    )
    longest = max(log.duration for own in runs for log in own)
    lines: list[NoiseLine] = []
    for name, noise in found.items():
        in_counts = _has_counts(runs, name)
        lines += [
            _line(name, one, noise, longest, in_counts=in_counts)
            for one in noise.estimates
        ]
        lines += _more_lines(name, noise, in_counts=in_counts)
        if rest is not None and not in_counts:
            lines.append(_bias(name, noise, rest))
    return Characterisation(
        title=", ".join(one.name for one in recordings),
        environment=tuple(map(RecordedConditions.of, recordings)),
        inputs=_files(recordings, runs),
        lines=tuple(lines),
        models=tuple(_models(name, one) for name, one in found.items()),
        allan=tuple(
            row
            for name, one in found.items()
            for row in _allan(name, one, in_counts=_has_counts(runs, name))
        ),
        spectrum=tuple(x for name, one in found.items() for x in _spectrum(name, one)),
        records=health,
        assumptions=(
            sentence("recordings.at_rest"),
            *((sentence("recordings.level"),) if rest is not None else ()),
        ),
        warnings=tuple(dict.fromkeys(_warnings(runs, found, health))),
    )


def _files(
    recordings: Sequence[Recording], runs: Sequence[tuple[Log, ...]]
) -> tuple[InputFile, ...]:
    """Return the files that were read; several are numbered."""
    every = [
        pair
        for one, own in zip(recordings, runs, strict=True)
        for pair in (
            *(((one.origin.file, one.origin.sha256),) if one.origin else ()),
            *(pair for log in own for pair in log.sha256),
        )
    ]
    return numbered_files("recording", [*dict.fromkeys(every)])


def _has_counts(runs: Sequence[tuple[Log, ...]], name: str) -> bool:
    """Whether a channel is in counts."""
    return any(log.channels[name].has_counts for log in runs[0] if name in log.channels)


def _unit(sensor: str, parameter: str, *, in_counts: bool) -> tuple[str, str, float]:
    """Return line, unit and size of a parameter: what it is over in its unit."""
    line, times = FIGURES[parameter]
    if sensor == ACCELEROMETER:
        line = OF_ACCELERATION.get(line, line)
    if in_counts:
        return line, IN_COUNTS.get(parameter, COUNTS), 1.0 / times
    unit = UNITS.get(line) or source_of(sensor, line).like(sensor)
    return line, unit, size_of(unit) / times


def _line(
    name: str, one: FittedValue, noise: FittedNoise, longest: float, *, in_counts: bool
) -> NoiseLine:
    """Return an estimate as a line."""
    sensor, _, axis = name.rpartition("_")
    line, unit, size = _unit(sensor, one.parameter, in_counts=in_counts)
    why = ""
    if one.bound == UPPER:
        why = sentence("recordings.bound")
    elif one.bound == REFUSED and one.needs > longest:
        why = sentence(
            "recordings.too_short",
            time=float(f"{one.value:.3g}"),
            needs=float(f"{one.needs:.3g}"),
            duration=longest,
        )
    elif one.bound == REFUSED:
        why = sentence("recordings.too_fast", time=one.value, block=noise.block)
    return NoiseLine(
        sensor=sensor,
        axis=axis,
        line=line,
        parameter=one.parameter,
        value=one.value,
        unit=unit,
        si_per_unit=size,
        standard_uncertainty=one.value * one.relative if one.relative else None,
        interval=one.interval,
        bound=one.bound,
        degrees_of_freedom=one.degrees_of_freedom,
        why=why,
    )


def _more_lines(
    name: str, noise: FittedNoise, *, in_counts: bool
) -> Iterator[NoiseLine]:
    """Yield repeatability and change with temperature, where a recording tells them."""
    sensor, _, axis = name.rpartition("_")

    def made(
        parameter: str,
        value: float,
        interval: tuple[float, float],
        nu: float | None,
        *,
        u: float | None = None,
        why: str = "",
    ) -> NoiseLine:
        line, unit, size = _unit(sensor, parameter, in_counts=in_counts)
        return NoiseLine(
            sensor=sensor,
            axis=axis,
            line=line,
            parameter=parameter,
            value=value,
            unit=unit,
            si_per_unit=size,
            standard_uncertainty=u,
            interval=interval,
            bound=UPPER if u is None else TWO_SIDED,
            degrees_of_freedom=nu,
            why=why,
        )

    if len(noise.means) > 1:
        value, interval, is_told = repeatability(noise.means)
        runs = len(noise.means)
        nu = runs - 1.0
        yield made(
            REPEATABILITY,
            value,
            interval,
            nu if is_told else None,
            u=value / sqrt(2.0 * nu) if is_told else None,
            why=sentence(
                "recordings.scatter" if is_told else "recordings.scatter_in_run",
                runs=runs,
            ),
        )
    if noise.temperature is not None:
        slope, u = noise.temperature
        size = abs(slope)
        if size > LEAST_CHANGE * u:
            reach = 1.959964 * u
            ends = (size - reach, size + reach)
            yield made(CHANGE, size, ends, max(0.5 * (size / u) ** 2, 1.0), u=u)
        else:
            most = size + ONE_SIDED * u
            why = sentence("recordings.bound")
            yield made(CHANGE, most, (0.0, most), None, why=why)


def _bias(name: str, noise: FittedNoise, rest: Rest) -> NoiseLine:
    """Return the bias: the mean of all runs, less the input."""
    sensor, _, axis = name.rpartition("_")
    place = AXES.index(axis)
    means, u = np.array(noise.means).T
    runs = len(means)
    square = float(np.mean(u**2)) / runs
    if runs > 1:
        square = max(square, float(np.var(means, ddof=1)) / runs)
    of_mean = sqrt(square)
    whole = hypot(of_mean, float(rest.unknown[sensor][place]))
    value = float(means.mean() - rest.inputs[sensor][place])
    _, unit, size = _unit(sensor, REPEATABILITY, in_counts=False)
    reach = 1.959964 * whole
    return NoiseLine(
        sensor=sensor,
        axis=axis,
        line=NOMINAL,
        parameter="b",
        value=value,
        unit=unit,
        si_per_unit=size,
        standard_uncertainty=whole,
        interval=(value - reach, value + reach),
        bound=TWO_SIDED,
        degrees_of_freedom=None,
    )


def repeatability(
    means: Sequence[tuple[float, float]],
) -> tuple[float, tuple[float, float], bool]:
    """Return the standard deviation from turn-on to turn-on, and its 95 % interval.

    s^2 of n means, less the mean square of what in-run noise puts there; the interval
    is that of chi-square with n - 1 degrees of freedom on s. Where nothing is left, the
    upper end, and False.

    Parameters
    ----------
    means : sequence of (float, float)
        Of each run, with standard uncertainties by its noise.
    """
    from scipy.stats import chi2

    values, u = np.array(means).T
    n = len(values)
    square = float(np.var(values, ddof=1))
    noise = float(np.mean(u**2))
    if square <= noise:
        bound = sqrt((n - 1) * square / float(chi2.ppf(0.05, n - 1)))
        return bound, (0.0, bound), False
    low, high = (
        sqrt(max((n - 1) * square / float(chi2.ppf(p, n - 1)) - noise, 0.0))
        for p in (0.975, 0.025)
    )
    return sqrt(square - noise), (low, high), True


def _models(name: str, noise: FittedNoise) -> NoiseModels:
    """Return the models of one axis."""
    sensor, _, axis = name.rpartition("_")
    least = noise.models[0][2]
    return NoiseModels(
        sensor=sensor,
        axis=axis,
        chosen=noise.chosen,
        not_told_apart=noise.not_told_apart,
        block=noise.block,
        candidates=tuple(
            NoiseCandidate(name=one, log_likelihood=l_R, bic=bic, delta=bic - least)
            for one, l_R, bic in noise.models
        ),
    )


def _allan(name: str, noise: FittedNoise, *, in_counts: bool) -> Iterator[AllanRow]:
    """Yield the Allan deviations of one axis."""
    sensor, _, axis = name.rpartition("_")
    _, unit, size = _unit(sensor, "sigma", in_counts=in_counts)
    for one in noise.curve:
        yield AllanRow(
            sensor=sensor,
            axis=axis,
            tau=one.tau,
            deviation=one.deviation,
            unit=unit,
            si_per_unit=size,
            edf=one.edf,
            interval_low=one.low,
            interval_high=one.high,
            model=one.model,
            white=one.white,
            slow=one.slow,
        )


def _spectrum(name: str, noise: FittedNoise) -> Iterator[SpectrumRow]:
    """Yield the spectrum of one axis over that of its model."""
    sensor, _, axis = name.rpartition("_")
    for frequency, ratio in noise.spectrum:
        yield SpectrumRow(sensor=sensor, axis=axis, frequency=frequency, ratio=ratio)


def _health(
    recording: Recording,
    own: Sequence[Log],
    place: int,
    found: Mapping[str, FittedNoise],
) -> RecordHealth:
    """Return the health of one recording."""
    channels, periodic = [], []
    for log in own:
        for name, channel in log.channels.items():
            sensor, _, axis = name.rpartition("_")
            _, unit, size = _unit(sensor, "sigma", in_counts=channel.has_counts)
            mean, u = found[name].means[place]
            channels.append(
                RecordedChannel(
                    sensor=sensor,
                    axis=axis,
                    unit=unit,
                    si_per_unit=size,
                    mean=mean,
                    mean_uncertainty=u,
                    stuck=channel.kept_out.stuck,
                    saturated=channel.kept_out.saturated,
                    outliers=channel.kept_out.outliers,
                    level=found[name].levels[place],
                )
            )
            periodic += [
                PeriodicLine(
                    sensor=sensor,
                    axis=axis,
                    unit=unit,
                    si_per_unit=size,
                    frequency=frequency,
                    amplitude=amplitude,
                )
                for frequency, amplitude in found[name].periodic[place]
            ]
    warm = [one.temperature for one in own if one.temperature is not None]
    first = own[0]
    return RecordHealth(
        name=recording.name,
        rows=first.rows,
        duration=first.duration,
        rate=first.rate,
        gaps=sum(log.gaps for log in own),
        missing=sum(log.missing for log in own),
        temperature=(
            (float(np.nanmin(warm[0])), float(np.nanmax(warm[0]))) if warm else ()
        ),
        channels=tuple(sorted(channels, key=_order)),
        periodic=tuple(sorted(periodic, key=_order)),
        skipped=tuple(head for log in own for head in log.skipped),
    )


def _order(one: RecordedChannel | PeriodicLine) -> tuple[int, int]:
    """Return the place of a channel among all."""
    return SENSORS.index(one.sensor), AXES.index(one.axis)


def _warnings(
    runs: Sequence[tuple[Log, ...]],
    found: Mapping[str, FittedNoise],
    health: Sequence[RecordHealth],
) -> Iterator[str]:
    """Yield what a reader has to know besides."""
    for own, record in zip(runs, health, strict=True):
        is_new = record is health[0] or record.skipped != health[0].skipped
        yield from _of_record(own, record, is_new=is_new)
    for name, noise in found.items():
        title = title_of(name)
        if noise.white_from:
            yield sentence("recordings.not_white", channel=title, time=noise.white_from)
        if noise.not_told_apart:
            yield sentence(
                "recordings.not_told",
                channel=title,
                chosen=MODEL_NAMES[noise.chosen],
                others=[MODEL_NAMES[one] for one in noise.not_told_apart],
            )
        yield from _louder(name, noise, runs, health)
        for record in health:
            yield from _periodic(name, noise, record)
    if len(health) == 1:
        yield sentence("recordings.one_turn_on")
    for sensor in SENSORS:
        if any(_has_counts(runs, x) for x in found if x.startswith(sensor)):
            yield sentence("recordings.counts", sensor=sensor)


def _of_stamps(name: str, log: Log) -> Iterator[str]:
    """Yield what is said of the stamps of a file."""
    if not log.has_stamps:
        yield sentence("recordings.no_stamps", name=name)
    if unit := log.likely_unit:
        yield sentence("recordings.stamps", name=name, rate=log.rate, unit=unit)


def _of_record(
    own: Sequence[Log], record: RecordHealth, *, is_new: bool
) -> Iterator[str]:
    """Yield what is said of one recording."""
    name = record.name
    for log in own:
        yield from _of_stamps(name, log)
        if log.gaps:
            yield sentence(
                "recordings.gaps",
                name=name,
                gaps=log.gaps,
                missing=log.missing,
                part=log.missing / log.samples,
            )
        for channel in log.channels.values():
            kept = channel.kept_out
            shown = {"name": name, "channel": title_of(channel.name)}
            if kept.stuck:
                yield sentence("recordings.stuck", **shown, number=kept.stuck)
            if kept.saturated:
                yield sentence("recordings.saturated", **shown, number=kept.saturated)
            if kept.outliers:
                yield sentence(
                    "recordings.outliers",
                    **shown,
                    number=kept.outliers,
                    first=kept.first[0][0],
                )
            yield from _uneven(name, log, channel.name)
        if log.samples < LEAST_BLOCKS * log.block:
            yield sentence("recordings.short", name=name)
    if record.skipped and is_new:
        yield sentence("recordings.skipped", name=name, heads=record.skipped)


def _uneven(name: str, log: Log, channel: str) -> Iterator[str]:
    """Say where one eighth of a recording is noisier than the others.

    By the mean square of differences of neighbouring blocks, white but for what is
    slow: of n of them its relative standard uncertainty is sqrt(3/n).
    """
    own = log.channels[channel]
    whole = own.counts == log.block
    y = np.where(whole, own.sums / np.maximum(own.counts, 1), np.nan)
    parts = np.array_split(np.diff(y) ** 2, EIGHTHS)
    if min(int(np.isfinite(one).sum()) for one in parts) < 2 * EIGHTHS:
        return
    levels = np.array([float(np.nanmean(one)) for one in parts])
    middle = float(np.median(levels))
    number = float(np.isfinite(parts[0]).sum())
    worst = int(levels.argmax())
    if middle > 0.0 and levels[worst] > middle * (1.0 + LOUDER * sqrt(3.0 / number)):
        yield sentence(
            "recordings.uneven",
            name=name,
            channel=title_of(channel),
            part=worst + 1,
            level=sqrt(levels[worst] / middle),
        )


def _louder(
    name: str,
    noise: FittedNoise,
    runs: Sequence[tuple[Log, ...]],
    health: Sequence[RecordHealth],
) -> Iterator[str]:
    """Name runs that are noisier than the others."""
    for place, level in enumerate(noise.levels):
        blocks = sum(
            int((log.channels[name].counts > 0).sum())
            for log in runs[place]
            if name in log.channels
        )
        if level**2 > 1.0 + LOUDER * sqrt(3.0 / max(blocks, 1)):
            yield sentence(
                "recordings.louder",
                name=health[place].name,
                channel=title_of(name),
                level=level,
            )


def _periodic(name: str, noise: FittedNoise, record: RecordHealth) -> Iterator[str]:
    """Name lines, and what they can add to N: A^2/(2 pi^2 f^2 D) of its square at most.

    A line of amplitude A moves a mean over D by A/(pi f D) at the most.
    """
    sensor, _, axis = name.rpartition("_")
    own = [one for one in record.periodic if (one.sensor, one.axis) == (sensor, axis)]
    if not own:
        return
    square = noise.white**2
    leak = sum(
        one.amplitude**2 / (2.0 * (pi * one.frequency) ** 2 * noise.block)
        for one in own
    )
    yield sentence(
        "recordings.periodic",
        name=record.name,
        channel=title_of(name),
        lines=[
            f"{one.frequency:.4g} Hz ({one.amplitude / one.si_per_unit:.2g} {one.unit})"
            for one in own[:MOST_NAMED]
        ],
        more=min(0.5 * leak / square, inf),
    )


def title_of(name: str) -> str:
    """Return 'gyro x' of 'gyro_x'."""
    return name.replace("_", " ")
