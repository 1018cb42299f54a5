"""The file of a target, filled in from its template, and each of its keys.

A target is one template in templates/export. What it sets at its head is the target's
row: `title`, `comment` (what a line of comment begins with; `<!--` of one that ends
with `-->`), `sources` (where keys, units and their use were read), and where they
apply `notes`, `needs_rate` (no meaning without a sampling rate) and `one_time` (one
correlation time for both triads, the gyros'). Figures are those of
budget.studies.export.figures, as `gyro.noise`; filters say how the target counts them.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from math import sqrt, ulp
from typing import TYPE_CHECKING, Any

from jinja2 import pass_context

from budget.documents import written
from budget.errors import CallError
from budget.model.sources import SENSORS
from budget.resources import (
    first_stem,
    own_templates,
    telling,
    template_environment,
    template_file,
)
from budget.studies.export.figures import Figure, Missing, print_number
from budget.ties import settle
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from jinja2.runtime import Context
    from jinja2.sandbox import SandboxedEnvironment

    from budget.arrays import Array
    from budget.names import Name
    from budget.studies.export.figures import KnownFigures

# What becomes of a key whose figure is not known: the export is refused, the key is
# left out, or it is 0, where that is how the target leaves the effect out.
REFUSE, LEAVE_OUT, ZERO = "refuse", "leave out", "zero"
# In a file under way, before it is told what stands for them.
HEADER, GONE, KEY, END = "\x01", "\x02", "\x03", "\x04"
ROUNDING = 4.0  # of a few conversions [units in the last place]


@dataclass(frozen=True, kw_only=True)
class Exported:
    """One key of the target with its value.

    Attributes
    ----------
    key : str
        As the target has it.
    sensor : str
        Whose figure it is.
    axes : tuple of str
        Whose values it holds, in its order; ('',) where one stands for all.
    values : tuple of float
        In `unit`, by its axes.
    unit : str
        As the target prints it.
    steps : tuple of str
        Where the value is from, and how it is made.
    lines : tuple of Name
        Lines of the data sheet in it.
    """

    key: str
    sensor: str
    axes: tuple[str, ...]
    values: tuple[float, ...]
    unit: str
    steps: tuple[str, ...]
    lines: tuple[Name, ...] = ()

    @property
    def by_axis(self) -> list[tuple[Exported, str, float]]:
        """It for each axis, with that and the value."""
        pairs = zip(self.axes, self.values, strict=True)
        return [(self, axis, value) for axis, value in pairs]


written(
    "exported",
    """
    key = 0.key (str): as the target has it
    sensor = 0.sensor (str): whose figure it is
    axis = 1 (str): '' where one value stands for all
    value = 2 (float) [unit]
    unit = 0.unit (str): as the target prints it
    from = 0.lines (list[str]): lines of the data sheet in it
    steps = 0.steps not in CSV (list[str]): where it is from, and how it is made
    """,
    said="Everything that goes into the file of a target.",
)(tuple)


@dataclass(frozen=True, kw_only=True)
class Target:
    """A program that reads figures of an IMU: what its template says of it."""

    name: str
    file: str
    source: str
    title: str
    comment: str
    sources: tuple[str, ...]
    notes: tuple[str, ...] = ()
    needs_rate: bool = False
    one_time: bool = False

    @cached_property
    def quantities(self) -> set[str]:
        """Figures that it asks for."""
        from jinja2 import nodes

        found = _environment().parse(self.source).find_all(nodes.Getattr)
        return {one.attr for one in found}


def targets() -> dict[str, Target]:
    """Return what there is, by the name that `--to` calls it."""
    return _targets(own_templates())


@cache
def _targets(_: Path | None) -> dict[str, Target]:
    """Return those of a folder of templates that go before those that ship."""
    from jinja2 import nodes

    environment = _environment()
    found = {}
    every = environment.list_templates()
    for file in (name for name in every if name.startswith("export/")):
        source = template_file(file).read_text("utf-8")
        said = {
            one.target.name: one.node.as_const()
            for one in environment.parse(source).body
            if isinstance(one, nodes.Assign)
            and isinstance(one.target, nodes.Name)
            and isinstance(one.node, nodes.Expr)
        }
        own = {key: said[key] for key in Target.__dataclass_fields__.keys() & said}
        name = first_stem(file)
        found[name] = Target(name=name, file=file, source=source, **own)
    return found


def find_target(name: str) -> Target:
    """Return the target of that name.

    Raises
    ------
    CallError
        There is none.
    """
    if name not in targets():
        there = ", ".join(targets())
        raise CallError(f"{name!r} is no target; there are: {there}")
    return targets()[name]


@dataclass(kw_only=True)
class Filled:
    """A template that is filled in, and what its filters were asked for.

    Attributes
    ----------
    text : str
        The file, with marks where the header goes and before the value of a key.
    entries : dict of str to Exported
        By key, in the order in which the file has them.
    left_out : list of str
        Keys whose figure is not known, and what they are without it.
    asked : dict of str to (str, str)
        Unit of every key, and what becomes of it where its figure is not known.
    """

    target: Target
    inflate: float = 1.0
    text: str = ""
    entries: dict[str, Exported] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    asked: dict[str, tuple[str, str]] = field(default_factory=dict)
    _needed: dict[str, list[str]] = field(default_factory=dict)

    def to(
        self,
        figure: Figure | Missing,
        key: str,
        unit: str,
        of: str | float = "",
        *,
        axes: str = "",
        axis: str = "",
        absent: str = REFUSE,
    ) -> str:
        """Print a figure under a key: of all axes, or of one of them.

        `of` is the size of the unit [SI], or what we call it, where the target spells
        it in its own way.
        """
        key, unit = str(key), str(unit)  # no markup: a template may join them
        if key not in self.asked:
            self.asked[key] = unit, absent
            self._tell(figure, key, unit, of, axes=axes.split(), absent=absent)
        if key not in self.entries:
            return GONE
        told = self.entries[key]
        texts = dict(zip(told.axes, map(print_double, told.values), strict=True))
        if axis or told.axes == ("",):
            return f"{KEY}{key}{END}{texts[axis]}"
        return f"{KEY}{key}{END}[{', '.join(texts.values())}]"

    def _tell(
        self,
        figure: Figure | Missing,
        key: str,
        unit: str,
        of: str | float,
        *,
        axes: list[str],
        absent: str,
    ) -> None:
        """Enter a key with its value, or why it has none."""
        held = tuple(axes) or figure.axes
        lines: tuple[Name, ...] = ()
        if isinstance(figure, Missing):
            said = f"{figure.needs}: {figure.why}"
            if absent == REFUSE:
                self._needed.setdefault(said, []).append(key)
                return
            if absent == LEAVE_OUT:
                self.left_out[key] = f"{key} is left out: it needs {said}"
                return
            steps: tuple[str, ...] = (f"0, which leaves it out: it needs {said}",)
            self.left_out[key] = f"{key} is {steps[0]}"
            values = tuple(0.0 for _ in held)
        else:
            size = size_of(of or unit) if isinstance(of, str) else float(of)
            factor = self.inflate**figure.power
            by_axis = dict(zip(figure.axes, figure.value.tolist(), strict=True))
            values = tuple(_plain(factor * by_axis[axis] / size) for axis in held)
            steps, lines = figure.steps, figure.names
            if self.inflate != 1.0 and figure.power:
                steps = (*steps, f"times {print_number(factor)} (inflated)")
        self.entries[key] = Exported(
            key=key,
            sensor=figure.kind,
            axes=held,
            values=values,
            unit=unit,
            steps=steps,
            lines=lines,
        )

    def check(self) -> None:
        """Refuse where a figure that the target must have is not known.

        Raises
        ------
        CallError
            Names each with its keys.
        """
        if self._needed:
            faults = "\n".join(
                f"{', '.join(keys)}: needs {said}"
                for said, keys in self._needed.items()
            )
            raise CallError(
                f"{self.target.title} cannot do without figures that are missing; give "
                "the specifications in the device file or with --set, let --missing "
                "put others in their place, or choose another target\n"
                f"{faults}"
            )


def fill_in(
    target: Target,
    known: Mapping[str, Mapping[str, Figure | Missing] | KnownFigures],
    *,
    inflate: float = 1.0,
    rate: float | None = None,
    gravity: float = 0.0,
) -> Filled:
    """Fill the template of a target in."""
    filled = Filled(target=target, inflate=inflate)
    shown = {"header": HEADER, "rate": rate, "gravity": gravity, "filled": filled}
    with telling(target.file):
        filled.text = _environment().get_template(target.file).render(shown, **known)
    return filled


def keys_of(target: Target) -> list[tuple[str, str, str]]:
    """Return keys of a target with their units, and what becomes of them unknown."""
    nothing: dict[str, Any] = defaultdict(lambda: Missing(needs=""))
    filled = fill_in(target, dict.fromkeys(SENSORS, nothing), rate=1.0)
    return [(key, *said) for key, said in filled.asked.items()]


def _environment() -> SandboxedEnvironment:
    """Return what reads templates: a line of a tag alone is no line of the file."""
    return _environment_of(own_templates())


@cache
def _environment_of(_: Path | None) -> SandboxedEnvironment:
    """Return that of a folder of templates that go before those that ship."""
    environment = template_environment(keep_trailing_newline=True)
    environment.filters |= {
        "to": _to,
        "number": print_double,
        "largest": _largest,
        "above_zero": _above_zero,
        **{name: _counted(*how) for name, how in COUNTED.items()},
    }
    return environment


@pass_context
def _to(context: Context, *what: object, **how: object) -> str:
    """Print a figure under a key, as `Filled.to`."""
    text: str = context["filled"].to(*what, **how)
    return text


def _largest(figure: Figure | Missing) -> Figure | Missing:
    """Return one value for all axes, the largest."""
    if isinstance(figure, Missing):
        return replace(figure, axes=("",))
    steps = figure.steps
    most = figure.value.max(keepdims=True)
    if (figure.value != most).any():
        told = print_number(float(most[0]))
        steps = (*steps, f"one for all axes, the largest: {told}")
    return replace(figure, value=most, axes=("",), steps=steps)


def _above_zero(figure: Figure | Missing) -> Figure | Missing:
    """Refuse a figure that is 0 on all axes: the target reads none there."""
    if isinstance(figure, Missing) or figure.value.any():
        return figure
    needs = ", ".join(figure.names)
    return Missing(
        kind=figure.kind, axes=figure.axes, needs=f"{needs} above 0", why="it is 0"
    )


# How a target counts a figure v at the sampling rate f: the formula, its value, and
# the power of v in it, which what multiplies standard deviations acts by. In
# `of_midpoint` each of the two samples of a step counts as independent of the step
# before, in which it was used too: half the variance. Var v of a step of dt is
# dt^2 n^2/2, to be N^2 dt.
COUNTED: dict[str, tuple[str, Callable[[Array, float], Array], int]] = {
    "variance": ("{v}^2", lambda v, _: v * v, 2),
    "of_sample": ("{v} sqrt(f)", lambda v, f: v * sqrt(f), 1),
    "variance_of_sample": ("{v}^2 f", lambda v, f: v * v * f, 2),
    "of_midpoint": ("{v} sqrt(2 f)", lambda v, f: v * sqrt(2.0 * f), 1),
}


def _counted(
    formula: str, value: Callable[[Array, float], Array], power: int
) -> Callable[[Context, Figure | Missing], Figure | Missing]:
    """Return the filter of a formula."""

    @pass_context
    def count(context: Context, figure: Figure | Missing) -> Figure | Missing:
        if isinstance(figure, Missing):
            return figure
        rate = context["rate"]
        at = f" at f = {print_number(rate)} Hz" if rate and "f" in formula else ""
        return replace(
            figure,
            value=value(figure.value, rate or 1.0),
            power=power,
            steps=(*figure.steps, f"{formula.format(v=figure.symbol)}{at}"),
        )

    return count


def _plain(value: float) -> float:
    """Return the short number that a value is but for the rounding of doubles."""
    short = settle(value)
    return short if abs(short - value) <= ROUNDING * ulp(value) else value


def print_double(value: float) -> str:
    """Print a number so that every reader reads that very double.

    With a point in it, without which YAML 1.1 reads 1e-06 as a text.
    """
    mantissa, mark, exponent = repr(float(value)).partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}{mark}{exponent}"
