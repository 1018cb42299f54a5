"""Budgets made by hand, for the tests of the formats; no engine stands behind them."""

from __future__ import annotations

from dataclasses import replace
from math import fsum, pi, sqrt
from types import SimpleNamespace

import numpy as np

from budget.distributions import NORMAL, UNIFORM
from budget.inputs.records import (
    ANGLES,
    AXES,
    AccelerometerProcedure,
    Device,
    ErrorLine,
    GyroProcedure,
    Origin,
    Procedure,
    Sensor,
    UnusedValue,
)
from budget.known import Known
from budget.language import note
from budget.names import Name, key_title, parameters_of
from budget.problem import Output
from budget.results import (
    INTERACTION,
    Assessment,
    Budget,
    Condition,
    Contribution,
    InputFile,
    JudgedOutput,
    OutputBudget,
    Probability,
    Remedy,
    SobolIndex,
    Validation,
    Verdict,
)
from budget.settings import Settings
from budget.studies.densities import ErrorDensity
from budget.studies.evidence import Coupling, CouplingTable
from budget.ties import largest
from budget.units import ARCSEC, DEG_PER_HOUR, DEGREE, MICRO_G, PPM

# Standard uncertainty of each source alone, in printed units: by group and source.
GYRO = {
    ("scale_factor", "ppm", PPM): {
        "bias_repeatability": 0.0,
        "bias_stability": 0.077,
        "angle_random_walk": 0.69,
        "scale_factor_repeatability": 50.0,
        "mounting_repeatability": 0.0,
        "interaction": 2.4e-9,
    },
    ("mounting_angle", "arcsec", ARCSEC): {
        "bias_repeatability": 0.0,
        "bias_stability": 0.016,
        "angle_random_walk": 0.143,
        "scale_factor_repeatability": 0.0,
        "mounting_repeatability": 2.0,
        "interaction": 1e-4,
    },
    ("bias", "deg/h", DEG_PER_HOUR): {
        "bias_repeatability": 0.05,
        "bias_stability": 0.0259,
        "angle_random_walk": 0.0087,
        "scale_factor_repeatability": 0.0,
        "mounting_repeatability": 0.0,
        "interaction": 2.5e-6,
    },
}
ACCELEROMETER = {
    ("scale_factor", "ppm", PPM): {
        "bias_repeatability": 0.0,
        "bias_stability": 8.7,
        "sample_noise": 0.14,
        "scale_factor_repeatability": 37.0,
        "mounting_repeatability": 0.0,
        "interaction": 0.0,
    },
    ("mounting_angle", "arcsec", ARCSEC): {
        "bias_repeatability": 0.0,
        "bias_stability": 1.8,
        "sample_noise": 0.029,
        "scale_factor_repeatability": 0.0,
        "mounting_repeatability": 2.0,
        "interaction": 0.0,
    },
    ("bias", "ug", MICRO_G): {
        "bias_repeatability": 37.0,
        "bias_stability": 17.2,
        "sample_noise": 0.14,
        "scale_factor_repeatability": 0.0,
        "mounting_repeatability": 0.0,
        "interaction": 0.0,
    },
}
SETTINGS = Settings(
    method="gum",
    trials=None,
    seed=0,
    coverage=0.95,
    interval="symmetric",
    reference="nominal",
    formulas="corrected",
    normals_per_trial=72,
)
SHA = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"


def make_output(
    sensor,
    parameter,
    axis,
    *,
    unit,
    scale,
    sources,
    mean=0.0,
    validation=None,
    skew=0.0,
    resolution=1e-20,
):
    """One output from the standard uncertainties of its sources, in printed units."""
    variance = fsum(u**2 for u in sources.values())
    u = sqrt(variance)
    return OutputBudget(
        output=Output(
            name=Name(parameter, owner=sensor, axis=axis),
            unit=unit,
            si_per_unit=scale,
            resolution=resolution,
        ),
        mean=mean * scale,
        standard_uncertainty=Known(u * scale),
        interval=(
            (mean - (1.96 - skew) * u) * scale,
            (mean + (1.96 + skew) * u) * scale,
        ),
        contributions=tuple(
            Contribution(
                source=INTERACTION
                if name == "interaction"
                else Name(name, owner=sensor),
                standard_uncertainty=Known(u_source * scale),
                share=u_source**2 / variance if variance > 0.0 else 0.0,
            )
            for name, u_source in sources.items()
        ),
        validation=validation,
        law_factor=1.96,
    )


def make_outputs(sensor, groups, **options):
    """All twelve outputs of one triad; the z axis of biases is a little worse."""
    outputs = []
    for (parameter, unit, scale), sources in groups.items():
        for axis in ANGLES if parameter == "mounting_angle" else AXES:
            worse = 1.3 if (parameter, axis) == ("bias", "z") else 1.0
            here = {
                name: u * (worse if name == "bias_stability" else 1.0)
                for name, u in sources.items()
            }
            check = Validation(
                trials=230_000,
                holds=True,
                difference_low=0.0001 * scale,
                difference_high=0.0001 * scale,
                tolerance=0.5 * scale,
                reached=0.05 * scale,
                interval=(-0.1 * scale, 0.1 * scale),
            )
            outputs.append(
                make_output(
                    sensor,
                    parameter,
                    axis,
                    unit=unit,
                    scale=scale,
                    sources=here,
                    validation=check,
                    **options,
                )
            )
    return tuple(outputs)


def reached(owner, *quantities):
    """Return the names of all outputs of some parameters."""
    return tuple(name for name in parameters_of(owner) if name.quantity in quantities)


# What each line that the example does not give would reach.
COULD_WIDEN = {
    Name("rate_random_walk", owner="gyro"): parameters_of("gyro"),
    Name("scale_factor_nonlinearity", owner="gyro"): reached("gyro", "scale_factor"),
    Name("scale_factor_asymmetry", owner="gyro"): parameters_of("gyro"),
    Name("acceleration_random_walk", owner="accelerometer"): parameters_of(
        "accelerometer"
    ),
    Name("scale_factor_nonlinearity", owner="accelerometer"): reached(
        "accelerometer", "scale_factor"
    ),
}


def make_budget(**changes):
    """Return the budget of the paper's device, about."""
    outputs = changes.pop(
        "outputs",
        make_outputs("gyro", GYRO) + make_outputs("accelerometer", ACCELEROMETER),
    )
    budget = Budget(
        command="analyze",
        title="Zhao 2019 optical IMU",
        inputs=(
            InputFile(role="device", name="zhao-2019.yaml", sha256=SHA),
            InputFile(role="procedure", name="zhao-2019.yaml", sha256=SHA[::-1]),
        ),
        settings=SETTINGS,
        outputs=outputs,
        covariance=np.diag([row.standard_uncertainty**2 for row in outputs]),
        question=SimpleNamespace(not_given=tuple(COULD_WIDEN)),
        assumptions=(
            "gyro.bias_stability: the correlation time of 300 s is the file's own",
            "gravity at latitude 34.2394 deg is normal gravity, 9.7966933 m/s^2",
        ),
        warnings=("accelerometer.sample_noise is read as white, per sample",),
        could_widen=COULD_WIDEN,
    )
    return replace(budget, **changes)


def make_line(name, u, unit, scale, *, n=3, printed="", distribution=NORMAL, **texts):
    """One line of a data sheet, equal on all axes, in its printed unit."""
    return ErrorLine(
        name=name,
        u=np.full(n, u * scale),
        distributions=(distribution,) * n,
        printed=printed or f"{u:g} {unit}",
        unit=unit,
        si_per_unit=scale,
        **texts,
    )


def make_device(name="Zhao 2019 optical IMU"):
    """Return the paper's device with a few of the texts that makers add."""
    arw = DEGREE / 60.0  # deg/sqrt(h) [rad/sqrt(s)]
    gyro = Sensor(
        kind="gyro",
        device=name,
        nominal_bias=np.full(3, 2.5 * DEG_PER_HOUR),
        nominal_mounting_angle=np.full(6, 2.0 * ARCSEC),
        lines=(
            make_line("bias_repeatability", 0.05, "deg/h", DEG_PER_HOUR),
            make_line(
                "bias_stability",
                0.04,
                "deg/h",
                DEG_PER_HOUR,
                correlation_time=np.full(3, 300.0),
            ),
            make_line("angle_random_walk", 0.005, "deg/sqrt(h)", arw),
            make_line(
                "scale_factor_repeatability",
                50.0,
                "ppm",
                PPM,
                condition="-40 to 71 degC",
                source="table 2 <rev B>",
            ),
            make_line(
                "mounting_repeatability",
                2.0 / sqrt(3.0),
                "arcsec",
                ARCSEC,
                n=6,
                printed="2 arcsec",
                meaning="max",
                distribution=UNIFORM,
            ),
        ),
        not_given=(
            Name("rate_random_walk", owner="gyro"),
            Name("scale_factor_asymmetry", owner="gyro"),
        ),
        expected_missing=(),
    )
    accelerometer = Sensor(
        kind="accelerometer",
        device=name,
        nominal_bias=np.full(3, 6000.0 * MICRO_G),
        nominal_mounting_angle=np.zeros(6),
        lines=(
            make_line("bias_repeatability", 37.0, "ug", MICRO_G),
            make_line(
                "bias_stability",
                20.0,
                "ug",
                MICRO_G,
                correlation_time=np.full(3, 300.0),
            ),
            make_line("sample_noise", 50.0, "ug", MICRO_G),
            make_line("scale_factor_repeatability", 37.0, "ppm", PPM),
            make_line("mounting_repeatability", 2.0, "arcsec", ARCSEC, n=6),
        ),
        not_given=(Name("scale_factor_nonlinearity", owner="accelerometer"),),
        expected_missing=(),
    )
    return Device(
        name=name,
        gyro=gyro,
        accelerometer=accelerometer,
        figures=(
            UnusedValue(
                name="bandwidth", value="200 Hz", meaning="-3 dB", source="table 1"
            ),
        ),
        assumptions=(),
        origin=Origin(file="zhao-2019.yaml", sha256=SHA),
        source="Zhao, Zhang, Li 2019, section 3",
    )


def make_procedure(**changes):
    """Return the paper's procedure."""
    procedure = Procedure(
        name="Zhao 2019",
        latitude=34.2394 * DEGREE,
        gravity=9.7966933092,
        sample_rate=100.0,
        formulas="corrected",
        gyro=GyroProcedure(
            rate=20.0 * DEGREE,
            turns=1,
            order=("z", "x", "y"),
            pause=0.0,
            azimuths=(0.0, pi, 1.5 * pi, 2.5 * pi),
            dwell=300.0,
        ),
        accelerometer=AccelerometerProcedure(dwell=300.0, pause=0.0),
        assumptions=(),
        origin=Origin(file="zhao-2019.yaml", sha256=SHA),
    )
    return replace(procedure, **changes)


# A requirement that devices of other grades than the paper's hold, or nearly.
WIDE_LIMITS = {
    "name": "wide",
    "coverage": "95 %",
    "reference": "nominal",
    "limits": {
        "gyro": {
            "scale_factor": "900 ppm",
            "mounting_angle": "60 arcsec",
            "bias": "30 deg/h",
        },
    },
}
LIMITS = {
    "gyro.scale_factor": ("100 ppm", 100.0),
    "gyro.mounting_angle": ("5 arcsec", 5.0),
    "gyro.bias": ("0.1 deg/h", 0.1),
    "accelerometer.scale_factor": ("80 ppm", 80.0),
    "accelerometer.mounting_angle": ("6 arcsec", 6.0),
    "accelerometer.bias": ("100 ug", 100.0),
}


# What every verdict made by hand is of, in a headline.
AFTER = "as the maker calibrated it, in the environment of the calibration"


def make_standing(verdict, sensor="gyro", conditions=1):
    """Return a verdict with what it stands on: an undecidable one lacks the noise."""
    noise = Name("noise", owner=sensor)
    calibration, use = AFTER.split(", ")
    lacks = verdict in {"undecidable", "meets_if"}
    return Verdict(
        verdict=verdict,
        conditions=tuple(
            Condition(
                kind="missing",
                line=noise,
                below=DEG_PER_HOUR * (1.0 + place),
                unit="deg/h",
                si_per_unit=DEG_PER_HOUR,
                decides=verdict == "undecidable",
                text=note(
                    "{line} is not given, and from {bound} on it fails: ask for it"
                    if verdict == "undecidable"
                    else "if {line} stays below {bound}",
                    line=note(key_title(noise)),
                    bound=f"{1 + place} deg/h",
                ),
            )
            for place in range(conditions if lacks else 0)
        ),
        calibration=note(calibration),
        use=note(use),
        station=note("an ideal table"),
    )


def make_assessment(budget, limits=None, **verdicts):
    """Hold a budget against limits; a verdict by sensor may be set by hand."""
    limits = LIMITS if limits is None else limits
    outputs = []
    for row in budget.outputs:
        group = f"{row.sensor}.{row.parameter}"
        if group in limits:
            printed, number = limits[group]
            limit = number * row.output.si_per_unit
            outputs.append(
                JudgedOutput(
                    output=row.output,
                    limit=limit,
                    printed_limit=printed,
                    standard_uncertainty=row.standard_uncertainty,
                    interval=row.interval,
                    interval_by=row.interval_by,
                    conformance=0.99,
                )
            )
    sensors = []
    for sensor in dict.fromkeys(o.output.name.split(".")[0] for o in outputs):
        own = [o for o in outputs if o.output.name.startswith(f"{sensor}.")]
        all_worst = [own[k] for k in largest([row.utilisation for row in own])]
        worst = all_worst[0]
        verdict = verdicts.get(sensor, "meets" if worst.is_within else "fails")
        sensors.append(
            replace(
                make_standing(verdict, sensor),
                sensor=sensor,
                outputs=tuple(own),
                utilisation=worst.utilisation,
                utilisation_interval=(worst.utilisation, worst.utilisation),
                conformance=Probability(value=0.9, low=0.89, high=0.91),
                trials=100_000,
                worst_outputs=tuple(row.output.name for row in all_worst),
                remedy=Remedy(
                    source=budget.output(worst.output.name).ranked[0].source,
                    share=1.0,
                    factor=None,
                ),
                expected_missing=(
                    (Name("noise", owner=sensor),) if verdict == "undecidable" else ()
                ),
            )
        )
    return Assessment(
        requirement="tactical grade",
        outputs=tuple(outputs),
        sensors=tuple(sensors),
        conformance=Probability(value=0.81, low=0.80, high=0.82),
    )


def with_checks(budget, off=()):
    """Check every output: the law's interval a tenth of a tolerance too wide.

    `off` maps names of outputs to tolerances that the lower end is off by instead.
    """
    outputs = []
    for row in budget.outputs:
        tolerance = 0.1 * row.standard_uncertainty
        low = dict(off).get(row.output.name, -0.1)
        ends = (row.interval[0] - low * tolerance, row.interval[1] - 0.1 * tolerance)
        check = Validation(
            trials=230_000,
            holds=abs(low) <= 1.0,
            difference_low=abs(row.interval[0] - ends[0]),
            difference_high=abs(row.interval[1] - ends[1]),
            tolerance=tolerance,
            reached=0.1 * tolerance,
            interval=ends,
        )
        outputs.append(replace(row, validation=check))
    return replace(budget, outputs=tuple(outputs))


def with_indices(budget, interaction=0.0):
    """Give every source indices: its share first, `interaction` more in total."""
    outputs = []
    for row in budget.outputs:
        parts = []
        for part in row.contributions:
            if part.source != "interaction":
                first, total = part.share, part.share + interaction
                sobol = SobolIndex(
                    first=first,
                    first_interval=(first - 0.02, first + 0.02),
                    total=total,
                    total_interval=(total - 0.02, total + 0.02),
                    interacts=interaction > 0.0,
                    rank=1,
                )
                parts.append(replace(part, sobol=sobol))
        outputs.append(replace(row, contributions=tuple(parts)))
    return replace(budget, outputs=tuple(outputs))


def make_coupling(sizes=None):
    """Return what reaches what in the gyro; `sizes` are by (source, parameter)."""
    sizes = (
        {
            ("bias_repeatability", "bias"): 0.89,
            ("bias_stability", "scale_factor"): 0.0015,
            ("bias_stability", "mounting_angle"): 3.1e-5,
            ("bias_stability", "bias"): 0.44,
            ("angle_random_walk", "scale_factor"): 2e-7,
            ("angle_random_walk", "mounting_angle"): 5e-4,
            ("angle_random_walk", "bias"): 0.15,
            ("scale_factor_repeatability", "scale_factor"): 0.99999,
            ("mounting_repeatability", "mounting_angle"): 1.0,
        }
        if sizes is None
        else sizes
    )
    sources = list(dict.fromkeys(s for s, _ in sizes))
    groups = [parameter for parameter, _, _ in GYRO]
    return CouplingTable(
        # In another order than the figures have them.
        sources=tuple(Name(name, owner="gyro") for name in reversed(sources)),
        groups=tuple(Name(name, owner="gyro") for name in groups),
        cells=tuple(
            Coupling(
                source=Name(source, owner="gyro"),
                group=Name(group, owner="gyro"),
                u=sizes.get((source, group), 0.0),
                size=sizes.get((source, group), 0.0),
                reaches=sizes.get((source, group), 0.0) > 0.0,
            )
            for source in sources
            for group in groups
        ),
    )


def make_density(limit=0.1, mean=0.0):
    """Return a normal gyro bias of u = 0.05 deg/h in fine bins."""
    u = 0.05
    edges = mean + u * np.linspace(-4.5, 4.5, 121)
    middle = (edges[1:] + edges[:-1]) / 2.0
    density = np.exp(-0.5 * ((middle - mean) / u) ** 2)
    density /= (density * np.diff(edges)).sum()
    ends = (mean - 1.96 * u, mean + 1.96 * u)
    return ErrorDensity(
        output=Output(
            name=Name("bias", owner="gyro", axis="z"),
            unit="deg/h",
            si_per_unit=DEG_PER_HOUR,
            resolution=1e-20,
        ),
        trials=100_000,
        edges=edges * DEG_PER_HOUR,
        density=density / DEG_PER_HOUR,
        mean=mean * DEG_PER_HOUR,
        u=Known(u * DEG_PER_HOUR),
        interval=(ends[0] * DEG_PER_HOUR, ends[1] * DEG_PER_HOUR),
        interval_mc=(ends[0] * DEG_PER_HOUR, ends[1] * DEG_PER_HOUR),
        limit=None if limit is None else limit * DEG_PER_HOUR,
    )
