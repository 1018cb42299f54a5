"""A recorded trajectory: the CSV file that a mission names, read strictly."""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from contextlib import suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from math import degrees, pi, radians
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import meridian_radius, normal_radius
from budget.errors import BudgetError, Issue, UnitError
from budget.inputs.checking import nearest
from budget.inputs.files import find, open_file
from budget.inputs.procedure import MOST_HEIGHT
from budget.inputs.reader import ODD, is_number, read_bytes, refuse
from budget.inputs.records import Origin
from budget.inputs.tree import all_of, describe
from budget.navigation.route import Track
from budget.sentences import sentence
from budget.units import DAY, STANDARD_GRAVITY, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from budget.arrays import Array

# The columns there may be, and a unit of each; the first four must be there.
COLUMNS = {
    "time": "s",
    "latitude": "deg",
    "longitude": "deg",
    "height": "m",
    "roll": "deg",
    "pitch": "deg",
    "heading": "deg",
}
PLACE = ("latitude", "longitude", "height")
NEEDED = ("time", *PLACE)
# What others call a column, and what is of none: positions say it.
ALSO = {
    "time": ("t", "timestamp", "gps time", "seconds", "time of week", "tow"),
    "latitude": ("lat",),
    "longitude": ("lon", "long", "lng"),
    "height": ("alt", "altitude", "h", "elevation", "ellipsoidal height"),
    "roll": ("bank", "roll angle"),
    "pitch": ("pitch angle",),
    "heading": ("yaw", "hdg", "azimuth", "psi", "yaw angle", "true heading"),
}
USUAL = {other: name for name, own in ALSO.items() for other in (name, *own)}
VELOCITIES = {"vn", "ve", "vd", "vu", "vx", "vy", "vz", "v", "velocity", "speed"}
# Files of another kind, by how they begin.
KINDS = {
    b"PK\x03\x04": "an archive or a workbook",
    b"\x93NUMPY": "an array of NumPy",
    b"%PDF": "a PDF",
    b"$": "a file of NMEA sentences",
    b"<": "an XML file, as GPX and KML are",
    b"{": "a JSON file",
    b"[": "a JSON file",
}
EXAMPLE = ",".join(f"{name} [{unit}]" for name, unit in COLUMNS.items())
MOST_BYTES = 32 * 1024 * 1024
# Noise in a record makes each row a step of the growth: 50,000 take 20 s and 0.4 GB.
LEAST_ROWS, MOST_ROWS = 4, 50_000
MOST_ALIKE = 3  # rows that one thing is said of, before it is said once
MOST_RUNS = 5  # of rows, that one message names
LONGEST = DAY  # from the first row to the last [s]
MOST_LATITUDE = radians(89.9)  # north is no direction at a pole [rad]
MOST_SPEED = 10_000.0  # [m/s]
FOOT = 0.3048  # [m]
LEAST_SPEED = 0.1  # below which a track has no direction [m/s]
# From where a heading is held against the track, and may be off in the median: noise
# of positions turns a slow track, and a helicopter or a boat heads a little aside.
TRACK_SPEED = 1.0  # [m/s]
MOST_ASIDE = radians(45.0)  # [rad]
WELL_ALONG = radians(20.0)  # where another reading of a heading fits [rad]
# Of steps between rows in which a rounded position goes, and of what rounding asks for.
MOST_GRAINS, MOST_ROUNDING = 20, STANDARD_GRAVITY  # [1], [m/s^2]
LEAST_GRAIN = 1e-6  # below which it is the rounding of radians [m]
# What a lean that follows the track is besides 1 times what this asks for, by a slip:
# the factor, how near to it, from which size on [rad] and how much of height [m], so
# that it is no ship, which heels out of its turns and pitches with the slope of waves.
SLIPS = (
    ("roll", radians(1.0), 1.1, 0.2, 0.0, "radians"),
    # With latitude for longitude east is stretched.
    ("roll", -1.0, 1.6, 0.2, 0.0, "left_down"),
    ("pitch", radians(1.0), 1.1, 0.05, 50.0, "radians"),
    ("pitch", -1.0, 1.1, 0.05, 50.0, "nose_down"),
    ("pitch", FOOT, 1.1, 0.05, 50.0, "feet"),
)
CLOSE = 0.95  # correlation with the track from which a lean follows it [1]
MOST_GAP = 10.0  # from row to row, of the median: above it something is left out [1]
# What is within bounds of each column [SI], and the bounds in words.
BOUNDS = {
    "latitude": (MOST_LATITUDE * (1.0 - 1e-9), "between -89.9 deg and 89.9 deg"),
    "longitude": (2.0 * pi * (1.0 + 1e-9), "-360 deg to 360 deg"),
    "height": (MOST_HEIGHT, "-100 km to 100 km"),
    "roll": (pi * (1.0 + 1e-9), "-180 deg to 180 deg"),
    "pitch": (0.5 * pi * (1.0 + 1e-9), "-90 deg to 90 deg"),
    "heading": (200.0 * pi * (1.0 + 1e-9), "-36000 deg to 36000 deg"),
}
_HEAD = re.compile(r"([^\[\]]*?)\s*\[([^\[\]]*)\]")
_LOOSE = re.compile(
    r"(.*?)(?:[ _]*[(\[{].*|[ _]+(?:rad|degs?|degrees|m|ms|s|sec|ft|km))?"
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Recorded:
    """What a trajectory file holds, in SI, its time from the first row on.

    Attributes
    ----------
    track : Track
        Its longitude and heading do not jump.
    first_speed : float
        Mean speed from the first row to the second [m/s].
    assumptions, doubts : tuple of str
        What is taken where nothing is said, and what looks like a slip.
    origin : Origin
    """

    track: Track
    first_speed: float
    assumptions: tuple[str, ...]
    doubts: tuple[str, ...]
    origin: Origin


def ground(latitude: Array, longitude: Array, height: Array) -> tuple[Array, Array]:
    """Return coordinates whose differences from row to row are those on the ground.

    To the north and to the east [m], each element at the radii of its middle.
    """

    def along(angle: Array, radius: Array) -> Array:
        steps = np.diff(angle) * 0.5 * (radius[1:] + radius[:-1])
        return np.concatenate([[0.0], np.cumsum(steps)])

    north = np.vectorize(meridian_radius)(latitude) + height
    east = (np.vectorize(normal_radius)(latitude) + height) * np.cos(latitude)
    return along(latitude, north), along(longitude, east)


def read_trajectory(path: Path, shown: str) -> Recorded:
    """Read a recorded trajectory, which messages name `shown`.

    Raises
    ------
    SpecError
        Everything that is wrong with the file, each at its row.
    """
    data = read_bytes(path, shown, most=MOST_BYTES, what="a CSV file")
    if len(data) > MOST_BYTES:
        raise refuse(shown, f"is larger than {MOST_BYTES} bytes, the most allowed")
    if kind := _other_kind(path, data):
        message = f"is {kind}, expected a CSV file with a header, as {EXAMPLE}"
        raise refuse(shown, message)
    table = _Table(shown, _lines(data, shown))
    values = table.numbers()
    first = float(values["time"][0])
    values["time"] = values["time"] - first
    for name in {"longitude", "heading"} & values.keys():
        values[name] = np.unwrap(values[name])
    place = values["latitude"], values["longitude"], values["height"]
    track = (*ground(*place), place[2])
    speed = np.sqrt(np.sum(np.diff(track) ** 2, axis=0)) / np.diff(values["time"])
    table.check_speed(speed)
    north, east = (np.gradient(x, values["time"], edge_order=2) for x in track[:2])
    heading = values.get("heading")
    if heading is None:
        heading = table.along_track(north, east)
    zero = np.zeros_like(values["time"])
    taken = {"roll": "0 deg", "pitch": "0 deg", "heading": "that of the track"}
    return Recorded(
        track=Track(
            time=values["time"],
            latitude=place[0],
            longitude=place[1],
            height=place[2],
            attitude=np.column_stack(
                [values.get("roll", zero), values.get("pitch", zero), heading]
            ),
        ),
        first_speed=float(speed[0]),
        assumptions=(
            *(
                sentence("assumed.default", of="trajectory", name=key, usual=usual)
                for key, usual in taken.items()
                if key not in values
            ),
            *_gaps(values["time"], first),
            *_aside(heading, north, east),
        ),
        doubts=(
            *_coarse(values["time"], dict(zip(PLACE, track, strict=True))),
            *_leaning(values, north, east),
        ),
        origin=Origin(file=path.name, sha256=sha256(data).hexdigest()),
    )


def _gaps(time: Array, first: float) -> tuple[str, ...]:
    """Return what is assumed where rows are left out; times as the file counts them."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > MOST_GAP * usual)
    if not gaps.size:
        return ()
    longest = gaps[np.argmax(steps[gaps])]
    return (
        sentence(
            "trajectory.gaps",
            number=int(gaps.size),
            start=float(first + time[longest]),
            end=float(first + time[longest + 1]),
            usual=usual,
        ),
    )


def _coarse(time: Array, track: dict[str, Array]) -> tuple[str, ...]:
    """Say where positions have too few decimals for how often they come.

    All steps are then small whole numbers of the least one, the grain, and change by it
    from row to row: an acceleration of grain / dt^2 of the rounding alone.
    """
    dt = float(np.median(np.diff(time)))
    steps = {name: np.abs(np.diff(place)) for name, place in track.items()}
    grains = {
        name: float(one[one > LEAST_GRAIN].min(initial=np.inf))
        for name, one in steps.items()
    }
    return tuple(
        sentence(
            "trajectory.coarse",
            name=name,
            grain=grain,
            step=dt,
            size=grain / dt**2 / STANDARD_GRAVITY,
        )
        for name, grain in grains.items()
        if MOST_ROUNDING * dt**2 < grain < np.inf and _is_rounded(steps[name] / grain)
    )


def _is_rounded(steps: Array) -> bool:
    """Whether steps are small whole numbers, and change [1].

    Radii and the cosine of the latitude change a little on the way.
    """
    whole = np.rint(steps)
    is_near = np.abs(steps - whole).max() < 0.01 * max(1.0, whole.max())
    return bool(whole.max() <= MOST_GRAINS and np.ptp(whole) > 0 and is_near)


def _leaning(
    values: dict[str, Array], v_north: Array, v_east: Array
) -> tuple[str, ...]:
    """Say where roll or pitch follow the track in another unit or sense.

    In a turn in which nothing pulls aside tan(roll) = a/g, a the acceleration to the
    right; where the nose is along the path tan(pitch) is climb over way. A vehicle
    leans as it likes, and less so or not at all is no slip; what is said follows the
    track closely (correlation) by a factor that a slip has.
    """
    time, v = values["time"], np.hypot(v_north, v_east)
    moves = v > TRACK_SPEED
    if moves.sum() < LEAST_ROWS:
        return ()
    a_north, a_east, climb = (
        np.gradient(one, time, edge_order=2)
        for one in (v_north, v_east, values["height"])
    )
    aside = (v_north * a_east - v_east * a_north)[moves] / v[moves]
    of_track = {
        "roll": np.arctan(aside / STANDARD_GRAVITY),
        "pitch": np.arctan(climb[moves] / v[moves]),
    }
    rises = float(np.ptp(values["height"]))
    factors = {
        name: float(np.polyfit(angle, own, 1)[0])
        for name, angle in of_track.items()
        for own in [values.get(name, np.zeros_like(v))[moves]]
        if np.ptp(angle) and np.ptp(own)
        if abs(np.corrcoef(angle, own)[0, 1]) > CLOSE
    }
    return tuple(
        sentence("trajectory.leaning", name=name, factor=factors[name], slip=what)
        for name, slip, near, least, height, what in SLIPS
        if name in factors
        and 1.0 / near < factors[name] / slip < near
        and np.ptp(of_track[name]) > least
        and rises >= height
    )


def _in_words(rows: Sequence[int]) -> str:
    """Return rising numbers of rows, those that follow each other in one: '2 to 5'."""
    runs = np.split(np.array(rows), np.flatnonzero(np.diff(rows) > 1) + 1)
    texts = [
        f"{run[0]} to {run[-1]}" if len(run) > 1 else f"{run[0]}"
        for run in runs[:MOST_RUNS]
    ]
    if more := sum(map(len, runs[MOST_RUNS:])):
        texts.append(f"{more} more")
    *before, last = texts
    return ("rows " if len(rows) > 1 else "row ") + (
        f"{', '.join(before)} and {last}" if before else last
    )


def _other_kind(path: Path, data: bytes) -> str:
    """Say what a file is that is no CSV file: 'a station file'; '' of others."""
    if path.suffix.lower() in {".yaml", ".yml"}:
        try:
            return f"a {open_file(find(path)).kind} file"
        except BudgetError:
            return "a YAML file"
    start = data.removeprefix(BOM_UTF8).lstrip()
    return next((kind for mark, kind in KINDS.items() if start.startswith(mark)), "")


def _hint(head: str, name: str) -> str:
    """Return what to write in the place of a head that is none, or ''."""
    match = _LOOSE.fullmatch(name.lower().replace("_", " "))
    word = match[1].strip() if match else name
    if word in VELOCITIES:
        return "; velocities follow from the positions: leave it out"
    if meant := USUAL.get(word):
        given = _HEAD.fullmatch(head)
        unit = given[2] if given and given[2] else COLUMNS[meant]
        return f"; write {f'{meant} [{unit}]'!r}"
    return nearest(name, tuple(COLUMNS))


def _aside(heading: Array, v_north: Array, v_east: Array) -> tuple[str, ...]:
    """Say where a heading has little to do with the track: columns may be swapped.

    It is no error: a car in reverse and a helicopter do so.
    """
    moves = np.hypot(v_north, v_east) > TRACK_SPEED
    if not moves.any():
        return ()
    track = np.arctan2(v_east, v_north)

    def median(other: Array) -> float:
        off = np.remainder(other - track + pi, 2.0 * pi) - pi
        return float(np.median(np.abs(off)[moves]))

    if (angle := median(heading)) <= MOST_ASIDE:
        return ()
    readings = {
        "radians": degrees(1.0) * heading,
        "left": -heading,
        "east": pi / 2.0 - heading,
    }
    fits = (word for word, one in readings.items() if median(one) < WELL_ALONG)
    return (sentence("trajectory.aside", angle=degrees(angle), fits=next(fits, "")),)


def _lines(data: bytes, shown: str) -> list[str]:
    """Return the lines of the file; blank ones at its end are none."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"byte 0x{data[error.start]:02x} is not UTF-8; save the file as UTF-8"
        raise refuse(shown, message) from None
    text = text.rstrip().replace("\r\n", "\n").replace("\r", "\n")
    if not text:
        raise refuse(shown, f"the file is empty, expected a header, as {EXAMPLE}")
    rows = text.count("\n")
    if not LEAST_ROWS <= rows <= MOST_ROWS:
        advice = f" after a header, as {EXAMPLE}"
        if rows > MOST_ROWS:
            advice = "; leave rows out, ten a second show what a vehicle does"
        message = f"has {rows} rows, expected {LEAST_ROWS} to {MOST_ROWS}{advice}"
        raise refuse(shown, message)
    return text.split("\n")


class _Table:
    """The rows of a file with their places in it, and what is wrong with them."""

    def __init__(self, shown: str, lines: list[str]) -> None:
        """Read the header.

        Raises
        ------
        SpecError
            It is none of a trajectory.
        """
        self.shown = shown
        self.lines = lines
        self.issues: dict[tuple[str, str], list[Issue]] = {}
        self.names: list[str] = []
        self.factors: list[float] = []
        other = next(filter(lines[0].count, ";\t|"), "")
        if "," not in lines[0] and other:
            points = "; write points in the numbers then, not commas"
            message = f"parts its columns by {other!r}, expected commas, as {EXAMPLE}"
            self._add(0, 0, "", f"{message}{points if ',' in lines[1] else ''}")
        elif not ODD.search(lines[0]):
            message = f"is of numbers, expected a header above them, as {EXAMPLE}"
            self._add(0, 0, "", message)
        self._raise()
        for place, head in enumerate(lines[0].split(",", len(COLUMNS))):
            self._read_head(place, head)
        if missing := [name for name in NEEDED if name not in self.names]:
            message = f"the header has no {', '.join(missing)}, expected as {EXAMPLE}"
            self._add(0, 0, "", message)
        self._raise()

    def _read_head(self, place: int, head: str) -> None:
        """Read one head of the header."""
        match = _HEAD.fullmatch(head.strip())
        name, unit = match.groups() if match else (head.strip(), "")
        known = name in COLUMNS and name not in self.names
        self.names.append(name)
        self.factors.append(1.0)
        if not known:
            why = "stands twice" if name in COLUMNS else "is no column of a trajectory"
            message = f"{describe(name)} {why}, expected {', '.join(COLUMNS)}"
            self._add(0, place, "", f"{message}{_hint(head.strip(), name)}")
        elif not match:
            message = f"has no unit, expected '{name} [{COLUMNS[name]}]'"
            self._add(0, place, name, message)
        else:
            try:
                self.factors[-1] = parse_quantity(f"1 {unit}", COLUMNS[name]).value
            except UnitError as error:
                self._add(0, place, name, f"{error}")

    def numbers(self) -> dict[str, Array]:
        """Return the columns [SI].

        Raises
        ------
        SpecError
            A row is not of numbers, or they are not within bounds.
        """
        every = enumerate(self.lines[1:], start=1)
        rows = [self._read_row(number, line) for number, line in every]
        self._raise()
        with np.errstate(over="ignore"):
            columns = np.array(rows).T * np.array(self.factors)[:, None]
        values = dict(zip(self.names, columns, strict=True))
        for place, name in enumerate(self.names):
            if name in BOUNDS:
                most, words = BOUNDS[name]
                words += self._slip(place, values, most)
                for after in np.flatnonzero(~(np.abs(values[name]) <= most)):
                    self._refuse(int(after) + 1, place, f"expected {words}")
        self._check_time(values["time"])
        self._raise()
        return values

    def _slip(self, place: int, values: dict[str, Array], most: float) -> str:
        """Return a hint at what is likelier than values out of their bounds, or ''."""
        name = self.names[place]
        if COLUMNS[name] == "deg" and self.factors[place] == 1.0:
            is_fitting = np.abs(np.radians(values[name])).max() <= most
            return f"; the head says rad: is it '{name} [deg]'?" if is_fitting else ""
        if name == "latitude" and np.abs(values["longitude"]).max() <= most:
            return "; are latitude and longitude swapped?"
        return ""

    def _read_row(self, number: int, line: str) -> list[float]:
        """Return the numbers of a row."""
        count = line.count(",") + 1
        if count != len(self.names):
            message = f"has {count} values, expected {len(self.names)} as the header"
            if count > len(self.names):
                message += "; where commas are decimal ones write points"
            self._add(number, 0, "", message)
            return []
        cells = line.split(",")
        if not ODD.search(line):
            with suppress(ValueError):
                return [float(cell) for cell in cells]
        for place, cell in enumerate(cells):
            if not is_number(cell):
                self._refuse(number, place, "expected a number")
        return []

    def _check_time(self, time: Array) -> None:
        """Refuse times that do not rise, or for too long."""
        place = self.names.index("time")
        with np.errstate(invalid="ignore"):
            falls = ~(np.diff(time) > 0.0)
            length = time[-1] - time[0]
        for row in np.flatnonzero(falls):
            self._refuse(
                int(row) + 2, place, "expected a time after that of the row before"
            )
        if not length <= LONGEST * (1.0 + 1e-9):
            message = f"lasts {length:.6g} s, expected 24 h at the most"
            self._add(len(time), place, "time", message)

    def along_track(self, v_north: Array, v_east: Array) -> Array:
        """Return the heading of the track, shape (n,) [rad], of its velocity [m/s].

        Raises
        ------
        SpecError
            It stands somewhere, and has none there.
        """
        rows = np.flatnonzero(np.hypot(v_north, v_east) < LEAST_SPEED)
        if rows.size:
            which = _in_words((rows + 2).tolist())
            message = (
                f"moves at less than {LEAST_SPEED:g} m/s in {which} of the file, "
                "and a track that stands has no heading; give a column 'heading [deg]'"
            )
            self._add(int(rows[0]) + 1, 0, "", message)
        self._raise()
        return np.asarray(np.unwrap(np.arctan2(v_east, v_north)))

    def check_speed(self, speed: Array) -> None:
        """Refuse rows that are too far apart.

        Raises
        ------
        SpecError
            There are some.
        """
        for row in np.flatnonzero(~(speed <= MOST_SPEED)):
            message = (
                f"is {speed[row] / 1e3:.6g} km/s from the row before, expected "
                f"{MOST_SPEED / 1e3:g} km/s at the most; see to the units of the header"
            )
            self._add(int(row) + 2, 0, "", message, alike="speed")
        self._raise()

    def _refuse(self, number: int, place: int, expected: str) -> None:
        """Add an issue of one value."""
        found = self.lines[number].split(",")[place].strip()
        name = self.names[place]
        self._add(
            number, place, name, f"found {describe(found)}, {expected}", alike=expected
        )

    def _add(
        self, number: int, place: int, name: str, message: str, *, alike: str = ""
    ) -> None:
        """Add an issue at a value of a row; row 0 is the header.

        Of many rows with one name and what is alike the first alone is said.
        """
        before = self.lines[number].split(",", place)[:place]
        self.issues.setdefault((name, alike or message), []).append(
            Issue(
                file=self.shown,
                line=number + 1,
                column=1 + sum(len(cell) + 1 for cell in before),
                field=name,
                message=message,
            )
        )

    def _raise(self) -> None:
        """Raise the issues, if there are any."""
        if self.issues:
            raise all_of(
                one for alike in self.issues.values() for one in _at_most(alike)
            )


def _at_most(alike: list[Issue]) -> list[Issue]:
    """Return issues that are alike, many of them as one."""
    if len(alike) <= MOST_ALIKE:
        return alike
    first, *others = alike
    more = f"; {len(others)} more rows are alike"
    return [replace(first, message=f"{first.message}{more}")]
