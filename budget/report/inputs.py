"""Inputs section: specification values of the data sheets, and the procedure."""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING

from budget.calibration.mission import on_the_way
from budget.inputs.records import ANGLES, AXES
from budget.inputs.station import IDEAL
from budget.language import Note, say, term, words
from budget.model.sources import ENVIRONMENT, SENSORS, STATION, source_of
from budget.names import Name
from budget.report.blocks import Cell, Field, Pairs, Panel, Paragraph, Section, table_of
from budget.report.figures.rows import chart_picture
from budget.report.figures.timeline import (
    made_of,
    make_tracks,
    print_time,
    schedule_chart,
)
from budget.report.tables import print_given
from budget.report.wording import capital, parted
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Device, ErrorLine, Procedure, Sensor, UnusedValue
    from budget.report.blocks import Block, Table, Words
    from budget.studies.blunders import Blunder, Offset


NOMINAL_BIAS = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}
ABOUT = (
    *(term("vendor"), term("technology"), term("range"), term("price"), term("mass")),
    *(term("power"), term("notes"), term("source")),
)


def inputs_section(devices: Sequence[Device], procedure: Procedure) -> Section:
    """Return every value that the budget is made of, and those that it is not."""
    panels = [
        Panel(
            title=say("{device}: {kind}", device=sensor.device, kind=say(sensor.kind)),
            blocks=tuple(sensor_blocks(sensor, device.assumptions)),
        )
        for device in devices
        for sensor in on_the_way(device.sensors, procedure)[0]
    ]
    panels += [
        Panel(
            title=say("{name}: {owner}", name=procedure.name, owner=say(owner)),
            blocks=(lines_table(owner, procedure.name, lines, procedure.assumptions),),
        )
        for owner, lines in (
            (STATION, procedure.station),
            (ENVIRONMENT, procedure.environment),
        )
        if lines
    ]
    panels += [panel for device in devices for panel in _about(device)]
    return Section(name="inputs", title=say("Inputs"), blocks=tuple(panels))


def print_by_axis(values: Array) -> str:
    """Write one number where the axes agree, else each with its axis."""
    printed = [print_given(float(value)) for value in values]
    if len(set(printed)) == 1:
        return printed[0]
    names = AXES if len(printed) == len(AXES) else ANGLES
    pairs = zip(names, printed, strict=True)
    return say(", ").join(f"{name} {text}" for name, text in pairs)


def sensor_blocks(sensor: Sensor, assumptions: Sequence[str]) -> Iterator[Block]:
    """Yield the data sheet of one triad."""
    unit, scale = NOMINAL_BIAS[sensor.kind]
    nominal = say(
        "Nominal bias {nominal_bias} {unit}; nominal mounting "
        "angle {nominal_mounting_angle} arcsec.",
        nominal_bias=print_by_axis(sensor.nominal_bias / scale),
        unit=unit,
        nominal_mounting_angle=print_by_axis(sensor.nominal_mounting_angle / ARCSEC),
    )
    yield Paragraph(words=(nominal,), small=True)
    if lines := (*sensor.lines, *sensor.initial):
        yield lines_table(sensor.kind, sensor.device, lines, assumptions)
    else:
        text = say("The data sheet gives no line that the model uses.")
        yield Paragraph(words=(text,))


def lines_table(
    owner: str, of: str, lines: Sequence[ErrorLine], assumptions: Sequence[str]
) -> Table:
    """Return the lines of one owner, each with what was assumed of it."""
    sheet = say("Data sheet") if owner in SENSORS else say("Lines")
    assumed = [parted(text) for text in assumptions]
    fields: tuple[Field[ErrorLine], ...] = (
        Field(head=say("line"), weight=1.4, cell=lambda line: words(line.name)),
        Field(head=say("as printed, meaning"), weight=1.2, cell=_printed),
        Field(
            head=say("u, distribution"),
            weight=3.0,
            cell=lambda line: _standard(line, owner),
        ),
        Field(head=say("condition"), weight=1.6, cell=_conditions),
        Field(head=say("source"), weight=1.2, cell=lambda line: line.source),
        Field(
            head=say("assumed"),
            weight=1.6,
            cell=lambda line: _assumed(line, owner, assumed),
        ),
    )
    return table_of(
        lines,
        [replace(field, optional=True) for field in fields],
        name=f"inputs-{owner}",
        caption=say(
            "{sheet} of the {owner} {of}", sheet=sheet, owner=say(owner), of=of
        ),
        is_wide=True,
        searchable=True,
    )


def _printed(line: ErrorLine) -> Cell:
    """Return a value as it is printed, and what it means."""
    meaning = line.meaning
    if line.definition:
        meaning += say(", {definition}", definition=words(line.definition))
    return Cell(text=line.printed, note=meaning)


def _standard(line: ErrorLine, owner: str) -> Cell:
    """Return the standard uncertainty and its distribution, as the model takes them."""
    shape = say(", ").join(dict.fromkeys(say(d.name) for d in line.distributions))
    if not source_of(owner, line.name).meant(line).varies:
        shape = say("fixed")
    if line.correlation_time is not None:
        shape += say(
            ", correlation time {correlation_time} s",
            correlation_time=print_by_axis(line.correlation_time),
        )
    u = print_by_axis(line.u / line.si_per_unit)
    return Cell(text=f"{u} {line.unit}", note=shape)


def _conditions(line: ErrorLine) -> str:
    """Return under which conditions a value holds."""
    conditions = [
        # What stands for a line that no maker prints is said, a maker's text is not.
        say(line.condition) if isinstance(line.condition, Note) else line.condition,
        say("includes {includes}", includes=line.includes) if line.includes else "",
        say("over {horizon}", horizon=line.horizon) if line.horizon else "",
    ]
    return say("; ").join(filter(None, conditions))


def _assumed(
    line: ErrorLine, owner: str, assumptions: Sequence[tuple[str, str]]
) -> str:
    """Return what was assumed of a line, or of an axis of it."""
    key = Name(line.name, owner=owner)
    of_axis: dict[str, str] = {
        Name(line.name, owner=owner, axis=axis): say("{axis}: ", axis=axis)
        for axis in source_of(owner, line.name).axes
        if axis
    }
    return say("; ").join(
        of_axis.get(start, "") + note
        for start, note in assumptions
        if start == key or start in of_axis
    )


def _about(device: Device) -> Iterator[Panel]:
    """Yield what moves no number: values no model uses, what the device is."""
    blocks: list[Block] = []
    if device.figures:
        blocks.append(unused_table(device))
    said = [(label, getattr(device, label).rstrip(" .")) for label in ABOUT]
    lines = say("; ").join(f"{say(label)} {text}" for label, text in said if text)
    if lines:
        blocks.append(
            Paragraph(words=(say("{lines}.", lines=capital(lines)),), small=True)
        )
    if blocks:
        title = say("printed, not budgeted") if device.figures else say("the device")
        yield Panel(
            title=say("{name}: {title}", name=device.name, title=title),
            blocks=tuple(blocks),
        )


def unused_table(device: Device) -> Table:
    """Return what the maker prints and no model uses."""
    fields: tuple[Field[UnusedValue], ...] = (
        Field(head=say("specification"), cell=lambda value: words(value.name)),
        Field(head=say("as printed"), cell=lambda value: value.value),
        Field(head=say("meaning"), cell=lambda value: value.meaning),
        Field(head=say("condition"), cell=lambda value: value.condition),
        Field(head=say("source"), cell=lambda value: value.source),
    )
    return table_of(
        device.figures,
        [replace(field, optional=True) for field in fields],
        name=f"not-budgeted-{device.origin.sha256[:8]}",
        caption=say(
            "Specification values of {name} that no model uses", name=device.name
        ),
        is_wide=True,
        searchable=True,
    )


FORMULAS = {
    "corrected": (term("formulas"), term("corrected")),
    "paper": (
        term("formulas"),
        term("as the paper prints eq. (4) for the gyro bias, all others corrected"),
    ),
    "least_squares": (term("estimator"), term("least squares, every window alike")),
    "weighted": (
        term("estimator"),
        term("least squares, weighted by the device's noise, station and environment"),
    ),
    "norm": (
        term("estimator"),
        term("norm of gravity, at attitudes that nobody knows"),
    ),
}
LATITUDE_DIGITS, GRAVITY_DIGITS = 7, 8


def procedure_section(procedure: Procedure, sensors: Sequence[str]) -> Section:
    """Return the procedure in words, and drawn; of the sensors that are there."""
    rows: list[tuple[str, Words]] = [
        (
            say("place"),
            (
                (
                    say(
                        "latitude {latitude} deg, gravity {gravity} m/s^2",
                        latitude=print_degrees(procedure.latitude),
                        gravity=print_given(procedure.gravity, digits=GRAVITY_DIGITS),
                    )
                ),
            ),
        ),
        (
            say("pulses"),
            (
                say(
                    "read at {sample_rate} Hz",
                    sample_rate=print_given(procedure.sample_rate),
                ),
            ),
        ),
    ]
    if procedure.windows:
        rows += [
            (
                say(track.sensor),
                (
                    say(
                        "{made_of}, in {end}",
                        made_of=made_of(track),
                        end=print_time(track.end),
                    ),
                ),
            )
            for track in make_tracks(procedure, sensors)
        ]
    elif "gyro" in sensors:
        rows += _gyro_rows(procedure)
    if "accelerometer" in sensors and not procedure.windows:
        dwell = print_given(procedure.accelerometer.dwell)
        pause = _pause(procedure.accelerometer.pause)
        text = say("twelve positions, {dwell} s each{pause}", dwell=dwell, pause=pause)
        rows.append((say("accelerometer"), (text,)))
    name, text = FORMULAS[procedure.formulas]
    stands = say("they stand") if name == "formulas" else say("it stands")
    rows.append(
        (
            say(name),
            (say("{text}; {stands} under Method", text=say(text), stands=stands),),
        )
    )
    rows.append((say(STATION), (_station(procedure),)))
    blocks: tuple[Block, ...] = (Pairs(rows=tuple(rows)),)
    schedule = schedule_chart(procedure, sensors)
    if schedule is not None:
        blocks += (chart_picture(schedule),)
    return Section(name="procedure", title=say("Procedure"), blocks=blocks)


def _station(procedure: Procedure) -> str:
    """Say what station the test is done at, in one line."""
    origin = procedure.station_origin
    file = say(" ({file})", file=origin.file) if origin else ""
    if not procedure.station:
        said = say("given as ideal{file}", file=file)
        if IDEAL in procedure.assumptions:
            said = say("none is given, an ideal one is assumed")
        return say(
            "{said}: no error of table, place or timing is in this budget", said=said
        )
    return say(
        "{station} figures{file}; their shares stand under Test station",
        station=len(procedure.station),
        file=file,
    )


def print_degrees(angle: float) -> str:
    """Print an angle of the procedure [rad] in degrees."""
    return print_given(degrees(angle), digits=LATITUDE_DIGITS)


def _gyro_rows(procedure: Procedure) -> list[tuple[str, Words]]:
    """Return the rate turns and the static test."""
    gyro = procedure.gyro
    azimuths = say(", ").join(print_degrees(azimuth) for azimuth in gyro.azimuths)
    static = say(
        "{dwell} s at each azimuth {azimuths} deg",
        dwell=print_given(gyro.dwell),
        azimuths=azimuths,
    )
    if not gyro.azimuths:
        static = say(
            "in the twelve positions of the accelerometers, each axis up and down"
        )
    return [
        (
            say("gyro, rate turns"),
            (
                (
                    say(
                        "1 turn at {rate} deg/s, forward and back about {order}"
                        if gyro.turns == 1
                        else "{turns} turns at {rate} deg/s, forward and back about "
                        "{order}",
                        turns=gyro.turns,
                        rate=print_degrees(gyro.rate),
                        order=say(", ").join(gyro.order),
                    )
                ),
            ),
        ),
        (
            say("gyro, static"),
            (f"{static}{_pause(gyro.pause)}",),
        ),
    ]


def _pause(pause: float) -> str:
    """Say how long the pauses are, where there are any [s]."""
    return (
        say("; pause {pause} s between all windows", pause=print_given(pause))
        if pause
        else ""
    )


def blunders_sections(
    costs: Sequence[tuple[Blunder, Sequence[Offset]]],
) -> tuple[Section, ...]:
    """Say what mistakes about the place would add to the outputs; () without any."""
    if not costs:
        return ()
    rows = [
        (say(one.text) if offset is moved[0] else "", offset)
        for one, moved in costs
        for offset in moved
    ]
    name = "blunders"
    fields: tuple[Field[tuple[str, Offset]], ...] = (
        Field(head=say("mistake"), cell=lambda row: row[0]),
        Field(head=say("output"), cell=lambda row: row[1].name),
        Field(head=say("adds"), cell=lambda row: row[1].printed),
    )
    title = say("What a mistake about the place would add (calibrated minus true)")
    table = table_of(rows, fields, name=f"{name}-table", caption=title)
    return (Section(name=name, title=title, blocks=(table,)),)
