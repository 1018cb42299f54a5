"""Execution of long work: workers, cluster, progress."""

from __future__ import annotations

import sys
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from time import monotonic
from typing import TYPE_CHECKING

from budget.cli.streams import talk

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    from rich.progress import Progress, TaskID

    from budget.methods.cluster import Cluster
    from budget.settings import Engine


@contextmanager
def computing(engine: Engine) -> Iterator[Engine]:
    """Provide workers, local or on a cluster, and a progress bar."""
    with _place(engine.cluster) as found, progress() as show:
        place = {} if found is None else vars(found)
        yield replace(engine, progress=show, talk=talk, **place)


def _place(cluster: str | None) -> AbstractContextManager[Cluster | None]:
    """Return where the work is done: on a cluster, or here."""
    if cluster is None:
        return nullcontext()
    from budget.methods.cluster import connect

    return connect(cluster)


PATIENCE = 1.0  # [s] before a bar appears


@contextmanager
def progress() -> Iterator[Callable[[str, int, int], None]]:
    """Provide a callback (what, done, total) that shows a bar once work takes long.

    The bar says what is being done and starts again for each task; tasks that are done
    stay above it. Nothing is shown where stderr is no terminal.
    """
    begun = monotonic()
    tasks: dict[str, tuple[int, int]] = {}
    rows: dict[str, TaskID] = {}
    bar: Progress | None = None

    def show(what: str, done: int, total: int) -> None:
        nonlocal bar
        if what not in tasks:  # adaptive work ends before all its steps are done
            tasks.update({task: (most, most) for task, (_, most) in tasks.items()})
        tasks[what] = (done, total)
        if bar is None and monotonic() - begun >= PATIENCE and sys.stderr.isatty():
            bar = _started_bar()
        if bar is None:
            return
        for task, (made, most) in tasks.items():
            if task not in rows:
                rows[task] = bar.add_task(task, total=None)
            bar.update(rows[task], completed=made, total=most)

    try:
        yield show
    finally:
        if bar is not None:
            bar.stop()


def _started_bar() -> Progress:
    """Return a bar that shows on stderr."""
    from rich.console import Console
    from rich.progress import Progress, TimeRemainingColumn

    bar = Progress(
        *Progress.get_default_columns()[:-1],
        TimeRemainingColumn(),
        console=Console(file=sys.stderr),
        transient=True,
    )
    bar.start()
    return bar
