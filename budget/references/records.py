"""Reference budget: inputs, settings, quantity values, words, versions.

The rows of what a file may hold stand beside the records that it is read into.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache, cached_property
from math import inf
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from budget.distributions import LEAST_COVERAGE, MOST_COVERAGE
from budget.inputs.fields import (
    TRUTH,
    KeyRow,
    ValueKind,
    by_name,
    items,
    number,
    one_of,
    or_else,
    table,
    text,
)
from budget.known import Known
from budget.model.source import OWNERS
from budget.model.sources import every_source
from budget.names import AIDING, ALIGNMENT, MISSION, OUTPUTS, PARAMETERS, Name
from budget.settings import (
    MOST_TRIALS,
    SAMPLES,
    UNTESTED,
    Asked,
    Use,
    every_row,
    rows,
)
from budget.settings import Row as Setting

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

Job = Literal["analyze", "mission", "compare", "allocate"]
Role = Literal[
    "device", "procedure", "station", "mission", "requirement", "costs", "result"
]

FALLING = {"interval_low", "conformance"}  # the worse, the smaller
MANY = 1000  # inputs of a reference at the most
NONE, ONE, MAYBE = range(1), range(1, 2), range(2)
SOME = range(1, 10**9)  # or more: a file may have many variants
ANY = range(10**9)
RESULT = "result"  # of a recorded calibration: JSON, and none ships

# How many files of each role a job takes.
FILES: Mapping[str, Mapping[str, range]] = {
    job: {
        "device": SOME,
        "mission": missions,
        "procedure": procedures,
        "station": MAYBE,
        "requirement": limits,
        "costs": costs,
        RESULT: results,
    }
    for job, procedures, missions, limits, costs, results in (
        ("analyze", ONE, NONE, MAYBE, NONE, MAYBE),
        ("mission", ONE, ONE, MAYBE, NONE, MAYBE),
        ("compare", SOME, MAYBE, ONE, NONE, ANY),
        ("allocate", ONE, MAYBE, ONE, MAYBE, NONE),
    )
}
JOBS = tuple(FILES)

# Files hold quantities between 1e-30 and 1e30 SI: no budget comes near this, and what
# is computed of two such numbers does not overflow.
LARGEST = 1e100


_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]").search, "has a control character"
_NO_DIGEST = (
    lambda value: not re.fullmatch("[0-9a-f]{64}", value),
    "is no SHA-256, expected 64 digits of 0 to 9 and a to f",
)
LINE, WORDS = text(400, _CONTROL), text(4000, _CONTROL)
SHA256 = text(64, _NO_DIGEST)
FINITE = number(-LARGEST, LARGEST, is_whole=False)
NOT_NEGATIVE = number(0.0, LARGEST, is_whole=False)
OPTIONAL = KeyRow(LINE, usual="")


def needed(kind: ValueKind) -> KeyRow:
    """Return the row of a key that must be there."""
    return KeyRow(kind, is_needed=True)


@dataclass(frozen=True, kw_only=True)
class StoredInput:
    """One input file as it was."""

    role: Role
    # Path from the folder of the reference, with '/'; or the name of a shipped file.
    file: str
    variant: str = ""  # '' for the base; of a comparison the base and every variant
    changes: tuple[str, ...] = ()  # laid over a device, each SENSOR.LINE=VALUE
    sha256: str  # of the file's bytes
    text: str


INPUT = table(
    StoredInput,
    {
        "role": needed(one_of(*FILES["analyze"])),
        "file": needed(text(400, _CONTROL, (lambda value: not value, "is empty"))),
        "variant": OPTIONAL,
        "changes": KeyRow(items(LINE), usual=()),
        "sha256": needed(SHA256),
        "text": needed(  # a file has one line of it in each entry of a list
            or_else(
                items(text(10**7)),
                lambda node, gravity, read: "\n".join(read(node, gravity)),
            )
        ),
    },
)


@dataclass(frozen=True, kw_only=True)
class Stored(Asked, Use):
    """What was asked for besides the files; None leaves it to the job's default.

    Coverage and error reference are None too where a requirement rules them, so that a
    change of the requirement is one of the result. The calibration is one without a
    procedure, 'none' or 'factory'.
    """

    @classmethod
    def of(cls, asked: Asked, inputs: Use) -> Self:
        """Put together what a call asks for."""
        given = {name: getattr(inputs, name) for name in every_row(Use)}
        if given["calibration"] not in UNTESTED:
            given["calibration"] = None
        samples = asked.samples or (SAMPLES if asked.sobol else None)
        own = vars(asked) | {"samples": samples, "sobol": False}
        return cls(**own | given)


STORED = {name: row for name, row in rows(Stored, "check").items() if name != "sobol"}


def _stored_kind(row: Setting) -> ValueKind:
    """Return the kind of what a file may have for a setting."""
    choices = UNTESTED if row.words else row.choices
    kind = one_of(*choices) if choices else LINE
    if row.several:
        return items(kind)
    if row.least is not None:
        return number(row.least, inf if row.most is None else row.most)
    if row.fault is not None:
        return number(LEAST_COVERAGE, MOST_COVERAGE, is_whole=False)
    return kind


SETTINGS = table(
    Stored,
    {
        name: KeyRow(_stored_kind(row), usual=row.default)
        for name, row in STORED.items()
    },
)


@dataclass(frozen=True, kw_only=True)
class Item:
    """What a quantity value or a word is of."""

    subject: str  # 'gyro.bias.x', 'gyro.bias_stability', 'hg4930.yaml#C gyro'
    quantity: str  # 'standard_uncertainty'
    partner: str = ""  # a source, or the other output of a correlation

    def __str__(self) -> str:
        """Name it in one line."""
        return " ".join(
            text for text in (self.subject, self.quantity, self.partner) if text
        )


@dataclass(frozen=True, kw_only=True)
class QuantityValue:
    """Number of a result, in its printed unit, and its tolerance."""

    subject: str  # output, source or sensor
    quantity: str
    partner: str = ""  # the source or other output beside it
    unit: str
    value: float
    floor: float = 0.0  # a difference at or below it is rounding [unit]
    standard_error: float | None = None  # [unit]; None: no trial touches it
    degrees_of_freedom: float | None = None  # None: so many that they do not count
    # Of a proportion: the value times this is a count.
    trials: int | None = None
    lower_bound: bool = False  # this or worse: a line not given would add to it

    @cached_property
    def item(self) -> Item:
        """What it is of."""
        return Item(subject=self.subject, quantity=self.quantity, partner=self.partner)

    @property
    def known(self) -> Known:
        """The number, with the end that lines which are not given leave open."""
        if not self.lower_bound:
            return Known(self.value)
        if self.quantity in FALLING:
            return Known(self.value, low=-inf)
        return Known.at_least(self.value)

    @property
    def is_sampled(self) -> bool:
        """Whether another seed gives another value."""
        return self.standard_error is not None or self.trials is not None


@dataclass(frozen=True, kw_only=True)
class NominalProperty:
    """Property without magnitude (JCGM 200:2012, 1.30): verdict, status, lines."""

    subject: str  # sensor or source
    quantity: str
    text: str
    # Quantity of the same subject that decides it. Where that number is no surer than
    # its trials, the word is not either: it has moved only if the number has.
    rests_on: str = ""
    unit: ClassVar[str] = ""
    is_sampled: ClassVar[bool] = False

    @cached_property
    def item(self) -> Item:
        """What it is of."""
        return Item(subject=self.subject, quantity=self.quantity)

    @property
    def known(self) -> str:
        """The text."""
        return self.text


QUANTITY_VALUE = table(
    QuantityValue,
    {
        **dict.fromkeys(("subject", "quantity", "unit"), needed(LINE)),
        "partner": OPTIONAL,
        "value": needed(FINITE),
        "floor": KeyRow(NOT_NEGATIVE, usual=0.0),
        "standard_error": KeyRow(NOT_NEGATIVE),
        "degrees_of_freedom": KeyRow(number(1e-300, is_whole=False)),
        "trials": KeyRow(number(1, MOST_TRIALS)),
        "lower_bound": KeyRow(TRUTH, usual=False),
    },
)
NOMINAL_PROPERTY = table(
    NominalProperty,
    {
        **dict.fromkeys(("subject", "quantity"), needed(LINE)),
        "text": needed(WORDS),
        "rests_on": OPTIONAL,
    },
)


# Owners of what a mission asks for and adds: every tool that takes one knows these.
OF_MISSION = frozenset({MISSION, AIDING, ALIGNMENT})
# What this version can say something of: quantities of sources and of outputs.
# Lines that one kind of sensor had before the other: known by their full names.
LATER = frozenset(
    {
        "accelerometer.scale_factor_asymmetry",
        *("gyro.scale_factor_quadratic", "gyro.scale_factor_cubic"),
    }
)


@cache
def known_now() -> frozenset[str]:
    """Return what this version can say something of, lines of other packages too."""
    return frozenset({*(source.name for source in every_source()), *OUTPUTS, *LATER})


# What the version had that did not yet write it into its references.
KNOWN_FIRST = frozenset(
    {
        *PARAMETERS,
        *("bias_repeatability", "bias_stability", "sample_noise"),
        *("angle_random_walk", "velocity_random_walk"),
        *("rate_random_walk", "acceleration_random_walk"),
        *("scale_factor_repeatability", "scale_factor_nonlinearity"),
        *("scale_factor_asymmetry", "mounting_repeatability"),
    }
)


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """All that a result says, as a flat list."""

    numbers: tuple[QuantityValue, ...]
    words: tuple[NominalProperty, ...] = ()
    # Error sources and parameters that the tool had when it was made, of a file those
    # of the first version: what a later one has learnt is no change of what is stored.
    known: frozenset[str] = field(default_factory=known_now)

    def knows(self, item: Item) -> bool:
        """Whether the tool that made it had the quantities that an item is of."""
        names = [n for n in (item.subject, item.partner) if isinstance(n, Name)]
        return all(not n.owner or n.owner in OF_MISSION or self._has(n) for n in names)

    def _has(self, name: Name) -> bool:
        """Whether the tool that made it had a quantity of that owner."""
        return (name.group if name.group in LATER else name.quantity) in self.known

    def known_part(self, text: str) -> str:
        """Return a list of sources without those that the tool did not have."""
        if self.known >= known_now():  # most are: the names need not be made
            return text
        unknown = self._unknown
        return ", ".join(name for name in text.split(", ") if name not in unknown)

    @cached_property
    def _unknown(self) -> frozenset[Name]:
        """Sources and outputs that the tool which made it did not have."""
        return frozenset(
            name
            for quantity in known_now()
            for owner in OWNERS
            if not self._has(name := Name(quantity, owner=owner))
        )

    @cached_property
    def by_item(self) -> Mapping[Item, QuantityValue | NominalProperty]:
        """Return numbers and words by what they are of."""
        words = {one.item: one for one in self.words}
        return {one.item: one for one in self.numbers} | words


@dataclass(frozen=True, kw_only=True)
class ReferenceBudget(Snapshot):
    """A stored budget: all that a result said, and what it was made of."""

    job: Job
    inputs: tuple[StoredInput, ...]
    settings: Stored
    versions: Mapping[str, str]  # of the tool and what it stands on


REFERENCE = {  # the rows of a file, but for its format and its checksum
    "job": needed(one_of(*JOBS)),
    "inputs": needed(items(INPUT, least=1, most=MANY)),
    "settings": needed(SETTINGS),
    "numbers": needed(items(QUANTITY_VALUE, least=1)),
    "words": KeyRow(items(NOMINAL_PROPERTY), usual=()),
    "known": KeyRow(
        or_else(
            items(LINE, most=MANY),
            lambda node, gravity, read: frozenset(read(node, gravity)),
        ),
        usual=tuple(sorted(KNOWN_FIRST)),
    ),
    "versions": needed(by_name(LINE, LINE)),
}


def files_fault(job: str, roles: Sequence[str]) -> str:
    """Say which files are too few or too many for a job; '' where they are right.

    On a mission without a procedure a unit is as its maker calibrated it.
    """
    for role, counts in FILES[job].items():
        found = roles.count(role)
        if found not in counts and (
            found or role != "procedure" or MISSION not in roles
        ):
            some = f"{counts[0]} or more" if counts is SOME else ""
            allowed = some or " or ".join(map(str, counts))
            return (
                f"{found} of role {role}, a reference of kind {job} has {allowed} of it"
            )
    return ""
