"""Sweep: the budget over values of one line of a data sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.errors import CallError
from budget.inputs import (
    load_calibration,
    load_device,
    load_mission,
    load_requirement,
)
from budget.inputs.changes import read_change
from budget.inputs.load import several
from budget.studies.analysis import analyze

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    import pandas as pd

    from budget.inputs.files import File
    from budget.inputs.records import Device, Mission, Procedure, Requirement, Station
    from budget.names import Name
    from budget.results import Budget


def sweep(
    device: Device | File,
    line: str,
    values: Iterable[object],
    *,
    procedure: Procedure | File | None = None,
    requirement: Requirement | File | None = None,
    calibration: Procedure | File | None = None,
    station: Station | File | None = None,
    age: str | None = None,
    environment: str | None = None,
    mission: Mission | File | None = None,
    at: Sequence[float | str] = (),
    coverage: float | None = None,
    reference: str | None = None,
    outputs: Sequence[str] = (),
    validate: bool = False,
    seed: int = 0,
) -> pd.DataFrame:
    """Compute the budget for each of several values of a line.

    Parameters
    ----------
    device : Device, or what load_device takes
        All its other lines stay as they are.
    line : str
        'gyro.bias_stability', 'gyro.nominal.bias.x', as `Device.replace` takes it.
    values : iterable
        '0.5 deg/h' and others, each as a device file would give it.
    procedure, requirement, outputs, seed
        As of `analyze`.
    calibration, station, age, environment, mission, at
        As of `analyze`.
    coverage, reference
        As of `analyze`; with a requirement those that it asks for.
    validate : bool
        Whether Monte Carlo checks the law, for every value.

    Returns
    -------
    DataFrame
        A row for each value and output, in printed units: `value` as it was given, then
        sensor, parameter, axis, of a mission time [s], unit, mean,
        standard_uncertainty, interval_low, interval_high; `share` of the variance that
        the line contributes [1], products left out; with a requirement limit,
        utilisation [1] and the verdict on the sensor, empty where the output has no
        limit, which adds no rows.

    Raises
    ------
    SpecError
        A value is none of that line.
    CallError
        There is no value, or what `analyze` refuses.
    """
    import pandas as pd

    start = load_device(device)
    wanted = None if requirement is None else load_requirement(requirement)
    route = None if mission is None else load_mission(mission)
    how = load_calibration(
        calibration,
        procedure,
        station=station,
        age=age,
        environment=environment,
        mission=route,
        requirement=wanted,
    )
    given = () if isinstance(values, str) else several(values)
    if not given:
        raise CallError(
            f"{line}: expected a list of values to compute the budget for, as "
            "['0.01 deg/h', '0.02 deg/h']"
        )
    changed = [start.replace({line: value}) for value in given]  # refused at once
    address = read_change(f"{line}=0").address
    rows: list[dict[str, Any]] = []
    for value, one in zip(given, changed, strict=True):
        budget = analyze(
            one,
            procedure=how,
            requirement=wanted,
            mission=route,
            at=at,
            coverage=coverage,
            reference=reference,
            outputs=outputs,
            validate=validate,
            seed=seed,
            command="sweep",
        )
        rows += ({"value": value, **row} for row in _rows(budget, address))
    return pd.DataFrame.from_records(rows)


def _rows(budget: Budget, line: Name) -> Iterator[dict[str, Any]]:
    """Yield what a sweep says of each output of one budget."""
    found = budget.assessment
    limits = {} if found is None else {row.output.name: row for row in found.outputs}
    verdicts = {} if found is None else {one.sensor: one for one in found.sensors}
    asked = budget.settings.outputs or [row.output.name for row in budget.outputs]
    for row in budget.outputs:
        if row.output.name not in asked:
            continue
        own = row.in_unit()
        shares = [part.share for part in row.contributions if part.source == line]
        record: dict[str, Any] = {
            "sensor": row.sensor,
            "parameter": row.parameter,
            "axis": row.axis,
            **({} if row.output.name.time is None else {"time": row.output.name.time}),
            "unit": own.unit,
            "mean": own.mean,
            "standard_uncertainty": own.standard_uncertainty,
            "interval_low": own.interval[0],
            "interval_high": own.interval[1],
            "share": sum(shares),
        }
        if found is not None:
            limit = limits.get(row.output.name)
            record |= dict.fromkeys(("limit", "utilisation", "verdict"))
            if limit is not None:
                record |= {
                    "limit": limit.limit / row.output.si_per_unit,
                    "utilisation": limit.utilisation,
                    "verdict": verdicts[row.sensor].verdict,
                }
        yield record
