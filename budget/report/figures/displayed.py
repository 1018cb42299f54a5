"""A figure that a notebook shows by itself: no backend, no display, no magic."""

from __future__ import annotations

from io import BytesIO, StringIO
from typing import TYPE_CHECKING
from warnings import catch_warnings, filterwarnings

from matplotlib import rc_context
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

DPI = 144  # of the bitmap


class Displayed(Figure):
    """A matplotlib Figure that is a picture in whatever shows rich results.

    It is drawn in the style that made it.
    """

    def __init__(
        self,
        *,
        style: Callable[[], AbstractContextManager[None]],
        figsize: tuple[float, float],
    ) -> None:
        """Make an empty figure of a size [inch]."""
        super().__init__(figsize=figsize)
        self._style = style

    def __repr__(self) -> str:
        """Say what it shows."""
        return f"<Figure: {self.get_label()}>"

    def _repr_png_(self) -> bytes:
        """Return it as a bitmap."""
        file = BytesIO()
        with self._style():
            self.savefig(file, format="png", dpi=DPI, metadata={"Software": None})
        return file.getvalue()

    def _repr_svg_(self) -> str:
        """Return it as outlines, which need no font, on paper of its own."""
        file = StringIO()
        with self._style(), rc_context({"svg.fonttype": "path"}), catch_warnings():
            filterwarnings("ignore", message=r"Glyph \d+ .* missing from")
            self.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
        return file.getvalue()
