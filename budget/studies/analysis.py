"""Analysis: devices and a procedure in, the budget of every parameter out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import combination
from budget.calibration.schemes import estimated
from budget.calibration.simulation import simulate
from budget.errors import CallError
from budget.known import Known
from budget.methods.execution import BLOCK, draw, small_blocks
from budget.methods.intervals import interval_of_values
from budget.methods.monte_carlo import (
    MAX_TRIALS,
    first_stage_trials,
    least_trials,
    sample,
)
from budget.methods.radius import circles
from budget.methods.sobol import SCRAMBLES, SobolResult, evaluations, sobol
from budget.methods.validation import MAX_TRIALS as VALIDATION_TRIALS
from budget.methods.validation import validate as validate_law
from budget.missing.expected import could_widen
from budget.model.sources import SENSORS
from budget.names import IMU, MISSION, Name
from budget.question import (
    Question,
    question_of,
)
from budget.results import (
    BY_LAW,
    BY_PREDICTION,
    BY_TRIALS,
    CEP,
    INTERACTION,
    R95,
    Budget,
    Compensation,
    Contribution,
    OutputBudget,
    Radii,
    SobolIndex,
    Validation,
    u_known,
)
from budget.sentences import sentence
from budget.settings import Asked, Engine, Inputs, asking, check
from budget.studies import blunders, cautions
from budget.studies.compensation import compensations
from budget.studies.conformity import assess, open_to
from budget.studies.doubt import ONE_SIGMA, Mixture
from budget.studies.envelope import envelope
from budget.studies.input_quantities import input_quantities, sensitivities
from budget.studies.judgement import intervals_of
from budget.studies.mission import bought, filtered, too_sure
from budget.studies.readings import effects

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import Device, Requirement
    from budget.problem import Problem
    from budget.settings import Settings

# An interaction below this is the rounding of the estimators [1].
ROUNDING = 1e-9
SIMULATED_RUNS = 200  # where no number is asked for


@dataclass(frozen=True, kw_only=True, eq=False)
class MethodEstimate:
    """What one method says of all outputs, in their order [SI]."""

    method: str  # 'law', 'monte-carlo' or 'simulation'
    trials: int | None
    mean: Array  # shape (n_out,)
    covariance: Array  # shape (n_out, n_out)
    interval: Array  # shape (n_out, 2)
    # Of the law, output by output, where it gives the interval.
    validations: tuple[Validation | None, ...]
    # Whether the interval is of trials by the method gum too, shape (n_out,).
    by_trials: NDArray[np.bool_] | None = None
    warnings: tuple[str, ...] = ()
    # CEP and R95 of the lengths, shape (2, n_lengths); None: of a normal law.
    circles: Array | None = None
    assumptions: tuple[str, ...] = ()


@asking("analyze")
def analyze(
    *devices: Device | File,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    command: str = "analyze",
) -> Budget:
    """Compute the error budget of a calibration, or of a mission after it.

    Parameters
    ----------
    *devices : Device
        Together at most one gyro and one accelerometer.
    command : str
        Name of the job in the result.

    Returns
    -------
    Budget

    Raises
    ------
    CallError
        Options or devices that do not fit together.
    """
    question = Question.load(*devices, inputs=inputs, asked=asked)
    return analyze_as(asked.settle(), question, engine=engine, command=command)


def analyze_as(
    settings: Settings,
    question: Question,
    *,
    engine: Engine | None = None,
    command: str = "analyze",
) -> Budget:
    """Compute the budget as `analyze` does; what the question says goes before."""
    engine = Engine() if engine is None else engine
    settings = replace(
        settings, coverage=question.coverage, reference=question.reference
    )
    check("analyze", settings, engine)
    procedure, sensors = question.procedure, question.sensors
    requirement = question.requirement
    of_test = question.journey is None
    if settings.matrices and not of_test:
        raise CallError(
            "outputs and matrices are of a calibration, and this is of a mission, "
            "which has neither; leave --outputs and --matrices out"
        )
    chosen, warnings = question.only, cautions.asked_alone(question)
    problem, law = question.problem, question.law
    if engine.talk is not None:
        for text in _costs(problem, settings, engine.workers):
            engine.talk(text)
    warnings += cautions.options_without_effect(
        settings.method, trials=settings.trials, interval=settings.interval
    )
    if chosen is None:
        warnings += cautions.unknown_zeros(problem, law)
    warnings += cautions.beyond_first_order(problem, law)
    # Of some sources alone what is true is no measure of what the filter believes.
    found_out = filtered(question) if chosen is None else None
    warnings += too_sure(found_out, requirement)
    warnings += cautions.saturated(question)
    warnings += cautions.of_no_vehicle(question.journey)
    if chosen is None and of_test:
        warnings += cautions.say_unfelt(cautions.unfelt(question))
        warnings += blunders.worth_saying(procedure, sensors, law, problem, requirement)
    estimate = ESTIMATORS[settings.method](question, settings, engine)
    estimate = _over_missing(question, estimate)
    warnings += estimate.warnings
    warnings += cautions.few_trials(estimate.trials, settings.coverage)
    indices = None
    if settings.samples is not None and problem.normals_per_trial == 0:
        warnings += (sentence("cautions.nothing_varies"),)
    elif settings.samples is not None:
        indices = sobol(
            problem,
            samples=settings.samples,
            seed=settings.seed,
            workers=engine.workers,
            executor=engine.executor,
            progress=engine.stage("Sobol' indices"),
        )
    matrices: dict[str, Compensation] = {}
    if settings.matrices:
        matrices, absent = compensations(question)
        warnings += absent
    is_simulated = settings.method == "simulation"
    settings = replace(
        settings,
        trials=estimate.trials,
        formulas=procedure.formulas,
        normals_per_trial=None if is_simulated else problem.normals_per_trial,
        only=tuple(sorted(chosen or ())),
        outputs=question.asked or (),
        samples=None if indices is None else indices.samples,
        sobol_scrambles=None if indices is None else indices.scrambles,
    )
    assumed = (
        *(() if of_test else cautions.left_behind(sensors, procedure)),
        *cautions.shared_constants(sensors, procedure, settings.reference),
        *estimate.assumptions,
    )
    budget = Budget(
        **envelope(question, settings, assumed=assumed, warned=warnings),
        command=command,
        outputs=tuple(
            _as_given(row, settings.coverage)
            for row in _output_budgets(question, estimate, indices=indices)
        ),
        covariance=estimate.covariance,
        could_widen=could_widen(
            sensors,
            procedure,
            reference=settings.reference,
            on=question.carried,
        ),
        matrices=matrices,
        quantities=input_quantities(question),
        filled=question.filled.lines,
        left=question.filled.left,
        readings=effects(question) if chosen is None and of_test else (),
        mission=question.journey,
        filter=found_out,
    )
    budget = budget if requirement is None else _judge(budget, requirement)
    return replace(
        budget,
        bought=() if of_test or chosen is not None else bought(question, budget),
        warnings=(
            *budget.warnings,
            *cautions.judged_otherwise(budget),
            *cautions.doubts(budget.outputs),
        ),
    )


def _by_law(question: Question, settings: Settings, engine: Engine) -> MethodEstimate:
    """Propagate, and have Monte Carlo check it.

    Where the law is not sure enough of an interval, it is that of the trials by which
    limits are judged; what has a limit is judged later.
    """
    problem, law, coverage = question.problem, question.law, settings.coverage
    found = intervals_of(question, seed=settings.seed)
    estimate = MethodEstimate(
        method=BY_LAW,
        trials=None,
        mean=law.mean,
        covariance=law.covariance,
        interval=found.ends,
        by_trials=found.by_trials,
        validations=(None,) * len(problem.outputs),
    )
    if not settings.validate:
        return estimate
    if _most_to_validate(settings.digits) < least_trials(coverage):
        text = sentence(
            "cautions.not_validated", coverage=coverage, least=least_trials(coverage)
        )
        return replace(estimate, warnings=(text,))
    validations = validate_law(
        problem,
        law,
        coverage=coverage,
        digits=settings.digits,
        max_trials=_validation_cap(settings),
        seed=settings.seed,
        workers=engine.workers,
        executor=engine.executor,
        progress=engine.stage("Monte Carlo check of the law"),
    )
    return replace(
        estimate,
        validations=tuple(
            None if by_trials else validation
            for by_trials, validation in zip(found.by_trials, validations, strict=True)
        ),
    )


def _by_trials(
    question: Question, settings: Settings, engine: Engine
) -> MethodEstimate:
    """Propagate distributions by Monte Carlo."""
    problem = question.problem
    drawn = sample(
        problem,
        trials=settings.trials,
        digits=settings.digits,
        max_trials=settings.max_trials or MAX_TRIALS,
        coverage=settings.coverage,
        interval=settings.interval,
        seed=settings.seed,
        workers=engine.workers,
        executor=engine.executor,
        progress=engine.stage("Monte Carlo"),
    )
    return MethodEstimate(
        method=BY_TRIALS,
        trials=drawn.trials,
        mean=drawn.mean,
        covariance=drawn.covariance,
        interval=drawn.interval,
        validations=(None,) * len(problem.outputs),
        warnings=cautions.unsettled(problem, drawn),
    )


def _by_simulation(
    question: Question, settings: Settings, engine: Engine
) -> MethodEstimate:
    """Simulate the calibration run after run, and take moments and intervals."""
    if question.journey is not None:
        raise CallError(
            "--method simulation simulates the calibration, and a mission takes "
            "its noise in run besides; take gum or monte-carlo"
        )
    if any(one.measured for one in question.devices):
        raise CallError(
            "--method simulation simulates the calibration that is predicted, and "
            "--measured is of one that was done; take gum or monte-carlo"
        )
    runs = SIMULATED_RUNS if settings.trials is None else settings.trials
    progress = engine.stage("simulated calibrations")
    columns = []
    for run in range(runs):
        columns.append(
            simulate(
                question.sensors,
                question.procedure,
                seed=settings.seed,
                reference=settings.reference,
                only=question.only,
                run=run,
            )
        )
        if progress is not None:
            progress(run + 1, runs)
    errors = np.stack(columns, axis=1)
    if question.outputs is not None:
        names = [
            name
            for one in question.sensors
            for name in estimated(one.kind, question.procedure)
        ]
        errors = combination(names, question.outputs)(errors)
    return MethodEstimate(
        method="simulation",
        trials=runs,
        mean=errors.mean(axis=1),
        covariance=np.atleast_2d(np.cov(errors)),
        interval=interval_of_values(
            np.sort(errors), settings.coverage, settings.interval
        ),
        validations=(None,) * len(errors),
    )


ESTIMATORS = {
    "gum": _by_law,
    "monte-carlo": _by_trials,
    "simulation": _by_simulation,
}


def _over_missing(question: Question, estimate: MethodEstimate) -> MethodEstimate:
    """Return an estimate over what predicted lines may be, not at their medians.

    Of a mission; all others as they are. Correlations are those at the medians.
    """
    mixture = Mixture.of(question)
    if mixture is None:
        return estimate
    law, legs = question.law, question.problem.legs
    half = mixture.half_widths(question.coverage, question)
    u = mixture.half_widths(ONE_SIGMA, question)
    first = u.size - legs.shape[1]
    u[first:] = np.hypot(*u[legs])  # as of DRMS, which no circle is of
    before = law.standard_uncertainty
    ratio = np.divide(u, before, out=np.ones_like(u), where=before > 0.0)
    return replace(
        estimate,
        method=BY_PREDICTION,
        mean=law.mean,
        covariance=law.covariance * np.outer(ratio, ratio),
        interval=np.stack([law.mean - half, law.mean + half], axis=1),
        circles=np.stack(
            [mixture.half_widths(p, question)[first:] for p in (CEP, R95)]
        ),
        assumptions=(sentence("cautions.mixture"),),
    )


def _judge(budget: Budget, requirement: Requirement) -> Budget:
    """Judge a budget; its required outputs get the intervals that were judged."""
    assessment = assess(budget, requirement)
    judged = {row.output.name: row for row in assessment.outputs}
    lacks = open_to(question_of(budget), assessment)
    return replace(
        budget,
        assessment=assessment,
        outputs=tuple(
            _as_given(
                replace(
                    row,
                    interval=found.interval,
                    interval_by=found.interval_by,
                    coverage=found.coverage,
                    validation=None if found.by_trials else row.validation,
                ),
                budget.settings.coverage,
            )
            if (found := judged.get(row.output.name)) is not None
            # What is judged is judged at the medians.
            and row.interval_by != BY_PREDICTION
            else row
            for row in [row.lacking(lacks[row.output.name]) for row in budget.outputs]
        ),
    )


# Moments, sorting and gathering take about as long again as evaluating the model.
GATHERING = 1.3  # [1]


def seconds_per_trial(problem: Problem) -> float:
    """Time a block of trials, drawn and evaluated, on this machine: best of three."""
    x = np.empty((problem.n_inputs, BLOCK))
    times = []
    with small_blocks():
        for block in range(3):
            begun = perf_counter()
            problem.evaluate(draw(problem, 0, block, x))
            times.append(perf_counter() - begun)
    return GATHERING * min(times) / BLOCK


def describe_cost(what: str, number: int, seconds: float, workers: int) -> str:
    """Return one line: what is done how often, and about how long it takes."""
    each = f" on {workers} workers" if workers > 1 else ""
    count = f"{number:,}".replace(",", " ")
    return f"{what}: {count} model evaluations, about {seconds / workers:.0f} s{each}"


def _costs(problem: Problem, settings: Settings, workers: int) -> Iterator[str]:
    """Say what validation to two digits and Sobol' indices will cost."""
    two_digits = settings.method == "gum" and settings.validate and settings.digits > 1
    if not (two_digits or settings.samples):
        return
    each = seconds_per_trial(problem)
    if two_digits:
        most = _validation_cap(settings)
        yield describe_cost(
            "Monte Carlo to validate two digits, at most", most, most * each, workers
        )
    if settings.samples:
        number = evaluations(problem, settings.samples, SCRAMBLES)
        yield describe_cost("Sobol' indices", number, number * each, workers)


def _validation_cap(settings: Settings) -> int:
    """Return the trials that validation takes at the most, its first stage at least."""
    least = first_stage_trials(settings.coverage, settings.digits)
    return max(_most_to_validate(settings.digits), least)


def _most_to_validate(digits: int) -> int:
    """Return the trials that are worth it to validate so many digits."""
    # A tolerance ten times smaller takes a hundred times as many trials.
    return VALIDATION_TRIALS * (100 if digits > 1 else 1)


def _output_budgets(
    question: Question,
    estimate: MethodEstimate,
    *,
    indices: SobolResult | None,
) -> tuple[OutputBudget, ...]:
    """Put the estimate and the law's contributions together, output by output."""
    problem, law, lacks = question.problem, question.law, question.lacks
    names = [group.name for group in problem.groups]
    radii = _radii(problem, estimate)
    c = sensitivities(question)
    u = np.sqrt(np.diag(estimate.covariance))
    factor = law.coverage_factor(question.coverage)
    of_others = {one.source for one in question.filled.lines}
    by_trials = estimate.by_trials
    budgets = []
    for k, output in enumerate(problem.outputs):
        # The other triad's own sources stand here only if they reach this output.
        variances = [
            (name, variance)
            for name, variance in zip(names, law.source_variance[:, k], strict=True)
            if name.owner not in SENSORS
            or output.name.owner in {name.owner, IMU, MISSION}
            or variance > 0.0
        ]
        is_known = not lacks[output.name] and not any(
            variance > output.resolution**2
            for name, variance in variances
            if name in of_others
        )
        variances.append((INTERACTION, law.interaction_variance[k]))
        total = float(sum(variance for _, variance in variances))
        budgets.append(
            OutputBudget(
                output=output,
                mean=float(estimate.mean[k]),
                standard_uncertainty=u_known(output, u[k], lacks[output.name]),
                interval=(
                    float(estimate.interval[k, 0]),
                    float(estimate.interval[k, 1]),
                ),
                contributions=tuple(
                    Contribution(
                        source=name,
                        standard_uncertainty=Known.of(
                            float(np.sqrt(max(variance, 0.0))),
                            lacks[output.name] if name == INTERACTION else (),
                        ),
                        share=float(variance) / total if total > 0.0 else 0.0,
                        sobol=_sobol_index(indices, name, k),
                        u_input=float(c[name].u_input[k]) if name in c else None,
                        sensitivity=float(c[name].c[k]) if name in c else None,
                        line_unit=c[name].unit if name in c else None,
                    )
                    for name, variance in variances
                ),
                interval_by=BY_TRIALS
                if by_trials is not None and by_trials[k]
                else estimate.method,
                u_by=estimate.method,
                law_factor=float(factor[k]),
                validation=estimate.validations[k],
                radii=radii.get(output.name),
                degrees_of_freedom=float(law.degrees_of_freedom[k])
                if is_known and estimate.method == BY_LAW
                else None,
            )
        )
    return tuple(budgets)


def _radii(problem: Problem, estimate: MethodEstimate) -> dict[Name, Radii]:
    """Return CEP and R95 of the lengths among the outputs."""
    lengths = [output.name for output in problem.outputs if output.length_of]
    if not lengths:
        return {}
    found = estimate.circles
    if found is None:
        C, legs = estimate.covariance, problem.legs
        found = np.stack([circles(C, legs, p) for p in (CEP, R95)])
    return {
        name: Radii(cep=float(cep), r95=float(r95))
        for name, cep, r95 in zip(lengths, *found, strict=True)
    }


def _as_given(row: OutputBudget, coverage: float) -> OutputBudget:
    """Return a row whose CEP and R95 are what its interval of that coverage says."""
    p = coverage if row.coverage is None else row.coverage
    if row.radii is None or p not in {CEP, R95}:
        return row
    key = "cep" if p == CEP else "r95"
    return replace(row, radii=replace(row.radii, **{key: row.largest_error}))


def _sobol_index(
    indices: SobolResult | None, source: str, output: int
) -> SobolIndex | None:
    """Return the indices of one source for one output, None where there are none."""
    if indices is None or source not in indices.factors:
        return None
    f = indices.factors.index(source)
    first, total, both = indices.first, indices.total, indices.interaction
    if np.isnan(total.value[f, output]):  # the output does not vary
        return None
    return SobolIndex(
        first=max(float(first.value[f, output]), 0.0),
        first_interval=(float(first.low[f, output]), float(first.high[f, output])),
        total=max(float(total.value[f, output]), 0.0),
        total_interval=(float(total.low[f, output]), float(total.high[f, output])),
        interacts=bool(both.low[f, output] > ROUNDING),
        rank=indices.ranks(output)[f],
    )
