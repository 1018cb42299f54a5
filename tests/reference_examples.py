"""References and their inputs, as several test modules build them."""

from __future__ import annotations

import pickle
import shutil
from dataclasses import replace

import pytest

from budget.references.check import make_reference
from budget.references.files import (
    digest,
    present_documents,
    stored_documents,
    take,
)
from budget.references.jobs import compute
from budget.references.records import Stored
from budget.references.store import read_reference, reference_text

DEVICE = """\
name: Two sensors
gyro:
  nominal: {bias: 3 deg/h}
  errors:
    bias_repeatability: 0.05 deg/h
    bias_stability: {value: 0.04 deg/h, correlation_time: 300 s}
    angle_random_walk: 0.005 deg/sqrt(h)
    scale_factor_repeatability: {value: 50 ppm, meaning: max}
    scale_factor_asymmetry: 40 ppm
    mounting_repeatability: 2 arcsec
accelerometer:
  errors:
    bias_repeatability: 37 ug
    sample_noise: 50 ug
    scale_factor_repeatability: 37 ppm
    mounting_repeatability: {value: 2 arcsec, axes: {xy: 4 arcsec}}
notes: not a number
"""


def parts_of(text=DEVICE, *, job="analyze", more=()):
    """Return the parts of a device text and shipped files, (role, name) each."""
    device = replace(
        take("device", "zhao-2019"),
        file="imu.yaml",
        text=text,
        sha256=digest(text),
    )
    inputs = [device, take("procedure", "zhao-2019")]
    inputs += [take(role, name) for role, name in more]
    return stored_documents(inputs, reference="test", job=job)


def snapshot(text=DEVICE, *, job="analyze", more=(), **asked):
    """Compute a job on a device text."""
    return compute(job, parts_of(text, job=job, more=more), Stored(**asked))


def computing_once():
    """Compute each budget once, however often tests ask for it (for a fixture).

    What one is of is all that its files say, wherever in them it stands: a file with
    one key exchanged and one that was written so are the same.
    """
    kept = {}

    def computed(job, inputs, asked, *, workers=1):
        files = [(one.kind, one.base_name, said(one.root)) for one in inputs]
        content = pickle.dumps((job, files, asked, workers))
        if content not in kept:
            kept[content] = compute(job, inputs, asked, workers=workers)
        return kept[content]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("budget.references.check.compute", computed)
        yield


def said(node):
    """Return all that a node and those below it say, without their places."""
    if isinstance(node.value, dict):
        return [(key, said(child)) for key, child in node.value.items()]
    if isinstance(node.value, tuple):
        return tuple(map(said, node.value))
    return node.value, node.written


def copied(path, folder):
    """Return the copy of a reference, made beside a copy of its device."""
    for name in ("imu.yaml", path.name):
        shutil.copy(path.with_name(name), folder)
    return folder / path.name


def store(folder, text=DEVICE, *, job="analyze", more=(), name="ref.json", **asked):
    """Write a device file and a reference of it; return the path of the latter."""
    (folder / "imu.yaml").write_text(text, encoding="utf-8")
    inputs = [take("device", folder / "imu.yaml", folder)]
    inputs += [take("procedure", "zhao-2019", folder)]
    inputs += [take(role, one, folder) for role, one in more]
    reference = make_reference(job, inputs, Stored(**asked))
    path = folder / name
    path.write_text(reference_text(reference), encoding="utf-8")
    return path


def stored(path):
    """Read a reference back."""
    return read_reference(path, path.name)


def now(reference, folder):
    """Return the inputs of a reference as their files are now."""
    return present_documents(
        reference.inputs, folder, reference="test", job=reference.job
    )
