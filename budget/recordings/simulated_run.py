"""A recorded calibration as a device and a table would give it, mistakes and all.

Windows are those of the simulation of a calibration (budget.calibration.simulation).
Between two of them the table stands, turns about one axis after the other, and stands
again; there it has no errors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import pi, radians, remainder
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mistakes import Mistake, mistakes_of, moved_to
from budget.calibration.schemes import is_beside, windows_of
from budget.calibration.schemes.covariance import Windows
from budget.calibration.simulation import (
    MOST_SAMPLES,
    SampledWindow,
    draw_source,
    reading_of,
    stream_of,
)
from budget.errors import CallError, UnitError
from budget.inputs import load_device
from budget.inputs.records import UNCALIBRATED
from budget.model.source import Disturbance, Samples, TableState
from budget.model.sources import source_of
from budget.model.windows import INNER, MIDDLE, OUTER, Schedule, Window
from budget.names import AXES
from budget.recordings.columns import LIKE
from budget.recordings.simulated import NUMBER, STAMP, SimulatedReadings
from budget.recordings.window_table import DURATION, WINDOW
from budget.settings import LEAST_RATE, MOST_RATE, Asked, Inputs, asking
from budget.units import parse_quantity, size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.calibration.simulation import DrawnSource, TurnOn
    from budget.inputs.files import File
    from budget.inputs.records import Device, ErrorLine, Procedure, Sensor
    from budget.model.place import Place
    from budget.model.scheme import Scheme
    from budget.model.windows import Setting

MOVE = radians(30.0)  # rate from one window to the next [rad/s]
STAND = 1.5  # at the least, before and after a move or a turn [s]
MOTION = "window_motion"
CUT = 0.5  # of a dwell that is read on into the motion after it, where none is said [s]
SIZED = {"latitude": "deg", "gravity": "m/s^2"}  # mistakes with a value
MOST_SHOWN = 12  # allowed words that are listed
MOST_SAMPLES_OF_RUN = 200_000_000


@dataclass(frozen=True, kw_only=True)
class PlantedMistake:
    """A mistake that is made in a simulated run.

    Attributes
    ----------
    said : str
        As it was asked for.
    mistakes : mapping of str to Mistake
        By triad.
    cut : (int, float), optional
        Place of a dwell that is read on into the motion after it, and for how long [s].
    """

    said: str
    mistakes: Mapping[str, Mistake]
    cut: tuple[int, float] | None = None


@dataclass(frozen=True, kw_only=True)
class RunStep:
    """A part of a run: a window, or a stand or a move between two.

    Attributes
    ----------
    window : Window
        With start and length as they are, from the start of the recording [s].
    place : int or None
        Of the window in the procedure; None of what is between.
    """

    window: Window
    place: int | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedRun(SimulatedReadings):
    """A recorded calibration that a device would give.

    Attributes
    ----------
    blunders : tuple of PlantedMistake
    is_table : bool
        Whether it is written as a table of means.
    """

    blunders: tuple[PlantedMistake, ...] = ()
    is_table: bool = False

    @cached_property
    def windows(self) -> tuple[Window, ...]:
        """The windows as they really are, in the order of the procedure."""
        found = list(windows_of(self.procedure))
        for blunder in self.blunders:
            (one, *_) = blunder.mistakes.values()
            if one.order:
                found = [
                    replace(
                        window,
                        setting=found[k].setting,
                        length=found[k].length,
                        axis=found[k].axis,
                        sign=found[k].sign,
                    )
                    for window, k in zip(found, one.order, strict=True)
                ]
            found = one.really(found)
        return tuple(found)

    @cached_property
    def place(self) -> Place:
        """Where it really is."""
        found = self.procedure.place
        for blunder in self.blunders:
            for one in blunder.mistakes.values():
                found = one.place or found
        return found

    @cached_property
    def steps(self) -> tuple[RunStep, ...]:
        """The run from begin to end, with what is between windows."""
        windows = self.windows
        found = [_stand(windows[0].setting, 0.0, STAND)]
        design = windows_of(self.procedure)
        for k, one in enumerate(windows):
            start = found[-1].window.end
            if k and is_beside(self.procedure):  # from dwell to move without a stand
                pause = design[k].start - design[k - 1].end
                if pause > 0.0:
                    stands = one.setting
                    found.append(_stand(stands, start, pause))
            elif k:
                pause = max(0.0, design[k].start - design[k - 1].end)
                found += _between(windows[k - 1], one, start, pause)
            start = found[-1].window.end
            found.append(RunStep(window=replace(one, start=start), place=k))
        last = windows[-1]
        stands = last.setting.after(last.setting.angle)
        found.append(_stand(stands, found[-1].window.end, STAND))
        return tuple(found)

    @cached_property
    def samples(self) -> int:
        """How many there are."""
        return sum(self._count(one) for one in self.steps)

    @property
    def duration(self) -> float:
        """From begin to end [s]."""
        return self.steps[-1].window.end

    def _count(self, step: RunStep) -> int:
        """Return how many samples a step has."""
        return max(1, round(step.window.length * self.rate))

    @cached_property
    def schedule(self) -> Schedule:
        """The windows on the clock of the recording."""
        there = [one.window for one in self.steps if one.place is not None]
        return Schedule(windows=tuple(there))

    def scheme_of(self, sensor: Sensor) -> Scheme:
        """Return all windows as those of a triad."""
        return Windows.of(sensor.kind, self.schedule, self.procedure)

    def acts(self, owner: str, line: ErrorLine) -> bool:
        """Whether a line acts: in a test all that varies does."""
        return source_of(owner, line.name).meant(line).varies

    def _shared(self, scheme: Scheme) -> list[DrawnSource]:
        """Draw what comes from table and environment, alike for all triads."""
        stream = partial(stream_of, self.seed, 0)
        return [
            draw_source(owner, line, scheme, self.rate, stream)
            for owner, lines in self.procedure.shared.items()
            for line in lines
            if line.u.any()
        ]

    def _triads(self) -> Iterator[_DrawnTriad]:
        """Yield the triads with what is drawn of each."""
        for sensor in self.device.sensors:
            scheme = self.scheme_of(sensor)
            lines = (*self.procedure.environment, *sensor.lines)
            yield _DrawnTriad(
                sensor=sensor,
                scheme=scheme,
                drawn=[*self._draw(sensor), *self._shared(scheme)],
                known={line.name: line for line in lines},
            )

    def _readings(self) -> Iterator[tuple[RunStep, Samples, list[Array]]]:
        """Yield step after step its samples and the readings of each triad, (3, n)."""
        triads, last = list(self._triads()), 0
        for step in self.steps:
            last = last if step.place is None else step.place
            n = self._count(step)
            dt = step.window.length / n
            at = Samples(n=n, dt=dt, first=step.window.start + dt / 2.0)
            found = []
            for one in triads:
                kind = one.sensor.kind
                readings = one.readings(step, at, self.turn_ons[kind], self.place, last)
                for blunder in self.blunders:
                    mistake = replace(blunder.mistakes[kind], order=())
                    readings = mistake.done(readings)
                found.append(readings)
            yield step, at, found

    def pieces(self) -> Iterator[Array]:
        """Yield stamps [s] and readings [rad/s, m/s^2], shape (n, 1 + columns)."""
        for _, at, found in self._readings():
            times = at.times - at.dt / 2.0
            yield np.concatenate([times[None], *found]).T

    def means(self) -> Iterator[tuple[Window, list[Array]]]:
        """Yield the windows of the procedure with the means of each triad, (3,)."""
        late = {one.cut[0]: one.cut[1] for one in self.blunders if one.cut}
        design = windows_of(self.procedure)
        waiting: list[tuple[int, Samples, list[Array]]] = []
        for step, at, found in self._readings():
            if waiting and (step.place is not None or step.window.sense):
                place, before, first = waiting.pop()
                n = min(max(1, round(late[place] / at.dt)), at.n, before.n - 1)
                yield (
                    design[place],
                    [
                        np.concatenate([a[:, : before.n - n], b[:, :n]], axis=1).mean(
                            axis=1
                        )
                        for a, b in zip(first, found, strict=True)
                    ],
                )
            if step.place is None:
                continue
            if step.place in late and step.place + 1 < len(design):
                waiting.append((step.place, at, found))
                continue
            yield design[step.place], [one.mean(axis=1) for one in found]

    def csv(self) -> Iterator[str]:
        """Yield its text as a file has it, heads first; of one seed the same bytes."""
        if not self.is_table:
            yield from super().csv()
            return
        heads = self.heads[1:]
        yield ",".join((WINDOW, f"{DURATION} [s]", *heads)) + "\n"
        kinds = [one.kind for one in self.device.sensors]
        for window, found in self.means():
            cells = [window.name.replace(",", ";"), STAMP % window.length]
            for kind, mean in zip(kinds, found, strict=True):
                is_used = window.use in {kind, "both"}
                values = mean / size_of(LIKE[kind])
                cells += [NUMBER % x if is_used else "" for x in values.tolist()]
            yield ",".join(cells) + "\n"


@dataclass(frozen=True, kw_only=True, eq=False)
class _DrawnTriad:
    """A triad in one run."""

    sensor: Sensor
    scheme: Scheme
    drawn: Sequence[DrawnSource]
    known: Mapping[str, ErrorLine]

    def readings(
        self, step: RunStep, at: Samples, tested: TurnOn, place: Place, last: int
    ) -> Array:
        """Return what it reads in a step, (3, n) [unit of the input].

        What is between windows is where the last of them was, on a table as it is.
        """
        window = step.window
        turning = window.setting.turning
        schedule = self.scheme.schedule
        is_window = step.place is not None
        table = TableState(
            turn=schedule.turns.get(last) if is_window else None,
            stop=schedule.stops[last],
            turning=None if turning is None else OUTER - turning,
            angle=window.setting.angle,
            length=window.length,
            place=place,
            timing=self.scheme.timing,
        )
        drawn = table
        for one in self.drawn:
            if isinstance(one.effect, Disturbance):
                drawn = one.effect.table(one.value, drawn)
        table = drawn if is_window else replace(table, place=drawn.place)
        where = SampledWindow(window=window, table=table, samples=at, known=self.known)
        found = reading_of(self.sensor, tested, self.drawn, where)
        K = (1.0 + tested.k)[:, None] * table.pace
        return np.asarray(np.broadcast_to(K * found, (len(AXES), at.n)))


def _stand(setting: Setting, start: float, length: float) -> RunStep:
    """Return a stand of the table."""
    at = replace(setting, turning=None, angle=0.0)
    return RunStep(window=Window(name="stand", start=start, length=length, setting=at))


def _between(
    before: Window, after: Window, start: float, pause: float
) -> list[RunStep]:
    """Return what is between two windows: stand, move, stand; a pause alone of none."""
    stands = before.setting.after(before.setting.angle)
    there = replace(after.setting, turning=None, angle=0.0)
    moves = [
        (axis, remainder(there.angles[k] - stands.angles[k], 2.0 * pi))
        for k, axis in enumerate((OUTER, MIDDLE, INNER))
    ]
    moves = [(axis, angle) for axis, angle in moves if abs(angle) > 1e-9]  # noqa: PLR2004
    if not moves and not (before.sense or after.sense):
        return [_stand(stands, start, pause)] if pause > 0.0 else []
    found = [_stand(stands, start, STAND)]
    for axis, angle in moves:
        moving = replace(stands, turning=axis, angle=angle)
        begin = found[-1].window.end
        length = abs(angle) / MOVE
        found.append(
            RunStep(
                window=Window(name="move", start=begin, length=length, setting=moving)
            )
        )
        stands = moving.after(angle)
    spent = found[-1].window.end - start
    rest = max(STAND, pause - spent)
    return [*found, _stand(there, found[-1].window.end, rest)]


@asking("simulate")
def simulated_run(
    device: Device | File,
    *,
    means: bool = False,
    rate: float | None = None,
    blunders: Sequence[str] = (),
    inputs: Inputs,
    asked: Asked,
) -> SimulatedRun:
    """Make the recording of a calibration that a device would give in one turn-on.

    Parameters
    ----------
    device : str, Path or Device
    means : bool
        Whether it is a table with the means of windows, and no recording.
    rate : float, optional
        Of sampling [Hz]; the procedure's without it.
    blunders : sequence of str
        Mistakes that are made, NAME or NAME=WHAT: 'earth_rate_sign', 'latitude=39.9',
        'window_face=7:x up'.

    Returns
    -------
    SimulatedRun

    Raises
    ------
    SpecError
        What is wrong with a file.
    CallError
        It is no test, or would have too many samples; a mistake is none.
    """
    how = inputs.calibrated()
    if how.formulas in UNCALIBRATED:
        raise CallError(f"{how.name} is no test that could be recorded")
    rate = how.sample_rate if rate is None else rate
    if not LEAST_RATE <= rate <= MOST_RATE:
        raise CallError(
            f"rate is {rate!r}, expected {LEAST_RATE:g} to {MOST_RATE:g} Hz, as 200"
        )
    unit = load_device(device)
    made = SimulatedRun(
        device=unit,
        procedure=how,
        rate=rate,
        seed=asked.seed,
        blunders=tuple(_blunder(one, unit, how, rate) for one in blunders),
        is_table=means,
    )
    longest = max(one.length for one in made.windows) * rate
    if longest > MOST_SAMPLES or made.samples > MOST_SAMPLES_OF_RUN:
        raise CallError(
            f"{how.name} at {rate:g} Hz is {made.samples:.3g} samples, {longest:.3g} "
            f"in one window, expected {MOST_SAMPLES_OF_RUN:.0e} and "
            f"{MOST_SAMPLES:.0e} at the most; give a lower rate"
        )
    return made


def _blunder(said: str, unit: Device, how: Procedure, rate: float) -> PlantedMistake:
    """Read a mistake that is to be made.

    Raises
    ------
    CallError
        It is none of this procedure.
    """
    name, _, what = (part.strip() for part in said.partition("="))
    windows, place = windows_of(how), how.place
    if name == MOTION:
        return _motion(said, what, unit, windows)
    numbers = range(1, len(windows) + 1)
    by_kind = {
        one.kind: [*mistakes_of(one.kind, windows, numbers, place, rate)]
        for one in unit.sensors
    }
    if name in SIZED:
        mistake = _sized(name, what, place)
        return PlantedMistake(said=said, mistakes=dict.fromkeys(by_kind, mistake))
    known = [one for own in by_kind.values() for one in own if one.name == name]
    if not known:
        names = {one.name for own in by_kind.values() for one in own}
        allowed = ", ".join(sorted(names | {MOTION, *SIZED}))
        raise CallError(f"blunder {name!r} is none, allowed: {allowed}")
    chosen = known[0] if not what else None
    for one in known:
        if what and _said(one) == " ".join(what.casefold().split()):
            chosen = one
            break
    if chosen is None or (not what and dict(known[0].what).keys() - {"factor"}):
        texts = [*dict.fromkeys(_said(one) for one in known)]
        more = "" if len(texts) <= MOST_SHOWN else f", ... ({len(texts)} in all)"
        raise CallError(
            f"blunder {said!r}: which? Allowed behind {name}=: "
            f"{', '.join(texts[:MOST_SHOWN])}{more}"
        )
    nothing = Mistake(name=name)
    is_of_readings = bool(chosen.mix) or chosen.factor != 1.0
    return PlantedMistake(
        said=said,
        mistakes={
            kind: chosen if not is_of_readings or chosen in own else nothing
            for kind, own in by_kind.items()
        },
    )


def _said(mistake: Mistake) -> str:
    """Return which one it is as it is typed: '7:x up', 'xy', '7,8'."""
    parts = []
    for _, value in mistake.what:
        if isinstance(value, tuple):
            parts.append(",".join(map(str, value)))
        else:
            parts.append(f"{value:g}" if isinstance(value, float) else str(value))
    return ":".join(parts)


def _sized(name: str, what: str, place: Place) -> Mistake:
    """Return a latitude or a gravity that it really was at.

    Raises
    ------
    CallError
        The value is none.
    """
    try:
        value = parse_quantity(what, SIZED[name], bare=SIZED[name]).value
    except UnitError as error:
        raise CallError(f"blunder {name}={what}: {error}") from None
    if name == "gravity":
        return Mistake(name=name, place=replace(place, gravity=value, is_normal=False))
    if abs(value) > pi / 2.0:
        raise CallError(f"blunder {name}={what}: expected -90 to 90 deg")
    return Mistake(name=name, place=moved_to(place, value))


def _motion(
    said: str, what: str, unit: Device, windows: Sequence[Window]
) -> PlantedMistake:
    """Return a dwell that is read on into the motion after it.

    Raises
    ------
    CallError
        There is no such dwell, or no such time.
    """
    number, _, time = what.partition(":")
    dwells = [
        str(k + 1)
        for k, one in enumerate(windows[:-1])
        if not one.sense and windows[k + 1].setting != one.setting
    ]
    if number.strip() not in dwells:
        raise CallError(
            f"blunder {said!r}: which? Allowed behind {MOTION}= is the number of a "
            f"dwell that is left by a move, {', '.join(dwells) or 'and there is none'}"
            ", with a time, as 3:0.5 s"
        )
    try:
        cut = parse_quantity(time, "s", bare="s").value if time.strip() else CUT
    except UnitError as error:
        raise CallError(f"blunder {said}: {error}") from None
    place = int(number) - 1
    if not 0.0 < cut < windows[place].length:
        raise CallError(
            f"blunder {said!r}: expected a time below {windows[place].length:g} s"
        )
    nothing = Mistake(name=MOTION)
    return PlantedMistake(
        said=said,
        mistakes={one.kind: nothing for one in unit.sensors},
        cut=(place, cut),
    )
