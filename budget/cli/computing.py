"""Long work: its workers or cluster, and what it says while it runs."""

from __future__ import annotations

import sys
from contextlib import contextmanager, nullcontext
from time import monotonic
from typing import TYPE_CHECKING

from budget.cli.streams import say

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.progress import TaskID

    from budget.studies.progress import Engine


@contextmanager
def computing(*, workers: int, cluster: str | None) -> Iterator[Engine]:
    """Provide workers, local or on a cluster, and a progress bar."""
    from budget.methods.cluster import connect
    from budget.studies.progress import Engine

    place = nullcontext() if cluster is None else connect(cluster)
    with place as found, progress() as show:
        yield Engine(
            executor=None if found is None else found.executor,
            workers=workers if found is None else found.workers,
            progress=show,
            talk=say,
        )


PATIENCE = 1.0  # [s] before a bar appears


@contextmanager
def progress() -> Iterator[Callable[[str, int, int], None]]:
    """Provide a callback (what, done, total) that shows a bar once work takes long.

    The bar says what is being done and starts again for each task; tasks that are done
    stay above it. Nothing is shown where stderr is no terminal.
    """
    from rich.console import Console
    from rich.progress import Progress, TimeRemainingColumn

    bar = Progress(
        *Progress.get_default_columns()[:-1],
        TimeRemainingColumn(),
        console=Console(file=sys.stderr),
        transient=True,
    )
    begun = monotonic()
    rows: dict[str, TaskID] = {}

    def show(what: str, done: int, total: int) -> None:
        if what not in rows:
            for row in bar.tasks:  # adaptive work ends before all its steps are done
                bar.update(row.id, completed=row.total)
            rows[what] = bar.add_task(what, total=None)
        bar.update(rows[what], completed=done, total=total)
        if (
            not bar.live.is_started
            and monotonic() - begun >= PATIENCE
            and sys.stderr.isatty()
        ):
            bar.start()

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
