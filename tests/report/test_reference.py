"""Moves as people read them: digits, signs, axes, causes, and how many are shown."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from reading import assert_says, find

from budget.known import Known
from budget.references.difference import Alteration, Cause, Move
from budget.references.records import Item
from budget.report.blocks import Listing, Paragraph, Table
from budget.report.reference import (
    MOST_IDLE,
    MOST_ROWS,
    cause_texts,
    difference_sections,
    move_table,
    print_pair,
)


def move(subject="gyro.bias.x", quantity="standard_uncertainty", **more):
    """Return a move of 1 %."""
    before, after = more.pop("before", 2.0), more.pop("after", 2.02)
    return Move(
        item=Item(subject=subject, quantity=quantity, partner=more.pop("partner", "")),
        unit=more.pop("unit", "deg/h"),
        before=before,
        after=after,
        times=more.pop("times", 1e7),
        scale=more.pop("scale", before),
        **more,
    )


def caused(amounts):
    """Return changes, and what each explains."""
    changes = [
        Alteration(where="device a.yaml", key=f"k{k}", before="1", after="2")
        for k, _ in enumerate(amounts)
    ]
    causes = [Cause(change=c, amount=a) for c, a in zip(changes, amounts, strict=True)]
    return changes, tuple(causes)


def sections_of(moves=(), changes=()):
    """Return the page of a difference that has these."""
    return difference_sections(
        SimpleNamespace(
            first="a", second="b", moves=moves, changes=changes, compared=len(moves)
        )
    )


def rows_of(moves, changes=()):
    """Return what the table of moves has: title, then label, numbers, causes."""
    (table,) = find(sections_of(moves, changes)[0], Table)
    return [
        (group.title, *(cell.text for cell in row))
        for group in table.groups
        for row in group.rows
    ]


def lines_of(changes, *, moved):
    """Return what is said of changes, where a number moved or none did."""
    section = sections_of([move()] if moved else (), changes)[0]
    (listing,) = find(section, Listing)
    _, *rest = find(section, Paragraph)
    return [*(words for (words,) in listing.items), *(one.words[0] for one in rest)]


@pytest.mark.parametrize(
    ("before", "after", "texts"),
    [
        (0.05638, 0.05649, ("0.05638", "0.05649")),
        (0.05, 0.05049999, ("0.05000", "0.05050")),
        (2.0, 155.0, ("2.0", "155.0")),
        (50.0048813194, 50.0048825057, ("50.0048813", "50.0048825")),
        (1.0, 1.0 + 1e-15, ("1.000000000", "1.000000000")),
        (-1.5e-10, 3.1e-9, ("-1.5e-10", "3.10e-9")),
        (1e9, 1.1e9, ("1.00e9", "1.10e9")),
        (2829.1, 29697.2, ("2829", "29697")),
        (0.0, 0.0, ("0", "0")),
        (0.0, 1.0, ("0.00", "1.00")),
    ],
)
def test_both_numbers_show_their_difference(before, after, texts):
    """Two digits of the difference and of both; ten digits at most."""
    assert print_pair(before, after) == texts


def test_axes_that_say_the_same_are_one_row():
    """Three alike are `all`; one that differs stands alone."""
    alike = [move(f"gyro.bias.{axis}") for axis in "xyz"]
    (row,) = rows_of(alike)
    assert row[:2] == ("Gyro bias, u [deg/h]", "all")
    rows = rows_of([*alike[:2], move("gyro.bias.z", after=2.5)])
    assert [label for _, label, *_ in rows] == ["z", "x, y"]


def test_names_with_commas_are_told_apart():
    """Devices that say the same are one row, also under 'eq. 4, as printed'."""
    names = ("a.yaml @ eq. 4, as printed", "b.yaml @ eq. 4, as printed")
    rows = rows_of([move(f"{name} gyro") for name in names])
    assert [label for _, label, *_ in rows] == ["; ".join(names)]


@pytest.mark.parametrize(
    ("subject", "title", "label"),
    [
        ("hg4930.yaml#C gyro.bias.x", "hg4930.yaml#C gyro bias, u [deg/h]", "x"),
        ("hg4930.yaml#C gyro", "gyro, u [deg/h]", "hg4930.yaml#C"),
        ("my imu.yaml gyro", "gyro, u [deg/h]", "my imu.yaml"),
        ("gyro.bias_stability", "Gyro, u [deg/h]", "bias stability"),
        ("gyro", "Gyro, u [deg/h]", ""),
    ],
)
def test_groups_and_rows(subject, title, label):
    """A subject is taken apart into what a table is of and what a row is of."""
    assert rows_of([move(subject)])[0][:2] == (title, label)


def test_the_largest_first_and_the_rest_counted():
    """Groups fall by their largest change; what follows from u is only counted."""
    moves = [
        move("gyro.bias.x", after=2.02),
        move("gyro.scale_factor.x", after=2.5, unit="ppm"),
        move("gyro.bias.x", "contribution", partner="gyro.bias_stability", after=9.0),
    ]
    assert [row[0][:10] for row in rows_of(moves)] == ["Gyro scale", "Gyro bias,"]
    assert move_table(moves).rest == 1
    ((title, *_),) = rows_of(moves[2:])
    assert_says(title, "gyro bias", "contribution of bias stability", "[deg/h]")
    many = [move(f"a{k}.gyro.bias.x", after=2.0 + k) for k in range(1, 60)]
    table = move_table(many)
    assert len(table.rows) == MOST_ROWS
    assert table.rest == 59 - MOST_ROWS


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (move(), "+1.0 %"),
        (move(after=1.9), "-5.0 %"),
        (move(after=20.0), "x 10"),
        (move(quantity="mean", before=1e-9, after=1e-6, scale=1.0), "+1.0e-4 %"),
        (move(before=None, scale=None), "-"),
        (move(before=0.0, scale=None), "-"),
    ],
)
def test_a_change_is_of_the_uncertainty_or_of_itself(change, text):
    """Per cent of the scale; so many times where a number itself grew much."""
    rows = move_table([change]).rows
    assert rows[0].change == text


def test_words_stand_apart():
    """A verdict that moved is a sentence, not a row."""
    word = move("gyro", "verdict", before="meets", after="fails", unit="", scale=None)
    (listing,) = find(sections_of([word])[0], Listing)
    assert listing.items == (("Gyro, verdict: meets -> fails",),)
    table = move_table([word])
    assert (table.rows, table.rest) == ((), 0)


def test_a_word_of_a_comparison_names_its_device():
    """A row has the device as its label, a sentence has it in front."""
    subject, pair = "my imu.yaml gyro", {"before": "meets", "after": "fails"}
    word = move(subject, "verdict", **pair, unit="", scale=None)
    text = "my imu.yaml gyro, verdict: meets -> fails"
    assert [one.items for one in find(sections_of([word])[0], Listing)] == [((text,),)]


@pytest.mark.parametrize(
    ("amounts", "text"),
    [
        ((0.02,), "1"),
        ((0.015, 0.005), "1: 75 %, 2: 25 %"),
        ((0.005, 0.015), "2: 75 %, 1: 25 %"),
        ((0.03, -0.01), "1: 150 %, 2: -50 %"),
        ((0.01, 0.005, 0.004), "1: 50 %, 2: 25 %, ..."),
        ((0.01,), "1: 50 %"),
        ((), "-"),
    ],
)
def test_causes(amounts, text):
    """Changes by number, the largest part first; one that is all needs no part."""
    changes, causes = caused(amounts)
    one = move(causes=causes)
    assert rows_of([one], changes)[0][-1] == text
    assert len(cause_texts(one)) == len(amounts)


@pytest.mark.parametrize(
    ("amounts", "together", "text"),
    [
        ((0.01, 0.006), 0.004, "1: 50 %, 2: 30 %, together: 20 %"),
        ((0.03, 0.0), -0.01, "1: 150 %, together: -50 %"),
        ((0.01, 0.005, 0.003), 0.002, "1: 50 %, 2: 25 %, ..., together: 10 %"),
        ((0.02,), 0.0005, "1"),  # 2.5 %: parts of an uncertainty never add up quite
        ((), 0.02, "together: 100 %"),
    ],
)
def test_what_parts_leave(amounts, together, text):
    """What the changes do at once beyond their parts is said, above a few per cent."""
    changes, causes = caused(amounts)
    moves = [move(causes=causes, together=together)]
    assert rows_of(moves, changes)[0][-1] == text
    _, legend = sections_of(moves, changes)
    assert ("together:" in legend.blocks[0].words[0]) == ("together" in text)


@pytest.mark.parametrize(
    ("amount", "text"),
    [(2e300, "-"), (3.0, "1: 1.5e4 %"), (-2e5, "1: -1.0e9 %"), (1e-300, "-")],
)
def test_no_part_overflows(amount, text):
    """A part a thousand times the difference is short; one beyond any is none."""
    changes, causes = caused([amount])
    one = move(causes=causes, together=amount * 1e10)
    *_, because = rows_of([one], changes)[0]
    assert because.partition(", ")[0] == text
    assert len(because) < 40


@pytest.mark.parametrize(
    ("moved", "key", "note"),
    [
        (True, "gyro.turns", " (by itself moves no number)"),
        (False, "gyro.turns", " (moves no number)"),
        (True, "notes", " (moves no number)"),
    ],
)
def test_a_change_that_does_nothing_alone(moved, key, note):
    """Where numbers moved, only a text is said to move none with another change."""
    change = Alteration(
        where="device a.yaml",
        key=key,
        before="1",
        after="2",
        acts=False,
        is_text=key == "notes",
    )
    assert lines_of([change], moved=moved) == [f"{change}{note}"]
    *_, last = lines_of([change] * (MOST_IDLE + 1), moved=moved)
    assert ("alone" in last) == ("alone" in note)


def test_changes_without_effect_are_counted():
    """All that act are named, of the others a dozen."""
    acting = Alteration(
        where="device a.yaml", key="k", before="1 s", after="2 s", acts=True
    )
    idle = Alteration(
        where="device a.yaml",
        key="notes",
        before="",
        after="x",
        acts=False,
        is_text=True,
    )
    lines = lines_of([acting, *[idle] * (MOST_IDLE + 5)], moved=True)

    assert lines[0] == "device a.yaml: k: 1 s -> 2 s"
    assert_says(lines[1], "device a.yaml: notes: (not there) -> x", "moves no number")
    assert_says(lines[-1], "5 more that move no number", "--json")
    assert len(lines) == MOST_IDLE + 2


@pytest.mark.parametrize(
    ("after", "pair"),
    [
        (Known.at_least(2.5), ("2.00", "≥ 2.50")),
        (Known.at_least(2.5).falling, ("2.00", "≤ 2.50")),
    ],
)
def test_a_bound_is_marked(after, pair):
    """Where a line lacks, u is this or more, and a conformance this or less."""
    one = move(after=after)
    (row,) = rows_of([one])
    assert row[2:4] == pair
    marked, plain = (sections_of(moves)[1] for moves in ([one], [move()]))
    assert ">=, <=:" in marked.blocks[0].words[0]
    assert ">=" not in plain.blocks[0].words[0]
