"""Method section of a report: settings, formulas, references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import scheme_of
from budget.language import say, term, words
from budget.model.norm import NormScheme
from budget.model.response import STATISTICS
from budget.model.rotation import RotationScheme
from budget.model.sources import BAND, FLICKER
from budget.names import AXES, by_group, parameters_of
from budget.report.blocks import (
    Cell,
    Equation,
    Equations,
    Field,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Section,
    table_of,
)
from budget.report.formulas import Math, with_math
from budget.report.tables import print_count, print_coverage, print_given
from budget.report.wording import (
    BY_LAW,
    INTERVALS,
    METHODS,
    error_reference,
    points,
)
from budget.studies.request import sensors_of

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator
    from collections.abc import Set as AbstractSet

    from budget.arrays import Array
    from budget.inputs.records import Device, Procedure
    from budget.model.scheme import Scheme
    from budget.report.blocks import Block, Table, Words
    from budget.results import Settings

    # A row of the weights: its axis, window, mean input, weights.
    Record = tuple[str, str, Array, Array]

PAPER = term(
    "X. Zhao, L. Zhang, S. Li, Metrology & Measurement Technology 39 (3), 2019, 34-40, "
    "doi 10.11823/j.issn.1674-5795.2019.03.06"
)
REFERENCE_LIST: tuple[str, ...] = (
    "Zhao 2019: {paper}",
    term("JCGM 100:2008, Guide to the expression of uncertainty in measurement (GUM)"),
    (
        term(
            "JCGM 101:2008, Supplement 1 to the GUM: propagation of distributions by a "
            "Monte Carlo method"
        )
    ),
    term("JCGM 102:2011, Supplement 2 to the GUM: any number of output quantities"),
    term("IEEE Std 528-2019, Standard for Inertial Sensor Terminology"),
    term(
        "NIMA TR8350.2, Department of Defense World Geodetic System 1984, third edition"
    ),
)
SOBOL_REFERENCE = term("SALib: estimators of Sobol' indices after Saltelli et al. 2010")

# Axis and the turn that scales it; angle, sign, and pulse differences: eq. (3).
TURN_SCALES = (("x", "2"), ("y", "3"), ("z", "1"))
TURN_ANGLES = (
    ("x y", "-", "x 1", "x 2"),
    ("x z", "", "x 3", "x 2"),
    ("y x", "", "y 1", "y 3"),
    ("y z", "-", "y 2", "y 3"),
    ("z x", "-", "z 3", "z 1"),
    ("z y", "", "z 2", "z 1"),
)
# Axis and its face up; angle, sign, and the face up that shows it: eq. (5).
FACE_SCALES = (("x", 3), ("y", 5), ("z", 1))
FACE_ANGLES = (
    ("x y", "-", 1),
    ("x z", "", 5),
    ("y x", "", 1),
    ("y z", "-", 3),
    ("z x", "-", 5),
    ("z y", "", 3),
)
NOTATION = term(
    "After {paper}, its misprints mended. $K$ is a scale factor, $delta$ a mounting "
    "angle, $Delta T$ the matrix of them in its eq. (1), $epsilon$ and $nabla$ the "
    "bias of gyro and accelerometer, $I$ the unit matrix, $g$ gravity."
)
CORRECTED = "macron(N)/K - (I + Delta T) macron(omega)"
PRINTED = "(I + Delta T^upright(T)) macron(N)/K - macron(omega)"
BIAS_LETTERS = term(
    "$macron(N)$ is the mean number of pulses a second over the azimuths, "
    "$macron(omega)$ the mean earth rate there in body axes, (0, 0, "
    "$omega sin phi$) at latitude $phi$ where they balance. "
)
HELD = term(
    "A limit is on the absolute error: what is held against it is the larger of the "
    "two ends, without its sign."
)
PLUS_MINUS = "\N{PLUS-MINUS SIGN}"
LETTERS = {"sigma": "\u03c3", "tau": "\u03c4", "pi": "\u03c0"}
# Lines of a data sheet; variance of the average over a window, and what it is of.
NOISE = (
    (
        {"angle_random_walk", "velocity_random_walk", BAND},
        "N^2/L",
        term("white, density N"),
    ),
    (
        {"sample_noise"},
        "sigma^2/(f L)",
        term("white per sample, {sigma} at rate f"),
    ),
    (
        {"bias_stability"},
        "2 sigma^2 (tau/L)^2 (L/tau - 1 + e^(-L\\/tau))",
        term("first-order Gauss-Markov, {sigma} and correlation time {tau}"),
    ),
    (
        {"rate_random_walk", "acceleration_random_walk"},
        "K^2 (s + L/3)",
        term("random walk K from t = 0"),
    ),
    (
        {FLICKER},
        'B^2/pi ((x sin x + 1 - cos x)\\/x^2 - "Ci"(x))',
        term("flicker, coefficient B, without power below f: x = 2{pi}f L"),
    ),
    (
        {"quantization"},
        "q^2/(6 L^2)",
        term("rounding of the integral to steps q"),
    ),
)


@dataclass(frozen=True, kw_only=True)
class Trials:
    """Trials of Monte Carlo beside those of the method itself."""

    check: int  # of the law; 0 where it was not checked
    densities: int  # 0 where none is drawn


def method_section(
    settings: Settings,
    procedure: Procedure,
    devices: Collection[Device],
    sensors: Collection[str],
    trials: Trials,
    *,
    of_verdict: Settings,
) -> Section:
    """Return settings, formulas and references; of the sensors that are there."""
    panels: list[Block] = [
        Pairs(rows=_settings_rows(settings, trials, of_verdict)),
        Paragraph(words=with_math(say(NOTATION, paper=say(PAPER)))),
    ]
    if procedure.formulas in {"least_squares", "weighted", "norm"}:
        panels += _estimator_panels(procedure, devices)
    else:
        if "gyro" in sensors:
            panels += [_turns_panel(), _gyro_bias_panel(procedure)]
        if "accelerometer" in sensors:
            panels.append(_accelerometer_panel())
    lines = {  # of other forms the formulas are not these
        line.name if not line.form else line.form
        for device in devices
        for sensor in device.sensors
        for line in sensor.lines
    }
    panels += [_law_panel(), _coverage_panel(settings), *_noise_panels(lines)]
    references = REFERENCE_LIST
    if settings.sobol_samples is not None:
        panels.append(_indices_panel())
        references += (SOBOL_REFERENCE,)
    panels.append(
        Panel(
            title=say("References"),
            blocks=(
                Listing(
                    items=points(say(one, paper=say(PAPER)) for one in references),
                    empty=say("None."),
                ),
            ),
        )
    )
    return Section(name="method", title=say("Method"), blocks=tuple(panels))


def _settings_rows(
    settings: Settings, trials: Trials, of_verdict: Settings
) -> tuple[tuple[str, Words], ...]:
    """Return what the result depends on besides the files."""
    kind = say(BY_LAW if settings.method == "gum" else INTERVALS[settings.interval])
    rows: list[tuple[str, str]] = [
        (
            say("method"),
            say(
                "{method}: {methods}",
                method=settings.method,
                methods=say(METHODS[settings.method]),
            ),
        ),
        (say("trials"), _trials_words(settings, trials)),
        (say("seed"), str(settings.seed)),
        (say("coverage"), f"{print_coverage(settings.coverage)} %"),
        (
            say("interval"),
            say("{interval}: {kind}", interval=say(settings.interval), kind=kind),
        ),
        *(
            (
                head,
                say(
                    "{reference}: {error_references}",
                    reference=words(own.reference),
                    error_references=error_reference(own),
                ),
            )
            for head, own in {
                error_reference(of_verdict): (say("error reference"), of_verdict),
                error_reference(settings): (
                    say("error reference")
                    if error_reference(of_verdict) == error_reference(settings)
                    else say("error reference of the test alone"),
                    settings,
                ),
            }.values()
        ),
    ]
    if settings.sobol_samples is not None:
        points_text = print_count(settings.sobol_samples)
        rows.append(
            (
                say("Sobol' indices"),
                say(
                    "{sobol_scrambles} scrambles of {points_text} points",
                    sobol_scrambles=settings.sobol_scrambles,
                    points_text=points_text,
                ),
            )
        )
    if settings.only:
        only = say(", ").join(settings.only)
        rows.append(
            (
                say("only"),
                say("{only}; all other lines are set to zero in this run", only=only),
            )
        )
    if settings.outputs:
        rows.append((say("outputs"), say(", ").join(by_group(settings.outputs))))
    return tuple((head, (text,)) for head, text in rows)


def _trials_words(settings: Settings, trials: Trials) -> str:
    """Say how many trials there were, and what for."""
    parts = []
    if settings.trials is not None:
        each = settings.normals_per_trial
        numbers = "" if each is None else say(", {each} random numbers each", each=each)
        parts.append(
            say(
                "{trials} for the budget{numbers}",
                trials=print_count(settings.trials),
                numbers=numbers,
            )
        )
    if trials.check:
        sure = (
            say("one digit")
            if settings.digits == 1
            else say("{digits} digits", digits=settings.digits)
        )
        count = print_count(trials.check)
        parts.append(
            say(
                "{count} to check the law, to {sure} of u",
                count=count,
                sure=sure,
            )
        )
    if trials.densities:
        parts.append(
            say(
                "{densities} for the distributions",
                densities=print_count(trials.densities),
            )
        )
    return say("; ").join(parts) or say("none")


def _formulas(
    title: str, text: str, equations: Iterable[str | tuple[str, str]]
) -> Panel:
    """Return formulas, some with what they are of, under what their letters mean."""
    pairs = [(one, "") if isinstance(one, str) else one for one in equations]
    return Panel(
        title=title,
        blocks=(
            Paragraph(words=with_math(text), small=True),
            Equations(
                equations=tuple(
                    Equation(math=Math(source=source), number=note)
                    for source, note in pairs
                )
            ),
        ),
    )


def _estimator_panels(
    procedure: Procedure, devices: Collection[Device]
) -> Iterator[Panel]:
    """Yield the estimator, and the weights that it gave each triad."""
    sensors = sensors_of(tuple(devices), procedure)
    schemes = {one.kind: scheme_of(one.kind, procedure, one) for one in sensors}
    if procedure.formulas == "norm":
        yield _norm_panel()
        if "gyro" in schemes:
            yield _rotation_panel()
    else:
        yield _least_squares_panel(procedure)
    for kind, scheme in schemes.items():
        yield Panel(
            title=say("Weights of the {kind}", kind=kind),
            blocks=(_weights_table(scheme),),
        )


def _norm_panel() -> Panel:
    """Return the estimator of dwells at unknown attitudes."""
    return _formulas(
        say("Estimator: norm of gravity"),
        say(
            "$macron(n)_w$ are the mean counts a second of the three axes in "
            "dwell w, $hat(K)$, $Delta hat(T)$, $hat(b)$ what is looked for. The "
            "attitudes of the dwells are not used; the weights $W$ are those of "
            "least squares at the nominal ones, where $J$ is the sensitivity of F "
            "to the parameters. How the triad as a whole is turned no norm shows: "
            "three angles are held."
        ),
        [
            "g_w = norm((I + Delta hat(T))^(-1) (hat(K)^(-1) macron(n)_w - hat(b)))",
            "F_w = g_w^2 - g^2",
            "sum_w W_w F_w = 0",
            "W = (J^upright(T) J)^(-1) J^upright(T)",
        ],
    )


def _rotation_panel() -> Panel:
    """Return the estimator of a gyro that is turned between such dwells."""
    return _formulas(
        say("Estimator: rotation between the dwells"),
        say(
            "$hat(omega)_w$ is the mean rate that the calibrated gyro shows in a "
            "dwell or in a step w of a turn, of length L, less the earth rate at "
            "the nominal attitude; $hat(s)_k$ is what the calibrated "
            "accelerometers show in dwell k. Steps are of 15 deg at the most. The "
            "weights $W$ are those of least squares at the nominal attitudes. The "
            "tables below give them for the parts of F along body x, y and z."
        ),
        [
            (
                "hat(omega)_w = (I + Delta hat(T))^(-1) "
                "(hat(K)^(-1) macron(n)_w - hat(b)) - R_w^upright(T) omega_upright(e)"
            ),
            (
                "F_(k, k+1) = hat(s)_(k+1)/g - "
                "product_w exp(-[hat(omega)_w L_w]_times) hat(s)_k/g"
            ),
            "F_w = hat(omega)_w L_w",
            "sum W F = 0",
        ],
    )


def _least_squares_panel(procedure: Procedure) -> Panel:
    """Return the estimator of windows at known attitudes."""
    weighted = procedure.formulas == "weighted"
    inverse = "(A^upright(T) C^(-1) A)^(-1) A^upright(T) C^(-1)"
    return _formulas(
        say("Estimator: least squares") + (say(", weighted") if weighted else ""),
        say(
            "$A$ has a row for each window: its mean input $u$ in body axes, and 1. "
            "$macron(n)_i$ are the mean counts a second of axis i in the windows; the "
            "weights are unbiased, $W A = I$."
        )
        + (
            say(
                " $C$ is the covariance of the window averages by the device's "
                "noise, station and environment."
            )
            if weighted
            else ""
        )
        + (
            say(
                " A parameter that is held has no column of its own: at its "
                "nominal value it is part of that of the own axis, and its row of "
                "$W$ is 0."
            )
            if procedure.held
            else ""
        )
        + (
            say(
                " The orders that are estimated besides have columns of the own "
                "input to that power."
            )
            if procedure.orders
            else ""
        ),
        [
            f"W = {inverse if weighted else '(A^upright(T) A)^(-1) A^upright(T)'}",
            "(K_i (I + Delta T)_i, K_i b_i) = W macron(n)_i",
        ],
    )


def _weights_table(scheme: Scheme) -> Table:
    """Return W, a row for each window; of each axis where they differ."""
    unit = "rad/s" if scheme.owner == "gyro" else "m/s^2"
    inputs = scheme.turn + scheme.standing
    names = [window.name for window in scheme.schedule.windows]
    parts = list(zip(names, inputs, strict=True))
    first = f"u {{}} [{unit}]"
    if isinstance(scheme, RotationScheme):
        parts, first = scheme.parts, say("turned {} [rad]")
    heads, groups = _weights(scheme, unit)
    digits = 5 if len(heads) == STATISTICS else 3
    records = [
        (title, name, input_, W[:, k])
        for title, W in groups
        for k, (name, input_) in enumerate(parts)
    ]

    def number(head: str, part: int, place: int) -> Field[Record]:
        def cell(record: Record) -> Cell:
            value = float((record[2], record[3])[part][place])
            return Cell(text=print_given(value, digits=digits), exact=value)

        return Field(head=head, kind="number", cell=cell)

    fields: list[Field[Record]] = [
        Field(head=say("window"), cell=lambda record: record[1])
    ]
    for k, axis in enumerate(AXES):
        fields.append(number(first.format(axis), 0, k))
    fields += [number(head, 1, k) for k, head in enumerate(heads)]
    return table_of(
        records,
        fields,
        name=f"weights-{scheme.owner}",
        caption=say(
            "Mean inputs and weights of the windows of the {owner}",
            owner=say(scheme.owner),
        ),
        by=lambda record: record[0],
        titled=True,
        is_wide=True,
        searchable=True,
    )


def _weights(scheme: Scheme, unit: str) -> tuple[list[str], list[tuple[str, Array]]]:
    """Return what rows of W are called, and W by what it is of, shape (m, n)."""
    if isinstance(scheme, RotationScheme):
        names = [parameters_of(scheme.owner)[k] for k in scheme.held.estimated]
        heads = [
            f"W {words(name.quantity)} {name.axis}"
            + (" [1/s]" if name.quantity == "bias" else "")
            for name in names
        ]
        W = scheme.inverse[scheme.held.estimated]
        return heads, [
            (say("part {axis}", axis=axis), W[:, k::3]) for k, axis in enumerate(AXES)
        ]
    if isinstance(scheme, NormScheme):
        names = [parameters_of(scheme.owner)[k] for k in scheme.held.estimated]
        heads = [
            say(
                "W {quantity} {axis} [1/({unit}){power}]",
                quantity=words(name.quantity),
                axis=name.axis,
                unit=unit,
                power=power,
            )
            for name in names
            for power in ["" if name.quantity == "bias" else "^2"]
        ]
        return heads, [("", scheme.norm_weights)]
    W = scheme.weights
    heads = [
        *(say("W {axis} [1/({unit})]", axis=axis, unit=unit) for axis in AXES),
        say("W bias"),
        *(
            say("W K{order} [1/({unit})^{order}]", order=order, unit=unit)
            for order in scheme.orders
        ),
    ]
    if np.array_equal(W[0], W[1]) and np.array_equal(W[0], W[2]):
        return heads, [("", W[0])]
    return heads, [(say("axis {axis}", axis=axis), W[k]) for k, axis in enumerate(AXES)]


def _turns_panel() -> Panel:
    """Return the gyro's scale factors and mounting angles: Zhao 2019, eq. (3)."""
    return _formulas(
        say("Gyro scale factors and mounting angles, eq. (3)"),
        say(
            "$n_(i j)$: pulses of axis i over m turns forward minus those back, about "
            "z (j = 1), x (2), y (3). The paper prints $delta_(y x)$ with a minus, "
            "against its eq. (1)."
        ),
        [
            *(f"K_{axis} = n_({axis} {turn})/(4 pi m)" for axis, turn in TURN_SCALES),
            *(
                f"delta_({angle}) = {sign}n_({top})/n_({bottom})"
                for angle, sign, top, bottom in TURN_ANGLES
            ),
        ],
    )


def _gyro_bias_panel(procedure: Procedure) -> Panel:
    """Return the gyro's bias: Zhao 2019, eq. (4) as printed, or corrected; or else."""
    if not procedure.gyro.azimuths:
        return _formulas(
            say("Gyro bias, of twelve positions"),
            say(
                "$N_i (j)$: mean number of pulses a second of axis i over the two "
                "dwells with that axis up and down. The earth rate drops out."
            ),
            ['epsilon_i = (N_i ("up") + N_i ("down"))/(2 K_i)'],
        )
    if procedure.formulas == "paper":
        return _formulas(
            say("Gyro bias, eq. (4) as printed"),
            say(
                "{bias_letters}This is exact only without mounting angles; "
                "the corrected formula is $epsilon = {corrected}$.",
                bias_letters=say(BIAS_LETTERS),
                corrected=CORRECTED,
            ),
            [f"epsilon = {PRINTED}"],
        )
    return _formulas(
        say("Gyro bias, corrected from eq. (4)"),
        say(
            "{bias_letters}The paper prints ${printed}$, which does "
            "not invert its eq. (1) where there are mounting angles.",
            bias_letters=say(BIAS_LETTERS),
            printed=PRINTED,
        ),
        [f"epsilon = {CORRECTED}"],
    )


def _accelerometer_panel() -> Panel:
    """Return the accelerometer's parameters: Zhao 2019, eq. (5)."""

    def faces(axis: str, face: int, sign: str) -> str:
        return f"(N_{axis} ({face}) {sign} N_{axis} ({face + 1}))"

    return _formulas(
        say("Accelerometer, eq. (5)"),
        say(
            "$N_i (j)$: mean number of pulses a second of axis i over the two "
            "dwells with z up (j = 1), z down (2), x up (3), x down (4), y up "
            "(5), y down (6). The paper prints $delta_(y z)$ with the counts of "
            "x, and $delta_(x y)$ twice; the second is $delta_(x z)$."
        ),
        [
            *(
                f"K_{axis} = {faces(axis, face, '-')}/(2 g)"
                for axis, face in FACE_SCALES
            ),
            *(
                f"delta_({angle}) = {sign}{faces(angle[0], face, '-')}"
                f"/(2 g K_{angle[0]})"
                for angle, sign, face in FACE_ANGLES
            ),
            *(
                f"nabla_{axis} = {faces(axis, face, '+')}/(2 K_{axis})"
                for axis, face in FACE_SCALES
            ),
        ],
    )


def _law_panel() -> Panel:
    """Return the law of propagation to second order, JCGM 100, 5.1.2."""
    return _formulas(
        say("Law of propagation"),
        say(
            "$c$: sensitivities, $H$: second derivatives of an output at the "
            "nominal point, $U_x$: covariance of the inputs; an input that is not "
            "normal adds its fourth moment. JCGM 100:2008, eq. (13) and the note "
            "to 5.1.2, without the third derivatives of that note."
        ),
        [
            "E(y) - y(x) = 1/2 tr(H U_x)",
            '"cov"(y_k, y_l) = c_k^upright(T) U_x c_l + 1/2 tr(H_k U_x H_l U_x)',
        ],
    )


def _coverage_panel(settings: Settings) -> Panel:
    """Return the coverage interval of the method."""
    percent = print_coverage(settings.coverage)
    if settings.method == "gum":
        return _formulas(
            say("Coverage"),
            say(
                "The interval is mean {plus_minus} U, with k of the normal "
                "law for {percent} %, JCGM 100:2008, G.1.3. {held}",
                plus_minus=PLUS_MINUS,
                percent=percent,
                held=say(HELD),
            ),
            ["U = k u"],
        )
    text = say(
        "The interval contains {percent} % of the trials, JCGM 101:2008, 7.7. {held}",
        percent=percent,
        held=say(HELD),
    )
    return Panel(title=say("Coverage"), blocks=(Paragraph(words=(text,), small=True),))


def _noise_panels(lines: AbstractSet[str]) -> list[Panel]:
    """Return the variance of a window average of every process that is given."""
    found = [
        (f"u_L^2 = {variance}", say(note, **LETTERS))
        for names, variance, note in NOISE
        if names & lines
    ]
    if not found:
        return []
    text = say(
        "The noise of a window enters as its average, a Gaussian quantity with a "
        "variance in closed form; averages of one process over several windows are "
        "correlated accordingly. $L$ is the length of a window, $s$ its start."
    )
    return [_formulas(say("Noise averaged over a window"), text, found)]


def _indices_panel() -> Panel:
    """Return first-order and total index."""
    return _formulas(
        say("Sobol' indices"),
        say(
            "Part of the variance that the source $i$ contributes alone, and with "
            "all its products."
        ),
        ["S_i = V(E(y | x_i))/V(y)", "S_(upright(T) i) = E(V(y | x_(tilde i)))/V(y)"],
    )
