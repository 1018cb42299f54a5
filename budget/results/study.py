"""A study: what was asked, the files and settings it rests on, and its frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from budget import views
from budget.documents import Documented, Shown, written

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from budget.inputs.changes import Changed
    from budget.inputs.records import (
        Costs,
        Device,
        Mission,
        Origin,
        Procedure,
        Requirement,
        Station,
    )
    from budget.names import Name
    from budget.settings import Settings


@written(
    "role_and_file",
    """
    role: 'device', 'procedure', 'station', ...
    *self as file
    """,
)
@written(
    "file",
    """
    name: base name, with #VARIANT where one was chosen
    sha256: of its bytes
    changes?: that the call laid over it
    """,
)
@dataclass(frozen=True, kw_only=True)
class InputFile(Documented):
    """One file that a result depends on, by base name and content."""

    role: str  # device, procedure, requirement
    name: str
    sha256: str
    changes: tuple[Changed, ...] = ()  # that the call laid over it


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Study(Shown, Documented):
    """What a study has found, a table, and what it rests on.

    Of one Question all but what it has found is put together by
    budget.studies.envelope.
    """

    title: str = ""  # names of the devices
    inputs: tuple[InputFile, ...]  # files that it depends on
    settings: Settings  # what it depends on besides
    assumptions: Sequence[str]
    warnings: tuple[str, ...]
    # What it answers (budget.question.Question): results know nothing of files.
    question: Any = field(default=None, repr=False)

    @property
    def not_given(self) -> tuple[Name, ...]:
        """Lines that the data sheets do not give."""
        found: tuple[Name, ...] = self.question.not_given
        return found

    def to_frame(self) -> pd.DataFrame:
        """Return its rows as a pandas frame, in printed units."""
        table: pd.DataFrame = views.view().study_frame(self)
        return table


def input_files(
    devices: Sequence[Device],
    **files: Device | Procedure | Mission | Requirement | Costs | None,
) -> tuple[InputFile, ...]:
    """Return the files that a result depends on; several devices are numbered.

    Those that there are of `files` follow, each with its role.
    """
    number = " {}" if len(devices) > 1 else ""
    return (
        *(
            input_file(f"device{number.format(place)}", device)
            for place, device in enumerate(devices, start=1)
        ),
        *results_of(devices),
        *(input_file(role, file) for role, file in files.items() if file is not None),
        *named_files([*files.values()]),
    )


def numbered_files(
    role: str, files: Sequence[tuple[str, str]]
) -> tuple[InputFile, ...]:
    """Return files of one role by name and SHA-256; several are numbered."""
    number = " {}" if len(files) > 1 else ""
    return tuple(
        InputFile(role=f"{role}{number.format(place)}", name=name, sha256=digest)
        for place, (name, digest) in enumerate(files, start=1)
    )


def results_of(devices: Sequence[Device]) -> tuple[InputFile, ...]:
    """Return the results of recorded calibrations that stand for predictions."""
    every = [one.measured for one in devices if one.measured is not None]
    return numbered_files("measured", [(one.file, one.sha256) for one in every])


def named_files(
    files: Sequence[Device | Procedure | Mission | Requirement | Costs | None],
) -> tuple[InputFile, ...]:
    """Return the files that files name: stations of procedures, trajectories."""
    named: list[tuple[str, Origin | None]] = [
        (role, getattr(one, key, None))
        for role, key in (("station", "station_origin"), ("trajectory", "trajectory"))
        for one in files
    ]
    found = {(role, origin) for role, origin in named if origin is not None}
    return tuple(
        InputFile(role=role, name=origin.file, sha256=origin.sha256)
        for role, origin in sorted(found, key=lambda one: (one[0], one[1].file))
    )


def input_file(
    role: str, record: Device | Procedure | Mission | Requirement | Costs | Station
) -> InputFile:
    """Return the file that a record was read from."""
    origin = record.origin
    return InputFile(
        role=role, name=origin.file, sha256=origin.sha256, changes=origin.changes
    )
