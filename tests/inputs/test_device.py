"""Device files: the paper's figures and every convention of data sheets."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import put

from budget.errors import SpecError
from budget.inputs import load_device
from budget.model.sources import SENSORS, lines_of, source_of
from budget.model.sources.processes import FlickerNoise, Stability, WhiteNoise

DEG = pi / 180.0
DEG_H = DEG / 3600.0
ARCSEC = DEG / 3600.0
UG = 9.80665e-6


@pytest.fixture
def gyro(tmp_path):
    """Return a function that reads a device of one gyro from its error lines."""

    def read(*lines, head=""):
        path = tmp_path / "device.yaml"
        errors = "".join(f"    {line}\n" for line in lines)
        path.write_text(f"name: x\n{head}gyro:\n  errors:\n{errors}")
        return load_device(path)

    return read


# Zhao 2019, section 3, as the shipped file prints them.
PAPER = {
    "gyro": {
        "bias_repeatability": ("0.05 deg/h", 0.05 * DEG_H),
        "bias_stability": ("0.04 deg/h", 0.04 * DEG_H),
        "angle_random_walk": ("0.005 deg/sqrt(h)", 0.005 * DEG / 60.0),
        "scale_factor_repeatability": ("50 ppm", 50e-6),
        "mounting_repeatability": ("2 arcsec", 2.0 * ARCSEC),
    },
    "accelerometer": {
        "bias_repeatability": ("37 ug", 37.0 * UG),
        "bias_stability": ("20 ug", 20.0 * UG),
        "sample_noise": ("50 ug", 50.0 * UG),
        "scale_factor_repeatability": ("37 ppm", 37e-6),
        "mounting_repeatability": ("2 arcsec", 2.0 * ARCSEC),
    },
}


@pytest.mark.parametrize("kind", SENSORS)
def test_the_shipped_device_has_the_figures_of_the_paper(kind):
    """Every line, its text and its value are those of Zhao 2019; nothing is added."""
    sensor = getattr(load_device("zhao-2019"), kind)
    assert [line.name for line in sensor.lines] == list(PAPER[kind])
    for line in sensor.lines:
        printed, u = PAPER[kind][line.name]
        assert line.printed == printed
        axes = 6 if line.name == "mounting_repeatability" else 3
        assert_allclose(line.u, [u] * axes, rtol=1e-15)
        assert {shape.name for shape in line.distributions} == {"normal"}
    assert_allclose(sensor.line("bias_stability").correlation_time, 300.0, rtol=0)


def test_the_shipped_device_has_the_nominal_values_of_the_paper():
    """2.5 deg/h, 6 mg and 2 arcsec stand on every axis."""
    device = load_device("zhao-2019")
    assert_allclose(device.gyro.nominal_bias, [2.5 * DEG_H] * 3, rtol=1e-15)
    assert_allclose(device.accelerometer.nominal_bias, [6000.0 * UG] * 3, rtol=1e-15)
    for sensor in device.sensors:
        assert_allclose(sensor.nominal_mounting_angle, [2.0 * ARCSEC] * 6, rtol=1e-15)


def test_the_shipped_device_needs_no_assumption_and_misses_nothing_expected():
    """What the paper does not give is listed; what a verdict needs is there."""
    device = load_device("zhao-2019")
    assert device.assumptions == ()
    assert device.gyro.not_given == (
        "gyro.rate_random_walk",
        "gyro.quantization",
        "gyro.scale_factor_nonlinearity",
        "gyro.scale_factor_asymmetry",
        "gyro.g_sensitivity",
        "gyro.scale_factor_quadratic",
        "gyro.scale_factor_cubic",
        "gyro.bias_over_temperature",
        "gyro.scale_factor_over_temperature",
        "gyro.ageing",
        "gyro.scale_factor_ageing",
        "gyro.vibration_rectification",
    )
    assert device.accelerometer.not_given == (
        "accelerometer.acceleration_random_walk",
        "accelerometer.quantization",
        "accelerometer.scale_factor_nonlinearity",
        "accelerometer.scale_factor_asymmetry",
        "accelerometer.scale_factor_quadratic",
        "accelerometer.scale_factor_cubic",
        "accelerometer.bias_over_temperature",
        "accelerometer.scale_factor_over_temperature",
        "accelerometer.ageing",
        "accelerometer.scale_factor_ageing",
        "accelerometer.vibration_rectification",
    )
    assert [sensor.expected_missing for sensor in device.sensors] == [(), ()]


def test_the_bare_name_and_the_file_are_one_device():
    """'zhao-2019' is the shipped file, by its bytes."""
    bare = load_device("zhao-2019")
    assert bare.origin.file == "zhao-2019.yaml"
    assert len(bare.origin.sha256) == 64
    assert bare.gyro.device == bare.name == "Zhao 2019 optical IMU"


# u of a value of 6 deg/h, by what the maker means with it (JCGM 100:2008, 4.3).
MEANINGS = {
    "meaning: 1 sigma": (6.0, "normal"),
    "meaning: 2 sigma": (3.0, "normal"),
    "meaning: 3 sigma": (2.0, "normal"),
    "meaning: rms": (6.0, "normal"),
    "meaning: typical": (6.0, "normal"),
    "meaning: max": (6.0 / sqrt(3.0), "uniform"),
    "meaning: peak to peak": (3.0 / sqrt(3.0), "uniform"),
    "meaning: max, distribution: uniform": (6.0 / sqrt(3.0), "uniform"),
    "meaning: max, distribution: triangular": (6.0 / sqrt(6.0), "triangular"),
    "meaning: max, distribution: arcsine": (6.0 / sqrt(2.0), "arcsine"),
    "meaning: peak to peak, distribution: arcsine": (3.0 / sqrt(2.0), "arcsine"),
    "meaning: 2 sigma, distribution: uniform": (3.0, "uniform"),
    "distribution: triangular": (6.0, "triangular"),
}


@pytest.mark.parametrize("words", MEANINGS)
def test_a_meaning_gives_its_standard_uncertainty_and_shape(gyro, words):
    """A sigma divides the value, a half-width goes through its distribution."""
    u, shape = MEANINGS[words]
    line = gyro(f"bias_repeatability: {{value: 6 deg/h, {words}}}").gyro.lines[0]
    assert_allclose(line.u, [u * DEG_H] * 3, rtol=1e-14)
    assert {one.name for one in line.distributions} == {shape}


CURVES = {
    "full_scale: 300 deg/s": ("cubic", 4.0, 2),
    "full_scale: 300 deg/s, line: best, shape: quadratic": ("quadratic", 2.0, 1),
    "full_scale: 300 deg/s, line: least_squares": ("cubic", 2.5, 2),
    "full_scale: 300 deg/s, line: least_squares, shape: quadratic": (
        "quadratic",
        1.5,
        1,
    ),
}


@pytest.mark.parametrize("words", CURVES)
def test_a_nonlinearity_of_a_full_scale_is_the_coefficient_of_a_curve(gyro, words):
    """K_p is the factor times NL over R^(p-1); what it does not say is assumed."""
    form, factor, power = CURVES[words]
    device = gyro(f"scale_factor_nonlinearity: {{value: 30 ppm, {words}}}")
    (line,) = device.gyro.lines
    assert line.form == form
    assert_allclose(line.u, factor * 30e-6 / (300.0 * DEG) ** power, rtol=1e-14)
    assert_allclose(line.u / line.si_per_unit, 30.0, rtol=1e-14)
    said = [f"{key} not given" for key in ("line", "shape") if f"{key}:" not in words]
    assert len(device.assumptions) == len(said) + 2  # and the nominal values
    assert all(any(one in text for text in device.assumptions) for one in said)


def test_the_extreme_of_a_curve_is_its_nonlinearity():
    """K_p x^p leaves the line that the maker draws by NL R at the most."""
    x = np.linspace(-1.0, 1.0, 200_001)
    for factor, power, line in (
        (4.0, 3, "best"),
        (2.0, 2, "best"),
        (2.5, 3, "least_squares"),
        (1.5, 2, "least_squares"),
    ):
        curve = factor * x**power
        if line == "best":  # the minimax line: Chebyshev's polynomial is left
            left = curve - (0.75 * factor * x if power == 3 else 0.5 * factor)
        else:
            left = curve - np.polyval(np.polyfit(x, curve, 1), x)
        assert_allclose(np.abs(left).max(), 1.0, rtol=1e-4)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("scale_factor_nonlinearity: {value: 1 ppm, line: best}", "full_scale"),
        ("scale_factor_nonlinearity: {value: 1 ppm, shape: cubic}", "full_scale"),
        ("scale_factor_nonlinearity: {value: 1 ppm, full_scale: 5 g}", "deg/s"),
        ("scale_factor_quadratic: 10 ppm", "scale_factor_nonlinearity.*quadratic"),
        ("scale_factor_cubic: 10 ppm", "scale_factor_nonlinearity.*shape: cubic"),
    ],
)
def test_a_curve_without_its_range_is_refused_with_the_remedy(gyro, line, words):
    """A ratio says nothing of a coefficient unless the full scale stands beside it."""
    with pytest.raises(SpecError, match=words):
        gyro(line)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("scale_factor_quadratic: 10 ppm", "full_scale and shape: quadratic"),
        ("scale_factor_cubic: 10 ppm", "full_scale and shape: cubic"),
        ("K2: 10 ppm", "scale_factor_quadratic"),
    ],
)
def test_accelerometers_have_no_k2_in_ppm_either(tmp_path, line, words):
    """Nor K3: 10 ppm of 10 g and of 50 g are not the same; ppm/g says which."""
    path = tmp_path / "k.yaml"
    head = "name: k\naccelerometer:\n  errors:\n    "
    path.write_text(f"{head}{line}\n")
    with pytest.raises(SpecError, match=words):
        load_device(path)
    path.write_text(f"{head}scale_factor_quadratic: 10 ppm/g\n")
    assert_allclose(
        load_device(path).accelerometer.lines[0].u, 10e-6 / 9.80665, rtol=1e-12
    )


def test_an_asymmetry_says_whose_sign_decides(gyro):
    """Unset it is the turn's, as in the paper."""
    for words, form in (
        ("", ""),
        (", sign_of: turn", "turn"),
        (", sign_of: input",) * 2,
    ):
        device = gyro(f"scale_factor_asymmetry: {{value: 9 ppm{words}}}")
        assert device.gyro.lines[0].form == form.rpartition(" ")[2]


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("linearity", "did you mean 'scale_factor_nonlinearity'"),
        ("in-run bias instability", "did you mean 'bias_stability' or 'flicker'"),
        ("VRE", "did you mean 'vibration_rectification'"),
        ("tempco", "'bias_temperature_coefficient' or 'scale_factor_temperature"),
        ("LSB", "did you mean 'quantization'"),
        ("resolution", "did you mean 'quantization'"),
        ("K2", "did you mean 'scale_factor_quadratic'"),
        ("aging", "did you mean 'ageing'"),
        ("long-term stability", "did you mean 'ageing'"),
    ],
)
def test_a_word_of_data_sheets_is_answered_with_the_line(gyro, word, hint):
    """It is refused all the same: which quantity is meant the file has to say."""
    with pytest.raises(SpecError, match=f"unknown key.*{hint}"):
        gyro(f"{word}: 1 deg/h")


def test_an_unknown_key_of_a_value_is_told_those_of_the_value(gyro):
    """What is allowed beside `value` is said, not the lines of the sensor."""
    with pytest.raises(SpecError, match="unknown key 'sigmas', allowed:") as refused:
        gyro("bias_stability: {value: 1 deg/h, sigmas: 3}")
    allowed = str(refused.value).partition("allowed: ")[2].split(", ")
    assert {"value", "axes", "meaning", "correlation_time"} <= set(allowed)
    assert "angle_random_walk" not in allowed


PROCESSES = {
    "bias_stability": "deg/h",
    "angle_random_walk": "deg/sqrt(h)",
    "rate_random_walk": "deg/h/sqrt(h)",
    "sample_noise": "deg/h",
}


@pytest.mark.parametrize("name", PROCESSES)
@pytest.mark.parametrize(
    ("words", "part"),
    [("max", 1.0), ("peak to peak", 0.5), ("max, distribution: normal", 1.0)],
)
def test_a_bound_on_a_process_is_its_sigma(gyro, name, words, part):
    """A maker's largest noise or stability is the sigma of the worst unit, and said so.

    It is not divided by sqrt(3), and the process is normal.
    """
    unit = PROCESSES[name]
    device = gyro(f"{name}: {{value: 6 {unit}, meaning: {words}}}")
    whole = gyro(f"{name}: 6 {unit}").gyro.lines[0]
    line = device.gyro.lines[0]
    assert_allclose(line.u, part * whole.u, rtol=1e-14)
    assert {one.name for one in line.distributions} == {"normal"}
    (said,) = [text for text in device.assumptions if "taken as a bound" in text]
    assert said.startswith(f"gyro.{name}: ")


@pytest.mark.parametrize(
    ("word", "meaning", "shape"),
    [
        ("meaning: 3\N{GREEK SMALL LETTER SIGMA}", "3 sigma", "normal"),
        ("meaning: 1 \N{GREEK SMALL LETTER SIGMA}", "1 sigma", "normal"),
        ("meaning: 2-sigma", "2 sigma", "normal"),
        ("meaning: p-p", "peak to peak", "uniform"),
        ("meaning: pk-pk", "peak to peak", "uniform"),
        ("meaning: max, distribution: rectangular", "max", "uniform"),
        ("distribution: rectangular", "1 sigma", "uniform"),
        ("distribution: gaussian", "1 sigma", "normal"),
        ("meaning: 3 sigma, distribution: Gaussian", "3 sigma", "normal"),
    ],
)
def test_makers_words_are_read_as_ours(gyro, word, meaning, shape):
    """Another spelling of a meaning or a shape is that one, to the last bit."""
    line = gyro(f"bias_repeatability: {{value: 6 deg/h, {word}}}").gyro.lines[0]
    ours = gyro(
        f"bias_repeatability: {{value: 6 deg/h, meaning: {meaning}, "
        f"distribution: {shape}}}"
    ).gyro.lines[0]
    assert (line.meaning, line.distributions) == (meaning, ours.distributions)
    assert_allclose(line.u, ours.u, rtol=0)


# Printed density, unit, and the random walk of it in that of the sensor's walk line.
# One-sided N = D / sqrt(2), else N = D; deg/h/sqrt(Hz) is a 60th of deg/sqrt(h).
DENSITIES = [
    (
        "angle_random_walk: {value: 0.008 deg/s/sqrt(Hz), density: one-sided}",
        "0.34 deg/sqrt(h)",
        1.0 / 480.0,
    ),
    # Some makers of fibre-optic gyros equate 0.7 deg/h/sqrt(Hz) and 0.012 deg/sqrt(h).
    ("angle_random_walk: 0.7 deg/h/sqrt(Hz)", "0.0116666666666667 deg/sqrt(h)", 1e-14),
    ("angle_random_walk: 6 deg/h/sqrt(Hz)", "0.1 deg/sqrt(h)", 1e-14),
    (
        "angle_random_walk: {value: 8.485281374 deg/h/sqrt(Hz), density: one-sided}",
        "0.1 deg/sqrt(h)",
        1e-9,
    ),
    (
        "angle_random_walk: {value: 6 deg/h/sqrt(Hz), density: two-sided}",
        "0.1 deg/sqrt(h)",
        1e-14,
    ),
]


@pytest.mark.parametrize(("density", "walk", "rtol"), DENSITIES)
def test_a_density_is_the_random_walk_that_its_sides_make_it(gyro, density, walk, rtol):
    """ADIS16470 prints both 0.008 deg/s/sqrt(Hz) and 0.34 deg/sqrt(h) for one noise.

    0.008 x 60 / sqrt(2) is 0.3394, which rounds to what is printed: half of its last
    digit over 0.3394 is the tolerance. The rest are exact.
    """
    line = gyro(density).gyro.lines[0]
    same = gyro(f"angle_random_walk: {walk}").gyro.lines[0]
    tolerance = 0.005 / 0.3394 if "0.008" in density else rtol
    assert_allclose(line.u, same.u, rtol=tolerance)
    # What a table shows stays in the maker's terms.
    printed = float(density.replace("{", "").replace("value:", "").split()[1])
    assert_allclose(line.u / line.si_per_unit, printed, rtol=1e-14)


def test_a_two_sided_density_would_contradict_the_maker(gyro):
    """Control: read as two-sided, the first of those is 0.48 and not 0.34."""
    figure = "{value: 0.008 deg/s/sqrt(Hz), density: two-sided}"
    line = gyro(f"angle_random_walk: {figure}").gyro.lines[0]
    printed = gyro("angle_random_walk: 0.34 deg/sqrt(h)").gyro.lines[0]
    assert_allclose(line.u / printed.u, 0.48 / 0.34, rtol=1e-14)


def test_the_default_of_a_density_is_said_and_a_stated_one_is_not(gyro):
    """The assumption names the factor 0.7071; what the file says is none."""
    head = "accelerometer: {}\n"
    device = gyro("angle_random_walk: 1 deg/h/sqrt(Hz)", head=head)
    (said,) = [text for text in device.assumptions if "density" in text]
    assert said.startswith("gyro.angle_random_walk: the sides of the density are not")
    assert "0.7071" in said
    line = device.gyro.lines[0]
    sizes = {word: float(read.u[0]) for word, read in line.readings}
    assert_allclose(sizes["one-sided"], line.u[0] * sqrt(0.5), rtol=1e-14)
    assert_allclose(sizes["two-sided"], line.u[0], rtol=0)
    for sides in ("one-sided", "two-sided"):
        figure = f"{{value: 1 deg/h/sqrt(Hz), density: {sides}}}"
        stated = gyro(f"angle_random_walk: {figure}", head=head).assumptions
        assert not any("density" in text for text in stated)
    walk = gyro("angle_random_walk: 1 deg/sqrt(h)", head=head).assumptions
    assert not any("density" in text for text in walk)


def test_axes_may_be_densities_and_walks(gyro):
    """Each axis goes by its own unit and words; 1 deg/s/sqrt(Hz) is 60 deg/sqrt(h)."""
    line = gyro(
        "angle_random_walk: {value: 1 deg/s/sqrt(Hz), axes: {y: 60 deg/sqrt(h), "
        "z: {value: 1 deg/s/sqrt(Hz), density: two-sided}}}"
    ).gyro.lines[0]
    assert_allclose(line.u / line.u[1], [1.0, 1.0, 1.0], rtol=1e-14)
    sizes = {word: read.u / line.u[1] for word, read in line.readings}
    assert_allclose(sizes["one-sided"], [sqrt(0.5), 1.0, 1.0], rtol=1e-14)


def test_the_sides_of_a_known_maker_are_no_question(gyro):
    """Analog Devices prints them one-sided; whoever says otherwise is believed."""
    walk = "angle_random_walk: 1 deg/s/sqrt(Hz)"
    for vendor in ("Analog Devices", "analog devices", "ADI"):
        device = gyro(walk, head=f"vendor: {vendor}\n")
        (line,) = device.gyro.lines
        assert (line.density, line.readings) == ("one-sided", ())
        assert any("ADIS16470" in text for text in device.assumptions)
    own = walk.replace(
        "1 deg/s/sqrt(Hz)", "{value: 1 dps/sqrt(Hz), density: two-sided}"
    )
    (line,) = gyro(own, head="vendor: ADI\n").gyro.lines
    assert (line.density, line.readings) == ("two-sided", ())
    (line,) = gyro(walk, head="vendor: Quagga\n").gyro.lines
    assert (line.density, len(line.readings)) == ("two-sided", 2)


@pytest.mark.parametrize(
    "figure",
    [
        "{value: 0.1 deg/sqrt(h), density: one-sided}",
        "{value: 0.1 deg/h/sqrt(Hz), axes: {x: 1 deg/sqrt(h)}, density: two-sided}",
        "{axes: {x: {value: 1 deg/sqrt(h), density: one-sided}, y: 1 dps, z: 1 dps}}",
    ],
)
def test_a_random_walk_itself_has_no_sides(gyro, figure):
    """A figure in deg/sqrt(h) is N, and refuses to be called a density."""
    with pytest.raises(SpecError, match=r"random walk itself .*remove 'density'"):
        gyro(f"angle_random_walk: {figure}")


BOTH = "angle_random_walk: 0.1 deg/sqrt(h)\n    sample_noise: "


def test_the_same_noise_is_not_taken_twice(gyro):
    """A random walk and a noise of every sample are refused together, with remedies."""
    with pytest.raises(SpecError) as caught:
        gyro(BOTH + "60 deg/h")
    (issue,) = caught.value.issues
    assert issue.field == "gyro.errors.sample_noise"
    for words in ("would be counted twice", "Remove one", "adds_to: angle_random_walk"):
        assert words in issue.message


def test_two_noises_that_differ_are_both_taken(gyro):
    """`adds_to` says that the noise of the sample is no part of the random walk."""
    sensor = gyro(BOTH + "{value: 60 deg/h, adds_to: angle_random_walk}").gyro
    assert {line.name for line in sensor.lines} == {"angle_random_walk", "sample_noise"}
    with pytest.raises(SpecError, match="adds_to"):
        gyro(BOTH + "{value: 60 deg/h, adds_to: velocity_random_walk}")


@pytest.mark.parametrize(
    ("noise", "other"),
    [
        ("angle_random_walk: 1 deg/sqrt(h)", "gyro.sample_noise"),
        ("sample_noise: 1 deg/h", "gyro.angle_random_walk"),
    ],
)
def test_the_second_way_to_give_one_noise_is_no_gap(gyro, noise, other):
    """Where one noise line is given, the other is not among those that could widen."""
    assert other not in gyro(noise).gyro.not_given
    assert other in gyro("bias_repeatability: 1 deg/h").gyro.not_given


@pytest.mark.parametrize(
    ("line", "assumption"),
    [
        (
            "bias_repeatability: {value: 1 deg/h, meaning: typical}",
            "gyro.bias_repeatability: 'typical' taken as 1 sigma",
        ),
        (
            "bias_repeatability: {value: 1 deg/h, meaning: max}",
            "gyro.bias_repeatability: 'max' taken as uniform, half-width over sqrt(3)",
        ),
        (
            "bias_stability: 1 deg/h",
            "gyro.bias_stability: correlation time not given, 300 s assumed",
        ),
        (
            (
                "bias_stability: {value: 1 deg/h, definition: allan_minimum, "
                "correlation_time: 1 h}"
            ),
            (
                "gyro.bias_stability: the lowest Allan deviation over 0.664 taken as "
                "the sigma of the Gauss-Markov process, right for flicker noise only"
            ),
        ),
        (
            (
                "bias_stability: {axes: {x: 1 deg/h, y: 1 deg/h, z: {value: 1 deg/h, "
                "meaning: typical, correlation_time: 9 s}}, correlation_time: 1 s}"
            ),
            "gyro.bias_stability.z: 'typical' taken as 1 sigma",
        ),
        (
            (
                "bias_repeatability: {value: 1 deg/h, meaning: 3 sigma, "
                "axes: {x: {value: 1 deg/h}}}"
            ),
            (
                "gyro.bias_repeatability.x: meaning of the specification not taken, "
                "the axis is a mapping of its own"
            ),
        ),
    ],
)
def test_what_is_assumed_is_said(gyro, line, assumption):
    """A default taken, and 'typical', stand in the assumptions, and nothing else."""
    head = "accelerometer: {}\n"
    of_lines = [a for a in gyro(line, head=head).assumptions if "nominal" not in a]
    assert of_lines == [assumption]


def test_a_correlation_time_is_kept(gyro):
    """A given correlation time is taken, in seconds, and no assumption is made."""
    device = gyro("bias_stability: {value: 1 deg/h, correlation_time: 1 h}")
    assert_allclose(device.gyro.lines[0].correlation_time, [3600.0] * 3, rtol=0)
    assert not any("bias_stability" in text for text in device.assumptions)


@pytest.mark.parametrize(
    ("words", "u"),
    [
        ("definition: sigma", 6.0),
        ("definition: allan_minimum", 6.0 / 0.664),
        ("definition: allan_minimum, meaning: typical", 6.0 / 0.664),
        ("definition: allan_minimum, meaning: max", 6.0 / 0.664),
    ],
)
def test_a_definition_gives_the_size_of_the_process(gyro, words, u):
    """The lowest point of the Allan curve is 0.664 of the sigma or of B taken."""
    line = gyro(f"bias_stability: {{value: 6 deg/h, {words}}}").gyro.lines[0]
    assert_allclose(line.u, [u * DEG_H] * 3, rtol=1e-14)


@pytest.mark.parametrize(
    ("bandwidth", "per_corner"),
    [
        ("10 Hz", 1.0),
        ("{corner: 10 Hz, order: 1}", 1.5707963),
        ("{corner: 10 Hz, order: 2}", 1.1107207),
        ("{corner: 0.01 kHz, order: 4}", 1.0261722),
    ],
)
def test_an_rms_in_a_band_is_a_random_walk(gyro, bandwidth, per_corner):
    """N = rms/sqrt(2 B), B the integral of 1/(1 + (f/f_c)^2n), Butterworth's."""
    text = f"sample_noise: {{value: 0.05 deg/s, bandwidth: {bandwidth}}}"
    (line,) = gyro(text).gyro.lines
    N = 0.05 * DEG / sqrt(2.0 * per_corner * 10.0)
    assert_allclose(line.u, [N] * 3, rtol=1e-7)
    assert_allclose(line.u / line.si_per_unit, [0.05] * 3, rtol=1e-14)
    source = source_of("gyro", line.name).meant(line)
    assert isinstance(source.effect, WhiteNoise)
    # The same by quadrature, up to where next to nothing is left.
    f = np.linspace(0.0, 2e4, 4_000_001)
    if "corner" in bandwidth:
        order = int(bandwidth[-2])
        passed = np.trapezoid(1.0 / (1.0 + (f / 10.0) ** (2 * order)), f)
        assert_allclose(per_corner * 10.0, passed, rtol=1e-3)


@pytest.mark.parametrize(
    ("bandwidth", "told"),
    [
        ("0 Hz", "positive"),
        ("10 s", "Hz"),
        ("{corner: 10 Hz}", "order"),
        ("{corner: 10 Hz, order: 0}", "order"),
    ],
)
def test_what_is_no_bandwidth_is_refused(gyro, bandwidth, told):
    """A frequency above 0, or a corner with its order."""
    with pytest.raises(SpecError, match=r"sample_noise\.bandwidth") as error:
        gyro(f"sample_noise: {{value: 0.05 deg/s, bandwidth: {bandwidth}}}")
    assert told in str(error.value)


FLOOR = "value: 6 deg/h, definition: allan_minimum"


def test_an_allan_floor_without_a_correlation_time_is_flicker(gyro):
    """Its low cut is once a day, and both are said; with a time it is Gauss-Markov."""
    device = gyro(f"bias_stability: {{{FLOOR}}}")
    (line,) = device.gyro.lines
    assert_allclose(line.low_cut, [1.0 / 86400.0] * 3, rtol=1e-14)
    assert line.correlation_time is None
    effect = source_of("gyro", line.name).meant(line).effect
    assert isinstance(effect, FlickerNoise)
    (said,) = (text for text in device.assumptions if "0.664" in text)
    assert "coefficient of flicker noise" in said
    assert any("low cut not given" in text for text in device.assumptions)

    device = gyro(f"bias_stability: {{{FLOOR}, correlation_time: 300 s}}")
    (line,) = device.gyro.lines
    assert_allclose(line.correlation_time, [300.0] * 3, rtol=0)
    effect = source_of("gyro", line.name).meant(line).effect
    assert isinstance(effect, Stability)


@pytest.mark.parametrize(
    ("words", "place", "told"),
    [
        (
            f"{FLOOR}, correlation_time: 99 s, averaging_time: 100 s",
            "correlation_time",
            "below the '100 s' at which",
        ),
        (
            "value: 6 deg/h, averaging_time: 100 s",
            "averaging_time",
            "expected definition: allan_minimum",
        ),
        (
            f"{FLOOR}, axes: {{x: {{value: 6 deg/h}}}}",
            "axes",
            "flicker noise (allan_minimum without a correlation time) on some axes",
        ),
    ],
)
def test_what_no_allan_floor_can_be_is_refused(gyro, words, place, told):
    """A time below the floor's own, a floor's time without one, one of each kind."""
    with pytest.raises(SpecError, match=rf"bias_stability\.{place}: ") as error:
        gyro(f"bias_stability: {{{words}}}")
    assert told in str(error.value)


def test_a_correlation_time_from_the_averaging_time_on_is_allowed(gyro):
    """Of a Gauss-Markov process; without one the averaging time decides nothing."""
    for words in (", correlation_time: 100 s", ""):
        device = gyro(f"bias_stability: {{{FLOOR}, averaging_time: 100 s{words}}}")
        assert_allclose(device.gyro.lines[0].u, [6.0 / 0.664 * DEG_H] * 3, rtol=1e-14)


@pytest.mark.parametrize(
    ("words", "u"),
    [
        ("value: 6 deg/h, axes: {y: 3 deg/h}", (6.0, 3.0, 6.0)),
        ("axes: {x: 1 deg/h, y: 2 deg/h, z: 3 deg/h}", (1.0, 2.0, 3.0)),
        ("value: 6 deg/h, meaning: 3 sigma, axes: {y: 3 deg/h}", (2.0, 1.0, 2.0)),
        (
            (
                "value: 6 deg/h, meaning: 3 sigma, "
                "axes: {z: {value: 6 deg/h, meaning: 2 sigma}}"
            ),
            (2.0, 2.0, 3.0),
        ),
        (
            "value: 6 deg/h, meaning: 3 sigma, axes: {z: {value: 6 deg/h}}",
            (2.0, 2.0, 6.0),
        ),
    ],
)
def test_an_axis_overrides_the_value(gyro, words, u):
    """A named axis has its own value; the rest applies unless it is a mapping."""
    line = gyro(f"bias_repeatability: {{{words}}}").gyro.lines[0]
    assert_allclose(line.u, np.array(u) * DEG_H, rtol=1e-14)


def test_an_axis_may_have_its_own_shape(gyro):
    """Distributions are kept by axis."""
    line = gyro(
        "bias_repeatability: {value: 6 deg/h, axes: "
        "{x: {value: 6 deg/h, meaning: max}}}"
    ).gyro.lines[0]
    names = [shape.name for shape in line.distributions]
    assert names == ["uniform", "normal", "normal"]
    assert line.meaning == "x max, y 1 sigma, z 1 sigma"


def test_angles_override_by_their_names(gyro):
    """The six angles stand in the order xy xz yx yz zx zy."""
    line = gyro("mounting_repeatability: {value: 1 arcsec, axes: {zx: 3 arcsec}}")
    assert_allclose(
        line.gyro.lines[0].u, np.array([1, 1, 1, 1, 3, 1]) * ARCSEC, rtol=1e-14
    )


def test_a_line_keeps_the_words_of_the_file(gyro):
    """What is printed, and the maker's own words about it, are handed on."""
    line = gyro(
        "bias_stability: {axes: {x: 0.02 \N{DEGREE SIGN}/h, y: 0.03 deg/h, "
        "z: 0.02 deg/h}, definition: allan_minimum, includes: turn-on, "
        "horizon: 1 year, condition: 25 C, source: 'p. 5'}"
    ).gyro.lines[0]
    assert line.printed == "x 0.02 \N{DEGREE SIGN}/h, y 0.03 deg/h, z 0.02 deg/h"
    assert line.unit == "\N{DEGREE SIGN}/h"
    assert_allclose(line.si_per_unit, DEG_H / 0.664, rtol=1e-15)
    assert line.definition == "allan_minimum"
    assert line.meaning == "1 sigma"
    assert (line.includes, line.horizon) == ("turn-on", "1 year")
    assert (line.condition, line.source) == ("25 C", "p. 5")


def test_a_source_of_zero_is_given_where_it_is_meant(gyro):
    """meaning: exact keeps the line; without it 0 is not given, and that is said."""
    device = gyro("bias_repeatability: {value: 0 deg/h, meaning: exact}")
    assert_allclose(device.gyro.lines[0].u, np.zeros(3), rtol=0, atol=0)
    assert "gyro.bias_repeatability" not in device.gyro.not_given
    for zero in ("0 deg/h", "{axes: {x: 0 deg/h, y: 0 deg/h, z: 0 deg/h}}"):
        device = gyro(f"bias_repeatability: {zero}")
        assert device.gyro.lines == ()
        assert "gyro.bias_repeatability" in device.gyro.expected_missing
        (said,) = (text for text in device.assumptions if "0 is taken" in text)
        assert "meaning: exact" in said
    # Of an expected line a 0 on some axes is no figure of these either.
    some = gyro("bias_repeatability: {value: 0 deg/h, axes: {z: 1 deg/h}}")
    assert some.gyro.lines == ()
    axes = "{axes: {x: {value: 0 deg/h, meaning: exact}, y: 0 deg/h, z: 1 deg/h}}"
    (line,) = gyro(f"bias_repeatability: {axes}").gyro.lines
    assert_allclose(line.u, [0.0, 0.0, DEG_H], rtol=1e-14)


def test_what_has_a_size_is_not_exact(gyro):
    """A spread has a meaning; a known offset is nominal."""
    with pytest.raises(SpecError, match=r"bias_repeatability\.meaning: found 'exact'"):
        gyro("bias_repeatability: {value: 1 deg/h, meaning: exact}")


def test_a_sensor_without_lines_gives_none(tmp_path):
    """Everything is not given, and what a verdict needs is said; noise is one line."""
    path = put(tmp_path / "bare.yaml", "name: x\naccelerometer: {}\n")
    sensor = load_device(path).accelerometer
    assert sensor.lines == ()
    assert sensor.not_given == tuple(
        f"accelerometer.{line.name}"
        for line in lines_of("accelerometer")
        if line.varies and not line.is_initial
    )
    assert sensor.expected_missing == (
        "accelerometer.bias_repeatability",
        "accelerometer.bias_stability",
        "accelerometer.noise",
        "accelerometer.scale_factor_repeatability",
        "accelerometer.mounting_repeatability",
    )
    assert load_device(path).gyro is None


@pytest.mark.parametrize(
    "noise", ["angle_random_walk: 1 deg/sqrt(h)", "sample_noise: 1 dps"]
)
def test_either_noise_line_is_the_expected_one(gyro, noise):
    """A random walk or a noise per sample will do."""
    assert "gyro.noise" not in gyro(noise).gyro.expected_missing


def test_nominal_values_by_axis_and_their_zeros(tmp_path):
    """An unnamed axis is 0, may be negative where named, and the zero is said."""
    path = put(
        tmp_path / "nominal.yaml",
        "name: x\ngyro: {nominal: {bias: {x: -1 deg/h, z: 2 deg/h}, "
        "mounting_angle: {zy: -3 arcsec}}}\naccelerometer: {}\n",
    )
    device = load_device(path)
    assert_allclose(
        device.gyro.nominal_bias, np.array([-1.0, 0.0, 2.0]) * DEG_H, rtol=1e-15, atol=0
    )
    angles = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -3.0]) * ARCSEC
    assert_allclose(device.gyro.nominal_mounting_angle, angles, rtol=1e-15, atol=0)
    assert device.assumptions == (
        "gyro.nominal.bias: y not given, 0 assumed",
        "gyro.nominal.mounting_angle: xy, xz, yx, yz, zx not given, 0 assumed",
        "accelerometer.nominal.bias: not given, 0 assumed",
        "accelerometer.nominal.mounting_angle: not given, 0 assumed",
    )


def test_gravity_unit_rules_g_in_its_file_only(tmp_path):
    """A maker's own g scales mg and ug; the next file has the standard one again."""
    path = put(
        tmp_path / "own.yaml",
        "name: x\ngravity_unit: 9.80708 m/s^2\naccelerometer:\n"
        "  nominal: {bias: 1 mg}\n"
        "  errors: {bias_repeatability: 1 ug, velocity_random_walk: 1 m/s/sqrt(h)}\n",
    )
    sensor = load_device(path).accelerometer
    assert_allclose(sensor.nominal_bias, [9.80708e-3] * 3, rtol=1e-15)
    assert_allclose(sensor.line("bias_repeatability").u, [9.80708e-6] * 3, rtol=1e-15)
    assert_allclose(sensor.line("velocity_random_walk").u, [1 / 60] * 3, rtol=1e-15)
    paper = load_device("zhao-2019").accelerometer
    assert_allclose(paper.line("bias_repeatability").u, [37.0 * UG] * 3, rtol=1e-15)


def test_what_no_model_uses_is_kept_as_printed(tmp_path):
    """Figures beyond the model lines, and texts about the device, are handed on."""
    path = put(
        tmp_path / "texts.yaml",
        "format: budget-device/1\nname: x\nvendor: V\nprice: 5000 EUR\n"
        "notes: |\n  two\n  lines\n"
        "figures:\n- {name: g-sensitivity, value: 1 deg/h/g, meaning: '1 \u03c3', "
        "condition: static, source: p. 3}\n"
        "gyro: {}\n",
    )
    device = load_device(path)
    assert (device.vendor, device.price, device.mass) == ("V", "5000 EUR", "")
    assert device.notes == "two\nlines\n"
    (figure,) = device.figures
    assert (figure.name, figure.value) == ("g-sensitivity", "1 deg/h/g")
    assert (figure.meaning, figure.condition) == ("1 \u03c3", "static")


def test_what_does_not_go_together_is_said_at_once(tmp_path):
    """Each thing at its key; a time beside a 0 that is meant is none of them."""
    path = put(
        tmp_path / "d.yaml",
        "name: d\ngyro:\n  errors:\n    bias_stability: {value: 0 deg/h, "
        "meaning: exact, correlation_time: 300 s}\n    angle_random_walk: "
        "{value: 1 deg/sqrt(h), "
        "density: one-sided, meaning: exact}\n",
    )
    with pytest.raises(SpecError) as error:
        load_device(path)
    line = "gyro.errors.angle_random_walk"
    fields = [issue.field for issue in error.value.issues]
    assert fields == [f"{line}.density", f"{line}.meaning"]
