"""A new device file: the lines that are given, all others as comments to fill in."""

from __future__ import annotations

import re
from textwrap import wrap
from typing import TYPE_CHECKING

from budget.errors import CallError
from budget.inputs.checking import nearest
from budget.inputs.device import read_device
from budget.inputs.makers import MEANINGS, PAGE, UNITS, printed_as
from budget.inputs.ranges import IS
from budget.inputs.reader import parse
from budget.inputs.specification import HALF_WIDTHS, SIGMAS
from budget.model.sources import SENSORS, lines_of
from budget.model.sources.later import AGEING
from budget.names import keys_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

BLANK = "___"  # in the place of a number: no file with one is valid
_PLAIN = re.compile(r"[\w.][^:#,\[\]{}\n]*[^:#,\[\]{}\s]|\w")


def split_line(text: str) -> tuple[str, str, str]:
    """Read SENSOR.LINE=VALUE; the value as a file has it, text or a mapping in braces.

    Raises
    ------
    CallError
        It has not that form. Whether there is such a line the file's own check says.
    """
    place, sign, value = (part.strip() for part in text.partition("="))
    sensor, *rest = keys_of(place)
    whole = sign and value and len(rest) == 1 and rest[0] and sensor in SENSORS
    if not (whole and text.isprintable()):
        hint = nearest(sensor, SENSORS) if rest and sensor not in SENSORS else ""
        raise CallError(
            f"--line {text!r}: expected SENSOR.SPEC=VALUE on one line, as "
            "gyro.bias_stability='0.5 deg/h' or "
            '"accelerometer.bias_repeatability={value: 1 mg, meaning: max}"; SENSOR '
            f"is {' or '.join(SENSORS)}{hint}"
        )
    return sensor, rest[0], value


def new_device(
    shown: str, name: str, source: str, lines: Mapping[tuple[str, str], str]
) -> str:
    """Return the text of a device file with those lines, by sensor and line.

    A sensor without a line is left as a comment, unless none has one.

    Raises
    ------
    CallError
        A text has a line break or what is no text.
    SpecError
        Something is wrong with a line, at its place in the file it would stand in.
    """
    for text in (name, source, *lines.values()):
        if not text.isprintable():
            raise CallError(
                f"found {text!r}, expected a name, a source or a value on one line"
            )
    given = {sensor for sensor, _ in lines}
    text = "\n".join(_text(name, source, lines, given or set(SENSORS))) + "\n"
    document = parse(text.encode(), shown, base_name=shown)
    read_device(document)
    return text


def _text(
    name: str, source: str, lines: Mapping[tuple[str, str], str], sensors: set[str]
) -> Iterator[str]:
    """Yield the lines of a device file."""
    yield "# A device: what its data sheet prints, as printed."
    yield f"# How to read a data sheet: {PAGE}; units: {UNITS}"
    yield "# Check with: budget validate FILE"
    yield f"# To give one remove its '#' and put the value for {BLANK}; where more is"
    yield "# printed: {value: ___ ppm, meaning: typical, condition: 25 °C}. Meanings:"
    yield f"# {', '.join([*SIGMAS, *HALF_WIDTHS])}: {MEANINGS}"
    yield "format: budget-device/1"
    yield f"name: {scalar(name)}"
    yield f"source: {scalar(source)}" if source else "# source: document, revision"
    yield "# vendor:"
    yield "# technology: FOG, RLG, MEMS, ..."
    yield "# gravity_unit: 9.80708 m/s^2 # where g is not 9.80665 m/s^2"
    yield f"# range: {{gyro: {BLANK} deg/s, accelerometer: {BLANK} g}} # {IS}"
    for sensor in SENSORS:
        off = "" if sensor in sensors else "# "
        mine = {line: value for (own, line), value in lines.items() if own == sensor}
        yield f"{off}{sensor}:"
        empty = "" if mine or off else " {} # the first one takes the place of {}"
        yield f"{off}  errors:{empty}"
        known = {line.name: line for line in lines_of(sensor)}
        for line, source_line in known.items():
            words = f"{source_line.model}; {printed_as(line)}"
            yield from wrap(
                words,
                88,
                initial_indent="    # ",
                subsequent_indent="    #   ",
                break_on_hyphens=False,
            )
            if line in mine:
                yield f"    {line}: {_value(mine[line])}"
            else:
                blank = f"{BLANK} {source_line.like(sensor)}"
                if line in AGEING.values():
                    blank = f"{{value: {blank}, horizon: {BLANK} year}}"
                yield f"    # {line}: {blank}"
        for line in mine.keys() - known.keys():
            yield f"    {scalar(line)}: {_value(mine[line])}"
    yield "# Printed values that are no specification of the model:"
    yield "# figures:"
    yield "#   - {name: gyro.bandwidth, value: 262 Hz, condition: configurable}"


def _value(text: str) -> str:
    """Return a value as YAML: a mapping in braces as it is, or a text."""
    return text if text.startswith("{") else scalar(text)


def scalar(text: str) -> str:
    """Return a text as a YAML scalar."""
    if _PLAIN.fullmatch(text) and not re.fullmatch(r"[\d.eE+-]+|true|false|null", text):
        return text
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
