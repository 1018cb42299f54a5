"""Table of the targets of an export, one row each: keys, units and how each counts.

Keys, units and meanings are as the target publishes them or, where its text leaves
them open, as its code uses them; `sources` says where that was read. A target is this
row and a template of its name in the folder templates/export.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import ANGLES, AXES
from budget.units import (
    ARCSEC,
    DEG_PER_HOUR,
    DEGREE,
    HOUR,
    PPM,
    STANDARD_GRAVITY,
)

if TYPE_CHECKING:
    from collections.abc import Callable

MILLI_GAL = 1e-5  # [m/s^2]
ROOT_HOUR = sqrt(HOUR)  # [sqrt(s)]
# glv.g0 of PSINS, which its ug are of [m/s^2].
PSINS_GRAVITY = 9.7803267714

ONE, BY_AXIS = ("",), AXES
# What becomes of a key whose figure is not known: the export is refused, the key is
# left out, or it is 0, where that is how the target leaves the effect out.
REFUSE, LEAVE_OUT, ZERO = "refuse", "leave out", "zero"


@dataclass(frozen=True, kw_only=True)
class Form:
    """How a target counts a figure v at the sampling rate f."""

    value: Callable[[float, float], float]  # of v and f
    power: int  # of v in it: what a standard deviation is multiplied by acts so often
    formula: str  # '' of v itself
    by_sample: bool = False


PLAIN = Form(value=lambda v, _: v, power=1, formula="")
TIME = Form(value=lambda v, _: v, power=0, formula="")
VARIANCE = Form(value=lambda v, _: v * v, power=2, formula="{v}^2")
SAMPLE = Form(
    value=lambda v, f: v * sqrt(f), power=1, formula="{v} sqrt(f)", by_sample=True
)
SAMPLE_VARIANCE = Form(
    value=lambda v, f: v * v * f, power=2, formula="{v}^2 f", by_sample=True
)
# Each of the two samples of a step counts as independent of the step before, in which
# it was used too: half the variance. Var v of a step of dt is dt^2 n^2/2, to be N^2 dt.
MIDPOINT = Form(
    value=lambda v, f: v * sqrt(2.0 * f),
    power=1,
    formula="{v} sqrt(2 f)",
    by_sample=True,
)


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One key of a target.

    Attributes
    ----------
    key : str
        As the target has it, in the template too.
    owner, quantity : str
        What it holds: a row of budget.studies.export.figures.
    unit : str
        As the target prints it.
    size : float
        Of that unit [SI].
    form : Form
    axes : tuple of str
        Whose values it holds, in its order; ('',) where one stands for all.
    absent : str
        REFUSE, LEAVE_OUT or ZERO.
    above_zero : bool
        Whether the target reads no 0 there.
    """

    key: str
    owner: str
    quantity: str
    unit: str
    size: float = 1.0
    form: Form = PLAIN
    axes: tuple[str, ...] = BY_AXIS
    absent: str = REFUSE
    above_zero: bool = False


@dataclass(frozen=True, kw_only=True)
class Target:
    """A program that reads figures of an IMU.

    Attributes
    ----------
    name : str
        What `--to` calls it.
    title : str
    template : str
        File in templates/export.
    comment : str
        What a line of comment begins with; '<!--' of one that ends with '-->'.
    entries : tuple of Entry
    sources : tuple of str
        Where keys, units and their use were read.
    notes : tuple of str
        What a user of the file must know.
    needs_rate : bool
        Whether it has no meaning without a sampling rate.
    one_time : bool
        Whether it has one correlation time for both triads, the gyros'.
    """

    name: str
    title: str
    template: str
    comment: str
    entries: tuple[Entry, ...]
    sources: tuple[str, ...]
    notes: tuple[str, ...] = ()
    needs_rate: bool = False
    one_time: bool = False


# Noise and random walk of both triads, densities in SI.
_KALIBR = tuple(
    Entry(key=key, owner=owner, quantity=quantity, unit=unit, axes=ONE, above_zero=True)
    for key, owner, quantity, unit in (
        ("gyroscope_noise_density", GYRO, "noise", "rad/s/sqrt(Hz)"),
        ("gyroscope_random_walk", GYRO, "drift", "rad/s^2/sqrt(Hz)"),
        ("accelerometer_noise_density", ACCELEROMETER, "noise", "m/s^2/sqrt(Hz)"),
        ("accelerometer_random_walk", ACCELEROMETER, "drift", "m/s^3/sqrt(Hz)"),
    )
)

TARGETS = (
    Target(
        name="kalibr",
        title="Kalibr",
        template="kalibr.yaml.in",
        comment="#",
        entries=_KALIBR,
        sources=(
            (
                "https://github.com/adujardin/kalibr/wiki/IMU-Noise-Model, a copy of "
                "Kalibr's own (white noise and random walk of continuous time)"
            ),
            (
                "https://github.com/ethz-asl/kalibr, kalibr_common/ConfigReader.py, "
                "ImuParameters (keys; all four above 0)"
            ),
        ),
        needs_rate=True,
    ),
    Target(
        name="openvins",
        title="OpenVINS",
        template="openvins.yaml.in",
        comment="#",
        entries=_KALIBR,
        sources=(
            (
                "https://github.com/rpng/open_vins, "
                "config/euroc_mav/kalibr_imu_chain.yaml "
                "(keys and units)"
            ),
        ),
        notes=(
            (
                "intrinsics and the rotation of the body are those of a "
                "calibrated unit: "
                "identities"
            ),
        ),
        needs_rate=True,
    ),
    Target(
        name="vins",
        title="VINS-Mono and VINS-Fusion",
        template="vins.yaml.in",
        comment="#",
        entries=(
            Entry(
                key="acc_n",
                owner=ACCELEROMETER,
                quantity="noise",
                unit="m/s^2",
                form=MIDPOINT,
                axes=ONE,
            ),
            Entry(
                key="gyr_n",
                owner=GYRO,
                quantity="noise",
                unit="rad/s",
                form=MIDPOINT,
                axes=ONE,
            ),
            Entry(
                key="acc_w",
                owner=ACCELEROMETER,
                quantity="drift",
                unit="m/s^3",
                form=SAMPLE,
                axes=ONE,
            ),
            Entry(
                key="gyr_w",
                owner=GYRO,
                quantity="drift",
                unit="rad/s^2",
                form=SAMPLE,
                axes=ONE,
            ),
        ),
        sources=(
            (
                "https://github.com/HKUST-Aerial-Robotics/VINS-Fusion, "
                "config/euroc/euroc_stereo_imu_config.yaml (keys)"
            ),
            (
                "the same, vins_estimator/src/factor/integration_base.h, "
                "midPointIntegration (use: by the sample, V noise V^T with dt in V)"
            ),
        ),
        notes=(
            (
                "these keys belong into the configuration of the cameras, in "
                "the place of "
                "those there"
            ),
            (
                "the four count by the sample, at the rate above: at another "
                "rate they are "
                "others"
            ),
        ),
        needs_rate=True,
    ),
    Target(
        name="gtsam",
        title="GTSAM",
        template="gtsam.py.in",
        comment="#",
        entries=(
            Entry(
                key="gyroscope_covariance",
                owner=GYRO,
                quantity="noise",
                unit="(rad/s)^2/Hz",
                form=VARIANCE,
            ),
            Entry(
                key="accelerometer_covariance",
                owner=ACCELEROMETER,
                quantity="noise",
                unit="(m/s^2)^2/Hz",
                form=VARIANCE,
            ),
            Entry(
                key="bias_omega_covariance",
                owner=GYRO,
                quantity="drift",
                unit="(rad/s^2)^2/Hz",
                form=VARIANCE,
            ),
            Entry(
                key="bias_acc_covariance",
                owner=ACCELEROMETER,
                quantity="drift",
                unit="(m/s^3)^2/Hz",
                form=VARIANCE,
            ),
            Entry(
                key="bias_acc_prior",
                owner=ACCELEROMETER,
                quantity="total_bias",
                unit="m/s^2",
                absent=LEAVE_OUT,
            ),
            Entry(
                key="bias_omega_prior",
                owner=GYRO,
                quantity="total_bias",
                unit="rad/s",
                absent=LEAVE_OUT,
            ),
        ),
        sources=(
            (
                "https://github.com/borglab/gtsam, "
                "gtsam/navigation/PreintegrationCombinedParams.h "
                "and PreintegrationParams.h (names; covariances of continuous time)"
            ),
        ),
        notes=(
            (
                "the integration covariance is no figure of the device: it "
                "stays as GTSAM "
                "has it"
            ),
        ),
    ),
    Target(
        name="kf-gins",
        title="KF-GINS",
        template="kf-gins.yaml.in",
        comment="#",
        entries=(
            Entry(
                key="arw",
                owner=GYRO,
                quantity="noise",
                unit="deg/sqrt(hr)",
                size=DEGREE / ROOT_HOUR,
            ),
            Entry(
                key="vrw",
                owner=ACCELEROMETER,
                quantity="noise",
                unit="m/s/sqrt(hr)",
                size=1.0 / ROOT_HOUR,
            ),
            Entry(
                key="gbstd",
                owner=GYRO,
                quantity="stability",
                unit="deg/hr",
                size=DEG_PER_HOUR,
            ),
            Entry(
                key="abstd",
                owner=ACCELEROMETER,
                quantity="stability",
                unit="mGal",
                size=MILLI_GAL,
            ),
            Entry(
                key="gsstd",
                owner=GYRO,
                quantity="scale_factor",
                unit="ppm",
                size=PPM,
            ),
            Entry(
                key="asstd",
                owner=ACCELEROMETER,
                quantity="scale_factor",
                unit="ppm",
                size=PPM,
            ),
            Entry(
                key="corrtime",
                owner=GYRO,
                quantity="correlation_time",
                unit="hr",
                size=HOUR,
                form=TIME,
                axes=ONE,
            ),
            Entry(
                key="initbgstd",
                owner=GYRO,
                quantity="total_bias",
                unit="deg/h",
                size=DEG_PER_HOUR,
                absent=LEAVE_OUT,
            ),
            Entry(
                key="initbastd",
                owner=ACCELEROMETER,
                quantity="total_bias",
                unit="mGal",
                size=MILLI_GAL,
                absent=LEAVE_OUT,
            ),
        ),
        sources=(
            "https://github.com/i2Nav-WHU/KF-GINS, dataset/kf-gins.yaml (keys, units)",
            (
                "the same, src/kf_gins.cpp, loadConfig, and src/kf-gins/gi_engine.cpp "
                "(use: Gauss-Markov, 2 sigma^2/T)"
            ),
        ),
        notes=(
            (
                "these keys belong into the configuration of the run, in the place of "
                "those there"
            ),
            (
                "scale factors are Gauss-Markov processes of the same correlation time "
                "there; here they are constants, of which a process is a proxy"
            ),
        ),
        one_time=True,
    ),
    Target(
        name="psins",
        title="PSINS",
        template="psins.m.in",
        comment="%",
        entries=(
            Entry(
                key="eb", owner=GYRO, quantity="bias", unit="deg/h", size=DEG_PER_HOUR
            ),
            Entry(
                key="db",
                owner=ACCELEROMETER,
                quantity="bias",
                unit="ug",
                size=1e-6 * PSINS_GRAVITY,
            ),
            Entry(
                key="web",
                owner=GYRO,
                quantity="noise",
                unit="deg/sqrt(h)",
                size=DEGREE / ROOT_HOUR,
            ),
            Entry(
                key="wdb",
                owner=ACCELEROMETER,
                quantity="noise",
                unit="ug/sqrt(Hz)",
                size=1e-6 * PSINS_GRAVITY,
            ),
            Entry(
                key="sqrtR0G",
                owner=GYRO,
                quantity="stability",
                unit="deg/h",
                size=DEG_PER_HOUR,
                absent=ZERO,
            ),
            Entry(
                key="TauG",
                owner=GYRO,
                quantity="correlation_time",
                unit="s",
                form=TIME,
                absent=ZERO,
            ),
            Entry(
                key="sqrtR0A",
                owner=ACCELEROMETER,
                quantity="stability",
                unit="ug",
                size=1e-6 * PSINS_GRAVITY,
                absent=ZERO,
            ),
            Entry(
                key="TauA",
                owner=ACCELEROMETER,
                quantity="correlation_time",
                unit="s",
                form=TIME,
                absent=ZERO,
            ),
            Entry(
                key="dKGii",
                owner=GYRO,
                quantity="scale_factor",
                unit="ppm",
                size=PPM,
                absent=ZERO,
            ),
            Entry(
                key="dKAii",
                owner=ACCELEROMETER,
                quantity="scale_factor",
                unit="ppm",
                size=PPM,
                absent=ZERO,
            ),
            # dKg(2,1), (3,1), (3,2), (1,2), (1,3), (2,3); of dKa the first three.
            Entry(
                key="dKGij",
                owner=GYRO,
                quantity="mounting_angle",
                unit="arcsec",
                size=ARCSEC,
                axes=("yz", "zy", "zx", "xz", "xy", "yx"),
                absent=ZERO,
            ),
            Entry(
                key="dKAij",
                owner=ACCELEROMETER,
                quantity="mounting_angle",
                unit="arcsec",
                size=ARCSEC,
                axes=("yz", "zy", "zx"),
                absent=ZERO,
            ),
            Entry(
                key="KA2",
                owner=ACCELEROMETER,
                quantity="quadratic",
                unit="ug/g^2",
                size=1e-6 / PSINS_GRAVITY,
                absent=ZERO,
            ),
        ),
        sources=(
            (
                "https://github.com/asenlinmu/psins, a copy of the PSINS toolbox: "
                "base/imu/imuerrset.m (arguments, units) and base/glvf.m "
                "(g0 = 9.7803267714 m/s^2, of which its ug is)"
            ),
        ),
        notes=(
            (
                "of accelerometers it has three mounting angles, (2,1), (3,1) "
                "and (3,2): "
                "its body is theirs; xy, xz and yx are not held"
            ),
        ),
    ),
    Target(
        name="gazebo",
        title="Gazebo",
        template="gazebo.sdf.in",
        comment="<!--",
        entries=tuple(
            Entry(
                key=f"{key}_{name}",
                owner=owner,
                quantity=quantity,
                unit="s" if form is TIME else unit + suffix,
                form=form,
                absent=absent,
            )
            for owner, key, unit in (
                (GYRO, "angular_velocity", "rad/s"),
                (ACCELEROMETER, "linear_acceleration", "m/s^2"),
            )
            for name, quantity, suffix, form, absent in (
                ("stddev", "noise", "", SAMPLE, REFUSE),
                ("bias_stddev", "bias", "", PLAIN, LEAVE_OUT),
                ("dynamic_bias_stddev", "driving", "/sqrt(s)", PLAIN, LEAVE_OUT),
                (
                    "dynamic_bias_correlation_time",
                    "correlation_time",
                    "",
                    TIME,
                    LEAVE_OUT,
                ),
            )
        ),
        sources=(
            (
                "https://github.com/gazebosim/sdformat, sdf/1.9/imu.sdf and noise.sdf "
                "(elements)"
            ),
            (
                "https://github.com/gazebosim/gz-sensors, "
                "src/GaussianNoiseModel.cc (use: "
                "stddev by the sample; dynamic_bias_stddev drives a process, whose own "
                "sigma is that times sqrt(T/2))"
            ),
        ),
        notes=(
            (
                "Gazebo lets the bias of a turn-on fade with the correlation "
                "time of the "
                "dynamic bias"
            ),
        ),
        needs_rate=True,
    ),
    Target(
        name="ros",
        title="ROS, sensor_msgs/Imu",
        template="ros.yaml.in",
        comment="#",
        entries=(
            Entry(
                key="angular_velocity_covariance",
                owner=GYRO,
                quantity="noise",
                unit="rad^2/s^2",
                form=SAMPLE_VARIANCE,
            ),
            Entry(
                key="linear_acceleration_covariance",
                owner=ACCELEROMETER,
                quantity="noise",
                unit="m^2/s^4",
                form=SAMPLE_VARIANCE,
            ),
        ),
        sources=(
            (
                "https://docs.ros.org/en/jazzy/p/sensor_msgs/msg/Imu.html (fields: row "
                "major, variances of a measurement; -1 first: there is no orientation)"
            ),
        ),
        notes=(
            (
                "variances of a sample, white noise alone: whoever reads them "
                "takes the "
                "errors of two samples for independent, which those of a bias are not"
            ),
        ),
        needs_rate=True,
    ),
    Target(
        name="matlab",
        title="MATLAB imuSensor",
        template="matlab.m.in",
        comment="%",
        entries=tuple(
            Entry(
                key=f"{triad}_{name}",
                owner=owner,
                quantity=quantity,
                unit=unit.format(u=si),
                form=form,
                axes=axes,
                absent=absent,
            )
            for owner, triad, si in (
                (GYRO, "gyro", "rad/s"),
                (ACCELEROMETER, "accel", "m/s^2"),
            )
            for name, quantity, unit, form, axes, absent in (
                ("NoiseDensity", "noise", "({u})/sqrt(Hz)", PLAIN, AXES, REFUSE),
                ("RandomWalk", "walk", "({u})(sqrt(Hz))", PLAIN, AXES, LEAVE_OUT),
                ("BiasInstability", "step", "{u}", PLAIN, AXES, LEAVE_OUT),
                ("Memory", "memory", "1", TIME, ONE, LEAVE_OUT),
                ("Bias", "bias", "{u}", PLAIN, AXES, LEAVE_OUT),
                ("ScaleFactor", "scale_factor", "1", PLAIN, AXES, ZERO),
                ("Mounting", "mounting_angle", "rad", PLAIN, ANGLES, ZERO),
            )
        ),
        sources=(
            (
                "https://www.mathworks.com/help/nav/ref/gyroparams.html and "
                "accelparams.html (properties, units; AxesMisalignment in %)"
            ),
            (
                "https://www.mathworks.com/help/nav/ref/fractalcoef.html "
                "(BiasInstabilityCoefficients, from R2023b)"
            ),
        ),
        notes=(
            (
                "BiasInstability drives the filter of "
                "BiasInstabilityCoefficients, which "
                "here is the Gauss-Markov process itself, at the rate above"
            ),
            (
                "constants are drawn anew at each run of the script (randn): "
                "bias, scale "
                "factors and mounting angles"
            ),
        ),
        needs_rate=True,
    ),
    Target(
        name="nav-toolkit",
        title="NaveGo",
        template="nav-toolkit.m.in",
        comment="%",
        entries=(
            Entry(
                key="arw",
                owner=GYRO,
                quantity="noise",
                unit="deg/root-hour",
                size=DEGREE / ROOT_HOUR,
            ),
            Entry(
                key="vrw",
                owner=ACCELEROMETER,
                quantity="noise",
                unit="m/s/root-hour",
                size=1.0 / ROOT_HOUR,
            ),
            Entry(
                key="arrw",
                owner=GYRO,
                quantity="walk",
                unit="deg/root-hour/s",
                size=DEGREE / ROOT_HOUR,
                absent=ZERO,
            ),
            Entry(
                key="vrrw",
                owner=ACCELEROMETER,
                quantity="walk",
                unit="m/s/root-hour/s",
                size=1.0 / ROOT_HOUR,
                absent=ZERO,
            ),
            Entry(key="gb_sta", owner=GYRO, quantity="bias", unit="deg/s", size=DEGREE),
            Entry(
                key="ab_sta",
                owner=ACCELEROMETER,
                quantity="bias",
                unit="mg",
                size=1e-3 * STANDARD_GRAVITY,
            ),
            Entry(
                key="gb_dyn",
                owner=GYRO,
                quantity="stability",
                unit="deg/s",
                size=DEGREE,
            ),
            Entry(
                key="ab_dyn",
                owner=ACCELEROMETER,
                quantity="stability",
                unit="mg",
                size=1e-3 * STANDARD_GRAVITY,
            ),
            Entry(
                key="gb_corr",
                owner=GYRO,
                quantity="correlation_time",
                unit="s",
                form=TIME,
            ),
            Entry(
                key="ab_corr",
                owner=ACCELEROMETER,
                quantity="correlation_time",
                unit="s",
                form=TIME,
            ),
        ),
        sources=(
            (
                "https://github.com/rodralez/NaveGo, "
                "conversions/imu_si_errors.m (fields, "
                "units; the unit that it prints for vrrw is of arrw, its code "
                "has the one "
                "here)"
            ),
            "the same, simulation/noise_b_dyn.m, noise_b_sta.m and noise_rrw.m (use)",
        ),
        notes=(
            (
                "a static bias is taken by NaveGo as it stands, with a tenth of it at "
                "random: here it is one standard uncertainty"
            ),
            (
                "NaveGo's simulation adds arrw dt at each sample, so that its walk is "
                "smaller than the one written by sqrt(dt)"
            ),
        ),
    ),
)
NAMES = tuple(target.name for target in TARGETS)
