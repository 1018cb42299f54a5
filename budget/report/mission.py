"""Errors of a mission for people: times, units that one reads, which line dominates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING

from budget.language import beside, key_title, say, term
from budget.names import LENGTHS, Name, time_text
from budget.report.blocks import Cell, Field, table_of
from budget.report.tables import (
    SMALL_SHARE,
    as_limited,
    bound_number,
    largest_error,
    print_coverage,
    print_share,
    round_u,
    round_uncertainty,
    source_title,
    used_part,
)
from budget.report.wording import capital, cell, outcome_words
from budget.results import BY_PREDICTION
from budget.studies.cautions import SMALL
from budget.ties import from_largest, settle
from budget.units import ARCSEC

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.report.blocks import Table
    from budget.report.tables import Number
    from budget.results import (
        Assessment,
        Budget,
        Calibrated,
        Learnt,
        OutputAssessment,
        OutputBudget,
    )

# Units that an error is read in, the first one up to the next [SI].
UNITS = {
    "position": (("m", 1.0), ("km", 1000.0)),
    "velocity": (("m/s", 1.0),),
    "attitude": (("arcsec", ARCSEC), ("arcmin", 60.0 * ARCSEC), ("deg", 3600 * ARCSEC)),
}
HEADING = "heading"
HOUR = 3600.0  # [s]
NAUTICAL_MILE = 1852.0  # [m]
CIRCLES = term(
    "CEP and R95: radii of the circles about the true place that the unit is in with "
    "50 % and with 95 % probability; DRMS: root of the sum of the squared standard "
    "uncertainties north and east. All other numbers are standard uncertainties."
)
OVER = term(
    "All are of the predictive mixture, over what the lines that are not given may be. "
    "It has no variance: a standard uncertainty is half of the interval of 68.3 %, and "
    "shares are those at the medians of these lines."
)


def what_sizes_are(moments: Sequence[AtTime]) -> Iterator[str]:
    """Say what CEP, R95, DRMS and all other numbers of the tables are."""
    yield say(CIRCLES)
    if any(row.interval_by == BY_PREDICTION for at in moments for row in at.rows):
        yield say(OVER)


@dataclass(frozen=True, kw_only=True)
class AtTime:
    """The errors at one time of a mission."""

    time: float  # since it began [s]
    rows: tuple[OutputBudget, ...]

    def row(self, quantity: str, axis: str) -> OutputBudget | None:
        """Return one of them; None where it was not asked for."""
        for row in self.rows:
            if (row.parameter, row.axis) == (quantity, axis):
                return row
        return None

    @property
    def horizontal(self) -> OutputBudget | None:
        """The horizontal error of position."""
        return self.row("position", LENGTHS["position"])

    @property
    def is_lost(self) -> bool:
        """Whether attitude errors are beyond the first order of all these numbers."""
        own = (row for row in self.rows if row.parameter == "attitude")
        return any(row.standard_uncertainty > SMALL for row in own)

    def unit_of(self, quantity: str, axis: str = "") -> tuple[str, float]:
        """Return the unit that all errors like one are read in, and its size.

        Those of a quantity, but heading by itself, which may be a hundred times tilt.
        """
        return unit_for(quantity, self.largest(quantity, axis))

    def largest(self, quantity: str, axis: str = "") -> float:
        """Return the largest size of all errors that are read in one unit [SI]."""
        sizes = (
            max(row.standard_uncertainty, *_radii(row))
            for row in self.rows
            if row.parameter == quantity and (row.axis == HEADING) == (axis == HEADING)
        )
        return max(sizes, default=0.0)


def unit_for(quantity: str, largest: float) -> tuple[str, float]:
    """Return the unit that errors up to one [SI] are read in, and its size [SI]."""
    units = UNITS[quantity]
    fitting = [unit for unit in units if settle(largest / unit[1]) >= 1.0]
    return fitting[-1] if fitting else units[0]


def unit_for_all(quantity: str, sizes: Iterable[float]) -> tuple[str, float]:
    """Return the unit of a column, and its size [SI]: the same at every time.

    That which the smallest of the sizes [SI] is read in: no number has leading zeros.
    """
    return unit_for(quantity, min((one for one in sizes if one > 0.0), default=0.0))


def _radii(row: OutputBudget) -> tuple[float, float]:
    """Return CEP and R95; 0 of what is no length."""
    return (0.0, 0.0) if row.radii is None else (row.radii.cep, row.radii.r95)


def by_time(budget: Budget) -> tuple[AtTime, ...]:
    """Gather the outputs of a mission by their times, rising."""

    def time_of(row: OutputBudget) -> float:
        return row.output.name.time or 0.0

    rows = sorted(budget.outputs, key=time_of)
    return tuple(
        AtTime(time=time, rows=tuple(own)) for time, own in groupby(rows, key=time_of)
    )


def size(
    at: AtTime,
    row: OutputBudget,
    value: float,
    unit_of_all: tuple[str, float] | None = None,
) -> Number:
    """Round a size of an error, in a unit or that which its like have at that time."""
    unit, si_per_unit = unit_of_all or at.unit_of(row.parameter, row.axis)
    output = replace(row.output, unit=unit, si_per_unit=si_per_unit)
    return bound_number(
        round_u(value, output), lower_bound=row.lower_bound, unknown=row.is_unknown
    )


def _sized(
    quantity: str,
    axis: str,
    pick: Callable[[OutputBudget], float],
    unit: tuple[str, float],
) -> Callable[[AtTime], Cell | str]:
    """Return what stands in a column of one error."""

    def found(at: AtTime) -> Cell | str:
        row = at.row(quantity, axis)
        return "" if row is None else cell(size(at, row, pick(row), unit))

    return found


def _u(row: OutputBudget) -> float:
    return row.standard_uncertainty


def _columns(
    moments: Sequence[AtTime],
    quantity: str,
    heads: Iterable[tuple[str, str, Callable[[OutputBudget], float]]],
) -> tuple[Field[AtTime], ...]:
    """Return the columns of axes that are alike, and that of their one unit."""
    heads = tuple(heads)
    like = heads[0][1]
    unit = unit_for_all(quantity, (at.largest(quantity, like) for at in moments))
    return (
        *(
            Field(
                head=head,
                kind="number",
                cell=_sized(quantity, axis, pick, unit),
                optional=True,
            )
            for head, axis, pick in heads
        ),
        Field(
            head="",
            kind="unit",
            cell=lambda at: unit[0] if at.largest(quantity, like) else "",
            optional=True,
        ),
    )


def _after() -> Field[AtTime]:
    return Field(head=say("after"), cell=lambda at: time_text(at.time))


def position_table(moments: Sequence[AtTime]) -> Table:
    """Return the errors of position at every time."""
    plane = LENGTHS["position"]
    heads = (
        ("CEP", plane, lambda row: _radii(row)[0]),
        ("R95", plane, lambda row: _radii(row)[1]),
        ("DRMS", plane, _u),
        *((say(axis), axis, _u) for axis in ("north", "east", "down")),
    )
    return table_of(
        moments,
        (_after(), *_columns(moments, "position", heads)),
        name="mission-position",
        caption=say("Errors of position at each time"),
    )


def motion_table(moments: Sequence[AtTime]) -> Table:
    """Return the errors of velocity and attitude at every time."""
    velocity = (
        (say("velocity CEP"), LENGTHS["velocity"], lambda row: _radii(row)[0]),
        (say("DRMS"), LENGTHS["velocity"], _u),
        (say("down"), "down", _u),
    )
    tilt = ((say(axis), axis, _u) for axis in ("roll", "pitch"))
    return table_of(
        moments,
        (
            _after(),
            *_columns(moments, "velocity", velocity),
            *_columns(moments, "attitude", tilt),
            *_columns(moments, "attitude", [(say(HEADING), HEADING, _u)]),
        ),
        name="mission-motion",
        caption=say("Errors of velocity and attitude at each time"),
    )


def bought_table(budget: Budget, moments: Sequence[AtTime]) -> Table | None:
    """Return the CEP at every time after each calibration; None of one alone."""
    tests = budget.bought
    places = {at.time: place for place, at in enumerate(moments)}
    if not tests or len(tests[0].cep) != len(moments):
        return None

    unit, si_per_unit = unit_for_all(
        "position", (max(own) for own in zip(*(one.cep for one in tests), strict=True))
    )

    def radius(one: Calibrated) -> Callable[[AtTime], Cell | str]:
        """Return what stands in the column of a calibration."""

        def found(at: AtTime) -> Cell | str:
            if at.horizontal is None:
                return ""
            output = replace(at.horizontal.output, unit=unit, si_per_unit=si_per_unit)
            number = round_u(one.cep[places[at.time]], output)
            return cell(
                bound_number(number, lower_bound=one.lower_bound, unknown=False)
            )

        return found

    return table_of(
        moments,
        (
            _after(),
            *(
                Field(head=head, kind="number", cell=radius(one))
                for head, one in zip(
                    (say("uncalibrated"), say("by the maker"), say("by this test")),
                    tests,
                    strict=False,
                )
            ),
            Field(head="", kind="unit", cell=lambda _: unit),
        ),
        name="mission-calibrations",
        caption=say("CEP after each calibration"),
    )


SHOWN = 3  # spans of an aid
NOT_LEARNT = 0.9  # of what was there before, from which on it is not learnt [1]


def learnt_table(budget: Budget) -> Table | None:
    """Return what the filter has found out of the biases; None without one."""
    found = () if budget.filter is None else budget.filter.learnt
    if not found:
        return None
    last = max(one.time for one in found)

    def before(one: Learnt) -> str:
        """Return what was there without aids."""
        return _digits(one.before)

    def left(one: Learnt) -> str:
        """Return what is left of a bias, or that nothing is learnt of it."""
        if one.after > NOT_LEARNT * one.before:
            return say("not learnt")
        return _digits(one.after)

    return table_of(
        [one for one in found if one.time == last],
        (
            Field(head=say("bias"), cell=lambda one: full_title(_bias_of(one))),
            Field(head=say("before"), kind="number", cell=before),
            Field(head=say("after"), kind="number", cell=left),
            Field(head="", kind="unit", cell=lambda one: one.unit),
        ),
        name="filter-learnt",
        caption=say("What the filter has learnt after {time}", time=time_text(last)),
    )


def _digits(x: float) -> str:
    """Write a number to three digits, without an exponent."""
    return f"{float(f'{x:.3g}'):.10g}"


def _bias_of(one: Learnt) -> Name:
    """Return the bias that something is learnt of."""
    return Name("bias", owner=one.sensor, axis=one.axis)


def aids_words(budget: Budget) -> str:
    """Say what is measured on a mission, and when; '' without aids."""
    if budget.filter is None or budget.mission is None:
        return ""
    aids = [
        say(
            "{aid} {spans}",
            aid=key_title(one.name),
            spans=", ".join(
                f"{time_text(begin)} - {time_text(end)}"
                for begin, end in one.spans[:SHOWN]
            )
            + ", ..." * (len(one.spans) > SHOWN),
        )
        for one in budget.mission.aiding
    ]
    return say(
        "Measured besides: {aids}. The filter has {states} states and {updates} "
        "updates; lever arms, delays and tight coupling are left out.",
        aids="; ".join(aids),
        states=str(budget.filter.states),
        updates=str(budget.filter.updates),
    )


WORSE = 2.0  # than straight on, from which on a turn is worth a sentence [1]


def turned_words(budget: Budget) -> str:
    """Say what cancels until the unit turns; '' where a turn shows little of it."""
    found = None if budget.filter is None else budget.filter.turned
    if found is None or found.turned < WORSE * found.straight:
        return ""
    return say(
        "What the filter has not learnt does not show, or cancels, until the unit "
        "turns: had it turned by 180 deg in the first half of the time after the aids, "
        "it would be off by {turned} DRMS after {time}, in place of {straight}.",
        turned=length(found.turned),
        straight=length(found.straight),
        time=time_text(found.time),
    )


def length(size: float) -> str:
    """Print a length in the unit that it is read in."""
    unit, scale = unit_for("position", size)
    return f"{round_uncertainty(size / scale)} {unit}"


def believed_words(budget: Budget) -> str:
    """Say what a filter of its own believes at the end, beside what is true."""
    found = () if budget.filter is None else budget.filter.believed
    own = [
        one for one in found if (one.parameter, one.axis) == ("position", "horizontal")
    ]
    if not own or budget.filter is None or budget.filter.kind == "optimal":
        return ""
    last = max(own, key=lambda one: one.time)
    return say(
        "After {time} the filter believes {believed} {unit} DRMS, and {true} {unit} is "
        "true.",
        time=time_text(last.time),
        believed=_digits(last.standard_uncertainty),
        true=_digits(last.true),
        unit=last.unit,
    )


def believed_table(budget: Budget) -> Table | None:
    """Return what a filter of its own believes beside what is true, time by time."""
    found = () if budget.filter is None else budget.filter.believed
    wanted = (("position", LENGTHS["position"]), ("attitude", HEADING))
    rows = [one for one in found if (one.parameter, one.axis) in wanted]
    if not rows or budget.filter is None or budget.filter.kind == "optimal":
        return None
    return table_of(
        rows,
        (
            Field(head=say("after"), cell=lambda one: time_text(one.time)),
            Field(
                head=say("error"),
                cell=lambda one: key_title(Name(one.parameter, axis=one.axis)),
            ),
            Field(
                head=say("believed"),
                kind="number",
                cell=lambda one: _digits(one.standard_uncertainty),
            ),
            Field(head=say("true"), kind="number", cell=lambda one: _digits(one.true)),
            Field(head="", kind="unit", cell=lambda one: one.unit),
        ),
        name="filter-believed",
        caption=say("What the filter believes, and what is true"),
    )


@dataclass(frozen=True, kw_only=True)
class Blamed:
    """What one source contributes to the horizontal position, time by time."""

    source: Name
    shares: tuple[float, ...]  # of the variance, in the order of the times [1]

    @property
    def title(self) -> str:
        """'gyro bias repeatability'."""
        return full_title(self.source)


def full_title(source: Name) -> str:
    """Name a source with its owner, as it stands among those of all."""
    title = source_title(source)
    return beside(say(source.owner), title) if source.owner else title


def blamed(moments: Sequence[AtTime]) -> tuple[Blamed, ...]:
    """Return sources by their largest share of the horizontal variance at any time."""
    rows = [row for at in moments if (row := at.horizontal) is not None]
    found: dict[Name, list[float]] = {}
    for place, row in enumerate(rows):
        for part in row.contributions:
            shares = found.setdefault(part.source, [0.0] * len(rows))
            shares[place] = part.share if row.is_resolved else 0.0
    sources = [
        Blamed(source=source, shares=tuple(shares)) for source, shares in found.items()
    ]
    order = from_largest([max(one.shares) for one in sources])
    return tuple(sources[k] for k in order)


def contributions_table(moments: Sequence[AtTime]) -> Table:
    """Return who contributes how much to the horizontal position at every time."""
    sources = blamed(moments)
    major = [one for one in sources if max(one.shares) >= SMALL_SHARE]
    minor = [one for one in sources if 0.0 < max(one.shares) < SMALL_SHARE]
    lines = [(one.title, one.shares) for one in major]
    if minor:
        together = tuple(map(sum, zip(*(one.shares for one in minor), strict=True)))
        lines.append((say("{minor} others together", minor=len(minor)), together))

    def share(place: int) -> Callable[[tuple[str, tuple[float, ...]]], Cell]:
        def found(line: tuple[str, tuple[float, ...]]) -> Cell:
            value = line[1][place]
            text = print_share(value).removesuffix(" %")
            return Cell(text=text, exact=value, share=value)

        return found

    times = [at.time for at in moments if at.horizontal is not None]
    return table_of(
        lines,
        (
            Field(head=say("share of the variance [%]"), cell=lambda line: line[0]),
            *(
                Field(head=time_text(time), kind="number", cell=share(place))
                for place, time in enumerate(times)
            ),
        ),
        name="mission-contributions",
        caption=say("Contributions to the horizontal position at each time"),
    )


def leading(moments: Sequence[AtTime]) -> str:
    """Say which source contributes most, and until when: '' of a single time."""
    sources = blamed(moments)
    times = [at.time for at in moments if at.horizontal is not None]
    first: list[tuple[Name, float, float, float]] = []
    for place, time in enumerate(times):
        shares = [one.shares[place] for one in sources]
        if not any(shares):
            continue
        top = sources[from_largest(shares)[0]].source
        share = max(shares)
        if first and first[-1][0] == top:
            first[-1] = (top, first[-1][1], time, share)
        else:
            first.append((top, time, time, share))
    if not first or len(times) == 1:  # which the finding has said
        return ""
    if len(first) == 1:
        source, _, last, share = first[0]
        return say(
            "At every time {source} contributes most, {share} of the variance after "
            "{time}.",
            source=full_title(source),
            share=print_share(share),
            time=time_text(last),
        )
    parts = []
    for source, begun, last, share in first:
        template = (
            say(
                "{source} after {time} ({share})",
                source=full_title(source),
                time=time_text(last),
                share=print_share(share),
            )
            if begun == last
            else say(
                "{source} from {begun} to {time} ({share})",
                source=full_title(source),
                begun=time_text(begun),
                time=time_text(last),
                share=print_share(share),
            )
        )
        parts.append(template)
    return say("Which line contributes most: {parts}.", parts=say("; ").join(parts))


def rate_per_hour(moments: Sequence[AtTime]) -> tuple[AtTime, float] | None:
    """Return CEP over time at 1 h, or at the first later time [nmi/h], else None."""
    for at in moments:
        row = at.horizontal
        if at.time >= HOUR and row is not None and row.radii is not None:
            return at, row.radii.cep / NAUTICAL_MILE / (at.time / HOUR)
    return None


def limits_table(
    usual: float, assessment: Assessment, rows: Sequence[OutputAssessment]
) -> Table:
    """Return each limit on a mission, with its own probability, else the usual one."""

    def used(row: OutputAssessment) -> Cell:
        number = used_part(row)
        return Cell(
            text=number.text.removesuffix(" %"),
            exact=number.exact,
            strong=not row.is_within,
        )

    return table_of(
        rows,
        (
            Field(
                head="",
                cell=lambda row: capital(key_title(row.output.name)),
            ),
            Field(
                head=say("P [%]"),
                kind="number",
                cell=lambda row: print_coverage(
                    usual if row.coverage is None else row.coverage
                ),
            ),
            Field(
                head=say("error"),
                kind="number",
                cell=lambda row: cell(
                    largest_error(as_limited(row)), strong=not row.is_within
                ),
            ),
            Field(head="", kind="unit", cell=lambda row: as_limited(row).output.unit),
            Field(head=say("limit"), cell=lambda row: row.printed_limit),
            Field(head=say("used [%]"), kind="number", cell=used),
            Field(
                head=say("verdict"),
                cell=lambda row: Cell(
                    text=outcome_words(assessment, row), strong=not row.is_within
                ),
            ),
        ),
        name="mission-limits",
        caption=say("Errors of the mission against their limits"),
    )
