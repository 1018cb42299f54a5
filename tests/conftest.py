"""What a test module may switch on for all its tests."""

from __future__ import annotations

import gc
import os
import re
import signal
import sys
from collections import defaultdict
from functools import wraps
from importlib import import_module
from types import FunctionType

# As the command line has it: a thread more waits for the other, spinning. What may not
# depend on their number is run with several by .ci/kernels. It is read as numpy is
# imported, so it stands before all that imports it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from keeping import Variates, once

from budget import question
from budget.methods import execution
from budget.report.figures import rows, style, tabled
from budget.settings import Engine
from budget.studies import analysis
from budget.studies.allocation import allocate
from budget.studies.allocation.longer_tests import find_longer_tests

# Tests are interrupted also where whoever runs them is not, as in the background.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# A worker more than processors: while one waits for a process, another goes on.
MORE_WORKERS = 1


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return what `-n auto` means."""
    return (os.cpu_count() or 1) + MORE_WORKERS


def pytest_ignore_collect(collection_path, config) -> bool | None:
    """Leave out a module of which `-m` asks for no test: nothing is imported.

    For `-m mark` one without the mark, for `-m 'not mark'` one that is marked as a
    whole. Of any other expression every module is collected.
    """
    negated, mark = re.fullmatch(r"(not )?(\w*)|.*", config.option.markexpr).groups()
    if not mark or not collection_path.match("test_*.py"):
        return None
    text = collection_path.read_text(encoding="utf-8")
    if negated:
        whole = rf"^pytestmark = (\[[^]]*)?pytest\.mark\.{mark}\b"
        return True if re.search(whole, text, re.MULTILINE) else None
    return None if f"pytest.mark.{mark}" in text else True


def pytest_collection_finish() -> None:
    """Let the garbage collector pass over what will be there to the end."""
    gc.freeze()


# What takes long alone is begun first, that no core waits for it at the end. A worker
# takes from the end of what another has: the tests of the first module stay together,
# whose one run of all commands each worker would make for itself.
LONG = ("test_wheel", "test_processors", "test_least_squares", "test_cost")
LONG += ("test_readme", "test_budgets", "test_missions", "test_docs")
LONG += ("test_of_both", "test_prediction")


def pytest_collection_modifyitems(items) -> None:
    """Put the modules with the longest tests first, the others as they are."""
    places = {name: place for place, name in enumerate(LONG)}
    items.sort(key=lambda item: places.get(item.path.stem, len(LONG)))


# Who draws the figures of every kind of report.
PAGES = ("analysis.build", "comparison.page", "allocation")
PAGES = (*(f"budget.report.{page}" for page in PAGES), "zhao_2019.page")
DRAWN: dict = {}


@pytest.fixture(scope="module")
def drawn_once():
    """Draw a figure once, however many reports have it: two thirds of their time.

    For modules that ask what reports say. That the same figure is drawn the same is
    asked elsewhere.
    """
    for page in PAGES:
        import_module(page)
    modules = [
        module
        for name, module in sys.modules.items()
        if name.startswith(("budget.report", "zhao_2019"))
    ]
    found = [
        (module, name, value)
        for module in modules
        for name, value in vars(module).items()
        if name.endswith("_picture")
        and name != "as_picture"
        and isinstance(value, FunctionType)
        and not name.startswith("_")
    ]
    assert found
    with pytest.MonkeyPatch.context() as patch:
        for module, name, value in found:
            patch.setattr(module, name, once(value, DRAWN))
        yield


@pytest.fixture(scope="module")
def not_drawn():
    """Leave every figure blank, for modules that ask what stands beside them."""

    def blank(_, *, name):
        return f'<svg id="{name}" viewBox="0 0 9 9"/>'

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tabled.Plot, "figure", None)
        patch.setattr(rows, "draw", lambda _: None)
        patch.setattr(style, "to_svg", blank)
        yield


@pytest.fixture(scope="session", autouse=True)
def searched_once():
    """Search for a longer test once for each sensor, procedure and limits.

    It is two thirds of the time of an allocation, which dozens of tests ask for.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(allocate, "find_longer_tests", once(find_longer_tests, {}))
        yield


ANALYZED: dict = {}


@pytest.fixture(scope="module")
def analyzed_once():
    """Compute a budget or an allocation once, in however many forms it is told.

    For modules that ask what is said of it; nothing is said while it is computed.
    """

    def kept(function):
        @wraps(function)
        def silent(*args, **options):
            return function(*args, engine=Engine(), **options)

        computed = once(silent, ANALYZED)

        def talking(*args, engine=None, **options):
            del engine  # no two calls have the same
            return computed(*args, **options)

        return talking

    with pytest.MonkeyPatch.context() as patch:
        for module, name in ((analysis, "analyze_as"), (allocate, "allocate_as")):
            patch.setattr(module, name, kept(getattr(module, name)))
        yield


VARIATES = Variates()


@pytest.fixture(scope="module", autouse=True)
def variates_once(request):
    """Draw the same variates of a source once, but where the drawing is asked."""
    kept = {} if request.path.parent.name == "methods" else VARIATES.patches()
    with pytest.MonkeyPatch.context() as patch:
        for name, function in kept.items():
            patch.setattr(execution, name, function)
        yield


@pytest.fixture
def nothing_is_missing(monkeypatch):
    """Leave out which lines that are not given could widen an output: it is no number.

    That takes as long as the numbers; test_expected asks it.
    """
    monkeypatch.setattr(analysis, "could_widen", lambda *_, **__: {})
    for name in ("lacking", "lacking_of_mission"):
        monkeypatch.setattr(question, name, lambda *_, **__: defaultdict(tuple))


@pytest.fixture
def forget_drawings():
    """Return what makes the next report draw all its figures anew."""
    return DRAWN.clear
