"""Figures of the paper's check: its figures 1 to 4, and the ratios of Table 1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from budget.language import say, words
from budget.report.blocks import Cell, Field, table_of
from budget.report.figures.rows import (
    Chart,
    Dot,
    Group,
    Panel,
    Row,
    Scale,
    Side,
)
from budget.report.figures.style import (
    INK,
    PAPER,
    as_picture,
    house_style,
    plane,
    write,
)
from budget.report.tables import print_given
from budget.report.wording import capital
from budget.ties import first_largest
from budget.units import PPM
from zhao_2019.printed import Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.report.blocks import Picture, Table
    from zhao_2019.orders import Sweep
    from zhao_2019.study import PaperStudy

HEIGHT = 190.0  # of a curve [pt]
DASHES = ("-", "--", ":", "-.")
ALIKE = 0.01  # curves whose ends differ by less of the largest share a label [1]

NEAR_ONE = 1e-3  # a ratio this close to 1 is printed with all its digits [1]
AIR = 2.0  # times the farthest ratio to the end of the axis [1]
FITS = (Verdict.FITS_MEAN, Verdict.FITS_SINGLE)
JOINED = ", all "  # in the place of a row that speaks of all axes


def sweep_picture(sweep: Sweep) -> Picture:
    """Return one of the paper's figures as a block, with the steps behind it."""
    name, title = sweep.figure.replace(" ", "-"), sweep_title(sweep)
    ends = {
        f"curve-{k}": _ends(names, curve)
        for k, (names, curve) in enumerate(_gathered(sweep))
    }
    first, last = (print_given(float(s / PPM)) for s in sweep.size[[0, -1]])
    return as_picture(
        _draw_sweep(sweep, title),
        name=name,
        title=title,
        alt=say(
            "{title}. Relative errors from {first} to {last} ppm. {ends}.",
            title=title,
            first=first,
            last=last,
            ends=say("; ").join(ends.values()),
        ),
        tips=ends,
        data=_steps(sweep, f"steps-of-{name}"),
    )


def sweep_title(sweep: Sweep) -> str:
    """State the finding of one figure, and the order that the paper prints."""
    is_angle = sweep.given.parameter == "mounting_angle"
    head = say(
        "{figure}: {cause} and {effect} errors",
        figure=capital(say(sweep.figure)),
        cause=_cause(sweep),
        effect=say("angle") if is_angle else say("bias"),
    )
    order = sweep.given.order
    if not sweep.largest:
        return say(
            "{head}: no effect at all (printed order {order}: rounding)",
            head=head,
            order=order,
        )
    if not sweep.slopes.any():
        return say(
            "{head}: none but eq. (4)'s own error, the same throughout (printed order "
            "{order})",
            head=head,
            order=order,
        )
    return say(
        "{head}: proportional, up to {size} (printed order {order})",
        head=head,
        size=print_given(sweep.largest, digits=3),
        order=order,
    )


@house_style()
def _draw_sweep(sweep: Sweep, title: str) -> Figure:
    """Draw relative errors against the step; curves that coincide share one label."""
    largest = sweep.largest
    exponent = int(np.floor(np.log10(largest))) if largest else 0
    scale = 10.0**exponent
    unit = f"1e{exponent}" if largest else "1"
    figure, axes = plane(
        title,
        f"{_cause(sweep)} [ppm]",
        say("relative error [{unit}]", unit=unit),
        HEIGHT,
    )
    x = sweep.size / PPM
    for k, (names, curve) in enumerate(_gathered(sweep)):
        axes.plot(
            x,
            curve / scale,
            color=INK,
            linewidth=1.1,
            linestyle=DASHES[k % len(DASHES)],
            gid=f"curve-{k}",
        )
        name = say("all") if len(names) == len(sweep.names) else say(", ").join(names)
        write(axes, name, (x[-1], curve[-1] / scale), (5.0, 0.0))
    axes.set_xlim(0.0, float(x[-1]))
    reach = 1.15 * largest / scale or 1.0
    axes.set_ylim(-reach, reach)
    if not largest:
        axes.set_yticks([0.0], ["0"])
    return figure


def _ends(names: Sequence[str], curve: Array) -> str:
    """Say where a curve begins and ends."""
    first, last = (print_given(float(e), digits=3) for e in curve[[0, -1]])
    return say(
        "{key}: {text}",
        key=say(", ").join(names),
        text=say("{low} to {high}", low=first, high=last),
    )


def _steps(sweep: Sweep, name: str) -> Table:
    """Return the relative error of every axis or angle at every step."""
    heads = (f"{_cause(sweep)} [ppm]", *sweep.names)
    rows: list[list[float]] = np.vstack([sweep.size / PPM, sweep.errors]).T.tolist()

    def cell(place: int, row: list[float]) -> Cell:
        return Cell(text=print_given(row[place]), exact=row[place])

    return table_of(
        rows,
        [
            Field(head=head, kind="number", cell=partial(cell, place))
            for place, head in enumerate(heads)
        ],
        name=name,
        caption=say(
            "Relative errors at each step of {figure}", figure=say(sweep.figure)
        ),
    )


def _gathered(sweep: Sweep) -> list[tuple[list[str], Array]]:
    """Return curves with the names of those that coincide with them."""
    found: list[tuple[list[str], Array]] = []
    for name, curve in zip(sweep.names, sweep.errors, strict=True):
        for names, other in found:
            if np.abs(other - curve).max() <= ALIKE * sweep.largest:
                names.append(name)
                break
        else:
            found.append(([name], curve))
    return found


def _cause(sweep: Sweep) -> str:
    """Name what is stepped."""
    return words(sweep.source.rpartition("_")[2])


@dataclass(frozen=True, kw_only=True)
class Entry:
    """All random entries of one parameter in one row of Table 1."""

    # 'Angle random walk', 'bias'.
    group: str
    parameter: str
    ratio: float  # u over the root mean square of the printed entries [1]
    verdict: Verdict

    @property
    def name(self) -> str:
        """The dot in a sentence: 'angle random walk on bias'."""
        group = f"{self.group[:1].lower()}{self.group[1:]}"
        return say("{group} on {parameter}", group=group, parameter=self.parameter)


def ratio_chart(study: PaperStudy) -> Chart:
    """Show u over the printed root mean square, a dot for each random row of Table 1.

    The table has the numbers too.
    """
    dots = [
        Entry(
            group=capital(say(row.place[0])),
            parameter=say(row.place[1].partition(JOINED)[0]),
            ratio=row.ratio,
            verdict=row.verdict,
        )
        for row in study.of_section("table 1")
        if row.is_summary and row.ratio is not None and JOINED in row.where
    ]
    fits = sum(dot.verdict in FITS for dot in dots)
    far = dots[first_largest([max(dot.ratio, 1.0 / dot.ratio) for dot in dots])]
    is_open = any(dot.verdict == Verdict.UNEXPLAINED for dot in dots)
    ratios = [dot.ratio for dot in dots]
    scale = Scale(
        low=min(*ratios, 1.0) / AIR,
        high=max(*ratios, 1.0) * AIR,
        kind="log",
        lines=((1.0, ""),),
        label=say("ours / printed, root mean square"),
    )
    groups = tuple(
        Group(title=title, rows=tuple(map(_row, own)))
        for title, own in groupby(dots, key=lambda dot: dot.group)
    )
    return Chart(
        name="ratios",
        title=say(
            "{fits} of the {dots} random rows of Table 1 fit; farthest off is {far}, "
            "{ratio} times the printed",
            fits=fits,
            dots=len(dots),
            far=far.name,
            ratio=print_ratio(far.ratio),
        ),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=say("Ours over printed: "),
        caption=say(
            "Ours: u of a single run, or of a mean over 25 where the row fits that. "
            "Filled: fits; open: does not; bold: and nothing explains it."
            if is_open
            else "Ours: u of a single run, or of a mean over 25 where the row fits "
            "that. Filled: fits; open: does not."
        ),
    )


def _row(dot: Entry) -> Row:
    """Return one dot, filled where it fits."""
    ratio = print_ratio(dot.ratio)
    mark = Dot(
        at=dot.ratio,
        fill=INK if dot.verdict in FITS else PAPER,
        size=5.5,
        tip=say(
            "{name}: {ratio} times the printed root mean square; {verdict}",
            name=dot.name,
            ratio=ratio,
            verdict=say(dot.verdict.value),
        ),
    )
    return Row(
        label=dot.parameter,
        marks=(mark,),
        beside=(ratio,),
        strong=dot.verdict == Verdict.UNEXPLAINED,
        said=say(
            "{parameter} {ratio} ({verdict})",
            parameter=dot.parameter,
            ratio=ratio,
            verdict=say(dot.verdict.value),
        ),
    )


def print_ratio(ratio: float | None) -> str:
    """Print ours over printed, '' where there is none."""
    if ratio is None:
        return ""
    if abs(ratio - 1.0) < NEAR_ONE:
        return f"{ratio:.6f}"
    return print_given(ratio, digits=3)
