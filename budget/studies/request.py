"""What is asked for: which sensors and sources, at which coverage and reference."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING

from budget.calibration.problem import REFERENCES
from budget.distributions import COVERAGES, is_coverage
from budget.errors import CallError
from budget.methods.intervals import KINDS as INTERVALS
from budget.model.sources import ENVIRONMENT, SENSORS, STATION, lines_of
from budget.names import Name, meant, parameters_of
from budget.spec.records import Device

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.spec.records import ErrorLine, Procedure, Requirement, Sensor

METHODS = ("gum", "monte-carlo", "simulation")
SHARED = (STATION, ENVIRONMENT)  # what all triads share
DEFAULT_COVERAGE = 0.95  # [1]
DEFAULT_REFERENCE = "nominal"


@dataclass(frozen=True, kw_only=True)
class Basis:
    """What a statement about errors rests on."""

    coverage: float
    reference: str


def choose_basis(
    requirement: Requirement | None, *, coverage: float | None, reference: str | None
) -> Basis:
    """Return coverage and reference: the requirement's, where there is one.

    Raises
    ------
    CallError
        An option asks for another one than the requirement does.
    """
    if requirement is None:
        return Basis(
            coverage=DEFAULT_COVERAGE if coverage is None else coverage,
            reference=DEFAULT_REFERENCE if reference is None else reference,
        )
    faults = [
        f"--{name} {asked} differs from the requirement's {name} {rules}"
        for name, asked, rules in (
            ("coverage", coverage, requirement.coverage),
            ("reference", reference, requirement.reference),
        )
        if asked is not None and asked != rules
    ]
    if faults:
        raise CallError(
            "; ".join(faults) + f"; leave the option out, or change it in "
            f"{requirement.origin.file}"
        )
    return Basis(coverage=requirement.coverage, reference=requirement.reference)


def sensors_of(devices: Sequence[Device]) -> tuple[Sensor, ...]:
    """Return the triads of all devices, gyro first.

    Raises
    ------
    CallError
        There is no sensor, or two of one kind.
    """
    strangers = [device for device in devices if not isinstance(device, Device)]
    if strangers:
        raise CallError(
            f"{strangers[0]!r} is no Device; load one with budget.load_device(FILE), "
            "and give a procedure as procedure=budget.load_procedure(FILE)"
        )
    found: list[Sensor] = []
    for kind in SENSORS:
        of_kind = [s for d in devices for s in d.sensors if s.kind == kind]
        if len(of_kind) > 1:
            names = " and ".join(f"{sensor.device!r}" for sensor in of_kind)
            raise CallError(
                f"{names} both have a {kind}, one budget takes at most one; "
                "give devices that complete each other, or `budget compare` them"
            )
        found.extend(of_kind)
    if not found:
        raise CallError("no device with a gyro or an accelerometer was given")
    return tuple(found)


def source_names(
    sensors: Sequence[Sensor], procedure: Procedure | None = None
) -> tuple[Name, ...]:
    """Return all sources that these sensors, and with a procedure the place, can have.

    Those of sensors first, then those that all triads share.
    """
    shared = () if procedure is None else SHARED
    owners = [*(sensor.kind for sensor in sensors), *shared]
    return tuple(
        Name(line.name, owner=owner)
        for owner in owners
        for line in lines_of(owner)
        if line.varies
    )


def given_lines(
    sensors: Sequence[Sensor], procedure: Procedure
) -> dict[Name, ErrorLine]:
    """Return every line that is given: those of the sensors, then the shared ones."""
    owned = [(sensor.kind, sensor.lines) for sensor in sensors]
    owned += [(STATION, procedure.station), (ENVIRONMENT, procedure.environment)]
    return {
        Name(line.name, owner=owner): line for owner, lines in owned for line in lines
    }


def find_sources(
    texts: Sequence[str], known: Sequence[Name], *, option: str
) -> tuple[Name, ...]:
    """Turn what a person wrote into names; a bare one means every owner that has it.

    Raises
    ------
    CallError
        A text names none of those that are known.
    """
    words = [*known, *(name.without_owner for name in known)]
    unknown = []
    for text in texts:
        if not meant(text, known):
            near = get_close_matches(text, words)
            hint = f"; did you mean {near[0]!r}?" if near else "."
            unknown.append(f"{text!r} is no source of these devices{hint}")
    if unknown:
        raise CallError(f"{option}: {' '.join(unknown)} Known: {', '.join(known)}")
    return tuple(dict.fromkeys(name for text in texts for name in meant(text, known)))


def read_name(text: str) -> Name:
    """Turn a text of a stored document into the source or output that it names.

    What the tool does not know, such as the name of a file, is a name of one part.
    """
    known = (
        name
        for owner in (*SENSORS, *SHARED)
        for name in (
            *(Name(line.name, owner=owner) for line in lines_of(owner)),
            *(parameters_of(owner) if owner in SENSORS else ()),
        )
    )
    return next((name for name in known if name == text), Name(text))


def choose_sources(
    sensors: Sequence[Sensor], procedure: Procedure, only: Sequence[str]
) -> tuple[frozenset[Name] | None, tuple[str, ...]]:
    """Resolve the names after `--only`.

    Returns
    -------
    frozenset of Name or None
        None where nothing was chosen, so that everything counts.
    tuple of str
        Warnings about lines that a device does not give.

    Raises
    ------
    CallError
        A name is no source of these sensors.
    """
    if not only:
        return None, ()
    if isinstance(only, str):  # one name, not a sequence of letters
        only = (only,)
    known = source_names(sensors, procedure)
    chosen = frozenset(find_sources(only, known, option="--only"))
    absent = sorted(chosen - given_lines(sensors, procedure).keys())
    return chosen, tuple(
        f"{name} was asked for alone, but the device does not give it: taken as 0"
        for name in absent
    )


def check_words(*, method: str, interval: str, reference: str) -> None:
    """Refuse words that name no choice, all at once."""
    faults = [
        f"{name} is {value!r}, allowed: {', '.join(allowed)}"
        for name, value, allowed in (
            ("method", method, METHODS),
            ("interval", interval, INTERVALS),
            ("reference", reference, REFERENCES),
        )
        if value not in allowed
    ]
    if faults:
        raise CallError("; ".join(faults))


def check_numbers(coverage: float, counts: dict[str, tuple[int | None, int]]) -> None:
    """Refuse numbers that mean nothing, all at once; counts are {name: (n, least)}."""
    faults = [
        f"{name} is {number}, allowed: {least} or more"
        for name, (number, least) in counts.items()
        if number is not None and number < least
    ]
    if not is_coverage(coverage):
        faults.append(f"coverage is {coverage!r}, allowed: {COVERAGES}")
    if faults:
        raise CallError("; ".join(faults))
