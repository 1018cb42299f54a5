"""Blocks of trials: who draws what, in which order results come back.

Every source has a stream of its own for every block, seeded by (seed, name of the
source, number of the block). So a result is bit for bit the same for any number of
workers, and adding a source moves no other's draws.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from hashlib import sha256
from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.problem import Group, Problem

BLOCK = 4096  # trials; inputs of a block (some 2 MB) stay in the cache

Result = TypeVar("Result")
Progress = Callable[[int, int], None]  # trials done, trials in all


def stream(seed: int, name: str, block: int) -> np.random.Generator:
    """Return the random stream of one source in one block of trials.

    Parameters
    ----------
    seed : int
        Of the run, 0 or larger.
    name : str
        Of the source.
    block : int
        Number of the block, from 0.
    """
    key = int.from_bytes(sha256(name.encode()).digest()[:8], "big")
    sequence = np.random.SeedSequence(seed, spawn_key=(key, block))
    return np.random.Generator(np.random.SFC64(sequence))


def draw(problem: Problem, seed: int, block: int, out: Array) -> Array:
    """Fill one block of inputs.

    Parameters
    ----------
    problem : Problem
        Whose inputs are drawn.
    seed, block : int
        Which numbers.
    out : ndarray, shape (n_inputs, BLOCK)
        Is overwritten; constant inputs keep their mean.

    Returns
    -------
    ndarray
        `out`.
    """
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        x = out[rows]
        if group.is_constant:
            x[:] = group.mean[:, None]
            continue
        _draw_unit(group, stream(seed, group.name, block), x)
        if group.is_independent:
            x *= np.diag(group.factor)[:, None]
        else:
            x[:] = group.factor @ x
        if group.mean.any():
            x += group.mean[:, None]
    return out


def _draw_unit(group: Group, rng: np.random.Generator, out: Array) -> None:
    """Fill `out`, shape (n, BLOCK), with variates of unit standard uncertainty."""
    shapes = group.distributions
    if len(set(shapes)) == 1:
        shapes[0].draw(rng, out)
        return
    for shape, row in zip(shapes, out, strict=True):
        shape.draw(rng, row)


@contextmanager
def executor(workers: int) -> Iterator[Executor | None]:
    """Provide an executor, or None where one process does the work itself."""
    if workers == 1:
        yield None
        return
    pool = ProcessPoolExecutor(workers)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def in_order(
    work: Callable[[int], Result],
    tasks: Iterable[int],
    pool: Executor | None,
) -> Iterator[Result]:
    """Yield the result of every task in the order of the tasks, whoever does it."""
    yield from map(work, tasks) if pool is None else pool.map(work, tasks)
