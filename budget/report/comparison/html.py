"""A comparison as one HTML page: what stands there; the words are in the template."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.comparison import figures
from budget.report.comparison.document import to_json
from budget.report.comparison.tables import (
    PAIRS_SHOWN,
    advice_lines,
    cap_lines,
    missing_lines,
    print_parts,
    print_probability,
    side_by_side,
    tables,
    verdict_lines,
)
from budget.report.inline import inline_svg
from budget.report.markup import (
    css_string,
    markup,
    page_environment,
    script_safe,
)
from budget.report.tables import (
    Number,
    output_title,
    print_coverage,
    print_given,
    round_value,
    settings_lines,
    words,
)
from budget.studies.comparison.figures_of_merit import MERITS
from budget.version import __version__

if TYPE_CHECKING:
    from budget.report.comparison.tables import Row, Table
    from budget.studies.comparison.records import Comparison, Pair, RequiredOutput


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One required output of one device, as text."""

    part: Number  # of the limit [%]
    error: str  # '0.056 deg/h of 0.1 deg/h'
    is_within: bool


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """A Pareto scatter and its data: (device, cost, part of the limit, on front)."""

    title: str
    merit: str
    svg: str
    points: tuple[tuple[str, str, str, bool], ...]


@dataclass(frozen=True, kw_only=True)
class Section:
    """One table with its figures."""

    table: Table
    map_title: str
    map_svg: str
    heads: tuple[str, ...]
    cells: tuple[tuple[Row, tuple[Cell, ...]], ...]
    margin_title: str
    margin_svg: str
    scatters: tuple[Scatter, ...]

    @property
    def has_intervals(self) -> bool:
        """Whether utilisations have sampling intervals."""
        return any(row.interval for row in self.table.rows)

    @property
    def has_missing(self) -> bool:
        """Whether any device lacks an expected line."""
        return any(row.missing for row in self.table.rows)


def render_html(comparison: Comparison, *, date: str) -> str:
    """Write the comparison as one page that needs nothing else.

    Parameters
    ----------
    comparison : Comparison
        The result.
    date : str
        As it shall stand on the page.

    Returns
    -------
    str
        The same bytes for the same arguments.
    """
    environment = page_environment()
    environment.filters |= {
        "svg": markup,
        "words": words,
        "first_up": lambda text: text[:1].upper() + text[1:],
    }
    found = tables(comparison)
    several = len(comparison.procedures) > 1
    return environment.get_template("comparison.html.j2").render(
        comparison=comparison,
        coverage=print_coverage(comparison.settings.coverage),
        verdicts=verdict_lines(found),
        several=several,
        sides=[
            (sensor, side_by_side(found, sensor))
            for sensor in (comparison.required if several else ())
        ],
        sections=[_section(table, place) for place, table in enumerate(found)],
        pairs=[_pair_cells(pair) for pair in comparison.pairs[:PAIRS_SHOWN]],
        missing=missing_lines(comparison),
        advice=advice_lines(comparison),
        caps=cap_lines(comparison),
        settings=settings_lines(comparison.settings),
        shown=figures.SHOWN,
        date=date,
        version=__version__,
        document=markup(script_safe(to_json(comparison))),
        css_string=lambda text: markup(css_string(text)),
    )


def _section(table: Table, place: int) -> Section:
    """Draw the figures of one table, and write the data behind them."""
    scatters = []
    for merit in MERITS:
        points = figures.merit_points(table, merit)
        if len(points) < figures.LEAST_POINTS:
            continue
        svg = inline_svg(
            figures.pareto_scatter(table, merit),
            f"pareto-{merit}-{place}",
            figures.pareto_alt(table, merit),
        )
        scatters.append(
            Scatter(
                title=figures.pareto_title(table, merit),
                merit=merit,
                svg=svg,
                points=tuple(
                    (
                        row.device,
                        f"{print_given(amount.value)} {amount.unit}",
                        row.utilisation,
                        merit in row.of.on_front,
                    )
                    for row, amount in points
                ),
            )
        )
    return Section(
        table=table,
        map_title=figures.map_title(table),
        map_svg=inline_svg(
            figures.utilisation_map(table), f"map-{place}", figures.map_alt(table)
        ),
        heads=tuple(
            output_title(output.output.name.partition(".")[2])
            for output in table.rows[0].of.outputs
        ),
        cells=tuple(
            (row, tuple(_cell(output) for output in row.of.outputs))
            for row in table.rows
        ),
        margin_title=figures.margin_title(table),
        margin_svg=inline_svg(
            figures.margin_bars(table), f"margin-{place}", figures.margin_alt(table)
        ),
        scatters=tuple(scatters),
    )


def _cell(output: RequiredOutput) -> Cell:
    """Round one output of one device like its uncertainty."""
    scale = output.output.si_per_unit
    error = round_value(
        output.largest_error / scale,
        output.standard_uncertainty / scale,
        resolution=output.output.resolution / scale,
    )
    part = output.utilisation
    return Cell(
        part=Number(text=print_parts(part, (part, part))[0], exact=part),
        error=f"{error} {output.output.unit} of {output.printed_limit}",
        is_within=part <= 1.0,
    )


def _pair_cells(pair: Pair) -> tuple[str, ...]:
    """Write one pair."""
    return (
        pair.gyro,
        pair.accelerometer,
        pair.procedure,
        pair.verdict,
        print_parts(pair.utilisation, (pair.utilisation,) * 2)[0],
        print_probability(pair.conformance),
    )
