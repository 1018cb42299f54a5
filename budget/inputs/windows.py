"""The windows of a procedure file: faces or table angles, dwells and turns, in time.

A line may stand for many: every face, several azimuths, a turn and back; a group of
lines can be repeated.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import degrees, isclose, pi, remainder
from typing import TYPE_CHECKING, ClassVar

from budget.inputs.fields import (
    ANGLE,
    SPAN,
    TIME,
    TRUTH,
    FieldGroup,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    faults,
    items,
    measured,
    number,
    one_of,
    table,
)
from budget.model.windows import FLIPS, INNER, MIDDLE, OUTER, Setting, Window
from budget.names import AXES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

MOST_WINDOWS = 10_000  # all windows are correlated with all
TABLE_AXES = {"vertical": OUTER, "outer": OUTER, "middle": MIDDLE, "inner": INNER}
ANGLES = ("outer", "middle", "inner")
FACES = ("z up", "z down", "x up", "x down", "y up", "y down")
_ROUNDING = 1e-9  # of a time, relative


class WindowLine(Keyed):
    """A dwell or a turn, at a face held up or down or at angles of the table."""

    rows: ClassVar[Rows] = {
        "face": KeyRow(
            one_of(*FACES, "all"), "which body axis is vertical; all: each in turn"
        ),
        "azimuth": KeyRow(ANGLE, "of the outer axis, beside a face; unset: 0 deg"),
        "azimuths": KeyRow(items(ANGLE), "one after the other, beside a face"),
        "outer": KeyRow(ANGLE, "table angle, about up"),
        "middle": KeyRow(ANGLE, "table angle, about y"),
        "inner": KeyRow(ANGLE, "table angle, about x"),
        "dwell": KeyRow(SPAN, "how long it stands"),
        "turn": KeyRow(
            one_of(*TABLE_AXES), "axis that turns; vertical is the outer one"
        ),
        "turns": KeyRow(
            number(-1_000_000, 1_000_000), "whole turns; the sign is the sense"
        ),
        "rate": KeyRow(measured("deg/s", Sign.POSITIVE), "of the turn"),
        "back": KeyRow(
            TRUTH, "followed by the same turn in the other sense", usual=False
        ),
        "repeat": KeyRow(number(1, MOST_WINDOWS), "times one after the other", usual=1),
        "start": KeyRow(TIME, "on the clock of the file; unset: after the last"),
        "use": KeyRow(
            one_of("gyro", "accelerometer", "both"),
            "whose readings are averaged",
            usual="both",
        ),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "face",
            lambda it: not it.face and not it.angles,
            "says not how the table stands, expected a face, as 'face: z up', or table "
            "angles, as 'outer: 0 deg'",
        ),
        *(
            Rule(
                key,
                lambda it, key=key: it.face and it.angles[:1] == [key],
                "stands beside a face, which says it already; remove it",
            )
            for key in ANGLES
        ),
        Rule(
            "azimuth",
            lambda it: it.azimuth and it.azimuths is not None,
            "stands beside azimuths; remove one of them",
        ),
        Rule(
            "azimuths",
            lambda it: (
                it.azimuths is not None and not 1 <= len(it.azimuths) <= MOST_WINDOWS
            ),
            f"names {{count}} azimuths, expected 1 to {MOST_WINDOWS}",
        ),
        *(
            Rule(
                key,
                lambda it, key=key: getattr(it, key) is not None and not it.face,
                "needs a face beside it; table angles have outer",
            )
            for key in ("azimuth", "azimuths")
        ),
        Rule(
            "dwell",
            lambda it: not it.turn and not it.dwell,
            "says not how long, expected a dwell, as 'dwell: 60 s', or a turn",
        ),
        *(
            Rule(
                key,
                lambda it, key=key: (
                    not it.turn and getattr(it, key) not in {None, False}
                ),
                "needs the axis of a turn, as 'turn: vertical'",
            )
            for key in ("turns", "rate", "back")
        ),
        Rule(
            "dwell",
            lambda it: it.turn and it.dwell,
            "stands beside a turn, whose rate says how long it takes",
        ),
        Rule(
            "rate",
            lambda it: it.turn and not it.rate,
            "has a turn without rate, expected such as 'rate: 10 deg/s'",
        ),
        Rule(
            "turns",
            lambda it: it.turn and not it.turns,
            "is no whole turn, expected such as turns: 1 or -1",
        ),
    )

    @property
    def angles(self) -> list[str]:
        """The angles of the table that it gives."""
        return [key for key in ANGLES if getattr(self, key) is not None]

    @property
    def count(self) -> int:
        """How many azimuths it names."""
        return len(self.azimuths or ())

    @property
    def number(self) -> int:
        """How many windows it stands for."""
        faces = len(FACES) if self.face == "all" else 1
        return int(self.repeat * faces * len(self.azimuths or " ") * (1 + self.back))

    def each(self) -> list[WindowLine]:
        """Return a line for each window: face by face, azimuth by azimuth, and back."""
        faces = FACES if self.face == "all" else (self.face,)
        azimuths = self.azimuths or (self.azimuth,)
        turns = (self.turns, -(self.turns or 0)) if self.back else (self.turns,)
        return [
            self.but(face=face, azimuth=azimuth, turns=turn)
            for face, azimuth, turn in product(faces, azimuths, turns)
        ] * int(self.repeat)

    def setting(self, flip_axis: str) -> Setting:
        """Return how the table stands, and turns [rad]; z comes down by that axis."""
        turning = None if self.turn is None else TABLE_AXES[self.turn]
        angle = 2.0 * pi * (self.turns or 0)
        if self.face is not None:
            axis, word = self.face.split()
            azimuth = self.azimuth.value if self.azimuth else 0.0
            sign = 1 if word == "up" else -1
            flip = FLIPS[flip_axis]
            angles = Setting.face(AXES.index(axis), sign, azimuth, flip).angles
        else:
            outer, middle, inner = (getattr(self, key) for key in ANGLES)
            values = [one.value if one else 0.0 for one in (outer, middle, inner)]
            angles = (values[0], values[1], values[2])
        return Setting(
            outer=angles[0],
            middle=angles[1],
            inner=angles[2],
            turning=turning,
            angle=angle,
        )

    @property
    def length(self) -> float:
        """How long one of it takes [s]."""
        if self.dwell is not None:
            return float(self.dwell.value)
        rate = 1.0 if self.rate is None else self.rate.value
        return float(abs(2.0 * pi * (self.turns or 0)) / rate)

    @property
    def title(self) -> str:
        """'z up, azimuth 90 deg', 'turn +1 outer at 0/90/0 deg'."""
        text: str
        if self.face is not None:
            text = self.face
            if self.azimuth is not None:
                text += f", azimuth {degrees(self.azimuth.value):.6g} deg"
        else:
            held = self.setting("inner").angles
            text = "/".join(f"{degrees(angle):.6g}" for angle in held) + " deg"
        if self.turn is None:
            return text
        return f"turn {self.turns:+d} {self.turn} at {text}"


class WindowItem(FieldGroup, WindowLine):
    """A line, or a group of lines that is repeated as a whole."""

    key = "windows"
    rows: ClassVar[Rows] = {
        key: KeyRow(
            items(table(WindowLine)), "a group; repeat beside it is of the whole"
        )
    }

    def each(self) -> list[WindowLine]:
        """Return a line for each window, those of a repetition again."""
        if self.windows is None:
            return super().each()
        return [one for line in self.windows for one in line.each()] * int(self.repeat)


def lay_out(
    items: Sequence[WindowItem],
    pause: float,
    sample_rate: float,
    *,
    flip_axis: str = "inner",
    moves: float | None = None,
) -> tuple[Window, ...]:
    """Put windows on one clock: each after the one before, or when it says.

    Parameters
    ----------
    items : sequence of WindowItem
    pause : float
        Before each that does not say its start [s].
    sample_rate : float
        [Hz].
    flip_axis : str
        That z comes down by, 'inner' or 'middle'.
    moves : float, optional
        Rate of the turns from one dwell to the next that a gyro reads [rad/s].

    Raises
    ------
    Faults
        Windows overlap, hold no sample, or are too many: which, all at once.
    """
    messages: dict[tuple[str | int, ...], str] = {}
    number = sum(item.number for item in items)
    if number > MOST_WINDOWS:
        raise faults(
            {("windows",): f"are {number}, expected {MOST_WINDOWS} at the most"}
        )
    windows: list[Window] = []
    for place, item in enumerate(items):
        made: dict[int, Window] = {}  # by the line, those of a repetition once
        begun: set[int] = set()  # starts of lines, which are of their first window
        for line in item.each():
            if line.length * sample_rate < 1.0 - _ROUNDING:
                messages["windows", place] = (
                    f"a window of {line.length:.6g} s has no sample at "
                    f"{sample_rate:g} Hz, expected one at least"
                )
            windows.extend(_moves(windows[-1:], line.setting(flip_axis), moves))
            end = windows[-1].end if windows else 0.0
            start = end + pause if windows else 0.0
            if line.start is not None and id(line.start) not in begun:
                begun.add(id(line.start))
                start = line.start.value
                if start < end and not isclose(start, end, rel_tol=_ROUNDING):
                    messages["windows", place, "start"] = (
                        f"begins at {start:.6g} s, before the window before it ends "
                        f"at {end:.6g} s; windows cannot overlap"
                    )
            if id(line) not in made:
                made[id(line)] = Window(
                    name=line.title,
                    start=0.0,
                    length=line.length,
                    setting=line.setting(flip_axis),
                    use=line.use,
                )
            windows.append(replace(made[id(line)], start=start))
    steps = sum(len(one.steps) for one in windows if moves)
    if steps > MOST_WINDOWS:
        messages["moves",] = (
            f"turns {steps} steps of 15 deg, expected {MOST_WINDOWS} at the most"
        )
    if messages:
        raise faults(messages)
    return tuple(windows)


def _moves(
    before: Sequence[Window], after: Setting, rate: float | None
) -> Iterator[Window]:
    """Yield turns of one table axis after the other, the inner first, the shorter way.

    They follow one another from the end of a dwell on, as hands do it; before the
    first there are none, nor without a rate.
    """
    if rate is None or not before:
        return
    stands, start = before[-1].setting, before[-1].end
    for axis, name in zip((INNER, MIDDLE, OUTER), ANGLES[::-1], strict=True):
        angle = remainder(getattr(after, name) - getattr(stands, name), 2.0 * pi)
        if abs(angle) < _ROUNDING:
            continue
        yield Window(
            name=f"{name} by {degrees(angle):+.6g} deg",
            start=start,
            length=abs(angle) / rate,
            setting=replace(stands, turning=axis, angle=angle),
            use="gyro",
        )
        start += abs(angle) / rate
        stands = replace(stands, **{name: getattr(after, name)})
