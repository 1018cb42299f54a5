"""Conformity of a budget with a requirement: verdicts, margins, what is missing."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.inputs import load_devices, load_requirement
from budget.inputs.records import JOINT
from budget.question import question_of, refuse_unjudged
from budget.results import Assessment, CapAssessment
from budget.studies.ceilings import ceilings_of
from budget.studies.figures_of_merit import is_within
from budget.studies.judgement import (
    MAX_TRIALS,
    TRIALS,
    judge,
    screen,
    together,
)
from budget.studies.margin import Margin
from budget.studies.readings import verdicts_by_reading
from budget.studies.verdicts import verdict_on

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import Device, Requirement
    from budget.names import Name
    from budget.question import Question
    from budget.results import Budget, Verdict
    from budget.studies.judgement import Judged

AS_PRINTED = 1.05  # times u that is the same to half a digit of the two printed [1]


def assess(
    budget: Budget,
    requirement: Requirement | File,
    devices: Sequence[Device | File] = (),
) -> Assessment:
    """Judge a budget against limits, as every command does (budget.studies.judgement).

    A sensor `meets` if the largest of its utilisations is below 1, `fails` if it is
    above, is `undecided` where its interval contains 1, and is `undecidable` if it
    would meet but lacks a line that has to be known.

    Parameters
    ----------
    budget : Budget
        Computed at the coverage and reference of the requirement. Where it was computed
        for it, that judgement is returned and the intervals are those of the budget.
    requirement : Requirement
        Limits, coverage and reference; outputs without a limit are not required.
    devices : sequence of Device
        Others than those of the budget, under the same procedure.

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
    question, wanted = question_of(budget), load_requirement(requirement)
    found, settings = budget.assessment, budget.settings
    if found is not None and found.requirement == wanted.name:
        return found
    if (settings.coverage, settings.reference) != (
        wanted.coverage,
        wanted.reference,
    ):
        raise CallError(
            f"the budget is for coverage {settings.coverage} and reference "
            f"{settings.reference}, {wanted.name} asks for {wanted.coverage} "
            f"and {wanted.reference}; compute it with those"
        )
    if devices:
        question = replace(question, devices=tuple(load_devices(devices)))
    return _assess(question, wanted, seed=settings.seed)


def _assess(question: Question, requirement: Requirement, *, seed: int) -> Assessment:
    """Judge every triad that has limits, each as if the other were not there.

    What belongs to both is judged with both.
    """
    found: list[Judged] = []
    verdicts: list[Verdict] = []
    kinds = [sensor.kind for sensor in question.sensors]
    if question.requirement is not requirement:
        question = replace(question, requirement=requirement)
    for owner in question.limited:
        own = question.alone(owner)
        if (held := own.held) is None:
            continue
        judged = judge(
            held,
            seed=seed,
            # What missing lines leave open, no trial decides.
            max_trials=TRIALS if own.filled.prediction else MAX_TRIALS,
        )
        if own.has_lines:
            found.append(judged)
        verdicts.append(
            verdict_on(
                own,
                judged,
                seed=seed,
                readings=verdicts_by_reading(own, seed=seed, taken=judged),
            )
        )
    if not verdicts:
        refuse_unjudged(requirement, question.mission, question.procedure)
        raise CallError(
            f"{requirement.name} sets no limit for what is estimated of a sensor that "
            f"is there ({', '.join(sorted(kinds))}); add limits for it, or leave the "
            "requirement out"
        )
    judged_kinds = {one.sensor for one in verdicts}
    order = {limit.output: place for place, limit in enumerate(requirement.limits)}
    return Assessment(
        requirement=requirement.name,
        outputs=tuple(
            sorted(
                (row for one in verdicts for row in one.outputs),
                key=lambda row: order[row.output.name],
            )
        ),
        sensors=tuple(verdicts),
        conformance=together(found)
        if found
        and question.filled.prediction is None
        and not any(one.saturates for one in verdicts)
        else None,
        not_there=tuple(kind for kind in requirement.kinds if kind not in judged_kinds),
        together=requirement.coverage if requirement.decision == JOINT else None,
        caps=tuple(
            _cap(device, merit, cap)
            for merit, cap in requirement.caps
            for device in question.devices
        ),
    )


def margins(question: Question) -> Iterator[tuple[Question, Margin]]:
    """Yield by owner what its verdict has room for, by the law alone."""
    for owner in question.limited:
        own = question.alone(owner)
        if own.held is None or not own.has_lines:
            continue
        yield own, Margin.of(own, screen(own.held, seed=0), seed=0)


def open_to(
    question: Question, assessment: Assessment
) -> Mapping[Name, tuple[Name, ...]]:
    """Return by output the lines that are not given and that its number is open to.

    Not those that are negligible to the limits of its owner, where u with all of these
    at their ceilings is the same to the digits that are printed.
    """
    spared = {one.sensor: one.negligible for one in assessment.sensors}
    names = tuple(dict.fromkeys(name for own in spared.values() for name in own))
    tops = {name: one.line for name, one in ceilings_of(question, names).items()}
    if not tops:
        return question.lacks
    whole = replace(question.with_lines(tops), designed=None)
    least = np.array([output.resolution for output in question.problem.outputs]) ** 2
    variance = np.diag(question.law.covariance)
    same = np.diag(whole.law.covariance) <= np.maximum(AS_PRINTED**2 * variance, least)
    is_same = {
        output.name: bool(one)
        for output, one in zip(question.problem.outputs, same, strict=True)
    }
    return {
        output: tuple(
            name
            for name in lacks
            if not (
                is_same.get(output)
                and name in tops
                and name in spared.get(output.owner, ())
            )
        )
        for output, lacks in question.lacks.items()
    }


def _cap(device: Device, merit: str, cap: str) -> CapAssessment:
    """Hold what a device costs, weighs or draws against a cap."""
    given = str(getattr(device, merit))
    return CapAssessment(
        device=device.name,
        merit=merit,
        cap=cap,
        given=given,
        is_within=is_within(merit, given, cap),
    )
