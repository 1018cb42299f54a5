"""Lines that are not given are predicted with the spread that they really have."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from math import inf, log, sqrt

import numpy as np
import pytest
from keeping import catalogue
from numpy.testing import assert_allclose
from places import DOCS
from scipy.special import stdtrit

from budget import load_device
from budget.missing import prediction
from budget.missing.prediction import (
    DF_0,
    LEAST_DESIGNS,
    LEVELS,
    ROUNDS,
    TAILS,
    Fit,
    LogLine,
    _others,
    figures_of,
    joined,
    predict,
)
from budget.names import Name

WHOLE = sum(v for v, _ in LEVELS.values())
BIAS = Name("bias_repeatability", owner="gyro")
G_SENSITIVITY = Name("g_sensitivity", owner="gyro")


def figure(design, line="a", log_u=0.0, *, device="1", technology=None):
    """Return a line of a design, of a technology of its own unless one is named."""
    own = f"{design} {device}"
    groups = (technology or design, design, own, f"{own} gyro")
    return LogLine(groups=groups, line=line, device=own, log_u=log_u)


@pytest.fixture(scope="module")
def script():
    """Return the script that hides every line of the catalogue in turn."""
    path = DOCS / "make_missing.py"
    spec = importlib.util.spec_from_file_location("make_missing", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where its dataclasses look
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def cases(script):
    """Return what the script makes of the catalogue: 200 fits."""
    return script.leave_one_out(catalogue())


@pytest.fixture
def normal_tails(monkeypatch):
    """Take the effects of designs for normal ones."""
    monkeypatch.setattr(prediction, "TAILS", inf)
    monkeypatch.setattr(prediction, "ROUNDS", 0)


@pytest.mark.usefixtures("normal_tails")
@pytest.mark.parametrize("n", [3, 5, 40])
def test_one_line_of_unlike_designs_is_the_t_of_a_new_observation(n):
    """x0 (X'X)^-1 x0' + 1 of a mean is 1 + 1/n; the prior is DF_0 observations.

    With normal effects, that weigh all designs alike.
    """
    y = np.random.default_rng(n).normal(2.0, 1.5, n)
    given = [figure(f"d{k}", log_u=value) for k, value in enumerate(y)]
    found = Fit.of(given).predict({BIAS: figure("new")})
    df = DF_0 + n - 1
    squares = float(np.square(y - y.mean()).sum())
    s2 = (DF_0 * WHOLE + squares) / df * (1.0 + 1.0 / n)

    assert found.df == df
    assert_allclose(found.location, [y.mean()], rtol=1e-12)
    assert_allclose(found.scale, [[s2]], rtol=1e-12)
    half = stdtrit(df, 0.95) * sqrt(s2)
    assert_allclose(
        np.log(found.interval(0.9)[0]),
        [y.mean() - half, y.mean() + half],
        rtol=1e-9,
    )


def test_weights_of_unlike_designs_are_those_of_a_student_t():
    """By hand: w = (TAILS + 1)/(TAILS + d^2), of one line and designs of their own."""
    y = np.append(np.random.default_rng(3).normal(0.0, 1.0, 12), -9.0)
    given = [figure(f"d{k}", log_u=value) for k, value in enumerate(y)]
    found = Fit.of(given).predict({BIAS: figure("new")})
    wide = LEVELS["technology"][0]
    narrow = WHOLE - wide
    w, df = np.ones(y.size), DF_0 + y.size - 1
    for _ in range(ROUNDS + 1):
        K = wide + narrow / w
        mean = np.average(y, weights=1.0 / K)
        s2 = (DF_0 + np.sum((y - mean) ** 2 / K)) / df
        last = w
        own = (narrow / w) / K * (y - mean)
        w = (TAILS + 1.0) / (TAILS + own**2 / narrow / s2)

    assert_allclose(found.location, [mean], rtol=1e-9)
    assert_allclose(found.scale, [[s2 * (WHOLE + 1.0 / (1.0 / K).sum())]], rtol=1e-9)
    assert found.df == TAILS
    assert last[-1] < 0.2
    assert last[:-1].min() > 0.35


def test_designs_of_another_class_widen_no_interval(monkeypatch):
    """Accelerometers for earthquakes are a hundred times as quiet as those of phones.

    Where the noise of MEMS accelerometers is predicted the 90 % interval is 19:1 in
    the middle of the devices; normal effects made it 264:1, and 32:1 without the two.
    """
    noise = Name("noise", owner="accelerometer")
    seismic = {"M-A352AD10", "M-A370AD10"}
    lacking = [
        one
        for one in catalogue()
        if "mems" in one.technology.casefold()
        if one.accelerometer is not None
        if noise in one.accelerometer.expected_missing
    ]

    def widths():
        _others.cache_clear()
        ends = [predict(one, [noise], catalogue()).interval(0.9)[0] for one in lacking]
        return np.median([high / low for low, high in ends])

    try:
        robust = widths()
        trust = _others(catalogue()).fits([()])[0].trust
        for one in catalogue():
            if one.name in seismic:
                assert trust[one.origin.sha256] < 0.2
        monkeypatch.setattr(prediction, "ROUNDS", 0)
        monkeypatch.setattr(prediction, "TAILS", inf)
        normal = widths()
    finally:
        _others.cache_clear()
    assert len(lacking) >= 5
    assert 10.0 < robust < 40.0
    assert normal > 5.0 * robust


def test_a_design_far_off_is_predicted_less_surely():
    """Its own given line shows it of another class: its other lines may be, too."""
    rng = np.random.default_rng(8)
    given = [
        figure(f"d{k}", line, float(rng.normal()))
        for k in range(40)
        for line in ("a", "b")
    ]

    def width(a):
        own = figure("new", "a", a)
        found = Fit.of([*given, own]).predict({BIAS: figure("new", "b")})
        assert found.df == TAILS + 1.0
        return sqrt(found.scale[0, 0])

    assert width(8.0) > 1.5 * width(0.0)
    assert width(-8.0) > 1.5 * width(0.0)


def test_a_given_line_of_the_same_device_predicts_the_missing_one():
    """Designs good in one line are good in the other: the slope is that of the law.

    With the effects of LEVELS the covariance of two lines over the variance of one is
    the slope of the regression; the mean being known it is exact.
    """
    rng = np.random.default_rng(2)
    slope = sum(v * rho for v, rho in LEVELS.values()) / WHOLE
    given = [
        figure(f"d{k}", line, float(rng.normal()))
        for k in range(200)
        for line in ("a", "b")
    ]

    def at(a):
        new = figure("new", "b")
        own = figure("new", "a", a)
        return Fit.of([*given, own]).predict({BIAS: new})

    low, high = at(-2.0), at(2.0)
    rise = float(high.location[0] - low.location[0]) / 4.0
    alone = Fit.of(given).predict({BIAS: figure("new", "b")})

    assert_allclose(rise, slope, rtol=0.05)  # r of the two lines differ by chance
    assert at(0.0).scale[0, 0] < alone.scale[0, 0]


def test_variants_of_a_design_are_no_further_witnesses():
    """Ten variants of each of four designs make the prediction hardly any surer."""
    y = [0.0, 1.0, -1.0, 0.5]
    once = [figure(f"d{k}", log_u=value) for k, value in enumerate(y)]
    rng = np.random.default_rng(1)
    often = [
        figure(f"d{k}", log_u=value + 0.3 * rng.normal(), device=str(j))
        for k, value in enumerate(y)
        for j in range(10)
    ]
    independent = [
        figure(f"d{k} {j}", log_u=one.log_u)
        for j in range(10)
        for k, one in enumerate(once)
    ]
    new = {BIAS: figure("new")}
    few, many, free = (
        float(Fit.of(those).predict(new).scale[0, 0])
        for those in (once, often, independent)
    )

    assert many > 0.5 * few
    assert free / WHOLE < 0.8 * few / WHOLE


def test_too_few_designs_predict_nothing():
    """However many variants there are, the spread between designs is not known."""
    n = LEAST_DESIGNS - 1
    given = [
        figure(f"d{k}", log_u=1.0, device=str(j)) for k in range(n) for j in range(9)
    ]
    assert Fit.of(given).predict({BIAS: figure("new")}) is None
    assert Fit.of([*given, figure("one more")]).predict({BIAS: figure("new")})


def test_missing_lines_go_together():
    """Two lines that a device lacks are drawn jointly, with a positive correlation."""
    device = load_device("stim210")
    missing = device.gyro.expected_missing
    found = predict(device, missing, catalogue())
    u = np.sqrt(np.diag(found.scale))
    correlation = found.scale / np.outer(u, u)

    assert found.names == missing
    assert correlation[np.triu_indices(len(missing), 1)].min() > 0.05
    assert found.of(missing[:1]).location == found.location[:1]


def test_the_device_itself_is_no_witness_twice():
    """In the catalogue or beside it, the same lines predict the same."""
    device = load_device("sch16t-k01")
    missing = device.gyro.expected_missing
    others = [one for one in catalogue() if one.name != device.name]
    inside, outside = (
        predict(device, missing, those) for those in (catalogue(), others)
    )

    assert_allclose(inside.location, outside.location, rtol=1e-9)
    assert_allclose(inside.scale, outside.scale, rtol=1e-9)
    # Out of a copy of its file, which is none of the catalogue's, it is the same.
    copy = replace(device, origin=replace(device.origin, sha256="copy"))
    again = predict(copy, missing, catalogue())
    assert_allclose(again.location, inside.location, rtol=1e-12)
    assert_allclose(again.scale, inside.scale, rtol=1e-12)


def test_devices_that_make_one_unit_keep_their_tails():
    """Intervals of a device, and what is taken out again, are those of it alone."""
    one, other = (
        predict(device, device.gyro.expected_missing, catalogue())
        for device in (load_device("ltm210#S1B"), load_device("stim210"))
    )
    both = joined([one, other])

    assert one.df > other.df == both.df
    assert_allclose(both.interval(0.9)[0], one.interval(0.9)[0], rtol=1e-12)
    again = joined([one, replace(other, names=(G_SENSITIVITY,) * 4)]).of(one.names)
    assert again.df == one.df
    assert_allclose(again.interval(0.9), one.interval(0.9), rtol=1e-12)


def test_a_better_device_is_predicted_to_be_better():
    """A tenth of the given bias stability lessens every missing line."""
    device = load_device("adis16495-1")
    line = device.gyro.line("bias_stability")
    better = replace(
        device,
        name="better",
        origin=replace(device.origin, sha256="1"),
        gyro=replace(
            device.gyro,
            lines=tuple(
                replace(one, u=0.1 * one.u) if one is line else one
                for one in device.gyro.lines
            ),
        ),
    )
    missing = device.gyro.expected_missing
    then, now = (
        predict(one, missing, catalogue()).location for one in (better, device)
    )
    assert (then < now - 0.1 * log(10.0)).all()


@pytest.mark.slow
def test_intervals_hold_what_the_catalogue_prints(script, cases):
    """Each line of each design hidden in turn: 50 and 90 % hold as many as they say."""
    for level in script.LEVELS:
        low, high = script.bounds(len(cases), level)
        inside = sum(case.inside(level) for case in cases)
        assert low <= inside <= high
        # Control: intervals of a third of the width hold too few.
        third = sum(
            float(np.mean(np.abs(np.array(case.p) - 0.5) <= level / 6.0))
            for case in cases
        )
        assert third < low
    assert len(cases) > 60


@pytest.mark.slow
def test_intervals_hold_on_catalogues_drawn_from_the_law():
    """Of 400 catalogues of 6 unlike designs, 90 % of the intervals hold a new one."""
    rng = np.random.default_rng(5)
    runs, inside = 400, 0
    for _ in range(runs):
        y = rng.normal(0.0, sqrt(WHOLE), 7)
        given = [figure(f"d{k}", log_u=value) for k, value in enumerate(y[:-1])]
        low, high = np.log(Fit.of(given).predict({BIAS: figure("n")}).interval(0.9)[0])
        inside += low <= y[-1] <= high
    # sigma^2 is 1 here as in the prior: a little wide rather than a little narrow.
    assert abs(inside / runs - 0.9) < 3.0 * sqrt(0.9 * 0.1 / runs)


def test_the_page_has_the_table_of_the_script(script, cases, tmp_path, monkeypatch):
    """The table in the page is that of the catalogue as it is."""

    def of_those(devices):
        """Return the cases, of devices that are those of the catalogue."""
        assert [figures_of(one) for one in devices] == [*map(figures_of, catalogue())]
        return cases

    monkeypatch.setattr(script, "leave_one_out", of_those)
    script.write(tmp_path)

    made, kept = (
        (folder / script.PAGE).read_text(encoding="utf-8")
        for folder in (tmp_path, DOCS)
    )
    assert made == kept
    assert "median factor" in kept


def test_nothing_is_predicted_from_nothing():
    """Without any figure, of others or of its own, there is no prediction."""
    device = load_device("stim210")
    bare = replace(device, gyro=replace(device.gyro, lines=device.gyro.lines[1:]))

    assert predict(bare, device.gyro.expected_missing, ()) is None
