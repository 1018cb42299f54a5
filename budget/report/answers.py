"""The answer of a command as a document: headline, summary, cards, sections."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import takewhile
from math import ceil, floor, log10
from typing import TYPE_CHECKING

from budget.report.blocks import Panel, Paragraph, Run, Section, Table
from budget.report.pages import document

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Block, Document, Words

LEAST_ROWS = 2  # of a figure: one bar says no more than its number


@dataclass(frozen=True, kw_only=True)
class Answer:
    """A section whose first words are the answer, and whose panels stand alone."""

    headline: str
    summary: Words  # what is said behind the headline
    said: tuple[Words, ...]  # and below it, a paragraph each
    method: tuple[Block, ...]  # in small print
    parts: tuple[Section, ...]

    @classmethod
    def of(cls, section: Section) -> Answer:
        """Take one apart: its panels become sections, named by their first table."""
        words = [
            one
            for one in takewhile(lambda x: not isinstance(x, Panel), section.blocks)
            if isinstance(one, Paragraph)
        ]
        first, *said = [one.words for one in words if not one.small]
        head, *rest = first
        headline = head.text if isinstance(head, Run) else str(head)
        if not any(rest) and said:
            rest, said = [*said[0]], said[1:]
        panels = [one for one in section.blocks if isinstance(one, Panel)]
        return cls(
            headline=headline.removesuffix("."),
            summary=tuple(rest),
            said=tuple(said),
            method=tuple(one for one in words if one.small),
            parts=tuple(_part(section, *one) for one in enumerate(panels)),
        )

    def first(self, *names: str) -> tuple[Section, ...]:
        """Return parts of page one."""
        own = [part for part in self.parts if part.name in names]
        return tuple(replace(part, on_first_page=True) for part in own)

    def others(self, *names: str) -> tuple[Section, ...]:
        """Return all parts but these."""
        return tuple(part for part in self.parts if part.name not in names)

    def whole(
        self, page: str, *ends: Section, json: str, date: str, **view: object
    ) -> Document:
        """Return the document of a page that shows it; its cards say what stands below.

        The kind of the document is the name of the page without '_page'.
        """
        made = document(page, answer=self, **view)
        cards = tuple(replace(card, lines=self.said) for card in made.cards)
        return replace(
            made, summary=self.summary, cards=cards if self.said else ()
        ).whole(page.removesuffix("_page"), *ends, json=json, date=date)


def _part(section: Section, place: int, panel: Panel) -> Section:
    """Return a panel as a section."""
    tables = [one.name for one in panel.blocks if isinstance(one, Table)]
    name = tables[0] if tables else f"{section.name}-{place}"
    return Section(name=name, title=panel.title, blocks=panel.blocks)


def decades(values: Sequence[float]) -> tuple[float, float]:
    """Return powers of ten that values above 0 lie between, apart from the lower."""
    low, high = floor(log10(min(values))), ceil(log10(max(values)))
    return 10.0 ** (low - (10.0**low == min(values))), 10.0 ** max(high, low + 1)


def split_at(
    section: Section, *names: str
) -> tuple[tuple[Block, ...], tuple[Block, ...]]:
    """Return the blocks up to the first that has one of these names, and others."""
    blocks: Sequence[Block] = section.blocks
    place = next(
        (k for k, one in enumerate(blocks) if getattr(one, "name", "") in names),
        len(blocks),
    )
    return tuple(blocks[:place]), tuple(blocks[place:])
