"""The report as a page."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from html import unescape
from html.parser import HTMLParser

import pytest
from report_examples import (
    ACCELEROMETER,
    GYRO,
    make_assessment,
    make_budget,
    make_device,
    make_output,
    make_outputs,
    make_procedure,
)

from budget.report.html import render_html
from budget.report.markup import bind, css_string, number_markup
from budget.report.tables import group_tables

EVIL = "<script>alert(1)</script>"
VOID = {"meta", "br", "img", "link", "input", "hr"}


class Page(HTMLParser):
    """Reads a page: its elements, its text, and whether its tags are balanced."""

    def __init__(self, text):
        super().__init__()
        self.elements = []
        self.open = []
        self.text = {}
        self.cells = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        """Note an element and that it is open."""
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)
        if tag in {"td", "th"}:
            self.cells.append("")

    def handle_startendtag(self, tag, attrs):
        """Note an element that closes itself."""
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        """Close the element that was opened last."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Gather the text of elements and of table cells."""
        where = self.open[-1] if self.open else ""
        self.text[where] = self.text.get(where, "") + data
        if self.cells and {"td", "th"} & set(self.open):
            self.cells[-1] += data

    def attributes(self, name):
        """Return all values of one attribute."""
        return [attrs[name] for _, attrs in self.elements if name in attrs]


@cache
def example_page():
    """Render the example once for all tests that only read it."""
    return render(make_budget())


@cache
def example_failing():
    """Render the example against limits that it fails, once."""
    budget = make_budget()
    return render(budget, assessment=make_assessment(budget))


def render(budget=None, *, assessment=None, name="Zhao 2019 optical IMU", **procedure):
    """Render a page with the example device and procedure."""
    return render_html(
        budget or make_budget(),
        devices=(make_device(name),),
        procedure=make_procedure(**procedure),
        assessment=assessment,
        date="2026-11-21",
    )


def plain(html):
    """Return the words of a page with single ordinary spaces."""
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", html)).split())


def test_page_is_the_same_twice():
    """The same budget gives the same bytes."""
    budget = make_budget()

    again = render(budget, assessment=make_assessment(budget))

    assert again == example_failing()


def test_tags_are_balanced():
    """Every element that is opened is closed, in order."""
    assert Page(example_failing()).open == []


@pytest.mark.parametrize("attribute", ["src", "href", "xlink:href", "action", "data"])
def test_page_loads_nothing(attribute):
    """No address on the page leads anywhere but into the page."""
    targets = Page(example_failing()).attributes(attribute)

    assert all(target.startswith("#") for target in targets)


def test_style_loads_nothing():
    """The style sheet fetches neither fonts nor pictures."""
    page = example_failing()

    assert "@import" not in page
    assert "http:" not in page
    assert "https:" not in page
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)", page))


def test_hostile_names_stay_text():
    """Mark-up in names of devices, lines and notes is shown, never obeyed."""
    budget = make_budget(
        title=EVIL,
        assumptions=(EVIL,),
        warnings=(f"{EVIL}<img src=x onerror=y>",),
        not_given=(f"gyro.{EVIL}",),
    )
    assessment = replace(make_assessment(budget), requirement=EVIL)
    page = Page(render(budget, assessment=assessment, name=EVIL))

    scripts = [attrs for tag, attrs in page.elements if tag == "script"]
    assert [attrs["type"] for attrs in scripts] == ["application/json"]
    assert "img" not in {tag for tag, _ in page.elements}
    assert css_string(f"{EVIL}: FAILS {EVIL}, 2026-11-21") in page.text["style"]
    assert page.text["h1"] == EVIL


def test_embedded_document_is_the_budget():
    """The JSON in the page is the JSON document, whatever the names hold."""
    budget = make_budget(title=f"</script>{EVIL} & <!-- µ")
    document = json.loads(Page(render(budget)).text["script"])

    assert document["title"] == budget.title
    assert document["outputs"] == budget.to_dict()["outputs"]


def test_every_source_of_every_output_stands_in_the_tables():
    """The exact u and share of each source are on the page, at a row with its name."""
    budget = make_budget()
    page = Page(render(budget))
    titles = set(page.attributes("title"))

    for group in group_tables(budget):
        for source in group.sources:
            assert source.title in page.cells
            for cell in source.cells:
                assert str(cell.u.exact) in titles
                assert str(cell.share.exact) in titles


def test_every_figure_has_its_data_as_a_table():
    """Each number in the words of a figure stands in a table cell, too."""
    page = Page(example_failing())
    figures = [attrs["aria-label"] for tag, attrs in page.elements if tag == "svg"]
    cells = {cell.replace("\N{NO-BREAK SPACE}", " ") for cell in page.cells}
    shown = cells | {f"{cell} %" for cell in cells}

    assert len(figures) == 7
    for alt in figures:
        gathered = re.sub(r"other [<\d.]+ %", "", alt.partition(". ")[2])
        for number in re.findall(r"[<>]?[\d.]+ %", gathered):
            assert number in shown


def test_page_without_requirement_gives_u_of_each_group():
    """Without a requirement the first thing said is U and what dominates it."""
    words = plain(example_page())

    assert "U95 0.119 deg/h (axis z)" in words
    assert (
        "bias repeatability 74 %, bias stability 24 %, rest 2 % of the variance"
        in words
    )
    assert "of the limit" not in words


def test_failing_page_says_by_what_and_why():
    """Verdict, worst output, largest error, limit, utilisation and causes are said."""
    words = plain(example_failing())

    assert "FAILS tactical grade" in words
    assert "3 of 24 required outputs exceed their limits." in words
    assert (
        "Worst output: gyro bias z, largest error 0.119 deg/h, limit 0.1 deg/h: "
        "119 % of the limit." in words
    )
    assert "Because: bias repeatability 67 %, bias stability 31 %, rest 2 %" in words


def test_verdict_stands_before_all_sections():
    """The verdict is the first thing after the title line."""
    page = example_failing()

    assert page.index("FAILS tactical grade</p>") < page.index("<h2>")


def test_undecidable_page_names_what_is_missing():
    """A sensor that would meet says which line its verdict waits for."""
    budget = make_budget(outputs=make_outputs("accelerometer", ACCELEROMETER))
    assessment = make_assessment(budget, accelerometer="undecidable")
    words = plain(render(budget, assessment=assessment))

    assert "UNDECIDABLE tactical grade" in words
    assert "the data sheet does not give a noise line" in words


def test_meeting_page_says_meets():
    """Where every sensor meets, so does the page."""
    budget = make_budget(outputs=make_outputs("accelerometer", ACCELEROMETER))
    words = plain(render(budget, assessment=make_assessment(budget)))

    assert "MEETS tactical grade" in words
    assert "All 12 required outputs stay within their limits." in words


def test_causes_are_ranked_by_what_they_do_to_the_limits():
    """With a requirement the causes in groups beyond their limits stand first."""
    causes = re.findall(r"<li><strong>(.*?)</strong>", example_failing())

    assert causes == [
        "Gyro bias repeatability",
        "Gyro bias stability",
        "Gyro angle random walk",
        "Gyro scale factor repeatability",
        "Accelerometer scale factor repeatability",
    ]


def test_cause_quotes_the_data_sheet():
    """A cause carries the printed figure of its line, share and u."""
    words = plain(example_page())

    assert (
        "Accelerometer bias repeatability (37 ug) makes 79 % of the accelerometer bias "
        "variance (alone u 37 ug)."
    ) in words


def test_empty_states_are_said():
    """Nothing missing, assumed or warned of is said in words."""
    words = plain(render(make_budget(not_given=(), assumptions=(), warnings=())))

    assert "Every line that the model knows is given." in words
    assert "None beyond what the files say." in words
    assert "Warnings None." in words


def test_page_without_spread_says_so():
    """A budget in which nothing varies has no causes and no empty figure."""
    still = make_output(
        "gyro",
        "bias",
        "x",
        unit="deg/h",
        scale=1.0,
        sources={"bias_stability": 0.0},
    )
    words = plain(render(make_budget(outputs=(still,))))

    assert "Nothing varies: no output has any spread." in words
    assert "The gyro bias has no spread" in words


def test_inputs_show_the_data_sheet():
    """Printed form, meaning, distribution, condition and source of a line are shown."""
    cells = {
        cell.replace("\N{NO-BREAK SPACE}", " ") for cell in Page(example_page()).cells
    }

    assert {"2 arcsec", "max", "uniform", "1.155 arcsec"} <= cells
    assert {"-40 to 71 degC", "table 2 <rev B>", "bandwidth", "200 Hz"} <= cells
    assert "normal, correlation time 300 s" in cells


def test_figures_by_axis_are_told_apart():
    """A line with unequal axes shows the figure of each."""
    device = make_device()
    line = replace(device.gyro.lines[0], u=device.gyro.lines[0].u * [1.0, 2.0, 3.0])
    gyro = replace(device.gyro, lines=(line,))
    page = render_html(
        make_budget(),
        devices=(replace(device, gyro=gyro),),
        procedure=make_procedure(),
        assessment=None,
        date="2026-11-21",
    )

    assert "x 0.05, y 0.1, z 0.15 deg/h" in page.replace("\N{NO-BREAK SPACE}", " ")


def test_sensor_that_is_absent_has_no_section():
    """With a gyro alone nothing is said of the accelerometer's test and formulas."""
    device = replace(make_device(), accelerometer=None)
    page = render_html(
        make_budget(outputs=make_outputs("gyro", GYRO), not_given=(), warnings=()),
        devices=(device,),
        procedure=make_procedure(),
        assessment=None,
        date="2026-11-21",
    )

    assert "twelve positions" not in page
    assert "eq. (5)" not in page
    assert "eq. (3)" in page


def test_formula_of_the_paper_is_shown_where_it_is_used():
    """The gyro bias formula on the page is the one of the procedure."""
    assert "Gyro bias, corrected from eq. (4)" in example_page()
    assert "Gyro bias, eq. (4) as printed" in render(formulas="paper")


def test_six_mounting_angles_have_a_formula_each():
    """All 24 parameters have their formula: 9 and 1 of the gyro, 12 of the other."""
    assert example_page().count("<math") == 10 + 12


def test_provenance_names_the_inputs():
    """Version, command, base names and hashes of the inputs are on the page."""
    budget = make_budget()
    cells = Page(render(budget)).cells

    for file in budget.inputs:
        assert {file.role, file.name, file.sha256} <= set(cells)


def test_reference_is_explained():
    """The page says what the errors are counted from."""
    settings = replace(make_budget().settings, reference="next_turn_on")
    words = plain(render(make_budget(settings=settings)))

    assert "next turn on: errors are counted from the values at a later" in words


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("-0.11", "\N{MINUS SIGN}0.11"),
        ("2.4e-9", "2.4&#8239;&times;&#8239;10<sup>\N{MINUS SIGN}9</sup>"),
        ("<0.1", "&lt;0.1"),
    ],
)
def test_numbers_are_set_for_reading(text, markup):
    """Minus signs are true ones, exponents are raised, the rest is escaped."""
    assert number_markup(text) == markup


def test_points_of_a_column_are_in_line():
    """Shorter tails are filled up with spaces as wide as digits and point."""
    assert number_markup("50", tail=3) == (
        "50\N{PUNCTUATION SPACE}\N{FIGURE SPACE}\N{FIGURE SPACE}"
    )
    assert number_markup("0.69", tail=4) == "0.69\N{FIGURE SPACE}"
    assert number_markup("0.077", tail=4) == "0.077"


def test_css_string_cannot_be_left():
    """Quotes, brackets and line ends become code points."""
    assert css_string('a"}\n') == r'"a\000022\00007d\00000a"'


def test_number_stays_with_its_unit():
    """The space between a number and its unit does not break."""
    assert bind("after 300 s at 5 deg/h or so") == (
        "after 300\N{NO-BREAK SPACE}s at 5\N{NO-BREAK SPACE}deg/h or so"
    )


def test_the_check_of_the_law_stands_with_every_output():
    """Both differences, the tolerance and the word stand in each group's table."""
    page = render()
    groups = 6
    assert page.count(">lower ends differ by<") == groups
    assert page.count(">upper ends differ by<") == groups
    assert page.count('<td class="n">holds</td>') == 24
