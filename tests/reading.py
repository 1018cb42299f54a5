"""What people read, as text: sentences, blocks of a page, PDF."""

from __future__ import annotations

import io
import re
import shutil
import subprocess
from dataclasses import fields, is_dataclass

import pytest
from rich.console import Console

from budget.report.blocks import ForPages, Table
from budget.report.terminal import TerminalPage, print_sections

MINUS = "\N{MINUS SIGN}"


def assert_says(text, *facts):
    """Assert that a text states facts: whole words, names and numbers with units.

    Blanks, line breaks, capitals and the kind of minus sign make no difference; a fact
    is no part of another: '9 %' is not in '19 %', nor '0.1 deg' in '0.1 deg/h'.
    """
    plain = " ".join(text.replace(MINUS, "-").split()).casefold()
    absent = [
        fact
        for fact in facts
        if not re.search(rf"(?<![\w.]){re.escape(fact.casefold())}(?!/?\w|\.\w)", plain)
    ]
    assert absent == [], f"not said: {absent}, but: {plain}"


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


needs_poppler = pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="reads PDF by poppler-utils"
)
needs_qpdf = pytest.mark.skipif(
    shutil.which("qpdf") is None, reason="checks the file by qpdf"
)
needs_verapdf = pytest.mark.skipif(
    shutil.which("verapdf") is None, reason="checks PDF/A and PDF/UA by veraPDF"
)


def ask(pdf, folder, *command):
    """Run a tool on a PDF, which comes after its first words; return what it prints."""
    path = folder / "asked.pdf"
    path.write_bytes(pdf)
    words = [str(path) if word == "FILE" else word for word in command]
    return subprocess.run(words, capture_output=True, check=True).stdout.decode()


def pages_of(pdf, folder):
    """Return the text of each page, without blanks and possible breaks."""
    text = ask(pdf, folder, "pdftotext", "-raw", "-enc", "UTF-8", "FILE", "-")
    return [squeeze(page) for page in text.split("\f")[:-1]]


def text_of(pdf, folder):
    """Return the text of the whole file, in the same way."""
    return "".join(pages_of(pdf, folder))


def squeeze(text):
    """Leave out blanks and the marks of a possible break."""
    return re.sub(r"[\s\u00ad\u200b\u2060]", "", text)


def words_beyond(pdf, folder):
    """Return the words that reach over an edge of their page."""
    boxes = ask(pdf, folder, "pdftotext", "-bbox", "FILE", "-")
    width, height = map(
        float, re.search(r'<page width="([\d.]+)" height="([\d.]+)"', boxes).groups()
    )
    words = re.findall(
        r'<word xMin="([-\d.]+)" yMin="([-\d.]+)" xMax="([-\d.]+)" yMax="([-\d.]+)">'
        r"(.*?)</word>",
        boxes,
    )
    assert words
    return [
        text
        for *edges, text in words
        for x0, y0, x1, y1 in [map(float, edges)]
        if x0 < 0.0 or y0 < 0.0 or x1 > width or y1 > height
    ]
