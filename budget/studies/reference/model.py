"""The shape of a reference file: its keys, and what each may hold."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from budget.distributions import LEAST_COVERAGE, MOST_COVERAGE
from budget.spec.fields import Strict

# Files hold quantities between 1e-30 and 1e30 SI: no budget comes near this, and what
# is computed of two such numbers does not overflow.
LARGEST = 1e100
# No more than the command line allows: a forged reference keeps no machine busy.
MOST_TRIALS = 100_000_000
MOST_SAMPLES = 2**20  # Sobol' points of one scramble

Line = Annotated[str, Field(max_length=400, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")]
Finite = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=LARGEST)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
Count = Annotated[int, Field(ge=0, lt=2**63)]


class InputEntry(Strict):
    """One input file as it was."""

    role: Literal["device", "procedure", "requirement", "costs"]
    file: Annotated[Line, Field(min_length=1)] = Field(
        description="path from the folder of this file, or bare name of a shipped one"
    )
    variant: Line = ""
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    text: tuple[str, ...] = Field(description="its content, line by line")


class SettingsEntry(Strict):
    """What was asked for besides the files."""

    method: Literal["gum", "monte-carlo", "simulation"] = "gum"
    trials: Annotated[int, Field(ge=2, le=MOST_TRIALS)] | None = None
    max_trials: Annotated[int, Field(ge=2, le=MOST_TRIALS)] | None = None
    digits: Annotated[int, Field(ge=1, le=2)] = 1
    seed: Annotated[int, Field(ge=0)] = 0
    coverage: Annotated[float, Field(ge=LEAST_COVERAGE, le=MOST_COVERAGE)] | None = None
    interval: Literal["symmetric", "shortest"] = "symmetric"
    reference: Literal["nominal", "as_tested", "next_turn_on"] | None = None
    only: tuple[Line, ...] = ()
    samples: Annotated[int, Field(ge=2, le=MOST_SAMPLES)] | None = None
    strategy: Literal["equal", "proportional", "cost"] | None = None
    fix: tuple[Line, ...] = ()


class NumberEntry(Strict):
    """One number of the result."""

    subject: Line
    quantity: Line
    partner: Line = ""
    unit: Line
    value: Finite
    floor: NotNegative = Field(
        default=0.0, description="a difference at or below it is rounding"
    )
    standard_error: NotNegative | None = Field(
        default=None, description="of the sampling; unset: no trial touches it"
    )
    degrees_of_freedom: Positive | None = None
    trials: Annotated[Count, Field(ge=1)] | None = Field(
        default=None, description="of a proportion"
    )


class WordEntry(Strict):
    """One word of the result."""

    subject: Line
    quantity: Line
    text: Annotated[str, Field(max_length=4000, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")]
    rests_on: Line = Field(default="", description="the quantity that decides it")


class ReferenceFile(Strict):
    """A reference budget."""

    format: Literal["budget-reference/1"]
    checksum: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] = Field(
        description="SHA-256 of all the rest, as JSON with sorted keys and no spaces"
    )
    job: Literal["analyze", "compare", "allocate"]
    inputs: Annotated[tuple[InputEntry, ...], Field(min_length=1, max_length=1000)]
    settings: SettingsEntry
    numbers: Annotated[tuple[NumberEntry, ...], Field(min_length=1)]
    words: tuple[WordEntry, ...] = ()
    known: Annotated[tuple[Line, ...], Field(max_length=1000)] | None = Field(
        default=None,
        description="sources and parameters of the tool then; unset: those of 0.1.0",
    )
    versions: dict[Line, Line] = Field(description="of the tool and what it stands on")
