"""Calibrations of several units beside their data sheet: the spread of a lot.

Of n units whose values scatter by s about their mean, (n - 1) s^2/u^2 is chi-square
with n - 1 degrees of freedom where u is the tolerance printed for them with what each
value is not known to: its upper tail is p, its quantiles give the interval of the
spread.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mistakes import prior_of
from budget.documents import Documented, written
from budget.errors import CallError
from budget.model.source import GYRO
from budget.names import PARAMETERS, parameters_of
from budget.recordings.results import (
    LEVEL,
    common_keys,
    counted_once,
    in_one_unit,
    said_of,
)
from budget.results import input_files, numbered_files
from budget.units import STANDARD_GRAVITY, size_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device
    from budget.recordings.calibrated import CalibrationResult, Key
    from budget.results import InputFile

WORSE, WITHIN = "worse", "within"
NOT_PRINTED, NOT_TOLD = "not_printed", "not_told"
LEAST = 2  # units of which there is a spread


@written(
    "lot_spread",
    """
    sensor: 'gyro' or 'accelerometer'
    parameter
    axis
    unit
    units [1]: how many there are
    mean [unit]
    spread [unit]: standard deviation of the units, less what their values are not known
      to
    spread_low [unit]: of its interval at 95 %
    spread_high [unit]
    printed [unit]: standard uncertainty by the data sheet; null where it gives none
    p [1]: probability of as large a spread in a lot as printed; likewise
    standing: 'within', 'worse' where p is below 5 % over all that are judged,
      'not_printed' in this unit, or 'not_told' where a value has no uncertainty
    """,
)
@dataclass(frozen=True, kw_only=True)
class LotSpread(Documented):
    """One parameter over the units of a lot."""

    sensor: str
    parameter: str
    axis: str
    unit: str
    units: int
    mean: float
    spread: float
    spread_low: float
    spread_high: float
    printed: float | None
    p: float | None
    standing: str


@written(
    "calibrated_lot",
    """
    title: name of the data sheet
    units (list[str]): serial numbers, or names of results
    inputs by role as file
    level [1]: below which p is worse, 5 % over all that are judged
    parameters
    warnings
    """,
    commands="diff",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class CalibratedLot(Documented):
    """Units of a lot, calibrated, beside their data sheet."""

    title: str
    units: tuple[str, ...]
    inputs: tuple[InputFile, ...]
    level: float
    parameters: tuple[LotSpread, ...]
    warnings: tuple[str, ...]

    @property
    def worse(self) -> tuple[LotSpread, ...]:
        """Parameters that spread more than printed."""
        return tuple(one for one in self.parameters if one.standing == WORSE)

    @property
    def judged(self) -> tuple[LotSpread, ...]:
        """Parameters that are held against what is printed."""
        return tuple(one for one in self.parameters if one.p is not None)


def lot_of(device: Device, results: Sequence[CalibrationResult]) -> CalibratedLot:
    """Hold calibrations of several units beside their data sheet.

    Runs that were not sound are left out.

    Raises
    ------
    CallError
        They are fewer than two, of one unit, or have no parameter of the device.
    """
    kept, twice = counted_once(results)
    sound = [one for one in kept if one.is_sound is not False]
    units = [one.serial or one.name for one in sound]
    if len(sound) < LEAST:
        said = "".join(f"; {one}" for one in twice)
        raise CallError(f"fewer than two units were calibrated by a sound run{said}")
    if len({*units}) < len(units):
        raise CallError(
            "some results are of one unit; of a unit over time ask `budget history`"
        )
    known = _printed(device)
    has = [(device.name, tuple(known)), *((one.name, one.keys) for one in sound)]
    keys, left_out = common_keys(has, among=PARAMETERS)
    if not keys:
        raise CallError(f"the results have no parameter of {device.name} in common")
    rows = [_spread(key, sound, known[key]) for key in keys]
    level = LEVEL / max(sum(one.p is not None for one in rows), 1)
    return CalibratedLot(
        title=device.name,
        units=tuple(units),
        inputs=(
            *input_files((device,)),
            *numbered_files("result", [one.file for one in kept]),
        ),
        level=level,
        parameters=tuple(
            one
            if one.p is None
            else replace(one, standing=WORSE if one.p < level else WITHIN)
            for one in rows
        ),
        warnings=(*said_of(kept), *twice, *left_out),
    )


def _printed(device: Device) -> dict[Key, float | None]:
    """Return how well each parameter is known by the data sheet [SI]; None if not."""
    found: dict[Key, float | None] = {}
    for sensor in device.sensors:
        largest = 1.0 if sensor.kind == GYRO else STANDARD_GRAVITY
        prior = prior_of(sensor, largest)
        for name, u, is_known in zip(
            parameters_of(sensor.kind), prior.u, prior.is_known, strict=True
        ):
            key = (name.owner, name.quantity, name.axis)
            found[key] = float(u) if is_known else None
    return found


def _spread(
    key: Key, results: Sequence[CalibrationResult], printed: float | None
) -> LotSpread:
    """Return one parameter over the units, not judged yet.

    Raises
    ------
    CallError
        It is in several units of measurement.
    """
    from scipy.special import chdtrc, chdtri

    sensor, parameter, axis = key
    unit, values, variances = in_one_unit(key, results, "units")
    is_told = bool(np.isfinite(variances).all())
    own = float(np.mean(variances)) if is_told else 0.0
    n = len(values)
    square = float(values.var(ddof=1))
    # Quantiles of (n - 1) s^2/u^2; what values are not known to is no spread.
    ends = [
        sqrt(max((n - 1) * square / float(chdtri(n - 1, q)) - own, 0.0))
        for q in (0.025, 0.975)
    ]
    told = p = None
    if printed is not None and "counts" not in unit:
        told = printed / size_of(unit)
        if is_told:
            p = float(chdtrc(n - 1, (n - 1) * square / (told**2 + own)))
    return LotSpread(
        sensor=sensor,
        parameter=parameter,
        axis=axis,
        unit=unit,
        units=n,
        mean=float(values.mean()),
        spread=sqrt(max(square - own, 0.0)),
        spread_low=ends[0],
        spread_high=ends[1],
        printed=told,
        p=p,
        standing=NOT_PRINTED if told is None else NOT_TOLD,
    )
