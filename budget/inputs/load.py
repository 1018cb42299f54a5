"""Load the files that a user names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import is_dataclass, replace
from functools import lru_cache, partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from budget.errors import CallError, SpecError
from budget.inputs.changes import check_used, read_change, texts_of
from budget.inputs.costs import read_costs
from budget.inputs.device import read_device, root_of, variant_names
from budget.inputs.files import FOLDERS, find, open_file, refuse_absent
from budget.inputs.mission import read_mission
from budget.inputs.procedure import read_procedure
from budget.inputs.reader import parse, refuse
from budget.inputs.recording import YAML, bare_recording, read_recording
from budget.inputs.records import (
    FACTORY,
    NONE,
    UNCALIBRATED,
    Checked,
    Costs,
    Device,
    Mission,
    Origin,
    Procedure,
    Recording,
    Requirement,
    Station,
)
from budget.inputs.requirement import read_requirement
from budget.inputs.station import aged, done_at, read_station, used
from budget.inputs.tree import MOST_ISSUES, all_of
from budget.model.source import Coefficient, TurnOnChange
from budget.model.sources import ENVIRONMENT, SENSORS, source_of
from budget.model.sources.later import TEST_VIBRATION
from budget.names import MISSION, Name, parameters_of
from budget.resources import shipped
from budget.sentences import sentence
from budget.spooled import Lazy, SpooledList

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.errors import Issue
    from budget.inputs.changes import Changes, Override
    from budget.inputs.files import File, NamedFile
    from budget.inputs.tree import YamlFile


P = TypeVar("P")
T = TypeVar("T")
PAPER = "zhao-2019"  # the shipped procedure that stands in for none
# What stands for a procedure where there is none.
UNTESTED = {NONE: "no calibration", FACTORY: "calibration by the maker"}


def load_device(path: Device | File, changes: Changes = ()) -> Device:
    """Read a device.

    Parameters
    ----------
    path : str, Path or mapping
        'FILE', 'FILE#VARIANT', or the bare name of a shipped device instead of FILE; or
        a dict with the keys of such a file. A Device is its own.
    changes : mapping, or sequence of str
        What is other than in the file: {'gyro.bias_stability': '0.02 deg/h'}, or
        'gyro.bias_stability=0.02 deg/h'. The result names every change.

    Returns
    -------
    Device
        What the file says, in SI.

    Raises
    ------
    SpecError
        Everything that is wrong with the file, each at its place.
    CallError
        It is no such thing, or a change is none or reaches no sensor.
    """
    if isinstance(path, Device):
        return path.replace(changes) if changes else path
    (device,) = load_changed([path], changes, variants=False)
    return device


def load_devices(
    given: Device | File | Iterable[Device | File], *, variants: bool = False
) -> Sequence[Device]:
    """Read devices, one or several; of a file every variant if asked for.

    Raises as load_device, with the issues of all files.
    """
    if isinstance(given, Lazy):
        return given  # of thousands, read before

    def load(one: Device | File) -> Sequence[Device]:
        if isinstance(one, Device):
            return (one,)
        return load_changed([one], (), variants=variants)

    found: SpooledList[Device] = SpooledList()
    _, issues = try_all(several(given), lambda one: found.extend(load(one)))
    return _sound(found, issues).held()


def several(given: object) -> tuple[Any, ...]:
    """Return records or files, of which one may be given alone."""
    if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
        return (given,)
    return tuple(given)


def load_changed(
    paths: Sequence[File], changes: Changes, *, variants: bool
) -> Sequence[Device]:
    """Load devices with changes, each file's base and every variant if asked for.

    Raises
    ------
    CallError
        A change is none, or reaches no device.
    SpecError
        With the issues of all files.
    """
    return _sound(*try_changed(paths, changes, variants=variants)).held()


def try_changed(
    paths: Sequence[File],
    changes: Changes,
    *,
    variants: bool,
    most: float = MOST_ISSUES,
) -> tuple[SpooledList[Device], list[Issue]]:
    """Load what can be read with changes, and the issues of what cannot.

    After more than `most` issues no further file is read.

    Raises
    ------
    CallError
        A change is none, or reaches no device though all could be read.
    """
    wanted = [read_change(text) for text in texts_of(changes)]
    devices: SpooledList[Device] = SpooledList()
    _, issues = try_all(
        paths,
        lambda path: devices.extend(_load(path, wanted, variants=variants)),
        most=most,
    )
    if wanted and not issues:
        check_used(wanted, (text for one in devices for text in one.origin.used))
    return devices, list(dict.fromkeys(issues))


def _load(
    path: File, changes: Sequence[Override], *, variants: bool
) -> tuple[Device, ...]:
    """Load the devices of one file, or the one that is named."""
    file = find(path, "device")
    document = open_file(file, "device")
    names: tuple[str, ...] = (file.variant,)
    if variants and not file.variant:
        names = variant_names(document)
    devices, issues = try_all(names, lambda name: _read(document, file, name, changes))
    if issues:
        raise all_of(issues)
    return tuple(devices)


def _read(
    document: YamlFile, file: NamedFile, variant: str, changes: Sequence[Override]
) -> Device:
    """Read one device with those of the changes that are its own."""
    root = root_of(document, variant) if changes else document.root
    own = [change for change in changes if change.is_of(file, variant, root)]
    same = replace(file, variant=variant, content=document.text.encode())
    if own:
        device = read_device(document, variant, own)
    else:
        kept = _kept(same.content or b"", document.file, document.base_name, variant)
        device = _copied(kept)
    return replace(
        device,
        read_again=partial(_read_again, same, tuple(change.text for change in own)),
        read_plain=partial(_read_again, same, (), ()),
    )


# A run reads a device more than once too (see reader.parse), and to check a data sheet
# takes ten times as long as to copy its record.
@lru_cache(maxsize=512)
def _kept(content: bytes, shown: str, base_name: str, variant: str) -> Device:
    """Read one device of a file with that content, as `read_device`, to be copied."""
    document = parse(content, shown, base_name=base_name)
    return read_device(replace(document, kind="device"), variant)


def _copied(part: Any) -> Any:  # noqa: ANN401 - of whatever a record consists
    """Return a record with arrays and records of its own, as if it had been read anew.

    Arrays can be written to, and records are told apart. `copy.deepcopy` keeps account
    of what it has met, which takes longer than to read the record.
    """
    if isinstance(part, np.ndarray):
        return part.copy()
    if isinstance(part, tuple):
        return tuple(_copied(item) for item in part)
    if not is_dataclass(part) or isinstance(part, type):
        return part
    own = object.__new__(type(part))
    own.__dict__.update({name: _copied(value) for name, value in vars(part).items()})
    return own


def _read_again(file: NamedFile, before: tuple[str, ...], changes: Changes) -> Device:
    """Read a device as it was read, with more changes after those that it has."""
    return load_device(file, (*before, *texts_of(changes)))


def load_procedure(
    path: Procedure | File | None = None,
    *,
    station: Station | File | None = None,
    age: str | None = None,
    environment: str | None = None,
) -> Procedure:
    """Read a procedure; without a path that of the paper. Raises as load_device.

    Parameters
    ----------
    path : str, Path or mapping, optional
        As in load_device.
    station : str, Path or mapping, optional
        A station file to do it at, for a procedure that names no station itself.
    age : str, optional
        Time from the calibration to its use, '1 year', where neither file gives one.
    environment : str, optional
        That it is used in, 'temperature 20 degC, vibration 1 g' or 'none', likewise.
    """
    if path is None:
        path = shipped("specs") / FOLDERS["procedure"] / f"{PAPER}.yaml"
    if isinstance(path, Procedure):
        procedure, shown = path, path.origin.file
    else:
        procedure = read_procedure(_open(path, "procedure"))
        shown = find(path, "procedure").shown
    if station is not None:
        procedure = done_at(procedure, load_station(station), shown)
    return _used(procedure, age, environment, shown)


def _used(
    procedure: Procedure, age: str | None, environment: str | None, shown: str
) -> Procedure:
    """Return a procedure whose unit is used as a call states."""
    if age is not None:
        procedure = aged(procedure, age, shown)
    return procedure if environment is None else used(procedure, environment, shown)


def uncalibrated(
    word: str,
    *,
    station: Station | File | None = None,
    age: str | None = None,
    environment: str | None = None,
) -> Procedure:
    """Return what stands for a procedure where nobody calibrates: all is held.

    Parameters
    ----------
    word : str
        'none', a unit as it was made; 'factory', one that its maker has calibrated.
    station : str, Path or mapping, optional
        Whose environment it is used in; there is no test that the station disturbs.
    age : str, optional
        Time since the maker's calibration.
    environment : str, optional
        As of load_procedure.

    Raises
    ------
    CallError
        It is another word.
    SpecError
        As of load_procedure.
    """
    if word not in UNCALIBRATED:
        raise CallError(
            f"found {word!r}, expected {' or '.join(UNCALIBRATED)}, or a procedure"
        )
    procedure = load_procedure()
    if station is not None:
        procedure = done_at(procedure, load_station(station), word)
    return _used(without_test(procedure, word), age, environment, word)


def load_calibration(
    calibration: Procedure | File | None = None,
    procedure: Procedure | File | None = None,
    *,
    station: Station | File | None = None,
    age: str | None = None,
    environment: str | None = None,
    mission: Mission | None = None,
    requirement: Requirement | None = None,
) -> Procedure:
    """Return what calibrated a unit, of all that a call says of it.

    Where it says nothing the test is the paper's. A mission alone takes a unit as its
    maker calibrated it; limits on the calibration need a test, which then is what the
    mission follows, too: one verdict is after one calibration.

    Parameters
    ----------
    calibration : str, Path, mapping or Procedure, optional
        'none', 'factory' (`uncalibrated`), or a procedure.
    procedure : str, Path, mapping or Procedure, optional
        In place of `calibration`.
    station, age, environment
        As of load_procedure.
    mission : Mission, optional
        That follows.
    requirement : Requirement, optional
        That is judged.

    Raises
    ------
    CallError
        Both say what calibrated it.
    SpecError
        As of load_procedure.
    """
    given = one_calibration(calibration, procedure)
    limited = () if requirement is None else requirement.kinds
    if given is None and mission is not None and {*limited} <= {MISSION}:
        given = FACTORY
    if isinstance(given, str) and given in UNCALIBRATED:
        return uncalibrated(given, station=station, age=age, environment=environment)
    if isinstance(calibration, str | Path):
        refuse_absent(find(calibration, "procedure"), "procedure", UNCALIBRATED)
    return load_procedure(given, station=station, age=age, environment=environment)


def one_calibration(calibration: Any, procedure: Any) -> Any:  # noqa: ANN401 - or several
    """Return what calibrated a unit, of the two that may say it.

    Raises
    ------
    CallError
        Both do.
    """
    given = [one for one in (calibration, procedure) if one is not None and one != ()]
    if len(given) > 1:
        first, second = map(_said, given)
        raise CallError(
            f"calibration {first} and procedure {second} both say what calibrated the "
            "unit; leave one out"
        )
    return given[0] if given else None


def _said(given: Procedure | File) -> str:
    """Name what a call says in a message."""
    return given.name if isinstance(given, Procedure) else str(given)


def without_test(procedure: Procedure, word: str) -> Procedure:
    """Return a procedure as if nobody did it: 'none' or 'factory' (uncalibrated)."""
    later = tuple(
        line
        for line in procedure.environment
        if isinstance(
            source_of(ENVIRONMENT, line.name).effect, TurnOnChange | Coefficient
        )
        and line.name != TEST_VIBRATION
    )
    at_all = tuple(f"{Name(line.name, owner=ENVIRONMENT)}:" for line in later)
    return replace(
        procedure,
        name=UNTESTED[word],
        formulas=word,
        held=tuple(name for kind in SENSORS for name in parameters_of(kind)),
        windows=(),
        orders=(),
        station=(),
        environment=later,
        assumptions=(
            sentence("assumed.untested", formulas=word),
            *(text for text in procedure.assumptions if text.startswith(at_all)),
        ),
        origin=Origin(file=word, sha256=sha256(word.encode()).hexdigest()),
        station_origin=procedure.station_origin if later else None,
    )


def load_station(path: Station | File) -> Station:
    """Read a test station. Raises as load_device."""
    return cast("Station", _record(path, "station"))


def load_stations() -> tuple[Station, ...]:
    """Load every test station that ships, in the order of files.

    Raises
    ------
    SpecError
        Everything that is wrong with any of the files.
    """
    folder = shipped("specs") / FOLDERS["station"]
    return tuple(_sound(*try_all(sorted(folder.glob("*.yaml")), load_station)))


def load_mission(path: Mission | File) -> Mission:
    """Read a mission. Raises as load_device."""
    return cast("Mission", _record(path, "mission"))


def load_requirement(path: Requirement | File) -> Requirement:
    """Read a requirement. Raises as load_device."""
    return cast("Requirement", _record(path, "requirement"))


def load_costs(path: Costs | File) -> Costs:
    """Read the costs of better lines. Raises as load_device."""
    return cast("Costs", _record(path, "costs"))


def load_recording(path: Recording | File) -> Recording:
    """Read what the columns of a recording are, or take a log as it is.

    A recording file is YAML; of another file the heads are its own. Raises as
    load_device.
    """
    if isinstance(path, str | Path) and Path(path).suffix.lower() not in YAML:
        file = find(path, "recording")
        if not file.path.exists():
            raise refuse(file.shown, "no such file, expected a recording")
        return bare_recording(file.path, file.shown)
    return cast("Recording", _record(path, "recording"))


def variants(path: File) -> tuple[str, ...]:
    """Return the variants of a device file, '' for its base unless it is abstract."""
    return variant_names(open_file(find(path, "device"), "device"))


def validate(path: File, changes: Changes = ()) -> Checked:
    """Check a file of any kind, of a device the base and every variant.

    Parameters
    ----------
    path : str or Path
        As in load_device; the variant after '#' must be one of the file's.
    changes : mapping, or sequence of str
        As in load_device.

    Returns
    -------
    Checked
        The kind of the file and what is assumed in it.

    Raises
    ------
    CallError
        A change is none, or reaches no device.
    SpecError
        Everything that is wrong with the file, each at its place.
    """
    (found,) = _sound(*try_valid([path], changes))
    return found


def try_valid(
    paths: Sequence[File], changes: Changes
) -> tuple[list[Checked], list[Issue]]:
    """Check files of any kind with changes, and the issues of what is not valid.

    Raises
    ------
    CallError
        A change is none, or reaches no device though all could be read.
    """
    wanted = [read_change(text) for text in texts_of(changes)]
    found, issues = try_all(paths, lambda path: _validate(path, wanted))
    if not issues:
        check_used(wanted, (text for one in found for text in one.changes))
    return found, issues


def _validate(path: File, changes: Sequence[Override]) -> Checked:
    """Check one file with those of the changes that are its own."""
    file = find(path)
    document = open_file(file)
    if document.kind != "device":
        _refuse_variant(file)
        _, read = _READERS[document.kind]
        said = read(document).assumptions
        return Checked(
            file=file.shown, kind=document.kind, variants=(), assumptions=said
        )
    named, issues = try_all([document], variant_names)
    names = named[0] if named else ("",)
    devices, more = try_all(
        dict.fromkeys((*names, file.variant or names[0])),
        lambda name: _read(document, file, name, changes),
    )
    if issues := [*issues, *more]:
        raise all_of(issues)

    def each(texts: Iterable[str]) -> tuple[str, ...]:
        """Return texts that are some, each once."""
        return tuple(dict.fromkeys(filter(None, texts)))

    return Checked(
        file=f"{file.shown}#{file.variant}" if file.variant else file.shown,
        kind=document.kind,
        variants=names,
        assumptions=each(text for one in devices for text in one.assumptions),
        ranges=each(device.range for device in devices),
        devices=tuple(devices),
        changes=each(text for one in devices for text in one.origin.used),
    )


_READERS: dict[str, tuple[type, Callable[[YamlFile], Any]]] = {
    "procedure": (Procedure, read_procedure),
    "station": (Station, read_station),
    "mission": (Mission, read_mission),
    "requirement": (Requirement, read_requirement),
    "costs": (Costs, read_costs),
    "recording": (Recording, read_recording),
}


def _record(given: Any, kind: str) -> object:  # noqa: ANN401 - a record or a file
    """Return a record, read where its file is given."""
    record, read = _READERS[kind]
    return given if isinstance(given, record) else read(_open(given, kind))


def _open(path: File, kind: str) -> YamlFile:
    """Open a file that can have no variants."""
    file = find(path, kind)
    _refuse_variant(file)
    return open_file(file, kind)


def _refuse_variant(file: NamedFile) -> None:
    """Refuse '#VARIANT' after a file that can have none."""
    if file.variant:
        message = f"found '#{file.variant}', only a device file has variants"
        raise refuse(file.shown, message)


def load_catalogue() -> tuple[Device, ...]:
    """Load every device that ships, with all its variants, in the order of files.

    Raises
    ------
    SpecError
        Everything that is wrong with any of the files.
    """
    folder = shipped("specs") / FOLDERS["device"]
    return load_all(sorted(folder.glob("*.yaml")))


def shipped_path(device: Device) -> str:
    """Return what a device of the catalogue is loaded by, wherever one works."""
    return str(shipped("specs") / FOLDERS["device"] / device.origin.file)


def try_all(
    paths: Iterable[P], load: Callable[[P], T], *, most: float = MOST_ISSUES
) -> tuple[list[T], list[Issue]]:
    """Load what can be read of several files, and the issues of what cannot.

    After more than `most` issues no further file is read.
    """
    found: list[T] = []
    issues: list[Issue] = []
    for path in paths:
        try:
            found.append(load(path))
        except SpecError as error:
            issues.extend(error.issues)
            if len(issues) > most:
                break
    return found, issues


def _sound(found: T, issues: Sequence[Issue]) -> T:
    """Return what was read, where nothing is wrong; raise what is."""
    if issues:
        raise SpecError(tuple(issues))
    return found


def load_all(paths: Sequence[File]) -> tuple[Device, ...]:
    """Load devices as `load_variants` does, from several files.

    Raises
    ------
    SpecError
        With the issues of all files.
    """
    return tuple(load_changed(paths, (), variants=True))


def load_variants(path: File) -> tuple[Device, ...]:
    """Load the devices of one file.

    Parameters
    ----------
    path : str or Path
        'FILE', its base (unless that is abstract) and every variant, or
        'FILE#VARIANT', that one; the bare name of a shipped device stands for FILE.

    Returns
    -------
    tuple of Device
        In the order of the file, the base first.

    Raises
    ------
    SpecError
        Everything that is wrong with the file, each at its place.
    """
    return _load(path, (), variants=True)
