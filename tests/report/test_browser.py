"""The page in a real Chromium: it works there, loads nothing, and its numbers agree."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import fields, is_dataclass, replace
from functools import cache

import pytest
from browsing import CONTRAST, axe_core, chromium, opened, written
from command_line import call
from numpy.testing import assert_allclose
from places import put
from reading import assert_says
from report.test_page import HOSTILE, example, fill

from budget import analyze, load_device, load_requirement
from budget.report.blocks import Cell, Column, RowGroup, Section, Table
from budget.report.formulas import Math
from budget.resources import shipped

pytestmark = pytest.mark.slow

ENOUGH = 4.5  # WCAG 2, 1.4.3: contrast of text with what is behind it
A4_WIDTH = 673  # what the margins leave of a sheet [px]
SIZES = (320, 400, 800, 1280, 1600)

SORTED = Table(
    name="sorted",
    caption="Rows to sort",
    columns=(
        Column(head="row"),
        Column(head="u", kind="number"),
        Column(head="said"),
    ),
    groups=(
        RowGroup(
            title="first group",
            rows=(
                (Cell(text="a"), Cell(text="9", exact=9.0), Cell(text="ten 10")),
                (Cell(text="b"), Cell(text="1e-12", exact=1e-12), Cell(text="ten 9")),
                (Cell(text="c"), Cell(text="10", exact=10.0), Cell(text="same")),
                (Cell(text="d"), Cell(text="none"), Cell(text="same")),
            ),
        ),
        RowGroup(
            title="second group",
            rows=(
                (Cell(text="e"), Cell(text="2", exact=2.0), Cell(text="x")),
                (Cell(text="f"), Cell(text="-3", exact=-3.0), Cell(text="<b>y</b>")),
            ),
        ),
    ),
    searchable=True,
)


@pytest.fixture(scope="module")
def browser():
    """Provide the machine's Chromium."""
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Provide the page of the example, with a table to sort."""
    section = Section(name="z", title="Z", blocks=(SORTED,))
    document = example(sections=(*example().sections, section))
    return written(tmp_path_factory.mktemp("page"), document)


def test_page_loads_in_silence(browser, path):
    """Nothing is asked for but the file itself, and the console stays empty."""
    with opened(browser, path) as (_, record):
        assert record.requests == [path.as_uri()]
        assert record.complaints == []


def test_policy_keeps_everything_out(browser, path, tmp_path):
    """Control: a picture and a script that are put in are refused and complained of."""
    intruder = (
        '<img src="https://example.org/x.png"><script>document.title="x"</script>'
    )
    bad = put(
        tmp_path / "bad.html",
        path.read_text(encoding="utf-8").replace("</header>", f"</header>{intruder}"),
    )
    with opened(browser, bad) as (page, record):
        assert page.title() != "x"
        assert len(record.complaints) == 2
        assert all("Content Security Policy" in c for c in record.complaints)


def shorter(part):
    """Return a document with two rows of each group: all others are set as they are."""
    if isinstance(part, tuple):
        return tuple(map(shorter, part))
    if isinstance(part, RowGroup):
        return replace(part, rows=part.rows[:2])
    if is_dataclass(part) and not isinstance(part, Math):
        names = [field.name for field in fields(part)]
        return replace(part, **{name: shorter(getattr(part, name)) for name in names})
    return part


def elements_with(browser, folder, text):
    """Return the elements of the example's page with one text in all places."""
    path = written(folder, fill(shorter(example()), text))
    with opened(browser, path) as (page, record):
        assert record.complaints == []
        return page.evaluate(
            "[...document.querySelectorAll('*')].map((e) => e.tagName)"
        )


def test_foreign_text_is_never_obeyed(browser, tmp_path):
    """With mark-up in every text nothing runs, and no element comes in."""
    harmless = elements_with(browser, tmp_path, "plain")
    for text in HOSTILE:
        assert elements_with(browser, tmp_path, text) == harmless, text


def assert_no_sideways(page, width, *, media="screen"):
    """Assert that the page is no wider than a window, or a sheet."""
    page.set_viewport_size({"width": width, "height": 900})
    page.emulate_media(media=media)
    wide = page.evaluate("document.scrollingElement.scrollWidth")
    assert wide <= width, (width, media)


def test_page_does_not_scroll_sideways(browser, path):
    """What is wide scrolls by itself; the page does not, at any size or on paper."""
    with opened(browser, path) as (page, _):
        for width in SIZES:
            assert_no_sideways(page, width)
        assert_no_sideways(page, A4_WIDTH, media="print")


def test_words_without_end_break(browser, tmp_path):
    """A name of hundreds of letters widens no page, wherever it stands."""
    document = fill(example(), "Wortungetüm" * 30)
    with opened(browser, written(tmp_path, document)) as (page, _):
        for width in (400, 1600):
            assert_no_sideways(page, width)


def assert_can_be_read(page):
    """Assert that all text has enough contrast, in both schemes of colours."""
    behind = []
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        found = page.evaluate(CONTRAST, ENOUGH)
        assert found["texts"] > 200, scheme
        assert found["poor"] == [], scheme
        behind.append(page.evaluate("getComputedStyle(document.body).backgroundColor"))
    assert len({*behind}) == 2


def test_every_text_can_be_read(browser, path):
    """Text has enough contrast with what is behind it, in figures, too."""
    with opened(browser, path) as (page, _):
        assert_can_be_read(page)


def test_the_check_of_contrast_can_fail(browser, path):
    """Control: grey words on a page, and pale ones on a bar, are found."""
    with opened(browser, path) as (page, _):
        page.evaluate(
            "document.querySelector('h1').style.color = '#999';"
            "for (const e of document.querySelectorAll('svg text'))"
            "  e.style.fill = '#ddd';"
        )
        poor = page.evaluate(CONTRAST, ENOUGH)["poor"]

    assert any("Zhao" in text for text in poor)
    assert any("77 %" in text for text in poor)


def column(page, place):
    """Return one column of the table to sort, group by group."""
    return page.evaluate(
        "(place) => [...document.getElementById('sorted').tBodies].map((body) =>"
        " [...body.rows].slice(1).map((r) => r.cells[place].textContent).join(' '))",
        place,
    )


def test_numbers_are_sorted_by_their_exact_values(browser, path):
    """Up, down and as it was, within each group; what is no number comes last."""
    with opened(browser, path) as (page, _):
        head = page.locator("#sorted thead th").nth(1)
        orders = []
        for _ in range(3):
            head.get_by_role("button").click()
            orders.append((head.get_attribute("aria-sort"), column(page, 0)))

    assert orders == [
        ("ascending", ["b a c d", "f e"]),
        ("descending", ["d c a b", "e f"]),
        (None, ["a b c d", "e f"]),
    ]


def test_texts_are_sorted_as_people_do(browser, path):
    """Numbers in texts count as numbers, equal texts keep their order."""
    with opened(browser, path) as (page, _):
        button = page.locator("#sorted thead th").nth(2).get_by_role("button")
        button.focus()
        page.keyboard.press("Enter")

        assert column(page, 2)[0] == "same same ten 9 ten 10"
        assert column(page, 0)[0] == "c d b a"


def test_search_shows_the_rows_with_all_words(browser, path):
    """`/` leads to the search of every open table; Escape shows all rows again."""
    with opened(browser, path) as (page, _):
        page.keyboard.press("/")
        page.keyboard.type("first TEN")
        shown = page.locator("#sorted tbody tr:not(.group):visible th")
        count = page.locator(".search output")

        assert shown.all_inner_texts() == ["a", "b"]
        assert page.locator("#sorted tbody").nth(1).is_hidden()
        assert count.inner_text() == "2 of 106 rows"
        page.keyboard.press("Escape")
        assert shown.count() == 6
        assert count.inner_text() == ""


def test_page_says_the_same_without_its_script(browser, path):
    """Without JavaScript the tables stand, and nothing that would not work."""
    with opened(browser, path, java_script_enabled=False) as (page, _):
        assert page.locator("#what-if-table").is_visible()
        assert page.locator("#sorted").is_visible()
        assert page.locator(".what-if").is_hidden()
        assert page.locator(".search").is_hidden()
        assert page.locator("thead button").count() == 0


@pytest.mark.parametrize("size", ["A4", "Letter"])
def test_page_prints(browser, path, tmp_path, size):
    """On paper heads repeat on every page, pages are numbered, sliders stay away."""
    with opened(browser, path) as (page, _):
        data = page.pdf(format=size, prefer_css_page_size=True, print_background=True)

    pages = len(re.findall(rb"/Type\s*/Page\b", data))
    assert pages >= 4
    if shutil.which("pdftotext") is None:
        return  # what follows reads the text back
    (tmp_path / "page.pdf").write_bytes(data)
    text = subprocess.run(
        ["pdftotext", "-layout", "page.pdf", "-"],
        cwd=tmp_path,
        capture_output=True,
        check=True,
    ).stdout.decode()
    sheets = text.split("\f")[:-1]
    assert len(sheets) == pages
    assert "Reset all" not in text
    for number, sheet in enumerate(sheets, start=1):
        assert "Zhao 2019 optical IMU: FAILS tactical grade" in sheet
        assert f"{number} of {pages}" in sheet
        if re.search(r"^ *source \d+ ", sheet, re.MULTILINE):
            assert re.search(r"where it comes from", sheet)
    assert len(re.findall(r"^ *source \d+ ", text, re.MULTILINE)) == 89


# ---- real reports: quiet, readable, of fitting size ----------------------------------

DEVICES = shipped("specs") / "devices"
NAVIGATION = shipped("specs") / "requirements" / "navigation-grade.yaml"
LARGEST = 3e6  # bytes
AGREES = 1e-9  # two programmes add up the same numbers in another order
REPORTS = {
    "paper": ("paper",),
    "without": (
        *("report", "--no-validate", "--sobol", "--samples", "64"),
        *("--station", "granite-plate-cube"),
    ),
    "gaps": ("report", DEVICES / "stim300.yaml#10g", "--requirement", NAVIGATION),
    "compared": (
        *("compare", DEVICES / "stim300.yaml", DEVICES / "zhao-2019.yaml"),
        *("--requirement", NAVIGATION, "--trials", "2000"),
    ),
    # Last: a test more asks for it.
    "failing": ("report", "--requirement", NAVIGATION, "--allocate"),
}


@pytest.fixture(scope="module")
def report(tmp_path_factory):
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
def test_report_is_quiet_fits_and_can_be_read(browser, report, name):
    """No complaint, no request, no sideways scrolling, from telephone to desk.

    Every word has enough contrast, those in figures included. On a desk the sections of
    page one begin where no one has to scroll.
    """
    path = report(name)
    assert path.stat().st_size < LARGEST
    with opened(browser, path, width=400) as (page, record):
        for width in (400, 1600):
            assert_no_sideways(page, width)
        tops = page.evaluate(
            "[...document.querySelectorAll('.verdict, .first > section')]"
            ".map((e) => e.getBoundingClientRect().top)"
        )
        assert len(tops) >= 2
        assert max(tops) < 1000
        assert_can_be_read(page)
        assert record.requests == [path.as_uri()]
        assert record.complaints == []


# What else a telephone must show, of a page without its details open.
ON_A_TELEPHONE = """() => {
  const shown = (e) => e.getClientRects().length > 0;
  const small = [...document.querySelectorAll(".drawing svg")].filter(shown).flatMap(
    (svg) => [...svg.querySelectorAll("text")].filter((text) =>
      parseFloat(getComputedStyle(text).fontSize) * svg.getBoundingClientRect().width
        / svg.viewBox.baseVal.width < 9.3).map((text) => text.textContent));
  const cut = [...document.querySelectorAll(".drawing")].filter(shown).filter((box) =>
    box.scrollWidth > box.clientWidth).map((box) => box.parentElement.id);
  const touched = document.querySelectorAll("nav a, button, summary, input, select");
  const targets = [...touched].filter(shown).filter((e) => {
      const { width, height } = e.getBoundingClientRect();
      return Math.min(width, height) < 24;
    }).map((e) => e.outerHTML);
  const heads = [...document.querySelectorAll("thead th")].filter((head) => shown(head)
    && ["verdict", "of the limit [%]"].includes(head.textContent.trim()));
  const hidden = heads.filter((head) =>
    head.getBoundingClientRect().right > innerWidth)
    .map((head) => head.closest("table").id);
  const sizes = ["h1", "h2:not(.word)", "h3", "p"].map((tag) =>
    parseFloat(getComputedStyle(document.querySelector(tag)).fontSize));
  return { small, cut, targets, hidden, heads: heads.length, sizes };
}"""


@pytest.mark.parametrize("name", REPORTS)
def test_report_is_open_to_everybody(browser, report, name):
    """Axe-core finds no violation, on a telephone and on a desk, all details open."""
    script = axe_core()
    found = {}
    with opened(browser, report(name), bypass_csp=True) as (page, _):
        page.evaluate(
            "document.querySelectorAll('details').forEach(d => d.open = true)"
        )
        page.evaluate(script)
        for width in (400, 1280):
            page.set_viewport_size({"width": width, "height": 900})
            # Contrast is looked at above: in figures, and in both schemes.
            run = page.evaluate(
                "axe.run({resultTypes: ['violations'],"
                " rules: {'color-contrast': {enabled: false}}})"
            )
            assert len(run["passes"]) > 20
            found |= {(width, one["id"]): one["nodes"] for one in run["violations"]}
    assert found == {}


def test_the_check_by_axe_can_fail(browser, path):
    """Control: a box that scrolls and cannot be reached, and a head without a name."""
    script = axe_core()
    with opened(browser, path, bypass_csp=True) as (page, _):
        page.set_viewport_size({"width": 400, "height": 900})
        page.evaluate(
            "document.querySelectorAll('.scroll').forEach((e) =>"
            " { e.removeAttribute('tabindex'); e.role = 'presentation'; });"
            "document.querySelector('#sorted thead th').textContent = ''"
        )
        page.evaluate(script)
        run = page.evaluate("axe.run({resultTypes: ['violations']})")
    ids = {one["id"] for one in run["violations"]}
    assert {"scrollable-region-focusable", "empty-table-header"} <= ids


@pytest.mark.parametrize("name", ["compared", "failing"])
def test_report_can_be_read_on_a_telephone(browser, report, name):
    """Figures fit with words of 7 pt, a finger finds what it may touch.

    Verdicts are in sight, headings show their level.
    """
    with opened(browser, report(name), width=400) as (page, _):
        seen = page.evaluate(ON_A_TELEPHONE)
        page.set_viewport_size({"width": 320, "height": 900})
        narrower = page.evaluate(ON_A_TELEPHONE)

    assert seen["small"] == narrower["small"] == []
    assert seen["cut"] == []
    assert seen["targets"] == narrower["targets"] == []
    assert seen["heads"] > 0
    assert seen["hidden"] == []
    assert seen["sizes"] == sorted({*seen["sizes"]}, reverse=True)


FOLDED = (
    "[...document.querySelectorAll('#folded tbody .more')]"
    ".map((cell) => cell.checkVisibility())"
)


def test_folded_columns_stand_below_their_row_after_a_tap(browser, tmp_path):
    """A telephone has them below, with their heads; a desk beside; no script: below."""
    columns = (
        Column(head="row"),
        Column(head="how", when_narrow="more"),
        Column(head="u", kind="number"),
        Column(head="of", when_narrow="more"),
    )
    rows = [tuple(Cell(text=text) for text in row) for row in ("abcd", "efgh")]
    table = Table(
        name="folded", caption="F", columns=columns, groups=(RowGroup(rows=(*rows,)),)
    )
    section = Section(name="z", title="Z", blocks=(table,))
    path = written(tmp_path, example(sections=(section,)))
    with opened(browser, path, width=400) as (page, _):
        assert page.evaluate(FOLDED) == [False] * 4
        page.locator("#folded tbody button").first.click()
        assert page.evaluate(FOLDED) == [True, True, False, False]
        page.set_viewport_size({"width": 1280, "height": 900})
        page.locator("#folded tbody button").first.wait_for(state="detached")
        assert page.evaluate(FOLDED) == [True] * 4
        assert page.locator("#folded tbody th").all_inner_texts() == ["a", "e"]
    with opened(browser, path, width=400, java_script_enabled=False) as (page, _):
        assert page.locator("#folded tbody .more").first.is_visible()
        tops = [
            page.locator(f"#folded tbody {kind}").first.bounding_box()["y"]
            for kind in (".number", ".more")
        ]
        assert tops[0] < tops[1]


def test_tab_stops_at_boxes_that_scroll_alone(browser, path):
    """A box is a stop of the Tab key where it hides something, and nowhere else."""
    stops = (
        "[...document.querySelectorAll('.scroll')].filter((e) => e.checkVisibility())"
        ".map((e) => [e.scrollWidth > e.clientWidth || e.scrollHeight > e.clientHeight,"
        " e.tabIndex])"
    )
    with opened(browser, path) as (page, _):
        for width in (320, 1600):
            page.set_viewport_size({"width": width, "height": 900})
            page.evaluate("new Promise((done) => setTimeout(done, 100))")
            for scrolls, index in page.evaluate(stops):
                assert index == (0 if scrolls else -1), width
        page.goto(f"{path.as_uri()}#")
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.className") == "skip"
        page.keyboard.press("Enter")
        assert page.evaluate("document.activeElement.id") == "main"


def test_sliders_of_a_report_stand_at_its_budget(browser, report):
    """Untouched, the table beside the sliders has the numbers of `analyze`."""
    requirement = load_requirement("navigation-grade")
    truth = analyze(
        load_device("zhao-2019"),
        validate=False,
        coverage=requirement.coverage,
        reference=requirement.reference,
    )
    with opened(browser, report("failing")) as (page, _):
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
    assert said.startswith("Gyro: FAILS")
    assert_says(said, "gyro bias z at 1480 % of its limit")
