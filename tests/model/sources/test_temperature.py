"""Coefficients of temperature: their signs, as makers print them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from builders import line
from numpy.testing import assert_allclose
from places import put

import budget
from budget.units import MICRO_G


@pytest.mark.parametrize(("sign", "bias"), [(1.0, 8.32457 - 1.6717), (-1.0, 9.99627)])
def test_the_sign_of_a_coefficient_counts_beside_another(tmp_path, sign, bias):
    """One ramp of 1 degC/h moves bias and scale factor: -8.325 and 1.672 ug of z."""
    path = put(
        tmp_path / "warm.yaml",
        "name: warm\naccelerometer:\n"
        "  nominal: {bias: 6 mg, mounting_angle: 2 arcsec}\n"
        f"  errors:\n    bias_temperature_coefficient: {sign * 10.0} ug/degC\n"
        "    scale_factor_temperature_coefficient: 100 ppm/degC\n",
    )
    how = replace(
        budget.load_procedure(), environment=(line("temperature.ramp", [1.0 / 3600.0]),)
    )
    found = budget.analyze(budget.load_device(path), procedure=how, validate=False)
    row = next(x for x in found.outputs if x.output.name == "accelerometer.bias.z")
    assert_allclose(row.standard_uncertainty / MICRO_G, bias, rtol=1e-4)
