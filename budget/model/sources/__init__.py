"""Table of the error sources, one row each.

Everything else reads this table: files their keys and units, the calibration its
inputs, the simulation its samples, results what is expected, figures their colours.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from budget.errors import CallError
from budget.model.source import (
    ACCELEROMETER,
    DEVICE,
    ENVIRONMENT,
    GYRO,
    IN_RUN,
    PROCEDURE,
    SENSORS,
    SHARED,
    STATION,
    TEST,
    TURN_ON,
    Initial,
    Nonlinearity,
    Offset,
    Source,
)
from budget.model.sources.asymmetry import InputAsymmetry, TurnAsymmetry
from budget.model.sources.g_sensitivity import ELEMENTS, GSensitivity
from budget.model.sources.later import (
    AGE,
    AGEING,
    MISSION_TEMPERATURE,
    MISSION_VIBRATION,
    RECTIFICATION,
    TEST_VIBRATION,
    Age,
    Ageing,
    OverTemperature,
    Vibration,
    VibrationRectification,
)
from budget.model.sources.place import (
    ZERO_UNKNOWN,
    EarthRate,
    Height,
    Latitude,
    LocalGravity,
    UnknownAzimuth,
)
from budget.model.sources.power import Power
from budget.model.sources.processes import (
    LOW_CUT,
    FlickerNoise,
    Quantization,
    SampleNoise,
    Stability,
    Walk,
    WhiteNoise,
)
from budget.model.sources.rotation import (
    AFTER_MIDDLE,
    AFTER_OUTER,
    BASE,
    BODY,
    Mount,
    Positioning,
    Rotation,
    Wobble,
)
from budget.model.sources.temperature import (
    ON_THE_WAY,
    OnTheWay,
    RandomTemperature,
    Soaks,
    TemperatureChange,
    TemperatureCoefficient,
    TemperatureRamp,
    WarmUp,
)
from budget.model.sources.timing import Clock, EdgeJitter, RateError, TurnAngle
from budget.names import ANGLES, AXES, ONE_VALUE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.model.sources.outside import Outside

__all__ = [
    "ACCELEROMETER",
    "BAND",
    "DEVICE",
    "ENVIRONMENT",
    "FLICKER",
    "GYRO",
    "IN_RUN",
    "LOW_CUT",
    "PROCEDURE",
    "SAMPLE_NOISE",
    "SENSORS",
    "SHARED",
    "SOURCES",
    "STATION",
    "TEST",
    "TURN_ON",
    "WHITE",
    "blamed_outside",
    "every_source",
    "from_outside",
    "lines_of",
    "outside_faults",
    "source_of",
    "twin_of",
    "walk_of",
]

BAND = "band"  # form of a sample noise that is the rms in a bandwidth
FLICKER = "flicker"  # form of a bias stability that is the floor of an Allan curve

# In the order of tables, figures and inputs.
SOURCES = (
    Source(
        name="bias_repeatability",
        units={GYRO: "deg/h", ACCELEROMETER: "ug"},
        model="random constant, new at each turn-on",
        effect=Offset("bias"),
        stays=TURN_ON,
        expected="bias_repeatability",
        colour="blue",
        over_temperature="bias_over_temperature",
        grades=(ACCELEROMETER,),
    ),
    Source(
        name="bias_stability",
        units={GYRO: "deg/h", ACCELEROMETER: "ug"},
        model="first-order Gauss-Markov process",
        effect=Stability(),
        stays=IN_RUN,
        expected="bias_stability",
        colour="orange",
        forms={FLICKER: FlickerNoise()},
        value="stability",
        over_temperature="bias_over_temperature",
        grades=(GYRO,),
    ),
    Source(
        name="flicker",
        units={GYRO: "deg/h", ACCELEROMETER: "ug"},
        model="flicker noise of coefficient B, above a low cut",
        effect=FlickerNoise(),
        stays=IN_RUN,
        expected="bias_stability",
        colour="",
        value="flicker",
        beside=("bias_stability",),
    ),
    Source(
        name="angle_random_walk",
        units={GYRO: "deg/sqrt(h)"},
        model="white noise, whose integral is this random walk",
        effect=WhiteNoise(),
        stays=IN_RUN,
        expected="noise",
        colour="green",
        value="walk",
    ),
    Source(
        name="velocity_random_walk",
        units={ACCELEROMETER: "ug/sqrt(Hz)"},
        model="white noise, whose integral is this random walk",
        effect=WhiteNoise(),
        stays=IN_RUN,
        expected="noise",
        colour="green",
        value="walk",
    ),
    Source(
        name="rate_random_walk",
        units={GYRO: "deg/h/sqrt(h)"},
        model="random walk from the start of the calibration",
        effect=Walk(),
        stays=IN_RUN,
        colour="purple",
        value="walk",
    ),
    Source(
        name="acceleration_random_walk",
        units={ACCELEROMETER: "ug/sqrt(h)"},
        model="random walk from the start of the calibration",
        effect=Walk(),
        stays=IN_RUN,
        colour="purple",
        value="walk",
    ),
    Source(
        name="sample_noise",
        units={GYRO: "deg/h", ACCELEROMETER: "ug"},
        model="white noise of every sample",
        effect=SampleNoise(),
        forms={BAND: WhiteNoise()},
        stays=IN_RUN,
        expected="noise",
        colour="sky",
        value="sample_noise",
        beside=("angle_random_walk", "velocity_random_walk"),
    ),
    Source(
        name="quantization",
        units={GYRO: "arcsec", ACCELEROMETER: "m/s"},
        model="rounding of increments of angle or velocity to whole steps",
        effect=Quantization(),
        stays=IN_RUN,
        colour="green",
        is_hatched=True,
    ),
    Source(
        name="scale_factor_repeatability",
        units={GYRO: "ppm", ACCELEROMETER: "ppm"},
        model="random constant, new at each turn-on",
        effect=Offset("scale_factor"),
        stays=TURN_ON,
        expected="scale_factor_repeatability",
        colour="vermilion",
        over_temperature="scale_factor_over_temperature",
    ),
    Source(
        name="scale_factor_nonlinearity",
        units={GYRO: "ppm", ACCELEROMETER: "ppm"},
        model="random constant of the device",
        effect=Nonlinearity("scale_factor"),
        stays=DEVICE,
        colour="vermilion",
        is_hatched=True,
        forms={"cubic": Power(3), "quadratic": Power(2)},
        value="nonlinearity",
    ),
    *(
        Source(
            name="scale_factor_asymmetry",
            units={owner: "ppm"},
            model="random constant of the device: K(+) minus K(-), over their mean",
            effect=next(iter(forms.values())),
            stays=DEVICE,
            colour="black",
            forms=forms,
            value="asymmetry",
        )
        for owner, forms in (
            (GYRO, {"turn": TurnAsymmetry(), "input": InputAsymmetry()}),
            (ACCELEROMETER, {"input": InputAsymmetry()}),
        )
    ),
    Source(
        name="mounting_repeatability",
        units={GYRO: "arcsec", ACCELEROMETER: "arcsec"},
        model="random constant, new at each turn-on",
        effect=Offset("mounting_angle"),
        stays=TURN_ON,
        axes=ANGLES,
        expected="mounting_repeatability",
        colour="yellow",
    ),
    Source(
        name="g_sensitivity",
        units={GYRO: "deg/h/g"},
        model="random constant of the device: nine elements, G times the force",
        effect=GSensitivity(),
        stays=DEVICE,
        axes=ELEMENTS,
        colour="sky",
        is_hatched=True,
        is_asked=True,
    ),
    Source(
        name="scale_factor_quadratic",
        units={GYRO: "ppm/(deg/s)", ACCELEROMETER: "ug/g^2"},
        model="random constant of the device: K2 times the square of the input",
        effect=Power(2),
        stays=DEVICE,
        colour="black",
        is_hatched=True,
    ),
    Source(
        name="scale_factor_cubic",
        units={GYRO: "ppm/(deg/s)^2", ACCELEROMETER: "ug/g^3"},
        model="random constant of the device: K3 times the cube of the input",
        effect=Power(3),
        stays=DEVICE,
        colour="purple",
        is_hatched=True,
    ),
    Source(
        name="bias_temperature_coefficient",
        units={GYRO: "deg/h/degC", ACCELEROMETER: "ug/degC"},
        model="fixed change of the bias with the temperature of the environment",
        effect=TemperatureCoefficient(),
        forms={ON_THE_WAY: OnTheWay("bias")},
        stays=DEVICE,
        use="temperature",
        is_asked=True,
    ),
    Source(
        name="bias_temperature_rate_coefficient",
        units={GYRO: "deg/h/(degC/min)", ACCELEROMETER: "ug/(degC/min)"},
        model="fixed change of the bias with the rate of change of that temperature",
        effect=TemperatureCoefficient(),
        forms={ON_THE_WAY: OnTheWay("bias", is_of_rate=True)},
        stays=DEVICE,
        is_asked=True,
    ),
    Source(
        name="scale_factor_temperature_coefficient",
        units={GYRO: "ppm/degC", ACCELEROMETER: "ppm/degC"},
        model="fixed relative change of the scale factor with that temperature",
        effect=TemperatureCoefficient(),
        forms={ON_THE_WAY: OnTheWay("scale_factor")},
        stays=DEVICE,
        use="temperature",
        is_asked=True,
    ),
    Source(
        name="bias_over_temperature",
        units={GYRO: "deg/h", ACCELEROMETER: "ug"},
        model="random constant of a later turn-on, at another temperature",
        effect=OverTemperature("bias"),
        stays=DEVICE,
        colour="blue",
        is_hatched=True,
        use="temperature",
        left_of=(
            "bias_temperature_coefficient",
            "bias_temperature_rate_coefficient",
        ),
    ),
    Source(
        name="scale_factor_over_temperature",
        units={GYRO: "ppm", ACCELEROMETER: "ppm"},
        model="random constant of a later turn-on, at another temperature",
        effect=OverTemperature("scale_factor"),
        stays=DEVICE,
        colour="orange",
        is_hatched=True,
        use="temperature",
        left_of=("scale_factor_temperature_coefficient",),
    ),
    Source(
        name=AGEING["bias"],
        units={GYRO: "deg/h", ACCELEROMETER: "ug"},
        model="what the bias has gone a time after its calibration",
        effect=Ageing("bias"),
        stays=DEVICE,
        colour="",
        value="ageing",
        beside=("bias_repeatability",),
        use="age",
        is_asked=True,
    ),
    Source(
        name=AGEING["scale_factor"],
        units={GYRO: "ppm", ACCELEROMETER: "ppm"},
        model="what the scale factor has gone a time after its calibration",
        effect=Ageing("scale_factor"),
        stays=DEVICE,
        colour="",
        value="ageing",
        beside=("scale_factor_repeatability",),
        use="age",
        is_asked=True,
    ),
    Source(
        name=RECTIFICATION,
        units={GYRO: "deg/h/g^2", ACCELEROMETER: "ug/g^2"},
        model="random constant of the device: bias over the square of a vibration",
        effect=VibrationRectification(),
        stays=DEVICE,
        colour="yellow",
        is_hatched=True,
        use="vibration",
        is_asked=True,
    ),
    Source(
        name="initial_bias",
        units={GYRO: "deg/s", ACCELEROMETER: "mg"},
        model="random constant of the device, that every calibration finds",
        effect=Initial("bias"),
        stays=DEVICE,
        colour="",
    ),
    Source(
        name="initial_scale_factor",
        units={GYRO: "%", ACCELEROMETER: "%"},
        model="random constant of the device, that every calibration finds",
        effect=Initial("scale_factor"),
        stays=DEVICE,
        colour="",
    ),
    Source(
        name="initial_mounting",
        units={GYRO: "mrad", ACCELEROMETER: "mrad"},
        model="random constant of the device, that every calibration finds",
        effect=Initial("mounting_angle"),
        stays=DEVICE,
        axes=ANGLES,
        colour="",
    ),
    Source(
        name="temperature.ramp",
        units={ENVIRONMENT: "degC/h"},
        model="steady change of the temperature from the start of each triad's test",
        effect=TemperatureRamp(),
        stays=TEST,
        axes=ONE_VALUE,
    ),
    Source(
        name="temperature.sigma",
        units={ENVIRONMENT: "degC"},
        model="random temperature, a stationary first-order Gauss-Markov process",
        effect=RandomTemperature(),
        stays=IN_RUN,
        axes=ONE_VALUE,
        time="correlation_time",
    ),
    Source(
        name="temperature.warm_up",
        units={ENVIRONMENT: "degC"},
        model="what is missing at the start of each triad's test, less and less",
        effect=WarmUp(),
        stays=TEST,
        axes=ONE_VALUE,
        time="warm_up_time",
    ),
    Source(
        name="temperature.soak",
        units={ENVIRONMENT: "degC"},
        model="temperature of each soak, on its own, which the sensors settle to",
        effect=Soaks(),
        stays=TEST,
        axes=ONE_VALUE,
        time="settling_time",
        points="soak_points",
    ),
    Source(
        name=MISSION_TEMPERATURE,
        units={ENVIRONMENT: "degC"},
        model="temperature of a later turn-on less that of the calibration",
        effect=TemperatureChange(),
        stays=TURN_ON,
        axes=ONE_VALUE,
    ),
    *(
        Source(
            name=name,
            units={ENVIRONMENT: "g"},
            model=f"known vibration, rms, {when}",
            effect=Vibration(),
            stays=TEST,
            axes=ONE_VALUE,
        )
        for name, when in (
            (TEST_VIBRATION, "during the calibration"),
            (MISSION_VIBRATION, "at a later turn-on"),
        )
    ),
    Source(
        name=AGE,
        units={ENVIRONMENT: "s"},
        model="known time from the calibration to a later turn-on",
        effect=Age(),
        stays=TEST,
        axes=ONE_VALUE,
    ),
    Source(
        name="turn_angle",
        units={STATION: "arcsec"},
        model="angle that each turn of the table misses, on its own",
        effect=TurnAngle(),
        stays=TEST,
        axes=ONE_VALUE,
    ),
    *(
        Source(
            name=name,
            units={STATION: "arcsec"},
            model=model,
            effect=effect,
            stays=TEST,
            axes=axes,
        )
        for name, model, effect, axes in (
            (
                "orthogonality.outer_middle",
                "angle that outer and middle axis miss of a right one",
                Rotation(AFTER_OUTER, 0),
                ONE_VALUE,
            ),
            (
                "orthogonality.middle_inner",
                "angle that middle and inner axis miss of a right one",
                Rotation(AFTER_MIDDLE, 2),
                ONE_VALUE,
            ),
            (
                "encoder_zero.middle",
                "zero of the middle axis' encoder",
                Rotation(AFTER_MIDDLE, 1),
                ONE_VALUE,
            ),
            (
                "encoder_zero.inner",
                "zero of the inner axis' encoder",
                Rotation(BODY, 0),
                ONE_VALUE,
            ),
            (
                "positioning",
                "angle that each axis of the table misses at each stop, on its own",
                Positioning(),
                ONE_VALUE,
            ),
            (
                "levelling.east",
                "tilt of the table's base about east",
                Rotation(BASE, 0),
                ONE_VALUE,
            ),
            (
                "levelling.north",
                "tilt of the table's base about north",
                Rotation(BASE, 1),
                ONE_VALUE,
            ),
            (
                "azimuth",
                "turn of the table's base against north, with the outer zero",
                Rotation(BASE, 2),
                ONE_VALUE,
            ),
            (
                "wobble",
                "lean of each rotor while it turns, that turns with it",
                Wobble(),
                ONE_VALUE,
            ),
            ("mount", "turn of the body against the inner axis", Mount(), AXES),
        )
    ),
    *(
        Source(
            name=name,
            units={STATION: unit},
            model=model,
            effect=effect,
            stays=TEST,
            axes=ONE_VALUE,
        )
        for name, unit, model, effect in (
            ("rate_error", "ppm", "rate that the table turns too fast", RateError()),
            ("latitude", "arcsec", "latitude that is used, minus the true", Latitude()),
            ("height", "m", "height that is used, minus the true", Height()),
            ("gravity", "mGal", "gravity that is used, minus the true", LocalGravity()),
            (
                "earth_rate",
                "deg/h",
                "earth rate that is used, minus the true",
                EarthRate(),
            ),
            (
                "edge_jitter",
                "s",
                "time that each edge of a window on a moving table misses, on its own",
                EdgeJitter(),
            ),
            ("clock", "ppm", "time that the clock counts too much", Clock()),
        )
    ),
    Source(
        name="heading",
        units={PROCEDURE: "deg/h"},
        model="horizontal earth rate at a heading that nobody knows",
        effect=UnknownAzimuth(),
        stays=TEST,
        axes=ONE_VALUE,
        forms={ZERO_UNKNOWN: UnknownAzimuth(is_one=True)},
    ),
)

# What white noise may be given as: as a random walk or by the sample, not as both.
WHITE = tuple(one.name for one in SOURCES if one.expected == "noise")
SAMPLE_NOISE = next(one.name for one in SOURCES if isinstance(one.effect, SampleNoise))


@cache
def from_outside() -> Outside:
    """Return the lines of other packages, looked for once."""
    from budget.model.sources.outside import find_outside

    return find_outside(source.name for source in SOURCES)


def every_source() -> tuple[Source, ...]:
    """Return all sources in their order, those of other packages last."""
    return (*SOURCES, *from_outside().sources)


def outside_faults() -> tuple[str, ...]:
    """Return what is wrong with lines of other packages, if they were looked for."""
    was_asked = from_outside.cache_info().currsize
    return tuple(from_outside().faults.values()) if was_asked else ()


def blamed_outside(error: BaseException) -> str:
    """Say in which other package's line an error arose; '' in none."""
    if not from_outside.cache_info().currsize:
        return ""
    from budget.model.sources.outside import blamed

    return blamed(error, from_outside().sources)


@cache
def lines_of(owner: str) -> tuple[Source, ...]:
    """Return the sources that an owner can have, in their order."""
    every = every_source() if owner in SENSORS else SOURCES
    return tuple(source for source in every if source.like(owner))


@cache
def source_of(owner: str, name: str) -> Source:
    """Return the source of that name.

    Raises
    ------
    CallError
        The table has no such source: nothing is taken for what it is not.
    """
    for source in SOURCES:  # others are looked for where it is none of these
        if source.name == name and source.like(owner):
            return source
    for source in from_outside().sources:
        if source.name == name and source.like(owner):
            return source
    fault = from_outside().faults.get(name, "")
    raise CallError(
        f"{owner}.{name} is no error source; there are: {_names(lines_of(owner))}. "
        + (fault or "A new source is a row of budget.model.sources")
    )


def _names(sources: Iterable[Source]) -> str:
    return ", ".join(source.name for source in sources)


def walk_of(sensor: str) -> str:
    """Return the random walk that white noise is on that sensor."""
    white = (one for one in SOURCES if one.value == "walk" and one.expected)
    return next(one.name for one in white if one.like(sensor))


def twin_of(name: str) -> str:
    """Return the line that is the same on the other kind of sensor; '' if none is."""
    for one in SOURCES:
        for other in SOURCES if one.name == name else ():
            alike = (type(other.effect), other.model) == (type(one.effect), one.model)
            if alike and not other.units.keys() & one.units.keys():
                return other.name
    return ""
