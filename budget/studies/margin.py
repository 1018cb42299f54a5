"""Room for what is not given and what nobody has stated, by the law of propagation.

Of a line of size s that is not given, at its ceiling s_c (budget.studies.ceilings),

    U(s) = |mean| + k sqrt(V + sum of V_m + (s/s_c)^2 V_s) ,

V of what is given, V_m of the others that are not, at their ceilings. Its bound is the
largest s at which every U is within its limit; so it is of a temperature (variance
going with its square), of a vibration (with the fourth power of its rms) and of an age
(as its lines grow). Of a length, the ellipse in the place of V gives a circle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import normal_coverage_factor
from budget.inputs.specification import read_value
from budget.inputs.use import STATED, stated_of
from budget.methods.gum import covariance_by_source
from budget.methods.radius import principal_variances, radius_of
from budget.missing import line_of, usual_line
from budget.missing.grades import family
from budget.missing.prediction import stand_in
from budget.model.sources import ENVIRONMENT, source_of
from budget.model.sources.later import growth
from budget.names import Name
from budget.results import TINY
from budget.studies.ceilings import BY_NATURE, ceilings_of, largest_printed
from budget.studies.jointly import Jointly, components_of
from budget.studies.judgement import TRIALS, judge
from budget.studies.lacking import (
    COEFFICIENTS,
    IN_GRAVITY,
    MEMS,
    OF_RATES,
    RESIDUALS,
    expected_of,
    felt_by,
    lacking_in_test,
    lacking_stated,
    lacking_use,
    manoeuvres,
    temperatures_of_test,
    unstated,
)
from budget.ties import from_largest, settle
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.records import ErrorLine
    from budget.question import Limited, Question
    from budget.studies.ceilings import Ceiling
    from budget.studies.judgement import Judged

# What a use that nobody has stated is tried at, and how big that is [SI].
PROBE = {
    key: read_value(source_of(ENVIRONMENT, STATED[key][0]), ENVIRONMENT, quantity).line
    for key, quantity in (
        ("temperature", parse_quantity("1 degC", "degC")),
        ("vibration", parse_quantity("1 g", "g")),
        ("age", parse_quantity("1 year", "s")),
    )
}
TRIED_AT = {key: float(line.u[0]) for key, line in PROBE.items()}
POWERS = {"temperature": 2, "vibration": 4}  # of a use, that its variance goes with
CLOSE = 1e-13  # relative, of the ends between which a bound is looked up
# A line reaches a limit where u at its ceiling is more than this part of it; without
# one, where so many times the largest that any device prints is [1].
NEGLIGIBLE, FAR_ABOVE = 0.005, 10.0
DOUBLINGS = 200  # of a bound, from one probe on
STEPS = 60  # of the look-up of a bound: to the rounding of a double


@dataclass(frozen=True, kw_only=True, eq=False)
class Margin:
    """Room that there is for what is not given and what nobody has stated.

    Attributes
    ----------
    missing : tuple of Name
        Expected lines that are not given and reach a limited output.
    tops : mapping of Name to Ceiling
        Of those that have one.
    groups : mapping of str to tuple of int
        Groups of `parts` that a missing line, or a use by its key, stands for.
    ages : mapping of int to ErrorLine
        Lines of ageing, by their group.
    silent : mapping of str to tuple of Name
        By the use: lines of it that reach a limited output and are not given.
    parts : ndarray, shape (n_groups, n_required, 2, 2)
        Covariance that each group makes: of a length of both components, of others the
        variance in the first place [SI squared].
    rest : ndarray, shape (n_required, 2, 2)
        Of all that is given.
    mean : ndarray, shape (n_required,)
        Absolute [SI].
    factor : tuple of ndarray, shape (n_required,) each
        Coverage factors on what is given, and with all lines at their ceilings [1].
    ratio : ndarray, shape (n_required,)
        Of a length what was judged over the circle of the law [1].
    jointly : Jointly, optional
        Of limits to be kept together what decides in the place of these.
    """

    held: Limited
    missing: tuple[Name, ...]
    filled: tuple[Name, ...]  # those that something stands for
    sizes: Mapping[Name, float]  # that their groups are of [SI]
    tops: Mapping[Name, Ceiling]
    groups: Mapping[str, tuple[int, ...]]
    ages: Mapping[int, ErrorLine]
    silent: Mapping[str, tuple[Name, ...]]
    parts: Array
    rest: Array
    mean: Array
    factor: tuple[Array, Array]
    ratio: Array
    jointly: Jointly | None = None

    @classmethod
    def of(cls, question: Question, judged: Judged, *, seed: int) -> Margin:
        """Compute what each missing line and each use that is not stated makes."""
        held = question.limits
        names, uses = expected_of(question), unstated(question)
        stands = {one.expected: one for one in question.filled.lines}
        silent = {key: lacking_use(question, key) for key in uses}
        every = dict.fromkeys((*names, *chain(*silent.values())))
        tops = ceilings_of(question, [*every])
        sizes = {
            name: tops[name].u if name in tops else float(usual_line(name).u[0])
            for name in every
        }
        in_test = [x for x in lacking_in_test(question) if x.quantity in COEFFICIENTS]
        apart = {*in_test} - {*lacking_stated(question)}
        lines = {name: _standing(question, name, sizes[name]) for name in every}
        missing = {name: lines[name] for name in names if name not in apart}
        probes = {name: lines[name] for name in chain(*silent.values())}
        asked = question.with_lines(missing | probes).in_use([PROBE[x] for x in uses])
        whole = asked.limits
        tests = [_of_test(question, name, sizes[name]) for name in in_test]
        places = {group.name: k for k, group in enumerate(whole.problem.groups)}
        acting: dict[str, tuple[Name, ...]] = {
            name: (Name(one.name, owner=name.owner),)
            for name, one in (missing | probes).items()
        }
        acting |= {name: (one.source,) for name, one in stands.items()}
        for key in uses:
            # Without the size of one of its lines a use has no bound by any.
            sized = all(x in tops and tops[x].origin != BY_NATURE for x in silent[key])
            own = [name for x in silent[key] for name in acting[x]] if sized else []
            acting[key] = (*felt_by(question, key), *own)
        groups = {
            name: tuple(places[own] for own in several if own in places)
            for name, several in acting.items()
        }
        for k, name in enumerate(in_test, start=len(places)):
            groups[name] = (*groups.get(name, ()), k)
        circle = np.abs(held.by_law).max(axis=1)
        used = judged.used * held.limits / np.maximum(circle, TINY)
        margin = cls(
            held=held,
            missing=(*names, *stands),
            filled=tuple(stands),
            sizes=sizes | {name: one.u for name, one in stands.items()},
            tops=tops,
            groups=groups,
            ages={
                places[name]: line
                for sensor in asked.there
                for line in sensor.lines
                if source_of(sensor.kind, line.name).use == "age"
                if (name := Name(line.name, owner=sensor.kind)) in places
            },
            silent=silent,
            parts=np.concatenate([_parts(whole), *tests]),
            rest=_parts(held, whole=True)[0],
            mean=np.abs(held.mean),
            factor=(_factor(held, judged),) * 2,
            ratio=np.where(held.lengths >= 0, used, 0.0),
        )
        margin = margin._reaching(question)
        if held.is_joint:
            margin = replace(margin, jointly=_jointly(margin, whole, judged))
        margin = margin.less([x for x in margin.missing if _is_suspected(question, x)])
        if margin.without_ceiling or not (missing and judged.by_trials.any()):
            return margin
        top = question.with_lines(missing).limits
        at_top = judge(top, seed=seed, max_trials=TRIALS)
        if margin.jointly is not None:
            ends = (*margin.jointly.known, (margin.weights, at_top.utilisation))
            margin = replace(margin, jointly=replace(margin.jointly, known=ends))
        return replace(margin, factor=(margin.factor[0], _factor(top, at_top)))

    def _reaching(self, question: Question) -> Margin:
        """Return it with what reaches a limit, of what may be; less what is filled."""
        least = np.array([output.resolution for output in self.held.outputs]) ** 2
        known = {*self.tops, *self.filled}
        is_mems = all(family(one.technology) == MEMS for one in question.devices)

        def variance(name: str) -> Array:
            own = self.parts[list(self.groups[name])].sum(axis=0)
            return np.asarray(own[:, [0, 1], [0, 1]].max(axis=1))

        def reaches(name: str) -> bool:
            return bool((variance(name) > least).any())

        def matters(name: Name) -> bool:
            size = 1.0
            if name not in known:
                if name.quantity in IN_GRAVITY and not is_mems:
                    return False
                most = largest_printed(name, question.catalogue)
                size = inf if most is None else FAR_ABOVE * most / self.sizes[name]
            share = float((np.sqrt(variance(name)) / self.held.limits).max())
            return reaches(name) and size * share > NEGLIGIBLE

        given = [self.parts[list(self.groups[x])].sum(axis=0) for x in self.filled]
        return replace(
            self,
            missing=tuple(filter(matters, self.missing)),
            silent={
                key: tuple(filter(reaches, own)) for key, own in self.silent.items()
            },
            rest=self.rest - sum(given, 0.0),
        )

    @cached_property
    def weights(self) -> Array:
        """Times that the variance of each group counts at the ceilings, (n_groups,)."""
        found = np.zeros(len(self.parts))
        for name in self.missing:
            found[list(self.groups[name])] = name in self.tops or name in self.filled
        return found

    def less(self, suspected: Sequence[Name]) -> Margin:
        """Return it without lines that overturn nothing, or of which nobody knows."""
        kept = tuple(x for x in self.missing if x not in suspected)
        least = replace(self, missing=kept)
        known = (x for x in suspected if x in self.tops)
        most = replace(self, missing=(*kept, *known))
        used, at_first = (settle(one.used(one.weights)) for one in (most, least))
        return most if used > 1.0 >= at_first else least

    @property
    def added(self) -> Array:
        """Covariance that missing lines add at their ceilings, as one of `parts`."""
        weights = self.weights.copy()
        for name in self.filled:
            weights[list(self.groups[name])] = 0.0  # it is in what is given
        return np.asarray(np.tensordot(weights, self.parts, axes=1))

    @property
    def without_ceiling(self) -> tuple[Name, ...]:
        """Missing lines that nothing bounds."""
        known = {*self.tops, *self.filled}
        return tuple(
            name
            for name in self.missing
            if name not in known and name.quantity not in OF_RATES
        )

    @cached_property
    def at_ceilings(self) -> float | None:
        """Utilisation with all missing lines at their ceilings; None: one has none."""
        return None if self.without_ceiling else self.used(self.weights)

    @cached_property
    def decisive(self) -> tuple[Name, ...]:
        """Missing lines that overturn a verdict, the one to ask for first.

        No more than are needed: with these at 0 all others may be at their ceilings.
        """
        if none := self.without_ceiling:
            return none
        weights = self.weights.copy()
        places = [list(self.groups[name]) for name in self.missing]
        sizes = [
            float((self._variances[own].sum(axis=0) / self.held.limits**2).max())
            for own in places
        ]
        asked: list[Name] = []
        for k in from_largest(sizes):
            if settle(self.used(weights)) <= 1.0:
                break
            weights[places[k]] = 0.0
            asked.append(self.missing[k])
        return tuple(asked)

    def used(self, weights: Array) -> float:
        """Return the utilisation with groups at so many times their variance [1].

        Parameters
        ----------
        weights : ndarray, shape (n_groups,)
            Of what is not among the given.
        """
        if self.jointly is not None:
            return self.jointly.used(weights)
        added = weights @ self._variances
        # From the factor of what is given to that with all lines at their ceilings.
        factor, top = self.factor[0], self._top
        if self.factor[0] is not self.factor[1]:
            grown = np.minimum(added, top) / np.maximum(top, TINY)
            factor = factor + (self.factor[1] - factor) * grown
        ends = self.mean + factor * np.sqrt(np.maximum(self.rest[:, 0, 0] + added, 0.0))
        if self.ratio.any():
            C = self.rest + np.tensordot(weights, self.parts, axes=1)
            for j in np.flatnonzero(self.ratio):
                axes = principal_variances(C[j, :1, 0], C[j, 1:, 1], C[j, :1, 1])
                circle = radius_of(self.held.coverage[[j]], axes)
                ends[j] = self.ratio[j] * float(circle[0])
        return float((ends / self.held.limits).max())

    @cached_property
    def _variances(self) -> Array:
        """Variance that each group makes, of a length of its first component."""
        return np.ascontiguousarray(self.parts[:, :, 0, 0])

    @cached_property
    def _top(self) -> Array:
        """Variance that is added at the ceilings, shape (n_required,) [SI squared]."""
        return np.asarray(self.weights @ self._variances)

    def bound(self, change: Callable[[Array, float], None], *, alone: bool) -> float:
        """Return the largest size at which every output is within its limit.

        `change` puts a size into the weights; all others are at their ceilings, or
        `alone` at 0. inf where no size matters, 0 where none will do.
        """

        def excess(size: float) -> float:
            weights = np.zeros_like(self.weights) if alone else self.weights.copy()
            change(weights, size)
            return self.used(weights) - 1.0

        if settle(1.0 + excess(0.0)) > 1.0:
            return 0.0
        high = 1.0
        for _ in range(DOUBLINGS):
            if excess(high) > 0.0:
                return turn(excess, 0.0, high)
            high *= 2.0
        return inf

    def bound_of(self, name: Name, *, alone: bool) -> float:
        """Return the largest size of a missing line [SI]; arguments as of `bound`."""
        places = list(self.groups[name])

        def change(weights: Array, times: float) -> None:
            weights[places] = times**2

        return self.bound(change, alone=alone) * self.sizes[name]

    @cached_property
    def use_bounds(self) -> Mapping[str, float]:
        """Largest sizes of the uses that nobody has stated, over those tried [1].

        Each alone first, then all of them by one factor, at which every output is
        within its limit with all of them there.
        """
        places = {
            key: [k for k in self.groups.get(key, ()) if self.parts[k].any()]
            for key in STATED
        }

        def change(sizes: Mapping[str, float]) -> Callable[[Array, float], None]:
            def put(weights: Array, times: float) -> None:
                for key, size in sizes.items():
                    for k in places[key]:
                        weights[k] = self._grown(key, k, times * size)

            return put

        alone = {
            key: self.bound(change({key: 1.0}), alone=False)
            for key, own in places.items()
            if own
        }
        within = {key: size for key, size in alone.items() if 0.0 < size < inf}
        if len(within) > 1:
            factor = min(self.bound(change(within), alone=False), 1.0)
            alone |= {key: factor * size for key, size in within.items()}
        return alone

    def _grown(self, key: str, group: int, size: float) -> float:
        """Return the variance of a group at so many times the use that was tried."""
        if key in POWERS:
            return size ** POWERS[key]
        line, year = self.ages[group], TRIED_AT[key]
        return (growth(line, size * year) / growth(line, year)) ** 2


def turn(excess: Callable[[float], float], low: float, high: float) -> float:
    """Return where `excess`, which grows from `low` to `high`, turns positive.

    Or just below, by regula falsi (Illinois).
    """
    ends, values, last = [low, high], [excess(low), excess(high)], None
    for _ in range(STEPS):
        step = values[0] / (values[0] - values[1])
        middle = ends[0] + (ends[1] - ends[0]) * step
        if not ends[0] < middle < ends[1] or ends[1] - ends[0] <= CLOSE * ends[1]:
            break
        value = excess(middle)
        side = int(value > 0.0)
        ends[side], values[side] = middle, value
        if last == side:
            values[1 - side] /= 2.0
        last = side
    return ends[0]


def _factor(held: Limited, judged: Judged) -> Array:
    """Return the coverage factors that were judged by; of what is 0 the normal ones."""
    usual = np.array([normal_coverage_factor(p) for p in held.coverage.tolist()])
    return np.where(judged.factor > 0.0, judged.factor, usual)


def _jointly(margin: Margin, whole: Limited, judged: Judged) -> Jointly:
    """Return what limits to be kept together have room for: `whole` is with `parts`."""
    of, of_whole = components_of(margin.held), components_of(whole)
    parts = of_whole.scaled(covariance_by_source(whole.problem, whole.law)[:-1])
    given = np.zeros(len(parts))
    for name in margin.filled:
        given[list(margin.groups[name])] = 1.0
    return Jointly(
        of=of,
        rest=of.covariance - np.tensordot(given, parts, axes=1),
        parts=parts,
        coverage=margin.held.usual,
        known=((given, judged.utilisation),),
    )


def _parts(held: Limited, *, whole: bool = False) -> Array:
    """Return the covariance that each group makes, as Margin has it.

    Of the `whole` law in one.
    """
    law, lengths = held.law, held.lengths
    variance = np.diag(law.covariance)[None] if whole else law.source_variance
    found = np.zeros((len(variance), held.rows.size, 2, 2))
    found[:, :, 0, 0] = variance[:, held.rows]
    if (lengths >= 0).any():
        each = (
            law.covariance[None]
            if whole
            else covariance_by_source(held.problem, law)[:-1]
        )
        for j in np.flatnonzero(lengths >= 0):
            legs = law.legs[:, lengths[j]]
            found[:, j] = each[:, legs[:, None], legs[None, :]]
    return found


def _is_suspected(question: Question, name: Name) -> bool:
    """Say whether a line counts only where at its ceiling it overturns a verdict.

    The g-sensitivity of a gyro that does not turn in gravity.
    """
    is_level = question.journey is not None and not manoeuvres(question.journey)
    # Beside a use that nobody has stated it is one condition more.
    return is_level and name.quantity in IN_GRAVITY and not unstated(question)


def _standing(question: Question, name: Name, u: float) -> ErrorLine:
    """Return the line that stands for one that is not given, of a size [SI].

    Of a coefficient of temperature what it makes of the temperature that is stated: a
    residual on each axis, whose sign nobody knows. Where that is known at every time of
    a mission the coefficient is a constant itself.
    """
    stated = stated_of(question.procedure).get("temperature")
    residual = RESIDUALS.get(name.quantity)
    if residual is None or (stated and stated.course):
        return line_of(stand_in(name), name.owner, u)
    size = float((stated or PROBE["temperature"]).u[0])
    return line_of(source_of(name.owner, residual.name), name.owner, u * size)


def _of_test(question: Question, name: Name, size: float) -> Array:
    """Return the covariance that one coefficient has of the temperature of a test.

    Alone, as its sign beside that of others is not known: shape (1, n_required, 2, 2).
    """
    line = line_of(stand_in(name), name.owner, size)
    own = question.with_lines({name: line}, less=COEFFICIENTS).limits
    there = temperatures_of_test(question)
    rows = [k for k, group in enumerate(own.problem.groups) if group.name in there]
    return np.asarray(_parts(own)[rows].sum(axis=0, keepdims=True))
