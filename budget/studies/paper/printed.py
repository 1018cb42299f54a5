"""What Zhao 2019 prints, digit by digit, and where it stands.

Table 1 does not say in which order its six angles stand; its last row shows it (see
mounting.py).
"""

from __future__ import annotations

from dataclasses import dataclass

from budget.model.sources import GYRO
from budget.names import Name
from budget.spec.records import ANGLES

RUNS = 25  # section 3.1
ANGLE_ORDER = ("xz", "xy", "yz", "yx", "zy", "zx")  # of the angles in Table 1


@dataclass(frozen=True, kw_only=True)
class PrintedRow:
    """One row of Table 1: relative errors [1], angles in the order of ANGLE_ORDER."""

    source: Name
    condition: str
    scale_factor: tuple[str, str, str]
    mounting_angle: tuple[str, str, str, str, str, str]
    bias: tuple[str, str, str]

    @property
    def entries(self) -> tuple[str, ...]:
        """All twelve entries in the order of our outputs."""
        angles = dict(zip(ANGLE_ORDER, self.mounting_angle, strict=True))
        ordered = (angles[name] for name in ANGLES)
        return (*self.scale_factor, *ordered, *self.bias)


@dataclass(frozen=True, kw_only=True)
class PrintedOrder:
    """An order of magnitude that the text gives for the errors of one parameter."""

    section: str
    sensor: str
    source: Name  # '' for a run without any error
    condition: str
    parameter: str
    order: str  # [unit]; '0' for none
    unit: str = "1"  # of the text, a key of UNITS
    note: str = ""  # where the text gives it in another way


TABLE_1 = (
    PrintedRow(
        source=Name("bias_repeatability", owner=GYRO),
        condition="bias repeatability 0.05 deg/h",
        scale_factor=("0", "0", "0"),
        mounting_angle=(
            "8.8817e-16",
            "-8.8817e-16",
            "-2.7866e-14",
            "7.9936e-15",
            "6.4392e-15",
            "6.4392e-15",
        ),
        bias=("0.00467", "0.00154", "0.00534"),
    ),
    PrintedRow(
        source=Name("bias_stability", owner=GYRO),
        condition="bias stability 0.04 deg/h, 300 s",
        scale_factor=("-1.2262e-7", "-2.4947e-7", "9.1776e-7"),
        mounting_angle=("-0.1081", "0.0133", "-0.1454", "0.0479", "-0.0075", "0.0155"),
        bias=("-0.00296", "-0.00630", "-0.00577"),
    ),
    PrintedRow(
        source=Name("scale_factor_repeatability", owner=GYRO),
        condition="scale factor repeatability 50 ppm",
        scale_factor=("-8.9744e-6", "-5.5502e-7", "1.2164e-5"),
        mounting_angle=(
            "3.7747e-15",
            "0",
            "-2.4313e-14",
            "5.9952e-15",
            "7.7715e-15",
            "7.7715e-15",
        ),
        bias=("-3.18263e-10", "-3.18264e-10", "6.36529e-10"),
    ),
    PrintedRow(
        source=Name("angle_random_walk", owner=GYRO),
        condition="angle random walk 0.005 deg/sqrt(h)",
        scale_factor=("1.95118e-9", "7.3213e-9", "-3.144e-9"),
        mounting_angle=(
            "-0.0003",
            "0.0002",
            "-0.0001",
            "-0.00038",
            "-0.00035",
            "0.00019",
        ),
        bias=("2.44844e-6", "-6.19804e-6", "1.08101e-5"),
    ),
    PrintedRow(
        source=Name("mounting_repeatability", owner=GYRO),
        condition="mounting repeatability 2 arcsec",
        scale_factor=("0", "0", "0"),
        mounting_angle=(
            "-0.95228",
            "-1.05342",
            "-1.08526",
            "-1.13201",
            "-0.87941",
            "-0.94683",
        ),
        bias=("7.70764e-6", "-6.13065e-6", "-7.61494e-7"),
    ),
)


def _orders(  # one condition, up to three parameters
    section: str,
    sensor: str,
    source: str,
    condition: str,
    *,
    scale_factor: str = "",
    mounting_angle: str = "",
    bias: str = "",
    unit: str = "1",
    note: str = "",
) -> tuple[PrintedOrder, ...]:
    """Return what the text gives under one condition."""
    given = {
        "scale_factor": scale_factor,
        "mounting_angle": mounting_angle,
        "bias": bias,
    }
    return tuple(
        PrintedOrder(
            section=section,
            sensor=sensor,
            source=Name(source, owner=sensor) if source else Name(""),
            condition=condition,
            parameter=parameter,
            order=order,
            unit=unit,
            note=note,
        )
        for parameter, order in given.items()
        if order
    )


# In which the text gives an order, and how much of it a relative error of 1 is: the
# nominal 2 arcsec and 2.5 deg/h of 3.1.
UNITS = {"1": 1.0, "arcsec": 2.0, "deg/h": 2.5}
# Of the stability the text also says "within 0.1e-6", as no other order: see orders.py.
BOUND = "0.1e-6"

GYRO_ORDERS = (
    *_orders(
        "3.1",
        "gyro",
        "",
        "no error",
        scale_factor="0",
        mounting_angle="1e-14",
        bias="1e-10",
    ),
    *_orders(
        "3.1",
        "gyro",
        "bias_repeatability",
        "bias repeatability",
        scale_factor="0",
        mounting_angle="1e-14",
    ),
    *_orders(
        "3.1",
        "gyro",
        "bias_stability",
        "bias stability",
        scale_factor="1e-7",
        mounting_angle="1e-1",
        bias="1e-3",
    ),
    *_orders(
        "3.1",
        "gyro",
        "scale_factor_repeatability",
        "scale factor repeatability",
        mounting_angle="1e-14",
        unit="arcsec",
    ),
    *_orders(
        "3.1",
        "gyro",
        "scale_factor_repeatability",
        "scale factor repeatability",
        bias="1e-9",
        unit="deg/h",
    ),
    *_orders(
        "3.1",
        "gyro",
        "angle_random_walk",
        "angle random walk",
        scale_factor="1e-9",
        mounting_angle="1e-4",
        bias="1e-5",
    ),
    *_orders(
        "3.1",
        "gyro",
        "mounting_repeatability",
        "mounting repeatability",
        scale_factor="0",
        bias="1e-6",
    ),
)

ACCELEROMETER_ORDERS = (
    *_orders(
        "3.2",
        "accelerometer",
        "",
        "no error",
        scale_factor="1e-15",
        mounting_angle="1e-10",
        bias="1e-13",
    ),
    *_orders(
        "3.2",
        "accelerometer",
        "bias_repeatability",
        "bias repeatability 37 ug",
        scale_factor="1e-15",
        mounting_angle="1e-10",
    ),
    *_orders(
        "3.2",
        "accelerometer",
        "scale_factor_repeatability",
        "scale factor repeatability 37 ppm",
        mounting_angle="1e-11",
        bias="1e-14",
        note="the text prints 37 ug; a scale factor repeats in ppm",
    ),
    *_orders(
        "3.2",
        "accelerometer",
        "scale_factor_nonlinearity",
        "nonlinearity 30 ppm x i",
        mounting_angle="1e-10",
        bias="1e-14",
        note="ours at i = 25, 750 ppm",
    ),
    *_orders(
        "3.2",
        "accelerometer",
        "mounting_repeatability",
        "mounting repeatability 2 arcsec",
        scale_factor="1e-15",
        bias="1e-14",
    ),
    *_orders(
        "3.2",
        "accelerometer",
        "bias_stability",
        "bias stability 20 ug",
        scale_factor="1e-6",
        mounting_angle="1e-1",
        bias="1e-3",
        note="correlation time 300 s assumed: the text gives none here",
    ),
    *_orders(
        "3.2",
        "accelerometer",
        "sample_noise",
        "noise 50 ug in each sample",
        scale_factor="1e-11",
        mounting_angle="1e-5",
        bias="1e-9",
        note="taken as white noise in each of the samples at 100 Hz",
    ),
)

# Figures 1 to 4: only the orders that the text reads off them survive; 1, 2: steps of
# nonlinearity, 3, 4: steps of asymmetry, i = 1 to 25.
FIGURE_ORDERS = {
    "figure 1": "1e-10",
    "figure 2": "1e-14",
    "figure 3": "1e-1",
    "figure 4": "1e-7",
}
NONLINEARITY_STEP = 30e-6  # [1]
ASYMMETRY_STEP = 50e-6  # [1]
