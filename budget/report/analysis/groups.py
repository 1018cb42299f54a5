"""The budget of each group of parameters: its errors, their causes, its check."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import (
    Abreast,
    Cell,
    Column,
    Panel,
    Paragraph,
    RowGroup,
    Section,
    Table,
)
from budget.report.figures import share_picture
from budget.report.tables import print_coverage
from budget.report.wording import cell, first_up

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.report.blocks import Block
    from budget.report.tables import (
        CheckCell,
        GroupTable,
        Number,
        OutputRow,
        SourceCell,
    )

TINY_BAR = 0.005  # a share below this is no bar [1]


def budget_section(groups: Sequence[GroupTable]) -> Section:
    """Return the budgets of all groups with the figures of their causes."""
    coverage = print_coverage(groups[0].coverage)
    text = (
        f"U{coverage} is half the width of the {coverage} % interval, u the standard "
        "uncertainty. Sources are ranked by their variance over all axes of a group; "
        "each line is what that source does alone. Mean and interval are of the error."
    )
    return Section(
        name="budget",
        title="Budget",
        blocks=(
            Paragraph(words=(text,)),
            Abreast(blocks=tuple(_panel(group) for group in groups)),
        ),
    )


def _panel(group: GroupTable) -> Panel:
    """Return figure, table and remarks of one group."""
    picture = share_picture(group)
    blocks: list[Block] = [] if picture is None else [picture]
    blocks.append(_table(group))
    if group.gaps:
        blocks.append(Paragraph(words=(f"{group.gaps}.",), small=True))
    idle = [row.title for row in group.sources if row.is_idle]
    if idle:
        text = f"Without effect, to rounding: {', '.join(idle)}."
        blocks.append(Paragraph(words=(text,), small=True))
    if group.validation:
        text = f"The law checked {group.validation}."
        blocks.append(Paragraph(words=(text,), small=True))
    return Panel(title=first_up(group.title), blocks=tuple(blocks))


def _table(group: GroupTable) -> Table:
    """Return the numbers of one group, an axis a column."""
    coverage = print_coverage(group.coverage)
    unit = group.unit

    def over_rows(head: str, pick: Callable[[OutputRow], Number]) -> tuple[Cell, ...]:
        return (Cell(text=head), *(cell(pick(row)) for row in group.rows))

    row_groups = [
        RowGroup(
            title=f"error [{unit}]",
            rows=(
                over_rows("mean", lambda row: row.mean),
                over_rows("u", lambda row: row.u),
                over_rows(f"U{coverage}", lambda row: row.expanded),
                over_rows(f"{coverage} % interval from", lambda row: row.low),
                over_rows("to", lambda row: row.high),
            ),
        )
    ]
    acting = [source for source in group.sources if not source.is_idle]
    if acting:
        row_groups += [
            RowGroup(
                title=f"u of each source alone [{unit}]",
                rows=tuple(
                    (Cell(text=source.title), *(cell(part.u) for part in source.cells))
                    for source in acting
                ),
            ),
            RowGroup(
                title="share of the variance [%]",
                rows=tuple(
                    (Cell(text=source.title), *map(_share_cell, source.cells))
                    for source in acting
                ),
            ),
        ]
    checks = [row.check for row in group.rows if row.check is not None]
    if checks:
        row_groups.append(_check_rows(checks, unit))
    return Table(
        name=f"budget-{group.sensor}-{group.parameter}".replace("_", "-"),
        caption=f"Budget of the {group.title} by axis",
        columns=(
            Column(head=""),
            *(Column(head=row.axis, kind="number") for row in group.rows),
        ),
        groups=tuple(row_groups),
    )


def _share_cell(part: SourceCell) -> Cell:
    """Return a share in per cent, with a bar behind it where one can be seen."""
    share = part.share
    return Cell(
        text=share.text.removesuffix(" %"),
        exact=share.exact,
        share=share.exact if share.exact > TINY_BAR else None,
    )


def _check_rows(checks: Sequence[CheckCell], unit: str) -> RowGroup:
    """Return the law against Monte Carlo, output by output."""
    return RowGroup(
        title=f"law against Monte Carlo [{unit}]",
        rows=(
            (Cell(text="lower ends differ by"), *(cell(c.low) for c in checks)),
            (Cell(text="upper ends differ by"), *(cell(c.high) for c in checks)),
            (Cell(text="tolerance"), *(cell(c.tolerance) for c in checks)),
            (
                Cell(text="the law"),
                *(Cell(text=c.word, strong=c.word != "holds") for c in checks),
            ),
        ),
    )
