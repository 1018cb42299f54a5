"""The tree of a file: laid over, written, read back; and rows of what goes wrong."""

from __future__ import annotations

import json
from string import Formatter

import pytest

from budget.errors import SpecError
from budget.inputs import load, load_device
from budget.inputs.composer import compose
from budget.inputs.fields import Keyed
from budget.inputs.tree import (
    Location,
    block,
    flow,
    merge,
    plain,
    put,
    quoted,
    scalar,
)

TEXTS = (
    *("plain", "0.5 deg/h", "a: b", "- x", "#c", "x #c", "true", "null", "1e3", "010"),
    *(
        "",
        " ",
        "'q'",
        '"d"',
        "back\\slash",
        "{a: b}",
        "[1]",
        "*alias",
        "&a",
        "!t",
        "%d",
    ),
    *("Zhao, Zhang", "°/h ± µg", "a\tb", "é", "?", "~", "@x", "|", ">", "no", "-", ":"),
)
DEVICE = """\
name: d
gyro:
  errors:
    bias_repeatability: {value: 1 deg/h, meaning: max}
    bias_stability: 0.1 deg/h
variants:
  worse: {gyro: {errors: {bias_repeatability: 3 parsec}}}
"""


def read(text):
    """Return the root of a sound text."""
    root, issues = compose(text, "t.yaml")
    assert not issues
    return root


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("write", [scalar, quoted])
def test_what_is_written_is_read_back(text, write):
    """A text is the same text, whatever it is to YAML; as a key, a value, an item."""
    assert plain(read("\n".join(block([("k", write(text))])))) == {"k": text}
    assert plain(read(flow({"k": [text, text]}, write))) == {"k": (text, text)}
    if text:
        assert plain(read(flow({text: {text: text}}, quoted))) == {text: {text: text}}


def test_quoted_is_json():
    """So files that were written by it stay what they are."""
    value = {"a": ["x", 1.5, True, {"b": "ä\n"}], "c": {}}
    assert flow(value, quoted) == json.dumps(value, ensure_ascii=False)


def test_a_node_is_written_as_its_file_spells_it():
    """Numbers, words and lists stay as they are; lines and blanks are one blank."""
    text = "a: {v: 1e3, w: [0.50, 'x y'], t: true}\nb: >\n  two\n  lines\n"
    assert flow(read(text)) == "{a: {v: 1e3, w: [0.50, x y], t: true}, b: two lines}"


def test_blocks():
    """Comments and keys below one another, indented by two."""
    entries = ["c", ("a", "1"), ("b", ["in", ("d", "2")]), ("e", "")]
    assert [*block(entries)] == ["# c", "a: 1", "b:", "  # in", "  d: 2", "e:"]


def test_laid_over_each_part_keeps_its_place():
    """What stays is where it was, what is new where it is from; nothing is changed."""
    base = read("a: {b: 1, c: [x, {d: 2}]}\ne: f\n")
    new, _ = compose("new", "--set", path="a.b")
    before = plain(base)

    laid = put(base, ("a", "b"), new)
    assert plain(laid) == {"a": {"b": "new", "c": ("x", {"d": 2})}, "e": "f"}
    assert (laid.find(("a", "b")).file, laid.find(("a", "b")).path) == ("--set", "a.b")
    assert laid.find(("a", "c")) == base.find(("a", "c"))
    assert plain(put(base, ("a", "c", 1, "d"), new))["a"]["c"] == ("x", {"d": "new"})
    assert plain(put(base, ("a", "b"), None)) == {"a": {"c": ("x", {"d": 2})}, "e": "f"}
    deep = put(base, ("g", "h", "i"), new)
    assert plain(deep)["g"] == {"h": {"i": "new"}}
    assert deep.find(("g", "h")).at == new.at
    assert plain(put(base, ("e", "k"), new))["e"] == {"k": "new"}
    assert base.find(("a", "z", "y")) is None
    assert plain(base) == before


def test_variants_are_merged_key_by_key():
    """Under errors a text is short for its value; elsewhere the new one replaces."""
    base = read("gyro: {errors: {l: 1 deg/h}, nominal: {bias: 1 deg/h}}\nname: a\n")
    over = read("gyro: {errors: {l: {meaning: max}}, nominal: {bias: {x: 2 deg/h}}}\n")
    both = merge(base, over)
    assert plain(both) == {
        "gyro": {
            "errors": {"l": {"value": "1 deg/h", "meaning": "max"}},
            "nominal": {"bias": {"x": "2 deg/h"}},
        },
        "name": "a",
    }
    assert both.find(("gyro", "errors", "l", "meaning")).at == Location(1, 30)


def test_an_issue_is_where_what_was_laid_over_is_from(tmp_path):
    """In a variant at its line, in a call at --set, in the base where that stands."""
    path = tmp_path / "d.yaml"
    path.write_text(DEVICE, encoding="utf-8")
    with pytest.raises(SpecError, match=r"d\.yaml:7:47: variants\.worse") as one:
        load_device(f"{path}#worse")
    with pytest.raises(SpecError, match=r"^--set gyro\.ageing:1:9: gyro") as two:
        load_device(path, ["gyro.ageing={value: 3 parsec, horizon: 1 year}"])
    assert [len(error.value.issues) for error in (one, two)] == [1, 1]


def kinds(base=Keyed):
    """Yield every type of mapping with rules."""
    for kind in base.__subclasses__():
        yield kind
        yield from kinds(kind)


def test_what_rules_say_is_there():
    """Every place in the words of a rule is a key of its mapping, or known of it."""
    assert load
    rows = [(kind, rule) for kind in kinds() for rule in vars(kind).get("rules", ())]
    assert len(rows) > 80
    for kind, rule in rows:
        for _, place, _, _ in Formatter().parse(rule.says):
            name = (place or "").partition(".")[0]
            assert not name or name in kind.rows or hasattr(kind, name), rule
