"""Inputs section: specification values of the data sheets, and the procedure."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

from budget.calibration.mission import on_the_way
from budget.inputs.station import IDEAL
from budget.inputs.use import LINES
from budget.model.sources import source_of
from budget.names import Name
from budget.report.blocks import Abreast
from budget.report.figures.allan import Allan, allan_plot
from budget.report.figures.attitudes import Positions, positions_plot
from budget.report.figures.rows import chart_picture
from budget.report.figures.timeline import (
    made_of,
    make_tracks,
    print_time,
    schedule_chart,
)
from budget.report.pages import section, sections
from budget.report.standing import parted
from budget.report.tables import print_given
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Device, ErrorLine, Procedure, Sensor
    from budget.report.blocks import Section
    from budget.studies.blunders import Blunder, BlunderError


NOMINAL_BIAS = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}
LATITUDE_DIGITS = 7


@dataclass(frozen=True, kw_only=True)
class InputRow:
    """A line of a data sheet or a station as the model takes it."""

    line: ErrorLine
    varies: bool  # whether it is no known value
    assumed: tuple[tuple[str, str], ...]  # axis, '' for all, and what of it


@dataclass(frozen=True, kw_only=True)
class DataSheet:
    """The data sheet of one triad."""

    sensor: Sensor
    unit: str  # of the bias
    bias: Array
    angle: Array  # [arcsec]
    rows: tuple[InputRow, ...]


def inputs_section(
    devices: Sequence[Device],
    procedure: Procedure,
    *,
    absent: Sequence[str] = (),
    assumed: Sequence[str] = (),
    parted: Callable[[str], tuple[str, str]] = parted,
    full: bool = True,
) -> Section:
    """Return every value that the budget is made of, and in full those that it is not.

    What is absent, and assumed, as far as it does not stand on page one.
    """
    triads = [
        sensor
        for device in devices
        for sensor in on_the_way(device.sensors, procedure)[0]
    ]
    return section(
        "inputs",
        full=full,
        absent=absent,
        assumed=assumed,
        parted=parted,
        devices=devices,
        drawn=noise_pictures(triads, procedure) if full else None,
        sheets=[
            data_sheet(sensor, device.assumptions)
            for device in devices
            for sensor in on_the_way(device.sensors, procedure)[0]
        ],
        name=procedure.name,
        shared=[
            (owner, _rows(owner, [*filter(_counts, lines)], procedure.assumptions))
            for owner, lines in procedure.shared.items()
        ],
    )


def noise_pictures(sensors: Sequence[Sensor], procedure: Procedure) -> Abreast | None:
    """Show the noise of triads by averaging time; None where no sheet gives any."""
    every = (Allan.of(sensor, procedure) for sensor in sensors)
    found = tuple(allan_plot(one).picture for one in every if one is not None)
    return Abreast(blocks=found) if found else None


def _counts(line: ErrorLine) -> bool:
    """Whether a line is more than a use that is stated to be that of the test."""
    return bool(line.u.any()) or line.name not in LINES


def data_sheet(sensor: Sensor, assumptions: Sequence[str] = ()) -> DataSheet:
    """Return the data sheet of one triad, with what was assumed of its lines."""
    unit, size = NOMINAL_BIAS[sensor.kind]
    return DataSheet(
        sensor=sensor,
        unit=unit,
        bias=sensor.nominal_bias / size,
        angle=sensor.nominal_mounting_angle / ARCSEC,
        rows=_rows(sensor.kind, (*sensor.lines, *sensor.initial), assumptions),
    )


def _rows(
    owner: str, lines: Sequence[ErrorLine], assumptions: Sequence[str]
) -> tuple[InputRow, ...]:
    """Return the lines of one owner, each with what was assumed of it."""
    assumed = [parted(text) for text in assumptions]
    rows = []
    for line in lines:
        source = source_of(owner, line.name)
        axes: dict[str, str] = {
            Name(line.name, owner=owner, axis=axis): axis for axis in ("", *source.axes)
        }
        own = tuple((axes[key], text) for key, text in assumed if key in axes)
        rows.append(InputRow(line=line, varies=source.meant(line).varies, assumed=own))
    return tuple(rows)


def procedure_section(
    procedure: Procedure, sensors: Sequence[str], *, full: bool = True
) -> Section:
    """Return the procedure in words and its positions; in full its schedule."""
    schedule = schedule_chart(procedure, sensors) if full else None
    positions = Positions.of(procedure, sensors)
    return section(
        "procedure",
        procedure=procedure,
        sensors=sensors,
        tracks=make_tracks(procedure, sensors) if procedure.windows else (),
        schedule=None if schedule is None else chart_picture(schedule),
        positions=None if positions is None else positions_plot(positions).picture,
        made_of=made_of,
        print_time=print_time,
        degrees=print_degrees,
        IDEAL=IDEAL,
    )


def print_degrees(angle: float) -> str:
    """Print an angle of the procedure [rad] in degrees."""
    return print_given(degrees(angle), digits=LATITUDE_DIGITS)


def blunders_sections(
    costs: Sequence[tuple[Blunder, Sequence[BlunderError]]],
) -> tuple[Section, ...]:
    """Say what mistakes about the place would add to the outputs; () without any."""
    return sections("mistakes", costs=costs)
