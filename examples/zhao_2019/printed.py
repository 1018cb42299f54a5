"""What Zhao 2019 prints, how it may be read, and what is found of it.

The file is printed.yaml beside this one; a finding is a printed number or claim,
ours beside it, and a verdict, in the words of that file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, ClassVar

from budget.documents import written
from budget.inputs.fields import (
    TRUTH,
    Keyed,
    KeyRow,
    Rows,
    ValueKind,
    by_name,
    check,
    fault,
    items,
    number,
    one_of,
    or_else,
    table,
    text,
)
from budget.inputs.reader import read
from budget.inputs.tree import Node, describe
from budget.language import note, say, term
from budget.model.sources import SENSORS, lines_of
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


def _check_digits(node: Node, gravity: float, own: Any) -> str:  # noqa: ANN401
    """Read a number in quotes; refuse a text that is none."""
    text: str = own(node, gravity)
    if not re.fullmatch(NUMBER, text):
        raise fault(f"found {text!r}, expected a number as printed, such as '1e-14'")
    return text


SAID = text(10_000)
DIGITS = or_else(SAID, _check_digits)
NUMBER_OF_ANY_SIZE = number(-1e300, 1e300, is_whole=False)
PARAMETER = one_of("scale_factor", "mounting_angle", "bias")
NEEDED = KeyRow(SAID, is_needed=True)
MAYBE = KeyRow(SAID, usual="")


def _needed(kind: ValueKind) -> KeyRow:
    """Return the row of a key that must be there."""
    return KeyRow(kind, is_needed=True)


def _some(kind: ValueKind, number: int) -> KeyRow:
    """Return the row of a key with so many values."""
    return _needed(items(kind, least=number, most=number))


# One row of Table 1: relative errors [1], angles in the order of the table.
PRINTED_ROW = table(
    rows={
        "scale_factor": _some(DIGITS, 3),
        "mounting_angle": _some(DIGITS, 6),
        "bias": _some(DIGITS, 3),
    }
)


class OfSource(Keyed):
    """Something said of one error source of one sensor; '' is none at all."""

    rows: ClassVar[Rows] = {
        "section": NEEDED,
        "sensor": _needed(one_of(*SENSORS)),
        "source": MAYBE,
    }

    @property
    def name(self) -> Name:
        """The full name of the source."""
        return Name(self.source, owner=self.sensor) if self.source else Name("")

    def _faults(self) -> dict[tuple[str, ...], str]:
        """Refuse a source that the sensor has not."""
        known = [line.name for line in lines_of(self.sensor)]
        if not self.source or self.source in known:
            return {}
        message = f"a {self.sensor} has no source {self.source!r}, allowed: "
        return {("source",): message + ", ".join(known)}


class PrintedOrders(OfSource):
    """Orders of magnitude that the text gives under one condition."""

    rows: ClassVar[Rows] = {
        "condition": NEEDED,
        "unit": KeyRow(one_of("1", "arcsec", "deg/h"), usual="1"),
        "note": MAYBE,  # where the text gives it in another way
        "errors": _needed(by_name(DIGITS, PARAMETER)),  # '0' for none [unit]
    }


class Conclusion(OfSource):
    """What the paper says of one source and some parameters."""

    rows: ClassVar[Rows] = {
        "claims": _needed(by_name(one_of("affects", "no effect"), PARAMETER))
    }


class PrintedFigure(Keyed):
    """Figure 1, 2, 3 or 4: what is stepped, and the order that the text reads off."""

    rows: ClassVar[Rows] = {
        "source": _needed(
            one_of("scale_factor_nonlinearity", "scale_factor_asymmetry")
        ),
        "parameter": _needed(PARAMETER),
        "step": _needed(NUMBER_OF_ANY_SIZE),  # [1]
        "order": _needed(DIGITS),
    }

    @property
    def stepped(self) -> str:
        """The step as the paper has it: '30 ppm x i'."""
        return f"{self.step / PPM:g} ppm x i"


# One formula for one parameter, or alike for several.
PRINTED_FORMULA = table(
    rows={
        "equation": NEEDED,
        "names": _needed(items(SAID)),
        "unit": NEEDED,
        "printed": NEEDED,
        "ours": MAYBE,  # where it differs
        "is_slip": KeyRow(TRUTH, usual=True),  # of the press; else an approximation
        "note": MAYBE,
    }
)
# A reading of the inputs of one row: what varies, and what is changed.
GIVEN_READING = table(
    rows={
        "row": NEEDED,
        "name": NEEDED,
        "sources": _needed(items(SAID)),
        "pause": KeyRow(NUMBER_OF_ANY_SIZE),  # between windows [s]
        "sample_noise": KeyRow(NUMBER_OF_ANY_SIZE),  # in each sample [deg/h]
        "divisor": KeyRow(
            NUMBER_OF_ANY_SIZE, usual=1.0
        ),  # of the angle random walk [1]
        "once_a_window": KeyRow(TRUTH, usual=False),  # noise added to a window's sum
        # Angles drawn about 0, errors counted from nominal.
        "about_zero": KeyRow(TRUTH, usual=False),
    }
)
# A reading of the accelerometer noise.
NOISE_READING = table(
    rows={
        "name": NEEDED,
        "in_si": KeyRow(TRUTH, usual=False),  # m/s^2 in place of g
        "once_a_window": KeyRow(TRUTH, usual=False),
    }
)
# How a kind of finding is told; what stands in braces is filled in.
GIVEN_FINDING = table(
    rows={
        "section": NEEDED,
        "where": NEEDED,
        "place": _needed(items(SAID, least=2, most=3)),
        "printed": MAYBE,  # where that is no single number
        "why": _needed(  # by what is the case
            or_else(
                by_name(SAID),
                lambda node, gravity, read: (
                    node.value if isinstance(node.value, str) else read(node, gravity)
                ),
            )
        ),
        "is_summary": KeyRow(TRUTH, usual=True),
    }
)


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


class Paper(Keyed):
    """Everything that is printed, the readings, and the words of the study."""

    rows: ClassVar[Rows] = {
        **dict.fromkeys(("title", "reference"), NEEDED),
        "sections": _needed(by_name(SAID)),
        "verdicts": _needed(by_name(SAID)),  # what each means
        "cards": _needed(by_name(items(SAID))),  # verdicts that are counted together
        "assumptions": _needed(items(SAID)),
        "notes": _needed(by_name(SAID)),
        "angle_order": _some(one_of(*ANGLES), 6),
        "table_1": _needed(by_name(PRINTED_ROW)),
        "orders": _needed(items(table(PrintedOrders))),
        "bound": _needed(DIGITS),
        "figures": _needed(by_name(table(PrintedFigure))),
        "figure_3": _needed(by_name(SAID)),
        "readings": _needed(items(GIVEN_READING)),
        "noise_readings": _needed(items(NOISE_READING)),
        "formulas": _needed(items(PRINTED_FORMULA)),
        "conclusions": _needed(items(table(Conclusion))),
        "findings": _needed(by_name(GIVEN_FINDING)),
    }

    def _faults(self) -> dict[tuple[str, ...], str]:
        """Hold meanings, cards and angles to what there is, each once."""
        if sorted(self.angle_order) != sorted(ANGLES):
            angles = ", ".join(self.angle_order)
            message = f"has {angles}, expected every angle once: {', '.join(ANGLES)}"
            return {("angle_order",): message}
        known = [str(verdict) for verdict in Agreement]
        counted = [word for card in self.cards.values() for word in card]
        for key, found in (("verdicts", list(self.verdicts)), ("cards", counted)):
            if sorted(found) != sorted(known):
                message = f"has {describe(', '.join(found))}, expected each once: "
                return {(key,): message + ", ".join(known)}
        sections = ", ".join(self.sections)
        return {
            ("findings", kind, "section"): f"{finding.section!r} is no section, "
            f"expected one of: {sections}"
            for kind, finding in self.findings.items()
            if finding.section not in self.sections
        }

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
    paper: Paper = check(read(FILE, FILE.name), table(Paper))
    return paper


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
