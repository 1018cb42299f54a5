"""Any text as a stored reference: a sound record, or one error with its remedy."""

from __future__ import annotations

import json
import tempfile
from hashlib import sha256
from pathlib import Path

import pytest
from fuzz.effort import examples
from hypothesis import given
from hypothesis import strategies as st

from budget.errors import ReferenceFileError
from budget.references.records import ReferenceBudget
from budget.references.store import read_reference
from budget.resources import shipped

STORED = shipped("specs") / "references" / "zhao-2019-corrected-nominal.json"
CONTENT = json.loads(STORED.read_text(encoding="utf-8"))
SHORT = CONTENT | {"numbers": CONTENT["numbers"][::12]}  # the others are of their form
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(["/etc/passwd", "../x", "C:\\x", "gum", "9" * 300, "\x1b[2J"]),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=8,
)


@pytest.fixture(scope="module", autouse=True)
def path():
    """Return one file for all examples."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder) / "ref.json"


def judge(path, data):
    """Read a file: a record, or an error on one line that names it."""
    path.write_bytes(data)
    try:
        found = read_reference(path, "ref.json")
    except ReferenceFileError as error:
        text = str(error)
        assert text.startswith("ref.json:")
        assert "\x1b" not in text
        return None
    assert isinstance(found, ReferenceBudget)
    assert found.numbers
    return found


def sealed(content):
    """Return a content with the checksum that belongs to it, as bytes."""
    rest = {key: value for key, value in content.items() if key != "checksum"}
    spelt = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    seal = sha256(spelt.encode(errors="surrogatepass")).hexdigest()
    return json.dumps(rest | {"checksum": seal}).encode()


def replaced(content, way, value):
    """Return a content with something else at a place that a number leads to."""
    if isinstance(content, dict) and content:
        key = sorted(content)[way % len(content)]
        inner = replaced(content[key], way // len(content), value)
        return content | {key: inner}
    if isinstance(content, list) and content:
        place = way % len(content)
        inner = replaced(content[place], way // len(content), value)
        return [*content[:place], inner, *content[place + 1 :]]
    return value


@pytest.mark.slow
@given(data=st.binary(max_size=300) | st.text(max_size=300).map(str.encode))
@examples(300)
def test_any_bytes_are_read_or_refused(path, data):
    """No bytes end in anything but a record or an error for people."""
    judge(path, data)


@given(
    start=st.integers(0, STORED.stat().st_size - 1),
    length=st.integers(0, 200),
    put=st.binary(max_size=20),
)
@examples(200)
def test_damage_is_noticed(path, start, length, put):
    """A stored reference with a piece replaced is refused, or it is the same."""
    data = STORED.read_bytes()
    damaged = data[:start] + put + data[start + length :]

    if judge(path, damaged) is not None:
        assert json.loads(damaged) == CONTENT


@pytest.mark.slow
@given(way=st.integers(0, 2**40), value=VALUES)
@examples(400)
def test_forged_values_are_read_or_refused(path, way, value):
    """Whatever stands under a checksum that is right ends in words, or is sound."""
    judge(path, sealed(replaced(SHORT, way, value)))


@pytest.mark.parametrize("name", ["/etc/passwd", "C:\\x.yaml", "\\\\host\\x.yaml"])
def test_an_absolute_input_is_refused(path, name):
    """A reference opens nothing but what stands beside it or ships."""
    first, *others = CONTENT["inputs"]
    forged = CONTENT | {"inputs": [first | {"file": name}, *others]}

    path.write_bytes(sealed(forged))
    with pytest.raises(ReferenceFileError, match="absolute path"):
        read_reference(path, "ref.json")


def test_a_reference_without_numbers_is_refused(path):
    """A check that compares nothing could not fail."""
    path.write_bytes(sealed(CONTENT | {"numbers": []}))
    with pytest.raises(ReferenceFileError, match="numbers"):
        read_reference(path, "ref.json")


def test_the_judge_reads_what_is_sound(path):
    """Control: the stored reference itself, and under a new checksum, is a record."""
    assert judge(path, STORED.read_bytes()) is not None
    assert judge(path, sealed(SHORT)) is not None
    assert judge(path, sealed(CONTENT)) is not None
