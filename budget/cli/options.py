"""Options that several commands share, each defined once."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from functools import partial, wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_type_hints

import typer

from budget.cli.space import SPACE_OF_PAGES, check_space
from budget.cli.streams import talk

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.inputs.records import Device, Requirement
    from budget.results import Assessment
    from budget.settings import Settings

BUILT_IN_DEVICE = "zhao-2019"
STDOUT = Path("-")
MEETS = "meets"  # the verdict whose exit code is always 0
EXIT_NOT_MET = 1
LONGEST_NUMBER = 20  # digits; longer ones cost time to read
LEAST_TRIALS, MOST_TRIALS = 2, 100_000_000  # also of stored references


class Kind(StrEnum):
    """What a device has, or is."""

    GYRO = "gyro"
    ACCELEROMETER = "accelerometer"
    IMU = "IMU"


class Grade(StrEnum):
    """What the list of devices has under grade."""

    NAVIGATION = "navigation"
    TACTICAL = "tactical"
    CONSUMER = "consumer"


def _coverage(text: str) -> float:
    """Read a probability, '0.95' or '95 %', to the nearest double."""
    from budget.distributions import COVERAGES, is_coverage

    number, percent, rest = text.partition("%")
    try:
        value = float(Decimal(number.strip()) / (100 if percent else 1))
    except ArithmeticError:  # no number, or one beyond what a Decimal can be
        value = float("nan")
    if rest.strip() or not is_coverage(value):
        raise typer.BadParameter(
            f"{text!r} is no probability of an interval; give one {COVERAGES}, "
            "as 0.95 or '95 %'"
        )
    return value


def _trials(text: str) -> int | None:
    """Read a number of trials; 'adaptive' is none."""
    if text == "adaptive":
        return None
    return _number_of_trials(text, or_else=", or 'adaptive'")


def _number_of_trials(text: str, *, or_else: str = "") -> int:
    """Read a whole number, '1000000' or '1e6'."""
    number = Decimal(0)
    if len(text) <= LONGEST_NUMBER and re.fullmatch(r"[0-9.]+(e\+?[0-9]+)?", text):
        with suppress(ArithmeticError):
            number = Decimal(text)
    if not (LEAST_TRIALS <= number <= MOST_TRIALS) or number % 1:
        raise typer.BadParameter(
            f"{text!r} is no number of trials; give a whole number, as 1000000 or 1e6, "
            f"{LEAST_TRIALS} or more and {MOST_TRIALS} at the most{or_else}"
        )
    return int(number)


def _time(text: str) -> float:
    """Read a time after the start of a mission, '10 min' [s]."""
    from budget.errors import UnitError
    from budget.units import parse_quantity

    try:
        time = parse_quantity(text, "s", bare="s").value
    except UnitError as error:
        raise typer.BadParameter(str(error)) from None
    if not time > 0.0:
        raise typer.BadParameter(f"{text!r} is not after the start; give one above 0 s")
    return time


def _processes(wanted: int) -> int:
    """Cut the number of processes to that of the processors, and say so.

    More would share the same processors, and each takes some 100 MB.
    """
    there = processors()
    if wanted <= there:
        return wanted
    some = "1 processor" if there == 1 else f"{there} processors"
    talk(f"--workers {wanted}: this run may use {some}, so that many are started")
    return there


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def completing(kind: str, *words: str) -> Callable[[str], list[str]]:
    """Return what completes the name of a shipped file of a kind, or one there.

    Of words that may stand in its place, too.
    """

    def complete(incomplete: str) -> list[str]:
        from budget.inputs.files import shipped_names

        folder, slash, start = incomplete.rpartition("/")
        names = (*words, *shipped_names(kind))
        found = [name for name in names if name.startswith(incomplete)]
        with suppress(OSError):  # no such folder: nothing to complete
            for path in Path(folder + slash).iterdir():
                if path.name.startswith(start):
                    named = f"{folder}{slash}{path.name}"
                    if path.is_dir():
                        found.append(f"{named}/")
                    elif path.suffix.lower() in {".yaml", ".yml"}:
                        found.append(named)
        return sorted(found)

    return complete


complete_device = completing("device")


def complete_line(incomplete: str) -> list[str]:
    """Complete the name of a specification to which a value is given."""
    from budget.inputs.changes import RANGE
    from budget.model.sources import SENSORS, lines_of
    from budget.names import Name

    names = (
        f"{Name(name, owner=owner)}="
        for owner in SENSORS
        for name in (*(one.name for one in lines_of(owner)), RANGE)
    )
    return [name for name in names if name.startswith(incomplete)]


def complete_source(incomplete: str) -> list[str]:
    """Complete the name of an error source, of sensors, station or environment."""
    from budget.model.sources import ENVIRONMENT, SENSORS, STATION, lines_of
    from budget.names import Name

    names = (
        str(Name(one.name, owner=owner))
        for owner in (*SENSORS, STATION, ENVIRONMENT)
        for one in lines_of(owner)
        if one.may_vary
    )
    return [name for name in names if name.startswith(incomplete)]


def complete_output(incomplete: str) -> list[str]:
    """Complete the last of some outputs: gyro, gyro.bias or gyro.bias.z."""
    from budget.model.sources import SENSORS
    from budget.names import Name, quantities_of

    before, comma, last = incomplete.rpartition(",")
    names: list[str] = []
    for owner in SENSORS:
        names.append(owner)
        for quantity, axes in quantities_of(owner).items():
            names += [Name(quantity, owner=owner, axis=one) for one in ("", *axes)]
    return [f"{before}{comma}{name}" for name in names if name.startswith(last)]


# Options by what they are of: `--help` shows them so.
judged = partial(typer.Option, rich_help_panel="What is judged")
calibrated = partial(typer.Option, rich_help_panel="Calibration and use")
computed = partial(typer.Option, rich_help_panel="How it is computed")
written = partial(typer.Option, rich_help_panel="Where it goes")

Devices = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[DEVICE]",
        autocompletion=complete_device,
        help="Device files, FILE or FILE#VARIANT, - for standard input; without one "
        "the built-in paper device.",
        show_default=False,
    ),
]
ProcedureFile = Annotated[
    Path | None,
    calibrated(
        "--procedure",
        autocompletion=completing("procedure"),
        metavar="FILE",
        help="Procedure file (the paper's).",
    ),
]
StationFile = Annotated[
    Path | None,
    calibrated(
        "--station",
        autocompletion=completing("station"),
        metavar="FILE",
        help="Station file: what is not known of table, place and environment (an "
        "ideal one).",
        show_default=False,
    ),
]
MISSION: Any = judged(
    "--mission",
    autocompletion=completing("mission"),
    metavar="FILE",
    help="Mission file, or the name of one that ships, as bench.",
    show_default=False,
)
AT: Any = judged(
    "--at",
    parser=_time,
    metavar="TIME",
    help="Time since the mission began, as '10 min'; may be given again (those of the "
    "mission's file).",
    show_default=False,
)
At = Annotated[list[float] | None, AT]
Calibration = Annotated[
    str | None,
    calibrated(
        autocompletion=completing("procedure", "none", "factory"),
        metavar="none|factory|PROCEDURE",
        help="What calibrated the unit: nothing, its maker, or a procedure (its maker "
        "for a mission; the paper's for limits on the calibration).",
        show_default=False,
    ),
]
Age = Annotated[
    str | None,
    calibrated(
        metavar="TIME",
        help="Time from the calibration to its use, as '1 year': what ages has gone "
        "that long (--reference next_turn_on).",
        show_default=False,
    ),
]
Environment = Annotated[
    str | None,
    calibrated(
        metavar="TEXT|none",
        help="That the unit is used in, as 'temperature 20 degC, vibration 1 g' "
        "(difference from the calibration, 1 sigma; rms), or none, as there "
        "(--reference next_turn_on).",
        show_default=False,
    ),
]
Accept = Annotated[
    Literal["meets", "meets_if"],
    judged(
        case_sensitive=False,
        help="The least verdict whose exit code is 0: meets_if accepts conditions that "
        "nobody has stated.",
    ),
]
ExitCode = Annotated[
    bool,
    judged(
        "--exit-code", help="Exit with 1 where the requirement is not met (0 always)."
    ),
]
FIRST_TRIALS: Any = computed(
    "--trials",
    parser=_number_of_trials,
    metavar="N",
    help="Monte Carlo trials of each device at first (100000).",
    show_default=False,
)
MOST_OF_A_DEVICE: Any = computed(
    "--max-trials",
    parser=_number_of_trials,
    metavar="N",
    help="The most of a device whose verdict or rank is open (1600000).",
    show_default=False,
)
REQUIREMENT: Any = judged(
    "--requirement",
    autocompletion=completing("requirement"),
    metavar="FILE",
    help="Requirement file; its coverage and error reference rule.",
)
RequirementFile = Annotated[Path | None, REQUIREMENT]


def _with_room(paths: list[Path] | None) -> list[Path] | None:
    """Refuse pages where no memory is left for what draws them."""
    if paths:
        check_space(SPACE_OF_PAGES)
    return paths


OUTPUT: Any = written(
    "-o",
    "--output",
    metavar="FILE",
    callback=_with_room,
    help="Report to write, .html or .pdf; may be given again.",
    show_default=False,
)


def _own_templates(context: typer.Context, folder: Path | None) -> Path | None:
    """Let the templates of a folder go before those that ship, for this call."""
    from budget.resources import templates_of

    context.with_resource(templates_of(folder))
    return folder


Templates = Annotated[
    Path | None,
    written(
        "--templates",
        metavar="DIR",
        is_eager=True,  # targets of an export may stand there
        callback=_own_templates,
        help="Folder with templates, style sheet and letterhead of your own.",
        show_default=False,
    ),
]
Paper = Annotated[
    Literal["a4", "letter"],
    written(case_sensitive=False, help="Sheets of a PDF: A4, or US Letter."),
]
Language = Annotated[
    Literal["en", "zh"],
    written(
        case_sensitive=False, help="Language of results and pages: English, or Chinese."
    ),
]
Method = Annotated[
    Literal["gum", "monte-carlo", "simulation"],
    computed(case_sensitive=False, help="How uncertainty is propagated."),
]
Trials = Annotated[
    int | None,
    computed(
        parser=_trials,
        metavar="N|adaptive",
        help="Monte Carlo trials (adaptive) or simulated runs (200).",
        show_default=False,
    ),
]
Digits = Annotated[
    int,
    computed(
        min=1,
        max=2,
        help="Digits of the uncertainty that adaptive trials and validation make sure.",
    ),
]
MaxTrials = Annotated[
    int | None,
    computed(
        parser=_number_of_trials,
        metavar="N",
        help="Where adaptive trials stop at the latest (2000000).",
        show_default=False,
    ),
]
Full = Annotated[
    bool,
    written("--full", help="Everything that is known, not only the answer."),
]
Sobol = Annotated[
    bool, computed("--sobol", help="Estimate Sobol' indices of the sources too.")
]
Samples = Annotated[
    int | None,
    computed(
        min=2,
        max=2**20,
        metavar="N",
        help="Sobol' points in each of 8 scrambles (2048).",
        show_default=False,
    ),
]
NoValidate = Annotated[
    bool,
    computed("--no-validate", help="Do not validate GUM propagation by Monte Carlo."),
]
Seed = Annotated[int, computed(min=0, metavar="S", help="Same seed, same numbers.")]
Workers = Annotated[
    int,
    computed(
        min=1,
        metavar="N",
        callback=_processes,
        help="Processes, as many as there are processors at the most; changes no "
        "number.",
    ),
]
Cluster = Annotated[
    str | None,
    computed(
        metavar="ADDRESS",
        help="Run on a Dask cluster, as tcp://host:port; changes no number.",
        show_default=False,
    ),
]
Coverage = Annotated[
    float | None,
    computed(
        parser=_coverage,
        metavar="P",
        help="Probability of the intervals, 0.95 or '95 %' (0.95).",
        show_default=False,
    ),
]
Interval = Annotated[
    Literal["symmetric", "shortest"],
    computed(case_sensitive=False, help="Coverage interval of Monte Carlo results."),
]
Reference = Annotated[
    Literal["nominal", "as_tested", "next_turn_on"] | None,
    computed(
        case_sensitive=False,
        help="Error reference: what errors are counted from (nominal).",
        show_default=False,
    ),
]
Only = Annotated[
    list[str] | None,
    computed(
        autocompletion=complete_source,
        metavar="SOURCE",
        help="Count only this source, as gyro.bias_stability or bias_stability; "
        "may be given again.",
        show_default=False,
    ),
]
Changes = Annotated[
    list[str] | None,
    judged(
        "--set",
        autocompletion=complete_line,
        metavar="SPEC=VALUE",
        help="Another value than the file's, as gyro.bias_stability='0.02 deg/h', of "
        "an axis gyro.bias_repeatability.x=..., of one device NAME:gyro...; may be "
        "given again.",
        show_default=False,
    ),
]
Outputs = Annotated[
    list[str] | None,
    written(
        autocompletion=complete_output,
        metavar="NAME,...",
        help="Show only these, as gyro, gyro.bias, gyro.bias.z or bias.z, or what is "
        "derived of the mounting angles: rotation, non_orthogonality, misalignment; "
        "may be given again.",
        show_default=False,
    ),
]
Matrices = Annotated[
    bool,
    written(
        "--matrices",
        help="Add the matrices that turn readings into inputs, with uncertainties.",
    ),
]
Kinds = Annotated[
    list[Kind] | None,
    judged(
        "--kind",
        case_sensitive=False,
        help="Of the catalogue what has this, by itself or in an IMU, or is an IMU; "
        "may be given again.",
        show_default=False,
    ),
]
Grades = Annotated[
    list[Grade] | None,
    judged(
        "--grade",
        case_sensitive=False,
        help="Of the catalogue what has this grade, of that kind; may be given again.",
        show_default=False,
    ),
]
Missing = Annotated[
    Literal["refuse", "worst", "typical", "predict"],
    judged(
        case_sensitive=False,
        help="What stands for expected specifications not given: nothing, the "
        "worst or the median of comparable devices, or a distribution predicted from "
        "them. Exit codes go by refuse.",
    ),
]
JsonFile = Annotated[
    Path | None,
    written("--json", metavar="FILE|-", help="Write the result as JSON."),
]
CsvFile = Annotated[
    Path | None,
    written("--csv", metavar="FILE|-", help="Write the result as CSV."),
]


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The options that say how a budget is computed, in the order of the help.

    A command that takes them whole has them spelled out by `spell_out`.
    """

    method: Method = "gum"
    trials: Trials = None
    digits: Digits = 1
    max_trials: MaxTrials = None
    seed: Seed = 0
    workers: Workers = 1
    cluster: Cluster = None
    coverage: Coverage = None
    interval: Interval = "symmetric"
    reference: Reference = None
    no_validate: NoValidate = False
    sobol: Sobol = False
    samples: Samples = None
    only: Only = None
    outputs: Outputs = None
    matrices: Matrices = False
    missing: Missing = "refuse"

    def settings(self, requirement: Requirement | None) -> Settings:
        """Return them with coverage and reference of the requirement, if there is one.

        Raises
        ------
        CallError
            An option asks for another one than the requirement does.
        """
        from budget import settings

        return settings.Asked(
            method=self.method,
            trials=self.trials,
            digits=self.digits,
            max_trials=self.max_trials,
            validate=not self.no_validate,
            seed=self.seed,
            coverage=self.coverage,
            interval=self.interval,
            reference=self.reference,
            sobol=self.sobol,
            samples=self.samples,
            only=self.only or (),
            matrices=self.matrices,
            missing=self.missing,
            outputs=self.outputs or (),
        ).settle(requirement)


def spell_out(command: Callable[..., None]) -> Callable[..., None]:
    """Spell the fields of Asked out where a command takes them as `asked`.

    typer reads the options of a command in its signature.
    """
    return spell_out_but()(command)


def spell_out_but(
    *without: str,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return the same for a command in which some of these options mean nothing."""
    return partial(_spelled_out, without=without)


def _spelled_out(
    command: Callable[..., None], *, without: tuple[str, ...]
) -> Callable[..., None]:
    """Return a command whose signature has the options of Asked."""
    hints = get_type_hints(Asked, include_extras=True)
    single = Parameter.KEYWORD_ONLY
    spelled = [
        Parameter(field.name, single, default=field.default, annotation=hints[name])
        for name, field in Asked.__dataclass_fields__.items()
        if name not in without
    ]
    own = signature(command, eval_str=True)
    parameters = [
        each
        for parameter in own.parameters.values()
        for each in (spelled if parameter.name == "asked" else [parameter])
    ]

    @wraps(command)
    def with_asked(*arguments: object, **values: Any) -> None:  # noqa: ANN401 - as typer read them
        asked = Asked(**{each.name: values.pop(each.name) for each in spelled})
        command(*arguments, asked=asked, **values)

    told: Any = with_asked
    told.__signature__ = own.replace(parameters=parameters)
    told.__annotations__ = {each.name: each.annotation for each in parameters}
    return with_asked


def select_catalogue(
    kinds: Sequence[str] | None, grades: Sequence[str] | None
) -> tuple[Device, ...]:
    """Load the devices that ship, of some kinds and grades or all.

    Raises
    ------
    CallError
        There is none.
    """
    from budget.errors import CallError
    from budget.inputs import load_catalogue
    from budget.missing.grades import is_one_of

    found = tuple(
        device for device in load_catalogue() if is_one_of(device, kinds, grades)
    )
    if not found:
        asked = " and ".join(
            f"{option} {' or '.join(words)}"
            for option, words in (("--kind", kinds), ("--grade", grades))
            if words
        )
        raise CallError(
            f"{asked}: expected a device of the catalogue that is so, found none; "
            "`budget devices` lists kind and grade of all"
        )
    return found


def calibration_files(
    calibration: str | None, *procedures: Path | None
) -> tuple[str | Path | None, ...]:
    """Return the files that a unit is calibrated by, where there are any."""
    from budget.inputs.records import UNCALIBRATED

    return (None if calibration in UNCALIBRATED else calibration, *procedures)


def accepted(accept: str) -> tuple[str, ...]:
    """Return the verdicts whose exit code is 0."""
    from budget.results import VERDICTS

    return VERDICTS[: VERDICTS.index(accept) + 1]


def check_exit_code(requirement: Path | None, *, exit_code: bool, accept: str) -> None:
    """Refuse options on the exit code where nothing sets it.

    Raises
    ------
    CallError
        There is no requirement, or the code is 0 whatever the verdict.
    """
    from budget.errors import CallError

    if exit_code and requirement is None:
        raise CallError(
            "--exit-code is by the verdict on a requirement: give one with "
            "--requirement, or leave it out"
        )
    if accept != MEETS and not exit_code:
        raise CallError(
            f"--accept {accept} changes nothing without --exit-code: the code is 0 "
            "whatever the verdict; add --exit-code, or leave it out"
        )


def exit_by(assessment: Assessment | None, *, exit_code: bool, accept: str) -> None:
    """End with 1 where a requirement is not met, if the code is to say so.

    One with limits that were not judged is not met: the headline names them.
    """
    is_met = assessment is None or (
        assessment.verdict in accepted(accept) and not assessment.not_there
    )
    if exit_code and not is_met:
        raise typer.Exit(EXIT_NOT_MET)


def load_devices(
    names: list[str] | None, changes: list[str] | None
) -> tuple[Device, ...]:
    """Load the devices named, or the built-in one, saying so; with the changes.

    Raises
    ------
    CallError
        A change is none, or reaches no device.
    SpecError
        With the issues of all files.
    """
    from budget.inputs.load import load_changed

    if not names:
        talk(f"No device given: using the built-in {BUILT_IN_DEVICE} (Zhao 2019).")
        names = [BUILT_IN_DEVICE]
    return load_changed(names, changes or (), variants=False)
