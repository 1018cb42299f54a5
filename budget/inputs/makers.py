"""What makers call the lines of a device file: the words, and where a page reads them.

The words are data, makers.yaml beside this, of other packages their rows; messages, the
JSON Schema, `budget new` and docs/datasheets.md read them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from budget.inputs.composer import compose
from budget.inputs.tree import plain
from budget.model.sources import every_source
from budget.units import ONE_SIDED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

PAGE = "docs/datasheets.md"
MEANINGS = f"{PAGE}#what-a-value-means"
UNITS = f"{PAGE}#units"


@dataclass(frozen=True, kw_only=True)
class Density:
    """Sides of the noise density that a maker prints, where a sheet of theirs shows it.

    A sheet shows it that prints density and random walk of one noise, or a density and
    the rms of a band.
    """

    vendors: tuple[str, ...]  # as files name them
    sides: str
    source: str  # the sheet, and what it prints


DENSITIES = (
    Density(
        vendors=("Analog Devices", "ADI"),
        sides=ONE_SIDED,
        # 0.008 x 60 / sqrt(2) is 0.339.
        source="ADIS16470: 0.008 deg/s/sqrt(Hz) beside 0.34 deg/sqrt(h)",
    ),
)


def density_of(vendor: str) -> Density | None:
    """Return how a vendor means a density; None where nobody knows."""
    named = bare(vendor)
    return next((x for x in DENSITIES if named in map(bare, x.vendors)), None)


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Lines of one idea: each with the words of makers, and how to read them."""

    anchor: str  # of the heading in PAGE
    words: Mapping[str, Sequence[str]]  # by line
    says: str  # what to look at before a value becomes the line

    @property
    def link(self) -> str:
        """Where the page tells it; of other packages whose the line is."""
        return f"{PAGE}#{self.anchor}" if self.anchor else self.says


@cache
def readings() -> tuple[Reading, ...]:
    """Return the lines with their words, those of other packages by what they say."""
    file = Path(__file__).with_name("makers.yaml")
    node, _ = compose(file.read_text(encoding="utf-8"), file.name)
    own = (Reading(**one) for one in cast("list[dict[str, Any]]", plain(node)))
    others = (one for one in every_source() if one.origin)
    return (
        *own,
        *(
            Reading(anchor="", words={one.name: one.words}, says=one.origin)
            for one in others
        ),
    )


def bare(word: str) -> str:
    """Return a word without what joins it: one spelling of many."""
    return re.sub("[^a-z0-9]", "", word.lower())


@cache
def reading_of(line: str) -> Reading | None:
    """Return how makers print a line of a device; None of what is no line."""
    return next((one for one in readings() if line in one.words), None)


def printed_as(line: str) -> str:
    """Return what makers call a line, and where the page reads it."""
    one = reading_of(line)
    if one is None or not one.words[line]:
        return "printed under no other name that we know"
    return f"printed as {', '.join(one.words[line])}: {one.link}"


@cache
def lines_by_word() -> Mapping[str, tuple[str, ...]]:
    """Return the lines that each word may stand for; a line's own name is no word."""
    found: dict[str, tuple[str, ...]] = {}
    for one in readings():
        for line, words in one.words.items():
            for word in dict.fromkeys(map(bare, words)):
                found[word] = (*found.get(word, ()), line)
    return found | {bare(line): (line,) for one in readings() for line in one.words}
