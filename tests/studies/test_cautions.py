"""What a user must be told, and what must never happen to a user's files."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from builders import NOWHERE, line, paper_gyro, procedure, sensor
from command_line import call
from numpy.testing import assert_allclose

import budget
from budget.calibration.problem import calibration_problem
from budget.distributions import NORMAL, UNIFORM
from budget.errors import CallError, ProblemError, SpecError
from budget.inputs import load_device
from budget.inputs.records import Device, Limit, Requirement
from budget.methods.execution import BLOCK, draw
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.methods.sobol import sobol
from budget.methods.validation import validate
from budget.names import Name
from budget.problem import Group, Output, Problem
from budget.studies.analysis import analyze
from budget.studies.conformity import assess
from budget.studies.sheets import cautions_of_device
from budget.units import DEG_PER_HOUR, MICRO_G
from jcgm import student_t


def device(*sensors, name="test device"):
    """Return a device of these sensors."""
    kinds = {s.kind: s for s in sensors}
    return Device(
        name=name,
        gyro=kinds.get("gyro"),
        accelerometer=kinds.get("accelerometer"),
        figures=(),
        assumptions=(),
        origin=NOWHERE,
    )


def one_output(*groups, function=lambda x: x.sum(axis=0, keepdims=True)):
    """Return a Problem of one output, the sum of its inputs by default."""
    return Problem(groups=groups, outputs=(Output(name="y"),), function=function)


def test_a_heavy_tail_does_not_confirm_a_law_that_is_far_off():
    """Scale factors of 40 %, reference next turn-on: 1/(1 + k) has no moments."""
    wild = sensor("gyro", {"scale_factor_repeatability": 0.4})
    problem = calibration_problem((wild,), procedure(), reference="next_turn_on")
    found = validate(problem, propagate(problem))
    assert [v.holds for v in found[:3]] == [False] * 3


@pytest.mark.parametrize(
    ("limit_ug", "coverage", "verdict"), [(45.0, 0.5, "fails"), (105.0, 0.95, "meets")]
)
def test_a_verdict_stands_on_an_interval_that_passed_its_check(
    limit_ug, coverage, verdict
):
    """A uniform bias of +-100 ug: the normal law says the contrary both times."""
    lines = [
        line("bias_repeatability", 100.0 / np.sqrt(3.0) * MICRO_G, distribution=UNIFORM)
    ]
    accelerometer = sensor("accelerometer", lines)
    dev = device(accelerometer)
    requirement = Requirement(
        name="r",
        coverage=coverage,
        reference="nominal",
        limits=(
            Limit(
                output=Name("bias", owner="accelerometer", axis="x"),
                limit=limit_ug * MICRO_G,
                printed="limit",
            ),
        ),
        caps=(),
        assumptions=(),
        origin=NOWHERE,
    )
    law = analyze(dev, procedure=procedure(), coverage=coverage)
    result = analyze(
        dev, procedure=procedure(), requirement=requirement, coverage=coverage
    )
    (row,) = assess(result, requirement, (dev,)).sensors
    place = [one.output.name for one in law.outputs].index("accelerometer.bias.x")
    by_law = law.question.law.interval(coverage)[place, 1] / MICRO_G
    assert row.verdict == verdict
    assert (by_law > limit_ug) == (verdict == "meets")


@pytest.mark.parametrize("v", [1, 2, 3, 5, 18, 39])
def test_one_input_keeps_its_degrees_of_freedom(v):
    """A single t input of v degrees of freedom has the coverage factor t(v)."""
    from scipy.special import stdtrit

    for u in (1.0, 0.3, 1e-8, 7.7):
        law = propagate(
            one_output(Group.independent("x", u=u, distribution=student_t(v)))
        )
        np.testing.assert_allclose(
            law.coverage_factor(0.95), stdtrit(v, 0.975), rtol=1e-9
        )


def test_student_inputs_have_the_indices_of_their_own_variance():
    """Y = a + b, a t(5), b normal: 5/3 of u^2 to a, so 0.625 and 0.375."""
    problem = one_output(
        Group.independent("a", u=1.0, distribution=student_t(5)),
        Group.independent("b", u=1.0),
    )
    found = sobol(problem, samples=4096)
    np.testing.assert_allclose(found.first.value[:, 0], [0.625, 0.375], atol=0.02)
    assert (found.first.high > found.first.low).all()


def test_asymmetry_moves_no_other_sources_draws():
    """With and without asymmetry every other source has the same inputs."""
    names = {}
    for more in ({}, {"scale_factor_asymmetry": 1e-12}):
        problem = calibration_problem((paper_gyro(**more),), procedure())
        x = draw(problem, 0, 0, np.empty((problem.n_inputs, BLOCK)))
        for group, rows in zip(problem.groups, problem.slices, strict=True):
            names.setdefault(group.name, []).append(x[rows][:12])
    for name, found in names.items():
        if len(found) > 1:
            scale = np.abs(found[0]).max()
            error = np.abs(found[0] - found[1]).max() / scale
            assert error < 1e-14, name


def test_one_axis_shape_moves_no_other_axis_draws():
    """Of three uniform axes one becomes triangular: the others keep their bits."""
    from budget.distributions import TRIANGULAR

    def inputs(*shapes):
        group = Group.independent("x", u=[1.0, 1.0, 1.0], distribution=shapes)
        return draw(one_output(group), 0, 0, np.empty((3, BLOCK)))

    before = inputs(UNIFORM, UNIFORM, UNIFORM)
    after = inputs(UNIFORM, TRIANGULAR, UNIFORM)
    np.testing.assert_array_equal(before[[0, 2]], after[[0, 2]])
    mixed = inputs(UNIFORM, NORMAL, UNIFORM)
    np.testing.assert_array_equal(before[[0, 2]], mixed[[0, 2]])


@pytest.mark.parametrize(
    "how",
    [
        {"coverage": 1.5},
        {"coverage": 1.0},
        {"interval": "foo"},
        {"digits": 0},
        {"trials": 1},
        {"max_trials": 1000},
        {"coverage": 0.9999999},
    ],
)
def test_sample_refuses_arguments_that_mean_nothing(how):
    """Each raises CallError; none gives numbers, nan or another exception."""
    with pytest.raises(CallError):
        sample(one_output(Group.independent("x", u=1.0)), **how)


def test_a_model_that_is_not_finite_is_refused():
    """The logarithm of a normal input raises ProblemError, not nan."""
    problem = one_output(Group.independent("x", u=1.0), function=np.log)
    with np.errstate(invalid="ignore"), pytest.raises(ProblemError, match="finite"):
        sample(problem, trials=5000)


def test_a_group_does_not_lock_the_callers_arrays():
    """Means and covariances given to a Group can still be changed by their owner."""
    mean = np.zeros(1)
    Group(name="x", mean=mean, covariance=np.ones((1, 1)), distributions=(NORMAL,))
    mean[0] = 1.0


def test_a_sensor_without_lines_is_a_budget_of_zeros_that_says_so():
    """Nothing is known: all u are 0, and a warning tells what that 0 means."""
    bare = device(sensor("gyro", {}, bias=DEG_PER_HOUR))
    result = analyze(bare, procedure=procedure(), samples=64)
    assert all(row.standard_uncertainty == 0.0 for row in result.outputs)
    words = " ".join(result.warnings)
    assert "not known, not good" in words
    assert "no source varies" in words


def test_options_without_effect_and_rough_intervals_are_said():
    """Trials by the law, and 20 trials for 99.9 %, each carry a warning."""
    dev = device(paper_gyro())
    by_law = analyze(dev, procedure=procedure(), trials=77, validate=False)
    assert any("has no effect" in text for text in by_law.warnings)
    rough = analyze(
        dev, procedure=procedure(), method="monte-carlo", trials=20, coverage=0.999
    )
    assert any("rough" in text for text in rough.warnings)


def test_nonlinearity_that_counts_nothing_is_said():
    """Under as_tested a given nonlinearity is in the reference: an assumption."""
    dev = device(paper_gyro(scale_factor_nonlinearity=0.05))
    told_by = {"nominal": False, "as_tested": True, "next_turn_on": False}
    for reference, told in told_by.items():
        result = analyze(
            dev, procedure=procedure(), reference=reference, validate=False
        )
        found = any("nonlinearity" in text for text in result.assumptions)
        assert found == told


def test_what_is_no_device_is_refused_in_words():
    """What is neither a device nor its name raises CallError that names load_device."""
    with pytest.raises(CallError, match="load_device"):
        budget.analyze(3.5)
    with pytest.raises(SpecError, match="no such file"):
        budget.analyze("imu.yaml")


@pytest.mark.parametrize("option", ["--json", "--csv"])
def test_an_output_never_overwrites_an_input(tmp_path, option):
    """A device file named as output is refused, and left as it was."""
    path = tmp_path / "imu.yaml"
    text = "name: a\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n"
    path.write_text(text, encoding="utf-8")
    run = call("analyze", str(path), option, str(path))
    assert run.code == 2
    assert "would be overwritten" in run.err
    assert path.read_text(encoding="utf-8") == text


@pytest.mark.slow
def test_a_reader_that_stops_reading_ends_the_program_in_silence():
    """`budget analyze | head -1` prints one line, and no error."""
    run = subprocess.run(
        [
            *("bash", "-c", '"$0" -m budget analyze --no-validate | head -1'),
            sys.executable,
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout == "Zhao 2019 optical IMU\n"
    assert "rror" not in run.stderr


def test_a_date_that_is_none_is_refused():
    """SOURCE_DATE_EPOCH=abc is exit 2 with one line, not a traceback."""
    run = subprocess.run(
        [sys.executable, "-m", "budget", "analyze"],
        capture_output=True,
        text=True,
        check=False,
        env={"SOURCE_DATE_EPOCH": "abc", "PATH": "/usr/bin:/bin"},
    )
    assert run.returncode == 2
    assert run.stderr.startswith("SOURCE_DATE_EPOCH is 'abc'")
    assert len(run.stderr.splitlines()) == 1


def nonlinear(folder, words):
    """Return u of the gyro's scale factor in use over 30 ppm, and what is said."""
    path = folder / "bent.yaml"
    path.write_text(
        f"name: bent\ngyro: {{errors: {{scale_factor_nonlinearity: {words}}}}}\n"
    )
    found = {
        reference: budget.analyze(
            budget.load_device(path), reference=reference, validate=False
        )
        for reference in ("nominal", "as_tested", "next_turn_on")
    }
    u = {key: one.outputs[0].standard_uncertainty / 30e-6 for key, one in found.items()}
    told = {
        key: " ".join((*one.assumptions, *one.warnings)) for key, one in found.items()
    }
    return u, told


def test_a_nonlinearity_without_a_full_scale_is_met_in_use(tmp_path):
    """No calibration takes it out: once in full, and nothing says that it cancels."""
    u, told = nonlinear(tmp_path, "30 ppm")
    assert_allclose([u["nominal"], u["next_turn_on"]], [1.0, 1.0], rtol=1e-6)
    assert_allclose(u["as_tested"], 0.0, rtol=0, atol=1e-9)
    assert "has no effect" in told["as_tested"]
    assert "has no effect" not in told["next_turn_on"]
    assert "full scale not given" in told["next_turn_on"]


def test_a_nonlinearity_over_a_full_scale_is_its_curve(tmp_path):
    """Control: of a curve the turns at 20 deg/s see 4 NL/R^2 Omega^2, 0.533 ppm."""
    u, told = nonlinear(tmp_path, "{value: 30 ppm, full_scale: 300 deg/s}")
    assert_allclose(u["next_turn_on"], 4.0 * (20.0 / 300.0) ** 2, rtol=1e-3)
    assert "full scale not given" not in told["next_turn_on"]


GIVEN = {
    "bias_repeatability": "1 deg/h",
    "bias_stability": "0.1 deg/h",
    "angle_random_walk": "0.01 deg/sqrt(h)",
    "scale_factor_repeatability": "10 ppm",
    "mounting_repeatability": "1 arcsec",
}


def kinds_of(*, without=(), reads="300 deg/s", **lines):
    """Return kind and line of all that a gyro's sheet leaves open."""
    errors = {name: x for name, x in GIVEN.items() if name not in without} | lines
    sheet = {"name": "sheet", "gyro": {"errors": errors}}
    if reads:
        sheet["gyro"]["range"] = reads
    found = cautions_of_device(load_device(sheet))
    return [(one.kind, one.line.quantity) for one in found]


def aside(name, **lines):
    """Return what is said of a figure that stands beside the lines of a gyro."""
    figures = [{"name": name, "value": "1 deg/sqrt(h)"}]
    sheet = {"name": "sheet", "gyro": {"errors": lines}, "figures": figures}
    found = cautions_of_device(load_device(sheet))
    return [one.line.quantity for one in found if "under figures" in str(one.text)]


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("gyro_arw", "angle_random_walk"),
        ("Gyro angle random walk, typical", "angle_random_walk"),
        ("accel VRW", None),
        ("gyro resolution", None),
        ("the arw of the gyro", None),
    ],
)
def test_a_figure_that_is_called_as_a_line_is_said(name, line):
    """In the words of makers, of a sensor that the sheet has and a line it lacks."""
    assert aside(name) == ([line] if line else [])
    assert aside(name, angle_random_walk="0.1 deg/sqrt(h)") == []


@pytest.mark.parametrize(("size", "is_far"), [(0.3, True), (0.003, False)])
def test_a_figure_far_from_all_others_is_said(size, is_far):
    """In deg/s for deg/h: above ten times the largest that others print."""
    errors = {"bias_stability": f"{size} deg/s"}
    sheet = {"name": "sheet", "gyro": {"errors": errors}}
    found = cautions_of_device(load_device(sheet))
    assert any("more than ten times" in str(one.text) for one in found) is is_far


def test_a_sheet_that_says_all_leaves_nothing_open():
    """The control: every expected line, a range, and nothing that a use exercises."""
    assert kinds_of() == []


@pytest.mark.parametrize(
    ("options", "kind", "line"),
    [
        ({"without": ["bias_stability"]}, "missing", "bias_stability"),
        ({"reads": ""}, "range", "range"),
        *(
            ({name: value}, "not_exercised", name)
            for name, value in (
                ("bias_temperature_coefficient", "0.1 deg/h/degC"),
                ("scale_factor_temperature_coefficient", "10 ppm/degC"),
                ("vibration_rectification", "1 deg/h/g^2"),
                ("ageing", {"value": "1 deg/h", "horizon": "1 year"}),
            )
        ),
        (
            {"bias_repeatability": {"value": "1 deg/h", "horizon": "1 year"}},
            *("horizon", "bias_repeatability"),
        ),
        (
            {"scale_factor_nonlinearity": "30 ppm"},
            *("full_scale", "scale_factor_nonlinearity"),
        ),
        (
            {"without": ["angle_random_walk"], "sample_noise": "0.1 deg/s"},
            *("bandwidth", "sample_noise"),
        ),
        (
            {"bias_stability": {"value": "1 deg/h", "definition": "allan_minimum"}},
            *("correlation_time", "bias_stability"),
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_a_sheet_leaves_open_is_said(options, kind, line):
    """Of one line each, and of nothing else."""
    assert kinds_of(**options) == [(kind, line)]


@pytest.mark.parametrize(
    "options",
    [
        {"bias_temperature_coefficient": "0 deg/h/degC"},
        {"scale_factor_nonlinearity": {"value": "30 ppm", "full_scale": "300 deg/s"}},
        {
            "without": ["angle_random_walk"],
            "sample_noise": {"value": "0.1 deg/s", "bandwidth": "50 Hz"},
        },
        {
            "bias_stability": {
                "value": "1 deg/h",
                "definition": "allan_minimum",
                "correlation_time": "600 s",
            }
        },
    ],
    ids=["nothing", "full scale", "bandwidth", "correlation time"],
)
def test_what_a_sheet_says_of_itself_leaves_nothing_open(options):
    """What is a 0, or says its full scale, bandwidth or time."""
    assert kinds_of(**options) == []


def test_validate_says_what_a_sheet_leaves_open():
    """Once for all variants, in the words of the verdicts."""
    out = call("validate", "bmi088").out
    said = [line for line in out.splitlines() if line.startswith("  caution: ")]
    assert len(said) == len(set(said))
    assert any("temperature at use, which is to be stated" in line for line in said)
    own = {str(one.text) for one in cautions_of_device(load_device("bmi088"))}
    assert {line.removeprefix("  caution: ") for line in said} == own
