"""A budget against a requirement: who meets it, by what margin, and why not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.errors import CallError
from budget.results import (
    Assessment,
    CapAssessment,
    OutputAssessment,
    SensorAssessment,
    all_worst_of,
)
from budget.studies.comparison.figures_of_merit import over_cap, read_amount

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.results import Budget, OutputBudget
    from budget.spec.records import Device, Limit, Requirement, Sensor

NEAR = (0.95, 1.05)  # utilisations that one sure digit of u leaves open
NEAR_ADVICE = "near the limit: --method monte-carlo --digits 2 makes it sure"


def assess(
    budget: Budget, requirement: Requirement, devices: Sequence[Device]
) -> Assessment:
    """Hold a budget against the limits on its absolute errors.

    The utilisation of an output is the largest absolute end of its coverage interval
    over its limit; where the law failed its check by Monte Carlo, that interval is the
    Monte Carlo one. A sensor `meets` if none exceeds 1, `fails` if one does, and is
    `undecidable` if it would meet but lacks a line that has to be known.

    Parameters
    ----------
    budget : Budget
        Computed at the coverage and reference of the requirement.
    requirement : Requirement
        Limits; outputs without one are not required.
    devices : sequence of Device
        Those of the budget.

    Returns
    -------
    Assessment
        A sensor without limits has no verdict.

    Raises
    ------
    CallError
        The budget has another coverage or reference, or the requirement sets no limit
        for any sensor that is there.
    """
    settings = budget.settings
    if (settings.coverage, settings.reference) != (
        requirement.coverage,
        requirement.reference,
    ):
        raise CallError(
            f"the budget is for coverage {settings.coverage} and reference "
            f"{settings.reference}, {requirement.name} asks for {requirement.coverage} "
            f"and {requirement.reference}; compute it with those"
        )
    present = {row.output.name: row for row in budget.outputs}
    outputs = tuple(
        _hold(row, limit)
        for limit in requirement.limits
        if (row := present.get(limit.output)) is not None
    )
    if not outputs:
        raise CallError(
            f"{requirement.name} sets no limit for a sensor that is there "
            f"({', '.join(sorted({row.sensor for row in budget.outputs}))}); "
            "add limits for it, or leave the requirement out"
        )
    sensors = tuple(s for device in devices for s in device.sensors)
    verdicts = (_judge(sensor, outputs, budget) for sensor in sensors)
    return Assessment(
        requirement=requirement.name,
        outputs=outputs,
        sensors=tuple(verdict for verdict in verdicts if verdict is not None),
        not_there=limited_but_absent(requirement, sensors),
        caps=tuple(
            _cap(device, merit, cap)
            for merit, cap in requirement.caps
            for device in devices
        ),
    )


def limited_but_absent(
    requirement: Requirement, sensors: Sequence[Sensor]
) -> tuple[str, ...]:
    """Return the kinds of sensor that a requirement limits and no device has."""
    limited = dict.fromkeys(r.output.partition(".")[0] for r in requirement.limits)
    present = {sensor.kind for sensor in sensors}
    return tuple(kind for kind in limited if kind not in present)


def _cap(device: Device, merit: str, cap: str) -> CapAssessment:
    """Hold what a device costs, weighs or draws against a cap."""
    given = str(getattr(device, merit))
    have, most = read_amount(merit, given), read_amount(merit, cap)
    comparable = have is not None and most is not None and have.unit == most.unit
    return CapAssessment(
        device=device.name,
        merit=merit,
        cap=cap,
        given=given,
        is_within=not over_cap(merit, given, cap) if comparable else None,
    )


def _hold(row: OutputBudget, limit: Limit) -> OutputAssessment:
    """Hold one output against its limit, by an interval that passed its check."""
    refused = row.validation is not None and not row.validation.holds
    interval = row.interval
    if row.validation is not None and refused:
        interval = row.validation.interval
    largest = max(abs(interval[0]), abs(interval[1]))
    return OutputAssessment(
        output=row.output,
        limit=limit.limit,
        printed_limit=limit.printed,
        standard_uncertainty=row.standard_uncertainty,
        largest_error=largest,
        utilisation=largest / limit.limit,
        by_monte_carlo=refused,
        lower_bound=row.lower_bound,
        is_unknown=row.is_unknown,
    )


def _judge(
    sensor: Sensor, outputs: tuple[OutputAssessment, ...], budget: Budget
) -> SensorAssessment | None:
    """Return the verdict on one sensor, None where nothing is required of it."""
    own = [row for row in outputs if row.output.name.startswith(f"{sensor.kind}.")]
    if not own:
        return None
    all_worst = all_worst_of(own)
    worst = all_worst[0]
    # The law is checked, and trials are made, to one digit of u: that near to a limit
    # they cannot decide. Only trials made to two digits can.
    is_sure = budget.settings.method == "monte-carlo" and budget.settings.digits > 1
    near = not is_sure and NEAR[0] <= worst.utilisation <= NEAR[1]
    if not worst.is_within:
        verdict = "fails"
    elif sensor.expected_missing:
        verdict = "undecidable"
    else:
        verdict = "meets"
    return SensorAssessment(
        sensor=sensor.kind,
        verdict=verdict,
        utilisation=worst.utilisation,
        worst_output=worst.output.name,
        worst_outputs=tuple(row.output.name for row in all_worst),
        limiting_source=budget.output(worst.output.name).ranked[0].source,
        expected_missing=sensor.expected_missing,
        advice=NEAR_ADVICE if near else "",
        nothing_known=not sensor.lines,
    )
