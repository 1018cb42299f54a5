"""The lines of a data sheet that an error model uses: the sources of the sensors."""

from __future__ import annotations

from budget.model.source import ACCELEROMETER, GYRO, SENSORS
from budget.model.source import Source as Line
from budget.model.sources import SOURCES as LINES
from budget.model.sources import lines_of
from budget.model.sources.processes import SampleNoise, Walk, WhiteNoise

__all__ = [
    "ACCELEROMETER",
    "GYRO",
    "LINES",
    "SAMPLE_NOISE",
    "SENSORS",
    "WALKS",
    "WHITE",
    "Line",
    "lines_of",
    "twin_of",
    "walk_of",
]

# Lines that a value per root of hertz may stand for.
WALKS = tuple(line.name for line in LINES if isinstance(line.effect, WhiteNoise | Walk))
# What white noise may be given as: as a random walk or by the sample, not as both.
WHITE = tuple(line.name for line in LINES if line.expected == "noise")
SAMPLE_NOISE = next(line.name for line in LINES if isinstance(line.effect, SampleNoise))


def walk_of(sensor: str) -> str:
    """Return the random walk that white noise is on that sensor."""
    names = (line.name for line in lines_of(sensor))
    return next(name for name in names if name in WHITE and name in WALKS)


def twin_of(name: str) -> str:
    """Return the line that is the same on the other kind of sensor; '' if none is."""
    for one in LINES:
        for other in LINES if one.name == name else ():
            alike = (type(other.effect), other.model) == (type(one.effect), one.model)
            if alike and not other.units.keys() & one.units.keys():
                return other.name
    return ""
