"""What `budget paper --json` writes, as a part of the schema of results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.schema import VECTOR, files_of, head_of, many
from budget.studies.coupling import Coupling
from zhao_2019.orders import Sweep
from zhao_2019.printed import Finding
from zhao_2019.study import COLUMNS, PaperStudy

if TYPE_CHECKING:
    from budget.report.schema import Node, Schema


def paper_keys(schema: Schema) -> Node:
    """Describe the paper beside ours."""
    finding = schema.entry("finding", Finding, " ".join(COLUMNS))
    sweep = schema.entry(
        "sweep",
        Sweep,
        "figure source",
        parameter=str,
        size=VECTOR,
        errors={"type": "object", "additionalProperties": VECTOR},
    )
    cell = schema.entry("coupling", Coupling, "source group reaches size")
    return schema.entry(
        "paper",
        PaperStudy,
        **head_of("paper"),
        title=str,
        inputs=files_of(schema),
        rows=many(finding),
        verdicts=dict[str, str],
        sweeps=many(sweep),
        coupling=many(cell),
        assumptions=list[str],
        warnings=list[str],
    )
