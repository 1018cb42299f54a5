"""Fonts of a PDF, character by character; code points where none has a glyph.

Text is set in DejaVu Sans, which matplotlib carries: the figures use it too, its digits
are of one width, and it is there on every machine. Only for characters that it lacks
are the fonts of the machine looked at, and only those that are needed reach typst. A
character that no font has would be a box, or stop typst, so its code point is written
in its place: 'U+8D75'.
"""

from __future__ import annotations

import os
import re
import sys
from contextlib import chdir
from dataclasses import dataclass, replace
from functools import cache
from html import escape
from importlib import import_module
from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unicodedata import category

from budget.journal import is_kept

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from fontTools.ttLib import TTFont

TEXT_FAMILY, CODE_FAMILY = "DejaVu Sans", "DejaVu Sans Mono"
BUNDLED = ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")  # what text is set in
CODE_FILES = ("DejaVuSansMono.ttf", "DejaVuSansMono-Bold.ttf")
REGULAR, BOLD = 400, 700  # weights, as OpenType counts them

MARKS = {"Mn", "Mc", "Me"}  # categories of what is drawn on the character before
# Surrogates and private use stand for nothing that a reader could know; controls have
# no glyph. PDF/A and PDF/UA forbid them all.
UNPRINTABLE = {"Cc", "Cs", "Co"}
BLANKS = "\t\n\r\N{LINE SEPARATOR}\N{PARAGRAPH SEPARATOR}"
# Most of all text, drawings above all, is ASCII, which the bundled font has; the letter
# before another character may bear it as a mark, so it is looked at with that.
RUNS = re.compile(
    r"(?P<plain>[\t\n\r -~]+(?![^\t\n\r -~]))|(?P<other>[\t\n\r -~]?[^\t\n\r -~]+)"
)
# Forbidden by PDF/UA; and marks that turn the direction of what comes after them,
# in which a name could hide or reverse the words beside it.
COMMANDS = "\ufeff\ufffe\uffff\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
INVISIBLE = re.compile(  # shown by no glyph, so no font needs one
    "[\u00ad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u2060-\u2065"
    "\u206a-\u206f\u3164\ufe00-\ufe0f\uffa0\U000e0000-\U000e0fff]"
)
# Han characters are drawn a little differently in each country: the script beside
# them says which; without one they are taken for simplified Chinese.
HANGUL = re.compile("[\u1100-\u11ff\uac00-\ud7af]")
KANA = re.compile("[\u3040-\u30ff]")


@dataclass(frozen=True, kw_only=True)
class Face:
    """One font of a file: a collection (.ttc) holds several."""

    family: str
    path: Path
    index: int


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A part of a text as it is printed."""

    text: str  # as it was, or code points
    family: int = 0  # place of its font among the families
    lost: str = ""  # what the code points stand for


@dataclass(frozen=True, kw_only=True)
class FontSet:
    """The fonts of a document, and how to write what they do not have."""

    # Names of the text fonts, in the order in which typst tries them.
    families: tuple[str, ...]
    # Fonts of this machine that it takes besides the bundled ones.
    faces: tuple[Face, ...]
    coverage: tuple[frozenset[int], ...]  # code points of each family

    def printable(self, text: str) -> str:
        """Write what cannot be shown as code points: 'U+8D75'."""
        return "".join(piece.text for piece in self.pieces(text))

    def drawable(self, svg: str) -> str:
        """Make the texts of a drawing printable, and name the font of each part.

        In drawings typst looks for other fonts letter by letter, which breaks letters
        with marks and takes the first country's form of a Han character.
        """
        return re.sub(
            r"(<text\b[^>]*>)(.*?)(?=</text>)|[^<]+|<",
            lambda found: (
                found[1] + self._name_fonts(found[2])
                if found[1]
                else self.printable(found[0])
            ),
            svg,
            flags=re.DOTALL,
        )

    def missing(self, text: str) -> frozenset[str]:
        """Return the characters of a text that cannot be shown."""
        return frozenset(c for piece in self.pieces(text) for c in piece.lost)

    def pieces(self, text: str) -> Iterator[Piece]:
        """Cut a text into letters with their marks, each with a font that has them.

        Code points that stand for neighbours are kept apart by a blank.
        """
        before = ""
        for found in RUNS.finditer(text):
            if found["plain"]:
                yield Piece(text=found["plain"])
                before = ""
                continue
            for cluster in clusters(found["other"]):
                for piece in self._show(cluster):
                    yield (
                        replace(piece, text=f" {piece.text}")
                        if (before and piece.lost)
                        else piece
                    )
                    before = piece.lost

    def _show(self, cluster: str) -> Iterator[Piece]:
        """Yield a character and its marks, or their code points."""
        place = 0 if _is_blank(cluster) else self._find(cluster)
        if place is not None:
            yield Piece(text=cluster, family=place)
        elif len(cluster) == 1:
            yield Piece(text=name_character(cluster), lost=cluster)
        else:
            # No one font has the letter and its marks: each by itself, but for marks
            # that only say how the letter would look.
            yield from self._show(cluster[0])
            for mark in INVISIBLE.sub("", cluster[1:]):
                yield Piece(text=name_character(mark), lost=mark)

    def _find(self, cluster: str) -> int | None:
        """Return the place of the first font with a character and all its marks."""
        if not all(map(_may_print, cluster)):
            return None
        needed = {ord(c) for c in INVISIBLE.sub("", cluster)}
        places = (k for k, covered in enumerate(self.coverage) if needed <= covered)
        return next(places, None)

    def _name_fonts(self, content: str) -> str:
        """Put what is between the tags of an SVG text into the fonts that have it."""
        parts = []
        for family, pieces in groupby(self.pieces(content), lambda piece: piece.family):
            text = "".join(piece.text for piece in pieces)
            name = self.families[family].replace("'", "")
            style = f"font-family: '{escape(name)}'"
            parts.append(f'<tspan style="{style}">{text}</tspan>' if family else text)
        return "".join(parts)


def choose_fonts(
    texts: Iterable[str], *, folders: Sequence[Path] | None = None
) -> FontSet:
    """Find fonts for all characters of a document, in these folders or the system's.

    Of the fonts that could serve, sans serif ones come first, then the order is that
    of their names, so that the same machine takes the same fonts every time.
    """
    bundled = FontSet(
        families=(TEXT_FAMILY,),
        faces=(),
        coverage=(_bundled_coverage(),),
    )
    missing = frozenset().union(*(bundled.missing(text) for text in texts))
    wanted = {ord(c) for c in missing if _may_print(c)}
    if not wanted:
        return bundled
    available = _system_faces(folders)
    regular = {
        face.family: face for face, weight in reversed(available) if weight == REGULAR
    }
    chosen: dict[str, frozenset[int]] = {}
    for family in sorted(regular, key=lambda name: _preference(name, missing)):
        covered = coverage(regular[family])
        if wanted & covered:
            chosen[family] = covered
            wanted -= covered
        if not wanted:
            break
    faces = [regular[family] for family in chosen]
    for family, covered in chosen.items():
        bold = [f for f, w in available if w == BOLD and f.family == family]
        # A bold font with fewer characters would lack some of a heading.
        faces += [face for face in bold[:1] if coverage(face) >= covered]
    return FontSet(
        families=(TEXT_FAMILY, *chosen),
        faces=tuple(faces),
        coverage=(*bundled.coverage, *chosen.values()),
    )


def name_character(character: str) -> str:
    """Return the code point of a character: 'U+8D75'."""
    return f"U+{ord(character):04X}"


def clusters(text: str) -> list[str]:
    """Cut a text into characters, each with the marks that are drawn on it."""
    found: list[str] = []
    for character in text:
        joins = category(character) in MARKS or INVISIBLE.match(character)
        if found and joins and not _is_blank(found[-1]):
            found[-1] += character
        else:
            found.append(character)
    return found


def coverage(face: Face) -> frozenset[int]:
    """Return the code points that a font has a glyph for; none if it is no font."""
    from fontTools.ttLib import TTLibError

    try:
        with _open(face) as font:
            _call_glyphs_by_number(font)
            return frozenset(font.getBestCmap() or ())
    except (TTLibError, OSError, AssertionError, KeyError):
        return frozenset()  # a broken font of the system is not the user's concern


def text_width(text: str, *, bold: bool = False) -> float:
    """Return how wide a text is in the bundled font, without breaks [em]."""
    widths = _advances(BUNDLED[bold])
    return sum(widths.get(ord(character), 1.0) for character in text)


def place_fonts(faces: Iterable[Face], folder: Path) -> None:
    """Put the bundled fonts and these into a folder, one font a file.

    A collection is taken apart: typst would also see the fonts beside the chosen one.
    """
    from shutil import copyfile

    for name in (*BUNDLED, *CODE_FILES):
        copyfile(_bundled(name), folder / name)
    for place, face in enumerate(faces):
        target = folder / f"{place}{face.path.suffix}"
        if face.path.suffix.lower() in {".ttc", ".otc"}:
            with _open(face) as font:
                font.save(target.with_suffix(".otf"), reorderTables=False)
        else:
            copyfile(face.path, target)


def _is_blank(text: str) -> bool:
    """Whether a text is one blank, or a break of a line, which is set as one."""
    return text in BLANKS or text == " "


def _may_print(character: str) -> bool:
    """Whether a character stands for something to see."""
    return category(character) not in UNPRINTABLE and character not in COMMANDS


def drawing_library() -> Any:  # noqa: ANN401 - a module
    """Import matplotlib; in a run of the command line without the user's settings.

    A variable or a file of settings, which may be of a notebook or stand in any folder,
    can end the import or make it wait or talk. It looks into the current folder first:
    for that moment it is the one of its own defaults. A program that uses this library
    keeps its settings.
    """
    found = find_spec("matplotlib")
    if is_kept() and found is not None and "matplotlib" not in sys.modules:
        os.environ.pop("MPLBACKEND", None)
        with chdir(Path(found.origin or "").parent / "mpl-data"):
            import_module("matplotlib")
    return import_module("matplotlib")


def _bundled(name: str) -> Path:
    """Return a font file that matplotlib carries."""
    return Path(drawing_library().get_data_path()) / "fonts" / "ttf" / name


@cache
def _bundled_coverage() -> frozenset[int]:
    """Return the code points that both bundled fonts have."""
    return frozenset.intersection(*(frozenset(_advances(name)) for name in BUNDLED))


@cache
def _advances(name: str) -> dict[int, float]:
    """Return the width of each character of a bundled font [em]."""
    face = Face(family=TEXT_FAMILY, path=_bundled(name), index=0)
    with _open(face) as font:
        _call_glyphs_by_number(font)
        units, metrics = font["head"].unitsPerEm, font["hmtx"].metrics
        return {
            code: metrics[glyph][0] / units
            for code, glyph in font.getBestCmap().items()
        }


def _open(face: Face) -> TTFont:
    """Open a font file; its tables are read when they are asked for."""
    from fontTools.ttLib import TTFont

    return TTFont(
        face.path,
        fontNumber=face.index,
        lazy=True,
        recalcBBoxes=False,
        recalcTimestamp=False,
    )


def _call_glyphs_by_number(font: TTFont) -> None:
    """Spare a font that is only read the names of its glyphs.

    Nothing asks for them, and they take as long to read as all the rest.
    """
    font.setGlyphOrder(list(range(font["maxp"].numGlyphs)))


def _system_faces(folders: Sequence[Path] | None) -> list[tuple[Face, int]]:
    """Return upright fonts of ordinary width with their weights, sorted."""
    import typst

    found = typst.Fonts(
        include_system_fonts=folders is None,
        include_embedded_fonts=False,
        font_paths=list(folders or ()),
    ).fonts()
    faces = [
        (
            Face(family=font.family, path=Path(font.path), index=font.index),
            font.weight,
        )
        for font in found
        if font.path
        and font.style == "normal"
        and font.stretch == 1.0
        and font.family not in {TEXT_FAMILY, CODE_FAMILY}
        and not font.family.startswith("Last Resort")  # draws boxes for everything
    ]
    return sorted(
        faces, key=lambda pair: (pair[0].family, str(pair[0].path), pair[0].index)
    )


def _preference(family: str, missing: Iterable[str]) -> tuple[bool, bool, bool, str]:
    """Return what families are sorted by: the country, then sans serif, then names."""
    text = "".join(missing)
    country = "KR" if HANGUL.search(text) else "JP" if KANA.search(text) else "SC"
    words = family.split()
    elsewhere = "CJK" in words and country not in words
    return (elsewhere, "Mono" in words, "Sans" not in words, family)
