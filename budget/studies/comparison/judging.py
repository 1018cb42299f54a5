"""Verdicts on every candidate; paired trials for neighbours in the ranking."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.methods.execution import in_order
from budget.methods.largest import is_same, probability_smaller
from budget.methods.validation import validate
from budget.missing import shipped_devices
from budget.missing.prediction import prepare
from budget.studies.comparison.candidates import find_remedy
from budget.studies.comparison.records import Lead, Remedy
from budget.studies.doubt import doubt_of
from budget.studies.judgement import (
    MAX_TRIALS,
    STEP,
    TRIALS,
    Judged,
    assess_outputs,
    can_sharpen,
    judge,
    judge_with,
    screen,
)
from budget.studies.readings import verdicts_by_reading
from budget.studies.verdicts import FAILS, decide

CHUNK = 64  # candidates that are judged by the law at once

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

    from budget.names import Name
    from budget.question import Limited, Question
    from budget.results import Doubt, OutputAssessment, ReadingVerdicts, Standing


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


@dataclass(frozen=True, kw_only=True, eq=False)
class JudgedCandidate:
    """What is kept of one candidate; its law and its trials are not."""

    # With as many trials as the verdict took: what every command says of it.
    judged: Judged
    closer: Judged  # with as many as its rank took, for nothing but the rank
    standing: Standing
    outputs: tuple[OutputAssessment, ...]  # the required ones
    # That which uses most of its limit; that and all that are equal by the law.
    worst: Name
    all_worst: tuple[Name, ...]
    remedy: Remedy
    doubt: Doubt | None  # where missing lines are predicted
    readings: ReadingVerdicts | None  # where the meaning of lines is open
    normals: int  # that a trial of its Problem draws
    impossible: tuple[str, ...]  # outputs beyond their limits without any source
    doubtful: tuple[str, ...]  # outputs for which Monte Carlo does not confirm the law


def judge_all(
    candidates: Sequence[Question],
    judging: Judging,
    *,
    executor: Executor | None,
    ahead: int,
    progress: Callable[[int, int], None] | None,
) -> list[JudgedCandidate]:
    """Judge all; those whose rank is open are looked at again with more trials.

    `ahead` candidates are given out at once; `progress` is called with the judgements
    done and those in all.
    """
    findings: dict[int, JudgedCandidate] = {}
    done = 0

    def take(places: Sequence[int], work: Callable[..., JudgedCandidate]) -> None:
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
    tasks: Sequence[tuple[Question, JudgedCandidate | None]],
    *,
    work: Callable[..., JudgedCandidate],
) -> list[JudgedCandidate]:
    """Judge some candidates, one after the other; what they share is made at once."""
    devices = dict.fromkeys(device for one, _ in tasks for device in one.devices)
    prepare(devices, tasks[0][0].catalogue or shipped_devices())
    return [work(task) for task in tasks]


def _judge(task: tuple[Question, None], *, judging: Judging) -> JudgedCandidate:
    """Judge one candidate, by the law alone or as every command does."""
    one = replace(task[0])  # of thousands no Problem is kept
    held, law = held_of(one), one.law
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
    missing = (*one.missing, *held.absent)
    doubt = None
    if prediction is not None and not missing:
        doubt = doubt_of(prediction, held, law, judged)
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
    standing = decide(
        one,
        held,
        law,
        judged,
        seed=judging.seed,
        doubt=doubt,
        readings=readings,
    )
    return JudgedCandidate(
        judged=judged,
        closer=judged,
        standing=standing,
        outputs=assess_outputs(held, judged, standing, one.lacks),
        worst=names[judged.worst],
        all_worst=tuple(names[place] for place in judged.all_worst),
        remedy=find_remedy(held, law, judged),
        doubt=doubt,
        readings=readings,
        normals=held.problem.normals_per_trial,
        impossible=tuple(itertools.compress(names, beyond)),
        doubtful=doubtful,
    )


def held_of(one: Question) -> Limited:
    """Return its Problem with the limits on it.

    Raises
    ------
    CallError
        Nothing is required of it.
    """
    if one.held is None:
        raise CallError(
            f"{one.wanted.name} limits nothing of the {one.owner}; "
            "add limits for it, or leave it out"
        )
    return one.held


def _look_closer(
    task: tuple[Question, JudgedCandidate], *, judging: Judging, trials: int
) -> JudgedCandidate:
    """Judge one candidate again with more trials, for its rank."""
    one, finding = task
    if (finding.closer.trials or 0) >= trials:
        return finding
    one = replace(one)
    closer = judge_with(
        held_of(one),
        one.law,
        seed=judging.seed,
        trials=trials,
    )
    return replace(finding, closer=closer)


def _tied(
    candidates: Sequence[Question],
    findings: dict[int, JudgedCandidate],
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
        if findings[place].standing.verdict == FAILS:
            continue
        key = (one.owner, one.procedure.name, findings[place].standing.verdict)
        lists.setdefault(key, []).append(place)
    for places in lists.values():
        order = sorted(places, key=lambda p: findings[p].judged.utilisation)
        for better, worse in itertools.pairwise(order):
            a, b = (findings[place].closer for place in (better, worse))
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
            if is_same(*(findings[place].closer.ends for place in pair))
        ]
        for pair in (*twins, *reversed(twins)):
            if found & {*pair}:
                found |= {*pair}
    return sorted(found)
