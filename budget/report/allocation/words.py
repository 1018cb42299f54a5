"""What is written of an allocation, in tables, sentences and figures alike: values."""

from __future__ import annotations

from math import floor, log10
from typing import TYPE_CHECKING

from budget.language import say, term
from budget.report.tables import (
    DASH,
    DIGITS,
    Number,
    bound_number,
    print_given,
    print_stop,
    print_utilisation,
    source_title,
)
from budget.studies.allocation.records import MEAN
from budget.ties import first_largest, from_largest, settle
from budget.units import DAY, YEAR

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Sequence

    from budget.names import Name
    from budget.studies.allocation.records import (
        LimitedOutput,
        LimitPart,
        SourceAllotment,
    )

NONE = term("none")  # no value would do
IDLE = term("counts nothing here")
CEILING = term("its ceiling")
TAKERS = 3  # sources that are named where a limit cannot be met, at the most
TAKEN = 0.01  # part of the squared limit from which one is named [1]


def print_value(value: float, unit: str) -> str:
    """Print a value with its unit to three digits."""
    return f"{print_given(value, digits=DIGITS)} {unit}"


def print_headroom(row: SourceAllotment) -> tuple[str, str]:
    """Print how far a source may go alone in the unit of its file, and what stops it.

    'none' is what cannot mend an output that fails without it, a dash that there is
    nothing to say.
    """
    room = row.headroom
    if room is None:
        return DASH, say(IDLE) if row.is_idle else DASH
    up_to = print_given(room.value / row.si_per_unit, digits=DIGITS)
    stops = room.stopped_by
    stop = print_stop(stops, row.source.owner) if stops else say(CEILING)
    return up_to if room.value else say(NONE), stop


def print_part(part: float) -> str:
    """Print a part of a squared limit in per cent, 0 plainly."""
    if part < 0.5e-3:  # noqa: PLR2004
        return "0" if part <= 1e-12 else "<0.1"  # noqa: PLR2004 - rounding
    return f"{100.0 * part:.{1 if part < 0.1 else 0}f}"  # noqa: PLR2004


def print_used(row: LimitedOutput, *, now: bool) -> str:
    """Print the largest error in per cent of the limit; at its limit it is 100 %."""
    used = row.now if now else row.after
    text = "100 %" if row.is_binding and not now else print_utilisation(used)
    number = Number(text=text, exact=used)
    return bound_number(number, lower_bound=row.lower_bound).text


def _alike(
    outputs: Sequence[LimitedOutput], by: Callable[[LimitedOutput], Hashable]
) -> Iterator[list[LimitedOutput]]:
    """Yield outputs that have something in common, in order of the first."""
    for common in dict.fromkeys(map(by, outputs)):
        yield [row for row in outputs if by(row) == common]


def tightest(outputs: Sequence[LimitedOutput]) -> tuple[LimitedOutput, ...]:
    """Return the output of each parameter group that is nearest to its limit."""
    return tuple(
        rows[
            first_largest(
                [row.now if row.allowed is None else row.allowed for row in rows]
            )
        ]
        for rows in _alike(outputs, lambda row: row.output.name.group)
    )


def part_title(source: Name, sensor: str) -> str:
    """Name what takes a part of a limit of that sensor."""
    return say("mean error") if source == MEAN else source_title(source, of=sensor)


def relaxations(
    outputs: Sequence[LimitedOutput],
) -> Iterator[tuple[list[Name], LimitedOutput, list[LimitPart]]]:
    """Yield outputs with one limit that cannot be met, the one that needs most of it.

    With what takes most of that one.
    """
    for rows in _alike(outputs, lambda row: (row.output.name.group, row.printed_limit)):
        row = rows[first_largest([row.floor for row in rows])]
        users = [row.parts[k] for k in from_largest([one.floor for one in row.parts])]
        taken = [part for part in users[:TAKERS] if part.floor > TAKEN]
        yield [each.output.name for each in rows], row, taken


def in_units(seconds: float) -> tuple[str, str]:
    """Write a time in days, months or years, two digits rounded down; and which."""
    sizes = {"years": YEAR, "months": YEAR / 12.0, "days": DAY}
    unit = next((one for one in sizes if seconds >= 2.0 * sizes[one]), "days")
    number = seconds / sizes[unit]
    step = 10.0 ** (floor(log10(number)) - 1)
    return print_given(floor(settle(number / step)) * step), unit
