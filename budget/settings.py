"""What may be asked for: every setting and input once, with all that is known of it.

Options of commands, signatures and docstrings of functions, checks, documents, stored
references and tables of methods are read from the rows here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, is_dataclass, replace
from decimal import Decimal
from functools import partial
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TypeVar

from budget.documents import Documented, written
from budget.errors import CallError, UnitError
from budget.names import Name

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from budget.inputs.records import Requirement

T = TypeVar("T")
Progress = Callable[[str, int, int], None]  # what is done, steps done, steps in all
Stage = Callable[[int, int], None]
LONGEST_NUMBER = 20  # digits; longer ones cost time to read
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
    document: str | None = (
        None  # how its row begins; None: with its name, '': there is none
    )
    has_line: bool = False  # whether the table of methods has words of its own for it

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
    return {
        name: replace(row, **row.at.get(job, {}))
        for name, row in every_row(kind).items()
        if job in row.jobs and row.only in {"", where or row.only}
    }


def every_row(kind: type) -> dict[str, Row]:
    """Return all rows by the names of their fields, those of what it stands on too."""
    bases = [one for one in reversed(kind.__mro__) if is_dataclass(one)]
    return {
        one.name: one.metadata["row"]
        for base in bases
        for one in fields(base)
        if "row" in one.metadata
    }


def ask(kind: type[T], job: str, given: Mapping[str, Any]) -> T:
    """Return what is asked for: what is given, else what is usual in the job."""
    usual = {name: row.default for name, row in rows(kind, job).items()}
    return kind(**{**usual, **given})


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
        if value != row.default or isinstance(value, bool)
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
    is_good = is_whole and value >= row.least  # type: ignore[operator]
    return "" if is_good else f"whole numbers, {row.least} or more"


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
        "analyze mission report compare decide allocate sweep check",
        metavar="S",
        least=0,
        has_line=True,
    )
    coverage: float | None = setting(
        None,
        "Probability of the intervals, 0.95 or '95 %' (0.95).",
        "analyze mission report sweep check diff",
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
        "analyze mission report compare decide export check",
        said="What stands for expected lines that are not given: nothing, the worst or "
        "the median of comparable devices, or a distribution predicted from them.",
        panel=JUDGED,
        choices=("refuse", "worst", "typical", "predict"),
        document="missing if fills",
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
        "analyze mission report compare decide check",
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
        "analyze compare",
        only=LIBRARY,
    )
    progress: Progress | None = setting(
        None,
        "Called with what is being done, steps done and steps in all.",
        "analyze compare decide allocate",
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
        return stage(self.progress, what)


def stage(progress: Progress | None, what: str) -> Stage | None:
    """Return what a method calls with steps done and in all; it need not know more."""
    return None if progress is None else partial(progress, what)


def fills(asked: Asked) -> bool:
    """Whether anything stands for expected lines that are not given."""
    return asked.missing != "refuse"


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
