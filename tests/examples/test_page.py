"""The paper as a document: every row and verdict in it, in HTML and in PDF."""

from __future__ import annotations

import re
from html import unescape

import pytest
from command_line import call
from reading import needs_poppler, squeeze, text_of

from budget.report.blocks import Abreast, Picture, Table, drawn
from budget.report.document import json_text
from budget.report.inline import MINUS, cut
from budget.report.page import render_page
from budget.report.typeset import typeset
from budget.report.writing import capital
from zhao_2019.figures import print_ratio
from zhao_2019.page import paper_document, print_ours, printed_cell, reason
from zhao_2019.printed import Agreement
from zhao_2019.study import reproduce

DATE = "2026-01-31"
NO_FONTS = ()  # besides the bundled ones


@pytest.fixture(scope="module")
def study():
    return reproduce()


@pytest.fixture(scope="module")
def document(study):
    return drawn(paper_document(study, date=DATE))


@pytest.fixture(scope="module")
def pdf(document):
    return typeset(document, folders=NO_FONTS).pdf


def section_of(document, title):
    """Return the one section with a title."""
    (found,) = (part for part in document.sections if part.title == title)
    return found


def table_of(section):
    """Return the one table of a section."""
    (found,) = (block for block in section.blocks if isinstance(block, Table))
    return found


def pictures_of(document):
    """Return all figures."""
    return [
        picture
        for section in document.sections
        for block in section.blocks
        if isinstance(block, Abreast)
        for picture in block.blocks
        if isinstance(picture, Picture)
    ]


def said(row):
    """Return the texts in which a finding must be found."""
    group, *own = row.place
    return (capital(group), *own, row.verdict, reason(row))


@pytest.mark.parametrize(
    "name", ["table 1", "figures", "text", "formulas", "conclusions", "readings"]
)
def test_every_finding_is_one_row_with_its_numbers(study, document, name):
    """Rows of a section are its findings: printed, ours, ratio and both p, exact."""
    table = table_of(section_of(document, study.paper.sections[name]))
    rows = {
        (group.title, row[0].text, row[0].note): row
        for group in table.groups
        for row in group.rows
    }
    findings = study.of_section(name)
    assert sum(len(group.rows) for group in table.groups) == len(findings)
    for finding in findings:
        group, head, *special = finding.place
        row = rows[capital(group), head, "".join(special)]
        texts = " ".join(f"{cell.text} {cell.note}" for cell in row)
        assert printed_cell(finding.printed).text in texts
        assert print_ours(finding) in texts
        assert print_ratio(finding.ratio) in texts
        assert finding.verdict in texts
        exact = {cell.exact for cell in row}
        numbers = (finding.ratio, finding.p_single, finding.p_mean)
        assert exact.issuperset(n for n in numbers if n is not None)
        assert isinstance(finding.ours, str) or finding.ours in exact
    assert table.searchable


def test_a_table_says_where_a_row_stands_as_a_sentence_does(study):
    """Group and row together have every word of the place, each as often."""

    def words(text):
        text = text.casefold().removeprefix("section ").removeprefix("table 1, ")
        return sorted(re.findall(r"[^\s,:]+", text))

    for row in study.findings:
        group, *own = row.place
        told = own if group == "Table 1 as a whole" else row.place
        assert words(" ".join(told)) == words(row.where)


@pytest.mark.parametrize(
    ("printed", "text", "exact", "note"),
    [
        ("-3.18263e-10", "-3.18263e-10", -3.18263e-10, ""),
        ("rms 4.74e-9", "4.74e-9", 4.74e-9, "rms"),
        ("rms 0.0887 about -1", "0.0887", 0.0887, "rms about -1"),
        ("rms 0.193 of u, single run", "0.193", 0.193, "rms of u, single"),
        ("no effect", "no effect", None, ""),
    ],
)
def test_printed_numbers_keep_their_digits(printed, text, exact, note):
    """The number stands by itself as printed, and what it is of in the note."""
    cell = printed_cell(printed)
    assert (cell.text, cell.exact, cell.note) == (text, exact, note)


def test_cards_count_every_row_once(study, document):
    """Every verdict belongs to one card, and the counts add up to all rows."""
    counted = [word for words in study.paper.cards.values() for word in words]
    assert sorted(counted) == sorted(Agreement)
    totals = [int(card.lines[0][0].text.split()[0]) for card in document.cards]
    assert sum(totals) == len(study.findings)
    assert document.headline.startswith(f"{len(study.findings)} ")


def test_what_nothing_explains_is_on_page_one(study, document):
    """Each unexplained group of entries is a point of the answer."""
    section = section_of(document, "What nothing explains")
    places = [
        row.where
        for row in study.findings
        if row.verdict == Agreement.UNEXPLAINED and row.is_summary
    ]
    (listing,) = section.blocks
    assert section.on_first_page
    assert len(listing.items) == len(places)
    for item, place in zip(listing.items, places, strict=True):
        assert item[0].casefold().startswith(place.casefold())


def test_ratios_of_table_1_are_drawn_and_said(study, document):
    """A dot for every random row, with its ratio in words; 4 of the 10 fit."""
    (picture,) = section_of(document, "Random entries of Table 1").blocks
    rows = [
        row
        for row in study.of_section("table 1")
        if re.search(r", all [36]$", row.where)
    ]
    assert len(picture.tips) == len(rows) == 10
    assert picture.title.startswith("4 of the 10 random rows")
    for row, tip in zip(rows, picture.tips.values(), strict=True):
        assert f"ratio {print_ratio(row.ratio)}" in tip
        assert f" {print_ratio(row.ratio)}, {row.verdict}" in picture.alt


def test_figures_have_words_tips_and_their_steps(study, document):
    """Four figures; behind each the exact errors at all 25 steps."""
    pictures = pictures_of(document)
    assert len(pictures) == len(study.sweeps) == 4
    for number, (picture, sweep) in enumerate(
        zip(pictures, study.sweeps, strict=True), start=1
    ):
        assert picture.alt.startswith(f"Figure {number}: ")
        assert picture.tips
        (group,) = picture.data.groups
        errors = [[cell.exact for cell in row[1:]] for row in group.rows]
        assert errors == sweep.errors.T.tolist()


def test_document_takes_its_date_and_holds_the_numbers(study, document):
    """The date is the given one, the JSON that of --json, and no seed is claimed."""
    assert (document.kind, document.date) == ("paper", DATE)
    assert document.json == json_text(study.to_dict())
    (pairs, files, _) = section_of(document, "Provenance").blocks
    assert [term for term, _ in pairs.rows] == ["made by", "command"]
    hashes = [row[2].text for group in files.groups for row in group.rows]
    assert hashes == [file.sha256 for file in study.inputs]


def test_page_says_every_row(study, document):
    """The HTML has every place, reason, verdict, meaning and assumption."""
    page = render_page(document)
    text = squeeze(unescape(re.sub(r"<[^>]*>", "", page))).casefold()
    text = text.replace("-", MINUS).replace("^", "")
    for row in study.findings:
        for words in said(row):
            assert plain(words) in text
    paper = study.paper
    for words in (
        *paper.sections.values(),
        *paper.verdicts.values(),
        *paper.assumptions,
    ):
        assert plain(words) in text


@pytest.mark.slow
@needs_poppler
def test_pdf_says_every_row(study, pdf, tmp_path):
    """The PDF has every place, reason, section title, and meaning of a verdict."""
    text = text_of(pdf, tmp_path).casefold().replace("-", MINUS).replace("^", "")
    for row in study.findings:
        for words in said(row):
            assert plain(words) in text
    paper = study.paper
    for words in (
        *paper.sections.values(),
        *(paper.verdicts[word] for word in study.counts),
    ):
        assert plain(words) in text


def plain(words):
    """Return a text as it is read back from a page: no line is a hyphen's alone."""
    pieces = (one if isinstance(one, str) else one.text for one in cut(words))
    return squeeze("".join(pieces)).casefold().replace("-", MINUS).replace("^", "")


def test_figures_of_the_pdf_have_words(pdf):
    """Four figures can be heard."""
    assert len(set(re.findall(rb"/Alt *\(Figure ([1-4]):", pdf))) == 4


def test_all_files_or_none(tmp_path):
    """Where one file cannot be written the other is not either."""
    call("paper", "-o", tmp_path / "a.pdf", "-o", tmp_path / "none" / "a.html", code=2)
    assert not list(tmp_path.iterdir())
