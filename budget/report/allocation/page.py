"""An allocation as a section, for a report and for a terminal."""

from __future__ import annotations

from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING

from budget.language import key_title, say, term, words
from budget.names import MISSION
from budget.report.allocation.figures import (
    after_word,
    headroom_chart,
    waterfall_chart,
)
from budget.report.allocation.words import (
    DASH,
    DIGITS,
    explain_idle,
    headline,
    longer_test_text,
    match_text,
    part_title,
    print_floor,
    print_headroom,
    print_part,
    print_stop,
    print_used,
    print_value,
    recalibration_text,
    relaxations,
    remarks,
    tightest,
)
from budget.report.blocks import (
    Abreast,
    Cell,
    Field,
    ForPages,
    Listing,
    Panel,
    Paragraph,
    Picture,
    Run,
    Section,
    assumptions_section,
    table_of,
)
from budget.report.figures.rows import chart_picture
from budget.report.tables import (
    join_outputs,
    print_count,
    print_coverage,
    print_given,
    source_title,
)
from budget.report.wording import capital, standing_lines
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from budget.report.blocks import Block, Table
    from budget.studies.allocation.records import (
        Allocation,
        CostReport,
        CoverageCheck,
        LimitedOutput,
        SourceAllotment,
    )

STRATEGIES = {
    "proportional": term(
        "one factor on the lines of a sensor that matter at its limits, the others as "
        "they are"
    ),
    "equal": term("each line gets an equal part of the limit it uses most"),
    "cost": term("the least total cost"),
}
CLOSEST = 5  # catalogue entries a sensor that are listed where none meets
PER_CENT = 100.0
SHARP = 1e-12  # below it a residual is the rounding of the processor [1]


def allocation_section(allocation: Allocation) -> Section:
    """Return what each line may be: the finding, its tables and figures."""
    coverage = print_coverage(allocation.coverage)
    settings = say(
        "Strategy {strategy}: {strategies}. Coverage {coverage} %, "
        "error reference {reference}, procedure {procedure}. "
        "Values are standard uncertainties of the largest axis. Alone: what one line "
        "could be, the others as they are now.",
        strategy=say(allocation.strategy),
        strategies=say(STRATEGIES[allocation.strategy]),
        coverage=coverage,
        reference=words(allocation.reference),
        procedure=allocation.procedure,
    )
    blocks: list[Block] = [
        Paragraph(words=(Run(text=headline(allocation), strong=True),)),
        *_standing_blocks(allocation),
        Paragraph(words=(settings,), small=True),
        *_points(
            say("What would make it feasible"), relaxations(allocation.impossible)
        ),
    ]
    for sensor, rows in _by_sensor(allocation):
        limits = _limits(allocation, sensor)
        tables: list[Block] = [_lines_table(sensor, rows)]
        if idle := explain_idle(rows):
            tables.append(
                Paragraph(words=(say("{idle}.", idle=capital(idle)),), small=True)
            )
        if limits:
            tables.append(_parts_table(sensor, limits))
        blocks.append(Panel(title=capital(say(sensor)), blocks=tuple(tables)))
    if on_mission := _limits(allocation, MISSION):  # of the lines of both triads
        table = _parts_table(MISSION, on_mission)
        blocks.append(Panel(title=capital(say(MISSION)), blocks=(table,)))
    blocks.append(Abreast(blocks=(ForPages(lambda: _pictures(allocation)),)))
    corrected = (row for row in allocation.sources if row.uncorrected is not None)
    blocks += _points(say("Corrected by Monte Carlo"), map(_correction, corrected))
    blocks += _points(say("What limits cost"), map(_cost_text, allocation.costs))
    if allocation.checks:
        title = say("Checked by Monte Carlo at the allocated values")
        blocks.append(Panel(title=title, blocks=(_checks_table(allocation.checks),)))
    blocks += _points(
        say("A longer test"), map(longer_test_text, allocation.longer_tests)
    )
    texts = (
        recalibration_text(one, allocation.coverage)
        for one in allocation.recalibrations
    )
    blocks += _points(say("When to calibrate again"), texts)
    blocks += _shelves(allocation)
    blocks += _points(say("Remarks on the allocation"), map(say, allocation.warnings))
    return Section(
        name="allocation", title=say("What each line may be"), blocks=tuple(blocks)
    )


def _standing_blocks(allocation: Allocation) -> Iterator[Block]:
    """Yield after which calibration and in which use, and what it holds if."""
    for place, (owner, standing) in enumerate(allocation.standings):
        if not place:
            yield Paragraph(words=(say("Judged {after}.", after=say(standing.after)),))
        for text in standing_lines(standing):
            said = say("{sensor}: {text}.", sensor=key_title(owner), text=text)
            yield Paragraph(words=(Run(text=capital(said), strong=True),))


def figured(allocation: Allocation) -> tuple[LimitedOutput, ...]:
    """Return the outputs that get a waterfall: of each parameter the tightest one.

    Those whose limits cannot be met, and those at their limits.
    """
    return tightest((*allocation.impossible, *allocation.binding))


def allocation_answer(allocation: Allocation) -> tuple[Section, ...]:
    """Return what stands alone on a terminal: the allocation and what was assumed."""
    return (allocation_section(allocation), assumptions_section(allocation.assumptions))


def _by_sensor(
    allocation: Allocation,
) -> Iterator[tuple[str, list[SourceAllotment]]]:
    """Yield each owner of lines with its lines."""
    for sensor in dict.fromkeys(row.source.owner for row in allocation.sources):
        yield sensor, [r for r in allocation.sources if r.source.owner == sensor]


def _pictures(allocation: Allocation) -> Iterator[Picture]:
    """Draw how far each line could go, and what takes how much of the limits."""
    for _, rows in _by_sensor(allocation):
        if (headroom := headroom_chart(rows)) is not None:
            yield chart_picture(headroom)
    yield from (chart_picture(waterfall_chart(row)) for row in figured(allocation))


def _correction(row: SourceAllotment) -> str:
    """Say what Monte Carlo changed."""
    value = (row.uncorrected or 0.0) / row.si_per_unit
    return say(
        "{source}: the law alone allows {value}, corrected by Monte Carlo",
        source=source_title(row.source),
        value=print_value(value, row.unit),
    )


def _points(title: str, lines: Iterable[str]) -> Iterator[Panel]:
    """Yield lines of text under a heading, nothing where there are none."""
    items = tuple((capital(line),) for line in lines)
    if items:
        yield Panel(title=title, blocks=(Listing(items=items, empty=say("None.")),))


def _limits(allocation: Allocation, sensor: str) -> tuple[LimitedOutput, ...]:
    """Return the outputs whose limits are taken apart: those that have a waterfall.

    Of parameters without one the tightest.
    """
    own = [row for row in allocation.outputs if row.sensor == sensor]
    drawn = {row.output.name.group: row for row in figured(allocation)}
    return tuple(drawn.get(row.output.name.group, row) for row in tightest(own))


def _lines_table(sensor: str, rows: Sequence[SourceAllotment]) -> Table:
    """Return what each line is and may be."""
    fields: tuple[Field[SourceAllotment], ...] = (
        Field(
            head=say("line"),
            weight=1.4,
            cell=lambda row: Cell(
                text=capital(source_title(row.source)), note=remarks(row)
            ),
        ),
        Field(head=say("now"), kind="number", cell=lambda row: _value(row.now, row)),
        Field(head=say("alone up to"), kind="number", cell=_alone),
        Field(head=say("unit"), kind="unit", cell=lambda row: row.unit),
        Field(head=say("alone stopped by"), cell=lambda row: print_headroom(row)[1]),
        Field(
            head=say("allowed"),
            kind="number",
            cell=lambda row: _value(row.allowed, row),
        ),
        Field(head=say("allowed / now"), kind="number", cell=_factor),
        Field(
            head=say("stopped by"),
            cell=lambda row: print_stop(row.binding_outputs, row.source.owner),
        ),
    )
    return table_of(
        rows,
        fields,
        name=f"allocation-{sensor}",
        caption=say(
            "What each line of the {sensor} is now, and what it may be",
            sensor=say(sensor),
        ),
        by=attrgetter("unit"),  # points are in line where that means something
        is_wide=True,
    )


def _factor(row: SourceAllotment) -> Cell:
    """Return what a line is times, a dash where nothing is allowed."""
    if row.allowed is None:
        return Cell(text=DASH)
    return Cell(text=print_given(row.factor, digits=DIGITS), exact=row.factor)


def _alone(row: SourceAllotment) -> Cell:
    """Return how far a line could go alone."""
    room = row.headroom
    exact = room.value / row.si_per_unit if room and room.value else None
    return Cell(text=print_headroom(row)[0], exact=exact)


def _value(value: float | None, row: SourceAllotment) -> Cell:
    """Return a value in the unit of its line, a dash for none."""
    if value is None:
        return Cell(text=DASH)
    number = value / row.si_per_unit
    return Cell(text=print_given(number, digits=DIGITS), exact=number)


def _parts_table(sensor: str, limits: Sequence[LimitedOutput]) -> Table:
    """Return what takes how much of the squared limits, now and after.

    A row is a place among the parts, the last one the largest error.
    """

    def head(place: int) -> str:
        if place == len(limits[0].parts):
            return say("Largest error, of the limit")
        return capital(part_title(limits[0].parts[place].source, sensor))

    fields: list[Field[int]] = [
        Field(head=say("part of the squared limit [%]"), weight=1.4, cell=head)
    ]
    for row in limits:
        name = print_stop((row.output.name,), sensor)
        fields += [
            Field(
                head=say("{name}, {word}", name=name, word=say(word)),
                kind="number",
                cell=partial(_part, row, after=after),
            )
            for word, after in (("now", False), (after_word(row), True))
        ]
    number = len(limits[0].parts)
    return table_of(
        range(number + 1),
        fields,
        name=f"allocation-parts-{sensor}",
        caption=say(
            "Parts of the squared limits of the {sensor} by source", sensor=say(sensor)
        ),
        by=lambda place: place == number,
        is_wide=True,
    )


def _part(row: LimitedOutput, place: int, *, after: bool) -> Cell:
    """Return a part of a squared limit, or the largest error behind the last."""
    is_held = row.allowed is None
    if place < len(row.parts):
        part = row.parts[place]
        then = part.floor if part.allowed is None else part.allowed
        size = then if after else part.now
        return Cell(text=print_part(size), exact=PER_CENT * size)
    if not after:
        text, used = print_used(row, now=True), row.now
    elif is_held:
        text, used = print_floor(row), row.floor
    else:
        text, used = print_used(row, now=False), row.allowed or 0.0
    return Cell(
        text=text.removesuffix(" %"),
        exact=PER_CENT * used,
        strong=used > 1.0 and (is_held or not after),
    )


def _cost_text(cost: CostReport) -> str:
    """Say what the allocation of one sensor costs, and what limits cost."""
    given, now = (print_given(x, digits=DIGITS) for x in (cost.cost, cost.now))
    savings = "".join(
        say(
            " One percent more on {outputs} would save {saves}.",
            outputs=join_outputs(saving.outputs),
            saves=print_given(saving.saves, digits=DIGITS),
        )
        for saving in cost.savings
    )
    return say(
        "{sensor}: {given} for the lines that are free, {now} now; "
        "at most a part of {gap:.0e} above the least (residual "
        "below {residual:.0e}).{savings}",
        sensor=say(cost.sensor),
        given=given,
        now=now,
        gap=cost.gap,
        residual=max(settle(cost.residual), SHARP),
        savings=savings,
    )


def _checks_table(checks: Sequence[CoverageCheck]) -> Table:
    """Return how often the law's interval holds, output by output."""
    fields: tuple[Field[CoverageCheck], ...] = (
        Field(
            head=say("output at its limit"),
            cell=lambda check: Cell(
                text=capital(key_title(check.output)),
                note=say("corrected") if check.is_corrected else "",
            ),
        ),
        Field(
            head=say("trials"),
            kind="number",
            cell=lambda check: Cell(text=print_count(check.trials), exact=check.trials),
        ),
        Field(
            head=say("within the interval of the law [%]"),
            kind="number",
            cell=lambda check: Cell(
                text=f"{PER_CENT * check.covered:.2f}", exact=PER_CENT * check.covered
            ),
        ),
        Field(
            head=say("k of the law"),
            kind="number",
            cell=lambda check: Cell(
                text=f"{check.factor_before:.4f}", exact=check.factor_before
            ),
        ),
        Field(
            head=say("k allocated with"),
            kind="number",
            cell=lambda check: Cell(
                text=f"{check.factor:.4f}",
                exact=check.factor,
                strong=check.is_corrected,
            ),
        ),
    )
    return table_of(
        checks,
        fields,
        name="allocation-checks",
        caption=say("Coverage of the intervals of the law, by Monte Carlo"),
    )


def _shelves(allocation: Allocation) -> Iterator[Panel]:
    """Yield the catalogue entries of each sensor, the closest ones."""
    for sensor in dict.fromkeys(match.sensor for match in allocation.matches):
        own = [match for match in allocation.matches if match.sensor == sensor]
        meeting = sum(match.meets for match in own)
        yield from _points(
            say(
                "Catalogue: {meeting} of {own} {sensor} entries meet every line",
                meeting=meeting,
                own=len(own),
                sensor=say(sensor),
            ),
            map(match_text, own[: max(meeting, CLOSEST)]),
        )
