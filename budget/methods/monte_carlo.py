"""Propagation of distributions by a Monte Carlo method: JCGM 101:2008, clause 7."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial, reduce
from itertools import chain
from math import ceil, pi, sqrt
from operator import add
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import COVERAGES, is_coverage
from budget.errors import CallError, ProblemError
from budget.methods.execution import (
    BLOCK,
    batches,
    in_order,
    local_executor,
    small_blocks,
)
from budget.methods.intervals import (
    KINDS,
    Grid,
    Histogram,
    interval_of_trials,
    numerical_tolerance,
)
from budget.methods.trials import check_finite

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Executor

    import pandas as pd

    from budget.arrays import Array
    from budget.problem import Output, Problem


EXACT_TRIALS = 2_000_000  # kept as they are; beyond, quantiles come from a histogram
MAX_TRIALS = EXACT_TRIALS  # of an adaptive run that is not told otherwise
LEAST_TRIALS = 2  # have a spread
LEAST_MACRO_BLOCK = 10_000  # trials, JCGM 101:2008, 7.9.4 b)
# Macro-blocks of the first stage, for one digit and for more. Student's t quantile is
# 1.25 and 1.07 times the normal one for them, and trials go as its square; two digits
# take more than 30 macro-blocks in most cases anyway.
FIRST_STAGE = 10
FIRST_STAGE_FINE = 30
AHEAD = 2  # tasks under way for each worker
# Macro-blocks in a task at the most: one takes some 10 ms, sending a task 1 ms to a
# process of this machine and more to another machine.
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
    outputs : tuple of Output
        What the rows are of.
    """

    trials: int
    mean: Array
    covariance: Array
    interval: Array
    tolerance: Array | None
    reached: Array | None
    outputs: tuple[Output, ...] = ()

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table with a row for each output, in its unit."""
        import pandas as pd

        scale = np.array([output.si_per_unit for output in self.outputs])
        return pd.DataFrame(
            {
                "output": [str(output.name) for output in self.outputs],
                "unit": [output.unit for output in self.outputs],
                "mean": self.mean / scale,
                "standard_uncertainty": self.standard_uncertainty / scale,
                "interval_low": self.interval[:, 0] / scale,
                "interval_high": self.interval[:, 1] / scale,
                "is_settled": self.is_settled,
            }
        )

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
    ahead = AHEAD * workers

    def tasks(bundle: int) -> Iterator[tuple[_Task, ...]]:
        first = 0  # macro-block of the next task
        while first * plan.size < most:
            # Tasks under way when an adaptive run settles are lost: together no more
            # macro-blocks than were given out before.
            size = min(bundle, max(first // ahead, 1)) if adaptive else bundle
            last = min(first + size, ceil(most / plan.size))
            yield tuple(
                _Task(
                    index=index,
                    trials=min(plan.size, most - index * plan.size),
                    grid=None if gathering is None else gathering.grid,
                )
                for index in range(first, last)
            )
            first = last

    with local_executor(1 if executor is not None else workers) as pool:
        doer = executor or pool
        bundle = REMOTE_BUNDLE if executor else LOCAL_BUNDLE if pool else 1
        work = partial(_macro_blocks, problem, plan)
        for block in chain.from_iterable(
            in_order(work, tasks(bundle), doer, ahead=ahead)
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
        outputs=tuple(problem.outputs),
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
    with small_blocks():
        return [_macro_block(problem, plan, task) for task in tasks]


def _macro_block(problem: Problem, plan: _Plan, task: _Task) -> MacroBlock:
    """Draw, evaluate and condense one macro-block."""
    y = np.empty((len(problem.outputs), task.trials))
    moments: list[Moments] = []
    first = task.index * plan.blocks
    for at, values in batches(problem, plan.seed, block=first, trials=task.trials):
        if at.stop - at.start < task.trials:
            y[:, at] = values
        else:
            y = values
        moments.append(Moments.of(values))
    total = reduce(add, moments)
    check_finite(total.deviations)
    settling = None
    if task.index < plan.first_stage:
        ends = [interval_of_trials([row], plan.coverage, plan.interval) for row in y]
        settling = np.stack(
            [total.mean, total.standard_uncertainty, *np.transpose(ends)]
        )
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


ERROR_RATE = 0.05  # [1], of what adaptive trials are said to have settled to
FAR = 0.5  # part of a mean square that a mean may have, as it is subtracted [1]
HALVINGS = 12  # of the bracket around r, from above: to 1e-4 of it


@dataclass(frozen=True, kw_only=True, eq=False)
class Moments:
    """Mean and co-moment of a number of trials; two of them add up exactly."""

    n: int
    mean: Array  # shape (n_out,)
    deviations: Array  # sum over trials of (y - mean)(y - mean)^T, shape (n_out, n_out)

    @classmethod
    def of(cls, y: Array) -> Moments:
        """Return the moments of trials, shape (n_out, n)."""
        mean = y.mean(axis=1)
        products = y @ y.T
        squares, n = products.diagonal(), y.shape[1]
        if (n * mean**2 <= FAR * squares).all():  # nothing cancels
            deviations = products - n * np.outer(mean, mean)
        else:
            centred = y - mean[:, None]
            deviations = centred @ centred.T
        return cls(n=n, mean=mean, deviations=deviations)

    def __add__(self, other: Moments) -> Moments:
        """Return the moments of both together (pairwise update of a variance)."""
        n = self.n + other.n
        step = other.mean - self.mean
        return Moments(
            n=n,
            mean=self.mean + step * (other.n / n),
            deviations=self.deviations
            + other.deviations
            + np.outer(step, step) * (self.n * other.n / n),
        )

    @property
    def covariance(self) -> Array:
        """Sample covariance, shape (n_out, n_out): JCGM 101:2008, eq. (17)."""
        return np.asarray(self.deviations / (self.n - 1))

    @property
    def standard_uncertainty(self) -> Array:
        """Sample standard deviations, shape (n_out,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, kw_only=True, eq=False)
class MacroBlock:
    """What a worker returns of M trials."""

    moments: Moments
    # The trials, in their order; None where their counts stand instead, shape (n_out,
    # M).
    values: Array | None = None
    histogram: Histogram | None = None
    # Mean, standard uncertainty and both interval ends of this block alone; of the
    # macro-blocks of the first stage, shape (4, n_out).
    settling: Array | None = None


class Gathering:
    """Macro-blocks taken in one after another, and the numbers of all so far."""

    def __init__(self, first: MacroBlock, *, exact: bool) -> None:
        """Begin with the first block; `exact` keeps up to EXACT_TRIALS as they are."""
        self.moments = first.moments
        self._keep = EXACT_TRIALS if exact else 0
        self._kept: list[Array] = []
        self._histogram: Histogram | None = None
        self._settling: list[Array] = []
        self._blocks = 0
        self._store(first)

    @property
    def grid(self) -> Grid | None:
        """Bins for macro-blocks yet to come; None while values are kept."""
        return None if self._histogram is None else self._histogram.grid

    def take(self, block: MacroBlock) -> None:
        """Take in the next macro-block."""
        self.moments += block.moments
        self._store(block)

    def reached(self, kind: str) -> Array:
        """Return what the least settled of the four numbers has settled to, (n_out,).

        Stein's two stages in place of the fixed factor 2 of JCGM 101:2008, 7.9.4 e) to
        i): with s_j the spread of number j over the n macro-blocks of the first stage
        and h those there are, r solves

            sum_j P(|t_{n-1}| > r sqrt(h)/s_j) = ERROR_RATE ,

        so that all four errors are within r with a probability of 1 - ERROR_RATE or
        more (Bonferroni; the union over four, each with a part of the rate that goes by
        its spread). For one number it is exact where block values are normal, because s
        comes from the first stage alone and decides only when to stop (Stein 1945, Ann.
        Math. Statist. 16, 243-258). A spread taken anew at every block would choose the
        moments at which it happens to be small.

        The ends of a shortest interval settle as h^(-1/3) only (Kim and Pollard 1990,
        Ann. Statist. 18, 191-219).
        """
        n = len(self._settling)
        if n < 2:  # noqa: PLR2004 - a spread takes two
            return np.full(self.moments.mean.shape, np.inf)
        ends = 1.0 / 3.0 if kind == "shortest" else 1.0 / 2.0
        rate = float(self._blocks) ** -np.array([0.5, 0.5, ends, ends])
        error = np.std(self._settling, axis=0, ddof=1) * rate[:, None]
        return _exceeded_by_none(error, n - 1)

    def interval(self, coverage: float, kind: str) -> Array:
        """Return the coverage intervals of all trials so far, shape (n_out, 2)."""
        if self._histogram is not None:
            return self._histogram.interval(coverage, kind)
        # Output after output: never a second copy of all trials.
        each = zip(*self._kept, strict=True)
        return np.stack([interval_of_trials(one, coverage, kind) for one in each])

    def values(self) -> Array | None:
        """Return all trials in their order, shape (n_out, trials), if still kept."""
        return None if self._histogram else np.concatenate(self._kept, axis=1)

    def _store(self, block: MacroBlock) -> None:
        """Keep values while they are few, counts from then on."""
        self._blocks += 1
        if block.settling is not None:
            self._settling.append(block.settling)
        if block.histogram is not None:
            self._count(block.histogram)
        elif block.values is not None:  # noqa: PD011 - no pandas
            self._kept.append(block.values)
        if self._kept and (self._histogram or self.moments.n > self._keep):
            grid = self.grid or Grid.around(
                self.moments.mean, self.moments.standard_uncertainty
            )
            while self._kept:  # freed one by one
                self._count(grid.count(self._kept.pop(0)))

    def _count(self, more: Histogram) -> None:
        """Add counts to those so far."""
        self._histogram = more if self._histogram is None else self._histogram + more


def _exceeded_by_none(error: Array, degrees_of_freedom: int) -> Array:
    """Return r of each column with sum_j P(|t| > r/error_j) = ERROR_RATE, (n_out,)."""
    v = degrees_of_freedom
    largest, counts = error.max(axis=0), len(error)
    # As if only the largest counted, and as if all were as large.
    low = largest * student_quantile(ERROR_RATE, v)
    high = largest * student_quantile(ERROR_RATE / counts, v)
    safe = np.where(error > 0.0, error, 1.0)
    for _ in range(HALVINGS):
        r = 0.5 * (low + high)
        beyond = np.where(error > 0.0, student_tails(r / safe, v), 0.0).sum(axis=0)
        low, high = (
            np.where(beyond > ERROR_RATE, r, low),
            np.where(beyond > ERROR_RATE, high, r),
        )
    return np.asarray(high)


def student_tails(t: Array, v: int) -> Array:
    """Return P(|T| > t) of Student's t with v degrees of freedom, whole and few.

    By t = sqrt(v) tan a the density of T is cos^(v-1) a over its integral B_v, and
    integration by parts gives P(|T| <= t) = A_v with

        A_1 = 2 a/pi, A_2 = sin a, A_(n+2) = A_n + 2 sin a cos^n a / (n B_n) ,

    B_1 = pi, B_2 = 2, B_(n+2) = B_n n/(n+1). To rounding of 1, not of the tails; what
    scipy has to rounding of these takes longer to import than a short run to compute.
    """
    tangent = t / sqrt(v)
    cosine = 1.0 / np.sqrt(1.0 + tangent**2)
    sine = tangent * cosine
    n, B, power = (1, pi, cosine) if v % 2 else (2, 2.0, cosine**2)
    within = 2.0 / pi * np.arctan(tangent) if v % 2 else sine
    while n < v:
        within = within + 2.0 / (n * B) * sine * power
        n, B, power = n + 2, B * n / (n + 1), power * cosine**2
    return np.asarray(1.0 - within)


@cache
def student_quantile(tails: float, v: int) -> float:
    """Return t with P(|T| > t) = tails, of v degrees of freedom, whole and few."""
    low, high = 0.0, 1.0
    while student_tails(np.array(high), v) > tails:
        high *= 2.0
    while low < (t := 0.5 * (low + high)) < high:
        if student_tails(np.array(t), v) > tails:
            low = t
        else:
            high = t
    return high
