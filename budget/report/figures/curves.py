"""Names of lines, areas and points in a figure over two axes, none on another."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.report.figures.style import INCH, text_width, write

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from matplotlib.axes import Axes

    from budget.arrays import Array

APART = 10.5  # lines of names beside an axis [pt]
AIR, PIECE = 5.0, 12.0  # before a name, and of the piece of its line [pt]


def name_lines(
    axes: Axes,
    names: Sequence[tuple[float, str]],
    looks: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """Write names beside the ends of lines, apart from one another.

    With a piece of the line where `looks` has one for a name.
    """
    room = axes.bbox.height * INCH / axes.figure.dpi
    wide = axes.bbox.width * INCH / axes.figure.dpi

    def place(value: float) -> float:
        to_axes = axes.transData + axes.transAxes.inverted()
        return room * float(to_axes.transform((axes.get_xlim()[1], value))[1])

    ranked = sorted(((place(v), text) for v, text in names), reverse=True)
    half = [APART * (1 + in_two_lines(text).count("\n")) / 2.0 for _, text in ranked]
    at = [min(y, room) for y, _ in ranked]
    for k in range(1, len(at)):
        at[k] = min(at[k], at[k - 1] - half[k - 1] - half[k])
    if at and at[-1] < 0.0:  # push up from below
        at[-1] = 0.0
        for k in range(len(at) - 2, -1, -1):
            at[k] = max(at[k], at[k + 1] + half[k] + half[k + 1])
    for y, (_, text) in zip(at, ranked, strict=True):
        shift = AIR
        if looks and text in looks:
            axes.plot(
                [1.0 + AIR / wide, 1.0 + (AIR + PIECE) / wide],
                [y / room, y / room],
                transform=axes.transAxes,
                clip_on=False,
                **looks[text],
            )
            shift = 2.0 * AIR + PIECE
        write(
            axes,
            in_two_lines(text),
            (1.0, y / room),
            (shift, 0.0),
            va="center",
            coords=("axes fraction", "axes fraction"),
        )


FOLD = 18  # characters of a name in a line beside a figure


def in_two_lines(text: str) -> str:
    """Break a long name in two lines."""
    if len(text) <= FOLD or " " not in text:
        return text
    words = text.split(" ")
    cuts = range(1, len(words))
    best = min(
        cuts, key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:])))
    )
    return "\n".join((" ".join(words[:best]), " ".join(words[best:])))


HEAD_LENGTH, HEAD_WIDTH = 3.2, 1.7  # of an arrow, from its middle line [pt]


def arrow(
    axes: Axes, line: Array, *, color: str, linewidth: float, zorder: float = 4.0
) -> None:
    """Draw a line (n, 2), in axes of points, with a head at its end."""
    along = line[-1] - line[-2]
    along /= float(np.hypot(*along)) or 1.0
    base, across = (
        line[-1] - HEAD_LENGTH * along,
        HEAD_WIDTH * along[::-1] * (-1.0, 1.0),
    )
    look: dict[str, Any] = {"color": color, "zorder": zorder}
    axes.plot(*line.T, linewidth=linewidth, solid_capstyle="butt", **look)
    axes.fill(
        *np.array([line[-1], base + across, base - across]).T, linewidth=0, **look
    )


Box = tuple[float, float, float, float]  # left, low, right, high


def free_place(boxes: Iterable[Box], within: Box, taken: list[Box]) -> int | None:
    """Return the first of some boxes that is within another and on none that is taken.

    It is taken then; None where none is free.
    """
    for place, (left, low, right, high) in enumerate(boxes):
        inside = within[0] <= left and within[1] <= low
        inside = inside and right <= within[2] and high <= within[3]
        if inside and not any(
            left < one[2] and one[0] < right and low < one[3] and one[1] < high
            for one in taken
        ):
            taken.append((left, low, right, high))
            return place
    return None


LINE = 11.0  # height of a line of a small text, with the air around it [pt]
GAP = 2.0  # from a text to what it is the name of [pt]
Place = tuple[Sequence[float], float, float]  # a point; halves of a text beyond it


def write_apart(
    axes: Axes,
    names: Iterable[tuple[str, Sequence[Place]]],
    *,
    marks: Iterable[Array] = (),
    paper: float = 0.0,
    everywhere: bool = False,
) -> None:
    """Write each text at the first of its places that is free, if any.

    That is within the axes, unless they may stand everywhere, on no other text and on
    none of the marks, points (n, 2) each.
    """
    scale = INCH / axes.figure.dpi
    ends: Any = (
        (-inf, -inf, inf, inf) if everywhere else np.multiply(scale, axes.bbox.extents)
    )
    seen = [scale * axes.transData.transform(one) for one in marks]
    taken: list[Box] = [(*one.min(axis=0), *one.max(axis=0)) for one in seen]
    for text, places in names:
        rows = text.split("\n")
        size = np.array([max(map(text_width, rows)) + 2.0, LINE * len(rows)])
        shifts = [(size / 2.0 + GAP) * (right, up) for _, right, up in places]
        middles = [
            scale * axes.transData.transform(at) + shift
            for (at, *_), shift in zip(places, shifts, strict=True)
        ]
        boxes = [(*(at - size / 2.0), *(at + size / 2.0)) for at in middles]
        found = free_place(boxes, ends, taken)
        if found is not None:
            (x, y), shift = places[found][0], shifts[found]
            write(
                axes, text, (x, y), tuple(shift), ha="center", va="center", paper=paper
            )
