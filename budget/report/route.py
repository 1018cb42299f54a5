"""The route of a mission in words, and as a table of places."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, degrees, hypot, remainder
from typing import TYPE_CHECKING

from budget.names import time_text
from budget.report.figures.timeline import print_time
from budget.report.pages import section
from budget.report.tables import print_given, unit_for
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from budget.inputs.records import Mission
    from budget.navigation.dynamics import Moment
    from budget.navigation.route import Route
    from budget.report.blocks import Section

STILL = 0.5  # below which a way is none [m]
DIGITS = 7  # of a number that is rounded to decimals already


@dataclass(frozen=True)
class _Waypoint:
    """One of the moments of a route."""

    time: float  # since the start [s]
    moments: Moment
    which: tuple[int, ...]

    @property
    def latitude(self) -> str:
        """In degrees, to 11 m."""
        return _to(degrees(self.moments.latitude[self.which]), 4)

    @property
    def height(self) -> str:
        """In metres."""
        return _to(float(self.moments.height[self.which]), 1)

    @property
    def speed(self) -> str:
        """Over the ground, in m/s."""
        north, east, _ = self.moments.velocity[self.which]
        return _to(hypot(north, east), 2)

    @property
    def heading(self) -> str:
        """Of the forward axis, from north to east in degrees."""
        north, east, _ = self.moments.body[self.which][:, 1]
        return _to(round(degrees(atan2(east, north)), 2) % 360.0, 2)


def way_of(route: Route) -> dict[str, object]:
    """Return where a route leads and how hard, as one line says it."""
    way = route.outline
    begin, end = (
        _place(way.latitude[k], None if way.longitude is None else way.longitude[k])
        for k in (0, 1)
    )
    unit, si_per_unit = unit_for("position", way.length)
    return {
        "is_still": way.length < STILL,
        "begin": begin,
        "end": end,
        "length": f"{print_given(way.length / si_per_unit, digits=3)} {unit}",
        "duration": time_text(float(f"{way.duration:.4g}")),
        "low": _to(way.heights[0], 0),
        "high": _to(way.heights[1], 0),
        "speed": way.speed,
        "climb_rate": way.climb_rate,
        "acceleration": way.acceleration / STANDARD_GRAVITY,
        "turn_rate": degrees(way.turn_rate),
    }


def _place(latitude: float, longitude: float | None) -> str:
    """Write a place as charts do, to 11 m: '45.0000 N 10.0000 E'."""
    text = f"{abs(degrees(latitude)):.4f} {'S' if latitude < 0.0 else 'N'}"
    if longitude is None:
        return text
    east = remainder(degrees(longitude), 360.0)
    return f"{text} {abs(east):.4f} {'W' if east < 0.0 else 'E'}"


def route_section(mission: Mission) -> Section:
    """Tell the way in a table: a row for the start and for each asked time."""
    ends = mission.route.steps(mission.at).ends
    return section(
        "route",
        way=way_of(mission.route),
        places=[
            _Waypoint(0.0, mission.route.first, ()),
            *(_Waypoint(time, ends, (k,)) for k, time in enumerate(mission.at)),
        ],
        print_time=print_time,
    )


def _to(value: float, decimals: int) -> str:
    """Print a number that is known, to a number of decimals at the most."""
    return print_given(round(value, decimals) + 0.0, digits=DIGITS)  # no -0
