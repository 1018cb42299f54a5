"""Sections of blocks from templates/pages: Markdown with Jinja2, for every medium.

A page is a template that is given values and prints Markdown, which becomes the blocks
that terminal, HTML and PDF show. What it may write:

    ## Title {:name}                    a section; `{:name first}` is of page one,
                                        `{:name page}` of pages, not of a terminal
    ### Title                           a panel of it, up to the next heading or `---`
    Words **bold** $n_x$ {{ u|number }} a paragraph, a formula, an exact number
    > Words                             a small paragraph
    - point   1. point                  listings
    $$ n_x/m $$ words                   a displayed formula, and its number or what it
                                        is of; those of one paragraph side by side
    Table: caption {:name wide}         what the table below it shows
    | text | number | unit |            columns by alignment: `---`, `--:`, `:-:`; in a
    |---|--:|:-:|                       head `?` for one that goes where nothing stands
    | = title |                         in it, `{1.4}` for its weight, `{code}` for its
                                        kind, `{used}` what a script knows it by,
                                        `{below}` where a narrow page has it, below
                                        the row, `{more}` there after a tap, or
                                        several; a group of rows
    | | |  |---|---|  | term | words |  without caption and heads: terms, what they are
    Brief: words                        what a terminal prints in place of the section
    Empty: words                        that there are no points of a listing, muted
    {{ block(x) }}                      a block that is made elsewhere: a figure; in a
                                        sentence a formula, in a cell a stacked bar
    {{ sections(x) }}                   sections that are made elsewhere
    {% call abreast(3) %} {% endcall %} panels and figures in it beside each other

A whole document begins with `# Title`, a listing of facts, the headline, the summary
(each a paragraph) and its cards (`### Title`, a paragraph a line); sections follow. The
words of a figure, and of what is made elsewhere, are macros of a page; where one says
several things, each is a point that begins with its name: `- title: words`.

Sentences stand in `{% trans %}`, whole, with their values as named parts. No value is
read as Markdown, whatever stands in it. Filters round and write values; a template
has no access to anything else.
"""

from __future__ import annotations

import re
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cache
from itertools import groupby, pairwise
from operator import attrgetter
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from budget.language import spoken, template
from budget.report.blocks import (
    Abreast,
    Block,
    Card,
    Cell,
    Column,
    Document,
    Equation,
    Equations,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    RowGroup,
    Run,
    Section,
    Shares,
    Table,
)
from budget.report.writing import (
    BAR,
    BENEATH,
    END,
    EXACT,
    FILTERS,
    OBJECT,
    OF,
    WIDE,
    Marked,
    marked,
    shown,
)
from budget.resources import own_templates, telling
from budget.sentences import PAGE, message_key, module_of, translating
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from jinja2.sandbox import SandboxedEnvironment
    from markdown_it import MarkdownIt
    from markdown_it.tree import SyntaxTreeNode

    from budget.report.blocks import Words
    from budget.report.formulas import Math
    from budget.results import Verdict

    Object = Block | Math | Section | Shares  # what is made elsewhere

_MARK = re.compile(f"([{EXACT}{OBJECT}{BENEATH}{BAR}])([^{END}]*){END}")
# At the end of a title, and of a head, as the page has them: a value has them hidden.
_NAMED = re.compile(r"\s*\{:([^\s{}]+)((?: \w+)*)\}$")
_HEAD = re.compile(r"(\?)?(?:\{([\w. ]+)\})?$")
# What Markdown reads, or a mark, in words that a template has printed.
_READ = re.compile(
    rf"[*\\`$|#>{EXACT}{OBJECT}{BENEATH}{BAR}]|^\s*(?:[-+]|\d+[.)])", re.MULTILINE
)
_POINTS = re.compile(r"^- (\w+):", re.MULTILINE)
_PLACES = re.compile(r"\{(\w+)\}")
KINDS = {"right": "number", "center": "unit"}
MARKED_KINDS = {"code", "drawing"}
_FORMULA = re.compile(r"(\$\$?)([^$]+)\1")
_TAG = re.compile(r"\{%.*?%\}")
TABLE, BRIEF, EMPTY = "Table: ", "Brief: ", "Empty: "
NARROW = {"below", "more"}  # of columns: see `Column.when_narrow`
_objects: ContextVar[list[Object]] = ContextVar("objects")


@dataclass(frozen=True, kw_only=True)
class Page:
    """What a page of a whole document says: see `budget.report.blocks.Document`."""

    title: str
    facts: tuple[str, ...]
    headline: str
    summary: Words
    cards: tuple[Card, ...]
    sections: tuple[Section, ...]

    def whole(self, kind: str, *ends: Section, json: str, date: str) -> Document:
        """Return the document of a kind, with the sections that end it."""
        own = replace(self, sections=(*self.sections, *ends))
        return Document(
            kind=kind, **vars(own), json=json, date=date, version=__version__
        )


def sections(page: str, /, **view: object) -> tuple[Section, ...]:
    """Return the sections of a page, filled in with values, in the language spoken."""
    with telling(_file(page)):
        return tuple(_sections(*_filled(page, view)))


def section(page: str, /, **view: object) -> Section:
    """Return the only section of a page."""
    (found,) = sections(page, **view)
    return found


def document(page: str, /, **view: object) -> Page:
    """Return what a page says that is a whole document."""
    with telling(_file(page)):
        return _page(*_filled(page, view))


def blocks(page: str, macro: str = "", /, **view: object) -> tuple[Block, ...]:
    """Return the blocks of a page that has no section, or of one of its macros."""
    with telling(_file(page)):
        return tuple(_panels(*_filled(page, view, macro)))


def cards(page: str, macro: str = "", /, **view: object) -> tuple[Card, ...]:
    """Return the cards of a page without sections, or of one of its macros."""
    with telling(_file(page)):
        return tuple(_cards(*_filled(page, view, macro)))


def table(page: str, macro: str = "", /, **view: object) -> Table:
    """Return the table of a page, or of one of its macros."""
    return next(one for one in blocks(page, macro, **view) if isinstance(one, Table))


def line(page: str, macro: str = "", /, **view: object) -> str:
    """Return the words of a page, or of one of its macros, as plain text."""
    with telling(_file(page)):
        return _plain(_printed(page, view, macro))


def lines(page: str, macro: str = "", /, **view: object) -> tuple[str, ...]:
    """Return the words of each line of a page, or of one of its macros, as text."""
    with telling(_file(page)):
        return tuple(filter(None, map(_plain, _printed(page, view, macro).split("\n"))))


def texts(page: str, macro: str, /, **view: object) -> SimpleNamespace:
    """Return the points of a macro, `- name: words`, by their names as plain text."""
    with telling(_file(page)):
        return _points(_printed(page, view, macro))


def figure(page: str, macro: str, /, **view: object) -> tuple[SimpleNamespace, Table]:
    """Return what a figure says, the points of a macro, and the table below them."""
    with telling(_file(page)), _gathering() as objects:
        points, mark, rows = _printed(page, view, macro).partition(f"\n{TABLE}")
        own = _blocks(_nodes(mark + rows), objects)
        return _points(points), next(one for one in own if isinstance(one, Table))


def runs(page: str, macro: str = "", /, **view: object) -> Words:
    """Return the words of a page, or of one of its macros: bold, exact, formulas."""
    with telling(_file(page)):
        nodes, objects = _filled(page, view, macro)
        return tuple(word for node in nodes for word in _words(node, objects))


# ---- Markdown to blocks --------------------------------------------------------------


@cache
def _reader() -> MarkdownIt:
    """Return what reads the Markdown of a page, and nothing else of Markdown."""
    from markdown_it import MarkdownIt

    inside = ("emphasis", "escape", "newline")
    rules = ("heading", "hr", "list", "blockquote", "table", *inside)
    return MarkdownIt("zero").enable(rules)


def _file(page: str) -> str:
    """Return the file of a page among the templates."""
    return PAGE.format(page)


def _filled(
    page: str, view: Mapping[str, object], macro: str = ""
) -> tuple[Sequence[SyntaxTreeNode], Sequence[Object]]:
    """Fill a page, or a macro of it, in with values, and read it."""
    with _gathering() as objects:
        return _nodes(_printed(page, view, macro)), objects


def _points(text: str) -> SimpleNamespace:
    """Return points that begin with their names, by these as plain text."""
    _, *points = _POINTS.split(text)
    named = zip(points[::2], map(_plain, points[1::2]), strict=True)
    return SimpleNamespace(**dict(named))


def _plain(text: str) -> str:
    """Return what has been printed as plain text in a line."""
    if _READ.search(text) is None:
        return shown(" ".join(re.split("[ \n]+", text.strip(" \n"))))
    with _gathering():
        return " ".join(map(_text, _nodes(text)))


@contextmanager
def _gathering() -> Iterator[list[Object]]:
    """Gather what is made elsewhere and put into a page."""
    objects: list[Object] = []
    token = _objects.set(objects)
    try:
        yield objects
    finally:
        _objects.reset(token)


def _printed(page: str, view: Mapping[str, object], macro: str) -> str:
    """Return what a page, or a macro of it, prints of values."""
    template = _environment().get_template(_file(page))
    if not macro:
        return template.render(view)
    found = getattr(module_of(template, spoken()), macro, None)
    if found is None:
        raise LookupError(f"the macro {macro!r} is missing")
    return str(found(**view))


def _nodes(text: str) -> Sequence[SyntaxTreeNode]:
    """Read the Markdown of a page; a value in a formula is a part of it."""
    from markdown_it.tree import SyntaxTreeNode

    text = _FORMULA.sub(_formula, text)
    text = text.replace("****", "")  # bold words that others follow run on
    return SyntaxTreeNode(_reader().parse(text)).children


def _formula(found: re.Match[str]) -> Marked:
    """Put a formula of a page into it; between double signs it is displayed."""
    from budget.report.formulas import Math

    math = Math(source=shown(" ".join(found[2].split())))
    if found[1] == "$":
        return _block(math)
    return _block(Equations(equations=(Equation(math=math),)))


def _page(nodes: Sequence[SyntaxTreeNode], objects: Sequence[Object]) -> Page:
    """Return what stands before the first section, and the sections."""
    (_, head), *_ = _under({"h2"}, nodes)
    (_, (title, *rest)), *_ = _under({"h3"}, head)
    facts = [one for one in rest if one.type == "bullet_list"]
    headline, *said = [one for one in rest if one.type == "paragraph"]
    return Page(
        title=_text(title),
        facts=tuple(_text(one) for listing in facts for one in listing.children),
        headline=_text(headline),
        summary=tuple(
            word
            for k, one in enumerate(said)
            for word in ((" ",) if k else ()) + tuple(_words(one, objects))
        ),
        cards=tuple(_cards(head, objects)),
        sections=tuple(_sections(nodes[len(head) :], objects)),
    )


def _cards(
    nodes: Sequence[SyntaxTreeNode], objects: Sequence[Object]
) -> Iterator[Card]:
    """Yield the cards that headings of the third level begin, a paragraph a line."""
    for title, own in _under({"h3"}, nodes):
        if title is not None:
            rows = tuple(_words(one, objects) for one in own)
            yield Card(title=_text(title), lines=rows)


def _sections(
    nodes: Sequence[SyntaxTreeNode], objects: Sequence[Object]
) -> Iterator[Section]:
    """Yield the sections that headings of the second level begin."""
    for title, own in _under({"h2"}, nodes):
        if title is None:
            continue
        if isinstance(made := next(iter(_words(title, objects)), None), Section):
            yield made
            continue
        said, name, how = _named(title)
        brief = [one for one in own if _raw(one).startswith(BRIEF)]
        yield Section(
            name=name,
            title=said,
            blocks=tuple(_panels([one for one in own if one not in brief], objects)),
            on_first_page="first" in how,
            in_brief=_text(brief[0]).removeprefix(BRIEF)
            if brief
            else ("" if "page" in how else None),
        )


def _panels(
    nodes: Sequence[SyntaxTreeNode], objects: Sequence[Object]
) -> Iterator[Block]:
    """Yield blocks, those below a heading of the third level in a panel."""
    for title, own in _under({"h3", "hr"}, nodes):
        blocks = tuple(_blocks(own, objects))
        if title is None or title.tag == "hr":
            yield from blocks
        else:
            yield Panel(title=_text(title), blocks=blocks)


def _under(
    tags: set[str], nodes: Sequence[SyntaxTreeNode]
) -> Iterator[tuple[SyntaxTreeNode | None, Sequence[SyntaxTreeNode]]]:
    """Part nodes at headings and lines: what stands before the first has none."""
    heads = [place for place, node in enumerate(nodes) if node.tag in tags]
    for start, end in zip([-1, *heads], [*heads, len(nodes)], strict=True):
        if start >= 0 or end > 0:
            yield (nodes[start] if start >= 0 else None), nodes[start + 1 : end]


def _blocks(
    nodes: Sequence[SyntaxTreeNode], objects: Sequence[Object]
) -> Iterator[Block]:
    """Yield the block of each node; a caption is of the table below it."""
    caption: SyntaxTreeNode | None = None
    for node in nodes:
        match node.type:
            case "paragraph" if _raw(node).startswith(TABLE):
                caption = node
            case "paragraph" if _raw(node).startswith(EMPTY):
                yield Listing(items=(), empty=_text(node).removeprefix(EMPTY))
            case "paragraph":
                yield _paragraph(_words(node, objects))
            case "blockquote":
                for one in node.children:
                    yield Paragraph(words=_words(one, objects), small=True)
            case "bullet_list" | "ordered_list":
                yield Listing(
                    items=tuple(
                        _words(one.children[0], objects) for one in node.children
                    ),
                    empty="",
                    numbered=node.type == "ordered_list",
                )
            case "table" if caption is None and not _text(node.children[0]).strip():
                rows = (
                    row.children for part in node.children[1:] for row in part.children
                )
                yield Pairs(
                    rows=tuple((_text(one), _words(of, objects)) for one, of in rows)
                )
            case "table":
                yield _table(node, caption, objects)
                caption = None


def _paragraph(words: Any) -> Block:  # noqa: ANN401 - words, and blocks made elsewhere
    """Return a paragraph, or what stands in its place: formulas, a block of its own."""
    match words:
        case (Equations(), *_):
            return Equations(equations=tuple(_equations(words)))
        case (one,) if isinstance(one, Block):
            return one
    return Paragraph(words=words)


def _equations(words: Any) -> Iterator[Equation]:  # noqa: ANN401 - likewise
    """Yield displayed formulas, each with the words behind it as its number."""
    for one, behind in pairwise((*words, "")):
        if isinstance(one, Equations):
            said = behind.strip() if isinstance(behind, str) else ""
            for own in one.equations:
                yield replace(own, number=said or own.number)


def _table(
    node: SyntaxTreeNode, caption: SyntaxTreeNode | None, objects: Sequence[Object]
) -> Table:
    """Return a table with its caption, columns and groups of rows."""
    said, name, how = _named(caption)
    (head,) = node.children[0].children
    columns, optional = zip(*map(_column, head.children), strict=True)
    groups: list[tuple[str, list[tuple[Cell, ...]]]] = [("", [])]
    for row in node.children[1].children if len(node.children) > 1 else ():
        cells = tuple(_cell(one, objects) for one in row.children)
        if _raw(row.children[0]).startswith("="):
            groups.append((cells[0].text.removeprefix("=").strip(), []))
        else:
            groups[-1][1].append(cells)
    groups = [(title, rows) for title, rows in groups if rows]
    kept = [
        place
        for place, may_go in enumerate(optional)
        if not may_go or any(row[place].text for _, rows in groups for row in rows)
    ]
    return Table(
        name=name,
        caption=said.removeprefix(TABLE),
        columns=tuple(columns[place] for place in kept),
        groups=tuple(
            RowGroup(title=t, rows=tuple(tuple(row[k] for k in kept) for row in rows))
            for t, rows in groups
        ),
        is_wide="wide" in how,
        searchable="searchable" in how,
        for_pen="pen" in how,
    )


def _column(node: SyntaxTreeNode) -> tuple[Column, bool]:
    """Return a column, and whether it goes where nothing stands in it."""
    text, (mark, more) = _ended_by(_HEAD, node)
    align = str(node.attrs.get("style", "")).removeprefix("text-align:")
    column = Column(head=text.rstrip(), kind=KINDS.get(align, "text"))
    for one in (more or "").split():
        column = (
            replace(column, weight=float(one))
            if one[0].isdigit()
            else replace(column, when_narrow=one)
            if one in NARROW
            else replace(column, kind=one)
            if one in MARKED_KINDS
            else replace(column, role=f"{column.role} {one}".strip())
        )
    return column, bool(mark)


def _cell(node: SyntaxTreeNode, objects: Sequence[Object]) -> Cell:
    """Return a cell: its text, what it is exactly, bars and remark."""
    text, exact, share, note, strong, shares = "", None, None, "", False, None
    for word in _words(node, objects):
        if isinstance(word, Shares):
            shares = word
        elif isinstance(word, tuple):
            kind, value = word
            if kind == BAR:
                share = float(value)
            else:
                note += value
        elif isinstance(word, Run):
            text += word.text
            strong |= word.strong
            exact = word.exact if word.exact is not None else exact
        else:
            text += str(word)
    return Cell(
        text=text.rstrip() if shares is None else text.strip(),
        exact=exact,
        share=share,
        strong=strong,
        note=note.strip(),
        shares=shares,
    )


def _named(node: SyntaxTreeNode | None) -> tuple[str, str, set[str]]:
    """Return a title or caption, its name and what else stands in its braces."""
    if node is None:
        return "", "", set()
    text, (name, how) = _ended_by(_NAMED, node)
    return text, shown(name or ""), set((how or "").split())


def _ended_by(
    pattern: re.Pattern[str], node: SyntaxTreeNode
) -> tuple[str, tuple[str | None, ...]]:
    """Return words without what a page has put behind them, and the groups of that."""
    text, raw = _text(node), _raw(node)
    found = pattern.search(raw)
    if found is None:
        return text, (None,) * pattern.groups
    return text[: len(text) - len(found[0])], found.groups()


def _text(node: SyntaxTreeNode) -> str:
    """Return the text of a heading or a head."""
    return "".join(
        word if isinstance(word, str) else getattr(word, "text", "")
        for word in _words(node)
    )


def _raw(node: SyntaxTreeNode) -> str:
    """Return the text of a node as the page has it: no value begins with a mark."""
    return "".join(child.content for child in node.children)


def _words(node: SyntaxTreeNode, objects: Sequence[Object] = ()) -> Any:  # noqa: ANN401 - words, and marks of cells
    """Return the words of a node; numbers and bold ones as runs, marks as they are."""
    found: list[Any] = []
    for text, strong in _inline(node):
        at = 0
        for mark in _MARK.finditer(text):
            _add(found, text[at : mark.start()], strong=strong)
            kind, value = mark[1], mark[2]
            if kind == OBJECT:
                found.append(objects[int(value)])
            elif kind == EXACT:
                exact, _, said = value.partition(OF)
                size = int(exact) if exact.isdecimal() else float(exact)
                found.append(Run(text=shown(said), strong=strong, exact=size))
            else:
                found.append((kind, shown(value)))
            at = mark.end()
        _add(found, text[at:], strong=strong)
    return tuple(found)


def _add(found: list[Any], text: str, *, strong: bool) -> None:
    """Add words to those before; plain ones run on."""
    said = shown(re.sub("[ \n]+", " ", text))
    if strong and said:
        found.append(Run(text=said, strong=True))
    elif said and found and isinstance(found[-1], str):
        found[-1] += said
    elif said:
        found.append(said)


def _inline(
    node: SyntaxTreeNode, *, strong: bool = False
) -> Iterator[tuple[str, bool]]:
    """Yield the texts of a node, and whether each is bold."""
    for child in node.children:
        if child.type == "text":
            yield child.content, strong
        elif child.type in {"softbreak", "hardbreak"}:
            yield " ", strong
        else:
            yield from _inline(child, strong=strong or child.type == "strong")


# ---- values to Markdown --------------------------------------------------------------


def _environment() -> SandboxedEnvironment:
    """Return what fills templates in: no value is Markdown, none may be missing."""
    return _environment_of(own_templates())


@cache
def _environment_of(_: Path | None) -> SandboxedEnvironment:
    """Return that of a folder of templates that go before those that ship."""
    from jinja2.ext import Extension

    class Lines(Extension):
        """A line of tags alone is no line of the page; any other keeps its end."""

        def preprocess(self, source: str, *_: object) -> str:
            return "\n".join(map(_ended, source.split("\n")))

    environment = translating(_said, Lines, finalize=marked)
    environment.globals |= {
        "block": _block,
        "sections": _made,
        "abreast": _abreast,
    }
    environment.filters |= {
        **FILTERS,
        "runs": _in_runs,
        "by": _by,
        "standing": _standing,
    }
    return environment


def _ended(line: str) -> str:
    """Keep the end of a line that has words in it or after which a sentence ends."""
    has_words = _TAG.sub("", line).strip() or "endtrans" in line
    is_open = line.endswith("%}") and line[-3] not in "-+"
    return f"{line[:-2]}+%}}" if has_words and is_open else line


def messages(source: str) -> set[str]:
    """Return the sentences of a template, as the catalogue of a language has them."""
    found = _environment().extract_translations(source)  # type: ignore[attr-defined]
    texts = [
        text
        for _, _, one in found
        for text in ((one,) if isinstance(one, str) else one)
    ]
    return {message_key(text) for text in texts if text}


def _said(message: str, /, **parts: object) -> Marked:
    """Say a sentence of a template in the language spoken; its parts are values.

    What a template has made of them has no blanks around it.
    """
    said = template(message_key(message)).translate(WIDE)
    return Marked(_PLACES.sub(lambda one: _part(parts[one[1]]), said))


def _part(value: object) -> str:
    """Return a part of a sentence."""
    return marked(value).strip() if isinstance(value, Markup) else marked(value)


def _block(value: Object) -> Marked:
    """Put a block, or a formula, that is made elsewhere into the page."""
    _objects.get().append(value)
    return Marked(f"{OBJECT}{len(_objects.get()) - 1}{END}")


def _made(found: Section | Iterable[Section] | None) -> Marked:
    """Put sections that are made elsewhere into the page."""
    own = (found,) if isinstance(found, Section) else found or ()
    return Marked("\n".join(f"## {_block(one)}" for one in own))


def _abreast(columns: int = 2, *, caller: Callable[[], str]) -> Marked:
    """Put panels and figures beside each other."""
    nodes = _nodes(caller())
    own: Any = tuple(_panels(nodes, _objects.get()))
    return _block(Abreast(blocks=own, columns=columns))


def _in_runs(
    records: Iterable[Any], by: str | Callable[[Any], object]
) -> Iterator[tuple[object, list[Any]]]:
    """Yield runs of records that have something in common, with what it is."""
    key = attrgetter(by) if isinstance(by, str) else by
    for common, own in groupby(records, key):
        yield common, list(own)


def _standing(standing: Verdict) -> tuple[str, ...]:
    """Return what a verdict stands on, and what qualifies it, in words."""
    return lines("standing", "stands", standing=standing)


def _by(records: Iterable[Any], by: str) -> list[tuple[object, list[Any]]]:
    """Return records that have something in common together, in order of the first."""
    key = attrgetter(by)
    found: dict[object, list[Any]] = {}
    for one in records:
        found.setdefault(key(one), []).append(one)
    return list(found.items())
