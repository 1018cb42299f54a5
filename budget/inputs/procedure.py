"""The procedure file: where and how the calibration is done."""

from __future__ import annotations

from functools import cached_property
from math import pi
from typing import TYPE_CHECKING, Any, ClassVar

from budget.earth import normal_gravity
from budget.inputs.fields import (
    ANGLE,
    SPAN,
    TEXT,
    TIME,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    check,
    fault,
    format_row,
    items,
    measured,
    number,
    one_of,
    or_else,
    table,
)
from budget.inputs.files import open_file, unshown
from budget.inputs.records import (
    AXES,
    AccelerometerProcedure,
    GyroProcedure,
    Origin,
    Procedure,
)
from budget.inputs.station import (
    IDEAL,
    OR_FILE,
    at_station,
    read_station,
    station_file,
    station_of,
    surroundings,
)
from budget.inputs.tree import Node, describe, flow
from budget.inputs.use import AGE_ROW, is_none, stated_lines, with_use
from budget.inputs.windows import WindowItem, lay_out
from budget.language import note
from budget.model.estimators import ESTIMATORS, PLAIN, Estimator, estimator_of
from budget.model.sources import ENVIRONMENT, SENSORS, STATION
from budget.model.sources.place import UNKNOWN, ZERO_UNKNOWN
from budget.names import (
    HIGHER,
    ORDERS,
    PARAMETERS,
    Name,
    by_group,
    parameters_of,
)
from budget.sentences import sentence

if TYPE_CHECKING:
    from budget.inputs.tree import YamlFile
    from budget.model.windows import Window


NO_PAPER = (
    "format",
    "name",
    "estimator",
    "estimate",
    "windows",
    "pause",
    "height",
    "flip_axis",
    "moves",
    "azimuth",
)  # keys it has none of
HEIGHT_0 = note("height: not given, 0 m assumed")  # where gravity is the normal one
# Of one triad beside `weighted`, whose work grows with their cube: 1,000 take 5 s.
MOST_WEIGHED = 1000
NORMAL = "normal"  # gravity of the ellipsoid
PAPER = "paper"  # the estimator of its own test; of windows:
OF_WINDOWS = tuple(one.name for one in ESTIMATORS)
SAYS = tuple((one.name, one.says) for one in ESTIMATORS if one.says)
AZIMUTHS = "azimuths"  # where the bias of gyros is read
MOST_AZIMUTHS = 360  # one for every degree; all windows are correlated with all
MOST_HEIGHT = 100_000.0  # of a laboratory; the series of normal gravity ends there [m]
_ROUNDING = 1e-12  # relative; a latitude of 90 deg is no more than that in radians


def _read_gravity(node: Node, gravity: float, own: Any) -> object:  # noqa: ANN401
    """Read an acceleration, or the word for that of the ellipsoid."""
    value = node.value
    if value == NORMAL:
        return NORMAL
    if isinstance(value, str) and not any(c.isdigit() for c in value):
        expected = "'normal' or an acceleration such as '9.7967 m/s^2'"
        raise fault(f"found {describe(value)}, expected {expected}")
    return own(node, gravity)


class GyroTest(Keyed):
    """Rate turns, then a static test at several azimuths or in twelve positions."""

    rows: ClassVar[Rows] = {  # what stands for a key is the paper's
        "rate": KeyRow(
            measured("deg/s", Sign.POSITIVE),
            "turntable rate of the turns",
            usual="20 deg/s",
        ),
        "turns": KeyRow(
            number(1, 1_000_000),
            "whole turns, so that the earth rate averages out",
            usual=1,
        ),
        "order": KeyRow(
            items(one_of(*AXES)),
            "axes in the order they are turned about",
            usual=("z", "x", "y"),
        ),
        "pause": KeyRow(TIME, "between all windows", usual="0 s"),
        AZIMUTHS: KeyRow(
            items(
                ANGLE,
                most=MOST_AZIMUTHS,
                many=f"names {{number}} azimuths, expected {MOST_AZIMUTHS} at most",
            ),
            "of the static test",
            usual=("0 deg", "180 deg", "270 deg", "450 deg"),
        ),
        "dwell": KeyRow(SPAN, "at each azimuth", usual="300 s"),
        "bias": KeyRow(
            one_of(AZIMUTHS, "twelve_positions"),
            "where it is read: at the azimuths, or in the dwells of the "
            "accelerometers, each axis up and down, so that no knowledge of the earth "
            "rate goes in",
            usual=AZIMUTHS,
        ),
    }
    rules: ClassVar[Rules] = (
        *(
            Rule(
                key,
                lambda it, key=key: key in it.given and it.bias != AZIMUTHS,
                "is of the bias at azimuths, and this is of twelve_positions, whose "
                "dwell is that of the accelerometer; remove it",
            )
            for key in (AZIMUTHS, "dwell")
        ),
        Rule(
            AZIMUTHS,
            lambda it: not it.azimuths,
            "names no azimuth, expected one at least",
        ),
        Rule(
            "order",
            lambda it: sorted(it.order) != [*AXES],
            "found {turned}, expected each of x, y, z once, such as [z, x, y]",
        ),
    )

    @property
    def turned(self) -> str:
        """The order, as a file has it."""
        return flow(self.order)


class AccelerometerTest(Keyed):
    """The twelve-position static test."""

    rows: ClassVar[Rows] = {
        "dwell": KeyRow(SPAN, "at each position", usual="300 s"),
        "pause": KeyRow(TIME, "between all windows", usual="0 s"),
    }


# What can be estimated: a quantity on all its axes, or on one.
PARAMETER_WORDS = (
    *PARAMETERS,
    *(str(name.without_owner) for name in parameters_of(SENSORS[0])),
)
ALL = "all"


# With x of the body along the sensitive axis x, and its y in the plane of x and y.
TRIANGULAR = (
    *("scale_factor", "bias"),
    *("mounting_angle.yz", "mounting_angle.zx", "mounting_angle.zy"),
)


def _estimated(node: Node, gravity: float, read: Any) -> object:  # noqa: ANN401
    """Read what is estimated of one sensor; a test that finds nothing is refused."""
    if node.value == ALL:
        return tuple(PARAMETERS)
    if node.value == ():
        message = (
            "names no parameter, expected one at least; to leave the sensor out give "
            "the windows to the other (use:)"
        )
        raise fault(message)
    return read(node, gravity)


def _estimable(*more: str) -> ValueKind:
    """Return the kind of what is estimated of one sensor, more than of both."""
    return or_else(items(one_of(*PARAMETER_WORDS, *more)), _estimated, {"const": ALL})


class Estimate(Keyed):
    """What the estimator finds; all else is held at the device's nominal values."""

    rows: ClassVar[Rows] = {
        "gyro": KeyRow(
            _estimable(),
            "all, or such as [scale_factor, bias]",
            usual=tuple(PARAMETERS),
        ),
        "accelerometer": KeyRow(
            _estimable(*HIGHER),
            "all, or as [bias, mounting_angle.xy]; "
            "second_order and third_order besides",
            usual=tuple(PARAMETERS),
        ),
    }

    @property
    def orders(self) -> tuple[int, ...]:
        """Powers of an accelerometer's input that are estimated besides."""
        return tuple(p for name, p in ORDERS.items() if name in self.accelerometer)

    def held(self) -> tuple[Name, ...]:
        """Return the parameters that are not named, 'gyro.bias.x'."""
        return tuple(
            name
            for owner in SENSORS
            for name in parameters_of(owner)
            if not {name.quantity, name.without_owner} & {*getattr(self, owner)}
        )


class ProcedureFile(Keyed):
    """A calibration procedure; an unset key takes the value of Zhao 2019."""

    rows: ClassVar[Rows] = {
        "format": format_row("procedure"),
        "name": KeyRow(TEXT, "unset: the file's name"),
        "latitude": KeyRow(ANGLE, "geodetic", usual="34.2394 deg"),
        "gravity": KeyRow(
            or_else(
                measured("m/s^2", Sign.POSITIVE, bare=True),
                _read_gravity,
                {"const": NORMAL},
            ),
            "at the place; normal: WGS 84 at that latitude",
            usual=NORMAL,
        ),
        "height": KeyRow(
            measured("m", Sign.ANY, bare=True),
            "above the ellipsoid, for normal gravity; unset: 0 m",
        ),
        "azimuth": KeyRow(
            one_of(UNKNOWN, ZERO_UNKNOWN),
            "unknown: nobody knows the heading, a new one at each stop, as by hand; "
            "zero_unknown: azimuths are right among one another, their zero is not "
            "known; unset: from north",
        ),
        "sample_rate": KeyRow(
            measured("Hz", Sign.POSITIVE, bare=True),
            "of the sensor outputs",
            usual="100 Hz",
        ),
        "estimator": KeyRow(
            one_of(PAPER, *OF_WINDOWS),
            "; ".join(
                f"{name}: {says}" for name, says in (("paper", "its formulas"), *SAYS)
            )
            + ". Unset: paper, or least_squares where there are windows",
        ),
        "estimate": KeyRow(
            table(Estimate),
            "parameters that are found; unset: all. The others are held at "
            "the device's nominal values, and what they truly are is an error source",
        ),
        "windows": KeyRow(
            items(table(WindowItem)),
            "dwells and turns, in place of the tests of gyro and accelerometer",
        ),
        "pause": KeyRow(TIME, "between all windows; unset: 0 s"),
        "flip_axis": KeyRow(
            one_of("inner", "middle"),
            "axis of the table that z comes down by",
            usual="inner",
        ),
        "moves": KeyRow(
            measured("deg/s", Sign.POSITIVE),
            "of the estimator norm: rate at which the unit is turned from one dwell to "
            "the next, one axis after the other, while the gyro is read, which is "
            "calibrated so; unset: accelerometers alone",
        ),
        "formulas": KeyRow(
            one_of("corrected", PAPER),
            "of the gyro bias: corrected, or as the paper prints them",
            usual="corrected",
        ),
        "gyro": KeyRow(table(GyroTest), usual={}),
        "accelerometer": KeyRow(table(AccelerometerTest), usual={}),
        STATION: KeyRow(
            OR_FILE,
            "uncertainties of table and place, or the file of a station; unset: none",
        ),
        ENVIRONMENT: KeyRow(
            surroundings(ENVIRONMENT),
            "what changes during the calibration, and that of the use; unset: "
            "nothing in the calibration, and of the use nothing is stated; none: "
            "neither",
        ),
        "age": AGE_ROW,
    }
    rules: ClassVar[Rules] = (
        Rule(
            "latitude",
            lambda it: abs(it.latitude.value) > 0.5 * pi * (1.0 + _ROUNDING),
            "found {latitude!r}, expected -90 deg to 90 deg",
        ),
        Rule(
            "height",
            lambda it: it.height and abs(it.height.value) > MOST_HEIGHT,
            f"found {{height!r}}, expected {-MOST_HEIGHT:g} m to {MOST_HEIGHT:g} m",
        ),
        Rule(
            "height",
            lambda it: it.height and it.gravity != NORMAL,
            "is for normal gravity, and gravity is given; remove one of them",
        ),
        Rule(
            "age",
            lambda it: (
                it.age
                and getattr(it.environment, "age", None)
                and not is_none(it.environment)
            ),
            "stands in the environment, too; remove one of them",
        ),
        Rule(
            "pause",
            lambda it: "pause" in it.given and it.windows is None,
            "is of windows; the tests of gyro and accelerometer have their own",
        ),
        Rule(
            "windows",
            lambda it: it.windows == (),
            "names no window, expected one at least",
        ),
        *(
            Rule(
                key,
                lambda it, key=key: it.windows is not None and key in it.given,
                "stands beside windows, which are the whole test; remove one of them",
            )
            for key in SENSORS
        ),
        Rule(
            "estimator",
            lambda it: it.windows is not None and it.estimator == PAPER,
            "found 'paper', whose formulas are of its own test; expected "
            f"{', '.join(OF_WINDOWS[:-1])} or {OF_WINDOWS[-1]} beside windows",
        ),
        Rule(
            "moves",
            lambda it: it.moves and it.kind.knows_attitudes,
            "is of the estimator norm, to which attitudes are unknown; for others give "
            "turns among the windows",
        ),
        Rule(
            ("estimate", "accelerometer"),
            lambda it: (
                not it.kind.knows_attitudes and it.estimate and it.estimate.orders
            ),
            "names a higher order, which the norm of gravity does not find; remove it, "
            "or take another estimator",
        ),
        Rule(
            "formulas",
            lambda it: "formulas" in it.given and it.chosen_estimator != PAPER,
            "is of the estimator paper, and this is {chosen_estimator}; remove it",
        ),
        Rule(
            "formulas",
            lambda it: it.formulas == PAPER and it.gyro.bias != AZIMUTHS,
            "are eq. (4) as printed, which is of the bias at azimuths; remove it, or "
            "the bias of the gyro",
        ),
        Rule(
            "estimate",
            lambda it: it.estimate and it.chosen_estimator == PAPER,
            "is of the estimators for windows, and this is paper, whose formulas find "
            "all; name another estimator, or remove it",
        ),
    )

    def _faults(self) -> dict[tuple[Any, ...], str]:
        """Return what has no sample, or is nothing that the norm of gravity takes."""
        lengths = {
            ("gyro", "rate"): (
                "turn",
                2.0 * pi * self.gyro.turns / self.gyro.rate.value,
            ),
            ("gyro", "dwell"): ("dwell", self.gyro.dwell.value),
            ("accelerometer", "dwell"): ("dwell", self.accelerometer.dwell.value),
        }
        short: dict[tuple[Any, ...], str] = {
            path: f"a {what} of {length:.6g} s has no sample at "
            f"{self.sample_rate.printed}, expected one at least"
            for path, (what, length) in lengths.items()
            if length * self.sample_rate.value < 1.0 - _ROUNDING
        }
        lines = [
            (place, line)
            for place, item in enumerate(self.windows or ())
            for line in item.lines
            if not self.kind.knows_attitudes
        ]
        uses = {
            ("windows", place, "use"): "is of the gyro, and the norm of gravity "
            "calibrates accelerometers alone; remove it, or take another estimator"
            for place, line in lines
            if line.use == "gyro" and line.turn is None
        }
        turns = {
            ("windows", place, "turn"): "turns, and the estimator norm takes dwells "
            "alone; remove it, or give a dwell"
            for place, line in lines
            if line.turn is not None
        }
        return short | uses | turns

    def _faults_of_whole(self) -> dict[tuple[Any, ...], str]:
        """Return what is wrong with the windows, laid out."""
        laid_out = self.laid_out  # refuses windows that overlap
        most = max(
            sum(one.use in {owner, "both"} for one in laid_out) for owner in SENSORS
        )
        if not self.kind.weighs_noise or most <= MOST_WEIGHED:
            return {}
        return {
            ("windows",): f"are {most} of one triad, expected {MOST_WEIGHED} at the "
            "most beside estimator: weighted, which weighs each against every other; "
            "take least_squares, or fewer and longer windows"
        }

    @property
    def held(self) -> tuple[Name, ...]:
        """Parameters that are not estimated, 'gyro.bias.x'.

        How a triad is turned as a whole no norm shows: three angles are held there.
        """
        named = self.estimate or Estimate.of()
        fields = named.given
        if not self.kind.knows_attitudes and "accelerometer" not in fields:
            named = Estimate.of(gyro=named.gyro, accelerometer=TRIANGULAR)
        return named.held()

    @property
    def kind(self) -> Estimator:
        """What holds for the estimator that is named."""
        return estimator_of(self.estimator or "")

    @property
    def chosen_estimator(self) -> str:
        """The estimator, the usual one where none is named."""
        if self.estimator is not None:
            return str(self.estimator)
        return PAPER if self.windows is None else PLAIN

    @cached_property
    def laid_out(self) -> tuple[Window, ...]:
        """The windows on the clock of the file."""
        pause = 0.0 if self.pause is None else self.pause.value
        return lay_out(
            self.windows or (),
            pause,
            self.sample_rate.value,
            flip_axis=self.flip_axis,
            moves=None if self.moves is None else self.moves.value,
        )


def read_procedure(document: YamlFile, station: YamlFile | None = None) -> Procedure:
    """Turn a procedure file into a record, in SI.

    Parameters
    ----------
    document : YamlFile
    station : YamlFile, optional
        The file of the station that it names; without it that file is looked for.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model: ProcedureFile = check(document, table(ProcedureFile))
    origin = Origin(file=document.base_name, sha256=document.sha256)
    name = model.name or document.stem
    named = model.station if isinstance(model.station, str) else None
    own = None if named else model.station
    here = station_of(own, model.environment, name=name, origin=origin)
    is_normal, is_paper = model.gravity == NORMAL, model.chosen_estimator == PAPER
    height = model.height.value if model.height else 0.0
    gyro, accelerometer = model.gyro, model.accelerometer
    procedure = Procedure(
        name=name,
        latitude=model.latitude.value,
        gravity=normal_gravity(model.latitude.value, height)
        if is_normal
        else model.gravity.value,
        height=height,
        is_gravity_normal=is_normal,
        timing=here.timing,
        sample_rate=model.sample_rate.value,
        formulas=model.formulas if is_paper else model.chosen_estimator,
        windows=model.laid_out,
        azimuth=model.azimuth or "",
        held=model.held,
        orders=() if model.estimate is None else model.estimate.orders,
        gyro=GyroProcedure(
            rate=gyro.rate.value,
            turns=gyro.turns,
            order=gyro.order,
            pause=gyro.pause.value,
            azimuths=tuple(azimuth.value for azimuth in gyro.azimuths)
            if gyro.bias == AZIMUTHS
            else (),
            dwell=gyro.dwell.value,
        ),
        accelerometer=AccelerometerProcedure(
            dwell=accelerometer.dwell.value,
            pause=accelerometer.pause.value,
            flip_axis=model.flip_axis,
        ),
        assumptions=(*_assumptions(model), *here.assumptions),
        station=here.station,
        environment=here.environment,
        origin=origin,
    )
    procedure = with_use(procedure, stated_lines(None, model.age))
    if named is None:
        return procedure
    if station is None:
        file, node = station_file(document), document.root.nearest((STATION,))
        with unshown(file.path, f"a {STATION}", document, node):
            there = read_station(open_file(file, STATION))
    else:
        there = read_station(station)
    if model.environment is not None and there.environment:
        message = f"stands beside that of {named}, which has one; remove one of them"
        raise document.refuse(((ENVIRONMENT,), message), on_key=True)
    return at_station(procedure, there)


def _assumptions(model: ProcedureFile) -> tuple[str, ...]:
    """Say what a file leaves open, and how it is taken: as the paper has it."""
    gyro = model.gyro
    of_bias = ("bias",) if gyro.bias == AZIMUTHS else ("bias", AZIMUTHS, "dwell")
    idle = () if model.chosen_estimator == PAPER else ("formulas",)
    parts: tuple[tuple[str, Keyed, tuple[str, ...]], ...] = (
        ("", model, (*NO_PAPER, *SENSORS, STATION, ENVIRONMENT, *idle)),
        ("gyro.", gyro, of_bias),
        ("accelerometer.", model.accelerometer, ()),
    )
    usual = {"estimator": PLAIN, "pause": "0 s"} if model.windows else {}
    return (
        *(
            sentence(
                "assumed.as_in_the_paper",
                key=f"{prefix}{key}",
                shown=flow(row.usual),
            )
            for prefix, part, others in (parts[:1] if model.windows else parts)
            for key, row in part.rows.items()
            if key not in part.given and key not in others
            if row.usual is not None  # an age that nobody states is no 0 either
        ),
        *((HEIGHT_0,) if model.gravity == NORMAL and model.height is None else ()),
        *((IDEAL,) if model.station is None else ()),
        *(
            sentence("assumed.usual", key=key, usual=word)
            for key, word in usual.items()
            if getattr(model, key) is None
        ),
        *(
            sentence("assumed.held", parameters=parameters)
            for parameters in by_group(model.held)
        ),
    )
