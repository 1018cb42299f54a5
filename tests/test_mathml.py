"""Formula trees as MathML."""

from __future__ import annotations

import pytest

from budget.report.formulas import (
    Figure,
    Letter,
    Mean,
    Sign,
    Sup,
    fraction,
    letter,
    line,
    minus,
    sub,
)
from budget.report.page import to_mathml


@pytest.mark.parametrize(
    ("math", "element"),
    [
        (letter("K"), "<mi>K</mi>"),
        (Letter(text="T", upright=True), '<mi mathvariant="normal">T</mi>'),
        (Letter(text="sin", upright=True), "<mi>sin</mi>"),
        (Figure(text="4"), "<mn>4</mn>"),
        (Figure(text="max"), "<mtext>max</mtext>"),
        (Sign(text="="), "<mo>=</mo>"),
        (
            minus(letter("x")),
            '<mrow><mo form="prefix">\N{MINUS SIGN}</mo><mi>x</mi></mrow>',
        ),
        (sub("n", "x2"), "<msub><mi>n</mi><mi>x2</mi></msub>"),
        (
            Sup(base=letter("u"), exponent=Figure(text="2")),
            "<msup><mi>u</mi><mn>2</mn></msup>",
        ),
        (
            Mean(base=letter("N")),
            (
                '<mover accent="true"><mi>N</mi>'
                '<mo stretchy="false">\N{MACRON}</mo></mover>'
            ),
        ),
        (
            fraction(letter("a"), letter("b")),
            "<mfrac><mi>a</mi><mi>b</mi></mfrac>",
        ),
        (line("a", "b"), "<mrow><mi>a</mi><mi>b</mi></mrow>"),
    ],
)
def test_every_part_has_its_element(math, element):
    """Letters, numbers, signs, indices, bars and quotients are set as such."""
    assert to_mathml(math) == f"<math>{element}</math>"


def test_displayed_formula_is_set_at_full_size():
    """A formula on a line of its own does not shrink its quotients."""
    assert to_mathml(letter("x"), displayed=True) == (
        '<math displaystyle="true"><mi>x</mi></math>'
    )


@pytest.mark.parametrize(
    "part", [letter("<b>"), Figure(text="<b>"), Figure(text="1<b>"), Sign(text="<b>")]
)
def test_texts_in_formulas_are_escaped(part):
    """Mark-up in a formula is shown, never obeyed."""
    assert "<b>" not in to_mathml(part)
    assert "&lt;b&gt;" in to_mathml(part)
