"""Table 1: which reading of 'relative error' its 60 entries and their groups fit.

The biases of the mounting row follow from its angles. With eq. (4) as printed the bias
error is a function of the angles alone, linear but for 1e-4 of itself, so that the mean
bias error over any number of runs follows from the mean angles. The table does not say
in which order its six angles stand; of the 720 orders one returns all three printed
biases: that of the rows of dT in eq. (1). The rest tells runs from means: a mean of
products is not the product of means. About zero and with u = 2 arcsec, dT^T dT w adds
2 u^2 w to the bias of z in every run.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import BLOCK, draw
from budget.methods.gum import propagate
from budget.model.sources import GYRO
from budget.names import ANGLES, AXES, PARAMETERS, Name
from budget.sentences import sentence
from zhao_2019.conditions import (
    HALF_ULP,
    PLACES,
    nominal_size,
    only_sources,
    without_nominal_angles,
)
from zhao_2019.printed import (
    RUNS,
    U_MEAN,
    U_SINGLE,
    Agreement,
    Finding,
    agrees_if,
    say_number,
)
from zhao_2019.readings import (
    MOUNTING,
    SIX_DIGITS,
    STABILITY,
    WALK,
    as_stated,
    best_reading,
    two_sided,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.problem import Problem
    from zhao_2019.conditions import Conditions, Expectation
    from zhao_2019.readings import Reading

REPEATABILITIES = ("bias_repeatability", "scale_factor_repeatability")
BLOCKS = 10  # of trials drawn for repeats of a mean
REPEATS = BLOCKS * (BLOCK // RUNS)  # means that are drawn
HALF_DIGIT = 0.5e-5  # of a printed angle entry [1]
SIGMAS = 3.0  # standard uncertainties of the products that are allowed [1]


def stated_rows(conditions: Conditions) -> dict[str, Reading]:
    """Read each row as stated, as a single run: formulas of the paper, from nominal."""
    return {row: as_stated(conditions, row) for row in conditions.paper.table_1}


def table1_findings(
    conditions: Conditions, readings: tuple[Reading, ...]
) -> tuple[Finding, ...]:
    """Return, for each row, a summary of every random parameter and all 12 entries."""
    rows = stated_rows(conditions)
    findings = []
    for name, row in rows.items():
        other, drawn = best_reading(readings, row.source), drawn_means(conditions, row)
        for parameter in PLACES:
            if row.is_random(parameter):
                findings += _random_entries(conditions, row, parameter, other, drawn)
            else:
                findings += _fixed_entries(conditions, row, parameter)
        if name == STABILITY.quantity:
            findings.append(_left_on(conditions, rows, readings))
    return (
        *findings,
        _both_repeatabilities(conditions, rows),
        *_mounting_findings(conditions),
    )


def reading_findings(
    conditions: Conditions, readings: tuple[Reading, ...]
) -> tuple[Finding, ...]:
    """Return a row for each reading and parameter that varies under it."""
    findings = []
    for reading in readings:
        is_single = reading.runs == 1
        verdict = (
            Agreement.READING_FITS if reading.fits_row else Agreement.READING_FAILS
        )
        for parameter in filter(reading.is_random, PLACES):
            place, found = PLACES[parameter], reading.fit(parameter)
            # Where the reading has a mean, deviations from it are what is random.
            rms = root_mean_square((reading.printed - reading.expectation.mean)[place])
            shifted = root_mean_square(reading.expectation.mean[place]) > found.u_rms
            findings.append(
                conditions.paper.tell(
                    "reading of table 1",
                    ours=found.u_rms,
                    against=rms,
                    quantity=reading.quantity,
                    verdict=verdict,
                    p=(found.p, None) if is_single else (None, found.p),
                    reading=reading,
                    parameter=parameter,
                    about=sentence("paper_words.about") if shifted else "",
                    fit=found,
                    whole=reading.fit(),
                )
            )
    return tuple(findings)


def root_mean_square(values: Array) -> float:
    """Return the root mean square [1]."""
    return float(np.sqrt(np.mean(values**2)))


def spread_of_means(problem: Problem) -> Array:
    """Return the standard deviation of REPEATS means over 25 runs each.

    Shape (12,), of a Problem of one triad [SI].
    """
    x = np.empty((problem.n_inputs, BLOCK))
    each = BLOCK // RUNS
    means = []
    for block in range(BLOCKS):
        y = problem.evaluate(draw(problem, 0, block, x))[:, : each * RUNS]
        means.append(y.reshape(len(problem.outputs), each, RUNS).mean(axis=2))
    return np.asarray(np.concatenate(means, axis=1).std(axis=1, ddof=1))


def drawn_means(conditions: Conditions, row: Reading) -> Array:
    """Return the spread of means over 25 runs of a row as stated, shape (12,) [1]."""
    problem = only_sources(conditions.gyro, conditions.printed, row.source)
    return spread_of_means(problem) / nominal_size(conditions.gyro)


def _random_entries(
    conditions: Conditions,
    row: Reading,
    parameter: str,
    other: Reading | None,
    means: Array,
) -> list[Finding]:
    """Say which reading the entries of one parameter fit, together and one by one."""
    paper, place = conditions.paper, PLACES[parameter]
    single, mean = row.fit(parameter), row.of_mean.fit(parameter)
    chosen, verdict, cause = row, Agreement.UNEXPLAINED, ""
    if mean.fits and mean.p > single.p:
        chosen, verdict = row.of_mean, Agreement.FITS_MEAN
    elif single.fits:
        verdict = Agreement.FITS_SINGLE
    elif other is not None:
        p = other.fit(parameter).p
        verdict = Agreement.READING
        parts = {"reading": other.full_name, "p": say_number(p, 2)}
        cause = sentence("paper_words.fits", **parts)
        if row.source == MOUNTING:  # see _mounting_findings
            verdict = Agreement.EXPLAINED
            cause = sentence("paper_words.proven", **parts)
    u, u_rms = chosen.u[place], chosen.fit(parameter).u_rms
    rms = root_mean_square(row.printed[place])
    summary = paper.tell(
        "entries of table 1",
        ours=u_rms,
        against=rms,
        quantity=chosen.quantity,
        verdict=verdict,
        p=(single.p, mean.p),
        row=row,
        parameter=parameter,
        single=single,
        mean=mean,
        repeats=REPEATS,
        drawn=np.mean(means[place] / row.of_mean.u[place]),
        cause=cause,
    )
    entries = [
        paper.tell(
            "entry of table 1",
            "random",
            printed=text,
            ours=float(u[k]),
            quantity=chosen.quantity,
            verdict=verdict,
            p=(float(single.p_entries[k]), float(mean.p_entries[k])),
            row=row,
            parameter=parameter,
            name=name,
        )
        for k, (name, text) in enumerate(
            zip(PARAMETERS[parameter], row.texts[place], strict=True)
        )
    ]
    return [summary, *entries]


def _fixed_entries(
    conditions: Conditions, row: Reading, parameter: str
) -> list[Finding]:
    """Return entries that do not vary: zeros to rounding, and eq. (4)'s residual."""
    place, expected = PLACES[parameter], row.expectation
    findings = []
    for name, text, ours, zero in zip(
        PARAMETERS[parameter],
        row.texts[place],
        expected.mean[place].tolist(),
        expected.resolution[place].tolist(),
        strict=True,
    ):
        printed, is_zero = float(text), abs(ours) <= zero
        off = 0.0 if is_zero else ours / printed - 1.0
        agrees = abs(printed) <= zero if is_zero else abs(off) <= SIX_DIGITS
        case = "residual" if not is_zero else "rounding" if printed else "zero"
        findings.append(
            conditions.paper.tell(
                "entry of table 1",
                case,
                printed=text,
                ours=0.0 if is_zero else ours,
                verdict=agrees_if(agrees),
                row=row,
                parameter=parameter,
                name=name,
                steps=round(abs(printed) / HALF_ULP),
                off=off,
            )
        )
    return findings


def _both_repeatabilities(conditions: Conditions, rows: dict[str, Reading]) -> Finding:
    """Judge the two repeatability rows together: only so a single run is excluded."""

    def together(readings: list[Reading]) -> tuple[float, float]:
        fits = [reading.fit() for reading in readings]
        chi_square = sum(one.chi_square for one in fits)
        return chi_square, two_sided(chi_square, sum(one.entries for one in fits))

    single, p_single = together([rows[name] for name in REPEATABILITIES])
    mean, p_mean = together([rows[name].of_mean for name in REPEATABILITIES])
    # Printed over u: each row has three random entries with independent axes.
    rms = float(np.sqrt(single / 6.0))
    return conditions.paper.tell(
        "both repeatabilities",
        ours=float(1.0 / np.sqrt(RUNS)),
        against=rms,
        quantity=U_MEAN,
        verdict=Agreement.FITS_MEAN if p_mean > p_single else Agreement.FITS_SINGLE,
        p=(p_single, p_mean),
        single=single,
        mean=mean,
    )


def switched_on(conditions: Conditions) -> dict[tuple[Name, ...], Expectation]:
    """Expect one run with every choice of the five stated sources: 31 of them."""
    rows = list(conditions.paper.table_1)
    sources = [Name(row, owner=GYRO) for row in rows]
    return {
        chosen: as_stated(conditions, rows[0], chosen).expectation
        for n in range(1, len(sources) + 1)
        for chosen in combinations(sources, n)
    }


def fitting_choices(
    choices: dict[tuple[Name, ...], Expectation], stated: Reading
) -> tuple[Reading, ...]:
    """Return the choices of sources that fit a row, as one run or a mean over 25."""
    tried = (
        replace(stated, sources=chosen, expectation=expectation, runs=runs)
        for chosen, expectation in choices.items()
        for runs in (1, RUNS)
    )
    return tuple(reading for reading in tried if reading.fits_row)


def _left_on(
    conditions: Conditions, rows: dict[str, Reading], readings: tuple[Reading, ...]
) -> Finding:
    """Judge the stability row as a run whose random walk was left on, and the choice.

    No number is fitted, but a reading was looked for: how many were tried, how many
    of them fit, and how often one fits by chance, shown by the other rows, is said.
    """
    choices = switched_on(conditions)
    row, walk = (rows[source.quantity] for source in (STABILITY, WALK))
    single, mean = (
        r for r in readings if r.source == STABILITY and r.sources == (STABILITY, WALK)
    )
    of_single = single.fit()
    found = {name: fitting_choices(choices, r) for name, r in rows.items()}
    fitting = {r.sources: r for r in found.pop(STABILITY.quantity)}
    if any(WALK not in chosen or r.runs != 1 for chosen, r in fitting.items()):
        raise ValueError(
            "a run without the random walk fits: the reason given is wrong"
        )
    elsewhere = sum(r.sources != (r.source,) for fits in found.values() for r in fits)
    tried = 2 * len(choices)
    others = sum(r.source == STABILITY and r.sources == (STABILITY,) for r in readings)
    alone, norm = fitting[WALK,], np.linalg.norm
    # Of ratios of normal densities the powers of 2 pi cancel.
    odds = np.exp(_log_density(alone) - _log_density(single))
    times = [
        f"{norm(walk.expectation.u[place]) / norm(walk.printed[place]):.0f}"
        for place in PLACES.values()
    ]
    rms = float(np.sqrt(of_single.chi_square / of_single.entries))
    return conditions.paper.tell(
        "random walk left on",
        ours=1.0,
        against=rms,
        quantity=U_SINGLE,
        verdict=Agreement.READING,
        p=(of_single.p, mean.fit().p),
        single=of_single,
        stated=row.fit(),
        tried=tried + others,
        choices=len(choices),
        fitting=len(fitting),
        alone=alone.fit(),
        odds=odds,
        elsewhere=elsewhere,
        wrong=(len(rows) - 1) * (tried - 2),
        times=", ".join(times),
    )


def _log_density(reading: Reading) -> float:
    """Return the logarithm of the normal density of twelve entries, less a constant."""
    u = reading.expectation.u
    # Scaled first: scale factors and angles differ by a factor of 1e5.
    _, log_det = np.linalg.slogdet(reading.expectation.covariance / np.outer(u, u))
    return -0.5 * float(reading.fit().chi_square + log_det) - float(np.log(u).sum())


@dataclass(frozen=True, kw_only=True, eq=False)
class BiasesFromAngles:
    """What the printed angles make of the biases."""

    order: tuple[str, ...]  # the order of the printed angles that fits best
    bias: Array  # relative bias errors from the angles in that order, shape (3,) [1]
    # Part of `bias` that products of angles add in a mean over 25 runs, shape (3,) [1].
    products: Array
    u_products: Array  # standard uncertainty of that part, shape (3,) [1]
    # What the rounding of the printed angles may change, shape (3,) [1].
    rounding: Array
    # Largest deviation from a printed bias over its tolerance, of that order and of the
    # next best one [1].
    misfit: float
    next_misfit: float

    @property
    def tolerance(self) -> Array:
        """What is allowed between printed and ours, shape (3,) [1]."""
        return self.rounding + SIGMAS * self.u_products


def biases_from_angles(conditions: Conditions) -> BiasesFromAngles:
    """Feed the printed angle errors to the calibration, in every order."""
    row, place = conditions.paper.table_1[MOUNTING.quantity], PLACES["bias"]
    gyro, procedure = conditions.gyro, conditions.printed
    size = nominal_size(gyro)
    problem = only_sources(gyro, procedure, MOUNTING)
    orders = list(permutations(ANGLES))
    printed = np.array([float(text) for text in row.mounting_angle])
    angles = np.stack(
        [printed[[order.index(name) for name in ANGLES]] for order in orders], axis=1
    )

    def bias(relative: Array) -> Array:
        error = problem.evaluate(relative * size[PLACES["mounting_angle"], None])
        return np.asarray((error / size[:, None])[place])

    # Angles drawn about 0: their mean is the printed error plus 1, in 2 arcsec.
    law = propagate(only_sources(without_nominal_angles(gyro), procedure, MOUNTING))
    second_order = np.diag(law.covariance - law.first_order)[place]
    products = (law.mean / size)[place] * (1.0 - 1.0 / RUNS)
    u_products = np.sqrt(second_order / RUNS) / size[place]
    steps = bias(HALF_DIGIT * np.eye(6)) - bias(np.zeros((6, 1)))
    rounding = np.abs(steps).sum(axis=1)
    found = bias(angles) + products[:, None]
    wanted = np.array([float(text) for text in row.bias])
    tolerance = rounding + SIGMAS * u_products
    misfits = np.abs((found - wanted[:, None]) / tolerance[:, None]).max(axis=0)
    best, second = np.argsort(misfits)[:2]
    return BiasesFromAngles(
        order=orders[best],
        bias=found[:, best],
        products=products,
        u_products=u_products,
        rounding=rounding,
        misfit=float(misfits[best]),
        next_misfit=float(misfits[second]),
    )


def _mounting_findings(conditions: Conditions) -> tuple[Finding, ...]:
    """Return the order of the angles, and the biases that follow from them.

    The last tells by the products in the bias of z whether the row is a run or a mean.
    """
    found, paper = biases_from_angles(conditions), conditions.paper
    texts = paper.table_1[MOUNTING.quantity].bias
    order = paper.tell(
        "order of the angles",
        ours=" ".join(found.order),
        verdict=agrees_if(found.order == paper.angle_order),
        found=found,
    )
    biases = [
        paper.tell(
            "bias from its angles",
            printed=text,
            ours=ours,
            verdict=agrees_if(abs(ours - float(text)) <= tolerance),
            axis=axis,
            tolerance=tolerance,
        )
        for axis, text, ours, tolerance in zip(
            AXES, texts, found.bias.tolist(), found.tolerance.tolist(), strict=True
        )
    ]
    ours, u = float(found.products[2]), float(found.u_products[2])
    rest, slack = float(texts[2]) - float(found.bias[2]) + ours, found.rounding[2]
    is_mean = abs(rest - ours) <= slack + SIGMAS * u and abs(rest) > slack
    products = paper.tell(
        "bias beyond its angles",
        ours=ours,
        against=rest,
        verdict=Agreement.FITS_MEAN if is_mean else Agreement.UNEXPLAINED,
        u=u,
        slack=slack,
    )
    return order, *biases, products
