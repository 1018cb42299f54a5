"""Pages as PDF: a typst template and its data in, the bytes of the file out.

The data reach the template as JSON and are never pasted into its source, so nothing
in them can be markup. Fonts are those that typst and matplotlib carry, and of the
system only those that are named (`budget.report.fonts`): the same pages on any machine.
"""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from budget.errors import OutputError
from budget.report.fonts import place_fonts
from budget.resources import shipped

if TYPE_CHECKING:
    from collections.abc import Mapping

    from typst import PDFStandard, TypstWarning

    from budget.report.fonts import Face

# To keep, and to be read aloud: tagged, with alternative texts and a language.
STANDARDS: list[PDFStandard] = ["a-2a", "ua-1"]


def render_pdf(
    template: str,
    data: Mapping[str, Any],
    images: Mapping[str, bytes],
    *,
    date: str,
    faces: tuple[Face, ...] = (),
) -> bytes:
    """Set a document with typst.

    Parameters
    ----------
    template : str
        Name of a file in the folder `templates`. It finds its data in `data.json` and
        its images in `images/`.
    data : mapping
        What JSON can hold.
    images : mapping of str to bytes
        Files by name, SVG or PNG; `data` says where they go and has words for them.
    date : str
        Of the document, year-month-day; nothing else in the file tells the time.
    faces : tuple of Face
        Fonts besides the bundled ones.

    Returns
    -------
    bytes
        PDF/A-2a and PDF/UA-1; the same bytes for the same arguments.

    Raises
    ------
    OutputError
        The template is not there, or typst refuses it, the data or an image.
    """
    source = _read_template(template)
    try:
        with TemporaryDirectory(prefix="budget-") as folder:
            root = Path(folder)
            (root / "main.typ").write_bytes(source)
            (root / "data.json").write_text(
                json.dumps(data, allow_nan=False), encoding="utf-8"
            )
            (root / "fonts").mkdir()
            place_fonts(faces, root / "fonts")
            (root / "images").mkdir()
            for name, content in images.items():
                (root / "images" / name).write_bytes(content)
            pdf, doubts = _compile(root, template, date)
    except OSError as error:
        raise OutputError(
            f"{template}: cannot prepare the PDF in the folder for temporary files "
            f"({error.strerror}), expected one with room for 30 MB; set TMPDIR to such "
            "a folder, or write .html instead"
        ) from error
    for doubt in doubts:
        warnings.warn(f"{template}: typst says: {doubt.message}", stacklevel=2)
    return pdf


def _compile(root: Path, template: str, date: str) -> tuple[bytes, list[TypstWarning]]:
    """Run typst in a folder; return the file and what typst has doubts about."""
    from datetime import UTC, datetime

    import typst

    try:
        return typst.compile_with_warnings(
            root / "main.typ",
            root=root,
            font_paths=[root / "fonts"],
            ignore_system_fonts=True,
            format="pdf",
            pdf_standards=STANDARDS,
            timestamp=datetime.fromisoformat(date).replace(tzinfo=UTC),
        )
    except typst.TypstError as error:
        hints = "".join(f" ({hint})" for hint in error.hints)
        raise OutputError(
            f"{template}: typst says: {error.message}{hints}; expected a template "
            "and data that make a PDF; write .html instead, and report this"
        ) from error


def _read_template(name: str) -> bytes:
    """Read a template; an installation may have lost one."""
    path = shipped("templates") / name
    try:
        return path.read_bytes()
    except OSError as error:
        raise OutputError(
            f"{path}: cannot read this template ({error.strerror}); it comes with the "
            "program: install that again, or write .html instead"
        ) from error
