"""Budgets and documents made by hand, for the tests of the formats."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
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
from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Column,
    Document,
    Equation,
    Equations,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Picture,
    RowGroup,
    Run,
    Section,
    Sliders,
    Table,
)
from budget.report.figures.outputs import utilisation_chart
from budget.report.figures.rows import draw
from budget.report.figures.sources import share_chart
from budget.report.figures.style import to_svg
from budget.report.formulas import Math
from budget.report.tables import group_tables
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


DATE = "2026-01-31"
VERSION = "0.4"


def make_table(name="u", **changes):
    """Return a table with all kinds of columns, groups, bars and notes."""
    fields = {
        "caption": "Standard uncertainties of the gyro, source by source",
        "columns": (
            Column(head="source"),
            Column(head="u of the bias [deg/h]", kind="number"),
            Column(head="share of the variance [%]", kind="number"),
            Column(head="u", kind="number"),
            Column(head="unit", kind="unit"),
            Column(head="where it comes from", weight=2.0),
        ),
        "groups": (
            RowGroup(
                title="gyro bias",
                rows=(
                    row("bias repeatability", "0.050", "79", "0.05", "deg/h"),
                    row("bias stability", "0.026", "20", "0.04", "deg/h"),
                    row("angle random walk", "8.7e-3", "1", "0.005", "deg/sqrt(h)"),
                ),
            ),
            RowGroup(
                title="gyro scale factor",
                rows=(
                    row("scale factor repeatability", "120", "<0.1", "50", "ppm"),
                    row("mounting repeatability", "-2.3e-9", "0", "2.0", "arcsec"),
                ),
            ),
        ),
    }
    return Table(name=name, **(fields | changes))


def row(source, u, share, given, unit):
    """Return one row of that table."""
    bar = float(share) / 100.0 if share[0].isdigit() else None
    return (
        Cell(text=source, strong=share == "79"),
        Cell(text=u, exact=float(u)),
        Cell(text=share, exact=bar, share=bar),
        Cell(text=given, exact=float(given)),
        Cell(text=unit),
        Cell(text="table 2 <rev B>", note="at -40 to 71 degC"),
    )


@cache  # pictures are drawn once; what is made here nobody can change
def make_picture(place=2, name="shares-gyro-bias", **changes):
    """Return the share bars of one group, as the report draws them."""
    group = group_tables(make_budget())[place]
    chart = share_chart(group)
    fields = {
        "title": chart.title,
        "alt": chart.alt,
        "svg": to_svg(draw(chart), name=name),
        "caption": "Each bar is the whole variance of one output.",
    }
    return Picture(name=name, **(fields | changes))


@cache
def make_overview(name="limits"):
    """Return the dots of all outputs against their limits."""
    chart = utilisation_chart(make_assessment(make_budget()))
    return Picture(
        name=name,
        title=chart.title,
        alt=chart.alt,
        svg=to_svg(draw(chart), name=name),
        data=make_table("limits-data"),
        is_wide=True,
    )


def make_equations():
    """Return formulas with every kind of part."""
    sources = {
        "K_x = n_(x 2)/(4 pi m)": "(3)",
        "delta_(y z) = -n_(y 2)/n_(y 3)": "",
        "epsilon = macron(N)/K - (I + T^upright(T)) omega sin L": "(4)",
        "u^2 = 0.25 times g": "",
    }
    return Equations(
        equations=tuple(
            Equation(math=Math(source=source), number=number)
            for source, number in sources.items()
        )
    )


def first_page(overview):
    """Return the sections of page one."""
    return (
        Section(
            name="overview", title="Limits", on_first_page=True, blocks=(overview,)
        ),
        Section(
            name="contributions",
            title="The five largest contributions",
            on_first_page=True,
            blocks=(
                Listing(
                    numbered=True,
                    empty="Nothing varies.",
                    items=tuple(
                        (
                            Run(text=contribution, strong=True),
                            " contributes ",
                            Run(text="79 %", exact=0.7912345),
                            " of the gyro bias variance (alone u 0.050 deg/h).",
                        )
                        for contribution in (
                            "Gyro bias repeatability (0.05 deg/h)",
                            "Accelerometer bias repeatability (37 ug)",
                            "Gyro mounting repeatability (2 arcsec)",
                            "Accelerometer mounting repeatability (2 arcsec)",
                            "Gyro scale factor repeatability (50 ppm)",
                        )
                    ),
                ),
            ),
        ),
        Section(
            name="open",
            title="What is open",
            on_first_page=True,
            blocks=(
                Abreast(
                    columns=3,
                    blocks=(
                        Panel(
                            title="Not given",
                            blocks=(
                                Listing(
                                    empty="All is given.",
                                    items=(("Gyro rate random walk: it would grow.",),),
                                ),
                            ),
                        ),
                        Panel(
                            title="Assumptions",
                            blocks=(
                                Listing(
                                    empty="None.",
                                    items=(
                                        ("Gravity is that of WGS 84, 9.7966933 m/s^2",),
                                        ("2 arcsec is a largest value, uniform",),
                                    ),
                                ),
                            ),
                        ),
                        Panel(
                            title="Warnings",
                            blocks=(Listing(empty="None.", items=()),),
                        ),
                    ),
                ),
            ),
        ),
    )


def later_pages():
    """Return the sections after the contents."""
    long_rows = RowGroup(
        rows=tuple(
            row(f"source {k}", "0.050", str(k % 100), "0.05", "deg/h")
            for k in range(1, 90)
        )
    )
    return (
        Section(
            name="budget",
            title="Budget",
            blocks=(
                Paragraph(
                    words=(
                        "U95 is half the width of the 95 % interval, ",
                        Math(source="u_c"),
                        " the combined standard uncertainty of all sources.",
                    )
                ),
                Paragraph(
                    words=("Each line is what that source does alone.",), small=True
                ),
                make_table(),
                Abreast(
                    blocks=(
                        make_picture(0, "shares-scale", data=make_table("scale-data")),
                        make_picture(1, "shares-angle"),
                        make_picture(2, "shares-bias"),
                    )
                ),
            ),
        ),
        Section(
            name="what-if",
            title="What if",
            blocks=(Sliders(model=make_model(), table=make_table("what-if-table")),),
        ),
        Section(
            name="inputs",
            title="Inputs",
            blocks=(
                make_table(
                    "inputs-gyro",
                    groups=(long_rows,),
                    is_wide=True,
                    searchable=True,
                ),
            ),
        ),
        Section(
            name="method",
            title="Method",
            blocks=(
                Pairs(
                    rows=(
                        ("seed", ("0",)),
                        ("coverage", (Run(text="95 %", exact=0.95),)),
                        ("formula", ("the mean of ", Math(source="macron(N)"), ".")),
                    )
                ),
                Panel(title="Formulas, eq. (3) and (4)", blocks=(make_equations(),)),
                Table(
                    name="files",
                    caption="Every file that was read, with its hash",
                    columns=(
                        Column(head="input"),
                        Column(head="file"),
                        Column(head="SHA-256", kind="code"),
                    ),
                    groups=(
                        RowGroup(
                            rows=(
                                (
                                    Cell(text="device"),
                                    Cell(text="zhao-2019.yaml"),
                                    Cell(text=SHA),
                                ),
                            )
                        ),
                    ),
                ),
            ),
        ),
    )


def make_model():
    """Return what sliders compute from: one source, one output."""
    return {
        "coverage": 0.95,
        "most": 1e6,
        "sensors": [
            {
                "name": "gyro",
                "title": "gyro",
                "missing": [],
                "doubt": [1.0, 1.0],
                "verdict": "",
                "is_open": False,
                "conditions": [],
                "saturates": False,
            }
        ],
        "sources": [
            {
                "name": "gyro.bias_repeatability",
                "owner": "gyro",
                "quantity": "bias_repeatability",
                "title": "gyro bias repeatability",
                "u": 0.05,
                "unit": "deg/h",
                "printed": "0.05 deg/h",
                "decides": ["gyro", "mission"],
            },
            {
                "name": "gyro.bias_stability",
                "owner": "gyro",
                "quantity": "bias_stability",
                "title": "gyro bias stability",
                "u": 0.04,
                "unit": "deg/h",
                "printed": "0.04 deg/h",
                "decides": ["gyro", "mission"],
            },
        ],
        "outputs": [
            {
                "name": "gyro.bias.x",
                "sensor": "gyro",
                "lower_bound": False,
                "title": "gyro bias x",
                "group": "gyro bias",
                "axis": "x",
                "unit": "deg/h",
                "value": 0.0,
                "factor": 1.959963984540054,
                "shift": 0.0,
                "is_timed": False,
                "length": None,
                "limit": 0.15,
                "resolution": 1e-12,
                "added": [0.0, 0.0, 0.0],
            }
        ],
        "mean": [[0.001], [0.0]],
        "first": [[0.0025], [0.0016]],
        "second": [[1e-6], [0.0]],
        "pairs": [
            {
                "sources": ["gyro.bias_repeatability", "gyro.bias_stability"],
                "variance": [2e-6],
            }
        ],
    }


def make_document(**changes):
    """Return a document with every kind of block."""
    fields = {
        "kind": "report",
        "title": "Zhao 2019 optical IMU",
        "facts": ("procedure Zhao 2019", "latitude 34.2394 deg"),
        "headline": "FAILS tactical grade",
        "summary": (
            Run(text="3 of 24", strong=True),
            " required outputs exceed their limits, most of all gyro bias z: ",
            Run(text="U95 0.12 deg/h", exact=0.1234567),
            ", limit 0.1 deg/h. Errors are counted from the nominal values.",
        ),
        "cards": (
            Card(
                title="Gyro: FAILS",
                lines=(
                    ("Worst output: gyro bias z, ", Run(text="123 %", exact=1.2345)),
                    ("Because: bias repeatability 79 %, stability 20 %, rest 1 %",),
                ),
            ),
            Card(
                title="Accelerometer: MEETS",
                lines=(
                    ("Worst output: accelerometer bias z, 90 % of the limit",),
                    ("Because: bias repeatability 82 %, rest 18 %",),
                ),
            ),
        ),
        "sections": (*first_page(make_overview()), *later_pages()),
        "json": json.dumps({"schema": "budget/1", "text": "</script><b>"}),
        "date": DATE,
        "version": VERSION,
    }
    return Document(**(fields | changes))
