"""What is asked: devices, procedure, limits, mission; its Problem and law."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from typing import TYPE_CHECKING, Self

from budget.aiding import problem_of_mission
from budget.calibration.aiding import lines_of_mission
from budget.calibration.derived import (
    combination,
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
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import (
    NORM,
    WEIGHTED,
    calibrates,
    estimated,
    initial_lines,
    noise_of,
    with_accelerometers,
)
from budget.errors import CallError, UnitError
from budget.inputs import load_procedure
from budget.inputs.mission import MOST_TIMES
from budget.inputs.records import UNCALIBRATED, Device
from budget.methods.gum import propagate
from budget.missing import Filling
from budget.missing.expected import expecting, lacking, lacking_of_mission
from budget.model.sources import (
    ACCELEROMETER,
    ENVIRONMENT,
    SENSORS,
    STATION,
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
from budget.sentences import sentence
from budget.settings import Asked, check
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Container, Iterable, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.records import (
        ErrorLine,
        Mission,
        Procedure,
        Requirement,
        Sensor,
    )
    from budget.methods.gum import Propagation
    from budget.problem import Problem
    from budget.results import Budget

SHARED = (STATION, ENVIRONMENT)  # what all triads share
DEFAULT_COVERAGE = 0.95  # [1]
DEFAULT_REFERENCE = "nominal"
SAME_TIME = 1e-9  # relative; of two times that are one [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Question:
    """Devices under a procedure, and what their errors are counted from.

    The Problem and its law are made when they are first asked for, once: whatever
    looks at the same calibration is given this.
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
    mission: Mission | None = None  # that limits may be on
    # Of what follows on it, and at which times besides those of limits [s]; None: the
    # calibration is looked at.
    carried_to: tuple[float, ...] | None = None
    # What calibrated the unit for limits on the mission; None: the procedure.
    on_mission: Procedure | None = None
    # Devices that are comparable; None: those that ship.
    catalogue: tuple[Device, ...] | None = None

    @classmethod
    def of(
        cls,
        *devices: Device,
        procedure: Procedure | None = None,
        requirement: Requirement | None = None,
        coverage: float | None = None,
        reference: str | None = None,
        only: Sequence[str] = (),
        outputs: Sequence[str] = (),
    ) -> Self:
        """Put together what a caller asks for; without an option its usual value.

        Raises
        ------
        CallError
            Options or devices that do not fit together.
        """
        procedure = load_procedure(None) if procedure is None else procedure
        settings = Asked(coverage=coverage, reference=reference).settle(requirement)
        check("analyze", settings)
        chosen, _ = choose_sources(sensors_of(devices, procedure), procedure, only)
        return cls(
            devices=devices,
            procedure=procedure,
            coverage=settings.coverage,
            reference=settings.reference,
            only=chosen,
            requirement=requirement,
            asked=choose_outputs(devices, procedure, outputs),
        )

    def alone(self, owner: str) -> Self:
        """Return the same of one triad, as if the other were not there.

        Of what belongs to both, IMU: the two, with nothing of either alone.
        """
        if owner == IMU:
            known = known_outputs([one.kind for one in self.sensors], self.procedure)
            of_both = tuple(name for name in known if name.owner == IMU)
            return replace(self, requirement=None, asked=of_both)
        if owner == MISSION:
            how = self.on_mission or self.procedure
            return replace(self, procedure=how, asked=None, carried_to=())
        return replace(self, kinds=(owner,), asked=None)

    @property
    def journey(self) -> Mission | None:
        """The mission that it is of; None of a calibration."""
        return None if self.carried_to is None else self.mission

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
    def filled(self) -> Filling:
        """What stands for lines of the triads, and of those that they rest on."""
        there = {one.kind for one in with_accelerometers(self.sensors, self.procedure)}
        filling = self.filling
        names = (*(line.expected for line in filling.lines), *filling.left)
        return filling.of([name for name in names if name.owner in there])

    @cached_property
    def problem(self) -> Problem:
        """Inputs, measurement function and outputs of calibration or mission."""
        if self.journey is not None:
            return problem_of_mission(
                self.sensors,
                self.procedure,
                self.journey,
                self.outputs or (),
                only=self.only,
            )
        return calibration_problem(
            self.sensors,
            self.procedure,
            reference=self.reference,
            only=self.only,
            outputs=self.outputs,
        )

    @cached_property
    def outputs(self) -> tuple[Name, ...] | None:
        """What is asked for and what is limited; None: all parameters, no others."""
        limited = () if self.requirement is None else self.requirement.outputs
        if self.journey is not None:
            every = mission_outputs(self.journey, self.carried_to or ())
            asked = every if self.asked is None else self.asked
            own = on_mission(limited, self.journey)
            return tuple(dict.fromkeys((*asked, *own)))
        return outputs_for(
            [sensor.kind for sensor in self.sensors],
            self.procedure,
            limited,
            self.asked,
        )

    @cached_property
    def derive(self) -> Callable[[Array], Array]:
        """What makes outputs of errors of the parameters, both of shape (n, runs) [SI].

        Raises
        ------
        CallError
            They are of a mission, in which errors of parameters are not all.
        """
        if self.journey is not None:
            raise CallError(
                "--method simulation simulates the calibration, and a mission takes "
                "its noise in run besides; take gum or monte-carlo"
            )
        if self.outputs is None:
            return lambda errors: errors
        kinds = [sensor.kind for sensor in self.sensors]
        names = [name for kind in kinds for name in estimated(kind, self.procedure)]
        return combination(names, self.outputs)

    @cached_property
    def law(self) -> Propagation:
        """The law of propagation for it."""
        return propagate(self.problem)

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
        if procedure.formulas == NORM and ACCELEROMETER not in kinds:
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


def after_a_turn_on(reference: str | None) -> str:
    """Return the error reference of a mission.

    Raises
    ------
    CallError
        Another one is asked for.
    """
    if reference not in {None, ON_MISSION}:
        raise CallError(
            f"reference is {reference!r}, and a mission begins with a turn-on of its "
            f"own: allowed is {ON_MISSION}"
        )
    return ON_MISSION


def limits_on_mission(requirement: Requirement) -> None:
    """Refuse a requirement that says nothing of a mission.

    Raises
    ------
    CallError
        It has no limit on one.
    """
    if MISSION not in requirement.kinds:
        raise CallError(
            f"{requirement.origin.file}: {requirement.name} has no limit on a "
            "mission; add one, as limits: {mission: {position: {horizontal: 1 nmi, "
            "at: 1 h, probability: 50 %}}}, or leave the requirement or the mission out"
        )


def mission_for(requirement: Requirement, mission: Mission | None) -> None:
    """Refuse limits on a mission without one, and one without limits on it.

    Raises
    ------
    CallError
        With the limits that nothing can be said of.
    """
    if mission is not None:
        limits_on_mission(requirement)
    elif limited := [name for name in requirement.outputs if name.owner == MISSION]:
        raise CallError(
            f"{requirement.name} limits {', '.join(limited)}, which depends on the "
            "mission; give one with --mission FILE, or a requirement without "
            "these limits"
        )


def needs_test(requirement: Requirement, procedure: Procedure) -> None:
    """Refuse limits on a calibration where nobody calibrates.

    Raises
    ------
    CallError
        With what they are on.
    """
    limited = [kind for kind in requirement.kinds if kind != MISSION]
    if limited and procedure.formulas in UNCALIBRATED:
        raise CallError(
            f"{requirement.origin.file}: {requirement.name} limits the residual error "
            f"of {' and '.join(limited)}, and {procedure.name} is no calibration; "
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


def not_calibrated(devices: Sequence[Device], procedure: Procedure) -> tuple[str, ...]:
    """Say of which triads that are there a procedure finds nothing."""
    if procedure.formulas in UNCALIBRATED:
        return ()
    return tuple(
        sentence("cautions.not_calibrated", procedure=procedure.name, sensor=kind)
        for kind in _kinds(devices)
        if not calibrates(kind, procedure)
    )


def _kinds(devices: Sequence[Device]) -> tuple[str, ...]:
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


def not_estimated(
    devices: Sequence[Device], procedure: Procedure, requirement: Requirement | None
) -> tuple[str, ...]:
    """Say which limits a procedure says nothing of, as it holds what they are on."""
    limits = () if requirement is None else requirement.outputs
    return tuple(
        sentence(
            "cautions.not_estimated", procedure=procedure.name, parameters=parameters
        )
        for parameters in by_group(limited_but_held(_kinds(devices), procedure, limits))
    )


def not_on_a_mission(
    requirement: Requirement | None, mission: Mission | None
) -> tuple[str, ...]:
    """Say that limits on a mission are judged by nobody who is given none."""
    if mission is not None or requirement is None or MISSION not in requirement.kinds:
        return ()
    return (sentence("cautions.limits_on_a_mission"),)


def not_of_one_sensor(requirement: Requirement) -> tuple[str, ...]:
    """Say which limits are judged by nobody who takes the sensors one by one."""
    of_both = [name for name in requirement.outputs if name.owner == IMU]
    return tuple(
        sentence("cautions.of_both", parameters=parameters)
        for parameters in by_group(of_both)
    )


def not_weighted(sensors: Sequence[Sensor], procedure: Procedure) -> tuple[str, ...]:
    """Say for which triads there is no noise that an estimator could weigh by."""
    if procedure.formulas != WEIGHTED:
        return ()
    return tuple(
        sentence("cautions.no_weights", sensor=sensor.kind)
        for sensor in sensors
        if not noise_of(sensor.kind, sensor.lines)
    )


def choose_outputs(
    devices: Sequence[Device], procedure: Procedure, texts: Sequence[str]
) -> tuple[Name, ...] | None:
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
    if isinstance(texts, str):  # one name, not a sequence of letters
        texts = (texts,)
    kinds = [sensor.kind for sensor in sensors_of(devices, procedure)]
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
    owners = [*(sensor.kind for sensor in sensors), *shared]
    return tuple(
        Name(line.name, owner=owner)
        for owner in owners
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
    owned += [(STATION, procedure.station), (ENVIRONMENT, procedure.environment)]
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


def choose_sources(
    sensors: Sequence[Sensor],
    procedure: Procedure,
    only: Sequence[str],
    mission: Mission | None = None,
) -> tuple[frozenset[Name] | None, tuple[str, ...]]:
    """Resolve the names after `--only`.

    Returns
    -------
    frozenset of Name or None
        None where nothing was chosen, so that everything counts.
    tuple of str
        Warnings about lines that a device does not give.

    Raises
    ------
    CallError
        A name is no source of these sensors.
    """
    if not only:
        return None, ()
    if isinstance(only, str):  # one name, not a sequence of letters
        only = (only,)
    is_known = any(line.course for line in procedure.environment)
    known = (
        *(
            name
            for name in source_names(sensors, procedure)
            if is_known or source_of(name.owner, name.quantity).varies
        ),
        *lines_of_mission(mission),
    )
    chosen = frozenset(find_sources(only, known, option="--only"))
    given = given_lines(sensors, procedure, mission=mission)
    absent = sorted(chosen - given.keys())
    return chosen, tuple(sentence("cautions.asked_alone", name=name) for name in absent)
