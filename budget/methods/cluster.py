"""The same work on an existing Dask cluster, through the executor interface.

A cluster runs what it is sent: connect only to one that you trust.
"""

from __future__ import annotations

import platform
import socket
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.errors import CallError, WorkerError
from budget.methods.execution import RemoteExecutor
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Executor, Future

CONNECT_TIMEOUT = 10.0  # [s]


class DaskExecutor(RemoteExecutor):
    """Dask's own executor, and whether its scheduler still listens."""

    def __init__(self, executor: Executor, address: str) -> None:
        """Keep the executor of a client and the scheduler's address."""
        self._executor = executor
        self._host, _, port = address.rpartition("://")[2].rpartition(":")
        self._port = int(port)

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ANN401 - as Executor has it
        """Give a task to the cluster."""
        return self._executor.submit(fn, *args, **kwargs)

    def is_alive(self) -> bool:
        """Whether the scheduler's port takes a connection."""
        try:
            with socket.create_connection((self._host, self._port), CONNECT_TIMEOUT):
                return True
        except OSError:
            return False


@dataclass(frozen=True, kw_only=True)
class Cluster:
    """A connection: who does the work, and how many they are."""

    executor: DaskExecutor
    workers: int


@contextmanager
def connect(address: str) -> Iterator[Cluster]:
    """Connect to a Dask scheduler and see that its workers compute as we do.

    Parameters
    ----------
    address : str
        As tcp://host:port.

    Raises
    ------
    CallError
        The extra `dask` is not installed.
    WorkerError
        No scheduler answers, it has no workers, or a worker has other versions.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.comm.core import CommClosedError
    except ImportError:
        raise CallError(
            "a cluster needs the extra 'dask': pip install 'sins-budget[dask]'"
        ) from None
    try:
        client = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise WorkerError(
            f"no Dask scheduler answers at {address!r} within {CONNECT_TIMEOUT:.0f} s "
            f"({error}); see that it runs and that the address is its own, "
            "as tcp://host:port"
        ) from None
    try:
        threads = client.nthreads()
        if not threads:
            raise WorkerError(
                f"the scheduler at {address!r} has no workers; start some "
                f"with `dask worker {address}`"
            )
        _check_versions(client.run(versions))
        # Workers retry nothing: a task that killed one would kill the next.
        yield Cluster(
            executor=DaskExecutor(client.get_executor(retries=0, pure=False), address),
            workers=sum(threads.values()),
        )
    except (KilledWorker, CommClosedError) as error:
        raise WorkerError(
            f"the cluster at {address!r} lost the work it was given ({error}); nothing "
            "was computed with what is left. See its workers' logs"
        ) from None
    finally:
        client.close(timeout=CONNECT_TIMEOUT)


def versions() -> dict[str, str]:
    """Return what must be equal for two machines to give the same bits."""
    return {
        "budget": __version__,
        "numpy": np.__version__,
        "python": ".".join(platform.python_version_tuple()[:2]),
    }


def _check_versions(found: dict[str, dict[str, str]]) -> None:
    """Refuse workers that compute with other versions than ours."""
    ours = versions()
    faults = [
        f"{worker} has {name} {theirs.get(name)}, here it is {version}"
        for worker, theirs in sorted(found.items())
        for name, version in ours.items()
        if theirs.get(name) != version
    ]
    if faults:
        raise WorkerError(
            "the cluster would not give the same numbers: "
            + "; ".join(faults)
            + ". Install the same versions there"
        )
