"""What a user gives stays on the machine, and is data, never code."""

from __future__ import annotations

import ast
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

import matplotlib as mpl
import pytest
from command_line import call, surroundings
from places import PACKAGE

from budget.cli import app
from budget.resources import shipped

pytestmark = pytest.mark.usefixtures("drawn_once")

GRADE = ("--requirement", "navigation-grade")

# Calls that between them reach everything a command can reach, cluster apart.
CALLS = {
    "analyze": ("analyze", "--json", "a.json"),
    "analyze, two workers": (
        *("analyze", "--method", "monte-carlo", "--trials", "50000"),
        *("--workers", "2"),
    ),
    "allocate": ("allocate", *GRADE, "--no-validate", "--json", "a.json"),
    "station": ("station", *GRADE, "--write", "a.yaml", "--json", "a.json"),
    "export": (
        *("export", "hg4930#A", "--to", "gtsam", "--residual"),
        *("-o", "a.py", "--json", "a.json"),
    ),
    "compare": ("compare", "hg4930", *GRADE, "--method", "gum", "-o", "a.html"),
    "devices": ("devices", "hg4930"),
    "paper": ("paper", "-o", "a.html", "-o", "a.pdf"),
    "report": (
        *("report", "--no-validate", *GRADE),
        *("-o", "a.html", "-o", "a.pdf"),
    ),
    "mission": ("mission", "--mission", "bench", "--no-validate", "--json", "a.json"),
    "validate": ("validate", "zhao-2019"),
    "schema": ("schema", "device"),
    "check": ("check", "zhao-2019-eq4-nominal"),
    "diff": ("diff", "hg4930#A", "hg4930#C"),
    "new": ("new", "a.yaml", "--line", "gyro.bias_stability=1 deg/h"),
    "help": ("--help",),
}
NOT_MET = {"compare", "station"}
KNOWN = {
    command.name or command.callback.__name__ for command in app.registered_commands
}

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
# name is written into the list of events.
SESSION = """
import contextlib, io, json, os, sys

calls, place = json.loads(sys.argv[1]), os.environ["AUDIT_LOG"]
found = {}
for name, words in calls.items():
    os.mkdir(name)
    os.chdir(name)
    sys.argv = ["budget", *words]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            from budget.cli import main

            main()
        except SystemExit as end:
            found[name] = [end.code or 0, out.getvalue(), err.getvalue()]
    os.chdir("..")
    with open(place, "a") as log:
        log.write(f"# {name}\\n")
print(json.dumps(found))
"""
# Workers import what started them: the process of theirs is a command and no more.
ALONE = "analyze, two workers"

PERSON, HOST = "someuserhere", "somehosthere"


@dataclass(frozen=True, kw_only=True)
class Watched:
    """One run of Python: how it ended, what it did of what is watched, its folder."""

    code: int
    out: str
    err: str
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


def watch(folder, *words, is_traced=False, is_offline=False):
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
    started = [*inside * is_offline, *trace * is_traced, sys.executable, *words]
    run = subprocess.run(
        started,
        cwd=work,
        env=surroundings()
        | {"PYTHONPATH": str(hooks), "AUDIT_LOG": str(log)}
        # Without its list of fonts matplotlib asks fc-list, a program, for them.
        | {"MPLCONFIGDIR": mpl.get_cachedir()}
        | {"HOME": str(folder / "home"), "HOSTNAME": HOST}
        | {"USER": PERSON, "LOGNAME": PERSON},
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


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Return what every command did: one run, for all that is asked of it.

    Without a network and under the eyes of the kernel, where that is allowed.
    """
    import_module("matplotlib.font_manager")  # makes the list, once on a machine
    together = {name: words for name, words in CALLS.items() if name != ALONE}
    how = dict(is_traced=True, is_offline=True)
    session = watch(
        tmp_path_factory.mktemp("watched"),
        *("-c", SESSION, json.dumps(together)),
        **how,
    )
    assert session.code == 0, session.err
    ends = json.loads(session.out)
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
        for name, (code, out, err) in ends.items()
    }
    alone = ("-m", "budget", *CALLS[ALONE])
    return found | {ALONE: watch(tmp_path_factory.mktemp("watched"), *alone, **how)}


def test_every_command_is_called_here():
    """A command that is added is watched too."""
    assert {words[0] for words in CALLS.values()} >= KNOWN


@pytest.mark.slow
def test_no_network_no_program_no_pickle(watched):
    """No command connects, starts a program or loads a pickle; workers alone may."""
    assert watched.keys() == CALLS.keys()
    for name, found in watched.items():
        assert found.code == (1 if name in NOT_MET else 0), (name, found.err)
        events = found.events
        if name == ALONE:
            # Python's own processes, and tasks that they get through a private pipe.
            allowed = ("os.posix_spawn", "subprocess.Popen", "os.fork")
            allowed += ("pickle.find_class",)
            events = [event for event in events if not event.startswith(allowed)]
        assert events == [], name


@pytest.mark.slow
def test_no_system_call_to_a_network(watched):
    """Libraries that are no Python open no internet socket either."""
    for name, found in watched.items():
        if found.system_calls is None:
            pytest.skip("tracing is not allowed here")
        assert "AF_INET" not in found.system_calls, name


@pytest.mark.slow
def test_a_machine_without_a_network(watched):
    """In a network namespace without any interface a report is written."""
    found = watched["report"]
    if not found.is_offline:
        pytest.skip("namespaces are not allowed here")
    assert found.code == 0, found.err
    assert sorted(p.name for p in found.folder.iterdir()) == ["a.html", "a.pdf"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["report", "paper"])
def test_documents_name_no_place_and_no_person(name, watched):
    """No folder, user or host of the run stands in what is written."""
    found = watched[name]
    secrets = (
        *(str(found.folder), str(found.folder.parent.parent)),
        *(str(PACKAGE), PERSON, HOST, os.uname().nodename),
    )
    written = list(found.folder.glob("a.*"))
    assert written
    for path in written:
        data = path.read_bytes()
        for secret in secrets:
            assert len(secret) < 4 or secret.encode() not in data, (path.name, secret)


@pytest.mark.parametrize(
    "code",
    [
        "import socket; socket.create_connection(('127.0.0.1', 9))",
        "import socket; socket.getaddrinfo('localhost', 80)",
        "import urllib.request as r; r.urlopen('http://127.0.0.1:9')",
        "import pickle, collections as c; pickle.loads(pickle.dumps(c.OrderedDict()))",
        "import subprocess; subprocess.run(['true'])",
    ],
)
def test_the_watch_sees_what_it_watches(code, tmp_path):
    """Control: each of these is written down."""
    assert watch(tmp_path, "-c", code).events


def test_the_trace_sees_a_socket(tmp_path):
    """Control: a socket that no hook is asked about is written down."""
    found = watch(tmp_path, "-c", "import socket; socket.socket()", is_traced=True)
    if found.system_calls is None:
        pytest.skip("tracing is not allowed here")
    assert "AF_INET" in found.system_calls


def test_only_a_cluster_that_is_asked_for_is_connected_to():
    """One module knows sockets: that of `--cluster`, which says so in its help."""
    knowing = {
        str(path.relative_to(PACKAGE))
        for path in SOURCES
        if modules_of(path) & {"socket", "urllib", "http", "ssl", "distributed"}
    }
    assert knowing == {str(Path("methods") / "cluster.py")}


# ---- data is no code ----------------------------------------------------------------

SOURCES = sorted(PACKAGE.rglob("*.py"))
FORBIDDEN_NAMES = {"eval", "exec", "compile", "__import__", "input", "breakpoint"}
FORBIDDEN_MODULES = {
    *("pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "subprocess"),
    *("code", "codeop", "runpy", "webbrowser"),
}
FORBIDDEN_CALLS = {
    *("os.system", "os.popen", "np.load", "numpy.load", "pd.read_pickle"),
    *("pandas.read_pickle", "DataFrame.eval", "DataFrame.query", "np.fromfile"),
}


def modules_of(path):
    """Return the top names of the modules that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


def code_from_data(path):
    """Yield what in a file could turn data into code.

    Of YAML that is whatever loads: its events are text, and so are its safe loaders'.
    """
    yield from sorted(modules_of(path) & FORBIDDEN_MODULES)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module == "yaml":
            names = {alias.name for alias in node.names}
        elif isinstance(node, ast.Attribute) and ast.unparse(node.value) == "yaml":
            names = {node.attr}
        else:
            names = set()
        for name in sorted(names - {"SafeLoader"}):
            if "load" in name.lower():
                yield f"yaml.{name}"
        if isinstance(node, ast.Name) and node.id in FORBIDDEN_NAMES:
            yield node.id
        elif isinstance(node, ast.Attribute):
            name = ast.unparse(node)
            if name in FORBIDDEN_CALLS:
                yield name
        elif isinstance(node, ast.Constant) and node.value == "allow_pickle":
            yield "allow_pickle"


def test_nothing_turns_data_into_code():
    """No pickle, eval, exec or other program anywhere in the package."""
    assert SOURCES
    found = {path: list(code_from_data(path)) for path in SOURCES}
    assert {path: faults for path, faults in found.items() if faults} == {}


def test_the_search_for_code_can_fail(tmp_path):
    """Control: each of these is found."""
    bad = tmp_path / "bad.py"
    bad.write_text(
        "import pickle\nimport os\nimport yaml\nfrom yaml import load_all\n\n\n"
        "def f(x):\n    os.system(x)\n    yaml.load(x, yaml.Loader)\n"
        "    yaml.parse(x, yaml.SafeLoader)\n    return eval(x)\n",
        encoding="utf-8",
    )
    assert set(code_from_data(bad)) == {
        *("pickle", "os.system", "eval"),
        *("yaml.load", "yaml.Loader", "yaml.load_all"),
    }


def test_templates_come_from_the_package_alone():
    """Every loader of templates is given the shipped folder, and escapes."""
    loaders, environments = [], []
    for path in SOURCES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        # string.Template puts values into places and runs nothing.
        plain = {
            one.asname or one.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module == "string"
            for one in node.names
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func).split(".")[-1]
                if name.endswith("Loader"):
                    loaders.append(ast.unparse(node))
                elif name == "Environment":
                    environments.append(
                        {k.arg: ast.unparse(k.value) for k in node.keywords}
                    )
                assert name not in {"Template", "from_string"} - plain
    assert loaders
    assert set(loaders) == {"FileSystemLoader(shipped('templates'))"}
    assert all(options["autoescape"] == "True" for options in environments)


HOSTILE = """name: "{name}"
notes: "{name}"
gyro: {{errors: {{bias_repeatability: {{value: 1 deg/h, source: "{name}"}}}}}}
"""
NAMES = {
    "script": "<script>alert(1)</script>",
    "closing": "</script></style>--><b>x</b>",
    "jinja": "{{ 7 * 191 }}{% include '/etc/passwd' %}",
    "typst": '#panic(1) #read(\\"/etc/passwd\\") $ x $ *b* _e_ @ref <label>',
    "rich": "[red]x[/red] [link=http://x.org]",
    "formula": "=HYPERLINK(1)",
    "escape": "\\\\x1b[31mred",
}


@pytest.mark.parametrize("name", NAMES)
def test_a_hostile_name_is_only_a_name(name, tmp_path):
    """What a device is called is shown as it stands, in text, page, PDF and JSON."""
    text = NAMES[name]
    device = tmp_path / "d.yaml"
    device.write_text(HOSTILE.format(name=text), encoding="utf-8")
    run = call("analyze", device, "--no-validate", "--json", tmp_path / "a.json")
    assert run.code == 0, run.err
    plain = text.replace('\\"', '"').replace("\\\\", "\\")
    assert plain in " ".join(run.out.split())

    page = tmp_path / "a.html"
    run = call("report", device, "--no-validate", "-o", page, "-o", tmp_path / "a.pdf")
    assert run.code == 0, run.err
    html = page.read_text(encoding="utf-8")
    assert "1337" not in html.replace("#", "") or name != "jinja"
    assert "<script>alert" not in html
    assert "<b>x</b>" not in html
    assert "root:x:0" not in html
    json.loads((tmp_path / "a.json").read_bytes())


def test_files_beside_the_user_are_no_templates(tmp_path, monkeypatch):
    """A folder `templates` where the user works changes nothing."""
    folder = tmp_path / "templates"
    folder.mkdir()
    for path in shipped("templates").iterdir():
        (folder / path.name).write_text("taken over", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    run = call("report", "--no-validate", "-o", "a.html")
    assert run.code == 0, run.err
    assert "taken over" not in (tmp_path / "a.html").read_text(encoding="utf-8")
