"""Execution on an existing Dask cluster, through the executor interface.

A cluster runs what it is sent: connect only to one that you trust.
"""

from __future__ import annotations

import asyncio
import platform
import re
import socket
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.util import find_spec
from threading import Thread
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.errors import CallError, WorkerError
from budget.methods.execution import WatchedExecutor
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Executor, Future

REACH_TIMEOUT = 4.0  # [s]; whoever mistyped an address learns it within 5
CONNECT_TIMEOUT = 10.0  # [s] of a scheduler that is known to be one
LOOKS = 3  # a heartbeat apart, that find no worker until none is said to be left
# A name, an IPv4 address, or an IPv6 address in brackets; then the port.
ADDRESS = re.compile(
    r"(?:\[(?P<six>[0-9A-Fa-f:.]+(?:%\w+)?)\]|(?P<host>[\w.-]+)):(?P<port>[0-9]{1,5})"
)
MOST_PORT = 65535
SCHEMES = ("tcp", "tls")  # what Dask speaks without further libraries
EXPECTED = "expected tcp://host:port, tls://host:port or tcp://[IPv6]:port"
# What Dask reads, from the environment or its own files, where it speaks TLS.
TLS_SETTINGS = ", ".join(
    f"DASK_DISTRIBUTED__COMM__TLS__{name}"
    for name in ("CA_FILE", "CLIENT__CERT", "CLIENT__KEY")
)


@dataclass(frozen=True, kw_only=True)
class Address:
    """Where a scheduler listens."""

    scheme: str
    host: str  # an IPv6 address without its brackets
    port: int

    def __str__(self) -> str:
        """Write it as Dask takes it."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}://{host}:{self.port}"


def read_address(text: str) -> Address:
    """Read an address, as 'tcp://host:port'; without a scheme it is tcp.

    Raises
    ------
    CallError
        It is none.
    """
    scheme, separator, rest = text.strip().rpartition("://")
    if separator and scheme not in SCHEMES:
        raise CallError(
            f"cluster {text!r}: {scheme!r} is no protocol that is spoken here, "
            f"{EXPECTED}; start the scheduler with one of these"
        )
    found = ADDRESS.fullmatch(rest)
    if found is None or not 0 < int(found["port"]) <= MOST_PORT:
        has_port = re.search(r"[^:]:[^:]*$", re.sub(r"^\[.*\]", "x", rest))
        fault = "is no address" if has_port else "has no port"
        if rest.count(":") > 1 and not rest.startswith("["):
            fault = "is an IPv6 address without its brackets, or none at all"
        raise CallError(
            f"cluster {text!r}: {fault}, {EXPECTED}; the scheduler prints its own when "
            "it starts, mostly with port 8786"
        )
    host = found["six"] or found["host"]
    return Address(scheme=scheme or "tcp", host=host, port=int(found["port"]))


class DaskExecutor(WatchedExecutor):
    """Dask's own executor, and whether anyone is left to do its work."""

    def __init__(self, client: Any, address: Address) -> None:  # noqa: ANN401 - of an extra
        """Keep a client, its executor and the scheduler's address."""
        self._client = client
        # Workers retry nothing: a task that killed one would kill the next.
        self._executor: Executor = client.get_executor(retries=0, pure=False)
        self._address = address
        self._looks_at_no_one = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ANN401 - as Executor has it
        """Give a task to the cluster."""
        return self._executor.submit(fn, *args, **kwargs)

    def fault(self) -> str:
        """Return that the scheduler, or the last worker, went away.

        A worker that its nanny starts anew is missed for a moment: no one is left when
        several looks find no one.
        """
        place = (self._address.host, self._address.port)
        try:
            with socket.create_connection(place, CONNECT_TIMEOUT):
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
            f"no workers are left at '{self._address}': the last one went away before "
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

    At tcp://host:port, or by TLS, with Dask's own settings, at tls://host:port.

    Raises
    ------
    CallError
        The extra `dask` is not installed, or the address is none.
    WorkerError
        No scheduler answers, it has no workers, or a worker has other versions.
    """
    where = read_address(address)
    if find_spec("distributed") is None:
        raise CallError(
            "a cluster needs the extra 'dask': pip install 'sins-budget[dask]'"
        )
    if why := _why_out_of_reach(where):
        raise WorkerError(
            f"no Dask scheduler answers at {address!r} within {REACH_TIMEOUT:.0f} s "
            f"({why}); see that it runs and that the address is its own, {EXPECTED}"
        )
    if why := _why_no_scheduler(where):
        advice = "see that it is a scheduler's port, and that it speaks no TLS"
        if where.scheme == "tls":
            advice = (
                "see that it is the port of a scheduler that speaks TLS, and that Dask "
                f"is told its certificates ({TLS_SETTINGS})"
            )
        raise WorkerError(
            f"what listens at {address!r} does not answer as a Dask scheduler by "
            f"{where.scheme} ({why}); {advice}"
        )
    from distributed import Client

    try:
        client = Client(str(where), timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise WorkerError(
            f"the scheduler at {address!r} lets nobody in within "
            f"{CONNECT_TIMEOUT:.0f} s ({error}); see its log"
        ) from None
    try:
        threads = _threads(client, address)
        _check_versions(client.run(versions))
        yield Cluster(
            executor=DaskExecutor(client, where), workers=sum(threads.values())
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


def _why_out_of_reach(address: Address) -> str:
    """Say why no connection to that place is taken; '' where one is."""

    def reach() -> None:
        with socket.create_connection((address.host, address.port), REACH_TIMEOUT):
            pass

    return _fault_of(reach)


def _why_no_scheduler(address: Address) -> str:
    """Say why what listens there is no scheduler; '' where Dask's handshake is done.

    By a connection alone: a Client that does not come about tries on until the end.
    """
    from distributed.comm.core import connect as shake_hands
    from distributed.security import Security

    async def meet() -> None:
        # What a stranger sends may be no message of Dask's: the fault is told below.
        asyncio.get_running_loop().set_exception_handler(lambda *_: None)
        arguments = Security().get_connection_args("client")
        comm = await shake_hands(str(address), timeout=REACH_TIMEOUT, **arguments)
        await comm.close()

    return _fault_of(lambda: asyncio.run(meet()))


def _fault_of(attempt: Callable[[], None]) -> str:
    """Return what is wrong with a connection, in time; '' where nothing is.

    In a thread of its own: nothing else ends the search for a name, and an event loop
    may run in this one.
    """
    found: list[str] = []

    def run() -> None:
        try:
            attempt()
        except (OSError, ValueError, TypeError, RuntimeError, MemoryError) as error:
            found.append(str(error) or type(error).__name__)
        else:
            found.append("")

    thread = Thread(target=run, daemon=True)
    thread.start()
    thread.join(REACH_TIMEOUT + 0.5)
    return found[0] if found else "no answer in time"


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
