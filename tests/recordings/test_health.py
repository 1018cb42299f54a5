"""Health of a long run: what its windows lack is found, counted, and said once."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from calibration.test_mistakes import MEMS
from command_line import call
from numpy.testing import assert_allclose
from scipy.stats import norm

from budget.calibration.schemes import windows_of
from budget.errors import BudgetError, CallError, SpecError
from budget.inputs import load_procedure, load_recording
from budget.inputs.recording import with_columns
from budget.recordings import calibrate as module
from budget.recordings.calibrate import calibrate
from budget.recordings.health import ReadingSteps
from budget.recordings.log import read_logs
from budget.recordings.matching import PACE
from budget.recordings.run import read_windows
from budget.recordings.simulated_run import simulated_run

RATE = 20.0
SIX = "six-positions-and-turns"
SHORT = (
    "name: six faces\nlatitude: 34.2394 deg\ngravity: normal\nsample_rate: 20 Hz\n"
    "estimator: least_squares\npause: 4 s\nwindows:\n  - {face: all, dwell: 15 s}\n"
) + "".join(
    f"  - {{face: {axis} up, turn: vertical, turns: 1, rate: 45 deg/s, back: true, "
    "use: gyro}\n"
    for axis in "zxy"
)


@cache
def simulated(procedure, seed):
    """Return heads, rows and windows of a run as it is printed."""
    made = simulated_run(MEMS, procedure=procedure, seed=seed, rate=RATE)
    head, *rows = "".join(made.csv()).splitlines()
    numbers = np.array([[float(x) for x in one.split(",")] for one in rows])
    return head, numbers, {one.place: one.window for one in made.steps}


class Run:
    """A simulated run, to be spoilt: rows of stamps and readings as printed."""

    def __init__(self, procedure, seed):
        self.head, rows, self.steps = simulated(procedure, seed)
        self.rows, self.gone = rows.copy(), np.zeros(len(rows), dtype=bool)

    def inside(self, window):
        """Return the rows of a window, which is counted from 1."""
        own = self.steps[window - 1]
        time = self.rows[:, 0]
        return np.flatnonzero((time > own.start - 1e-6) & (time < own.end - 1e-6))

    def clip(self, window, column, part=0.8):
        """Let a turn reach the end of a range."""
        at = self.inside(window)
        end = part * np.abs(np.median(self.rows[at, column]))
        self.rows[at, column] = np.clip(self.rows[at, column], -end, end)

    def cut(self, window, seconds, after=2.0):
        """Leave samples of a window out."""
        at = self.inside(window)[round(after * RATE) :]
        self.gone[at[: round(seconds * RATE)]] = True

    def stick(self, window, column, seconds):
        """Repeat a value."""
        at = self.inside(window)[40 : 40 + round(seconds * RATE)]
        self.rows[at, column] = self.rows[at[0], column]

    def spike(self, window, column, sizes):
        """Add to single samples."""
        at = self.inside(window)[60:100:5][: len(sizes)]
        self.rows[at, column] += sizes

    def write(self, path):
        """Write what is left."""
        rows = self.rows[~self.gone]
        text = [",".join(f"{x:.9g}" for x in row) + "\n" for row in rows]
        path.write_text(f"{self.head}\n{''.join(text)}", encoding="utf-8")
        return path


@pytest.fixture
def short(tmp_path, monkeypatch):
    """Provide a short run in a folder with its device and procedure."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "six.yaml").write_text(SHORT, encoding="utf-8")
    (tmp_path / "mems.yaml").write_text(json.dumps(MEMS), encoding="utf-8")
    return Run("six.yaml", seed=5)


def read(path, procedure="six.yaml", **more):
    """Return the windows of a run."""
    how = load_procedure(procedure)
    recording = with_columns(load_recording(path), **more)
    return read_windows([recording], windows_of(how), name=how.name)


def found(run):
    """Return what is unsound: window, sensor, axis and kind with how many samples."""
    seen = {}
    for kind, own in run.health.items():
        for number, one in enumerate(own, start=1):
            if one.missing:
                seen[number, "missing"] = one.missing
            for what in ("saturated", "stuck", "outliers"):
                for axis, count in zip("xyz", getattr(one, what), strict=True):
                    if count:
                        seen[number, f"{kind}_{axis}", what] = count
    return seen


def test_each_is_named_where_it_is(short, tmp_path):
    """A saturated turn, gaps in a rest and in a turn, stuck values, three spikes."""
    short.clip(7, 3)
    short.cut(3, 2.0)
    short.cut(9, 1.0)
    short.stick(4, 4, 3.0)
    short.spike(5, 2, [3.0, -20.0, 8.0])
    seen = found(read(short.write(tmp_path / "run.csv")))
    assert seen == {
        (7, "gyro_z", "saturated"): 160,
        (3, "missing"): 40,
        (9, "missing"): 20,
        (4, "accelerometer_x", "stuck"): 60,
        (5, "gyro_y", "outliers"): 3,
    }


def test_means_are_those_of_what_is_sound(short, tmp_path):
    """Of a rest without spikes and stuck values; of a turn over its gap."""
    clean = read(short.write(tmp_path / "clean.csv"))
    short.spike(5, 2, [3.0, -20.0, 8.0])
    short.stick(4, 4, 3.0)
    short.cut(9, 1.0)
    spoilt = read(short.write(tmp_path / "run.csv"))
    noise = np.radians(0.03)  # of a sample, over the root of what is left
    for kind, size in (("gyro", noise), ("accelerometer", 0.005)):
        off = np.abs(spoilt.means[kind] - clean.means[kind])
        assert off[:, [3, 4, 8]].max() < 4.0 * size / np.sqrt(100.0)
    kept = spoilt.health["accelerometer"][3].kept
    assert_allclose(spoilt.windows[3].length, clean.windows[3].length * kept, rtol=1e-9)


def test_a_saturated_turn_is_not_sound(short, tmp_path):
    """With exit code 1, one caution and fields, and without a device too."""
    short.clip(7, 3, 0.97)
    short.clip(8, 3, 0.97)
    short.write(tmp_path / "run.csv")
    words = ("calibrate", "run.csv", "--procedure", "six.yaml", "--json", "a.json")
    said = call(*words)
    assert said.code == 1
    text = " ".join(said.out.split())
    assert "NOT SOUND" in text
    assert text.count("at the end of the range") == 1
    assert "sound is not told" not in text
    assert "7 gyro z (160), 8 gyro z (160)" in text
    document = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert document["is_sound"] is False
    rows = {x["window"]: x for x in document["windows"] if x["sensor"] == "gyro"}
    assert rows[7]["is_spoilt"] is True
    assert rows[7]["saturated"] == [0, 0, 160]
    assert rows[6]["is_spoilt"] is False
    assert rows[6]["gaps"] == rows[6]["missing"] == 0


@pytest.mark.slow
def test_a_certificate_marks_the_windows(short, tmp_path):
    """Beside the name of each."""
    short.clip(7, 3)
    short.cut(3, 2.0)
    short.write(tmp_path / "run.csv")
    words = ("calibrate", "run.csv", "--procedure", "six.yaml", "-o", "a.html")
    assert call(*words).code == 1
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert page.count(">saturated<") == page.count(">gap<") - 1 == 1


def test_a_stated_range_is_kept_to(short, tmp_path):
    """One sample at it is enough; without it that is none."""
    at = short.inside(7)[50]
    short.rows[at, 3] = 46.0
    short.write(tmp_path / "run.csv")
    (tmp_path / "run.yaml").write_text(
        "recording: run.csv\nsaturation: {gyro: 46 deg/s}\n", encoding="utf-8"
    )
    assert found(read(tmp_path / "run.csv")) == {}
    assert found(read(tmp_path / "run.yaml")) == {(7, "gyro_z", "saturated"): 1}


def test_a_turn_that_begins_in_a_gap_is_spoilt(short, tmp_path):
    """Nobody knows then how far it had turned."""
    at = short.inside(9)[0]
    short.gone[at - 3 : at + 3] = True
    run = read(short.write(tmp_path / "run.csv"))
    assert [k for k, x in enumerate(run.health["gyro"], 1) if x.is_lost] == [9]
    assert run.health["gyro"][8].is_spoilt


def test_a_window_of_which_little_is_left_is_spoilt(short, tmp_path):
    """More than half of it is stuck."""
    short.stick(4, 4, 10.0)
    run = read(short.write(tmp_path / "run.csv"))
    assert run.health["accelerometer"][3].is_spoilt
    assert not run.health["gyro"][3].is_spoilt
    assert np.isfinite(run.means["accelerometer"]).all()


@pytest.mark.parametrize("steps", [0.3, 1.0, 3.0, 10.0, 40.0])
def test_coarse_steps_are_not_stuck(short, tmp_path, steps):
    """Of a hundredth of the noise to forty times it; nor are they saturated."""
    for column in range(1, 7):
        own = short.rows[:, column]
        at = short.inside(1)
        q = steps * np.std(np.diff(own[at])) / np.sqrt(2.0)
        short.rows[:, column] = np.round(own / q) * q
    assert found(read(short.write(tmp_path / "run.csv"))) == {}


def test_a_counter_says_where_samples_are_missing(short, tmp_path):
    """Where there are no stamps."""
    short.cut(3, 2.0)
    short.rows[:, 0] = np.arange(len(short.rows)) % 256
    short.head = short.head.replace("time [s]", "n")
    short.write(tmp_path / "run.csv")
    (tmp_path / "run.yaml").write_text(
        "recording: run.csv\nrate: 20 Hz\ncounter: {column: n, modulo: 256}\n",
        encoding="utf-8",
    )
    assert found(read(tmp_path / "run.yaml")) == {(3, "missing"): 40}


@pytest.mark.parametrize(
    ("factor", "unit", "rate"),
    [
        (1e3, "ms", None),
        (1e6, "us", None),
        (1e9, "ns", None),
        (1e3, "ms", RATE),
        (1e9, "ns", RATE),
    ],
)
def test_stamps_of_another_unit_are_named(short, tmp_path, factor, unit, rate):
    """The likely unit is in the remedy, of a run and of a log."""
    short.rows[:, 0] *= factor
    path = short.write(tmp_path / "run.csv")
    with pytest.raises(SpecError, match=rf"look like {unit}: write 'time \[{unit}\]'"):
        read(path, rate=rate)
    with pytest.raises(SpecError, match=rf"look like {unit}: write"):
        read_logs(with_columns(load_recording(path), rate=rate))
    short.head = short.head.replace("[s]", f"[{unit}]", 1)
    assert found(read(short.write(path), rate=rate)) == {}


def test_a_rate_beside_stamps_is_theirs(short, tmp_path):
    """Another one is refused."""
    path = short.write(tmp_path / "run.csv")
    with pytest.raises(SpecError, match="25 Hz, and its stamps come at 20 Hz"):
        read(path, rate=25.0)


@pytest.mark.parametrize("rate", [40.0, 80.0])
def test_a_rate_that_is_another_is_asked_for(short, tmp_path, rate):
    """All rests are as much shorter than those of the procedure: 15 s at 20 Hz."""
    written = short.write(tmp_path / "run.csv")
    rows = written.read_text(encoding="utf-8").splitlines()
    bare = "".join(one.split(",", 1)[1] + "\n" for one in rows)
    written.write_text(bare, encoding="utf-8")
    with pytest.raises(CallError) as error:
        read(written, rate=rate)
    asked = str(error.value).split("is the rate about ")[1]
    assert abs(np.log(float(asked.split(" Hz")[0]) / RATE)) <= PACE
    assert f"not {rate:g} Hz (--rate" in asked


def test_a_blunder_is_typed_as_it_is_listed():
    """With its blank; without it the list is shown."""
    words = {"procedure": "six-positions", "means": True}
    made = simulated_run("zhao-2019", blunders=["window_face=1:z down"], **words)
    assert made.blunders[0].said == "window_face=1:z down"
    with pytest.raises(CallError, match="1:z down, 1:x up"):
        simulated_run("zhao-2019", blunders=["window_face=1:zdown"], **words)


@pytest.mark.slow
def test_no_clean_run_is_accused(tmp_path):
    """Of 20 seeds none lacks anything."""
    for seed in range(20):
        path = Run(SIX, seed).write(tmp_path / "run.csv")
        assert found(read(path, SIX)) == {}


@pytest.mark.slow
def test_each_is_named_in_a_long_run(tmp_path):
    """As in a short one; the answer is not sound."""
    run = Run(SIX, 3)
    run.clip(7, 3)
    run.cut(3, 5.0)
    run.cut(9, 3.0)
    run.stick(4, 4, 3.0)
    run.spike(5, 2, [3.0, -20.0, 8.0])
    answer = calibrate(run.write(tmp_path / "run.csv"), procedure=SIX, device=MEMS)
    assert answer.is_sound is False
    assert answer.spoilt == (7,)
    said = [str(one) for one in answer.warnings]
    for what in (
        "at the end of the range",
        "gaps, with 100 samples",
        "gaps in turns",
        "are stuck",
        "outliers of",
    ):
        assert sum(what in one for one in said) == 1


@pytest.mark.slow
def test_spoilt_runs_are_read_or_refused(short, tmp_path, monkeypatch):
    """Of 60 none ends otherwise; what is read says what it lacks."""
    monkeypatch.setattr(module, "unseen_of", lambda *_: ())
    rng = np.random.default_rng(41)
    rows = short.rows.copy()
    answers = longest = 0
    for _ in range(60):
        short.rows, short.gone[:] = rows.copy(), False
        for _ in range(rng.integers(1, 4)):
            window, column = int(rng.integers(1, 13)), int(rng.integers(1, 7))
            seconds = float(rng.uniform(0.1, 12.0))
            [
                lambda w=window, c=column: short.clip(w, c, rng.uniform(0.1, 1.0)),
                lambda w=window, s=seconds: short.cut(w, s, rng.uniform(0.0, 5.0)),
                lambda w=window, c=column, s=seconds: short.stick(w, c, s),
                lambda w=window, c=column: short.spike(
                    w, c, 10.0 ** rng.uniform(-1.0, 5.0, rng.integers(1, 8))
                ),
            ][rng.integers(4)]()
        path = short.write(tmp_path / "run.csv")
        try:
            answer = calibrate(path, procedure="six.yaml", device="mems.yaml")
        except BudgetError as error:
            longest = max(longest, len(str(error)))
        else:
            answers += 1
            json.dumps(answer.to_dict(), allow_nan=False)
    assert answers > 30
    assert 0 < longest < 8000


def in_pieces(run, folder, cuts):
    """Write a run in several files; return them."""
    paths, rows = [], run.rows
    for number, part in enumerate(np.split(rows, cuts)):
        run.rows, run.gone = part, np.zeros(len(part), dtype=bool)
        paths.append(run.write(folder / f"{number}.csv"))
    run.rows, run.gone = rows, np.zeros(len(rows), dtype=bool)
    return paths


def between(run, windows):
    """Return rows in the middle of the pauses before windows, counted from 1."""
    return [(run.inside(k - 1)[-1] + run.inside(k)[0]) // 2 for k in windows]


def test_files_whose_stamps_go_on_are_one_run(short, tmp_path):
    """Windows, values and p are those of one file; a pause counts as it was."""
    whole = short.write(tmp_path / "run.csv")
    paths = in_pieces(
        short, tmp_path, sorted([*between(short, [3, 8]), short.inside(5)[99]])
    )
    words = {"procedure": "six.yaml", "device": "mems.yaml"}
    one, several = calibrate(whole, **words), calibrate(*paths, **words)
    for key in ("start", "length"):
        own, split = ([getattr(x, key) for x in y.windows] for y in (one, several))
        assert_allclose(split, own, atol=1e-9)
    values = [[x.value for x in y.outputs] for y in (several, one)]
    assert_allclose(*values, rtol=1e-9)
    p = [[x.p for x in (*y.chi_square, *y.prior)] for y in (several, one)]
    assert_allclose(*p, rtol=1e-9)


@pytest.mark.parametrize("is_stamped", [True, False])
def test_files_are_one_after_the_other(short, tmp_path, is_stamped):
    """Between two windows samples are left out, or stamps begin again."""
    whole = read(short.write(tmp_path / "run.csv"))
    cuts = between(short, [3, 8])
    if is_stamped:
        short.rows = np.delete(short.rows, [x + k for x in cuts for k in range(9)], 0)
        cuts = [cuts[0], cuts[1] - 9]
    paths = in_pieces(short, tmp_path, cuts)
    if not is_stamped:
        for path in paths:
            head, *rows = path.read_text(encoding="utf-8").splitlines()
            first = float(rows[0].split(",")[0])
            rows = [x.split(",", 1) for x in rows]
            text = "".join(f"{float(t) - first:.9g},{x}\n" for t, x in rows)
            path.write_text(f"{head}\n{text}", encoding="utf-8")
    how = load_procedure("six.yaml")
    made = [load_recording(x) for x in paths]
    several = read_windows(made, windows_of(how), name=how.name)
    own, split = ([x.start for x in y.windows] for y in (whole, several))
    assert_allclose(split, own, atol=0.11)


TURNS = SHORT.replace("rate: 45 deg/s", "rate: 20 deg/s").replace("20 Hz", "100 Hz")
QUIET = {
    "format": "budget-device/1",
    "name": "Quiet",
    "gyro": {
        "errors": {
            "bias_repeatability": "20 deg/h",
            "scale_factor_repeatability": "2000 ppm",
            "mounting_repeatability": "400 arcsec",
            "angle_random_walk": "0.01 deg/sqrt(h)",
        }
    },
}


def trapezoids(how, ramp, rng, rate=100.0):
    """Return times and rates of a run whose turns have ramps of a length [deg/s]."""
    parts, forces = [], []

    def add(setting, rates, angles):
        earth = [setting.after(x).to_body @ how.place.earth for x in angles]
        parts.append(np.array(rates) + earth)
        forces.append([setting.after(x).to_body @ how.place.force for x in angles])

    for one in windows_of(how):
        there = replace(one.setting, angle=0.0)
        n = round((3.0 if one.sense else one.length) * rate)
        move = np.zeros((round(2.0 * rate), 3))
        move[:, 0] = np.radians(30.0)
        if one.sense >= 0:
            add(there, move, np.zeros(len(move)))
        add(there, np.zeros((n, 3)), np.zeros(n))
        if one.sense:
            size = np.linalg.norm(one.rate)
            total = abs(one.setting.angle) / size + ramp
            time = (np.arange(round(total * rate)) + 0.5) / rate
            own = np.clip(np.minimum(time, total - time) / ramp, 0.0, 1.0)
            own *= abs(one.setting.angle) / (own.sum() / rate)
            angle = (np.cumsum(own) - own / 2.0) / rate * np.sign(one.setting.angle)
            add(there, own[:, None] * one.rate / size, angle)
            add(there, np.zeros((n, 3)), np.zeros(n))
    values = np.concatenate(parts)
    values += rng.normal(size=values.shape) * np.radians(0.01) / 60.0 * np.sqrt(rate)
    force = np.concatenate(forces) + rng.normal(size=values.shape) * 1e-4
    return np.column_stack([np.arange(len(values)) / rate, np.degrees(values), force])


@pytest.mark.parametrize("ramp", [0.5, 1.0, 2.0])
def test_the_ramps_of_a_turn_are_part_of_its_angle(tmp_path, monkeypatch, ramp):
    """Scale factors are those of the unit, whatever the turns begin and end with."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "six.yaml").write_text(TURNS, encoding="utf-8")
    how = load_procedure("six.yaml")
    rows = trapezoids(how, ramp, np.random.default_rng(7))
    heads = [f"gyro_{x} [deg/s]" for x in "xyz"]
    heads += [f"accelerometer_{x} [m/s^2]" for x in "xyz"]
    text = "".join(",".join(f"{x:.10g}" for x in row) + "\n" for row in rows)
    path = tmp_path / "run.csv"
    path.write_text(f"{','.join(['time [s]', *heads])}\n{text}", encoding="utf-8")
    run = calibrate(path, procedure="six.yaml", device=QUIET)
    assert run.is_sound
    for one in run.outputs:
        if one.sensor == "gyro" and one.parameter == "scale_factor":
            off = abs(one.value) * one.si_per_unit
            u = one.standard_uncertainty * one.si_per_unit
            assert off < 3e-6 + 4.0 * u


@pytest.mark.parametrize(
    ("row", "place", "said"),
    [
        ("2,1,12", ":3:1:", "1 to 12 s is over that of line 2, 0 to 10 s"),
        ("2,0,10", ":3:1:", "line 2"),
        ("2,,30", ":3:2:", r"start \[s\] is empty"),
        ("2,20,", ":3:3:", r"end \[s\] is empty"),
    ],
)
def test_windows_over_each_other_are_refused(short, tmp_path, row, place, said):
    """With both rows; what is missing is named."""
    path = short.write(tmp_path / "run.csv")
    rows = [f"{k},{20 * k},{20 * k + 10}" for k in range(2, 12)]
    text = "\n".join(["window,start [s],end [s]", "1,0,10", row, *rows, ""])
    (tmp_path / "windows.csv").write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=f"{place}.*{said}"):
        calibrate(path, procedure="six.yaml", windows=tmp_path / "windows.csv")


def test_code_of_higher_orders_is_refused(short, tmp_path):
    """They are named; without them there is code."""
    text = SHORT + "estimate: {accelerometer: [scale_factor, bias, second_order]}\n"
    (tmp_path / "second.yaml").write_text(text, encoding="utf-8")
    short.write(tmp_path / "run.csv")
    words = ("calibrate", "run.csv", "--to", "c", "--procedure")
    said = call(*words, "second.yaml")
    assert said.code == 2
    assert "found second_order" in " ".join(said.err.split())
    assert "gyro_correct" in call(*words, "six.yaml").out


@pytest.mark.parametrize("noise", [0.1, 0.2, 0.3])
def test_what_steps_put_into_a_mean_is_in_its_uncertainty(noise):
    """Of 200 runs of six rests at any place in a step 95 % intervals hold 93 % or more.

    Halved, as a control, less than that.
    """
    rng = np.random.default_rng(3)
    held = {1.96: 0, 0.98: 0}
    for _ in range(200):
        places = rng.uniform(0.0, 1.0, 6)
        rests = [np.round(x + rng.normal(0.0, noise, 2000)) for x in places]
        u = ReadingSteps.of(rests, 1.0).u
        off = [abs(one.mean() - x) for one, x in zip(rests, places, strict=True)]
        for k in held:
            held[k] += sum(np.array(off) < k * u)
    assert held[1.96] >= 0.93 * 1200
    assert held[0.98] < 0.93 * 1200


def test_what_steps_put_into_a_mean_is_that_of_a_saw_tooth():
    """Without noise q/sqrt(12); of much its first term; of more than half a step 0."""
    assert_allclose(ReadingSteps(step=2.0, noise=0.0).u, 2.0 / np.sqrt(12.0), rtol=0.01)
    first = 2.0 / np.pi / np.sqrt(2.0) * np.exp(-2.0 * (np.pi * 0.3) ** 2)
    assert_allclose(ReadingSteps(step=2.0, noise=0.6).u, first, rtol=1e-3)
    assert not ReadingSteps(step=2.0, noise=1.0).is_coarse
    assert ReadingSteps(step=0.0, noise=1.0).u == 0.0


@pytest.mark.slow
def test_values_of_coarse_readings_are_known_to_their_steps(tmp_path, monkeypatch):
    """Steps of 5 times the noise: sound, the truth in the intervals; said once."""
    monkeypatch.chdir(tmp_path)
    sheet = {
        "format": "budget-device/1",
        "name": "quiet",
        "accelerometer": {
            "errors": {
                "bias_repeatability": "5 mg",
                "scale_factor_repeatability": "2000 ppm",
                "mounting_repeatability": "400 arcsec",
                "velocity_random_walk": "10 ug/sqrt(Hz)",
            }
        },
    }
    rest = {"procedure": "six-positions"}
    off = []
    for seed in range(6):
        made = simulated_run(sheet, seed=seed, rate=50.0, **rest)
        lines = "".join(made.csv()).splitlines()
        rows = np.array([[float(x) for x in one.split(",")] for one in lines[1:]])
        step = 350e-6 * 9.80665
        rows[:, 1:] = np.round(rows[:, 1:] / step) * step
        np.savetxt("run.csv", rows, delimiter=",", header=lines[0], comments="")
        found = calibrate("run.csv", device=sheet, **rest)
        assert found.is_sound
        assert sum("come in steps of 0.0034 m/s^2" in str(x) for x in found.warnings)
        for one in found.outputs:
            if one.parameter == "bias":
                true = made.turn_ons["accelerometer"].bias["xyz".index(one.axis)]
                off.append((one.value - true) / one.standard_uncertainty)
    assert np.abs(off).max() < norm.isf(0.0005 / len(off))
