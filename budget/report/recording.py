"""What recordings say of noise: for a terminal, as a page, and as a device file."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

from budget.errors import CallError
from budget.inputs.device import read_device
from budget.inputs.reader import parse
from budget.inputs.tree import block, flow, quoted, visible
from budget.names import AXES, Name
from budget.recordings.characterise import (
    CHANGE,
    MODEL_NAMES,
    NOMINAL,
    TIME_LINE,
    title_of,
)
from budget.report.document import json_text
from budget.report.figures.recorded import recorded_plots, spectrum_plots
from budget.report.pages import document, sections
from budget.report.provenance import endings
from budget.report.tables import DASH, print_given
from budget.sentences import sentence
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.inputs.records import Device
    from budget.recordings.records import (
        Characterisation,
        NoiseLine,
        RecordedConditions,
    )
    from budget.report.blocks import Document, Section

DIGITS = 3
MOST_TEXT, MOST_NOTES = 200, 4000  # characters of a device file's texts
# Written with the lines whose time they are.
BESIDE = {TIME_LINE: "bias_stability", NOMINAL: "bias"}


@dataclass(frozen=True, kw_only=True)
class PrintedLine:
    """One figure as people read it, in its unit."""

    line: NoiseLine
    name: Name  # of the specification
    value: str  # '0.152', '≤ 3.01', '?'
    exact: float | None
    ends: tuple[str, ...]  # of the interval; () where it is none
    degrees_of_freedom: str


def printed(line: NoiseLine) -> PrintedLine:
    """Print a figure: an upper bound as one, what is refused as unknown."""
    scale = line.si_per_unit
    value = print_given(line.value / scale, digits=DIGITS)
    ends = tuple(
        print_given(one / scale, digits=DIGITS)
        for one in line.interval
        if line.is_told and (0.0 < one < inf or line.line == NOMINAL)
    )
    nu = line.degrees_of_freedom
    return PrintedLine(
        line=line,
        name=Name(BESIDE.get(line.line, line.line), owner=line.sensor),
        value=value
        if line.is_told
        else f"\N{LESS-THAN OR EQUAL TO} {value}"
        if line.bound == "upper"
        else "?",
        exact=line.value / scale if line.is_told else None,
        ends=ends if len(ends) == len(line.interval) else (),
        degrees_of_freedom=print_given(nu, digits=2) if nu else "",
    )


def run_row(one: RecordedConditions) -> tuple[RecordedConditions, list[str]]:
    """Return when and in what a recording was made, and that in the units of people."""
    numbers = (
        (one.temperature, 1.0, "\N{DEGREE SIGN}C"),
        (one.humidity, 100.0, "% RH"),
        (one.pressure, 0.01, "hPa"),
    )
    given = [f"{x * size:.6g} {unit}" for x, size, unit in numbers if x is not None]
    return one, [*given, *([one.text] if one.text else [])]


def characterise_answer(found: Characterisation) -> tuple[Section, ...]:
    """Return what stands on a terminal: figures by line and axis, what is not told."""
    return (
        *sections("characterise", **_view(found)),
        *sections("assumptions", found=found),
    )


def _view(found: Characterisation) -> dict[str, object]:
    """Return what the pages are given."""
    groups: dict[str, dict[str, list[PrintedLine]]] = {x: {} for x in found.sensors}
    for one in found.lines:
        groups[one.sensor].setdefault(one.line, []).append(printed(one))
    models = {
        sensor: [
            (one.axis, MODEL_NAMES[one.chosen], one)
            for one in found.models
            if one.sensor == sensor
        ]
        for sensor in found.sensors
    }
    return {
        "found": found,
        "conditions": [run_row(one) for one in found.environment],
        "groups": {sensor: [*own.values()] for sensor, own in groups.items()},
        "TIME_LINE": TIME_LINE,
        "models": models,
        "chosen": {
            sensor: {
                name: [axis for axis, other, _ in own if other == name]
                for _, name, _ in own
            }
            for sensor, own in models.items()
        },
        "refused": [
            *(
                (sensor, sentence("recordings.short", name=found.title))
                for sensor in found.sensors
                if found.is_short
            ),
            *(
                (title_of(f"{one.sensor}_{one.axis}"), one.why)
                for one in found.lines
                if one.bound == "refused"
            ),
        ],
        "MODEL_NAMES": MODEL_NAMES,
        "DASH": DASH,
    }


def characterise_document(
    found: Characterisation, *, date: str, command_line: str = "budget characterise"
) -> Document:
    """Put it into one document: figures, curves, models, and the record's health."""
    return document(
        "characterise_page",
        pictures=[one.picture for one in recorded_plots(found)],
        spectra=[one.picture for one in spectrum_plots(found)],
        assumed=sections("assumptions", found=found),
        **_view(found),
    ).whole(
        "characterise",
        *endings(found.inputs, command_line=command_line),
        json=json_text(found.to_dict()),
        date=date,
    )


# ---- device file ---------------------------------------------------------------------


def measured_yaml(found: Characterisation, *, name: str = "") -> str:
    """Write figures as a device file: values, degrees of freedom, upper bounds as max.

    A parameter that is told of some axes is 0 on those whose model does without it. An
    axis that was not recorded has the largest of those that were.

    Raises
    ------
    CallError
        Figures are in counts.
    """
    if found.has_counts:
        raise CallError(
            f"{found.title} is in counts, of which no device file can be; give a "
            "recording file (.yaml) with gain, as 'gain: {gyro: 16.4 counts/(deg/s)}'"
        )
    names = visible(", ".join(dict.fromkeys(one.name for one in found.inputs)))
    notes = [
        f"Recorded at rest: {names}; by budget {__version__} characterise.",
        *(visible(str(text)) for text in found.warnings),
        *(
            f"{title_of(f'{one.sensor}_{one.axis}')}: {one.why}"
            for one in found.lines
            if one.bound == "refused"
        ),
    ]
    entries: list[tuple[str, str | list[tuple[str, str]]]] = [
        ("format", "budget-device/1"),
        ("name", quoted(visible(name or found.title)[:MOST_TEXT])),
        ("source", quoted(f"recorded: {names}"[:MOST_TEXT])),
        ("notes", quoted("\n".join(notes)[:MOST_NOTES])),
    ]
    for sensor in found.sensors:
        own = [one for one in found.lines if one.sensor == sensor]
        biases = {one.axis: _said(one, one.unit) for one in own if one.line == NOMINAL}
        said: list[Any] = [("nominal", flow({"bias": biases}))] if biases else []
        errors: list[Any] = [*said, ("errors", [*_errors(own)])]
        entries.append((sensor, errors))
    return "\n".join(block(entries)) + "\n"


def measured_device(found: Characterisation) -> Device:
    """Return the device whose file it is."""
    text = measured_yaml(found)
    return read_device(parse(text.encode(), found.title, base_name=found.title))


def _errors(own: Sequence[NoiseLine]) -> Iterator[tuple[str, str]]:
    """Yield the lines of one sensor, as a device file has them."""
    times = {one.axis: one for one in own if one.line == TIME_LINE and one.is_told}
    for line in dict.fromkeys(one.line for one in own):
        if line in {TIME_LINE, NOMINAL}:
            continue
        by_axis = {
            one.axis: one for one in own if one.line == line and one.bound != "refused"
        }
        if not by_axis:
            continue
        recorded = {one.axis for one in own}
        slow = "bias_stability" if line == "flicker" and times else ""
        yield line, _figure(line, by_axis, times, recorded, slow)


def _figure(
    line: str,
    by_axis: dict[str, NoiseLine],
    times: dict[str, NoiseLine],
    recorded: set[str],
    slow: str,
) -> str:
    """Write one line of a device file."""
    largest = max(by_axis.values(), key=lambda one: one.value)
    has_time = line == BESIDE[TIME_LINE]
    slowest = max(times.values(), key=lambda one: one.value) if has_time else None
    axes: dict[str, object] = {}
    for axis in AXES:
        one = by_axis.get(axis) or (None if axis in recorded else largest)
        time = (times.get(axis) or slowest) if has_time else None
        says: dict[str, object] = {"value": _said(one, largest.unit)}
        if one is None:
            says["meaning"] = "exact"
        elif one.bound == "upper":
            says["meaning"] = "max"
        elif one.degrees_of_freedom and one.parameter != CHANGE:
            says["degrees_of_freedom"] = f"{one.degrees_of_freedom:.4g}"
        if time is not None:
            says["correlation_time"] = quoted(f"{time.value:.5g} s")
        axes[axis] = says
    said = "; ".join(
        f"{axis} {' to '.join(printed(one).ends)}"
        for axis, one in by_axis.items()
        if one.is_told
    )
    condition = f"at rest; 95 %: {said} {largest.unit}" if said else "at rest"
    others = [axis for axis in AXES if axis not in recorded]
    if others:
        condition += f"; {', '.join(others)} not recorded, as {largest.axis}"
    says = {"axes": axes, "condition": quoted(condition[:MOST_TEXT])}
    # Beside what wanders in a time of its own it is another noise.
    return flow(says | ({"adds_to": slow} if slow else {}))


def _said(one: NoiseLine | None, unit: str) -> str:
    """Write a value with its unit."""
    value = 0.0 if one is None else one.value / one.si_per_unit
    return quoted(f"{value:.6g} {unit}")
