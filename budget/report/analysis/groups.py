"""Budgets of parameter groups: errors, contributions, check of the law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from budget.names import AXES, key_title
from budget.report.analysis.verdict import (
    headline,
    limits_section,
    summary,
    verdict_cards,
)
from budget.report.blocks import (
    Abreast,
    Cell,
    Field,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    R,
    Section,
    table_of,
)
from budget.report.figures.rows import chart_picture
from budget.report.figures.sources import share_chart, sobol_chart
from budget.report.readings import effect_line, verdict_line
from budget.report.tables import (
    UNKNOWN,
    CheckCell,
    OutputRow,
    SourceRow,
    bound_number,
    group_tables,
    print_coverage,
    round_error,
    round_u,
    settings_lines,
)
from budget.report.wording import (
    capital,
    cell,
    mode_sentence,
    not_given_lines,
    points,
    share_cell,
)
from budget.results import CONVENTION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.report.blocks import Block, Table
    from budget.report.tables import GroupTable, Number
    from budget.results import Assessment, Budget, Compensation


def budget_answer(budget: Budget, *, brief: bool = False) -> tuple[Section, ...]:
    """Return what stands on a terminal: the answer, all groups, what they rest on.

    In brief it is the answer, and what a reader must know beside it.
    """
    groups = group_tables(budget)
    warnings = _listed("Warnings", budget.warnings)
    if brief:
        return (
            *_verdict_sections(budget),
            _worst_axes(budget, groups),
            *filled_sections(budget),
            Section(
                name="not-given",
                title="Not given",
                blocks=(),
                in_brief=f"Not given: {len(budget.not_given)} lines, all named "
                "without --brief"
                if budget.not_given
                else "",
            ),
            *((warnings,) if budget.warnings else ()),
        )
    checks = list({group.validation for group in groups})
    tested = ("procedure", "station")
    settings = [
        *((file.role, file.name) for file in budget.inputs if file.role in tested),
        *settings_lines(budget.settings),
    ]
    if len(checks) == 1 and checks[0]:
        settings.append(("checked", checks[0]))
    return (
        *_verdict_sections(budget),
        _worst_axes(budget, groups),
        *((limits_section(budget, budget.assessment),) if budget.assessment else ()),
        *(_group_section(group, checked=len(checks) > 1) for group in groups),
        *matrices_sections(budget),
        *_indices(budget, dict.fromkeys(group.sensor for group in groups)),
        *filled_sections(budget),
        *readings_section(budget, budget.assessment),
        _listed("Not given", not_given_lines(budget.could_widen)),
        _listed("Assumptions", budget.assumptions),
        warnings,
        Section(
            name="settings",
            title="Settings",
            blocks=(Pairs(rows=tuple((name, (text,)) for name, text in settings)),),
        ),
    )


def _verdict_sections(budget: Budget) -> Iterator[Section]:
    """Yield the verdict and why, as page one of a report has it; none without one."""
    assessment = budget.assessment
    if assessment is None:
        return
    yield Section(
        name="verdict",
        title=headline(budget, assessment),
        blocks=(
            Paragraph(words=summary(budget, assessment)),
            *(
                Panel(
                    title=card.title,
                    blocks=tuple(Paragraph(words=line) for line in card.lines),
                )
                for card in verdict_cards(budget, assessment)
            ),
        ),
    )


def _worst_axes(budget: Budget, groups: Sequence[GroupTable]) -> Section:
    """Return the worst axis of each group: u, U, and what contributes to it.

    The mean stands beside them where an error is expected that is not 0.
    """
    coverage = print_coverage(budget.settings.coverage)

    def number(head: str, pick: Callable[[OutputRow], Number]) -> Field[GroupTable]:
        return Field(
            head=head, kind="number", cell=lambda group: cell(pick(group.widest))
        )

    means = [group.widest.mean.text for group in groups]
    has_mean = any(text != UNKNOWN and float(text) for text in means)
    # Where an interval is not mean +- U, the two ends must be seen.
    interval: tuple[Field[GroupTable], ...] = (
        number(f"U{coverage}", lambda row: row.expanded),
    )
    if not all(group.widest.is_centred for group in groups):
        interval = (
            number(f"{coverage} % interval from", lambda row: row.low),
            number("to", lambda row: row.high),
        )
    fields = (
        Field["GroupTable"](head="", cell=lambda group: group.title),
        *((number("mean", lambda row: row.mean),) if has_mean else ()),
        number("u", lambda row: row.u),
        *interval,
        Field(head="", kind="unit", cell=lambda group: group.unit),
        Field(
            head="contributions",
            weight=3.0,
            cell=lambda group: group.contributions,
        ),
    )
    gaps = dict.fromkeys(f"{group.gaps}." for group in groups if group.gaps)
    return Section(
        name="worst-axes",
        title=f"Worst axis of each{': ' if not budget.assessment else ''}"
        + ("" if budget.assessment else _lower(headline(budget, None))),
        blocks=(
            table_of(groups, fields, name="worst-axes-table", caption="Worst axes"),
            *(Paragraph(words=(text,)) for text in gaps),
        ),
    )


def _lower(text: str) -> str:
    """Write a title within another one."""
    return text[:1].lower() + text[1:]


def filled_sections(budget: Budget) -> tuple[Section, ...]:
    """Return what stands for expected lines that are not given; nothing to refuse."""
    sentence = mode_sentence(budget.settings)
    if not sentence:
        return ()
    lines = [
        f"{key_title(line.source)}: {line.printed} ({line.origin})"
        for line in budget.filled
    ]
    lines += [f"{key_title(name)}: nothing is known" for name in budget.left]
    return (
        Section(
            name="filled",
            title="In the place of lines that are not given",
            blocks=(
                Paragraph(words=(sentence,), small=True),
                Listing(
                    items=points(lines), empty="None: every expected line is given."
                ),
            ),
        ),
    )


def readings_section(
    budget: Budget, assessment: Assessment | None
) -> tuple[Section, ...]:
    """Return what other readings would change; nothing where none is open."""
    if not budget.readings:
        return ()
    judged = [] if assessment is None else assessment.sensors
    text = (
        "The data sheet leaves open what these values mean; the numbers stand on the "
        "reading with the largest standard uncertainty. A sensor meets if it does "
        "under every reading."
    )
    lines = (
        *(
            f"The {one.sensor} {verdict_line(one.readings)}"
            for one in judged
            if one.readings
        ),
        *map(effect_line, budget.readings),
    )
    return (
        Section(
            name="readings",
            title="Open readings",
            blocks=(
                Paragraph(words=(text,), small=True),
                Listing(items=points(lines), empty=""),
            ),
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
    centred = all(row.is_centred for row in group.rows)

    mean, u, expanded, low, high = _errors(group)
    # Where it is not mean +- U, the two ends must be seen.
    interval = (expanded,) if centred else (low, high)
    outputs = table_of(
        group.rows,
        (Field(head="axis", cell=lambda row: row.axis), mean, u, *interval),
        name=f"outputs-{group.sensor}-{group.parameter}",
        caption=f"Errors of the {group.title} by axis",
    )
    blocks: list[Block] = [outputs, *_gaps(group)]
    known = " that is known" if group.gaps else ""
    acting = [source for source in group.sources if not source.is_idle]
    sources = (_sources_table(group, acting),) if acting else ()
    title = f"Contributions, by share of the variance{known}"
    blocks.append(Panel(title=title, blocks=(*sources, *_idle(group))))
    if checked:
        blocks += _checked(group)
    return Section(
        name=f"group-{group.sensor}-{group.parameter}",
        title=f"{capital(group.title)} [{group.unit}]",
        blocks=tuple(blocks),
    )


def _gaps(group: GroupTable) -> Iterator[Paragraph]:
    """Yield what the numbers of a group lack."""
    if group.gaps:
        yield Paragraph(words=(f"{capital(group.gaps)}.",), small=True)


def _idle(group: GroupTable) -> Iterator[Paragraph]:
    """Yield which sources change nothing in a group."""
    if idle := ", ".join(row.title for row in group.sources if row.is_idle):
        text = f"Without effect, to rounding: {idle}."
        yield Paragraph(words=(text,), small=True)


def _checked(group: GroupTable) -> Iterator[Paragraph]:
    """Yield how the law fared against Monte Carlo."""
    if group.validation:
        text = f"The law checked {group.validation}."
        yield Paragraph(words=(text,), small=True)


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
                cell=lambda source: share_cell(source.share.exact),
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


def _indices(budget: Budget, sensors: Iterable[str]) -> Iterator[Section]:
    """Yield Sobol' indices with their intervals, where there are any."""
    charts = [chart for one in sensors if (chart := sobol_chart(budget, one))]
    blocks: list[Block] = []
    for chart in charts:
        blocks += [chart.data] if chart.data else []
        blocks += [Paragraph(words=(chart.after.strip(),))] if chart.after else []
    if blocks:
        yield Section(name="indices", title="Sobol' indices", blocks=tuple(blocks))


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
    blocks += [_table(group), *_gaps(group), *_idle(group), *_checked(group)]
    return Panel(title=capital(group.title), blocks=tuple(blocks))


def _errors(group: GroupTable) -> tuple[Field[OutputRow], ...]:
    """Return what is said of each output: mean, u, U, both ends of its interval."""
    coverage = print_coverage(group.coverage)

    def number(head: str, pick: Callable[[OutputRow], Number]) -> Field[OutputRow]:
        return Field(head=head, kind="number", cell=lambda row: cell(pick(row)))

    return (
        number("mean", lambda row: row.mean),
        number("u", lambda row: row.u),
        number(f"U{coverage}", lambda row: row.expanded),
        number(f"{coverage} % interval from", lambda row: row.low),
        number("to", lambda row: row.high),
    )


CHECKS: tuple[Field[CheckCell], ...] = (  # the law against Monte Carlo
    Field(head="lower ends differ by", cell=lambda check: cell(check.low)),
    Field(head="upper ends differ by", cell=lambda check: cell(check.high)),
    Field(head="tolerance", cell=lambda check: cell(check.tolerance)),
    Field(
        head="the law",
        cell=lambda check: Cell(text=check.word, strong=check.word != "holds"),
    ),
)


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a table with an axis a column."""

    title: str  # of the lines that it stands among
    head: str
    cells: Sequence[Cell | str]


def _table(group: GroupTable) -> Table:
    """Return the numbers of one group, an axis a column."""
    unit = group.unit
    acting = [source for source in group.sources if not source.is_idle]
    checks = [row.check for row in group.rows if row.check is not None]
    lines = [
        *_turned(f"error [{unit}]", _errors(group), group.rows),
        *(
            Line(
                title=f"u of each source alone [{unit}]",
                head=source.title,
                cells=[cell(part.u) for part in source.cells],
            )
            for source in acting
        ),
        *(
            Line(
                title="share of the variance [%]",
                head=source.title,
                cells=[share_cell(part.share.exact) for part in source.cells],
            )
            for source in acting
        ),
        *(
            _turned(f"law against Monte Carlo [{unit}]", CHECKS, checks)
            if checks
            else ()
        ),
    ]
    return table_of(
        lines,
        (
            Field(head="", cell=lambda line: line.head),
            *(
                Field(head=row.axis, kind="number", cell=partial(_of_axis, place))
                for place, row in enumerate(group.rows)
            ),
        ),
        name=f"budget-{group.sensor}-{group.parameter}".replace("_", "-"),
        caption=f"Budget of the {group.title} by axis",
        by=lambda line: line.title,
        titled=True,
    )


def matrices_sections(budget: Budget) -> Iterator[Section]:
    """Yield how readings become inputs, where it was asked for."""
    if budget.matrices:
        yield Section(
            name="matrices",
            title="Compensation of readings",
            blocks=(
                Paragraph(words=(CONVENTION,)),
                Paragraph(
                    words=(
                        (
                            "Values are of the nominal mounting angles and biases of "
                            "the device, u is of what one calibration finds of them."
                        ),
                    ),
                    small=True,
                ),
                Abreast(
                    blocks=tuple(
                        Panel(title=capital(kind), blocks=(_matrix_table(one),))
                        for kind, one in budget.matrices.items()
                    )
                ),
            ),
        )


def _matrix_table(found: Compensation) -> Table:
    """Return T, and both forms of the bias, with their uncertainties."""
    values, us = [], []
    for output, x, u in zip(
        found.outputs, found.value, found.standard_uncertainty, strict=True
    ):
        is_bias = output.name.quantity != "T"
        bound = found.bias_lower_bound if is_bias else found.lower_bound
        values.append(cell(round_error(float(x), float(u), output)))
        us.append(cell(bound_number(round_u(float(u), output), lower_bound=bound)))
    unit = found.outputs[-1].unit
    rows = [(axis, 3 * k) for k, axis in enumerate(AXES)]
    lines = [
        Line(title=title, head=head, cells=cells[start : start + 3])
        for title, parts in (
            ("T [1], a row a body axis", [(*row, values) for row in rows]),
            ("u of T [1]", [(*row, us) for row in rows]),
            (f"bias b in sensor axes [{unit}]", [("b", 9, values), ("u", 9, us)]),
            (f"bias T b in body axes [{unit}]", [("T b", 12, values), ("u", 12, us)]),
        )
        for head, start, cells in parts
    ]
    return table_of(
        lines,
        (
            Field(head="", cell=lambda line: line.head),
            *(
                Field(head=axis, kind="number", cell=partial(_of_axis, place))
                for place, axis in enumerate(AXES)
            ),
        ),
        name=f"matrices-{found.sensor}",
        caption=f"Compensation of the {found.sensor}",
        by=lambda line: line.title,
        titled=True,
    )


def _turned(
    title: str, fields: Iterable[Field[R]], rows: Sequence[R]
) -> Iterator[Line]:
    """Yield a line for each field, a cell for each row."""
    for field in fields:
        yield Line(
            title=title, head=field.head, cells=[field.cell(row) for row in rows]
        )


def _of_axis(place: int, line: Line) -> Cell | str:
    """Return what a line has in a column."""
    return line.cells[place]
