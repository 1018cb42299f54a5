"""Densities of the errors of the critical outputs, against their limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.known import Known
from budget.report.figures.style import (
    BLUE,
    INK,
    MUTED,
    SMALL,
    WIDTH,
    add_panel,
    blank,
    text_width,
    without_name,
    write,
)
from budget.report.figures.tabled import Plot
from budget.report.pages import figure
from budget.report.tables import print_coverage, print_given, round_error

if TYPE_CHECKING:
    from types import SimpleNamespace

    from matplotlib.figure import Figure

    from budget.report.tables import Number
    from budget.studies.densities import ErrorDensity

SIDE, TOP, BELOW = 12.0, 16.0, 34.0  # around the panel [pt]
HEIGHT = 156.0  # [pt]
STRIP = 0.3  # height of the intervals below the density, over its peak [1]
FAR = 2.2  # a limit beyond so many times the reach of the trials is not drawn [1]
REACH = 3.6  # of the picture, in standard uncertainties at least [1]
AIR = 6.0  # between words [pt]
POINTS = 161  # of the normal law
INSIDE, BEYOND = 0.28, 0.75  # opacities of the one hue, within the limits and not
PAGE = "figures_density"


def density_plot(density: ErrorDensity, *, coverage: float) -> Plot:
    """Show the density of one output: trials, the normal law over it, limits."""
    output, limit = density.output, density.limit

    def marked(x: float, *, is_mean: bool = False, is_end: bool = False) -> Number:
        """Round a mean, a lower end or another number; what lines not given move."""
        known = Known(x) if is_mean else density.u.like(x)
        return round_error(known.falling if is_end else known, density.u, output)

    said, table = figure(
        PAGE,
        "density",
        density=density,
        coverage=coverage,
        beyond=part_beyond(density),
        limit=print_given((limit or 0.0) / output.si_per_unit),
        is_far=limit is not None and not _limits(density),
        scale=output.si_per_unit,
        rounded=lambda x: round_error(x, density.u, output).text,
        marked=marked,
    )
    return Plot(
        name=f"density-{output.name}",
        said=said,
        table=table,
        draw=lambda: _draw(density, f"{print_coverage(coverage)} %", said),
    )


def _draw(density: ErrorDensity, share: str, said: SimpleNamespace) -> Figure:
    """Draw the density of trials, the normal law over it, intervals and limits."""
    drawing, scale = blank(HEIGHT), density.output.si_per_unit
    width = WIDTH - 2.0 * SIDE
    axes = add_panel(
        drawing, left=SIDE, top=TOP, width=width, height=HEIGHT - TOP - BELOW
    )
    limits = _limits(density)
    ends = np.array([*_reach(density), *limits])
    low, high = ends.min() - 0.02 * np.ptp(ends), ends.max() + 0.02 * np.ptp(ends)
    axes.set(xlim=(low / scale, high / scale), ylim=(-STRIP, 1.04), yticks=[])
    without_name(axes.yaxis)
    x = np.linspace(low, high, POINTS)
    law = np.exp(-0.5 * ((x - density.mean) / density.u) ** 2)
    law /= density.u * np.sqrt(2.0 * np.pi)
    peak = max(float(density.density.max()), float(law.max()))
    far = np.inf if density.limit is None else density.limit
    for own, opacity in (
        ((-far, far), INSIDE),
        ((-np.inf, -far), BEYOND),
        ((far, np.inf), BEYOND),
    ):
        edges = np.clip(density.edges, *own)  # bins that are not there have no width
        if edges[0] < edges[-1]:
            steps = axes.stairs(density.density / peak, edges / scale, fill=True)
            steps.set(facecolor=BLUE, alpha=opacity, linewidth=0.0)
    axes.plot(x / scale, law / peak, color=INK, linewidth=1.1)
    axes.plot([low / scale, high / scale], [0.0, 0.0], color=MUTED, linewidth=0.6)
    for y, interval, colour, text in (
        (-0.09, density.interval, INK, said.law),
        (-0.21, density.interval_mc, BLUE, said.trials),
    ):
        start, end = (one / scale for one in interval)
        axes.hlines(y, start, end, color=colour, linewidth=3.0)
        write(axes, share, (start, y), (-4.0, 0.0), ha="right")
        write(axes, text, (end, y), (4.0, 0.0))
    room = (text_width(said.limit) + AIR) * (high - low)
    are_near = len(limits) > 1 and 2.0 * far * width < room
    for at, apart in zip(limits, ("right", "left"), strict=False):
        side = apart if are_near else "center"
        dashes = (0.0, (5.0, 2.0))
        axes.vlines(at / scale, 0.0, 1.04, color=INK, linewidth=1.0, linestyle=dashes)
        write(axes, said.limit, (at / scale, 1.04), (0.0, 3.0), ha=side, va="baseline")
    axes.locator_params(axis="x", nbins=7, steps=[1, 2, 5, 10])
    axes.set_xticks([x for x in axes.get_xticks() if low <= x * scale <= high])
    axes.set_xlabel(said.axis, fontsize=SMALL, color=MUTED)
    return drawing


def part_beyond(density: ErrorDensity) -> float:
    """Return the part of trials beyond the limit; a bin that it cuts counts in part."""
    if density.limit is None:
        return 0.0
    ends = np.clip(density.edges, -density.limit, density.limit)
    # Bins within the limits keep their width, those beyond have none left.
    return float(density.density @ (np.diff(density.edges) - np.diff(ends)))


def _reach(density: ErrorDensity) -> tuple[float, float]:
    """Return the range where trials and law can be seen [SI]."""
    (low, high), reach = density.interval_mc, REACH * density.u
    margin = 0.4 * (high - low)
    return min(low - margin, density.mean - reach), max(
        high + margin, density.mean + reach
    )


def _limits(density: ErrorDensity) -> tuple[float, ...]:
    """Return the limits near enough to be drawn, rising [SI]."""
    (low, high), limit = _reach(density), density.limit
    both = () if limit is None else (-limit, limit)
    return tuple(
        x for x in both if abs(x - (low + high) / 2.0) <= FAR * (high - low) / 2.0
    )
