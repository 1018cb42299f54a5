"""The track of a mission seen from above, with ellipses of the errors of position."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import atan2, degrees, floor, log, log10, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mission import SEEN
from budget.names import HORIZONTAL, time_text
from budget.navigation.route import WEIGHTS
from budget.report.figures.curves import write_apart
from budget.report.figures.growth import PLANE
from budget.report.figures.style import (
    INK,
    MUTED,
    PAPER,
    VERMILION,
    add_picture,
    blank,
    rgb,
    write,
)
from budget.report.figures.tabled import Plot, entries
from budget.report.pages import figure
from budget.report.tables import DASH, length, print_coverage

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.navigation.route import Route
    from budget.report.figures.curves import Place
    from budget.studies.mission import Curve

WIDTH, SIDE = 258.0, 234.0  # of the figure, and of the picture in it at the most [pt]
LEAST_SIDE = 96.0  # [pt]
EDGE, FOOT = 12.0, 20.0  # [pt]
AIR = 0.08  # around what is drawn, of its larger side [1]
SEEN_FROM = 0.03  # of the picture, half a length of an ellipse to be seen as it is [1]
DRAWN_AT = 0.12  # of the picture, the largest ellipse that is enlarged [1]
POINTS = 73  # of an ellipse
MOST = 6  # ellipses
ROUND = (1.0, 2.0, 5.0)  # of a scale, times a power of ten
ROUND_TO = 1.05  # of the axes, for a circle [1]
NAME = 30.0  # an ellipse that is smaller has no name on it [pt]
PAGE = "figures_track"


@dataclass(frozen=True, kw_only=True)
class Ellipse:
    """Where the unit is about its true place with the coverage, at one time."""

    time: float  # [s]
    centre: Array  # planned place, north and east of the start, shape (2,) [m]
    major: float  # half axes [m]
    minor: float
    bearing: float  # of the major one, from north to east, 0 up to pi [rad]
    is_more: bool = False  # its axes are this or more: a specification lacks

    @classmethod
    def of(
        cls,
        time: float,
        centre: Array,
        covariance: Array,
        coverage: float,
        *,
        is_more: bool = False,
    ) -> Ellipse:
        """Take it from a covariance north and east, shape (2, 2) [m^2].

        Its half axes are sqrt(-2 ln(1 - P)) standard uncertainties along the principal
        axes: the square of a plane normal vector over these is chi-squared of 2.
        """
        (a, b), (_, d) = covariance.tolist()
        half, middle = sqrt(((a - d) / 2.0) ** 2 + b**2), (a + d) / 2.0
        k = sqrt(-2.0 * log(1.0 - coverage))
        return cls(
            time=time,
            centre=centre,
            major=k * sqrt(middle + half),
            minor=k * sqrt(max(a * d - b * b, 0.0) / (middle + half or 1.0)),
            bearing=0.5 * atan2(2.0 * b, a - d) % np.pi,
            is_more=is_more,
        )

    @property
    def is_round(self) -> bool:
        """Whether its axes are equal to what is printed."""
        return self.major <= ROUND_TO * self.minor

    def outline(self, times: float = 1.0) -> Array:
        """Return its points north and east, so many times as large, (POINTS, 2) [m]."""
        t = np.linspace(0.0, 2.0 * np.pi, POINTS)
        along, across = self.major * np.cos(t), self.minor * np.sin(t)
        # One that is round has its major axis wherever rounding puts it.
        bearing = 0.0 if self.is_round else self.bearing
        c, s = np.cos(bearing), np.sin(bearing)
        shape = np.column_stack([c * along - s * across, s * along + c * across])
        return np.asarray(self.centre + times * shape)


@dataclass(frozen=True, kw_only=True)
class Way:
    """A planned track north and east of its start, with ellipses on it."""

    track: Array  # shape (n, 2) [m]
    ellipses: tuple[Ellipse, ...]
    coverage: float

    @classmethod
    def of(
        cls, route: Route, curve: Curve, asked: Sequence[float], coverage: float
    ) -> Way | None:
        """Lay ellipses on a track at times that are asked for [s]; None without any.

        Where they are many, some of them, the last among these. None of what is over
        lines that are predicted, which has no covariance.
        """
        times = [time for time in asked if time in curve.times]
        if len(times) > MOST:
            chosen = np.unique(np.linspace(0, len(times) - 1, MOST).round())
            times = [times[int(k)] for k in chosen]
        clock, track = track_of(route)
        rows = [SEEN.index(("position", axis)) for axis in HORIZONTAL]
        whole = curve.covariance.sum(axis=0)[:, rows][:, :, rows]
        found = tuple(
            Ellipse.of(
                time,
                np.array([np.interp(time, clock, one) for one in track.T]),
                whole[curve.times.index(time)],
                coverage,
                is_more=PLANE in curve.lower_bounds,
            )
            for time in times
        )
        if curve.mixture is not None or not any(one.major > 0.0 for one in found):
            return None
        return cls(track=track, ellipses=found, coverage=coverage)

    @property
    def times(self) -> float:
        """How many times as large the ellipses are drawn [1]."""
        span = float(np.ptp(self.track, axis=0).max())
        largest = max(one.major for one in self.ellipses)
        if span <= 0.0 or largest >= SEEN_FROM * span:
            return 1.0
        return max(_rounded(DRAWN_AT * span / largest), 1.0)


def track_of(route: Route) -> tuple[Array, Array]:
    """Return times (n,) [s] and places north and east of the start, (n, 2) [m].

    Ways over the ground, summed: of a journey around the earth no map.
    """
    steps = route.steps((route.duration,))
    moves = np.einsum("snk,n->sk", steps.nodes.velocity[..., :2], np.array(WEIGHTS))
    ends = np.cumsum(moves * steps.durations[:, None], axis=0)
    clock = np.cumsum(steps.durations)
    return np.concatenate([[0.0], clock]), np.vstack([np.zeros(2), ends])


def track_plot(way: Way) -> Plot:
    """Show a track from above, north up, with the ellipses of its errors."""
    coverage = f"{print_coverage(way.coverage)} %"
    said, table = figure(PAGE, "track", way=way, bearing=_bearing, coverage=coverage)
    (own,) = (own for _, own in entries(table))
    return Plot(
        name="mission-track",
        said=said,
        table=table,
        draw=lambda: _draw(way, said.north),
        tips={f"ellipse-{k}": one.tip for k, one in enumerate(own)},
    )


def _draw(way: Way, north: str) -> Figure:
    """Draw track, ellipses, a scale and which way is north."""
    outlines = [one.outline(way.times) for one in way.ellipses]
    every = np.vstack([way.track, *outlines])[:, ::-1]  # east, north
    span = np.ptp(every, axis=0)
    span = span + 2.0 * AIR * max(float(span.max()), 1e-9)
    scale = SIDE / float(span.max())  # [pt/m]
    wide, tall = size = np.maximum(scale * span, LEAST_SIDE)
    middle = (every.min(axis=0) + every.max(axis=0)) / 2.0
    drawing = blank(EDGE + tall + FOOT, width=WIDTH)
    axes = add_picture(
        drawing,
        *np.transpose([middle - size / scale / 2.0, middle + size / scale / 2.0]),
        left=(WIDTH - wide) / 2.0,
        top=EDGE,
        width=wide,
        height=tall,
    )
    axes.plot(*way.track[:, ::-1].T, color=MUTED, linewidth=1.0)
    axes.plot(
        *way.track[0, ::-1], "o", color=PAPER, markeredgecolor=INK, markersize=5.0
    )
    for k, (one, outline) in enumerate(zip(way.ellipses, outlines, strict=True)):
        axes.fill(
            *outline[:, ::-1].T,
            facecolor=(*rgb(VERMILION), 0.12),
            edgecolor=VERMILION,
            linewidth=1.3,
            gid=f"ellipse-{k}",
        )
        axes.plot(*one.centre[::-1], marker="+", color=INK, markersize=5.0)
    # The last one first: of those that would lie on another one the earlier has none.
    names = [
        (time_text(one.time), [*_places(outline)])
        for one, outline in zip(way.ellipses, outlines, strict=True)
    ]
    small = [
        one[:, ::-1] for one in outlines if scale * np.ptp(one, axis=0).max() < NAME
    ]
    write_apart(axes, names[::-1], marks=small, paper=0.85)
    length_of = _rounded(wide / scale / 4.0)
    across = length_of * scale  # [pt]
    axes.plot(
        np.array([0.0, 0.0, 0.0, across, across, across]) / wide,
        np.array([-3.0, -9.0, -6.0, -6.0, -9.0, -3.0]) / tall,
        color=INK,
        linewidth=1.0,
        transform=axes.transAxes,
        clip_on=False,
    )
    below = partial(write, axes, coords=("axes fraction", "axes fraction"))
    below(length(length_of), (0.0, 0.0), (across + 6.0, -6.0))
    below(north, (1.0, 0.0), (0.0, -6.0), ha="right")
    return drawing


def _places(outline: Array) -> Iterator[Place]:
    """Yield where the name of an ellipse may stand: at its sides, then within it."""
    seen = outline[:, ::-1]
    for at, right, up in (
        (seen[:, 0].argmax(), 1.0, 0.0),
        (seen[:, 1].argmax(), 0.0, 1.0),
        (seen[:, 1].argmin(), 0.0, -1.0),
        (seen[:, 0].argmin(), -1.0, 0.0),
        (seen[:, 1].argmax(), 0.0, -2.0),
    ):
        yield seen[at], right, up


def _rounded(size: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten up to a size."""
    power = 10.0 ** floor(log10(size))
    return max(power * part for part in ROUND if power * part <= size * (1.0 + 1e-9))


def _bearing(one: Ellipse) -> str:
    """Print where the long axis points, from north to east, in degrees; '-': round."""
    return DASH if one.is_round else f"{degrees(one.bearing) % 180.0:.0f}"
