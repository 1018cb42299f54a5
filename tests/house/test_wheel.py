"""The wheel, installed and run outside the checkout, and the checkout itself.

Every command is run from it once, watched, without a network and beside a matplotlibrc;
what it may not do there, and what it must, is asked of that one run.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import venv
from contextlib import chdir
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from zipfile import ZipFile

import pytest
from command_line import Outcome, call, checked
from places import PACKAGE, ROOT
from report.test_matplotlibrc import HOSTILE
from watching import ALONE, CALLS, DATE, HOST, NOT_MET, PERSON, watch_commands

import budget
from budget.resources import shipped

pytestmark = pytest.mark.slow  # builds and installs a wheel

CODE = """\
import json, budget
from budget.resources import shipped
print(json.dumps([budget.__file__, str(shipped("specs")), str(shipped("templates"))]))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build the wheel of this checkout, with the build backend that is installed."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [
            *(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"),
            *("--no-build-isolation", "--no-index", "--wheel-dir", folder, ROOT),
        ],
        check=True,
        capture_output=True,
    )
    (file,) = folder.glob("*.whl")
    return file


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """Install the wheel into a fresh environment and return its Python.

    The environment borrows the dependencies of this one, after its own packages, so
    that nothing is downloaded; `budget` is the wheel's.
    """
    place = tmp_path_factory.mktemp("environment") / "venv"
    venv.create(place, with_pip=False)
    base = {"base": str(place), "platbase": str(place)}
    own = Path(sysconfig.get_path("purelib", "venv", base))
    subprocess.run(
        [
            *(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps"),
            *("--no-index", "--target", own, wheel),
        ],
        check=True,
        capture_output=True,
    )
    borrowed = {sysconfig.get_path(kind) for kind in ("purelib", "platlib")}
    (own / "borrowed.pth").write_text("\n".join(sorted(borrowed)) + "\n")
    return Path(sysconfig.get_path("scripts", "venv", base)) / "python"


@pytest.fixture(scope="module")
def watched(python, tmp_path_factory):
    """Return what every command of the wheel did: one run, for all that is asked."""
    folder = tmp_path_factory.mktemp("watched")
    return watch_commands(folder, python=python, style=HOSTILE)


@dataclass(frozen=True, kw_only=True)
class Here(Outcome):
    """What a call in this process left behind, and where."""

    folder: Path


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    """Return a function that calls a command of those in this process, once each."""

    @cache
    def run(name):
        folder = tmp_path_factory.mktemp("here")
        with chdir(folder):
            outcome = call(*CALLS[name], **DATE)
        return Here(**vars(outcome), folder=folder)

    return run


def places(python, folder):
    """Return where a Python finds the package, its specs and its templates."""
    run = subprocess.run(
        [python, "-c", CODE],
        cwd=folder,
        check=True,
        capture_output=True,
        env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
    )
    return [Path(place) for place in json.loads(run.stdout)]


def content(folder):
    """Return the files below a folder by their relative names."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_wheel_holds_what_it_needs_and_no_more(wheel):
    """Specs and templates travel inside the package; tests and tools stay at home."""
    names = ZipFile(wheel).namelist()

    for needed in (
        "budget/py.typed",
        "jcgm/py.typed",
        "budget/languages/zh.po",
        "budget/_shipped/specs/devices/zhao-2019.yaml",
        "budget/_shipped/specs/references/hg4930-c.json",
        "budget/_shipped/templates/page.html.j2",
        "zhao_2019/printed.yaml",
    ):
        assert needed in names
    roots = {name.partition("/")[0] for name in names}
    about = f"sins_budget-{budget.__version__}.dist-info"
    assert roots == {"budget", "jcgm", "zhao_2019", about}
    assert not [name for name in names if "__pycache__" in name]


def test_installed_package_is_the_wheels(python, tmp_path):
    """In the fresh environment the package and all it reads are the wheel's copy."""
    package, specs, templates = places(python, tmp_path)

    assert ROOT not in package.parents
    assert python.parent.parent in package.parents
    assert specs == package.parent / "_shipped" / "specs"
    assert templates == package.parent / "_shipped" / "templates"
    assert content(specs) == content(ROOT / "specs")
    assert content(templates) == content(ROOT / "templates")


@pytest.mark.parametrize("name", ["analyze", "paper"])
def test_wheel_computes_the_same(watched, here, name):
    """From the wheel, a document and what is said are those of the checkout."""
    there, run = watched[name], here(name)

    assert (there.code, there.out, there.err) == (0, run.out, run.err)
    document = checked(json.loads((there.folder / "a.json").read_bytes()))
    assert document == json.loads((run.folder / "a.json").read_bytes())
    assert document["rows" if name == "paper" else "outputs"]


@pytest.mark.parametrize(("name", "kinds"), [("report", 2), ("paper", 4)])
def test_same_bytes_every_time_and_the_date_is_the_given_one(
    watched, here, name, kinds
):
    """With SOURCE_DATE_EPOCH, of every kind, whoever writes them and where.

    Another process, of the wheel, beside a matplotlibrc that the first says nothing of.
    """
    there, run = content(watched[name].folder), content(here(name).folder)

    assert len(there) == kinds
    assert there.keys() == run.keys()
    assert len(there["a.html"]) > 10_000
    for file, data in there.items():
        assert data == run[file], file
    assert b"D:19700102" in there["a.pdf"]
    assert b"1970-01-02" in there["a.html"]


def test_wheel_checks_its_references(watched):
    """From the wheel, every shipped reference holds, by its own copy of the inputs."""
    run = watched["check"]

    assert run.code == 0, run.out
    assert "11 references: 11 unchanged, 0 moved" in run.out


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


def test_no_system_call_to_a_network(watched):
    """Libraries that are no Python open no internet socket either."""
    for name, found in watched.items():
        if found.system_calls is None:
            pytest.skip("tracing is not allowed here")
        assert "AF_INET" not in found.system_calls, name


def test_a_machine_without_a_network(watched):
    """In a network namespace without any interface a report is written."""
    found = watched["report"]
    if not found.is_offline:
        pytest.skip("namespaces are not allowed here")
    assert found.code == 0, found.err
    assert sorted(p.name for p in found.folder.iterdir()) == ["a.html", "a.pdf"]


@pytest.mark.parametrize("name", ["report", "paper"])
def test_documents_name_no_place_and_no_person(name, watched, python):
    """No folder, user or host of the run stands in what is written."""
    found = watched[name]
    secrets = (
        *(str(found.folder), str(found.folder.parent.parent)),
        *(str(python.parent.parent), str(PACKAGE)),
        *(PERSON, HOST, os.uname().nodename),
    )
    written = list(found.folder.glob("a.*"))
    assert written
    for path in written:
        data = path.read_bytes()
        for secret in secrets:
            assert len(secret) < 4 or secret.encode() not in data, (path.name, secret)


def test_checkout_reads_its_own_specs(tmp_path):
    """Run from the checkout, specs and templates are those that people edit there.

    A copy that an editable install left behind in site-packages is not read.
    """
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{CODE}"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True
    )
    package, specs, templates = map(Path, json.loads(run.stdout))

    assert package == ROOT / "budget" / "__init__.py"
    assert (specs, templates) == (ROOT / "specs", ROOT / "templates")


def test_stale_copy_is_not_read(tmp_path, monkeypatch):
    """With a copy inside the package too, a checkout reads what stands beside it."""
    package = tmp_path / "budget"
    for folder in (tmp_path / "specs", package / "_shipped" / "specs"):
        folder.mkdir(parents=True)
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.setattr("budget.resources.PACKAGE", package)
    assert shipped("specs") == tmp_path / "specs"

    # Control: without the checkout around it, the copy inside is the one.
    (tmp_path / "pyproject.toml").unlink()
    assert shipped("specs") == package / "_shipped" / "specs"
