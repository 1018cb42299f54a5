"""Verdicts on every candidate, a chunk at once; more trials for ties in the ranking."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import compress, islice, pairwise
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import in_order
from budget.methods.largest import is_same, probability_smaller
from budget.methods.validation import validate
from budget.missing import REFUSE, shipped_devices
from budget.missing.prediction import prepare
from budget.question import laws_together
from budget.sentences import sentence
from budget.spooled import SpooledList
from budget.studies.comparison.records import Entrant, Lead, MissingLines, UnknownCap
from budget.studies.figures_of_merit import MERITS, is_within, over_cap
from budget.studies.judgement import (
    MAX_TRIALS,
    STEP,
    TRIALS,
    can_sharpen,
    judge,
    judge_with,
    screened,
)
from budget.studies.readings import verdicts_by_reading
from budget.studies.verdicts import FAILS, unjudged, verdict_on
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from concurrent.futures import Executor

    from budget.question import Question
    from budget.results import Verdict
    from budget.settings import Asked

Task = tuple[int, "Question"]  # place of the device among those compared, what is asked

CHUNK = 256  # candidates that are judged by the law at once
PREDICTED = 64  # of these, whose missing lines are predicted at once: fits are large
NEAR = (0.95, 1.05)  # utilisations at which the fast screen is not the last word


def judge_all(
    candidates: Iterable[Task],
    asked: Asked,
    *,
    executor: Executor | None,
    ahead: int,
    progress: Callable[[int], None],
) -> Sequence[Entrant]:
    """Judge all as they come; those whose rank is open again with more trials.

    Parameters
    ----------
    candidates : iterable of (int, Question)
        No more of them stand in memory than are under way, and than trials may rank.
    asked : Asked
        Its trials are those of each at first, and at most.
    executor : Executor or None
        None: this process.
    ahead : int
        Chunks that are given out at once.
    progress : callable
        Called with the judgements done.
    """
    # By the law a chunk is sooner judged than sent; trials are shared out singly.
    size = CHUNK if by_law(asked) else 1
    open_to_trials: dict[int, Question] = {}

    def chunks() -> Iterator[list[Task]]:
        source = enumerate(candidates)
        while chunk := [*islice(source, size)]:
            # No trial says how a line that is not given would rank a device.
            open_to_trials.update(
                (k, replace(one))  # of thousands no Problem is kept
                for k, (_, one) in chunk
                if size == 1 and one.has_lines
                if not (one.missing or one.filled.lines)
            )
            yield [task for _, task in chunk]

    found: SpooledList[Entrant] | list[Entrant] = []
    if by_law(asked):
        found = SpooledList()
    work = partial(judge_chunk, asked=asked)
    for some in in_order(work, chunks(), executor, ahead=ahead):
        found.extend(some)
        progress(len(found))
    if isinstance(found, SpooledList):
        return found.held()
    done, number = len(found), asked.trials or TRIALS
    most = asked.max_trials or MAX_TRIALS
    while number < most and open_to_trials:
        number = min(STEP * number, most)
        tied = _tied({k: found[k] for k in open_to_trials}, most)
        closer = partial(_look_closer, seed=asked.seed, trials=number)
        tasks = ((open_to_trials[k], found[k]) for k in tied)
        results = in_order(closer, tasks, executor, ahead=ahead)
        for k, one in zip(tied, results, strict=True):
            found[k] = one
            done += 1
            progress(done)
        if not tied:
            break
    return found


def by_law(asked: Asked) -> bool:
    """Whether no trial is made."""
    return asked.method == "gum" and not asked.validate


def judge_chunk(tasks: Sequence[Task], *, asked: Asked) -> list[Entrant]:
    """Judge some candidates; what they share is made at once."""
    own = [replace(one) for _, one in tasks]  # of thousands no Problem is kept
    laws_together([one for one in own if one.has_lines])
    found: list[Entrant] = []
    for start in range(0, len(own), PREDICTED):
        some = slice(start, start + PREDICTED)
        devices = dict.fromkeys(device for one in own[some] for device in one.devices)
        prepare(devices, own[start].catalogue or shipped_devices())
        for one, (place, _) in zip(own[some], tasks[some], strict=True):
            found.append(_judge(one, place, asked))
    return found


def _judge(one: Question, place: int, asked: Asked) -> Entrant:
    """Judge one candidate, by the law alone or as every command does."""
    if not one.has_lines:
        return entrant_of(one, unjudged(one), place)
    held, seed = one.limits, asked.seed
    prediction = one.filled.prediction
    trials, most = asked.trials or TRIALS, asked.max_trials or MAX_TRIALS
    doubtful: tuple[str, ...] = ()
    last = trials if prediction else most  # what is missing no trial decides
    if by_law(asked):
        judged = screened(held, seed=seed, max_trials=last)
    else:
        judged = judge(held, seed=seed, trials=trials, max_trials=last)
    if asked.validate:
        checks = validate(
            held.problem, held.law, coverage=one.wanted.coverage, seed=seed
        )
        doubtful = tuple(
            held.problem.outputs[row].name
            for row, by_trials in zip(held.rows, judged.by_trials, strict=True)
            if not (by_trials or checks[row].holds)
        )
    beyond = np.abs(held.law.value[held.rows]) >= held.limits
    is_usual = by_law(asked) or (trials, most) == (TRIALS, MAX_TRIALS)
    readings = verdicts_by_reading(
        one, seed=seed, by_law=by_law(asked), taken=judged if is_usual else None
    )
    verdict = verdict_on(one, judged, seed=seed, readings=readings)
    # Trials make no difference to what missing lines leave open.
    is_open = verdict.doubt is None and judged.trials is None
    is_near = NEAR[0] <= judged.utilisation <= NEAR[1]
    found = entrant_of(one, verdict, place)
    one.let_go()
    return replace(
        found,
        advice=sentence("comparisons.advice") if is_open and is_near else "",
        at_medians=found.missing is not None and prediction is not None,
        counted=judged.counted,
        closer=None if judged.trials is None else judged,
        normals=held.problem.normals_per_trial,
        impossible=tuple(compress((x.name for x in held.outputs), beyond)),
        doubtful=doubtful,
    )


def entrant_of(one: Question, verdict: Verdict, place: int) -> Entrant:
    """Return what is said of every candidate, whether it can be judged or not."""
    device = one.devices[0]
    caps = [(m, cap, getattr(device, m)) for m, cap in one.wanted.caps if m in MERITS]
    return Entrant(
        **vars(verdict),
        name=device.name,
        place=place,
        procedure=one.procedure.name,
        file=device.origin.file,
        measured=device.measured.file if device.measured else "",
        technology=device.technology,
        vendor=device.vendor,
        not_given=tuple(name for own in one.sensors for name in own.not_given),
        missing=_missing_lines(one, verdict),
        price=device.price,
        mass=device.mass,
        power=device.power,
        over_caps=tuple(
            said for merit, cap, text in caps if (said := over_cap(merit, text, cap))
        ),
        unknown_caps=tuple(
            UnknownCap(merit=merit, cap=cap, text=text)
            for merit, cap, text in caps
            if is_within(merit, text, cap) is None
        ),
    )


def _missing_lines(one: Question, verdict: Verdict) -> MissingLines | None:
    """Return what lines that are not given could do to limits; None where none can."""
    missing = verdict.matter(one.bare.missing)
    if not missing:
        return None
    is_bound = one.filled.mode == REFUSE
    used = verdict.at_ceilings if is_bound else None
    return MissingLines(
        lines=missing,
        filling=one.filled,
        utilisation=used,
        verdict="" if used is None else "meets" if settle(used) <= 1.0 else "fails",
        is_bound=is_bound,
    )


def _look_closer(task: tuple[Question, Entrant], *, seed: int, trials: int) -> Entrant:
    """Judge one candidate again with more trials, for its rank."""
    one, finding = task
    if (finding.looked_at.trials or 0) >= trials:
        return finding
    one = replace(one)  # of thousands no Problem is kept
    return replace(finding, closer=judge_with(one.limits, seed=seed, trials=trials))


def _tied(findings: dict[int, Entrant], max_trials: int) -> list[int]:
    """Return the places that a neighbour ties with, where more trials can tell.

    Of devices that fail nobody chooses one: their ties stand as their verdicts left
    them.
    """
    found: set[int] = set()
    lists: dict[tuple[str, str, str], list[int]] = {}
    for place, one in findings.items():
        if one.verdict != FAILS:
            key = (one.sensor, one.procedure, one.verdict)
            lists.setdefault(key, []).append(place)
    for places in lists.values():
        order = sorted(places, key=lambda p: findings[p].utilisation)
        for better, worse in pairwise(order):
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
            for pair in pairwise(order)
            if is_same(*(findings[place].looked_at.ends for place in pair))
        ]
        for pair in (*twins, *reversed(twins)):
            if found & {*pair}:
                found |= {*pair}
    return sorted(found)
