"""What every computing command sets up around its work: workers, progress, talk."""

from __future__ import annotations

from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.cli.progress import progress

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Executor


@dataclass(frozen=True, kw_only=True)
class Workshop:
    """Who does the work, and how it is talked about."""

    executor: Executor | None
    workers: int
    progress: Callable[[str, int, int], None]


@contextmanager
def computing(*, workers: int, cluster: str | None) -> Iterator[Workshop]:
    """Provide workers, local or on a cluster, and a progress bar."""
    from budget.methods.cluster import connect

    place = nullcontext() if cluster is None else connect(cluster)
    with place as found, progress() as show:
        yield Workshop(
            executor=None if found is None else found.executor,
            workers=workers if found is None else found.workers,
            progress=show,
        )
