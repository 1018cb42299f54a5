"""Check the nodes of a file against a model; all that is wrong, each at its place."""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from budget.earth import ROTATION_RATE
from budget.inputs.fields import KEY, Later
from budget.inputs.makers import MEANINGS, bare, lines_by_word, reading_of
from budget.inputs.tree import LONGEST_SHOWN, MOST_ISSUES, all_of, describe, plain
from budget.model.sources import every_source, from_outside, twin_of
from budget.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from pydantic_core import ErrorDetails

    from budget.errors import Issue
    from budget.inputs.tree import Node, YamlFile

Model = TypeVar("Model", bound=BaseModel)

_SLIP = 0.85  # likeness from which a word of a file is a slip of another

_EARTH_RATE = (
    f"; the earth rate is that of WGS 84, {ROTATION_RATE / DEG_PER_HOUR:.4f} deg/h, a "
    "turn in a sidereal day and not in 24 h; what is not known of it is "
    "station.earth_rate"
)

# Of a limit on a horizontal error, by what others call its radius.
_RADIUS = {
    "radius": "did you mean 'horizontal'?",
    "circle": "did you mean 'horizontal'?",
    "cep": "expected 'horizontal' with 'probability: 50 %' beside it",
    "cep50": "expected 'horizontal' with 'probability: 50 %' beside it",
    "cep95": "expected 'horizontal' with 'probability: 95 %' beside it",
    "r95": "expected 'horizontal' with 'probability: 95 %' beside it",
}

# Bounds of pydantic in our words; of a range it names one end at a time.
_BOUNDS = {
    "greater_than": "expected more than {gt}",
    "greater_than_equal": "expected {ge} or more",
    "less_than": "expected less than {lt}",
    "less_than_equal": "expected {le} or less",
    "too_short": "has {actual_length} items, expected {min_length} or more",
    "too_long": "has {actual_length} items, expected {max_length} at the most",
    "string_too_long": "expected at most {max_length} characters",
    "finite_number": "expected a finite number",
    "int_parsing_size": "expected a number of fewer digits",
}
_EXPECTED = {
    "string_type": "expected text; put it in quotes",
    "int_type": "expected a whole number, such as 1",
    "int_from_float": "expected a whole number, such as 1",
    "float_type": "expected a number, such as 1.5",
    "bool_type": "expected true or false",
    "tuple_type": "expected a list in brackets",
    "model_type": "expected a mapping of keys",
    "dict_type": "expected a mapping of keys",
}


def check(
    document: YamlFile,
    model: type[Model],
    *,
    root: Node | None = None,
    gravity: float | None = None,
) -> Model:
    """Read a file's nodes into a model; `g` means `gravity` [m/s^2] in it.

    `root` stands for the file's own: a variant laid over the base.

    Raises
    ------
    SpecError
        Something is wrong with the file; every issue of it.
    """
    root = root or document.root
    issues: list[Issue] = []
    context = {} if gravity is None else {"gravity": gravity}
    try:
        checked = _validated(model, root, context, {})
    except ValidationError as error:
        details = error.errors(include_url=False)[: MOST_ISSUES + 1]
        issues.extend(_issue(document, root, model, detail) for detail in details)
    if not issues and not document.issues:
        return checked
    # What is no sound YAML has its issue already, and no value for a model.
    known = {(issue.line, issue.column) for issue in document.issues}
    new = [issue for issue in issues if (issue.line, issue.column) not in known]
    raise all_of([*document.issues, *new])


def _validated(
    model: type[Model], root: Node, context: dict[str, float], words: dict[int, str]
) -> Model:
    """Read the values; `words` stand for those of fixed lists in other capitals.

    They are looked for where something is wrong: a file without them costs nothing.

    Raises
    ------
    pydantic_core.ValidationError
        Of what is wrong besides.
    """
    try:
        return model.model_validate(plain(root, words), context=context)
    except ValidationError as error:
        found = dict(words)
        for detail in error.errors(include_url=False):
            if detail["type"] == "literal_error":
                node = root.nearest(detail["loc"])
                allowed = {word.lower(): word for word in _words_of(detail)}
                if word := allowed.get(node.written.lower()):
                    found[id(node)] = word
        if found == words:
            raise
    return _validated(model, root, context, found)


def _words_of(detail: ErrorDetails) -> tuple[str, ...]:
    """Return the words that a finding of pydantic allows."""
    return tuple(re.findall(r"'([^']*)'", detail["ctx"]["expected"]))


@lru_cache(maxsize=1024)
def nearest(word: str, allowed: tuple[str, ...]) -> str:
    """Return a hint at the allowed word that is nearest, or ''."""
    by_lower = {name.lower(): name for name in allowed if name != word}
    near = get_close_matches(word.lower(), by_lower, n=1)
    return f"; did you mean {by_lower[near[0]]!r}?" if near else ""


def _slip(word: str, allowed: tuple[str, ...]) -> str:
    """Return a hint at the word of a file that another is a slip of, or ''.

    Near is not enough here: '4 sigma' is no slip of '1 sigma' nor 'lognormal' of
    'normal', and a line of one kind of sensor has its own twin on the other.
    """
    if word in from_outside().faults:
        return f"; {from_outside().faults[word]}"
    if word == "earth_rate":
        return _EARTH_RATE
    if "horizontal" in allowed and word.lower() in _RADIUS:
        return f"; {_RADIUS[word.lower()]}"
    if any(line.name == word for line in every_source()):
        twin = twin_of(word)
        return f"; did you mean {twin!r}?" if twin in allowed else ""
    digits = re.findall("[0-9]", word)
    same = {
        name.lower(): name for name in allowed if re.findall("[0-9]", name) == digits
    }
    lines = [line for line in lines_by_word().get(bare(word), ()) if line in allowed]
    if lines:
        either = " or ".join(map(repr, lines))
        return f"; did you mean {either}?{_see(lines)}"
    near = get_close_matches(word.lower(), same, n=1, cutoff=_SLIP)
    return f"; did you mean {same[near[0]]!r}?" if near else ""


def _see(steps: Sequence[str | int]) -> str:
    """Return where to read how makers print the line of those steps, or ''."""
    found = next(filter(None, (reading_of(str(step)) for step in steps)), None)
    return f"; how makers print it: {found.link}" if found else ""


def _issue(
    document: YamlFile, root: Node, model: type[BaseModel], detail: ErrorDetails
) -> Issue:
    """Say one finding of pydantic in our words, at its place in the file."""
    kind, node = detail["type"], root.nearest(detail["loc"])
    on_key = detail["loc"][-1:] == (KEY,)
    steps = detail["loc"][:-1] if on_key else detail["loc"]
    last = steps[-1] if steps else ""
    given = last if on_key else node.value
    is_number = isinstance(given, int | float) and not on_key
    found = f"found {node.written if is_number else describe(given)}, "
    around = _model_at(model, steps[:-1])
    expected = detail.get("ctx", {}).get("expected", "")
    missing = f"item {last + 1}" if isinstance(last, int) else repr(last)
    see = f"; what makers mean: {MEANINGS}" if last == "meaning" else ""
    says: dict[str, Callable[[], str]] = {
        "missing": lambda: f"{missing} is missing, expected it here",
        "extra_forbidden": lambda: _unknown(around, str(last)),
        "budget": lambda: (
            detail["msg"] + (_see(steps) if "expected" in detail["msg"] else "")
        ),
        "literal_error": lambda: (
            f"{found}expected {expected}{_slip(node.written, _words_of(detail))}{see}"
        ),
        "tuple_type": lambda: found + _EXPECTED[kind] + _bracketed(around, last, node),
    }
    usual = f"{found}{in_our_words(detail)}{_mended(node, kind)}"
    message = says[kind]() if kind in says else usual
    return document.issue(node, message, on_key=on_key or kind == "extra_forbidden")


def _unknown(model: type[BaseModel], key: str) -> str:
    """Say that a mapping has no such key, which one may be meant, or where it is."""
    allowed = tuple(model.model_fields)
    owners = [
        own
        for own, field in model.model_fields.items()
        if any(key in one.model_fields for one in _models_in(field.annotation))
    ]
    inside = f"; it stands under {owners[0]!r}" if len(owners) == 1 else ""
    hint = _slip(key, allowed) or inside
    return f"unknown key {describe(key)}, allowed: {', '.join(allowed)}{hint}"


def in_our_words(detail: ErrorDetails) -> str:
    """Return what pydantic expects."""
    kind, about = detail["type"], detail.get("ctx", {})
    if kind in _BOUNDS:
        return _BOUNDS[kind].format_map(about)
    said = detail["msg"].removeprefix("Value error, ")
    return _EXPECTED.get(kind, said.lower().replace("input should be", "expected"))


def _mended(node: Node, kind: str) -> str:
    """Return a hint at the word that YAML 1.2 reads as what YAML 1.1 did."""
    if kind == "bool_type" and node.written.lower() in {"yes", "no", "on", "off"}:
        return f"; did you mean {str(node.written.lower() in {'yes', 'on'}).lower()}?"
    number = re.fullmatch(r"([+-]?)0*([0-9][0-9_]*)", node.written)
    if kind in {"int_type", "float_type"} and number:
        return f"; did you mean {number[1]}{number[2].replace('_', '')}?"
    return ""


def _bracketed(model: type[BaseModel], key: str | int, node: Node) -> str:
    """Return how the list is written that a file has one item of, or of what."""
    field = model.model_fields.get(str(key))
    if field and next(_models_in(field.annotation), None):
        return ", each item a mapping of keys"
    one = node.written
    # What is long, or no text that a terminal shows, is not repeated.
    is_short = one.isprintable() and 0 < len(one) <= LONGEST_SHOWN
    if is_short and not isinstance(node.value, bool):
        return f", such as '{key}: [{one}]'"
    return ", such as [x, y] of two items"


def _model_at(model: type[BaseModel], steps: Sequence[str | int]) -> type[BaseModel]:
    """Return the model of the mapping that those steps lead to."""
    for step in steps:
        field = model.model_fields.get(str(step))
        if field is not None:
            model = next(_models_in(field.annotation), model)
    return model


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:  # noqa: ANN401
    """Yield the models that a type names."""
    if isinstance(annotation, Later):
        annotation = annotation.make()
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models_in(inner)
