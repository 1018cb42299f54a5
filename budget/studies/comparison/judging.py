"""Judge every candidate; those that the trials leave open, again with more trials."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import in_order
from budget.methods.gum import propagate
from budget.methods.validation import validate
from budget.studies.comparison.candidates import Candidate, find_remedy
from budget.studies.comparison.records import Ahead, Remedy
from budget.studies.comparison.sampling import (
    Judged,
    judge_by_law,
    judge_by_trials,
    probability_smaller,
)
from budget.ties import equal_to, first_largest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from concurrent.futures import Executor

STEP = 4  # times as many trials in each try


@dataclass(frozen=True, kw_only=True)
class How:
    """What every judgement of one comparison shares.

    Attributes
    ----------
    method : str
        'gum' or 'monte-carlo'.
    coverage : float
        Of the intervals that are held against the limits.
    seed : int
    trials, max_trials : int
        Of a candidate at first and at most.
    validate : bool
        Whether Monte Carlo checks the law, by gum.
    """

    method: str
    coverage: float
    seed: int
    trials: int
    max_trials: int
    validate: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Finding:
    """What is kept of one candidate; its law and its trials are not."""

    judged: Judged
    verdict: str
    worst: int  # place of the worst output among the required ones
    all_worst: tuple[int, ...]  # with the outputs that are equal to it by the law
    remedy: Remedy
    impossible: tuple[str, ...]  # outputs beyond their limits without any source
    doubtful: tuple[str, ...]  # outputs for which Monte Carlo does not confirm the law


def judge_all(
    candidates: Sequence[Candidate],
    how: How,
    *,
    executor: Executor | None,
    ahead: int,
    progress: Callable[[int, int], None] | None,
) -> list[Finding]:
    """Judge all; those whose verdict or rank is open again, with more trials.

    Parameters
    ----------
    candidates : sequence of Candidate
    how : How
    executor : Executor or None
        Does the work in place of this process.
    ahead : int
        Candidates given out at once.
    progress : callable, optional
        Called with the judgements done and those in all.
    """
    open_ones = list(range(len(candidates)))
    findings: dict[int, Finding] = {}
    number, done = how.trials, 0
    while open_ones:
        work = partial(judge, how=how, trials=number)
        chosen = [candidates[place] for place in open_ones]
        total = done + len(chosen)
        for place, finding in zip(
            open_ones, in_order(work, chosen, executor, ahead=ahead), strict=True
        ):
            findings[place] = finding
            done += 1
            if progress is not None:
                progress(done, total)
        if how.method == "gum" or number >= how.max_trials:
            break
        number = min(STEP * number, how.max_trials)
        open_ones = _unsettled(candidates, findings)
    return [findings[place] for place in range(len(candidates))]


def judge(one: Candidate, *, how: How, trials: int) -> Finding:
    """Judge one candidate, by the law or by that many trials."""
    law = propagate(one.problem)
    doubtful: tuple[str, ...] = ()
    if how.method == "gum":
        judged = judge_by_law(
            law, one.rows, one.limits, coverage=how.coverage, seed=how.seed
        )
        if how.validate:
            checks = validate(one.problem, law, coverage=how.coverage, seed=how.seed)
            doubtful = tuple(
                one.problem.outputs[row].name
                for row in one.rows
                if not checks[row].holds
            )
    else:
        judged = judge_by_trials(
            one.problem,
            one.rows,
            one.limits,
            coverage=how.coverage,
            trials=trials,
            seed=how.seed,
        )
    worst = first_largest((judged.largest_error / one.limits).tolist())
    ends = np.abs(law.interval(how.coverage)[one.rows]).max(axis=1)
    beyond = np.abs(law.value[one.rows]) >= one.limits
    return Finding(
        judged=judged,
        verdict=_verdict(one, judged, worst),
        worst=worst,
        all_worst=equal_to((ends / one.limits).tolist(), worst),
        remedy=find_remedy(one, law, worst, how.coverage),
        impossible=tuple(one.problem.outputs[row].name for row in one.rows[beyond]),
        doubtful=doubtful,
    )


def _verdict(one: Candidate, judged: Judged, worst: int) -> str:
    """Return one of VERDICTS; a missing expected line stops nothing but a `meets`."""
    if judged.utilisation_low <= 1.0 < judged.utilisation_high:
        return "undecided"
    if judged.largest_error[worst] > one.limits[worst]:
        return "fails"
    return "undecidable" if one.sensor.expected_missing else "meets"


def _unsettled(
    candidates: Sequence[Candidate], findings: dict[int, Finding]
) -> list[int]:
    """Return the places whose verdict is open, or that a neighbour ties with."""
    found = {p for p, finding in findings.items() if finding.verdict == "undecided"}
    lists: dict[tuple[str, str, str], list[int]] = {}
    for place, one in enumerate(candidates):
        if one.sensor.expected_missing:
            continue  # no trial says how a line that is not given would rank it
        key = (one.sensor.kind, one.procedure.name, findings[place].verdict)
        lists.setdefault(key, []).append(place)
    for places in lists.values():
        order = sorted(places, key=lambda p: _largest(candidates[p], findings[p]))
        for better, worse in itertools.pairwise(order):
            a, b = (findings[place].judged for place in (better, worse))
            if np.array_equal(a.largest_error, b.largest_error) and np.array_equal(
                a.batches, b.batches
            ):
                continue  # the same lines under two names: no trial parts them
            step = Ahead(
                other="", probability=probability_smaller(a.batches, b.batches)
            )
            if step.is_tied:
                found |= {better, worse}
    return sorted(found)


def _largest(one: Candidate, finding: Finding) -> float:
    """Return the largest utilisation [1]."""
    worst = finding.worst
    return float(finding.judged.largest_error[worst] / one.limits[worst])
