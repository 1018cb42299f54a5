"""What a user gives stays on the machine, and is data, never code."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest
from command_line import call
from places import ROOT, SHIPPED, nodes_of, put
from watching import CALLS, watch

from budget.cli import app
from budget.resources import shipped, template_environment, templates_of

pytestmark = pytest.mark.usefixtures("drawn_once")

KNOWN = {
    command.name or command.callback.__name__ for command in app.registered_commands
}


# What they do there is asked by test_wheel, of the commands that are installed.
def test_every_command_is_watched():
    """A command that is added is watched too."""
    assert {words[0] for words in CALLS.values()} >= KNOWN


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
        str(path.relative_to(ROOT))
        for path in SHIPPED
        if modules_of(path) & {"socket", "urllib", "http", "ssl", "distributed"}
    }
    assert knowing == {str(Path("budget") / "methods" / "cluster.py")}


# ---- data is no code ----------------------------------------------------------------

FORBIDDEN_NAMES = {"eval", "exec", "compile", "__import__", "input", "breakpoint"}
FORBIDDEN_MODULES = {
    *("pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "subprocess"),
    *("code", "codeop", "runpy", "webbrowser"),
}
FORBIDDEN_CALLS = {
    *("os.system", "os.popen", "np.load", "numpy.load", "pd.read_pickle"),
    *("pandas.read_pickle", "DataFrame.eval", "DataFrame.query", "np.fromfile"),
}
ENDS = {name.rpartition(".")[2] for name in FORBIDDEN_CALLS}


def is_name(node, name):
    """Say whether a node is that name alone."""
    return isinstance(node, ast.Name) and node.id == name


def modules_of(path):
    """Return the top names of the modules that a file imports."""
    found = set()
    for node in nodes_of(path):
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
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.module == "yaml":
            names = {alias.name for alias in node.names}
        elif isinstance(node, ast.Attribute) and is_name(node.value, "yaml"):
            names = {node.attr}
        else:
            names = set()
        for name in sorted(names - {"SafeLoader"}):
            if "load" in name.lower():
                yield f"yaml.{name}"
        if isinstance(node, ast.Name) and node.id in FORBIDDEN_NAMES:
            yield node.id
        elif isinstance(node, ast.Attribute) and node.attr in ENDS:
            name = ast.unparse(node)
            if name in FORBIDDEN_CALLS:
                yield name
        elif isinstance(node, ast.Constant) and node.value == "allow_pickle":
            yield "allow_pickle"


# What stands in a file without a name, which nobody but the process can write.
SPOOLED = Path("budget") / "spooled.py"


def test_nothing_turns_data_into_code():
    """No pickle, eval, exec or other program anywhere in the package, but for spools.

    These are of files that have no name and are open to the process alone.
    """
    assert SHIPPED
    found = {path: list(code_from_data(path)) for path in SHIPPED}
    faulty = {str(path.relative_to(ROOT)): x for path, x in found.items() if x}
    assert faulty == {str(SPOOLED): ["pickle"]}
    assert "TemporaryFile()" in (ROOT / SPOOLED).read_text(encoding="utf-8")


def test_the_search_for_code_can_fail(tmp_path):
    """Control: each of these is found."""
    bad = put(
        tmp_path / "bad.py",
        "import pickle\nimport os\nimport yaml\nfrom yaml import load_all\n\n\n"
        "def f(x):\n    os.system(x)\n    yaml.load(x, yaml.Loader)\n"
        "    yaml.parse(x, yaml.SafeLoader)\n    return eval(x)\n",
    )
    assert set(code_from_data(bad)) == {
        *("pickle", "os.system", "eval"),
        *("yaml.load", "yaml.Loader", "yaml.load_all"),
    }


def last_name(called):
    """Return the last name of what is called."""
    if isinstance(called, ast.Attribute):
        return called.attr
    return ast.unparse(called).split(".")[-1]


def test_templates_come_from_the_package_and_the_folder_that_is_named(tmp_path):
    """Every loader of templates is given these alone, and escapes."""
    loaders, environments = [], []
    for path in SHIPPED:
        nodes = nodes_of(path)
        # string.Template puts values into places and runs nothing.
        plain = {
            one.asname or one.name
            for node in nodes
            if isinstance(node, ast.ImportFrom) and node.module == "string"
            for one in node.names
        }
        for node in nodes:
            if isinstance(node, ast.Call):
                name = last_name(node.func)
                if name.endswith("Loader"):
                    loaders.append(ast.unparse(node))
                elif name.endswith("Environment"):
                    environments.append(
                        {k.arg: ast.unparse(k.value) for k in node.keywords}
                    )
                assert name not in {"Template", "from_string"} - plain
    assert loaders == ["Loader(folders)", "FileSystemLoader(ships)"]
    ships = str(shipped("templates"))
    assert template_environment().loader.searchpath == [ships]
    with templates_of(tmp_path):
        assert template_environment().loader.searchpath == [str(tmp_path), ships]
    (options,) = environments
    assert options["autoescape"] == "True"


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
    device = put(tmp_path / "d.yaml", HOSTILE.format(name=text))
    run = call(
        "analyze", device, "--no-validate", "--json", tmp_path / "a.json", code=0
    )
    plain = text.replace('\\"', '"').replace("\\\\", "\\")
    assert plain in " ".join(run.out.split())

    page = tmp_path / "a.html"
    run = call(
        "report", device, "--no-validate", "-o", page, "-o", tmp_path / "a.pdf", code=0
    )
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
    for path in shipped("templates").rglob("*.*"):
        own = folder / path.relative_to(shipped("templates"))
        own.parent.mkdir(parents=True, exist_ok=True)
        own.write_text("taken over", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    call("report", "--no-validate", "-o", "a.html", code=0)
    assert "taken over" not in (tmp_path / "a.html").read_text(encoding="utf-8")
