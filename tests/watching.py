"""Every command in a process where nothing is as at home, and what it does there."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING

import matplotlib as mpl
from command_line import Outcome, surroundings
from places import TESTS

if TYPE_CHECKING:
    from pathlib import Path

GRADE = ("--requirement", "navigation-grade")

# What the call of `calibrate` wrote, in the folder beside.
UNIT = (
    *("zhao-2019", "--procedure", "zhao-2019"),
    *("--measured", "../calibrate/a.json"),
)

# Calls that between them reach everything a command can reach, cluster apart.
CALLS = {
    "help": ("--help",),
    "analyze": ("analyze", "--json", "a.json"),
    "analyze, two workers": (
        *("analyze", "--method", "monte-carlo", "--trials", "50000"),
        *("--workers", "2"),
    ),
    "allocate": (
        *("allocate", *GRADE, "--no-validate"),
        *("--json", "a.json", "-o", "a.html"),
    ),
    "station": (
        *("station", *GRADE, "--write", "a.yaml"),
        *("--json", "a.json", "-o", "a.html"),
    ),
    "export": (
        *("export", "hg4930#A", "--to", "gtsam", "--residual"),
        *("-o", "a.py", "--json", "a.json"),
    ),
    "compare": ("compare", "hg4930", *GRADE, "--method", "gum", "-o", "a.html"),
    "decide": ("decide", GRADE[1], "hg4930", "-o", "a.html", "--json", "a.json"),
    "characterise": (
        *("characterise", str(TESTS / "data" / "static.csv")),
        *("-o", "a.yaml", "-o", "a.html", "--json", "a.json"),
    ),
    "calibrate": (
        *("calibrate", str(TESTS / "data" / "run.csv"), "--procedure", "zhao-2019"),
        *("--device", "zhao-2019", "-o", "a.html", "--json", "a.json"),
    ),
    "history": (
        *("history", str(TESTS / "data" / "history")),
        *("-o", "a.html", "--json", "a.json"),
    ),
    "simulate": (
        *("simulate", "hg4930#A", "--static", "20 s"),
        *("-o", "a.csv", "--truth", "a.yaml"),
    ),
    "devices": ("devices", "hg4930"),
    "paper": (
        *("paper", "-o", "a.html", "-o", "a.pdf"),
        *("--json", "a.json", "--csv", "a.csv"),
    ),
    "report": (
        *("report", "--no-validate", *GRADE),
        *("-o", "a.html", "-o", "a.pdf"),
    ),
    "mission": (
        *("mission", "--mission", "bench", "--no-validate"),
        *("--json", "a.json", "-o", "a.html"),
    ),
    "mission, of a unit": (
        *("mission", *UNIT, "--mission", "bench", "--no-validate"),
        *("--json", "a.json", "-o", "a.html"),
    ),
    "check, of a unit": ("check", "--save", "a.json", *UNIT),
    "validate": ("validate", "zhao-2019"),
    "schema": ("schema", "device"),
    "check": ("check", "-o", "a.html"),
    "diff": ("diff", "hg4930#A", "hg4930#C"),
    "new": ("new", "a.yaml", "--line", "gyro.bias_stability=1 deg/h"),
}
NOT_MET = {"compare", "decide", "station"}
# Workers import what started them: the process of theirs is a command and no more.
ALONE = "analyze, two workers"

# Python tells every hook about sockets, programs and unpickling before they happen.
# (https://docs.python.org/3/library/audit_events.html)
WATCHED = (
    *("socket.connect", "socket.bind", "socket.sendto", "socket.sendmsg"),
    *("socket.getaddrinfo", "socket.gethostbyname", "socket.gethostbyaddr"),
    *("urllib.Request", "http.client.connect", "ftplib.connect", "smtplib.connect"),
    *("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork"),
    *("pickle.find_class", "webbrowser.open"),
)
HOOK = f"""
import os, sys

WATCHED = frozenset({WATCHED!r})


def watch(event, arguments):
    if event in WATCHED:
        place = os.open(os.environ["AUDIT_LOG"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(place, (event + " " + repr(arguments)[:200] + "\\n").encode())
        os.close(place)
        if event.startswith(("socket", "urllib", "http")):
            raise OSError("no network in this test")


sys.addaudithook(watch)
"""
# Commands one after another in one process, each in a folder of its own: what modules
# do when they are imported is seen once, by the first that imports them. After each its
# name is written into the list of events. In every folder stands a matplotlibrc, which
# the library reads from that of the first command that draws.
SESSION = """
import contextlib, io, json, os, sys

calls, style = json.loads(sys.argv[1]), sys.argv[2]
found = {}
for name, words in calls.items():
    os.mkdir(name)
    os.chdir(name)
    with open("matplotlibrc", "x") as file:
        file.write(style)
    sys.argv = ["budget", *words]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            from budget.cli import main

            main()
        except SystemExit as end:
            found[name] = [end.code or 0, out.getvalue(), err.getvalue()]
    os.unlink("matplotlibrc")
    os.chdir("..")
    with open(os.environ["AUDIT_LOG"], "a") as log:
        log.write(f"# {name}\\n")
print(json.dumps(found))
"""

PERSON, HOST = "someuserhere", "somehosthere"
DATE = {"SOURCE_DATE_EPOCH": "86400"}


@dataclass(frozen=True, kw_only=True)
class Watched(Outcome):
    """One run of Python: how it ended, what it did of what is watched, its folder."""

    events: list[str]
    folder: Path
    is_offline: bool
    system_calls: str | None  # None: not traced


def is_allowed(*wrapper):
    """Return whether a program is there that may run another one."""
    if not shutil.which(wrapper[0]):
        return False
    probe = subprocess.run([*wrapper, "true"], capture_output=True, check=False)
    return probe.returncode == 0


def watch(folder, *words, python=sys.executable, is_traced=False, is_offline=False):
    """Run Python under the hooks, and where asked and allowed under more than that."""
    hooks, work, log = folder / "hooks", folder / "work", folder / "log"
    for path in (hooks, work, folder / "home"):
        path.mkdir()
    (hooks / "sitecustomize.py").write_text(HOOK, encoding="utf-8")
    # By a filter in the kernel: else it stops at every call, which trebles the time.
    trace = [
        "strace",
        "-f",
        "--seccomp-bpf",
        "-qq",
        "-e",
        "trace=socket,connect,sendto",
    ]
    trace += ["-o", str(folder / "trace")]
    inside = ["unshare", "--map-root-user", "--net"]
    is_traced = is_traced and is_allowed(*trace)
    is_offline = is_offline and is_allowed(*inside)
    started = [*inside * is_offline, *trace * is_traced, str(python), *words]
    run = subprocess.run(
        started,
        cwd=work,
        env=surroundings()
        | {"PYTHONPATH": str(hooks), "AUDIT_LOG": str(log)}
        # Without its list of fonts matplotlib asks fc-list, a program, for them.
        | {"MPLCONFIGDIR": mpl.get_cachedir()}
        | {"HOME": str(folder / "home"), "HOSTNAME": HOST}
        | {"USER": PERSON, "LOGNAME": PERSON}
        | DATE,
        capture_output=True,
        check=False,
    )
    return Watched(
        code=run.returncode,
        out=run.stdout.decode(),
        err=run.stderr.decode(),
        events=log.read_text(encoding="utf-8").splitlines() if log.exists() else [],
        folder=work,
        is_offline=is_offline,
        system_calls=(folder / "trace").read_text("utf-8") if is_traced else None,
    )


def watch_commands(folder, *, python, style):
    """Return what every command did: one run, for all that is asked of it.

    Without a network and under the eyes of the kernel, where that is allowed; beside a
    matplotlibrc of that style.
    """
    import_module("matplotlib.font_manager")  # makes the list, once on a machine
    together = {name: words for name, words in CALLS.items() if name != ALONE}
    how = dict(python=python, is_traced=True, is_offline=True)
    places = folder / "together", folder / "alone"
    for place in places:
        place.mkdir()
    session = watch(places[0], "-c", SESSION, json.dumps(together), style, **how)
    assert session.code == 0, session.err
    events = dict.fromkeys(together, ())
    own = []
    for line in session.events:
        if line.startswith("# "):
            events[line.removeprefix("# ")], own = own, []
        else:
            own.append(line)
    found = {
        name: replace(
            session,
            code=code,
            out=out,
            err=err,
            events=events[name],
            folder=session.folder / name,
        )
        for name, (code, out, err) in json.loads(session.out).items()
    }
    return found | {ALONE: watch(places[1], "-m", "budget", *CALLS[ALONE], **how)}
