"""The positions of a calibration as small cubes: which axis is up, and which turns."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from math import cos, radians, sin
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.schemes import calibrates, schedule_of
from budget.inputs.records import AXES, UNCALIBRATED
from budget.report.figures.curves import arrow
from budget.report.figures.style import (
    BLUE,
    GRID,
    INK,
    MUTED,
    add_picture,
    blank,
    rgb,
    write,
)
from budget.report.figures.tabled import Plot, entries
from budget.report.pages import figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.inputs.records import Procedure
    from budget.model.windows import Window
    from budget.report.blocks import Table

ACROSS, WIDE, HIGH, EDGE = 5, 52.0, 74.0, 4.0  # cells, and their sizes [pt]
SCALE = 50.0 / 2.7  # of the drawing [pt]; lengths without a unit are times this
NAME, COUNT = -33.0, -43.0  # base lines of the words below a cube, from its middle [pt]
HALF, TIP, BEYOND = 0.42, 1.06, 0.24  # half an edge, end of an axis, its name beyond it
NEAR = 0.36  # of two names: the second is not written
ALIGNED = 0.9999  # cosine from which on an axis is vertical [1]
DIGITS = 4  # of directions that are one
RING, RADIUS, OPEN = 0.72, 0.42, 300.0  # place and size of a turn's arc, [deg]
EAST_OF_SOUTH, ABOVE = radians(-30.0), radians(25.0)  # where one looks from
RIGHT = np.array([cos(EAST_OF_SOUTH), sin(EAST_OF_SOUTH), 0.0])
UP = np.array(
    [
        -sin(EAST_OF_SOUTH) * sin(ABOVE),
        cos(EAST_OF_SOUTH) * sin(ABOVE),
        cos(ABOVE),
    ]
)
SEEN = np.column_stack([RIGHT, UP])  # of east, north, up what is seen right and up
SIGHT = np.cross(RIGHT, UP)  # to who looks, east, north, up
CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])  # of a face
PAGE = "figures_attitudes"


@dataclass(frozen=True, kw_only=True)
class Attitude:
    """Windows in which the vertical is one direction of the body, or alike turns."""

    to_body: Array  # from east, north, up, of the first of them, shape (3, 3)
    about: int | None  # body axis that all turn about; None of dwells
    windows: tuple[Window, ...]

    @property
    def up(self) -> Array:
        """The vertical in body axes, shape (3,) [1]."""
        return np.asarray(self.to_body[:, 2])

    @property
    def vertical(self) -> tuple[str, int] | None:
        """The axis that is up (+1) or down (-1); None where none is."""
        axis = int(np.argmax(np.abs(self.up)))
        aligned = abs(self.up[axis]) >= ALIGNED
        return (AXES[axis], int(np.sign(self.up[axis]))) if aligned else None

    @property
    def azimuths(self) -> int:
        """Different attitudes about the vertical."""
        return len({_key(one.setting.to_body) for one in self.windows})


@dataclass(frozen=True, kw_only=True)
class Positions:
    """All positions of a calibration, and its turns."""

    dwells: tuple[Attitude, ...]
    turns: tuple[Attitude, ...]

    @classmethod
    def of(cls, procedure: Procedure, sensors: Sequence[str]) -> Positions | None:
        """Gather the windows of triads; None without any, and of one alone."""
        if procedure.formulas in UNCALIBRATED:
            return None
        every = [
            window
            for sensor in sensors
            if calibrates(sensor, procedure)
            for window in schedule_of(sensor, procedure).windows
        ]
        if procedure.windows:  # one clock: what both triads use is one window
            every = list(dict.fromkeys(replace(one, use="both") for one in every))
        found: dict[Any, list[Window]] = {}
        for window in every:
            up = window.setting.after(0.0).to_body[:, 2]
            axis = _turned(window)
            # Of turns it counts whether they are about the vertical.
            alike = _key(up) if axis is None else (abs(up[axis]) >= ALIGNED,)
            found.setdefault((axis, alike), []).append(window)
        gathered = [
            Attitude(
                to_body=own[0].setting.after(0.0).to_body,
                about=axis,
                windows=tuple(own),
            )
            for (axis, _), own in found.items()
        ]
        return (
            None
            if len(gathered) <= 1
            else cls(
                dwells=tuple(one for one in gathered if one.about is None),
                turns=tuple(one for one in gathered if one.about is not None),
            )
        )

    @property
    def every(self) -> tuple[Attitude, ...]:
        """Dwells, then turns."""
        return (*self.dwells, *self.turns)

    @property
    def ups(self) -> Counter[tuple[str, int]]:
        """How often each axis is up or down, of the dwells where one is."""
        pairs = [(one.vertical, len(one.windows)) for one in self.dwells]
        return Counter({axis: times for axis, times in pairs if axis is not None})

    @property
    def even(self) -> int:
        """How often every axis is up and down; 0 where that differs."""
        ups, counts = self.ups, {*self.ups.values()}
        is_even = len(ups) == len(self.dwells) == 2 * len(AXES) and len(counts) == 1
        return counts.pop() if is_even else 0

    @property
    def positions(self) -> int:
        """Windows that stand."""
        return sum(len(one.windows) for one in self.dwells)

    @property
    def turned(self) -> int:
        """Windows that turn."""
        return sum(len(one.windows) for one in self.turns)

    @property
    def axes(self) -> list[str]:
        """Body axes that are turned about."""
        return [AXES[k] for k in sorted({one.about or 0 for one in self.turns})]


def _turned(window: Window) -> int | None:
    """Return the body axis that a window turns about; None where it stands."""
    return int(np.argmax(np.abs(window.setting.turn_axis))) if window.sense else None


def _key(values: Array) -> tuple[float, ...]:
    """Return numbers that are equal where directions are."""
    return tuple((np.round(values, DIGITS) + 0.0).ravel().tolist())


def positions_plot(positions: Positions) -> Plot:
    """Show the positions of a calibration and its turns as small cubes."""
    said, table = figure(
        PAGE, "positions", positions=positions, component=_component, axes=AXES
    )
    return Plot(
        name="positions", said=said, table=table, draw=lambda: _draw(positions, table)
    )


def _draw(positions: Positions, table: Table) -> Figure:
    """Draw a cube with its axes for each attitude, row by row."""
    across = min(ACROSS, len(positions.every))
    high = EDGE + HIGH * -(-len(positions.every) // across)
    drawing = blank(high, width=ACROSS * WIDE)
    axes = add_picture(drawing, (0.0, ACROSS * WIDE), (-high, 0.0))
    ((_, own),) = entries(table)
    for place, (one, named) in enumerate(zip(positions.every, own, strict=True)):
        row, column = divmod(place, across)
        middle = np.array([WIDE * (column + 0.5), -EDGE - HIGH * row - WIDE / 2.0])
        _draw_cube(axes, one, middle)
        for text, base, colour in (
            (named.label, NAME, INK),
            (named.count, COUNT, MUTED),
        ):
            at = (float(middle[0]), float(middle[1]))
            write(
                axes, text, at, (0.0, base), ha="center", va="baseline", colour=colour
            )
    return drawing


def _draw_cube(axes: Axes, one: Attitude, middle: Array) -> None:
    """Draw the faces that one sees, the axes, and how it turns."""

    def seen(points: Array) -> Array:
        """Return where points east, north, up (n, 3) are in the picture (n, 2) [pt]."""
        return np.asarray(middle + SCALE * points @ SEEN)

    body = one.to_body.T  # columns: x, y, z in east, north, up
    for axis, normal in enumerate(body.T):
        side = HALF * np.sign(normal @ SIGHT)  # of the two faces that which one sees
        beside = np.delete(body, axis, axis=1)
        axes.fill(
            *seen(side * normal + HALF * CORNERS @ beside.T).T,
            facecolor=(*rgb(GRID), 0.55),
            edgecolor=MUTED,
            linewidth=0.8,
            zorder=2.0,
        )
    taken: list[Array] = []
    for axis in sorted(range(3), key=lambda axis: -abs(body[2, axis])):
        end = body[:, axis]
        is_turned = axis == one.about
        is_strong = is_turned or AXES[axis] in (one.vertical or ())
        colour = BLUE if is_turned else INK
        line = seen(np.outer((HALF, TIP), end))
        order = 1.0 if end @ SIGHT < 0.0 else 3.0
        arrow(
            axes, line, color=colour, linewidth=1.8 if is_strong else 0.9, zorder=order
        )
        if is_turned:
            across, beside = np.roll(body, -axis, axis=1)[:, 1:].T
            t = np.radians(np.linspace(0.0, OPEN, 40))
            arc = np.outer(np.cos(t), across) + np.outer(np.sin(t), beside)
            arrow(axes, seen(RING * end + RADIUS * arc), color=colour, linewidth=1.1)
        out = line[1] - middle
        at = line[1] + BEYOND * SCALE * out / (float(np.hypot(*out)) or 1.0)
        if all(np.hypot(*(at - other)) >= NEAR * SCALE for other in taken):
            taken.append(at)
            place = (float(at[0]), float(at[1]))
            write(axes, AXES[axis], place, ha="center", va="center", strong=is_strong)


def _component(one: Attitude, axis: int) -> str:
    """Print one component of the vertical in body axes."""
    return f"{one.up[axis] + 0.0:.3g}" if abs(one.up[axis]) > 10.0**-DIGITS else "0"
