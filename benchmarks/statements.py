"""How much code there is: statements, functions, classes and sentences in Python.

Run `python benchmarks/statements.py`, or with `--against REVISION` to set a git
revision beside it. Rooms are the folders of `budget/`, the files beside them are the
ground, and `examples/` is one. A statement is an `ast.stmt` that is neither an import
nor a docstring: a longer line is no fewer of them. Sentences are calls of what says
one; of the files in `templates/` lines are counted.
"""

from __future__ import annotations

import argparse
import ast
import io
import subprocess
import tarfile
from collections import Counter
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

ROOT = Path(__file__).resolve().parent.parent
PACKAGE, EXAMPLES, TEMPLATES = TOPS = "budget", "examples", "templates"
COUNTED = ("statements", "functions", "classes")
SAYING = ("say", "note", "term", "counted")  # of budget/language.py
SENTENCES = {"sentences": SAYING}
GROUND, TOTAL = "(ground)", "total"
IMPORTS = (ast.Import, ast.ImportFrom)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
DOCUMENTED = (ast.Module, ast.ClassDef, *FUNCTIONS)


def count(source: str) -> Counter[str]:
    """Return how many of each kind stand in one file of Python."""
    found: Counter[str] = Counter()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False):
            found["statements"] -= 1
        if isinstance(node, ast.stmt) and not isinstance(node, IMPORTS):
            found["statements"] += 1
        if isinstance(node, FUNCTIONS):
            found["functions"] += 1
        if isinstance(node, ast.ClassDef):
            found["classes"] += 1
        if isinstance(node, ast.Call):
            called = getattr(node.func, "attr", getattr(node.func, "id", None))
            found[called] += called in SAYING
    return found


def rooms(files: dict[str, str]) -> dict[str, Counter[str]]:
    """Return the counts of each room and of all, from texts by their paths."""
    found: dict[str, Counter[str]] = {}
    for path, text in sorted(files.items()):
        top, *inside, _ = PurePosixPath(path).parts
        if top == PACKAGE and path.endswith(".py"):
            room, counts = inside[0] if inside else GROUND, count(text)
        elif top == EXAMPLES and path.endswith(".py"):
            room, counts = EXAMPLES, count(text)
        elif top == TEMPLATES:
            room, counts = TEMPLATES, Counter({TEMPLATES: len(text.splitlines())})
        else:
            continue
        for name in (room, TOTAL):
            found.setdefault(name, Counter()).update(counts)
    found[TOTAL] = found.pop(TOTAL, Counter())
    return found


def tree(root: Path) -> dict[str, str]:
    """Return the texts of a checkout by their paths."""
    return {
        path.relative_to(root).as_posix(): path.read_text(encoding="utf-8")
        for top in TOPS
        for path in (root / top).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def revision(root: Path, name: str) -> dict[str, str]:
    """Return the texts of a git revision by their paths."""
    packed = subprocess.run(
        ["git", "archive", "--format=tar", name],  # noqa: S607
        cwd=root,
        capture_output=True,
        check=True,
    ).stdout
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        return {
            member.name: stream.read().decode()
            for member in archive
            if member.name.partition("/")[0] in TOPS
            and (stream := archive.extractfile(member))
        }


def table(counts: dict[str, dict[str, Counter[str]]]) -> str:
    """Write counts, by the name of what they are of, as one table of 80 columns."""
    if len(counts) == 1:
        kinds, below = (*COUNTED, *SAYING), (TEMPLATES,)
        widths = [len(kind) + 2 for kind in kinds]
    else:
        kinds, below = (*COUNTED, "sentences"), (*SAYING, TEMPLATES)
        widths = [16 // len(counts)] * (len(kinds) * len(counts))

    def row(head: str, cells: Iterable[object]) -> str:
        pairs = zip(cells, widths, strict=False)
        return f"{head:<14}" + "".join(f"{cell:>{width}}" for cell, width in pairs)

    def numbers(room: str, *asked: str) -> list[int]:
        return [
            sum(one.get(room, Counter())[name] for name in SENTENCES.get(kind, (kind,)))
            for kind in asked
            for one in counts.values()
        ]

    named = {room: None for one in counts.values() for room in one}
    order = [room for room in named if room not in {TEMPLATES, TOTAL}] + [TOTAL]
    lines = [row(room, numbers(room, *kinds)) for room in order]
    lines += [row(kind, numbers(TOTAL, kind)) for kind in below]
    if len(counts) == 1:
        return "\n".join([row("room", kinds), *lines])
    heads = " " * 14 + "".join(f"{kind:>16}" for kind in kinds)
    return "\n".join([heads, row("room", [*counts] * len(kinds)), *lines])


def main(words: list[str] | None = None, root: Path = ROOT) -> str:
    """Return the table that is asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--against", metavar="REVISION", help="git revision beside it")
    against = parser.parse_args(words).against
    was = {"was": rooms(revision(root, against))} if against else {}
    return table({**was, "now": rooms(tree(root))})


if __name__ == "__main__":
    print(main())
