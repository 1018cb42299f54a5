"""Formula trees as MathML, which browsers set themselves."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from budget.report.formulas import Figure, Fraction, Letter, Line, Mean, Sign, Sub, Sup

if TYPE_CHECKING:
    from budget.report.formulas import Math

OVERLINE = "\N{MACRON}"


def to_mathml(math: Math, *, displayed: bool = False) -> str:
    """Write a formula as a `math` element.

    Parameters
    ----------
    math : Math
        The tree.
    displayed : bool
        Whether it stands by itself, with quotients at full size.

    Returns
    -------
    str
        MathML Core inside HTML, all texts escaped.
    """
    opening = '<math displaystyle="true">' if displayed else "<math>"
    return f"{opening}{_element(math)}</math>"


def _element(math: Math) -> str:  # noqa: PLR0911 - one return for each kind of part
    """Write one part with all that is in it."""
    match math:
        case Letter(text=text, upright=upright):
            return _letter(text, upright=upright)
        case Figure(text=text):
            tag = "mn" if text[:1].isdigit() else "mtext"
            return f"<{tag}>{escape(text)}</{tag}>"
        case Sign(text=text, prefix=prefix):
            form = ' form="prefix"' if prefix else ""
            return f"<mo{form}>{escape(text)}</mo>"
        case Sub(base=base, index=index):
            return f"<msub>{_element(base)}{_element(index)}</msub>"
        case Sup(base=base, exponent=exponent):
            return f"<msup>{_element(base)}{_element(exponent)}</msup>"
        case Mean(base=base):
            bar = f'<mo stretchy="false">{OVERLINE}</mo>'
            return f'<mover accent="true">{_element(base)}{bar}</mover>'
        case Fraction(top=top, bottom=bottom):
            return f"<mfrac>{_element(top)}{_element(bottom)}</mfrac>"
        case Line(parts=parts):
            return f"<mrow>{''.join(map(_element, parts))}</mrow>"


def _letter(text: str, *, upright: bool) -> str:
    """Write a variable: browsers slant one letter, and set several upright."""
    slant = ' mathvariant="normal"' if upright and len(text) == 1 else ""
    return f"<mi{slant}>{escape(text)}</mi>"
