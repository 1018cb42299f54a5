"""Execution of trials: random streams by source and block, processes, their order.

Every source has a stream of its own for every block of trials, seeded by (seed, name of
the source, number of the block). So a result is bit for bit the same for any number of
workers, and adding a source moves no other's draws.
"""

from __future__ import annotations

import os
import signal
from collections import deque
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from contextlib import contextmanager
from functools import cache, lru_cache
from hashlib import sha256
from itertools import islice
from math import ceil
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from threadpoolctl import ThreadpoolController

from budget.distributions import LEAST
from budget.errors import BudgetError, WorkerError

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator

    from budget.arrays import Array
    from budget.problem import Group, Problem

HEARTBEAT = 2.0  # [s] between looks at whether the others are still there
KEPT = 2**25 - 2**16  # bytes, of memory that the C library is told to keep
BLOCK = 4096  # trials of a stream; inputs of a block (some 2 MB) stay in the cache
BATCH = 3  # blocks that are evaluated at once: a macro-block of most runs

Task = TypeVar("Task")
Result = TypeVar("Result")


def stream(seed: int, name: str, block: int) -> np.random.Generator:
    """Return the random stream of one source in one block of trials, from block 0."""
    sequence = np.random.SeedSequence(seed, spawn_key=(_key(name), block))
    return np.random.Generator(np.random.SFC64(sequence))


@lru_cache(maxsize=4096)
def _key(name: str) -> int:
    """Return the number of a source among all that there may be."""
    return int.from_bytes(sha256(name.encode()).digest()[:8], "big")


def draw(
    problem: Problem,
    seed: int,
    block: int,
    out: Array,
    *,
    kept: dict[Hashable, Array] | None = None,
) -> Array:
    """Fill one block of inputs, shape (n_inputs, BLOCK), and return it.

    Constant inputs keep their mean. `kept` are unit variates of this seed and block,
    which other Problems have in common; what is drawn is added.
    """
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        x = out[rows]
        if group.is_constant:
            x[:] = group.mean[:, None]
            continue
        key = (group.name, x.shape, None if group.is_normal else group.drawn)
        z = None if kept is None else kept.get(key)
        if z is None:
            z = np.empty(x.shape)
            _draw_unit(group, stream(seed, group.name, block), z)
            if kept is not None:
                kept[key] = z
        group.deviations(z, out=x)
        for place, scale in enumerate(group.scales):
            v = scale.degrees_of_freedom
            rng = stream(seed, f"{group.name}, scale {place}", block)
            chi_squared = 2.0 * rng.standard_gamma(v / 2.0, (1, x.shape[1]))
            x[list(scale.rows)] *= scale.of(chi_squared)
        if group.mean.any():
            x += group.mean[:, None]
    return out


def batches(
    problem: Problem, seed: int, *, block: int, trials: int
) -> Iterator[tuple[slice, Array]]:
    """Yield so many trials from a block on: their places, values (n_out, n) [SI].

    Several blocks are evaluated at once: fewer calls of functions, each of which finds
    its code and its objects pushed out of the cache by the drawing.
    """
    x = np.empty((problem.n_inputs, min(BATCH, ceil(trials / BLOCK)) * BLOCK))
    for start in range(0, trials, BATCH * BLOCK):
        columns = range(0, min(x.shape[1], trials - start), BLOCK)
        for column in columns:
            at = slice(column, column + BLOCK)
            draw(problem, seed, block + (start + column) // BLOCK, x[:, at])
        y = problem.evaluate(x[:, : len(columns) * BLOCK])[:, : trials - start]
        yield slice(start, start + y.shape[1]), y


def _draw_unit(group: Group, rng: np.random.Generator, out: Array) -> None:
    """Fill `out`, shape (n, BLOCK), with variates of unit standard uncertainty.

    Normal ones by numpy's own method. In a group with any other shape every input is
    the quantile of one uniform number, so that no input's shape moves another's draws.
    """
    if group.is_normal:
        rng.standard_normal(out=out)
        return
    rng.random(out=out)
    np.maximum(out, LEAST, out=out)
    for shape, row in zip(group.drawn, out, strict=True):
        row[:] = shape.quantile(row)


@contextmanager
def small_blocks() -> Iterator[None]:
    """Keep the linear algebra of small blocks on one core, and their memory here.

    Blocks are too small to share out: a second BLAS thread gains nothing on a quiet
    machine and waits for the first one, spinning, on a busy one (18 times slower
    measured). Cores are used by giving them blocks.

    What one block frees the next one needs. The C library of Linux gives freed memory
    back to the system, which zeroes it page by page for the next block, and that takes
    as long as the arithmetic: but not memory below twice the largest piece that was
    ever mapped and freed, so one of the largest that counts (32 MiB) is, untouched.
    """
    np.empty(KEPT, dtype=np.uint8)
    with _blas().limit(limits=1, user_api="blas"):
        yield


@cache
def _blas() -> ThreadpoolController:
    """Find the BLAS that numpy has loaded: once in a process, it takes a while."""
    return ThreadpoolController()


class WatchedExecutor(Executor):
    """An executor whose other end may go away without a word."""

    def fault(self) -> str:
        """Return why no result will ever come, for people; empty where one may."""
        raise NotImplementedError


class _Pool(ProcessPoolExecutor, WatchedExecutor):
    """Processes of this machine. One that is killed may leave half a result behind.

    Then the pool waits for the other half, which no one will write, and never sees that
    the worker died. Without workers, and with its own end of the pipe closed, it does.
    """

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ANN401 - as Executor has it
        """Give a task; a process that this starts never hears of Ctrl-C.

        It would end in a traceback while it loads, before it can ignore it.
        """
        if not hasattr(signal, "pthread_sigmask"):  # no POSIX system
            return super().submit(fn, *args, **kwargs)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().submit(fn, *args, **kwargs)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def fault(self) -> str:
        """Let the pool see that a worker died; it says so itself."""
        workers = list((self._processes or {}).values())
        if any(worker.exitcode is not None for worker in workers):
            for worker in workers:
                worker.kill()
            self._result_queue._writer.close()  # type: ignore[attr-defined]  # noqa: SLF001
        return ""


@contextmanager
def local_executor(workers: int) -> Iterator[Executor | None]:
    """Provide processes of this machine, or None where this one does the work itself.

    The processes ignore Ctrl-C, which the terminal sends to all of them: this one
    alone answers it, waits for the tasks under way (some 0.1 s) and leaves none. Should
    this one be killed, they end by themselves.
    """
    if workers == 1:
        yield None
        return
    pool = _Pool(
        workers,
        mp_context=get_context("spawn"),  # no copy of threads and locks of this one
        initializer=_begin_worker,
    )
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _begin_worker() -> None:
    """Leave Ctrl-C to the process that gives the tasks, and end when it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Wait for the end of the parent; no one is left then to take a result."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def in_order(
    work: Callable[[Task], Result],
    tasks: Iterable[Task],
    executor: Executor | None,
    *,
    ahead: int,
) -> Iterator[Result]:
    """Yield the result of every task in the order of the tasks, whoever does it.

    Without an executor this process does the work. The tasks may be endless: no more
    than `ahead` are given out before the first result is taken.

    Raises
    ------
    WorkerError
        A worker died, or the work cannot be sent to it.
    """
    if executor is None:
        yield from map(work, tasks)
        return
    source = iter(tasks)
    under_way: deque[Future[Result]] = deque()
    try:
        under_way.extend(executor.submit(work, task) for task in islice(source, ahead))
        while under_way:
            yield _result(under_way.popleft(), executor)
            under_way.extend(executor.submit(work, task) for task in islice(source, 1))
    except (BrokenExecutor, CancelledError):
        fault = executor.fault() if isinstance(executor, WatchedExecutor) else ""
        raise WorkerError(
            fault
            or "a worker died before its task was done, or its scheduler did; nothing "
            "was computed with what it left. A script that asks for workers needs its "
            "calls under `if __name__ == '__main__':`; else memory may have run out: "
            "use fewer"
        ) from None
    finally:
        for future in under_way:
            future.cancel()


def _result(future: Future[Result], executor: Executor) -> Result:
    """Return a result; say what to do where none will come."""
    watched = executor if isinstance(executor, WatchedExecutor) else None
    while True:
        try:
            return future.result(timeout=None if watched is None else HEARTBEAT)
        except (BrokenExecutor, CancelledError):
            raise
        except Exception as error:
            if isinstance(error, BudgetError):
                raise  # what the model itself has to say
            fault = "" if watched is None else watched.fault()
            if fault:
                raise WorkerError(fault) from None
            is_own = future.done() and future.exception() is error  # of the work
            if isinstance(error, TimeoutError) and not is_own:
                continue  # alive, and still at work, or done since the last look
            if "pickle" in str(error):
                raise WorkerError(
                    f"the model cannot be sent to other processes ({error}); define "
                    "its function at the top of a module, or use one worker"
                ) from error
            raise
