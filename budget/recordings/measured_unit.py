"""A unit whose calibration was recorded, in the place of a prediction of it.

The covariance C of a result stands for that of errors against the values during the
test, which the budget predicts as the sum over sources s of J_s U_s J_s'. Of these
noise, table and place act by the readings alone; what the unit's own constants (its
g-sensitivity, the shape of its scale factor) put into the estimates they give back in
use, so that their lines stay, and C less their part is what is drawn besides. By the
scatter of a run nothing is known of table, place and constants: all of it is noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem, is_by_readings
from budget.calibration.schemes import calibrates, estimated
from budget.errors import CallError
from budget.inputs.records import CHANGED, MeasuredParameters
from budget.methods.gum import covariance_by_source, derivatives
from budget.model.source import SENSORS
from budget.names import Name
from budget.recordings.columns import COUNTS
from budget.recordings.results import read_results
from budget.recordings.run_values import AS_TESTED
from budget.sentences import sentence
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.inputs.changes import Changes
    from budget.inputs.files import File
    from budget.inputs.records import Device, Procedure, Sensor
    from budget.recordings.calibrated import CalibrationResult


def measured_units(
    devices: Sequence[Device], files: Sequence[File], procedures: Sequence[Procedure]
) -> list[tuple[Device, Device]]:
    """Return data sheets, each with the unit of it that a result is of.

    Parameters
    ----------
    devices : sequence of Device
        Data sheets; that of a result has the name of its device, or is the only one.
    files : sequence of str or Path
        Results of `budget calibrate --json`.
    procedures : sequence of Procedure
        Of which one is that of the result.

    Raises
    ------
    CallError
        A result is of another device or procedure, of a run that was not sound, in
        counts, lacks parameters, or does not say how sure they are.
    SpecError
        A file is no result.
    """
    found: list[tuple[Device, Device]] = []
    read: list[CalibrationResult] = []
    for one in read_results(files):
        twice = next((x for x in read if x.sha256 == one.sha256), None)
        if twice is not None:
            raise CallError(f"{twice.name} and {one.name} are one result; give it once")
        read.append(one)
        device = _device_of(one, devices)
        unit = measured_unit(device, one, _procedure_of(one, procedures))
        found.append((device, unit))
    names = [unit.name for _, unit in found]
    return [
        (sheet, unit)
        if names.count(unit.name) == 1
        else (sheet, _named(unit, f"{unit.name}, {one.name}"))
        for (sheet, unit), one in zip(found, read, strict=True)
    ]


def _device_of(result: CalibrationResult, devices: Sequence[Device]) -> Device:
    """Return the data sheet of a result."""
    title = result.title.removesuffix(CHANGED)
    own = [one for one in devices if one.as_printed == title]
    if not result.has_device:
        own = own or [*devices]
    if len(own) == 1:
        return own[0]
    names = ", ".join(repr(one.name) for one in devices)
    if own:
        raise CallError(
            f"{result.name} does not say of which device it is, and {len(own)} may be "
            f"meant ({names}); calibrate with --device, or give one device"
        )
    raise CallError(
        f"{result.name} is a calibration of {result.title!r}, found {names}; give the "
        "device file that it was calibrated with, or the result of a unit of this one"
    )


def _procedure_of(
    result: CalibrationResult, procedures: Sequence[Procedure]
) -> Procedure:
    """Return the procedure of a result."""
    own = [one for one in procedures if one.name == result.procedure]
    if own:
        return own[0]
    names = ", ".join(repr(one.name) for one in procedures)
    raise CallError(
        f"{result.name} was calibrated by {result.procedure!r}, found {names}; give "
        "--procedure with the file of the one that it was calibrated by"
    )


def measured_unit(
    device: Device, result: CalibrationResult, procedure: Procedure
) -> Device:
    """Return a device of which one unit was calibrated.

    Raises
    ------
    CallError
        As measured_units.
    """
    where = result.name
    if result.is_sound is False:
        raise CallError(
            f"{where} is of a run that was not sound (is_sound: false), whose values "
            "nobody should correct by; find what went wrong and calibrate again"
        )
    sheet = _sheet_of(device, result)
    _check_files(device, result, procedure)
    triads = tuple(one for one in sheet.sensors if calibrates(one.kind, procedure))
    names = [x for one in triads for x in estimated(one.kind, procedure)]
    places = [_place(result, name) for name in names]
    absent = [name for name, k in zip(names, places, strict=True) if k is None]
    if absent:
        raise CallError(
            f"{where} says nothing of {', '.join(absent)}, or not how sure it is, and "
            f"{procedure.name} estimates it of {device.name}; give the result of a run "
            "with all of its triads, or leave it out"
        )
    rows = [k for k in places if k is not None]
    if any(COUNTS in result.units[k] for k in rows):
        raise CallError(
            f"{where} is in counts, of which no error of a unit in use follows; "
            "calibrate with a gain in the recording file"
        )
    sizes = np.array([_size(result, k) for k in rows])
    C = result.covariance[np.ix_(rows, rows)] * np.outer(sizes, sizes)
    if result.has_device:
        C = _without(C, _by_constants(sheet, procedure, names))
    measured = MeasuredParameters(
        names=tuple(names),
        covariance=C,
        degrees_of_freedom=result.degrees_of_freedom[rows],
        noise=_noise_of(triads) if result.has_device else None,
        has_station=result.has_device and result.has_station,
        file=where,
        sha256=result.sha256,
        serial=result.serial,
        date=result.date,
        procedure=procedure.name,
        is_told=result.is_sound is not None,
        is_bound=result.is_bound,
    )
    said = sentence(
        "measured_unit.measured",
        name=device.name,
        file=where,
        serial=result.serial,
        date=result.date,
        procedure=procedure.name,
        is_by_scatter=not result.has_device,
    )
    unit = f"unit {result.serial}" if result.serial else where
    return _measured(device, measured, name=f"{device.name} ({unit})", said=said)


def _sheet_of(device: Device, result: CalibrationResult) -> Device:
    """Return the data sheet as it was calibrated with, without changes made since."""
    own = [one.to_dict() for one in device.origin.changes]
    told = [*result.changes]
    if not result.has_device or told == own or not own:
        plain = device
    else:
        plain = device if device.read_plain is None else device.read_plain()
    if result.has_device and told != [one.to_dict() for one in plain.origin.changes]:
        raise CallError(
            f"{result.name} was calibrated with values laid over the device file "
            f"(--set), and {device.name} has others; give the same, or calibrate again"
        )
    return plain


def _check_files(
    device: Device, result: CalibrationResult, procedure: Procedure
) -> None:
    """Refuse a result of another version of a file, or of another table."""
    files = {"procedure": procedure.origin}
    if result.has_device:
        files["device"] = device.origin
    if result.has_station and procedure.station_origin is not None:
        files["station"] = procedure.station_origin
    for role, origin in files.items():
        if result.files.get(role) != origin.sha256:
            raise CallError(
                f"{result.name} was calibrated with another {role} than {origin.file} "
                "is now (SHA-256); give that file, or calibrate again"
            )


def _size(result: CalibrationResult, k: int) -> float:
    """Return the unit of a value, of a scale factor relative to it [SI]."""
    size = size_of(result.units[k])
    is_relative = result.keys[k][1] == "scale_factor"
    return size / (1.0 + result.values[k] * size) if is_relative else size


def _place(result: CalibrationResult, name: Name) -> int | None:
    """Return where a result has a parameter with its uncertainty; None: nowhere."""
    key = (name.owner, name.quantity, name.axis)
    if key not in result.keys:
        return None
    k = result.keys.index(key)
    return k if np.isfinite(result.covariance[k, k]) else None


def _measured(
    device: Device, measured: MeasuredParameters, *, name: str, said: str
) -> Device:
    """Return a device with what was measured in its triads."""
    again = device.read_again

    def read_again(changes: Changes) -> Device:
        return _measured(again(changes), measured, name=name, said=said)  # type: ignore[misc]

    named = _named(device, name)
    return replace(
        named,
        **{
            kind: replace(one, measured=measured)
            for kind in SENSORS
            for one in [getattr(named, kind)]
            if one is not None
        },
        assumptions=(said, *device.assumptions),
        read_again=None if again is None else read_again,
    )


def _named(device: Device, name: str) -> Device:
    """Return a device of another name."""
    triads = {
        kind: replace(one, device=name)
        for kind in SENSORS
        for one in [getattr(device, kind)]
        if one is not None
    }
    return replace(device, name=name, **triads)


def _by_constants(device: Device, procedure: Procedure, names: Sequence[Name]) -> Array:
    """Return what constants of a unit put into the estimates, (n, n) [SI squared]."""
    sensors = tuple(one for one in device.sensors if calibrates(one.kind, procedure))
    problem = calibration_problem(
        sensors, procedure, reference=AS_TESTED, outputs=tuple(names)
    )
    each = covariance_by_source(problem, derivatives(problem))
    noise = _noise_of(sensors)
    owned = [
        each[g]
        for g, group in enumerate(problem.groups)
        if group.name.owner in SENSORS and group.name not in noise
    ]
    return np.asarray(sum(owned, np.zeros(each.shape[1:])))


def _noise_of(sensors: Sequence[Sensor]) -> frozenset[Name]:
    """Return the lines of triads that act by the readings of a test alone."""
    return frozenset(
        Name(line.name, owner=one.kind)
        for one in sensors
        for line in one.lines
        if is_by_readings(one.kind, line, has_station=True)
    )


def _without(C: Array, part: Array) -> Array:
    """Return C less a part of it, the nearest that a covariance can have.

    A part that is more than all of it counts in full: nothing is left beside it.
    """
    u = np.sqrt(np.diag(C))
    size = np.where(u > 0.0, u, 1.0)
    left = (C - part) / size[:, None] / size
    values, vectors = np.linalg.eigh(0.5 * (left + left.T))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    found = root @ root.T * np.outer(size, size)
    return np.asarray(0.5 * (found + found.T))
