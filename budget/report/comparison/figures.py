"""Figures of a comparison: how far devices are from the limit, where, at what cost."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from budget.language import counted, key_title, say, term, words
from budget.names import time_text
from budget.report.comparison.tables import merit_points, what_is_judged
from budget.report.figures.rows import (
    Bar,
    Chart,
    Dot,
    Group,
    Head,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import (
    BLUE,
    INCH,
    INK,
    MUTED,
    PAPER,
    WIDE,
    WIDTH,
    as_picture,
    fits,
    house_style,
    log_ticks,
    plane,
    write,
)
from budget.report.tables import (
    AT_LEAST,
    as_limited,
    largest_error,
    print_given,
    print_utilisation,
    used_part,
)
from budget.report.wording import capital
from budget.studies.figures_of_merit import MERITS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.report.blocks import Table as DataTable
    from budget.report.comparison.tables import Ranking
    from budget.report.comparison.tables import Row as Device
    from budget.report.figures.rows import Mark
    from budget.results import OutputAssessment

SHOWN = 40  # devices in a figure, the best ones; all are in the tables
DOTS = "..."
MARK = " *"  # behind the name of a device that lacks a line
NAME, LONG_NAME = 22, 32  # characters of a name that fit beside a narrow, a wide figure
LEAST = 1e-4  # utilisation where a bar ends at the latest [1]
OPEN = ("undecidable", "predicted")  # verdicts that wait for a line
SURE = ("meets", "fails")  # verdicts whose bars and points are full
# Opacities of the one hue; up to 0.8 ink can be read on it (4.5:1) in light and dark.
PALEST, UP_TO_LIMIT, BEYOND, DARKEST = 0.06, 0.40, 0.60, 0.80
DARKEST_AT = 2.0  # utilisation with the darkest hue [1]
STEPS = 44  # of the hue on its scale, which goes on for a tenth beyond the darkest
ROOM = 5  # characters that a cell holds
MOST_PER_CENT = 999.5  # beyond, a cell says >999
BOTH = 2  # devices that are all there are
SHORT = {
    "scale_factor": term("SF"),
    "mounting_angle": term("angle"),
    "bias": term("bias"),
}
NAMED = 3  # devices in a title
LEAST_COSTS = 2  # different ones, below which a scatter shows nothing


def margin_chart(table: Ranking, name: str) -> Chart:
    """Show how far each device is from its limit: bars that start at the limit.

    The ranking has the data.
    """
    rows = table.rows[:SHOWN]
    parts = [max(row.of.utilisation, LEAST) for row in rows]
    worst = [row.of.at_worst or 0.0 for row in rows if row.of.lower_bound]
    ranges = [row.of.doubt.utilisation_90 for row in rows if row.of.doubt]
    reached = [max(end, LEAST) for ends in ranges for end in ends]
    scale = Scale(
        low=100.0 * min(0.5, *parts, *reached) / 1.3,
        high=100.0 * max(2.0, *parts, *worst, *reached) * 1.3,
        kind="log",
        lines=((100.0, say("limit")),),
        label=say("largest error [% of the limit]"),
    )
    group = Group(rows=tuple(_margin_row(row, scale.high) for row in rows))
    return Chart(
        name=name,
        title=margin_title(table),
        sides=(Side(panels=(Panel(scale=scale, groups=(group,)),)),),
        lead=say("Largest error in per cent of the limit: "),
        caption=(
            say(
                "Bars start at the limit: to the left is what is left of "
                "it. Hollow: undecided. "
                "{hollow}{explain_mark}{more_devices}",
                hollow=say(HOLLOW[rests_on_predictions(table)]),
                explain_mark=explain_mark(table),
                more_devices=more_devices(table),
            )
        ),
        flush="left",
        pitch=15.0,
    )


# What a bar of a device that lacks a line shows; where lines are predicted.
HOLLOW = {
    False: (
        term(
            "A range: undecidable because an expected line is not given, from now "
            "to at worst; an arrow: at worst is not known."
        )
    ),
    True: (
        term(
            "Hollow with a range: at the medians of predicted lines, and 90 % "
            "over what they may be."
        )
    ),
}


def rests_on_predictions(table: Ranking) -> bool:
    """Whether a verdict in it rests on predicted lines."""
    return any(row.of.doubt is not None for row in table.rows)


def margin_title(table: Ranking) -> str:
    """State the finding: how many meet, and the best of those that can be decided."""
    sensor = table.subject
    meets = [row for row in table.rows if row.of.verdict == "meets"]
    on_conditions = [row for row in table.rows if row.of.verdict == "meets_if"]
    decided = [row for row in table.rows if row.of.verdict not in OPEN]
    lacking = len(table.rows) - len(decided)
    number = say(
        "{meets} of {rows}", meets=len(meets) or say("None"), rows=len(table.rows)
    )
    why = say("cannot be decided, lines are missing")
    if rests_on_predictions(table):
        why = say("by predicted lines")
    if not decided:
        return say(
            "{sensor}: {number} can be decided, lines are missing",
            sensor=what_is_judged(sensor),
            number=number,
        )
    best = table.best or min(decided, key=lambda row: row.of.utilisation)
    named = say(
        "{device} at {utilisation} of the limit",
        device=best.device,
        utilisation=print_utilisation(best.of.utilisation),
    )
    lack = say("; {lacking} {why}", lacking=lacking, why=why) if lacking else ""
    if on_conditions:
        return say(
            "{sensor}: {number} without conditions, {more} on conditions, the best is "
            "{named}{lack}",
            sensor=sensor,
            number=number,
            more=len(on_conditions),
            named=named,
            lack=lack,
        )
    if meets:
        return counted(
            len(meets),
            "{sensor}: {number} meets, the best is {named}{lack}",
            "{sensor}: {number} meet, the best is {named}{lack}",
            sensor=sensor,
            number=number,
            named=named,
            lack=lack,
        )
    least = (
        say("the best that can be decided") if lacking else say("the least used limit")
    )
    return say(
        "{sensor}: {number} meets; {least} is {named}{lack}",
        sensor=what_is_judged(sensor),
        number=number,
        least=least,
        named=named,
        lack=lack,
    )


def _margin_row(row: Device, end: float) -> Row:
    """Return a bar from the limit; its fill and a word say the verdict."""
    x, ink = 100.0 * max(row.of.utilisation, LEAST), BLUE
    if row.of.utilisation > 1.0:
        ink = INK
    at_worst = (
        say("; at worst {at_worst}", at_worst=row.at_worst) if row.at_worst else ""
    )
    start, height = 100.0, 9.3
    marks: list[Mark] = []
    if row.of.verdict == "undecidable":  # not a margin: somewhere from here on
        worst = row.of.at_worst
        start = end if worst is None else max(100.0 * worst, x)
        height = 3.9
        shape = ">" if worst is None else "|"
        marks.append(Dot(at=start, shape=shape, fill=MUTED, edge=MUTED))
    marks.append(
        Bar(
            start=start,
            end=x,
            colour=ink if row.of.verdict in SURE else "none",
            edge=ink,
            edge_width=0.9,
            height=height,
            tip=say(
                "{device}: {verdict}, {utilisation} % of the limit, worst "
                "{worst_output}, limited by {limiting_source}{at_worst}",
                device=row.device,
                verdict=row.verdict,
                utilisation=row.utilisation,
                worst_output=row.worst_output,
                limiting_source=row.limiting_source,
                at_worst=at_worst,
            ),
        )
    )
    low, high = (100.0 * max(end, LEAST) for end in row.of.range)
    if high > low:
        marks.append(Stroke(start=low, end=high, width=2.2))
    return Row(
        label=mark_name(row, NAME),
        marks=tuple(marks),
        beside=(f"{row.utilisation} {row.verdict}",),
        strong=row.of.verdict == "meets",
        said=say(
            "{device} {utilisation} %, {verdict}{at_worst}",
            device=row.device,
            utilisation=row.utilisation,
            verdict=row.verdict,
            at_worst=at_worst.replace(";", ","),
        ),
    )


def map_chart(table: Ranking, name: str, data: DataTable) -> Chart:
    """Show devices by outputs, best first: one hue, a step and a frame at the limit."""
    rows = table.rows[:SHOWN]
    outputs = rows[0].of.outputs
    cells = Panel(
        scale=Scale(low=0.0, high=float(len(outputs)), ticks=()),
        groups=(Group(rows=tuple(map(_map_row, rows))),),
    )
    width = 1.1 * DARKEST_AT / STEPS
    hues = tuple(
        Bar(
            start=step * width,
            end=(step + 1) * width,
            colour=BLUE,
            edge="none",
            opacity=_opacity((step + 0.5) * width),
        )
        for step in range(STEPS)
    )
    scale = Panel(
        scale=Scale(
            low=0.0,
            high=STEPS * width,
            ticks=(
                (0.0, "0"),
                (1.0, say("limit")),
                (DARKEST_AT, say("200 % and more")),
            ),
        ),
        groups=(Group(rows=(Row(label="", marks=hues),)),),
    )
    return Chart(
        name=name,
        title=map_title(table),
        sides=(Side(panels=(cells, scale)),),
        lead=(
            say(
                "Largest error of each output in per cent of its limit; the worst "
                "of each device: "
            )
        ),
        caption=(
            say(
                "Largest error in % of the limit, devices by outputs, best "
                "first; framed and in bold: beyond the "
                "limit.{explain_mark}{more_devices}",
                explain_mark=explain_mark(table),
                more_devices=more_devices(table),
            )
        ),
        heads=tuple(_output_heads([output.output.name for output in outputs])),
        pitch=16.0,
        data=data,
        width=WIDE,
    )


def map_title(table: Ranking) -> str:
    """State the finding: which output is the tightest for most devices."""
    # Of what is only known to be this or more, nobody knows what is the tightest.
    rows = [row for row in table.rows if not row.of.lower_bound]
    if not rows:
        return say(
            "{subject}: no device gives all lines, each can be worse",
            subject=table.subject,
        )
    worst = [output_group(row) for row in rows]
    first = max(dict.fromkeys(worst), key=worst.count)
    number = worst.count(first)
    whole = len(worst)
    lack = len(table.rows) - whole
    but = (
        counted(
            lack, "; {lack} more lacks lines", "; {lack} more lack lines", lack=lack
        )
        if lack
        else ""
    )
    of = say("{number} of {whole} devices", number=number, whole=whole)
    if number == whole:
        of = (
            say("both devices")
            if whole == BOTH
            else say("all {whole} devices", whole=whole)
        )
    if whole == 1:
        of = say("the only device") + (say(" that gives all lines") if lack else "")
    return say(
        "{subject}: the {first} is the tightest for {of}{but}",
        subject=table.subject,
        first=first,
        of=of,
        but=but,
    )


def output_group(row: Device) -> str:
    """Name the parameter whose output is the tightest of a device: 'bias'."""
    return words(row.of.worst_output.quantity)


def _map_row(row: Device) -> Row:
    """Return the cells of one device; each has its tooltip."""
    return Row(
        label=mark_name(row, LONG_NAME),
        marks=tuple(
            Bar(
                start=x + 0.02,
                end=x + 0.98,
                colour=BLUE,
                edge="none",
                opacity=PALEST if output.is_unknown else _opacity(output.utilisation),
                height=15.0,
                is_framed=not output.is_within,
                text=_cell(output),
                strong=not output.is_within,
                tip=say(
                    "{device}, {name}: {largest_error} {unit} of "
                    "{printed_limit}, {used_part} of the limit",
                    device=row.device,
                    name=key_title(output.output.name),
                    largest_error=largest_error(as_limited(output)).text,
                    unit=as_limited(output).output.unit,
                    printed_limit=output.printed_limit,
                    used_part=used_part(output).text,
                ),
            )
            for x, output in enumerate(row.of.outputs)
        ),
        said=say(
            "{device} {utilisation} % ({worst_output})",
            device=row.device,
            utilisation=row.utilisation,
            worst_output=row.worst_output,
        ),
    )


def _output_heads(names: list[Name]) -> Iterator[Head]:
    """Yield the axes above the columns, and their parameters above those."""
    if any(name.time is not None for name in names):
        yield from _mission_heads(names)
        return
    for place, name in enumerate(names):
        yield Head(at=place + 0.5, text=name.axis, colour=MUTED)
    for parameter, own in groupby(enumerate(names), key=lambda pair: pair[1].quantity):
        places = [place for place, _ in own]
        title = (
            words(parameter)
            if len(places) > BOTH
            else say(SHORT.get(parameter, "angle"))
        )
        yield Head(at=(places[0] + places[-1] + 1) / 2.0, text=title, level=1)


def _mission_heads(names: Sequence[Name]) -> Iterator[Head]:
    """Yield times above the columns, above those axes, and quantities at the top."""
    titles = [
        (
            words(name.quantity),
            say(name.axis),
            say("after {time}", time=time_text(name.time or 0.0)),
        )
        for name in names
    ]
    for level, depth in enumerate((3, 2, 1)):
        for title, own in groupby(enumerate(titles), key=lambda one: one[1][:depth]):
            places = [place for place, _ in own]
            yield Head(
                at=(places[0] + places[-1] + 1) / 2.0,
                text=title[-1],
                level=level,
                colour=MUTED if level == 0 else INK,
            )


def _opacity(part: float) -> float:
    """Return the opacity of the hue: it steps up at the limit."""
    if part <= 1.0:
        return PALEST + (UP_TO_LIMIT - PALEST) * part
    share = min((part - 1.0) / (DARKEST_AT - 1.0), 1.0)
    return BEYOND + (DARKEST - BEYOND) * share


def _cell(output: OutputAssessment) -> str:
    """Print a part of a limit as everywhere, as far as a cell has room for it."""
    if 100.0 * output.utilisation >= MOST_PER_CENT:
        return ">999"
    text = used_part(output).text.removesuffix(" %").replace(" ", "")
    return text if len(text) <= ROOM or text[:1] == AT_LEAST else "<0.1"


def front_picture(table: Ranking, merit: str, name: str, data: DataTable) -> Picture:
    """Return the part of the limit against a cost; each point has its tooltip."""
    points = merit_points(table, merit)
    said = say("; ").join(
        say(
            "{device} {amount} {unit}, {utilisation} %",
            device=row.device,
            amount=print_given(amount.value),
            unit=amount.unit,
            utilisation=row.utilisation,
        )
        for row, amount in points
    )
    title = pareto_title(table, merit)
    return as_picture(
        pareto_scatter(table, merit),
        name=name,
        title=title,
        alt=say(
            "{title}. {merit} and part of the limit: {said}.",
            title=title,
            merit=capital(say(merit)),
            said=said,
        ),
        tips={
            f"tip-{place}": say(
                "{device}: {amount} {unit}, {utilisation} % of the limit, {verdict}",
                device=row.device,
                amount=print_given(amount.value),
                unit=amount.unit,
                utilisation=row.utilisation,
                verdict=row.verdict,
            )
            for place, (row, amount) in enumerate(points)
        },
        caption=(
            say(
                "Lower left is better. Joined: no other device is better "
                "in one and as good in the other. Hollow: undecided or "
                "undecidable; a line up from a point: what lacks an "
                "expected line is there or above, up to at worst, and "
                "beats nobody. Only devices whose {merit} is "
                "known.{explain_mark}",
                merit=say(merit),
                explain_mark=explain_mark(table),
            )
        ),
        data=data,
    )


def no_front(table: Ranking, merit: str) -> str:
    """Say why a front would show nothing; '' where it shows something."""
    points = merit_points(table, merit)
    if not points:
        return say("no device gives one that can be compared")
    if len(points) == 1:
        return say(
            "only {device} gives one that can be compared", device=points[0][0].device
        )
    if len({amount.value for _, amount in points}) >= LEAST_COSTS:
        return ""
    amount = points[0][1]
    return say(
        "the {points} devices that give one have the same, {amount} {unit}",
        points=len(points),
        amount=print_given(amount.value),
        unit=amount.unit,
    )


def no_fronts(table: Ranking) -> str:
    """Say in a sentence which fronts are not drawn, and why; '' where all are."""
    reasons = {merit: no_front(table, merit) for merit in MERITS}
    missing = [merit for merit in MERITS if reasons[merit]]
    if not missing:
        return ""
    if not any(merit_points(table, merit) for merit in MERITS):
        return say(
            "No device gives a price, a mass or a power that can be compared: there is "
            "no front to draw."
        )
    said = say("; ").join(
        say("{merit}: {reasons}", merit=say(merit), reasons=reasons[merit])
        for merit in missing
    )
    return say(
        "No front is drawn where it would show nothing. {said}.", said=capital(said)
    )


@house_style()
def pareto_scatter(table: Ranking, merit: str) -> Figure:
    """Draw the part of the limit against a cost; the front is joined, the rest grey."""
    points = merit_points(table, merit)
    figure, axes = plane(
        pareto_title(table, merit),
        f"{say(merit)} [{points[0][1].unit}]",
        say("largest error [% of the limit]"),
        220.0,
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    costs = [amount.value for _, amount in points]
    parts = [max(row.of.utilisation, LEAST) for row, _ in points]
    axes.set_xlim(min(costs) / 1.6, max(costs) * 2.2)
    worst = [row.of.at_worst or 0.0 for row, _ in points if row.of.lower_bound]
    axes.set_ylim(
        100.0 * min(0.5, *parts) / 1.5, 100.0 * max(2.0, *parts, *worst) * 1.5
    )
    log_ticks(axes.xaxis)
    log_ticks(axes.yaxis)
    axes.minorticks_off()
    axes.axhline(100.0, color=INK, linewidth=1.0, zorder=1)
    on_front = [
        (amount.value, 100.0 * max(row.of.utilisation, LEAST))
        for row, amount in points
        if merit in row.of.on_front
    ]
    if on_front:
        axes.plot(*zip(*on_front, strict=True), color=BLUE, linewidth=1.0, zorder=2)
    for place, (row, amount) in enumerate(points):
        point = _draw_point(axes, row, amount.value, is_best=merit in row.of.on_front)
        point.set_gid(f"tip-{place}")
    names: dict[tuple[float, float], list[str]] = {}
    for row, amount in points:
        if merit in row.of.on_front:  # devices in one place share a label
            names.setdefault((amount.value, row.of.utilisation), []).append(
                mark_name(row, NAME)
            )
    for (cost, part), own in names.items():
        name = (
            own[0]
            if len(own) == 1
            else say("{first} and {more} more", first=own[0], more=len(own) - 1)
        )
        room = WIDTH - INCH / figure.dpi * axes.transData.transform((cost, 100.0))[0]
        side = "left" if fits(name, room) else "right"  # it stays in the figure
        shift = (-6.0 if side == "right" else 5.0, 3.0)
        write(
            axes, name, (cost, 100.0 * max(part, LEAST)), shift, ha=side, va="baseline"
        )
    return figure


def pareto_title(table: Ranking, merit: str) -> str:
    """State the finding: which devices nobody beats in both."""
    best = [
        row.device for row, _ in merit_points(table, merit) if merit in row.of.on_front
    ]
    names = list(dict.fromkeys(best))
    if not names:
        return say(
            "{subject}: nobody can say which device is best in {merit} "
            "and error, all lack lines",
            subject=table.subject,
            merit=say(merit),
        )
    more = len(names) - NAMED
    named = say(", ").join(names[:NAMED]) + (
        say(" and {more} more", more=more) if more > 0 else ""
    )
    return counted(
        len(names),
        "{subject}: {named} is not beaten in {merit} and error at once",
        "{subject}: {named} are not beaten in {merit} and error at once",
        subject=table.subject,
        named=named,
        merit=say(merit),
    )


def _draw_point(axes: Axes, row: Device, cost: float, *, is_best: bool) -> Line2D:
    """Draw one device; those on the front have their names beside them."""
    y = 100.0 * max(row.of.utilisation, LEAST)
    sure = row.of.verdict in SURE
    colour = BLUE if is_best else MUTED
    if row.of.lower_bound:
        worst = row.of.at_worst
        top = axes.get_ylim()[1] if worst is None else max(100.0 * worst, y)
        axes.plot([cost, cost], [y, top], color=MUTED, linewidth=0.9, zorder=1)
    (point,) = axes.plot(
        [cost],
        [y],
        marker="o",
        markersize=5.0,
        color=colour if sure else PAPER,
        markeredgecolor=colour,
        linestyle="none",
        zorder=4 if is_best else 3,
    )
    return point


def fit_name(name: str, length: int) -> str:
    """Return a name that fits beside a figure, its end left out where it is long."""
    return name if len(name) <= length else f"{name[: length - len(DOTS)]}{DOTS}"


def mark_name(row: Device, length: int) -> str:
    """Return a device's name that fits, marked where expected lines are missing."""
    if not row.missing:
        return fit_name(row.device, length)
    return fit_name(row.device, length - len(MARK)) + MARK


def explain_mark(table: Ranking) -> str:
    """Say what the mark means, '' where no device of the figure has it."""
    if not any(row.missing for row in table.rows[:SHOWN]):
        return ""
    if any(row.of.lower_bound for row in table.rows[:SHOWN]):
        return say(
            " *: expected lines are missing and count as 0; the error is this or more "
            "(≥)."
        )
    return say(" *: expected lines are missing; others stand in their place.")


def more_devices(table: Ranking) -> str:
    """Say that a figure does not show all devices, '' where it does."""
    whole = len(table.rows)
    return (
        say(" The first {shown} of {whole} devices.", shown=SHOWN, whole=whole)
        if whole > SHOWN
        else ""
    )
