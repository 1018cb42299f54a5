"""Figures of the paper's check: its figures 1 to 4, and the ratios of Table 1."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.report.figures.rows import Chart, ChartPanel, Dot, rows_of
from budget.report.figures.style import INK, PAPER, Scale, add_plane, blank, write
from budget.report.figures.tabled import Plot, alternative_of_curves
from budget.report.pages import figure, line
from budget.report.tables import print_given
from budget.ties import first_largest
from budget.units import PPM
from zhao_2019.printed import Agreement

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

    from matplotlib.figure import Figure

    from budget.arrays import Array
    from zhao_2019.orders import Sweep
    from zhao_2019.study import PaperStudy

PAGE = "figures_paper"
HEIGHT = 190.0  # of a curve [pt]
DASHES = ("-", "--", ":", "-.")
ALIKE = 0.01  # curves whose ends differ by less of the largest share a label [1]

NEAR_ONE = 1e-3  # a ratio this close to 1 is printed with all its digits [1]
AIR = 2.0  # times the farthest ratio to the end of the axis [1]
FITS = (Agreement.FITS_MEAN, Agreement.FITS_SINGLE)
JOINED = ", all "  # in the place of a row that speaks of all axes


def sweep_plot(sweep: Sweep) -> Plot:
    """Show one of the paper's figures, with the steps behind it."""
    curves, steps = _gathered(sweep), sweep.size / PPM
    exponent = int(np.floor(np.log10(sweep.largest))) if sweep.largest else 0
    told, table = figure(
        PAGE,
        "sweep",
        sweep=sweep,
        unit=f"1e{exponent}" if sweep.largest else "1",
        rows=np.vstack([steps, sweep.errors]).T.tolist(),
    )
    return Plot(
        name=sweep.figure.replace(" ", "-"),
        said=told,
        table=table,
        draw=lambda: _draw_sweep(sweep, curves, 10.0**exponent, told),
        tips={
            f"curve-{k}": line(PAGE, "curve_tip", names=names, curve=curve)
            for k, (names, curve) in enumerate(curves)
        },
        alt=alternative_of_curves(told.title, table),
        data_on_paper=True,
    )


def _draw_sweep(
    sweep: Sweep,
    curves: Sequence[tuple[list[str], Array]],
    scale: float,
    told: SimpleNamespace,
) -> Figure:
    """Draw relative errors against the step; curves that coincide share one label."""
    x = sweep.size / PPM
    reach = 1.15 * sweep.largest / scale or 1.0
    drawing = blank(HEIGHT)
    axes = add_plane(
        drawing,
        Scale(low=0.0, high=float(x[-1]), label=told.step),
        Scale(
            low=-reach,
            high=reach,
            ticks=None if sweep.largest else ((0.0, "0"),),
            label=told.error,
        ),
        height=HEIGHT - 46.0,
    )
    for k, (names, curve) in enumerate(curves):
        axes.plot(
            x,
            curve / scale,
            color=INK,
            linewidth=1.1,
            linestyle=DASHES[k % len(DASHES)],
            gid=f"curve-{k}",
        )
        name = line(PAGE, "curve_label", names=names, all=sweep.names)
        write(axes, name, (x[-1], curve[-1] / scale), (5.0, 0.0))
    return drawing


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
    said, table = figure(
        PAGE,
        "ratios",
        rows=rows,
        far=far,
        fits=sum(row.verdict in FITS for row in rows),
        is_open=any(row.verdict == Agreement.UNEXPLAINED for row in rows),
        unexplained=Agreement.UNEXPLAINED,
        print=print_ratio,
    )
    scale = Scale(
        low=min(*ratios, 1.0) / AIR,
        high=max(*ratios, 1.0) * AIR,
        kind="log",
        lines=((1.0, ""),),
        label=said.axis,
    )
    drawn = rows_of(
        table,
        lambda at, row: [
            Dot(
                start=at.ratio,
                colour=INK if row.verdict in FITS else PAPER,
                width=5.5,
                tip=at.tip,
            )
        ],
        rows,
    )
    return Chart(
        name="ratios",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        has_data=False,
        caption=said.caption,
    )


def print_ratio(ratio: float | None) -> str:
    """Print ours over printed, '' where there is none."""
    if ratio is None:
        return ""
    if abs(ratio - 1.0) < NEAR_ONE:
        return f"{ratio:.6f}"
    return print_given(ratio, digits=3)
