"""A line that is not given has a ceiling, which hiding more never lowers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from keeping import catalogue
from numpy.testing import assert_allclose

from budget import load_device
from budget.errors import CallError
from budget.missing import comparable
from budget.missing.grades import UNKNOWN, family, grade, graded_by
from budget.missing.prediction import predict, stand_in
from budget.names import Name
from budget.studies.ceilings import GRADE, TECHNOLOGY, ceilings

MOUNTING = Name("mounting_repeatability", owner="gyro")
G_SENSITIVITY = Name("g_sensitivity", owner="gyro")
COEFFICIENT = Name("bias_temperature_coefficient", owner="gyro")


def without(device, kind, name):
    """Return a device whose sheet does not print one line."""
    sensor = getattr(device, kind)
    every = (*sensor.lines, *sensor.initial)
    return replace(
        device, **{kind: sensor.with_lines([x for x in every if x.name != name])}
    )


def test_the_larger_of_what_others_print_and_of_the_prediction():
    """Each expected line of every device: by `comparable` and `predict` themselves."""
    origins = set()
    for device in catalogue():
        for sensor in device.sensors:
            names = sensor.expected_missing
            found = ceilings(device, names, catalogue())
            predicted = predict(device, names, catalogue())
            if not family(device.technology) or grade(sensor) == UNKNOWN:
                continue
            for name in names:
                ends = predicted.of([name]).interval(0.95)[:, 1].tolist()
                offers = comparable(name, device, sensor, catalogue())
                printed = [float(line.u.max()) for line, _ in offers]
                one = found[name]

                assert_allclose(one.u, max(ends + printed), rtol=1e-12)
                assert_allclose(one.line.u, np.full_like(one.line.u, one.u), rtol=0)
                assert one.line.name == stand_in(name).name
                assert (one.largest_comparable is None) == (not printed)
                if printed:
                    assert one.largest_comparable.u == max(printed)
                    assert one.largest_comparable.owner != device.name
                origins.add(one.origin)
    assert origins == {"comparable devices", "prediction"}


def test_lines_that_nobody_expects_have_ceilings_too():
    """The worst that a MEMS gyro of the same grade prints; nothing is predicted."""
    device = load_device("mpu-9250")
    (found,) = ceilings(device, [COEFFICIENT], catalogue()).values()
    sizes = {
        other.name: float(np.abs(line.u).max())
        for other in catalogue()
        if other.gyro is not None
        if family(other.technology) == "mems" and other.name != device.name
        if (line := other.gyro.line("bias_temperature_coefficient")) is not None
    }

    assert found.untold == (GRADE,)
    assert found.origin == "comparable devices"
    assert_allclose(found.u, max(sizes.values()), rtol=1e-12)
    assert found.largest_comparable.owner == max(sizes, key=sizes.get)
    assert found.printed == f"{found.u / np.pi * 180 * 3600:.3g} deg/h/degC"


def test_a_coefficient_below_zero_counts_by_its_size():
    """-30 deg/h/degC is as bad as 30 deg/h/degC."""
    device = load_device("mpu-9250")
    (worst,) = ceilings(device, [COEFFICIENT], catalogue()).values()
    turned = [
        replace(
            other,
            gyro=replace(
                other.gyro,
                lines=tuple(
                    replace(line, u=-line.u)
                    if line.name == COEFFICIENT.quantity
                    else line
                    for line in other.gyro.lines
                ),
            ),
        )
        for other in catalogue()
        if other.gyro is not None
    ]
    (found,) = ceilings(device, [COEFFICIENT], turned).values()

    assert found.u == worst.u
    assert found.largest_comparable.owner == worst.largest_comparable.owner


@pytest.mark.slow
def test_hiding_technology_or_grade_brings_no_better_company():
    """What is not told may be any: the worst comparable device is never better."""
    lower = 0
    for device in catalogue():
        for sensor in device.sensors:
            names = (*sensor.expected_missing, Name("initial_bias", owner=sensor.kind))
            told = ceilings(device, names, catalogue())
            graded = graded_by(sensor.kind)
            for hidden, untold in (
                (replace(device, technology=""), TECHNOLOGY),
                (replace(device, technology="6-axis"), TECHNOLOGY),
                (without(device, sensor.kind, graded), GRADE),
            ):
                found = ceilings(hidden, names, catalogue())
                for name, one in told.items():
                    assert untold in found[name].untold
                    if one.largest_comparable is not None:
                        now = found[name].largest_comparable.u
                        assert now >= one.largest_comparable.u
                        lower += now > one.largest_comparable.u
    assert lower > 50  # so it is no rule without effect


@pytest.mark.slow
def test_a_sheet_that_hides_its_worst_line_is_not_taken_for_better():
    """At the ceiling a hidden line is no better than any comparable sheet's."""
    for device in catalogue():
        for sensor in device.sensors:
            for line in sensor.lines:
                name = Name(line.name, owner=sensor.kind)
                hidden = without(device, sensor.kind, line.name)
                found = ceilings(hidden, [name], catalogue()).get(name)
                for other, owner in comparable(name, device, sensor, catalogue()):
                    if line.name == stand_in(name).name == other.name:
                        assert found.u >= np.abs(other.u).max(), owner.name


def test_a_noise_of_any_kind_is_the_random_walk():
    """'gyro.noise' and 'gyro.sample_noise' ask for the same ceiling."""
    device = load_device("mpu-9250")
    names = [
        Name(one, owner="accelerometer")
        for one in ("noise", "sample_noise", "velocity_random_walk")
    ]
    found = ceilings(device, names, catalogue())

    assert [*found] == names
    assert {one.line.name for one in found.values()} == {"velocity_random_walk"}
    assert len({one.u for one in found.values()}) == 1


def test_without_devices_and_prediction_there_is_none():
    """Nobody prints it, nobody predicts it, or the device has no such sensor."""
    device = load_device("stim210")
    absent = Name("vibration_rectification", owner="gyro")
    other = Name("bias_repeatability", owner="accelerometer")

    assert ceilings(device, [absent, other], catalogue()) == {}
    assert ceilings(device, [G_SENSITIVITY], ()) == {}
    (angle,) = ceilings(device, [MOUNTING], ()).values()
    assert (angle.u, angle.origin) == (1.0, "no sensor is worse")  # a radian
    with pytest.raises(CallError, match="is no error source"):
        ceilings(device, [Name("drift", owner="gyro")], catalogue())


def test_an_ageing_is_compared_at_a_year():
    """A month's and a year's are no two sizes of the same thing."""
    device = load_device("ltm210#S1B")
    donor = next(one for one in catalogue() if one.name == "STIM300 (5g)")
    month, year = 30.0 * 86400.0, 365.25 * 86400.0
    line = donor.gyro.line("bias_stability")

    def aged(u, horizon, name):
        own = replace(line, name="ageing", u=np.full(3, u), horizons=((horizon, 1.0),))
        gyro = donor.gyro.with_lines((*donor.gyro.lines, own))
        return replace(donor, name=name, gyro=gyro)

    those = [aged(1e-6, month, "month"), aged(2e-6, year, "year")]
    (found,) = ceilings(device, [Name("ageing", owner="gyro")], those).values()

    assert found.largest_comparable.owner == "month"  # a drift: 12.2e-6 after a year
    assert_allclose(found.u, 1e-6 * year / month, rtol=1e-9)
    assert found.line.horizons == ((year, 1.0),)


@pytest.mark.parametrize("name", ["jdwdg073-083#073", "stim300#80g", "ltm210#S10"])
def test_a_hidden_technology_lowers_no_ceiling(name):
    """What is predicted is then of the worst technology: 0.16 of it, were it not so."""
    device = load_device(name)
    names = [line for one in device.sensors for line in one.expected_missing]
    told = ceilings(device, names)
    hidden = ceilings(replace(device, technology=""), names)

    assert told
    for line, one in told.items():
        assert hidden[line].u >= 0.98 * one.u  # fitted from the weights of the former


@pytest.mark.parametrize(
    ("device", "printed", "owner", "ceiling"),
    [
        # 0.006 x 9.80665 x 3600/sqrt(3) deg/h/g, of a tactical gyro.
        ("hg4930#C", "0.006 (°/s)/(m/s2)", "SCH16T-K01", 122.296),
        ("stim300#5g", "0.006 (°/s)/(m/s2)", "SCH16T-K01", 122.296),
        # Of the same, without the one that prints the most: typical.
        ("sch16t-k01", "7 °/h/g", "STIM300 (5g)", 7.0),
    ],
)
def test_a_g_sensitivity_that_a_maker_prints_is_seen(device, printed, owner, ceiling):
    """What sheets print is a line, not a figure that nobody compares with."""
    hiding = without(load_device(device), "gyro", "g_sensitivity")
    found = ceilings(hiding, [G_SENSITIVITY], catalogue())[G_SENSITIVITY]
    worst = found.largest_comparable
    assert (worst.printed, worst.owner) == (printed, owner)
    assert_allclose(found.u / (np.deg2rad(1.0) / 3600 / 9.80665), ceiling, rtol=1e-5)
