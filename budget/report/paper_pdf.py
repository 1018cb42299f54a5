"""The paper beside ours as PDF; the words are in the template."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from budget.report import figures
from budget.report.curves import sweep_alt, sweep_curves, sweep_title
from budget.report.paper import unexplained
from budget.report.paper_page import page_row, page_section
from budget.report.pdf import render_pdf
from budget.studies.paper.findings import VERDICTS
from budget.studies.paper.study import ASSUMPTIONS, SECTIONS, TITLE
from budget.version import __version__

if TYPE_CHECKING:
    from budget.studies.paper.study import PaperStudy
    from budget.studies.paper.sweeps import Sweep


def paper_pdf(study: PaperStudy, *, date: str) -> bytes:
    """Write the whole study as a PDF.

    Parameters
    ----------
    study : PaperStudy
    date : str
        That the document bears, year-month-day.

    Returns
    -------
    bytes
        The same for the same study and date.
    """
    data = {
        "title": TITLE,
        "date": date,
        "version": __version__,
        "total": sum(number for _, number in study.counts),
        "counts": [
            {"word": word, "number": number, "meaning": VERDICTS[word]}
            for word, number in study.counts
        ],
        "unexplained": [
            {**asdict(page_row(row)), "where": row.where} for row in unexplained(study)
        ],
        "assumptions": ASSUMPTIONS,
        "sections": [
            {"name": name, **asdict(page_section(study, name))} for name in SECTIONS
        ],
        "pictures": [
            {
                "file": _file(sweep),
                "title": sweep_title(sweep),
                "alt": sweep_alt(sweep),
            }
            for sweep in study.sweeps
        ],
        "inputs": [
            {"role": file.role, "name": file.name, "sha256": file.sha256}
            for file in study.inputs
        ],
    }
    images = {
        _file(sweep): figures.to_svg(sweep_curves(sweep), name=_name(sweep)).encode()
        for sweep in study.sweeps
    }
    return render_pdf("paper.typ", data, images, date=date)


def _file(sweep: Sweep) -> str:
    """Name the file of a figure."""
    return f"{_name(sweep)}.svg"


def _name(sweep: Sweep) -> str:
    """Name a figure in one word."""
    return sweep.figure.replace(" ", "-")
