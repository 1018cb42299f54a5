"""The report as a document: what it says of a budget, before it is a page."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import pytest
from numpy.testing import assert_allclose
from reading import assert_says, find, lines, names, rows, say, section
from report_examples import (
    ACCELEROMETER,
    AFTER,
    GYRO,
    make_assessment,
    make_budget,
    make_device,
    make_output,
    make_outputs,
    make_procedure,
    make_standing,
)

from budget.inputs import load_requirement
from budget.inputs.device import read_device
from budget.inputs.reader import parse
from budget.names import key_title
from budget.question import Question
from budget.report.analysis.build import Extra, report_document
from budget.report.blocks import (
    Cell,
    Equation,
    Paragraph,
    Picture,
    Section,
    Sliders,
    Table,
)
from budget.report.device_file import MARK
from budget.report.tables import group_tables
from budget.report.writing import print_by_axis
from budget.resources import shipped
from budget.results import CapAssessment
from budget.studies.evidence import gather_evidence

TACTICAL = shipped("specs") / "requirements" / "tactical-grade.yaml"

pytestmark = pytest.mark.usefixtures("not_drawn")

NO_GAPS: dict = {"question": SimpleNamespace(not_given=()), "could_widen": {}}


@cache
def example_evidence(reference="nominal", *, gyro_only=False):
    """Compute what stands behind the example device once."""
    device = make_device()
    if gyro_only:
        device = replace(device, accelerometer=None)
    outputs = {"outputs": make_outputs("gyro", GYRO)} if gyro_only else {}
    budget = make_budget(**outputs)
    settings = replace(budget.settings, reference=reference)
    return gather_evidence(
        Question.of(device, procedure=make_procedure(), reference=reference),
        replace(budget, settings=settings),
    )


def document(budget=None, *, assessment=None, device=None, **changes):
    """Return the report on the example device."""
    formulas = changes.pop("formulas", "corrected")
    arguments = {
        "devices": (device or make_device(),),
        "procedure": make_procedure(formulas=formulas),
        "evidence": example_evidence(),
        "assessment": assessment,
        "command_line": "budget report zhao-2019.yaml",
        "date": "2026-11-21",
    }
    return report_document(budget or make_budget(), **(arguments | changes))


@cache
def example():
    """Return the report without a requirement, once."""
    return document()


@cache
def failing():
    """Return the report on limits that are not held, once."""
    budget = make_budget()
    return document(budget, assessment=make_assessment(budget))


def answer(report):
    """Return the rows of the table on page one."""
    (table,) = find(section(report, "overview"), Table)
    return [row for group in table.groups for row in group.rows]


@pytest.mark.slow
def test_page_one_answers_first():
    """The sections of page one come before all others: a table, what may change it."""
    for report in (example(), failing()):
        first = [s.on_first_page for s in report.sections]
        assert first == sorted(first, reverse=True)
        assert names(report)[:2] == ["overview", "gaps"]


@pytest.mark.slow
def test_every_section_of_a_full_report_is_there():
    """Inputs to provenance stand in the order in which a reviewer asks for them."""
    assert names(failing()) == [
        *(
            "overview",
            "gaps",
            "limits",
            "what-if",
            "budget",
            "inputs",
            "procedure",
        ),
        *("coupling", "validity", "distributions", "method", "provenance"),
        "sign-off",
    ]


def test_names_of_links_are_unique():
    """No two sections, tables or pictures share the name that links lead to."""
    found = [s.name for s in failing().sections]
    found += [p.name for p in find(failing(), Picture)]

    assert len(found) == len(set(found))


def test_report_without_requirement_gives_u_of_each_group():
    """Without a requirement the table says U of each group and what makes it up."""
    found = {row[0].text: row for row in answer(example())}
    z = found["Gyro bias z"]

    assert [cell.text for cell in z[:3]] == ["Gyro bias z", "0.119", "deg/h"]
    assert_says(z[-1].text, "bias repeatability 67 %", "bias stability 31 %", "rest")
    assert len(found) == 6
    assert example().headline == "Error budget, U at 95 % coverage"
    assert not any("of the limit" in line for line in lines(example()))


def test_the_bar_is_what_the_budget_has():
    """Its parts are the shares of the output of the row, small ones gathered, to 1."""
    budget = make_budget()
    for row in answer(failing()):
        shares = row[-1].shares
        own = budget.output(shares.outputs[0]).contributions
        exact = {str(part.source): part.share for part in own}
        assert_allclose(sum(one.share for one in shares.parts), 1.0, rtol=1e-2)
        for one in shares.parts:
            if one.name != "other":
                assert_allclose(one.share, exact[one.name], rtol=1e-12)
        small = [name for name, share in exact.items() if share < 0.01]
        assert not {one.name for one in shares.parts} & {*small}


def test_a_limit_that_is_exceeded_is_bold():
    """Each row has the largest error, the limit and the part of it, bold if beyond."""
    found = {row[0].text: row for row in answer(failing())}
    z = found["Gyro bias z"]

    texts = [cell.text for cell in z[:5]]
    assert texts == ["Gyro bias z", "0.119", "deg/h", "0.1 deg/h", "119"]
    assert [row[0].text for row in found.values() if row[0].strong] == ["Gyro bias z"]


def test_failing_report_says_by_what_and_why():
    """Verdict, margin, worst output, limit, utilisation and contributions are said."""
    report = failing()
    (gyro, _) = report.cards
    words = " ".join(say(line) for line in gyro.lines)

    assert report.headline == f"FAILS tactical grade, {AFTER}"
    assert report.running_head == f"Zhao 2019 optical IMU: {report.headline}"
    assert_says(say(report.summary), "3 of 24", "exceed", "119 % of its limit")
    assert gyro.title == "Gyro: FAILS"
    assert_says(words, "Gyro bias z", "0.119 deg/h of 0.1 deg/h allowed, 119 %")
    assert_says(words, "bias repeatability 67 %", "bias stability 31 %", "rest 2 %")


@pytest.mark.parametrize(
    ("beyond", "text"), [(0.002, "100.2 %"), (1e-6, "100.0001 %"), (0.03, "103 %")]
)
def test_limits_are_never_exceeded_by_nothing(beyond, text):
    """A limit that is exceeded by little is not said to be met: one figure, its own."""
    budget = make_budget()
    z = budget.output("gyro.bias.z")
    limit = z.largest_error / z.output.si_per_unit / (1.0 + beyond)
    report = document(
        budget, assessment=make_assessment(budget, {"gyro.bias": ("limit", limit)})
    )

    assert_says(say(report.summary), "exceed", f"the worst at {text} of its limit")


def test_undecidable_report_names_what_is_missing():
    """A sensor that would meet says which line its verdict waits for."""
    budget = make_budget(outputs=make_outputs("accelerometer", ACCELEROMETER))
    report = document(
        budget, assessment=make_assessment(budget, accelerometer="undecidable")
    )

    assert report.headline == f"UNDECIDABLE tactical grade, {AFTER}"
    assert_says(
        say(report.cards[0].lines[0]),
        *("Cannot be judged", "accelerometer noise", "not given", "ask for it"),
    )


@pytest.mark.parametrize(("number", "shown"), [(1, 1), (4, 4), (8, 3)])
def test_page_one_says_the_first_conditions(number, shown):
    """A long list goes on under Limits, where all stand; one more is no list."""
    budget = make_budget(outputs=make_outputs("accelerometer", ACCELEROMETER))
    assessment = make_assessment(budget, accelerometer="meets_if")
    standing = make_standing("meets_if", "accelerometer", conditions=number)
    own = {"verdict": standing.verdict, "conditions": standing.conditions}
    sensors = tuple(replace(one, **own) for one in assessment.sensors)
    report = document(budget, assessment=replace(assessment, sensors=sensors))
    first = say(report.cards[0].lines[0])
    told = [line for line in lines(section(report, "limits")) if "stays below" in line]

    conditions = "A CONDITION" if number == 1 else f"{number} CONDITIONS"
    assert report.headline == f"MEETS tactical grade ON {conditions}, {AFTER}"
    assert first.count("accelerometer noise stays below") == shown
    assert ("and 5 more" in first) == (number == 8)
    assert len(told) == number


def test_meeting_report_says_the_margin():
    """Where every sensor meets, so does the report, with what is left."""
    budget = make_budget(outputs=make_outputs("accelerometer", ACCELEROMETER))
    report = document(budget, assessment=make_assessment(budget))

    assert report.headline == f"MEETS tactical grade, {AFTER}"
    said = say(report.summary)
    assert_says(said, "12 required outputs", "by itself", "tightest uses 93.1 % of its")
    assert_says(said, "all 12", "together", "probability of 81 %")


@pytest.mark.parametrize("required", [True, False])
def test_page_one_says_that_sources_were_left_out(required):
    """A verdict on chosen sources alone says so, and so does every running head."""
    budget = make_budget()
    chosen = replace(budget.settings, only=("gyro.bias_stability", "sample_noise"))
    budget = replace(budget, settings=chosen)
    report = document(budget, assessment=make_assessment(budget) if required else None)

    assert ", chosen sources only" in report.running_head
    first, other, _ = say(report.summary).split(". ", 2)
    assert_says(first, "only", "sources", "gyro bias stability, sample noise")
    assert_says(other, "zero", "not the budget of the whole device")


def test_empty_states_are_said():
    """Nothing missing is said in words; no assumption or caution is no heading."""
    report = document(make_budget(**NO_GAPS, assumptions=(), warnings=()))
    (panel,) = section(report, "gaps").blocks[0].blocks

    assert panel.blocks[0].items == ()
    assert_says(panel.blocks[0].empty, "every specification", "is given")


def test_budget_without_spread_says_so():
    """A budget in which nothing varies has no bar."""
    still = make_output(
        "gyro", "bias", "x", unit="deg/h", scale=1.0, sources={"bias_stability": 0.0}
    )
    ((*_, cell),) = answer(document(make_budget(outputs=(still,))))

    assert cell.shares.parts == ()
    assert cell.text == "no spread"


def test_every_source_of_every_output_stands_in_the_tables():
    """Each source that acts has a row with u and share; the others are named."""
    budget = make_budget()
    part = section(document(budget), "budget")

    for group, panel in zip(group_tables(budget), part.blocks[3:], strict=True):
        by_axis = {
            axis: {row[0].text: [cell.text for cell in row] for row in own.rows}
            for own in find(panel, Table)[0].groups
            for axis in (own.title or panel.title.split(" [")[0]).split(", ")
        }
        by_axis = {axis.split()[-1]: own for axis, own in by_axis.items()}
        assert [*by_axis] == [row.axis for row in group.rows]
        for source in group.sources:
            for row, cell in zip(group.rows, source.cells, strict=True):
                if source.is_idle:
                    assert any(
                        line.startswith("Without effect") and source.title in line
                        for line in lines(panel)
                    )
                else:
                    share = cell.share.text.removesuffix(" %")
                    assert {cell.u.text, share} <= {*by_axis[row.axis][source.title]}


def test_the_check_of_the_law_stands_with_every_output():
    """Both differences and the word stand in the figure's numbers, in words once."""
    report = example()
    data = [picture.data for picture in find(section(report, "validity"), Picture)]
    found = [row for table in data for group in table.groups for row in group.rows]

    assert len(found) == 24
    assert all(row[-1].text == "agrees" for row in found)
    said = " ".join(lines(section(report, "budget")))
    assert said.count("GUM propagation checked against Monte Carlo") == 1


def test_inputs_show_the_data_sheet():
    """Printed form, meaning, distribution, condition and source of a line are shown."""
    part = section(example(), "inputs")
    cells = {cell for row in rows(part) for cell in row}
    notes = {(cell.text, cell.note) for cell in find(part, Cell)}

    assert {"-40 to 71 degC", "table 2 <rev B>", "bandwidth", "200 Hz"} <= cells
    assert {("1.155 arcsec", "uniform"), ("50 ppm", "normal")} <= notes
    assert ("0.04 deg/h", "normal, correlation time 300 s") in notes
    assert ("2 arcsec", "max") in notes


def test_a_note_that_ends_with_a_stop_gets_no_second_one():
    """What a file says of the device is joined by semicolons and ends once."""
    device = replace(make_device(), vendor="A. Maker", notes="Out of date.", source="")
    said = lines(section(document(device=device), "inputs"))

    assert any(text.endswith("Vendor A. Maker; notes Out of date.") for text in said)


def test_inputs_show_what_was_assumed_of_each_line():
    """An assumption stands in the row of its line, that of one axis with its name."""
    device = replace(
        make_device(),
        assumptions=(
            "gyro.bias_stability: correlation time not given, 300 s assumed",
            "gyro.angle_random_walk.y: typical is taken as 1 sigma",
        ),
    )
    gyro = section(document(device=device), "inputs").blocks[0]
    by_line = {
        row[0].text: row[3].note
        for table in find(gyro, Table)
        for group in table.groups
        for row in group.rows
    }

    assert by_line["bias stability"] == "correlation time not given, 300 s assumed"
    assert by_line["angle random walk"] == "y: typical is taken as 1 sigma"


def test_columns_in_which_nothing_stands_are_left_out():
    """No data sheet without conditions has an empty column of conditions."""
    device = replace(make_device(), gyro=None)
    table = section(document(device=device), "inputs").blocks[0].blocks[1]

    assert [column.head for column in table.columns] == [
        *("specification", "as printed, meaning", "u, distribution")
    ]


def test_figures_by_axis_are_told_apart():
    """A line with unequal axes shows the figure of each."""
    line = make_device().gyro.lines[0]

    text = print_by_axis(line.u / line.si_per_unit * [1.0, 2.0, 3.0])

    assert text == "x 0.05, y 0.1, z 0.15"


def test_sensor_that_is_absent_has_no_part():
    """With a gyro alone nothing is said of the accelerometer's test and formulas."""
    report = document(
        make_budget(
            outputs=make_outputs("gyro", GYRO),
            **NO_GAPS,
            warnings=(),
        ),
        device=replace(make_device(), accelerometer=None),
        evidence=example_evidence(gyro_only=True),
    )
    words = " ".join(
        [
            *lines(report),
            *(say(text) for _, text in section(report, "procedure").blocks[0].rows),
        ]
    )

    assert "twelve positions" not in words
    numbers = {one.number for one in find(report, Equation)}
    assert "eq. (3)" in numbers
    assert "eq. (5)" not in numbers


def test_formula_of_the_paper_is_shown_where_it_is_used():
    """The gyro bias formula is the one of the procedure."""
    notes = {one.number for one in find(example(), Equation)}
    assert "eq. (4), corrected" in notes
    printed = {one.number for one in find(document(formulas="paper"), Equation)}
    assert "eq. (4), as printed" in printed
    assert "eq. (4), corrected" not in printed


def test_letters_of_the_formulas_are_named():
    """A letter that a formula uses is explained: matrix, latitude, K of a walk."""
    walk = replace(make_device().gyro.lines[0], name="rate_random_walk")
    gyro = replace(make_device().gyro, lines=(*make_device().gyro.lines, walk))
    report = document(device=replace(make_device(), gyro=gyro))
    said = " ".join(lines(section(report, "budget")))
    notes = {e.number for e in find(report, Equation)}

    for words in (
        *("Delta T: mounting angles", "I: unit matrix", "g: gravity"),
        *("at latitude phi", "number of pulses a second over the azimuths"),
        "number of pulses a second of axis i over",
    ):
        assert words in said
    said = "; ".join(filter(None, notes))
    assert_says(said, "random walk K", "first-order Gauss-Markov", "white per sample")
    assert_says(said, "correlation time \N{GREEK SMALL LETTER TAU}", "rate f")


@pytest.mark.parametrize("method", ["gum", "monte-carlo"])
def test_the_formulas_claim_no_check(method):
    """What is held against Monte Carlo is said where it was, not with the formulas."""
    outputs = tuple(replace(row, validation=None) for row in make_budget().outputs)
    budget = make_budget(outputs=outputs)
    budget = replace(budget, settings=replace(budget.settings, method=method))
    report = document(budget)

    assert "validity" not in names(report)
    assert "against Monte Carlo" not in " ".join(lines(section(report, "method")))


def test_every_parameter_has_its_formula():
    """24 parameters: 9 and one vector equation of the gyro, 12 of the accelerometer."""
    panels = section(example(), "budget").blocks[3:]

    assert [len(find(panel, Equation)) for panel in panels] == [3, 6, 1, 3, 6, 3]


def test_noise_formulas_are_those_of_the_lines_given():
    """Processes that no data sheet gives have no formula."""
    notes = {e.number for e in find(section(example(), "method"), Equation)}

    said = "; ".join(filter(None, notes))
    assert_says(said, "first-order Gauss-Markov", "white per sample")
    assert "random walk K" not in said


def test_provenance_names_the_inputs():
    """Version, command, base names and hashes of the inputs are there."""
    budget = make_budget()
    part = section(document(budget), "provenance")
    pairs = dict(part.blocks[0].rows)

    assert pairs["command"] == ("budget report zhao-2019.yaml",)
    assert rows(part) == [(f.role, f.name, f.sha256) for f in budget.inputs]


def test_reference_is_explained():
    """The report says what the errors are counted from."""
    settings = replace(make_budget().settings, reference="next_turn_on")
    report = document(make_budget(settings=settings))
    pairs = dict(section(report, "method").blocks[0].rows)

    assert_says(pairs["error reference"][0], "next turn-on:", "errors are counted from")


def test_every_figure_has_a_finding_words_and_data():
    """Title, words with numbers, and a table stand with every figure or beside it."""
    pictures = find(failing(), Picture)

    assert len(pictures) >= 12
    for picture in pictures:
        assert picture.title
        assert any(c.isdigit() for c in picture.alt)
        in_table = picture.name.startswith(("tornado", "steps"))
        assert picture.data is not None or in_table


def test_embedded_document_is_the_budget_and_its_extras():
    """The JSON holds the budget, and under its key what another study adds."""
    budget = make_budget()
    extra = Extra(
        key="allocation",
        content={"feasible": True},
        sections=(
            Section(name="allocation", title="A", blocks=(Paragraph(words=("x",)),)),
        ),
        inputs=(
            replace(budget.inputs[0], role="catalogue", name="other.yaml"),
            budget.inputs[1],
        ),
    )
    report = document(budget, extras=(extra,))
    found = json.loads(report.json)

    assert found["outputs"] == budget.to_dict()["outputs"]
    assert found["allocation"] == {"feasible": True}
    assert names(report).index("allocation") == names(report).index("budget") - 1
    assert [row[0] for row in rows(section(report, "provenance"))] == [
        *("device", "procedure", "allocation, catalogue")
    ]


@pytest.mark.slow
def test_what_if_with_limits_says_what_each_step_uses():
    """With limits there are the parts of them, and what the verdict becomes."""
    wanted = load_requirement(TACTICAL)
    budget = make_budget()
    settings = replace(budget.settings, reference=wanted.reference)
    evidence = gather_evidence(
        Question.of(make_device(), procedure=make_procedure(), requirement=wanted),
        replace(budget, settings=settings),
    )
    (sliders,) = find(section(document(evidence=evidence), "what-if"), Sliders)
    heads = [column.head for column in sliders.table.columns]

    assert heads[-1] == "verdict then"
    assert heads.count("of the limit now [%]") == 1
    assert all(output["limit"] is not None for output in sliders.model["outputs"])


def test_what_if_has_the_device_as_a_file_to_change():
    """It reads back as the device, and the size of every line of a source is marked."""
    model = find(section(example(), "what-if"), Sliders)[0].model
    text, device = model["device"], make_device()
    read = read_device(parse(text.replace(MARK, "").encode(), "x", base_name="x"))
    marked = re.findall(rf"^ {{4}}(\w+): .*{MARK}", text, flags=re.MULTILINE)

    for kind in ("gyro", "accelerometer"):
        before, after = getattr(device, kind).lines, getattr(read, kind).lines
        assert [line.name for line in after] == [line.name for line in before]
        for one, other in zip(before, after, strict=True):
            assert_allclose(other.u, one.u, rtol=1e-12)
    assert len(marked) == len({source["name"] for source in model["sources"]})


@pytest.mark.parametrize(("factor", "place"), [(0.5, 5), (1.0, 6)])
def test_steps_are_the_law_at_changed_sources(factor, place):
    """The table's U at half is what the model behind it evaluates to."""
    model = example_evidence().what_if
    (sliders,) = find(section(example(), "what-if"), Sliders)
    row = sliders.table.groups[0].rows[0]
    outlook = model.evaluate({model.sources[0].name: factor})
    names_of = [key_title(o.name.partition(".")[2]) for o in model.outputs]
    k = names_of.index(row[2].text)
    expected = model.coverage_factor[k] * outlook.u[k] / model.outputs[k].si_per_unit

    assert_allclose(row[place].exact, expected, rtol=1e-12)


@pytest.mark.slow
def test_what_if_says_where_the_report_does_not_stand_on_the_law():
    """A law in doubt, an interval that is not its own, another method: all are said."""
    budget = make_budget()
    first = budget.outputs[0]
    refused = replace(first, validation=replace(first.validation, holds=False))
    doubted = replace(budget, outputs=(refused, *budget.outputs[1:]))
    wanted = load_requirement(TACTICAL)
    evidence = gather_evidence(
        Question.of(make_device(), procedure=make_procedure(), requirement=wanted),
        replace(budget, settings=replace(budget.settings, reference=wanted.reference)),
    )
    doubtful = document(doubted)
    overruled = replace(first, interval_by="monte-carlo")
    judged = document(
        replace(budget, outputs=(overruled, *budget.outputs[1:])), evidence=evidence
    )
    settings = replace(budget.settings, method="monte-carlo", trials=1000)
    drawn = document(replace(budget, settings=settings))

    failed = " ".join(lines(section(doubtful, "what-if")))
    assert_says(
        failed, "GUM propagation failed its check", "gyro scale factor x", "in doubt"
    )
    said = " ".join(lines(section(judged, "what-if")))
    assert_says(said, "interval of gyro scale factor x", "not by GUM propagation")
    assert "in doubt" not in said
    (card,) = doubtful.cards
    assert_says(say(card.lines[-1]), "in doubt", "not confirmed on x")
    assert_says(" ".join(lines(section(drawn, "what-if"))), "budget", "by monte-carlo")


def test_a_sensor_that_is_limited_but_absent_is_said_first():
    """The headline says what was judged alone, the summary what was not."""
    budget = make_budget(outputs=make_outputs("gyro", GYRO))
    assessment = replace(make_assessment(budget), not_there=("accelerometer",))
    report = document(
        budget,
        assessment=assessment,
        device=replace(make_device(), accelerometer=None),
        evidence=example_evidence(gyro_only=True),
    )

    assert report.headline == (
        f"FAILS tactical grade, gyro only, accelerometer not judged, {AFTER}"
    )
    assert_says(say(report.summary), "no accelerometer calibrated", "not assessed")


def test_caps_stand_with_the_limits():
    """Each cap stands with what the device file gives, known or not."""
    budget = make_budget()
    caps = tuple(
        CapAssessment(
            device="IMU", merit=merit, cap=cap, given=given, is_within=is_within
        )
        for merit, cap, given, is_within in (
            ("price", "2 EUR", "", None),
            ("mass", "1 kg", "2 kg", False),
        )
    )
    report = document(budget, assessment=replace(make_assessment(budget), caps=caps))

    said = " ".join(lines(section(report, "limits")))
    assert_says(said, "IMU, price: not given, at most 2 EUR: not known")
    assert_says(said, "IMU, mass: 2 kg, at most 1 kg: beyond", "decide no verdict")


def test_limits_stand_by_group():
    """Rows of one unit and limit stand together, the sensors side by side."""
    (abreast,) = section(failing(), "limits").blocks[1:]

    assert [panel.title for panel in abreast.blocks] == ["Gyro", "Accelerometer"]
    for panel, bias in zip(abreast.blocks, ("deg/h", "ug"), strict=True):
        titles = [group.title for group in panel.blocks[0].groups]
        assert [title.partition(", limit ")[0] for title in titles] == [
            *("Scale factor [ppm]", "Mounting angle [arcsec]", f"Bias [{bias}]")
        ]
        assert all(title.partition(", limit ")[2] for title in titles)


def test_assumptions_are_written_in_words():
    """The key before an assumption is no key to a reader of page one."""
    panels = section(example(), "gaps").blocks[0].blocks

    said = [say(item) for panel in panels for item in panel.blocks[0].items]
    (line,) = (one for one in said if one.startswith("Gyro bias stability:"))
    assert_says(line, "correlation time of 300 s", "file's own")
    assert "_" not in line


def test_what_moves_nothing_stands_under_inputs():
    """An assumption of what counts nowhere is not on page one, and is not lost."""
    text = "gyro.nominal_bias: not given, 0 assumed"
    report = document(make_budget(assumptions=(text,)))
    (panel,) = (
        one
        for one in section(report, "inputs").blocks
        if getattr(one, "title", "") == "Assumed besides"
    )

    assert "nominal bias" not in " ".join(lines(section(report, "gaps")))
    assert say(panel.blocks[0].items[0]) == "Gyro nominal bias: not given, 0 assumed"


def test_number_and_lines_to_sign():
    """A report number stands under the title; three lines wait for signatures."""
    report = document(number="TH-2026-17")

    assert report.facts[0] == "report TH-2026-17"
    assert [row[0] for row in rows(section(report, "sign-off"))] == [
        *("prepared", "checked", "approved")
    ]
    assert not any("report" in fact for fact in example().facts)


def test_warnings_of_other_studies_reach_page_one():
    """What an allocation warns of is not only said in its own section."""
    extra = Extra(
        key="allocation",
        content={},
        sections=(),
        inputs=(),
        warnings=("limits cannot be met",),
    )
    panels = section(document(extras=(extra,)), "gaps").blocks[0].blocks

    assert panels[0].title == "Cautions"
    assert ("Allocation: limits cannot be met",) in panels[0].blocks[0].items


def test_trials_say_what_they_were_for():
    """The law has no trials of its own; its check and the densities have."""
    pairs = dict(section(example(), "method").blocks[0].rows)

    (said,) = pairs["trials"]
    assert_says(said, "230 000 to check GUM propagation", "one digit of u")
    assert_says(said, "100 000 for the distributions")
