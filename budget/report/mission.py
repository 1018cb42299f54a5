"""Errors of a mission by time, in readable units, and their main contributors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, Any

from budget.names import LENGTHS, Name
from budget.report.pages import blocks
from budget.report.standing import outcome_words
from budget.report.tables import (
    HEADING,
    SMALL_SHARE,
    UNITS,
    Number,
    as_limited,
    largest_error,
    length,
    round_u,
    round_uncertainty,
    unit_for,
    used_part,
)
from budget.studies.cautions import SMALL
from budget.ties import from_largest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from budget.problem import Output
    from budget.report.blocks import Block
    from budget.report.tables import Unit
    from budget.results import Assessment, Budget, JudgedOutput, OutputBudget

PLANE = LENGTHS["position"]
HOUR = 3600.0  # [s]
NAUTICAL_MILE = 1852.0  # [m]
WORSE = 2.0  # than straight on, from which on a turn is worth a sentence [1]


@dataclass(frozen=True, kw_only=True)
class ErrorsAtTime:
    """The errors at one time of a mission."""

    time: float  # since it began [s]
    rows: tuple[OutputBudget, ...]

    def row(self, quantity: str, axis: str) -> OutputBudget | None:
        """Return one of them; None where it was not asked for."""
        own = (
            one for one in self.rows if (one.parameter, one.axis) == (quantity, axis)
        )
        return next(own, None)

    @property
    def horizontal(self) -> OutputBudget | None:
        """The horizontal error of position."""
        return self.row("position", PLANE)

    @property
    def is_lost(self) -> bool:
        """Whether attitude errors are beyond the first order of all these numbers."""
        own = (row for row in self.rows if row.parameter == "attitude")
        return any(row.standard_uncertainty > SMALL for row in own)

    def largest(self, like: str) -> float:
        """Return the largest size of all errors that are read in one unit [SI]."""
        own = (row for row in self.rows if _like(row) == like)
        sizes = (
            size for row in own for size in (row.standard_uncertainty, *_radii(row))
        )
        return max(sizes, default=0.0)

    def size(
        self, quantity: str, axis: str, units: Mapping[str, Unit], circle: str = ""
    ) -> Number | None:
        """Round the size of an error, or of a circle; None: it was not asked for."""
        row = self.row(quantity, axis)
        if row is None:
            return None
        value = getattr(row.radii, circle, 0.0) if circle else row.standard_uncertainty
        return _in_unit(row.standard_uncertainty.like(value), row, units[_like(row)])


def _like(row: OutputBudget) -> str:
    """Return what all errors that are read in one unit have in common."""
    return HEADING if row.axis == HEADING else row.parameter


def _radii(row: OutputBudget) -> tuple[float, float]:
    """Return CEP and R95; 0 of what is no length."""
    return (0.0, 0.0) if row.radii is None else (row.radii.cep, row.radii.r95)


def _in_unit(value: float, row: OutputBudget, unit: Unit) -> Number:
    """Round a size of an error [SI] in a unit."""
    return round_u(value, replace(row.output, unit=unit[0], si_per_unit=unit[1]))


def unit_for_all(quantity: str, sizes: Iterable[float]) -> Unit:
    """Return the unit of a column, and its size [SI]: the same at every time.

    That which the smallest of the sizes [SI] is read in: no number has leading zeros.
    """
    return unit_for(quantity, min((one for one in sizes if one > 0.0), default=0.0))


def units_of(moments: Iterable[ErrorsAtTime]) -> dict[str, Unit]:
    """Return the units of errors that are read in one, the same at these times."""
    return {
        like: unit_for_all(like, [at.largest(like) for at in moments]) for like in UNITS
    }


def outputs_at_end(budget: Budget) -> dict[Name, Output]:
    """Return the outputs in the units that those alike are read in at the end."""
    largest: dict[str, float] = {}
    for row in by_time(budget)[-1].rows:
        largest[_like(row)] = max(largest.get(_like(row), 0.0), row.largest_error)
    units = {like: unit_for(like, size) for like, size in largest.items()}
    return {
        row.output.name: replace(row.output, unit=unit, si_per_unit=scale)
        for row in budget.outputs
        for unit, scale in [
            units.get(_like(row), (row.output.unit, row.output.si_per_unit))
        ]
    }


def by_time(budget: Budget) -> tuple[ErrorsAtTime, ...]:
    """Gather the outputs of a mission by their times, rising."""

    def time_of(row: OutputBudget) -> float:
        return row.output.name.time or 0.0

    return tuple(
        ErrorsAtTime(time=time, rows=tuple(own))
        for time, own in groupby(sorted(budget.outputs, key=time_of), key=time_of)
    )


def bought(budget: Budget, moments: Sequence[ErrorsAtTime]) -> Mapping[str, Any] | None:
    """Return the CEP at every time after each calibration; None of one alone."""
    tests = budget.bought
    if not tests or len(tests[0].cep) != len(moments):
        return None
    largest = map(max, zip(*(one.cep for one in tests), strict=True))
    unit = unit_for_all("position", largest)
    rows = [
        (
            at,
            [
                at.horizontal and _in_unit(one.cep[place], at.horizontal, unit)
                for one in tests
            ],
        )
        for place, at in enumerate(moments)
    ]
    return {"unit": unit[0], "rows": rows}


def filtered(budget: Budget) -> dict[str, object]:
    """Return what a filter has learnt, and believes where it is not the optimal one."""
    found = budget.filter
    learnt = () if found is None else found.learnt
    believed = () if found is None or found.kind == "optimal" else found.believed
    last = max((one.time for one in learnt), default=0.0)
    far = [one for one in believed if (one.parameter, one.axis) == ("position", PLANE)]
    turned = None if found is None else found.turned
    is_worse = turned is not None and turned.turned >= WORSE * turned.straight
    return {
        "kalman": found,
        "learnt": [
            (Name("bias", owner=one.sensor, axis=one.axis), one)
            for one in learnt
            if one.time == last
        ],
        "believed_rows": [
            (Name(one.parameter, axis=one.axis), one)
            for one in believed
            if (one.parameter, one.axis) in {("position", PLANE), ("attitude", HEADING)}
        ],
        "believed_end": max(far, key=lambda one: one.time, default=None),
        "turn": turned if is_worse else None,
        "length": length,
        "plain": _plain,
    }


def _plain(x: float) -> str:
    """Write a number to three digits, without an exponent."""
    return f"{float(f'{x:.3g}'):.10g}"


@dataclass(frozen=True, kw_only=True)
class Blamed:
    """What one source contributes to the horizontal position, time by time."""

    source: Name
    shares: tuple[float, ...]  # of the variance, in the order of the times [1]


@dataclass(frozen=True, kw_only=True)
class Leader:
    """What contributes most to the horizontal position at one time."""

    source: Name
    time: float  # [s]
    share: float  # of the variance [1]


def blamed(moments: Sequence[ErrorsAtTime]) -> tuple[Blamed, ...]:
    """Return sources by their largest share of the horizontal variance at any time."""
    rows = [row for at in moments if (row := at.horizontal) is not None]
    found: dict[Name, list[float]] = {}
    for place, row in enumerate(rows):
        for part in row.contributions:
            shares = found.setdefault(part.source, [0.0] * len(rows))
            shares[place] = part.share if row.is_resolved else 0.0
    sources = [
        Blamed(source=source, shares=tuple(shares)) for source, shares in found.items()
    ]
    return tuple(sources[k] for k in from_largest([max(one.shares) for one in sources]))


def contributions(moments: Sequence[ErrorsAtTime]) -> dict[str, object]:
    """Return who contributes how much to the horizontal position at every time."""
    sources = blamed(moments)
    times = [at.time for at in moments if at.horizontal is not None]
    leaders = []
    for place, time in enumerate(times):
        shares = [one.shares[place] for one in sources]
        if any(shares):
            top = sources[from_largest(shares)[0]].source
            leaders.append(Leader(source=top, time=time, share=max(shares)))
    return {
        "times": times,
        "leaders": [
            (source, list(own))
            for source, own in groupby(leaders, lambda one: one.source)
        ],
        "latest": [
            sources[k] for k in from_largest([one.shares[-1] for one in sources])
        ],
        "major": [one for one in sources if max(one.shares) >= SMALL_SHARE],
        "minor": [one for one in sources if 0.0 < max(one.shares) < SMALL_SHARE],
    }


def rate_per_hour(moments: Sequence[ErrorsAtTime]) -> tuple[float, Number] | None:
    """Return CEP over time at 1 h, or at the first later time [nmi/h], else None."""
    for at in moments:
        row = at.horizontal
        if at.time >= HOUR and row is not None and row.radii is not None:
            rate = row.radii.cep / NAUTICAL_MILE / (at.time / HOUR)
            known = row.standard_uncertainty.like(rate)
            return at.time, Number.of(known, round_uncertainty(rate))
    return None


def limits_blocks(
    usual: float,
    assessment: Assessment,
    rows: Iterable[JudgedOutput],
    worst: Iterable[tuple[Name, str]] = (),
) -> tuple[Block, ...]:
    """Return each limit on a mission, with its own probability, else the usual one.

    And what the worst of these outputs are made of.
    """
    return blocks(
        "mission_limits",
        usual=usual,
        rows=[(row, as_limited(row)) for row in rows],
        worst=worst,
        at_medians=assessment.chance is not None,
        largest_error=largest_error,
        used_part=used_part,
        outcome=lambda row: outcome_words(assessment, row),
    )
