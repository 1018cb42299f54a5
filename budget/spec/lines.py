"""The lines of a data sheet that an error model uses: the sources of the sensors."""

from __future__ import annotations

from budget.model.source import ACCELEROMETER, GYRO, SENSORS
from budget.model.source import Source as Line
from budget.model.sources import SOURCES as LINES
from budget.model.sources import lines_of

__all__ = ["ACCELEROMETER", "GYRO", "LINES", "SENSORS", "Line", "lines_of"]
