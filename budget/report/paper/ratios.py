"""The random entries of Table 1 over ours: which rows of the paper are far off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.figures.picture import as_picture
from budget.report.figures.rows import write_beside
from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    canvas,
    house_style,
)
from budget.report.paper.printing import print_ratio
from budget.report.paper.tables import place_of
from budget.studies.paper.findings import Verdict
from budget.ties import first_largest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

ROW = 12.5  # [pt] from row to row
LEFT, RIGHT, TOP, BELOW = 180.0, 36.0, 3.0, 31.0  # [pt]
NAMES = 112.0  # [pt] from the left edge to the names of the parameters
AIR = 2.0  # times the farthest ratio to the end of the axis [1]
FITS = frozenset({Verdict.FITS_MEAN, Verdict.FITS_SINGLE})
JOINED = ", all "  # in the place of a row that speaks of all axes


def ratio_picture(study: PaperStudy) -> Picture:
    """Return the ratios of all random rows as a block; the table has them too."""
    rows = _rows(study)
    return as_picture(
        ratio_marks(study),
        name="ratios",
        title=ratio_title(study),
        alt=ratio_alt(study),
        tips={
            f"tip-{place}": f"{_name(row)}: {print_ratio(row.ratio)} times the printed "
            f"root mean square; {row.verdict}"
            for place, row in enumerate(rows)
        },
        caption=(
            "Ours: u of a single run, or of a mean over 25 where the row fits that. "
            "Filled: fits; open: does not"
            + ("; bold: and nothing explains it." if _is_open(rows) else ".")
        ),
    )


@house_style()
def ratio_marks(study: PaperStudy) -> Figure:
    """Draw u over the printed root mean square, a dot for each random row."""
    rows = _rows(study)
    figure, axes = canvas(
        TOP + ROW * len(rows) + BELOW,
        left=LEFT,
        right=RIGHT,
        top=TOP,
        below=BELOW,
    )
    figure.set_label(ratio_title(study))
    ratios = [_ratio(row) for row in rows]
    axes.set_xscale("log")
    axes.set_xlim(min(*ratios, 1.0) / AIR, max(*ratios, 1.0) * AIR)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.minorticks_off()
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    axes.axvline(1.0, color=MUTED, linewidth=0.9, zorder=1)
    axes.set_xlabel("ours / printed, root mean square", fontsize=SMALL, color=MUTED)
    axes.set_yticks([])
    source = ""
    for place, (row, ratio) in enumerate(zip(rows, ratios, strict=True)):
        group, parameter = place_of(row).group, _parameter(row)
        if group != source:
            _write_name(figure, place, group, left=4.0)
            source = group
        _write_name(figure, place, parameter, left=NAMES)
        axes.plot(
            [ratio],
            [place],
            marker="o",
            markersize=5.5,
            color=INK if row.verdict in FITS else PAPER,
            markeredgecolor=INK,
            zorder=3,
            gid=f"tip-{place}",
        )
        strong = row.verdict == Verdict.UNEXPLAINED
        text = print_ratio(row.ratio)
        write_beside(axes, place, text, reach=RIGHT - 4.0, strong=strong)
    return figure


def ratio_title(study: PaperStudy) -> str:
    """State the finding: how many rows fit, and the farthest."""
    rows = _rows(study)
    fits = sum(row.verdict in FITS for row in rows)
    far = rows[first_largest([max(_ratio(row), 1.0 / _ratio(row)) for row in rows])]
    return (
        f"{fits} of the {len(rows)} random rows of Table 1 fit; farthest off is "
        f"{_name(far)}, {print_ratio(far.ratio)} times the printed"
    )


def ratio_alt(study: PaperStudy) -> str:
    """Say in words with numbers what the dots show."""
    said = "; ".join(
        f"{_name(row)} {print_ratio(row.ratio)} ({row.verdict})" for row in _rows(study)
    )
    return f"{ratio_title(study)}. Ours over printed: {said}."


def _rows(study: PaperStudy) -> list[Finding]:
    """Return the rows that speak of all random entries of one parameter."""
    return [
        row
        for row in study.of_section("table 1")
        if row.is_summary and row.ratio is not None and JOINED in row.where
    ]


def _is_open(rows: list[Finding]) -> bool:
    """Whether nothing explains one of them."""
    return any(row.verdict == Verdict.UNEXPLAINED for row in rows)


def _ratio(row: Finding) -> float:
    """Return the ratio of a row that has one."""
    if row.ratio is None:
        raise ValueError(f"{row.where}: no ratio to draw, expected a random entry")
    return row.ratio


def _parameter(row: Finding) -> str:
    """Name the parameter: 'mounting angle'."""
    return place_of(row).name.partition(JOINED)[0]


def _name(row: Finding) -> str:
    """Name a row in a sentence: 'angle random walk on bias'."""
    group = place_of(row).group
    return f"{group[:1].lower()}{group[1:]} on {_parameter(row)}"


def _write_name(figure: Figure, place: int, text: str, *, left: float) -> None:
    """Write a name beside the row at a place."""
    (axes,) = figure.axes
    axes.annotate(
        text,
        (0.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(left - LEFT, 0.0),
        textcoords="offset points",
        fontsize=SMALL,
        color=INK,
        va="center_baseline",
    )
