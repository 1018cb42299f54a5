"""What tables of a comparison show of devices: rankings, parts of limits, CSV."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from math import inf
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from budget.documents import document
from budget.errors import CallError
from budget.known import AT_MOST
from budget.language import say, words
from budget.missing import PREDICT
from budget.names import MISSION
from budget.report.document import csv_pieces
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
from budget.studies.comparison.records import NUMBERED
from budget.studies.figures_of_merit import read_amount
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.names import Name
    from budget.results import Condition, Doubt, Probability, Remedy
    from budget.studies.comparison.records import Comparison, Entrant, Unit
    from budget.studies.figures_of_merit import Amount

COLUMNS = (
    "procedure",
    "sensor",
    "rank",
    "device",
    "file",
    "verdict",
    "device_utilisation",
    "device_conformance",
    "parameter",
    "axis",
    "unit",
    "limit",
    "standard_uncertainty",
    "largest_error",
    "utilisation",
    "conformance",
    "interval_low",
    "interval_high",
    "interval_by",
    "lower_bound",
    "device_lower_bound",
    "conditions",
)


PREDICTED = ("device_probability", "device_doubt", "ask_first", "ask_first_worth")


MOST_FACTOR = 1000.0  # beyond, a line does not limit anything in any case
SURE = 5e-4  # of a utilisation [1]: half a unit in the third digit


@dataclass(frozen=True, kw_only=True)
class RankingColumn:
    """A column of the ranking: what stands there, and what `--sort` orders by."""

    key: str
    order: Callable[[Entrant], Any]
    text: Callable[[Entrant], Any] = lambda _: ""

    @property
    def head(self) -> str:
        """What stands above it."""
        return line("comparison_parts", "head", key=self.key)


@dataclass(frozen=True, kw_only=True)
class Ranking:
    """All devices with one sensor under one procedure."""

    sensor: str
    name: str  # unique in the document: 'gyro-0'
    devices: Sequence[Entrant]  # best first, or in the order that was asked for
    nothing_known: tuple[str, ...]  # devices with no error line: in no row
    verdicts: Counter[str]  # with those
    under: str  # the procedure, '' where there is no other

    @cached_property
    def rows(self) -> list[SimpleNamespace]:
        """The devices as texts."""
        return [*map(row_of, self.devices)]

    @cached_property
    def decided(self) -> list[SimpleNamespace]:
        """The rows of devices that can be judged."""
        return [row for row in self.rows if _is_decided(row.of)]

    @cached_property
    def measured(self) -> list[SimpleNamespace]:
        """Those of them that read what they are asked for: a figure shows these."""
        return [row for row in self.decided if not row.saturates]

    def first(self, most: int) -> list[SimpleNamespace]:
        """Return the first that can be judged, and units that were measured.

        No more are written than it takes.
        """
        decided = enumerate(filter(_is_decided, self.devices))
        return [row_of(one) for k, one in decided if k < most or one.measured]

    @property
    def subject(self) -> str:
        """'Gyro', or 'Gyro, Zhao 2019' where there are several procedures."""
        return line("comparison_parts", "subject", table=self)

    @property
    def best(self) -> SimpleNamespace | None:
        """The best device that meets, if on conditions; None where none does."""
        return next((row_of(one) for one in self.devices if one.rank), None)

    @property
    def counts(self) -> dict[str, int]:
        """How many devices there are with each verdict, the best verdict first."""
        return {verdict: n for verdict in VERDICTS if (n := self.verdicts[verdict])}


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
        own = [one for one in comparison.listed if one.sensor == sensor]
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
    firsts: list[Condition]  # what each is asked for first

    @property
    def bounds(self) -> str:
        """From where on devices fail by that: '5.53 deg/h/g', of several a range.

        '' where it is not known of all, or in units of which there are two.
        """
        sizes = [one.below / one.si_per_unit for one in self.firsts if one.below]
        units = {one.unit for one in self.firsts}
        if not sizes or len(sizes) < len(self.firsts) or len(units) > 1:
            return ""
        ends = dict.fromkeys(map(print_three, (min(sizes), max(sizes))))
        return f"{say(' to ').join(ends)} {units.pop()}"


def gather(
    found: Iterable[tuple[tuple[str, str, tuple[Name, ...]], Entrant | Unit]],
) -> list[Request]:
    """Gather what is asked for by sensor, maker and lines that are alike."""
    together: dict[
        tuple[str, str, tuple[Name, ...]], list[tuple[str, Sequence[Condition]]]
    ] = {}
    for key, one in found:
        together.setdefault(key, []).append((one.name, one.asks[:1]))
    return [
        Request(
            sensor=sensor,
            vendor=vendor,
            lines=lines,
            names=list(dict.fromkeys(name for name, _ in own)),
            firsts=[ask for _, asks in own for ask in asks],
        )
        for (sensor, vendor, lines), own in together.items()
    ]


def requests(comparison: Comparison) -> list[Request]:
    """Return what to ask whom for, sensor by sensor."""
    found = (
        ((one.sensor, one.vendor, _asked_for(one)), one)
        for one in comparison.entrants
        if not (_is_decided(one) or one.saturates)
    )
    order = [*comparison.required]
    return sorted(gather(found), key=lambda one: order.index(one.sensor))


def _asked_for(one: Entrant) -> tuple[Name, ...]:
    """Return the lines to ask for; () of a sheet that gives none: every one."""
    if not one.is_judged and one.sensor != MISSION:
        return ()
    asks = tuple(ask.line for ask in one.asks)
    return asks or (one.missing.lines if one.missing else ())


def rankings(
    comparison: Comparison, *, order: Callable[[Entrant], Any] | None = None
) -> tuple[Ranking, ...]:
    """Return a table for each sensor and procedure, best first or by a column."""
    return tuple(
        Ranking(
            sensor=sensor,
            name=f"{sensor}-{place}",
            devices=sorted(devices, key=order) if order else devices,
            nothing_known=tuple(
                one.name
                for one in comparison.nothing_known
                if (one.sensor, one.procedure) == (sensor, procedure)
            ),
            verdicts=Counter(
                one.verdict
                for one in comparison.listed
                if (one.sensor, one.procedure) == (sensor, procedure)
            ),
            under=procedure if len(comparison.procedures) > 1 else "",
        )
        for place, ((sensor, procedure), devices) in enumerate(comparison.lists.items())
    )


def side_by_side(
    found: Sequence[Ranking], sensor: str
) -> list[tuple[SimpleNamespace, list[SimpleNamespace | None]]]:
    """Return the devices with one sensor under all procedures, as under the first.

    None: the procedure leaves the sensor out.
    """
    own = [table for table in found if table.sensor == sensor]
    known = [{row.of.place: row for row in table.rows} for table in own]
    return [
        (row, [rows.get(row.of.place) for rows in known])
        for row in next(table for table in own if table.rows).rows
    ]


def row_of(one: Entrant) -> SimpleNamespace:
    """Write one row: a text of each column, `saturates` in words, and the device.

    What a row prints in per cent has no sign of it.
    """
    beyond = line("comparison_parts", "saturates", standing=one)
    texts = {column.key: column.text(one) for column in RANKING}
    return SimpleNamespace(**texts, saturates=beyond if one.saturates else "", of=one)


def _print_used(one: Entrant) -> str:
    """Print the part of the limit, which of what saturates is that of another unit."""
    text, _ = print_parts(one.utilisation, one.utilisation_interval)
    return DASH if one.saturates else one.utilisation.written(text)


def _print_interval(one: Entrant) -> tuple[str, ...]:
    """Print the ends of the interval, or one that is both; () by the law."""
    if one.saturates:
        return ()
    if one.doubt:
        return print_range(one.doubt)
    return print_parts(one.utilisation, one.utilisation_interval)[1]


def _print_worst(one: Entrant) -> str:
    """Name the outputs that use most, without their sensor."""
    return join_outputs([name.without_owner for name in one.worst_outputs])


def _print_source(one: Entrant) -> str:
    """Name the source that limits it."""
    return source_title(one.remedy.source, of=one.sensor)


def print_conformance(one: Entrant | Unit) -> str:
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


def _undecided_last(one: Entrant, number: float) -> tuple[bool, float]:
    """Order by a number, what cannot be decided last."""
    return one.verdict == "undecidable", number


RANKING = (
    RankingColumn(
        key="device",
        text=lambda one: one.name,
        order=lambda one: one.name.casefold(),
    ),
    RankingColumn(
        key="rank",
        text=lambda one: one.printed_rank,
        order=lambda one: one.rank or inf,
    ),
    RankingColumn(
        key="verdict",
        text=lambda one: print_doubt(one.doubt) if one.doubt else words(one.verdict),
        order=lambda one: (
            VERDICTS.index(one.verdict),
            -one.doubt.probability if one.doubt else 0.0,
        ),
    ),
    RankingColumn(
        key="utilisation",
        text=_print_used,
        order=lambda one: _undecided_last(one, one.utilisation),
    ),
    RankingColumn(
        key="interval",
        text=_print_interval,
        order=lambda one: one.utilisation_interval,
    ),
    RankingColumn(
        key="conformance",
        text=print_conformance,
        order=lambda one: _undecided_last(one, -one.conformance.value),
    ),
    RankingColumn(key="worst_output", text=_print_worst, order=_print_worst),
    RankingColumn(key="limiting_source", text=_print_source, order=_print_source),
    RankingColumn(
        key="factor",
        text=lambda one: (
            "" if one.rests_on_others or one.saturates else print_factor(one.remedy)
        ),
        order=lambda one: -(one.remedy.factor or 0.0),
    ),
    RankingColumn(
        key="missing",
        text=lambda one: "" if one.missing is None else f"{len(one.missing.lines)}",
        order=lambda one: len(one.missing.lines) if one.missing else 0,
    ),
    RankingColumn(
        key="at_worst",
        order=lambda one: inf if one.at_worst is None else one.at_worst,
    ),
    RankingColumn(
        key="ask",
        text=lambda one: "" if one.doubt is None else print_ask(one.doubt, one.sensor),
        order=lambda one: -one.doubt.asks[0].reduction if one.doubt else 0.0,
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


def merit_points(ranking: Ranking, merit: str) -> list[tuple[SimpleNamespace, Amount]]:
    """Return the devices whose price, mass or power can be compared, cheapest first."""
    found = [
        (row, amount)
        for row in ranking.measured
        if (amount := read_amount(merit, getattr(row.of, merit))) is not None
    ]
    # As the front does: amounts in other units than the first one cannot be compared.
    same = [pair for pair in found if pair[1].unit == found[0][1].unit]
    return sorted(same, key=lambda pair: (pair[1].value, pair[0].of.utilisation))


def to_csv(comparison: Comparison) -> Iterator[str]:
    """Yield the text of one row for each device and required output, in printed units.

    Where missing lines are predicted, with the probability and what to ask for.
    """
    more = PREDICTED if comparison.settings.missing == PREDICT else ()
    return csv_pieces((*COLUMNS, *more), _rows(comparison))


def _rows(comparison: Comparison) -> Iterator[dict[str, Any]]:
    """Yield the entries of the JSON document, one for each output, without lists."""
    for one in map(document, comparison.ranked):
        predicted = one.get("predicted", {})
        first: dict[str, Any] = next(iter(predicted.get("worth_asking", [])), {})
        for output in one["outputs"]:
            low, high = output["interval"]
            yield {
                **{f"device_{key}": value for key, value in one.items()},
                **{key: one[key] for key in ("rank", "file", "verdict")},
                "procedure": one["procedure"],
                "device": one["name"],
                "conditions": _conditions(one),
                "device_probability": predicted.get("probability"),
                "device_doubt": predicted.get("doubt"),
                "ask_first": first.get("source"),
                "ask_first_worth": first.get("reduction"),
                **output,
                "interval_low": low,
                "interval_high": high,
            }
    for entrant in comparison.nothing_known:  # no figure: a 0 would look like the best
        one = document(entrant, "entrant")
        yield {**one, "device": entrant.name, "conditions": _conditions(one)}


def _conditions(one: dict[str, Any]) -> str:
    """Say in a cell what a verdict holds if, or what to ask for."""
    return "; ".join(condition["text"] for condition in one["conditions"])
