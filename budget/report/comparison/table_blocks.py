"""The tables of a comparison as blocks: ranking, outputs, fronts, pairs, procedures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.comparison.fronts import merit_points
from budget.report.comparison.tables import (
    PAIRS_SHOWN,
    print_at_most,
    print_output,
    side_by_side,
)
from budget.report.tables import (
    AT_LEAST,
    PER_CENT,
    key_title,
    output_title,
    print_given,
    print_probability,
    print_utilisation,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.names import Name
    from budget.report.comparison.tables import Row
    from budget.report.comparison.tables import Table as Devices
    from budget.report.comparison.wording import MissingEffect
    from budget.results import OutputAssessment
    from budget.studies.comparison.records import Comparison, Pair

LONG = 8  # rows from which a table is worth searching
FEW = 2  # devices that are named, even where they are all
DASH = "\N{EN DASH}"  # a factor that is not there


def ranking_table(devices: Devices, name: str) -> Table:
    """Return the devices with one sensor under one procedure, best first."""
    rows = devices.rows
    has_intervals = any(row.interval for row in rows)
    has_missing = any(row.missing for row in rows)
    columns = [
        Column(head="device", weight=2.0),
        Column(head="rank", kind="number"),
        Column(head="verdict"),
        Column(head="% of limit", kind="number"),
        *([Column(head="sampling interval", weight=1.3)] if has_intervals else ()),
        Column(head="conformance [%]", kind="number"),
        Column(head="worst output", weight=1.3),
        Column(head="limited by", weight=1.5),
        Column(head="factor", kind="number"),
    ]
    if has_missing:
        columns += [
            Column(head="missing", kind="number"),
            Column(head="at worst [% of limit]"),
        ]
    return Table(
        name=name,
        caption=f"Ranking of the {devices.sensor} devices",
        columns=tuple(columns),
        groups=(
            RowGroup(
                rows=tuple(
                    _ranked(row, intervals=has_intervals, missing=has_missing)
                    for row in rows
                )
            ),
        ),
        is_wide=True,
        searchable=len(rows) >= LONG,
    )


def ranking_note(devices: Devices) -> str:
    """Say what the columns of the ranking mean."""
    text = (
        "Best first; = marks neighbours that cannot be told apart at 95 %. "
        "Conformance: probability that all required outputs are within their limits "
        "together. Factor: times this, the standard uncertainty of the limiting "
        "source alone would bring the worst output to its limit, by the law; "
        f"{DASH}: it alone cannot."
    )
    if any(row.missing for row in devices.rows):
        text += (
            " Missing: expected lines that the data sheet does not give; they count as "
            f"0, so that the error is this or more ({AT_LEAST}), and one stops a "
            "'meets'. At worst: with the worst of the catalogue of the same technology "
            "and grade in their place; ?: there is none, and nothing is known."
        )
    return text


def outputs_table(devices: Devices, name: str) -> Table:
    """Return the part of each limit that each device uses: the data of the map."""
    heads = (output.output.name for output in devices.rows[0].of.outputs)
    return Table(
        name=name,
        caption="Largest error in % of the limit, devices by outputs",
        columns=(
            Column(head="device"),
            *(Column(head=_output_head(head), kind="number") for head in heads),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (Cell(text=row.device), *map(_part_of_limit, row.of.outputs))
                    for row in devices.rows
                )
            ),
        ),
        is_wide=True,
        searchable=len(devices.rows) >= LONG,
    )


def front_table(devices: Devices, merit: str, name: str) -> Table:
    """Return cost and part of the limit of each device: the data of a front."""
    points = merit_points(devices, merit)
    return Table(
        name=name,
        caption=f"{merit} and part of the limit, cheapest first",
        columns=(
            Column(head="device", weight=1.6),
            Column(head=f"{merit} [{points[0][1].unit}]", kind="number"),
            Column(head="% of limit", kind="number"),
            Column(head="verdict"),
            Column(head="on the front"),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (
                        Cell(text=row.device),
                        Cell(text=print_given(amount.value), exact=amount.value),
                        _utilisation(row),
                        Cell(text=row.verdict),
                        Cell(text="yes" if merit in row.of.on_front else "no"),
                    )
                    for row, amount in points
                )
            ),
        ),
    )


def pairs_table(pairs: Sequence[Pair]) -> Table:
    """Return the best pairs of a gyro and an accelerometer."""
    several = len({pair.procedure for pair in pairs}) > 1
    return Table(
        name="pairs-table",
        caption="Pairs of gyro and accelerometer, best first",
        columns=(
            Column(head="gyro", weight=1.6),
            Column(head="accelerometer", weight=1.6),
            *([Column(head="procedure")] if several else ()),
            Column(head="verdict"),
            Column(head="% of limit", kind="number"),
            Column(head="conformance [%]", kind="number"),
        ),
        groups=(
            RowGroup(
                rows=tuple(_pair(pair, several=several) for pair in pairs[:PAIRS_SHOWN])
            ),
        ),
        is_wide=True,
        searchable=len(pairs) >= LONG,
    )


def procedures_table(
    comparison: Comparison, found: Sequence[Devices], sensor: str
) -> Table:
    """Return one sensor of every device under every procedure."""
    rows = side_by_side(found, sensor)
    return Table(
        name=f"procedures-{sensor}",
        caption=f"{sensor} devices by procedure: % of the limit and verdict",
        columns=(
            Column(head="device", weight=1.6),
            *(Column(head=name) for name in comparison.procedures),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (Cell(text=row.device), *(Cell(text=text) for text in row.cells))
                    for row in rows
                )
            ),
        ),
        is_wide=True,
        searchable=len(rows) >= LONG,
    )


def assumptions_table(comparison: Comparison, name: str) -> Table:
    """Return what the files leave to be assumed, alike ones in one row.

    An assumption reads 'device: figure: what is assumed'; those of a procedure or of
    the requirement name no device.
    """
    names = sorted({one.name for one in comparison.devices}, key=len, reverse=True)
    gathered: dict[tuple[str, str], list[str]] = {}
    for text in comparison.assumptions:
        device = next((name for name in names if text.startswith(f"{name}: ")), "")
        rest = text.removeprefix(f"{device}: ") if device else text
        figure, _, assumed = rest.partition(": ")
        gathered.setdefault((figure, assumed), []).append(device)
    alike: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for (figure, assumed), devices in gathered.items():
        alike.setdefault((assumed, tuple(devices)), []).append(figure)
    return Table(
        name=name,
        caption="Assumptions in the files",
        columns=(
            Column(head="figure", weight=1.2),
            Column(head="assumed", weight=2.0),
            Column(head="of", weight=2.0),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (
                        Cell(text=", ".join(map(_figure, figures))),
                        Cell(text=assumed),
                        Cell(text=_owners(devices, len(names))),
                    )
                    for (assumed, devices), figures in alike.items()
                )
            ),
        ),
        is_wide=True,
        searchable=len(alike) >= LONG,
    )


def missing_table(effects: Sequence[MissingEffect]) -> Table:
    """Return what is put in the place of lines that are not given."""
    return Table(
        name="missing-table",
        caption="What 'at worst' puts in the place of expected lines not given",
        columns=(
            Column(head="sensor", weight=0.7),
            Column(head="devices", weight=1.5),
            Column(head="in the place of what is missing", weight=2.5),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (
                        Cell(text=row.sensor),
                        Cell(text=", ".join(row.devices)),
                        Cell(text=row.effect),
                    )
                    for row in effects
                )
            ),
        ),
        is_wide=True,
        searchable=len(effects) >= LONG,
    )


def _figure(name: str) -> str:
    """Name a figure of a file: 'gyro bias stability'."""
    return key_title(name)


def _owners(devices: Sequence[str], number: int) -> str:
    """Name the devices that an assumption is of; many that are all, as such."""
    named = [name for name in devices if name]
    if len(named) == number > FEW:
        return f"all {number} devices"
    return ", ".join(named)


def _output_head(name: Name) -> str:
    """Name an output above a narrow column: 'angle xy'."""
    return output_title(name.without_owner).removeprefix("mounting ")


def _ranked(row: Row, *, intervals: bool, missing: bool) -> tuple[Cell, ...]:
    """Return one row of the ranking."""
    of, meets = row.of, row.verdict == "meets"
    cells = [
        Cell(
            text=row.device,
            strong=meets,
            note="lines missing" if row.missing else "",
        ),
        Cell(text=row.rank, exact=float(row.rank.rstrip("="))),
        Cell(text=row.verdict, strong=meets),
        _utilisation(row),
        *([Cell(text=row.interval)] if intervals else ()),
        Cell(text=row.conformance, exact=PER_CENT * of.conformance.value),
        Cell(text=row.worst_output),
        Cell(text=row.limiting_source),
        Cell(text=row.factor or DASH, exact=of.remedy.factor),
    ]
    if missing:
        number = float(row.missing) if row.missing else None
        cells += [Cell(text=row.missing, exact=number), Cell(text=row.at_worst)]
    return tuple(cells)


def _utilisation(row: Row) -> Cell:
    """Return the part of the limit that a device uses."""
    return Cell(text=row.utilisation, exact=PER_CENT * row.of.utilisation)


def _part_of_limit(output: OutputAssessment) -> Cell:
    """Return the part of one limit that one device uses; beyond it in bold."""
    part = output.utilisation
    return Cell(
        text=print_output(output),
        exact=PER_CENT * part,
        strong=not output.is_within,
    )


def _pair(pair: Pair, *, several: bool) -> tuple[Cell, ...]:
    """Return one pair."""
    part = print_utilisation(pair.utilisation).removesuffix(" %")
    said = print_probability(pair.conformance)
    if pair.lower_bound:
        part, said = f"{AT_LEAST} {part}", print_at_most(pair.conformance)
    return (
        Cell(text=pair.gyro, strong=pair.verdict == "meets"),
        Cell(text=pair.accelerometer, strong=pair.verdict == "meets"),
        *([Cell(text=pair.procedure)] if several else ()),
        Cell(text=pair.verdict),
        Cell(text=part, exact=PER_CENT * pair.utilisation),
        Cell(
            text=said,
            exact=PER_CENT * pair.conformance.value,
        ),
    )
