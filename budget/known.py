"""A number that is known in part: how it reads, how it is counted with, how it ranks.

What a data sheet does not give makes a result a bound: this or more, this or less, or
no number at all. The number carries that with it, and why.
"""

from __future__ import annotations

from math import inf, isinf
from typing import TYPE_CHECKING, Self

from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.names import Name

AT_LEAST, AT_MOST = "\N{GREATER-THAN OR EQUAL TO}", "\N{LESS-THAN OR EQUAL TO}"
UNKNOWN = "?"  # stands for a number of which nothing is known


class Known(float):
    """A number, between which ends the true one is, and why no better is known.

    It is a float, of what is given. Ends that are infinite make it a bound.

    Attributes
    ----------
    low, high : float
        Ends of what it may be; the number itself where it is known.
    why : tuple of Name
        Lines that are not given.
    """

    __slots__ = ("high", "low", "why")
    low: float
    high: float
    why: tuple[Name, ...]

    def __new__(
        cls,
        value: float,
        low: float | None = None,
        high: float | None = None,
        why: tuple[Name, ...] = (),
    ) -> Self:
        """Return a number; without ends it is known."""
        self = super().__new__(cls, value)
        self.low = float(value if low is None else low)
        self.high = float(value if high is None else high)
        self.why = why
        return self

    @classmethod
    def at_least(cls, value: float, why: tuple[Name, ...] = ()) -> Known:
        """Return what is this or more."""
        return cls(value, high=inf, why=why)

    @classmethod
    def of(cls, value: float, why: tuple[Name, ...], *, is_felt: bool = True) -> Known:
        """Return what lines that are not given would add to: this or more.

        Unknown where what is given `is_felt` nowhere in it.
        """
        if not why:
            return cls(value)
        return cls(value, None if is_felt else -inf, inf, why)

    def like(self, value: float) -> Known:
        """Return another size that is known as this one is."""
        low, high = (end if isinf(end) else None for end in (self.low, self.high))
        return Known(value, low, high, self.why)

    @classmethod
    def largest(cls, numbers: Iterable[Known]) -> Known:
        """Return the largest of some: known no better than any of them."""
        every = [*numbers]
        return cls(
            max(every, key=settle),
            max(one.low for one in every),
            max(one.high for one in every),
            tuple(dict.fromkeys(name for one in every for name in one.why)),
        )

    def __reduce__(self) -> tuple[type[Known], tuple[object, ...]]:
        """Return what it is made of again: it goes to other processes."""
        return Known, (float(self), self.low, self.high, self.why)

    def __truediv__(self, size: float) -> Known:
        """Return it in a unit of a size above 0."""
        return Known(float(self) / size, self.low / size, self.high / size, self.why)

    @property
    def falling(self) -> Known:
        """The same of what is less the more this is: a lower end, a probability."""
        return Known(self, 2.0 * self - self.high, 2.0 * self - self.low, self.why)

    @property
    def is_bound(self) -> bool:
        """Whether it is this or more, or this or less."""
        return self.high == inf or self.low == -inf

    @property
    def is_unknown(self) -> bool:
        """Whether nothing is known of it."""
        return self.high == inf and self.low == -inf

    def written(self, text: str) -> str:
        """Write it, printed as a text: '≥ 0.42', '≤ 0.42', '?', '0.42'."""
        if self.is_unknown:
            return UNKNOWN
        if not self.is_bound:
            return text
        return f"{AT_LEAST if self.high == inf else AT_MOST} {text}"
