"""A new device file: the lines that are given, all others as comments to fill in."""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING

from budget.errors import CallError
from budget.inputs.checking import nearest
from budget.inputs.device import read_device
from budget.inputs.makers import MEANINGS, PAGE, UNITS, printed_as
from budget.inputs.ranges import IS
from budget.inputs.reader import parse
from budget.inputs.specification import HALF_WIDTHS, SIGMAS
from budget.inputs.tree import block, scalar
from budget.model.sources import SENSORS, lines_of
from budget.model.sources.later import AGEING
from budget.names import keys_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

BLANK = "___"  # in the place of a number: no file with one is valid


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
    read_device(parse(text.encode(), shown, base_name=shown))
    return text


def _text(
    name: str, source: str, lines: Mapping[tuple[str, str], str], sensors: set[str]
) -> Iterator[str]:
    """Yield the lines of a device file."""
    yield from block(
        (
            "A device: what its data sheet prints, as printed.",
            f"How to read a data sheet: {PAGE}; units: {UNITS}",
            "Check with: budget validate FILE",
            f"To give one remove its '#' and put the value for {BLANK}; where more is",
            "printed: {value: ___ ppm, meaning: typical, condition: 25 °C}. Meanings:",
            f"{', '.join([*SIGMAS, *HALF_WIDTHS])}: {MEANINGS}",
            ("format", "budget-device/1"),
            ("name", scalar(name)),
            ("source", scalar(source)) if source else "source: document, revision",
            "vendor:",
            "technology: FOG, RLG, MEMS, ...",
            "gravity_unit: 9.80708 m/s^2 # where g is not 9.80665 m/s^2",
            f"range: {{gyro: {BLANK} deg/s, accelerometer: {BLANK} g}} # {IS}",
        )
    )
    for sensor in SENSORS:
        off = "" if sensor in sensors else "# "
        mine = {line: value for (own, line), value in lines.items() if own == sensor}
        yield f"{off}{sensor}:"
        empty = "" if mine or off else " {} # the first one takes the place of {}"
        yield f"{off}  errors:{empty}"
        yield from block(_errors(sensor, mine), "    ")
    yield from block(
        (
            "Printed values that are no specification of the model:",
            "figures:",
            "  - {name: gyro.bandwidth, value: 262 Hz, condition: configurable}",
        )
    )


def _errors(sensor: str, given: Mapping[str, str]) -> Iterator[str | tuple[str, str]]:
    """Yield every line of a triad, as a comment where it is not given."""
    values = {
        line: text if text.startswith("{") else scalar(text)
        for line, text in given.items()
    }
    known = {line.name: line for line in lines_of(sensor)}
    for line, source in known.items():
        words = f"{source.model}; {printed_as(line)}"
        yield from wrap(words, 82, subsequent_indent="  ", break_on_hyphens=False)
        blank = f"{BLANK} {source.like(sensor)}"
        if line in AGEING.values():
            blank = f"{{value: {blank}, horizon: {BLANK} year}}"
        yield (line, values[line]) if line in values else f"{line}: {blank}"
    yield from ((scalar(line), values[line]) for line in values.keys() - known.keys())
