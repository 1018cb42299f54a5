"""Second-order Taylor arithmetic: value, gradient and Hessian carried together.

A Jet is a number; numpy arrays of dtype object hold them, so any model written in
plain numpy arithmetic yields its derivatives to rounding, without differences. Where a
model has no derivatives at the point (abs and sqrt at 0, a maximum of equals, a branch
that switches there) a Jet refuses in words: a value taken from one side is no law.
"""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.errors import BudgetError, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array

REMEDY = (
    "the law of propagation needs first and second derivatives at the nominal inputs; "
    "use sample() (Monte Carlo), which needs none"
)


def _of_root(root: float, v: float, order: float) -> tuple[float, float, float]:
    """Return value, first and second derivative of v^(1/order)."""
    first = root / (order * v)
    return root, first, first * (1.0 / order - 1.0) / v


def _of_tangent(t: float, sign: float) -> tuple[float, float, float]:
    """Return those of tan (sign 1) and tanh (-1): g' = 1 + sign g^2."""
    first = 1.0 + sign * t * t
    return t, first, 2.0 * sign * t * first


def _of_logarithm(value: float, v: float, base: float) -> tuple[float, float, float]:
    """Return those of a logarithm whose base has the natural logarithm `base`."""
    return value, 1.0 / (v * base), -1.0 / (v * v * base)


def _of_arcsine(value: float, v: float, sign: float) -> tuple[float, float, float]:
    """Return those of arcsin (sign 1) and arccos (-1)."""
    root = math.sqrt((1.0 - v) * (1.0 + v))
    return value, sign / root, sign * v / root**3


def _of_arccosh(v: float) -> tuple[float, float, float]:
    """Return those of arccosh."""
    root = math.sqrt(v - 1.0) * math.sqrt(v + 1.0)
    return math.acosh(v), 1.0 / root, -v / root**3


def _of_power(value: float, base: float) -> tuple[float, float, float]:
    """Return those of an exponential of the natural logarithm `base`."""
    return value, value * base, value * base**2


# Value, first and second derivative of what numpy knows by these names.
ELEMENTARY: dict[str, Callable[[float], tuple[float, float, float]]] = {
    "exp": lambda v: _of_power(math.exp(v), 1.0),
    "exp2": lambda v: _of_power(2.0**v, math.log(2.0)),
    "expm1": lambda v: (math.expm1(v), math.exp(v), math.exp(v)),
    "log": lambda v: (math.log(v), 1.0 / v, -1.0 / v**2),
    "log2": lambda v: _of_logarithm(math.log2(v), v, math.log(2.0)),
    "log10": lambda v: _of_logarithm(math.log10(v), v, math.log(10.0)),
    "log1p": lambda v: _of_logarithm(math.log1p(v), 1.0 + v, 1.0),
    "sqrt": lambda v: _of_root(math.sqrt(v), v, 2.0),
    "cbrt": lambda v: _of_root(math.cbrt(v), v, 3.0),
    "sin": lambda v: (math.sin(v), math.cos(v), -math.sin(v)),
    "cos": lambda v: (math.cos(v), -math.sin(v), -math.cos(v)),
    "tan": lambda v: _of_tangent(math.tan(v), 1.0),
    "arcsin": lambda v: _of_arcsine(math.asin(v), v, 1.0),
    "arccos": lambda v: _of_arcsine(math.acos(v), v, -1.0),
    "arctan": lambda v: (
        math.atan(v),
        1.0 / (1.0 + v**2),
        -2.0 * v / (1.0 + v**2) ** 2,
    ),
    "sinh": lambda v: (math.sinh(v), math.cosh(v), math.sinh(v)),
    "cosh": lambda v: (math.cosh(v), math.sinh(v), math.cosh(v)),
    "tanh": lambda v: _of_tangent(math.tanh(v), -1.0),
    "arcsinh": lambda v: (
        math.asinh(v),
        1.0 / math.hypot(1.0, v),
        -v / math.hypot(1.0, v) ** 3,
    ),
    "arccosh": _of_arccosh,
    "arctanh": lambda v: (
        math.atanh(v),
        1.0 / (1.0 - v * v),
        2.0 * v / (1.0 - v * v) ** 2,
    ),
    "deg2rad": lambda v: (math.radians(v), math.pi / 180.0, 0.0),
    "radians": lambda v: (math.radians(v), math.pi / 180.0, 0.0),
    "rad2deg": lambda v: (math.degrees(v), 180.0 / math.pi, 0.0),
    "degrees": lambda v: (math.degrees(v), 180.0 / math.pi, 0.0),
}


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
                else second * (self.gradient[:, None] * self.gradient),
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
        return Jet(
            self.value * other.value,
            other.value * self.gradient + self.value * other.gradient,
            _add(
                _twice_the_product(self.gradient, other.gradient),
                _add(
                    _scale(self.hessian, other.value), _scale(other.hessian, self.value)
                ),
            ),
        )

    def __truediv__(self, other: Jet | float) -> Jet:
        """Return self over other."""
        if isinstance(other, Jet):
            return self * other**-1
        if other == 0.0:
            raise ProblemError(f"the function divides by 0: {REMEDY}")
        return self * (1.0 / other)

    def __rtruediv__(self, other: float) -> Jet:
        """Return other over self."""
        return self**-1 * other

    def __pow__(self, exponent: Jet | float) -> Jet:
        """Return self to a power; a Jet as the exponent needs a positive base."""
        if isinstance(exponent, Jet):
            return (exponent * self.log()).exp()
        n, v = float(exponent), float(self.value)
        if n == 0.0:
            return self.compose(1.0, 0.0, 0.0)
        if n == 1.0:
            return self
        try:
            second = 2.0 if n == 2.0 else n * (n - 1.0) * math.pow(v, n - 2.0)  # noqa: PLR2004
            return self.compose(math.pow(v, n), n * math.pow(v, n - 1.0), second)
        except (ArithmeticError, ValueError):
            raise _without_derivatives(f"x**{n:g}", v) from None

    def __rpow__(self, base: float) -> Jet:
        """Return base to the power self."""
        if not base > 0.0:
            raise _without_derivatives(f"{base:g}**x", float(self.value))
        return (self * math.log(base)).exp()

    __radd__ = __add__
    __rmul__ = __mul__

    def __abs__(self) -> Jet:
        """Return the absolute value; at 0 there is a corner."""
        if self.value == 0.0 and not self._is_constant:
            raise _without_derivatives("abs", 0.0)
        return self if self.value >= 0.0 else -self

    # numpy calls these by name when a ufunc meets an array of objects.

    def __getattr__(self, name: str) -> Callable[[], Jet]:
        """Return an elementary function of this number, by numpy's name."""
        if name not in ELEMENTARY:
            raise AttributeError(name)
        return partial(self._apply, name)

    def _apply(self, name: str) -> Jet:
        """Return an elementary function of this number."""
        v = float(self.value)
        try:
            return self.compose(*ELEMENTARY[name](v))
        except (ArithmeticError, ValueError):
            raise _without_derivatives(name, v) from None

    def fabs(self) -> Jet:
        """Return the absolute value."""
        return abs(self)

    def square(self) -> Jet:
        """Return self times self."""
        return self * self

    def reciprocal(self) -> Jet:
        """Return 1 over self."""
        return self**-1

    def conjugate(self) -> Jet:
        """Return self, which is real."""
        return self

    def hypot(self, other: Jet | float) -> Jet:
        """Return sqrt(self^2 + other^2); at (0, 0) there is a corner."""
        b = self._as_jet(other)
        r = math.hypot(self.value, b.value)
        if r == 0.0:
            raise _without_derivatives("hypot", 0.0)
        s, c = self.value / r, b.value / r
        return self._compose_two(b, r, (s, c), (c * c / r, -s * c / r, s * s / r))

    def arctan2(self, other: Jet | float) -> Jet:
        """Return the angle of (other, self); it jumps where other <= 0 and self = 0."""
        x = self._as_jet(other)
        r = math.hypot(self.value, x.value)
        if self.value == 0.0 and x.value <= 0.0:
            raise _without_derivatives("arctan2", 0.0)
        s, c = self.value / r, x.value / r
        cross = 2.0 * s * c / r**2
        return self._compose_two(
            x,
            math.atan2(self.value, x.value),
            (c / r, -s / r),
            (-cross, (s * s - c * c) / r**2, cross),
        )

    def _as_jet(self, other: Jet | float) -> Jet:
        """Return a number as a Jet of the same inputs."""
        if isinstance(other, Jet):
            return other
        return Jet(float(other), np.zeros_like(self.gradient), None)

    def _compose_two(
        self,
        other: Jet,
        value: float,
        first: tuple[float, float],
        second: tuple[float, float, float],
    ) -> Jet:
        """Return g(self, other) from g, (g_a, g_b) and (g_aa, g_ab, g_bb)."""
        a, b = self.gradient, other.gradient
        cross = np.outer(a, b)
        bend = (
            second[0] * np.outer(a, a)
            + second[1] * (cross + cross.T)
            + second[2] * np.outer(b, b)
        )
        slopes = _add(_scale(self.hessian, first[0]), _scale(other.hessian, first[1]))
        return Jet(value, first[0] * a + first[1] * b, _add(bend, slopes))

    # Comparisons go by value: where, maximum, minimum, clip, sign and `if` use them.

    @property
    def _is_constant(self) -> bool:
        """Whether no input moves this number."""
        return not self.gradient.any() and (
            self.hessian is None or not self.hessian.any()
        )

    def _compare(self, other: object, by: Callable[[float, float], bool]) -> bool:
        """Compare values; equal ones only where they are equal around the point."""
        if not isinstance(other, (Jet, int, float, np.number)):
            raise TypeError(f"a number is compared with {other!r}")
        step = self - (other if isinstance(other, Jet) else float(other))
        if step.value == 0.0 and not step._is_constant:  # noqa: SLF001 - of this class
            raise ProblemError(
                "the function compares two equal numbers at the nominal inputs "
                f"({self.value:g}), so it may have a corner or a jump there (maximum, "
                f"where, sign): {REMEDY}"
            )
        return bool(by(step.value, 0.0))

    def __lt__(self, other: object) -> bool:
        """Whether self < other, by value."""
        return self._compare(other, operator.lt)

    def __le__(self, other: object) -> bool:
        """Whether self <= other, by value."""
        return self._compare(other, operator.le)

    def __gt__(self, other: object) -> bool:
        """Whether self > other, by value."""
        return self._compare(other, operator.gt)

    def __ge__(self, other: object) -> bool:
        """Whether self >= other, by value."""
        return self._compare(other, operator.ge)

    def __eq__(self, other: object) -> bool:
        """Whether self == other, by value."""
        return self._compare(other, operator.eq)

    def __ne__(self, other: object) -> bool:
        """Whether self != other, by value."""
        return self._compare(other, operator.ne)

    def __hash__(self) -> int:
        """Refuse: numbers that may not be compared are no keys."""
        raise TypeError("a Taylor number cannot be hashed")

    def __bool__(self) -> bool:
        """Whether the value is not 0."""
        return self != 0.0


def _without_derivatives(what: str, v: float) -> ProblemError:
    """Return the error of a function that has no value or derivatives at a point."""
    return ProblemError(f"{what} has no two derivatives at {v:g}: {REMEDY}")


OF_TWO = ("hypot", "arctan2")
OF_VALUES = ("isfinite", "isnan", "isinf")  # what numpy asks of floats only


class Jets(np.ndarray):
    """An array of Jets, among which plain numbers may stand."""

    def __array_ufunc__(
        self,
        ufunc: np.ufunc,
        method: str,
        *inputs: Any,  # noqa: ANN401 - as numpy has it
        **kwargs: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Apply a ufunc element by element, plain numbers by numpy itself."""
        plain = [x.view(np.ndarray) if isinstance(x, Jets) else x for x in inputs]
        name, out = ufunc.__name__, kwargs.get("out")
        if out is not None:
            kwargs["out"] = tuple(
                x.view(np.ndarray) if isinstance(x, Jets) else x for x in out
            )
        known = name in ELEMENTARY or name in OF_TWO
        if method == "__call__" and name in OF_VALUES:
            found = ufunc(
                np.asarray(np.frompyfunc(_value, 1, 1)(plain[0]), dtype=float)
            )
        elif method == "__call__" and known and out is None:
            found = np.frompyfunc(partial(_element, ufunc), ufunc.nin, 1)(*plain)
        else:
            found = getattr(ufunc, method)(*plain, **kwargs)
        if out is not None:
            return out[0]
        is_array = isinstance(found, np.ndarray) and found.dtype == object
        return found.view(Jets) if is_array else found


def _value(x: Jet | float) -> float:
    """Return the value of a Jet or a number."""
    return float(x.value if isinstance(x, Jet) else x)


def _element(ufunc: np.ufunc, *numbers: Jet | float) -> Jet | float:
    """Return a known ufunc of one or two numbers, some of them Jets."""
    first = next((x for x in numbers if isinstance(x, Jet)), None)
    if first is None:
        return float(ufunc(*(_value(x) for x in numbers)))
    if len(numbers) == 1:
        return first._apply(ufunc.__name__)  # noqa: SLF001 - of this module
    a, b = (first._as_jet(x) for x in numbers)  # noqa: SLF001
    return a.hypot(b) if ufunc.__name__ == "hypot" else a.arctan2(b)


@dataclass(frozen=True, kw_only=True, eq=False)
class Expansion:
    """A function and its derivatives at one point."""

    value: Array  # shape (n_out,)
    C: Array  # sensitivities dy/dx, shape (n_out, n_in) [unit of y / unit of x]
    # Second derivatives, shape (n_out, n_in, n_in) [unit of y / units of both x].
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

    Raises
    ------
    ProblemError
        It has no derivatives there, or uses what Taylor numbers cannot pass through.
    """
    n = point.size
    x = np.empty((n, 1), dtype=object).view(Jets)
    for i, unit in enumerate(np.eye(n)):
        x[i, 0] = Jet(float(point[i]), unit, None)
    try:
        return _parts(np.asarray(function(x))[:, 0], n)
    except BudgetError:
        raise
    except Exception as error:
        function(point[:, None])  # what it raises of plain numbers is its own fault
        raise ProblemError(
            "the function does something with its inputs that the Taylor numbers of "
            f"the law do not know ({type(error).__name__}: {error}). Use + - * / **, "
            f"abs, maximum, minimum, where, {', '.join(OF_TWO)}, "
            f"{', '.join(ELEMENTARY)} of numpy; or use sample() (Monte Carlo), which "
            "takes any"
        ) from error


def _parts(jets: Array, n: int) -> Expansion:
    """Return values and derivatives of Jets, shape (n_out,), as arrays."""
    value = np.zeros(jets.size)
    C, H = np.zeros((jets.size, n)), np.zeros((jets.size, n, n))
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


def _twice_the_product(a: Array, b: Array) -> Array | None:
    """Return a b^T + b a^T of two gradients; None where one of them is zero."""
    if not (a.any() and b.any()):
        return None
    cross = a[:, None] * b
    return cross + cross.T


def _scale(hessian: Array | None, factor: float) -> Array | None:
    """Scale a Hessian, None being zero."""
    return None if hessian is None or factor == 0.0 else hessian * factor
