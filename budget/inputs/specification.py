"""Specification values of a data sheet: as printed, and as standard uncertainties."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import isfinite, pi, sin, sqrt
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    Self,
    cast,
    get_args,
)

import numpy as np
from pydantic import Field, create_model, model_validator

from budget.distributions import BY_NAME, NORMAL, Distribution
from budget.errors import UnitError
from budget.inputs.changes import EXACT
from budget.inputs.fields import (
    Measured,
    OrText,
    ShortText,
    Sign,
    Strict,
    Synonyms,
    faults,
    mapping_of,
)
from budget.inputs.records import ErrorLine
from budget.language import term
from budget.model.sources import (
    BAND,
    FLICKER,
    GYRO,
    LOW_CUT,
    SENSORS,
    lines_of,
    source_of,
)
from budget.names import AXES, ONE_VALUE, Name, words
from budget.sentences import sentence
from budget.ties import first_largest
from budget.units import (
    ONE_SIDED,
    TWO_SIDED,
    WALK_PER_DENSITY,
    Quantity,
    parse_quantity,
    per_root_hertz,
    size_of,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.inputs.makers import Density
    from budget.model.source import Key, Source

# What is printed, over the standard uncertainty [1].
SIGMAS = {"1 sigma": 1.0, "2 sigma": 2.0, "3 sigma": 3.0, "rms": 1.0, "typical": 1.0}
# The half-width, over what is printed [1].
HALF_WIDTHS = {"max": 1.0, "peak to peak": 0.5}
FIXED = term("known value")  # of what is no spread: a coefficient, a vibration

# Spellings of makers, and ours.
MEANINGS = {
    **{
        f"{n}{gap}\N{GREEK SMALL LETTER SIGMA}": f"{n} sigma"
        for n in "123"
        for gap in ("", " ")
    },
    **{f"{n}-sigma": f"{n} sigma" for n in "123"},
    **dict.fromkeys(("typ", "typ."), "typical"),
    **dict.fromkeys(("maximum", "max."), "max"),
    **dict.fromkeys(("p-p", "pk-pk", "peak-to-peak"), "peak to peak"),
}
GAUSSIAN = {"gaussian": "normal", "Gaussian": "normal"}
SHAPES = {**GAUSSIAN, "rectangular": "uniform"}

# The lowest Allan deviation of flicker noise over its coefficient B: sqrt(2 ln 2 / pi)
# to three digits, as data sheets use it [1].
ALLAN_MINIMUM = 0.664
CORRELATION_TIME = 300.0  # of a stability that names none [s]


# What a value may mean that the maker leaves open: words that exclude one another, and
# what each of them says in the other keys of the line.
MEANING_READINGS = tuple(SIGMAS) + tuple(HALF_WIDTHS)
PER_AXIS, TOGETHER = "per axis", "root sum square"
OVER_TEMPERATURE = "over temperature"
SIDES = (ONE_SIDED, TWO_SIDED)  # a smaller noise, and a larger one
READINGS = (  # by the key that says it, '' where none does
    ("meaning", MEANING_READINGS),
    ("definition", ("sigma", "allan_minimum")),
    ("definition", ("coefficient", "allan_minimum")),
    ("density", SIDES),
    ("", (PER_AXIS, TOGETHER)),
    ("", ("in-run", OVER_TEMPERATURE)),
    ("", ("turn-on", OVER_TEMPERATURE)),
)


_ORDER = tuple(dict.fromkeys(word for _, group in READINGS for word in group))


class SpecificationValue(Strict):
    """What a file may say about one specification value, or about one axis of it.

    Attributes
    ----------
    of_axis : type or None
        What it may say about one axis, where that is less.
    besides : str
        What it has to say besides the value, as a file writes it; '' if nothing.
    """

    of_axis: ClassVar[type[SpecificationValue] | None] = None
    besides: ClassVar[str] = ""

    value: Quantity | None = None
    meaning: Annotated[
        Literal[
            "1 sigma",
            "2 sigma",
            "3 sigma",
            "rms",
            "typical",
            "max",
            "peak to peak",
            "exact",
        ],
        Synonyms(MEANINGS),
    ] = Field(
        default="1 sigma",
        description="what the maker means by the value; exact: by a 0 that is meant",
    )
    distribution: str | None = None
    includes: ShortText | None = Field(
        default=None, description="what the value contains"
    )
    horizon: ShortText | None = Field(
        default=None, description="over what time it is given"
    )
    condition: ShortText | None = Field(
        default=None, description="under what condition"
    )
    source: ShortText | None = Field(default=None, description="where it is printed")

    @model_validator(mode="after")
    def _check_exact(self) -> Self:
        if self.meaning != EXACT:
            return self
        own = vars(getattr(self, "axes", None) or self).values()
        found = [q for q in (self.value, *own) if isinstance(q, Quantity) and q.value]
        if found:
            message = (
                f"found 'exact' with {found[0].printed!r}, expected it of 0 alone: an "
                "error of some size has a spread; say which, as 1 sigma, or put a "
                "known offset under nominal"
            )
            raise faults({("meaning",): message})
        return self

    @property
    def is_exact(self) -> bool:
        """Whether a 0 is meant, on some axis at least."""
        axes = vars(getattr(self, "axes", None) or self).values()
        own = (one for one in axes if isinstance(one, SpecificationValue))
        return self.meaning == EXACT or any(one.meaning == EXACT for one in own)


class ConstantValue(SpecificationValue):
    """Specification value of a random constant."""

    distribution: (
        Annotated[
            Literal["normal", "uniform", "triangular", "arcsine"], Synonyms(SHAPES)
        ]
        | None
    ) = Field(
        default=None,
        description="shape; unset: normal for a sigma, uniform for a half-width",
    )

    @model_validator(mode="after")
    def _check_shape(self) -> Self:
        if self.meaning in HALF_WIDTHS and self.distribution == "normal":
            message = (
                f"found 'normal' with meaning {self.meaning!r}, a half-width; expected "
                "uniform, triangular or arcsine, or a sigma meaning"
            )
            raise faults({("distribution",): message})
        return self


class NonlinearityValue(ConstantValue):
    """Specification value of a nonlinearity: a constant, or of a curve over a range."""

    of_axis: ClassVar[type[SpecificationValue] | None] = ConstantValue
    full_scale: Quantity | None = None  # of the sensor's own unit, below
    line: Literal["best", "least_squares"] | None = Field(
        default=None,
        description="what the largest deviation is from; unset, with full_scale: best",
    )
    shape: Literal["cubic", "quadratic"] | None = Field(
        default=None, description="of the curve; unset, with full_scale: cubic"
    )

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        if self.full_scale is None and (self.line or self.shape):
            key = "line" if self.line else "shape"
            message = (
                "is of the curve over a full scale, expected full_scale beside it "
                f"({{value: 30 ppm, full_scale: ..., {key}: ...}}); or remove it"
            )
            raise faults({(key,): message})
        return self

    def curve(self) -> _Form:
        """Return the curve as the coefficient of its power [SI].

        NL R is the largest deviation of K_p x^p from the line over -R to R: of the best
        (minimax) line K3 R^3/4 and K2 R^2/2, of that of least squares 2 K3 R^3/5 and
        2 K2 R^2/3.
        """
        if self.full_scale is None:
            return _Form(notes=(sentence("values.no_full_scale"),))
        line, shape = self.line or "best", self.shape or "cubic"
        part = {
            ("cubic", "best"): 1.0 / 4.0,
            ("quadratic", "best"): 1.0 / 2.0,
            ("cubic", "least_squares"): 2.0 / 5.0,
            ("quadratic", "least_squares"): 2.0 / 3.0,
        }[shape, line]
        power = 3 if shape == "cubic" else 2
        notes = [] if self.line else [sentence("values.no_line")]
        notes += [] if self.shape else [sentence("values.no_shape")]
        range_ = self.full_scale
        return _Form(
            form=shape,
            factor=1.0 / (part * range_.value ** (power - 1)),
            says=(("full_scale", self._lasting()), ("line", line), ("shape", shape)),
            definition=f"{shape}, from the {line} line over {range_.printed}",
            notes=tuple(notes),
        )

    def _lasting(self) -> str:
        """Return the full scale as any file has it."""
        return self.full_scale.printed if self.full_scale else ""


class RateNonlinearity(NonlinearityValue):
    """Of a gyro."""

    full_scale: Annotated[Quantity, Measured("deg/s", Sign.POSITIVE)] | None = Field(
        default=None, description="half the range, over which the value is given"
    )


class ForceNonlinearity(NonlinearityValue):
    """Of an accelerometer."""

    full_scale: Annotated[Quantity, Measured("g", Sign.POSITIVE)] | None = Field(
        default=None, description="half the range, over which the value is given"
    )

    def _lasting(self) -> str:
        """Return the full scale without g, which may be another one elsewhere."""
        return f"{self.full_scale.value!r} m/s^2" if self.full_scale else ""


class RateAsymmetry(ConstantValue):
    """Of a gyro."""

    of_axis: ClassVar[type[SpecificationValue] | None] = ConstantValue
    sign_of: Literal["turn", "input"] = Field(
        default="turn", description="whose sign decides which scale factor applies"
    )

    def curve(self) -> _Form:
        """Return whose sign decides."""
        if "sign_of" not in self.model_fields_set:
            return _Form()
        return _Form(
            form=self.sign_of,
            says=(("sign_of", self.sign_of),),
            definition=f"by the sign of the {self.sign_of}",
        )


class ForceAsymmetry(RateAsymmetry):
    """Of an accelerometer, which knows of no turns."""

    sign_of: Literal["input"] = Field(
        default="input", description="whose sign decides which scale factor applies"
    )


Time = Annotated[Quantity, Measured("s", Sign.POSITIVE)]


class Earlier(Strict):
    """What a maker prints of the same parameter for a shorter horizon."""

    value: Quantity
    horizon: Time = Field(description="time after which it has gone that far")


class AgeingValue(ConstantValue):
    """Specification value of what a parameter has gone a time after its calibration."""

    of_axis: ClassVar[type[SpecificationValue] | None] = ConstantValue
    besides: ClassVar[str] = "horizon: 1 year"
    horizon: Time = Field(description="time after which it has gone that far")  # type: ignore[assignment]
    law: Literal["drift", "random_walk"] | None = Field(
        default=None, description="of other times; unset: what gives the larger value"
    )
    earlier: tuple[Earlier, ...] = ()  # of the line's own unit, below

    @model_validator(mode="after")
    def _check_horizons(self) -> Self:
        found: dict[tuple[str | int, ...], str] = {}
        if self.earlier and not (self.value and self.value.value):
            message = "is beside one value of all axes above 0, expected that here"
            raise faults({("earlier",): message})
        horizons = [*(one.horizon for one in self.earlier), self.horizon]
        for place, (one, after) in enumerate(pairwise(horizons)):
            if one.value >= after.value:
                found["earlier", place, "horizon"] = (
                    f"found {one.printed!r} before {after.printed!r}, expected times "
                    "that rise to the horizon of the line"
                )
        for place, each in enumerate(self.earlier):
            later = [one.value for one in self.earlier[place + 1 :]]
            most = later[0] if later else self.value
            if each.value.value == 0.0:
                found["earlier", place, "value"] = "found 0, expected more than that"
            elif most is not None and each.value.value > most.value:
                found["earlier", place, "value"] = (
                    f"found {each.value.printed!r} before {most.printed!r}, expected "
                    "values that do not fall with time: what has aged stays so"
                )
        if found:
            raise faults(found)
        return self

    def curve(self) -> _Form:
        """Return its law, and its size at the horizons that are printed."""
        size = self.value.value if self.value else 1.0
        points = [(one.value.value, one.horizon) for one in self.earlier]
        says = [
            (f"{one.value.printed} after", one.horizon.printed) for one in self.earlier
        ]
        law = "" if self.law is None else f", {words(self.law)}"
        before = "".join(f", {value} {time}" for value, time in says)
        return _Form(
            form=self.law or "",
            horizons=(
                *((horizon.value, value / size) for value, horizon in points),
                (self.horizon.value, 1.0),
            ),
            says=(
                ("horizon", self.horizon.printed),
                *((("law", self.law),) if self.law else ()),
            ),
            definition=f"after {self.horizon.printed}{law}{before}",
            notes=() if self.law else (sentence("values.no_law"),),
        )


@dataclass(frozen=True, kw_only=True)
class _Form:
    """What a file means by a value that can be meant in several ways."""

    form: str = ""
    factor: float = 1.0  # [SI]
    reading: float = 1.0  # part of it that is no unit [1]
    low_cut: float | None = None  # [Hz]
    horizons: tuple[tuple[float, float], ...] = ()  # [s, 1]
    says: tuple[tuple[str, str], ...] = ()
    definition: str = ""
    notes: tuple[str, ...] = ()


class ProcessValue(SpecificationValue):
    """Specification value of a random process."""

    distribution: Annotated[Literal["normal"], Synonyms(GAUSSIAN)] | None = Field(
        default=None, description="a process is normal"
    )


class Filter(Strict):
    """Butterworth filter that noise has passed; of order 1 a simple pole."""

    corner: Annotated[Quantity, Measured("Hz", Sign.POSITIVE)] = Field(
        description="where it lets half of the power pass"
    )
    order: Annotated[int, Field(ge=1, le=20)] = Field(description="number of its poles")


class SampleNoiseValue(ProcessValue):
    """Specification value of a noise of every sample, or of the rms in a band."""

    of_axis: ClassVar[type[SpecificationValue] | None] = ProcessValue
    bandwidth: Annotated[Filter, OrText(Measured("Hz", Sign.POSITIVE))] | None = Field(
        default=None,
        description="noise bandwidth B of an rms, N = rms/sqrt(2 B); unset: of samples",
    )

    def curve(self) -> _Form:
        """Return the random walk of an rms in a one-sided noise bandwidth B [Hz].

        rms^2 = 2 N^2 B of white noise N, with B = f_c (pi/2n)/sin(pi/2n) of a
        Butterworth filter of order n, the integral of 1/(1 + (f/f_c)^2n): pi/2 f_c of
        the first order.
        """
        if self.bandwidth is None:
            return _Form()
        band: Filter | Quantity = self.bandwidth
        if isinstance(band, Quantity):
            B, said = band.value, band.printed
        else:
            corner, order = band.corner, band.order
            angle = pi / (2.0 * order)
            B = corner.value * angle / sin(angle)
            said = f"{{corner: {corner.printed}, order: {order}}}"
        return _Form(
            form=BAND,
            factor=1.0 / sqrt(2.0 * B),
            says=(("bandwidth", said),),
            definition=f"rms in a noise bandwidth of {B:.4g} Hz",
        )


class WalkValue(ProcessValue):
    """Value of a random walk, as its coefficient N or as a density of noise."""

    density: Literal["one-sided", "two-sided"] | None = Field(
        default=None,
        description="of a value per root of hertz; unset: open, the larger N = D taken",
    )

    @model_validator(mode="after")
    def _check_density(self) -> Self:
        for quantity in self._governed():
            if self.density and not per_root_hertz(quantity.unit):
                message = (
                    f"found {self.density!r} with {quantity.printed!r}, which is the "
                    "random walk itself and no density, expected a value per root of "
                    "hertz; remove 'density'"
                )
                raise faults({("density",): message})
        return self

    @property
    def is_open(self) -> bool:
        """Whether it is a density, and the sides of it are not said."""
        units = [quantity.unit for quantity in self._governed()]
        return self.density is None and any(map(per_root_hertz, units))

    def _governed(self) -> list[Quantity]:
        """Return its values, without those of axes that are mappings of their own."""
        own = getattr(getattr(self, "axes", None), "__dict__", {})
        return [q for q in (self.value, *own.values()) if isinstance(q, Quantity)]


class StabilityValue(ProcessValue):
    """Specification value of the bias stability."""

    definition: Literal["sigma", "allan_minimum"] = Field(
        default="sigma",
        description="sigma of the process, or the lowest point of the Allan curve",
    )
    correlation_time: Time | None = Field(
        default=None,
        description="of the process; unset: 300 s of a sigma, none of a flicker",
    )
    averaging_time: Time | None = Field(
        default=None, description="at which the Allan curve is lowest"
    )

    @model_validator(mode="after")
    def _check_definition(self) -> Self:
        is_floor = self.definition == "allan_minimum"
        if is_floor and SIGMAS.get(self.meaning, 1.0) != 1.0:
            message = (
                f"found 'allan_minimum' with meaning {self.meaning!r}; a point of the "
                "Allan curve is 1 sigma, expected that meaning"
            )
            raise faults({("definition",): message})
        floor, time = self.averaging_time, self.correlation_time
        if floor and not is_floor:
            message = (
                "is of a floor of the Allan curve, expected definition: allan_minimum "
                "beside it; or remove it"
            )
            raise faults({("averaging_time",): message})
        if floor and time and time.value < floor.value:
            message = (
                f"found {time.printed!r}, below the {floor.printed!r} at which the "
                "Allan curve is lowest, expected that time or more: a Gauss-Markov "
                "process of a shorter one is on its way down there. Remove it, and the "
                "floor is taken as that of flicker noise"
            )
            raise faults({("correlation_time",): message})
        if len({part.is_flicker for part in self._parts()}) > 1:
            message = (
                "is flicker noise (allan_minimum without a correlation time) on some "
                "axes and a Gauss-Markov process on others, expected one of them; say "
                "definition and correlation_time of every axis alike"
            )
            raise faults({("axes",): message})
        return self

    @property
    def is_flicker(self) -> bool:
        """Whether it is the floor of a curve, and nothing tells of another process."""
        return self.definition == "allan_minimum" and self.correlation_time is None

    def _parts(self) -> list[StabilityValue]:
        """Return what speaks for the axes: mappings of their own, and the line."""
        axes = vars(getattr(self, "axes", None) or self).values()
        own = [one for one in axes if isinstance(one, StabilityValue)]
        return own if own and len(own) == len(axes) else [self, *own]

    def curve(self) -> _Form:
        """Return flicker noise, whose Allan deviation is 0.664 B at its floor."""
        parts = self._parts()
        floors = [one.averaging_time for one in parts if one.averaging_time]
        shortest = min(floors, key=lambda one: one.value, default=None)
        says = (("averaging_time", shortest.printed),) if shortest else ()
        if not all(part.is_flicker for part in parts):
            return _Form(says=says)
        return _Form(
            form=FLICKER,
            factor=1.0 / ALLAN_MINIMUM,
            reading=1.0 / ALLAN_MINIMUM,
            low_cut=LOW_CUT,
            says=(("definition", "allan_minimum"), *says),
            definition="allan_minimum",
            notes=(
                sentence("values.floor_as_flicker", minimum=ALLAN_MINIMUM),
                sentence("values.low_cut"),
            ),
        )


class FlickerValue(ProcessValue):
    """Specification value of a flicker."""

    of_axis: ClassVar[type[SpecificationValue] | None] = ProcessValue
    definition: Literal["coefficient", "allan_minimum"] = Field(
        default="coefficient",
        description="B itself, or the lowest point of the Allan curve, 0.664 B",
    )
    low_cut: Annotated[Quantity, Measured("Hz", Sign.POSITIVE)] | None = Field(
        default=None, description="below which it has no power; unset: once a day"
    )

    def curve(self) -> _Form:
        """Return its coefficient and its low cut."""
        low = f"{LOW_CUT!r} Hz" if self.low_cut is None else self.low_cut.printed
        is_minimum = self.definition == "allan_minimum"
        reading = 1.0 / ALLAN_MINIMUM if is_minimum else 1.0
        return _Form(
            factor=reading,
            reading=reading,
            low_cut=LOW_CUT if self.low_cut is None else self.low_cut.value,
            says=(("definition", self.definition), ("low_cut", low)),
            definition=f"{self.definition}, no power below "
            + ("once a day" if self.low_cut is None else low),
            notes=(sentence("values.low_cut"),) if self.low_cut is None else (),
        )


class Whole(SpecificationValue):
    """Specification value for all axes, some of which may say otherwise."""

    axes: Strict | None = None

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        if self.value is not None:
            return self
        if self.axes is None:
            raise faults({(): "names neither value nor axes, expected one of them"})
        absent = [a for a in type(self.axes).model_fields if not getattr(self.axes, a)]
        if absent:
            message = f"without value, expected all axes; missing: {', '.join(absent)}"
            raise faults({("axes",): message})
        return self


class Open(Whole):
    """Specification value whose meaning the maker may leave open."""

    reading: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _check_readings(self) -> Self:
        """Refuse words that do not leave one thing open, or that the line says."""
        words = self.reading
        if not words:
            return self
        keys = [key for key, group in READINGS if {*words} <= {*group}]
        own = [*vars(self.axes).values()] if self.axes else []
        message = ""
        if len({*words}) < max(2, len(words)):
            message = (
                f"found {', '.join(words)}, expected two different words at the least; "
                "what is known is said by its own key"
            )
        elif not keys:
            groups = "; ".join(", ".join(group) for _, group in READINGS)
            message = (
                f"found {', '.join(words)}, expected words that exclude one another: "
                f"{groups}"
            )
        elif keys[0] in self.model_fields_set:
            message = f"leaves open what {keys[0]!r} says, expected one of them"
        elif any(isinstance(one, SpecificationValue) for one in own):
            message = (
                "is of the whole line, and an axis is a mapping of its own; give the "
                "axes as values"
            )
        elif "max" in words and getattr(self, "distribution", None) == "normal":
            message = "may be 'max', a half-width, which is never 'normal'; remove that"
        elif keys[0] == "density" and not all(
            per_root_hertz(quantity.unit)
            for quantity in (self.value, *own)
            if isinstance(quantity, Quantity)
        ):
            message = "is of a value per root of hertz; this is the random walk itself"
        if message:
            raise faults({("reading",): message})
        return self


class Residual(ConstantValue, Whole):
    """What is left over temperature, said of another line."""


@dataclass(frozen=True, kw_only=True)
class ReadValue:
    """A line as the models take it, and what had to be assumed for that."""

    line: ErrorLine
    assumptions: tuple[str, ...]


def value_type(line: Source, sensor: str) -> Any:  # noqa: ANN401
    """Return the type of a value of that line: a text or a mapping."""
    beside = beside_of(line, sensor)
    family = _family(line, sensor)
    is_open = line.varies and sensor in SENSORS
    readings = tuple(
        word for group in readings_of(line, sensor) for word in group if is_open
    )
    sign = Sign.ANY if line.is_signed else Sign.NOT_NEGATIVE
    measured = Measured(line.like(sensor), sign)
    return _value_type(measured, family, line.axes, beside, readings, keys=line.keys)


def readings_of(line: Source, sensor: str) -> tuple[tuple[str, ...], ...]:
    """Return what a value of that line may mean: lists of words that exclude others."""
    fields = _family(line, sensor).model_fields
    places = (
        {"definition": get_args(fields["definition"].annotation)}
        if ("definition" in fields)
        else {}
    )
    found = []
    for key, group in READINGS:
        if key == "definition":
            fits = {*group} <= {*places.get(key, ())}
        elif key:
            fits = key in fields
        elif group == (PER_AXIS, TOGETHER):
            fits = line.axes == AXES
        else:
            fits = bool(line.over_temperature) and _usual_word(line) == group[0]
        if fits:
            found.append(group)
    return tuple(found)


def beside_of(line: Source, sensor: str) -> str:
    """Return the line that says the same again, beside that one; '' if none."""
    there = {one.name for one in lines_of(sensor)}
    return next((name for name in line.beside if name in there), "")


def _usual_word(line: Source) -> str:
    """Return what a value is that is not that over temperature: 'in-run', 'turn-on'."""
    return line.stays.replace(" ", "-")


def read_value(
    line: Source,
    sensor: str,
    given: Quantity | SpecificationValue,
    *,
    known: Density | None = None,
) -> ReadValue:
    """Turn a value as printed into standard uncertainties by axis [SI].

    Where the file leaves open what it means, the reading with the largest; the line
    holds the others. A density of which no sides are said is open, unless it is
    `known` how its maker means it.
    """
    if isinstance(given, Quantity):
        given = _family(line, sensor)(value=given)
    readings: tuple[str, ...] = getattr(given, "reading", ())
    if isinstance(given, WalkValue) and given.is_open and not readings:
        sided = {one: _under(line, sensor, given, one) for one in SIDES}
        return _of_sides(sided, Name(line.name, owner=sensor), known)
    if not readings:
        return _read(line, sensor, given)
    # In an order that is not the file's: of equal ones, what stays in this line.
    readings = tuple(sorted(readings, key=_ORDER.index))
    read = [_under(line, sensor, given, word) for word in readings]
    place = first_largest([one.line.largest for one in read])
    key = Name(line.name, owner=sensor)
    said = sentence("values.open", key=key, readings=readings, taken=readings[place])
    lines = tuple((word, one.line) for word, one in zip(readings, read, strict=True))
    return ReadValue(
        line=replace(read[place].line, readings=lines),
        assumptions=(said, *read[place].assumptions),
    )


def _of_sides(
    sided: Mapping[str, ReadValue], key: Name, known: Density | None
) -> ReadValue:
    """Return a density as its maker means it, or as the larger where it is open."""
    if known is None:
        taken, text = sided[TWO_SIDED], sentence("values.density")
        readings = tuple((word, one.line) for word, one in sided.items())
        taken = replace(taken, line=replace(taken.line, readings=readings))
    else:
        taken = sided[known.sides]
        text = sentence(
            "values.density_of_maker", sides=known.sides, source=known.source
        )
    said = sentence("assumed.of", key=key, text=text)
    return replace(taken, assumptions=(said, *taken.assumptions))


def _under(
    line: Source, sensor: str, given: SpecificationValue, word: str
) -> ReadValue:
    """Read a value under one of its readings."""
    says: dict[str, object] = {"reading": ()}
    if word in MEANING_READINGS:
        says["meaning"] = word
    elif word in SIDES:
        says["density"] = word
    elif word == OVER_TEMPERATURE:
        other = source_of(sensor, line.over_temperature)
        same = ("value", "axes", "meaning", "includes", "condition", "source")
        kept = {key: getattr(given, key) for key in same}
        return _read(other, sensor, Residual.model_construct(**kept))
    elif word not in {PER_AXIS, TOGETHER, _usual_word(line)}:
        says["definition"] = word
    part = given.model_copy(update=says)
    part.model_fields_set.update(says)
    one = _read(line, sensor, part)
    if word != TOGETHER:
        return one
    factor = 1.0 / sqrt(len(line.axes))
    scaled = replace(
        one.line,
        u=one.line.u * factor,
        si_per_unit=one.line.si_per_unit * factor,
        factor=one.line.factor * factor,
        reading=one.line.reading * factor,
    )
    return replace(one, line=scaled)


def _read(line: Source, sensor: str, given: Quantity | SpecificationValue) -> ReadValue:
    """Turn a value whose meaning is said into standard uncertainties by axis [SI].

    A text is 1 sigma and normal. A sigma meaning divides the value; `max` and `peak to
    peak` give a half-width, which its shape divides (JCGM 100:2008, 4.3.7 to 4.3.9).
    Of a process they bound its sigma or density over units, and are taken as that: a
    maker who prints at most 0.3 deg/sqrt(h) says of every unit that its noise is no
    larger, not that the noise of one never exceeds it.

    A value per root of hertz is a spectral density D, whose random walk coefficient is
    N = D / sqrt(2) if it is one-sided (rms in a band B is D sqrt(B)), and N = D if not:
    the larger, which is taken where nobody says it.
    """
    family = _family(line, sensor)
    part = family(value=given) if isinstance(given, Quantity) else given
    axes = [_axis(part, axis) for axis in line.axes]
    notes = list(dict.fromkeys(text for a in axes for text in a.notes))
    key = Name(line.name, owner=sensor)
    assumptions = [
        sentence(
            "assumed.of",
            key=key
            if all(text in a.notes for a in axes)
            else Name(line.name, owner=sensor, axis=name),
            text=text,
        )
        for text in notes
        for name, a in zip(line.axes, axes, strict=True)
        if text in a.notes
    ]

    def say(words: list[str]) -> str:
        """Return one text for all axes, or a text for each that has one."""
        if len(set(words)) == 1:
            return words[0]
        named = zip(line.axes, words, strict=True)
        return ", ".join(f"{axis} {word}" for axis, word in named if word)

    times = [a.correlation_time for a in axes if a.correlation_time is not None]
    form = part.curve() if isinstance(part, FORMED) else _Form()
    given_keys = {one: getattr(part, one.name, None) for one in line.keys}
    unsaid = [one.name for one, quantity in given_keys.items() if quantity is None]
    form_notes = [
        *form.notes,
        *(
            sentence("values.usual_key", key=one.name, size=_usual(one))
            for one in line.keys
            if one.name in unsaid
        ),
    ]
    assumptions += [sentence("assumed.of", key=key, text=text) for text in form_notes]
    own_says = tuple(
        (one.name, _usual(one) if quantity is None else quantity.printed)
        for one, quantity in given_keys.items()
    )
    taken = ErrorLine(
        name=line.name,
        u=np.array([a.u for a in axes]) * form.factor,
        distributions=tuple(NORMAL if line.process else a.shape for a in axes),
        own={
            one.name: one.usual if quantity is None else quantity.value
            for one, quantity in given_keys.items()
        },
        correlation_time=np.array(times) if times else None,
        printed=say([a.quantity.printed for a in axes]),
        unit=axes[0].quantity.unit,
        si_per_unit=axes[0].quantity.si_per_unit
        * WALK_PER_DENSITY[axes[0].density]
        * form.factor,
        low_cut=None if form.low_cut is None else np.full(len(axes), form.low_cut),
        form=form.form,
        horizons=form.horizons,
        factor=form.factor,
        reading=form.reading,
        says=(*form.says, *(one for one in own_says if one[0] not in unsaid)),
        density=axes[0].density,
        adds_to=getattr(part, "adds_to", None) or "",
        meaning=say([_meaning(line, a.part) for a in axes]),
        definition=form.definition
        or say([a.definition for a in axes])
        or ", ".join(f"{words(name)} {text}" for name, text in own_says),
        includes=say([a.part.includes or "" for a in axes]),
        horizon=say([_text(a.part.horizon) for a in axes]),
        condition=say([a.part.condition or "" for a in axes]),
        source=say([a.part.source or "" for a in axes]),
    )
    return ReadValue(line=taken, assumptions=tuple(dict.fromkeys(assumptions)))


def _usual(key: Key) -> str:
    """Write what is taken where a file does not say a key."""
    return f"{key.usual / size_of(key.unit):.6g} {key.unit}"


def time_in(given: Quantity | SpecificationValue | None) -> Quantity | None:
    """Return the time over which a value holds; None where no time is said."""
    text = None if given is None or isinstance(given, Quantity) else given.horizon
    return None if text is None else time_of(text)


def time_of(text: str) -> Quantity | None:
    """Return the time that a horizon says; None of 'run to run' or '6 runs'."""
    try:
        return parse_quantity(text, "s")
    except UnitError:
        return None


def _text(horizon: str | Quantity | None) -> str:
    """Return what a file says in words; '' of a time, which the definition says."""
    return horizon if isinstance(horizon, str) else ""


def standard_size(quantity: Quantity, density: str = "") -> float:
    """Return the u that a bare value of a line is [SI]: of a density the random walk.

    `density` says of which sides it is; two-sided where nobody has said it.
    """
    if not per_root_hertz(quantity.unit):
        return quantity.value
    return quantity.value * WALK_PER_DENSITY[density or TWO_SIDED]


@cache
def _value_type(
    measured: Measured,
    family: type[SpecificationValue],
    axes: tuple[str, ...],
    beside: str,
    readings: tuple[str, ...],
    *,
    keys: tuple[Key, ...],
) -> Any:  # noqa: ANN401
    """Return the type of the values that have this unit and these axes.

    `beside` is a line of which the value may say that it is no part of it; `readings`
    are what it may mean, `keys` what it may say besides.
    """
    value = Annotated[Quantity, measured]
    title = f"{family.__name__.removesuffix('Value')} in {measured.like}"
    text = OrText(measured, family.besides)
    if axes == ONE_VALUE:
        alone = create_model(title, __base__=family, value=(value, ...))
        return Annotated[alone, text]
    of_axis = family.of_axis or family
    says = "what the value may mean, where the maker leaves it open: all are computed"
    reading = {"reading": (tuple[Literal[readings], ...], Field((), description=says))}  # type: ignore[valid-type]
    one_axis = create_model(f"{title}, one axis", __base__=of_axis, value=(value, ...))
    by_axis = mapping_of(
        f"{title}, by axis", dict.fromkeys(axes, Annotated[one_axis, OrText(measured)])
    )
    fields: dict[str, Any] = {
        **(reading if readings else {}),
        "value": (value | None, None),
        "axes": (by_axis | None, None),
        **{
            one.name: (
                Annotated[Quantity, Measured(one.unit, Sign.POSITIVE)] | None,
                Field(default=None, description=one.says),
            )
            for one in keys
        },
    }
    if beside:
        says = f"what is no part of {beside}, given as well"
        word = Literal[beside]  # type: ignore[valid-type]
        fields["adds_to"] = (word | None, Field(default=None, description=says))
    if issubclass(family, AgeingValue):
        earlier = create_model(
            f"{title}, earlier", __base__=Earlier, value=(value, ...)
        )
        says = "what is printed for shorter horizons, of all axes"
        fields["earlier"] = (
            tuple[earlier, ...],  # type: ignore[valid-type]
            Field(default=(), description=says),
        )
    base = Open if readings else Whole
    whole = create_model(title, __base__=(family, base), **fields)
    return Annotated[whole, text]


FORMED = (
    NonlinearityValue
    | RateAsymmetry
    | SampleNoiseValue
    | StabilityValue
    | FlickerValue
    | AgeingValue
)
# What a file may say of values that are more than those of a constant or a process, by
# the word of the row; where sensors differ, of a gyro and of an accelerometer.
FAMILIES: Mapping[str, tuple[type[SpecificationValue], ...]] = {
    "nonlinearity": (RateNonlinearity, ForceNonlinearity),
    "asymmetry": (RateAsymmetry, ForceAsymmetry),
    "sample_noise": (SampleNoiseValue,),
    "flicker": (FlickerValue,),
    "ageing": (AgeingValue,),
    "stability": (StabilityValue,),
    "walk": (WalkValue,),
}


def _family(line: Source, sensor: str) -> type[SpecificationValue]:
    """Return what a file may say about a value of that line."""
    usual = ProcessValue if line.process else ConstantValue
    families = FAMILIES.get(line.value, (usual,))
    return families[0] if sensor == GYRO else families[-1]


def _meaning(line: Source, part: SpecificationValue) -> str:
    """Return what a value means; of what is no spread, unless it is said, just that."""
    if line.varies or "meaning" in part.model_fields_set:
        return part.meaning
    return FIXED


@dataclass(frozen=True, kw_only=True)
class _Axis:
    """One axis of a specification value."""

    part: SpecificationValue
    quantity: Quantity
    u: float  # [SI]
    shape: Distribution
    definition: str  # as given
    correlation_time: float | None  # of a stability [s]
    density: str  # of a random walk per root of hertz, 'one-sided' or 'two-sided'
    notes: tuple[str, ...]  # what was assumed


def _axis(given: SpecificationValue, axis: str) -> _Axis:
    """Return what a specification value says about one axis."""
    axes = given.axes if isinstance(given, Whole) else None
    own: SpecificationValue | Quantity | None = getattr(axes, axis, None)
    part = own if isinstance(own, SpecificationValue) else given
    # Whole lets no value pass that leaves an axis without a value.
    quantity = cast("Quantity", own if isinstance(own, Quantity) else part.value)
    notes: list[str] = []
    if isinstance(own, SpecificationValue):
        stated = {
            *("meaning", "distribution", "definition", "correlation_time", "density"),
            "averaging_time",
        }
        lost = sorted((given.model_fields_set - own.model_fields_set) & stated)
        if lost:
            notes.append(sentence("values.own_mapping", lost=lost))
    level = _level(part, quantity)
    u = level.u
    notes += level.notes
    definition, correlation_time = "", None
    if isinstance(part, StabilityValue) and not part.is_flicker:
        definition = part.definition if "definition" in part.model_fields_set else ""
        if definition == "allan_minimum":
            u /= ALLAN_MINIMUM
            notes.append(sentence("values.floor_as_sigma", minimum=ALLAN_MINIMUM))
        correlation_time = CORRELATION_TIME
        if part.correlation_time is not None:
            correlation_time = part.correlation_time.value
        else:
            notes.append(sentence("values.correlation_time", time=CORRELATION_TIME))
    return _Axis(
        part=part,
        quantity=quantity,
        u=u,
        shape=level.shape,
        density=level.density,
        definition=definition,
        correlation_time=correlation_time,
        notes=tuple(notes),
    )


@dataclass(frozen=True, kw_only=True)
class _Level:
    """What a value is as a standard uncertainty, of a density as a random walk."""

    u: float  # [SI]
    shape: Distribution
    density: str
    notes: list[str]  # what was assumed


def divisor(meaning: str, shape: Distribution) -> float:
    """Return what is printed over the standard uncertainty that it means [1].

    Of a half-width that of its shape (JCGM 100:2008, 4.3.7 to 4.3.9); where the shape
    is normal the half-width bounds the sigma itself.
    """
    if meaning not in HALF_WIDTHS:
        return SIGMAS.get(meaning, 1.0)
    own = shape.half_width if isfinite(shape.half_width) else 1.0
    return own / HALF_WIDTHS[meaning]


def _level(part: SpecificationValue, quantity: Quantity) -> _Level:
    """Return the standard uncertainty that a value means."""
    notes: list[str] = []
    density = ""
    if isinstance(part, WalkValue) and per_root_hertz(quantity.unit):
        density = part.density or TWO_SIDED
        if part.density is None:
            notes.append(sentence("values.density"))
    if part.meaning in HALF_WIDTHS and isinstance(part, ProcessValue):
        shape = NORMAL
        notes.append(sentence("values.bound", meaning=part.meaning))
    elif part.meaning in HALF_WIDTHS:
        shape = BY_NAME[part.distribution or "uniform"]
        if part.distribution is None:
            notes.append(sentence("values.uniform", meaning=part.meaning))
    else:
        shape = BY_NAME[part.distribution or "normal"]
        if part.meaning == "typical":
            notes.append(sentence("values.typical"))
    u = quantity.value / divisor(part.meaning, shape)
    return _Level(
        u=u * WALK_PER_DENSITY[density], shape=shape, density=density, notes=notes
    )
