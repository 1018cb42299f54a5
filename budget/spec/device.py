"""The device file: a data sheet, its variants, and the record they become."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, create_model, model_validator

from budget.errors import UnitError
from budget.spec.checking import check, nearest
from budget.spec.fields import (
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
from budget.spec.figures import figure_type, take
from budget.spec.lines import ACCELEROMETER, GYRO, SENSORS, lines_of
from budget.spec.records import (
    ANGLES,
    AXES,
    Device,
    ErrorLine,
    MakerFigure,
    Sensor,
    Source,
)
from budget.spec.tree import all_of, describe, merge
from budget.units import STANDARD_GRAVITY, Quantity, parse_quantity

if TYPE_CHECKING:
    from budget.spec.tree import Document, Node

MOST_VARIANTS = 50  # each is checked as a device of its own
_BASE_ONLY = ("format", "abstract", "variants")


class FigureEntry(Strict):
    """A figure that the maker prints and no model uses."""

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


def _sensor_type(sensor: str) -> Any:  # noqa: ANN401
    """Return the type of a sensor, from the table of model lines."""
    lines = lines_of(sensor)
    nominal = mapping_of(
        f"{sensor} nominal",
        {
            "bias": per_axis(lines[0].like(sensor), AXES, Sign.ANY),
            "mounting_angle": per_axis("arcsec", ANGLES, Sign.ANY),
        },
    )
    fields = {
        line.name: Annotated[figure_type(line, sensor), Field(description=line.model)]
        for line in lines
    }
    types: dict[str, Any] = {
        "nominal": (nominal | None, SensorPart.model_fields["nominal"]),
        "errors": (mapping_of(f"{sensor} errors", fields) | None, None),
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
    range: ShortText = ""
    notes: LongText = ""
    gravity_unit: Annotated[Quantity, Measured("m/s^2", Sign.POSITIVE)] | None = Field(
        default=None, description="what g means in this file; unset: 9.80665 m/s^2"
    )
    gyro: SensorPart | None = None
    accelerometer: SensorPart | None = None
    figures: tuple[FigureEntry, ...] = Field(
        default=(), description="printed by the maker, used by no model"
    )


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
        if self.gyro is None and self.accelerometer is None:
            raise faults({(): "has no sensor, expected gyro, accelerometer or both"})
        return self


_SENSORS: dict[str, Any] = {
    sensor: (_sensor_type(sensor) | None, None) for sensor in SENSORS
}
_VARIANT = create_model("Variant", __base__=Sheet, **_SENSORS)
_VARIANTS: Any = (dict[ShortText, _VARIANT], Base.model_fields["variants"])  # type: ignore[valid-type]
DeviceFile = create_model("Device", __base__=Base, variants=_VARIANTS, **_SENSORS)


def variant_names(document: Document) -> tuple[str, ...]:
    """Return the variants of a device file, '' for its base unless it is abstract."""
    names = tuple(_variants(document))
    if not _is_abstract(document.root):
        return ("", *names)
    if not names:
        message = "an abstract base has no variants, expected one at least"
        raise all_of([*document.issues, document.issue(document.root, message)])
    return names


def read_device(document: Document, variant: str = "") -> Device:
    """Turn a device file, or one variant in it, into a record.

    Parameters
    ----------
    document : Document
        The file.
    variant : str
        Name of the variant; '' for the base.

    Returns
    -------
    Device
        What it says, in SI.

    Raises
    ------
    SpecError
        Every issue of the base with that variant over it.
    """
    root = _root(document, variant)
    sheet = check(document, DeviceFile, root=root, gravity=_gravity(root))
    name = f"{sheet.name} ({variant})" if variant else sheet.name
    sensors: dict[str, Sensor] = {}
    assumptions: list[str] = []
    for kind in SENSORS:
        part: SensorPart | None = getattr(sheet, kind)
        if part is not None:
            sensors[kind] = _sensor(kind, name, part, assumptions)
    return Device(
        name=name,
        gyro=sensors.get(GYRO),
        accelerometer=sensors.get(ACCELEROMETER),
        figures=tuple(MakerFigure(**dict(figure)) for figure in sheet.figures),
        assumptions=tuple(assumptions),
        origin=Source(
            file=f"{document.base_name}#{variant}" if variant else document.base_name,
            sha256=document.sha256,
        ),
        source=sheet.source,
        vendor=sheet.vendor,
        technology=sheet.technology,
        price=sheet.price,
        mass=sheet.mass,
        power=sheet.power,
        range=sheet.range,
        notes=sheet.notes,
    )


def _variants(document: Document) -> dict[str, Node]:
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


def _root(document: Document, variant: str) -> Node:
    """Return the nodes of the base, with one variant laid over them."""
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
    """Return what g means in the file; an unsound text is reported by its model."""
    node = root.child("gravity_unit")
    try:
        return parse_quantity(node.written, "m/s^2").value if node else STANDARD_GRAVITY
    except UnitError:
        return STANDARD_GRAVITY


def _sensor(kind: str, device: str, part: SensorPart, assumptions: list[str]) -> Sensor:
    """Turn one sensor into its record, and add what was assumed."""
    lines: list[ErrorLine] = []
    expected: dict[str, bool] = {}
    for line in lines_of(kind):
        figure = getattr(part.errors, line.name, None)
        if line.expected:
            has = expected.get(line.expected, False)
            expected[line.expected] = has or figure is not None
        if figure is not None:
            taken = take(line, kind, figure)
            lines.append(taken.line)
            assumptions.extend(taken.assumptions)
    given = {line.name for line in lines}
    nominal = {}
    for key, axes in (("bias", AXES), ("mounting_angle", ANGLES)):
        value = getattr(part.nominal, key, None)
        named = {} if value is None else by_axis(value, axes)
        absent = [axis for axis in axes if axis not in named]
        nominal[key] = np.array([named[a].value if a in named else 0.0 for a in axes])
        if absent:
            which = f"{', '.join(absent)} " if named else ""
            assumptions.append(f"{kind}.nominal.{key}: {which}not given, 0 assumed")
    return Sensor(
        kind=kind,
        device=device,
        nominal_bias=nominal["bias"],
        nominal_mounting_angle=nominal["mounting_angle"],
        lines=tuple(lines),
        not_given=tuple(
            f"{kind}.{line.name}" for line in lines_of(kind) if line.name not in given
        ),
        expected_missing=tuple(
            f"{kind}.{name}" for name, has in expected.items() if not has
        ),
    )
