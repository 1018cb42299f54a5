"""Figures: result in, matplotlib Figure out; each with a finding and words for it.

330 pt wide, readable on a telephone and two abreast on a desk. No pyplot and no global
state: the same result gives the same bytes, in any process.
"""

from __future__ import annotations

import io
import re
from itertools import groupby
from math import fsum
from typing import TYPE_CHECKING, Any

from budget.report.tables import (
    SMALL_SHARE,
    output_title,
    print_share,
    print_utilisation,
    source_title,
)
from budget.results import INTERACTION

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.tables import GroupTable
    from budget.results import Assessment, OutputAssessment

INK, MUTED, GRID, PAPER = "#1b1f24", "#6b7280", "#d5d9de", "#fefefe"
WIDTH = 330.0  # [pt]
TEXT, SMALL = 9.0, 8.0  # [pt]
INCH = 72.0  # [pt]

# Okabe and Ito's eight; the ninth source is the second of the scale factor, hatched.
ORANGE, SKY, GREEN, YELLOW = "#E69F00", "#56B4E9", "#009E73", "#F0E442"
BLUE, VERMILION, PURPLE, BLACK = "#0072B2", "#D55E00", "#CC79A7", "#000000"
ON_DARK, ON_LIGHT = "#ffffff", "#111111"  # text on a segment
OTHER = "other"
STYLES = {  # source: (colour, hatch, colour of text), in the order of the segments
    "bias_repeatability": (BLUE, "", ON_DARK),
    "bias_stability": (ORANGE, "", ON_LIGHT),
    "angle_random_walk": (GREEN, "", ON_LIGHT),
    "velocity_random_walk": (GREEN, "", ON_LIGHT),
    "sample_noise": (SKY, "", ON_LIGHT),
    "rate_random_walk": (PURPLE, "", ON_LIGHT),
    "acceleration_random_walk": (PURPLE, "", ON_LIGHT),
    "scale_factor_repeatability": (VERMILION, "", ON_LIGHT),
    "scale_factor_nonlinearity": (VERMILION, "////", ""),  # no text on a hatch
    "scale_factor_asymmetry": (BLACK, "", ON_DARK),
    "mounting_repeatability": (YELLOW, "", ON_LIGHT),
    INTERACTION: ("#9aa0a6", "xxxx", ""),
    OTHER: ("#c3c7cc", "", ON_LIGHT),
}
STYLE: dict[Any, Any] = {  # text stays text; ids do not change from run to run
    "svg.fonttype": "none",
    "svg.hashsalt": "budget",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # ships with matplotlib: same layout anywhere
    "hatch.linewidth": 0.8,
    "path.simplify": False,
}

BAR, PITCH = 15.0, 21.0  # height of a bar, and from bar to bar [pt]
ROW = 13.0  # [pt] from dot to dot
LEGEND_LINE = 13.0  # [pt]
VISIBLE = 0.002  # share below which a segment is thinner than a line [1]
MAJORITY = 0.5  # share of the variance [1]
LINEAR_BELOW = 4.0  # utilisations beyond need a logarithmic axis [1]


def share_bars(group: GroupTable) -> Figure:
    """Draw what causes each output's variance: a stacked bar for each output."""
    bars = [_segments(group, place) for place in range(len(group.rows))]
    left, right, top = 28.0, 8.0, 18.0
    span = WIDTH - left - right  # [pt] of the whole variance
    named = {
        source
        for source, share in bars[0]
        if source != OTHER and _fits(source_title(source), share * span)
    }
    seen = {name for bar in bars for name, share in bar if share >= VISIBLE}
    legend = [name for name in STYLES if name in seen and name not in named]
    below = 32.0 + LEGEND_LINE * ((len(legend) + 1) // 2)
    height = top + PITCH * len(bars) + below
    figure, axes = canvas(height, left=left, right=right, top=top, below=below)
    figure.set_label(share_title(group))
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(len(bars) - 0.5, -0.5)
    axes.set_yticks(range(len(bars)), [row.axis for row in group.rows])
    axes.set_xticks([0, 25, 50, 75, 100])
    axes.set_xlabel("share of the variance [%]", fontsize=SMALL, color=MUTED)
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    for place, bar in enumerate(bars):
        _draw_bar(axes, place, bar, span)
    start = 0.0
    for source, share in bars[0]:
        if source in named:
            axes.annotate(
                source_title(source),
                (100.0 * start, -BAR / PITCH / 2.0),
                xytext=(0.0, 3.0),
                textcoords="offset points",
                fontsize=SMALL,
                color=INK,
            )
        start += share
    _draw_legend(figure, legend, left)
    return figure


def share_title(group: GroupTable) -> str:
    """State the finding: what makes most of the variance of a group."""
    first, *others = group.sources
    if first.share.exact == 0.0:
        return f"The {group.title} has no spread"
    whole = f"of the {group.title} variance"
    if first.share.exact >= MAJORITY or not others:
        return f"{first.title.capitalize()} makes {first.share.text} {whole}"
    second = others[0]
    both = print_share(first.share.exact + second.share.exact)
    return f"{first.title.capitalize()} and {second.title} make {both} {whole}"


def share_alt(group: GroupTable) -> str:
    """Say in words with numbers what the bars show."""
    bars = []
    for place, row in enumerate(group.rows):
        parts = [
            f"{source_title(source)} {print_share(share)}"
            for source, share in _segments(group, place)
        ]
        bars.append(f"{row.axis}: {', '.join(parts) or 'no spread'}")
    return f"{share_title(group)}. Shares of the variance by axis. {'; '.join(bars)}."


def utilisation_dots(assessment: Assessment) -> Figure:
    """Draw each required output's largest error against its limit, worst first."""
    groups = _by_group(assessment)
    left, right, top, below = 24.0, 46.0, 18.0, 32.0
    rows = len(assessment.outputs) + len(groups)
    figure, axes = canvas(
        top + ROW * rows + below, left=left, right=right, top=top, below=below
    )
    figure.set_label(utilisation_title(assessment))
    largest = max(output.utilisation for output in assessment.outputs)
    start = 0.0
    if largest > LINEAR_BELOW:
        axes.set_xscale("log")
        start = 1.0  # [%]; what is less sits at the edge, its label is exact
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
    axes.set_xlim(start, 100.0 * max(1.05 * largest, 1.2))
    axes.set_ylim(rows - 0.5, -0.5)
    axes.set_xlabel(
        "largest error [% of the limit]; filled: beyond it", fontsize=SMALL, color=MUTED
    )
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    ticks: list[tuple[int, str]] = []
    place = 0
    for title, outputs in groups:
        axes.annotate(
            title,
            (0.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(4.0 - left, 0.0),
            textcoords="offset points",
            fontsize=TEXT,
            fontweight="bold",
            color=INK,
            va="center",
            bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 1.0},
        )
        for output in outputs:
            place += 1
            ticks.append((place, output.output.name.rpartition(".")[2]))
            _draw_dot(axes, place, output, start)
        place += 1
    axes.set_yticks([place for place, _ in ticks], [axis for _, axis in ticks])
    axes.axvline(100.0, color=INK, linewidth=1.0, zorder=2)
    axes.annotate(
        "limit",
        (100.0, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0.0, 4.0),
        textcoords="offset points",
        ha="center",
        fontsize=SMALL,
        color=INK,
    )
    return figure


def utilisation_title(assessment: Assessment) -> str:
    """State the finding: how many outputs exceed their limits, and the worst."""
    worst = max(assessment.outputs, key=_utilisation)
    beyond = sum(not output.is_within for output in assessment.outputs)
    name = output_title(worst.output.name)
    part = f"{name} at {print_utilisation(worst.utilisation)} of the limit"
    total = len(assessment.outputs)
    if beyond:
        return f"{beyond} of {total} outputs exceed their limits, most of all {part}"
    return f"All {total} outputs stay within their limits, the nearest is {part}"


def utilisation_alt(assessment: Assessment) -> str:
    """Say in words with numbers what the dots show."""
    groups = []
    for title, outputs in _by_group(assessment):
        dots = ", ".join(
            f"{o.output.name.rpartition('.')[2]} {print_utilisation(o.utilisation)}"
            for o in outputs
        )
        groups.append(f"{title}: {dots}")
    return (
        f"{utilisation_title(assessment)}. Largest errors in per cent of the limit. "
        f"{'; '.join(groups)}."
    )


def to_svg(figure: Figure, *, name: str) -> str:
    """Write a figure as SVG text; ids begin with `name`, so that several fit a page."""
    from matplotlib import rc_context

    file = io.StringIO()
    with rc_context(STYLE):
        figure.savefig(
            file,
            format="svg",
            transparent=True,
            metadata={
                "Date": None,
                "Creator": None,
                "Format": None,
                "Type": None,
                "Title": figure.get_label(),
            },
        )
    text = re.sub(r'\bid="', f'id="{name}-', file.getvalue())
    return re.sub(r'(url\(|href=")#', rf"\1#{name}-", text)


def canvas(
    height: float, *, left: float, right: float, top: float, below: float
) -> tuple[Figure, Axes]:
    """Make a bare figure of a height and margins in points."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH / INCH, height / INCH))
        axes = figure.add_axes(
            (
                left / WIDTH,
                below / height,
                (WIDTH - left - right) / WIDTH,
                (height - top - below) / height,
            )
        )
    axes.set_axisbelow(True)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0.0, labelsize=SMALL, labelcolor=MUTED)
    axes.tick_params(axis="y", labelsize=TEXT, labelcolor=INK)
    return figure, axes


def _segments(group: GroupTable, place: int) -> list[tuple[str, float]]:
    """Return (source, share) of one bar in fixed order, small ones gathered."""
    shares = {
        row.source.rpartition(".")[2]: row.cells[place].share.exact
        for row in group.sources
    }
    bar = [
        (name, shares[name])
        for name in STYLES
        if name in shares and shares[name] >= SMALL_SHARE
    ]
    rest = fsum(shares.values()) - fsum(share for _, share in bar)
    small = any(0.0 < share < SMALL_SHARE for share in shares.values())
    return [*bar, (OTHER, rest)] if small or rest >= SMALL_SHARE else bar


def _draw_bar(
    axes: Axes, place: int, bar: Sequence[tuple[str, float]], span: float
) -> None:
    """Draw one stacked bar; the share is written where it fits."""
    if not bar:
        axes.text(0.5, place, "no spread", fontsize=SMALL, color=MUTED, va="center")
    start = 0.0
    for source, share in bar:
        colour, hatch, text_colour = STYLES[source]
        axes.barh(
            place,
            100.0 * share,
            left=100.0 * start,
            height=BAR / PITCH,
            color=colour,
            edgecolor=PAPER,
            linewidth=0.6,
            hatch=hatch or None,
        )
        label = print_share(share)
        if text_colour and _fits(label, share * span):
            axes.text(
                100.0 * (start + share / 2.0),
                place,
                label,
                fontsize=SMALL,
                color=text_colour,
                ha="center",
                va="center_baseline",
            )
        start += share


def _draw_legend(figure: Figure, sources: Sequence[str], left: float) -> None:
    """Name the sources that no label fits on, two abreast at the foot."""
    from matplotlib.patches import Patch

    if not sources:
        return
    figure.legend(
        handles=[
            Patch(facecolor=STYLES[name][0], hatch=STYLES[name][1], edgecolor=PAPER)
            for name in sources
        ],
        labels=[
            "other, each below 1 %" if name == OTHER else source_title(name)
            for name in sources
        ],
        loc="lower left",
        bbox_to_anchor=(left / WIDTH, 0.0),
        ncols=2,
        frameon=False,
        fontsize=SMALL,
        labelcolor=INK,
        borderpad=0.0,
        borderaxespad=0.0,
        handlelength=1.2,
        handleheight=0.9,
    )


def _by_group(
    assessment: Assessment,
) -> list[tuple[str, list[OutputAssessment]]]:
    """Return the outputs by parameter group, the worst group and output first."""
    groups = [
        (output_title(name), sorted(outputs, key=_utilisation, reverse=True))
        for name, outputs in groupby(
            assessment.outputs, key=lambda output: output.output.name.rpartition(".")[0]
        )
    ]
    return sorted(groups, key=lambda pair: -pair[1][0].utilisation)


def _utilisation(output: OutputAssessment) -> float:
    """Return what outputs are sorted by; those that print alike keep their order."""
    return round(output.utilisation, 3)


def _draw_dot(axes: Axes, place: int, output: OutputAssessment, start: float) -> None:
    """Draw one output: a thin line to its dot, filled where it is beyond the limit."""
    x = max(100.0 * output.utilisation, start)
    axes.plot([start, x], [place, place], color=MUTED, linewidth=0.7, zorder=1)
    axes.plot(
        [x],
        [place],
        marker="o",
        markersize=5.0,
        color=PAPER if output.is_within else INK,
        markeredgecolor=MUTED if output.is_within else INK,
        zorder=3,
        clip_on=False,
    )
    axes.annotate(
        print_utilisation(output.utilisation),
        (1.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(42.0, 0.0),
        textcoords="offset points",
        fontsize=SMALL,
        color=INK,
        fontweight="normal" if output.is_within else "bold",
        ha="right",
        va="center_baseline",
    )


def _fits(text: str, room: float) -> bool:
    """Whether a small text and a little air fit into `room` [pt]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    path = TextPath((0.0, 0.0), text, SMALL, prop=FontProperties(family="DejaVu Sans"))
    return bool(path.get_extents().width + 6.0 < room)
