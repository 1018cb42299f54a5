"""The library as the README shows it: load, analyze, table, covariance."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from contextlib import redirect_stdout
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from command_line import analyze
from numpy.testing import assert_allclose
from places import ROOT

import budget
from budget.units import DEG_PER_HOUR

README = ROOT / "README.md"
COLUMNS = [
    *("sensor", "parameter", "axis", "unit", "source"),
    *("standard_uncertainty", "share", "mean", "interval_low", "interval_high"),
    "interval_by",
    "lower_bound",
]


@pytest.fixture(scope="module")
def result():
    """Provide the budget of the paper's device."""
    return budget.analyze(budget.load_device("zhao-2019"), validate=False)


@pytest.mark.smoke
def test_the_lines_of_the_readme_run():
    """The README's five lines run as printed: 24 totals and the joint covariance."""
    text = README.read_text(encoding="utf-8")
    (block,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    code = [line for line in block.splitlines() if line and line != "import budget"]
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(block, README.name, "exec"), {})  # noqa: S102 - as a reader would

    assert len(code) <= 5
    lines = out.getvalue().splitlines()
    assert sum(" total " in line for line in lines) == 24
    assert lines[-1] == "(24, 24)"


def test_frame_is_tidy(result):
    """One row for each output and source and one total, one fact in each column."""
    table = result.to_frame()

    assert list(table.columns) == COLUMNS
    key = ["sensor", "parameter", "axis", "source"]
    assert not table.duplicated(key).any()
    assert len(table) == 24 * 7  # five sources, interaction, total
    totals = table[table["source"] == "total"]
    assert not totals.isna().any(axis=None)
    causes = table[table["source"] != "total"]
    assert causes[["mean", "interval_low", "interval_high"]].isna().all(axis=None)


def test_frame_is_in_printed_units(result):
    """The table prints deg/h where the records hold rad/s."""
    table = result.to_frame().set_index(["sensor", "parameter", "axis", "source"])
    row = table.loc[("gyro", "bias", "x", "total")]

    assert row["unit"] == "deg/h"
    u = result.output("gyro.bias.x").standard_uncertainty
    assert_allclose(row["standard_uncertainty"] * DEG_PER_HOUR, u, rtol=1e-12)


def test_covariance_is_joint(result):
    """Scale factor and bias of gyro x are correlated, gyro and accelerometer not."""
    correlation = result.correlation
    names = [row.output.name for row in result.outputs]
    i, j = names.index("gyro.scale_factor.x"), names.index("gyro.bias.x")

    assert result.covariance.shape == (24, 24)
    assert_allclose(np.diag(correlation), 1.0, rtol=1e-12)
    assert abs(correlation[i, j]) > 1e-6  # bias stability reaches both
    assert np.all(result.covariance[:12, 12:] == 0.0)


def test_records_are_frozen(result):
    """Nothing in a result can be assigned to."""
    for record, name in (
        (result, "outputs"),
        (result.settings, "seed"),
        (result.outputs[0], "mean"),
        (result.outputs[0].contributions[0], "share"),
    ):
        with pytest.raises(FrozenInstanceError):
            setattr(record, name, None)


def test_unknown_output_is_an_error(result):
    """An output that there is not is a KeyError, not an empty answer."""
    with pytest.raises(KeyError, match=r"gyro\.bias\.w"):
        result.output("gyro.bias.w")


def test_document_is_what_the_command_prints(result):
    """`to_dict()` and the command line's JSON are one document."""
    assert json.loads(json.dumps(result.to_dict())) == analyze("zhao-2019")


def test_errors_are_of_one_family():
    """Whatever is wrong with a call or a file, one class catches it."""
    device = budget.load_device("zhao-2019")
    with pytest.raises(budget.BudgetError, match="both have a gyro"):
        budget.analyze(device, device)
    with pytest.raises(budget.BudgetError, match="allowed: gum"):
        budget.analyze(device, method="linear")
    with pytest.raises(budget.SpecError, match="no such file"):
        budget.load_device("absent.yaml")


def test_public_names_are_there():
    """Every name in `__all__` can be had, and an unknown one is an AttributeError."""
    for name in budget.__all__:
        assert getattr(budget, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'analyse'"):
        _ = budget.analyse


def test_import_is_cheap(tmp_path):
    """Importing the package imports no numpy."""
    code = "import sys, budget; print('numpy' in sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )

    assert run.stdout == "False\n"
