"""Orders of magnitude that the text gives: gyro (3.1) and accelerometer (3.2).

The text takes for the order of some entries the power of ten of the largest: beside
Table 1 it says 0.001 for -0.00296, -0.0063, -0.00577, and 1e-9 for 7.3213e-9.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from budget.model.sources import ACCELEROMETER
from budget.names import Name
from budget.studies.paper.conditions import (
    PLACES,
    Expectation,
    expect,
    nominal_size,
    only_sources,
    value_of,
    with_lines,
)
from budget.studies.paper.findings import (
    RUNS,
    U_SINGLE,
    VALUE,
    WORD,
    Finding,
    Verdict,
    agrees_if,
    ratio_of,
    say,
    words,
)
from budget.studies.paper.printed import UNITS
from budget.studies.paper.readings import STABILITY, best_reading
from budget.studies.paper.statistics import LEVEL, order_probability
from budget.studies.paper.sweeps import power_of_ten
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.printed import Parameter, PrintedOrders
    from budget.studies.paper.readings import Reading

NOISE = Name("sample_noise", owner=ACCELEROMETER)


def order_findings(
    conditions: Conditions, readings: tuple[Reading, ...]
) -> tuple[Finding, ...]:
    """Return one row for each order of magnitude in the text of section 3.

    After those of the text come those of the readings of the accelerometer noise.
    """
    found = []
    of_noise: list[Finding] = []
    for printed in conditions.paper.orders:
        expected = expectation_of(printed, conditions)
        other, cause = None, ""
        if printed.name == NOISE:
            of_noise = noise_readings(printed, conditions)
            fitting = [r.where for r in of_noise if r.verdict == Verdict.READING_FITS]
            names = dict.fromkeys(where.partition(": ")[2] for where in fitting)
            if names:
                cause = f"all three orders come out if read so: {'; or '.join(names)}"
        elif printed.source:
            other = best_reading(readings, printed.name)
        for parameter in printed.errors:
            if other is not None and other.is_random(parameter):
                p = order_probability(
                    printed.errors[parameter],
                    other.expectation,
                    PLACES[parameter],
                    runs=other.runs,
                )
                cause = f"{say(p)} if read so: {other.full_name}"
            found.append(_judge(printed, parameter, expected, cause=cause))
            if (printed.name, parameter) == (STABILITY, "scale_factor"):
                found.append(_bound(conditions))
    return (*found, *of_noise)


def expectation_of(printed: PrintedOrders, conditions: Conditions) -> Expectation:
    """Expect what the text speaks of; nonlinearity at its largest step."""
    sensor = conditions.sensor(printed.sensor)
    problem = only_sources(sensor, conditions.printed, printed.name)
    size = nominal_size(sensor) / UNITS[printed.unit]
    found = expect(problem, size)
    step = conditions.paper.farthest.get(printed.source)
    if step is None:
        return found
    # Stepped, not drawn: the error itself, and no spread.
    errors = problem.evaluate(np.full((problem.n_inputs, 1), step))[:, 0]
    return replace(found, mean=errors / size, covariance=np.zeros((12, 12)))


def noise_readings(printed: PrintedOrders, conditions: Conditions) -> list[Finding]:
    """Return readings of the accelerometer noise of 3.2."""
    sensor, procedure = conditions.accelerometer, conditions.printed
    samples = procedure.sample_rate * procedure.accelerometer.dwell
    findings = []
    for reading in conditions.paper.noise_readings:
        u = value_of(sensor, NOISE.quantity)
        u /= STANDARD_GRAVITY if reading.in_si else 1.0
        u /= np.sqrt(samples) if reading.once_a_window else 1.0
        noisy = with_lines(sensor, sample_noise=float(u))
        found = expect(only_sources(noisy, procedure, NOISE), nominal_size(sensor))
        p = {name: _probabilities(printed, name, found) for name in printed.errors}
        fits = any(all(both[k] >= LEVEL for both in p.values()) for k in range(2))
        for parameter, order in printed.errors.items():
            ours = float(found.u[PLACES[parameter]].max())
            findings.append(
                Finding(
                    section="readings",
                    where=f"{printed.section}, sample noise, {words(parameter)}: "
                    f"{reading.name}",
                    printed=order,
                    ours=ours,
                    quantity=U_SINGLE,
                    ratio=ratio_of(ours, float(order)),
                    verdict=Verdict.READING_FITS if fits else Verdict.READING_FAILS,
                    why="all three orders must come out, as single runs or as means",
                    p_single=p[parameter][0],
                    p_mean=p[parameter][1],
                    is_summary=True,
                )
            )
    return findings


def _judge(
    printed: PrintedOrders, parameter: Parameter, found: Expectation, *, cause: str
) -> Finding:
    """Hold one order against what it should be; `cause` explains one that is not."""
    place, text = PLACES[parameter], printed.errors[parameter]
    order, unit = float(text), "" if printed.unit == "1" else f" {printed.unit}"
    single = mean = None
    quantity = VALUE
    if found.u[place].any():
        single, mean = _probabilities(printed, parameter, found)
        ours, quantity = float(found.u[place].max()), U_SINGLE
        verdict, why = (
            Verdict.AGREES_IN_ORDER,
            "p: of the largest entry having this order",
        )
        if max(single, mean) < LEVEL:
            verdict = Verdict.READING if cause else Verdict.UNEXPLAINED
            why += f"; {cause}" if cause else ""
    else:
        ours = float(np.abs(found.mean[place]).max())
        zero = float(found.resolution[place].max())
        if ours <= zero:
            ours, why = 0.0, "no effect"
            verdict = agrees_if(order <= zero)
            why += f"; {say(zero, 1)} is rounding here" if order else ""
        else:
            same = power_of_ten(ours) == power_of_ten(order)
            verdict = Verdict.AGREES_IN_ORDER if same else Verdict.EXPLAINED
            why = "not rounding, as the text has it: eq. (4)'s own error"
    return Finding(
        section="text",
        where=f"{printed.section}, {printed.sensor}, {printed.condition}, "
        f"{words(parameter)}",
        printed=f"{text}{unit}",
        ours=ours,
        quantity=quantity,
        ratio=ratio_of(ours, order),
        verdict=verdict,
        why=f"{printed.note}; {why}" if printed.note else why,
        p_single=single,
        p_mean=mean,
        is_summary=True,
    )


def _bound(conditions: Conditions) -> Finding:
    """Hold the one order that the text gives as a bound against the table beside it."""
    paper = conditions.paper
    entries = paper.table_1[STABILITY.quantity].scale_factor
    largest = max(entries, key=lambda text: abs(float(text)))
    beyond = abs(float(largest)) / float(paper.bound)
    as_order = power_of_ten(float(largest)) == power_of_ten(float(paper.bound))
    return Finding(
        section="text",
        where="3.1, gyro, bias stability, scale factor as a bound",
        printed=f"within {paper.bound}",
        ours=f"{largest} in Table 1",
        quantity=WORD,
        ratio=beyond,
        verdict=Verdict.EXPLAINED if as_order else Verdict.UNEXPLAINED,
        why=f"the table beside the text has an entry {say(beyond)} times that bound; "
        "as a power of ten, which is how the text reads all others, the two agree",
        is_summary=True,
    )


def _probabilities(
    printed: PrintedOrders, parameter: Parameter, found: Expectation
) -> tuple[float, float]:
    """Return the probability of the order in a single run and in a mean over 25."""
    single, mean = (
        order_probability(printed.errors[parameter], found, PLACES[parameter], runs=n)
        for n in (1, RUNS)
    )
    return single, mean
