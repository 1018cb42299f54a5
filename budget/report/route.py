"""Where a mission leads: place and motion when it begins and when it is asked about."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, degrees, hypot
from typing import TYPE_CHECKING

from budget.language import say
from budget.report.blocks import Field, Section, table_of
from budget.report.figures.timeline import print_time
from budget.report.tables import print_given

if TYPE_CHECKING:
    from budget.navigation.dynamics import Moment
    from budget.spec.records import Mission

DIGITS = 7  # of a number that is rounded to decimals already


@dataclass(frozen=True)
class _Place:
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


def route_section(mission: Mission) -> Section:
    """Tell the way in a table: a row for the start and for each asked time."""
    ends = mission.route.steps(mission.at).ends
    places = [
        _Place(0.0, mission.route.first, ()),
        *(_Place(time, ends, (k,)) for k, time in enumerate(mission.at)),
    ]
    title = say("Where the mission leads")
    table = table_of(
        places,
        (
            Field(head=say("time"), cell=lambda one: print_time(one.time)),
            Field(
                head=say("latitude [deg]"),
                kind="number",
                cell=lambda one: one.latitude,
            ),
            Field(head=say("height [m]"), kind="number", cell=lambda one: one.height),
            Field(
                head=say("speed over ground [m/s]"),
                kind="number",
                cell=lambda one: one.speed,
            ),
            Field(
                head=say("heading [deg]"),
                kind="number",
                cell=lambda one: one.heading,
            ),
        ),
        name="route",
        caption=title,
    )
    return Section(name="route", title=title, blocks=(table,))


def _to(value: float, decimals: int) -> str:
    """Print a number that is known, to a number of decimals at the most."""
    return print_given(round(value, decimals), digits=DIGITS)
