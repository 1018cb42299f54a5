"""A comparison as texts, documents, figures and page."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace

import pytest
from builders import compared, only_bias, paper_device, requirement
from figure_text import cut_texts
from reading import assert_says, find, lines, names, on_terminal, rows, section

from budget.errors import CallError
from budget.report.blocks import Picture, Table
from budget.report.comparison.figures import (
    fit_name,
    front_plot,
    map_chart,
)
from budget.report.comparison.page import (
    comparison_answer,
    comparison_document,
    comparison_sections,
)
from budget.report.comparison.tables import (
    RANKING,
    find_column,
    print_factor,
    print_parts,
    rankings,
    requests,
    to_csv,
)
from budget.report.document import json_text
from budget.report.figures.rows import draw
from budget.report.page import render_page
from budget.report.tables import print_probability, used_part
from budget.report.typeset import typeset
from budget.results import Probability, Remedy
from budget.studies.comparison.ranking import numbered
from budget.studies.comparison.records import Lead

pytestmark = pytest.mark.usefixtures("drawn_once")

BOTH = ("gyro", "accelerometer")
DATE = "2026-01-01"


@pytest.fixture(scope="module")
def comparison():
    """Three IMUs of both sensors: one meets, one lacks a line, one fails."""
    devices = [
        paper_device("bad <b>", sensors=BOTH, times=20.0, mass="3 kg"),
        paper_device("good", sensors=BOTH, times=0.5, mass="2 kg"),
        paper_device(
            "bare", sensors=BOTH, times=0.4, mass="1 kg", missing=("bias_stability",)
        ),
    ]
    return compared(
        devices,
        requirement(sensors=BOTH),
        pairs=True,
        catalogue=[paper_device("other", sensors=BOTH, times=300.0)],
    )


def rendered(found, width=80):
    """Return what a terminal of a width shows with --full."""
    return on_terminal(comparison_answer(found, full=True), width)


def brief(found, width=80):
    """Return what a terminal of a width shows."""
    return on_terminal(comparison_answer(found), width)


# Numbers


@pytest.mark.parametrize(
    ("value", "interval", "printed"),
    [
        (0.9588, (0.9515, 0.9673), ("95.9", ("95.2", "96.7"))),
        (0.858, (0.8579, 0.9781), ("85.8", ("85.8", "97.8"))),
        (0.061592, (0.061592, 0.061592), ("6.16", ())),
        (0.025, (0.025, 0.025), ("2.50", ())),
        (0.99999, (0.99999, 0.99999), ("99.999", ())),
        (0.9996, (0.9996, 0.9996), ("99.96", ())),
        (1.0004, (1.0004, 1.0004), ("100.04", ())),
        (1.0 - 1e-8, (1.0 - 1e-8, 1.0 - 1e-8), ("<100", ())),
        (1.0 + 1e-8, (1.0 + 1e-8, 1.0 + 1e-8), (">100", ())),
        (1.0, (1.0, 1.0), ("100", ())),
        (6.0477, (6.0477, 6.0477), ("605", ())),
    ],
)
def test_parts_of_a_limit(value, interval, printed):
    """To the digit of the part, or the first of the sampling; 100 only where met."""
    assert print_parts(value, interval) == printed


@pytest.mark.parametrize(
    ("p", "printed"),
    [
        (Probability(value=1.0, low=0.99977, high=1.0), ">99.9"),
        (Probability(value=1.0, low=0.5, high=1.0), ">50"),
        (Probability(value=0.0, low=0.0, high=0.0002), "<0.02"),
        # Up: nobody knows that it is below 0.0009 %.
        (Probability(value=0.0, low=0.0, high=9.22e-6), "<0.001"),
        (Probability(value=0.0, low=0.0, high=2.31e-6), "<0.0003"),
        (Probability(value=1.0, low=1.0 - 3.69e-5, high=1.0), ">99.99"),
        (Probability(value=0.7512, low=0.745, high=0.757), "75.1"),
        (Probability(value=0.99994, low=None, high=None), ">99.9"),
        (Probability(value=1.0, low=None, high=None), ">99.9"),
        (Probability(value=0.00006, low=None, high=None), "<0.1"),
        (Probability(value=0.9987, low=None, high=None), "99.9"),
    ],
)
def test_probabilities_claim_no_more_than_is_known(p, printed):
    """All of the trials inside is not 100 %, none of them is not 0 %."""
    assert print_probability(p) == printed


def test_factor_of_a_source_that_cannot_mend_is_empty():
    """No factor is no number; a huge one is not printed in digits."""
    texts = [
        print_factor(Remedy(source="s", share=1.0, factor=factor))
        for factor in (None, 0.5, 1e5)
    ]
    assert texts == ["", "0.500", ">1000"]


def test_ties_share_a_rank(comparison):
    """Of four, the middle two tied: 1, 2=, 2=, 4."""
    sure, tied = (Lead(other="", probability=p) for p in (1.0, 0.5))
    ranks = numbered(["meets"] * 4, [sure, tied, sure, None])
    rows = [
        replace(comparison.devices[0], rank=rank, is_tied=is_tied)
        for rank, is_tied in ranks
    ]

    assert [one.printed_rank for one in rows] == ["1", "2=", "2=", "4"]


# Terminal


@pytest.mark.parametrize("width", [60, 80, 160])
def test_terminal_names_every_device_once_a_table(comparison, width):
    """At any width each device stands where it is judged, or asked for, best first."""
    text = rendered(comparison, width)

    for name in ("good", "bad <b>"):
        assert len(re.findall(rf"(?m)^{name} ", text)) >= 2
    assert re.search(r"(?m)^bare +bias stability", text)
    assert text.index("\ngood ") < text.index("\nbad <b> ") < text.index("\nbare ")


@pytest.mark.parametrize("answer", [rendered, brief])
def test_no_table_is_split_at_80_columns(comparison, answer):
    """Each table stands whole, whatever its devices are called."""
    long = replace(
        comparison,
        devices=tuple(
            replace(one, name=f"{one.name}, a device of a long name, revision 7")
            for one in comparison.devices
        ),
    )
    for found in (comparison, long):
        text = answer(found)
        assert max(map(len, text.splitlines())) <= 80
        assert len(re.findall(r"(?m)^device +verdict ", text)) == 1


def test_brief_answer_says_who_meets_and_whom_to_ask(comparison):
    """Counts, the best with what it uses and why, and the specification to ask for."""
    text = " ".join(brief(comparison).split())

    assert_says(text, "MET: 1 of 3 gyros, 1 of 3 accelerometers meet")
    assert re.search(r"good meets +\S+ .*repeatability", text)
    assert_says(text, "gyro: bare, not given: bias stability")


def test_brief_answer_is_brief():
    """Of sixty devices some stand there, the rest are counted."""
    devices = [only_bias(f"d{n}", 0.1 + 0.1 * n) for n in range(60)]
    found = compared(devices, method="gum")
    text = brief(found)

    assert len(text.splitlines()) <= 25
    assert len(re.findall(r"(?m)^d\d+ ", text)) == 3
    assert len(re.findall(r"(?m)^d\d+ ", rendered(found))) == 60


def test_terminal_says_what_missing_lines_could_do(comparison):
    """What to ask for stands beside the device that waits for it, which has no rank."""
    text = rendered(comparison, 160)

    assert "fails from" in text
    assert re.search(r"(?m)^bare +bias stability", text)


def test_terminal_of_complete_devices_asks_for_nothing():
    """Where nothing is missing, nothing is said about it."""
    text = rendered(compared([paper_device("a", times=0.5)], method="gum"), 160)

    assert "fails from" not in text
    assert "interval" not in text.partition("Method")[0]


def test_a_factor_is_explained_where_there_is_one():
    """Where no source alone can mend anything, there is none and nothing is said."""
    for times, expected in ((1e4, False), (0.5, True)):
        text = rendered(compared([paper_device(times=times)], method="gum"), 160)

        assert ("by itself it cannot" in text) is expected


def test_sorting_keeps_the_rank(comparison):
    """Sorted by device, each keeps the rank it had."""
    by_rank = {r.device: r.rank for r in rankings(comparison)[0].rows}
    rows = rankings(comparison, order=find_column("device").order)[0].rows

    assert [r.device for r in rows] == sorted(by_rank)
    assert {r.device: r.rank for r in rows} == by_rank


@pytest.mark.parametrize("column", RANKING, ids=lambda column: column.key)
def test_every_column_can_be_sorted_by(comparison, column):
    """Its key and its head name a column, and it has an order."""
    assert find_column(column.key) is column
    assert find_column(column.head) is column
    assert len(rankings(comparison, order=column.order)[0].rows) == 3


def test_unknown_column_says_the_nearest():
    """An unknown column is refused with the one that was meant."""
    with pytest.raises(CallError, match="did you mean 'utilisation'"):
        find_column("utilization")


def test_pairs_are_counted_beyond_twenty():
    """Five gyros and five accelerometers: 20 pairs shown, 5 counted."""
    devices = [
        paper_device(f"d{n}", sensors=BOTH, times=0.1 + 0.1 * n) for n in range(5)
    ]
    found = compared(devices, requirement(sensors=BOTH), pairs=True, method="gum")
    text = rendered(found, 120).partition("Pairs")[2]

    assert len(re.findall(r"(?m)^d\d +d\d ", text)) == 20
    assert "5 more pairs" in " ".join(text.split())


# Documents


def test_documents_agree(comparison):
    """CSV and JSON hold the same numbers, a row for each device and output."""
    rows = list(csv.DictReader(to_csv(comparison)))
    devices = json.loads(json_text(comparison.to_dict()))["devices"]

    flat = [output["utilisation"] for one in devices for output in one["outputs"]]
    assert [float(row["utilisation"]) for row in rows] == flat
    assert len(flat) == 6 * 12


def test_document_is_in_printed_units(comparison):
    """A limit of one degree an hour is 1 deg/h in the document."""
    outputs = comparison.to_dict()["devices"][0]["outputs"]
    (bias,) = (o for o in outputs if (o["parameter"], o["axis"]) == ("bias", "x"))

    assert bias["unit"] == "deg/h"
    assert round(bias["limit"], 12) == 1.0


# Figures and page


def test_map_frames_what_is_beyond_the_limit():
    """A frame for each cell beyond its limit, none for others; equal axes are one."""
    found = compared([only_bias("over", 3.0), only_bias("under", 0.1)], method="gum")
    figure = draw(map_chart(rankings(found)[0], "map", None))
    frames = [p for p in figure.axes[0].patches if p.get_facecolor()[3] == 0.0]

    assert len(frames) == 1  # three equal biases of one device


def test_columns_of_the_map_are_what_devices_use_alike(comparison):
    """Outputs in one column use the same of each device; each is in one column."""
    table = rankings(comparison)[0]
    (head, *_) = draw(map_chart(table, "map", None)).axes
    bars = [p for p in head.patches if p.get_facecolor()[3] > 0.0]
    kinds = {
        (one.output.name.quantity, used_part(one).text)
        for one in table.decided[0].of.outputs
    }

    assert len(bars) == len(table.decided) * len(kinds)


def test_names_that_differ_in_the_end_stay_apart():
    """Of a long name the middle goes."""
    names = [f"A device of a rather long name, rev. 31 ({n} g)" for n in (5, 10)]

    assert len({fit_name(name, 26) for name in names}) == 2
    assert max(len(fit_name(name, 26)) for name in names) <= 26
    assert fit_name("short", 26) == "short"


def test_every_dot_of_a_front_has_its_name_or_there_is_none():
    """Devices that crowd have no figure, and why is said; a few have their names."""

    def ranking(number):
        devices = [
            replace(only_bias(f"device {n}", 0.1 + 0.001 * n), mass=f"{1 + n} kg")
            for n in range(number)
        ]
        return rankings(compared(devices, method="gum"))[0]

    few = ranking(3)
    told = {text.get_text() for text in front_plot(few, "mass").figure.axes[0].texts}
    assert told == {f"device {n}" for n in range(3)}

    assert "no room" in front_plot(ranking(40), "mass")


def test_front_is_joined(comparison):
    """The line of the scatter goes through the devices on the front, cheapest first."""
    table = rankings(comparison)[0]
    (front, *_) = (line for line in front_plot(table, "mass").figure.axes[0].lines[1:])
    best = [row for row in table.rows if "mass" in row.of.on_front]

    assert sorted(front.get_xdata()) == list(front.get_xdata())
    assert len(front.get_xdata()) == len(best) > 0


def test_words_beside_figures_have_the_numbers(comparison):
    """Alternative texts name every device with its part of the limit."""
    table = rankings(comparison)[0]
    for text in (
        map_chart(table, "map", None).alt,
        front_plot(table, "mass").picture.alt,
    ):
        for row in table.decided:
            assert row.device in text
            assert f" {row.utilisation}" in text


def test_no_text_of_a_figure_is_cut(comparison):
    """Names, verdicts, numbers and the axes lie within the figure."""
    table = rankings(comparison)[0]

    assert cut_texts(draw(map_chart(table, "map", None))) == []
    assert cut_texts(front_plot(table, "mass").figure) == []


@pytest.fixture(scope="module")
def document(comparison):
    """Return the document of the comparison."""
    return comparison_document(comparison, date=DATE, command_line="budget compare x")


def test_document_answers_first(document):
    """Counts, the best of each sensor, who is judged, whom to ask, cautions."""
    assert document.headline == (
        "MET: 1 of 3 gyros, 1 of 3 accelerometers meet test requirement"
    )
    assert [card.title for card in document.cards] == ["Gyro", "Accelerometer"]
    for card in document.cards:
        text = " ".join(lines(card))
        assert "good is best" in text
        assert "% of the limit" in text
        assert "1 meet, 1 undecidable, 1 fail" in text
    first = [part.name for part in document.sections if part.on_first_page]
    told = ["decided", "not-judged", "remarks"]
    assert first == names(document)[: len(first)] == told


def test_document_of_nobody_who_meets_says_so():
    """Without a device that meets, headline, summary and card say so."""
    found = compared([only_bias("over", 3.0)], method="gum")
    document = comparison_document(found, date=DATE)

    assert document.headline == "NOT MET: 0 of 1 gyro meets test requirement"
    assert "No device meets" in lines(document.cards[0])


def test_the_ranking_holds_every_number_exactly(comparison, document):
    """Each device that can be judged stands there once a sensor, best first."""
    (table,) = (t for t in find(document, Table) if t.name == "ranking")
    heads = [column.head for column in table.columns]
    gyro, accelerometer, imu = table.groups

    for group, found in zip((gyro, accelerometer), rankings(comparison), strict=True):
        assert group.title == found.subject
        for cells, row in zip(group.rows, found.decided, strict=True):
            by_head = dict(zip(heads, cells, strict=True))
            assert by_head["device"].text == row.device
            assert by_head["% of limit"].exact == 100.0 * row.of.utilisation
            assert by_head["conformance [%]"].exact == 100.0 * row.of.conformance.value
            assert by_head["device"].strong == (row.verdict == "meets")
            assert by_head["mass"].text == row.of.mass
    assert [cells[0].text for cells in imu.rows] == ["good", "bad <b>"]
    assert heads[1:3] == ["verdict", "% of limit"]  # what a narrow page shows


@pytest.mark.parametrize("method", ["gum", "monte-carlo"])
def test_the_conformance_of_the_screen_says_what_it_is(method):
    """What no trial was drawn for is of the normal law, in every table of it."""
    both = ("gyro", "accelerometer")
    found = compared(
        [paper_device(sensors=both)], requirement(sensors=both), method=method
    )
    tables = find(
        comparison_document(found, date=DATE, command_line="budget compare x"), Table
    )
    heads = {
        column.head
        for table in tables
        for column in table.columns
        if column.head.startswith("conformance")
    }
    by_law = {"conformance by the normal distribution [%]"}
    assert heads == (by_law if method == "gum" else {"conformance [%]"})


def test_the_map_has_its_data_behind_it(comparison, document):
    """The table of each map has every device and output; each cell has its tip."""
    maps = [p for p in find(document, Picture) if p.name.startswith("map")]

    assert len(maps) == 2
    for picture, table in zip(maps, rankings(comparison), strict=True):
        (group,) = picture.data.groups
        for cells, row in zip(group.rows, table.decided, strict=True):
            expected = [100.0 * output.utilisation for output in row.of.outputs]
            assert [cell.exact for cell in cells[1:]] == expected
            assert [cell.strong for cell in cells[1:]] == [x > 100.0 for x in expected]
        assert "good, gyro scale factor x, y, z: " in "".join(maps[0].tips.values())


def test_every_cell_and_point_has_a_tip(document):
    """Maps and fronts have tips for each device, in an element of the figure."""
    pictures = find(document, Picture)

    assert {p.name.partition("-")[0] for p in pictures} == {"map", "front"}
    for picture in pictures:
        told = "".join(picture.tips.values())
        assert "good" in told
        assert "bad <b>" in told
        for gid in picture.tips:
            assert f'id="{picture.name}-{gid}"' in picture.svg


def test_what_is_not_given_is_asked_of_its_maker(comparison):
    """A row names devices, maker, specifications and from where on it would fail."""
    found = replace(
        comparison, devices=tuple(replace(d, vendor="ACME") for d in comparison.devices)
    )
    document = comparison_document(found, date=DATE)
    (table,) = find(section(document, "not-judged"), Table)

    assert [group.title for group in table.groups] == ["Gyro", "Accelerometer"]
    for devices, ask, maker, bound in rows(table):
        assert (devices, maker) == ("bare", "ACME")
        assert ask == "bias stability"
        assert bound


def test_requests_that_are_alike_are_gathered():
    """Devices of one maker that lack the same are one row, of another one their own."""
    devices = [
        replace(
            paper_device(f"d{n}", times=0.4, missing=("bias_stability",)),
            vendor="ACME" if n < 2 else "Other",
        )
        for n in range(3)
    ]
    other = [paper_device("other", times=300.0)]
    found = requests(compared(devices, catalogue=other, method="gum"))

    assert [one.names for one in found] == [["d0", "d1"], ["d2"]]


def test_long_tables_can_be_searched():
    """A ranking of eight devices is searchable, one of three is not."""
    for number, expected in ((3, False), (8, True)):
        devices = [only_bias(f"d{n}", 0.1 + 0.1 * n) for n in range(number)]
        document = comparison_document(compared(devices, method="gum"), date=DATE)
        ranking = next(t for t in find(document, Table) if t.name == "ranking")
        assert ranking.searchable is expected


def test_names_are_unique_in_a_document_and_beside_one(comparison, document):
    """Sections, tables and pictures share no name; sections in a report neither."""
    for parts in (document.sections, comparison_sections(comparison)):
        found = [part.name for part in parts]
        found += [p.name for p in find(parts, Picture)]
        found += [t.name for t in find(parts, Table)]
        assert len(found) == len(set(found)) > 10


def test_sections_in_a_report_begin_with_the_answer(comparison):
    """The first section states the verdict; none claims the report's first page."""
    first, *others = comparison_sections(comparison)

    assert first.title == "Comparison against test requirement"
    assert_says(" ".join(lines(first)), "MET: 1 of 3 gyros")
    assert not any(part.on_first_page for part in (first, *others))
    assert [p.name for p in find(others, Picture) if p.name.startswith("map")]


def test_procedures_stand_beside_each_other_in_the_document():
    """Under two procedures each sensor has a table with a column for each."""
    from builders import procedure

    slow = replace(procedure(rate=2.0), name="slow")
    found = compared(
        [only_bias("a", 0.1)], procedures=(procedure(), slow), method="gum"
    )
    document = comparison_document(found, date=DATE)
    (table,) = find(section(document, "procedures"), Table)

    assert [c.head for c in table.columns] == ["device", "test procedure", "slow"]
    assert [card.title for card in document.cards] == [
        "Gyro, test procedure",
        "Gyro, slow",
    ]
    # Figures of two procedures are told apart by what they say.
    titles = [p.title for p in find(document.sections, Picture)]
    assert [title.partition(":")[0] for title in titles] == [
        "Gyro, test procedure",
        "Gyro, slow",
    ]


def test_assumptions_of_several_devices_are_gathered(comparison):
    """What is assumed of two devices alike is one row that names both."""
    alike = "gyro.bias_stability: correlation time not given, 300 s assumed"
    found = replace(
        comparison,
        assumptions=(f"good: {alike}", f"bare: {alike}", "gravity: not given"),
    )
    document = comparison_document(found, date=DATE)

    assert rows(section(document, "assumptions")) == [
        (
            "gyro bias stability",
            "correlation time not given, 300 s assumed",
            "good, bare",
        ),
        ("gravity", "not given", ""),
    ]


def test_without_costs_there_is_no_front_and_it_is_said():
    """Where no device gives price, mass or power, the document says so."""
    found = compared([paper_device()], method="gum")
    text = " ".join(lines(comparison_document(found, date=DATE)))

    assert_says(text, "price: no device gives one that can be compared")


def test_page_harms_nobody_and_holds_the_numbers(comparison, document):
    """Names are text, not markup; nothing is fetched; the JSON is in the page."""
    page = render_page(document)

    assert "bad &lt;b&gt;" in page
    assert "bad <b>" not in page
    assert not re.search(r'(src|href)="https?:', page)
    script = r'id="comparison-json"[^>]*>(.*?)</script>'
    embedded = re.search(script, page, re.DOTALL)[1]
    assert json.loads(embedded) == json.loads(json_text(comparison.to_dict()))


def test_page_has_unique_ids(document):
    """Figures of several tables share no id."""
    ids = re.findall(r'\bid="([^"]+)"', render_page(document))

    assert len(ids) == len(set(ids)) > 10


def test_the_same_comparison_gives_the_same_bytes(comparison, forget_drawings):
    """Page and PDF are the same twice."""
    first = comparison_document(comparison, date=DATE)
    forget_drawings()
    again = comparison_document(comparison, date=DATE)

    assert render_page(first) == render_page(again)
    assert typeset(first).pdf == typeset(again).pdf
