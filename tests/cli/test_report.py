"""`budget report`: pages that say the same, whole or not at all."""

from __future__ import annotations

import io
import json
import re
import shlex
from html import unescape

import pytest
from command_line import call, checked, start
from places import put
from reading import assert_says, needs_poppler, squeeze, text_of

from budget.resources import shipped

pytestmark = pytest.mark.usefixtures("drawn_once", "analyzed_once")

SPECS = shipped("specs")
REQUIREMENT = SPECS / "requirements" / "navigation-grade.yaml"
TACTICAL = SPECS / "requirements" / "tactical-grade.yaml"
HG4930 = SPECS / "devices" / "hg4930.yaml"
GYRO = "name: g\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n"


def embedded(page):
    """Return the JSON document of a page."""
    found = re.findall(
        r'<script type="application/json" id="report-json">(.*?)</script>',
        page.read_text(encoding="utf-8"),
        flags=re.DOTALL,
    )
    assert len(found) == 1
    return json.loads(found[0])


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return how the command went in a process of its own, and its folder."""
    folder = tmp_path_factory.mktemp("report")
    run = start(
        *("report", "--no-validate", "-o", "x.html", "-o", "x.pdf"),
        cwd=folder,
        SOURCE_DATE_EPOCH="86400",
    )
    return run, folder


@pytest.mark.slow
def test_both_kinds_are_written_at_once(written):
    """-o may be given again: a page and a PDF, each whole, and nothing else."""
    run, folder = written

    assert (run.code, run.out) == (0, "")
    assert sorted(path.name for path in folder.iterdir()) == ["x.html", "x.pdf"]
    assert (folder / "x.pdf").read_bytes().startswith(b"%PDF-")
    assert (folder / "x.html").stat().st_size < 3e6


@needs_poppler
def test_a_station_has_its_section_in_every_form(tmp_path, monkeypatch):
    """--station: the same finding on page and PDF, its file among the inputs."""
    (tmp_path / "hut.yaml").write_text("station: {gravity: 20 mGal}\n")
    (tmp_path / "a.yaml").write_text(
        "name: a\naccelerometer: {errors: {bias_repeatability: 37 ug, "
        "bias_stability: {value: 20 ug, correlation_time: 300 s}, "
        "scale_factor_repeatability: 37 ppm, mounting_repeatability: 2 arcsec}}\n"
    )
    monkeypatch.chdir(tmp_path)
    run = call(
        *("report", "a.yaml", "--no-validate", "--station", "hut.yaml"),
        *("-o", "x.html", "-o", "x.pdf"),
    )
    assert (run.code, run.out) == (0, ""), run.err
    page = unescape((tmp_path / "x.html").read_text(encoding="utf-8"))
    finding = re.search(r"The station contributes[^<]*", page).group()
    assert_says(finding, "22 %", "accelerometer scale factor", "gravity")
    pdf = text_of((tmp_path / "x.pdf").read_bytes(), tmp_path)
    assert squeeze(finding) in squeeze(pdf)
    assert "hut.yaml" in json.dumps(embedded(tmp_path / "x.html")["inputs"])


def test_one_unwritable_place_leaves_nothing(tmp_path):
    """Where one of two files cannot be written, the other is not written either."""
    run = call(
        *("report", "--no-validate"),
        *("-o", tmp_path / "x.html", "-o", tmp_path / "nowhere" / "x.pdf"),
        code=2,
    )

    assert "nowhere" in run.err
    assert len(run.err.strip().splitlines()) == 1  # the error, before any work
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "outputs",
    [
        ("-o", "a.html", "--json", "a.html"),
        ("-o", "a.html", "-o", "b/../a.html"),
        ("-o", "a.pdf", "--json", "c.json", "--csv", "c.json"),
    ],
)
def test_two_outputs_in_one_file_are_refused(tmp_path, monkeypatch, outputs):
    """However it is spelt, one file takes one output: else one would be lost."""
    (tmp_path / "b").mkdir()
    monkeypatch.chdir(tmp_path)
    run = call("report", "--no-validate", *outputs, code=2)

    assert_says(run.err, "two outputs", "one file")
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_chinese_names_make_no_noise(tmp_path, monkeypatch, caplog, capfd):
    """A name beyond the font of the figures is no warning where it can be shown.

    A warning would be an error here; what is logged comes on stderr elsewhere.
    """
    for file, name in (("g.yaml", "赵明"), ("h.yaml", "李")):
        text = GYRO.replace("name: g", f'name: "{name}"')
        (tmp_path / file).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    wanted = ("report", "g.yaml", "--compare", "h.yaml", "--requirement", "r.yaml")
    wanted += ("--no-validate", "-o", "x.html")
    run = call(*wanted, code=2)
    (tmp_path / "r.yaml").write_text(
        "name: r\nlimits: {gyro: {bias: 9 deg/h}}\n", encoding="utf-8"
    )
    run = call(*wanted)

    assert run.err == "x.html: written\n"
    assert (caplog.messages, capfd.readouterr().err) == ([], "")


@pytest.mark.slow
def test_allocation_and_comparison_go_with_it(tmp_path):
    """Their sections stand in the page, their numbers in the page's and the JSON."""
    page, file = tmp_path / "x.html", tmp_path / "x.json"
    for name in ("one", "two"):
        text = GYRO.replace("name: g", f"name: {name}")
        text += "variants: {C: {vendor: c}}\n"
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    call(
        *("report", tmp_path / "one.yaml#C", "--requirement", TACTICAL),
        *("--no-validate", "--allocate", "--compare", tmp_path / "two.yaml"),
        *("-o", page, "--json", file),
        code=0,
    )

    document = checked(json.loads(file.read_text(encoding="utf-8")))
    assert embedded(page) == document
    assert document["allocation"]["feasible"] in {True, False}
    names = {row["name"] for row in document["comparison"]["devices"]}
    assert names == {"one (C)", "two", "two (C)"}
    text = page.read_text(encoding="utf-8")
    assert "Allowable specification values" in text
    for file in document["comparison"]["inputs"]:
        assert file["sha256"] in text


@pytest.mark.parametrize(
    ("option", "words"),
    [(("--allocate",), "shares out"), (("--compare", "zhao-2019"), "sets devices")],
)
def test_what_needs_limits_says_so(tmp_path, option, words):
    """Allocation and comparison without a requirement are exit 2, nothing written."""
    run = call("report", *option, "-o", tmp_path / "x.html", code=2)

    assert words in run.err
    assert "--requirement" in run.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", [("--allocate",), ("--compare", "zhao-2019")])
def test_a_report_holds_one_budget(tmp_path, option):
    """What counts every source is refused beside --only, which leaves some out."""
    run = call(
        *("report", "--requirement", TACTICAL, "--only", "bias_stability"),
        *(*option, "-o", tmp_path / "x.html"),
        code=2,
    )

    assert "two budgets" in run.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["-#A", "-g.yaml"])
def test_commands_of_what_if_can_be_typed(tmp_path, monkeypatch, name):
    """Also of a variant on standard input and of a file named like an option."""
    monkeypatch.chdir(tmp_path)
    text = f"{GYRO}variants: {{A: {{vendor: a}}}}\n".encode()
    (tmp_path / "-g.yaml").write_bytes(text)
    done = []
    words = ["report", "--no-validate", "-o", "p.html", "--", name]
    for _ in range(2):
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text)))
        done.append(call(*words))
        page = (tmp_path / "p.html").read_text(encoding="utf-8")
        (model,) = re.findall(r'class="what-if-model">(.*?)</script>', page)
        model = json.loads(unescape(model))
        change = " --set gyro.bias_repeatability='2 deg/h'"
        words = shlex.split(f"{model['command']}{change}{model['operands']}")[1:]
        assert model["command_of_file"] == "budget analyze changed.yaml --no-validate"
    assert [run.code for run in done] == [0, 0], done
    assert "2 deg/h by --set" in done[1].out


def test_provenance_quotes_the_command(tmp_path):
    """The command stands in the page: base names, no outputs, no workers."""
    page = tmp_path / "x.html"
    call(
        *("report", f"{HG4930}#C", "--requirement", TACTICAL, "--no-validate"),
        *("--seed", "7", "--coverage", "95 %", "--workers", "2", "-o", page),
        code=0,
    )

    text = unescape(page.read_text(encoding="utf-8"))
    assert (
        "budget report 'hg4930.yaml#C' --requirement tactical-grade.yaml "
        "--seed 7 --coverage 0.95 --no-validate"
    ) in text.replace("\N{NO-BREAK SPACE}", " ")
    assert str(SPECS) not in text
    assert "--workers" not in text


def test_a_name_no_font_has_is_warned_of(tmp_path):
    """A character that cannot be printed is named, and the PDF is written."""
    device = put(tmp_path / "g.yaml", GYRO.replace("name: g", 'name: "g \\uE000"'))
    run = call("report", device, "--no-validate", "-o", tmp_path / "x.pdf", code=0)

    assert "U+E000" in run.err
    assert (tmp_path / "x.pdf").read_bytes().startswith(b"%PDF-")


@pytest.mark.smoke
def test_report_is_written(written):
    """`budget report -o x.html` writes one whole page, and says so on stderr."""
    run, folder = written

    assert "x.html: written" in run.err
    page = (folder / "x.html").read_text(encoding="utf-8")
    assert page.lower().startswith("<!doctype html>")
    assert page.rstrip().endswith("</html>")
    assert "Zhao 2019 optical IMU" in page


def test_report_of_the_same_day_is_the_same(written, tmp_path, monkeypatch):
    """With SOURCE_DATE_EPOCH both files have the same bytes, from any folder.

    Another process, folder and name; processes differ in the order of their sets.
    """
    _, folder = written
    monkeypatch.chdir(tmp_path)
    call(
        *("report", "--no-validate", "-o", "y.html", "-o", "y.pdf"),
        SOURCE_DATE_EPOCH="86400",
        code=0,
    )

    for suffix in ("html", "pdf"):
        one, two = folder / f"x.{suffix}", tmp_path / f"y.{suffix}"
        assert one.read_bytes() == two.read_bytes()
    assert b"1970-01-02" in (folder / "x.html").read_bytes()


def test_report_needs_an_output():
    """Without -o there is nothing to write: exit 2."""
    run = call("report", "--no-validate", code=2)

    assert "-o" in run.err


def test_report_of_an_unknown_kind(tmp_path):
    """`-o x.txt` is exit 2, even beside a good one, and nothing is written."""
    run = call(
        *("report", "--no-validate"),
        *("-o", tmp_path / "x.html", "-o", tmp_path / "x.txt"),
    )

    assert (run.code, run.out) == (2, "")
    assert "x.txt" in run.err
    assert ".html" in run.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["report", "compare", "paper"])
def test_paper_is_that_of_a_pdf(tmp_path, command):
    """Another paper, and one for a page that has none, is exit 2 before any work."""
    given = ("zhao-2019", "--requirement", REQUIREMENT) if command == "compare" else ()
    for paper, page, said in (
        ("legal", "x.pdf", "'a4', 'letter'"),
        ("letter", "x.html", "add -o FILE.pdf"),
    ):
        run = call(command, *given, "--paper", paper, "-o", tmp_path / page)
        assert (run.code, run.out) == (2, "")
        assert_says(run.err, said)
    assert list(tmp_path.iterdir()) == []


def test_report_against_a_requirement(tmp_path):
    """A failed requirement is said in the page; the exit code stays 0."""
    page = tmp_path / "x.html"
    call("report", "--no-validate", "--requirement", REQUIREMENT, "-o", page, code=0)

    text = page.read_text(encoding="utf-8")
    assert "navigation grade" in text
    assert re.search("fails", text, flags=re.IGNORECASE)
    assert "next_turn_on" in text


def test_requirement_agrees_with_the_same_options(tmp_path):
    """Saying what the requirement says is no conflict."""
    page, device = tmp_path / "x.html", tmp_path / "g.yaml"
    device.write_text(GYRO, encoding="utf-8")
    call(
        *("report", device, "--no-validate", "--requirement", REQUIREMENT, "-o", page),
        *("--coverage", "95 %", "--reference", "next_turn_on"),
        code=0,
    )


@pytest.mark.parametrize(
    ("option", "value"), [("--coverage", "0.9"), ("--reference", "nominal")]
)
def test_requirement_beside_another_option(tmp_path, option, value):
    """Another coverage or reference than the requirement's is exit 2, nothing done."""
    page = tmp_path / "x.html"
    run = call(
        *("report", "--no-validate", "--requirement", REQUIREMENT, "-o", page),
        *(option, value),
    )

    assert (run.code, run.out) == (2, "")
    assert option in run.err
    assert value in run.err
    assert not page.exists()


def test_requirement_without_a_limit_for_what_is_there(tmp_path):
    """Limits for an accelerometer alone cannot judge a gyro: exit 2."""
    device, requirement = tmp_path / "g.yaml", tmp_path / "r.yaml"
    device.write_text(GYRO, encoding="utf-8")
    requirement.write_text(
        "name: r\nlimits: {accelerometer: {bias: 80 ug}}\n", encoding="utf-8"
    )
    page = tmp_path / "x.html"
    run = call(
        *("report", device, "--no-validate", "--requirement", requirement, "-o", page)
    )

    assert (run.code, run.out) == (2, "")
    assert not page.exists()


def test_report_carries_the_exact_numbers(written):
    """The document that `analyze --json` prints stands whole in the page."""
    of_page = embedded(written[1] / "x.html")
    of_command = call("analyze", "--no-validate", "--json", "-").document
    assert of_page["outputs"] == of_command["outputs"]
    assert of_page["covariance"] == of_command["covariance"]
