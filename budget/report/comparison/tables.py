"""A comparison as texts: the tables that terminal and page share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from budget.report.tables import (
    AT_LEAST,
    AT_MOST,
    PER_CENT,
    Number,
    bound_number,
    join_outputs,
    print_probability,
    print_three,
    print_utilisation,
    round_value,
    source_title,
)
from budget.studies.comparison.records import VERDICTS, ranks

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.results import OutputAssessment, Probability
    from budget.studies.comparison.records import (
        Comparison,
        DeviceVerdict,
        MissingLines,
        Remedy,
    )

PAIRS_SHOWN = 20
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
    of: DeviceVerdict


@dataclass(frozen=True, kw_only=True)
class Table:
    """All devices with one sensor under one procedure."""

    sensor: str
    procedure: str
    rows: tuple[Row, ...]
    nothing_known: tuple[str, ...]  # devices with no error line: in no row

    @property
    def counts(self) -> str:
        """'2 meet, 1 undecided, 3 fail'."""
        verdicts = [row.of.verdict for row in self.rows]
        verdicts += ["undecidable"] * len(self.nothing_known)
        plural = {"meets": "meet", "fails": "fail"}
        return ", ".join(
            f"{verdicts.count(word)} {plural.get(word, word)}"
            for word in VERDICTS
            if word in verdicts
        )


@dataclass(frozen=True, kw_only=True)
class SideRow:
    """One sensor of one device under every procedure: '61.2 meets' for each."""

    device: str
    cells: tuple[str, ...]


def tables(
    comparison: Comparison, *, order: Callable[[Row], Any] | None = None
) -> tuple[Table, ...]:
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
            Table(
                sensor=sensor,
                procedure=procedure,
                rows=tuple(rows),
                nothing_known=unknown,
            )
        )
    return tuple(found)


def side_by_side(found: Sequence[Table], sensor: str) -> tuple[SideRow, ...]:
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
            cells=tuple(cells[row.of.place, table.procedure] for table in own),
        )
        for row in own[0].rows
    )


def _row(one: DeviceVerdict, rank: str) -> Row:
    """Write one row."""
    utilisation, interval = print_parts(one.utilisation, one.utilisation_interval)
    if one.lower_bound:
        utilisation = f"{AT_LEAST} {utilisation}"
    return Row(
        rank=rank,
        device=one.name,
        verdict=one.verdict,
        utilisation=utilisation,
        interval=interval,
        conformance=print_at_most(one.conformance)
        if one.lower_bound
        else print_probability(one.conformance),
        worst_output=join_outputs([name.without_owner for name in one.worst_outputs]),
        limiting_source=source_title(one.remedy.source, of=one.sensor),
        factor="" if one.lower_bound else print_factor(one.remedy),
        missing="" if one.missing is None else f"{len(one.missing.lines)}",
        at_worst=print_worst_case(one.missing),
        of=one,
    )


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
    return text, f"{ends[0]} to {ends[1]}"


def print_at_most(p: Probability) -> str:
    """Print a probability that lines not given can only lessen."""
    text = "100" if p.value == 1.0 else print_probability(p)
    return text if text.startswith("<") else f"{AT_MOST} {text}"


def print_output(row: OutputAssessment) -> str:
    """Print the part of its limit that an output uses, in per cent: '≥ 42.0', '?'."""
    used = Number(
        text=print_utilisation(row.utilisation).removesuffix(" %"),
        exact=row.utilisation,
    )
    return bound_number(used, lower_bound=row.lower_bound, unknown=row.is_unknown).text


def print_factor(remedy: Remedy) -> str:
    """Print what the u of the limiting source times which would just do; '' if none."""
    if remedy.factor is None:
        return ""
    if remedy.factor >= MOST_FACTOR:
        return f">{MOST_FACTOR:.0f}"
    return print_three(remedy.factor)


def print_worst_case(missing: MissingLines | None) -> str:
    """Print what the missing lines could do at worst: '198 fails', or '?'."""
    if missing is None:
        return ""
    if missing.utilisation is None:
        return "?"
    text = print_parts(missing.utilisation, (missing.utilisation,) * 2)[0]
    return f"{text} {missing.verdict}"
