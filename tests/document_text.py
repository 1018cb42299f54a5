"""The text of a document of blocks, for tests that ask what it says."""

from __future__ import annotations

import io
from dataclasses import fields, is_dataclass

from rich.console import Console

from budget.report.blocks import ForPages, Table
from budget.report.terminal import TerminalPage, print_sections


def walk(part):
    """Yield every record of a document, from the outside in."""
    if isinstance(part, ForPages):
        yield from walk(part.blocks)
    elif is_dataclass(part):
        yield part
        for field in fields(part):
            if field.name not in {"svg", "model", "json", "tips"}:
                yield from walk(getattr(part, field.name))
    elif isinstance(part, (tuple, list)):
        for one in part:
            yield from walk(one)
    elif isinstance(part, str):
        yield part


def find(document, kind):
    """Return all records of one type."""
    return [part for part in walk(document) if isinstance(part, kind)]


def say(words):
    """Return a line of text with its formulas as they are said."""
    return "".join(
        part if isinstance(part, str) else getattr(part, "text", None) or part.alt
        for part in words
    )


def on_terminal(sections, width=100):
    """Return what a terminal of that width shows of sections."""
    text = io.StringIO()
    print_sections(sections, TerminalPage(Console(file=text, width=width)))
    return text.getvalue()


def section(document, name):
    """Return the section of that name."""
    return next(s for s in document.sections if s.name == name)


def names(document):
    """Return the names of all sections."""
    return [s.name for s in document.sections]


def lines(part):
    """Return every line of text that stands in a part of a document."""
    found = []
    for one in walk(part):
        for attribute in ("words", "text", "title", "summary", "headline"):
            value = getattr(one, attribute, None)
            if isinstance(value, tuple):
                found.append(say(value))
            elif isinstance(value, str):
                found.append(value)
        for attribute in ("items", "lines"):
            value = getattr(one, attribute, ())
            if isinstance(value, tuple):
                found += [say(words) for words in value]
    return found


def rows(part):
    """Return the rows of all tables as tuples of text."""
    return [
        tuple(cell.text for cell in row)
        for table in find(part, Table)
        for group in table.groups
        for row in group.rows
    ]
