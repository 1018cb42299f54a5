"""Devices as they are listed and shown: sections, and JSON."""

from __future__ import annotations

from textwrap import shorten
from typing import TYPE_CHECKING

from budget.documents import document, form
from budget.inputs.files import bare_name
from budget.inputs.records import Device, ErrorLine, Sensor, UnusedValue
from budget.report.document import json_text
from budget.report.inputs import data_sheet
from budget.report.pages import sections
from budget.studies.grades import (
    Completeness,
    completeness,
    grade,
    kind_of_device,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Section

TEXTS = ("source", "vendor", "technology", "price", "mass", "power", "range", "notes")
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
    return json_text(document(devices, "device_list"))


def device_to_json(device: Device) -> str:
    """Write one device as JSON: values as printed and as standard uncertainties."""
    return json_text(document(device, "one_device"))


def _grades(device: Device) -> dict[str, str]:
    """Return the grades of its triads."""
    return {sensor.kind: grade(sensor) for sensor in device.sensors}


def _completeness(device: Device) -> dict[str, Completeness]:
    """Return of each triad how many of the expected lines are given."""
    return {sensor.kind: completeness(sensor) for sensor in device.sensors}


form(
    "completeness",
    """
    given: lines that a verdict 'meets' needs
    expected: that it needs
    """,
    Completeness,
    said="One triad of a device: its nominal values and the lines of its data sheet.",
)
form(
    "listed_device",
    """
    name
    file = origin.file: base name, with #VARIANT where one was chosen
    sha256 = origin.sha256: of its bytes
    kind: 'gyro', 'accelerometer' or 'IMU'
    technology: in the words of its maker
    vendor
    price
    mass
    power
    grades: by triad, 'navigation', 'tactical', 'consumer' or '-'
    completeness as completeness (dict[str, Completeness]): by triad
    """,
    Device,
    kind=kind_of_device,
    grades=_grades,
    completeness=_completeness,
)
form(
    "line",
    """
    line = name
    printed: as the file gives it
    meaning: how its number is meant, '1 sigma', 'max', ...
    unit: as the file gives it
    standard_uncertainty = u / si_per_unit (list[float]) [unit]: by axis
    correlation_time (list[float] | None) [s]: by axis; null of what has none
    distributions = distributions.name (list[str]): shapes by axis
    includes: what it covers, in the words of the maker
    horizon: after which time
    definition: of the maker
    condition: under which it holds
    source: where it is printed
    """,
    ErrorLine,
)
form(
    "sensor",
    """
    sensor = kind: 'gyro' or 'accelerometer'
    lines as line
    not_given: lines of the model that are absent
    expected_missing: those of them that a verdict 'meets' cannot do without
    """,
    Sensor,
)
form(
    "unused_value",
    """
    name
    value: as the file gives it
    condition: under which it holds
    meaning: how its number is meant
    source: where it is printed
    """,
    UnusedValue,
)
form(
    "device",
    """
    *self as listed_device
    source: where it all is printed
    notes
    range: the largest that its triads read, in words
    sensors as sensor
    figures as unused_value: values that no model uses
    assumptions
    """,
    Device,
)
DEVICE_LIST = form(
    "device_list",
    """
    devices = self as listed_device (tuple[Device, ...])
    """,
    tuple,
    said="One device file, one variant of it.",
    commands="devices",
)
ONE_DEVICE = form(
    "one_device",
    """
    device = self as device (Device)
    """,
    Device,
    commands="devices",
)
