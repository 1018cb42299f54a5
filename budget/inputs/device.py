"""The device file: a data sheet, its variants, and the record they become."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, create_model, model_validator

from budget.errors import UnitError
from budget.inputs.changes import apply, tell_changes
from budget.inputs.checking import check, nearest
from budget.inputs.fields import (
    Later,
    LongText,
    Measured,
    ShortText,
    Sign,
    Strict,
    by_axis,
    faults,
    mapping_of,
    per_axis,
)
from budget.inputs.makers import density_of, printed_as
from budget.inputs.ranges import IS, RANGES, TYPES, read_range
from budget.inputs.records import (
    ANGLES,
    AXES,
    CHANGED,
    Device,
    Origin,
    Sensor,
    UnusedValue,
)
from budget.inputs.specification import (
    OVER_TEMPERATURE,
    read_value,
    time_in,
    value_type,
)
from budget.inputs.tree import all_of, describe, merge
from budget.model.sources import (
    ACCELEROMETER,
    GYRO,
    SAMPLE_NOISE,
    SENSORS,
    SOURCES,
    WHITE,
    lines_of,
)
from budget.model.sources.later import AGEING
from budget.names import Name
from budget.sentences import sentence
from budget.units import STANDARD_GRAVITY, Quantity, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.inputs.changes import Override
    from budget.inputs.makers import Density
    from budget.inputs.ranges import RangeValue
    from budget.inputs.tree import Node, YamlFile
    from budget.model.source import Source

PLAUSIBLE_GRAVITY = (9.5, 10.5)  # what a maker may mean by g [m/s^2]
MOST_VARIANTS = 50  # each is checked as a device of its own
_BASE_ONLY = ("format", "abstract", "variants")


class UnusedEntry(Strict):
    """A value that the maker prints and no model uses."""

    name: ShortText
    value: ShortText = Field(description="as printed, with its unit")
    condition: ShortText = ""
    meaning: ShortText = ""
    source: ShortText = ""


class SensorPart(Strict):
    """One triad of gyros or accelerometers."""

    nominal: Strict | None = Field(
        default=None, description="true values that the errors are added to; unset: 0"
    )
    errors: Strict | None = Field(
        default=None, description="the lines of the data sheet"
    )

    @model_validator(mode="after")
    def _check_noise(self) -> Self:
        flicker = getattr(self.errors, "flicker", None)
        stable = getattr(self.errors, "bias_stability", None)
        if flicker and stable and not getattr(flicker, "adds_to", None):
            message = (
                "stands beside bias_stability: the bias instability that a maker "
                "prints, given as flicker and as a Gauss-Markov process, would be "
                "counted twice; expected one of them. Remove one, or, where they are "
                "two noises, write {value: ..., adds_to: bias_stability}"
            )
            raise faults({("errors", "flicker"): message})
        found = {
            ("errors", ageing): (
                f"stands beside {repeated}, which is given over {over.printed} and so "
                "contains what that time does: it would be counted twice; expected "
                f"one of them. Remove one, or, where {repeated} is of turn-ons only, "
                f"write {{value: ..., adds_to: {repeated}}}"
            )
            for parameter, ageing in AGEING.items()
            for repeated in [f"{parameter}_repeatability"]
            if (given := getattr(self.errors, ageing, None))
            and not given.adds_to
            and (over := time_in(getattr(self.errors, repeated, None))) is not None
        }
        if found:
            raise faults(found)
        noise = getattr(self.errors, SAMPLE_NOISE, None)
        walk = next(
            (n for n in WHITE if n != SAMPLE_NOISE and getattr(self.errors, n, None)),
            "",
        )
        if noise is None or not walk or getattr(noise, "adds_to", None):
            return self
        message = (
            f"stands beside {walk}: white noise, given by the sample and as a random "
            "walk, would be counted twice; expected one of them. Remove one, or, where "
            "they are two noises, write {value: ..., adds_to: " + walk + "}"
        )
        raise faults({("errors", SAMPLE_NOISE): message})

    @model_validator(mode="after")
    def _check_temperature(self) -> Self:
        found: dict[tuple[str, ...], str] = {}
        for one in (one for one in SOURCES if one.left_of):
            residual = one.name
            given = [key for key in one.left_of if getattr(self.errors, key, None)]
            elsewhere = [
                line.name
                for line in SOURCES
                if line.over_temperature == residual
                and OVER_TEMPERATURE
                in getattr(getattr(self.errors, line.name, None), "reading", ())
            ]
            given += elsewhere[1:]
            if elsewhere and (given or getattr(self.errors, residual, None)):
                beside = [
                    *given,
                    *([residual] if getattr(self.errors, residual, None) else []),
                ]
                found["errors", elsewhere[0], "reading"] = (
                    f"may be {OVER_TEMPERATURE}, and so is {' and so is '.join(beside)}"
                    ": it would be counted twice; expected one of them. Remove that "
                    "word, or the other specification"
                )
            elif given and getattr(self.errors, residual, None):
                found["errors", residual] = (
                    f"stands beside {' and '.join(given)}: the residual over "
                    "temperature and what a temperature changes are one effect, and "
                    "would be counted twice; expected one of them. Remove the "
                    "coefficient, where the maker compensates it, or the residual"
                )
        if found:
            raise faults(found)
        return self


def _later(line: Source, sensor: str) -> Any:  # noqa: ANN401
    """Return what stands for the type of a line until a file has that line."""
    return Annotated[Any, Later(partial(value_type, line, sensor))]


def _sensor_type(sensor: str, type_of: Callable[[Source, str], Any]) -> Any:  # noqa: ANN401
    """Return the type of a sensor, from the table of model lines."""
    lines = lines_of(sensor)
    nominal = mapping_of(
        f"{sensor} nominal",
        {
            "bias": per_axis(lines[0].like(sensor), AXES, Sign.ANY),
            "mounting_angle": per_axis("arcsec", ANGLES, Sign.ANY),
        },
    )
    errors = mapping_of(
        f"{sensor} errors",
        {line.name: type_of(line, sensor) for line in lines},
        {line.name: f"{line.model}; {printed_as(line.name)}" for line in lines}
        if type_of is value_type  # to describe it
        else {},
    )
    types: dict[str, Any] = {
        "range": (TYPES[sensor] | None, Field(default=None, description=IS)),
        "nominal": (nominal | None, SensorPart.model_fields["nominal"]),
        "errors": (errors | None, SensorPart.model_fields["errors"]),
    }
    return create_model(sensor, __base__=SensorPart, **types)


class Sheet(Strict):
    """What a device file says, and what a variant may override."""

    name: ShortText | None = None
    source: ShortText = Field(default="", description="the document it is from")
    vendor: ShortText = ""
    technology: ShortText = Field(default="", description="FOG, RLG, MEMS, ...")
    price: ShortText = ""
    mass: ShortText = ""
    power: ShortText = ""
    range: RANGES | None = Field(
        default=None, description=f"of each sensor, or under it: {IS}"
    )
    notes: LongText = ""
    gravity_unit: (
        Annotated[Quantity, Measured("m/s^2", Sign.POSITIVE, bare=True)] | None
    ) = Field(
        default=None, description="what g means in this file; unset: 9.80665 m/s^2"
    )
    gyro: SensorPart | None = None
    accelerometer: SensorPart | None = None
    figures: tuple[UnusedEntry, ...] = Field(
        default=(), description="specification values that no model uses, as text"
    )

    @model_validator(mode="after")
    def _check_gravity(self) -> Self:
        low, high = PLAUSIBLE_GRAVITY
        if self.gravity_unit and not low <= self.gravity_unit.value <= high:
            message = (
                f"found {self.gravity_unit.printed!r}, expected {low} to {high} m/s^2"
            )
            raise faults({("gravity_unit",): message})
        return self


class Base(Sheet):
    """The base of a device file, with its variants."""

    format: Literal["budget-device/1"] = "budget-device/1"
    name: ShortText
    abstract: bool = Field(default=False, description="true: only the variants count")
    variants: dict[ShortText, Sheet] = Field(
        default={}, description="overrides by name, chosen as FILE#NAME"
    )

    @model_validator(mode="after")
    def _check_sensors(self) -> Self:
        if self.model_fields_set.isdisjoint(SENSORS):
            raise faults({(): "has no sensor, expected gyro, accelerometer or both"})
        return self

    @model_validator(mode="after")
    def _check_ranges(self) -> Self:
        found = {}
        for kind in SENSORS:
            part = getattr(self, kind)
            if getattr(self.range, kind, None) is None:
                continue
            if part is None:
                found["range", kind] = (
                    f"is of {kind}, and the file has none; remove it, or put it under "
                    "figures, as what is printed and not budgeted"
                )
            elif getattr(part, "range", None) is not None:
                found["range", kind] = (
                    f"stands under {kind}, too; expected one of them, remove the other"
                )
        if found:
            raise faults(found)
        return self


def _file_type(type_of: Callable[[Source, str], Any]) -> type[Base]:
    """Return the type of a device file, with that type of every line."""
    sensors: dict[str, Any] = {
        sensor: (_sensor_type(sensor, type_of) | None, None) for sensor in SENSORS
    }
    variant = create_model("Variant", __base__=Sheet, **sensors)
    variants: Any = (dict[ShortText, variant], Base.model_fields["variants"])  # type: ignore[valid-type]
    return create_model("Device", __base__=Base, variants=variants, **sensors)


@cache
def device_file_type() -> type[Base]:
    """Return the type of a device file, made where there is one to be read."""
    return _file_type(_later)


def whole_file_type() -> type[Base]:
    """Return the type of a device file with those of all lines, to describe it."""
    return _file_type(value_type)


def variant_names(document: YamlFile) -> tuple[str, ...]:
    """Return the variants of a device file, '' for its base unless it is abstract."""
    names = tuple(_variants(document))
    if not _is_abstract(document.root):
        return ("", *names)
    if not names:
        message = "an abstract base has no variants, expected one at least"
        raise all_of([*document.issues, document.issue(document.root, message)])
    return names


def read_device(
    document: YamlFile, variant: str = "", changes: Sequence[Override] = ()
) -> Device:
    """Turn a device file, or one variant in it, into a record in SI.

    Changes are laid over both.

    Raises
    ------
    SpecError
        Every issue of the base with that variant over it.
    """
    printed = root = root_of(document, variant)
    for change in changes:
        root = apply(root, change)
    changed = tell_changes(printed, root, changes)
    sheet = check(document, device_file_type(), root=root, gravity=_gravity(root))
    name = f"{sheet.name} ({variant})" if variant else sheet.name
    name = f"{name}{CHANGED}" if changed else name
    parts: dict[str, SensorPart | None] = {
        kind: getattr(sheet, kind) for kind in SENSORS
    }
    read = {
        kind: _with_range(
            _read_sensor(
                kind,
                name,
                part,
                gravity=_gravity(root),
                density=density_of(sheet.vendor),
            ),
            getattr(part, "range", None) or getattr(sheet.range, kind, None),
        )
        for kind, part in parts.items()
        if part is not None
    }
    return Device(
        name=name,
        gyro=read[GYRO].sensor if GYRO in read else None,
        accelerometer=read[ACCELEROMETER].sensor if ACCELEROMETER in read else None,
        figures=tuple(UnusedValue(**vars(entry)) for entry in sheet.figures),
        assumptions=(
            *(one.said for one in changed),
            *(text for one in read.values() for text in one.assumptions),
        ),
        origin=Origin(
            file=f"{document.base_name}#{variant}" if variant else document.base_name,
            sha256=document.sha256,
            changes=changed,
        ),
        source=sheet.source,
        vendor=sheet.vendor,
        technology=sheet.technology,
        price=sheet.price,
        mass=sheet.mass,
        power=sheet.power,
        notes=sheet.notes,
    )


def _variants(document: YamlFile) -> dict[str, Node]:
    """Return the overrides by name; the parts that none may override are refused."""
    node = document.root.child("variants")
    if node is None or node.value is None:
        return {}
    if not isinstance(node.value, dict):
        message = f"found {describe(node.value)}, expected a mapping of variants"
        raise all_of([*document.issues, document.issue(node, message)])
    issues = []
    if len(node.value) > MOST_VARIANTS:
        message = f"found {len(node.value)} variants, {MOST_VARIANTS} are allowed"
        raise all_of([*document.issues, document.issue(node, message, on_key=True)])
    for name, over in node.value.items():
        if not name.isprintable() or "#" in name:
            message = f"found {describe(name)}, expected a name without '#' on one line"
            issues.append(document.issue(over, message, on_key=True))
        if not isinstance(over.value, dict):
            message = f"found {describe(over.value)}, expected a mapping of overrides"
            issues.append(document.issue(over, message))
            continue
        issues.extend(
            document.issue(over.value[key], "belongs to the base only", on_key=True)
            for key in _BASE_ONLY
            if key in over.value
        )
    if issues:
        raise all_of([*document.issues, *issues])
    return node.value


def root_of(document: YamlFile, variant: str) -> Node:
    """Return the nodes of the base, with one variant laid over them.

    Raises
    ------
    SpecError
        There is no such variant, or the base only serves its variants.
    """
    root = document.root
    keys = root.value if isinstance(root.value, dict) else {}
    base = replace(root, value={k: v for k, v in keys.items() if k != "variants"})
    if not variant and not _is_abstract(root):
        return base
    overrides = _variants(document)
    if variant in overrides:
        return merge(base, overrides[variant])
    names = ", ".join(overrides) or "none"
    message = f"no variant {variant!r}, there are: {names}"
    if not variant:
        message = f"the base is abstract, choose a variant: {names}"
    message += nearest(variant, tuple(overrides))
    node = root.child("variants") or root
    raise all_of([*document.issues, document.issue(node, message, on_key=True)])


def _is_abstract(root: Node) -> bool:
    """Say whether a base only serves its variants."""
    node = root.child("abstract")
    return node is not None and node.value is True


def _gravity(root: Node) -> float:
    """Return what g means in the file; the model says where that is not sound."""
    node = root.child("gravity_unit")
    try:
        own = parse_quantity(node.written, "m/s^2").value if node else STANDARD_GRAVITY
    except UnitError:
        return STANDARD_GRAVITY
    low, high = PLAUSIBLE_GRAVITY
    return own if low <= own <= high else STANDARD_GRAVITY


@dataclass(frozen=True, kw_only=True)
class _ReadSensor:
    """A sensor as the models take it, and what had to be assumed for that."""

    sensor: Sensor
    assumptions: tuple[str, ...]


def _read_sensor(
    kind: str,
    device: str,
    part: SensorPart,
    *,
    gravity: float,
    density: Density | None,
) -> _ReadSensor:
    """Turn one sensor of a file into its record."""
    values = {line: getattr(part.errors, line.name, None) for line in lines_of(kind)}
    every = [
        (
            read_value(line, kind, value, known=density),
            getattr(value, "is_exact", False),
            # What a verdict asks for of every axis is given where no axis has a 0.
            bool(line.expected) or line.is_asked,
        )
        for line, value in values.items()
        if value
    ]
    given = [
        is_exact or bool(one.line.u.all() if of_all else one.line.u.any())
        for one, is_exact, of_all in every
    ]
    read = [one for (one, *_), is_given in zip(every, given, strict=True) if is_given]
    bias = _nominal(part, "bias", AXES)
    angle = _nominal(part, "mounting_angle", ANGLES)
    assumptions = [text for one in read for text in one.assumptions]
    assumptions += [
        sentence(
            "assumed.nothing",
            key=Name(one.line.name, owner=kind),
            value=one.line.printed,
        )
        for (one, *_), is_given in zip(every, given, strict=True)
        if not is_given
    ]
    for key, named, axes in (("bias", bias, AXES), ("mounting_angle", angle, ANGLES)):
        absent = [axis for axis in axes if axis not in named]
        if absent:
            assumptions.append(
                sentence(
                    "assumed.nominal",
                    key=f"{kind}.nominal.{key}",
                    axes=absent if named else [],
                )
            )
    return _ReadSensor(
        sensor=Sensor(
            kind=kind,
            device=device,
            nominal_bias=np.array([bias.get(axis, 0.0) for axis in AXES]),
            nominal_mounting_angle=np.array([angle.get(axis, 0.0) for axis in ANGLES]),
            lines=(),
            not_given=(),
            expected_missing=(),
            gravity_unit=gravity,
        ).with_lines(one.line for one in read),
        assumptions=tuple(assumptions),
    )


def _with_range(read: _ReadSensor, given: Quantity | RangeValue | None) -> _ReadSensor:
    """Return a sensor with its range, where the file gives it."""
    if given is None:
        return read
    found = read_range(given)
    sensor = replace(read.sensor, range=found.values, range_printed=found.printed)
    return replace(read, sensor=sensor)


def _nominal(part: SensorPart, key: str, axes: tuple[str, ...]) -> dict[str, float]:
    """Return the nominal values of the axes that a file names [SI]."""
    value: Quantity | Strict | None = getattr(part.nominal, key, None)
    named = {} if value is None else by_axis(value, axes)
    return {axis: quantity.value for axis, quantity in named.items()}
