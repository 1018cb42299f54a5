"""Results as flat lists of numbers and words, each number with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from budget.studies.reference.records import Number, Snapshot, Word

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.results import Assessment, Budget, OutputBudget
    from budget.studies.allocation.records import Allocation
    from budget.studies.reference.sampling import StandardErrors

# A correlation coefficient or a probability is a part of 1; so much of 1 is rounding.
PART = 1e-9
# Sobol' indices of a linear output are exact; their estimators still round.
INDEX = 1e-9
# The solver of the least cost is sure of the cost to a part of 1e-6; as the cost is
# flat around its least, it is sure of a line to the root of that only.
LEAST_COST, LEAST_COST_LINE = 1e-5, 2e-3


@dataclass(frozen=True, kw_only=True)
class _Sure:
    """Sampling uncertainty of one number; none by the law."""

    standard_error: float | None = None
    degrees_of_freedom: float | None = None


_EXACT = _Sure()


def budget_numbers(
    budget: Budget, errors: StandardErrors | None, assessment: Assessment | None
) -> Snapshot:
    """Return all that a budget says.

    Parameters
    ----------
    budget : Budget
    errors : StandardErrors or None
        Of its outputs, in their order; None by the law.
    assessment : Assessment or None
        The budget against a requirement.

    Returns
    -------
    Snapshot
        Shares are left out: they are ratios of contributions; so are correlations
        between the triads, which the model keeps independent.
    """
    numbers: list[Number] = []
    for k, row in enumerate(budget.outputs):
        numbers.extend(_output_numbers(row, k, errors))
        numbers.extend(_cause_numbers(row, budget.settings.sobol_scrambles))
    numbers.extend(_correlations(budget, errors))
    words = [
        Word(
            subject=sensor,
            quantity="not_given",
            text=", ".join(n for n in budget.not_given if n.owner == sensor),
        )
        for sensor in dict.fromkeys(row.sensor for row in budget.outputs)
    ]
    if assessment is not None:
        numbers.extend(_utilisations(budget, assessment, errors))
        words.extend(
            Word(
                subject=row.sensor,
                quantity="verdict",
                text=row.verdict,
                rests_on="" if errors is None else "utilisation",
            )
            for row in assessment.sensors
        )
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def allocation_numbers(allocation: Allocation) -> Snapshot:
    """Return what an allocation says of lines, limits and costs.

    What it says of the catalogue and of the procedure is left out: the one depends on
    files that are no input, the other is a search.
    """
    line = LEAST_COST_LINE if allocation.strategy == "cost" else 0.0
    numbers: list[Number] = []
    words: list[Word] = []
    yes = {True: "yes", False: "no"}
    words.append(
        Word(
            subject="requirement",
            quantity="feasible",
            text=yes[allocation.feasible],
        )
    )
    for row in allocation.sources:
        room = None if row.headroom is None else row.headroom.value
        values = {"now": row.now, "allowed": row.allowed, "headroom": room}
        numbers.extend(
            Number(
                subject=row.source,
                quantity=quantity,
                unit=row.unit,
                value=value / row.si_per_unit,
                floor=line * value / row.si_per_unit if quantity == "allowed" else 0.0,
            )
            for quantity, value in values.items()
            if value is not None
        )
        words.append(Word(subject=row.source, quantity="status", text=row.status))
    for limited in allocation.outputs:
        parts = {
            "utilisation_now": limited.now,
            "utilisation_allowed": limited.allowed,
            "utilisation_floor": limited.floor,
        }
        numbers.extend(
            Number(
                subject=limited.output.name,
                quantity=quantity,
                unit="1",
                value=value,
                floor=max(
                    line if quantity == "utilisation_allowed" else 0.0,
                    limited.output.resolution / limited.limit,
                ),
            )
            for quantity, value in parts.items()
            if value is not None
        )
    for cost in allocation.costs:
        numbers.extend(
            Number(
                subject=cost.sensor,
                quantity=quantity,
                unit="1",
                value=value,
                floor=LEAST_COST * value,
            )
            for quantity, value in (("cost_now", cost.now), ("cost", cost.cost))
        )
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def _output_numbers(
    row: OutputBudget, k: int, errors: StandardErrors | None
) -> Iterator[Number]:
    """Yield mean, u and both ends of one output."""
    scale = row.output.si_per_unit
    sure = dict.fromkeys(("mean", "u", "low", "high"), _EXACT)
    if errors is not None:
        freedom = {
            "mean": errors.degrees_of_freedom,
            "u": float(errors.u_degrees_of_freedom[k]),
            "low": errors.end_degrees_of_freedom,
            "high": errors.end_degrees_of_freedom,
        }
        sure = {
            name: _Sure(
                standard_error=float(getattr(errors, name)[k]) / scale,
                degrees_of_freedom=degrees,
            )
            for name, degrees in freedom.items()
        }
    for quantity, value, name in (
        ("mean", row.mean, "mean"),
        ("standard_uncertainty", row.standard_uncertainty, "u"),
        ("interval_low", row.interval[0], "low"),
        ("interval_high", row.interval[1], "high"),
    ):
        yield Number(
            subject=row.output.name,
            quantity=quantity,
            unit=row.output.unit,
            value=value / scale,
            floor=row.output.resolution / scale,
            standard_error=sure[name].standard_error,
            degrees_of_freedom=sure[name].degrees_of_freedom,
        )


def _cause_numbers(row: OutputBudget, scrambles: int | None) -> Iterator[Number]:
    """Yield contributions, by the law under every method, and Sobol' indices."""
    scale = row.output.si_per_unit
    for part in row.contributions:
        yield Number(
            subject=row.output.name,
            quantity="contribution",
            partner=part.source,
            unit=row.output.unit,
            value=part.standard_uncertainty / scale,
            floor=row.output.resolution / scale,
        )
        if part.sobol is None or scrambles is None:
            continue
        for quantity, value, ends in (
            ("sobol_first", part.sobol.first, part.sobol.first_interval),
            ("sobol_total", part.sobol.total, part.sobol.total_interval),
        ):
            yield Number(
                subject=row.output.name,
                quantity=quantity,
                partner=part.source,
                unit="1",
                value=value,
                floor=INDEX,
                standard_error=_of_interval(ends, scrambles),
                degrees_of_freedom=scrambles - 1.0,
            )


def _of_interval(ends: tuple[float, float], scrambles: int) -> float:
    """Return the standard error behind a t interval over scrambles."""
    from scipy.special import stdtrit

    from budget.methods.sobol import CONFIDENCE

    t = float(stdtrit(scrambles - 1, (1.0 + CONFIDENCE) / 2.0))
    return (ends[1] - ends[0]) / 2.0 / t


def _correlations(budget: Budget, errors: StandardErrors | None) -> Iterator[Number]:
    """Yield the correlations of the outputs of a triad that have a spread."""
    r = np.asarray(budget.correlation)
    rows: Sequence[tuple[int, OutputBudget]] = [
        (k, row) for k, row in enumerate(budget.outputs) if row.is_resolved
    ]
    for (a, one), (b, other) in combinations(rows, 2):
        if one.sensor != other.sensor:
            continue
        yield Number(
            subject=one.output.name,
            quantity="correlation",
            partner=other.output.name,
            unit="1",
            value=float(r[a, b]),
            floor=PART,
            standard_error=None if errors is None else float(errors.correlation[a, b]),
            degrees_of_freedom=None if errors is None else errors.degrees_of_freedom,
        )


def _utilisations(
    budget: Budget, assessment: Assessment, errors: StandardErrors | None
) -> Iterator[Number]:
    """Yield the part of its limit that each required output, and each sensor, uses."""
    places = {row.output.name: k for k, row in enumerate(budget.outputs)}
    worst: dict[str, Number] = {}
    for row in assessment.outputs:
        sure = _EXACT
        if errors is not None:
            sure = _Sure(
                standard_error=float(errors.end[places[row.output.name]]) / row.limit,
                degrees_of_freedom=errors.end_degrees_of_freedom,
            )
        number = Number(
            subject=row.output.name,
            quantity="utilisation",
            unit="1",
            value=row.utilisation,
            floor=row.output.resolution / row.limit,
            standard_error=sure.standard_error,
            degrees_of_freedom=sure.degrees_of_freedom,
        )
        yield number
        sensor = row.output.name.owner
        if sensor not in worst or number.value > worst[sensor].value:
            worst[sensor] = number
    for sensor, number in worst.items():
        yield Number(
            subject=sensor,
            quantity="utilisation",
            unit="1",
            value=number.value,
            floor=number.floor,
            standard_error=number.standard_error,
            degrees_of_freedom=number.degrees_of_freedom,
        )
