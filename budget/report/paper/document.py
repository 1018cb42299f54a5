"""The paper beside ours for programs: JSON and CSV."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from budget.report.document import csv_text
from budget.results import SCHEMA

if TYPE_CHECKING:
    from budget.studies.paper.study import PaperStudy

COLUMNS = (
    "section",
    "where",
    "printed",
    "ours",
    "quantity",
    "ratio",
    "verdict",
    "p_single",
    "p_mean",
    "why",
)


def to_document(study: PaperStudy) -> dict[str, Any]:
    """Return the JSON document of schema `budget/1`, full precision."""
    return {
        "schema": SCHEMA,
        "command": "paper",
        "title": study.paper.title,
        "inputs": {
            file.role: {"name": file.name, "sha256": file.sha256}
            for file in study.inputs
        },
        "rows": [
            {name: getattr(row, name) for name in COLUMNS} for row in study.findings
        ],
        "verdicts": study.paper.verdicts,
        "sweeps": [
            {
                "figure": sweep.figure,
                "source": sweep.source,
                "parameter": sweep.given.parameter,
                "size": sweep.size.tolist(),
                "errors": dict(zip(sweep.names, sweep.errors.tolist(), strict=True)),
            }
            for sweep in study.sweeps
        ],
        "coupling": [
            {
                "source": cell.source,
                "group": cell.group,
                "reaches": cell.reaches,
                "size": cell.size,
            }
            for cell in study.table.cells
        ],
        "assumptions": list(study.paper.assumptions),
        "warnings": [],
    }


def to_json(study: PaperStudy) -> str:
    """Write the JSON document."""
    document = to_document(study)
    return json.dumps(document, allow_nan=False, ensure_ascii=False, indent=1) + "\n"


def to_csv(study: PaperStudy) -> str:
    """Write one line for each row, numbers with all their digits."""
    return csv_text(COLUMNS, map(vars, study.findings))
