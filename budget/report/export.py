"""An export as the file of its target, and as sections that explain it."""

from __future__ import annotations

import re
from textwrap import wrap
from typing import TYPE_CHECKING

from budget.inputs.tree import visible
from budget.language import ENGLISH, speaking
from budget.report.pages import line, sections, texts
from budget.report.tables import print_given
from budget.studies.export.template import END, GONE, HEADER, KEY
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Section
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
WORDS = "export_words"
QUIET = {"assumptions", "sources"}  # lists that stand in the file, or elsewhere


def write_export(found: Export) -> str:
    """Return the file of a target with its comments.

    A line with a key that is left out goes; before the first line of a key stands
    where its value is from.
    """
    explained: set[str] = set()
    by_key = {one.key: one for one in found.entries}
    lines: list[str] = []
    for row in found.body.splitlines():
        if row == HEADER:
            lines += _comments(_header(found), found.target.comment, "")
        elif GONE not in row:
            indent = row[: len(row) - len(row.lstrip())]
            for key in dict.fromkeys(_KEYS.findall(row)):
                if key not in explained:
                    steps = [f"{key}: {by_key[key].steps[0]}", *by_key[key].steps[1:]]
                    lines += _comments(steps, found.target.comment, indent)
                    explained.add(key)
            lines.append(_KEYS.sub("", row))
    return "\n".join(lines) + "\n"


def _header(found: Export) -> Iterator[str]:
    """Yield what stands above a file, in English like all of it."""
    with speaking(ENGLISH):
        yield f"{found.target.title}: {found.title}, by budget {__version__} export"
        for file in found.inputs:
            yield f"{file.role} {file.name}, sha256 {file.sha256}"
        yield line(WORDS, "what", found=found)
        for _, head, own in _lists(found):
            yield f"{head}:"
            yield from (f"- {text}" for text in own)


def _lists(found: Export) -> Iterator[tuple[str, str, Sequence[str]]]:
    """Yield what is to be said besides by its key, each with its head."""
    heads = texts(WORDS, "heads", found=found)
    for key, own in (
        *((key, getattr(found, key)) for key in ("not_held", "left_out", "notes")),
        *((key, getattr(found, key)) for key in ("assumptions", "warnings")),
        ("sources", found.target.sources),
    ):
        if own:
            yield key, getattr(heads, key), own


def _comments(
    texts: Sequence[str] | Iterator[str], sign: str, indent: str
) -> list[str]:
    """Write lines of comment, which no text ends or leaves, nor gives orders in."""
    rows = [
        row
        for text in texts
        for row in wrap(
            _ORDERS.sub(r"\1 ", visible(" ".join(text.split()))),
            WIDTH - len(indent) - len(sign) - 1,
            subsequent_indent="    ",
            break_on_hyphens=False,
        )
    ]
    if sign != OPEN:
        return [f"{indent}{sign} {row}" for row in rows]
    # Two hyphens in a row are not allowed within, nor one at the end.
    return [
        f"{indent}{OPEN}",
        *(f"{indent}  {row}" for row in [re.sub("-(?=-)", "- ", row) for row in rows]),
        f"{indent}{CLOSE}",
    ]


def remarks(found: Export) -> tuple[str, ...]:
    """Return what a person must hear who sees the file alone, a line each."""
    return tuple(
        row
        for key, head, own in _lists(found)
        if key not in QUIET
        for row in (f"{head}:", *(f"  {text}" for text in own))
    )


def export_answer(found: Export) -> tuple[Section, ...]:
    """Return what stands on a terminal: the values, and what is not among them."""
    lists = [own for key, *own in _lists(found) if key not in QUIET]
    return (
        *sections("export", found=found, lists=lists, value=_value),
        *sections("assumptions", found=found),
    )


def _value(one: Exported) -> str:
    """Return the value of a key, one where all axes are equal."""
    texts = [print_given(value, digits=_DIGITS) for value in one.values]
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts)
