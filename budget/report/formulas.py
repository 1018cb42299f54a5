"""Formulas in typst's notation, which the PDF sets as they are and HTML as MathML.

They are constants of this package, or of one with error lines of its own, never texts
of a user: they are run as typst.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING
from unicodedata import normalize

from budget.errors import CallError

if TYPE_CHECKING:
    from budget.model.source import Source

EXPERIMENTAL = "html export is under active development"
# Browsers set a combining bar beside its letter, and a bar marked as an accent on it.
BAR = (
    ('<mover accent="true">', "<mover>"),
    ("<mo>\u0304</mo>", '<mo stretchy="false">\N{MACRON}</mo>'),
)
SAID = (  # what stands in a source beside letters and signs, and how it is said
    (r"macron\((\w+)\)", r"mean of \1"),
    (r"upright\((\w+)\)", r"\1"),
    (r'"(\w+)"', r"\1"),
    (r"\\/", "/"),
)


@dataclass(frozen=True, kw_only=True)
class Math:
    """A formula: 'K_x = n_(x 2)/(4 pi m)'."""

    source: str

    @property
    def alt(self) -> str:
        """The formula for those who cannot see it: 'mean of N/K - mean of omega'."""
        text = self.source
        for pattern, words in SAID:
            text = re.sub(pattern, words, text)
        return text


def with_math(text: str) -> tuple[str | Math, ...]:
    """Cut a text of this package at its dollar signs: words, formula, words, ..."""
    return tuple(
        Math(source=part) if place % 2 else part
        for place, part in enumerate(text.split("$"))
        if part
    )


def check_formula(source: Source) -> None:
    """Refuse the formula of a line of another package that cannot be set.

    Raises
    ------
    CallError
        Whose it is, and what typst says.
    """
    import typst

    formula = source.effect.formula
    try:
        to_mathml((formula,))
    except typst.TypstError as error:
        raise CallError(
            f"the formula {formula!r} of {source.name!r} of {source.origin} cannot be "
            f"set: {' '.join(str(error).split())}; mend or remove that package"
        ) from error


@cache
def to_mathml(sources: tuple[str, ...]) -> tuple[str, ...]:
    """Write formulas as MathML Core: what stands inside each `math` element.

    Letters are plain: a browser slants those that are not marked as upright.
    """
    import typst

    text = "\n\n".join(f"$ {source} $" for source in sources)
    html, doubts = typst.compile_with_warnings(
        text.encode(), format="html", ignore_system_fonts=True
    )
    for doubt in doubts:
        if EXPERIMENTAL not in doubt.message:
            warnings.warn(f"formulas: typst says: {doubt.message}", stacklevel=2)
    page = normalize("NFKC", html.decode())
    for theirs, ours in BAR:
        page = page.replace(theirs, ours)
    return tuple(re.findall(r"<math[^>]*>(.*?)</math>", page))
