"""A pandas frame that prints some of its rows, and how many there are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Callable

MOST = 10  # rows


class Frame(pd.DataFrame):
    """A DataFrame in all but how much of it is printed; what is made of it is one."""

    def __repr__(self) -> str:
        """Print some rows."""
        with pd.option_context("display.max_rows", MOST):
            return super().__repr__()

    def _repr_html_(self) -> str | None:
        """Print the same in HTML."""
        html: Callable[[pd.DataFrame], str | None]
        html = vars(pd.DataFrame)["_repr_html_"]  # which has no stub
        with pd.option_context("display.max_rows", MOST):
            return html(self)
