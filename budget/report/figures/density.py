"""Densities of the errors of the critical outputs, against their limits."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.known import Known
from budget.report.figures.style import (
    BLUE,
    INK,
    MUTED,
    SMALL,
    WIDTH,
    as_picture,
    canvas,
    house_style,
    text_width,
    without_name,
    write,
)
from budget.report.pages import blocks, line
from budget.report.tables import (
    Number,
    print_coverage,
    print_given,
    round_error,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.studies.densities import Density

LEFT, RIGHT, TOP, BELOW = 12.0, 12.0, 16.0, 34.0  # [pt]
HEIGHT = 156.0  # [pt]
STRIP = 0.3  # height of the intervals below the density, over its peak [1]
FAR = 2.2  # a limit beyond so many times the reach of the trials is not drawn [1]
REACH = 3.6  # of the picture, in standard uncertainties at least [1]
AIR = 6.0  # between words [pt]
POINTS = 161  # of the normal law
INSIDE, BEYOND = 0.28, 0.75  # opacities of the one hue, within the limits and not
said = partial(line, "figures_density")


@house_style()
def density_picture(density: Density, *, coverage: float) -> Picture:
    """Return the density of one output as a block, with its numbers as a table."""
    limit, title = _limit(density), density_title(density, coverage=coverage)
    data: Any = blocks(
        "figures_density",
        "data",
        density=density,
        coverage=coverage,
        limit=limit,
        scale=density.output.si_per_unit,
        marked=partial(_marked, density),
    )[0]
    return as_picture(
        density_step(density, coverage=coverage),
        name=f"density-{density.output.name}",
        title=title,
        alt=said(
            "alt",
            density=density,
            coverage=coverage,
            title=title,
            limit=limit,
            rounded=partial(_round, density),
        ),
        caption=said(
            "caption",
            density=density,
            limit=limit,
            is_far=density.limit is not None and not _limits(density),
        ),
        data=data,
        data_on_paper=False,
    )


@house_style()
def density_step(density: Density, *, coverage: float) -> Figure:
    """Draw the density of trials, the normal law over it, intervals and limits."""
    figure, axes = canvas(HEIGHT, left=LEFT, right=RIGHT, top=TOP, below=BELOW)
    figure.set_label(density_title(density, coverage=coverage))
    scale = density.output.si_per_unit
    low, high = _view(density)
    limits = _limits(density)
    axes.set_xlim(low / scale, high / scale)
    x = np.linspace(low, high, POINTS)
    law = np.exp(-0.5 * ((x - density.mean) / density.u) ** 2)
    law /= density.u * np.sqrt(2.0 * np.pi)
    peak = max(float(density.density.max()), float(law.max()))
    axes.set_ylim(-STRIP, 1.04)
    axes.set_yticks([])
    without_name(axes.yaxis)
    far = np.inf if density.limit is None else density.limit
    for ends, opacity in (
        ((-far, far), INSIDE),
        ((-np.inf, -far), BEYOND),
        ((far, np.inf), BEYOND),
    ):
        edges = np.clip(density.edges, *ends)  # bins that are not there have no width
        if edges[0] < edges[-1]:
            axes.stairs(
                density.density / peak,
                edges / scale,
                fill=True,
                facecolor=BLUE,
                alpha=opacity,
                linewidth=0.0,
            )
    axes.plot(x / scale, law / peak, color=INK, linewidth=1.1)
    axes.plot([low / scale, high / scale], [0.0, 0.0], color=MUTED, linewidth=0.6)
    share = f"{print_coverage(coverage)} %"
    for y, ends, colour, text in (
        (-0.09, density.interval, INK, said("law")),
        (-0.21, density.interval_mc, BLUE, said("trials")),
    ):
        at = (ends[0] / scale, ends[1] / scale)
        _draw_interval(axes, y, at, colour, (share, text))
    room = (text_width(said("limit")) + AIR) * (high - low)
    are_near = len(limits) > 1 and 2.0 * far * (WIDTH - LEFT - RIGHT) < room
    for limit in limits:
        side = "center"
        if are_near:
            side = "right" if limit < 0.0 else "left"
        _draw_limit(axes, limit / scale, side=side)
    axes.locator_params(axis="x", nbins=7, steps=[1, 2, 5, 10])
    axes.set_xticks([x for x in axes.get_xticks() if low <= x * scale <= high])
    axes.set_xlabel(said("axis", output=density.output), fontsize=SMALL, color=MUTED)
    return figure


def density_title(density: Density, *, coverage: float) -> str:
    """State the finding: how often the limit is exceeded, or where the errors lie."""
    return said(
        "title",
        density=density,
        coverage=coverage,
        beyond=part_beyond(density),
        rounded=partial(_round, density),
    )


def part_beyond(density: Density) -> float:
    """Return the part of trials beyond the limit; a bin that it cuts counts in part."""
    if density.limit is None:
        return 0.0
    ends = np.clip(density.edges, -density.limit, density.limit)
    # Bins within the limits keep their width, those beyond have none left.
    lost = np.diff(density.edges) - np.diff(ends)
    return float((density.density * lost).sum())


def _draw_interval(
    axes: Axes, y: float, ends: tuple[float, float], colour: str, names: tuple[str, str]
) -> None:
    """Draw one coverage interval, its coverage on the left, its method on the right."""
    axes.plot(ends, [y, y], color=colour, linewidth=3.0, solid_capstyle="butt")
    for end, name, shift, side in zip(
        ends, names, (-4.0, 4.0), ("right", "left"), strict=True
    ):
        write(axes, name, (end, y), (shift, 0.0), ha=side)


def _draw_limit(axes: Axes, x: float, *, side: str) -> None:
    """Draw one limit as a line with its name above."""
    axes.plot(
        [x, x], [0.0, 1.04], color=INK, linewidth=1.0, linestyle=(0.0, (5.0, 2.0))
    )
    write(axes, said("limit"), (x, 1.04), (0.0, 3.0), ha=side, va="baseline")


def _reach(density: Density) -> tuple[float, float]:
    """Return the range where trials and law can be seen [SI]."""
    low, high = density.interval_mc
    margin = 0.4 * (high - low)
    return (
        min(low - margin, density.mean - REACH * density.u),
        max(high + margin, density.mean + REACH * density.u),
    )


def _limits(density: Density) -> tuple[float, ...]:
    """Return the limits near enough to be drawn [SI]."""
    if density.limit is None:
        return ()
    low, high = _reach(density)
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    both = (-density.limit, density.limit)
    return tuple(limit for limit in both if abs(limit - middle) <= FAR * half)


def _view(density: Density) -> tuple[float, float]:
    """Return the range that is drawn, with the limits that are near [SI]."""
    ends = (*_reach(density), *_limits(density))
    air = 0.02 * (max(ends) - min(ends))
    return min(ends) - air, max(ends) + air


def _marked(
    density: Density, value: float, *, is_mean: bool = False, is_end: bool = False
) -> Number:
    """Round a mean, a lower end or another number, which lines not given would move."""
    known = Known.of(value, () if is_mean else density.lacks)
    return round_error(known.falling if is_end else known, density.u, density.output)


def _round(density: Density, value: float) -> str:
    """Round a value of the output to its uncertainty, in its unit."""
    return round_error(value, density.u, density.output).text


def _limit(density: Density) -> str:
    """Write the limit as it was given, in the unit of the output."""
    limit = 0.0 if density.limit is None else density.limit
    return print_given(limit / density.output.si_per_unit)
