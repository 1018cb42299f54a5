"""`budget analyze`: what each option and each kind of device file changes."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from builders import last_digit
from command_line import analyze, call, contribution, output
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.model.sources import lines_of


@pytest.fixture
def procedure(tmp_path):
    """Write a procedure file of a given text and return its path."""

    def write(text):
        return put(tmp_path / "procedure.yaml", text)

    return write


def u(document, name):
    """Return the standard uncertainty of one output, in its printed unit."""
    return output(document, name)["standard_uncertainty"]


@pytest.mark.parametrize(
    ("reference", "printed"),
    [("nominal", "0.0564"), ("as_tested", "0.0261"), ("next_turn_on", "0.0754")],
)
def test_reference_says_what_errors_are_counted_from(reference, printed):
    """The paper's gyro bias x has the three uncertainties that the README names."""
    document = analyze("--reference", reference)

    assert document["settings"]["reference"] == reference
    assert_allclose(
        u(document, "gyro.bias.x"), float(printed), rtol=0, atol=last_digit(printed)
    )


@pytest.mark.parametrize(
    ("method", "options", "trials"),
    [
        ("gum", (), None),
        ("monte-carlo", ("--trials", "20000"), 20000),
        ("simulation", ("--trials", "3"), 3),
    ],
)
def test_method_and_trials_are_noted(method, options, trials):
    """Method and trials of a result are those asked for; the law has no trials."""
    settings = analyze("--method", method, *options)["settings"]

    assert (settings["method"], settings["trials"]) == (method, trials)


@pytest.fixture
def short(procedure):
    """Write a procedure of some seconds: its simulation takes as little."""
    return procedure(
        "name: short\ngyro: {rate: 360 deg/s, dwell: 1 s}\n"
        "accelerometer: {dwell: 1 s}\n"
    )


def test_simulation_runs_two_hundred_times(short):
    """Without a number, the calibration, here a short one, is simulated 200 times."""
    document = analyze("--method", "simulation", "--procedure", short)
    assert document["settings"]["trials"] == 200


@pytest.mark.parametrize("method", ["monte-carlo", "simulation"])
def test_methods_share_the_contributions(method, short):
    """Under every method the contributions are the law's, to the last bit."""
    law = analyze("--procedure", short)
    other = analyze("--procedure", short, "--method", method, "--trials", "20")

    assert other["outputs"][0]["mean"] != law["outputs"][0]["mean"]
    for ours, theirs in zip(law["outputs"], other["outputs"], strict=True):
        assert ours["contributions"] == theirs["contributions"]


def test_adaptive_is_the_default_of_trials():
    """`--trials adaptive` is what runs when nothing is said."""
    asked = analyze("--method", "monte-carlo", "--trials", "adaptive")

    assert asked == analyze("--method", "monte-carlo")
    assert asked["settings"]["trials"] >= 10_000


def test_a_second_digit_takes_more_trials(write):
    """`--digits 2` draws three times what `--digits 1` does, or more."""
    gyro = write("gyro.yaml", GYRO)
    one, two = (
        analyze(gyro, "--method", "monte-carlo", "--digits", digits)
        for digits in (1, 2)
    )

    # First stages of 30 and 10 macro-blocks.
    assert two["settings"]["trials"] >= 3 * one["settings"]["trials"]


def test_too_few_trials_allowed_is_said():
    """Stopped by `--max-trials`, a result carries a warning that names the option."""
    document = analyze(
        *("--method", "monte-carlo", "--digits", "2", "--max-trials", "30000")
    )

    assert any("--max-trials" in text for text in document["warnings"])


def test_seed_moves_the_draws():
    """Another seed gives other numbers, the same seed the same; 0 is the default."""
    draw = ("--method", "monte-carlo", "--trials", "1000", "--seed")
    zero, one, again = (analyze(*draw, seed) for seed in (0, 1, 1))

    assert one == again
    assert u(zero, "gyro.bias.x") != u(one, "gyro.bias.x")
    assert zero == analyze(*draw[:-1])


def test_coverage_in_per_cent_is_the_same():
    """'95 %', '95%' and 0.95 are one coverage, which is also the default."""
    documents = [analyze("--coverage", text) for text in ("95 %", "95%", "0.95")]

    assert documents == [analyze()] * 3


def test_coverage_in_per_cent_is_exact():
    """'99.73 %' is the double nearest to 0.9973, as a requirement file reads it."""
    document = analyze("--coverage", "99.73 %")

    assert document["settings"]["coverage"] == 0.9973


def test_coverage_sets_the_width():
    """At 99.73 % the law's interval is 3 u to each side, to three digits."""
    document = analyze("--coverage", "0.9973")

    assert document["settings"]["coverage"] == 0.9973
    low, high = output(document, "gyro.bias.x")["interval"]
    assert_allclose((high - low) / 2 / u(document, "gyro.bias.x"), 3.0, rtol=1e-3)


def test_shortest_interval_is_no_wider():
    """Of the same trials, the shortest interval is within the symmetric one's width."""
    draw = ("--method", "monte-carlo", "--trials", "20000", "--interval")
    symmetric, shortest = (analyze(*draw, kind) for kind in ("symmetric", "shortest"))

    assert shortest["settings"]["interval"] == "shortest"
    for one, two in zip(symmetric["outputs"], shortest["outputs"], strict=True):
        width, least = (row["interval"][1] - row["interval"][0] for row in (one, two))
        assert 0.9 * width < least < width


def test_law_is_validated_unless_told_not_to():
    """The law is checked by at most 250 000 trials; `--no-validate` leaves that out."""
    source = ("--only", "gyro.bias_repeatability")
    run = call("analyze", *source, "--json", "-")

    for row in run.document["outputs"]:
        check = row["validation"]
        assert check["holds"] is True
        assert 0 < check["trials"] <= 250_000
        assert max(check["difference_low"], check["difference_high"]) >= 0.0
    assert {row["validation"] for row in analyze(*source)["outputs"]} == {None}


def test_sobol_indices_are_the_shares_of_a_linear_law():
    """The paper's gyro bias is linear in its sources: indices and shares agree.

    Within 1e-6, which is 10 half-widths of the intervals at these 512 points.
    """
    parts = output(analyze("--sobol", "--samples", "64"), "gyro.bias.x")[
        "contributions"
    ]

    for part in parts[:-1]:
        for key in ("sobol_first", "sobol_total"):
            assert_allclose(part[key], part["share"], rtol=0, atol=1e-6)


def test_samples_ask_for_indices():
    """`--samples N` alone asks for the indices too, and N is noted."""
    document = analyze("--samples", "64")

    assert document["settings"]["sobol_samples"] == 64
    assert document == analyze("--sobol", "--samples", "64")


def test_procedure_file_is_used(procedure):
    """The paper's formula of the gyro bias leaves its residual, 6.365e-10 of 2.5 deg/h.

    Printed in Table 1 as 6.36529e-10 relative; the corrected formula leaves less than
    a tenth of it as expected error, the second-order mean.
    """
    file = procedure("name: printed\nformulas: paper\n")
    only = ("--only", "gyro.scale_factor_repeatability")
    printed, mended = analyze("--procedure", file, *only), analyze(*only)

    assert printed["settings"]["formulas"] == "paper"
    assert mended["settings"]["formulas"] == "corrected"
    assert printed["inputs"]["procedure"]["name"] == "procedure.yaml"
    assert_allclose(
        output(printed, "gyro.bias.z")["mean"] / 2.5, 6.36529e-10, rtol=5e-6
    )
    assert abs(output(mended, "gyro.bias.z")["mean"] / 2.5) < 6.4e-11


def test_longer_dwell_averages_more(procedure):
    """Four times the dwell halves what white noise does to the accelerometer bias."""
    file = procedure("name: slow\naccelerometer: {dwell: 1200 s}\n")
    place = ("accelerometer.bias.x", "accelerometer.sample_noise")
    short, long = (
        contribution(document, *place)["standard_uncertainty"]
        for document in (analyze(), analyze("--procedure", file))
    )

    assert_allclose(long, short / 2, rtol=1e-9)


def test_only_with_a_full_name():
    """Alone, the gyro's bias repeatability leaves 0.05 deg/h and nothing elsewhere."""
    document = analyze("--only", "gyro.bias_repeatability")

    assert document["settings"]["only"] == ["gyro.bias_repeatability"]
    for row in document["outputs"]:
        is_own = (row["sensor"], row["parameter"]) == ("gyro", "bias")
        expected = 0.05 if is_own else 0.0
        # 1e-12 of a printed unit is rounding: 1e-12 ppm, arcsec, deg/h or ug.
        assert_allclose(row["standard_uncertainty"], expected, rtol=1e-9, atol=1e-12)


def test_only_with_a_bare_name_means_both_sensors():
    """`--only bias_repeatability` is the same as both full names, in any order."""
    bare = analyze("--only", "bias_repeatability")
    both = analyze(
        *("--only", "gyro.bias_repeatability"),
        *("--only", "accelerometer.bias_repeatability"),
    )

    assert bare == both
    assert bare["settings"]["only"] == [
        "accelerometer.bias_repeatability",
        "gyro.bias_repeatability",
    ]


def test_only_changes_nothing_in_not_given():
    """A line set to zero for this run is still a line that the device gives."""
    assert analyze("--only", "bias_stability")["not_given"] == analyze()["not_given"]


def test_only_keeps_the_rows_of_all_sources():
    """Sources set to zero still stand in every list of contributions."""
    for one, two in zip(
        analyze("--only", "bias_stability")["outputs"],
        analyze()["outputs"],
        strict=True,
    ):
        sources = [[p["source"] for p in row["contributions"]] for row in (one, two)]
        assert sources[0] == sources[1]


@pytest.mark.parametrize(
    ("typed", "near"),
    [
        ("gyro.bias_stabilty", "gyro.bias_stability"),
        ("bias_stabilty", "bias_stability"),
        ("accelerometer.sample_nose", "accelerometer.sample_noise"),
    ],
)
def test_only_with_an_unknown_name(typed, near):
    """A misspelt source is exit 2 with the nearest name there is."""
    run = call("analyze", "--no-validate", "--only", typed, "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert repr(typed) in run.err
    assert f"did you mean {near!r}?" in run.err


def test_only_with_a_line_that_is_not_given():
    """A known line the device lacks gives zeros, shares of 0 and a warning."""
    document = analyze("--only", "gyro.rate_random_walk")

    (warning,) = document["warnings"]
    assert "gyro rate random walk" in warning
    for row in document["outputs"]:
        assert row["standard_uncertainty"] == 0.0
        assert {part["share"] for part in row["contributions"]} == {0.0}


def test_table_and_document_agree():
    """What the terminal prints for the gyro biases is the document's, rounded."""
    text = call("analyze", "--no-validate", "--full").out
    block = text[text.index("Gyro bias x, y, z [deg/h]") :].partition("Without")[0]
    (u,) = re.findall(r"(?m)^combined u +([\d.]+) ", block)
    (expanded,) = re.findall(r"(?m)^U95 = k u +([\d.]+)$", block)

    entry = output(analyze(), "gyro.bias.x")
    for printed, exact in (
        (u, entry["standard_uncertainty"]),
        (expanded, (entry["interval"][1] - entry["interval"][0]) / 2),
    ):
        assert_allclose(exact, float(printed), rtol=0, atol=last_digit(printed) / 2)


# ---- what a device file says, and what becomes of it ---------------------------------

GYRO = """\
name: gyro alone
gyro:
  errors:
    bias_repeatability: 0.05 deg/h
    bias_stability: {value: 0.04 deg/h, correlation_time: 300 s}
    angle_random_walk: 0.005 deg/sqrt(h)
    scale_factor_repeatability: 50 ppm
    mounting_repeatability: 2 arcsec
"""
ACCELEROMETER = """\
name: accelerometer alone
accelerometer:
  errors:
    bias_repeatability: 37 ug
    bias_stability: {value: 20 ug, correlation_time: 300 s}
    velocity_random_walk: 5 ug/sqrt(Hz)
    scale_factor_repeatability: 37 ppm
    mounting_repeatability: 2 arcsec
"""
VARIANTS = """\
variants:
  better: {name: better, gyro: {errors: {bias_repeatability: 0.01 deg/h}}}
"""


@pytest.fixture
def write(tmp_path):
    """Write files of given texts beside each other and return their paths."""

    def write(name, text):
        return put(tmp_path / name, text)

    return write


def test_gyro_alone_has_twelve_outputs(write):
    """A device without an accelerometer has no accelerometer outputs or gaps."""
    document = analyze(write("gyro.yaml", GYRO))

    assert [row["sensor"] for row in document["outputs"]] == ["gyro"] * 12
    assert len(document["covariance"]) == 12
    assert all(name.startswith("gyro.") for name in document["not_given"])


def test_two_files_complete_each_other(write):
    """A gyro and an accelerometer from two files, in any order, give 24 outputs."""
    gyro, other = write("g.yaml", GYRO), write("a.yaml", ACCELEROMETER)
    one, two = analyze(gyro, other), analyze(other, gyro)

    assert len(one["outputs"]) == 24
    assert one["outputs"] == two["outputs"]
    assert one["outputs"][0]["sensor"] == "gyro"
    assert [one["inputs"][f"device {n}"]["name"] for n in (1, 2)] == [
        "g.yaml",
        "a.yaml",
    ]


def test_two_gyros_are_refused(write):
    """Two devices with a gyro each are exit 2, and both are named."""
    gyro = write("g.yaml", GYRO)
    run = call("analyze", gyro, "zhao-2019", "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert_says(run.err, "'gyro alone'", "'Zhao 2019 optical IMU'", "a gyro")


def test_figure_by_axis(write):
    """An axis named in `axes` takes its own figure, the others the common one."""
    text = GYRO.replace(
        "bias_repeatability: 0.05 deg/h",
        "bias_repeatability: {value: 0.05 deg/h, axes: {z: 0.2 deg/h}}",
    )
    document = analyze(write("g.yaml", text))

    for axis, expected in zip("xyz", (0.05, 0.05, 0.2), strict=True):
        part = contribution(document, f"gyro.bias.{axis}", "gyro.bias_repeatability")
        assert_allclose(part["standard_uncertainty"], expected, rtol=1e-9)


def test_half_width_without_distribution(write):
    """`max` is a half-width, uniform unless said: u = a / sqrt(3), and that is said."""
    text = GYRO.replace("50 ppm", "{value: 50 ppm, meaning: max}")
    document = analyze(write("g.yaml", text))

    part = contribution(
        document, "gyro.scale_factor.x", "gyro.scale_factor_repeatability"
    )
    assert_allclose(part["standard_uncertainty"], 28.8675134595, rtol=1e-9)
    assert any("uniform" in text for text in document["assumptions"])


def test_missing_line_stands_in_not_given(write):
    """Every model line that the device does not give is named, and only those.

    Its white noise is given, as a random walk; flicker is another reading of stability.
    """
    text = "".join(
        line for line in GYRO.splitlines(keepends=True) if "mounting" not in line
    )
    document = analyze(write("g.yaml", text))

    given = {
        *("bias_repeatability", "bias_stability"),
        *("angle_random_walk", "sample_noise", "scale_factor_repeatability"),
        "flicker",
    }
    assert set(document["not_given"]) == {
        f"gyro.{line.name}"
        for line in lines_of("gyro")
        if line.varies and not line.is_initial and line.name not in given
    }
    assert "gyro.mounting_repeatability" in document["not_given"]


def test_variant_is_chosen_by_name(write):
    """FILE#VARIANT takes the variant's figure, FILE the base's."""
    file = write("g.yaml", GYRO + VARIANTS)
    place = ("gyro.bias.x", "gyro.bias_repeatability")
    base, better = (
        contribution(analyze(name), *place)["standard_uncertainty"]
        for name in (file, f"{file}#better")
    )

    assert_allclose([base, better], [0.05, 0.01], rtol=1e-9)


def test_unknown_variant_is_refused(write):
    """A variant that there is not is exit 2, with the ones there are."""
    file = write("g.yaml", GYRO + VARIANTS)
    run = call("analyze", f"{file}#beter", "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert "beter" in run.err
    assert "better" in run.err


def test_source_of_zero_uncertainty(write):
    """A 0 that is meant is given, not missing: its rows are zeros, nothing breaks."""
    exact = "angle_random_walk: {value: 0 deg/sqrt(h), meaning: exact}"
    text = GYRO.replace("angle_random_walk: 0.005 deg/sqrt(h)", exact)
    document = analyze(write("g.yaml", text))

    assert "gyro.angle_random_walk" not in document["not_given"]
    for row in document["outputs"]:
        (part,) = (
            part
            for part in row["contributions"]
            if part["source"] == "gyro.angle_random_walk"
        )
        assert (part["standard_uncertainty"], part["share"]) == (0.0, 0.0)


def test_nothing_but_zeros(write):
    """A device whose every figure is 0 has no spread, no shares and no failure."""
    text = (
        "name: perfect\ngyro: {errors: {bias_repeatability: 0 deg/h,"
        " scale_factor_repeatability: 0 ppm}}\n"
    )
    file = write("perfect.yaml", text)
    validated = call("analyze", file, "--json", "-", code=0)

    for document in (
        validated.document,
        analyze(file, "--method", "monte-carlo", "--trials", "1000"),
    ):
        for row in document["outputs"]:
            assert row["standard_uncertainty"] == 0.0
            assert {part["share"] for part in row["contributions"]} == {0.0}


def test_faults_of_all_files_come_at_once(write):
    """Two faulty files are reported in one call, each with its position."""
    one = write("one.yaml", "name: x\ngyro: {errors: {bias_stability: 1 arcsec}}\n")
    two = write("two.yaml", "name: y\naccelerometer: {errors: {bias_stabilty: 1 ug}}\n")
    run = call("analyze", one, two, "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert f"{one}:2:" in run.err
    assert f"{two}:2:" in run.err


DERIVED = "gyro.rotation,misalignment"


def test_outputs_are_those_asked_for_in_the_order_of_all():
    """A group, an axis, a bare name, by commas or again; the numbers stay the same."""
    whole = analyze()
    some = analyze("--outputs", "bias.z, gyro.scale_factor", "--outputs", "gyro.bias.x")
    names = [
        f"{one['sensor']}.{one['parameter']}.{one['axis']}" for one in some["outputs"]
    ]

    assert names == [
        *(f"gyro.scale_factor.{axis}" for axis in "xyz"),
        *("gyro.bias.x", "gyro.bias.z", "accelerometer.bias.z"),
    ]
    assert some["settings"]["outputs"] == names
    assert "outputs" not in whole["settings"]
    for name in names:
        assert_allclose(u(some, name), u(whole, name), rtol=1e-13)


def test_derived_outputs_follow_from_the_covariance_of_the_angles():
    """By hand from `covariance`: (yx + zx)/2, gyro less accelerometer, both of all."""
    whole = analyze()
    place = {
        f"{one['sensor']}.{one['axis']}": k
        for k, one in enumerate(whole["outputs"])
        if one["parameter"] == "mounting_angle"
    }
    c = np.zeros(len(whole["outputs"]))
    c[[place["gyro.yx"], place["gyro.zx"]]] = 0.5
    found = analyze("--outputs", DERIVED)
    C = np.array(whole["covariance"])
    assert_allclose(u(found, "gyro.rotation.x"), np.sqrt(c @ C @ c), rtol=1e-12)
    c[[place["accelerometer.yx"], place["accelerometer.zx"]]] = -0.5
    assert_allclose(u(found, "imu.misalignment.x"), np.sqrt(c @ C @ c), rtol=1e-12)
    assert {one["unit"] for one in found["outputs"]} == {"arcsec"}


@pytest.mark.parametrize("method", ["monte-carlo", "simulation"])
def test_every_method_knows_derived_outputs(method, short):
    """Rotation and misalignment within five standard errors of the law's u."""
    n = {"monte-carlo": 20_000, "simulation": 60}[method]
    derived = ("--procedure", short, "--outputs", DERIVED)
    law = analyze(*derived)
    found = analyze("--method", method, "--trials", str(n), *derived)

    for one in law["outputs"]:
        name = f"{one['sensor']}.{one['parameter']}.{one['axis']}"
        assert_allclose(u(found, name), u(law, name), rtol=5.0 / np.sqrt(2.0 * n))
    # The control: angles are no rotation, their u is 1.41 times as large.
    angle = u(analyze(*derived[:2]), "gyro.mounting_angle.yx")
    assert angle / u(found, "gyro.rotation.x") > 1.41 * (1.0 - 5.0 / np.sqrt(2.0 * n))


def test_a_misalignment_has_the_sources_of_both_triads():
    """Each of them stands in the list, those of no effect too; shares sum to 1."""
    found = analyze("--outputs", "misalignment")
    parts = output(found, "imu.misalignment.y")["contributions"]

    assert {one["source"] for one in parts} == {
        "interaction",
        *(f"gyro.{name}" for name in (*CONSTANT, "angle_random_walk")),
        *(f"accelerometer.{name}" for name in (*CONSTANT, "sample_noise")),
    }
    assert_allclose(sum(one["share"] for one in parts), 1.0, rtol=1e-12)


CONSTANT = (
    "bias_repeatability",
    "bias_stability",
    "scale_factor_repeatability",
    "mounting_repeatability",
)


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("gyro.rotatoin",), ("no output", "did you mean 'gyro.rotation'", "Known")),
        (("tilt",), ("no output", "imu.misalignment")),
        (("",), ("no output",)),
        (
            ("rotation.x", "--procedure", "one-axis-rate-table"),
            ("gyro.rotation x", "does not estimate", "gyro.mounting_angle yx, zx"),
        ),
        (
            ("misalignment", "--procedure", "six-positions"),
            ("accelerometer and the gyro", "does not calibrate", "give a device"),
        ),
    ],
)
def test_outputs_that_cannot_be_had_are_refused(args, said):
    """What is not there, not tested or not estimated: where, what lacks, what to do."""
    run = call("analyze", "zhao-2019", "--outputs", *args, code=2)

    for words in ("--outputs", *said):
        assert_says(run.err, words)


def test_a_requirement_is_judged_as_by_report(tmp_path, monkeypatch, write):
    """The verdict stands first, the document holds it, and the exit code stays 0."""
    monkeypatch.chdir(tmp_path)
    write("gyro.yaml", GYRO.replace("0.05 deg/h", "50 deg/h"))
    wanted = ("gyro.yaml", "--requirement", "catalogue-edge", "--no-validate")
    found = call("analyze", *wanted, code=0)
    assert found.out.index("FAILS edge of the catalogue") < found.out.index("Gyro")
    limits = call("analyze", *wanted, "--full").out.partition("\nLimits\n")[2]
    assert "28 deg/h" in limits
    call("report", *wanted, "-o", "a.html", "--json", "a.json")
    stored = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    document = call("analyze", *wanted, "--json", "-").document
    assert document["assessment"] == stored["assessment"]
    assert document["settings"]["reference"] == "next_turn_on"


def test_a_requirement_allows_no_other_reference():
    """An option that contradicts the requirement is refused."""
    wanted = ("--requirement", "catalogue-edge", "--reference", "nominal")
    found = call("analyze", *wanted)
    assert (found.code, found.out) == (2, "")
    assert "next_turn_on" in found.err


def test_in_brief_nothing_is_hidden():
    """Lower bounds, lines that are not given and warnings are said in brief too."""
    found = call("analyze", "hg1700", "--no-validate")
    assert ">= 34 " in found.out
    assert_says(found.out, "Ask for", "gyro bias stability", "lower bounds")
    assert_says(found.out, "Not given", "more could widen these errors")
    warned = call("analyze", "--no-validate", "--age", "1 year")
    assert "Cautions" in warned.out


def test_limits_on_a_mission_alone_ask_for_one():
    """A budget of a calibration has none: the words are those of a comparison."""
    asked = ("zhao-2019", "--requirement", "survey-drone")
    run = call("analyze", *asked, code=2)
    assert "give one with --mission FILE" in run.err
    assert call("compare", *asked, code=2).err.strip() in run.err
