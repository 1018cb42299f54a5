"""The law against Monte Carlo, which answers whether the law may be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import as_picture, capital
from budget.report.figures.rows import write_beside, write_heading
from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    canvas,
    house_style,
)
from budget.report.tables import output_title, print_count, words
from budget.ties import first_largest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.results import Budget, OutputBudget, Validation

ROW = 13.0  # [pt] from output to output
LEFT, RIGHT, TOP, BELOW = 24.0, 58.0, 4.0, 32.0  # [pt]
TEN = 10.0  # tolerances that are printed without decimals [1]
LEAST, LINEAR_BELOW = 1.5, 6.0  # reach of the axis, in tolerances [1]


@dataclass(frozen=True, kw_only=True)
class Check:
    """Both interval ends of one output: the law's less Monte Carlo's."""

    row: OutputBudget
    validation: Validation
    low: float  # in tolerances [1]
    high: float  # in tolerances [1]

    @property
    def worst(self) -> float:
        """The larger one in size [1]."""
        return max(abs(self.low), abs(self.high))

    @property
    def word(self) -> str:
        """Whether the law holds."""
        return self.validation.word


def validity_picture(budget: Budget, sensor: str) -> Picture | None:
    """Return the checks of one sensor as a block, None where nothing was checked."""
    checks = _checks(budget, sensor)
    if not checks:
        return None
    trials = print_count(max(check.validation.trials for check in checks))
    return as_picture(
        validity_marks(budget, sensor),
        name=f"validity-{sensor}",
        title=validity_title(budget, sensor),
        alt=validity_alt(budget, sensor),
        tips={_gid(check): _tip(check) for check in checks},
        caption=(
            f"Monte Carlo: {trials} trials. Triangles point to the end that they are "
            "of; in the band the law holds."
        ),
        data=_data(checks, sensor),
    )


@house_style()
def validity_marks(budget: Budget, sensor: str) -> Figure:
    """Draw both interval ends of each output against the band of the tolerance."""
    groups = _by_group(_checks(budget, sensor))
    rows = sum(len(checks) + 1 for _, checks in groups)
    figure, axes = canvas(
        TOP + ROW * rows + BELOW, left=LEFT, right=RIGHT, top=TOP, below=BELOW
    )
    figure.set_label(validity_title(budget, sensor))
    worst = max(check.worst for _, checks in groups for check in checks)
    reach = max(LEAST, 1.1 * worst)
    if reach > LINEAR_BELOW:
        axes.set_xscale("symlog", linthresh=1.0)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
        reach *= 1.2
    axes.set_xlim(-reach, reach)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.set_xlabel(
        "law less Monte Carlo [tolerances]; band: the law holds",
        fontsize=SMALL,
        color=MUTED,
    )
    ticks: list[tuple[int, str]] = []
    place = 0
    for title, checks in groups:
        write_heading(axes, place, title, indent=LEFT)
        ends = (place + 0.5, place + len(checks) + 0.5)
        axes.fill_betweenx(ends, -1.0, 1.0, color=GRID, alpha=0.6, linewidth=0.0)
        axes.plot([0.0, 0.0], ends, color=MUTED, linewidth=0.7, zorder=1)
        for check in checks:
            place += 1
            ticks.append((place, check.row.axis))
            _draw_check(axes, place, check)
        place += 1
    axes.set_yticks([place for place, _ in ticks], [axis for _, axis in ticks])
    return figure


def validity_title(budget: Budget, sensor: str) -> str:
    """State the finding: for how many outputs the law holds, and the worst of them."""
    checks = _checks(budget, sensor)
    worst = checks[first_largest([abs(check.worst) for check in checks])]
    name = output_title(worst.row.output.name)
    size = _signed(worst.worst)[1:]
    missed = sum(not check.validation.holds for check in checks)
    part = f"{name} with a difference of {size} tolerances"
    if missed:
        return (
            f"The law does not hold for {missed} of {len(checks)} {sensor} outputs, "
            f"farthest off is {part}"
        )
    return (
        f"The law holds for all {len(checks)} {sensor} outputs, farthest off is {part}"
    )


def validity_alt(budget: Budget, sensor: str) -> str:
    """Say in words with numbers what the marks show."""
    groups = []
    for title, checks in _by_group(_checks(budget, sensor)):
        marks = ", ".join(
            f"{check.row.axis} {_signed(check.low)} and {_signed(check.high)}"
            + ("" if check.validation.holds else f" ({check.word})")
            for check in checks
        )
        groups.append(f"{title}: {marks}")
    return (
        f"{validity_title(budget, sensor)}. Lower and upper interval end, law less "
        f"Monte Carlo, in tolerances. {'; '.join(groups)}."
    )


def _checks(budget: Budget, sensor: str) -> list[Check]:
    """Return the outputs that were checked and have a spread to be checked."""
    checks = []
    for row in budget.outputs:
        check = row.validation
        if row.sensor != sensor or check is None or not row.is_resolved:
            continue
        low, high = (
            (ours - theirs) / check.tolerance
            for ours, theirs in zip(row.interval, check.interval, strict=True)
        )
        checks.append(Check(row=row, validation=check, low=low, high=high))
    return checks


def _by_group(checks: list[Check]) -> list[tuple[str, list[Check]]]:
    """Return the checks under the title of their group of parameters."""
    return [
        (words(name), list(own))
        for name, own in groupby(checks, key=lambda check: check.row.parameter)
    ]


def _draw_check(axes: Axes, place: int, check: Check) -> None:
    """Draw both ends of one output; dark and named where the law does not hold."""
    holds = check.validation.holds
    axes.plot(
        [check.low, check.high],
        [place, place],
        color=MUTED if holds else INK,
        linewidth=0.7,
        zorder=2,
        gid=_gid(check),
    )
    for x, marker in ((check.low, "<"), (check.high, ">")):
        axes.plot(
            [x],
            [place],
            marker=marker,
            markersize=5.0,
            color=PAPER if holds else INK,
            markeredgecolor=MUTED if holds else INK,
            zorder=3,
        )
    size = _signed(check.worst)[1:]
    text = {"holds": size, "fails": f"fails {size}"}.get(check.word, check.word)
    write_beside(axes, place, text, reach=RIGHT - 4.0, strong=not holds)


def _tip(check: Check) -> str:
    """Say both differences of one output."""
    ends = f"lower end {_signed(check.low)}, upper end {_signed(check.high)} tolerances"
    return f"{output_title(check.row.output.name)}: the law {check.word}, {ends}"


def _signed(value: float) -> str:
    """Print a number of tolerances with its sign; hundredths of one are enough."""
    return f"{value:+.2f}" if abs(value) < TEN else f"{value:+.0f}"


def _data(checks: list[Check], sensor: str) -> Table:
    """Return the differences as a table."""
    return Table(
        name=f"validity-{sensor}-data",
        caption=f"The law less Monte Carlo for the {sensor}, in tolerances",
        columns=(
            Column(head="output"),
            Column(head="lower end [tolerances]", kind="number"),
            Column(head="upper end [tolerances]", kind="number"),
            Column(head="the law"),
        ),
        groups=tuple(
            RowGroup(
                title=capital(title),
                rows=tuple(
                    (
                        Cell(text=check.row.axis),
                        Cell(text=_signed(check.low), exact=check.low),
                        Cell(text=_signed(check.high), exact=check.high),
                        Cell(text=check.word, strong=not check.validation.holds),
                    )
                    for check in own
                ),
            )
            for title, own in _by_group(checks)
        ),
    )


def _gid(check: Check) -> str:
    """Name a pair of marks."""
    return f"tip-{check.row.output.name}"
