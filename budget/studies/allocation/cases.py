"""A sensor's or a mission's part of an allocation: limits, bounds, costs as a task."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, log10
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mission import on_the_way
from budget.calibration.problem import retimed
from budget.distributions import NORMAL, normal_coverage_factor
from budget.errors import CallError
from budget.methods.allocation import Task, equal, sparing
from budget.methods.least_cost import LeastCost, Prices, least_cost
from budget.methods.scaling import scaled_law
from budget.model.estimators import estimator_of
from budget.names import Name
from budget.studies.allocation.records import FREE, HELD, SHARED, ZERO, CoverageCheck
from budget.studies.judgement import judge
from budget.ties import equal_to
from budget.units import DEGREE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import (
        Costs,
        Procedure,
        Sensor,
    )
    from budget.methods.scaling import ScaledLaw
    from budget.problem import Output
    from budget.question import Question
    from budget.studies.judgement import Judged

STRATEGIES = ("proportional", "equal", "cost")

# What a line may grow to unless the call says otherwise.
SCALE_FACTOR_CEILING = 0.01  # [1]
ANGLE_CEILING = DEGREE  # [rad]
OTHER_CEILING = 100.0  # times the present value [1]
MOST_DECADES = 50  # of a price: what lies further apart adds to no sum
COVERAGE_OFF = 0.002  # [1]; a coverage further off corrects the allocation
# Relative change of an error by its own filter, in the place of the one before, from
# which on no more are built: what is left then is of the order of its square [1].
TUNED = 1e-4
EXACT = 1e-9  # the same of a filter that is not the best: of the order of itself [1]
RETUNINGS = 30  # at the most


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """What the call says of single sources, by full names, largest axis [SI]."""

    held: frozenset[Name]
    most: Mapping[Name, float]
    least: Mapping[Name, float]


NO_BOUNDS = Bounds(held=frozenset(), most={}, least={})


@dataclass(frozen=True, kw_only=True, eq=False)
class SensorCase:
    """One required sensor, or both by a mission: the task, and what became of it."""

    question: Question  # alone of the triad, or of the mission
    # With the coverage factors, and the filter if any, allocated with in the end.
    task: Task
    law: ScaledLaw  # with the filter of the present state
    least_law: ScaledLaw  # with that of free sources as small as they may be
    outputs: Mapping[Name, Output]  # of its owner, by name
    statuses: tuple[str, ...]  # of each source
    # The present state, as every command judges it, and coverage factors from that
    # which equal outputs share, shape (n_out,) [1].
    judged: Judged
    present_factor: Array
    # Free sources that are left as they are as they do not matter, shape (n_src,).
    spared: NDArray[np.bool_]
    # Factors; None where the limits cannot be met, shape (n_src,).
    s: Array | None = None
    # Factors before Monte Carlo corrected them; None where it did not, shape (n_src,).
    by_law: Array | None = None
    prices: Prices | None = None
    solution: LeastCost | None = None
    checks: tuple[CoverageCheck, ...] = ()

    @property
    def owner(self) -> str:
        """Owner of the limits: the triad, or the mission."""
        return self.question.owner

    @property
    def kinds(self) -> tuple[str, ...]:
        """The triads whose lines are shared out."""
        return tuple(sensor.kind for sensor in self.question.sensors)

    @property
    def factors(self) -> Array:
        """The allocated factors, of the present state where there are none."""
        return self.task.now if self.s is None else self.s

    @property
    def present(self) -> Task:
        """The task by the coverage factors and the filter of the present state."""
        return replace(self.task, law=self.law, coverage_factor=self.present_factor)

    @property
    def is_feasible(self) -> bool:
        """Whether the limits can be met at all."""
        return replace(self.task, law=self.least_law).is_feasible

    @property
    def is_tuned(self) -> bool:
        """Whether a filter goes with the lines."""
        mission = self.question.journey
        return mission is not None and bool(mission.aiding)

    @property
    def tuned_to(self) -> float:
        """From which change of an error on filters are built no more [1]."""
        mission = self.question.journey
        best = mission is None or mission.filter is None
        return TUNED if best else EXACT

    @property
    def normal_factor(self) -> Array:
        """Coverage factors of a normal error, shape (n_out,) [1]."""
        wanted = self.question.wanted
        limited = {one.output: one for one in wanted.limits}
        coverage = [wanted.coverage_of(limited[name]) for name in self.task.law.outputs]
        return np.asarray(normal_coverage_factor(np.array(coverage)))

    @property
    def allocated(self) -> tuple[Sensor, ...]:
        """The triads with their lines as allocated."""
        return tuple(
            resize(sensor, self.task.law.sources, self.factors)
            for sensor in self.question.sensors
        )

    def known(self, s: Array) -> tuple[float, ...]:
        """Return factors that a filter knows; of what has none those of all are one."""
        return tuple((s if self.is_tuned else self.task.now).tolist())

    def law_of(
        self, known: Sequence[float] | Array, procedure: Procedure | None = None
    ) -> ScaledLaw:
        """Return the law whose filter, if any, is that of a unit with these factors.

        Maybe after another calibration. Shape (n_src,).
        """
        names = self.task.law.sources
        one = self.question.under(procedure or self.question.procedure)
        knows = one.with_sensors(
            resize(x, names, np.asarray(known)) for x in one.sensors
        )
        problem = replace(one, designed=knows).problem
        return scaled_law(problem).select(self.task.law.outputs)

    def retimed(self, procedure: Procedure) -> ScaledLaw:
        """Return the law by windows of other lengths, that change but the noise."""
        one, is_led = self.question, self.question.journey is not None
        sensors, how = one.sensors, procedure
        if is_led:
            sensors, how = on_the_way(sensors, how)
        problem = retimed(one.problem, sensors, how, every=is_led)
        return scaled_law(problem, one.law).select(self.task.law.outputs)

    @property
    def found(self) -> Question:
        """The calibration, or the mission, with the lines as allocated."""
        return self.question.kept(self.factors.tobytes(), self._resized)

    def _resized(self) -> Question:
        """Return it; its Problem has the groups of what there is, resized."""
        found = self.question.with_sensors(self.allocated)
        estimator = estimator_of(self.question.procedure.formulas)
        if not self.is_tuned and not estimator.weighs_noise:
            vars(found)["problem"] = self.question.problem.resized(self.factors)
        return found

    def at_most(self, ceilings: Mapping[Name, float]) -> SensorCase:
        """Return the case with no line above these factors, by the name of its line."""
        task = self.task
        most = [ceilings.get(name, inf) for name in task.law.sources]
        high = np.where(task.free, np.minimum(task.high, most), task.high)
        return replace(
            self, task=replace(task, high=high, low=np.minimum(task.low, high))
        )


def set_up(
    question: Question,
    bounds: Bounds,
    market: Mapping[Name, float],
    *,
    seed: int = 0,
) -> SensorCase | None:
    """Return the task of one sensor, None where nothing is required of it.

    Or of a gyro and an accelerometer by a mission. Its coverage factors are those of
    the law; the present state is judged as every command does, and has the k of trials
    where these find another coverage than the law's.
    """
    kinds = [sensor.kind for sensor in question.sensors]
    problem, requirement, held = question.problem, question.wanted, question.held
    if held is None:
        return None
    names = {output.name for output in held.outputs}
    limits = [limit for limit in requirement.limits if limit.output in names]
    given = question.lines
    law = scaled_law(problem, question.law)
    statuses, low, high = [], [], []
    for name in law.sources:
        now = given[name].largest
        statuses.append(_status(name, now, bounds, kinds))
        least, most = _bounds_of(name, now, bounds, market)
        low.append(least)
        high.append(most)
    required = tuple(limit.output for limit in limits)
    coverage = np.array([requirement.coverage_of(limit) for limit in limits])
    judged = judge(held, seed=seed)
    task = Task(
        law=law.select(required),
        limit=np.array([limit.limit for limit in limits]),
        coverage_factor=normal_coverage_factor(coverage),
        coverage=None if question.journey is None else coverage,
        free=np.array([status == FREE for status in statuses], dtype=bool),
        low=np.array(low),
        high=np.array(high),
    )
    k = judged.factor / task.roundness(task.now)
    is_off = np.abs(2.0 * NORMAL.probability(k) - 1.0 - coverage) > COVERAGE_OFF
    factor = np.where(judged.by_trials & is_off, k, task.coverage_factor)
    factor = shared_by_equals(task, task.now, factor)
    case = SensorCase(
        question=question,
        outputs={output.name: output for output in problem.outputs},
        statuses=tuple(statuses),
        judged=judged,
        present_factor=factor,
        spared=np.zeros(len(statuses), dtype=bool),
        task=task,
        law=task.law,
        least_law=task.law,
    )
    return replace(case, least_law=case.law_of(task.least)) if case.is_tuned else case


def shared_by_equals(task: Task, s: Array, factor: Array) -> Array:
    """Return coverage factors of which equal outputs share the largest one.

    Equal are those of one parameter that use as much of their limits by one k: trials
    tell equal axes apart by their sampling alone. Shapes (n_src,) of the sources'
    factors and (n_out,) [1].
    """
    used = replace(task, coverage_factor=np.ones_like(factor)).utilisation(s).tolist()
    groups = [name.group for name in task.law.outputs]
    return np.array(
        [
            max(float(factor[j]) for j in equal_to(used, k) if groups[j] == groups[k])
            for k in range(len(used))
        ]
    )


def solve(case: SensorCase, strategy: str, costs: Costs | None) -> SensorCase:
    """Allocate by the law with the coverage factors of the task.

    The filter of a mission is that of the unit as allocated. With given gains K a
    variance V(q, K) is linear in the squared factors q; that of the filter that knows q
    is V(q) = min over K of V(q, K), which is concave, below V(q, K) everywhere and
    tangent to it at the q of K. So what meets the limits with the gains of other values
    does with its own, and to share out again with these is a step of Newton's method,
    which comes to the limits from below.
    """
    found = _share_out(case, strategy, costs)
    for _ in range(RETUNINGS if case.is_tuned else 0):
        task = replace(found.task, law=case.law_of(found.factors))
        before = found.task.utilisation(found.factors)
        off = np.abs(task.utilisation(found.factors) / before - 1.0).max()
        mattered = task.free & ~found.spared
        found = _share_out(replace(found, task=task), strategy, costs, mattered)
        if off <= case.tuned_to:
            break
    return found


def _share_out(
    case: SensorCase,
    strategy: str,
    costs: Costs | None,
    mattered: NDArray[np.bool_] | None = None,
) -> SensorCase:
    """Allocate with the filter that there is; what mattered once still does."""
    if strategy == "cost":
        prices = _prices(case, costs)
        solution = least_cost(case.task, prices)
        return replace(case, s=solution.s, prices=prices, solution=solution)
    if strategy == "equal":
        return replace(case, s=equal(case.task))
    shared = sparing(case.task, now=case.law, known=mattered)
    return replace(case, s=shared.s, spared=shared.spared)


def resize(sensor: Sensor, sources: Sequence[Name], factors: Array) -> Sensor:
    """Return a sensor with its lines multiplied; correlation times stay."""
    by_name = dict(zip(sources, factors, strict=True))
    return replace(
        sensor,
        lines=tuple(
            replace(
                line, u=line.u * by_name.get(Name(line.name, owner=sensor.kind), 1.0)
            )
            for line in sensor.lines
        ),
    )


def _status(name: Name, now: float, bounds: Bounds, kinds: Sequence[str]) -> str:
    """Say whether a source of a triad may change; what is not its own does not."""
    if now == 0.0:
        return ZERO
    if name.owner not in kinds:
        return SHARED
    return HELD if name in bounds.held else FREE


def _bounds_of(
    name: Name, now: float, bounds: Bounds, market: Mapping[Name, float]
) -> tuple[float, float]:
    """Return least and largest factor of one source; a default never asks for less."""
    if now == 0.0:
        return 0.0, 1.0
    line = name.quantity
    if line.startswith("scale_factor"):
        most = max(SCALE_FACTOR_CEILING, now)
    elif line.startswith("mounting"):
        most = max(ANGLE_CEILING, now)
    else:
        most = OTHER_CEILING * now
    least = min(market.get(name, 0.0), now)
    least, most = bounds.least.get(name, least), bounds.most.get(name, most)
    if least > most:
        raise CallError(
            f"{name}: the least value, {least:.6g}, is above the largest, {most:.6g} "
            "(SI units); change --min, --max or --market"
        )
    return least / now, most / now


def _prices(case: SensorCase, costs: Costs | None) -> Prices:
    """Return the cost of each source as a function of its factor.

    Raises
    ------
    CallError
        A cost is beyond what can be weighed against others.
    """
    named = {cost.source: cost for cost in costs.costs} if costs is not None else {}
    c, p = [], []
    for name in case.task.law.sources:
        cost = named.get(name)
        now = case.question.lines[name].largest
        power = 1.0 if cost is None else cost.p
        ratio = 1.0
        if cost is not None and cost.u_ref is not None and now > 0.0:
            # In the maker's own terms, of a floor of the Allan curve 0.664 B.
            ratio = cost.u_ref * case.question.lines[name].factor / now
        if abs(power * log10(ratio)) > MOST_DECADES:
            raise CallError(
                f"costs.{name}: u_ref is {ratio:.3g} times the "
                f"present value, which to the power of {power:g} is no price, expected "
                f"1e-{MOST_DECADES} to 1e{MOST_DECADES}; see to u_ref and p"
            )
        c.append((1.0 if cost is None else cost.a) * ratio**power)
        p.append(power)
    return Prices(c=np.array(c), p=np.array(p))
