"""Orders of magnitude that the text gives: gyro (3.1) and accelerometer (3.2).

The text takes for the order of some entries the power of ten of the largest: beside
Table 1 it says 0.001 for -0.00296, -0.0063, -0.00577, and 1e-9 for 7.3213e-9.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import Name
from budget.studies.paper.conditions import (
    FARTHEST,
    PLACES,
    Expectation,
    expect,
    nominal_size,
    only_sources,
    with_lines,
)
from budget.studies.paper.findings import (
    AGREES,
    AGREES_IN_ORDER,
    EXPLAINED,
    READING,
    READING_FAILS,
    READING_FITS,
    U_SINGLE,
    UNEXPLAINED,
    WORD,
    Finding,
    ratio_of,
    say,
)
from budget.studies.paper.printed import (
    ACCELEROMETER_ORDERS,
    BOUND,
    GYRO_ORDERS,
    RUNS,
    TABLE_1,
    UNITS,
    PrintedOrder,
)
from budget.studies.paper.readings import ONCE_A_WINDOW, best_reading
from budget.studies.paper.statistics import LEVEL, order_probability
from budget.studies.paper.sweeps import power_of_ten
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.readings import Reading

STABILITY = Name("bias_stability", owner=GYRO)
NOISE = Name("sample_noise", owner=ACCELEROMETER)


def order_findings(
    conditions: Conditions,
    readings: tuple[Reading, ...],
    of_noise: tuple[Finding, ...],
) -> tuple[Finding, ...]:
    """Return one row for each order of magnitude in the text of section 3.

    Parameters
    ----------
    conditions : Conditions
    readings : tuple of Reading
        Those of Table 1.
    of_noise : tuple of Finding
        Those of the accelerometer noise, from noise_readings.

    Returns
    -------
    tuple of Finding
    """
    findings = []
    for printed in (*GYRO_ORDERS, *ACCELEROMETER_ORDERS):
        row = _judge(printed, expectation_of(printed, conditions), readings)
        if printed.source == NOISE:
            row = _explain_noise(row, printed, of_noise)
        findings.append(row)
        if (printed.source, printed.parameter) == (STABILITY, "scale_factor"):
            findings.append(_bound())
    return tuple(findings)


def expectation_of(printed: PrintedOrder, conditions: Conditions) -> Expectation:
    """Expect what the text speaks of; nonlinearity at its largest step."""
    sensor = conditions.sensor(printed.sensor)
    problem = only_sources(sensor, conditions.printed, printed.source)
    size = nominal_size(sensor) / UNITS[printed.unit]
    found = expect(problem, size)
    line = printed.source.quantity
    if line not in FARTHEST:
        return found
    # Stepped, not drawn: the error itself, and no spread.
    errors = problem.evaluate(np.full((problem.n_inputs, 1), FARTHEST[line]))[:, 0]
    return replace(found, mean=errors / size, covariance=np.zeros((12, 12)))


def noise_readings(conditions: Conditions) -> tuple[Finding, ...]:
    """Return readings of the accelerometer noise of 3.2."""
    sensor, procedure = conditions.accelerometer, conditions.printed
    size = nominal_size(sensor)
    line = sensor.line("sample_noise")
    if line is None:
        raise ValueError("the paper's accelerometer has no sample noise")
    sigma = float(line.u[0])
    samples = procedure.sample_rate * procedure.accelerometer.dwell
    readings = (
        ("50e-6 m/s^2 in place of 50 ug", sigma / STANDARD_GRAVITY),
        (ONCE_A_WINDOW, sigma / np.sqrt(samples)),
        (
            f"{ONCE_A_WINDOW}, and 50e-6 m/s^2",
            sigma / STANDARD_GRAVITY / np.sqrt(samples),
        ),
    )
    wanted = [row for row in ACCELEROMETER_ORDERS if row.source == NOISE]
    findings = []
    for name, u in readings:
        found = expect(
            only_sources(with_lines(sensor, sample_noise=float(u)), procedure, NOISE),
            size,
        )
        probabilities = {row: _probabilities(row, found) for row in wanted}
        fits = any(all(p[k] >= LEVEL for p in probabilities.values()) for k in range(2))
        findings += [
            Finding(
                section="readings",
                where=f"3.2, sample noise, {_words(row.parameter)}: {name}",
                printed=row.order,
                ours=float(found.u[PLACES[row.parameter]].max()),
                quantity=U_SINGLE,
                ratio=ratio_of(
                    float(found.u[PLACES[row.parameter]].max()), float(row.order)
                ),
                verdict=READING_FITS if fits else READING_FAILS,
                why="all three orders must come out, as single runs or as means",
                p_single=single,
                p_mean=mean,
                is_summary=True,
            )
            for row, (single, mean) in probabilities.items()
        ]
    return tuple(findings)


def _judge(
    printed: PrintedOrder, found: Expectation, readings: tuple[Reading, ...]
) -> Finding:
    """Hold one order against what it should be."""
    place = PLACES[printed.parameter]
    where = f"{printed.section}, {printed.sensor}, {printed.condition}, "
    row = Finding(
        section="text",
        where=where + _words(printed.parameter),
        printed=printed.order
        if printed.unit == "1"
        else f"{printed.order} {printed.unit}",
        ours=0.0,
        verdict=AGREES,
        why="",
        is_summary=True,
    )
    note = f"{printed.note}; " if printed.note else ""
    order = float(printed.order)
    if found.u[place].any():
        single, mean = _probabilities(printed, found)
        u = float(found.u[place].max())
        why = f"{note}p: of the largest entry having this order"
        verdict = AGREES_IN_ORDER
        if max(single, mean) < LEVEL:
            other = best_reading(readings, printed.source) if printed.source else None
            verdict = UNEXPLAINED if other is None else READING
            if other is not None:
                p = order_probability(
                    printed.order, other.expectation, place, runs=other.runs
                )
                why += f"; {say(p, 2)} if read so: {other.full_name}"
        return replace(
            row,
            ours=u,
            quantity=U_SINGLE,
            ratio=ratio_of(u, order),
            verdict=verdict,
            why=why,
            p_single=single,
            p_mean=mean,
        )
    ours = float(np.abs(found.mean[place]).max())
    zero = float(found.resolution[place].max())
    if ours <= zero:
        agrees = order <= zero
        return replace(
            row,
            verdict=AGREES if agrees else UNEXPLAINED,
            why=f"{note}no effect; {say(zero, 1)} is rounding here"
            if order
            else f"{note}no effect",
        )
    same = power_of_ten(ours) == power_of_ten(order)
    return replace(
        row,
        ours=ours,
        ratio=ratio_of(ours, order),
        verdict=AGREES_IN_ORDER if same else EXPLAINED,
        why=f"{note}not rounding, as the text has it: eq. (4)'s own error",
    )


def _bound() -> Finding:
    """Hold the one order that the text gives as a bound against the table beside it."""
    row = next(row for row in TABLE_1 if row.source == STABILITY)
    largest = max(row.scale_factor, key=lambda text: abs(float(text)))
    beyond = abs(float(largest)) / float(BOUND)
    as_order = power_of_ten(float(largest)) == power_of_ten(float(BOUND))
    return Finding(
        section="text",
        where="3.1, gyro, bias stability, scale factor as a bound",
        printed=f"within {BOUND}",
        ours=f"{largest} in Table 1",
        quantity=WORD,
        ratio=beyond,
        verdict=EXPLAINED if as_order else UNEXPLAINED,
        why=f"the table beside the text has an entry {say(beyond)} times that bound; "
        "as a power of ten, which is how the text reads all others, the two agree",
        is_summary=True,
    )


def _explain_noise(
    row: Finding, printed: PrintedOrder, of_noise: tuple[Finding, ...]
) -> Finding:
    """Name the readings that give the orders of the accelerometer noise."""
    names = [
        found.where.partition(": ")[2]
        for found in of_noise
        if found.verdict == READING_FITS
        and f", {_words(printed.parameter)}: " in found.where
    ]
    if row.verdict != UNEXPLAINED or not names:
        return row
    why = f"{row.why}; all three orders come out if read so: {'; or '.join(names)}"
    return replace(row, verdict=READING, why=why)


def _probabilities(printed: PrintedOrder, found: Expectation) -> tuple[float, float]:
    """Return the probability of the order in a single run and in a mean over 25."""
    place = PLACES[printed.parameter]
    return (
        order_probability(printed.order, found, place, runs=1),
        order_probability(printed.order, found, place, runs=RUNS),
    )


def _words(name: str) -> str:
    """Turn a key into words."""
    return name.replace("_", " ")
