"""A comparison as a flat list of numbers and words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.calibration.problem import calibration_problem
from budget.studies.judgement import NORMAL_TRIALS
from budget.studies.reference.numbers import PART
from budget.studies.reference.records import Number, Snapshot, Word
from budget.studies.reference.sampling import standard_errors

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.spec.records import Device, Procedure, Requirement
    from budget.studies.comparison.records import Comparison, DeviceVerdict, Entrant
    from budget.studies.reference.sampling import StandardErrors


@dataclass(frozen=True, kw_only=True)
class Compared:
    """What was compared."""

    devices: Sequence[Device]
    names: Sequence[str]  # of the devices, each once
    requirement: Requirement
    procedures: Sequence[Procedure]


def comparison_numbers(comparison: Comparison, compared: Compared) -> Snapshot:
    """Return what a comparison says of every sensor of every device.

    Ranks, worst outputs and factors are left out: where two are alike, which of them
    comes first is chance, and what they rest on is here. So is what missing lines
    could do, which depends on the whole catalogue.
    """
    numbers: list[Number] = []
    words: list[Word] = []
    for row in comparison.devices:
        errors = _errors(row, compared)
        subject = f"{_name(row, compared)} {row.sensor}"
        numbers.extend(_device_numbers(row, subject, errors))
        sampled = "" if errors is None else "utilisation"
        words.extend(
            Word(
                subject=subject,
                quantity=quantity,
                text=text,
                rests_on=rests_on,
            )
            for quantity, text, rests_on in (
                ("verdict", row.verdict, sampled),
                # Axes are alike: which of them is the worst may hang on rounding.
                ("limiting_source", row.remedy.source, "utilisation"),
                ("not_given", ", ".join(row.not_given), ""),
            )
        )
    for unknown in comparison.nothing_known:
        subject = f"{_name(unknown, compared)} {unknown.sensor}"
        words += [
            Word(subject=subject, quantity="verdict", text="undecidable"),
            Word(
                subject=subject,
                quantity="not_given",
                text=", ".join(unknown.not_given),
            ),
        ]
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def _name(row: Entrant, compared: Compared) -> str:
    """Return the name of a device, with its procedure where there are several."""
    name = compared.names[row.place]
    return f"{name} @ {row.procedure}" if len(compared.procedures) > 1 else name


@dataclass(frozen=True, kw_only=True, eq=False)
class _Errors:
    """Standard errors of a device's required outputs, and where they stand."""

    of: StandardErrors
    places: dict[str, int]


def _errors(row: DeviceVerdict, compared: Compared) -> _Errors | None:
    """Return the standard errors of the trials of one device; None by the law."""
    if row.trials is None:
        return None
    device = compared.devices[row.place]
    sensor = next(one for one in device.sensors if one.kind == row.sensor)
    procedure = next(p for p in compared.procedures if p.name == row.procedure)
    problem = calibration_problem(
        (sensor,), procedure, reference=compared.requirement.reference
    )
    return _Errors(
        of=standard_errors(
            problem, trials=row.trials, coverage=compared.requirement.coverage
        ),
        places={output.name: k for k, output in enumerate(problem.outputs)},
    )


def _device_numbers(
    row: DeviceVerdict, subject: str, errors: _Errors | None
) -> Iterator[Number]:
    """Yield the numbers of one sensor of one device."""
    freedom = None if errors is None else errors.of.end_degrees_of_freedom
    device = subject.removesuffix(row.sensor)
    ends: list[float] = []
    for one in row.outputs:
        name, scale = f"{device}{one.output.name}", one.output.si_per_unit
        place = None if errors is None else errors.places[one.output.name]
        spread = end = degrees = None
        if errors is not None and place is not None:
            spread = float(errors.of.u[place]) / scale
            degrees = float(errors.of.u_degrees_of_freedom[place])
            end = float(errors.of.end[place]) / scale
            ends.append(end * scale / one.limit)
        yield Number(
            subject=name,
            quantity="standard_uncertainty",
            unit=one.output.unit,
            value=one.standard_uncertainty / scale,
            floor=one.output.resolution / scale,
            standard_error=spread,
            degrees_of_freedom=degrees,
        )
        yield Number(
            subject=name,
            quantity="largest_error",
            unit=one.output.unit,
            value=one.largest_error / scale,
            floor=one.output.resolution / scale,
            standard_error=end,
            degrees_of_freedom=freedom,
        )
        yield Number(
            subject=name,
            quantity="conformance",
            unit="1",
            value=one.conformance,
            floor=PART,
            trials=row.trials,
        )
    yield Number(
        subject=subject,
        quantity="utilisation",
        unit="1",
        value=row.utilisation,
        floor=max(one.output.resolution / one.limit for one in row.outputs),
        # The largest of several strays no further than that which strays furthest.
        standard_error=max(ends) if ends else None,
        degrees_of_freedom=freedom,
    )
    yield Number(
        subject=subject,
        quantity="conformance",
        unit="1",
        value=row.conformance.value,
        floor=PART,
        trials=row.trials or NORMAL_TRIALS,  # by the law counted in draws of it
    )
