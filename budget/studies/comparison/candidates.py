"""Candidates of a comparison: what would mend them, and what they lack."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.methods.gum import covariance_by_source
from budget.methods.radius import principal_variances, probability_within
from budget.missing import REFUSE
from budget.studies.comparison.records import MissingLines, Remedy
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from budget.methods.gum import Propagation
    from budget.question import Limited, Question
    from budget.results import Standing
    from budget.studies.judgement import Judged


GROWTH = 4.0  # of a variance, from one try of a bracket to the next [1]


def find_remedy(held: Limited, law: Propagation, judged: Judged) -> Remedy:
    """Return the source that makes most of the worst output, and what would mend it.

    With the other sources as they are, k^2 (V - V_s + f^2 V_s) = (limit - |mean|)^2
    gives the factor f on its standard uncertainty, by the law and with the k of the
    interval that was judged; its small part in products with other sources is left as
    it is. Of a length, the circle that was judged goes as the law's does.
    """
    worst = judged.worst
    row = held.rows[worst]
    parts = law.source_variance[:, row]
    source = first_largest(parts.tolist())
    total = float(law.covariance[row, row])
    name = held.problem.groups[source].name
    if total == 0.0:
        return Remedy(source=name, share=0.0, factor=None)
    if row >= law.value.size - law.legs.shape[1]:
        factor = _of_length(held, law, judged, source)
        return Remedy(source=name, share=float(parts[source]) / total, factor=factor)
    k = float(judged.factor[worst])
    allowed = (max(held.limits[worst] - abs(law.mean[row]), 0.0) / k) ** 2
    rest = total - float(parts[source])
    can_mend = allowed > rest and parts[source] > 0.0
    return Remedy(
        source=name,
        share=float(parts[source]) / total,
        factor=float(np.sqrt((allowed - rest) / parts[source])) if can_mend else None,
    )


def _of_length(
    held: Limited, law: Propagation, judged: Judged, source: int
) -> float | None:
    """Return the factor on a source that brings a length to its limit; None: none does.

    The ellipse of U - (1 - f^2) U_s gives a circle of the limit's radius, times what
    the law's circle is to that which was judged, its coverage.
    """
    from scipy.optimize import brentq

    row = held.rows[judged.worst]
    legs = law.legs[:, row - (law.value.size - law.legs.shape[1])]
    part = covariance_by_source(held.problem, law)[source][np.ix_(legs, legs)]
    rest = law.covariance[np.ix_(legs, legs)] - part
    by_law = law.interval(held.every_coverage)[row, 1]
    radius = np.array([by_law / judged.utilisation])

    def excess(squared: float) -> float:
        (a, between), (_, b) = (rest + squared * part)[:, :, None]
        within = probability_within(radius, principal_variances(a, b, between))
        return float(within[0] - held.coverage[judged.worst])

    if excess(0.0) <= 0.0:
        return None
    most = 1.0
    while excess(most) > 0.0:
        most *= GROWTH
    return float(np.sqrt(brentq(excess, 0.0, most, xtol=1e-15 * most)))


def missing_lines(one: Question, standing: Standing) -> MissingLines | None:
    """Return what lines that are not given could do to limits; None where none can."""
    missing = standing.matter(one.bare.missing)
    if not missing:
        return None
    used = standing.at_ceilings
    is_bound = one.filled.mode == REFUSE
    return MissingLines(
        lines=missing,
        filling=one.filled,
        utilisation=used if is_bound else None,
        verdict=""
        if used is None or not is_bound
        else ("meets" if settle(used) <= 1.0 else "fails"),
        is_bound=is_bound,
    )
