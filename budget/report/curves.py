"""Curves of the paper's figures 1 to 4: a sweep in, a Figure out, with its finding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.report.figures import GRID, INK, MUTED, SMALL, canvas
from budget.report.tables import print_given
from budget.units import PPM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.studies.paper.sweeps import Sweep

HEIGHT = 190.0  # [pt]
LEFT, RIGHT, TOP, BELOW = 58.0, 66.0, 12.0, 34.0  # [pt]
DASHES = ("-", "--", ":", "-.")
ALIKE = 0.01  # curves whose ends differ by less of the largest share a label [1]


def sweep_curves(sweep: Sweep) -> Figure:
    """Draw relative errors against the step; curves that coincide share one label."""
    figure, axes = canvas(HEIGHT, left=LEFT, right=RIGHT, top=TOP, below=BELOW)
    figure.set_label(sweep_title(sweep))
    axes.tick_params(axis="y", labelsize=SMALL, labelcolor=MUTED)
    axes.grid(color=GRID, linewidth=0.6)
    largest = sweep.largest
    exponent = int(np.floor(np.log10(largest))) if largest else 0
    scale = 10.0**exponent
    x = sweep.size / PPM
    for k, (names, curve) in enumerate(_gathered(sweep)):
        style = DASHES[k % len(DASHES)]
        axes.plot(x, curve / scale, color=INK, linewidth=1.1, linestyle=style)
        axes.annotate(
            "all" if len(names) == len(sweep.names) else ", ".join(names),
            (x[-1], curve[-1] / scale),
            xytext=(5.0, 0.0),
            textcoords="offset points",
            fontsize=SMALL,
            color=INK,
            va="center",
        )
    axes.set_xlim(0.0, float(x[-1]))
    reach = 1.15 * largest / scale or 1.0
    axes.set_ylim(-reach, reach)
    if not largest:
        axes.set_yticks([0.0], ["0"])
    axes.set_xlabel(f"{_cause(sweep)} [ppm]", fontsize=SMALL, color=MUTED)
    unit = f"1e{exponent}" if largest else "1"
    axes.set_ylabel(f"relative error [{unit}]", fontsize=SMALL, color=MUTED)
    return figure


def sweep_title(sweep: Sweep) -> str:
    """State the finding of one figure, and the order that the paper prints."""
    number = sweep.figure.partition(" ")[2]
    head = f"Figure {number}: {_cause(sweep)} and {_effect(sweep)}"
    printed = f"printed order {sweep.order}"
    if not sweep.largest:
        return f"{head}: no effect at all ({printed}: rounding)"
    if not sweep.slopes.any():
        return f"{head}: none but eq. (4)'s own error, the same throughout ({printed})"
    size = print_given(sweep.largest, digits=3)
    return f"{head}: proportional, up to {size} ({printed})"


def sweep_alt(sweep: Sweep) -> str:
    """Say in words with numbers what the curves show."""
    ends = "; ".join(
        f"{', '.join(names)}: {print_given(float(curve[0]), digits=3)} to "
        f"{print_given(float(curve[-1]), digits=3)}"
        for names, curve in _gathered(sweep)
    )
    first, last = (print_given(float(s / PPM)) for s in sweep.size[[0, -1]])
    return f"{sweep_title(sweep)}. Relative errors from {first} to {last} ppm. {ends}."


def _gathered(sweep: Sweep) -> list[tuple[list[str], Array]]:
    """Return curves with the names of those that coincide with them."""
    found: list[tuple[list[str], Array]] = []
    for name, curve in zip(sweep.names, sweep.errors, strict=True):
        for names, other in found:
            if np.abs(other - curve).max() <= ALIKE * sweep.largest:
                names.append(name)
                break
        else:
            found.append(([name], curve))
    return found


def _cause(sweep: Sweep) -> str:
    """Name what is stepped."""
    return sweep.source.rpartition("_")[2]


def _effect(sweep: Sweep) -> str:
    """Name what is shown."""
    return "angle errors" if sweep.parameter == "mounting_angle" else "bias errors"
