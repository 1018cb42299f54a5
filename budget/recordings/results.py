"""Results of recorded calibrations read again: what changed between two, and in time.

A parameter moved where its two values differ by more than both uncertainties: z of
their difference has p below 5 % over all that are held beside each other. The change is
the size of a known mistake where that mistake, made in one of the two runs, explains
most of it: with d the changes of a triad, C the sum of both covariances and D what the
estimator makes of readings with the mistake, d' C^-1 d less (d - D)' C^-1 (d - D).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from hashlib import sha256
from math import erfc, hypot, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.mistakes import (
    TOLD_APART,
    inputs_of,
    mistakes_of,
)
from budget.calibration.schemes import as_recorded, calibrates, scheme_of, windows_of
from budget.documents import Documented, written
from budget.errors import CallError
from budget.inputs.files import find
from budget.inputs.reader import refuse
from budget.inputs.records import Sensor
from budget.journal import note_read
from budget.model.source import SENSORS
from budget.names import ANGLES, AXES, PARAMETERS
from budget.recordings.calibrated import MistakeRow
from budget.results import InputFile
from budget.sentences import sentence
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import Procedure
    from budget.model.scheme import Scheme

MOVED, WITHIN = "moved", "within"
LEVEL = 0.05  # probability that one of all is found to have moved, and none has
EXPLAINED = 0.1  # of the squares of a change, that a mistake leaves at the most [1]
COMMAND = "calibrate"
MOST_BYTES = 64 * 1024 * 1024
Key = tuple[str, str, str]


@dataclass(frozen=True, kw_only=True, eq=False)
class CalibrationResult:
    """What a document of `budget calibrate` says of its values.

    Attributes
    ----------
    name : str
        Of its file.
    sha256 : str
    title, serial, date, procedure : str
    is_sound : bool or None
    keys : tuple of (str, str, str)
        Sensor, parameter and axis of each value.
    units : tuple of str
    values, expanded : ndarray, shape (n,)
        In these units.
    covariance : ndarray, shape (n, n)
        Likewise.
    """

    name: str
    sha256: str
    title: str
    serial: str
    date: str
    procedure: str
    is_sound: bool | None
    keys: tuple[Key, ...]
    units: tuple[str, ...]
    values: Array
    expanded: Array
    covariance: Array


def is_result(name: File) -> bool:
    """Whether a file is a result of `budget calibrate`, by its first words."""
    path = find(name, "device").path
    if path.suffix.lower() != ".json":
        return False
    try:
        with path.open("rb") as stream:
            return b'"command": "calibrate"' in stream.read(400)
    except OSError:
        return False


def read_result(name: File) -> CalibrationResult:
    """Read a result of `budget calibrate --json`.

    Raises
    ------
    SpecError
        It cannot be read, or is none.
    """
    file = find(name, "device")
    try:
        note_read(file.path)
        size = file.path.stat().st_size
        data = file.path.read_bytes() if size <= MOST_BYTES else b""
        return _result(file.path.name, data)
    except OSError as error:
        raise refuse(file.shown, f"cannot be read ({error.strerror})") from None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        message = "is no result of a calibration, expected one of calibrate --json"
        raise refuse(file.shown, message) from None


def _result(name: str, data: bytes) -> CalibrationResult:
    """Return what a document says.

    Raises
    ------
    ValueError, TypeError, KeyError, AttributeError, RecursionError
        It is no such document.
    """
    document = json.loads(data)
    rows = document["outputs"]
    n = len(rows)
    covariance = np.array(document["covariance"], dtype=float).reshape(n, n)
    values = np.array([float(one["value"]) for one in rows])
    every = (values, covariance.ravel())
    if document["command"] != COMMAND or not np.isfinite(np.concatenate(every)).all():
        raise ValueError(name)
    return CalibrationResult(
        name=name,
        sha256=sha256(data).hexdigest(),
        title=str(document["title"]),
        serial=str(document["serial"]),
        date=str(document["date"]),
        procedure=str(document.get("procedure", "")),
        is_sound=document["is_sound"],
        keys=tuple(
            (str(x["sensor"]), str(x["parameter"]), str(x["axis"])) for x in rows
        ),
        units=tuple(str(one["unit"]) for one in rows),
        values=values,
        expanded=np.array(
            [
                float(one["coverage_factor"]) * float(one["standard_uncertainty"])
                for one in rows
            ]
        ),
        covariance=covariance,
    )


@written(
    "changed_parameter",
    """
    sensor: 'gyro', 'accelerometer' or, of both together, 'imu'
    parameter
    axis
    unit
    first [unit]: value
    second [unit]
    difference [unit]: second less first
    standard_uncertainty [unit]: of the difference
    z [1]: difference over it
    p [1]: probability of one as large where nothing moved
    standing: 'moved' or 'within'
    """,
)
@dataclass(frozen=True, kw_only=True)
class ChangedParameter(Documented):
    """One parameter in two calibrations."""

    sensor: str
    parameter: str
    axis: str
    unit: str
    first: float
    second: float
    difference: float
    standard_uncertainty: float
    z: float
    p: float
    standing: str


@written(
    "change_of_a_mistake",
    """
    *mistake as mistake
    evidence: squares of the change that it explains
    run: in which it would have been made, 'first' or 'second'
    """,
)
@dataclass(frozen=True, kw_only=True)
class ChangeOfMistake(Documented):
    """A mistake in one of two runs that a change is the size of."""

    mistake: MistakeRow
    evidence: float
    run: str


@written(
    "calibration_change",
    """
    first: name of the first result
    second: name of the second
    inputs by role as file
    level [1]: below which p has moved, 5 % over all parameters
    parameters
    looks_like: mistakes in one of the two that the change is the size of
    warnings
    """,
    commands="diff",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class CalibrationChange(Documented):
    """Two calibrations of a unit, side by side."""

    first: str
    second: str
    inputs: tuple[InputFile, ...]
    level: float
    parameters: tuple[ChangedParameter, ...]
    looks_like: tuple[ChangeOfMistake, ...]
    warnings: tuple[str, ...]

    @property
    def moved(self) -> tuple[ChangedParameter, ...]:
        """Parameters that moved, the farthest first."""
        found = [one for one in self.parameters if one.standing == MOVED]
        return tuple(sorted(found, key=lambda one: -abs(one.z)))


def change_between(
    first: CalibrationResult, second: CalibrationResult, procedure: Procedure | None
) -> CalibrationChange:
    """Hold two calibrations beside each other.

    Parameters
    ----------
    procedure : Procedure or None
        That was followed; without it no mistake is looked for.

    Raises
    ------
    CallError
        They have no parameter in common, or other units.
    """
    places = {key: k for k, key in enumerate(first.keys)}
    common = [(places[key], k) for k, key in enumerate(second.keys) if key in places]
    if not common:
        raise CallError(f"{first.name} and {second.name} have no parameter in common")
    for a, b in common:
        if first.units[a] != second.units[b]:
            raise CallError(
                f"{' '.join(first.keys[a])} is in {first.units[a]} in {first.name}, "
                f"and in {second.units[b]} in {second.name}; calibrate both with, or "
                "without, a gain"
            )
    level = LEVEL / len(common)
    rows = [_changed(first, second, a, b, level) for a, b in common]
    looks = () if procedure is None else _looks(first, second, procedure)
    warnings = [
        *(
            sentence("calibrations.unsound", name=one.name)
            for one in (first, second)
            if one.is_sound is False
        ),
        *(
            [sentence("calibrations.other_unit")]
            if first.serial != second.serial
            else []
        ),
        *([sentence("calibrations.no_procedure")] if procedure is None else []),
        *(
            sentence("calibrations.other_procedure", name=one.name, own=one.procedure)
            for one in (first, second)
            if procedure is not None and one.procedure not in {"", procedure.name}
        ),
    ]
    return CalibrationChange(
        first=first.name,
        second=second.name,
        inputs=tuple(
            InputFile(role=role, name=one.name, sha256=one.sha256)
            for role, one in (("first", first), ("second", second))
        ),
        level=level,
        parameters=tuple(rows),
        looks_like=tuple(looks),
        warnings=tuple(warnings),
    )


def _changed(
    first: CalibrationResult,
    second: CalibrationResult,
    a: int,
    b: int,
    level: float,
) -> ChangedParameter:
    """Return one parameter in both."""
    sensor, parameter, axis = first.keys[a]
    difference = float(second.values[b] - first.values[a])
    u = hypot(sqrt(first.covariance[a, a]), sqrt(second.covariance[b, b]))
    z = difference / u if u > 0.0 else 0.0
    p = erfc(abs(z) / sqrt(2.0))
    return ChangedParameter(
        sensor=sensor,
        parameter=parameter,
        axis=axis,
        unit=first.units[a],
        first=float(first.values[a]),
        second=float(second.values[b]),
        difference=difference,
        standard_uncertainty=u,
        z=z,
        p=p,
        standing=MOVED if p < level else WITHIN,
    )


def _looks(
    first: CalibrationResult, second: CalibrationResult, procedure: Procedure
) -> Iterator[ChangeOfMistake]:
    """Yield for each triad the mistake that its change is the size of, if any is."""
    windows = windows_of(procedure)
    numbers = range(1, len(windows) + 1)
    for kind in SENSORS:
        if not calibrates(kind, procedure):
            continue
        keys = [(kind, q, axis) for q in PARAMETERS for axis in _axes_of(q)]
        both = [key for key in keys if key in first.keys and key in second.keys]
        if len(both) < len(keys) or "counts" in first.units[first.keys.index(both[0])]:
            continue
        change, covariance = _of_triad(first, second, both)
        own = [k for k, one in enumerate(windows) if one.use in {kind, "both"}]
        scheme = scheme_of(kind, as_recorded(procedure, windows), Sensor.bare(kind))
        found = [
            (left, run, mistake)
            for mistake in mistakes_of(
                kind,
                [windows[k] for k in own],
                [numbers[k] for k in own],
                procedure.place,
                procedure.sample_rate,
            )
            for run, sign in (("second", 1.0), ("first", -1.0))
            if (made := _made(scheme, mistake)) is not None
            for left in [_square(change - sign * made, covariance)]
        ]
        whole = _square(change, covariance)
        least = min(found, key=lambda one: one[0], default=None)
        if least is None or whole - least[0] <= TOLD_APART:
            continue
        if least[0] <= EXPLAINED * whole:
            yield ChangeOfMistake(
                mistake=MistakeRow.of(kind, least[2]),
                evidence=whole - least[0],
                run=least[1],
            )


def _axes_of(parameter: str) -> Sequence[str]:
    """Return the axes of a parameter."""
    return ANGLES if parameter == "mounting_angle" else AXES


def _of_triad(
    first: CalibrationResult, second: CalibrationResult, keys: Sequence[Key]
) -> tuple[Array, Array]:
    """Return the change of parameters, (12,), and its covariance [SI]."""
    a = [first.keys.index(key) for key in keys]
    b = [second.keys.index(key) for key in keys]
    sizes = np.array([size_of(first.units[k]) for k in a])
    change = (second.values[b] - first.values[a]) * sizes
    C = first.covariance[np.ix_(a, a)] + second.covariance[np.ix_(b, b)]
    return change, np.asarray(C * np.outer(sizes, sizes))


def _square(change: Array, covariance: Array) -> float:
    """Return d' C^-1 d."""
    u = np.sqrt(np.diag(covariance))
    scaled = change / u
    return float(scaled @ np.linalg.solve(covariance / np.outer(u, u), scaled))


def _made(scheme: Scheme, mistake: Any) -> Array | None:  # noqa: ANN401 - of mistakes
    """Return what a mistake makes of the parameters of a nominal triad, (12,) [SI]."""
    place = mistake.place or scheme.place
    windows = mistake.really(scheme.schedule.windows)
    readings = mistake.done(inputs_of(scheme.owner, windows, place).T)
    with np.errstate(all="ignore"):
        found = scheme.estimate(readings)
    values = np.concatenate(
        [found.scale_factor - 1.0, found.mounting_angle, found.bias]
    )
    return values if np.isfinite(values).all() else None
