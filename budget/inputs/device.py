"""The device file: a data sheet, its variants, and the record they become."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from budget.errors import UnitError
from budget.inputs.changes import NOMINAL, apply, tell_changes
from budget.inputs.checking import nearest
from budget.inputs.fields import (
    LONG_TEXT,
    OWN,
    TEXT,
    TRUTH,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    by_axis,
    by_name,
    check,
    format_row,
    items,
    measured,
    per_axis,
    rows_of,
    table,
)
from budget.inputs.makers import density_of, printed_as
from budget.inputs.ranges import IS, OF_SENSOR, RANGES, read_range
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
    value_of,
)
from budget.inputs.tree import all_of, describe, merge, put
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
    from collections.abc import Sequence

    from budget.inputs.changes import Override
    from budget.inputs.makers import Density
    from budget.inputs.specification import ReadValue
    from budget.inputs.tree import Node, YamlFile

PLAUSIBLE_GRAVITY = (9.5, 10.5)  # what a maker may mean by g [m/s^2]
PLAUSIBLE = " to ".join(map(str, PLAUSIBLE_GRAVITY))


def _is_plausible(gravity: float) -> bool:
    """Say whether a maker may mean that by g [m/s^2]."""
    low, high = PLAUSIBLE_GRAVITY
    return low <= gravity <= high


MOST_VARIANTS = 50  # each is checked as a device of its own
_BASE_ONLY = ("format", "abstract", "variants")
TEXTS = ("source", "vendor", "technology", "price", "mass", "power", "notes")


UNUSED = table(
    rows={
        "name": KeyRow(TEXT, is_needed=True),
        "value": KeyRow(TEXT, "as printed, with its unit", is_needed=True),
        **dict.fromkeys(("condition", "meaning", "source"), KeyRow(TEXT, usual="")),
    },
    title="UnusedEntry",
)


class SensorPart(Keyed):
    """One triad of gyros or accelerometers."""

    rules: ClassVar[Rules] = (
        Rule(
            ("errors", "flicker"),
            lambda it: it.counts("flicker") and it.line("bias_stability"),
            "stands beside bias_stability: the bias instability that a maker prints, "
            "given as flicker and as a Gauss-Markov process, would be counted twice; "
            "expected one of them. Remove one, or, where they are two noises, write "
            "{{value: ..., adds_to: bias_stability}}",
        ),
        Rule(
            ("errors", SAMPLE_NOISE),
            lambda it: it.counts(SAMPLE_NOISE) and it.walk,
            "stands beside {walk}: white noise, given by the sample and as a random "
            "walk, would be counted twice; expected one of them. Remove one, or, where "
            "they are two noises, write {{value: ..., adds_to: {walk}}}",
        ),
    )

    def line(self, key: str) -> Any:  # noqa: ANN401 - a type made on the way
        """Return what the file gives of a line, or None."""
        return getattr(self.errors, key, None)

    def counts(self, key: str) -> bool:
        """Whether a line is given, and not as what adds to another."""
        return bool(self.line(key)) and not getattr(self.line(key), "adds_to", None)

    @property
    def walk(self) -> str:
        """The random walk that is given, or ''."""
        return next((n for n in WHITE if n != SAMPLE_NOISE and self.line(n)), "")

    def _faults(self) -> dict[tuple[str, ...], str]:
        """Return what time or temperature do that would be counted twice."""
        found: dict[tuple[str, ...], str] = {
            ("errors", ageing): (
                f"stands beside {repeated}, which is given over {over.printed} and so "
                "contains what that time does: it would be counted twice; expected "
                f"one of them. Remove one, or, where {repeated} is of turn-ons only, "
                f"write {{value: ..., adds_to: {repeated}}}"
            )
            for parameter, ageing in AGEING.items()
            for repeated in [f"{parameter}_repeatability"]
            if self.counts(ageing)
            and (over := time_in(self.line(repeated))) is not None
        }
        for row in (row for row in SOURCES if row.left_of):
            residual = row.name
            elsewhere = [
                one.name
                for one in SOURCES
                if one.over_temperature == residual
                and OVER_TEMPERATURE in getattr(self.line(one.name), "reading", ())
            ]
            given = [*(key for key in row.left_of if self.line(key)), *elsewhere[1:]]
            beside = [*given, *([residual] if self.line(residual) else [])]
            if elsewhere and beside:
                found["errors", elsewhere[0], "reading"] = (
                    f"may be {OVER_TEMPERATURE}, and so is {' and so is '.join(beside)}"
                    ": it would be counted twice; expected one of them. Remove that "
                    "word, or the other specification"
                )
            elif given and self.line(residual):
                found["errors", residual] = (
                    f"stands beside {' and '.join(given)}: the residual over "
                    "temperature and what a temperature changes are one effect, and "
                    "would be counted twice; expected one of them. Remove the "
                    "coefficient, where the maker compensates it, or the residual"
                )
        return found


def _sensor(sensor: str) -> ValueKind:
    """Return what a file may say of one triad, of the table of model lines."""
    lines = lines_of(sensor)
    nominal = {
        "bias": per_axis(lines[0].like(sensor), AXES, Sign.ANY),
        "mounting_angle": per_axis("arcsec", ANGLES, Sign.ANY),
    }
    errors = {
        line.name: KeyRow(
            value_of(line, sensor), f"{line.model}; {printed_as(line.name)}"
        )
        for line in lines
    }
    return table(
        SensorPart,
        {
            "nominal": KeyRow(
                table(rows=rows_of(nominal), title=f"{sensor} nominal"),
                "true values that the errors are added to; unset: 0",
            ),
            "errors": KeyRow(
                table(rows=errors, title=f"{sensor} errors"),
                "the lines of the data sheet",
            ),
            "range": KeyRow(OF_SENSOR[sensor], IS),
        },
        sensor,
    )


class Sheet(Keyed):
    """What a device file says, and what a variant may override."""

    rows: ClassVar[Rows] = {
        "name": KeyRow(TEXT),
        "source": KeyRow(TEXT, "the document it is from", usual=""),
        "vendor": KeyRow(TEXT, usual=""),
        "technology": KeyRow(TEXT, "FOG, RLG, MEMS, ...", usual=""),
        **dict.fromkeys(("price", "mass", "power"), KeyRow(TEXT, usual="")),
        "range": KeyRow(RANGES, f"of each sensor, or under it: {IS}"),
        "notes": KeyRow(LONG_TEXT, usual=""),
        "gravity_unit": KeyRow(
            measured("m/s^2", Sign.POSITIVE, bare=True),
            "what g means in this file; unset: 9.80665 m/s^2",
        ),
        **dict.fromkeys(SENSORS, KeyRow(OWN)),
        "figures": KeyRow(
            items(UNUSED),
            "specification values that no model uses, as text",
            usual=(),
        ),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "gravity_unit",
            lambda it: it.gravity_unit and not _is_plausible(it.gravity_unit.value),
            f"found {{gravity_unit!r}}, expected {PLAUSIBLE} m/s^2",
        ),
    )


class Base(Sheet):
    """The base of a device file, with its variants."""

    rows: ClassVar[Rows] = {
        "format": format_row("device"),
        "name": KeyRow(TEXT, is_needed=True),
        "abstract": KeyRow(TRUTH, "true: only the variants count", usual=False),
    }
    rules: ClassVar[Rules] = (
        Rule(
            (),
            lambda it: it.given.isdisjoint(SENSORS),
            "has no sensor, expected gyro, accelerometer or both",
        ),
        *(
            Rule(
                ("range", kind),
                lambda it, kind=kind: (
                    getattr(it.range, kind, None) and getattr(it, kind) is None
                ),
                f"is of {kind}, and the file has none; remove it, or put it under "
                "figures, as what is printed and not budgeted",
            )
            for kind in SENSORS
        ),
        *(
            Rule(
                ("range", kind),
                lambda it, kind=kind: (
                    getattr(it.range, kind, None)
                    and getattr(getattr(it, kind), "range", None)
                ),
                f"stands under {kind}, too; expected one of them, remove the other",
            )
            for kind in SENSORS
        ),
    )


@cache
def device_table() -> ValueKind:
    """Return the rows of a device file, made where there is one to be read."""
    sensors = {sensor: KeyRow(_sensor(sensor)) for sensor in SENSORS}
    variants = KeyRow(
        by_name(table(Sheet, sensors, "Variant")),
        "overrides by name, chosen as FILE#NAME",
        usual={},
    )
    return table(Base, {**sensors, "variants": variants}, "Device")


def variant_names(document: YamlFile) -> tuple[str, ...]:
    """Return the variants of a device file, '' for its base unless it is abstract."""
    names = tuple(_variants(document))
    if not _is_abstract(document.root):
        return ("", *names)
    if not names:
        message = "an abstract base has no variants, expected one at least"
        raise document.refuse((document.root, message))
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
    sheet = check(document, device_table(), root=root, gravity=_gravity(root))
    shown = variant or document.variant
    name = f"{sheet.name} ({shown})" if shown else sheet.name
    name = f"{name}{CHANGED}" if changed else name
    sensors: dict[str, Sensor] = {}
    assumptions = [one.said for one in changed]
    for kind in SENSORS:
        part: SensorPart | None = getattr(sheet, kind)
        if part is None:
            continue
        own = getattr(part, "range", None) or getattr(sheet.range, kind, None)
        sensors[kind], said = _read_sensor(kind, part, density_of(sheet.vendor))
        sensors[kind] = replace(
            sensors[kind],
            device=name,
            gravity_unit=_gravity(root),
            **({} if own is None else read_range(own)),
        )
        assumptions += said
    return Device(
        name=name,
        gyro=sensors.get(GYRO),
        accelerometer=sensors.get(ACCELEROMETER),
        figures=tuple(UnusedValue(**vars(entry)) for entry in sheet.figures),
        assumptions=tuple(assumptions),
        origin=Origin(
            file=f"{document.base_name}#{variant}" if variant else document.base_name,
            sha256=document.sha256,
            changes=changed,
        ),
        **{key: getattr(sheet, key) for key in TEXTS},
    )


def _variants(document: YamlFile) -> dict[str, Node]:
    """Return the overrides by name; the parts that none may override are refused."""
    node = document.root.child("variants")
    if node is None or node.value is None:
        return {}
    if not isinstance(node.value, dict):
        message = f"found {describe(node.value)}, expected a mapping of variants"
        raise document.refuse((node, message))
    number = len(node.value)
    if number > MOST_VARIANTS:
        message = f"found {number} variants, {MOST_VARIANTS} are allowed"
        raise document.refuse((node, message), on_key=True)
    unnamed = [
        document.issue(
            over,
            f"found {describe(name)}, expected a name without '#' on one line",
            on_key=True,
        )
        for name, over in node.value.items()
        if not name.isprintable() or "#" in name
    ]
    unkeyed = [
        document.issue(
            over, f"found {describe(over.value)}, expected a mapping of overrides"
        )
        for over in node.value.values()
        if not isinstance(over.value, dict)
    ]
    not_theirs = [
        document.issue(own, "belongs to the base only", on_key=True)
        for over in node.value.values()
        for key in _BASE_ONLY
        if (own := over.child(key)) is not None
    ]
    if issues := [*unnamed, *unkeyed, *not_theirs]:
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
    base = put(root, ("variants",), None)
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
    raise document.refuse((root.child("variants") or root, message), on_key=True)


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
    return own if _is_plausible(own) else STANDARD_GRAVITY


def _read_sensor(
    kind: str, part: SensorPart, density: Density | None
) -> tuple[Sensor, list[str]]:
    """Turn one sensor of a file into its record, and what had to be assumed for it."""
    given: list[ReadValue] = []
    nothing: list[ReadValue] = []
    for line in lines_of(kind):
        if value := part.line(line.name):
            one = read_value(line, kind, value, known=density)
            # What a verdict asks for of every axis is given where no axis has a 0.
            of_all = bool(line.expected) or line.is_asked
            is_given = one.line.u.all() if of_all else one.line.u.any()
            is_exact = getattr(value, "is_exact", False)
            (given if is_exact or is_given else nothing).append(one)
    nominal = {key: _nominal(part, key, axes) for key, axes in NOMINAL.items()}
    bias, angle = (
        np.array([nominal[key].get(axis, 0.0) for axis in axes])
        for key, axes in NOMINAL.items()
    )
    sensor = Sensor(
        kind=kind,
        device="",
        nominal_bias=bias,
        nominal_mounting_angle=angle,
        lines=(),
        not_given=(),
        expected_missing=(),
    ).with_lines(one.line for one in given)
    return sensor, [
        *(text for one in given for text in one.assumptions),
        *(
            sentence(
                "assumed.nothing",
                key=Name(one.line.name, owner=kind),
                value=one.line.printed,
            )
            for one in nothing
        ),
        *(
            sentence(
                "assumed.nominal",
                key=f"{kind}.nominal.{key}",
                axes=absent if nominal[key] else [],
            )
            for key, axes in NOMINAL.items()
            if (absent := [axis for axis in axes if axis not in nominal[key]])
        ),
    ]


def _nominal(part: SensorPart, key: str, axes: tuple[str, ...]) -> dict[str, float]:
    """Return the nominal values of the axes that a file names [SI]."""
    value: Quantity | Keyed | None = getattr(part.nominal, key, None)
    named = {} if value is None else by_axis(value, axes)
    return {axis: quantity.value for axis, quantity in named.items()}
