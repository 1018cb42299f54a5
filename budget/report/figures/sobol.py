"""Sobol' indices: first order and total, with their intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.names import words
from budget.report.blocks import Cell, Field, table_of
from budget.report.figures.rows import (
    Bar,
    Chart,
    Dot,
    Group,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import INK, PAPER, in_order, look_of
from budget.report.tables import output_title, print_index, source_title
from budget.report.wording import capital
from budget.results import widest_of_each
from budget.ties import first_largest

if TYPE_CHECKING:
    from budget.names import Name
    from budget.report.figures.rows import Mark
    from budget.results import Budget, OutputBudget, SobolIndex

APART = 4.0  # of the two dots of a source from the middle of its row [pt]
GAP = 0.35  # opacity of the gap between them


@dataclass(frozen=True, kw_only=True)
class Indices:
    """The indices of one output that are not 0 to the digits printed."""

    row: OutputBudget
    shown: tuple[tuple[Name, SobolIndex], ...]  # in the order of all figures
    zero: tuple[Name, ...]  # names of the other sources

    @property
    def ranked(self) -> list[tuple[Name, SobolIndex]]:
        """Those shown by rank, then by total index."""
        return sorted(self.shown, key=lambda pair: (pair[1].rank, -pair[1].total))


def sobol_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show first-order and total index of each source of a sensor, None without any.

    Of each group of parameters the output with the largest spread.
    """
    found = _widest(budget, sensor)
    if not found:
        return None
    zeros = "; ".join(
        f"for the {words(one.row.parameter)}: "
        + ", ".join(source_title(name, of=sensor) for name in one.zero)
        for one in found
        if one.zero
    )
    zeros = f" 0 to the digits that are sure {zeros}." if zeros else ""
    scale = Scale(
        low=0.0,
        high=1.0,
        ticks=tuple((float(x), x) for x in ("0", "0.25", "0.5", "0.75", "1")),
        label="index, a share of the variance [1]",
    )
    groups = tuple(
        Group(
            title=f"{words(one.row.parameter)} {one.row.axis}",
            said=output_title(one.row.output.name),
            rows=tuple(_row(one.row, *pair, sensor) for pair in one.shown),
        )
        for one in found
    )
    return Chart(
        name=f"sobol-{sensor}",
        title=_title(found, sensor),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead="Sobol' indices with intervals. ",
        after=zeros,
        caption=(
            "Dot: first-order index, ring: total index, with their intervals; a band "
            f"between them is interaction.{zeros}"
        ),
        beside=("first, total",),
        pitch=20.0,
        data=table_of(
            [(one.row, *pair) for one in found for pair in one.ranked],
            (
                Field(
                    head="source",
                    cell=lambda one: Cell(
                        text=source_title(one[1], of=sensor),
                        note="interacts" if one[2].interacts else "",
                    ),
                ),
                Field(head="rank", cell=lambda one: _rank(one[0], one[2])),
                Field(
                    head="first order",
                    kind="number",
                    cell=lambda one: Cell(text=_first(one[2])[0], exact=one[2].first),
                ),
                Field(head="interval", kind="unit", cell=lambda one: _first(one[2])[1]),
                Field(
                    head="total",
                    kind="number",
                    cell=lambda one: Cell(text=_total(one[2])[0], exact=one[2].total),
                ),
                Field(head="interval", kind="unit", cell=lambda one: _total(one[2])[1]),
            ),
            name=f"sobol-{sensor}-data",
            caption=f"Sobol' indices of the widest {sensor} outputs",
            by=lambda one: capital(output_title(one[0].output.name)),
            titled=True,
        ),
    )


def _title(found: tuple[Indices, ...], sensor: str) -> str:
    """State the finding: the largest interaction, or that there is none."""
    pairs = [(one.row, *pair) for one in found for pair in one.shown]
    seen = [pair for pair in pairs if _can_be_seen(pair[2])]
    if seen:
        row, source, index = seen[
            first_largest([index.total - index.first for _, _, index in seen])
        ]
        first, total = _first(index)[0], _total(index)[0]
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
        shown = [name for name in in_order(own) if float(_total(own[name])[0]) > 0.0]
        found.append(
            Indices(
                row=row,
                shown=tuple((name, own[name]) for name in shown),
                zero=tuple(name for name in in_order(own) if name not in shown),
            )
        )
    return tuple(found)


def _row(output: OutputBudget, source: Name, index: SobolIndex, sensor: str) -> Row:
    """Return one source: dot above, ring below, whiskers, and the gap between."""
    colour, title = look_of(source)[0], source_title(source, of=sensor)
    first, total = _first(index), _total(index)
    said = f"{title} first order {' '.join(first)} and total {' '.join(total)}" + (
        " (interacts)" if index.interacts else ""
    )
    gap = Bar(
        start=index.first,
        end=index.total,
        colour=colour,
        edge="none",
        opacity=GAP,
        height=2.0 * APART,
    )
    marks: list[Mark] = [gap]
    for value, ends, lift, fill in (
        (index.first, index.first_interval, -APART, INK),
        (index.total, index.total_interval, APART, PAPER),
    ):
        tip = f"{output_title(output.output.name)}: {said}" if fill == INK else ""
        marks += [
            Stroke(start=0.0, end=value, colour=colour, width=2.0, lift=lift),
            Stroke(start=ends[0], end=ends[1], colour=INK, width=0.9, lift=lift),
            Dot(at=value, fill=fill, size=4.5, lift=lift, tip=tip),
        ]
    return Row(
        label=title,
        marks=tuple(marks),
        beside=(f"{first[0]}, {total[0]}",),
        strong=_can_be_seen(index),
        said=said,
    )


def _rank(output: OutputBudget, index: SobolIndex) -> str:
    """Print a rank; sources that cannot be told apart share it: '2='."""
    ranks = [part.sobol.rank for part in output.contributions if part.sobol]
    return f"{index.rank}{'=' if ranks.count(index.rank) > 1 else ''}"


def _can_be_seen(index: SobolIndex) -> bool:
    """Whether an interaction is beyond chance and beyond the digits printed."""
    return index.interacts and _first(index)[0] != _total(index)[0]


def _first(index: SobolIndex) -> tuple[str, str]:
    """Print the first-order index and its interval."""
    return print_index(index.first, index.first_interval)


def _total(index: SobolIndex) -> tuple[str, str]:
    """Print the total index and its interval."""
    return print_index(index.total, index.total_interval)
