"""Verdicts on every candidate; paired trials for neighbours in the ranking."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import in_order
from budget.methods.largest import is_same, probability_smaller
from budget.methods.validation import validate
from budget.missing import REFUSE, shipped_devices
from budget.missing.prediction import prepare
from budget.sentences import sentence
from budget.studies.comparison.records import Entrant, Lead, MissingLines, UnknownCap
from budget.studies.figures_of_merit import MERITS, is_known, over_cap
from budget.studies.judgement import (
    MAX_TRIALS,
    STEP,
    TRIALS,
    can_sharpen,
    judge,
    judge_with,
    screen,
)
from budget.studies.readings import verdicts_by_reading
from budget.studies.verdicts import FAILS, verdict_on
from budget.ties import settle

CHUNK = 64  # candidates that are judged by the law at once

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

    from budget.question import Question
    from budget.results import Verdict


NEAR = (0.95, 1.05)  # utilisations at which the fast screen is not the last word


@dataclass(frozen=True, kw_only=True)
class Judging:
    """What every judgement of one comparison shares."""

    method: str  # 'gum' or 'monte-carlo'
    coverage: float  # of the intervals that are held against the limits
    seed: int
    # Of a candidate at first and at most.
    trials: int
    max_trials: int
    validate: bool  # whether Monte Carlo checks the law, by gum

    @property
    def by_law(self) -> bool:
        """Whether no trial is made."""
        return self.method == "gum" and not self.validate


def judge_all(
    candidates: Sequence[Question],
    judging: Judging,
    *,
    executor: Executor | None,
    ahead: int,
    progress: Callable[[int, int], None] | None,
) -> list[Entrant]:
    """Judge all; those whose rank is open are looked at again with more trials.

    `ahead` candidates are given out at once; `progress` is called with the judgements
    done and those in all.
    """
    findings: dict[int, Entrant] = {}
    done = 0

    def take(places: Sequence[int], work: Callable[..., Entrant]) -> None:
        nonlocal done
        total = done + len(places)
        # By the law a chunk is sooner judged than sent; trials are shared out singly.
        size = CHUNK if judging.by_law else 1
        tasks = (
            [(candidates[place], findings.get(place)) for place in places[k : k + size]]
            for k in range(0, len(places), size)
        )
        results = in_order(partial(_each, work=work), tasks, executor, ahead=ahead)
        each = (finding for some in results for finding in some)
        for place, finding in zip(places, each, strict=True):
            findings[place] = finding
            done += 1
            if progress is not None:
                progress(done, total)

    take(range(len(candidates)), partial(_judge, judging=judging))
    number = judging.trials
    while number < judging.max_trials:
        number = min(STEP * number, judging.max_trials)
        tied = _tied(candidates, findings, judging.max_trials)
        if not tied:
            break
        take(tied, partial(_look_closer, judging=judging, trials=number))
    return [findings[place] for place in range(len(candidates))]


def _each(
    tasks: Sequence[tuple[Question, Entrant | None]],
    *,
    work: Callable[..., Entrant],
) -> list[Entrant]:
    """Judge some candidates, one after the other; what they share is made at once."""
    devices = dict.fromkeys(device for one, _ in tasks for device in one.devices)
    prepare(devices, tasks[0][0].catalogue or shipped_devices())
    return [work(task) for task in tasks]


def _judge(task: tuple[Question, None], *, judging: Judging) -> Entrant:
    """Judge one candidate, by the law alone or as every command does."""
    one = replace(task[0])  # of thousands no Problem is kept
    held, law = one.limits, one.law
    prediction = one.filled.prediction
    doubtful: tuple[str, ...] = ()
    if judging.by_law:
        judged = screen(held, law, seed=judging.seed)
    else:
        judged = judge(
            held,
            law,
            seed=judging.seed,
            trials=judging.trials,
            # What missing lines leave open, no trial decides.
            max_trials=judging.trials if prediction else judging.max_trials,
        )
    if judging.validate:
        checks = validate(
            held.problem, law, coverage=judging.coverage, seed=judging.seed
        )
        doubtful = tuple(
            held.problem.outputs[row].name
            for row, by_trials in zip(held.rows, judged.by_trials, strict=True)
            if not (by_trials or checks[row].holds)
        )
    beyond = np.abs(law.value[held.rows]) >= held.limits
    names = [output.name for output in held.outputs]
    readings = None
    if prediction is None and len(one.sensors) == 1:
        by_law = judging.by_law
        is_usual = (judging.trials, judging.max_trials) == (TRIALS, MAX_TRIALS)
        readings = verdicts_by_reading(
            one,
            seed=judging.seed,
            by_law=by_law,
            taken=judged if by_law or is_usual else None,
        )
    verdict = verdict_on(
        one,
        judged,
        seed=judging.seed,
        readings=readings,
    )
    used = judged.utilisation
    is_near = NEAR[0] <= used <= NEAR[1]
    # Trials make no difference to what missing lines leave open.
    is_open = verdict.doubt is None and judged.trials is None
    is_open = is_open and (is_near or judged.is_open)
    found = entrant_of(one, verdict)
    one.let_go()
    return replace(
        found,
        advice=sentence("comparisons.advice", is_near=is_near) if is_open else "",
        at_medians=found.missing is not None and prediction is not None,
        judged=judged,
        closer=judged,
        normals=held.problem.normals_per_trial,
        impossible=tuple(itertools.compress(names, beyond)),
        doubtful=doubtful,
    )


def entrant_of(one: Question, verdict: Verdict) -> Entrant:
    """Return what is said of every candidate, whether it can be judged or not."""
    device, caps = one.devices[0], one.wanted.caps
    return Entrant(
        **vars(verdict),
        name=device.name,
        place=0,
        procedure=one.procedure.name,
        file=device.origin.file,
        technology=device.technology,
        vendor=device.vendor,
        not_given=tuple(name for one in one.sensors for name in one.not_given),
        missing=missing_lines(one, verdict),
        price=device.price,
        mass=device.mass,
        power=device.power,
        over_caps=tuple(
            text
            for merit, cap in caps
            if merit in MERITS
            and (text := over_cap(merit, getattr(device, merit), cap))
        ),
        unknown_caps=tuple(
            UnknownCap(merit=merit, cap=cap, text=text)
            for merit, cap in caps
            if merit in MERITS
            and not is_known(merit, text := getattr(device, merit), cap)
        ),
    )


def missing_lines(one: Question, verdict: Verdict) -> MissingLines | None:
    """Return what lines that are not given could do to limits; None where none can."""
    missing = verdict.matter(one.bare.missing)
    if not missing:
        return None
    used = verdict.at_ceilings
    is_bound = one.filled.mode == REFUSE
    return MissingLines(
        lines=missing,
        filling=one.filled,
        utilisation=used if is_bound else None,
        verdict=""
        if used is None or not is_bound
        else ("meets" if settle(used) <= 1.0 else "fails"),
        is_bound=is_bound,
    )


def _look_closer(
    task: tuple[Question, Entrant], *, judging: Judging, trials: int
) -> Entrant:
    """Judge one candidate again with more trials, for its rank."""
    one, finding = task
    if (finding.looked_at.trials or 0) >= trials:
        return finding
    one = replace(one)
    closer = judge_with(
        one.limits,
        one.law,
        seed=judging.seed,
        trials=trials,
    )
    return replace(finding, closer=closer)


def _tied(
    candidates: Sequence[Question],
    findings: dict[int, Entrant],
    max_trials: int,
) -> list[int]:
    """Return the places that a neighbour ties with, where more trials can tell.

    Of devices that fail nobody chooses one: their ties stand as their verdicts left
    them.
    """
    found: set[int] = set()
    lists: dict[tuple[str, str, str], list[int]] = {}
    for place, one in enumerate(candidates):
        if one.missing or one.filled.lines:
            continue  # no trial says how a line that is not given would rank it
        if findings[place].verdict == FAILS:
            continue
        key = (one.owner, one.procedure.name, findings[place].verdict)
        lists.setdefault(key, []).append(place)
    for places in lists.values():
        order = sorted(places, key=lambda p: findings[p].utilisation)
        for better, worse in itertools.pairwise(order):
            a, b = (findings[place].looked_at for place in (better, worse))
            if is_same(a.ends, b.ends):
                continue  # what decides is the same lines: no trial parts them
            step = Lead(other="", probability=probability_smaller(a.ends, b.ends))
            if step.is_tied:
                found |= {
                    place
                    for place, one in ((better, a), (worse, b))
                    if can_sharpen(one, max_trials, above=one.utilisation_interval[0])
                }
        # Those that nothing parts are drawn for together, or their ends would differ
        # by the trials alone.
        twins = [
            pair
            for pair in itertools.pairwise(order)
            if is_same(*(findings[place].looked_at.ends for place in pair))
        ]
        for pair in (*twins, *reversed(twins)):
            if found & {*pair}:
                found |= {*pair}
    return sorted(found)
