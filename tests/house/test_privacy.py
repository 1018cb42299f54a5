"""What a user gives stays on the machine, and is data, never code."""

from __future__ import annotations

import ast
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

import matplotlib as mpl
import pytest
from command_line import call, surroundings
from failing import PATIENCE
from forked import run_forked
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
        log = os.environ.get("CHILD_LOG", os.environ["AUDIT_LOG"])
        place = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(place, (event + " " + repr(arguments)[:200] + "\\n").encode())
        os.close(place)
        if event.startswith(("socket", "urllib", "http")):
            raise OSError("no network in this test")


sys.addaudithook(watch)
"""


PERSON, HOST = "someuserhere", "somehosthere"
TRACED = ("report", "paper", "analyze, two workers")


@dataclass(frozen=True, kw_only=True)
class Watched:
    """One run of Python: its process, what it did of what is watched, its folder."""

    run: subprocess.CompletedProcess[bytes]
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


def under_hooks(folder):
    """Return an environment in which Python writes down what is watched."""
    hooks, home = folder / "hooks", folder / "home"
    for path in (hooks, home):
        path.mkdir()
    (hooks / "sitecustomize.py").write_text(HOOK, encoding="utf-8")
    return surroundings() | {
        "PYTHONPATH": str(hooks),
        "AUDIT_LOG": str(folder / "log"),
        # Without its list of fonts matplotlib asks fc-list, a program, for them.
        "MPLCONFIGDIR": mpl.get_cachedir(),
        "HOME": str(home),
        "HOSTNAME": HOST,
        "USER": PERSON,
        "LOGNAME": PERSON,
    }


def events_of(log):
    """Return what stands in a log; nothing is watched that did not happen."""
    return log.read_text(encoding="utf-8").splitlines() if log.exists() else []


def watch(folder, *words, is_traced=False, is_offline=False):
    """Run Python under the hooks, and where asked and allowed under more than that."""
    environment, work = under_hooks(folder), folder / "work"
    work.mkdir()
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
        env=environment,
        capture_output=True,
        check=False,
    )
    return Watched(
        run=run,
        events=events_of(folder / "log"),
        folder=work,
        is_offline=is_offline,
        system_calls=(folder / "trace").read_text("utf-8") if is_traced else None,
    )


@pytest.fixture(scope="module")
def call_of(tmp_path_factory):
    """Return a way to get the run of a command: one run, for all that is asked of it.

    The report is made without a network, where that is allowed. What is not traced runs
    in a child of a process that has imported everything, under the hooks too.
    """
    import_module("matplotlib.font_manager")  # makes the list, once on a machine
    parent = tmp_path_factory.mktemp("parent")
    environment = under_hooks(parent)

    @cache
    def run_once(name):
        folder = tmp_path_factory.mktemp("watched")
        if name in TRACED:
            return watch(
                folder,
                *("-m", "budget", *CALLS[name]),
                is_traced=True,
                is_offline=name == "report",
            )
        work = folder / "work"
        work.mkdir()
        run = run_forked(
            CALLS[name],
            folder=work,
            streams="",
            environment=environment | {"CHILD_LOG": str(folder / "log")},
            patience=PATIENCE,
        )
        imported = events_of(parent / "log")
        # The parent forks, and does nothing else of what is watched.
        events = [event for event in imported if not event.startswith("os.fork ")]
        return Watched(
            run=run,
            events=events + events_of(folder / "log"),
            folder=work,
            is_offline=False,
            system_calls=None,
        )

    return run_once


def test_every_command_is_called_here():
    """A command that is added is watched too."""
    assert {words[0] for words in CALLS.values()} >= KNOWN


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_no_network_no_program_no_pickle(name, call_of):
    """No command connects, starts a program or loads a pickle; workers alone may."""
    found = call_of(name)
    code = 1 if name in NOT_MET else 0
    assert found.run.returncode == code, found.run.stderr.decode()
    events = found.events
    if name == "analyze, two workers":
        # Python's own processes, and tasks that they get through a private pipe.
        allowed = ("os.posix_spawn", "subprocess.Popen", "os.fork", "pickle.find_class")
        events = [event for event in events if not event.startswith(allowed)]
    assert events == []


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


@pytest.mark.slow
@pytest.mark.parametrize("name", TRACED)
def test_no_system_call_to_a_network(name, call_of):
    """Libraries that are no Python open no internet socket either."""
    found = call_of(name)
    if found.system_calls is None:
        pytest.skip("tracing is not allowed here")
    assert found.run.returncode == 0, found.run.stderr.decode()
    assert "AF_INET" not in found.system_calls


def test_the_trace_sees_a_socket(tmp_path):
    """Control: a socket that no hook is asked about is written down."""
    found = watch(tmp_path, "-c", "import socket; socket.socket()", is_traced=True)
    if found.system_calls is None:
        pytest.skip("tracing is not allowed here")
    assert "AF_INET" in found.system_calls


@pytest.mark.slow
def test_a_machine_without_a_network(call_of):
    """In a network namespace without any interface a report is written."""
    found = call_of("report")
    if not found.is_offline:
        pytest.skip("namespaces are not allowed here")
    assert found.run.returncode == 0, found.run.stderr.decode()
    assert sorted(p.name for p in found.folder.iterdir()) == ["a.html", "a.pdf"]


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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["report", "paper"])
def test_documents_name_no_place_and_no_person(name, call_of):
    """No folder, user or host of the run stands in what is written."""
    found = call_of(name)
    assert found.run.returncode == 0, found.run.stderr.decode()
    secrets = (
        str(found.folder.parent),
        str(PACKAGE),
        PERSON,
        HOST,
        os.uname().nodename,
    )
    written = list(found.folder.glob("a.*"))
    assert written
    for path in written:
        data = path.read_bytes()
        for secret in secrets:
            assert len(secret) < 4 or secret.encode() not in data, (path.name, secret)
