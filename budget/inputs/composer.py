"""Compose a YAML 1.2 text into nodes with positions, within strict limits."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import yaml
from yaml import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    MarkedYAMLError,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    YAMLError,
)

from budget.errors import Issue
from budget.inputs.tree import (
    LONGEST_SHOWN,
    MOST_ISSUES,
    START,
    Location,
    Node,
    all_of,
    describe,
)
from budget.units import NUMBER

if TYPE_CHECKING:
    from collections.abc import Iterator

    from yaml import Event
    from yaml._yaml import Mark as MarkInC
    from yaml.error import Mark as MarkInPython

    from budget.errors import SpecError

# A device file has about 100 nodes on 6 levels.
MOST_NODES = 5_000
MOST_LEVELS = 20

# Control characters, unpaired surrogates, line breaks that editors do not count, and
# marks that reorder a line on the screen, so that it shows what it does not say.
# In braces a comma ends a value: what of '0,007 deg/h' becomes a key.
PART = re.compile(r"\.\d+(?:[eE][+-]?\d+)?(?: [^.]*)?$")
DECIMAL = "of a decimal write a point (0.5, not 0,5); "
UNSAFE = re.compile(
    "[^\t\n\r\x20-\x7e\xa0-\u2027\u202f-\u2065\u2070-\ud7ff\ue000-\ufefe"
    "\uff00-\ufffd\U00010000-\U0010ffff]"
)

# Only the events of the parser are taken, which are those of YAML 1.2; what a word is,
# its own loaders take from 1.1, where `no` is false, 010 is 8 and 1e-6 is text. By the
# library in C, which every wheel has, the catalogue is read in a tenth of the time.
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

# The core schema of YAML 1.2 (10.3.2) without octal, hexadecimal, inf and nan: those
# stay text, as 010 and 1_000 do, and are refused where a number is needed.
_NULL = {"", "~", "null", "Null", "NULL"}
_BOOL = {
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
BREAK = re.compile("\r\n|\r|\n")  # of a line
_INTEGER = re.compile("[+-]?(?:0|[1-9][0-9]{0,17})")
_FLOAT = re.compile(NUMBER)


def compose(text: str, file: str, *, path: str = "") -> tuple[Node, list[Issue]]:
    """Compose the only document of a text; messages name it `file`.

    Where it stands for a part of another file, `path` is that part, and all nodes name
    this one.

    Returns its root and what did not stop the reading: duplicate and unreadable keys,
    empty values, aliases, anchors and tags.

    Raises
    ------
    SpecError
        The text is no YAML, has a second document or breaks a limit.
    """
    composer = _Composer(text, file, path)
    try:
        return composer.document(), composer.issues
    except MarkedYAMLError as error:
        what = ", ".join(filter(None, (error.context, error.problem)))
        mark = composer.place(error.problem_mark or error.context_mark)
    # An escape like \UFFFFFFFF: the parser in Python lets slip what chr() says, without
    # a place.
    except (YAMLError, ValueError, OverflowError) as error:
        what, mark = str(error), composer.latest
    hint = "look at indentation, colons, brackets and quotes, here and above"
    composer.report(mark, "", f"is no YAML: {what}; {hint}")
    raise all_of(composer.issues)


def forbid(character: str) -> str:
    """Say that a character is one of UNSAFE."""
    return f"character U+{ord(character):04X} is not allowed; remove it"


class _Composer:
    """Takes parser events one by one, so that no limit is passed before it is seen."""

    def __init__(self, text: str, file: str, path: str) -> None:
        self.events: Iterator[Event] = yaml.parse(text, Loader=LOADER)
        self.written = text.rstrip()
        self.file, self.path = file, path
        self.own = file if path else ""  # name of every node
        self.issues: list[Issue] = []
        self.nodes = 0
        self.latest = START  # where the node that was entered last stands

    def document(self) -> Node:
        """Return the root of the only document."""
        root = None
        for event in self.events:
            if isinstance(event, NodeEvent):
                root = self.node(event, self.path, 1)
            elif isinstance(event, DocumentStartEvent) and root is not None:
                message = "a second document starts here, expected one in a file"
                raise self.stop(self.place(event.start_mark), message)
        if root is None:
            raise self.stop(START, "the file is empty, expected keys with values")
        return root

    def node(
        self, event: Event, path: str, level: int, key: Location | None = None
    ) -> Node:
        """Return the node that starts with this event."""
        at = self.enter(event, path, level)
        value: str | float | bool | tuple[Node, ...] | dict[str, Node] | None = None
        written = ""
        if isinstance(event, MappingStartEvent):
            value = self.mapping(path, level)
        elif isinstance(event, SequenceStartEvent):
            value = self.sequence(path, level)
        elif isinstance(event, ScalarEvent):
            written = event.value
            value = written if event.style else _resolve(written)
            if not written and not event.style:
                at = key or at  # the parser marks what follows
            if value is None:
                more = DECIMAL if PART.search(path) else ""
                text = f"is empty, expected a value; {more}or remove the key"
                self.report(at, path, text)
            elif unsafe := UNSAFE.search(written):
                self.report(at, path, forbid(unsafe[0]))
                value = None
        return Node(
            value=value,
            written=written,
            path=path,
            at=at,
            key=key or at,
            file=self.own,
        )

    def mapping(self, path: str, level: int) -> dict[str, Node]:
        """Return the values by key, up to the end of the mapping."""
        nodes: dict[str, Node] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            word, mark = self.key(event, path, level + 1)
            inner = f"{path}.{_shown(word)}" if path else _shown(word)
            child = self.node(next(self.events), inner, level + 1, mark)
            first = nodes.setdefault(word, child)
            if first is not child and word:
                place = f"{first.key.line}:{first.key.column}"
                self.report(mark, inner, f"duplicate key, first at {place}; keep one")
        nodes.pop("", None)
        return nodes

    def key(self, event: Event, path: str, level: int) -> tuple[str, Location]:
        """Return a key and its place; '' where it is no word, which is an issue."""
        if isinstance(event, ScalarEvent):
            word, mark = event.value, self.enter(event, path, level)
        else:
            word, mark = "", self.node(event, path, level).at
        if not word or UNSAFE.search(word):
            self.report(mark, path, "a key is no word, expected one")
            word = ""
        return word, mark

    def sequence(self, path: str, level: int) -> tuple[Node, ...]:
        """Return the items, up to the end of the sequence."""
        nodes: list[Node] = []
        while not isinstance(event := next(self.events), SequenceEndEvent):
            nodes.append(self.node(event, f"{path}[{len(nodes)}]", level + 1))
        return tuple(nodes)

    def enter(self, event: Event, path: str, level: int) -> Location:
        """Count a node, hold the limits and report what hides what a file says."""
        at = self.latest = self.place(event.start_mark)
        self.nodes += 1
        if self.nodes > MOST_NODES:
            raise self.stop(at, f"more than {MOST_NODES} keys and values in a file")
        if level > MOST_LEVELS:
            raise self.stop(at, f"more than {MOST_LEVELS} levels of nesting")
        anchor, tag = getattr(event, "anchor", None), getattr(event, "tag", None)
        if isinstance(event, AliasEvent):
            self.report(at, path, f"alias {describe(anchor)}; write the value itself")
        elif anchor is not None:
            self.report(at, path, f"anchor {describe(anchor)}; remove it")
        if tag is not None:
            self.report(at, path, f"tag {describe(str(tag))}; remove it")
        return at

    def report(self, mark: Location, path: str, message: str) -> None:
        """Keep an issue."""
        self.issues.append(
            Issue(
                file=self.file,
                line=mark.line,
                column=mark.column,
                field=path,
                message=message,
            )
        )
        if len(self.issues) > MOST_ISSUES:
            raise all_of(self.issues)

    def place(self, mark: MarkInC | MarkInPython | None) -> Location:
        """Return a place counted from 1; of what is missing, where the text ends."""
        if mark is None:
            return START
        if mark.index < len(self.written):
            return Location(mark.line + 1, mark.column + 1)
        *before, last = BREAK.split(self.written)
        return Location(len(before) + 1, len(last) + 1)

    def stop(self, mark: Location, message: str) -> SpecError:
        """Return the error of a file that is not read on."""
        self.report(mark, "", message)
        return all_of(self.issues)


def _resolve(word: str) -> str | float | bool | None:
    """Return what an unquoted word is."""
    if word in _NULL:
        return None
    if word in _BOOL:
        return _BOOL[word]
    if _INTEGER.fullmatch(word):
        return int(word)
    return float(word) if _FLOAT.fullmatch(word) else word


def _shown(key: str) -> str:
    """Return a key as part of a path: short, on one line, nothing invisible."""
    short = key if len(key) <= LONGEST_SHOWN else f"{key[:LONGEST_SHOWN]}..."
    return short if short.isprintable() else ascii(short)
