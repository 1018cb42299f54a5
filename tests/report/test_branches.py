"""Every branch of every page, filled in with stand-ins, in every language.

A condition of a template is answered by the test, not by a value, so that each side is
rendered once; values are stand-ins that have every attribute and print a number of
their own. What is rendered must read as a page, and have the same numbers in every
language.
"""

# The parts of the reader of pages are taken one by one.
# ruff: noqa: SLF001

from __future__ import annotations

import re
from contextlib import contextmanager
from functools import cache
from zlib import crc32

import pytest
from jinja2 import Undefined, nodes
from jinja2.runtime import Macro
from jinja2.visitor import NodeTransformer
from markupsafe import Markup

from budget import sentences
from budget.language import LANGUAGES, speaking
from budget.report import pages
from budget.report.blocks import Paragraph, Section
from budget.report.writing import FILTERS, marked
from budget.resources import own_templates, shipped, template_file, templates_of

FOLDER = shipped("templates", "pages")
NAMES = sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.md.j2"))
SIZE = 2  # turns of each loop
NUMBER = re.compile(r"\d+(?:\.\d+)?")
COUNTING = {"length", "count", "min", "max", "sum", "float", "int"}  # make a number
WORDS = {str(number) for number in range(1, 13)}
MOST = 2000  # renderings of one page: a page that needs more is too large to read


MADE = Section(name="made", title="made elsewhere", blocks=())


class StandIn(Undefined):
    """A value that has every attribute, may be called, and prints a number."""

    def __init__(self, *_, name="value", **__):
        """Keep what it stands for: the same in every language."""
        super().__init__(name=str(name))
        object.__setattr__(self, "path", str(name))

    def _of(self, how):
        return StandIn(name=f"{self.path}{how}")

    def __getattr__(self, name):
        """Return an attribute, which is another."""
        if name.startswith("__"):
            raise AttributeError(name)
        return self._of(f".{name}")

    def __getitem__(self, key):
        """Return an item, which is another."""
        return self._of(f"[{getattr(key, 'path', key)}]")

    def __call__(self, *given, **_):
        """Return what a function returns; its arguments tell it from others."""
        return self._of("".join(f"({getattr(one, 'path', one)})" for one in given))

    def __iter__(self):
        """Yield as many as a loop has turns."""
        return (self._of(f"[{place}]") for place in range(SIZE))

    def __str__(self):
        """Print its number, behind a letter: no line begins as a listing does."""
        return f"n{1000 + crc32(self.path.encode()) % 9000}"

    def __html__(self):
        """Print its number."""
        return str(self)

    def __hash__(self):
        """Tell it from others by what it stands for."""
        return hash(self.path)

    def __eq__(self, other):
        """Say whether both stand for the same."""
        return getattr(other, "path", None) == self.path

    def __lt__(self, _):
        """Return that it is no smaller."""
        return False

    __gt__ = __le__ = __ge__ = __contains__ = __lt__

    def __bool__(self):
        """Return that there is one."""
        return True

    def __int__(self):
        """Return how many turns a loop over it has."""
        return SIZE

    __index__ = __len__ = __int__

    def __float__(self):
        """Return its number."""
        return float(str(self)[1:])

    def _with(self, *_):
        return self._of("~")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _with
    __truediv__ = __rtruediv__ = __neg__ = __mod__ = __rmod__ = __pow__ = _with
    __floordiv__ = __rpow__ = _with


class Choices(NodeTransformer):
    """What a page decides by, and loops over, is asked of the test."""

    def __init__(self, name):
        self.name, self.count = name, 0

    def _ask(self, function, *given):
        self.count += 1
        place = nodes.Const(f"{self.name}:{self.count}")
        called = nodes.Name(function, "load")
        return nodes.Call(called, [place, *given], [], None, None)

    def visit_If(self, node):
        """Replace the condition of an `if` and of each `elif`."""
        node = self.generic_visit(node)
        node.test = self._ask("choose_")
        return node

    def visit_CondExpr(self, node):
        """Replace the condition of `x if y else z`."""
        node = self.generic_visit(node)
        node.test = self._ask("choose_")
        return node

    def visit_For(self, node):
        """Replace what is looped over: by some, and by nothing."""
        node = self.generic_visit(node)
        node.test = None
        node.iter = self._ask("turns_", nodes.Const(_width(node.target)))
        return node

    def visit_Assign(self, node):
        """Give `set a, b, c = x` as many values as it has names."""
        node = self.generic_visit(node)
        if isinstance(node.target, nodes.Tuple) and not isinstance(
            node.node, nodes.Tuple
        ):
            width = nodes.Const(_width(node.target))
            called = nodes.Name("parts_", "load")
            node.node = nodes.Call(called, [node.node, width], [], None, None)
        return node


def _width(target):
    """Return how many names are set; 0 of a single one."""
    if not isinstance(target, nodes.Tuple):
        return 0
    return tuple(map(_width, target.items))


def _shaped(width, path):
    """Return a stand-in, or several where several names are set."""
    if width == 0:
        return StandIn(name=path)
    return [_shaped(one, f"{path}/{place}") for place, one in enumerate(width)]


class Filters(dict):
    """Filters of pages and sentences, which return a stand-in or keep words."""

    def __missing__(self, name):
        """Return what keeps words, and makes a stand-in another."""

        def kept(value="", *given, **_):
            if name in {"each", "map"} and given and isinstance(given[0], Macro):
                return [str(given[0](one)).strip() for one in value]
            if name in {"strong", "beneath", "bar", "exact"}:
                numbers = [float(x) if isinstance(x, StandIn) else x for x in given]
                return FILTERS[name](_words(value), *numbers)
            if name in COUNTING:
                return StandIn(name=f"{name} of {getattr(value, 'path', 'words')}")
            if isinstance(value, StandIn):
                return value._of(f"|{name}")
            return _words(value)

        return kept

    def get(self, name, _=None):
        """Return that of any name: another test holds the names."""
        return self[name]


def _words(value):
    """Return words as they are, without the blanks around them."""
    if isinstance(value, list | tuple):
        return Markup(" ").join(_words(one) for one in value)
    return marked(value).strip() if isinstance(value, Markup) else marked(value)


def _safe(*_):
    """Let pages ask anything of a stand-in."""
    return True


class Explorer:
    """Renders a page under choices, and keeps which were met under which others."""

    def __init__(self):
        """Begin with no choice."""
        self.chosen, self.met, self.has_words = {}, {}, False
        environment = pages._environment().overlay(undefined=StandIn)
        parse = environment._parse

        def parsed(source, name, filename):
            return Choices(name).visit(parse(source, name, filename))

        environment._parse = parsed
        environment.bytecode_cache = None  # that of pages as they are
        environment.is_safe_callable = environment.is_safe_attribute = _safe
        environment.filters = Filters()
        environment.globals = environment.globals | {
            "choose_": self.choose,
            "turns_": lambda place, width: [
                _shaped(width, f"{place}/{k}")
                for k in range(SIZE if self.choose(place) else 0)
            ],
            "parts_": lambda value, width: _shaped(
                width, getattr(value, "path", "parts")
            ),
            "ngettext": lambda one, many, number, **parts: pages._said(
                one if self.choose(f"one: {one}") else many, **parts
            ),
            "block": lambda _: pages._block(Paragraph(words=("block",))),
            "sections": lambda _: pages._made([MADE]),
        }
        self.environment = environment

    def choose(self, place):
        """Return what is chosen there, and remember under which choices it was met."""
        value = self.chosen.get(place, True)
        self.met.setdefault((place, value), dict(self.chosen))
        return value

    def rendered(self, name, macro):
        """Return the page, or a macro of it with stand-ins for what it takes."""
        template = self.environment.get_template(f"pages/{name}")
        if macro is None:
            return template.render()
        found = getattr(template.make_module(), macro)
        if found.caller:
            return ""
        return str(found(*(StandIn(name=f"{macro}.{x}") for x in found.arguments)))

    def open(self):
        """Return choices that were met one way alone, and how to meet the other."""
        return {
            place: under | {place: not value}
            for (place, value), under in self.met.items()
            if (place, not value) not in self.met
        }


@contextmanager
def objects():
    """Let pages have blocks that are made elsewhere."""
    token = pages._objects.set([])
    try:
        yield
    finally:
        pages._objects.reset(token)


def read(text):
    """Read what was rendered as what it is: a document, sections or blocks."""
    found = pages._nodes(text)
    heads = {node.tag for node in found}
    made = pages._objects.get()
    if "h1" in heads:
        return pages._page(found, made)
    if "h2" in heads:
        return tuple(pages._sections(found, made))
    return tuple(pages._panels(found, made))


def lines(text):
    """Return the numbers of every line, in the order of the lines."""
    plain = re.sub("[\ue000-\ue00f]", " ", text)
    return [set(NUMBER.findall(row)) for row in plain.splitlines()]


def same(english, other):
    """Say whether lines have the same numbers.

    English has words for small ones, and another language may say one twice.
    """
    return len(english) == len(other) and all(
        not one - its and its - one <= WORDS
        for one, its in zip(english, other, strict=True)
    )


@cache
def explorer_of(_):
    """Return what explores the pages of a folder, which are compiled once."""
    return Explorer()


def explore(name, languages=LANGUAGES):
    """Render every branch of a page, then of its macros; yield what is found of each.

    A branch of a macro that the page has taken, by calling it, is not taken again. What
    a page without words sets may be read by its macros alone: each takes that anew.
    """
    explorer = explorer_of(own_templates())
    explorer.met, explorer.has_words = {}, False
    for macro in (None, *macros(name)):
        yield macro, *explore_one(explorer, name, macro, languages)
        if not explorer.has_words:
            explorer.met = {}


def explore_one(explorer, name, macro, languages):
    """Render a page or a macro; return how many and what differs, and what is left."""
    wrong, count, seen, tried = [], 0, [], {""}
    todo = [("", {})]
    while todo and count < MOST:
        place, explorer.chosen = todo.pop()
        if place and (place in tried or place not in explorer.open()):
            continue
        tried.add(place)
        count += 1
        texts = []
        for language in languages:
            with speaking(language), objects():
                texts.append(explorer.rendered(name, macro))
                read(texts[-1])
        if macro is None:
            explorer.has_words |= bool(texts[0].strip())
        first, *others = map(lines, texts)
        wrong += [(first, other) for other in others if not same(first, other)]
        left = explorer.open()
        # All of them at once, then one by one what another choice hides.
        both = {one: way for under in left.values() for one, way in under.items()}
        both |= {one: under[one] for one, under in left.items()}
        if both in seen:
            todo += left.items()
        else:
            seen.append(both)
            todo += [*left.items(), ("", both)]
    return count, wrong, [*explorer.open()]


def macros(name):
    """Return the macros of a page."""
    source = template_file(f"pages/{name}").read_text(encoding="utf-8")
    tree = pages._environment().parse(source)
    found = (one.name for one in tree.body if isinstance(one, nodes.Macro))
    return [name for name in found if not name.startswith("_")]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_branch_has_the_same_numbers_in_every_language(name):
    """No branch fails, is no page, loses a number or has another one in Chinese."""
    for macro, count, wrong, left in explore(name):
        assert count
        assert left == [], f"{macro}: not rendered"
        assert wrong == [], macro


@pytest.mark.parametrize("name", NAMES)
def test_every_filter_of_a_page_is_there(name):
    """A filter that is missing would be told where the branch is reached alone."""
    source = (FOLDER / name).read_text(encoding="utf-8")
    tree = pages._environment().parse(source)
    known = {**pages._environment().filters, **sentences.environment_of(None).filters}

    assert {one.name for one in tree.find_all(nodes.Filter)} <= set(known)


def test_a_lost_number_and_one_too_many_are_found():
    """The comparison can fail: lines count, stand-ins count, and so do literals."""
    told = lines("a 1234 of 95 %\nand two")

    assert same(told, lines("1234 \u7684 95 %\n2 \u4e2a"))
    assert not same(told, lines("1235 \u7684 95 %\n2 \u4e2a"))
    assert not same(told, lines("1234 \u7684 %\n2 \u4e2a"))
    assert not same(told, lines("1234 \u7684 95 % 2 \u4e2a"))


def test_a_branch_that_fails_is_found(tmp_path):
    """It is reached, however deep it lies."""
    (tmp_path / "pages").mkdir()
    page = "{% if a %}{% for x in b %}{% else %}{{ c if d else 'e' + 1 }}{% endfor %}"
    (tmp_path / "pages" / "own.md.j2").write_text(page + "{% endif %}", "utf-8")

    with templates_of(tmp_path), pytest.raises(TypeError):
        list(explore("own.md.j2"))
