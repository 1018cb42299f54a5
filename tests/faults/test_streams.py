"""Streams and terminals as they may be found: closed, full, narrow, of any locale."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path

import pytest
from failing import (
    BUDGET,
    FOREIGN,
    GERAET,
    GRADE,
    GUM,
    NOT_MET,
    PATIENCE,
    PRINTING,
    WRITING,
    assert_whole,
    contents,
    environment,
    run,
    run_rehearsed,
    run_warm,
    said,
)
from forked import NO_READER
from reading import assert_says

from budget.cli import app

pytestmark = pytest.mark.skipif(os.name != "posix", reason="faults of POSIX systems")


def runner(name, *, cold, warm=run_warm):
    """Return what runs a call: for some names from a cold start, imports included."""
    return run if name in cold else warm


# All tests of one command follow each other, on one worker if there are several, so
# that what it computes is computed once.
every_command = pytest.mark.parametrize("name", PRINTING, scope="module")


def test_every_command_is_called_here():
    """A command that is added is tried with every fault too."""
    called = {words[0] for words in (*PRINTING.values(), *WRITING.values())}
    known = {
        command.name or command.callback.__name__ for command in app.registered_commands
    }
    assert called - {"--help", "--version"} == known


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@every_command
@pytest.mark.slow
def test_a_full_disk_behind_stdout(name, tmp_path):
    """Exit 2 and a message: what was printed did not arrive."""
    start = runner(name, cold={"analyze", "help"}, warm=run_rehearsed)
    outcome = start(*PRINTING[name], folder=tmp_path, streams="> /dev/full")
    text = said(outcome)
    assert_says(text, "standard output:", "No space left on device")
    assert outcome.returncode == 2


@every_command
def test_a_closed_stdout_is_an_output_that_is_not_wanted(name, tmp_path):
    """With stdout closed a command does its work, and returns its code."""
    start = runner(name, cold={"compare", "version"}, warm=run_rehearsed)
    outcome = start(*PRINTING[name], folder=tmp_path, streams=">&-")
    said(outcome)
    assert outcome.returncode == (1 if name in NOT_MET else 0)


TALK = {
    "no file": ("validate", "no-such.yaml"),
    "no option": ("analyze", "--no-such"),
    "no command": ("no-such",),
    "no device": ("analyze", "--no-validate"),
    "not met": PRINTING["compare"],
}


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize(
    ("name", "encoding"),
    [
        *((name, "utf-8") for name in TALK),
        ("no option", "ascii"),
        ("no device", "ascii"),
    ],
)
def test_a_full_disk_behind_stderr_changes_no_code(name, encoding, tmp_path):
    """What is said is lost, what is done is done, and the code is the same."""
    usual = run_warm(*TALK[name], folder=tmp_path)
    start = runner((name, encoding), cold={("no option", "ascii")})
    outcome = start(
        *TALK[name],
        folder=tmp_path,
        streams="2> /dev/full",
        PYTHONIOENCODING=encoding,
    )
    assert outcome.returncode == usual.returncode
    if encoding == "utf-8":
        assert outcome.stdout == usual.stdout


@every_command
def test_no_terminal_and_no_streams_at_all(name, tmp_path):
    """All three streams closed, and no terminal to fall back on: the same code."""
    outcome = run_rehearsed(*PRINTING[name], folder=tmp_path, streams="<&- >&- 2>&-")
    assert outcome.returncode == (1 if name in NOT_MET else 0)


FILES = ("a.csv", "a.html", "a.pdf")


@pytest.mark.slow
def test_files_are_whole_where_all_streams_are_closed(tmp_path):
    """A file does not get the number of a closed stream, nor what is printed there.

    From a cold start, imports included, and without a terminal.
    """
    words = (*PRINTING["compare"], "--csv", FILES[0], "-o", FILES[1], "-o", FILES[2])
    closed = 'exec setsid -w "$@" <&- >&- 2>&-'
    process = subprocess.run(
        ["bash", "-c", closed, "bash", *BUDGET, *words],
        cwd=tmp_path,
        env=environment(SOURCE_DATE_EPOCH="0"),
        check=False,
        timeout=PATIENCE,
    )
    assert process.returncode == 1
    found = contents(tmp_path)
    usual = run_warm(*words, folder=tmp_path, SOURCE_DATE_EPOCH="0")
    assert usual.returncode == 1
    assert contents(tmp_path) == found
    assert sorted(found) == sorted(FILES)


@every_command
def test_a_reader_that_has_enough(name, tmp_path):
    """A pipe closed by its reader ends the command quietly, files or none."""
    start = runner(name, cold={"devices"}, warm=run_rehearsed)
    outcome = start(*PRINTING[name], folder=tmp_path, streams=NO_READER)
    said(outcome)
    # By the signal itself, or with the code that shells give to it.
    assert outcome.returncode in {-signal.SIGPIPE, 141}


# ---- locales and terminals ----------------------------------------------------------

LOCALES = {
    "C": dict(LANG="C", LC_ALL="C", PYTHONIOENCODING=None),
    "POSIX, bytes": dict(
        LC_ALL="POSIX",
        PYTHONCOERCECLOCALE="0",
        PYTHONUTF8="0",
        PYTHONIOENCODING=None,
    ),
    "ASCII": dict(LANG="C", LC_ALL="C", PYTHONIOENCODING="ascii"),
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
    "station": (
        *("station", "{}", "--requirement", "catalogue-edge"),
        *("-o", "\u6d4b\u53f0.html"),
    ),
    "mission": (
        *("mission", "{}", "adxl357", "--mission", "outage-10-s"),
        *("--no-validate", "-o", "\u6d4b\u7a0b.html"),
    ),
    "export": ("export", "{}", "adxl357", "--to", "ros", "--rate", "100"),
    "compare": ("compare", "{}", *GRADE, *GUM),
    "compare json": ("compare", "{}", *GRADE, *GUM, "--json", "-"),
    "decide": ("decide", "catalogue-edge", "{}"),
    "devices": ("devices", "{}"),
    "devices json": ("devices", "{}", "--json", "-"),
    "validate": ("validate", "{}"),
    "validate missing": ("validate", "\u6d4b.yaml"),
    "report": ("report", "{}", "--no-validate", "-o", "\u6d4b.html"),
}


# A table, documents, an export, an error and a page: what each locale may get wrong.
EACH = ("analyze", "analyze json", "export", "validate missing", "station")


@pytest.mark.slow
@pytest.mark.parametrize("locale", LOCALES)
def test_names_beyond_ascii_in_any_locale(locale, tmp_path):
    """A device and a file of foreign names: every command does its work.

    All of them where names are bytes, one of each kind elsewhere.
    """
    file = f"{GERAET}.yaml"
    (tmp_path / file).write_text(FOREIGN, encoding="utf-8")
    for name in NAMED if locale == "POSIX, bytes" else EACH:
        words = [word.format(file) for word in NAMED[name]]
        start = runner(name, cold={"analyze json"})
        outcome = start(*words, folder=tmp_path, **LOCALES[locale])
        said(outcome)
        wanted = dict.fromkeys(("compare", "compare json", "allocate", "decide"), 1)
        wanted = ({"validate missing": 2} | wanted).get(
            name, 0
        )  # it lacks lines: nothing meets without conditions
        assert outcome.returncode == wanted, (name, outcome.stderr)
        if name.endswith("json"):
            encoding = "latin-1" if locale == "Latin-1" else "utf-8"
            document = json.loads(outcome.stdout.decode(encoding))
            text = json.dumps(document, ensure_ascii=False)
            assert GERAET in text, name
            assert "\\udc" not in json.dumps(document), name  # no halves of bytes


@pytest.mark.slow
def test_a_document_in_a_pipe_is_the_one_in_a_file(tmp_path):
    """In the locale C, stdout and the file get the same UTF-8 bytes."""
    (tmp_path / "d.yaml").write_text(FOREIGN, encoding="utf-8")
    call = ("analyze", "d.yaml", "--no-validate", "--json")
    piped = run(*call, "-", folder=tmp_path, **LOCALES["POSIX, bytes"])
    run_warm(*call, "a.json", folder=tmp_path, **LOCALES["POSIX, bytes"])
    assert piped.stdout == (tmp_path / "a.json").read_bytes()
    assert "\u6d4b".encode() in piped.stdout


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["new", "analyze", "decide", "export", "paper"])
def test_no_home_and_no_temporary_folder(name, tmp_path):
    """Caches and scratch files of libraries are not needed by any command."""
    nowhere = "/nonexistent"
    start = runner(name, cold={"new"})
    outcome = start(
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


@every_command
def test_a_terminal_that_is_narrow(name, tmp_path):
    """Of 40 columns: everything is printed and nothing fails."""
    start = runner(name, cold={"check"}, warm=run_rehearsed)
    outcome = start(*PRINTING[name], folder=tmp_path, COLUMNS="40")
    said(outcome)
    assert outcome.returncode == (1 if name in NOT_MET else 0)
    assert outcome.stdout


ODD_WIDTHS = ("1", "0", "-5", "wide", "100000", "\N{SUPERSCRIPT TWO}")


@pytest.mark.parametrize("columns", ODD_WIDTHS)
def test_terminals_of_any_width(columns, tmp_path):
    """Whatever COLUMNS says, tables are printed and nothing fails."""
    outcome = run_rehearsed(*PRINTING["analyze"], folder=tmp_path, COLUMNS=columns)
    said(outcome)
    assert outcome.returncode == 0
    assert outcome.stdout
