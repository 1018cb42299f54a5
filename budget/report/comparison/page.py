"""A comparison as a document, and as sections of a report on one device."""

from __future__ import annotations

from collections import Counter
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING, Any

from budget.documents import document as document_of
from budget.known import AT_LEAST
from budget.language import Note
from budget.missing.prediction import LEAST_DESIGNS
from budget.names import MISSION
from budget.report.blocks import Document, ForPages, Paragraph
from budget.report.comparison.figures import (
    front_plot,
    map_chart,
    no_fronts,
)
from budget.report.comparison.tables import (
    print_conformance,
    rankings,
    requests,
    side_by_side,
    tallies,
)
from budget.report.document import json_pieces
from budget.report.figures.rows import chart_picture
from budget.report.figures.tabled import Plot
from budget.report.pages import blocks, document, line, lines, sections
from budget.report.provenance import provenance_section
from budget.report.standing import (
    deciding_lines,
    error_reference,
    mode_remark,
    mode_sentence,
    parted,
    standing_lines,
)
from budget.report.tables import print_chance, settings_lines, used_part
from budget.results import VERDICTS
from budget.studies.comparison.records import NUMBERED
from budget.studies.figures_of_merit import MERITS, over_cap

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.report.blocks import Block, Section
    from budget.report.comparison.tables import Ranking, Request
    from budget.studies.comparison.records import Comparison, Entrant

PAIRS_SHOWN = 20
FEW = 2  # devices that are named, even where they are all
MANY = 6  # names in a sentence; of more, some are counted
BEST = 3  # devices of each sensor in a brief answer


def comparison_document(
    comparison: Comparison, *, date: str, command_line: str = "budget compare"
) -> Document:
    """Put a comparison into one document, the answer first."""
    page = document("comparison", **_view(comparison, rankings(comparison)))
    provenance = provenance_section(
        comparison.inputs,
        comparison.settings,
        command_line=command_line,
    )
    text = "".join(json_pieces(document_of(comparison)))
    return page.whole("comparison", provenance, json=text, date=date)


def comparison_sections(comparison: Comparison) -> tuple[Section, ...]:
    """Return the sections that stand inside a report on something else.

    The answer and how it was computed, who meets, whom to ask, what to beware of,
    figures, pairs, and what the files leave to be assumed.
    """
    view = _view(comparison, rankings(comparison))
    return sections("comparison_answer", is_apart=True, **view)


def comparison_answer(
    comparison: Comparison,
    *,
    order: Callable[[Entrant], Any] | None = None,
    full: bool = False,
) -> tuple[Section, ...]:
    """Return what stands alone on a terminal: the answer, or with `full` all there is.

    The rows of a ranking are sorted by `order`, in place of the rank.
    """
    found = rankings(comparison, order=order)
    if full:
        view = _view(comparison, found, is_paged=False)
        return sections("comparison_answer", is_apart=False, **view)
    asked = [
        (sensor, [name for one in own for name in one.names], _most_asked(own))
        for sensor, own in _by_sensor(requests(comparison))
    ]
    best = [(table, table.first(BEST)) for table in found]
    view = _said(comparison, found) | {"best": best, "asked": asked, "MANY": FEW + 1}
    return sections("comparison_brief", **view)


def _by_sensor(found: Iterable[Request]) -> Iterator[tuple[str, list[Request]]]:
    """Part requests by sensor, those apart of which nothing at all is given."""
    for (sensor, _), own in groupby(
        sorted(found, key=lambda one: not one.lines),
        lambda one: (one.sensor, not one.lines),
    ):
        yield sensor, list(own)


def _most_asked(found: Sequence[Request]) -> list[str]:
    """Return the specifications to ask for, those of the most devices first."""
    counts = Counter(
        name for one in found for name in one.lines for _ in range(len(one.names))
    )
    sensor = found[0].sensor
    return [
        line("comparison_parts", "of_many", name=name, sensor=sensor, times=times)
        for name, times in counts.most_common(FEW + 1)
    ]


def _said(comparison: Comparison, found: Sequence[Ranking]) -> dict[str, Any]:
    """Return what every answer is given."""
    beside = _beside(comparison, found)
    return {
        "comparison": comparison,
        "found": found,
        "tallies": tallies(comparison),
        "compared": len({one.place for one in comparison.listed}),
        "deciding": beside["deciding"],
        "qualifying": beside["cautions"],
        "elsewhere": _elsewhere(comparison, beside["cautions"]),
        "over_caps": _over_caps(comparison),
        "unknown_caps": list(_unknown_caps(comparison)),
        "reference": error_reference(comparison.settings),
        "remark": mode_remark(comparison.settings),
        "filling": mode_sentence(comparison.settings),
        "print_chance": print_chance,
        "print_conformance": print_conformance,
        "AT_LEAST": AT_LEAST,
        "FEW": FEW,
        "MANY": MANY,
        "MISSION": MISSION,
        "NUMBERED": NUMBERED,
    }


def _view(
    comparison: Comparison, found: Sequence[Ranking], *, is_paged: bool = True
) -> dict[str, Any]:
    """Return what the pages are given: records, and how they are written."""
    settings = comparison.settings
    names = {one.name for one in comparison.listed}
    is_refused = settings.missing == "refuse"
    caps = dict(comparison.caps)
    return _said(comparison, found) | {
        "is_paged": is_paged,
        "requests": requests(comparison),
        "caps": caps,
        "is_over": lambda merit, text: bool(
            merit in caps and over_cap(merit, text, caps[merit])
        ),
        "drawn": lambda table: ForPages(lambda: _drawn(table)),
        "not_drawn": ForPages(
            lambda: _not_drawn([one for one in found if one.decided])
        ),
        "side_by_side": partial(side_by_side, found),
        "settled": settings_lines(settings),
        "standing": _standing(comparison, is_refused=is_refused),
        "replaced": () if is_refused else _replaced(comparison),
        "named_devices": len(names),
        "assumed": _assumed(comparison.assumptions, names),
        "LEAST_DESIGNS": LEAST_DESIGNS,
        "PAIRS_SHOWN": PAIRS_SHOWN,
    }


def _together(found: Iterable[tuple[Any, str]]) -> list[tuple[Any, list[str]]]:
    """Gather names by what they have in common, each once, in order of the first."""
    names: dict[Any, dict[str, None]] = {}
    for common, name in found:
        names.setdefault(common, {})[name] = None
    return [(common, list(own)) for common, own in names.items()]


def _standing(
    comparison: Comparison, *, is_refused: bool
) -> list[tuple[Any, list[str]]]:
    """Return what the verdicts of devices that do not fail hold if, with the devices.

    Of what cannot be judged the lines to ask for stand elsewhere; of what others stand
    for, saturation alone is said here.
    """
    return _together(
        ((one.sensor, lines), one.name)
        for one in sorted(
            comparison.entrants, key=lambda one: VERDICTS.index(one.verdict)
        )
        if one.saturates or (is_refused and one.verdict not in {"undecidable", "fails"})
        for said in [deciding_lines if one.saturates else standing_lines]
        if (lines := said(one))
    )


def _beside(
    comparison: Comparison, found: Sequence[Ranking]
) -> dict[str, list[tuple[Any, list[str]]]]:
    """Return what decides of the best devices, and what qualifies it, with the names.

    Of those that fail their row says why; one that saturates is nowhere left out.
    """
    best = [row.of for table in found for row in table.first(BEST)]
    lost = [one for one in comparison.nothing_known if one.saturates]
    shown = [one for one in (*best, *lost) if one.verdict != "fails"]
    return {
        macro: _together(
            ((one.sensor, text), one.name)
            for one in shown
            for text in lines("standing", macro, standing=one)
        )
        for macro in ("deciding", "cautions")
    }


def _elsewhere(
    comparison: Comparison, shown: Iterable[tuple[Any, list[str]]]
) -> list[str]:
    """Return the devices with cautions that are not among those shown."""
    named = {name for _, names in shown for name in names}
    own = (one.name for one in comparison.entrants if one.cautions)
    return [name for name in dict.fromkeys(own) if name not in named]


def _over_caps(comparison: Comparison) -> list[tuple[Any, list[str]]]:
    """Return the caps that devices exceed, with those that do not fail anyway."""
    return _together(
        (text, one.name)
        for one in comparison.entrants
        if one.verdict != "fails"
        for text in one.over_caps
    )


def _replaced(comparison: Comparison) -> list[tuple[Any, list[str]]]:
    """Return lines that are not given, what stands for them, and the devices.

    And whether the technology is known, by which others are comparable.
    """
    return _together(
        ((one.sensor, lacks.lines, lacks.filling.lines, bool(one.technology)), one.name)
        for one in comparison.entrants
        if (lacks := one.missing) is not None
    )


def _unknown_caps(
    comparison: Comparison,
) -> Iterator[tuple[str, str, list[tuple[str, str]]]]:
    """Yield the caps that nobody knows of some devices whether they exceed them.

    With their names, and what their makers say that cannot be held against a cap.
    """
    for merit, cap in comparison.caps:
        found = {  # one for both sensors of a device, under every procedure
            one.place: (one.name, unknown.text)
            for one in comparison.entrants
            for unknown in one.unknown_caps
            if unknown.merit == merit
        }
        if found:
            yield merit, cap, list(found.values())


def _assumed(texts: Iterable[str], names: Iterable[str]) -> list[tuple[Any, list[str]]]:
    """Return what the files leave to be assumed and of which devices, with the lines.

    An assumption reads 'device: line: what is assumed'; those of a procedure or of
    the requirement name no device.
    """
    longest = sorted(names, key=len, reverse=True)
    found = []
    for text in texts:
        device = next((name for name in longest if text.startswith(f"{name}: ")), "")
        said = text.removeprefix(f"{device}: ") if device else text
        own = text.parts.get("text") if device and isinstance(text, Note) else None
        found.append((parted(own if isinstance(own, str) else said), device))
    if len(longest) > MANY:  # by what is assumed alone: the document has each
        owners = dict(_together((assumed, device) for (_, assumed), device in found))
        return _together(
            ((assumed, tuple(owners[assumed])), line) for (line, assumed), _ in found
        )
    return _together(
        ((assumed, tuple(devices)), line)
        for (line, assumed), devices in _together(found)
    )


def _drawn(table: Ranking) -> Iterator[Block]:
    """Yield the figures of a ranking: what devices use of each limit, at what cost.

    A front for each cost of which there are two different amounts.
    """
    if (
        table.measured and len(table.devices[0].outputs) > 1
    ):  # of one the ranking has it
        outputs = _data("outputs", table=table, used_part=used_part)
        yield chart_picture(map_chart(table, f"map-{table.name}", outputs))
    for merit in MERITS:
        front = front_plot(table, merit)
        if isinstance(front, Plot):
            yield front.picture


def _not_drawn(found: Sequence[Ranking]) -> Iterator[Block]:
    """Say which fronts are not drawn, and why, once where that is the same for all."""
    why = {
        table.subject: no_fronts(
            {
                merit: front if isinstance(front, str) else ""
                for merit in MERITS
                for front in [front_plot(table, merit)]
            }
        )
        for table in found
    }
    if len({*why.values()}) == 1:
        why = {"": next(iter(why.values()))}
    for subject, text in why.items():
        if text:
            said = line("figures_comparison", "of_one", subject=subject, text=text)
            yield Paragraph(words=(said,), small=True)


def _data(macro: str, **view: object) -> Any:  # noqa: ANN401 - a table, of all blocks
    """Return a table behind a figure."""
    return blocks("comparison_data", macro, **view)[0]
