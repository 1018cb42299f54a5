"""The range of a triad: the largest input of either sign that it reads."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, ClassVar

import numpy as np

from budget.inputs.fields import (
    TEXT,
    Faults,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    fault,
    measured,
    node_of,
    or_else,
    or_text,
    rows_of,
    table,
)
from budget.inputs.tree import Node, describe
from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import AXES
from budget.units import Quantity

MEASURED = {
    GYRO: measured("deg/s", Sign.POSITIVE, both=True),
    ACCELEROMETER: measured("g", Sign.POSITIVE, both=True),
}
FORM = "{gyro: 300 deg/s, accelerometer: 10 g}"
IS = "the largest input of either sign that it reads"


class RangeValue(Keyed):
    """What a file may say of the range of one triad, besides a text."""

    rows: ClassVar[Rows] = {
        **dict.fromkeys(("value", *AXES), KeyRow(MEASURED[GYRO])),
        "options": KeyRow(TEXT, "ranges that it can be ordered or set to, as printed"),
        "condition": KeyRow(TEXT, "the maker's other words"),
    }
    rules: ClassVar[Rules] = (
        Rule(
            (),
            lambda given: given.absent,
            "says nothing of {absent}, expected value, or x, y and z",
        ),
    )

    @property
    def absent(self) -> str:
        """The axes that it says nothing of."""
        return ", ".join(axis for axis in AXES if self.of_axis(axis) is None)

    def of_axis(self, axis: str) -> Quantity | None:
        """Return what it says of an axis."""
        own: Quantity | None = getattr(self, axis)
        return self.value if own is None else own


def _read_alone(node: Node, gravity: float, mapping: Any) -> object:  # noqa: ANN401
    """Read a mapping of sensors, or a text: its unit says which."""
    if isinstance(node.value, dict):
        return mapping(node, gravity)
    for sensor, size in MEASURED.items():
        with suppress(Faults):
            size.read(node, gravity)
            return mapping(node_of({sensor: node.value}), gravity)
    raise fault(
        f"found {describe(node.value)}, expected {FORM}, each {IS}; in a file with one "
        "sensor '300 deg/s' will do; the maker's other words stand beside a value: "
        "{value: 300 deg/s, condition: ...}"
    )


OF_SENSOR = {
    sensor: or_text(
        table(
            RangeValue,
            rows_of(dict.fromkeys(("value", *AXES), size)),
            f"range {sensor}",
        ),
        size,
    )
    for sensor, size in MEASURED.items()
}
RANGES = or_else(
    table(rows=rows_of(OF_SENSOR), title="ranges"),
    _read_alone,
    *MEASURED.values(),
)


def read_range(given: Quantity | RangeValue) -> dict[str, Any]:
    """Turn what a file says of the range of one triad into numbers and a text.

    `range`, shape (3,) [rad/s or m/s^2], and `range_printed`, for people: '±400 °/s
    (saturates at ±480 °/s)'.
    """
    if isinstance(given, Quantity):
        given = RangeValue.of(value=given)
    found = [(axis, one) for axis in AXES if (one := given.of_axis(axis)) is not None]
    texts = [f"{axis} ±{one.printed}" for axis, one in found]
    if len({one.printed for _, one in found}) == 1:
        texts = [f"±{found[0][1].printed}"]
    words = f"of {given.options}" if given.options else ""
    beside = "; ".join(filter(None, (words, given.condition)))
    return {
        "range": np.array([one.value for _, one in found]),
        "range_printed": ", ".join(texts) + (f" ({beside})" if beside else ""),
    }
