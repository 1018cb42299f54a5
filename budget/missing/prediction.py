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

from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt
from typing import TYPE_CHECKING, Self

import numpy as np

from budget.methods.execution import small_blocks
from budget.missing.grades import FAMILIES, family
from budget.model.sources import SENSORS, lines_of, source_of
from budget.names import Name

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

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
    same = [one for one in catalogue if one.as_printed == device.as_printed]
    if same:  # also out of another file: the same data sheet is no other witness
        device = replace(device, origin=same[0].origin)
    meant = device if technology is None else replace(device, technology=technology)
    wanted = {name: figure_of(meant, name) for name in missing}
    if not technology and [figures_of(one) for one in same] == [figures_of(device)]:
        return _fit(tuple(catalogue)).predict(wanted)
    others = [one for one in catalogue if one not in same]
    if technology:
        near = _fit(tuple(catalogue) if same else (*others, device))
        return Fit.of(_figures((*others, meant)), near=near).predict(wanted)
    return _fit((*others, device)).predict(wanted)


def predict_figures(
    given: Sequence[LogLine], wanted: dict[Name, LogLine]
) -> Prediction | None:
    """Predict figures from others; arguments as of `predict`."""
    return Fit.of(given).predict(wanted)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Given figures, and what every prediction from them needs."""

    given: tuple[LogLine, ...]
    spread: dict[str, float]  # of each line [1]
    trust: dict[str, float]  # w of each design [1]
    mean: Array  # of each line, in the order of `spread`, shape (q,) [ln SI]
    spread_of_mean: Array  # its covariance over sigma^2, shape (q, q)
    inverse: Array  # of the covariance over sigma^2, shape (n, n)
    inverse_lines: Array  # times H, shape (n, q)
    weights: Array  # the inverse times what is left of the logarithms, shape (n,)
    df: float
    sigma_2: float

    @classmethod
    def of(cls, given: Sequence[LogLine], *, near: Fit | None = None) -> Self:
        """Fit scale and weights to figures; soon, where one is `near` that of them."""
        alike = _alike(given, given)
        trust = dict.fromkeys((each.groups[DESIGN] for each in given), 1.0)
        with small_blocks():
            fit = cls._at(given, alike, trust | (near.trust if near else {}))
            for _ in range(ROUNDS_NEAR if near else ROUNDS):
                fit = cls._at(given, alike, fit.reweighted(alike))
        return fit

    @classmethod
    def _at(
        cls,
        given: Sequence[LogLine],
        alike: tuple[Array, Array],
        trust: dict[str, float],
    ) -> Self:
        """Fit the scale at weights of designs."""
        spread = spreads(given, trust)
        y = np.array([each.log_u for each in given])
        inverse = np.asarray(
            np.linalg.inv(_scaled(alike, given, given, spread, trust).sum(axis=0))
        )
        lines = _lines(given, spread)
        inverse_lines = inverse @ lines
        spread_of_mean = np.asarray(np.linalg.inv(lines.T @ inverse_lines))
        mean = spread_of_mean @ (inverse_lines.T @ y)
        left = y - lines @ mean
        weights = inverse @ left
        df = DF_0 + len(given) - len(spread)
        return cls(
            given=tuple(given),
            spread=spread,
            trust=trust,
            mean=mean,
            spread_of_mean=spread_of_mean,
            inverse=inverse,
            inverse_lines=inverse_lines,
            weights=weights,
            df=df,
            sigma_2=(DF_0 + float(left @ weights)) / df,
        )

    def reweighted(self, alike: tuple[Array, Array]) -> dict[str, float]:
        """Return E[w] of each design at this fit.

        e = R/w K^-1 (y - H m), so d^2 sigma^2 is e' K^-1 (y - H m)/w.
        """
        own = _scaled(alike, self.given, self.given, self.spread, self.trust)[1]
        parts = self.weights * (own @ self.weights) / self.sigma_2
        number, distance = dict.fromkeys(self.trust, 0), dict.fromkeys(self.trust, 0.0)
        for each, part in zip(self.given, parts.tolist(), strict=True):
            number[each.groups[DESIGN]] += 1
            distance[each.groups[DESIGN]] += part
        return {
            design: (TAILS + number[design]) / (TAILS + distance[design] / w)
            for design, w in self.trust.items()
        }

    def predict(self, wanted: dict[Name, LogLine]) -> Prediction | None:
        """Predict figures; None where too few designs give any of them."""
        found = _witnesses(self.given, wanted)
        if not found:
            return None
        names = tuple(found)
        new = [wanted[name] for name in names]
        across = covariance(new, self.given, self.spread, self.trust)
        lines = _lines(new, self.spread)
        with small_blocks():
            off = lines - across @ self.inverse_lines
            scale = (
                covariance(new, new, self.spread, self.trust)
                - across @ self.inverse @ across.T
                + off @ self.spread_of_mean @ off.T
            )
            location = lines @ self.mean + across @ self.weights
        own = [
            sum(each.groups[DESIGN] == one.groups[DESIGN] for each in self.given)
            for one in new
        ]
        return Prediction(
            names=names,
            location=location,
            scale=self.sigma_2 * (scale + scale.T) / 2.0,
            df=min(self.df, TAILS + min(own)),
            devices=tuple(
                tuple(dict.fromkeys(each.device for each in those))
                for those in found.values()
            ),
            designs=tuple(
                len({each.groups[DESIGN] for each in those}) for those in found.values()
            ),
        )


def _witnesses(
    given: Sequence[LogLine], wanted: dict[Name, LogLine]
) -> dict[Name, list[LogLine]]:
    """Return who else gives each line, where that are designs enough."""
    witnesses = {
        name: [
            each
            for each in given
            if each.line == one.line and each.groups[DESIGN] != one.groups[DESIGN]
        ]
        for name, one in wanted.items()
    }
    return {
        name: those
        for name, those in witnesses.items()
        if len({each.groups[DESIGN] for each in those}) >= LEAST_DESIGNS
    }


def spreads(given: Sequence[LogLine], trust: dict[str, float]) -> dict[str, float]:
    """Return the moderated spread of designs in each line, over that of all [1].

    Each design counts with its weight w.
    """
    sizes: dict[str, dict[str, list[float]]] = {}
    for each in given:
        sizes.setdefault(each.line, {}).setdefault(each.groups[DESIGN], []).append(
            each.log_u
        )
    squares, df = {}, {}
    for line, designs in sizes.items():
        means = np.array([np.mean(values) for values in designs.values()])
        w = np.array([trust[design] for design in designs])
        squares[line] = float(
            (w * np.square(means - np.average(means, weights=w))).sum()
        )
        df[line] = len(means) - 1
    common = sum(squares.values()) / max(sum(df.values()), 1)
    if common == 0.0:
        return dict.fromkeys(sizes, 1.0)
    return {
        line: sqrt((WITNESSES + squares[line] / common) / (WITNESSES + df[line]))
        for line in sizes
    }


def covariance(
    rows: Sequence[LogLine],
    columns: Sequence[LogLine],
    spread: dict[str, float],
    trust: dict[str, float],
) -> Array:
    """Return the covariance of figures over sigma^2, shape (rows, columns)."""
    both = _scaled(_alike(rows, columns), rows, columns, spread, trust)
    return np.asarray(both.sum(axis=0))


def _scaled(
    alike: tuple[Array, Array],
    rows: Sequence[LogLine],
    columns: Sequence[LogLine],
    spread: dict[str, float],
    trust: dict[str, float],
) -> Array:
    """Return what technology, and what design and all within it, add to that."""
    r_rows, r_columns = ([spread[f.line] for f in those] for those in (rows, columns))
    w_rows, w_columns = (
        np.array([trust.get(f.groups[DESIGN], 1.0) for f in those])
        for those in (rows, columns)
    )
    wide, narrow = alike
    narrow = narrow / np.sqrt(np.outer(w_rows, w_columns))
    return np.stack([wide, narrow]) * np.outer(r_rows, r_columns)


def _alike(rows: Sequence[LogLine], columns: Sequence[LogLine]) -> tuple[Array, Array]:
    """Return the same for spreads and weights of 1, (rows, columns) each."""
    same_line = _same([f.line for f in rows], [f.line for f in columns])
    parts = [
        v
        * _same([f.groups[level] for f in rows], [f.groups[level] for f in columns])
        * (rho + (1.0 - rho) * same_line)
        for level, (v, rho) in enumerate(LEVELS.values())
    ]
    return sum(parts[:DESIGN], 0.0 * same_line), sum(parts[DESIGN:], 0.0 * same_line)


def figures_of(device: Device) -> dict[Name, LogLine]:
    """Return the expected lines that a device gives."""
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


def stand_in(name: Name) -> Source:
    """Return the line that stands for an expected one: of noises a random walk."""
    own = (one for one in stand_ins(name.owner) if one.expected == name.quantity)
    return next(own, None) or source_of(name.owner, name.quantity)


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
    design = device.origin.sha256 or device.name
    quantity = source.expected or source.name
    own = f"{design}, {device.name}"
    known = family(device.technology)
    known = known if known in FAMILIES else ""
    return LogLine(
        # Of a technology that is not told nobody knows what is like it.
        groups=(known or design, design, own, f"{own}, {kind}"),
        line=quantity if len(units) == 1 else f"{quantity} of the {kind}",
        device=device.name,
        log_u=log_u,
    )


@lru_cache(maxsize=2)
def _fit(devices: tuple[Device, ...]) -> Fit:
    """Return the fit of all figures of devices."""
    return Fit.of(_figures(devices))


def _figures(devices: Iterable[Device]) -> list[LogLine]:
    """Return all figures that devices give."""
    return [each for one in devices for each in figures_of(one).values()]


def _lines(figures: Sequence[LogLine], spread: dict[str, float]) -> Array:
    """Return H: 1 where a figure is of a line, shape (n, q)."""
    return _same([each.line for each in figures], list(spread))


def _same(rows: Sequence[str], columns: Sequence[str]) -> Array:
    """Return 1 where two texts are the same, else 0, shape (rows, columns)."""
    codes = {text: k for k, text in enumerate(dict.fromkeys((*rows, *columns)))}
    a = np.array([codes[text] for text in rows])
    b = np.array([codes[text] for text in columns])
    return np.asarray(a[:, None] == b[None, :], dtype=float)
