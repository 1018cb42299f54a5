"""Allan deviations of recordings, with bands, and the models that are told."""

from __future__ import annotations

from functools import partial
from itertools import groupby
from math import ceil, floor, log10
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from budget.names import AXES
from budget.report.figures.curves import name_lines
from budget.report.figures.style import (
    BLUE,
    GREEN,
    INK,
    VERMILION,
    Scale,
    add_plane,
    blank,
    house_style,
)
from budget.report.figures.tabled import Plot, alternative_of_curves
from budget.report.pages import figure
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from types import SimpleNamespace

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.recordings.records import AllanRow, Characterisation, SpectrumRow

T = TypeVar("T")
Look = dict[str, Any]  # of a line, as matplotlib has it

PAGE = "figures_recorded"
LOOKS: Mapping[str, tuple[str, str]] = dict(
    zip(AXES, ((BLUE, "-"), (VERMILION, "--"), (GREEN, ":")), strict=True)
)
ABOVE, HEIGHT, BELOW, LEFT, RIGHT = 16.0, 170.0, 34.0, 52.0, 40.0  # [pt]
CURVES = ("deviation", "interval_low", "interval_high", "model", "white", "slow")
SURE = 20.0  # degrees of freedom, of what the title says [1]
ROOM = 1.3  # beyond the ends of the curves [1]


def recorded_plots(found: Characterisation) -> list[Plot]:
    """Show the Allan deviation of each sensor, an axis a curve."""
    return [
        _plot(sensor, [*rows], is_warm=any(one.temperature for one in found.records))
        for sensor, rows in groupby(found.allan, key=lambda one: one.sensor)
    ]


def spectrum_plots(found: Characterisation) -> list[Plot]:
    """Show the spectrum of each sensor over that of its models, an axis a curve."""
    return [
        _spectrum(sensor, [*rows])
        for sensor, rows in groupby(found.spectrum, key=lambda one: one.sensor)
    ]


def _spectrum(sensor: str, rows: Sequence[SpectrumRow]) -> Plot:
    """Show the spectrum of one sensor over that of its models."""
    curves = {axis: [*own] for axis, own in groupby(rows, key=lambda one: one.axis)}
    told, table = figure(
        PAGE,
        "spectrum",
        sensor=sensor,
        axes=[*curves],
        worst=rows[first_largest([max(one.ratio, 1.0 / one.ratio) for one in rows])],
        rows=[
            (
                place,
                [
                    next((one for one in own if one.frequency == place), None)
                    for own in curves.values()
                ],
            )
            for place in sorted({one.frequency for one in rows})
        ],
    )
    return Plot(
        name=f"spectrum-{sensor}",
        said=told,
        table=table,
        draw=lambda: _draw_spectrum(curves, told),
        alt=alternative_of_curves(told.title, table),
    )


def _draw_spectrum(
    curves: Mapping[str, Sequence[SpectrumRow]], told: SimpleNamespace
) -> Figure:
    """Draw ratios over frequency."""
    every = [row for own in curves.values() for row in own]
    ratios = [one.ratio for one in every]

    def curve(axes: Axes, own: Sequence[SpectrumRow], look: Look) -> float:
        axes.plot([one.frequency for one in own], [one.ratio for one in own], **look)
        return own[-1].ratio

    log = partial(Scale, kind="log", most=9)
    return draw_axes(
        log(
            low=min(one.frequency for one in every) / ROOM,
            high=max(one.frequency for one in every) * ROOM,
            label=told.frequency_axis,
        ),
        log(
            low=min(0.3, min(ratios) / ROOM),
            high=max(3.0, max(ratios) * ROOM),
            label=told.axis,
        ),
        curves.items(),
        curve,
        zero=(1.0, 0.7),
    )


def _plot(sensor: str, rows: Sequence[AllanRow], *, is_warm: bool) -> Plot:
    """Show the Allan deviation of one sensor."""
    curves = {axis: [*own] for axis, own in groupby(rows, key=lambda one: one.axis)}
    taus = sorted({one.tau for own in curves.values() for one in own})
    sure = [one.tau for one in rows if one.edf >= SURE] or taus[:1]
    there = [one for one in rows if one.tau == max(sure)]
    worst = there[first_largest([one.deviation for one in there])]
    told, table = figure(
        PAGE,
        "recorded",
        sensor=sensor,
        axes=[*curves],
        worst=worst,
        rows=[
            (
                tau,
                [
                    next((one for one in own if one.tau == tau), None)
                    for own in curves.values()
                ],
            )
            for tau in taus
        ],
        scale=worst.si_per_unit,
        warm=is_warm,
    )
    return Plot(
        name=f"allan-{sensor}",
        said=told,
        table=table,
        draw=lambda: _draw(curves, told),
        alt=alternative_of_curves(told.title, table),
    )


def _draw(curves: Mapping[str, Sequence[AllanRow]], told: SimpleNamespace) -> Figure:
    """Draw points with bands, and the models as lines."""
    every = [row for own in curves.values() for row in own]
    scale = every[0].si_per_unit
    low = min(min(one.interval_low, one.model) for one in every) / scale / ROOM
    high = max(max(one.interval_high, one.model) for one in every) / scale * ROOM
    taus = [one.tau for one in every]

    def curve(axes: Axes, own: Sequence[AllanRow], look: Look) -> float:
        x, colour = [one.tau for one in own], look["color"]
        deviation, band_low, band_high, model, *parts = (
            np.array([getattr(one, name) for one in own]) / scale for name in CURVES
        )
        axes.fill_between(x, band_low, band_high, color=colour, alpha=0.2, linewidth=0)
        axes.plot(x, deviation, "o", markersize=2.6, color=colour, markeredgewidth=0.0)
        axes.plot(x, model, **look)
        for part in parts:
            axes.plot(x, part, color=colour, linewidth=0.5, alpha=0.6)
        return float(model[-1])

    log = partial(Scale, kind="log", most=9)
    return draw_axes(
        log(
            low=10.0 ** floor(log10(min(taus))),
            high=10.0 ** ceil(log10(max(taus))),
            label=told.time_axis,
        ),
        log(low=low, high=high, label=told.axis),
        curves.items(),
        curve,
        width=1.3,
    )


@house_style()
def draw_axes(
    x: Scale,
    y: Scale,
    curves: Iterable[tuple[str, T]],
    curve: Callable[[Axes, T, Look], float],
    *,
    zero: tuple[float, float] | None = None,
    width: float = 1.1,
) -> Figure:
    """Draw a curve for each axis of a sensor, named where it ends, as `curve` says.

    `zero` is where a line stands that they are held against, and how wide it is.
    """
    drawing = blank(ABOVE + HEIGHT + BELOW)
    axes = add_plane(drawing, x, y, left=LEFT, top=ABOVE, right=RIGHT, height=HEIGHT)
    if zero is not None:
        axes.axhline(zero[0], color=INK, linewidth=zero[1])
    ends = []
    looks: dict[str, Look] = {}
    for axis, own in curves:
        colour, dash = LOOKS[axis]
        look = looks[axis] = {"color": colour, "linestyle": dash, "linewidth": width}
        ends.append((curve(axes, own, look), axis))
    name_lines(axes, ends, looks)
    axes.spines[:].set_color(INK)
    return drawing
