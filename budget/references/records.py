"""Reference budget: inputs, settings, quantity values, words, versions.

The records of what is stored are the format of the file as well: `store` reads a file
into them, and their constraints are those of its JSON Schema.
"""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003 - pydantic reads the annotations
from dataclasses import dataclass, field, make_dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    GetPydanticSchema,
    WithJsonSchema,
)
from pydantic_core.core_schema import no_info_after_validator_function

from budget.distributions import LEAST_COVERAGE, MOST_COVERAGE
from budget.model.source import OWNERS
from budget.model.sources import every_source
from budget.names import AIDING, ALIGNMENT, MISSION, OUTPUTS, PARAMETERS, Name
from budget.settings import (
    MOST_TRIALS,
    SAMPLES,
    UNTESTED,
    Asked,
    Row,
    Use,
    every_row,
    rows,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

Job = Literal["analyze", "mission", "compare", "allocate"]
Role = Literal["device", "procedure", "station", "mission", "requirement", "costs"]

MANY = 1000  # inputs of a reference at the most
NONE, ONE, MAYBE = range(1), range(1, 2), range(2)
SOME = range(1, 10**9)  # or more: a file may have many variants

# How many files of each role a job takes.
FILES: Mapping[str, Mapping[str, range]] = {
    job: {
        "device": SOME,
        "mission": missions,
        "procedure": procedures,
        "station": MAYBE,
        "requirement": limits,
        "costs": costs,
    }
    for job, procedures, missions, limits, costs in (
        ("analyze", ONE, NONE, MAYBE, NONE),
        ("mission", ONE, ONE, MAYBE, NONE),
        ("compare", SOME, MAYBE, ONE, NONE),
        ("allocate", ONE, MAYBE, ONE, MAYBE),
    )
}
JOBS = tuple(FILES)

# Files hold quantities between 1e-30 and 1e30 SI: no budget comes near this, and what
# is computed of two such numbers does not overflow.
LARGEST = 1e100


def _joined(lines: Any) -> str:  # noqa: ANN401 - not yet checked
    """Return the text of lines; a file has one in each entry of a list."""
    if not isinstance(lines, list) or not all(isinstance(one, str) for one in lines):
        raise ValueError("input should be a list of lines")
    return "\n".join(lines)


PLAIN = r"^[^\x00-\x1f\x7f-\x9f]*$"  # no control characters
Line = Annotated[str, Field(max_length=400, pattern=PLAIN)]
Words = Annotated[str, Field(max_length=4000, pattern=PLAIN)]
Lines = Annotated[
    str,
    BeforeValidator(_joined),
    WithJsonSchema({"type": "array", "items": {"type": "string"}}),
]
Sha256 = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
Finite = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=LARGEST)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
STRICT = ConfigDict(extra="forbid", strict=True)


@dataclass(frozen=True, kw_only=True)
class StoredInput:
    """One input file as it was."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    role: Role
    # Path from the folder of the reference, with '/'; or the name of a shipped file.
    file: Annotated[Line, Field(min_length=1)]
    variant: Line = ""  # '' for the base; of a comparison the base and every variant
    changes: tuple[Line, ...] = ()  # laid over a device, each SENSOR.LINE=VALUE
    sha256: Sha256  # of the file's bytes
    text: Lines


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


def _stored_type(row: Row) -> Any:  # noqa: ANN401 - a type
    """Return what a file may have for a setting."""
    choices = UNTESTED if row.words else row.choices
    kind: Any = Literal[choices] if choices else Line
    if row.several:
        kind = tuple[kind, ...]
    elif row.least is not None:
        kind = Annotated[int, Field(ge=row.least, le=row.most)]
    elif row.fault is not None:
        kind = Annotated[float, Field(ge=LEAST_COVERAGE, le=MOST_COVERAGE)]
    return kind | None if row.default is None else kind


# As a file has them.
Settings = Annotated[
    Stored,
    GetPydanticSchema(
        lambda _, schema: no_info_after_validator_function(
            lambda one: Stored(**vars(one)),
            schema(
                make_dataclass(
                    "Asked",
                    [
                        (name, _stored_type(row), field(default=row.default))
                        for name, row in STORED.items()
                    ],
                    namespace={
                        "__pydantic_config__": STRICT,
                        "__doc__": Stored.__doc__,
                    },
                    frozen=True,
                    kw_only=True,
                )
            ),
        )
    ),
]


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

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    subject: Line  # output, source or sensor
    quantity: Line
    partner: Line = ""  # the source or other output beside it
    unit: Line
    value: Finite
    floor: NotNegative = 0.0  # a difference at or below it is rounding [unit]
    standard_error: NotNegative | None = None  # [unit]; None: no trial touches it
    degrees_of_freedom: Positive | None = None  # None: so many that they do not count
    # Of a proportion: the value times this is a count.
    trials: Annotated[int, Field(ge=1, le=MOST_TRIALS)] | None = None
    lower_bound: bool = False  # this or worse: a line not given would add to it

    @cached_property
    def item(self) -> Item:
        """What it is of."""
        return Item(subject=self.subject, quantity=self.quantity, partner=self.partner)

    @property
    def is_sampled(self) -> bool:
        """Whether another seed gives another value."""
        return self.standard_error is not None or self.trials is not None


@dataclass(frozen=True, kw_only=True)
class NominalProperty:
    """Property without magnitude (JCGM 200:2012, 1.30): verdict, status, lines."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    subject: Line  # sensor or source
    quantity: Line
    text: Words
    # Quantity of the same subject that decides it. Where that number is no surer than
    # its trials, the word is not either: it has moved only if the number has.
    rests_on: Line = ""
    unit: ClassVar[str] = ""
    is_sampled: ClassVar[bool] = False
    lower_bound: ClassVar[bool] = False

    @cached_property
    def item(self) -> Item:
        """What it is of."""
        return Item(subject=self.subject, quantity=self.quantity)

    @property
    def value(self) -> str:
        """The text."""
        return self.text


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

    numbers: Annotated[tuple[QuantityValue, ...], Field(min_length=1)]
    words: tuple[NominalProperty, ...] = ()
    # Error sources and parameters that the tool had when it was made, of a file those
    # of the first version: what a later one has learnt is no change of what is stored.
    known: Annotated[frozenset[Line], Field(max_length=1000)] = field(
        default_factory=known_now
    )

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

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    job: Job
    inputs: Annotated[tuple[StoredInput, ...], Field(min_length=1, max_length=MANY)]
    settings: Settings
    versions: Mapping[Line, Line]  # of the tool and what it stands on


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
