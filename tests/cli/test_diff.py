"""`budget diff`: two budgets side by side, each difference with its causes."""

from __future__ import annotations

import csv
import io
import re
import shutil
from math import sqrt

import pytest
from command_line import analyze, call, output
from numpy.testing import assert_allclose
from reading import assert_says
from reference_examples import DEVICE, computing_once, store

from budget.resources import shipped

BETTER = DEVICE.replace(
    "repeatability: 0.05 deg/h", "repeatability: 0.03 deg/h"
).replace("value: 0.04 deg/h", "value: 0.02 deg/h")
U = "standard_uncertainty"
_computing_once = pytest.fixture(scope="module", autouse=True)(computing_once)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide two devices and a reference of the first, and work there."""
    monkeypatch.chdir(tmp_path)
    store(tmp_path)
    (tmp_path / "better.yaml").write_text(BETTER, encoding="utf-8")
    return tmp_path


def row_of(document, subject, quantity):
    """Return one difference."""
    (row,) = (
        row
        for row in document["moved"]
        if (row["subject"], row["quantity"]) == (subject, quantity)
    )
    return row


@pytest.mark.usefixtures("folder")
class TestDevices:
    """Two device files."""

    @pytest.mark.slow
    def test_text(self):
        """Names, keys that differ, outputs with both values and the keys' parts."""
        run = call("diff", "imu.yaml", "better.yaml")

        assert (run.code, run.err) == (0, "")
        assert "A is imu.yaml, B better.yaml." in run.out
        assert "device: gyro.errors.bias_repeatability: 0.05 deg/h -> 0.03" in run.out
        table = run.out[run.out.index("because") :].splitlines()
        assert table[1] == "Gyro bias, u [deg/h]"
        assert table[2].split()[:3] == ["all", "0.0564", "0.0336"]
        assert "accelerometer" not in run.out.casefold().replace("imu", "")

    def test_numbers_are_those_of_analyze(self):
        """Both sides are what `budget analyze` says of each device."""
        document = call("diff", "imu.yaml", "better.yaml", "--json", "-").document
        row = row_of(document, "gyro.bias.y", U)

        assert (document["command"], document["kind"]) == ("diff", "analyze")
        for name, value in (("imu.yaml", row["before"]), ("better.yaml", row["after"])):
            there = output(analyze(name), "gyro.bias.y")
            assert_allclose(value, there[U], rtol=1e-9)

    def test_causes_are_exchanged_one_at_a_time(self, folder):
        """The amount of a key is what analyze gives with this one key exchanged."""
        document = call("diff", "imu.yaml", "better.yaml", "--json", "-").document
        row = row_of(document, "gyro.bias.y", U)

        texts = {
            "gyro.errors.bias_repeatability": ("0.05 deg/h", "0.03 deg/h"),
            "gyro.errors.bias_stability": ("value: 0.04", "value: 0.02"),
        }
        assert len(row["causes"]) == len(texts)
        for cause in row["causes"]:
            key = cause["change"].split(": ")[1]
            (folder / "one.yaml").write_text(DEVICE.replace(*texts[key], 1))
            alone = output(analyze("one.yaml"), "gyro.bias.y")[U]
            assert_allclose(cause["amount"], alone - row["before"], rtol=1e-6)

    def test_largest_first(self):
        """Differences fall, over A's standard uncertainty of the output."""
        document = call("diff", "imu.yaml", "better.yaml", "--json", "-").document
        u = {
            row["subject"]: row["before"]
            for row in document["moved"]
            if row["quantity"] == U
        }
        sizes = [
            abs(row["difference"]) / u[row["subject"]]
            for row in document["moved"]
            if row["unit"] == "deg/h" and row["difference"] is not None
        ]
        assert len(sizes) > 10
        assert sizes == sorted(sizes, reverse=True)

    def test_what_a_missing_line_would_add_to_is_marked(self, folder):
        """A gyro bias without its stability has this u or more, as analyze says."""
        (folder / "less.yaml").write_text(
            DEVICE.replace(
                "    bias_stability: {value: 0.04 deg/h, correlation_time: 300 s}\n", ""
            )
        )
        assert output(analyze("less.yaml"), "gyro.bias.x")["lower_bound"]
        run = call("diff", "imu.yaml", "less.yaml")
        table = run.out[run.out.index("Gyro bias, u") :].splitlines()
        assert re.fullmatch(r"all +0\.\d+ +>= 0\.\d+ .*", table[1]), table[1]
        assert ">=, <=: this or worse" in " ".join(run.out.split())
        assert ">=" not in call("diff", "imu.yaml", "better.yaml").out

    def test_turned_round(self):
        """B against A has the same differences with the other sign."""
        one = call("diff", "imu.yaml", "better.yaml", "--json", "-").document
        other = call("diff", "better.yaml", "imu.yaml", "--json", "-").document
        a, b = (row_of(d, "gyro.bias.x", U) for d in (one, other))
        assert (a["before"], a["after"]) == (b["after"], b["before"])
        assert_allclose(a["difference"], -b["difference"], rtol=1e-12)

    def test_alike(self):
        """A device against itself: nothing differs, exit code 0."""
        run = call("diff", "imu.yaml", "imu.yaml")
        assert (run.code, run.out.startswith("0 of ")) == (0, True)

    @pytest.mark.slow
    def test_variants_and_shipped_ones(self):
        """FILE#VARIANT and bare names; many keys are counted, not all listed."""
        run = call("diff", "zhao-2019", "hg4930#C", code=0)
        said = " ".join(run.out.split())
        key = "gyro.errors.mounting_repeatability"
        assert f"{key}: 2 arcsec -> {{value: 750 μrad, meaning: 1 sigma}}" in said
        assert_says(run.out, "more that move no number", "--json")
        assert "  x 77  " in run.out

    @pytest.mark.slow
    def test_another_sensor(self):
        """A gyro alone against an IMU: the accelerometer's numbers are new."""
        document = call("diff", "ltys11cj1x", "hg4930#C", "--json", "-").document
        new = [row for row in document["moved"] if row["before"] is None]
        assert {row["subject"].split(".")[0] for row in new} == {
            *("gyro", "accelerometer"),
        }

    @pytest.mark.slow
    def test_settings(self):
        """Reference, coverage, procedure and single sources are those asked for."""
        args = ("--reference", "next_turn_on", "--coverage", "0.5", "--json", "-")
        document = call("diff", "imu.yaml", "better.yaml", *args).document
        row = row_of(document, "gyro.bias.x", "interval_high")
        there = analyze("imu.yaml", *args[:4])
        assert_allclose(
            row["before"], output(there, "gyro.bias.x")["interval"][1], rtol=1e-9
        )
        document = call(
            *("diff", "imu.yaml", "better.yaml", "--only", "bias_stability"),
            *("--json", "-"),
        ).document
        (causes,) = {tuple(c["change"] for c in r["causes"]) for r in document["moved"]}
        assert len(causes) == 1

    def test_two_keys_that_act_together(self, folder):
        """A half-width with its shape is one change, and it is the whole cause."""
        figure = "{value: 0.05 deg/h, meaning: max, distribution: triangular}"
        text = DEVICE.replace("repeatability: 0.05 deg/h", f"repeatability: {figure}")
        (folder / "max.yaml").write_text(text, encoding="utf-8")
        run = call("diff", "imu.yaml", "max.yaml")

        said = " ".join(run.out.split())
        assert f"1. device: gyro.errors.bias_repeatability: 0.05 deg/h -> {figure}" in (
            said
        )
        assert "number)" not in said
        rows = run.out[run.out.index("because") :].splitlines()
        assert rows[2].split()[0] == "all"
        assert rows[2].split()[-1] == "1"

    def test_a_value_in_the_place_of_an_axis(self, folder):
        """One value for an axis of its own explains that axis too."""
        own = "bias_repeatability: {value: 50 ug, axes: {z: 80 ug}}"
        line = "bias_repeatability: 37 ug"
        for name, figure in (("a", own), ("b", "bias_repeatability: 500 ug")):
            text = DEVICE.replace(line, figure)
            (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
        document = call("diff", "a.yaml", "b.yaml", "--json", "-").document

        for axis in "xyz":
            row = row_of(document, f"accelerometer.bias.{axis}", U)
            (cause,) = row["causes"]
            assert_allclose(cause["amount"], row["difference"], rtol=1e-9)
            assert row["together"] is None
            assert row["because"] == "accelerometer.errors.bias_repeatability 100 %"

    def test_what_the_parts_leave_is_done_together(self):
        """Parts and what they do together add up to the difference."""
        document = call("diff", "imu.yaml", "better.yaml", "--json", "-").document
        row = row_of(document, "gyro.bias.y", U)

        amounts = [cause["amount"] for cause in row["causes"]]
        assert_allclose(sum(amounts) + row["together"], row["difference"], rtol=1e-9)
        part = round(100.0 * row["together"] / row["difference"])
        assert part > 3  # less is not worth a word
        assert row["because"].endswith(f"; together {part} %")
        run = call("diff", "imu.yaml", "better.yaml")
        assert_says(run.out, f"together: {part} %", "all changes", "at once")

    @pytest.mark.parametrize("width", ["40", "80", "120"])
    def test_fits(self, width):
        """No line is longer than the terminal is wide."""
        run = call("diff", "zhao-2019", "stim300#5g", COLUMNS=width, code=0)
        assert max(map(len, run.out.splitlines())) <= int(width)
        # However narrow, the same numbers.
        for text in ("0.056", "8.074", "x 143"):
            assert text in run.out.split("Gyro bias, u")[1].splitlines()[1]

    def test_csv(self):
        """One row for each difference, in the same order as the JSON document."""
        run = call("diff", "imu.yaml", "better.yaml", "--csv", "-")
        rows = list(csv.DictReader(io.StringIO(run.out)))
        document = call("diff", "imu.yaml", "better.yaml", "--json", "-").document
        assert [row["subject"] for row in rows] == [
            row["subject"] for row in document["moved"]
        ]
        assert float(rows[0]["difference"]) == document["moved"][0]["difference"]


@pytest.mark.usefixtures("folder")
class TestReferences:
    """References, and devices beside them."""

    @pytest.mark.slow
    def test_a_reference_and_a_device(self):
        """The device is analyzed with the settings of the reference."""
        save = ("check", "--save", "later.json", "imu.yaml")
        assert call(*save, "--reference", "next_turn_on").code == 0
        document = call("diff", "later.json", "better.yaml", "--json", "-").document
        row = row_of(document, "gyro.bias.x", U)
        there = analyze("better.yaml", "--reference", "next_turn_on")
        assert_allclose(row["after"], output(there, "gyro.bias.x")[U], rtol=1e-9)

    def test_two_references(self):
        """What differs is the setting, and it explains the difference."""
        save = ("check", "--save", "later.json", "imu.yaml")
        assert call(*save, "--reference", "next_turn_on").code == 0
        document = call("diff", "ref.json", "later.json", "--json", "-").document
        (change,) = document["changes"]
        assert (change["where"], change["key"]) == ("settings", "reference")
        row = row_of(document, "gyro.bias.x", U)
        assert_allclose(row["causes"][0]["amount"], row["difference"], rtol=1e-9)

    def test_law_against_trials(self):
        """By law and by trials nothing differs: flat scale factors end by trials."""
        args = ("--method", "monte-carlo", "--trials", "20000")
        assert call("check", "--save", "mc.json", "imu.yaml", *args).code == 0
        document = call("diff", "ref.json", "mc.json", "--json", "-").document
        assert [c["key"] for c in document["changes"]] == ["method", "trials"]
        assert document["moved"] == []
        # The scale factors are uniform: 95 % of them are within 1.65 u, not 1.96 u.
        row = output(analyze("imu.yaml"), "gyro.scale_factor.x")
        assert row["interval_by"] == "monte-carlo"
        assert_allclose(row["interval"][1], 0.95 * sqrt(3.0) * row[U], rtol=0.02)

    def test_the_stored_numbers_count(self, folder):
        """A reference is what is stored, whatever its files have become."""
        (folder / "imu.yaml").write_text(BETTER)
        assert call("diff", "ref.json", "imu.yaml", "--json", "-").document["moved"]
        (folder / "imu.yaml").unlink()
        assert call("diff", "ref.json", "better.yaml").code == 0

    def test_shipped_references_by_name(self):
        """Both formulas of the paper: the one key, and only the gyro bias differs."""
        names = ("zhao-2019-corrected-nominal", "zhao-2019-eq4-nominal")
        run = call("diff", *names, "--json", "-")
        acting = [c for c in run.document["changes"] if c["acts"]]
        assert [(c["key"], c["before"], c["after"]) for c in acting] == [
            ("formulas", "corrected", "paper")
        ]
        own = [row for row in run.document["moved"] if row["quantity"] != "correlation"]
        assert {row["subject"].rpartition(".")[0] for row in own} == {"gyro.bias"}

    def test_comparisons(self, folder):
        """Two comparisons are held together device by device."""
        shutil.copytree(shipped("specs") / "references", folder / "refs")
        args = ("--kind", "compare", "--requirement", "navigation-grade")
        for name, device in (("a", "imu.yaml"), ("b", "imu.yaml")):
            assert (
                call(
                    "check", "--save", f"{name}.json", device, *args, "--method", "gum"
                )
            ).code == 0
            (folder / "imu.yaml").write_text(BETTER)
        run = call("diff", "a.json", "b.json", code=0)
        assert "gyro, utilisation\nimu.yaml" in run.out


@pytest.mark.usefixtures("folder")
class TestBadCalls:
    """Exit code 2."""

    @pytest.mark.parametrize(
        ("args", "said"),
        [
            (("imu.yaml",), "B"),
            (("imu.yaml", "no.yaml"), "no such file"),
            (("imu.yaml", "no.json"), "no such file"),
            (("imu.yaml", "hg4930"), "\nhg4930:20:1: variants: the base is abstract"),
            (("ref.json", "imu.yaml", "--reference", "nominal"), "has its own"),
            (("imu.yaml", "better.yaml", "--only", "nothing"), "is no source"),
            (("ref.json", "allocate-navigation-grade"), "of kind allocate"),
            (("imu.yaml", "compare-catalogue-edge"), "is a device, and the reference"),
            (("imu.yaml", "better.yaml", "--json", "imu.yaml"), "would be overwritten"),
            (("imu.yaml", "better.yaml", "--json", "-", "--csv", "-"), "both write"),
        ],
    )
    def test_refused(self, args, said):
        """What is wrong is said, and nothing is printed."""
        run = call("diff", *args)
        assert (run.code, run.out) == (2, "")
        assert said in f"\n{run.err}"
