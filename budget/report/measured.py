"""What was measured of a unit beside its data sheet, on a terminal and as a page."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from budget.names import Name
from budget.recordings.printed import FLOOR, NOT_MEASURED, NOT_PRINTED, WORSE
from budget.report.answers import decades
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
from budget.report.pages import document, figure, sections
from budget.report.provenance import endings
from budget.report.tables import DASH

if TYPE_CHECKING:
    from types import SimpleNamespace

    from budget.recordings.printed import (
        LotLine,
        MeasuredLine,
        MeasuredLot,
        MeasuredUnit,
    )
    from budget.report.blocks import Document, Section


def measured_answer(found: MeasuredUnit) -> tuple[Section, ...]:
    """Return what stands on a terminal: each line printed and measured."""
    return sections("measured", **_view(found))


def _view(found: MeasuredUnit) -> dict[str, object]:
    """Return what the pages are given."""
    groups: dict[str, dict[str, list[MeasuredLine]]] = {}
    for one in found.lines:
        if one.ratio is not None:
            groups.setdefault(one.sensor, {}).setdefault(one.line, []).append(one)

    def named(standing: str) -> list[Name]:
        names = [_name(one) for one in found.lines if one.standing == standing]
        return list(dict.fromkeys(names))

    return {
        "found": found,
        "groups": {sensor: [*own.values()] for sensor, own in groups.items()},
        "not_measured": named(NOT_MEASURED),
        "not_printed": named(NOT_PRINTED),
        "name_of": _name,
        "FLOOR": FLOOR,
    }


def _name(one: MeasuredLine | LotLine) -> Name:
    """Return the name of a line, whatever its axis."""
    return Name(one.line, owner=one.sensor)


def measured_document(
    found: MeasuredUnit, *, date: str, command_line: str = "budget diff"
) -> Document:
    """Put it into one document: what is worse, all ratios, all lines."""
    chart = ratio_chart(found)
    return document(
        "measured_page",
        picture=None if chart is None else chart_picture(chart),
        **_view(found),
    ).whole(
        "diff",
        *endings(found.inputs, command_line=command_line),
        json=json_text(found.to_dict()),
        date=date,
    )


def lot_answer(found: MeasuredLot) -> tuple[Section, ...]:
    """Return what stands on a terminal: each line printed, and of the lot."""
    return sections("lot", **_view_of_lot(found))


def lot_document(
    found: MeasuredLot, *, date: str, command_line: str = "budget diff"
) -> Document:
    """Put it into one document: which units are worse, and all lines."""
    return document("lot_page", **_view_of_lot(found)).whole(
        "diff",
        *endings(found.inputs, command_line=command_line),
        json=json_text(found.to_dict()),
        date=date,
    )


def _view_of_lot(found: MeasuredLot) -> dict[str, object]:
    """Return what the pages are given."""
    groups: dict[str, list[LotLine]] = {}
    for one in found.lines:
        groups.setdefault(one.sensor, []).append(one)
    return {
        "found": found,
        "groups": groups,
        "name_of": _name,
        "FLOOR": FLOOR,
        "DASH": DASH,
    }


def ratio_chart(found: MeasuredUnit) -> Chart | None:
    """Show each ratio with its interval, on one logarithmic axis; None of none."""
    lines = [one for one in found.lines if one.interval and one.interval[1] < inf]
    if not lines:
        return None
    said, table = figure(
        "figures_measured",
        "ratios",
        found=found,
        rows=lines,
        name_of=_name,
    )
    low, high = decades([1.0, *(end for one in lines for end in one.interval)])
    scale = Scale(low=low, high=high, kind="log", label=said.axis)

    def marks(_: SimpleNamespace, one: MeasuredLine) -> list[ChartMark]:
        colour = VERMILION if one.standing == WORSE else INK
        start, end = one.interval
        return [
            Stroke(start=start, end=end, colour=colour, width=1.2),
            Dot(start=one.ratio or 1.0, colour=colour, edge=colour),
        ]

    return Chart(
        name="ratios",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=rows_of(table, marks, lines)),),
        table=table,
        has_data=False,
        caption=said.caption,
        heads=(Head(at=1.0, text=said.printed),),
    )
