"""Figures of one triad that filters and simulators ask for, from its data sheet.

White noise of density N, and of a sample sigma_s at the rate f:
N^2 + sigma_s^2/f. A drift of the bias as the random walk that it is, K, and as the one
that a Gauss-Markov process of sigma and T looks like over times well below T,
sqrt(K^2 + 2 sigma^2/T): the increments of a first-order Gauss-Markov process have the
variance 2 sigma^2 (1 - e^(-t/T)), so 2 sigma^2 t/T where t << T. No filter here has the
flicker noise of an Allan minimum: a Gauss-Markov process of sigma = B stands for it, of
the correlation time that is assumed elsewhere, and the steps say so. Constants are the
root sum square of the lines that shift a parameter; or what a calibration leaves of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.inputs.specification import CORRELATION_TIME
from budget.model.source import Offset
from budget.model.sources import (
    BAND,
    FLICKER,
    GYRO,
    SAMPLE_NOISE,
    lines_of,
    source_of,
    walk_of,
)
from budget.model.sources.power import Power
from budget.model.sources.processes import FlickerNoise, Stability, Walk
from budget.names import AXES, PARAMETERS, Name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from budget.arrays import Array
    from budget.inputs.records import ErrorLine, Sensor
    from budget.model.source import Effect
    from budget.results import Budget, FilledLine


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One figure of a triad.

    Attributes
    ----------
    value : ndarray, shape (n_axes,)
        [SI].
    axes : tuple of str
        AXES or ANGLES.
    symbol : str
        How formulas call it.
    lines : tuple of str
        Lines of the data sheet that it is made of.
    steps : tuple of str
        Where it is from and how it is made, for people.
    power : int
        Of a standard deviation in it: what multiplies one acts so often.
    kind : str
        Whose figure it is; '' until it is asked for.
    """

    value: Array
    axes: tuple[str, ...] = AXES
    symbol: str
    lines: tuple[str, ...]
    steps: tuple[str, ...]
    power: int = 1
    kind: str = ""

    @property
    def names(self) -> tuple[Name, ...]:
        """The full names of its lines."""
        return tuple(Name(line, owner=self.kind) for line in self.lines)


@dataclass(frozen=True, kw_only=True)
class Missing:
    """A figure that is not known: what would have to be given for it."""

    needs: str  # 'gyro.bias_stability'
    why: str = "not given"
    axes: tuple[str, ...] = AXES
    kind: str = ""  # as of a figure


@dataclass(frozen=True, kw_only=True)
class KnownFigures:
    """What is known of one triad.

    Attributes
    ----------
    sensor : Sensor
    rate : float or None
        Samples in a second [Hz].
    left : Budget or None
        What a calibration leaves, in place of the raw constants.
    procedure : str
        Name of that calibration.
    filled : mapping of Name to FilledLine
        Lines that the device does not give and something stands for.
    """

    sensor: Sensor
    rate: float | None = None
    left: Budget | None = None
    procedure: str = ""
    filled: Mapping[Name, FilledLine] = field(default_factory=dict)
    _found: dict[str, Figure | Missing] = field(default_factory=dict, repr=False)

    def figure(self, quantity: str) -> Figure | Missing:
        """Return one of QUANTITIES."""
        if quantity not in self._found:
            found = QUANTITIES[quantity](self)
            self._found[quantity] = replace(found, kind=self.sensor.kind)
        return self._found[quantity]

    def __getitem__(self, quantity: str) -> Figure | Missing:
        """Return what a template calls `gyro.noise`."""
        return self.figure(quantity)

    def name(self, line: str) -> Name:
        """Return the full name of a line."""
        return Name(line, owner=self.sensor.kind)


def print_number(value: float) -> str:
    """Print a number for comments."""
    return f"{value:.6g}"


def print_values(values: Array) -> str:
    """Print the values of all axes, one where they are equal."""
    texts = dict.fromkeys(map(print_number, values.tolist()))
    return (
        ", ".join(map(print_number, values.tolist())) if len(texts) > 1 else min(texts)
    )


def origin(known: KnownFigures, line: ErrorLine) -> str:
    """Say what a line is and where it is printed."""
    if told := known.filled.get(known.name(line.name)):
        return f"{known.name(line.name)}: {told.words}"
    said = [line.meaning, line.density, line.definition, line.condition, line.source]
    words = "; ".join(dict.fromkeys(text for text in said if text))
    return f"{known.name(line.name)}: {line.printed} ({words})"


def _noise(known: KnownFigures) -> Figure | Missing:
    """Return the density of white noise [SI unit/sqrt(Hz)], two-sided."""
    kind = known.sensor.kind
    walk = known.sensor.line(walk_of(kind))
    noise = known.sensor.line(SAMPLE_NOISE)
    if walk is None and noise is None:
        needs = f"{known.name(walk_of(kind))} or {known.name(SAMPLE_NOISE)}"
        return Missing(needs=needs)
    if noise is not None and noise.form != BAND and known.rate is None:
        needs = f"--rate HZ, as {known.name(SAMPLE_NOISE)} counts by the sample"
        return Missing(needs=needs)
    square = np.zeros(len(AXES))
    steps = []
    if walk is not None:
        square = square + walk.u**2
        steps.append(origin(known, walk))
    if noise is not None and noise.form == BAND:
        square = square + noise.u**2
        steps.append(origin(known, noise))
    elif noise is not None and known.rate is not None:
        square = square + noise.u**2 / known.rate
        steps.append(f"{origin(known, noise)}, over sqrt(f)")
    value = np.sqrt(square)
    unit = _unit(kind, "/sqrt(Hz)")
    steps.append(f"N = {print_values(value)} {unit}, two-sided")
    given = [line.name for line in (walk, noise) if line is not None]
    return Figure(value=value, symbol="N", lines=tuple(given), steps=tuple(steps))


def _name_of(kind: str, effect: Effect) -> str:
    """Return the line of a sensor that has that effect."""
    return next(one.name for one in lines_of(kind) if one.effect == effect)


def _walk(known: KnownFigures) -> Figure | Missing:
    """Return the random walk of the bias [SI unit/s/sqrt(Hz)]."""
    walk = _name_of(known.sensor.kind, Walk())
    line = known.sensor.line(walk)
    if line is None:
        return Missing(needs=known.name(walk))
    unit = _unit(known.sensor.kind, "/s/sqrt(Hz)")
    return Figure(
        value=line.u,
        symbol="K",
        lines=(line.name,),
        steps=(origin(known, line), f"K = {print_values(line.u)} {unit}"),
    )


def _quadratic(known: KnownFigures) -> Figure | Missing:
    """Return K2, the coefficient of the square of the input [1/SI unit]."""
    name = _name_of(known.sensor.kind, Power(2))
    line = known.sensor.line(name)
    if line is None:
        return Missing(needs=known.name(name))
    per = "s/rad" if known.sensor.kind == GYRO else "s^2/m"
    said = f"K2 = {print_values(line.u)} {per}"
    steps = (origin(known, line), said)
    return Figure(value=line.u, symbol="K2", lines=(line.name,), steps=steps)


def _stability(known: KnownFigures) -> Figure | Missing:
    """Return sigma of the Gauss-Markov process [SI]."""
    name = _name_of(known.sensor.kind, Stability())
    line = known.sensor.line(name)
    if line is None:
        why = "not given"
        if known.sensor.line(_name_of(known.sensor.kind, FlickerNoise())) is not None:
            why += ", and flicker is no Gauss-Markov process"
        return Missing(needs=known.name(name), why=why)
    said = f"sigma = {print_values(line.u)} {_unit(known.sensor.kind)}"
    if line.form == FLICKER:
        said += ", the coefficient B of flicker noise, which a Gauss-Markov process "
        said += "stands for"
    return Figure(
        value=line.u,
        symbol="sigma",
        lines=(line.name,),
        steps=(origin(known, line), said),
    )


def _time(known: KnownFigures) -> Figure | Missing:
    """Return the correlation time of the Gauss-Markov process [s]."""
    name = known.name(_name_of(known.sensor.kind, Stability()))
    line = known.sensor.line(name.quantity)
    if line is None:
        return Missing(needs=name)
    value = line.correlation_time
    said = f"correlation time of {name}"
    if value is None:
        value = np.full(len(AXES), CORRELATION_TIME)
        said = f"assumed, as {name} is flicker noise, which has none"
    said = f"T = {print_values(value)} s, {said}"
    return Figure(value=value, symbol="T", lines=(line.name,), steps=(said,), power=0)


def _drift(known: KnownFigures) -> Figure | Missing:
    """Return the random walk that the drift of the bias looks like [.../s/sqrt(Hz)]."""
    walk, sigma, time = (
        known.figure(key) for key in ("walk", "stability", "correlation_time")
    )
    if isinstance(sigma, Missing) or isinstance(time, Missing):
        if isinstance(walk, Missing):
            why = sigma.why if isinstance(sigma, Missing) else walk.why
            stability = known.name(_name_of(known.sensor.kind, Stability()))
            needs = f"{stability} or {walk.needs}"
            return Missing(needs=needs, why=why)
        return walk
    unit = _unit(known.sensor.kind, "/s/sqrt(Hz)")
    square = 2.0 * sigma.value**2 / time.value
    steps = [*sigma.steps, *time.steps]
    lines = sigma.lines
    proxy = (
        "sigma sqrt(2/T): a random walk as proxy of the Gauss-Markov process, right "
        f"over times well below T = {print_values(time.value)} s"
    )
    if isinstance(walk, Missing):
        steps.append(f"K = {print_values(np.sqrt(square))} {unit} = {proxy}")
    else:
        square = square + walk.value**2
        steps += walk.steps
        steps.append(
            f"K' = {print_values(np.sqrt(square))} {unit}, root sum square of K and "
            + proxy
        )
        lines += walk.lines
    return Figure(
        value=np.sqrt(square),
        symbol="K" if isinstance(walk, Missing) else "K'",
        lines=lines,
        steps=tuple(steps),
    )


def _driving(known: KnownFigures) -> Figure | Missing:
    """Return the density of the noise that drives the process [SI/sqrt(s)]."""
    sigma, time = known.figure("stability"), known.figure("correlation_time")
    if isinstance(sigma, Missing) or isinstance(time, Missing):
        return sigma if isinstance(sigma, Missing) else time
    value = sigma.value * np.sqrt(2.0 / time.value)
    unit = _unit(known.sensor.kind, "/sqrt(s)")
    steps = (
        *sigma.steps,
        *time.steps,
        f"q = sigma sqrt(2/T) = {print_values(value)} {unit}, which drives the process",
    )
    return Figure(value=value, symbol="q", lines=sigma.lines, steps=steps)


def _memory(known: KnownFigures) -> Figure | Missing:
    """Return phi, what is left of the process after one sample [1]."""
    time = known.figure("correlation_time")
    if isinstance(time, Missing):
        return time
    if known.rate is None:
        return Missing(needs="--rate HZ")
    longest = float(np.max(time.value))
    phi = np.exp(-1.0 / (known.rate * np.full(len(AXES), longest)))
    said = f"phi = exp(-1/(f T)) = {print_number(float(phi[0]))}"
    steps = (*time.steps, said)
    return Figure(value=phi, symbol="phi", lines=time.lines, steps=steps, power=0)


def _step(known: KnownFigures) -> Figure | Missing:
    """Return what one sample adds to the process [SI]."""
    sigma, memory = known.figure("stability"), known.figure("memory")
    if isinstance(sigma, Missing) or isinstance(memory, Missing):
        return sigma if isinstance(sigma, Missing) else memory
    # 1 - phi^2 without the loss of digits that phi near 1 brings.
    with np.errstate(divide="ignore"):  # nothing is left of a fast one: phi is 0
        value = sigma.value * np.sqrt(-np.expm1(2.0 * np.log(memory.value)))
    said = f"w = sigma sqrt(1 - phi^2) = {print_values(value)}, of each sample"
    return Figure(
        value=value,
        symbol="w",
        lines=sigma.lines,
        steps=(*sigma.steps, *memory.steps, said),
    )


def _constant(parameter: str) -> Callable[[KnownFigures], Figure | Missing]:
    """Return what finds the spread of a parameter, raw or after a calibration."""

    def find(known: KnownFigures) -> Figure | Missing:
        axes = PARAMETERS[parameter]
        names = [Name(parameter, owner=known.sensor.kind, axis=axis) for axis in axes]
        raw = _raw(known, parameter)
        if known.left is None:
            return raw
        rows = {row.output.name: row for row in known.left.outputs}
        if not rows.keys() >= set(names):
            if isinstance(raw, Missing):
                return raw
            said = f"{known.procedure} does not find it: the raw figure"
            return Figure(
                value=raw.value,
                axes=axes,
                symbol=raw.symbol,
                lines=raw.lines,
                steps=(*raw.steps, said),
            )
        lacks = dict.fromkeys(
            name for one in names for name in rows[one].standard_uncertainty.why
        )
        if lacks:
            why = "not given, and would add to what is left"
            return Missing(needs=", ".join(lacks), why=why, axes=axes)
        value = np.array([rows[name].standard_uncertainty for name in names])
        first = rows[names[int(np.argmax(value))]].ranked[0]
        said = (
            f"{names[0].group}: u = {print_values(value)}"
            f"{_unit_of(known.sensor.kind, parameter)} left by {known.procedure} at "
            f"the next turn-on (law of propagation), most of it {first.source}"
        )
        lines = () if isinstance(raw, Missing) else raw.lines
        return Figure(value=value, axes=axes, symbol="u", lines=lines, steps=(said,))

    return find


def _raw(known: KnownFigures, parameter: str) -> Figure | Missing:
    """Return the root sum square of the lines that shift a parameter."""
    kind = known.sensor.kind
    lines = [
        line
        for line in known.sensor.lines
        for effect in (source_of(kind, line.name).meant(line).effect,)
        if isinstance(effect, Offset) and effect.target == parameter
    ]
    expected = _name_of(kind, Offset(parameter))
    if expected not in {line.name for line in lines}:
        return Missing(needs=known.name(expected), axes=PARAMETERS[parameter])
    value = np.sqrt(np.sum([line.u**2 for line in lines], axis=0))
    steps = [origin(known, line) for line in lines]
    sum_ = "" if len(lines) == 1 else ", root sum square"
    steps.append(f"u = {print_values(value)}{_unit_of(kind, parameter)}{sum_}")
    return Figure(
        value=value,
        axes=PARAMETERS[parameter],
        symbol="u",
        lines=tuple(line.name for line in lines),
        steps=tuple(steps),
    )


def _total_bias(known: KnownFigures) -> Figure | Missing:
    """Return the spread of the bias at the start: the constant with the process."""
    bias, sigma = known.figure("bias"), known.figure("stability")
    if isinstance(bias, Missing) or isinstance(sigma, Missing):
        return bias
    value = np.hypot(bias.value, sigma.value)
    unit = _unit(known.sensor.kind)
    said = f"u' = {print_values(value)} {unit}, root sum square of u and sigma"
    return Figure(
        value=value,
        symbol="u'",
        lines=(*bias.lines, *sigma.lines),
        steps=(*bias.steps, *sigma.steps, said),
    )


def _unit(kind: str, per: str = "") -> str:
    """Return the SI unit of what a triad reads."""
    return ("rad/s" if kind == GYRO else "m/s^2") + per


def _unit_of(kind: str, parameter: str) -> str:
    """Return the SI unit of a parameter, after a blank; a ratio has none."""
    units = {"scale_factor": "", "mounting_angle": " rad"}
    return units.get(parameter, f" {_unit(kind)}")


QUANTITIES: Mapping[str, Callable[[KnownFigures], Figure | Missing]] = {
    "noise": _noise,
    "walk": _walk,
    "drift": _drift,
    "stability": _stability,
    "correlation_time": _time,
    "driving": _driving,
    "memory": _memory,
    "step": _step,
    "quadratic": _quadratic,
    "bias": _constant("bias"),
    "total_bias": _total_bias,
    "scale_factor": _constant("scale_factor"),
    "mounting_angle": _constant("mounting_angle"),
}
