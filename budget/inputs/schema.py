"""JSON Schemas of the files, for editors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema

from budget.errors import CallError
from budget.inputs.costs import costs_file_type
from budget.inputs.device import whole_file_type
from budget.inputs.mission import MissionFile
from budget.inputs.procedure import ProcedureFile
from budget.inputs.requirement import RequirementFile
from budget.inputs.station import StationFile

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import BaseModel
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import core_schema

DIALECT = "https://json-schema.org/draft/2020-12/schema"

_MODELS: dict[str, Callable[[], type[BaseModel]]] = {
    "device": whole_file_type,
    "procedure": lambda: ProcedureFile,
    "station": lambda: StationFile,
    "mission": lambda: MissionFile,
    "requirement": lambda: RequirementFile,
    "costs": costs_file_type,
}


def json_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a kind of file.

    It knows keys, types and units; what several keys say together only `validate`
    checks.

    Raises
    ------
    CallError
        There is no such kind.
    """
    if kind not in _MODELS:
        raise CallError(f"no files of kind {kind!r}, expected {', '.join(_MODELS)}")
    return schema_of(_MODELS[kind](), f"budget {kind} file")


def schema_of(model: type, title: str) -> dict[str, Any]:
    """Return the JSON Schema of a model of a file, under a title."""
    schema = TypeAdapter(model).json_schema(schema_generator=_Generator)
    return {"$schema": DIALECT, **schema, "title": title}


class _Generator(GenerateJsonSchema):
    """Writes schemas of files, in which an unset key is absent and never null."""

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        """Describe the value alone."""
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Describe a default only where it says something."""
        if schema.get("default") in (None, "", (), {}):
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)
