"""Simulated recordings: one seed one text; what is drawn is in it, and found again."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from command_line import call
from numpy.testing import assert_allclose
from scipy.stats import binom, norm

from budget.errors import CallError
from budget.inputs import load_device, load_recording
from budget.inputs.recording import with_columns
from budget.methods.noise_fit import (
    AT_68,
    AT_95,
    LikelihoodProfile,
    fit_noise,
    profile_interval,
)
from budget.recordings.log import read_logs
from budget.recordings.noise import block_means
from budget.recordings.simulated import PIECE, simulated_recording
from budget.units import size_of

DEVICE = {
    "format": "budget-device/1",
    "name": "three kinds of noise",
    "gyro": {
        "errors": {
            "bias_repeatability": "30 deg/h",
            "scale_factor_repeatability": "2000 ppm",
            "angle_random_walk": "0.15 deg/sqrt(h)",
            "bias_stability": {
                "axes": {
                    "x": {
                        "value": "6 deg/h",
                        "definition": "sigma",
                        "correlation_time": "20 s",
                    },
                    "y": {"value": "0 deg/h", "meaning": "exact"},
                    "z": {"value": "0 deg/h", "meaning": "exact"},
                },
            },
            "rate_random_walk": {
                "axes": {
                    "x": "0 deg/h/sqrt(h)",
                    "y": "60 deg/h/sqrt(h)",
                    "z": "0 deg/h/sqrt(h)",
                },
            },
        }
    },
}
MODELS = {"x": "gm", "y": "rw", "z": "white"}
SEEDS = 200


def whole(made):
    """Return all of a recording, shape (n, columns)."""
    return np.concatenate(list(made.pieces()))


def test_one_seed_gives_one_text(tmp_path, monkeypatch):
    """The same bytes, wherever it goes; those of another seed are others."""
    monkeypatch.chdir(tmp_path)
    words = ("simulate", "hg4930#A", "--static", "20 s", "--rate", "100")
    for name, more in (("a", ()), ("b", ()), ("c", ("--seed", "1"))):
        assert call(*words, *more, "-o", f"{name}.csv").code == 0
    texts = [(tmp_path / f"{x}.csv").read_bytes() for x in "abc"]
    assert texts[0] == texts[1] == call(*words, "-o", "-").out.encode()
    assert texts[0] != texts[2]
    head, first, *rest = texts[0].decode().splitlines()
    assert head.startswith("time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],acc")
    assert first.startswith("0,")
    assert len(rest) == 1999


def test_what_is_drawn_is_in_it(tmp_path, monkeypatch):
    """Means are K (M u + b) of the file of what was drawn, to their noise."""
    monkeypatch.chdir(tmp_path)
    made = simulated_recording("hg4930#A", static="1 h", rate=20.0, seed=4)
    words = ("simulate", "hg4930#A", "--static", "1 h", "--rate", "20", "--seed", "4")
    assert call(*words, "-o", "a.csv", "--truth", "a.yaml").code == 0
    truth = yaml.safe_load((tmp_path / "a.yaml").read_text(encoding="utf-8"))

    def numbers(said):
        found = [text.split(" ", 1) for text in said.values()]
        return np.array([float(value) * size_of(unit) for value, unit in found])

    mean = whole(made).mean(axis=0)[1:]
    L = made.procedure.latitude
    earth = 7.292115e-5 * np.array([0.0, np.cos(L), np.sin(L)])
    gravity = np.array([0.0, 0.0, made.procedure.gravity])
    for k, (sensor, u) in enumerate((("gyro", earth), ("accelerometer", gravity))):
        own = truth[sensor]
        xy, xz, yx, yz, zx, zy = numbers(own["mounting_angle"])
        M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])
        expected = M @ u + numbers(own["bias"])
        if sensor == "gyro":
            G = numbers(own["constants"]["g_sensitivity"]).reshape(3, 3)
            expected += G @ gravity
        expected *= 1.0 + numbers(own["scale_factor"])
        # In-run bias, as it stands over an hour: 1 deg/h and 120 ug, five times.
        slow = (5.0 * size_of("deg/h"), 600.0 * size_of("ug"))[k]
        assert_allclose(mean[3 * k : 3 * k + 3], expected, rtol=0, atol=slow)
    assert truth["seed"] == 4
    assert truth["gyro"]["processes"]["angle_random_walk"]["x"] == "0.06 deg/sqrt(h)"


def test_pieces_go_on_where_the_one_before_ended():
    """A random walk has no step between them: the largest is that of any other."""
    device = load_device(
        DEVICE,
        {"gyro.angle_random_walk": "1e-6 deg/sqrt(h)"},
    )
    made = simulated_recording(device, static=2.5 * PIECE / 100.0, rate=100.0)
    y = whole(made)[:, 2]
    steps = np.abs(np.diff(y))
    u = 60.0 * size_of("deg/h/sqrt(h)") / np.sqrt(100.0)
    most = norm.isf(1e-9 / 2) * u * 1.1
    assert steps[PIECE - 1] < most
    assert steps[2 * PIECE - 1] < most
    assert_allclose(np.sqrt(np.mean(steps**2)), u, rtol=4.0 / np.sqrt(2.0 * steps.size))


def test_what_is_not_given_is_named(tmp_path, monkeypatch):
    """A recording without an in-run bias looks better than the unit is."""
    monkeypatch.chdir(tmp_path)
    words = ("simulate", "icm-20948", "--static", "10 s", "-o")
    found = call(*words, "a.csv")
    assert "Not in it" in found.out
    assert "gyro bias stability" in found.out
    assert "warning: gyro.bias_stability is not given" in call(*words, "-").err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--static", "2"), "did you mean '2 s'"),
        (("--static", "1 ms"), "expected 100 to 1e+09"),
        (("--static", "100 years"), "expected 100 to 1e+09"),
        (("--static", "nan h"), "found 'nan h'"),
        (("--static", "1 h", "--rate", "0"), "no sampling rate"),
    ],
)
def test_what_is_none_is_refused(words, said, tmp_path, monkeypatch):
    """With what is allowed, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    found = call("simulate", "hg4930#A", *words, "-o", "a.csv")
    assert found.code == 2
    assert said in found.err
    assert not any(tmp_path.iterdir())


def test_files_of_other_names_are_refused(tmp_path, monkeypatch):
    """A recording is text, what was drawn YAML; one of them may go to stdout."""
    monkeypatch.chdir(tmp_path)
    words = ("simulate", "hg4930#A", "--static", "10 s", "-o")
    assert "ends in .csv" in call(*words, "a.npy").err
    assert "ends in .yaml" in call(*words, "a.csv", "--truth", "a.csv").err
    assert "both write to stdout" in call(*words, "-", "--truth", "-").err
    with pytest.raises(CallError, match="rate is nan"):
        simulated_recording("hg4930#A", static=10.0, rate=float("nan"))
    assert not any(tmp_path.iterdir())


def fitted(device, seed, folder, axis):
    """Return the model of an axis of the recording of one seed."""
    made = simulated_recording(device, static=1024.0, rate=10.0, seed=seed)
    path = folder / "a.npy"
    np.save(path, whole(made))
    heads = "time [s]," + ",".join(f"gyro_{x} [rad/s]" for x in "xyz")
    (log,) = read_logs(with_columns(load_recording(path), columns=heads))
    runs = block_means([(log, log.channels[f"gyro_{axis}"])], 10)
    return fit_noise(runs, MODELS[axis])


@pytest.mark.slow
@pytest.mark.parametrize("axis", MODELS)
def test_what_is_drawn_is_found_again(axis, tmp_path):
    """95 % intervals hold the truth in 181 to 198 of 200, 68 % ones in 114 to 158.

    Those that are as likely as the ends of an interval, or more, are in it: of half of
    the seeds the ends are found. Halved intervals are of 67 %, and fail.
    """
    device = load_device(DEVICE)
    truth = {"N": 0.15 * size_of("deg/sqrt(h)"), "sigma": 6.0 * size_of("deg/h")}
    truth |= {"tau": 20.0, "K": 60.0 * size_of("deg/h/sqrt(h)")}
    held, halved = {}, {}
    for seed in range(SEEDS):
        fit = fitted(device, seed, tmp_path, axis)
        for name, value in fit.values.items():
            place = np.log(truth[name])
            short = fit.log_likelihood + LikelihoodProfile(fit, name).cost(place)
            is_in = [2.0 * short <= AT_95, 2.0 * short <= AT_68]
            held.setdefault(name, []).append(is_in)
            if seed < SEEDS // 2:
                low, high = ends = profile_interval(fit, name, AT_95)
                assert (low <= truth[name] <= high) == is_in[0], (name, seed)
                low, high = np.sqrt(np.multiply(ends, value))
                halved.setdefault(name, []).append(low <= truth[name] <= high)
    assert (
        held.keys() == {"x": {"N", "sigma", "tau"}, "y": {"N", "K"}, "z": {"N"}}[axis]
    )
    low, high = 181, 198
    assert binom.cdf(low - 1, SEEDS, 0.95) + binom.sf(high, SEEDS, 0.95) < 0.005
    near_low, near_high = binom.interval(0.999, SEEDS, 0.683)
    for name, own in held.items():
        wide, near = np.sum(own, axis=0)
        assert low <= wide <= high, (name, wide)
        assert near_low <= near <= near_high, (name, near)
        assert 2 * sum(halved[name]) < low, (name, sum(halved[name]))
