"""Budgets of parameter groups: errors, contributions, check of the law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from budget.language import key_title, say, term, words
from budget.names import AXES
from budget.report.analysis.budget_table import (
    READ,
    budget_remarks,
    budget_table,
    budget_title,
)
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
    Section,
    table_of,
)
from budget.report.figures.contributions import (
    Critical,
    tornado_chart,
    waterfall_chart,
)
from budget.report.figures.rows import chart_picture
from budget.report.figures.sources import sobol_chart
from budget.report.readings import effect_line, verdict_line
from budget.report.tables import (
    UNKNOWN,
    OutputRow,
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
)
from budget.results import CONVENTION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.names import Name
    from budget.report.blocks import Block, Table
    from budget.report.tables import GroupTable, Number
    from budget.results import Assessment, Budget, Compensation


def budget_answer(budget: Budget, *, brief: bool = False) -> tuple[Section, ...]:
    """Return what stands on a terminal: the answer, all groups, what they rest on.

    In brief it is the answer, and what a reader must know beside it.
    """
    groups = group_tables(budget)
    warnings = _listed(say("Warnings"), budget.warnings)
    if brief:
        return (
            *verdict_sections(budget, _cards),
            _worst_axes(budget, groups),
            *filled_sections(budget),
            Section(
                name="not-given",
                title=say("Not given"),
                blocks=(),
                in_brief=say(
                    "Not given: {not_given} lines, all named without --brief",
                    not_given=len(budget.not_given),
                )
                if budget.not_given
                else "",
            ),
            *((warnings,) if budget.warnings else ()),
        )
    checks = {group.validation for group in groups}
    return (
        *verdict_sections(budget, _cards),
        _worst_axes(budget, groups),
        *((limits_section(budget, budget.assessment),) if budget.assessment else ()),
        *(_group_section(group, checked=len(checks) > 1) for group in groups),
        *matrices_sections(budget),
        *rest_sections(budget, checked=checks.pop() if len(checks) == 1 else ""),
    )


def rest_sections(budget: Budget, *, checked: str) -> tuple[Section, ...]:
    """Return what the numbers of a budget rest on, and how the law was checked."""
    tested = ("procedure", "station", "mission", "trajectory")
    settings = [
        *((file.role, file.name) for file in budget.inputs if file.role in tested),
        *settings_lines(budget.settings),
    ]
    if checked:
        settings.append((term("checked"), checked))
    not_given = (
        _listed(
            say("Not given"),
            not_given_lines(
                budget.could_widen,
                is_later=budget.settings.reference == "next_turn_on",
            ),
        )
        if budget.mission is None
        else _named(say("Not given"), budget.not_given)
    )
    return (
        *_indices(budget, dict.fromkeys(row.sensor for row in budget.outputs)),
        *filled_sections(budget),
        *readings_section(budget, budget.assessment),
        not_given,
        _listed(say("Assumptions"), budget.assumptions),
        _listed(say("Warnings"), budget.warnings),
        Section(
            name="settings",
            title=say("Settings"),
            blocks=(
                Pairs(rows=tuple((say(name), (say(text),)) for name, text in settings)),
            ),
        ),
    )


def verdict_sections(
    budget: Budget,
    why: Callable[[Budget, Assessment], Iterable[Block]],
    under: Callable[[Assessment], Iterable[Block]] = lambda _: (),
) -> Iterator[Section]:
    """Yield the verdict, as page one of a report has it, and why; none without one.

    Right `under` the headline stands what it holds if, where `why` does not say it.
    """
    assessment = budget.assessment
    if assessment is None:
        return
    yield Section(
        name="verdict",
        title=headline(budget, assessment),
        blocks=(
            *under(assessment),
            Paragraph(words=summary(budget, assessment)),
            *why(budget, assessment),
        ),
    )


def _cards(budget: Budget, assessment: Assessment) -> Iterator[Block]:
    """Yield why, sensor by sensor."""
    for card in verdict_cards(budget, assessment):
        blocks = tuple(Paragraph(words=line) for line in card.lines)
        yield Panel(title=card.title, blocks=blocks)


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
            number(
                say("{coverage} % interval from", coverage=coverage),
                lambda row: row.low,
            ),
            number(say("to"), lambda row: row.high),
        )
    fields = (
        Field["GroupTable"](head="", cell=lambda group: group.title),
        *((number(say("mean"), lambda row: row.mean),) if has_mean else ()),
        number("u", lambda row: row.u),
        *interval,
        Field(head="", kind="unit", cell=lambda group: group.unit),
        Field(
            head=say("contributions"),
            weight=3.0,
            cell=lambda group: group.contributions,
        ),
    )
    gaps = dict.fromkeys(
        say("{gaps}.", gaps=group.gaps) for group in groups if group.gaps
    )
    return Section(
        name="worst-axes",
        title=say("Worst axis of each")
        if budget.assessment
        else say(
            "Worst axis of each: {headline}", headline=_lower(headline(budget, None))
        ),
        blocks=(
            table_of(
                groups, fields, name="worst-axes-table", caption=say("Worst axes")
            ),
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
        say(
            "{source}: {line} ({origin})",
            source=key_title(line.source),
            line=line.printed,
            origin=say(line.origin),
        )
        for line in budget.filled
    ]
    lines += [
        say("{name}: nothing is known", name=key_title(name)) for name in budget.left
    ]
    return (
        Section(
            name="filled",
            title=say("In the place of lines that are not given"),
            blocks=(
                Paragraph(words=(sentence,), small=True),
                Listing(
                    items=points(lines),
                    empty=say("None: every expected line is given."),
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
    text = say(
        "The data sheet leaves open what these values mean; the numbers stand on the "
        "reading with the largest standard uncertainty. A sensor meets if it does "
        "under every reading."
    )
    lines = (
        *(
            say(
                "The {sensor} {verdict_line}",
                sensor=say(one.sensor),
                verdict_line=verdict_line(one.readings),
            )
            for one in judged
            if one.readings
        ),
        *map(effect_line, budget.readings),
    )
    return (
        Section(
            name="readings",
            title=say("Open readings"),
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
        blocks=(Listing(items=points(map(say, lines)), empty=""),),
        in_brief=None if lines else say("{title}: none", title=title),
    )


def _named(title: str, names: Sequence[Name]) -> Section:
    """Return names under a heading, those of one owner in a line."""
    owners: dict[str, list[str]] = {}
    for name in names:
        owners.setdefault(name.owner, []).append(words(name.quantity))
    lines = [
        say("{owner}: {lines}", owner=say(owner), lines=say(", ").join(own))
        for owner, own in owners.items()
    ]
    return _listed(title, lines)


def _group_section(group: GroupTable, *, checked: bool) -> Section:
    """Return the budget of one group; how it was checked, where that differs."""
    return Section(
        name=f"group-{group.sensor}-{group.parameter}",
        title=budget_title(group),
        blocks=(budget_table(group), *budget_remarks(group, checked=checked)),
    )


def _indices(budget: Budget, sensors: Iterable[str]) -> Iterator[Section]:
    """Yield Sobol' indices with their intervals, where there are any."""
    charts = [chart for one in sensors if (chart := sobol_chart(budget, one))]
    blocks: list[Block] = []
    for chart in charts:
        blocks += [chart.data] if chart.data else []
        blocks += [Paragraph(words=(chart.after.strip(),))] if chart.after else []
    if blocks:
        yield Section(name="indices", title=say("Sobol' indices"), blocks=tuple(blocks))


def budget_section(
    groups: Sequence[GroupTable], assessment: Assessment | None = None
) -> Section:
    """Return the budgets of all groups with the figures of their contributions."""
    checks = {group.validation for group in groups}
    differ = len(checks) > 1
    check = "" if differ else checks.pop()
    said = (
        say("{read} The law checked {check}.", read=say(READ), check=check)
        if check
        else say(READ)
    )
    return Section(
        name="budget",
        title=say("Budget"),
        blocks=(
            Paragraph(words=(said,)),
            *(
                Panel(
                    title=budget_title(group),
                    blocks=(
                        *budget_remarks(group, checked=differ),
                        budget_table(group),
                        *_pictures(group, assessment),
                    ),
                )
                for group in groups
            ),
        ),
    )


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a table with an axis a column."""

    title: str  # of the lines that it stands among
    head: str
    cells: Sequence[Cell | str]


def _pictures(group: GroupTable, assessment: Assessment | None) -> Iterator[Abreast]:
    """Yield tornado and waterfall of the critical output of a group."""
    critical = Critical.of(group, assessment)
    charts = [tornado_chart(critical), waterfall_chart(critical)]
    if drawn := tuple(chart_picture(chart) for chart in charts if chart is not None):
        yield Abreast(blocks=drawn)


def matrices_sections(budget: Budget) -> Iterator[Section]:
    """Yield how readings become inputs, where it was asked for."""
    if budget.matrices:
        yield Section(
            name="matrices",
            title=say("Compensation of readings"),
            blocks=(
                Paragraph(words=(say(CONVENTION),)),
                Paragraph(
                    words=(
                        (
                            say(
                                "Values are of the nominal mounting angles and "
                                "biases of the device, u is of what one "
                                "calibration finds of them."
                            )
                        ),
                    ),
                    small=True,
                ),
                Abreast(
                    blocks=tuple(
                        Panel(title=capital(say(kind)), blocks=(_matrix_table(one),))
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
            (say("T [1], a row a body axis"), [(*row, values) for row in rows]),
            (say("u of T [1]"), [(*row, us) for row in rows]),
            (
                say("bias b in sensor axes [{unit}]", unit=unit),
                [("b", 9, values), ("u", 9, us)],
            ),
            (
                say("bias T b in body axes [{unit}]", unit=unit),
                [("T b", 12, values), ("u", 12, us)],
            ),
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
        caption=say("Compensation of the {sensor}", sensor=say(found.sensor)),
        by=lambda line: line.title,
        titled=True,
    )


def _of_axis(place: int, line: Line) -> Cell | str:
    """Return what a line has in a column."""
    return line.cells[place]
