"""A device as a file: its lines as 1 sigma, all digits, in the units that they had."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from budget.distributions import NORMAL
from budget.spec.records import ANGLES, AXES
from budget.units import (
    ARCSEC,
    DEG_PER_HOUR,
    STANDARD_GRAVITY,
    WALK_PER_DENSITY,
    parse_quantity,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.spec.records import ErrorLine, Sensor

LONGEST_NAME = 200  # characters, of a device file
LONGEST_NOTES = 4000


def device_yaml(
    sensors: Sequence[Sensor], *, name: str, source: str, notes: str, mark: str = ""
) -> str:
    """Write a device file in YAML 1.2: 1 sigma, all digits, units as they were.

    The sensors are of one device file, one at least and at most one of a kind. Lines
    that a sensor does not give stay away, so they are not given there either. A mark
    stands on both sides of every size of a line, for one who changes sizes.
    """
    text = [
        "format: budget-device/1",
        f"name: {_quote(name[:LONGEST_NAME])}",
        f"source: {_quote(source[:LONGEST_NAME])}",
        f"notes: {_quote(notes[:LONGEST_NOTES])}",
    ]
    units = [sensor.gravity_unit for sensor in sensors]
    # Of two files one may have its own g: the new one has it for both.
    gravity = next((g for g in units if g != STANDARD_GRAVITY), STANDARD_GRAVITY)
    if gravity != STANDARD_GRAVITY:
        text.append(f"gravity_unit: {_quantity(gravity, 'm/s^2')}")
    for sensor in sensors:
        text += [f"{sensor.kind}:", "  nominal:"]
        unit, size = "deg/h", DEG_PER_HOUR
        if sensor.kind != "gyro":
            unit, size = "mg", 1e-3 * gravity
        text.append(f"    bias: {_nominal(sensor.nominal_bias, AXES, unit, size)}")
        angles = _nominal(sensor.nominal_mounting_angle, ANGLES, "arcsec", ARCSEC)
        text.append(f"    mounting_angle: {angles}")
        if sensor.lines:
            text.append("  errors:")
            text += [
                f"    {line.name}: {_figure(line, gravity, mark)}"
                for line in sensor.lines
            ]
    return "\n".join(text) + "\n"


def _figure(line: ErrorLine, gravity: float, mark: str) -> str:
    """Write one line: a text where nothing but a value has to be said."""
    axes = ANGLES if line.u.size == len(ANGLES) else AXES
    one = parse_quantity(f"1 {line.unit}", line.unit, gravity=gravity)
    size = one.si_per_unit * WALK_PER_DENSITY[line.density] * line.factor
    values = [_quantity(float(u) / size, line.unit, mark) for u in line.u]
    shapes = [shape.name for shape in line.distributions]
    times: list[float | None] = [None] * line.u.size
    if line.correlation_time is not None:
        times = [float(time) for time in line.correlation_time]
    common = {
        key: text
        for key, text in _says(shapes[0], times[0]).items()
        if len(set(shapes)) == len(set(times)) == 1
    }
    whole = {
        key: text
        for key, text in (
            *(("density", line.density), ("adds_to", line.adds_to)),
            *line.says,
        )
        if text
    }
    own = [
        {} if common else _says(shape, time)
        for shape, time in zip(shapes, times, strict=True)
    ]
    if len(set(values)) == 1 and not any(own):
        if not common and not whole:
            return values[0]
        return _mapping({"value": values[0], **common, **whole})
    by_axis = {
        axis: _mapping({"value": value, **more}) if more else value
        for axis, value, more in zip(axes, values, own, strict=True)
    }
    return _mapping({**common, **whole, "axes": _mapping(by_axis)})


def _says(shape: str, time: float | None) -> dict[str, str]:
    """Return what has to be said of an axis besides its value."""
    says = {}
    if shape != NORMAL.name:
        says["distribution"] = shape
    if time is not None:
        says["correlation_time"] = _quantity(time, "s")
    return says


def _nominal(values: Array, axes: tuple[str, ...], unit: str, size: float) -> str:
    """Write nominal values, one text where the axes agree."""
    texts = [_quantity(float(value) / size, unit) for value in values]
    if len(set(texts)) == 1:
        return texts[0]
    return _mapping(dict(zip(axes, texts, strict=True)))


def _quantity(value: float, unit: str, mark: str = "") -> str:
    """Write a quantity with all its digits, never as YAML would read otherwise."""
    return _quote(f"{mark}{value!r}{mark} {unit}")


def _mapping(items: dict[str, str]) -> str:
    """Write a flow mapping; the values are written already."""
    return "{" + ", ".join(f"{key}: {text}" for key, text in items.items()) + "}"


def _quote(text: str) -> str:
    """Quote a text as YAML 1.2 and JSON both do."""
    return json.dumps(text, ensure_ascii=False)
