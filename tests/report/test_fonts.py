"""Any script shows, in a font of the machine or as code points; never boxes."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from unicodedata import category

import numpy as np
import pytest
import typst
from reading import ask, needs_poppler, squeeze, text_of
from report_examples import make_document, make_picture, make_table

from budget.report.blocks import Cell, Column, RowGroup, Section, Table
from budget.report.fonts import FontSet, choose_fonts, clusters
from budget.report.typeset import typeset

NOTO = {  # folders of this machine in which Debian's fonts-noto-cjk is
    Path(font.path).parent
    for font in typst.Fonts(include_embedded_fonts=False).fonts()
    if font.path and font.family == "Noto Sans CJK SC"
}
needs_noto = pytest.mark.skipif(
    not NOTO, reason="sets Chinese in the fonts of Debian's fonts-noto-cjk"
)
CHINESE = "\u8d75\u660e\u60ef\u5bfc"  # a surname, bright, inertial navigation
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="200pt" height="40pt">'
    '<title>{0}</title><text x="5" y="20" style="font: 9px \'DejaVu Sans\'">'
    "{0}</text></svg>"
)


def make_named(*names):
    """Return a short document with names in a title, a cell, a head and a figure."""
    table = Table(
        name="t",
        caption=names[0],
        columns=(Column(head=names[0]), Column(head="b", kind="code")),
        groups=(
            RowGroup(
                title=names[0],
                rows=tuple(
                    (Cell(text=name, note=name, strong=True), Cell(text=name))
                    for name in names
                ),
            ),
        ),
    )
    safe = "".join(names).translate(str.maketrans("", "", "<>&"))
    picture = replace(make_picture(), svg=SVG.format(safe), alt=safe, data=None)
    return make_document(
        title=names[0],
        sections=(Section(name="s", title=names[0], blocks=(table, picture)),),
        cards=(),
    )


@needs_poppler
def test_characters_without_a_font_are_code_points(tmp_path):
    """Where no font has Chinese, its code points are printed and named."""
    made = typeset(make_named(f"IMU {CHINESE[0]}"), folders=())
    assert made.replaced == ("U+8D75",)
    text = text_of(made.pdf, tmp_path)
    assert text.count("IMUU+8D75") >= 7  # in the figure too
    assert CHINESE[0] not in text


@pytest.mark.slow
@needs_noto
@needs_poppler
def test_chinese_is_shown_in_a_font_that_has_it(tmp_path):
    """Chinese is text of the file, in the form of its country, in figures too."""
    made = typeset(make_named(CHINESE), folders=[*NOTO])
    assert made.replaced == ()
    assert text_of(made.pdf, tmp_path).count(CHINESE) >= 7
    fonts = ask(made.pdf, tmp_path, "pdffonts", "FILE")
    assert "NotoSansCJKsc-Regular" in fonts
    assert "NotoSansCJKsc-Bold" in fonts
    assert "CJKjp" not in fonts
    assert typeset(make_named(CHINESE), folders=[*NOTO]).pdf == made.pdf


@needs_noto
@pytest.mark.parametrize(
    ("text", "country"), [("\u8d75", "SC"), ("\u3072\u8d75", "JP"), ("\ud55c", "KR")]
)
def test_script_beside_them_says_which_country_han_is_of(text, country):
    """Kana make it Japanese, Hangul Korean, nothing Chinese."""
    found = choose_fonts([text], folders=[*NOTO])
    assert found.families == ("DejaVu Sans", f"Noto Sans CJK {country}")


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("a\x00b", "aU+0000b"),
        ("a\x07b", "aU+0007b"),
        ("a\x85b", "aU+0085b"),
        ("a\ue000b", "aU+E000b"),
        ("a\ufeffb", "aU+FEFFb"),
        ("a\U0010ffffb", "aU+10FFFFb"),
        ("a\ud800b", "aU+D800b"),
        ("a\u202eb\u202c", "aU+202EbU+202C"),
        ("a\u2066b", "aU+2066b"),
        ("a\U0001f9eab", "aU+1F9EAb"),
        ("\u8d75\u0301x", "U+8D75 U+0301x"),
        ("\U0001f6f0\ufe0f\U0001f9eab", "U+1F6F0 U+1F9EAb"),
        ("a\u20ddb", "aU+20DDb"),
    ],
)
def test_what_no_font_may_show_is_named(text, printed):
    """Controls, private use and commands of direction are code points."""
    found = choose_fonts([text], folders=())
    assert found.printable(text) == printed
    assert found.missing(text)


@pytest.mark.parametrize(
    "text",
    [
        *("abc", "\u03b5 \u2212 \u00d7", "e\u0301", "\u0628\u0627", "a\u200db"),
        *("\U0001f600", "x\ty\nz", "a\u2028b", "\u05d0", "a\u00adb", "\u2007\u202f"),
    ],
)
def test_what_the_bundled_font_has_is_kept(text):
    """Marks that compose, Greek, Arabic, joiners and line breaks stay."""
    found = choose_fonts([text], folders=())
    assert found.printable(text) == text
    assert found.families == ("DejaVu Sans",)


def test_marks_stay_with_their_letter():
    """A letter and its marks are one; a mark after a blank is alone."""
    assert clusters("e\u0301\u0323x") == ["e\u0301\u0323", "x"]
    assert clusters(" \u0301") == [" ", "\u0301"]


def test_drawings_name_the_font_of_each_part():
    """Only text of a drawing is split by fonts; its tags are left alone."""
    lettering = FontSet(
        families=("DejaVu Sans", "Other"),
        faces=(),
        coverage=(frozenset(range(32, 127)), frozenset(map(ord, CHINESE))),
    )
    drawn = lettering.drawable(f'<g id="a"/><text x="1">a {CHINESE} b\ue000</text>')
    assert drawn == (
        '<g id="a"/><text x="1">a <tspan style="font-family: \'Other\'">'
        f"{CHINESE}</tspan> bU+E000</text>"
    )


def test_a_file_that_is_no_font_is_passed_over(tmp_path):
    """Broken fonts of a machine are no reason to stop."""
    (tmp_path / "broken.ttf").write_bytes(b"\x00\x01\x00\x00 no font")
    assert choose_fonts([CHINESE], folders=[tmp_path]).faces == ()


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.slow
def test_no_text_stops_typst(seed):
    """Random characters of all scripts, with random marks, make a PDF."""
    characters = [
        c
        for c in map(chr, range(0x30000))
        if category(c) != "Cs" and not 0x3400 <= ord(c) < 0xD7A4
    ]
    every = np.array(characters)
    marks = np.array([c for c in characters if category(c) in {"Mn", "Mc", "Me"}])
    rng = np.random.default_rng(seed)
    names = [
        "".join(
            rng.choice(marks if rng.random() < 0.25 else every)
            for _ in range(rng.integers(1, 7))
        )
        for _ in range(100)
    ]
    made = typeset(make_named(*names), folders=None if seed == 0 else ())
    assert made.pdf.startswith(b"%PDF-")
    assert len(made.replaced) > 50
    assert all(re.fullmatch(r"U\+[0-9A-F]{4,6}", code) for code in made.replaced)


@needs_poppler
def test_right_to_left_names_do_not_turn_their_neighbours(tmp_path):
    """A Hebrew name is there, and what stands beside it keeps its order."""
    document = make_named("A \u05d0\u05d1 B")
    table = make_table()
    section = replace(document.sections[0], blocks=(table,))
    text = text_of(
        typeset(replace(document, sections=(section,)), folders=()).pdf, tmp_path
    )
    assert "\u05d0\u05d1" in text
    assert squeeze("bias repeatability") in text
