"""U of every output, for a report without a requirement."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import as_picture, capital
from budget.report.figures.rows import (
    columns_for,
    write_beside,
    write_heading,
    write_on,
)
from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    SMALL,
    add_panel,
    blank,
    house_style,
)
from budget.report.tables import UNKNOWN, print_coverage, words

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.report.tables import GroupTable, OutputRow

ROW, HEAD, GAP, FOOT = 12.0, 15.0, 4.0, 12.0  # heights [pt]
COLUMN_HEAD, AXIS_LABEL = 16.0, 14.0  # [pt]
NAMES, NUMBERS = 24.0, 40.0  # room beside the dots [pt]
ABOVE = 1.08  # reach of an axis over the largest U [1]


def overview_picture(groups: Sequence[GroupTable]) -> Picture | None:
    """Return U of all outputs as a block, None where nothing has a spread."""
    if not any(row.expanded.exact > 0.0 for group in groups for row in group.rows):
        return None
    return as_picture(
        overview_dots(groups),
        name="overview",
        title=overview_title(groups),
        alt=overview_alt(groups),
        tips={
            _gid(group, row): f"{group.title} {row.axis}: U {row.expanded.text} "
            f"{group.unit}"
            for group in groups
            for row in group.rows
        },
        caption="Each group of parameters has an axis of its own, from zero.",
        data=_data(groups),
    )


@house_style()
def overview_dots(groups: Sequence[GroupTable]) -> Figure:
    """Draw U of each output: a panel a group, a column a sensor."""
    sensors = list(dict.fromkeys(group.sensor for group in groups))
    columns = [[g for g in groups if g.sensor == sensor] for sensor in sensors]
    height = COLUMN_HEAD + max(sum(map(_height, column)) for column in columns)
    figure = blank(height + AXIS_LABEL)
    figure.set_label(overview_title(groups))
    for (left, width), sensor, column in zip(
        columns_for(len(columns)), sensors, columns, strict=True
    ):
        write_on(figure, left + 4.0, 10.0, sensor, weight="bold")
        top = COLUMN_HEAD
        for group in column:
            _draw_group(figure, group, left=left, top=top, width=width)
            top += _height(group)
    coverage = print_coverage(groups[0].coverage)
    text = f"U{coverage}, half the width of the {coverage} % interval"
    write_on(figure, 4.0, height + 9.0, text, size=SMALL, colour=MUTED)
    return figure


def overview_title(groups: Sequence[GroupTable]) -> str:
    """State the finding: the widest bias of each sensor, or the widest output."""
    chosen = [group for group in groups if group.parameter == "bias"] or groups[:1]
    parts = [
        f"not known for the {group.title}"
        if group.widest.expanded.text == UNKNOWN
        else f"{group.widest.expanded.text} {group.unit} for the {group.title}"
        for group in chosen
    ]
    return f"U{print_coverage(groups[0].coverage)} is {' and '.join(parts)}"


def overview_alt(groups: Sequence[GroupTable]) -> str:
    """Say in words with numbers what the dots show."""
    coverage = print_coverage(groups[0].coverage)
    texts = [
        f"{group.title} in {group.unit}: "
        + ", ".join(f"{row.axis} {row.expanded.text}" for row in group.rows)
        for group in groups
    ]
    return f"{overview_title(groups)}. U{coverage}. {'; '.join(texts)}."


def _draw_group(
    figure: Figure, group: GroupTable, *, left: float, top: float, width: float
) -> None:
    """Draw one group: its heading, and a dot for each output on an axis from zero."""
    rows = group.rows
    axes = add_panel(
        figure,
        left=left + NAMES,
        top=top,
        width=width - NAMES - NUMBERS,
        height=HEAD + ROW * len(rows),
    )
    axes.set_ylim(HEAD + ROW * len(rows), 0.0)  # [pt]
    largest = max(row.expanded.exact for row in rows)
    axes.set_xlim(0.0, ABOVE * largest or 1.0)
    axes.locator_params(axis="x", nbins=3, steps=[1, 2, 5, 10])
    axes.tick_params(axis="x", pad=1.0)
    write_heading(
        axes, HEAD / 2.0, f"{words(group.parameter)} [{group.unit}]", indent=NAMES
    )
    ends = (HEAD, HEAD + ROW * len(rows))
    axes.set_xticks([x for x in axes.get_xticks() if 0.0 <= x <= ABOVE * largest])
    for x in axes.get_xticks():
        axes.plot([x, x], ends, color=GRID, linewidth=0.6, zorder=0)
    places = [HEAD + ROW * (place + 0.5) for place in range(len(rows))]
    axes.set_yticks(places, [row.axis for row in rows])
    for y, row in zip(places, rows, strict=True):
        _draw_dot(axes, y, group, row)


def _draw_dot(axes: Axes, y: float, group: GroupTable, row: OutputRow) -> None:
    """Draw one output: a line from zero to its dot, and its number."""
    x = row.expanded.exact
    axes.plot([0.0, x], [y, y], color=MUTED, linewidth=0.7, zorder=1)
    axes.plot(
        [x],
        [y],
        marker="o",
        markersize=4.5,
        color=INK,
        markeredgecolor=INK,
        zorder=2,
        clip_on=False,
        gid=_gid(group, row),
    )
    write_beside(axes, y, row.expanded.text, reach=NUMBERS - 4.0)


def _height(group: GroupTable) -> float:
    """Return the height of one group with its axis [pt]."""
    return HEAD + ROW * len(group.rows) + FOOT + GAP


def _data(groups: Sequence[GroupTable]) -> Table:
    """Return U of all outputs as a table."""
    coverage = print_coverage(groups[0].coverage)
    return Table(
        name="overview-data",
        caption=f"U{coverage} of every output",
        columns=(
            Column(head="output"),
            Column(head=f"U{coverage}", kind="number"),
            Column(head="", kind="unit"),
        ),
        groups=tuple(
            RowGroup(
                title=capital(group.title),
                rows=tuple(
                    (
                        Cell(text=row.axis),
                        Cell(text=row.expanded.text, exact=row.expanded.exact),
                        Cell(text=group.unit),
                    )
                    for row in group.rows
                ),
            )
            for group in groups
        ),
    )


def _gid(group: GroupTable, row: OutputRow) -> str:
    """Name a dot."""
    return f"tip-{group.sensor}-{group.parameter}-{row.axis}"
