"""The file that a target reads, from its template; and what a person is told of it."""

from __future__ import annotations

import re
from string import Template
from textwrap import wrap
from typing import TYPE_CHECKING

from budget.report.blocks import (
    Cell,
    Field,
    Listing,
    Panel,
    Paragraph,
    Section,
    assumptions_section,
    table_of,
)
from budget.report.document import csv_text
from budget.report.tables import print_given
from budget.resources import shipped
from budget.studies.export.study import REFERENCE
from budget.studies.export.targets import ONE
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.report.blocks import Block
    from budget.studies.export.study import Export, Exported

WIDTH = 88
OPEN, CLOSE = "<!--", "-->"  # comments of XML
COLUMNS = ("key", "sensor", "axis", "value", "unit", "from")
# What Python (PEP 263) and editors (Vim, Emacs, YAML's server) obey in a comment.
_ORDERS = re.compile(
    r"(coding|\bvim?[<=>]?\d*|\bex|local variables|language-server|-\*)(?=[:=-])",
    re.IGNORECASE,
)
_NAMES = re.compile(r"\$\{?([A-Za-z]\w*)\}?")
_DIGITS = 6  # of a value for people
_ASSUMED, _SOURCES = "Assumed", "Keys and units from"
QUIET = {_ASSUMED, _SOURCES}  # lists that stand in the file, or elsewhere


def write_export(found: Export) -> str:
    """Fill the template of a target in.

    A line with a key that is left out goes; before the first line of a key stands
    where its value is from.
    """
    text = (shipped("templates") / "export" / found.target.template).read_text("utf-8")
    explained: set[str] = set()
    by_key = {one.entry.key: one for one in found.entries}
    values = dict(_values(found))
    absent = {entry.key for entry in found.target.entries} - by_key.keys()
    lines: list[str] = []
    for line in text.splitlines():
        names = _NAMES.findall(line)
        if line == "$header":
            lines += _comments(_header(found), found.target.comment, "")
            continue
        keys = [key for name in names for key in _keys_of(name, by_key.keys() | absent)]
        if any(key in absent for key in keys):
            continue
        indent = line[: len(line) - len(line.lstrip())]
        for key in dict.fromkeys(keys):
            if key not in explained:
                steps = [f"{key}: {by_key[key].steps[0]}", *by_key[key].steps[1:]]
                lines += _comments(steps, found.target.comment, indent)
                explained.add(key)
        lines.append(Template(line).substitute(values))
    return "\n".join(lines) + "\n"


def _keys_of(name: str, keys: set[str]) -> list[str]:
    """Return the key that a name of a template is of: itself, or one of its axes."""
    return [key for key in keys if name == key or re.fullmatch(f"{key}_[xyz]", name)]


def _values(found: Export) -> Iterator[tuple[str, str]]:
    """Yield what stands for each name in the template."""
    yield "gravity", print_double(found.gravity)
    if found.rate is not None:
        yield "rate", print_double(found.rate)
    for one in found.entries:
        texts = [print_double(value) for value in one.values]
        if one.entry.axes == ONE:
            yield one.entry.key, texts[0]
            continue
        yield one.entry.key, f"[{', '.join(texts)}]"
        for axis, text in zip(one.entry.axes, texts, strict=True):
            yield f"{one.entry.key}_{axis}", text


def print_double(value: float) -> str:
    """Print a number so that every reader reads that very double.

    With a point in it, without which YAML 1.1 reads 1e-06 as a text.
    """
    mantissa, mark, exponent = repr(float(value)).partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}{mark}{exponent}"


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
                Field(head="key", cell=lambda one: one.entry.key),
                Field(head="value", cell=_value),
                Field(head="unit", cell=lambda one: one.entry.unit),
                Field(head="from", cell=lambda one: ", ".join(one.lines)),
            ),
            name="export",
            caption=f"What {found.target.title} is told, with the lines it is from",
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
    return (section, assumptions_section(found.assumptions))


def _value(one: Exported) -> Cell:
    """Return the value of a key, one where all axes are equal."""
    texts = [print_given(value, digits=_DIGITS) for value in one.values]
    return Cell(text=texts[0] if len(set(texts)) == 1 else ", ".join(texts))


def export_csv(found: Export) -> str:
    """Write one row for each key and axis, in the unit of the target."""
    return csv_text(COLUMNS, map(_flat, found.rows()))


def _flat(row: Mapping[str, object]) -> dict[str, object]:
    """Return a record with its lists as texts."""
    return {
        key: ", ".join(map(str, value)) if isinstance(value, list) else value
        for key, value in row.items()
    }
