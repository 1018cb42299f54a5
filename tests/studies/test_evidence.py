"""The coupling study: what reaches what, how far, and that none is told from some."""

from __future__ import annotations

import numpy as np
import pytest
from builders import asked, paper_accelerometer, paper_gyro, procedure, sensor
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.model.sources import source_of
from budget.studies.evidence import coupling

GYRO = paper_gyro(scale_factor_nonlinearity=30e-6, scale_factor_asymmetry=1250e-6)
ACCELEROMETER = paper_accelerometer(scale_factor_nonlinearity=30e-6)

# Scale factors, angles, bias; by the corrected formulas.
REACHES = {
    "gyro.bias_repeatability": (False, False, True),
    "gyro.bias_stability": (True, True, True),
    "gyro.angle_random_walk": (True, True, True),
    "gyro.scale_factor_repeatability": (True, False, False),
    "gyro.scale_factor_nonlinearity": (True, False, False),
    "gyro.scale_factor_asymmetry": (True, True, True),
    "gyro.mounting_repeatability": (False, True, False),
    "accelerometer.bias_repeatability": (False, False, True),
    "accelerometer.bias_stability": (True, True, True),
    "accelerometer.sample_noise": (True, True, True),
    "accelerometer.scale_factor_repeatability": (True, False, False),
    "accelerometer.scale_factor_nonlinearity": (True, False, False),
    "accelerometer.mounting_repeatability": (False, True, False),
}
PARAMETERS = ("scale_factor", "mounting_angle", "bias")


def found(*sensors, plan=None):
    """Return the table of these triads."""
    return coupling(asked(*sensors, procedure=plan or procedure()))


def reached(table):
    """Return the table as {source: (scale factors, angles, bias)}."""
    return {
        source: tuple(
            table.cell(source, f"{source.split('.')[0]}.{parameter}").reaches
            for parameter in PARAMETERS
        )
        for source in table.sources
    }


def test_study_finds_the_coupling_table():
    """Both sensors at once, a source reaches what it should."""
    assert reached(found(GYRO, ACCELEROMETER)) == REACHES


def test_paper_formula_couples_mounting_to_the_gyro_bias():
    """Eq. (4) as printed changes one cell of the table and no other."""
    table = found(GYRO, ACCELEROMETER, plan=procedure(formulas="paper"))
    expected = {**REACHES, "gyro.mounting_repeatability": (False, True, True)}
    assert reached(table) == expected


def test_own_constants_have_the_size_of_their_line():
    """Where a random constant is the parameter's own, u is the data sheet's figure."""
    table = found(GYRO, ACCELEROMETER)
    own = [
        cell
        for cell in table.cells
        if cell.is_own
        and not source_of(cell.source.owner, cell.source.quantity).process
    ]
    assert len(own) == 8
    for cell in own:
        kind, name = cell.source.split(".")
        u = {"gyro": GYRO, "accelerometer": ACCELEROMETER}[kind].line(name).u
        assert_allclose(cell.u, u.max(), rtol=1e-9)


def test_sizes_of_a_group_with_equal_axes_are_parts_of_one_whole():
    """Squares of the sizes in a column sum to 1 where all axes are alike."""
    table = found(GYRO)
    for parameter in ("scale_factor", "bias"):
        column = [c.size for c in table.cells if c.group == f"gyro.{parameter}"]
        # Asymmetry, 1e-3 of the rest, differs by axis through the earth rate.
        assert_allclose(sum(size**2 for size in column), 1.0, rtol=1e-4)


def test_a_spread_at_the_resolution_is_none():
    """A bias that repeats to 1e-20 deg/h is not said to reach the bias."""
    still = sensor("gyro", {"bias_repeatability": 1e-26})
    loud = sensor("gyro", {"bias_repeatability": 1e-12})
    for one, reaches in ((still, False), (loud, True)):
        cell = found(one).cell("gyro.bias_repeatability", "gyro.bias")
        assert cell.reaches is reaches
        assert (cell.size > 0.0) is reaches


def test_sources_and_groups_of_two_sensors_share_no_cell():
    """A gyro source has no cell beside an accelerometer parameter."""
    table = found(GYRO, ACCELEROMETER)
    with pytest.raises(KeyError):
        table.cell("gyro.bias_repeatability", "accelerometer.bias")


# ---- the paper's conclusions, entry by entry, each source alone ----------------------

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
