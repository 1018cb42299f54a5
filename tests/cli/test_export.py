"""`budget export`: the file alone on stdout, what it lacks on stderr, its options."""

from __future__ import annotations

import csv
import io
import json

import pytest
import yaml
from command_line import call
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.studies.export.template import targets

KALIBR = ("export", "hg4930#A", "--to", "kalibr", "--rate", "200")


def test_every_target_can_be_asked_for():
    """The choices of `--to` are the templates, in capitals too; others are refused."""
    shown = call("export", "--help", COLUMNS="300").out
    for name in targets():
        assert name in shown
        assert (
            call("export", "hg4930#A", "--to", name.upper(), "--rate", "200").code == 0
        )
    run = call("export", "hg4930#A", "--to", "ekf2", code=2)
    assert_says(run.err, "ekf2", "kalibr", "nav-toolkit")


def test_stdout_is_the_file_and_stderr_what_it_cannot_hold():
    """A pipe gets YAML and nothing else; a person hears what is not in it."""
    run = call(*KALIBR, code=0)
    assert yaml.safe_load(run.out)["update_rate"] == 200.0
    assert_says(run.err, "Kalibr cannot hold", "gyro.bias_repeatability", "proxy")


def test_a_file_is_written_and_the_values_are_shown(tmp_path):
    """-o: the same bytes in the file, a table and the lists on stdout."""
    path = tmp_path / "imu.yaml"
    run = call(*KALIBR, "-o", path, code=0)
    assert path.read_text(encoding="utf-8") == call(*KALIBR).out
    assert_says(run.out, "gyroscope_noise_density", "1.74533e-5", "cannot hold")
    assert "written" in run.err


def test_documents_have_the_values_in_full(tmp_path):
    """--json - and --csv: key, value, unit and lines, as in the file."""
    path = tmp_path / "a.csv"
    run = call(*KALIBR, "--json", "-", "--csv", path)
    document = run.document
    told = yaml.safe_load(call(*KALIBR).out)
    assert document["command"] == "export"
    assert document["settings"]["target"] == "kalibr"
    for row in document["entries"]:
        assert row["value"] == told[row["key"]]
        assert row["from"]
    rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))
    values = {row["key"]: float(row["value"]) for row in rows}
    assert values == {row["key"]: row["value"] for row in document["entries"]}
    assert document["not_held"]
    assert any("proxy" in note for note in document["notes"])


def test_the_residual_names_its_procedure():
    """--residual with a procedure: it is an input, and u of the later turn-on."""
    words = ("export", "hg4930#A", "--to", "psins", "--residual")
    run = call(*words, "--procedure", "twelve-positions", "--json", "-", code=0)
    document = json.loads(run.out)
    assert document["inputs"]["procedure"]["name"] == "twelve-positions.yaml"
    assert document["settings"]["reference"] == "next_turn_on"
    (step,) = {row["steps"][0] for row in document["entries"] if row["key"] == "dKAii"}
    assert_says(step, "next turn-on", "law of propagation")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--to", "kalibr"), ("--rate",)),
        (("--to", "ekf2"), ("kalibr", "nav-toolkit")),
        (("--to", "kalibr", "--rate", "0"), ("sampling rate", "200")),
        (("--to", "kalibr", "--rate", "5 s"), ("Hz",)),
        (("--to", "kalibr", "--rate", "nan"), ("Hz",)),
        (("--to", "gtsam", "--inflate", "0.5"), ("factor", "0.5")),
        (("--to", "gtsam", "--inflate", "much"), ("factor",)),
        (("--to", "gtsam", "--procedure", "zhao-2019"), ("--residual",)),
        (("--to", "gtsam", "--station", "ideal"), ("--residual",)),
        (("--to", "gtsam", "--age", "1 year"), ("--residual",)),
    ],
)
def test_a_bad_call_says_what_to_give(more, words):
    """Exit code 2, nothing on stdout."""
    run = call("export", "hg4930#A", *more)
    assert (run.code, run.out) == (2, "")
    assert_says(run.err, *words)


def test_a_missing_line_is_named():
    """adis16495-1 prints no noise of its accelerometers: no file, exit code 2."""
    run = call("export", "adis16495-1", "--to", "gtsam")
    assert (run.code, run.out) == (2, "")
    assert_says(
        run.err, "accelerometer_covariance", "accelerometer.velocity_random_walk"
    )


@pytest.mark.parametrize("rate", ["200", "200 Hz", "0.2 kHz", "2e2"])
def test_a_rate_may_have_a_unit(rate):
    """All of them are 200 Hz."""
    run = call("export", "hg4930#A", "--to", "kalibr", "--rate", rate)
    assert yaml.safe_load(run.out)["update_rate"] == 200.0


def test_a_residual_ages(tmp_path):
    """With --age the bias that is left is larger by what it goes in that time."""
    path = put(
        tmp_path / "imu.yaml",
        "name: a\n"
        "gyro: {errors: {bias_repeatability: 1 deg/h, bias_stability: 1 deg/h, "
        "angle_random_walk: 1 deg/sqrt(h), "
        "ageing: {value: 3 deg/h, horizon: 1 year}}}\n"
        "accelerometer: {errors: {bias_repeatability: 1 mg, bias_stability: 1 mg, "
        "ageing: {value: 1 mg, horizon: 1 year}, "
        "velocity_random_walk: 1 m/s/sqrt(h)}}\n",
    )
    words = ("export", path, "--to", "psins", "--residual", "--json", "-")

    def bias(*more):
        rows = call(*words, *more).document["entries"]
        return next(row["value"] for row in rows if row["key"] == "eb")

    new, old = bias(), bias("--age", "1 year")
    assert_allclose(old**2 - new**2, 9.0, rtol=1e-6)
