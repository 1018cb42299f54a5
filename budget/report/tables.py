"""Numbers and tables for people: the only place where a result is rounded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from decimal import ROUND_HALF_UP, Context, Decimal
from itertools import groupby
from math import ceil, floor, fsum, inf, isfinite, log10, sqrt
from typing import TYPE_CHECKING

from budget.inputs.records import ANGLES
from budget.known import UNKNOWN, Known
from budget.language import axis_title, beside, key_title, say
from budget.names import MISSION, Name, by_group
from budget.results import BY_LAW, INTERACTION, Contribution
from budget.sentences import sentence
from budget.settings import further
from budget.ties import first_largest, foremost, from_largest, settle
from budget.units import ARCSEC, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.problem import Output
    from budget.results import (
        Budget,
        Doubt,
        InputQuantity,
        JudgedOutput,
        OutputBudget,
        Probability,
    )
    from budget.settings import Settings


# Plain notation between 1e-4 and 1e7, as 2.3e-9 outside: nobody counts nine zeros.
PLAIN_FROM, PLAIN_BELOW = -4, 7  # decimal exponents of the first digit
EXACT = Context(prec=700, rounding=ROUND_HALF_UP)  # digits from 1e308 to 1e-324

SMALL_SHARE = 0.01  # of the variance [1]; one below it is not worth a sentence
ALL = 1.0 - 1e-9  # [1]; a share above is the whole, short of it by rounding only
NO_SHARE = 1e-20  # [1]; a share below is what the rounding of doubles leaves of zero
CERTAIN = 4  # decimals of a per cent that nearly certain probabilities get at most
ONE_OF_1000 = 1e-3  # [1]; nearer to 0 and 1 the draws of the normal law do not tell
PER_CENT = 100.0
MINOR, FEW = {"<0.1 %", "0 %"}, 3  # such shares, so many of them have a row each
NAMED = 2  # contributions of a sentence
HALF_DIGIT = 5e-3  # half of the last digit of a probability of two decimals [1]
ROUNDING = 1e-9  # [1] of divisors and degrees of freedom
MORE_DIGITS = 4  # at the most, to tell on which side of a limit a number is
NEAR_LIMIT = 0.01  # [1]; a utilisation this close to 1 gets one more digit
DASH = "-"  # nothing to say
DIGITS = 3  # of an allocated value: it is a specification, not a measurement
HEADING = "heading"
LEAST_OF_UNIT = 0.1  # [1]; a smaller error is read in a unit of its own
# Units that an error is read in, the first one up to the next [SI]. Heading by itself,
# which may be a hundred times tilt.
ANGLE_UNITS = (("arcsec", ARCSEC), ("arcmin", 60.0 * ARCSEC), ("deg", 3600 * ARCSEC))
UNITS = {
    "position": (("m", 1.0), ("km", 1000.0)),
    "velocity": (("m/s", 1.0),),
    "attitude": ANGLE_UNITS,
    HEADING: ANGLE_UNITS,
}
Unit = tuple[str, float]  # and its size [SI]


@dataclass(frozen=True, kw_only=True)
class Number:
    """A number as people read it, and as it is."""

    text: str
    exact: float

    @classmethod
    def of(cls, exact: float, text: str) -> Number:
        """Return a number as it is printed, marked where it is known in part."""
        said = exact.written(text) if isinstance(exact, Known) else text
        return cls(text=said, exact=exact)


@dataclass(frozen=True, kw_only=True)
class OutputRow:
    """One output of a parameter group, in the unit of the group."""

    axis: str
    mean: Number
    u: Number
    expanded: Number  # U, half the width of the coverage interval
    low: Number
    high: Number
    check: str  # of the law: 'agrees', 'fails' or 'unsettled'; '' where not made
    # Coverage factor; None where nothing varies or is known, or U and u are not of one
    # method.
    k: Number | None
    law_k: float | None  # that of the law [1]
    degrees_of_freedom: str  # effective ones
    by: str  # what the interval is of, where it is not the law's
    u_by: str  # what mean and u are of, likewise
    lacks: tuple[str, ...]  # lines not given that would widen it, in words

    @property
    def has_mean(self) -> bool:
        """Whether an error is expected that is not 0, in print."""
        return self.mean.text != UNKNOWN and float(self.mean.text) != 0.0

    @property
    def is_centred(self) -> bool:
        """Whether the interval is mean +- U, to the digits that are printed."""
        text = round_value((self.low.exact + self.high.exact) / 2.0, self.u.exact)
        return self.mean.text in {text, UNKNOWN}


@dataclass(frozen=True, kw_only=True)
class SourceCell:
    """What one source alone does to one output."""

    u: Number  # [unit of the group]
    share: Number  # of the variance of the output
    # u(x) of its line and c, where it has one: JCGM 100:2008, 5.1.3.
    u_input: Number | None = None  # [unit of the line]
    c: Number | None = None  # [unit of the group over that of the line]
    linear: Number | None = None  # c u(x) [unit of the group]


@dataclass(frozen=True, kw_only=True)
class SourceRow:
    """One source over a parameter group, cells in the order of its outputs."""

    source: Name
    title: str
    share: Number  # of the variance, over the group
    cells: tuple[SourceCell, ...]
    quantity: InputQuantity | None = None  # its line, where it is of one

    @property
    def is_idle(self) -> bool:
        """Whether the source moves no output of the group, to rounding."""
        return all(cell.u.text == "0" for cell in self.cells)


@dataclass(frozen=True, kw_only=True)
class GroupTable:
    """The budget of one parameter of one sensor: outputs, contributions ranked."""

    sensor: str
    parameter: str
    unit: str
    coverage: float
    rows: tuple[OutputRow, ...]
    sources: tuple[SourceRow, ...]
    outputs: tuple[OutputBudget, ...]  # what the rows are of, with checks of the law
    digits: int  # of u that these checks make sure

    @property
    def title(self) -> str:
        """'gyro scale factor'."""
        return key_title(Name(self.parameter, owner=self.sensor))

    @property
    def widest(self) -> OutputRow:
        """The output with the largest U."""
        return self.rows[first_largest([row.expanded.exact for row in self.rows])]

    @property
    def minor(self) -> tuple[SourceRow, ...]:
        """Sources below 0.1 % of the variance of every output, where they are many."""
        small = tuple(
            row
            for row in self.sources
            if not row.is_idle and all(cell.share.text in MINOR for cell in row.cells)
        )
        return small if len(small) > FEW else ()

    @property
    def major(self) -> tuple[SourceRow, ...]:
        """The other ones that have an effect, each with rows of its own."""
        minor = {row.source for row in self.minor}
        return tuple(
            row for row in self.sources if not row.is_idle and row.source not in minor
        )

    def gathered(self, places: Sequence[int]) -> SourceCell:
        """Return the contribution of the minor sources together, the largest of these.

        Where outputs differ in it, it is marked as what is not exceeded.
        """
        columns = [[row.cells[place] for row in self.minor] for place in places]
        us = [sqrt(fsum(cell.u.exact**2 for cell in cells)) for cells in columns]
        share = max(fsum(cell.share.exact for cell in cells) for cells in columns)
        texts = [*dict.fromkeys(map(round_uncertainty, sorted(us, reverse=True)))]
        u = Known(max(us), low=-inf if texts[1:] else None)
        share_of = Number(text=print_share(share), exact=share)
        return SourceCell(u=Number.of(u, texts[0]), share=share_of)

    @property
    def alike(self) -> tuple[tuple[tuple[int, ...], ...], ...]:
        """Places of the outputs whose sources are the same in print.

        Those of them together of which the totals are, too.
        """
        found: dict[object, dict[object, list[int]]] = {}
        for place, row in enumerate(self.rows):
            sources = tuple(_printed(own.cells[place]) for own in self.major)
            found.setdefault(sources, {}).setdefault(_printed(row), []).append(place)
        return tuple(tuple(map(tuple, own.values())) for own in found.values())

    def axes(self, places: Sequence[int]) -> list[str]:
        """Name the axes of some outputs."""
        return [self.rows[place].axis for place in places]

    def seen(self, place: int) -> list[tuple[SourceRow, SourceCell]]:
        """Return the sources that have rows of their own, and act on an output."""
        cells = ((source, source.cells[place]) for source in self.major)
        return [(source, cell) for source, cell in cells if cell.u.text != "0"]

    @property
    def gaps(self) -> str:
        """Say which lines the numbers of the group lack; '' where none."""
        return print_gaps(self.outputs)

    @property
    def contributions(self) -> str:
        """'bias repeatability 79 %, bias stability 21 %, rest 0.2 %'."""
        return print_contributions(
            [(row.title, row.share.exact) for row in self.sources]
        )


def print_gaps(rows: Sequence[OutputBudget], most: int = 0) -> str:
    """Say which expected lines outputs lack, as of a group; '' where none.

    With `most` the first of them, and how many more.
    """
    lacks = dict.fromkeys(
        source_title(one, of=row.sensor)
        for row in rows
        for one in row.standard_uncertainty.why
    )
    if not lacks:
        return ""
    names = [*lacks]
    if most and len(names) > most + 1:
        names = [*names[:most], say("{more} more", more=len(names) - most)]
    unknown = any(row.standard_uncertainty.is_unknown for row in rows)
    return sentence("analysis/shares.gaps", lacks=names, is_unknown=unknown).said()


def _printed(record: OutputRow | SourceCell) -> tuple[object, ...]:
    """Return what is printed of an output or a source in a budget table."""
    return tuple(
        number.text if isinstance(number, Number) else number
        for name, number in vars(record).items()
        if name not in {"axis", "check", "law_k"}
    )


def round_uncertainty(u: float, *, resolution: float = 0.0) -> str:
    """Round to two significant digits, JCGM 100:2008, 7.2.6; halves go up.

    A spread at or below `resolution` is rounding of the computation: '0' [unit of u].

    Raises
    ------
    ValueError
        u is negative or not finite.
    """
    _check(u)
    if u <= resolution:
        return "0"
    return _print_decimal(_quantize(u, _last_place(u)))


def round_value(value: float, u: float, *, resolution: float = 0.0) -> str:
    """Round a value to the last digit that its uncertainty is printed to.

    Without spread (u at or below `resolution`) the value is as sure as the
    computation: six digits, or '0' at or below the resolution.

    Raises
    ------
    ValueError
        The value is not finite, or u is negative or not finite.
    """
    _check(u)
    if not isfinite(value):
        raise ValueError(f"a value of {value}, expected a finite number")
    if u <= resolution:
        return "0" if abs(value) <= resolution else print_given(value, digits=6)
    return _print_decimal(_quantize(value, _last_place(u)))


def round_error(
    error: float, u: float, output: Output, *, limit: float | None = None
) -> Number:
    """Round an error [SI] to the last digit of its u [SI], in the unit of its output.

    The one rule for every mean, interval end and largest error of a result. Beside a
    limit [SI] it has as many digits more as tell on which side of it it is: 2.39 of a
    limit of 2.4, not 2.4.
    """
    scale = output.si_per_unit
    text = round_value(error / scale, u / scale, resolution=output.resolution / scale)
    if limit is not None and output.resolution < u:
        text = _beside(error / scale, limit / scale, _last_place(u / scale))
    return Number.of(error / scale, text)


def _beside(value: float, limit: float, place: int) -> str:
    """Round to a decimal place, or to one that leaves it on its side of a limit."""

    def side(number: float) -> tuple[bool, bool]:
        return settle(number) < settle(limit), settle(number) > settle(limit)

    for more in range(MORE_DIGITS + 1):
        rounded = _quantize(value, place - more)
        if side(float(rounded)) == side(value):
            return _print_decimal(rounded)
    return _print_decimal(_quantize(value, place))


def round_u(u: float, output: Output) -> Number:
    """Round a standard uncertainty of an output [SI], in the unit it has."""
    scale = output.si_per_unit
    text = round_uncertainty(u / scale, resolution=output.resolution / scale)
    return Number.of(u / scale, text)


def used_part(row: JudgedOutput) -> Number:
    """Round the part of its limit that an output uses: '98.7 %', '≥ 42.0 %', '?'."""
    return Number.of(row.utilisation, print_utilisation(row.utilisation))


def as_limited(row: JudgedOutput) -> JudgedOutput:
    """Return an output of a mission in the unit of its limit, others as they are.

    An error below a tenth of that unit is in its own: 2.7 m, not 0.0027 km.
    """
    name = row.output.name
    if name.owner != MISSION:
        return row
    limit = parse_quantity(row.printed_limit, row.output.unit)
    unit = (limit.unit, limit.si_per_unit)
    if settle(row.largest_error / limit.si_per_unit) < LEAST_OF_UNIT:
        like = HEADING if name.axis == HEADING else name.quantity
        unit = unit_for(like, row.largest_error)
    return replace(row, output=replace(row.output, unit=unit[0], si_per_unit=unit[1]))


def largest_error(row: JudgedOutput) -> Number:
    """Round a largest error, in the unit of the output; marked where it is a bound."""
    u = row.standard_uncertainty
    return round_error(row.largest_error, u, row.output, limit=row.limit)


def unit_for(quantity: str, largest: float) -> Unit:
    """Return the unit that errors up to one [SI] are read in, and its size [SI]."""
    units = UNITS[quantity]
    fitting = [unit for unit in units if settle(largest / unit[1]) >= 1.0]
    return fitting[-1] if fitting else units[0]


def length(size: float) -> str:
    """Print a length in the unit that it is read in."""
    unit, scale = unit_for("position", size)
    return f"{round_uncertainty(size / scale)} {unit}"


def print_given(value: float, *, digits: int = 4) -> str:
    """Print a value that was given, not computed: '0.0125', no zeros added."""
    return _print_decimal(Decimal(f"{settle(value):.{digits - 1}e}").normalize(EXACT))


def print_share(share: float) -> str:
    """Print a share of the variance: '79 %', '0.3 %', '<0.1 %', '>99 %', '0 %'."""
    share = settle(share)
    if abs(share) < NO_SHARE:
        return "0 %"
    if 0.0 < share < SMALL_SHARE / 10.0:
        return "<0.1 %"
    digits = 1 if abs(share) < SMALL_SHARE else 0
    text = print_decimals(100.0 * share, digits)
    return ">99 %" if text == "100" and share < ALL else f"{text} %"


def print_utilisation(utilisation: float) -> str:
    """Print a part of a limit in three digits: '143 %', '98.7 %', '4.20 %'.

    100 % stands only where the limit is met exactly; near it as many digits are printed
    as tell on which side it is: '99.96 %'.
    """
    used = settle(utilisation)
    if used == 1.0:
        return "100 %"
    if abs(used - 1.0) >= NEAR_LIMIT:
        # Two digits of a tenth.
        return f"{round_value(PER_CENT * used, 10.0 * abs(used))} %"
    for decimals in range(1, MORE_DIGITS + 1):
        text = print_decimals(PER_CENT * used, decimals)
        if float(text) != PER_CENT:
            return f"{text} %"
    return "<100 %" if used < 1.0 else ">100 %"


def print_decimals(value: float, decimals: int) -> str:
    """Print a number with that many decimals; halves go up, never a negative zero."""
    return f"{_quantize(value, -decimals):f}"


def print_two_down(value: float) -> str:
    """Print two digits, rounded down: of the most that will do."""
    step = 10.0 ** (floor(log10(value)) - 1) if value > 0.0 else 1.0
    return print_given(floor(settle(value / step)) * step)


def print_three(value: float) -> str:
    """Print three digits, zeros kept: '2.50'."""
    return round_value(value, value / 10.0)  # two digits of a tenth


def print_probability(p: Probability) -> str:
    """Print a probability in per cent as far as its 95 % interval makes it sure."""
    if p.low is None or p.high is None:  # of the joint normal law
        return _print_by_law(p.value)
    if p.low == p.high:
        return print_given(PER_CENT * p.value)
    if p.value == 1.0:  # every trial: what is known is the lower end
        nines = min(max(floor(-log10(1.0 - p.low)) - 2, 0), CERTAIN)
        return f">{floor(PER_CENT * p.low * 10**nines) / 10**nines:.{nines}f}"
    if p.value == 0.0:
        first = 10.0 ** floor(log10(settle(PER_CENT * p.high)))
        most = ceil(settle(PER_CENT * p.high / first)) * first  # up: it is a bound
        return f"<{print_given(most, digits=1)}"
    return round_value(PER_CENT * p.value, 10.0 * PER_CENT * (p.high - p.low) / 2.0)


def _print_by_law(p: float) -> str:
    """Print in per cent a probability that draws of the normal law count."""
    if not ONE_OF_1000 <= p <= 1.0 - ONE_OF_1000:
        return ">99.9" if p > ONE_OF_1000 else "<0.1"
    if p > 1.0 - SMALL_SHARE:  # three digits of 99.87 are not 100
        return print_decimals(PER_CENT * p, 1)
    return print_three(PER_CENT * p)


def print_most(p: Probability) -> str:
    """Print in per cent what a probability is at the most: '98.3', '0.01'.

    '' where that says nothing, as it is all but 100 %.
    """
    text = print_probability(p)
    return "" if text.startswith(">") or text == "100" else text.removeprefix("<")


def print_chance(p: float) -> str:
    """Print a probability that rests on predictions to two decimals: '0.83'."""
    if p < HALF_DIGIT or 1.0 - p < HALF_DIGIT:
        return "<0.01" if p < HALF_DIGIT else ">0.99"
    return f"{settle(p):.2f}"


def print_doubt(doubt: Doubt) -> str:
    """Print a verdict that rests on predicted lines: 'meets 0.83'."""
    return say("meets {probability}", probability=print_chance(doubt.probability))


def print_coverage(coverage: float) -> str:
    """Print a coverage probability in per cent without the sign: '95', '99.73'."""
    return f"{100.0 * coverage:.6g}"


def print_count(count: int) -> str:
    """Print a count in groups of three digits: '230 000'."""
    return f"{count:,}".replace(",", " ")


def print_contributions(shares: Sequence[tuple[str, float]]) -> str:
    """Name the two largest, with all that are equal, and gather the rest."""
    return sentence("analysis/shares.largest", **_largest(shares)).said()


def of_the_variance(shares: Sequence[tuple[str, float]]) -> str:
    """Name the two largest as shares 'of the variance'; 'no spread' has none."""
    return sentence("analysis/shares.of_the_variance", **_largest(shares)).said()


def _largest(shares: Sequence[tuple[str, float]]) -> dict[str, object]:
    """Return the two largest shares, and the rest, as they are printed."""
    ranked = [shares[k] for k in from_largest([share for _, share in shares])]
    named = foremost([share for _, share in ranked], NAMED)
    head = [pair for pair in ranked[:named] if pair[1] >= SMALL_SHARE]
    rest = fsum(share for _, share in ranked[len(head) :])
    return {
        "parts": [f"{title} {print_share(share)}" for title, share in head],
        "rest": print_share(rest) if rest > NO_SHARE else "",
    }


def source_title(source: Name, *, of: str = "") -> str:
    """Name a source for people: 'gyro.bias_stability' to 'bias stability'.

    With its owner where it stands among those of another one: 'station levelling'.
    """
    if source == INTERACTION:
        return say("products of two sources")
    return key_title(source.within(of) if of else source.without_owner)


def full_title(source: Name) -> str:
    """Name a source with its owner, as it stands among those of all."""
    title = source_title(source)
    return beside(say(source.owner), title) if source.owner else title


def join_outputs(names: Sequence[Name]) -> str:
    """Gather outputs of one parameter: 'gyro bias x, y, z'; of all six, every axis."""
    groups: dict[Name, list[str]] = {}
    for name in names:
        if name.time is None:
            groups.setdefault(name.group, []).append(name.axis)
    return say("; ").join(
        [
            f"{key_title(group)} "
            + (
                say("(every axis)")
                if len(axes) == len(ANGLES)
                else say(", ").join(axes)
            )
            for group, axes in groups.items()
        ]
        + [key_title(name) for name in names if name.time is not None]
    )


def print_stop(names: Sequence[Name], of: str = "") -> str:
    """Name outputs, those of that sensor without it; a dash where there are none."""
    return join_outputs([name.within(of) for name in names]) or DASH


def settings_lines(settings: Settings) -> tuple[tuple[str, str], ...]:
    """Return (name, value), to be said, of what a result depends on besides files."""
    trials = settings.trials
    chosen = (settings.only, by_group(settings.outputs))
    only, outputs = (say(", ").join(few) for few in chosen)
    lines = {
        "method": settings.method,
        "trials": "none" if trials is None else print_count(trials),
        "seed": str(settings.seed),
        "coverage": f"{print_coverage(settings.coverage)} %",
        "interval": settings.interval,
        "error reference": settings.reference,
        "formulas": settings.formulas,
        "only": only,
        "outputs": outputs,
        "missing lines": "" if settings.missing == "refuse" else settings.missing,
    }
    lines |= further(settings)
    return tuple((name, value) for name, value in lines.items() if value)


def group_tables(budget: Budget) -> tuple[GroupTable, ...]:
    """Gather the outputs of a budget by sensor and parameter, in their order."""
    return tuple(
        _group_table(sensor, parameter, tuple(rows), budget)
        for (sensor, parameter), rows in groupby(
            budget.outputs, key=lambda row: (row.sensor, row.parameter)
        )
    )


def align_decimals(
    texts: Sequence[str], *, digit: str = " ", point: str = " "
) -> tuple[str, ...]:
    """Pad texts on the right so that, set flush right, their points are in line."""
    tails = [len(text) - len(text.partition(".")[0]) for text in texts]
    longest = max(tails, default=0)
    return tuple(
        text
        + (point if tail == 0 and longest else "")
        + digit * (longest - tail - (tail == 0 and longest > 0))
        for text, tail in zip(texts, tails, strict=True)
    )


def _group_table(
    sensor: str, parameter: str, outputs: tuple[OutputBudget, ...], budget: Budget
) -> GroupTable:
    """Make the table of one group; sources ranked by variance over the group."""
    settings = budget.settings
    quantities = {one.source: one for one in budget.quantities}
    # Where the spread is only rounding, so are the shares of it.
    spread = [
        (part.source, part.standard_uncertainty)
        for row in outputs
        for part in row.contributions
        if row.is_resolved and part.standard_uncertainty > row.output.resolution
    ]
    total = fsum(u**2 for _, u in spread)
    sources = []
    for source in dict.fromkeys(p.source for row in outputs for p in row.contributions):
        own = fsum(u**2 for name, u in spread if name == source)
        share = own / total if total > 0.0 else 0.0
        sources.append(
            SourceRow(
                source=source,
                title=source_title(source, of=sensor),
                share=Number(text=print_share(share), exact=share),
                cells=tuple(
                    _source_cell(row, source, quantities.get(source)) for row in outputs
                ),
                quantity=quantities.get(source),
            )
        )
    return GroupTable(
        sensor=sensor,
        parameter=parameter,
        unit=outputs[0].output.unit,
        coverage=settings.coverage,
        rows=tuple(output_row(row) for row in outputs),
        sources=tuple(
            sources[k] for k in from_largest([row.share.exact for row in sources])
        ),
        outputs=outputs,
        digits=settings.digits,
    )


def output_row(row: OutputBudget) -> OutputRow:
    """Round one output, everything to the last digit of its standard uncertainty."""
    u = row.standard_uncertainty

    def value(x: float) -> Number:
        return round_error(x, u, row.output)

    low, high = row.interval
    return OutputRow(
        axis=axis_title(row.output.name),
        mean=value(u.like(row.mean) if u.is_unknown else row.mean),
        u=round_u(u, row.output),
        expanded=value(u.like((high - low) / 2.0)),
        low=value(u.like(low).falling),
        high=value(u.like(high)),
        check="" if row.validation is None else row.validation.word,
        k=_coverage_factor(row),
        law_k=None if u.is_unknown else row.law_factor,
        degrees_of_freedom=print_degrees_of_freedom(row.degrees_of_freedom),
        by="" if row.interval_by == BY_LAW else row.interval_by,
        u_by="" if row.u_by == BY_LAW else row.u_by,
        lacks=tuple(source_title(name, of=row.sensor) for name in u.why),
    )


def _coverage_factor(row: OutputBudget) -> Number | None:
    """Return k of one output, JCGM 100:2008, 6.3."""
    if row.coverage_factor is None or row.standard_uncertainty.is_unknown:
        return None
    k = row.coverage_factor
    return Number(text=print_given(k), exact=k)


def print_degrees_of_freedom(v: float | None) -> str:
    """Print degrees of freedom, cut to the integer below: JCGM 100:2008, G.4.1."""
    if v is None:
        return ""
    return str(floor(v * (1.0 + ROUNDING))) if isfinite(v) else "\N{INFINITY}"


def print_divisor(divisor: float) -> str:
    """Print what turns a printed value into u(x): '3', 'sqrt(3)', '2 sqrt(3)'."""
    for times in (1, 2):
        square = round((divisor / times) ** 2)
        is_root = abs(divisor - times * sqrt(square)) <= ROUNDING * divisor
        if is_root and square in {2, 3, 6}:
            return f"{'' if times == 1 else f'{times} '}sqrt({square})"
    return print_given(divisor)


def _source_cell(
    row: OutputBudget, source: Name, quantity: InputQuantity | None
) -> SourceCell:
    """Round what one source does to one output; zeros where it is not in the list."""
    part = next(
        (p for p in row.contributions if p.source == source),
        Contribution(source=source, standard_uncertainty=Known(0.0), share=0.0),
    )
    u = float(part.standard_uncertainty)
    acts = row.is_resolved and u > row.output.resolution
    share = part.share if acts else 0.0
    cell = SourceCell(
        u=round_u(u, row.output),
        share=Number(text=print_share(share), exact=share),
    )
    if not quantity or part.linear is None:
        return cell
    unit = quantity.si_per_unit
    u_input = (part.u_input or 0.0) / unit
    c = (part.sensitivity or 0.0) / row.output.si_per_unit * unit if acts else 0.0
    return replace(
        cell,
        u_input=Number(text=print_given(u_input), exact=u_input),
        c=Number(text=print_given(c, digits=3), exact=c),
        linear=round_u(part.linear, row.output),
    )


def _check(u: float) -> None:
    """Refuse what is no uncertainty."""
    if not (isfinite(u) and u >= 0.0):
        raise ValueError(f"an uncertainty of {u}, expected a finite number from 0")


def _last_place(u: float) -> int:
    """Return the decimal exponent of the second digit of u > 0, after rounding."""
    exact = Decimal(repr(settle(u)))
    place = exact.adjusted() - 1
    # 0.0995 rounds to 0.10: the carry moves the second digit.
    return place + (_quantize(u, place).adjusted() - exact.adjusted())


def _quantize(value: float, place: int) -> Decimal:
    """Round to a multiple of 10**place; never to a negative zero."""
    settled = Decimal(repr(settle(value)))
    rounded = settled.quantize(Decimal(1).scaleb(place), context=EXACT)
    return abs(rounded) if rounded == 0 else rounded


def _print_decimal(number: Decimal) -> str:
    """Write all digits of a decimal, plainly or, where it is long, with an exponent."""
    if PLAIN_FROM <= number.adjusted() < PLAIN_BELOW:
        return f"{number:f}"
    if number == 0:
        return "0"
    places = max(0, len(number.as_tuple().digits) - 1)
    return f"{number:.{places}e}".replace("e+", "e")


MOST_DECIMALS = 3  # an index is a share: more digits tell nobody anything


def print_index(value: float, interval: tuple[float, float]) -> tuple[str, str]:
    """Return an index and its interval, to the digit that the interval makes sure."""
    half = (interval[1] - interval[0]) / 2.0
    decimals = MOST_DECIMALS
    if half > 0.0:
        decimals = min(max(ceil(-log10(half)) + 1, 1), MOST_DECIMALS)
    # Rounded first: a low end of -1e-9 is 0.0, not -0.0.
    texts = [f"{round(x, decimals) + 0.0:.{decimals}f}" for x in (value, *interval)]
    return texts[0], f"[{texts[1]}, {texts[2]}]"
