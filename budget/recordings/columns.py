"""Columns of a recording: what a head says of quantity, axis, sense and unit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.errors import UnitError
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS
from budget.names import AXES
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

TIME, TEMPERATURE, COUNTER = "time", "temperature", "counter"
COUNTS = "counts"
CHANNELS = tuple(f"{sensor}_{axis}" for sensor in SENSORS for axis in AXES)
# A unit of each; of increments that of the step of an angle or a velocity.
LIKE = {GYRO: "deg/s", ACCELEROMETER: "m/s^2", TIME: "s", TEMPERATURE: "degC"}
STEPS = {GYRO: "deg", ACCELEROMETER: "m/s"}
SKIPPED = "_"
# What others call them, for hints alone.
ALSO = {
    GYRO: ("gyr", "gyroscope", "w", "omega", "angular_velocity", "angular_rate", "g"),
    ACCELEROMETER: ("acc", "accel", "a", "acceleration", "linear_acceleration", "f"),
    TIME: ("t", "timestamp", "time_stamp", "stamp", "seconds"),
    TEMPERATURE: ("temp", "t_imu"),
}
EXAMPLE = "time [s],gyro_x [deg/s],accelerometer_z [m/s^2],temperature [degC]"
_HEAD = re.compile(r"(-)?\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?")
_COUNTS = {"count", "counts", "lsb", "digit", "digits"}
_LETTER = re.compile(r"(.+?)_?([xyz])")


@dataclass(frozen=True, kw_only=True)
class RecordedColumn:
    """What one column of a recording is.

    Attributes
    ----------
    name : str
        'gyro_x', 'time', 'temperature', 'counter'; '' of one that is not read.
    sign : float
        -1 where it counts the other way round [1].
    unit : str
        As written; 'counts' of what no gain is known for.
    size : float or None
        Of the unit [SI]; None of counts.
    head : str
        As it stands in the file.
    """

    name: str = ""
    sign: float = 1.0
    unit: str = ""
    size: float | None = None
    head: str = ""

    @property
    def sensor(self) -> str:
        """'gyro', 'accelerometer', or ''."""
        return self.name.rpartition("_")[0] if self.name in CHANNELS else ""


def read_head(head: str, *, increments: bool = False) -> RecordedColumn:
    """Return what a column is, of its head; one of another name is not read.

    Raises
    ------
    UnitError
        What looks like one of ours has no unit, or one of another kind.
    """
    text = head.strip().strip('"').strip()
    match = _HEAD.fullmatch(text)
    if match is None:
        return RecordedColumn(head=text)
    minus, said, unit = match.groups()
    name = re.sub(r"[ .\-]+", "_", said.casefold())
    sensor = name.rpartition("_")[0] if name in CHANNELS else name
    if sensor not in LIKE and name != COUNTER:
        if meant := _meant(name):
            like = LIKE[meant.rpartition("_")[0] or meant]
            write = f"{meant} [{unit or like}]"
            raise UnitError(f"found {text!r}; did you mean {write!r}?")
        return RecordedColumn(head=text)
    sign = -1.0 if minus else 1.0
    if name == COUNTER:
        return RecordedColumn(name=name, sign=sign, head=text)
    like = STEPS[sensor] if increments and sensor in STEPS else LIKE[sensor]
    if not unit:
        raise UnitError(f"found {text!r} without a unit, as '{said} [{like}]'")
    if sensor in STEPS and unit.strip().casefold() in _COUNTS:
        return RecordedColumn(name=name, sign=sign, unit=COUNTS, head=text)
    if sensor == TEMPERATURE:
        unit = {"\N{DEGREE SIGN}C": "degC", "C": "degC"}.get(unit.strip(), unit)
    try:
        size = parse_quantity(f"1 {unit}", like).si_per_unit
    except UnitError as error:
        hint = ""
        if sensor in STEPS and not increments and _is_step(unit, sensor):
            hint = "; of angle or velocity steps say 'increments: true' in a recording"
        raise UnitError(
            f"{str(error).removeprefix(f'found {unit!r}, ')}{hint}"
        ) from None
    return RecordedColumn(name=name, sign=sign, unit=unit.strip(), size=size, head=text)


def _is_step(unit: str, sensor: str) -> bool:
    """Whether a unit is that of an increment."""
    try:
        parse_quantity(f"1 {unit}", STEPS[sensor])
    except UnitError:
        return False
    return True


def _meant(name: str) -> str:
    """Return the name of ours that another one may mean, or ''."""
    match = _LETTER.fullmatch(name)
    for meant, others in ALSO.items():
        if meant in SENSORS:
            if match and match[1] in (meant, *others):
                return f"{meant}_{match[2]}"
        elif name in others:
            return meant
    return ""


def twice(columns: Sequence[RecordedColumn]) -> str:
    """Return a name that several columns have, or ''."""
    names = [one.name for one in columns if one.name]
    return next((name for name in names if names.count(name) > 1), "")
