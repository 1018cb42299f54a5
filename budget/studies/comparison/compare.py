"""Devices against a requirement: judged, ranked with confidence, paired."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from budget.calibration.schemes import calibrates, refusals
from budget.errors import CallError
from budget.inputs import load_devices, load_requirement
from budget.inputs.load import several
from budget.inputs.use import in_use
from budget.methods.execution import local_executor
from budget.model.sources import ENVIRONMENT, SENSORS
from budget.model.sources.later import AGE
from budget.names import IMU, MISSION, Name, by_group
from budget.question import Question, refuse_unjudged
from budget.results import input_file, named_files
from budget.sentences import sentence
from budget.settings import Asked, Engine, Inputs, asking
from budget.studies.blunders import against_limits
from budget.studies.cautions import (
    age_that_counts_not,
    not_calibrated,
    not_estimated,
    not_weighted,
    of_no_vehicle,
)
from budget.studies.comparison.judging import Judging, entrant_of, judge_all
from budget.studies.comparison.ranking import pair_up, rank, rank_imus
from budget.studies.comparison.records import (
    Comparison,
    Entrant,
)
from budget.studies.judgement import MAX_TRIALS, TRIALS
from budget.studies.verdicts import unjudged

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import (
        Device,
        Mission,
        Procedure,
        Requirement,
    )

LEAST_TRIALS = 2


@asking("compare")
def compare(
    devices: Device | File | Sequence[Device | File],
    requirement: Requirement | File,
    procedures: Procedure | File | Sequence[Procedure | File] = (),
    *,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    pairs: bool = False,
    strict: bool = False,
) -> Comparison:
    """Judge every sensor of every device under every procedure, and rank them.

    What belongs to both triads of a device is judged with both.

    Parameters
    ----------
    devices : sequence of Device
        Candidates; variants are devices of their own, and the name of a file stands
        for its base and every variant.
    requirement : Requirement
        Limits, coverage and reference.
    procedures : sequence of Procedure
        The paper's, if none is given; where all limits are on a mission, the maker's.
    pairs : bool
        Whether every gyro is paired with every accelerometer too; the two of one
        device are ranked as an IMU in any case.
    strict : bool
        Refuse devices that a procedure takes beyond their range, which else are named
        and left out.

    Returns
    -------
    Comparison

    Raises
    ------
    CallError
        Options that do not fit together, limits on a mission without one, or no
        device has a sensor that the requirement limits.
    """
    imus = load_devices(devices, variants=True)
    wanted = load_requirement(requirement)
    journey = inputs.journey
    of_both = tuple(one for one in wanted.limits if one.output.owner == IMU)
    shared = replace(wanted, limits=of_both)
    tests = tuple(
        inputs.calibrated(mission=journey, requirement=wanted, by=one)
        for one in several(procedures) or (None,)
    )
    for test in tests:
        refuse_unjudged(wanted, journey, test)
    trials = TRIALS if asked.trials is None else asked.trials
    most = asked.max_trials or max(trials, MAX_TRIALS)
    _check(asked, trials=trials, max_trials=most)
    check_names(tests)
    candidates, places = [], []
    for test in tests:
        how = in_use(test, wanted, journey)
        for place, device in enumerate(imus):
            for on in (None, journey)[: 1 if journey is None else 2]:
                if not _can_be_asked(device, how, on):
                    continue
                one = Question.of(
                    device,
                    procedure=how,
                    requirement=wanted,
                    mission=on,
                    carried_to=None if on is None else (),
                    missing=asked.missing,
                    catalogue=inputs.catalogue,
                )
                candidates += [one.alone(owner) for owner in one.limited]
                places += [place] * len(one.limited)
    beyond = [refusals(one.there, one.procedure) for one in candidates]
    reasons = tuple(dict.fromkeys(text for some in beyond for text in some))
    not_compared = _not_compared(imus, wanted, [one.owner for one in candidates])
    tested = [k for k, texts in enumerate(beyond) if not texts]
    if reasons and (strict or not tested):
        raise CallError("\n".join(reasons))
    every = dict.fromkeys(one.owner for one in candidates)
    places, candidates = (
        [places[k] for k in tested],
        [candidates[k] for k in tested],
    )
    untested = [one for one in every if one not in {x.owner for x in candidates}]
    judged = [one for one in candidates if one.has_lines]
    if not candidates:
        raise CallError(
            f"{wanted.name} limits no sensor that these devices have, or nothing "
            f"that {' and '.join(one.name for one in tests)} estimates of it; add "
            "limits for what is estimated, or give other devices or procedures"
        )
    judging = Judging(
        method=asked.method,
        coverage=wanted.coverage,
        seed=asked.seed,
        trials=trials,
        max_trials=most,
        validate=asked.validate,
    )
    with local_executor(1 if engine.executor else engine.workers) as pool:
        findings = judge_all(
            judged,
            judging,
            executor=engine.executor or pool,
            ahead=2 * engine.workers,
            progress=engine.stage("comparison of devices"),
        )
    where = {id(one): place for one, place in zip(candidates, places, strict=True)}
    ranked = rank(
        [
            replace(finding, place=where[id(one)])
            for one, finding in zip(judged, findings, strict=True)
        ]
    )
    return Comparison(
        requirement=wanted.name,
        mission="" if journey is None else journey.name,
        procedures=tuple(procedure.name for procedure in tests),
        inputs=(
            *(input_file("device", device) for device in imus),
            *(input_file("procedure", procedure) for procedure in tests),
            *(() if journey is None else (input_file("mission", journey),)),
            input_file("requirement", wanted),
            *named_files(tests),
        ),
        settings=replace(
            asked.settle(wanted),
            trials=trials if asked.method == "monte-carlo" or asked.validate else None,
            formulas=", ".join(dict.fromkeys(p.formulas for p in tests)),
            normals_per_trial=max((finding.normals for finding in findings), default=0),
        ),
        caps=wanted.caps,
        not_compared=not_compared,
        devices=ranked,
        nothing_known=tuple(
            replace(entrant_of(one, unjudged(one)), place=place)
            for one, place in zip(candidates, places, strict=True)
            if not one.has_lines
        ),
        untested=tuple(untested),
        imus=rank_imus(ranked, is_shared=bool(of_both)),
        pairs=pair_up(ranked, is_shared=bool(of_both)) if pairs else (),
        assumptions=(() if journey is None else journey.assumptions)
        + tuple(
            sentence(
                "comparisons.age",
                procedure=procedure.name,
                source=Name(AGE, owner=ENVIRONMENT),
                age=line.printed,
            )
            for procedure in tests
            for line in procedure.environment
            if line.name == AGE
        )
        + tuple(
            dict.fromkeys(
                sentence("assumed.of", key=device.name, text=text)
                for device in (
                    *imus,
                    *(one.devices[0] for one in candidates if one.filled.lines),
                )
                for text in (
                    *device.assumptions,
                    *(
                        text
                        for procedure in tests
                        for text in not_weighted(device.sensors, procedure)
                    ),
                )
            )
        ),
        warnings=(
            *dict.fromkeys(
                text
                for procedure in tests
                for text in (
                    *age_that_counts_not(procedure, wanted.reference),
                    *against_limits(procedure, wanted),
                    *not_calibrated(imus, procedure),
                    *not_estimated(imus, procedure, wanted),
                )
            ),
            *of_no_vehicle(journey),
            *_not_of_both(imus, shared, pairs=pairs),
            *reasons,
            *_warnings(imus, wanted, judged, findings, not_compared),
        ),
    )


def _can_be_asked(
    device: Device, procedure: Procedure, mission: Mission | None
) -> bool:
    """Whether anything of a device is calibrated, or both triads are on the mission."""
    if mission is not None:
        return len(device.sensors) == len(SENSORS)
    return any(calibrates(sensor.kind, procedure) for sensor in device.sensors)


def _check(asked: Asked, *, trials: int, max_trials: int) -> None:
    """Refuse options that mean nothing together."""
    if asked.validate and asked.method != "gum":
        raise CallError(
            "--validate checks the law of propagation, which --method monte-carlo "
            "does not use; leave it out, or take --method gum"
        )
    if not LEAST_TRIALS <= trials <= max_trials:
        raise CallError(
            f"{trials} trials at first and {max_trials} at most, expected "
            f"{LEAST_TRIALS} or more, and no more than --max-trials"
        )


def check_names(procedures: Sequence[Procedure]) -> None:
    """Refuse two procedures that could not be told apart in the result."""
    names = [procedure.name for procedure in procedures]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise CallError(
            f"procedures of the same name: {', '.join(twice)}; expected a name of its "
            "own for each, change `name` in their files"
        )


def _warnings(
    devices: Sequence[Device],
    requirement: Requirement,
    candidates: Sequence[Question],
    findings: Sequence[Entrant],
    not_compared: Sequence[str],
) -> tuple[str, ...]:
    """Name what a reader could misread."""
    twice = [name for name, n in Counter(d.name for d in devices).items() if n > 1]
    present = _present(devices) - {MISSION}
    by_mission = MISSION in requirement.kinds  # by which both sensors are compared
    lacking = {
        kind: [
            device.name
            for device in devices
            if [one.kind for one in device.sensors] not in ([kind], [*SENSORS])
        ]
        for kind in SENSORS
    }
    impossible = {name for finding in findings for name in finding.impossible}
    doubts: dict[str, dict[str, None]] = {}
    for one, finding in zip(candidates, findings, strict=True):
        if finding.doubtful:
            own = doubts.setdefault(one.devices[0].name, {})
            own |= dict.fromkeys(finding.doubtful)
    return (
        *([sentence("comparisons.same_name", names=sorted(twice))] if twice else []),
        *(
            sentence("comparisons.not_compared", sensor=kind)
            for kind in sorted(present - set(requirement.kinds))
            if not by_mission
        ),
        *(
            sentence("comparisons.not_there", sensor=kind)
            for kind in not_compared
            if kind not in {IMU, MISSION}
        ),
        *(
            sentence("comparisons.no_mission", sensor=kind, devices=names)
            for kind, names in lacking.items()
            if by_mission and names
        ),
        *(
            sentence("comparisons.impossible", output=name)
            for name in sorted(impossible)
        ),
        *(
            sentence("comparisons.not_confirmed", device=device, outputs=tuple(names))
            for device, names in doubts.items()
        ),
    )


def _not_of_both(
    devices: Sequence[Device], shared: Requirement, *, pairs: bool
) -> Iterator[str]:
    """Say once of what limits on both triads together are not judged."""
    if pairs or any(len(device.sensors) < len(SENSORS) for device in devices):
        for parameters in by_group(shared.outputs):
            yield sentence("comparisons.of_both", parameters=parameters)


def _not_compared(
    devices: Sequence[Device], requirement: Requirement, owners: Sequence[str]
) -> tuple[str, ...]:
    """Return the sensors that have limits, and that no device has.

    So of what belongs to both, where none of the `owners` of what is judged is that.
    """
    there = _present(devices) | ({IMU} & {*owners})
    return tuple(kind for kind in requirement.kinds if kind not in there)


def _present(devices: Sequence[Device]) -> set[str]:
    """Return the sensors that some device has; and the mission, where one has both."""
    found = {sensor.kind for device in devices for sensor in device.sensors}
    both = any(len(device.sensors) == len(SENSORS) for device in devices)
    return found | ({MISSION} if both else set())
