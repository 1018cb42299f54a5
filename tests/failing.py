"""Calls of every command in a child of its own, for a machine that fails them."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import chdir
from pathlib import Path

from command_line import call, surroundings
from forked import NO_READER, run_forked
from places import TESTS

from budget.resources import shipped

# [s] before a test gives up on a process that hangs: on no machine does it decide what
# takes seconds.
PATIENCE = 600.0
BUDGET = (sys.executable, "-m", "budget")
GRADE = ("--requirement", "navigation-grade")
GUM = ("--method", "gum")
DEVICE = shipped("specs") / "devices" / "zhao-2019.yaml"

# Quick calls of every command that prints results, with the code of success.
LOG = str(TESTS / "data" / "static.csv")
RUN = str(TESTS / "data" / "run.csv")
RESULTS = (str(TESTS / "data" / "history"),)
TEST = ("--procedure", "zhao-2019", "--device", "zhao-2019")
# A result of `calibrate RUN --procedure zhao-2019 --json`, by its scatter.
UNIT = (
    *("zhao-2019", "--procedure", "zhao-2019"),
    *("--measured", str(TESTS / "data" / "measured.json")),
)
PRINTING = {
    "analyze": ("analyze", "--no-validate", *GRADE),
    "analyze full": ("analyze", "--no-validate", "--full"),
    "analyze json": ("analyze", "--no-validate", "--json", "-"),
    "analyze csv": ("analyze", "--no-validate", "--csv", "-"),
    "allocate": ("allocate", *GRADE, "--no-validate"),
    "allocate json": ("allocate", *GRADE, "--no-validate", "--json", "-"),
    "compare": ("compare", "zhao-2019", *GRADE, *GUM),
    "compare csv": ("compare", "zhao-2019", *GRADE, *GUM, "--csv", "-"),
    "compare catalogue": (
        *("compare", "--catalogue", "--kind", "IMU", "--grade", "navigation"),
        *("--requirement", "catalogue-edge", *GUM),
    ),
    "decide": ("decide", "catalogue-edge", "zhao-2019"),
    "devices": ("devices",),
    "devices of a kind": ("devices", "--kind", "gyro", "--grade", "tactical"),
    "devices json": ("devices", "--json", "-"),
    "characterise": ("characterise", LOG),
    "calibrate": ("calibrate", RUN, *TEST),
    "history": ("history", *RESULTS),
    "simulate": ("simulate", "hg4930#A", "--static", "1 min", "-o", "-"),
    "paper": ("paper",),
    "validate": ("validate", DEVICE),
    "schema": ("schema", "device"),
    "diff": ("diff", "hg4930#A", "hg4930#C"),
    "check": ("check", "zhao-2019-eq4-nominal"),
    "station": ("station", "zhao-2019", "--requirement", "tactical-grade"),
    "mission": ("mission", "--mission", "outage-10-s", "--no-validate"),
    "mission json": (
        *("mission", "--mission", "outage-10-s", "--no-validate", "--json", "-"),
    ),
    "analyze measured": ("analyze", *UNIT, "--no-validate"),
    "mission measured": ("mission", *UNIT, "--mission", "bench", "--no-validate"),
    "compare measured": ("compare", *UNIT, *GRADE, *GUM),
    "export": ("export", "hg4930#A", "--to", "gtsam"),
    "export json": ("export", "hg4930#A", "--to", "gtsam", "--json", "-"),
    "new": ("new", "-"),
    "help": ("--help",),
    "version": ("--version",),
}
# And of every command that writes files: the options that name them come last.
WRITING = {
    "analyze": ("analyze", "--no-validate", "--json", "a.json", "--csv", "a.csv"),
    "allocate": (
        *("allocate", *GRADE, "--no-validate", "--json", "a.json"),
        *("-o", "a.html"),
    ),
    "check": (
        *("check", "zhao-2019-eq4-nominal", "--json", "a.json"),
        *("-o", "a.html"),
    ),
    "compare": ("compare", "zhao-2019", *GRADE, *GUM, "-o", "a.html"),
    "decide": ("decide", "catalogue-edge", "zhao-2019", "-o", "a.html"),
    "devices": ("devices", "--json", "a.json"),
    "characterise": (
        *("characterise", LOG, "--json", "a.json", "--csv", "a.csv"),
        *("-o", "a.html", "-o", "a.yaml"),
    ),
    "calibrate": (
        *("calibrate", RUN, *TEST, "--json", "a.json", "--csv", "a.csv"),
        *("-o", "a.html"),
    ),
    "history": (
        *("history", *RESULTS, "--json", "a.json", "--csv", "a.csv"),
        *("-o", "a.html"),
    ),
    "simulate": (
        *("simulate", "hg4930#A", "--static", "1 min"),
        *("--truth", "a.yaml", "-o", "a.csv"),
    ),
    "paper": ("paper", "--csv", "a.csv", "-o", "a.html", "-o", "a.pdf"),
    "report": ("report", "adxl357", "--no-validate", "-o", "a.html"),
    "diff": ("diff", "hg4930#A", "hg4930#C", "--json", "a.json"),
    "station": (
        *("station", "zhao-2019", "--requirement", "tactical-grade"),
        *("--json", "a.json", "--write", "a.yaml", "-o", "a.html"),
    ),
    "mission": (
        *("mission", "--mission", "outage-10-s", "--no-validate"),
        *("--json", "a.json", "--csv", "a.csv", "-o", "a.html"),
    ),
    "new": ("new", "--force", "--line", "gyro.bias_stability=1 deg/h", "a.yaml"),
    "export measured": (
        *("export", *UNIT, "--to", "gtsam", "--residual", "--rate", "200"),
        *("--json", "a.json", "-o", "a.py"),
    ),
    "export": (
        *("export", "hg4930#A", "--to", "gtsam", "--residual"),
        *("--json", "a.json", "--csv", "a.csv", "-o", "a.yaml"),
    ),
}

# The paper's device does not meet that grade.
NOT_MET = {"compare", "compare csv", "compare measured"}


def environment(**more):
    """Return the environment of a call; None takes a name away."""
    every = surroundings() | more
    return {name: text for name, text in every.items() if text is not None}


def children(process):
    """Return the process ids of a process' children."""
    path = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [int(number) for number in path.read_text(encoding="ascii").split()]


def run(*args, folder, streams="", before=None, **more):
    """Run a command in a folder; `streams` redirects."""
    words = [*BUDGET, *map(str, args)]
    if streams == NO_READER:
        return _run_without_reader(words, folder, environment(**more))
    if streams:
        words = ["bash", "-c", f'"$@" {streams}', "bash", *words]
    return subprocess.run(
        words,
        cwd=folder,
        env=environment(**more),
        capture_output=True,
        check=False,
        preexec_fn=before,
        timeout=PATIENCE,
    )


def _run_without_reader(words, folder, variables):
    """Run a command whose stdout is a pipe that is closed before it writes."""
    with subprocess.Popen(
        words,
        cwd=folder,
        env=variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        process.stdout.close()
        err = process.stderr.read()
    return subprocess.CompletedProcess(words, process.returncode, b"", err)


def run_warm(*args, folder, streams="", rehearsed=False, **more):
    """Run a command as `run` does, in a child that has imported everything."""
    return run_forked(
        [str(word) for word in args],
        folder=folder,
        streams=streams,
        environment=environment(**more),
        patience=PATIENCE,
        rehearsed=rehearsed,
    )


def run_rehearsed(*args, folder, streams="", **more):
    """Run a command as `run_warm` does, its numbers computed once for all its runs."""
    return run_warm(*args, folder=folder, streams=streams, rehearsed=True, **more)


def run_here(*args, folder, **more):
    """Run a command in a folder, in this process, which saves the start of another."""
    with chdir(folder):
        outcome = call(*args, **more)
    return subprocess.CompletedProcess(
        args, outcome.code, outcome.out.encode(), outcome.err.encode()
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


GERAET = "Ger\N{LATIN SMALL LETTER A WITH DIAERESIS}t"
FOREIGN = f"""name: {GERAET} \N{MICRO SIGN} \u6d4b\u8bd5
notes: \N{DOUBLE LOW-9 QUOTATION MARK}so\N{LEFT DOUBLE QUOTATION MARK} \U0001f6f0
gyro:
  errors:
    bias_repeatability: 1 \N{DEGREE SIGN}/h
    angle_random_walk: 0.1 deg/sqrt(h)
"""
