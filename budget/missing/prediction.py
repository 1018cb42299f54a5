"""Prediction of lines that a data sheet does not give, from those of other devices.

The logarithm y of the standard uncertainty of a line is taken as normal, about a mean
of its own for every line, with effects of the technology, the design (a file), the
device (a variant) and the sensor (LEVELS):

    y = mu(line) + sum over levels of e(group, line),
    cov(e(g, l), e(g, l')) = sigma^2 r(l) r(l') v (rho + (1 - rho) [l = l'])/w

rho says that what is good in one line tends to be good in the others, so that given
lines of a device predict those that it lacks; v, that devices of one design, or of one
technology, are no independent witnesses; r, that designs differ more in some lines than
in others: their variance about the mean of the line over that of all lines, moderated
by it with the weight of WITNESSES designs (Smyth 2004).

Some designs are of a class of their own, as a seismic accelerometer among those of
phones. So the effects of a design, and of all within it, have heavy tails: w, 1 for a
technology, is a factor of each design, w ~ chi^2(TAILS)/TAILS, which makes them a
multivariate Student t. Of its n figures, left over by e once means and technology are
taken off, with their covariance sigma^2 R at w = 1,

    E[w given e] = (TAILS + n) / (TAILS + d^2), d^2 = e' R^-1 e / sigma^2,

as w given e is gamma again: its prior's chi^2 and the normal's w^(n/2) exp(-w d^2/2)
multiply. That is put for w, and all is fitted anew, ROUNDS times (EM). What is
predicted of a design has its own w, and TAILS + n degrees of freedom at the most.

With a flat prior of mu and sigma^2 ~ Inv-chi^2(DF_0, 1), of n given lines y, H telling
which of the q lines each is and K their covariance over sigma^2, those that are
missing, with k the covariance to the given ones and h which lines they are, are a
multivariate Student t (BDA, chapters 14 and 15):

    m = G H' K^-1 y, G = (H' K^-1 H)^-1, r = y - H m, d = h - k' K^-1 H,
    location h m + k' K^-1 r, scale s^2 (k0 - k' K^-1 k + d G d'),
    df = DF_0 + n - q, s^2 = (DF_0 + r' K^-1 r) / df

Of one line and designs with nothing in common that is the t of a new observation of
ordinary regression, s^2 (1 + x0 (X'X)^-1 x0') (Seber, Lee, 5.3).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import small_blocks
from budget.missing.grades import FAMILIES, known_family
from budget.model.sources import SENSORS, lines_of, source_of
from budget.names import Name

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Device
    from budget.model.source import Source

# Variance over that of designs, and correlation of the lines of one group, for each
# level from the widest to the narrowest: assumptions, round numbers near the largest
# likelihood of the catalogue, which is flat about them. The scale sigma is estimated.
LEVELS = {
    "technology": (0.25, 0.5),
    "design": (1.0, 0.5),
    "device": (0.1, 0.75),
    "sensor": (0.1, 0.75),
}
DESIGN = tuple(LEVELS).index("design")
DF_0 = 2.0  # weight of the prior sigma^2 = 1, of a factor e, in observations
WITNESSES = 5.0  # weight of the common spread of designs, in designs
TAILS = 4.0  # degrees of freedom of the effects of a design: a round number
ROUNDS = 12  # of the fit, after which no w moves by more than 0.01
ROUNDS_NEAR = 1  # from a fit of figures of which one device is as before
# Designs that give a line, of which one more can be predicted: fewer say nothing of
# the spread between designs.
LEAST_DESIGNS = 3
KEPT = 512  # fits, of devices that are predicted again and again
AT_ONCE = 16  # fits: what they are made of takes 300 kB each


@dataclass(frozen=True, kw_only=True)
class LogLine:
    """One expected line of one device, in logarithms."""

    groups: tuple[str, ...]  # of each level
    line: str  # what is compared: 'noise of the gyro', 'mounting_repeatability'
    device: str
    log_u: float  # of the largest axis [ln SI]; 0 of one that is predicted


@dataclass(frozen=True, kw_only=True, eq=False)
class Prediction:
    """Joint Student t of the logarithms of lines that are not given."""

    names: tuple[Name, ...]
    location: Array  # shape (n,) [ln SI]
    scale: Array  # scale matrix, shape (n, n) [1]
    df: float  # degrees of freedom, of all lines together
    # For each line: devices that give it, and designs that these are of.
    devices: tuple[tuple[str, ...], ...]
    designs: tuple[int, ...]
    df_of_each: tuple[float, ...] = ()  # of each line, where they are not the same

    @property
    def median(self) -> Array:
        """Medians of the standard uncertainties, shape (n,) [SI]."""
        return np.exp(self.location)

    def interval(self, probability: float) -> Array:
        """Return the central interval of each line, shape (n, 2) [SI]."""
        from scipy.special import stdtrit

        half = stdtrit(self.df_of_each or self.df, (1.0 + probability) / 2.0) * np.sqrt(
            np.diag(self.scale)
        )
        ends = np.stack([self.location - half, self.location + half], axis=1)
        return np.asarray(np.exp(ends))

    def of(self, names: Sequence[Name]) -> Prediction:
        """Return the marginal of some of the lines."""
        kept = [place for place, name in enumerate(self.names) if name in names]
        df = tuple(self.df_of_each[place] for place in kept if self.df_of_each)
        return Prediction(
            names=tuple(self.names[place] for place in kept),
            location=self.location[kept],
            scale=self.scale[np.ix_(kept, kept)],
            df=min(df, default=self.df),
            devices=tuple(self.devices[place] for place in kept),
            designs=tuple(self.designs[place] for place in kept),
            df_of_each=df,
        )


def joined(parts: Sequence[Prediction]) -> Prediction:
    """Return predictions of several devices as one, as if they were independent.

    Together their tails are those of the heaviest, each line keeps its own.
    """
    from scipy.linalg import block_diag

    if len(parts) == 1:
        return parts[0]
    return Prediction(
        names=tuple(name for one in parts for name in one.names),
        location=np.concatenate([one.location for one in parts]),
        scale=np.asarray(block_diag(*(one.scale for one in parts))),
        df=min(one.df for one in parts),
        devices=tuple(those for one in parts for those in one.devices),
        designs=tuple(number for one in parts for number in one.designs),
        df_of_each=tuple(
            df for one in parts for df in one.df_of_each or (one.df,) * len(one.names)
        ),
    )


def predict(
    device: Device,
    missing: Sequence[Name],
    catalogue: Sequence[Device],
    *,
    technology: str | None = None,
) -> Prediction | None:
    """Predict expected lines that a device does not give.

    Parameters
    ----------
    device : Device
        Its given lines are part of what the prediction stands on.
    missing : sequence of Name
        Of its sensors; those given by fewer than LEAST_DESIGNS other designs are left
        out.
    catalogue : sequence of Device
        Where the other lines come from.
    technology : str, optional
        That its missing lines are taken to be of, where its own is not known.

    Returns
    -------
    Prediction or None
        None where no line can be predicted.
    """
    if not missing:
        return None
    known = _Member.of(device, catalogue)
    meant = known.device
    if technology is not None:
        meant = replace(meant, technology=technology)
    fit = _fit_all([known], technology)[0]
    if fit is None:
        return None
    return fit.predict({name: figure_of(meant, name) for name in missing})


def prepare(devices: Iterable[Device], catalogue: Sequence[Device]) -> None:
    """Fit what predictions of several devices take: at once, which is sooner done."""
    members = [
        _Member.of(one, catalogue)
        for one in devices
        if any(sensor.expected_missing for sensor in one.sensors)
    ]
    untold = [one for one in members if known_family(one.device) == ""]
    _fit_all(members, None)
    for word in FAMILIES if untold else ():
        _fit_all(untold, word)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Member:
    """A device among others, whose figures it stands beside, or in the place of."""

    device: Device  # of the design that it is of there
    others: tuple[Device, ...]
    variants: tuple[Device, ...]  # of its design among them
    is_there: bool  # as it is
    is_printed: bool  # there is one of its name

    @classmethod
    def of(cls, device: Device, catalogue: Sequence[Device]) -> _Member:
        """Find its design; out of another file it is no other witness of itself."""
        by_name, by_design = _sorted(tuple(catalogue))
        same = by_name.get(device.as_printed, [])
        if same:
            device = replace(device, origin=same[0].origin)
        design = _design(device)
        variants = [one for one in by_design.get(design, []) if one not in same]
        stands = bool(variants or figures_of(device))
        is_there = [figures_of(one) for one in same] == [figures_of(device)]
        left = [
            one for one in same if not (is_there or (stands and _design(one) == design))
        ]
        return cls(
            device=device,
            others=tuple(one for one in catalogue if one not in left)
            if left
            else tuple(catalogue),
            variants=tuple(variants),
            is_there=is_there,
            is_printed=bool(same),
        )

    def figures(self, technology: str | None) -> tuple[LogLine, ...]:
        """Return those of its design, of that technology where its own is not known."""
        if self.is_there and technology is None:
            return ()
        own: Iterable[Device] = (*self.variants, self.device)
        if technology is not None:
            own = [replace(one, technology=technology) for one in own]
        return tuple(_figures(own))


def _fit_all(members: Sequence[_Member], technology: str | None) -> list[Fit | None]:
    """Return the fits that predictions of devices take; None: nothing is given.

    Those of a technology that nobody told start near those without.
    """
    found: dict[int, Fit] = {}
    alike: dict[tuple[Device, ...], list[int]] = {}
    for k, one in enumerate(members):
        alike.setdefault(one.others, []).append(k)
    for devices, places in alike.items():
        others = _others(devices)
        those = [members[k] for k in places]
        figures = [one.figures(technology) for one in those]
        near = None
        if technology is not None:
            untold = [() if one.is_printed else one.figures(None) for one in those]
            if others.designs or all(untold):  # else there is nothing to be near
                near = others.fits(untold)
        if others.designs or any(figures):
            found |= dict(zip(places, others.fits(figures, near=near), strict=True))
    return [found.get(k) for k in range(len(members))]


class Design:
    """Figures of one design, and what every fit takes of them.

    Attributes
    ----------
    figures : sequence of LogLine
        Of one design.
    of_line : mapping of str to list of LogLine
        The same by their line.
    technology, name : str
        The design stands for its technology where nobody knows that.
    number : ndarray, shape (q,)
        Of figures of each line.
    middle : ndarray, shape (q,)
        Mean of their logarithms about the origin of the line; 0 where there is none.
    forms : ndarray, shape (3, q, q)
        Z' N^-1 Z, Z' N^-1 Y Z and Z' Y N^-1 Y Z: N the covariance of the figures, over
        r and at w = 1, Y the diagonal matrix of their logarithms, Z telling their line.
    """

    def __init__(
        self, figures: Sequence[LogLine], lines: Sequence[str], origin: Array
    ) -> None:
        self.figures = figures
        self.of_line: dict[str, list[LogLine]] = {}
        for each in figures:
            self.of_line.setdefault(each.line, []).append(each)
        self.technology, self.name = figures[0].groups[: DESIGN + 1]
        Z = _same([each.line for each in figures], lines)
        self.number = Z.sum(axis=0)
        y = np.array([each.log_u for each in figures]) - Z @ origin
        self.middle = y @ Z / np.maximum(self.number, 1.0)
        inverse = np.linalg.inv(_alike(figures, figures))
        of_y = Z * y[:, None]
        self.forms = np.stack(
            [Z.T @ inverse @ Z, Z.T @ inverse @ of_y, of_y.T @ inverse @ of_y]
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Scale, weights and means fitted to figures, and what predictions take of them."""

    designs: tuple[Design, ...]
    lines: tuple[str, ...]
    origin: Array  # that logarithms are counted from, shape (q,) [ln SI]
    technologies: tuple[str, ...]
    spread: Array  # r of each line, shape (q,) [1]
    weights: Array  # w of each design [1]
    mean: Array  # of each line over r, from the origin, shape (q,)
    spread_of_mean: Array  # its covariance over sigma^2, shape (q, q)
    # Effects of the technologies over r, and what their figures weigh in it:
    # (1 + S A)^-1 S, S the sum of w Z' N^-1 Z, shapes (t, q) and (t, q, q).
    effect: Array
    given: Array
    df: float
    sigma_2: float

    @classmethod
    def of(cls, given: Sequence[LogLine]) -> Fit:
        """Fit scale and weights to figures."""
        return Others.of(given).fits([()])[0]

    @property
    def trust(self) -> dict[str, float]:
        """Weight w of each design [1]."""
        names = (one.name for one in self.designs)
        return dict(zip(names, self.weights.tolist(), strict=True))

    def predict(self, wanted: dict[Name, LogLine]) -> Prediction | None:
        """Predict figures of one device; None where too few designs give any of them.

        Of a design whose figures lie z off the mean and its technology, a new one lies
        n' N^-1 z off; that mean and effect are no surer than
        A - A X A + (1 - A X) G (1 - A X)', X being `given`.
        """
        found = {
            name: those
            for name, one in wanted.items()
            for those in [self._witnesses(one)]
            if len({each.groups[DESIGN] for each in those}) >= LEAST_DESIGNS
        }
        if not found:
            return None
        new = [wanted[name] for name in found]
        technology, design = new[0].groups[0], new[0].groups[DESIGN]
        own = next((one for one in self.designs if one.name == design), None)
        there = own.figures if own else ()
        A, q = _technology(len(self.lines)), len(self.lines)
        effect, X = np.zeros(q), np.zeros((q, q))
        if technology in self.technologies:
            place = self.technologies.index(technology)
            effect, X = self.effect[place], self.given[place]
        at = _same([one.line for one in new], self.lines)
        Z = _same([one.line for one in there], self.lines)
        y = (np.array([one.log_u for one in there]) - Z @ self.origin) @ np.diag(
            1.0 / (Z @ self.spread)
        )
        n = _alike(new, there)
        gain = np.linalg.solve(_alike(there, there), n.T).T
        known, loss = at - gain @ Z, np.eye(q) - A @ X
        w = self.weights[self.designs.index(own)] if own else 1.0
        scale = (
            known @ (A - A @ X @ A + loss @ self.spread_of_mean @ loss.T) @ known.T
            + (_alike(new, new) - gain @ n.T) / w
        )
        r = at @ self.spread
        return Prediction(
            names=tuple(found),
            location=at @ self.origin + r * (known @ (self.mean + effect) + gain @ y),
            scale=self.sigma_2 * np.outer(r, r) * (scale + scale.T) / 2.0,
            df=min(self.df, TAILS + len(there)),
            devices=tuple(
                tuple(dict.fromkeys(each.device for each in those))
                for those in found.values()
            ),
            designs=tuple(
                len({each.groups[DESIGN] for each in those}) for those in found.values()
            ),
        )

    def _witnesses(self, wanted: LogLine) -> list[LogLine]:
        """Return who else gives a line."""
        return [
            each
            for one in self.designs
            if one.name != wanted.groups[DESIGN]
            for each in one.of_line.get(wanted.line, ())
        ]


@dataclass(frozen=True, kw_only=True, eq=False)
class Others:
    """Figures that many fits share, each of which has one design more or another.

    As K is N/w + Z A Z' within a technology, all that a fit needs are sums over designs
    of w times their `forms` (Woodbury), of many fits at once; each one is the same,
    digit by digit, whichever others are beside it.
    """

    designs: tuple[Design, ...]
    lines: tuple[str, ...]
    origin: Array  # shape (q,) [ln SI]
    # Fits that were made, by the figures of the member and whether from near.
    kept: dict[tuple[tuple[LogLine, ...], bool], Fit] = field(default_factory=dict)

    @classmethod
    def of(cls, figures: Sequence[LogLine]) -> Others:
        """Sort figures by their design."""
        sizes: dict[str, list[float]] = {}
        designs: dict[str, list[LogLine]] = {}
        for each in figures:
            sizes.setdefault(each.line, []).append(each.log_u)
            designs.setdefault(each.groups[DESIGN], []).append(each)
        origin = np.array([np.mean(values) for values in sizes.values()])
        lines = tuple(sizes)
        return cls(
            designs=tuple(Design(own, lines, origin) for own in designs.values()),
            lines=lines,
            origin=origin,
        )

    def fits(
        self,
        members: Sequence[Sequence[LogLine]],
        *,
        near: Sequence[Fit] | None = None,
    ) -> list[Fit]:
        """Return a fit for each member: with its figures, all of one design.

        They stand for those that the others have of that design; soon, from fits that
        are `near` them.
        """
        words = {one.technology for one in self.designs}
        keys = [(tuple(member), near is not None) for member in members]
        if len(self.kept) > KEPT:
            self.kept.clear()
        found = {key: self.kept[key] for key in keys if key in self.kept}
        alike: dict[tuple[tuple[str, ...], bool, str], list[int]] = {}
        for k, (member, key) in enumerate(zip(members, keys, strict=True)):
            if key in found:
                continue
            word = member[0].groups[0] if member else ""
            of_one = word if word in words else ""
            more = tuple(sorted({one.line for one in member} - {*self.lines}))
            alike.setdefault((more, bool(member), of_one), []).append(k)
        for (more, *_), places in alike.items():
            own = self._with(more)
            for start in range(0, len(places), AT_ONCE):
                some = places[start : start + AT_ONCE]
                with small_blocks():
                    fits = own.fits_alike(
                        [members[k] for k in some],
                        None if near is None else [near[k] for k in some],
                    )
                found |= dict(zip((keys[k] for k in some), fits, strict=True))
        self.kept.update(found)
        return [found[key] for key in keys]

    def _with(self, more: tuple[str, ...]) -> Others:
        """Return the others with lines more, that none of them gives."""
        if not more:
            return self
        lines = (*self.lines, *more)
        origin = np.append(self.origin, np.zeros(len(more)))
        return Others(
            designs=tuple(Design(one.figures, lines, origin) for one in self.designs),
            lines=lines,
            origin=origin,
        )

    def fits_alike(
        self, members: Sequence[Sequence[LogLine]], near: Sequence[Fit] | None
    ) -> list[Fit]:
        """Fit at once what is of one technology, or of none that others are of."""
        own = [Design(each, self.lines, self.origin) for each in members if each]
        every = [(*self.designs, *own[k : k + 1]) for k in range(len(members))]
        names = [one.name for one in self.designs]
        slots = [*dict.fromkeys(one.technology for one in self.designs)]
        slot = [slots.index(one.technology) for one in self.designs]
        if own:
            word = own[0].technology
            slot.append(slots.index(word) if word in slots else len(slots))
        order = np.argsort(slot, kind="stable")
        # What a member has in the place of a design of the others.
        replaced = np.zeros((len(members), len(slot)), dtype=bool)
        for k, one in enumerate(own):
            replaced[k, : len(names)] = [name == one.name for name in names]
        sums = _Sums(
            number=self._stacked("number", own, replaced)[:, order],
            middle=self._stacked("middle", own, replaced)[:, order],
            forms=self._stacked("forms", own, replaced)[:, order],
            slot=np.array(slot)[order],
        )
        trust = [one.trust for one in near] if near else [{} for _ in members]
        w = np.array(
            [
                [known.get(one.name, 1.0) for one in each]
                for known, each in zip(trust, every, strict=True)
            ]
        )[:, order]
        number = sums.number.sum(axis=2)
        for _ in range(ROUNDS_NEAR if near else ROUNDS):
            w = (TAILS + number) / (TAILS + sums.at(w).distance)
        found = sums.at(w)
        fits = []
        for k, each in enumerate(every):
            kept = np.flatnonzero(~replaced[k]).tolist()
            fits.append(
                Fit(
                    designs=tuple(each[place] for place in kept),
                    lines=self.lines,
                    origin=self.origin,
                    technologies=(*slots, *(one.technology for one in own[k : k + 1])),
                    weights=w[k, np.argsort(order)[kept]],
                    spread=found.spread[k],
                    mean=found.mean[k],
                    spread_of_mean=found.spread_of_mean[k],
                    effect=found.effect[k],
                    given=found.given[k],
                    df=float(sums.df[k]),
                    sigma_2=float(found.sigma_2[k]),
                )
            )
        return fits

    def _stacked(
        self, what: str, own: Sequence[Design], replaced: NDArray[np.bool_]
    ) -> Array:
        """Return what designs have, of every fit, with zeros for what is replaced."""
        q = len(self.lines)
        found = np.zeros((*replaced.shape, *{"forms": (3, q, q)}.get(what, (q,))))
        for place, one in enumerate(self.designs):
            found[:, place] = getattr(one, what)
        for k, one in enumerate(own):
            found[k, -1] = getattr(one, what)
        found[replaced] = 0.0
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _FitsAt:
    """Fits at weights of their designs, and how far off each design lies."""

    spread: Array  # shape (b, q) [1]
    mean: Array  # shape (b, q)
    spread_of_mean: Array  # shape (b, q, q)
    effect: Array  # shape (b, t, q)
    given: Array  # shape (b, t, q, q)
    sigma_2: Array  # shape (b,)
    distance: Array  # d^2 of each design, shape (b, d)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sums:
    """What designs have, of b fits at once, technology by technology.

    Every product is of one fit: matrices of many are never multiplied in one, whose
    rounding would depend on how many there are.
    """

    number: Array  # shape (b, d, q)
    middle: Array  # shape (b, d, q)
    forms: Array  # shape (b, d, 3, q, q)
    slot: NDArray[np.intp]  # of the technology of each design, ascending, shape (d,)

    @property
    def df(self) -> Array:
        """Degrees of freedom, shape (b,)."""
        each = self.number.sum(axis=1)
        return np.asarray(DF_0 + each.sum(axis=1) - (each > 0.0).sum(axis=1))

    def at(self, w: Array) -> _FitsAt:
        """Fit means and scale at weights, shape (b, d).

        With z = y/r - m - u of a design, u the effect of its technology, e = K^-1 (y -
        H m) is w N^-1 z/r there, so d^2 sigma^2 is z' N^-1 z.
        """
        b, d, q = self.number.shape
        spread = self._spread(w)
        over = 1.0 / spread
        flat = self.forms.reshape(b, d, 3, q * q)
        starts = np.searchsorted(self.slot, np.arange(self.slot[-1] + 1))
        # Z' N^-1 y/r and (y/r)' N^-1 y/r of each design.
        of_y = (self.forms[:, :, 1].reshape(b, d * q, q) @ over[..., None]).reshape(
            b, d, q
        )
        twice = (over[:, :, None] * over[:, None, :]).reshape(b, q * q, 1)
        of_yy = (flat[:, :, 2] @ twice)[..., 0]
        S = np.add.reduceat(w[..., None] * flat[:, :, 0], starts, axis=1)
        S = S.reshape(b, -1, q, q)
        Sy = np.add.reduceat(w[..., None] * of_y, starts, axis=1)
        A = _technology(q)
        found = np.linalg.solve(
            np.eye(q) + S @ A, np.concatenate([S, Sy[..., None]], axis=-1)
        )
        given, of_given = found[..., :q], found[..., q]
        is_absent = self.number.sum(axis=1) == 0.0
        spread_of_mean = np.linalg.inv(
            given.sum(axis=1) + is_absent[..., None] * np.eye(q)
        )
        mean = (spread_of_mean @ of_given.sum(axis=1)[..., None])[..., 0]
        left = of_given - (given @ mean[:, None, :, None])[..., 0]
        effect = (A @ left[..., None])[..., 0]
        at = (mean[:, None] + effect)[:, self.slot]
        distance = (
            of_yy
            - 2.0 * (at * of_y).sum(axis=2)
            + (at * (self.forms[:, :, 0] @ at[..., None])[..., 0]).sum(axis=2)
        )
        chi = (w * distance).sum(axis=1) + (effect * left).sum(axis=(1, 2))
        sigma_2 = (DF_0 + chi) / self.df
        return _FitsAt(
            spread=spread,
            mean=mean,
            spread_of_mean=spread_of_mean,
            effect=effect,
            given=given,
            sigma_2=sigma_2,
            distance=distance / sigma_2[:, None],
        )

    def _spread(self, w: Array) -> Array:
        """Return the moderated spread of designs in each line, over that of all [1].

        Each design counts with its weight w.
        """
        w = w[..., None] * (self.number > 0.0)
        average = (w * self.middle).sum(axis=1) / np.maximum(w.sum(axis=1), 1e-300)
        squares = (w * np.square(self.middle - average[:, None])).sum(axis=1)
        df = np.maximum((self.number > 0.0).sum(axis=1) - 1.0, 0.0)
        common = squares.sum(axis=1) / np.maximum(df.sum(axis=1), 1.0)
        common = common[:, None]
        over = np.divide(squares, common, out=df.copy(), where=common > 0.0)
        return np.asarray(np.sqrt((WITNESSES + over) / (WITNESSES + df)))


def _technology(q: int) -> Array:
    """Return A, the covariance of the effects of a technology over sigma^2 r r'."""
    v, rho = LEVELS["technology"]
    return np.asarray(v * (rho + (1.0 - rho) * np.eye(q)))


def _alike(rows: Sequence[LogLine], columns: Sequence[LogLine]) -> Array:
    """Return N of figures of one design, shape (rows, columns)."""
    same_line = _same([f.line for f in rows], [f.line for f in columns])
    return np.asarray(
        sum(
            v
            * _same([f.groups[level] for f in rows], [f.groups[level] for f in columns])
            * (rho + (1.0 - rho) * same_line)
            for level, (v, rho) in list(enumerate(LEVELS.values()))[DESIGN:]
        )
    )


@lru_cache(maxsize=512)
def figures_of(device: Device) -> dict[Name, LogLine]:
    """Return the expected lines that a device gives: not to be changed."""
    return {
        Name(source.expected, owner=sensor.kind): _figure(
            device, sensor.kind, source, float(np.log(u))
        )
        for sensor in device.sensors
        for source in stand_ins(sensor.kind)
        if (line := sensor.line(source.name)) is not None and (u := line.largest) > 0.0
    }


def figure_of(device: Device, name: Name) -> LogLine:
    """Return an expected line of a device that is not given."""
    return _figure(device, name.owner, stand_in(name), 0.0)


@cache
def stand_in(name: Name) -> Source:
    """Return the line that stands for an expected one: of noises a random walk."""
    own = (one for one in stand_ins(name.owner) if one.expected == name.quantity)
    return next(own, None) or source_of(name.owner, name.quantity)


@cache
def stand_ins(kind: str) -> tuple[Source, ...]:
    """Return the lines that stand for all expected ones."""
    first: dict[str, Source] = {}
    for line in lines_of(kind):
        if line.expected:
            first.setdefault(line.expected, line)
    return tuple(first.values())


def _figure(device: Device, kind: str, source: Source, log_u: float) -> LogLine:
    """Return a line of a device; one of like unit is compared across sensors."""
    units = {source.like(each) for each in SENSORS}
    design = _design(device)
    quantity = source.expected or source.name
    own = f"{design}, {device.name}"
    return LogLine(
        # Of a technology that is not told nobody knows what is like it.
        groups=(known_family(device) or design, design, own, f"{own}, {kind}"),
        line=quantity if len(units) == 1 else f"{quantity} of the {kind}",
        device=device.name,
        log_u=log_u,
    )


@lru_cache(maxsize=2)
def _sorted(
    devices: tuple[Device, ...],
) -> tuple[dict[str, list[Device]], dict[str, list[Device]]]:
    """Return devices by the name on their sheet, and by their design."""
    by_name: dict[str, list[Device]] = {}
    by_design: dict[str, list[Device]] = {}
    for one in devices:
        by_name.setdefault(one.as_printed, []).append(one)
        by_design.setdefault(_design(one), []).append(one)
    return by_name, by_design


@lru_cache(maxsize=2)
def _others(devices: tuple[Device, ...]) -> Others:
    """Return all figures of devices by their design."""
    return Others.of(_figures(devices))


def _design(device: Device) -> str:
    """Return what a device is a variant of: its file, without one itself."""
    return device.origin.sha256 or device.name


def _figures(devices: Iterable[Device]) -> list[LogLine]:
    """Return all figures that devices give."""
    return [each for one in devices for each in figures_of(one).values()]


def _same(rows: Sequence[str], columns: Sequence[str]) -> Array:
    """Return 1 where two texts are the same, else 0, shape (rows, columns)."""
    codes = {text: k for k, text in enumerate(dict.fromkeys((*rows, *columns)))}
    a = np.array([codes[text] for text in rows])
    b = np.array([codes[text] for text in columns])
    return np.asarray(a[:, None] == b[None, :], dtype=float)
