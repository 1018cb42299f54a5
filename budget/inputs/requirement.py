"""The requirement file: the largest errors a calibrated system may have."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, ClassVar

from budget.distributions import COVERAGES, is_coverage
from budget.inputs.fields import (
    TEXT,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    by_axis,
    check,
    format_row,
    given_of,
    items,
    measured,
    one_of,
    per_axis,
    rows_of,
    table,
)
from budget.inputs.records import EACH, JOINT, Limit, Origin, Requirement
from budget.inputs.use import AGE_ROW, ENVIRONMENT_ROW, stated_lines
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

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.tree import YamlFile
    from budget.units import Quantity

COVERAGE = "95 %"
REFERENCE = "next_turn_on"
COVER = measured("%", Sign.POSITIVE, bare=True)
# What an error of navigation is limited in.
LIKE = {"position": "m", "velocity": "m/s", "attitude": "arcsec"}
MOST_LIMITS = 20  # on one quantity of a mission


# What the device may cost; held against its own; they decide no verdict.
CAPS = table(rows=dict.fromkeys(("price", "mass", "power"), KeyRow(TEXT)), title="Caps")


def _is_none(share: Quantity | None) -> bool:
    """Say whether what is given is no coverage."""
    return share is not None and not is_coverage(share.value)


class AtTime(Keyed):
    """A limit at a time of a mission."""

    rows: ClassVar[Rows] = {
        "at": KeyRow(
            measured("s", Sign.POSITIVE), "since the mission began", is_needed=True
        ),
        "probability": KeyRow(COVER, "of the error to be within; unset: the coverage"),
        "interpretation": KeyRow(
            one_of("ensemble"),
            "of the probability: over units, turn-ons and noise, at that time",
        ),
    }
    rules: ClassVar[Rules] = (
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
        return " or ".join(key for key in vars(self) if key not in AtTime.rows)

    @property
    def named(self) -> dict[str, Quantity]:
        """The limits that are there, by their keys."""
        own = given_of(vars(self))
        return {key: own[key] for key in own if key not in AtTime.rows}


def _several(title: str, like: str, keys: Sequence[str]) -> ValueKind:
    """Return the kind of limits at several times, one of which may stand alone."""
    limits = rows_of(dict.fromkeys(keys, measured(like, Sign.POSITIVE)))
    return items(
        table(AtTime, limits, title),
        most=MOST_LIMITS,
        alone=True,
        lacks=(keys[0], "at: 60 s"),
    )


# On a mission: lengths and parts of vectors, and each angle of attitude.
ON_MISSION = table(
    rows=rows_of(
        {
            quantity: _several(
                f"{quantity} limit", LIKE[quantity], (LENGTHS[quantity], *axes)
            )
            for quantity, axes in PLACES.items()
            if quantity in LENGTHS
        }
        | {
            axis: _several(f"{axis} limit", LIKE["attitude"], ("limit",))
            for axis in PLACES["attitude"]
        }
    ),
    title="mission limits",
)


def _limits_on(owner: str) -> Rows:
    """Return the rows of the limits of one sensor, or of both together."""
    units = {
        "scale_factor": "ppm",
        "bias": SOURCES[0].like(owner),
        **{quantity: f"ug/g^{order}" for quantity, order in ORDERS.items()},
    }
    return rows_of(
        {
            quantity: per_axis(units.get(quantity, "arcsec"), axes, Sign.POSITIVE)
            for quantity, axes in quantities_of(owner).items()
        }
    )


LIMITS = table(
    rows={
        **{
            sensor: KeyRow(table(rows=_limits_on(sensor), title=f"{sensor} limits"))
            for sensor in SENSORS
        },
        **_limits_on(IMU),
        MISSION: KeyRow(ON_MISSION),
    },
    title="limits",
)


class RequirementFile(Keyed):
    """What a calibrated system must hold."""

    rows: ClassVar[Rows] = {
        "format": format_row("requirement"),
        "name": KeyRow(TEXT, is_needed=True),
        "coverage": KeyRow(COVER, f"of the intervals; unset: {COVERAGE}"),
        "reference": KeyRow(
            one_of("nominal", "as_tested", "next_turn_on"),
            f"error reference, what errors are counted from; unset: {REFERENCE}",
        ),
        "limits": KeyRow(LIMITS, "largest absolute errors allowed", is_needed=True),
        "environment": ENVIRONMENT_ROW,
        "age": AGE_ROW,
        "decision": KeyRow(
            one_of(EACH, JOINT),
            "each (unset): every limit alone, at its coverage; joint: all of "
            "them together, at the coverage of the requirement",
        ),
        "caps": KeyRow(CAPS, usual={}),
    }
    rules: ClassVar[Rules] = (
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


def read_requirement(document: YamlFile) -> Requirement:
    """Turn a requirement file into a record, in SI, one limit an output.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model: RequirementFile = check(document, table(RequirementFile))
    usual = {"coverage": COVERAGE, "reference": REFERENCE}
    return Requirement(
        name=model.name,
        coverage=0.95 if model.coverage is None else model.coverage.value,
        reference=model.reference or REFERENCE,
        limits=(*_limits(model.limits), *_mission_limits(model.limits)),
        caps=tuple(given_of(vars(model.caps)).items()),
        assumptions=tuple(
            sentence("assumed.usual", key=key, usual=word)
            for key, word in usual.items()
            if getattr(model, key) is None
        ),
        origin=Origin(file=document.base_name, sha256=document.sha256),
        use=stated_lines(model.environment, model.age),
        decision=model.decision or EACH,
    )


def _limits(limits: Keyed) -> tuple[Limit, ...]:
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


def _mission_limits(limits: Keyed) -> tuple[Limit, ...]:
    """Return the limits on a mission, in the order of the file."""
    mission = getattr(limits, MISSION)
    found: list[Limit] = []
    for key, several in () if mission is None else given_of(vars(mission)).items():
        for item in several:
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
