"""Prediction of lines that a data sheet does not give, from those of other devices.

The logarithm y of the standard uncertainty of a line is taken as normal, about a mean
of its own for every line, with effects of the technology, the design (a file), the
device (a variant) and the sensor (LEVELS):

    y = mu(line) + sum over levels of e(group, line),
    cov(e(g, l), e(g, l')) = sigma^2 r(l) r(l') v (rho + (1 - rho) [l = l'])

rho says that what is good in one line tends to be good in the others, so that given
lines of a device predict those that it lacks; v, that devices of one design, or of one
technology, are no independent witnesses; r, that designs differ more in some lines than
in others: their variance about the mean of the line over that of all lines, moderated
by it with the weight of WITNESSES designs (Smyth 2004).

With a flat prior of mu and sigma^2 ~ Inv-chi^2(DF_0, 1), of n given lines y, H telling
which line each is and K their covariance over sigma^2 with FLAT H H' in it, those that
are missing, with k the covariance to the given ones, are a multivariate Student t (BDA,
chapters 14 and 15):

    location k' K^-1 y, scale s^2 (k0 - k' K^-1 k), df = DF_0 + n - lines,
    s^2 = (DF_0 + y' K^-1 y) / df

Of one line and designs with nothing in common that is the t of a new observation of
ordinary regression, s^2 (1 + x0 (X'X)^-1 x0') (Seber, Lee, 5.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.model.sources import SENSORS, lines_of
from budget.names import Name
from budget.studies.grades import family

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.model.source import Source
    from budget.spec.records import Device

# Variance over that of designs, and correlation of the lines of one group, for each
# level from the widest to the narrowest: assumptions, round numbers near the largest
# likelihood of the catalogue, which is flat about them. The scale sigma is estimated.
LEVELS = {
    "technology": (0.25, 0.5),
    "design": (1.0, 0.5),
    "device": (0.1, 0.75),
    "sensor": (0.1, 0.75),
}
DF_0 = 2.0  # weight of the prior sigma^2 = 1, of a factor e, in observations
WITNESSES = 5.0  # weight of the common spread of designs, in designs
FLAT = 1e4  # variance of the prior of mu over sigma^2: says nothing
# Designs that give a line, of which one more can be predicted: fewer say nothing of
# the spread between designs.
LEAST_DESIGNS = 3


@dataclass(frozen=True, kw_only=True)
class Figure:
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
    df: float  # degrees of freedom
    # For each line: devices that give it, and designs that these are of.
    devices: tuple[tuple[str, ...], ...]
    designs: tuple[int, ...]

    @property
    def median(self) -> Array:
        """Medians of the standard uncertainties, shape (n,) [SI]."""
        return np.exp(self.location)

    def interval(self, probability: float) -> Array:
        """Return the central interval of each line, shape (n, 2) [SI]."""
        from scipy.special import stdtrit

        half = stdtrit(self.df, (1.0 + probability) / 2.0) * np.sqrt(
            np.diag(self.scale)
        )
        ends = np.stack([self.location - half, self.location + half], axis=1)
        return np.asarray(np.exp(ends))

    def of(self, names: Sequence[Name]) -> Prediction:
        """Return the marginal of some of the lines."""
        kept = [place for place, name in enumerate(self.names) if name in names]
        return Prediction(
            names=tuple(self.names[place] for place in kept),
            location=self.location[kept],
            scale=self.scale[np.ix_(kept, kept)],
            df=self.df,
            devices=tuple(self.devices[place] for place in kept),
            designs=tuple(self.designs[place] for place in kept),
        )


def predict(
    device: Device, missing: Sequence[Name], catalogue: Sequence[Device]
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

    Returns
    -------
    Prediction or None
        None where no line can be predicted.
    """
    own = figures_of(device).values()
    mine = {(each.groups, each.line) for each in own}
    others = [
        each for each in _of(tuple(catalogue)) if (each.groups, each.line) not in mine
    ]
    wanted = {name: figure_of(device, name) for name in missing}
    return predict_figures([*others, *own], wanted)


def predict_figures(
    given: Sequence[Figure], wanted: dict[Name, Figure]
) -> Prediction | None:
    """Predict figures from others; arguments as of `predict`."""
    witnesses = {
        name: [
            each
            for each in given
            if each.line == one.line and each.groups[1] != one.groups[1]
        ]
        for name, one in wanted.items()
    }
    designs = {
        name: len({each.groups[1] for each in those})
        for name, those in witnesses.items()
    }
    names = tuple(name for name in wanted if designs[name] >= LEAST_DESIGNS)
    if not names:
        return None
    new = [wanted[name] for name in names]
    spread = spreads(given)
    known = covariance(given, given, spread)
    across = covariance(new, given, spread)
    y = np.array([each.log_u for each in given])
    solved = np.linalg.solve(known, np.column_stack([y, across.T]))
    df = DF_0 + len(given) - len({each.line for each in given})
    sigma_2 = (DF_0 + float(y @ solved[:, 0])) / df
    scale = covariance(new, new, spread) - across @ solved[:, 1:]
    return Prediction(
        names=names,
        location=across @ solved[:, 0],
        scale=sigma_2 * (scale + scale.T) / 2.0,
        df=df,
        devices=tuple(
            tuple(dict.fromkeys(each.device for each in witnesses[name]))
            for name in names
        ),
        designs=tuple(designs[name] for name in names),
    )


def spreads(given: Sequence[Figure]) -> dict[str, float]:
    """Return the moderated spread of designs in each line, over that of all [1]."""
    sizes: dict[str, dict[str, list[float]]] = {}
    for each in given:
        sizes.setdefault(each.line, {}).setdefault(each.groups[1], []).append(
            each.log_u
        )
    squares, df = {}, {}
    for line, designs in sizes.items():
        means = np.array([np.mean(values) for values in designs.values()])
        squares[line] = float(np.square(means - means.mean()).sum())
        df[line] = len(means) - 1
    common = sum(squares.values()) / max(sum(df.values()), 1)
    if common == 0.0:
        return dict.fromkeys(sizes, 1.0)
    return {
        line: sqrt((WITNESSES + squares[line] / common) / (WITNESSES + df[line]))
        for line in sizes
    }


def covariance(
    rows: Sequence[Figure], columns: Sequence[Figure], spread: dict[str, float]
) -> Array:
    """Return the covariance of figures over sigma^2, shape (rows, columns)."""
    same_line = _same([f.line for f in rows], [f.line for f in columns])
    total = FLAT * same_line
    for level, (v, rho) in enumerate(LEVELS.values()):
        same = _same(
            [f.groups[level] for f in rows], [f.groups[level] for f in columns]
        )
        total += v * same * (rho + (1.0 - rho) * same_line)
    r_rows, r_columns = ([spread[f.line] for f in those] for those in (rows, columns))
    return np.asarray(total * np.outer(r_rows, r_columns))


def figures_of(device: Device) -> dict[Name, Figure]:
    """Return the expected lines that a device gives."""
    return {
        Name(source.expected, owner=sensor.kind): _figure(
            device, sensor.kind, source, float(np.log(u))
        )
        for sensor in device.sensors
        for source in stand_ins(sensor.kind)
        if (line := sensor.line(source.name)) is not None
        and (u := float(line.u.max())) > 0.0
    }


def figure_of(device: Device, name: Name) -> Figure:
    """Return an expected line of a device that is not given."""
    return _figure(device, name.owner, stand_in(name), 0.0)


def stand_in(name: Name) -> Source:
    """Return the line that stands for an expected one: of noises a random walk."""
    return next(one for one in stand_ins(name.owner) if one.expected == name.quantity)


def stand_ins(kind: str) -> tuple[Source, ...]:
    """Return the lines that stand for all expected ones."""
    first: dict[str, Source] = {}
    for line in lines_of(kind):
        if line.expected:
            first.setdefault(line.expected, line)
    return tuple(first.values())


def _figure(device: Device, kind: str, source: Source, log_u: float) -> Figure:
    """Return a line of a device; one of like unit is compared across sensors."""
    units = {source.like(each) for each in SENSORS}
    design = device.origin.sha256 or device.name
    own = f"{design}, {device.name}"
    return Figure(
        # Of a technology that is not told nobody knows what is like it.
        groups=(family(device.technology) or design, design, own, f"{own}, {kind}"),
        line=source.expected if len(units) == 1 else f"{source.expected} of the {kind}",
        device=device.name,
        log_u=log_u,
    )


@lru_cache(maxsize=2)
def _of(catalogue: tuple[Device, ...]) -> tuple[Figure, ...]:
    """Return all figures of a catalogue."""
    return tuple(each for device in catalogue for each in figures_of(device).values())


def _same(rows: Sequence[str], columns: Sequence[str]) -> Array:
    """Return 1 where two texts are the same, else 0, shape (rows, columns)."""
    codes = {text: k for k, text in enumerate(dict.fromkeys((*rows, *columns)))}
    a = np.array([codes[text] for text in rows])
    b = np.array([codes[text] for text in columns])
    return np.asarray(a[:, None] == b[None, :], dtype=float)
