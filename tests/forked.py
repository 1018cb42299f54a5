"""Commands in processes of their own, forked from one that has imported everything.

A child has its own streams, folder, code and end, as if a shell had started it; what
it saves is the start, and of a call that is rehearsed what is computed before anything
is printed. What Python reads as it starts (the locale, PYTHON...) belongs to
the process that forks: there is one for each environment.
"""

from __future__ import annotations

import atexit
import gc
import io
import json
import os
import re
import runpy
import signal
import subprocess
import sys
import threading
import warnings
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import cache, wraps
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

# Names that begin so are of what few calls need, and take as long to import as all the
# rest: a child that needs one imports it as a command does. scipy.special is needed.
SELDOM = ("distributed", "SALib", "matplotlib", "pandas", "fontTools")
SELDOM += ("scipy.signal", "scipy.stats")
# Read while a command runs, not while Python or a library starts; the last by nobody.
READ_LATE = ("COLUMNS", "SOURCE_DATE_EPOCH", "MATPLOTLIBRC", "PYTEST_CURRENT_TEST")
# Read as Python makes its streams, which a child makes anew.
ENCODING = "PYTHONIOENCODING"
# What commands compute: pure, so that of the same words it is the same.
COMPUTING = (
    "budget.inputs.load_catalogue",
    "budget.inputs.load_stations",
    "budget.inputs.json_schema",
    "budget.references.check.make_reference",
    "budget.references.check.compare_sides",
    "budget.references.check.check",
    "budget.studies.analysis.analyze_as",
    "budget.studies.allocation.allocate.allocate",
    "budget.studies.comparison.compare.compare",
    "budget.studies.export.study.export",
    "zhao_2019.study.reproduce",
    "budget.studies.stations.qualify",
)
NO_READER = ">&|"  # as a redirection: stdout is a pipe that its reader has closed
# A line that imports one module, or from one.
_IMPORT = re.compile(
    r"^ *(?:from|import) ([\w.]+)(?: as \w+| import .*)?$", re.MULTILINE
)
_REDIRECTION = re.compile(r"([012]?)([<>])(&-|&\||\s*\S+)")


def run_forked(words, *, folder, streams, environment, patience, rehearsed):
    """Run `budget` with those words; `streams` redirects as in a shell.

    A call that is rehearsed has been made once in the process that forks: its children
    read and print, and what lies between is computed once for all of them.
    """
    late = {
        name: environment[name]
        for name in (*READ_LATE, ENCODING)
        if name in environment
    }
    early = {name: text for name, text in environment.items() if name not in late}
    server = _server(frozenset(early.items()))
    with TemporaryDirectory() as caught:
        request = {
            # As bytes: what characters they are is up to the child's locale.
            "words": [os.fsencode(word).decode("latin-1") for word in words],
            "folder": str(folder),
            "late": late,
            "streams": f"< {os.devnull} > {caught}/1 2> {caught}/2 {streams}",
            "patience": patience,
            "rehearsed": rehearsed,
        }
        server.stdin.write(json.dumps(request).encode() + b"\n")
        server.stdin.flush()
        code = json.loads(server.stdout.readline())
        out, err = ((Path(caught) / number).read_bytes() for number in "12")
    return subprocess.CompletedProcess(words, code, out, err)


@cache
def _server(environment):
    """Start a process that forks, in an environment of pairs; it ends with this one."""
    process = subprocess.Popen(
        [sys.executable, __file__, *_modules()],
        env=dict(environment),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    atexit.register(process.communicate)  # closes its stdin, at which it ends
    return process


def _serve():
    """Fork a child for every line on stdin, and say its code; a child returns."""
    asked, told = os.fdopen(os.dup(0), "rb"), os.dup(1)
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    _import_everything()
    for line in asked:
        request = json.loads(line)
        if request["rehearsed"]:
            _rehearse(_asking(request["words"]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of forks where a library has threads
            child = os.fork()
        if child == 0:
            os.close(told)
            os.close(nowhere)
            asked.close()
            return request
        _, status = os.waitpid(child, 0)
        os.write(told, f"{os.waitstatus_to_exitcode(status)}\n".encode())
    sys.exit()


@cache
def _modules():
    """Return the modules that any command imports, those of seldom used ones apart."""
    import budget

    files = Path(budget.__file__).parent.rglob("*.py")
    names = {
        name for file in files for name in _IMPORT.findall(file.read_text("utf-8"))
    }
    return sorted(n for n in names if not n.startswith((*SELDOM, "_")))


def _import_everything():
    """Import what the command line names, and read the files that ship."""
    for name in sys.argv[1:]:
        import_module(name)
    typer = import_module("typer.main")
    typer.get_command = cache(typer.get_command)
    typer.get_command(import_module("budget.cli").app)
    import_module("budget.inputs").load_catalogue()
    keep_computed(setattr)
    _leave_alone()


def _leave_alone():
    """Keep what there is from being looked through by a child at its end: a second."""
    gc.collect()
    gc.freeze()


def keep_computed(set_attribute):
    """Let what computes for a command do so once for the same words."""
    for place in COMPUTING:
        module, _, name = place.rpartition(".")
        home = import_module(module)
        set_attribute(home, name, _computed_once(getattr(home, name)))


KEPT = {}  # what is computed, by the words that ask for it and in their order
ASKED = []  # functions that this call has asked so far
WITHIN = []  # the one of them that is computing, which may ask others
# Where a document goes changes nothing that is computed.
WITHOUT_EFFECT = {"--json", "--csv", "-"}


def _computed_once(function):
    """Return a function that computes once for the same words.

    It finds the streams for data closed, which nothing that computes may ask for.
    """

    @wraps(function)
    def asked(*args, **kwargs):
        if WITHIN:
            return function(*args, **kwargs)
        ASKED.append(function)
        key = *_asking(sys.argv[1:]), *ASKED
        if key not in KEPT:
            WITHIN.append(function)
            with redirect_stdout(None), patch.object(sys, "stdin", None):
                KEPT[key] = function(*args, **kwargs)
            WITHIN.clear()
        return KEPT[key]

    return asked


def _asking(words):
    """Return the words of a call that say what is computed."""
    return tuple(word for word in words if word not in WITHOUT_EFFECT)


@cache
def _rehearse(words):
    """Make a call in this process, for what is computed; nobody sees what it says."""
    sys.argv = _words(words)
    with (
        redirect_stdout(io.StringIO()),
        redirect_stderr(io.StringIO()),
        suppress(SystemExit),
    ):
        import_module("budget.cli").main()
    ASKED.clear()
    WITHIN.clear()
    _leave_alone()


def _words(words):
    """Return the words of a call as Python has them in this locale."""
    return ["budget", *(os.fsdecode(word.encode("latin-1")) for word in words)]


def _redirect(streams):
    """Open and close streams as a shell does."""
    for number, way, target in _REDIRECTION.findall(streams):
        stream = int(number or way == ">")
        if target == "&-":
            os.close(stream)
        elif target == "&|":
            read, write = os.pipe()
            os.close(read)
            os.dup2(write, stream)
            os.close(write)
        else:
            flags = os.O_RDONLY if way == "<" else os.O_WRONLY | os.O_CREAT
            opened = os.open(target.strip(), flags, 0o600)
            os.dup2(opened, stream)
            os.close(opened)


def _streams_of_python():
    """Make the streams anew as Python makes them, None for a closed one."""
    named, _, errors = os.environ.get(ENCODING, "").partition(":")
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        old, new = getattr(sys, name), None
        with suppress(OSError):
            os.fstat(number)
            end = io.FileIO(number, "w" if number else "r", closefd=False)
            new = io.TextIOWrapper(
                io.BufferedWriter(end) if number else io.BufferedReader(end),
                encoding=named or old.encoding,
                errors=(errors or "strict") if named and number < 2 else old.errors,
                newline="\n" if number else None,
                line_buffering=number == 2,
            )
        setattr(sys, name, new)
        setattr(sys, f"__{name}__", new)


def _run():
    """Run `budget` and end as Python does, but leave its thousands of objects alone.

    To take them apart is most of what a quick command takes here. What else happens at
    an end happens, and where there is more to it the end is Python's own.
    """
    try:
        runpy.run_module("budget", run_name="__main__", alter_sys=True)
    except SystemExit as end:
        if threading.active_count() > 1 or not isinstance(end.code, int):
            raise
        atexit._run_exitfuncs()  # noqa: SLF001
        with suppress(OSError, ValueError):
            for stream in (sys.stdout, sys.stderr):
                if stream is not None:
                    stream.flush()
            os._exit(end.code)
        raise


if __name__ == "__main__":
    asked_for = _serve()
    signal.alarm(int(asked_for["patience"]))
    os.setsid()  # no terminal to fall back on
    os.chdir(asked_for["folder"])
    os.environ.update(asked_for["late"])
    _redirect(asked_for["streams"])
    _streams_of_python()
    sys.argv = _words(asked_for["words"])
    sys.path[0] = asked_for["folder"]
    _run()
