"""Coupling map, which answers what reaches what, and how far."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.model.sources import SENSORS
from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import as_picture, capital, in_order
from budget.report.figures.style import (
    BLUE,
    INK,
    MUTED,
    ON_DARK,
    SMALL,
    WIDTH,
    add_panel,
    canvas,
    house_style,
)
from budget.report.tables import ALL, output_title, print_given, source_title, words
from budget.ties import first_largest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.studies.coupling import Coupling, CouplingTable

LEFT, RIGHT, TOP, BELOW = 132.0, 4.0, 18.0, 46.0  # [pt]
ROW = 18.0  # [pt]
# Opacity of the one hue by the part of u that a source makes: steps that stay apart in
# grey. Text is light on the full hue only: it can be read on all others, light or dark.
STEPS = (
    (0.1, 1.0),
    (0.01, 0.68),
    (1e-3, 0.5),
    (1e-4, 0.34),
    (1e-6, 0.21),
    (0.0, 0.11),
)
EDGES = {0.0: "", 1e-6: "1e-6", 1e-4: "1e-4", 1e-3: "0.1 %", 0.01: "1 %", 0.1: "10 %"}
PER_CENT_FROM = 0.001  # smaller parts are written as powers of ten [1]
NOTHING = "none"


def coupling_picture(table: CouplingTable, sensor: str) -> Picture | None:
    """Return the map of one sensor as a block, None where nothing reaches anything."""
    if not any(cell.reaches for cell in _cells(table, sensor)):
        return None
    return as_picture(
        coupling_map(table, sensor),
        name=f"coupling-{sensor}",
        title=coupling_title(table, sensor),
        alt=coupling_alt(table, sensor),
        tips={
            _gid(cell): f"{source_title(cell.source, of=sensor)} makes "
            f"{print_part(cell.size)} of the u of the {output_title(cell.group)}"
            for cell in _cells(table, sensor)
            if cell.reaches
        },
        caption="Framed: the own spread of a parameter. Empty: nothing.",
        data=_data(table, sensor),
    )


@house_style()
def coupling_map(table: CouplingTable, sensor: str) -> Figure:
    """Draw sources by groups of parameters, the hue by the size of what reaches."""
    from matplotlib.patches import Rectangle

    sources, groups = _sources(table, sensor), _groups(table, sensor)
    height = TOP + ROW * len(sources) + BELOW
    figure, axes = canvas(height, left=LEFT, right=RIGHT, top=TOP, below=BELOW)
    figure.set_label(coupling_title(table, sensor))
    axes.set_xlim(0.0, len(groups))
    axes.set_ylim(len(sources), 0.0)
    axes.set_xticks([])
    axes.set_yticks(
        [place + 0.5 for place in range(len(sources))],
        [source_title(source, of=sensor) for source in sources],
    )
    for x, group in enumerate(groups):
        axes.text(
            x + 0.5,
            -0.25,
            words(group.quantity),
            fontsize=SMALL,
            color=INK,
            ha="center",
            va="bottom",
        )
        for y, source in enumerate(sources):
            cell = table.cell(source, group)
            if cell.reaches:
                _draw_cell(axes, x, y, cell)
            if cell.is_own:
                axes.add_patch(
                    Rectangle(
                        (x + 0.03, y + 0.1),
                        0.94,
                        0.8,
                        facecolor="none",
                        edgecolor=INK,
                        linewidth=1.0,
                    )
                )
    _draw_scale(figure, height)
    return figure


def coupling_title(table: CouplingTable, sensor: str) -> str:
    """State the finding: which source reaches farthest where it does not belong."""
    foreign = [cell for cell in _cells(table, sensor) if not cell.is_own]
    most = foreign[first_largest([cell.size for cell in foreign])] if foreign else None
    if most is None or not most.reaches:
        return f"Each {sensor} parameter is reached by its own spread alone"
    title = source_title(most.source, of=sensor)
    return (
        f"Besides own spreads, {title} reaches farthest: "
        f"{print_part(most.size)} of the u of the {output_title(most.group)}"
    )


def coupling_alt(table: CouplingTable, sensor: str) -> str:
    """Say in words with numbers what the map shows."""
    groups = []
    for group in _groups(table, sensor):
        cells = [table.cell(source, group) for source in _sources(table, sensor)]
        parts = [
            f"{source_title(cell.source, of=sensor)} {print_part(cell.size)}"
            + (" (own)" if cell.is_own else "")
            for cell in cells
            if cell.reaches
        ]
        name = words(group.quantity)
        groups.append(f"{name}: {', '.join(parts) or NOTHING}")
    return (
        f"{coupling_title(table, sensor)}. u from one source alone over u from all, of "
        f"the {sensor}. {'; '.join(groups)}. All other sources reach nothing."
    )


def print_part(size: float) -> str:
    """Print a part of u in two digits: '33 %', '0.69 %', '3.1e-5', '>99 %'."""
    if size < PER_CENT_FROM:
        return f"{size:.1e}".replace("e-0", "e-")
    return f"{_per_cent(size)} %"


def _draw_cell(axes: Axes, x: int, y: int, cell: Coupling) -> None:
    """Fill one cell and write its number."""
    from matplotlib.patches import Rectangle

    opacity = _opacity(cell.size)
    axes.add_patch(
        Rectangle(
            (x + 0.015, y + 0.05),
            0.97,
            0.9,
            facecolor=BLUE,
            alpha=opacity,
            linewidth=0.0,
            gid=_gid(cell),
        )
    )
    axes.text(
        x + 0.5,
        y + 0.5,
        print_part(cell.size),
        fontsize=SMALL,
        color=ON_DARK if opacity == 1.0 else INK,
        ha="center",
        va="center_baseline",
    )


def _draw_scale(figure: Figure, height: float) -> None:
    """Draw the steps of the hue at the foot, their edges written below."""
    from matplotlib.patches import Rectangle

    axes = add_panel(
        figure,
        left=LEFT,
        top=height - BELOW + 10.0,
        width=WIDTH - LEFT - RIGHT,
        height=8.0,
    )
    axes.set_xlim(0.0, len(STEPS))
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks([])
    rising = STEPS[::-1]
    for place, (_, opacity) in enumerate(rising):
        axes.add_patch(
            Rectangle(
                (place, 0.0), 0.96, 1.0, facecolor=BLUE, alpha=opacity, linewidth=0.0
            )
        )
    axes.set_xticks(
        [float(place) for place in range(1, len(STEPS))],
        [EDGES[edge] for edge, _ in rising[1:]],
    )
    axes.set_xlabel("u of one source over u of all", fontsize=SMALL, color=MUTED)


def _per_cent(size: float) -> str:
    """Print a part in per cent; 100 stands only where nothing else counts."""
    text = print_given(100.0 * size, digits=2)
    return ">99" if text == "100" and size < ALL else text


def _opacity(size: float) -> float:
    """Return the opacity of the hue, a step for each few decades."""
    return next(opacity for edge, opacity in STEPS if size >= edge)


def _data(table: CouplingTable, sensor: str) -> Table:
    """Return the numbers of the map."""
    groups = _groups(table, sensor)
    rows = []
    for source in _sources(table, sensor):
        cells = [table.cell(source, group) for group in groups]
        rows.append(
            (
                Cell(text=capital(source_title(source, of=sensor))),
                *(
                    Cell(
                        text=_per_cent(cell.size),
                        exact=100.0 * cell.size,
                        strong=cell.is_own,
                    )
                    if cell.reaches
                    else Cell(text=NOTHING)
                    for cell in cells
                ),
            )
        )
    return Table(
        name=f"coupling-{sensor}-data",
        caption=f"u of each {sensor} source over u of all, in per cent",
        columns=(
            Column(head="source"),
            *(
                Column(head=f"{words(group.quantity)} [%]", kind="number")
                for group in groups
            ),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _sources(table: CouplingTable, sensor: str) -> list[Name]:
    """Return the sources that can reach one sensor, those that both share last."""
    own = [s for s in table.sources if s.owner == sensor]
    shared = [s for s in table.sources if s.owner not in SENSORS]
    return [*in_order(own), *in_order(shared)]


def _groups(table: CouplingTable, sensor: str) -> list[Name]:
    """Return the groups of parameters of one sensor."""
    return [group for group in table.groups if group.owner == sensor]


def _cells(table: CouplingTable, sensor: str) -> list[Coupling]:
    """Return the cells of one sensor."""
    return [cell for cell in table.cells if cell.group.owner == sensor]


def _gid(cell: Coupling) -> str:
    """Name a cell."""
    return f"tip-{cell.source}-{cell.group}"
