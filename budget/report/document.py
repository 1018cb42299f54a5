"""Documents for other programs: JSON of schema `budget/1` and CSV, full precision."""

from __future__ import annotations

import csv
import io
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.results import Budget

COLUMNS = (
    "sensor",
    "parameter",
    "axis",
    "unit",
    "source",
    "standard_uncertainty",
    "share",
    "mean",
    "interval_low",
    "interval_high",
    "interval_by",
    "lower_bound",
)


def to_json(
    budget: Budget, extras: Mapping[str, Mapping[str, Any]] | None = None
) -> str:
    """Write the JSON document of a budget, in printed units.

    Parameters
    ----------
    budget : Budget
        The result.
    extras : mapping, optional
        Documents of other studies that go with it, by their keys.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        A number is not finite: JSON has none, and a budget must have none.
    """
    document = {**budget.to_dict(), **(extras or {})}
    return json.dumps(document, allow_nan=False, ensure_ascii=False, indent=1) + "\n"


def to_csv(budget: Budget) -> str:
    """Write one row for each output and source and one `total`, in printed units."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in budget.rows():
        writer.writerow({name: _cell(row[name]) for name in COLUMNS})
    return text.getvalue()


def _cell(value: str | float | None) -> str:
    """Write a number with all its digits, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else repr(float(value))
