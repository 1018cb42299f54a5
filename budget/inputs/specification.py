"""Specification values of a data sheet: as printed, and as standard uncertainties."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import isfinite, pi, sin, sqrt
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from budget.distributions import BY_NAME, NORMAL, Distribution
from budget.errors import UnitError
from budget.inputs.changes import EXACT
from budget.inputs.fields import (
    OWN,
    TEXT,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    given_of,
    items,
    meaning,
    measured,
    number,
    one_of,
    or_text,
    rows_of,
    table,
)
from budget.inputs.records import ErrorLine
from budget.inputs.tree import flow
from budget.language import term
from budget.model.sources import (
    ACCELEROMETER,
    BAND,
    FLICKER,
    GYRO,
    LOW_CUT,
    SENSORS,
    STATION,
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
    from collections.abc import Callable, Mapping

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
FLOOR = "allan_minimum"  # definition of a value: the lowest point of the Allan curve
FEW = "degrees_of_freedom"
FROM_FEW: Rows = {  # of a line that varies
    FEW: KeyRow(
        number(1, is_whole=False),
        "of its standard uncertainty: n - 1 of a scatter of n; unset: it is known",
    )
}
# Keys of a line that a mapping of one axis has for itself.
STATED = frozenset(
    {
        *("meaning", "distribution", "definition", "correlation_time", "density"),
        *("averaging_time", FEW),
    }
)


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


POSITIVE_TIME = measured("s", Sign.POSITIVE, bare=False)
FREQUENCY = measured("Hz", Sign.POSITIVE)
Form = dict[str, Any]  # fields of a line that follow from what its value means


class SpecificationValue(Keyed):
    """What a file may say about one specification value, or about one axis of it.

    Attributes
    ----------
    of_axis : type or None
        What it may say about one axis, where that is less.
    of_sensor : mapping of str to Rows
        Rows that are others for a sensor.
    besides : str
        What it has to say besides the value, as a file writes it; '' if nothing.
    """

    of_axis: ClassVar[type[SpecificationValue] | None] = None
    of_sensor: ClassVar[Mapping[str, Rows]] = {}
    besides: ClassVar[str] = ""

    strangers: ClassVar[Mapping[str, str]] = {
        FEW: "; they are of errors that add to a result (JCGM 100, G.4), and by this "
        "others are multiplied, or it is calibrated away: state a value that covers "
        "what it is known to"
    }
    rows: ClassVar[Rows] = {  # value and distribution: of its own kind, below
        "value": KeyRow(OWN),
        "meaning": KeyRow(
            meaning(*SIGMAS, *HALF_WIDTHS, EXACT, meant=MEANINGS),
            "what the maker means by the value; exact: by a 0 that is meant",
            usual="1 sigma",
        ),
        "distribution": KeyRow(OWN),
        "includes": KeyRow(TEXT, "what the value contains"),
        "horizon": KeyRow(TEXT, "over what time it is given"),
        "condition": KeyRow(TEXT, "under what condition"),
        "source": KeyRow(TEXT, "where it is printed"),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "meaning",
            lambda it: it.meaning == EXACT and it.some_size,
            "found 'exact' with {some_size!r}, expected it of 0 alone: an error of "
            "some size has a spread; say which, as 1 sigma, or put a known offset "
            "under nominal",
        ),
        Rule(
            FEW,
            lambda it: (
                getattr(it, FEW, None)
                and (
                    it.meaning in {*HALF_WIDTHS, EXACT}
                    or it.distribution not in {None, NORMAL.name}
                )
            ),
            "are of the standard uncertainty of a normal error, expected a sigma "
            "meaning and no other distribution; remove them, or say that",
        ),
    )

    @property
    def by_axis(self) -> dict[str, Any]:
        """What it says of axes, by axis."""
        axes = getattr(self, "axes", None)
        return vars(axes) if axes else {}

    @property
    def sizes(self) -> list[Quantity]:
        """Its values, without those of axes that are mappings of their own."""
        every = (self.value, *self.by_axis.values())
        return [one for one in every if isinstance(one, Quantity)]

    @property
    def some_size(self) -> str:
        """The first value that is not 0, as printed; '' where all are."""
        return next((one.printed for one in self.sizes if one.value), "")

    @property
    def is_exact(self) -> bool:
        """Whether a 0 is meant, on some axis at least."""
        return EXACT in {
            getattr(one, "meaning", "") for one in (self, *self.by_axis.values())
        }

    def form(self, _: str) -> Form:
        """Return what follows of its meaning for a sensor, if that may be several.

        Fields of its ErrorLine, and `notes` on what is assumed.
        """
        return {}


class ConstantValue(SpecificationValue):
    """Specification value of a random constant."""

    rows: ClassVar[Rows] = {
        "distribution": KeyRow(
            one_of("normal", "uniform", "triangular", "arcsine", meant=SHAPES),
            "shape; unset: normal for a sigma, uniform for a half-width",
        )
    }
    rules: ClassVar[Rules] = (
        Rule(
            "distribution",
            lambda it: it.meaning in HALF_WIDTHS and it.distribution == "normal",
            "found 'normal' with meaning {meaning!r}, a half-width; expected uniform, "
            "triangular or arcsine, or a sigma meaning",
        ),
    )


# The largest deviation of K_p x^p from a line over -R to R, over K_p R^p [1].
DEVIATIONS = {
    ("cubic", "best"): 1.0 / 4.0,
    ("quadratic", "best"): 1.0 / 2.0,
    ("cubic", "least_squares"): 2.0 / 5.0,
    ("quadratic", "least_squares"): 2.0 / 3.0,
}
_LONE = (
    "is of the curve over a full scale, expected full_scale beside it ({{value: 30 "
    "ppm, full_scale: ..., %s: ...}}); or remove it"
)
_HALF = "half the range, over which the value is given"


class NonlinearityValue(ConstantValue):
    """Specification value of a nonlinearity: a constant, or of a curve over a range."""

    of_axis = ConstantValue
    of_sensor: ClassVar[Mapping[str, Rows]] = {
        GYRO: {"full_scale": KeyRow(measured("deg/s", Sign.POSITIVE), _HALF)},
        ACCELEROMETER: {"full_scale": KeyRow(measured("g", Sign.POSITIVE), _HALF)},
    }
    rows: ClassVar[Rows] = {
        "full_scale": KeyRow(OWN),
        "line": KeyRow(
            one_of("best", "least_squares"),
            "what the largest deviation is from; unset, with full_scale: best",
        ),
        "shape": KeyRow(
            one_of("cubic", "quadratic"),
            "of the curve; unset, with full_scale: cubic",
        ),
    }
    rules: ClassVar[Rules] = (
        Rule("line", lambda it: it.line and not it.full_scale, _LONE % "line"),
        Rule(
            "shape",
            lambda it: it.shape and not (it.full_scale or it.line),
            _LONE % "shape",
        ),
    )

    def form(self, sensor: str) -> Form:
        """Return the curve as the coefficient of its power [SI].

        NL R is the largest deviation of K_p x^p from the line over -R to R: of the best
        (minimax) line K3 R^3/4 and K2 R^2/2, of that of least squares 2 K3 R^3/5 and
        2 K2 R^2/3. A full scale is said without g, which may be another one elsewhere.
        """
        scale = self.full_scale
        if scale is None:
            return {"notes": [sentence("values.no_full_scale")]}
        line, shape = self.line or "best", self.shape or "cubic"
        power = 3 if shape == "cubic" else 2
        unsaid = {"values.no_line": self.line, "values.no_shape": self.shape}
        lasting = scale.printed if sensor == GYRO else f"{scale.value!r} m/s^2"
        return {
            "form": shape,
            "factor": 1.0 / (DEVIATIONS[shape, line] * scale.value ** (power - 1)),
            "says": (("full_scale", lasting), ("line", line), ("shape", shape)),
            "definition": f"{shape}, from the {line} line over {scale.printed}",
            "notes": [sentence(key) for key, said in unsaid.items() if not said],
        }


_WHOSE = "whose sign decides which scale factor applies"


class AsymmetryValue(ConstantValue):
    """Specification value of an asymmetry; an accelerometer knows of no turns."""

    of_axis = ConstantValue
    of_sensor: ClassVar[Mapping[str, Rows]] = {
        GYRO: {"sign_of": KeyRow(one_of("turn", "input"), _WHOSE, usual="turn")},
        ACCELEROMETER: {"sign_of": KeyRow(one_of("input"), _WHOSE, usual="input")},
    }

    def form(self, _: str) -> Form:
        """Return whose sign decides."""
        if "sign_of" not in self.given:
            return {}
        return {
            "form": self.sign_of,
            "says": (("sign_of", self.sign_of),),
            "definition": f"by the sign of the {self.sign_of}",
        }


class Earlier(Keyed):
    """What a maker prints of the same parameter for a shorter horizon."""

    rows: ClassVar[Rows] = {
        "value": KeyRow(OWN, is_needed=True),
        "horizon": KeyRow(
            POSITIVE_TIME, "time after which it has gone that far", is_needed=True
        ),
    }


class AgeingValue(ConstantValue):
    """Specification value of what a parameter has gone a time after its calibration."""

    of_axis = ConstantValue
    besides = "horizon: 1 year"

    rows: ClassVar[Rows] = {
        "horizon": KeyRow(
            POSITIVE_TIME, "time after which it has gone that far", is_needed=True
        ),
        "law": KeyRow(
            one_of("drift", "random_walk"),
            "of other times; unset: what gives the larger value",
        ),
        "earlier": KeyRow(
            items(OWN), "what is printed for shorter horizons, of all axes", usual=()
        ),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "earlier",
            lambda it: it.earlier and not (it.value and it.value.value),
            "is beside one value of all axes above 0, expected that here",
        ),
    )

    def _faults(self) -> dict[tuple[str | int, ...], str]:
        """Return where times and values do not rise to those of the line."""
        horizons = [*(one.horizon for one in self.earlier), self.horizon]
        values = [*(one.value for one in self.earlier), self.value]
        times = {
            ("earlier", place, "horizon"): f"found {one.printed!r} before "
            f"{after.printed!r}, expected times that rise to the horizon of the line"
            for place, (one, after) in enumerate(pairwise(horizons))
            if one.value >= after.value
        }
        sizes = {
            ("earlier", place, "value"): f"found {one.printed!r} before "
            f"{most.printed!r}, expected values that do not fall with time: what has "
            "aged stays so"
            if one.value
            else "found 0, expected more than that"
            for place, (one, most) in enumerate(pairwise(values))
            if one and most and (one.value > most.value or not one.value)
        }
        return {**super()._faults(), **times, **sizes}

    def form(self, _: str) -> Form:
        """Return its law, and its size at the horizons that are printed."""
        size = self.value.value if self.value else 1.0
        law = "" if self.law is None else f", {words(self.law)}"
        before = "".join(
            f", {one.value.printed} after {one.horizon.printed}" for one in self.earlier
        )
        return {
            "form": self.law or "",
            "horizons": (
                *((one.horizon.value, one.value.value / size) for one in self.earlier),
                (self.horizon.value, 1.0),
            ),
            "says": (
                ("horizon", self.horizon.printed),
                *((("law", self.law),) if self.law else ()),
            ),
            "definition": f"after {self.horizon.printed}{law}{before}",
            "notes": [] if self.law else [sentence("values.no_law")],
        }


class ProcessValue(SpecificationValue):
    """Specification value of a random process."""

    rows: ClassVar[Rows] = {
        "distribution": KeyRow(one_of("normal", meant=GAUSSIAN), "a process is normal")
    }


class Filter(Keyed):
    """Butterworth filter that noise has passed; of order 1 a simple pole."""

    rows: ClassVar[Rows] = {
        "corner": KeyRow(
            FREQUENCY, "where it lets half of the power pass", is_needed=True
        ),
        "order": KeyRow(number(1, 20), "number of its poles", is_needed=True),
    }


class SampleNoiseValue(ProcessValue):
    """Specification value of a noise of every sample, or of the rms in a band."""

    of_axis = ProcessValue
    rows: ClassVar[Rows] = {
        "bandwidth": KeyRow(
            or_text(table(Filter), FREQUENCY),
            "noise bandwidth B of an rms, N = rms/sqrt(2 B); unset: of samples",
        )
    }

    def form(self, _: str) -> Form:
        """Return the random walk of an rms in a one-sided noise bandwidth B [Hz].

        rms^2 = 2 N^2 B of white noise N, with B = f_c (pi/2n)/sin(pi/2n) of a
        Butterworth filter of order n, the integral of 1/(1 + (f/f_c)^2n): pi/2 f_c of
        the first order.
        """
        band = self.bandwidth
        if band is None:
            return {}
        if isinstance(band, Quantity):
            B, said = band.value, band.printed
        else:
            angle = pi / (2.0 * band.order)
            B = band.corner.value * angle / sin(angle)
            said = flow({"corner": band.corner.printed, "order": band.order})
        return {
            "form": BAND,
            "factor": 1.0 / sqrt(2.0 * B),
            "says": (("bandwidth", said),),
            "definition": f"rms in a noise bandwidth of {B:.4g} Hz",
        }


class WalkValue(ProcessValue):
    """Value of a random walk, as its coefficient N or as a density of noise."""

    rows: ClassVar[Rows] = {
        "density": KeyRow(
            one_of(*SIDES),
            "of a value per root of hertz; unset: open, the larger N = D taken",
        )
    }
    rules: ClassVar[Rules] = (
        Rule(
            "density",
            lambda it: it.density and it.some_walk,
            "found {density!r} with {some_walk!r}, which is the random walk itself and "
            "no density, expected a value per root of hertz; remove 'density'",
        ),
    )

    @property
    def some_walk(self) -> str:
        """The first value that is no density, as printed; '' where all are."""
        walks = (one.printed for one in self.sizes if not per_root_hertz(one.unit))
        return next(walks, "")

    @property
    def is_open(self) -> bool:
        """Whether it is a density, and the sides of it are not said."""
        return not self.density and any(per_root_hertz(one.unit) for one in self.sizes)


class StabilityValue(ProcessValue):
    """Specification value of the bias stability."""

    rows: ClassVar[Rows] = {
        "definition": KeyRow(
            one_of("sigma", FLOOR),
            "sigma of the process, or the lowest point of the Allan curve",
            usual="sigma",
        ),
        "correlation_time": KeyRow(
            POSITIVE_TIME,
            "of the process; unset: 300 s of a sigma, none of a flicker",
        ),
        "averaging_time": KeyRow(POSITIVE_TIME, "at which the Allan curve is lowest"),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "definition",
            lambda it: it.definition == FLOOR and SIGMAS.get(it.meaning, 1.0) != 1.0,
            "found 'allan_minimum' with meaning {meaning!r}; a point of the Allan "
            "curve is 1 sigma, expected that meaning",
        ),
        Rule(
            "averaging_time",
            lambda it: it.averaging_time and it.definition != FLOOR,
            "is of a floor of the Allan curve, expected definition: allan_minimum "
            "beside it; or remove it",
        ),
        Rule(
            "correlation_time",
            lambda it: (
                it.averaging_time
                and it.correlation_time
                and it.correlation_time.value < it.averaging_time.value
            ),
            "found {correlation_time!r}, below the {averaging_time!r} at which the "
            "Allan curve is lowest, expected that time or more: a Gauss-Markov process "
            "of a shorter one is on its way down there. Remove it, and the floor is "
            "taken as that of flicker noise",
        ),
        Rule(
            "axes",
            lambda it: len({part.is_flicker for part in it.parts}) > 1,
            "is flicker noise (allan_minimum without a correlation time) on some axes "
            "and a Gauss-Markov process on others, expected one of them; say "
            "definition and correlation_time of every axis alike",
        ),
    )

    @property
    def is_flicker(self) -> bool:
        """Whether it is the floor of a curve, and nothing tells of another process."""
        return self.definition == FLOOR and self.correlation_time is None

    @property
    def parts(self) -> list[StabilityValue]:
        """What speaks for the axes: mappings of their own, and the line."""
        axes = self.by_axis.values()
        own = [one for one in axes if isinstance(one, StabilityValue)]
        return own if own and len(own) == len(axes) else [self, *own]

    def form(self, _: str) -> Form:
        """Return flicker noise, whose Allan deviation is 0.664 B at its floor."""
        floors = [one.averaging_time for one in self.parts if one.averaging_time]
        shortest = min(floors, key=lambda one: one.value, default=None)
        says = (("averaging_time", shortest.printed),) if shortest else ()
        if not all(part.is_flicker for part in self.parts):
            return {"says": says}
        return {
            "form": FLICKER,
            "factor": 1.0 / ALLAN_MINIMUM,
            "reading": 1.0 / ALLAN_MINIMUM,
            "low_cut": LOW_CUT,
            "says": (("definition", FLOOR), *says),
            "definition": FLOOR,
            "notes": [
                sentence("values.floor_as_flicker", minimum=ALLAN_MINIMUM),
                sentence("values.low_cut"),
            ],
        }


class FlickerValue(ProcessValue):
    """Specification value of a flicker."""

    of_axis = ProcessValue
    rows: ClassVar[Rows] = {
        "definition": KeyRow(
            one_of("coefficient", FLOOR),
            "B itself, or the lowest point of the Allan curve, 0.664 B",
            usual="coefficient",
        ),
        "low_cut": KeyRow(FREQUENCY, "below which it has no power; unset: once a day"),
    }

    def form(self, _: str) -> Form:
        """Return its coefficient and its low cut."""
        own = self.low_cut
        reading = 1.0 / ALLAN_MINIMUM if self.definition == FLOOR else 1.0
        return {
            "factor": reading,
            "reading": reading,
            "low_cut": own.value if own else LOW_CUT,
            "says": (
                ("definition", self.definition),
                ("low_cut", own.printed if own else f"{LOW_CUT!r} Hz"),
            ),
            "definition": f"{self.definition}, no power below "
            + (own.printed if own else "once a day"),
            "notes": [] if own else [sentence("values.low_cut")],
        }


class Whole(SpecificationValue):
    """Specification value for all axes, some of which may say otherwise."""

    rows: ClassVar[Rows] = {"axes": KeyRow(OWN)}
    rules: ClassVar[Rules] = (
        Rule(
            (),
            lambda it: it.value is None and it.axes is None,
            "names neither value nor axes, expected one of them",
        ),
        Rule(
            "axes",
            lambda it: it.value is None and it.absent,
            "without value, expected all axes; missing: {absent}",
        ),
    )

    @property
    def absent(self) -> str:
        """The axes that a mapping of them does not name."""
        return ", ".join(axis for axis, one in self.by_axis.items() if not one)


class Open(Whole):
    """Specification value whose meaning the maker may leave open."""

    rows: ClassVar[Rows] = {
        "reading": KeyRow(
            items(OWN),
            "what the value may mean, where the maker leaves it open: all are computed",
            usual=(),
        )
    }

    def _faults(self) -> dict[tuple[str | int, ...], str]:
        """Return what is wrong with words that do not leave one thing open."""
        words, own = self.reading, [*self.by_axis.values()]
        if not words:
            return super()._faults()
        keys = [key for key, group in READINGS if {*words} <= {*group}]
        key = keys[0] if keys else ""
        found = f"found {', '.join(words)}, expected"
        groups = "; ".join(", ".join(group) for _, group in READINGS)
        tests = (
            (
                len({*words}) < max(2, len(words)),
                (
                    f"{found} two different words at the least; what is known is said "
                    "by its own key"
                ),
            ),
            (not keys, f"{found} words that exclude one another: {groups}"),
            (key in self.given, f"leaves open what {key!r} says, expected one of them"),
            (
                any(isinstance(one, SpecificationValue) for one in own),
                (
                    "is of the whole line, and an axis is a mapping of its own; give "
                    "the axes as values"
                ),
            ),
            (
                "max" in words and self.distribution == "normal",
                "may be 'max', a half-width, which is never 'normal'; remove that",
            ),
            (
                key == "density"
                and not all(per_root_hertz(one.unit) for one in self.sizes),
                "is of a value per root of hertz; this is the random walk itself",
            ),
        )
        wrong = [text for is_wrong, text in tests if is_wrong]
        said: dict[tuple[str | int, ...], str] = (
            {("reading",): wrong[0]} if wrong else {}
        )
        return {**super()._faults(), **said}


class Residual(ConstantValue, Whole):
    """What is left over temperature, said of another line."""


@dataclass(frozen=True, kw_only=True)
class ReadValue:
    """A line as the models take it, and what had to be assumed for that."""

    line: ErrorLine
    assumptions: tuple[str, ...]


@cache
def value_of(line: Source, sensor: str) -> ValueKind:
    """Return the kind of a value of that line: a text, or a mapping of its family."""
    family = _family(line)
    size = measured(
        line.like(sensor), Sign.ANY if line.is_signed else Sign.NOT_NEGATIVE
    )
    title = f"{family.__name__.removesuffix('Value')} in {line.like(sensor)}"
    own = family.of_sensor.get(sensor, {})
    needed: Rows = {"value": KeyRow(size, is_needed=True)}
    is_open = line.varies and sensor in SENSORS
    is_few = is_open or (line.varies and sensor == STATION)
    few = FROM_FEW if is_few and not line.is_initial else {}
    if line.axes == ONE_VALUE:
        alone = table(family, {**own, **needed, **few}, title)
        return or_text(alone, size, family.besides)
    of_axis = family.of_axis or family
    one_axis = or_text(table(of_axis, {**needed, **few}, f"{title}, one axis"), size)
    by_axis = rows_of(dict.fromkeys(line.axes, one_axis))
    beside = beside_of(line, sensor)
    readings = tuple(word for group in readings_of(line) for word in group if is_open)
    every: dict[str, KeyRow | None] = {
        "reading": replace(Open.rows["reading"], kind=items(one_of(*readings)))
        if readings
        else None,
        "value": KeyRow(size),
        **few,
        "axes": KeyRow(table(rows=by_axis, title=f"{title}, by axis")),
        "adds_to": KeyRow(one_of(beside), f"what is no part of {beside}, given as well")
        if beside
        else None,
        "earlier": replace(
            family.rows["earlier"],
            kind=items(table(Earlier, needed, f"{title}, earlier")),
        )
        if "earlier" in family.rows
        else None,
        **{
            one.name: KeyRow(measured(one.unit, Sign.POSITIVE), one.says)
            for one in line.keys
        },
    }
    bases = (family, Open if readings else Whole)
    whole = type(family.__name__, bases, {"__doc__": family.__doc__})
    return or_text(
        table(whole, {**own, **given_of(every)}, title), size, family.besides
    )


def readings_of(line: Source) -> tuple[tuple[str, ...], ...]:
    """Return what a value of that line may mean: lists of words that exclude others."""
    rows = _family(line).rows
    defined = rows["definition"].kind.allowed if "definition" in rows else ()
    fits: dict[str, Callable[[tuple[str, ...]], object]] = {
        "definition": lambda group: {*group} <= {*defined},
        "": lambda group: (
            line.axes == AXES
            if group == (PER_AXIS, TOGETHER)
            else line.over_temperature and line.stays.replace(" ", "-") == group[0]
        ),
    }
    return tuple(
        group
        for key, group in READINGS
        if (fits[key](group) if key in fits else key in rows)
    )


def beside_of(line: Source, sensor: str) -> str:
    """Return the line that says the same again, beside that one; '' if none."""
    there = {one.name for one in lines_of(sensor)}
    return next((name for name in line.beside if name in there), "")


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
        given = _family(line).of(value=given)
    # In an order that is not the file's: of equal ones, what stays in this line.
    words = tuple(sorted(getattr(given, "reading", ()), key=_ORDER.index))
    is_sided = isinstance(given, WalkValue) and given.is_open and not words
    words = SIDES if is_sided else words
    if not words:
        return _read(line, sensor, given)
    read = {word: _under(line, sensor, given, word) for word in words}
    lines = tuple((word, one.line) for word, one in read.items())
    key = Name(line.name, owner=sensor)
    if is_sided and known is not None:
        taken, lines = known.sides, ()
        text = sentence("values.density_of_maker", sides=taken, source=known.source)
        said = sentence("assumed.of", key=key, text=text)
    elif is_sided:
        taken = TWO_SIDED
        said = sentence("assumed.of", key=key, text=sentence("values.density"))
    else:
        taken = words[first_largest([one.largest for _, one in lines])]
        said = sentence("values.open", key=key, readings=words, taken=taken)
    return ReadValue(
        line=replace(read[taken].line, readings=lines),
        assumptions=(said, *read[taken].assumptions),
    )


def _under(
    line: Source, sensor: str, given: SpecificationValue, word: str
) -> ReadValue:
    """Read a value under one of its readings."""
    if word == OVER_TEMPERATURE:
        other = source_of(sensor, line.over_temperature)
        same = ("value", "axes", "meaning", "includes", "condition", "source")
        kept = {key: getattr(given, key) for key in same}
        return _read(other, sensor, Residual.of(**kept))
    key = next(key for key, group in READINGS if word in group)
    says: dict[str, object] = {"reading": (), **({key: word} if key else {})}
    one = _read(line, sensor, given.but(**says))
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
    family = _family(line)
    part = family.of(value=given) if isinstance(given, Quantity) else given
    named = line.axes if part.by_axis else line.axes[:1]
    axes = [_axis(part, axis) for axis in named] * (len(line.axes) // len(named))
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
    usual: Form = {"notes": (), "says": (), "factor": 1.0, "definition": ""}
    form = usual | part.form(sensor)
    given_keys = {one: getattr(part, one.name, None) for one in line.keys}
    unsaid = [one.name for one, quantity in given_keys.items() if quantity is None]
    form_notes = [
        *form["notes"],
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
        u=np.array([a.u for a in axes]) * form["factor"],
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
        * form["factor"],
        low_cut=np.full(len(axes), form["low_cut"]) if "low_cut" in form else None,
        degrees_of_freedom=_degrees_of_freedom(part, [a.part for a in axes]),
        form=form.get("form", ""),
        horizons=form.get("horizons", ()),
        factor=form["factor"],
        reading=form.get("reading", 1.0),
        says=(*form["says"], *(one for one in own_says if one[0] not in unsaid)),
        density=axes[0].density,
        adds_to=getattr(part, "adds_to", None) or "",
        meaning=say([_meaning(line, a.part) for a in axes]),
        definition=form["definition"]
        or say([a.definition for a in axes])
        or ", ".join(f"{words(name)} {text}" for name, text in own_says),
        includes=say([a.part.includes or "" for a in axes]),
        horizon=say([_text(a.part.horizon) for a in axes]),
        condition=say([a.part.condition or "" for a in axes]),
        source=say([a.part.source or "" for a in axes]),
    )
    return ReadValue(line=taken, assumptions=tuple(dict.fromkeys(assumptions)))


def _degrees_of_freedom(
    line: SpecificationValue, axes: list[SpecificationValue]
) -> tuple[float | None, ...]:
    """Return them as a line has them: of one value for all axes one."""
    each: tuple[float | None, ...] = tuple(getattr(one, FEW, None) for one in axes)
    if not any(each):
        return ()
    return each if line.by_axis else each[:1]


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


# What a file may say of values that are more than those of a constant or a process, by
# the word of the row.
FAMILIES: Mapping[str, type[SpecificationValue]] = {
    "nonlinearity": NonlinearityValue,
    "asymmetry": AsymmetryValue,
    "sample_noise": SampleNoiseValue,
    "flicker": FlickerValue,
    "ageing": AgeingValue,
    "stability": StabilityValue,
    "walk": WalkValue,
}


def _family(line: Source) -> type[SpecificationValue]:
    """Return what a file may say about a value of that line."""
    return FAMILIES.get(line.value, ProcessValue if line.process else ConstantValue)


def _meaning(line: Source, part: SpecificationValue) -> str:
    """Return what a value means; of what is no spread, unless it is said, just that."""
    is_said = line.varies or "meaning" in part.given
    return str(part.meaning) if is_said else FIXED


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


def divisor(meaning: str, shape: Distribution) -> float:
    """Return what is printed over the standard uncertainty that it means [1].

    Of a half-width that of its shape (JCGM 100:2008, 4.3.7 to 4.3.9); where the shape
    is normal the half-width bounds the sigma itself.
    """
    if meaning not in HALF_WIDTHS:
        return SIGMAS.get(meaning, 1.0)
    own = shape.half_width if isfinite(shape.half_width) else 1.0
    return own / HALF_WIDTHS[meaning]


def _axis(given: SpecificationValue, axis: str) -> _Axis:
    """Return what a specification value says about one axis."""
    own: SpecificationValue | Quantity | None = given.by_axis.get(axis)
    part = own if isinstance(own, SpecificationValue) else given
    # Whole lets no value pass that leaves an axis without a value.
    quantity = cast("Quantity", own if isinstance(own, Quantity) else part.value)
    lost = given.given - part.given
    is_bound, is_process = part.meaning in HALF_WIDTHS, isinstance(part, ProcessValue)
    usual = "uniform" if is_bound and not is_process else "normal"
    shape = BY_NAME[part.distribution or usual]
    density, open_density = "", False
    if isinstance(part, WalkValue) and per_root_hertz(quantity.unit):
        density, open_density = part.density or TWO_SIDED, part.density is None
    definition, time, no_time = "", None, False
    if isinstance(part, StabilityValue) and not part.is_flicker:
        definition = part.definition if "definition" in part.given else ""
        no_time = part.correlation_time is None
        time = CORRELATION_TIME
        if part.correlation_time is not None:
            time = part.correlation_time.value
    notes: tuple[tuple[object, str, dict[str, Any]], ...] = (
        (lost & STATED, "values.own_mapping", {"lost": sorted(lost & STATED)}),
        (open_density, "values.density", {}),
        (is_bound and is_process, "values.bound", {"meaning": part.meaning}),
        (
            usual == "uniform" and part.distribution is None,
            "values.uniform",
            {"meaning": part.meaning},
        ),
        (part.meaning == "typical", "values.typical", {}),
        (definition == FLOOR, "values.floor_as_sigma", {"minimum": ALLAN_MINIMUM}),
        (no_time, "values.correlation_time", {"time": CORRELATION_TIME}),
    )
    u = quantity.value / divisor(part.meaning, shape) * WALK_PER_DENSITY[density]
    return _Axis(
        part=part,
        quantity=quantity,
        u=u / ALLAN_MINIMUM if definition == FLOOR else u,
        shape=shape,
        density=density,
        definition=definition,
        correlation_time=time,
        notes=tuple(sentence(key, **says) for is_so, key, says in notes if is_so),
    )
