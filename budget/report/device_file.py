"""A device as a file: its lines as 1 sigma, all digits, in the units that they had."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.errors import SpecError
from budget.inputs.changes import EXACT
from budget.inputs.device import read_device
from budget.inputs.reader import parse
from budget.inputs.records import ANGLES, AXES
from budget.inputs.specification import (
    ALLAN_MINIMUM,
    HALF_WIDTHS,
    MEANING_READINGS,
    OVER_TEMPERATURE,
    divisor,
    time_of,
)
from budget.inputs.tree import block, flow, quoted
from budget.model.sources import GYRO
from budget.units import (
    ARCSEC,
    DEG_PER_HOUR,
    DEGREE,
    STANDARD_GRAVITY,
    WALK_PER_DENSITY,
    parse_quantity,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.inputs.records import ErrorLine, Sensor

LONGEST_NAME = 200  # characters, of a device file
LONGEST_NOTES = 4000
# On both sides of a size, for one who changes sizes. Texts are quoted, and quoting
# escapes control characters: no text of a device can hold this one.
MARK = "\x02"
ROUNDED = 2e-15  # relative difference that a conversion of units leaves
SAME = 1e-12  # relative difference of numbers that are the same, written and read back


def device_yaml(
    sensors: Sequence[Sensor],
    *,
    name: str,
    source: str,
    notes: str,
    technology: str = "",
    mark: str = "",
) -> str:
    """Write a device file in YAML 1.2: 1 sigma, all digits, units as they were.

    The sensors are of one device file, one at least and at most one of a kind. Lines
    that a sensor does not give stay away, so they are not given there either. A mark
    (MARK) stands on both sides of every size of a line. A line whose meaning is open
    stays open.
    """
    units = [sensor.gravity_unit for sensor in sensors]
    # Of two files one may have its own g: the new one has it for both.
    gravity = next((g for g in units if g != STANDARD_GRAVITY), STANDARD_GRAVITY)
    texts = (
        ("name", name[:LONGEST_NAME]),
        ("source", source[:LONGEST_NAME]),
        ("notes", notes[:LONGEST_NOTES]),
        *((("technology", technology),) if technology else ()),
    )
    own = [("gravity_unit", _quantity(gravity, "m/s^2"))]
    entries = [
        ("format", "budget-device/1"),
        *((key, quoted(text)) for key, text in texts),
        *(own if gravity != STANDARD_GRAVITY else []),
        *((sensor.kind, _triad(sensor, gravity, mark)) for sensor in sensors),
    ]
    return "\n".join(block(entries)) + "\n"


def _triad(
    sensor: Sensor, gravity: float, mark: str
) -> list[tuple[str, str | list[tuple[str, str]]]]:
    """Return what a device file says of one triad."""
    bias = ("deg/h", DEG_PER_HOUR) if sensor.kind == "gyro" else ("mg", 1e-3 * gravity)
    nominal = [
        ("bias", _nominal(sensor.nominal_bias, AXES, *bias)),
        (
            "mounting_angle",
            _nominal(sensor.nominal_mounting_angle, ANGLES, "arcsec", ARCSEC),
        ),
    ]
    errors = [
        *((line.name, _figure(line, gravity, mark)) for line in sensor.lines),
        *((line.name, _figure(line, gravity, "")) for line in sensor.initial),
    ]
    read = ("deg/s", DEGREE) if sensor.kind == GYRO else ("g", gravity)
    reaches = [] if sensor.range is None else [_nominal(sensor.range, AXES, *read)]
    return [
        *(("range", one) for one in reaches),
        ("nominal", nominal),
        *([("errors", errors)] if errors else []),
    ]


def _figure(line: ErrorLine, gravity: float, mark: str) -> str:
    """Write one line: a text where nothing but a value has to be said.

    A line whose meaning is open has its size as printed, and its readings, of which it
    is the largest.
    """
    words = [word for word, _ in line.readings]
    same = (word for word, one in line.readings if np.array_equal(one.u, line.u))
    taken = next(same, "")
    one = parse_quantity(f"1 {line.unit}", line.unit, gravity=gravity)
    size = one.si_per_unit * WALK_PER_DENSITY[line.density] * line.factor
    # Printed over the standard uncertainty that is taken [1].
    opened = divisor(line.meaning, line.distributions[0]) if words else 1.0
    if taken == "allan_minimum" and line.correlation_time is not None:
        opened *= ALLAN_MINIMUM
    sizes = [float(u) / size * opened for u in line.u]
    values = [_quantity(one, line.unit, mark) for one in sizes]
    shapes = [shape.name for shape in line.distributions]
    if words:
        shapes = [_shape_said(line)] * line.u.size
    times = [""] * line.u.size
    if line.correlation_time is not None:
        times = [_quantity(float(time), "s") for time in line.correlation_time]
    few = line.degrees_of_freedom or (None,)
    own = [
        _given(
            distribution="" if shape == NORMAL.name else shape,
            correlation_time=at,
            degrees_of_freedom=f"{v:.15g}" if v else "",
        )
        for shape, at, v in zip(
            shapes, times, few * (line.u.size // len(few)), strict=True
        )
    ]
    # Of one figure of all axes they are of all together.
    is_common = len(few) == 1 and all(says == own[0] for says in own)
    common = own[0] if is_common else {}
    if common or not any(own):
        own = [{} for _ in own]
    says = _given(
        density="" if line.density in words else line.density,
        adds_to=line.adds_to,
        **{
            key: text
            for key, text in line.says
            if not (key == "definition" and "allan_minimum" in words)
        },
    ) | _given(
        horizon=line.horizon and quoted(line.horizon),
        reading=flow(words) if words else "",
        # Of a 0: else it would be no line.
        meaning=EXACT
        if not line.u.any()
        else line.meaning
        if words and taken not in MEANING_READINGS
        else "",
        earlier=flow(
            [
                {
                    "value": _quantity(sizes[0] * part, line.unit, mark),
                    "horizon": _quantity(time, "s"),
                }
                for time, part in line.horizons[:-1]
            ]
        )
        if line.horizons[:-1]
        else "",
    )
    if len(set(values)) == 1 and not any(own):
        whole = {"value": values[0], **common, **says}
        return flow(whole) if common or says else values[0]
    axes = ANGLES if line.u.size == len(ANGLES) else AXES
    by_axis = {
        axis: {"value": value, **more} if more else value
        for axis, value, more in zip(axes, values, own, strict=True)
    }
    return flow({**common, **says, "axes": by_axis})


def _given(**says: str) -> dict[str, str]:
    """Return what is said."""
    return {key: text for key, text in says.items() if text}


def _shape_said(line: ErrorLine) -> str:
    """Return the shape that an open line says: one that is not that of the meaning."""
    told = [
        shape.name
        for _, one in line.readings
        for shape in one.distributions[:1]
        if (
            line.correlation_time is None
            and (shape.name == NORMAL.name) == (one.meaning in HALF_WIDTHS)
        )
        or shape.name not in {NORMAL.name, "uniform"}
    ]
    return told[0] if told else NORMAL.name


def is_read_back(text: str, sensors: Sequence[Sensor], *, technology: str = "") -> bool:
    """Whether a device file that was written, without marks, is of these sensors.

    In all that decides a budget: sizes, shapes, times, laws, what is open and what is
    not given.
    """
    # What a temperature leaves stands under another key, which no file says here.
    if any(OVER_TEMPERATURE in dict(x.readings) for s in sensors for x in s.lines):
        return False
    try:
        read = read_device(parse(text.encode(), "changed", base_name="changed"))
    except SpecError:
        return False
    own, others = (tuple(map(_triad_says, some)) for some in (read.sensors, sensors))
    return read.technology == technology and _is_same(own, others)


def _triad_says(sensor: Sensor) -> tuple[object, ...]:
    """Return what of a triad decides a budget."""
    return (
        *(sensor.kind, sensor.nominal_bias, sensor.nominal_mounting_angle),
        *(sensor.range, sensor.expected_missing),
        tuple(map(_line_says, sensor.lines)),
        tuple(map(_line_says, sensor.initial)),
    )


def _line_says(line: ErrorLine) -> tuple[object, ...]:
    """Return what of a line decides a budget, under every reading."""
    time = time_of(line.horizon)
    return (
        *(line.name, line.distributions, line.form, line.adds_to),
        *(line.density if line.readings else "", None if time is None else time.value),
        *(line.u, line.correlation_time, line.low_cut, np.array(line.horizons)),
        line.degrees_of_freedom,
        np.array(list(line.own.values())),
        tuple((word, _line_says(one)) for word, one in line.readings),
    )


def _is_same(one: object, other: object) -> bool:
    """Whether two are the same but for last digits of numbers."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        is_alike = one.shape == other.shape
        return is_alike and np.allclose(one, other, rtol=SAME, atol=0.0)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    return type(one) is type(other) and one == other


def _nominal(values: Array, axes: tuple[str, ...], unit: str, size: float) -> str:
    """Write nominal values, one text where the axes agree."""
    texts = [_quantity(float(value) / size, unit) for value in values]
    if len(set(texts)) == 1:
        return texts[0]
    return flow(dict(zip(axes, texts, strict=True)))


def _quantity(value: float, unit: str, mark: str = "") -> str:
    """Write a quantity, to what rounding leaves, never as YAML would read otherwise."""
    short = float(f"{value:.13g}")
    if abs(short - value) <= ROUNDED * abs(value):
        value = short
    return f'"{mark}{value!r}{mark} {quoted(unit)[1:]}'
