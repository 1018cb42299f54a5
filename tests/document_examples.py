"""A document made by hand, with every kind of block, for the tests of the renderers."""

from __future__ import annotations

import json
from functools import cache

from report_examples import make_assessment, make_budget

from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Column,
    Document,
    Equation,
    Equations,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Picture,
    RowGroup,
    Run,
    Section,
    Sliders,
    Table,
)
from budget.report.figures.outputs import utilisation_chart
from budget.report.figures.rows import draw
from budget.report.figures.sources import share_chart
from budget.report.figures.style import to_svg
from budget.report.formulas import Math
from budget.report.tables import group_tables

DATE = "2026-01-31"
VERSION = "0.4"
SHA = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"


def make_table(name="u", **changes):
    """Return a table with all kinds of columns, groups, bars and notes."""
    fields = {
        "caption": "Standard uncertainties of the gyro, source by source",
        "columns": (
            Column(head="source"),
            Column(head="u of the bias [deg/h]", kind="number"),
            Column(head="share of the variance [%]", kind="number"),
            Column(head="u", kind="number"),
            Column(head="unit", kind="unit"),
            Column(head="where it comes from", weight=2.0),
        ),
        "groups": (
            RowGroup(
                title="gyro bias",
                rows=(
                    row("bias repeatability", "0.050", "79", "0.05", "deg/h"),
                    row("bias stability", "0.026", "20", "0.04", "deg/h"),
                    row("angle random walk", "8.7e-3", "1", "0.005", "deg/sqrt(h)"),
                ),
            ),
            RowGroup(
                title="gyro scale factor",
                rows=(
                    row("scale factor repeatability", "120", "<0.1", "50", "ppm"),
                    row("mounting repeatability", "-2.3e-9", "0", "2.0", "arcsec"),
                ),
            ),
        ),
    }
    return Table(name=name, **(fields | changes))


def row(source, u, share, given, unit):
    """Return one row of that table."""
    bar = float(share) / 100.0 if share[0].isdigit() else None
    return (
        Cell(text=source, strong=share == "79"),
        Cell(text=u, exact=float(u)),
        Cell(text=share, exact=bar, share=bar),
        Cell(text=given, exact=float(given)),
        Cell(text=unit),
        Cell(text="table 2 <rev B>", note="at -40 to 71 degC"),
    )


@cache  # pictures are drawn once; what is made here nobody can change
def make_picture(place=2, name="shares-gyro-bias", **changes):
    """Return the share bars of one group, as the report draws them."""
    group = group_tables(make_budget())[place]
    chart = share_chart(group)
    fields = {
        "title": chart.title,
        "alt": chart.alt,
        "svg": to_svg(draw(chart), name=name),
        "caption": "Each bar is the whole variance of one output.",
    }
    return Picture(name=name, **(fields | changes))


@cache
def make_overview(name="limits"):
    """Return the dots of all outputs against their limits."""
    chart = utilisation_chart(make_assessment(make_budget()))
    return Picture(
        name=name,
        title=chart.title,
        alt=chart.alt,
        svg=to_svg(draw(chart), name=name),
        data=make_table("limits-data"),
        is_wide=True,
    )


def make_equations():
    """Return formulas with every kind of part."""
    sources = {
        "K_x = n_(x 2)/(4 pi m)": "(3)",
        "delta_(y z) = -n_(y 2)/n_(y 3)": "",
        "epsilon = macron(N)/K - (I + T^upright(T)) omega sin L": "(4)",
        "u^2 = 0.25 times g": "",
    }
    return Equations(
        equations=tuple(
            Equation(math=Math(source=source), number=number)
            for source, number in sources.items()
        )
    )


def first_page(overview):
    """Return the sections of page one."""
    return (
        Section(
            name="overview", title="Limits", on_first_page=True, blocks=(overview,)
        ),
        Section(
            name="contributions",
            title="The five largest contributions",
            on_first_page=True,
            blocks=(
                Listing(
                    numbered=True,
                    empty="Nothing varies.",
                    items=tuple(
                        (
                            Run(text=contribution, strong=True),
                            " contributes ",
                            Run(text="79 %", exact=0.7912345),
                            " of the gyro bias variance (alone u 0.050 deg/h).",
                        )
                        for contribution in (
                            "Gyro bias repeatability (0.05 deg/h)",
                            "Accelerometer bias repeatability (37 ug)",
                            "Gyro mounting repeatability (2 arcsec)",
                            "Accelerometer mounting repeatability (2 arcsec)",
                            "Gyro scale factor repeatability (50 ppm)",
                        )
                    ),
                ),
            ),
        ),
        Section(
            name="open",
            title="What is open",
            on_first_page=True,
            blocks=(
                Abreast(
                    columns=3,
                    blocks=(
                        Panel(
                            title="Not given",
                            blocks=(
                                Listing(
                                    empty="All is given.",
                                    items=(("Gyro rate random walk: it would grow.",),),
                                ),
                            ),
                        ),
                        Panel(
                            title="Assumptions",
                            blocks=(
                                Listing(
                                    empty="None.",
                                    items=(
                                        ("Gravity is that of WGS 84, 9.7966933 m/s^2",),
                                        ("2 arcsec is a largest value, uniform",),
                                    ),
                                ),
                            ),
                        ),
                        Panel(
                            title="Warnings",
                            blocks=(Listing(empty="None.", items=()),),
                        ),
                    ),
                ),
            ),
        ),
    )


def later_pages():
    """Return the sections after the contents."""
    long_rows = RowGroup(
        rows=tuple(
            row(f"source {k}", "0.050", str(k % 100), "0.05", "deg/h")
            for k in range(1, 90)
        )
    )
    return (
        Section(
            name="budget",
            title="Budget",
            blocks=(
                Paragraph(
                    words=(
                        "U95 is half the width of the 95 % interval, ",
                        Math(source="u_c"),
                        " the combined standard uncertainty of all sources.",
                    )
                ),
                Paragraph(
                    words=("Each line is what that source does alone.",), small=True
                ),
                make_table(),
                Abreast(
                    blocks=(
                        make_picture(0, "shares-scale", data=make_table("scale-data")),
                        make_picture(1, "shares-angle"),
                        make_picture(2, "shares-bias"),
                    )
                ),
            ),
        ),
        Section(
            name="what-if",
            title="What if",
            blocks=(Sliders(model=make_model(), table=make_table("what-if-table")),),
        ),
        Section(
            name="inputs",
            title="Inputs",
            blocks=(
                make_table(
                    "inputs-gyro",
                    groups=(long_rows,),
                    is_wide=True,
                    searchable=True,
                ),
            ),
        ),
        Section(
            name="method",
            title="Method",
            blocks=(
                Pairs(
                    rows=(
                        ("seed", ("0",)),
                        ("coverage", (Run(text="95 %", exact=0.95),)),
                        ("formula", ("the mean of ", Math(source="macron(N)"), ".")),
                    )
                ),
                Panel(title="Formulas, eq. (3) and (4)", blocks=(make_equations(),)),
                Table(
                    name="files",
                    caption="Every file that was read, with its hash",
                    columns=(
                        Column(head="input"),
                        Column(head="file"),
                        Column(head="SHA-256", kind="code"),
                    ),
                    groups=(
                        RowGroup(
                            rows=(
                                (
                                    Cell(text="device"),
                                    Cell(text="zhao-2019.yaml"),
                                    Cell(text=SHA),
                                ),
                            )
                        ),
                    ),
                ),
            ),
        ),
    )


def make_model():
    """Return what sliders compute from: one source, one output."""
    return {
        "coverage": 0.95,
        "most": 1e6,
        "sensors": [
            {
                "name": "gyro",
                "title": "gyro",
                "missing": [],
                "doubt": [1.0, 1.0],
                "verdict": "",
                "is_open": False,
                "conditions": [],
                "saturates": False,
            }
        ],
        "sources": [
            {
                "name": "gyro.bias_repeatability",
                "owner": "gyro",
                "quantity": "bias_repeatability",
                "title": "gyro bias repeatability",
                "u": 0.05,
                "unit": "deg/h",
                "printed": "0.05 deg/h",
                "decides": ["gyro", "mission"],
            },
            {
                "name": "gyro.bias_stability",
                "owner": "gyro",
                "quantity": "bias_stability",
                "title": "gyro bias stability",
                "u": 0.04,
                "unit": "deg/h",
                "printed": "0.04 deg/h",
                "decides": ["gyro", "mission"],
            },
        ],
        "outputs": [
            {
                "name": "gyro.bias.x",
                "sensor": "gyro",
                "lower_bound": False,
                "title": "gyro bias x",
                "group": "gyro bias",
                "axis": "x",
                "unit": "deg/h",
                "value": 0.0,
                "factor": 1.959963984540054,
                "shift": 0.0,
                "is_timed": False,
                "length": None,
                "limit": 0.15,
                "resolution": 1e-12,
                "added": [0.0, 0.0, 0.0],
            }
        ],
        "mean": [[0.001], [0.0]],
        "first": [[0.0025], [0.0016]],
        "second": [[1e-6], [0.0]],
        "pairs": [
            {
                "sources": ["gyro.bias_repeatability", "gyro.bias_stability"],
                "variance": [2e-6],
            }
        ],
    }


def make_document(**changes):
    """Return a document with every kind of block."""
    fields = {
        "kind": "report",
        "title": "Zhao 2019 optical IMU",
        "facts": ("procedure Zhao 2019", "latitude 34.2394 deg"),
        "headline": "FAILS tactical grade",
        "summary": (
            Run(text="3 of 24", strong=True),
            " required outputs exceed their limits, most of all gyro bias z: ",
            Run(text="U95 0.12 deg/h", exact=0.1234567),
            ", limit 0.1 deg/h. Errors are counted from the nominal values.",
        ),
        "cards": (
            Card(
                title="Gyro: FAILS",
                lines=(
                    ("Worst output: gyro bias z, ", Run(text="123 %", exact=1.2345)),
                    ("Because: bias repeatability 79 %, stability 20 %, rest 1 %",),
                ),
            ),
            Card(
                title="Accelerometer: MEETS",
                lines=(
                    ("Worst output: accelerometer bias z, 90 % of the limit",),
                    ("Because: bias repeatability 82 %, rest 18 %",),
                ),
            ),
        ),
        "sections": (*first_page(make_overview()), *later_pages()),
        "json": json.dumps({"schema": "budget/1", "text": "</script><b>"}),
        "date": DATE,
        "version": VERSION,
    }
    return Document(**(fields | changes))
