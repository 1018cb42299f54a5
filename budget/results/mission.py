"""What a mission adds to a budget: calibrations beside one another, its filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.documents import written

if TYPE_CHECKING:
    from budget.known import Known
    from budget.names import Name


@written(
    "calibrated",
    """
    name: of the procedure
    cep [m]: of the horizontal position, time by time
    lower_bound: whether an expected line that is not given would widen it
    worse_than: the maker's calibration, where it is farther off at the end than after
      that
    because: the line that adds most then
    """,
)
@dataclass(frozen=True, kw_only=True)
class Calibrated:
    """How far off a unit is on a mission after one calibration, or none."""

    name: str  # of the procedure
    cep: tuple[Known, ...]  # of the horizontal position, time by time [m]
    # Of a test after which it is larger at the end than after the maker's calibration:
    # the name of that, and the line that adds most; '' and None of others.
    worse_than: str = ""
    because: Name | None = None

    @property
    def lower_bound(self) -> bool:
        """Whether an expected line that is not given would widen it."""
        return any(one.is_bound for one in self.cep)


@written(
    "learnt",
    """
    sensor
    axis
    time [s]: at which an aid ends
    before [unit]: standard uncertainty without the filter
    after [unit]: and with it
    unit
    """,
)
@dataclass(frozen=True, kw_only=True)
class Learnt:
    """What a filter has found out of the bias of one axis, its slow noise with it."""

    sensor: str
    axis: str
    time: float  # at which an aid ends [s]
    before: float  # standard uncertainty without the filter [unit]
    after: float  # and with it [unit]
    unit: str


@written(
    "believed",
    """
    parameter: 'position', 'velocity', 'attitude'
    axis
    time [s]: since the mission began
    standard_uncertainty [unit]: as the filter believes
    true [unit]: what it is
    unit
    """,
)
@dataclass(frozen=True, kw_only=True)
class BelievedError:
    """An error of navigation as the filter believes it."""

    parameter: str  # 'position', 'velocity', 'attitude'
    axis: str
    time: float  # [s]
    standard_uncertainty: float  # [unit]
    true: float  # what it is [unit]
    unit: str


@written(
    "turned",
    """
    time [s]: of both ends
    straight [m]: root of the summed variances north and east
    turned [m]: the same, turned by 180 deg in the first half of the way on
    """,
)
@dataclass(frozen=True, kw_only=True)
class Turned:
    """How far off a mission ends, and one that turns where its aids end [m]."""

    time: float  # of both ends [s]
    straight: float  # root of the summed variances north and east [m]
    turned: float  # the same, turned by 180 deg in the first half of the way on [m]


@written(
    "filter",
    """
    kind: 'optimal' or 'own'
    states: how many it has
    updates: how many measurements it takes
    learnt: of biases, where aids end
    believed: errors of navigation, as it believes and as they are
    turned: of a mission that goes straight on without aids; null of others
    """,
)
@dataclass(frozen=True, kw_only=True)
class Filtered:
    """The filter of a mission with aids."""

    kind: str  # 'optimal' or 'own'
    states: int
    updates: int
    learnt: tuple[Learnt, ...]
    believed: tuple[BelievedError, ...]
    turned: Turned | None = None  # of a mission that goes straight on without aids
