"""Blunders about the place of a test, each with what it does to the outputs.

A wrong latitude, earth rate, height or gravity widens no interval: it is an offset of
every output that it reaches, and shows when a test is compared with another one. Each
is a source of the station (budget.model.sources.place) at a known value, used minus
true, through the windows and weights of the procedure at hand. A number that is right
for its kind shows none of them, so what they cost is a table; where a file gives
evidence of one, that is a warning.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import atan, degrees, inf, isclose, tan
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import calibrates, estimated
from budget.distributions import NORMAL
from budget.earth import ECCENTRICITY_SQUARED, ROTATION_RATE, normal_gravity
from budget.errors import BudgetError
from budget.inputs.procedure import HEIGHT_0
from budget.inputs.records import ErrorLine, Sensor
from budget.model.sources import SENSORS, STATION
from budget.names import Name
from budget.sentences import sentence
from budget.units import DEG_PER_HOUR, STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from budget.inputs.records import Procedure, Requirement
    from budget.methods.gum import Propagation
    from budget.problem import Output, Problem

FALSE_RATE = 15.0 * DEG_PER_HOUR  # a turn in 24 h, in place of a sidereal day [rad/s]
CLIMB = 100.0  # above the height that is assumed [m]
MILLIGAL = 1e-5  # [m/s^2]
ANOMALY, LEAST_ANOMALY = 50.0, 10.0  # of gravity; 10 to 100 are usual [mGal]
ROUNDING = 1e-12  # of units [1]
ROUND = (STANDARD_GRAVITY, 9.81, 9.8)  # of who means the unit g [m/s^2]
SAME = 0.01  # an uncertainty that near to a value is the value itself [1]
SHARE = 0.1  # of u or of a limit, from which on an offset is worth a warning [1]
LIMIT_SHARE = 0.25  # of a limit, likewise, where the file is silent: 4:1 is custom [1]
ALIKE = 0.01  # axes whose offsets differ by less of the largest are named as one [1]
# In resolutions of an output, 1 ppm, 0.2 arcsec, 1e-6 of what a bias is measured
# beside: below it an offset is left out.
LEAST = 1e8
MOST_WINDOWS = 200  # of a test whose table of blunders is made
WHOLE, MILLION = 100.0, 1e6  # between them no decimals are printed [unit of output]


@dataclass(frozen=True, kw_only=True)
class Blunder:
    """One mistake about the place: a source of the station at a value.

    Attributes
    ----------
    kind : str
        'geocentric', 'solar_day', 'height', 'anomaly' or 'unit_g'.
    size : float
        What is taken, or left out [deg, m, mGal or m/s^2].
    source : str
        The source of the station that it is an input of.
    used : Procedure
        With what is taken for the truth.
    difference : float
        Used minus true [SI].
    worth : float
        Part of u, or of a limit, from which on it is worth a warning [1].
    """

    kind: str
    size: float
    source: str
    used: Procedure
    difference: float
    worth: float = SHARE

    @property
    def text(self) -> str:
        """What is taken for what."""
        return sentence("blunders.mistake", kind=self.kind, size=self.size)

    def warn(
        self,
        moved: Iterable[BlunderError],
        beside: Mapping[Name, float] | None = None,
        what: str = "u",
    ) -> str:
        """Say in a warning why it is suspected, what it does, and what to do.

        Offsets stand `beside` what is said of their outputs.
        """
        return sentence(
            "blunders.warning",
            kind=self.kind,
            size=self.size,
            normal=self.used.gravity - self.difference,
            moved=_adding(moved, beside, what),
        )


@dataclass(frozen=True, kw_only=True)
class BlunderError:
    """What a blunder adds to an output, or to all axes of it alike."""

    name: Name
    error: float  # calibrated minus true [SI]
    output: Output

    @property
    def printed(self) -> str:
        """The error with sign and unit, to three digits: '+0.0388 deg/h'."""
        value = self.error / self.output.si_per_unit
        # Where three digits are no decimals whole numbers are, not powers of ten.
        form = "+.0f" if WHOLE <= abs(value) < MILLION else "+#.3g"
        return f"{value:{form}} {self.output.unit}"


def blunders(procedure: Procedure) -> tuple[Blunder, ...]:
    """Return the mistakes that can be made at a place, which is what the file says.

    Latitude: the geocentric one used, tan L' = (1 - e^2) tan L. Earth rate: 15 deg/h
    used. Normal gravity: that of height 0 used 100 m up, and an anomaly left out.
    Gravity: the unit g used for it.
    """
    found = [_geocentric(procedure), _solar_day(procedure)]
    if procedure.is_gravity_normal:
        found += [_height(procedure)] if _is_height_open(procedure) else []
        found.append(_anomaly(procedure))
    if not _is_round(procedure):
        there = replace(procedure, gravity=STANDARD_GRAVITY, is_gravity_normal=False)
        found.append(_unit_g(there, procedure.gravity))
    return tuple(found)


def suspected(procedure: Procedure) -> Iterator[Blunder]:
    """Yield the mistakes that a file gives evidence of.

    Gravity that is the unit g, and a figure of the place that stands where its
    uncertainty belongs. A station that is given and says nothing of height or gravity:
    without a station it is said that an ideal one is assumed.
    """
    normal = normal_gravity(procedure.latitude)
    misses = abs(procedure.gravity - normal)
    if _is_round(procedure) and misses > LEAST_ANOMALY * MILLIGAL:
        yield _unit_g(procedure, normal)
    if procedure.station:
        yield from left_open(procedure)


def left_open(procedure: Procedure) -> Iterator[Blunder]:
    """Yield the mistakes that nothing is said against: of height, of gravity."""
    if procedure.is_gravity_normal:
        if _is_height_open(procedure):
            yield _height(procedure)
        if all(line.name != "gravity" for line in procedure.station):
            yield _anomaly(procedure)


def offsets(blunder: Blunder, sensors: Iterable[Sensor]) -> tuple[BlunderError, ...]:
    """Return what a blunder adds to each output of these triads.

    The calibration (budget.calibration.problem) with that source at its value, less
    the same with it at 0; all other sources at 0.

    Raises
    ------
    BudgetError
        The procedure cannot calibrate these triads.
    """
    line = ErrorLine(
        name=blunder.source,
        u=np.ones(1),
        distributions=(NORMAL,),
        printed="",
        unit="",
        si_per_unit=1.0,
    )
    name = Name(blunder.source, owner=STATION)
    used = replace(blunder.used, station=(line,), environment=())
    problem = calibration_problem(tuple(sensors), used, only=frozenset({name}))
    x = np.zeros((sum(group.mean.size for group in problem.groups), 2))
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        if group.name == name:
            x[rows, 1] = blunder.difference
    with np.errstate(all="ignore"):  # no such earth; what is not finite is left out
        errors = problem.evaluate(x)
    return tuple(
        BlunderError(name=output.name, error=float(there - without), output=output)
        for output, (without, there) in zip(problem.outputs, errors, strict=True)
    )


def costs(procedure: Procedure) -> tuple[tuple[Blunder, tuple[BlunderError, ...]], ...]:
    """Return what each mistake adds to triads without errors of their own.

    Of a parameter the axis that is moved most, or all where they move alike. What
    reaches nothing that the test estimates is left out, as are all where the windows
    do not calibrate a triad that nothing is known of, or are more than 200: each is a
    calibration of its own, which with thousands of windows takes a minute.
    """
    if len(procedure.windows) > MOST_WINDOWS:
        return ()
    return tuple((one, moved) for one in blunders(procedure) if (moved := _ideal(one)))


def evident(procedure: Procedure) -> tuple[str, ...]:
    """Say what is wrong with a procedure whatever the device, with its size."""
    found = [
        one.warn(moved)
        for one in suspected(procedure)
        if one.source == "gravity" and not one.used.is_gravity_normal
        for moved in [_ideal(one)]
        if moved
    ]
    return (*found, *_values_for_uncertainties(procedure))


def worth_saying(
    procedure: Procedure,
    sensors: Iterable[Sensor],
    law: Propagation,
    problem: Problem,
    requirement: Requirement | None = None,
) -> tuple[str, ...]:
    """Say the same of devices at hand, where it counts beside u or a limit."""
    u = {
        output.name: float(one)
        for output, one in zip(problem.outputs, law.standard_uncertainty, strict=True)
    }
    limits = (
        {}
        if requirement is None
        else {limit.output: limit.limit for limit in requirement.limits}
    )
    return (
        *(
            one.warn(moved, u)
            for one in suspected(procedure)
            for moved in [_counting(one, sensors, u, limits)]
            if moved
        ),
        *(() if procedure.station else _beside_limits(procedure, limits)),
        *_values_for_uncertainties(procedure),
    )


def against_limits(procedure: Procedure, requirement: Requirement) -> tuple[str, ...]:
    """Say the same of any device, where it counts beside a limit."""
    limits = {limit.output: limit.limit for limit in requirement.limits}
    return (*_beside_limits(procedure, limits), *evident(procedure))


def _beside_limits(procedure: Procedure, limits: Mapping[Name, float]) -> Iterator[str]:
    """Say what is left open of the place and takes a good part of a limit."""
    for one in left_open(procedure) if limits else ():
        moved = _moved(
            offset
            for offset in _of_ideal(one)
            if abs(offset.error) > LIMIT_SHARE * limits.get(offset.name, inf)
        )
        if moved:
            yield one.warn(moved, limits, "limit")


def _counting(
    blunder: Blunder,
    sensors: Iterable[Sensor],
    u: Mapping[Name, float],
    limits: Mapping[Name, float],
) -> tuple[BlunderError, ...]:
    """Return the offsets that are more than their share of u or of a limit."""
    return _moved(
        one
        for one in offsets(blunder, sensors)
        if one.name in u
        and abs(one.error)
        > blunder.worth * min(u[one.name], limits.get(one.name, u[one.name]))
    )


def _geocentric(procedure: Procedure) -> Blunder:
    """Return the geocentric latitude for the geodetic: TR8350.2, eq. (4-15)."""
    L = procedure.latitude
    less = atan((1.0 - ECCENTRICITY_SQUARED) * tan(L))
    gravity = procedure.gravity
    if procedure.is_gravity_normal:
        gravity = normal_gravity(less, procedure.height)
    return Blunder(
        kind="geocentric",
        size=degrees(less),
        source="latitude",
        used=replace(procedure, latitude=less, gravity=gravity),
        difference=less - L,
    )


def _solar_day(procedure: Procedure) -> Blunder:
    """Return a turn of the earth in 24 h for one in a sidereal day."""
    return Blunder(
        kind="solar_day",
        size=FALSE_RATE / DEG_PER_HOUR,
        source="earth_rate",
        used=procedure,
        difference=FALSE_RATE - ROTATION_RATE,
    )


def _height(procedure: Procedure) -> Blunder:
    """Return normal gravity at height 0 used above it."""
    return Blunder(
        kind="height",
        size=CLIMB,
        source="height",
        used=procedure,
        difference=-CLIMB,
    )


def _anomaly(procedure: Procedure) -> Blunder:
    """Return normal gravity used where there is more of it."""
    return Blunder(
        kind="anomaly",
        size=ANOMALY,
        source="gravity",
        used=procedure,
        difference=-ANOMALY * MILLIGAL,
        worth=SHARE * ANOMALY / LEAST_ANOMALY,
    )


def _unit_g(used: Procedure, true: float) -> Blunder:
    """Return the unit g, or what it is rounded to, used for gravity."""
    return Blunder(
        kind="unit_g",
        size=used.gravity,
        source="gravity",
        used=used,
        difference=used.gravity - true,
    )


def _is_round(procedure: Procedure) -> bool:
    """Whether gravity is given, and as the unit g."""
    return not procedure.is_gravity_normal and any(
        isclose(procedure.gravity, one, rel_tol=ROUNDING) for one in ROUND
    )


def _is_height_open(procedure: Procedure) -> bool:
    """Whether height 0 is assumed, and not said."""
    return HEIGHT_0 in procedure.assumptions


def _values_for_uncertainties(procedure: Procedure) -> tuple[str, ...]:
    """Say which figures of the station are not uncertainties, but values."""
    place = procedure.place
    values = {
        "latitude": abs(place.latitude),
        "height": abs(place.height),
        "gravity": place.gravity,
        "earth_rate": place.earth_rate,
    }
    day = _solar_day(procedure)
    return tuple(
        sentence(
            "blunders.value_itself",
            name=Name(line.name, owner=STATION),
            printed=line.printed,
            used=value / DEG_PER_HOUR,
            moved=_adding(_ideal(day)) if line.name == day.source else [],
        )
        for line in procedure.station
        for value in [values.get(line.name)]
        if value and isclose(line.u[0], value, rel_tol=SAME)
    )


def _ideal(blunder: Blunder) -> tuple[BlunderError, ...]:
    """Return the largest of what it adds to triads without errors, by parameter."""
    return _moved(_of_ideal(blunder))


# Of the procedure alone: thousands of devices share a few.
@lru_cache(maxsize=64)
def _of_ideal(blunder: Blunder) -> tuple[BlunderError, ...]:
    """Return what it adds to triads without errors; () where none are calibrated."""
    sensors = [
        Sensor.bare(kind)
        for kind in SENSORS
        if calibrates(kind, blunder.used) and estimated(kind, blunder.used)
    ]
    try:
        return offsets(blunder, sensors) if sensors else ()
    except BudgetError:  # what only a device can make whole
        return ()


def _moved(found: Iterable[BlunderError]) -> tuple[BlunderError, ...]:
    """Return of each parameter the largest offset, of all axes where they are alike."""
    groups: dict[Name, list[BlunderError]] = {}
    for one in found:
        if inf > abs(one.error) > LEAST * one.output.resolution:
            groups.setdefault(one.name.group, []).append(one)
    moved = []
    for group, own in groups.items():
        largest = max(own, key=lambda one: abs(one.error))
        apart = max(abs(one.error - largest.error) for one in own)
        if len(own) > 1 and apart <= ALIKE * abs(largest.error):
            largest = replace(largest, name=group)
        moved.append(largest)
    return tuple(moved)


def _adding(
    moved: Iterable[BlunderError],
    beside: Mapping[Name, float] | None = None,
    what: str = "",
) -> list[tuple[str, Name, str, float, str]]:
    """Return offsets, their outputs, and what they stand beside, where that is known.

    That is '' where it is not, its size, and its unit.
    """
    return [
        (
            one.printed,
            one.name,
            "" if beside is None else what,
            0.0 if beside is None else beside[one.output.name] / unit,
            one.output.unit,
        )
        for one in moved
        for unit in [one.output.si_per_unit]
    ]
