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
from functools import partial
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


@dataclass(kw_only=True, eq=False)
class Missing(Exception):  # noqa: N818 - a figure that is none
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

    def __getitem__(self, quantity: str) -> Figure | Missing:
        """Return one of QUANTITIES, as a template calls it: `gyro.noise`."""
        if quantity not in self._found:
            try:
                found: Figure | Missing = QUANTITIES[quantity](self)
            except Missing as missing:
                found = missing
            self._found[quantity] = replace(found, kind=self.sensor.kind)
        return self._found[quantity]

    def figure(self, quantity: str) -> Figure:
        """Return one of QUANTITIES; raises Missing."""
        found = self[quantity]
        if isinstance(found, Missing):
            raise found
        return found

    def name(self, line: str) -> Name:
        """Return the full name of a line."""
        return Name(line, owner=self.sensor.kind)

    def unit(self, per: str = "") -> str:
        """Return the SI unit of what the triad reads, per something."""
        return ("rad/s" if self.sensor.kind == GYRO else "m/s^2") + per

    def name_of(self, effect: Effect) -> str:
        """Return the line of the triad that has that effect."""
        lines = lines_of(self.sensor.kind)
        return next(one.name for one in lines if one.effect == effect)

    def line_of(self, effect: Effect, why: str = "not given") -> ErrorLine:
        """Return what is given of the line that has that effect; raises Missing."""
        name = self.name_of(effect)
        line = self.sensor.line(name)
        if line is None:
            raise Missing(needs=self.name(name), why=why)
        return line

    def origin(self, line: ErrorLine) -> str:
        """Say what a line is and where it is printed."""
        name = self.name(line.name)
        if told := self.filled.get(name):
            return f"{name}: {told.words}"
        said = [
            *(line.meaning, line.density, line.definition),
            *(line.condition, line.source),
        ]
        words = "; ".join(dict.fromkeys(text for text in said if text))
        return f"{name}: {line.printed} ({words})"


def print_number(value: float) -> str:
    """Print a number for comments."""
    return f"{value:.6g}"


def print_values(values: Array) -> str:
    """Print the values of all axes, one where they are equal."""
    texts = list(map(print_number, values.tolist()))
    return texts[0] if len({*texts}) == 1 else ", ".join(texts)


def _noise(known: KnownFigures) -> Figure:
    """Return the density of white noise [SI unit/sqrt(Hz)], two-sided."""
    names = (walk_of(known.sensor.kind), SAMPLE_NOISE)
    lines = [line for name in names if (line := known.sensor.line(name))]
    if not lines:
        raise Missing(needs=" or ".join(map(known.name, names)))
    square, steps = np.zeros(len(AXES)), []
    for line in lines:
        is_of_sample = line.name == SAMPLE_NOISE and line.form != BAND
        rate = known.rate if is_of_sample else 1.0
        if rate is None:
            needs = f"--rate HZ, as {known.name(line.name)} counts by the sample"
            raise Missing(needs=needs)
        square = square + line.u**2 / rate
        steps.append(known.origin(line) + ", over sqrt(f)" * is_of_sample)
    value = np.sqrt(square)
    steps.append(f"N = {print_values(value)} {known.unit('/sqrt(Hz)')}, two-sided")
    given = tuple(line.name for line in lines)
    return Figure(value=value, symbol="N", lines=given, steps=tuple(steps))


def _of_line(
    known: KnownFigures, line: ErrorLine, symbol: str, unit: str, more: str = ""
) -> Figure:
    """Return a line as the figure that it is."""
    steps = (known.origin(line), f"{symbol} = {print_values(line.u)} {unit}{more}")
    return Figure(value=line.u, symbol=symbol, lines=(line.name,), steps=steps)


def _walk(known: KnownFigures) -> Figure:
    """Return the random walk of the bias [SI unit/s/sqrt(Hz)]."""
    return _of_line(known, known.line_of(Walk()), "K", known.unit("/s/sqrt(Hz)"))


def _quadratic(known: KnownFigures) -> Figure:
    """Return K2, the coefficient of the square of the input [1/SI unit]."""
    per = "s/rad" if known.sensor.kind == GYRO else "s^2/m"
    return _of_line(known, known.line_of(Power(2)), "K2", per)


def _stability(known: KnownFigures) -> Figure:
    """Return sigma of the Gauss-Markov process [SI]."""
    is_flicker = known.sensor.line(known.name_of(FlickerNoise())) is not None
    other = ", and flicker is no Gauss-Markov process" * is_flicker
    line = known.line_of(Stability(), f"not given{other}")
    stands = (
        ", the coefficient B of flicker noise, which a Gauss-Markov process stands for"
        if line.form == FLICKER
        else ""
    )
    return _of_line(known, line, "sigma", known.unit(), stands)


def _time(known: KnownFigures) -> Figure:
    """Return the correlation time of the Gauss-Markov process [s]."""
    line = known.line_of(Stability())
    name, value = known.name(line.name), line.correlation_time
    said = f"correlation time of {name}"
    if value is None:
        value = np.full(len(AXES), CORRELATION_TIME)
        said = f"assumed, as {name} is flicker noise, which has none"
    said = f"T = {print_values(value)} s, {said}"
    return Figure(value=value, symbol="T", lines=(line.name,), steps=(said,), power=0)


def _drift(known: KnownFigures) -> Figure:
    """Return the random walk that the drift of the bias looks like [.../s/sqrt(Hz)]."""
    walk, sigma, time = known["walk"], known["stability"], known["correlation_time"]
    if isinstance(sigma, Missing) or isinstance(time, Missing):
        if isinstance(walk, Figure):
            return walk
        first = sigma if isinstance(sigma, Missing) else walk
        needs = f"{known.name(known.name_of(Stability()))} or {walk.needs}"
        raise Missing(needs=needs, why=first.why)
    unit = known.unit("/s/sqrt(Hz)")
    square = 2.0 * sigma.value**2 / time.value
    lines, steps = sigma.lines, (*sigma.steps, *time.steps)
    symbol, sum_ = "K", ""
    if isinstance(walk, Figure):
        square = square + walk.value**2
        lines, steps = (*lines, *walk.lines), (*steps, *walk.steps)
        symbol, sum_ = "K'", "root sum square of K and "
    said = (
        f"{symbol} = {print_values(np.sqrt(square))} {unit}{', ' if sum_ else ' = '}"
        f"{sum_}sigma sqrt(2/T): a random walk as proxy of the Gauss-Markov process, "
        f"right over times well below T = {print_values(time.value)} s"
    )
    value = np.sqrt(square)
    return Figure(value=value, symbol=symbol, lines=lines, steps=(*steps, said))


def _driving(known: KnownFigures) -> Figure:
    """Return the density of the noise that drives the process [SI/sqrt(s)]."""
    sigma, time = known.figure("stability"), known.figure("correlation_time")
    value = sigma.value * np.sqrt(2.0 / time.value)
    shown = f"{print_values(value)} {known.unit('/sqrt(s)')}"
    said = f"q = sigma sqrt(2/T) = {shown}, which drives the process"
    steps = (*sigma.steps, *time.steps, said)
    return Figure(value=value, symbol="q", lines=sigma.lines, steps=steps)


def _memory(known: KnownFigures) -> Figure:
    """Return phi, what is left of the process after one sample [1]."""
    time = known.figure("correlation_time")
    if known.rate is None:
        raise Missing(needs="--rate HZ")
    phi = np.exp(-1.0 / (known.rate * np.full(len(AXES), float(np.max(time.value)))))
    steps = (*time.steps, f"phi = exp(-1/(f T)) = {print_number(float(phi[0]))}")
    return Figure(value=phi, symbol="phi", lines=time.lines, steps=steps, power=0)


def _step(known: KnownFigures) -> Figure:
    """Return what one sample adds to the process [SI]."""
    sigma, memory = known.figure("stability"), known.figure("memory")
    # 1 - phi^2 without the loss of digits that phi near 1 brings.
    with np.errstate(divide="ignore"):  # nothing is left of a fast one: phi is 0
        value = sigma.value * np.sqrt(-np.expm1(2.0 * np.log(memory.value)))
    said = f"w = sigma sqrt(1 - phi^2) = {print_values(value)}, of each sample"
    steps = (*sigma.steps, *memory.steps, said)
    return Figure(value=value, symbol="w", lines=sigma.lines, steps=steps)


def _constant(known: KnownFigures, parameter: str) -> Figure:
    """Return the spread of a parameter, raw or after a calibration."""
    axes = PARAMETERS[parameter]
    if known.left is None:
        return _raw(known, parameter)
    names = [Name(parameter, owner=known.sensor.kind, axis=axis) for axis in axes]
    rows = {row.output.name: row for row in known.left.outputs}
    if not rows.keys() >= {*names}:
        raw = _raw(known, parameter)
        said = f"{known.procedure} does not find it: the raw figure"
        return replace(raw, steps=(*raw.steps, said))
    lacks = dict.fromkeys(
        name for one in names for name in rows[one].standard_uncertainty.why
    )
    if lacks:
        why = "not given, and would add to what is left"
        raise Missing(needs=", ".join(lacks), why=why, axes=axes)
    value = np.array([rows[name].standard_uncertainty for name in names])
    first = rows[names[int(np.argmax(value))]].ranked[0]
    said = (
        f"{names[0].group}: u = {print_values(value)}{_unit_of(known, parameter)} left "
        f"by {known.procedure} at the next turn-on (law of propagation), most of it "
        f"{first.source}"
    )
    lines = tuple(line.name for line in _shifting(known, parameter))
    return Figure(value=value, axes=axes, symbol="u", lines=lines, steps=(said,))


def _shifting(known: KnownFigures, parameter: str) -> list[ErrorLine]:
    """Return the lines that shift a parameter; none where the expected one is not."""
    kind = known.sensor.kind
    lines = [
        line
        for line in known.sensor.lines
        for effect in (source_of(kind, line.name).meant(line).effect,)
        if isinstance(effect, Offset) and effect.target == parameter
    ]
    expected = known.name_of(Offset(parameter))
    return lines if expected in {line.name for line in lines} else []


def _raw(known: KnownFigures, parameter: str) -> Figure:
    """Return the root sum square of the lines that shift a parameter."""
    axes, lines = PARAMETERS[parameter], _shifting(known, parameter)
    if not lines:
        raise Missing(needs=known.name(known.name_of(Offset(parameter))), axes=axes)
    value = np.sqrt(np.sum([line.u**2 for line in lines], axis=0))
    sum_ = "" if len(lines) == 1 else ", root sum square"
    return Figure(
        value=value,
        axes=axes,
        symbol="u",
        lines=tuple(line.name for line in lines),
        steps=(
            *map(known.origin, lines),
            f"u = {print_values(value)}{_unit_of(known, parameter)}{sum_}",
        ),
    )


def _total_bias(known: KnownFigures) -> Figure:
    """Return the spread of the bias at the start: the constant with the process."""
    bias, sigma = known.figure("bias"), known["stability"]
    if isinstance(sigma, Missing):
        return bias
    value = np.hypot(bias.value, sigma.value)
    said = f"u' = {print_values(value)} {known.unit()}, root sum square of u and sigma"
    return Figure(
        value=value,
        symbol="u'",
        lines=(*bias.lines, *sigma.lines),
        steps=(*bias.steps, *sigma.steps, said),
    )


def _unit_of(known: KnownFigures, parameter: str) -> str:
    """Return the SI unit of a parameter, after a blank; a ratio has none."""
    units = {"scale_factor": "", "mounting_angle": " rad"}
    return units.get(parameter, f" {known.unit()}")


QUANTITIES: Mapping[str, Callable[[KnownFigures], Figure]] = {
    "noise": _noise,
    "walk": _walk,
    "drift": _drift,
    "stability": _stability,
    "correlation_time": _time,
    "driving": _driving,
    "memory": _memory,
    "step": _step,
    "quadratic": _quadratic,
    "total_bias": _total_bias,
    **{name: partial(_constant, parameter=name) for name in PARAMETERS},
}
