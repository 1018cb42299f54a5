"""Answers in brief on a terminal: their length, tables, colours; help, completion."""

import io

import pytest
from command_line import call
from places import put
from reading import assert_says
from rich.console import Console

from budget.cli import options
from budget.language import speaking
from budget.report import terminal
from budget.report.blocks import Cell, Column, RowGroup, Section, Table

pytestmark = pytest.mark.usefixtures("analyzed_once")

TACTICAL = ("--requirement", "tactical-grade")
CALLS = {
    "analyze": ("analyze", "zhao-2019", "--no-validate"),
    "analyze, judged": ("analyze", "mpu-6050", "--no-validate", *TACTICAL),
    "analyze, one sensor": ("analyze", "adxl357", "--no-validate", *TACTICAL),
    "mission": ("mission", "hg4930#C", "--mission", "bench", "--no-validate"),
    "station": ("station", "hg4930#C", *TACTICAL),
    "allocate": ("allocate", "hg4930#C", *TACTICAL, "--no-validate"),
    "devices": ("devices",),
}
MOST_LINES = 45  # a screen; most answers are half of it


@pytest.fixture
def tables(monkeypatch):
    """Note into how many pieces each table is cut."""
    found = []
    whole = terminal._parts  # noqa: SLF001 - what cuts them

    def noted(columns, width):
        parts = whole(columns, width)
        found.append((columns[0].cells[:1], width, parts and len(parts)))
        return parts

    monkeypatch.setattr(terminal, "_parts", noted)
    return found


@pytest.mark.parametrize("name", CALLS)
def test_no_table_is_cut_in_pieces(name, tables):
    """At 80 columns every table of an answer fits beside itself, at some width."""
    out = call(*CALLS[name], COLUMNS="80").out
    assert tables
    last = {str(first): pieces for first, _, pieces in tables}
    assert set(last.values()) == {1}, last
    assert all(len(line) <= 80 for line in out.splitlines())


@pytest.mark.parametrize("name", [name for name in CALLS if name != "devices"])
def test_an_answer_is_brief_and_names_the_option_for_all(name):
    """A screen at the most, and its last words are how to see the rest."""
    out = call(*CALLS[name]).out
    assert len(out.splitlines()) <= MOST_LINES
    last = out[out.rindex("\nEverything") :]
    assert_says(last, "--full")
    assert "Assumptions" not in out


def test_what_was_asked_for_is_in_the_brief_answer():
    """Indices, matrices and what was changed are not left to --full."""
    asked = ("--matrices", "--set", "gyro.bias_stability=0.02 deg/h")
    out = call("analyze", "zhao-2019", "--no-validate", *asked).out
    assert_says(out, "0.02 deg/h", "by --set", "Compensation of readings")


def judged(verdict, word, **colours):
    """Return what a terminal shows of a verdict, its headline and a row of it."""
    cells = (Cell(text="one"), Cell(text=word))
    table = Table(
        name="verdicts",
        caption="",
        columns=(Column(head="device"), Column(head="verdict")),
        groups=(RowGroup(title=f"Gyro: {word}", rows=(cells,)),),
    )
    section = Section(
        name="verdict", title=f"{word} a grade", verdict=verdict, blocks=(table,)
    )
    text = io.StringIO()
    console = Console(file=text, width=80, **colours)
    terminal.print_sections([section], terminal.TerminalPage(console))
    return text.getvalue()


COLOURED = {"force_terminal": True, "color_system": "standard"}


@pytest.mark.parametrize(
    ("verdict", "word", "code"),
    [
        ("meets", "MEETS", "32"),
        ("fails", "FAILS", "31"),
        ("meets_if", "MEETS IF", "33"),
        ("undecided", "UNDECIDED", "33"),
    ],
)
def test_verdicts_are_in_colour(verdict, word, code):
    """Headline, title and cell; the words are the same without."""
    shown = judged(verdict, word, **COLOURED, _environ={})
    lines = [line for line in shown.splitlines() if word in line]
    assert len(lines) == 3
    assert all(f"{code}m" in line for line in lines)
    assert "\x1b" not in judged(verdict, word)


@pytest.mark.parametrize(
    "environment", [{"NO_COLOR": "1"}, {"TERM": "dumb", "COLORTERM": "truecolor"}]
)
def test_no_colour_where_none_is_wanted(environment):
    """NO_COLOR, and a terminal that has none."""
    shown = judged("fails", "FAILS", force_terminal=True, _environ=environment)
    assert "31m" not in shown
    assert "FAILS a grade" in shown


def test_a_chinese_verdict_has_its_colour():
    """The longest word counts: 'not met' has 'met' in it."""
    with speaking("zh"):
        shown = judged("fails", "不满足", **COLOURED, _environ={})
    assert shown.count("31m") == 3
    assert "32m" not in shown


def test_nothing_is_coloured_in_a_pipe():
    """Whatever FORCE_COLOR says."""
    found = call(*CALLS["analyze, one sensor"], FORCE_COLOR="1", NO_COLOR="")
    assert "FAILS" in found.out or "UNDECIDABLE" in found.out
    assert "\x1b" not in found.out


def completed(*words):
    """Return what a shell is offered for the last of some words."""
    found = call(
        _BUDGET_COMPLETE="complete_bash",
        COMP_WORDS=" ".join(("budget", *words)),
        COMP_CWORD=str(len(words)),
    )
    return found.out.split()


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (("mission", "--mission", "car"), ["car-drive"]),
        (("analyze", "--requirement", "navig"), ["navigation-grade"]),
        (("station", "--station", "granite"), ["granite-plate-cube"]),
        (("analyze", "--calibration", "fac"), ["factory"]),
        (("report", "--procedure", "hand-"), ["hand-turns"]),
        (("analyze", "--set", "gyro.bias_st"), ["gyro.bias_stability="]),
        (("analyze", "--set", "gyro.ra"), ["gyro.rate_random_walk=", "gyro.range="]),
        (("analyze", "--only", "station.lev"), ["station.levelling.east"]),
        (("allocate", "--fix", "gyro.angle"), ["gyro.angle_random_walk"]),
        (("analyze", "--outputs", "gyro,gyro.bias.z"), ["gyro,gyro.bias.z"]),
    ],
)
def test_names_are_completed(words, offered, tmp_path, monkeypatch):
    """What ships, and names that an option takes."""
    monkeypatch.chdir(tmp_path)
    found = completed(*words)
    assert found[: len(offered)] == offered


def test_every_name_that_is_offered_is_taken():
    """Sources and outputs: none that is refused when it is typed."""
    names = ",".join(options.complete_output("gyro."))
    taken = ("--outputs", names, "--only", options.complete_source("gyro.bias_s")[0])
    call("analyze", "zhao-2019", "--no-validate", *taken, code=0)


@pytest.mark.parametrize("name", ["analyze", "mission", "station", "allocate"])
def test_help_has_options_in_groups(name):
    """Each group once, in their order; that of help itself last."""
    out = call(name, "--help").out
    places = [
        out.index(f"\n{title}:\n")
        for title in (
            *("What is judged", "Calibration and use", "How it is computed"),
            *("Where it goes", "Options"),
        )
    ]
    assert places == sorted(places)
    assert out.count("Where it goes:") == 1


def test_a_small_error_is_not_in_the_unit_of_a_large_limit(tmp_path):
    """2 m of 50 km are metres; near its limit an error is in the unit of that."""
    path = put(
        tmp_path / "wide.yaml",
        "name: wide\nlimits: {mission: {position: [{horizontal: 50 km, at: 60 s}, "
        "{horizontal: 0.01 km, at: 30 s}]}}\n",
    )
    out = call(
        *("mission", "zhao-2019", "--mission", "outage-60-s", "--no-validate"),
        *("--requirement", path),
    ).out
    assert_says(out, "1.9 m 50 km")
    assert " km  0.01 km" not in out
