"""The catalogue against allocated lines: what is offered, what comes closest."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import SpecError
from budget.inputs import load_variants
from budget.model.sources import BAND, SAMPLE_NOISE, SENSORS, walk_of
from budget.names import Name
from budget.resources import shipped
from budget.studies.allocation.records import LineMatch, Match
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.inputs.records import Device, ErrorLine, Sensor

# White noise is printed as a density or for every sample: one is the other over the
# root of the sample rate.
DENSITIES = tuple(map(walk_of, SENSORS))
OTHERWISE = "given as another quantity"


def load_catalogue() -> tuple[tuple[Device, ...], tuple[str, ...]]:
    """Load every shipped device in every variant.

    Returns
    -------
    tuple of Device
        In the order of their files.
    tuple of str
        Warnings about files that cannot be read.
    """
    devices: list[Device] = []
    warnings: list[str] = []
    for path in sorted((shipped("specs") / "devices").glob("*.yaml")):
        try:
            devices.extend(load_variants(path))
        except SpecError as error:
            warnings.append(f"left out of the catalogue: {error.issues[0].message}")
    return tuple(devices), tuple(warnings)


def best_offered(
    catalogue: Sequence[Device], sensors: Sequence[Sensor] = ()
) -> dict[Name, float]:
    """Return the least value above zero of every line, largest axis [SI].

    Of a line that these sensors have, of those that are meant as theirs.
    """
    best: dict[Name, float] = {}
    wanted = {one.kind: one for one in sensors}
    for device in catalogue:
        for sensor in device.sensors:
            for line in sensor.lines:
                name, u = (
                    Name(line.name, owner=sensor.kind),
                    line.largest,
                )
                own = (
                    wanted[sensor.kind].line(line.name)
                    if wanted.get(sensor.kind)
                    else None
                )
                if u > 0.0 and (own is None or _is_alike(line, own)):
                    best[name] = min(best.get(name, u), u)
    return best


def _is_alike(line: ErrorLine, other: ErrorLine) -> bool:
    """Say whether two lines are the same quantity: a curve is no constant."""
    return (line.form, line.horizons) == (other.form, other.horizons)


def match_catalogue(
    catalogue: Sequence[Device], sensors: Sequence[Sensor], *, sample_rate: float
) -> tuple[Match, ...]:
    """Hold every triad of the catalogue against the lines of the allocated ones.

    Their lines above zero are what counts; the sample rate turns noise of a sample into
    a density [Hz]. By sensor, the closest first: those that meet every line, then by
    missing lines, then by the worst ratio.
    """
    matches = [
        _match(device, offered, wanted, sample_rate)
        for wanted in sensors
        if any(line.u.any() for line in wanted.lines)
        for device in catalogue
        for offered in device.sensors
        if offered.kind == wanted.kind and offered.lines
    ]
    kinds = [sensor.kind for sensor in sensors]
    return tuple(
        sorted(
            matches,
            key=lambda m: (
                kinds.index(m.sensor),
                not m.meets,
                len(m.missing),
                settle(m.worst),
                m.device,
            ),
        )
    )


def _match(device: Device, offered: Sensor, wanted: Sensor, rate: float) -> Match:
    """Compare two triads line by line."""
    lines = []
    for line in wanted.lines:
        if not line.u.any():
            continue
        value, how = _value(offered, line, rate)
        # An axis that may have nothing has no ratio: the others decide.
        ratio = None
        if value is not None:
            value, size = np.abs(value), np.abs(line.u)  # a coefficient has a sign
            ratio = float((value / np.where(size > 0.0, size, np.inf)).max())
        lines.append(
            LineMatch(
                source=Name(line.name, owner=wanted.kind),
                value=None if value is None else float(value.max()),
                ratio=ratio,
                how=how,
            )
        )
    allotted = {line.name for line in wanted.lines if line.u.any()}
    noise = {SAMPLE_NOISE, *DENSITIES}
    extra = tuple(
        Name(line.name, owner=offered.kind)
        for line in offered.lines
        if line.u.any()
        and line.name not in allotted
        and not (line.name in noise and allotted & noise)
    )
    return Match(
        device=device.name,
        file=device.origin.file,
        sensor=offered.kind,
        lines=tuple(lines),
        extra=extra,
    )


def _value(sensor: Sensor, wanted: ErrorLine, rate: float) -> tuple[Array | None, str]:
    """Return what a triad has in one line [SI], white noise converted."""
    name, line = wanted.name, sensor.line(wanted.name)
    if line is not None:
        return (line.u, "") if _is_alike(line, wanted) else (None, OTHERWISE)
    if name == SAMPLE_NOISE:
        for density in DENSITIES:
            if (other := sensor.line(density)) is not None:
                return other.u * _per_density(wanted, rate), f"from its {density}"
    if name in DENSITIES and (other := sensor.line(SAMPLE_NOISE)) is not None:
        return other.u / _per_density(other, rate), f"from its {SAMPLE_NOISE}"
    return None, ""


def _per_density(noise: ErrorLine, rate: float) -> float:
    """Return u of a sample noise over its density: of an rms in a band it is that."""
    return 1.0 if noise.form == BAND else sqrt(rate)
