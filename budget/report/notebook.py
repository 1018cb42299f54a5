"""Results where they are computed: a table in a notebook, figures, a written report."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from datetime import datetime
from functools import wraps
from html import escape
from importlib.util import find_spec
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

from budget.calibration.mission import SEEN
from budget.errors import CallError
from budget.language import ENGLISH, speaking
from budget.model.sources import SENSORS
from budget.names import LENGTHS, Name
from budget.report.analysis.build import report_document
from budget.report.analysis.mission import way_with_errors
from budget.report.analysis.verdict import headline
from budget.report.blocks import Cell
from budget.report.comparison.document import to_csv as comparison_csv
from budget.report.document import table_csv
from budget.report.export import write_export
from budget.report.figures.allan import Allan, draw_allan
from budget.report.figures.attitudes import Positions, draw_positions
from budget.report.figures.contributions import (
    Critical,
    correlation_chart,
    tornado_chart,
    waterfall_chart,
)
from budget.report.figures.density import density_step
from budget.report.figures.growth import Growth, draw_growth
from budget.report.figures.outputs import (
    overview_chart,
    utilisation_chart,
    validity_chart,
)
from budget.report.figures.rows import draw
from budget.report.figures.sources import (
    coupling_chart,
    group_shares_chart,
    share_chart,
    sobol_chart,
)
from budget.report.figures.style import headed
from budget.report.figures.timeline import schedule_chart
from budget.report.figures.track import draw_track
from budget.report.files import check_targets, write_all
from budget.report.pages import blocks, line
from budget.report.rendering import check_suffixes, document_date, render_pages
from budget.report.tables import AT_LEAST, group_tables
from budget.results import COLUMNS, worst_of
from budget.studies.allocation.records import Allocation
from budget.studies.comparison.records import Comparison
from budget.studies.coupling import coupling_by_law
from budget.studies.densities import critical_densities
from budget.studies.evidence import gather_evidence
from budget.studies.export.study import Export
from budget.studies.mission import curve, drawn_times
from budget.studies.request import analysis_of
from budget.studies.stations import Qualification

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    import pandas as pd
    from matplotlib.figure import Figure

    from budget.report.figures.rows import Chart
    from budget.report.tables import GroupTable
    from budget.results import Budget, Tabled
    from budget.studies.mission import Curve

T = TypeVar("T")
COMMAND = "budget.report (Python)"  # in the place of a command line


def write_report(
    budget: Budget,
    files: Sequence[str | Path],
    *,
    number: str = "",
    paper: str = "a4",
    language: str = ENGLISH,
) -> tuple[Path, ...]:
    """Write the report on a budget, as `budget report` does; return the files."""
    analysis = analysis_of(budget)
    if not files:
        raise CallError("no file to write to; give one or more, as 'report.html'")
    paths = tuple(map(Path, files))
    check_suffixes(paths, paper)
    check_targets(paths)
    with speaking(language):
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
    heads, *rows = _texts(budget, widest=True)
    said = [] if budget.assessment is None else [headline(budget, budget.assessment)]
    said += [line("notebook", "warning", text=text) for text in budget.warnings]
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


def _lines(budget: Budget, *, widest: bool = False) -> list[tuple[Cell, ...]]:
    """Return the heads of a budget table, then its rows, rounded as on every page."""
    table: Any = blocks(
        "notebook",
        "outputs",
        groups=group_tables(budget),
        coverage=budget.settings.coverage,
        widest=widest,
    )[0]
    heads = tuple(Cell(text=column.head) for column in table.columns)
    return [heads, *(row for group in table.groups for row in group.rows)]


def _texts(budget: Budget, *, widest: bool = False) -> list[tuple[str, ...]]:
    """Return the same as texts."""
    rows = _lines(budget, widest=widest)
    return [tuple(cell.text for cell in row) for row in rows]


def budget_markdown(budget: Budget) -> str:
    """Write a row for each output as a pipe table."""
    heads, *rows = (
        [re.sub(r"([\\|<>*_`])", r"\\\1", text) for text in line]
        for line in _texts(budget)
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
        for line in _texts(budget)
    )
    body = "".join(f"{line} \\\\\n" for line in rows)
    return (
        f"\\begin{{tabular}}{{llrrrll}}\n\\hline\n{heads} \\\\\n\\hline\n{body}"
        "\\hline\n\\end{tabular}\n"
    )


def export_text(found: Export) -> str:
    """Return the file that the target of an export reads."""
    return write_export(found)


def study_frame(found: Tabled) -> pd.DataFrame:
    """Return the CSV document of a study as a pandas frame; empty cells are missing."""
    import pandas as pd

    write: dict[type, Callable[[Any], str]] = {
        Comparison: comparison_csv,
        Allocation: lambda one: table_csv("allotment", one.sources),
        Qualification: lambda one: table_csv("station_figure", one.figures),
        Export: lambda one: table_csv("exported", one.rows),
    }
    text = StringIO(write[type(found)](found))
    return pd.read_csv(text, keep_default_na=False, na_values=[""])


XLSX = ".xlsx"
WIDEST = 60  # characters of a column


def write_xlsx(budget: Budget, file: str | Path) -> Path:
    """Write a workbook: a row for each output, contributions, what it stands on.

    Numbers are numbers at full precision, shown with the digits of the report; texts
    are texts, also those that look like formulas. The same budget gives the same bytes
    under one SOURCE_DATE_EPOCH.
    """
    if find_spec("xlsxwriter") is None:
        raise CallError(
            "a workbook needs the extra 'xlsx': pip install 'sins-budget[xlsx]'"
        )
    from xlsxwriter import Workbook

    path = Path(file)
    if path.suffix.lower() != XLSX:
        raise CallError(f"{file}: expected a name that ends in {XLSX}")
    check_targets([path])
    content = BytesIO()
    book = Workbook(content, {"in_memory": True})
    day = datetime.fromisoformat(document_date())
    book.set_properties({"title": budget.title, "created": day})
    for name, rows in _sheets(budget):
        sheet, bold = book.add_worksheet(name), book.add_format({"bold": True})
        widths: dict[int, int] = {}
        for i, row in enumerate(rows):
            for j, cell in enumerate(row):
                shown = cell.text if isinstance(cell, Cell) else str(cell)
                widths[j] = max(widths.get(j, 0), min(len(shown), WIDEST))
                if isinstance(cell, Cell) and cell.exact is not None:
                    look = book.add_format({"num_format": _shown_as(cell.text)})
                    sheet.write_number(i, j, cell.exact, look)
                elif isinstance(cell, float):
                    sheet.write_number(i, j, cell)
                elif cell is not None:
                    sheet.write_string(i, j, shown, None if i else bold)
        for j, width in widths.items():
            sheet.set_column(j, j, width + 1)
        sheet.freeze_panes(1, 0)
    book.close()
    write_all({path: content.getvalue()})
    return path


def _shown_as(text: str) -> str:
    """Return the format of a spreadsheet that shows a number with these digits."""
    decimals = re.search(r"\.\d+", text)
    shape = f"0{re.sub('[0-9]', '0', decimals[0])}" if decimals else "0"
    return f"{shape}E+00" if "e" in text else shape


def _sheets(budget: Budget) -> Iterator[tuple[str, list[Sequence[object]]]]:
    """Yield the sheets of a workbook by their names, each with its heads first."""
    heads, *rows = _lines(budget)
    yield "Budget", [heads, *rows]
    flat = [[row[name] for name in COLUMNS] for row in budget.rows()]
    yield "Contributions", [COLUMNS, *flat]
    settings = budget.settings.to_dict()
    notes = [
        *(
            ("input", f"{one.role}: {one.name}, SHA-256 {one.sha256}")
            for one in budget.inputs
        ),
        *((key, str(value)) for key, value in settings.items() if value is not None),
        *(("assumed", text) for text in budget.assumptions),
        *(("not given", str(name)) for name in budget.not_given),
        *(("warning", text) for text in budget.warnings),
    ]
    if budget.assessment is not None:
        notes.insert(0, ("verdict", headline(budget, budget.assessment)))
    yield "Notes", [("", budget.title), *notes]


P = ParamSpec("P")


def _headed(
    drawn: Callable[Concatenate[Plots, P], Figure],
) -> Callable[Concatenate[Plots, P], Figure]:
    """Give a figure that stands alone its finding, and what it is of."""

    @wraps(drawn)
    def made(self: Plots, /, *args: P.args, **options: P.kwargs) -> Figure:
        return headed(drawn(self, *args, **options), self.budget.title)

    return made


@dataclass(frozen=True)
class Plots:
    """The figures of the report on a budget, each a matplotlib Figure."""

    budget: Budget

    @_headed
    def overview(self) -> Figure:
        """Show U of every output."""
        chart = overview_chart(group_tables(self.budget))
        return _drawn(chart, "no output has a spread")

    @_headed
    def limits(self) -> Figure:
        """Show how much of its limit every required output uses."""
        assessment = self.budget.assessment
        if assessment is None:
            raise CallError(
                "the budget was not held against limits; give requirement= to analyze"
            )
        return draw(utilisation_chart(assessment))

    @_headed
    def contributions(self, group: str = "") -> Figure:
        """Show what contributes to each output of a group, 'gyro.bias'.

        Without a name it is the group that uses most of its limit or, where nothing is
        required, the first.
        """
        return draw(share_chart(self._group(group)))

    @_headed
    def shares(self) -> Figure:
        """Show what the variance of each group of outputs is made of."""
        chart = group_shares_chart(self.budget)
        return _drawn(chart, "it has no two groups of outputs with a spread")

    @_headed
    def tornado(self, group: str = "") -> Figure:
        """Show how far each source alone moves the critical output of a group."""
        chart = tornado_chart(self._critical(group))
        return _drawn(chart, "no two sources move that output")

    @_headed
    def waterfall(self, group: str = "") -> Figure:
        """Show how the sources add up to U of the critical output of a group."""
        chart = waterfall_chart(self._critical(group))
        return _drawn(chart, "no two sources move that output")

    @_headed
    def correlation(self) -> Figure:
        """Show the correlation of all outputs that have one."""
        return _drawn(correlation_chart(self.budget), "no two outputs are correlated")

    @_headed
    def coupling(self, sensor: str = "") -> Figure:
        """Show which source reaches which parameters of a sensor, the first without."""
        sensor = self._sensor(sensor)
        analysis = analysis_of(self.budget)
        table = coupling_by_law(
            analysis.problem, analysis.law, analysis.procedure.formulas
        )
        return _drawn(coupling_chart(table, sensor), f"no source reaches the {sensor}")

    @_headed
    def schedule(self) -> Figure:
        """Show turns and dwells of the test, to scale."""
        there = list(dict.fromkeys(row.sensor for row in self.budget.outputs))
        sensors = [kind for kind in SENSORS if kind in there]
        chart = schedule_chart(analysis_of(self.budget).procedure, sensors)
        return _drawn(chart, "the test has no windows")

    @_headed
    def positions(self) -> Figure:
        """Show the positions of the calibration: which axis is up, and which turns."""
        analysis = analysis_of(self.budget)
        kinds = [sensor.kind for sensor in analysis.sensors]
        found = Positions.of(analysis.procedure, kinds)
        return draw_positions(_found(found, "the calibration has no positions"))

    @_headed
    def allan(self, sensor: str = "") -> Figure:
        """Show the noise of a sensor's data sheet by averaging time, the first without.

        With the windows that the calibration averages.
        """
        analysis = analysis_of(self.budget)
        triads = {one.kind: one for one in analysis.sensors}
        triad = _choice(triads, sensor or next(iter(triads)))
        found = Allan.of(triad, analysis.procedure)
        return draw_allan(_found(found, f"no line of the {triad.kind} is noise"))

    @_headed
    def growth(self, error: str = "position.horizontal") -> Figure:
        """Show an error of a mission over time, its limits, and what makes it when.

        'position.horizontal', 'velocity.down', 'attitude.heading'.
        """
        known = {
            str(Name(quantity, axis=axis)): (quantity, axis)
            for quantity, axis in (*LENGTHS.items(), *SEEN)
        }
        found = Growth.of(self._curve(), _choice(known, error))
        judged = self.budget.assessment
        limits = () if judged is None else judged.outputs
        return draw_growth(_found(found, "nothing moves that error"), limits)

    @_headed
    def track(self) -> Figure:
        """Show the track of a mission from above, with ellipses of its errors."""
        found = way_with_errors(self.budget, self._curve())
        why = "the position has no covariance at the times that are asked for"
        return draw_track(_found(found, why))

    def _curve(self) -> Curve:
        """Return how the errors of a mission grow."""
        analysis = analysis_of(self.budget)
        if analysis.journey is None:
            raise CallError("the budget is of no mission; give mission= to analyze")
        asked = sorted({row.output.name.time or 0.0 for row in self.budget.outputs})
        return curve(analysis, drawn_times(analysis.journey, asked))

    @_headed
    def validation(self, sensor: str = "") -> Figure:
        """Show the law against Monte Carlo, of a sensor, the first without."""
        why = "the law was not validated; analyze with validate=True and method='gum'"
        return _drawn(validity_chart(self.budget, self._sensor(sensor)), why)

    @_headed
    def indices(self, sensor: str = "") -> Figure:
        """Show Sobol' indices, of a sensor, the first without."""
        why = "there are no Sobol' indices; analyze with samples=2048"
        return _drawn(sobol_chart(self.budget, self._sensor(sensor)), why)

    @_headed
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

    def _group(self, group: str) -> GroupTable:
        """Return the group of that name; see `contributions` for which without."""
        groups = group_tables(self.budget)
        tables = {str(Name(g.parameter, owner=g.sensor)): g for g in groups}
        assessment = self.budget.assessment
        if not group and assessment is not None and assessment.outputs:
            group = str(worst_of(assessment.outputs).output.name.group)
        return _choice(tables, group or next(iter(tables)))

    def _critical(self, group: str) -> Critical:
        """Return the output of a group that uses most of its limit, or is widest."""
        return Critical.of(self._group(group), self.budget.assessment)

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
    return draw(_found(chart, why))


def _found(one: T | None, why: str) -> T:
    """Return what is to be drawn; say why there is nothing."""
    if one is None:
        raise CallError(f"nothing to draw: {why}")
    return one
