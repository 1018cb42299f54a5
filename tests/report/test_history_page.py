"""Calibrations over time as people read them: each number to what it is known to."""

from __future__ import annotations

import pytest
from numpy.testing import assert_allclose

from budget.recordings.history import CalibratedValue, HistoryRow
from budget.report.calibration_history import printed_drift


def row(value, expanded, drift, reach):
    """Return a parameter with one value and a drift."""
    known = reach is not None
    last = CalibratedValue(
        name="a.json",
        date="2026-05-11",
        time=0.0,
        value=value,
        standard_uncertainty=None if expanded is None else expanded / 2.0,
        expanded=expanded,
    )
    return HistoryRow(
        sensor="gyro",
        parameter="bias",
        axis="x",
        unit="deg/h",
        values=(last,),
        repeatability=None,
        drift=drift,
        drift_low=drift - reach if known else None,
        drift_high=drift + reach if known else None,
        scatter=None,
        p=None,
        standing="not told",
        ageing=None,
        is_older=False,
        limit=None,
        reaches=None,
        earliest=None,
    )


@pytest.mark.parametrize(
    ("numbers", "printed"),
    [
        ((53.097, 57.4, 13.21, 45.6), ("53", "57", "+13", "46")),
        ((17.661, 8.94, 6.234, 6.07), ("17.7", "8.9", "+6.2", "6.1")),
        ((-0.0601, 8.5, -0.012, 5.8), ("-0.1", "8.5", "+0.0", "5.8")),
        ((17.661, None, 6.23456, None), ("17.661", "", "6.2346", "")),
    ],
)
def test_a_drift_has_the_digits_of_its_interval(numbers, printed):
    """And a last value those of U; without one of them all that are of use."""
    one = printed_drift(row(*numbers))
    assert (one.last, one.expanded, one.drift, one.reach) == printed
    assert_allclose(one.row.drift, numbers[2], rtol=0)
