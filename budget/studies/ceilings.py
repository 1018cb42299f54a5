"""Ceilings of lines that a data sheet does not give: what they hardly exceed.

The larger of what the worst comparable device of the catalogue prints, which has the
same sensor, family of technology and grade, and the 97.5 % point of the prediction
(budget.missing.prediction), which there is of expected lines:

    u_c = max(max over comparable of |u|, exp(m + t(0.975; df) s)),

m location and s scale of ln u. A sheet that hides is never better off: where nobody
can tell its technology or its grade, devices of any are comparable with it, so that to
tell can only make fewer of them, and lower the largest; and of what is predicted that
of the worst technology stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import inf
from typing import TYPE_CHECKING

from budget.inputs.specification import time_of
from budget.missing import line_of, shipped_devices
from budget.missing.grades import FAMILIES, UNKNOWN, grade, known_family
from budget.missing.prediction import figures_of, predict, stand_in
from budget.model.sources.later import AGEING, growth
from budget.names import Name
from budget.ties import first_largest
from budget.units import YEAR

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.inputs.records import Device, ErrorLine
    from budget.question import Question

BY_DEVICES, BY_PREDICTION, BY_NATURE = ORIGINS = (
    "comparable devices",
    "prediction",
    "no sensor is worse",
)
# A scale factor may be wrong by all of it, an axis stand a radian off [1, rad]: by the
# unit of a line.
MOST = {"ppm": 1.0, "arcsec": 1.0}
TECHNOLOGY, GRADE = UNTOLD = ("technology", "grade")
FEW = 5  # devices that a line is held against to call it unusual
COVERAGE = 0.95  # of the central interval whose upper end is a ceiling [1]


@dataclass(frozen=True, kw_only=True)
class Comparable:
    """A line as a device of the catalogue prints it."""

    u: float  # of the largest axis, of an ageing after a year [SI]
    printed: str  # as its file gives it, beside its own meaning
    owner: str  # name of the device
    family: str
    grade: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Ceiling:
    """A line that is not given at what it hardly exceeds.

    Attributes
    ----------
    name : Name
        As it was asked for, 'gyro.noise'.
    line : ErrorLine
        What stands for it, at the ceiling.
    u : float
        [SI]
    origin : str
        'comparable devices' or 'prediction', the larger of the two; without either
        'no sensor is worse', of a ratio or an angle.
    largest_comparable : Comparable or None
        What the worst comparable device prints; None where none prints it.
    untold : tuple of str
        What nobody told, 'technology' or 'grade': devices of any count as comparable.
    """

    name: Name
    line: ErrorLine
    u: float
    origin: str
    largest_comparable: Comparable | None = None
    untold: tuple[str, ...] = ()

    @property
    def printed(self) -> str:
        """Its size to three digits, as makers print it: '0.2 deg'."""
        return self.line.printed


def ceilings(
    device: Device, names: Sequence[Name], catalogue: Sequence[Device] | None = None
) -> Mapping[Name, Ceiling]:
    """Return what lines that a device does not give hardly exceed.

    Parameters
    ----------
    device : Device
        Of the catalogue or not: it is not comparable with itself.
    names : sequence of Name
        Any lines of its sensors that it does not give, 'gyro.noise' or
        'gyro.g_sensitivity'; of several that may stand for an expected one the first
        is taken.
    catalogue : sequence of Device, optional
        Without it the devices that ship.

    Returns
    -------
    mapping of Name to Ceiling
        Without those that nobody comparable prints and that cannot be predicted.

    Raises
    ------
    CallError
        A name is none of a line.
    """
    devices = tuple(shipped_devices() if catalogue is None else catalogue)
    meant = {name: _expected(name) for name in names}
    there = {sensor.kind: sensor for sensor in device.sensors}
    wanted = [own for own in dict.fromkeys(meant.values()) if own.owner in there]
    given = figures_of(device)  # of which nothing is left to predict
    expected = [own for own in wanted if stand_in(own).expected]
    asked = [own for own in expected if own not in given]
    upper: dict[Name, float] = {}
    for word in (None,) if known_family(device) else (None, *FAMILIES):
        prediction = predict(device, asked, devices, technology=word)
        if prediction is not None:
            ends = prediction.interval(COVERAGE)[:, 1].tolist()
            for own, end in zip(prediction.names, ends, strict=True):
                upper[own] = max(end, upper.get(own, 0.0))
    found, itself = {}, device.as_printed
    for name, own in meant.items():
        if own not in wanted:
            continue
        source = stand_in(own)
        own_family, own_grade = known_family(device), grade(there[own.owner])
        offers = [
            one
            for one in _printed(devices).get((own.owner, source.name), ())
            if one.owner != itself
            if own_family in {one.family, ""} and own_grade in {one.grade, UNKNOWN}
        ]
        worst = offers[first_largest([one.u for one in offers])] if offers else None
        sizes = [0.0 if worst is None else worst.u, upper.get(own, 0.0)]
        most = at_most(own)
        if max(sizes) == 0.0 or max(sizes) > most:
            sizes = [0.0, 0.0, most]
        if not 0.0 < max(sizes) < inf:
            continue
        origin = first_largest(sizes)
        found[name] = Ceiling(
            name=name,
            line=line_of(source, own.owner, sizes[origin], meaning="ceiling"),
            u=sizes[origin],
            origin=ORIGINS[origin],
            largest_comparable=worst,
            untold=tuple(
                word
                for word, is_told in zip(
                    UNTOLD, (own_family, own_grade != UNKNOWN), strict=True
                )
                if not is_told
            ),
        )
    return found


def ceilings_of(question: Question, names: Sequence[Name]) -> dict[Name, Ceiling]:
    """Return those of lines that a question's data sheets do not give."""
    return {
        name: one
        for device in question.sheets or question.devices
        for own in [{sensor.kind for sensor in device.sensors}]
        for name, one in ceilings(
            device, [name for name in names if name.owner in own], question.catalogue
        ).items()
    }


def at_most(name: Name) -> float:
    """Return what a line of any sensor is below [SI]; inf: nothing says."""
    source = stand_in(name)
    return inf if source.process else MOST.get(source.like(name.owner), inf)


def largest_printed(
    name: Name, catalogue: Sequence[Device] | None = None
) -> float | None:
    """Return the largest of a line that any device prints [SI]; None: none does."""
    devices = tuple(shipped_devices() if catalogue is None else catalogue)
    found = _printed(devices).get((name.owner, stand_in(name).name), ())
    return max((one.u for one in found), default=None)


def printed_by_others(
    name: Name, device: Device, catalogue: Sequence[Device] | None = None
) -> tuple[Comparable, Comparable] | None:
    """Return least and largest of a line that other devices of like technology print.

    None where fewer than FEW print it: that is no measure.
    """
    devices = tuple(shipped_devices() if catalogue is None else catalogue)
    itself, own_family = device.as_printed, known_family(device)
    found = [
        one
        for one in _printed(devices).get((name.owner, name.quantity), ())
        if one.owner != itself and own_family in {one.family, ""}
    ]
    by_size = sorted(found, key=lambda one: one.u)
    return (by_size[0], by_size[-1]) if len(found) >= FEW else None


def _expected(name: Name) -> Name:
    """Return the expected line that a name is of, or the name itself."""
    source = stand_in(name)
    return Name(source.expected or source.name, owner=name.owner)


@lru_cache(maxsize=2)
def _printed(
    catalogue: tuple[Device, ...],
) -> Mapping[tuple[str, str], Sequence[Comparable]]:
    """Return what devices print, by sensor and line; those that print 0 print none."""
    found: dict[tuple[str, str], list[Comparable]] = {}
    for device in catalogue:
        for sensor in device.sensors:
            for line in (*sensor.lines, *sensor.initial):
                for name, u in _says(line):
                    found.setdefault((sensor.kind, name), []).append(
                        Comparable(
                            u=u,
                            printed=line.printed,
                            owner=device.as_printed,
                            family=known_family(device),
                            grade=grade(sensor),
                        )
                    )
    return found


def _says(line: ErrorLine) -> Iterator[tuple[str, float]]:
    """Yield the lines that one tells of, and their sizes [SI]; of 0 it tells nothing.

    A repeatability over a year or more is not less than what a year of ageing adds.
    """
    ages = line.name in AGEING.values()
    if (u := line.largest * (growth(line, YEAR) if ages else 1.0)) > 0.0:
        yield line.name, u
        horizon = time_of(line.horizon)
        for parameter, ageing in AGEING.items():
            is_long = horizon is not None and horizon.value >= YEAR
            if is_long and line.name == f"{parameter}_repeatability":
                yield ageing, u
