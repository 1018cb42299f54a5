"""The largest causes of a budget, in words with numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.tables import SMALL_SHARE, output_title, source_title
from budget.studies.request import given_lines, sensors_of
from budget.ties import first_largest, from_largest, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.names import Name
    from budget.report.tables import GroupTable, Number
    from budget.results import Assessment
    from budget.spec.records import Device, ErrorLine, Procedure

SIGMAS = ("1 sigma", "2 sigma", "3 sigma", "rms", "typical")
CAUSES = 5  # as many as a reader keeps in mind


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What a source makes of the variance of one group of parameters."""

    share: Number
    group: str
    u: Number  # of the source alone, on the axis where it is largest
    unit: str


@dataclass(frozen=True, kw_only=True)
class Cause:
    """One source, and what it makes of every group where it counts."""

    title: str
    printed: str  # the line of the data sheet; '' where it has none
    effects: tuple[Effect, ...]


def rank_causes(
    groups: Sequence[GroupTable],
    devices: Sequence[Device],
    procedure: Procedure,
    assessment: Assessment | None,
) -> tuple[Cause, ...]:
    """Return the largest causes, each with what it makes of every group.

    Ranked by the largest share of a group's variance; with a requirement by that share
    of the group's utilisation, those of groups beyond their limits before all others.
    """
    weight = _weights(groups, assessment)
    given = given_lines(sensors_of(devices), procedure)
    effects: dict[tuple[str, Name], list[tuple[tuple[bool, float], Effect]]] = {}
    for group in groups:
        used = weight[group.title]
        for row in group.sources:
            if row.share.exact < SMALL_SHARE:
                continue
            effect = Effect(
                share=row.share,
                group=group.title,
                u=row.cells[first_largest([c.u.exact for c in row.cells])].u,
                unit=group.unit,
            )
            order = (settle(used) > 1.0, used * row.share.exact)
            owner = row.source.owner or group.sensor
            effects.setdefault((owner, row.source), []).append((order, effect))
    causes = list(effects.items())
    ranked = _from_largest([max(order for order, _ in found) for _, found in causes])
    return tuple(
        Cause(
            title=f"{owner} {source_title(source)}",
            printed=_as_meant(given[source]) if source in given else "",
            effects=tuple(
                found[k][1] for k in _from_largest([order for order, _ in found])
            ),
        )
        for (owner, source), found in (causes[k] for k in ranked[:CAUSES])
    )


def _from_largest(orders: Sequence[tuple[bool, float]]) -> list[int]:
    """Return places, those beyond a limit first, then from the largest weight down."""
    places: list[int] = []
    for is_beyond in (True, False):
        own = [k for k, (beyond, _) in enumerate(orders) if beyond == is_beyond]
        places += [own[k] for k in from_largest([orders[k][1] for k in own])]
    return places


def _weights(
    groups: Sequence[GroupTable], assessment: Assessment | None
) -> dict[str, float]:
    """Return the utilisation of each group, or 1 where nothing is required of any."""
    idle = 1.0 if assessment is None else 0.0
    weight = dict.fromkeys((group.title for group in groups), idle)
    for required in assessment.outputs if assessment else ():
        title = output_title(required.output.name.group)
        weight[title] = max(weight[title], required.utilisation)
    return weight


def _as_meant(line: ErrorLine) -> str:
    """'0.06 deg/h, 3 sigma': a figure with its meaning, where not 1 sigma.

    With its distribution, where that is not the one that the meaning says already.
    """
    words = [line.printed]
    if line.meaning != "1 sigma":
        words.append(line.meaning)
    if line.definition not in {"", "sigma"}:
        words.append(line.definition.replace("_", " "))
    usual = "normal" if line.meaning in SIGMAS else "uniform"
    words += [
        name
        for name in dict.fromkeys(d.name for d in line.distributions)
        if name != usual
    ]
    return ", ".join(words)
