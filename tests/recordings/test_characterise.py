"""Figures of noise of recordings: known ones, several turn-ons, what is not told."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pyarrow as pa
import pytest
import yaml
from command_line import call
from numpy.testing import assert_allclose
from pyarrow import parquet
from recorded import HEADS, check_log, markov, short_log, walk, white, write

from budget.errors import BudgetError
from budget.inputs import load_device
from budget.recordings.characterise import characterise, repeatability
from budget.report.recording import measured_device, measured_yaml

COLUMNS = ",".join(HEADS)


@cache
def known(folder):
    """Return what is found in the check log."""
    np.save(folder / "check.npy", check_log())
    return characterise(folder / "check.npy", columns=COLUMNS)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return what is found in the check log, once."""
    return known(tmp_path_factory.mktemp("check"))


def by_line(found):
    """Return the lines by axis and parameter, values and intervals in their units."""
    return {
        (one.axis, one.parameter): (
            one.value / one.si_per_unit,
            [end / one.si_per_unit for end in one.interval],
            one,
        )
        for one in found.lines
    }


def test_the_check_log_gives_its_figures(found):
    """N, sigma, tau, K and their intervals, as other programs of the method have them.

    Between blocks of 0.5 and 10 s they move by less than these tolerances.
    """
    own = by_line(found)
    assert [one.chosen for one in found.models] == ["gm", "white", "rw"]
    assert [one.not_told_apart for one in found.models] == [(), (), ("gm",)]
    per_hour = 60.0  # deg/h sqrt(s) of one deg/sqrt(h)
    for axis, N, ends in (
        ("x", 9.045, (8.81, 9.29)),
        ("y", 8.97, (8.73, 9.12)),
        ("z", 9.045, (8.84, 9.27)),
    ):
        value, interval, _ = own[axis, "N"]
        assert_allclose(value * per_hour, N, rtol=0.012)
        assert_allclose(np.array(interval) * per_hour, ends, rtol=0.015)
    sigma, tau = own["x", "sigma"], own["x", "tau"]
    assert_allclose(sigma[0], 5.589, rtol=0.006)
    assert_allclose(sigma[1], [5.0, 6.36], rtol=0.01)
    assert_allclose(tau[0], 44.54, rtol=0.03)
    assert_allclose(tau[1], [33.1, 63.1], rtol=0.035)
    K, ends, line = own["z", "K"]
    assert_allclose(K / 60.0, 0.3131, rtol=0.006)
    assert_allclose(np.array(ends) / 60.0, [0.264, 0.373], rtol=0.006)
    # 1/(2 u^2) of the relative standard uncertainty.
    u = line.standard_uncertainty / line.value
    assert_allclose(line.degrees_of_freedom, 0.5 / u**2, rtol=1e-9)
    (rw,) = [one for one in found.models if one.axis == "z"]
    assert_allclose(rw.candidates[1].delta, 3.1, atol=0.3)
    assert own["x", "K"][2].bound == "upper"
    assert ("y", "sigma") not in own


def test_its_curve_is_that_of_the_contract(found):
    """Overlapping Allan deviations over whole octaves, within those of known times."""
    x = [one for one in found.allan if one.axis == "x"]
    assert_allclose(x[0].tau, 0.01)
    near = next(one for one in x if 0.6 < one.tau < 0.7)
    assert_allclose(near.deviation / near.si_per_unit, 9.0861 / 0.8, rtol=0.02)
    for one in x:
        assert one.interval_low < one.deviation < one.interval_high


def test_the_device_file_is_read_back(found, tmp_path):
    """Values, degrees of freedom and correlation times, bounds as max."""
    path = tmp_path / "imu.yaml"
    path.write_text(measured_yaml(found, name="imu"))
    (gyro,) = load_device(path).sensors
    lines = {one.name: one for one in gyro.lines}
    own = by_line(found)
    for name, parameter in (("angle_random_walk", "N"), ("bias_stability", "sigma")):
        line = lines[name]
        value = own["x", parameter][2]
        assert_allclose(line.u[0], value.value, rtol=1e-5)
        assert_allclose(line.degrees_of_freedom[0], value.degrees_of_freedom, rtol=1e-3)
    assert_allclose(lines["bias_stability"].u[1:], 0.0)
    assert_allclose(
        lines["bias_stability"].correlation_time[0], own["x", "tau"][0], rtol=1e-4
    )
    assert "max" in lines["rate_random_walk"].meaning
    assert_allclose(lines["rate_random_walk"].u[0], own["x", "K"][2].value, rtol=1e-5)
    assert measured_device(found).sensors[0].kind == "gyro"


def test_a_slow_process_is_told_as_a_walk(tmp_path):
    """Of a correlation time near the length of the record nothing is told but K."""
    rng, n, dt = np.random.default_rng(2), 200_000, 0.01
    slow = white(rng, n, dt, 9.0) + markov(rng, n, dt, 12.0, 1500.0)
    own = white(rng, n, dt, 9.0) + walk(rng, n, dt, 0.3)
    values = np.stack([np.arange(n) * dt, slow, own, slow[::-1]], axis=1)
    np.save(tmp_path / "a.npy", values)
    found = characterise(tmp_path / "a.npy", columns=COLUMNS)
    for one in found.lines:
        assert not (one.parameter in {"sigma", "tau"} and one.bound == "two-sided")
        if one.bound == "refused":
            assert "needs 50 times as long" in str(one.why)
    K = by_line(found)["x", "K"]
    assert K[1][0] / 60.0 < 12.0 * np.sqrt(2.0 / 1500.0) < K[1][1] / 60.0


def test_turn_ons_give_the_repeatability(tmp_path):
    """Six means as in the contract; noise is taken out; of noise alone a bound."""
    means = [1446.071, 1364.041, 1264.542, 1406.988, 1432.610, 1463.169]
    value, ends, is_told = repeatability([(one, 0.0) for one in means])
    assert is_told
    assert_allclose(value, 73.19, rtol=1e-3)
    assert_allclose(ends, [45.7, 179.5], rtol=1e-3)
    less, _, _ = repeatability([(one, 30.0) for one in means])
    assert_allclose(less**2, value**2 - 900.0, rtol=1e-9)
    _, _, is_told = repeatability([(one, 200.0) for one in means])
    assert not is_told
    paths = []
    for k in range(3):
        values = short_log(3000, seed=k)
        values[:, 1] += 50.0 * k
        paths.append(write(tmp_path / f"{k}.csv", values))
    found = characterise(*paths)
    x = by_line(found)["x", "R"]
    assert x[2].bound == "two-sided"
    assert_allclose(x[2].degrees_of_freedom, 2.0)
    assert_allclose(x[0], 50.0, rtol=0.1)
    assert len(found.records) == 3


def test_a_louder_run_is_named(tmp_path):
    """Runs that are not alike are said to be none."""
    paths = []
    for k in range(3):
        values = short_log(6000, seed=k)
        values[:, 1] *= 1.0 + (k == 1)
        paths.append(write(tmp_path / f"{k}.csv", values))
    found = characterise(*paths)
    (said,) = [one for one in found.warnings if "noise of the other runs" in one]
    assert "1.csv, gyro x" in said


def test_temperature_is_taken_out_and_told(tmp_path):
    """A change of 2 deg/h/degC is found, and the noise beside it is that without."""
    rng, n = np.random.default_rng(7), 60_000
    T = 25.0 + 5.0 * np.sin(np.arange(n) / 20_000.0)
    values = short_log(n)
    values[:, 1] += 2.0 * (T - 25.0)
    path = tmp_path / "a.npy"
    np.save(path, np.column_stack([values, T + 0.01 * rng.standard_normal(n)]))
    found = characterise(path, columns=f"{COLUMNS},temperature [degC]")
    lines = by_line(found)
    value, (low, high), _ = lines["x", "C"]
    assert low < 2.0 < high
    assert_allclose(value, 2.0, rtol=0.3)
    assert found.models[0].chosen == "white"
    assert lines["y", "C"][2].bound == "upper"


def test_quantisation_of_increments_is_told(tmp_path):
    """Rounding of angle increments to steps q: Q = q/sqrt(12), of the short times."""
    rng, n, dt, q = np.random.default_rng(9), 60_000, 0.01, 1.5  # q [arcsec]
    angle = np.cumsum(rng.standard_normal((n, 3)) * 9.0 / np.sqrt(dt) * dt, axis=0)
    step = np.diff(np.round(angle / q) * q, axis=0, prepend=0.0) / 3600.0
    np.save(tmp_path / "a.npy", np.column_stack([np.arange(n) * dt, step]))
    (tmp_path / "a.yaml").write_text(
        "recording: a.npy\nincrements: true\n"
        'columns: ["time [s]", "gyro_x [deg]", "gyro_y [deg]", "gyro_z [deg]"]\n'
    )
    lines = by_line(characterise(tmp_path / "a.yaml"))
    for axis in "xyz":
        value, (low, high), _ = lines[axis, "Q"]
        assert low < q < high
        assert_allclose(value, q, rtol=0.1)


@pytest.mark.slow
def test_a_filter_is_said(tmp_path):
    """What is not white at short times is said to be none."""
    values = short_log(60_000)
    values[:, 1] = np.convolve(values[:, 1], np.ones(8) / 8.0, "same")
    np.save(tmp_path / "a.npy", values)
    found = characterise(tmp_path / "a.npy", columns="time [s],gyro_x [deg/h],_,_")
    assert any("is not white below" in one for one in found.warnings)


def test_what_does_not_vary_is_refused(tmp_path):
    """A column of equal values is named."""
    values = short_log()
    values[:, 2] = 7.0
    with pytest.raises(BudgetError, match="gyro_y does not vary"):
        characterise(write(tmp_path / "a.csv", values))


def test_no_device_file_is_written_of_counts(tmp_path):
    """Figures in counts are told, and a file of them is refused with the remedy."""
    heads = (HEADS[0], *(one.replace("deg/h", "counts") for one in HEADS[1:]))
    rows = short_log()
    rows[:, 1:] = np.round(rows[:, 1:])
    log = write(tmp_path / "a.csv", rows, heads)
    assert "counts" in call("characterise", str(log)).out
    failed = call("characterise", str(log), "-o", str(tmp_path / "d.yaml"))
    assert failed.code == 2
    assert "with gain" in failed.err
    assert not (tmp_path / "d.yaml").exists()


def test_what_does_not_belong_together_is_refused(tmp_path):
    """Other columns, other rates."""
    a = write(tmp_path / "a.csv", short_log())
    b = write(tmp_path / "b.csv", short_log(dt=0.02))
    c = write(tmp_path / "c.csv", short_log()[:, :3], HEADS[:3])
    with pytest.raises(BudgetError, match=r"50 Hz, and a\.csv at 100 Hz"):
        characterise(a, b)
    with pytest.raises(BudgetError, match=r"c\.csv has the columns gyro_x, gyro_y"):
        characterise(a, c)


def test_the_command_writes_file_page_and_target(tmp_path):
    """All that is asked for, and nothing where a recording is bad."""
    log = write(tmp_path / "a.csv", short_log())
    done = call(
        *("characterise", str(log), "-o", str(tmp_path / "d.yaml")),
        *("-o", str(tmp_path / "d.html"), "--json", str(tmp_path / "d.json")),
    )
    assert done.code == 0, done.err
    assert "angle random walk" in done.out
    assert load_device(tmp_path / "d.yaml").sensors
    assert "Allan deviation" in (tmp_path / "d.html").read_text()
    bad = tmp_path / "b.csv"
    bad.write_text(log.read_text().replace("0.02,", "x,", 1))
    failed = call("characterise", str(bad), "-o", str(tmp_path / "e.yaml"))
    assert failed.code == 2
    assert "b.csv:4:1" in failed.err
    assert not (tmp_path / "e.yaml").exists()
    again = call("characterise", str(log), "-o", str(log))
    assert again.code == 2


def words_of(path, columns):
    """Return what is said of a recording that is refused, None of one that is not."""
    try:
        characterise(path, columns=columns)
    except BudgetError as error:
        return str(error)
    return None


@pytest.mark.slow
def test_mutated_recordings_give_figures_or_words(tmp_path):
    """2,000 recordings with bytes changed, cut, doubled: no fault of the program."""
    rng = np.random.default_rng(11)
    good = write(tmp_path / "good.csv", short_log(150)).read_bytes()
    np.save(tmp_path / "good.npy", short_log(150))
    heads = dict(zip(HEADS, short_log(150).T, strict=True))
    parquet.write_table(pa.table(heads), tmp_path / "good.parquet")
    kinds = {
        0: ("m.csv", good),
        2: ("m.parquet", (tmp_path / "good.parquet").read_bytes()),
        3: ("m.npy", (tmp_path / "good.npy").read_bytes()),
    }
    alphabet = b"0123456789.,-+eE \n\r\t\"'#%[]/xnaif\x00\xff;"
    refused = 0
    for k in range(2000):
        name, sound = kinds.get(k % 4, kinds[0])
        data = bytearray(sound)
        for _ in range(rng.integers(1, 6)):
            at = int(rng.integers(0, len(data)))
            if k % 3 == 0:
                at = int(rng.integers(0, 160))
            what = rng.integers(0, 4)
            if what == 0:
                data[at] = alphabet[rng.integers(0, len(alphabet))]
            elif what == 1:
                data[at:at] = bytes([alphabet[rng.integers(0, len(alphabet))]])
            elif what == 2:
                del data[at : at + int(rng.integers(1, 40))]
            else:
                data[at:at] = data[at : at + int(rng.integers(1, 60))]
        path = tmp_path / name
        path.write_bytes(bytes(data))
        said = words_of(path, COLUMNS if path.suffix == ".npy" else None)
        assert said is None or "m." in said
        refused += said is not None
    assert 500 < refused < 2000


@pytest.mark.slow
def test_an_attitude_gives_the_bias(tmp_path, monkeypatch):
    """The mean less g and the earth's rate; level gyros are unsure of the azimuth."""
    monkeypatch.chdir(tmp_path)
    values = np.random.default_rng(2).standard_normal((20_000, 6)) * 1e-4
    gyro, force = np.array([1e-5, 2e-5, 3e-5]), np.array([0.01, 0.02, 0.03])
    procedure = {
        "name": "lab",
        "latitude": "48 deg",
        "gravity": "9.809 m/s^2",
        "sample_rate": "100 Hz",
    }
    (tmp_path / "lab.yaml").write_text(yaml.safe_dump(procedure), encoding="utf-8")
    earth = 7.292115e-5 * np.array([0.0, np.sin(np.radians(48.0)), 0.0])
    values += np.concatenate([gyro - earth, force - np.array([0.0, 9.809, 0.0])])
    heads = [f"gyro_{x} [rad/s]" for x in "xyz"]
    heads += [f"accelerometer_{x} [m/s^2]" for x in "xyz"]
    write(tmp_path / "a.csv", values, heads)
    words = ("characterise", "a.csv", "--rate", "100", "--attitude", "y down")
    found = call(*words, "--procedure", "lab.yaml", "-o", "a.yaml", "--json", "a.json")
    assert found.code == 0
    device = load_device("a.yaml")
    u = 5.0 * 1e-4 / np.sqrt(20_000.0)
    assert_allclose(device.gyro.nominal_bias, gyro, rtol=0, atol=u)
    assert_allclose(device.accelerometer.nominal_bias, force, rtol=0, atol=u)
    told = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    rows = [one for one in told["lines"] if one["line"] == "nominal.bias"]
    level = 7.292115e-5 * np.cos(np.radians(48.0)) / np.sqrt(2.0)
    per_hour = np.pi / 180.0 / 3600.0
    for one, wanted in zip(rows[:3], (level, 1e-6, level), strict=True):
        assert_allclose(one["standard_uncertainty"] * per_hour, wanted, rtol=0.35)
    refused = call(*words)
    assert refused.code == 2
    assert "name a procedure" in refused.err
    assert "allowed: z up" in call(*words[:-1], "up").err


@pytest.mark.slow
def test_white_noise_that_blocks_do_not_show_is_of_short_times(tmp_path):
    """N 2.5 deg/h sqrt(s) beside sigma 60 deg/h, tau 200 s, in blocks of 10 s."""
    rng, n, dt = np.random.default_rng(9), 2_000_000, 0.02
    y = white(rng, n, dt, 2.5) + markov(rng, n, dt, 60.0, 200.0)
    np.save(tmp_path / "a.npy", y)
    found = characterise(tmp_path / "a.npy", rate=50.0, columns="gyro_x [deg/h]")
    own = by_line(found)
    for name, truth in (("N", 2.5 / 60.0), ("sigma", 60.0), ("tau", 200.0)):
        _, (low, high), line = own["x", name]
        assert line.is_told
        assert low < truth < high, name
        assert high / low < 2.0
    low, high = own["x", "N"][1]
    assert high / low < 1.02


@pytest.mark.slow
def test_a_device_file_of_a_hostile_name_is_read_back(tmp_path, monkeypatch):
    """What cannot be seen of a name stands there as an escape."""
    monkeypatch.chdir(tmp_path)
    log = write(tmp_path / "a\n\x1b[31m{b} %s.csv", short_log())
    assert call("characterise", log.name, "-o", "d\n.yaml").code == 0
    device = load_device("d\n.yaml")
    assert device.name == "d\\n"


def test_day_and_environment_are_said_and_move_no_number(tmp_path, monkeypatch):
    """On terminal, page and JSON, as of a calibration; what nobody said as such."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "a.csv", short_log())
    write(tmp_path / "b.csv", short_log(seed=2))
    (tmp_path / "how.yaml").write_text(
        "recording: a.csv\ndate: 2026-05-31\nenvironment: {temperature: 296.55 K, "
        "humidity: 45 %, text: laboratory <3>}\n",
        encoding="utf-8",
    )
    plain, found = characterise("a.csv", "b.csv"), characterise("how.yaml", "b.csv")
    assert [one.value for one in found.lines] == [one.value for one in plain.lines]
    first, second = found.to_dict()["environment"]
    assert (first["date"], first["text"]) == ("2026-05-31", "laboratory <3>")
    assert_allclose([first["temperature"], first["humidity"]], [23.4, 45.0])
    assert (second["recording"], second["date"], second["pressure"]) == (
        *("b.csv", ""),
        None,
    )
    done = call("characterise", "how.yaml", "b.csv", "-o", "a.html")
    said = "2026-05-31, 23.4 \N{DEGREE SIGN}C, 45 % RH, laboratory <3> (how.yaml)"
    assert said in " ".join(done.out.split())
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "laboratory &lt;3&gt;" in page
    assert page.count("not stated") == 2
    assert "samples. b.csv:" in page
    assert "Circumstances" not in call("characterise", "a.csv").out


def test_one_recording_file_says_it_of_many(tmp_path, monkeypatch):
    """Counts with a gain: as the same recordings in units of their own."""
    monkeypatch.chdir(tmp_path)
    words = []
    for k in (1, 2, 3):
        values = short_log(3000, seed=k)
        write(tmp_path / f"own-{k}.csv", values)
        counts = values[:, 1:] * 2.0
        write(tmp_path / f"run-{k}.txt", np.round(counts, 7), heads=None, sep=" ")
        words.append(f"run-{k}.txt")
    (tmp_path / "how.yaml").write_text(
        "format: budget-recording/1\nrecording: run-1.txt\nrate: 100 Hz\n"
        'columns: ["gyro_x [counts]", "gyro_y [counts]", "gyro_z [counts]"]\n'
        "gain: {gyro: 2 counts/(deg/h)}\n",
        encoding="utf-8",
    )
    own = characterise(*(f"own-{k}.csv" for k in (1, 2, 3)))
    found = characterise(*words, recording="how.yaml")
    assert [one.role for one in found.inputs] == [f"recording {k}" for k in range(1, 5)]
    for one, other in zip(own.lines, found.lines, strict=True):
        assert_allclose(other.value, one.value, rtol=1e-6)
    said = call("characterise", *words, "--recording", "how.yaml", "-o", "a.yaml")
    assert said.code == 0
    twice = call("characterise", "how.yaml", "--recording", "how.yaml")
    assert twice.code == 2
    assert "is a recording file itself" in twice.err


@pytest.mark.slow
def test_white_noise_below_all_else_is_a_bound(tmp_path):
    """A process with hardly any noise, and a line: N is at most so much, no fault."""
    rng, n, dt = np.random.default_rng(10), 40_000, 0.1
    y = markov(rng, n, dt, 60.0, 50.0) + 1e-3 * rng.standard_normal(n)
    y += 5.0 * np.sin(2.0 * np.pi * 2.0 * np.arange(n) * dt)
    np.save(tmp_path / "a.npy", y)
    found = characterise(tmp_path / "a.npy", rate=10.0, columns="gyro_x [deg/h]")
    value, _, line = by_line(found)["x", "N"]
    assert line.bound == "upper"
    assert 1e-3 * np.sqrt(dt) / 60.0 < value < 0.1
    assert "2 Hz" in " ".join(map(str, found.warnings))
    measured_yaml(found)
