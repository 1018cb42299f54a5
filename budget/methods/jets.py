"""Second-order Taylor arithmetic: value, gradient and Hessian carried together.

A Jet is a number; numpy arrays of dtype object hold them, so any model written in
plain numpy arithmetic yields its derivatives to rounding, without differences.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array


class Jet:
    """f, df/dx and d2f/dx2 of one quantity at one point.

    Attributes
    ----------
    value : float
    gradient : ndarray, shape (n,)
    hessian : ndarray, shape (n, n), or None
        None stands for zero: most quantities of a budget are linear in its inputs.
    """

    __slots__ = ("gradient", "hessian", "value")

    def __init__(self, value: float, gradient: Array, hessian: Array | None) -> None:
        """Keep the three parts."""
        self.value = value
        self.gradient = gradient
        self.hessian = hessian

    def __repr__(self) -> str:
        """Show the value; the derivatives are long."""
        return f"Jet({self.value!r})"

    def compose(self, value: float, first: float, second: float) -> Jet:
        """Return g(self) from g, g', g'' at the value: the chain rule."""
        return Jet(
            value,
            first * self.gradient,
            _add(
                _scale(self.hessian, first),
                None
                if second == 0.0
                else second * np.outer(self.gradient, self.gradient),
            ),
        )

    def __add__(self, other: Jet | float) -> Jet:
        """Return self + other."""
        if isinstance(other, Jet):
            return Jet(
                self.value + other.value,
                self.gradient + other.gradient,
                _add(self.hessian, other.hessian),
            )
        return Jet(self.value + other, self.gradient, self.hessian)

    def __neg__(self) -> Jet:
        """Return -self."""
        return self * -1.0

    def __pos__(self) -> Jet:
        """Return self."""
        return self

    def __sub__(self, other: Jet | float) -> Jet:
        """Return self - other."""
        if isinstance(other, Jet):
            return self + other * -1.0
        return Jet(self.value - other, self.gradient, self.hessian)

    def __rsub__(self, other: float) -> Jet:
        """Return other - self."""
        return self * -1.0 + other

    def __mul__(self, other: Jet | float) -> Jet:
        """Return self times other: the product rule, twice."""
        if not isinstance(other, Jet):
            return Jet(
                self.value * other, self.gradient * other, _scale(self.hessian, other)
            )
        cross = np.outer(self.gradient, other.gradient)
        return Jet(
            self.value * other.value,
            other.value * self.gradient + self.value * other.gradient,
            _add(
                cross + cross.T,
                _add(
                    _scale(self.hessian, other.value), _scale(other.hessian, self.value)
                ),
            ),
        )

    def __truediv__(self, other: Jet | float) -> Jet:
        """Return self over other."""
        return self * (other**-1 if isinstance(other, Jet) else 1.0 / other)

    def __rtruediv__(self, other: float) -> Jet:
        """Return other over self."""
        return self**-1 * other

    def __pow__(self, exponent: Jet | float) -> Jet:
        """Return self to a power; a Jet as the exponent needs a positive base."""
        if isinstance(exponent, Jet):
            return (exponent * self.log()).exp()
        n, v = exponent, self.value
        if n == 0:
            return self.compose(1.0, 0.0, 0.0)
        if n == 1:
            return self
        second = 2.0 if n == 2 else n * (n - 1) * v ** (n - 2)  # noqa: PLR2004
        return self.compose(v**n, n * v ** (n - 1), second)

    def __rpow__(self, base: float) -> Jet:
        """Return base to the power self."""
        return (self * math.log(base)).exp()

    __radd__ = __add__
    __rmul__ = __mul__

    # numpy calls these by name when a ufunc meets an array of objects.

    def exp(self) -> Jet:
        """Return e^self."""
        v = math.exp(self.value)
        return self.compose(v, v, v)

    def log(self) -> Jet:
        """Return the natural logarithm."""
        v = self.value
        return self.compose(math.log(v), 1.0 / v, -1.0 / v**2)

    def sqrt(self) -> Jet:
        """Return the square root."""
        root = math.sqrt(self.value)
        return self.compose(root, 0.5 / root, -0.25 / root**3)

    def square(self) -> Jet:
        """Return self times self."""
        return self * self

    def reciprocal(self) -> Jet:
        """Return 1 over self."""
        return self**-1

    def sin(self) -> Jet:
        """Return the sine."""
        s, c = math.sin(self.value), math.cos(self.value)
        return self.compose(s, c, -s)

    def cos(self) -> Jet:
        """Return the cosine."""
        s, c = math.sin(self.value), math.cos(self.value)
        return self.compose(c, -s, -c)

    def tan(self) -> Jet:
        """Return the tangent."""
        return self.sin() / self.cos()

    def arctan(self) -> Jet:
        """Return the inverse tangent."""
        v = self.value
        first = 1.0 / (1.0 + v**2)
        return self.compose(math.atan(v), first, -2.0 * v * first**2)


@dataclass(frozen=True, kw_only=True, eq=False)
class Expansion:
    """A function and its derivatives at one point.

    Attributes
    ----------
    value : ndarray, shape (n_out,)
    C : ndarray, shape (n_out, n_in)
        Sensitivities dy/dx [unit of y / unit of x].
    H : ndarray, shape (n_out, n_in, n_in)
        Second derivatives [unit of y / units of both x].
    """

    value: Array
    C: Array
    H: Array


def expand(function: Callable[[Array], Array], point: Array) -> Expansion:
    """Return the function's second-order Taylor expansion at a point.

    Parameters
    ----------
    function : callable, (n_in, trials) -> (n_out, trials)
        Written in numpy arithmetic that keeps the dtype of its argument.
    point : ndarray, shape (n_in,)
        Where to expand.

    Returns
    -------
    Expansion
    """
    n = point.size
    x = np.empty((n, 1), dtype=object)
    for i, unit in enumerate(np.eye(n)):
        x[i, 0] = Jet(float(point[i]), unit, None)
    jets = function(x)[:, 0]
    value, C, H = (
        np.zeros(jets.size),
        np.zeros((jets.size, n)),
        np.zeros((jets.size, n, n)),
    )
    for k, jet in enumerate(jets):
        if not isinstance(jet, Jet):  # an output that no input reaches
            value[k] = jet
            continue
        value[k], C[k] = jet.value, jet.gradient
        if jet.hessian is not None:
            H[k] = jet.hessian
    return Expansion(value=value, C=C, H=H)


def _add(a: Array | None, b: Array | None) -> Array | None:
    """Add two Hessians, None being zero."""
    if a is None:
        return b
    return a if b is None else a + b


def _scale(hessian: Array | None, factor: float) -> Array | None:
    """Scale a Hessian, None being zero."""
    return None if hessian is None or factor == 0.0 else hessian * factor
