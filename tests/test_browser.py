"""The page in a real Chromium: it works there, loads nothing, and its numbers agree."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from math import floor, log10

import pytest
from browsing import CONTRAST, chromium, opened
from document_examples import make_document, make_table
from numpy.testing import assert_allclose
from test_page import HOSTILE, example, fill
from test_what_if import scaled

from budget import analyze, load_device, load_requirement
from budget.report.blocks import Cell, Column, RowGroup, Section, Sliders, Table
from budget.report.page import render_page
from budget.studies.what_if import what_if

ENOUGH = 4.5  # WCAG 2, 1.4.3: contrast of text with what is behind it
AGREES = 1e-9  # two programmes add up the same numbers in another order
TENFOLD = 40  # places of a slider from as it is to ten times
A4_WIDTH = 673  # what the margins leave of a sheet [px]
SIZES = (320, 400, 800, 1280, 1600)
SOURCES = ("gyro.bias_repeatability", "accelerometer.mounting_repeatability")

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


@cache
def device():
    """Return the paper's device."""
    return load_device("zhao-2019")


@cache
def requirement():
    """Return limits that some outputs pass when a source grows."""
    return load_requirement("tactical-grade")


@cache
def law():
    """Return what the page must agree with."""
    return what_if(device(), requirement=requirement())


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Provide the page of the example with a real model behind its sliders."""
    model = law().to_dict()
    sliders = Sliders(model=model, table=make_table("changes"))
    sections = tuple(
        replace(section, blocks=(sliders,)) if section.name == "what-if" else section
        for section in make_document().sections
    )
    document = make_document(
        sections=(*sections, Section(name="z", title="Z", blocks=(SORTED,)))
    )
    return written(tmp_path_factory.mktemp("page"), document)


def written(folder, document):
    """Write the page of a document to a file."""
    path = folder / "page.html"
    path.write_text(render_page(document), encoding="utf-8")
    return path


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
    bad = tmp_path / "bad.html"
    bad.write_text(
        path.read_text(encoding="utf-8").replace("<main>", f"<main>{intruder}"),
        encoding="utf-8",
    )
    with opened(browser, bad) as (page, record):
        assert page.title() != "x"
        assert len(record.complaints) == 2
        assert all("Content Security Policy" in c for c in record.complaints)


@pytest.mark.parametrize("text", HOSTILE)
def test_foreign_text_is_never_obeyed(browser, tmp_path, text):
    """With mark-up in every text nothing runs, and no element comes in."""
    page_of = {}
    for name, said in (("harmless", "plain"), ("hostile", text)):
        folder = tmp_path / name
        folder.mkdir()
        document = fill(example(), said)
        with opened(browser, written(folder, document)) as (page, record):
            assert record.complaints == []
            page_of[name] = page.evaluate(
                "[...document.querySelectorAll('*')].map((e) => e.tagName)"
            )
    assert page_of["hostile"] == page_of["harmless"]


@pytest.mark.parametrize(
    ("media", "width"), [*(("screen", size) for size in SIZES), ("print", A4_WIDTH)]
)
def test_page_does_not_scroll_sideways(browser, path, media, width):
    """What is wide scrolls by itself; the page does not, at any size or on paper."""
    with opened(browser, path, viewport={"width": width, "height": 900}) as (page, _):
        page.emulate_media(media=media)
        assert page.evaluate("document.scrollingElement.scrollWidth") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_can_be_read(browser, path, scheme):
    """Text has enough contrast with what is behind it, in figures, too."""
    with opened(browser, path, color_scheme=scheme) as (page, _):
        found = page.evaluate(CONTRAST, ENOUGH)

    assert found["texts"] > 300
    assert found["poor"] == []


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
    """`/` leads to the search, rows are counted, Escape shows all again."""
    with opened(browser, path) as (page, _):
        page.keyboard.press("/")
        page.keyboard.type("first TEN")
        shown = page.locator("#sorted tbody tr:not(.group):visible th")
        count = page.locator(".search output")

        assert shown.all_inner_texts() == ["a", "b"]
        assert page.locator("#sorted tbody").nth(1).is_hidden()
        assert count.inner_text() == "2 of 95 rows"
        page.keyboard.press("Escape")
        assert shown.count() == 6
        assert count.inner_text() == ""


def move(page, source, keys):
    """Move the slider of one source with the keyboard."""
    words = source.replace(".", " ").replace("_", " ")
    page.get_by_label(f"{words}, times its present size").focus()
    for key in keys:
        page.keyboard.press(key)


def read(page, cell):
    """Return text and exact value of one column of the what-if table, by output."""
    found = page.evaluate(
        "(cell) => [...document.querySelectorAll('.what-if tr[data-output]')].map("
        "(row) => { const c = row.querySelector(`[data-cell=${cell}]`);"
        " return [row.dataset.output, c.textContent, c.dataset.exact]; })",
        cell,
    )
    return {name: (text, float(exact)) for name, text, exact in found}


def as_number(text):
    """Read what the page writes."""
    text = text.replace("\N{MINUS SIGN}", "-").replace(" × 10", "e")  # noqa: RUF001
    return float(text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")))


@pytest.mark.parametrize(
    ("keys", "factor"),
    [
        (["ArrowRight"] * 12, 10.0 ** (12 / TENFOLD)),
        (["End"], 10.0),
        (["Home"], 0.0),
        (["ArrowLeft"] * 30, 10.0 ** (-30 / TENFOLD)),
    ],
)
@pytest.mark.parametrize("source", SOURCES)
def test_slider_agrees_with_the_analysis_of_a_changed_device(
    browser, path, source, keys, factor
):
    """U, mean and utilisation in the page are those of `analyze`, to four digits."""
    truth = analyze(
        scaled(device(), {source: factor}),
        validate=False,
        coverage=requirement().coverage,
        reference=requirement().reference,
    )
    limits = {limit.output: limit.limit for limit in requirement().limits}
    with opened(browser, path) as (page, record):
        move(page, source, keys)
        expanded, mean = read(page, "expanded"), read(page, "mean")
        used = read(page, "used")

    assert record.complaints == []
    assert len(expanded) == len(truth.outputs) == 24
    for row in truth.outputs:
        name, scale = row.output.name, row.output.si_per_unit
        half = (row.interval[1] - row.interval[0]) / 2.0 / scale
        assert_allclose(expanded[name][1], half, rtol=AGREES)
        last = 10.0 ** (floor(log10(half)) - 3)  # the fourth digit
        assert_allclose(as_number(expanded[name][0]), half, rtol=0, atol=0.51 * last)
        assert_allclose(
            mean[name][1],
            row.mean / scale,
            rtol=AGREES,
            atol=row.output.resolution / scale,
        )
        utilisation = row.largest_error / limits[name]
        assert_allclose(used[name][1], utilisation, rtol=AGREES)


def test_field_takes_the_standard_uncertainty(browser, path):
    """A number typed into the field counts as it stands, with comma or point."""
    model = law()
    wanted = model.evaluate({"gyro.bias_repeatability": 0.123 / 0.05})
    names = [output.name for output in model.outputs]
    k = names.index("gyro.bias.x")
    with opened(browser, path) as (page, _):
        field = page.get_by_label("gyro bias repeatability, standard uncertainty")
        field.fill("0,123")
        field.press("Enter")
        field.blur()
        u = read(page, "expanded")["gyro.bias.x"][1]

    expected = model.factor[k] * wanted.u[k] / model.outputs[k].si_per_unit
    assert_allclose(u, expected, rtol=AGREES)


def test_field_refuses_what_is_no_size(browser, path):
    """A word or a negative number changes nothing and says what is expected."""
    with opened(browser, path) as (page, _):
        before = read(page, "expanded")
        field = page.get_by_label("gyro bias repeatability, standard uncertainty")
        for text in ("much", "-1", ""):
            field.fill(text)
            field.blur()
            assert field.get_attribute("aria-invalid") == "true"
            assert page.get_by_text("expected a number from 0 on").is_visible()
            assert read(page, "expanded") == before


def test_verdict_follows_the_sliders(browser, path):
    """The verdict is that of the law in Python, is spoken, and can be taken back."""
    model = law()
    outlook = model.evaluate({"gyro.scale_factor_repeatability": 10.0})
    worst = {s.sensor: s for s in outlook.sensors}["gyro"]
    with opened(browser, path) as (page, _):
        said = page.locator(".outlook")
        first = said.inner_text()
        move(page, "gyro.scale_factor_repeatability", ["End"])
        then = said.inner_text()
        beyond = page.locator(".what-if tr.beyond").all_inner_texts()
        page.get_by_role("button", name="Reset all").click()
        last = said.inner_text()

    assert "Gyro: MEETS" in first
    assert worst.verdict == "fails"
    assert (
        f"Gyro: FAILS. gyro scale factor x at {100 * worst.utilisation:.0f} %" in then
    )
    assert "as it is: MEETS" in then
    assert len(beyond) == 3
    assert all("beyond" in row for row in beyond)
    assert last == first


def test_missing_line_makes_a_pass_undecidable(browser, tmp_path):
    """A sensor that would pass waits for the line that its data sheet lacks."""
    document = make_document()
    model = next(s for s in document.sections if s.name == "what-if").blocks[0].model
    model = {**model, "sensors": [{"name": "gyro", "missing": ["angle random walk"]}]}
    sliders = Sliders(model=model, table=make_table("changes"))
    page_path = written(
        tmp_path,
        make_document(sections=(Section(name="w", title="W", blocks=(sliders,)),)),
    )
    with opened(browser, page_path) as (page, _):
        said = page.locator(".outlook")
        first = said.inner_text()
        move(page, "gyro.bias_repeatability", ["End"])

        assert "Gyro: UNDECIDABLE, as angle random walk is not given" in first
        assert "Gyro: FAILS" in said.inner_text()


def test_sliders_without_a_requirement_show_uncertainties(browser, tmp_path):
    """Without limits there are no columns of utilisation and no verdict."""
    sliders = Sliders(model=what_if(device()).to_dict(), table=make_table("changes"))
    section = Section(name="w", title="W", blocks=(sliders,))
    page_path = written(tmp_path, make_document(sections=(section,)))
    with opened(browser, page_path) as (page, record):
        heads = page.locator(".what-if thead th").all_inner_texts()

        assert "No requirement" in page.locator(".outlook").inner_text()
        assert not [head for head in heads if "limit" in head]
        assert record.complaints == []


def test_page_says_the_same_without_its_script(browser, path):
    """Without JavaScript the tables stand, and nothing that would not work."""
    with opened(browser, path, java_script_enabled=False) as (page, _):
        assert page.locator("#changes").is_visible()
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
