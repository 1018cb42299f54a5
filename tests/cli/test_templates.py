"""Templates of one's own: letterhead, style, words, targets; broken ones are told."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from command_line import call
from reading import needs_poppler, squeeze, text_of

pytestmark = pytest.mark.usefixtures("analyzed_once", "drawn_once")
EXAMPLE = Path(__file__).parents[2] / "examples" / "templates"
REPORT = ("report", "stim300#5g", "--no-validate")
FURTHER = "pages/further.md.j2"


@pytest.fixture
def own(tmp_path):
    """Return a folder of templates that may be changed."""
    return Path(shutil.copytree(EXAMPLE, tmp_path / "own"))


@pytest.mark.slow
@needs_poppler
def test_a_company_has_its_letterhead_style_and_words(own, tmp_path):
    """In HTML and PDF; the page loads nothing, and without the option it is as ever."""
    html, pdf, bare = (tmp_path / name for name in ("x.html", "x.pdf", "y.html"))
    call(*REPORT, "--templates", str(own), "-o", str(html), "-o", str(pdf), code=0)
    assert call(*REPORT, "-o", str(bare)).code == 0
    page, plain = (path.read_text("utf-8") for path in (html, bare))
    assert 'src="data:image/svg+xml;base64,' in page
    assert "header h1, .verdict .word { color: #0b5394; }" in page
    assert "Terms of the laboratory" in page
    assert "<strong>STIM300 (5g)</strong>" in page or "<strong>STIM300" in page
    assert "--templates own" in page  # the provenance: which call it was
    for text in ("Terms of the laboratory", "#0b5394; }", "Example Navigation"):
        assert text not in plain
    said = text_of(pdf.read_bytes(), tmp_path)
    for text in ("Example Navigation, test laboratory", "Terms of the laboratory"):
        assert squeeze(text) in squeeze(said)


def test_a_block_of_the_page_and_a_page_of_a_section_are_overridden(own, tmp_path):
    """By the name of the shipped one, which may be extended."""
    (own / "page.html.j2").write_text(
        '{% extends "shipped/page.html.j2" %}\n'
        "{% block footer %}<p>{{ document.title }} & own</p>{% endblock %}\n",
        encoding="utf-8",
    )
    html = tmp_path / "x.html"
    call(*REPORT, "--templates", str(own), "-o", str(html), code=0)
    assert " & own</p>" in html.read_text("utf-8")


@pytest.mark.parametrize(
    ("page", "lacks"), [("words", "not_given"), ("equations", "model")]
)
def test_a_macro_that_a_page_of_ones_own_lacks_is_told(own, tmp_path, page, lacks):
    """Whether another page or the program asks for it; nothing is written."""
    (own / "pages" / f"{page}.md.j2").write_text("{% macro x() %}{% endmacro %}")
    html = tmp_path / "x.html"
    found = call(*REPORT, "--templates", str(own), "-o", str(html), code=2)
    assert lacks in found.err
    assert page in found.err
    assert "mend this template" in found.err
    assert not html.exists()


def test_a_target_of_ones_own_is_exported(own):
    """Named by its file, with the filters of the others."""
    (own / "export").mkdir()
    shipped = EXAMPLE.parents[1] / "templates" / "export" / "kalibr.yaml.j2"
    text = shipped.read_text("utf-8").replace("kalibr", "own")
    (own / "export" / "own.yaml.j2").write_text(text, encoding="utf-8")
    words = ("export", "stim300#5g", "--to", "own", "--rate", "200")
    mine = call(*words, "--templates", str(own), code=0)
    assert "accelerometer_noise_density" in mine.out
    assert call(*words).code == 2


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        (FURTHER, "a\n{% if x %}\n", ":2: Unexpected end of template"),
        (FURTHER, "a\n{{ nothing }}\n", ":2: 'nothing' is undefined"),
        (FURTHER, "a\n\n{{ document.nothing }}\n", ":3: "),
        (FURTHER, "{{ ''.__class__.__mro__ }}", ":1: access to attribute '__class__'"),
        (FURTHER, "{{ 1/0 }}", ":1: division by zero"),
        (FURTHER, "{{ x|nofilter }}", ":1: No filter named 'nofilter'"),
        (FURTHER, '{% include "nowhere" %}', "no template is called so"),
        (FURTHER, "{% for i in range(10**9) %}{% endfor %}", ":1: Range too big"),
        (FURTHER, "{% macro a() %}{{ a() }}{% endmacro %}{{ a() }}", ":1: maximum"),
        ("letterhead.html.j2", '{{ "no.svg"|embedded }}', "no such picture is there"),
        ("page.css", "{% endif %}", ":1: Encountered unknown tag 'endif'"),
        (
            "page.html.j2",
            '{% extends "shipped/page.html.j2" %}{% block footer %}\n\n{{ x }}',
            ":3: Unexpected end of template",
        ),
    ],
)
def test_a_broken_template_is_told_with_its_line_and_nothing_is_written(
    own, tmp_path, file, text, said
):
    """In one line, without a traceback, with code 2."""
    (own / file).write_text(text, encoding="utf-8")
    html = tmp_path / "x.html"
    found = call(*REPORT, "--templates", str(own), "-o", str(html))
    (line,) = found.err.strip().splitlines()
    assert (found.code, html.exists()) == (2, False)
    assert line.startswith(str(own / file).removesuffix(file))
    assert said in line


def test_letters_that_are_none_and_a_folder_that_is_not_there_are_told(own, tmp_path):
    """As any other file that cannot be read."""
    html = tmp_path / "x.html"
    (own / FURTHER).write_bytes(b"\xff\xfe words")
    found = call(*REPORT, "--templates", str(own), "-o", str(html), code=2)
    assert "not UTF-8" in found.err
    for folder in (tmp_path / "nowhere", own / "logo.svg"):
        found = call(*REPORT, "--templates", str(folder), "-o", str(html), code=2)
        assert "no folder of templates is there" in found.err
    assert not html.exists()


@needs_poppler
def test_a_broken_letterhead_of_a_pdf_is_told(own, tmp_path):
    """By what typst says of it."""
    (own / "letterhead.typ").write_text("#nothing()", encoding="utf-8")
    pdf = tmp_path / "x.pdf"
    found = call(*REPORT, "--templates", str(own), "-o", str(pdf))
    assert (found.code, pdf.exists()) == (2, False)
    assert "unknown variable: nothing" in found.err


def test_a_picture_that_is_too_large_is_refused(own, tmp_path):
    """Before anything is written."""
    (own / "logo.svg").write_bytes(b" " * 1_000_001)
    html = tmp_path / "x.html"
    found = call(*REPORT, "--templates", str(own), "-o", str(html))
    assert (found.code, html.exists()) == (2, False)
    assert "1000001 bytes, allowed are 1000000" in found.err
