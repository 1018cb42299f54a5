"""Where a mission leads: place and motion when it begins and when it is asked about."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, degrees, hypot, remainder
from typing import TYPE_CHECKING

from budget.language import say
from budget.names import time_text
from budget.report.blocks import Field, Paragraph, Section, table_of
from budget.report.figures.timeline import print_time
from budget.report.mission import unit_for
from budget.report.tables import print_given
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from budget.navigation.dynamics import Moment
    from budget.navigation.route import Route
    from budget.spec.records import Mission

STILL = 0.5  # below which a way is none [m]
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


def route_words(route: Route) -> str:
    """Say in one line where a route leads and how hard, so that a slip is seen."""
    way = route.outline
    begin, end = (
        _place(way.latitude[k], None if way.longitude is None else way.longitude[k])
        for k in (0, 1)
    )
    rate = print_given(degrees(way.turn_rate), digits=2)
    time = time_text(float(f"{way.duration:.4g}"))
    if way.length < STILL:
        return say(
            "Route: stands at {place} for {time}, turns at most {rate} deg/s.",
            place=begin,
            time=time,
            rate=rate,
        )
    unit, si_per_unit = unit_for("position", way.length)
    return say(
        "Route: {begin} to {end}, {length} in {time}, {low} m to {high} m high, at "
        "most {speed} m/s, {climb} m/s up or down, {acceleration} g, {rate} deg/s.",
        begin=begin,
        end=end,
        length=f"{print_given(way.length / si_per_unit, digits=3)} {unit}",
        time=time,
        low=_to(way.heights[0], 0),
        high=_to(way.heights[1], 0),
        speed=print_given(way.speed, digits=3),
        climb=print_given(way.climb_rate, digits=2),
        acceleration=print_given(way.acceleration / STANDARD_GRAVITY, digits=2),
        rate=rate,
    )


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
    return Section(
        name="route",
        title=title,
        blocks=(Paragraph(words=(route_words(mission.route),)), table),
    )


def _to(value: float, decimals: int) -> str:
    """Print a number that is known, to a number of decimals at the most."""
    return print_given(round(value, decimals) + 0.0, digits=DIGITS)  # no -0
