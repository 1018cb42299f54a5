"""Station section of a report: what table, place, timing, environment make of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import fsum, sqrt
from typing import TYPE_CHECKING

from budget.inputs.use import LINES
from budget.language import counted, key_title, say, term, words
from budget.model.sources import ENVIRONMENT, SENSORS, STATION, source_of
from budget.report.blocks import (
    Cell,
    Field,
    Listing,
    Panel,
    Paragraph,
    Section,
    table_of,
)
from budget.report.tables import (
    NO_SHARE,
    SMALL_SHARE,
    Number,
    bound_number,
    print_contributions,
    print_coverage,
    print_share,
    print_utilisation,
    source_title,
    used_part,
)
from budget.report.wording import capital, share_cell
from budget.results import INTERACTION
from budget.studies.request import SHARED, given_lines
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from budget.inputs.records import ErrorLine, Procedure
    from budget.names import Name
    from budget.report.blocks import Block, Table, Words
    from budget.report.tables import GroupTable
    from budget.results import Assessment, Budget, OutputAssessment, OutputBudget
    from budget.studies.cautions import Unfelt

LEAST_SAID = 0.001  # share of a variance that is printed as a number [1]
OWN = term("the sensors' own lines")
TITLES = {STATION: term("test station"), ENVIRONMENT: term("environment")}
PRODUCTS = term("products of two sources")


def station_section(
    budget: Budget,
    groups: Sequence[GroupTable],
    procedure: Procedure,
    assessment: Assessment | None,
    unfelt: Sequence[Unfelt],
) -> Section | None:
    """Return what the station and the environment make of the budget.

    None where the procedure gives no line of either.
    """
    lines = {
        name: line
        for name, line in given_lines((), procedure).items()
        # A use as in the test is stated, and makes nothing.
        if line.u.any() or name.quantity not in LINES
    }
    if not lines:
        return None
    owners = [one for one in SHARED if any(name.owner == one for name in lines)]
    finding = say(" ").join(_findings(budget, owners, lines, assessment))
    shares = _shares_table(budget, groups, owners, lines, unfelt)
    # Not in a panel: as long as it is, it may break over pages.
    blocks: list[Block] = [
        Paragraph(words=(finding,)),
        Paragraph(words=(say("Shares of the variance of each group:"),), small=True),
        shares,
    ]
    if assessment is not None:
        blocks += _limits(budget, owners, assessment)
    if reasons := _reasons(unfelt):
        listing = Listing(items=reasons, empty="")
        blocks.append(Panel(title=say("What does nothing"), blocks=(listing,)))
    title = capital(say(" and ").join(say(TITLES[owner]) for owner in owners))
    return Section(name="station", title=title, blocks=tuple(blocks))


def _findings(
    budget: Budget,
    owners: Sequence[str],
    lines: Mapping[Name, ErrorLine],
    assessment: Assessment | None,
) -> list[str]:
    """Say where they take most, by what, and what is left to the sensors."""
    who = capital(say("the {owners}", owners=say(" and the ").join(map(say, owners))))
    several = len(owners)
    shares = [_share(row, *owners) for row in budget.outputs]
    row = budget.outputs[first_largest(shares)]
    most = max(shares)
    if not any(source_of(name.owner, name.quantity).varies for name in lines):
        by = say(", ").join(dict.fromkeys(_partner(name) for name in lines))
        return [
            say(
                "What is given of {who} is known: it acts by {by} alone.",
                who=who.lower(),
                by=by,
            )
        ]
    if most <= NO_SHARE:
        return [
            counted(
                several,
                "{who} takes nothing of U of any output.",
                "{who} take nothing of U of any output.",
                who=who,
            )
        ]
    if most < LEAST_SAID:
        return [
            counted(
                several,
                "{who} takes less than 0.1 % of the square of U of every output.",
                "{who} take less than 0.1 % of the square of U of every output.",
                who=who,
            )
        ]
    parts = [
        (source_title(part.source), part.share)
        for part in row.ranked
        if part.source.owner in owners
    ]
    by = print_contributions(parts) if parts[0][1] >= SMALL_SHARE else parts[0][0]
    known = say(", of what is known") if row.lower_bound else ""
    own = print_share(_share(row, *SENSORS))
    found = [
        (
            counted(
                several,
                "{who} takes up to {most} of the square of U{known}: of the {name}, by "
                "{by}; {sensors} take {own}.",
                "{who} take up to {most} of the square of U{known}: of the {name}, by "
                "{by}; {sensors} take {own}.",
                who=who,
                most=print_share(most),
                known=known,
                name=key_title(row.output.name),
                by=by,
                sensors=say(OWN),
                own=own,
            )
        )
    ]
    if assessment is not None and (rows := _judged(budget, assessment)):
        worst = rows[first_largest([one.used_by(owners).exact for one in rows])]
        found.append(
            counted(
                several,
                "Alone it uses at most {used} of a limit, that of the {name}, where "
                "{sensors} alone use {own}.",
                "Alone they use at most {used} of a limit, that of the {name}, where "
                "{sensors} alone use {own}.",
                used=worst.used_by(owners).text,
                name=key_title(worst.row.output.name),
                sensors=say(OWN),
                own=worst.used_by(SENSORS).text,
            )
        )
    return found


def _share(row: OutputBudget, *owners: str) -> float:
    """Return the share of those owners in the variance of an output."""
    if not row.is_resolved:
        return 0.0
    return fsum(part.share for part in row.contributions if part.source.owner in owners)


@dataclass(frozen=True, kw_only=True)
class _Line:
    """A line of the table of shares."""

    of: str  # the title that it stands under
    head: str
    figure: Cell  # as it is given
    where: Cell  # the output of whose variance it makes most
    shares: tuple[float, ...]  # of the variance, by group of outputs


def _shares_table(
    budget: Budget,
    groups: Sequence[GroupTable],
    owners: Sequence[str],
    lines: Mapping[Name, ErrorLine],
    unfelt: Sequence[Unfelt],
) -> Table:
    """Return every line of station and environment, with its share of each group."""
    idle = {
        one.source: Cell(
            text=say("nothing"), note=say("to first order") if one.removed else ""
        )
        for one in unfelt
    }
    records = [
        _Line(
            of=name.owner,
            head=source_title(name),
            figure=Cell(text=line.printed, note=line.meaning),
            where=idle.get(name) or _where(budget, name),
            shares=tuple(
                fsum(row.share.exact for row in group.sources if row.source == name)
                for group in groups
            ),
        )
        for name, line in lines.items()
    ]
    nothing = Cell(text="")
    records += [
        _Line(
            of="together",
            head=head,
            figure=nothing,
            where=nothing,
            shares=tuple(
                fsum(row.share.exact for row in group.sources if belongs(row.source))
                for group in groups
            ),
        )
        for head, belongs in (
            *(
                (say("the {owner}", owner=say(owner)), partial(_is_of, (owner,)))
                for owner in owners
            ),
            (say(OWN), partial(_is_of, SENSORS)),
            (say(PRODUCTS), partial(_is_of, (INTERACTION.owner,))),
        )
    ]

    def share(place: int, record: _Line) -> Cell:
        found = record.shares[place]
        return share_cell(found) if found > NO_SHARE else nothing

    return table_of(
        records,
        (
            Field[_Line](head="", weight=1.6, cell=lambda one: one.head),
            Field[_Line](head=say("figure"), weight=1.2, cell=lambda one: one.figure),
            Field[_Line](
                head=say("acts most on"), weight=1.8, cell=lambda one: one.where
            ),
            *(
                Field[_Line](
                    head=f"{group.title} [%]", kind="number", cell=partial(share, k)
                )
                for k, group in enumerate(groups)
            ),
        ),
        name="station-shares",
        caption=say("Shares of the variance of each group, by line of the station"),
        by=lambda one: one.of,
        titled=True,
        is_wide=True,
    )


def _is_of(owners: Sequence[str], source: Name) -> bool:
    """Whether a source is of one of those owners."""
    return source.owner in owners


def _where(budget: Budget, name: Name) -> Cell:
    """Return the output of whose variance a source makes most, and how much."""
    if budget.settings.only and name not in budget.settings.only:
        return Cell(text=say("left out"))
    if not source_of(name.owner, name.quantity).varies:
        return Cell(text=say("known; acts by {partner}", partner=_partner(name)))
    shares = [
        fsum(part.share for part in row.contributions if part.source == name)
        if row.is_resolved
        else 0.0
        for row in budget.outputs
    ]
    if max(shares, default=0.0) <= NO_SHARE:
        return Cell(text=say("nothing"))
    row = budget.outputs[first_largest(shares)]
    return Cell(text=key_title(row.output.name), note=print_share(max(shares)))


def _partner(name: Name) -> str:
    """Return the line of a sensor that a known size acts by."""
    effect = source_of(name.owner, name.quantity).effect
    return say(" and ").join(map(words, getattr(effect, "partners", ())))


@dataclass(frozen=True, kw_only=True)
class _Judged:
    """A required output, and what it is made of."""

    row: OutputBudget
    limit: OutputAssessment

    def used_by(self, owners: Sequence[str]) -> Number:
        """Return U by the sources of those owners alone, over the limit."""
        low, high = self.limit.interval
        k = 0.5 * (high - low) / self.limit.standard_uncertainty
        variance = fsum(
            part.standard_uncertainty**2
            for part in self.row.contributions
            if part.source.owner in owners
        )
        u = sqrt(variance)
        used = k * u / self.limit.limit if u > self.row.output.resolution else 0.0
        return bound_number(
            Number(text=print_utilisation(used) if used else "0 %", exact=used),
            lower_bound=self.row.lower_bound and owners == SENSORS,
        )


def _judged(budget: Budget, assessment: Assessment) -> list[_Judged]:
    """Return the required outputs that have any spread."""
    rows = {row.output.name: row for row in budget.outputs}
    found = [
        _Judged(row=rows[one.output.name], limit=one)
        for one in assessment.judged
        if one.output.name in rows  # not those of a mission
    ]
    return [one for one in found if one.row.is_resolved]


def _limits(
    budget: Budget, owners: Sequence[str], assessment: Assessment
) -> Iterator[Panel]:
    """Yield what each part alone uses of the limits, where the station uses most."""
    groups: dict[Name, list[_Judged]] = {}
    for one in _judged(budget, assessment):
        groups.setdefault(one.row.output.name.group, []).append(one)
    if not groups:
        return
    records = [
        rows[first_largest([row.used_by(owners).exact for row in rows])]
        for rows in groups.values()
    ]
    coverage = print_coverage(budget.settings.coverage)

    def used(head: str, pick: Callable[[_Judged], Number]) -> Field[_Judged]:
        def percent(one: _Judged) -> Cell:
            number = pick(one)
            text = number.text.removesuffix(" %")
            return Cell(text=text, exact=number.exact)

        return Field(head=f"{head} [%]", kind="number", cell=percent)

    table = table_of(
        records,
        (
            Field[_Judged](
                head=say("output"),
                cell=lambda one: key_title(one.row.output.name),
            ),
            Field[_Judged](head=say("limit"), cell=lambda one: one.limit.printed_limit),
            *(
                used(
                    say("the {owner}", owner=say(owner)),
                    partial(_Judged.used_by, owners=(owner,)),
                )
                for owner in owners
            ),
            used(say(OWN), partial(_Judged.used_by, owners=SENSORS)),
            used(say("all"), lambda one: used_part(one.limit)),
        ),
        name="station-limits",
        caption=say("What station and sensors alone use of the limits"),
    )
    yield Panel(
        title=say("U{coverage} of each part alone, of the limit", coverage=coverage),
        blocks=(
            table,
            Paragraph(
                words=(
                    (
                        say(
                            "Of each group of limits the output where {who} alone "
                            "would take most. The squares of the parts add up.",
                            who=say("the {owners}", owners=say(owners[0]))
                            if len(owners) == 1
                            else say("both"),
                        )
                    ),
                ),
                small=True,
            ),
        ),
    )


def _reasons(unfelt: Sequence[Unfelt]) -> tuple[Words, ...]:
    """Say of what reaches nothing why, those of one reason together."""
    by_reason: dict[str, list[str]] = {}
    for one in unfelt:
        if one.source.owner in SHARED:
            reason = (
                say("removed by {removed}, to first order", removed=say(one.removed))
                if one.removed
                else say("takes {needs}", needs=say(one.needs))
            )
            by_reason.setdefault(reason, []).append(source_title(one.source))
    return tuple(
        (
            say(
                "{names}: {reason}.",
                names=capital(say(", ").join(names)),
                reason=reason,
            ),
        )
        for reason, names in by_reason.items()
    )
