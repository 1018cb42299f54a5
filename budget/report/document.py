"""Documents for other programs: JSON of schema `budget/1` and CSV, full precision."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from budget.report.csv_text import csv_text

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
    return csv_text(COLUMNS, budget.rows())
