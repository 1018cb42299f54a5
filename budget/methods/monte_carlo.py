"""Propagation of distributions by a Monte Carlo method: JCGM 101:2008, clause 7.

Trials come in macro-blocks of M (7.9.4). Each is drawn in blocks that fit the cache,
and macro-blocks are gathered in their order, so neither the numbers nor the decision to
stop depends on who computed them. Adaptive runs stop by Stein's two stages: the spread
over a first stage of macro-blocks says how many it takes (Gathering.reached).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial, reduce
from itertools import chain
from math import ceil
from operator import add
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import COVERAGES, is_coverage
from budget.errors import CallError, ProblemError
from budget.methods.execution import (
    BLOCK,
    draw,
    in_order,
    local_executor,
    one_blas_thread,
)
from budget.methods.gathering import EXACT_TRIALS, Gathering, MacroBlock, Moments
from budget.methods.intervals import KINDS, Grid, interval_of_values
from budget.methods.tolerance import numerical_tolerance
from budget.methods.trials import check_finite

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Executor

    from budget.arrays import Array
    from budget.problem import Problem

MAX_TRIALS = EXACT_TRIALS  # of an adaptive run that is not told otherwise
LEAST_TRIALS = 2  # have a spread
LEAST_MACRO_BLOCK = 10_000  # trials, JCGM 101:2008, 7.9.4 b)
# Macro-blocks of the first stage, for one digit and for more. Student's t quantile is
# 1.25 and 1.07 times the normal one for them, and trials go as its square; two digits
# take more than 30 macro-blocks in most cases anyway.
FIRST_STAGE = 10
FIRST_STAGE_FINE = 30
AHEAD = 2  # tasks under way for each worker
# Macro-blocks in a task: one takes some 10 ms, sending a task 1 ms to a process of this
# machine and more to another machine.
LOCAL_BUNDLE = 2
REMOTE_BUNDLE = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """The numbers of a Monte Carlo run, and how far they have settled.

    Attributes
    ----------
    trials : int
        Number of trials made.
    mean : ndarray, shape (n_out,)
        JCGM 101:2008, eq. (16).
    covariance : ndarray, shape (n_out, n_out)
        JCGM 101:2008, eq. (17); JCGM 102:2011, 7.6 for several outputs.
    interval : ndarray, shape (n_out, 2)
        JCGM 101:2008, 7.7.
    tolerance : ndarray, shape (n_out,), or None
        What adaptive trials are to settle to.
    reached : ndarray, shape (n_out,), or None
        What they have settled to: the errors of estimate, standard uncertainty and both
        interval ends of an output are all within it with a probability of 0.95
        (7.9.4, with Stein's two stages). None where the number of trials was fixed.
    """

    trials: int
    mean: Array
    covariance: Array
    interval: Array
    tolerance: Array | None
    reached: Array | None

    @property
    def standard_uncertainty(self) -> Array:
        """Standard uncertainties of the outputs, shape (n_out,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def is_settled(self) -> Array:
        """Whether each output has settled, shape (n_out,); a fixed run always has."""
        if self.reached is None or self.tolerance is None:
            return np.ones(self.mean.shape, dtype=bool)
        return np.asarray(self.reached <= self.tolerance)


@dataclass(frozen=True, kw_only=True)
class _Plan:
    """What every task of one run has to know."""

    seed: int
    blocks: int  # of BLOCK trials in a macro-block
    coverage: float
    interval: str
    first_stage: int  # macro-blocks whose spread is taken, 0 for a fixed run

    @property
    def size(self) -> int:
        """Trials in a macro-block, M."""
        return self.blocks * BLOCK


@dataclass(frozen=True, kw_only=True, eq=False)
class _Task:
    """One macro-block to be computed."""

    index: int
    trials: int  # M, fewer in the last one of a fixed run
    grid: Grid | None  # count in these bins, or return the values


def sample(
    problem: Problem,
    *,
    trials: int | None = None,
    digits: int = 1,
    part: float = 1.0,
    max_trials: int = MAX_TRIALS,
    coverage: float = 0.95,
    interval: str = "symmetric",
    seed: int = 0,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Sample:
    """Draw inputs, evaluate the model, gather the outputs.

    Parameters
    ----------
    problem : Problem
        Any. Its function must be picklable where other processes work.
    trials : int, optional
        Number of trials, 2 or more. Without it adaptive (JCGM 101:2008, 7.9): until
        estimate, standard uncertainty and both interval ends of every output have
        settled to its numerical tolerance.
    digits : int
        Significant digits of the standard uncertainty that adaptive trials make sure.
    part : float
        Part of that tolerance to settle to; 1/5 to validate the law (8.2).
    max_trials : int
        Where adaptive trials stop at the latest, to the macro-block.
    coverage : float
        Probability of the intervals.
    interval : str
        'symmetric' or 'shortest'.
    seed : int
        The same seed gives the same numbers whatever the number of workers; the first
        trials of a longer run are those of a shorter one.
    workers : int
        Number of processes on this machine, or of workers that the executor has.
    executor : concurrent.futures.Executor, optional
        Does the work: a pool of processes, a cluster.
    progress : callable, optional
        Called with the trials done and the trials in all at the most.

    Returns
    -------
    Sample
        [SI units of the outputs].

    Raises
    ------
    CallError
        An argument means nothing, or max_trials is too few for the coverage.
    ProblemError
        The function returned a value that is not finite.
    WorkerError
        A worker died, or the model cannot be sent to it.
    """
    _check(trials, digits, coverage, interval)
    problem = problem.pooled
    adaptive = trials is None
    blocks = (_macro_block_size(coverage) if adaptive else _macro_block_size()) // BLOCK
    first_stage = FIRST_STAGE if digits == 1 else FIRST_STAGE_FINE
    plan = _Plan(
        seed=seed,
        blocks=blocks,
        coverage=coverage,
        interval=interval,
        # With room for fewer blocks all there are, and a larger t quantile for them.
        first_stage=min(first_stage, max_trials // (blocks * BLOCK)) if adaptive else 0,
    )
    if adaptive and max_trials < least_trials(coverage):
        raise CallError(
            f"adaptive trials at coverage {coverage:g} take at the least "
            f"{least_trials(coverage)} (two macro-blocks of JCGM 101, 7.9.4), but "
            f"max_trials is {max_trials}; raise it, or give a number of trials"
        )
    most = max_trials // plan.size * plan.size if trials is None else trials
    exact = trials is None or trials <= EXACT_TRIALS
    gathering: Gathering | None = None

    def tasks(bundle: int) -> Iterator[tuple[_Task, ...]]:
        for first in range(0, most, bundle * plan.size):
            yield tuple(
                _Task(
                    index=start // plan.size,
                    trials=min(plan.size, most - start),
                    grid=None if gathering is None else gathering.grid,
                )
                for start in range(
                    first, min(first + bundle * plan.size, most), plan.size
                )
            )

    with local_executor(1 if executor is not None else workers) as pool:
        doer = executor or pool
        bundle = REMOTE_BUNDLE if executor else LOCAL_BUNDLE if pool else 1
        work = partial(_macro_blocks, problem, plan)
        for block in chain.from_iterable(
            in_order(work, tasks(bundle), doer, ahead=AHEAD * workers)
        ):
            if gathering is None:
                gathering = Gathering(block, exact=exact)
            else:
                gathering.take(block)
            if progress is not None:
                progress(gathering.moments.n, most)
            if adaptive and _is_settled(gathering, problem, plan, digits, part):
                break
    if gathering is None:
        raise ProblemError(f"a Monte Carlo run of {most} trials has no result")
    return Sample(
        trials=gathering.moments.n,
        mean=gathering.moments.mean,
        covariance=gathering.moments.covariance,
        interval=gathering.interval(coverage, interval),
        tolerance=part * _tolerance(gathering, problem, digits) if adaptive else None,
        reached=gathering.reached(interval) if adaptive else None,
    )


def least_trials(coverage: float) -> int:
    """Return what an adaptive run takes at the least: two macro-blocks, 7.9.4 b)."""
    return 2 * _macro_block_size(coverage)


def first_stage_trials(coverage: float, digits: int) -> int:
    """Return what an adaptive run takes before it first asks whether it may stop."""
    stage = FIRST_STAGE if digits == 1 else FIRST_STAGE_FINE
    return stage * _macro_block_size(coverage)


def _macro_block_size(coverage: float = 0.0) -> int:
    """Return M of 7.9.4 b), in whole blocks."""
    return ceil(max(LEAST_MACRO_BLOCK, 100.0 / (1.0 - coverage)) / BLOCK) * BLOCK


def _check(trials: int | None, digits: int, coverage: float, interval: str) -> None:
    """Refuse arguments that mean nothing, all at once."""
    faults = []
    if trials is not None and trials < LEAST_TRIALS:
        faults.append(f"trials is {trials}, allowed: {LEAST_TRIALS} or more")
    if digits < 1:
        faults.append(f"digits is {digits}, allowed: 1 or more")
    if not is_coverage(coverage):
        faults.append(f"coverage is {coverage!r}, allowed: {COVERAGES}")
    if interval not in KINDS:
        faults.append(f"interval is {interval!r}, allowed: {', '.join(KINDS)}")
    if faults:
        raise CallError("; ".join(faults))


def _macro_blocks(
    problem: Problem, plan: _Plan, tasks: tuple[_Task, ...]
) -> list[MacroBlock]:
    """Do the macro-blocks of one task."""
    with one_blas_thread():
        return [_macro_block(problem, plan, task) for task in tasks]


def _macro_block(problem: Problem, plan: _Plan, task: _Task) -> MacroBlock:
    """Draw, evaluate and condense one macro-block."""
    y = np.empty((len(problem.outputs), task.trials))
    x = np.empty((problem.n_inputs, BLOCK))
    moments: list[Moments] = []
    for k, start in enumerate(range(0, task.trials, BLOCK)):
        draw(problem, plan.seed, task.index * plan.blocks + k, x)
        block = problem.evaluate(x)[:, : task.trials - start]
        y[:, start : start + BLOCK] = block
        moments.append(Moments.of(block))
    total = reduce(add, moments)
    check_finite(total.deviations)
    settling = None
    if task.index < plan.first_stage:
        ends = interval_of_values(np.sort(y), plan.coverage, plan.interval)
        settling = np.stack([total.mean, total.standard_uncertainty, *ends.T])
    if task.grid is None:
        return MacroBlock(moments=total, values=y, settling=settling)
    return MacroBlock(moments=total, histogram=task.grid.count(y), settling=settling)


def _is_settled(
    gathering: Gathering, problem: Problem, plan: _Plan, digits: int, part: float
) -> bool:
    """Whether every output has settled to its tolerance: JCGM 101:2008, 7.9.4 i)."""
    if gathering.moments.n < plan.first_stage * plan.size:
        return False
    tolerance = part * _tolerance(gathering, problem, digits)
    return bool((gathering.reached(plan.interval) <= tolerance).all())


def _tolerance(gathering: Gathering, problem: Problem, digits: int) -> Array:
    """Return the numerical tolerance of every output at the u found so far [SI]."""
    return numerical_tolerance(
        gathering.moments.standard_uncertainty, problem.outputs, digits
    )
