"""What tables of a comparison show of devices: rankings, orders, parts of limits."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

from budget.errors import CallError
from budget.known import AT_LEAST, AT_MOST
from budget.language import say, words
from budget.names import MISSION
from budget.report.pages import line
from budget.report.tables import (
    DASH,
    HALF_DIGIT,
    PER_CENT,
    join_outputs,
    print_chance,
    print_doubt,
    print_most,
    print_probability,
    print_three,
    print_utilisation,
    round_value,
    source_title,
)
from budget.results import VERDICTS
from budget.studies.comparison.records import (
    NUMBERED,
    Entrant,
    rank_number,
    ranks,
)
from budget.studies.figures_of_merit import read_amount
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.names import Name
    from budget.results import Condition, Doubt, Probability, Remedy
    from budget.studies.comparison.records import (
        Comparison,
        Entrant,
        MissingLines,
        Pair,
    )
    from budget.studies.figures_of_merit import Amount


MOST_FACTOR = 1000.0  # beyond, a line does not limit anything in any case
SURE = 5e-4  # of a utilisation [1]: half a unit in the third digit


@dataclass(frozen=True, kw_only=True)
class DeviceRow:
    """One sensor of one device, as texts; numbers are in per cent, without the sign."""

    rank: str  # '2', '2=' where it is tied with a neighbour
    device: str
    verdict: str
    utilisation: str
    interval: tuple[str, ...]  # its ends, or one that is both; () by the law
    conformance: str
    worst_output: str  # without the sensor
    limiting_source: str
    factor: str  # '' where the source alone cannot mend it
    missing: str  # number of expected lines that are not given
    at_worst: str  # '198 fails' with the worst of the catalogue in their place
    ask: str  # 'mounting repeatability 0.11': which of them to ask for, its worth
    saturates: str  # 'saturates: gyro z asks ...': its numbers are those of no device
    of: Entrant


@dataclass(frozen=True, kw_only=True)
class Ranking:
    """All devices with one sensor under one procedure."""

    sensor: str
    name: str  # unique in the document: 'gyro-0'
    devices: tuple[Entrant, ...]  # best first
    nothing_known: tuple[str, ...]  # devices with no error line: in no row
    under: str  # the procedure, '' where there is no other
    order: Callable[[DeviceRow], Any] | None = (
        None  # what rows are sorted by; None: the rank
    )

    @cached_property
    def rows(self) -> tuple[DeviceRow, ...]:
        """The devices as texts."""
        return tuple(self._written(self.devices))

    @cached_property
    def decided(self) -> tuple[DeviceRow, ...]:
        """The rows of devices that can be judged."""
        return tuple(row for row in self.rows if _is_decided(row.of))

    @cached_property
    def measured(self) -> tuple[DeviceRow, ...]:
        """Those of them that read what they are asked for: a figure shows these."""
        return tuple(row for row in self.decided if not row.saturates)

    def first(self, most: int) -> list[DeviceRow]:
        """Return the first of these; no more are written than it takes."""
        known = [one for one in self.devices if _is_decided(one)]
        return self._written(known[:most] if self.order is None else known)[:most]

    def _written(self, devices: Sequence[Entrant]) -> list[DeviceRow]:
        """Write rows of devices, in the order that is asked for."""
        places = map(id, self.devices)
        by_place = dict(zip(places, self._ranks, strict=True))
        rows = [_row(one, by_place[id(one)]) for one in devices]
        return rows if self.order is None else sorted(rows, key=self.order)

    @cached_property
    def _ranks(self) -> tuple[str, ...]:
        return ranks(self.devices)

    @property
    def subject(self) -> str:
        """'Gyro', or 'Gyro, Zhao 2019' where there are several procedures."""
        return line("comparison_parts", "subject", table=self)

    @cached_property
    def best(self) -> DeviceRow | None:
        """The best device that meets, if on conditions; None where none does."""
        return next(
            (
                _row(one, rank)
                for one, rank in zip(self.devices, self._ranks, strict=True)
                if rank_of(rank)
            ),
            None,
        )

    @property
    def counts(self) -> dict[str, int]:
        """How many devices there are with each verdict, the best verdict first."""
        found = [one.verdict for one in self.devices]
        found += ["undecidable"] * len(self.nothing_known)
        return {
            verdict: found.count(verdict) for verdict in VERDICTS if verdict in found
        }


def _is_decided(one: Entrant) -> bool:
    """Whether a device can be judged, were it that it is close to a limit."""
    return one.verdict != "undecidable"


@dataclass(frozen=True, kw_only=True)
class Tally:
    """How many devices with a sensor meet, each after what serves it best."""

    sensor: str
    devices: int
    meeting: int  # with conditions and without
    conditional: int


def tallies(comparison: Comparison) -> list[Tally]:
    """Count who meets, sensor by sensor."""
    found = []
    for sensor in comparison.required:
        own = [one for one in comparison.entrants if one.sensor == sensor]
        sure = {one.place for one in own if one.verdict == "meets"}
        meeting = {one.place for one in own if one.verdict in NUMBERED}
        found.append(
            Tally(
                sensor=sensor,
                devices=len({one.place for one in own}),
                meeting=len(meeting),
                conditional=len(meeting - sure),
            )
        )
    return found


@dataclass(frozen=True, kw_only=True)
class Request:
    """What to ask one maker for, of devices that cannot be judged without it."""

    sensor: str
    vendor: str  # '' where no file says
    lines: tuple[Name, ...]  # that which decides first; () for every error line
    names: list[str]  # of the devices
    bounds: tuple[float, float] | None  # of the first line, least and largest [unit]
    unit: str


def requests(comparison: Comparison) -> list[Request]:
    """Return what to ask whom for, makers' requests that are alike gathered."""
    together: dict[Any, list[Entrant]] = {}
    for one in comparison.entrants:
        if not _is_decided(one) and not one.saturates:
            lines = tuple(ask.line for ask in one.asks)
            if not one.is_judged and one.sensor != MISSION:
                lines = ()  # of a sheet that gives none every one is asked for
            elif not lines and one.missing:
                lines = one.missing.lines
            together.setdefault((one.sensor, one.vendor, lines), []).append(one)
    found = [
        Request(
            sensor=sensor,
            vendor=vendor,
            lines=lines,
            names=list(dict.fromkeys(one.name for one in own)),
            **bounds_of([ask for each in own for ask in each.asks[:1]]),
        )
        for (sensor, vendor, lines), own in together.items()
    ]
    order = [*comparison.required]
    return sorted(found, key=lambda one: order.index(one.sensor))


def bounds_of(firsts: Sequence[Condition]) -> dict[str, Any]:
    """Return from where on devices fail by what is asked for first, of all or none."""
    sizes = [one.below / one.si_per_unit for one in firsts if one.below]
    units = {one.unit for one in firsts}
    if not sizes or len(sizes) < len(firsts) or len(units) > 1:
        return {"bounds": None, "unit": ""}
    return {"bounds": (min(sizes), max(sizes)), "unit": units.pop()}


def print_bounds(one: Request) -> str:
    """Print from where on devices fail: '5.53 deg/h/g', or of several a range."""
    if one.bounds is None:
        return ""
    ends = dict.fromkeys(map(print_three, one.bounds))
    return f"{say(' to ').join(ends)} {one.unit}"


def rankings(
    comparison: Comparison, *, order: Callable[[DeviceRow], Any] | None = None
) -> tuple[Ranking, ...]:
    """Return a table for each sensor and procedure, best first or by a column."""
    return tuple(
        Ranking(
            sensor=sensor,
            name=f"{sensor}-{place}",
            devices=tuple(devices),
            nothing_known=tuple(
                one.name
                for one in comparison.nothing_known
                if (one.sensor, one.procedure) == (sensor, procedure)
            ),
            under=procedure if len(comparison.procedures) > 1 else "",
            order=order,
        )
        for place, ((sensor, procedure), devices) in enumerate(comparison.lists.items())
    )


def side_by_side(
    found: Sequence[Ranking], sensor: str
) -> list[tuple[DeviceRow, list[DeviceRow | None]]]:
    """Return the devices with one sensor under all procedures, as under the first.

    None: the procedure leaves the sensor out.
    """
    own = [table for table in found if table.sensor == sensor]
    known = [{row.of.place: row for row in table.rows} for table in own]
    return [
        (row, [rows.get(row.of.place) for rows in known])
        for row in next(table for table in own if table.rows).rows
    ]


def _row(one: Entrant, rank: str) -> DeviceRow:
    """Write one row."""
    utilisation, interval = print_parts(one.utilisation, one.utilisation_interval)
    if one.utilisation.is_bound:
        utilisation = f"{AT_LEAST} {utilisation}"
    beyond = one.saturates
    is_open = one.rests_on_others or beyond
    return DeviceRow(
        rank=rank,
        device=one.name,
        verdict=words(one.verdict) if one.doubt is None else print_doubt(one.doubt),
        utilisation=DASH if beyond else utilisation,
        interval=() if beyond else print_range(one.doubt) if one.doubt else interval,
        conformance=print_conformance(one),
        worst_output=join_outputs([name.without_owner for name in one.worst_outputs]),
        limiting_source=source_title(one.remedy.source, of=one.sensor),
        factor="" if is_open else print_factor(one.remedy),
        missing="" if one.missing is None else f"{len(one.missing.lines)}",
        at_worst=print_worst_case(one.missing),
        ask="" if one.doubt is None else print_ask(one.doubt, one.sensor),
        saturates=line("comparison_parts", "saturates", standing=one) if beyond else "",
        of=one,
    )


def print_conformance(one: Entrant | Pair) -> str:
    """Print the conformance; '' where it would be that of another unit."""
    if one.at_medians or one.saturates:
        return ""
    return (print_at_most if one.utilisation.is_bound else print_probability)(
        one.conformance
    )


def print_range(doubt: Doubt) -> tuple[str, ...]:
    """Print the ends of the part of a limit, over what lines may be, in per cent."""
    ends = (print_utilisation(end).removesuffix(" %") for end in doubt.utilisation_90)
    return tuple(dict.fromkeys(ends))


def print_ask(doubt: Doubt, sensor: str) -> str:
    """Name the missing line to ask for first, 'mounting repeatability 0.11'."""
    first = doubt.asks[0]
    if settle(first.reduction) < HALF_DIGIT:
        return ""
    title = source_title(first.source, of=sensor)
    return f"{title} {print_chance(first.reduction)}"


def print_parts(
    value: float, interval: tuple[float, float]
) -> tuple[str, tuple[str, ...]]:
    """Print a part of a limit in per cent, and the ends of its sampling interval.

    The part is printed as everywhere, the interval to the first digit of its
    half-width and never coarser than the part, and where the law is surer than three
    digits tell only if the limit lies in it.
    """
    low, high = interval
    half = (high - low) / 2.0
    text = print_utilisation(value).removesuffix(" %")
    if half <= SURE * abs(value) and not low <= 1.0 < high:
        return text, ()
    # round_value keeps two digits of an uncertainty; of ten times it, one.
    unsure = 10.0 * min(PER_CENT * half, abs(value))
    ends = (round_value(PER_CENT * x, unsure) for x in interval)
    return text, tuple(ends)


def print_at_most(p: Probability) -> str:
    """Print a probability that lines not given can only lessen; '' of no bound."""
    text, most = print_probability(p), print_most(p)
    return text if text.startswith("<") else most and f"{AT_MOST} {most}"


def print_factor(remedy: Remedy) -> str:
    """Print what the u of the limiting source times which would just do; '' if none."""
    if remedy.factor is None:
        return ""
    if remedy.factor >= MOST_FACTOR:
        return f">{MOST_FACTOR:.0f}"
    return print_three(remedy.factor)


def print_worst_case(missing: MissingLines | None) -> str:
    """Print what the missing lines could do at worst: '198 fails', or '?'."""
    if missing is None or not missing.is_bound:
        return ""
    if missing.utilisation is None:
        return "?"
    text = print_utilisation(missing.utilisation).removesuffix(" %")
    return f"{text} {words(missing.verdict)}"


@dataclass(frozen=True, kw_only=True)
class RankingColumn:
    """A column of the ranking, and what `--sort` puts it in order by."""

    key: str
    order: Callable[[DeviceRow], Any]

    @property
    def head(self) -> str:
        """What stands above it."""
        return line("comparison_parts", "head", key=self.key)


def _undecided_last(row: DeviceRow, number: float) -> tuple[bool, float]:
    """Order by a number, what cannot be decided last."""
    return row.of.verdict == "undecidable", number


def rank_of(rank: str) -> float | None:
    """Return a rank as a number; None of what has none."""
    number = rank_number(rank)
    return None if number is None else float(number)


RANKING = (
    RankingColumn(key="device", order=lambda row: row.device.casefold()),
    RankingColumn(key="rank", order=lambda row: rank_of(row.rank) or inf),
    RankingColumn(
        key="verdict",
        order=lambda row: (
            VERDICTS.index(row.of.verdict),
            -row.of.doubt.probability if row.of.doubt else 0.0,
        ),
    ),
    RankingColumn(
        key="utilisation", order=lambda row: _undecided_last(row, row.of.utilisation)
    ),
    RankingColumn(key="interval", order=lambda row: row.of.utilisation_interval),
    RankingColumn(
        key="conformance",
        order=lambda row: _undecided_last(row, -row.of.conformance.value),
    ),
    RankingColumn(key="worst_output", order=lambda row: row.worst_output),
    RankingColumn(key="limiting_source", order=lambda row: row.limiting_source),
    RankingColumn(key="factor", order=lambda row: -(row.of.remedy.factor or 0.0)),
    RankingColumn(
        key="missing",
        order=lambda row: len(row.of.missing.lines) if row.of.missing else 0,
    ),
    RankingColumn(
        key="at_worst",
        order=lambda row: inf if row.of.at_worst is None else row.of.at_worst,
    ),
    RankingColumn(
        key="ask",
        order=lambda row: -row.of.doubt.asks[0].reduction if row.of.doubt else 0.0,
    ),
)


def find_column(name: str) -> RankingColumn:
    """Return the column of that key or head.

    Raises
    ------
    CallError
        There is none.
    """
    known = {
        text: column for column in RANKING for text in (column.key, column.head)
    } | {words(column.key): column for column in RANKING}
    if name in known:
        return known[name]
    near = get_close_matches(name, known)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise CallError(
        f"--sort: {name!r} is no column, allowed: "
        f"{', '.join(column.key for column in RANKING)}{hint}"
    )


def merit_points(ranking: Ranking, merit: str) -> list[tuple[DeviceRow, Amount]]:
    """Return the devices whose price, mass or power can be compared, cheapest first."""
    found = [
        (row, amount)
        for row in ranking.measured
        if (amount := read_amount(merit, getattr(row.of, merit))) is not None
    ]
    # As the front does: amounts in other units than the first one cannot be compared.
    same = [pair for pair in found if pair[1].unit == found[0][1].unit]
    return sorted(same, key=lambda pair: (pair[1].value, pair[0].of.utilisation))
