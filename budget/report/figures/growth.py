"""How an error of a mission grows against its limits, and what makes it when."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import ceil, floor, log, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.known import Known
from budget.language import say
from budget.names import LENGTHS, MISSION, SPANS, time_text
from budget.report.figures.curves import name_lines
from budget.report.figures.style import (
    GRID,
    INK,
    OTHER,
    PAPER,
    WIDTH,
    Scale,
    add_plane,
    blank,
    look_of,
    text_width,
    write,
)
from budget.report.figures.tabled import Plot, alternative_of_curves, column_tips
from budget.report.pages import figure, line
from budget.report.tables import (
    UNITS,
    full_title,
    length,
    round_uncertainty,
    unit_for,
)
from budget.results import CEP, R95
from budget.ties import first_largest, from_largest
from budget.units import DEGREE

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.report.tables import Unit
    from budget.results import JudgedOutput
    from budget.studies.mission import Curve

# Heights of the errors, of the strip of shares, and what is around them [pt].
ABOVE, ERRORS, BETWEEN, STRIP, BELOW = 12.0, 140.0, 12.0, 104.0, 34.0
LEFT, RIGHT = 64.0, 106.0  # [pt]
MOST_DIGITS = 11  # of a time
SHOWN = 4  # sources with an area of their own
LEAST = 0.02  # of the variance at any time, to be one of them [1]
REACH = 1e7  # of the vertical axis: below the largest by more nothing is seen [1]
AREA = 0.12  # of the variance, for a name within its area [1]
HOUR, MINUTE = 3600.0, 60.0  # [s]
TICKS = (  # [s]
    *(1.0, 2.0, 5.0, 10.0, 30.0),
    *(MINUTE * n for n in (1.0, 2.0, 5.0, 10.0, 30.0)),
    *(HOUR * n for n in (1.0, 2.0, 5.0, 10.0, 24.0)),
)
TICK_ROOM = 0.18  # of the axis of times, for one of them [1]
MOST_TICKS = 6  # of an even axis of times
AIDED = 0.5  # opacity behind the times with aids
PLANE = ("position", LENGTHS["position"])
PAGE = "figures_growth"
said = partial(line, PAGE)


@dataclass(frozen=True, kw_only=True)
class ErrorGrowth:
    """One error of a mission over time, with what is drawn of it."""

    curve: Curve
    error: tuple[str, str]  # quantity and axis
    sizes: dict[str, Array]  # by their names, the largest first, shape (n_times,) [SI]
    sources: tuple[Name, ...]  # those with an area of their own
    shares: Array  # of them, then of all others together, (n + 1, n_times) [1]

    @classmethod
    def of(cls, curve: Curve, error: tuple[str, str] = PLANE) -> ErrorGrowth | None:
        """Choose the sources that are largest at some time; None if nothing varies."""
        variance = curve.variance(*error)
        total = variance.sum(axis=0)
        if not (total > 0.0).all():
            return None
        shares = variance / total
        most = shares.max(axis=1)
        order = [k for k in from_largest(most.tolist()) if most[k] >= LEAST][:SHOWN]
        own = shares[order]
        is_plane = LENGTHS.get(error[0]) == error[1]
        names = {"R95": R95, "CEP": CEP} if is_plane else {"U95": R95}
        return cls(
            curve=curve,
            error=error,
            sizes={name: curve.reach(part, *error) for name, part in names.items()},
            sources=tuple(curve.sources[k] for k in order),
            shares=np.vstack([own, np.delete(shares, order, axis=0).sum(axis=0)]),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Titles of the sources, and of all others together."""
        return (*map(full_title, self.sources), said("others"))

    @property
    def title(self) -> str:
        """'horizontal position', 'heading'."""
        quantity, axis = self.error
        return say(axis if quantity == "attitude" else f"{axis} {quantity}")

    @property
    def unit(self) -> Unit:
        """What its size at the end is read in."""
        quantity, axis = self.error
        like = axis if axis in UNITS else quantity
        return unit_for(like, float(next(iter(self.sizes.values()))[-1]))

    @property
    def is_more(self) -> bool:
        """Whether its sizes are lower bounds: a specification that reaches it lacks."""
        return self.error in self.curve.lower_bounds

    def printed(self, size: float) -> str:
        """Print one of its sizes [SI], a length in the unit that it is read in."""
        unit, scale = self.unit
        is_length = self.error[0] == "position"
        text = (
            length(size) if is_length else f"{round_uncertainty(size / scale)} {unit}"
        )
        return Known.at_least(size).written(text) if self.is_more else text


def growth_pictures(
    curve: Curve, limits: Sequence[JudgedOutput] = ()
) -> tuple[Picture, ...]:
    """Return a figure of the horizontal position and of each other limited error.

    Without those in which nothing varies.
    """
    names = (row.output.name for row in limits if row.output.name.owner == MISSION)
    errors = dict.fromkeys((PLANE, *((name.quantity, name.axis) for name in names)))
    every = (ErrorGrowth.of(curve, error) for error in errors)
    return tuple(growth_plot(one, limits).picture for one in every if one is not None)


def growth_plot(growth: ErrorGrowth, limits: Sequence[JudgedOutput] = ()) -> Plot:
    """Show an error over time against its limits, and below it who makes it when.

    Shares are of the variance: they alone add up.
    """
    curve = growth.curve
    own = [
        row
        for row in limits
        if (row.output.name.quantity, row.output.name.axis) == growth.error
        and row.output.name.owner == MISSION
    ]
    name = "-".join(
        ("mission-growth", *(growth.error if growth.error != PLANE else ()))
    )
    last = growth.shares[:-1, -1].tolist()
    top = first_largest(last) if last else 0
    told, table = figure(
        PAGE,
        "growth",
        name=name,
        growth=growth,
        curve=curve,
        scale=growth.unit[1],
        rows=[
            (time, [sizes[k] for sizes in growth.sizes.values()], growth.shares[:, k])
            for k, time in enumerate(times_apart(curve.times))
        ],
        source=growth.names[top],
        share=growth.shares[top, -1],
        limits=own,
    )
    more = [said("limit_said", row=row) for row in own]
    return Plot(
        name=name,
        said=told,
        table=table,
        draw=lambda: _draw(growth, own, told),
        tips=column_tips(table),
        alt=alternative_of_curves(told.title, table, more),
    )


def _draw(
    growth: ErrorGrowth, limits: Sequence[JudgedOutput], told: SimpleNamespace
) -> Figure:
    """Draw sizes and limits on a logarithmic axis, and shares below on one of time."""
    drawing = blank(ABOVE + ERRORS + BETWEEN + STRIP + BELOW)
    x, spans = np.array(growth.curve.times), growth.curve.measured
    every = np.array([*growth.sizes.values()])
    largest = max(float(every.max()), *(one.limit for one in limits), 0.0)
    low, high = max(float(every.min()) / 2.0, largest / REACH), 2.0 * largest
    ticks = time_ticks(x[0], x[-1], is_even=bool(spans))
    times = Scale(low=x[0], high=x[-1], kind="linear" if spans else "log", ticks=ticks)
    sizes = Scale(
        low=low,
        high=high,
        kind="log",
        ticks=size_ticks(low, high, growth.error[0]),
        label=told.error_axis,
    )
    plane = partial(add_plane, drawing, left=LEFT, right=RIGHT)
    unnamed = replace(times, ticks=tuple((at, "") for at, _ in ticks))
    axes = plane(unnamed, sizes, top=ABOVE, height=ERRORS)
    for begin, end in spans:
        if end > x[0]:
            axes.axvspan(
                max(begin, x[0]),
                end,
                zorder=0.0,
                color=GRID,
                alpha=AIDED,
                linewidth=0.0,
            )
    for k, one in enumerate(every, start=1):
        axes.plot(x, one, color=INK, linewidth=1.0 + 0.8 * (k == 1), gid=f"curve-{k}")
    for row in limits:
        at = (row.output.name.time or 0.0, row.limit)
        axes.plot(*at, "D", clip_on=False, zorder=4.0, **LIMIT)
        is_early = at[0] < sum(axes.get_xlim()) / 2.0
        shift, side = (8.0, "left") if is_early else (-8.0, "right")
        write(
            axes, row.printed_limit, at, (shift, 0.0), ha=side, va="center", **PAPERED
        )
    name_lines(axes, [(float(one[-1]), name) for name, one in growth.sizes.items()])
    shares = Scale(low=0.0, high=100.0, label=told.share_axis)
    named = replace(times, label=told.time_axis)
    axes = plane(named, shares, top=ABOVE + ERRORS + BETWEEN, height=STRIP)
    for time in {time for span in spans for time in span if x[0] < time < x[-1]}:
        axes.axvline(time, color=INK, linewidth=0.8, linestyle=":")
    _draw_shares(axes, growth)
    return drawing


def _draw_shares(axes: Axes, growth: ErrorGrowth) -> None:
    """Draw areas one upon the other, the largest source at the bottom."""
    x = np.array(growth.curve.times)
    shares = 100.0 * np.maximum(growth.shares, 0.0)
    ends = np.vstack([np.zeros(x.size), np.cumsum(shares, axis=0)])
    beside: list[tuple[float, str]] = []
    for k, (name, source) in enumerate(
        zip(growth.names, (*growth.sources, OTHER), strict=True)
    ):
        colour, hatch, _ = look_of(source, is_both=True)
        axes.fill_between(
            x,
            *ends[k : k + 2],
            facecolor=colour,
            edgecolor=PAPER,
            linewidth=0.8,
            hatch=hatch,
            gid=f"curve-{1 + len(growth.sizes) + k}",
        )
        peak, middle = int(np.argmax(shares[k])), ends[k : k + 2].mean(axis=0)
        if shares[k, -1] >= 100.0 * LEAST:
            beside.append((float(middle[-1]), name))
        elif shares[k, peak] >= 100.0 * AREA:
            inner = max(peak, x.size // 8)
            at = (float(x[inner]), float(middle[inner]))
            left = (axes.transData + axes.transAxes.inverted()).transform(at)[0]
            room = (WIDTH - LEFT - RIGHT) * (1.0 - left) - text_width(name) - AIR
            write(axes, name, at, (min(room, 0.0), 0.0), va="center", **PAPERED)
    name_lines(axes, beside)


AIR = 4.0  # between a name and the edge [pt]
LIMIT: dict[str, Any] = {"color": PAPER, "markeredgecolor": INK, "markersize": 5.5}
PAPERED: dict[str, Any] = {"paper": 0.85, "pad": 1.5}  # of a text over lines and areas


def time_ticks(
    low: float, high: float, *, is_even: bool
) -> tuple[tuple[float, str], ...]:
    """Tick an axis of times at round ones."""
    ticks: list[float] = []
    if is_even:
        step = next((t for t in TICKS if MOST_TICKS * t >= high - low), TICKS[-1])
        ticks = (step * np.arange(ceil(low / step), floor(high / step) + 1.0)).tolist()
    for time in () if is_even else reversed(TICKS):
        is_apart = not ticks or log(ticks[-1] / time) >= TICK_ROOM * log(high / low)
        ticks += [time] if low <= time <= high and is_apart else []
    return tuple((time, time_text(time)) for time in ticks)


def size_ticks(low: float, high: float, quantity: str) -> tuple[tuple[float, str], ...]:
    """Tick a logarithmic axis at powers of ten, in units that one reads."""
    units = DECADES[quantity]
    base = units[-1][1] if quantity == "attitude" else 1.0
    powers = range(ceil(log10(low / base)), floor(log10(high / base)) + 1)
    ticks = []
    for size in (base * 10.0**k for k in powers[:: ceil(len(powers) / MOST_POWERS)]):
        fitting = [*(own for own in units if size >= 0.999 * own[1]), units[-1]]
        ticks.append((size, f"{size / fitting[0][1]:g} {fitting[0][0]}"))
    return tuple(ticks)


MOST_POWERS = 7  # on an axis


def times_apart(times: Sequence[float]) -> list[str]:
    """Print times [s] to two digits, to more where one would look like another."""

    def around(time: float, digits: int) -> str:
        unit, size = next(own[:2] for own in SPANS if time >= own[1] or own[1] == 1.0)
        return f"{float(f'{time / size:.{digits}g}'):.10g} {unit}"

    texts = [[around(time, k) for time in times] for k in range(2, MOST_DIGITS)]
    return [
        next((own[k] for own in texts if own.count(own[k]) == 1), time_text(time))
        for k, time in enumerate(times)
    ]


DECADES = {
    "position": (("km", 1e3), ("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)),
    "velocity": (("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3)),
    "attitude": (("deg", DEGREE),),
}
