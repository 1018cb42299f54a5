"""Law against Monte Carlo: interval ends of each output, in tolerances."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from budget.names import words
from budget.report.blocks import Cell, Field, table_of
from budget.report.figures.rows import (
    Chart,
    Dot,
    Group,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import INK, MUTED, PAPER
from budget.report.tables import output_title, print_count
from budget.report.wording import capital
from budget.ties import first_largest

if TYPE_CHECKING:
    from budget.results import Budget, OutputBudget, Validation

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


FIELDS = (
    Field[Check](head="output", cell=lambda check: check.row.axis),
    Field[Check](
        head="lower end [tolerances]",
        kind="number",
        cell=lambda check: Cell(text=_signed(check.low), exact=check.low),
    ),
    Field[Check](
        head="upper end [tolerances]",
        kind="number",
        cell=lambda check: Cell(text=_signed(check.high), exact=check.high),
    ),
    Field[Check](
        head="the law",
        cell=lambda check: Cell(
            text=check.validation.word, strong=not check.validation.holds
        ),
    ),
)


def validity_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show both interval ends of each output of a sensor, None where none was checked.

    The band is the tolerance of JCGM 101:2008, 8.1.
    """
    checks = _checks(budget, sensor)
    if not checks:
        return None
    trials = print_count(max(check.validation.trials for check in checks))
    reach = max(LEAST, 1.1 * max(check.worst for check in checks))
    is_long = reach > LINEAR_BELOW
    scale = Scale(
        low=-reach * (1.2 if is_long else 1.0),
        high=reach * (1.2 if is_long else 1.0),
        kind="symlog" if is_long else "linear",
        lines=((0.0, ""),),
        band=(-1.0, 1.0),
        label="law less Monte Carlo [tolerances]; band: the law holds",
    )
    groups = tuple(
        Group(title=words(name), rows=tuple(map(_row, own)))
        for name, own in groupby(checks, key=lambda check: check.row.parameter)
    )
    return Chart(
        name=f"validity-{sensor}",
        title=_title(checks, sensor),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=("Lower and upper interval end, law less Monte Carlo, in tolerances. "),
        caption=(
            f"Monte Carlo: {trials} trials. Triangles point to the end that they are "
            "of; in the band the law holds."
        ),
        data=table_of(
            checks,
            FIELDS,
            name=f"validity-{sensor}-data",
            caption=f"The law less Monte Carlo for the {sensor}, in tolerances",
            by=lambda check: capital(words(check.row.parameter)),
            titled=True,
        ),
    )


def _title(checks: list[Check], sensor: str) -> str:
    """State the finding: for how many outputs the law holds, and the worst of them."""
    worst = checks[first_largest([check.worst for check in checks])]
    name, size = output_title(worst.row.output.name), _signed(worst.worst)[1:]
    missed = sum(not check.validation.holds for check in checks)
    part = f"farthest off is {name} with a difference of {size} tolerances"
    if missed:
        return (
            f"The law does not hold for {missed} of {len(checks)} {sensor} outputs, "
            f"{part}"
        )
    return f"The law holds for all {len(checks)} {sensor} outputs, {part}"


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


def _row(check: Check) -> Row:
    """Return both ends of one output; dark and named where the law does not hold."""
    holds, word = check.validation.holds, check.validation.word
    low, high = _signed(check.low), _signed(check.high)
    size = _signed(check.worst)[1:]
    fill, edge = (PAPER, MUTED) if holds else (INK, INK)
    axis = check.row.axis
    tip = (
        f"{output_title(check.row.output.name)}: the law {word}, lower end {low}, "
        f"upper end {high} tolerances"
    )
    return Row(
        label=axis,
        marks=(
            Stroke(start=check.low, end=check.high, colour=edge, tip=tip),
            Dot(at=check.low, shape="<", fill=fill, edge=edge),
            Dot(at=check.high, shape=">", fill=fill, edge=edge),
        ),
        beside=({"holds": size, "fails": f"fails {size}"}.get(word, word),),
        strong=not holds,
        said=f"{axis} {low} and {high}" + ("" if holds else f" ({word})"),
    )


def _signed(value: float) -> str:
    """Print a number of tolerances with its sign; hundredths of one are enough."""
    return f"{value:+.2f}" if abs(value) < TEN else f"{value:+.0f}"
