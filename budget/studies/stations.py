"""Test stations for a requirement: how good each figure must be, which station does.

The part of a station in the error of an output k is its expanded uncertainty alone,
U_k = k_p u_k, with the variance of the law of propagation over the sources of station
and environment that are uncertainties of the test itself,

    u_k^2 = sum_s a_ks u_s^2 + sum_st P_kst u_s^2 u_t^2 ,

all lines of the device being 0 (budget.methods.scaling). A station does where it takes
no more of a limit than the ratio R asked for allows: R U_k <= limit. Turned round it is
an allocation with the limits limit / R, solved as every allocation is
(budget.methods.allocation).

What is measured there has more than the station in it: U_m = k_p u_m is the expanded
uncertainty of the whole measurement, the noise of the device in that test and the
station together, of the error as tested. The test uncertainty ratio is limit / U_m, and
a measured value is accepted up to A = limit - r U_m: guarded acceptance, JCGM 106:2012,
8.3.2. The probability of false accept is that of all items that are accepted and beyond
the limit (JCGM 106:2012, 9.5.2; 2 % at the most by ANSI/NCSL Z540.3, 5.3 b),

    PFA = P(|eta| > limit and |eta + e| <= A) ,  eta ~ N(0, u_0), e ~ N(0, u_m) ,

u_0 being what the lines of the device say of the parameter before anything is measured:
the variance of the error against its nominal value less that of the error as tested.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import known_outputs, outputs_for
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import (
    removal,
    schemes_of,
    with_accelerometers,
)
from budget.distributions import NORMAL, normal_coverage_factor
from budget.documents import Documented, written
from budget.errors import CallError
from budget.inputs import (
    load_station,
    load_stations,
)
from budget.inputs.records import UNCALIBRATED, ErrorLine
from budget.inputs.station import IDEAL, at_station
from budget.inputs.use import of_the_test
from budget.methods.allocation import Task, equal, headroom, proportional
from budget.methods.decisions import acceptance_interval, global_risks
from budget.methods.gum import propagate
from budget.methods.scaling import NEGLIGIBLE, scaled_law
from budget.model.estimators import estimator_of
from budget.model.source import Disturbance, Statistics, Triad
from budget.model.sources import (
    ENVIRONMENT,
    IN_RUN,
    STATION,
    TEST,
    lines_of,
    source_of,
)
from budget.names import Name, by_group
from budget.question import Question, given_lines
from budget.results import LimitedOutput, Study
from budget.sentences import described, sentence
from budget.settings import Asked, Inputs, asking
from budget.studies.blunders import against_limits
from budget.studies.envelope import envelope
from budget.studies.verdicts import stand
from budget.ties import first_largest, largest, settle
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import (
        Device,
        Limit,
        Procedure,
        Sensor,
        Station,
    )
    from budget.methods.gum import Propagation
    from budget.methods.scaling import ScaledLaw
    from budget.model.source import Source
    from budget.problem import Problem
    from budget.results import Verdict

RATIO, LEAST_RATIO, MOST_RATIO = 4.0, 1.0, 1000.0  # limit over U of the station [1]
GUARD, MOST_GUARD = 1.0, 10.0  # r, of a guard band r U [1]
MOST_FALSE_ACCEPT = 0.02  # ANSI/NCSL Z540.3, 5.3 b [1]
STRATEGIES = ("equal", "proportional")

# Up to where the law of second order is trusted, by the usual unit of a source.
CEILINGS = {
    "arcsec": "1 deg",
    "ppm": "1 %",
    "m": "1000 m",
    "mGal": "1000 mGal",
    "deg/h": "1 deg/h",
    "s": "1 s",
    "degC": "100 degC",
    "degC/h": "100 degC/h",
}
# Part of a squared limit below which a source at its largest is left out of sharing it:
# all terms together change no utilisation by 1e-6 [1].
MINUTE = 1e-9
USUAL_TIME = 1800.0  # of a temperature whose time nothing says [s]

DOES, DOES_NOT, NO_FIGURES = "does", "does not", "no figures"


@written(
    "station_figure",
    """
    owner = source.owner: 'station' or 'environment'
    source
    unit
    any = is_any: whether it reaches no limited output
    alone / unit: what it may be, the others being 0; null where any value will do
    alone_stopped_by = stopped_by: outputs that are at their limits then
    together / unit: what it may be, all sharing the limits; null where any value will
      do
    binding_outputs: at their limits then, where it takes most
    now / unit: of the procedure's own station, largest axis
    takes_now [1]: of the part of a limit that a station may take, where that is most
    within = is_within: whether it is now no more than its part
    why: any value will do, or the first order is 0
    """,
)
@dataclass(frozen=True, kw_only=True)
class StationFigure(Documented):
    """One source of station or environment: what it may be, 1 sigma, normal."""

    source: Name
    unit: str
    si_per_unit: float
    now: float | None  # of the procedure's own station, largest axis [SI]
    # k_p u alone over limit / R, of the output where that is largest [1].
    takes_now: float | None
    alone: float | None  # the others being 0 [SI]; None: any value will do
    stopped_by: tuple[Name, ...]  # outputs; (): nothing before its ceiling
    together: float | None  # all sharing the limits [SI]; None: any, or not shared
    binding_outputs: tuple[Name, ...]  # at limit / R then, where it takes most
    # Why any value will do, or what makes the first order 0; '' of others.
    why: str = ""

    @property
    def is_any(self) -> bool:
        """Whether it reaches no limited output."""
        return self.alone is None

    @property
    def is_within(self) -> bool | None:
        """Whether it is now no more than its part; None where one of both is not."""
        if self.now is None:
            return None
        if self.is_any:
            return True
        return None if self.together is None else settle(self.now) <= self.together


@written(
    "station_output",
    """
    output = output.name
    unit = output.unit
    limit / unit: on the absolute error
    expanded_uncertainty = expanded / unit: of the station alone
    utilisation [1]: of the part of the limit that a station may take
    ratio [1]: limit over the expanded uncertainty; null where that is 0
    station_acceptance_limit = station_acceptance / unit: were the station alone
      uncertain
    limiting_source = sources.0: that takes most of the station's part
    measurement_expanded_uncertainty = whole / unit: of the whole measurement
    measurement_limiting_source = whole_sources.0: that takes most of that
    test_uncertainty_ratio = test_ratio [1]: limit over that; null where it is 0
    acceptance_limit = acceptance / unit: largest measured value that is accepted; null
      where none is
    parameter_standard_uncertainty = prior / unit: by the lines of the device, before
      the measurement
    false_accept [1]: probability of accepting what is beyond the limit; null where no
      line says how far the parameter is from nominal
    """,
)
@dataclass(frozen=True, kw_only=True)
class StationOutput(LimitedOutput):
    """One limited output at one station."""

    expanded: float  # U of the station alone, at the coverage of the requirement [SI]
    utilisation: float  # U over limit / R [1]
    sources: tuple[Name, ...]  # that take most of it; () where it is 0
    whole: float  # U of the whole measurement, device and station, as tested [SI]
    whole_sources: tuple[Name, ...]  # that take most of that
    # Largest absolute measured value that is accepted [SI]; None: there is none.
    acceptance: float | None
    station_acceptance: float | None  # the same, were the station's U all [SI]
    # u_0 of the parameter by the lines of the device, before the measurement [SI].
    prior: float
    # Of all items, those that are accepted and beyond the limit [1]; None where no line
    # of the device says how far they are from nominal.
    false_accept: float | None

    @property
    def ratio(self) -> float | None:
        """Limit over U of the station alone; None where that is 0."""
        return self.limit / self.expanded if self.expanded > 0.0 else None

    @property
    def test_ratio(self) -> float | None:
        """Test uncertainty ratio, limit over U of the whole; None where that is 0."""
        return self.limit / self.whole if self.whole > 0.0 else None

    @property
    def is_accepted_too_often(self) -> bool:
        """Whether more false accepts are to be expected than Z540.3 allows."""
        return settle(self.false_accept or 0.0) > MOST_FALSE_ACCEPT


@written(
    "station_verdict",
    """
    name
    file
    own = is_own: whether it is that of the procedure
    verdict: 'does', 'does not', 'no figures'
    utilisation [1]: the largest of all outputs
    ratio = worst.ratio [1]: least limit over expanded uncertainty; null where all are 0
    worst_output (str | None): that uses most of its part
    limiting_source = worst.sources.0: that takes most of that
    test_uncertainty_ratio = test_ratio [1]: the least of all outputs
    false_accept [1]: the largest of all outputs
    outputs
    """,
    worst_output=lambda one: one.worst.output.name if one.worst.ratio else None,
)
@dataclass(frozen=True, kw_only=True)
class StationVerdict(Documented):
    """One station at this test: whether its part of every limit is small enough."""

    name: str
    file: str
    is_own: bool  # that of the procedure
    has_figures: bool
    outputs: tuple[StationOutput, ...]

    @property
    def worst(self) -> StationOutput:
        """The output that uses most of limit / R; of equal ones the first."""
        return self.outputs[first_largest([row.utilisation for row in self.outputs])]

    @property
    def all_worst(self) -> tuple[Name, ...]:
        """That output and all that are equal to it."""
        places = largest([row.utilisation for row in self.outputs])
        return tuple(self.outputs[k].output.name for k in places)

    @property
    def utilisation(self) -> float:
        """The largest of all outputs [1]."""
        return self.worst.utilisation

    @property
    def all_coarsest(self) -> tuple[StationOutput, ...]:
        """The outputs whose whole measurement has the least test uncertainty ratio."""
        used = [row.whole / row.limit for row in self.outputs]
        return tuple(self.outputs[k] for k in largest(used))

    @property
    def test_ratio(self) -> float | None:
        """The least test uncertainty ratio [1]; None: no measurement is uncertain."""
        return self.all_coarsest[0].test_ratio

    @property
    def false_accept(self) -> float | None:
        """The largest of all outputs [1]; None: nothing is known of any."""
        found = [row.false_accept for row in self.outputs]
        return max((one for one in found if one is not None), default=None)

    @property
    def verdict(self) -> str:
        """Say whether it does; one without a figure says nothing of itself."""
        if not self.has_figures:
            return NO_FIGURES
        return DOES if settle(self.utilisation) <= 1.0 else DOES_NOT


@written(
    "stations",
    """
    title: names of the devices
    inputs by role as file
    settings = self as station_settings
    does = doing (bool): whether any station will do
    standings as standing: on what is calibrated by this test, at its own station
    sources = figures: what each figure may be
    stations: the procedure's own first
    assumptions
    warnings
    """,
    commands="station",
)
@written(
    "station_settings",
    """
    method = 'gum' (str)
    strategy = settings.strategy (str): how limits are shared out
    ratio [1]: of every limit over the station's expanded uncertainty, that is asked for
    guard [1]: guard band over the expanded uncertainty of the measurement
    most_false_accept (float) [1]: ANSI/NCSL Z540.3
    coverage = settings.coverage [1]: of the requirement
    coverage_factor [1]
    reference = settings.reference: what an error is one against
    formulas = settings.formulas
    """,
    most_false_accept=lambda _: MOST_FALSE_ACCEPT,
)
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Qualification(Study):
    """Everything that `budget station` says."""

    ratio: float  # R [1]
    guard: float  # r [1]
    coverage_factor: float  # k_p [1]
    figures: tuple[StationFigure, ...]
    stations: tuple[StationVerdict, ...]  # the procedure's own first
    # Correlation and warm-up time that figures were found with, by source [s].
    times: Mapping[Name, float]
    # Verdicts on what is calibrated by this test, at its own station, by triad.
    standings: tuple[Verdict, ...] = ()

    @property
    def own(self) -> StationVerdict | None:
        """The procedure's own station, where it names one."""
        return next((one for one in self.stations if one.is_own), None)

    @property
    def doing(self) -> tuple[StationVerdict, ...]:
        """The stations that will do."""
        return tuple(one for one in self.stations if one.verdict == DOES)


@asking("station")
def qualify(
    *devices: Device | File,
    inputs: Inputs,
    asked: Asked,
    ratio: float = RATIO,
    guard: float = GUARD,
    stations: Sequence[Station | File] | None = None,
) -> Qualification:
    """Say how good each figure of a test station must be, and which station does.

    Parameters
    ----------
    *devices : Device
        What is calibrated; together at most one gyro and one accelerometer.
    ratio : float
        R, of every limit over U of the station alone, that is asked for [1].
    guard : float
        r, guard band of the acceptance limits over U of the whole measurement [1].
    stations : sequence of Station, optional
        Candidates; the shipped ones, if none are given.

    Returns
    -------
    Qualification

    Raises
    ------
    CallError
        Options that mean nothing, or no limit on what the test estimates.
    """
    how, strategy = inputs.calibrated(), asked.strategy or STRATEGIES[0]
    if how.formulas in UNCALIBRATED:
        raise CallError(
            f"{how.name}: there is no test, so that no station is needed; give the "
            "procedure of a test"
        )
    _check(ratio, guard, strategy, how)
    question = Question.load(*devices, inputs=inputs)
    wanted, how = question.wanted, question.procedure
    sensors = question.sensors
    names = known_outputs([sensor.kind for sensor in sensors], how)
    limits = tuple(one for one in wanted.limits if one.output in names)
    if not limits:
        raise CallError(
            f"{wanted.origin.file}: {wanted.name} sets no limit for what "
            f"{how.name} estimates of a sensor that is there "
            f"({', '.join(sensor.kind for sensor in sensors)}), one at least is "
            "needed; add limits for it, or give another procedure"
        )
    case = _Case(question=question, limits=limits, ratio=ratio, guard=guard)
    given = load_stations() if stations is None else map(load_station, stations)
    # One that is given again is one.
    candidates = (*{(one.name, one.origin): one for one in given}.values(),)
    verdicts = _verdicts(case, candidates)
    probe = _probe(case)
    own = envelope(
        question,
        replace(asked.settle(wanted), strategy=strategy, formulas=how.formulas),
        assumed=probe.assumed,
        warned=(*_warnings(case, names), *against_limits(how, wanted)),
        files={f"candidate {k}": one for k, one in enumerate(candidates, start=1)},
    )
    # What is there instead of an ideal station is what is asked.
    assumptions = tuple(text for text in own["assumptions"] if text != IDEAL)
    return Qualification(
        **own | {"assumptions": assumptions},
        ratio=ratio,
        guard=guard,
        coverage_factor=case.k,
        figures=_figures(case, probe, strategy),
        stations=verdicts,
        times=probe.times,
        standings=tuple(
            standing
            for sensor in sensors
            for standing in [stand(question.alone(sensor.kind), seed=0)]
            if standing is not None
        ),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Case:
    """A test at its station: its limits, the ratio."""

    question: Question
    limits: tuple[Limit, ...]
    ratio: float
    guard: float

    @property
    def k(self) -> float:
        """Coverage factor of a normal error [1]."""
        return normal_coverage_factor(self.question.coverage)

    @property
    def names(self) -> list[Name]:
        """The limited outputs."""
        return [one.output for one in self.limits]

    @property
    def allowed(self) -> Array:
        """Return limit / R, shape (n_limits,) [SI]."""
        return np.array([one.limit for one in self.limits]) / self.ratio

    def problem(self, procedure: Procedure) -> Problem:
        """Return the test with nothing but the sources of station and environment.

        What no triad feels is left out, and what varies of the device, unless an
        estimator weighs by it: every input costs second derivatives with all others.
        """
        sensors = self.question.sensors
        kinds = tuple(sensor.kind for sensor in sensors)
        if not estimator_of(procedure.formulas).weighs_noise:
            sensors = tuple(map(_coefficients_alone, sensors))
        triads = [
            Triad(
                scheme=scheme,
                given={one.name: one for one in (*procedure.environment, *lines)},
                statistics=Statistics.of(scheme, []),
            )
            for there in [with_accelerometers(sensors, procedure)]
            for scheme, lines in (
                (schemes_of(there, procedure)[one.kind], one.lines) for one in there
            )
        ]

        def felt(owner: str, lines: Sequence[ErrorLine]) -> tuple[ErrorLine, ...]:
            return tuple(one for one in lines if _is_felt(owner, one, triads))

        return calibration_problem(
            sensors,
            replace(
                procedure,
                station=felt(STATION, procedure.station),
                environment=felt(ENVIRONMENT, procedure.environment),
            ),
            reference=self.question.reference,
            only=frozenset(Name(one.name, owner=o) for o, one in station_sources()),
            outputs=outputs_for(kinds, procedure, self.names),
        )

    def measured(self, procedure: Procedure, reference: str) -> Question:
        """Return the test with all that is given, of the device too."""
        return replace(self.question, procedure=procedure, reference=reference)

    def prior(self) -> dict[Name, float]:
        """Return u_0 of each limited output, by the lines of the device [SI]."""
        alone = replace(self.question.procedure, station=(), environment=())
        by_reference = []
        for reference in ("nominal", "as_tested"):
            one = self.measured(alone, reference)
            # 0 of what is rounding.
            by_reference.append(
                {
                    output.name: u**2 if u > output.resolution else 0.0
                    for output, u in zip(
                        one.problem.outputs,
                        one.law.standard_uncertainty.tolist(),
                        strict=True,
                    )
                }
            )
        nominal, tested = by_reference
        return {
            name: sqrt(max(nominal[name] - tested[name], 0.0)) for name in self.names
        }


def _coefficients_alone(sensor: Sensor) -> Sensor:
    """Return a sensor, and those beside it, without the lines that vary."""
    return replace(
        sensor,
        lines=tuple(
            one for one in sensor.lines if not source_of(sensor.kind, one.name).varies
        ),
        beside=sensor.beside and _coefficients_alone(sensor.beside),
    )


def _is_felt(owner: str, line: ErrorLine, triads: Sequence[Triad]) -> bool:
    """Whether a line does anything to a triad of the test."""
    effect = source_of(owner, line.name).effect
    if not isinstance(effect, Disturbance):
        return True
    return any(effect.bind(line, triad) is not None for triad in triads)


def station_sources() -> tuple[tuple[str, Source], ...]:
    """Return owner and source of what a station can be better at.

    Uncertainties that last no longer than the test: what differs at a later turn-on
    is the mission's, and a known vibration is none.
    """
    return tuple(
        (owner, source)
        for owner in (STATION, ENVIRONMENT)
        for source in lines_of(owner)
        if source.varies and source.stays in {TEST, IN_RUN}
    )


def _check(ratio: float, guard: float, strategy: str, procedure: Procedure) -> None:
    """Refuse options that mean nothing, all at once."""
    faults = []
    if not (isfinite(ratio) and LEAST_RATIO <= ratio <= MOST_RATIO):
        faults.append(
            f"ratio is {ratio!r}, allowed: {LEAST_RATIO:g} to {MOST_RATIO:g}, the "
            "limit over the expanded uncertainty of the station by itself; 4 is usual"
        )
    if not (isfinite(guard) and 0.0 <= guard <= MOST_GUARD):
        faults.append(
            f"guard is {guard!r}, allowed: 0 (none) to {MOST_GUARD:g}, times the "
            "expanded uncertainty of the measurement; 1 is usual"
        )
    if strategy not in STRATEGIES:
        faults.append(f"strategy is {strategy!r}, allowed: {', '.join(STRATEGIES)}")
    elif strategy == "proportional" and not (
        procedure.station + of_the_test(procedure.environment)
    ):
        faults.append(
            f"strategy is 'proportional', and {procedure.name} has no figures of a "
            "station that it could go by; let it name one (station: FILE), or take "
            "the strategy 'equal'"
        )
    if faults:
        raise CallError("; ".join(faults))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Probe:
    """The law of every source of station and environment, each of size 1 of its unit.

    Attributes
    ----------
    law : ScaledLaw
        Of the limited outputs, the deviations alone; rounding is 0 in it.
    lines : mapping of Name to ErrorLine
    first, any : ndarray of bool, shape (n_src,)
        Whether it moves a limited output to first order, and whether at all.
    elsewhere : ndarray of bool, shape (n_src,)
        Whether it moves any output of the test, limited or not.
    times : mapping of Name to float
    assumed : tuple of str
    """

    law: ScaledLaw
    lines: Mapping[Name, ErrorLine]
    first: NDArray[np.bool_]
    any: NDArray[np.bool_]
    elsewhere: NDArray[np.bool_]
    times: Mapping[Name, float]
    assumed: tuple[str, ...]


def _probe(case: _Case) -> _Probe:
    """Expand the test once, with every source that a station can have."""
    given = given_lines((), case.question.procedure)
    lines: dict[Name, ErrorLine] = {}
    times: dict[Name, float] = {}
    assumed: dict[Name, str] = {}
    for owner, source in station_sources():
        name = Name(source.name, owner=owner)
        has = given.get(name)
        if source.points and has is None:
            continue  # nobody knows when
        if source.time:
            own = None if has is None else has.correlation_time
            times[name] = USUAL_TIME if own is None else float(own[0])
            if own is None:
                assumed[name] = sentence(
                    "stations.usual_time", name=name, key=source.time, time=USUAL_TIME
                )
        lines[name] = _unit_line(source, owner, has, times.get(name))
    kept = tuple(
        line
        for line in case.question.procedure.environment
        if Name(line.name, owner=ENVIRONMENT) not in lines
    )
    procedure = replace(
        case.question.procedure,
        station=tuple(line for name, line in lines.items() if name.owner == STATION),
        environment=kept
        + tuple(line for name, line in lines.items() if name.owner == ENVIRONMENT),
    )
    problem = case.problem(procedure)
    whole = scaled_law(problem)
    there = [name for name in lines if name in whole.sources]
    law = whole.select_sources(there).over([*lines]).centred()
    zero = np.array([output.resolution**2 for output in problem.outputs])
    law = replace(
        law,
        first=np.where(law.first > zero[:, None], law.first, 0.0),
        second=np.where(law.second > zero[:, None, None], law.second, 0.0),
    )
    limited = law.select(case.names)
    first, anyhow = _moved(limited)
    return _Probe(
        law=limited,
        lines=lines,
        first=first,
        any=anyhow,
        elsewhere=_moved(law)[1],
        times=times,
        assumed=tuple(
            assumed[name]
            for name, counts in zip(law.sources, anyhow, strict=True)
            if counts and name in assumed
        ),
    )


def _moved(law: ScaledLaw) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which sources move an output to first order, and which at all."""
    first = np.asarray((law.first > 0.0).any(axis=0))
    return first, np.asarray(first | (law.second > 0.0).any(axis=(0, 2)))


def _unit_line(
    source: Source, owner: str, has: ErrorLine | None, time: float | None
) -> ErrorLine:
    """Return a line of 1 of the unit that the station's own has, or the usual one."""
    unit = source.like(owner)
    size = parse_quantity(f"1 {unit}", unit).si_per_unit
    if has is not None:
        unit, size = has.unit, has.si_per_unit
    n = len(source.axes)
    return ErrorLine(
        name=source.name,
        u=np.full(n, size),
        distributions=(NORMAL,) * n,
        correlation_time=None if time is None else np.full(n, time),
        points=None if has is None else has.points,
        printed=f"1 {unit}",
        unit=unit,
        si_per_unit=size,
    )


def _figures(case: _Case, probe: _Probe, strategy: str) -> tuple[StationFigure, ...]:
    """Return what each source may be, alone and together."""
    law = probe.law
    n = len(law.sources)
    unit = np.array([probe.lines[name].si_per_unit for name in law.sources])
    given = given_lines((), case.question.procedure)
    now = np.array([given[g].largest if g in given else 0.0 for g in law.sources])
    most = np.maximum(
        [
            parse_quantity(CEILINGS[unit], unit).value
            for g in law.sources
            for unit in [source_of(g.owner, g.quantity).like(g.owner)]
        ],
        now,
    )
    task = _task(case, law, most / unit)
    rooms = headroom(task, np.zeros(n))
    alone = np.minimum(unit * [room.factor for room in rooms], most)
    felt = probe.any
    is_equal = strategy == "equal"
    free = felt if is_equal else felt & (now > 0.0)
    sizes = (alone if is_equal else now)[free]
    together = np.zeros(n)
    binding: dict[int, tuple[Name, ...]] = {}
    if free.any():
        places = np.flatnonzero(free)
        part_law = law.select_sources([law.sources[g] for g in places])
        part_law = part_law.resized(sizes / unit[free])
        shared = _task(case, _without_minute(case, part_law), most[free] / sizes)
        s = equal(shared) if is_equal else proportional(shared)
        together[free] = sizes * s
        part = np.where(shared.binding(s)[:, None], shared.part(s), 0.0)
        for column, g in enumerate(places):
            at = largest(part[:, column].tolist())
            binding[int(g)] = tuple(
                law.outputs[k] for k in at if part[k, column] >= NEGLIGIBLE
            )
    takes = np.sqrt(task.part(now / unit)).max(axis=0)
    return tuple(
        StationFigure(
            source=name,
            unit=probe.lines[name].unit,
            si_per_unit=float(unit[g]),
            now=float(now[g]) if name in given else None,
            takes_now=float(takes[g]) if name in given else None,
            alone=float(alone[g]) if felt[g] else None,
            stopped_by=tuple(law.outputs[k] for k in rooms[g].stopped_by)
            if alone[g] < most[g]
            else (),
            together=float(together[g]) if free[g] else None,
            binding_outputs=binding.get(g, ()),
            why=_why(name, g, probe, case.question.procedure),
        )
        for g, name in enumerate(law.sources)
    )


def _without_minute(case: _Case, law: ScaledLaw) -> ScaledLaw:
    """Return a law without the terms that no utilisation shows.

    A source is not stopped by a limit of which it takes nothing that counts.
    """
    scale = (case.k / case.allowed) ** 2
    return replace(
        law,
        first=np.where(scale[:, None] * law.first > MINUTE, law.first, 0.0),
        second=np.where(scale[:, None, None] * law.second > MINUTE, law.second, 0.0),
    )


def _task(case: _Case, law: ScaledLaw, high: Array) -> Task:
    """Return the allocation of limit / R over the sources of a law."""
    n = len(law.sources)
    return Task(
        law=law,
        limit=case.allowed,
        coverage_factor=np.full(len(case.limits), case.k),
        free=np.ones(n, dtype=bool),
        low=np.zeros(n),
        high=np.asarray(high),
    )


def _why(name: Name, g: int, probe: _Probe, procedure: Procedure) -> str:
    """Say why any value will do, or what removes a source to first order."""
    what = removal(name, procedure)
    if probe.first[g]:
        return ""
    if not probe.elsewhere[g] and not what:
        needs = source_of(name.owner, name.quantity).effect.needs
        return sentence("stations.reaches_nothing", needs=described(needs))
    return sentence("stations.counts_nothing", what=what, is_felt=bool(probe.any[g]))


def _verdicts(case: _Case, candidates: Sequence[Station]) -> tuple[StationVerdict, ...]:
    """Judge the procedure's own station, then every other candidate."""
    procedure, prior = case.question.procedure, case.prior()
    found = []
    own = procedure.station_origin
    is_there = IDEAL not in procedure.assumptions
    if is_there:
        file = (own or procedure.origin).file
        name = next(
            (one.name for one in candidates if own and one.origin == own),
            f"station of {procedure.name}" if own is None else own.file,
        )
        lines = (*procedure.station, *of_the_test(procedure.environment))
        found.append(_verdict(case, procedure, lines, prior, name=name, file=file))
    for one in candidates:
        if is_there and own == one.origin:
            continue
        there = at_station(procedure, one)
        lines = (*one.station, *of_the_test(one.environment))
        file = one.origin.file
        found.append(_verdict(case, there, lines, prior, name=one.name, file=file))
    return tuple(
        replace(one, is_own=is_there and place == 0) for place, one in enumerate(found)
    )


def _verdict(
    case: _Case,
    procedure: Procedure,
    lines: Sequence[ErrorLine],
    prior: Mapping[Name, float],
    *,
    name: str,
    file: str,
) -> StationVerdict:
    """Propagate the figures of one station alone, and the whole measurement there.

    `lines` are those that the station gives, `prior` u_0 of each output [SI].
    """
    problem, measured = case.problem(procedure), case.measured(procedure, "as_tested")
    station = _uncertain(case, problem, propagate(problem))
    whole = _uncertain(case, measured.problem, measured.law)
    outputs = {output.name: output for output in problem.outputs}
    rows = []
    for one, allowed in zip(case.limits, case.allowed, strict=True):
        expanded, sources = station[one.output]
        all_of_it, whole_sources = whole[one.output]
        acceptance = _acceptance(one.limit, case.guard * all_of_it)
        u_0, u_m = prior[one.output], all_of_it / case.k
        rows.append(
            StationOutput(
                output=outputs[one.output],
                limit=one.limit,
                printed_limit=one.printed,
                expanded=expanded,
                utilisation=expanded / float(allowed),
                sources=sources,
                whole=all_of_it,
                whole_sources=whole_sources,
                acceptance=acceptance,
                station_acceptance=_acceptance(one.limit, case.guard * expanded),
                prior=u_0,
                false_accept=false_accept(one.limit, acceptance, u_0, u_m)
                if u_0 > 0.0
                else None,
            )
        )
    return StationVerdict(
        name=name,
        file=file,
        is_own=False,
        has_figures=any(line.u.any() for line in lines),
        outputs=tuple(rows),
    )


def _uncertain(
    case: _Case, problem: Problem, law: Propagation
) -> dict[Name, tuple[float, tuple[Name, ...]]]:
    """Return by output U [SI], 0 of what is rounding, and what takes most of it."""
    found = {}
    for row, output in enumerate(problem.outputs):
        u = float(law.standard_uncertainty[row])
        is_felt = u > output.resolution
        takes = law.source_variance[:, row].tolist() if is_felt else []
        most = tuple(problem.groups[g].name for g in largest(takes))
        found[output.name] = (case.k * u if is_felt else 0.0, most)
    return found


def _acceptance(limit: float, band: float) -> float | None:
    """Return the acceptance limit with a guard band; None where there is none [SI]."""
    if band >= limit:
        return None
    return acceptance_interval((-limit, limit), band)[1]


def false_accept(
    limit: float, acceptance: float | None, u_prior: float, u_measurement: float
) -> float:
    """Return the probability that an item is accepted and beyond its limit.

    P(|eta| > limit and |eta + e| <= A), eta and e normal: JCGM 106:2012, 9.5.2.

    Parameters
    ----------
    limit, acceptance : float
        The limit and A; None where nothing is accepted [SI].
    u_prior, u_measurement : float
        Of the parameter before the measurement, and of the measurement [SI].
    """
    if acceptance is None or u_measurement == 0.0:  # which sees the parameter itself
        return 0.0
    return global_risks(
        (-limit, limit),
        (-acceptance, acceptance),
        mean=0.0,
        u=u_prior,
        u_measurement=u_measurement,
    ).consumer


def _warnings(case: _Case, names: Sequence[Name]) -> tuple[str, ...]:
    """Say what a reader should know before believing the tables."""
    absent = [
        one.output for one in case.question.wanted.limits if one.output not in names
    ]
    found = [
        sentence("stations.not_estimated", parameters=parameters)
        for parameters in by_group(absent)
    ]
    if IDEAL in case.question.procedure.assumptions:
        found.append(
            sentence("stations.no_station", procedure=case.question.procedure.name)
        )
    return tuple(found)
