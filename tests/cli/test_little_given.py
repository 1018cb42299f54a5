"""Units of which nothing, only zeros, one line or one axis is given, everywhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from command_line import call

pytestmark = pytest.mark.usefixtures("drawn_once")

NOISE = "{sample_noise: 1 deg/h}"
ZEROS = (
    "bias_repeatability: 0 {}, bias_stability: 0 {}, mounting_repeatability: 0 arcsec"
)
UNITS = {
    "nothing.yaml": ("{}", "{}"),
    "zeros.yaml": (
        f"{{{ZEROS.format('deg/h', 'deg/h')}}}",
        f"{{{ZEROS.format('ug', 'ug')}}}",
    ),
    "line.yaml": (NOISE, "{}"),
    "axis.yaml": (
        "{bias_repeatability: {axes: {x: 1 deg/h, y: 0 deg/h, z: 0 deg/h}}}",
        "{}",
    ),
}
LIMIT = (
    "name: soon\nenvironment: none\n"
    "limits: {mission: {position: {horizontal: 1 m, at: 1e-4 s}}}\n"
)
GRADE = "--requirement navigation-grade"
SOON = "--mission bench --at 1e-4_s"
COMMANDS = (
    "validate UNIT",
    "devices UNIT",
    f"analyze UNIT {GRADE} --no-validate",
    "analyze UNIT --no-validate --only gyro.flicker",
    "analyze UNIT --method monte-carlo --trials 1000",
    "analyze UNIT --no-validate --sobol --samples 16",
    f"analyze UNIT --no-validate {SOON}",
    "mission UNIT --mission bench --no-validate",
    f"mission UNIT {SOON} --no-validate",
    f"mission UNIT {SOON} --no-validate --only gyro.flicker",
    f"mission UNIT {SOON} --no-validate --only gyro.bias_stability",
    f"mission UNIT {SOON} --no-validate --calibration none",
    f"mission UNIT {SOON} --no-validate --calibration zhao-2019 --language zh",
    f"mission UNIT {SOON} --no-validate --requirement soon.yaml",
    f"mission UNIT {SOON} --method monte-carlo --trials 1000",
    "mission UNIT --mission bench-self-aligned --at 1e-4_s --no-validate",
    f"report UNIT -o out.html {GRADE} --no-validate",
    f"report UNIT -o out.html {SOON} --no-validate",
    f"compare UNIT zhao-2019 {GRADE} --method gum",
    f"compare UNIT {GRADE} --mission bench --method gum",
    f"allocate UNIT {GRADE} --no-validate",
    f"allocate UNIT {GRADE} --no-validate --strategy proportional",
    f"station UNIT {GRADE}",
    "export UNIT --to kalibr",
    "export UNIT --to psins --residual",
    "check --save out.json UNIT",
    "diff zhao-2019 UNIT",
    "diff UNIT UNIT",
)
ANSWERED = (0, 1, 2)  # met, not met, refused in words
UNSAID = re.compile(
    r"\bnan\b|\bNaN\b|Traceback|(?<![\d.])0 % of the variance|spread of the variance"
)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_answers_where_little_is_given(command, tmp_path, monkeypatch):
    """No failure of the program, no nan, no source of 0 % of the variance."""
    monkeypatch.chdir(tmp_path)
    Path("soon.yaml").write_text(LIMIT, encoding="utf-8")
    for name, (gyro, accelerometer) in UNITS.items():
        Path(name).write_text(
            f"name: u\ngyro: {{errors: {gyro}}}\n"
            f"accelerometer: {{errors: {accelerometer}}}\n",
            encoding="utf-8",
        )
        words = command.replace("UNIT", name).split()

        outcome = call(*(word.replace("_s", " s") for word in words))

        page = Path("out.html")
        shown = page.read_text(encoding="utf-8") if page.exists() else ""
        shown = re.sub(r"<(script|style)[^>]*>.*?</\1>", "", shown, flags=re.DOTALL)
        assert outcome.code in ANSWERED, (name, outcome.err)
        assert not UNSAID.search(outcome.out + outcome.err + shown), name


def test_a_mission_without_an_error_blames_no_line():
    """Where no line moves the position that is said, and no source or rate is named."""
    soon = ("--mission", "bench", "--at", "1e-4 s", "--only", "gyro.bias_stability")

    outcome = call("mission", *soon)

    assert outcome.code == 0, outcome.err
    said = " ".join(outcome.out.split())
    assert "no specification moves the horizontal position by more than" in said
    assert "share of the variance" not in outcome.out
