"""How long work shows itself: what is being done, how far it is, how much there is."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

Progress = Callable[[str, int, int], None]  # what is done, steps done, steps in all


def stage(progress: Progress | None, what: str) -> Callable[[int, int], None] | None:
    """Return what a method calls with steps done and in all; it need not know more."""
    return None if progress is None else partial(progress, what)
