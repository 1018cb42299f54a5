"""Input quantities of a budget: divisor, u(x), c, and what they add up to."""

from __future__ import annotations

from math import sqrt

import pytest
from keeping import catalogue
from numpy.testing import assert_allclose
from places import put

from budget.inputs import load_device
from budget.model.sources import FLICKER
from budget.names import Name
from budget.question import Question
from budget.results import INTERACTION
from budget.studies.analysis import analyze
from budget.studies.input_quantities import input_quantities
from budget.units import parse_quantity

FLOOR = "definition: allan_minimum"
DEVICE = """\
name: Axes that differ
gyro:
  nominal: {bias: 3 deg/h}
  errors:
    bias_repeatability: {value: 0.06 deg/h, meaning: 3 sigma}
    bias_stability: {value: 0.04 deg/h, correlation_time: 300 s}
    angle_random_walk:
      axes: {x: 0.005 deg/sqrt(h), y: 0.02 deg/sqrt(h), z: 0.01 deg/sqrt(h)}
    scale_factor_repeatability: {value: 100 ppm, meaning: peak to peak}
    scale_factor_nonlinearity: {value: 50 ppm, meaning: max}
    mounting_repeatability: {value: 20 arcsec, meaning: max, distribution: triangular}
"""


@pytest.fixture(scope="module")
def device(tmp_path_factory):
    """Return a gyro whose noise differs by axis, and several shapes."""
    path = put(tmp_path_factory.mktemp("device") / "axes.yaml", DEVICE)
    return load_device(path)


@pytest.fixture(scope="module")
def budget(device):
    """Return its budget."""
    return analyze(device, validate=False)


def quantity(budget, name):
    """Return one input quantity."""
    return next(one for one in budget.quantities if one.source == f"gyro.{name}")


@pytest.mark.parametrize(
    ("name", "divisor", "u"),
    [
        ("bias_repeatability", 3.0, 0.06 / 3.0),
        ("bias_stability", 1.0, 0.04),
        ("scale_factor_repeatability", 2.0 * sqrt(3.0), 100.0 / sqrt(12.0)),
        ("scale_factor_nonlinearity", sqrt(3.0), 50.0 / sqrt(3.0)),
        ("mounting_repeatability", sqrt(6.0), 20.0 / sqrt(6.0)),
    ],
)
def test_the_divisor_is_that_of_meaning_and_shape(budget, name, divisor, u):
    """JCGM 100:2008, 4.3.3, 4.3.7 and 4.3.9: printed over u(x)."""
    found = quantity(budget, name)

    assert_allclose(found.divisor, divisor, rtol=1e-14)
    assert_allclose(found.u, u, rtol=1e-14)


def test_what_does_not_spread_is_shared_out_to_nothing(budget):
    """Shares of a variance add up to 1; of none, each is 0."""
    zero = {"name": "z", "gyro": {"errors": {"bias_repeatability": "0 deg/h"}}}
    for found, whole in (
        (budget, 1.0),
        (analyze(load_device(zero), validate=False), 0),
    ):
        for row in found.outputs:
            share = sum(part.share for part in row.contributions)
            assert_allclose(share, whole, rtol=1e-12)


def test_printed_over_divisor_is_u_in_the_whole_catalogue():
    """Of every shipped line with one value: what is printed over its divisor is u(x).

    In the printed unit and, where the model has the maker's quantity, in SI too: how a
    number is read (sides of a density, Allan minimum) is in the divisor, not in c.
    """
    found, read = 0, set()
    for device in catalogue():
        question = Question.of(device)
        lines = {
            Name(line.name, owner=sensor.kind): line
            for sensor in question.sensors
            for line in sensor.lines
        }
        for one in input_quantities(question):
            number = one.printed.removesuffix(one.unit).strip()
            if one.divisor is None or not number.replace(".", "").isdigit():
                continue
            told = f"{device.name} {one.source}"
            u = float(number) / one.divisor
            assert_allclose(one.u, u, rtol=1e-9, err_msg=told)
            found += 1
            line = lines.get(one.source)
            if (  # another quantity, local g
                line is None or line.form not in {"", FLICKER} or "g" in one.unit
            ):
                continue
            size = parse_quantity(f"1 {one.unit}", one.unit).si_per_unit
            assert_allclose(line.u, u * size, rtol=1e-9, err_msg=told)
            read.add(line.density or line.definition.partition(",")[0])
    assert found > 20
    assert {"one-sided", "allan_minimum"} <= read


@pytest.mark.parametrize(
    ("source", "given", "divisor"),
    [
        ("bias_stability", f"{FLOOR}, correlation_time: 300 s", 0.664),
        ("bias_stability", FLOOR, 0.664),
        ("flicker", "definition: allan_minimum", 0.664),
        ("flicker", "definition: coefficient", 1.0),
        ("angle_random_walk", "density: one-sided", sqrt(2.0)),
        ("angle_random_walk", "density: two-sided", 1.0),
        (
            "angle_random_walk",
            "{density: one-sided, meaning: 3 sigma}",
            3.0 * sqrt(2.0),
        ),
    ],
)
def test_how_a_number_is_read_is_in_its_divisor(tmp_path, source, given, divisor):
    """u(x) is the printed value over the divisor, and c does not know of the reading.

    IEEE 952: N = D / sqrt(2) of a one-sided density, B = minimum / 0.664 of flicker.
    """
    unit = "deg/h/sqrt(Hz)" if source.endswith("walk") else "deg/h"

    def read(words):
        path = tmp_path / "read.yaml"
        said = words.strip("{}")
        path.write_text(
            "name: Read\ngyro:\n  errors:\n"
            f"    {source}: {{value: 0.5 {unit}, {said}}}\n"
        )
        return analyze(load_device(path), validate=False)

    budget = read(given)
    assert_allclose(quantity(budget, source).u, 0.5 / divisor, rtol=1e-12)
    assert_allclose(quantity(budget, source).divisor, divisor, rtol=1e-12)
    plain = "definition: coefficient" if source == "flicker" else "density: two-sided"
    if source == "bias_stability":  # a floor is of flicker noise, without a time
        source = "flicker" if given == FLOOR else source
        plain = "definition: coefficient" if given == FLOOR else "definition: sigma"
    same = [
        next(
            part["sensitivity"]
            for part in one.to_dict()["outputs"][-1]["contributions"]
            if part["source"] in {"gyro.bias_stability", f"gyro.{source}"}
        )
        for one in (budget, read(plain))
    ]
    assert same[0] > 0.0
    assert_allclose(same[0], same[1], rtol=1e-9)


def test_c_u_is_the_source_alone(device, budget):
    """What the linear map says is what the budget of that source alone says."""
    for name in ("bias_stability", "angle_random_walk", "mounting_repeatability"):
        alone = analyze(device, validate=False, only=[f"gyro.{name}"])
        for row in budget.outputs:
            part = next(p for p in row.contributions if p.source == f"gyro.{name}")
            expected = alone.output(row.output.name).standard_uncertainty
            assert_allclose(
                part.linear, expected, rtol=1e-9, atol=row.output.resolution
            )


def test_c_does_not_depend_on_the_size_of_the_line(device, budget):
    """A line ten times as large has the same c, and ten times the c u(x)."""
    changed = device.replace({"gyro.bias_stability": "0.4 deg/h"})
    more = analyze(changed, validate=False)
    for row in budget.outputs:
        before, after = (
            next(
                p
                for p in one.output(row.output.name).contributions
                if p.source == "gyro.bias_stability"
            )
            for one in (budget, more)
        )
        assert_allclose(after.sensitivity, before.sensitivity, rtol=1e-9)
        assert_allclose(after.u_input, 10.0 * before.u_input, rtol=1e-12)


def test_u_is_that_of_the_axis_that_reaches(budget):
    """The bias about y is reached by the noise of the gyro along y alone."""
    line = quantity(budget, "angle_random_walk")
    for axis, u in zip("xyz", (0.005, 0.02, 0.01), strict=True):
        row = budget.output(f"gyro.bias.{axis}")
        part = next(p for p in row.contributions if p.source == line.source)
        assert_allclose(part.u_input / line.si_per_unit, u, rtol=1e-12)


def test_the_rows_sum_to_the_combined_u(budget):
    """(c u)^2 of the rows, and what is of second order, sum to u^2."""
    document = budget.to_dict()
    for row, output in zip(document["outputs"], budget.outputs, strict=True):
        first = second = 0.0
        for part in row["contributions"]:
            whole = part["standard_uncertainty"] ** 2
            if part["source"] == INTERACTION:
                second += whole
                continue
            linear = (part["sensitivity"] * part["u_input"]) ** 2
            first += linear
            second += whole - linear
            assert_allclose(
                part["share"] * row["standard_uncertainty"] ** 2,
                whole,
                rtol=1e-9,
                atol=1e-24,
            )
        u = row["standard_uncertainty"]
        assert_allclose(first + second, u**2, rtol=1e-12)
        assert_allclose(second, 0.0, atol=1e-6 * u**2)
        assert first > 0.0
        if row["interval_by"] == "law":
            assert_allclose(
                row["coverage_factor"] * u,
                (row["interval"][1] - row["interval"][0]) / 2.0,
                rtol=1e-12,
            )
        else:
            assert row["coverage_factor"] is None
        assert row["degrees_of_freedom"] is None, output.output.name


def test_k_is_that_of_the_coverage(device):
    """At 99.73 % the coverage factor is 3, not 1.96 by rote."""
    budget = analyze(device, validate=False, coverage=0.9973)

    factors = [row.coverage_factor for row in budget.outputs if not row.by_trials]
    assert factors
    assert_allclose(factors, 3.0, rtol=1e-4)
    assert_allclose([row.law_factor for row in budget.outputs], 3.0, rtol=1e-4)
