"""Table 1, all 60 entries: which reading of 'relative error' they fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.names import PARAMETERS
from budget.studies.paper.conditions import (
    HALF_ULP,
    PLACES,
    nominal_size,
    only_sources,
)
from budget.studies.paper.findings import (
    RUNS,
    U_MEAN,
    U_SINGLE,
    Finding,
    Verdict,
    agrees_if,
    ratio_of,
    say,
    words,
)
from budget.studies.paper.readings import (
    MOUNTING,
    SIX_DIGITS,
    STABILITY,
    WALK,
    as_stated,
    best_reading,
    fitting_choices,
    root_mean_square,
    switched_on,
)
from budget.studies.paper.statistics import repeats, spread_of_means, two_sided

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.readings import Reading

REPEATABILITIES = ("bias_repeatability", "scale_factor_repeatability")


@dataclass(frozen=True, kw_only=True, eq=False)
class Row:
    """One row of Table 1, read as stated.

    Attributes
    ----------
    single, mean : Reading
        Of a single run and of a mean over 25.
    drawn : ndarray, shape (12,)
        Spread of means over 25 runs, drawn again and again [1].
    texts : tuple of str
        The twelve entries as printed.
    """

    single: Reading
    mean: Reading
    drawn: Array
    texts: tuple[str, ...]

    @property
    def title(self) -> str:
        """Where the row stands."""
        return f"Table 1, {words(self.single.source.quantity)}"


def compute_rows(conditions: Conditions) -> dict[str, Row]:
    """Compute what each row should be: formulas of the paper, reference nominal."""
    size = nominal_size(conditions.gyro)
    rows = {}
    for name in conditions.paper.table_1:
        single = as_stated(conditions, name)
        problem = only_sources(conditions.gyro, conditions.printed, single.source)
        rows[name] = Row(
            single=single,
            mean=single.of_mean,
            drawn=spread_of_means(problem, runs=RUNS) / size,
            texts=conditions.paper.entries(name),
        )
    return rows


def table1_findings(
    conditions: Conditions, readings: tuple[Reading, ...]
) -> tuple[Finding, ...]:
    """Return, for each row, a summary of every random parameter and all 12 entries."""
    rows = compute_rows(conditions)
    findings = []
    for name, row in rows.items():
        other = best_reading(readings, row.single.source)
        for parameter in PLACES:
            if row.single.is_random(parameter):
                findings += _random_entries(row, parameter, other)
            else:
                findings += _fixed_entries(row, parameter)
        if name == STABILITY.quantity:
            findings.append(_left_on(rows, readings, conditions))
    return (*findings, _both_repeatabilities(rows))


def _random_entries(row: Row, parameter: str, other: Reading | None) -> list[Finding]:
    """Say which reading the entries of one parameter fit, together and one by one."""
    place = PLACES[parameter]
    single, mean = row.single.fit(parameter), row.mean.fit(parameter)
    chosen, verdict, cause = row.single, Verdict.UNEXPLAINED, ""
    if mean.fits and mean.p > single.p:
        chosen, verdict = row.mean, Verdict.FITS_MEAN
    elif single.fits:
        verdict = Verdict.FITS_SINGLE
    elif other is not None:
        p = other.fit(parameter).p
        verdict = Verdict.READING
        cause = f"; fits if read so: {other.full_name} (p {say(p, 2)})"
        if row.single.source == MOUNTING:  # see mounting.py
            verdict = Verdict.EXPLAINED
            cause += "; its biases prove it, see below"
    u, u_rms = chosen.u[place], chosen.fit(parameter).u_rms
    drawn = np.mean(row.drawn[place] / row.mean.u[place])
    rms = root_mean_square(row.single.printed[place])
    summary = Finding(
        section="table 1",
        where=f"{row.title}, {words(parameter)}, all {single.entries}",
        printed=f"rms {say(rms, 3)}",
        ours=u_rms,
        quantity=chosen.quantity,
        ratio=ratio_of(u_rms, rms),
        verdict=verdict,
        why=f"chi-square for {single.entries} entries: {say(single.chi_square, 3)} as "
        f"a single run, {say(mean.chi_square, 3)} as a mean over {RUNS}; u single "
        f"{say(single.u_rms)}, mean {say(mean.u_rms)} ({repeats(RUNS)} means drawn "
        f"spread by {drawn:.3f} of it){cause}",
        p_single=single.p,
        p_mean=mean.p,
        is_summary=True,
    )
    entries = [
        Finding(
            section="table 1",
            where=f"{row.title}, {words(parameter)} {name}",
            printed=text,
            ours=float(u[k]),
            quantity=chosen.quantity,
            ratio=ratio_of(float(u[k]), float(text)),
            verdict=verdict,
            why="judged with its neighbours, in the row above",
            p_single=float(single.p_entries[k]),
            p_mean=float(mean.p_entries[k]),
        )
        for k, (name, text) in enumerate(
            zip(PARAMETERS[parameter], row.texts[place], strict=True)
        )
    ]
    return [summary, *entries]


def _fixed_entries(row: Row, parameter: str) -> list[Finding]:
    """Return entries that do not vary: zeros to rounding, and eq. (4)'s residual."""
    place, expected = PLACES[parameter], row.single.expectation
    findings = []
    for name, text, ours, zero in zip(
        PARAMETERS[parameter],
        row.texts[place],
        expected.mean[place].tolist(),
        expected.resolution[place].tolist(),
        strict=True,
    ):
        printed, is_zero = float(text), abs(ours) <= zero
        if is_zero:
            agrees, why = abs(printed) <= zero, "exactly zero"
            if printed:
                why = (
                    f"rounding: {round(abs(printed) / HALF_ULP)} times 2^-53, the "
                    "spacing of doubles below 1, left by calibrated over nominal - 1"
                )
        else:
            agrees = abs(ours / printed - 1.0) <= SIX_DIGITS
            why = (
                "eq. (4)'s own error (dT + dT^T) w + dT^T b + dT^T dT w, no rounding; "
                f"to six digits: ours/printed - 1 = {say(ours / printed - 1.0, 2)}"
            )
        findings.append(
            Finding(
                section="table 1",
                where=f"{row.title}, {words(parameter)} {name}",
                printed=text,
                ours=0.0 if is_zero else ours,
                ratio=None if is_zero else ratio_of(ours, printed),
                verdict=agrees_if(agrees),
                why=why,
            )
        )
    return findings


def _both_repeatabilities(rows: dict[str, Row]) -> Finding:
    """Judge the two repeatability rows together: only so a single run is excluded."""

    def together(readings: list[Reading]) -> tuple[float, float]:
        fits = [reading.fit() for reading in readings]
        chi_square = sum(one.chi_square for one in fits)
        return chi_square, two_sided(chi_square, sum(one.entries for one in fits))

    single, p_single = together([rows[name].single for name in REPEATABILITIES])
    mean, p_mean = together([rows[name].mean for name in REPEATABILITIES])
    # Printed over u: each row has three random entries with independent axes.
    rms = float(np.sqrt(single / 6.0))
    return Finding(
        section="table 1",
        where="Table 1, bias and scale factor repeatability, their 6 random entries",
        printed=f"rms {say(rms, 3)} of u, single run",
        ours=1.0 / np.sqrt(RUNS),
        quantity=U_MEAN,
        ratio=float(1.0 / np.sqrt(RUNS) / rms),
        verdict=Verdict.FITS_MEAN if p_mean > p_single else Verdict.FITS_SINGLE,
        why=f"chi-square for 6 entries: {say(single)} as a single run, {say(mean)} as "
        f"a mean over {RUNS}",
        p_single=p_single,
        p_mean=p_mean,
        is_summary=True,
    )


def _left_on(
    rows: dict[str, Row], readings: tuple[Reading, ...], conditions: Conditions
) -> Finding:
    """Judge the stability row as a run whose random walk was left on, and the choice.

    No number is fitted, but a reading was looked for: how many were tried, how many
    of them fit, and how often one fits by chance, shown by the other rows, is said.
    """
    choices = switched_on(conditions)
    row, walk = (rows[source.quantity].single for source in (STABILITY, WALK))
    single, mean = (
        r for r in readings if r.source == STABILITY and r.sources == (STABILITY, WALK)
    )
    of_single = single.fit()
    found = {name: fitting_choices(choices, r.single) for name, r in rows.items()}
    fitting = {r.sources: r for r in found.pop(STABILITY.quantity)}
    if any(WALK not in chosen or r.runs != 1 for chosen, r in fitting.items()):
        raise ValueError(
            "a run without the random walk fits: the reason given is wrong"
        )
    elsewhere = sum(r.sources != (r.source,) for fits in found.values() for r in fits)
    tried = 2 * len(choices)
    others = sum(r.source == STABILITY and r.sources == (STABILITY,) for r in readings)
    alone, norm = fitting[WALK,], np.linalg.norm
    # Of ratios of normal densities the powers of 2 pi cancel.
    odds = np.exp(_log_density(alone) - _log_density(single))
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
        verdict=Verdict.READING,
        why=f"chi-square {say(of_single.chi_square, 3)} for {of_single.entries} "
        f"entries, as stated {say(row.fit().chi_square, 3)}; no free "
        f"parameter. Looked for among {tried + others} readings: every choice of the "
        f"five stated sources ({len(choices)}) and turns far apart, each as one run "
        f"and as a mean over {RUNS}. {len(fitting)} fit, all single runs with the "
        f"random walk; it alone fits as well (p {say(alone.fit().p)}, "
        f"{say(float(odds))} times as likely), so that the row does not show whether "
        f"the stability was on. By chance {elsewhere} of "
        f"{(len(rows) - 1) * (tried - 2)} wrong choices fit another row. Against it: "
        f"the random walk's own row prints {', '.join(times)} times less",
        p_single=of_single.p,
        p_mean=mean.fit().p,
        is_summary=True,
    )


def _log_density(reading: Reading) -> float:
    """Return the logarithm of the normal density of twelve entries, less a constant."""
    u = reading.expectation.u
    # Scaled first: scale factors and angles differ by a factor of 1e5.
    _, log_det = np.linalg.slogdet(reading.expectation.covariance / np.outer(u, u))
    return -0.5 * float(reading.fit().chi_square + log_det) - float(np.log(u).sum())
