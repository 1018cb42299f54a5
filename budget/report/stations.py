"""Test stations for people and programs: figures, verdicts, acceptance limits."""

from __future__ import annotations

import json
from decimal import ROUND_FLOOR, Decimal
from itertools import groupby
from math import floor, log10
from operator import attrgetter
from typing import TYPE_CHECKING

from budget.distributions import NORMAL
from budget.language import key_title, say, words
from budget.model.sources import ENVIRONMENT, STATION, source_of
from budget.names import keys_of
from budget.report.allocation.words import CEILING, DASH, DIGITS, print_stop
from budget.report.blocks import (
    Cell,
    Field,
    Listing,
    Panel,
    Paragraph,
    Run,
    Section,
    assumptions_section,
    table_of,
)
from budget.report.document import csv_text
from budget.report.tables import (
    join_outputs,
    print_coverage,
    print_given,
    print_three,
    print_utilisation,
    source_title,
)
from budget.report.wording import VERDICTS, capital, standing_blocks
from budget.studies.request import given_lines
from budget.studies.stations import DOES, MOST_FALSE_ACCEPT, NO_FIGURES
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Block, Table
    from budget.studies.stations import (
        Qualification,
        StationFigure,
        StationOutput,
        StationVerdict,
    )

ANY = "any"
PER_CENT = 100.0
LEAST_RISK = 1e-4  # of a false accept: less is printed as less than this [1]
COLUMNS = (
    *("owner", "source", "unit", "any", "alone", "alone_stopped_by", "together"),
    *("binding_outputs", "now", "takes_now", "within", "why"),
)


def station_answer(found: Qualification) -> tuple[Section, ...]:
    """Return what stands on a terminal: the answer, and what was assumed."""
    return (station_section(found), assumptions_section(found.assumptions))


def station_section(found: Qualification) -> Section:
    """Return how good each figure must be and which station will do."""
    measured = "".join(f" {_measured(one)}" for one in _headed(found))
    blocks: list[Block] = [
        Paragraph(words=(Run(text=headline(found), strong=True), measured)),
        *_standing_blocks(found),
        Paragraph(words=(_settings(found),), small=True),
    ]
    for owner in (STATION, ENVIRONMENT):
        rows = [one for one in found.figures if one.source.owner == owner]
        inner: list[Block] = []
        if felt := [one for one in rows if not one.is_any]:
            inner.append(_figures_table(owner, felt))
        if points := tuple(_idle(rows)):
            inner.append(Listing(items=points, empty=say("None.")))
        blocks.append(
            Panel(
                title=say("How good the {owner} must be", owner=say(owner)),
                blocks=(*inner,),
            )
        )
    verdicts = _verdicts_table(found)
    blocks.append(Panel(title=say("Which station will do"), blocks=(verdicts,)))
    blocks.append(
        Panel(title=say("Acceptance limits"), blocks=tuple(_acceptance_blocks(found)))
    )
    if found.warnings:
        items = tuple((capital(say(text)),) for text in found.warnings)
        blocks.append(
            Panel(title=say("Remarks"), blocks=(Listing(items=items, empty=""),))
        )
    return Section(
        name="stations",
        title=say("What the test station must be"),
        blocks=tuple(blocks),
    )


def _standing_blocks(found: Qualification) -> Iterator[Block]:
    """Yield the verdict on what is calibrated by this test, and what it stands on."""
    for owner, standing in found.standings:
        said = say(
            "{sensor}: {verdict}, {after}.",
            sensor=capital(key_title(owner)),
            verdict=say(VERDICTS[standing.verdict]),
            after=say(standing.after),
        )
        yield Paragraph(words=(said,))
        yield from standing_blocks(standing)


def headline(found: Qualification) -> str:
    """State the finding: whether the procedure's own station does, and which others."""
    ratio = print_ratio(found.ratio)
    own, others = found.own, [one for one in found.doing if not one.is_own]
    names = say(", ").join(one.name for one in others)
    if own is None:
        if others:
            will = say(
                "{names} will do for {requirement} at {ratio}",
                names=capital(names),
                requirement=found.requirement,
                ratio=ratio,
            )
            failing = [
                one.name
                for one in found.stations
                if one.has_figures and one.verdict != DOES
            ]
            return (
                say(
                    "{will}; not: {failing}.",
                    will=will,
                    failing=say(", ").join(failing),
                )
                if failing
                else say("{will}.", will=will)
            )
        tried = [one for one in found.stations if one.has_figures]
        none = say(
            "No station here will do for {requirement} at {ratio}",
            requirement=found.requirement,
            ratio=ratio,
        )
        if not tried:
            return say("{none}: none gives a figure.", none=none)
        nearest = min(tried, key=lambda one: settle(one.utilisation))
        return say(
            "{none}; nearest is {name}, {worst_text}.",
            none=none,
            name=nearest.name,
            worst_text=_worst_text(nearest, found),
        )
    if own.verdict == NO_FIGURES:
        said = say(
            "{name} gives no figure, so nothing is known of it", name=capital(own.name)
        )
    else:
        word = say("will do") if own.verdict == DOES else say("will not do")
        said = say(
            "{name} {word} for {requirement} at {ratio}: ",
            name=capital(own.name),
            word=word,
            requirement=found.requirement,
            ratio=ratio,
        )
        said += _worst_text(own, found)
    return (
        say(
            "{said}; also {names} will."
            if own.verdict == DOES
            else "{said}; but {names} will.",
            said=said,
            names=names,
        )
        if names
        else say("{said}.", said=said)
    )


def _headed(found: Qualification) -> Iterator[StationVerdict]:
    """Yield the station that the headline is about, if one gives figures."""
    tried = [one for one in found.stations if one.has_figures]
    if tried:
        yield found.own or min(
            found.doing or tried, key=lambda one: settle(one.utilisation)
        )


def _measured(row: StationVerdict) -> str:
    """Say how far the whole measurement is below the limits at one station."""
    if row.test_ratio is None:
        return ""
    return say(
        "With the noise of the device in this test the test uncertainty ratio "
        "at {name} is {ratio} ({outputs}, most of U by {sources}).",
        name=row.name,
        ratio=print_ratio(row.test_ratio),
        outputs=join_outputs([one.output.name for one in row.all_coarsest]),
        sources=say(", ").join(
            source_title(name) for name in row.all_coarsest[0].whole_sources
        ),
    )


def print_ratio(ratio: float) -> str:
    """Print a ratio of a limit to an uncertainty: '4:1'."""
    return f"{print_given(ratio, digits=DIGITS)}:1"


def station_csv(found: Qualification) -> str:
    """Write one row for each source, values in its unit."""
    rows = (
        {
            key: say(", ").join(value) if isinstance(value, list) else value
            for key, value in one.to_dict().items()
        }
        for one in found.figures
    )
    return csv_text(COLUMNS, rows)


def station_yaml(found: Qualification) -> str:
    """Write a station file whose figures are what they may be together: 1 sigma.

    What may be any value is left out.
    """
    timing = found.procedure.timing
    given = given_lines((), found.procedure)
    tree: dict[str, object] = {
        "format": "budget-station/1",
        "name": f"station for {found.requirement} at {print_ratio(found.ratio)}"[:200],
    }
    for owner in (STATION, ENVIRONMENT):
        for one in found.figures:
            if one.source.owner != owner or one.together is None:
                continue
            *folders, last = keys_of(one.source.quantity)
            branch = tree.setdefault(owner, {})
            for folder in folders:
                branch = branch.setdefault(folder, {})  # type: ignore[attr-defined]
            value = one.together / one.si_per_unit
            branch[last] = f"{value!r} {one.unit}"  # type: ignore[index]
            if one.source in found.times:
                time = source_of(owner, one.source.quantity).time
                branch[time] = f"{found.times[one.source]!r} s"  # type: ignore[index]
            points = None if one.source not in given else given[one.source].points
            if points is not None:
                key = source_of(owner, one.source.quantity).points
                branch[key] = [f"{point!r} s" for point in points.tolist()]  # type: ignore[index]
    station: dict[str, object] = tree.setdefault(STATION, {})  # type: ignore[assignment]
    station |= {"scale_from": timing.scale_from, "window": timing.edges}
    lines = [
        f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in tree.items()
    ]
    return "\n".join(lines) + "\n"


def _settings(found: Qualification) -> str:
    """Say what the figures are and what they were found for."""
    shared = {
        "equal": say("each source gets an equal part of the limit that it uses most"),
        "proportional": say("one factor on all figures of the procedure's own station"),
    }[found.strategy]
    return say(
        "Asked for is {ratio}: the expanded uncertainty "
        "of the station alone (coverage {coverage} %, k = "
        "{coverage_factor:.4g}, law of propagation to second "
        "order, every line of the device 0) is to be at most limit "
        "/ {number}; used is U over that. limit / U of a station "
        "is the least test uncertainty ratio there, U being of the "
        "whole measurement. Alone: all other sources "
        "0; together: {shared}. Values are standard uncertainties "
        "(1 sigma), of every axis alike. Procedure {name}, error "
        "reference {reference}.",
        ratio=print_ratio(found.ratio),
        coverage=print_coverage(found.coverage),
        coverage_factor=found.coverage_factor,
        number=print_given(found.ratio),
        shared=shared,
        name=found.procedure.name,
        reference=words(found.reference),
    )


def _figures_table(owner: str, rows: Sequence[StationFigure]) -> Table:
    """Return what each source may be, beside what it is now."""

    def size(value: float | None, row: StationFigure, *, none: str = DASH) -> Cell:
        if value is None:
            return Cell(text=none)
        number = value / row.si_per_unit
        return Cell(text=print_given(number, digits=DIGITS), exact=number)

    def now(row: StationFigure) -> Cell | str:
        return size(row.now, row) if row.now is not None else ""

    def takes(row: StationFigure) -> Cell | str:
        if row.takes_now is None:
            return ""
        text = print_utilisation(row.takes_now).removesuffix(" %")
        used = PER_CENT * row.takes_now
        return Cell(text=text, exact=used, strong=settle(row.takes_now) > 1.0)

    def within(row: StationFigure) -> Cell | str:
        if row.is_within is None:
            return ""
        return Cell(
            text=say("yes") if row.is_within else say("no"), strong=not row.is_within
        )

    def stop(row: StationFigure) -> str:
        return join_outputs(row.stopped_by) if row.stopped_by else say(CEILING)

    fields: tuple[Field[StationFigure], ...] = (
        Field(
            head=say("figure"),
            cell=lambda row: Cell(
                text=capital(source_title(row.source)), note=capital(say(row.why))
            ),
        ),
        Field(head=say("alone"), kind="number", cell=lambda row: size(row.alone, row)),
        Field(
            head=say("together"),
            kind="number",
            cell=lambda row: size(row.together, row),
        ),
        Field(head=say("unit"), kind="unit", cell=lambda row: row.unit),
        Field(head=say("now"), kind="number", optional=True, cell=now),
        Field(
            head=say("uses [%]"),
            kind="number",
            optional=True,
            cell=takes,
        ),
        Field(head=say("within its part"), optional=True, cell=within),
        Field(head=say("alone stopped by"), weight=1.4, cell=stop),
        Field(
            head=say("together stopped by"),
            weight=1.4,
            optional=True,
            cell=lambda row: print_stop(row.binding_outputs, ""),
        ),
    )
    return table_of(
        rows,
        fields,
        name=f"station-figures-{owner}",
        caption=say(
            "What each figure of the {owner} may be, alone and together",
            owner=say(owner),
        ),
        by=attrgetter("unit"),
        is_wide=True,
    )


def _idle(rows: Sequence[StationFigure]) -> Iterator[tuple[str]]:
    """Say of which sources any value will do, and why."""
    why = [one for one in rows if one.is_any]
    for reason in dict.fromkeys(one.why for one in why):
        names = say(", ").join(
            source_title(one.source) for one in why if one.why == reason
        )
        yield (
            say(
                "{names}: any value will do; {reason}",
                names=capital(names),
                reason=say(reason),
            ),
        )


def _verdicts_table(found: Qualification) -> Table:
    """Return every station with its verdict."""

    def name(row: StationVerdict) -> Cell:
        own = say("the procedure's own, ") if row.is_own else ""
        return Cell(text=row.name, note=f"{own}{row.file}")

    def used(row: StationVerdict) -> Cell | str:
        if not row.has_figures:
            return DASH
        text = print_utilisation(row.utilisation).removesuffix(" %")
        return Cell(text=text, exact=PER_CENT * row.utilisation)

    def ratio(row: StationVerdict) -> Cell | str:
        return _ratio_cell(row.test_ratio)

    def worst(row: StationVerdict) -> str:
        return join_outputs(row.all_worst) if row.utilisation else DASH

    fields: tuple[Field[StationVerdict], ...] = (
        Field(head=say("station"), cell=name),
        Field(
            head=say("verdict"),
            cell=lambda row: Cell(
                text=say(row.verdict), strong=row.verdict not in {DOES, NO_FIGURES}
            ),
        ),
        Field(
            head=say("used [%]"),
            kind="number",
            cell=used,
        ),
        Field(head=say("worst output"), weight=1.4, cell=worst),
        Field(head=say("most of it from"), cell=_from),
        Field(head=say("limit / U"), kind="number", cell=ratio),
    )
    return table_of(
        found.stations,
        fields,
        name="station-verdicts",
        caption=say("Which station will do, by its worst output"),
        is_wide=True,
    )


def _ratio_cell(ratio: float | None) -> Cell | str:
    """Return a test uncertainty ratio, a dash where nothing is uncertain."""
    if ratio is None:
        return DASH
    return Cell(text=print_given(ratio, digits=DIGITS), exact=ratio)


def _from(row: StationVerdict) -> str:
    """Name the sources that take most of the worst output."""
    return say(", ").join(source_title(name) for name in row.worst.sources) or DASH


def _worst_text(row: StationVerdict, found: Qualification) -> str:
    """Say what the worst output uses and of what."""
    if not row.utilisation:
        return say("it reaches no limited output")
    return say(
        "{outputs} uses {utilisation} of limit / {ratio}, most of it by {sources}"
        if len(row.all_worst) == 1
        else "{outputs} use {utilisation} of limit / {ratio}, most of it by {sources}",
        outputs=join_outputs(row.all_worst),
        utilisation=print_utilisation(row.utilisation),
        ratio=print_given(found.ratio),
        sources=_from(row),
    )


def _acceptance_blocks(found: Qualification) -> Iterator[Block]:
    """Yield what is accepted at the own station, or at every candidate with figures."""
    guard = print_given(found.guard)
    band = "U" if found.guard == 1.0 else f"{guard} U"
    risk = float(NORMAL.probability([-found.guard * found.coverage_factor])[0])
    text = say(
        "The measured value of an error is accepted up to limit - "
        "{band}, U being the expanded uncertainty of the whole "
        "measurement, of the error as tested: noise of the device "
        "in this test and the station together (guarded acceptance, "
        "JCGM 106:2012, 8.3.2; r = {guard}). By an accepted value "
        "the error is beyond its limit with a probability of {risk} "
        "% at the most. None: {band} is not below the limit. limit / "
        "U is the test uncertainty ratio; station alone: accepted "
        "up to, were its U all.",
        band=band,
        guard=guard,
        risk=print_given(PER_CENT * risk, digits=2),
    )
    yield Paragraph(words=(text,), small=True)
    text = say(
        "False accept is the part of all items that is accepted and "
        "beyond the limit, with the spread that the lines of the "
        "device give the parameter before it is measured (JCGM "
        "106:2012, 9.5.2); ANSI/NCSL Z540.3 allows {most} %. A dash: "
        "nothing is accepted, or no line says how far it is from "
        "nominal.",
        most=print_given(PER_CENT * MOST_FALSE_ACCEPT),
    )
    yield Paragraph(words=(text,), small=True)
    shown = [found.own] if found.own else [s for s in found.stations if s.has_figures]
    for one in shown:
        yield _acceptance_table(one, found)
        if beyond := [
            row.output.name for row in one.outputs if row.is_accepted_too_often
        ]:
            text = say(
                "At {name} false accept is {risk} %, above the {most} % of ANSI/NCSL "
                "Z540.3: {outputs}. A guard band lowers it (--guard).",
                name=one.name,
                risk=print_given(PER_CENT * (one.false_accept or 0.0), digits=2),
                most=print_given(PER_CENT * MOST_FALSE_ACCEPT),
                outputs=join_outputs(beyond),
            )
            yield Paragraph(words=(Run(text=text, strong=True),))


def _acceptance_table(station: StationVerdict, found: Qualification) -> Table:
    """Return limit, U and acceptance limit of every limited output; alike ones once."""
    scale = attrgetter("output.si_per_unit")

    def expanded(row: StationOutput) -> str:
        value = row.whole / scale(row)
        return print_three(value) if value > 0.0 else "0"

    def up_to(value: float | None, u: float, row: StationOutput) -> str:
        if value is None:
            return say("none")
        return print_down(value / scale(row), u / scale(row))

    def accepted(row: StationOutput) -> str:
        return up_to(row.acceptance, row.whole, row)

    def by_station(row: StationOutput) -> str:
        return up_to(row.station_acceptance, row.whole, row)

    def alike(row: StationOutput) -> tuple[str, ...]:
        group = row.output.name.group
        values = expanded(row), accepted(row), by_station(row)
        return (group, row.printed_limit, *values, print_risk(row))

    rows: list[list[StationOutput]] = [
        [*rows] for _, rows in groupby(station.outputs, alike)
    ]

    def number(text: str, exact: float | None) -> Cell:
        return Cell(text=text, exact=exact)

    def size(value: float | None, row: StationOutput) -> float | None:
        return None if value is None else value / scale(row)

    fields: tuple[Field[list[StationOutput]], ...] = (
        Field(
            head=station.name,
            cell=lambda same: capital(join_outputs([row.output.name for row in same])),
        ),
        Field(
            head=say("limit"),
            kind="number",
            cell=lambda same: number(
                print_given(same[0].limit / scale(same[0]), digits=6),
                same[0].limit / scale(same[0]),
            ),
        ),
        Field(
            head="U",
            kind="number",
            cell=lambda same: number(expanded(same[0]), same[0].whole / scale(same[0])),
        ),
        Field(
            head=say("accept up to"),
            kind="number",
            cell=lambda same: number(
                accepted(same[0]), size(same[0].acceptance, same[0])
            ),
        ),
        Field(head=say("unit"), kind="unit", cell=lambda same: same[0].output.unit),
        Field(
            head=say("limit / U"),
            kind="number",
            cell=lambda same: _ratio_cell(same[0].test_ratio),
        ),
        Field(
            head=say("false accept [%]"),
            kind="number",
            cell=lambda same: Cell(
                text=print_risk(same[0]),
                exact=None
                if same[0].false_accept is None
                else PER_CENT * same[0].false_accept,
                strong=same[0].is_accepted_too_often,
            ),
        ),
        Field(
            head=say("station alone"),
            kind="number",
            cell=lambda same: Cell(
                text=by_station(same[0]),
                exact=size(same[0].station_acceptance, same[0]),
                strong=settle(same[0].utilisation) > 1.0,
            ),
        ),
    )
    return table_of(
        rows,
        fields,
        name=f"acceptance-{found.stations.index(station)}",
        caption=say(
            "Acceptance limits of what is measured at {name}", name=station.name
        ),
        by=lambda same: key_title(same[0].output.name.group),
        is_wide=True,
    )


def print_risk(row: StationOutput) -> str:
    """Print a false accept in per cent: a dash for none, and what is hardly any."""
    risk = row.false_accept
    if risk is None or row.acceptance is None:
        return DASH
    if risk < LEAST_RISK:
        return f"<{print_given(PER_CENT * LEAST_RISK)}"
    return print_given(PER_CENT * risk, digits=2)


def print_down(value: float, u: float) -> str:
    """Print an acceptance limit to the third digit of U, never rounded up."""
    if u <= 0.0 or value <= 0.0:
        return print_given(value, digits=6)
    place = max(floor(log10(settle(u))) - 2, floor(log10(value)) - 5)
    step = Decimal(1).scaleb(place)
    exact = Decimal(repr(settle(value)))
    return f"{(exact / step).to_integral_value(ROUND_FLOOR) * step:f}"
