"""A comparison for other programs: JSON of schema `budget/1`, CSV; full precision."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from budget.report.comparison.tables import lists, ranks
from budget.report.document import csv_text
from budget.results import SCHEMA

if TYPE_CHECKING:
    from collections.abc import Iterator

    from budget.results import OutputAssessment
    from budget.studies.comparison.records import (
        Comparison,
        DeviceVerdict,
        Entrant,
        Pair,
    )

DEVICES = "devices"
COLUMNS = (
    "procedure",
    "sensor",
    "rank",
    "device",
    "file",
    "verdict",
    "device_utilisation",
    "device_conformance",
    "parameter",
    "axis",
    "unit",
    "limit",
    "standard_uncertainty",
    "largest_error",
    "utilisation",
    "conformance",
    "interval_low",
    "interval_high",
    "interval_by",
    "lower_bound",
    "device_lower_bound",
)


def to_dict(comparison: Comparison) -> dict[str, Any]:
    """Return the JSON document, in printed units, best first."""
    return {**_frame(comparison), DEVICES: list(_devices(comparison))}


def _frame(comparison: Comparison) -> dict[str, Any]:
    """Return the document with an empty list in the place of the devices."""
    return {
        "schema": SCHEMA,
        "command": "compare",
        "requirement": comparison.requirement,
        "procedures": list(comparison.procedures),
        "met": comparison.is_met,
        "caps": dict(comparison.caps),
        "not_compared": list(comparison.not_compared),
        "inputs": [asdict(file) for file in comparison.inputs],
        "settings": asdict(comparison.settings),
        DEVICES: [],
        "nothing_known": [_entrant(one) for one in comparison.nothing_known],
        "pairs": [_pair(pair) for pair in comparison.pairs],
        "assumptions": list(comparison.assumptions),
        "warnings": list(comparison.warnings),
    }


def to_json(comparison: Comparison) -> str:
    """Write the JSON document of a comparison.

    Raises
    ------
    ValueError
        A number is not finite: JSON has none, and a comparison must have none.
    """
    return "".join(json_pieces(comparison))


def json_pieces(comparison: Comparison) -> Iterator[str]:
    """Yield the text of the JSON document, one device after another.

    Thousands of them as one nest of dicts, and as what that is encoded to, take ten
    times the room of their text. Raises as to_json does.
    """
    start = "{\n"
    for key, value in _frame(comparison).items():
        yield f"{start} {json.dumps(key)}: "
        start = ",\n"
        if key != DEVICES or not comparison.devices:
            yield _dumps(value, depth=1)
            continue
        for place, one in enumerate(_devices(comparison)):
            yield ("[\n  " if place == 0 else ",\n  ") + _dumps(one, depth=2)
        yield "\n ]"
    yield "\n}\n"


def _dumps(value: Any, *, depth: int) -> str:  # noqa: ANN401 - any part of a document
    """Write a part of the document that stands so deep in it.

    A text in JSON has no line break of its own, so every one is of the layout.
    """
    text = json.dumps(value, allow_nan=False, ensure_ascii=False, indent=1)
    return text.replace("\n", "\n" + " " * depth)


def _devices(comparison: Comparison) -> Iterator[dict[str, Any]]:
    """Yield the entries of `devices`, best first."""
    for devices in lists(comparison).values():
        for one, rank in zip(devices, ranks(devices), strict=True):
            yield _device(one, rank)


def to_csv(comparison: Comparison) -> str:
    """Write one row for each device and required output, in printed units."""
    rows: list[dict[str, Any]] = [
        {
            "procedure": procedure,
            "sensor": sensor,
            "rank": _number(rank),
            "device": one.name,
            "file": one.file,
            "verdict": one.verdict,
            "device_utilisation": one.utilisation,
            "device_conformance": one.conformance.value,
            "device_lower_bound": one.lower_bound,
            **_flat(output),
            "lower_bound": output.lower_bound,
        }
        for (sensor, procedure), devices in lists(comparison).items()
        for one, rank in zip(devices, ranks(devices), strict=True)
        for output in one.outputs
    ]
    rows += [  # no figure: a 0 would look like the best
        {
            "procedure": entrant.procedure,
            "sensor": entrant.sensor,
            "device": entrant.name,
            "file": entrant.file,
            "verdict": "undecidable",
        }
        for entrant in comparison.nothing_known
    ]
    return csv_text(COLUMNS, rows)


def _entrant(one: Entrant) -> dict[str, Any]:
    """Return what is said of every entrant, judged or not."""
    missing = one.missing
    return {
        "name": one.name,
        "file": one.file,
        "technology": one.technology,
        "sensor": one.sensor,
        "procedure": one.procedure,
        "verdict": "undecidable",
        "not_given": list(one.not_given),
        "missing": None
        if missing is None
        else {
            "lines": list(missing.lines),
            "assumed": [str(line) for line in missing.assumed],
            "utilisation": missing.utilisation,
            "verdict": missing.verdict or None,
        },
        "price": one.price,
        "mass": one.mass,
        "power": one.power,
        "over_caps": list(one.over_caps),
        "unknown_caps": [asdict(unknown) for unknown in one.unknown_caps],
    }


def _device(one: DeviceVerdict, rank: str) -> dict[str, Any]:
    """Return one entry of `devices`."""
    ahead = one.ahead
    return {
        **_entrant(one),
        "rank": _number(rank),
        "verdict": one.verdict,
        "lower_bound": one.lower_bound,
        "utilisation": one.utilisation,
        "utilisation_interval": list(one.utilisation_interval),
        "margin": one.margin,
        "worst_output": one.worst_output,
        "worst_outputs": list(one.worst_outputs),
        **one.conformance.to_dict(),
        "limiting_source": one.remedy.source,
        "limiting_share": one.remedy.share,
        "improvement_factor": one.remedy.factor,
        "ahead": None
        if ahead is None
        else {
            "other": ahead.other,
            "probability": ahead.probability,
            "tied": ahead.is_tied,
        },
        "on_front": list(one.on_front),
        "advice": one.advice,
        "trials": one.trials,
        "outputs": [output.to_dict() for output in one.outputs],
    }


def _number(rank: str) -> int:
    """Return a rank without the mark of a tie."""
    return int(rank.rstrip("="))


def _flat(row: OutputAssessment) -> dict[str, Any]:
    """Return the same without a list, as columns have it."""
    document = row.to_dict()
    document["interval_low"], document["interval_high"] = document.pop("interval")
    return document


def _pair(pair: Pair) -> dict[str, Any]:
    """Return one entry of `pairs`."""
    return {
        "gyro": pair.gyro,
        "accelerometer": pair.accelerometer,
        "procedure": pair.procedure,
        "verdict": pair.verdict,
        "lower_bound": pair.lower_bound,
        "utilisation": pair.utilisation,
        **pair.conformance.to_dict(),
    }
