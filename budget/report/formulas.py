"""Formulas as trees, which HTML sets as MathML and the PDF as typst mathematics."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Letter:
    """A variable, in italics; upright where it is a name or a transposition."""

    text: str
    upright: bool = False


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number or a word, upright."""

    text: str


@dataclass(frozen=True, kw_only=True)
class Sign:
    """An operator or a bracket; a `prefix` sign stands close to what it belongs to."""

    text: str
    prefix: bool = False


@dataclass(frozen=True, kw_only=True)
class Sub:
    """An index below."""

    base: Math
    index: Math


@dataclass(frozen=True, kw_only=True)
class Sup:
    """An exponent, or the T of a transposed matrix."""

    base: Math
    exponent: Math


@dataclass(frozen=True, kw_only=True)
class Mean:
    """A bar above."""

    base: Math


@dataclass(frozen=True, kw_only=True)
class Fraction:
    """A quotient."""

    top: Math
    bottom: Math


@dataclass(frozen=True, kw_only=True)
class Line:
    """Parts one after another."""

    parts: tuple[Math, ...]


Math = Letter | Figure | Sign | Sub | Sup | Mean | Fraction | Line


def letter(text: str) -> Letter:
    """Return a variable."""
    return Letter(text=text)


def upright(text: str) -> Figure:
    """Return a number or a word."""
    return Figure(text=text)


def sign(text: str) -> Sign:
    """Return an operator between two terms, or a bracket."""
    return Sign(text=text)


def minus(term: Math) -> Line:
    """Return a term with a minus before it."""
    return Line(parts=(Sign(text="\N{MINUS SIGN}", prefix=True), term))


def sub(base: Math | str, index: Math | str) -> Sub:
    """Return a letter with an index; plain texts are letters."""
    return Sub(base=_letter(base), index=_letter(index))


def fraction(top: Math, bottom: Math) -> Fraction:
    """Return a quotient."""
    return Fraction(top=top, bottom=bottom)


def line(*parts: Math | str) -> Line:
    """Return parts one after another; plain texts are letters."""
    return Line(parts=tuple(_letter(part) for part in parts))


def equals(left: Math, right: Math) -> Line:
    """Return an equation."""
    return Line(parts=(left, Sign(text="="), right))


def brackets(*parts: Math | str) -> Line:
    """Return parts in round brackets."""
    return line(sign("("), *parts, sign(")"))


def _letter(part: Math | str) -> Math:
    """Take a plain text for a variable."""
    return Letter(text=part) if isinstance(part, str) else part
