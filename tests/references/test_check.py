"""The check can fail: each figure of each shipped device, 1 % larger, is named."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass, replace

import pytest
from reference_examples import computing_once

from budget.inputs.device import variant_names
from budget.inputs.files import find, open_file, shipped_names
from budget.references.check import check, make_reference
from budget.references.difference import find_moves
from budget.references.exchange import KeyChange, effective, exchange, input_changes
from budget.references.files import (
    shipped_references,
    stored_documents,
    take,
)
from budget.references.jobs import by_law, compute
from budget.references.records import Stored
from budget.references.store import read_reference
from budget.resources import shipped

NUMBER = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?")
# Keys of a figure that are words, though some begin with a digit ('1 sigma').
WORDS = {"meaning", "distribution", "definition", "includes", "horizon", "condition"}
WORDS |= {"source"}

# Under these references the figure moves nothing, and is reported so.
IDLE = {
    # Only eq. 4 as printed carries the true mounting angles into the bias.
    *(
        (f"zhao-2019-corrected-{origin}", "gyro.nominal.mounting_angle")
        for origin in ("nominal", "next_turn_on")
    ),
}


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A figure of a device: the way to it and its node."""

    device: str  # file and variant
    steps: tuple
    node: object

    @property
    def key(self):
        """How messages name it."""
        return KeyChange(steps=self.steps, before=None, after=None).path

    def larger(self):
        """Return the text of the figure with 1 % more."""
        found = NUMBER.match(self.node.written)
        value = float(found[0]) * 1.01
        return f"{value:.12g}{self.node.written[found.end() :]}"

    def __str__(self):
        """Name the test."""
        return f"{self.device}-{self.key}"


def leaves(node, steps=()):
    """Yield every value below a node, with the way to it."""
    children = {}
    if isinstance(node.value, dict):
        children = node.value
    elif isinstance(node.value, tuple):
        children = dict(enumerate(node.value))
    else:
        yield steps, node
    for step, child in children.items():
        yield from leaves(child, (*steps, step))


def all_figures(device):
    """Return every figure of a device that is a number with a unit, or has one."""
    stem, _, variant = device.partition("#")
    document = effective(open_file(find(stem, "device"), "device"), variant)
    return [
        Figure(device=device, steps=steps, node=node)
        for steps, node in leaves(document.root)
        if steps[-1] not in WORDS
        and steps[0] in {"gyro", "accelerometer", "figures"}
        and isinstance(node.value, str)
        and NUMBER.match(node.written)
    ]


def model_figures(device):
    """Return those that a model of a calibration uses."""
    return [
        figure
        for figure in all_figures(device)
        if figure.steps[0] != "figures"
        # Every calibration finds what a new unit has (tests/calibration/test_initial).
        and not any(str(step).startswith("initial_") for step in figure.steps)
    ]


def devices(file):
    """Return every device in a file that ships: its variants, and its base."""
    names = variant_names(open_file(find(file, "device"), "device"))
    return [f"{file}#{name}" if name else file for name in names]


def references_of(device):
    """Return the shipped references of kind analyze that are of a device."""
    stem, _, variant = device.partition("#")
    found = []
    for one in shipped_references():
        reference = read_reference(one.path, one.shown)
        own = [i for i in reference.inputs if i.role == "device"]
        if reference.job == "analyze" and own[0].file.endswith(f"/{stem}.yaml"):
            assert own[0].variant == variant
            found.append((one, reference))
    return found


REFERENCED = ("zhao-2019", "hg4930#C", "stim300#5g", "ltys11cj1x")


computed_once = pytest.fixture(scope="module", autouse=True)(computing_once)


@pytest.fixture(scope="module")
def specs(tmp_path_factory):
    """Provide a copy of all that ships, whose devices may be changed."""
    folder = tmp_path_factory.mktemp("specs") / "specs"
    shutil.copytree(shipped("specs"), folder)
    return folder


@pytest.fixture(scope="module")
def references():
    """Provide the shipped references by device, by law, which is fast."""
    found = {}
    for device in REFERENCED:
        found[device] = []
        for one, reference in references_of(device):
            base = reference
            if by_law(reference.settings) != reference.settings:
                inside = [
                    replace(i, file=i.file.rpartition("/")[2]) for i in reference.inputs
                ]
                law = make_reference("analyze", inside, by_law(reference.settings))
                base = replace(law, inputs=reference.inputs)
            found[device].append((one.shown, base))
    return found


def perturbed(specs, references, *figures):
    """Write the device with those figures 1 % larger; check all its references."""
    device = figures[0].device
    path = specs / "devices" / f"{device.partition('#')[0]}.yaml"
    before = path.read_text(encoding="utf-8")
    lines = before.splitlines(keepends=True)
    for figure in sorted(figures, key=lambda one: one.node.at, reverse=True):
        line, column = figure.node.at.line - 1, figure.node.at.column - 1
        head, tail = lines[line][:column], lines[line][column:]
        assert figure.node.written in tail
        lines[line] = head + tail.replace(figure.node.written, figure.larger(), 1)
    path.write_text("".join(lines), encoding="utf-8")
    try:
        return {
            name: check(reference, specs / "references", name=name, root=specs)
            for name, reference in references[device]
        }
    finally:
        path.write_text(before, encoding="utf-8")


def test_all_devices_of_references_are_here():
    """Every device with a reference of its own is perturbed below."""
    files = {
        one.file.rpartition("/")[2].removesuffix(".yaml")
        for found in shipped_references()
        for one in read_reference(found.path, found.shown).inputs
        if one.role == "device" and "compare" not in found.shown
    }
    assert files == {device.partition("#")[0] for device in REFERENCED}


@pytest.mark.parametrize("device", REFERENCED)
def test_unchanged_references_hold(specs, references, device):
    """Control: without a change nothing moves, and no change is reported."""
    assert references[device]
    for name, reference in references[device]:
        found = check(reference, specs / "references", name=name, root=specs)
        assert found.holds
        assert not [change for change in found.changes if change.where != "tool"]


@pytest.mark.slow
@pytest.mark.parametrize("device", REFERENCED)
def test_a_figure_changed_by_one_percent_is_caught(specs, references, device):
    """Some number moved, that one key is named, and it explains what moved."""
    figures = model_figures(device)
    assert figures
    for figure in figures:
        assert_caught(perturbed(specs, references, figure), figure)


def assert_caught(checks, figure):
    """Assert that checks of references find that figure, and no other, changed."""
    assert not all(found.holds for found in checks.values()) or len(checks) == 1, str(
        figure
    )
    for name, found in checks.items():
        (change,) = (c for c in found.changes if c.where != "tool")
        assert change.key == figure.key
        assert (change.before, change.after) == (figure.node.written, figure.larger())
        if (name, figure.key) in IDLE:
            assert (found.holds, change.acts) == (True, False)
            continue
        if name.endswith("as_tested") and found.holds:
            # What cancels against the value during the test moves nothing there.
            assert "repeatability" in figure.key
            continue
        assert not found.holds, name
        assert change.acts is True
        for move in found.moves:
            (cause,) = move.causes
            assert cause.change == change
            assert abs(cause.amount - move.difference) <= 1e-6 * abs(move.difference)


@pytest.mark.parametrize("device", REFERENCED[1:])  # the paper prints no others
def test_figures_that_no_model_uses_are_reported_without_effect(
    specs, references, device
):
    """They move no number, and the check says of each by name that it changed."""
    figures = [
        figure
        for figure in all_figures(device)
        if figure.steps[0] == "figures" and figure.steps[-1] == "value"
    ]
    assert figures
    for found in perturbed(specs, references, *figures).values():
        assert found.holds
        changes = [change for change in found.changes if change.where != "tool"]
        assert {change.key: change.acts for change in changes} == {
            figure.key: False for figure in figures
        }
        assert len(changes) == len(figures)


WARMER = """
environment:
  temperature: {ramp: 1 degC/h, mission: 10 degC}
  vibration: {test: 0 g, mission: 3 g}
"""


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_is_missing")
@pytest.mark.parametrize("file", shipped_names("device"))
def test_every_figure_of_the_catalogue_moves_a_number(file, tmp_path):
    """By law and reference nominal, each figure of each device that ships is caught.

    Those of temperature and vibration act in a later turn-on at another one only.
    """
    warmer = tmp_path / "warmer.yaml"
    text = (shipped("specs") / "procedures" / "zhao-2019.yaml").read_text("utf-8")
    warmer.write_text(text + WARMER, encoding="utf-8")
    felt = set()
    for device in devices(file):
        assert_felt(device, warmer, felt)


def is_felt_later(key):
    """Whether a line says what the environment does."""
    return "temperature" in key or "vibration" in key


def assert_felt(device, warmer, felt):
    """Assert that each figure of a device moves a number, and no key but its own.

    One that a variant has as another one has was `felt` there.
    """
    stem, _, variant = device.partition("#")
    every = {(one.steps, one.node.written): one for one in model_figures(device)}
    bases, figures = {}, [one for own, one in every.items() if own not in felt]
    felt |= every.keys()
    for warm, procedure, asked in (
        (False, "zhao-2019-eq4", Stored()),
        (True, str(warmer), Stored(reference="next_turn_on")),
    ):
        sensors = {f.steps[0] for f in figures if is_felt_later(f.key) is warm}
        if not sensors:
            continue
        inputs = [
            replace(take("device", stem), variant=variant),
            take("procedure", procedure),
        ]
        part, steps = stored_documents(inputs, reference=device, job="analyze")
        for sensor in sensors:
            base = compute("analyze", (alone(part, sensor), steps), asked)
            bases[warm, sensor] = part, steps, asked, base

    for figure in figures:
        sensor = figure.steps[0]
        part, procedure, asked, base = bases[is_felt_later(figure.key), sensor]
        larger = replace(figure.node, value=figure.larger(), written=figure.larger())
        key = KeyChange(steps=figure.steps, before=figure.node, after=larger)
        changed = exchange(part, key)
        own = alone(changed, sensor)
        moves = find_moves(base, compute("analyze", (own, procedure), asked))
        (one,) = input_changes((part,), (changed,))
        assert moves, figure
        assert one.change.key == figure.key


def alone(document, sensor):
    """Return a device file with one of its sensors: a figure acts on its own."""
    other = {"gyro": "accelerometer", "accelerometer": "gyro"}[sensor]
    kept = {key: one for key, one in document.root.value.items() if key != other}
    if ranges := kept.pop("range", None):
        own = {key: one for key, one in ranges.value.items() if key != other}
        kept |= {"range": replace(ranges, value=own)} if own else {}
    return replace(document, root=replace(document.root, value=kept))
