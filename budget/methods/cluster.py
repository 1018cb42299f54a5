"""The same work on an existing Dask cluster, through the executor interface.

A cluster runs what it is sent: connect only to one that you trust.
"""

from __future__ import annotations

import platform
import socket
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
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
LOOKS = 3  # a heartbeat apart, that find no worker until none is said to be left


class DaskExecutor(RemoteExecutor):
    """Dask's own executor, and whether anyone is left to do its work."""

    def __init__(self, client: Any, address: str) -> None:  # noqa: ANN401 - of an extra
        """Keep a client, its executor and the scheduler's address."""
        self._client = client
        # Workers retry nothing: a task that killed one would kill the next.
        self._executor: Executor = client.get_executor(retries=0, pure=False)
        self._address = address
        self._host, _, port = address.rpartition("://")[2].rpartition(":")
        self._port = int(port)
        self._looks_at_no_one = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ANN401 - as Executor has it
        """Give a task to the cluster."""
        return self._executor.submit(fn, *args, **kwargs)

    def fault(self) -> str:
        """Return that the scheduler, or the last worker, went away.

        A worker that its nanny starts anew is missed for a moment: no one is left when
        several looks find no one.
        """
        try:
            with socket.create_connection((self._host, self._port), CONNECT_TIMEOUT):
                pass
            threads = self._client.sync(
                self._client.scheduler.ncores,
                workers=None,
                callback_timeout=CONNECT_TIMEOUT,
            )
        except Exception as error:
            if not _is_of_the_cluster(error):
                raise
            return (
                "the cluster's scheduler went away before the work was done; "
                "nothing was computed with what it left. Start it and run again"
            )
        self._looks_at_no_one = 0 if threads else self._looks_at_no_one + 1
        if self._looks_at_no_one < LOOKS:
            return ""
        return (
            f"no workers are left at {self._address!r}: the last one went away before "
            "the work was done, and nothing was computed with what it left. Start "
            f"some with `dask worker {self._address}` and run again; if they ran out "
            "of memory, fewer threads each need less"
        )


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
        from distributed import Client
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
        threads = _threads(client, address)
        _check_versions(client.run(versions))
        yield Cluster(
            executor=DaskExecutor(client, address), workers=sum(threads.values())
        )
    except Exception as error:
        if not _is_of_the_cluster(error):
            raise
        raise WorkerError(
            f"the cluster at {address!r} lost the work it was given ({error}); nothing "
            "was computed with what is left. See its workers' logs"
        ) from None
    finally:
        with suppress(Exception):  # of a scheduler that is gone; all has been said
            client.close(timeout=CONNECT_TIMEOUT)


def _threads(client: Any, address: str) -> dict[str, int]:  # noqa: ANN401 - of an extra
    """Return the threads of every worker; there must be one."""
    found: dict[str, int] = client.nthreads()
    if not found:
        raise WorkerError(
            f"the scheduler at {address!r} has no workers; start some "
            f"with `dask worker {address}`"
        )
    return found


def _is_of_the_cluster(error: Exception) -> bool:
    """Whether an error tells of Dask and its connections, not of the work it does."""
    package = type(error).__module__.partition(".")[0]
    return package in {"dask", "distributed", "tornado"} or isinstance(
        error, (ConnectionError, TimeoutError, CancelledError)
    )


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
