"""Waterfalls, which answer where the allowance of a limit goes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.allocation.rows import THICK, named_rows, write_beside
from budget.report.allocation.words import part_title, print_part, print_used
from budget.report.figures import GRID, MUTED, PAPER, SMALL, house_style, look_of
from budget.report.figures.picture import as_picture, capital
from budget.report.tables import output_title
from budget.ties import first_largest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.studies.allocation.records import LimitedOutput, Part

THIN = 0.2  # height of the bar of what is now, in rows [1]
SHOWN = 1e-3  # part of the squared limit from which a source has a row [1]
NOW, AFTER = 46.0, 88.0  # right ends of the columns of numbers beside the panel [pt]


def waterfall_picture(row: LimitedOutput) -> Picture:
    """Return the waterfall of one limit as a block; a table beside it has the data.

    Each bar has its tooltip.
    """
    return as_picture(
        waterfall(row),
        name=f"waterfall-{row.output.name}",
        title=waterfall_title(row),
        alt=waterfall_alt(row),
        tips=waterfall_tips(row),
        caption=(
            "From the squared limit down: thick bars are what is "
            f"{after_word(row)}, thin ones what each source takes now."
        ),
    )


@house_style()
def waterfall(row: LimitedOutput) -> Figure:
    """Draw one limit from the whole down through the sources to what is left.

    The thick bars are what is allowed (of an impossible limit, what is held), the thin
    ones what the sources take now; those leave the figure where the limit is passed.
    """
    parts = _shown(row)
    figure, axes = named_rows(len(parts) + 2, top=20.0)
    figure.set_label(waterfall_title(row))
    axes.set_xlim(0.0, 100.0)
    axes.set_xticks([0, 25, 50, 75, 100])
    axes.set_xlabel("part of the squared limit [%]", fontsize=SMALL, color=MUTED)
    names = ["limit", *(part_title(part.source, row.sensor) for part in parts), "left"]
    axes.set_yticks(range(len(names)), names)
    axes.barh(0, 100.0, height=THICK, color=GRID)
    left, left_now = 1.0, 1.0
    for place, part in enumerate(parts, start=1):
        colour, hatch, _ = look_of(part.source)
        after = _after(part)
        (bar,) = axes.barh(
            place,
            100.0 * after,
            left=100.0 * (left - after),
            height=THICK,
            color=colour,
            edgecolor=PAPER,
            linewidth=0.4,
            hatch=hatch or None,
        )
        bar.set_gid(_gid(part))
        _draw_now(axes, place, left_now, part.now)
        _write(axes, place, print_part(part.now), print_part(after))
        left, left_now = left - after, left_now - part.now
    _draw_left(axes, len(parts) + 1, left, left_now)
    for column, word in ((NOW, "now"), (AFTER, after_word(row))):
        write_beside(axes, -0.75, column, word, colour=MUTED)
    return figure


def waterfall_title(row: LimitedOutput) -> str:
    """State the finding: who takes most of the limit."""
    name = output_title(row.output.name)
    largest = row.parts[first_largest([_after(part) for part in row.parts])]
    title = part_title(largest.source, row.sensor)
    part = f"{title} takes {print_part(_after(largest))} %"
    if row.allowed is None:
        return f"{capital(name)} cannot be met: {part} of the squared limit"
    return f"{capital(part)} of the squared {name} limit"


def waterfall_alt(row: LimitedOutput) -> str:
    """Say in words with numbers what the waterfall shows."""
    word = after_word(row)
    parts = "; ".join(
        f"{part_title(part.source, row.sensor)} now {print_part(part.now)} %, {word} "
        f"{print_part(_after(part))} %"
        for part in _shown(row)
    )
    used = print_used(row, now=True)
    return (
        f"{waterfall_title(row)}. Parts of the squared limit {row.printed_limit}: "
        f"{parts}. The largest error is now {used} of the limit."
    )


def waterfall_tips(row: LimitedOutput) -> dict[str, str]:
    """Return a tooltip for the bar of each source, by its gid."""
    return {
        _gid(part): (
            f"{part_title(part.source, row.sensor)}: now {print_part(part.now)} %, "
            f"{after_word(row)} {print_part(_after(part))} % of the squared "
            f"{output_title(row.output.name)} limit {row.printed_limit}"
        )
        for part in _shown(row)
    }


def after_word(row: LimitedOutput) -> str:
    """Say what stands beside 'now': what is allowed, or all that is held."""
    return "held" if row.allowed is None else "allowed"


def _shown(row: LimitedOutput) -> list[Part]:
    """Return the parts that have a bar."""
    return [part for part in row.parts if max(part.now, _after(part)) >= SHOWN]


def _gid(part: Part) -> str:
    """Name the bar of a source."""
    return f"tip-{part.source.quantity}"


def _after(part: Part) -> float:
    """Return the part after the allocation, of an impossible limit what is held [1]."""
    return part.floor if part.allowed is None else part.allowed


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
    write_beside(axes, place, NOW, now, colour=MUTED)
    write_beside(axes, place, AFTER, after)
