"""The wheel, installed and run outside the checkout, and the checkout itself."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import venv
from functools import partial
from pathlib import Path
from zipfile import ZipFile

import pytest
from command_line import call, start
from places import ROOT

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
        "budget/languages/zh.po",
        "budget/_shipped/specs/devices/zhao-2019.yaml",
        "budget/_shipped/specs/references/hg4930-c.json",
        "budget/_shipped/templates/page.html.j2",
        "budget/_shipped/examples/zhao_2019/printed.yaml",
    ):
        assert needed in names
    roots = {name.partition("/")[0] for name in names}
    assert roots == {"budget", f"sins_budget-{budget.__version__}.dist-info"}
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


def test_wheel_runs_the_main_job(python, tmp_path):
    """From the wheel, analyze gives the same document as from the checkout."""
    words = ("analyze", "--no-validate", "--json", "-")
    here, there = call(*words), start(*words, cwd=tmp_path, python=python)

    assert (there.code, there.err) == (0, here.err)
    assert there.document == here.document


def test_wheel_writes_the_report(python, tmp_path, monkeypatch):
    """From the wheel, the report is the same bytes as from the checkout."""
    monkeypatch.chdir(tmp_path)
    pages = []
    for name, make in (
        ("here", call),
        ("there", partial(start, cwd=tmp_path, python=python)),
    ):
        run = make(
            *("report", "--no-validate", "-o", f"{name}.html"), SOURCE_DATE_EPOCH="0"
        )
        assert run.code == 0, run.err
        pages.append((tmp_path / f"{name}.html").read_bytes())

    assert len(pages[0]) > 10_000
    assert pages[0] == pages[1]


def test_wheel_computes_the_paper_again(python, tmp_path):
    """From the wheel, the paper's check is the same document as from the checkout."""
    words = ("paper", "--json", "-")
    here, there = call(*words), start(*words, cwd=tmp_path, python=python)

    assert (there.code, there.err) == (0, "")
    assert there.document["rows"]
    assert there.document == here.document


def test_wheel_checks_its_references(python, tmp_path):
    """From the wheel, every shipped reference holds, by its own copy of the inputs."""
    run = start("check", cwd=tmp_path, python=python)

    assert run.code == 0, run.out
    assert "11 references: 11 unchanged, 0 moved" in run.out


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
