"""An allocation as a section of a document: what it says, its tables and figures."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import pytest
from figure_text import cut_texts
from reading import assert_says, find, lines, on_terminal, rows

from budget import load_device, load_procedure, load_requirement
from budget.inputs.records import Limit
from budget.names import Name
from budget.report.allocation import (
    allocation_answer,
    allocation_section,
    figured,
    headroom_chart,
    waterfall_chart,
)
from budget.report.blocks import Document, Picture, Table
from budget.report.figures.rows import draw
from budget.report.page import render_page
from budget.report.pages import line
from budget.report.typeset import typeset
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.cases import Bounds

pytestmark = pytest.mark.usefixtures("drawn_once")

PAPER = "zhao-2019"


@pytest.fixture(scope="module")
def allocation():
    """Return the paper's device, shared out among equal parts."""
    return allocate(
        load_device(PAPER),
        requirement=load_requirement("navigation-grade"),
        strategy="equal",
        validate=False,
    )


@pytest.fixture(scope="module")
def impossible():
    """Return an allocation whose limits what is held already passes."""
    return allocate(
        load_device(PAPER),
        requirement=load_requirement("navigation-grade"),
        bounds=Bounds(held=frozenset({"gyro.bias_stability"}), most={}, least={}),
        validate=False,
    )


def tables_of(section):
    """Return the tables of a section by name."""
    return {table.name: table for table in find(section, Table)}


def cells_of(table):
    """Return the rows of a table, group after group."""
    return [row for group in table.groups for row in group.rows]


def in_document(section):
    """Return a document of one section."""
    return Document(
        kind="allocation",
        title="test",
        facts=(),
        headline="can be met",
        summary=(),
        cards=(),
        sections=(section,),
        json="{}",
        date="2026-01-01",
        version="0",
    )


@pytest.mark.slow
def test_the_finding_comes_first(allocation, impossible):
    """The first line says whether the requirement can be met, and what is tight."""
    assert_says(
        lines(allocation_section(allocation))[1],
        *("navigation grade", "can be met", "at its limit"),
    )
    assert_says(lines(allocation_section(impossible))[1], "cannot be met")


def test_every_line_has_its_values_in_the_unit_of_the_file(allocation):
    """Now, allowed and their ratio stand there exactly, in printed units."""
    tables = tables_of(allocation_section(allocation))
    cells = [
        row
        for sensor in ("gyro", "accelerometer")
        for group in tables[f"allocation-{sensor}"].groups
        for row in group.rows
    ]

    assert len(cells) == len(allocation.sources) == 10
    for row, source in zip(cells, allocation.sources, strict=True):
        assert row[1].exact == source.now / source.si_per_unit
        alone = source.headroom.value if source.headroom else 0.0
        assert row[2].exact == (alone / source.si_per_unit or None)
        assert row[3].text == source.unit
        assert row[5].exact == source.allowed / source.si_per_unit
        assert row[6].exact == source.factor


@pytest.mark.slow
def test_what_does_not_matter_is_marked():
    """A line that the strategy spares says so, as one that it moves does not."""
    found = allocate(
        load_device("hg4930#C"),
        requirement=load_requirement("tactical-grade"),
        validate=False,
    )
    sources = [replace(row, is_minor=False) for row in found.sources]

    assert any(source.is_spared for source in found.sources)
    for one, said in (
        (found, "negligible"),
        (replace(found, sources=tuple(sources)), "left as it is"),
    ):
        tables = tables_of(allocation_section(one))
        rows = [
            row
            for sensor in ("gyro", "accelerometer")
            for row in cells_of(tables[f"allocation-{sensor}"])
        ]
        for row, source in zip(rows, found.sources, strict=True):
            assert row[0].note == (said if source.is_spared else "")
            assert (row[6].exact == 1.0) == source.is_spared


def test_waterfalls_are_those_of_the_tightest_outputs(allocation):
    """A figure for each parameter at its limit, and a headroom for each sensor."""
    names = [p.name for p in find(allocation_section(allocation), Picture)]

    assert len(figured(allocation)) == 6
    assert sorted(names) == sorted(
        [
            *(
                f"waterfall-{row.output.name}".replace(".", "-").replace("_", "-")
                for row in figured(allocation)
            ),
            "headroom-gyro",
            "headroom-accelerometer",
        ]
    )


def test_the_parts_of_each_waterfall_stand_in_a_table(allocation):
    """The columns of an output with a waterfall have its parts, now and allowed."""
    tables = tables_of(allocation_section(allocation))
    for row in figured(allocation):
        table = tables[f"allocation-parts-{row.sensor}"]
        heads = [column.head for column in table.columns]
        title = row.output.name.partition(".")[2].replace("_", " ").replace(".", " ")
        now, allowed = (heads.index(f"{title}, {w}") for w in ("now", "allowed"))
        parts, used = table.groups
        for cells, part in zip(parts.rows, row.parts, strict=True):
            assert cells[now].exact == 100.0 * part.now
            assert cells[allowed].exact == 100.0 * part.allowed
        assert used.rows[0][now].exact == 100.0 * row.now


def test_what_cannot_be_met_says_what_is_held(impossible):
    """Of an impossible limit the columns are 'now' and 'held', and help is named."""
    section = allocation_section(impossible)
    heads = [c.head for c in tables_of(section)["allocation-parts-gyro"].columns]
    (lines_table,) = (
        t for n, t in tables_of(section).items() if n == "allocation-gyro"
    )

    assert any(head.endswith(", held") for head in heads)
    assert "What would make it feasible" in lines(section)
    assert {row[5].text for row in cells_of(lines_table)} == {"-"}


@pytest.mark.parametrize("which", ["allocation", "impossible"])
def test_tips_belong_to_elements_of_their_figures(which, request):
    """Every bar with a tip is in its figure; every picture has tips and words."""
    section = allocation_section(request.getfixturevalue(which))
    for picture in find(section, Picture):
        assert picture.tips
        assert "%" in picture.alt or "times" in picture.alt or "none" in picture.alt
        for gid in picture.tips:
            assert f'id="{picture.name}-{gid}"' in picture.svg


@pytest.mark.parametrize("which", ["allocation", "impossible"])
def test_no_text_of_a_figure_is_cut(which, request):
    """Names, numbers and what stops a line lie within the figure."""
    found = request.getfixturevalue(which)
    charts = [waterfall_chart(row) for row in figured(found)]
    charts += [headroom_chart(of_sensor(found, s)) for s in ("gyro", "accelerometer")]

    assert [cut_texts(draw(chart)) for chart in charts if chart] == [[]] * len(
        [chart for chart in charts if chart]
    )


@pytest.mark.parametrize("which", ["allocation", "impossible"])
def test_the_section_can_be_printed_as_page_and_as_pdf(which, request, forget_drawings):
    """HTML and PDF are made of it, the same bytes twice."""
    section = allocation_section(request.getfixturevalue(which))
    forget_drawings()
    again = allocation_section(request.getfixturevalue(which))

    assert find(section, Picture) == find(again, Picture)
    page = render_page(in_document(section))
    assert "Allowable specification values" in page
    assert typeset(in_document(section)).pdf.startswith(b"%PDF-")


def test_a_sensor_without_limits_is_left_as_it_is(allocation):
    """Without limits there is a table of the lines, and no figure."""
    bare = replace(
        allocation,
        outputs=(),
        sources=tuple(
            replace(row, allowed=None, headroom=None, binding_outputs=())
            for row in allocation.sources
        ),
    )
    section = allocation_section(bare)

    assert not find(section, Picture)
    assert len(rows(tables_of(section)["allocation-gyro"])) == 5


@pytest.fixture(scope="module")
def as_tested():
    """Return an allocation where repeatabilities cancel: few lines count."""
    return allocate(
        load_device("stim300#5g"),
        requirement=replace(load_requirement("catalogue-edge"), reference="as_tested"),
        catalogue=(),
        validate=False,
    )


def of_sensor(allocation, sensor):
    """Return the lines of one sensor."""
    return [r for r in allocation.sources if r.source.startswith(f"{sensor}.")]


def test_lines_that_count_nothing_get_no_number(as_tested):
    """Table, figure and title say that they count nothing, and give no headroom."""
    table = tables_of(allocation_section(as_tested))["allocation-accelerometer"]
    own = of_sensor(as_tested, "accelerometer")
    idle = [row for row in own if row.is_idle]
    chart = headroom_chart(own)

    assert {row.source.partition(".")[2] for row in idle} == {
        "bias_repeatability",
        "bias_over_temperature",
        "scale_factor_repeatability",
        "scale_factor_nonlinearity",
    }
    for cells, row in zip(cells_of(table), own, strict=True):
        said = (cells[2].text, cells[4].text)
        assert (said == ("-", "without effect here")) == row.is_idle
        assert ("without effect here" in cells[0].note) == row.is_idle
        assert (cells[2].exact is None) == row.is_idle
    assert_says(chart.title, "2 of 2 accelerometer specifications", "grow")
    assert_says(chart.caption, "without effect here: bias repeatability")


def test_page_and_terminal_say_headroom_alike(as_tested, impossible):
    """Number, 'none', dash and what stops a line are the same words in both."""
    for allocation in (as_tested, impossible):
        text = on_terminal(allocation_answer(allocation), width=200)
        tables = tables_of(allocation_section(allocation))
        for sensor in ("gyro", "accelerometer"):
            part = text.partition(f"\n{sensor.capitalize()}\n")[2]
            printed = [
                re.split(" {2,}", line)
                for line in part.splitlines()[1:]
                if not line.startswith(" ")  # a remark on the line above
            ]
            cells = cells_of(tables[f"allocation-{sensor}"])
            own = of_sensor(allocation, sensor)
            for row, words, shown in zip(cells, printed[: len(own)], own, strict=True):
                up_to, stop = (
                    line("allocation_words", macro, row=shown)
                    for macro in ("up_to", "stop")
                )
                assert (row[2].text, row[4].text) == (up_to, stop)
                assert (words[2], words[4]) == (up_to, stop)


def test_limits_of_a_sensor_not_given_are_said():
    """Gyros alone against limits for both: headline and remarks name what is left."""
    found = allocate(
        load_device("adxrs453"),
        requirement=load_requirement("catalogue-edge"),
        catalogue=(),
        validate=False,
    )
    said = (
        "the requirement limits the accelerometer, which is not given: nothing is "
        "allocated for it"
    )
    text = lines(allocation_section(found))

    assert said in found.warnings
    assert found.not_allocated == ("accelerometer",)
    assert_says(text[1], "edge of the catalogue", "can be met for the gyro")
    shown = " ".join(on_terminal(allocation_answer(found), width=80).split())
    assert said in shown.replace("The requirement", "the requirement")
    assert "Remarks on the allocation" in text
    assert "Warnings" not in text


def test_limits_on_what_the_test_holds_are_no_part_of_what_can_be_met():
    """Six positions find no second order: the headline says so."""
    limit = Limit(
        output=Name("second_order", owner="accelerometer", axis="x"),
        limit=1e-6,
        printed="1 ug/g^2",
    )
    edge = load_requirement("catalogue-edge")
    found = allocate(
        load_device("zhao-2019"),
        requirement=replace(edge, limits=(*edge.limits, limit)),
        procedure=load_procedure("six-positions"),
        catalogue=(),
        validate=False,
    )

    assert found.not_estimated == (limit.output,)
    assert_says(
        lines(allocation_section(found))[1],
        *("can be met", "but for accelerometer second order", "x"),
    )
    assert found.to_dict()["not_estimated"] == ["accelerometer.second_order.x"]


def test_nothing_is_said_of_sensors_that_are_all_given(allocation):
    """With both sensors the headline speaks for the whole requirement."""
    assert allocation.not_allocated == ()
    assert not any("not given: nothing is" in text for text in allocation.warnings)


def test_numbers_are_in_line_within_one_unit(allocation):
    """A group of rows has one unit, and neighbours of one unit are one group."""
    table = tables_of(allocation_section(allocation))["allocation-gyro"]
    units = [{row[3].text for row in group.rows} for group in table.groups]

    assert all(len(found) == 1 for found in units)
    assert all(a != b for a, b in pairwise(units))
    assert any(len(group.rows) > 1 for group in table.groups)
