"""`budget paper`: text, page and documents, and what it refuses."""

from __future__ import annotations

import csv
import io
import json
import re

import pytest
from command_line import call
from reading import on_terminal

from zhao_2019 import study as computing
from zhao_2019.figures import print_ratio
from zhao_2019.page import paper_sections, print_probability, reason
from zhao_2019.printed import Agreement
from zhao_2019.study import reproduce

CONTRACT = {"where", "printed", "ours", "ratio", "verdict", "why"}


@pytest.fixture(scope="module")
def study():
    return reproduce()


@pytest.fixture
def computed(study, monkeypatch):
    """Give a command the study that is there: how it is told is the question."""
    monkeypatch.setattr(computing, "reproduce", lambda: study)


@pytest.fixture(scope="module")
def document():
    run = call("paper", "--json", "-")
    assert (run.code, run.err) == (0, "")
    return run.document


@pytest.mark.usefixtures("computed")
def test_text_has_every_section_and_is_ascii(study):
    """Without options everything goes to stdout, in ASCII, and the exit code is 0."""
    run = call("paper")
    assert (run.code, run.err) == (0, "")
    assert run.out.isascii()
    for title in (
        *study.paper.sections.values(),
        "What nothing explains",
        "The verdicts",
        "Assumed",
    ):
        assert f"{title}\n" in run.out


@pytest.mark.parametrize("width", [60, 100, 160])
def test_text_keeps_to_the_terminal(study, width):
    """No line is wider than the terminal, but for single words."""
    lines = on_terminal(paper_sections(study), width).splitlines()
    assert max(len(line) for line in lines if " " in line.strip()) <= width


def test_text_says_every_row(study):
    """No verdict, ratio, probability or reason of the page goes on the terminal."""
    said = " ".join(on_terminal(paper_sections(study), 80).split())
    for row in study.findings:
        assert row.verdict in said
        assert " ".join(reason(row).split()) in said
        assert print_ratio(row.ratio) in said
        for p in (row.p_single, row.p_mean):
            assert print_probability(p) in said


def test_json_keeps_the_contract(document):
    """Schema, command and the fields of every row are those of the contract."""
    assert (document["schema"], document["command"]) == ("budget/1", "paper")
    assert set(document["inputs"]) == {"device", "procedure"}
    for row in document["rows"]:
        assert row.keys() >= CONTRACT
        assert row["verdict"] in set(Agreement)


def test_json_holds_the_residual_in_full(document):
    """Numbers are not rounded: eq. (4)'s residual has more than its printed digits."""
    (row,) = (
        row
        for row in document["rows"]
        if row["where"] == "Table 1, scale factor repeatability, bias z"
    )
    assert row["printed"] == "6.36529e-10"
    assert len(repr(row["ours"])) > 15


@pytest.mark.usefixtures("computed")
def test_csv_has_the_rows_of_the_json(document):
    """One line a row, the same numbers to the last digit."""
    run = call("paper", "--csv", "-")
    rows = list(csv.DictReader(io.StringIO(run.out)))
    assert list(rows[0]) == list(document["rows"][0])
    assert len(rows) == len(document["rows"])
    for line, row in zip(rows, document["rows"], strict=True):
        assert line["where"] == row["where"]
        if isinstance(row["ours"], float):
            assert float(line["ours"]) == row["ours"]


@pytest.mark.usefixtures("computed")
def test_page_needs_nothing_else_and_has_the_figures(tmp_path):
    """The page holds four figures with words for them, its data, and loads nothing."""
    page = tmp_path / "paper.html"
    run = call("paper", "-o", page)
    assert (run.code, run.out) == (0, "")
    assert run.err == f"{page}: written\n"
    text = page.read_text(encoding="utf-8")
    assert text.count('role="img" aria-label="Figure ') == 4
    assert not re.findall(r'src="(?!#)', text)
    assert not re.findall(r'href="(?!#|https://doi\.org/)', text)
    data = re.search(r'id="paper-json">\n(.*?)</script>', text, re.DOTALL)
    assert json.loads(data[1])["command"] == "paper"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("-o", "paper.txt"), "allowed: .html, .pdf"),
        (("--json", "-", "--csv", "-"), "both write to stdout"),
        (("--json", "x", "--csv", "x"), "different names"),
        (("-o", "x.html", "--json", "x.html"), "different names"),
    ],
)
def test_bad_calls_are_refused_before_work(tmp_path, monkeypatch, options, message):
    """A call that cannot be meant is exit 2 with a reason, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    run = call("paper", *options, code=2)
    assert message in run.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("ratio", "text"),
    [(None, ""), (1.0000048, "1.000005"), (146.63, "147"), (0.0224, "0.0224")],
)
def test_ratios_near_one_keep_their_digits(ratio, text):
    """A ratio near 1 is printed to six decimals, others to three digits."""
    assert print_ratio(ratio) == text


@pytest.mark.parametrize(
    ("p", "text"), [(None, ""), (0.0, "<1e-6"), (0.0409, "0.041"), (1.0, "1")]
)
def test_probabilities_have_two_digits(p, text):
    """Probabilities below one in a million are said to be just that."""
    assert print_probability(p) == text
