"""Budget table of a parameter group: JCGM 100:2008, 8.1, in the form of EA-4/02.

Axes that agree in all that is printed share their rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.language import say, term
from budget.report.blocks import Cell, Field, Paragraph, table_of
from budget.report.tables import (
    UNKNOWN,
    print_coverage,
    print_degrees_of_freedom,
    print_divisor,
)
from budget.report.wording import capital, cell, share_cell

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Table
    from budget.report.tables import GroupTable, Number, OutputRow, SourceRow
    from budget.results import InputQuantity

READ = term(
    "x is a line of the data sheet with its standard uncertainty u(x), what is printed "
    "over the divisor; c, the sensitivity coefficient, is how the output changes by "
    "one unit of x (of several inputs of a line c u(x) is the root of the sum of their "
    "squares, with their correlation, and u(x) the largest); c u(x) is the "
    "contribution of the line alone, and the share is of the variance; "
    "\N{GREEK SMALL LETTER NU} are degrees of freedom. "
    "Lines are independent of each other."
)


@dataclass(frozen=True, kw_only=True)
class Line:
    """One row of a budget table."""

    axes: str  # that it is of
    head: str
    given: str = ""
    distribution: str = ""
    divisor: str = ""
    u_input: Number | None = None
    unit: str = ""
    c: Number | None = None
    linear: Number | None = None
    whole: str = ""  # c u(x) with its second order, where that can be seen
    share: float | None = None
    degrees_of_freedom: str = ""
    strong: bool = False


def budget_table(group: GroupTable) -> Table:
    """Return the budget of one group, the largest contribution first."""
    unit = group.unit
    has_quantities = any(source.quantity for source in group.sources)

    def number(pick: Number | None, *, strong: bool = False) -> Cell | str:
        return "" if pick is None else cell(pick, strong=strong)

    fields: tuple[Field[Line], ...] = (
        Field(
            head=say("quantity"),
            cell=lambda line: Cell(text=line.head, strong=line.strong),
            weight=1.4,
        ),
        Field(
            head=say("specification"),
            cell=lambda line: line.given,
            optional=True,
            weight=1.4,
        ),
        Field(
            head=say("distribution"), cell=lambda line: line.distribution, optional=True
        ),
        Field(head=say("divisor"), cell=lambda line: line.divisor, optional=True),
        Field(
            head="u(x)",
            kind="number",
            cell=lambda line: number(line.u_input),
            optional=True,
        ),
        Field(head="", kind="unit", cell=lambda line: line.unit, optional=True),
        Field(
            head="c",
            kind="number",
            cell=lambda line: number(line.c),
            optional=True,
        ),
        Field(
            head=say("c u(x) [{unit}]", unit=unit)
            if has_quantities
            else say("u alone [{unit}]", unit=unit),
            kind="number",
            cell=lambda line: Cell(
                text=line.linear.text if line.linear else "",
                exact=line.linear.exact if line.linear else None,
                note=line.whole,
                strong=line.strong,
            ),
        ),
        Field(
            head=say("share [%]"),
            kind="number",
            cell=lambda line: "" if line.share is None else share_cell(line.share),
        ),
        Field(
            head="\N{GREEK SMALL LETTER NU}",
            cell=lambda line: line.degrees_of_freedom,
            optional=True,
        ),
    )
    return table_of(
        _lines(group),
        fields,
        name=f"budget-{group.sensor}-{group.parameter}".replace("_", "-"),
        caption=say("Budget of the {group}", group=group.title),
        by=lambda line: line.axes,
        titled=len(group.alike) > 1,
        is_wide=True,
    )


def budget_title(group: GroupTable) -> str:
    """Name a group with its unit, and with its axes where all agree."""
    axes = f" {_axes(group, range(len(group.rows)))}" if len(group.alike) == 1 else ""
    return f"{capital(group.title)}{axes} [{group.unit}]"


def budget_remarks(group: GroupTable, *, checked: bool = True) -> Iterator[Paragraph]:
    """Yield what the numbers of a group lack, do not do, and how they were checked."""
    if group.gaps:
        yield Paragraph(words=(say("{gaps}.", gaps=capital(group.gaps)),), small=True)
    if idle := say(", ").join(row.title for row in group.sources if row.is_idle):
        yield Paragraph(
            words=(say("Without effect, to rounding: {idle}.", idle=idle),), small=True
        )
    if minor := say(", ").join(row.title for row in group.minor):
        text = say("Below 0.1 % of the variance each: {minor}.", minor=minor)
        yield Paragraph(words=(text,), small=True)
    if by := next((row.u_by for row in group.rows if row.u_by), ""):
        text = say(
            "Rows of sources are by the law, mean error and combined u by {by}: they "
            "do not add up exactly.",
            by=say(by),
        )
        yield Paragraph(words=(text,), small=True)
    if checked and group.validation:
        yield Paragraph(
            words=(say("The law checked {validation}.", validation=group.validation),),
            small=True,
        )


def _lines(group: GroupTable) -> Iterator[Line]:
    """Yield the rows of all axes."""
    for parts in group.alike:
        places = sorted(place for part in parts for place in part)
        axes = _axes(group, places)
        # Equal in print, so that any of them stands for all; the first it is.
        first = places[0]
        for source in group.major:
            if source.cells[first].u.text != "0":
                yield _source_line(source, first, axes)
        if minor := group.minor:
            together = group.gathered(places)
            yield Line(
                axes=axes,
                head=say("{minor} others together", minor=len(minor)),
                linear=together.u,
                share=together.share.exact,
            )
        for part in parts:
            of = say(" ({axes})", axes=_axes(group, part)) if len(parts) > 1 else ""
            yield from _total_lines(group, group.rows[part[0]], axes, of)


def _axes(group: GroupTable, places: Sequence[int]) -> str:
    """Name the axes of some outputs."""
    return say(", ").join(group.rows[place].axis for place in places)


def _source_line(source: SourceRow, place: int, axes: str) -> Line:
    """Return one source of one axis."""
    part = source.cells[place]
    own = source.quantity
    if own is None or part.linear is None:
        return Line(axes=axes, head=source.title, linear=part.u, share=part.share.exact)
    curved = part.linear.text != part.u.text
    return Line(
        axes=axes,
        head=source.title,
        given=_given(own),
        distribution=say(own.distribution),
        divisor="" if own.divisor is None else print_divisor(own.divisor),
        u_input=part.u_input,
        unit=own.unit,
        c=part.c,
        linear=part.linear,
        whole=say("{u} with second order", u=part.u.text) if curved else "",
        share=part.share.exact,
        degrees_of_freedom=print_degrees_of_freedom(own.degrees_of_freedom),
    )


def _given(own: InputQuantity) -> str:
    """Say what is printed, what it means, and whose it is where it is another's."""
    said = [own.printed, say(own.meaning), say(own.origin)]
    if own.readings:
        said.append(say("largest of {readings} readings", readings=own.readings))
    return say(", ").join(filter(None, said))


def _total_lines(
    group: GroupTable, row: OutputRow, axes: str, of: str
) -> Iterator[Line]:
    """Yield the combined uncertainty, the interval and what both are of."""
    coverage = print_coverage(group.coverage)
    u_by, by = (
        say(", by {by}{of}", by=say(method or "the law"), of=of)
        if row.u_by or method
        else of
        for method in (row.u_by, row.by)
    )
    if row.mean.text != UNKNOWN and float(row.mean.text):
        yield Line(axes=axes, head=say("mean error{of}", of=u_by), linear=row.mean)
    yield Line(
        axes=axes,
        head=say("combined u{by}", by=u_by),
        linear=row.u,
        degrees_of_freedom=row.degrees_of_freedom,
        strong=True,
    )
    k = "" if row.k is None else f"k = {row.k.text}"
    if row.is_centred:
        yield Line(
            axes=axes,
            head=f"U{coverage}{by}" if row.k is None else f"U{coverage} = k u{by}",
            given=k,
            linear=row.expanded,
            strong=True,
        )
        return
    for head, end in (("from", row.low), ("to", row.high)):
        yield Line(
            axes=axes,
            head=say(
                "{coverage} % interval from{by}"
                if head == "from"
                else "{coverage} % interval to{by}",
                coverage=coverage,
                by=by,
            ),
            given=k if head == "from" else "",
            linear=end,
            strong=True,
        )
