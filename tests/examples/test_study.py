"""Zhao 2019, section 3, computed again: what fits, what does not, and how sure."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import chi2

from budget.calibration.simulation import simulate
from budget.errors import SpecError
from budget.units import NUMBER
from zhao_2019.conditions import (
    PLACES,
    load_conditions,
    nominal_size,
    only_sources,
)
from zhao_2019.formulas import compute_formulas, evaluate
from zhao_2019.orders import expectation_of
from zhao_2019.printed import (
    FILE,
    RUNS,
    Agreement,
    Conclusion,
    load_paper,
)
from zhao_2019.readings import LEVEL, readings
from zhao_2019.study import (
    compute_couplings,
    conclusion_findings,
    reproduce,
)
from zhao_2019.table1 import (
    REPEATS,
    biases_from_angles,
    drawn_means,
    fitting_choices,
    stated_rows,
    switched_on,
)

pytestmark = pytest.mark.kernels

SIGMAS = 5.0  # of the sampling error that a drawn spread may miss by


@pytest.fixture(scope="module")
def conditions():
    return load_conditions()


@pytest.fixture(scope="module")
def study():
    return reproduce()


@pytest.fixture(scope="module")
def rows(conditions):
    return stated_rows(conditions)


def reading_of(conditions, source, name, runs=1):
    """Return the one reading of a row whose name begins so."""
    (found,) = (
        reading
        for reading in readings(conditions)
        if reading.source == f"gyro.{source}"
        and reading.name.startswith(name)
        and reading.runs == runs
    )
    return found


def rms(values):
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.asarray(values) ** 2)))


def find(study, where):
    """Return the one finding of that name."""
    (found,) = (row for row in study.findings if row.where == where)
    return found


def test_all_sixty_entries_of_table_1_are_there_once(study):
    """Every printed entry stands in one row, character for character."""
    found = [row.printed for row in study.of_section("table 1") if not row.is_summary]
    paper = study.paper
    printed = [text for row in paper.table_1 for text in paper.entries(row)]
    assert len(found) == 60
    assert Counter(found) == Counter(printed)


@pytest.mark.parametrize(
    ("axis", "printed"),
    [("x", "-3.18263e-10"), ("y", "-3.18264e-10"), ("z", "6.36529e-10")],
)
def test_bias_without_spread_agrees_to_six_digits(study, axis, printed):
    """Eq. (4)'s own residual is what Table 1 prints under SF repeatability."""
    row = find(study, f"Table 1, scale factor repeatability, bias {axis}")
    # Doubles leave about 1e-6 of this residual, the paper's no less than ours.
    assert_allclose(row.ours, float(printed), rtol=5e-6)
    assert row.verdict == Agreement.AGREES


def test_printed_angle_rounding_is_whole_steps_of_doubles_below_one(conditions):
    """Nonzero entries of rounding size are whole multiples of 2^-53, to five digits."""
    tiny = [
        float(text)
        for row in conditions.paper.table_1.values()
        for text in row.mounting_angle
        if 0.0 < abs(float(text)) < 1e-10
    ]
    assert len(tiny) == 11
    for value in tiny:
        steps = abs(value) / 2.0**-53
        # One unit in the last of five printed digits.
        assert_allclose(steps, round(steps), rtol=1e-4)
        # Above 1 doubles are twice as far apart.
        assert value < 0.0 or round(steps) % 2 == 0


def test_a_spread_of_drawn_means_is_a_fifth_of_a_runs(conditions, rows):
    """Means over 25 drawn runs spread by u/5, which the law says."""
    bound = SIGMAS / np.sqrt(2.0 * (REPEATS - 1))
    for row in rows.values():
        varies, u = row.varies, row.expectation.u
        found = drawn_means(conditions, row)[varies] / u[varies] * np.sqrt(RUNS)
        assert np.abs(found - 1.0).max() < bound
        # Control: a mean over 16 runs is told from one over 25.
        assert np.abs(found * 5.0 / 4.0 - 1.0).min() > bound


@pytest.mark.parametrize(
    ("source", "parameter"),
    [
        ("gyro.bias_repeatability", "bias"),
        ("gyro.bias_stability", "mounting_angle"),
        ("gyro.angle_random_walk", "scale_factor"),
        ("gyro.mounting_repeatability", "bias"),
    ],
)
def test_simulation_has_the_spread_of_the_law(conditions, rows, source, parameter):
    """Runs done sample by sample, at 10 Hz, spread as Table 1's rows are judged by."""
    plan = replace(conditions.printed, sample_rate=10.0)
    size = nominal_size(conditions.gyro)
    runs = 60
    errors = [
        simulate((conditions.gyro,), plan, run=run, only=frozenset({source})) / size
        for run in range(runs)
    ]
    u = rows[source.partition(".")[2]].expectation.u[PLACES[parameter]]
    found = np.std(errors, axis=0, ddof=1)[PLACES[parameter]]
    bound = SIGMAS / np.sqrt(2.0 * (runs - 1))
    assert np.abs(found / u - 1.0).max() < bound
    assert np.abs(2.0 * found / u - 1.0).min() > bound  # control: twice as much


def test_a_ratio_is_ours_over_printed(study):
    """Of two numbers, of absolute values; none where one of them is zero."""
    rows = [
        (row, float(row.printed))
        for row in study.findings
        if isinstance(row.ours, float)
        and re.fullmatch(NUMBER, row.printed)
        and "beyond" not in row.where  # what is left of a printed number, to 3 digits
    ]
    assert len(rows) > 100
    for row, printed in rows:
        if row.ours and printed:
            assert_allclose(row.ratio, abs(row.ours / printed), rtol=1e-15)
        else:
            assert row.ratio is None


def test_zeros_of_table_1_are_printed_as_such_or_as_rounding(study):
    """Where ours is 0, the entry is 0, or whole steps of 2^-53, and that is said."""
    zeros = [
        row
        for row in study.of_section("table 1")
        if not row.is_summary and row.ours == 0.0
    ]
    assert {row.verdict for row in zeros} == {Agreement.AGREES}
    rounded = [row for row in zeros if float(row.printed)]
    assert len(rounded) == 11
    for row in rounded:
        steps = round(abs(float(row.printed)) / 2.0**-53)
        assert f" {steps} times 2^-53" in row.why
    assert {row.why for row in zeros if row not in rounded} == {"exactly zero"}


@pytest.mark.parametrize(
    ("row", "parameter", "verdict"),
    [
        ("bias repeatability", "bias, all 3", Agreement.FITS_MEAN),
        ("scale factor repeatability", "scale factor, all 3", Agreement.FITS_MEAN),
        ("mounting repeatability", "bias, all 3", Agreement.FITS_MEAN),
        ("bias stability", "bias, all 3", Agreement.FITS_SINGLE),
        ("bias stability", "scale factor, all 3", Agreement.READING),
        ("bias stability", "mounting angle, all 6", Agreement.READING),
        ("angle random walk", "scale factor, all 3", Agreement.READING),
        ("angle random walk", "mounting angle, all 6", Agreement.READING),
        ("angle random walk", "bias, all 3", Agreement.READING),
        ("mounting repeatability", "mounting angle, all 6", Agreement.EXPLAINED),
    ],
)
def test_verdicts_of_table_1(study, row, parameter, verdict):
    """Each group of random entries has the verdict that was found for it."""
    assert find(study, f"Table 1, {row}, {parameter}").verdict == verdict


def test_both_repeatability_rows_exclude_a_single_run(study):
    """Together they fit a mean over 25 runs and no single run."""
    row = find(
        study, "Table 1, bias and scale factor repeatability, their 6 random entries"
    )
    assert row.p_single < 1e-3
    assert row.p_mean > 0.5


@pytest.mark.parametrize(
    ("parameter", "ours", "last_digit", "times"),
    [
        ("scale_factor", 6.9e-7, 1e-8, 147),
        ("mounting_angle", 0.143 / 2.0, 1e-3 / 2.0, 264),  # arcsec over 2 arcsec
        ("bias", 3.5e-3, 1e-4, 472),
    ],
)
def test_random_walk_row_is_far_below_its_inputs(
    rows, parameter, ours, last_digit, times
):
    """Ours from 0.005 deg/sqrt(h), and how many times less is printed (rms)."""
    row = rows["angle_random_walk"]
    u = row.expectation.u[PLACES[parameter]]
    assert_allclose(u, ours, rtol=0, atol=last_digit)
    printed = rms(row.printed[PLACES[parameter]])
    assert_allclose(rms(u) / printed, times, rtol=0, atol=0.5)


def test_random_walk_as_white_noise_per_sample_is_within_1_3_to_4(conditions):
    """Read as 0.005 deg/h in each sample, printed is 1.3 to 4.1 times larger."""
    reading = reading_of(conditions, "angle_random_walk", "0.005 deg/h,")
    times = [
        rms(reading.printed[place]) / rms(reading.expectation.u[place])
        for place in PLACES.values()
    ]
    assert_allclose(times, [4.09, 2.28, 1.27], rtol=0.01)


def test_noise_once_a_window_fits_both_white_noise_rows(study):
    """One slip, noise added once to a window's sum, gives gyro and accelerometer."""
    name = "noise added once to the sum of a window, not to each of its samples"
    found = [
        row
        for row in study.of_section("readings")
        if name in row.where and "single run" not in row.where
    ]
    assert {row.verdict for row in found} == {Agreement.READING_FITS}
    assert {row.where.partition(",")[0] for row in found} == {"Table 1", "3.2"}


def test_bias_stability_with_independent_turns(conditions):
    """Far apart, turns give 3.9e-7 (adjacent 7.7e-8); angles stay 1.9 times larger."""
    reading = reading_of(conditions, "bias_stability", "+ and - turns far apart")
    assert_allclose(reading.expectation.u[:3], 3.9e-7, rtol=0.01)
    angle = PLACES["mounting_angle"]
    times = rms(reading.printed[angle]) / rms(reading.expectation.u[angle])
    assert_allclose(times, 1.92, rtol=0.01)
    assert reading.fit("scale_factor").fits
    assert not reading.fit("mounting_angle").fits


def test_bias_stability_row_fits_a_run_with_the_random_walk_left_on(conditions):
    """Its twelve entries against a covariance put together by hand, chi2 by scipy."""
    left_on = "the angle random walk 0.005 deg/sqrt(h) left on"
    reading = reading_of(conditions, "bias_stability", left_on)
    printed = reading.printed
    walk, turn, dwells = 0.005, 18.0 / 3600.0, 4.0 * 300.0 / 3600.0
    # Differences of turns by 360 deg over 4 pi n and, for angles, over 2 arcsec; the
    # mean of four dwells over 2.5 deg/h: white noise N^2/L [deg, h].
    u_sf = walk * np.sqrt(2.0 * turn) / 720.0
    u_bias = walk / np.sqrt(dwells) / 2.5
    u = np.repeat([u_sf, u_sf / (2.0 / 3600.0 * np.pi / 180.0), u_bias], [3, 6, 3])
    alone = chi2.sf(np.sum((printed / u) ** 2), 12)
    # To the bias the stability adds its mean over the dwells; to the rest 1 %.
    u[9:] = np.hypot(u_bias, 0.04 / 2.5 * np.sqrt(gauss_markov_share(1200.0 / 300.0)))
    both = chi2.sf(np.sum((printed / u) ** 2), 12)
    assert_allclose(min(2 * alone, 2 - 2 * alone), 0.42, rtol=0, atol=0.01)
    assert_allclose(min(2 * both, 2 - 2 * both), 0.68, rtol=0, atol=0.02)
    assert_allclose(reading.fit().p, 0.676, rtol=2e-3)
    assert reading.fits_row
    # Control: twice the size of the entries is told from theirs.
    assert not replace(reading, printed=2.0 * printed).fits_row


def gauss_markov_share(ratio):
    """Variance of a Gauss-Markov mean over `ratio` correlation times, of sigma^2."""
    return 2.0 / ratio**2 * (ratio - 1.0 + np.exp(-ratio))


def test_what_a_reading_is_worth_is_said_beside_it(conditions, rows, study):
    """62 choices of stated sources: 4 fit the stability row, none a wrong row."""
    choices = switched_on(conditions)
    assert len(choices) == 31
    fits = {name: fitting_choices(choices, row) for name, row in rows.items()}
    stability = fits.pop("bias_stability")
    assert len(stability) == 4
    assert all("gyro.angle_random_walk" in reading.sources for reading in stability)
    assert {reading.runs for reading in stability} == {1}
    assert any(fits.values())
    assert all(r.sources == (r.source,) for found in fits.values() for r in found)
    row = find(
        study,
        "Table 1, bias stability, one run with the random walk left on",
    )
    assert row.verdict == Agreement.READING
    assert_allclose(row.p_single, 0.676, rtol=2e-3)
    assert row.p_mean < 1e-30
    for said in ("64 readings", "0 of 240 wrong choices", "147, 264, 472 times less"):
        assert said in row.why


@pytest.mark.parametrize(
    ("where", "printed", "ours"),
    [
        ("bias repeatability, mounting angle", "1e-14", 0.0),
        ("scale factor repeatability, mounting angle", "1e-14 arcsec", 0.0),
        # 6.36529e-10 of 2.5 deg/h
        ("scale factor repeatability, bias", "1e-9 deg/h", 1.59132e-9),
    ],
)
def test_orders_of_3_1_in_their_units(study, where, printed, ours):
    """Repeatabilities have the orders that the text gives, in arcsec and deg/h."""
    row = find(study, f"3.1, gyro, {where}")
    assert row.printed == printed
    assert_allclose(row.ours, ours, rtol=5e-6)
    assert row.verdict in {Agreement.AGREES, Agreement.AGREES_IN_ORDER}


def test_orders_of_the_text_agree_but_for_these(study):
    """Both white noises, the angles under stability, and a bound; figure 3 alone."""
    white = ("3.1, gyro, angle random walk", "3.2, accelerometer, noise 50 ug")
    for row in study.of_section("text"):
        agrees = row.verdict in {Agreement.AGREES, Agreement.AGREES_IN_ORDER}
        differs = row.where.startswith(white) or row.where in {
            "3.1, gyro, bias stability, mounting angle",
            "3.1, gyro, bias stability, scale factor as a bound",
        }
        assert agrees != differs, row.where
        if row.p_single is not None:  # 1 % for a run or for a mean is enough
            assert agrees == (max(row.p_single, row.p_mean) >= LEVEL), row.where
    orders = {
        row.where: row.verdict
        for row in study.of_section("figures")
        if row.where.endswith("order")
    }
    assert orders == {
        "figure 1, bias, order": Agreement.AGREES_IN_ORDER,
        "figure 2, mounting angle, order": Agreement.AGREES,
        "figure 3, mounting angle, order": Agreement.UNEXPLAINED,
        "figure 4, bias, order": Agreement.AGREES_IN_ORDER,
    }


def test_text_and_table_differ_on_the_bound(study):
    """'within 0.1e-6' stands beside an entry of 9.1776e-7."""
    row = find(study, "3.1, gyro, bias stability, scale factor as a bound")
    assert (row.printed, row.verdict) == ("within 0.1e-6", Agreement.EXPLAINED)
    assert_allclose(row.ratio, 9.1776, rtol=1e-12)


def test_mounting_row_shows_the_order_of_its_angles(conditions):
    """One order of 720 returns the printed biases; the next is far off."""
    found = biases_from_angles(conditions)
    paper = conditions.paper
    printed = [float(text) for text in paper.table_1["mounting_repeatability"].bias]
    assert found.order == paper.angle_order
    assert np.abs(found.bias - printed).max() < 6e-10
    assert found.misfit < 1.0
    assert found.next_misfit > 100.0  # control


def test_mounting_row_is_a_mean_and_no_single_run(conditions, study):
    """What the mean angles leave of the bias of z is a mean of products."""
    where = "Table 1, mounting repeatability, bias z beyond its mean angles"
    assert find(study, where).verdict == Agreement.FITS_MEAN
    found = biases_from_angles(conditions)
    printed = conditions.paper.table_1["mounting_repeatability"].bias
    rest = float(printed[2]) - (found.bias[2] - found.products[2])
    allowed = found.rounding[2] + 3.0 * found.u_products[2]
    assert abs(rest - found.products[2]) < allowed
    assert abs(rest) > found.rounding[2] + 3.0 * found.u_products[2]


def test_mounting_angles_fit_without_their_nominal(conditions):
    """About -1 a mean over 25 runs fits; about 0 it does not, nor a single run."""
    single = reading_of(conditions, "mounting_repeatability", "")
    angles = single.printed[PLACES["mounting_angle"]]
    assert_allclose(angles.mean(), -1.008, atol=5e-4)
    assert single.of_mean.fit("mounting_angle").fits
    assert not single.fit("mounting_angle").fits


def test_figures_are_straight_with_their_closed_slopes(study):
    """Errors from asymmetry are proportional to it; slopes as eqs. (12), (4) say."""
    for sweep in study.sweeps[2:]:
        # Terms of the mounting angles, 1e-5 rad times up to 6, are left out.
        assert_allclose(sweep.fitted_slopes, sweep.slopes, rtol=3e-4)
        assert sweep.deviation < 1e-6


@pytest.mark.parametrize(
    ("figure", "largest"),
    [(0, 6.36529e-10), (1, 0.0), (2, 2.24e-3), (3, 3.73e-7)],
)
def test_figures_have_their_sizes(study, figure, largest):
    """The largest errors of figures 1 to 4; figure 3 is 45 times below its print."""
    assert_allclose(study.sweeps[figure].largest, largest, rtol=2e-3)


@pytest.mark.parametrize(
    ("source", "parameter", "ours"),
    [
        ("bias_stability", "scale_factor", 8.7e-6),
        ("bias_stability", "mounting_angle", 0.90),
        ("bias_stability", "bias", 2.0e-3),
        ("sample_noise", "scale_factor", 1.4e-7),
        ("sample_noise", "mounting_angle", 1.5e-2),
        ("sample_noise", "bias", 2.4e-5),
    ],
)
def test_accelerometer_magnitudes(conditions, source, parameter, ours):
    """Ours from the inputs of 3.2, to the two digits that were found."""
    (printed,) = (
        row for row in conditions.paper.orders if row.name == f"accelerometer.{source}"
    )
    u = expectation_of(printed, conditions).u[PLACES[parameter]]
    assert_allclose(u, ours, rtol=0.035)


def test_accelerometer_experiments_are_all_seven(conditions):
    """Section 3.2 does seven experiments, and each has its orders here."""
    orders = [row for row in conditions.paper.orders if row.section == "3.2"]
    assert len({row.condition for row in orders}) == 7
    assert {row.sensor for row in orders} == {"accelerometer"}


@pytest.mark.parametrize(
    ("equation", "name", "printed", "truth"),
    [
        ("eq. (3)", "d_yx", -3.0, 3.0),
        ("eq. (5)", "second d_xy", 2.0, 1.0),
        ("eq. (5)", "d_yz", -198014.2, 4.0),
        # h = w cos L/rate, 1.72699411e-4: (6 - 5) h sqrt(3)/2, (9 - 5 sqrt(3)/2) h.
        ("2.1.1", "earth rate in the count of z", 1.4956207705e-04, 8.0648431275e-04),
    ],
)
def test_misprints_return_a_wrong_angle(conditions, equation, name, printed, truth):
    """Fed with error-free pulses the printed formula misses, ours does not [arcsec]."""
    (formula,) = (
        f
        for f in compute_formulas(conditions)
        if (f.given.equation, f.name) == (equation, name)
    )
    assert formula.is_misprint
    assert formula.is_right
    assert_allclose(formula.returns_printed, printed, rtol=1e-6)
    assert_allclose(formula.returns_ours, truth, rtol=1e-8)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-n_x1/n_x2", -2.0 / 3.0),
        ("n_x2/4 pi n", 3.0 / (4.0 * np.pi)),
        ("[N_x(3) - N_x(4)]/2g", (7.0 - 11.0) / (2.0 * 9.8)),
        ("-[N_x(3) + N_x(4)]/2g K_y", -18.0 / (2.0 * 9.8 * 13.0)),
    ],
)
def test_printed_quotients_are_computed_as_they_stand(text, value):
    """A formula as printed returns what it says, by hand."""
    values = {"n_x1": 2.0, "n_x2": 3.0, "N_x(3)": 7.0, "N_x(4)": 11.0}
    values |= {"K_y": 13.0, "g": 9.8, "n": 1.0, "pi": np.pi}
    assert_allclose(evaluate(text, values), value, rtol=1e-15)


@pytest.mark.parametrize(
    "text",
    ["n_x1", "n_x1*n_x2", "[N_x(3) - ]/2g", "n_q1/n_x2", "n_x1/n_q2", "n_x1/n_x2 + 1"],
)
def test_what_is_no_quotient_is_refused(text):
    """A text that cannot be computed is an error, never a number."""
    with pytest.raises(ValueError, match="no quotient of counts"):
        evaluate(text, {"n_x1": 2.0, "n_x2": 3.0, "N_x(3)": 7.0})


def test_the_second_d_xy_is_held_against_the_first(conditions):
    """Ours is what the package returns for d_xy, not the true angle put in for it."""
    angles = {
        f.name: f
        for f in compute_formulas(conditions)
        if f.given.equation == "eq. (5)" and f.name.endswith("d_xy")
    }
    assert angles["second d_xy"].returns_ours == angles["d_xy"].returns_ours
    assert angles["second d_xy"].returns_ours != angles["second d_xy"].truth


def test_eq_4_misses_the_bias_and_eq_17_the_earth(conditions):
    """Eq. (4) is wrong on every axis, eq. (17) where the earth turns along it."""
    wrong = Counter(
        f.given.equation for f in compute_formulas(conditions) if f.is_misprint
    )
    assert wrong == {
        "eq. (3)": 1,
        "eq. (4)": 3,
        "2.1.1": 1,
        "eq. (5)": 2,
        "eq. (17)": 2,
    }
    seventeen = [
        f for f in compute_formulas(conditions) if f.given.equation == "eq. (17)"
    ]
    assert_allclose([f.returns_printed for f in seventeen], 2.17e-8, rtol=1e-3)
    truth = [2.17e-8, 1.30e-7, 9.52e-8]
    assert_allclose([f.truth for f in seventeen], truth, rtol=5e-3)
    assert all(f.is_right for f in compute_formulas(conditions))


def test_conclusions_agree_but_for_two(study):
    """Law and simulation bear the paper out, save for eq. (4) and a way of counting."""
    differing = {
        row.where: row.verdict
        for row in study.of_section("conclusions")
        if row.verdict != Agreement.AGREES
    }
    assert differing == {
        "section 2.1.2: gyro scale factor nonlinearity on scale factor": (
            Agreement.EXPLAINED
        ),
        "section 2.1.3, 4: gyro mounting repeatability on bias": Agreement.EXPLAINED,
    }


@pytest.mark.parametrize(
    ("source", "parameter", "claim"),
    [
        ("bias_repeatability", "mounting_angle", "affects"),
        ("angle_random_walk", "bias", "no effect"),
    ],
)
def test_a_wrong_conclusion_is_not_borne_out(conditions, source, parameter, claim):
    """A claim against law and simulation is unexplained, whatever the paper says."""
    said = Conclusion.of(
        section="4", sensor="gyro", source=source, claims={parameter: claim}
    )
    paper = conditions.paper.but(conclusions=(said,))
    (row,) = conclusion_findings(
        compute_couplings(conditions), replace(conditions, paper=paper)
    )
    assert row.verdict == Agreement.UNEXPLAINED
    assert row.printed == claim
    assert row.ours.count("affects" if claim == "no effect" else "no effect") == 4


def test_every_row_has_a_known_verdict_and_section(study):
    """Verdicts come from the closed set, sections too, and a reason is given."""
    for row in study.findings:
        assert row.verdict in study.paper.verdicts
        assert row.section in study.paper.sections
        assert row.why


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('"-0.00630"', '"-0.00630?"', "expected a number as printed"),
        ("[xz, xy, yz,", "[xz, xy, yx,", "expected every angle once"),
        ("  unexplained: ", "  unclear: ", "expected each once"),
        ("    is_slip: false", "    is_slop: false", "unknown key 'is_slop'"),
        ("source: sample_noise", "source: sample_nose", "has no source 'sample_nose'"),
        ("    section: figures", "    section: figure", "is no section"),
    ],
)
def test_a_slip_in_the_printed_numbers_is_refused(
    tmp_path, monkeypatch, right, wrong, message
):
    """What the paper's file cannot mean is an error at its place, never a number."""
    text = FILE.read_text(encoding="utf-8")
    assert right in text
    path = tmp_path / FILE.name
    path.write_text(text.replace(right, wrong, 1), encoding="utf-8")
    monkeypatch.setattr("zhao_2019.printed.FILE", path)
    with pytest.raises(SpecError, match=message):
        load_paper()


def test_sources_that_are_not_asked_for_stay_out(conditions):
    """Without any error the gyro problem has no spread and eq. (4)'s residual alone."""
    problem = only_sources(conditions.gyro, conditions.printed, "")
    assert problem.normals_per_trial == 0
    y = problem.evaluate(np.zeros((problem.n_inputs, 1)))[:, 0]
    assert not y[:9].any()
    assert y[9:].all()
