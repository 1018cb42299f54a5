"""Utilisation dots, which answer how near each output is to its limit."""

from __future__ import annotations

from itertools import groupby
from math import floor, log10
from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import as_picture
from budget.report.figures.rows import (
    columns_for,
    write_beside,
    write_heading,
    write_on,
)
from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    add_panel,
    blank,
    house_style,
)
from budget.report.tables import (
    Number,
    bound_number,
    join_outputs,
    output_title,
    print_utilisation,
    round_error,
)
from budget.results import worst_of
from budget.ties import from_largest, largest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.results import Assessment, OutputAssessment

ROW = 13.0  # [pt] from dot to dot
MOST_TICKS = 4  # that fit side by side where there are two columns
TOP, BELOW = 28.0, 30.0  # [pt]
NAMES, NUMBERS = 24.0, 42.0  # room beside the dots [pt]
LINEAR_BELOW = 4.0  # utilisations beyond need a logarithmic axis [1]


def utilisation_picture(assessment: Assessment) -> Picture:
    """Return the dots as a block, with a tooltip for each and the data behind them."""
    rows = [
        RowGroup(
            title=title,
            rows=tuple(
                (
                    Cell(text=_axis(row)),
                    Cell(
                        text=_used(row).removesuffix(" %"),
                        exact=100.0 * row.utilisation,
                        strong=not row.is_within,
                    ),
                    Cell(text=row.printed_limit),
                )
                for row in outputs
            ),
        )
        for title, outputs in _by_group(assessment)
    ]
    return as_picture(
        utilisation_dots(assessment),
        name="utilisation",
        title=utilisation_title(assessment),
        alt=utilisation_alt(assessment),
        tips={
            _gid(row): f"{output_title(row.output.name)}: largest error "
            f"{_error(row)}, {_used(row)} of the limit "
            f"{row.printed_limit}"
            for row in assessment.outputs
        },
        data=Table(
            name="utilisation-data",
            caption="Largest error of each output in per cent of its limit",
            columns=(
                Column(head="output"),
                Column(head="largest error [% of the limit]", kind="number"),
                Column(head="limit"),
            ),
            groups=tuple(rows),
        ),
    )


@house_style()
def utilisation_dots(assessment: Assessment) -> Figure:
    """Draw each required output's largest error against its limit, worst first."""
    sensors = list(dict.fromkeys(map(_sensor, assessment.outputs)))
    columns = [_by_group(assessment, sensor) for sensor in sensors]
    rows = [sum(len(own) + 1 for _, own in groups) for groups in columns]
    height = TOP + ROW * max(rows) + BELOW
    figure = blank(height)
    figure.set_label(utilisation_title(assessment))
    largest = max(output.utilisation for output in assessment.outputs)
    for (left, width), sensor, groups, number in zip(
        columns_for(len(sensors)), sensors, columns, rows, strict=True
    ):
        write_on(figure, left + 4.0, 10.0, sensor, weight="bold")
        axes = add_panel(
            figure,
            left=left + NAMES,
            top=TOP,
            width=width - NAMES - NUMBERS,
            height=ROW * number,
        )
        _draw_sensor(axes, groups, number, largest)
    text = "largest error [% of the limit]; filled: beyond it"
    write_on(figure, 4.0, height - 4.0, text, size=SMALL, colour=MUTED)
    return figure


def utilisation_title(assessment: Assessment) -> str:
    """State the finding: how many outputs exceed their limits, and the worst."""
    worst = worst_of(assessment.outputs)
    sensors = assessment.sensors
    nearest = [
        sensors[place] for place in largest([one.utilisation for one in sensors])
    ]
    beyond = sum(not output.is_within for output in assessment.outputs)
    name = join_outputs([name for one in nearest for name in one.worst_outputs])
    part = f"{name} at {_used(worst)} of the limit"
    total = len(assessment.outputs)
    if beyond:
        return f"{beyond} of {total} outputs exceed their limits, most of all {part}"
    open_ones = sum(output.lower_bound for output in assessment.outputs)
    if open_ones:
        return (
            f"{total - open_ones} of {total} outputs are within their limits, "
            f"{open_ones} cannot be decided, lines are missing"
        )
    return f"All {total} outputs stay within their limits, the nearest is {part}"


def utilisation_alt(assessment: Assessment) -> str:
    """Say in words with numbers what the dots show."""
    groups = []
    for title, outputs in _by_group(assessment):
        dots = ", ".join(f"{_axis(o)} {_used(o)}" for o in outputs)
        groups.append(f"{title}: {dots}")
    return (
        f"{utilisation_title(assessment)}. Largest errors in per cent of the limit. "
        f"{'; '.join(groups)}."
    )


def _axis(row: OutputAssessment) -> str:
    """Return the axis of an output."""
    return row.output.name.axis


def _gid(row: OutputAssessment) -> str:
    """Name a dot."""
    return f"tip-{row.output.name}"


def _error(row: OutputAssessment) -> str:
    """Write a largest error with its unit."""
    error = round_error(row.largest_error, row.standard_uncertainty, row.output)
    marked = bound_number(error, lower_bound=row.lower_bound, unknown=row.is_unknown)
    return f"{marked.text} {row.output.unit}"


def _used(row: OutputAssessment) -> str:
    """Write the part of a limit, marked where it is a lower bound."""
    used = Number(text=print_utilisation(row.utilisation), exact=row.utilisation)
    return bound_number(used, lower_bound=row.lower_bound, unknown=row.is_unknown).text


def _sensor(row: OutputAssessment) -> str:
    """Return the triad of an output."""
    return row.output.name.owner


def _by_group(
    assessment: Assessment, sensor: str = ""
) -> list[tuple[str, list[OutputAssessment]]]:
    """Return the outputs by parameter group, the worst group first.

    Axes keep their order, which noise would change otherwise. Titles of the groups of
    one sensor are without its name.
    """
    own = [row for row in assessment.outputs if sensor in {"", _sensor(row)}]
    groups = [
        (
            output_title(name.without_owner if sensor else name),
            list(outputs),
        )
        for name, outputs in groupby(own, key=lambda output: output.output.name.group)
    ]
    used = [worst_of(outputs).utilisation for _, outputs in groups]
    return [groups[k] for k in from_largest(used)]


def _draw_sensor(
    axes: Axes,
    groups: list[tuple[str, list[OutputAssessment]]],
    rows: int,
    largest: float,
) -> None:
    """Draw the groups of one sensor on the axis that both have."""
    start = 0.0
    if largest > LINEAR_BELOW:
        axes.set_xscale("log")
        start = 1.0  # [%]; what is less sits at the edge, its label is exact
        decades = range(floor(log10(100.0 * largest)) + 1)
        step = 1 if len(decades) <= MOST_TICKS else 2
        axes.set_xticks([10.0**k for k in decades][::step])
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
    else:
        axes.locator_params(axis="x", nbins=4, steps=[1, 2, 5, 10])
    axes.set_xlim(start, 100.0 * max(1.05 * largest, 1.2))
    axes.set_ylim(rows - 0.5, -0.5)
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    ticks: list[tuple[int, str]] = []
    place = 0
    for title, outputs in groups:
        write_heading(axes, place, title, indent=NAMES)
        for output in outputs:
            place += 1
            ticks.append((place, _axis(output)))
            _draw_dot(axes, place, output, start)
        place += 1
    axes.set_yticks([place for place, _ in ticks], [axis for _, axis in ticks])
    axes.axvline(100.0, color=INK, linewidth=1.0, zorder=2)
    axes.annotate(
        "limit",
        (100.0, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0.0, 4.0),
        textcoords="offset points",
        ha="center",
        fontsize=SMALL,
        color=INK,
    )


def _draw_dot(axes: Axes, place: int, output: OutputAssessment, start: float) -> None:
    """Draw one output: a thin line to its dot, filled where it is beyond the limit."""
    x = max(100.0 * output.utilisation, start)
    axes.plot([start, x], [place, place], color=MUTED, linewidth=0.7, zorder=1)
    axes.plot(
        [x],
        [place],
        marker="o",
        markersize=5.0,
        color=PAPER if output.is_within else INK,
        markeredgecolor=MUTED if output.is_within else INK,
        zorder=3,
        clip_on=False,
        gid=_gid(output),
    )
    write_beside(
        axes,
        place,
        _used(output),
        reach=NUMBERS - 2.0,
        strong=not output.is_within,
    )
