"""The figures of the data sheets: as printed, as meant, as the model takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.model.sources import ENVIRONMENT, SENSORS, STATION, source_of
from budget.names import Name
from budget.report.blocks import (
    Cell,
    Column,
    Panel,
    Paragraph,
    RowGroup,
    Section,
    Table,
)
from budget.report.tables import print_given, words
from budget.report.wording import first_up, texts, without_empty
from budget.spec.records import ANGLES, AXES
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.report.blocks import Block
    from budget.spec.records import Device, ErrorLine, Procedure, Sensor

NOMINAL_BIAS = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}
FIGURE_HEADS = ("figure", "as printed", "meaning", "condition", "source")
ABOUT = ("vendor", "technology", "range", "price", "mass", "power", "notes", "source")


def inputs_section(devices: Sequence[Device], procedure: Procedure) -> Section:
    """Return every figure that the budget is made of, and those that it is not."""
    panels = [
        _sensor_panel(sensor, device.assumptions)
        for device in devices
        for sensor in device.sensors
    ]
    panels += [
        Panel(
            title=f"{procedure.name}: {owner}",
            blocks=(
                without_empty(
                    _lines_table(owner, procedure.name, lines, procedure.assumptions)
                ),
            ),
        )
        for owner, lines in (
            (STATION, procedure.station),
            (ENVIRONMENT, procedure.environment),
        )
        if lines
    ]
    panels += [panel for device in devices for panel in _about(device)]
    return Section(name="inputs", title="Inputs", blocks=tuple(panels))


def print_by_axis(values: Array) -> str:
    """Write one number where the axes agree, else each with its axis."""
    printed = [print_given(float(value)) for value in values]
    if len(set(printed)) == 1:
        return printed[0]
    names = AXES if len(printed) == len(AXES) else ANGLES
    pairs = zip(names, printed, strict=True)
    return ", ".join(f"{name} {text}" for name, text in pairs)


def _sensor_panel(sensor: Sensor, assumptions: Sequence[str]) -> Panel:
    """Return the data sheet of one triad."""
    unit, scale = NOMINAL_BIAS[sensor.kind]
    nominal = (
        f"Nominal bias {print_by_axis(sensor.nominal_bias / scale)} {unit}; nominal "
        f"mounting angle {print_by_axis(sensor.nominal_mounting_angle / ARCSEC)} "
        "arcsec."
    )
    blocks: list[Block] = [Paragraph(words=(nominal,), small=True)]
    if sensor.lines:
        blocks.append(
            without_empty(
                _lines_table(sensor.kind, sensor.device, sensor.lines, assumptions)
            )
        )
    else:
        text = "The data sheet gives no line that the model uses."
        blocks.append(Paragraph(words=(text,)))
    return Panel(title=f"{sensor.device}: {sensor.kind}", blocks=tuple(blocks))


def _lines_table(
    owner: str, of: str, lines: Sequence[ErrorLine], assumptions: Sequence[str]
) -> Table:
    """Return the lines of one owner, each with what was assumed of it."""
    sheet = "Data sheet" if owner in SENSORS else "Lines"
    return Table(
        name=f"inputs-{owner}",
        caption=f"{sheet} of the {owner} {of}",
        columns=(
            Column(head="line", weight=1.4),
            Column(head="as printed, meaning", weight=1.2),
            Column(head="u, distribution", weight=3.0),
            Column(head="condition", weight=1.6),
            Column(head="source", weight=1.2),
            Column(head="assumed", weight=1.6),
        ),
        groups=(
            RowGroup(rows=tuple(_line_row(line, owner, assumptions) for line in lines)),
        ),
        is_wide=True,
        searchable=True,
    )


def _line_row(
    line: ErrorLine, owner: str, assumptions: Sequence[str]
) -> tuple[Cell, ...]:
    """Return one line of a data sheet."""
    meaning = line.meaning
    if line.definition:
        meaning += f", {words(line.definition)}"
    shape = ", ".join(dict.fromkeys(d.name for d in line.distributions))
    if line.correlation_time is not None:
        shape += f", correlation time {print_by_axis(line.correlation_time)} s"
    conditions = [
        line.condition,
        f"includes {line.includes}" if line.includes else "",
        f"over {line.horizon}" if line.horizon else "",
    ]
    key = Name(line.name, owner=owner)
    of_axis: dict[str, str] = {
        Name(line.name, owner=owner, axis=axis): f"{axis}: "
        for axis in source_of(owner, line.name).axes
        if axis
    }
    notes = [text.partition(": ") for text in assumptions]
    assumed = [
        of_axis.get(start, "") + note
        for start, _, note in notes
        if start == key or start in of_axis
    ]
    return (
        Cell(text=words(line.name)),
        Cell(text=line.printed, note=meaning),
        Cell(
            text=f"{print_by_axis(line.u / line.si_per_unit)} {line.unit}", note=shape
        ),
        *texts("; ".join(filter(None, conditions)), line.source, "; ".join(assumed)),
    )


def _about(device: Device) -> Iterator[Panel]:
    """Yield what moves no number: figures no model uses, what the device is."""
    blocks: list[Block] = []
    if device.figures:
        blocks.append(without_empty(_figures_table(device)))
    said = [(label, getattr(device, label).rstrip(" .")) for label in ABOUT]
    lines = "; ".join(f"{label} {text}" for label, text in said if text)
    if lines:
        blocks.append(Paragraph(words=(f"{first_up(lines)}.",), small=True))
    if blocks:
        title = "printed, not budgeted" if device.figures else "the device"
        yield Panel(title=f"{device.name}: {title}", blocks=tuple(blocks))


def _figures_table(device: Device) -> Table:
    """Return what the maker prints and no model uses."""
    return Table(
        name=f"not-budgeted-{device.origin.sha256[:8]}",
        caption=f"Figures of {device.name} that no model uses",
        columns=tuple(Column(head=head) for head in FIGURE_HEADS),
        groups=(
            RowGroup(
                rows=tuple(
                    texts(
                        words(figure.name),
                        figure.value,
                        figure.meaning,
                        figure.condition,
                        figure.source,
                    )
                    for figure in device.figures
                )
            ),
        ),
        is_wide=True,
        searchable=True,
    )
