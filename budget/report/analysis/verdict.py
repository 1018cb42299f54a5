"""Verdict and limits of a report: margins, contributions, cards of page one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.language import beside, counted, key_title, say, term, words
from budget.names import IMU, MISSION, by_group
from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Field,
    Listing,
    Panel,
    Paragraph,
    Run,
    Section,
    table_of,
)
from budget.report.mission import limits_blocks
from budget.report.readings import verdict_line
from budget.report.tables import (
    SMALL_SHARE,
    UNKNOWN,
    Number,
    as_limited,
    bound_number,
    join_outputs,
    largest_error,
    of_the_variance,
    print_chance,
    print_coverage,
    print_decimals,
    print_most,
    print_probability,
    print_share,
    print_utilisation,
    round_u,
    source_title,
    used_part,
)
from budget.report.wording import (
    MISSING,
    NOT_KNOWN,
    VERDICTS,
    capital,
    caution_texts,
    cell,
    condition_texts,
    deciding_lines,
    doubt_sentence,
    error_reference,
    mode_remark,
    mode_sentence,
    outcome_words,
    points,
    say_words,
    value,
)
from budget.studies.request import given_lines, sensors_of
from budget.studies.verdicts import MEETS_IF
from budget.ties import first_largest, from_largest, settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from budget.inputs.records import Device, ErrorLine, Procedure
    from budget.names import Name
    from budget.report.blocks import Block, Table, Words
    from budget.report.tables import GroupTable
    from budget.results import (
        Assessment,
        Budget,
        OutputAssessment,
        SensorAssessment,
        Settings,
    )


ON_A_CARD = 3  # conditions and cautions at the most
SPARE = 0.01  # of the limit [1]; a margin below it is no margin to speak of


def headline(budget: Budget, assessment: Assessment | None) -> str:
    """Return the answer in one line: 'FAILS navigation grade'.

    It stands on every printed page, so it says where sources were left out.
    """
    part = say(", chosen sources alone") if budget.settings.only else ""
    if assessment is None:
        coverage = print_coverage(budget.settings.coverage)
        part += mode_remark(budget.settings)
        return say(
            "Error budget, U at {coverage} % coverage{part}",
            coverage=coverage,
            part=part,
        )
    overall = assessment.verdict
    if assessment.not_there:
        present = say(" and ").join(
            key_title(sensor.sensor) for sensor in assessment.sensors
        )
        left = say(" and ").join(map(key_title, assessment.not_there))
        part = say(
            ", {present} alone, {left} not judged{part}",
            present=present,
            left=left,
            part=part,
        )
    if overall == "predicted" and assessment.chance is not None:
        chance = print_chance(assessment.chance)
        part += say(": meets with a probability of {chance}", chance=chance)
    part += mode_remark(budget.settings)
    after = say(assessment.sensors[-1].standing.after)  # a mission stands last
    number = sum(
        len(sensor.standing.conditions)
        for sensor in assessment.sensors
        if sensor.verdict == MEETS_IF
    )
    if overall == MEETS_IF:
        return counted(
            number,
            "MEETS {requirement} ON A CONDITION{part}, {after}",
            "MEETS {requirement} ON {number} CONDITIONS{part}, {after}",
            number=number,
            requirement=assessment.requirement,
            part=part,
            after=after,
        )
    return say(
        "{verdict} {requirement}{part}, {after}",
        verdict=say(VERDICTS[overall]),
        requirement=assessment.requirement,
        part=part,
        after=after,
    )


def judged_by(budget: Budget, carried: Budget | None) -> Budget:
    """Return the budget that the verdicts are of, where the mission alone is limited.

    A unit on it may be as its maker calibrated it, and the test of the other budget
    then calibrated nothing that is judged.
    """
    found = budget.assessment
    if carried and found and {one.sensor for one in found.sensors} == {MISSION}:
        return carried
    return budget


def summary(
    budget: Budget, assessment: Assessment | None, carried: Budget | None = None
) -> Words:
    """Return the answer in a sentence or two: margin, and what errors are."""
    not_there = () if assessment is None else assessment.not_there
    triads = [owner for owner in not_there if owner not in {IMU, MISSION}]
    absent: list[str] = []
    if budget.mission is not None and not_there:
        absent.append(
            say(
                "Limits on {triads} are on the calibration, which this does not judge: "
                "`budget analyze --requirement` does, and `budget compare --mission` "
                "judges all. ",
                triads=say(" and ").join(map(key_title, not_there)),
            )
        )
        triads, not_there = [], ()
    if MISSION in not_there:
        absent.append(
            say(
                "Nothing is said of the mission, which the requirement limits too: "
                "`budget mission` and `budget report --mission` do. "
            )
        )
    if triads:
        absent.append(
            say(
                "Nothing is said of the {triads}, which the requirement "
                "limits too: no device with one was calibrated. ",
                triads=say(" and ").join(map(say, triads)),
            )
        )
    if IMU in not_there:
        absent.append(
            say(
                "Nothing is said of the misalignment, which the requirement "
                "limits too: it takes the mounting angles of a gyro and an "
                "accelerometer. "
            )
        )
    mode = mode_sentence(budget.settings)
    return (
        *_left_out(budget.settings),
        *absent,
        *_margin(judged_by(budget, carried), assessment),
        *((f" {mode}",) if mode else ()),
    )


def verdict_cards(
    budget: Budget, assessment: Assessment, carried: Budget | None = None
) -> tuple[Card, ...]:
    """Return the verdict on each sensor; on a mission by its own budget."""
    rows = {row.output.name: row for row in assessment.outputs}
    return tuple(
        _verdict_card(
            carried if carried and sensor.sensor == MISSION else budget,
            sensor,
            rows[sensor.worst_output],
            is_joint=assessment.together is not None,
        )
        for sensor in assessment.sensors
    )


def group_cards(groups: Sequence[GroupTable]) -> tuple[Card, ...]:
    """Return U of each group of parameters, where nothing is required."""
    return tuple(_group_card(group) for group in groups)


def limits_section(budget: Budget, assessment: Assessment) -> Section:
    """Return every required output against its limit, as a table."""
    coverage = print_coverage(budget.settings.coverage)
    text = say(
        "{requirement}. A limit is on the absolute error: the largest absolute end of "
        "the {coverage} % interval of each output is held against it. {jointly}",
        requirement=capital(assessment.requirement),
        coverage=coverage,
        jointly=_jointly(assessment),
    ).rstrip()
    sensors = dict.fromkeys(row.output.name.owner for row in assessment.outputs)
    tables = {
        sensor: limits_blocks(
            budget.settings.coverage,
            assessment,
            [row for row in assessment.outputs if row.output.name.owner == sensor],
        )[0]
        if sensor == MISSION
        else _limits_table(assessment, sensor)
        for sensor in sensors
    }
    blocks: tuple[Block, ...] = (Paragraph(words=(text,)),)
    if len(tables) > 1:
        panels = (
            Panel(title=capital(key_title(sensor)), blocks=(table,))
            for sensor, table in tables.items()
        )
        blocks += (Abreast(blocks=tuple(panels)),)
    else:
        blocks += tuple(tables.values())
    if assessment.caps:
        blocks += (_caps_table(assessment),)
    stands_on = tuple(
        say("{sensor}: {said}", sensor=capital(key_title(one.sensor)), said=text)
        for one in assessment.sensors
        for text in (*condition_texts(one.standing), *caution_texts(one.standing))
    )
    if stands_on:
        listing = Listing(items=points(stands_on), empty="")
        blocks += (Panel(title=say("What the verdicts stand on"), blocks=(listing,)),)
    return Section(name="limits", title=say("Limits"), blocks=blocks)


def _limits_table(assessment: Assessment, sensor: str) -> Table:
    """Return the required outputs of a sensor against limits; bold what exceeds."""

    def text(pick: Callable[[OutputAssessment], str]) -> Callable[..., Cell]:
        return lambda row: Cell(text=pick(row), strong=not row.is_within)

    def used(row: OutputAssessment) -> Cell:
        number, known = used_part(row), outcome_words(assessment, row) != say(NOT_KNOWN)
        return Cell(
            text=number.text.removesuffix(" %"),
            exact=number.exact,
            strong=not row.is_within,
            share=min(row.utilisation, 1.0) if known else None,
        )

    return table_of(
        [row for row in assessment.outputs if row.output.name.owner == sensor],
        (
            Field(head=say("axis"), cell=text(lambda row: row.output.name.axis)),
            Field(
                head=say("largest error"),
                kind="number",
                cell=lambda row: cell(largest_error(row), strong=not row.is_within),
            ),
            Field(head=say("of the limit [%]"), kind="number", cell=used),
            Field(
                head=say("verdict"),
                cell=text(lambda row: outcome_words(assessment, row)),
            ),
        ),
        name=f"limits-{sensor}",
        caption=say(
            "Largest {sensor} errors against limits of {requirement}",
            sensor=say(sensor),
            requirement=assessment.requirement,
        ),
        by=lambda row: say(
            "{quantity} [{unit}], limit {printed_limit}",
            quantity=capital(words(row.output.name.quantity)),
            unit=row.output.unit,
            printed_limit=row.printed_limit,
        ),
        titled=True,
        searchable=True,
    )


def _caps_table(assessment: Assessment) -> Table:
    """Return what the devices cost, weigh and draw against the caps."""
    words = {True: say("within"), False: say("beyond"), None: say(NOT_KNOWN)}
    return table_of(
        assessment.caps,
        (
            Field(
                head=say("cap, which decides no verdict"),
                cell=lambda cap: say(cap.merit),
            ),
            Field(head=say("at most"), cell=lambda cap: cap.cap),
            Field(head=say("device"), cell=lambda cap: cap.device),
            Field(head=say("given"), cell=lambda cap: cap.given or say("not given")),
            Field(
                head=say("against it"),
                cell=lambda cap: Cell(
                    text=words[cap.is_within], strong=cap.is_within is False
                ),
            ),
        ),
        name="caps",
        caption=say("Price, mass and power against their caps; they decide no verdict"),
    )


def _left_out(settings: Settings) -> Words:
    """Say that sources were left out, where they were."""
    if not settings.only:
        return ()
    only = say(", ").join(map(key_title, settings.only))
    text = say(
        "Only these sources are counted: {only}. All other lines "
        "are set to zero in this run, so this is not the budget of "
        "the whole device. ",
        only=only,
    )
    return (Run(text=text, strong=True),)


def _margin(budget: Budget, assessment: Assessment | None) -> Words:
    """Return by how much limits are held or exceeded, and what errors are."""
    basis = _basis(budget.settings, assessment)
    if assessment is None:
        counted = capital(error_reference(budget.settings))
        left = say("No requirement was given: this is what the calibration leaves.")
        return (say("{left} {counted}.", left=left, counted=counted),)
    unknown = [sensor.sensor for sensor in assessment.sensors if sensor.nothing_known]
    judged = assessment.judged
    said = say(
        "Nothing is known of the {unknown}: the data sheet gives "
        "no error line, and a 0 says just that. ",
        unknown=say(" and ").join(map(say, unknown)),
    )
    nothing: Words = (Run(text=said, strong=True),) if unknown else ()
    if not judged:
        return (*nothing, basis)
    total = len(judged)
    outcomes = [assessment.outcome(row) for row in judged]
    beyond, unsure = outcomes.count("does not conform"), outcomes.count("open")
    worst = max(row.utilisation for row in judged)
    if beyond:
        found = say(
            "{beyond} of {total} required outputs exceed their limits, the worst ",
            beyond=beyond,
            total=total,
        )
        found += say("at {worst} of its limit", worst=print_utilisation(worst))
    elif unsure:
        found = say(
            "{unsure} of {total} required outputs are so near their "
            "limits that their intervals do not tell on which side",
            unsure=unsure,
            total=total,
        )
    elif open_ones := len(assessment.open_rows):
        found = say(
            "{within} of {total} required outputs are within their limits; {open_ones} "
            "cannot be decided, as lines are missing",
            within=len(assessment.outputs) - open_ones,
            total=len(assessment.outputs),
            open_ones=open_ones,
        )
    else:
        found = say(
            "Each of the {total} required outputs, taken alone, stays", total=total
        )
        if total == 1:
            found = say("The required output stays")
        found += say(" within its limit")
        if 1.0 - worst >= SPARE:
            spare = print_decimals(100.0 * (1.0 - worst), 1)
            found += say(", with {spare} % of the nearest one to spare", spare=spare)
    for template in _provisos(assessment):
        found = say(template, found=f"{found[:1].lower()}{found[1:]}")
    return (*nothing, say("{found}. ", found=found), _jointly(assessment), basis)


def _provisos(assessment: Assessment) -> Iterator[str]:
    """Yield what the numbers of a summary are at, as templates around it."""
    sensors = assessment.sensors
    if assessment.chance is not None:
        yield term("At the medians of predicted lines: {found}")
    if any(one.standing.misses for one in sensors):
        yield term("On what is given: {found}")
    if any(one.standing.saturates for one in sensors):
        yield term("Of sensors that read enough: {found}")
    if any(one.is_open_by_reading for one in sensors):
        yield term("As the values are read here: {found}")


def _jointly(assessment: Assessment) -> str:
    """State the conformance probability of all together (JCGM 106:2012, clause 7)."""
    if assessment.conformance is None:
        return ""
    total = len(assessment.judged)
    what = (
        say("It conforms")
        if total == 1
        else say("All {total} conform together", total=total)
    )
    most = any(map(_is_at_most, assessment.sensors))
    said = say(
        "{what} with a probability of at the most {probability} %. "
        if most
        else "{what} with a probability of {probability} %. ",
        what=what,
        probability=(print_most if most else print_probability)(assessment.conformance),
    )
    if assessment.together is not None:
        said += say(
            "They are to be kept together with {needed} %. ",
            needed=print_coverage(assessment.together),
        )
    return said


def _is_at_most(sensor: SensorAssessment) -> bool:
    """Say whether its conformance is that or less, as something is not known."""
    missing = sensor.expected_missing or sensor.not_estimated
    return bool(missing) or sensor.standing.misses


def _utilisation_lines(
    sensor: SensorAssessment, worst: OutputAssessment, *, is_joint: bool
) -> Iterator[Words]:
    """Say how much of the limits is used, and by which output.

    The utilisation of limits that are to be kept together is that of all of them; the
    part that the worst output uses is then of its own limit alone.
    """
    if is_joint:
        t = sensor.utilisation
        used = Number(text=print_utilisation(t), exact=t)
        used = bound_number(used, lower_bound=_is_at_most(sensor))
        yield say_words("Its limits, kept together: {used} used.", used=value(used))
    limited = as_limited(worst)
    yield say_words(
        "Worst output: {outputs}, largest error {error}, limit {limit}: {used} of its "
        "own limit."
        if is_joint
        else "Worst output: {outputs}, largest error {error}, limit {limit}: {used} of "
        "the limit.",
        outputs=join_outputs(sensor.worst_outputs),
        error=value(largest_error(limited), limited.output.unit),
        limit=worst.printed_limit,
        used=value(used_part(worst)),
    )
    if worst.by_monte_carlo:
        yield (say("By Monte Carlo: the law is not sure enough there."),)


def _verdict_card(
    budget: Budget,
    sensor: SensorAssessment,
    worst: OutputAssessment,
    *,
    is_joint: bool,
) -> Card:
    """Say of a sensor whether it meets, by which output, and because of what."""
    missing = say(", ").join(
        say(MISSING.get(line.quantity, source_title(line)))
        for line in sensor.expected_missing
    )
    lines: list[Words] = []
    if sensor.nothing_known:
        lines.append(
            (say("Nothing is known of it: {missing} are not given.", missing=missing),)
        )
        return Card(
            title=say(
                "{sensor}: {verdicts}",
                sensor=capital(key_title(sensor.sensor)),
                verdicts=say(VERDICTS[sensor.verdict]),
            ),
            lines=tuple(lines),
        )
    reasons = [
        say(
            "the test does not estimate {parameters}, which is limited",
            parameters=parameters,
        )
        for parameters in by_group(sensor.not_estimated)
    ]
    if reasons:
        lines.append(
            (say("It would meet, but {reasons}.", reasons=say(" and ").join(reasons)),)
        )
    if sensor.is_open_by_reading and sensor.readings is not None:
        said = verdict_line(sensor.readings)
        lines.append((say("What its data sheet means is open: it {said}.", said=said),))
    elif sensor.verdict == "undecided":
        low, high = (print_utilisation(end) for end in sensor.utilisation_interval)
        text = say(
            "It uses {low} to {high} of the limit: on which side is not decided.",
            low=low,
            high=high,
        )
        lines.append((text,))
    lines += [
        (Run(text=say("{said}.", said=capital(text)), strong=True),)
        for text in deciding_lines(sensor.standing, most=ON_A_CARD)
    ]
    if sensor.doubt is not None:
        said = doubt_sentence(sensor.doubt, of=sensor.sensor)
        low, high = (print_utilisation(end) for end in sensor.doubt.utilisation_90)
        lines.append((Run(text=say("{said}.", said=capital(said)), strong=True),))
        lines.append(
            (
                say(
                    "It uses {low} to {high} of the limit, 90 % over predicted lines.",
                    low=low,
                    high=high,
                ),
            )
        )
    lines += _utilisation_lines(sensor, worst, is_joint=is_joint)
    if sensor.conformance is not None:
        is_open = _is_at_most(sensor)
        used = (print_most if is_open else print_probability)(sensor.conformance)
        lines.append(
            say_words(
                "Conformance probability, all its limits together: at the most {used}."
                if is_open
                else "Conformance probability, all its limits together: {used}.",
                used=Run(text=f"{used} %", exact=sensor.conformance.value),
            )
        )
    because = of_the_variance(
        [
            (source_title(part.source, of=sensor.sensor), part.share)
            for part in budget.output(sensor.worst_output).contributions
        ]
    )
    at = "" if sensor.doubt is None else say(", at the medians")
    text = say("Because: {because} of that output{at}.", because=because, at=at)
    if missing and sensor.verdict != "undecidable":
        text += say(" Not given: {missing}.", missing=missing)
    lines.append((text,))
    if beside := caution_texts(sensor.standing, most=ON_A_CARD):
        lines.append((f"{capital(say('; ').join(beside))}.",))
    return Card(
        title=say(
            "{sensor}: {verdicts}",
            sensor=capital(key_title(sensor.sensor)),
            verdicts=say(VERDICTS[sensor.verdict]),
        ),
        lines=tuple(lines),
    )


def _group_card(group: GroupTable) -> Card:
    """Say how large U of a group is, on which axis, and the contributions to it."""
    coverage = print_coverage(group.coverage)
    widest = group.widest
    same = len({row.expanded.text for row in group.rows}) == 1
    where = say("every axis") if same else say("axis {axis}", axis=widest.axis)
    first: Words = (f"U{coverage} ", value(widest.expanded, group.unit))
    if widest.mean.text not in {"0", UNKNOWN} and float(widest.mean.text) != 0.0:
        first += (say(", mean "), value(widest.mean, group.unit))
    contributions = of_the_variance(
        [(row.title, row.share.exact) for row in group.sources]
    )
    lines: list[Words] = [(*first, say(" ({where})", where=where)), (contributions,)]
    if group.gaps:
        lines.append((say("{gaps}.", gaps=group.gaps),))
    refused = [row.axis for row in group.rows if row.check not in {"", "agrees"}]
    if refused:
        lines.append(
            (
                say(
                    "In doubt: the law is not confirmed on {refused}.",
                    refused=say(", ").join(refused),
                ),
            )
        )
    return Card(title=capital(group.title), lines=tuple(lines))


def _basis(settings: Settings, assessment: Assessment | None) -> str:
    """Say at which coverage errors are given, and from what they are counted."""
    coverage = print_coverage(settings.coverage)
    rows = () if assessment is None else assessment.outputs
    return say(
        "Errors at the probability that a limit names, else at {coverage} % coverage; "
        "{error_references}."
        if any(row.coverage is not None for row in rows)
        else "Errors at {coverage} % coverage; {error_references}.",
        coverage=coverage,
        error_references=error_reference(settings),
    )


SIGMAS = ("1 sigma", "2 sigma", "3 sigma", "rms", "typical")
LARGEST = 5  # as many as a reader keeps in mind


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What a source makes of the variance of one group, or of an error on a mission."""

    share: Number
    group: str
    is_on_mission: bool = False
    u: Number  # of the source alone, on the axis where it is largest
    unit: str


@dataclass(frozen=True, kw_only=True)
class LargestContribution:
    """One source, and what it makes of every group where it counts."""

    title: str
    printed: str  # the line of the data sheet; '' where it has none
    effects: tuple[Effect, ...]


def rank_contributions(
    groups: Sequence[GroupTable],
    devices: Sequence[Device],
    procedure: Procedure,
    assessment: Assessment | None,
    carried: Budget | None = None,
) -> tuple[LargestContribution, ...]:
    """Return the largest contributions, each with what it makes of every group.

    Ranked by the largest share of a group's variance; with a requirement by that share
    of the group's utilisation, those of groups beyond their limits before all others.
    Where a budget carried to a mission is limited, of what is limited alone.
    """
    on_mission = [] if carried is None else list(_limited(carried))
    weight = _weights(groups, assessment)
    given = given_lines(sensors_of(devices), procedure)
    effects: dict[tuple[str, Name], list[tuple[tuple[bool, float], Effect]]] = {}
    for one in on_mission:
        row, used = as_limited(one), one.utilisation
        for part in carried.output(row.output.name).contributions if carried else ():
            if part.share < SMALL_SHARE:
                continue
            effect = Effect(
                share=Number(text=print_share(part.share), exact=part.share),
                group=key_title(row.output.name),
                is_on_mission=True,
                u=round_u(part.standard_uncertainty, row.output),
                unit=row.output.unit,
            )
            order = (settle(used) > 1.0, used * part.share)
            owner = part.source.owner or MISSION
            effects.setdefault((owner, part.source), []).append((order, effect))
    for group in groups:
        used = weight[group.title]
        if on_mission and not used:
            continue
        for source in group.sources:
            if source.share.exact < SMALL_SHARE:
                continue
            effect = Effect(
                share=source.share,
                group=group.title,
                u=source.cells[first_largest([c.u.exact for c in source.cells])].u,
                unit=group.unit,
            )
            order = (settle(used) > 1.0, used * source.share.exact)
            owner = source.source.owner or group.sensor
            effects.setdefault((owner, source.source), []).append((order, effect))
    contributions = list(effects.items())
    ranked = _from_largest(
        [max(order for order, _ in found) for _, found in contributions]
    )
    return tuple(
        LargestContribution(
            title=beside(say(owner), source_title(source)),
            printed=_as_meant(given[source]) if source in given else "",
            effects=tuple(
                found[k][1] for k in _from_largest([order for order, _ in found])
            ),
        )
        for (owner, source), found in (contributions[k] for k in ranked[:LARGEST])
    )


def _limited(carried: Budget) -> Iterator[OutputAssessment]:
    """Yield of each quantity that is limited on a mission what uses most of its limit.

    Nothing of what is only rounding.
    """
    found: dict[Name, list[OutputAssessment]] = {}
    for row in carried.assessment.outputs if carried.assessment else ():
        name = row.output.name
        if name.owner == MISSION and carried.output(name).is_resolved:
            found.setdefault(name.group, []).append(row)
    for rows in found.values():
        yield rows[first_largest([row.utilisation for row in rows])]


def _from_largest(orders: Sequence[tuple[bool, float]]) -> list[int]:
    """Return places, those beyond a limit first, then from the largest weight down."""
    places: list[int] = []
    for is_beyond in (True, False):
        own = [k for k, (beyond, _) in enumerate(orders) if beyond == is_beyond]
        places += [own[k] for k in from_largest([orders[k][1] for k in own])]
    return places


def _weights(
    groups: Sequence[GroupTable], assessment: Assessment | None
) -> dict[str, float]:
    """Return the utilisation of each group, or 1 where nothing is required of any."""
    idle = 1.0 if assessment is None else 0.0
    weight = dict.fromkeys((group.title for group in groups), idle)
    for required in assessment.outputs if assessment else ():
        title = key_title(required.output.name.group)
        if title in weight:  # not those of a mission
            weight[title] = max(weight[title], required.utilisation)
    return weight


def _as_meant(line: ErrorLine) -> str:
    """'0.06 deg/h, 3 sigma': a value with its meaning, where not 1 sigma.

    With its distribution, where that is not the one that the meaning says already.
    """
    words = [line.printed]
    if line.meaning != "1 sigma":
        words.append(say(line.meaning))
    if line.definition not in {"", "sigma"}:
        words.append(say(line.definition.replace("_", " ")))
    usual = "normal" if line.meaning in SIGMAS else "uniform"
    words += [
        say(name)
        for name in dict.fromkeys(d.name for d in line.distributions)
        if name != usual
    ]
    return say(", ").join(words)
