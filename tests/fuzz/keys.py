"""The keys that files may have, out of the schemas, and those that move no number."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from fuzz.grammar import schema_of
from places import DOCS

from budget.model.sources import lines_of
from budget.model.sources.later import AGEING

FILES = DOCS / "files.md"


@dataclass(frozen=True)
class Key:
    """One key that a kind of file may have: where, and what may stand there."""

    path: tuple[str, ...]  # '*' for a name of the user's, '[]' for an item
    schema: dict

    def __str__(self):
        """Return the dotted path, by which pytest names it."""
        return ".".join(self.path)


def walk(schema, root, path=()):
    """Yield every key below a schema that can be given a scalar or a list of them."""
    while "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rpartition("/")[2]]
    for option in schema.get("anyOf", ()):
        yield from walk({**option, "description": ""}, root, path)
    if schema.get("type") == "object":
        for key, inner in schema.get("properties", {}).items():
            yield from walk(inner, root, (*path, key))
        if schema.get("additionalProperties"):
            yield from walk(schema["additionalProperties"], root, (*path, "*"))
    elif "$ref" in schema.get("items", {}):
        yield from walk(schema["items"], root, (*path, "[]"))
    elif "anyOf" not in schema:
        yield Key(path, schema)


def keys_of(kind):
    """Return every key of a kind of file; of several forms of a value the last one."""
    schema = schema_of(kind)
    return list({key.path: key for key in walk(schema, schema)}.values())


def table():
    """Return the docs' table of keys that move no number: where, and which."""
    text = FILES.read_text(encoding="utf-8")
    text = text.partition("### Keys that move no number")[2]
    part = text.partition("\n## ")[0]
    rows = re.findall(r"^\| ([a-z ]+) \| (`.*) \|$", part, re.MULTILINE)
    assert len(rows) > 4, "the table is not there, or has another form"
    return [(where, re.findall("`([a-z_]+)`", words)) for where, words in rows]


TABLE = table()


def is_of_use(kind, path):
    """Say whether a key states what a unit is used in, and not what a test is."""
    if path[0] == "environment" and kind == "procedure":
        return len(path) == 1 or path[1:] in {("temperature",), ("vibration",)}
    return path[0] == "age" or (
        path[0] == "environment" and kind in {"requirement", "mission"}
    )


@cache
def silent(kind, path):
    """Say whether the docs have this key among those that move no number."""
    used = is_of_use(kind, path)
    surroundings = (
        kind in {"procedure", "station"}
        and path[0] in {"station", "environment"}
        and not used
    )
    figure = (kind == "device" and "errors" in path) or surroundings or used
    name = ".".join(path[1:-1]) if surroundings else "".join(path[2:3])
    owner = path[0]
    if used:
        owner, *steps = ("environment", *path) if path[0] == "age" else path
        name = "age" if "age" in steps else f"{''.join(steps[:1])}.mission"
    process = figure and any(
        line.process for line in lines_of(owner) if line.name == name
    )
    is_ageing = (
        kind == "device" and {*path[2:3]} <= {*AGEING.values()} and len(path) > 3
    )
    ages = is_ageing and path[-1] == "horizon" and "axes" not in path
    for where, keys in TABLE:
        applies = {
            "every file": path[0] in keys,
            "every file but costs": kind != "costs" and path[0] in keys,
            "a specification value": figure and path[-1] in keys and not ages,
            "a specification value of a process": process and path[-1] in keys,
            "an asymmetry of an accelerometer": path[0] == "accelerometer"
            and path[-1] in keys,
            "an ageing": is_ageing and path[-1] in keys,
            "a range": "range" in path[:2] and path[-1] in keys,
            "a limit on a mission": path[:2] == ("limits", "mission")
            and path[-1] in keys,
            "g sensitivity by axis": "g_sensitivity" in path
            and any(axis in keys for axis in path),
        }.get(
            where, where == kind and path[kind == "mission" and len(path) > 1] in keys
        )
        if applies:
            return True
    return False


KEYS = {
    kind: keys_of(kind)
    for kind in ("device", "procedure", "station", "mission", "requirement", "costs")
}
