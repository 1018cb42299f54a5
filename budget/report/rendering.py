"""Documents as files: which kinds of page there are, what is in them, their date."""

from __future__ import annotations

import os
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from budget.errors import CallError
from budget.inputs.tree import describe

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from budget.report.blocks import Document

SUFFIXES = (".html", ".pdf")
PAPERS = ("a4", "letter")  # the first is the default


def check_suffixes(paths: Sequence[Path], paper: str) -> None:
    """Refuse a kind of page that there is not, before anything is computed.

    Raises
    ------
    CallError
        A suffix is neither of SUFFIXES, a paper none of those of a PDF, or one is
        chosen where no PDF is written.
    """
    if paper not in PAPERS:
        raise CallError(f"found paper {paper!r}, allowed: {', '.join(PAPERS)}")
    wrong = [str(path) for path in paths if path.suffix.lower() not in SUFFIXES]
    if wrong:
        raise CallError(
            f"-o {', '.join(wrong)}: the suffix decides the kind of page, "
            f"allowed: {', '.join(SUFFIXES)}"
        )
    if paper != PAPERS[0] and not any(path.suffix.lower() == ".pdf" for path in paths):
        raise CallError(
            f"--paper {paper}: only a PDF has sheets of its own (a browser prints an "
            "HTML page on those that it is given); add -o FILE.pdf, or leave it out"
        )


def render_pages(
    document: Document,
    paths: Sequence[Path],
    *,
    paper: str,
    warn: Callable[[Path, str], None],
) -> dict[Path, str | bytes]:
    """Return the contents of the files, each kind rendered once.

    `warn` is told of characters that no font of this machine has.
    """
    from budget.language import speaking
    from budget.report.page import render_page
    from budget.report.pages import sections
    from budget.report.typeset import typeset

    with speaking(document.language):
        further = sections("further", document=document)
    document = replace(document, sections=(*document.sections, *further))
    files: dict[Path, str | bytes] = {}
    made: dict[str, str | bytes] = {}
    for path in paths:
        suffix = path.suffix.lower()
        if suffix not in made and suffix == ".html":
            made[suffix] = render_page(document)
        elif suffix not in made:
            found = typeset(document, paper=paper)
            made[suffix] = found.pdf
            if found.replaced:
                names = ", ".join(found.replaced)
                warn(
                    path,
                    f"no font on this machine has {names}; "
                    "the code points stand in their place. Install a font that has "
                    "them, as Noto Sans CJK has Chinese, and write the report again",
                )
        files[path] = made[suffix]
    return files


def document_date() -> str:
    """Return today's date, or that of SOURCE_DATE_EPOCH where it is set."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch is None:
        return datetime.now().astimezone().date().isoformat()
    try:
        return datetime.fromtimestamp(int(epoch), tz=UTC).date().isoformat()
    except (ValueError, OverflowError, OSError):
        raise CallError(
            f"SOURCE_DATE_EPOCH is {describe(epoch)}, expected seconds since 1970 as a "
            "whole number; unset it to use today's date"
        ) from None
