"""Calibration schemes: what a procedure file means as windows and weights."""

from __future__ import annotations

from budget.calibration.schemes.zhao_2019 import (
    schedule_accelerometer,
    schedule_gyro,
    scheme_of,
)

__all__ = ["schedule_accelerometer", "schedule_gyro", "scheme_of"]
