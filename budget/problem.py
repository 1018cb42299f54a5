"""Uncertainty-propagation problem: inputs, outputs, measurement function.

A Problem knows no sensors and no statistics. Sensors make Problems
(budget.calibration), methods solve them (budget.methods); the published examples are
Problems too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from budget.arrays import Array, root_of_correlation
from budget.distributions import NORMAL, Distribution
from budget.errors import ProblemError
from budget.names import Name, as_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

Record = TypeVar("Record")
Function = Callable[[Array], Array]

# A covariance matrix may miss symmetry and positive semidefiniteness by rounding.
EXACT = 1e-13  # [1], to which a root gives its correlation matrix back
ROUNDING = 1e-10  # [1], relative to the product of the two standard uncertainties
# Standard uncertainties whose fourth powers, products of two variances, are numbers of
# full precision [SI].
LEAST_U, MOST_U = 1e-76, 1e76


@dataclass(frozen=True, kw_only=True)
class CommonScale:
    """What standard uncertainties from few readings have in common: their error.

    The true ones are those given times sqrt(v / chi^2_v), of v degrees of freedom: with
    that normal inputs are a joint Student t (JCGM 101:2008, 6.4.9).

    Attributes
    ----------
    degrees_of_freedom : float
        v [1].
    rows : tuple of int
        Inputs of the group that it is of.
    """

    degrees_of_freedom: float
    rows: tuple[int, ...]

    def of(self, chi_squared: Array) -> Array:
        """Return sqrt(v / chi^2_v), same shape [1]."""
        return np.asarray(np.sqrt(self.degrees_of_freedom / chi_squared))


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Input quantities that belong to one source and are drawn together.

    Attributes
    ----------
    name : Name or str
        The source, as it stands in budgets; kept as a Name.
    mean : ndarray, shape (n,)
        Best estimates [SI]; lists are taken too, and kept as arrays.
    covariance : ndarray, shape (n, n)
        Covariance within the group [SI squared]; groups are independent.
    distributions : tuple of Distribution, length n
        Shapes; correlated inputs are normal.
    pool : str
        Groups of one pool enter the function as the sum of their rows and in no other
        way; '' of a group that enters on its own.
    scales : tuple of CommonScale
        Of standard uncertainties from few readings.

    Raises
    ------
    ProblemError
        Shapes do not fit, the covariance is no covariance (JCGM 102:2011, 5.2.1: it is
        positive semidefinite), or inputs are correlated that are not normal.
    """

    name: Name
    mean: Array
    covariance: Array
    distributions: tuple[Distribution, ...]
    pool: str = ""
    scales: tuple[CommonScale, ...] = ()

    def __post_init__(self) -> None:
        """Check the group once, where it enters."""
        where = f"input group {self.name!r}"
        if not isinstance(self.name, str):
            raise ProblemError(f"{where}: a name is a text")
        object.__setattr__(self, "name", as_name(self.name))
        for name in ("mean", "covariance"):  # own copies, that nobody can change
            array = _numbers(getattr(self, name), f"{where}: {name}").copy()
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(
            self, "distributions", _shapes(self.distributions, where=where)
        )
        n = self.mean.size
        if self.mean.ndim != 1 or self.covariance.shape != (n, n):
            raise ProblemError(
                f"{where}: mean has shape {self.mean.shape}, covariance "
                f"{self.covariance.shape}; expected (n,) and (n, n)"
            )
        if len(self.distributions) != n:
            raise ProblemError(
                f"{where}: {len(self.distributions)} distributions for {n} inputs; "
                "give one each"
            )
        if not (np.isfinite(self.mean).all() and np.isfinite(self.covariance).all()):
            raise ProblemError(f"{where}: a mean or covariance is not finite")
        if (np.diag(self.covariance) < 0.0).any():
            raise ProblemError(f"{where}: a variance is negative")
        if not self.is_independent:
            self._check_correlated(where)

    def _check_correlated(self, where: str) -> None:
        """Check a covariance of inputs that are not independent."""
        scale = np.sqrt(np.abs(np.diag(self.covariance)))
        slack = ROUNDING * np.outer(scale, scale)
        if (np.abs(self.covariance - self.covariance.T) > slack).any():
            raise ProblemError(f"{where}: the covariance matrix is not symmetric")
        if (np.abs(self.covariance) > np.outer(scale, scale) + slack).any():
            raise ProblemError(f"{where}: a correlation is larger than 1")
        _ = self.factor  # says no to a covariance that has none
        if any(d != NORMAL for d in self.drawn):
            raise ProblemError(
                f"{where}: inputs are correlated that are not all normal; a covariance "
                "does not say their joint distribution. Take jcgm.Copula in the place "
                "of Group (docs/problems.md), or normal inputs"
            )

    @classmethod
    def independent(
        cls,
        name: Name | str,
        *,
        u: ArrayLike,
        mean: ArrayLike = 0.0,
        distribution: Distribution | Sequence[Distribution] = NORMAL,
    ) -> Group:
        """Make a group of uncorrelated inputs from standard uncertainties [SI]."""
        where = f"input group {name!r}"
        u_x = np.atleast_1d(_numbers(u, f"{where}: u"))
        estimate = _numbers(mean, f"{where}: mean")
        if u_x.ndim != 1 or estimate.shape not in {(), (1,), u_x.shape}:
            raise ProblemError(
                f"{where}: u has shape {u_x.shape}, mean {estimate.shape}; expected "
                "one u for each input, and one mean for each or for all"
            )
        if (u_x < 0.0).any():
            raise ProblemError(
                f"{where}: a standard uncertainty is {u_x.min()}, expected 0 or more"
            )
        # Methods carry variances, and second-order terms products of them.
        lost = u_x[(u_x > 0.0) & ((u_x < LEAST_U) | (u_x > MOST_U))]
        if lost.size:
            raise ProblemError(
                f"{where}: a standard uncertainty is {lost[0]:g}, whose powers are no "
                f"numbers of double precision; expected 0, or {LEAST_U:g} to "
                f"{MOST_U:g}: take another unit"
            )
        shapes = (
            (distribution,) * u_x.size
            if isinstance(distribution, Distribution)
            else distribution
        )
        shapes = _shapes(shapes, where=where)
        mean = np.array(np.broadcast_to(estimate, u_x.shape))
        is_checked = len(shapes) == u_x.size and np.isfinite(u_x + mean).all()
        make = cls.known if is_checked else cls  # which says what is wrong
        return make(
            name=as_name(name),
            mean=mean,
            covariance=np.diag(u_x**2),
            distributions=shapes,
        )

    @classmethod
    def known(
        cls,
        *,
        name: Name,
        mean: Array,
        covariance: Array,
        distributions: tuple[Distribution, ...],
        pool: str = "",
        scales: tuple[CommonScale, ...] = (),
    ) -> Group:
        """Make a group of what is known to fit, and is nobody else's: unchecked."""
        for array in (mean, covariance):
            array.flags.writeable = False
        self = object.__new__(cls)
        vars(self).update(
            name=name,
            mean=mean,
            covariance=covariance,
            distributions=distributions,
            pool=pool,
            scales=scales,
        )
        return self

    @property
    def size(self) -> int:
        """Number of inputs, n."""
        return self.mean.size

    @cached_property
    def is_independent(self) -> bool:
        """Whether no two inputs of the group are correlated."""
        found = np.count_nonzero(self.covariance)
        return bool(found == np.count_nonzero(np.diag(self.covariance)))

    @cached_property
    def is_constant(self) -> bool:
        """Whether nothing in the group varies."""
        return not self.covariance.any()

    @cached_property
    def factor(self) -> Array:
        """Matrix F, shape (n, n): F z has the covariance, z being unit variates [SI].

        Taken of the correlation matrix, so that inputs of very different size keep
        their relative accuracy.

        Raises
        ------
        ProblemError
            The covariance has a negative eigenvalue beyond rounding.
        """
        u = np.sqrt(np.diag(self.covariance))
        if self.is_independent:
            return np.diag(u)
        root, least = checked_root(self.correlation, scale=u)
        if root is None:
            # R of least eigenvalue l < 0: that of (1 - s) I + s R is 1 - s + s l.
            raise ProblemError(
                f"input group {self.name!r}: its correlations contradict each other: "
                f"the correlation matrix has the eigenvalue {least:.3g}, and those of "
                "a covariance are 0 or more. Compute it from readings taken together "
                "(numpy.cov), or make the correlations smaller: all of them times "
                f"{1.0 / (1.0 - least):.3g} would do"
            )
        return root

    @property
    def drawn(self) -> tuple[Distribution, ...]:
        """Shapes of the independent variates that `deviations` takes."""
        return self.distributions

    @cached_property
    def is_normal(self) -> bool:
        """Whether all independent variates are normal."""
        return all(shape == NORMAL for shape in self.drawn)

    def deviations(self, z: Array, out: Array | None = None) -> Array:
        """Return deviations from the mean, shape (n, trials) [SI].

        Parameters
        ----------
        z : ndarray, shape (n, trials)
            Independent variates of the shapes `drawn`, of unit standard uncertainty.
        out : ndarray, shape (n, trials), optional
            Where they go.
        """
        if self.is_independent:
            return np.multiply(self._scale, z, out=out)
        return np.matmul(self.factor, z, out=out)

    @cached_property
    def _scale(self) -> Array:
        """The diagonal of a factor that is diagonal, shape (n, 1) [SI]."""
        return np.diag(self.factor)[:, None]

    @property
    def correlation(self) -> Array:
        """Correlation matrix, shape (n, n); rows of 0 for what does not vary."""
        u = np.sqrt(np.diag(self.covariance))
        safe = np.where(u > 0.0, u, 1.0)
        return np.asarray(self.covariance / np.outer(safe, safe))


@dataclass(frozen=True, kw_only=True)
class Output:
    """One quantity that is asked for.

    Attributes
    ----------
    name : Name or str
        Dotted, from the general to the particular: 'gyro.scale_factor.x'; kept as a
        Name.
    unit : str
        The unit it is printed in.
    si_per_unit : float
        Size of that unit [SI].
    resolution : float
        A spread at or below this is rounding of the computation, not spread [SI].
    length_of : tuple of Name, two, or ()
        The components of a vector in a plane, both outputs themselves, whose length
        this is. It counts with the sign of the first one: so its mean is 0 where
        theirs are, its standard uncertainty the root sum of squares of theirs (DRMS),
        and the largest end of its interval the radius of a circle of that coverage.
    """

    name: Name
    unit: str = "1"
    si_per_unit: float = 1.0
    resolution: float = 0.0
    length_of: tuple[Name, ...] = ()

    def __post_init__(self) -> None:
        """Keep a text as a Name."""
        object.__setattr__(self, "name", as_name(self.name))


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Independent groups of inputs, named outputs, and the function between them.

    Attributes
    ----------
    groups : tuple of Group
        Sources; the inputs are theirs, one group after another.
    outputs : tuple of Output
        What the function returns, in its order.
    function : callable, (n_arguments, trials) -> (n_outputs, trials)
        The model [SI], of the inputs with each pool added up (see `arguments`). Plain
        numpy arithmetic that keeps the dtype of its argument: the methods pass float
        arrays and arrays of Taylor numbers through it. Lengths stand after all other
        outputs, and it does not return them.

    Raises
    ------
    ProblemError
        A name stands twice, there are no outputs, or a length is of no outputs that
        stand before it.
    """

    groups: tuple[Group, ...]
    outputs: tuple[Output, ...]
    function: Function = field(repr=False)

    def __post_init__(self) -> None:
        """Check names; shapes are checked where the function is first called."""
        object.__setattr__(self, "groups", _records(self.groups, "groups", Group))
        object.__setattr__(self, "outputs", _records(self.outputs, "outputs", Output))
        if not callable(self.function):
            raise ProblemError(
                f"the function is {self.function!r}; expected a callable that takes "
                "inputs (n_inputs, trials) and returns outputs (n_outputs, trials)"
            )
        if not self.outputs:
            raise ProblemError("a Problem needs at least one output")
        for kind, names in (
            ("input group", [g.name for g in self.groups]),
            ("output", [o.name for o in self.outputs]),
        ):
            twice = sorted({n for n in names if names.count(n) > 1})
            if twice:
                raise ProblemError(f"{kind} named twice: {', '.join(twice)}")
        _ = self.legs  # says no to lengths of what is not there

    @property
    def n_inputs(self) -> int:
        """Number of input quantities over all groups."""
        return sum(group.size for group in self.groups)

    @property
    def normals_per_trial(self) -> int:
        """Number of variates that one Monte Carlo trial of the totals draws."""
        return sum(group.size for group in self.pooled.groups if not group.is_constant)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Rows of the input array that belong to each group."""
        ends = np.cumsum([group.size for group in self.groups], dtype=int)
        return tuple(
            slice(int(end) - group.size, int(end))
            for end, group in zip(ends, self.groups, strict=True)
        )

    @property
    def input_covariance(self) -> Array:
        """U_x of all inputs, shape (n_in, n_in)."""
        found = np.zeros((self.n_inputs, self.n_inputs))
        for group, rows in zip(self.groups, self.slices, strict=True):
            found[rows, rows] = group.covariance
        return found

    @cached_property
    def arguments(self) -> tuple[slice, ...]:
        """Rows of the function's argument that each group is added to."""
        return arguments(self.groups)

    @cached_property
    def legs(self) -> NDArray[np.intp]:
        """Rows of the two components of each length, shape (2, n_lengths)."""
        names = [output.name for output in self.outputs if not output.length_of]
        for place, output in enumerate(self.outputs):
            is_last = place >= len(names)
            fits = len(output.length_of) == 2 and {*output.length_of} <= {*names}  # noqa: PLR2004
            if is_last != bool(output.length_of) or (is_last and not fits):
                raise ProblemError(
                    f"output {output.name!r} is the length of {output.length_of!r}; "
                    "expected two outputs that are no lengths, and lengths after them"
                )
        places = [[names.index(leg) for leg in o.length_of] for o in self.outputs]
        return np.array([one for one in places if one], dtype=np.intp).reshape(-1, 2).T

    @cached_property
    def has_pools(self) -> bool:
        """Whether some groups share rows of the function's argument."""
        pools = [group.pool for group in self.groups if group.pool]
        return len(set(pools)) < len(pools)

    @cached_property
    def pooled(self) -> Problem:
        """The Problem with the normal groups of each pool drawn as one.

        Its outputs have the same joint distribution: a sum of independent normal
        vectors is normal, with the sum of their means and covariances. For whoever asks
        for totals, and not for sources.
        """
        if not self.has_pools:
            return self
        groups: list[Group] = []
        for key in dict.fromkeys(group.pool or group.name for group in self.groups):
            members = [g for g in self.groups if (g.pool or g.name) == key]
            normal = [
                g
                for g in members
                if all(d == NORMAL for d in g.distributions) and not g.scales
            ]
            if len(normal) < 2:  # noqa: PLR2004 - nothing to add up
                groups.extend(members)
                continue
            groups.append(
                Group(
                    name=as_name(normal[0].pool),
                    mean=np.sum([group.mean for group in normal], axis=0),
                    covariance=np.sum([group.covariance for group in normal], axis=0),
                    distributions=normal[0].distributions,
                    pool=normal[0].pool,
                )
            )
            groups.extend(group for group in members if group not in normal)
        return replace(self, groups=tuple(groups))

    def resized(self, factors: Array) -> Problem:
        """Return it with every standard uncertainty of each group times its factor.

        Shape (n_groups,) [1].
        """
        groups = (
            group
            if factor == 1.0
            else replace(group, covariance=group.covariance * factor**2)
            for group, factor in zip(self.groups, factors.tolist(), strict=True)
        )
        return replace(self, groups=tuple(groups))

    @cached_property
    def mean(self) -> Array:
        """Best estimates of all inputs, shape (n_inputs,) [SI]."""
        return np.concatenate([np.empty(0), *(group.mean for group in self.groups)])

    def add_up(self, x: Array) -> Array:
        """Return the function's argument, (n_arguments, trials): pools added up."""
        if not self.has_pools:
            return x
        n = max(rows.stop for rows in self.arguments)
        argument = np.zeros_like(x, shape=(n, x.shape[1]))
        for rows, place in zip(self.slices, self.arguments, strict=True):
            argument[place] += x[rows]
        return argument

    @cached_property
    def columns(self) -> NDArray[np.intp]:
        """Row of the function's argument that each input is added to, (n_inputs,)."""
        places = [np.arange(rows.start, rows.stop) for rows in self.arguments]
        return np.concatenate([np.empty(0, dtype=np.intp), *places])

    def then(self, function: Function, outputs: Iterable[Output]) -> Problem:
        """Return the Problem of what follows from the outputs of this one.

        Inputs and their draws stay, and the joint distribution of the outputs goes
        through the function whole: every method solves the chain as one model.

        Parameters
        ----------
        function : callable, (n_outputs, trials) -> (n_new, trials)
            Of all outputs of this Problem [SI], in plain numpy arithmetic as its own;
            a function of a module, or an object, where other processes are to call it.
        outputs : iterable of Output
            What it returns, in its order.

        Raises
        ------
        ProblemError
            As for any Problem.
        """
        chain = _Chain(first=self, last=function)
        return replace(self, outputs=tuple(outputs), function=chain)

    def evaluate(self, x: Array) -> Array:
        """Call the function and hold it to its shape.

        Parameters
        ----------
        x : ndarray, shape (n_inputs, trials)
            Input values [SI].

        Returns
        -------
        ndarray, shape (n_outputs, trials)
            Output values [SI].

        Raises
        ------
        ProblemError
            The function returns another shape, or no array.
        """
        return self.evaluate_argument(self.add_up(x))

    def evaluate_argument(self, argument: Array) -> Array:
        """Call the function as `evaluate` does, on inputs whose pools are added up."""
        y = self.components(argument)
        if not self.legs.size:
            return y
        first, second = y[self.legs]
        return np.concatenate([y, np.copysign(np.hypot(first, second), first)])

    def components(self, argument: Array) -> Array:
        """Return the outputs that the function returns, those that are no lengths."""
        returned = self.function(argument)
        try:
            y = np.asarray(returned)
        except ValueError as error:  # rows of different length
            raise ProblemError(
                f"the function returned no array ({error}); return one row for each "
                "output, as np.stack returns it"
            ) from error
        expected = (len(self.outputs) - self.legs.shape[1], argument.shape[1])
        if y.shape != expected:
            raise ProblemError(
                f"the function returned shape {y.shape} for {argument.shape[1]} "
                f"trials, expected {expected}: one row for each output"
            )
        return y


@dataclass(frozen=True, kw_only=True, eq=False)
class _Chain:
    """A function of the outputs of a Problem, as one of its arguments."""

    first: Problem
    last: Function

    @property
    def is_steady(self) -> bool:
        """Whether the first is the same whenever it is called."""
        return getattr(self.first.function, "is_steady", False)

    def __call__(self, argument: Array) -> Array:
        """Return what follows, shape (n_new, trials) [SI]."""
        return self.last(self.first.evaluate_argument(argument))


def arguments(groups: tuple[Group, ...]) -> tuple[slice, ...]:
    """Return the rows of a function's argument that each group is added to.

    A group without a pool has rows of its own; a pool has those of its first member,
    and every other member adds to them.

    Raises
    ------
    ProblemError
        Groups of one pool differ in size.
    """
    places: list[slice] = []
    pools: dict[str, slice] = {}
    end = 0
    for group in groups:
        place = pools.get(group.pool) if group.pool else None
        if place is None:
            place = slice(end, end + group.size)
            end = place.stop
            if group.pool:
                pools[group.pool] = place
        elif place.stop - place.start != group.size:
            raise ProblemError(
                f"input group {group.name!r} has {group.size} inputs, its pool "
                f"{group.pool!r} {place.stop - place.start}; expected the same number"
            )
        places.append(place)
    return tuple(places)


def _numbers(given: ArrayLike, where: str) -> Array:
    """Return what is given as an array of floats.

    Raises
    ------
    ProblemError
        It is none: rows of different length, words, complex numbers.
    """
    try:
        if np.iscomplexobj(given):
            raise TypeError("complex numbers")  # noqa: TRY301 - told as the others are
        return np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise ProblemError(
            f"{where} is no array of real numbers ({error}); give numbers, all rows of "
            "one length"
        ) from error


def _shapes(
    given: Distribution | Sequence[Distribution], *, where: str
) -> tuple[Distribution, ...]:
    """Return distributions as a tuple, one alone too."""
    found = (given,) if isinstance(given, Distribution) else given
    return _records(found, f"{where}: distributions", Distribution)


def _records(
    given: Iterable[Record], where: str, kind: type[Record]
) -> tuple[Record, ...]:
    """Return a sequence as a tuple, all of one class.

    Raises
    ------
    ProblemError
        It holds something else.
    """
    alone = isinstance(given, str) or not isinstance(given, Iterable)
    found: tuple[Any, ...] = (given,) if alone else tuple(given)
    for item in found:
        if not isinstance(item, kind):
            raise ProblemError(
                f"{where} has {item!r}, expected objects of class {kind.__name__}"
            )
    return found


def checked_root(correlation: Array, *, scale: Array) -> tuple[Array | None, float]:
    """Return diag(scale) R^(1/2), None where there is none, and the least eigenvalue.

    The eigenvalue is found only where the root does not give the correlation back, else
    it is 0.
    """
    root = root_of_correlation(correlation)
    least = 0.0
    if np.abs(root @ root.T - correlation).max(initial=0.0) > EXACT * len(correlation):
        least = float(np.linalg.eigvalsh(correlation)[0])
    if least < -ROUNDING * len(correlation):
        return None, least
    return np.asarray(scale[:, None] * root), least
