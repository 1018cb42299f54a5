"""The library as the README shows it: load, analyze, table, covariance."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import zipfile
from contextlib import redirect_stdout
from dataclasses import FrozenInstanceError, replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from command_line import analyze
from numpy.testing import assert_allclose
from places import ROOT, put

import budget
from budget.errors import CallError
from budget.studies.decide import decide
from budget.units import DEG_PER_HOUR

README = ROOT / "README.md"
COLUMNS = [
    *("sensor", "parameter", "axis", "unit", "source"),
    *("standard_uncertainty", "share", "mean", "interval_low", "interval_high"),
    "interval_by",
    "lower_bound",
]


@pytest.fixture(scope="module")
def result():
    """Provide the budget of the paper's device."""
    return budget.analyze(budget.load_device("zhao-2019"), validate=False)


@pytest.mark.smoke
def test_the_lines_of_the_readme_run():
    """The README's five lines run as printed: 24 totals and the joint covariance."""
    text = README.read_text(encoding="utf-8")
    (block,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    code = [line for line in block.splitlines() if line and line != "import budget"]
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(block, README.name, "exec"), {})  # noqa: S102 - as a reader would

    assert len(code) <= 5
    lines = out.getvalue().splitlines()
    assert sum(" total " in line for line in lines) == 24
    assert lines[-1] == "(24, 24)"


def test_frame_is_tidy(result):
    """One row for each output and source and one total, one fact in each column."""
    table = result.to_frame()

    assert list(table.columns) == COLUMNS
    key = ["sensor", "parameter", "axis", "source"]
    assert not table.duplicated(key).any()
    assert len(table) == 24 * 7  # five sources, interaction, total
    totals = table[table["source"] == "total"]
    assert not totals.isna().any(axis=None)
    causes = table[table["source"] != "total"]
    assert causes[["mean", "interval_low", "interval_high"]].isna().all(axis=None)


def test_frame_is_in_printed_units(result):
    """The table prints deg/h where the records hold rad/s."""
    table = result.to_frame().set_index(["sensor", "parameter", "axis", "source"])
    row = table.loc[("gyro", "bias", "x", "total")]

    assert row["unit"] == "deg/h"
    u = result.output("gyro.bias.x").standard_uncertainty
    assert_allclose(row["standard_uncertainty"] * DEG_PER_HOUR, u, rtol=1e-12)


def test_covariance_is_joint(result):
    """Scale factor and bias of gyro x are correlated, gyro and accelerometer not."""
    correlation = result.correlation
    names = [row.output.name for row in result.outputs]
    i, j = names.index("gyro.scale_factor.x"), names.index("gyro.bias.x")

    assert result.covariance.shape == (24, 24)
    assert_allclose(np.diag(correlation), 1.0, rtol=1e-12)
    assert abs(correlation[i, j]) > 1e-6  # bias stability reaches both
    assert np.all(result.covariance[:12, 12:] == 0.0)


def test_records_are_frozen(result):
    """Nothing in a result can be assigned to."""
    for record, name in (
        (result, "outputs"),
        (result.settings, "seed"),
        (result.outputs[0], "mean"),
        (result.outputs[0].contributions[0], "share"),
    ):
        with pytest.raises(FrozenInstanceError):
            setattr(record, name, None)


def test_unknown_output_is_an_error(result):
    """An output that there is not is a KeyError, not an empty answer."""
    with pytest.raises(KeyError, match=r"gyro\.bias\.w"):
        result.output("gyro.bias.w")


def test_document_is_what_the_command_prints(result):
    """`to_dict()` and the command line's JSON are one document."""
    assert json.loads(json.dumps(result.to_dict())) == analyze("zhao-2019")


def test_errors_are_of_one_family():
    """Whatever is wrong with a call or a file, one class catches it."""
    device = budget.load_device("zhao-2019")
    with pytest.raises(budget.BudgetError, match="both have a gyro"):
        budget.analyze(device, device)
    with pytest.raises(budget.BudgetError, match="allowed: gum"):
        budget.analyze(device, method="linear")
    with pytest.raises(budget.SpecError, match="no such file"):
        budget.load_device("absent.yaml")


def test_public_names_are_there():
    """Every name in `__all__` can be had, and an unknown one is an AttributeError."""
    for name in budget.__all__:
        assert getattr(budget, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'analyse'"):
        _ = budget.analyse


def test_what_is_public_is_listed():
    """Completion shows the public names alone, also after modules were loaded."""
    assert dir(budget) == sorted(budget.__all__)
    assert {"CallError", "allocate", "qualify", "export"} < set(dir(budget))
    assert "studies" not in dir(budget)


SHEET = {
    "name": "Mine",
    "gyro": {
        "errors": {"bias_stability": "0.5 deg/h", "angle_random_walk": "0.1 deg/√h"}
    },
}


def test_a_device_of_a_dict_is_that_of_the_file(tmp_path):
    """A dict is read as a file with its keys is, and hashed as its JSON."""
    text = json.dumps(SHEET, indent=1, ensure_ascii=False)
    file = put(tmp_path / "mine.yaml", text)
    one, other = budget.load_device(SHEET), budget.load_device(file)

    assert one.name == other.name
    assert one.assumptions == other.assumptions
    assert one.origin.sha256 == other.origin.sha256
    assert (one.origin.file, other.origin.file) == ("dict", "mine.yaml")
    kept = budget.analyze(one, validate=False).to_dict()
    assert kept["outputs"] == budget.analyze(file, validate=False).to_dict()["outputs"]


def test_a_wrong_dict_is_refused_like_a_file():
    """The issue names the key; what JSON cannot hold is told as such."""
    wrong = {**SHEET, "gyro": {"errors": {"bias_stability": "3 m"}}}
    with pytest.raises(budget.SpecError, match=r"gyro\.errors\.bias_stability: found"):
        budget.load_device(wrong)
    with pytest.raises(budget.CallError, match=r"dict: .*not JSON"):
        budget.load_device({**SHEET, "notes": object()})
    with pytest.raises(budget.CallError, match="found a int, expected a device"):
        budget.load_device(3)


def test_names_stand_for_records(result):
    """What a command takes, the name of a file, a call takes too."""
    by_name = budget.analyze("zhao-2019", procedure="zhao-2019", validate=False)
    assert by_name.to_dict() == result.to_dict()
    variant = budget.analyze("stim300#5g", validate=False)
    assert variant.inputs[0].name == "stim300.yaml#5g"


@pytest.mark.slow
def test_studies_take_names():
    """Allocation, stations, exports and comparisons are a line each."""
    wanted = "navigation-grade"
    shared = budget.allocate("zhao-2019", requirement=wanted, validate=False)
    assert shared.title == "Zhao 2019 optical IMU"
    assert budget.qualify("zhao-2019", requirement=wanted).figures
    assert (
        budget.export("stim300#5g", to="kalibr", rate=200.0).to_dict()["command"]
        == "export"
    )
    ranked = budget.compare("stim300", wanted, "zhao-2019", method="gum")
    assert "STIM300 (5g)" in {row.name for row in ranked.devices}


@pytest.mark.parametrize(
    "call",
    [
        lambda: budget.analyze(budget.load_procedure()),
        lambda: budget.analyze("zhao-2019", requirement=7),
        lambda: budget.compare([None], "navigation-grade"),
        lambda: budget.allocate("zhao-2019", requirement=None),
        lambda: budget.assess(budget.load_device("zhao-2019"), "navigation-grade"),
        lambda: budget.load_device("zhao-2019", changes=7),
    ],
)
def test_a_wrong_argument_is_a_call_error(call):
    """A record of another kind is refused in words, by an error of ours."""
    with pytest.raises(budget.CallError):
        call()


def test_a_replaced_value_is_named():
    """What is replaced stands beside the hash of the file, with its old value."""
    printed = budget.load_device("zhao-2019")
    new = printed.replace({"gyro.bias_repeatability": "0.02 deg/h"})
    again = new.replace({"gyro.bias_repeatability": ["0.1 deg/h"] * 3})

    assert (new.name, new.as_printed) == (f"{printed.name}, changed", printed.name)
    assert new.origin.sha256 == printed.origin.sha256
    for device, value in ((new, "0.02 deg/h"), (again, "x 0.1 deg/h")):
        (told,) = device.origin.changes
        assert (told.address, told.old) == ("gyro.bias_repeatability", "0.05 deg/h")
        assert told.new.startswith(value)
    by_text = budget.load_device(
        "zhao-2019", changes=["gyro.bias_repeatability=0.02 deg/h"]
    )
    assert by_text.origin == new.origin
    with pytest.raises(budget.SpecError, match=r"gyro\.errors\.bias_instability"):
        printed.replace({"gyro.bias_instability": "0.1 deg/h"})


def test_a_file_that_changed_on_disk_does_not_count(tmp_path):
    """What is replaced is a value of the text that was read."""
    file = put(tmp_path / "mine.yaml", json.dumps(SHEET))
    device = budget.load_device(file)
    file.write_text("name: Another", encoding="utf-8")

    new = device.replace({"gyro.bias_stability": "0.2 deg/h"})
    assert new.origin.sha256 == device.origin.sha256


@pytest.fixture(scope="module")
def judged():
    """Provide a budget that is held against limits."""
    return budget.analyze(
        "zhao-2019",
        requirement="navigation-grade",
        reference="next_turn_on",
        validate=False,
    )


def test_values_agree_with_their_unit(result):
    """`in_unit()` is what the table prints; another unit of the quantity is taken."""
    row = result.output("gyro.bias.x")
    printed, si = row.in_unit(), row.in_unit("rad/s")

    assert (printed.unit, si.unit) == ("deg/h", "rad/s")
    assert_allclose(
        printed.standard_uncertainty * DEG_PER_HOUR,
        row.standard_uncertainty,
        rtol=1e-12,
    )
    assert_allclose(np.array(printed.interval) * DEG_PER_HOUR, row.interval, rtol=1e-12)
    assert_allclose([si.mean, *si.interval], [row.mean, *row.interval], rtol=1e-12)
    with pytest.raises(budget.BudgetError, match="length"):
        row.in_unit("m")


def test_a_notebook_shows_a_table(judged):
    """A row for each group with its worst output, the verdict, every warning."""
    html = judged._repr_html_()

    assert html.count("<tr>") == 1 + 6
    row = r"<td[^>]*>gyro\.bias\.z</td><td[^>]*>0\.148</td><td[^>]*>deg/h</td>"
    assert re.search(row, html)
    assert "FAILS navigation grade" in html
    assert "... 18 more" in html
    assert html.count("Warning: ") == len(judged.warnings) > 0
    hostile = replace(judged, title="<script>")
    assert "&lt;script&gt;" in hostile._repr_html_()
    assert "<script>" not in hostile._repr_html_()
    assert not re.search(r"src=|href=|url\(", html)


def test_a_prompt_shows_the_same_in_text(judged):
    """The rows of the notebook, and of warnings how many are left."""
    text = repr(judged)

    rows = re.findall(r"^(?:gyro|accelerometer)\.\S+  +[\d.]+ ", text, re.MULTILINE)
    assert len(rows) == 6
    assert re.search(r"gyro\.bias\.z +0\.148 +deg/h +\d+ % of 0\.01 deg/h", text)
    assert "... 18 more" in text
    many = replace(judged, warnings=("one", "two", "three", "four"))
    assert "... 2 more in .warnings" in repr(many)
    assert "three" in many._repr_html_()


@pytest.fixture(scope="module")
def flight():
    """Provide the budget of a mission."""
    return budget.analyze("hg4930#C", mission="outage-60-s", validate=False)


def test_outputs_are_asked_by_name(judged, flight):
    """A budget is a mapping from the names of its outputs, in their order."""
    assert judged["gyro.bias.x"] is judged.output("gyro.bias.x")
    assert "gyro.bias.x" in judged
    assert "gyro.bias" not in judged
    assert len(judged) == 24
    assert [judged[name] for name in judged] == [*judged.outputs]
    assert judged._ipython_key_completions_() == list(judged)
    far = flight["mission.position.horizontal.60"]
    for name in ("mission.position.60 s", "mission.position.horizontal.1 min"):
        assert name in flight
        assert flight[name] is far
    assert flight["mission.attitude.heading.0.5 min"].output.name.time == 30.0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("gyro.bais.x", r"did you mean 'gyro\.bias\.x'"),
        ("gyro.bias", r"'gyro\.bias\.x' or 'gyro\.bias\.y' or 'gyro\.bias\.z'\?"),
        ("nothing", r"\. It has gyro\.scale_factor\.\{x, y, z\};"),
        (3, r"found 3, no output .* It has .*gyro\.bias\.\{x, y, z\}"),
    ],
)
def test_a_wrong_name_says_what_there_is(judged, name, words):
    """A KeyError with names that are like it, and what there is."""
    with pytest.raises(KeyError, match=words):
        judged[name]


def test_a_wrong_time_says_which_there_are(flight):
    """Of a mission names are told as they are asked for."""
    with pytest.raises(
        KeyError, match=r"mean 'mission\.position\.60 s'.*\{10, 30, 60\}"
    ):
        flight["mission.position.61 s"]


def test_one_output_is_a_table(judged, flight):
    """Its contributions in printed units, and in which SI its attributes are."""
    text = repr(judged["gyro.bias.x"])
    assert re.search(r"standard uncertainty +0\.075 deg/h", text)
    assert re.search(r"gyro\.bias_repeatability +0\.07\d+ +deg/h", text)
    assert "SI (rad/s)" in text
    assert "SI (1)" in repr(judged["gyro.scale_factor.x"])
    assert "... 2 more" in repr(flight["mission.position.60 s"])
    assert "<table>" in judged["gyro.bias.x"]._repr_html_()


def test_a_device_is_a_table():
    """Ten specification values as printed, how many more, and what is not given."""
    device = budget.load_device("stim300#5g")
    text = repr(device)
    assert re.search(r"gyro\.g_sensitivity +7 \S+ +typical", text)
    assert "... 2 more" in text
    assert "Expected and not given: gyro.scale_factor_repeatability" in text
    assert device._repr_html_().count("<tr>") == 1 + 10


def test_a_mission_and_its_growth_are_tables(flight):
    """The horizontal position at all times comes first; units stand in heads."""
    rows = re.findall(r"^mission\.\S+", repr(flight), re.MULTILINE)
    assert rows[:3] == [f"mission.position.horizontal.{at}" for at in (10, 30, 60)]
    assert "time [s]" in flight.to_frame()
    grown = budget.growth(flight)
    assert list(grown.to_frame()) == [
        *("time [s]", "cep [m]", "r95 [m]", "drms [m]", "velocity_drms [m/s]"),
        "dominant",
    ]
    assert re.search(r"^1 min +41\.\d", repr(grown), re.MULTILINE)
    assert "... 90 more" in repr(grown)


def test_tables_for_documents(judged):
    """A row for each output, the same number of cells in each; signs are escaped."""
    head, _, *rows = judged.to_markdown().splitlines()
    assert len(rows) == len(judged.outputs)
    assert {len(re.findall(r"(?<!\\\\)\|", line)) for line in (head, *rows)} == {8}
    assert any(row.startswith("| gyro bias | z | 0.000 | 0.075 |") for row in rows)
    hostile = replace(
        judged.outputs[0],
        output=replace(judged.outputs[0].output, unit="a|b_%\\"),
    )
    odd = replace(judged, outputs=(hostile,))
    assert r"| a\|b\_%\\ |" in odd.to_markdown()
    assert r" & a\textbar{}b\_\%\textbackslash{} & " in odd.to_latex()

    latex = judged.to_latex()
    body = latex.split("\\hline\n")[2].splitlines()
    assert len(body) == len(judged.outputs)
    assert {line.count(" & ") for line in body} == {6}
    assert not re.search(r"(?<!\\)%", latex)
    assert "$>$99 \\%" in latex


@pytest.mark.slow
def test_figures_of_a_result(judged):
    """Each figure is a matplotlib Figure that names what it shows."""
    plot = judged.plot
    for figure in (
        *(plot.overview(), plot.limits(), plot.coupling("accelerometer")),
        *(plot.tornado(), plot.waterfall("gyro.bias")),
        *(plot.shares(), plot.positions(), plot.allan(), plot.allan("accelerometer")),
    ):
        assert figure.get_label()
        assert figure.axes
        assert judged.title in {text.get_text() for text in figure.texts}
    worst = max(judged.assessment.outputs, key=lambda row: row.utilisation)
    label = plot.contributions().get_label()
    assert label == plot.contributions(str(worst.output.name.group)).get_label()
    assert label != plot.contributions("accelerometer.bias").get_label()


@pytest.mark.slow
def test_figures_that_there_are_complete(result, judged, flight):
    """What completion offers of a budget can be drawn, all of it."""
    for one in (result, judged, flight):
        for name in dir(one.plot):
            assert getattr(one.plot, name)().get_label(), name
    assert "limits" not in dir(result.plot)
    assert set(dir(judged.plot)) - set(dir(result.plot)) <= {"limits", "tornado"}
    assert {"growth", "shares"} < set(dir(flight.plot))
    assert not {"coupling", "schedule", "indices"} & set(dir(flight.plot))
    assert "limits" in repr(judged.plot)
    with pytest.raises(budget.CallError, match="mission="):
        result.plot.growth()


def test_a_figure_shows_itself(judged):
    """As a drawing on paper of its own and as a bitmap, the same each time."""
    figure = judged.plot.contributions("gyro.bias")
    svg = figure._repr_svg_()

    assert figure._repr_png_().startswith(b"\x89PNG")
    assert svg == judged.plot.contributions("gyro.bias")._repr_svg_()
    root = ET.fromstring(svg)  # noqa: S314 - written above
    assert root.tag.endswith("svg")
    assert not list(root.iter("{http://www.w3.org/2000/svg}text"))  # needs no font
    assert repr(figure) == f"<Figure: {figure.get_label()}>"


@pytest.mark.usefixtures("drawn_once")
def test_figures_of_a_mission(result):
    """Its errors over time and where they are; a calibration alone has none."""
    found = budget.analyze("zhao-2019", mission="outage-60-s", validate=False)
    for figure in (
        *(found.plot.growth(), found.plot.growth("attitude.heading")),
        *(found.plot.track(), found.plot.shares()),
    ):
        assert figure.get_label()
        assert found.title in {text.get_text() for text in figure.texts}
    with pytest.raises(budget.CallError, match=r"can show: .*velocity\.down"):
        found.plot.growth("position.up")
    with pytest.raises(budget.CallError, match="mission="):
        result.plot.track()


def test_a_figure_that_there_is_not_is_refused(result):
    """What cannot be drawn is an error that says what can, or what to ask for."""
    with pytest.raises(budget.CallError, match="requirement="):
        result.plot.limits()
    with pytest.raises(budget.CallError, match="validate=True"):
        result.plot.validation()
    with pytest.raises(budget.CallError, match="samples="):
        result.plot.indices()
    with pytest.raises(budget.CallError, match=r"can show: .*gyro\.bias"):
        result.plot.contributions("gyro.bais")


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_once")
def test_a_report_is_a_line(judged, tmp_path):
    """`budget.report` writes the pages of the command, before and after its import."""
    page = tmp_path / "r.html"
    assert budget.report(judged, page, number="17") == (page,)
    text = page.read_text(encoding="utf-8")
    assert "FAILS navigation grade" in text
    assert "report 17" in text
    budget.report(judged, str(page))  # the package of that name is loaded now
    with pytest.raises(budget.CallError, match="suffix"):
        budget.report(judged, tmp_path / "r.docx")
    with pytest.raises(budget.CallError, match="analyze"):
        budget.report(budget.load_device("zhao-2019"), page)


def test_results_of_problems_have_tables():
    """Law and trials of a Problem as pandas tables, in the units of its outputs."""
    problem = budget.Problem(
        groups=(
            budget.Group.independent("a", u=[3.0]),
            budget.Group.independent("b", u=[4.0]),
        ),
        outputs=(budget.Output(name="y", unit="km", si_per_unit=1000.0),),
        function=lambda x: 2.0 * x[:1] + 2.0 * x[1:],
    )
    law = budget.propagate(problem).to_frame(0.95).set_index("source")
    u = law["standard_uncertainty"]

    assert list(law.index) == ["a", "b", "interaction", "total"]
    assert set(law["unit"]) == {"km"}
    assert_allclose(u, [6e-3, 8e-3, 0.0, 10e-3], rtol=1e-12)
    assert_allclose(law["share"], [0.36, 0.64, 0.0, 1.0], rtol=1e-12)
    assert_allclose(law.loc["total", "interval_high"], 1.959964e-2, rtol=1e-6)
    assert law.drop(index="total")["mean"].isna().all()
    drawn = budget.sample(problem, trials=10_000, seed=1)
    (row,) = drawn.to_frame().to_dict("records")
    assert row["unit"] == "km"
    # u of 10000 trials is within 5 standard errors of 1/sqrt(2 n).
    assert_allclose(row["standard_uncertainty"], 1e-2, rtol=5.0 / np.sqrt(2e4))


def test_import_is_cheap(tmp_path):
    """Importing the package imports no numpy."""
    code = "import sys, budget; print('numpy' in sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )

    assert run.stdout == "False\n"


def cells(path, sheet):
    """Return the cells of a sheet of a workbook by rows: numbers, and texts."""
    with zipfile.ZipFile(path) as book:
        parts = {
            name: ET.fromstring(book.read(name))  # noqa: S314 - written above
            for name in book.namelist()
        }
    main = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
    shared = ["".join(one.itertext()) for one in parts["xl/sharedStrings.xml"]]
    found = parts[f"xl/worksheets/sheet{sheet}.xml"]
    assert not list(found.iter(f"{main}f"))  # no formula
    return [
        [
            shared[int(cell[0].text)] if cell.get("t") == "s" else float(cell[0].text)
            for cell in row
        ]
        for row in found.iter(f"{main}row")
    ]


def test_a_workbook_has_numbers_and_what_they_stand_on(judged, tmp_path, monkeypatch):
    """Full precision in cells, hostile texts as texts, the same bytes again."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    odd = replace(judged, title="=1+1", assumptions=("@SUM(A1)",))
    path = odd.to_xlsx(tmp_path / "b.xlsx")

    heads, *rows = cells(path, 1)
    assert heads[3:6] == ["u", "U (95 %)", "unit"]
    assert len(rows) == len(judged.outputs)
    u = [row.in_unit().standard_uncertainty for row in judged.outputs]
    assert_allclose([row[3] for row in rows], u, rtol=1e-15)
    assert len(cells(path, 2)) == 1 + len(list(judged.rows()))
    notes = cells(path, 3)
    assert notes[0][-1] == "=1+1"
    assert ["assumed", "@SUM(A1)"] in notes
    assert any("SHA-256" in row[-1] for row in notes)
    again = odd.to_xlsx(tmp_path / "c.xlsx")
    assert path.read_bytes() == again.read_bytes()


def test_a_workbook_says_what_it_needs(judged, tmp_path, monkeypatch):
    """Another suffix, and a Python without the extra, are errors in words."""
    with pytest.raises(budget.CallError, match=r"ends in \.xlsx"):
        judged.to_xlsx(tmp_path / "b.xls")
    monkeypatch.setattr("budget.report.notebook.find_spec", lambda _: None)
    with pytest.raises(budget.CallError, match=r"pip install 'sins-budget\[xlsx\]'"):
        judged.to_xlsx(tmp_path / "b.xlsx")
    assert list(tmp_path.iterdir()) == []


STUDIES = {
    "compare": lambda: budget.compare("zhao-2019", "catalogue-edge", method="gum"),
    "allocate": lambda: budget.allocate("zhao-2019", requirement="navigation-grade"),
    "qualify": lambda: budget.qualify("zhao-2019", requirement="navigation-grade"),
    "export": lambda: budget.export("stim300#5g", to="kalibr", rate=200.0),
    "decide": lambda: decide("zhao-2019", "catalogue-edge"),
}


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_is_a_table_in_a_notebook(name):
    """Ten rows at the most, how many more there are, and all of them in a frame."""
    found = STUDIES[name]()
    table = found.to_frame()
    shown = min(len(table), 10)
    assert shown > 0
    for text in (repr(found), found._repr_html_()):
        assert ("... " in text) == (len(table) > shown)
        assert len(table) == shown or f"... {len(table) - shown} more" in text
    assert found._repr_html_().count("<tr>") == shown + 1


def test_a_comparison_is_a_row_a_device():
    """Of both triads of a device the graver verdict; rows of limits apart."""
    found = budget.compare(["stim300#5g", "hg4930#C"], "tactical-grade", method="gum")
    table = found.to_frame()

    assert list(table["name"]) == ["STIM300 (5g)", "HG4930 (C)"]
    assert list(table["verdict"]) == ["fails", "fails"]
    by_device = found.output_frame().groupby("device")["utilisation"].max()
    assert_allclose(table["utilisation"], by_device[table["name"]], rtol=1e-12)
    assert table["lower_bound"].tolist() == [True, False]
    assert re.search(r"STIM300 \(5g\) +FAILS +>= 263 %", repr(found))


def test_an_export_is_the_file_of_the_target():
    """What `budget export` writes."""
    text = STUDIES["export"]().to_text()
    assert "gyroscope_noise_density: " in text
    assert "$" not in text


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: budget.analyze("zhao-2019", coverage="95 deg"), "'95 deg' is no prob"),
        (lambda: budget.analyze("zhao-2019", trials=1.5), "trials is 1.5, allowed"),
        (
            lambda: budget.analyze("zhao-2019", trials="few"),
            "'few' is no number",
        ),
        (lambda: budget.analyze("zhao-2019", seed=None), "seed is None, allowed"),
        (lambda: budget.analyze("zhao-2019", only=[3]), "only has 3, expected names"),
        (lambda: budget.export("stim300#5g", to="kalibr", rate="1"), "rate is '1'"),
        (
            lambda: budget.analyze("zhao-2019", validate=False).output("x"),
            "gyro.bias.x",
        ),
    ],
)
def test_a_wrong_argument_is_an_error_in_words(call, words):
    """Never one of Python's own, and never a seed that is another each time."""
    with pytest.raises(budget.CallError, match=re.escape(words)):
        call()


def test_a_report_goes_somewhere(judged):
    """A report without a file is a bad call, and the schedule is one of its figures."""
    with pytest.raises(budget.CallError, match="no file to write to"):
        budget.report(judged)
    assert judged.plot.schedule().get_label()


def test_one_output_can_be_simulated_alone():
    """The covariance of one output is a matrix too."""
    found = budget.analyze(
        "zhao-2019",
        method="simulation",
        trials=4,
        validate=False,
        outputs=["gyro.bias.x"],
    )
    (row,) = found.outputs
    assert found.covariance.shape == (1, 1)
    np.testing.assert_allclose(
        found.covariance[0, 0], row.standard_uncertainty**2, rtol=1e-12
    )


@pytest.mark.parametrize(
    ("option", "value"),
    [("only", 5), ("outputs", 5), ("seed", True), ("workers", True)],
)
def test_an_argument_of_another_kind_is_said_in_words(option, value):
    """No error of Python's own, and no True taken for 1."""
    with pytest.raises(budget.CallError, match=f"{option} is {value}"):
        budget.analyze("zhao-2019", validate=False, **{option: value})


def test_a_text_is_read_as_at_a_terminal():
    """A probability in per cent; what is none is refused as there."""
    found = budget.analyze("zhao-2019", validate=False, coverage="90 %")
    assert found.settings.coverage == 0.9
    with pytest.raises(CallError, match="'900 %' is no probability"):
        budget.analyze("zhao-2019", coverage="900 %")
