"""What may be asked for: every setting and input once, with all that is known of it.

Options of commands, signatures and docstrings of functions, checks, documents, stored
references and tables of methods are read from the rows here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, is_dataclass, replace
from decimal import Decimal
from difflib import get_close_matches
from functools import partial, wraps
from inspect import Parameter, Signature, cleandoc, signature
from numbers import Integral, Real
from textwrap import fill, indent
from typing import TYPE_CHECKING, Any, TypeVar

from budget.documents import Documented, written
from budget.errors import CallError, UnitError
from budget.names import Name

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from budget.inputs.files import File
    from budget.inputs.records import (
        Device,
        Mission,
        Procedure,
        Recording,
        Requirement,
        Station,
    )

T = TypeVar("T")
Progress = Callable[[str, int, int], None]  # what is done, steps done, steps in all
Stage = Callable[[int, int], None]
FILES = ("device", "procedure", "station", "mission", "requirement")
NAMED = ("source", "output")
UNTESTED = ("none", "factory")  # in the place of a procedure
LONGEST_NUMBER = 20  # digits; longer ones cost time to read
LEAST_RATE, MOST_RATE = 1e-3, 1e9  # [Hz]
LEAST_TRIALS, MOST_TRIALS = 2, 100_000_000  # of a call and of stored references
METHODS = ("gum", "monte-carlo", "simulation")
REFERENCES = ("nominal", "as_tested", "next_turn_on")
SAMPLES = 2048  # where Sobol' indices are asked for without a number

JUDGED, USED = "What is judged", "Calibration and use"
COMPUTED, GOES = "How it is computed", "Where it goes"
CLI, LIBRARY = "cli", "library"


@dataclass(frozen=True, kw_only=True)
class Row:
    """What is known of a field besides its type and its usual value."""

    help: str  # beside the option
    jobs: frozenset[str]  # in which it means something
    said: str = ""  # beside the parameter and in documents, where that is other words
    at: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # other in a job
    only: str = ""  # where it is given, CLI or LIBRARY; '' both
    panel: str = COMPUTED  # of `--help`
    option: str = ""  # where that is not its name
    metavar: str | None = None
    takes: str = ""  # what it names: the kind of a file, 'source', 'line', 'output'
    words: tuple[str, ...] = ()  # that may stand in the place of such a name
    choices: tuple[str, ...] = ()
    least: int | None = None
    most: int | None = None
    read: Callable[[str], Any] | None = None  # of a text of the command line
    fault: Callable[[Any], str] | None = None  # what is allowed, '' of a good value
    several: bool = False  # may be given again
    needed: bool = False
    default: Any = None
    type: str = ""  # of the field, as it is written there
    name: str = ""  # of the field
    document: str | None = (
        None  # how its row begins; None: with its name, '': there is none
    )
    has_line: bool = False  # whether the table of methods has words of its own for it

    @property
    def is_on(self) -> bool:
        """Whether it is done unless one asks for it not to be."""
        return self.default is True

    @property
    def flag(self) -> str:
        """What one types."""
        no = "no-" if self.is_on else ""
        return self.option or f"--{no}{self.name.replace('_', '-')}"

    @property
    def text(self) -> str:
        """What it is, for the one who calls a function."""
        return self.said or self.help


def setting(
    default: Any,  # noqa: ANN401 - of the field's type
    text: str,
    jobs: str,
    **row: Any,  # noqa: ANN401 - fields of Row
) -> Any:  # noqa: ANN401 - what dataclasses take for a value of the field's type
    """Return a field with its row."""
    made = Row(help=text, jobs=frozenset(jobs.split()), default=default, **row)
    return field(default=default, metadata={"row": made})


def rows(kind: type, job: str, where: str = "") -> dict[str, Row]:
    """Return the fields that mean something in a job, each as it is there."""
    there = {
        name: replace(row, **_other(row, row.at[job])) if job in row.at else row
        for name, row in every_row(kind).items()
        if job in row.jobs
    }
    return {
        name: row for name, row in there.items() if row.only in {"", where or row.only}
    }


_KNOWN: dict[type, dict[str, Row]] = {}


def every_row(kind: type) -> dict[str, Row]:
    """Return all rows by the names of their fields, those of what it stands on too."""
    if kind not in _KNOWN:
        bases: list[Any] = [one for one in kind.__mro__[::-1] if is_dataclass(one)]
        _KNOWN[kind] = {
            one.name: replace(one.metadata["row"], name=one.name, type=str(one.type))
            for base in bases
            for one in fields(base)
            if "row" in one.metadata
        }
    return _KNOWN[kind]


def _other(row: Row, there: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is other in a job; other words of an option are those of both."""
    said = "" if "help" in there else row.said
    return {"said": said, **there}


def ask(kind: type[T], job: str, given: Mapping[str, Any]) -> T:
    """Return what is asked for: what is given, else what is usual in the job.

    Raises
    ------
    CallError
        Where names are expected there is something else.
    """
    found = rows(kind, job)
    values = {name: row.default for name, row in found.items()}
    for name, value in given.items():
        row = found[name]
        values[name] = (
            _many(name, value, row)
            if row.several
            else row.read(value)  # as at a terminal
            if row.read and isinstance(value, str)
            else value
        )
    return kind(**values)


def _many(name: str, given: Any, row: Row) -> tuple[Any, ...]:  # noqa: ANN401 - not checked
    """Return what may be given again, one alone too."""
    if isinstance(given, str) or (row.read and isinstance(given, Real)):
        given = (given,)
    if not isinstance(given, Iterable):
        raise CallError(f"{name} is {given!r}, expected names: ['gyro.bias']")
    values = tuple(given)
    if row.takes in NAMED and (
        wrong := [one for one in values if not isinstance(one, str)]
    ):
        raise CallError(f"{name} has {wrong[0]!r}, expected names: 'gyro.bias'")
    return values


def check(job: str, *asked: object) -> None:
    """Refuse what names no choice, or numbers that mean nothing in a job.

    Raises
    ------
    CallError
        With all faults of words, or all of numbers.
    """
    found = [
        (name, getattr(one, name), row)
        for one in asked
        for name, row in rows(type(one), job).items()
    ]
    given = [
        (name, value, row)
        for name, value, row in found
        if value is not row.default or isinstance(value, bool)
    ]
    words = [
        f"{name} is {value!r}, allowed: {', '.join(row.choices)}"
        for name, value, row in given
        if row.choices and value not in row.choices
    ]
    numbers = [
        f"{name} is {value!r}, allowed: {allowed}"
        for name, value, row in given
        if (allowed := _allowed(value, row))
    ]
    if words or numbers:
        raise CallError("; ".join(words or numbers))


def _allowed(value: object, row: Row) -> str:
    """Return which numbers are allowed, '' of one of these."""
    if row.fault is not None:
        return row.fault(value)
    if row.least is None:
        return ""
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    most = float("inf") if row.most is None else row.most
    if is_whole and row.least <= value <= most:  # type: ignore[operator]
        return ""
    to = " or more" if row.most is None else f" to {row.most}"
    return f"whole numbers, {row.least}{to}"


def _whole(text: str, or_else: str = "") -> int:
    """Read a whole number, '1000000' or '1e6'."""
    number = Decimal(0)
    if len(text) <= LONGEST_NUMBER and re.fullmatch(r"[0-9.]+(e\+?[0-9]+)?", text):
        with suppress(ArithmeticError):
            number = Decimal(text)
    if not (LEAST_TRIALS <= number <= MOST_TRIALS) or number % 1:
        raise CallError(
            f"{text!r} is no number of trials; give a whole number, as 1000000 or 1e6, "
            f"{LEAST_TRIALS} or more and {MOST_TRIALS} at the most{or_else}"
        )
    return int(number)


def _trials(text: str) -> int | None:
    """Read a number of trials; 'adaptive' is none."""
    return None if text == "adaptive" else _whole(text, ", or 'adaptive'")


def _coverage(text: str) -> float:
    """Read a probability, '0.95' or '95 %', to the nearest double."""
    from budget.distributions import COVERAGES

    number, percent, rest = text.partition("%")
    try:
        value = float(Decimal(number.strip()) / (100 if percent else 1))
    except ArithmeticError:  # no number, or one beyond what a Decimal can be
        value = float("nan")
    if rest.strip() or _no_coverage(value):
        raise CallError(
            f"{text!r} is no probability of an interval; give one {COVERAGES}, "
            "as 0.95 or '95 %'"
        )
    return value


def _no_coverage(value: object) -> str:
    """Return which probabilities are allowed, '' of one of these."""
    from budget.distributions import COVERAGES, is_coverage

    return "" if isinstance(value, Real) and is_coverage(float(value)) else COVERAGES


def read_rate(text: str) -> float:
    """Read a sampling rate: '200', '200 Hz', '1 kHz' [Hz].

    Raises
    ------
    CallError
        It is none.
    """
    from budget.units import NUMBER, parse_quantity

    is_bare = len(text) <= LONGEST_NUMBER and re.fullmatch(NUMBER, text.strip())
    try:
        rate = float(text) if is_bare else parse_quantity(text, "Hz").value
    except UnitError as error:
        raise CallError(str(error)) from None
    if not LEAST_RATE <= rate <= MOST_RATE:
        raise CallError(
            f"{text!r} is no sampling rate; give {LEAST_RATE:g} to {MOST_RATE:g} Hz, "
            "as 200"
        )
    return rate


def _time(text: str) -> float:
    """Read a time after the start of a mission, '10 min' [s]."""
    from budget.units import parse_quantity

    try:
        time = parse_quantity(text, "s", bare="s").value
    except UnitError as error:
        raise CallError(str(error)) from None
    if not time > 0.0:
        raise CallError(f"{text!r} is not after the start; give one above 0 s")
    return time


_JUDGING = "analyze mission report compare decide allocate"


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a result depends on besides the input files, as asked for."""

    method: str = setting(
        "gum",
        "How uncertainty is propagated.",
        "analyze mission report compare decide check",
        said="How uncertainty is propagated; contributions of the sources are always "
        "the law's.",
        at={
            "compare": {
                "help": "gum is the fast screen.",
                "choices": METHODS[:2],
                "default": "monte-carlo",
            },
            "decide": {"help": "gum is the fast screen.", "choices": METHODS[:2]},
        },
        choices=METHODS,
        document="method",
        has_line=True,
    )
    trials: int | None = setting(
        None,
        "Monte Carlo trials (adaptive) or simulated runs (200).",
        "analyze mission report compare check",
        said="Of Monte Carlo (adaptive without it), or simulated runs (200).",
        at={
            "compare": {
                "help": "Monte Carlo trials of each device at first (100000).",
                "read": _whole,
                "metavar": "N",
            }
        },
        metavar="N|adaptive",
        read=_trials,
        least=LEAST_TRIALS,
        most=MOST_TRIALS,
        has_line=True,
    )
    digits: int = setting(
        1,
        "Digits of the uncertainty that adaptive trials and validation make sure.",
        "analyze mission report check",
        least=1,
        most=2,
        has_line=True,
    )
    max_trials: int | None = setting(
        None,
        "Where adaptive trials stop at the latest (2000000).",
        "analyze mission report compare check",
        at={
            "compare": {
                "help": "The most of a device whose verdict or rank is open (1600000)."
            }
        },
        metavar="N",
        read=_whole,
        least=LEAST_TRIALS,
        most=MOST_TRIALS,
        document="",
    )
    seed: int = setting(
        0,
        "Same seed, same numbers.",
        "analyze mission report compare decide allocate sweep check simulate",
        metavar="S",
        least=0,
        has_line=True,
    )
    coverage: float | None = setting(
        None,
        "Probability of the intervals, 0.95 or '95 %' (0.95).",
        "analyze mission report sweep check diff calibrate",
        said="Probability of the intervals; the requirement's, else 0.95.",
        metavar="P",
        read=_coverage,
        fault=_no_coverage,
        document="coverage [1]",
        has_line=True,
    )
    interval: str = setting(
        "symmetric",
        "Coverage interval of Monte Carlo results.",
        "analyze mission report check",
        said="Coverage interval of Monte Carlo results; by the law both are mean +- k "
        "u.",
        choices=("symmetric", "shortest"),
        has_line=True,
    )
    reference: str | None = setting(
        None,
        "Error reference: what errors are counted from (nominal).",
        "analyze report sweep check diff",
        said="Error reference, what errors are counted from; the requirement's, else "
        "'nominal'.",
        choices=REFERENCES,
        has_line=True,
    )
    validate: bool = setting(
        True,  # noqa: FBT003 - the usual value
        "Do not validate GUM propagation by Monte Carlo.",
        "analyze mission report compare allocate sweep",
        said="Whether Monte Carlo checks the law of propagation.",
        at={
            "compare": {
                "help": "By gum: check every one by Monte Carlo.",
                "default": False,
            },
            "allocate": {
                "said": "Whether Monte Carlo checks, and corrects, the allocation."
            },
            "sweep": {"default": False},
        },
        document="",
    )
    sobol: bool = setting(
        False,  # noqa: FBT003 - the usual value
        "Estimate Sobol' indices of the sources too.",
        "analyze mission report check",
        only=CLI,
        document="",
    )
    samples: int | None = setting(
        None,
        f"Sobol' points in each of 8 scrambles ({SAMPLES}).",
        "analyze mission report check",
        said="Points in each of eight scrambles for Sobol' indices; without it there "
        "are none.",
        metavar="N",
        least=2,
        most=2**20,
        document="sobol_samples = samples",
        has_line=True,
    )
    only: Sequence[str] = setting(
        (),
        "Count only this source, as gyro.bias_stability or bias_stability.",
        "analyze mission report check diff",
        said="Sources that count, all others being 0; a bare name means every owner.",
        metavar="SOURCE",
        takes="source",
        several=True,
        has_line=True,
    )
    outputs: Sequence[str] = setting(
        (),
        "Show only these, as gyro, gyro.bias, gyro.bias.z or bias.z, or what is "
        "derived of the mounting angles: rotation, non_orthogonality, misalignment.",
        "analyze report sweep",
        said="What is asked for, 'gyro.rotation' or 'bias.z': parameters, and what is "
        "derived of them; all that is estimated without it.",
        at={
            "sweep": {
                "said": "As of `analyze`; of a mission names as `budget[...]` takes "
                "them, or what several begin or end with: 'mission.position'."
            }
        },
        panel=GOES,
        metavar="NAME,...",
        takes="output",
        several=True,
        document="outputs?",
        has_line=True,
    )
    matrices: bool = setting(
        False,  # noqa: FBT003 - the usual value
        "Add the matrices that turn readings into inputs, with uncertainties.",
        "analyze report",
        panel=GOES,
        document="",
    )
    missing: str = setting(
        "refuse",
        "What stands for expected specifications not given: nothing, the worst or the "
        "median of comparable devices, or a distribution predicted from them. Exit "
        "codes go by refuse.",
        "analyze mission report compare decide export check diff",
        said="What stands for expected lines that are not given: nothing, the worst or "
        "the median of comparable devices, or a distribution predicted from them.",
        panel=JUDGED,
        choices=("refuse", "worst", "typical", "predict"),
        document="missing if fills",
        has_line=True,
    )

    strategy: str | None = setting(
        None,
        "How limits are shared out (proportional; cost with --costs).",
        "allocate station check",
        said="How limits are shared out; 'proportional' without it, 'cost' where there "
        "are costs.",
        at={
            "station": {
                "help": "How figures share the limits: in equal parts, or in "
                "proportion to the procedure's own station.",
                "said": "How figures share the limits: in equal parts, or in "
                "proportion to those of the procedure's own station.",
                "choices": ("equal", "proportional"),
                "default": "equal",
            },
        },
        choices=("equal", "proportional", "cost"),
        document="",
    )
    fix: Sequence[str] = setting(
        (),
        "Hold this specification, as gyro.bias_stability.",
        "allocate check",
        only=CLI,
        metavar="SOURCE",
        takes="source",
        several=True,
        document="",
    )

    def settle(self, requirement: Requirement | None = None) -> Settings:
        """Return it with what a requirement rules, if there is one.

        Raises
        ------
        CallError
            An option asks for another coverage or reference than the requirement does.
        """
        ruled = {
            name: getattr(requirement or _USUAL, name)
            for name in ("coverage", "reference")
        }
        given = {
            name: value for name in ruled if (value := getattr(self, name)) is not None
        }
        faults = [
            f"--{name} {value} differs from the requirement's {name} {ruled[name]}"
            for name, value in given.items()
            if value != ruled[name]
        ]
        if faults and requirement is not None:
            raise CallError(
                "; ".join(faults) + "; leave the option out, or change it in "
                f"{requirement.origin.file}"
            )
        own = {one.name: getattr(self, one.name) for one in fields(Asked)}
        named = {
            option: tuple(
                Name(name.strip()) for text in own[option] for name in text.split(",")
            )
            for option in ("only", "outputs")
        }
        samples = self.samples or (SAMPLES if self.sobol else None)
        return Settings(**own | ruled | given | named | {"samples": samples})


@dataclass(frozen=True, kw_only=True)
class Engine:
    """Who does the work, and how it is talked about; nothing of it changes a number."""

    workers: int = setting(
        1,
        "Processes, as many as there are processors at the most; changes no number.",
        "analyze mission report compare decide check characterise",
        said="Processes; changes no number.",
        metavar="N",
        least=1,
    )
    cluster: str | None = setting(
        None,
        "Run on a Dask cluster, as tcp://host:port; changes no number.",
        "analyze mission report compare",
        only=CLI,
        metavar="ADDRESS",
    )
    executor: Executor | None = setting(
        None,
        "Does the work in place of local processes.",
        "analyze compare characterise",
        only=LIBRARY,
    )
    progress: Progress | None = setting(
        None,
        "Called with what is being done, steps done and steps in all.",
        "analyze compare decide allocate characterise",
        only=LIBRARY,
    )
    talk: Callable[[str], None] | None = setting(
        None,
        "Called with a line for people before work that may take long.",
        "analyze",
        only=LIBRARY,
    )

    def stage(self, what: str) -> Stage | None:
        """Return what a method calls with steps done and in all."""
        return None if self.progress is None else partial(self.progress, what)


def fills(asked: Asked) -> bool:
    """Whether anything stands for expected lines that are not given."""
    return asked.missing != "refuse"


def further(settings: Settings) -> dict[str, str]:
    """Return what tables have no words of their own for, where it is not as usual."""
    return {
        name: str(getattr(settings, name))
        for name, row in every_row(Asked).items()
        if row.document != ""
        and not row.has_line
        and getattr(settings, name) != row.default
    }


@dataclass(frozen=True, kw_only=True)
class Settings(Asked, Documented):
    """Everything besides the input files that a result depends on.

    What is asked for, coverage and error reference as a requirement has them, and, as
    part of the result, what was made of it.
    """

    coverage: float = 0.95
    reference: str = "nominal"
    only: tuple[Name, ...] = ()
    outputs: tuple[Name, ...] = ()
    # What was made of it.
    formulas: str = setting("", "Of the calibration.", "")
    normals_per_trial: int | None = setting(
        None, "Normal random numbers that a trial takes.", ""
    )
    sobol_scrambles: int | None = setting(None, "Scrambles of Sobol' points.", "")


_USUAL = Settings()


@dataclass(frozen=True, kw_only=True)
class Use:
    """What a unit was calibrated by, and what it is used in."""

    calibration: Procedure | File | None = setting(
        None,
        "What calibrated the unit: nothing, its maker, or a procedure (its maker for a "
        "mission; the paper's for limits on the calibration).",
        "analyze mission report compare allocate station sweep check diff",
        said="What calibrated the unit, in the place of a procedure: 'none', 'factory' "
        "or a procedure.",
        panel=USED,
        metavar="none|factory|PROCEDURE",
        takes="procedure",
        words=UNTESTED,
    )
    age: str | None = setting(
        None,
        "Time from the calibration to its use, as '1 year': what ages has gone that "
        "long (--reference next_turn_on).",
        f"{_JUDGING} station export sweep check diff",
        said="Time from the calibration to its use, '1 year', where no file gives one.",
        panel=USED,
        metavar="TIME",
    )
    environment: str | None = setting(
        None,
        "That the unit is used in, as 'temperature 20 degC, vibration 1 g' "
        "(difference from the calibration, 1 sigma; rms), or none, as there "
        "(--reference next_turn_on).",
        f"{_JUDGING} station export sweep check diff",
        said="That it is used in, 'temperature 20 degC, vibration 1 g' or 'none', "
        "where no file says so.",
        panel=USED,
        metavar="TEXT|none",
    )


@dataclass(frozen=True, kw_only=True)
class Inputs(Use):
    """The files that a result depends on, with what the call says in their place."""

    requirement: Requirement | File | None = setting(
        None,
        "Requirement file; its coverage and error reference rule.",
        "analyze mission report compare allocate station sweep check calibrate history",
        said="What it is judged against; its coverage and error reference rule.",
        at={
            "compare": {"only": CLI, "needed": True},
            "allocate": {"needed": True},
            "station": {"needed": True},
        },
        panel=JUDGED,
        metavar="FILE",
        takes="requirement",
    )
    changes: Sequence[str] = setting(
        (),
        "Another value than the file's, as gyro.bias_stability='0.02 deg/h', of an "
        "axis gyro.bias_repeatability.x=..., of one device NAME:gyro....",
        f"{_JUDGING} station export check diff devices validate simulate calibrate "
        "history",
        only=CLI,
        panel=JUDGED,
        option="--set",
        metavar="SPEC=VALUE",
        takes="line",
        several=True,
    )
    mission: Mission | File | None = setting(
        None,
        "Mission file, or the name of one that ships, as bench.",
        f"{_JUDGING} sweep check diff",
        said="Whose errors are asked for, or what limits on a mission are on; at a "
        "later turn-on.",
        at={"mission": {"needed": True}},
        panel=JUDGED,
        metavar="FILE",
        takes="mission",
    )
    at: Sequence[float | str] = setting(
        (),
        "Time since the mission began, as '10 min' (those of the mission's file).",
        "analyze mission report sweep",
        said="Times of the mission [s], or as '10 min'; those of its file without it.",
        panel=JUDGED,
        metavar="TIME",
        read=_time,
        several=True,
    )
    procedure: Procedure | File | None = setting(
        None,
        "Procedure file (the paper's).",
        "analyze mission report allocate station export sweep diff simulate "
        "characterise calibrate",
        at={
            "calibrate": {
                "needed": True,
                "help": "Procedure that was followed.",
                "said": "The one that was followed.",
            },
            "characterise": {
                "help": "Whose place is taken, with --attitude.",
                "said": "Whose place is taken, with an attitude.",
            },
            "simulate": {
                "help": "Test that is recorded; with --static whose place and rate are "
                "taken (the paper's).",
                "said": "The test, or whose place and rate are taken; the paper's "
                "without it.",
            },
        },
        said="The test; the paper's, if none is given, and of a mission alone the "
        "maker's calibration.",
        panel=USED,
        metavar="FILE",
        takes="procedure",
    )
    measured: Sequence[File] = setting(
        (),
        "Result of a recorded calibration (calibrate --json) of a unit of DEVICE, in "
        "the place of what is predicted of --procedure.",
        "analyze mission report compare export check",
        said="Results of recorded calibrations (calibrate --json) of units of the "
        "devices, in the place of what is predicted of the procedure.",
        at={
            "compare": {
                "help": "Result of a recorded calibration (calibrate --json) of a unit "
                "of a DEVICE, as one more candidate."
            }
        },
        panel=USED,
        metavar="FILE.json",
        takes="result",
        several=True,
    )
    procedures: Sequence[Procedure | File] = setting(
        (),
        "Procedure file (the paper's).",
        "compare decide check",
        at={
            "decide": {
                "help": "A calibration that is at hand, the one preferred first (the "
                "paper's)."
            }
        },
        only=CLI,
        panel=USED,
        option="--procedure",
        metavar="FILE",
        takes="procedure",
        several=True,
    )
    station: Station | File | None = setting(
        None,
        "Station file: what is not known of table, place and environment (an ideal "
        "one).",
        f"{_JUDGING} export sweep check diff simulate calibrate",
        said="Where a procedure is done that names no station itself.",
        panel=USED,
        metavar="FILE",
        takes="station",
    )
    catalogue: Sequence[Device] | None = setting(
        None,
        "Devices that are comparable; without it those that ship.",
        "analyze compare decide allocate export",
        only=LIBRARY,
    )

    @property
    def required(self) -> Any:  # noqa: ANN401 - as the job has it
        """The requirement, loaded; None where none is given."""
        from budget.inputs import load_requirement

        return None if self.requirement is None else load_requirement(self.requirement)

    @property
    def journey(self) -> Mission | None:
        """The mission, loaded; None where none is given."""
        from budget.inputs import load_mission

        return None if self.mission is None else load_mission(self.mission)

    def calibrated(
        self,
        *,
        mission: Mission | None = None,
        requirement: Requirement | None = None,
        by: Procedure | File | None = None,
    ) -> Procedure:
        """Load what calibrated the unit, for a mission and limits; `by` one of several.

        Raises as load_calibration.
        """
        from budget.inputs import load_calibration

        return load_calibration(
            self.calibration,
            self.procedure if by is None else by,
            station=self.station,
            age=self.age,
            environment=self.environment,
            mission=mission,
            requirement=requirement,
        )

    @property
    def files(self) -> list[Any]:
        """What it names, file by file."""
        given = [
            getattr(self, name)
            for name, row in every_row(Inputs).items()
            if row.takes in {*FILES, "result"}
        ]
        return [
            one
            for some in given
            for one in (some if isinstance(some, tuple) else (some,))
            if one is not None and one not in UNTESTED
        ]


@dataclass(frozen=True, kw_only=True)
class RecordingSettings:
    """How recordings are read, where they do not say it themselves."""

    rate: float | None = setting(
        None,
        "Sampling rate, where no column of stamps says it.",
        "characterise calibrate",
        said="Of sampling, in the place of stamps [Hz].",
        panel=JUDGED,
        metavar="HZ",
        read=read_rate,
    )
    columns: str | None = setting(
        None,
        "Heads in the place of those of the file, as 'time [s],gyro_x [deg/s],_': _ is "
        "not read, - before a head reverses it.",
        "characterise calibrate",
        said="Heads in the place of those of the files, with commas between them.",
        panel=JUDGED,
        metavar="HEADS",
    )
    recording: Recording | File | None = setting(
        None,
        "Recording file that says of all of them what columns, gains and rate are.",
        "characterise calibrate",
        panel=JUDGED,
        metavar="FILE.yaml",
        takes="recording",
    )

    @property
    def files(self) -> list[Any]:
        """What it names."""
        return [] if self.recording is None else [self.recording]

    def load(self, *given: Recording | File) -> list[Recording]:
        """Load recordings, each as it is to be read.

        Raises
        ------
        CallError
            One is a recording file itself, where another one is given.
        SpecError
            Everything that is wrong with a recording file.
        """
        from budget.inputs import load_recording
        from budget.inputs.recording import with_columns

        like = None if self.recording is None else load_recording(self.recording)
        return [
            with_columns(
                load_recording(one), rate=self.rate, columns=self.columns, like=like
            )
            for one in given
        ]


# In documents, as the first of them had it; later ones follow.
_FIRST = (
    *("method", "trials", "seed", "coverage", "interval", "reference", "formulas"),
    *("normals_per_trial", "only", "outputs", "digits", "samples", "sobol_scrambles"),
)


def _document() -> str:
    """Return the rows of documents."""
    found = {n: row for n, row in every_row(Settings).items() if row.document != ""}
    names = sorted(found, key=lambda name: (*_FIRST, name).index(name))
    return "\n".join(
        f"{found[name].document or name}: {_said(found[name])}" for name in names
    )


def _said(row: Row) -> str:
    """Say what it is within a sentence, with its choices."""
    text, _, _ = (row.text[0].lower() + row.text[1:]).rstrip(".").partition(";")
    return f"{text}: {_listed(row.choices)}" if row.choices else text


def _listed(choices: Sequence[str]) -> str:
    """List choices."""
    *others, last = map(repr, choices)
    return f"{', '.join(others)} or {last}"


written("settings", _document(), fills=fills)(Settings)


RECORDS = {one.__name__: one for one in (Asked, Engine, Inputs, RecordingSettings)}


def asking(job: str) -> Callable[[Callable[..., T]], Callable[..., T]]:
    """Spell out what may be asked of a function that takes it in records.

    The function has parameters of the types in RECORDS. Whoever calls it gives their
    fields by name; signature and docstring have them, what is given is checked, and
    the function is handed the records. They may be given whole, too.
    """

    def give(function: Callable[..., T]) -> Callable[..., T]:
        own = signature(function)
        spelled = {
            one.name: RECORDS[one.annotation]
            for one in own.parameters.values()
            if one.annotation in RECORDS
        }
        found = {name: rows(kind, job, LIBRARY) for name, kind in spelled.items()}
        every = {name: row for some in found.values() for name, row in some.items()}
        allowed = [*every, *(name for name in own.parameters if name not in spelled)]

        @wraps(function)
        def call(*arguments: Any, **given: Any) -> T:  # noqa: ANN401 - as it takes them
            for name in given.keys() - {*allowed, *spelled}:
                near = get_close_matches(name, allowed, 1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise TypeError(
                    f"{function.__name__}() got an unexpected keyword argument "
                    f"{name!r}{hint} Allowed: {', '.join(allowed)}"
                )
            for name in spelled.keys() - given.keys():
                for one, row in found[name].items():
                    if row.needed and given.get(one) is None:
                        kind = row.type.removesuffix(" | None")
                        raise CallError(
                            f"{function.__name__}() needs {one}={kind}; none was given"
                        )
                own = {one: given.pop(one) for one in [*given] if one in found[name]}
                given[name] = ask(spelled[name], job, own)
            check(job, *(given[name] for name in spelled))
            return function(*arguments, **given)

        shown: Any = call
        shown.__signature__ = own.replace(parameters=_parameters(own, found))
        shown.__doc__ = _with_parameters(function.__doc__ or "", every)
        return call

    return give


def _parameters(
    own: Signature, found: Mapping[str, Mapping[str, Row]]
) -> list[Parameter]:
    """Return parameters, each record as its fields."""
    return [
        each
        for one in own.parameters.values()
        for each in (
            [
                Parameter(
                    name,
                    Parameter.KEYWORD_ONLY,
                    default=Parameter.empty if row.needed else row.default,
                    annotation=row.type,
                )
                for name, row in found[one.name].items()
            ]
            if one.name in found
            else [one]
        )
    ]


def _with_parameters(text: str, found: Mapping[str, Row]) -> str:
    """Return a docstring with these at the end of its Parameters."""
    # Up to the next section, if there is one.
    head, *rest = re.split(r"(?=\n\n(?:Returns|Raises)\n)", cleandoc(text), maxsplit=1)
    lines = []
    for name, row in found.items():
        kind = _listed(row.choices) if row.choices else row.type.replace(" | ", " or ")
        kind = kind.replace(" or None", ", optional")
        lines += [f"{name} : {kind}", indent(fill(row.text, 84), "    ")]
    return "\n".join([head, *lines]) + "".join(rest)
