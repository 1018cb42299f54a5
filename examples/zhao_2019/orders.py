"""Orders of magnitude: of the text, gyro (3.1), accelerometer (3.2), and of figures.

The text takes for the order of some entries the power of ten of the largest: beside
Table 1 it says 0.001 for -0.00296, -0.0063, -0.00577, and 1e-9 for 7.3213e-9.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, floor, log10, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.documents import written
from budget.earth import ROTATION_RATE
from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import PARAMETERS, Name
from budget.sentences import sentence
from budget.units import STANDARD_GRAVITY
from zhao_2019.conditions import (
    HALF_ULP,
    PLACES,
    Expectation,
    expect,
    nominal_size,
    only_sources,
    value_of,
    with_lines,
)
from zhao_2019.printed import (
    RUNS,
    U_SINGLE,
    UNITS,
    VALUE,
    Agreement,
    Finding,
    agrees_if,
    say_number,
)
from zhao_2019.readings import (
    LEVEL,
    STABILITY,
    best_reading,
    order_probability,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from zhao_2019.conditions import Conditions
    from zhao_2019.printed import PrintedFigure, PrintedOrders
    from zhao_2019.readings import Reading

NOISE = Name("sample_noise", owner=ACCELEROMETER)
PROPORTIONAL = 1e-4  # deviation from a straight line over the largest value [1]


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
            fitting = [r.where for r in of_noise if r.verdict == Agreement.READING_FITS]
            names = dict.fromkeys(where.partition(": ")[2] for where in fitting)
            if names:
                cause = sentence("paper_words.all_orders", names=tuple(names))
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
                cause = sentence(
                    "paper_words.order", reading=other.full_name, p=say_number(p)
                )
            found.append(_judge(conditions, printed, parameter, expected, cause=cause))
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
            findings.append(
                conditions.paper.tell(
                    "reading of the noise",
                    printed=order,
                    ours=float(found.u[PLACES[parameter]].max()),
                    quantity=U_SINGLE,
                    verdict=Agreement.READING_FITS if fits else Agreement.READING_FAILS,
                    p=p[parameter],
                    orders=printed,
                    parameter=parameter,
                    reading=reading,
                )
            )
    return findings


def _judge(
    conditions: Conditions,
    printed: PrintedOrders,
    parameter: str,
    found: Expectation,
    *,
    cause: str,
) -> Finding:
    """Hold one order against what it should be; `cause` explains one that is not."""
    place, text = PLACES[parameter], printed.errors[parameter]
    order, unit = float(text), "" if printed.unit == "1" else f" {printed.unit}"
    ours = float(np.abs(found.mean[place]).max())
    zero = float(found.resolution[place].max())
    quantity, p = VALUE, None
    if found.u[place].any():
        p = _probabilities(printed, parameter, found)
        ours, quantity = float(found.u[place].max()), U_SINGLE
        case, verdict = "random", Agreement.AGREES_IN_ORDER
        if max(p) >= LEVEL:
            cause = ""
        else:
            verdict = Agreement.READING if cause else Agreement.UNEXPLAINED
    elif ours <= zero:
        ours, case = 0.0, "rounding" if order else "zero"
        verdict = agrees_if(order <= zero)
    else:
        case = "fixed"
        same = power_of_ten(ours) == power_of_ten(order)
        verdict = Agreement.AGREES_IN_ORDER if same else Agreement.EXPLAINED
    return conditions.paper.tell(
        "order of the text",
        case,
        printed=f"{text}{unit}",
        ours=ours,
        against=order,
        quantity=quantity,
        verdict=verdict,
        p=p or (None, None),
        orders=printed,
        parameter=parameter,
        zero=zero,
        note=sentence("paper_words.remark", text=printed.note) if printed.note else "",
        cause=sentence("paper_words.cause", text=cause) if cause else "",
    )


def _bound(conditions: Conditions) -> Finding:
    """Hold the one order that the text gives as a bound against the table beside it."""
    paper = conditions.paper
    entries = paper.table_1[STABILITY.quantity].scale_factor
    largest = max(entries, key=lambda text: abs(float(text)))
    beyond = abs(float(largest)) / float(paper.bound)
    as_order = power_of_ten(float(largest)) == power_of_ten(float(paper.bound))
    return paper.tell(
        "bound of the text",
        ours=sentence("paper_words.largest", text=largest),
        ratio=beyond,
        verdict=Agreement.EXPLAINED if as_order else Agreement.UNEXPLAINED,
        bound=paper.bound,
        beyond=beyond,
    )


def _probabilities(
    printed: PrintedOrders, parameter: str, found: Expectation
) -> tuple[float, float]:
    """Return the probability of the order in a single run and in a mean over 25."""
    single, mean = (
        order_probability(printed.errors[parameter], found, PLACES[parameter], runs=n)
        for n in (1, RUNS)
    )
    return single, mean


@written(
    "sweep",
    """
    figure: of the paper
    source
    parameter = given.parameter (str)
    size (list[float]) [1]: of the step
    errors (Mapping[str, list[float]]) [1]: relative, by axis or angle
    """,
    errors=lambda one: dict(zip(one.names, one.errors, strict=True)),
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """One of the four figures, computed: relative errors against the step."""

    # 'figure 3', 'gyro.scale_factor_asymmetry'.
    figure: str
    source: Name
    given: PrintedFigure  # what is stepped, and what the paper reads off its figure
    size: Array  # nonlinearity or asymmetry at i = 1 to 25, shape (25,) [1]
    errors: Array  # relative errors of the axes or angles, shape (n, 25) [1]
    slopes: Array  # closed form of d error / d size, shape (n,) [1]

    @property
    def names(self) -> tuple[str, ...]:
        """Axes or angles, length n."""
        return PARAMETERS[self.given.parameter]

    @property
    def largest(self) -> float:
        """Largest absolute error [1]."""
        return float(np.abs(self.errors).max())

    @property
    def fitted_slopes(self) -> Array:
        """Rise from i = 1 to i = 25 over the step, shape (n,) [1]."""
        rise = self.errors[:, -1] - self.errors[:, 0]
        return np.asarray(rise / (self.size[-1] - self.size[0]))

    @property
    def deviation(self) -> float:
        """Largest deviation from the straight line through both ends, relative [1]."""
        line = self.errors[:, [0]] + self.fitted_slopes[:, None] * (
            self.size - self.size[0]
        )
        return float(np.abs(self.errors - line).max() / self.largest)


def compute_sweeps(conditions: Conditions) -> tuple[Sweep, ...]:
    """Calibrate error-free but for the step, 25 times: formulas of the paper."""
    nominal = nominal_size(conditions.gyro)
    rising = _asymmetry_slopes(conditions)
    sweeps = []
    for figure, given in conditions.paper.figures.items():
        place, source = PLACES[given.parameter], Name(given.source, owner=GYRO)
        problem = only_sources(conditions.gyro, conditions.printed, source)
        size = given.step * np.arange(1.0, RUNS + 1.0)
        errors = problem.evaluate(np.tile(size, (3, 1))) / nominal[:, None]
        rises = source.quantity == "scale_factor_asymmetry"
        sweeps.append(
            Sweep(
                figure=figure,
                source=source,
                given=given,
                size=size,
                errors=errors[place],
                slopes=rising[place] * rises,
            )
        )
    return tuple(sweeps)


def power_of_ten(value: float) -> int:
    """Return k with 10^k <= |value| < 10^(k+1)."""
    return floor(log10(abs(value)))


def _asymmetry_slopes(conditions: Conditions) -> Array:
    """Return d(relative error)/dKa of the twelve parameters, shape (12,) [1].

    With G = T/(4 pi n) each row of the response takes up G Ka b off its diagonal and
    G Ka (b + e) on it, e = (0, w cos L, w sin L). Hence for an angle s G b / d0, s its
    sign in dT, and by eq. (4) for the biases -(b + w_i) G (b + e_i) + sum over k != i
    of G b (b + w_k), over b; w = (0, 0, w sin L). Terms in dT are left out, 1e-5.
    """
    gyro, procedure = conditions.gyro, conditions.printed
    b = float(gyro.nominal_bias[0])
    d0 = float(gyro.nominal_mounting_angle[0])
    gain = 1.0 / (2.0 * procedure.gyro.rate)  # T / (4 pi n)
    vertical = ROTATION_RATE * sin(procedure.latitude)
    e = np.array([0.0, ROTATION_RATE * cos(procedure.latitude), vertical])
    v = b + np.array([0.0, 0.0, vertical])
    sign = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])
    bias = gain * (b * (v.sum() - v) - v * (b + e)) / b
    return np.concatenate([gain * (b + e), sign * gain * b / d0, bias])


def sweep_findings(
    sweeps: tuple[Sweep, ...], conditions: Conditions
) -> tuple[Finding, ...]:
    """Return the order of each figure, and the slopes of those that rise."""
    tell = conditions.paper.tell
    findings: list[Finding] = []
    for sweep in sweeps:
        order, ours = float(sweep.given.order), sweep.largest
        verdict, case = Agreement.AGREES_IN_ORDER, "same order"
        if not ours:
            verdict, case = Agreement.AGREES, "zero"
        elif power_of_ten(ours) != power_of_ten(order):
            verdict, case = Agreement.UNEXPLAINED, "other order"
        elif not sweep.slopes.any():
            case = "level"
        findings.append(
            tell(
                "order of a figure",
                case,
                printed=sweep.given.order,
                ours=ours,
                verdict=verdict,
                sweep=sweep,
                steps=order / HALF_ULP,
                times=order / ours if ours else 0.0,
            )
        )
        if sweep.slopes.any():
            findings += (
                tell(
                    "slope of a figure",
                    ours=float(found),
                    verdict=agrees_if(sweep.deviation <= PROPORTIONAL),
                    sweep=sweep,
                    name=name,
                    closed=closed,
                )
                for name, found, closed in zip(
                    sweep.names, sweep.fitted_slopes, sweep.slopes, strict=True
                )
            )
    # Readings of figure 3: by what each would multiply our errors.
    third, bias = sweeps[2], float(np.abs(conditions.gyro.nominal_bias[0]))
    factors = (
        100.0,  # per cent
        1200.0 / 18.0,  # time of the dwells over that of a turn
        1.0 + ROTATION_RATE / bias,
    )
    readings = (
        tell(
            "reading of a figure",
            printed=third.given.order,
            ours=factor * third.largest,
            verdict=Agreement.READING_FAILS,
            sweep=third,
            name=name,
            why=why,
        )
        for factor, (name, why) in zip(
            factors, conditions.paper.figure_3.items(), strict=True
        )
    )
    return (*findings, *readings)
