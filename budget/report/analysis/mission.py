"""A mission on a terminal: the finding, errors by time, which line is to blame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.language import key_title, say, term
from budget.model.sources import DEVICE, TURN_ON, source_of
from budget.names import MISSION, time_text
from budget.report.analysis.groups import rest_sections, verdict_sections
from budget.report.blocks import Abreast, Card, ForPages, Paragraph, Section
from budget.report.figures.growth import growth_pictures
from budget.report.mission import (
    aids_words,
    believed_table,
    believed_words,
    blamed,
    bought_table,
    by_time,
    contributions_table,
    full_title,
    leading,
    learnt_table,
    limits_table,
    motion_table,
    position_table,
    rate_per_hour,
    size,
    turned_words,
    what_sizes_are,
)
from budget.report.route import route_words
from budget.report.tables import (
    AT_LEAST,
    Number,
    bound_number,
    of_the_variance,
    print_share,
    round_uncertainty,
    validation_words,
)
from budget.report.wording import capital, standing_blocks
from budget.spec.records import UNCALIBRATED
from budget.studies.request import SHARED, analysis_of
from budget.studies.verdicts import calibration_words

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Block
    from budget.report.mission import AtTime
    from budget.results import Assessment, Budget, Calibrated, OutputBudget
    from budget.studies.mission import Curve


BUYS = term(
    "What the calibration buys: the CEP of a unit as it was made, of one that its "
    "maker alone has calibrated, and after this test, which adds its noise and finds "
    "what is new at each turn-on only once."
)
UNTESTED = term(
    "What a calibration by the maker buys: the CEP of a unit as it was made, and of "
    "one that its maker has calibrated."
)
TWICE = term(
    "after one test it counts twice in variance, in that turn-on and in the later one, "
    "and after the maker's calibration once"
)
NOISY = term("the test has it too, and a longer one averages more of it out")
OF_THE_PLACE = term("it is of the place of the test")
HELD = term("the test does not estimate what it is of, and the maker has")
LEARNT = term(
    "What the filter has learnt of each bias, slow noise with it: its standard "
    "uncertainty without aids and with them, when the last of them ends."
)
METHOD = term(
    "Errors of position, velocity and attitude follow x' = F x + G e along the "
    "nominal route: the modified phi-angle equations (Scherzinger and Reid 1994) with"
    " all terms of first order in position, e being the joint errors of all "
    "parameters at a later turn-on, and the noise in run. They are solved by matrix "
    "exponentials over short pieces of the route, which noise enters by its moments, "
    "in closed form for any correlation time. The map is linear, so contributions add"
    " up, and the law, Monte Carlo and validation are those of the calibration."
)


FILTERED = term(
    "With aids the unit has a Kalman filter: between epochs its covariance goes on as"
    " P <- F P F' + Q, at each one the gain is K = P H' (H P H' + R)^-1 and P <- (I -"
    " K H) P (I - K H)' + K R K', of Joseph's form (Brown and Hwang, Introduction to "
    "Random Signals and Applied Kalman Filtering; Grewal and Andrews, Kalman "
    "Filtering; Farrell, Aided Navigation). P, Q and R are what the filter believes. "
    "What is true is linear in every source once the gains are known: rows that are "
    "asked for are traced back through all updates, C <- C (I - K H), and take at "
    "each what the measurement adds, so that the contributions of all lines, aids and"
    " the start add up to the whole."
)


def mission_answer(budget: Budget) -> tuple[Section, ...]:
    """Return what stands on a terminal: finding, tables, what they rest on."""
    moments = by_time(budget)
    return (
        *verdict_sections(budget, mission_limits, _conditions),
        Section(
            name="mission",
            title=mission_title(budget),
            blocks=tuple(mission_blocks(budget, moments)),
        ),
        *rest_sections(
            budget, checked=validation_words(budget.outputs, budget.settings.digits)
        ),
    )


def _conditions(assessment: Assessment) -> Iterator[Block]:
    """Yield what the verdict stands on."""
    for sensor in assessment.sensors:
        yield from standing_blocks(sensor.standing)


def mission_title(budget: Budget) -> str:
    """Name the mission, and what calibrated the unit."""
    mission = budget.mission
    if mission is None:
        return ""
    how = calibration_words(analysis_of(budget).procedure)
    return say(
        "Mission: {name}, {calibration}", name=mission.name, calibration=say(how)
    )


def mission_section(budget: Budget, found: Curve | None = None) -> Section:
    """Return a mission in a report: finding, tables, figures, method."""
    moments = by_time(budget)
    limits = () if budget.assessment is None else budget.assessment.outputs
    drawn = ForPages(lambda: () if found is None else growth_pictures(found, limits))
    return Section(
        name="mission",
        title=mission_title(budget),
        blocks=(
            *mission_blocks(budget, moments),
            Abreast(blocks=(drawn,)),
            Paragraph(words=(say(METHOD),), small=True),
            *((Paragraph(words=(say(FILTERED),), small=True),) * bool(budget.filter)),
        ),
    )


def mission_card(budget: Budget) -> Card:
    """Return the finding on page one, where no limit is on the mission."""
    lines = (
        *finding(by_time(budget)),
        believed_words(budget),
        turned_words(budget),
        lower_bounds(budget),
    )
    return Card(
        title=mission_title(budget),
        lines=tuple((line,) for line in lines if line),
    )


def mission_blocks(budget: Budget, moments: Sequence[AtTime]) -> Iterator[Block]:
    """Yield the finding and the tables of a mission."""
    for text in finding(moments):
        yield Paragraph(words=(text,))
    if budget.mission is not None:
        yield Paragraph(words=(route_words(budget.mission.route),))
    yield position_table(moments)
    for text in what_sizes_are(moments):
        yield Paragraph(words=(text,), small=True)
    yield motion_table(moments)
    if gaps := lower_bounds(budget):
        yield Paragraph(words=(gaps,), small=True)
    if said := leading(moments):
        yield Paragraph(words=(said,))
    if any(any(one.shares) for one in blamed(moments)):
        yield contributions_table(moments)
    yield from _filter_blocks(budget)
    table = bought_table(budget, moments)
    if table is not None:
        is_tested = len(budget.bought) > len(UNCALIBRATED)
        yield Paragraph(words=(say(BUYS if is_tested else UNTESTED),))
        yield table
        if said := why_worse(budget.bought[-1]):
            yield Paragraph(words=(said,))


def _filter_blocks(budget: Budget) -> Iterator[Block]:
    """Yield which aids there are, and what the filter has learnt of them."""
    for text in (aids_words(budget), turned_words(budget), believed_words(budget)):
        if text:
            yield Paragraph(words=(text,))
    if (believed := believed_table(budget)) is not None:
        yield believed
    if (learnt := learnt_table(budget)) is not None:
        yield Paragraph(words=(say(LEARNT),))
        yield learnt


def why_worse(test: Calibrated) -> str:
    """Say which line makes a test leave more than its maker's; '' of others."""
    if test.because is None:
        return ""
    source = source_of(test.because.owner, test.because.quantity)
    why = NOISY
    if test.because.owner in SHARED:
        why = OF_THE_PLACE
    elif source.is_initial:
        why = HELD
    elif source.stays in {DEVICE, TURN_ON}:
        why = TWICE
    return say(
        "The test leaves more than the maker's calibration, most of it by {line}: "
        "{why}.",
        line=full_title(test.because),
        why=say(why),
    )


def finding(moments: Sequence[AtTime]) -> Iterator[str]:
    """Say how far off it is at the end, because of what; and the rate in an hour."""
    at = next((one for one in reversed(moments) if one.horizontal is not None), None)
    if at is None or at.horizontal is None or at.horizontal.radii is None:
        return
    row, radii = at.horizontal, at.horizontal.radii
    unit = at.unit_of("position")[0]
    if not row.is_resolved:
        yield unmoved(at, row)
        return
    cep, r95, drms = (
        size(at, row, value).text
        for value in (radii.cep, radii.r95, row.standard_uncertainty)
    )
    top = row.ranked[0]
    yield say(
        "After {time} the horizontal position is off by {cep} {unit} CEP ({r95} {unit} "
        "R95, {drms} {unit} DRMS); {share} of the variance is {source}.",
        time=time_text(at.time),
        cep=cep,
        r95=r95,
        drms=drms,
        unit=unit,
        share=print_share(top.share),
        source=full_title(top.source),
    )
    if (lost := next((one for one in moments if one.is_lost), None)) is not None:
        yield say(
            "After {time} the unit is lost: its attitude is off by more than 5.7 deg "
            "(1 sigma), and numbers of such errors say no more than that.",
            time=time_text(lost.time),
        )
    elif (found := rate_per_hour(moments)) is not None:
        yield rate_sentence(*found)


def unmoved(at: AtTime, row: OutputBudget) -> str:
    """Say that no line moves a position beyond rounding, and whether any may."""
    if row.is_unknown:
        return say(
            "After {time} nothing is known of the horizontal position: no line that is "
            "given reaches it.",
            time=time_text(at.time),
        )
    return say(
        "After {time} no line moves the horizontal position by more than {resolution} "
        "{unit}, the rounding of the computation.",
        time=time_text(at.time),
        resolution=round_uncertainty(row.output.resolution / row.output.si_per_unit),
        unit=row.output.unit,
    )


def rate_sentence(at: AtTime, rate: float) -> str:
    """Say the rate, and how it is defined."""
    row = at.horizontal
    number = Number(text=round_uncertainty(rate), exact=rate)
    if row is not None:
        number = bound_number(
            number, lower_bound=row.lower_bound, unknown=row.is_unknown
        )
    return say(
        "As a rate {rate} nmi/h: the CEP after {time}, divided by {time}.",
        rate=number.text,
        time=time_text(at.time),
    )


def lower_bounds(budget: Budget) -> str:
    """Say which lines the numbers lack; '' where none."""
    lacks = dict.fromkeys(name for row in budget.outputs for name in row.lacks)
    if not lacks:
        return ""
    return say(
        "{at_least} this or more: {lacks} not given.",
        at_least=AT_LEAST,
        lacks=say(", ").join(map(full_title, lacks)),
    )


def mission_limits(budget: Budget, assessment: Assessment) -> Iterator[Block]:
    """Yield the limits on a mission as a table, and what uses most of one."""
    rows = [r for r in assessment.outputs if r.output.name.owner == MISSION]
    yield limits_table(budget.settings.coverage, assessment, rows)
    for sensor in assessment.sensors:
        if sensor.sensor != MISSION:
            continue
        parts = budget.output(sensor.worst_output).contributions
        yield Paragraph(
            words=(
                say(
                    "{output}: {because}.",
                    output=capital(key_title(sensor.worst_output)),
                    because=of_the_variance(
                        [(full_title(part.source), part.share) for part in parts]
                    ),
                ),
            )
        )
