"""The costs file: what it costs to make a line of a data sheet better."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from budget.inputs.fields import (
    OWN,
    Keyed,
    KeyRow,
    Rows,
    Sign,
    ValueKind,
    check,
    format_row,
    measured,
    number,
    rows_of,
    table,
)
from budget.inputs.records import Cost, Costs, Origin
from budget.inputs.specification import standard_size
from budget.model.sources import SENSORS, lines_of
from budget.names import Name
from budget.sentences import sentence
from budget.units import per_root_hertz

if TYPE_CHECKING:
    from budget.inputs.tree import YamlFile
    from budget.model.source import Source


class CostPart(Keyed):
    """Cost of one line: a (u_ref / u)^p."""

    # The product stays a number for every line that a device may have.
    rows: ClassVar[Rows] = {
        "a": KeyRow(number(1e-12, 1e12, is_whole=False), "cost at u_ref", usual=1.0),
        "p": KeyRow(
            number(0.01, 10.0, is_whole=False),
            "power with which the cost grows",
            usual=1.0,
        ),
        "u_ref": KeyRow(OWN, "unset: the value the device has now"),
    }


class CostsFile(Keyed):
    """Costs by line."""


@cache
def _sources() -> dict[Name, Source]:
    """Return what may cost: what a calibration finds costs nothing."""
    return {
        Name(line.name, owner=sensor): line
        for sensor in SENSORS
        for line in lines_of(sensor)
        if line.varies and not line.is_initial
    }


@cache
def costs_table() -> ValueKind:
    """Return the rows of a costs file, made where there is one to be read."""
    units = {name: line.like(name.owner) for name, line in _sources().items()}
    u_ref = CostPart.rows["u_ref"]
    costs: dict[str, ValueKind] = {
        name: table(
            CostPart,
            {"u_ref": replace(u_ref, kind=measured(like, Sign.POSITIVE))},
            f"Cost in {like}",
        )
        for name, like in units.items()
    }
    return table(
        CostsFile,
        {
            "format": format_row("costs"),
            "costs": KeyRow(
                table(rows=rows_of(costs), title="costs by line"), is_needed=True
            ),
        },
    )


def read_costs(document: YamlFile) -> Costs:
    """Turn a costs file into a record.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    parts = vars(check(document, costs_table()).costs)
    given = {name: parts[name] for name in _sources() if parts[name] is not None}
    defaults = {"a": "1", "p": "1", "u_ref": "the present value"}
    return Costs(
        costs=tuple(
            Cost(
                source=key,
                a=part.a,
                p=part.p,
                u_ref=None if part.u_ref is None else standard_size(part.u_ref),
            )
            for key, part in given.items()
        ),
        assumptions=tuple(
            sentence("assumed.default", of=key, name=name, usual=default)
            for key, part in given.items()
            for name, default in defaults.items()
            if name not in part.given
        )
        + tuple(
            sentence("assumed.of", key=f"{key}.u_ref", text=sentence("values.density"))
            for key, part in given.items()
            if part.u_ref and per_root_hertz(part.u_ref.unit)
        ),
        origin=Origin(file=document.base_name, sha256=document.sha256),
    )
