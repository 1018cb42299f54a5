"""An allocation for programs: CSV, and the allocated device as a file."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from budget.distributions import NORMAL
from budget.report.document import csv_text
from budget.report.tables import print_coverage
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
    from budget.studies.allocation.records import Allocation


COLUMNS = (
    *("sensor", "source", "unit", "status", "now", "allowed", "uncorrected"),
    *("binding_output", "at_ceiling", "at_least", "ceiling", "least"),
    *("headroom", "stopped_by", "best_offered", "counts"),
)


def allocation_csv(allocation: Allocation) -> str:
    """Write one row for each source, values in the units of the file."""
    return csv_text(COLUMNS, (_row(one.to_dict()) for one in allocation.sources))


def allocated_device(allocation: Allocation) -> str:
    """Write the allocated device as a device file.

    Raises
    ------
    ValueError
        The requirement cannot be met, so there is none.
    """
    if not allocation.feasible:
        raise ValueError("an infeasible requirement has no allocated device")
    basis = "; ".join(
        f"{file.role} {file.name} sha256 {file.sha256}" for file in allocation.inputs
    )
    notes = (
        f"Allocated by budget allocate, strategy {allocation.strategy}, to meet "
        f"{allocation.requirement} at coverage {print_coverage(allocation.coverage)} %,"
        f" error reference {allocation.reference}, by procedure {allocation.procedure},"
        f" formulas {allocation.formulas}. Made from {basis}."
    )
    if any(check.is_corrected for check in allocation.checks):
        notes += (
            " Corrected by Monte Carlo, for which the law is not good enough here: "
            "analyse it with --method monte-carlo."
        )
    if allocation.assumptions:
        notes += f" Assumed: {'; '.join(allocation.assumptions)}."
    return device_yaml(
        allocation.sensors,
        name=f"{allocation.title[:150]}, allocated for {allocation.requirement[:30]}",
        source="budget allocate",
        notes=notes,
    )


def _row(entry: dict[str, Any]) -> dict[str, Any]:
    """Return one entry of `sources` without a nest, as columns have it."""
    room = entry["headroom"] or {}
    return {
        **entry,
        "headroom": room.get("value"),
        "stopped_by": room.get("stopped_by"),
    }


LONGEST_NAME = 200  # characters, of a device file
LONGEST_NOTES = 4000


def device_yaml(
    sensors: Sequence[Sensor], *, name: str, source: str, notes: str
) -> str:
    """Write a device file in YAML 1.2: 1 sigma, all digits, units as they were.

    The sensors are of one device file, one at least and at most one of a kind. Lines
    that a sensor does not give stay away, so they are not given there either.
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
                f"    {line.name}: {_figure(line, gravity)}" for line in sensor.lines
            ]
    return "\n".join(text) + "\n"


def _figure(line: ErrorLine, gravity: float) -> str:
    """Write one line: a text where nothing but a value has to be said."""
    axes = ANGLES if line.u.size == len(ANGLES) else AXES
    one = parse_quantity(f"1 {line.unit}", line.unit, gravity=gravity)
    size = one.si_per_unit * WALK_PER_DENSITY[line.density] * line.factor
    values = [_quantity(float(u) / size, line.unit) for u in line.u]
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


def _quantity(value: float, unit: str) -> str:
    """Write a quantity with all its digits, never as YAML would read otherwise."""
    return _quote(f"{value!r} {unit}")


def _mapping(items: dict[str, str]) -> str:
    """Write a flow mapping; the values are written already."""
    return "{" + ", ".join(f"{key}: {text}" for key, text in items.items()) + "}"


def _quote(text: str) -> str:
    """Quote a text as YAML 1.2 and JSON both do."""
    return json.dumps(text, ensure_ascii=False)
