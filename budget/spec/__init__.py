"""Files a user writes, read, checked and turned into frozen records."""

from __future__ import annotations

from budget.spec.load import (
    load_all,
    load_catalogue,
    load_costs,
    load_device,
    load_devices,
    load_mission,
    load_procedure,
    load_requirement,
    load_station,
    load_stations,
    load_variants,
    uncalibrated,
    validate,
    variants,
    without_test,
)
from budget.spec.schema import json_schema

__all__ = [
    "json_schema",
    "load_all",
    "load_catalogue",
    "load_costs",
    "load_device",
    "load_devices",
    "load_mission",
    "load_procedure",
    "load_requirement",
    "load_station",
    "load_stations",
    "load_variants",
    "uncalibrated",
    "validate",
    "variants",
    "without_test",
]
