"""A document as PDF: all of it there, to standard, the same every time, and safe."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import replace

import pytest
from numpy.testing import assert_allclose
from places import TESTS
from reading import (
    ask,
    needs_poppler,
    needs_qpdf,
    needs_verapdf,
    pages_of,
    squeeze,
    text_of,
    words_beyond,
)
from report_examples import (
    DATE,
    make_document,
    make_overview,
    make_picture,
    make_table,
)

from budget.errors import OutputError
from budget.report import typeset as pdf_module
from budget.report.blocks import (
    Abreast,
    Cell,
    Column,
    Listing,
    Panel,
    RowGroup,
    Run,
    Section,
    Table,
)
from budget.report.formulas import Math
from budget.report.typeset import (
    BREAK,
    break_long,
    cut_numbers,
    cut_words,
    shorten,
    typeset,
)

MINUS, TIMES = "\N{MINUS SIGN}", "\N{MULTIPLICATION SIGN}"
TEN = f"\u202f{TIMES}\u202f10"
NOWHERE = ()  # no font besides the bundled ones


def make_pdf(paper="a4", **changes):
    """Return the PDF of the document made by hand, set with the bundled fonts."""
    return typeset(make_document(**changes), paper=paper, folders=NOWHERE).pdf


@pytest.fixture(scope="module")
def pdf():
    return make_pdf()


def texts_of(part):
    """Yield every text of a document, but not what computes or draws."""
    if isinstance(part, str):
        yield part
    elif isinstance(part, tuple):
        for item in part:
            yield from texts_of(item)
    elif hasattr(part, "__dataclass_fields__"):
        for name in part.__dataclass_fields__:
            if name not in {
                *("svg", "json", "model", "tips", "caption", "name", "kind", "alt"),
                *("number", "source"),
            }:
                yield from texts_of(getattr(part, name))


@needs_poppler
def test_every_text_of_the_document_can_be_found(pdf, tmp_path):
    """Titles, facts, terms, heads, cells and notes are all in the file."""
    text = text_of(pdf, tmp_path)
    document = make_document()
    found = 0
    for words in texts_of(document):
        number = re.fullmatch(r"(-?)([\d.]+)e-(\d)", words)
        shown = re.sub(r"\^(?=\d)", "", re.sub(r"(?<!\S)-(?=\d)", MINUS, words))
        if number:  # as it is set: a true minus, the power of ten raised
            sign, digits, power = number.groups()
            shown = f"{sign and MINUS}{digits}{TIMES}10{MINUS}{power}"
        if words not in {"All is given.", "Nothing varies."}:  # of lists with points
            assert squeeze(shown) in text, words
            found += 1
    assert found > 400


@needs_poppler
def test_texts_of_figures_can_be_found(pdf, tmp_path):
    """Figures keep their text as text: labels of axes and of bars."""
    text = text_of(pdf, tmp_path)
    assert squeeze("share of the variance [%]") in text
    assert squeeze("angle random walk") in text


@needs_poppler
def test_page_one_answers(pdf, tmp_path):
    """Verdict, overview, contributions and what is open are all on page one."""
    first, *others = pages_of(pdf, tmp_path)
    document = make_document()
    for words in (
        *(document.title, document.headline, *document.facts, document.date),
        *(card.title for card in document.cards),
        *(s.title for s in document.sections if s.on_first_page),
        *("Not given", "2 arcsec is a largest value, uniform"),
        make_overview().title,
    ):
        assert squeeze(words) in first
    assert not any("Contents" in page for page in others)


@needs_poppler
def test_pages_are_numbered_under_a_running_head(pdf, tmp_path):
    """Every page says which of how many it is; from the second on, the verdict."""
    pages = pages_of(pdf, tmp_path)
    assert len(pages) > 3
    for place, page in enumerate(pages, 1):
        assert f"page{place}of{len(pages)}" in page
    for page in pages[1:]:
        assert page.startswith(squeeze(make_document().running_head))


@needs_poppler
def test_heads_of_tables_repeat(pdf, tmp_path):
    """A table of 89 rows has its head on each page that it reaches."""
    pages = [p for p in pages_of(pdf, tmp_path) if re.search(r"source\d+0\.050", p)]
    assert len(pages) > 2
    assert all("whereitcomesfrom" in page for page in pages)


@needs_poppler
def test_contents_name_the_pages(tmp_path):
    """Contents of a long document say for each section the page on which it is."""
    sections = make_document().sections
    more = [replace(sections[-1], title=f"Part {k}", blocks=()) for k in range(12)]
    pages = pages_of(make_pdf(sections=(*sections, *more)), tmp_path)
    listed = dict(re.findall(r"(Inputs|Method|Whatif)\.+(\d)", pages[1]))
    assert len(listed) == 3
    for title, page in listed.items():
        assert title in pages[int(page) - 1]


@needs_poppler
def test_nothing_is_cut_at_the_edges(pdf, tmp_path):
    """No word reaches over the edge of a page."""
    assert not words_beyond(pdf, tmp_path)


@needs_poppler
@pytest.mark.parametrize(
    ("paper", "sheet"), [("a4", (595.28, 841.89)), ("letter", (612.0, 792.0))]
)
def test_pdf_is_set_for_its_paper(tmp_path, paper, sheet):
    """Every page is a sheet of it, and words go to its margins and no further."""
    pdf = make_pdf(paper=paper)
    boxes = ask(pdf, tmp_path, "pdftotext", "-bbox", "FILE", "-")
    pages = re.findall(r'<page width="([\d.]+)" height="([\d.]+)"', boxes)
    edges = [float(x) for x in re.findall(r'xMax="([-\d.]+)"', boxes)]

    assert len(pages) > 1
    for page in pages:
        assert_allclose([*map(float, page)], sheet, rtol=1e-4)
    margin = 15.0 / 25.4 * 72.0
    assert sheet[0] - 2 * margin < max(edges) < sheet[0] - margin + 1.0
    assert not words_beyond(pdf, tmp_path)


def test_file_claims_its_standards(pdf):
    """It says that it is PDF/A-2a and PDF/UA-1, tagged, English, of that day."""
    assert re.search(rb"pdfaid:part>2<.*pdfaid:conformance>A<", pdf, re.DOTALL)
    assert b"pdfuaid:part>1<" in pdf
    assert re.search(rb"/Marked true", pdf)
    assert re.search(rb"/Lang *\(en", pdf)
    assert f"D:{DATE.replace('-', '')}".encode() in pdf


def test_figures_and_formulas_have_words(pdf):
    """What cannot be read aloud has an alternative text."""
    alternatives = set(re.findall(rb"/Alt *(\(.*?[^\\]\)|<[0-9A-Fa-f]+>)", pdf))
    assert len([a for a in alternatives if b"variance by axis" in a]) == 3
    assert any(b"outputs exceed their limits" in a for a in alternatives)
    assert b"(u_c)" in alternatives
    assert b"(mean of N)" in alternatives


def test_sections_and_panels_are_bookmarks(pdf):
    """The outline of the file has every section, and the panels in them."""
    titles = set(re.findall(rb"/Title *\((.*?)\)", pdf))
    assert {b"Budget", b"What if", b"Inputs", b"Method", b"Not given"} <= titles


@needs_poppler
def test_title_and_fonts(pdf, tmp_path):
    """The title of the file says what it is of; every font is inside."""
    about = ask(pdf, tmp_path, "pdfinfo", "FILE")
    assert re.search(r"Title: +Zhao 2019 optical IMU: FAILS tactical grade\n", about)
    assert re.search(r"Tagged: +yes", about)
    assert re.search(r"Page size: .*A4", about)
    fonts = ask(pdf, tmp_path, "pdffonts", "FILE").splitlines()[2:]
    assert len(fonts) >= 3
    for font in fonts:
        assert re.search(r" yes yes yes +\d+ +\d+$", font)  # embedded, subset, unicode


@needs_qpdf
def test_file_is_whole(pdf, tmp_path):
    """Qpdf finds nothing wrong in it."""
    assert "No syntax or stream encoding errors" in ask(
        pdf, tmp_path, "qpdf", "--check", "FILE"
    )


@pytest.mark.slow
@needs_verapdf
@pytest.mark.parametrize("flavour", ["2a", "ua1"])
def test_file_keeps_its_standards(tmp_path, flavour):
    """VeraPDF finds that it is what it claims, on either paper."""
    pdf = make_pdf(paper={"2a": "a4", "ua1": "letter"}[flavour])
    said = ask(pdf, tmp_path, "verapdf", "-f", flavour, "--format", "text", "FILE")
    assert said.startswith("PASS")


@pytest.mark.slow
def test_same_bytes_in_every_process(pdf):
    """Another process, with other hashes of texts, writes the same bytes."""
    code = (
        "import hashlib\nfrom report.test_typeset import make_pdf\n"
        "print(hashlib.sha256(make_pdf()).hexdigest())"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=TESTS,
        env={**os.environ, "PYTHONHASHSEED": "1"},
    )
    assert run.stdout.strip() == hashlib.sha256(pdf).hexdigest()


HOSTILE = (
    *('#panic("x")', "#eval(1)", "$ x^2 $", "*b* _i_", "`c`", "<label>", "@ref"),
    *("= head", "- point", "+ point", "/ term: x", "\\", "\\u{41}", '"quoted"', "'"),
    *("// comment", "/* comment */", "https://example.org", "[x](y)", "--- ~ ...", "#"),
    *("</text><script>", "&amp; &lt;", "{{ x }}", "%PDF", "\N{RIGHT-TO-LEFT MARK}x"),
)


@needs_poppler
def test_foreign_text_is_shown_as_it_is(tmp_path):
    """Nothing in a document is markup of typst, wherever in it it stands."""
    cells = tuple(
        (Cell(text=text, note=text), Cell(text=text), Cell(text=text))
        for text in HOSTILE
    )
    table = Table(
        name="hostile",
        caption=HOSTILE[0],
        columns=(
            Column(head="#panic()"),
            Column(head="$", kind="number"),
            Column(head="*", kind="code"),
        ),
        groups=(RowGroup(rows=cells, title="#panic()"),),
    )
    listing = Listing(items=tuple((text,) for text in HOSTILE), empty="")
    text = text_of(
        make_pdf(
            title=" ".join(HOSTILE),
            headline="#panic()",
            facts=HOSTILE,
            summary=HOSTILE,
            sections=(
                Section(
                    name="a",
                    title=" ".join(HOSTILE),
                    blocks=(table, Panel(title="#panic()", blocks=(listing,))),
                ),
            ),
        ),
        tmp_path,
    )
    for words in HOSTILE:
        # Direction marks have no glyph and poppler leaves them out.
        assert text.count(squeeze(words.strip("\u200f"))) >= 6, words


@pytest.mark.slow
@needs_poppler
@pytest.mark.parametrize("word", ["x" * 10_000, "long words " * 900, "a/b_c." * 1500])
def test_long_names_do_not_leave_the_page(tmp_path, word):
    """A name of ten thousand letters is broken, not cut, and shown to its end."""
    name = f"{word}END"
    row = (Cell(text=name, note=name), Cell(text=name), Cell(text="1"))
    table = Table(
        name="long",
        caption="long",
        columns=(Column(head=name), Column(head="u"), Column(head="n", kind="number")),
        groups=(RowGroup(rows=(row,)),),
    )
    panel = Panel(title=name, blocks=(Listing(items=((name,),), empty=""),))
    pdf = make_pdf(
        title=name,
        sections=(
            Section(
                name="a",
                title="a",
                blocks=(table, Abreast(blocks=(panel, panel, panel), columns=3)),
            ),
        ),
    )
    assert not words_beyond(pdf, tmp_path)
    text = re.sub(r"page\d+of\d+|budget0\.4,2026-01-31", "", text_of(pdf, tmp_path))
    assert text.count("END") == 1 + 3 + 6  # title; cells and note; panels


@needs_poppler
@pytest.mark.parametrize("rows", [0, 1, 120])
def test_panels_of_any_length_stand_abreast(tmp_path, rows):
    """Beside each other, panels that are longer than a page go on on the next."""
    group = make_table().groups[0].rows[0]
    panel = Panel(
        title="panel",
        blocks=(make_table("t", groups=(RowGroup(rows=(group,) * rows),)),),
    )
    pdf = make_pdf(
        sections=(Section(name="a", title="a", blocks=(Abreast(blocks=(panel,) * 2),)),)
    )
    assert not words_beyond(pdf, tmp_path)
    assert text_of(pdf, tmp_path).count("biasrepeatability0.05079") == 2 * rows


def test_a_document_without_anything_is_a_page():
    """No cards, no sections, no facts: still a file."""
    assert make_pdf(cards=(), sections=(), facts=(), summary=()).startswith(b"%PDF-")


@needs_poppler
def test_figures_as_numbers_are_at_the_end(pdf, tmp_path):
    """The data behind figures are printed, and each figure says where."""
    text, pages = text_of(pdf, tmp_path), pages_of(pdf, tmp_path)
    told = re.findall(r"Asnumbers:page(\d+)\.", text)
    assert len(told) == 2
    assert text.count(squeeze(make_overview().title)) == 2
    assert squeeze(make_overview().title) in pages[int(told[0]) - 1]


def test_a_figure_twice_is_printed_twice():
    """The same record in two places is no mistake."""
    picture = make_picture()
    twice = Section(name="a", title="a", blocks=(picture, picture))
    assert make_pdf(sections=(twice,)).count(b"variance by axis") >= 2


def test_a_lost_template_is_told(tmp_path, monkeypatch):
    """A template that is not there is one line that says what to do."""
    monkeypatch.setattr(pdf_module, "template_file", lambda name: tmp_path / name)
    with pytest.raises(
        OutputError, match=r"report\.typ: cannot read .*install"
    ) as told:
        make_pdf()
    assert "\n" not in str(told.value)


def test_no_room_for_temporary_files_is_told(tmp_path, monkeypatch):
    """Without a folder for them the message is one line that names the remedy."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with pytest.raises(OutputError, match=r"temporary files .*TMPDIR") as told:
        make_pdf()
    assert "\n" not in str(told.value)


def test_a_broken_figure_is_told():
    """A drawing that is none is an OutputError, not a page without it."""
    broken = replace(make_picture(), svg="<svg")
    with pytest.raises(OutputError, match="typst says") as told:
        make_pdf(sections=(Section(name="a", title="a", blocks=(broken,)),))
    assert "\n" not in str(told.value)


# ---- numbers and words, cut into the parts that a page sets apart --------------------

BOUND, FIGURE, POINT = "\u00a0", "\u2007", "\u2008"


def flat(part):
    """Write a part as it reads."""
    if isinstance(part, str):
        return part
    if part["is"] == "number":
        power = f"*10^{part['power']}" if part["power"] else ""
        return part["head"] + part["digits"] + power + part["tail"] + part["pad"]
    if part["is"] == "raised":
        return f"^{part['text']}"
    return f"<{''.join(map(flat, part['parts']))}>"


@pytest.mark.parametrize(
    ("texts", "printed"),
    [
        (["0.050", "12"], ["0.050", f"12{POINT}{FIGURE * 3}"]),
        (["-1.5", "0.25"], [f"{MINUS}1.5{FIGURE}", "0.25"]),
        (["<0.1", "79"], ["<0.1", f"79{POINT}{FIGURE}"]),
        (
            ["2.3e-9", "1.25", "7"],
            [f"2.3*10^{MINUS}9", "1.25", f"7{POINT}{FIGURE * 2}"],
        ),
        (["79 %", "0.3 %"], [f"79{BOUND}%{POINT}{FIGURE}", f"0.3{BOUND}%"]),
        (["230 000", "1"], ["230\u202f000", "1"]),
        (["-", "holds", "", "2x"], ["-", "holds", "", "2x"]),
    ],
)
def test_numbers_of_a_column_are_padded_to_their_points(texts, printed):
    """Points are in line; powers, words and dashes have no part in it."""
    assert [flat(part) for part in cut_numbers(texts)] == printed


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("u 0.050 deg/h", f"u 0.050{BOUND}deg/h"),
        (
            "from -0.5 to -2.3e-9 ppm",
            f"from {MINUS}0.5{BOUND}to {MINUS}2.3{TEN}^{MINUS}9{BOUND}ppm",
        ),
        ("HG4930-2 of 2026-01-31", f"HG4930-2{BOUND}of 2026-01-31"),
        ("zhao-2019.yaml a-1, -v, -3b", "zhao-2019.yaml a-1, -v, -3b"),
        ("1e5 x", f"1{TEN}^5{BOUND}x"),
        ("9f86e08, v1e5, 12e4ab", "9f86e08, v1e5, 12e4ab"),
    ],
)
def test_numbers_in_a_sentence_are_set_as_numbers(text, printed):
    """A minus, a power of ten and a unit are; names, dates and hashes stay."""
    assert "".join(map(flat, cut_words((text,)))) == printed


def test_bold_runs_are_marked():
    """A strong run is one; a run that is not is plain text."""
    parts = cut_words((Run(text="a", strong=True), Run(text="b", exact=1.0), "c"))
    assert "".join(map(flat, parts)) == "<a>bc"


def test_formulas_have_a_source_and_words():
    """The template sets the one, who hears the page hears the other."""
    (part,) = cut_words((Math(source="macron(N)"),))
    assert part == {"is": "math", "alt": "mean of N", "source": "macron(N)"}


def test_long_words_may_be_broken_and_short_ones_not():
    """A path is broken after its signs, a run of letters anywhere, words nowhere."""
    assert break_long("accelerometer repeatability") == "accelerometer repeatability"
    assert break_long("a-very/long_path.of/several-parts") == BREAK.join(
        ["a-", "very/", "long_", "path.", "of/", "several-", "parts"]
    )
    pieces = break_long("x" * 100).split(BREAK)
    assert max(map(len, pieces)) == 12
    assert "".join(pieces) == "x" * 100


def test_what_is_cut_shows_it():
    """A shortened text ends in an ellipsis; a short one is whole."""
    assert shorten("abc", 3) == "abc"
    assert shorten("abc defg", 5) == "abc\u2026"
