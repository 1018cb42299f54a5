"""Real reports in a real Chromium: quiet, readable, of fitting size."""

from __future__ import annotations

import re
from functools import cache

import pytest
from browsing import CONTRAST, chromium, opened
from command_line import call
from numpy.testing import assert_allclose

from budget import analyze, load_device, load_requirement
from budget.resources import shipped

DEVICES = shipped("specs") / "devices"
NAVIGATION = shipped("specs") / "requirements" / "navigation-grade.yaml"
LARGEST = 3e6  # bytes
ENOUGH = 4.5  # WCAG 2, 1.4.3
AGREES = 1e-9  # two programmes add up the same numbers in another order
REPORTS = {
    "paper": ("paper",),
    "failing": ("report", "--requirement", NAVIGATION, "--allocate"),
    "without": ("report", "--no-validate", "--sobol", "--samples", "64"),
    "gaps": ("report", DEVICES / "stim300.yaml#10g", "--requirement", NAVIGATION),
    "compared": (
        *("compare", DEVICES / "stim300.yaml", DEVICES / "zhao-2019.yaml"),
        *("--requirement", NAVIGATION, "--trials", "2000"),
    ),
}


@pytest.fixture(scope="module")
def browser():
    """Provide the machine's Chromium."""
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Provide a function that writes one of the reports once and gives its path."""
    folder = tmp_path_factory.mktemp("reports")

    @cache
    def write(name):
        path = folder / f"{name}.html"
        run = call(*REPORTS[name], "-o", path)
        assert path.is_file(), run.err
        return path

    return write


@pytest.mark.parametrize("name", REPORTS)
def test_report_is_quiet_and_fits(browser, written, name):
    """No complaint, no request, no sideways scrolling, from telephone to desk."""
    path = written(name)
    for width in (400, 1600):
        with opened(browser, path, viewport={"width": width, "height": 900}) as (
            page,
            record,
        ):
            assert record.requests == [path.as_uri()]
            assert record.complaints == []
            assert page.evaluate("document.scrollingElement.scrollWidth") <= width
    assert path.stat().st_size < LARGEST


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", REPORTS)
def test_every_text_of_a_report_can_be_read(browser, written, name, scheme):
    """Every word has enough contrast, those in figures included."""
    with opened(browser, written(name), color_scheme=scheme) as (page, _):
        found = page.evaluate(CONTRAST, ENOUGH)

    assert found["texts"] > 300
    assert found["poor"] == []


@pytest.mark.parametrize("name", REPORTS)
def test_answer_is_above_the_fold(browser, written, name):
    """On a desk the sections of page one begin where no one has to scroll."""
    view = {"width": 1600, "height": 1000}
    with opened(browser, written(name), viewport=view) as (page, _):
        tops = page.evaluate(
            "[...document.querySelectorAll('.verdict, .first > section')]"
            ".map((e) => e.getBoundingClientRect().top)"
        )

    assert len(tops) >= 2
    assert max(tops) < view["height"]


def test_sliders_of_a_report_stand_at_its_budget(browser, written):
    """Untouched, the table beside the sliders has the numbers of `analyze`."""
    requirement = load_requirement("navigation-grade")
    truth = analyze(
        load_device("zhao-2019"),
        validate=False,
        coverage=requirement.coverage,
        reference=requirement.reference,
    )
    with opened(browser, written("failing")) as (page, _):
        shown = page.evaluate(
            "Object.fromEntries([...document.querySelectorAll('tr[data-output]')].map("
            "(r) => [r.dataset.output,"
            " Number(r.querySelector('[data-cell=expanded]').dataset.exact)]))"
        )
        said = page.locator(".outlook").inner_text()

    assert list(shown) == [row.output.name for row in truth.outputs]
    for row in truth.outputs:
        half = (row.interval[1] - row.interval[0]) / 2.0 / row.output.si_per_unit
        assert_allclose(shown[row.output.name], half, rtol=AGREES)
    assert re.match(r"Gyro: FAILS\. gyro bias z at 1480 % of its limit\.", said)
