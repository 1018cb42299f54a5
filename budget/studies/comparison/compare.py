"""Devices against a requirement: judged, ranked with confidence, paired."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.methods.execution import in_order, local_executor
from budget.results import InputFile, Settings
from budget.studies.comparison.candidates import (
    Candidate,
    bound_missing,
    candidate,
    find_remedy,
)
from budget.studies.comparison.figures_of_merit import MERITS, over_cap
from budget.studies.comparison.ranking import pair_up, rank
from budget.studies.comparison.records import (
    Ahead,
    Comparison,
    DeviceVerdict,
    RequiredOutput,
)
from budget.studies.comparison.sampling import (
    Judged,
    judge_by_law,
    judge_by_trials,
    probability_smaller,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

    from budget.spec.records import Device, Procedure, Requirement

METHODS = ("gum", "monte-carlo")
TRIALS = 100_000
MAX_TRIALS = 1_600_000  # where more trials stop trying to settle a verdict or a rank
STEP = 4  # times as many trials in each try
NEAR = (0.95, 1.05)  # utilisations for which the law alone is a poor judge


@dataclass(frozen=True, kw_only=True)
class _How:
    """What every judgement of one comparison shares."""

    method: str
    coverage: float
    seed: int
    trials: int
    max_trials: int


def compare(
    devices: Sequence[Device],
    requirement: Requirement,
    procedures: Sequence[Procedure],
    *,
    catalogue: Sequence[Device] = (),
    method: str = "monte-carlo",
    trials: int = TRIALS,
    max_trials: int = MAX_TRIALS,
    pairs: bool = False,
    seed: int = 0,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Judge every sensor of every device under every procedure, and rank them.

    Parameters
    ----------
    devices : sequence of Device
        Candidates; variants are devices of their own.
    requirement : Requirement
        Limits, coverage and reference.
    procedures : sequence of Procedure
        One or more.
    catalogue : sequence of Device
        Where the worst value of a line that is not given is taken from.
    method : str
        'monte-carlo' on common random numbers, or 'gum', the fast screen.
    trials : int
        Of each device at first; verdicts and ranks that they leave open get more.
    max_trials : int
        The most that a device gets.
    pairs : bool
        Whether gyros and accelerometers are paired too.
    seed, workers, executor
        As of monte_carlo.sample; workers share out devices.
    progress : callable, optional
        Called with the judgements done and those in all.

    Returns
    -------
    Comparison

    Raises
    ------
    CallError
        No device has a sensor that the requirement limits.
    """
    candidates = [
        one
        for procedure in procedures
        for device in devices
        for sensor in device.sensors
        if (one := candidate(device, sensor, procedure, requirement)) is not None
    ]
    if not candidates:
        raise CallError(
            f"{requirement.name} limits no sensor that these devices have; "
            "add limits for them, or give other devices"
        )
    how = _How(
        method=method,
        coverage=requirement.coverage,
        seed=seed,
        trials=trials,
        max_trials=max_trials,
    )
    with local_executor(1 if executor is not None else workers) as pool:
        judged = _judge_all(
            candidates,
            how,
            doer=executor or pool,
            ahead=2 * workers,
            progress=progress,
        )
    verdicts = [
        _verdict(one, result, requirement, catalogue, method)
        for one, result in zip(candidates, judged, strict=True)
    ]
    ranked = rank(verdicts)
    return Comparison(
        requirement=requirement.name,
        procedures=tuple(procedure.name for procedure in procedures),
        inputs=_inputs(devices, requirement, procedures),
        settings=Settings(
            method=method,
            trials=trials if method == "monte-carlo" else None,
            seed=seed,
            coverage=requirement.coverage,
            interval="symmetric",
            reference=requirement.reference,
            formulas=", ".join(dict.fromkeys(p.formulas for p in procedures)),
            normals_per_trial=max(c.problem.normals_per_trial for c in candidates),
        ),
        devices=ranked,
        pairs=pair_up(ranked) if pairs else (),
        assumptions=tuple(
            dict.fromkeys(
                f"{device.name}: {text}"
                for device in devices
                for text in device.assumptions
            )
        ),
        warnings=_warnings(devices, requirement, candidates),
    )


def _judge_all(
    candidates: Sequence[Candidate],
    how: _How,
    *,
    doer: Executor | None,
    ahead: int,
    progress: Callable[[int, int], None] | None,
) -> list[Judged]:
    """Judge all; those whose verdict or rank is open again, with more trials."""
    open_ones = list(range(len(candidates)))
    judged: dict[int, Judged] = {}
    number, done = how.trials, 0
    while open_ones:
        work = partial(_judge, how=how, trials=number)
        chosen = [candidates[place] for place in open_ones]
        for place, result in zip(
            open_ones, in_order(work, chosen, doer, ahead=ahead), strict=True
        ):
            judged[place] = result
            done += 1
            if progress is not None:
                progress(done, max(done, len(candidates)))
        number *= STEP
        if how.method == "gum" or number > how.max_trials:
            break
        open_ones = _unsettled(candidates, judged)
    return [judged[place] for place in range(len(candidates))]


def _judge(one: Candidate, *, how: _How, trials: int) -> Judged:
    """Judge one candidate."""
    if how.method == "gum":
        return judge_by_law(
            one.law, one.rows, one.limits, coverage=how.coverage, seed=how.seed
        )
    return judge_by_trials(
        one.problem,
        one.rows,
        one.limits,
        coverage=how.coverage,
        trials=trials,
        seed=how.seed,
    )


def _unsettled(candidates: Sequence[Candidate], judged: dict[int, Judged]) -> list[int]:
    """Return the places whose verdict is open, or that a neighbour ties with."""
    found = {
        place
        for place, result in judged.items()
        if result.utilisation_low <= 1.0 < result.utilisation_high
    }
    lists: dict[tuple[str, str], list[int]] = {}
    for place, one in enumerate(candidates):
        lists.setdefault((one.sensor.kind, one.procedure.name), []).append(place)
    for places in lists.values():
        order = sorted(
            places, key=lambda place: _largest(candidates[place], judged[place])
        )
        for better, worse in itertools.pairwise(order):
            a, b = judged[better].batches, judged[worse].batches
            if np.array_equal(a, b):
                continue  # the same lines under two names: no trial parts them
            step = Ahead(other="", probability=probability_smaller(a, b))
            if step.is_tied:
                found |= {better, worse}
    return sorted(found)


def _largest(one: Candidate, result: Judged) -> float:
    """Return the largest utilisation [1]."""
    return float((result.largest_error / one.limits).max())


def _verdict(
    one: Candidate,
    result: Judged,
    requirement: Requirement,
    catalogue: Sequence[Device],
    method: str,
) -> DeviceVerdict:
    """Turn a judgement into the verdict on one sensor of one device."""
    utilisations = result.largest_error / one.limits
    worst = int(np.argmax(utilisations))
    utilisation = float(utilisations[worst])
    if result.utilisation_low <= 1.0 < result.utilisation_high:
        verdict = "undecided"
    elif utilisation > 1.0:
        verdict = "fails"
    else:
        verdict = "undecidable" if one.sensor.expected_missing else "meets"
    near = method == "gum" and NEAR[0] <= utilisation <= NEAR[1]
    device = one.device
    outputs = [one.problem.outputs[row] for row in one.rows]
    return DeviceVerdict(
        name=device.name,
        sensor=one.sensor.kind,
        procedure=one.procedure.name,
        file=device.origin.file,
        technology=device.technology,
        verdict=verdict,
        utilisation=utilisation,
        utilisation_interval=(result.utilisation_low, result.utilisation_high),
        worst_output=outputs[worst].name,
        conformance=result.conformance,
        outputs=tuple(
            RequiredOutput(
                output=output,
                limit=float(one.limits[k]),
                printed_limit=one.printed[k],
                standard_uncertainty=float(result.u[k]),
                largest_error=float(result.largest_error[k]),
                conformance=float(result.within[k]),
            )
            for k, output in enumerate(outputs)
        ),
        remedy=find_remedy(one, worst, requirement.coverage),
        not_given=one.sensor.not_given,
        missing=bound_missing(one, requirement, catalogue),
        trials=result.trials,
        price=device.price,
        mass=device.mass,
        power=device.power,
        over_caps=tuple(
            text
            for merit, cap in requirement.caps
            if merit in MERITS
            and (text := over_cap(merit, getattr(device, merit), cap))
        ),
        advice="near the limit: use --method monte-carlo" if near else "",
        batches=result.batches,
    )


def _warnings(
    devices: Sequence[Device],
    requirement: Requirement,
    candidates: Sequence[Candidate],
) -> tuple[str, ...]:
    """Name what a reader could misread: double names, no limits, impossible limits."""
    found = []
    twice = [name for name, n in Counter(d.name for d in devices).items() if n > 1]
    if twice:
        found.append(f"devices of the same name: {', '.join(sorted(twice))}")
    limited = {limit.output.split(".")[0] for limit in requirement.limits}
    present = {sensor.kind for device in devices for sensor in device.sensors}
    found += [
        f"{requirement.name} has no limit for a {kind}, which some devices have: "
        "it is not compared"
        for kind in sorted(present - limited)
    ]
    impossible = {
        one.problem.outputs[row].name
        for one in candidates
        for row, limit in zip(one.rows, one.limits, strict=True)
        if abs(one.law.value[row]) >= limit
    }
    found += [
        f"the limit on {name} is below what the procedure leaves without any error "
        "source: no device can meet it"
        for name in sorted(impossible)
    ]
    return tuple(found)


def _inputs(
    devices: Sequence[Device],
    requirement: Requirement,
    procedures: Sequence[Procedure],
) -> tuple[InputFile, ...]:
    """Return every file that the comparison depends on."""
    origins = [("device", device.origin) for device in devices]
    origins += [("procedure", procedure.origin) for procedure in procedures]
    origins.append(("requirement", requirement.origin))
    return tuple(
        InputFile(role=role, name=origin.file, sha256=origin.sha256)
        for role, origin in origins
    )
