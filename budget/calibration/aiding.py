"""Aiding of a mission: its measurements, and the model of its Kalman filter.

What an aid measures is white by epoch; epochs are at multiples of a period from the
mission's start, after the begin of a stretch that is aided to its end. All that is
measured at one time is taken at once, and what is asked for then is after it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.errors import CallError
from budget.inputs.records import ErrorLine
from budget.model.source import SENSORS
from budget.model.sources import source_of
from budget.names import AIDING, ALIGNMENT, PLACES, Name
from budget.navigation.aided import KNOWN, Aid, Drift
from budget.units import DEGREE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.inputs.records import Aiding, Believed, Mission, Sensor

# Rows of Moment.measured: north, east and down, or one.
ROWS = {
    "gnss_position": (0, 1, 2),
    "gnss_velocity": (3, 4, 5),
    "heading": (8,),
    "zero_velocity": (3, 4, 5),
    "odometer": (9,),
}
UNITS = {
    **dict.fromkeys(("gnss_position", "gnss_position_drift", "position"), ("m", 1.0)),
    **dict.fromkeys(
        ("gnss_velocity", "zero_velocity", "odometer", "velocity"), ("m/s", 1.0)
    ),
    **dict.fromkeys(("heading", "level"), ("deg", DEGREE)),
}
DOWN = (2, 5)  # rows of the vertical channel
SAME = 1e-9  # of two times that are one, of the mission's length [1]


@dataclass(frozen=True, kw_only=True)
class Cuts:
    """Times that the steps of a mission end at.

    Attributes
    ----------
    times : tuple of float
        Rising [s].
    asked : tuple of int
        Which of them are asked for.
    ends : tuple of tuple of int
        Which are epochs of each aid.
    """

    times: tuple[float, ...]
    asked: tuple[int, ...]
    ends: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, mission: Mission, times: Sequence[float]) -> Cuts:
        """Put epochs and times that are asked for in a row, to the last of these."""
        slack = SAME * mission.route.duration
        groups = [np.array(times)]
        groups += (epochs(aid, times[-1] + slack) for aid in mission.aiding)
        every = np.sort(np.concatenate(groups))
        cuts = every[np.diff(every, prepend=-1.0) > slack]
        asked, *ends = (
            tuple(np.searchsorted(cuts, group - slack).tolist()) for group in groups
        )
        cuts[list(asked)] = times
        return cls(times=tuple(cuts.tolist()), asked=asked, ends=tuple(ends))


def epochs(aid: Aiding, last: float) -> Array:
    """Return the times at which it measures, to a last one, shape (k,) [s]."""
    found = [
        np.arange(floor(begin * aid.rate + SAME) + 1, floor(end * aid.rate + SAME) + 1)
        for begin, end in aid.spans
    ]
    t = np.concatenate([np.empty(0), *found]) / aid.rate
    return np.asarray(t[t <= last])


def lines_of_mission(mission: Mission | None) -> dict[Name, ErrorLine]:
    """Return what a mission adds to the sources of a unit: its aids, its alignment."""
    if mission is None:
        return {}
    sizes: dict[Name, Array] = {}
    for aid in mission.aiding:
        sizes[Name(aid.name, owner=AIDING)] = np.array(aid.u)
        if aid.drift:
            sizes[Name(f"{aid.name}_drift", owner=AIDING)] = np.array(aid.drift)
    start = np.array(mission.start)
    sizes |= {Name(key, owner=ALIGNMENT): start[rows] for key, rows in KNOWN.items()}
    return {name: _line(name, u) for name, u in sizes.items() if u.any()}


def _line(name: Name, u: Array) -> ErrorLine:
    """Return the line of an aid or of an alignment."""
    unit, size = UNITS[name.quantity]
    each = [f"{one / size:.10g} {unit}" for one in u.tolist()]
    differ = len(set(each)) > 1
    return ErrorLine(
        name=name.quantity,
        u=u,
        distributions=(NORMAL,) * len(u),
        printed=", ".join(map(" ".join, zip(PLACES["position"], each, strict=True)))
        if differ
        else each[0],
        unit=unit,
        si_per_unit=size,
    )


def aids_of(
    mission: Mission, cuts: Cuts, believes: Sequence[Believed] = ()
) -> tuple[Aid, ...]:
    """Return the aids of a mission as they are, or as a filter believes them."""
    found = []
    for aid, ends in zip(mission.aiding, cuts.ends, strict=True):
        kept = [
            place
            for place, row in enumerate(ROWS[aid.name])
            if not (mission.aided and row in DOWN)
        ]
        u, drift = (
            _believed(name, given, believes)
            for name, given in ((aid.name, aid.u), (f"{aid.name}_drift", aid.drift))
        )
        found.append(
            Aid(
                name=aid.name,
                rows=tuple(ROWS[aid.name][place] for place in kept),
                u=tuple(u[place] for place in kept),
                ends=ends,
                drift=Drift(
                    u=tuple(drift[place] for place in kept),
                    correlation_time=aid.correlation_time,
                )
                if drift
                else None,
            )
        )
    return tuple(found)


def _believed(
    name: str, given: tuple[float, ...], believes: Sequence[Believed]
) -> tuple[float, ...]:
    """Return the sizes of an aid as a filter believes them."""
    for one in believes:
        if one.line == Name(name, owner=AIDING):
            return (one.value,) * len(given)
    return given


def believing(
    sensors: Sequence[Sensor], believes: Sequence[Believed]
) -> tuple[Sensor, ...]:
    """Return triads as a filter believes them.

    Raises
    ------
    CallError
        It believes something of a line that they do not have.
    """
    own = {sensor.kind: sensor for sensor in sensors}
    for one in believes:
        kind = one.line.owner
        if kind not in SENSORS:
            continue
        line = own[kind].line(one.line.quantity) if kind in own else None
        if line is None or (one.is_time and line.correlation_time is None):
            raise CallError(
                f"mission.filter.believes.{one.line}: {own[kind].device} has no such "
                "specification; expected one that its file gives: remove it, or give "
                "that"
            )
        axes = source_of(kind, line.name).axes
        values = np.array(line.correlation_time if one.is_time else line.u)
        values[[one.axis in {"", axis} for axis in axes]] = one.value
        line = (
            replace(line, correlation_time=values)
            if one.is_time
            else replace(line, u=values)
        )
        new = tuple(line if old.name == line.name else old for old in own[kind].lines)
        own[kind] = replace(own[kind], lines=new)
    return tuple(own.values())
