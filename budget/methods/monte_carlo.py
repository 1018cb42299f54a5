"""Propagation of distributions by a Monte Carlo method: JCGM 101:2008, clause 7."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import BLOCK, Progress, draw, executor, in_order

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.problem import Problem


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """Monte Carlo trials of all outputs.

    Attributes
    ----------
    values : ndarray, shape (n_out, trials)
        Model values, trial by trial: the columns are joint draws.
    mean : ndarray, shape (n_out,)
        JCGM 101:2008, eq. (16).
    covariance : ndarray, shape (n_out, n_out)
        JCGM 101:2008, eq. (17); JCGM 102:2011, 7.6 for several outputs.
    """

    values: Array
    mean: Array
    covariance: Array

    @property
    def trials(self) -> int:
        """Number of trials, M."""
        return int(self.values.shape[1])

    @property
    def standard_uncertainty(self) -> Array:
        """Standard uncertainties of the outputs, shape (n_out,)."""
        return np.sqrt(np.diag(self.covariance))

    def interval(self, coverage: float, kind: str = "symmetric") -> Array:
        """Return coverage intervals, shape (n_out, 2): JCGM 101:2008, 7.7.

        Parameters
        ----------
        coverage : float
            Probability, above 0 and below 1.
        kind : str
            'symmetric' (in probability) or 'shortest'.
        """
        find = {"symmetric": symmetric_interval, "shortest": shortest_interval}[kind]
        return np.array([find(row, coverage) for row in self.values])


def sample(
    problem: Problem,
    *,
    trials: int,
    seed: int = 0,
    workers: int = 1,
    progress: Progress | None = None,
) -> Sample:
    """Draw inputs, evaluate the model, collect the outputs.

    Parameters
    ----------
    problem : Problem
        Any.
    trials : int
        Number of trials, 2 or more.
    seed : int
        The same seed gives the same numbers, whatever the number of workers; the
        first trials of a longer run are those of a shorter one.
    workers : int
        Number of processes.
    progress : callable, optional
        Called with the trials done and the trials in all.

    Returns
    -------
    Sample
        [SI units of the outputs].
    """
    values = np.empty((len(problem.outputs), trials))
    starts = range(0, trials, BLOCK)
    with executor(workers) as pool:
        blocks = in_order(
            partial(_evaluate_block, problem, seed), range(len(starts)), pool
        )
        for start, y in zip(starts, blocks, strict=True):
            end = min(start + BLOCK, trials)
            values[:, start:end] = y[:, : end - start]
            if progress is not None:
                progress(end, trials)
    return collect(values)


def collect(values: Array) -> Sample:
    """Make a Sample of trials that are there already, shape (n_out, trials)."""
    mean = values.mean(axis=1)
    return Sample(values=values, mean=mean, covariance=_covariance(values, mean))


def symmetric_interval(values: Array, coverage: float) -> tuple[float, float]:
    """Return the probabilistically symmetric interval: JCGM 101:2008, 7.7.2."""
    M = values.size
    q = _count(M, coverage)
    low = (M - q + 1) // 2  # r of 7.7.2, counted from 1
    ends = np.partition(values, (low - 1, low + q - 1))
    return float(ends[low - 1]), float(ends[low + q - 1])


def shortest_interval(values: Array, coverage: float) -> tuple[float, float]:
    """Return the shortest interval: JCGM 101:2008, 7.7.4."""
    ordered = np.sort(values)
    q = _count(values.size, coverage)
    best = int(np.argmin(ordered[q:] - ordered[:-q]))
    return float(ordered[best]), float(ordered[best + q])


def _count(M: int, coverage: float) -> int:
    """Return q = p M as an integer that leaves a value on either side, 7.7.1."""
    return min(max(int(M * coverage + 0.5), 1), M - 1)


def _evaluate_block(problem: Problem, seed: int, block: int) -> Array:
    """Return the outputs of one block, shape (n_out, BLOCK)."""
    x = draw(problem, seed, block, np.empty((problem.n_inputs, BLOCK)))
    return problem.evaluate(x)


def _covariance(values: Array, mean: Array) -> Array:
    """Return the sample covariance, block by block: no copy of all trials."""
    n, trials = values.shape
    C = np.zeros((n, n))
    for start in range(0, trials, BLOCK):
        deviation = values[:, start : start + BLOCK] - mean[:, None]
        C += deviation @ deviation.T
    return np.asarray(C / (trials - 1))
