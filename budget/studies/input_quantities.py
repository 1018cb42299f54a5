"""Input quantities of a budget: lines of the specification, u(x) and c of each.

A line of a data sheet is a quantity x with a standard uncertainty u(x), the printed
value over the divisor; c is the change of an output for one unit of x, by the linear
map of the law (JCGM 100:2008, 5.1.3 and 8.1, EA-4/02 M:2022, 4.9). How the number is
read (a one-sided density, an Allan minimum) is part of the divisor, not of c. Where
several inputs of the Problem are of one line (axes, window averages of a noise)

    c = sqrt(sum over i, j of c_i u_i r_ij c_j u_j) / u(x)

with u(x) the largest u_i of those that reach the output: of equal u_i it is the root
of the sum of c_i r_ij c_j.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import MEASURED, line_u_of_inputs
from budget.inputs.specification import (
    ALLAN_MINIMUM,
    HALF_WIDTHS,
    SIGMAS,
    divisor,
)
from budget.results import InputQuantity
from budget.units import WALK_PER_DENSITY

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import ErrorLine
    from budget.names import Name
    from budget.question import Question

REACHES = 1e-6  # part of the largest input's contribution that is one too [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivity:
    """First-order effect of one line on every output."""

    u_input: Array  # of the largest axis that reaches the output, (n_out,) [SI]
    c: Array  # shape (n_out,) [SI of the output over that of u_input]
    unit: float  # size of the unit of the line [SI]


def input_quantities(question: Question) -> tuple[InputQuantity, ...]:
    """Return the lines that a budget is made of, in the order of its sources."""
    lines = question.lines
    origins = {one.source: one.origin for one in question.filled.lines}
    return tuple(
        _quantity(group.name, lines[group.name], origins.get(group.name, ""))
        for group in question.problem.groups
        if group.name != MEASURED  # which is no one quantity
    )


def sensitivities(question: Question) -> dict[Name, Sensitivity]:
    """Return u(x) and c of every source, for all outputs."""
    problem, law = question.problem, question.law
    lines = question.lines
    found = {}
    for group, rows, variance in zip(
        problem.groups, problem.slices, law.source_first_order, strict=True
    ):
        if group.name == MEASURED:
            continue
        line = lines[group.name]
        of_inputs = (
            line_u_of_inputs(group.name.owner, line, group)
            if question.journey is None
            else np.full(group.size, line.largest)
        )
        each = np.abs(law.C[:, rows]) * np.sqrt(np.diag(group.covariance))
        # An output that nothing reaches has c = 0 of the largest axis.
        reached = each >= REACHES * each.max(axis=1, keepdims=True, initial=0.0)
        u = np.where(reached, of_inputs, 0.0).max(axis=1, initial=0.0)
        c = np.sqrt(np.maximum(variance, 0.0)) / np.where(u > 0.0, u, np.inf)
        found[group.name] = Sensitivity(u_input=u, c=c, unit=_unit(line))
    return found


def _reading(line: ErrorLine) -> float:
    """Return what is how the number is read, which stands in the divisor."""
    return WALK_PER_DENSITY[line.density] * line.reading


def _unit(line: ErrorLine) -> float:
    """Return the size of the unit of a line as it is printed [SI]."""
    return line.si_per_unit / _reading(line)


def _quantity(name: Name, line: ErrorLine, origin: str) -> InputQuantity:
    """Return one line as an input quantity."""
    shapes = dict.fromkeys(line.distributions)
    meaning = line.meaning
    # Axes that mean different things have a text each, 'x max, y 3 sigma'; of what was
    # predicted nothing is printed.
    is_minimum = line.definition == "allan_minimum" and not line.form
    differ = len(shapes) > 1 or meaning not in {*SIGMAS, *HALF_WIDTHS}
    differ |= not is_minimum and line.definition.startswith(("x ", "y ", "z "))
    own = None if differ else divisor(meaning, next(iter(shapes)))
    reading = _reading(line)
    si_per_unit = _unit(line)
    if is_minimum:
        reading /= ALLAN_MINIMUM
    return InputQuantity(
        source=name,
        printed=line.printed,
        meaning=meaning,
        unit=line.unit,
        si_per_unit=si_per_unit,
        u=tuple((abs(line.u) / si_per_unit).tolist()),
        distribution=", ".join(dict.fromkeys(shape.name for shape in shapes)),
        divisor=None if own is None else own / reading,
        degrees_of_freedom=None
        if origin
        else min(
            *filter(None, line.degrees_of_freedom),
            *(shape.degrees_of_freedom for shape in shapes),
            inf,
        ),
        origin=origin,
        readings=len(line.readings),
    )
