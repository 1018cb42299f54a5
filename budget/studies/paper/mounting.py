"""Biases of the mounting row of Table 1 from its angles: their order, run or mean.

With eq. (4) as printed the bias error is a function of the angles alone, linear but for
1e-4 of itself, so that the mean bias error over any number of runs follows from the
mean angles. The table does not say in which order its six angles stand; of the 720
orders one returns all three printed biases: that of the rows of dT in eq. (1).

The rest tells runs from means: a mean of products is not the product of means. About
zero and with u = 2 arcsec, dT^T dT w adds 2 u^2 w to the bias of z in every run.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.gum import propagate
from budget.names import ANGLES, AXES
from budget.studies.paper.conditions import (
    PLACES,
    nominal_size,
    only_sources,
    without_nominal_angles,
)
from budget.studies.paper.findings import (
    RUNS,
    WORD,
    Finding,
    Verdict,
    agrees_if,
    ratio_of,
    say,
)
from budget.studies.paper.readings import MOUNTING

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.studies.paper.conditions import Conditions

HALF_DIGIT = 0.5e-5  # of a printed angle entry [1]
SIGMAS = 3.0  # standard uncertainties of the products that are allowed [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class BiasesFromAngles:
    """What the printed angles make of the biases.

    Attributes
    ----------
    order : tuple of str
        The order of the printed angles that fits best.
    bias : ndarray, shape (3,)
        Relative bias errors from the angles in that order [1].
    products : ndarray, shape (3,)
        Part of `bias` that products of angles add in a mean over 25 runs [1].
    u_products : ndarray, shape (3,)
        Standard uncertainty of that part [1].
    rounding : ndarray, shape (3,)
        What the rounding of the printed angles may change [1].
    misfit, next_misfit : float
        Largest deviation from a printed bias over its tolerance, of that order and of
        the next best one [1].
    """

    order: tuple[str, ...]
    bias: Array
    products: Array
    u_products: Array
    rounding: Array
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


def mounting_findings(conditions: Conditions) -> tuple[Finding, ...]:
    """Return the order of the angles, and the biases that follow from them.

    The last tells by the products in the bias of z whether the row is a run or a mean.
    """
    found, paper = biases_from_angles(conditions), conditions.paper
    texts = paper.table_1[MOUNTING.quantity].bias
    order = Finding(
        section="table 1",
        where="Table 1, order of the six angles",
        printed="not said",
        ours=" ".join(found.order),
        quantity=WORD,
        verdict=agrees_if(found.order == paper.angle_order),
        why="of 720 orders the only one that returns the printed biases of the "
        f"mounting row by eq. (4): off by {say(found.misfit, 2)} of what rounding "
        f"allows, the next order by {found.next_misfit:.0f}",
        is_summary=True,
    )
    biases = [
        Finding(
            section="table 1",
            where=f"Table 1, mounting repeatability, bias {axis} from its angles",
            printed=text,
            ours=ours,
            ratio=ratio_of(ours, float(text)),
            verdict=agrees_if(abs(ours - float(text)) <= tolerance),
            why="eq. (4) at the six printed angles, whose rounding and whose "
            f"products allow {say(tolerance, 1)}: the formula makes this error, "
            "not the sensor",
            is_summary=True,
        )
        for axis, text, ours, tolerance in zip(
            AXES, texts, found.bias.tolist(), found.tolerance.tolist(), strict=True
        )
    ]
    ours, u = float(found.products[2]), float(found.u_products[2])
    rest, slack = float(texts[2]) - float(found.bias[2]) + ours, found.rounding[2]
    is_mean = abs(rest - ours) <= slack + SIGMAS * u and abs(rest) > slack
    products = Finding(
        section="table 1",
        where="Table 1, mounting repeatability, bias z beyond its mean angles",
        printed=f"{say(rest, 3)}",
        ours=ours,
        ratio=ratio_of(ours, rest),
        verdict=Verdict.FITS_MEAN if is_mean else Verdict.UNEXPLAINED,
        why=f"mean of dT^T dT w over {RUNS} draws of 2 arcsec about zero, u "
        f"{say(u, 1)}; a single run would leave 0, give or take {say(slack, 1)} of "
        "rounding",
        is_summary=True,
    )
    return order, *biases, products
