"""A device as a file: its lines as 1 sigma, all digits, in the units that they had."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.errors import SpecError
from budget.inputs.device import read_device
from budget.inputs.reader import parse
from budget.inputs.records import ANGLES, AXES
from budget.inputs.specification import (
    ALLAN_MINIMUM,
    EXACT,
    HALF_WIDTHS,
    MEANING_READINGS,
    OVER_TEMPERATURE,
    divisor,
    time_of,
)
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
    from budget.inputs.records import ErrorLine, Sensor

LONGEST_NAME = 200  # characters, of a device file
LONGEST_NOTES = 4000
# On both sides of a size, for one who changes sizes. Texts are quoted, and quoting
# escapes control characters: no text of a device can hold this one.
MARK = "\x02"
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
    text = [
        "format: budget-device/1",
        f"name: {_quote(name[:LONGEST_NAME])}",
        f"source: {_quote(source[:LONGEST_NAME])}",
        f"notes: {_quote(notes[:LONGEST_NOTES])}",
    ]
    if technology:
        text.append(f"technology: {_quote(technology)}")
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
        if sensor.lines or sensor.initial:
            text.append("  errors:")
            text += [
                f"    {line.name}: {_figure(line, gravity, mark)}"
                for line in sensor.lines
            ]
            text += [
                f"    {line.name}: {_figure(line, gravity, '')}"
                for line in sensor.initial
            ]
    return "\n".join(text) + "\n"


def _figure(line: ErrorLine, gravity: float, mark: str) -> str:
    """Write one line: a text where nothing but a value has to be said."""
    axes = ANGLES if line.u.size == len(ANGLES) else AXES
    one = parse_quantity(f"1 {line.unit}", line.unit, gravity=gravity)
    size = one.si_per_unit * WALK_PER_DENSITY[line.density] * line.factor
    opened = _open(line)
    sizes = [float(u) / size * opened.factor for u in line.u]
    values = [_quantity(one, line.unit, mark) for one in sizes]
    shapes = [opened.shape or shape.name for shape in line.distributions]
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
            ("horizon", line.horizon and _quote(line.horizon)),
            *opened.says,
        )
        if text and key not in opened.unsaid
    }
    if not line.u.any():
        whole["meaning"] = EXACT  # else it would be no line
    if line.horizons[:-1]:
        earlier = (
            {
                "value": _quantity(sizes[0] * part, line.unit, mark),
                "horizon": _quantity(time, "s"),
            }
            for time, part in line.horizons[:-1]
        )
        whole["earlier"] = f"[{', '.join(map(_mapping, earlier))}]"
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


@dataclass(frozen=True, kw_only=True)
class _Opened:
    """What a line whose meaning is open says in place of 1 sigma."""

    factor: float = 1.0  # printed over the standard uncertainty that is taken [1]
    shape: str = ""  # of all axes, as a file that says none would have it: NORMAL
    says: tuple[tuple[str, str], ...] = ()
    unsaid: frozenset[str] = frozenset()  # keys that would close it


def _open(line: ErrorLine) -> _Opened:
    """Return what an open line says: its size as printed, and the readings of it.

    The line is the largest of its readings.
    """
    if not line.readings:
        return _Opened()
    taken = next(word for word, one in line.readings if np.array_equal(one.u, line.u))
    factor = divisor(line.meaning, line.distributions[0])
    if taken == "allan_minimum" and line.correlation_time is not None:
        factor *= ALLAN_MINIMUM
    # A shape that is not that of the meaning stands in the file.
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
    words = [word for word, _ in line.readings]
    says = [("reading", f"[{', '.join(words)}]")]
    if taken not in MEANING_READINGS:
        says.append(("meaning", line.meaning))
    return _Opened(
        factor=factor,
        shape=told[0] if told else NORMAL.name,
        says=tuple(says),
        unsaid=frozenset({"density"} if line.density in words else ())
        | frozenset({"definition"} if "allan_minimum" in words else ()),
    )


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
    return (
        read.technology == technology
        and [one.kind for one in read.sensors] == [one.kind for one in sensors]
        and all(map(_is_same_sensor, read.sensors, sensors))
    )


def _is_same_sensor(one: Sensor, other: Sensor) -> bool:
    """Whether two triads have one budget."""
    return (
        _is_near(one.nominal_bias, other.nominal_bias)
        and _is_near(one.nominal_mounting_angle, other.nominal_mounting_angle)
        and one.expected_missing == other.expected_missing
        and all(
            len(own) == len(others) and all(map(_is_same, own, others))
            for own, others in (
                (one.lines, other.lines),
                (one.initial, other.initial),
            )
        )
    )


def _is_same(one: ErrorLine, other: ErrorLine) -> bool:
    """Whether two lines are one source, of one size, under every reading."""

    def words(line: ErrorLine) -> tuple[object, ...]:
        time = time_of(line.horizon)
        return (
            *(line.name, line.distributions, line.form, line.adds_to),
            *(line.density if line.readings else "", len(line.horizons)),
            *(None if time is None else time.value, [w for w, _ in line.readings]),
        )

    return (
        words(one) == words(other)
        and _is_near(one.u, other.u)
        and _is_near(one.correlation_time, other.correlation_time)
        and _is_near(one.low_cut, other.low_cut)
        and _is_near(np.array(one.horizons), np.array(other.horizons))
        and all(
            _is_same(read, wanted)
            for (_, read), (_, wanted) in zip(one.readings, other.readings, strict=True)
        )
    )


def _is_near(one: Array | None, other: Array | None) -> bool:
    """Whether numbers are the same but for their last digits."""
    if one is None or other is None:
        return one is other
    return one.shape == other.shape and np.allclose(one, other, rtol=SAME, atol=0.0)


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
    return f'"{mark}{value!r}{mark} {_quote(unit)[1:]}'


def _mapping(items: dict[str, str]) -> str:
    """Write a flow mapping; the values are written already."""
    return "{" + ", ".join(f"{key}: {text}" for key, text in items.items()) + "}"


def _quote(text: str) -> str:
    """Quote a text as YAML 1.2 and JSON both do."""
    return json.dumps(text, ensure_ascii=False)
