"""Structured names: whose quantity it is, which one, of which axis."""

from __future__ import annotations

from typing import Self

AXES = ("x", "y", "z")
ANGLES = ("xy", "xz", "yx", "yz", "zx", "zy")  # order of the six mounting angles


class Name(str):
    """A dotted text that keeps its parts: `gyro.bias.x`.

    It is the text itself wherever one is wanted (keys, documents, messages); whoever
    needs a part reads the attribute, and nobody splits strings.

    Attributes
    ----------
    owner : str
        'gyro', 'accelerometer', 'station', ...; '' of a Problem that knows no owners.
    quantity : str
        'bias', 'bias_stability', 'levelling.east'; the text itself without an owner.
    axis : str
        'x', 'xy', ...; '' where there is none.
    """

    __slots__ = ("axis", "owner", "quantity")

    owner: str
    quantity: str
    axis: str

    def __new__(cls, quantity: str, *, owner: str = "", axis: str = "") -> Self:
        """Join the parts that are there with dots."""
        self = super().__new__(
            cls, ".".join(part for part in (owner, quantity, axis) if part)
        )
        self.owner, self.quantity, self.axis = owner, quantity, axis
        return self

    def __reduce__(self) -> tuple[object, ...]:
        """Keep the parts when the name is sent to another process."""
        return _name, (self.quantity, self.owner, self.axis)

    @property
    def group(self) -> Name:
        """The name without its axis: what several axes have in common."""
        return Name(self.quantity, owner=self.owner)

    @property
    def without_owner(self) -> Name:
        """The name within its owner: 'bias.x'."""
        return Name(self.quantity, axis=self.axis)


def as_name(text: str) -> Name:
    """Return a name as it is; another text becomes a name without owner or axis."""
    return text if isinstance(text, Name) else Name(text)


def _name(quantity: str, owner: str, axis: str) -> Name:
    return Name(quantity, owner=owner, axis=axis)
