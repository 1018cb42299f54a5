"""The devices that ship, and what a user means by FILE where many may be given."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.errors import SpecError
from budget.resources import shipped
from budget.spec.device import read_device, variant_names
from budget.spec.files import FOLDERS, find, open_file
from budget.spec.tree import all_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from budget.errors import Issue
    from budget.spec.records import Device


def load_catalogue() -> tuple[Device, ...]:
    """Load every device that ships, with all its variants, in the order of files.

    Raises
    ------
    SpecError
        Everything that is wrong with any of the files.
    """
    folder = shipped("specs") / FOLDERS["device"]
    return load_all(sorted(folder.glob("*.yaml")))


def load_all(paths: Sequence[str | Path]) -> tuple[Device, ...]:
    """Load devices as `load_variants` does, from several files.

    Raises
    ------
    SpecError
        With the issues of all files.
    """
    devices: list[Device] = []
    issues: list[Issue] = []
    for path in paths:
        try:
            devices.extend(load_variants(path))
        except SpecError as error:
            issues.extend(error.issues)
    if issues:
        raise SpecError(tuple(issues))
    return tuple(devices)


def load_variants(path: str | Path) -> tuple[Device, ...]:
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
    file = find(path, "device")
    document = open_file(file, "device")
    if file.variant:
        return (read_device(document, file.variant),)
    devices: list[Device] = []
    issues: list[Issue] = []
    for name in variant_names(document):
        try:
            devices.append(read_device(document, name))
        except SpecError as error:
            issues.extend(error.issues)
    if issues:
        raise all_of(issues)
    return tuple(devices)
