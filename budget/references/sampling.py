"""Standard errors of what trials give: how much another seed would change it.

A result keeps means and intervals, not its trials. So the spread of every statistic is
taken from batches of trials of the same model, on streams of their own, and standard
errors follow from it and from the number of trials that the result has.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import BLOCK
from budget.methods.intervals import interval_of_values
from budget.methods.trials import first_trials

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.names import Name
    from budget.problem import Output, Problem

SHAPE_TRIALS = 8 * BLOCK
SHAPE_SEED = 20_190_306  # any fixed one: shapes are properties of the model
BATCHES = 64
IN_TAIL = 10.0  # trials beyond an end of an interval, in a batch that tells its spread


@dataclass(frozen=True, kw_only=True, eq=False)
class StandardErrors:
    """Of every output of a run with so many trials, shape (n_out,) [SI]."""

    outputs: tuple[Output, ...]
    mean: Array
    u: Array  # of the standard uncertainty
    low: Array  # of the ends of the coverage interval
    high: Array
    correlation: Array  # of the correlation coefficients, shape (n_out, n_out) [1]
    degrees_of_freedom: float  # of all but the ends
    end_degrees_of_freedom: float

    @property
    def end(self) -> Array:
        """Of the larger absolute end, shape (n_out,) [SI].

        That of the less sure one: the larger of two numbers strays no further than
        the one of them that strays further.
        """
        return np.maximum(self.low, self.high)

    def of(self, statistic: str, *names: Name) -> float:
        """Return one of the fields, of one output or of two, in its unit."""
        places = {output.name: k for k, output in enumerate(self.outputs)}
        at = tuple(places[name] for name in names)
        per = self.outputs[at[0]].si_per_unit if len(at) == 1 else 1.0
        return float(getattr(self, statistic)[at]) / per

    def freedom(self, statistic: str) -> float:
        """Return the degrees of freedom of one of the fields."""
        is_end = statistic in {"low", "high", "end"}
        return self.end_degrees_of_freedom if is_end else self.degrees_of_freedom


def standard_errors(
    problem: Problem, *, trials: int, coverage: float, interval: str = "symmetric"
) -> StandardErrors:
    """Return the standard errors of a Monte Carlo result.

    The standard deviation s of a statistic over batches of m trials each is that of
    the whole run but for the number of trials n: s sqrt(m/n). Where the shortest
    interval lies is sure to the cube root of the trials only.

    """
    y = first_trials(problem, trials=SHAPE_TRIALS, seed=SHAPE_SEED)
    batches = _split(y, BATCHES)
    mean = batches.mean(axis=2, keepdims=True)
    u = batches.std(axis=2, keepdims=True)
    z = (batches - mean) / np.where(u > 0.0, u, 1.0)
    size = y.shape[1] / BATCHES
    # Few large batches for a high coverage: their extremes would tell nothing.
    tail = (1.0 - coverage) / 2.0
    number = min(max(int(tail * y.shape[1] / IN_TAIL), 2), BATCHES)
    parts = _split(y, number)
    parts.sort(axis=2)
    ends = np.stack([interval_of_values(one, coverage, interval) for one in parts])
    power = 1.0 / 2.0 if interval == "symmetric" else 1.0 / 3.0
    spread = _spread(ends) * (y.shape[1] / number / trials) ** power
    root = sqrt(size / trials)
    return StandardErrors(
        outputs=problem.outputs,
        mean=_spread(mean[..., 0]) * root,
        u=_spread(u[..., 0]) * root,
        low=spread[:, 0],
        high=spread[:, 1],
        correlation=_spread(z @ z.transpose(0, 2, 1) / size) * root,
        degrees_of_freedom=BATCHES - 1.0,
        end_degrees_of_freedom=number - 1.0,
    )


def _split(y: Array, number: int) -> Array:
    """Return trials in batches of one size, shape (number, n_out, size)."""
    size = y.shape[1] // number
    parts = y[:, : number * size].reshape(len(y), number, size)
    return np.ascontiguousarray(parts.transpose(1, 0, 2))


def _spread(values: Array) -> Array:
    """Return the standard deviation over batches."""
    return np.asarray(values.std(axis=0, ddof=1))
