"""What all figures share: inks, looks of the sources, a bare canvas, and the way out.

No pyplot, no global state and no matplotlibrc, the user's or one in the current folder:
the same result gives the same bytes, in any process.
"""

from __future__ import annotations

import io
import re
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Literal
from warnings import catch_warnings, filterwarnings

from budget.calibration.problem import MEASURED
from budget.model.source import ACCELEROMETER, COLOURS, PROCEDURE
from budget.model.sources import every_source
from budget.names import Name
from budget.report.blocks import Picture
from budget.report.fonts import drawing_library
from budget.results import INTERACTION

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

    from budget.report.blocks import Table

INK, MUTED, GRID, PAPER = "#1b1f24", "#6b7280", "#d5d9de", "#fefefe"
WIDTH = 330.0  # [pt] of a column: readable on a telephone, two abreast on a desk
WIDE = 700.0  # [pt] of two columns and what is between them
TEXT, SMALL = 9.0, 8.0  # [pt]
INCH = 72.0  # [pt]

# The eight hues of Okabe and Ito, seven at lightnesses 12 % apart in grey, so chosen
# that each has a contrast of 3:1 to a light paper and to a dark one. Black turns with
# the paper. The ninth source is the second of the scale factor, hatched.
ORANGE, SKY, GREEN, YELLOW = "#A77201", "#078DC5", "#009E73", "#A0970A"
BLUE, VERMILION, PURPLE, BLACK = "#0072B2", "#AA4A01", "#B3548B", "#000000"
INKS = dict(
    zip(
        COLOURS,
        (ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE, BLACK),
        strict=True,
    )
)
ON_DARK, ON_LIGHT = "#ffffff", "#111111"  # text on a segment
DARK = ("blue", "vermilion", "purple", "black")
HATCH = "////"
REST = "#8e949c"  # of what has no look of its own
OTHER = Name("other")
# Those that have no look of their own: of station and environment, and left over.
LEFT_OVER = ("....", "\\\\\\\\", "----", "++++", "||||")
Look = tuple[str, str, str]  # colour, hatch, colour of text: none on a hatch


@cache
def looks() -> Mapping[str, Look]:
    """Return the look of each source, in the order of the segments.

    Those without a colour have every ink, hatch by hatch, in the order of the table;
    those of other packages the first look of their colour that nobody has.
    """
    every = [one for one in every_source() if one.may_vary]
    own = [one for one in every if not one.origin]
    left = [one for one in own if one.shared or not (one.colour and one.varies)]
    left.sort(
        key=lambda one: (one.like(PROCEDURE) != "", not one.shared, not one.varies)
    )
    spare = (_look(ink, hatch) for hatch in LEFT_OVER for ink in COLOURS)
    found = dict(zip((one.name for one in left), spare, strict=False))
    for one in own:
        if one.name not in found:
            found[one.name] = _look(one.colour, HATCH if one.is_hatched else "")
    for one in every[len(own) :]:
        inks = (one.colour,) if one.colour else COLOURS
        tried = [_look(ink, hatch) for hatch in ("", HATCH, *LEFT_OVER) for ink in inks]
        free = (look for look in tried if look not in found.values())
        found[one.name] = next(free, tried[-1])
    return {
        **{one.name: found[one.name] for one in every},
        MEASURED.quantity: _look("purple", "xxxx"),
        INTERACTION: (REST, "xxxx", ""),
        OTHER: (REST, "", ON_LIGHT),
    }


def _look(ink: str, hatch: str) -> Look:
    """Return the look of a colour by name, with a hatch or ''."""
    return INKS[ink], hatch, "" if hatch else ON_DARK if ink in DARK else ON_LIGHT


STYLE: dict[Any, Any] = {  # text stays text; ids do not change from run to run
    "svg.fonttype": "none",
    "svg.hashsalt": "budget",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # ships with matplotlib: same layout anywhere
    "hatch.linewidth": 0.8,
    "path.simplify": False,
}
# Ticks of a logarithmic axis, and the span beyond which the coarse ones are enough.
FINE, COARSE, DECADES = (1.0, 2.0, 5.0), (1.0,), 99.0
# These choose windows, which nothing here opens, and cannot be set for a while only.
OF_WINDOWS = ("backend", "backend_fallback", "interactive", "toolbar")
# Whether the style holds already: to set 300 defaults takes as long as a text or two.
_STYLED: ContextVar[bool] = ContextVar("_STYLED", default=False)


def look_of(source: Name, *, is_both: bool = False) -> Look:
    """Return colour, hatch and colour of text of a source, whoever owns it.

    Where those of both triads are drawn, `is_both`, the second is hatched.
    """
    colour, hatch, ink = looks().get(source.quantity, looks()[OTHER])
    of_second = is_both and source.owner == ACCELEROMETER
    return (colour, hatch or HATCH, "") if of_second else (colour, hatch, ink)


@contextmanager
def house_style() -> Iterator[None]:
    """Draw under the library's own defaults and STYLE, whatever a matplotlibrc says.

    Such a file may stand in any folder: `text.usetex` in one would start a program.
    Also a decorator, of every function that draws.
    """
    if _STYLED.get():
        yield
        return
    mpl = drawing_library()
    defaults = {
        name: mpl.rcParamsDefault[name]
        for name in mpl.rcParamsDefault.keys() - OF_WINDOWS
    }
    token = _STYLED.set(True)
    try:
        with mpl.rc_context(defaults | STYLE):
            yield
    finally:
        _STYLED.reset(token)


def blank(height: float, *, width: float = WIDTH) -> Figure:
    """Make a figure with nothing on it [pt]."""
    from budget.report.figures.displayed import Displayed

    return Displayed(style=house_style, figsize=(width / INCH, height / INCH))


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


def add_picture(
    figure: Figure,
    x: tuple[float, float],
    y: tuple[float, float],
    *,
    left: float = 0.0,
    top: float = 0.0,
    width: float | None = None,
    height: float | None = None,
) -> Axes:
    """Add axes between these ends that have no numbers, of the whole figure without."""
    whole = [float(INCH * inches) for inches in figure.get_size_inches()]
    wide, high = width or whole[0], height or whole[1]
    axes = add_panel(figure, left=left, top=top, width=wide, height=high)
    axes.set(xlim=x, ylim=y, xticks=[], yticks=[])
    without_name(axes.xaxis)
    without_name(axes.yaxis)
    return axes


def without_name(axis: Axis) -> None:
    """Say that an axis has no name: else its numbers are measured to find its place."""
    axis.set_label_coords(0.0, 0.0)


def fits(text: str, room: float) -> bool:
    """Whether a small text and a little air fit into `room` [pt]."""
    return text_width(text) + 6.0 < room


@lru_cache(maxsize=1024)  # the same names and shares come again in every figure
@house_style()
def text_width(text: str, size: float = SMALL) -> float:
    """Return the width of a text in the font of the layout [pt]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    if not text:
        return 0.0
    path = TextPath((0.0, 0.0), text, size, prop=FontProperties(family="DejaVu Sans"))
    x = path.vertices[:, 0]
    return float(x.max() - x.min()) if x.size else 0.0


def shorten(text: str, room: float) -> str:
    """Cut a small text that is wider than its room, and show that it was [pt]."""
    if text_width(text) <= room:
        return text
    while text and text_width(f"{text}...") > room:
        text = text[:-1]
    return f"{text.rstrip()}..."


def write_on(
    figure: Figure,
    left: float,
    base: float,
    text: str,
    *,
    size: float = SMALL,
    weight: str = "normal",
    colour: str = INK,
) -> None:
    """Write a text on the figure; place of its base line in points from top left."""
    width, height = (INCH * float(inches) for inches in figure.get_size_inches())
    figure.text(
        left / width,
        1.0 - base / height,
        text,
        fontsize=size,
        fontweight=weight,
        color=colour,
    )


def write(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    shift: tuple[float, float] = (0.0, 0.0),
    *,
    ha: str = "left",
    va: str = "center_baseline",
    strong: bool = False,
    colour: str = INK,
    coords: tuple[str, str] = ("data", "data"),
    size: float = SMALL,
    paper: float = 0.0,
    pad: float = 1.0,
) -> None:
    """Write a text at a place of the axes, shifted by points.

    On paper of its own, of an opacity from 0 to 1, where it lies on something else.
    """
    beneath = {"facecolor": PAPER, "edgecolor": "none", "alpha": paper, "pad": pad}
    axes.annotate(
        text,
        at,
        xycoords=coords,
        xytext=shift,
        textcoords="offset points",
        fontsize=size,
        fontweight="bold" if strong else "normal",
        color=colour,
        ha=ha,
        va=va,
        bbox=beneath if paper else None,
    )


TICK_ROOM, DECADE_ROOM = 30.0, 24.0  # of a number, of a power of ten on an axis [pt]


@dataclass(frozen=True, kw_only=True)
class Scale:
    """The axis that rows share."""

    # Its ends.
    low: float
    high: float
    kind: str = "linear"  # 'linear', 'log', or 'symlog' (linear between -1 and 1)
    # Where its numbers stand, and as what; None for round ones.
    ticks: tuple[tuple[float, str], ...] | None = None
    # Lines across all rows, a limit or a zero, with a word above; '' for none.
    lines: tuple[tuple[float, str], ...] = ()
    band: tuple[float, float] | None = None  # what is shaded behind the rows
    label: str = ""  # quantity and unit
    most: int | None = None  # numbers on a logarithmic one, None: as fit


def set_scale(
    axes: Axes, name: Literal["x", "y"], scale: Scale, *, by_room: bool = False
) -> None:
    """Set ends, kind, numbers and name of an axis, no more numbers than have room."""
    options = {"linthresh": 1.0} if scale.kind == "symlog" else {}
    axis = getattr(axes, f"{name}axis")
    if scale.kind != "linear":  # as it is
        getattr(axes, f"set_{name}scale")(scale.kind, **options)
    getattr(axes, f"set_{name}lim")(scale.low, scale.high)
    width = in_points(axes, axes.bbox.width)
    if scale.ticks is not None:
        axis.set_ticks([x for x, _ in scale.ticks], [text for _, text in scale.ticks])
    elif by_room or scale.kind != "linear":
        if scale.kind == "linear":
            number = max(2, int(width / TICK_ROOM))
            axes.locator_params(name, nbins=number, steps=[1, 2, 5, 10])
        elif scale.kind == "log":
            log_ticks(axis, scale.most or max(2, int(width / DECADE_ROOM)))
        axis.set_major_formatter("{x:g}")
        low, high = sorted((scale.low, scale.high))
        axis.set_ticks([x for x in axis.get_ticklocs() if low <= x <= high])
    axes.minorticks_off()
    if scale.label:
        axis.set_label_text(scale.label, fontsize=SMALL, color=MUTED)
    else:
        without_name(axis)


def in_points(axes: Axes, pixels: float) -> float:
    """Return a length on the figure [pt]."""
    return INCH * pixels / axes.figure.dpi


HEAD_LINE, HEAD_EDGE = 12.0, 6.0  # height of a line above a figure, air around it [pt]


@house_style()
def headed(figure: Figure, about: str) -> Figure:
    """Write above a figure that stands alone what it shows, and of what; return it.

    On a page its heading says so.
    """
    width, height = (INCH * float(inches) for inches in figure.get_size_inches())
    room = width - 2.0 * HEAD_EDGE
    lines = [
        *(
            (one, TEXT, "bold", INK)
            for one in folded(str(figure.get_label()), room, TEXT)
        ),
        *((one, SMALL, "normal", MUTED) for one in folded(about, room, SMALL)),
    ]
    whole = height + HEAD_LINE * len(lines) + 2.0 * HEAD_EDGE
    for axes in figure.axes:
        x, y, wide, tall = axes.get_position().bounds
        axes.set_position((x, y * height / whole, wide, tall * height / whole))
    for own in figure.texts:
        own.set_y(own.get_position()[1] * height / whole)
    figure.set_size_inches(width / INCH, whole / INCH)
    for k, (text, size, weight, colour) in enumerate(lines, start=1):
        base = HEAD_LINE * k + (0.0 if weight == "bold" else 1.0)
        write_on(figure, HEAD_EDGE, base, text, size=size, weight=weight, colour=colour)
    return figure


WORD = re.compile(r"[\u2e80-\uffff]|[^\s\u2e80-\uffff]+\s*|\s+")
BOLD = 1.15  # width of bold letters over that of others [1]


def folded(text: str, room: float, size: float) -> list[str]:
    """Break a text into lines that fit, between words, or within what has none [pt]."""
    found = [""]
    for word in WORD.findall(text):
        longer = found[-1] + word
        if found[-1] and BOLD * text_width(longer.rstrip(), size) > room:
            found.append(word)
        else:
            found[-1] = longer
    return [one.rstrip() for one in found if one.strip()]


def add_plane(
    figure: Figure,
    x: Scale,
    y: Scale,
    *,
    left: float = 58.0,
    top: float = 12.0,
    right: float = 66.0,
    height: float,
) -> Axes:
    """Add a panel with a grid over two axes; margins and height in points."""
    width = INCH * float(figure.get_size_inches()[0]) - left - right
    axes = add_panel(figure, left=left, top=top, width=width, height=height)
    axes.tick_params(axis="y", labelsize=SMALL, labelcolor=MUTED)
    axes.grid(color=GRID, linewidth=0.6)
    set_scale(axes, "x", x)
    set_scale(axes, "y", y)
    return axes


def log_ticks(axis: Axis, most: int | None = None) -> None:
    """Tick a logarithmic axis at 1, 2 and 5, or at decades where it is long."""
    from matplotlib.ticker import LogLocator

    low, high = axis.get_view_interval()
    subs = FINE if high < DECADES * low else COARSE
    marks = LogLocator(subs=subs, numticks=most).tick_values(low, high)
    axis.set_ticks([mark for mark in marks if low <= mark <= high])
    axis.set_major_formatter("{x:g}")


def as_picture(
    figure: Figure,
    *,
    name: str,
    title: str,
    alt: str,
    tips: Mapping[str, str] | None = None,
    caption: str = "",
    data: Table | None = None,
    narrow: Figure | None = None,
    is_wide: bool = False,
    data_on_paper: bool = True,
) -> Picture:
    """Write a figure into a block; `name` may be a dotted name with underscores.

    One that needs the width of the page has another for a telephone, `narrow`.
    """
    name = kebab(name)
    svg = to_svg(figure, name=name)
    return Picture(
        name=name,
        title=title,
        alt=alt,
        svg=svg,
        tips={k: tip for k, tip in (tips or {}).items() if f'"{name}-{k}"' in svg},
        caption=caption,
        data=data,
        is_wide=is_wide or narrow is not None,
        narrow=to_svg(narrow, name=f"{name}-narrow") if narrow else "",
        data_on_paper=data_on_paper,
    )


def kebab(name: str) -> str:
    """Write a dotted name with underscores as one for a link."""
    return name.replace("_", "-").replace(".", "-")


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue of a colour [1]."""
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def in_order(sources: Iterable[Name]) -> list[Name]:
    """Sort sources as every figure does; those without a look of their own last."""
    places = {name: place for place, name in enumerate(looks())}
    return sorted(sources, key=lambda name: places.get(name.quantity, len(places)))


def to_svg(figure: Figure, *, name: str) -> str:
    """Write a figure as SVG text; ids begin with `name`, so that several fit a page.

    An artist with the gid 'tip-z' becomes the element with the id '{name}-tip-z': the
    tips of a picture find it by that.
    """
    file = io.StringIO()
    with house_style(), catch_warnings():
        # Texts stay texts: who shows the figure has other fonts, or says what it lacks.
        filterwarnings("ignore", message=r"Glyph \d+ .* missing from")
        figure.savefig(
            file,
            format="svg",
            transparent=True,
            metadata={
                "Date": None,
                "Creator": None,
                "Format": None,
                "Type": None,
                "Title": figure.get_label(),
            },
        )
    text = re.sub(r'\bid="', f'id="{name}-', file.getvalue())
    return re.sub(r'(url\(|href=")#', rf"\1#{name}-", text)
