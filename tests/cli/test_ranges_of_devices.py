"""A test beyond the range of a device is bad input, whichever command asks for it."""

from __future__ import annotations

import re

import pytest
from command_line import call
from reading import assert_says

from budget.model.sources import SENSORS

GYRO = """\
gyro:
  errors:
    bias_repeatability: 1 deg/h
    bias_stability: {value: 1 deg/h, correlation_time: 300 s}
    angle_random_walk: 0.1 deg/sqrt(h)
    scale_factor_repeatability: 100 ppm
    mounting_repeatability: 2 arcsec
    g_sensitivity: 1 deg/h/g
"""
ACCELEROMETER = """\
accelerometer:
  errors:
    bias_repeatability: 1 mg
    bias_stability: {value: 1 mg, correlation_time: 300 s}
    velocity_random_walk: 50 ug/sqrt(Hz)
    scale_factor_repeatability: 100 ppm
    mounting_repeatability: 2 arcsec
"""
SHY = {
    "slow": f"range: {{gyro: 10 deg/s, accelerometer: 5 g}}\n{GYRO}{ACCELEROMETER}",
    "weak": f"range: {{gyro: 100 deg/s, accelerometer: 0.5 g}}\n{GYRO}{ACCELEROMETER}",
    "wide": f"range: {{gyro: 20 deg/s, accelerometer: 1 g}}\n{GYRO}{ACCELEROMETER}",
}
SAID = {
    "slow": ("slow", "gyro", "±10 deg/s", "turn x+", "20 deg/s", "Zhao 2019"),
    "weak": ("weak", "accelerometer", "±0.5 g", "x up 1", "0.999 g", "Zhao 2019"),
}
NAVIGATION = ("--requirement", "navigation-grade")
STATED = "environment: none\n"
MILE = """\
name: a mile
limits: {mission: {position: {horizontal: 1 nmi, at: 60 s, probability: 50 %}}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the devices, and a requirement on a mission."""
    path = tmp_path_factory.mktemp("ranges")
    for name, text in SHY.items():
        (path / f"{name}.yaml").write_text(f"name: {name}\n{text}", encoding="utf-8")
    (path / "mile.yaml").write_text(MILE, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", SAID)
@pytest.mark.parametrize(
    "words",
    [
        ("analyze", "{}", "--no-validate"),
        ("analyze", "{}", "--method", "simulation"),
        ("analyze", "{}", "--no-validate", "--missing", "worst"),
        ("report", "{}", "-o", "page.html"),
        ("compare", "{}", "vn-100", *NAVIGATION, "--method", "gum", "--strict"),
        ("allocate", "{}", *NAVIGATION, "--no-validate"),
        ("station", "{}", *NAVIGATION, "--station", "three-axis-table"),
        ("mission", "{}", "--mission", "outage-60-s", "--procedure", "zhao-2019"),
        (
            *("export", "{}", "--to", "kf-gins", "--residual"),
            *("--procedure", "zhao-2019", "-o", "kf-gins.yaml"),
        ),
        ("check", "--save", "one.json", "{}"),
        ("check", "--kind", "allocate", "--save", "one.json", "{}", *NAVIGATION),
    ],
    ids=lambda words: " ".join(words[:1] + words[2:4]),
)
def test_a_test_beyond_the_range_is_bad_input(name, words, folder, monkeypatch):
    """Exit code 2, and which sensor of which device, how far it reads, what asks."""
    monkeypatch.chdir(folder)
    before = {path.name for path in folder.iterdir()}

    run = call(*(word.format(f"{name}.yaml") for word in words), code=2)

    assert run.out == ""
    assert "Traceback" not in run.err
    assert_says(run.err, *SAID[name], "cannot be calibrated")
    assert {path.name for path in folder.iterdir()} == before


def test_as_large_as_the_range_is_no_bad_input(folder):
    """Control: 20 deg/s and 1 g are what the paper's test asks."""
    call("analyze", folder / "wide.yaml", "--no-validate", code=0)


def test_what_nobody_tests_is_not_refused(folder):
    """A unit as its maker calibrates it goes on a mission that it can follow."""
    run = call(
        *("mission", folder / "slow.yaml", "--mission", "outage-60-s"),
        *("--calibration", "factory", "--no-validate"),
        code=0,
    )
    assert "saturates" not in run.out


def test_what_a_report_advises_does_it(folder):
    """A report has pages on a test; the advice is a command that needs none."""
    what = (folder / "slow.yaml", "--mission", "outage-60-s", "--no-validate")
    run = call("report", *what, "-o", folder / "slow.html", code=2)
    (advised,) = re.findall("`budget ([^`]+)`", run.err)
    assert call(*advised.split(), *what).code == 0


def test_a_mission_beyond_the_range_is_warned_of(folder):
    """Which axis, how far it reads, which segment, what that asks."""
    run = call(
        *("mission", folder / "slow.yaml", "--mission", "car-drive", "--no-validate"),
        *("--calibration", "factory"),
        code=0,
    )
    assert_says(run.out, "saturates: gyro z of slow", "±10 deg/s", "segment 5")


def test_a_comparison_names_what_cannot_be_tested_and_leaves_it_out(folder):
    """The others are ranked; the other sensor of the same unit too."""
    names = [folder / f"{name}.yaml" for name in SHY]
    run = call(
        "compare", *names, "vn-100", *NAVIGATION, "--method", "gum", "--json", "-"
    )
    assert run.code in {0, 1}, run.err
    ranked = {(row["name"], row["sensor"]) for row in run.document["devices"]}
    assert ranked == {
        *(("slow", "accelerometer"), ("weak", "gyro")),
        *((name, kind) for name in ("wide", "VN-100") for kind in SENSORS),
    }
    said = [one for one in run.document["warnings"] if "cannot be calibrated" in one]
    assert len(said) == 2
    for name, text in zip(("slow", "weak"), said, strict=True):
        assert_says(text, *SAID[name])


def test_where_none_can_be_tested_nothing_is_met(folder):
    """No limit is met by a sensor that was left out: exit code 1, and 2 without any."""
    easy = folder / "easy.yaml"
    limits = "{gyro: {bias: 1 deg/s}, accelerometer: {bias: 1 g}}"
    easy.write_text(f"name: easy\n{STATED}limits: {limits}\n", encoding="utf-8")

    def code(*names):
        paths = [folder / f"{name}.yaml" for name in names]
        return call("compare", *paths, "--requirement", easy, "--method", "gum").code

    assert [code("wide"), code("slow", "wide"), code("slow")] == [0, 0, 1]
    (folder / "both.yaml").write_text(
        (folder / "slow.yaml").read_text("utf-8").replace("5 g", "0.5 g"), "utf-8"
    )
    assert code("both") == 2


def test_on_a_mission_a_unit_that_cannot_be_tested_is_left_out(folder):
    """Both sensors are needed there; as its maker calibrates it, it is judged."""
    words = ("compare", folder / "slow.yaml", folder / "wide.yaml", "--method", "gum")
    words = (*words, "--requirement", folder / "mile.yaml", "--mission", "outage-60-s")

    test = ("--procedure", "zhao-2019")
    tested = call(*words, *test, "--json", "-").document["devices"]
    as_made = call(*words, "--calibration", "factory", "--json", "-").document

    assert {row["name"] for row in tested} == {"wide"}
    assert {row["name"] for row in as_made["devices"]} == {"slow", "wide"}


def test_validate_says_the_range_as_it_was_read(folder):
    """With both signs, sensor by sensor."""
    run = call("validate", folder / "slow.yaml", code=0)
    assert_says(run.out, "range: gyro ±10 deg/s", "accelerometer ±5 g")


@pytest.mark.slow
def test_the_catalogue_takes_the_paper_s_test():
    """No device that ships is beyond its range at 20 deg/s and 1 g."""
    run = call(
        *("compare", "--catalogue", *NAVIGATION, "--method", "gum", "--json", "-")
    )
    assert run.code in {0, 1}, run.err
    assert [one for one in run.document["warnings"] if "tested" in one] == []
