"""Grade of a device, by the one specification value that grades go by."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from budget.documents import written
from budget.model.sources import SOURCES, lines_of
from budget.units import DEG_PER_HOUR, MICRO_G

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device, Sensor

# The grades below these sizes of the line that a sensor is graded by [SI].
BELOW = {
    "gyro": (("navigation", 0.01 * DEG_PER_HOUR), ("tactical", 10.0 * DEG_PER_HOUR)),
    "accelerometer": (("navigation", 100.0 * MICRO_G), ("tactical", 5e3 * MICRO_G)),
}
# What makers call their technology has one of these in it, mostly.
FAMILIES = ("mems", "fog", "rlg", "hrg", "quartz flexure")
REST = "consumer"
UNKNOWN = "-"


@written(
    "completeness",
    """
    given: lines that a verdict 'meets' needs
    expected: that it needs
    """,
    said="One triad of a device: its nominal values and the lines of its data sheet.",
)
@dataclass(frozen=True, kw_only=True)
class Completeness:
    """How many of the lines that a verdict `meets` needs a data sheet gives."""

    given: int
    expected: int

    def __str__(self) -> str:
        """Format as '4/5'."""
        return f"{self.given}/{self.expected}"


def kind_of_device(device: Device) -> str:
    """Return 'IMU' for both triads, else the name of the one that is there."""
    kinds = [sensor.kind for sensor in device.sensors]
    return "IMU" if len(kinds) > 1 else kinds[0]


def graded_by(kind: str) -> str:
    """Return the line that a kind of sensor is graded by."""
    return next(one.name for one in SOURCES if kind in one.grades)


def grade(sensor: Sensor) -> str:
    """Return 'navigation', 'tactical' or 'consumer'; '-' where nobody can tell.

    Gyros go by bias stability, accelerometers by bias repeatability, both as standard
    uncertainties of the worst axis. Makers draw these lines in different places. Of a
    stability that is sigma of a Gauss-Markov process, or the coefficient B of flicker
    noise: the largest Allan deviation of the one is 0.617 sigma, 0.664 B of the other.
    """
    line = sensor.line(graded_by(sensor.kind))
    if line is None:
        return UNKNOWN
    size = line.largest
    return next((name for name, below in BELOW[sensor.kind] if size < below), REST)


def is_one_of(
    device: Device, kinds: Sequence[str] | None, grades: Sequence[str] | None
) -> bool:
    """Whether a device has a triad that is asked for, with one of the grades.

    Kinds are 'gyro' and 'accelerometer', alone or in an IMU, and 'IMU', either triad
    of a device that has both. None and () are no condition.
    """
    return any(
        (not kinds or sensor.kind in kinds or kind_of_device(device) in kinds)
        and (not grades or grade(sensor) in grades)
        for sensor in device.sensors
    )


def completeness(sensor: Sensor) -> Completeness:
    """Count the expected lines; any one noise line gives the one that is expected."""
    expected = {line.expected for line in lines_of(sensor.kind) if line.expected}
    return Completeness(
        given=len(expected) - len(sensor.expected_missing), expected=len(expected)
    )


def known_family(device: Device) -> str:
    """Return the family of a device; '' of a word that is no technology we know."""
    found = family(device.technology)
    return found if found in FAMILIES else ""


@lru_cache(maxsize=1024)
def family(technology: str) -> str:
    """Return 'mems' of 'MEMS, Z axis' and 'bulk MEMS'; '' where nothing is said."""
    text = technology.casefold()
    known = next((word for word in FAMILIES if word in text), "")
    return known or re.split(r"[,(]", text)[0].strip()
