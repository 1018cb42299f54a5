"""What Zhao 2019 prints, how it may be read, and what is found of it.

The file is printed.yaml beside this one; a finding is a printed number or claim,
ours beside it, and a verdict, in the words of that file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from budget.documents import written
from budget.inputs.checking import check
from budget.inputs.fields import Strict, fault, faults
from budget.inputs.reader import read
from budget.inputs.tree import describe
from budget.language import note, say, term
from budget.model.sources import lines_of
from budget.names import ANGLES, Name
from budget.units import NUMBER, PPM

FILE = Path(__file__).with_name("printed.yaml")
RUNS = 25  # of each condition, section 3.1
# In which the text gives an order, and how much of it a relative error of 1 is: the
# nominal 2 arcsec and 2.5 deg/h of 3.1.
UNITS = {"1": 1.0, "arcsec": 2.0, "deg/h": 2.5}


class Agreement(StrEnum):
    """How ours stands to what is printed; the paper's file says what each means."""

    AGREES = "agrees"
    AGREES_IN_ORDER = "agrees in order"
    FITS_MEAN = "fits a mean over 25 runs"
    FITS_SINGLE = "fits a single run"
    MISPRINT = "misprint, mended"
    EXPLAINED = "differs, explained"
    READING = "differs, a reading fits"
    UNEXPLAINED = "unexplained"
    READING_FITS = "reading that fits"
    READING_FAILS = "reading that does not fit"


# What `ours` is.
VALUE = term("value")
U_SINGLE = term("u, single run")
U_MEAN = note("u, mean over {runs} runs", runs=RUNS)
WORD = term("word")


@written(
    "finding",
    """
    section: part of the study
    where: the number stands in the paper
    printed: as it is
    ours [as printed]: a number where the paper prints one, else words
    quantity: what a number of ours is
    ratio [1]: ours over printed, of absolute values; null where one is no number or
      zero
    verdict
    p_single [1]: probability of values at least as extreme in a single run; of an order
      of magnitude, of that order
    p_mean [1]: likewise in a mean over 25
    why: in words
    """,
)
@dataclass(frozen=True, kw_only=True)
class Finding:
    """One row."""

    section: str  # part of the study: a key of Paper.sections
    where: str  # where the number stands in the paper
    # The same in a table: group of rows ('bias stability'), head of the row ('bias x'),
    # and what is special about it ('from its angles'), if anything.
    place: tuple[str, ...]
    # As printed, or the root mean square of printed entries where `where` says so.
    printed: str
    # A number where the paper prints one, a word or formula where it prints one [same
    # unit as printed].
    ours: float | str
    # What a number of ours is: VALUE, or the standard uncertainty that a random entry
    # is held against.
    quantity: str = VALUE
    # Ours over printed, of absolute values [1]; None where one of them is no number or
    # zero.
    ratio: float | None = None
    verdict: Agreement
    why: str  # in words
    # Probability of values at least as extreme as the printed one, two-sided, if it is
    # a single run or a mean over 25; of an order of magnitude, the probability of that
    # order [1]. None where nothing is random.
    p_single: float | None = None
    p_mean: float | None = None
    is_summary: bool = False  # whether the row speaks of several entries together

    @property
    def group(self) -> str:
        """The group of rows of a table that it is in."""
        return self.place[0]


def _check_digits(text: str) -> str:
    """Refuse a text that is no number."""
    if not re.fullmatch(NUMBER, text):
        raise fault(f"found {text!r}, expected a number as printed, such as '1e-14'")
    return text


Digits = Annotated[str, AfterValidator(_check_digits)]
Sensor = Literal["gyro", "accelerometer"]
Parameter = Literal["scale_factor", "mounting_angle", "bias"]
Angle = Literal["xy", "xz", "yx", "yz", "zx", "zy"]
Claim = Literal["affects", "no effect"]


class PrintedRow(Strict):
    """One row of Table 1: relative errors [1], angles in the order of the table."""

    scale_factor: Annotated[tuple[Digits, ...], Field(min_length=3, max_length=3)]
    mounting_angle: Annotated[tuple[Digits, ...], Field(min_length=6, max_length=6)]
    bias: Annotated[tuple[Digits, ...], Field(min_length=3, max_length=3)]


class OfSource(Strict):
    """Something said of one error source of one sensor; '' is none at all."""

    section: str
    sensor: Sensor
    source: str = ""

    @property
    def name(self) -> Name:
        """The full name of the source."""
        return Name(self.source, owner=self.sensor) if self.source else Name("")

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        """Refuse a source that the sensor has not."""
        known = [line.name for line in lines_of(self.sensor)]
        if self.source and self.source not in known:
            message = f"a {self.sensor} has no source {self.source!r}, allowed: "
            raise faults({("source",): message + ", ".join(known)})
        return self


class PrintedOrders(OfSource):
    """Orders of magnitude that the text gives under one condition."""

    condition: str
    unit: Literal["1", "arcsec", "deg/h"] = "1"
    note: str = ""  # where the text gives it in another way
    errors: dict[Parameter, Digits]  # '0' for none [unit]


class Conclusion(OfSource):
    """What the paper says of one source and some parameters."""

    claims: dict[Parameter, Claim]


class PrintedFigure(Strict):
    """Figure 1, 2, 3 or 4: what is stepped, and the order that the text reads off."""

    source: Literal["scale_factor_nonlinearity", "scale_factor_asymmetry"]
    parameter: Parameter
    step: float  # [1]
    order: Digits

    @property
    def stepped(self) -> str:
        """The step as the paper has it: '30 ppm x i'."""
        return f"{self.step / PPM:g} ppm x i"


class PrintedFormula(Strict):
    """One formula for one parameter, or alike for several."""

    equation: str
    names: tuple[str, ...]
    unit: str
    printed: str
    ours: str = ""  # where it differs
    is_slip: bool = True  # of the press, where it differs; otherwise an approximation
    note: str = ""


class GivenReading(Strict):
    """A reading of the inputs of one row: what varies, and what is changed."""

    row: str
    name: str
    sources: tuple[str, ...]
    pause: float | None = None  # between windows [s]
    sample_noise: float | None = None  # in each sample [deg/h]
    divisor: float = 1.0  # of the angle random walk [1]
    once_a_window: bool = False  # noise added to the sum of a window
    about_zero: bool = False  # angles drawn about 0, errors counted from nominal


class NoiseReading(Strict):
    """A reading of the accelerometer noise."""

    name: str
    in_si: bool = False  # m/s^2 in place of g
    once_a_window: bool = False


class GivenFinding(Strict):
    """How a kind of finding is told; what stands in braces is filled in."""

    section: str
    where: str
    place: Annotated[tuple[str, ...], Field(min_length=2, max_length=3)]
    printed: str = ""  # where that is no single number
    why: str | dict[str, str]  # by what is the case
    is_summary: bool = True


class _Part:
    """A part of a sentence: a number to so many digits {u:3}, else two; {key:words}.

    Other formats are those of Python. Words and texts are said in the language of the
    context, so that a note that has them can be.
    """

    def __init__(self, value: object) -> None:
        self.value = value

    def __reduce__(self) -> tuple[object, ...]:
        """Take the value along to another process."""
        return _Part, (self.value,)

    def __getattr__(self, name: str) -> _Part:
        """Give a part of the part."""
        return _Part(getattr(self.value, name))

    def __format__(self, spec: str) -> str:
        """Write the value."""
        value = self.value
        if spec == "words":
            return say(words(str(value)))
        if isinstance(value, float) and (spec.isdigit() or not spec):
            return say_number(value, int(spec or 2))
        if isinstance(value, str):
            return say(value)
        return format(value, spec)


class Paper(Strict):
    """Everything that is printed, the readings, and the words of the study."""

    title: str
    reference: str
    sections: dict[str, str]
    verdicts: dict[str, str]  # what each means
    cards: dict[str, tuple[str, ...]]  # verdicts that are counted together
    assumptions: tuple[str, ...]
    notes: dict[str, str]
    angle_order: Annotated[tuple[Angle, ...], Field(min_length=6, max_length=6)]
    table_1: dict[str, PrintedRow]
    orders: tuple[PrintedOrders, ...]
    bound: Digits
    figures: dict[str, PrintedFigure]
    figure_3: dict[str, str]
    readings: tuple[GivenReading, ...]
    noise_readings: tuple[NoiseReading, ...]
    formulas: tuple[PrintedFormula, ...]
    conclusions: tuple[Conclusion, ...]
    findings: dict[str, GivenFinding]

    @model_validator(mode="after")
    def _check_words(self) -> Self:
        """Hold meanings, cards and angles to what there is, each once."""
        if sorted(self.angle_order) != sorted(ANGLES):
            angles = ", ".join(self.angle_order)
            message = f"has {angles}, expected every angle once: {', '.join(ANGLES)}"
            raise faults({("angle_order",): message})
        known = [str(verdict) for verdict in Agreement]
        counted = [word for card in self.cards.values() for word in card]
        for key, found in (("verdicts", list(self.verdicts)), ("cards", counted)):
            if sorted(found) != sorted(known):
                message = f"has {describe(', '.join(found))}, expected each once: "
                raise faults({(key,): message + ", ".join(known)})
        for kind, finding in self.findings.items():
            if finding.section not in self.sections:
                message = f"{finding.section!r} is no section, expected one of: "
                message += ", ".join(self.sections)
                raise faults({("findings", kind, "section"): message})
        return self

    @property
    def farthest(self) -> dict[str, float]:
        """The largest step of each source that the figures step, by source [1]."""
        return {figure.source: RUNS * figure.step for figure in self.figures.values()}

    def entries(self, source: str) -> tuple[str, ...]:
        """Return a row of Table 1, all twelve entries in the order of our outputs."""
        row = self.table_1[source]
        angles: dict[str, str] = dict(
            zip(self.angle_order, row.mounting_angle, strict=True)
        )
        return (*row.scale_factor, *(angles[name] for name in ANGLES), *row.bias)

    def tell(
        self,
        kind: str,
        case: str = "",
        *,
        ours: float | str,
        verdict: Agreement,
        printed: str = "",
        against: float | None = None,
        ratio: float | None = None,
        quantity: str = VALUE,
        p: tuple[float | None, float | None] = (None, None),
        **said: object,
    ) -> Finding:
        """Put a finding into the words of the paper's file.

        `kind` and `case` say which of `findings` and which of its reasons, `p` has that
        of a single run and of a mean, `against` is what ours is over for the ratio
        (without it the printed number), `said` what is filled in beside those. All else
        is as in Finding; without `printed` it is what the file says.
        """
        given = self.findings[kind]
        why = given.why if isinstance(given.why, str) else given.why[case]
        if against is None and re.fullmatch(NUMBER, printed):
            against = float(printed)
        parts = {
            key: _Part(value)
            for key, value in (said | {"ours": ours, "against": against}).items()
        }
        if isinstance(ours, float) and against is not None:
            ratio = abs(ours / against) if ours and against else None
        return Finding(
            section=given.section,
            where=note(given.where, **parts),
            place=tuple(note(place, **parts) for place in given.place),
            printed=printed or note(given.printed, **parts),
            ours=ours,
            quantity=WORD if isinstance(ours, str) else quantity,
            ratio=ratio,
            verdict=verdict,
            why=note(why, **parts),
            p_single=p[0],
            p_mean=p[1],
            is_summary=given.is_summary,
        )


def load_paper() -> Paper:
    """Read the shipped file.

    Raises
    ------
    SpecError
        Something is wrong with it, each at its place.
    """
    return check(read(FILE, FILE.name), Paper)


def agrees_if(condition: bool) -> Agreement:  # noqa: FBT001 - the one thing it asks
    """Return the verdict on what can only agree or stay unexplained."""
    return Agreement.AGREES if condition else Agreement.UNEXPLAINED


def say_number(value: float, digits: int = 2) -> str:
    """Write a number within a sentence: '7.7e-8', '3890', '0.16'."""
    text = f"{value:.{digits}g}"
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if e else text


def words(key: str) -> str:
    """Turn a key into words: 'scale factor'."""
    return key.replace("_", " ")
