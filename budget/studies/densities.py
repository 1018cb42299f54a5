"""Densities of the errors of the critical outputs, by Monte Carlo trials.

The density of a bin is the part of all trials in it over its width: what a histogram
shows, scaled so that it integrates to 1 and a normal density can stand beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from budget.known import Known
from budget.methods.intervals import interval_of_trials
from budget.methods.trials import first_trials
from budget.ties import first_largest

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.names import Name
    from budget.problem import Output
    from budget.question import Question
    from budget.results import Assessment, Budget

TRIALS = 100_000
# Of a normal output a bin is 0.07 u wide and the highest has 3,000 trials: uneven by
# 2 %, which an eye does not see.
BINS = 120


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorDensity:
    """The distribution of the error of one output, and what the law says of it."""

    output: Output
    trials: int  # of Monte Carlo
    # Ends of the bins, from the smallest trial to the largest, shape (BINS + 1,) [SI].
    edges: Array = field(repr=False)
    # Probability density in each bin, shape (BINS,) [1/SI].
    density: Array = field(repr=False)
    # Of the law, so of its normal distribution [SI].
    mean: float
    u: Known
    interval: tuple[float, float]  # coverage interval of the law [SI]
    interval_mc: tuple[float, float]  # coverage interval of the trials [SI]
    limit: float | None  # on the absolute error [SI]; None where nothing is required


def critical_densities(
    question: Question,
    budget: Budget,
    assessment: Assessment | None,
    *,
    trials: int = TRIALS,
) -> tuple[ErrorDensity, ...]:
    """Draw the distributions of the outputs that decide, in their order.

    With an assessment they are the output of each parameter group with the largest
    utilisation, without one the widest of each group. An output without spread has no
    density and is left out. The trials are the first ones of the streams that Monte
    Carlo draws from, with the seed and the kind of interval of the budget.
    """
    settings = budget.settings
    limits: dict[str, float] = {}
    if assessment is not None:
        limits = {row.output.name: row.limit for row in assessment.outputs}
    wanted = _critical(budget, assessment)
    if not wanted:
        return ()
    problem, law = question.problem, question.law
    rows = [k for k, output in enumerate(problem.outputs) if output.name in wanted]
    ends = law.interval(settings.coverage)
    values = first_trials(problem, trials=trials, seed=settings.seed, outputs=rows)
    ends_mc = [
        interval_of_trials([y], settings.coverage, settings.interval) for y in values
    ]
    for place, k in enumerate(rows):  # one interval of each output on a page
        row = budget.outputs[k]
        if row.by_trials:
            ends_mc[place] = np.array(row.interval)
    densities = []
    for place, k in enumerate(rows):
        density, edges = np.histogram(values[place], bins=BINS, density=True)
        densities.append(
            ErrorDensity(
                output=problem.outputs[k],
                trials=trials,
                edges=edges,
                density=density,
                mean=float(law.mean[k]),
                u=Known.of(
                    float(law.standard_uncertainty[k]),
                    budget.outputs[k].standard_uncertainty.why,
                ),
                interval=(float(ends[k, 0]), float(ends[k, 1])),
                interval_mc=(float(ends_mc[place][0]), float(ends_mc[place][1])),
                limit=limits.get(problem.outputs[k].name),
            )
        )
    return tuple(densities)


def _critical(budget: Budget, assessment: Assessment | None) -> set[Name]:
    """Return the names of the outputs that decide, at the most one a group."""
    resolved = {row.output.name for row in budget.outputs if row.is_resolved}
    weights = {row.output.name: row.standard_uncertainty for row in budget.outputs}
    if assessment is not None:
        weights = {row.output.name: row.utilisation for row in assessment.outputs}
    groups: dict[Name, list[Name]] = {}
    for name in weights:
        if name in resolved:
            groups.setdefault(name.group, []).append(name)
    return {
        names[first_largest([weights[name] for name in names])]
        for names in groups.values()
    }
