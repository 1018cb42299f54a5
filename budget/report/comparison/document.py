"""A comparison for other programs: JSON of schema `budget/1`, CSV; full precision."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from budget.documents import document
from budget.missing import PREDICT
from budget.report.document import csv_text

if TYPE_CHECKING:
    from budget.studies.comparison.records import Comparison

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
    "conditions",
)


PREDICTED = ("device_probability", "device_doubt", "ask_first", "ask_first_worth")


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
    for key, value in document(comparison).items():
        yield f"{start} {json.dumps(key)}: "
        start = ",\n"
        if not isinstance(value, Iterator) or not comparison.devices:
            yield _dumps(list(value) if isinstance(value, Iterator) else value, depth=1)
            continue
        for place, one in enumerate(value):
            yield ("[\n  " if place == 0 else ",\n  ") + _dumps(one, depth=2)
        yield "\n ]"
    yield "\n}\n"


def _dumps(value: Any, *, depth: int) -> str:  # noqa: ANN401 - any part of a document
    """Write a part of the document that stands so deep in it.

    A text in JSON has no line break of its own, so every one is of the layout.
    """
    text = json.dumps(value, allow_nan=False, ensure_ascii=False, indent=1)
    return text.replace("\n", "\n" + " " * depth)


def to_csv(comparison: Comparison) -> str:
    """Write one row for each device and required output, in printed units.

    Where missing lines are predicted, with the probability and what to ask for.
    """
    more = PREDICTED if comparison.settings.missing == PREDICT else ()
    return csv_text((*COLUMNS, *more), _rows(comparison))


def _rows(comparison: Comparison) -> Iterator[dict[str, Any]]:
    """Yield the entries of the JSON document, one for each output, without lists."""
    for one in map(document, comparison.ranked):
        predicted = one.get("predicted", {})
        first: dict[str, Any] = next(iter(predicted.get("worth_asking", [])), {})
        for output in one["outputs"]:
            low, high = output["interval"]
            yield {
                **{f"device_{key}": value for key, value in one.items()},
                **{key: one[key] for key in ("rank", "file", "verdict")},
                "procedure": one["procedure"],
                "device": one["name"],
                "conditions": _conditions(one),
                "device_probability": predicted.get("probability"),
                "device_doubt": predicted.get("doubt"),
                "ask_first": first.get("source"),
                "ask_first_worth": first.get("reduction"),
                **output,
                "interval_low": low,
                "interval_high": high,
            }
    for entrant in comparison.nothing_known:  # no figure: a 0 would look like the best
        one = document(entrant, "entrant")
        yield {**one, "device": entrant.name, "conditions": _conditions(one)}


def _conditions(one: dict[str, Any]) -> str:
    """Say in a cell what a verdict holds if, or what to ask for."""
    return "; ".join(condition["text"] for condition in one["conditions"])
