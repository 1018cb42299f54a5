"""The paper as PDF: whole, the same every time, and foreign text stays text."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from command_line import call, start

from budget.errors import OutputError
from budget.report import pdf as pdf_module
from budget.report.paper import shorten
from budget.report.paper_pdf import paper_pdf
from budget.report.pdf import render_pdf
from budget.studies.paper.findings import VERDICTS
from budget.studies.paper.study import SECTIONS, reproduce

DATE = "2026-01-31"
needs_pdftotext = pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="reads PDF by pdftotext of poppler-utils"
)


@pytest.fixture(scope="module")
def study():
    return reproduce()


@pytest.fixture(scope="module")
def pdf(study):
    return paper_pdf(study, date=DATE)


def text_of(pdf, folder):
    """Return the text without any blanks, in which lines and cells are broken."""
    path = folder / "page.pdf"
    path.write_bytes(pdf)
    run = subprocess.run(
        ["pdftotext", "-raw", "-enc", "UTF-8", str(path), "-"],
        capture_output=True,
        check=True,
    )
    return squeeze(run.stdout.decode())


def squeeze(text):
    """Leave out blanks and the marks of a possible break."""
    return re.sub(r"[\s\u200b\u00ad]", "", text)


@pytest.fixture
def template(tmp_path, monkeypatch):
    """Return what puts a template in the place of the shipped ones."""

    def put(source):
        (tmp_path / "x.typ").write_text(source, encoding="utf-8")
        monkeypatch.setattr(pdf_module, "shipped", lambda _: tmp_path)
        return "x.typ"

    return put


@needs_pdftotext
def test_every_row_can_be_found(study, pdf, tmp_path):
    """The text of the file has every place, reason, section title and verdict."""
    text = text_of(pdf, tmp_path)
    for row in study.findings:
        assert squeeze(shorten(row)) in text
        assert row.why.startswith("judged with") or squeeze(row.why) in text
    for words in (*SECTIONS.values(), *(VERDICTS[word] for word, _ in study.counts)):
        assert squeeze(words) in text


@needs_pdftotext
def test_pages_are_numbered(pdf, tmp_path):
    """The last page says that it is the last."""
    pages = re.findall(r"page(\d+)of(\d+)", text_of(pdf, tmp_path))
    last = pages[-1][1]
    assert int(last) > 1
    assert pages == [(str(k), last) for k in range(1, int(last) + 1)]


def test_file_claims_its_standards_and_has_the_figures(pdf):
    """It says that it is PDF/A-2a and PDF/UA-1; four figures have words for them."""
    assert pdf.startswith(b"%PDF-")
    assert re.search(rb"pdfaid:part>2<.*pdfaid:conformance>A<", pdf, re.DOTALL)
    assert b"pdfuaid:part>1<" in pdf
    assert len(set(re.findall(rb"/Alt *\(Figure ([1-4]):", pdf))) == 4


def test_same_bytes_every_time_and_the_date_is_the_given_one(tmp_path):
    """With SOURCE_DATE_EPOCH two processes write the same bytes, beside the page."""
    written = []
    for place in ("a", "b"):
        folder = tmp_path / place
        folder.mkdir()
        run = start(
            *("paper", "-o", "paper.pdf", "-o", "paper.html"),
            cwd=folder,
            SOURCE_DATE_EPOCH="86400",
        )
        assert run.code == 0, run.err
        assert {path.name for path in folder.iterdir()} == {"paper.pdf", "paper.html"}
        written.append((folder / "paper.pdf").read_bytes())
    assert written[0] == written[1]
    assert b"D:19700102" in written[0]


def test_all_files_or_none(tmp_path):
    """Where one file cannot be written the other is not either."""
    run = call("paper", "-o", tmp_path / "a.pdf", "-o", tmp_path / "none" / "a.html")
    assert run.code == 2
    assert not list(tmp_path.iterdir())


@needs_pdftotext
@pytest.mark.parametrize(
    "text", ['#panic("x")', "$", "<a>", "*b*", "`c`", '"; #1', "\\", "@d", "= e"]
)
def test_foreign_text_is_shown_as_it_is(template, tmp_path, text):
    """Nothing in the data is markup of typst."""
    source = '#let data = json("data.json")\n#set document(title: "t")\n#data.text'
    pdf = render_pdf(template(source), {"text": text}, {}, date=DATE)
    assert squeeze(text) in text_of(pdf, tmp_path)


def test_errors_of_typst_are_told(template):
    """A template that stops is an OutputError of one line with the reason."""
    with pytest.raises(OutputError, match=r"^x\.typ: typst says: .*no such thing"):
        render_pdf(template('#panic("no such thing")'), {}, {}, date=DATE)


def test_an_image_without_words_is_refused(template):
    """Who cannot see a figure is told what it shows: PDF/UA is held to it."""
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>'
    source = '#set document(title: "t")\n#image("images/a.svg")'
    with pytest.raises(OutputError, match="alt"):
        render_pdf(template(source), {}, {"a.svg": svg}, date=DATE)


def test_a_font_that_is_not_there_is_told(template):
    """A doubt of typst is a warning: the page would not be what was meant."""
    source = '#set document(title: "t")\n#text(font: "Nowhere Sans")[a]'
    with pytest.warns(UserWarning, match="nowhere sans"):
        render_pdf(template(source), {}, {}, date=DATE)
