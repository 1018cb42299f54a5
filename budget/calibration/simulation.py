"""Simulation of the calibration pulse by pulse, as in the paper: checks the methods.

Every sample of every window is made: the turning table and earth, the constants of the
run, each noise process in time; the pulses are counted (Zhao 2019, eqs. (1), (2)) and
go through the scheme's weights. Of the closed forms for window averages nothing is used
here, so agreement with them is evidence for both. What sources there are stands in the
one table of budget.model.sources.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache, partial
from hashlib import sha256
from math import cos, sin
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.schemes import (
    initial_lines,
    schemes_of,
    with_accelerometers,
)
from budget.distributions import LEAST
from budget.errors import CallError
from budget.model.rotation import RotationScheme
from budget.model.source import (
    TURN_ON,
    Disturbance,
    Initial,
    Noise,
    Nonlinearity,
    Offset,
    Samples,
    SimulatedWindow,
    TableState,
    TurnOnChange,
)
from budget.model.sources import source_of
from budget.model.windows import OUTER
from budget.names import Name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.records import ErrorLine, Procedure, Sensor
    from budget.model.response import CalibratedTriad
    from budget.model.scheme import Scheme
    from budget.model.source import Effect, Given
    from budget.model.windows import Window

# Of one window, three axes and a few arrays of that length: some 0.2 GB.
MOST_SAMPLES = 2_000_000
KEPT_SAMPLES = 10_000  # of a turn whose inputs are kept for the next run


@dataclass(frozen=True, kw_only=True, eq=False)
class TurnOn:
    """The values that the constants of one triad have during one turn-on."""

    k: Array  # K = K0 (1 + k), shape (3,) [1]
    angle: Array  # shape (6,) [rad]
    bias: Array  # shape (3,) [SI]


@dataclass(frozen=True, kw_only=True, eq=False)
class DrawnSource:
    """A source in one run: what it is, its value, its samples."""

    given: Given
    effect: Effect
    value: Array  # of a constant [SI]
    later: Array  # its value at a later turn-on [SI]
    samples: Callable[[Samples], Array] | None  # of a process


def simulate(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    run: int,
    seed: int = 0,
    reference: str = "nominal",
    only: frozenset[str] | None = None,
    every: bool = False,
) -> Array:
    """Simulate one run of the whole calibration.

    Parameters
    ----------
    sensors : tuple of Sensor
        At most one gyro and one accelerometer.
    procedure : Procedure
        Windows, the place, the formulas, station and environment.
    run, seed : int
        Which random numbers; each source has a stream of its own.
    reference : str
        What errors are counted from: 'nominal', 'as_tested', 'next_turn_on'.
    only : frozenset of str, optional
        Full names of the sources that count; all others are left out.
    every : bool
        Whether parameters that are held are outputs too, as of `calibration_problem`.

    Returns
    -------
    ndarray, shape (n_outputs,)
        Errors of scale factors (relative), mounting angles and biases, triad by triad
        [1, rad, rad/s or m/s^2].

    Raises
    ------
    CallError
        A window holds too many samples to be made one by one.
    """
    there = with_accelerometers(sensors, procedure)
    schemes = schemes_of(there, procedure, every=every)
    for kind, scheme in schemes.items():
        _check_samples(kind, scheme, procedure.sample_rate)

    # Of what both triads share the first that is tested tells how often it is drawn, as
    # it does for the law: in the paper's test accelerometers are not turned.
    tested = min(schemes.values(), key=lambda one: not one.schedule.windows)

    def draw(owner: str, lines: tuple[ErrorLine, ...]) -> list[DrawnSource]:
        return [
            draw_source(
                owner,
                line,
                schemes.get(owner) or tested,
                procedure.sample_rate,
                partial(stream_of, seed, run),
            )
            for line in lines
            if only is None or Name(line.name, owner=owner) in only
        ]

    def draw_own(sensor: Sensor) -> list[DrawnSource]:
        made = initial_lines(sensor, procedure) if every else ()
        return draw(sensor.kind, (*sensor.lines, *made))

    shared = [
        one for owner, lines in procedure.shared.items() for one in draw(owner, lines)
    ]
    errors: list[Array] = []
    shown = None
    for sensor in reversed(there):  # a gyro may be found by the accelerometers
        found, shown = _simulate_triad(
            sensor,
            schemes[sensor.kind],
            [*draw_own(sensor), *shared],
            {line.name: line for line in (*procedure.environment, *sensor.lines)},
            sample_rate=procedure.sample_rate,
            reference=reference,
            beside=shown,
            every=every,
        )
        if sensor in sensors:
            errors.insert(0, found)
    return np.concatenate(errors)


def _check_samples(kind: str, scheme: Scheme, sample_rate: float) -> None:
    """Refuse windows that would fill the memory."""
    samples = scheme.schedule.lengths.max(initial=0.0) * sample_rate
    if samples > MOST_SAMPLES:
        raise CallError(
            f"a window of the {kind} procedure has {samples:.3g} samples "
            f"at {sample_rate:g} Hz; the simulation computes them one by "
            f"one, {MOST_SAMPLES:.0e} at the most. Lower the sample rate or "
            "shorten the window, or use another method, for which length is free"
        )


def draw_source(
    owner: str,
    line: ErrorLine,
    scheme: Scheme | None,
    sample_rate: float,
    rng_of: Callable[[str], np.random.Generator],
) -> DrawnSource:
    """Draw what a source is in this run; any scheme tells how many turns there are.

    Without one nothing is calibrated: what a new unit has counts in full.
    """
    held: Callable[[str], Any] = scheme.held_of if scheme else lambda _: 1.0
    source = source_of(owner, line.name).meant(line)
    effect, name = source.effect, Name(line.name, owner=owner)
    rng = rng_of(name)
    value = later = np.zeros_like(line.u)
    samples = None
    if isinstance(effect, Noise):
        samples = effect.sampler(line, rng, sample_rate)
    elif isinstance(effect, Disturbance):
        drawn = effect.draw(line, rng)
        times = effect.size(line, scheme) // line.u.size
        value = _values(line, rng, times) if drawn is None else drawn
    elif isinstance(effect, Offset | TurnOnChange):
        value = later = _values(line, rng)
        if isinstance(effect, Initial):
            value = later = value * held(effect.target)
        if isinstance(effect, Nonlinearity):  # in use it is away from what was tested
            later = value * held(effect.target)
        if source.stays == TURN_ON:
            later = _values(line, rng_of(f"{name}, later"))
    return DrawnSource(
        given=line, effect=effect, value=value, later=later, samples=samples
    )


def _values(line: ErrorLine, rng: np.random.Generator, times: int = 1) -> Array:
    """Draw random constants, shape (n,) [SI]."""
    u, shapes = np.tile(line.u, times), line.distributions * times
    p = rng.uniform(LEAST, 1.0, u.size)
    z = [shape.quantile(p[i : i + 1])[0] for i, shape in enumerate(shapes)]
    return np.asarray(u * z)


def _simulate_triad(
    sensor: Sensor,
    scheme: Scheme,
    drawn: list[DrawnSource],
    known: Mapping[str, Given],
    *,
    sample_rate: float,
    reference: str,
    beside: Array | None,
    every: bool,
) -> tuple[Array, Array]:
    """Simulate one triad, a gyro beside what the accelerometers show.

    Returns errors, shape (n_outputs,): 12 less those held, unless `every` counts; and
    what the calibrated triad shows in its windows, shape (3, n) [unit of the input].
    """
    tested = turn_on_of(sensor, drawn, known)
    true = {
        "nominal": turn_on_of(sensor, [], known),
        "as_tested": tested,
        "next_turn_on": turn_on_of(sensor, drawn, known, is_later=True),
    }[reference]
    found, shown = _calibrate(
        sensor, scheme, tested, drawn, known, sample_rate=sample_rate, beside=beside
    )
    calibrated = found.vector[:12]
    design = turn_on_of(sensor, [], known)
    if scheme.held is not None:
        nominal = np.concatenate([1.0 + design.k, design.angle, design.bias])
        calibrated[scheme.held.held] = nominal[scheme.held.held]
    errors = calibrated - np.concatenate([1.0 + true.k, true.angle, true.bias])
    errors[:3] /= 1.0 + true.k
    if scheme.held is not None and not every:
        errors = errors[scheme.held.estimated]
    if found.higher is None or not scheme.orders:
        return errors, shown
    true_higher = np.zeros_like(found.higher)
    for one in drawn:
        order = one.effect.order if isinstance(one.effect, Disturbance) else 0
        if order in scheme.orders and reference != "nominal":
            place = 3 * scheme.orders.index(order)
            true_higher[place : place + 3] += one.value
    return np.concatenate([errors, found.higher - true_higher]), shown


def turn_on_of(
    sensor: Sensor,
    drawn: list[DrawnSource],
    known: Mapping[str, Given],
    *,
    is_later: bool = False,
) -> TurnOn:
    """Add offsets and changes to the nominal values."""
    truth = {
        "scale_factor": np.zeros(3),  # eq. (14)
        "mounting_angle": sensor.nominal_mounting_angle.copy(),
        "bias": sensor.nominal_bias.copy(),
    }
    for one in drawn:
        value = one.later if is_later else one.value
        if isinstance(one.effect, Offset):
            truth[one.effect.target] += value
        elif isinstance(one.effect, TurnOnChange):
            for target, gains in one.effect.gains(known).items():
                truth[target] += gains[is_later] @ value
    return TurnOn(
        k=truth["scale_factor"], angle=truth["mounting_angle"], bias=truth["bias"]
    )


@dataclass(frozen=True, kw_only=True)
class SampledWindow:
    """Samples of one window, the table as it really stands, what the files give."""

    window: Window
    table: TableState
    samples: Samples
    known: Mapping[str, Given]


def _calibrate(
    sensor: Sensor,
    scheme: Scheme,
    tested: TurnOn,
    drawn: list[DrawnSource],
    known: Mapping[str, Given],
    *,
    sample_rate: float,
    beside: Array | None,
) -> tuple[CalibratedTriad, Array]:
    """Run the windows in the order of time, and calibrate from the pulses.

    What the triad then shows in its windows too, (3, n); `beside`: the other triad.
    """
    rates = []
    for place, window in enumerate(scheme.schedule.windows):
        n = max(1, round(window.length * sample_rate))
        dt = window.length / n
        at = Samples(n=n, dt=dt, first=window.start + dt / 2.0)
        table = _table_of(scheme, place, drawn)
        where = SampledWindow(window=window, table=table, samples=at, known=known)
        rates.append(_count(sensor, tested, drawn, where))
    readings = np.array(rates).reshape(-1, 3).T
    if isinstance(scheme, RotationScheme) and beside is not None:
        found = scheme.estimate_beside(readings, beside)
    else:
        found = scheme.estimate(readings)
    inputs = readings / found.scale_factor[:, None] - found.bias[:, None]
    return found, np.asarray(np.linalg.solve(_response(found.mounting_angle), inputs))


def _response(angle: Array) -> Array:
    """Return M = I + dT of eq. (1), shape (3, 3), of angles in the order of ANGLES."""
    xy, xz, yx, yz, zx, zy = angle
    return np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])


def _table_of(scheme: Scheme, place: int, drawn: list[DrawnSource]) -> TableState:
    """Return how the table really stands in a window."""
    setting = scheme.schedule.windows[place].setting
    table = TableState(
        turn=scheme.schedule.turns.get(place),
        stop=scheme.schedule.stops[place],
        turning=None if setting.turning is None else OUTER - setting.turning,
        angle=setting.angle,
        length=scheme.schedule.windows[place].length,
        place=scheme.place,
        timing=scheme.timing,
    )
    for one in drawn:
        if isinstance(one.effect, Disturbance):
            table = one.effect.table(one.value, table)
    return table


def _count(
    sensor: Sensor,
    tested: TurnOn,
    drawn: Sequence[DrawnSource],
    where: SampledWindow,
) -> Array:
    """Return pulses over the length of a window by the clock, (3,): eq. (2), K0 = 1."""
    reading = reading_of(sensor, tested, drawn, where)
    pace, length = where.table.pace, where.window.length
    K = 1.0 + tested.k
    if reading.shape[1] == 1:  # nothing varies within the window
        return np.asarray(K * reading[:, 0] * length * pace / length)
    return np.asarray(K * reading.sum(axis=1) * where.samples.dt * pace / length)


def reading_of(
    sensor: Sensor,
    tested: TurnOn,
    drawn: Sequence[DrawnSource],
    where: SampledWindow,
) -> Array:
    """Return the readings of samples over the scale factor, (3, n) or (3, 1): eq. (1).

    A process goes on from where the window before left it.
    """
    window, at = where.window, where.samples
    rate, force = _inputs(window, where.table, at)
    M = _response(tested.angle)
    true_input = M @ (rate if sensor.kind == "gyro" else force) + tested.bias[:, None]
    reading = true_input
    for one in drawn:
        if one.samples is not None:
            reading = reading + one.samples(at)
    moment = partial(
        SimulatedWindow,
        owner=sensor.kind,
        window=window,
        samples=at,
        force=force,
        true_input=true_input,
        reading=reading,
        known=where.known,
    )
    for one in drawn:
        if isinstance(one.effect, Disturbance):
            reading = reading + one.effect.reading(one.value, moment(given=one.given))
    return np.asarray(reading)


@dataclass(frozen=True, kw_only=True)
class _Inputs:
    """What inputs of samples are computed of: equal where these are equal."""

    window: Window
    at: Samples
    content: tuple[object, ...]  # of the table, all that counts
    table: TableState = field(compare=False)


def _inputs(window: Window, table: TableState, at: Samples) -> tuple[Array, Array]:
    """Return body rate and specific force of the samples, each (3, n) or (3, 1).

    At a table that is as it should be they are the same in every run, and kept.
    """
    place = table.place.earth.tobytes(), table.place.force.tobytes()
    numbers = table.angle, table.length, table.pace, table.joints.tobytes()
    of = _Inputs(window=window, at=at, content=(*place, *numbers), table=table)
    is_small = window.setting.turning is None or at.n <= KEPT_SAMPLES
    return (_inputs_of if is_small else _inputs_of.__wrapped__)(of)


@lru_cache(maxsize=256)
def _inputs_of(what: _Inputs) -> tuple[Array, Array]:
    """Return body rate and specific force of the samples, for reading alone.

    The table's axes are turned back one after the other, the outer first; the one that
    turns by the angle that it has reached in the middle of each sample. What is askew
    at a joint is turned back by its matrix, base and mount at the ends of the chain.
    """
    window, table, at = what.window, what.table, what.at
    setting = window.setting
    base, *joints = (joint.T for joint in table.joints)
    is_askew = (table.joints[1:] != np.eye(3)).any(axis=(1, 2)).tolist()
    there = (table.place.earth, table.place.force)
    fixed = np.stack([base @ each[:, None] for each in there])  # (2, 3, 1 or n)
    dt = at.dt * table.pace
    turn_rate = table.angle / (window.length * table.pace)
    turn: Array | None = None
    for axis, start, joint, askew in zip(
        (2, 1, 0), setting.angles, joints, is_askew, strict=True
    ):
        angle = np.array([start])
        if axis == setting.turning:
            angle = start + turn_rate * dt * (np.arange(at.n, dtype=float) + 0.5)
            turn = turn_rate * np.eye(3)[:, [axis]]
        elif turn is not None:
            turn = _turned_back(turn, axis, angle)
        fixed = _turned_back(fixed, axis, angle)
        if askew:
            turn = None if turn is None else joint @ turn
            fixed = np.stack([joint @ each for each in fixed])
    earth, gravity = fixed
    rate = earth if turn is None else earth + turn
    rate.flags.writeable = gravity.flags.writeable = False
    return rate, gravity


def _turned_back(vectors: Array, axis: int, angle: Array) -> Array:
    """Return fixed vectors in a frame turned about a coordinate axis, (..., 3, n)."""
    one = float(angle[0])
    c, s = (np.cos(angle), np.sin(angle)) if angle.size > 1 else (cos(one), sin(one))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    n = max(vectors.shape[-1], angle.size)
    y, z = vectors[..., j, :], vectors[..., k, :]
    turned = np.empty((*vectors.shape[:-1], n))
    turned[..., axis, :] = vectors[..., axis, :]
    turned[..., j, :] = c * y + s * z
    turned[..., k, :] = c * z - s * y
    return turned


def stream_of(seed: int, run: int, name: str) -> np.random.Generator:
    """Return the random stream of one source in one run."""
    key = int.from_bytes(sha256(name.encode()).digest()[8:16], "big")
    return np.random.Generator(
        np.random.SFC64(np.random.SeedSequence(seed, spawn_key=(key, run)))
    )
