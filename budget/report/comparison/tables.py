"""The tables of a comparison: ranking, outputs, fronts, pairs, procedures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any

from budget.errors import CallError
from budget.language import Note, key_title, say, term, words
from budget.names import IMU
from budget.report.blocks import Cell, Field, table_of
from budget.report.tables import (
    AT_LEAST,
    AT_MOST,
    HALF_DIGIT,
    PER_CENT,
    join_outputs,
    print_chance,
    print_doubt,
    print_given,
    print_most,
    print_probability,
    print_three,
    print_utilisation,
    round_value,
    source_title,
    used_part,
)
from budget.report.wording import capital, deciding_lines, parted
from budget.results import VERDICTS
from budget.studies.comparison.records import rank_number, ranks
from budget.studies.figures_of_merit import read_amount
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from budget.names import Name
    from budget.report.blocks import Table
    from budget.results import Doubt, Probability
    from budget.studies.comparison.records import (
        Comparison,
        DeviceVerdict,
        MissingLines,
        Pair,
        Remedy,
    )
    from budget.studies.figures_of_merit import Amount


PAIRS_SHOWN = 20
CONFORMANCE = term("conformance [%]")
NOT_CALIBRATED = term("not calibrated")  # a sensor under a procedure that leaves it out
MOST_FACTOR = 1000.0  # beyond, a line does not limit anything in any case
SURE = 5e-4  # of a utilisation [1]: half a unit in the third digit


@dataclass(frozen=True, kw_only=True)
class Row:
    """One sensor of one device, as texts; numbers are in per cent, without the sign."""

    rank: str  # '2', '2=' where it is tied with a neighbour
    device: str
    verdict: str
    utilisation: str
    interval: str  # '' by the law
    conformance: str
    worst_output: str  # without the sensor
    limiting_source: str
    factor: str  # '' where the source alone cannot mend it
    missing: str  # number of expected lines that are not given
    at_worst: str  # '198 fails' with the worst of the catalogue in their place
    ask: str  # 'mounting repeatability 0.11': which of them to ask for, its worth
    of: DeviceVerdict


@dataclass(frozen=True, kw_only=True)
class Ranking:
    """All devices with one sensor under one procedure."""

    sensor: str
    procedure: str
    rows: tuple[Row, ...]
    nothing_known: tuple[str, ...]  # devices with no error line: in no row
    under: str  # ', Zhao 2019' where there are several procedures, else ''

    @property
    def subject(self) -> str:
        """'Gyro', or 'Gyro, Zhao 2019' where there are several procedures."""
        return f"{capital(what_is_judged(self.sensor))}{self.under}"

    @property
    def best(self) -> Row | None:
        """The best device that meets, if on conditions; None where none does."""
        numbered = [row for row in self.rows if row.rank]
        return min(numbered, key=lambda row: _rank(row.rank) or inf, default=None)

    @property
    def counts(self) -> str:
        """'2 meet, 1 undecided, 3 fail'."""
        verdicts = [row.of.verdict for row in self.rows]
        verdicts += ["undecidable"] * len(self.nothing_known)
        if not verdicts:
            return say(NOT_CALIBRATED)
        plural = {
            "meets": term("meet"),
            "meets_if": term("meet if"),
            "fails": term("fail"),
        }
        return say(", ").join(
            f"{verdicts.count(word)} {say(plural.get(word, word))}"
            for word in VERDICTS
            if word in verdicts
        )


@dataclass(frozen=True, kw_only=True)
class SideRow:
    """One sensor of one device under every procedure: '61.2 meets' for each."""

    device: str
    cells: tuple[str, ...]


def what_is_judged(sensor: str) -> str:
    """Name a triad, both together, or the mission."""
    return say("gyro and accelerometer") if sensor == IMU else say(sensor)


def rankings(
    comparison: Comparison, *, order: Callable[[Row], Any] | None = None
) -> tuple[Ranking, ...]:
    """Return a table for each sensor and procedure, best first or by a column."""
    found = []
    for (sensor, procedure), devices in comparison.lists.items():
        rows = [
            _row(one, rank) for one, rank in zip(devices, ranks(devices), strict=True)
        ]
        if order is not None:
            rows.sort(key=order)
        unknown = tuple(
            one.name
            for one in comparison.nothing_known
            if (one.sensor, one.procedure) == (sensor, procedure)
        )
        found.append(
            Ranking(
                sensor=sensor,
                procedure=procedure,
                rows=tuple(rows),
                nothing_known=unknown,
                under=say(", {procedure}", procedure=procedure)
                if len(comparison.procedures) > 1
                else "",
            )
        )
    return tuple(found)


def side_by_side(found: Sequence[Ranking], sensor: str) -> tuple[SideRow, ...]:
    """Return the devices with one sensor under all procedures, as under the first."""
    own = [table for table in found if table.sensor == sensor]
    cells = {
        (row.of.place, table.procedure): f"{row.utilisation} {row.verdict}"
        for table in own
        for row in table.rows
    }
    return tuple(
        SideRow(
            device=row.device,
            cells=tuple(
                cells.get((row.of.place, table.procedure), say(NOT_CALIBRATED))
                for table in own
            ),
        )
        for row in next((table for table in own if table.rows), own[0]).rows
    )


def _row(one: DeviceVerdict, rank: str) -> Row:
    """Write one row."""
    utilisation, interval = print_parts(one.utilisation, one.utilisation_interval)
    if one.doubt is not None:
        interval = print_range(one.doubt.utilisation_90)
    if one.lower_bound:
        utilisation = f"{AT_LEAST} {utilisation}"
    return Row(
        rank=rank,
        device=one.name,
        verdict=words(one.verdict) if one.doubt is None else print_doubt(one.doubt),
        utilisation=utilisation,
        interval=interval,
        conformance=_conformance(one),
        worst_output=join_outputs([name.without_owner for name in one.worst_outputs]),
        limiting_source=source_title(one.remedy.source, of=one.sensor),
        factor=""
        if one.rests_on_others or one.standing.saturates
        else print_factor(one.remedy),
        missing="" if one.missing is None else f"{len(one.missing.lines)}",
        at_worst=print_worst_case(one.missing),
        ask="" if one.doubt is None else print_ask(one.doubt, one.sensor),
        of=one,
    )


def _named_after(
    fields: Iterable[Field[Any]], found: Iterable[Probability]
) -> list[Field[Any]]:
    """Say in the head where conformances are the screen's, which draws no trials."""
    if all(p.low is not None for p in found):
        return list(fields)
    by_law = term("conformance by the normal law [%]")
    return [
        replace(one, head=by_law) if one.head == CONFORMANCE else one for one in fields
    ]


def _conformance(one: DeviceVerdict) -> str:
    """Print the conformance; '' where it would be that of another unit."""
    if one.at_medians or one.standing.saturates:
        return ""
    return (print_at_most if one.lower_bound else print_probability)(one.conformance)


def print_range(interval: tuple[float, float]) -> str:
    """Print an interval of a part of a limit, '4.2 to 61.5', in per cent."""
    low, high = (print_utilisation(end).removesuffix(" %") for end in interval)
    return low if low == high else say("{low} to {high}", low=low, high=high)


def print_ask(doubt: Doubt, sensor: str) -> str:
    """Name the missing line to ask for first, 'mounting repeatability 0.11'."""
    first = doubt.asks[0]
    if settle(first.reduction) < HALF_DIGIT:
        return ""
    title = source_title(first.source, of=sensor)
    return f"{title} {print_chance(first.reduction)}"


def print_parts(value: float, interval: tuple[float, float]) -> tuple[str, str]:
    """Print a part of a limit in per cent, and its sampling interval.

    The part is printed as everywhere, the interval to the first digit of its
    half-width, and where the law is surer than three digits tell only if the limit
    lies in it.
    """
    low, high = interval
    half = (high - low) / 2.0
    text = print_utilisation(value).removesuffix(" %")
    if half <= SURE * abs(value) and not low <= 1.0 < high:
        return text, ""
    # round_value keeps two digits of an uncertainty; of ten times it, one.
    ends = [round_value(PER_CENT * x, 10.0 * PER_CENT * half) for x in (low, high)]
    return text, say("{low} to {high}", low=ends[0], high=ends[1])


def print_at_most(p: Probability) -> str:
    """Print a probability that lines not given can only lessen."""
    text = print_probability(p)
    return text if text.startswith("<") else f"{AT_MOST} {print_most(p)}"


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
    text = print_parts(missing.utilisation, (missing.utilisation,) * 2)[0]
    return f"{text} {say(missing.verdict)}"


LONG = 8  # rows from which a table is worth searching
FEW = 2  # devices that are named, even where they are all
DASH = "\N{EN DASH}"  # a factor that is not there


@dataclass(frozen=True, kw_only=True)
class RankingField(Field[Row]):
    """A column of the ranking, and what `--sort` puts it in order by."""

    order: Callable[[Row], Any]


def _undecided_last(row: Row, number: float) -> tuple[bool, float]:
    """Order by a number, what cannot be decided last."""
    return row.of.verdict == "undecidable", number


def _rank(rank: str) -> float | None:
    """Return a rank as a number; None of what has none."""
    number = rank_number(rank)
    return None if number is None else float(number)


def _utilisation(row: Row) -> Cell:
    """Return the part of the limit that a device uses."""
    return Cell(text=row.utilisation, exact=PER_CENT * row.of.utilisation)


RANKING = (
    RankingField(
        key="device",
        head=term("device"),
        weight=2.0,
        cell=lambda row: Cell(
            text=row.device,
            strong=row.verdict == "meets",
            note=say("lines missing") if row.missing else "",
        ),
        order=lambda row: row.device.casefold(),
    ),
    RankingField(
        key="rank",
        head=term("rank"),
        kind="number",
        cell=lambda row: Cell(text=row.rank, exact=_rank(row.rank)),
        order=lambda row: _rank(row.rank) or inf,
    ),
    RankingField(
        key="verdict",
        head=term("verdict"),
        cell=lambda row: Cell(text=row.verdict, strong=row.of.verdict == "meets"),
        order=lambda row: (
            VERDICTS.index(row.of.verdict),
            -row.of.doubt.probability if row.of.doubt else 0.0,
        ),
    ),
    RankingField(
        key="utilisation",
        head=term("% of limit"),
        kind="number",
        cell=_utilisation,
        order=lambda row: _undecided_last(row, row.of.utilisation),
    ),
    RankingField(
        key="interval",
        head=term("interval"),
        weight=1.3,
        cell=lambda row: row.interval,
        optional=True,
        order=lambda row: row.of.utilisation_interval,
    ),
    RankingField(
        key="conformance",
        head=CONFORMANCE,
        kind="number",
        cell=lambda row: Cell(
            text=row.conformance,
            exact=None if row.of.at_medians else PER_CENT * row.of.conformance.value,
        ),
        order=lambda row: _undecided_last(row, -row.of.conformance.value),
    ),
    RankingField(
        key="worst_output",
        head=term("worst output"),
        weight=1.3,
        cell=lambda row: row.worst_output,
        order=lambda row: row.worst_output,
    ),
    RankingField(
        key="limiting_source",
        head=term("limited by"),
        weight=1.5,
        cell=lambda row: row.limiting_source,
        order=lambda row: row.limiting_source,
    ),
    RankingField(
        key="factor",
        head=term("factor"),
        kind="number",
        cell=lambda row: Cell(text=row.factor or DASH, exact=row.of.remedy.factor),
        order=lambda row: -(row.of.remedy.factor or 0.0),
    ),
    RankingField(
        key="missing",
        head=term("missing"),
        kind="number",
        cell=lambda row: Cell(
            text=row.missing, exact=float(row.missing) if row.missing else None
        ),
        optional=True,
        order=lambda row: len(row.of.missing.lines) if row.of.missing else 0,
    ),
    RankingField(
        key="at_worst",
        head=term("at worst [% of limit]"),
        cell=lambda row: row.at_worst,
        optional=True,
        order=lambda row: inf if row.of.at_worst is None else row.of.at_worst,
    ),
    RankingField(
        key="ask",
        head=term("ask for first"),
        cell=lambda row: row.ask,
        optional=True,
        order=lambda row: -row.of.doubt.asks[0].reduction if row.of.doubt else 0.0,
    ),
)


def find_column(name: str) -> RankingField:
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


# What the column of missing lines means, by the mode.
MISSING_NOTES = {
    "refuse": (
        term(
            "; they count as 0, so that the error is this or more (≥), "
            "and 'meets if' is the best verdict. At worst: with each at its "
            "ceiling, the larger of what the worst comparable device prints and the "
            "97.5 % point of its prediction; ?: one has none, and decides."
        )
    ),
    "worst": (
        term(
            "; they count as the worst of comparable devices, those of the same "
            "technology and grade, and as 0 where there are none: then the "
            "verdict is undecidable."
        )
    ),
    "typical": (
        term(
            "; they count as the median of comparable devices, those of the same "
            "technology and grade, and as 0 where there are none: then the verdict is "
            "undecidable."
        )
    ),
    "predict": (
        term(
            ", predicted from other devices: 'meets 0.83' is the probability that "
            "the device meets, over what its lines may be; % of limit is at their "
            "medians, and the interval is 90 % over what they may be. Of equal "
            "probability the decided device ranks first. Ask for first: the line "
            "whose knowledge would lessen the doubt, the probability that the "
            "likelier verdict is wrong, by the most, and by how much on average."
        )
    ),
}


def ranking_table(devices: Ranking, name: str) -> Table:
    """Return the devices with one sensor under one procedure, best first."""
    return table_of(
        devices.rows,
        _named_after(RANKING, (row.of.conformance for row in devices.rows)),
        name=name,
        caption=say(
            "Ranking of the {sensor} devices", sensor=what_is_judged(devices.sensor)
        ),
        is_wide=True,
        searchable=len(devices.rows) >= LONG,
    )


def ranking_note(found: Sequence[Ranking], mode: str) -> str:
    """Say what the columns of the rankings mean."""
    text = say(
        "Best first; = marks neighbours that cannot be told apart "
        "at 95 %. Conformance: probability that all required "
        "outputs are within their limits together. Factor: times "
        "this, the standard uncertainty of the limiting source "
        "alone would bring the worst output to its limit, by the "
        "law; {dash}: it alone cannot.",
        dash=DASH,
    )
    if any(row.interval for devices in found for row in devices.rows):
        text += say(" Interval: 95 %, of the sampling, and what the law can be off by.")
    if any(row.missing for devices in found for row in devices.rows):
        text += say(" Missing: expected lines that the data sheet does not give")
        text += say(MISSING_NOTES[mode])
    return text


def outputs_table(devices: Ranking, name: str) -> Table:
    """Return the part of each limit that each device uses: the data of the map."""
    return table_of(
        devices.rows,
        (
            Field[Row](head=say("device"), cell=lambda row: row.device),
            *(
                Field[Row](
                    head=_output_head(output.output.name),
                    kind="number",
                    cell=partial(_part_of_limit, place),
                )
                for place, output in enumerate(devices.rows[0].of.outputs)
            ),
        ),
        name=name,
        caption=say("Largest error in % of the limit, devices by outputs"),
        is_wide=True,
        searchable=len(devices.rows) >= LONG,
    )


def front_table(devices: Ranking, merit: str, name: str) -> Table:
    """Return cost and part of the limit of each device: the data of a front."""
    points = merit_points(devices, merit)
    return table_of(
        points,
        (
            Field(head=say("device"), weight=1.6, cell=lambda point: point[0].device),
            Field(
                head=f"{say(merit)} [{points[0][1].unit}]",
                kind="number",
                cell=lambda point: Cell(
                    text=print_given(point[1].value), exact=point[1].value
                ),
            ),
            Field(
                head=say("% of limit"),
                kind="number",
                cell=lambda point: _utilisation(point[0]),
            ),
            Field(head=say("verdict"), cell=lambda point: point[0].verdict),
            Field(
                head=say("on the front"),
                cell=lambda point: "yes" if merit in point[0].of.on_front else "no",
            ),
        ),
        name=name,
        caption=say("{merit} and part of the limit, cheapest first", merit=say(merit)),
    )


def _pair_utilisation(pair: Pair) -> Cell:
    """Return the part of its limits that a pair uses."""
    part = print_utilisation(pair.utilisation).removesuffix(" %")
    return Cell(
        text=f"{AT_LEAST} {part}" if pair.lower_bound else part,
        exact=PER_CENT * pair.utilisation,
    )


def _pair_verdict(pair: Pair) -> str:
    """Return the verdict, of a predicted one the probability."""
    if pair.probability is None:
        return words(pair.verdict)
    return say("meets {probability}", probability=print_chance(pair.probability))


def _pair_conformance(pair: Pair) -> Cell | str:
    """Print the joint conformance; '' where it would be that of another unit."""
    if pair.at_medians or pair.standing.saturates:
        return ""
    printed = print_at_most if pair.lower_bound else print_probability
    return Cell(text=printed(pair.conformance), exact=PER_CENT * pair.conformance.value)


PAIRS = (
    Field["Pair"](
        head=term("gyro"),
        weight=1.6,
        cell=lambda pair: Cell(text=pair.gyro, strong=pair.verdict == "meets"),
    ),
    Field["Pair"](
        head=term("accelerometer"),
        weight=1.6,
        cell=lambda pair: Cell(text=pair.accelerometer, strong=pair.verdict == "meets"),
    ),
    Field["Pair"](head=term("procedure"), cell=lambda pair: pair.procedure),
    Field["Pair"](head=term("verdict"), cell=_pair_verdict),
    Field["Pair"](head=term("% of limit"), kind="number", cell=_pair_utilisation),
    Field["Pair"](
        head=CONFORMANCE,
        kind="number",
        cell=_pair_conformance,
    ),
)


def imus_table(imus: Sequence[tuple[Pair, str]]) -> Table:
    """Return the IMUs as one device each, with their ranks, best first."""
    several = len({pair.procedure for pair, _ in imus}) > 1
    fields: tuple[Field[tuple[Pair, str]], ...] = (
        Field(
            head=say("device"),
            weight=1.6,
            cell=lambda one: Cell(text=one[0].gyro, strong=one[0].verdict == "meets"),
        ),
        Field(head=say("procedure"), cell=lambda one: one[0].procedure),
        Field(
            head=say("rank"),
            kind="number",
            cell=lambda one: Cell(text=one[1], exact=_rank(one[1])),
        ),
        Field(head=say("verdict"), cell=lambda one: _pair_verdict(one[0])),
        Field(
            head=say("% of limit"),
            kind="number",
            cell=lambda one: _pair_utilisation(one[0]),
        ),
        Field(
            head=CONFORMANCE,
            kind="number",
            cell=lambda one: _pair_conformance(one[0]),
        ),
        Field(
            head=say("worst output"),
            weight=1.6,
            cell=lambda one: join_outputs(one[0].worst_outputs),
        ),
        Field(
            head=say("limited by"),
            weight=1.5,
            cell=lambda one: source_title(
                one[0].limiting_source, of=one[0].worst_outputs[0].owner
            ),
        ),
        Field(
            head=say("stands on"),
            weight=2.5,
            cell=lambda one: say("; ").join(deciding_lines(one[0].standing)),
        ),
    )
    return table_of(
        imus,
        _named_after(
            (field for field in fields if several or field.head != "procedure"),
            (pair.conformance for pair, _ in imus),
        ),
        name="imus-table",
        caption=say("IMUs as one device, best first"),
        is_wide=True,
        searchable=len(imus) >= LONG,
    )


def pairs_table(pairs: Sequence[Pair]) -> Table:
    """Return the best pairs of a gyro and an accelerometer."""
    several = len({pair.procedure for pair in pairs}) > 1
    return table_of(
        pairs[:PAIRS_SHOWN],
        _named_after(
            (field for field in PAIRS if several or field.head != "procedure"),
            (pair.conformance for pair in pairs),
        ),
        name="pairs-table",
        caption=say("Pairs of gyro and accelerometer, best first"),
        is_wide=True,
        searchable=len(pairs) >= LONG,
    )


def procedures_table(
    comparison: Comparison, found: Sequence[Ranking], sensor: str
) -> Table:
    """Return one sensor of every device under every procedure."""
    rows = side_by_side(found, sensor)
    return table_of(
        rows,
        (
            Field[SideRow](head=say("device"), weight=1.6, cell=lambda row: row.device),
            *(
                Field[SideRow](head=name, cell=partial(_under, place))
                for place, name in enumerate(comparison.procedures)
            ),
        ),
        name=f"procedures-{sensor}",
        caption=say(
            "{sensor} devices by procedure: % of the limit and verdict",
            sensor=what_is_judged(sensor),
        ),
        is_wide=True,
        searchable=len(rows) >= LONG,
    )


def assumptions_table(comparison: Comparison, name: str) -> Table:
    """Return what the files leave to be assumed, alike ones in one row.

    An assumption reads 'device: line: what is assumed'; those of a procedure or of
    the requirement name no device.
    """
    names = sorted({one.name for one in comparison.devices}, key=len, reverse=True)
    gathered: dict[tuple[str, str], list[str]] = {}
    for given in comparison.assumptions:
        text = given
        device = next((name for name in names if text.startswith(f"{name}: ")), "")
        if device:
            own = text.parts.get("text") if isinstance(text, Note) else None
            text = own if isinstance(own, str) else text.removeprefix(f"{device}: ")
        line, assumed = parted(text)
        gathered.setdefault((line, assumed), []).append(device)
    alike: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for (line, assumed), devices in gathered.items():
        alike.setdefault((assumed, tuple(devices)), []).append(line)
    return table_of(
        alike.items(),
        (
            Field(
                head=say("line"),
                weight=1.2,
                cell=lambda item: say(", ").join(map(key_title, item[1])),
            ),
            Field(head=say("assumed"), weight=2.0, cell=lambda item: item[0][0]),
            Field(
                head=say("of"),
                weight=2.0,
                cell=lambda item: _owners(item[0][1], len(names)),
            ),
        ),
        name=name,
        caption=say("Assumptions in the files"),
        is_wide=True,
        searchable=len(alike) >= LONG,
    )


@dataclass(frozen=True, kw_only=True)
class MissingEffect:
    """What is put in the place of the expected lines that some devices lack."""

    sensor: str
    devices: tuple[str, ...]
    effect: str  # 'bias stability 24 deg/h (of NAME)', or that nothing is known


def missing_table(effects: Sequence[MissingEffect], *, head: str = "") -> Table:
    """Return what is put in the place of lines that are not given, or under a head."""
    return table_of(
        effects,
        (
            Field(
                head=say("sensor"),
                weight=0.7,
                cell=lambda row: what_is_judged(row.sensor),
            ),
            Field(
                head=say("devices"),
                weight=1.5,
                cell=lambda row: say(", ").join(row.devices),
            ),
            Field(
                head=head or say("in the place of what is missing"),
                weight=2.5,
                cell=lambda row: row.effect,
            ),
        ),
        name="missing-table",
        caption=say("In the place of expected lines that are not given"),
        is_wide=True,
        searchable=len(effects) >= LONG,
    )


def _owners(devices: Sequence[str], number: int) -> str:
    """Name the devices that an assumption is of; many that are all, as such."""
    named = [name for name in devices if name]
    if len(named) == number > FEW:
        return say("all {number} devices", number=number)
    return say(", ").join(named)


def _output_head(name: Name) -> str:
    """Name an output above a narrow column: 'angle xy'."""
    return key_title(name.without_owner).removeprefix("mounting ")


def _under(place: int, row: SideRow) -> str:
    """Return what a device uses, and its verdict, under one of the procedures."""
    return row.cells[place]


def _part_of_limit(place: int, row: Row) -> Cell:
    """Return the part of one limit that one device uses; beyond it in bold."""
    output = row.of.outputs[place]
    part = output.utilisation
    return Cell(
        text=used_part(output).text.removesuffix(" %"),
        exact=PER_CENT * part,
        strong=not output.is_within,
    )


def merit_points(ranking: Ranking, merit: str) -> list[tuple[Row, Amount]]:
    """Return the devices whose price, mass or power can be compared, cheapest first."""
    found = [
        (row, amount)
        for row in ranking.rows
        if (amount := read_amount(merit, getattr(row.of, merit))) is not None
    ]
    if not found:
        return []
    # As the front does: amounts in other units than the first one cannot be compared.
    unit = found[0][1].unit
    same = [pair for pair in found if pair[1].unit == unit]
    return sorted(same, key=lambda pair: (pair[1].value, pair[0].of.utilisation))
