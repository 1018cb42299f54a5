"""Sweep: the budget over values of one line of a data sheet."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.errors import CallError
from budget.inputs import (
    load_device,
)
from budget.inputs.changes import read_change
from budget.inputs.load import several
from budget.names import with_parts
from budget.question import Question
from budget.results import TIME_COLUMN
from budget.settings import Asked, Inputs, asking
from budget.studies.analysis import analyze_as
from budget.units import NUMBER

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator

    import pandas as pd

    from budget.inputs.files import File
    from budget.inputs.records import Device
    from budget.names import Name
    from budget.results import Budget

QUANTITY = re.compile(rf"({NUMBER})\s*([^\s\d].*)")


@asking("sweep")
def sweep(
    device: Device | File,
    line: str,
    values: Iterable[object],
    *,
    unit: str = "",
    inputs: Inputs,
    asked: Asked,
) -> pd.DataFrame:
    """Compute the budget for each of several values of a line.

    Parameters
    ----------
    device : Device, or what load_device takes
        All its other lines stay as they are.
    line : str
        'gyro.bias_stability', 'gyro.nominal.bias.x', as `Device.replace` takes it.
    values : iterable
        '0.5 deg/h' and others, each as a device file would give it; or numbers: a list,
        a range, an array of shape (n,), or (n, 3) axis by axis [unit].
    unit : str
        Of the numbers, 'deg/h'.

    Returns
    -------
    DataFrame
        A row for each value and output: `value` in `value_unit`, or as it was given if
        it is no number with a unit; then sensor, parameter, axis, of a mission
        `time [s]`, and in `unit` mean, standard_uncertainty, interval_low,
        interval_high; `share` of the variance that the line contributes [1], products
        left out; with a requirement limit, utilisation [1] and the verdict on the
        sensor, empty where the output has no limit, which adds no rows.

    Raises
    ------
    SpecError
        A value is none of that line.
    CallError
        There is no value, a number has no unit, or what `analyze` refuses.
    """
    from budget.studies.frame import Frame

    start = load_device(device)
    outputs = asked.outputs
    asked = replace(asked, outputs=() if inputs.mission else outputs)
    whole = Question.load(start, inputs=inputs, asked=asked)
    listed = () if isinstance(values, str) else several(values)
    printed = tuple(_as_printed(value, line, unit) for value in listed)
    if not printed:
        raise CallError(
            f"{line}: expected a list of values to compute the budget for, as "
            "['0.01 deg/h', '0.02 deg/h'], or numbers with unit='deg/h'"
        )
    changed = [start.replace({line: value}) for value in printed]  # refused at once
    address = read_change(f"{line}=0").address
    rows: list[dict[str, Any]] = []
    for value, one in zip(printed, changed, strict=True):
        question = replace(whole, devices=(one,))
        budget = analyze_as(asked.settle(), question, command="sweep")
        chosen = _asked(budget, outputs)
        rows += ({**_split(value), **row} for row in _rows(budget, address, chosen))
    return Frame(rows)


def _as_printed(value: object, line: str, unit: str) -> object:
    """Return a value as a device file gives it: a number, or one an axis, with a unit.

    Raises
    ------
    CallError
        There is none for a number.
    """
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str):
        return [_as_printed(one, line, unit) for one in value]
    if not isinstance(value, Real) or isinstance(value, bool):
        return value
    if not unit:
        raise CallError(
            f"{line}: found {value}, a number without a unit; give unit=, as 'deg/h'"
        )
    return f"{value if isinstance(value, int) else float(value)!r} {unit}"


def _split(value: object) -> dict[str, object]:
    """Return number and unit of a value; what is not one with the other as it is."""
    found = QUANTITY.fullmatch(value.strip()) if isinstance(value, str) else None
    if found is None:
        return {"value": value, "value_unit": ""}
    return {"value": float(found[1]), "value_unit": found[2]}


def _asked(budget: Budget, texts: Sequence[str]) -> Container[Name]:
    """Return the names of the outputs that are asked for; all if none is.

    Raises
    ------
    CallError
        A mission has none of that name.
    """
    if budget.mission is None or not texts:
        return budget.settings.outputs or tuple(budget)
    found: set[Name] = set()
    for text in (texts,) if isinstance(texts, str) else texts:
        found |= {*with_parts(text, budget)} or {budget[text].output.name}
    return found


def _rows(
    budget: Budget, line: Name, asked: Container[Name]
) -> Iterator[dict[str, Any]]:
    """Yield what a sweep says of each output of one budget."""
    found = budget.assessment
    limits = {} if found is None else {row.output.name: row for row in found.outputs}
    verdicts = {} if found is None else {one.sensor: one for one in found.sensors}
    for row in budget.outputs:
        if row.output.name not in asked:
            continue
        own, time = row.in_unit(), row.output.name.time
        shares = [part.share for part in row.contributions if part.source == line]
        record: dict[str, Any] = {
            "sensor": row.sensor,
            "parameter": row.parameter,
            "axis": row.axis,
            **({} if time is None else {TIME_COLUMN: time}),
            "unit": own.unit,
            "mean": own.mean,
            "standard_uncertainty": own.standard_uncertainty,
            "interval_low": own.interval[0],
            "interval_high": own.interval[1],
            "share": sum(shares),
        }
        if found is not None:
            limit = limits.get(row.output.name)
            record |= dict.fromkeys(("limit", "utilisation", "verdict"))
            if limit is not None:
                record |= {
                    "limit": limit.limit / row.output.si_per_unit,
                    "utilisation": limit.utilisation,
                    "verdict": verdicts[row.sensor].verdict,
                }
        yield record
