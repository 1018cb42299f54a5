"""Sobol' indices for people: ranked, and never without their interval."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log10
from typing import TYPE_CHECKING

from budget.report.tables import output_title, source_title
from budget.results import widest_of_each

if TYPE_CHECKING:
    from budget.results import Budget, OutputBudget

MOST_DECIMALS = 3  # an index is a share: more digits tell nobody anything


@dataclass(frozen=True, kw_only=True)
class IndexRow:
    """The indices of one source for one output, as texts."""

    rank: str  # '2', '2=' where it is shared
    title: str
    first: str
    first_interval: str
    total: str
    total_interval: str
    note: str  # 'interacts', or ''


@dataclass(frozen=True, kw_only=True)
class IndexTable:
    """All indices for one output; sources that cannot be told apart share a rank."""

    title: str  # 'gyro bias z'
    is_widest: bool  # of its parameter group
    rows: tuple[IndexRow, ...]
    small: str  # the sources whose total index is 0 to the digits printed


def index_tables(budget: Budget) -> tuple[IndexTable, ...]:
    """Return a table for every output that has indices."""
    widest = {row.output.name for row in widest_of_each(budget.outputs)}
    return tuple(
        IndexTable(
            title=output_title(row.output.name),
            is_widest=row.output.name in widest,
            rows=tuple(r for r in rows if float(r.total) > 0.0),
            small=", ".join(r.title for r in rows if float(r.total) == 0.0),
        )
        for row in budget.outputs
        if (rows := _rows(row))
    )


def _rows(output: OutputBudget) -> tuple[IndexRow, ...]:
    """Return the rows of one output, by rank, then by total index."""
    found = [(p.source, p.sobol) for p in output.contributions if p.sobol is not None]
    found.sort(key=lambda pair: (pair[1].rank, -pair[1].total))
    ranks = [index.rank for _, index in found]
    rows = []
    for source, index in found:
        first = print_index(index.first, index.first_interval)
        total = print_index(index.total, index.total_interval)
        rows.append(
            IndexRow(
                rank=f"{index.rank}{'=' if ranks.count(index.rank) > 1 else ''}",
                title=source_title(source),
                first=first[0],
                first_interval=first[1],
                total=total[0],
                total_interval=total[1],
                note="interacts" if index.interacts else "",
            )
        )
    return tuple(rows)


def print_index(value: float, interval: tuple[float, float]) -> tuple[str, str]:
    """Return an index and its interval, to the digit that the interval makes sure."""
    half = (interval[1] - interval[0]) / 2.0
    decimals = MOST_DECIMALS
    if half > 0.0:
        decimals = min(max(ceil(-log10(half)) + 1, 1), MOST_DECIMALS)
    # Rounded first: a low end of -1e-9 is 0.0, not -0.0.
    texts = [f"{round(x, decimals) + 0.0:.{decimals}f}" for x in (value, *interval)]
    return texts[0], f"[{texts[1]}, {texts[2]}]"
