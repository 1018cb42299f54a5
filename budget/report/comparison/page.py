"""A comparison as a document, and as sections of a report on one device."""

from __future__ import annotations

from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from budget.language import Note
from budget.names import MISSION
from budget.report.blocks import Abreast, Document, ForPages, Paragraph
from budget.report.comparison.document import to_json
from budget.report.comparison.figures import (
    front_picture,
    map_chart,
    margin_chart,
    no_front,
    no_fronts,
)
from budget.report.comparison.tables import (
    merit_points,
    print_conformance,
    rank_of,
    rankings,
    side_by_side,
)
from budget.report.figures.rows import chart_picture
from budget.report.pages import blocks, document, sections
from budget.report.provenance import provenance_section
from budget.report.readings import verdict_line
from budget.report.tables import AT_LEAST, print_chance, settings_lines, used_part
from budget.report.wording import (
    deciding_lines,
    doubt_sentence,
    error_reference,
    mode_remark,
    mode_sentence,
    parted,
    standing_lines,
)
from budget.results import VERDICTS
from budget.studies.comparison.records import NUMBERED
from budget.studies.figures_of_merit import MERITS
from budget.studies.prediction import LEAST_DESIGNS
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.report.blocks import Block, Picture, Section
    from budget.report.comparison.tables import Ranking, Row
    from budget.studies.comparison.records import Comparison

COMMAND = "budget compare"
PAIRS_SHOWN = 20
FEW = 2  # devices that are named, even where they are all
DASH = "\N{EN DASH}"  # a factor that is not there


def comparison_document(
    comparison: Comparison, *, date: str, command_line: str = COMMAND
) -> Document:
    """Put a comparison into one document, the answer first."""
    found = rankings(comparison)
    margins = ForPages(lambda: map(_margins, filter(attrgetter("rows"), found)))
    page = document(
        "comparison",
        margins=Abreast(blocks=(margins,)),
        **_view(comparison, found, drawn=_drawn),
    )
    provenance = provenance_section(
        comparison.inputs,
        comparison.settings,
        version=__version__,
        command_line=command_line,
    )
    return page.whole("comparison", provenance, json=to_json(comparison), date=date)


def comparison_sections(comparison: Comparison) -> tuple[Section, ...]:
    """Return the sections that stand inside a report on something else.

    The answer and how it was computed, the devices sensor by sensor, pairs, what the
    files leave to be assumed, and what to beware of.
    """
    return _answer(comparison, rankings(comparison), is_apart=True)


def comparison_answer(
    comparison: Comparison, *, order: Callable[[Row], Any] | None = None
) -> tuple[Section, ...]:
    """Return what stands alone on a terminal: the same, and the settings.

    The rows of a ranking are sorted by `order`, in place of the rank.
    """
    return _answer(comparison, rankings(comparison, order=order), is_apart=False)


def _answer(
    comparison: Comparison, found: Sequence[Ranking], *, is_apart: bool
) -> tuple[Section, ...]:
    """Return the sections that report and terminal have in common."""
    view = _view(comparison, found, drawn=partial(_drawn, has_margins=True))
    return sections("comparison_answer", is_apart=is_apart, **view)


def _view(
    comparison: Comparison,
    found: Sequence[Ranking],
    *,
    drawn: Callable[[Ranking], Iterable[Block]],
) -> dict[str, Any]:
    """Return what the pages are given: records, and how they are written."""
    settings = comparison.settings
    names = {one.name for one in comparison.devices}
    is_refused = settings.missing == "refuse"
    return {
        "comparison": comparison,
        "found": found,
        "drawn": lambda table: ForPages(lambda: drawn(table)),
        "side_by_side": partial(side_by_side, found),
        "reference": error_reference(settings),
        "remark": mode_remark(settings),
        "filling": mode_sentence(settings),
        "settled": settings_lines(settings),
        "standing": _standing(comparison) if is_refused else (),
        "replaced": () if is_refused else _replaced(comparison),
        "over_caps": dict.fromkeys(
            (one.name, text) for one in comparison.entrants for text in one.over_caps
        ),
        "unknown_caps": list(_unknown_caps(comparison)),
        "assumed": _assumed(comparison.assumptions, names),
        "compared": len(names),
        "deciding_lines": deciding_lines,
        "doubt_sentence": doubt_sentence,
        "print_chance": print_chance,
        "print_conformance": print_conformance,
        "rank_of": rank_of,
        "verdict_line": verdict_line,
        "AT_LEAST": AT_LEAST,
        "DASH": DASH,
        "FEW": FEW,
        "LEAST_DESIGNS": LEAST_DESIGNS,
        "MISSION": MISSION,
        "NUMBERED": NUMBERED,
        "PAIRS_SHOWN": PAIRS_SHOWN,
    }


def _together(found: Iterable[tuple[Any, str]]) -> list[tuple[Any, list[str]]]:
    """Gather names by what they have in common, each once, in order of the first."""
    names: dict[Any, dict[str, None]] = {}
    for common, name in found:
        names.setdefault(common, {})[name] = None
    return [(common, list(own)) for common, own in names.items()]


def _standing(comparison: Comparison) -> list[tuple[Any, list[str]]]:
    """Return what the verdicts hold if, and whom to ask for what, with the devices.

    Decided ones first, of devices that do not fail in any case.
    """
    return _together(
        ((one.sensor, lines), one.name)
        for one in sorted(
            comparison.entrants, key=lambda one: VERDICTS.index(one.verdict)
        )
        if one.standing.saturates or one.verdict != "fails"
        for said in [deciding_lines if one.standing.saturates else standing_lines]
        if (lines := said(one.standing))
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
    return _together(
        ((assumed, tuple(devices)), line)
        for (line, assumed), devices in _together(found)
    )


def _margins(table: Ranking) -> Picture:
    """Draw how far every device is from its limit."""
    return chart_picture(margin_chart(table, f"margins-{table.name}"))


def _drawn(table: Ranking, *, has_margins: bool = False) -> Iterator[Block]:
    """Yield the figures of a ranking: where devices are beyond limits, at what cost.

    A front for each cost of which there are two different amounts.
    """
    outputs = _data("outputs", table=table, used_part=used_part)
    yield chart_picture(map_chart(table, f"map-{table.name}", outputs))
    pictures = [_margins(table)] if has_margins else []
    for merit in MERITS:
        if not no_front(table, merit):
            points = merit_points(table, merit)
            data = _data("front", table=table, merit=merit, points=points)
            name = f"front-{merit}-{table.name}"
            pictures.append(front_picture(table, merit, name, data))
    if pictures:
        yield Abreast(blocks=tuple(pictures))
    if why_not := no_fronts(table):
        yield Paragraph(words=(why_not,), small=True)


def _data(macro: str, **view: object) -> Any:  # noqa: ANN401 - a table, of all blocks
    """Return a table behind a figure."""
    return blocks("comparison_data", macro, **view)[0]
