"""The budget of each group of parameters: errors, contributions, its check."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import (
    Abreast,
    Cell,
    Column,
    Field,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    RowGroup,
    Section,
    Table,
    table_of,
)
from budget.report.figures.rows import chart_picture
from budget.report.figures.shares import share_chart
from budget.report.tables import (
    IndexRow,
    OutputRow,
    SourceRow,
    group_tables,
    index_tables,
    print_coverage,
    settings_lines,
)
from budget.report.wording import capital, cell, not_given_lines, points

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.report.blocks import Block
    from budget.report.tables import (
        CheckCell,
        GroupTable,
        IndexTable,
        Number,
        SourceCell,
    )
    from budget.results import Budget

TINY_BAR = 0.005  # a share below this is no bar [1]


def budget_answer(budget: Budget) -> tuple[Section, ...]:
    """Return what stands on a terminal: all groups, then what they rest on."""
    groups = group_tables(budget)
    checks = list({group.validation for group in groups})
    settings = [*settings_lines(budget.settings)]
    if len(checks) == 1 and checks[0]:
        settings.append(("checked", checks[0]))
    return (
        *(_group_section(group, checked=len(checks) > 1) for group in groups),
        *(_index_section(table) for table in index_tables(budget) if table.is_widest),
        _listed("Not given", not_given_lines(budget.could_widen)),
        _listed("Assumptions", budget.assumptions),
        _listed("Warnings", budget.warnings),
        Section(
            name="settings",
            title="Settings",
            blocks=(Pairs(rows=tuple((name, (text,)) for name, text in settings)),),
        ),
    )


def _listed(title: str, lines: Sequence[str]) -> Section:
    """Return lines of text under a heading, which says so where there are none."""
    return Section(
        name=title.lower().replace(" ", "-"),
        title=title,
        blocks=(Listing(items=points(lines), empty=""),),
        in_brief=None if lines else f"{title}: none",
    )


def _group_section(group: GroupTable, *, checked: bool) -> Section:
    """Return the outputs of one group, an axis a row, then its sources."""
    coverage = print_coverage(group.coverage)
    centred = all(row.is_centred for row in group.rows)

    def number(
        head: str, pick: Callable[[OutputRow], Number], *, shown: bool = True
    ) -> Field[OutputRow]:
        return Field(
            head=head,
            kind="number",
            optional=True,
            cell=lambda row: cell(pick(row)) if shown else "",
        )

    outputs = table_of(
        group.rows,
        (
            Field[OutputRow](head="axis", cell=lambda row: row.axis),
            number("mean", lambda row: row.mean),
            number("u", lambda row: row.u),
            number(f"U{coverage}", lambda row: row.expanded, shown=centred),
            # Not mean +- U: the two ends must be seen.
            number(f"{coverage} % from", lambda row: row.low, shown=not centred),
            number("to", lambda row: row.high, shown=not centred),
        ),
        name=f"outputs-{group.sensor}-{group.parameter}",
        caption=f"Errors of the {group.title} by axis",
    )
    blocks: list[Block] = [outputs]
    if group.gaps:
        blocks.append(Paragraph(words=(group.gaps,)))
    known = " that is known" if group.gaps else ""
    acting = [source for source in group.sources if not source.is_idle]
    shown: list[Block] = [_sources_table(group, acting)] if acting else []
    if idle := ", ".join(row.title for row in group.sources if row.is_idle):
        shown.append(Paragraph(words=(f"no effect: {idle}",)))
    title = f"Contributions, by share of the variance{known}"
    blocks.append(Panel(title=title, blocks=tuple(shown)))
    if checked and group.validation:
        blocks.append(Paragraph(words=(f"Checked {group.validation}",)))
    return Section(
        name=f"group-{group.sensor}-{group.parameter}",
        title=f"{capital(group.title)} [{group.unit}]",
        blocks=tuple(blocks),
    )


def _sources_table(group: GroupTable, acting: Sequence[SourceRow]) -> Table:
    """Return the sources that have an effect, the largest first."""
    ranges = {source.source: _range(source) for source in acting}
    differ = any(" to " in text for text in ranges.values())
    return table_of(
        acting,
        (
            Field[SourceRow](head="", cell=lambda source: source.title),
            Field[SourceRow](
                head="share [%]",
                kind="number",
                cell=lambda source: Cell(
                    text=source.share.text.removesuffix(" %"),
                    exact=source.share.exact,
                    share=source.share.exact,
                ),
            ),
            Field[SourceRow](
                head="u, worst axis" if differ else "u alone",
                kind="number",
                cell=lambda source: cell(
                    max((part.u for part in source.cells), key=lambda u: u.exact)
                ),
            ),
            Field[SourceRow](
                head="share by axis",
                cell=lambda source: ranges[source.source] if differ else "",
                optional=True,
            ),
        ),
        name=f"sources-{group.sensor}-{group.parameter}",
        caption=f"Sources of the {group.title}",
    )


def _range(source: SourceRow) -> str:
    """Return 'least to most' of the shares by axis; one where the axes agree."""
    shares = sorted((part.share for part in source.cells), key=lambda x: x.exact)
    least, most = shares[0].text, shares[-1].text
    return most if least == most else f"{least} to {most}"


def _index_section(table: IndexTable) -> Section:
    """Return Sobol' indices with their intervals."""
    blocks: list[Block] = [
        table_of(
            table.rows,
            (
                Field[IndexRow](
                    head="",
                    cell=lambda row: Cell(text=row.title, note=row.note),
                ),
                Field[IndexRow](head="rank", cell=lambda row: row.rank),
                Field[IndexRow](
                    head="first order",
                    cell=lambda row: f"{row.first} {row.first_interval}",
                ),
                Field[IndexRow](
                    head="total",
                    cell=lambda row: f"{row.total} {row.total_interval}",
                ),
            ),
            name=f"indices-{table.title}".replace(" ", "-"),
            caption=f"Sobol indices of {table.title}",
        )
    ]
    if table.small:
        blocks.append(Paragraph(words=(f"below 0.001: {table.small}",)))
    return Section(
        name=f"indices-{table.title}",
        title=f"Sobol indices of {table.title}",
        blocks=tuple(blocks),
    )


def budget_section(groups: Sequence[GroupTable]) -> Section:
    """Return the budgets of all groups with the figures of their contributions."""
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
    has_spread = any(row.share.exact for row in group.sources)
    blocks: list[Block] = [chart_picture(share_chart(group))] if has_spread else []
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
    return Panel(title=capital(group.title), blocks=tuple(blocks))


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
