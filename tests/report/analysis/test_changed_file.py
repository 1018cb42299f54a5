"""The device file that a report hands out: with nothing moved it is the device."""

from __future__ import annotations

from functools import cache

import pytest
from numpy.testing import assert_allclose
from places import put
from report_examples import WIDE_LIMITS

from budget import analyze, load_catalogue, load_device, load_procedure
from budget.inputs import load_requirement
from budget.question import question_of, sensors_of
from budget.report.analysis.what_if import AnalyzeAgain, what_if_section
from budget.report.device_file import MARK, is_read_back
from budget.studies import conformity, readings
from budget.studies.judgement import judge_with
from budget.studies.what_if import one_at_a_time, what_if

SAME = 1e-9  # relative: quantities are written in another unit and read back
FORCES = {"accelerometer": {"bias": "10 mg", "scale_factor": "900 ppm"}}
DEVICE = """
format: budget-device/1
name: {name}
technology: MEMS
gyro:
  errors:
    bias_repeatability: {{value: 3 deg/h, horizon: 1 year{open}}}
    bias_stability: {{value: 0.5 deg/h, reading: [sigma, allan_minimum]}}
    angle_random_walk: {{value: 0.6 deg/h/sqrt(Hz), reading: [one-sided, two-sided]}}
    scale_factor_repeatability: {{value: 90 ppm, horizon: 1 year, {scale}}}
    mounting_repeatability: {{value: 20 arcsec, meaning: max}}
    ageing: {{value: 4 deg/h, horizon: 1 year, adds_to: bias_repeatability,
      earlier: [{{value: 2 deg/h, horizon: 30 day}}]}}
"""
OPEN = (
    ("", "meaning: 3 sigma, reading: [per axis, root sum square]"),
    (", reading: [max, 1 sigma]", "reading: [3 sigma, 2 sigma]"),
    (", reading: [max, peak to peak], distribution: triangular", "meaning: max"),
    (", meaning: max, reading: [turn-on, over temperature]", "meaning: max"),
)


TRIALS = 10_000  # a tenth of what a report takes: those of both files are the same


@pytest.fixture(autouse=True)
def few_trials(monkeypatch):
    """Judge the device and its file with the same trials, but fewer."""

    def judge(held, *, seed, **_):
        return judge_with(held, seed=seed, trials=TRIALS)

    for module in (conformity, readings):
        monkeypatch.setattr(module, "judge", judge)


def shapes(device):
    """Return what every line of a device is distributed as."""
    sensors = [one for one in (device.gyro, device.accelerometer) if one]
    return [(line.name, line.distributions) for one in sensors for line in one.lines]


def handed_out(budget, *devices):
    """Return the file of a report with nothing moved; '' where there is none."""
    question = question_of(budget)
    model = what_if(question, budget=budget)
    section = what_if_section(
        budget,
        model,
        one_at_a_time(model),
        devices=question.devices,
        again=AnalyzeAgain(same="a", of_file="b", devices=devices),
    )
    (*_, sliders) = section.blocks
    assert (sliders.model["command_of_file"] != "") == (sliders.model["device"] != "")
    return sliders.model["device"].replace(MARK, "")


def assert_same(folder, device, *, limits=None, **options):
    """Check that the file is judged as the device is; return verdict and name."""
    wanted = load_requirement(WIDE_LIMITS if limits is None else limits)
    budget = analyze(device, requirement=wanted, validate=False, **options)
    path = put(folder / "changed.yaml", handed_out(budget, device))
    read = load_device(path)
    again = analyze(read, requirement=wanted, validate=False, **options)

    assert read.technology == device.technology
    assert shapes(read) == shapes(device)
    before, after = budget.assessment.sensors, again.assessment.sensors
    assert [one.verdict for one in before] == [one.verdict for one in after]
    for one, other in zip(before, after, strict=True):
        assert_allclose(other.utilisation, one.utilisation, rtol=SAME)
        if one.readings is not None:
            used = [
                [read.utilisation for read in x.readings.found] for x in (one, other)
            ]
            assert_allclose(used[1], used[0], rtol=SAME)
    assert [one.lower_bound for one in again.outputs] == [
        one.lower_bound for one in budget.outputs
    ]
    assert_allclose(
        [one.standard_uncertainty for one in again.outputs],
        [one.standard_uncertainty for one in budget.outputs],
        rtol=SAME,
    )
    return [one.verdict for one in after], read


@cache
def catalogue():
    """Return every shipped device once."""
    return load_catalogue()


@pytest.mark.parametrize("place", range(0, 100, 9))
def test_a_shipped_device_is_the_file_handed_out(tmp_path, place):
    """Sizes, lower bounds and verdicts: nothing of the data sheet is lost."""
    devices = catalogue()
    device = devices[place % len(devices)]
    limits = WIDE_LIMITS if device.gyro else {**WIDE_LIMITS, "limits": FORCES}
    assert_same(tmp_path, device, limits=limits)


@pytest.mark.parametrize("mode", ["predict", "typical", "worst"])
def test_stand_ins_are_not_handed_out_as_the_makers(tmp_path, mode):
    """The command puts them there again: the verdict stays one of stand-ins."""
    verdicts, read = assert_same(tmp_path, load_device("ltm210#S1A"), missing=mode)
    assert read.gyro.expected_missing != ()
    assert verdicts != ["meets"]


def test_a_horizon_is_handed_out(tmp_path):
    """A repeatability that holds over a year says so in the file too."""
    text = DEVICE.format(name="horizon", open="", scale="meaning: max")
    text = text[: text.index("    ageing")]
    (tmp_path / "d.yaml").write_text(text, encoding="utf-8")
    limits = {**WIDE_LIMITS, "reference": "next_turn_on"}
    procedure = load_procedure(None, age="6 months")
    device = load_device(tmp_path / "d.yaml")
    _, read = assert_same(tmp_path, device, limits=limits, procedure=procedure)
    assert read.gyro.line("bias_repeatability").horizon == "1 year"


@pytest.mark.parametrize(("bias", "scale"), OPEN)
def test_an_open_meaning_stays_open(tmp_path, bias, scale):
    """Each reading has its size in the file, or there is no file."""
    text = DEVICE.format(name="open", open=bias, scale=scale)
    (tmp_path / "d.yaml").write_text(text, encoding="utf-8")
    device = load_device(tmp_path / "d.yaml")
    if "over temperature" in bias:
        assert handed_out(analyze(device, validate=False), device) == ""
        return
    _, read = assert_same(tmp_path, device)
    for one, other in zip(device.gyro.lines, read.gyro.lines, strict=True):
        assert [word for word, _ in other.readings] == [w for w, _ in one.readings]
        for (_, wanted), (_, found) in zip(one.readings, other.readings, strict=True):
            assert_allclose(found.u, wanted.u, rtol=SAME)
    assert_allclose(read.gyro.line("ageing").horizons[0][1], 0.5, rtol=SAME)


def test_what_reads_back_as_another_device_is_none():
    """The check sees a size, a time and a line that are other."""
    device = load_device("zhao-2019")
    sensors = sensors_of([device])
    text = handed_out(analyze(device, validate=False), device)
    kept = {"technology": device.technology}
    assert is_read_back(text, sensors, **kept)
    for other in (
        text.replace("arcsec", "arcmin", 1),
        text.replace("gyro:", "gyros:", 1),
        "\n".join(x for x in text.splitlines() if "scale_factor_rep" not in x),
    ):
        assert other != text
        assert not is_read_back(other, sensors, **kept)
    assert not is_read_back(text, sensors, technology="RLG, not this")


def test_a_changed_device_is_called_so_once(tmp_path):
    """Also where the report had a change of its own; no mark is of its name."""
    text = DEVICE.format(name='"\ue0005\ue000"', open="", scale="meaning: max")
    (tmp_path / "d.yaml").write_text(text, encoding="utf-8")
    device = load_device(tmp_path / "d.yaml", changes=["gyro.bias_stability=1 deg/h"])
    marked = handed_out(analyze(device, validate=False), device)
    assert '\nname: "\ue0005\ue000, changed"\n' in marked
