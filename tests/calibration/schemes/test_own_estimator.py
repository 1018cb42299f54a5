"""An estimator that nobody knows yet: a row, a scheme, and its maker."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget import analyze, load_device, load_procedure
from budget.calibration import schemes
from budget.model import estimators
from budget.model.estimators import PLAIN, Estimator
from budget.model.scheme import Scheme
from budget.report.analysis.method import _weights

ZHAO = load_device("zhao-2019")
DAMPED = "damped"  # its name
STEPS = 60  # of its search, each of which halves what is wrong


@dataclass(frozen=True, kw_only=True, eq=False)
class DampedScheme(Scheme):
    """Least squares found step by step, as one that is not linear finds it."""

    weighed = DAMPED

    def read_errors(self, truth, epsilon):
        """Return the errors of least squares, by damped steps from none."""
        found = super().read_errors(truth, 0.0 * epsilon)
        wanted = super().read_errors(truth, epsilon)
        parts = {}
        for name in ("scale_factor", "mounting_angle", "bias"):
            at, end = getattr(found, name), getattr(wanted, name)
            for _ in range(STEPS):
                at = at + 0.5 * (end - at)
            parts[name] = at
        return replace(wanted, **parts)


@pytest.fixture
def procedure(monkeypatch):
    """Return positions and turns under an estimator that no shipped file has."""

    def make(owner, schedule, how, held, sensor):
        plain = schemes.SCHEMES[PLAIN](
            owner, schedule, replace(how, formulas=PLAIN), held, sensor
        )
        return DampedScheme(
            **{one.name: getattr(plain, one.name) for one in fields(plain)}
        )

    rows = (*estimators.ESTIMATORS, Estimator(name=DAMPED, says="step by step"))
    monkeypatch.setattr(estimators, "ESTIMATORS", rows)
    monkeypatch.setitem(schemes.SCHEMES, DAMPED, make)
    return replace(load_procedure("six-positions-and-turns"), formulas=DAMPED)


def test_an_estimator_is_a_row_a_scheme_and_its_maker(procedure):
    """It finds what least squares finds, and its weights are printed by its name."""
    plain = replace(procedure, formulas=PLAIN)
    found, wanted = (
        np.array(
            [
                row.standard_uncertainty
                for row in analyze(ZHAO, procedure=how, validate=False).outputs
            ]
        )
        for how in (procedure, plain)
    )

    assert_allclose(found, wanted, rtol=1e-9)
    scheme = schemes.scheme_of("gyro", procedure, ZHAO.gyro)
    assert isinstance(scheme, DampedScheme)
    assert _weights(scheme).kind == DAMPED
