"""Of thousands of devices few are in memory: what is said of them is the same."""

from __future__ import annotations

import errno
import gc
from io import StringIO

import pytest
from keeping import catalogue
from rich.console import Console

from budget import spooled
from budget.documents import document
from budget.errors import BudgetError
from budget.inputs import load_devices
from budget.report.comparison.page import comparison_answer, comparison_document
from budget.report.comparison.tables import to_csv
from budget.report.document import json_pieces
from budget.report.page import render_page
from budget.report.terminal import TerminalPage, print_sections
from budget.spooled import Lazy, SpooledList, chained
from budget.studies.comparison.compare import compare
from budget.studies.comparison.records import Entrant

FEW = 3  # in memory


@pytest.fixture
def few(monkeypatch):
    """Let few records stay in memory."""
    monkeypatch.setattr(spooled, "IN_MEMORY", FEW)


@pytest.mark.usefixtures("few")
def test_what_is_beyond_memory_is_read_back():
    """Items, slices and both ends, in any order; what is short is a tuple."""
    found = SpooledList({"place": place} for place in range(8))

    assert [one["place"] for one in found] == [*range(8)]
    assert found[-1] == {"place": 7}
    assert [one["place"] for one in found[6:1:-2]] == [6, 4, 2]
    assert found[0] is found[0]
    assert found[5] is not found[5]
    assert found.held() is found
    assert found[:FEW].held() == tuple({"place": place} for place in range(FEW))
    assert [*chained([(1, 2), found[6:]])] == [1, 2, {"place": 6}, {"place": 7}]
    with pytest.raises(IndexError):
        found[8]


@pytest.mark.usefixtures("few")
def test_no_room_for_temporary_files_is_said(monkeypatch):
    """Once, with what to do; where all is in memory none is asked for."""

    def refuse():
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(spooled, "TemporaryFile", refuse)
    found = SpooledList(range(FEW))
    with pytest.raises(BudgetError, match=r"No space left on device.*TMPDIR"):
        found.append(FEW)


def written(found):
    """Return everything that is said of a comparison."""
    text = StringIO()
    for full in (False, True):
        page = TerminalPage(Console(file=text, width=80))
        print_sections(comparison_answer(found, full=full), page)
    page = comparison_document(found, date="2026-01-01")
    return {
        "json": "".join(json_pieces(document(found))),
        "csv": "".join(to_csv(found)),
        "terminal": text.getvalue(),
        "page": render_page(page),
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("requirement", "given"),
    [
        ("catalogue-edge", {}),
        ("catalogue-edge", {"missing": "predict", "pairs": True}),
        ("survey-drone", {"mission": "ship"}),
    ],
)
def test_all_that_is_said_is_the_same(monkeypatch, requirement, given):
    """JSON, CSV, terminal and page, with few records in memory and with all."""
    asked = {"method": "gum", **given}
    devices = catalogue()[:14]
    whole = written(compare(devices, requirement, **asked))
    monkeypatch.setattr(spooled, "IN_MEMORY", FEW)
    found = compare(load_devices(devices), requirement, **asked)

    assert isinstance(found.devices, Lazy)
    assert written(found) == whole


@pytest.mark.slow
def test_of_what_is_judged_by_the_law_few_stay(monkeypatch):
    """As many verdicts as a list keeps, of what was found and of what is ranked."""
    monkeypatch.setattr(spooled, "IN_MEMORY", FEW)
    devices = load_devices(catalogue()[:30])
    found = compare(devices, "catalogue-edge", method="gum")
    gc.collect()

    assert isinstance(devices, Lazy)
    assert len(found.devices) > 10 * FEW
    assert sum(isinstance(one, Entrant) for one in gc.get_objects()) <= 4 * FEW
