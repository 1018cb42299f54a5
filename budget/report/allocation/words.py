"""An allocation in words: what changes, what stops it, what would help."""

from __future__ import annotations

from math import floor, log10
from typing import TYPE_CHECKING

from budget.language import key_title, say, term, words
from budget.names import by_group
from budget.report.tables import (
    Number,
    bound_number,
    join_outputs,
    print_coverage,
    print_given,
    print_utilisation,
    source_title,
)
from budget.studies.allocation.records import FREE, MEAN
from budget.ties import first_largest, from_largest, settle
from budget.units import DAY, YEAR

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.names import Name
    from budget.studies.allocation.records import (
        Allocation,
        LimitedOutput,
        LineMatch,
        LongerTest,
        Match,
        Recalibration,
        SourceAllotment,
    )

DASH = "-"  # nothing to say
NONE = term("none")  # no value would do
IDLE = term("counts nothing here")
CEILING = term("its ceiling")
DIGITS = 3  # of an allocated value: it is a specification, not a measurement


def print_value(value: float, unit: str) -> str:
    """Print a value with its unit to three digits."""
    return f"{print_given(value, digits=DIGITS)} {unit}"


def print_headroom(row: SourceAllotment) -> tuple[str, str]:
    """Print how far a source may go alone in the unit of its file, and what stops it.

    'none' is what cannot mend an output that fails without it, a dash that there is
    nothing to say.
    """
    room = row.headroom
    if room is None:
        return DASH, say(IDLE) if row.is_idle else DASH
    up_to = print_given(room.value / row.si_per_unit, digits=DIGITS)
    stop = (
        print_stop(room.stopped_by, row.source.owner)
        if room.stopped_by
        else say(CEILING)
    )
    return up_to if room.value else say(NONE), stop


def print_stop(names: Sequence[Name], of: str) -> str:
    """Name outputs, those of that sensor without it; a dash where there are none."""
    return join_outputs([name.within(of) for name in names]) or DASH


def explain_idle(rows: Sequence[SourceAllotment]) -> str:
    """Name the lines that count nothing and say what that means; '' without any."""
    names = say(", ").join(source_title(row.source) for row in rows if row.is_idle)
    if not names:
        return ""
    return say(
        "{idle}: {names} (under this error reference, the other "
        "lines as now, less than 0.1 % of every squared limit even "
        "at its ceiling)",
        idle=say(IDLE),
        names=names,
    )


def print_part(part: float | None) -> str:
    """Print a part of a squared limit in per cent, 0 plainly."""
    if part is None:
        return "-"
    if part == 0.0 or part < 0.5e-3:  # noqa: PLR2004
        return "0" if part <= 1e-12 else "<0.1"  # noqa: PLR2004 - rounding
    return f"{100.0 * part:.{1 if part < 0.1 else 0}f}"  # noqa: PLR2004


def print_used(row: LimitedOutput, *, now: bool) -> str:
    """Print the largest error in per cent of the limit; at its limit it is 100 %."""
    used = row.now if now or row.allowed is None else row.allowed
    text = print_utilisation(used)
    if row.is_binding and not now:
        text = "100 %"
    number = Number(text=text, exact=used)
    return bound_number(number, lower_bound=row.lower_bound).text


def print_floor(row: LimitedOutput) -> str:
    """Print what is held in per cent of the limit."""
    number = Number(text=print_utilisation(row.floor), exact=row.floor)
    return bound_number(number, lower_bound=row.lower_bound).text


def tightest(outputs: Sequence[LimitedOutput]) -> tuple[LimitedOutput, ...]:
    """Return the output of each parameter group that is nearest to its limit."""
    groups: dict[Name, list[LimitedOutput]] = {}
    for row in outputs:
        groups.setdefault(row.output.name.group, []).append(row)
    return tuple(
        rows[first_largest([_used(row) for row in rows])] for rows in groups.values()
    )


def part_title(source: Name, sensor: str) -> str:
    """Name what takes a part of a limit of that sensor."""
    return say("mean error") if source == MEAN else source_title(source, of=sensor)


def remarks(row: SourceAllotment) -> str:
    """Say what is special about a source."""
    found = []
    if row.status != FREE:
        found.append(say(row.status))
    if row.is_idle:
        found.append(say(IDLE))
    elif row.is_spared:
        found.append(say("does not matter") if row.is_minor else say("left as it is"))
    if row.at_ceiling:
        found.append(say("at its ceiling"))
    if row.at_least:
        found.append(say("at its least"))
    if row.is_beyond_market:
        found.append(say("better than any offered"))
    return say(", ").join(found)


def headline(allocation: Allocation) -> str:
    """State the finding in one sentence."""
    if allocation.feasible:
        met = say("{requirement} can be met", requirement=allocation.requirement)
        if allocation.not_allocated:  # 'met' alone would speak for what is not there
            kinds = dict.fromkeys(row.sensor for row in allocation.outputs)
            met += say(" for the {kinds}", kinds=say(" and the ").join(map(say, kinds)))
        if allocation.not_estimated:
            held = say(", ").join(
                key_title(one) for one in by_group(allocation.not_estimated)
            )
            met += say(" but for {held}, not estimated by this test", held=held)
        names = join_outputs([row.output.name for row in allocation.binding])
        if not names:
            return say("{met}; no limit is reached.", met=met)
        return say("{met}; at its limit: {names}.", met=met, names=names)
    names = join_outputs([row.output.name for row in allocation.impossible])
    return say(
        "{requirement} cannot be met: what is held and the "
        "procedure already pass the limits of {names}.",
        requirement=allocation.requirement,
        names=names,
    )


def relaxations(rows: Sequence[LimitedOutput]) -> tuple[str, ...]:
    """Say how far limits that cannot be met must be relaxed, like ones together."""
    groups: dict[tuple[Name, str], list[LimitedOutput]] = {}
    for row in rows:
        key = (row.output.name.group, row.printed_limit)
        groups.setdefault(key, []).append(row)
    return tuple(_relaxation(group) for group in groups.values())


def _relaxation(rows: Sequence[LimitedOutput]) -> str:
    """Say it of outputs with one limit, by the one that needs most."""
    row = rows[first_largest([row.floor for row in rows])]
    scale = row.output.si_per_unit
    needed = print_value(row.floor * row.limit / scale, row.output.unit)
    users = [row.parts[k] for k in from_largest([part.floor for part in row.parts])]
    taken = say(", ").join(
        f"{part_title(part.source, row.sensor)} {print_part(part.floor)} %"
        for part in users[:3]
        if part.floor > 0.01  # noqa: PLR2004 - of the squared limit
    )
    return say(
        "{outputs}: {floor} of the limit {printed_limit} is used "
        "up (of its square: {taken}); relax it to more than "
        "{needed}, or let go what is held",
        outputs=join_outputs([each.output.name for each in rows]),
        floor=print_floor(row),
        printed_limit=row.printed_limit,
        taken=taken,
        needed=needed,
    )


def longer_test_text(test: LongerTest) -> str:
    """Say what a change of the procedure would do."""
    unit = " s" if test.name == "dwell" else ""
    what = say("{sensor}, {goal}: ", sensor=say(test.sensor), goal=say(test.goal))
    if test.needed is not None:
        return say(
            "{what}{name} of {needed:g}{unit} in place of "
            "{now:g}{unit} would meet the limits",
            what=what,
            name=say(test.name),
            needed=test.needed,
            unit=unit,
            now=test.now,
        )
    none = say("dwell")
    if test.name != "dwell":
        none = say("number of {name}", name=say(test.name))
    return say(
        "{what}no {none} up to {tried_to:g}{unit} would do; best "
        "{utilisation} of a limit, at {best:g}{unit}",
        what=what,
        none=none,
        tried_to=test.tried_to,
        unit=unit,
        utilisation=print_utilisation(test.utilisation),
        best=test.best,
    )


def recalibration_text(one: Recalibration, coverage: float) -> str:
    """Say how old a calibration may be."""
    who = say("{sensor}, {goal}: ", sensor=say(one.sensor), goal=say(one.goal))
    used = print_utilisation(one.utilisation)
    if one.is_soon:
        return say(
            "{who}a limit is passed after one day already ({used} of it used)",
            who=who,
            used=used,
        )
    if one.age is None and one.not_given:
        names = say(", ").join(words(name.quantity) for name in one.not_given)
        return say(
            "{who}nobody can tell, as lines are not given: {names}",
            who=who,
            names=names,
        )
    if one.age is None:
        return say(
            "{who}no limit is reached within 30 years ({used} of one used then)",
            who=who,
            used=used,
        )
    latest = say(" at the latest") if one.not_given else ""
    names = say(", ").join(words(name.quantity) for name in one.not_given)
    why = say("; not given: {names}", names=names) if names else ""
    return say(
        "{who}a limit is reached after {age}{latest}, at a "
        "coverage of {coverage} %{why}",
        who=who,
        age=print_time(one.age),
        latest=latest,
        coverage=print_coverage(coverage),
        why=why,
    )


def print_time(seconds: float) -> str:
    """Write a time in days, months or years, two digits rounded down."""
    size, unit = next(
        (size, unit)
        for size, unit in (
            (YEAR, term("years")),
            (YEAR / 12.0, term("months")),
            (DAY, term("days")),
        )
        if seconds >= 2.0 * size or unit == "days"
    )
    number = seconds / size
    step = 10.0 ** (floor(log10(number)) - 1)
    return f"{print_given(floor(settle(number / step)) * step)} {say(unit)}"


def line_match_text(line: LineMatch) -> str:
    """'bias stability x 85 (from its sample_noise)'."""
    title = source_title(line.source)
    if line.ratio is None:
        return f"{title} {words(line.how) or say('not given')}"
    how = say(" ({how})", how=words(line.how)) if line.how else ""
    return f"{title} x {print_given(line.ratio, digits=DIGITS)}{how}"


def match_text(match: Match) -> str:
    """Say of one triad which lines are larger than allowed, and by how much."""
    if match.meets:
        text = say("{device}: meets every line", device=match.device)
    else:
        lines = [row for row in match.lines if row.ratio is None or row.ratio > 1.0]
        within = len(match.lines) - len(lines)
        text = say("{device}: ", device=match.device) + say(", ").join(
            line_match_text(row) for row in lines
        )
        text += say(
            "; {within} of {lines} lines within", within=within, lines=len(match.lines)
        )
    if match.extra:
        text += say(
            "; has besides {extra}",
            extra=say(", ").join(source_title(name) for name in match.extra),
        )
    return text


def _used(row: LimitedOutput) -> float:
    """Return largest error over limit, after the allocation where there is one [1]."""
    return row.now if row.allowed is None else row.allowed
