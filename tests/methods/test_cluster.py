"""A Dask cluster on loopback: the same bits, and clear words when it fails."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import warnings
from contextlib import contextmanager
from functools import cache
from multiprocessing import forkserver
from time import sleep

import numpy as np
import pytest
from builders import paper_gyro, procedure
from numpy.testing import assert_array_equal

from budget.calibration.problem import calibration_problem
from budget.errors import CallError, WorkerError
from budget.methods.cluster import (
    _check_versions,
    connect,
    read_address,
    versions,
)
from budget.methods.monte_carlo import sample
from budget.methods.sobol import sobol
from budget.problem import Group, Output, Problem

dask = pytest.importorskip("dask", reason="the extra 'dask' is absent")
distributed = pytest.importorskip("distributed", reason="the extra 'dask' is absent")
pytestmark = pytest.mark.filterwarnings("ignore")  # dask's own, none of ours

PATIENCE = 180  # [s], beyond which a test has failed; it takes some 10
NO_ONE = "tcp://127.0.0.1:9"  # the discard port


# What a worker imports, a second or two of each: here forked from one that has. That
# the work arrives where nothing is imported is asked of the lone worker and by TLS.
FORKED = {
    "distributed.worker.profile.enabled": False,
    "distributed.worker.multiprocessing-method": "forkserver",
}
IMPORTED = ("distributed.nanny", "distributed.worker", "scipy.stats")
IMPORTED += tuple(f"budget.{name}" for name in ("calibration.problem", "methods.sobol"))


@cache
def start_server():
    """Start the process that forks workers, once all that they need is imported."""
    forkserver.set_forkserver_preload(list(IMPORTED))
    forkserver.ensure_running()


@contextmanager
def started(workers):
    """Give a cluster of so many worker processes on loopback."""
    start_server()
    with (
        warnings.catch_warnings(),
        dask.config.set(FORKED),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=None,
            silence_logs=60,
        ) as running,
    ):
        warnings.simplefilter("ignore")
        yield running


@pytest.fixture
def cluster():
    """Return a cluster of two worker processes on loopback."""
    with started(2) as running:
        yield running


def problem():
    """Return the built-in gyro calibration."""
    return calibration_problem((paper_gyro(),), procedure())


@pytest.mark.slow
def test_cluster_gives_the_same_bits(cluster):
    """Monte Carlo, fixed and adaptive, and Sobol' indices equal one process' bits."""
    with connect(cluster.scheduler_address) as c:
        shared = {"executor": c.executor, "workers": c.workers}
        for trials in (100_000, None):
            here = sample(problem(), trials=trials, seed=1)
            there = sample(problem(), trials=trials, seed=1, **shared)
            assert_array_equal(here.covariance, there.covariance)
            assert_array_equal(here.interval, there.interval)
            assert here.trials == there.trials
        here, there = (
            sobol(problem(), samples=64),
            sobol(problem(), samples=64, **shared),
        )
        assert_array_equal(here.total.value, there.total.value)


@pytest.mark.slow
def test_a_worker_that_is_started_anew_is_not_missed():
    """One look that finds no worker is no fault, three are; a worker resets them."""
    with started(1) as cluster, connect(cluster.scheduler_address) as c:
        seen = iter([{}, {}, {"a": 1}, {}, {}, {}])
        c.executor._client.sync = lambda *_args, **_more: next(seen)  # noqa: SLF001
        faults = [bool(c.executor.fault()) for _ in range(6)]
        del c.executor._client.sync  # noqa: SLF001
    assert faults == [False] * 5 + [True]


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("tcp://host:8786", "tcp://host:8786"),
        ("host.example:1", "tcp://host.example:1"),
        ("tls://10.0.0.1:65535", "tls://10.0.0.1:65535"),
        ("tcp://[::1]:8786", "tcp://[::1]:8786"),
        ("tls://[fe80::1%eth0]:8786", "tls://[fe80::1%eth0]:8786"),
    ],
)
def test_an_address_is_read(text, read):
    """Without a scheme it is tcp; an IPv6 address stands in brackets."""
    assert str(read_address(text)) == read


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ucx://host:8786", "'ucx' is no protocol"),
        ("http://host:8786", "'http' is no protocol"),
        ("tcp://host", "has no port"),
        ("host", "has no port"),
        ("tcp://[::1]", "has no port"),
        ("tcp://::1:8786", "without its brackets"),
        ("tcp://host:99999", "is no address"),
        ("tcp://host:0", "is no address"),
        ("tcp://host:port", "is no address"),
        ("tcp://a b:1", "is no address"),
        ("tcp://", "has no port"),
        ("", "has no port"),
    ],
)
def test_what_is_no_address_is_refused_before_anything_is_tried(text, words):
    """In words that say what is allowed; on the command line that is exit code 2."""
    with pytest.raises(CallError, match=words) as caught, connect(text):
        pass
    assert "tcp://host:port" in str(caught.value)


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_a_port_of_something_else_is_an_error_for_people(scheme, monkeypatch):
    """A listener that is no scheduler is told apart from no listener."""
    monkeypatch.setattr("budget.methods.cluster.REACH_TIMEOUT", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        place = f"{scheme}://127.0.0.1:{silent.getsockname()[1]}"
        words = f"does not answer as a Dask scheduler by {scheme}"
        with pytest.raises(WorkerError, match=words), connect(place):
            pass


def test_a_name_of_no_machine_is_an_error_for_people():
    """A name that cannot be looked up is said as such."""
    words = r"no Dask scheduler answers at 'tcp://no-such-host\.invalid:8786'"
    place = "tcp://no-such-host.invalid:8786"
    with pytest.raises(WorkerError, match=words), connect(place):
        pass


@pytest.fixture(scope="module")
def certificate(tmp_path_factory):
    """Return Dask's settings for TLS, with a certificate made here."""
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("openssl is not installed: no certificate can be made")
    folder = tmp_path_factory.mktemp("tls")
    key, cert = folder / "key.pem", folder / "cert.pem"
    request = "req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost"
    subprocess.run(
        [openssl, *request.split(), "-keyout", str(key), "-out", str(cert)],
        check=True,
        capture_output=True,
    )
    told = {"ca-file": cert, "client.cert": cert, "client.key": key}
    for role in ("scheduler", "worker"):
        told |= {f"{role}.cert": cert, f"{role}.key": key}
    return {f"distributed.comm.tls.{name}": str(file) for name, file in told.items()}


@pytest.mark.slow
def test_a_cluster_by_tls_gives_the_same_bits(certificate):
    """With the certificate all is as by tcp; without it nobody gets in."""
    with dask.config.set(certificate):
        running = distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            protocol="tls",
            security=distributed.Security(),
            host="127.0.0.1",
            dashboard_address=None,
            silence_logs=60,
        )
    with running:
        address = running.scheduler_address
        assert address.startswith("tls://")
        here = sample(problem(), trials=50_000, seed=1)
        with dask.config.set(certificate), connect(address) as c:
            there = sample(problem(), trials=50_000, seed=1, executor=c.executor)
        assert_array_equal(here.covariance, there.covariance)
        words = "is told its certificates .DASK_DISTRIBUTED__COMM__TLS__CA_FILE"
        with pytest.raises(WorkerError, match=words), connect(address):
            pass
        plain = address.replace("tls", "tcp")
        with pytest.raises(WorkerError, match="speaks no TLS"), connect(plain):
            pass


def test_no_scheduler_is_an_error_for_people():
    """An address where nobody listens raises WorkerError with the address."""
    words = r"no Dask scheduler answers.*127\.0\.0\.1:9"
    with pytest.raises(WorkerError, match=words), connect(NO_ONE):
        pass


def test_other_versions_are_refused():
    """A worker with another numpy is named with both versions."""
    theirs = {**versions(), "numpy": "1.0.0"}
    with pytest.raises(WorkerError, match=r"worker-a has numpy 1\.0\.0, here it is"):
        _check_versions({"worker-a": theirs, "worker-b": versions()})


def fall(x):
    """Kill the worker that evaluates this."""
    os.kill(os.getpid(), signal.SIGKILL)
    return x


@pytest.mark.slow
def test_a_killed_worker_is_an_error_for_people(cluster):
    """A task that kills every worker it is given to raises WorkerError."""
    cluster.scheduler.allowed_failures = 1  # of 3: a worker takes long to start anew
    deadly = Problem(
        groups=(Group.independent("x", u=1.0),),
        outputs=(Output(name="y"),),
        function=fall,
    )
    with pytest.raises(WorkerError), connect(cluster.scheduler_address) as c:
        sample(deadly, trials=10_000, executor=c.executor, workers=c.workers)


@pytest.mark.slow
def test_a_dead_scheduler_is_an_error_for_people():
    """A scheduler that goes away in the middle raises WorkerError, no wrong answer."""
    with started(1) as cluster:

        def kill(done, _):
            if done > 0:
                cluster.close()

        with pytest.raises(WorkerError), connect(cluster.scheduler_address) as c:
            sample(
                problem(),
                trials=20_000_000,
                executor=c.executor,
                workers=c.workers,
                progress=kill,
            )


@pytest.mark.slow
def test_a_worker_killed_in_the_middle_still_gives_the_right_answer(cluster):
    """With one of two workers killed the other finishes: same bits, or an error."""
    here = sample(problem(), trials=200_000, seed=1)
    victim = next(iter(cluster.workers.values())).pid
    with connect(cluster.scheduler_address) as c:
        killed = []

        def kill(done, _):
            if done > 50_000 and not killed:
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)

        try:
            there = sample(
                problem(),
                trials=200_000,
                seed=1,
                executor=c.executor,
                workers=c.workers,
                progress=kill,
            )
        except WorkerError:
            return  # clear words are allowed, wrong numbers are not
        assert killed
        assert_array_equal(here.covariance, there.covariance)
        assert_array_equal(np.asarray(here.interval), np.asarray(there.interval))


class NoOneLeft(BaseException):
    """The guard of a test that would wait for ever."""


@contextmanager
def patience(seconds):
    """Raise NoOneLeft in the main thread after that time: a guard, no measurement."""

    def give_up(*_):
        raise NoOneLeft

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture
def lone_worker():
    """Return address of a scheduler and process of its only worker, without a nanny."""
    with distributed.LocalCluster(
        n_workers=0, host="127.0.0.1", dashboard_address=None, silence_logs=60
    ) as running:
        address = running.scheduler_address
        worker = subprocess.Popen(
            [
                *(sys.executable, "-m", "distributed.cli.dask_worker", address),
                *("--nthreads", "1", "--no-nanny", "--no-dashboard"),
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            with distributed.Client(address, set_as_default=False) as client:
                client.wait_for_workers(1, timeout=PATIENCE)
            yield address, worker
        finally:
            worker.kill()
            worker.wait()


@pytest.mark.slow
def test_the_last_worker_killed_is_an_error_for_people(lone_worker):
    """With no workers left the run ends with WorkerError that says so."""
    address, worker = lone_worker

    def kill(done, _):
        if done > 0 and worker.poll() is None:
            worker.kill()
            worker.wait()

    with (
        patience(PATIENCE),
        pytest.raises(WorkerError, match="no workers are left"),
        connect(address) as c,
    ):
        sample(
            problem(),
            trials=20_000_000,
            executor=c.executor,
            workers=c.workers,
            progress=kill,
        )


@pytest.mark.slow
def test_the_command_without_workers_left_ends_with_2(lone_worker):
    """`budget analyze --cluster` prints the error, no traceback, and exits with 2."""
    address, worker = lone_worker
    command = subprocess.Popen(
        [
            *(sys.executable, "-m", "budget", "analyze", "--cluster", address),
            *("--method", "monte-carlo", "--trials", "100000000"),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        with distributed.Client(address, set_as_default=False) as client:
            while not any(client.processing().values()):  # it works for the command
                assert command.poll() is None
                sleep(0.1)
        worker.kill()
        _, talk = command.communicate(timeout=PATIENCE)
    finally:
        command.kill()
    assert command.returncode == 2
    assert "no workers are left" in talk
    assert "Traceback" not in talk


@pytest.mark.slow
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_the_command_whose_scheduler_dies_says_that_alone(end):
    """No log of another library stands before the words, and none after them."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    dask = (sys.executable, "-m")
    far = ("--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    near = (address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
    scheduler = subprocess.Popen(
        [*dask, "distributed.cli.dask_scheduler", *far], **quiet
    )
    worker = subprocess.Popen([*dask, "distributed.cli.dask_worker", *near], **quiet)
    started = [scheduler, worker]
    try:
        with distributed.Client(address, timeout=PATIENCE, set_as_default=False) as own:
            own.wait_for_workers(1, timeout=PATIENCE)
            run = ("budget", "analyze", "zhao-2019", "--cluster", address)
            command = subprocess.Popen(
                [*dask, *run, "--method", "monte-carlo", "--trials", "100000000"],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            )
            started.append(command)
            while not any(own.processing().values()):  # it works for the command
                assert command.poll() is None
                sleep(0.1)
        scheduler.send_signal(end)
        _, talk = command.communicate(timeout=PATIENCE)
    finally:
        for process in started:
            process.kill()
            process.wait()
    assert command.returncode == 2
    (line,) = talk.splitlines()
    assert line.startswith("the cluster's scheduler went away")
