"""The formulas of propagation, coverage, noise and indices, each with its source."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import Equation, Equations, Panel, Paragraph
from budget.report.formulas import (
    Letter,
    Line,
    Sub,
    Sup,
    brackets,
    equals,
    fraction,
    line,
    minus,
    sign,
    sub,
    upright,
)
from budget.report.tables import print_coverage

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet

    from budget.report.blocks import Words
    from budget.report.formulas import Math
    from budget.results import Settings

PLUS, MINUS, PLUS_MINUS = "+", "\N{MINUS SIGN}", "\N{PLUS-MINUS SIGN}"
SIGMA, TAU = "\u03c3", "\u03c4"
HALF = fraction(upright("1"), upright("2"))
U_X = sub("U", "x")
HELD = (
    "A limit is on the absolute error: what is held against it is the larger of the "
    "two ends, without its sign."
)
WINDOWS = (
    "The noise of a window enters as its average, a Gaussian quantity with a variance "
    "in closed form; averages of one process over several windows are correlated "
    "accordingly. "
)


def law_panel() -> Panel:
    """Return the law of propagation to second order, JCGM 100, 5.1.2."""
    transposed = Sup(base=sub("c", "k"), exponent=upright("T"))
    mean = equals(
        line("E", brackets("y"), sign(MINUS), "y", brackets("x")),
        line(HALF, upright("tr"), brackets("H", U_X)),
    )
    covariance = equals(
        line(upright("cov"), brackets(sub("y", "k"), sign(","), sub("y", "l"))),
        line(
            transposed,
            U_X,
            sub("c", "l"),
            sign(PLUS),
            HALF,
            upright("tr"),
            brackets(sub("H", "k"), U_X, sub("H", "l"), U_X),
        ),
    )
    words: Words = (
        Letter(text="c"),
        ": sensitivities, ",
        Letter(text="H"),
        ": second derivatives of an output at the nominal point, ",
        U_X,
        (
            ": covariance of the inputs; an input that is not normal adds its fourth "
            "moment. JCGM 100:2008, eq. (13) and the note to 5.1.2, without the third "
            "derivatives of that note."
        ),
    )
    return _panel("Law of propagation", words, [(mean, ""), (covariance, "")])


def coverage_panel(settings: Settings) -> Panel:
    """Return the coverage interval of the method."""
    percent = print_coverage(settings.coverage)
    if settings.method == "gum":
        expanded = equals(Letter(text="U"), line("k", "u"))
        words: Words = (
            (
                f"The interval is mean {PLUS_MINUS} U, with k of the normal law for "
                f"{percent} %, JCGM 100:2008, G.1.3. {HELD}"
            ),
        )
        return _panel("Coverage", words, [(expanded, "")])
    words = (
        f"The interval holds {percent} % of the trials, JCGM 101:2008, 7.7. {HELD}",
    )
    return Panel(title="Coverage", blocks=(Paragraph(words=words, small=True),))


def noise_panel(lines: AbstractSet[str]) -> Panel | None:
    """Return the variance of a window average of every process that is given."""
    length = Letter(text="L")
    found: list[tuple[Math, str]] = []
    if lines & {"angle_random_walk", "velocity_random_walk"}:
        found.append((fraction(_square("N"), length), "white, density N"))
    if "sample_noise" in lines:
        found.append(
            (
                fraction(_square(SIGMA), line("f", length)),
                f"white per sample, {SIGMA} at rate f",
            )
        )
    if "bias_stability" in lines:
        ratio = fraction(length, Letter(text=TAU))
        decay = Sup(
            base=Letter(text="e"),
            exponent=line(minus(length), sign("/"), TAU),
        )
        gauss_markov = line(
            upright("2"),
            _square(SIGMA),
            Sup(
                base=brackets(fraction(Letter(text=TAU), length)),
                exponent=upright("2"),
            ),
            brackets(ratio, sign(MINUS), upright("1"), sign(PLUS), decay),
        )
        note = f"first-order Gauss-Markov, {SIGMA} and correlation time {TAU}"
        found.append((gauss_markov, note))
    if lines & {"rate_random_walk", "acceleration_random_walk"}:
        walk = line(
            _square("K"),
            brackets("s", sign(PLUS), fraction(length, upright("3"))),
        )
        found.append((walk, "random walk K from t = 0"))
    if not found:
        return None
    words: Words = (
        WINDOWS,
        Letter(text="L"),
        " is the length of a window, ",
        Letter(text="s"),
        " its start.",
    )
    variance = sub("u", "L")
    squared = Sup(base=variance, exponent=upright("2"))
    return _panel(
        "Noise averaged over a window",
        words,
        [(equals(squared, math), note) for math, note in found],
    )


def indices_panel() -> Panel:
    """Return first-order and total index."""
    variance = line("V", brackets("y"))
    first = equals(
        sub("S", "i"),
        fraction(
            line("V", brackets("E", brackets("y", sign("|"), sub("x", "i")))), variance
        ),
    )
    others = Sub(base=Letter(text="x"), index=line(sign("~"), "i"))
    total = equals(
        Sub(base=Letter(text="S"), index=line("T", "i")),
        fraction(line("E", brackets("V", brackets("y", sign("|"), others))), variance),
    )
    words: Words = (
        "Part of the variance that the source ",
        Letter(text="i"),
        " makes alone, and with all its products.",
    )
    return _panel("Sobol' indices", words, [(first, ""), (total, "")])


def _square(letter: str) -> Sup:
    """Return a letter squared."""
    return Sup(base=Letter(text=letter), exponent=upright("2"))


def _panel(title: str, words: Words, equations: list[tuple[Line, str]]) -> Panel:
    """Return formulas, each with what it is of, under what their letters mean."""
    return Panel(
        title=title,
        blocks=(
            Paragraph(words=words, small=True),
            Equations(
                equations=tuple(
                    Equation(math=math, number=note) for math, note in equations
                )
            ),
        ),
    )
