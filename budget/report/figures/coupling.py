"""Coupling map: part of the u of each parameter group that a source makes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.model.sources import SENSORS
from budget.names import words
from budget.report.blocks import Cell, Field, table_of
from budget.report.figures.rows import (
    Bar,
    Chart,
    Group,
    Head,
    Panel,
    Row,
    Scale,
    Side,
)
from budget.report.figures.style import BLUE, INK, ON_DARK, in_order
from budget.report.tables import ALL, output_title, print_given, source_title
from budget.ties import first_largest

if TYPE_CHECKING:
    from budget.names import Name
    from budget.report.figures.rows import Mark
    from budget.studies.coupling import Coupling, CouplingTable

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
EDGES = {1e-6: "1e-6", 1e-4: "1e-4", 1e-3: "0.1 %", 0.01: "1 %", 0.1: "10 %"}
PER_CENT_FROM = 0.001  # smaller parts are written as powers of ten [1]
NOTHING = "none"


def coupling_chart(table: CouplingTable, sensor: str) -> Chart | None:
    """Show sources by groups of parameters, the hue by the size of what reaches.

    Of one sensor; None where nothing reaches anything.
    """
    cells = [cell for cell in table.cells if cell.group.owner == sensor]
    if not any(cell.reaches for cell in cells):
        return None
    groups = [group for group in table.groups if group.owner == sensor]
    reaching = [s for s in table.sources if any(cell.source == s for cell in cells)]
    own = [s for s in reaching if s.owner in SENSORS]
    shared = [s for s in reaching if s.owner not in SENSORS]
    sources = (*in_order(own), *in_order(shared))
    rows = tuple(
        _row(source, [table.cell(source, group) for group in groups], sensor)
        for source in sources
    )

    def column(group: Name) -> Field[Name]:
        return Field(
            head=f"{words(group.quantity)} [%]",
            kind="number",
            cell=lambda source: _part_cell(table.cell(source, group)),
        )

    return Chart(
        name=f"coupling-{sensor}",
        title=_title(cells, sensor),
        sides=(
            Side(
                panels=(
                    Panel(
                        scale=Scale(low=0.0, high=float(len(groups)), ticks=()),
                        groups=(Group(rows=rows),),
                    ),
                    _hues(),
                )
            ),
        ),
        lead=f"u from one source alone over u from all, of the {sensor}. ",
        after=" All other sources reach nothing.",
        caption="Framed: the own spread of a parameter. Empty: nothing.",
        heads=tuple(
            Head(at=x + 0.5, text=words(group.quantity))
            for x, group in enumerate(groups)
        ),
        pitch=18.0,
        data=table_of(
            sources,
            (
                Field(head="source", cell=lambda name: source_title(name, of=sensor)),
                *map(column, groups),
            ),
            name=f"coupling-{sensor}-data",
            caption=f"u of each {sensor} source over u of all, in per cent",
        ),
    )


def _part_cell(cell: Coupling) -> Cell:
    """Return the part of u that a source makes of a group."""
    if not cell.reaches:
        return Cell(text=NOTHING)
    exact = 100.0 * cell.size
    return Cell(text=_per_cent(cell.size), exact=exact, strong=cell.is_own)


def print_part(size: float) -> str:
    """Print a part of u in two digits: '33 %', '0.69 %', '3.1e-5', '>99 %'."""
    if size < PER_CENT_FROM:
        return f"{size:.1e}".replace("e-0", "e-")
    return f"{_per_cent(size)} %"


def _title(cells: list[Coupling], sensor: str) -> str:
    """State the finding: which source reaches farthest where it does not belong."""
    foreign = [cell for cell in cells if not cell.is_own]
    most = foreign[first_largest([cell.size for cell in foreign])] if foreign else None
    if most is None or not most.reaches:
        return f"Each {sensor} parameter is reached by its own spread alone"
    title = source_title(most.source, of=sensor)
    return (
        f"Besides own spreads, {title} reaches farthest: "
        f"{print_part(most.size)} of the u of the {output_title(most.group)}"
    )


def _row(source: Name, cells: list[Coupling], sensor: str) -> Row:
    """Return the cells of one source, each with its number and its tooltip."""
    title = source_title(source, of=sensor)
    marks: list[Mark] = []
    said = []
    for x, cell in enumerate(cells):
        if not (cell.reaches or cell.is_own):
            continue
        opacity = next(opacity for edge, opacity in STEPS if cell.size >= edge)
        part = print_part(cell.size)
        marks.append(
            Bar(
                start=x + 0.015,
                end=x + 0.985,
                colour=BLUE if cell.reaches else "none",
                edge="none",
                opacity=opacity,
                height=16.0,
                is_framed=cell.is_own,
                text=part if cell.reaches else "",
                text_colour=ON_DARK if opacity == 1.0 else INK,
                tip=f"{title} makes {part} of the u of the {output_title(cell.group)}"
                if cell.reaches
                else "",
            )
        )
        if cell.reaches:
            owned = " (own)" if cell.is_own else ""
            said.append(f"{words(cell.group.quantity)} {part}{owned}")
    return Row(
        label=title,
        marks=tuple(marks),
        said=f"{title}: {', '.join(said)}" if said else "",
    )


def _hues() -> Panel:
    """Return the steps of the hue, their edges written below."""
    rising = STEPS[::-1]
    return Panel(
        scale=Scale(
            low=0.0,
            high=float(len(STEPS)),
            ticks=tuple(
                (float(place), EDGES[edge])
                for place, (edge, _) in enumerate(rising)
                if place
            ),
            label="u of one source over u of all",
        ),
        groups=(
            Group(
                rows=(
                    Row(
                        label="",
                        marks=tuple(
                            Bar(
                                start=float(place),
                                end=place + 0.96,
                                colour=BLUE,
                                edge="none",
                                opacity=opacity,
                            )
                            for place, (_, opacity) in enumerate(rising)
                        ),
                    ),
                )
            ),
        ),
    )


def _per_cent(size: float) -> str:
    """Print a part in per cent; 100 stands only where nothing else counts."""
    text = print_given(100.0 * size, digits=2)
    return ">99" if text == "100" and size < ALL else text
