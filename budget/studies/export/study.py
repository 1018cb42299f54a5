"""Export of devices to one target: values in its terms, and what it cannot express."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from budget import views
from budget.documents import written
from budget.errors import CallError
from budget.inputs import load_devices
from budget.missing import fill_all
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS
from budget.names import Name
from budget.question import sensors_of, with_results
from budget.results import Study, input_files
from budget.settings import LEAST_RATE, MOST_RATE, Asked, Inputs, asking
from budget.studies.analysis import analyze
from budget.studies.export.figures import Figure, KnownFigures, print_number
from budget.studies.export.template import fill_in, find_target
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import Device, Procedure, Sensor
    from budget.results import Budget
    from budget.studies.export.template import Exported, Target

# What a calibration finds, of the figures that targets hold.
CALIBRATED = {"bias", "total_bias", "scale_factor", "mounting_angle"}
REFERENCE = "next_turn_on"  # what a calibration leaves is met at a later turn-on
LEAST_INFLATION, MOST_INFLATION = 1.0, 1e6  # [1]


@written(
    "export",
    """
    title: names of the devices
    inputs by role as file
    settings = self as export_settings
    entries = rows as exported (list[tuple]): by key and axis
    left_out: keys whose figure is not known, and what they are without it
    not_held: lines of the data sheet that the target has no place for
    notes
    sources = target.sources (tuple[str, ...]): where keys and units were read
    assumptions
    warnings
    """,
    commands="export",
)
@written(
    "export_settings",
    """
    target = target.name (str)
    rate [Hz]: of the readings; null where the target asks for none
    inflate [1]: on every standard deviation and density
    missing: what stands for expected lines that are not given
    residual = procedure (bool): whether it is what a calibration leaves
    reference (str | None): what an error is one against, of what a calibration leaves
    """,
    reference=lambda found: REFERENCE if found.procedure else None,
)
@dataclass(frozen=True, kw_only=True, repr=False)
class Export(Study):
    """Everything that goes into the file of a target.

    Attributes
    ----------
    left_out : tuple of str
        Keys whose figure is not known, and what they are without it.
    not_held : tuple of str
        Lines of the data sheet that the target has no place for.
    body : str
        The file but for its comments (budget.studies.export.template).
    """

    target: Target
    title: str
    entries: tuple[Exported, ...]
    left_out: tuple[str, ...]
    not_held: tuple[str, ...]
    notes: tuple[str, ...]
    missing: str
    rate: float | None  # [Hz]
    inflate: float  # [1]
    procedure: str  # whose residual it is; '' of the raw figures
    body: str

    @property
    def rows(self) -> list[tuple[Exported, str, float]]:
        """What stands under each key, for each axis."""
        return [row for one in self.entries for row in one.by_axis]

    def to_text(self) -> str:
        """Return the file that the target reads."""
        text: str = views.view().export_text(self)
        return text


@asking("export")
def export(
    *devices: Device | File,
    to: str,
    inputs: Inputs,
    asked: Asked,
    residual: bool = False,
    inflate: float = 1.0,
    rate: float | None = None,
) -> Export:
    """Put the figures of devices as a target counts them.

    Parameters
    ----------
    *devices : Device
        Together one gyro and one accelerometer.
    to : str
        Name of the target.
    residual : bool
        Whether bias, scale factor and mounting angles are what that calibration leaves
        at the next turn-on, by the law of propagation, in place of the raw lines.
    inflate : float
        Factor on every standard deviation and density; variances take its square [1].
    rate : float, optional
        Samples in a second [Hz].

    Raises
    ------
    CallError
        A triad, the rate, or a figure that the target must have is missing.
    """
    imus = load_devices(devices)
    target = find_target(to)
    _check(target, inflate=inflate, rate=rate)
    if inputs.measured and not residual:
        raise CallError(
            "a result of a calibration changes nothing without --residual; add it, or "
            "leave --measured out"
        )
    if inputs.procedure is not None and not residual:
        raise CallError(
            f"a procedure changes nothing without --residual: {target.name} gets the "
            "raw figures of the data sheet; add --residual, or leave the procedure out"
        )
    imus, filling = fill_all(imus, asked.missing, inputs.catalogue)
    told = {line.source: line for line in filling.lines}
    sensors = {one.kind: one for one in sensors_of(imus)}
    absent = [kind for kind in SENSORS if kind not in sensors]
    if absent:
        raise CallError(
            f"{target.title} describes a whole IMU, and no {absent[0]} is given; give "
            "a device file that has one beside this one"
        )
    left: Budget | None = None
    how: Procedure | None = None
    if residual:
        if not CALIBRATED & target.quantities:
            raise CallError(
                f"--residual changes no key of {target.title}, which takes noise alone "
                "and nothing that a calibration finds; leave the option out"
            )
        how = inputs.calibrated()
        imus = with_results(imus, inputs.measured, how)
        sensors = {one.kind: one for one in sensors_of(imus)}
        left = analyze(*imus, procedure=how, reference=REFERENCE, validate=False)
    name = "" if how is None else how.name
    known = {
        kind: KnownFigures(
            sensor=sensor, rate=rate, left=left, procedure=name, filled=told
        )
        for kind, sensor in sensors.items()
    }
    gravity = how.gravity if how else STANDARD_GRAVITY
    filled_in = fill_in(target, known, inflate=inflate, rate=rate, gravity=gravity)
    filled_in.check()
    entries = tuple(filled_in.entries.values())
    held = {line for one in entries for line in one.lines}
    said = {one.said for device in imus for one in device.origin.changes}
    said |= {
        f"{one.expected}: {one.words}" for name, one in told.items() if name in held
    }
    opened = {  # as the file names them: over temperature it is another line
        Name(own.name, owner=kind)
        for kind, sensor in sensors.items()
        for line in sensor.lines
        for _, own in line.readings
        if Name(line.name, owner=kind) in held
    }
    assumptions = tuple(
        text
        for device in imus
        for text in device.assumptions
        if text in said or any(text.startswith(f"{line}:") for line in (held | opened))
    )
    return Export(
        target=target,
        title=" and ".join(dict.fromkeys(one.device for one in sensors.values())),
        inputs=input_files(imus, procedure=how if residual else None),
        settings=asked.settle(),
        entries=entries,
        left_out=tuple(filled_in.left_out.values()),
        not_held=tuple(_not_held(sensors, held | told.keys())),
        notes=(*target.notes, *_notes(target, known, entries)),
        assumptions=assumptions
        if left is None
        else tuple(dict.fromkeys((*assumptions, *left.assumptions))),
        warnings=() if left is None else left.warnings,
        missing=asked.missing,
        rate=rate,
        inflate=inflate,
        procedure=name,
        body=filled_in.text,
    )


def _check(target: Target, *, inflate: float, rate: float | None) -> None:
    """Refuse a factor or a rate that means nothing."""
    for name, number in (("inflate", inflate), ("rate", rate)):
        if number is not None and not isinstance(number, Real):
            raise CallError(f"{name} is {number!r}, expected a number")
    if not LEAST_INFLATION <= inflate <= MOST_INFLATION:
        raise CallError(
            f"inflate is {inflate!r}, allowed: {LEAST_INFLATION:g} to "
            f"{MOST_INFLATION:g}"
        )
    if rate is not None and not (isfinite(rate) and LEAST_RATE <= rate <= MOST_RATE):
        raise CallError(
            f"rate is {rate!r} Hz, allowed: {LEAST_RATE:g} to {MOST_RATE:g}"
        )
    if target.needs_rate and rate is None:
        raise CallError(
            f"{target.title} counts by the sample, and no sampling rate is given; give "
            "that of the readings it gets, as --rate 200"
        )


def _not_held(sensors: Mapping[str, Sensor], held: set[Name]) -> Iterator[str]:
    """Yield the lines that the target has no place for, and the nominal values."""
    for kind, sensor in sensors.items():
        for line in sensor.lines:
            name = Name(line.name, owner=kind)
            if name not in held:
                yield f"{name}: {line.printed}"
        nominal = {
            "bias": sensor.nominal_bias,
            "mounting angle": sensor.nominal_mounting_angle,
        }
        for word, value in nominal.items():
            if np.any(value):
                yield f"{kind}: the nominal {word}, taken as compensated"


def _notes(
    target: Target, known: Mapping[str, KnownFigures], entries: Sequence[Exported]
) -> Iterator[str]:
    """Yield what else a user of the file must know."""
    times = [known[kind]["correlation_time"] for kind in (GYRO, ACCELEROMETER)]
    values = [set(one.value.tolist()) for one in times if isinstance(one, Figure)]
    if target.one_time and len(set().union(*values)) > 1:
        texts = ", ".join(print_number(value) for value in sorted(set().union(*values)))
        yield (
            "one correlation time for all, the longest of the gyros; the device has "
            f"{texts} s"
        )
    if any("proxy" in step for one in entries for step in one.steps):
        yield (
            "a random walk that stands for a Gauss-Markov process is a proxy: it grows "
            "for ever, where the process stays at sigma"
        )
