"""The lines of a data sheet that an error model uses: one table of all of them."""

from __future__ import annotations

from dataclasses import dataclass

from budget.spec.records import ANGLES, AXES

GYRO = "gyro"
ACCELEROMETER = "accelerometer"
SENSORS = (GYRO, ACCELEROMETER)


@dataclass(frozen=True, kw_only=True)
class Line:
    """One model line: a key in a device file and what becomes of it.

    Attributes
    ----------
    name : str
        The key.
    gyro, accelerometer : str
        The most usual unit of the line on that sensor; '' where it has no such line.
    model : str
        What the line becomes, in words.
    process : bool
        A random process, so normal; else a random constant.
    axes : tuple of str
        x, y, z, or the six mounting angles.
    expected : str
        What a verdict 'meets' cannot do without: the line itself, 'noise' where any
        one noise line will do, '' where the line may be absent.
    """

    name: str
    gyro: str = ""
    accelerometer: str = ""
    model: str
    process: bool = False
    axes: tuple[str, ...] = AXES
    expected: str = ""

    def like(self, sensor: str) -> str:
        """Return the most usual unit of the line on that sensor."""
        return self.gyro if sensor == GYRO else self.accelerometer


LINES = (
    Line(
        name="bias_repeatability",
        gyro="deg/h",
        accelerometer="ug",
        model="random constant, new at each turn-on",
        expected="bias_repeatability",
    ),
    Line(
        name="bias_stability",
        gyro="deg/h",
        accelerometer="ug",
        model="first-order Gauss-Markov process",
        process=True,
        expected="bias_stability",
    ),
    Line(
        name="angle_random_walk",
        gyro="deg/sqrt(h)",
        model="white noise of this one-sided density",
        process=True,
        expected="noise",
    ),
    Line(
        name="velocity_random_walk",
        accelerometer="ug/sqrt(Hz)",
        model="white noise of this one-sided density",
        process=True,
        expected="noise",
    ),
    Line(
        name="rate_random_walk",
        gyro="deg/h/sqrt(h)",
        model="random walk from the start of the test",
        process=True,
    ),
    Line(
        name="acceleration_random_walk",
        accelerometer="ug/sqrt(h)",
        model="random walk from the start of the test",
        process=True,
    ),
    Line(
        name="sample_noise",
        gyro="deg/h",
        accelerometer="ug",
        model="white noise of every sample",
        process=True,
        expected="noise",
    ),
    Line(
        name="scale_factor_repeatability",
        gyro="ppm",
        accelerometer="ppm",
        model="random constant, new at each turn-on",
        expected="scale_factor_repeatability",
    ),
    Line(
        name="scale_factor_nonlinearity",
        gyro="ppm",
        accelerometer="ppm",
        model="random constant of the device",
    ),
    Line(
        name="scale_factor_asymmetry",
        gyro="ppm",
        model="random constant of the device: K(+) minus K(-), over their mean",
    ),
    Line(
        name="mounting_repeatability",
        gyro="arcsec",
        accelerometer="arcsec",
        model="random constant, new at each turn-on",
        axes=ANGLES,
        expected="mounting_repeatability",
    ),
)


def lines_of(sensor: str) -> tuple[Line, ...]:
    """Return the model lines that a sensor can have, in their order."""
    return tuple(line for line in LINES if line.like(sensor))
