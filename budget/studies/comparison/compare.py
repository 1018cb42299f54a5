"""Devices against a requirement: judged, ranked with confidence, paired."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

from budget.calibration.schemes import refusals
from budget.errors import CallError
from budget.inputs import load_devices, load_requirement
from budget.inputs.load import several
from budget.methods.execution import local_executor
from budget.model.sources import ENVIRONMENT, SENSORS
from budget.model.sources.later import AGE
from budget.names import IMU, MISSION, Name, by_group
from budget.question import Question
from budget.recordings.measured_unit import measured_units
from budget.results import input_file, named_files, results_of
from budget.sentences import sentence
from budget.settings import Asked, Engine, Inputs, asking
from budget.spooled import Made, SpooledList, chained
from budget.studies.blunders import against_limits
from budget.studies.cautions import (
    about_results,
    age_that_counts_not,
    better_than_units,
    not_calibrated,
    not_estimated,
    not_weighted,
    of_no_vehicle,
)
from budget.studies.comparison.judging import judge_all
from budget.studies.comparison.ranking import (
    pair_up,
    rank_devices,
    rank_imus,
    shared_by_both,
)
from budget.studies.comparison.records import Comparison
from budget.studies.judgement import MAX_TRIALS, TRIALS

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import (
        Device,
        Procedure,
        Requirement,
    )
    from budget.results import InputFile
    from budget.studies.comparison.records import Entrant

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
    sheets = load_devices(devices, variants=True)
    wanted, journey = load_requirement(requirement), inputs.journey
    tests = tuple(
        inputs.calibrated(mission=journey, requirement=wanted, by=one)
        for one in several(procedures) or (None,)
    )
    units = measured_units(sheets, inputs.measured, tests)
    imus = chained([sheets, [unit for _, unit in units]]) if units else sheets
    trials = TRIALS if asked.trials is None else asked.trials
    most = asked.max_trials or max(trials, MAX_TRIALS)
    _check(asked, trials=trials, max_trials=most)
    check_names(tests)
    owners: dict[str, bool] = {}  # of what has limits, and whether any can be tested
    reasons: dict[str, None] = {}  # why devices cannot
    filled: dict[str, None] = {}  # what is assumed of those that something stands in

    def candidates() -> Iterator[tuple[int, Question]]:
        """Yield what can be tested; note what cannot, and what is assumed."""
        every = Question.each(
            imus,
            tests,
            requirement=wanted,
            mission=journey,
            missing=asked.missing,
            catalogue=inputs.catalogue,
        )
        for place, one in every:
            refused = refusals(one.there, one.procedure)
            reasons.update(dict.fromkeys(refused))
            owners[one.owner] = owners.get(one.owner, False) or not refused
            if not refused:
                if one.filled.lines:
                    filled.update(dict.fromkeys(_assumed(one.devices[0], tests)))
                yield place, one

    if strict:
        deque(candidates(), maxlen=0)
        if reasons:
            raise CallError("\n".join(reasons))
    step = engine.stage("comparison of devices")
    total = len(imus) * len(tests) * len(wanted.kinds)
    with local_executor(1 if engine.executor else engine.workers) as pool:
        findings = judge_all(
            candidates(),
            replace(asked, trials=trials, max_trials=most),
            executor=engine.executor or pool,
            ahead=2 * engine.workers,
            progress=lambda done: step and step(done, max(done, total)),
        )
    if not any(owners.values()):
        raise CallError(
            "\n".join(reasons)
            or f"{wanted.name} limits no sensor that these devices have, or nothing "
            f"that {' and '.join(one.name for one in tests)} estimates of it; add "
            "limits for what is estimated, or give other devices or procedures"
        )
    named: list[tuple[str, list[str]]] = []  # with the sensors of each
    files: list[InputFile] = []
    assumed: SpooledList[str] = SpooledList()
    said: set[str] = set()
    alike: dict[object, Device] = {}  # one for all of which cautions say the same
    for place, one in enumerate(imus):
        kinds = [sensor.kind for sensor in one.sensors]
        named.append((one.name, kinds))
        files += [input_file("device", one)] * (place < len(sheets))
        assumed.extend(_anew(_assumed(one, tests), said))
        alike.setdefault((one.measured, *kinds), one)
    some = [*alike.values()]
    of_both = [name for name in wanted.outputs if name.owner == IMU]
    ranked = rank_devices(findings)
    normals, unknown, doubts = _looked_through(findings)
    not_compared = _not_compared(some, wanted, owners)
    is_counted = asked.method == "monte-carlo" or asked.validate
    return Comparison(
        requirement=wanted.name,
        mission="" if journey is None else journey.name,
        procedures=tuple(procedure.name for procedure in tests),
        inputs=(
            *files,
            *results_of(some),
            *(input_file("procedure", procedure) for procedure in tests),
            *(() if journey is None else (input_file("mission", journey),)),
            input_file("requirement", wanted),
            *named_files(tests),
        ),
        settings=replace(
            asked.settle(wanted),
            trials=trials if is_counted else None,
            formulas=", ".join(dict.fromkeys(p.formulas for p in tests)),
            normals_per_trial=normals,
        ),
        caps=wanted.caps,
        not_compared=not_compared,
        devices=ranked,
        nothing_known=Made(findings.__getitem__, unknown).held(),
        untested=tuple(owner for owner, is_tested in owners.items() if not is_tested),
        imus=rank_imus(ranked, shared=shared_by_both(wanted.outputs)),
        pairs=pair_up(ranked, shared=shared_by_both(wanted.outputs)) if pairs else (),
        assumptions=chained(
            [
                () if journey is None else journey.assumptions,
                [*_aged(tests)],
                assumed,
                [*_anew(filled, said)],
            ]
        ),
        warnings=(
            *dict.fromkeys(chain(*(better_than_units(some, one) for one in tests))),
            *dict.fromkeys(chain(*(_of_test(one, some, wanted) for one in tests))),
            *dict.fromkeys(chain(*(about_results(some, one) for one in tests))),
            *of_no_vehicle(journey),
            *_not_of_both(some, of_both, pairs=pairs),
            *reasons,
            *_warnings(named, some, wanted, not_compared),
            *doubts,
        ),
    )


def _aged(procedures: Sequence[Procedure]) -> Iterator[str]:
    """Say how old each calibration is."""
    for procedure in procedures:
        for line in procedure.environment:
            if line.name == AGE:
                yield sentence(
                    "comparisons.age",
                    procedure=procedure.name,
                    source=Name(AGE, owner=ENVIRONMENT),
                    age=line.printed,
                )


def _assumed(device: Device, procedures: Sequence[Procedure]) -> Iterator[str]:
    """Say what is assumed of a device."""
    texts = (not_weighted(device.sensors, procedure) for procedure in procedures)
    for text in (*device.assumptions, *chain.from_iterable(texts)):
        yield sentence("assumed.of", key=device.name, text=text)


def _anew(texts: Iterable[str], said: set[str]) -> Iterator[str]:
    """Yield the texts that are not said yet, and note them."""
    for text in texts:
        if (plain := str(text)) not in said:
            said.add(plain)
            yield text


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


def _of_test(
    procedure: Procedure, devices: Sequence[Device], requirement: Requirement
) -> Iterator[str]:
    """Name what a procedure leaves open."""
    yield from age_that_counts_not(procedure, requirement.reference)
    yield from against_limits(procedure, requirement)
    yield from not_calibrated(devices, procedure)
    yield from not_estimated(devices, procedure, requirement)


def _warnings(
    named: Sequence[tuple[str, list[str]]],
    devices: Sequence[Device],
    requirement: Requirement,
    not_compared: Sequence[str],
) -> Iterator[str]:
    """Name what a reader could misread."""
    times = Counter(name for name, _ in named)
    if twice := sorted(name for name, number in times.items() if number > 1):
        yield sentence("comparisons.same_name", names=twice)
    by_mission = MISSION in requirement.kinds  # by which both sensors are compared
    for kind in sorted(_present(devices) - {MISSION, *requirement.kinds}):
        if not by_mission:
            yield sentence("comparisons.not_compared", sensor=kind)
    for kind in not_compared:
        if kind not in {IMU, MISSION}:
            yield sentence("comparisons.not_there", sensor=kind)
    for kind in SENSORS if by_mission else ():
        names = [name for name, kinds in named if kinds not in ([kind], [*SENSORS])]
        if names:
            yield sentence("comparisons.no_mission", sensor=kind, devices=names)


def _looked_through(findings: Sequence[Entrant]) -> tuple[int, list[int], list[str]]:
    """Return the most normals of a trial, who is not judged, and what is doubtful.

    That are limits that nothing can keep, and outputs that trials do not confirm.
    """
    normals, unknown = 0, []
    impossible: set[str] = set()
    doubts: dict[str, dict[str, None]] = {}
    for place, one in enumerate(findings):
        normals = max(normals, one.normals)
        unknown += [] if one.is_judged else [place]
        impossible |= {*one.impossible}
        if one.doubtful:
            doubts.setdefault(one.name, {}).update(dict.fromkeys(one.doubtful))
    texts: list[str] = [
        *(sentence("comparisons.impossible", output=one) for one in sorted(impossible)),
        *(
            sentence("comparisons.not_confirmed", device=name, outputs=tuple(outputs))
            for name, outputs in doubts.items()
        ),
    ]
    return normals, unknown, texts


def _not_of_both(
    devices: Sequence[Device], outputs: Sequence[Name], *, pairs: bool
) -> Iterator[str]:
    """Say once of what limits on both triads together are not judged."""
    if pairs or any(len(device.sensors) < len(SENSORS) for device in devices):
        for parameters in by_group(outputs):
            yield sentence("comparisons.of_both", parameters=parameters)


def _not_compared(
    devices: Sequence[Device], requirement: Requirement, owners: Container[str]
) -> tuple[str, ...]:
    """Return the sensors that have limits, and that no device has.

    So of what belongs to both, where none of the `owners` of what is asked is that.
    """
    there = _present(devices) | ({IMU} if IMU in owners else set())
    return tuple(kind for kind in requirement.kinds if kind not in there)


def _present(devices: Sequence[Device]) -> set[str]:
    """Return the sensors that some device has; and the mission, where one has both."""
    found = {sensor.kind for device in devices for sensor in device.sensors}
    both = any(len(device.sensors) == len(SENSORS) for device in devices)
    return found | ({MISSION} if both else set())
