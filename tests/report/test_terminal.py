"""The budget on a terminal."""

from __future__ import annotations

import io
import re
from types import SimpleNamespace

import pytest
from reading import assert_says
from report_examples import GYRO, make_budget, make_output, make_outputs
from rich.console import Console

from budget.report.analysis.groups import budget_answer
from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.pages import line
from budget.report.tables import group_tables
from budget.report.terminal import TerminalPage, print_sections, print_table

NUMBER = re.compile(r"-?\d[\d.]*(?:e-?\d+)?")


def render(budget, *, width=80, encoding="utf-8", **options):
    """Render into bytes and decode them again."""
    raw = io.BytesIO()
    file = io.TextIOWrapper(raw, encoding=encoding, newline="")
    page = TerminalPage(Console(file=file, width=width, **options))
    page.line(budget.title)
    print_sections(budget_answer(budget), page)
    file.flush()
    return raw.getvalue().decode(encoding)


def extreme_budget():
    """Return a budget whose numbers are as long as they come."""
    outputs = tuple(
        make_output(
            "gyro",
            "bias",
            axis,
            unit="deg/h",
            scale=1.0,
            sources={"bias_stability": 1.23456e-6, "angle_random_walk": 2.3e-14},
            mean=-123.456789,
            skew=0.4,
        )
        for axis in "xyz"
    )
    return make_budget(outputs=outputs)


@pytest.mark.parametrize("width", [40, 47, 60, 80, 120, 200])
@pytest.mark.parametrize("encoding", ["utf-8", "ascii", "cp437", "latin-1"])
def test_no_line_is_wider_than_the_terminal(width, encoding):
    """Every line fits, in every encoding."""
    lines = render(make_budget(), width=width, encoding=encoding).splitlines()

    assert max(len(line) for line in lines) <= width


@pytest.mark.parametrize("budget", [make_budget(), extreme_budget()])
def test_no_number_is_cut_at_40_columns(budget):
    """Every number of the outputs and of the contributions stands whole on one line."""
    found = set(NUMBER.findall(render(budget, width=40)))

    for group in group_tables(budget):
        centred = all(row.is_centred for row in group.rows)
        for row in group.rows:
            ends = [row.expanded] if centred else [row.low, row.high]
            mean = [row.mean] if float(row.mean.text) else []
            assert {n.text for n in [*mean, row.u, *ends]} <= found
        for source in group.sources:
            if not source.is_idle:
                largest = max((cell.u for cell in source.cells), key=lambda u: u.exact)
                assert largest.text in found


@pytest.mark.parametrize("width", [40, 80, 200])
def test_long_numbers_fit(width):
    """Numbers too long for columns are set one to a line, none over the edge."""
    lines = render(extreme_budget(), width=width).splitlines()

    assert max(len(line) for line in lines) <= width


def test_a_table_in_chinese_is_straight():
    """A character of Chinese takes two columns: what stands right of it is in line."""
    words, long = "\u96f6\u504f", "bias and what is left of it"
    rows = tuple(
        (Cell(text=name), Cell(text=number))
        for name, number in ((words, "1"), (long, "2"))
    )
    columns = (Column(head="name"), Column(head="u", kind="number"))
    table = Table(name="t", caption="", columns=columns, groups=(RowGroup(rows=rows),))
    raw = io.BytesIO()
    file = io.TextIOWrapper(raw, encoding="utf-8", newline="")
    print_table(table, TerminalPage(Console(file=file)))
    file.flush()
    lines = raw.getvalue().decode().splitlines()
    (chinese,) = (line for line in lines if words in line)
    (english,) = (line for line in lines if long in line)
    assert len(chinese.rstrip()) + len(words) == len(english.rstrip())


def test_ascii_terminal_gets_ascii_bars():
    """Where there are no blocks the bars are number signs."""
    text = render(make_budget(title="Ring µ 激光 ±2 °"), encoding="ascii")

    assert "####" in text
    assert text.startswith("Ring u ?? +-2 deg\n")


def test_unicode_terminal_gets_blocks():
    """Where there are blocks the bars are drawn to an eighth of a column."""
    assert "█" in render(make_budget())


def test_output_is_the_same_without_colour():
    """Everything is in the characters: without colour the text is the same."""
    plain = render(make_budget())
    coloured = render(make_budget(), force_terminal=True, color_system="truecolor")

    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain


def test_markup_in_a_name_is_text():
    """A device called [red] is printed as it is called."""
    assert render(make_budget(title="[red]IMU[/red]")).startswith("[red]IMU[/red]\n")


def test_every_source_is_named_in_every_group():
    """A source with no effect is said to have none, not left out."""
    budget = make_budget()
    text = render(budget, width=140)

    for group in group_tables(budget):
        title = line("analysis/group", "title", group=group)
        block = text.split(f"{title}\n")[1]
        block = block.split("Without effect")[0] + block.split("Without effect")[1]
        for source in group.sources:
            assert source.title in " ".join(block.split())


def test_largest_source_stands_first():
    """The sources of a group are ranked."""
    block = render(make_budget()).split("Gyro bias [deg/h]")[1]

    assert block.index("bias repeatability") < block.index("bias stability")
    assert block.index("bias stability") < block.index("angle random walk")


def test_lopsided_interval_shows_both_ends():
    """An interval that is not mean +- U is printed by its ends."""
    text = render(make_budget(outputs=make_outputs("gyro", GYRO, skew=0.3)))

    assert "95 % interval from" in text
    assert "U95" not in text


def test_what_it_rests_on_is_printed():
    """Missing lines, assumptions, warnings and settings stand below the tables."""
    text = render(make_budget(), width=200)

    assert_says(text, "- gyro rate random walk, scale factor asymmetry:", "widen")
    assert "correlation time of 300 s" in text
    assert "accelerometer.sample_noise is read as" in text
    assert re.search(r"^seed +0$", text, re.MULTILINE)
    assert re.search(r"^checked +against Monte Carlo with 230 000", text, re.MULTILINE)


def test_empty_lists_are_said_to_be_empty():
    """Nothing missing and nothing assumed is said, not left to be guessed."""
    budget = make_budget(
        question=SimpleNamespace(not_given=()),
        could_widen={},
        assumptions=(),
        warnings=(),
    )
    text = render(budget)

    assert "Not given: none\n" in text
    assert "Assumptions: none\n" in text
    assert "Warnings: none\n" in text


def test_number_keeps_its_unit_on_the_line():
    """A line break never falls between a number and its unit."""
    budget = make_budget(warnings=("w" * 30 + " 300 s and more words follow here",))

    assert "300 s" in render(budget, width=40)


@pytest.mark.slow
def test_number_keeps_the_sign_of_a_bound_on_the_line():
    """A line break never falls between 'at least' or 'at most' and its number."""
    for sign in ("\N{GREATER-THAN OR EQUAL TO}", "\N{LESS-THAN OR EQUAL TO}"):
        for before in range(30, 42):
            told = "w" * before + f" {sign} 300 s and more words follow here"
            text = render(make_budget(warnings=(told,)), width=40)

            assert re.search(r"[<>]= 300 s", text)
