"""Results where they are computed: a table in a notebook, figures, a written report."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from budget.errors import CallError
from budget.names import Name
from budget.report.analysis.build import report_document
from budget.report.analysis.verdict import headline
from budget.report.figures.density import density_step
from budget.report.figures.outputs import (
    overview_chart,
    utilisation_chart,
    validity_chart,
)
from budget.report.figures.rows import draw
from budget.report.figures.sources import coupling_chart, share_chart, sobol_chart
from budget.report.files import check_targets, write_all
from budget.report.rendering import check_suffixes, document_date, render_pages
from budget.report.tables import AT_LEAST, group_tables, print_coverage
from budget.results import worst_of
from budget.studies.coupling import coupling_by_law
from budget.studies.densities import critical_densities
from budget.studies.evidence import gather_evidence
from budget.studies.request import analysis_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from matplotlib.figure import Figure

    from budget.report.figures.rows import Chart
    from budget.results import Budget

T = TypeVar("T")
COMMAND = "budget.report (Python)"  # in the place of a command line


def write_report(
    budget: Budget,
    files: Sequence[str | Path],
    *,
    number: str = "",
    paper: str = "a4",
) -> tuple[Path, ...]:
    """Write the report on a budget, as `budget report` does; return the files."""
    analysis = analysis_of(budget)
    paths = tuple(map(Path, files))
    check_suffixes(paths, paper)
    check_targets(paths)
    document = report_document(
        budget,
        devices=analysis.devices,
        procedure=analysis.procedure,
        evidence=gather_evidence(analysis, budget, budget.assessment),
        assessment=budget.assessment,
        command_line=COMMAND,
        date=document_date(),
        number=number,
    )
    write_all(render_pages(document, paths, paper=paper, warn=_warn))
    return paths


def _warn(path: Path, text: str) -> None:
    """Say what a page lacks."""
    warnings.warn(f"{path}: {text}", stacklevel=4)


def budget_html(budget: Budget) -> str:
    """Return a small table: of each group the output that is known least.

    Its texts may come from anywhere: all are escaped. It loads nothing.
    """
    heads, *rows = _lines(budget, widest=True)
    said = [] if budget.assessment is None else [headline(budget, budget.assessment)]
    said += [f"Warning: {text}" for text in budget.warnings]
    return (
        f"<table><caption>{escape(budget.title)}, {escape(budget.settings.reference)}"
        "</caption><thead><tr>"
        + "".join(f"<th>{escape(head)}</th>" for head in heads)
        + "</tr></thead><tbody>"
        + "".join(
            "<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>"
            for row in rows
        )
        + "</tbody></table>"
        + "".join(f"<p>{escape(text)}</p>" for text in said)
    )


def _lines(budget: Budget, *, widest: bool = False) -> Iterator[tuple[str, ...]]:
    """Yield the heads of a budget table, then its rows, rounded as on every page."""
    coverage = print_coverage(budget.settings.coverage)
    yield (
        "parameter",
        "axis",
        "mean",
        "u",
        f"U ({coverage} %)",
        "unit",
        "contributions",
    )
    for group in group_tables(budget):
        for row in [group.widest] if widest else group.rows:
            numbers = (row.mean.text, row.u.text, row.expanded.text)
            yield (group.title, row.axis, *numbers, group.unit, group.contributions)


def budget_markdown(budget: Budget) -> str:
    """Write a row for each output as a pipe table."""
    heads, *rows = (
        [re.sub(r"([\\|<>*_`])", r"\\\1", text) for text in line]
        for line in _lines(budget)
    )
    rule = ["---"] * len(heads)
    return "".join(f"| {' | '.join(line)} |\n" for line in (heads, rule, *rows))


LATEX = {
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "|": r"\textbar{}",
    "<": "$<$",
    ">": "$>$",
    AT_LEAST: r"$\geq$",
    "\N{MINUS SIGN}": "$-$",
}


def budget_latex(budget: Budget) -> str:
    """Write a row for each output as a tabular, which needs no package."""
    heads, *rows = (
        " & ".join("".join(LATEX.get(sign, sign) for sign in text) for text in line)
        for line in _lines(budget)
    )
    body = "".join(f"{line} \\\\\n" for line in rows)
    return (
        f"\\begin{{tabular}}{{llrrrll}}\n\\hline\n{heads} \\\\\n\\hline\n{body}"
        "\\hline\n\\end{tabular}\n"
    )


@dataclass(frozen=True)
class Plots:
    """The figures of the report on a budget, each a matplotlib Figure."""

    budget: Budget

    def overview(self) -> Figure:
        """Show U of every output."""
        chart = overview_chart(group_tables(self.budget))
        return _drawn(chart, "no output has a spread")

    def limits(self) -> Figure:
        """Show how much of its limit every required output uses."""
        assessment = self.budget.assessment
        if assessment is None:
            raise CallError(
                "the budget was not held against limits; give requirement= to analyze"
            )
        return draw(utilisation_chart(assessment))

    def contributions(self, group: str = "") -> Figure:
        """Show what contributes to each output of a group, 'gyro.bias'.

        Without a name it is the group that uses most of its limit or, where nothing is
        required, the first.
        """
        groups = group_tables(self.budget)
        tables = {str(Name(g.parameter, owner=g.sensor)): g for g in groups}
        assessment = self.budget.assessment
        if not group and assessment is not None and assessment.outputs:
            group = str(worst_of(assessment.outputs).output.name.group)
        return draw(share_chart(_choice(tables, group or next(iter(tables)))))

    def coupling(self, sensor: str = "") -> Figure:
        """Show which source reaches which parameters of a sensor, the first without."""
        sensor = self._sensor(sensor)
        analysis = analysis_of(self.budget)
        table = coupling_by_law(
            analysis.problem, analysis.law, analysis.procedure.formulas
        )
        return _drawn(coupling_chart(table, sensor), f"no source reaches the {sensor}")

    def validation(self, sensor: str = "") -> Figure:
        """Show the law against Monte Carlo, of a sensor, the first without."""
        why = "the law was not validated; analyze with validate=True and method='gum'"
        return _drawn(validity_chart(self.budget, self._sensor(sensor)), why)

    def indices(self, sensor: str = "") -> Figure:
        """Show Sobol' indices, of a sensor, the first without."""
        why = "there are no Sobol' indices; analyze with samples=2048"
        return _drawn(sobol_chart(self.budget, self._sensor(sensor)), why)

    def density(self, output: str = "") -> Figure:
        """Show how the error of a critical output is distributed, the first without.

        Of each group that is the output that uses most of its limit or, where nothing
        is required, has the largest spread.
        """
        budget = self.budget
        found = {
            str(one.output.name): one
            for one in critical_densities(
                analysis_of(budget), budget, budget.assessment
            )
        }
        density = _choice(found, output or next(iter(found), ""))
        return density_step(density, coverage=budget.settings.coverage)

    def _sensor(self, sensor: str) -> str:
        """Return the sensor that is asked for, the first of the budget without."""
        there = {row.sensor: row.sensor for row in self.budget.outputs}
        return _choice(there, sensor or next(iter(there)))


def _choice(known: Mapping[str, T], name: str) -> T:
    """Return what is called so.

    Raises
    ------
    CallError
        Nothing is.
    """
    if name not in known:
        there = ", ".join(known) or "nothing"
        raise CallError(f"found {name!r}, this budget can show: {there}")
    return known[name]


def _drawn(chart: Chart | None, why: str) -> Figure:
    """Draw a figure; say why there is none."""
    if chart is None:
        raise CallError(f"nothing to draw: {why}")
    return draw(chart)
