"""What is asked: devices, procedure, limits, mission; its Problem and law.

The way from a data sheet to a page:

- `inputs` read files to records: a Device has Sensors, triads, a Sensor has ErrorLines;
  a Procedure has windows, lines of station and environment; a Requirement has Limits.
- `Question.load` puts records together: the procedure in its use, what a sheet does not
  give expected and filled (`missing`), names resolved, what does not fit refused.
- `Question.problem` is the measurement function with its inputs (`calibration`, of
  `model`'s sources), `law` its propagation (`methods.gum`), `held` its limits. `alone`,
  `under`, `in_use`, `with_lines` are the same Question otherwise, each made once.
- `studies` are functions of a Question: `analyze_as` to a Budget, of which
  `conformity.assess` judges each owner of limits (`judgement.judge` by trials,
  `verdicts.verdict_on` by what is not given); `allocate_as`, `compare`, `qualify`.
- What they return writes its own documents (`documents`), and `report` its pages, by
  templates.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Self

import numpy as np

from budget.aiding import problem_of_mission
from budget.calibration.aiding import lines_of_mission
from budget.calibration.derived import (
    known_outputs,
    outputs_for,
    parts_of,
)
from budget.calibration.mission import (
    DOWN,
    Places,
    mission_outputs,
)
from budget.calibration.mission import REFERENCE as ON_MISSION
from budget.calibration.problem import MEASURED, calibration_problem
from budget.calibration.schemes import (
    calibrates,
    initial_lines,
    is_beside,
    with_accelerometers,
)
from budget.errors import CallError, UnitError
from budget.inputs import (
    load_devices,
    load_procedure,
)
from budget.inputs.mission import MOST_TIMES
from budget.inputs.records import JOINT, UNCALIBRATED, Device
from budget.inputs.station import of_run
from budget.inputs.use import in_use
from budget.methods.gum import propagate, propagate_together
from budget.missing import REFUSE, Filling, fill_all
from budget.missing.expected import (
    expecting,
    expecting_device,
    lacking,
    lacking_of_mission,
)
from budget.model.estimators import estimator_of
from budget.model.sources import (
    ACCELEROMETER,
    GYRO,
    SENSORS,
    SHARED,
    lines_of,
    source_of,
)
from budget.names import (
    IMU,
    MISSION,
    Name,
    by_group,
    every_output,
    meant,
    time_text,
)
from budget.recordings.measured_unit import measured_units
from budget.settings import Asked, Inputs, check
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import (
        Callable,
        Container,
        Hashable,
        Iterator,
        Mapping,
        Sequence,
    )

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import (
        ErrorLine,
        Mission,
        Procedure,
        Requirement,
        Sensor,
    )
    from budget.methods.gum import Propagation
    from budget.problem import Output, Problem
    from budget.results import Budget

DEFAULT_COVERAGE = 0.95  # [1]
DEFAULT_REFERENCE = "nominal"
SAME_TIME = 1e-9  # relative; of two times that are one [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Limited:
    """A Problem, and limits on some of its outputs."""

    problem: Problem
    # Required outputs among those of the Problem, shape (n_required,).
    rows: NDArray[np.intp]
    limits: Array  # on their absolute errors, shape (n_required,) [SI]
    coverage: Array  # probabilities of the intervals, shape (n_required,) [1]
    printed: tuple[str, ...]  # the limits as the requirement file gives them
    usual: float  # the requirement's coverage, of limits without their own [1]
    # Parameters with a limit that the calibration does not estimate.
    absent: tuple[Name, ...] = ()
    is_joint: bool = False  # whether all limits are to be kept together

    @classmethod
    def of(cls, problem: Problem, requirement: Requirement) -> Self | None:
        """Put the limits of a requirement on a Problem; None where it has none."""
        places = {output.name: row for row, output in enumerate(problem.outputs)}
        required = [one for one in requirement.limits if one.output in places]
        if not required:
            return None
        owners = {name.owner for name in places}
        return cls(
            problem=problem,
            rows=np.array([places[limit.output] for limit in required]),
            limits=np.array([limit.limit for limit in required]),
            coverage=np.array([requirement.coverage_of(limit) for limit in required]),
            printed=tuple(limit.printed for limit in required),
            usual=requirement.coverage,
            is_joint=requirement.decision == JOINT,
            absent=tuple(
                name
                for name in requirement.outputs
                if name not in places and name.owner in owners
            ),
        )

    @property
    def outputs(self) -> tuple[Output, ...]:
        """The required outputs."""
        return tuple(self.problem.outputs[row] for row in self.rows)

    @cached_property
    def law(self) -> Propagation:
        """The law of propagation for the Problem."""
        return propagate(self.problem)

    @property
    def mean(self) -> Array:
        """Expected errors by the law, shape (n_required,) [SI]."""
        return self.law.mean[self.rows]

    @property
    def u(self) -> Array:
        """Standard uncertainties by the law, shape (n_required,) [SI]."""
        return self.law.standard_uncertainty[self.rows]

    @cached_property
    def by_law(self) -> Array:
        """Coverage intervals by the law, shape (n_required, 2) [SI]."""
        return np.asarray(self.law.interval(self.every_coverage)[self.rows])

    @property
    def lengths(self) -> NDArray[np.intp]:
        """Places among the lengths of the Problem; below 0 of what is none."""
        first = self.law.value.size - self.law.legs.shape[1]
        return np.asarray(self.rows - first)

    @property
    def every_coverage(self) -> Array:
        """Coverages of all outputs of the Problem, shape (n_out,) [1].

        What is not required has that of the first that is.
        """
        found = np.full(len(self.problem.outputs), self.coverage[0])
        found[self.rows] = self.coverage
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Question:
    """Devices under a procedure, maybe on a mission, and what their errors are held to.

    Its Problem, law and limits are made when they are first asked for, once: whatever
    looks at the same calibration is given this, or what `alone` and `under` return.
    """

    devices: tuple[Device, ...]  # together at most one gyro and one accelerometer
    procedure: Procedure
    coverage: float = DEFAULT_COVERAGE  # probability of the intervals [1]
    reference: str = DEFAULT_REFERENCE  # error reference
    only: frozenset[Name] | None = None  # sources that count, all others 0; None: all
    requirement: Requirement | None = None  # limits on the errors
    # Outputs, and what has a limit; None: the parameters that are estimated.
    asked: tuple[Name, ...] | None = None
    # What stands in the devices for expected lines that are not given.
    filling: Filling = field(default_factory=Filling)
    # Triads that are looked at, of those that are there.
    kinds: tuple[str, ...] = SENSORS
    # The devices as they are printed, where others are asked about; (): these are.
    sheets: tuple[Device, ...] = ()
    mission: Mission | None = None  # that limits may be on
    # Of what follows on it, and at which times besides those of limits [s]; None: the
    # calibration is looked at.
    carried_to: tuple[float, ...] | None = None
    # What calibrated the unit for limits on the mission; None: the procedure.
    on_mission: Procedure | None = None
    # Devices that are comparable; None: those that ship.
    catalogue: tuple[Device, ...] | None = None
    # The devices as their data sheets leave them; None: as they are.
    given: tuple[Device, ...] | None = None
    # Whose unit the filter of the mission is made for; None: this one.
    designed: Question | None = None

    @classmethod
    def of(
        cls,
        *devices: Device,
        procedure: Procedure | None = None,
        requirement: Requirement | None = None,
        mission: Mission | None = None,
        carried_to: tuple[float, ...] | None = None,
        on_mission: Procedure | None = None,
        coverage: float | None = None,
        reference: str | None = None,
        only: Sequence[str] = (),
        outputs: Sequence[str] = (),
        missing: str = REFUSE,
        catalogue: Sequence[Device] | None = None,
    ) -> Self:
        """Put together what a caller asks for; without an option its usual value.

        The procedure is put in its use, what its data sheets do not give is expected
        and filled, names are resolved.

        Raises
        ------
        CallError
            Options or devices that do not fit together.
        """
        is_carried = carried_to is not None
        if is_carried:
            reference = _after_a_turn_on(reference, requirement)
        basis = Asked(coverage=coverage, reference=reference).settle(requirement)
        check("analyze", basis)
        how = load_procedure(None) if procedure is None else procedure
        if on_mission is not None:
            is_same = on_mission is how
            on_mission = None if is_same else in_use(on_mission, requirement, mission)
        how = in_use(how, requirement, mission)
        if any(one.measured and one.measured.has_station for one in devices):
            how = of_run(how)
        for one in devices:
            _refuse_bound(one, how)
        if is_carried and outputs:
            raise CallError(
                "outputs and matrices are of a calibration, and this is of a mission, "
                "which has neither; leave --outputs and --matrices out"
            )
        if not is_carried and how.formulas in UNCALIBRATED:
            raise CallError(
                f"{how.name}: there is no test whose budget this could be; give a "
                "procedure, or a mission, on which such a unit has errors"
            )
        navigating(devices) if is_carried else sensors_of(devices, how)
        found, filling, given = devices, Filling(), None
        if missing != REFUSE:
            given = devices
            expected = [
                expecting_device(one, how, basis.reference, every=is_carried)
                for one in devices
            ]
            found, filling = fill_all(expected, missing, catalogue)
        asked = cls(
            devices=found,
            procedure=how,
            coverage=basis.coverage,
            reference=basis.reference,
            requirement=requirement,
            filling=filling,
            mission=mission,
            carried_to=carried_to,
            on_mission=on_mission,
            catalogue=None if catalogue is None else tuple(catalogue),
            given=given,
        )
        return replace(
            asked,
            only=choose_sources(asked, only),
            asked=None if is_carried else choose_outputs(asked, outputs),
        )

    @classmethod
    def load(
        cls,
        *devices: Device | File,
        inputs: Inputs,
        asked: Asked | None = None,
    ) -> Self:
        """Read what a caller names, and put it together: the way to every study.

        With a mission it is of that; `at` are times [s], those of its file without.

        Raises
        ------
        CallError
            Options or devices that do not fit together.
        SpecError
            A file is not sound.
        """
        wanted, route = inputs.required, inputs.journey
        if route is None and inputs.at:
            raise CallError(
                f"at is {inputs.at!r}, the times of a mission; give mission=, too"
            )
        asked = Asked() if asked is None else asked
        named = asked.settle()
        how = inputs.calibrated(mission=route, requirement=wanted)
        return cls.of(
            *with_results(load_devices(devices), inputs.measured, how),
            procedure=how,
            requirement=wanted,
            mission=route,
            carried_to=None
            if route is None
            else choose_times(route, inputs.at, wanted),
            coverage=asked.coverage,
            reference=asked.reference,
            only=named.only,
            outputs=named.outputs,
            missing=asked.missing,
            catalogue=inputs.catalogue,
        )

    @classmethod
    def each(
        cls,
        devices: Sequence[Device],
        procedures: Sequence[Procedure],
        *,
        requirement: Requirement,
        mission: Mission | None = None,
        missing: str = REFUSE,
        catalogue: Sequence[Device] | None = None,
    ) -> Iterator[tuple[int, Question]]:
        """Put together each device after each procedure, one at a time.

        Of each owner of limits alone: a triad, what belongs to both, the mission; with
        the place of the device among those given.

        Raises
        ------
        CallError
            With limits that nothing can be said of, before the first.
        """
        for how in procedures:
            refuse_unjudged(requirement, mission, how)
        for how in (in_use(one, requirement, mission) for one in procedures):
            for place, device in enumerate(devices):
                if device.measured and device.measured.procedure != how.name:
                    continue  # it says nothing of what another one leaves
                kinds = [sensor.kind for sensor in device.sensors]
                on = [None] * any(calibrates(kind, how) for kind in kinds)
                is_whole = len(kinds) == len(SENSORS)
                for journey in (*on, mission) if mission and is_whole else on:
                    one = cls.of(
                        device,
                        procedure=how,
                        requirement=requirement,
                        mission=journey,
                        carried_to=None if journey is None else (),
                        missing=missing,
                        catalogue=catalogue,
                    )
                    yield from ((place, one.alone(owner)) for owner in one.limited)

    def whole(self) -> Self:
        """Return it, where every limit can be judged.

        Raises
        ------
        CallError
            With the limits that nothing can be said of.
        """
        how = self.on_mission or self.procedure
        refuse_unjudged(self.wanted, self.mission, how)
        return self

    def alone(self, owner: str) -> Question:
        """Return the same of one triad, as if the other were not there.

        Of what belongs to both, IMU: the two, with nothing of either alone.
        """
        return self.kept(owner, lambda: self._alone(owner))

    def _alone(self, owner: str) -> Question:
        """Return it of one owner of outputs."""
        if owner == MISSION:
            how = self.on_mission or self.procedure
            return replace(self, procedure=how, asked=None, carried_to=())
        if owner != IMU:
            return replace(self, kinds=(owner,), asked=None)
        known = known_outputs([one.kind for one in self.sensors], self.procedure)
        wanted = self.requirement
        if wanted is not None:
            limits = tuple(one for one in wanted.limits if one.output.owner == IMU)
            wanted = replace(wanted, limits=limits)
        of_both = tuple(name for name in known if name.owner == IMU)
        return replace(self, requirement=wanted, asked=of_both)

    def carry(self, times: tuple[float, ...], only: Sequence[str] = ()) -> Question:
        """Return what follows on its mission, at times besides those of its limits."""
        wanted = self.requirement
        wanted = None if wanted is None or MISSION not in wanted.kinds else wanted
        found = Question.of(
            *(self.given or self.devices),
            procedure=self.on_mission or self.procedure,
            requirement=wanted,
            mission=self.mission,
            carried_to=times,
            coverage=self.coverage,
            only=only,
            missing=self.filling.mode,
            catalogue=self.catalogue,
        )
        if wanted is not None and self.given is None and not only:
            found.kept(MISSION, lambda: self.alone(MISSION))
        return found

    @cached_property
    def _kept(self) -> dict[Hashable, Question]:
        """What was made of it."""
        return {}

    def kept(self, key: Hashable, make: Callable[[], Question]) -> Question:
        """Return what was made of it under a key, once."""
        if key not in self._kept:
            self._kept[key] = make()
        return self._kept[key]

    def let_go(self) -> None:
        """Forget what was made of it, that knows it in turn: of thousands all stood."""
        self._kept.clear()

    def under(self, procedure: Procedure) -> Question:
        """Return the same after another calibration."""
        if procedure is self.procedure:
            return self
        return self.kept(procedure, lambda: replace(self, procedure=procedure))

    def in_use(self, lines: Sequence[ErrorLine]) -> Question:
        """Return the same in an environment of more lines."""
        if not lines:
            return self
        used = _used(self.procedure, tuple(lines))
        return self.kept(tuple(map(id, lines)), lambda: replace(self, procedure=used))

    def with_sensors(self, sensors: Iterable[Sensor]) -> Question:
        """Return the same of other triads, in the place of those of their kinds."""
        found = {one.kind: one for one in sensors}
        devices = tuple(
            replace(
                device,
                gyro=device.gyro and found.get(GYRO, device.gyro),
                accelerometer=device.accelerometer
                and found.get(ACCELEROMETER, device.accelerometer),
            )
            for device in self.devices
        )
        return replace(self, devices=devices, sheets=self.sheets or self.devices)

    def with_lines(
        self, lines: Mapping[Name, ErrorLine], *, less: Sequence[str] = ()
    ) -> Question:
        """Return the same with more lines in its triads, and `less` some.

        A filter keeps the gains that it has by what is given: nobody told it more.
        """
        found = (
            one.with_lines(
                (
                    *(x for x in (*one.lines, *one.initial) if x.name not in less),
                    *(line for name, line in lines.items() if name.owner == one.kind),
                )
            )
            for device in self.devices
            for one in device.sensors
        )
        designed = self.designed or self
        return self.kept(
            (*less, *((name, *_told(one)) for name, one in lines.items())),
            lambda: replace(self.with_sensors(found), designed=designed),
        )

    @property
    def wanted(self) -> Requirement:
        """The limits.

        Raises
        ------
        CallError
            There are none.
        """
        if self.requirement is None:
            raise CallError(
                "requirement is None, and there is nothing to judge without limits; "
                "give a requirement"
            )
        return self.requirement

    @property
    def journey(self) -> Mission | None:
        """The mission that it is of; None of a calibration."""
        return None if self.carried_to is None else self.mission

    @property
    def owner(self) -> str:
        """Owner of the outputs: a triad, what belongs to both, or the mission."""
        if self.journey is not None:
            return MISSION
        return IMU if len(self.sensors) > 1 else self.sensors[0].kind

    @property
    def is_later(self) -> bool:
        """Whether it is of a use, so that its environment and its age count."""
        return self.journey is not None or self.reference == ON_MISSION

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """The triads, gyro first."""
        if self.journey is not None:
            found = navigating(self.devices)
        else:
            found = sensors_of(self.devices, self.procedure)
        return tuple(
            expecting(
                sensor,
                self.procedure,
                self.reference,
                every=self.journey is not None,
            )
            for sensor in found
            if sensor.kind in self.kinds
        )

    @cached_property
    def there(self) -> tuple[Sensor, ...]:
        """The triads, and those that a calibration of them rests on."""
        if self.journey is not None:
            return self.sensors
        return with_accelerometers(self.sensors, self.procedure)

    @property
    def title(self) -> str:
        """Names of the devices."""
        return " + ".join(device.name for device in self.devices)

    @property
    def not_given(self) -> tuple[Name, ...]:
        """Lines of the model that the data sheets of its triads do not give."""
        return tuple(name for sensor in self.sensors for name in sensor.not_given)

    @property
    def has_lines(self) -> bool:
        """Whether any error line is given."""
        return any(sensor.lines for sensor in self.sensors)

    @property
    def missing(self) -> tuple[Name, ...]:
        """Expected lines that are not given and nothing stands for, of all `there`."""
        return tuple(name for sensor in self.there for name in sensor.expected_missing)

    @cached_property
    def lines(self) -> dict[Name, ErrorLine]:
        """Every line that counts: of all `there`, of station and environment, of aids.

        On a mission those of what is held from its making, too.
        """
        return given_lines(
            self.there,
            self.procedure,
            every=self.journey is not None,
            mission=self.journey,
        )

    @cached_property
    def filled(self) -> Filling:
        """What stands for lines of the triads, and of those that they rest on."""
        there = {one.kind for one in with_accelerometers(self.sensors, self.procedure)}
        filling = self.filling
        names = (*(line.expected for line in filling.lines), *filling.left)
        return filling.of([name for name in names if name.owner in there])

    @property
    def bare(self) -> Question:
        """The same with the devices as their data sheets leave them."""
        if self.given is None:
            return self
        return replace(self, devices=self.given, given=None, filling=Filling())

    @cached_property
    def limited(self) -> tuple[str, ...]:
        """Owners of what has limits and can be judged: triads, both, the mission."""
        wanted = () if self.requirement is None else self.requirement.outputs
        found: dict[str, None] = {}
        if self.journey is None:
            kinds = [sensor.kind for sensor in self.sensors]
            known = known_outputs(kinds, self.procedure)
            first = self.sensors[0]
            if is_beside(self.procedure) and first.kind == GYRO and not first.beside:
                known = ()  # a gyro is found beside accelerometers
            found = dict.fromkeys(name.owner for name in known if name in wanted)
        if self.mission is not None and any(x.owner == MISSION for x in wanted):
            found[MISSION] = None
        return tuple(found)

    @cached_property
    def problem(self) -> Problem:
        """Inputs, measurement function and outputs of calibration or mission."""
        if self.journey is not None:
            known = self.designed or self
            return problem_of_mission(
                self.sensors,
                self.procedure,
                self.journey,
                self.outputs or (),
                only=self.only,
                designed=(known.sensors, known.procedure),
            )
        return calibration_problem(
            self.sensors,
            self.procedure,
            reference=self.reference,
            only=self.only,
            outputs=self.outputs,
        )

    @cached_property
    def held(self) -> Limited | None:
        """Its Problem with the limits on it; None where it has none."""
        if self.requirement is None:
            return None
        return Limited.of(self.problem, self.requirement)

    @property
    def limits(self) -> Limited:
        """Its Problem with the limits on it.

        Raises
        ------
        CallError
            Nothing is required of it.
        """
        if self.held is None:
            raise CallError(
                f"{self.wanted.name} limits nothing of the {self.owner}; "
                "add limits for it, or leave it out"
            )
        return self.held

    @cached_property
    def outputs(self) -> tuple[Name, ...] | None:
        """What is asked for and what is limited; None: all parameters, no others."""
        limited = () if self.requirement is None else self.requirement.outputs
        if self.journey is not None:
            every = mission_outputs(self.journey, self.carried_to or ())
            asked = every if self.asked is None else self.asked
            return tuple(dict.fromkeys((*asked, *on_mission(limited, self.journey))))
        return outputs_for(
            [sensor.kind for sensor in self.sensors],
            self.procedure,
            limited,
            self.asked,
        )

    @cached_property
    def law(self) -> Propagation:
        """The law of propagation for it."""
        return propagate(self.problem) if self.held is None else self.held.law

    @property
    def carried(self) -> tuple[Mission, tuple[Name, ...]] | None:
        """The mission and its outputs, where it is asked for."""
        if self.journey is None:
            return None
        return self.journey, Places.of(self.outputs or ()).every

    @cached_property
    def lacks(self) -> Mapping[Name, tuple[Name, ...]]:
        """Expected lines that are not given and would widen an output, by its name."""
        if self.carried is not None:
            return lacking_of_mission(
                self.sensors, self.procedure, *self.carried, only=self.only
            )
        return lacking(
            self.sensors, self.procedure, reference=self.reference, only=self.only
        )


@lru_cache(maxsize=16)
def _used(own: Procedure, lines: tuple[ErrorLine, ...]) -> Procedure:
    """Return a procedure in an environment of more lines: one for all devices."""
    return replace(own, environment=(*own.environment, *lines))


def _told(line: ErrorLine) -> tuple[Hashable, ...]:
    """Return what tells a line from others of its name."""
    times = line.correlation_time
    return (
        line.name,
        line.form,
        line.distributions,
        line.u.tobytes(),
        line.degrees_of_freedom,
        None if times is None else times.tobytes(),
    )


def laws_together(questions: Sequence[Question]) -> None:
    """Make the laws of several questions, those of one structure at once."""
    # Where there are limits it is their law that is judged.
    owners = [one.held or one for one in questions]
    open_ones = [one for one in owners if "law" not in vars(one)]
    laws = propagate_together([one.problem for one in open_ones])
    for one, law in zip(open_ones, laws, strict=True):
        vars(one)["law"] = law  # as if each had been asked for it


def question_of(budget: Budget) -> Question:
    """Return what a budget is of.

    Raises
    ------
    CallError
        It was put together by hand.
    """
    if isinstance(found := getattr(budget, "question", None), Question):
        return found
    raise CallError(
        f"{type(budget).__name__} does not say what it is a budget of; give what "
        "budget.analyze returns"
    )


def with_results(
    devices: Sequence[Device], results: Sequence[File], procedure: Procedure
) -> tuple[Device, ...]:
    """Return devices, those that results are of as the units that were measured.

    Raises as measured_units.
    """
    if results and len(devices) > 1:
        raise CallError(
            f"a result is of one device, found {len(devices)}; put both triads in one "
            "device file, and calibrate with it"
        )
    if len(results) > 1:
        raise CallError(
            "several results are of one device; give one, or `budget compare` them"
        )
    units = measured_units(devices, results, (procedure,))
    known = {id(sheet): unit for sheet, unit in units}
    return tuple(known.get(id(one), one) for one in devices)


def _refuse_bound(device: Device, procedure: Procedure) -> None:
    """Refuse lower bounds of a result where nothing would say that they are."""
    measured = device.measured
    if measured is None or not measured.is_bound:
        return
    expected = expecting_device(device, procedure, DEFAULT_REFERENCE).sensors
    if not any(one.expected_missing for one in expected):
        raise CallError(
            f"{measured.file} has lower bounds of its uncertainties (lower_bound: "
            f"true), and {device.name} lacks nothing that would add to them; calibrate "
            "again"
        )


def sensors_of(
    devices: Sequence[Device], procedure: Procedure | None = None
) -> tuple[Sensor, ...]:
    """Return the triads of all devices, gyro first; those that a procedure calibrates.

    Raises
    ------
    CallError
        There is no such sensor, or two of one kind.
    """
    strangers = [device for device in devices if not isinstance(device, Device)]
    if strangers:
        raise CallError(
            f"{strangers[0]!r} is no Device; load one with budget.load_device(FILE), "
            "and give a procedure as procedure=budget.load_procedure(FILE)"
        )
    found: list[Sensor] = []
    for kind in SENSORS:
        of_kind = [s for d in devices for s in d.sensors if s.kind == kind]
        if len(of_kind) > 1:
            names = " and ".join(f"{sensor.device!r}" for sensor in of_kind)
            raise CallError(
                f"{names} both have a {kind}, one budget takes at most one; "
                "give devices that complete each other, or `budget compare` them"
            )
        found.extend(of_kind)
    if not found:
        raise CallError("no device with a gyro or an accelerometer was given")
    if len(found) == len(SENSORS) and found[0].beside is not found[1]:
        found[0] = replace(found[0], beside=found[1])
    if procedure is None:
        return tuple(found)
    kept = tuple(one for one in found if calibrates(one.kind, procedure))
    if not kept:
        kinds = " and ".join(one.kind for one in found)
        if (
            not estimator_of(procedure.formulas).knows_attitudes
            and ACCELEROMETER not in kinds
        ):
            raise CallError(
                f"{procedure.name} calibrates accelerometers alone, by the norm of "
                f"gravity, and what is given is a {kinds}; give a device with "
                "accelerometers, or a procedure with another estimator"
            )
        raise CallError(
            f"{procedure.name} has no window of the {kinds}; let one be used by it "
            "(use: both), or give another device"
        )
    return kept


def navigating(devices: Sequence[Device]) -> tuple[Sensor, ...]:
    """Return the gyro and the accelerometer that a mission takes.

    Raises
    ------
    CallError
        One of them is not there, or two of a kind are.
    """
    found = sensors_of(devices)
    if len(found) == len(SENSORS):
        return found
    (there,) = found
    absent = next(kind for kind in SENSORS if kind != there.kind)
    raise CallError(
        f"{there.device} has no {absent}, and a mission takes a gyro and an "
        f"accelerometer; give a second device with {absent}s beside it"
    )


def on_mission(limited: Iterable[Name], mission: Mission) -> tuple[Name, ...]:
    """Return what is limited of a mission.

    Raises
    ------
    CallError
        It ends before, or a limit is on height where that is known.
    """
    own = [name for name in limited if name.owner == MISSION]
    faults = [
        f"{name}: {mission.name} ends after {mission.route.duration:g} s"
        for name in own
        if (name.time or 0.0) > mission.route.duration * (1.0 + SAME_TIME)
    ]
    faults += [
        f"{name}: on {mission.name} the altitude is aided, so that it has no error"
        for name in own
        if mission.aided and name.axis == DOWN
    ]
    if faults:
        raise CallError(
            "\n".join(faults) + "\nchange the limits, or take another mission"
        )
    return tuple(own)


def _after_a_turn_on(reference: str | None, requirement: Requirement | None) -> str:
    """Return the error reference of a mission.

    Raises
    ------
    CallError
        Another one is asked for, or the requirement says nothing of a mission.
    """
    if reference not in {None, ON_MISSION}:
        raise CallError(
            f"reference is {reference!r}, and a mission begins with a turn-on of its "
            f"own: allowed is {ON_MISSION}"
        )
    if requirement is not None and MISSION not in requirement.kinds:
        raise CallError(
            f"{requirement.origin.file}: {requirement.name} has no limit on a "
            "mission; add one, as limits: {mission: {position: {horizontal: 1 nmi, "
            "at: 1 h, probability: 50 %}}}, or leave the requirement or the mission out"
        )
    return ON_MISSION


def refuse_unjudged(
    requirement: Requirement, mission: Mission | None, procedure: Procedure
) -> None:
    """Refuse limits on a mission that is not there, and on a calibration that is none.

    Raises
    ------
    CallError
        With the limits that nothing can be said of.
    """
    limited = [name for name in requirement.outputs if name.owner == MISSION]
    if limited and mission is None:
        raise CallError(
            f"{requirement.name} limits {', '.join(limited)}, which depends on the "
            "mission; give one with --mission FILE, or a requirement without "
            "these limits"
        )
    kinds = [kind for kind in requirement.kinds if kind != MISSION]
    if kinds and procedure.formulas in UNCALIBRATED:
        raise CallError(
            f"{requirement.origin.file}: {requirement.name} limits the error that a "
            f"procedure leaves of {' and '.join(kinds)}, found {procedure.name}; "
            "give a procedure, or a requirement with limits on a mission only"
        )


def choose_times(
    mission: Mission,
    asked: Iterable[float | str] = (),
    requirement: Requirement | None = None,
) -> tuple[float, ...]:
    """Return the times at which errors of a mission are looked at, rising [s].

    Those that are asked for, else those of its file; and those that have limits.

    Raises
    ------
    CallError
        The mission ends before one of them, or they are no times, or too many.
    """
    times = [seconds(time) for time in asked]
    limited = () if requirement is None else requirement.outputs
    own = [name.time for name in limited if name.time is not None]
    found = tuple(sorted({*(times or mission.at), *own}))
    late = [t for t in found if t > mission.route.duration * (1.0 + SAME_TIME)]
    if requirement is not None and late and late[-1] in own:
        raise CallError(
            f"{requirement.name} has a limit after {time_text(late[-1])}, and "
            f"{mission.name} lasts {time_text(mission.route.duration)}; expected a "
            "limit within it, or a longer mission"
        )
    if late or found[0] <= 0.0:
        wrong = time_text(late[-1] if late else found[0])
        raise CallError(
            f"--at {wrong}: {mission.name} lasts {time_text(mission.route.duration)}; "
            "expected a time above 0 s within it"
        )
    if len(found) > MOST_TIMES:
        raise CallError(
            f"--at: {len(found)} times are asked for, those of the mission's file and "
            f"of limits among them; {MOST_TIMES} at the most, as memory and time grow "
            "with their cube: choose some with --at"
        )
    return found


def seconds(time: float | str) -> float:
    """Return a time [s], of a number of seconds or a text such as '10 min'.

    Raises
    ------
    CallError
        It is neither.
    """
    if isinstance(time, int | float) and not isinstance(time, bool):
        return float(time)
    if not isinstance(time, str):
        raise CallError(f"time {time!r}: expected seconds, or a text such as '10 min'")
    try:
        return parse_quantity(time, "s", bare="s").value
    except UnitError as error:
        raise CallError(f"time {error}") from None


def kinds_of(devices: Sequence[Device]) -> tuple[str, ...]:
    """Return the kinds of triad that are there, each once."""
    kinds = (sensor.kind for device in devices for sensor in device.sensors)
    return tuple(dict.fromkeys(kinds))


def limited_but_held(
    kinds: Iterable[str], procedure: Procedure, limits: Container[Name]
) -> tuple[Name, ...]:
    """Return what has a limit and is not estimated of triads that are calibrated."""
    there = [kind for kind in kinds if calibrates(kind, procedure)]
    known = known_outputs(there, procedure)
    return tuple(
        name
        for owner in (*there, IMU)
        for name in every_output(owner)
        if name in limits and name not in known and _owners(name) <= {*there}
    )


def choose_outputs(question: Question, texts: Sequence[str]) -> tuple[Name, ...] | None:
    """Resolve the names after `--outputs`: of a group, one of its axes, in any triad.

    Returns
    -------
    tuple of Name or None
        In the order of all outputs; None where nothing was chosen.

    Raises
    ------
    CallError
        A text names no output, or one of a triad that is not there, or one whose
        parameters are not all estimated.
    """
    if not texts:
        return None
    texts = _texts("outputs", texts)
    procedure = question.procedure
    kinds = [sensor.kind for sensor in question.sensors]
    known = known_outputs(kinds, procedure)
    chosen: set[Name] = set()
    faults = []
    for text in texts:
        named = [
            name
            for owner in (*SENSORS, IMU)
            for name in every_output(owner)
            if meant(text, (name, name.group))
        ] or [
            name for name in known if name.owner == text and [*parts_of(name)] == [name]
        ]
        there = {name for name in named if _owners(name) <= {*kinds}}
        chosen |= there
        if not there:
            faults.append(_not_there(text, named, known, procedure))
    absent = [name for name in chosen if name not in known]
    for group in sorted({name.group for name in absent}):
        names = sorted(name for name in absent if name.group == group)
        parts = sorted({p for n in names for p in parts_of(n) if p not in known})
        faults.append(
            f"{', '.join(by_group(names))} cannot be had: {procedure.name} does not "
            f"estimate {', '.join(by_group(parts))}; let `estimate` in the procedure "
            "name it, or leave this output out"
        )
    if faults:
        raise CallError("\n".join(f"--outputs: {fault}" for fault in faults))
    return tuple(name for name in known if name in chosen)


def _texts(option: str, given: Sequence[str]) -> tuple[str, ...]:
    """Return what an option names, one alone too.

    Raises
    ------
    CallError
        It has something else than texts.
    """
    names = (given,) if isinstance(given, str) else given
    if not isinstance(names, Iterable):
        raise CallError(f"{option} is {given!r}, expected names: ['gyro.bias']")
    names = tuple(names)
    if wrong := [one for one in names if not isinstance(one, str)]:
        raise CallError(f"{option} has {wrong[0]!r}, expected names: 'gyro.bias'")
    return names


def _owners(name: Name) -> set[str]:
    """Return the triads that an output is of."""
    return {part.owner for part in parts_of(name)}


def _not_there(
    text: str, named: Sequence[Name], known: Sequence[Name], procedure: Procedure
) -> str:
    """Say that nothing is called so, or of which triads it is."""
    if named:
        owners = " and the ".join(sorted(set().union(*map(_owners, named))))
        return (
            f"{text!r} is of the {owners}: no device with it is given, or "
            f"{procedure.name} does not calibrate it; give a device and a procedure "
            "that do, or leave this output out"
        )
    groups = dict.fromkeys(name.group for name in known)
    words = [*groups, *(group.without_owner for group in groups), *known]
    near = get_close_matches(text, words)
    hint = f"; did you mean {near[0]!r}?" if near else "."
    return (
        f"{text!r} is no output{hint} Known here: {', '.join(groups)}; with an axis "
        "after it, as gyro.bias.z, it is one of them"
    )


def source_names(
    sensors: Sequence[Sensor], procedure: Procedure | None = None
) -> tuple[Name, ...]:
    """Return all sources that these sensors, and with a procedure the place, can have.

    Those of sensors first, then those that all triads share.
    """
    shared = () if procedure is None else SHARED
    return tuple(
        Name(line.name, owner=owner)
        for owner in [*(sensor.kind for sensor in sensors), *shared]
        for line in lines_of(owner)
        if line.may_vary
    )


def given_lines(
    sensors: Sequence[Sensor],
    procedure: Procedure,
    *,
    every: bool = False,
    mission: Mission | None = None,
) -> dict[Name, ErrorLine]:
    """Return every line that counts: of the sensors, the shared ones, of a mission.

    Where `every` parameter counts, those of what is held from its making, too.
    """
    owned = [
        (one.kind, (*one.lines, *(initial_lines(one, procedure) if every else ())))
        for one in sensors
    ]
    owned += procedure.shared.items()
    return {
        Name(line.name, owner=owner): line for owner, lines in owned for line in lines
    } | lines_of_mission(mission)


def find_sources(
    texts: Sequence[str], known: Sequence[Name], *, option: str
) -> tuple[Name, ...]:
    """Turn what a person wrote into names; a bare one means every owner that has it.

    Raises
    ------
    CallError
        A text names none of those that are known.
    """
    words = [*known, *(name.without_owner for name in known)]
    unknown = []
    for text in texts:
        if not meant(text, known):
            near = get_close_matches(text, words)
            hint = f"; did you mean {near[0]!r}?" if near else "."
            unknown.append(f"{text!r} is no source of these devices{hint}")
    if unknown:
        raise CallError(f"{option}: {' '.join(unknown)} Known: {', '.join(known)}")
    return tuple(dict.fromkeys(name for text in texts for name in meant(text, known)))


def read_name(text: str) -> Name:
    """Turn a text of a stored document into the source or output that it names.

    What the tool does not know, such as the name of a file, is a name of one part.
    """
    known = (
        name
        for owner in (*SENSORS, *SHARED, IMU)
        for name in (
            *(Name(line.name, owner=owner) for line in lines_of(owner)),
            *(() if owner in SHARED else every_output(owner)),
        )
    )
    return next((name for name in known if name == text), Name(text))


def choose_sources(question: Question, only: Sequence[str]) -> frozenset[Name] | None:
    """Resolve the names after `--only`; None where nothing is, so that all count.

    Raises
    ------
    CallError
        A name is no source of these sensors.
    """
    if not only:
        return None
    only = _texts("only", only)
    is_known = any(line.course for line in question.procedure.environment)
    known = (
        *(
            name
            for name in source_names(question.sensors, question.procedure)
            if is_known or source_of(name.owner, name.quantity).varies
        ),
        *lines_of_mission(question.journey),
        *([MEASURED] if any(one.measured for one in question.devices) else ()),
    )
    return frozenset(find_sources(only, known, option="--only"))
