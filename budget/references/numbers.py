"""Results as flat lists of numbers and words, each number with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import TYPE_CHECKING

from budget.references.records import Number, Snapshot, Word
from budget.references.sampling import StandardErrors, standard_errors
from budget.studies.comparison.records import DeviceVerdict
from budget.studies.judgement import NORMAL_TRIALS
from budget.studies.request import Analysis, analysis_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from budget.names import Name
    from budget.problem import Output
    from budget.results import Budget, OutputAssessment, OutputBudget
    from budget.spec.records import Device, Procedure, Requirement
    from budget.studies.allocation.records import Allocation
    from budget.studies.comparison.records import Comparison

# A correlation coefficient, a probability or an index is a part of 1; so much of 1 is
# rounding, of the estimators of Sobol' indices too.
PART = 1e-9
# The solver of the least cost is sure of the cost to a part of 1e-6; as the cost is
# flat around its least, it is sure of a line to the root of that only.
LEAST_COST, LEAST_COST_LINE = 1e-5, 2e-3

# What the standard errors of trials are of: fields of StandardErrors.
MEAN, U, LOW, HIGH, END, CORRELATION = "mean", "u", "low", "high", "end", "correlation"


@dataclass(frozen=True, kw_only=True, eq=False)
class Certainty:
    """How sure the numbers of each output are: by rounding, and by its trials.

    Attributes
    ----------
    errors : StandardErrors or None
        Of the outputs in their places; None by the law.
    """

    places: Mapping[Name, int] = field(default_factory=dict)
    errors: StandardErrors | None = None

    @classmethod
    def of_trials(
        cls, analysis: Analysis, trials: int | None, *, interval: str = "symmetric"
    ) -> Certainty:
        """Return that of so many trials of a calibration; None: of the law."""
        if trials is None:
            return cls()
        problem, coverage = analysis.problem, analysis.coverage
        return cls(
            places={output.name: k for k, output in enumerate(problem.outputs)},
            errors=standard_errors(
                problem, trials=trials, coverage=coverage, interval=interval
            ),
        )

    def number(
        self,
        row: OutputBudget | OutputAssessment,
        quantity: str,
        value: float,
        spread: str = "",
        *,
        limit: float = 0.0,
    ) -> Number:
        """Return a number of an output, in its unit or as a part of its limit.

        Parameters
        ----------
        value, limit : float
            [SI]
        spread : str
            What its standard error is that of; '' where no trial touches it.
        """
        output = row.output
        per = limit or output.si_per_unit
        number = Number(
            subject=output.name,
            quantity=quantity,
            unit="1" if limit else output.unit,
            value=value / per,
            floor=output.resolution / per,
            lower_bound=row.lower_bound,
        )
        return self.sampled(number, spread, output, per=per) if spread else number

    def sampled(
        self, number: Number, spread: str, *outputs: Output, per: float = 1.0
    ) -> Number:
        """Return the number with its standard error over `per`, if trials made it."""
        if self.errors is None:
            return number
        place = tuple(self.places[output.name] for output in outputs)
        return replace(
            number,
            standard_error=float(getattr(self.errors, spread)[place]) / per,
            degrees_of_freedom=self.errors.freedom(spread),
        )


def budget_numbers(budget: Budget) -> Snapshot:
    """Return all that a budget says.

    Shares are left out: they are ratios of contributions; so are correlations between
    the triads, which the model keeps independent.
    """
    settings = budget.settings
    sure = Certainty.of_trials(
        analysis_of(budget), settings.trials, interval=settings.interval
    )
    numbers: list[Number] = []
    for row in budget.outputs:
        mean = sure.number(row, "mean", row.mean, MEAN)
        numbers += (
            replace(mean, lower_bound=False),
            sure.number(row, "standard_uncertainty", row.standard_uncertainty, U),
            sure.number(row, "interval_low", row.interval[0], LOW),
            sure.number(row, "interval_high", row.interval[1], HIGH),
            *_contributions(row, sure, settings.sobol_scrambles),
        )
    r = budget.correlation
    numbers += (
        sure.sampled(
            _part(one.output.name, "correlation", float(r[a, b]), other.output.name),
            CORRELATION,
            *(one.output, other.output),
        )
        for (a, one), (b, other) in combinations(enumerate(budget.outputs), 2)
        if one.is_resolved and other.is_resolved and one.sensor == other.sensor
    )
    words = [
        _not_given(sensor, (n for n in budget.not_given if n.owner == sensor))
        for sensor in dict.fromkeys(row.sensor for row in budget.outputs)
    ]
    if budget.assessment is not None:
        used = [_utilisation(row, sure) for row in budget.assessment.outputs]
        numbers += used
        rests_on = "" if sure.errors is None else "utilisation"
        for one in budget.assessment.sensors:
            own = [
                number
                for number, row in zip(used, budget.assessment.outputs, strict=True)
                if row.output.name.owner == one.sensor
            ]
            numbers.append(_largest(one.sensor, own))
            words.append(_word(one.sensor, "verdict", one.verdict, rests_on))
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def comparison_numbers(
    comparison: Comparison,
    names: Sequence[str],
    devices: Sequence[Device],
    procedures: Sequence[Procedure],
    requirement: Requirement,
) -> Snapshot:
    """Return what a comparison says of every sensor of every device.

    Ranks, worst outputs and factors are left out: where two are alike, which of them
    comes first is chance, and what they rest on is here. So is what missing lines
    could do, which depends on the whole catalogue.

    Parameters
    ----------
    comparison : Comparison
    names : sequence of str
        Of the devices, each once.
    devices, procedures, requirement
        That were compared.
    """
    numbers: list[Number] = []
    words: list[Word] = []
    by_name = {procedure.name: procedure for procedure in procedures}
    for row in comparison.entrants:
        device = names[row.place]
        if len(procedures) > 1:
            device = f"{device} @ {row.procedure}"
        subject = f"{device} {row.sensor}"
        if isinstance(row, DeviceVerdict):
            analysis = Analysis(
                devices=(devices[row.place],),
                procedure=by_name[row.procedure],
                coverage=requirement.coverage,
                reference=requirement.reference,
            ).alone(row.sensor)
            sure = Certainty.of_trials(analysis, row.trials)
            numbers += _device_numbers(row, device, sure)
            rests_on = "" if row.trials is None else "utilisation"
            words += (
                _word(subject, "verdict", row.verdict, rests_on),
                # Axes are alike: which of them is the worst may hang on rounding.
                _word(subject, "limiting_source", row.remedy.source, "utilisation"),
            )
        else:
            words.append(_word(subject, "verdict", "undecidable"))
        words.append(_not_given(subject, row.not_given))
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def allocation_numbers(allocation: Allocation) -> Snapshot:
    """Return what an allocation says of lines, limits and costs.

    What it says of the catalogue and of the procedure is left out: the one depends on
    files that are no input, the other is a search.
    """
    line = LEAST_COST_LINE if allocation.strategy == "cost" else 0.0
    # Subject, quantity, unit, value, rounding.
    rows: list[tuple[str, str, str, float | None, float]] = []
    feasible = "yes" if allocation.feasible else "no"
    words = [_word("requirement", "feasible", feasible)]
    for row in allocation.sources:
        sizes = {
            "now": row.now,
            "allowed": row.allowed,
            "headroom": None if row.headroom is None else row.headroom.value,
        }
        for quantity, size in sizes.items():
            value = None if size is None else size / row.si_per_unit
            floor = line * value if value and quantity == "allowed" else 0.0
            rows.append((row.source, quantity, row.unit, value, floor))
        words.append(_word(row.source, "status", row.status))
    for limited in allocation.outputs:
        name, least = limited.output.name, limited.output.resolution / limited.limit
        rows += (
            (name, "utilisation_now", "1", limited.now, least),
            (name, "utilisation_allowed", "1", limited.allowed, max(line, least)),
            (name, "utilisation_floor", "1", limited.floor, least),
        )
    for cost in allocation.costs:
        rows += (
            (cost.sensor, "cost_now", "1", cost.now, LEAST_COST * cost.now),
            (cost.sensor, "cost", "1", cost.cost, LEAST_COST * cost.cost),
        )
    bounds = {one.output.name for one in allocation.outputs if one.lower_bound}
    numbers = (
        Number(
            subject=subject,
            quantity=quantity,
            unit=unit,
            value=value,
            floor=floor,
            lower_bound=subject in bounds,
        )
        for subject, quantity, unit, value, floor in rows
        if value is not None
    )
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def _word(subject: str, quantity: str, text: str, rests_on: str = "") -> Word:
    """Return a word."""
    return Word(subject=subject, quantity=quantity, text=text, rests_on=rests_on)


def _not_given(subject: str, names: Iterable[Name]) -> Word:
    """Return the word on the lines that are not given."""
    return _word(subject, "not_given", ", ".join(names))


def _part(subject: str, quantity: str, value: float, partner: str = "") -> Number:
    """Return a part of 1: an index, a correlation, a probability."""
    return Number(
        subject=subject,
        quantity=quantity,
        partner=partner,
        unit="1",
        value=value,
        floor=PART,
    )


def _contributions(
    row: OutputBudget, sure: Certainty, scrambles: int | None
) -> Iterator[Number]:
    """Yield contributions, by the law under every method, and Sobol' indices."""
    for part in row.contributions:
        number = sure.number(row, "contribution", part.standard_uncertainty)
        yield replace(number, partner=part.source, lower_bound=part.lower_bound)
        if part.sobol is None or scrambles is None:
            continue
        for quantity, value, ends in (
            ("sobol_first", part.sobol.first, part.sobol.first_interval),
            ("sobol_total", part.sobol.total, part.sobol.total_interval),
        ):
            yield replace(
                _part(row.output.name, quantity, value, part.source),
                standard_error=_of_interval(ends, scrambles),
                degrees_of_freedom=scrambles - 1.0,
            )


def _of_interval(ends: tuple[float, float], scrambles: int) -> float:
    """Return the standard error behind a t interval over scrambles."""
    from scipy.special import stdtrit

    from budget.methods.sobol import CONFIDENCE

    t = float(stdtrit(scrambles - 1, (1.0 + CONFIDENCE) / 2.0))
    return (ends[1] - ends[0]) / 2.0 / t


def _device_numbers(
    row: DeviceVerdict, device: str, sure: Certainty
) -> Iterator[Number]:
    """Yield the numbers of one sensor of one device."""
    for one in row.outputs:
        for number in (
            sure.number(one, "standard_uncertainty", one.standard_uncertainty, U),
            sure.number(one, "largest_error", one.largest_error, END),
            replace(
                _part(one.output.name, "conformance", one.conformance),
                trials=row.trials,
                lower_bound=one.lower_bound,
            ),
        ):
            yield replace(number, subject=f"{device} {one.output.name}")
    subject = f"{device} {row.sensor}"
    yield _largest(subject, [_utilisation(one, sure) for one in row.outputs])
    yield replace(
        _part(subject, "conformance", row.conformance.value),
        trials=row.trials or NORMAL_TRIALS,  # by the law counted in draws of it
        lower_bound=row.lower_bound,
    )


def _utilisation(row: OutputAssessment, sure: Certainty) -> Number:
    """Return the part of its limit that a required output uses."""
    return sure.number(row, "utilisation", row.largest_error, END, limit=row.limit)


def _largest(subject: str, numbers: Sequence[Number]) -> Number:
    """Return the largest of several numbers as one of their sensor.

    It strays no further than that of them which strays furthest.
    """
    errors = [n.standard_error for n in numbers if n.standard_error is not None]
    return replace(
        max(numbers, key=lambda number: number.value),
        subject=subject,
        floor=max(number.floor for number in numbers),
        standard_error=max(errors) if errors else None,
        lower_bound=any(number.lower_bound for number in numbers),
    )
