"""Devices as they are listed and shown: sections, and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.documents import written
from budget.inputs.files import bare_name
from budget.inputs.records import Device
from budget.missing.grades import (
    completeness,
    grade,
    kind_of_device,
)
from budget.report.inputs import data_sheet
from budget.report.pages import sections

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Section

TEXTS = ("source", "vendor", "technology", "price", "mass", "power", "range", "notes")


def list_sections(devices: Sequence[Device]) -> tuple[Section, ...]:
    """Return a row for each device: what it is and how much its data sheet tells."""
    return _sections(
        "devices",
        devices=devices,
        bare_name=bare_name,
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


written(
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
    grades (dict[str, str]): by triad, 'navigation', 'tactical', 'consumer' or '-'
    completeness as completeness (dict[str, Completeness]): by triad
    """,
    kind=kind_of_device,
    grades=lambda device: {one.kind: grade(one) for one in device.sensors},
    completeness=lambda device: {one.kind: completeness(one) for one in device.sensors},
)(Device)
written(
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
)(Device)
written(
    "device_list",
    """
    devices = self as listed_device (tuple[Device, ...])
    """,
    said="One device file, one variant of it.",
    commands="devices",
)(tuple)
written(
    "one_device",
    """
    device = self as device (Device)
    """,
    commands="devices",
)(Device)
