"""Write the tables of pages that are made from data of the package."""  # noqa: INP001 - a script, no package

from __future__ import annotations

import inspect
from pathlib import Path
from types import ModuleType
from typing import Any

import budget
from budget.cli import app
from budget.cli.options import OutputFiles
from budget.inputs.makers import readings
from budget.inputs.schema import TABLES as KINDS
from budget.inputs.specification import SpecificationValue
from budget.report.schema import results_schema
from budget.settings import CLI, Asked, Engine, Inputs, rows
from budget.studies.export.template import LEAVE_OUT, ZERO, keys_of, targets
from zhao_2019.study import PaperStudy

DOCS = Path(__file__).resolve().parent
MARKS = {LEAVE_OUT: " (optional)", ZERO: " (0)"}


def words() -> list[str]:
    """Return one row for each line: the words of makers, and how to read them."""
    rows = ["| makers print | line | before it is one |", "|---|---|---|"]
    for one in readings():
        for place, (line, names) in enumerate(one.words.items()):
            says = "as above" if place else one.says
            rows.append(f"| {', '.join(names)} | [`{line}`](#{one.anchor}) | {says} |")
    return rows


def exports() -> list[str]:
    """Return one row for each target: keys with their units, and where from."""
    rows = ["| `--to` | target | keys [unit] | read in |", "|---|---|---|---|"]
    for target in targets().values():
        keys = ", ".join(
            f"`{key}` [{unit}]{MARKS.get(absent, '')}"
            for key, unit, absent in keys_of(target)
        )
        rate = ", `--rate`" if target.needs_rate else ""
        sources = "; ".join(target.sources)
        rows.append(f"| `{target.name}`{rate} | {target.title} | {keys} | {sources} |")
    return rows


def names() -> list[str]:
    """Return one row for each public name: what it is, in its own words."""
    rows = ["| name | what it is |", "|---|---|"]
    for name in sorted(set(budget.__all__) - {"__version__"}, key=str.lower):
        found = getattr(budget, name)
        if isinstance(found, ModuleType):  # `report`, a package that can be called
            found = vars(found)[name]
        said = (inspect.getdoc(found) or "").partition("\n")[0]
        rows.append(f"| `budget.{name}` | {said.replace('|', chr(92) + '|')} |")
    return rows


def keys() -> list[str]:
    """Return a table for each kind of object in result documents, top ones first."""
    schema = results_schema(PaperStudy)
    top = [ref for part in schema["oneOf"] for ref in part.get("oneOf", [part])]
    first = [_name(ref) for ref in top]
    rows: list[str] = []
    for name in dict.fromkeys([*first, *schema["$defs"]]):
        entry = schema["$defs"][name]
        rows += ["", f"## {name.replace('_', ' ')}", "", entry["description"]]
        if by := entry["properties"].get("command"):
            rows[-1] += f" Written by {' and '.join(f'`{one}`' for one in by['enum'])}."
        rows += ["", "| key | is | what |", "|---|---|---|"]
        for key, part in entry["properties"].items():
            marked = f"`{key}`" if key in entry["required"] else f"*`{key}`*"
            said = part.get("description", "").replace("|", "\\|")
            rows.append(f"| {marked} | {_type(part)} | {said} |")
    return [*rows, ""]


def options() -> list[str]:
    """Return one row for each option that several commands have: in which it is."""
    found: dict[str, list[str]] = {}
    for command in app.registered_commands:
        name = command.callback.__name__ if command.callback else ""
        for kind in (Inputs, Asked, Engine, OutputFiles):
            for row in rows(kind, name, CLI).values():
                found.setdefault(row.flag, []).append(name)
    return [
        "| option | commands |",
        "|---|---|",
        *(
            f"| `{option}` | {', '.join(f'`{one}`' for one in names)} |"
            for option, names in sorted(found.items())
            if len(names) > 1
        ),
    ]


def files() -> list[str]:
    """Return a table for each kind of file: every key, what it may be, what it means.

    What a specification value and a range may say docs/files.md has, once for all.
    """
    rows: list[str] = []
    for kind, table in KINDS.items():
        rows += ["", f"## {kind.capitalize()}", "", "| key | is | absent | meaning |"]
        rows += ["|---|---|---|---|", *_rows_of(table().tables[0], "")]
    return [*rows, ""]


TOLD = {"range", "variants", "figures", "windows.windows", "segments.segments"}


def _rows_of(table: Any, path: str) -> list[str]:  # noqa: ANN401
    """Return the rows of a mapping and of those in it, but for the same again."""
    found: list[str] = []
    # Costs of one line are those of every other.
    most = 1 if table.title == "costs_by_line" else None
    for key, row in [*table.rows.items()][:most]:
        name = f"{path}{key}"
        inside = row.kind.tables[:1]
        whole = any(issubclass(one.record, SpecificationValue) for one in inside)
        is_told = whole or any(name.endswith(end) for end in TOLD)
        shown = row.usual if isinstance(row.usual, str | int | float) else ""
        if isinstance(row.usual, tuple):
            shown = ", ".join(row.usual)
        absent = "must be given" if row.is_needed else f"`{shown}`" if shown else ""
        said = row.says.partition("; printed as")[0].replace("|", "\\|")
        what = "specification value" if whole else _allowed(row.schema({}))
        found.append(f"| `{name}` | {what} | {absent} | {said} |")
        for one in () if is_told else inside:
            is_by_axis = one.title.startswith("by_axis")
            found += [] if is_by_axis else _rows_of(one, f"{name}.")
    return found


def _allowed(schema: dict[str, Any]) -> str:
    """Say in a few words what a file may have."""
    if "anyOf" in schema:
        return " or ".join(dict.fromkeys(map(_allowed, schema["anyOf"])))
    if words := schema.get("enum") or [schema[x] for x in ("const",) if x in schema]:
        return ", ".join(f"`{word}`" for word in words)
    if "examples" in schema:
        return f"in {schema['examples'][0].removeprefix('1 ')}"
    if schema.get("type") == "array":
        inner = schema.get("items") or schema["prefixItems"][0]
        return f"list of {_allowed(inner)}"
    if "minimum" in schema:
        return f"{schema['minimum']:g} to {schema['maximum']:g}"
    return {"string": "text", "boolean": "true or false"}.get(
        schema.get("type", ""), "mapping"
    )


def _name(ref: dict[str, Any]) -> str:
    """Return what a reference leads to."""
    return str(ref["$ref"]).rpartition("/")[2]


def _type(part: dict[str, Any]) -> str:
    """Say in a few words what a part of the schema may be."""
    if "$ref" in part:
        name = _name(part)
        return f"[{name.replace('_', ' ')}](#{name.replace('_', '-')})"
    if "enum" in part or "const" in part:
        return ", ".join(f"`{one}`" for one in part.get("enum", [part.get("const")]))
    if "anyOf" in part:
        return " or ".join(_type(one) for one in part["anyOf"])
    if "prefixItems" in part:
        return f"{len(part['prefixItems'])} {_type(part['prefixItems'][0])}s"
    kinds = part["type"] if isinstance(part["type"], list) else [part["type"]]
    inner = {
        "array": ("list of", "items"),
        "object": ("by name:", "additionalProperties"),
    }
    return " or ".join(
        f"{inner[kind][0]} {_type(part[inner[kind][1]])}" if kind in inner else kind
        for kind in kinds
    )


TABLES = {
    "datasheets.md": ("words", words),
    "export.md": ("targets", exports),
    "library.md": ("names", names),
    "documents.md": ("keys", keys),
    "commands.md": ("options", options),
    "keys.md": ("keys of files", files),
}


def page(name: str) -> str:
    """Return a page with the present table in it."""
    title, rows = TABLES[name]
    begin = f"<!-- {title}: made by docs/make_tables.py -->\n"
    end = f"<!-- end of {title} -->\n"
    head, _, rest = (DOCS / name).read_text(encoding="utf-8").partition(begin)
    _, _, tail = rest.partition(end)
    return head + begin + "\n".join(rows()) + "\n" + end + tail


if __name__ == "__main__":
    for name in TABLES:
        (DOCS / name).write_text(page(name), encoding="utf-8")
