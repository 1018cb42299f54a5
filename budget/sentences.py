"""Sentences that records keep, as macros of templates/pages, said in any language.

`sentence("cautions.few_trials", trials=...)` is the macro `few_trials` of
templates/pages/cautions.md.j2, filled in in English; `budget.language.say` says it in
the language of the context, from the templates of one's own where there are any. JSON
and messages have the English of the shipped one, always.
"""

from __future__ import annotations

import re
from functools import cache, lru_cache
from typing import TYPE_CHECKING, cast

from markupsafe import Markup

from budget.language import (
    ENGLISH,
    Note,
    key_title,
    line_title,
    listed,
    say,
    speaking,
    spoken,
    template,
    words,
)
from budget.names import Name, time_text
from budget.resources import (
    own_templates,
    telling,
    template_environment,
    templates_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path
    from typing import Any, Self

    from jinja2 import BaseLoader, Template
    from jinja2.sandbox import SandboxedEnvironment

PAGE = "pages/{}.md.j2"  # the file of a page among the templates
_PLACE = re.compile(r"([^.]+)\.(\w+)")  # page and macro
_PARTS = re.compile(r"%\((\w+)\)s|%%")
_MACRO = re.compile(r"(?ms)^\{% macro (\w+)\(.*?\{% endmacro %\}$")
_WORD = re.compile(r"(?<!\|)\b\w+")
# Values of which a sentence is the same whenever they are: 1 and True are not.
PLAIN = {str, Name, int, float, bool, type(None)}


class Sentence(Note):
    """A text that keeps the macro it is and its values: English, sayable in any."""

    __slots__ = ()

    def __new__(
        cls, place: str, parts: Mapping[str, object], english: str | None = None
    ) -> Self:
        """Fill the macro in in English, from the templates that ship."""
        text = _english(place, parts) if english is None else english
        self = str.__new__(cls, text)
        self.template, self.parts = place, parts
        return self

    def __reduce__(self) -> tuple[object, ...]:
        """Keep the values, and the text, when it is sent to another process."""
        return Sentence, (self.template, self.parts, str(self))

    def said(self) -> str:
        """Say it in the language of the context."""
        return str(self) if _is_kept() else _filled(self.template, self.parts)


def sentence(place: str, /, **parts: object) -> Sentence:
    """Fill a macro, 'page.macro', in with values, to be said later."""
    if any(type(one) not in PLAIN for one in parts.values()):
        return Sentence(place, parts)
    return _kept(place, tuple(parts.items()), tuple(map(type, parts.values())))


def described(text: str) -> str:
    """Return what a source says: one of our sentences, or a text from outside."""
    return sentence(text) if text.startswith("sources.") else text


@lru_cache(maxsize=4096)
def _kept(
    place: str, parts: tuple[tuple[str, object], ...], _: tuple[type, ...]
) -> Sentence:
    """Return a sentence of plain values, which a comparison has a thousand times."""
    return Sentence(place, dict(parts))


@cache
def message_key(message: str) -> str:
    """Return what the catalogue calls a sentence of Jinja2: parts in braces."""
    return _PARTS.sub(lambda one: f"{{{one[1]}}}" if one[1] else "%", message)


@cache
def module_of(template: Template, language: str) -> Any:  # noqa: ANN401, ARG001 - macros by name; what a page sets is in a language
    """Return the macros of a page in a language."""
    return template.make_module()


def _is_kept() -> bool:
    """Whether what is said now is what sentences keep."""
    return spoken() == ENGLISH and own_templates() is None


def _english(place: str, parts: Mapping[str, object]) -> str:
    """Fill a macro that ships in, in English."""
    if _is_kept():
        return _filled(place, parts)
    with speaking(ENGLISH), templates_of(None):
        return _filled(place, parts)


def _filled(place: str, parts: Mapping[str, object]) -> str:
    """Fill a macro in, in the language of the context."""
    ((page, name),) = _PLACE.findall(place)
    said = None if own_templates() is None else _by_own(page, name, parts)
    if said is None:
        said = str(_shipped_macro(page, name, spoken())(**parts))
    return " ".join(said.split()) if "\n" in said else said


def _by_own(page: str, name: str, parts: Mapping[str, object]) -> str | None:
    """Fill a macro of one's own in; None: it is left to the one that ships."""
    file = PAGE.format(page)
    with telling(file):
        template = environment_of(own_templates()).get_template(file)
        macro = getattr(module_of(template, spoken()), name, None)
        return None if macro is None else str(macro(**parts))


@cache
def _shipped_macro(page: str, name: str, language: str) -> Callable[..., str]:
    """Return a macro that ships, in a language."""
    macro: Callable[..., str] = getattr(module_of(_shipped(page, name), language), name)
    return macro


@cache
def _shipped(page: str, name: str) -> Template:
    """Return a page that ships with one macro and those that it uses: all take long."""
    with templates_of(None):
        environment = environment_of(None)
    loader = cast("BaseLoader", environment.loader)
    source, file, _ = loader.get_source(environment, PAGE.format(page))
    macros = {one[1]: one[0] for one in _MACRO.finditer(source)}
    used, found = {name}, [name]
    while found:
        words = {*_WORD.findall(macros.get(found.pop(), ""))} & macros.keys()
        found += words - used
        used |= words

    def kept(macro: re.Match[str]) -> str:
        return macro[0] if macro[1] in used else "\n" * macro[0].count("\n")

    code = environment.compile(_MACRO.sub(kept, source), PAGE.format(page), file)
    return environment.template_class.from_code(
        environment, code, environment.make_globals(None)
    )


@cache
def environment_of(_: Path | None) -> SandboxedEnvironment:
    """Return what fills sentences in; they are text, and no value is escaped."""
    environment = translating(_said, finalize=_plain)
    environment.filters |= {
        "said": say,
        "words": words,
        "key": key_title,
        "line": line_title,
        "time": time_text,
        "each": _each,
        "thousands": lambda count: f"{count:,}".replace(",", " "),
        "commas": _commas,
        "listed": lambda texts: listed([str(_plain(one)) for one in texts]),
    }
    return environment


def translating(
    said: Callable[..., Markup], *extensions: object, finalize: Callable[..., Markup]
) -> SandboxedEnvironment:
    """Return what fills templates in, with sentences said in the language spoken.

    `said` fills a message of Jinja2 in, of one thing or of another number of them.
    """

    def counted(one: str, many: str, number: int, /, **parts: object) -> Markup:
        return said(one if number == 1 else many, **parts)

    environment = template_environment(
        finalize=finalize, extensions=["jinja2.ext.i18n", *extensions]
    )
    environment.policies["ext.i18n.trimmed"] = True
    environment.newstyle_gettext = True  # type: ignore[attr-defined]
    environment.globals |= {"gettext": said, "ngettext": counted}
    return environment


def _plain(value: object) -> Markup:
    """Return a value as text; a note is said."""
    return Markup(say(value) if isinstance(value, Note) else str(value))  # noqa: S704 - text, no HTML


def _said(message: str, **parts: object) -> Markup:
    """Say a sentence of a template in the language spoken."""
    found = {key: str(_plain(value)).strip() for key, value in parts.items()}
    said = template(message_key(message))
    return Markup(re.sub(r"\{(\w+)\}", lambda one: found[one[1]], said))  # noqa: S704 - text, no HTML


def _each(records: Iterable[Any], write: Callable[[Any], str]) -> list[str]:
    """Return what a macro writes of each record."""
    return [write(one) for one in records]


def _commas(texts: Iterable[object], mark: str = ", ") -> str:
    """Put texts in a row, with a mark of the language between them."""
    return say(mark).join(str(_plain(one)) for one in texts)
