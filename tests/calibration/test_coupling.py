"""The paper's conclusions as a coupling table, entry by entry, by three methods."""

from __future__ import annotations

import numpy as np
import pytest
from builders import paper_accelerometer, paper_gyro, procedure

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample

# Scale factors, angles, bias; own: the parameter's own spread.
TABLE = {
    "gyro.bias_repeatability": ("0", "0", "own"),
    "gyro.bias_stability": ("yes", "yes", "own"),
    "gyro.angle_random_walk": ("yes", "yes", "yes"),
    "gyro.rate_random_walk": ("yes", "yes", "yes"),
    "gyro.scale_factor_repeatability": ("own", "0", "0"),
    "gyro.scale_factor_nonlinearity": ("own", "0", "0"),
    "gyro.scale_factor_asymmetry": ("yes", "yes", "yes"),
    "gyro.mounting_repeatability": ("0", "own", "formula"),
    "accelerometer.bias_repeatability": ("0", "0", "own"),
    "accelerometer.bias_stability": ("yes", "yes", "own"),
    "accelerometer.sample_noise": ("yes", "yes", "yes"),
    "accelerometer.velocity_random_walk": ("yes", "yes", "yes"),
    "accelerometer.acceleration_random_walk": ("yes", "yes", "yes"),
    "accelerometer.scale_factor_repeatability": ("own", "0", "0"),
    "accelerometer.scale_factor_nonlinearity": ("own", "0", "0"),
    "accelerometer.mounting_repeatability": ("0", "own", "0"),
}
SENSORS = {
    "gyro": paper_gyro(
        rate_random_walk=1e-10,
        scale_factor_nonlinearity=30e-6,
        scale_factor_asymmetry=1250e-6,
    ),
    "accelerometer": paper_accelerometer(
        velocity_random_walk=1e-5,
        acceleration_random_walk=1e-6,
        scale_factor_nonlinearity=30e-6,
    ),
}
OWN = {"bias": 2, "mounting": 1, "scale": 0}
RELATIVE_ZERO = 1e-14


def spread(method, source, formulas):
    """Return the standard deviation of each output over its natural size, shape (12,).

    That size is 1 of a scale factor, 1 rad of an angle, the nominal bias of a bias.
    """
    sensor = SENSORS[source.split(".")[0]]
    how = procedure(formulas=formulas)
    if method == "simulation":
        how = procedure(formulas=formulas, sample_rate=10.0, dwell=20.0)
        runs = [
            simulate((sensor,), how, run=r, only=frozenset({source})) for r in range(4)
        ]
        u = np.std(runs, axis=0)
    else:
        # Asymmetry must stay among the sources where it is not asked for.
        problem = calibration_problem((sensor,), how, only=frozenset({source}))
        result = propagate(problem) if method == "gum" else sample(problem, trials=4096)
        u = result.standard_uncertainty
    return u / np.repeat([1.0, 1.0, sensor.nominal_bias[0]], [3, 6, 3])


@pytest.mark.parametrize("formulas", ["corrected", "paper"])
@pytest.mark.parametrize("method", ["gum", "monte-carlo", "simulation"])
@pytest.mark.parametrize("source", TABLE)
def test_coupling(source, method, formulas):
    """A source reaches exactly the parameter groups that the table says."""
    u = spread(method, source, formulas)
    # The simulation subtracts pulses: it has the rounding of the parameters, times
    # the lever of a bias beside gravity.
    zero = RELATIVE_ZERO * (100.0 if method == "simulation" else 1.0)
    for group, verdict in zip((u[:3], u[3:9], u[9:]), TABLE[source], strict=True):
        if verdict == "0" or (verdict == "formula" and formulas == "corrected"):
            assert group.max() < zero
        else:
            assert group.min() > 10.0 * zero


def test_own_entries_are_the_sources_own_size():
    """An entry 'own' equals the datasheet line itself, to second order."""
    for source, row in TABLE.items():
        kind, name = source.split(".")
        line = SENSORS[kind].line(name)
        if "own" not in row or name == "bias_stability":
            continue
        place = row.index("own")
        u = propagate(
            calibration_problem((SENSORS[kind],), procedure(), only=frozenset({source}))
        ).standard_uncertainty
        group = (u[:3], u[3:9], u[9:])[place]
        np.testing.assert_allclose(group, line.u, rtol=1e-6)
