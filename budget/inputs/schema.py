"""JSON Schemas of the files, for editors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.errors import CallError
from budget.inputs.costs import costs_table
from budget.inputs.device import device_table
from budget.inputs.fields import Schemas, ValueKind, table
from budget.inputs.mission import MissionFile
from budget.inputs.procedure import ProcedureFile
from budget.inputs.recording import RecordingFile
from budget.inputs.requirement import RequirementFile
from budget.inputs.station import StationFile

if TYPE_CHECKING:
    from collections.abc import Callable

DIALECT = "https://json-schema.org/draft/2020-12/schema"

TABLES: dict[str, Callable[[], ValueKind]] = {
    "device": device_table,
    "procedure": lambda: table(ProcedureFile),
    "station": lambda: table(StationFile),
    "mission": lambda: table(MissionFile),
    "requirement": lambda: table(RequirementFile),
    "costs": costs_table,
    "recording": lambda: table(RecordingFile),
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
    if kind not in TABLES:
        raise CallError(f"no files of kind {kind!r}, expected {', '.join(TABLES)}")
    return schema_of(TABLES[kind](), f"budget {kind} file")


def schema_of(kind: ValueKind, title: str) -> dict[str, Any]:
    """Return the JSON Schema of the rows of a file, under a title."""
    tables: Schemas = {}
    kind.described(tables)
    own, *others = tables.values()
    parts = {one["title"]: one for one in others}
    return {"$schema": DIALECT, **own, "title": title, "$defs": parts}
