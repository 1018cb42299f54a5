"""Windows that are not in a recording: which ones, said first."""

from __future__ import annotations

from functools import cache

import pytest
from calibration.test_mistakes import MEMS

from budget.errors import CallError
from budget.recordings.calibrate import calibrate
from budget.recordings.simulated_run import simulated_run

HOW = {
    "name": "six faces",
    "latitude": "34.2394 deg",
    "gravity": "normal",
    "sample_rate": "50 Hz",
    "estimator": "least_squares",
    "pause": "4 s",
    "windows": [
        {"face": "all", "dwell": "10 s"},
        *(
            {"face": f"{axis} up", "turn": "vertical", "turns": 1, "rate": "45 deg/s"}
            | {"back": True, "use": "gyro"}
            for axis in "zxy"
        ),
    ],
}


@cache
def recording():
    """Return the rows of a run, and when each window was."""
    made = simulated_run(MEMS, procedure=HOW, seed=4, rate=50.0)
    head, *rows = "".join(made.csv()).splitlines()
    return head, tuple(rows), made.schedule.windows


@pytest.mark.parametrize(
    ("gone", "said"),
    [
        ((3,), "without 3 x up they would be"),
        ((2, 5), "without 2 z down, 5 y up they would be"),
        ((9, 10), "without 9 turn +1 vertical at x up, 10 turn -1 vertical at x up"),
        (tuple(range(1, 10)), "of 12 are not (is it that procedure?)"),
    ],
)
def test_windows_that_are_missing_are_named_first(tmp_path, gone, said):
    """Rests at their face, and turns by the rest before them; of many how many."""
    head, rows, windows = recording()
    cut = [
        (windows[k - 1].start - 1.5, windows[k - 1].start + windows[k - 1].length + 1.5)
        for k in gone
    ]
    kept = [
        row
        for row in rows
        if not any(a <= float(row.split(",")[0]) <= b for a, b in cut)
    ]
    (tmp_path / "run.csv").write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")
    with pytest.raises(CallError) as found:
        calibrate(tmp_path / "run.csv", procedure=HOW, device=MEMS)
    first = str(found.value).splitlines()[0]
    assert said in first, first


def test_of_rests_that_may_be_anywhere_it_is_said_how_many_there_are(tmp_path):
    """By the norm of gravity no face is wanted."""
    head, rows, _ = recording()
    (tmp_path / "run.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    with pytest.raises(CallError, match="rests are there, 18 wanted"):
        calibrate(tmp_path / "run.csv", procedure="norm-eighteen-positions")
