"""Documents as the files that were asked for: HTML and PDF, by suffix."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.cli.streams import in_line, say

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from budget.report.blocks import Document

SUFFIXES = (".html", ".pdf")


def check_suffixes(paths: Sequence[Path]) -> None:
    """Refuse a kind of page that there is not, before anything is computed.

    Raises
    ------
    CallError
        A suffix is neither of SUFFIXES.
    """
    from budget.errors import CallError

    wrong = [str(path) for path in paths if path.suffix.lower() not in SUFFIXES]
    if wrong:
        raise CallError(
            f"-o {', '.join(wrong)}: the suffix decides the kind of page, "
            f"allowed: {', '.join(SUFFIXES)}"
        )


def render_pages(document: Document, paths: Sequence[Path]) -> dict[Path, str | bytes]:
    """Return the contents of the files, each kind rendered once.

    Characters that no font of this machine has are named on stderr.
    """
    from budget.report.page import render_page
    from budget.report.typeset import typeset

    files: dict[Path, str | bytes] = {}
    made: dict[str, str | bytes] = {}
    for path in paths:
        suffix = path.suffix.lower()
        if suffix not in made and suffix == ".html":
            made[suffix] = render_page(document)
        elif suffix not in made:
            found = typeset(document)
            made[suffix] = found.pdf
            if found.replaced:
                names = ", ".join(found.replaced)
                say(
                    f"warning: {in_line(path)}: no font on this machine has {names}; "
                    "the code points stand in their place. Install a font that has "
                    "them, as Noto Sans CJK has Chinese, and write the report again"
                )
        files[path] = made[suffix]
    return files
