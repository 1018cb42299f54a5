"""Signals, killed processes, two runs at once, and clocks that are wrong."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
from command_line import call
from failing import (
    BUDGET,
    DEVICE,
    PATIENCE,
    assert_whole,
    children,
    contents,
    environment,
    run,
    run_here,
    said,
)
from places import put
from reading import assert_says

from budget.cli.options import processors

pytestmark = pytest.mark.skipif(os.name != "posix", reason="faults of POSIX systems")

LONG_RUN = ("analyze", "--method", "monte-carlo", "--trials", "100000000")
# Says by a file in which block of trials it is: nobody else can see where one process
# is in its work.
TOLD = """
import os, runpy, sys
from budget.methods import execution

stream = execution.stream


def told(seed, name, block):
    with open(os.environ["AT_WORK"], "w") as place:
        place.write(str(block))
    return stream(seed, name, block)


execution.stream = told
runpy.run_module("budget", run_name="__main__", alter_sys=True)
"""
TELLING = (sys.executable, "-c", TOLD, *LONG_RUN)
RESULT = 10_000  # bytes that a worker has written once it has handed over a result
TWO_WORKERS = (*BUDGET, *LONG_RUN, "--workers", "2", "--json", "a.json")


# Runs that write one file, several times each, forked from a process that has imported
# what they need.
RACE = """
import os, sys
from budget.cli import main


def call(*words):
    sys.argv = ["budget", "analyze", "--no-validate", *words]
    try:
        main()
    except SystemExit as end:
        return end.code or 0


coverages = sys.argv[1:]
call()
runs = []
for p in coverages:
    runs.append(os.fork())
    if not runs[-1]:
        os._exit(max(call("--coverage", p, "--json", "a.json") for _ in range(2)))
sys.exit(max(os.waitstatus_to_exitcode(os.waitpid(run, 0)[1]) for run in runs))
"""


@pytest.mark.slow
def test_two_runs_that_write_one_file(tmp_path):
    """Whoever looks finds one whole file, of the one or the other, at any moment."""
    result = tmp_path / "a.json"
    found = set()
    with subprocess.Popen(
        [sys.executable, "-c", RACE, *("0.9", "0.99") * 2],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        while not result.exists():  # the imports are not worth looking at
            assert process.poll() is None
            sleep(0.001)
        while process.poll() is None:
            found.add(json.loads(result.read_bytes())["settings"]["coverage"])
    assert process.returncode == 0
    found.add(json.loads(result.read_bytes())["settings"]["coverage"])
    assert found <= {0.9, 0.99}
    assert contents(tmp_path).keys() == {"a.json"}


@pytest.mark.slow
def test_files_from_the_future(tmp_path):
    """A clock set back: inputs and outputs that are newer than now do no harm."""
    shutil.copy(DEVICE, tmp_path / "d.yaml")
    old = put(tmp_path / "a.json", "{}")
    for path in tmp_path.iterdir():
        os.utime(path, (4e9, 4e9))  # in the year 2096
    call = ("analyze", "d.yaml", "--no-validate", "--json", "a.json")
    outcome = run(*call, folder=tmp_path)
    said(outcome)
    assert outcome.returncode == 0
    first = old.read_bytes()
    assert run_here(*call, folder=tmp_path).returncode == 0
    assert old.read_bytes() == first
    assert json.loads(first)["schema"] == "budget/1"


@pytest.mark.slow
def test_a_clock_that_runs_backwards(monkeypatch, tmp_path):
    """The wall clock is not asked how long something takes."""
    times = iter(range(10**9, 0, -1000))
    monkeypatch.setattr("time.time", lambda: float(next(times)))
    result = tmp_path / "a.json"
    call("analyze", "--json", result, code=0)
    assert_whole(result)


@pytest.mark.slow
@pytest.mark.parametrize("epoch", ["0", "4102444800", "-1", "253402300800", "now", ""])
def test_any_source_date_epoch(epoch, tmp_path):
    """A date that can be is taken, another is exit 2 before anything is computed."""
    start = run if epoch == "now" else run_here
    outcome = start(
        "analyze",
        "--no-validate",
        "--json",
        "a.json",
        folder=tmp_path,
        SOURCE_DATE_EPOCH=epoch,
    )
    text = said(outcome)
    if outcome.returncode:
        assert "SOURCE_DATE_EPOCH" in text
        assert contents(tmp_path) == {}
    assert outcome.returncode == (0 if epoch in {"0", "4102444800", "-1"} else 2)


def listen():
    """Take every signal as usual, though these tests may run in the background."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


@pytest.fixture
def at_work(tmp_path_factory):
    """Return the file by which a long run says where it is."""
    return tmp_path_factory.mktemp("at_work") / "block"


def wait_for_block(process, at_work, block):
    """Wait until a run that tells is in a block of trials, and return in which."""
    begun = monotonic()
    while monotonic() - begun < PATIENCE:
        text = at_work.read_text(encoding="ascii") if at_work.exists() else ""
        if text and int(text) >= block:
            return int(text)
        assert process.poll() is None, "it ended before"
        sleep(0.02)
    raise AssertionError("no work")


@pytest.fixture
def start(tmp_path, at_work):
    """Return a way to start long runs, each in a process group that is gone after."""
    started = []

    def begin(*words):
        process = subprocess.Popen(
            [*words],
            cwd=tmp_path,
            env=environment(AT_WORK=str(at_work)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=listen,  # noqa: PLW1509 - no threads here
        )
        started.append(process)
        return process

    yield begin
    for process in started:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # a group that we made
        process.communicate(timeout=PATIENCE)


def is_gone(group):
    """Return whether all processes of a group end before patience does."""
    begun = monotonic()
    while monotonic() - begun < PATIENCE:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        sleep(0.05)
    return False


needs_proc = pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="needs Linux' /proc"
)


def written_by(number):
    """Return how many bytes a process has written, pipes included."""
    text = Path(f"/proc/{number}/io").read_text(encoding="ascii")
    return int(text.partition("wchar: ")[2].split()[0])


def workers_of(process):
    """Wait until both workers have done some of the work, and return their ids."""
    if processors() < 2:
        pytest.skip("one processor, so two workers are cut to one")
    begun = monotonic()
    while monotonic() - begun < PATIENCE:
        found = []
        for number in children(process):
            line = Path(f"/proc/{number}/cmdline").read_bytes()
            if b"spawn_main" in line:
                found.append(number)
        if len(found) == 2 and min(map(written_by, found)) > RESULT:
            return found
        sleep(0.05)
    raise AssertionError("no workers")


@pytest.mark.slow
@needs_proc
@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "ended on request")],
)
def test_a_signal_to_the_main_process(number, code, word, start, tmp_path):
    """Interrupted or ended: its code, no worker and no file is left."""
    process = start(*TWO_WORKERS)
    workers_of(process)
    process.send_signal(number)
    _, talk = process.communicate(timeout=PATIENCE)
    assert process.returncode == code
    assert f"{word}; nothing was written" in talk.decode()
    assert "Traceback" not in talk.decode()
    assert is_gone(process.pid)
    assert contents(tmp_path) == {}


def ends_by_ctrl_c(process, folder):
    """Interrupt all processes at once: 130 in words, and nothing is left."""
    os.killpg(process.pid, signal.SIGINT)
    _, talk = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "interrupted" in talk.decode()
    assert "Traceback" not in talk.decode()
    assert is_gone(process.pid)
    assert contents(folder) == {}


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_leaves_no_process_and_no_file(workers, start, tmp_path, at_work):
    """Interrupted as a terminal does, all of them at once: 130, and nothing is left."""
    begun = TWO_WORKERS if workers == "2" else (*TELLING, "--json", "a.json")
    process = start(*begun)
    if workers == "2":
        workers_of(process)
    else:
        wait_for_block(process, at_work, 1)
    ends_by_ctrl_c(process, tmp_path)


# Raises a signal while a module is loaded: the rest of the start-up is still to come.
LOADING = """
import os, runpy, sys


class Watch:
    def find_spec(self, name, *_):
        if name == sys.argv[-1]:
            del sys.meta_path[0]
            os.kill(os.getpid(), int(os.environ["SIGNAL"]))


sys.meta_path.insert(0, Watch())
runpy.run_module("budget", run_name="__main__", alter_sys=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "code", "word", "module"),
    [
        (signal.SIGINT, 130, b"interrupted", "budget.cli"),
        (signal.SIGTERM, 143, b"ended on request", "typer"),
        (signal.SIGHUP, 129, b"hung up", "budget.report.rendering"),
        (signal.SIGINT, 130, b"interrupted", "budget.report.rendering"),
    ],
)
def test_a_signal_while_the_command_is_loaded(number, code, word, module):
    """Its code and its words, as later."""
    outcome = subprocess.run(
        [sys.executable, "-c", LOADING, module],
        env=environment(SIGNAL=str(int(number))),
        capture_output=True,
        check=False,
        timeout=PATIENCE,
    )
    assert outcome.returncode == code
    assert outcome.stderr == word + b"; nothing was written\n"


@pytest.mark.slow
@needs_proc
@pytest.mark.parametrize("seed", range(2))
def test_ctrl_c_while_workers_are_loaded(seed, start, tmp_path):
    """The workers, which the terminal interrupts too, say nothing of it."""
    process = start(*TWO_WORKERS)
    while len(children(process)) < 2:
        sleep(0.001)
    sleep(np.random.default_rng(seed).uniform(0.0, 0.3))
    ends_by_ctrl_c(process, tmp_path)


@pytest.mark.slow
@needs_proc
def test_workers_end_with_a_main_process_that_was_killed(start, tmp_path):
    """Killed outright, the main process leaves no worker behind."""
    process = start(*TWO_WORKERS)
    workers_of(process)
    process.kill()
    process.wait(timeout=PATIENCE)
    assert is_gone(process.pid)
    assert contents(tmp_path) == {}


@pytest.mark.slow
@needs_proc
def test_a_killed_worker(start, tmp_path):
    """A worker that is killed: exit 2, what to do, no process and no file left."""
    process = start(*TWO_WORKERS)
    os.kill(workers_of(process)[0], signal.SIGKILL)
    _, talk = process.communicate(timeout=PATIENCE)
    text = talk.decode()
    assert_says(text, "worker died")
    assert "Traceback" not in text
    assert process.returncode == 2
    assert is_gone(process.pid)
    assert contents(tmp_path) == {}


@pytest.mark.slow
def test_nohup_keeps_its_meaning(start, at_work):
    """Where a hang-up is ignored when the command starts, it stays ignored."""
    process = start("bash", "-c", 'trap "" HUP; exec "$@"', "bash", *TELLING)
    block = wait_for_block(process, at_work, 1)
    process.send_signal(signal.SIGHUP)
    wait_for_block(process, at_work, block + 5)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 143
