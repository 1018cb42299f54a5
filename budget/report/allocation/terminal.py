"""An allocation on a terminal of any width."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING

from budget.model.sources import SENSORS
from budget.report.allocation.words import (
    DIGITS,
    explain_idle,
    headline,
    lever_text,
    match_text,
    part_title,
    print_change,
    print_headroom,
    print_part,
    print_stop,
    print_used,
    print_value,
    relaxations,
    tightest,
)
from budget.report.tables import (
    join_outputs,
    output_title,
    print_count,
    print_coverage,
    print_given,
    source_title,
)
from budget.results import INTERACTION
from budget.studies.allocation.records import FREE, MEAN
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from budget.studies.allocation.records import (
        Allocation,
        LimitedOutput,
        SourceAllotment,
    )

CLOSEST = 3  # devices a sensor that are shown where none meets
GAP = "  "
TEXT_WIDTH = 78
NO_BREAK = "\N{NO-BREAK SPACE}"
PLAIN = str.maketrans({"\N{MICRO SIGN}": "u", "\N{GREEK SMALL LETTER MU}": "u"})


def allocation_text(allocation: Allocation, *, width: int) -> str:
    """Write an allocation for a terminal.

    Parameters
    ----------
    allocation : Allocation
    width : int
        Of the terminal; rows that do not fit are set one field a line [columns].

    Returns
    -------
    str
        Ends with a line feed.
    """
    coverage = print_coverage(allocation.coverage)
    lines = _wrap(allocation.title, width)
    lines += _wrap(headline(allocation), width)
    lines += _wrap(
        f"strategy {allocation.strategy}, coverage {coverage} %, reference "
        f"{allocation.reference}, procedure {allocation.procedure}",
        width,
    )
    if not allocation.feasible:
        lines += ["", "What would make it feasible"]
        lines += _items(relaxations(allocation.impossible), width)
    for sensor in dict.fromkeys(row.source.owner for row in allocation.sources):
        rows = [row for row in allocation.sources if row.source.owner == sensor]
        limited = [row for row in allocation.outputs if row.sensor == sensor]
        lines += _sensor_lines(sensor, rows, limited, width)
    lines += _cost_lines(allocation, width)
    lines += _check_lines(allocation, width)
    if allocation.levers:
        lines += ["", "The procedure as a lever"]
        lines += _items([lever_text(lever) for lever in allocation.levers], width)
    for sensor in dict.fromkeys(match.sensor for match in allocation.matches):
        own = [match for match in allocation.matches if match.sensor == sensor]
        meeting = sum(match.meets for match in own)
        lines += _heading(
            f"Catalogue: {meeting} of {len(own)} {sensor} entries meet every line",
            width,
        )
        lines += _items(
            [match_text(match) for match in own[: max(meeting, CLOSEST)]], width
        )
    for label, texts in (
        ("Assumptions", allocation.assumptions),
        ("Warnings", allocation.warnings),
    ):
        if texts:
            lines += ["", label, *_items(texts, width)]
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _sensor_lines(
    sensor: str,
    rows: Sequence[SourceAllotment],
    limited: Sequence[LimitedOutput],
    width: int,
) -> list[str]:
    """Write what the lines of one sensor may be, what they take, how far they go."""
    feasible = all(row.allowed is not None for row in rows)
    lines = ["", f"{sensor.capitalize()} lines, 1 sigma"]
    lines += _table(_source_cells(rows, feasible=feasible), width)
    if feasible and any(row.is_beyond_market for row in rows):
        lines += _wrap("* nothing in the catalogue is as good", width)
    if idle := explain_idle(rows):
        lines += _wrap(idle, width)
    if any(row.uncorrected is not None for row in rows):
        lines += _items(_corrections(rows), width)
    if limited:
        lines += _heading(
            f"{sensor.capitalize()}: part of each squared limit [%], "
            + ("now > allowed" if feasible else "now"),
            width,
        )
        lines += _table(_part_cells(limited, feasible=feasible), width)
    if limited or sensor not in SENSORS:
        lines += _heading(
            f"{sensor.capitalize()} headroom: each line alone, the others as now",
            width,
        )
        lines += _table(_headroom_cells(rows), width)
    return lines


def _source_cells(
    rows: Sequence[SourceAllotment], *, feasible: bool
) -> list[list[str]]:
    """Return head and rows of the allocation table."""
    marks = [_mark(row) for row in rows]
    head = ["line", "now", *(["allowed"] if feasible else []), "unit"]
    head += ["change", "stopped by"] if feasible else []
    cells = [[*head, ""] if any(marks) else head]
    for row, mark in zip(rows, marks, strict=True):
        cell = [source_title(row.source), print_given(row.now / row.si_per_unit)]
        if feasible and row.allowed is not None:
            star = "*" if row.is_beyond_market else ""
            size = row.allowed / row.si_per_unit
            cell.append(print_given(size, digits=DIGITS) + star)
        cell.append(row.unit.translate(PLAIN))
        if feasible:
            cell += [
                print_change(row),
                _short(print_stop(row.binding_outputs, row.source.owner)),
            ]
        cells.append([*cell, mark] if any(marks) else cell)
    return cells


def _mark(row: SourceAllotment) -> str:
    """Return what is special about a source, in a word or two."""
    if row.status != FREE:
        return row.status
    if row.at_ceiling:
        return "ceiling"
    return "least" if row.at_least else ""


def _short(name: str) -> str:
    """Name an output of a sensor that stands above: 'angle xy', 'bias z'."""
    return name.removeprefix("mounting ")


def _part_cells(outputs: Sequence[LimitedOutput], *, feasible: bool) -> list[list[str]]:
    """Return head and rows of the parts, at the tightest output of each group."""
    chosen = tightest(outputs)
    cells = [["", *(output_title(row.output.name.without_owner) for row in chosen)]]
    for place, part in enumerate(chosen[0].parts):
        parts = [row.parts[place] for row in chosen]
        shown = [
            print_part(p.now) + (f" > {print_part(p.allowed)}" if feasible else "")
            for p in parts
        ]
        small = part.source in {INTERACTION, MEAN}
        if small and all(max(p.now, p.allowed or 0.0) < 1e-3 for p in parts):  # noqa: PLR2004
            continue
        cells.append([part_title(part.source, chosen[0].sensor), *shown])
    errors = [
        print_used(row, now=True)
        + (f" > {print_used(row, now=False)}" if feasible else "")
        for row in chosen
    ]
    cells.append(["largest error, of the limit", *errors])
    return cells


def _headroom_cells(rows: Sequence[SourceAllotment]) -> list[list[str]]:
    """Return head and rows of the headroom table."""
    cells = [["line", "now", "alone up to", "unit", "stopped by"]]
    for row in rows:
        if row.headroom is None and not row.is_idle:
            continue
        up_to, stop = print_headroom(row)
        cells.append(
            [
                source_title(row.source),
                print_given(row.now / row.si_per_unit),
                up_to,
                row.unit.translate(PLAIN),
                _short(stop),
            ]
        )
    return cells


def _corrections(rows: Iterable[SourceAllotment]) -> list[str]:
    """Say what Monte Carlo changed."""
    return [
        f"{source_title(row.source)}: the law alone allows "
        f"{print_value(row.uncorrected / row.si_per_unit, row.unit)}, corrected by "
        "Monte Carlo"
        for row in rows
        if row.uncorrected is not None
    ]


SHARP = 1e-12  # below it a residual is the rounding of the processor [1]


def _cost_lines(allocation: Allocation, width: int) -> list[str]:
    """Say what the allocation costs and what limits cost."""
    if not allocation.costs:
        return []
    lines = ["", "Cost"]
    for cost in allocation.costs:
        total = (
            f"{cost.sensor}: {cost.cost:.5g} for the lines that are free, "
            f"{cost.now:.5g} now; at most {cost.gap:.1g} of it above the least "
            f"(residual below {max(settle(cost.residual), SHARP):.1g})"
        )
        texts = [total]
        texts += [
            f"one percent more on {join_outputs(saving.outputs)} would save "
            f"{saving.saves:.3g} ({100.0 * saving.part:.2g} % of the cost)"
            for saving in cost.savings
        ]
        lines += _items(texts, width)
    return lines


def _check_lines(allocation: Allocation, width: int) -> list[str]:
    """Say how Monte Carlo found the allocated values."""
    if not allocation.checks:
        return []
    wanted = 100.0 * allocation.coverage
    lines = _heading("Checked by Monte Carlo at the allocated values", width)
    fine = [check for check in allocation.checks if not check.is_corrected]
    texts = []
    if fine:
        covered = [100.0 * check.covered for check in fine]
        span = (
            f"{min(covered):.2f} %"
            if len(covered) == 1
            else f"{min(covered):.2f} to {max(covered):.2f} %"
        )
        texts.append(
            f"coverage {span} at {len(fine)} outputs at their limits, {wanted:g} % "
            f"wanted ({print_count(fine[0].trials)} trials)"
        )
    texts += [
        f"{output_title(check.output)}: the law's interval covers "
        f"{100.0 * check.covered:.2f} % in place of {wanted:g} %, so it was allocated "
        f"with k = {check.factor:.4f} in place of {check.factor_before:.4f}"
        for check in allocation.checks
        if check.is_corrected
    ]
    return lines + _items(texts, width)


def _heading(text: str, width: int) -> list[str]:
    """Return an empty line and a heading."""
    return ["", *_wrap(text, width)]


def _items(texts: Iterable[str], width: int) -> list[str]:
    """Write a list of sentences."""
    return [line for text in texts for line in _wrap(text, width, first="- ")]


def _wrap(text: str, width: int, *, first: str = "") -> list[str]:
    """Break a text into lines, indented below `first`."""
    bound = re.sub(r"(?<=\d) (?=\S)", NO_BREAK, text.translate(PLAIN))
    lines = textwrap.wrap(
        bound,
        min(width, TEXT_WIDTH),
        initial_indent=first,
        subsequent_indent=" " * len(first),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(NO_BREAK, " ") for line in lines]


def _table(cells: Sequence[Sequence[str]], width: int) -> list[str]:
    """Set a table; one field a line where it is wider than the terminal."""
    widths = [max(len(row[place]) for row in cells) for place in range(len(cells[0]))]
    lines = []
    for row in cells:
        texts = [
            text.rjust(size) if _is_number(place, cells) else text.ljust(size)
            for place, (text, size) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append(GAP.join(texts).rstrip())
    if max(len(line) for line in lines) <= width:
        return lines
    head, *rows = cells
    return [
        line
        for row in rows
        for line in (
            row[0],
            *(
                part
                for name, text in zip(head[1:], row[1:], strict=True)
                if text
                for part in _wrap(f"{name}: {text}" if name else text, width, first=GAP)
            ),
        )
    ]


def _is_number(place: int, cells: Sequence[Sequence[str]]) -> bool:
    """Whether a column is set flush right."""
    return place > 0 and any(row[place][:1].isdigit() for row in cells[1:])
