"""Table 1, all 60 entries: which reading of 'relative error' they fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.model.sources import GYRO
from budget.names import Name
from budget.spec.records import ANGLES, AXES
from budget.studies.paper.conditions import (
    PLACES,
    Expectation,
    expect,
    nominal_size,
    only_sources,
)
from budget.studies.paper.findings import (
    AGREES,
    EXPLAINED,
    FITS_MEAN,
    FITS_SINGLE,
    READING,
    U_MEAN,
    U_SINGLE,
    UNEXPLAINED,
    Finding,
    ratio_of,
    say,
)
from budget.studies.paper.mounting import SOURCE as MOUNTING
from budget.studies.paper.printed import RUNS, TABLE_1
from budget.studies.paper.readings import (
    LEFT_ON,
    SIX_DIGITS,
    best_reading,
    fitting_choices,
)
from budget.studies.paper.statistics import (
    Fit,
    fit,
    repeats,
    spread_of_means,
    two_sided,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.printed import PrintedRow
    from budget.studies.paper.readings import Reading

HALF_ULP = 2.0**-53  # spacing of doubles just below 1 [1]
STABILITY, WALK = (
    Name("bias_stability", owner=GYRO),
    Name("angle_random_walk", owner=GYRO),
)
REPEATABILITIES = (
    Name("bias_repeatability", owner=GYRO),
    Name("scale_factor_repeatability", owner=GYRO),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Row:
    """One row of Table 1 with what it should be.

    Attributes
    ----------
    row : PrintedRow
    printed : ndarray, shape (12,)
        Its entries as numbers [1].
    expectation : Expectation
        Of one run under the paper's conditions.
    drawn : ndarray, shape (12,)
        Spread of means over 25 runs, drawn again and again [1].
    """

    row: PrintedRow
    printed: Array
    expectation: Expectation
    drawn: Array

    def is_random(self, parameter: str) -> bool:
        """Whether the entries of that parameter vary from run to run."""
        return bool(self.expectation.u[PLACES[parameter]].all())

    def fit(self, parameter: str, *, runs: int) -> Fit:
        """Hold the random entries of one parameter against a reading."""
        return fit(self.printed, self.expectation, PLACES[parameter], runs=runs)

    def fit_all(self, *, runs: int) -> Fit:
        """Hold all random entries of the row against a reading, jointly."""
        places = self.expectation.u > 0.0
        return fit(self.printed, self.expectation, places, runs=runs, scatter=False)


def compute_rows(conditions: Conditions) -> tuple[Row, ...]:
    """Compute what each row should be: formulas of the paper, reference nominal."""
    size = nominal_size(conditions.gyro)
    rows = []
    for row in TABLE_1:
        problem = only_sources(conditions.gyro, conditions.printed, row.source)
        rows.append(
            Row(
                row=row,
                printed=np.array([float(text) for text in row.entries]),
                expectation=expect(problem, size),
                drawn=spread_of_means(problem, runs=RUNS) / size,
            )
        )
    return tuple(rows)


def table1_findings(
    rows: tuple[Row, ...],
    readings: tuple[Reading, ...],
    choices: dict[tuple[Name, ...], Expectation],
) -> tuple[Finding, ...]:
    """Return, for each row, a summary of every random parameter and all 12 entries.

    Parameters
    ----------
    rows : tuple of Row
    readings : tuple of Reading
    choices : dict
        What every choice of the stated sources gives, from readings.switched_on.

    Returns
    -------
    tuple of Finding
    """
    findings = []
    for row in rows:
        other = best_reading(readings, row.row.source)
        for parameter in PLACES:
            if row.is_random(parameter):
                summary = _summarize(row, parameter, other)
                findings += [summary, *_random_entries(row, parameter, summary)]
            else:
                findings += _fixed_entries(row, parameter)
        if row.row.source == STABILITY:
            findings.append(_left_on(rows, readings, choices))
    return (*findings, _both_repeatabilities(rows))


def entry_names(parameter: str) -> tuple[str, ...]:
    """Name the entries of one parameter: axes or angles."""
    return ANGLES if parameter == "mounting_angle" else AXES


def _summarize(row: Row, parameter: str, other: Reading | None) -> Finding:
    """Say which reading the entries of one parameter fit together."""
    single, mean = row.fit(parameter, runs=1), row.fit(parameter, runs=RUNS)
    rms = float(np.sqrt(np.mean(row.printed[PLACES[parameter]] ** 2)))
    chosen, quantity, verdict = single, U_SINGLE, UNEXPLAINED
    if mean.fits and mean.p > single.p:
        chosen, quantity, verdict = mean, U_MEAN, FITS_MEAN
    elif single.fits:
        verdict = FITS_SINGLE
    elif other is not None:
        # The biases of that row prove the reading of its angles: mounting.py.
        verdict = EXPLAINED if row.row.source == MOUNTING else READING
    place = PLACES[parameter]
    drawn = np.mean(row.drawn[place] / (row.expectation.u[place] / np.sqrt(RUNS)))
    why = (
        f"chi-square for {single.entries} entries: {say(single.chi_square, 3)} as a "
        f"single run, {say(mean.chi_square, 3)} as a mean over {RUNS}; u single "
        f"{say(single.u_rms)}, mean {say(mean.u_rms)} ({repeats(RUNS)} means drawn "
        f"spread by {drawn:.3f} of it)"
    )
    if verdict in {READING, EXPLAINED} and other is not None:
        p = other.fit(row.printed, parameter).p
        why += f"; fits if read so: {other.full_name} (p {say(p, 2)})"
    if verdict == EXPLAINED:
        why += "; its biases prove it, see below"
    return Finding(
        section="table 1",
        where=f"Table 1, {_title(row)}, {_words(parameter)}, all {single.entries}",
        printed=f"rms {say(rms, 3)}",
        ours=chosen.u_rms,
        quantity=quantity,
        ratio=ratio_of(chosen.u_rms, rms),
        verdict=verdict,
        why=why,
        p_single=single.p,
        p_mean=mean.p,
        is_summary=True,
    )


def _random_entries(row: Row, parameter: str, summary: Finding) -> list[Finding]:
    """Return the single entries, with the verdict that they have together."""
    place = PLACES[parameter]
    single, mean = row.fit(parameter, runs=1), row.fit(parameter, runs=RUNS)
    texts = row.row.entries[place]
    u = row.expectation.u[place]
    if summary.quantity == U_MEAN:
        u = u / np.sqrt(RUNS)
    return [
        Finding(
            section="table 1",
            where=f"Table 1, {_title(row)}, {_words(parameter)} {name}",
            printed=text,
            ours=float(u[k]),
            quantity=summary.quantity,
            ratio=ratio_of(float(u[k]), float(text)),
            verdict=summary.verdict,
            why="judged with its neighbours, in the row above",
            p_single=float(single.p_entries[k]),
            p_mean=float(mean.p_entries[k]),
        )
        for k, (name, text) in enumerate(
            zip(entry_names(parameter), texts, strict=True)
        )
    ]


def _fixed_entries(row: Row, parameter: str) -> list[Finding]:
    """Return entries that do not vary: zeros to rounding, and eq. (4)'s residual."""
    place = PLACES[parameter]
    findings = []
    for name, text, ours, zero in zip(
        entry_names(parameter),
        row.row.entries[place],
        row.expectation.mean[place].tolist(),
        row.expectation.resolution[place].tolist(),
        strict=True,
    ):
        printed = float(text)
        ratio = None
        if abs(ours) <= zero:
            agrees, why = abs(printed) <= zero, "exactly zero"
            if printed:
                why = (
                    f"rounding: {round(abs(printed) / HALF_ULP)} times 2^-53, the "
                    "spacing of doubles below 1, left by calibrated over nominal - 1"
                )
        else:
            ratio = ratio_of(ours, printed)
            agrees = abs(ours / printed - 1.0) <= SIX_DIGITS
            why = (
                "eq. (4)'s own error (dT + dT^T) w + dT^T b + dT^T dT w, no rounding; "
                f"to six digits: ours/printed - 1 = {say(ours / printed - 1.0, 2)}"
            )
        findings.append(
            Finding(
                section="table 1",
                where=f"Table 1, {_title(row)}, {_words(parameter)} {name}",
                printed=text,
                ours=0.0 if abs(ours) <= zero else ours,
                ratio=ratio,
                verdict=AGREES if agrees else UNEXPLAINED,
                why=why,
            )
        )
    return findings


def _both_repeatabilities(rows: tuple[Row, ...]) -> Finding:
    """Judge the two repeatability rows together: only so a single run is excluded."""
    chosen = [row for row in rows if row.row.source in REPEATABILITIES]

    def together(runs: int) -> tuple[float, float]:
        fits = [row.fit_all(runs=runs) for row in chosen]
        chi_square = sum(one.chi_square for one in fits)
        n = sum(one.entries for one in fits)
        return chi_square, two_sided(chi_square, n)

    single, p_single = together(1)
    mean, p_mean = together(RUNS)
    # Printed over u: each row has three random entries with independent axes.
    rms = float(np.sqrt(single / 6.0))
    return Finding(
        section="table 1",
        where="Table 1, bias and scale factor repeatability, their 6 random entries",
        printed=f"rms {say(rms, 3)} of u, single run",
        ours=1.0 / np.sqrt(RUNS),
        quantity=U_MEAN,
        ratio=float(1.0 / np.sqrt(RUNS) / rms),
        verdict=FITS_MEAN if p_mean > p_single else FITS_SINGLE,
        why=f"chi-square for 6 entries: {say(single)} as a single run, {say(mean)} as "
        f"a mean over {RUNS}",
        p_single=p_single,
        p_mean=p_mean,
        is_summary=True,
    )


def _left_on(
    rows: tuple[Row, ...],
    readings: tuple[Reading, ...],
    choices: dict[tuple[Name, ...], Expectation],
) -> Finding:
    """Judge the stability row as a run whose random walk was left on, and the choice.

    No number is fitted, but a reading was looked for: how many were tried, how many
    of them fit, and how often one fits by chance, shown by the other rows, is said.
    """
    row, walk = (
        next(r for r in rows if r.row.source == source) for source in (STABILITY, WALK)
    )
    single, mean = (r for r in readings if r.name == LEFT_ON)
    of_single, of_mean = single.fit(row.printed), mean.fit(row.printed)
    found = {r.row.source: fitting_choices(choices, r.row.source) for r in rows}
    fitting = dict(found[STABILITY])
    if any(WALK not in chosen or r.runs != 1 for chosen, r in fitting.items()):
        raise ValueError(
            "a run without the random walk fits: the reason given is wrong"
        )
    elsewhere = sum(
        chosen != (source,)
        for source, fits in found.items()
        for chosen, _ in fits
        if source != STABILITY
    )
    tried = 2 * len(choices)
    others = sum(r.source == STABILITY and "turns" in r.name for r in readings)
    alone, norm = fitting[WALK,], np.linalg.norm
    # Of ratios of normal densities the powers of 2 pi cancel.
    odds = np.exp(_log_density(alone, row.printed) - _log_density(single, row.printed))
    times = [
        f"{norm(walk.expectation.u[place]) / norm(walk.printed[place]):.0f}"
        for place in PLACES.values()
    ]
    rms = float(np.sqrt(of_single.chi_square / of_single.entries))
    return Finding(
        section="table 1",
        where="Table 1, bias stability, one run with the random walk left on",
        printed=f"rms {say(rms, 3)} of u, single run",
        ours=1.0,
        quantity=U_SINGLE,
        ratio=1.0 / rms,
        verdict=READING,
        why=f"chi-square {say(of_single.chi_square, 3)} for {of_single.entries} "
        f"entries, as stated {say(row.fit_all(runs=1).chi_square, 3)}; no free "
        f"parameter. Looked for among {tried + others} readings: every choice of the "
        f"five stated sources ({len(choices)}) and turns far apart, each as one run "
        f"and as a mean over {RUNS}. {len(fitting)} fit, all single runs with the "
        f"random walk; it alone fits as well (p {say(alone.fit(row.printed).p)}, "
        f"{say(float(odds))} times as likely), so that the row does not show whether "
        f"the stability was on. By chance {elsewhere} of "
        f"{(len(rows) - 1) * (tried - 2)} wrong choices fit another row. Against it: "
        f"the random walk's own row prints {', '.join(times)} times less",
        p_single=of_single.p,
        p_mean=of_mean.p,
        is_summary=True,
    )


def _log_density(reading: Reading, printed: Array) -> float:
    """Return the logarithm of the normal density of twelve entries, less a constant."""
    u = reading.expectation.u
    # Scaled first: scale factors and angles differ by a factor of 1e5.
    _, log_det = np.linalg.slogdet(reading.expectation.covariance / np.outer(u, u))
    chi_square = reading.fit(printed).chi_square
    return -0.5 * float(chi_square + log_det) - float(np.log(u).sum())


def _title(row: Row) -> str:
    """Name a row for people."""
    return _words(row.row.source.quantity)


def _words(name: str) -> str:
    """Turn a key into words."""
    return name.replace("_", " ")
