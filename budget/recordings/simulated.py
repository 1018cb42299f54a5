"""A recording at rest as a device would give it: seeded, sample by sample.

It is the simulation of a calibration (budget.calibration.simulation) with one dwell:
body axes to east, north and up, of what a data sheet gives the constants of one turn-on
and the noise. Temperature, vibration and age stay what they are, and a table has no
errors.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import ceil, log, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.simulation import (
    DrawnSource,
    SampledWindow,
    TurnOn,
    draw_source,
    reading_of,
    stream_of,
    turn_on_of,
)
from budget.errors import CallError, UnitError
from budget.inputs import load_device, load_procedure
from budget.model.noise import RATIO
from budget.model.source import (
    Disturbance,
    Noise,
    Offset,
    Samples,
    TableState,
)
from budget.model.sources import source_of
from budget.model.sources.processes import LOW_CUT, FlickerNoise, Stability
from budget.model.windows import Timing, Window
from budget.names import AXES, Name
from budget.recordings.columns import CHANNELS, LIKE, TIME
from budget.settings import LEAST_RATE, MOST_RATE, Asked, Inputs, asking
from budget.units import parse_quantity, size_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import Device, ErrorLine, Procedure, Sensor
    from budget.model.scheme import Scheme
    from budget.model.source import Given

LEAST_SAMPLES, MOST_SAMPLES = 100, 1_000_000_000
PIECE = 2**15  # samples that are made at a time
NUMBER, STAMP = "%.9g", "%.12g"  # as they are written
AT_REST = Window(name="at rest", start=0.0, length=np.inf)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedReadings:
    """What a device would give: drawn of one seed, made piece by piece when asked for.

    Attributes
    ----------
    device : Device
    procedure : Procedure
    rate : float
        Of sampling [Hz].
    seed : int
    """

    device: Device
    procedure: Procedure
    rate: float
    seed: int

    @property
    @abstractmethod
    def samples(self) -> int:
        """How many there are."""

    def scheme_of(self, sensor: Sensor) -> Scheme | None:  # noqa: ARG002
        """Return the windows of a triad; None of no test."""
        return None

    def acts(self, owner: str, line: ErrorLine) -> bool:
        """Whether a line acts."""
        return _acts(owner, line)

    @cached_property
    def heads(self) -> tuple[str, ...]:
        """Of its columns, with units."""
        there = {one.kind for one in self.device.sensors}
        channels = [
            (name, name.rpartition("_")[0])
            for name in CHANNELS
            if name.rpartition("_")[0] in there
        ]
        return (
            f"{TIME} [{LIKE[TIME]}]",
            *(f"{name} [{LIKE[sensor]}]" for name, sensor in channels),
        )

    @cached_property
    def not_in_it(self) -> tuple[Name, ...]:
        """What is expected of a data sheet and not given, so that nothing has it."""
        return tuple(x for one in self.device.sensors for x in one.expected_missing)

    @cached_property
    def turn_ons(self) -> Mapping[str, TurnOn]:
        """The constants that each triad has, by its kind [SI]."""
        return {
            one.kind: turn_on_of(one, self._draw(one), known_lines(one))
            for one in self.device.sensors
        }

    @cached_property
    def constants(self) -> Mapping[Name, Array]:
        """What was drawn of each specification that is a constant, by axis [SI]."""
        return {
            Name(drawn.given.name, owner=one.kind): drawn.value
            for one in self.device.sensors
            for drawn in self._draw(one)
            if drawn.samples is None
        }

    @cached_property
    def processes(self) -> tuple[Name, ...]:
        """Specifications that are noise in it."""
        return tuple(
            Name(drawn.given.name, owner=one.kind)
            for one in self.device.sensors
            for drawn in self._draw(one)
            if drawn.samples is not None
        )

    def _draw(self, sensor: Sensor) -> list[DrawnSource]:
        """Draw what the sources are; of a process its first samples are to come."""
        stream = partial(stream_of, self.seed, 0)
        drawn = [
            draw_source(sensor.kind, line, self.scheme_of(sensor), self.rate, stream)
            for line in (*sensor.lines, *sensor.initial)
            if line.u.any() and self.acts(sensor.kind, line)
        ]
        return [
            replace(
                one,
                samples=flicker_samples(
                    one.given,
                    stream(Name(one.given.name, owner=sensor.kind)),
                    self.rate,
                ),
            )
            if isinstance(one.effect, FlickerNoise)
            else one
            for one in drawn
        ]

    def csv(self) -> Iterator[str]:
        """Yield its text as a file has it, heads first; of one seed the same bytes."""
        yield ",".join(self.heads) + "\n"
        sizes = [size_of(LIKE[TIME])]
        for one in self.device.sensors:
            sizes += [size_of(LIKE[one.kind])] * len(AXES)
        row = ",".join([STAMP, *[NUMBER] * (len(sizes) - 1)]) + "\n"
        for piece in self.pieces():
            yield row * len(piece) % tuple((piece / sizes).ravel().tolist())

    @abstractmethod
    def pieces(self) -> Iterator[Array]:
        """Yield stamps [s] and readings [rad/s, m/s^2], shape (n, 1 + columns)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedRecording(SimulatedReadings):
    """A recording at rest that a device would give.

    Attributes
    ----------
    asked : int
        Samples that it has.
    """

    asked: int

    @property
    def samples(self) -> int:
        """How many there are."""
        return self.asked

    @property
    def duration(self) -> float:
        """From the first sample to the end of the last [s]."""
        return self.samples / self.rate

    def pieces(self) -> Iterator[Array]:
        """Yield stamps [s] and readings [rad/s, m/s^2], shape (n, 1 + columns)."""
        dt = 1.0 / self.rate
        table = TableState(
            turn=None,
            stop=0,
            turning=None,
            angle=0.0,
            length=self.duration,
            place=self.procedure.place,
            timing=Timing(),
        )
        triads = [
            (one, self._draw(one), self.turn_ons[one.kind], known_lines(one))
            for one in self.device.sensors
        ]
        for first in range(0, self.samples, PIECE):
            n = min(PIECE, self.samples - first)
            at = Samples(n=n, dt=dt, first=(first + 0.5) * dt)
            columns = [(np.arange(first, first + n) * dt)[None]]
            for sensor, drawn, tested, known in triads:
                where = SampledWindow(
                    window=AT_REST, table=table, samples=at, known=known
                )
                found = reading_of(sensor, tested, drawn, where)
                K = (1.0 + tested.k)[:, None]
                columns.append(np.broadcast_to(K * found, (len(AXES), n)))
            yield np.concatenate(columns).T


def flicker_samples(
    given: Given, rng: np.random.Generator, sample_rate: float
) -> Callable[[Samples], Array]:
    """Return what yields the next samples of flicker noise, shape (3, n).

    Gauss-Markov processes of correlation times RATIO apart, each of variance
    B^2 ln(RATIO)/pi, from the low cut f_L, 1/(2 pi f_L), to half the sample rate: no
    lines, as sums of waves have them, which a spectrum would show.
    """
    low = LOW_CUT if given.low_cut is None else given.low_cut
    slowest = 1.0 / (2.0 * pi * np.broadcast_to(low, given.u.shape))
    number = ceil(log(slowest.max() * pi * sample_rate) / log(RATIO))
    parts = []
    for place in range(number):
        times = slowest * RATIO ** -(place + 0.5)
        u = given.u * sqrt(log(RATIO) / pi) * (times * pi * sample_rate >= 1.0)
        one = replace(given, u=u, correlation_time=times)
        parts.append(Stability().sampler(one, rng, sample_rate))
    return lambda at: np.asarray(sum(part(at) for part in parts))


def known_lines(sensor: Sensor) -> Mapping[str, ErrorLine]:
    """Return what the data sheet gives, by key."""
    return {line.name: line for line in sensor.lines}


def _acts(owner: str, line: ErrorLine) -> bool:
    """Whether it acts at rest, where nothing else changes."""
    effect = source_of(owner, line.name).meant(line).effect
    return isinstance(effect, Noise | Offset | Disturbance)


@asking("simulate")
def simulated_recording(
    device: Device | File,
    *,
    static: str | float,
    rate: float | None = None,
    inputs: Inputs,
    asked: Asked,
) -> SimulatedRecording:
    """Make the recording at rest that a device would give in one turn-on.

    Parameters
    ----------
    device : str, Path or Device
    static : str or float
        How long it rests, as '2 h', or in seconds.
    rate : float, optional
        Of sampling [Hz]; the procedure's without it.

    Returns
    -------
    SimulatedRecording

    Raises
    ------
    SpecError
        What is wrong with a file.
    CallError
        It would have too few samples, or too many.
    """
    place = load_procedure(inputs.procedure)
    rate = place.sample_rate if rate is None else rate
    if not LEAST_RATE <= rate <= MOST_RATE:
        raise CallError(
            f"rate is {rate!r}, expected {LEAST_RATE:g} to {MOST_RATE:g} Hz, as 200"
        )
    duration = _duration(static)
    if not LEAST_SAMPLES <= duration * rate <= MOST_SAMPLES:
        raise CallError(
            f"static {static} at {rate:g} Hz is {duration * rate:.3g} samples, "
            f"expected {LEAST_SAMPLES} to {MOST_SAMPLES:.0e}; give another time or rate"
        )
    return SimulatedRecording(
        device=load_device(device),
        procedure=place,
        rate=rate,
        asked=round(duration * rate),
        seed=asked.seed,
    )


def _duration(static: str | float) -> float:
    """Read a time [s].

    Raises
    ------
    CallError
        It is none.
    """
    if not isinstance(static, str):
        return float(static)
    try:
        return parse_quantity(static, "s", bare="s").value
    except UnitError as error:
        raise CallError(f"static: {error}") from None
