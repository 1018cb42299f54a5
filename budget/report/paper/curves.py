"""Curves of the paper's figures 1 to 4: a sweep in, a Figure out, with its finding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import as_picture
from budget.report.figures.style import GRID, INK, MUTED, SMALL, canvas, house_style
from budget.report.tables import print_given
from budget.units import PPM

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.report.blocks import Picture
    from budget.studies.paper.sweeps import Sweep

HEIGHT = 190.0  # [pt]
LEFT, RIGHT, TOP, BELOW = 58.0, 66.0, 12.0, 34.0  # [pt]
DASHES = ("-", "--", ":", "-.")
ALIKE = 0.01  # curves whose ends differ by less of the largest share a label [1]


def sweep_picture(sweep: Sweep) -> Picture:
    """Return one of the paper's figures as a block, with the steps behind it."""
    name = sweep.figure.replace(" ", "-")
    return as_picture(
        sweep_curves(sweep),
        name=name,
        title=sweep_title(sweep),
        alt=sweep_alt(sweep),
        tips={
            f"curve-{k}": _ends(names, curve)
            for k, (names, curve) in enumerate(_gathered(sweep))
        },
        data=_steps(sweep, f"steps-of-{name}"),
    )


@house_style()
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
        axes.plot(
            x,
            curve / scale,
            color=INK,
            linewidth=1.1,
            linestyle=style,
            gid=f"curve-{k}",
        )
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
    printed = f"printed order {sweep.given.order}"
    if not sweep.largest:
        return f"{head}: no effect at all ({printed}: rounding)"
    if not sweep.slopes.any():
        return f"{head}: none but eq. (4)'s own error, the same throughout ({printed})"
    size = print_given(sweep.largest, digits=3)
    return f"{head}: proportional, up to {size} ({printed})"


def sweep_alt(sweep: Sweep) -> str:
    """Say in words with numbers what the curves show."""
    ends = "; ".join(_ends(names, curve) for names, curve in _gathered(sweep))
    first, last = (print_given(float(s / PPM)) for s in sweep.size[[0, -1]])
    return f"{sweep_title(sweep)}. Relative errors from {first} to {last} ppm. {ends}."


def _ends(names: Sequence[str], curve: Array) -> str:
    """Say where a curve begins and ends."""
    first, last = (print_given(float(e), digits=3) for e in curve[[0, -1]])
    return f"{', '.join(names)}: {first} to {last}"


def _steps(sweep: Sweep, name: str) -> Table:
    """Return the relative error of every axis or angle at every step."""
    heads = (f"{_cause(sweep)} [ppm]", *sweep.names)
    return Table(
        name=name,
        caption=f"Relative errors at each step of {sweep.figure}",
        columns=tuple(Column(head=head, kind="number") for head in heads),
        groups=(
            RowGroup(
                rows=tuple(
                    (
                        Cell(text=print_given(size / PPM), exact=size / PPM),
                        *(Cell(text=print_given(e), exact=e) for e in errors),
                    )
                    for size, errors in zip(
                        sweep.size.tolist(), sweep.errors.T.tolist(), strict=True
                    )
                )
            ),
        ),
    )


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
    return (
        "angle errors" if sweep.given.parameter == "mounting_angle" else "bias errors"
    )
