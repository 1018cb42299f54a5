"""The language that reports are written in: English, or that of a catalogue.

Builders hand every sentence to `say` as a template with named parts,
`say("{output} uses {share} of its limit", output=..., share=...)`. In English it is
filled in as it is; in another language its translation is, with the parts where that
language wants them. The template is the key, as in gettext: a catalogue is a file
`languages/zh.po`, which translators' tools edit, and which is read as text when it is
first needed (nothing is compiled, no binary lies in the tree). A template without a
translation stays English.

Three things make this exact. Templates are literals in the code, so that a test finds
all of them in the syntax tree and counts those without a translation, translations
without a template, and parts that do not agree. Constants of a module are made before
anybody chose a language: `term` marks them there, and `say` says them where they are
used. And a language is a setting of the context, `speaking("zh")`, not an argument of
three hundred functions: only commands and `budget.report` set it, around the making of
a document, so that computing, errors, JSON and CSV are English always. The scripts of a
page say theirs by `word`, out of the same catalogue: `budget.report.page` hands the
translations of their templates over as data of the page.

Templates of whole documents, matched and replaced when they are complete, were the
other way; rejected, as a sentence with numbers in it cannot be told from another by
its text alone. Plurals are the choice between two templates (`counted`), lists and
colons are templates too: `say(", ").join(names)`.
"""

from __future__ import annotations

import ast
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from typing import TYPE_CHECKING, Self

from budget import names
from budget.errors import CallError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence


ENGLISH = "en"
LANGUAGES = (ENGLISH, "zh")

_language: ContextVar[str] = ContextVar("language", default=ENGLISH)


def spoken() -> str:
    """Return the language of what is written now: 'en', 'zh'."""
    return _language.get()


@contextmanager
def speaking(language: str) -> Iterator[None]:
    """Write in a language within this block.

    Raises
    ------
    CallError
        There is no catalogue of it.
    """
    if language not in LANGUAGES:
        raise CallError(f"language {language!r}, allowed: {', '.join(LANGUAGES)}")
    token = _language.set(language)
    try:
        yield
    finally:
        _language.reset(token)


class Note(str):
    """A text that keeps its template and parts: English, and sayable in any language.

    Records that outlive the context hold it (warnings, assumptions); it is its English
    text wherever one is wanted (JSON, messages, comparisons), and `say` says it.
    """

    __slots__ = ("parts", "template")

    template: str
    parts: Mapping[str, object]

    def __new__(cls, template: str, parts: Mapping[str, object]) -> Self:
        """Fill the template in English."""
        self = super().__new__(cls, template.format(**parts) if parts else template)
        self.template, self.parts = template, parts
        return self

    def __reduce__(self) -> tuple[object, ...]:
        """Keep the parts when the text is sent to another process."""
        return Note, (self.template, self.parts)

    def said(self) -> str:
        """Say it in the language of the context."""
        return say(self.template, **self.parts)


def note(text: str, /, **parts: object) -> Note:
    """Write a template in English, to be said later."""
    return Note(text, parts)


def listed(texts: Sequence[str]) -> str:
    """Write words as a sentence lists them: 'a, b and c'."""
    *most, last = texts
    if not most:
        return last
    return say("{most} and {last}", most=say(", ").join(most), last=last)


def term(text: str) -> str:
    """Mark a constant for the catalogue; `say` says it where it is used."""
    return text


def say(text: str, /, **parts: object) -> str:
    """Write a template with its parts, in the language of the context.

    Parts are formatted as by str.format; of them only notes are said here, all others
    come as they are to be read.
    """
    if isinstance(text, Note):
        return text.said()
    said = template(text)
    if not parts:
        return said
    return said.format(
        **{key: say(x) if isinstance(x, Note) else x for key, x in parts.items()}
    )


def template(text: str) -> str:
    """Return a template in the language of the context, its parts still open."""
    return _catalogue(spoken()).get(text, text)


def counted(number: int, one: str, many: str, /, **parts: object) -> str:
    """Write the template for one, or that for another number of things."""
    return say(one if number == 1 else many, **parts)


def words(name: str) -> str:
    """Turn a key into words: 'scale_factor' to 'scale factor'."""
    return say(names.words(name))


def key_title(key: str) -> str:
    """Write a key of a file as words, 'gyro bias stability'.

    Of a mission what it is and when: 'horizontal position after 1 h'.
    """
    if isinstance(key, names.Name) and key.time is not None:
        is_angle = key.quantity == "attitude"
        what = key.axis if is_angle else f"{key.axis} {key.quantity}"
        return say(
            "{what} after {time}", what=say(what), time=names.time_text(key.time)
        )
    title = names.key_title(key)
    known = _catalogue(spoken())
    if not known or title in known:
        return known.get(title, title)
    if isinstance(key, names.Name):
        return beside(words(key.owner), say(names.key_title(key.quantity)), key.axis)
    owner, *rest = names.keys_of(key)  # as a file or an assumption has it
    return beside(words(owner), words(" ".join(rest))) if rest else title


def line_title(name: names.Name) -> str:
    """Write a line of a device as words, without an axis: 'gyro bias stability'."""
    line = say(names.key_title(name.quantity))
    if not name.owner:
        return line
    return say("{owner} {line}", owner=words(name.owner), line=line)


def axis_title(name: names.Name) -> str:
    """Name an output among those of its parameter: 'x'; with its time 'north, 1 h'."""
    if name.time is None:
        return name.axis
    return say("{axis}, {time}", axis=say(name.axis), time=names.time_text(name.time))


def beside(*texts: str) -> str:
    """Set words next to each other; Chinese ones need no space between them."""
    line = ""
    for text in texts:
        space = (
            " " if line and text and (line[-1].isascii() or text[0].isascii()) else ""
        )
        line += space + text
    return line


@cache
def _catalogue(language: str) -> Mapping[str, str]:
    """Read the translations of a language, by what they translate."""
    if language == ENGLISH:
        return {}
    from importlib.resources import files

    return read_catalogue(
        (files("budget") / "languages" / f"{language}.po").read_text("utf-8")
    )


def read_catalogue(text: str) -> dict[str, str]:
    """Read a catalogue of gettext (.po): msgid, msgstr and the lines that go on."""
    found: dict[str, str] = {}
    entry = {"msgid": "", "msgstr": ""}
    key = "msgid"
    for row in [*text.splitlines(), 'msgid ""']:
        line = row
        word, _, rest = line.partition(" ")
        if word == "msgid":
            if entry["msgid"] and entry["msgstr"]:
                found[entry["msgid"]] = entry["msgstr"]
            entry = {"msgid": "", "msgstr": ""}
        if word in entry:
            key, line = word, rest
        if line.startswith('"'):
            entry[key] += ast.literal_eval(line)
    return found
