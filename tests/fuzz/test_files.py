"""Any text as a file: a sound record, or what is wrong with it at its place."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from fuzz.effort import examples
from fuzz.grammar import Raw, leaves, mappings, random_of, replaced, tree_of, write
from fuzz.oracle import LOADERS, judge_file, judge_input, judge_name, put
from hypothesis import given
from hypothesis import strategies as st

from budget.errors import SpecError
from budget.inputs import reader, validate

pytestmark = pytest.mark.slow  # hostile files

# All of an example follows from one: each draw of hypothesis costs more than a parse.
SEEDS = st.integers(0, 2**32 - 1)

# What hostile and careless people write; joined at random and put into sound files.
PIECES = (
    *("name: x\n", "gyro: ", "accelerometer: ", "limits: ", "costs: ", "errors: "),
    *("variants: ", "abstract: true\n", "format: budget-device/99999999999\n"),
    *("  ", "\n", "\r\n", "\r", "\t", " ", "\0", "\ufeff", "\u2028", "\x85", "\x1b"),
    *(": ", "- ", "? ", "[", "]", "{", "}", ", ", "#", "'", '"', "|\n", ">-\n", "|9\n"),
    *("&a ", "*a", "!!python/object:os.system ", "!<!> ", "!", "<<: *a\n", "%YAML 1.1"),
    *("---\n", "...\n", "--- ", '"\\x00"', '"\\ud800"', '"\\UFFFFFFFF"', '"\\'),
    *("1e400", "-0", "nan", ".inf", "1_000", "0x1F", "0o17", "010", "1:30", "~", "no"),
    *("9" * 400, "1e-400 deg/h", "-5 deg/h", "5 deg", "1 deg/h", "x" * 300, "\u202e"),
    *("\N{DEGREE SIGN}/\N{SQUARE ROOT}h", "\N{MICRO SIGN}g", "[" * 30, "{a: " * 30),
    *("\U0001f680", "\ud800", "\u200b", "\u0301", "\uff15", "yes", "true", "null"),
)
NAMES = (
    *("#", "/", "..", ".", "~", "zhao-2019", "navigation-grade", "\0", "\n", "\udcff"),
    *("x" * 300, "C:", "-", "*", "?", "%", " ", ".yaml"),
)
CODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-be", "utf-32", "latin-1", "utf-7")


@pytest.fixture(scope="module", autouse=True)
def path():
    """Return one file for all examples; a fixture of a function has one for each."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder) / "file.yaml"


@pytest.fixture(scope="module", autouse=True)
def parsed_once():
    """Parse bytes once for all loaders that ask, also those that are refused."""
    parse, last = reader.parse, {}

    def asked(*args, **kwargs):
        key = args, *kwargs.values()
        if key not in last:
            last.clear()
            try:
                last[key] = parse(*args, **kwargs)
            except SpecError as error:
                last[key] = error
        if isinstance(last[key], SpecError):
            raise SpecError(last[key].issues)
        return last[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reader, "parse", asked)
        yield


def encoded(text, coding):
    """Return the bytes of a text, whatever is in it and whatever the coding holds."""
    if coding == "utf-8":
        return text.encode(coding, errors="surrogatepass")
    return text.encode(coding, errors="replace")


@examples(500)
@given(data=st.binary(max_size=400))
def test_any_bytes_are_read_or_refused(path, data):
    """Bytes of any kind give a sound record or issues at places in the file."""
    judge_file(path, data)


@examples(400)
@given(
    text=st.lists(st.sampled_from(PIECES) | st.text(max_size=5), max_size=30),
    coding=st.sampled_from(CODINGS),
)
def test_any_text_in_any_coding_is_read_or_refused(path, text, coding):
    """Pieces of YAML and of no YAML, in any order and coding, do the same."""
    judge_file(path, encoded("".join(text), coding))


@pytest.mark.parametrize("kind", LOADERS)
def test_damaged_files_are_read_or_refused(path, kind):
    """A file as the grammar of its kind allows, then damaged anywhere, does so too."""

    @examples(150)
    @given(seed=SEEDS)
    def judge(seed):
        random = random_of(seed)
        text = write(tree_of(kind, random), seed).text
        for _ in range(random.randint(1, 3)):
            where = random.choice((0.0, 1.0, *(random.random() for _ in range(6))))
            start, gone = int(where * len(text)), random.randint(0, 12)
            piece = random.choice(("", *PIECES))
            text = text[:start] + piece + text[start + gone :]
        coding = random.choice(("utf-8", "utf-8", *CODINGS))
        judge_file(path, encoded(text, coding))

    judge()


@pytest.mark.parametrize("kind", LOADERS)
def test_files_of_the_grammar_are_read(path, kind):
    """The files that get damaged here are sound before, so that damage says something.

    Two in three are enough: the grammar knows no rule of more than one key.
    """
    read = []

    @examples(100)
    @given(seed=SEEDS)
    def judge(seed):
        tree = tree_of(kind, random_of(seed))
        read.append(judge_file(path, write(tree, seed).text.encode()) == kind)

    judge()
    assert sum(read) > 2 * len(read) // 3, (sum(read), len(read))


@examples(200)
@given(
    name=st.text(max_size=20)
    | st.lists(st.sampled_from(NAMES), max_size=6).map("".join)
)
def test_any_name_of_a_file_is_found_or_refused(name):
    """A name that no file has, or can have, is an issue of that name as typed."""
    judge_name(name)


# What is wrong in place of any scalar, and what in place of a number with a unit.
WRONG = (
    *("&a 1", "*a", "!!str 1", "!<x> 1", "~", "''", '"\\x07"', "[[]]", "[a, b]"),
    *('"\\u202E"', '"  "', "{? [a] : b}"),
)
NO_QUANTITY = (
    *("nan deg/h", ".inf deg/h", "1e400 deg/h", "-1e400 s", "1_000 deg/h", "010 deg/h"),
    *("0x1F deg/h", "0o17 s", "1:30 h", "1,5 ug", "1e-400 ug", "5 furlong", "5", "-0"),
    *("1e400", "true", "no", "5 deg/h/h/h", "5 ug ug", f"5 {'k' * 300}", "5 deg/0"),
    *(f"{'9' * 400} deg/h", "\uff15 deg/h", "5\N{NO-BREAK SPACE}furlong"),
)


@pytest.mark.parametrize("kind", LOADERS)
def test_what_is_wrong_is_reported_where_it_stands(path, kind):
    """One wrong value in a file of the grammar has an issue at its line and column."""

    @examples(200)
    @given(seed=SEEDS)
    def judge(seed):
        random = random_of(seed)
        tree = tree_of(kind, random)
        steps, value = random.choice(list(leaves(tree)))
        measured = isinstance(value, str) and value[:1] in set("0123456789.+-")
        measured &= " " in value if isinstance(value, str) else False
        wrong = random.choice(WRONG + (NO_QUANTITY if measured else ()))
        page = write(replaced(tree, steps, Raw(wrong)), seed)
        put(path, page.text.encode())
        with pytest.raises(SpecError) as caught:
            validate(path)
        line, column = page.places[steps].value
        places = [(issue.line, issue.column) for issue in caught.value.issues]
        inside = wrong.startswith(("{", "["))  # then the issue may be one level down
        assert (line, column) in places or (
            inside and any(at[0] == line and at[1] >= column for at in places)
        ), (page.text, wrong, steps, [str(one) for one in caught.value.issues])

    judge()


@pytest.mark.parametrize("kind", LOADERS)
def test_a_key_too_many_is_reported_where_it_stands(path, kind):
    """An unknown key, an empty one and a duplicate have an issue at the key."""

    @examples(120)
    @given(seed=SEEDS)
    def judge(seed):
        random = random_of(seed)
        tree = tree_of(kind, random)
        how = random.choice(["unknown", "empty", "twice", "long", "no value"])
        within = [p for p in mappings(tree) if p[-1:] != ("variants",)]
        steps = random.choice(within)
        if how == "twice":
            known = [path for path, _ in leaves(tree) if isinstance(path[-1], str)]
            place = random.choice(known)
            page = write(tree, seed, twice=place)
        else:
            new = {"empty": " ", "long": "k" * 900}.get(how, "unknwon")
            place = (*steps, new)
            value = Raw("" if how == "no value" else "5 deg/h")
            page = write(replaced(tree, place, value), seed)
        put(path, page.text.encode())
        with pytest.raises(SpecError) as caught:
            validate(path)
        places = [(issue.line, issue.column) for issue in caught.value.issues]
        assert page.places[place].key in places, (page.text, place, places)

    judge()


@pytest.mark.parametrize("kind", LOADERS)
def test_breaks_and_marks_of_other_systems_change_nothing(path, kind):
    """A sound file says the same with CR LF, with a byte order mark and padded."""

    @examples(60)
    @given(seed=SEEDS)
    def judge(seed):
        text = write(tree_of(kind, random_of(seed)), seed).text
        told = {
            _told(path, data)
            for data in (
                text.encode(),
                text.replace("\n", "\r").encode(),
                f"{text}\n# the end".replace("\n", "\r\n").encode("utf-8-sig"),
            )
        }
        assert len(told) == 1, told

    judge()


def _told(path, data):
    """Return what a file says, or what is said of it."""
    put(path, data)
    try:
        return repr(validate(path))
    except SpecError as error:
        return str(error)


# ---- inputs that broke the reader once -----------------------------------------------

FOUND = sorted((Path(__file__).parent / "found").iterdir())


@pytest.mark.parametrize("case", FOUND, ids=lambda path: path.name)
def test_what_broke_the_reader_breaks_it_no_more(case, tmp_path):
    """A case of the corpus gives a sound record, or issues at places in the file."""
    judge_input(tmp_path / "file.yaml", case.read_bytes())


def test_the_corpus_is_there():
    """The folder with the cases is in the checkout, so that the test above has some."""
    assert FOUND
