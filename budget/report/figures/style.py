"""What all figures share: inks, the looks of the sources, sizes, and a bare canvas.

No pyplot, no global state and no matplotlibrc, the user's or one in the current folder:
the same result gives the same bytes, in any process.
"""

from __future__ import annotations

from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from budget.model.sources import SOURCES
from budget.names import Name
from budget.results import INTERACTION

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, MUTED, GRID, PAPER = "#1b1f24", "#6b7280", "#d5d9de", "#fefefe"
WIDTH = 330.0  # [pt] of a column: readable on a telephone, two abreast on a desk
WIDE = 700.0  # [pt] of two columns and what is between them
TEXT, SMALL = 9.0, 8.0  # [pt]
INCH = 72.0  # [pt]

# Okabe and Ito's eight; the ninth source is the second of the scale factor, hatched.
ORANGE, SKY, GREEN, YELLOW = "#E69F00", "#56B4E9", "#009E73", "#F0E442"
BLUE, VERMILION, PURPLE, BLACK = "#0072B2", "#D55E00", "#CC79A7", "#000000"
INKS = {
    "orange": ORANGE,
    "sky": SKY,
    "green": GREEN,
    "yellow": YELLOW,
    "blue": BLUE,
    "vermilion": VERMILION,
    "purple": PURPLE,
    "black": BLACK,
}
ON_DARK, ON_LIGHT = "#ffffff", "#111111"  # text on a segment
DARK = ("blue", "black")
HATCH = "////"
OTHER = Name("other")
STYLES = {  # source: (colour, hatch, colour of text), in the order of the segments
    **{
        source.name: (INKS[source.colour], HATCH, "")  # no text on a hatch
        if source.is_hatched
        else (INKS[source.colour], "", ON_DARK if source.colour in DARK else ON_LIGHT)
        for source in SOURCES
        if source.varies
    },
    INTERACTION: ("#9aa0a6", "xxxx", ""),
    OTHER: ("#c3c7cc", "", ON_LIGHT),
}
STYLE: dict[Any, Any] = {  # text stays text; ids do not change from run to run
    "svg.fonttype": "none",
    "svg.hashsalt": "budget",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # ships with matplotlib: same layout anywhere
    "hatch.linewidth": 0.8,
    "path.simplify": False,
}
# These choose windows, which nothing here opens, and cannot be set for a while only.
OF_WINDOWS = ("backend", "backend_fallback", "interactive", "toolbar")


def look_of(source: Name) -> tuple[str, str, str]:
    """Return colour, hatch and colour of text of a source, whoever owns it."""
    return STYLES.get(source.quantity, STYLES[OTHER])


@contextmanager
def house_style() -> Iterator[None]:
    """Draw under the library's own defaults and STYLE, whatever a matplotlibrc says.

    Such a file may stand in any folder: `text.usetex` in one would start a program.
    Also a decorator, of every function that draws.
    """
    from matplotlib import rc_context, rcParamsDefault

    defaults = {
        name: rcParamsDefault[name] for name in rcParamsDefault.keys() - OF_WINDOWS
    }
    with rc_context(defaults | STYLE):
        yield


def canvas(
    height: float,
    *,
    left: float,
    right: float,
    top: float,
    below: float,
    width: float = WIDTH,
) -> tuple[Figure, Axes]:
    """Make a figure with one bare panel, from its height and margins in points."""
    figure = blank(height, width=width)
    axes = add_panel(
        figure,
        left=left,
        top=top,
        width=width - left - right,
        height=height - top - below,
    )
    return figure, axes


def blank(height: float, *, width: float = WIDTH) -> Figure:
    """Make a figure with nothing on it [pt]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width / INCH, height / INCH))


def add_panel(
    figure: Figure, *, left: float, top: float, width: float, height: float
) -> Axes:
    """Add axes without frame and ticks; place and size in points from the top left."""
    whole = [float(INCH * inches) for inches in figure.get_size_inches()]
    axes = figure.add_axes(
        (
            left / whole[0],
            1.0 - (top + height) / whole[1],
            width / whole[0],
            height / whole[1],
        )
    )
    axes.set_axisbelow(True)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0.0, labelsize=SMALL, labelcolor=MUTED)
    axes.tick_params(axis="y", labelsize=TEXT, labelcolor=INK, pad=5.5)
    return axes


def fits(text: str, room: float) -> bool:
    """Whether a small text and a little air fit into `room` [pt]."""
    return text_width(text) + 6.0 < room


@lru_cache(maxsize=1024)  # the same names and shares come again in every figure
@house_style()
def text_width(text: str, size: float = SMALL) -> float:
    """Return the width of a text in the font of the layout [pt]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    path = TextPath((0.0, 0.0), text, size, prop=FontProperties(family="DejaVu Sans"))
    x = path.vertices[:, 0]
    return float(x.max() - x.min()) if x.size else 0.0
