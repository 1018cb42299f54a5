"""A progress bar on stderr for whatever takes longer than a second."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PATIENCE = 1.0  # [s] before a bar appears


@contextmanager
def progress(task: str) -> Iterator[Callable[[int, int], None]]:
    """Provide a callback (done, total) that shows a bar once the work takes long.

    Nothing is shown where stderr is no terminal.
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
    row = bar.add_task(task, total=None)

    def show(done: int, total: int) -> None:
        if not bar.live.is_started:
            if monotonic() - begun < PATIENCE or not sys.stderr.isatty():
                return
            bar.start()
        bar.update(row, completed=done, total=total)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
