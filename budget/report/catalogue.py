"""Devices as they are listed and shown: sections, and JSON."""

from __future__ import annotations

from textwrap import shorten
from typing import TYPE_CHECKING, Any

from budget.names import words
from budget.report.blocks import Field, Listing, Pairs, Paragraph, Section, table_of
from budget.report.document import json_text
from budget.report.inputs import sensor_blocks, unused_table
from budget.results import SCHEMA
from budget.spec.files import bare_name
from budget.studies.grades import completeness, grade, kind_of_device

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Block
    from budget.spec.records import Device, Sensor

TEXTS = ("source", "vendor", "technology", "price", "mass", "power", "range", "notes")
REMARKS = ("includes", "horizon", "definition", "condition", "source")
LONGEST = 40  # characters of a technology in the list, in its maker's words


def list_sections(devices: Sequence[Device]) -> tuple[Section, ...]:
    """Return a row for each device: what it is and how much its data sheet tells."""
    fields: tuple[Field[Device], ...] = (
        Field(head="device", cell=lambda device: device.name),
        Field(head="name", cell=lambda device: bare_name(device.origin.file)),
        Field(head="kind", cell=kind_of_device),
        Field(
            head="grade",
            cell=lambda device: "/".join(map(grade, device.sensors)),
        ),
        Field(
            head="lines",
            cell=lambda device: " ".join(map(str, map(completeness, device.sensors))),
        ),
        Field(
            head="technology",
            cell=lambda device: shorten(device.technology or "-", LONGEST),
        ),
    )
    text = (
        "grade: gyros by bias stability (navigation below 0.01, tactical below 10 "
        "deg/h), accelerometers by bias repeatability (below 100 ug, below 5 mg), "
        "gyro/accelerometer of an IMU; -: the line is not given. lines: expected lines "
        "given out of expected. name: what every command takes as DEVICE."
    )
    table = table_of(devices, fields, name="devices", caption="Devices")
    blocks = (table, Paragraph(words=(text,), small=True))
    return (Section(name="devices", title="", blocks=blocks),)


def device_sections(device: Device) -> tuple[Section, ...]:
    """Return every specification value of a device: meaning and source."""
    said = [("file", device.origin.file)]
    said += [(name, " ".join(getattr(device, name).split())) for name in TEXTS]
    assumed = tuple((text,) for text in device.assumptions)
    return (
        Section(
            name="device",
            title=f"{device.name} ({kind_of_device(device)})",
            blocks=(Pairs(rows=tuple((key, (text,)) for key, text in said if text)),),
        ),
        *(_sensor_section(sensor) for sensor in device.sensors),
        Section(
            name="figures",
            title="Printed, not budgeted",
            blocks=(unused_table(device),) if device.figures else (),
            in_brief=None if device.figures else "Printed, not budgeted: none",
        ),
        Section(
            name="assumptions",
            title="Assumptions",
            blocks=(Listing(items=assumed, empty=""),),
            in_brief=None if assumed else "Assumptions: none",
        ),
    )


def _sensor_section(sensor: Sensor) -> Section:
    """Return the lines of one triad, then what it does not give."""
    absent = ", ".join(words(name.quantity) for name in sensor.not_given)
    missing = ", ".join(words(name.quantity) for name in sensor.expected_missing)
    rows = (
        ("not given", absent),
        ("expected", f"{missing}: no verdict `meets`" if missing else ""),
    )
    blocks: list[Block] = [*sensor_blocks(sensor, assumptions=())]
    if absent or missing:
        kept = tuple((key, (text,)) for key, text in rows if text)
        blocks.append(Pairs(rows=kept))
    return Section(
        name=sensor.kind,
        title=(
            f"{sensor.kind.capitalize()}: {completeness(sensor)} expected lines, "
            f"grade {grade(sensor)}"
        ),
        blocks=tuple(blocks),
    )


def list_to_json(devices: Sequence[Device]) -> str:
    """Write the list as JSON."""
    return _dump({"devices": [_head(device) for device in devices]})


def device_to_json(device: Device) -> str:
    """Write one device as JSON: values as printed and as standard uncertainties."""
    return _dump(
        {
            "device": {
                **_head(device),
                "source": device.source,
                "notes": device.notes,
                "range": device.range,
                "sensors": [_sensor(sensor) for sensor in device.sensors],
                "figures": [
                    {
                        "name": value.name,
                        "value": value.value,
                        "condition": value.condition,
                        "meaning": value.meaning,
                        "source": value.source,
                    }
                    for value in device.figures
                ],
                "assumptions": list(device.assumptions),
            }
        }
    )


def _head(device: Device) -> dict[str, Any]:
    """Return what the list and the single device have in common."""
    return {
        "name": device.name,
        "file": device.origin.file,
        "sha256": device.origin.sha256,
        "kind": kind_of_device(device),
        "technology": device.technology,
        "vendor": device.vendor,
        "price": device.price,
        "mass": device.mass,
        "power": device.power,
        "grades": {sensor.kind: grade(sensor) for sensor in device.sensors},
        "completeness": {
            sensor.kind: {
                "given": completeness(sensor).given,
                "expected": completeness(sensor).expected,
            }
            for sensor in device.sensors
        },
    }


def _sensor(sensor: Sensor) -> dict[str, Any]:
    """Return one triad: its lines, and what is not given."""
    return {
        "sensor": sensor.kind,
        "lines": [
            {
                "line": line.name,
                "printed": line.printed,
                "meaning": line.meaning,
                "unit": line.unit,
                "standard_uncertainty": (line.u / line.si_per_unit).tolist(),
                "correlation_time": None
                if line.correlation_time is None
                else line.correlation_time.tolist(),
                "distributions": [shape.name for shape in line.distributions],
                **{name: getattr(line, name) for name in REMARKS},
            }
            for line in sensor.lines
        ],
        "not_given": list(sensor.not_given),
        "expected_missing": list(sensor.expected_missing),
    }


def _dump(content: dict[str, Any]) -> str:
    """Write a document of schema `budget/1`."""
    return json_text({"schema": SCHEMA, "command": "devices", **content})
