"""Expected lines that a data sheet does not give, and what stands in their place.

Nothing (refuse), which a verdict `meets` cannot do with; the worst or the typical of
comparable devices, which have the same sensor, technology and grade; or a random
quantity whose distribution is predicted (budget.missing.prediction).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.documents import Documented, written
from budget.errors import CallError
from budget.inputs import load_catalogue
from budget.inputs.records import ErrorLine
from budget.inputs.specification import ALLAN_MINIMUM, CORRELATION_TIME
from budget.missing.grades import UNKNOWN, family, grade
from budget.missing.prediction import joined, predict, stand_in
from budget.model.sources import ACCELEROMETER, FLICKER, GYRO, LOW_CUT
from budget.model.sources.later import AGEING
from budget.names import Name
from budget.results import FilledLine
from budget.sentences import sentence
from budget.ties import first_largest, settle
from budget.units import (
    ONE_SIDED,
    WALK_PER_DENSITY,
    YEAR,
    parse_quantity,
    per_root_hertz,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device, Sensor
    from budget.missing.prediction import Prediction
    from budget.model.source import Source

REFUSE, WORST, TYPICAL, PREDICT = MODES = ("refuse", "worst", "typical", "predict")


@written(
    "filling",
    """
    mode
    filled = lines
    left
    """,
)
@dataclass(frozen=True, kw_only=True)
class Filling(Documented):
    """What stands in the place of the lines that a device does not give."""

    mode: str = REFUSE
    lines: tuple[FilledLine, ...] = ()
    left: tuple[Name, ...] = ()  # expected lines that nothing stands for
    prediction: Prediction | None = None  # of the lines, jointly, by 'predict'

    def of(self, names: Sequence[Name]) -> Filling:
        """Return what is said of some of the expected lines."""
        prediction = self.prediction
        if prediction is not None:
            kept = [name for name in prediction.names if name in names]
            prediction = prediction.of(kept) if kept else None
        return Filling(
            mode=self.mode,
            lines=tuple(line for line in self.lines if line.expected in names),
            left=tuple(name for name in self.left if name in names),
            prediction=prediction,
        )

    def and_of(self, other: Filling) -> Filling:
        """Return this one and that of another device, independent of it."""
        both = [one for one in (self.prediction, other.prediction) if one is not None]
        return Filling(
            mode=other.mode,
            lines=(*self.lines, *other.lines),
            left=(*self.left, *other.left),
            prediction=joined(both) if both else None,
        )


def check_mode(mode: str) -> None:
    """Refuse a word that names no mode.

    Raises
    ------
    CallError
    """
    if mode not in MODES:
        raise CallError(f"missing is {mode!r}, allowed: {', '.join(MODES)}")


@cache
def shipped_devices() -> tuple[Device, ...]:
    """Load the catalogue once: fits on it are kept by what they are of."""
    return load_catalogue()


def fill(
    device: Device, mode: str, catalogue: Sequence[Device] | None = None
) -> tuple[Device, Filling]:
    """Put lines in the place of the expected ones that a device does not give.

    A sensor of which no error line is given stays as it is: nothing is known of it.

    Parameters
    ----------
    device : Device
    mode : str
        One of MODES; by 'predict' the medians are put there, and the filling has the
        distribution.
    catalogue : sequence of Device, optional
        Where comparable devices are looked for; without it those that ship.

    Returns
    -------
    Device
        With the lines, and an assumption for each.
    Filling
    """
    check_mode(mode)
    if mode == REFUSE:
        return device, Filling()
    sensors = {sensor.kind: sensor for sensor in device.sensors if sensor.lines}
    missing = [name for one in sensors.values() for name in one.expected_missing]
    found: dict[Name, tuple[ErrorLine, FilledLine]] = {}
    if catalogue is None:
        catalogue = shipped_devices() if missing else ()
    prediction = predict(device, missing, catalogue) if mode == PREDICT else None
    if prediction is not None:
        found = _predicted(prediction)
    elif mode in {WORST, TYPICAL}:
        take = _worst if mode == WORST else _typical
        for name in missing:
            offers = comparable(name, device, sensors[name.owner], catalogue)
            if offers:
                found[name] = take(name, offers)
    found = {
        # A reader of the line must see that no maker of this device prints it.
        name: (replace(line, condition=told.words, source=""), told)
        for name, (line, told) in found.items()
    }
    filling = Filling(
        mode=mode,
        lines=tuple(told for _, told in found.values()),
        left=tuple(name for name in missing if name not in found),
        prediction=prediction,
    )
    if not found:
        return device, filling
    whole = {
        kind: _completed(sensor, {name: line for name, (line, _) in found.items()})
        for kind, sensor in sensors.items()
    }
    completed = replace(
        device,
        gyro=whole.get(GYRO, device.gyro),
        accelerometer=whole.get(ACCELEROMETER, device.accelerometer),
        assumptions=(
            *device.assumptions,
            *(
                sentence("assumed.of", key=told.expected, text=told.words)
                for _, told in found.values()
            ),
        ),
    )
    return completed, filling


def fill_all(
    devices: Sequence[Device], mode: str, catalogue: Sequence[Device] | None = None
) -> tuple[tuple[Device, ...], Filling]:
    """Fill devices that make one unit; arguments as of `fill`."""
    if len(devices) == 1:
        device, filling = fill(devices[0], mode, catalogue)
        return (device,), filling
    completed, whole = [], Filling(mode=mode)
    for device in devices:
        one, filling = fill(device, mode, catalogue)
        completed.append(one)
        whole = whole.and_of(filling)
    return tuple(completed), whole


def comparable(
    name: Name, device: Device, sensor: Sensor, catalogue: Sequence[Device]
) -> list[tuple[ErrorLine, Device]]:
    """Return a line of comparable devices of the catalogue, and whose each is.

    Of the same family of technology and the same grade, as a ring laser must not get
    the value of an automotive chip; none where nobody can tell the grade. 'gyro.noise'
    stands for the first of the noise lines, a random walk.
    """
    wanted = stand_in(name).name
    own_family, own_grade = family(device.technology), grade(sensor)
    if not own_family or own_grade == UNKNOWN:
        return []
    return [
        (line, owner)
        for owner in catalogue
        for other in owner.sensors
        if other.kind == sensor.kind and owner.as_printed != device.as_printed
        if own_grade == grade(other) and own_family == family(owner.technology)
        if (line := other.line(wanted)) is not None
    ]


@cache
def usual_line(name: Name) -> ErrorLine:
    """Return what stands for an expected line, of 1 in its most usual unit."""
    return line_of(stand_in(name), name.owner)


def line_of(
    source: Source, kind: str, u: float | None = None, *, meaning: str = "1 sigma"
) -> ErrorLine:
    """Return a normal line of a size [SI], without one of 1 in its most usual unit.

    A bias stability of a size B is what data sheets print: the floor 0.664 B of an
    Allan curve without a correlation time, which is flicker noise. Without a size it is
    the process of a plain value: a probe reaches the same outputs by either.
    """
    unit, density, one = _printed_in(source.like(kind))
    is_floor = u is not None and FLICKER in source.forms
    reading = 1.0 / ALLAN_MINIMUM if is_floor else 1.0
    one *= reading
    size = one if u is None else u
    axes = len(source.axes)
    is_timed = source.process and not is_floor
    line = ErrorLine(
        name=source.name,
        u=np.full(axes, size),
        distributions=(NORMAL,) * axes,
        own={key.name: key.usual for key in source.keys},
        correlation_time=np.full(axes, CORRELATION_TIME) if is_timed else None,
        horizons=((YEAR, 1.0),) if source.name in AGEING.values() else (),
        printed=f"{float(f'{size / one:.3g}'):g} {unit}",
        unit=unit,
        si_per_unit=one,
        density=density,
        factor=reading,
        reading=reading,
        meaning=meaning,
    )
    if not is_floor:
        return line
    return replace(
        line,
        form=FLICKER,
        low_cut=np.full(axes, LOW_CUT),
        says=(("definition", "allan_minimum"),),
        definition="allan_minimum",
    )


@cache
def _printed_in(unit: str) -> tuple[str, str, float]:
    """Return a unit, the density that it is of, and the size of 1 of it [SI].

    A size per root of hertz is printed as makers do, as a one-sided density.
    """
    density = ONE_SIDED if per_root_hertz(unit) else ""
    size = parse_quantity(f"1 {unit}", unit).value * WALK_PER_DENSITY[density]
    return unit, density, size


def _worst(
    name: Name, offers: Sequence[tuple[ErrorLine, Device]]
) -> tuple[ErrorLine, FilledLine]:
    """Return the largest of the lines, and whose it is.

    A Gauss-Markov process of one maker is flicker noise of the same size: its
    correlation time is not that of another unit.
    """
    line, owner = offers[first_largest([line.largest for line, _ in offers])]
    source = stand_in(name)
    if FLICKER in source.forms and line.form != FLICKER:
        worst = line_of(source, name.owner, line.largest, meaning=line.meaning)
        line = replace(worst, u=line.u, source=line.source)
    owners = (owner.name,)
    return line, _told(name, line, mode=WORST, owners=owners, number=len(offers))


def _typical(
    name: Name, offers: Sequence[tuple[ErrorLine, Device]]
) -> tuple[ErrorLine, FilledLine]:
    """Return the median over designs of the lines, of each that of its variants.

    A file is one design: its variants are no independent witnesses. Of two in the
    middle the median is the geometric mean.
    """
    logs: dict[str, list[float]] = {}
    for line, owner in offers:
        design = owner.origin.sha256 or owner.name
        logs.setdefault(design, []).append(settle(float(np.log(line.largest))))
    middle = float(np.exp(np.median([np.median(own) for own in logs.values()])))
    line = line_of(stand_in(name), name.owner, middle, meaning="median")
    owners = tuple(dict.fromkeys(owner.name for _, owner in offers))
    told = _told(name, line, mode=TYPICAL, owners=owners, number=len(offers))
    return line, replace(told, designs=len(logs))


def _predicted(prediction: Prediction) -> dict[Name, tuple[ErrorLine, FilledLine]]:
    """Return lines at the medians of a prediction."""
    found = {}
    half, most = prediction.interval(0.5), prediction.interval(0.9)
    for place, name in enumerate(prediction.names):
        u = float(prediction.median[place])
        line = line_of(stand_in(name), name.owner, u, meaning="predicted")
        told = replace(
            _told(
                name,
                line,
                mode=PREDICT,
                owners=prediction.devices[place],
                number=len(prediction.devices[place]),
            ),
            designs=prediction.designs[place],
            interval_50=(float(half[place, 0]), float(half[place, 1])),
            interval_90=(float(most[place, 0]), float(most[place, 1])),
        )
        found[name] = line, told
    return found


def _told(
    name: Name, line: ErrorLine, *, mode: str, owners: tuple[str, ...], number: int
) -> FilledLine:
    """Return what results say of a line."""
    return FilledLine(
        source=Name(line.name, owner=name.owner),
        expected=name,
        mode=mode,
        printed=line.printed,
        u=line.largest,
        unit=line.unit,
        si_per_unit=line.si_per_unit,
        owners=owners,
        devices=number,
    )


def _completed(sensor: Sensor, lines: dict[Name, ErrorLine]) -> Sensor:
    """Put lines into a sensor, in the order of the model lines."""
    own = {name: line for name, line in lines.items() if name.owner == sensor.kind}
    return replace(
        sensor.with_lines((*sensor.lines, *own.values())),
        expected_missing=tuple(n for n in sensor.expected_missing if n not in own),
    )
