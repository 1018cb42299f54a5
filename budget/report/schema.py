"""JSON Schema of result documents: every key that `--json` may write, by command.

Types are those of the records that documents are written from. What is listed here is
which of their fields stand in a document, and under what key: 'binding=is_binding'.
"""

from __future__ import annotations

import re
from collections import abc
from dataclasses import fields, is_dataclass
from enum import Enum
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Any, Literal, Union, get_args, get_origin
from typing import get_type_hints as hints_of

from budget.inputs.changes import Changed
from budget.inputs.records import Device, ErrorLine, Mission, Sensor, UnusedValue
from budget.inputs.schema import DIALECT
from budget.names import Name
from budget.navigation.route import Outline
from budget.references.difference import Change, Difference, Move
from budget.references.records import Item
from budget.report.catalogue import REMARKS
from budget.results import (
    AT_A_TIME,
    OF_A_LENGTH,
    SCHEMA,
    VERDICTS,
    Ask,
    Assessment,
    BelievedError,
    Budget,
    Calibrated,
    CapAssessment,
    Caution,
    Compensation,
    Condition,
    Contribution,
    Doubt,
    FilledLine,
    Filtered,
    InputFile,
    InputQuantity,
    Learnt,
    OutputAssessment,
    OutputBudget,
    Reading,
    ReadingEffect,
    ReadingVerdicts,
    SensorAssessment,
    Settings,
    SobolIndex,
    Standing,
    Turned,
    Validation,
)
from budget.studies.allocation.records import (
    Allocation,
    CostReport,
    CoverageCheck,
    Headroom,
    LimitedOutput,
    LimitPart,
    LineMatch,
    LongerTest,
    Match,
    Recalibration,
    SourceAllotment,
)
from budget.studies.comparison.records import (
    Comparison,
    DeviceVerdict,
    Entrant,
    Lead,
    MissingLines,
    Pair,
    UnknownCap,
)
from budget.studies.export.study import Export
from budget.studies.stations import (
    Qualification,
    StationFigure,
    StationOutput,
    StationVerdict,
)
from budget.studies.what_if import SourceSteps, Step

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

Node = dict[str, Any]  # a part of a JSON Schema

SIMPLE = {
    float: "number",
    int: "integer",
    bool: "boolean",
    str: "string",
    NoneType: "null",
}
VECTOR: Node = {"type": "array", "items": {"type": "number"}}
MATRIX: Node = {"type": "array", "items": VECTOR}
SAID = "assumptions warnings"  # what every study says beside its numbers
CHANCE: Node = {  # of what may be unknown
    "conformance": float | None,
    "conformance_interval": tuple[float, float] | None,
}


def results_schema(*further: Callable[[Schema], Node]) -> Node:
    """Return the JSON Schema (draft 2020-12) of all that commands write as `--json`.

    A document has no key that it does not name. `further` describe those of commands
    that stand on this package, beside its own studies.
    """
    schema = Schema()
    documents = [make(schema) for make in (_budget, *_STUDIES, *further, *_STORED)]
    return {
        "$schema": DIALECT,
        "title": f"budget result documents ({SCHEMA})",
        "oneOf": documents,
        "$defs": dict(sorted(schema.entries.items())),
    }


class Schema:
    """Collects the entries that documents are made of."""

    def __init__(self) -> None:
        self.entries: dict[str, Node] = {}

    def entry(
        self,
        name: str,
        record: type,
        take: str = "",
        /,
        *,
        maybe: Mapping[str, Any] | None = None,
        **keys: Any,  # noqa: ANN401 - types and parts of a schema
    ) -> Node:
        """Describe an object once, return a reference to it.

        Parameters
        ----------
        record : type
            What it is written from; the first line on it says what it is.
        take : str
            Its fields and properties whose type the keys have, as they are called.
        maybe : mapping of str to type
            Keys that only some of these objects have.
        **keys : type
            Those whose type is none of the record's.
        """
        named = [item.partition("=") for item in take.split()]
        always = {key: _hint(record, of or key) for key, _, of in named} | keys
        parts = {**always, **(maybe or {})}
        found = {
            "description": _said(record),
            "type": "object",
            "properties": {key: self.of(hint) for key, hint in parts.items()},
            "required": list(always),
            "additionalProperties": False,
        }
        if self.entries.setdefault(name, found) != found:
            raise ValueError(f"two kinds of objects are called {name}")
        return {"$ref": f"#/$defs/{name}"}

    def whole(self, name: str, record: type, /, **keys: Any) -> Node:  # noqa: ANN401 - as above
        """Describe a record that stands in a document as it is, with further keys."""
        own = " ".join(field.name for field in fields(record))
        return self.entry(name, record, own, **keys)

    def of(self, hint: Any) -> Node:  # noqa: ANN401 - a type, or a part already
        """Return the schema of what a type is in JSON."""
        if isinstance(hint, dict):
            return hint
        if get_origin(hint) is not None or isinstance(hint, UnionType):
            return self._of_parts(get_origin(hint), get_args(hint))
        if isinstance(hint, type) and is_dataclass(hint):
            name = re.sub("(?<=[a-z])(?=[A-Z])", "_", hint.__name__).lower()
            return self.whole(name, hint)
        if issubclass(hint, Enum):
            return {"enum": [one.value for one in hint]}
        return {"type": next(SIMPLE[one] for one in hint.__mro__ if one in SIMPLE)}

    def _of_parts(self, origin: Any, inner: tuple[Any, ...]) -> Node:  # noqa: ANN401
        """Return the schema of a type with others in it."""
        if origin is Literal:
            return {"enum": list(inner)}
        if origin in {Union, UnionType}:
            return _either([self.of(one) for one in inner])
        if issubclass(origin, abc.Mapping):
            return {"type": "object", "additionalProperties": self.of(inner[1])}
        if origin is list or inner[-1] is Ellipsis:
            return many(self.of(inner[0]))
        return {
            "type": "array",
            "prefixItems": [self.of(one) for one in inner],
            "minItems": len(inner),
            "items": False,
        }


def many(item: Node) -> Node:
    """Describe any number of things."""
    return {"type": "array", "items": item}


def _or_none(part: Node) -> Node:
    """Describe what may be null."""
    return _either([part, {"type": "null"}])


def _either(parts: list[Node]) -> Node:
    """Describe what is one of several things."""
    if all(set(part) == {"type"} for part in parts):
        return {"type": [part["type"] for part in parts]}
    return {"anyOf": parts}


def _said(record: type) -> str:
    """Return the first line on a record; its numbers are in printed units here."""
    return (record.__doc__ or "").partition("\n")[0].replace(" [SI]", "")


# What records name in annotations and import for type checkers alone.
KNOWN = {"Name": Name, "Mapping": abc.Mapping, "Sequence": abc.Sequence}


def _hint(record: type, name: str) -> Any:  # noqa: ANN401 - any type
    """Return the type of a field, or of what a property returns."""
    for owner in record.__mro__:
        text = vars(owner).get("__annotations__", {}).get(name)
        found = vars(owner).get(name)
        if text is None and isinstance(found, property):
            text = found.fget.__annotations__["return"]
        if text is not None:
            alone = {"__module__": owner.__module__, "__annotations__": {name: text}}
            return hints_of(type("_", (), alone), localns=KNOWN)[name]
    raise LookupError(f"{record.__name__} has no {name}")


# ---- what several commands write -----------------------------------------------------


def head_of(command: str | tuple[str, ...]) -> Node:
    """Describe the two keys that every document begins with."""
    commands = [command] if isinstance(command, str) else list(command)
    return {"schema": {"const": SCHEMA}, "command": {"enum": commands}}


def files_of(schema: Schema) -> Node:
    """Describe the files that a result depends on, by their roles."""
    changed = schema.entry("changed_line", Changed, line=str, to=str, **FROM)
    more: Node = {"changes": many(changed)}
    schema.entry("role_and_file", InputFile, "role name sha256", maybe=more)
    file = schema.entry("file", InputFile, "name sha256", maybe=more)
    return {"type": "object", "additionalProperties": file}


def _settings(schema: Schema) -> Node:
    """Describe what a budget depends on besides its files."""
    maybe = {"outputs", "missing"}
    left_out = {"max_trials", "validate", "matrices", *maybe}
    return schema.entry(
        "settings",
        Settings,
        " ".join(f.name for f in fields(Settings) if f.name not in left_out),
        maybe={name: _hint(Settings, name) for name in sorted(maybe)},
    )


def _filling(schema: Schema) -> Node:
    """Describe what stands for lines that are not given."""
    line = schema.entry(
        "filled_line",
        FilledLine,
        "source stands_for=expected printed unit standard_uncertainty=u devices "
        "designs of=owners interval_50 interval_90",
    )
    lines = many(line)
    return {"mode": str, "filled": lines, "left": list[str]}


def _doubt(schema: Schema) -> Node:
    """Describe a verdict that rests on predicted lines."""
    return schema.entry(
        "predicted",
        Doubt,
        "probability doubt utilisation_90",
        worth_asking=tuple[Ask, ...],
    )


def _standing(schema: Schema) -> Node:
    """Describe a verdict and what it stands on; the mission is null where none is."""
    condition = schema.entry(
        "condition",
        Condition,
        "kind line below unit largest_comparable ceiling decides not_given=silent text",
    )
    return {
        "verdict": {"enum": list(VERDICTS)},
        "calibration": str,
        "station": str,
        "use": str,
        "mission": str | None,
        "decision": str,
        "conditions": many(condition),
        "cautions": tuple[Caution, ...],
        "utilisation_at_ceilings": _hint(Standing, "at_ceilings"),
    }


def _standings(schema: Schema) -> Node:
    """Describe verdicts of triads, and of the mission, beside what stands first."""
    return many(schema.entry("standing", Standing, sensor=str, **_standing(schema)))


def _readings(schema: Schema) -> Node:
    """Describe the verdicts under the readings of lines with an open meaning."""
    one = schema.entry(
        "reading", Reading, "verdict utilisation", readings=dict[str, str]
    )
    return schema.entry(
        "reading_verdicts",
        ReadingVerdicts,
        "combinations=total passes",
        computed=many(one),
    )


def _judged(schema: Schema) -> Node:
    """Describe required outputs against their limits."""
    output = schema.entry(
        "limited_output",
        OutputAssessment,
        "limit standard_uncertainty interval interval_by largest_error utilisation "
        "conformance lower_bound nothing_known=is_unknown",
        **KEYS,
        maybe={**WHEN, "coverage": float},
    )
    return many(output)


WHEN: Node = {AT_A_TIME: float}  # of what is of a mission
# Of a length, which is a further output of a mission, with any other none is known.
JOINT: Node = {
    "description": "of all outputs; null between a horizontal length and another output"
    ", of which no covariance is known",
    "type": "array",
    "items": {"type": "array", "items": {"type": ["number", "null"]}},
}
FROM: Node = {"from": str}  # no name in Python
KEYS: Node = {
    "sensor": str,
    "parameter": str,
    "axis": str,
    "unit": str,
    "resolution": float,
}


# ---- analyze and report --------------------------------------------------------------


def _budget(schema: Schema) -> Node:
    """Describe the budget of a calibration; a report adds its further studies."""
    index: Node = dict.fromkeys(("sobol_first", "sobol_total"), float | None)
    contribution = schema.entry(
        "contribution",
        Contribution,
        "source standard_uncertainty share lower_bound",
        **index,
        maybe={
            f"sobol_{name}": _hint(SobolIndex, name)
            for name in ("first_interval", "total_interval", "interacts", "rank")
        }
        | dict.fromkeys(("u_input", "sensitivity"), float),
    )
    validation = schema.whole("validation", Validation)
    output = schema.entry(
        "output",
        OutputBudget,
        "mean standard_uncertainty lower_bound nothing_known=is_unknown lacks interval "
        "interval_by",
        **KEYS,
        coverage_factor=float | None,
        degrees_of_freedom=float | None,
        contributions=many(contribution),
        validation=_or_none(validation),
        maybe={**WHEN, **dict.fromkeys(OF_A_LENGTH, float), "coverage": float},
    )
    schema.entry(
        "mission_of_budget",
        Mission,
        "name alignment aided",
        duration=float,
        route=schema.whole("route", Outline),
        calibrations=many(
            schema.entry(
                "calibrated", Calibrated, "name cep lower_bound worse_than because"
            )
        ),
        maybe={
            "filter": schema.entry(
                "filter",
                Filtered,
                "kind states updates",
                learnt=many(
                    schema.entry("learnt", Learnt, "sensor axis time before after unit")
                ),
                believed=many(
                    schema.entry(
                        "believed",
                        BelievedError,
                        "parameter axis time standard_uncertainty true unit",
                    )
                ),
                turned=_or_none(schema.entry("turned", Turned, "time straight turned")),
            )
        },
    )
    step = schema.entry(
        "step", Step, "factor expanded_uncertainty=expanded utilisation verdict"
    )
    steps = schema.entry(
        "one_at_a_time",
        SourceSteps,
        "share lower_bound meets_up_to=most",
        source=str,
        output=str,
        unit=str,
        meets_at_any=bool,
        steps=many(step),
    )
    own = "title not_given assumptions warnings"
    return schema.entry(
        "budget",
        Budget,
        own,
        **head_of(("analyze", "report", "mission")),
        inputs=files_of(schema),
        settings=_settings(schema),
        outputs=many(output),
        quantities={"type": "object", "additionalProperties": _quantity(schema)},
        covariance=JOINT,
        assessment=_or_none(_assessment(schema)),
        maybe={
            "missing": schema.entry("missing", FilledLine, **_filling(schema)),
            # Of a report all that `budget mission` says.
            "mission": _either(
                [
                    {"$ref": f"#/$defs/{name}"}
                    for name in ("mission_of_budget", "budget")
                ]
            ),
            "readings": many(_effect(schema)),
            "matrices": _matrices(schema),
            "one_at_a_time": many(steps),
            "allocation": {"$ref": "#/$defs/allocation"},
            "comparison": {"$ref": "#/$defs/comparison"},
        },
    )


def _quantity(schema: Schema) -> Node:
    """Describe a specification line; degrees of freedom are null where infinite."""
    return schema.entry(
        "quantity",
        InputQuantity,
        "printed meaning unit standard_uncertainty=u distribution divisor origin",
        degrees_of_freedom=float | None,
    )


def _effect(schema: Schema) -> Node:
    """Describe what another reading of a line changes; a ratio over 0 is none."""
    return schema.whole("reading_effect", ReadingEffect, ratio=float | None)


def _matrices(schema: Schema) -> Node:
    """Describe the compensation matrices of each triad."""
    sized: Node = {"value": MATRIX, "standard_uncertainty": MATRIX}
    bias = schema.entry(
        "bias_of_matrix",
        Compensation,
        unit=str,
        value=VECTOR,
        standard_uncertainty=VECTOR,
    )
    triad = schema.entry(
        "matrices",
        Compensation,
        "bias_lower_bound",
        body_to_sensor=schema.entry("matrix", Compensation, value=MATRIX),
        sensor_to_body=schema.entry(
            "uncertain_matrix", Compensation, "lower_bound", **sized
        ),
        bias_sensor=bias,
        bias_body=bias,
        covariance=MATRIX,
    )
    return {
        "type": "object",
        "properties": {"convention": {"type": "string"}},
        "required": ["convention"],
        "additionalProperties": triad,
    }


def _assessment(schema: Schema) -> Node:
    """Describe a budget held against a requirement."""
    sensor = schema.entry(
        "sensor_verdict",
        SensorAssessment,
        "sensor utilisation utilisation_interval worst_output worst_outputs "
        "limiting_source trials expected_missing nothing_known",
        **_standing(schema),
        **CHANCE,
        maybe={
            "predicted": _doubt(schema),
            "not_estimated": list[str],
            "readings": _readings(schema),
        },
    )
    return schema.entry(
        "assessment",
        Assessment,
        "requirement verdict not_there",
        **CHANCE,
        sensors=many(sensor),
        outputs=_judged(schema),
        caps=tuple[CapAssessment, ...],
    )


# ---- the other studies ---------------------------------------------------------------


def _comparison(schema: Schema) -> Node:
    """Describe a ranking."""
    filling: Node = _filling(schema)
    missing = schema.entry(
        "missing_lines",
        MissingLines,
        "lines utilisation",
        assumed=list[str],
        verdict=str | None,
        maybe=filling,
    )
    entrant = (
        "name file technology sensor procedure not_given price mass power over_caps"
    )
    gap: Node = {"missing": _or_none(missing), **_standing(schema)}
    gap["unknown_caps"] = schema.of(tuple[UnknownCap, ...])
    lead = schema.entry("lead", Lead, "other probability tied=is_tied")
    device = schema.entry(
        "device_verdict",
        DeviceVerdict,
        f"{entrant} lower_bound utilisation utilisation_interval margin "
        "worst_output worst_outputs on_front advice trials",
        **gap,
        **CHANCE,
        rank=int | None,
        limiting_source=str,
        limiting_share=float,
        improvement_factor=float | None,
        ahead=_or_none(lead),
        outputs=_judged(schema),
        maybe={"predicted": _doubt(schema), "readings": _readings(schema)},
    )
    both = (
        "gyro accelerometer procedure lower_bound utilisation worst_outputs "
        "limiting_source"
    )
    more: Node = {"probability": float}
    judged = _standing(schema) | CHANCE
    imu = schema.entry(
        "imu", Pair, both, name=str, rank=int | None, **judged, maybe=more
    )
    verdict = judged["verdict"]
    pair = schema.entry("pair", Pair, both, verdict=verdict, **CHANCE, maybe=more)
    silent = schema.entry("entrant", Entrant, entrant, **gap)
    return schema.entry(
        "comparison",
        Comparison,
        f"requirement procedures met=is_met not_compared {SAID}",
        **head_of("compare"),
        caps=dict[str, str],
        inputs=many({"$ref": "#/$defs/role_and_file"}),
        settings=_settings(schema),
        devices=many(device),
        nothing_known=many(silent),
        imus=many(imu),
        pairs=many(pair),
        maybe={"mission": str},
    )


def _allocation(schema: Schema) -> Node:
    """Describe what each line may be."""
    room = schema.entry(
        "headroom",
        Headroom,
        "value all_that_stop=stopped_by",
        stopped_by=str | None,
    )
    source = schema.entry(
        "allotment",
        SourceAllotment,
        "source unit status now allowed uncorrected at_ceiling at_least "
        "spared=is_spared ceiling least binding_outputs best_offered "
        "counts=is_significant",
        sensor=str,
        binding_output=str | None,
        headroom=_or_none(room),
    )
    output = schema.entry(
        "shared_limit",
        LimitedOutput,
        "limit utilisation_now=now utilisation_allowed=allowed utilisation_floor=floor "
        "binding=is_binding lower_bound",
        output=str,
        unit=str,
        resolution=float,
        parts=tuple[LimitPart, ...],
    )
    line = schema.entry("line_match", LineMatch, "source ratio how")
    match = schema.entry(
        "match",
        Match,
        "name=device file sensor meets extra",
        lines=many(line),
    )
    relaxed: Node = {"output": str, "unit": str, "limit": float, "needed": float}
    check = schema.whole("coverage_check", CoverageCheck, corrected=bool)
    again = schema.whole("recalibration", Recalibration, is_soon=bool)
    return schema.entry(
        "allocation",
        Allocation,
        f"title feasible not_allocated not_given {SAID}",
        **head_of("allocate"),
        inputs=files_of(schema),
        standings=_standings(schema),
        settings=schema.entry(
            "allocation_settings",
            Allocation,
            "strategy seed coverage reference formulas",
            method=str,
        ),
        sources=many(source),
        outputs=many(output),
        relaxations=many(schema.entry("relaxation", LimitedOutput, **relaxed)),
        levers=tuple[LongerTest, ...],
        costs=tuple[CostReport, ...],
        checks=many(check),
        devices=many(match),
        maybe={
            "not_estimated": list[str],
            "recalibrations": many(again),
        },
    )


def _station(schema: Schema) -> Node:
    """Describe how good the figures of a station must be."""
    figure = schema.entry(
        "station_figure",
        StationFigure,
        "source unit any=is_any alone alone_stopped_by=stopped_by together "
        "binding_outputs now takes_now within=is_within why",
        owner=str,
    )
    output = schema.entry(
        "station_output",
        StationOutput,
        "limit expanded_uncertainty=expanded utilisation acceptance_limit=acceptance "
        "station_acceptance_limit=station_acceptance false_accept "
        "measurement_expanded_uncertainty=whole parameter_standard_uncertainty=prior "
        "test_uncertainty_ratio=test_ratio",
        output=str,
        unit=str,
        ratio=float | None,
        limiting_source=str | None,
        measurement_limiting_source=str | None,
    )
    station = schema.entry(
        "station_verdict",
        StationVerdict,
        "name file own=is_own verdict utilisation test_uncertainty_ratio=test_ratio "
        "false_accept",
        ratio=float | None,
        worst_output=str | None,
        limiting_source=str | None,
        outputs=many(output),
    )
    settings = schema.entry(
        "station_settings",
        Qualification,
        "strategy ratio guard coverage coverage_factor reference",
        method=str,
        formulas=str,
        most_false_accept=float,
    )
    return schema.entry(
        "stations",
        Qualification,
        f"title {SAID}",
        **head_of("station"),
        standings=_standings(schema),
        inputs=files_of(schema),
        settings=settings,
        does=bool,
        sources=many(figure),
        stations=many(station),
    )


def _export(schema: Schema) -> Node:
    """Describe the figures as a target reads them."""
    row: Node = {"key": str, "sensor": str, "axis": str, "value": float, "unit": str}
    lists: Node = {"from": list[str], "steps": list[str]}
    settings = schema.entry(
        "export_settings",
        Export,
        "rate inflate missing",
        target=str,
        residual=bool,
        reference=str | None,
    )
    return schema.entry(
        "export",
        Export,
        f"title left_out not_held notes {SAID}",
        **head_of("export"),
        inputs=files_of(schema),
        settings=settings,
        entries=many(schema.entry("exported", Export, **row, **lists)),
        sources=list[str],
    )


def _move(schema: Schema) -> Node:
    """Describe one number or word that is not what it was."""
    cause = schema.entry("cause", Change, change=str, amount=float)
    return {
        **{field.name: str for field in fields(Item)},
        **{
            key: _hint(Move, key)
            for key in ("unit", "before", "after", "difference", "relative", "times")
        },
        "sampled": bool,
        "causes": many(cause),
        "together": float | None,
        "because": str,
    }


def _check(schema: Schema) -> Node:
    """Describe stored budgets computed again."""
    reference = schema.entry(
        "reference",
        Difference,
        "name=first holds compared sampled changes",
        kind=str,
    )
    moved = schema.entry("moved", Move, reference=str, **_move(schema))
    return schema.entry(
        "check",
        Difference,
        "holds",
        **head_of("check"),
        references=many(reference),
        moved=many(moved),
        errors=list[str],
    )


def _diff(schema: Schema) -> Node:
    """Describe two budgets side by side."""
    moved = schema.entry("difference_moved", Move, **_move(schema))
    return schema.entry(
        "difference",
        Difference,
        "first second compared changes",
        **head_of("diff"),
        kind=str,
        moved=many(moved),
    )


def _devices(schema: Schema) -> Node:
    """Describe the list of devices, or one of them."""
    done: Node = {"given": int, "expected": int}
    lines = schema.entry("completeness", Sensor, **done)
    head: Node = {
        "file": str,
        "sha256": str,
        "kind": str,
        "grades": dict[str, str],
        "completeness": {"type": "object", "additionalProperties": lines},
    }
    texts = "name technology vendor price mass power"
    line = schema.entry(
        "line",
        ErrorLine,
        f"printed meaning unit {' '.join(REMARKS)}",
        line=str,
        standard_uncertainty=VECTOR,
        correlation_time=_or_none(VECTOR),
        distributions=list[str],
    )
    sensor = schema.entry(
        "sensor",
        Sensor,
        "sensor=kind not_given expected_missing",
        lines=many(line),
    )
    whole = schema.entry(
        "device",
        Device,
        f"{texts} source notes range assumptions",
        **head,
        sensors=many(sensor),
        figures=tuple[UnusedValue, ...],
    )
    row: Node = schema.entry("listed_device", Device, texts, **head)
    listed: Node = {"devices": many(row)}
    return {
        "oneOf": [
            schema.entry("device_list", Device, **head_of("devices"), **listed),
            schema.entry("one_device", Device, **head_of("devices"), device=whole),
        ]
    }


_STUDIES = (_comparison, _allocation, _station, _export)
_STORED = (_check, _diff, _devices)
