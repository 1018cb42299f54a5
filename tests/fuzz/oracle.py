"""What any input may do to a reader: a sound record, or issues at their places."""

from __future__ import annotations

import re
from dataclasses import fields, is_dataclass
from math import isfinite

import numpy as np

from budget.distributions import Distribution
from budget.errors import SpecError, UnitError
from budget.inputs import (
    load_costs,
    load_device,
    load_mission,
    load_procedure,
    load_requirement,
    load_station,
    validate,
)
from budget.inputs.tree import MOST_ISSUES
from budget.units import KINDS, parse_quantity

LOADERS = {
    "device": load_device,
    "procedure": load_procedure,
    "station": load_station,
    "mission": load_mission,
    "requirement": load_requirement,
    "costs": load_costs,
}
LIKES = tuple(kind.units[0] for kind in KINDS)

# A message repeats at most two texts of the file, each cut at 80 to 100 characters,
# and lists what is allowed; names of 200 shipped files would still fit.
LONGEST_MESSAGE = 4_000  # characters
_BREAK = re.compile("\r\n|\r|\n")


UNITS = b"U"  # first byte of an input that is no file but a text with a unit
STANDARD = 9.80665  # what g is [m/s^2]


def judge_input(path, data, kinds=tuple(LOADERS)):
    """Check what any input does: bytes of a file, or a text with a unit of any kind."""
    if data.startswith(UNITS):
        text = data[len(UNITS) :].decode(errors="surrogateescape")
        for like in LIKES:
            judge_quantity(text, like, STANDARD)
    else:
        judge_file(path, data, kinds)


def judge_file(path, data, kinds=tuple(LOADERS)):
    """Check what loaders do with bytes; return the kind of the file, '' if refused.

    Whatever they raise besides SpecError goes through: that is the finding.
    """
    put(path, data)
    loaded = set()
    for kind in kinds:
        try:
            record = LOADERS[kind](path)
        except SpecError as error:
            _check_issues(error, path, data)
        else:
            _check_sound(record, kind)
            loaded.add(kind)
    try:
        checked = validate(path)
    except SpecError as error:
        _check_issues(error, path, data)
        # Of a device one variant may be wrong and the base sound; `name: x` alone is a
        # procedure where one is asked for, and nothing says so where none is.
        assert loaded <= {"device", "procedure", "station"}, loaded
        return ""
    # The base of a device may be hidden, so that only its variants load.
    if checked.kind in kinds and "" in (checked.variants or ("",)):
        assert checked.kind in loaded, (checked, loaded)
    return checked.kind


def put(path, data):
    """Write a file anew: one that is cut to nothing waits for the disk as it closes."""
    path.unlink(missing_ok=True)
    path.write_bytes(data)


def judge_name(name):
    """Check that any name is loaded, or refused as it was typed, without a variant."""
    for load in (validate, *LOADERS.values()):
        try:
            load(name)
        except SpecError as error:
            files = {issue.file for issue in error.issues}
            _check_files(files, name)


def judge_quantity(text, like, gravity):
    """Check what the unit grammar does with a text; return the value in SI or None."""
    try:
        quantity = parse_quantity(text, like, gravity=gravity)
    except UnitError as error:
        _check_message(str(error))
        return None
    assert isfinite(quantity.value), (text, quantity)
    assert isfinite(quantity.si_per_unit), (text, quantity)
    assert quantity.si_per_unit > 0.0, (text, quantity)
    assert quantity.printed == text.strip(), (text, quantity)
    assert quantity.unit, (text, quantity)
    return quantity.value


def _check_files(files, name):
    """Check that all issues are of the file that was named."""
    assert files <= {name, name.rpartition("#")[0]}, (files, name)


def _check_issues(error, path, data):
    """Check that each issue stands at a place that is in the file."""
    assert 1 <= len(error.issues) <= MOST_ISSUES + 1, len(error.issues)
    lines = _BREAK.split(data.decode("utf-8-sig", errors="replace"))
    for issue in error.issues:
        assert issue.file == str(path), issue
        assert 1 <= issue.line <= len(lines), issue
        assert 1 <= issue.column <= len(lines[issue.line - 1]) + 1, issue
        _check_message(str(issue))


def _check_message(text):
    """Check that a message is one line of words that a terminal can show."""
    assert text.strip(), text
    assert text.isprintable(), ascii(text)
    assert len(text) <= LONGEST_MESSAGE, len(text)


def _check_sound(value, place):
    """Check that every number in a record is finite, however deep it lies."""
    if isinstance(value, float | np.ndarray):
        assert np.all(np.isfinite(value)), place
    elif is_dataclass(value) and not isinstance(value, Distribution):
        for field in fields(value):
            _check_sound(getattr(value, field.name), f"{place}.{field.name}")
    elif isinstance(value, tuple):
        for item in value:
            _check_sound(item, place)
