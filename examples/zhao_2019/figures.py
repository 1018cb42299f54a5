"""Figures of the paper's check: its figures 1 to 4, and the ratios of Table 1."""

from __future__ import annotations

from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

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
from budget.report.pages import blocks, line
from budget.report.tables import print_given
from budget.ties import first_largest
from budget.units import PPM
from zhao_2019.printed import Agreement

if TYPE_CHECKING:
    from typing import Any

    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.report.blocks import Picture
    from zhao_2019.orders import Sweep
    from zhao_2019.printed import Finding
    from zhao_2019.study import PaperStudy

PAGE = "figures_paper"
HEIGHT = 190.0  # of a curve [pt]
DASHES = ("-", "--", ":", "-.")
ALIKE = 0.01  # curves whose ends differ by less of the largest share a label [1]

NEAR_ONE = 1e-3  # a ratio this close to 1 is printed with all its digits [1]
AIR = 2.0  # times the farthest ratio to the end of the axis [1]
FITS = (Agreement.FITS_MEAN, Agreement.FITS_SINGLE)
JOINED = ", all "  # in the place of a row that speaks of all axes
said = partial(line, PAGE)


def sweep_picture(sweep: Sweep) -> Picture:
    """Return one of the paper's figures as a block, with the steps behind it."""
    title, curves, steps = sweep_title(sweep), _gathered(sweep), sweep.size / PPM
    data: Any = blocks(
        PAGE, "steps", sweep=sweep, rows=np.vstack([steps, sweep.errors]).T.tolist()
    )[0]
    return as_picture(
        _draw_sweep(sweep, title),
        name=sweep.figure.replace(" ", "-"),
        title=title,
        alt=said("sweep_alt", title=title, steps=steps, curves=curves),
        tips={
            f"curve-{k}": said("curve_tip", names=names, curve=curve)
            for k, (names, curve) in enumerate(curves)
        },
        data=data,
    )


def sweep_title(sweep: Sweep) -> str:
    """State the finding of one figure, and the order that the paper prints."""
    return said("sweep_title", sweep=sweep)


@house_style()
def _draw_sweep(sweep: Sweep, title: str) -> Figure:
    """Draw relative errors against the step; curves that coincide share one label."""
    largest = sweep.largest
    exponent = int(np.floor(np.log10(largest))) if largest else 0
    scale = 10.0**exponent
    unit = f"1e{exponent}" if largest else "1"
    figure, axes = plane(
        title,
        said("step", sweep=sweep),
        said("error", unit=unit),
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
        name = said("curve_label", names=names, all=sweep.names)
        write(axes, name, (x[-1], curve[-1] / scale), (5.0, 0.0))
    axes.set_xlim(0.0, float(x[-1]))
    reach = 1.15 * largest / scale or 1.0
    axes.set_ylim(-reach, reach)
    if not largest:
        axes.set_yticks([0.0], ["0"])
    return figure


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


def ratio_chart(study: PaperStudy) -> Chart:
    """Show u over the printed root mean square, a dot for each random row of Table 1.

    The table has the numbers too.
    """
    rows = [
        row
        for row in study.of_section("table 1")
        if row.is_summary and row.ratio is not None and JOINED in row.where
    ]
    ratios = [row.ratio or 1.0 for row in rows]
    far = rows[first_largest([max(ratio, 1.0 / ratio) for ratio in ratios])]
    fits = sum(row.verdict in FITS for row in rows)
    is_open = any(row.verdict == Agreement.UNEXPLAINED for row in rows)
    scale = Scale(
        low=min(*ratios, 1.0) / AIR,
        high=max(*ratios, 1.0) * AIR,
        kind="log",
        lines=((1.0, ""),),
        label=said("ratio_axis"),
    )
    groups = tuple(
        Group(title=title, rows=tuple(map(_row, own)))
        for title, own in groupby(rows, key=lambda row: said("ratio_group", row=row))
    )
    ratio = print_ratio(far.ratio)
    return Chart(
        name="ratios",
        title=said("ratio_title", fits=fits, rows=rows, far=far, ratio=ratio),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=said("ratio_lead"),
        caption=said("ratio_caption", is_open=is_open),
    )


def _row(row: Finding) -> Row:
    """Return one dot, filled where it fits."""
    ratio = print_ratio(row.ratio)
    mark = Dot(
        at=row.ratio or 1.0,
        fill=INK if row.verdict in FITS else PAPER,
        size=5.5,
        tip=said("ratio_tip", row=row, ratio=ratio),
    )
    return Row(
        label=said("ratio_label", row=row),
        marks=(mark,),
        beside=(ratio,),
        strong=row.verdict == Agreement.UNEXPLAINED,
        said=said("ratio_said", row=row, ratio=ratio),
    )


def print_ratio(ratio: float | None) -> str:
    """Print ours over printed, '' where there is none."""
    if ratio is None:
        return ""
    if abs(ratio - 1.0) < NEAR_ONE:
        return f"{ratio:.6f}"
    return print_given(ratio, digits=3)
