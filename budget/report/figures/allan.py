"""Allan deviation of the noise that a data sheet gives, and what a test averages.

Of every line it is that of the model's own process: sigma^2(tau) is half the expected
square of the difference of two averages over tau, one right after the other (IEEE Std
952-2020, annex C). So N^2/tau of white noise, K^2 tau/3 of a random walk, 3 Q^2/tau^2
of rounding with Q^2 = q^2/12, about (2 ln 2/pi) B^2 of flicker; and that of a
first-order Gauss-Markov process, which IEEE 952 has as correlated noise. It is no
standard deviation of an average but of white noise: what is slower than the window
shifts both averages alike. That of an average beside it is what a budget counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import ceil, floor, log10, sqrt
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.schemes import calibrates, schedule_of
from budget.inputs.records import AXES, UNCALIBRATED
from budget.language import words
from budget.model.source import Noise
from budget.model.sources import source_of
from budget.model.windows import Schedule, Window
from budget.names import Name
from budget.report.figures.curves import name_lines, write_apart
from budget.report.figures.style import (
    HATCH,
    INK,
    Scale,
    add_plane,
    blank,
    in_order,
    look_of,
)
from budget.report.figures.tabled import Plot, alternative_of_curves
from budget.report.pages import figure, line
from budget.report.tables import round_uncertainty, source_title
from budget.ties import first_largest
from budget.units import DEG_PER_HOUR, MICRO_G

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.model.noise import Process
    from budget.report.figures.curves import Place

READ_IN = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}
ABOVE, HEIGHT, BELOW, LEFT, RIGHT = 42.0, 160.0, 34.0, 52.0, 112.0  # [pt]
PER_DECADE = 12  # averaging times
LONGER, SLOWER = 10.0, 3.0  # than windows, than correlation times: end of the axis [1]
MOST_TIME = 1e6  # [s]
BELOW_SUM = 30.0  # of the vertical axis, from the least of the sum down [1]
MARKS = 3  # windows of different lengths at the most
APART = 1.05  # of windows of different lengths [1]
SIGMA = "\N{GREEK SMALL LETTER SIGMA}"
PAGE = "figures_allan"


@dataclass(frozen=True, kw_only=True)
class WindowMark:
    """Windows of one length: the Allan deviation over it, and u of their averages."""

    length: float  # [s]
    windows: int
    sigma: float  # Allan deviation over that length [SI]
    parts: dict[Name, float]  # variance of the last one's average, by line [SI squared]

    @property
    def average(self) -> float:
        """Standard uncertainty of the last one's average by this noise [SI]."""
        return sqrt(sum(self.parts.values()))


@dataclass(frozen=True, kw_only=True)
class Allan:
    """Allan deviations of one axis of a triad, by line and together."""

    sensor: str
    device: str
    axis: str  # that of most noise; '' where all are alike
    times: Array  # tau, shape (n,) [s]
    deviations: dict[Name, Array]  # by line, shape (n,) [SI]
    marks: tuple[WindowMark, ...]  # the longest first

    @classmethod
    def of(cls, sensor: Sensor, procedure: Procedure) -> Allan | None:
        """Take it from the lines that are noise; None where none is."""
        found = _processes(sensor, procedure.sample_rate)
        if not any(found):
            return None
        windows = _windows(sensor.kind, procedure)
        slow = [
            float(np.max(one.correlation_time))
            for one in sensor.lines
            if one.correlation_time is not None
        ]
        last = max([LONGER * own[-1].length for own in windows] + [1e3])
        last = min(max([last, *(SLOWER * tau for tau in slow)]), MOST_TIME)
        decades = floor(log10(1.0 / procedure.sample_rate)), ceil(log10(last))
        times = np.logspace(*decades, PER_DECADE * (decades[1] - decades[0]) + 1)
        at = windows[0][-1].length if windows else 1.0
        whole = [
            sum(float(allan_variance(one, [at])[0]) for one in axis.values())
            for axis in found
        ]
        chosen = found[first_largest(whole)]
        return cls(
            sensor=sensor.kind,
            device=sensor.device,
            axis="" if np.ptp(whole) == 0.0 else AXES[first_largest(whole)],
            times=times,
            deviations={
                name: np.sqrt(allan_variance(chosen[name], times))
                for name in in_order(chosen)
            },
            marks=tuple(
                WindowMark(
                    length=own[-1].length,
                    windows=len(own),
                    sigma=sum(
                        float(allan_variance(one, [own[-1].length])[0])
                        for one in chosen.values()
                    )
                    ** 0.5,
                    parts={
                        name: float(one.reduce(last, np.eye(1))[0, 0])
                        for name, one in chosen.items()
                    },
                )
                for own in windows
                for last in [Schedule(windows=(max(own, key=attrgetter("start")),))]
            ),
        )

    @property
    def whole(self) -> Array:
        """The root of the sum of squares of all lines, shape (n,) [SI]."""
        squares = [one**2 for one in self.deviations.values()]
        return np.asarray(np.sqrt(np.sum(squares, axis=0)))

    @property
    def unit(self) -> tuple[str, float]:
        """What it is read in, and its size [SI]."""
        return READ_IN[self.sensor]

    @property
    def top(self) -> tuple[Name, float, float, float]:
        """What makes most: line, share of the variance, time [s], its root [SI].

        Of an average over the longest windows; without any, of the Allan variance where
        that is least.
        """
        least = int(np.argmin(self.whole))
        parts = {name: float(one[least]) ** 2 for name, one in self.deviations.items()}
        time = float(self.times[least])
        if self.marks:
            time, parts = self.marks[0].length, self.marks[0].parts
        top = [*parts][first_largest([*parts.values()])]
        whole = sum(parts.values())
        return top, parts[top] / whole, time, whole**0.5


def allan_variance(process: Process, times: Sequence[float] | Array) -> Array:
    """Return half the expected square of differences of adjacent averages [SI squared].

    Shape (n,), of averages over the times [s].
    """
    apart = np.array([[-1.0, 1.0]])
    found = []
    for tau in map(float, times):
        two = (
            Window(name="first", start=0.0, length=tau),
            Window(name="second", start=tau, length=tau),
        )
        found.append(0.5 * process.reduce(Schedule(windows=two), apart)[0, 0])
    return np.maximum(found, 0.0)


def _processes(sensor: Sensor, sample_rate: float) -> list[dict[Name, Process]]:
    """Return the process of each line that is noise, for each axis."""
    found: list[dict[Name, Process]] = [{} for _ in AXES]
    for one in sensor.lines:
        effect = source_of(sensor.kind, one.name).meant(one).effect
        if isinstance(effect, Noise):
            for axis in range(len(AXES)):
                if one.u[axis] > 0.0:
                    name = Name(one.name, owner=sensor.kind)
                    found[axis][name] = effect.process(one, axis, sample_rate)
    return found


def _windows(sensor: str, procedure: Procedure) -> list[list[Window]]:
    """Return the windows of a test by length, each group rising.

    The longest first, of many lengths those of most windows.
    """
    if procedure.formulas in UNCALIBRATED or not calibrates(sensor, procedure):
        return []
    groups: list[list[Window]] = []
    for one in sorted(schedule_of(sensor, procedure).windows, key=attrgetter("length")):
        if groups and one.length <= APART * groups[-1][0].length:
            groups[-1].append(one)
        else:
            groups.append([one])
    most = sorted(groups, key=len, reverse=True)[:MARKS]
    return sorted(most, key=lambda own: own[-1].length, reverse=True)


def allan_plot(allan: Allan) -> Plot:
    """Show the noise of a data sheet over averaging time, and where a test averages."""
    (name, share, time, size), (unit, scale) = allan.top, allan.unit
    told, table = figure(
        PAGE,
        "allan",
        allan=allan,
        sensor=words(allan.sensor),
        size=f"{round_uncertainty(size / scale)} {unit}",
        time=time,
        source=source_title(name),
        share=share,
        names=[source_title(one) for one in allan.deviations],
        rows=[
            (
                float(allan.times[k]),
                [float(one[k]) / scale for one in allan.deviations.values()],
                float(allan.whole[k]) / scale,
            )
            for k in range(0, allan.times.size, PER_DECADE)
        ],
        scale=scale,
    )
    more = [line(PAGE, "mark", one=one, scale=scale) for one in allan.marks]
    return Plot(
        name=f"allan-{allan.sensor}",
        said=told,
        table=table,
        draw=lambda: _draw(allan, told),
        alt=alternative_of_curves(told.title, table, more),
    )


def _draw(allan: Allan, told: SimpleNamespace) -> Figure:
    """Draw each line, their sum, and the windows of the test, all logarithmic."""
    scale = allan.unit[1]
    whole = allan.whole / scale
    curves = {name: one / scale for name, one in allan.deviations.items()}
    least = float(whole.min()) / BELOW_SUM
    seen = [float(one.min()) for one in curves.values() if one.max() > least]
    low = max(min(seen) / 2.0, least)
    high = 2.0 * max(whole.max(), *(one.average / scale for one in allan.marks), 0.0)
    log = partial(Scale, kind="log", most=9)
    drawing = blank(ABOVE + HEIGHT + BELOW)
    axes = add_plane(
        drawing,
        log(low=allan.times[0], high=allan.times[-1], label=told.time_axis),
        log(low=low, high=high, label=told.axis),
        left=LEFT,
        top=ABOVE,
        right=RIGHT,
        height=HEIGHT,
    )
    drawn: list[tuple[str, Array, dict[str, Any]]] = [
        (
            source_title(name),
            one,
            {"color": colour, "linewidth": 1.3, "linestyle": dash},
        )
        for name, one in curves.items()
        if one.max() > low
        for colour, hatch, _ in [look_of(name)]
        for dash in ["--" if hatch == HATCH else "-"]
    ]
    if len(curves) > 1:
        drawn.append(
            (told.whole, whole, {"color": INK, "linewidth": 2.0, "linestyle": ":"})
        )
    for _, one, properties in drawn:
        axes.plot(allan.times, one, **properties)
    ends = [(float(one[-1]), title) for title, one, _ in drawn]
    name_lines(axes, ends, {title: properties for title, _, properties in drawn})
    texts: list[tuple[str, Sequence[Place]]] = []
    for mark in allan.marks:
        text = line(PAGE, "window", length=mark.length)
        axes.axvline(mark.length, color=INK, linewidth=0.8, linestyle="--")
        for name, size, inside, width in (
            (SIGMA, mark.sigma / scale, INK, 3.5),
            ("u", mark.average / scale, "none", 7.0),
        ):
            look: dict[str, Any] = {"markerfacecolor": inside, "markeredgecolor": INK}
            axes.plot(mark.length, size, "o", markersize=width, **look)
            text += f"\n{name} {round_uncertainty(size)}"
        texts.append((text, [((mark.length, high), 0.0, 1.0)]))
    write_apart(axes, texts, everywhere=True)
    return drawing
