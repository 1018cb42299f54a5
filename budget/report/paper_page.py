"""The paper beside ours as one HTML page; the words are in the template."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.curves import sweep_alt, sweep_curves, sweep_title
from budget.report.inline import inline_svg
from budget.report.markup import (
    css_string,
    markup,
    number_markup,
    page_environment,
    script_safe,
)
from budget.report.paper import (
    paper_json,
    print_ours,
    print_probability,
    print_ratio,
    shorten,
    unexplained,
)
from budget.studies.paper.findings import UNEXPLAINED, VERDICTS
from budget.studies.paper.study import ASSUMPTIONS, SECTIONS, TITLE
from budget.version import __version__

if TYPE_CHECKING:
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy
    from budget.studies.paper.sweeps import Sweep

# A number, or the root mean square of several.
NUMBER = re.compile(r"(rms |)(-?[0-9.]+(?:e-?[0-9]+)?)( about -1|)")


@dataclass(frozen=True, kw_only=True)
class PageRow:
    """One finding as text."""

    where: str
    printed: str
    ours: str
    exact: str  # for the tooltip
    quantity: str
    ratio: str
    p_single: str
    p_mean: str
    verdict: str
    why: str
    is_summary: bool
    is_open: bool


@dataclass(frozen=True, kw_only=True)
class PageSection:
    """One section of the page."""

    title: str
    rows: tuple[PageRow, ...]
    has_ratios: bool
    has_probabilities: bool


def paper_html(study: PaperStudy) -> str:
    """Write the whole study as one page that needs nothing else.

    Parameters
    ----------
    study : PaperStudy

    Returns
    -------
    str
        The same bytes for the same study.
    """
    environment = page_environment()
    environment.filters["number"] = lambda text: (
        markup(f"{number[1]}{number_markup(number[2])}{number[3]}")
        if (number := NUMBER.fullmatch(text))
        else text
    )
    return environment.get_template("paper.html.j2").render(
        title=TITLE,
        total=sum(number for _, number in study.counts),
        counts=study.counts,
        verdicts=VERDICTS,
        unexplained=[(row.where, page_row(row)) for row in unexplained(study)],
        sections=[(name, page_section(study, name)) for name in SECTIONS],
        pictures=[(sweep_title(sweep), markup(_draw(sweep))) for sweep in study.sweeps],
        assumptions=ASSUMPTIONS,
        inputs=study.inputs,
        version=__version__,
        document=markup(script_safe(paper_json(study))),
        css_string=lambda text: markup(css_string(text)),
    )


def page_section(study: PaperStudy, name: str) -> PageSection:
    """Write the rows of one section."""
    rows = study.of_section(name)
    return PageSection(
        title=SECTIONS[name],
        rows=tuple(page_row(row) for row in rows),
        has_ratios=any(row.ratio is not None for row in rows),
        has_probabilities=any(
            row.p_single is not None or row.p_mean is not None for row in rows
        ),
    )


def page_row(row: Finding) -> PageRow:
    """Write one finding."""
    return PageRow(
        where=shorten(row),
        printed=row.printed,
        ours=print_ours(row),
        exact=str(row.ours),
        quantity=row.quantity,
        ratio=print_ratio(row.ratio),
        p_single=print_probability(row.p_single),
        p_mean=print_probability(row.p_mean),
        verdict=row.verdict,
        why="" if row.why.startswith("judged with") else row.why,
        is_summary=row.is_summary and row.section == "table 1",
        is_open=row.verdict == UNEXPLAINED,
    )


def _draw(sweep: Sweep) -> str:
    """Draw one of the paper's figures for the page."""
    name = sweep.figure.replace(" ", "-")
    return inline_svg(sweep_curves(sweep), name, sweep_alt(sweep))
