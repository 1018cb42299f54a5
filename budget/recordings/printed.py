"""A data sheet beside what was measured of a unit: line by line, what is worse.

Of a value s with nu degrees of freedom and a printed sigma, nu (s/sigma)^2 is
chi-square with nu degrees of freedom where the unit is as printed (JCGM 100, G.3): its
upper tail is p, its quantiles give the interval of s/sigma.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.documents import Documented, written
from budget.errors import CallError
from budget.methods.noise_fit import SIGMA, TIME, WALK, WHITE, allan_variance
from budget.model.source import GYRO, Noise
from budget.model.sources import FLICKER, lines_of, source_of, walk_of
from budget.names import AXES
from budget.recordings.characterise import FIGURES, OF_ACCELERATION
from budget.results import input_files
from budget.ties import first_largest
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Device, ErrorLine, Sensor
    from budget.model.noise import InRun
    from budget.results import InputFile

# What a comparison comes to.
WITHIN, WORSE, OPEN = "within", "worse", "not_told"
NOT_PRINTED, NOT_MEASURED = "not_printed", "not_measured"
BIAS = ("bias_stability", FLICKER)
FLOOR, SPREAD = "allan_minimum", "sigma"  # what a bias stability is, in a file
LEVEL = 0.05  # probability that a unit as printed has a line that is found worse
LOWEST = 0.664  # of an Allan curve of flicker, over its coefficient: IEEE Std 952
HUMP = 1.89  # correlation times, where the Allan curve of a Markov process is largest
SHORTEST, LONGEST, TIMES = 0.1, 1e6, 600  # averaging times of a curve [s]


@written(
    "measured_line",
    """
    sensor: 'gyro' or 'accelerometer'
    axis: 'x', 'y' or 'z'
    line: as in a device file
    definition: of a bias stability, 'sigma' or 'allan_minimum'
    printed / unit or null [unit]: 1 sigma; null where the data sheet prints none
    measured / unit or null [unit]: null where it was not measured
    is_bound: whether it is no more than that, and no value
    unit: as printed
    ratio [1]: measured over printed
    interval_low = interval.0 or null [1]: of the ratio, at 95 %
    interval_high = interval.1 or null [1]
    degrees_of_freedom [1]: of what was measured
    p [1]: probability that a unit as printed is found as bad or worse
    standing: 'within', 'worse', 'not_told', 'not_printed' or 'not_measured'
    """,
)
@dataclass(frozen=True, kw_only=True)
class MeasuredLine(Documented):
    """One axis of one line, printed and measured."""

    sensor: str
    axis: str
    line: str
    definition: str = ""
    printed: float | None
    measured: float | None
    is_bound: bool = False
    unit: str
    si_per_unit: float
    ratio: float | None = None
    interval: tuple[float, ...] = ()
    degrees_of_freedom: float | None = None
    p: float | None = None
    standing: str = ""


@written(
    "measured",
    """
    title = first: names of both
    first: name of the data sheet
    second: name of what was measured
    inputs by role as file
    level [1]: below which p is found worse, 5 % over the lines that have one
    lines
    """,
    commands="diff",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class MeasuredUnit(Documented):
    """What was measured of a unit, beside its data sheet."""

    first: str
    second: str
    inputs: tuple[InputFile, ...]
    level: float
    lines: tuple[MeasuredLine, ...]

    @property
    def worse(self) -> tuple[MeasuredLine, ...]:
        """Lines that are worse than printed, the largest ratio first."""
        found = [one for one in self.lines if one.standing == WORSE]
        return tuple(sorted(found, key=lambda one: -(one.ratio or 0.0)))


@written(
    "lot_line",
    """
    sensor: 'gyro' or 'accelerometer'
    axis: 'x', 'y' or 'z'
    line: as in a device file
    definition: of a bias stability, 'sigma' or 'allan_minimum'
    printed / unit or null [unit]: 1 sigma; null where the data sheet prints none
    size / unit [unit]: root mean square of the units
    spread / unit [unit]: standard deviation of the units, less that of their values
    largest / unit [unit]
    largest_unit: of which unit it is
    unit: as printed
    ratio [1]: size over printed
    units: how many tell it
    worse (list[str]): units that are worse than printed
    """,
)
@dataclass(frozen=True, kw_only=True)
class LotLine(Documented):
    """One axis of one line, printed and of a lot."""

    sensor: str
    axis: str
    line: str
    definition: str
    printed: float | None
    size: float
    spread: float
    largest: float
    largest_unit: str
    unit: str
    si_per_unit: float
    ratio: float | None
    units: int
    worse: tuple[str, ...]


@written(
    "measured_lot",
    """
    first: name of the data sheet
    units (list[str]): names of the units
    inputs by role as file
    level [1]: below which p of a unit is found worse, 5 % over all that have one
    lines
    """,
    commands="diff",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class MeasuredLot(Documented):
    """What was measured of several units, beside their data sheet."""

    first: str
    units: tuple[str, ...]
    inputs: tuple[InputFile, ...]
    level: float
    lines: tuple[LotLine, ...]

    @property
    def worse(self) -> tuple[str, ...]:
        """Units of which some line is worse than printed."""
        bad = {unit for one in self.lines for unit in one.worse}
        return tuple(one for one in self.units if one in bad)


def is_measured(device: Device) -> bool:
    """Whether a device file is of recordings: of nothing but what these tell."""
    lines = [(one.kind, line) for one in device.sensors for line in one.lines]
    return any(line.degrees_of_freedom for _, line in lines) and all(
        line.name in _told(kind) for kind, line in lines
    )


def _told(kind: str) -> set[str]:
    """Return the lines that recordings tell of a sensor."""
    names = {line for line, _ in FIGURES.values()}
    return names if kind == GYRO else {OF_ACCELERATION.get(x, x) for x in names}


def beside_data_sheet(
    printed: Device, measured: Device, *, sample_rate: float
) -> MeasuredUnit:
    """Hold what was measured of a unit beside its data sheet.

    Parameters
    ----------
    printed, measured : Device
    sample_rate : float
        Of a noise that is printed by the sample [Hz].

    Returns
    -------
    MeasuredUnit
        Of what a recording can tell, sensor by sensor. A line is worse where p is below
        5 % over the number of those that have one (Bonferroni).

    Raises
    ------
    CallError
        They have no sensor in common.
    """
    rows = _beside(printed, measured, sample_rate)
    level = LEVEL / max(sum(row.p is not None for row in rows), 1)
    return MeasuredUnit(
        first=printed.name,
        second=measured.name,
        inputs=input_files([printed], measured=measured),
        level=level,
        lines=tuple(_standing(row, level) for row in rows),
    )


def lot_beside_data_sheet(
    printed: Device, units: Sequence[Device], *, sample_rate: float
) -> MeasuredLot:
    """Hold what was measured of several units beside their data sheet.

    Parameters
    ----------
    printed : Device
    units : sequence of Device
        Each measured.
    sample_rate : float
        Of a noise that is printed by the sample [Hz].

    Returns
    -------
    MeasuredLot
        Of lines that some units tell. The size of a lot is the root mean square of the
        units, its spread their standard deviation less what their own uncertainties put
        there, s/sqrt(2 nu) each. A unit is worse where p is below 5 % over the number
        of all lines of all units (Bonferroni).

    Raises
    ------
    CallError
        One has no sensor in common with the data sheet.
    """
    every = {one.name: _beside(printed, one, sample_rate) for one in units}
    if len(every) < len(units):
        raise CallError(
            "two units have one name, expected one for each; change name in their files"
        )
    level = LEVEL / max(sum(x.p is not None for own in every.values() for x in own), 1)
    by_line: dict[tuple[str, ...], list[tuple[str, MeasuredLine]]] = {}
    for name, own in every.items():
        for row in own:
            key = row.sensor, row.line, row.definition, row.axis
            by_line.setdefault(key, []).append((name, _standing(row, level)))
    made = [_lot(own) for own in by_line.values()]
    return MeasuredLot(
        first=printed.name,
        units=tuple(every),
        inputs=(
            *input_files([printed]),
            *(one for unit in units for one in input_files([], measured=unit)),
        ),
        level=level,
        lines=tuple(one for one in made if one is not None),
    )


def _lot(own: Sequence[tuple[str, MeasuredLine]]) -> LotLine | None:
    """Return one axis of one line of a lot; None where no unit tells it."""
    told = [
        (name, row, row.measured, row.degrees_of_freedom)
        for name, row in own
        if row.measured and row.degrees_of_freedom
    ]
    if not told:
        return None
    sizes, nu = (np.array([one[k] for one in told], dtype=float) for k in (2, 3))
    spread = 0.0
    if len(told) > 1:
        within = float(np.mean(sizes**2 / (2.0 * nu)))
        spread = sqrt(max(float(np.var(sizes, ddof=1)) - within, 0.0))
    name, row, largest, _ = told[first_largest(sizes.tolist())]
    size = sqrt(float(np.mean(sizes**2)))
    return LotLine(
        sensor=row.sensor,
        axis=row.axis,
        line=row.line,
        definition=row.definition,
        printed=row.printed,
        size=size,
        spread=spread,
        largest=largest or 0.0,
        largest_unit=name,
        unit=row.unit,
        si_per_unit=row.si_per_unit,
        ratio=size / row.printed if row.printed else None,
        units=len(told),
        worse=tuple(unit for unit, one in own if one.standing == WORSE),
    )


def _beside(
    printed: Device, measured: Device, sample_rate: float
) -> list[MeasuredLine]:
    """Return the lines of a unit beside those of its data sheet, not judged yet.

    Raises
    ------
    CallError
        They have no sensor in common.
    """
    sheets = {one.kind: one for one in printed.sensors}
    shared = [one for one in measured.sensors if one.kind in sheets]
    if not shared:
        raise CallError(
            f"{printed.name} has no {measured.sensors[0].kind}, and {measured.name} "
            "nothing else: there is nothing to compare"
        )
    is_sheet = not is_measured(printed)
    return [
        row
        for own in shared
        for row in _rows(sheets[own.kind], own, sample_rate, is_sheet=is_sheet)
    ]


def _standing(row: MeasuredLine, level: float) -> MeasuredLine:
    """Say what a comparison comes to."""
    if row.printed is None:
        word = NOT_PRINTED
    elif row.measured is None:
        word = NOT_MEASURED
    elif row.p is not None:
        word = WORSE if row.p < level else WITHIN
    else:
        word = WITHIN if row.measured <= row.printed else OPEN
    return replace(row, standing=word)


def _rows(
    sheet: Sensor, own: Sensor, sample_rate: float, *, is_sheet: bool
) -> Iterator[MeasuredLine]:
    """Yield the lines of one sensor."""
    wanted = _told(own.kind) - {FLICKER}  # a bias stability of another kind
    for source in lines_of(own.kind):
        if source.name not in wanted:
            continue
        for place, axis in enumerate(AXES):
            made = _Side(own, place, sample_rate, is_sheet=False)
            says = _Side(sheet, place, sample_rate, is_sheet=is_sheet)
            row = _row(source.name, axis, says, made)
            if row is not None:
                yield row


def _row(name: str, axis: str, says: _Side, made: _Side) -> MeasuredLine | None:
    """Return one axis of one line; None where neither has it."""
    definition = ""
    if name == "bias_stability":
        definition = FLOOR
        if not says.has_floor and not made.has_floor:
            definition = SPREAD
    value, _, nu, is_bound = made.value(name, definition)
    printed, sheet, known, _ = says.value(name, definition)
    if printed is None and value is None:
        return None
    usual = source_of(made.sensor.kind, name).like(made.sensor.kind)
    unit, size = usual, size_of(usual)
    if sheet is not None and sheet.name == name:  # in the maker's own terms
        unit, size = sheet.unit, sheet.si_per_unit
        size = size_of(unit) if definition else size
    row = MeasuredLine(
        sensor=made.sensor.kind,
        axis=axis,
        line=name,
        definition=definition,
        printed=printed,
        measured=value,
        is_bound=is_bound,
        unit=unit,
        si_per_unit=size,
        degrees_of_freedom=nu,
    )
    if not printed or not value:
        return row
    row = replace(row, ratio=value / printed)
    return row if nu is None else _compared(row, nu, known)


def _compared(row: MeasuredLine, nu: float, known: float | None) -> MeasuredLine:
    """Add the interval of a ratio, and p; `known`: of the printed, if few."""
    from scipy.stats import chi2, f

    # Of a variance over another one; where that is known a chi-square over nu.
    law = f(nu, known) if known else chi2(nu, scale=1.0 / nu)
    ratio = row.ratio or 0.0
    low, high = (ratio / sqrt(law.ppf(part)) for part in (0.975, 0.025))
    return replace(row, interval=(low, high), p=float(law.sf(ratio**2)))


# A value, the line that it is of, its degrees of freedom, and whether it is a bound.
Value = tuple[float | None, "ErrorLine | None", float | None, bool]
NOTHING: Value = (None, None, None, False)


@dataclass(frozen=True)
class _Side:
    """One axis of one sensor in one of the two files."""

    sensor: Sensor
    place: int
    sample_rate: float
    is_sheet: bool

    @property
    def has_floor(self) -> bool:
        """Whether its bias stability is flicker, the lowest point of an Allan curve."""
        return any(_is_flicker(one) and one.u[self.place] for one in self.sensor.lines)

    def value(self, name: str, definition: str) -> Value:
        """Return what it says of a line."""
        if definition == FLOOR:
            return self._floor()
        if name == walk_of(self.sensor.kind):
            return self._white()
        line = self.sensor.line(name)
        return NOTHING if line is None else self._of(abs(line.u[self.place]), [line])

    def _of(self, value: float, lines: Sequence[ErrorLine]) -> Value:
        """Return a value with the least degrees of freedom of what it is made of."""
        known = [nu for line in lines if (nu := self._freedom(line)) is not None]
        few = min(known, default=None)
        is_bound = few is None and any(
            line.degrees_of_freedom or line.meaning == "max" for line in lines
        )
        return float(value), lines[0], few, is_bound

    def _freedom(self, line: ErrorLine) -> float | None:
        """Return the degrees of freedom of a line on this axis."""
        several = line.degrees_of_freedom
        if not several or not line.u[self.place]:
            return None
        return several[self.place if len(several) > 1 else 0]

    def _processes(self, *kinds: str) -> list[tuple[ErrorLine, InRun]]:
        """Return what is noise on this axis, of some kinds."""
        found = []
        for line in self.sensor.lines:
            effect = source_of(self.sensor.kind, line.name).meant(line).effect
            if isinstance(effect, Noise) and line.u[self.place]:
                process = effect.process(line, self.place, self.sample_rate)
                found.append((line, process.in_run(self.sample_rate)))
        return [one for one in found if one[1].kind in kinds]

    def _white(self) -> Value:
        """Return N, of all that is white."""
        found = self._processes("white")
        if not found:
            return NOTHING
        N = sqrt(sum(run.u**2 for _, run in found))
        return self._of(N, [line for line, _ in found])

    def _floor(self) -> Value:
        """Return the lowest Allan deviation, as a maker prints it.

        Of flicker and walks that of the whole curve, of a Gauss-Markov process with
        white noise that before its largest value. Of a data sheet its own line counts;
        of what was measured all that is slow, bounds where nothing else is told.
        """
        slow = self._processes("walk", "markov")
        if self.is_sheet:
            slow = [one for one in slow if one[0].name in BIAS]
        else:
            slow = [one for one in slow if self._freedom(one[0]) is not None] or slow
        if not slow:
            return NOTHING
        lines = [line for line, _ in slow]
        if self.is_sheet and _is_flicker(lines[0]):
            return self._of(LOWEST * lines[0].u[self.place], lines)
        end = LONGEST
        if len(slow) == 1 and slow[0][1].kind == "markov" and not _is_flicker(lines[0]):
            end = HUMP * slow[0][1].times[0]
        times = np.geomspace(min(SHORTEST, end / TIMES), end, TIMES)
        every = (*self._processes("white"), *slow)
        curve = sum(
            _allan_variance(line, run, self.place, times) for line, run in every
        )
        return self._of(sqrt(float(np.min(curve))), lines)


def _is_flicker(line: ErrorLine) -> bool:
    """Whether a line is flicker noise."""
    return line.name in BIAS and FLICKER in {line.name, line.form}


def _allan_variance(line: ErrorLine, run: InRun, place: int, times: Array) -> Array:
    """Return the Allan variance of a process, shape (n,) [SI squared]."""
    if _is_flicker(line):  # above its low cut, 2 ln 2/pi B^2 at any time
        return np.full(times.size, (LOWEST * line.u[place]) ** 2)
    if run.kind == "markov":
        values = {SIGMA: run.u, TIME: run.times[0]}
    else:
        values = {WHITE if run.kind == "white" else WALK: run.u}
    return allan_variance(values, times, LONGEST)
