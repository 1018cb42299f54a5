"""What is unknown does not look good: numbers that lack a line are lower bounds."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from builders import asked
from keeping import catalogue
from places import DOCS
from reading import on_terminal

from budget import load_device, load_procedure, load_requirement
from budget.calibration.problem import calibration_problem
from budget.known import AT_LEAST
from budget.methods.gum import propagate
from budget.missing import line_of
from budget.missing.expected import could_widen, lacking
from budget.missing.grades import grade
from budget.model.sources import lines_of
from budget.names import DERIVED, IMU, Name
from budget.question import question_of
from budget.report.allocation import allocation_answer, allocation_section
from budget.report.analysis.verdict import answer_rows
from budget.report.analysis.what_if import what_if_section
from budget.report.comparison.figures import front_plot
from budget.report.comparison.tables import rankings
from budget.report.document import to_csv, to_json
from budget.report.figures.density import density_plot
from budget.report.tables import group_tables
from budget.studies.allocation.allocate import allocate
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare
from budget.studies.densities import critical_densities
from budget.studies.evidence import coupling
from budget.studies.verdicts import MEETS, MEETS_IF
from budget.studies.what_if import one_at_a_time, what_if

ZHAO = load_device("zhao-2019")
REQUIREMENT = load_requirement(DOCS / "example" / "requirement.yaml")
REFERENCES = ("nominal", "as_tested", "next_turn_on")


def without(*names, device=ZHAO, kind="gyro"):
    """Return a device as if its data sheet did not give some lines of one sensor."""
    sensor = getattr(device, kind)
    lines = tuple(line for line in sensor.lines if line.name not in names)
    noise = {"angle_random_walk", "velocity_random_walk", "sample_noise"}
    missing = tuple(Name("noise" if n in noise else n, owner=kind) for n in names)
    absent = tuple(Name(name, owner=kind) for name in names)
    bare = replace(sensor, lines=lines, expected_missing=missing, not_given=absent)
    return replace(device, **{kind: bare})


@pytest.mark.parametrize("kind", ["gyro", "accelerometer"])
@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("formulas", ["corrected", "paper"])
def test_a_missing_line_reaches_what_it_reaches_when_given(kind, reference, formulas):
    """For each line in turn: the outputs that lack it are those of the coupling.

    What is derived of the mounting angles lacks it where they do.
    """
    procedure = replace(load_procedure(), formulas=formulas)
    sensor = getattr(ZHAO, kind)
    table = coupling(asked(sensor, procedure=procedure, reference=reference))
    for line in sensor.lines:
        bare = getattr(without(line.name, kind=kind), kind)
        found = lacking((bare,), procedure, reference=reference)
        reached = {name.group for name, lines in found.items() if lines}
        given = {
            cell.group
            for cell in table.cells
            if cell.source == f"{kind}.{line.name}" and cell.reaches
        }
        if Name("mounting_angle", owner=kind) in given:
            given |= {Name(quantity, owner=kind) for quantity in DERIVED}
            given.add(Name("misalignment", owner=IMU))
        assert reached == given, line.name


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("name", ["zhao-2019", "six-positions-and-turns"])
def test_every_line_could_widen_what_the_law_says_it_reaches(name, reference):
    """Drawn alone or by the law: the same outputs, of a sensor that gives nothing."""
    procedure = load_procedure(name)
    for whole in (ZHAO.gyro, ZHAO.accelerometer):
        varying = [
            line for line in lines_of(whole.kind) if line.varies and not line.is_initial
        ]
        bare = whole.with_lines(())
        given = bare.with_lines(line_of(line, whole.kind) for line in varying)
        found = could_widen((bare,), procedure, reference=reference)
        law = propagate(calibration_problem((given,), procedure, reference=reference))
        known = {output.name for output in law.outputs}
        assert {name.quantity for name in found} == {line.name for line in varying}
        for source, variance in zip(law.sources, law.source_variance, strict=True):
            if source in found:
                assert {*found[source]} & known == {
                    output.name
                    for output, part in zip(law.outputs, variance, strict=True)
                    if part > output.resolution**2
                }, source


def test_an_estimator_that_weighs_is_asked_of_the_missing_lines_alone():
    """Noise lines that a sheet does not lack give it no other weights."""
    procedure = replace(load_procedure("one-axis-rate-table"), formulas="weighted")
    gyro = load_device("ltm210#S1B").gyro
    found = lacking((gyro,), procedure, reference="nominal")
    missing = {name.quantity for name in gyro.expected_missing}
    given = gyro.with_lines(
        line_of(line, "gyro") for line in lines_of("gyro") if line.name in missing
    )
    law = propagate(calibration_problem((given,), procedure, reference="nominal"))

    for k, output in enumerate(law.outputs):
        reached = law.source_variance[:, k] > output.resolution**2
        assert {*found[output.name]} == {
            name for name, is_so in zip(law.sources, reached, strict=True) if is_so
        } & {*gyro.expected_missing}, output.name


def test_a_bias_that_lacks_its_line_is_this_or_more():
    """Without bias repeatability only the biases are lower bounds, in every form."""
    budget = analyze(without("bias_repeatability"), validate=False)
    document = json.loads(to_json(budget))
    marked = {
        f"{row['sensor']}.{row['parameter']}"
        for row in document["outputs"]
        if row["lower_bound"]
    }
    full = analyze(ZHAO, validate=False)
    tables = {table.title: table for table in group_tables(budget)}

    assert marked == {"gyro.bias"}
    assert not any(row.standard_uncertainty.is_bound for row in full.outputs)
    assert [row.u.text[0] for row in tables["gyro bias"].rows] == ["≥"] * 3
    assert "bias repeatability not given" in tables["gyro bias"].gaps
    assert tables["gyro scale factor"].gaps == ""
    for row in budget.outputs:
        flags = {
            part.source: part.standard_uncertainty.is_bound
            for part in row.contributions
        }
        assert flags.pop("interaction") is row.standard_uncertainty.is_bound
        assert not any(flags.values())
    totals = [line for line in to_csv(budget).splitlines() if ",total," in line]
    assert sum(line.endswith(",true") for line in totals) == 3


def test_what_no_line_reaches_is_not_known():
    """An angle that no given line reaches prints '?', never 0."""
    kept = "scale_factor_repeatability"
    names = [line.name for line in ZHAO.gyro.lines if line.name != kept]
    bare = replace(without(*names), accelerometer=None)
    tables = group_tables(analyze(bare, validate=False))
    texts = {table.parameter: {row.u.text for row in table.rows} for table in tables}

    assert texts["mounting_angle"] == texts["bias"] == {"?"}
    assert all(text.startswith("≥") for text in texts["scale_factor"])


def test_what_is_left_out_on_purpose_is_not_missing():
    """With --only a line that was not asked for lacks nowhere."""
    bare = without("bias_repeatability")
    alone = analyze(bare, only=("gyro.bias_stability",), validate=False)

    assert not any(row.standard_uncertainty.is_bound for row in alone.outputs)


def compared(*devices, **options):
    """Compare devices by the law, with the shipped catalogue behind them."""
    return compare(devices, REQUIREMENT, catalogue=catalogue(), method="gum", **options)


def gyro_ranks(comparison):
    """Return the names of the gyros, best first."""
    return [one.name for one in comparison.devices if one.sensor == "gyro"]


@pytest.mark.parametrize("times", [0.1, 1.0, 30.0])
def test_publishing_less_never_ranks_higher(times):
    """A device that does not give a line has no number before itself with that line.

    Below the numbers it may stand before itself: it is open, or exceeds by less so far.
    """
    device = replace(scaled(ZHAO, times), accelerometer=None)
    names = [line.name for line in ZHAO.gyro.lines]
    bare = [replace(without(name, device=device), name=name) for name in names]
    found = compared(*bare, replace(device, name="full"))
    first, *others = gyro_ranks(found)
    gyros = {one.name: one for one in found.devices if one.sensor == "gyro"}
    numbered = {n for n, one in gyros.items() if one.verdict in {MEETS, MEETS_IF}}

    assert sorted([first, *others]) == sorted([*names, "full"])
    assert (first == "full") == (gyros["full"].verdict == MEETS) == (times < 1.0)
    if first != "full":
        assert numbered == set()


def test_the_undecidable_come_before_those_that_fail():
    """Nearly no error and a line missing: open, so before what fails; on no front."""
    bare = replace(without("bias_stability", device=scaled(ZHAO, 0.01)), mass="1 g")
    bad = replace(scaled(ZHAO, 50.0), name="bad", mass="9 kg")
    comparison = compared(replace(bare, name="bare"), bad)
    found = {one.name: one for one in comparison.devices if one.sensor == "gyro"}
    (table, *_) = rankings(comparison)

    assert gyro_ranks(comparison) == ["bare", "bad"]
    assert found["bare"].verdict == "undecidable"
    assert found["bare"].utilisation.is_bound
    assert not found["bad"].utilisation.is_bound
    assert found["bare"].on_front == ()
    assert "mass" in found["bad"].on_front
    assert "only bad gives one" in front_plot(table, "mass")
    assert table.rows[0].utilisation.startswith("≥ ")
    assert table.rows[0].conformance == ""  # at the most 100 says nothing


def test_at_worst_is_of_the_same_technology_and_grade():
    """A navigation grade gyro gets no automotive figure; without peers '?' stands."""
    missing = without("scale_factor_repeatability")
    chip = replace(scaled(ZHAO, 1e4), name="chip", technology="MEMS")
    peer = replace(scaled(ZHAO, 0.2), name="peer", technology="FOG")
    bare = replace(missing, name="bare", technology="FOG, 3 axes")

    def worst(*catalogue):
        found = compare(
            (bare,), REQUIREMENT, catalogue=catalogue, method="gum", missing="worst"
        )
        (one,) = [row for row in found.devices if row.sensor == "gyro"]
        return one.missing

    assert grade(chip.gyro) != grade(bare.gyro)
    assert worst(chip).filling.lines == ()
    assert worst(replace(chip, technology="FOG")).filling.lines == ()
    alike = replace(peer, gyro=replace(scaled(ZHAO, 0.3).gyro, device="peer"))
    assert grade(alike.gyro) == grade(bare.gyro)
    assert tuple(map(str, worst(chip, alike).filling.lines)) == (
        f"gyro.scale_factor_repeatability {alike.gyro.lines[3].printed} (of peer)",
    )


def scaled(device, times):
    """Return a device with all its lines that much larger."""

    def grown(sensor):
        lines = tuple(replace(line, u=line.u * times) for line in sensor.lines)
        return replace(sensor, lines=lines)

    return replace(
        device, gyro=grown(device.gyro), accelerometer=grown(device.accelerometer)
    )


def test_what_the_page_computes_with_is_marked():
    """Density, sliders and one-at-a-time table say that a line is missing."""
    bare = without("bias_stability")
    budget = analyze(bare, requirement=REQUIREMENT, validate=False)
    model = what_if(question_of(budget), budget=budget)
    lacking_of = {
        row.output.name: row.standard_uncertainty.is_bound for row in budget.outputs
    }

    lacks = map(bool, model.why)
    assert dict(zip(bound_names(model), lacks, strict=True)) == lacking_of
    assert any(lacking_of.values())
    assert not all(lacking_of.values())
    document = model.to_dict()["outputs"]
    assert {row["name"]: row["lower_bound"] for row in document} == lacking_of
    steps = one_at_a_time(model)
    assert {row.lower_bound for row in steps} == {
        lacking_of[row.output.name] for row in steps
    }
    assert all(
        row.steps[0].utilisation.is_bound == (row.source.name.owner == "gyro")
        for row in steps
    )
    table = (
        what_if_section(budget, model, steps, devices=question_of(budget).devices)
        .blocks[1]
        .table
    )
    texts = [cell.text for group in table.groups for row in group.rows for cell in row]
    assert any(text.startswith(AT_LEAST) for text in texts)
    densities = critical_densities(
        question_of(budget), budget, budget.assessment, trials=200
    )
    for density in densities:
        marked = lacking_of[density.output.name]
        data = density_plot(density, coverage=0.95).picture.data
        cells = [row[1].text for row in data.groups[0].rows]
        assert density.u.is_bound == marked
        assert any(text.startswith(AT_LEAST) for text in cells) == marked
        assert (
            "specifications are not given"
            in density_plot(density, coverage=0.95).said.title
        ) == marked


def bound_names(model):
    """Return the names of the outputs of a model."""
    return [output.name for output in model.outputs]


@pytest.mark.slow
def test_an_allocation_says_what_its_parts_of_limits_lack():
    """JSON, terminal and page mark the outputs that a missing line would reach."""
    bare = without("bias_stability")
    found = allocate(bare, requirement=REQUIREMENT, catalogue=(), validate=False)
    whole = allocate(ZHAO, requirement=REQUIREMENT, catalogue=(), validate=False)
    reached = lacking(bare.sensors, load_procedure(), reference=REQUIREMENT.reference)
    marked = {row["output"]: row["lower_bound"] for row in found.to_dict()["outputs"]}

    assert marked == {name: bool(reached[name]) for name in marked}
    assert ">= " in on_terminal(allocation_answer(found))
    assert AT_LEAST in repr(allocation_section(found))
    assert not any(row["lower_bound"] for row in whole.to_dict()["outputs"])
    assert ">= " not in on_terminal(allocation_answer(whole))


def test_documents_say_where_nothing_is_known():
    """Without any line that reaches it an output keeps its 0, marked as not known."""
    bare = without("scale_factor_repeatability", "bias_stability", "angle_random_walk")
    document = json.loads(to_json(analyze(bare, validate=False)))
    unknown = {
        f"{row['sensor']}.{row['parameter']}"
        for row in document["outputs"]
        if row["nothing_known"]
    }

    assert unknown == {"gyro.scale_factor"}
    assert all(
        row["lower_bound"] for row in document["outputs"] if row["nothing_known"]
    )


def test_equal_contributions_keep_their_order():
    """Where shares differ by rounding only, they are in the order of the sources."""
    budget = analyze(ZHAO, validate=False)
    nudged = [
        replace(
            row,
            contributions=tuple(
                replace(part, share=part.share * (1.0 + 1e-12 * place))
                for place, part in enumerate(row.contributions)
            ),
        )
        for row in budget.outputs
    ]
    again = replace(budget, outputs=tuple(nudged))
    first, second = (
        [
            (row.title, [part.name for part in row.shares.parts])
            for row in answer_rows(one, group_tables(one), None)
        ]
        for one in (budget, again)
    )
    assert first == second


@pytest.mark.parametrize("environment", ["none", "vibration 1 g"])
def test_lines_that_are_not_given_reach_what_a_mission_asks_for(environment):
    """Its own outputs, not parameters; what a use exercises where it is stated."""
    found = analyze(
        "stim300#5g",
        calibration="factory",
        mission="outage-60-s",
        environment=environment,
        validate=False,
    ).could_widen
    walk = found[Name("rate_random_walk", owner="gyro")]
    assert {name.owner for name in walk} == {"mission"}
    assert {name.quantity for name in walk} == {"position", "velocity", "attitude"}
    reached = found[Name("vibration_rectification", owner="gyro")]
    assert bool(reached) is (environment != "none")
    # A level flight at a steady speed has no acceleration whose cube counts.
    assert not found[Name("scale_factor_cubic", owner="accelerometer")]
