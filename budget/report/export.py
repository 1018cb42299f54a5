"""An export as the file of its target, and as sections that explain it."""

from __future__ import annotations

import re
from textwrap import wrap
from typing import TYPE_CHECKING

from budget.report.blocks import (
    Cell,
    Field,
    Listing,
    Panel,
    Paragraph,
    Section,
    table_of,
)
from budget.report.pages import sections
from budget.report.tables import print_given
from budget.studies.export.study import REFERENCE
from budget.studies.export.template import END, GONE, HEADER, KEY
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Block
    from budget.studies.export.study import Export
    from budget.studies.export.template import Exported

WIDTH = 88
OPEN, CLOSE = "<!--", "-->"  # comments of XML
# What Python (PEP 263) and editors (Vim, Emacs, YAML's server) obey in a comment.
_ORDERS = re.compile(
    r"(coding|\bvim?[<=>]?\d*|\bex|local variables|language-server|-\*)(?=[:=-])",
    re.IGNORECASE,
)
_KEYS = re.compile(f"{KEY}([^{END}]*){END}")
_DIGITS = 6  # of a value for people
_ASSUMED, _SOURCES = "Assumed", "Keys and units from"
QUIET = {_ASSUMED, _SOURCES}  # lists that stand in the file, or elsewhere


def write_export(found: Export) -> str:
    """Return the file of a target with its comments.

    A line with a key that is left out goes; before the first line of a key stands
    where its value is from.
    """
    explained: set[str] = set()
    by_key = {one.key: one for one in found.entries}
    lines: list[str] = []
    for line in found.body.splitlines():
        if line == HEADER:
            lines += _comments(_header(found), found.target.comment, "")
        elif GONE not in line:
            indent = line[: len(line) - len(line.lstrip())]
            for key in dict.fromkeys(_KEYS.findall(line)):
                if key not in explained:
                    steps = [f"{key}: {by_key[key].steps[0]}", *by_key[key].steps[1:]]
                    lines += _comments(steps, found.target.comment, indent)
                    explained.add(key)
            lines.append(_KEYS.sub("", line))
    return "\n".join(lines) + "\n"


def _header(found: Export) -> Iterator[str]:
    """Yield what stands above a file."""
    yield f"{found.target.title}: {found.title}, by budget {__version__} export"
    for file in found.inputs:
        yield f"{file.role} {file.name}, sha256 {file.sha256}"
    yield _what(found)
    for head, texts in _lists(found):
        yield f"{head}:"
        yield from (f"- {text}" for text in texts)


def _what(found: Export) -> str:
    """Say which figures they are, with factor and rate."""
    said = "The raw figures of the data sheet, 1 sigma"
    if found.procedure:
        said = (
            f"Bias, scale factor and mounting angles as left by {found.procedure} "
            f"({REFERENCE.replace('_', ' ')}), 1 sigma; the rest of the data sheet"
        )
    if found.inflate != 1.0:
        said += f"; standard deviations times {print_given(found.inflate)}"
    if found.rate is not None:
        said += f"; f = {print_given(found.rate)} Hz"
    return f"{said}."


def _lists(found: Export) -> Iterator[tuple[str, Sequence[str]]]:
    """Yield what is to be said besides, each with its head."""
    for head, texts in (
        (f"{found.target.title} cannot hold", found.not_held),
        ("Left out", found.left_out),
        ("Note", found.notes),
        (_ASSUMED, found.assumptions),
        ("Warning", found.warnings),
        (_SOURCES, found.target.sources),
    ):
        if texts:
            yield head, texts


def _comments(
    texts: Sequence[str] | Iterator[str], sign: str, indent: str
) -> list[str]:
    """Write lines of comment, which no text ends or leaves, nor gives orders in."""
    rows = [
        row
        for text in texts
        for row in wrap(
            _ORDERS.sub(r"\1 ", _printable(" ".join(text.split()))),
            WIDTH - len(indent) - len(sign) - 1,
            subsequent_indent="    ",
            break_on_hyphens=False,
        )
    ]
    if sign != OPEN:
        return [f"{indent}{sign} {row}" for row in rows]
    # Two hyphens in a row are not allowed within, nor one at the end.
    inside = [re.sub("-(?=-)", "- ", row) for row in rows]
    return [
        f"{indent}{OPEN}",
        *(f"{indent}  {row}" for row in inside),
        f"{indent}{CLOSE}",
    ]


def _printable(text: str) -> str:
    """Write what cannot be seen as escapes."""
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


def remarks(found: Export) -> tuple[str, ...]:
    """Return what a person must hear who sees the file alone, a line each."""
    return tuple(
        row
        for head, texts in _lists(found)
        if head not in QUIET
        for row in (f"{head}:", *(f"  {text}" for text in texts))
    )


def export_answer(found: Export) -> tuple[Section, ...]:
    """Return what stands on a terminal: the values, and what is not among them."""
    blocks: list[Block] = [
        Paragraph(words=(_what(found),)),
        table_of(
            found.entries,
            (
                Field(head="key", cell=lambda one: one.key),
                Field(head="value", cell=_value),
                Field(head="unit", cell=lambda one: one.unit),
                Field(head="from", cell=lambda one: ", ".join(one.lines)),
            ),
            name="export",
            caption=f"What {found.target.title} is told, from which specifications",
        ),
    ]
    blocks += [
        Panel(
            title=head,
            blocks=(Listing(items=tuple((text,) for text in texts), empty=""),),
        )
        for head, texts in _lists(found)
        if head not in QUIET
    ]
    title = f"What {found.target.title} is told"
    section = Section(name="export", title=title, blocks=tuple(blocks))
    return (section, *sections("assumptions", found=found))


def _value(one: Exported) -> Cell:
    """Return the value of a key, one where all axes are equal."""
    texts = [print_given(value, digits=_DIGITS) for value in one.values]
    return Cell(text=texts[0] if len(set(texts)) == 1 else ", ".join(texts))
