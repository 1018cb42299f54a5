"""Densities of the errors of the critical outputs, against their limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.language import key_title, say
from budget.report.blocks import Field, table_of
from budget.report.figures.style import (
    BLUE,
    INK,
    MUTED,
    SMALL,
    WIDTH,
    as_picture,
    canvas,
    house_style,
    kebab,
    text_width,
    without_name,
    write,
)
from budget.report.tables import (
    AT_LEAST,
    AT_MOST,
    Number,
    bound_number,
    print_count,
    print_coverage,
    print_given,
    print_share,
    round_error,
    source_title,
)
from budget.report.wording import capital, cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture, Table
    from budget.studies.densities import Density

LEFT, RIGHT, TOP, BELOW = 12.0, 12.0, 16.0, 34.0  # [pt]
HEIGHT = 156.0  # [pt]
STRIP = 0.3  # height of the intervals below the density, over its peak [1]
FAR = 2.2  # a limit beyond so many times the reach of the trials is not drawn [1]
REACH = 3.6  # of the picture, in standard uncertainties at least [1]
AIR = 6.0  # between words [pt]
POINTS = 161  # of the normal law
INSIDE, BEYOND = 0.28, 0.75  # opacities of the one hue, within the limits and not


@house_style()
def density_picture(density: Density, *, coverage: float) -> Picture:
    """Return the density of one output as a block, with its numbers as a table."""
    return as_picture(
        density_step(density, coverage=coverage),
        name=f"density-{density.output.name}",
        title=density_title(density, coverage=coverage),
        alt=density_alt(density, coverage=coverage),
        caption=_caption(density),
        data=_data(density, coverage=coverage),
        data_on_paper=False,
    )


@house_style()
def density_step(density: Density, *, coverage: float) -> Figure:
    """Draw the density of trials, the normal law over it, intervals and limits."""
    figure, axes = canvas(HEIGHT, left=LEFT, right=RIGHT, top=TOP, below=BELOW)
    figure.set_label(density_title(density, coverage=coverage))
    unit, scale = density.output.unit, density.output.si_per_unit
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
        (-0.09, density.interval, INK, say("law")),
        (-0.21, density.interval_mc, BLUE, say("Monte Carlo")),
    ):
        at = (ends[0] / scale, ends[1] / scale)
        _draw_interval(axes, y, at, colour, (share, text))
    room = (text_width(say("limit")) + AIR) * (high - low)
    are_near = len(limits) > 1 and 2.0 * far * (WIDTH - LEFT - RIGHT) < room
    for limit in limits:
        side = "center"
        if are_near:
            side = "right" if limit < 0.0 else "left"
        _draw_limit(axes, limit / scale, side=side)
    axes.locator_params(axis="x", nbins=7, steps=[1, 2, 5, 10])
    axes.set_xticks([x for x in axes.get_xticks() if low <= x * scale <= high])
    axes.set_xlabel(
        say(
            "error of the {name} [{unit}]",
            name=key_title(density.output.name),
            unit=unit,
        ),
        fontsize=SMALL,
        color=MUTED,
    )
    return figure


def density_title(density: Density, *, coverage: float) -> str:
    """State the finding: how often the limit is exceeded, or where the errors lie."""
    more = say(", this or more: lines are missing") if density.lacks else ""
    return f"{_finding(density, coverage=coverage)}{more}"


def _finding(density: Density, *, coverage: float) -> str:
    """State it as if all lines were given."""
    name = capital(key_title(density.output.name))
    if density.limit is None:
        low, high = (_round(density, end) for end in density.interval_mc)
        return say(
            "{name}: {coverage} % of the errors lie between {low} and {high} {unit}",
            name=name,
            coverage=print_coverage(coverage),
            low=low,
            high=high,
            unit=density.output.unit,
        )
    beyond = part_beyond(density)
    if beyond == 0.0:
        return say(
            "{name} exceeds its limit in none of {trials} trials",
            name=name,
            trials=print_count(density.trials),
        )
    return say(
        "{name} exceeds its limit in {beyond} of the trials",
        name=name,
        beyond=print_share(beyond),
    )


def density_alt(density: Density, *, coverage: float) -> str:
    """Say in words with numbers what the density shows."""
    unit = density.output.unit
    share = print_coverage(coverage)
    law, trials = (
        say(
            "{low} to {high} {unit}",
            low=_round(density, ends[0]),
            high=_round(density, ends[1]),
            unit=unit,
        )
        for ends in (density.interval, density.interval_mc)
    )
    text = say(
        "{density_title}. Density of {trials} trials with the "
        "normal law over it; {share} % interval by the law {law}, "
        "by Monte Carlo {sampled}",
        density_title=density_title(density, coverage=coverage),
        trials=print_count(density.trials),
        share=share,
        law=law,
        sampled=trials,
    )
    if density.limit is not None:
        text += say(
            "; limits at plus and minus {limit} {unit}",
            limit=_limit(density),
            unit=unit,
        )
    return say("{text}.", text=text)


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
    write(axes, say("limit"), (x, 1.04), (0.0, 3.0), ha=side, va="baseline")


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


def _caption(density: Density) -> str:
    """Say where the limits are if they are not drawn, and what is not given."""
    text = ""
    if density.limit is not None and not _limits(density):
        both = f"\N{PLUS-MINUS SIGN}{_limit(density)} {density.output.unit}"
        text += say(" The limits, {both}, are beyond the figure.", both=both)
    if density.lacks:
        titles = say(", ").join(map(source_title, density.lacks))
        text += say(
            " Not given, so that it is this wide or wider: {titles}.", titles=titles
        )
    return text.lstrip()


def _marked(density: Density, value: float, sign: str) -> Number:
    """Round a value, and mark it where lines that are not given would move it."""
    number = round_error(value, density.u, density.output)
    return bound_number(number, lower_bound=bool(density.lacks), sign=sign)


def _round(density: Density, value: float) -> str:
    """Round a value of the output to its uncertainty, in its unit."""
    return round_error(value, density.u, density.output).text


def _limit(density: Density) -> str:
    """Write the limit as it was given, in the unit of the output."""
    limit = 0.0 if density.limit is None else density.limit
    return print_given(limit / density.output.si_per_unit)


def _data(density: Density, *, coverage: float) -> Table:
    """Return what the figure shows in numbers."""
    scale = density.output.si_per_unit
    share = print_coverage(coverage)
    named = [
        (say("mean, by the law"), density.mean, ""),
        (say("u, by the law"), density.u, AT_LEAST),
        (
            say("{share} % interval by the law, from", share=share),
            density.interval[0],
            AT_MOST,
        ),
        ("to", density.interval[1], AT_LEAST),
        (
            say("{share} % interval by Monte Carlo, from", share=share),
            density.interval_mc[0],
            AT_MOST,
        ),
        ("to", density.interval_mc[1], AT_LEAST),
    ]
    rows = [(name, _marked(density, x, sign)) for name, x, sign in named]
    if density.limit is not None:
        limit = Number(text=_limit(density), exact=density.limit / scale)
        rows.append((say("limit on the absolute error"), limit))
    return table_of(
        rows,
        (
            Field(head="", cell=lambda row: row[0]),
            Field(
                head=say("error [{unit}]", unit=density.output.unit),
                kind="number",
                cell=lambda row: cell(row[1]),
            ),
        ),
        name=kebab(f"density-{density.output.name}-data"),
        caption=say("Distribution of the {name}", name=key_title(density.output.name)),
    )
