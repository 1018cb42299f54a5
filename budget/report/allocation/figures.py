"""Figures of an allocation: where each limit goes, how far each line may go alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.allocation.words import part_title, print_part, print_used
from budget.report.figures import GRID, INK, MUTED, PAPER, SMALL, STYLES, canvas
from budget.report.tables import output_title, print_given, source_title
from budget.studies.allocation.records import FREE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.studies.allocation.records import (
        LimitedOutput,
        Part,
        SourceAllotment,
    )

PITCH = 17.0  # from row to row [pt]
THICK, THIN = 0.52, 0.2  # heights of a bar, in rows [1]
SHOWN = 1e-3  # part of the squared limit from which a source has a row [1]
LEAST_FACTOR, MOST_FACTOR = 1e-2, 1e2  # of a headroom that is drawn [1]
LEFT = 122.0  # room for names [pt]


def waterfall(row: LimitedOutput) -> Figure:
    """Draw one limit from the whole down through the sources to what is left.

    The thick bars are what is allowed (of an impossible limit, what is held), the thin
    ones what the sources take now; those leave the figure where the limit is passed.
    """
    parts = [part for part in row.parts if max(part.now, _after(part)) >= SHOWN]
    right, top, below = 92.0, 20.0, 30.0
    figure, axes = _canvas(len(parts) + 2, right=right, top=top, below=below)
    figure.set_label(waterfall_title(row))
    axes.set_xlim(0.0, 100.0)
    axes.set_xticks([0, 25, 50, 75, 100])
    axes.set_xlabel("part of the squared limit [%]", fontsize=SMALL, color=MUTED)
    names = ["limit", *(part_title(part.source) for part in parts), "left"]
    axes.set_yticks(range(len(names)), names)
    axes.barh(0, 100.0, height=THICK, color=GRID)
    left, left_now = 1.0, 1.0
    for place, part in enumerate(parts, start=1):
        name = part.source.rpartition(".")[2]
        colour, hatch, _ = STYLES.get(name, STYLES["other"])
        after = _after(part)
        axes.barh(
            place,
            100.0 * after,
            left=100.0 * (left - after),
            height=THICK,
            color=colour,
            edgecolor=PAPER,
            linewidth=0.4,
            hatch=hatch or None,
        )
        _draw_now(axes, place, left_now, part.now)
        _write(axes, place, print_part(part.now), print_part(after))
        left, left_now = left - after, left_now - part.now
    _draw_left(axes, len(parts) + 1, left, left_now)
    words = ("now", "held" if row.allowed is None else "allowed")
    for column, word in zip((46.0, 88.0), words, strict=True):
        axes.annotate(
            word,
            (1.0, 1.0),
            xycoords="axes fraction",
            xytext=(column, 5.0),
            textcoords="offset points",
            fontsize=SMALL,
            color=MUTED,
            ha="right",
        )
    return figure


def waterfall_title(row: LimitedOutput) -> str:
    """State the finding: who takes most of the limit."""
    name = output_title(row.output.name)
    largest = max(row.parts, key=_after)
    part = f"{part_title(largest.source)} takes {print_part(_after(largest))} %"
    if row.allowed is None:
        return (
            f"{name[:1].upper()}{name[1:]} cannot be met: {part} of the squared limit"
        )
    return f"{part[:1].upper()}{part[1:]} of the squared {name} limit"


def waterfall_alt(row: LimitedOutput) -> str:
    """Say in words with numbers what the waterfall shows."""
    word = "held" if row.allowed is None else "allowed"
    parts = "; ".join(
        f"{part_title(part.source)} now {print_part(part.now)} %, {word} "
        f"{print_part(_after(part))} %"
        for part in row.parts
        if max(part.now, _after(part)) >= SHOWN
    )
    used = print_used(row, now=True)
    return (
        f"{waterfall_title(row)}. Parts of the squared limit {row.printed_limit}: "
        f"{parts}. The largest error is now {used} of the limit."
    )


def headroom_bars(rows: Sequence[SourceAllotment]) -> Figure:
    """Draw how far each line may go alone, from its present value, on a log axis."""
    shown = [row for row in rows if row.headroom is not None]
    right, top, below = 92.0, 8.0, 30.0
    figure, axes = _canvas(len(shown), right=right, top=top, below=below)
    figure.set_label(headroom_title(rows))
    axes.set_xscale("log")
    axes.set_xlim(LEAST_FACTOR, MOST_FACTOR)
    axes.set_xticks(
        [0.01, 0.1, 1.0, 10.0, 100.0], ["1/100", "1/10", "now", "10", "100"]
    )
    axes.minorticks_off()
    axes.set_xlabel(
        "value over the present one; diamond: allowed", fontsize=SMALL, color=MUTED
    )
    axes.set_yticks(range(len(shown)), [source_title(row.source) for row in shown])
    axes.axvline(1.0, color=INK, linewidth=0.8)
    for place, row in enumerate(shown):
        colour, hatch, _ = STYLES.get(row.source.rpartition(".")[2], STYLES["other"])
        factor = _factor(row)
        drawn = min(max(factor, LEAST_FACTOR), MOST_FACTOR)
        low, high = sorted((1.0, drawn))
        axes.barh(
            place,
            high - low,
            left=low,
            height=THICK,
            color=colour if factor > 0.0 else "none",
            edgecolor=colour,
            linewidth=0.8,
            hatch=hatch or None,
        )
        if row.status == FREE and row.allowed:
            allowed = min(max(row.factor, LEAST_FACTOR), MOST_FACTOR)
            axes.plot(
                [allowed],
                [place],
                marker="D",
                markersize=4.0,
                color=PAPER,
                markeredgecolor=INK,
                clip_on=False,
            )
        axes.annotate(
            _stop(row),
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(6.0, 0.0),
            textcoords="offset points",
            fontsize=SMALL,
            color=INK,
            va="center_baseline",
        )
    return figure


def headroom_title(rows: Sequence[SourceAllotment]) -> str:
    """State the finding: how many lines may grow alone, and which most."""
    shown = [row for row in rows if row.headroom is not None]
    growing = [row for row in shown if _factor(row) > 1.0]
    sensor = shown[0].source.partition(".")[0] if shown else ""
    if not growing:
        return f"No {sensor} line alone may grow"
    most = max(growing, key=_factor)
    factor = _factor(most)
    far = "without limit" if factor == float("inf") else f"{factor:.3g} times"
    return (
        f"{len(growing)} of {len(shown)} {sensor} lines may grow alone, "
        f"{source_title(most.source)} {far}"
    )


def headroom_alt(rows: Sequence[SourceAllotment]) -> str:
    """Say in words with numbers what the bars show."""
    texts = "; ".join(
        f"{source_title(row.source)} {print_given(_factor(row), digits=3)} times, "
        f"stopped by {_stop(row)}"
        if 0.0 < _factor(row) < float("inf")
        else f"{source_title(row.source)} {_stop(row)}"
        for row in rows
        if row.headroom is not None
    )
    return f"{headroom_title(rows)}. Each line alone, the others as now: {texts}."


def _after(part: Part) -> float:
    """Return the part after the allocation, of an impossible limit what is held [1]."""
    return part.floor if part.allowed is None else part.allowed


def _factor(row: SourceAllotment) -> float:
    """Return headroom over present value [1]; infinite where nothing stops it."""
    if row.headroom is None or row.headroom.value is None:
        return float("inf")
    return row.headroom.value / row.now


def _stop(row: SourceAllotment) -> str:
    """Name what stops a line."""
    if row.headroom is None or row.headroom.stopped_by is None:
        return "no limit"
    name = output_title(row.headroom.stopped_by.partition(".")[2])
    return name if row.headroom.value else f"none: {name}"


def _canvas(
    rows: int, *, right: float, top: float, below: float
) -> tuple[Figure, Axes]:
    """Make a bare figure for a number of rows, names on the left."""
    height = top + PITCH * rows + below
    figure, axes = canvas(height, left=LEFT, right=right, top=top, below=below)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    return figure, axes


def _draw_now(axes: Axes, place: int, left: float, part: float) -> None:
    """Draw what a source takes now, with an arrow where that passes the limit."""
    start, end = 100.0 * min(left, 1.0), 100.0 * (left - part)
    y = place + THICK / 2.0 + THIN / 2.0 + 0.04
    if start > 0.0 and part > 0.0:
        axes.barh(
            y, start - max(end, 0.0), left=max(end, 0.0), height=THIN, color=MUTED
        )
    if end < 0.0 < part:
        axes.plot([0.0], [y], marker="<", markersize=4.0, color=MUTED, clip_on=False)


def _draw_left(axes: Axes, place: int, left: float, left_now: float) -> None:
    """Draw what is left of the limit in the end, and write both."""
    if left > 0.0:
        axes.barh(place, 100.0 * left, height=THICK, color=GRID)
    if left_now > 0.0:
        y = place + THICK / 2.0 + THIN / 2.0 + 0.04
        axes.barh(y, 100.0 * left_now, height=THIN, color=MUTED)
    texts = [
        "none" if value < -SHOWN else print_part(max(value, 0.0))
        for value in (left_now, left)
    ]
    _write(axes, place, *texts)


def _write(axes: Axes, place: int, now: str, after: str) -> None:
    """Write both numbers of a row beside it."""
    for column, text, colour in ((46.0, now, MUTED), (88.0, after, INK)):
        axes.annotate(
            text,
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(column, 0.0),
            textcoords="offset points",
            fontsize=SMALL,
            color=colour,
            ha="right",
            va="center_baseline",
        )
