"""How the horizontal error of a mission grows, and which source makes it when."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import ceil, floor, log, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.names import LENGTHS, SPANS, time_text
from budget.report.figures.style import (
    INK,
    PAPER,
    SMALL,
    as_picture,
    house_style,
    look_of,
    plane,
    write,
)
from budget.report.pages import blocks, line
from budget.report.tables import full_title
from budget.results import CEP, R95
from budget.ties import from_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.results import OutputAssessment
    from budget.studies.mission import Curve

HEIGHT = 230.0  # [pt]
SHOWN = 4  # sources with a line or an area of their own
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
AIDED = "#e4e8ed"  # of the times with aids
APART = 0.11  # of the axis, between two names beside it [1]
said = partial(line, "figures_growth")


@dataclass(frozen=True, kw_only=True)
class Growth:
    """A curve with what is drawn of it."""

    curve: Curve
    cep: Array  # shape (n_times,) [m]
    r95: Array  # shape (n_times,) [m]
    sources: tuple[Name, ...]  # those with a line of their own
    shares: Array  # of them, then of all others together, (n + 1, n_times) [1]

    @classmethod
    def of(cls, curve: Curve) -> Growth | None:
        """Choose the sources that are largest at some time; None if nothing varies."""
        variance = curve.horizontal_variance()
        total = variance.sum(axis=0)
        if not (total > 0.0).all():
            return None
        shares = variance / total
        most = shares.max(axis=1)
        order = [k for k in from_largest(most.tolist()) if most[k] >= LEAST][:SHOWN]
        own = shares[order]
        return cls(
            curve=curve,
            cep=curve.radius(CEP),
            r95=curve.radius(R95),
            sources=tuple(curve.sources[k] for k in order),
            shares=np.vstack([own, np.delete(shares, order, axis=0).sum(axis=0)]),
        )

    @property
    def leaders(self) -> tuple[tuple[Name, float], ...]:
        """Who contributes most, each with the time from which it does [s]."""
        found: list[tuple[Name, float]] = []
        for name, time in zip(self.curve.dominant, self.curve.times, strict=True):
            if not found or found[-1][0] != name:
                found.append((name, time))
        return tuple(found)


def growth_pictures(
    curve: Curve, limits: Sequence[OutputAssessment] = ()
) -> tuple[Picture, ...]:
    """Return both figures of a mission; () where nothing varies."""
    growth = Growth.of(curve)
    if growth is None:
        return ()
    return (growth_picture(growth, limits), shares_picture(growth))


def growth_picture(growth: Growth, limits: Sequence[OutputAssessment] = ()) -> Picture:
    """Show CEP, R95, limits and the parts of the largest sources over time."""
    curve, lines = growth.curve, _lines(growth)
    figure = growth_figure(growth, limits)
    title = str(figure.get_label())
    rows = zip(
        map(_around, curve.times), growth.cep, growth.r95, growth.shares.T, strict=True
    )
    data: Any = blocks("figures_growth", "data", names=_names(growth), rows=rows)[0]
    return as_picture(
        figure,
        name="mission-growth",
        title=title,
        alt=said(
            "alt",
            title=title,
            first=_around(curve.times[0]),
            end=curve.times[-1],
            lines=lines.values(),
        ),
        tips=lines,
        caption=said(
            "caption", has_limits=_horizontal(limits), has_aids=curve.measured
        ),
        data=data,
        data_on_paper=False,
    )


def shares_picture(growth: Growth) -> Picture:
    """Show the shares of the variance over time, one upon the other."""
    figure = shares_figure(growth)
    title = str(figure.get_label())
    parts = {
        f"area-{k}": said("area_tip", name=name, shares=shares)
        for k, (name, shares) in enumerate(
            zip(_names(growth), growth.shares, strict=True)
        )
        if shares.any()
    }
    return as_picture(
        figure,
        name="mission-shares",
        title=title,
        alt=said("shares_alt", title=title, parts=parts.values()),
        tips=parts,
    )


def _names(growth: Growth) -> tuple[str, ...]:
    """Return the titles of the sources, and of all others together."""
    return (*map(full_title, growth.sources), said("others"))


def _lines(growth: Growth) -> dict[str, str]:
    """Say where each line begins and ends."""
    named = {
        "line-r95": ("R95", growth.r95),
        "line-cep": ("CEP", growth.cep),
        **{
            f"line-{k}": (name, growth.cep * np.sqrt(growth.shares[k]))
            for k, name in enumerate(_names(growth)[:-1])
        },
    }
    return {
        key: said("line_tip", name=name, sizes=values)
        for key, (name, values) in named.items()
    }


def _around(time: float) -> str:
    """Print a time of a curve to two digits."""
    unit, size = next(
        (unit, size) for unit, size, _ in SPANS if time >= size or size == 1.0
    )
    return f"{float(f'{time / size:.2g}'):g} {unit}"


def _horizontal(limits: Sequence[OutputAssessment]) -> list[OutputAssessment]:
    """Return the limits on the horizontal position."""
    return [
        row
        for row in limits
        if (row.output.name.quantity, row.output.name.axis)
        == ("position", LENGTHS["position"])
    ]


@house_style()
def growth_figure(growth: Growth, limits: Sequence[OutputAssessment] = ()) -> Figure:
    """Draw all lines on two logarithmic axes."""
    title = said("title", cep=growth.cep[-1], end=growth.curve.times[-1])
    own = _horizontal(limits)
    largest = max(float(growth.r95.max()), *(row.limit for row in own), 0.0)
    figure, axes = plane(title, said("time_axis"), said("error_axis"), HEIGHT)
    figure.axes[0].set_position((0.16, 0.15, 0.52, 0.79))
    x = np.array(growth.curve.times)
    _across(axes, growth.curve)
    for begin, end in growth.curve.measured:
        if end > x[0]:
            axes.axvspan(max(begin, x[0]), end, color=AIDED, linewidth=0.0, zorder=0.0)
    axes.set_yscale("log")
    low = max(float(growth.cep.min()) / 3.0, largest / REACH)
    axes.set_ylim(low, 2.0 * largest)
    names: list[tuple[float, str, str]] = []
    for key, values, width, text in (
        ("line-r95", growth.r95, 1.0, "R95"),
        ("line-cep", growth.cep, 1.8, "CEP"),
    ):
        axes.plot(x, values, color=INK, linewidth=width, gid=key)
        names.append((float(values[-1]), text, INK))
    for k, source in enumerate(growth.sources):
        values = growth.cep * np.sqrt(growth.shares[k])
        colour = look_of(source)[0]
        axes.plot(
            x,
            values,
            color=colour,
            linewidth=1.4,
            linestyle="-" if source.owner == "gyro" else "--",
            gid=f"line-{k}",
        )
        names.append((float(values[-1]), full_title(source), INK))
    for row in own:
        at = (row.output.name.time or 0.0, row.limit)
        axes.plot(*at, marker="D", color=PAPER, markeredgecolor=INK, markersize=5.5)
        _on_paper(axes, row.printed_limit, at, (-8.0, 0.0), ha="right")
    _name_lines(axes, names)
    _time_ticks(axes)
    _length_ticks(axes)
    return figure


@house_style()
def shares_figure(growth: Growth) -> Figure:
    """Draw areas one upon the other, the largest source at the bottom."""
    leaders = growth.leaders
    last, since = leaders[-1]
    title = said(
        "shares_title",
        source=full_title(last),
        since=_around(since) if len(leaders) > 1 else "",
    )
    figure, axes = plane(
        title,
        said("time_axis"),
        said("share_axis"),
        HEIGHT,
    )
    figure.axes[0].set_position((0.16, 0.15, 0.52, 0.79))
    x = np.array(growth.curve.times)
    _across(axes, growth.curve)
    for time in {time for span in growth.curve.measured for time in span}:
        if x[0] < time < x[-1]:
            axes.axvline(time, color=INK, linewidth=0.8, linestyle=":")
    axes.set_ylim(0.0, 100.0)
    below = np.zeros(x.size)
    names: list[tuple[float, str, str]] = []
    for k, name in enumerate(_names(growth)):
        shares = 100.0 * np.maximum(growth.shares[k], 0.0)
        is_other = k == len(growth.sources)
        source = None if is_other else growth.sources[k]
        axes.fill_between(
            x,
            below,
            below + shares,
            facecolor="#c3c7cc" if source is None else look_of(source)[0],
            edgecolor=PAPER,
            linewidth=0.8,
            hatch="" if source is None or source.owner == "gyro" else "////",
            gid=f"area-{k}",
        )
        peak = int(np.argmax(shares))
        if shares[-1] >= 100.0 * LEAST:
            names.append((float(below[-1] + shares[-1] / 2.0), name, INK))
        elif shares[peak] >= 100.0 * AREA:
            inner = max(peak, x.size // 8)
            place, middle = float(x[inner]), float((below + shares / 2.0)[inner])
            _on_paper(axes, name, (place, middle), (0.0, 0.0))
        below = below + shares
    _name_lines(axes, names)
    _time_ticks(axes)
    return figure


def _name_lines(axes: Axes, names: Sequence[tuple[float, str, str]]) -> None:
    """Write names beside the ends of lines, apart from one another."""
    low, high = axes.get_ylim()
    is_log = axes.get_yscale() == "log"

    def place(value: float) -> float:
        if is_log:
            return float(np.log(max(value, low) / low) / np.log(high / low))
        return (value - low) / (high - low)

    ranked = sorted(((place(v), text, ink) for v, text, ink in names), reverse=True)
    at = [min(y, 1.0) for y, _, _ in ranked]
    for k in range(1, len(at)):
        at[k] = min(at[k], at[k - 1] - APART * _rows_of(ranked[k - 1][1]))
    if at and at[-1] < 0.0:  # push up from below
        at[-1] = 0.0
        for k in range(len(at) - 2, -1, -1):
            at[k] = max(at[k], at[k + 1] + APART * _rows_of(ranked[k][1]))
    for y, (_, text, ink) in zip(at, ranked, strict=True):
        write(
            axes,
            _folded(text),
            (1.0, y),
            (5.0, 0.0),
            colour=ink,
            coords=("axes fraction", "axes fraction"),
        )


FOLD = 18  # characters of a name in a line beside a figure


def _folded(text: str) -> str:
    """Break a long name in two lines."""
    if len(text) <= FOLD or " " not in text:
        return text
    words = text.split(" ")
    cuts = range(1, len(words))
    best = min(
        cuts, key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:])))
    )
    return "\n".join((" ".join(words[:best]), " ".join(words[best:])))


def _rows_of(text: str) -> float:
    """Return how much room a name takes, in single lines over two [1]."""
    return 1.0 if "\n" in _folded(text) else 0.6


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


def _length_ticks(axes: Axes) -> None:
    """Tick a logarithmic axis of lengths at powers of ten, in units that one reads."""
    low, high = axes.get_ylim()
    powers = range(ceil(log10(low)), floor(log10(high)) + 1)
    step = ceil(len(powers) / MOST_POWERS)
    sizes = [10.0**power for power in powers[::step]]
    axes.set_yticks(sizes, [_decade(size) for size in sizes])
    axes.minorticks_off()


MOST_POWERS = 7  # on an axis


def _decade(size: float) -> str:
    """Print a power of ten as a length: '1 cm', '10 m', '1 km'."""
    unit, scale = next(
        ((unit, scale) for unit, scale in DECADES if size >= 0.999 * scale), DECADES[-1]
    )
    return f"{size / scale:g} {unit}"


DECADES = (("km", 1e3), ("m", 1.0), ("cm", 1e-2), ("mm", 1e-3))


def _on_paper(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    shift: tuple[float, float],
    *,
    ha: str = "left",
) -> None:
    """Write a text over lines or areas, on paper of its own."""
    axes.annotate(
        text,
        at,
        xytext=shift,
        textcoords="offset points",
        fontsize=SMALL,
        color=INK,
        ha=ha,
        va="center",
        bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.5},
    )
