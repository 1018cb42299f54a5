"""The positions of a calibration as small cubes: which axis is up, and which turns."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from itertools import product
from math import cos, radians, sin
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.schemes import calibrates, schedule_of
from budget.inputs.records import AXES, UNCALIBRATED
from budget.report.figures.style import (
    BLUE,
    GRID,
    INK,
    MUTED,
    SMALL,
    add_panel,
    blank,
    rgb,
    without_name,
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

ACROSS, CELL, NAMES, AIR = 5, 50.0, 24.0, 4.0  # cells, and their sizes [pt]
SPAN = 1.35  # of a cell from its middle, in half edges of the cube times 2 [1]
HALF, TIP = 0.42, 1.06  # edge of the cube over 2, end of an axis [1]
ALIGNED = 0.9999  # cosine from which on an axis is vertical [1]
DIGITS = 4  # of directions that are one
RING, RADIUS, OPEN = 0.72, 0.42, 300.0  # place and size of a turn's arc [1], [deg]
EAST_OF_SOUTH, ABOVE = radians(-30.0), radians(25.0)  # where one looks from
RIGHT = np.array([cos(EAST_OF_SOUTH), sin(EAST_OF_SOUTH), 0.0])
UP = np.array(
    [
        -sin(EAST_OF_SOUTH) * sin(ABOVE),
        cos(EAST_OF_SOUTH) * sin(ABOVE),
        cos(ABOVE),
    ]
)
SIGHT = np.cross(RIGHT, UP)  # to who looks, east, north, up
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
        found: dict[bool, dict[Any, list[Window]]] = {True: {}, False: {}}
        for window in every:
            found[bool(window.sense)].setdefault(_alike(window), []).append(window)
        dwells, turns = (
            tuple(_attitude(own) for own in found[is_turn].values())
            for is_turn in (False, True)
        )
        if len(dwells) + len(turns) <= 1:
            return None
        return cls(dwells=dwells, turns=turns)

    @property
    def every(self) -> tuple[Attitude, ...]:
        """Dwells, then turns."""
        return (*self.dwells, *self.turns)

    @property
    def ups(self) -> Counter[tuple[str, int]]:
        """How often each axis is up or down, of the dwells where one is."""
        return Counter(
            {
                one.vertical: len(one.windows)
                for one in self.dwells
                if one.vertical is not None
            }
        )

    @property
    def even(self) -> int:
        """How often every axis is up and down; 0 where that differs."""
        counts = set(self.ups.values())
        every = len(self.ups) == len(self.dwells) == 2 * len(AXES)
        return counts.pop() if every and len(counts) == 1 else 0

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


def _alike(window: Window) -> tuple[object, ...]:
    """Return what windows of one attitude have in common."""
    standing = window.setting.after(0.0)
    up = standing.to_body[:, 2]
    if not window.sense:
        return _key(up)
    axis = int(np.argmax(np.abs(window.setting.turn_axis)))
    is_vertical = abs(up[axis]) >= ALIGNED
    return (axis, is_vertical)


def _key(values: Array) -> tuple[float, ...]:
    """Return numbers that are equal where directions are."""
    return tuple((np.round(values, DIGITS) + 0.0).ravel().tolist())


def _attitude(windows: Sequence[Window]) -> Attitude:
    """Gather windows that are alike."""
    first = windows[0]
    about = int(np.argmax(np.abs(first.setting.turn_axis))) if first.sense else None
    return Attitude(
        to_body=first.setting.after(0.0).to_body, about=about, windows=tuple(windows)
    )


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
    number = len(positions.every)
    across = min(ACROSS, number)
    height = AIR + (CELL + NAMES) * -(-number // across)
    width = ACROSS * (CELL + 2.0)
    drawing = blank(height, width=width)
    ((_, own),) = entries(table)
    for place, (one, named) in enumerate(zip(positions.every, own, strict=True)):
        row, column = divmod(place, across)
        axes = add_panel(
            drawing,
            left=column * width / ACROSS,
            top=AIR + row * (CELL + NAMES),
            width=width / ACROSS,
            height=CELL,
        )
        reach = SPAN * width / ACROSS / CELL
        axes.set_xlim(-reach, reach)
        axes.set_ylim(-SPAN, SPAN)
        axes.set_xticks([])
        axes.set_yticks([])
        without_name(axes.xaxis)
        without_name(axes.yaxis)
        _draw_cube(axes, one)
        for k, text in enumerate((named.label, named.count)):
            axes.annotate(
                text,
                (0.5, 0.0),
                (0.0, -8.0 - 10.0 * k),
                xycoords="axes fraction",
                textcoords="offset points",
                fontsize=SMALL,
                color=MUTED if k else INK,
                ha="center",
                va="baseline",
            )
    return drawing


def _seen(points: Array) -> Array:
    """Return where points east, north, up (n, 3) are in the picture, (n, 2)."""
    return np.asarray(points @ np.column_stack([RIGHT, UP]))


def _draw_cube(axes: Axes, one: Attitude) -> None:
    """Draw the faces that one sees, the axes, and how it turns."""
    from matplotlib.patches import Polygon

    body = one.to_body.T  # columns: x, y, z in east, north, up
    for axis, sign in product(range(3), (-1.0, 1.0)):
        normal = sign * body[:, axis]
        if normal @ SIGHT <= 0.0:
            continue
        j, k = body[:, (axis + 1) % 3], body[:, (axis + 2) % 3]
        corners = [
            HALF * (normal + a * j + b * k)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        axes.add_patch(
            Polygon(
                _seen(np.array(corners)),
                facecolor=(*rgb(GRID), 0.55),
                edgecolor=MUTED,
                linewidth=0.8,
                zorder=2.0,
            )
        )
    vertical = one.vertical
    taken: list[Array] = []
    order = sorted(range(3), key=lambda axis: -abs(body[2, axis]))
    for axis in order:
        end = body[:, axis]
        is_up = vertical is not None and AXES[axis] == vertical[0]
        is_turned = axis == one.about
        colour = BLUE if is_turned else INK
        is_behind = end @ SIGHT < 0.0
        start, tip = _seen(np.array([HALF * end, TIP * end]))
        axes.annotate(
            "",
            tip,
            start,
            arrowprops={
                "arrowstyle": "-|>,head_length=0.25,head_width=0.13",
                "color": colour,
                "linewidth": 1.8 if is_up or is_turned else 0.9,
                "shrinkA": 0.0,
                "shrinkB": 0.0,
                "zorder": 1.0 if is_behind else 3.0,
            },
            zorder=1.0 if is_behind else 3.0,
        )
        if is_turned:
            _draw_turn(axes, end, colour)
        _name_axis(axes, AXES[axis], tip, taken, is_strong=is_up or is_turned)


def _name_axis(
    axes: Axes, name: str, tip: Array, taken: list[Array], *, is_strong: bool
) -> None:
    """Write the name of an axis beyond its end, unless another one is there."""
    length = float(np.hypot(*tip)) or 1.0
    at = tip * (1.0 + 0.24 / length)
    if any(np.hypot(*(at - other)) < NEAR for other in taken):
        return
    taken.append(at)
    axes.annotate(
        name,
        (float(at[0]), float(at[1])),
        fontsize=SMALL,
        fontweight="bold" if is_strong else "normal",
        color=INK,
        ha="center",
        va="center",
        zorder=5.0,
    )


NEAR = 0.36  # of two names [1]


def _draw_turn(axes: Axes, axis: Array, colour: str) -> None:
    """Draw an arc with a head about an axis, the right-handed way."""
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    beside = np.cross(axis, across)
    t = np.radians(np.linspace(0.0, OPEN, 40))
    points = RING * axis + RADIUS * (
        np.outer(np.cos(t), across) + np.outer(np.sin(t), beside)
    )
    seen = _seen(points)
    axes.plot(*seen.T, color=colour, linewidth=1.1, zorder=4.0)
    axes.annotate(
        "",
        (float(seen[-1, 0]), float(seen[-1, 1])),
        (float(seen[-4, 0]), float(seen[-4, 1])),
        arrowprops={
            "arrowstyle": "-|>,head_length=0.3,head_width=0.18",
            "color": colour,
            "linewidth": 1.1,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
        zorder=4.0,
    )


def _component(one: Attitude, axis: int) -> str:
    """Print one component of the vertical in body axes."""
    return f"{one.up[axis] + 0.0:.3g}" if abs(one.up[axis]) > 10.0**-DIGITS else "0"
