"""The costs file: what it costs to make a line of a data sheet better."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, create_model

from budget.inputs.checking import check
from budget.inputs.fields import Measured, Sign, Strict, mapping_of
from budget.inputs.records import Cost, Costs, Origin
from budget.inputs.specification import standard_size
from budget.model.sources import SENSORS, lines_of
from budget.names import Name
from budget.sentences import sentence
from budget.units import Quantity, per_root_hertz

if TYPE_CHECKING:
    from budget.inputs.tree import YamlFile
    from budget.model.source import Source

# Their product, a (u_ref/u)^p, stays a number for every line that a device may have.
Price = Annotated[float, Field(ge=1e-12, le=1e12, allow_inf_nan=False)]
Power = Annotated[float, Field(ge=0.01, le=10.0, allow_inf_nan=False)]


class CostPart(Strict):
    """Cost of one line: a (u_ref / u)^p."""

    a: Price = Field(default=1.0, description="cost at u_ref")
    p: Power = Field(default=1.0, description="power with which the cost grows")
    u_ref: Quantity | None = Field(
        default=None, description="unset: the value the device has now"
    )


class CostsBase(Strict):
    """Costs by line."""

    format: Literal["budget-costs/1"] = "budget-costs/1"
    costs: Strict


def _cost_type(like: str) -> Any:  # noqa: ANN401
    """Return the type of the cost of a line that has this unit."""
    u_ref: Any = (
        Annotated[Quantity, Measured(like, Sign.POSITIVE)] | None,
        CostPart.model_fields["u_ref"],
    )
    return create_model(f"Cost in {like}", __base__=CostPart, u_ref=u_ref)


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
def costs_file_type() -> type[CostsBase]:
    """Return the type of a costs file, made where there is one to be read."""
    costs: Any = mapping_of(
        "costs by line",
        {name: _cost_type(line.like(name.owner)) for name, line in _sources().items()},
    )
    return create_model("Costs", __base__=CostsBase, costs=(costs, ...))


def read_costs(document: YamlFile) -> Costs:
    """Turn a costs file into a record.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model = check(document, costs_file_type())
    parts = dict(model.costs)
    given: dict[Name, CostPart] = {
        name: part for name in _sources() if (part := parts.get(name)) is not None
    }
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
            if name not in part.model_fields_set
        )
        + tuple(
            sentence("assumed.of", key=f"{key}.u_ref", text=sentence("values.density"))
            for key, part in given.items()
            if part.u_ref and per_root_hertz(part.u_ref.unit)
        ),
        origin=Origin(file=document.base_name, sha256=document.sha256),
    )
