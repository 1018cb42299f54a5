"""The answer: which sensor meets, by what margin, because of what; the limits."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from budget.report.analysis.wording import (
    MISSING,
    REFERENCES,
    SEVERITY,
    VERDICTS,
    first_up,
    value,
)
from budget.report.blocks import (
    Card,
    Cell,
    Column,
    Paragraph,
    RowGroup,
    Run,
    Section,
    Table,
)
from budget.report.tables import (
    UNKNOWN,
    Number,
    bound_number,
    join_outputs,
    output_title,
    print_causes,
    print_coverage,
    print_decimals,
    print_share,
    print_utilisation,
    round_error,
    source_title,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Block, Words
    from budget.report.tables import GroupTable
    from budget.results import (
        Assessment,
        Budget,
        OutputAssessment,
        SensorAssessment,
        Settings,
    )

CAP_HEADS = ("cap, which decides no verdict", "at most", "device", "given", "")
SPARE = 0.01  # of the limit [1]; a margin below it is no margin to speak of


def headline(budget: Budget, assessment: Assessment | None) -> str:
    """Return the answer in one line: 'FAILS navigation grade'.

    It stands on every printed page, so it says where sources were left out.
    """
    part = ", chosen sources alone" if budget.settings.only else ""
    if assessment is None:
        coverage = print_coverage(budget.settings.coverage)
        return f"Error budget, U at {coverage} % coverage{part}"
    given = {sensor.verdict for sensor in assessment.sensors}
    overall = next(word for word in SEVERITY if word in given)
    if assessment.not_there:
        present = " and ".join(sensor.sensor for sensor in assessment.sensors)
        part = f", {present} alone{part}"
    return f"{VERDICTS[overall]} {assessment.requirement}{part}"


def summary(budget: Budget, assessment: Assessment | None) -> Words:
    """Return the answer in a sentence or two: margin, and what errors are."""
    absent: Words = ()
    if assessment is not None and assessment.not_there:
        text = (
            f"Nothing is said of the {' and '.join(assessment.not_there)}, which the "
            "requirement limits too: no device with one was given. "
        )
        absent = (text,)
    return (*_left_out(budget.settings), *absent, *_margin(budget, assessment))


def verdict_cards(budget: Budget, assessment: Assessment) -> tuple[Card, ...]:
    """Return the verdict on each sensor."""
    rows = {row.output.name: row for row in assessment.outputs}
    return tuple(
        _verdict_card(budget, sensor, rows[sensor.worst_output])
        for sensor in assessment.sensors
    )


def group_cards(groups: Sequence[GroupTable]) -> tuple[Card, ...]:
    """Return U of each group of parameters, where nothing is required."""
    return tuple(_group_card(group) for group in groups)


def limits_section(budget: Budget, assessment: Assessment) -> Section:
    """Return every required output against its limit, as a table."""
    coverage = print_coverage(budget.settings.coverage)
    groups = tuple(
        RowGroup(
            title=output_title(name),
            rows=tuple(
                _limit_row(row, is_known=row in assessment.judged) for row in outputs
            ),
        )
        for name, outputs in groupby(
            assessment.outputs, key=lambda row: row.output.name.rpartition(".")[0]
        )
    )
    table = Table(
        name="limits-table",
        caption=f"Largest errors against the limits of {assessment.requirement}",
        columns=(
            Column(head="axis"),
            Column(head="largest error", kind="number"),
            Column(head="", kind="unit"),
            Column(head="limit", kind="text"),
            Column(head="of the limit [%]", kind="number"),
            Column(head="verdict"),
        ),
        groups=groups,
        searchable=True,
    )
    text = (
        f"{first_up(assessment.requirement)}. A limit is on the absolute error: the "
        f"largest absolute end of the {coverage} % interval is held against it."
    )
    blocks: tuple[Block, ...] = (Paragraph(words=(text,)), table)
    if assessment.caps:
        blocks += (_caps_table(assessment),)
    return Section(name="limits", title="Limits", blocks=blocks)


def _limit_row(row: OutputAssessment, *, is_known: bool) -> tuple[Cell, ...]:
    """Return one required output against its limit."""
    error = _error(row)
    used = _used(row)
    strong = not row.is_within
    word = "within" if row.is_within else "beyond"
    if row.by_monte_carlo:
        word += ", by Monte Carlo"
    if row.lower_bound and row.is_within:
        word = "open: lines missing"
    if not is_known:
        word = "not known"
    return (
        Cell(text=row.output.name.rpartition(".")[2], strong=strong),
        Cell(text=error.text, exact=error.exact, strong=strong),
        Cell(text=row.output.unit, strong=strong),
        Cell(text=row.printed_limit, strong=strong),
        Cell(
            text=used.text.removesuffix(" %"),
            exact=used.exact,
            strong=strong,
            share=min(row.utilisation, 1.0) if is_known else None,
        ),
        Cell(text=word, strong=strong),
    )


def _caps_table(assessment: Assessment) -> Table:
    """Return what the devices cost, weigh and draw against the caps."""
    words = {True: "within", False: "beyond", None: "not known"}
    return Table(
        name="caps",
        caption="Price, mass and power against their caps; they decide no verdict",
        columns=tuple(Column(head=head) for head in CAP_HEADS),
        groups=(
            RowGroup(
                rows=tuple(
                    (
                        Cell(text=cap.merit),
                        Cell(text=cap.cap),
                        Cell(text=cap.device),
                        Cell(text=cap.given or "not given"),
                        Cell(text=words[cap.is_within], strong=cap.is_within is False),
                    )
                    for cap in assessment.caps
                )
            ),
        ),
    )


def _left_out(settings: Settings) -> Words:
    """Say that sources were left out, where they were."""
    if not settings.only:
        return ()
    only = ", ".join(map(output_title, settings.only))
    text = (
        f"Only these sources are counted: {only}. All other lines are set to zero in "
        "this run, so this is not the budget of the whole device. "
    )
    return (Run(text=text, strong=True),)


def _margin(budget: Budget, assessment: Assessment | None) -> Words:
    """Return by how much limits are held or exceeded, and what errors are."""
    basis = _basis(budget.settings)
    if assessment is None:
        counted = first_up(REFERENCES[budget.settings.reference])
        left = "No requirement was given: this is what the calibration leaves."
        return (f"{left} {counted}.",)
    unknown = [sensor.sensor for sensor in assessment.sensors if sensor.nothing_known]
    judged = assessment.judged
    said = (
        f"Nothing is known of the {' and '.join(unknown)}: the data sheet gives no "
        "error line, and a 0 says just that. "
    )
    nothing: Words = (Run(text=said, strong=True),) if unknown else ()
    if not judged:
        return (*nothing, basis)
    total = len(judged)
    beyond = sum(not row.is_within for row in judged)
    worst = max(row.utilisation for row in judged)
    if beyond:
        by = _print_excess(worst - 1.0)
        found = f"{beyond} of {total} required outputs exceed their limits, by up to "
        return (*nothing, f"{found}{by} of the limit. ", basis)
    open_ones = sum(row.lower_bound for row in assessment.outputs)
    if open_ones:
        found = (
            f"{len(assessment.outputs) - open_ones} of {len(assessment.outputs)} "
            "required outputs are within their limits; "
            f"{open_ones} cannot be decided, as lines are missing"
        )
        return (*nothing, f"{found}. ", basis)
    found = f"All {total} required outputs stay within their limits"
    if 1.0 - worst >= SPARE:
        spare = print_decimals(100.0 * (1.0 - worst), 1)
        found += f", with {spare} % of the nearest one to spare"
    return (*nothing, f"{found}. ", basis)


def _verdict_card(
    budget: Budget, sensor: SensorAssessment, worst: OutputAssessment
) -> Card:
    """Say of a sensor whether it meets, by which output, and because of what."""
    missing = ", ".join(
        MISSING.get(line, line) for line in map(source_title, sensor.expected_missing)
    )
    lines: list[Words] = []
    if sensor.nothing_known:
        lines.append((f"Nothing is known of it: {missing} are not given.",))
        return Card(
            title=f"{first_up(sensor.sensor)}: {VERDICTS[sensor.verdict]}",
            lines=tuple(lines),
        )
    if sensor.verdict == "undecidable":
        lines.append(
            (f"It would meet, but the data sheet does not give {missing}.",),
        )
    elif sensor.verdict == "undecided":
        text = (
            "The trials do not tell on which side of the limit it is; "
            "more of them will."
        )
        lines.append((text,))
    lines.append(
        (
            f"Worst output: {join_outputs(sensor.worst_outputs)}, largest error ",
            value(
                _error(worst),
                worst.output.unit,
            ),
            f", limit {worst.printed_limit}: ",
            value(_used(worst)),
            " of the limit.",
        )
    )
    if worst.by_monte_carlo:
        lines.append(("By Monte Carlo: the law failed its check there.",))
    if sensor.advice:
        lines.append((f"{first_up(sensor.advice)}.",))
    because = print_causes(
        [
            (source_title(part.source), part.share)
            for part in budget.output(sensor.worst_output).contributions
        ]
    )
    text = f"Because: {because} of the variance of that output."
    if missing and sensor.verdict != "undecidable":
        text += f" Not given: {missing}."
    lines.append((text,))
    return Card(
        title=f"{first_up(sensor.sensor)}: {VERDICTS[sensor.verdict]}",
        lines=tuple(lines),
    )


def _group_card(group: GroupTable) -> Card:
    """Say how large U of a group is, on which axis, and what causes it."""
    coverage = print_coverage(group.coverage)
    widest = group.widest
    same = len({row.expanded.text for row in group.rows}) == 1
    where = "every axis" if same else f"axis {widest.axis}"
    first: Words = (f"U{coverage} ", value(widest.expanded, group.unit))
    if widest.mean.text not in {"0", UNKNOWN} and float(widest.mean.text) != 0.0:
        first += (", mean ", value(widest.mean, group.unit))
    causes = group.causes
    if causes != "no spread":
        causes += " of the variance"
    lines: list[Words] = [(*first, f" ({where})"), (causes,)]
    if group.gaps:
        lines.append((f"{group.gaps}.",))
    refused = [
        row.axis
        for row in group.rows
        if row.check is not None and row.check.word != "holds"
    ]
    if refused:
        lines.append((f"In doubt: the law is not confirmed on {', '.join(refused)}.",))
    return Card(title=first_up(group.title), lines=tuple(lines))


def _print_excess(part: float) -> str:
    """Print by how much a limit is exceeded, in parts of it; never 0."""
    return print_share(part) if part < SPARE else f"{print_decimals(100.0 * part, 0)} %"


def _used(row: OutputAssessment) -> Number:
    """Return the part of its limit that an output uses."""
    used = Number(text=print_utilisation(row.utilisation), exact=row.utilisation)
    return bound_number(used, lower_bound=row.lower_bound, unknown=row.is_unknown)


def _error(row: OutputAssessment) -> Number:
    """Round a largest error, in the unit of the output; marked where it is a bound."""
    error = round_error(row.largest_error, row.standard_uncertainty, row.output)
    return bound_number(error, lower_bound=row.lower_bound, unknown=row.is_unknown)


def _basis(settings: Settings) -> str:
    """Say at which coverage errors are given, and from what they are counted."""
    coverage = print_coverage(settings.coverage)
    return f"Errors at {coverage} % coverage; {REFERENCES[settings.reference]}."
