"""What the package rests on: declared, bounded on both sides, locked by name."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions, version

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version
from places import EXAMPLE, ROOT, SHIPPED, nodes_of

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
NEEDED = PROJECT["project"]["dependencies"]
EXTRAS = PROJECT["project"]["optional-dependencies"]
BUILD = PROJECT["build-system"]["requires"]
DECLARED = [*NEEDED, *(text for extra in EXTRAS.values() for text in extra), *BUILD]
LOCK = (ROOT / "requirements-dev.txt").read_text(encoding="utf-8")
# One entry: 'name==version ; marker --hash=sha256:... --hash=sha256:...'.
ENTRIES = [
    line for line in LOCK.replace("\\\n", " ").splitlines() if not line.startswith("#")
]
PINS = [line.split()[0] for line in ENTRIES]


def names(requirements):
    """Return the normal names of some requirements."""
    return {canonicalize_name(Requirement(text).name) for text in requirements}


@cache
def imported():
    """Return the distributions that the package imports, standard library apart."""
    modules = set()
    for path in SHIPPED:
        for node in nodes_of(path):
            if isinstance(node, ast.Import):
                modules |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                modules.add(node.module.split(".")[0])
    # Type checkers bring _typeshed; nothing imports it at run time.
    outside = modules - sys.stdlib_module_names - {"budget", EXAMPLE.name, "_typeshed"}
    where = packages_distributions()
    return {canonicalize_name(name) for module in outside for name in where[module]}


def test_every_dependency_has_a_lower_and_an_upper_bound():
    """An old release that is not known to work, or one to come, is not installed."""
    assert [
        text
        for text in DECLARED
        if {clause.operator for clause in Requirement(text).specifier} != {">=", "<"}
    ] == []


def test_what_is_installed_is_within_the_bounds():
    """These tests run with releases that the bounds allow."""
    installed = {text: version(Requirement(text).name) for text in NEEDED}
    assert [
        f"{text}: {found}"
        for text, found in installed.items()
        if Version(found) not in Requirement(text).specifier
    ] == []


def test_what_is_imported_is_declared():
    """The package imports nothing that only another package happened to bring."""
    assert imported() <= names(
        [*NEEDED, *EXTRAS["dask"], *EXTRAS["xlsx"], *EXTRAS["parquet"]]
    )


def test_what_is_declared_is_imported():
    """Nothing is installed for users that the package does not use."""
    assert names(NEEDED) <= imported()


def test_python_is_bounded():
    """The Pythons that are promised are those that the classifiers name."""
    assert PROJECT["project"]["requires-python"] == ">=3.11,<3.14"
    listed = [
        text for text in PROJECT["project"]["classifiers"] if "Python :: 3" in text
    ]
    assert [text.rpartition(" ")[2] for text in listed] == ["3.11", "3.12", "3.13"]


def test_the_lock_holds_names_versions_and_hashes_alone():
    """No address of an index, no folder, no open range, no entry without a hash."""
    pin = r"[a-z0-9]+(-[a-z0-9]+)*==[0-9][0-9A-Za-z.]*"
    marker = r"( ; [a-z_]+ [=!<>]+ '[A-Za-z0-9.]+'( (and|or) [a-z_]+ [=!<>]+ '\S+')*)?"
    hashes = r"( +--hash=sha256:[0-9a-f]{64})+"
    entry = re.compile(pin + marker + hashes)
    assert [line for line in ENTRIES if not entry.fullmatch(line)] == []
    hashed = f"--hash=sha256:{'0' * 64}"
    assert entry.fullmatch(f"x==1 {hashed}")
    for fault in (f"x>=1 {hashed}", f"x @ https://example.org/x {hashed}", "x==1"):
        assert not entry.fullmatch(fault)


def test_the_lock_holds_every_direct_dependency_within_its_bounds():
    """What the tests have run with is what pyproject.toml allows."""
    pinned = dict(line.split("==") for line in PINS)
    assert len(pinned) == len(PINS)
    for text in DECLARED:
        requirement = Requirement(text)
        locked = pinned[canonicalize_name(requirement.name)]
        assert Version(locked) in requirement.specifier, text


def test_the_run_with_the_lowest_versions_reads_the_bounds():
    """.ci/lowest asks for the lower bound of every dependency, none left out."""
    script = (ROOT / ".ci" / "lowest").read_text(encoding="utf-8")
    (pattern,) = re.findall(r're\.sub\(r"([^"]+)"', script)
    lowest = [re.sub(pattern, r"==\1", text) for text in NEEDED]
    for text, declared in zip(lowest, NEEDED, strict=True):
        assert re.fullmatch(r"[A-Za-z0-9.-]+==[0-9.]+", text)
        assert Requirement(text).specifier != Requirement(declared).specifier


def test_every_run_installs_the_lock_by_its_hashes():
    """.ci/run takes nothing whose hash is not that of what was tested."""
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "pip install -q --require-hashes -r requirements-dev.txt" in script
    assert "pip install -q --no-deps --no-build-isolation ." in script


def test_licences_are_listed():
    """Every package that users get names its licence."""
    run = subprocess.run(
        [sys.executable, str(ROOT / ".ci" / "licences")],
        capture_output=True,
        text=True,
        check=False,
    )
    if "is not installed here" in run.stderr:
        pytest.skip(run.stderr.strip())
    assert run.returncode == 0, run.stderr
    said = dict(line.split(": ", 1) for line in run.stdout.splitlines())
    listed = {name.split()[0] for name in said}
    assert names(NEEDED) <= listed
    assert all(said.values())
