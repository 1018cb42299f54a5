"""Error lines of other packages: found by entry point, checked, or left out with words.

A distribution names one in its metadata,

    [project.entry-points."budget.sources"]
    anisoelasticity = "my_imu:ANISOELASTICITY"

where the name is the key of the line in a device file and the object a Source. They are
looked for when the lines of a sensor are first asked for, once in a process. What is
wrong with one is kept by its key, and harms no other line.
"""

from __future__ import annotations

import re
import sys
import traceback
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from functools import partial
from importlib import metadata
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.errors import CallError, UnitError
from budget.model.noise import InRun
from budget.model.source import (
    COLOURS,
    DEVICE,
    IN_RUN,
    SENSORS,
    TEST,
    TURN_ON,
    Disturbance,
    Given,
    Initial,
    Key,
    Noise,
    Offset,
    Samples,
    Source,
    TurnOnChange,
)
from budget.model.windows import Schedule, Window
from budget.names import AXES, OUTPUTS, PARAMETERS
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from importlib.metadata import EntryPoint
    from typing import Any

    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.source import Act

GROUP = "budget.sources"
PAGE = "docs/own-sources.md"
KEY = re.compile("[a-z][a-z0-9_]{1,59}")
AXIS = re.compile("[A-Za-z0-9_]{0,20}")
MOST_VALUES = 100  # of one line: all second derivatives are carried
# What stands under a sensor already, and what outputs and tables are called.
TAKEN = frozenset({*OUTPUTS, "errors", "interaction", "nominal", "noise", "other"})
# What a value says already, and what ties lines of our own to one another.
SAID = frozenset(
    {
        *("value", "axes", "meaning", "distribution", "includes", "horizon", "reading"),
        *("condition", "source", "adds_to", "definition", "density"),
    }
)
TIES = (
    *("time", "points", "forms", "value", "beside", "over_temperature"),
    *("left_of", "use", "is_asked", "grades"),
)
STAYS = (DEVICE, TURN_ON, TEST, IN_RUN)
EFFECTS = Noise | Disturbance | Offset | TurnOnChange
IN_RUN_KINDS = ("white", "walk", "markov", "rounding")
ALIKE = 1e-6  # relative, of one covariance made in two ways [1]
RATE = 100.0  # of the samples of a probe [Hz]
PROBED = np.array([[0.0, 0.0, 0.0], [0.3, -0.2, 9.7], [7.1, 0.4, -6.8]])  # [SI]
LONGEST = 300  # characters that are repeated of what an error says


class OutsideError(CallError):
    """An effect of another package failed."""


@dataclass(frozen=True, kw_only=True)
class Outside:
    """Lines of other packages, and what is wrong with those that are left out.

    Attributes
    ----------
    sources : tuple of Source
    faults : mapping of str to str
        By key: whose it is, what was found, what to do.
    """

    sources: tuple[Source, ...]
    faults: Mapping[str, str]


def find_outside(known: Iterable[str]) -> Outside:
    """Look for lines of other packages; `known` are the keys of our own."""
    ours, sources, faults = {*known}, [], {}
    entries = sorted(metadata.entry_points(group=GROUP), key=_origin)
    for entry in entries:
        twins = [_origin(one) for one in entries if one.name == entry.name]
        source, wrong = None, []
        if len(twins) > 1:
            wrong = [f"{' and '.join(twins)} have the same key; remove all but one"]
        else:
            source, wrong = _loaded(entry)
        if source is not None and not wrong:
            wrong = _wrong_in(source, entry, ours)
        if source is not None and not wrong:
            sources.append(replace(source, origin=_origin(entry)))
        else:
            faults[entry.name] = (
                f"the error line {entry.name!r} of {_origin(entry)} is left out: "
                f"{'; '.join(wrong)}; mend or remove that package ({PAGE})"
            )
    return Outside(sources=tuple(sources), faults=faults)


def _origin(entry: EntryPoint) -> str:
    """Name a distribution and its entry point."""
    of = f"{entry.dist.name} {entry.dist.version}" if entry.dist else "a package"
    return f"{of} ({entry.name} = {entry.value})"


def said(error: BaseException) -> str:
    """Repeat an error of another package, in a line."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text.removesuffix(":")[:LONGEST]


def _loaded(entry: EntryPoint) -> tuple[Source | None, list[str]]:
    """Import what an entry point names; what it prints is no result of ours."""
    try:
        with redirect_stdout(sys.stderr):
            found = entry.load()
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it does
        return None, [f"its import ended with {said(error)}"]
    if not isinstance(found, Source):
        kind = found.__name__ if isinstance(found, type) else type(found).__name__
        return None, [f"found {kind}, expected a budget.model.source.Source"]
    return found, []


def _wrong_in(source: Source, entry: EntryPoint, ours: set[str]) -> list[str]:
    """Return what is wrong with a row, or else with its effect where it is tried."""
    try:
        with np.errstate(all="ignore"), redirect_stdout(sys.stderr):
            return [*_wrong_with(source, entry, ours)] or [*_wrong_effect(source)]
    except Exception as error:  # noqa: BLE001 - whatever it does
        return [f"its effect, when it was tried, ended with {said(error)}"]


def _wrong_with(source: Source, entry: EntryPoint, ours: set[str]) -> Iterator[str]:
    """Yield what is wrong with a row, besides what its effect does."""
    name = source.name
    if name != entry.name:
        yield f"its Source is called {name!r}, expected the name of the entry point"
    elif not KEY.fullmatch(name):
        yield f"its key is {name!r}, expected small letters, digits and underscores"
    elif name in ours or name in TAKEN:
        yield f"budget itself calls something {name!r}; expected a key of its own"
    yield from _wrong_units(source.units)
    yield from _wrong_kind(source)
    yield from _wrong_ties(source)
    for key, value, allowed in (
        ("stays", source.stays, STAYS),
        ("colour", source.colour, (*COLOURS, "")),
    ):
        if value not in allowed:
            yield f"its {key} is {value!r}, expected {', '.join(map(repr, allowed))}"
    texts = [source.model, *(getattr(source.effect, one, "") for one in TEXTS)]
    if not isinstance(source.words, tuple) or not all(
        isinstance(text, str) and text.isprintable() for text in (*texts, *source.words)
    ):
        yield (
            "its model, formula, letters and needs are texts of one line, and its "
            "words a tuple of such; expected that"
        )
    elif not source.model or "$" in source.effect.formula:
        yield "expected a model, a line on what it is, and a formula without '$'"


def _wrong_ties(source: Source) -> Iterator[str]:
    """Yield what is wrong with keys of its own, and with what is of our lines alone."""
    for tie in TIES:
        if getattr(source, tie):
            yield f"it says {tie}, which ties lines of budget; expected it left out"
    if source.expected not in {"", source.name}:
        yield (
            f"it is expected as {source.expected!r}, which ties lines of budget; "
            f"expected {source.name!r}, or it left out"
        )
    if not isinstance(source.keys, tuple) or not all(map(_is_key, source.keys)):
        yield (
            "its keys are not a tuple of Key, each with a name that no value has yet, "
            "a unit of docs/files.md and a usual size above 0; expected that"
        )


def _is_key(key: object) -> bool:
    """Whether something is a key that can stand beside a value."""
    return (
        isinstance(key, Key)
        and KEY.fullmatch(key.name) is not None
        and key.name not in SAID
        and key.usual > 0.0
        and size_of(key.unit) > 0.0
        and key.says.isprintable()
    )


def _wrong_units(units: Any) -> Iterator[str]:  # noqa: ANN401 - whatever stands there
    """Yield what is wrong with the units of a row."""
    if not isinstance(units, dict) or not units or not units.keys() <= {*SENSORS}:
        yield (
            f"its units are {units!r}, expected a unit by sensor, as {{'gyro': "
            "'deg/h/g^2'}, of gyro, accelerometer or both"
        )
        return
    for unit in units.values():
        try:
            size_of(unit)
        except (UnitError, AttributeError, TypeError):
            yield f"found the unit {unit!r}, expected one that docs/files.md has"


def _wrong_kind(source: Source) -> Iterator[str]:
    """Yield what is wrong with the kind of effect, and the axes that it has."""
    axes, effect = source.axes, source.effect
    if not isinstance(effect, EFFECTS) or isinstance(effect, Initial):
        kind = effect.__name__ if isinstance(effect, type) else type(effect).__name__
        yield (
            f"its effect is {'the class ' * isinstance(effect, type)}{kind}, expected "
            "an instance of a Disturbance, a Noise, an Offset or a TurnOnChange"
        )
    elif isinstance(effect, Offset) and effect.target not in PARAMETERS:
        yield f"its target is {effect.target!r}, expected {', '.join(PARAMETERS)}"
    elif isinstance(effect, Noise | Offset):
        own = AXES if isinstance(effect, Noise) else PARAMETERS[effect.target]
        if axes != own:
            yield f"its axes are {axes!r}, expected {own!r} of such an effect"
    if (
        not isinstance(axes, tuple)
        or not 0 < len({*axes}) == len(axes) <= MOST_VALUES
        or not all(isinstance(one, str) and AXIS.fullmatch(one) for one in axes)
    ):
        yield f"its axes are {axes!r}, expected different names in a tuple: 'x', 'xy'"


TEXTS = ("formula", "letters", "needs")


def _wrong_effect(source: Source) -> Iterator[str]:
    """Yield what is wrong with what an effect does, where it is tried."""
    effect, n = source.effect, len(source.axes)
    given = Given(
        name=source.name,
        u=np.ones(n),
        distributions=(NORMAL,) * n,
        own={one.name: one.usual for one in source.keys},
    )
    if isinstance(effect, Disturbance):
        yield from _wrong_in_use(effect, n, has_keys=bool(source.keys))
    elif isinstance(effect, Noise):
        yield from _wrong_noise(effect, given)
    elif isinstance(effect, TurnOnChange):
        for target, gains in effect.gains({source.name: given}).items():
            shape = (len(PARAMETERS.get(target, ())), n)
            for which, array in zip(("test", "later"), gains, strict=True):
                yield from _wrong_shape(f"gain of {target}, {which},", array, shape)


def _wrong_in_use(effect: Disturbance, n: int, *, has_keys: bool) -> Iterator[str]:
    """Yield what is wrong with what a disturbance adds, for one input and for many."""
    for x in (PROBED[1], PROBED, np.stack([PROBED, 2.0 * PROBED])):
        found = effect.in_use(x, x[..., ::-1])
        if found is None:
            if type(effect).bind is Disturbance.bind:
                yield "its effect adds nothing; expected in_use, or bind, of its own"
            return
        yield from _wrong_shape("in_use", found, (*x.shape, n))
    if has_keys:
        yield "its in_use is not told its keys; expected bind alone, or no keys"


def _wrong_noise(effect: Noise, given: Given) -> Iterator[str]:
    """Yield what is wrong with a process over two windows, in a run, in samples."""
    process = effect.process(given, 0, RATE)
    if type(process).__hash__ is None:
        yield "its process has no hash; expected a frozen dataclass"
        return
    windows = [Window(name=f"{k}", start=20.0 * k, length=10.0 + k) for k in range(2)]
    schedule, W = Schedule(windows=tuple(windows)), np.array([[1.0, -1.0], [0.5, 0.5]])
    C, reduced = process.covariance(schedule), process.reduce(schedule, W)
    wrong = [
        *_wrong_shape("covariance", C, (2, 2)),
        *_wrong_shape("reduce", reduced, (2, 2)),
    ]
    size = 0.0 if wrong else float(np.trace(C))
    if not wrong and not np.allclose(reduced, W @ C @ W.T, ALIKE, ALIKE * size):
        wrong.append("its reduce is not W C W^T of its covariance C")
    if not wrong and (
        abs(C - C.T).max() > ALIKE * size or np.linalg.eigvalsh(C).min() < -ALIKE * size
    ):
        wrong.append("its covariance is none: not symmetric, or of a negative variance")
    yield from wrong
    run = process.in_run(RATE)
    if not isinstance(run, InRun) or run.kind not in IN_RUN_KINDS:
        yield f"its in_run is {run!r}, expected an InRun of {', '.join(IN_RUN_KINDS)}"
    draw = effect.sampler(given, np.random.default_rng(0), RATE)
    at = Samples(n=5, dt=1.0 / RATE, first=0.5 / RATE)
    yield from _wrong_shape("samples", draw(at), (len(AXES), at.n))


def _wrong_shape(what: str, found: Any, shape: tuple[int, ...]) -> Iterator[str]:  # noqa: ANN401
    """Yield what is wrong with an array that should be of a shape, and finite."""
    if np.shape(found) != shape:
        yield f"its {what} has the shape {np.shape(found)}, expected {shape}"
    elif not np.isfinite(np.asarray(found, dtype=float)).all():
        yield f"its {what} has values that are no finite numbers; expected such"


def watched(act: Act, source: Source) -> Act:
    """Return an act that says whose it is where it fails."""
    return partial(_watched, act=act, whose=f"{source.name!r} of {source.origin}")


def _watched(x: Array, truth: Truth, noise: Array, *, act: Act, whose: str) -> Array:
    """Act, and see that the errors are of the right shape and finite."""
    try:
        found = act(x, truth, noise)
        rows = np.shape(found)
    except Exception as error:
        raise OutsideError(_failed(whose, said(error))) from error
    if rows[:1] + rows[2:] != (len(AXES), x.shape[1]):
        wrong = f"an array of shape {rows}, expected (3, statistics, {x.shape[1]})"
        raise OutsideError(_failed(whose, wrong))
    if found.dtype != object and not np.isfinite(found).all():
        raise OutsideError(_failed(whose, "values that are no finite numbers"))
    return found


def _failed(whose: str, what: str) -> str:
    """Say that an effect failed, whose it is and what to do."""
    return (
        f"the effect of the error line {whose} ended with {what}; mend or remove that "
        f"package, or leave the line out ({PAGE})"
    )


def blamed(error: BaseException, sources: Iterable[Source]) -> str:
    """Say in whose code an error arose; '' where that is none from outside."""
    if isinstance(error, OutsideError):
        return str(error)
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    files = {frame.f_code.co_filename for frame in frames}
    acting = [id(frame.f_locals.get("self")) for frame in frames]
    own = [one for one in sources if one.origin and _file_of(one) in files]
    own.sort(
        key=lambda one: id(one.effect) not in acting
    )  # of one file the one at work
    return _failed(f"{own[0].name!r} of {own[0].origin}", said(error)) if own else ""


def _file_of(source: Source) -> str:
    """Return the file that an effect is written in."""
    module = sys.modules.get(type(source.effect).__module__)
    return getattr(module, "__file__", None) or ""
