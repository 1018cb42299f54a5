"""`budget compare`: exit codes, streams, files and the documents of the contract."""

from __future__ import annotations

import csv
import io
import json
import re

import pytest
from command_line import call
from places import DOCS
from reading import assert_says

SENSOR = """\
  errors:
    bias_repeatability: {bias} deg/h
    bias_stability: {{value: 0.04 deg/h, correlation_time: 300 s}}
    angle_random_walk: 0.005 deg/sqrt(h)
    scale_factor_repeatability: 50 ppm
    mounting_repeatability: 2 arcsec
"""
REQUIREMENT = """\
name: test grade
reference: nominal
limits: {gyro: {scale_factor: 200 ppm, mounting_angle: 10 arcsec, bias: 1 deg/h}}
"""
LAW = ("--method", "gum")
FEW = ("--trials", "20000", "--max-trials", "20000")


def device(name, bias, *, more=""):
    """Return the text of a device file with one gyro."""
    head = f"name: {name}\ntechnology: optical\n{more}gyro:\n"
    return head + SENSOR.format(bias=bias)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with devices and a requirement, and work there."""
    files = {
        "good.yaml": device("Good", 0.05, more="mass: 1 kg\n"),
        "bad.yaml": device("Bad", 2.0, more="mass: 2 kg\n"),
        "broken.yaml": device("Broken", 0.05).replace("50 ppm", "50 mV"),
        "twice.yaml": device("Twice", 0.1)
        + "variants:\n  B: {gyro: {errors: {bias_repeatability: 0.2 deg/h}}}\n",
        "grade.yaml": REQUIREMENT,
        "slow.yaml": "name: slow\ngyro: {rate: 2 deg/s}\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def compare(*args):
    """Call the command with the folder's requirement."""
    return call("compare", *args, "--requirement", "grade.yaml")


def names(run):
    """Return the names of the devices in a document, best first."""
    return [row["name"] for row in run.document["devices"]]


@pytest.mark.usefixtures("folder")
class TestExitCodes:
    """0 met, 1 not met, 2 bad input or bad call."""

    def test_met_is_0(self):
        """Where one device meets, the code is 0 though another fails."""
        assert compare("good.yaml", "bad.yaml", *LAW).code == 0

    def test_not_met_is_1(self):
        """Where no device meets, the code is 1 and the result is printed."""
        run = compare("bad.yaml", *LAW)

        assert run.code == 1
        assert "NOT MET: 0 of 1 gyro meets" in run.out

    def test_broken_file_is_2_and_the_rest_is_compared(self):
        """One broken file among three: its position on stderr, the rest on stdout."""
        run = compare("good.yaml", "broken.yaml", "bad.yaml", *LAW, "--json", "-")

        assert run.code == 2
        assert "broken.yaml:8:33: " in run.err
        assert "50 mV" in run.err
        assert names(run) == ["Good", "Bad"]

    def test_bad_input_wins_over_not_met(self):
        """A broken file and nobody who meets: 2, not 1."""
        assert compare("bad.yaml", "broken.yaml", *LAW).code == 2

    def test_strict_computes_nothing(self, folder):
        """With --strict a broken file stops all, and no file is written."""
        run = compare("good.yaml", "broken.yaml", *LAW, "--strict", "--json", "x.json")

        assert run.code == 2
        assert run.out == ""
        assert "broken.yaml:8:33: " in run.err
        assert not (folder / "x.json").exists()

    def test_all_broken_is_2(self):
        """With no file left there is nothing to compare."""
        assert compare("broken.yaml", *LAW).code == 2

    def test_no_number_of_bad_files_hides_a_good_one(self, folder):
        """Of 130 before it, one says 60 issues: a line a file, the rest are counted."""
        lines = "".join(f"    line_{k}: 1 deg/h\n" for k in range(60))
        text = f"name: many\ngyro:\n  errors:\n{lines}"
        (folder / "a-000.yaml").write_text(text, encoding="utf-8")
        for place in range(1, 130):
            (folder / f"a-{place:03d}.yaml").write_text("gyro: [\n", encoding="utf-8")
        bad = sorted(path.name for path in folder.glob("a-*.yaml"))

        run = compare(*bad, "good.yaml", *LAW, "--json", "-")

        assert run.code == 2
        assert names(run) == ["Good"]
        first, *others, last = run.err.splitlines()
        assert first.startswith("a-000.yaml:4:5: ")
        assert first.endswith(" (and 59 more)")
        assert [one.partition(":")[0] for one in others] == bad[1:20]
        assert last == "110 more files cannot be read; mend those above first"

    @pytest.mark.parametrize(
        ("args", "said"),
        [
            ((), "nothing to compare"),
            (("good.yaml", "--json", "-", "--csv", "-"), "both write to stdout"),
            (("good.yaml", "-o", "x.txt"), "allowed: .html, .pdf"),
            (("good.yaml", "--validate"), "--method gum"),
            (("good.yaml", "--sort", "verdikt"), "did you mean 'verdict'"),
            (("good.yaml", "--procedure", "absent.yaml"), "no such file"),
            (
                ("good.yaml", "--procedure", "slow.yaml", "--procedure", "slow.yaml"),
                "of the same name: slow",
            ),
        ],
    )
    def test_bad_calls_are_2(self, args, said):
        """A bad call is refused with what to do, and nothing on stdout."""
        run = compare(*args)

        assert run.code == 2
        assert said in run.err
        assert run.out == ""

    def test_requirement_is_needed(self):
        """Without a requirement there is nothing to hold devices against."""
        assert call("compare", "good.yaml").code == 2


@pytest.mark.usefixtures("folder")
class TestDocuments:
    """JSON and CSV of the contract."""

    def test_keys_of_the_contract(self):
        """Every key that FORMATS promises is there, with a device's own numbers."""
        run = compare("good.yaml", "bad.yaml", *FEW, "--json", "-")
        document = run.document
        good = document["devices"][0]

        assert (document["schema"], document["command"]) == ("budget/1", "compare")
        assert set(good) >= {
            *("name", "sensor", "verdict", "utilisation", "utilisation_interval"),
            *("worst_output", "conformance", "conformance_interval"),
            *("limiting_source", "not_given"),
        }
        assert good["verdict"] == "meets"
        low, high = good["utilisation_interval"]
        assert low < good["utilisation"] < high
        assert good["utilisation"] == max(o["utilisation"] for o in good["outputs"])
        assert good["worst_output"].startswith("gyro.")
        assert {"role", "name", "sha256"} == set(document["inputs"][0])
        roles = [file["role"] for file in document["inputs"]]
        assert roles == ["device", "device", "procedure", "requirement"]
        assert document["settings"]["trials"] == 20_000

    @pytest.mark.slow
    def test_same_bytes_for_any_number_of_workers(self):
        """Workers share out devices and change no byte."""
        one, two = (
            compare("good.yaml", "bad.yaml", *FEW, "--json", "-", "--workers", n).out
            for n in (1, 2)
        )

        assert one == two

    def test_seed_moves_the_numbers(self):
        """Control: another seed gives other trials."""
        one, two = (
            compare("good.yaml", *FEW, "--json", "-", "--seed", seed).out
            for seed in (0, 1)
        )

        assert one != two

    def test_csv_has_a_row_for_each_device_and_output(self):
        """Two gyros of twelve required outputs: 24 rows, in printed units."""
        text = compare("good.yaml", "bad.yaml", *LAW, "--csv", "-").out
        rows = list(csv.DictReader(io.StringIO(text)))

        assert len(rows) == 24
        biases = [r for r in rows if r["parameter"] == "bias" and r["device"] == "Bad"]
        assert {row["unit"] for row in biases} == {"deg/h"}
        assert {float(row["limit"]) for row in biases} == {1.0}
        assert min(float(row["utilisation"]) for row in biases) > 1.0

    def test_variants_are_devices_of_their_own(self):
        """FILE is the base and every variant, FILE#VARIANT that one."""
        both = names(compare("twice.yaml", *LAW, "--json", "-"))
        one = names(compare("twice.yaml#B", *LAW, "--json", "-"))

        assert both == ["Twice", "Twice (B)"]
        assert one == ["Twice (B)"]

    def test_files_are_written_beside_the_table(self, folder):
        """With --json FILE and -o the table still stands on stdout."""
        run = compare(
            *("good.yaml", *LAW, "--json", "x.json"), *("-o", "x.html", "-o", "x.pdf")
        )

        assert run.code == 0
        assert "Good" in run.out
        assert json.loads((folder / "x.json").read_text(encoding="utf-8"))["met"]
        page = (folder / "x.html").read_text(encoding="utf-8")
        assert "gyro meets test grade" in page
        assert "budget compare good.yaml --requirement grade.yaml" in page
        assert (folder / "x.pdf").read_bytes().startswith(b"%PDF-")


@pytest.mark.usefixtures("folder")
class TestTable:
    """What stands on the terminal."""

    def test_best_first_with_verdicts(self):
        """The table names who meets and who fails, the best first."""
        out = compare("bad.yaml", "good.yaml", *LAW).out

        rows = [line.split()[:3] for line in out.splitlines()]
        (bad,) = (k for k, row in enumerate(rows) if row[:2] == ["Bad", "fails"])
        (good,) = (k for k, row in enumerate(rows) if row[:2] == ["Good", "meets"])
        assert good < bad
        assert "1 meet, 1 fail" in out

    def test_sort_by_another_column(self):
        """--sort device puts the table, not the ranks, in another order."""
        lines = compare("good.yaml", "bad.yaml", *LAW, "--sort", "device").out
        rows = [x.split()[:2] for x in lines.splitlines() if x[:4] in {"Bad ", "Good"}]

        assert rows[:2] == [["Bad", "fails"], ["Good", "meets"]]

    def test_procedures_stand_side_by_side(self):
        """Two procedures: one table with a column for each."""
        out = compare(
            *("good.yaml", "bad.yaml", *LAW),
            *("--procedure", "zhao-2019", "--procedure", "slow.yaml", "--full"),
        ).out
        heads = [x.split() for x in out.splitlines() if x.startswith("device ")]

        assert heads[1] == ["device", "Zhao", "2019", "slow"]

    def test_pairs_need_both_sensors(self):
        """Pairs of a comparison of both sensors are printed, those of one are not."""
        wanted = ("compare", "zhao-2019", "--requirement", "catalogue-edge", *LAW)
        shipped = call(*wanted, "--pairs")

        assert "Pairs of gyro and accelerometer" in shipped.out
        assert "IMUs as one device" in call(*wanted, "--full").out
        assert "Pairs" not in compare("good.yaml", *LAW, "--pairs").out
        assert "Pairs" not in call(*wanted).out
        assert "IMUs" not in compare("good.yaml", *LAW).out

    def test_the_catalogue_is_what_ships(self, tmp_path, monkeypatch):
        """Outside a checkout, as if each file were named; what is named too, once."""
        monkeypatch.chdir(tmp_path)
        rest = ("--requirement", "catalogue-edge", *LAW, "--json", "-")
        chosen = ("--catalogue", "--kind", "imu", "--grade", "navigation")
        found = call("compare", *chosen, *rest).document
        named = call("compare", "cgys30cj3#A", "zhao-2019", *rest).document

        assert found == named
        assert len(found["imus"]) == 2
        twice = call("compare", "zhao-2019", *chosen, *rest).document
        names = [one["name"] for one in twice["devices"]]
        assert sorted(names) == sorted(one["name"] for one in found["devices"])

    @pytest.mark.parametrize("words", [(), ("zhao-2019", "--kind", "imu")])
    def test_choosing_needs_the_catalogue(self, words):
        """Nothing to compare, or a choice among nothing, is refused with the way."""
        found = call("compare", *words, "--requirement", "catalogue-edge", code=2)
        assert "--catalogue" in found.err

    def test_nothing_on_stderr_where_all_is_well(self):
        """Talk goes to stderr, and there is none."""
        assert compare("good.yaml", *LAW).err == ""


@pytest.mark.slow
def test_the_example_of_the_library_runs_as_printed(capsys):
    """The example of docs/comparing.md ranks the catalogue, the best gyro first."""
    docs = DOCS / "comparing.md"
    (code,) = re.findall(
        r"```python\n(.*?)```", docs.read_text(encoding="utf-8"), re.DOTALL
    )
    exec(compile(code, "comparing.md", "exec"), {})  # noqa: S102 - our own text

    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("gyro ")
    assert "meets" in lines[0]


ON_MISSION = """\
name: a mile an hour
limits:
  mission: {position: {horizontal: 3 nmi, at: 1 h, probability: 50 %}}
"""


@pytest.mark.usefixtures("folder")
class TestMission:
    """Limits on a mission: devices of both sensors in a list of their own."""

    @pytest.fixture(autouse=True)
    def _mile(self, folder):
        (folder / "mile.yaml").write_text(ON_MISSION, encoding="utf-8")

    def test_document_names_the_mission(self):
        """Beside the verdict by mission stand its name and its file."""
        limits = ("--requirement", "mile.yaml", "--mission", "bench")
        run = call("compare", "zhao-2019", "good.yaml", *limits, *LAW, "--json", "-")

        (row,) = run.document["devices"]
        assert (row["sensor"], row["verdict"]) == ("mission", "fails")
        assert row["worst_output"] == "mission.position.horizontal.3600"
        assert run.document["mission"] == "bench, 1 h"
        assert any(file["role"] == "mission" for file in run.document["inputs"])
        assert "have no accelerometer: Good" in " ".join(run.document["warnings"])

    def test_the_map_says_what_is_limited_and_when(self, folder):
        """Above a column stand quantity, axis and time: it is no angle of a sensor."""
        twice = ON_MISSION.replace("}}", "}, heading: {limit: 1 deg, at: 1 h}}")
        (folder / "mile.yaml").write_text(twice, encoding="utf-8")
        limits = ("--requirement", "mile.yaml", "--mission", "bench")
        run = call("compare", "zhao-2019", *limits, *LAW, "-o", "a.html")

        assert "a.html: written" in run.err
        text = (folder / "a.html").read_text(encoding="utf-8")
        (drawn,) = re.findall(r'id="map-mission-0-figure".*?</svg>', text, re.DOTALL)
        told = re.findall(r"<text[^>]*>([^<]*)</text>", drawn)
        assert {"position", "horizontal", "after 1 h"} <= set(told)
        assert "angle" not in told

    def test_limits_without_a_mission_are_refused(self):
        """Exit code 2, the limit named, and what to do."""
        run = call("compare", "zhao-2019", "--requirement", "mile.yaml", *LAW, code=2)

        assert "mission.position.horizontal.3600" in run.err
        assert "--mission" in run.err

    @pytest.mark.slow
    @pytest.mark.parametrize("calibration", ["none", "factory", "six-positions"])
    def test_verdict_is_that_of_the_mission(self, calibration):
        """Whatever calibrated the unit, `budget mission` says the same of it."""
        same = ("--requirement", "mile.yaml", "--mission", "bench")
        same += ("--calibration", calibration, "--json", "-")

        (row,) = call("compare", "zhao-2019", *same).document["devices"]
        budget = call("mission", "zhao-2019", *same, "--no-validate").document

        (found,) = budget["assessment"]["sensors"]
        assert row["verdict"] == found["verdict"]
        assert row["utilisation"] == found["utilisation"]

    def test_calibration_named_twice_is_refused(self):
        """A procedure and --calibration both say what calibrated the unit."""
        twice = ("--calibration", "none", "--procedure", "zhao-2019")
        run = call(
            *("compare", "zhao-2019", "--requirement", "mile.yaml"),
            *("--mission", "bench", *twice),
            code=2,
        )

        assert "leave one out" in run.err


TRIADS = """\
name: {name}
technology: MEMS
range: {{gyro: {range} deg/s, accelerometer: 10 g}}
gyro:
  errors:
    bias_repeatability: 3 deg/h
    bias_stability: {{value: {drift} deg/h, correlation_time: 100 s}}
    angle_random_walk: 0.1 deg/sqrt(h)
    scale_factor_repeatability: 300 ppm
    mounting_repeatability: 10 arcsec
    g_sensitivity: 1 deg/h/g
accelerometer:
  errors:
    bias_repeatability: 0.5 mg
    bias_stability: {{value: 50 ug, correlation_time: 100 s}}
    velocity_random_walk: 0.05 m/s/sqrt(h)
    scale_factor_repeatability: 300 ppm
    mounting_repeatability: 10 arcsec
"""
JOURNEY = """\
name: minute
environment: none
mission:
  latitude: 45 deg
  segments:
    - {straight: 20 s, speed: 20 m/s}
    - {turn: 90 deg, rate: 36 deg/s}
    - {straight: 40 s}
"""
ROAD = """\
name: road
environment: none
limits: {mission: {position: {horizontal: 150 m, at: 60 s, probability: 50 %}}}
"""


def test_what_decides_stands_beside_the_rows_that_are_shown(folder):
    """Of a unit that saturates in place of numbers; of conditions once for several."""
    for name, size, drift in (
        ("Narrow", 30, 1),
        ("Quiet", 400, 0),
        ("Silent", 400, 0),
    ):
        text = TRIADS.format(name=name, range=size, drift=drift)
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    (folder / "journey.yaml").write_text(JOURNEY, encoding="utf-8")
    (folder / "road.yaml").write_text(ROAD, encoding="utf-8")
    files = ("Narrow.yaml", "Quiet.yaml", "Silent.yaml")
    how = ("--requirement", "road.yaml", "--mission", "journey.yaml", *LAW)
    pages = [
        " ".join(call("compare", *files, *how, *more).out.split())
        for more in ((), ("--full",))
    ]
    call("compare", *files, *how, "-o", "c.html")
    page = (folder / "c.html").read_text(encoding="utf-8")
    first = page.partition('id="figures"')[0]

    for text in (*pages, first):
        assert_says(text, "saturates: gyro z asks", "36 deg/s")
        assert "None;" not in text
    assert pages[0].count("meets if gyro bias stability stays below") == 1
    assert "Quiet, Silent (mission): meets if" in pages[0]
    assert_says(first, "Quiet, Silent (mission): meets if")
    row = pages[0].partition("Narrow fails")[2].partition("saturates")[0]
    assert row.split() == ["-"]
    alone = " ".join(call("compare", "Narrow.yaml", *how).out.split())
    assert "saturates: gyro z asks" in alone
    assert "None;" not in alone
