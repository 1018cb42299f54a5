"""Allan deviation of the noise that a data sheet gives, and what a test averages.

Of every line it is that of the model's own process: sigma^2(tau) is half the expected
square of the difference of two averages over tau, one right after the other (IEEE Std
952-2020, annex C). So N^2/tau of white noise, K^2 tau/3 of a random walk, 3 Q^2/tau^2
of rounding with Q^2 = q^2/12, about (2 ln 2/pi) B^2 of flicker; and that of a
first-order Gauss-Markov process, which IEEE 952 has as correlated noise.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from math import ceil, floor, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.schemes import calibrates, schedule_of
from budget.inputs.records import AXES, UNCALIBRATED
from budget.language import words
from budget.model.source import Noise
from budget.model.sources import source_of
from budget.model.windows import Schedule, Window
from budget.names import Name
from budget.report.figures.lines import name_lines
from budget.report.figures.style import (
    GRID,
    HATCH,
    INK,
    MUTED,
    SMALL,
    WIDTH,
    add_panel,
    as_picture,
    blank,
    house_style,
    in_order,
    log_ticks,
    look_of,
    text_width,
    write,
)
from budget.report.pages import blocks, line
from budget.report.tables import round_uncertainty, source_title
from budget.ties import first_largest
from budget.units import DEG_PER_HOUR, MICRO_G

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.model.noise import Process
    from budget.report.blocks import Picture

READ_IN = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}
ABOVE, HEIGHT, BELOW, LEFT, RIGHT = 30.0, 160.0, 34.0, 52.0, 112.0  # [pt]
PER_DECADE = 12  # averaging times
LONGER, SLOWER = 10.0, 3.0  # than windows, than correlation times: end of the axis [1]
MOST_TIME = 1e6  # [s]
BELOW_SUM = 30.0  # of the vertical axis, from the least of the sum down [1]
MARKS = 3  # windows of different lengths at the most
APART = 1.05  # of windows of different lengths [1]
said = partial(line, "figures_allan")


@dataclass(frozen=True, kw_only=True)
class Mark:
    """Windows of one length, and what the noise of their averages is."""

    length: float  # [s]
    windows: int
    sigma: float  # Allan deviation over that length [SI]


@dataclass(frozen=True, kw_only=True)
class Allan:
    """Allan deviations of one axis of a triad, by line and together."""

    sensor: str
    device: str
    axis: str  # that of most noise; '' where all are alike
    times: Array  # tau, shape (n,) [s]
    deviations: dict[Name, Array]  # by line, shape (n,) [SI]
    marks: tuple[Mark, ...]  # the longest first

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
        last = max([LONGER * length for length, _ in windows] + [1e3])
        last = min(max([last, *(SLOWER * tau for tau in slow)]), MOST_TIME)
        decades = floor(log10(1.0 / procedure.sample_rate)), ceil(log10(last))
        times = np.logspace(*decades, PER_DECADE * (decades[1] - decades[0]) + 1)
        at = windows[0][0] if windows else 1.0
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
                Mark(
                    length=length,
                    windows=number,
                    sigma=sum(
                        float(allan_variance(one, [length])[0])
                        for one in chosen.values()
                    )
                    ** 0.5,
                )
                for length, number in windows
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
        """What makes most: line, share of the variance, time [s], sigma of all [SI].

        Over the longest windows; without any, where the sum is least.
        """
        least = int(np.argmin(self.whole))
        time = self.marks[0].length if self.marks else float(self.times[least])
        place = int(np.argmin(np.abs(np.log(self.times / time))))
        parts = [float(one[place]) ** 2 for one in self.deviations.values()]
        names = [*self.deviations]
        top = first_largest(parts)
        sigma = self.marks[0].sigma if self.marks else float(self.whole[least])
        return names[top], parts[top] / sum(parts), time, sigma


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


def _windows(sensor: str, procedure: Procedure) -> list[tuple[float, int]]:
    """Return lengths of the windows of a test [s], and how many are so long.

    The longest first, of many lengths those of most windows.
    """
    if procedure.formulas in UNCALIBRATED or not calibrates(sensor, procedure):
        return []
    lengths = sorted(one.length for one in schedule_of(sensor, procedure).windows)
    groups: list[list[float]] = []
    for length in lengths:
        if groups and length <= APART * groups[-1][0]:
            groups[-1].append(length)
        else:
            groups.append([length])
    most = Counter({group[-1]: len(group) for group in groups}).most_common(MARKS)
    return sorted(most, reverse=True)


def allan_picture(allan: Allan) -> Picture:
    """Show the noise of a data sheet over averaging time, and where a test averages."""
    title, scale = allan_title(allan), allan.unit[1]
    whole = allan.whole / scale
    rows = [
        (
            float(allan.times[k]),
            [float(one[k]) / scale for one in allan.deviations.values()],
            float(whole[k]),
        )
        for k in range(0, allan.times.size, PER_DECADE)
    ]
    names = [source_title(name) for name in allan.deviations]
    data: Any = blocks("figures_allan", "data", allan=allan, names=names, rows=rows)[0]
    return as_picture(
        draw_allan(allan),
        name=f"allan-{allan.sensor}",
        title=title,
        alt=said(
            "alt",
            title=title,
            allan=allan,
            rows=[
                (name, _print(one[0] / scale), _print(one[-1] / scale))
                for name, one in zip(names, allan.deviations.values(), strict=True)
            ],
            marks=[(one, _print(one.sigma / scale)) for one in allan.marks],
        ),
        caption=said("caption", allan=allan),
        data=data,
        data_on_paper=False,
    )


def allan_title(allan: Allan) -> str:
    """State the finding: what is left of the noise in an average, and of which line."""
    name, share, time, sigma = allan.top
    unit, scale = allan.unit
    return said(
        "title",
        sensor=words(allan.sensor),
        size=f"{_print(sigma / scale)} {unit}",
        time=time,
        source=source_title(name),
        share=share,
        is_averaged=bool(allan.marks),
    )


@house_style()
def draw_allan(allan: Allan) -> Figure:
    """Draw each line, their sum, and the windows of the test, all logarithmic."""
    unit, scale = allan.unit
    figure = blank(ABOVE + HEIGHT + BELOW)
    figure.set_label(allan_title(allan))
    axes = add_panel(
        figure, left=LEFT, top=ABOVE, width=WIDTH - LEFT - RIGHT, height=HEIGHT
    )
    axes.tick_params(axis="y", labelsize=SMALL, labelcolor=MUTED)
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(allan.times[0], allan.times[-1])
    whole = allan.whole / scale
    low, high = float(whole.min()) / BELOW_SUM, 2.0 * float(whole.max())
    seen = [
        float(one.min()) / scale
        for one in allan.deviations.values()
        if one.max() / scale > low
    ]
    axes.set_ylim(max(low, min(seen) / 2.0), high)
    names: list[tuple[float, str]] = []
    looks: dict[str, dict[str, Any]] = {}
    for name, one in allan.deviations.items():
        title, (colour, hatch, _) = source_title(name), look_of(name)
        if float(one.max()) / scale <= axes.get_ylim()[0]:
            continue
        looks[title] = {
            "color": colour,
            "linewidth": 1.3,
            "linestyle": "--" if hatch == HATCH else "-",
        }
        axes.plot(allan.times, one / scale, **looks[title])
        names.append((float(one[-1]) / scale, title))
    if len(allan.deviations) > 1:
        title = said("whole")
        looks[title] = {"color": INK, "linewidth": 2.0, "linestyle": ":"}
        axes.plot(allan.times, whole, **looks[title])
        names.append((float(whole[-1]), title))
    _draw_marks(axes, allan, scale)
    name_lines(axes, names, looks)
    for axis in (axes.xaxis, axes.yaxis):
        log_ticks(axis, most=9)
    axes.minorticks_off()
    axes.set_xlabel(said("time_axis"), fontsize=SMALL, color=MUTED)
    axes.set_ylabel(said("axis", unit=unit), fontsize=SMALL, color=MUTED)
    return figure


def _draw_marks(axes: Axes, allan: Allan, scale: float) -> None:
    """Mark the windows of the test, and write the sigma of their averages above."""
    taken: list[tuple[float, float]] = []
    width = WIDTH - LEFT - RIGHT
    for one in allan.marks:
        value = one.sigma / scale
        axes.axvline(one.length, color=INK, linewidth=0.8, linestyle="--")
        axes.plot(one.length, value, marker="o", color=INK, markersize=4.5)
        text = f"{said('window', length=one.length)}\n{_print(value)}"
        half = max(map(text_width, text.split("\n"))) / 2.0 + 2.0
        to_axes = axes.transData + axes.transAxes.inverted()
        at = width * float(to_axes.transform((one.length, value))[0])
        if all(at + half <= start or at - half >= end for start, end in taken):
            taken.append((at - half, at + half))
            write(
                axes,
                text,
                (one.length, 1.0),
                (0.0, 4.0),
                ha="center",
                va="bottom",
                coords=("data", "axes fraction"),
            )


def _print(size: float) -> str:
    """Print a deviation to two digits."""
    return round_uncertainty(float(size))
