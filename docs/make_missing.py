"""Write how well missing lines are predicted into the page on them: [FOLDER]."""  # noqa: INP001 - a script, no package

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import bdtr, stdtr

from budget.inputs import load_catalogue
from budget.missing.prediction import DESIGN, Fit, figures_of
from budget.names import words

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device

HERE = Path(__file__).resolve().parent
PAGE = "missing.md"
START, END = "<!-- leave one out -->\n", "<!-- end -->\n"
LEVELS = (0.5, 0.9)  # of the intervals
TAIL = 0.025  # of the binomial bounds, on each side


@dataclass(frozen=True, kw_only=True)
class Case:
    """One expected line hidden in all variants and both sensors of one design."""

    quantity: str
    p: tuple[float, ...]  # probability of less than is printed, of each [1]
    factor: tuple[float, ...]  # printed over median, or the inverse, of each [1]

    def inside(self, level: float) -> float:
        """Return the part of its figures that lies within an interval."""
        return float(np.mean(np.abs(np.array(self.p) - 0.5) <= level / 2.0))


def leave_one_out(catalogue: Sequence[Device]) -> tuple[Case, ...]:
    """Hide each line of each design in turn, and predict it."""
    figures = {
        (device.name, name): figure
        for device in catalogue
        for name, figure in figures_of(device).items()
    }
    hidden: dict[tuple[str, str], list[tuple[str, object]]] = {}
    for key, figure in figures.items():
        hidden.setdefault((figure.groups[DESIGN], key[1].quantity), []).append(key)
    cases = []
    for (_, quantity), keys in hidden.items():
        fit = Fit.of([figure for key, figure in figures.items() if key not in keys])
        p, factor = [], []
        for device, name in keys:
            figure = figures[device, name]
            found = fit.predict({name: figure})
            if found is not None:
                off = figure.log_u - float(found.location[0])
                p.append(float(stdtr(found.df, off / np.sqrt(found.scale[0, 0]))))
                factor.append(float(np.exp(abs(off))))
        if p:
            cases.append(Case(quantity=quantity, p=tuple(p), factor=tuple(factor)))
    return tuple(cases)


def bounds(number: int, level: float) -> tuple[int, int]:
    """Return how many of so many cases lie inside, in 95 % of all such tests."""
    below = np.array([bdtr(k, number, level) for k in range(number + 1)])
    return int(np.argmax(below > TAIL)), int(np.argmax(below >= 1.0 - TAIL))


def rows(cases: Sequence[Case]) -> list[str]:
    """Return the table, a row for each line and one for all."""
    kinds = list(dict.fromkeys(case.quantity for case in cases))
    lines = [
        "| specification | cases | within 50 % | within 90 % | median factor |",
        "|---|---|---|---|---|",
    ]
    for quantity in [*kinds, ""]:
        own = [case for case in cases if quantity in {"", case.quantity}]
        cells = [words(quantity) or "all", str(len(own))]
        for level in LEVELS:
            inside = sum(case.inside(level) for case in own)
            text = f"{100.0 * inside / len(own):.0f} %"
            if not quantity:
                low, high = (100.0 * n / len(own) for n in bounds(len(own), level))
                text += f" (chance: {low:.0f} to {high:.0f})"
            cells.append(text)
        cells.append(f"{np.median([np.median(case.factor) for case in own]):.1f}")
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def write(folder: Path) -> None:
    """Write the table into the page."""
    page = (HERE / PAGE).read_text(encoding="utf-8")
    before, _, rest = page.partition(START)
    after = rest.partition(END)[2]
    table = "\n".join(rows(leave_one_out(load_catalogue())))
    text = f"{before}{START}{table}\n{END}{after}"
    (folder / PAGE).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if sys.argv[1:] else HERE)
