"""The requirement file: the largest errors a calibrated system may have."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, create_model

from budget.distributions import COVERAGES, is_coverage
from budget.inputs.checking import check
from budget.inputs.fields import (
    Measured,
    Rule,
    Ruled,
    ShortText,
    Sign,
    Strict,
    by_axis,
    mapping_of,
    or_one,
    per_axis,
)
from budget.inputs.records import EACH, Limit, Origin, Requirement
from budget.inputs.use import (
    AGE_FIELD,
    ENVIRONMENT_FIELD,
    Age,
    Environment,
    stated_lines,
)
from budget.model.sources import SENSORS, SOURCES
from budget.names import (
    IMU,
    LENGTHS,
    MISSION,
    ORDERS,
    OUTPUTS,
    PLACES,
    Name,
    every_output,
    quantities_of,
)
from budget.sentences import sentence
from budget.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.tree import YamlFile

COVERAGE = "95 %"
REFERENCE = "next_turn_on"
Coverage = Annotated[Quantity, Measured("%", Sign.POSITIVE, bare=True)]
Moment = Annotated[Quantity, Measured("s", Sign.POSITIVE)]
# What an error of navigation is limited in.
LIKE = {"position": "m", "velocity": "m/s", "attitude": "arcsec"}
MOST_LIMITS = 20  # on one quantity of a mission


class Caps(Strict):
    """What the device may cost; held against its own; they decide no verdict."""

    price: ShortText | None = None
    mass: ShortText | None = None
    power: ShortText | None = None


def _is_none(share: Quantity | None) -> bool:
    """Say whether what is given is no coverage."""
    return share is not None and not is_coverage(share.value)


class AtTime(Ruled):
    """A limit at a time of a mission."""

    at: Moment = Field(description="since the mission began")
    probability: Coverage | None = Field(
        default=None, description="of the error to be within; unset: the coverage"
    )
    interpretation: Literal["ensemble"] | None = Field(
        default=None,
        description="of the probability: over units, turn-ons and noise, at that time",
    )

    rules: ClassVar[tuple[Rule, ...]] = (
        Rule(
            "probability",
            lambda it: _is_none(it.probability),
            f"found {{probability!r}}, expected one {COVERAGES}",
        ),
        Rule(
            "at",
            lambda it: not it.named,
            "has no limit beside it, expected {keys}",
        ),
    )

    @property
    def keys(self) -> str:
        """What may be limited."""
        return " or ".join(key for key in type(self).model_fields if key not in TIMING)

    @property
    def named(self) -> dict[str, Quantity]:
        """The limits that are there, by their keys."""
        each = {key: getattr(self, key) for key in type(self).model_fields}
        return {
            key: value
            for key, value in each.items()
            if key not in TIMING and value is not None
        }


TIMING = frozenset(AtTime.model_fields)


def _mission_type() -> Any:  # noqa: ANN401
    """Return the type of the limits of a mission."""

    def several(title: str, like: str, keys: Sequence[str]) -> Any:  # noqa: ANN401
        limit = Annotated[Quantity, Measured(like, Sign.POSITIVE)]
        item: Any = mapping_of(title, dict.fromkeys(keys, limit), base=AtTime)
        items: Any = tuple[item, ...]
        alone = or_one(keys[0], "at: 60 s")
        return Annotated[items, Field(max_length=MOST_LIMITS), alone]

    vectors = {
        quantity: several(
            f"{quantity} limit",
            LIKE[quantity],
            (LENGTHS[quantity], *axes),
        )
        for quantity, axes in PLACES.items()
        if quantity in LENGTHS
    }
    angles = {
        axis: several(f"{axis} limit", LIKE["attitude"], ("limit",))
        for axis in PLACES["attitude"]
    }
    return mapping_of("mission limits", vectors | angles)


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
    return mapping_of("limits", sensors | limits(IMU) | {MISSION: _mission_type()})


class RequirementBase(Ruled):
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
    environment: Environment | None = ENVIRONMENT_FIELD
    age: Age | None = AGE_FIELD
    decision: Literal["each", "joint"] | None = Field(
        default=None,
        description="each (unset): every limit alone, at its coverage; joint: all of "
        "them together, at the coverage of the requirement",
    )
    caps: Caps = Caps()

    rules: ClassVar[tuple[Rule, ...]] = (
        Rule(
            "coverage",
            lambda it: _is_none(it.coverage),
            f"found {{coverage!r}}, expected one {COVERAGES}",
        ),
        Rule(
            "limits",
            lambda it: not (_limits(it.limits) or _mission_limits(it.limits)),
            "names no limit, expected one at least",
        ),
        Rule(
            ("limits", MISSION),
            lambda it: it.twice,
            "limits {twice} twice, expected one limit at each time; the others are "
            "printed beside it (CEP, R95, DRMS)",
        ),
        Rule(
            "reference",
            lambda it: (
                it.reference not in {None, REFERENCE} and _mission_limits(it.limits)
            ),
            "found {reference!r} beside limits on a mission, which begins with a "
            "turn-on of its own; expected next_turn_on, or leave it out",
        ),
    )

    @property
    def twice(self) -> str:
        """Outputs of a mission that have two limits at one time."""
        number = Counter(one.output for one in _mission_limits(self.limits))
        return ", ".join(sorted(name for name, times in number.items() if times > 1))


_LIMITS: Any = (_limits_type(), RequirementBase.model_fields["limits"])
RequirementFile = create_model("Requirement", __base__=RequirementBase, limits=_LIMITS)


def read_requirement(document: YamlFile) -> Requirement:
    """Turn a requirement file into a record, in SI, one limit an output.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model = check(document, RequirementFile)
    usual = {"coverage": COVERAGE, "reference": REFERENCE}
    return Requirement(
        name=model.name,
        coverage=0.95 if model.coverage is None else model.coverage.value,
        reference=model.reference or REFERENCE,
        limits=(*_limits(model.limits), *_mission_limits(model.limits)),
        caps=tuple((key, text) for key, text in model.caps if text is not None),
        assumptions=tuple(
            sentence("assumed.usual", key=key, usual=word)
            for key, word in usual.items()
            if getattr(model, key) is None
        ),
        origin=Origin(file=document.base_name, sha256=document.sha256),
        use=stated_lines(model.environment, model.age),
        decision=model.decision or EACH,
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


def _mission_limits(limits: Strict) -> tuple[Limit, ...]:
    """Return the limits on a mission, in the order of the file."""
    mission = getattr(limits, MISSION)
    found: list[Limit] = []
    for key in () if mission is None else type(mission).model_fields:
        for item in getattr(mission, key) or ():
            for word, quantity in item.named.items():
                is_angle = key in PLACES["attitude"]
                found.append(
                    Limit(
                        output=Name(
                            "attitude" if is_angle else key,
                            owner=MISSION,
                            axis=key if is_angle else word,
                            time=item.at.value,
                        ),
                        limit=quantity.value,
                        printed=quantity.printed,
                        coverage=item.probability and item.probability.value,
                    )
                )
    return tuple(found)
