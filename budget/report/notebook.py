"""Results in a notebook and at a prompt: tables, figures, a written report."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from datetime import datetime
from functools import wraps
from html import escape
from importlib.util import find_spec
from io import BytesIO, StringIO
from itertools import repeat
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

from budget.calibration.mission import SEEN
from budget.errors import CallError
from budget.inputs.records import Device
from budget.known import AT_LEAST
from budget.language import ENGLISH, speaking
from budget.model.sources import SENSORS
from budget.names import HORIZONTAL, LENGTHS, Name
from budget.question import question_of
from budget.report.analysis.build import report_document
from budget.report.analysis.mission import way_with_errors
from budget.report.analysis.verdict import headline
from budget.report.blocks import Cell, Pairs, Paragraph, Run, Table
from budget.report.comparison.tables import to_csv as comparison_csv
from budget.report.document import table_csv
from budget.report.export import write_export
from budget.report.figures.allan import Allan, allan_plot
from budget.report.figures.attitudes import Positions, positions_plot
from budget.report.figures.contributions import (
    Critical,
    correlation_chart,
    tornado_chart,
    waterfall_chart,
)
from budget.report.figures.density import density_plot
from budget.report.figures.growth import ErrorGrowth, growth_plot
from budget.report.figures.outputs import (
    overview_chart,
    utilisation_chart,
    validity_chart,
)
from budget.report.figures.rows import Chart, draw
from budget.report.figures.sources import (
    coupling_chart,
    group_shares_chart,
    share_chart,
    sobol_chart,
)
from budget.report.figures.style import headed
from budget.report.figures.timeline import schedule_chart
from budget.report.figures.track import track_plot
from budget.report.files import check_targets, write_all
from budget.report.pages import blocks
from budget.report.rendering import check_suffixes, document_date, render_pages
from budget.report.tables import group_tables, output_row
from budget.report.terminal import TerminalPage, print_blocks
from budget.results import CEP, COLUMNS, R95, Budget, OutputBudget, worst_of
from budget.studies.allocation.records import Allocation
from budget.studies.comparison.records import Comparison
from budget.studies.decide import Decision, offers_of
from budget.studies.densities import critical_densities
from budget.studies.evidence import coupling, gather_evidence
from budget.studies.export.study import Export
from budget.studies.mission import Curve, curve, drawn_times
from budget.studies.stations import Qualification
from budget.ties import first_largest
from budget.units import si_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    import pandas as pd
    from matplotlib.figure import Figure

    from budget.documents import Shown
    from budget.report.blocks import Block, Words
    from budget.report.figures.tabled import Plot
    from budget.report.figures.track import Way
    from budget.report.tables import GroupTable, OutputRow
    from budget.results import JudgedOutput, Study

T = TypeVar("T")
P = ParamSpec("P")
MOST = 10  # rows of a small table
WARNINGS = 2  # below it, of a prompt
LEAST_WIDTH, MOST_WIDTH = 60, 100  # of a prompt [columns]
ALIGNED = {"text": "left", "number": "right", "unit": "center"}
FAR = ("position", LENGTHS["position"])
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
    question = question_of(budget)
    if not files:
        raise CallError("no file to write to; give one or more, as 'report.html'")
    paths = tuple(map(Path, files))
    check_suffixes(paths, paper)
    check_targets(paths)
    with speaking(language):
        document = report_document(
            budget,
            devices=question.devices,
            procedure=question.procedure,
            evidence=gather_evidence(question, budget, budget.assessment),
            assessment=budget.assessment,
            command_line=COMMAND,
            date=document_date(),
            number=number,
        )
    write_all(
        render_pages(
            document,
            paths,
            paper=paper,
            warn=lambda path, text: warnings.warn(f"{path}: {text}", stacklevel=4),
        )
    )
    return paths


# ---- What a prompt and a notebook print of a result ----------------------------------


def shown_text(found: Shown) -> str:
    """Return a small table of a record and how many rows it has beyond that."""
    from rich.console import Console

    text = StringIO()
    room = get_terminal_size((MOST_WIDTH, 0)).columns
    width = min(max(room, LEAST_WIDTH), MOST_WIDTH)
    console = Console(file=text, width=width, color_system=None, force_jupyter=False)
    print_blocks(_shown(found, WARNINGS), TerminalPage(console))
    return text.getvalue().rstrip()


def shown_html(found: Shown) -> str:
    """Return the same in HTML, with every warning.

    Its texts may come from anywhere: all are escaped. It loads nothing.
    """
    return "".join(map(_html, _shown(found, None)))


def _shown(found: Any, warnings: int | None) -> tuple[Block, ...]:  # noqa: ANN401 - Shown
    """Return what is printed of a record, with so many of its warnings."""
    macro, read, *more = SHOWN[type(found)]
    rows = tuple(read(found))
    view = more[0](found, rows) if more else {}
    rest = view.pop("many", len(rows)) - len(rows[:MOST])
    view |= {"found": found, "rows": rows[:MOST], "rest": rest}
    own = blocks("notebook", macro, **view)
    if not isinstance(found, Budget):
        return own
    said = found.warnings[:warnings]
    more_of = len(found.warnings) - len(said)
    verdict = found.assessment and headline(found, found.assessment)
    return (
        *own,
        *([Paragraph(words=(verdict,))] if verdict else ()),
        *blocks("notebook", "warned", warnings=said, rest=more_of),
    )


def _html(block: Block) -> str:
    """Write a block of a small table."""
    match block:
        case Table():
            head = "".join(f"<th>{escape(one.head)}</th>" for one in block.columns)
            rows = (
                "".join(
                    f'<td style="text-align: {ALIGNED[column.kind]}">'
                    f"{escape(cell.text)}</td>"
                    for column, cell in zip(block.columns, row, strict=True)
                )
                for group in block.groups
                for row in group.rows
            )
            body = "".join(f"<tr>{row}</tr>" for row in rows)
            return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        case Pairs(rows=pairs):
            return "".join(
                f"<p>{escape(term)}: {_words(words)}</p>" for term, words in pairs
            )
        case Paragraph(words=words):
            return f"<p>{_words(words)}</p>"
    raise TypeError(f"{type(block).__name__} is no part of a small table")


def _words(words: Words) -> str:
    """Write a line of a small table."""
    return "".join(
        f"<b>{escape(one.text)}</b>"
        if isinstance(one, Run) and one.strong
        else escape(one if isinstance(one, str) else getattr(one, "text", ""))
        for one in words
    )


Line = tuple["GroupTable", "OutputRow", "OutputBudget"]


def _matter(budget: Budget) -> Iterator[Line]:
    """Yield of each parameter the output that uses most of its limit, or is widest.

    Of a mission the horizontal position at all times, then what else there is at last.
    """
    limits = _limits(budget)
    lines = [
        [*zip(repeat(group), group.rows, group.outputs, strict=False)]
        for group in group_tables(budget)
    ]
    if budget.mission is None:
        for own in lines:
            judged = [limits.get(output.output.name) for _, _, output in own]
            sizes = [
                (0.0 if limit is None else limit.utilisation, output.largest_error)
                for limit, (_, _, output) in zip(judged, own, strict=True)
            ]
            by = 0 if any(judged) else 1
            yield own[first_largest([size[by] for size in sizes])]
        return
    flat = [line for own in lines for line in own]
    last = max(output.output.name.time or 0.0 for _, _, output in flat)
    names = [output.output.name for _, _, output in flat]
    far = [(name.quantity, name.axis) == FAR for name in names]
    yield from (line for line, is_far in zip(flat, far, strict=True) if is_far)
    for line, name, is_far in zip(flat, names, far, strict=True):
        if name.time == last and name.axis not in HORIZONTAL and not is_far:
            yield line


def _limits(budget: Budget) -> dict[Name, JudgedOutput]:
    """Return what is limited of a budget, by the names of outputs."""
    found = budget.assessment
    return {} if found is None else {row.output.name: row for row in found.outputs}


def _grown(found: Curve) -> list[tuple[object, ...]]:
    """Return rows of a curve at times that are spread over it evenly, the last too."""
    kept = np.unique(np.linspace(0, len(found.times) - 1, MOST).round().astype(int))
    columns = (
        *(np.array(found.times), found.radius(CEP), found.radius(R95), found.drms()),
        *(found.drms("velocity"), np.array(found.dominant, dtype=object)),
    )
    return [*zip(*(column[kept].tolist() for column in columns), strict=True)]


# What is printed of a record: the macro that prints it, its rows, and what besides.
SHOWN: dict[type, Any] = {
    Budget: (
        "budget",
        _matter,
        lambda found, _: {"limits": _limits(found), "many": len(found)},
    ),
    OutputBudget: (
        "output",
        lambda found: found.ranked,
        lambda found, _: {"own": output_row(found), "si": si_unit(found.output.unit)},
    ),
    Curve: ("growth", _grown, lambda found, _: {"many": len(found.times)}),
    Device: (
        "device",
        lambda found: [(one.kind, line) for one in found.sensors for line in one.lines],
    ),
    Comparison: ("devices", offers_of),
    Decision: ("devices", lambda found: found.offers),
    Allocation: ("allocation", lambda found: found.sources),
    Qualification: ("station", lambda found: found.figures),
    Export: ("export", lambda found: found.rows),
}


def _lines(budget: Budget) -> list[tuple[Cell, ...]]:
    """Return the heads of a budget table, then its rows, rounded as on every page."""
    table: Any = blocks(
        "notebook",
        "outputs",
        groups=group_tables(budget),
        coverage=budget.settings.coverage,
    )[0]
    heads = tuple(Cell(text=column.head) for column in table.columns)
    return [heads, *(row for group in table.groups for row in group.rows)]


def _texts(budget: Budget) -> list[tuple[str, ...]]:
    """Return the same as texts."""
    return [tuple(cell.text for cell in row) for row in _lines(budget)]


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


def study_frame(found: Study) -> pd.DataFrame:
    """Return the rows of a study as a pandas frame; empty cells are missing.

    Of a comparison and a decision those are devices, best first.
    """
    write: dict[type, Callable[[Any], str]] = {
        Comparison: lambda one: table_csv("offer", offers_of(one)),
        Decision: lambda one: table_csv("offer", one.offers),
        Allocation: lambda one: table_csv("allotment", one.sources),
        Qualification: lambda one: table_csv("station_figure", one.figures),
        Export: lambda one: table_csv("exported", one.rows),
    }
    return _read(write[type(found)](found))


def output_frame(found: Comparison) -> pd.DataFrame:
    """Return the CSV document of a comparison: each device and required output."""
    return _read("".join(comparison_csv(found)))


def _read(text: str) -> pd.DataFrame:
    """Read a table as it was written."""
    import pandas as pd

    return pd.read_csv(StringIO(text), keep_default_na=False, na_values=[""])


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


UNMOVED = "no two sources move that output"
ERRORS = (*LENGTHS.items(), *SEEN)  # of a mission: quantity and axis


def shows(
    why: str, has: Callable[[Plots], object]
) -> Callable[[Callable[P, Chart | Plot | None]], Callable[P, Figure]]:
    """Make a figure of what a method of Plots lays out.

    `why` says why there is none where it lays out nothing; `has` says of a budget
    whether there is one, without laying it out where that takes long.
    """

    def figure_of(laid_out: Callable[P, Chart | Plot | None]) -> Callable[P, Figure]:
        FIGURES[laid_out.__name__] = has

        @wraps(laid_out)
        def shown(*args: P.args, **kwargs: P.kwargs) -> Figure:
            found, own = laid_out(*args, **kwargs), args[0]
            if found is None:
                raise CallError(f"nothing to draw: {why}")
            drawn = draw(found) if isinstance(found, Chart) else found.figure
            return headed(drawn, own.budget.title)  # type: ignore[attr-defined]

        return shown

    return figure_of


FIGURES: dict[str, Callable[[Plots], object]] = {}  # those that there may be


@dataclass(frozen=True, repr=False)
class Plots:
    """The figures of the report on a budget, each a matplotlib Figure."""

    budget: Budget

    def __dir__(self) -> list[str]:
        """Return the figures that this budget has: what a notebook completes."""
        return [name for name, has in sorted(FIGURES.items()) if has(self)]

    def __repr__(self) -> str:
        """List them."""
        return f"<figures: {', '.join(dir(self))}>"

    @property
    def is_mission(self) -> bool:
        """Whether its outputs are of a mission."""
        return self.budget.mission is not None

    @property
    def varies(self) -> bool:
        """Whether any output has a spread."""
        return any(row.is_resolved for row in self.budget.outputs)

    @shows("no output has a spread", has=lambda own: own.varies)
    def overview(self) -> Chart | None:
        """Show U of every output."""
        return overview_chart(group_tables(self.budget))

    @shows(
        "the budget was not held against limits; give requirement= to analyze",
        has=lambda own: own.budget.assessment,
    )
    def limits(self) -> Chart | None:
        """Show how much of its limit every required output uses."""
        judged = self.budget.assessment
        return utilisation_chart(judged) if judged else None

    @shows("", has=lambda own: own.varies)
    def contributions(self, group: str = "") -> Chart:
        """Show what contributes to each output of a group, 'gyro.bias'.

        Without a name it is the group that uses most of its limit or, where nothing is
        required, the first.
        """
        return share_chart(self._group(group))

    @shows(
        "it has no two groups of outputs with a spread",
        has=lambda own: group_shares_chart(own.budget),
    )
    def shares(self) -> Chart | None:
        """Show what the variance of each group of outputs is made of."""
        return group_shares_chart(self.budget)

    @shows(UNMOVED, has=lambda own: tornado_chart(own.critical()))
    def tornado(self, group: str = "") -> Chart | None:
        """Show how far each source alone moves the critical output of a group."""
        return tornado_chart(self.critical(group))

    @shows(UNMOVED, has=lambda own: waterfall_chart(own.critical()))
    def waterfall(self, group: str = "") -> Chart | None:
        """Show how the sources add up to U of the critical output of a group."""
        return waterfall_chart(self.critical(group))

    @shows(
        "no two outputs are correlated", has=lambda own: correlation_chart(own.budget)
    )
    def correlation(self) -> Chart | None:
        """Show the correlation of all outputs that have one."""
        return correlation_chart(self.budget)

    @shows(
        "no source affects that sensor",
        has=lambda own: own.varies and not own.is_mission,
    )
    def coupling(self, sensor: str = "") -> Chart | None:
        """Show which source reaches which parameters of a sensor, the first without."""
        sensor = self._sensor(sensor)
        return coupling_chart(coupling(question_of(self.budget)), sensor)

    @shows(
        "there is no calibration, or it has no windows",
        has=lambda own: own.turns_and_dwells,
    )
    def schedule(self) -> Chart | None:
        """Show turns and dwells of the test, to scale."""
        return self.turns_and_dwells

    @shows("the calibration has no positions", has=lambda own: not own.is_mission)
    def positions(self) -> Plot | None:
        """Show the positions of the calibration: which axis is up, and which turns."""
        own = question_of(self.budget)
        found = Positions.of(own.procedure, [sensor.kind for sensor in own.sensors])
        return positions_plot(found) if found else None

    @shows(
        "no specification of that sensor is noise", has=lambda own: not own.is_mission
    )
    def allan(self, sensor: str = "") -> Plot | None:
        """Show the noise of a sensor's data sheet by averaging time, the first without.

        With the windows that the calibration averages.
        """
        own = question_of(self.budget)
        triads = {one.kind: one for one in own.sensors}
        found = Allan.of(_choice(triads, sensor or next(iter(triads))), own.procedure)
        return allan_plot(found) if found else None

    @shows("nothing moves that error", has=lambda own: own.varies and own.is_mission)
    def growth(self, error: str = "position.horizontal") -> Plot | None:
        """Show an error of a mission over time, its limits, and what makes it when.

        'position.horizontal', 'velocity.down', 'attitude.heading'.
        """
        known = {str(Name(one, axis=axis)): (one, axis) for one, axis in ERRORS}
        found = ErrorGrowth.of(_curve(self.budget), _choice(known, error))
        judged = self.budget.assessment
        return growth_plot(found, judged.outputs if judged else ()) if found else None

    @shows(
        "the position has no covariance at the times that are asked for",
        has=lambda own: own.varies and own.is_mission and own.way,
    )
    def track(self) -> Plot | None:
        """Show the track of a mission from above, with ellipses of its errors."""
        return track_plot(self.way) if self.way else None

    @shows(
        "GUM propagation was not validated; analyze with validate=True and "
        "method='gum'",
        has=lambda own: any(row.validation for row in own.budget.outputs),
    )
    def validation(self, sensor: str = "") -> Chart | None:
        """Show the law against Monte Carlo, of a sensor, the first without."""
        return validity_chart(self.budget, self._sensor(sensor))

    @shows(
        "there are no Sobol' indices; analyze with samples=2048",
        has=lambda own: any(
            part.sobol for row in own.budget.outputs for part in row.contributions
        ),
    )
    def indices(self, sensor: str = "") -> Chart | None:
        """Show Sobol' indices, of a sensor, the first without."""
        return sobol_chart(self.budget, self._sensor(sensor))

    @shows("", has=lambda own: own.varies)
    def density(self, output: str = "") -> Plot:
        """Show how the error of a critical output is distributed, the first without.

        Of each group that is the output that uses most of its limit or, where nothing
        is required, has the largest spread.
        """
        own = self.budget
        every = critical_densities(question_of(own), own, own.assessment)
        found = {str(one.output.name): one for one in every}
        density = _choice(found, output or next(iter(found), ""))
        return density_plot(density, coverage=own.settings.coverage)

    def critical(self, group: str = "") -> Critical:
        """Return the output of a group that uses most of its limit, or is widest."""
        return Critical.of(self._group(group), self.budget.assessment)

    def _group(self, group: str) -> GroupTable:
        """Return the group of that name; see `contributions` for which without."""
        groups = group_tables(self.budget)
        tables = {str(Name(g.parameter, owner=g.sensor)): g for g in groups}
        judged = self.budget.assessment
        if not group and judged is not None and judged.outputs:
            group = str(worst_of(judged.outputs).output.name.group)
        return _choice(tables, group or next(iter(tables)))

    def _sensor(self, sensor: str) -> str:
        """Return the sensor that is asked for, the first of the budget without."""
        there = {row.sensor: row.sensor for row in self.budget.outputs}
        return _choice(there, sensor or next(iter(there)))

    @property
    def way(self) -> Way | None:
        """The track, where errors of position have a covariance at the asked times."""
        return way_with_errors(self.budget, _curve(self.budget))

    @property
    def turns_and_dwells(self) -> Chart | None:
        """Those of the test; None of no test."""
        there = {row.sensor for row in self.budget.outputs}
        sensors = [kind for kind in SENSORS if kind in there]
        procedure = question_of(self.budget).procedure
        return schedule_chart(procedure, sensors) if sensors else None


def _curve(budget: Budget) -> Curve:
    """Return how the errors of a mission grow.

    Raises
    ------
    CallError
        The budget is of no mission.
    """
    question = question_of(budget)
    if budget.mission is None or question.journey is None:
        raise CallError("the budget is of no mission; give mission= to analyze")
    asked = sorted({row.output.name.time or 0.0 for row in budget.outputs})
    return curve(question, drawn_times(question.journey, asked))


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
