"""Checks and differences for other programs: JSON of schema `budget/1`, and CSV."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from budget.report.document import csv_text, json_text
from budget.report.reference.sections import cause_texts, together_text
from budget.results import SCHEMA

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.references.difference import Difference, Move

COLUMNS = (
    *("reference", "subject", "quantity", "partner", "unit", "before", "after"),
    *("difference", "relative", "sampled", "times", "because"),
)


def checks_json(checks: Sequence[Difference], errors: Sequence[str]) -> str:
    """Write the JSON document of `check`; `errors` are those of bad references."""
    return json_text(
        {
            "schema": SCHEMA,
            "command": "check",
            "holds": not errors and all(one.holds for one in checks),
            "references": [
                {
                    "name": one.first,
                    "kind": one.job,
                    "holds": one.holds,
                    "compared": one.compared,
                    "sampled": one.sampled,
                    "changes": [asdict(change) for change in one.changes],
                }
                for one in checks
            ],
            "moved": _moved(checks),
            "errors": list(errors),
        }
    )


def difference_json(difference: Difference) -> str:
    """Write the JSON document of `diff`, the largest change first."""
    return json_text(
        {
            "schema": SCHEMA,
            "command": "diff",
            "first": difference.first,
            "second": difference.second,
            "kind": difference.job,
            "compared": difference.compared,
            "changes": [asdict(change) for change in difference.changes],
            "moved": [_move(move) for move in difference.moves],
        }
    )


def differences_csv(differences: Sequence[Difference]) -> str:
    """Write one row for each number or word that moved."""
    return csv_text(COLUMNS, _moved(differences))


def _moved(differences: Sequence[Difference]) -> list[dict[str, Any]]:
    """Return the entries of `moved`, each with the name of what it is in."""
    return [
        {"reference": one.first, **_move(move)}
        for one in differences
        for move in one.moves
    ]


def _move(move: Move) -> dict[str, Any]:
    """Return one entry of `moved`."""
    because = [f"{one.key} {part}" for one, part in cause_texts(move)]
    if together := together_text(move):
        because.append(f"together {together}")
    return {
        "subject": move.item.subject,
        "quantity": move.item.quantity,
        "partner": move.item.partner,
        "unit": move.unit,
        "before": move.before,
        "after": move.after,
        "difference": move.difference,
        "relative": move.relative,
        "sampled": move.is_sampled,
        "times": move.times,
        "causes": [
            {"change": str(cause.change), "amount": cause.amount}
            for cause in move.causes
        ],
        "together": move.together,
        "because": "; ".join(because),
    }
