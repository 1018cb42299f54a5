"""Recording files: what columns of recorded readings are, where a log does not say."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import date as Day  # noqa: N812 - one word with one meaning
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from budget.errors import CallError, UnitError
from budget.inputs.fields import (
    TEXT,
    TRUTH,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    check,
    fault,
    format_row,
    items,
    measured,
    number,
    rows_of,
    table,
    text,
)
from budget.inputs.files import lies_in
from budget.inputs.records import Origin, Recording, RunConditions
from budget.inputs.tree import describe
from budget.inputs.use import or_part
from budget.model.sources import ACCELEROMETER, GYRO
from budget.units import NUMBER, parse_quantity

if TYPE_CHECKING:
    from budget.inputs.tree import Node, YamlFile
    from budget.units import Quantity

MOST_FILES = 100
YAML = {".yaml", ".yml"}
COLDEST = -273.15  # [degC]
RATES = {GYRO: "deg/s", ACCELEROMETER: "m/s^2"}
GAINS = {GYRO: "16.4 counts/(deg/s)", ACCELEROMETER: "2048 counts/g"}
_GAIN = re.compile(rf"({NUMBER})\s*(?:counts?|LSB|digits?)\s*/\s*\(?([^()]+)\)?")


def _gain(sensor: str) -> ValueKind:
    """Return the kind of a gain in counts per unit, read as counts per SI."""
    like = RATES[sensor]
    expected = f"expected counts per {like} or the like, as {GAINS[sensor]!r}"

    def read(node: Node, gravity: float) -> float:
        match = _GAIN.fullmatch(str(node.value).strip())
        if match is None or not (gain := float(match[1])):
            raise fault(f"found {describe(node.value)}, {expected}")
        try:
            unit = parse_quantity(f"1 {match[2]}", like, gravity=gravity)
        except UnitError as error:
            raise fault(f"{error}; {expected}") from None
        return gain / unit.si_per_unit

    return ValueKind(read, {"type": "string", "examples": [GAINS[sensor]]})


class CounterKeys(Keyed):
    """The column of a counter of samples."""

    rows: ClassVar[Rows] = {
        "column": KeyRow(TEXT, "its head, as it stands among the columns"),
        "modulo": KeyRow(
            number(2, 2**53), "from where it begins again at 0", is_needed=True
        ),
    }
    rules: ClassVar[Rules] = (
        Rule("column", lambda it: not it.column, "names no column, expected its head"),
    )


def _is_no_day(text: str) -> bool:
    """Whether a text is no day."""
    try:
        Day.fromisoformat(text)
    except ValueError:
        return True
    return False


class ConditionKeys(Keyed):
    """What the environment of a run was: a certificate says it, it moves no number."""

    rows: ClassVar[Rows] = {
        "temperature": KeyRow(measured("degC", Sign.ANY), "of the air"),
        "humidity": KeyRow(measured("%"), "relative"),
        "pressure": KeyRow(measured("hPa"), "of the air"),
        "text": KeyRow(TEXT, "what else is to be said, or all of it"),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "temperature",
            lambda it: it.temperature is not None and celsius(it.temperature) < COLDEST,
            "is below absolute zero, expected one as '23 degC'",
        ),
        Rule(
            "humidity",
            lambda it: it.humidity is not None and it.humidity.value > 1.0,
            "is above 100 %, expected relative humidity as '45 %'",
        ),
    )


def celsius(temperature: Quantity) -> float:
    """Return a temperature on the scale of Celsius [degC]."""
    return temperature.value + (COLDEST if temperature.unit == "K" else 0.0)


class RecordingFile(Keyed):
    """What the columns of a recording are."""

    rows: ClassVar[Rows] = {
        "format": format_row("recording"),
        "recording": KeyRow(
            items(TEXT, least=1, most=MOST_FILES, alone=True),
            "file of rows beside this one: CSV, whitespace text, .npy, .npz, "
            ".parquet; several are one after the other, or of a triad each",
            is_needed=True,
        ),
        "rate": KeyRow(
            measured("Hz", Sign.POSITIVE), "of sampling; unset: that of the stamps"
        ),
        "columns": KeyRow(
            items(TEXT, least=1, most=1000),
            "heads in the place of those of the file, as 'gyro_x [deg/s]'; _ of one "
            "that is not read, - before one that counts the other way round",
        ),
        "gain": KeyRow(
            table(rows=rows_of({one: _gain(one) for one in RATES}), title="gains"),
            "of a sensor in counts; unset: figures are in counts",
        ),
        "increments": KeyRow(
            TRUTH, "whether they are steps of angle and velocity", usual=False
        ),
        "saturation": KeyRow(
            table(
                rows=rows_of(
                    {
                        sensor: measured(like, Sign.POSITIVE, both=True)
                        for sensor, like in RATES.items()
                    }
                ),
                title="saturation",
            ),
            "reading at the end of the range; unset: where extreme values pile up",
        ),
        "counter": KeyRow(table(CounterKeys), "of samples: it says where some lack"),
        "date": KeyRow(
            text(200, (_is_no_day, "is no day, expected one as 2026-05-31")),
            "day of the run, 'YYYY-MM-DD'",
        ),
        "environment": KeyRow(
            or_part(table(ConditionKeys, title="conditions of a run"), key="text"),
            "that the run was made in, as {temperature: 23 degC, humidity: 45 %, "
            "pressure: 1002 hPa, text: ...}; a text alone is text: certificates say "
            "it, and it moves no number",
        ),
    }


def read_recording(document: YamlFile) -> Recording:
    """Turn a recording file into a record.

    Raises
    ------
    SpecError
        Every issue of the file; a recording that lies in another folder.
    """
    model = check(document, table(RecordingFile))
    folder = Path(document.file).parent
    names = [model.recording] if isinstance(model.recording, str) else model.recording
    files = [(folder / name, str(folder / name)) for name in names]
    for (path, _), name in zip(files, names, strict=True):
        if not lies_in(path, folder) or path.suffix.lower() in YAML:
            message = (
                f"found {name!r}, expected a file of rows in the folder of this one"
            )
            node = document.root.child("recording")
            raise document.refuse((node or document.root, message))

    def sizes(part: Keyed | None) -> dict[str, float]:
        """Return what is given of each sensor [SI]."""
        own = {} if part is None else vars(part)
        return {
            name: one if isinstance(one, float) else one.value
            for name, one in own.items()
            if one is not None
        }

    counter = model.counter
    return Recording(
        name=document.base_name,
        files=tuple(files),
        rate=None if model.rate is None else model.rate.value,
        columns=tuple(model.columns or ()),
        gain=sizes(model.gain),
        increments=bool(model.increments),
        saturation=sizes(model.saturation),
        counter=(counter.column, counter.modulo) if counter else None,
        date=model.date or "",
        environment=None if model.environment is None else _run_in(model.environment),
        assumptions=(),
        origin=Origin(file=document.base_name, sha256=document.sha256),
    )


def _run_in(given: Keyed) -> RunConditions:
    """Return what a file says of the environment of a run."""
    found: Any = given
    humidity, pressure = found.humidity, found.pressure
    return RunConditions(
        temperature=None if found.temperature is None else celsius(found.temperature),
        humidity=None if humidity is None else humidity.value,
        pressure=None if pressure is None else pressure.value,
        text=found.text or "",
    )


def bare_recording(path: Path, shown: str) -> Recording:
    """Return a recording of which its file alone says what it is."""
    return Recording(name=path.name, files=((path, shown),))


def with_columns(
    recording: Recording,
    *,
    rate: float | None = None,
    columns: str | None = None,
    like: Recording | None = None,
) -> Recording:
    """Return a recording whose rate [Hz] and heads are those of a call, where given.

    All else is as of `like`, another one, where that is given.

    Raises
    ------
    CallError
        It is a recording file itself.
    """
    if like is not None:
        if recording.origin is not None:
            raise CallError(
                f"{recording.name} is a recording file itself; give the recording, or "
                "leave the other recording file out"
            )
        recording = replace(like, name=recording.name, files=recording.files)
    if columns is not None:
        heads = tuple(one.strip() for one in columns.split(","))
        recording = replace(recording, columns=heads)
    return recording if rate is None else replace(recording, rate=rate)
