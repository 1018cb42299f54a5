"""Formulas: what is said of them, and the MathML that typst makes."""

from __future__ import annotations

import warnings

import pytest

from budget.report.formulas import Math, to_mathml, with_math


@pytest.mark.parametrize(
    ("source", "element"),
    [
        ("K_x", "<msub><mi>K</mi><mi>x</mi></msub>"),
        ("2 g", "<mn>2</mn><mi>g</mi>"),
        ("upright(T)", '<mi mathvariant="normal">T</mi>'),
        ("-x", "<mo>\N{MINUS SIGN}</mo><mi>x</mi>"),
        (
            "c_k^upright(T)",
            '<msubsup><mi>c</mi><mi>k</mi><mi mathvariant="normal">T</mi></msubsup>',
        ),
        (
            "macron(N)",
            '<mover><mi>N</mi><mo stretchy="false">\N{MACRON}</mo></mover>',
        ),
        ("a/b", "<mfrac><mi>a</mi><mi>b</mi></mfrac>"),
    ],
)
def test_every_part_has_its_element(source, element):
    """Letters, numbers, signs, indices, bars and quotients are set as such."""
    assert to_mathml((source,)) == (element,)


def test_formulas_are_set_in_their_order():
    """As many come back as were given, each in its place."""
    assert to_mathml(("a", "b", "c")) == ("<mi>a</mi>", "<mi>b</mi>", "<mi>c</mi>")


def test_what_mathml_cannot_show_is_not_passed_over():
    """A part that typst leaves out is a warning, and no formula without it."""
    with pytest.warns(UserWarning, match="overline was ignored"):
        to_mathml(("overline(N)",))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        to_mathml(("macron(M)",))


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("K_x = n/m", "K_x = n/m"),
        ("macron(N)", "mean of N"),
        ("c_k^upright(T)", "c_k^T"),
        ('"cov"(y_k, y_l)', "cov(y_k, y_l)"),
        ("e^(-L\\/tau)", "e^(-L/tau)"),
    ],
)
def test_formulas_are_said_on_a_line(source, said):
    """Who hears the page hears the formula."""
    assert Math(source=source).alt == said


def test_a_text_is_cut_at_its_dollar_signs():
    """Words and formulas take turns, wherever the text begins."""
    assert with_math("$K$ is a factor, $g$") == (
        Math(source="K"),
        " is a factor, ",
        Math(source="g"),
    )
