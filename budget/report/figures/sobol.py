"""Sobol' indices, which answer first order or total, and how sure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import as_picture, capital, in_order
from budget.report.figures.rows import write_beside, write_heading
from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    canvas,
    house_style,
    look_of,
)
from budget.report.indices import print_index
from budget.report.tables import output_title, source_title, words
from budget.results import widest_of_each
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.results import Budget, OutputBudget, SobolIndex

ROW, HEAD = 20.0, 14.0  # heights [pt]
LEFT, RIGHT, TOP, BELOW = 132.0, 66.0, 4.0, 32.0  # [pt]
APART = 4.0  # of the two dots of a source [pt]
GAP = 0.35  # opacity of the gap between them


@dataclass(frozen=True, kw_only=True)
class Indices:
    """The indices of one output that are not 0 to the digits printed."""

    row: OutputBudget
    shown: tuple[tuple[Name, SobolIndex], ...]  # in the order of all figures
    zero: tuple[Name, ...]  # names of the other sources


def sobol_picture(budget: Budget, sensor: str) -> Picture | None:
    """Return the indices of one sensor as a block, None where there are none."""
    found = _widest(budget, sensor)
    if not found:
        return None
    zero = [
        f"for the {words(one.row.parameter)}: {_titles(one.zero, sensor)}"
        for one in found
        if one.zero
    ]
    caption = (
        "Dot: first-order index, ring: total index, with their intervals; a band "
        "between them is interaction."
    )
    if zero:
        caption += f" 0 to the digits that are sure {'; '.join(zero)}."
    return as_picture(
        sobol_dots(budget, sensor),
        name=f"sobol-{sensor}",
        title=sobol_title(budget, sensor),
        alt=sobol_alt(budget, sensor),
        tips={
            _gid(one.row, source): f"{output_title(one.row.output.name)}: "
            f"{_words(source, index, sensor)}"
            for one in found
            for source, index in one.shown
        },
        caption=caption,
        data=_data(found, sensor),
    )


@house_style()
def sobol_dots(budget: Budget, sensor: str) -> Figure:
    """Draw first-order and total index of each source, with intervals."""
    found = _widest(budget, sensor)
    height = sum(HEAD + ROW * len(one.shown) for one in found)
    figure, axes = canvas(
        TOP + height + BELOW, left=LEFT, right=RIGHT, top=TOP, below=BELOW
    )
    figure.set_label(sobol_title(budget, sensor))
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(height, 0.0)  # [pt]
    axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "0.25", "0.5", "0.75", "1"])
    axes.set_xlabel("index, a share of the variance [1]", fontsize=SMALL, color=MUTED)
    write_beside(axes, HEAD / 2.0, "first, total", reach=RIGHT - 4.0)
    ticks: list[tuple[float, str]] = []
    top = 0.0
    for one in found:
        title = f"{words(one.row.parameter)} {one.row.axis}"
        write_heading(axes, top + HEAD / 2.0, title, indent=LEFT)
        top += HEAD
        ends = (top, top + ROW * len(one.shown))
        for x in (0.0, 0.25, 0.5, 0.75, 1.0):
            axes.plot([x, x], ends, color=GRID, linewidth=0.6, zorder=0, clip_on=False)
        for source, index in one.shown:
            middle = top + ROW / 2.0
            ticks.append((middle, source_title(source, of=sensor)))
            _draw_index(axes, middle, source, index, gid=_gid(one.row, source))
            top += ROW
    axes.set_yticks([place for place, _ in ticks], [text for _, text in ticks])
    return figure


def sobol_title(budget: Budget, sensor: str) -> str:
    """State the finding: the largest interaction, or that there is none."""
    pairs = [
        (one.row, source, index)
        for one in _widest(budget, sensor)
        for source, index in one.shown
    ]
    found = [pair for pair in pairs if _can_be_seen(pair[2])]
    if found:
        row, source, index = found[
            first_largest([p[2].total - p[2].first for p in found])
        ]
        first, total = _texts(index)
        return (
            f"{capital(source_title(source, of=sensor))} interacts in the "
            f"{output_title(row.output.name)}: first order {first}, total {total}"
        )
    if any(index.interacts for _, _, index in pairs):
        return (
            f"Products of {sensor} sources make too little to print: first-order and "
            "total indices agree"
        )
    return (
        f"No {sensor} source interacts beyond chance: first-order and total indices "
        "agree"
    )


def sobol_alt(budget: Budget, sensor: str) -> str:
    """Say in words with numbers what the dots show."""
    texts = []
    for one in _widest(budget, sensor):
        parts = [_words(source, index, sensor) for source, index in one.shown]
        if one.zero:
            parts.append(f"0 for {_titles(one.zero, sensor)}")
        texts.append(f"{output_title(one.row.output.name)}: {'; '.join(parts)}")
    return (
        f"{sobol_title(budget, sensor)}. Sobol' indices with intervals. "
        f"{'. '.join(map(capital, texts))}."
    )


def _widest(budget: Budget, sensor: str) -> tuple[Indices, ...]:
    """Return the indices of the output of each group with the largest spread."""
    with_indices = [
        row
        for row in budget.outputs
        if row.sensor == sensor and any(part.sobol for part in row.contributions)
    ]
    found = []
    for row in widest_of_each(with_indices):
        own = {p.source: p.sobol for p in row.contributions if p.sobol is not None}
        shown = [name for name in in_order(own) if float(_texts(own[name])[1]) > 0.0]
        found.append(
            Indices(
                row=row,
                shown=tuple((name, own[name]) for name in shown),
                zero=tuple(name for name in in_order(own) if name not in shown),
            )
        )
    return tuple(found)


def _draw_index(
    axes: Axes, middle: float, source: Name, index: SobolIndex, *, gid: str
) -> None:
    """Draw one source: dot above, ring below, whiskers, and the gap between."""
    colour = look_of(source)[0]
    first, total = middle - APART, middle + APART
    low, high = sorted((index.first, index.total))
    axes.fill_betweenx(
        [first, total],
        low,
        high,
        color=colour,
        alpha=GAP,
        linewidth=0.0,
        zorder=1,
    )
    for y, value, interval, fill in (
        (first, index.first, index.first_interval, INK),
        (total, index.total, index.total_interval, PAPER),
    ):
        axes.plot([0.0, value], [y, y], color=colour, linewidth=2.0, zorder=2)
        axes.plot(interval, [y, y], color=INK, linewidth=0.9, zorder=3)
        axes.plot(
            [value],
            [y],
            marker="o",
            markersize=4.5,
            color=fill,
            markeredgecolor=INK,
            markeredgewidth=0.9,
            zorder=4,
            clip_on=False,
            gid=gid if y == first else None,
        )
    texts = _texts(index)
    write_beside(
        axes, middle, ", ".join(texts), reach=RIGHT - 4.0, strong=_can_be_seen(index)
    )


def _can_be_seen(index: SobolIndex) -> bool:
    """Whether an interaction is beyond chance and beyond the digits printed."""
    first, total = _texts(index)
    return index.interacts and first != total


def _texts(index: SobolIndex) -> tuple[str, str]:
    """Return first-order and total index to the digits that are sure."""
    return (
        print_index(index.first, index.first_interval)[0],
        print_index(index.total, index.total_interval)[0],
    )


def _titles(sources: Sequence[Name], sensor: str) -> str:
    """Name sources in a row."""
    return ", ".join(source_title(source, of=sensor) for source in sources)


def _words(source: Name, index: SobolIndex, sensor: str) -> str:
    """Say both indices of a source with their intervals."""
    first = " ".join(print_index(index.first, index.first_interval))
    total = " ".join(print_index(index.total, index.total_interval))
    end = ", interacts" if index.interacts else ""
    return f"{source_title(source, of=sensor)} first order {first}, total {total}{end}"


def _data(found: tuple[Indices, ...], sensor: str) -> Table:
    """Return the indices as a table."""
    groups = []
    for one in found:
        rows = []
        for source, index in one.shown:
            first = print_index(index.first, index.first_interval)
            total = print_index(index.total, index.total_interval)
            rows.append(
                (
                    Cell(text=source_title(source, of=sensor), strong=index.interacts),
                    Cell(text=first[0], exact=index.first),
                    Cell(text=first[1]),
                    Cell(text=total[0], exact=index.total),
                    Cell(text=total[1]),
                )
            )
        title = capital(output_title(one.row.output.name))
        groups.append(RowGroup(title=title, rows=tuple(rows)))
    return Table(
        name=f"sobol-{sensor}-data",
        caption=f"Sobol' indices of the widest {sensor} outputs",
        columns=(
            Column(head="source"),
            Column(head="first order", kind="number"),
            Column(head="interval"),
            Column(head="total", kind="number"),
            Column(head="interval"),
        ),
        groups=tuple(groups),
    )


def _gid(row: OutputBudget, source: Name) -> str:
    """Name the dots of one source."""
    return f"tip-{row.parameter}-{source}"
