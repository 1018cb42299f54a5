"""Pages of a mission, an allocation, a station and a check: what the commands say."""

from __future__ import annotations

import json
import re
from html import unescape
from math import isclose

import pytest
from command_line import call
from keeping import once
from reading import pages_of, squeeze
from reference_examples import DEVICE

from budget.studies import stations

pytestmark = pytest.mark.usefixtures("drawn_once", "analyzed_once")

# A name that is no Markdown, no template, no tag and no formula.
HOSTILE = "A *b* <i>c</i> {{ 1 }} $d$ | `e`"
EPOCH = {"SOURCE_DATE_EPOCH": "86400"}
FILES = {
    "hostile.yaml": DEVICE.replace("name: Two sensors", f"name: '{HOSTILE}'"),
    "lab.yaml": "name: lab\nlatitude: 34.2394 deg\nstation: three-axis-table\n",
    "bad.json": "{}\n",
}
# By the kind of page: a call, its exit code, and the table of page one.
CALLS = {
    "mission": (
        ("mission", "hostile.yaml", "--mission", "outage-10-s", "--no-validate"),
        (0, "mission-position"),
    ),
    "allocation": (
        *(("allocate", "hostile.yaml", "--no-validate"), (1, "allocation-gyro")),
    ),
    "station": (
        ("station", "hostile.yaml", "--procedure", "lab.yaml"),
        (0, "station-verdicts"),
    ),
    "check": (("check", "ref.json", "bad.json"), (2, "verdicts")),
}
NEED = ("--requirement", "tactical-grade")


@pytest.fixture(scope="module", params=CALLS)
def made(request, tmp_path_factory):
    """Write the page of a command in both languages, once."""
    kind = request.param
    folder = tmp_path_factory.mktemp(kind)
    words, (code, table) = CALLS[kind]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(stations, "qualify", once(stations.qualify, {}))
        for name, text in FILES.items():
            (folder / name).write_text(text, encoding="utf-8")
        if kind == "check":
            call("check", "--save", "ref.json", "hostile.yaml")
            changed = FILES["hostile.yaml"].replace("0.04 deg/h", "0.05 deg/h")
            (folder / "hostile.yaml").write_text(changed, encoding="utf-8")
        words = words + (NEED if kind in {"allocation", "station"} else ())
        for language in ("en", "zh"):
            ends = (f"{language}.html", f"{language}.pdf")
            run = call(
                *(*words, "-o", ends[0], "-o", ends[1], "--json", "a.json"),
                *("--language", language),
                **EPOCH,
            )
            assert run.code == code, run.err
            assert f"{ends[1]}: written" in run.err
        yield kind, folder, table, words


def plain(page):
    """Return what a reader of a page sees, with blanks that may break."""
    text = re.sub(r"<(script|style).*?</\1>|<[^>]*>", "", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", unescape(text))


def exact(page, table):
    """Return the numbers of a table, in full precision."""
    (own,) = re.findall(rf'<table id="{table}".*?</table>', page, re.DOTALL)
    return [float(x) for x in re.findall(r'data-exact="([^"]*)"', own)]


def numbers(value):
    """Yield every number in a document, and how many a list has."""
    if isinstance(value, dict):
        value = [*value.values()]
    if isinstance(value, list):
        yield float(len(value))
        for one in value:
            yield from numbers(one)
    elif isinstance(value, int | float):
        yield float(value)


@pytest.mark.slow
def test_a_page_has_the_document_and_its_numbers(made):
    """The JSON of the command stands in it, and what its first table shows in that."""
    kind, folder, table, _ = made
    document = json.loads((folder / "a.json").read_text("utf-8"))
    stated = {*numbers(document)}
    for one in document.get("sources", ()):
        if one.get("allowed"):
            stated.add(one["allowed"] / one["now"])
    stated |= {100.0 * one for one in stated}
    for language in ("en", "zh"):
        page = (folder / f"{language}.html").read_text("utf-8")
        found = re.search(rf'id="{kind}-json">\n(.*?)</script>', page, re.DOTALL)
        assert json.loads(found[1]) == document
        shown = exact(page, table)
        assert shown
        lost = [
            one
            for one in shown
            if not any(isclose(one, its, rel_tol=1e-9) for its in stated)
        ]
        assert lost == []


@pytest.mark.slow
def test_a_pdf_has_two_to_four_sheets(made, tmp_path):
    """The headline stands on the first, and is that of the HTML page."""
    _, folder, _, _ = made
    for language in ("en", "zh"):
        page = (folder / f"{language}.html").read_text("utf-8")
        sheets = pages_of((folder / f"{language}.pdf").read_bytes(), tmp_path)
        headline = unescape(re.search(r'class="word">(.*?)</h2>', page)[1])
        assert 2 <= len(sheets) <= 4
        assert squeeze(headline) in squeeze(sheets[0])


def test_a_hostile_name_stays_a_name(made):
    """It is shown as it is, and is no markup; nothing is left unfilled."""
    kind, folder, _, _ = made
    for language in ("en", "zh"):
        page = (folder / f"{language}.html").read_text("utf-8")
        assert "<i>c</i>" not in page.partition('<script type="application/json"')[0]
        assert kind == "check" or HOSTILE in plain(page)


def test_every_page_can_be_traced(made):
    """It names the call, its inputs and their hashes, and has room for signatures."""
    _, folder, _, words = made
    page = (folder / "en.html").read_text("utf-8")
    assert f"budget {words[0]} {words[1]}" in plain(page)
    for section in ("provenance", "sign-off"):
        assert f'<section id="{section}"' in page
    hashes = re.findall(r"[0-9a-f]{64}", (folder / "a.json").read_text("utf-8"))
    assert {*hashes} <= {*re.findall(r"<code>([0-9a-f]{64})</code>", page)}
    assert hashes or len(re.findall(r"<code>[0-9a-f]{64}</code>", page)) >= 3


def test_a_page_is_the_same_again(made):
    """With SOURCE_DATE_EPOCH its bytes are too; of one kind, as all are made alike."""
    kind, folder, _, words = made
    if kind != "allocation":
        pytest.skip("pages are made alike")
    ends = ("-o", "again.html", "-o", "again.pdf", "--language", "en")
    call(*words, *ends, **EPOCH)
    for suffix in ("html", "pdf"):
        first = (folder / f"en.{suffix}").read_bytes()
        assert (folder / f"again.{suffix}").read_bytes() == first


def test_a_check_names_what_moved_and_what_cannot_be_checked(made):
    """The headline counts both; the change that did it stands on page one."""
    kind, folder, _, _ = made
    if kind != "check":
        pytest.skip("of a check")
    page = (folder / "en.html").read_text("utf-8")
    answer = plain(page.partition("<nav")[0])
    for words in (
        "2 references: 0 unchanged, 1 moved, 1 cannot be checked",
        *("ref.json: MOVED", "0.04 deg/h -> 0.05 deg/h (100 %)", "bad.json: has no"),
    ):
        assert words in answer


@pytest.mark.parametrize("name", ["mission", "allocate", "station", "check"])
def test_pages_that_cannot_be_are_refused_before_anything_is_read(name, tmp_path):
    """A suffix, a paper without a PDF, an input as output; nothing is written."""
    words = {
        "mission": ("mission", "--mission", "bench"),
        "check": ("check", "zhao-2019-eq4-nominal"),
    }.get(name, (name, *NEED))
    before = [*tmp_path.iterdir()]
    for more, said in (
        (("-o", str(tmp_path / "a.txt")), "the suffix decides"),
        (("-o", str(tmp_path / "a.html"), "--paper", "letter"), "--paper letter"),
        (("-o", str(tmp_path / "none" / "a.html")), "none"),
    ):
        run = call(*words, *more, code=2)
        assert said in run.err
    assert [*tmp_path.iterdir()] == before


def test_an_allocation_that_cannot_be_has_a_page(tmp_path):
    """It says why; the documents of what is allocated are not written."""
    page, document = tmp_path / "a.html", tmp_path / "a.json"
    run = call(
        *("allocate", "--requirement", "navigation-grade", "--no-validate"),
        *("--fix", "gyro.bias_stability", "-o", str(page), "--json", str(document)),
        code=1,
    )
    assert "no other file was written" in run.err
    assert not document.exists()
    assert "cannot be met" in page.read_text("utf-8")


def test_a_reference_that_is_stored_has_no_page(tmp_path):
    """It is a document itself."""
    run = call("check", "--save", str(tmp_path / "a.json"), "-o", "a.html", code=2)
    assert "leave them out" in run.err
