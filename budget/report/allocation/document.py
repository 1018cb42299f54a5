"""An allocation for programs: JSON, CSV and the allocated device as a file."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from budget.report.device_file import device_yaml
from budget.report.document import csv_text
from budget.report.tables import print_coverage
from budget.results import SCHEMA

if TYPE_CHECKING:
    from budget.studies.allocation.records import Allocation, Match

COLUMNS = (
    *("sensor", "source", "unit", "status", "now", "allowed", "uncorrected"),
    *("binding_output", "at_ceiling", "at_least", "ceiling", "least"),
    *("headroom", "stopped_by", "best_offered", "counts"),
)


def to_document(allocation: Allocation) -> dict[str, Any]:
    """Return the JSON document of schema `budget/1`, in the units of the files."""
    return {
        "schema": SCHEMA,
        "command": "allocate",
        "title": allocation.title,
        "inputs": {
            file.role: {"name": file.name, "sha256": file.sha256}
            for file in allocation.inputs
        },
        "settings": {
            "method": "gum",
            "strategy": allocation.strategy,
            "seed": allocation.seed,
            "coverage": allocation.coverage,
            "reference": allocation.reference,
            "formulas": allocation.formulas,
        },
        "feasible": allocation.feasible,
        "not_allocated": list(allocation.not_allocated),
        "sources": [
            {
                "sensor": row["sensor"],
                **{key: row[key] for key in COLUMNS[1:12]},
                "binding_outputs": list(source.binding_outputs),
                "headroom": None
                if source.headroom is None
                else {
                    "value": row["headroom"],
                    "stopped_by": row["stopped_by"],
                    "all_that_stop": list(source.headroom.stopped_by),
                },
                "best_offered": row["best_offered"],
                "counts": row["counts"],
            }
            for row, source in zip(_rows(allocation), allocation.sources, strict=True)
        ],
        "outputs": [
            {
                "output": row.output.name,
                "unit": row.output.unit,
                "limit": row.limit / row.output.si_per_unit,
                "utilisation_now": row.now,
                "utilisation_allowed": row.allowed,
                "utilisation_floor": row.floor,
                "binding": row.is_binding,
                "lower_bound": row.lower_bound,
                "parts": [asdict(part) for part in row.parts],
            }
            for row in allocation.outputs
        ],
        "relaxations": [
            {
                "output": row.output.name,
                "unit": row.output.unit,
                "limit": row.limit / row.output.si_per_unit,
                "needed": row.floor * row.limit / row.output.si_per_unit,
            }
            for row in allocation.impossible
        ],
        "levers": [asdict(lever) for lever in allocation.levers],
        "costs": [asdict(cost) for cost in allocation.costs],
        "checks": [
            {**asdict(check), "corrected": check.is_corrected}
            for check in allocation.checks
        ],
        "devices": [_match_document(match) for match in allocation.matches],
        "not_given": list(allocation.not_given),
        "assumptions": list(allocation.assumptions),
        "warnings": list(allocation.warnings),
    }


def allocation_json(allocation: Allocation) -> str:
    """Write the JSON document.

    Raises
    ------
    ValueError
        A number is not finite.
    """
    document = to_document(allocation)
    return json.dumps(document, allow_nan=False, ensure_ascii=False, indent=1) + "\n"


def allocation_csv(allocation: Allocation) -> str:
    """Write one row for each source, values in the units of the file."""
    return csv_text(COLUMNS, _rows(allocation))


def allocated_device(allocation: Allocation) -> str:
    """Write the allocated device as a device file.

    Raises
    ------
    ValueError
        The requirement cannot be met, so there is none.
    """
    if not allocation.feasible:
        raise ValueError("an infeasible requirement has no allocated device")
    basis = "; ".join(
        f"{file.role} {file.name} sha256 {file.sha256}" for file in allocation.inputs
    )
    notes = (
        f"Allocated by budget allocate, strategy {allocation.strategy}, to meet "
        f"{allocation.requirement} at coverage {print_coverage(allocation.coverage)} %,"
        f" reference {allocation.reference}, by procedure {allocation.procedure}, "
        f"formulas {allocation.formulas}. Made from {basis}."
    )
    if any(check.is_corrected for check in allocation.checks):
        notes += (
            " Corrected by Monte Carlo, for which the law is not good enough here: "
            "analyse it with --method monte-carlo."
        )
    if allocation.assumptions:
        notes += f" Assumed: {'; '.join(allocation.assumptions)}."
    return device_yaml(
        allocation.sensors,
        name=f"{allocation.title[:150]}, allocated for {allocation.requirement[:30]}",
        source="budget allocate",
        notes=notes,
    )


def _rows(allocation: Allocation) -> list[dict[str, Any]]:
    """Return one flat record for each source, in the unit of its file."""
    rows = []
    for row in allocation.sources:
        scale = row.si_per_unit

        def size(value: float | None, scale: float = scale) -> float | None:
            return None if value is None else value / scale

        room = row.headroom
        rows.append(
            {
                "sensor": row.source.owner,
                "source": row.source,
                "unit": row.unit,
                "status": row.status,
                "now": size(row.now),
                "allowed": size(row.allowed),
                "uncorrected": size(row.uncorrected),
                "binding_output": next(iter(row.binding_outputs), None),
                "at_ceiling": row.at_ceiling,
                "at_least": row.at_least,
                "ceiling": size(row.ceiling),
                "least": size(row.least),
                "headroom": None if room is None else size(room.value),
                "stopped_by": None
                if room is None
                else next(iter(room.stopped_by), None),
                "best_offered": size(row.best_offered),
                "counts": row.counts,
            }
        )
    return rows


def _match_document(match: Match) -> dict[str, Any]:
    """Return one device of the catalogue for the JSON document."""
    return {
        "name": match.device,
        "file": match.file,
        "sensor": match.sensor,
        "meets": match.meets,
        "lines": [
            {"source": line.source, "ratio": line.ratio, "how": line.how}
            for line in match.lines
        ],
        "extra": list(match.extra),
    }
