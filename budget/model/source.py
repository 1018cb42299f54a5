"""Error sources: owner, duration, effect on a window average.

A source acts in one of five ways. An Offset is part of the truth: a constant added to a
bias, a scale factor or a mounting angle. A Noise is a process, seen through its window
averages. A Disturbance is anything else that a reading or the table's input may hold. A
Change is part of the truth that is another one at a later turn-on. A Coefficient does
nothing alone: a source that multiplies it does.

Each Noise and Disturbance says the same thing twice, by closed form for the window
averages and sample by sample for the simulation; their agreement is tested.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from budget.arrays import Array
from budget.model.noise import of_size_1
from budget.model.response import STATISTICS
from budget.names import AXES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.distributions import Distribution
    from budget.model.course import Course
    from budget.model.noise import Process
    from budget.model.place import Place
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.windows import Schedule, Timing, Window

GYRO, ACCELEROMETER = "gyro", "accelerometer"
STATION, ENVIRONMENT, PROCEDURE = "station", "environment", "procedure"
SENSORS = (GYRO, ACCELEROMETER)
SHARED = (STATION, ENVIRONMENT, PROCEDURE)  # what all triads share
OWNERS = (*SENSORS, *SHARED)

# How long a source keeps its value.
DEVICE, TURN_ON, TEST, IN_RUN = "device", "turn-on", "test", "in run"

# Hues of Okabe and Ito, as figures have them, by name.
COLOURS = "orange", "sky", "green", "yellow", "blue", "vermilion", "purple", "black"


@dataclass(frozen=True, kw_only=True, eq=False)
class Given:
    """What a file gives of one source.

    Attributes
    ----------
    name : str
        The key: 'bias_stability'.
    u : ndarray, shape (n_axes,)
        Standard uncertainty, process sigma, density or coefficient by axis [SI]; a
        coefficient of temperature has a sign.
    distributions : tuple of Distribution
        Shape by axis; processes are normal.
    own : mapping of str to float
        Values of the keys that its source has, where it has any [SI].
    correlation_time : ndarray, shape (n_axes,), or None
        Of a source that has one [s].
    low_cut : ndarray, shape (n_axes,), or None
        Frequency below which a flicker has no power [Hz].
    points : ndarray or None
        Times of a source that has several, from the start of the test, rising [s].
    form : str
        Which of the effects of its source it is meant as; '' the usual one.
    horizons : tuple of (float, float)
        Ages of a calibration for which the maker prints it, rising [s], and its size
        there over u [1], the last 1; () where none is printed.
    course : Course or None
        Of a temperature or a vibration of the use: it at every time of a mission, where
        that is known; u is the largest then. Of a line that it acts by likewise.
    degrees_of_freedom : tuple of float or None
        Of u, where few readings gave it: one of all axes together, or one of each, None
        of one that is known [1]; () where all are.
    """

    name: str
    u: Array
    distributions: tuple[Distribution, ...]
    own: Mapping[str, float] = field(default_factory=dict)
    correlation_time: Array | None = None
    low_cut: Array | None = None
    points: Array | None = None
    form: str = ""
    horizons: tuple[tuple[float, float], ...] = ()
    course: Course | None = None
    degrees_of_freedom: tuple[float | None, ...] = ()

    @property
    def largest(self) -> float:
        """Size of the largest axis, of a coefficient whatever its sign [SI]."""
        return float(abs(self.u).max())


@dataclass(frozen=True, kw_only=True)
class Key:
    """What a file may say beside the value of a line, for its effect.

    Attributes
    ----------
    name : str
    unit : str
        The most usual one of it; it is above 0.
    usual : float
        What is taken where a file does not say it, which is printed [SI].
    says : str
        What it is, in words.
    """

    name: str
    unit: str
    usual: float
    says: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Triad:
    """One triad under test, as its disturbances see it.

    Attributes
    ----------
    scheme : Scheme
    given : mapping of str to Given
        What its data sheet and the environment give, by key.
    statistics : Statistics
        Of the window averages of its noise.
    """

    scheme: Scheme
    given: Mapping[str, Given]
    statistics: Statistics


@dataclass(frozen=True, kw_only=True, eq=False)
class Statistics:
    """Linear combinations of window averages that a calibration uses of its noise.

    Attributes
    ----------
    weights : ndarray, shape (3, k, n)
        For each axis: the rows of W, then those that disturbances ask for and that do
        not follow from rows before them. Where W has more rows than there are windows:
        the windows themselves.
    own : ndarray, shape (3, m, k), or None
        What makes the rows of W of these; None: they are the first m.
    """

    weights: Array
    own: Array | None = None
    # Covariances that processes of size 1 give them, by axis.
    _kept: dict[tuple[Process, int], Array] = field(default_factory=dict, repr=False)

    def covariance(self, process: Process, axis: int, schedule: Schedule) -> Array:
        """Return what a process gives them on an axis, shape (k, k) [SI squared].

        It goes with the square of its size: devices of one schedule share the rest.
        """
        size, alike = of_size_1(process)
        if (alike, axis) not in self._kept:
            if len(self._kept) >= MOST_KEPT:
                self._kept.clear()
            self._kept[alike, axis] = alike.reduce(schedule, self.weights[axis])
        return np.asarray(size**2 * self._kept[alike, axis])

    @classmethod
    def of(cls, scheme: Scheme, more: list[Array]) -> Statistics:
        """Take the rows of W and, of more rows (3, m, n), those that are new."""
        T = scheme.weights
        n = T.shape[2]
        if T.shape[1] > max(n, STATISTICS):
            return cls(weights=np.tile(np.eye(n), (3, 1, 1)), own=T)
        for row in (rows[:, k : k + 1] for rows in more for k in range(rows.shape[1])):
            if (_remainder(T, row) > DEPENDENT).any():
                T = np.concatenate([T, row], axis=1)
        return cls(weights=T)

    def coefficients(self, rows: Array) -> Array:
        """Return R with rows = R weights, shape (3, m, k) for rows of (3, m, n)."""
        R = np.stack(
            [_solve(T, own) for T, own in zip(self.weights, rows, strict=True)]
        )
        R[np.abs(R) < DEPENDENT * np.abs(R).max(initial=0.0)] = 0.0
        return R


MOST_KEPT = 256  # covariances of processes of size 1, of one calibration
DEPENDENT = 1e-9  # part of a row that may be left of it if it follows from others [1]


def _solve(T: Array, rows: Array) -> Array:
    """Return R of least squares with rows = R T, both scaled to rows of length 1."""
    size = np.linalg.norm(T, axis=1)
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq((T / size[:, None]).T, rows.T)[0].T / size)


def _remainder(T: Array, row: Array) -> Array:
    """Return what part of a row (3, 1, n) does not follow from T, shape (3,)."""
    left = [
        np.linalg.norm(own - _solve(t, own) @ t) / (np.linalg.norm(own) or 1.0)
        for t, own in zip(T, row, strict=True)
    ]
    return np.array(left)


class Effect:
    """What a source does.

    Attributes
    ----------
    needs : str
        Sentence (budget.sentences) on what has to be there, besides the source, for it
        to reach anything.
    removed : str
        Likewise on what makes it cancel, where a good test is made so that it does;
        else ''.
    removed_by_norm : str
        Likewise of a test that finds its parameters by the norm of gravity.
    is_process : bool
        Whether it is a random process, though no Noise.
    formula : str
        What it adds to a reading, as typst has it, for the method of a report: of a
        Noise the variance of a window's mean; '' where none is printed.
    letters : str
        What it is and what the letters of the formula are: a sentence, or a text.
    """

    needs: ClassVar[str] = "sources.windows"
    is_process: ClassVar[bool] = False
    removed: ClassVar[str] = ""
    removed_by_norm: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    letters: ClassVar[str] = ""


@dataclass(frozen=True)
class Offset(Effect):
    """A constant that is added to what the calibration is to find.

    Attributes
    ----------
    target : str
        'bias', 'scale_factor' (relative) or 'mounting_angle'.
    """

    target: str


@dataclass(frozen=True)
class Nonlinearity(Offset):
    """What a parameter differs by where the input is another one than in the test.

    Of a curve of which only that is known: a calibration at one input does not take it
    out, so at a later turn-on, in use, it counts in full.
    """


@dataclass(frozen=True)
class Initial(Offset):
    """What a unit has of it from its making, unknown until a calibration finds it.

    A parameter that is estimated holds it, whatever its size, and so does what its
    error is counted from: there it is part of the nominal value. It counts where the
    parameter is held at the value of the design.
    """


class Noise(Effect):
    """A zero-mean Gaussian process of each axis."""

    @abstractmethod
    def process(self, given: Given, axis: int, sample_rate: float) -> Process:
        """Return the process of one axis, for its window averages."""

    @abstractmethod
    def sampler(
        self, given: Given, rng: np.random.Generator, sample_rate: float
    ) -> Callable[[Samples], Array]:
        """Return what yields the next samples of the process, shape (3, n)."""


# Errors of the statistics, shape (3, 4, trials), from a source's inputs (n, trials),
# the truth, and the noise of the statistics, shape (3, k, trials).
Act = Callable[[Array, "Truth", Array], Array]


class Disturbance(Effect):
    """Anything else in a reading, or in the input that the table gives.

    One that says what it adds `in_use`, and nothing else, adds that in the windows of a
    test too, at their nominal inputs, and in the samples of a simulation.

    Attributes
    ----------
    order : int
        Power of the axis' own input that it is a coefficient of; 0 of none.
    """

    order: int = 0

    def size(self, given: Given, scheme: Scheme | None) -> int:  # noqa: ARG002
        """Return how many independent inputs the source has; one for each value."""
        return given.u.size

    def covariance(self, given: Given, triads: Sequence[Triad]) -> Array | None:  # noqa: ARG002
        """Return the covariance of its inputs, where they are of one process."""
        return None

    def part(self, triads: Sequence[Triad], place: int) -> slice:  # noqa: ARG002
        """Return which of its inputs reach the triad at that place."""
        return slice(None)

    def draw(self, given: Given, rng: np.random.Generator) -> Array | None:  # noqa: ARG002
        """Draw what the simulation is given of it; None: a value of each input."""
        return None

    def weights(self, scheme: Scheme) -> Array | None:  # noqa: ARG002
        """Return rows of weights, (3, m, n), whose noise the effect needs besides W."""
        return None

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return what the source does to this triad; None: nothing at all.

        It is sent to other processes: a partial of a function of its module. By itself
        the weighed means over the windows of what it adds in use.
        """
        scheme = triad.scheme
        added = self.in_use(scheme.within, scheme.forces)
        if added is None:
            return None
        means = np.moveaxis(added.mean(axis=1), 1, 0)  # (3, n, values)
        weighed = (scheme.weights[..., None] * means[:, None]).sum(axis=2)
        return partial(_added, weighed=weighed)

    def reading(self, value: Array, moment: SimulatedWindow) -> Array:
        """Return what is added to the readings of a window's samples, (3, n)."""
        x, force = np.broadcast_arrays(moment.true_input.T, moment.force.T)
        added = self.in_use(x, force)
        return np.zeros((3, 1)) if added is None else np.asarray((added @ value).T)

    def in_use(self, x: Array, force: Array) -> Array | None:  # noqa: ARG002
        """Return what inputs of 1 add to the readings of their triad in later use.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
            Nominal input of each axis itself, M u + b [unit of the input].
        force : ndarray, shape (..., 3)
            Specific force in body axes [m/s^2].

        Returns
        -------
        ndarray, shape (..., 3, n), or None
            None: nothing, it is one of the test alone.
        """
        return None

    def table(self, value: Array, table: TableState) -> TableState:  # noqa: ARG002
        """Return the table as it really stands during a window."""
        return table


def _added(
    x: Array,
    truth: Truth,  # noqa: ARG001
    noise: Array,  # noqa: ARG001
    *,
    weighed: Array,
) -> Array:
    """Return what values x (n, trials) add, weighed (3, k, n) for values of 1."""
    return np.asarray((weighed[..., None] * x).sum(axis=2))


Gains = tuple[Array, Array]  # of a source's inputs in a parameter: in the test, later


class TurnOnChange(Effect):
    """A constant part of the truth that is another one at a later turn-on."""

    @abstractmethod
    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:
        """Return what each parameter takes of it, (3, n) in the test and later.

        By 'bias', 'scale_factor' or 'mounting_angle', from all that data sheet and
        environment give.
        """


class Coefficient(Effect):
    """A fixed sensitivity of a device, or a known size of what it is sensitive to.

    Attributes
    ----------
    partners : tuple of str
        Lines of a sensor that a known size acts by; () of a sensitivity.
    """

    partners: ClassVar[tuple[str, ...]] = ()


@dataclass(frozen=True, kw_only=True)
class Samples:
    """The sampling of one window: n samples at the middle of steps of dt."""

    n: int
    dt: float  # [s]
    first: float  # time of the first sample [s]

    @property
    def last(self) -> float:
        """Time of the last sample [s]."""
        return self.first + (self.n - 1) * self.dt

    @property
    def times(self) -> Array:
        """Times of the samples, shape (n,) [s]."""
        return self.first + self.dt * np.arange(self.n, dtype=float)


@dataclass(frozen=True, kw_only=True, eq=False)
class TableState:
    """The table and the place during one simulated window.

    Attributes
    ----------
    turn : int or None
        Number of the turn among those of all triads; None of a dwell.
    stop : int
        Number of the stop among those of all triads.
    turning : int or None
        Place of the axis that turns in the chain from the base; None of a dwell.
    angle : float
        That the table really turns [rad].
    length : float
        Of the window, by the clock [s].
    place : Place
        Where it really is.
    timing : Timing
        What the test goes by where the table turns.
    pace : float
        Real length of a window over that by the clock [1].
    joints : ndarray, shape (4, 3, 3)
        Rotations that should not be there: of the base, and after each axis of the
        table, the last one that of the body in its mount.
    """

    turn: int | None
    stop: int
    turning: int | None
    angle: float
    length: float
    place: Place
    timing: Timing
    pace: float = 1.0
    joints: Array = field(default_factory=lambda: np.array([np.eye(3)] * 4))

    def askew(self, joint: int, axis: int, angle: float) -> TableState:
        """Return the table with one joint turned about a coordinate axis [rad]."""
        a = np.eye(3)[axis]
        cross = np.cross(a, np.eye(3)).T  # cross @ v = a x v
        turned = np.eye(3) + np.sin(angle) * cross
        turned += (1.0 - np.cos(angle)) * cross @ cross  # Rodrigues
        joints = self.joints.copy()
        joints[joint] = joints[joint] @ turned
        return replace(self, joints=joints)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedWindow:
    """The samples of one simulated window, before the scale factor.

    Attributes
    ----------
    owner : str
        Whose readings they are.
    window : Window
    samples : Samples
    force : ndarray, shape (3, n) or (3, 1)
        Specific force in body axes [m/s^2].
    true_input, reading : ndarray, shape (3, n) or (3, 1)
        M u + b, and with the noise [unit of the input].
    known : mapping of str to Given
        What the data sheet of the triad and the environment give.
    given : Given
        What the file gives of the source that is asked.
    """

    owner: str
    window: Window
    samples: Samples
    force: Array
    true_input: Array
    reading: Array
    known: Mapping[str, Given]
    given: Given


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """One error source: a key in a file, and what becomes of it.

    Attributes
    ----------
    name : str
        The key; with dots where the file nests it.
    units : mapping of str to str
        Owner and most usual unit of its value there.
    model : str
        What it is, in words.
    effect : Effect
    stays : str
        DEVICE, TURN_ON, TEST or IN_RUN.
    axes : tuple of str
        Names of its values; ('',) where it has one.
    expected : str
        What a verdict 'meets' cannot do without: the line itself, 'noise' where any one
        noise line will do, '' where the line may be absent.
    colour : str
        In figures: one of Okabe and Ito's, by name; '' of one that is left over.
    is_hatched : bool
        The second source of a colour.
    forms : mapping of str to Effect
        What else a file may mean by it, by the word that says so.
    time : str
        Key beside it, under environment, of a time that it needs; '' if none.
    points : str
        Likewise of several times.
    keys : tuple of Key
        What a file may say beside its value, for its effect.
    value : str
        What a file may say of its value, where that is more than of any constant or
        process: a word of budget.inputs.specification.
    beside : tuple of str
        Lines that may say the same once more, of which each sensor has one at most.
    over_temperature : str
        Line where its value stands if the maker means that over temperature.
    left_of : tuple of str
        Coefficients of which it is what a compensation leaves.
    use : str
        What of a later use it acts in: 'temperature', 'vibration', 'age'; '' of all.
    is_asked : bool
        Of every axis, where a test or a use exercises it.
    grades : tuple of str
        Sensors whose grade goes by it.
    words : tuple of str
        What makers call it, of one that comes from outside.
    origin : str
        What it comes from: the distribution and its entry point; '' of our own.
    """

    name: str
    units: Mapping[str, str]
    model: str
    effect: Effect
    stays: str
    axes: tuple[str, ...] = AXES
    expected: str = ""
    colour: str = "purple"
    is_hatched: bool = False
    forms: Mapping[str, Effect] = field(default_factory=dict)
    time: str = ""
    points: str = ""
    keys: tuple[Key, ...] = ()
    value: str = ""
    beside: tuple[str, ...] = ()
    over_temperature: str = ""
    left_of: tuple[str, ...] = ()
    use: str = ""
    is_asked: bool = False
    grades: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    origin: str = ""

    def meant(self, given: Given) -> Source:
        """Return the source with the effect that a file means by it."""
        effect = self.forms.get(given.form, self.effect)
        return self if effect is self.effect else replace(self, effect=effect)

    def like(self, owner: str) -> str:
        """Return the most usual unit with that owner; '' where it has none."""
        return self.units.get(owner, "")

    @property
    def shared(self) -> bool:
        """Whether it comes from outside the sensors, to all triads alike."""
        return not self.units.keys() & {*SENSORS}

    @property
    def process(self) -> bool:
        """Whether a value is a size as it stands: of a process, or a coefficient.

        Else it is the spread of a constant, whose shape matters.
        """
        return self.effect.is_process or isinstance(self.effect, Noise | Coefficient)

    @property
    def varies(self) -> bool:
        """Whether it is an input of the budget; a coefficient is fixed."""
        return not isinstance(self.effect, Coefficient)

    @property
    def may_vary(self) -> bool:
        """Whether it is one in any of its forms."""
        effects = (self.effect, *self.forms.values())
        return any(not isinstance(one, Coefficient) for one in effects)

    @property
    def is_signed(self) -> bool:
        """Whether its sign counts, beside that of others that one thing acts by."""
        return not self.varies and not getattr(self.effect, "partners", ())

    @property
    def is_initial(self) -> bool:
        """Whether every calibration finds it, so that it counts without one alone."""
        return isinstance(self.effect, Initial)

    @property
    def own(self) -> str:
        """The parameter whose own spread it is; '' of all others."""
        if isinstance(self.effect, Offset):
            return self.effect.target
        return getattr(self.effect, "own", "")
