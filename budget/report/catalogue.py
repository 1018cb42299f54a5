"""Devices as they are listed and shown: tables on a terminal, and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.report.document import json_text
from budget.report.tables import print_given, words
from budget.report.terminal import GAP, Page
from budget.results import SCHEMA
from budget.spec.records import ANGLES, AXES
from budget.studies.grades import completeness, grade, kind_of_device

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from budget.arrays import Array
    from budget.spec.records import Device, ErrorLine, Sensor

HEADS = ("device", "file", "kind", "grade", "lines", "technology")
LABEL = 14  # columns for the names of what a line is
TEXTS = ("source", "vendor", "technology", "price", "mass", "power", "range", "notes")
REMARKS = ("includes", "horizon", "definition", "condition", "source")
SHORTEST = 10  # characters that the last column keeps at least


def render_list(devices: Sequence[Device], console: Console) -> None:
    """Print one line for each device: what it is and how much its data sheet tells."""
    page = Page(console)
    head, *lines = _left((HEADS, *(_listed(device) for device in devices)))
    # The technology stands last, in the makers' words, which may be many.
    room = max(page.width, head.index(HEADS[-1]) + SHORTEST)
    page.line(head[:room], style="bold")
    for line in lines:
        page.line(line[:room])
    page.line()
    page.paragraph(
        "grade: gyros by bias stability (navigation below 0.01, tactical below 10 "
        "deg/h), accelerometers by bias repeatability (below 100 ug, below 5 mg), "
        "gyro/accelerometer of an IMU; -: the line is not given. lines: expected lines "
        "given out of expected."
    )


def render_device(device: Device, console: Console) -> None:
    """Print every figure of a device with what it means and where it is from."""
    page = Page(console)
    page.line(f"{device.name} ({kind_of_device(device)})", style="bold")
    page.paragraph(device.origin.file, first=f"{'file':<{LABEL}}")
    for name in TEXTS:
        text = getattr(device, name)
        if text:
            page.paragraph(" ".join(text.split()), first=f"{name:<{LABEL}}")
    for sensor in device.sensors:
        page.line()
        _print_sensor(sensor, page)
    page.line()
    _print_figures(device, page)
    page.line()
    page.line(
        "Assumptions" if device.assumptions else "Assumptions: none", style="bold"
    )
    for text in device.assumptions:
        page.paragraph(text, first="- ")


def list_to_json(devices: Sequence[Device]) -> str:
    """Write the list as JSON."""
    return _dump({"devices": [_head(device) for device in devices]})


def device_to_json(device: Device) -> str:
    """Write one device as JSON: figures as printed and as standard uncertainties."""
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
                        "name": figure.name,
                        "value": figure.value,
                        "condition": figure.condition,
                        "meaning": figure.meaning,
                        "source": figure.source,
                    }
                    for figure in device.figures
                ],
                "assumptions": list(device.assumptions),
            }
        }
    )


def _listed(device: Device) -> tuple[str, ...]:
    """Return the cells of one device in the list."""
    return (
        device.name,
        device.origin.file,
        kind_of_device(device),
        "/".join(grade(sensor) for sensor in device.sensors),
        " ".join(str(completeness(sensor)) for sensor in device.sensors),
        device.technology or "-",
    )


def _print_sensor(sensor: Sensor, page: Page) -> None:
    """Print the lines of one triad, then what it does not give."""
    page.line(
        f"{sensor.kind.capitalize()}: {completeness(sensor)} expected lines, "
        f"grade {grade(sensor)}",
        style="bold underline",
    )
    rows = [
        (words(line.name), line.printed, line.meaning, _u(line))
        for line in sensor.lines
    ]
    head, *lines = _left((("line", "printed", "meaning", "u"), *rows))
    if rows and len(head) <= page.width:
        page.line(head, style="bold")
        for text in lines:
            page.line(text)
    else:
        for name, printed, meaning, u in rows:
            page.paragraph(f"{printed}, {meaning}; u {u}", first=f"{name}: ")
    for line in sensor.lines:
        remarks = _remarks(line)
        if remarks:
            page.paragraph(remarks, first=f"- {words(line.name)}: ")
    missing = [name.quantity for name in sensor.expected_missing]
    absent = [name.quantity for name in sensor.not_given]
    if absent:
        page.paragraph(
            ", ".join(words(name) for name in absent), first=f"{'not given':<{LABEL}}"
        )
    if missing:
        page.paragraph(
            f"{', '.join(words(name) for name in missing)}: no verdict `meets`",
            first=f"{'expected':<{LABEL}}",
        )


def _left(rows: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """Set texts as columns, all flush left."""
    columns = [
        [text.ljust(max(len(other) for other in column)) for text in column]
        for column in zip(*rows, strict=True)
    ]
    return tuple((" " * GAP).join(cells) for cells in zip(*columns, strict=True))


def _remarks(line: ErrorLine) -> str:
    """Join what the maker adds to a figure, its source last."""
    named = [
        f"{name} {text}"
        for name in ("includes", "horizon", "definition")
        if (text := getattr(line, name))
    ]
    return "; ".join(
        [*named, *(text for text in (line.condition, line.source) if text)]
    )


def _print_figures(device: Device, page: Page) -> None:
    """Print what the maker prints and no model uses."""
    if not device.figures:
        page.line("Printed, not budgeted: none", style="bold")
        return
    page.line("Printed, not budgeted", style="bold")
    for figure in device.figures:
        remarks = "; ".join(
            text for text in (figure.meaning, figure.condition, figure.source) if text
        )
        page.paragraph(
            figure.value + (f" ({remarks})" if remarks else ""),
            first=f"- {words(figure.name)}: ",
        )


def _u(line: ErrorLine) -> str:
    """Print the standard uncertainties of a line in its own unit, by axis."""
    text = f"{_by_axis(line.u / line.si_per_unit)} {line.unit}"
    if line.correlation_time is not None:
        text += f", tau {_by_axis(line.correlation_time)} s"
    return text


def _by_axis(values: Array) -> str:
    """Write one number where the axes agree, else each with its axis."""
    texts = [print_given(float(value)) for value in values]
    if len(set(texts)) == 1:
        return texts[0]
    names = AXES if len(texts) == len(AXES) else ANGLES
    return ", ".join(f"{name} {text}" for name, text in zip(names, texts, strict=True))


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
