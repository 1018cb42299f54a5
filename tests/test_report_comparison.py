"""A comparison as texts, documents, figures and page."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace

import pytest
from comparison_examples import compared, only_bias, paper_device, requirement
from rich.console import Console

from budget.errors import CallError
from budget.report.comparison import figures
from budget.report.comparison.document import to_csv, to_dict, to_json
from budget.report.comparison.html import render_html
from budget.report.comparison.tables import (
    COLUMNS,
    find_column,
    print_factor,
    print_parts,
    print_probability,
    ranks,
    tables,
)
from budget.report.comparison.terminal import render_comparison
from budget.studies.comparison.records import Ahead, Probability, Remedy

BOTH = ("gyro", "accelerometer")


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
        catalogue=[paper_device("other", sensors=BOTH, times=3.0)],
    )


def rendered(found, width=80, **options):
    """Return what a terminal of a width shows."""
    console = Console(width=width, record=True, file=io.StringIO())
    render_comparison(found, console, **options)
    return console.export_text()


# Numbers


@pytest.mark.parametrize(
    ("value", "interval", "printed"),
    [
        (0.9588, (0.9515, 0.9673), ("95.9", "95.2 to 96.7")),
        (0.061592, (0.061592, 0.061592), ("6.16", "")),
        (0.025, (0.025, 0.025), ("2.50", "")),
        (0.99999, (0.99999, 0.99999), ("<100", "")),
        (1.00001, (1.00001, 1.00001), (">100", "")),
        (1.0, (1.0, 1.0), ("100", "")),
        (6.0477, (6.0477, 6.0477), ("605", "")),
    ],
)
def test_parts_of_a_limit(value, interval, printed):
    """To the first digit of the sampling, or three; 100 only where it is met."""
    assert print_parts(value, interval) == printed


@pytest.mark.parametrize(
    ("p", "printed"),
    [
        (Probability(value=1.0, low=0.99977, high=1.0), ">99.9"),
        (Probability(value=1.0, low=0.5, high=1.0), ">50"),
        (Probability(value=0.0, low=0.0, high=0.0002), "<0.02"),
        (Probability(value=0.7512, low=0.745, high=0.757), "75.1"),
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
    row = comparison.devices[0]
    sure, tied = (Ahead(other="", probability=p) for p in (1.0, 0.5))
    rows = [replace(row, ahead=ahead) for ahead in (sure, tied, sure, None)]

    assert ranks(rows) == ("1", "2=", "2=", "4")


# Terminal


@pytest.mark.parametrize("width", [60, 80, 160])
def test_terminal_names_every_device_once_a_table(comparison, width):
    """At any width each device stands in the table of each sensor, best first."""
    text = rendered(comparison, width)

    for name in ("good", "bare", "bad <b>"):
        assert len(re.findall(rf"(?m)^ *\d=? +{name} ", text)) >= 2
    assert text.index("good") < text.index("bare") < text.index("bad <b>  ")


def test_terminal_says_what_missing_lines_could_do(comparison):
    """The device without a line carries its bound, and the line is named with owner."""
    text = rendered(comparison, 160)

    assert "at worst" in text
    assert "bias stability" in text
    assert "(of other)" in text


def test_terminal_of_complete_devices_has_no_such_column():
    """Where nothing is missing, columns about it are not there."""
    text = rendered(compared([paper_device("a", times=0.5)], method="gum"), 160)

    assert "at worst" not in text
    assert "interval:" not in text


def test_a_dash_is_explained():
    """Where no source alone can mend anything, the dashes are explained."""
    text = rendered(compared([paper_device(times=1e4)], method="gum"), 160)

    assert re.search(r"(?m)repeatability +-$", text)
    assert "it alone cannot" in text


def test_sorting_keeps_the_rank(comparison):
    """Sorted by device, each keeps the rank it had."""
    by_rank = {r.device: r.rank for r in tables(comparison)[0].rows}
    rows = tables(comparison, sort=find_column("device"))[0].rows

    assert [r.device for r in rows] == sorted(by_rank)
    assert {r.device: r.rank for r in rows} == by_rank


@pytest.mark.parametrize("column", COLUMNS, ids=lambda column: column.key)
def test_every_column_can_be_sorted_by(comparison, column):
    """Its key and its head name a column, and it has an order."""
    assert find_column(column.key) is column
    assert find_column(column.head) is column
    assert len(tables(comparison, sort=column)[0].rows) == 3


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
    assert "and 5 more" in text


# Documents


def test_documents_agree(comparison):
    """CSV and JSON hold the same numbers, a row for each device and output."""
    rows = list(csv.DictReader(io.StringIO(to_csv(comparison))))
    devices = json.loads(to_json(comparison))["devices"]

    flat = [output["utilisation"] for one in devices for output in one["outputs"]]
    assert [float(row["utilisation"]) for row in rows] == flat
    assert len(flat) == 6 * 12


def test_document_is_in_printed_units(comparison):
    """A limit of one degree an hour is 1 deg/h in the document."""
    outputs = to_dict(comparison)["devices"][0]["outputs"]
    (bias,) = (o for o in outputs if (o["parameter"], o["axis"]) == ("bias", "x"))

    assert bias["unit"] == "deg/h"
    assert round(bias["limit"], 12) == 1.0


# Figures and page


def test_map_frames_what_is_beyond_the_limit():
    """A frame for each cell beyond its limit, none for the others."""
    found = compared([only_bias("over", 3.0), only_bias("under", 0.1)], method="gum")
    figure = figures.utilisation_map(tables(found)[0])
    frames = [p for p in figure.axes[0].patches if p.get_linewidth() > 0.0]

    assert len(frames) == 3  # three biases of one device


def test_margin_bars_start_at_the_limit(comparison):
    """Every bar begins at 100 % and ends at the device's part of the limit."""
    table = tables(comparison)[0]
    bars = figures.margin_bars(table).axes[0].patches

    for bar, row in zip(bars, table.rows, strict=True):
        assert bar.get_x() == 100.0
        assert round(bar.get_width() + 100.0, 9) == round(100 * row.of.utilisation, 9)


def test_front_is_joined(comparison):
    """The line of the scatter goes through the devices on the front, cheapest first."""
    table = tables(comparison)[0]
    (front, *_) = (
        line for line in figures.pareto_scatter(table, "mass").axes[0].lines[1:]
    )
    best = [row for row in table.rows if "mass" in row.of.on_front]

    assert sorted(front.get_xdata()) == list(front.get_xdata())
    assert len(front.get_xdata()) == len(best) > 0


def test_words_beside_figures_have_the_numbers(comparison):
    """Alternative texts name every device with its part of the limit."""
    table = tables(comparison)[0]
    for text in (
        figures.map_alt(table),
        figures.margin_alt(table),
        figures.pareto_alt(table, "mass"),
    ):
        assert "good" in text
        assert "%" in text


def test_page_answers_first_and_harms_nobody(comparison):
    """The verdict comes first; names are text, not markup; nothing is fetched."""
    page = render_html(comparison, date="2026-01-01")

    assert "bad &lt;b&gt;" in page
    assert "bad <b>" not in page
    body = page.partition("<main>")[2]
    assert body.index("MET: test requirement") < body.index("<table")
    assert not re.search(r'(src|href)="https?:', page)
    embedded = page.partition('id="comparison">')[2].partition("</script>")[0]
    assert json.loads(embedded) == json.loads(to_json(comparison))


def test_page_has_unique_ids(comparison):
    """Figures of several tables share no id."""
    ids = re.findall(r'\bid="([^"]+)"', render_html(comparison, date="2026-01-01"))

    assert len(ids) == len(set(ids)) > 10


def test_page_is_the_same_every_time(comparison):
    """The same comparison gives the same bytes."""
    pages = {render_html(comparison, date="2026-01-01") for _ in range(2)}

    assert len(pages) == 1


def test_page_without_costs_says_so():
    """Where no device gives price, mass or power, the page says there is no front."""
    page = render_html(compared([paper_device()], method="gum"), date="2026-01-01")

    assert "there is no front to draw" in page
