"""A simulated recording: what a terminal says of it, and the file of what was drawn."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

from budget.inputs.tree import block, flow, quoted
from budget.model.sources import FLICKER, lines_of, source_of
from budget.names import Name
from budget.recordings.simulated_run import SimulatedRun
from budget.report.pages import sections
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Sensor
    from budget.recordings.simulated import SimulatedReadings
    from budget.report.blocks import Section

DIGITS = 9


def simulated_answer(made: SimulatedReadings, *, name: str) -> tuple[Section, ...]:
    """Return what stands on a terminal once a recording is written."""
    return sections("simulate", made=made, name=name)


def truth_yaml(made: SimulatedReadings) -> str:
    """Write what was drawn: constants of the turn-on, and the processes as given."""
    place = made.procedure
    entries: list[tuple[str, object]] = [
        ("format", "budget-truth/1"),
        ("device", quoted(made.device.name)),
        ("seed", str(made.seed)),
        ("rate", quoted(f"{made.rate:.12g} Hz")),
        ("samples", str(made.samples)),
        *_test(made),
        ("latitude", quoted(f"{degrees(place.latitude):.12g} deg")),
        ("gravity", quoted(f"{place.gravity:.12g} m/s^2")),
        ("assumed", flow([quoted(one) for one in made.device.assumptions])),
        *((one.kind, [*_triad(made, one)]) for one in made.device.sensors),
    ]
    return "\n".join(block(entries)) + "\n"


def _test(made: SimulatedReadings) -> Iterator[tuple[str, object]]:
    """Yield how it stood: at rest, or in the windows of a procedure."""
    if not isinstance(made, SimulatedRun):
        yield "axes", "{x: east, y: north, z: up}"
        return
    yield "procedure", quoted(made.procedure.name)
    yield "mistakes", flow([quoted(one.said) for one in made.blunders])
    there = [one for one in made.steps if one.place is not None]
    yield (
        "windows",
        [
            (
                str(place),
                flow(
                    {
                        "start": _said(one.window.start, "s"),
                        "length": _said(one.window.length, "s"),
                    }
                ),
            )
            for place, one in enumerate(there, start=1)
        ],
    )


def _triad(made: SimulatedReadings, sensor: Sensor) -> Iterator[tuple[str, object]]:
    """Yield what is written of one triad."""
    own = made.turn_ons[sensor.kind]
    whole = {"bias": own.bias, "scale_factor": own.k, "mounting_angle": own.angle}
    for quantity, values in whole.items():
        given = quantity.removesuffix("_angle")
        source = source_of(sensor.kind, f"{given}_repeatability")
        yield quantity, _axes(values, source.axes, source.like(sensor.kind))
    drawn, processes = [], []
    for source in lines_of(sensor.kind):
        line = sensor.line(source.name)
        name = Name(source.name, owner=sensor.kind)
        unit = source.like(sensor.kind)
        if name in made.constants:
            values = made.constants[name]
            drawn.append((source.name, _axes(values, source.axes, unit)))
        elif line is not None and name in made.processes:
            said = _axes(line.u, source.axes, unit)
            times = line.correlation_time
            if times is not None:
                said = flow(
                    {
                        axis: {
                            "value": _said(u, unit),
                            "correlation_time": _said(time, "s"),
                        }
                        for axis, u, time in zip(
                            source.axes, line.u, times, strict=True
                        )
                    }
                )
            key = FLICKER if line.form == FLICKER else source.name
            processes.append((key, said))
    for title, rows in (("constants", drawn), ("processes", processes)):
        if rows:
            yield title, rows


def _axes(values: Array, axes: Sequence[str], unit: str) -> str:
    """Write values by axis."""
    return flow({axis: _said(x, unit) for axis, x in zip(axes, values, strict=True)})


def _said(value: float, unit: str) -> str:
    """Write a value with its unit."""
    return quoted(f"{value / size_of(unit):.{DIGITS}g} {unit}")
