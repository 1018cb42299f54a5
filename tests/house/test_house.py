"""The house: who may import whom, what the command line may not wake up."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from places import EXAMPLE, PACKAGE, SHIPPED, TESTS, nodes_of
from reading import assert_says

# From the ground up. A module imports from lower floors, or within its own room;
# rooms on one floor do not know each other.
FLOORS = (
    ("version", "arrays", "errors", "names", "earth", "ties", "journal", "views"),
    ("units", "language", "resources", "documents", "known", "spooled"),
    ("distributions", "sentences"),
    ("problem", "model", "navigation"),
    ("inputs",),
    ("settings",),
    ("results",),
    ("calibration", "methods"),
    ("aiding", "missing"),
    ("recordings",),
    ("question",),
    ("studies",),
    ("references",),
    ("report",),
    ("zhao_2019",),  # examples of use stand on the package; its commands run them
    ("cli",),
    ("__main__",),
)
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# The package's face hands on public names and loads them when they are asked for.
FACE = "__init__"


def room_of(path):
    """Return the first part of a module's place below the package, or its example."""
    if path.is_relative_to(EXAMPLE):
        return EXAMPLE.name
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path):
    """Return every room that a file imports from, anywhere in it."""
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.module:
            parts = node.module.split(".")
            if parts == ["budget"]:
                yield from (alias.name for alias in node.names)
            elif parts[0] == "budget":
                yield parts[1]
            elif parts[0] == EXAMPLE.name:
                yield EXAMPLE.name
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith("budget."):
                    yield alias.name.split(".")[1]


MODULES = [path for path in SHIPPED if room_of(path) != FACE]


def upward_imports(paths):
    """Return what imports its own floor's neighbour or from above, as texts."""
    return [
        f"{path.name} imports {other}"
        for path in paths
        for here in [room_of(path)]
        for other in imports(path)
        if other != here and FLOOR[other] >= FLOOR[here]
    ]


def silent_modules(paths):
    """Return the names of modules that do not begin with a docstring."""
    return [
        path.name
        for path in paths
        if not path.read_text(encoding="utf-8").startswith('"""')
    ]


def test_imports_run_downwards():
    """No module imports from its own floor's neighbour or from above."""
    assert MODULES
    assert upward_imports(MODULES) == []


def test_no_floor_names_a_module_of_one_above():
    """Nor does one load another by its name from above: such texts name lower ones."""
    named = [
        f"{path.name} names {node.value}"
        for path in MODULES
        for node in nodes_of(path)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if re.fullmatch(r"budget(\.\w+)+", node.value)
        for other in [node.value.split(".")[1]]
        if other != room_of(path) and FLOOR.get(other, 0) > FLOOR[room_of(path)]
    ]
    assert named == []


def test_modules_say_what_they_are_for():
    """Every file states its purpose first."""
    assert silent_modules(MODULES) == []


def test_the_house_checks_can_fail(tmp_path, monkeypatch):
    """Control: an import that runs upwards and a silent module are seen."""
    monkeypatch.setattr(f"{__name__}.PACKAGE", tmp_path)
    bad = tmp_path / "methods" / "bad.py"
    bad.parent.mkdir()
    bad.write_text(
        "import budget.calibration\ndef f():\n    from budget.cli import main\n"
        "from zhao_2019.study import reproduce\n",
        encoding="utf-8",
    )
    # A neighbour on the same floor, the floor above, and what stands on the package.
    assert sorted(upward_imports([bad])) == [
        "bad.py imports calibration",
        "bad.py imports cli",
        "bad.py imports zhao_2019",
    ]
    assert silent_modules([bad]) == ["bad.py"]


def test_no_command_needs_the_extras_of_the_guides():
    """The package `jcgm` stands on this one, and nothing here on it."""
    named = {
        part
        for path in PACKAGE.rglob("*.py")
        for node in nodes_of(path)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for part in (getattr(node, "module", None), *(a.name for a in node.names))
        if part
    }
    assert "budget.distributions" in named
    assert not [name for name in named if name.split(".")[0] == "jcgm"]


def rooms_within(floor):
    """Return which rooms of a folder each of its rooms imports, anywhere in it."""
    folder = PACKAGE / floor
    found = {}
    for path in folder.rglob("*.py"):
        here = path.relative_to(folder).parts[0].removesuffix(".py")
        if here == FACE:
            continue
        for node in nodes_of(path):
            if not isinstance(node, ast.ImportFrom) or node.module is None:
                continue
            parts = node.module.split(".")[1:]
            if parts[:1] != [floor]:
                continue
            rooms = parts[1:2] or [alias.name for alias in node.names]
            found.setdefault(here, set()).update(set(rooms) - {here})
    return found


FOLDERS = sorted(path.name for path in PACKAGE.iterdir() if path.is_dir())
# Folders that stand side by side: what two of them need is a room of its own.
APART = {
    "report": {"allocation", "analysis", "comparison", "reference"},
    "studies": {"allocation", "comparison"},
}


@pytest.mark.parametrize("floor", [name for name in FOLDERS if name != "__pycache__"])
def test_rooms_of_a_floor_stand_in_no_circle(floor):
    """Within a folder imports run one way, and studies do not know each other."""
    found = rooms_within(floor)
    assert list(TopologicalSorter(found).static_order()) or not found
    apart = APART.get(floor, set())
    assert {one: found.get(one, set()) & apart for one in apart} == {
        one: set() for one in apart
    }


def test_a_circle_of_rooms_is_seen(tmp_path, monkeypatch):
    """Control: two rooms that import each other."""
    monkeypatch.setattr(f"{__name__}.PACKAGE", tmp_path)
    (tmp_path / "report").mkdir()
    for one, other in (("a", "b"), ("b", "a")):
        text = f"def f():\n    from budget.report.{other} import f\n"
        (tmp_path / "report" / f"{one}.py").write_text(text, encoding="utf-8")
    assert rooms_within("report") == {"a": {"b"}, "b": {"a"}}
    with pytest.raises(CycleError):
        list(TopologicalSorter(rooms_within("report")).static_order())


# What is of no one module: the house itself, its documents, faults and hostile files,
# the package jcgm.
WHOLE = {"house", "docs", "faults", "fuzz", "guard", "extras"}


def misplaced_tests(tests):
    """Return the tests that stand in no folder of the package, or not with theirs.

    A test with the name of a module stands in the folder of that module; where several
    folders have a module of that name, in one of them.
    """
    homes = {}
    for path in MODULES:
        is_example = path.is_relative_to(EXAMPLE)
        folder = Path("examples") if is_example else path.relative_to(PACKAGE).parent
        name = folder.name if path.stem == FACE else path.stem
        homes.setdefault(name, set()).add(folder)
    folders = set().union(*homes.values())
    for path in sorted(tests.rglob("test_*.py")):
        place = path.relative_to(tests)
        if place.parts[0] in WHOLE:
            continue
        name = path.stem.removeprefix("test_")
        if place.parent not in homes.get(name, folders):
            yield str(place)


def test_tests_stand_where_their_modules_do():
    """The folders of tests/ are those of budget/, examples/, and some for the house."""
    assert list(misplaced_tests(TESTS)) == []


def test_a_misplaced_test_is_seen(tmp_path):
    """Control: a folder that the package has not, and a test not with its module."""
    for place in ("cabin/test_a.py", "inputs/test_sobol.py", "methods/test_sobol.py"):
        (tmp_path / place).parent.mkdir(exist_ok=True)
        (tmp_path / place).touch()
    assert list(misplaced_tests(tmp_path)) == [
        "cabin/test_a.py",
        "inputs/test_sobol.py",
    ]


def test_a_fact_that_a_text_drops_is_seen():
    """Control: a fact, its number, unit or sign is missing; its sentence is free."""
    text = "Gyro bias z: FAILS, at\n119\N{NO-BREAK SPACE}% of 0.1 deg/h (-3.5 ug)."
    assert_says(text, "gyro bias z", "fails", "119 %", "0.1 deg/h", "-3.5 ug")
    for fact in ("19 %", "0.1 deg", "1 deg/h", "3.5 u", "meets", "z: fail"):
        with pytest.raises(AssertionError, match="not said"):
            assert_says(text, fact)


# Dots that are no names': of numbers, of files, of Python's modules, of keys in a file
# and of values in a document.
OTHER_DOTS = {
    "text.partition('.')",
    "self.base_name.partition('.')",
    "place.partition('.')",
    "type(error).__module__.partition('.')",
    "f'{path}.{_shown(word)}'",
    "f'{path}.{key}'",
    "f'{path}.{k}'",
    "path.split('.')",
    "source.name.split('.')",
}
SPLITTERS = {"partition", "rpartition", "split", "rsplit"}
CUTTERS = {"startswith", "endswith", "removeprefix", "removesuffix"}


def is_dotted(node):
    """Whether it is a text with a blank in it that begins or ends with a dot."""
    parts = getattr(node, "values", [])
    ends = [getattr(parts[place], "value", None) for place in (0, -1) if parts]
    return isinstance(node, ast.JoinedStr) and len(parts) > 1 and "." in ends


def handled_names(path):
    """Return where a module takes dotted names apart or puts them together."""
    for node in nodes_of(path):
        found = False
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            first = node.args[0] if node.args else None
            dot = isinstance(first, ast.Constant) and first.value == "."
            found = (node.func.attr in SPLITTERS and dot) or (
                node.func.attr in CUTTERS and is_dotted(first)
            )
        elif isinstance(node, ast.JoinedStr):
            found = len(node.values) == 3 and (
                getattr(node.values[1], "value", None) == "."
            )
        if found and ast.unparse(node) not in OTHER_DOTS:
            yield f"{path.name}: {ast.unparse(node)}"


def test_nobody_splits_names():
    """Names of outputs and sources are read by their attributes, nowhere as texts."""
    found = [
        text
        for path in MODULES
        if path.name != "names.py"
        for text in handled_names(path)
    ]
    assert found == []


def test_the_check_of_names_can_fail(tmp_path):
    """Control: a name split, one cut by its owner and one joined are seen."""
    bad = tmp_path / "bad.py"
    bad.write_text(
        "name.partition('.')\nname.rsplit('.', 1)\nname.startswith(f'{sensor}.')\n"
        "f'{owner}.{name}'\nname.removeprefix('x')\ntext.partition(': ')\n",
        encoding="utf-8",
    )
    assert len(list(handled_names(bad))) == 4


DRAWING = ("pandas", "matplotlib", "SALib", "fontTools", "typst")
READING = ("jinja2", "pydantic", "yaml")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "spared"),
    [
        (["--help"], (*DRAWING, *READING, "numpy", "scipy", "rich")),
        (["analyze"], (*DRAWING, "scipy", "distributed", "dask", "asyncio")),
    ],
)
def test_a_command_loads_what_it_needs_alone(words, spared):
    """`--help` loads no numpy, `analyze` nothing that draws, solves or distributes."""
    loaded = loaded_by(
        "import budget.cli",
        f"sys.argv = ['budget', *{words!r}]",
        "try:\n    budget.cli.main()",
        "except SystemExit:\n    pass",
    )
    assert "typer" in loaded
    assert not loaded & {*spared}


def test_a_worker_loads_nothing_that_reads_files():
    """What a worker unpickles of a calibration needs no YAML."""
    loaded = loaded_by(
        "import budget.methods.monte_carlo, budget.methods.sobol",
        "import budget.calibration.problem, budget.inputs.records",
    )
    assert "numpy" in loaded
    assert not loaded & {*DRAWING, *READING, "rich", "typer"}


def loaded_by(*lines):
    """Return the packages that a fresh process has imported after some lines."""
    code = "\n".join(
        ("import sys", *lines, "print(*{m.split('.')[0] for m in sys.modules})")
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(PACKAGE.parent)},
    )
    return {*run.stdout.splitlines()[-1].split()}
