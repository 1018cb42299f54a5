"""Files a user writes, read, checked and turned into frozen records.

What reads files is imported when it is first asked for: processes that only compute
unpickle records and know no files.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from budget.inputs.load import (
        load_all,
        load_calibration,
        load_catalogue,
        load_costs,
        load_device,
        load_devices,
        load_mission,
        load_procedure,
        load_recording,
        load_requirement,
        load_station,
        load_stations,
        load_variants,
        uncalibrated,
        validate,
        variants,
        without_test,
    )
    from budget.inputs.schema import json_schema

__all__ = [
    "json_schema",
    "load_all",
    "load_calibration",
    "load_catalogue",
    "load_costs",
    "load_device",
    "load_devices",
    "load_mission",
    "load_procedure",
    "load_recording",
    "load_requirement",
    "load_station",
    "load_stations",
    "load_variants",
    "uncalibrated",
    "validate",
    "variants",
    "without_test",
]


def __getattr__(name: str) -> object:
    """Import a public name from its module when it is first used (PEP 562)."""
    if name in __all__:
        home = "schema" if name == "json_schema" else "load"
        return getattr(import_module(f"budget.inputs.{home}"), name)
    raise AttributeError(f"module 'budget.inputs' has no attribute {name!r}")
