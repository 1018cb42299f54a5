"""A template as PDF: foreign text stays text, and what typst refuses is told."""

from __future__ import annotations

import json

import pytest
from command_line import call
from reading import ask, needs_poppler, squeeze, text_of

from budget.errors import OutputError
from budget.report import typeset as pdf_module
from budget.report.typeset import render_pdf

DATE = "2026-01-31"


@pytest.fixture
def template(tmp_path, monkeypatch):
    """Return what puts a template in the place of the shipped ones."""

    def put(source):
        (tmp_path / "x.typ").write_text(source, encoding="utf-8")
        monkeypatch.setattr(pdf_module, "template_file", lambda name: tmp_path / name)
        return "x.typ"

    return put


@needs_poppler
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


@pytest.mark.slow
@needs_poppler
def test_what_is_copied_of_a_report_has_its_long_words_whole(tmp_path):
    """Hashes and DOIs can be searched and copied: where a line may end is no sign."""
    path = tmp_path / "report.pdf"
    asked = ("report", "hg4930#C", "--no-validate", "-o", path, "--json", "-")
    document = json.loads(call(*asked).out)
    text = ask(path.read_bytes(), tmp_path, "pdftotext", "FILE", "-")
    for one in document["inputs"].values():
        assert one["sha256"] in text
    assert "10.11823/j.issn.1674-5795.2019.03.06" in text
    assert "\N{ZERO WIDTH SPACE}" not in text
