"""The requirement file: the largest errors a calibrated system may have."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, create_model, model_validator

from budget.distributions import COVERAGES, is_coverage
from budget.language import note
from budget.model.sources import SENSORS, SOURCES
from budget.names import (
    IMU,
    ORDERS,
    OUTPUTS,
    Name,
    every_output,
    quantities_of,
)
from budget.spec.checking import check
from budget.spec.fields import (
    Measured,
    ShortText,
    Sign,
    Strict,
    by_axis,
    faults,
    mapping_of,
    per_axis,
)
from budget.spec.records import Limit, Origin, Requirement
from budget.units import Quantity

if TYPE_CHECKING:
    from budget.spec.tree import Document

COVERAGE = "95 %"
REFERENCE = "next_turn_on"
Coverage = Annotated[Quantity, Measured("%", Sign.POSITIVE, bare=True)]


class Caps(Strict):
    """What the device may cost; held against its own; they decide no verdict."""

    price: ShortText | None = None
    mass: ShortText | None = None
    power: ShortText | None = None


def _limits_type() -> Any:  # noqa: ANN401
    """Return the type of the limits of both sensors, and of both together."""

    def limits(owner: str) -> dict[str, Any]:
        units = {
            "scale_factor": "ppm",
            "bias": SOURCES[0].like(owner),
            **{quantity: f"ug/g^{order}" for quantity, order in ORDERS.items()},
        }
        return {
            quantity: per_axis(units.get(quantity, "arcsec"), axes, Sign.POSITIVE)
            for quantity, axes in quantities_of(owner).items()
        }

    sensors: dict[str, Any] = {
        sensor: mapping_of(f"{sensor} limits", limits(sensor)) for sensor in SENSORS
    }
    return mapping_of("limits", sensors | limits(IMU))


class RequirementBase(Strict):
    """What a calibrated system must hold."""

    format: Literal["budget-requirement/1"] = "budget-requirement/1"
    name: ShortText
    coverage: Coverage | None = Field(
        default=None, description=f"of the intervals; unset: {COVERAGE}"
    )
    reference: Literal["nominal", "as_tested", "next_turn_on"] | None = Field(
        default=None,
        description="error reference, what errors are counted from; unset: "
        f"{REFERENCE}",
    )
    limits: Strict = Field(description="largest absolute errors allowed")
    caps: Caps = Caps()

    @model_validator(mode="after")
    def _check_coverage_and_limits(self) -> Self:
        messages: dict[tuple[str, ...], str] = {}
        if self.coverage is not None and not is_coverage(self.coverage.value):
            messages["coverage",] = (
                f"found {self.coverage.printed!r}, expected one {COVERAGES}"
            )
        if not _limits(self.limits):
            messages["limits",] = "names no limit, expected one at least"
        if messages:
            raise faults(messages)
        return self


_LIMITS: Any = (_limits_type(), RequirementBase.model_fields["limits"])
RequirementFile = create_model("Requirement", __base__=RequirementBase, limits=_LIMITS)


def read_requirement(document: Document) -> Requirement:
    """Turn a requirement file into a record, in SI, one limit an output.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model = check(document, RequirementFile)
    assumptions = []
    if model.coverage is None:
        assumptions.append(
            note("coverage: not given, {coverage} assumed", coverage=COVERAGE)
        )
    if model.reference is None:
        assumptions.append(
            note("reference: not given, {reference} assumed", reference=REFERENCE)
        )
    caps = dict(model.caps)
    return Requirement(
        name=model.name,
        coverage=0.95 if model.coverage is None else model.coverage.value,
        reference=model.reference or REFERENCE,
        limits=_limits(model.limits),
        caps=tuple((key, text) for key, text in caps.items() if text is not None),
        assumptions=tuple(assumptions),
        origin=Origin(file=document.base_name, sha256=document.sha256),
    )


def _limits(limits: Strict) -> tuple[Limit, ...]:
    """Return the limits output by output, in the order of the outputs."""
    places = {sensor: getattr(limits, sensor) for sensor in SENSORS} | {IMU: limits}
    found: list[Limit] = []
    for owner, place in places.items():
        for group in dict.fromkeys(name.group for name in every_output(owner)):
            value = getattr(place, group.quantity, None)
            named = {} if value is None else by_axis(value, OUTPUTS[group.quantity])
            found.extend(
                Limit(
                    output=Name(group.quantity, owner=owner, axis=axis),
                    limit=quantity.value,
                    printed=quantity.printed,
                )
                for axis, quantity in named.items()
            )
    return tuple(found)
