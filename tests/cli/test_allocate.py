"""`budget allocate`: documents, files, exit codes, and what people read."""

from __future__ import annotations

import csv
import io
import re
from math import radians
from statistics import NormalDist

import numpy as np
import pytest
from command_line import call, output
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.inputs import load_device
from budget.resources import shipped
from budget.studies.allocation import allocate
from budget.studies.allocation.longer_tests import find_longer_tests

pytestmark = pytest.mark.usefixtures("drawn_once")

FAST = ("--requirement", "navigation-grade", "--no-validate")

# Axes, shapes, another g, a variant, several correlation times, a zero and remarks.
ODD = """
name: "Odd: device, no 1"
technology: optical
gravity_unit: 9.80708 m/s^2
gyro:
  nominal: {bias: {x: 1 deg/h, z: -3 deg/h}, mounting_angle: 30 arcsec}
  errors:
    bias_repeatability: {value: 0.05 \u00b0/h, meaning: max}
    bias_stability:
      axes:
        x: {value: 0.01 deg/h, correlation_time: 100 s}
        y: {value: 0.02 deg/h, correlation_time: 200 s}
        z: 0.03 deg/h
    angle_random_walk: 0.002 deg/sqrt(h)
    scale_factor_repeatability: {value: 30 ppm, meaning: 3 sigma}
    scale_factor_asymmetry: 0 ppm
    mounting_repeatability: {value: 3 arcsec, axes: {xy: 4 arcsec}}
accelerometer:
  nominal: {bias: 2 mg}
  errors:
    bias_repeatability: {value: 50 \u00b5g, axes: {z: 80 \u00b5g}}
    bias_stability: {value: 10 ug, correlation_time: 100 s}
    velocity_random_walk: 20 ug/sqrt(Hz)
    sample_noise: {value: 100 ug, adds_to: velocity_random_walk}
    scale_factor_repeatability: {value: 60 ppm, meaning: max, distribution: arcsine}
    mounting_repeatability: 3 arcsec
"""


@pytest.fixture
def odd(tmp_path):
    """Write a device file with everything that a writer can get wrong."""
    return put(tmp_path / "odd.yaml", ODD)


def document(*args):
    """Return the JSON document of an allocation that succeeds."""
    run = call("allocate", *FAST, *args, "--json", "-", code=0)
    return run.document


def test_the_document_has_the_fixed_keys():
    """Feasible and the six keys of every source stand there, in the file's units."""
    found = document("--strategy", "equal")

    assert (found["schema"], found["command"]) == ("budget/1", "allocate")
    assert found["feasible"] is True
    assert len(found["sources"]) == 10
    for row in found["sources"]:
        assert {"source", "now", "allowed", "unit", "binding_output", "at_ceiling"} <= (
            row.keys()
        )
    first = found["sources"][0]
    assert (first["source"], first["unit"]) == ("gyro.bias_repeatability", "deg/h")
    assert_allclose(first["now"], 0.05, rtol=1e-15)
    assert first["binding_output"] == "gyro.bias.z"


@pytest.mark.slow
def test_the_csv_has_a_row_for_each_source():
    """The CSV and the JSON document hold the same numbers."""
    run = call("allocate", *FAST, "--csv", "-")
    rows = list(csv.DictReader(io.StringIO(run.out)))
    sources = document()["sources"]

    assert [row["source"] for row in rows] == [row["source"] for row in sources]
    for row, source in zip(rows, sources, strict=True):
        assert float(row["allowed"]) == source["allowed"]


def test_without_a_device_the_built_in_one_is_named():
    """The built-in device is said on stderr, as everywhere."""
    assert "zhao-2019" in call("allocate", *FAST).err


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["proportional", "equal", "cost"])
def test_the_written_device_meets_the_requirement(odd, tmp_path, strategy):
    """Read back by analyze, its errors end within the limits, by the law at them.

    Limits are shared out by the law, to 1e-8.
    """
    path = tmp_path / "allocated.yaml"
    allotted = document(odd, "--strategy", strategy, "--write", path)
    run = call(
        *("analyze", path, "--reference", "next_turn_on", "--no-validate"),
        *("--json", "-"),
        code=0,
    )

    binding = 0
    for row in allotted["outputs"]:
        found = output(run.document, row["output"])
        assert max(abs(end) for end in found["interval"]) <= row["limit"]
        reach = NormalDist().inv_cdf(0.975) * found["standard_uncertainty"]
        used = (abs(found["mean"]) + reach) / row["limit"]
        assert_allclose(used, row["utilisation_allowed"], rtol=1e-8)
        binding += row["binding"]
    assert binding > 0


def test_the_written_device_reads_as_far_as_the_maker_says(tmp_path):
    """So one that a mission saturates does so when its lines are allocated, too.

    A decimal stays one: 0.007, not 0.006999999999999999.
    """
    device, path = tmp_path / "slow.yaml", tmp_path / "allocated.yaml"
    text = (shipped("specs") / "devices" / "zhao-2019.yaml").read_text("utf-8")
    device.write_text(
        text + "range: {gyro: 25 deg/s, accelerometer: {x: 3 g, y: 4 g, z: 7 g}}\n",
        encoding="utf-8",
    )
    call("allocate", device, *FAST, "--write", path, code=0)
    gyro, accelerometer = load_device(path).sensors

    assert_allclose(gyro.range, np.full(3, radians(25.0)), rtol=1e-15)
    assert_allclose(accelerometer.range, load_device(device).sensors[1].range)
    written = path.read_text("utf-8")
    assert "range:" in written
    assert not re.search("99999999|00000000", written)


def test_the_written_device_keeps_what_was_not_allocated(odd, tmp_path):
    """Nominal values, shapes, axes, times, absent lines and origins come back."""
    path = tmp_path / "allocated.yaml"
    document(odd, "--write", path)
    before, after = load_device(odd), load_device(path)

    for was, is_now in zip(before.sensors, after.sensors, strict=True):
        assert is_now.not_given == was.not_given
        assert_allclose(is_now.nominal_bias, was.nominal_bias, rtol=1e-14, atol=1e-30)
        assert_allclose(
            is_now.nominal_mounting_angle,
            was.nominal_mounting_angle,
            rtol=1e-14,
            atol=1e-30,
        )
        for old, new in zip(was.lines, is_now.lines, strict=True):
            assert new.distributions == old.distributions
            assert new.unit == old.unit
            if old.correlation_time is not None:
                assert_allclose(new.correlation_time, old.correlation_time, rtol=1e-15)
            if old.u.any():
                assert_allclose(new.u / new.u[0], old.u / old.u[0], rtol=1e-14)
            else:
                assert not new.u.any()
    notes = " ".join(after.notes.split())
    for part in ("navigation grade", "95 %", "next_turn_on", "Zhao 2019", "sha256"):
        assert part in notes
    assert call("validate", path).code == 0


@pytest.mark.slow
def test_a_corrected_device_meets_by_monte_carlo(tmp_path):
    """Where shapes are not normal the trials end at the limit, the law beyond it.

    Here those of an accelerometer alone: it has an arcsine beside a half-width.
    """
    odd, path = tmp_path / "odd.yaml", tmp_path / "allocated.yaml"
    head, _, tail = ODD.partition("gyro:\n")
    _, mark, tail = tail.partition("accelerometer:\n")
    odd.write_text(f"{head}{mark}{tail}", encoding="utf-8")
    run = call(
        *("allocate", odd, "--requirement", "navigation-grade", "--seed", "1"),
        *("--strategy", "equal", "--write", path, "--json", "-"),
    )
    allotted = run.document
    corrected = {row["output"] for row in allotted["checks"] if row["corrected"]}
    trials = ("--method", "monte-carlo", "--trials", "250000")
    used = {}
    for name, method in (("trials", trials), ("law", ("--no-validate",))):
        found = call(
            "analyze", path, "--reference", "next_turn_on", *method, "--json", "-"
        ).document
        rows = [
            (output(found, row["output"]), row["limit"])
            for row in allotted["outputs"]
            if row["output"] in corrected
        ]
        # The control: mean +- k u of the normal law, which analyze no longer prints.
        used[name] = max(
            max(abs(end) for end in row["interval"]) / limit
            if name == "trials"
            else (abs(row["mean"]) + 1.959964 * row["standard_uncertainty"]) / limit
            for row, limit in rows
        )

    assert corrected
    assert "--method monte-carlo" in load_device(path).notes
    # One standard error of an interval end of 250 000 trials is 0.27 % of it.
    assert abs(used["trials"] - 1.0) < 4 * 0.0027
    assert used["law"] > 1.02


@pytest.mark.slow
def test_two_files_make_one_device(odd, tmp_path):
    """A gyro and an accelerometer of two files are written into one."""
    gyro, accelerometer = tmp_path / "g.yaml", tmp_path / "a.yaml"
    head, mark, tail = ODD.partition("accelerometer:\n")
    gyro.write_text(head, encoding="utf-8")
    start = "name: Other\ntechnology: optical\ngravity_unit: 9.80708 m/s^2\n"
    accelerometer.write_text(start + mark + tail, encoding="utf-8")
    path = tmp_path / "both.yaml"

    apart = document(gyro, accelerometer, "--write", path)
    together = document(odd)

    assert len(load_device(path).sensors) == 2
    for one, other in zip(apart["sources"], together["sources"], strict=True):
        assert one["allowed"] == other["allowed"]


def test_a_bound_has_the_g_of_the_device(odd):
    """What --max holds a line to is in the same g as the line: 2 ug is its 2 ug."""
    held = document(odd, "--max", "accelerometer.bias_stability=2 ug")

    (row,) = (
        row
        for row in held["sources"]
        if row["source"] == "accelerometer.bias_stability"
    )
    assert_allclose(row["allowed"], 2.0, rtol=1e-12)


def test_infeasible_exits_1_and_writes_nothing(tmp_path):
    """With bias stability held no file appears, and the reason is on stdout."""
    files = [tmp_path / name for name in ("d.yaml", "r.json", "r.csv")]
    run = call(
        *("allocate", *FAST, "--fix", "gyro.bias_stability"),
        *("--write", files[0], "--json", files[1], "--csv", files[2]),
        code=1,
    )

    assert not any(path.exists() for path in files)
    assert_says(run.out, "cannot be met", "gyro bias z: 482 %", "limit 0.01 deg/h")
    assert_says(run.out, "bias stability 2319 %", "more than 0.0482 deg/h")
    assert_says(run.out, "dwell of 9200 s", "300 s")


def test_infeasible_says_so_in_the_document():
    """On stdout the document has feasible false, and null for what has no answer."""
    run = call("allocate", *FAST, "--fix", "gyro.bias_stability", "--json", "-", code=1)

    assert run.document["feasible"] is False
    by_name = {row["source"]: row["allowed"] for row in run.document["sources"]}
    assert by_name["gyro.bias_repeatability"] is None
    assert by_name["accelerometer.bias_repeatability"] > 0.0
    assert {row["output"] for row in run.document["relaxations"]} == {
        f"gyro.bias.{axis}" for axis in "xyz"
    }


def test_max_takes_any_unit_of_the_line():
    """A ceiling in deg/s counts in deg/h, and the line at it is marked."""
    rows = document(
        "--strategy", "equal", "--max", "gyro.angle_random_walk=1e-6 deg/sqrt(s)"
    )
    (row,) = (r for r in rows["sources"] if r["source"] == "gyro.angle_random_walk")

    assert_allclose(row["allowed"], 1e-6 * 60.0, rtol=1e-12)
    assert row["at_ceiling"] is True


@pytest.mark.parametrize("sides", ["", ", density: one-sided", ", density: two-sided"])
def test_a_density_stays_in_the_terms_of_the_file(odd, tmp_path, sides):
    """Now, allowed and --max are densities as the maker prints them; the walk is N."""
    figure = f"{{value: 20 ug/sqrt(Hz){sides}}}"
    text = ODD.replace("20 ug/sqrt(Hz)", figure).replace("9.80708", "9.80665")
    odd.write_text(text, encoding="utf-8")
    name, path = "accelerometer.velocity_random_walk", tmp_path / "out.yaml"
    rows = document(
        odd, "--max", f"{name}=1 ug/sqrt(Hz)", "--write", path, "--strategy", "equal"
    )["sources"]
    (row,) = [row for row in rows if row["source"] == name]
    assert_allclose([row["now"], row["allowed"]], [20.0, 1.0], rtol=1e-12)
    before, after = (
        load_device(one).accelerometer.line("velocity_random_walk")
        for one in (odd, path)
    )
    assert after.density == before.density
    assert_allclose(after.u, before.u / 20.0, rtol=1e-9)


def test_costs_choose_their_strategy(tmp_path):
    """A costs file makes the strategy cost, and the multipliers are told."""
    path = put(
        tmp_path / "costs.yaml",
        "costs: {gyro.bias_stability: {a: 1, p: 1, u_ref: 0.04 deg/h}, "
        "gyro.angle_random_walk: {a: 3, p: 2}}\n",
    )
    found = document("--costs", path)

    assert found["settings"]["strategy"] == "cost"
    assert found["inputs"]["costs"]["name"] == "costs.yaml"
    gyro = found["costs"][0]
    assert gyro["is_optimal"] is True
    assert gyro["savings"][0]["outputs"] == ["gyro.bias.z"]
    assert gyro["savings"][0]["saves"] > 0.0


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--fix", "gyro.bias_stabilty"), "did you mean 'gyro.bias_stability'"),
        (("--max", "bias_stability"), "expected SOURCE=VALUE"),
        (("--max", "gyro.bias_stability=3 ppm"), "expected an angular rate"),
        (("--max", "gyro.bias_stability=0 deg/h"), "expected a value above 0"),
        (("--write", "device.json"), "ends in .yaml"),
        (("--json", "-", "--csv", "-"), "would both write to stdout"),
    ],
)
def test_a_bad_call_is_refused(args, words):
    """Exit code 2, nothing on stdout, and what to do instead."""
    run = call("allocate", *FAST, *args)

    assert (run.code, run.out) == (2, "")
    assert words in run.err


def test_a_missing_requirement_is_a_bad_call():
    """Without a requirement there is nothing to allocate."""
    run = call("allocate", code=2)
    assert "--requirement" in run.err


@pytest.fixture
def gyro(tmp_path):
    """Write a device of one gyro, half as dear as two sensors."""
    return put(
        tmp_path / "gyro.yaml",
        "name: g\n"
        "gyro: {errors: {bias_repeatability: 0.05 deg/h, "
        "angle_random_walk: 0.005 deg/sqrt(h)}}\n",
    )


@pytest.mark.slow
def test_the_same_inputs_give_the_same_bytes(gyro, monkeypatch):
    """Twice the same call, Monte Carlo included, gives the same document."""
    monkeypatch.setattr(allocate, "find_longer_tests", find_longer_tests)
    args = ("allocate", gyro, "--requirement", "navigation-grade", "--json", "-")
    assert call(*args).out == call(*args).out


@pytest.mark.parametrize("columns", ["40", "80"])
def test_no_line_is_wider_than_the_terminal(columns, monkeypatch):
    """At 40 and 80 columns every line fits."""
    import command_line

    monkeypatch.setitem(command_line.TERMINAL, "COLUMNS", columns)
    run = call("allocate", *FAST)

    assert max(len(line) for line in run.out.splitlines()) <= int(columns)


@pytest.mark.parametrize("errors", ["", " {bias_repeatability: 0 deg/h}"])
@pytest.mark.parametrize("strategy", ["proportional", "equal", "cost"])
def test_a_device_without_any_error_has_nothing_to_share(tmp_path, errors, strategy):
    """No line, or only zeros: feasible, said in a warning, and nothing matches it.

    The code is 1: nobody can say whether it meets.
    """
    path = tmp_path / "bare.yaml"
    part = f"{{errors:{errors}}}" if errors else "{}"
    path.write_text(f"name: Bare\ngyro: {part}\n", encoding="utf-8")
    run = call("allocate", path, *FAST, "--strategy", strategy, "--json", "-", code=1)
    found = run.document

    assert found["feasible"] is True
    assert {one["verdict"] for one in found["standings"]} == {"undecidable"}
    assert any("nothing to allocate" in text for text in found["warnings"])
    assert found["devices"] == []


@pytest.mark.slow
def test_report_has_a_section_on_the_allocation(gyro, tmp_path):
    """`budget report --allocate` adds what each line may be; alone it is exit 2."""
    page = tmp_path / "report.html"
    call(
        *("report", gyro, "--requirement", "navigation-grade", "--allocate"),
        *("--no-validate", "-o", str(page)),
        code=0,
    )
    assert "Allowable specification values" in page.read_text(encoding="utf-8")

    without = call("report", "--allocate", "-o", str(tmp_path / "other.html"), code=2)
    assert "--requirement" in without.err
    assert not (tmp_path / "other.html").exists()


@pytest.mark.slow
def test_what_is_written_for_a_mission_does_not_fail(tmp_path, monkeypatch):
    """How good the gyro must be for three miles an hour: by compare it is enough."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mile.yaml").write_text(
        "name: three miles an hour\n"
        "limits: {mission: {position: {horizontal: 3 nmi, at: 1 h, "
        "probability: 50 %}}}\n",
        encoding="utf-8",
    )
    limits = ("--requirement", "mile.yaml", "--mission", "bench")

    call("allocate", *limits, "--no-validate", "--write", "new.yaml", code=0)
    before = call("compare", "zhao-2019", *limits, "--method", "gum", "--json", "-")
    after = call("compare", "new.yaml", *limits, "--method", "gum", "--json", "-")

    (old,), (new,) = before.document["devices"], after.document["devices"]
    assert old["verdict"] == "fails"
    assert new["verdict"] in {"meets", "undecided"}
    assert_allclose(new["utilisation"], 1.0, rtol=1e-4)
