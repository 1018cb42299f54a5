"""One finding: a printed number or claim, ours beside it, and a verdict."""

from __future__ import annotations

from dataclasses import dataclass

AGREES = "agrees"
AGREES_IN_ORDER = "agrees in order"
FITS_MEAN = "fits a mean over 25 runs"
FITS_SINGLE = "fits a single run"
MISPRINT = "misprint, mended"
EXPLAINED = "differs, explained"
READING = "differs, a reading fits"
UNEXPLAINED = "unexplained"
READING_FITS = "reading that fits"
READING_FAILS = "reading that does not fit"

VERDICTS = {
    AGREES: "ours is the printed value: to its digits, as a word, or both are zero "
    "beyond the rounding of doubles",
    AGREES_IN_ORDER: "the text gives only a power of ten, and ours has it, or has it "
    "with a probability of 1 % or more",
    FITS_MEAN: "a random entry: one of the mean over 25 runs at the stated inputs; "
    "two-sided p 1 % or more and larger than for a single run",
    FITS_SINGLE: "a random entry: one of a single run, likewise",
    MISPRINT: "the formula as printed returns a wrong parameter from error-free "
    "pulses; ours returns the right one",
    EXPLAINED: "ours differs, and the cause is shown by computation",
    READING: "does not fit the stated inputs; another reading of them does. It is "
    "computed and named, not adopted",
    UNEXPLAINED: "does not fit, and no reading that was tried explains it",
    READING_FITS: "another reading of the inputs: all entries fit it, p 1 % or more",
    READING_FAILS: "another reading of the inputs: it was tried and does not fit",
}

# What `ours` is.
VALUE = "value"
U_SINGLE = "u, single run"
U_MEAN = "u, mean over 25 runs"
WORD = "word"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One row.

    Attributes
    ----------
    section : str
        Part of the study: a key of study.SECTIONS.
    where : str
        Where the number stands in the paper.
    printed : str
        As printed, or the root mean square of printed entries where `where` says so.
    ours : float or str
        A number where the paper prints one, a word or formula where it prints one
        [same unit as printed].
    quantity : str
        What a number of ours is: VALUE, or the standard uncertainty that a random
        entry is held against.
    ratio : float or None
        Ours over printed, of absolute values [1]; None where one of them is no number
        or zero.
    verdict : str
        One of VERDICTS.
    why : str
        In words.
    p_single, p_mean : float or None
        Probability of values at least as extreme as the printed one, two-sided, if it
        is a single run or a mean over 25; of an order of magnitude, the probability of
        that order [1]. None where nothing is random.
    is_summary : bool
        Whether the row speaks of several entries together.
    """

    section: str
    where: str
    printed: str
    ours: float | str
    quantity: str = VALUE
    ratio: float | None = None
    verdict: str
    why: str
    p_single: float | None = None
    p_mean: float | None = None
    is_summary: bool = False


def say(value: float, digits: int = 2) -> str:
    """Write a number within a sentence: '7.7e-8', '3890', '0.16'."""
    text = f"{value:.{digits}g}"
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if e else text


def ratio_of(ours: float, printed: float) -> float | None:
    """Return |ours / printed|, None where either is zero."""
    return abs(ours / printed) if ours and printed else None
