"""One finding: a printed number or claim, ours beside it, and a verdict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

RUNS = 25  # of each condition, section 3.1


class Verdict(StrEnum):
    """How ours stands to what is printed; the paper's file says what each means."""

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


# What `ours` is.
VALUE = "value"
U_SINGLE = "u, single run"
U_MEAN = f"u, mean over {RUNS} runs"
WORD = "word"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One row.

    Attributes
    ----------
    section : str
        Part of the study: a key of Paper.sections.
    where : str
        Where the number stands in the paper.
    place : tuple of str
        The same in a table: group of rows ('bias stability'), head of the row ('bias
        x'), and what is special about it ('from its angles'), if anything.
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
    verdict : Verdict
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
    place: tuple[str, ...]
    printed: str
    ours: float | str
    quantity: str = VALUE
    ratio: float | None = None
    verdict: Verdict
    why: str
    p_single: float | None = None
    p_mean: float | None = None
    is_summary: bool = False


def agrees_if(condition: bool) -> Verdict:  # noqa: FBT001 - the one thing it asks
    """Return the verdict on what can only agree or stay unexplained."""
    return Verdict.AGREES if condition else Verdict.UNEXPLAINED


def say(value: float, digits: int = 2) -> str:
    """Write a number within a sentence: '7.7e-8', '3890', '0.16'."""
    text = f"{value:.{digits}g}"
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if e else text


def words(key: str) -> str:
    """Turn a key into words: 'scale factor'."""
    return key.replace("_", " ")


def ratio_of(ours: float, printed: float) -> float | None:
    """Return |ours / printed|, None where either is zero."""
    return abs(ours / printed) if ours and printed else None
