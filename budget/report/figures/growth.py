"""How an error of a mission grows against its limits, and what makes it when."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import ceil, floor, log, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.language import say
from budget.model.source import ACCELEROMETER
from budget.names import LENGTHS, MISSION, SPANS, time_text
from budget.report.figures.lines import name_lines, on_paper
from budget.report.figures.style import (
    GRID,
    HATCH,
    INK,
    MUTED,
    OTHER,
    PAPER,
    SMALL,
    WIDTH,
    add_panel,
    as_picture,
    blank,
    house_style,
    look_of,
    text_width,
)
from budget.report.pages import blocks, line
from budget.report.tables import (
    AT_LEAST,
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

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.report.tables import Unit
    from budget.results import OutputAssessment
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
said = partial(line, "figures_growth")


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
        return f"{AT_LEAST} {text}" if self.is_more else text


def growth_pictures(
    curve: Curve, limits: Sequence[OutputAssessment] = ()
) -> tuple[Picture, ...]:
    """Return a figure of the horizontal position and of each other limited error.

    Without those in which nothing varies.
    """
    names = (row.output.name for row in limits if row.output.name.owner == MISSION)
    errors = dict.fromkeys((PLANE, *((name.quantity, name.axis) for name in names)))
    every = (ErrorGrowth.of(curve, error) for error in errors)
    return tuple(growth_picture(one, limits) for one in every if one is not None)


def growth_picture(
    growth: ErrorGrowth, limits: Sequence[OutputAssessment] = ()
) -> Picture:
    """Show an error over time against its limits, and below it who makes it when.

    Shares are of the variance: they alone add up.
    """
    curve, own = growth.curve, _limits_on(growth, limits)
    name = "-".join(
        ("mission-growth", *(growth.error if growth.error != PLANE else ()))
    )
    title, tips = growth_title(growth), _tips(growth)
    times = times_apart(curve.times)
    rows = zip(
        times,
        *growth.sizes.values(),
        growth.shares.T,
        strict=True,
    )
    data: Any = blocks(
        "figures_growth",
        "data",
        name=name,
        growth=growth,
        scale=growth.unit[1],
        rows=[(after, sizes, shares) for after, *sizes, shares in rows],
    )[0]
    return as_picture(
        draw_growth(growth, limits),
        name=name,
        title=title,
        alt=said(
            "alt",
            title=title,
            first=times[0],
            end=curve.times[-1],
            parts=(*tips.values(), *(said("limit_said", row=row) for row in own)),
        ),
        tips=tips,
        caption=said(
            "caption",
            has_limits=bool(own),
            has_aids=bool(curve.measured),
            is_more=growth.is_more,
            is_predicted=curve.mixture is not None,
        ),
        data=data,
        data_on_paper=False,
    )


def growth_title(growth: ErrorGrowth) -> str:
    """State the finding: how far off at the end, and what makes most of it."""
    last = growth.shares[:-1, -1].tolist()
    top = first_largest(last) if last else 0
    name = list(growth.sizes)[-1]
    return said(
        "title",
        growth=growth,
        name=name,
        size=growth.printed(growth.sizes[name][-1]),
        end=growth.curve.times[-1],
        source=growth.names[top],
        share=growth.shares[top, -1],
    )


def _tips(growth: ErrorGrowth) -> dict[str, str]:
    """Say where each line begins and ends, and of each area its shares."""
    lines = {
        f"line-{name.lower()}": said(
            "line_tip",
            name=name,
            low=growth.printed(sizes[0]),
            high=growth.printed(sizes[-1]),
        )
        for name, sizes in growth.sizes.items()
    }
    areas = {
        f"area-{k}": said("area_tip", name=name, shares=shares)
        for k, (name, shares) in enumerate(
            zip(growth.names, growth.shares, strict=True)
        )
        if shares.any()
    }
    return lines | areas


def times_apart(times: Sequence[float]) -> list[str]:
    """Print times [s] to two digits, to more where one would look like another."""
    texts = {k: [_around(time, k) for time in times] for k in range(2, MOST_DIGITS)}
    return [
        next((own[k] for own in texts.values() if own.count(own[k]) == 1), time_text(t))
        for k, t in enumerate(times)
    ]


def _around(time: float, digits: int) -> str:
    """Print a time to some digits."""
    unit, size = next(
        (unit, size) for unit, size, _ in SPANS if time >= size or size == 1.0
    )
    return f"{float(f'{time / size:.{digits}g}'):.10g} {unit}"


def _limits_on(
    growth: ErrorGrowth, limits: Sequence[OutputAssessment]
) -> list[OutputAssessment]:
    """Return the limits on this error."""
    return [
        row
        for row in limits
        if (row.output.name.quantity, row.output.name.axis) == growth.error
        and row.output.name.owner == MISSION
    ]


@house_style()
def draw_growth(growth: ErrorGrowth, limits: Sequence[OutputAssessment] = ()) -> Figure:
    """Draw sizes and limits on a logarithmic axis, and shares below on one of time."""
    figure = blank(ABOVE + ERRORS + BETWEEN + STRIP + BELOW)
    figure.set_label(growth_title(growth))
    width = WIDTH - LEFT - RIGHT
    top = ABOVE
    for height, draw_on, label in (
        (
            ERRORS,
            partial(_draw_errors, limits=_limits_on(growth, limits)),
            "error_axis",
        ),
        (STRIP, _draw_shares, "share_axis"),
    ):
        axes = add_panel(figure, left=LEFT, top=top, width=width, height=height)
        axes.tick_params(axis="y", labelsize=SMALL, labelcolor=MUTED)
        axes.grid(color=GRID, linewidth=0.6)
        axes.set_ylabel(said(label), fontsize=SMALL, color=MUTED)
        _across(axes, growth.curve)
        draw_on(axes, growth)
        _time_ticks(axes)
        top += height + BETWEEN
    figure.axes[0].tick_params(labelbottom=False)
    how = "even" if growth.curve.measured else "log"
    axes.set_xlabel(said("time_axis", how=how), fontsize=SMALL, color=MUTED)
    return figure


def _draw_errors(
    axes: Axes, growth: ErrorGrowth, *, limits: Sequence[OutputAssessment]
) -> None:
    """Draw how large the error is, and what it may be when."""
    x = np.array(growth.curve.times)
    every = growth.sizes.values()
    largest = max([float(one.max()) for one in every] + [row.limit for row in limits])
    least = min(float(one.min()) for one in every)
    for begin, end in growth.curve.measured:
        if end > x[0]:
            axes.axvspan(
                max(begin, x[0]),
                end,
                color=GRID,
                alpha=AIDED,
                linewidth=0.0,
                zorder=0.0,
            )
    axes.set_yscale("log")
    axes.set_ylim(max(least / 2.0, largest / REACH), 2.0 * largest)
    for width, (name, sizes) in zip((1.8, 1.0), growth.sizes.items(), strict=False):
        axes.plot(x, sizes, color=INK, linewidth=width, gid=f"line-{name.lower()}")
    for row in limits:
        at = (row.output.name.time or 0.0, row.limit)
        axes.plot(
            *at,
            marker="D",
            color=PAPER,
            markeredgecolor=INK,
            markersize=5.5,
            clip_on=False,
            zorder=4.0,
        )
        is_early = at[0] < sum(axes.get_xlim()) / 2.0
        ends = (8.0, "left") if is_early else (-8.0, "right")
        on_paper(axes, row.printed_limit, at, (ends[0], 0.0), ha=ends[1])
    name_lines(axes, [(float(sizes[-1]), name) for name, sizes in growth.sizes.items()])
    _size_ticks(axes, growth.error[0])


def _draw_shares(axes: Axes, growth: ErrorGrowth) -> None:
    """Draw areas one upon the other, the largest source at the bottom."""
    x = np.array(growth.curve.times)
    for time in {time for span in growth.curve.measured for time in span}:
        if x[0] < time < x[-1]:
            axes.axvline(time, color=INK, linewidth=0.8, linestyle=":")
    axes.set_ylim(0.0, 100.0)
    below = np.zeros(x.size)
    names: list[tuple[float, str]] = []
    for k, name in enumerate(growth.names):
        shares = 100.0 * np.maximum(growth.shares[k], 0.0)
        source = growth.sources[k] if k < len(growth.sources) else OTHER
        colour, hatch, _ = look_of(source)
        axes.fill_between(
            x,
            below,
            below + shares,
            facecolor=colour,
            edgecolor=PAPER,
            linewidth=0.8,
            hatch=hatch or (HATCH if source.owner == ACCELEROMETER else ""),
            gid=f"area-{k}",
        )
        peak = int(np.argmax(shares))
        if shares[-1] >= 100.0 * LEAST:
            names.append((float(below[-1] + shares[-1] / 2.0), name))
        elif shares[peak] >= 100.0 * AREA:
            inner = max(peak, x.size // 8)
            place, middle = float(x[inner]), float((below + shares / 2.0)[inner])
            room = WIDTH - LEFT - RIGHT - text_width(name) - AIR
            at = (WIDTH - LEFT - RIGHT) * _across_part(axes, place)
            on_paper(axes, name, (place, middle), (min(room - at, 0.0), 0.0))
        below = below + shares
    name_lines(axes, names)


AIR = 4.0  # between a name and the edge [pt]


def _across_part(axes: Axes, time: float) -> float:
    """Return how far across the axes a time is [1]."""
    to_axes = axes.transData + axes.transAxes.inverted()
    return float(to_axes.transform((time, 0.0))[0])


def _across(axes: Axes, curve: Curve) -> None:
    """Set up the axis of times: logarithmic, and even where aids end on the way."""
    axes.set_xscale("linear" if curve.measured else "log")
    axes.set_xlim(curve.times[0], curve.times[-1])


def _time_ticks(axes: Axes) -> None:
    """Tick an axis of times at round ones."""
    low, high = axes.get_xlim()
    if axes.get_xscale() == "linear":
        step = next((t for t in TICKS if MOST_TICKS * t >= high - low), TICKS[-1])
        times = step * np.arange(ceil(low / step), floor(high / step) + 1.0)
        axes.set_xticks(times, list(map(time_text, times.tolist())))
        return
    ticks: list[float] = []
    for time in reversed([t for t in TICKS if low <= t <= high]):
        if not ticks or log(ticks[-1] / time) >= TICK_ROOM * log(high / low):
            ticks.append(time)
    axes.set_xticks(ticks, list(map(time_text, ticks)))
    axes.minorticks_off()


def _size_ticks(axes: Axes, quantity: str) -> None:
    """Tick a logarithmic axis at powers of ten, in units that one reads."""
    low, high = axes.get_ylim()
    units = DECADES[quantity]
    base = units[-1][1] if quantity == "attitude" else 1.0
    powers = range(ceil(log10(low / base)), floor(log10(high / base)) + 1)
    step = ceil(len(powers) / MOST_POWERS)
    sizes = [base * 10.0**power for power in powers[::step]]
    axes.set_yticks(sizes, [_decade(size, units) for size in sizes])
    axes.minorticks_off()


MOST_POWERS = 7  # on an axis


def _decade(size: float, units: Sequence[Unit]) -> str:
    """Print a power of ten in the unit that it is read in: '1 cm', '10 m', '1 km'."""
    unit, scale = next(
        ((unit, scale) for unit, scale in units if size >= 0.999 * scale), units[-1]
    )
    return f"{size / scale:g} {unit}"


DECADES = {
    "position": (("km", 1e3), ("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)),
    "velocity": (("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3)),
    "attitude": (("deg", DEGREE),),
}
