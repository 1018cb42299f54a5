"""Names of lines, areas and points in a figure over two axes, none on another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.report.figures.style import INCH, INK, PAPER, SMALL, write

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes

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


def on_paper(
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
