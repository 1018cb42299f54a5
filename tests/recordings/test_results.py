"""Two calibrations side by side: what moved, and the mistake it is the size of."""

from __future__ import annotations

import json

import numpy as np
import pytest
from calibration.test_mistakes import MEMS
from command_line import call
from numpy.testing import assert_allclose
from scipy.stats import chi2, norm

from budget.errors import CallError, SpecError
from budget.inputs import load_device, load_procedure
from budget.recordings.lot import lot_of
from budget.recordings.results import change_between, is_result, read_result

SIX = "six-positions-and-turns"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Provide results: of a unit, of it once more, with a mistake, of another unit."""
    found = tmp_path_factory.mktemp("results")
    (found / "mems.yaml").write_text(json.dumps(MEMS), encoding="utf-8")
    device = str(found / "mems.yaml")
    for name, seed, more in (
        ("a", "4", ()),
        ("turned", "4", ("--blunder", "turn_sense")),
        ("earth", "4", ("--blunder", "earth_rate_sign")),
        ("other", "5", ()),
    ):
        run, result = (str(found / f"{name}.{kind}") for kind in ("csv", "json"))
        words = ("simulate", device, "--procedure", SIX, "--means", "--rate", "20")
        assert call(*words, "--seed", seed, *more, "-o", run).code == 0
        words = ("calibrate", run, "--procedure", SIX, "--device", device)
        assert call(*words, "--json", result).code in {0, 1}
    return found


def change(folder, first, second, procedure=SIX):
    """Hold two of them beside each other."""
    how = None if procedure is None else load_procedure(procedure)
    sides = (read_result(folder / f"{one}.json") for one in (first, second))
    return change_between(*sides, how)


def test_a_result_is_read_as_it_was_written(folder):
    """Values, units and covariance of the document."""
    found = read_result(folder / "a.json")
    document = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert is_result(folder / "a.json")
    assert found.values.tolist() == [one["value"] for one in document["outputs"]]
    u = [one["standard_uncertainty"] for one in document["outputs"]]
    assert_allclose(np.sqrt(np.diag(found.covariance)), u, rtol=1e-12)


def test_another_unit_has_moved_and_the_same_has_not(folder):
    """By z of the difference, with p below 5 % over all."""
    assert not change(folder, "a", "a").moved
    found = change(folder, "a", "other")
    assert len(found.moved) > 10
    one = found.moved[0]
    assert_allclose(one.z, one.difference / one.standard_uncertainty)
    assert_allclose(one.p, 2.0 * norm.sf(abs(one.z)), rtol=1e-9)
    assert found.level == 0.05 / len(found.parameters)
    assert not found.looks_like


def test_a_change_of_the_size_of_a_mistake_is_named(folder):
    """In which of the two it was made; without a procedure nobody knows."""
    for first, second, run in (("a", "earth", "second"), ("earth", "a", "first")):
        (found,) = change(folder, first, second).looks_like
        assert (found.mistake.name, found.mistake.sensor) == ("earth_rate_sign", "gyro")
        assert found.run == run
        # Six faces up: 2 w sin L of the vertical axis go into the turns' bias alone.
    (found,) = change(folder, "a", "turned").looks_like
    assert found.mistake.name == "turn_sense"
    assert not change(folder, "a", "turned", procedure=None).looks_like


def test_diff_says_it(folder):
    """On a terminal, as JSON, as CSV; three of them are refused."""
    a, earth = (str(folder / f"{one}.json") for one in ("a", "earth"))
    found = call("diff", a, earth, "--procedure", SIX, "--json", "-")
    assert found.code == 0
    document = json.loads(found.out)
    assert document["looks_like"][0]["name"] == "earth_rate_sign"
    said = " ".join(call("diff", a, earth, "--procedure", SIX).out.split())
    assert "the change is the size of a mistake in earth.json" in said
    assert call("diff", a, earth, a).code == 2


def units(folder, spread, n=6):
    """Write results of a lot whose biases x spread by so much of what is printed."""
    whole = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    rng = np.random.default_rng(7)
    for k in range(n):
        made = json.loads(json.dumps(whole)) | {"serial": str(k)}
        for one in made["outputs"]:
            size = spread if (one["parameter"], one["axis"]) == ("bias", "x") else 1.0
            one["value"] = rng.normal() * size * (one["prior"] or 1.0)
        path = folder / f"unit-{k}-{spread:g}.json"
        path.write_text(json.dumps(made, indent=1), encoding="utf-8")
        yield path


def test_the_spread_of_a_lot_is_held_beside_what_is_printed(folder):
    """One that is four times as wide is worse; the others are not."""
    device = load_device(MEMS)
    sound = lot_of(device, [read_result(one) for one in units(folder, 1.0)])
    assert len(sound.parameters) == 24
    assert not sound.worse
    paths = [*units(folder, 4.0)]
    found = lot_of(device, [read_result(one) for one in paths])
    assert {(one.parameter, one.axis) for one in found.worse} == {("bias", "x")}
    one = next(x for x in found.parameters if (x.parameter, x.axis) == ("bias", "x"))
    assert_allclose(one.printed, 200.0, rtol=1e-9)
    values = [
        read_result(x).values[read_result(x).keys.index(("gyro", "bias", "x"))]
        for x in paths
    ]
    s = np.std(values, ddof=1)
    assert_allclose(one.p, chi2.sf(5 * s**2 / 200.0**2, 5), rtol=0.01)
    # Of six s x 0.6242 to s x 2.4526, as of a repeatability.
    ends = (one.spread_low, one.spread_high)
    assert_allclose(ends, s * np.array([0.6242, 2.4526]), rtol=2e-3)
    said = call("diff", str(folder / "mems.yaml"), *map(str, paths))
    assert said.code == 0
    assert "spread more than is printed" in said.out
    with pytest.raises(CallError, match="are of one unit"):
        lot_of(device, [read_result(paths[0])] * 2)


@pytest.mark.parametrize(
    "text",
    ['{"command": "calibrate"}', '{"command": "calibrate", "outputs": 3}', "[", "NaN"],
)
def test_what_is_no_result_is_refused(tmp_path, folder, text):
    """With its name; whatever stands in it."""
    path = tmp_path / "b.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"b.json.* is no result of a calibration"):
        read_result(path)
    whole = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    whole["outputs"][0]["unit"] = "counts/(deg/s)"
    path.write_text(json.dumps(whole), encoding="utf-8")
    with pytest.raises(CallError, match="calibrate both with, or"):
        change_between(read_result(folder / "a.json"), read_result(path), None)
