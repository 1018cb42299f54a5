"""Exports: values by hand, by the target's own arithmetic, and what is refused."""

from __future__ import annotations

import warnings
from dataclasses import replace
from math import exp, expm1, pi, sqrt

import numpy as np
import pytest
from keeping import catalogue
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget import analyze, load_device, load_procedure
from budget.errors import CallError
from budget.missing import fill
from budget.studies.export.study import export
from budget.studies.export.template import find_target, keys_of, targets

D2R = pi / 180.0
RATE = 200.0  # [Hz]


def device(folder, text):
    """Return a device of a file with that text."""
    path = put(folder / "imu.yaml", text)
    return load_device(path)


# Every line that a target may take, other on each axis where a file allows it.
WHOLE = """
name: whole
gyro:
  errors:
    bias_repeatability: {axes: {x: 1 deg/h, y: 2 deg/h, z: 3 deg/h}}
    bias_stability: {value: 0.5 deg/h, correlation_time: 200 s}
    angle_random_walk: 0.06 deg/sqrt(h)
    rate_random_walk: 0.6 deg/h/sqrt(h)
    scale_factor_repeatability: 30 ppm
    scale_factor_nonlinearity: 40 ppm
    mounting_repeatability:
      axes: {xy: 1 arcsec, xz: 2 arcsec, yx: 3 arcsec, yz: 4 arcsec, zx: 5 arcsec,
        zy: 6 arcsec}
    quantization: 1 arcsec
accelerometer:
  errors:
    bias_repeatability: 100 mGal
    bias_stability: {value: 10 mGal, correlation_time: 100 s}
    velocity_random_walk: 0.03 m/s/sqrt(h)
    acceleration_random_walk: 60 ug/sqrt(h)
    scale_factor_repeatability: 100 ppm
    mounting_repeatability: 10 arcsec
    scale_factor_quadratic: 20 ug/g^2
"""


def test_a_floor_of_the_allan_curve_is_exported_as_a_process_of_300_s(tmp_path):
    """No target has flicker noise: B and 300 s stand for it, and it says so."""
    text = "value: 0.5 deg/h, definition: allan_minimum"
    own = "value: 0.5 deg/h, correlation_time: 200 s"
    assert own in WHOLE
    floor = export(device(tmp_path, WHOLE.replace(own, text)), to="gazebo", rate=RATE)
    timed = f"{text}, correlation_time: 300 s"
    plain = export(device(tmp_path, WHOLE.replace(own, timed)), to="gazebo", rate=RATE)
    assert values(floor) == values(plain)
    told = " ".join(step for one in floor.entries for step in one.steps)
    assert_says(told, "the coefficient B of flicker noise", "T = 300 s, assumed")
    assert "flicker" not in " ".join(x for one in plain.entries for x in one.steps)


def values(found):
    """Return the values of an export by key, one where all axes are equal."""
    return {
        one.key: one.values[0] if len(set(one.values)) == 1 else one.values
        for one in found.entries
    }


# By hand from the printed figures of HG4930 N61-1175-000-007, variant A, whose g is
# 9.805989024 m/s^2: 0.06 deg/sqrt(h), 0.45 deg/h and 0.075 mg at the lowest point of
# the Allan curve (over 0.664, T 300 s), 0.06 m/s/sqrt(h), 20 deg/h, 3 mg, 1000 ppm,
# 750 urad; six digits.
HG4930 = {
    "kalibr": {
        "gyroscope_noise_density": 1.745329e-05,
        "gyroscope_random_walk": 2.682710e-07,
        "accelerometer_noise_density": 1.0e-03,
        "accelerometer_random_walk": 9.043550e-05,
    },
    "vins": {
        "gyr_n": 3.490659e-04,
        "acc_n": 2.0e-02,
        "gyr_w": 3.793924e-06,
        "acc_w": 1.278951e-03,
    },
    "gtsam": {
        "gyroscope_covariance": 3.046174e-10,
        "accelerometer_covariance": 1.0e-06,
        "bias_omega_covariance": 7.196931e-14,
        "bias_acc_covariance": 8.178580e-09,
    },
    "kf-gins": {
        "arw": 0.06,
        "vrw": 0.06,
        "gbstd": 0.6777108,
        "abstd": 110.7604,
        "gsstd": 1000.0,
        "asstd": 1000.0,
        "corrtime": 0.08333333,
    },
    "psins": {
        "eb": 20.0,
        "db": 3007.871,
        "web": 0.06,
        "wdb": 102.2461,
        "sqrtR0G": 0.6777108,
        "TauG": 300.0,
        "sqrtR0A": 113.2482,
        "dKGii": 1000.0,
        "dKGij": 154.6986,
        "dKAij": 154.6986,
    },
    "gazebo": {
        "angular_velocity_stddev": 2.468268e-04,
        "angular_velocity_bias_stddev": 9.696274e-05,
        "angular_velocity_dynamic_bias_stddev": 2.682710e-07,
        "linear_acceleration_stddev": 1.414214e-02,
        "linear_acceleration_bias_stddev": 2.941797e-02,
        "linear_acceleration_dynamic_bias_correlation_time": 300.0,
    },
    "ros": {
        "angular_velocity_covariance": 6.092348e-08,
        "linear_acceleration_covariance": 2.0e-04,
    },
    "matlab": {
        "gyro_NoiseDensity": 1.745329e-05,
        "gyro_Memory": 0.9999833,
        "gyro_Bias": 9.696274e-05,
        "accel_NoiseDensity": 1.0e-03,
        "accel_ScaleFactor": 1.0e-03,
        "accel_Mounting": 7.5e-04,
    },
    "nav-toolkit": {
        "arw": 0.06,
        "vrw": 0.06,
        "gb_sta": 5.555556e-03,
        "ab_sta": 2.999798,
        "gb_dyn": 1.882530e-04,
        "ab_dyn": 0.1129442,
        "gb_corr": 300.0,
        "arrw": 0.0,
    },
}
HG4930["openvins"] = HG4930["kalibr"]


@pytest.mark.parametrize("to", targets())
def test_values_of_a_published_sheet_by_hand(to):
    """Each target's figures of the HG4930 are those that its units ask for."""
    found = values(export(load_device("hg4930#A"), to=to, rate=RATE))
    for key, by_hand in HG4930[to].items():
        assert_allclose(found[key], by_hand, rtol=1e-6, err_msg=key)


def test_a_density_of_a_known_maker_is_one_sided(tmp_path):
    """ADIS16470's 0.008 deg/s/sqrt(Hz) and its 0.34 deg/sqrt(h) are one noise."""
    text = "vendor: Analog Devices\n" + WHOLE.replace("0.06 deg/sqrt(h)", "{}")
    noise = [
        values(export(device(tmp_path, text.replace("{}", one)), to="gtsam"))
        for one in ("0.008 deg/s/sqrt(Hz)", "0.34 deg/sqrt(h)")
    ]
    first, second = (one["gyroscope_covariance"] for one in noise)
    # Half a unit of the second figure's last digit.
    assert_allclose(sqrt(first), sqrt(second), rtol=0.005 / 0.34)


# ---- the target's own arithmetic, written down from its code -------------------------


def test_vins_covariance_grows_as_the_walks_do(tmp_path):
    """After 1 s of VINS' midpoint steps velocity, angle and bias have N^2 and K^2."""
    unit = device(tmp_path, WHOLE)
    found = values(export(unit, to="vins", rate=RATE))
    told = values(export(unit, to="kalibr", rate=RATE))
    dt, steps = 1.0 / RATE, int(RATE)
    for key, owner in (("gyr", "gyroscope"), ("acc", "accelerometer")):
        # V noise V^T: two samples, each with dt/2; of the bias one with dt.
        white = steps * 2.0 * (0.5 * dt * found[f"{key}_n"]) ** 2
        walk = steps * (dt * found[f"{key}_w"]) ** 2
        assert_allclose(white, told[f"{owner}_noise_density"] ** 2, rtol=1e-12)
        assert_allclose(walk, told[f"{owner}_random_walk"] ** 2, rtol=1e-12)


def test_gazebos_process_has_the_sigma_of_the_sheet(tmp_path):
    """sigma_b of gz-sensors settles to the stability; a sample has N sqrt(f)."""
    found = values(export(device(tmp_path, WHOLE), to="gazebo", rate=RATE))
    b = found["angular_velocity_dynamic_bias_stddev"]
    tau = found["angular_velocity_dynamic_bias_correlation_time"]
    dt = 1.0 / RATE
    step = -b * b * tau / 2.0 * expm1(-2.0 * dt / tau)
    settled = step / -expm1(-2.0 * dt / tau)
    assert_allclose(sqrt(settled), 0.5 * D2R / 3600.0, rtol=1e-9)
    assert_allclose(
        found["angular_velocity_stddev"], 0.06 * D2R / 60.0 * sqrt(RATE), rtol=1e-12
    )


def test_matlabs_filter_makes_the_gauss_markov_process(tmp_path):
    """White noise of BiasInstability through 1/(1 - phi/z): its sigma and its T."""
    found = values(export(device(tmp_path, WHOLE), to="matlab", rate=RATE))
    phi, w = found["gyro_Memory"], found["gyro_BiasInstability"]
    assert_allclose(w / sqrt(1.0 - phi**2), 0.5 * D2R / 3600.0, rtol=1e-9)
    assert_allclose(phi**RATE, exp(-1.0 / 200.0), rtol=1e-12)
    assert found["accel_Memory"] != phi


def test_kf_gins_and_navego_convert_back(tmp_path):
    """Their own conversions to SI, as in their code, give the figures of the sheet."""
    unit = device(tmp_path, WHOLE)
    kf = values(export(unit, to="kf-gins"))
    nav = values(export(unit, to="nav-toolkit"))
    si = values(export(unit, to="kalibr", rate=RATE))
    for arw in (kf["arw"] * D2R / 60.0, nav["arw"] / 60.0 * D2R):
        assert_allclose(arw, si["gyroscope_noise_density"], rtol=1e-12)
    for vrw in (kf["vrw"] / 60.0, nav["vrw"] / 60.0):
        assert_allclose(vrw, si["accelerometer_noise_density"], rtol=1e-12)
    assert_allclose(kf["abstd"] * 1e-5, 10e-5, rtol=1e-12)
    assert_allclose(nav["ab_dyn"] * 0.001 * 9.80665, 10e-5, rtol=1e-12)
    assert_allclose(nav["gb_dyn"] * D2R, kf["gbstd"] * D2R / 3600.0, rtol=1e-12)
    # 0.6 deg/h/sqrt(h) and 60 ug/sqrt(h) in deg/s/sqrt(h) and m/s^2/sqrt(h).
    assert_allclose(nav["arrw"], 0.6 / 3600.0, rtol=1e-12)
    assert_allclose(nav["vrrw"], 60e-6 * 9.80665, rtol=1e-12)


def test_gtsam_preintegrates_the_noise_of_the_sheet(tmp_path):
    """The covariance of GTSAM's own integration over 1 s has N^2 and K^2."""
    gtsam = pytest.importorskip("gtsam", reason="no wheel of gtsam here")
    found = values(export(device(tmp_path, WHOLE), to="gtsam"))
    params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.8)
    eye = np.eye(3)
    params.setGyroscopeCovariance(found["gyroscope_covariance"] * eye)
    params.setAccelerometerCovariance(found["accelerometer_covariance"] * eye)
    params.setBiasOmegaCovariance(found["bias_omega_covariance"] * eye)
    params.setBiasAccCovariance(found["bias_acc_covariance"] * eye)
    params.setIntegrationCovariance(1e-20 * eye)
    pim = gtsam.PreintegratedCombinedMeasurements(params)
    for _ in range(200):
        pim.integrateMeasurement(np.zeros(3), np.zeros(3), 0.005)
    # Rotation, position, velocity, bias of the accelerometers, of the gyros.
    variance = np.diag(pim.preintMeasCov())
    N, K = 0.06 * D2R / 60.0, sqrt(found["bias_omega_covariance"])
    # Beside white noise the walk of the bias adds K^2 t^3/3 (in steps of 1/200 s).
    assert_allclose(variance[:3], N**2 + K**2 / 3.0, rtol=0.02)
    accelerometer = (0.03 / 60.0) ** 2 + found["bias_acc_covariance"] / 3.0
    assert_allclose(variance[6:9], accelerometer, rtol=0.02)
    assert_allclose(variance[9:12], found["bias_acc_covariance"], rtol=1e-9)
    assert_allclose(variance[12:15], K**2, rtol=1e-9)


# ---- figures -------------------------------------------------------------------------


def test_a_walk_and_a_process_drift_as_their_root_sum_square(tmp_path):
    """K'^2 = K^2 + 2 sigma^2/T; without the walk sigma sqrt(2/T), called a proxy."""
    K = 0.6 * D2R / 3600.0 / 60.0
    proxy = 0.5 * D2R / 3600.0 * sqrt(2.0 / 200.0)
    both = export(device(tmp_path, WHOLE), to="kalibr", rate=RATE)
    text = WHOLE.replace("    rate_random_walk: 0.6 deg/h/sqrt(h)\n", "")
    alone = export(device(tmp_path, text), to="kalibr", rate=RATE)
    found = [values(one)["gyroscope_random_walk"] for one in (both, alone)]
    assert_allclose(found, [np.hypot(K, proxy), proxy], rtol=1e-12)
    for one in (both, alone):
        (row,) = (e for e in one.entries if e.key == "gyroscope_random_walk")
        assert_says(" ".join(row.steps), "proxy", "T = 200 s")
        assert_says(" ".join(one.notes), "proxy")


def test_a_walk_alone_is_no_proxy(tmp_path):
    """A device with a rate random walk and no stability is told as it is."""
    text = WHOLE.replace(
        "bias_stability: {value: 0.5 deg/h", "flicker: {value: 1 deg/h"
    )
    text = text.replace("1 deg/h, correlation_time: 200 s}", "1 deg/h}")
    found = export(device(tmp_path, text), to="kalibr", rate=RATE)
    (row,) = (e for e in found.entries if e.key == "gyroscope_random_walk")
    assert_allclose(row.values, 0.6 * D2R / 3600.0 / 60.0, rtol=1e-12)
    assert "proxy" not in " ".join(row.steps)
    assert any("gyro.flicker" in text for text in found.not_held)


def test_noise_of_a_sample_spreads_over_the_rate():
    """50 ug a sample at 100 Hz is 5 ug/sqrt(Hz), at 400 Hz half of it."""
    unit = load_device("zhao-2019")
    found = [
        values(export(unit, to="kalibr", rate=rate))["accelerometer_noise_density"]
        for rate in (100.0, 400.0)
    ]
    assert_allclose(found, [5e-6 * 9.80665, 2.5e-6 * 9.80665], rtol=1e-12)
    with pytest.raises(CallError) as caught:
        export(unit, to="gtsam")
    assert_says(str(caught.value), "accelerometer.sample_noise", "--rate")


def test_each_axis_stands_where_the_target_has_it(tmp_path):
    """Angles in the order of PSINS' matrix, axes in theirs; of one for all the most."""
    unit = device(tmp_path, WHOLE)
    psins = {one.key: one.values for one in export(unit, to="psins").entries}
    assert_allclose(psins["dKGij"], [4, 6, 5, 2, 1, 3], rtol=1e-12)
    assert_allclose(psins["eb"], [1, 2, 3], rtol=1e-12)
    assert_allclose(psins["dKGii"], 50.0, rtol=1e-12)  # 30 and 40 ppm
    # 20e-6 of g/g^2, so over g; and PSINS' ug/g^2 is 1e-6 over its own g.
    assert_allclose(psins["KA2"], 20.0 / 9.80665 * 9.7803267714, rtol=1e-12)
    matlab = {
        one.key: one.values for one in export(unit, to="matlab", rate=RATE).entries
    }
    assert_allclose(
        np.array(matlab["gyro_Mounting"]) / D2R * 3600, range(1, 7), rtol=1e-9
    )
    text = WHOLE.replace(
        "angle_random_walk: 0.06 deg/sqrt(h)",
        "angle_random_walk: {axes: {x: 1 deg/sqrt(h), y: 3 deg/sqrt(h), "
        "z: 2 deg/sqrt(h)}}",
    )
    found = export(device(tmp_path, text), to="kalibr", rate=RATE)
    (row,) = (e for e in found.entries if e.key == "gyroscope_noise_density")
    assert_allclose(row.values, [3.0 * D2R / 60.0], rtol=1e-12)
    assert_says(" ".join(row.steps), "largest")


@pytest.mark.parametrize("to", targets())
def test_inflation_multiplies_what_is_a_deviation(to, tmp_path):
    """Deviations and densities by 3, variances by 9, times not at all."""
    unit = device(tmp_path, WHOLE)
    plain = export(unit, to=to, rate=RATE)
    more = export(unit, to=to, rate=RATE, inflate=3.0)
    for one, other in zip(plain.entries, more.entries, strict=True):
        key = one.key
        timed = "corr" in key.lower() or "Tau" in key or "Memory" in key
        power = 0 if timed else 2 if "covariance" in key else 1
        assert_allclose(other.values, np.array(one.values) * 3.0**power, rtol=1e-12)


# ---- what a calibration leaves -------------------------------------------------------


def test_a_residual_is_the_budget_of_the_next_turn_on(tmp_path):
    """Constants are the u of analyze at next_turn_on; noise stays as it is."""
    unit = device(tmp_path, WHOLE)
    how = load_procedure("twelve-positions")
    left = {
        one.key: one.values
        for one in export(unit, to="psins", procedure=how, residual=True).entries
    }
    raw = {one.key: one.values for one in export(unit, to="psins").entries}
    budget = analyze(unit, procedure=how, reference="next_turn_on", validate=False)

    def u(name, size):
        rows = [budget.output(f"{name}.{axis}") for axis in "xyz"]
        return [row.standard_uncertainty / size for row in rows]

    assert_allclose(left["dKAii"], u("accelerometer.scale_factor", 1e-6), rtol=1e-12)
    micro_g = 9.7803267714e-6
    assert_allclose(left["db"], u("accelerometer.bias", micro_g), rtol=1e-12)
    assert left["db"] != raw["db"]
    for key in ("web", "wdb", "sqrtR0G", "TauG"):
        assert left[key] == raw[key]


def test_what_a_procedure_does_not_find_stays_raw_and_says_so(tmp_path):
    """A test of accelerometers leaves the gyro's figures as the sheet has them."""
    unit = device(tmp_path, WHOLE)
    how = load_procedure("six-positions")
    found = export(unit, to="psins", procedure=how, residual=True)
    raw = export(unit, to="psins")
    rows = {one.key: one for one in found.entries}
    (same,) = (one for one in raw.entries if one.key == "dKGii")
    assert rows["dKGii"].values == same.values
    assert_says(" ".join(rows["dKGii"].steps), how.name, "raw")


def test_a_residual_that_is_a_lower_bound_is_no_figure(tmp_path):
    """Without the repeatability what is left is not known, and the line is named."""
    text = WHOLE.replace("    scale_factor_repeatability: 100 ppm\n", "")
    unit = device(tmp_path, text)
    with pytest.raises(CallError) as caught:
        export(unit, to="kf-gins", residual=True)
    assert_says(str(caught.value), "asstd", "accelerometer.scale_factor_repeatability")


# ---- what is missing -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("to", "gone", "named"),
    [
        ("kalibr", "angle_random_walk: 0.06 deg/sqrt(h)", "gyro.angle_random_walk"),
        ("gazebo", "velocity_random_walk: 0.03 m/s/sqrt(h)", "velocity_random_walk"),
        ("kf-gins", "scale_factor_repeatability: 30 ppm", "gyro.scale_factor_rep"),
        ("psins", "bias_repeatability: 100 mGal", "accelerometer.bias_repeatability"),
        (
            "nav-toolkit",
            "bias_stability: {value: 10 mGal, correlation_time: 100 s}",
            "accelerometer.bias_stability",
        ),
    ],
)
def test_a_line_that_a_target_needs_is_never_made_up(to, gone, named, tmp_path):
    """The export is refused and names the key and the line."""
    unit = device(tmp_path, WHOLE.replace(f"    {gone}\n", ""))
    with pytest.raises(CallError) as caught:
        export(unit, to=to, rate=RATE)
    assert named in str(caught.value)


def test_what_a_target_can_do_without_is_left_out_in_words(tmp_path):
    """No bias of a turn-on: Gazebo has no such key; PSINS has 0 where 0 is none."""
    text = WHOLE.replace(
        "    bias_stability: {value: 0.5 deg/h, correlation_time: 200 s}\n", ""
    )
    unit = device(tmp_path, text)
    gazebo = export(unit, to="gazebo", rate=RATE)
    assert "angular_velocity_dynamic_bias_stddev" not in values(gazebo)
    assert_says(
        " ".join(gazebo.left_out),
        "angular_velocity_dynamic_bias_stddev",
        "gyro.bias_stability",
    )
    psins = export(unit, to="psins")
    assert values(psins)["sqrtR0G"] == values(psins)["TauG"] == 0.0
    assert_says(" ".join(psins.left_out), "sqrtR0G", "gyro.bias_stability")


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_what_stands_for_a_missing_line_is_told(mode):
    """Of comparable devices, in the steps and among the assumptions; never as given."""
    unit = load_device("adis16495-1")
    name = "accelerometer.velocity_random_walk"
    with pytest.raises(CallError, match="--missing"):
        export(unit, to="gtsam")
    filled, filling = fill(unit, mode, catalogue())
    line = next((one for one in filling.lines if one.source == name), None)
    if line is None:
        with pytest.raises(CallError, match="velocity_random_walk"):
            export(unit, to="gtsam", missing=mode, catalogue=catalogue())
        return
    found = export(unit, to="gtsam", missing=mode, catalogue=catalogue())
    (row,) = (e for e in found.entries if e.key == "accelerometer_covariance")
    assert_allclose(
        np.sqrt(row.values),
        filled.accelerometer.line(line.source.quantity).u,
        rtol=1e-9,
    )
    assert line.words in row.steps[0]
    assert any(line.words in text for text in found.assumptions)
    assert found.to_dict()["settings"]["missing"] == mode


def test_a_filled_line_is_no_line_that_the_device_has():
    """What the target has no place for is not listed where nobody gives it."""
    unit = load_device("adis16495-1")
    how = dict(missing="predict", catalogue=catalogue())
    found = export(unit, to="gtsam", **how)
    assert not any("mounting_repeatability" in text for text in found.not_held)


def test_numbers_are_short_where_rounding_alone_makes_them_long():
    """0.06 deg/sqrt(h) there and back is 0.06; what is no short number keeps all."""
    found = values(export(load_device("hg4930#A"), to="matlab", rate=RATE))
    assert values(export(load_device("hg4930#A"), to="psins"))["web"] == 0.06
    assert values(export(load_device("hg4930#A"), to="psins"))["dKGii"] == 1000.0
    assert found["gyro_Memory"] == exp(-1.0 / (RATE * 300.0))


ZERO = "{value: 0 deg/sqrt(h), meaning: exact}"


def test_zero_is_refused_where_the_target_reads_none(tmp_path):
    """Kalibr raises on a noise of 0: so does the export, naming the line."""
    unit = device(tmp_path, WHOLE.replace("0.06 deg/sqrt(h)", ZERO))
    with pytest.raises(CallError) as caught:
        export(unit, to="kalibr", rate=RATE)
    assert_says(str(caught.value), "gyro.angle_random_walk", "above 0")


def test_what_a_target_cannot_hold_is_listed(tmp_path):
    """Every given line is in the file or in the list of what is not."""
    unit = device(tmp_path, WHOLE)
    given = {f"{one.kind}.{line.name}" for one in unit.sensors for line in one.lines}
    for to in targets():
        found = export(unit, to=to, rate=RATE)
        held = {str(line) for one in found.entries for line in one.lines}
        lost = {text.partition(": ")[0] for text in found.not_held}
        assert held.isdisjoint(lost)
        assert held | lost == given, to


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (dict(to="kalibr"), ("--rate",)),
        (dict(to="kalibr", rate=0.0), ("rate", "0.0 Hz")),
        (dict(to="gtsam", rate=RATE, inflate=0.5), ("inflate", "0.5", "1 to")),
        (dict(to="gtsam", inflate=float("nan")), ("inflate",)),
        (dict(to="ekf2"), ("ekf2", "kalibr", "nav-toolkit")),
        (dict(to="gtsam", procedure=load_procedure(None)), ("--residual",)),
        (dict(to="kalibr", rate=RATE, residual=True), ("--residual", "changes no key")),
    ],
)
def test_a_call_that_means_nothing_is_refused(how, words, tmp_path):
    """A rate that is not there, a factor below 1, no such target, a useless option."""
    with pytest.raises(CallError) as caught:
        export(device(tmp_path, WHOLE), **how)
    assert_says(str(caught.value), *words)


def test_half_an_imu_is_refused(tmp_path):
    """A gyro alone: the other triad is named, and that a second file may bring it."""
    unit = replace(device(tmp_path, WHOLE), accelerometer=None)
    with pytest.raises(CallError) as caught:
        export(unit, to="kalibr", rate=RATE)
    assert_says(str(caught.value), "accelerometer", "beside")


def test_every_target_says_where_its_keys_were_read():
    """No target without a source; keys are unique within it."""
    for name, target in targets().items():
        assert target.sources
        assert all("http" in text or "the same" in text for text in target.sources)
        assert keys_of(target)
        assert find_target(name) is target


@pytest.mark.parametrize("to", targets())
@pytest.mark.parametrize("time", ["1e-9 s", "1e9 s"])
def test_processes_of_any_speed_are_exported_without_a_warning(to, time, tmp_path):
    """Nothing is left of a fast one after a sample, and each step is sigma."""
    text = (
        "name: x\ngyro: {errors: {angle_random_walk: 1 deg/sqrt(h), "
        "bias_repeatability: 1 deg/h, scale_factor_repeatability: 9 ppm,"
        f" bias_stability: {{value: 1 deg/h, correlation_time: {time}}}}}}}\n"
        "accelerometer: {errors: {velocity_random_walk: 1 m/s/sqrt(h), "
        "bias_repeatability: 1 mg, scale_factor_repeatability: 9 ppm, "
        f"bias_stability: {{value: 1 mg, correlation_time: {time}}}}}}}\n"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = values(export(device(tmp_path, text), to=to, rate=200.0))
    assert all(np.isfinite(one).all() for one in found.values())
    if to == "matlab" and time == "1e-9 s":
        assert_allclose(found["gyro_BiasInstability"], D2R / 3600.0, rtol=1e-14)
