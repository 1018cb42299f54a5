"""Results as text, pictures and pages: formats only, computes nothing.

Called, it writes a report: `budget.report(result, "report.html")`.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from budget.results import Budget


def report(
    budget: Budget,
    *files: str | Path,
    number: str = "",
    paper: str = "a4",
    language: str = "en",
) -> tuple[Path, ...]:
    """Write the report on a budget: verdict first, then what it stands on.

    Parameters
    ----------
    budget : Budget
        What `analyze` returns, held against a requirement if it was given one.
    *files : str or Path
        Where to, .html or .pdf.
    number : str
        Of the report, for the one who files it.
    paper : str
        Sheets of a PDF: 'a4' or 'letter'.
    language : str
        'en' or 'zh'.

    Returns
    -------
    tuple of Path
        The files that were written.

    Raises
    ------
    CallError
        It is no budget of `analyze`, a file has another suffix, or there is no such
        paper or language.
    OutputError
        A file cannot be written.
    """
    from budget.report.notebook import write_report

    return write_report(budget, files, number=number, paper=paper, language=language)


class _Callable(ModuleType):
    """The package as the function of its name, which its name in `budget` hides."""

    def __call__(
        self,
        budget: Budget,
        *files: str | Path,
        number: str = "",
        paper: str = "a4",
        language: str = "en",
    ) -> tuple[Path, ...]:
        """Write a report."""
        return report(budget, *files, number=number, paper=paper, language=language)


sys.modules[__name__].__class__ = _Callable
