"""Recorded calibrations: one, as a certificate too; two of a unit; those of a lot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby
from math import floor, inf, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.model.sources import ENVIRONMENT, GYRO, SENSORS, STATION
from budget.names import AXES, PARAMETERS, Name
from budget.report.document import json_text
from budget.report.figures.rows import (
    Chart,
    ChartMark,
    ChartPanel,
    Dot,
    Head,
    Stroke,
    chart_picture,
    rows_of,
)
from budget.report.figures.style import INK, VERMILION, Scale
from budget.report.pages import document, figure, section, sections
from budget.report.provenance import endings
from budget.report.recording import run_row
from budget.report.tables import DASH, print_given

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from types import SimpleNamespace

    from budget.arrays import Array
    from budget.recordings.calibrated import (
        CalibratedOutput,
        RecordedCalibration,
    )
    from budget.recordings.lot import CalibratedLot
    from budget.recordings.results import CalibrationChange, ChangedParameter
    from budget.recordings.run_soundness import UnseenMistakes
    from budget.report.blocks import Document, Section

FAR = 3.0  # standard uncertainties, from which a value is in colour, and said [1]
MOST_SAID = 3  # values that are far off, in a headline
MOST_DIGITS = 12
MOST_ROWS = 40  # of residuals, in one drawing
KNOWN = 1e6  # degrees of freedom, from which k is that of a normal law to 1e-5
PAGE = "figures_calibrated"
WHOLE, SHORT = "%.7g", "%.2g"
INVERSE = "S\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT ONE}"


@dataclass(frozen=True, kw_only=True)
class PrintedOutput:
    """One value as people read it, in its unit, to two digits of U."""

    row: CalibratedOutput
    name: Name
    printed: str
    exact: float
    expanded: str
    nu: str
    as_found: str  # '' where nothing says it
    exact_as_found: float


def decimals_of(u: float) -> int:
    """Return the decimals of a value whose uncertainty is told to two digits."""
    decimals = 1 - floor(log10(u)) if 0.0 < u < inf else 6
    return min(max(decimals, 0), MOST_DIGITS)


def printed_output(row: CalibratedOutput) -> PrintedOutput:
    """Print a value and its expanded uncertainty to the same decimals."""
    value, expanded = row.value / row.si_per_unit, row.expanded / row.si_per_unit
    decimals = decimals_of(expanded)
    nu = row.degrees_of_freedom
    error = None if row.as_found is None else row.as_found / row.si_per_unit
    return PrintedOutput(
        row=row,
        name=Name(row.parameter, owner=row.sensor, axis=row.axis),
        printed=f"{value:.{decimals}f}",
        exact=value,
        expanded=print_given(expanded, digits=2),
        nu="inf" if nu >= KNOWN else print_given(nu, digits=2),
        as_found=""
        if error is None
        else f"{round(error, decimals) + 0.0:+.{decimals}f}",
        exact_as_found=error or 0.0,
    )


@dataclass(frozen=True, kw_only=True)
class Pull:
    """What is off by how many standard uncertainties."""

    sensor: str
    axis: str
    z: float
    remaining: float = 0.0
    name: Name | None = None  # of a value
    window: int = 0  # of a residual
    said: str = ""  # the window's name
    last: int = 0  # the window that a turn ends at

    @property
    def size(self) -> float:
        """Whatever the sign."""
        return abs(self.z)


def calibrate_answer(found: RecordedCalibration) -> tuple[Section, ...]:
    """Return what stands on a terminal: soundness, values, what is not shown."""
    return (
        *sections("calibrate", **_view(found)),
        *sections("assumptions", found=_said_once(found)),
    )


def change_answer(found: CalibrationChange) -> tuple[Section, ...]:
    """Return what stands on a terminal of two: what moved, and what it looks like."""
    return _beside("changed", found, printed=_printed_change)


def calibrated_lot_answer(found: CalibratedLot) -> tuple[Section, ...]:
    """Return what stands on a terminal of a lot: its spread beside the data sheet."""
    return _beside("calibrated_lot", found)


def _printed_change(one: ChangedParameter) -> tuple[str, str, str]:
    """Print both values and their change, to two digits of its uncertainty."""
    values = (one.first, one.second, one.difference)
    u = one.standard_uncertainty
    if not u:
        first, second, change = (print_given(x, digits=6) for x in values)
    else:
        first, second, change = (f"{x:.{decimals_of(u)}f}" for x in values)
    return first, second, change


def _beside(
    page: str, found: CalibrationChange | CalibratedLot, **filters: object
) -> tuple[Section, ...]:
    """Return a page of parameters by their sensor."""
    parameters: Sequence[Any] = found.parameters
    groups = groupby(parameters, key=lambda one: one.sensor)
    return sections(
        page,
        found=found,
        groups={key: [*own] for key, own in groups},
        DASH=DASH,
        **filters,
    )


def unseen_section(found: UnseenMistakes, *, device: str) -> Section:
    """Return what a run of a procedure with a device may not show."""
    return section("unseen", found=found, device=device)


def _view(found: RecordedCalibration) -> dict[str, object]:
    """Return what the pages are given."""
    outputs: dict[str, dict[str, list[PrintedOutput]]] = {}
    for row in found.outputs:
        one = printed_output(row)
        outputs.setdefault(row.sensor, {}).setdefault(row.parameter, []).append(one)
    far = [
        one
        for own in outputs.values()
        for each in own.values()
        for one in each
        if one.row.prior_z is not None and abs(one.row.prior_z) > FAR
    ]
    far.sort(key=lambda one: -abs(one.row.prior_z or 0.0))
    is_told = found.is_sound is False and not found.looks_like
    return {
        "found": found,
        "outputs": {sensor: [*own.values()] for sensor, own in outputs.items()},
        "conditions": [run_row(one) for one in found.environment],
        "station": found.station,
        "station_file": next((x.name for x in found.inputs if x.role == STATION), ""),
        "off": far[:MOST_SAID] if is_told else [],
        "DASH": DASH,
    }


def calibrate_document(
    found: RecordedCalibration, *, date: str, command_line: str = "budget calibrate"
) -> Document:
    """Put it into one document: a certificate."""
    pulls = pull_chart(found)
    windows: dict[str, list[tuple[object, list[str], str, str]]] = {}
    for one in found.windows:
        row = (
            one,
            [f"{x:.7g}" for x in one.mean.tolist()],
            _listed(one.residual, "+.3g"),
            "" if one.z is None else _listed(one.z, "+.1f"),
        )
        windows.setdefault(one.sensor, []).append(row)
    return document(
        "calibrate_page",
        picture=None if pulls is None else chart_picture(pulls),
        residuals=[chart_picture(one) for one in residual_charts(found)],
        windows=windows,
        turns=[
            (one, _listed(one.residual, "+.3g"), _listed(one.z, "+.1f"))
            for one in found.turns
        ],
        spans=[f"{a.start:.2f} to {a.end:.2f} s" for a in found.passed_over],
        parts={
            one.sensor: [
                ("S", one.sensor_from_body, one.unit, WHOLE),
                ("u(S)", one.standard_uncertainty, one.unit, SHORT),
                (INVERSE, one.body_from_sensor, _inverse(one.unit), WHOLE),
                ("L", one.triangle, one.unit, WHOLE),
                ("R", one.rotation, "1", WHOLE),
                ("bias", one.bias[None], one.bias_unit, WHOLE),
                ("u(bias)", [one.bias_standard_uncertainty], one.bias_unit, SHORT),
            ]
            for one in found.matrix
        },
        assumed=sections("assumptions", found=_said_once(found)),
        **_view(found),
    ).whole(
        "calibrate",
        *endings(found.inputs, command_line=command_line),
        json=json_text(found.to_dict()),
        date=date,
    )


def _said_once(found: RecordedCalibration) -> RecordedCalibration:
    """Leave figures of the station, which stand by themselves, out of the rest."""
    figures = tuple(
        f"{Name(one.name, owner=owner)}: {one.printed}, "
        for one in found.station
        for owner in (STATION, ENVIRONMENT)
    )
    rest = [one for one in found.assumptions if not str(one).startswith(figures)]
    return replace(found, assumptions=tuple(rest))


def _listed(values: Array, form: str) -> str:
    """Write values beside each other."""
    return " ".join(f"{x:{form}}" for x in values.tolist())


def _inverse(unit: str) -> str:
    """Return the unit of an inverse."""
    return "1" if unit == "1" else "/".join(reversed(unit.split("/", 1)))


def pull_chart(found: RecordedCalibration) -> Chart | None:
    """Show how far values are off the data sheet; None without one."""
    rows = [
        Pull(
            sensor=one.sensor,
            axis=one.axis,
            z=one.prior_z,
            remaining=one.remaining or 0.0,
            name=Name(one.parameter, owner=one.sensor),
        )
        for one in found.outputs
        if one.prior_z is not None and one.parameter in PARAMETERS
    ]
    return _chart("pulls", rows)


def residual_charts(found: RecordedCalibration) -> Iterator[Chart]:
    """Yield the largest residuals of windows and turns, where something says their u.

    Of each triad; of many the farthest.
    """
    pulls: dict[tuple[str, bool], list[Pull]] = {}
    for one in found.windows:
        if one.z is None:
            continue
        k = int(np.abs(one.z).argmax())
        own = Pull(
            sensor=one.sensor,
            axis=AXES[k] if len(one.z) > 1 else "",  # of a norm
            z=float(one.z[k]),
            window=one.window,
            said=one.name,
        )
        pulls.setdefault((one.sensor, False), []).append(own)
    for turn in found.turns:
        z = float(turn.z[np.abs(turn.z).argmax()])
        own = Pull(sensor=GYRO, axis="", z=z, window=turn.first, last=turn.last)
        pulls.setdefault((GYRO, True), []).append(own)
    for _, rows in sorted(pulls.items(), key=lambda x: SENSORS.index(x[0][0])):
        least = sorted((one.size for one in rows), reverse=True)[:MOST_ROWS][-1]
        shown = [one for one in rows if one.size >= least]
        chart = _chart("residuals", shown, every=len(rows))
        if chart is not None:
            yield chart


def _chart(name: str, rows: Sequence[Pull], every: int = 0) -> Chart | None:
    """Draw pulls as rows; None of none. Of so many some may be left out."""
    if not rows:
        return None
    said, table = figure(PAGE, name, rows=rows, every=every)
    most = max(FAR + 1.0, *(1.1 * one.size for one in rows))
    scale = Scale(low=-most, high=most, label=said.axis)

    def marks(_: SimpleNamespace, one: Pull) -> list[ChartMark]:
        colour = VERMILION if one.size > FAR else INK
        reach = 1.96 * one.remaining
        line = [
            Stroke(start=one.z - reach, end=one.z + reach, colour=colour, width=1.2)
        ]
        return [*(line if reach else []), Dot(start=one.z, colour=colour, edge=colour)]

    return Chart(
        name=name,
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=rows_of(table, marks, list(rows))),),
        table=table,
        has_data=False,
        caption=said.caption,
        heads=(Head(at=0.0, text=said.nominal),),
    )
