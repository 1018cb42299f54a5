"""The calibration procedure: where, with what turns and dwells, read by what."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

from budget.report.blocks import Pairs, Section
from budget.report.figures.rows import chart_picture
from budget.report.figures.timeline import schedule_chart
from budget.report.tables import print_given

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Block, Words
    from budget.spec.records import Procedure

LATITUDE_DIGITS, GRAVITY_DIGITS = 7, 8


def procedure_section(procedure: Procedure, sensors: Sequence[str]) -> Section:
    """Return the procedure in words, and drawn; of the sensors that are there."""
    rows: list[tuple[str, Words]] = [
        (
            "place",
            (
                (
                    f"latitude {print_degrees(procedure.latitude)} deg, gravity "
                    f"{print_given(procedure.gravity, digits=GRAVITY_DIGITS)} m/s^2"
                ),
            ),
        ),
        ("pulses", (f"read at {print_given(procedure.sample_rate)} Hz",)),
    ]
    if "gyro" in sensors:
        rows += _gyro_rows(procedure)
    if "accelerometer" in sensors:
        dwell = print_given(procedure.accelerometer.dwell)
        pause = _pause(procedure.accelerometer.pause)
        text = f"twelve positions, {dwell} s each{pause}"
        rows.append(("accelerometer", (text,)))
    formulas = (
        "as the paper prints eq. (4) for the gyro bias, all others corrected"
        if procedure.formulas == "paper"
        else "corrected"
    )
    rows.append(("formulas", (f"{formulas}; they stand under Method",)))
    blocks: tuple[Block, ...] = (Pairs(rows=tuple(rows)),)
    schedule = schedule_chart(procedure, sensors)
    if schedule is not None:
        blocks += (chart_picture(schedule),)
    return Section(name="procedure", title="Procedure", blocks=blocks)


def print_degrees(angle: float) -> str:
    """Print an angle of the procedure [rad] in degrees."""
    return print_given(degrees(angle), digits=LATITUDE_DIGITS)


def _gyro_rows(procedure: Procedure) -> list[tuple[str, Words]]:
    """Return the rate turns and the static test."""
    gyro = procedure.gyro
    turns = "turn" if gyro.turns == 1 else "turns"
    azimuths = ", ".join(print_degrees(azimuth) for azimuth in gyro.azimuths)
    return [
        (
            "gyro, rate turns",
            (
                (
                    f"{gyro.turns} {turns} at {print_degrees(gyro.rate)} deg/s, "
                    f"forward and back about {', '.join(gyro.order)}"
                ),
            ),
        ),
        (
            "gyro, static",
            (
                (
                    f"{print_given(gyro.dwell)} s at each azimuth {azimuths} deg"
                    f"{_pause(gyro.pause)}"
                ),
            ),
        ),
    ]


def _pause(pause: float) -> str:
    """Say how long the pauses are, where there are any [s]."""
    return f"; pause {print_given(pause)} s between all windows" if pause else ""
