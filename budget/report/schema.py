"""JSON Schema of result documents: every key that `--json` may write, by command.

It is made of the forms that documents are written by (budget.documents). A type is that
of the field or property of the record, where a row says none.
"""

from __future__ import annotations

from collections import abc
from enum import Enum
from importlib import import_module
from types import GenericAlias, NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from budget.documents import BY_TYPE, FORMS, SCHEMA, Form, FormRow
from budget.inputs.schema import DIALECT
from budget.known import Known
from budget.names import Name
from budget.navigation.route import Outline
from budget.recordings.calibrated import RecordedCalibration
from budget.recordings.history import CalibrationHistory
from budget.recordings.lot import CalibratedLot
from budget.recordings.printed import MeasuredLot, MeasuredUnit
from budget.recordings.records import Characterisation
from budget.recordings.results import CalibrationChange
from budget.results import Budget
from budget.studies.allocation.records import Allocation
from budget.studies.comparison.records import Comparison
from budget.studies.decide import Decision
from budget.studies.export.study import Export
from budget.studies.stations import Qualification
from budget.studies.what_if import SourceSteps

Node = dict[str, Any]  # a part of a JSON Schema

STUDIES = (
    *(Budget, Comparison, Decision, Allocation, Qualification, Export),
    Characterisation,
    RecordedCalibration,
    CalibrationChange,
    CalibrationHistory,
    CalibratedLot,
    MeasuredUnit,
    MeasuredLot,
)
STORED = ("check", "difference", "device_list", "one_device")
# Where these have their forms.
FORMING = ("budget.report.reference", "budget.report.catalogue")
SIMPLE = {
    float: "number",
    int: "integer",
    bool: "boolean",
    str: "string",
    NoneType: "null",
}
LISTS, MAPPINGS = (list, abc.Sequence, abc.Iterator), (dict, abc.Mapping)


def results_schema(*further: type) -> Node:
    """Return the JSON Schema (draft 2020-12) of all that commands write as `--json`.

    A document has no key that it does not name. `further` are records of whole ones by
    commands that stand on this package, beside its own studies.
    """
    for module in FORMING:
        import_module(module)
    schema = Schema()
    whole = [BY_TYPE[one].name for one in (*STUDIES, *further)]
    documents = [schema.entry(FORMS[name]) for name in (*whole, *STORED)]
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
        # What records name in annotations and import for type checkers alone, and rows.
        known = (Known, Name, Outline, SourceSteps, *LISTS, *MAPPINGS)
        records = (one.record for one in FORMS.values())
        self.known: Node = {one.__name__: one for one in (*known, *records)}
        self.known["Literal"] = Literal

    def entry(self, form: Form) -> Node:
        """Describe a form once, return a reference to it."""
        if form.name not in self.entries:
            found = self.entries[form.name] = {}
            properties: Node = {}
            required: dict[str, bool] = {}
            for row, hint, always in self.rows(form):
                part = self.of(hint, row.form)
                known = properties.get(row.key, part)
                said = known.pop("description", "") or row.meaning
                one = _either([known, part]) | ({"description": said} if said else {})
                properties[row.key] = one
                required |= {row.key: True} if always else {}
            found |= {
                "description": form.said,
                "type": "object",
                "properties": properties,
                "required": [*required],
                "additionalProperties": False,
            }
        return {"$ref": f"#/$defs/{form.name}"}

    def rows(self, form: Form) -> abc.Iterator[tuple[FormRow, Any, bool]]:
        """Yield the rows of keys, each with its type and whether it is always there."""
        for row in form.rows:
            always = not (row.is_maybe or row.said["when"])
            hint = self.hint(form, row)
            if row.is_spliced:
                lacks = _is_optional(hint)
                for one, own, is_there in self.rows(FORMS[row.form]):
                    yield one, _or_none(own, if_so=lacks), is_there and always
            else:
                yield row, hint, always

    def of(self, hint: Any, name: str | None = None) -> Node:  # noqa: ANN401 - a type
        """Return the schema of what a type is in JSON, of a record by its form."""
        origin, inner = get_origin(hint), get_args(hint)
        if origin in {Union, UnionType}:
            return _either([self.of(one, name) for one in inner])
        if origin in MAPPINGS:
            return {"type": "object", "additionalProperties": self.of(inner[1], name)}
        if _is_list(hint):
            item = self.entry(FORMS[name]) if name else self.of(inner[0])
            return {"type": "array", "items": item}
        if hint is not NoneType and (name or hint in BY_TYPE):
            return self.entry(FORMS[name] if name else BY_TYPE[hint])
        if origin is tuple:
            parts = [self.of(one) for one in inner]
            ends = {"minItems": len(parts), "items": False}
            return {"type": "array", "prefixItems": parts, **ends}
        return _of_simple(hint)

    def hint(self, form: Form, row: FormRow) -> Any:  # noqa: ANN401 - as above
        """Return the type of what stands under a key, before it is JSON."""
        path = row.path
        if row.said["type"]:
            found = self.read(row.said["type"], form.record)
        elif path.startswith("'"):
            found = Literal[path[1:-1]]
        elif row.form and {form.record, *form.reads} & {tuple, path.split(".")[0]}:
            found = FORMS[row.form].record
        else:
            found = self.at(form, path)
        if row.said["by"]:
            found = GenericAlias(dict, (str, get_args(found)[0]))
        found = _certain(found) if row.is_maybe else found
        return _or_none(found, if_so=bool(row.said["null"]))

    def at(self, form: Form, path: str) -> Any:  # noqa: ANN401 - as above
        """Return the type of what is at a path of a record."""
        found: Any = form.record
        is_optional = False
        for step in path.split("."):
            found = self.step(form, found, step)
            is_optional |= _is_optional(found)
            found = _certain(found)
        return _or_none(found, if_so=is_optional)

    def step(self, form: Form, hint: Any, step: str) -> Any:  # noqa: ANN401 - as above
        """Return the type of what is one step of a path further."""
        inner = get_args(hint)
        if hint is form.record and step in form.reads:
            return get_type_hints(form.reads[step], localns=self.known)["return"]
        if step == "self":
            return hint
        if step.isdecimal():
            place = 0 if _is_list(hint) else int(step)
            return _or_none(inner[place], if_so=_is_list(hint))
        if _is_list(hint):
            return GenericAlias(list, (self.field(inner[0], step),))
        if get_origin(hint) in MAPPINGS:
            return _or_none(inner[1], if_so=True)
        return self.field(hint, step)

    def field(self, record: type, name: str) -> Any:  # noqa: ANN401 - as above
        """Return the type of a field, or of what a property returns."""
        for owner in record.__mro__:
            text = vars(owner).get("__annotations__", {}).get(name)
            found = vars(owner).get(name)
            get = getattr(found, "fget", getattr(found, "func", None))  # of a property
            if text is None and get is not None:
                text = get.__annotations__["return"]
            if text is not None:
                return self.read(text, owner)
        raise LookupError(f"{record.__name__} has no {name}")

    def read(self, text: str, owner: type) -> Any:  # noqa: ANN401 - as above
        """Return the type that a text means in the module of a record."""
        alone = {"__module__": owner.__module__, "__annotations__": {"_": text}}
        return get_type_hints(type("_", (), alone), localns=self.known)["_"]


def _of_simple(hint: Any) -> Node:  # noqa: ANN401 - as above
    """Return the schema of words, numbers and texts."""
    if get_origin(hint) is Literal:
        return {"enum": list(get_args(hint))}
    if issubclass(hint, Enum):
        return {"enum": [one.value for one in hint]}
    return {"type": next(SIMPLE[one] for one in hint.__mro__ if one in SIMPLE)}


def _either(parts: list[Node]) -> Node:
    """Describe what is one of several things."""
    first, *others = parts
    if all(one == first for one in others):
        return first
    if all(set(part) == {"type"} for part in parts):
        return {"type": [part["type"] for part in parts]}
    return {"anyOf": parts}


def _is_list(hint: Any) -> bool:  # noqa: ANN401 - as above
    """Say whether a type is of any number of things."""
    is_long = get_origin(hint) is tuple and Ellipsis in get_args(hint)
    return is_long or get_origin(hint) in LISTS


def _is_optional(hint: Any) -> bool:  # noqa: ANN401 - as above
    """Say whether a type has None in it."""
    return get_origin(hint) in {Union, UnionType} and NoneType in get_args(hint)


def _or_none(hint: Any, *, if_so: bool) -> Any:  # noqa: ANN401 - as above
    """Return a type, with None where that is so."""
    return Union[hint, None] if if_so else hint  # noqa: UP007 - of any kind


def _certain(hint: Any) -> Any:  # noqa: ANN401 - as above
    """Return a type without None."""
    kept = tuple(one for one in get_args(hint) if one is not NoneType)
    return Union[kept] if _is_optional(hint) else hint  # noqa: UP007 - of any number
