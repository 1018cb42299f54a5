"""A failing machine: the right exit code, whole files or none, and no traceback."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

import pytest
from command_line import call, surroundings

from budget.cli import app
from budget.resources import shipped

pytestmark = pytest.mark.skipif(os.name != "posix", reason="faults of POSIX systems")

NOBODY = 65_534  # user and group without rights
ADDRESS_SPACE = 500 << 20  # [bytes] libraries take 350 MB, 2e6 trials 384
PATIENCE = 60.0  # [s] before a test gives up on a process
BUDGET = (sys.executable, "-m", "budget")
LONG_RUN = ("analyze", "--method", "monte-carlo", "--trials", "300000000")
TWO_WORKERS = (*BUDGET, *LONG_RUN, "--workers", "2", "--json", "a.json")
GRADE = ("--requirement", "navigation-grade")
GUM = ("--method", "gum")
DEVICE = shipped("specs") / "devices" / "zhao-2019.yaml"

# Quick calls of every command that prints results, with the code of success.
PRINTING = {
    "analyze": ("analyze", "--no-validate"),
    "analyze json": ("analyze", "--no-validate", "--json", "-"),
    "analyze csv": ("analyze", "--no-validate", "--csv", "-"),
    "allocate": ("allocate", *GRADE, "--no-validate"),
    "allocate json": ("allocate", *GRADE, "--no-validate", "--json", "-"),
    "compare": ("compare", "zhao-2019", *GRADE, *GUM),
    "compare csv": ("compare", "zhao-2019", *GRADE, *GUM, "--csv", "-"),
    "devices": ("devices",),
    "devices json": ("devices", "--json", "-"),
    "paper": ("paper",),
    "validate": ("validate", DEVICE),
    "schema": ("schema", "device"),
    "diff": ("diff", "zhao-2019", "hg4930#A"),
    "check": ("check", "zhao-2019-eq4-nominal"),
    "help": ("--help",),
    "version": ("--version",),
}
# And of every command that writes files: the options that name them come last.
WRITING = {
    "analyze": ("analyze", "--no-validate", "--json", "a.json", "--csv", "a.csv"),
    "allocate": ("allocate", *GRADE, "--no-validate", "--json", "a.json"),
    "compare": ("compare", "zhao-2019", *GRADE, *GUM, "-o", "a.html"),
    "devices": ("devices", "--json", "a.json"),
    "paper": ("paper", "--csv", "a.csv", "-o", "a.html", "-o", "a.pdf"),
    "report": ("report", "--no-validate", "-o", "a.html"),
    "diff": ("diff", "zhao-2019", "hg4930#A", "--json", "a.json"),
}
ONE_EACH = ("analyze", "compare", "devices", "paper", "validate", "schema", "diff")
KNOWN = {
    command.name or command.callback.__name__ for command in app.registered_commands
}
NOT_MET = {"compare", "compare csv"}  # the paper's device does not meet that grade


def those_there(calls):
    """Return the calls whose command exists, by name."""
    return {
        name: call
        for name, call in calls.items()
        if call[0] in KNOWN or call[0].startswith("--")
    }


PRINTING, WRITING = those_there(PRINTING), those_there(WRITING)


def environment(**more):
    """Return the environment of a call; None takes a name away."""
    every = surroundings() | more
    return {name: text for name, text in every.items() if text is not None}


def run(*args, folder, streams="", before=None, user=None, **more):
    """Run a command in a folder; `streams` redirects."""
    words = [*BUDGET, *map(str, args)]
    if streams:
        words = ["bash", "-c", f'"$@" {streams}', "bash", *words]
    return subprocess.run(
        words,
        cwd=folder,
        env=environment(**more),
        capture_output=True,
        check=False,
        preexec_fn=before,
        user=user,
        group=user,
        timeout=PATIENCE,
    )


def said(outcome):
    """Return what stderr says, which is never a traceback."""
    text = outcome.stderr.decode(errors="replace")
    assert "Traceback" not in text, text
    assert "Exception ignored" not in text, text
    return text


def contents(folder):
    """Return names and bytes of all that is in a folder."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def assert_whole(path):
    """Assert that a written file goes to its own end."""
    data = path.read_bytes()
    if path.suffix == ".json":
        json.loads(data)
    elif path.suffix == ".html":
        assert data.rstrip().endswith(b"</html>")
    elif path.suffix == ".pdf":
        assert data.startswith(b"%PDF")
        assert data.rstrip().endswith(b"%%EOF")
    else:
        rows = data.decode().splitlines()
        assert data.endswith(b"\n")
        assert len(rows) > 1


# ---- streams ------------------------------------------------------------------------


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize("name", PRINTING)
def test_a_full_disk_behind_stdout(name, tmp_path):
    """Exit 2 and a message: what was printed did not arrive."""
    outcome = run(*PRINTING[name], folder=tmp_path, streams="> /dev/full")
    text = said(outcome)
    assert "standard output: the system refused: No space left on device" in text
    assert outcome.returncode == 2


@pytest.mark.parametrize("name", PRINTING)
def test_a_closed_stdout_is_an_output_that_is_not_wanted(name, tmp_path):
    """With stdout closed a command does its work, and returns its code."""
    outcome = run(*PRINTING[name], folder=tmp_path, streams=">&-")
    said(outcome)
    assert outcome.returncode == (1 if name in NOT_MET else 0)


@pytest.mark.parametrize(
    "name", those_there({n: PRINTING.get(n, "-") for n in ONE_EACH})
)
def test_no_terminal_and_no_streams_at_all(name, tmp_path):
    """All three streams closed, and no terminal to fall back on: the same code."""
    process = subprocess.run(
        ["bash", "-c", 'exec setsid -w "$@" <&- >&- 2>&-', "bash", *BUDGET]
        + [str(word) for word in PRINTING[name]],
        cwd=tmp_path,
        env=environment(),
        check=False,
        timeout=PATIENCE,
    )
    assert process.returncode == (1 if name in NOT_MET else 0)


def test_files_are_whole_where_all_streams_are_closed(tmp_path):
    """A file does not get the number of a closed stream, nor what is printed there."""
    outcome = run(
        *WRITING["paper"],
        folder=tmp_path,
        streams="<&- >&- 2>&-",
        SOURCE_DATE_EPOCH="0",
    )
    assert outcome.returncode == 0
    closed = contents(tmp_path)
    assert (
        run(*WRITING["paper"], folder=tmp_path, SOURCE_DATE_EPOCH="0").returncode == 0
    )
    assert contents(tmp_path) == closed
    assert sorted(closed) == ["a.csv", "a.html", "a.pdf"]


@pytest.mark.parametrize("name", PRINTING)
def test_a_reader_that_has_enough(name, tmp_path):
    """A pipe closed by its reader ends the command quietly, files or none."""
    words = [*BUDGET, *map(str, PRINTING[name])]
    with subprocess.Popen(
        words,
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        process.stdout.close()  # before anything is written
        text = process.stderr.read().decode()
    assert "Traceback" not in text
    assert "Exception ignored" not in text
    # By the signal itself, or with the code that shells give to it; help and version
    # are typer's own.
    quiet = {-signal.SIGPIPE, 141} | ({1} if name in {"help", "version"} else set())
    assert process.returncode in quiet


# ---- locales and terminals ----------------------------------------------------------

GERAET = "Ger\N{LATIN SMALL LETTER A WITH DIAERESIS}t"
FOREIGN = f"""name: {GERAET} \N{MICRO SIGN} \u6d4b\u8bd5
notes: \N{DOUBLE LOW-9 QUOTATION MARK}so\N{LEFT DOUBLE QUOTATION MARK} \U0001f6f0
gyro:
  errors:
    bias_repeatability: 1 \N{DEGREE SIGN}/h
    angle_random_walk: 0.1 deg/sqrt(h)
"""
LOCALES = {
    "C": dict(LANG="C", LC_ALL="C", PYTHONIOENCODING=None),
    "POSIX, bytes": dict(
        LC_ALL="POSIX",
        PYTHONCOERCECLOCALE="0",
        PYTHONUTF8="0",
        PYTHONIOENCODING=None,
    ),
    "ASCII": dict(LC_ALL="C", PYTHONIOENCODING="ascii"),
    "Latin-1": dict(PYTHONIOENCODING="latin-1"),
    "bare": dict(
        dict.fromkeys(("HOME", "USER", "LOGNAME", "LANG", "LC_ALL", "TERM")),
        PYTHONIOENCODING=None,
    ),
}
NAMED = {
    "analyze": ("analyze", "{}", "--no-validate"),
    "analyze json": ("analyze", "{}", "--no-validate", "--json", "-"),
    "analyze csv": ("analyze", "{}", "--no-validate", "--csv", "-"),
    "allocate": ("allocate", "{}", *GRADE, "--no-validate"),
    "compare": ("compare", "{}", *GRADE, *GUM),
    "compare json": ("compare", "{}", *GRADE, *GUM, "--json", "-"),
    "devices": ("devices", "{}"),
    "devices json": ("devices", "{}", "--json", "-"),
    "validate": ("validate", "{}"),
    "validate missing": ("validate", "\u6d4b.yaml"),
    "report": ("report", "{}", "--no-validate", "-o", "\u6d4b.html"),
}


@pytest.mark.parametrize("locale", LOCALES)
@pytest.mark.parametrize("name", NAMED)
def test_names_beyond_ascii_in_any_locale(name, locale, tmp_path):
    """A device and a file of foreign names: every command does its work."""
    file = f"{GERAET}.yaml"
    (tmp_path / file).write_text(FOREIGN, encoding="utf-8")
    words = [word.format(file) for word in NAMED[name]]
    outcome = run(*words, folder=tmp_path, **LOCALES[locale])
    said(outcome)
    wanted = {"validate missing": 2, "compare": 1, "compare json": 1}.get(name, 0)
    assert outcome.returncode == wanted, outcome.stderr.decode(errors="replace")
    if name.endswith("json"):
        encoding = "latin-1" if locale == "Latin-1" else "utf-8"
        document = json.loads(outcome.stdout.decode(encoding))
        text = json.dumps(document, ensure_ascii=False)
        assert GERAET in text
        assert "\\udc" not in json.dumps(document)  # no halves of bytes


def test_a_document_in_a_pipe_is_the_one_in_a_file(tmp_path):
    """In the locale C, stdout and the file get the same UTF-8 bytes."""
    (tmp_path / "d.yaml").write_text(FOREIGN, encoding="utf-8")
    call = ("analyze", "d.yaml", "--no-validate", "--json")
    piped = run(*call, "-", folder=tmp_path, **LOCALES["POSIX, bytes"])
    run(*call, "a.json", folder=tmp_path, **LOCALES["POSIX, bytes"])
    assert piped.stdout == (tmp_path / "a.json").read_bytes()
    assert "\u6d4b".encode() in piped.stdout


def test_a_file_name_that_is_no_text(tmp_path):
    """Bytes that are no UTF-8 in a file's name are shown as such, in valid JSON."""
    name = b"g\xff.yaml"
    try:
        Path(os.fsdecode(bytes(tmp_path) + b"/" + name)).write_text(
            FOREIGN, encoding="utf-8"
        )
    except OSError:
        pytest.skip("the file system takes no such names")
    outcome = subprocess.run(
        [*BUDGET, "analyze", name, "--no-validate", "--json", "a.json"],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        check=False,
    )
    said(outcome)
    assert outcome.returncode == 0
    inputs = json.loads((tmp_path / "a.json").read_bytes())["inputs"]
    assert "g\N{REPLACEMENT CHARACTER}.yaml" in json.dumps(inputs, ensure_ascii=False)


@pytest.mark.parametrize("name", WRITING)
def test_no_home_and_no_temporary_folder(name, tmp_path):
    """Caches and scratch files of libraries are not needed by any command."""
    nowhere = "/nonexistent"
    outcome = run(
        *WRITING[name],
        folder=tmp_path,
        USER=None,
        LOGNAME=None,
        **dict.fromkeys(
            ("HOME", "TMPDIR", "TEMP", "TMP", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"),
            nowhere,
        ),
        MPLCONFIGDIR=None,
    )
    said(outcome)
    assert outcome.returncode in {0, 1}
    written = list(tmp_path.iterdir())
    assert written
    for path in written:
        assert_whole(path)


TABLES = [name for name in PRINTING if not name.endswith(("json", "csv"))]
ODD_WIDTHS = ("1", "0", "-5", "wide", "100000", "\N{SUPERSCRIPT TWO}")


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        *((name, "40") for name in TABLES),
        *(("analyze", columns) for columns in ODD_WIDTHS),
    ],
)
def test_terminals_of_any_width(name, columns, tmp_path):
    """Whatever COLUMNS says, tables are printed and nothing fails."""
    outcome = run(*PRINTING[name], folder=tmp_path, COLUMNS=columns)
    said(outcome)
    assert outcome.returncode == (1 if name in NOT_MET else 0)
    assert outcome.stdout


# ---- disks and folders --------------------------------------------------------------


@pytest.mark.parametrize("name", WRITING)
def test_a_limit_on_the_size_of_files(name, tmp_path):
    """A disk that takes 2 kB of a file: exit 2, the old files whole, no scraps."""
    for path in ("a.json", "a.csv", "a.html", "a.pdf"):
        (tmp_path / path).write_text(f"old {path}", encoding="utf-8")
    before = contents(tmp_path)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))

    outcome = run(*WRITING[name], folder=tmp_path, before=limit)
    assert "the system refused: File too large" in said(outcome)
    assert outcome.returncode == 2
    assert contents(tmp_path) == before


@contextmanager
def small_disk(folder, options):
    """Mount a file system of its own on a folder; skip where that is not allowed."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    if (
        not shutil.which("mount")
        or subprocess.run(mount, capture_output=True, check=False).returncode
    ):
        pytest.skip("mounting is not allowed here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("name", WRITING)
def test_a_full_disk(name, tmp_path):
    """A disk of 8 kB: exit 2, the message names the file, old files are whole."""
    with small_disk(tmp_path / "disk", "size=8k") as disk:
        (disk / "a.json").write_text("old", encoding="utf-8")
        before = contents(disk)
        outcome = run(*WRITING[name], folder=disk)
        text = said(outcome)
        assert contents(disk) == before
    assert "the system refused: No space left on device" in text
    assert "nothing was written" in text
    assert outcome.returncode == 2


@pytest.mark.parametrize("name", ["analyze", "report"])
def test_a_read_only_disk(name, tmp_path):
    """Exit 2, and the folder is named."""
    with small_disk(tmp_path / "disk", "size=8k,ro") as disk:
        outcome = run(*WRITING[name], folder=disk)
        text = said(outcome)
        assert contents(disk) == {}
    assert "cannot be written" in text or "the system refused: Read-only" in text
    assert outcome.returncode == 2


@pytest.mark.skipif(os.name != "posix" or os.getuid() != 0, reason="needs root")
def test_a_user_without_rights(tmp_path):
    """A folder of another user: exit 2 and what to do; so for a file not readable."""
    for folder in (tmp_path, *tmp_path.parents):
        if folder.stat().st_mode & 0o001 == 0:
            if folder.stat().st_uid or "pytest" not in str(folder):
                pytest.skip("the folder of the tests is closed to other users")
            folder.chmod(0o711)
    secret = tmp_path / "secret.yaml"
    secret.write_text(FOREIGN, encoding="utf-8")
    secret.chmod(0o600)
    tmp_path.chmod(0o755)
    try:
        run("--version", folder=tmp_path, user=NOBODY).check_returncode()
    except (PermissionError, subprocess.CalledProcessError):
        pytest.skip("other users cannot start this Python")

    written = run(
        "analyze", "--no-validate", "--json", "a.json", folder=tmp_path, user=NOBODY
    )
    assert "cannot be written" in said(written)
    read = run("validate", "secret.yaml", folder=tmp_path, user=NOBODY)
    assert "secret.yaml:1:1: " in said(read)
    assert (written.returncode, read.returncode) == (2, 2)
    assert [path.name for path in tmp_path.iterdir()] == ["secret.yaml"]


def test_a_file_where_a_folder_should_be(tmp_path):
    """Exit 2, and nothing is touched."""
    (tmp_path / "file").write_text("old", encoding="utf-8")
    outcome = run(
        *("analyze", "--no-validate", "--json", "file/a.json"), folder=tmp_path
    )
    assert "expected one that can be written" in said(outcome)
    assert outcome.returncode == 2
    assert contents(tmp_path) == {"file": b"old"}


def test_a_folder_that_is_gone(tmp_path):
    """Started in a folder that has been removed, a command still works or says so."""
    gone = tmp_path / "gone"
    gone.mkdir()
    outcome = subprocess.run(
        ["bash", "-c", 'rmdir "$PWD"; exec "$@"', "bash", *BUDGET, "devices"],
        cwd=gone,
        env=environment(),
        capture_output=True,
        check=False,
    )
    said(outcome)
    assert outcome.returncode in {0, 2}


# ---- two runs, clocks, interrupts ---------------------------------------------------


def test_two_runs_that_write_one_file(tmp_path):
    """Whoever looks finds one whole file, of the one or the other, at any moment."""
    call = (*BUDGET, "analyze", "--no-validate")
    result = tmp_path / "a.json"
    with ExitStack() as stack:
        runs = [
            stack.enter_context(
                subprocess.Popen(
                    [*call, "--coverage", p, "--json", "a.json"],
                    cwd=tmp_path,
                    env=environment(),
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                )
            )
            for p in ("0.9", "0.99") * 2
        ]
        found = set()
        while any(process.poll() is None for process in runs):
            if result.exists():
                found.add(json.loads(result.read_bytes())["settings"]["coverage"])
    assert [process.returncode for process in runs] == [0] * 4
    found.add(json.loads(result.read_bytes())["settings"]["coverage"])
    assert found <= {0.9, 0.99}
    assert contents(tmp_path).keys() == {"a.json"}


def test_files_from_the_future(tmp_path):
    """A clock set back: inputs and outputs that are newer than now do no harm."""
    shutil.copy(DEVICE, tmp_path / "d.yaml")
    old = tmp_path / "a.json"
    old.write_text("{}", encoding="utf-8")
    for path in tmp_path.iterdir():
        os.utime(path, (4e9, 4e9))  # in the year 2096
    call = ("analyze", "d.yaml", "--no-validate", "--json", "a.json")
    outcome = run(*call, folder=tmp_path)
    said(outcome)
    assert outcome.returncode == 0
    first = old.read_bytes()
    assert run(*call, folder=tmp_path).returncode == 0
    assert old.read_bytes() == first
    assert json.loads(first)["schema"] == "budget/1"


def test_a_clock_that_runs_backwards(monkeypatch, tmp_path):
    """The wall clock is not asked how long something takes."""
    times = iter(range(10**9, 0, -1000))
    monkeypatch.setattr("time.time", lambda: float(next(times)))
    result = tmp_path / "a.json"
    outcome = call("analyze", "--json", result)
    assert outcome.code == 0, outcome.err
    assert_whole(result)


@pytest.mark.parametrize("epoch", ["0", "4102444800", "-1", "253402300800", "now", ""])
def test_any_source_date_epoch(epoch, tmp_path):
    """A date that can be is taken, another is exit 2 before anything is computed."""
    outcome = run(
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
def start(tmp_path):
    """Return a way to start long runs, each in a process group that is gone after."""
    started = []

    def begin(*words):
        process = subprocess.Popen(
            [*words],
            cwd=tmp_path,
            env=environment(),
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


def children(process):
    """Return the process ids of the children of a process we started."""
    path = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [int(number) for number in path.read_text(encoding="ascii").split()]


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


def workers_of(process):
    """Wait until both workers are at work, and return their process ids."""
    begun = monotonic()
    while monotonic() - begun < PATIENCE:
        found = []
        for number in children(process):
            line = Path(f"/proc/{number}/cmdline").read_bytes()
            if b"spawn_main" in line:
                found.append(number)
        if len(found) == 2:
            sleep(2.0)  # they import numpy before they work
            return found
        sleep(0.05)
    raise AssertionError("no workers")


@needs_proc
@pytest.mark.parametrize(
    ("number", "code", "word"),
    [
        (signal.SIGINT, 130, "interrupted"),
        (signal.SIGTERM, 143, "ended on request"),
        (signal.SIGHUP, 129, "hung up"),
    ],
)
def test_a_signal_to_the_main_process(number, code, word, start, tmp_path):
    """Interrupted, ended or hung up: its code, no worker and no file is left."""
    process = start(*TWO_WORKERS)
    workers_of(process)
    process.send_signal(number)
    _, talk = process.communicate(timeout=PATIENCE)
    assert process.returncode == code
    assert f"{word}; nothing was written" in talk.decode()
    assert "Traceback" not in talk.decode()
    assert is_gone(process.pid)
    assert contents(tmp_path) == {}


@needs_proc
def test_workers_end_with_a_main_process_that_was_killed(start, tmp_path):
    """Killed outright, the main process leaves no worker behind."""
    process = start(*TWO_WORKERS)
    workers_of(process)
    process.kill()
    process.wait(timeout=PATIENCE)
    assert is_gone(process.pid)
    assert contents(tmp_path) == {}


@needs_proc
def test_a_killed_worker(start, tmp_path):
    """A worker that is killed: exit 2, what to do, no process and no file left."""
    process = start(*TWO_WORKERS)
    os.kill(workers_of(process)[0], signal.SIGKILL)
    _, talk = process.communicate(timeout=PATIENCE)
    text = talk.decode()
    assert "a worker died before its task was done" in text
    assert "Traceback" not in text
    assert process.returncode == 2
    assert is_gone(process.pid)
    assert contents(tmp_path) == {}


def test_nohup_keeps_its_meaning(start):
    """Where a hang-up is ignored when the command starts, it stays ignored."""
    process = start("bash", "-c", 'trap "" HUP; exec "$@"', "bash", *BUDGET, *LONG_RUN)
    sleep(4.0)  # well into the trials
    process.send_signal(signal.SIGHUP)
    sleep(1.0)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 143


def test_too_little_memory(tmp_path):
    """Memory that runs out is exit 2 and words, at whatever point it does."""

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))

    words = (
        "analyze",
        "--method",
        "monte-carlo",
        "--trials",
        "2000000",
        "--json",
        "a.json",
    )
    small = run(
        *("analyze", "--no-validate"),
        folder=tmp_path,
        before=limit,
        OPENBLAS_NUM_THREADS="1",
    )
    if small.returncode:
        pytest.skip("the libraries alone take more here")
    outcome = run(*words, folder=tmp_path, before=limit, OPENBLAS_NUM_THREADS="1")
    text = said(outcome)
    assert outcome.returncode == 2
    assert "not enough memory" in text
    assert contents(tmp_path) == {}
