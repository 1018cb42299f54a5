"""A comparison as a document, and as sections of a report on one device."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.language import counted, say, term, words
from budget.report.blocks import (
    Abreast,
    Card,
    Document,
    ForPages,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Run,
    Section,
)
from budget.report.comparison.document import to_json
from budget.report.comparison.figures import (
    front_picture,
    map_chart,
    margin_chart,
    no_front,
    no_fronts,
)
from budget.report.comparison.tables import (
    PAIRS_SHOWN,
    assumptions_table,
    front_table,
    imus_table,
    missing_table,
    outputs_table,
    pairs_table,
    procedures_table,
    ranking_note,
    ranking_table,
    rankings,
    what_is_judged,
)
from budget.report.comparison.wording import (
    advice_lines,
    answer,
    basis,
    cap_lines,
    computed_apart,
    headline,
    missing_effects,
    missing_note,
    not_compared_lines,
    nothing_known_line,
    reading_lines,
    rests_on_others_lines,
    standing_effects,
    undecidable_lines,
    unknown_cap_lines,
    verdict_lines,
)
from budget.report.figures.rows import chart_picture
from budget.report.provenance import provenance_section
from budget.report.tables import PER_CENT, settings_lines
from budget.report.wording import capital
from budget.studies.figures_of_merit import MERITS
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from budget.report.blocks import Block, Picture, Words
    from budget.report.comparison.tables import Ranking, Row
    from budget.studies.comparison.records import Comparison

COMMAND = "budget compare"
METHODS = {
    "gum": (
        term(
            "the law of propagation of uncertainty with second-order terms (JCGM 100); "
            "joint conformance from the joint normal distribution"
        )
    ),
    "monte-carlo": (
        term(
            "the law of propagation of uncertainty (JCGM 100) where what it can "
            "be off by is less than the sampling error of the trials, else Monte "
            "Carlo (JCGM 101); every device on the same random numbers; open "
            "verdicts and ranks get more trials"
        )
    ),
}


def comparison_document(
    comparison: Comparison, *, date: str, command_line: str = COMMAND
) -> Document:
    """Put a comparison into one document, the answer first."""
    found = rankings(comparison)
    number = len({one.place for one in comparison.entrants})
    sections = [
        _overview(found),
        _remarks(comparison, on_first_page=True),
        *_procedures(comparison, found),
        *(
            _devices(found, place, comparison.settings.missing, with_margins=False)
            for place in range(len(found))
        ),
        *_imus(comparison),
        *_pairs(comparison),
        *_missing(comparison),
        _assumptions(comparison, in_report=False),
        _method(comparison),
        provenance_section(
            comparison.inputs,
            comparison.settings,
            version=__version__,
            command_line=command_line,
        ),
    ]
    return Document(
        kind="comparison",
        title=counted(
            number,
            "{number} device compared",
            "{number} devices compared",
            number=number,
        ),
        facts=(
            counted(
                len(comparison.procedures),
                "procedure {procedures}",
                "procedures {procedures}",
                procedures=say(", ").join(comparison.procedures),
            ),
        ),
        headline=headline(comparison),
        summary=(f"{answer(comparison)} {basis(comparison)}",),
        cards=tuple(map(_card, found)),
        sections=tuple(sections),
        json=to_json(comparison),
        date=date,
        version=__version__,
    )


def comparison_sections(comparison: Comparison) -> tuple[Section, ...]:
    """Return the sections that stand inside a report on something else.

    The answer and how it was computed, the devices sensor by sensor, pairs, what the
    files leave to be assumed, and what to beware of.
    """
    # No headline here: 'MET' would be read as a verdict on the report's device.
    apart = Paragraph(words=(computed_apart(comparison),), small=True)
    return tuple(_answer(comparison, rankings(comparison), apart))


def comparison_answer(
    comparison: Comparison, *, order: Callable[[Row], Any] | None = None
) -> tuple[Section, ...]:
    """Return what stands alone on a terminal: the same, and the settings.

    The rows of a ranking are sorted by `order`, in place of the rank.
    """
    return (
        *_answer(comparison, rankings(comparison, order=order)),
        _method(comparison),
    )


def _answer(
    comparison: Comparison, found: Sequence[Ranking], *apart: Block
) -> Iterator[Section]:
    """Yield the sections that report and terminal have in common."""
    lines = (*verdict_lines(found), *not_compared_lines(comparison))
    yield Section(
        name="comparison",
        title=say(
            "Comparison against {requirement}", requirement=comparison.requirement
        ),
        blocks=(
            Paragraph(words=(Run(text=answer(comparison), strong=True),)),
            Paragraph(words=(basis(comparison),), small=True),
            *apart,
            Listing(
                items=tuple((capital(line),) for line in lines),
                empty=say("No device has a required sensor."),
            ),
        ),
    )
    yield from _procedures(comparison, found)
    for place in range(len(found)):
        yield _devices(found, place, comparison.settings.missing, with_margins=True)
    yield from _imus(comparison)
    yield from _pairs(comparison)
    yield from _missing(comparison)
    yield _assumptions(comparison, in_report=True)
    yield _remarks(comparison, on_first_page=False)


def _card(table: Ranking) -> Card:
    """Return the answer for one sensor under one procedure."""
    best = table.best
    lines: list[Words] = []
    if best is None:
        lines.append((Run(text=say("No device meets"), strong=True),))
    else:
        used = Run(
            text=say("{utilisation} % of the limit", utilisation=best.utilisation),
            exact=PER_CENT * best.of.utilisation,
        )
        lines += [
            (Run(text=say("{device} is best", device=best.device), strong=True),),
            (
                used,
                say(
                    " at {worst_output}, limited by {limiting_source}",
                    worst_output=best.worst_output,
                    limiting_source=best.limiting_source,
                ),
            ),
        ]
    lines.append((table.counts,))
    return Card(title=table.subject, lines=tuple(lines))


def _overview(found: Sequence[Ranking]) -> Section:
    """Return how far every device is from its limit."""
    drawing = ForPages(
        lambda: (
            chart_picture(margin_chart(table, f"margins-{table.sensor}-{place}"))
            for place, table in enumerate(found)
            if table.rows
        )
    )
    nothing = Paragraph(words=(say("No device gives a line to draw."),))
    has_rows = any(table.rows for table in found)
    return Section(
        name="overview",
        title=say("Against the limits"),
        blocks=(Abreast(blocks=(drawing,)),) if has_rows else (nothing,),
        on_first_page=True,
    )


def _remarks(comparison: Comparison, *, on_first_page: bool) -> Section:
    """Return what to beware of: warnings, advice, caps, and verdicts left open."""
    lines = (
        *map(say, comparison.warnings),
        *filter(None, map(nothing_known_line, rankings(comparison))),
        *undecidable_lines(comparison),
        *rests_on_others_lines(comparison),
        *reading_lines(comparison),
        *advice_lines(comparison),
        *(say("Over a cap: {line}", line=line) for line in cap_lines(comparison)),
        *(say("Cap on {line}", line=line) for line in unknown_cap_lines(comparison)),
    )
    said = (
        say("no cap is exceeded")
        if comparison.caps
        else say("the requirement sets no cap")
    )
    return Section(
        name="remarks",
        title=say("What to beware of"),
        blocks=(
            Listing(
                items=tuple((capital(line),) for line in lines),
                empty=say("No verdict hangs on a missing line, and {said}.", said=said),
            ),
        ),
        on_first_page=on_first_page,
    )


def _missing(comparison: Comparison) -> tuple[Section, ...]:
    """Return what 'at worst' stands on; nothing where no line is missing."""
    refused = comparison.settings.missing == "refuse"
    effects = (standing_effects if refused else missing_effects)(comparison)
    if not effects:
        return ()
    if refused:
        return (
            Section(
                name="standing",
                title=say("What the verdicts stand on"),
                blocks=(missing_table(effects, head=say("verdict")),),
            ),
        )
    text = missing_note(comparison.settings.missing)
    return (
        Section(
            name="missing",
            title=say("In the place of lines that are not given"),
            blocks=(
                Paragraph(words=(text,), small=True),
                missing_table(effects),
            ),
        ),
    )


def _procedures(
    comparison: Comparison, found: Sequence[Ranking]
) -> tuple[Section, ...]:
    """Return every device under every procedure; nothing where there is one."""
    if len(comparison.procedures) == 1 or not comparison.devices:
        return ()
    text = say("% of the limit and verdict, in the order of the first procedure.")
    return (
        Section(
            name="procedures",
            title=say("By procedure"),
            blocks=(
                Paragraph(words=(text,), small=True),
                *(
                    Panel(
                        title=capital(what_is_judged(sensor)),
                        blocks=(procedures_table(comparison, found, sensor),),
                    )
                    for sensor in dict.fromkeys(t.sensor for t in found if t.rows)
                ),
            ),
        ),
    )


def _devices(
    found: Sequence[Ranking], place: int, mode: str, *, with_margins: bool
) -> Section:
    """Return ranking and figures of one sensor under one procedure.

    What the columns mean stands once, with the first ranking.
    """
    table = found[place]
    is_first = not any(before.rows for before in found[:place])
    explained = (ranking_note(found, mode),) if is_first else ()
    unknown = nothing_known_line(table)
    said = (
        (Paragraph(words=(say("{unknown}.", unknown=capital(unknown)),)),)
        if unknown
        else ()
    )
    end = f"{table.sensor}-{place}"
    name = f"devices-{end}"
    title = say(
        "{sensor} devices{under}: {counts}",
        sensor=capital(what_is_judged(table.sensor)),
        under=table.under,
        counts=table.counts,
    )
    if not table.rows:
        return Section(name=name, title=title, blocks=said)

    def drawn_map() -> Iterator[Picture]:
        data = outputs_table(table, f"outputs-{end}")
        yield chart_picture(map_chart(table, f"map-{end}", data))

    def drawn_costs() -> Iterator[Picture]:
        if with_margins:
            yield chart_picture(margin_chart(table, f"margins-{end}"))
        yield from _fronts(table, end)

    blocks: list[Block] = [
        *said,
        ranking_table(table, f"ranking-{end}"),
        *(Paragraph(words=(text,), small=True) for text in explained),
        ForPages(drawn_map),
        Abreast(blocks=(ForPages(drawn_costs),)),
    ]
    if why_not := no_fronts(table):
        remark = Paragraph(words=(why_not,), small=True)
        blocks.append(ForPages(lambda: (remark,)))
    return Section(
        name=name,
        title=title,
        blocks=tuple(blocks),
    )


def _fronts(table: Ranking, end: str) -> Iterator[Picture]:
    """Yield a front for each cost of which there are two different amounts."""
    for merit in MERITS:
        if not no_front(table, merit):
            data = front_table(table, merit, f"{merit}-{end}")
            yield front_picture(table, merit, f"front-{merit}-{end}", data)


def _imus(comparison: Comparison) -> tuple[Section, ...]:
    """Return the ranking of IMUs as one device; nothing where there is none."""
    imus = comparison.ranked_imus
    if not imus:
        return ()
    text = say(
        "Gyro and accelerometer of one unit together: the graver verdict, the larger "
        "part of a limit, and the probability that all outputs of both are within "
        "their limits, counted in the same trials, so what the two share is in it."
    )
    return (
        Section(
            name="imus",
            title=say("IMUs as one device"),
            blocks=(imus_table(imus), Paragraph(words=(text,), small=True)),
        ),
    )


def _pairs(comparison: Comparison) -> tuple[Section, ...]:
    """Return pairs of a gyro and an accelerometer; nothing where none were asked."""
    pairs = comparison.pairs
    if not pairs:
        return ()
    text = say("Counted in the same trials, so what the two share is in it.")
    if len(pairs) > PAIRS_SHOWN:
        more = len(pairs) - PAIRS_SHOWN
        text += say(" {more} more pairs are in the JSON document.", more=more)
    return (
        Section(
            name="pairs",
            title=say("Pairs of gyro and accelerometer"),
            blocks=(pairs_table(pairs), Paragraph(words=(text,), small=True)),
        ),
    )


def _assumptions(comparison: Comparison, *, in_report: bool) -> Section:
    """Return what the files leave to be assumed; a report has a section of its own."""
    name = "comparison-assumptions" if in_report else "assumptions"
    blocks: tuple[Block, ...] = (
        (assumptions_table(comparison, f"{name}-table"),)
        if comparison.assumptions
        else (Paragraph(words=(say("None: the files say all that is needed."),)),)
    )
    title = (
        say("Assumptions of the compared devices") if in_report else say("Assumptions")
    )
    number = len(comparison.assumptions)
    brief = (
        say("Assumptions: {number}, all in --json", number=number)
        if number
        else say("Assumptions: none")
    )
    told = (say(one.said) for file in comparison.inputs for one in file.changes)
    brief = say("; ").join((brief, *dict.fromkeys(told)))
    return Section(name=name, title=title, blocks=blocks, in_brief=brief)


def _method(comparison: Comparison) -> Section:
    """Return what the numbers depend on besides the files."""
    rows = []
    for name, value in settings_lines(comparison.settings):
        text = words(value) if name == "error reference" else say(value)
        if name == "method":
            text = say("{value}: {methods}", value=text, methods=say(METHODS[value]))
        rows.append((say(name), (text,)))
    return Section(
        name="method", title=say("Method"), blocks=(Pairs(rows=tuple(rows)),)
    )
