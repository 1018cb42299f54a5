"""Devices as they are listed and shown: sections, and JSON."""

from __future__ import annotations

from textwrap import shorten
from typing import TYPE_CHECKING, Any

from budget.inputs.files import bare_name
from budget.report.document import json_text
from budget.report.inputs import data_sheet
from budget.report.pages import sections
from budget.results import SCHEMA
from budget.studies.grades import completeness, grade, kind_of_device

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device, Sensor
    from budget.report.blocks import Section

TEXTS = ("source", "vendor", "technology", "price", "mass", "power", "range", "notes")
REMARKS = ("includes", "horizon", "definition", "condition", "source")
LONGEST = 40  # characters of a technology in the list, in its maker's words


def list_sections(devices: Sequence[Device]) -> tuple[Section, ...]:
    """Return a row for each device: what it is and how much its data sheet tells."""
    return _sections(
        "devices",
        devices=devices,
        bare_name=bare_name,
        short=lambda text: shorten(text, LONGEST),
    )


def device_sections(device: Device) -> tuple[Section, ...]:
    """Return every specification value of a device: meaning and source."""
    return _sections(
        "device",
        device=device,
        sheets=[data_sheet(one) for one in device.sensors],
        TEXTS=TEXTS,
    )


def _sections(page: str, **view: object) -> tuple[Section, ...]:
    """Return the sections of a page about devices."""
    return sections(
        page, kind_of=kind_of_device, grade=grade, completeness=completeness, **view
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
