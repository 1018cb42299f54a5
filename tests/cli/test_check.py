"""`budget check`: what it prints, writes and returns."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
from pathlib import Path

import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import ROOT, put
from reading import assert_says
from reference_examples import DEVICE, computing_once, store, stored

from budget.errors import ReferenceFileError
from budget.references.files import shipped_references, take
from budget.resources import shipped

WORSE = DEVICE.replace("value: 0.04 deg/h", "value: 0.0404 deg/h")
EDITED = DEVICE.replace("notes: not a number", "notes: still none")
KEY = "gyro.errors.bias_stability"

computed_once = pytest.fixture(scope="module", autouse=True)(computing_once)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with a device and its reference, and work there."""
    monkeypatch.chdir(tmp_path)
    store(tmp_path)
    return tmp_path


def rewrite(folder, text):
    """Change the device file."""
    (folder / "imu.yaml").write_text(text, encoding="utf-8")


def flat(text):
    """Return a text without its line breaks."""
    return " ".join(text.split())


class TestShipped:
    """References that ship."""

    @pytest.mark.slow
    @pytest.mark.smoke
    @pytest.mark.kernels
    def test_they_hold(self):
        """Without a name all are checked, all hold, each in one line."""
        run = call("check", code=0)

        names = [one.shown for one in shipped_references()]
        lines = [line for line in run.out.splitlines() if "  unchanged  " in line]
        assert [line.split()[0] for line in lines] == names
        assert f"{len(names)} references: {len(names)} unchanged, 0 moved" in run.out
        assert max(map(len, lines)) <= 80

    def test_they_are_what_was_promised(self):
        """Both formulas by three references; three devices; comparison, allocation."""
        found = {one.shown: stored(one.path) for one in shipped_references()}
        jobs = [reference.job for reference in found.values()]
        assert (jobs.count("compare"), jobs.count("allocate")) == (1, 1)
        paper = [
            (reference.settings.reference, reference.inputs[1].file)
            for name, reference in found.items()
            if name.startswith("zhao-2019-")
        ]
        assert len(set(paper)) == 6
        assert {origin for origin, _ in paper} == {
            *("nominal", "as_tested", "next_turn_on"),
        }
        assert "monte-carlo" in {r.settings.method for r in found.values()}
        assert any(r.settings.samples for r in found.values())
        assert all(one.path.stat().st_size < 300_000 for one in shipped_references())

    def test_they_can_be_stored_again(self, tmp_path):
        """`docs/make_references.py` stores these, with the same settings and inputs."""
        text = (ROOT / "docs" / "make_references.py").read_text(encoding="utf-8")
        for one in shipped_references():
            stem = one.shown.removeprefix("zhao-2019-corrected-")
            assert stem.removeprefix("zhao-2019-eq4-") in text
        shutil.copytree(shipped("specs"), tmp_path / "specs")
        path = tmp_path / "specs" / "references" / "zhao-2019-eq4-nominal.json"
        before = stored(path)
        specs = tmp_path / "specs"
        call(
            *("check", "--save", path, specs / "devices" / "zhao-2019.yaml"),
            *("--procedure", specs / "procedures" / "zhao-2019-eq4.yaml"),
            *("--reference", "nominal"),
            code=0,
        )
        after = stored(path)
        assert (after.inputs, after.settings) == (before.inputs, before.settings)

    def test_by_bare_name(self):
        """A shipped reference is found by its name, from any folder."""
        run = call("check", "hg4930-c")
        assert (run.code, run.out.split()[:2]) == (0, ["hg4930-c", "unchanged"])


class TestMoved:
    """A reference that moved."""

    def test_text(self, folder):
        """The key with both figures, the output, from, to, tolerances, the cause."""
        rewrite(folder, WORSE)
        run = call("check", "ref.json", code=1)

        assert "ref.json  MOVED" in run.out
        assert f"1. device imu.yaml: {KEY}: 0.04 deg/h -> 0.0404 deg/h" in run.out
        head, *rows = run.out[run.out.index("Gyro bias, u") :].splitlines()
        assert head == "Gyro bias, u [deg/h]"
        assert rows[0].split() == [
            *("all", "0.05638", "0.05649", "+0.19", "%", "1.9e6", "tol", "1"),
        ]
        assert "1 reference: 0 unchanged, 1 moved" in run.out

    @pytest.mark.parametrize("width", ["40", "80", "120"])
    def test_fits(self, folder, width):
        """No line is longer than the terminal is wide."""
        rewrite(folder, WORSE.replace("37 ppm", "70 ppm"))
        run = call("check", "ref.json", COLUMNS=width, code=1)

        assert max(map(len, run.out.splitlines())) <= int(width)

    def test_json(self, folder):
        """The document has every move with its cause, and what the law says of it."""
        rewrite(folder, WORSE)
        run = call("check", "ref.json", "--json", "-", code=1)

        document = run.document
        assert (document["schema"], document["command"]) == ("budget/1", "check")
        assert document["holds"] is False
        (one,) = document["references"]
        assert (one["name"], one["kind"], one["holds"]) == (
            "ref.json",
            "analyze",
            False,
        )
        (change,) = one["changes"]
        assert change == {
            "where": "device imu.yaml",
            "key": KEY,
            "before": "0.04 deg/h",
            "after": "0.0404 deg/h",
            "acts": True,
            "is_text": False,
        }
        (u,) = (
            row
            for row in document["moved"]
            if (row["subject"], row["quantity"])
            == ("gyro.bias.x", "standard_uncertainty")
        )
        assert (u["reference"], u["unit"], u["sampled"]) == ("ref.json", "deg/h", False)
        assert_allclose(u["after"] - u["before"], u["difference"], rtol=1e-12)
        assert_allclose(u["difference"] / u["before"], u["relative"], rtol=1e-12)
        assert u["because"] == f"{KEY} 100 %"
        (cause,) = u["causes"]
        assert_allclose(cause["amount"], u["difference"], rtol=1e-9)

    def test_csv(self, folder):
        """One row for each move, numbers with all their digits."""
        rewrite(folder, WORSE)
        moved = call("check", "ref.json", "--json", "-").document["moved"]
        run = call("check", "ref.json", "--csv", "-", code=1)

        rows = list(csv.DictReader(io.StringIO(run.out)))
        assert [float(row["after"]) for row in rows] == [row["after"] for row in moved]
        assert {row["because"] for row in rows} == {f"{KEY} 100 %"}

    def test_files_are_written_though_it_moved(self, folder):
        """Both documents as files, the table on stdout, exit code 1."""
        rewrite(folder, WORSE)
        run = call("check", "ref.json", "--json", "a.json", "--csv", "a.csv")

        assert (run.code, "MOVED" in run.out) == (1, True)
        assert json.loads((folder / "a.json").read_text())["moved"]
        assert (folder / "a.csv").read_text().startswith("reference,subject,quantity")

    def test_two_changes_share_a_move(self, folder):
        """Each change explains its part; they are numbered as the table names them."""
        rewrite(folder, WORSE.replace("repeatability: 0.05", "repeatability: 0.0505"))
        document = call("check", "ref.json", "--json", "-").document

        (u,) = (
            row
            for row in document["moved"]
            if (row["subject"], row["quantity"])
            == ("gyro.bias.z", "standard_uncertainty")
        )
        amounts = [cause["amount"] for cause in u["causes"]]
        assert len(amounts) == 2
        # Small changes of variances add up to second order.
        assert_allclose(sum(amounts), u["difference"], rtol=1e-2)
        assert u["because"].startswith("gyro.errors.bias_repeatability")

    def test_a_change_of_the_procedure(self, folder):
        """The procedure is named as the cause where it changed."""
        shutil.copy(shipped("specs") / "procedures" / "zhao-2019.yaml", "how.yaml")
        call("check", "--save", "p.json", "imu.yaml", "--procedure", "how.yaml", code=0)
        text = (folder / "how.yaml").read_text()
        (folder / "how.yaml").write_text(text.replace("turns: 1", "turns: 2"))
        run = call("check", "p.json", code=1)

        assert "procedure how.yaml: gyro.turns: 1 -> 2" in run.out

    def test_a_change_of_the_requirement(self, folder):
        """A tighter limit moves the utilisation and the verdict."""
        text = (
            "name: mine\nreference: nominal\n"
            "limits: {gyro: {bias: 0.2 deg/h}, accelerometer: {bias: 100 ug}}\n"
        )
        (folder / "want.yaml").write_text(text)
        call(
            "check",
            "--save",
            "q.json",
            "imu.yaml",
            "--requirement",
            "want.yaml",
            code=0,
        )
        (folder / "want.yaml").write_text(text.replace("0.2 deg/h", "0.1 deg/h"))
        run = call("check", "q.json", code=1)

        assert "requirement want.yaml: limits.gyro.bias: 0.2 deg/h -> 0.1" in run.out
        assert "Gyro, verdict: " in run.out
        assert "-> fails" in run.out

    def test_the_law_explains_what_trials_moved(self, folder):
        """One key leaves nothing to do together by the law, whatever trials say."""
        args = ("--method", "monte-carlo", "--trials", "2000")
        assert call("check", "--save", "m.json", "imu.yaml", *args).code == 0
        rewrite(folder, DEVICE.replace("37 ppm", "70 ppm"))
        moved = call("check", "m.json", "--json", "-").document["moved"]

        assert any(row["sampled"] for row in moved)
        assert {row["together"] for row in moved} == {None}

    def test_a_line_taken_out(self, folder):
        """What is gone is said to be, and the line too."""
        rewrite(
            folder, DEVICE.replace("    angle_random_walk: 0.005 deg/sqrt(h)\n", "")
        )
        run = call("check", "ref.json", code=1)

        said = "angle_random_walk: {value: 0.005 deg/sqrt(h)} -> (not there)"
        assert said in flat(run.out)
        assert "gyro.angle_random_walk" in run.out

    def test_keys_of_one_figure_are_tried_together(self, folder):
        """Two keys of a figure, of which one alone is refused, are one change."""
        sigma = DEVICE.replace("correlation_time: 300 s", "meaning: 2 sigma")
        store(folder, sigma)
        # With 2 sigma an Allan minimum is refused.
        rewrite(folder, sigma.replace("meaning: 2 sigma", "definition: allan_minimum"))
        document = call("check", "ref.json", "--json", "-").document

        (change,) = document["references"][0]["changes"]
        assert change == {
            "where": "device imu.yaml",
            "key": KEY,
            "before": "{value: 0.04 deg/h, meaning: 2 sigma}",
            "after": "{value: 0.04 deg/h, definition: allan_minimum}",
            "acts": True,
            "is_text": False,
        }
        assert {row["because"] for row in document["moved"]} == {f"{KEY} 100 %"}

    def test_a_key_that_cannot_be_tried_alone(self, folder):
        """Two keys that only go together are named, and the one is marked."""
        how = put(
            folder / "how.yaml",
            "name: how\nsample_rate: 100 Hz\ngyro: {dwell: 300 s}\n",
        )
        call("check", "--save", "p.json", "imu.yaml", "--procedure", "how.yaml", code=0)
        # A window of 5 ms holds no sample at 100 Hz.
        how.write_text("name: how\nsample_rate: 1 kHz\ngyro: {dwell: 5 ms}\n")
        run = call("check", "p.json", code=1)

        said = flat(run.out)
        assert "gyro.dwell: 300 s -> 5 ms (cannot be tried by itself)" in said
        assert re.search(r"(?m)^all .*together: 100 %", run.out)

    @pytest.mark.usefixtures("folder")
    def test_another_version_of_the_tool(self, monkeypatch):
        """Numbers that the tool itself moved are laid at its door, with the version."""
        from budget.references import check as module
        from budget.references import jobs

        monkeypatch.setattr(
            module, "present_versions", lambda: {"budget": "9.9", "numpy": "9.0"}
        )
        monkeypatch.setattr(module, "compute", jobs.compute)  # anew
        monkeypatch.setattr(jobs, "analyze", _with_other_trigger(jobs.analyze))
        run = call("check", "ref.json", code=1)

        assert "tool: budget: 0.1.0 -> 9.9" in run.out
        assert "tool: numpy: " in run.out
        assert "imu.yaml: " not in run.out

    @pytest.mark.usefixtures("folder")
    def test_another_version_that_moves_nothing(self, monkeypatch):
        """A reference that holds says once that other versions stored it."""
        from budget.references import check as module

        monkeypatch.setattr(module, "present_versions", lambda: {"budget": "9.9"})
        run = call("check", "ref.json", code=0)

        assert "stored with other versions: budget 0.1.0 -> 9.9" in run.out


def _with_other_trigger(analyze):
    """Return the main job as a later version may have it: another coverage factor."""

    def changed(*devices, **options):
        return analyze(*devices, coverage=0.95 + 1e-4, **options)

    return changed


class TestHolds:
    """Changes that move nothing."""

    def test_a_changed_text_is_reported(self, folder):
        """Notes move no number: exit code 0, and the key is named."""
        rewrite(folder, EDITED)
        run = call("check", "ref.json", code=0)

        assert "ref.json  unchanged" in run.out
        said = "notes: not a number -> still none (moves no number)"
        assert said in flat(run.out)
        (one,) = call("check", "ref.json", "--json", "-").document["references"]
        assert [change["key"] for change in one["changes"]] == ["notes"]

    def test_a_comment_is_no_change(self, folder):
        """A comment, quotes or order of keys are no change of content."""
        rewrite(
            folder, "# a comment\n" + DEVICE.replace("Two sensors", "'Two sensors'")
        )
        run = call("check", "ref.json", code=0)

        assert " changed" not in run.out

    def test_from_any_folder(self, folder, tmp_path_factory, monkeypatch):
        """Paths count from the reference, not from where the check is called."""
        monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
        assert call("check", folder / "ref.json").code == 0
        assert call("check", folder).code == 0

    def test_moved_to_another_place(self, folder, tmp_path_factory):
        """Reference and device may move together."""
        there = tmp_path_factory.mktemp("there") / "inside"
        shutil.copytree(folder, there)
        assert call("check", there / "ref.json").code == 0

    def test_by_any_number_of_workers(self, folder):
        """Workers change no bit."""
        args = ("--method", "monte-carlo", "--trials", "20000")
        assert call("check", "--save", "a.json", "imu.yaml", *args).code == 0
        assert (
            call("check", "--save", "b.json", "imu.yaml", *args, "--workers", 2).code
            == 0
        )
        one, other = ((folder / name).read_bytes() for name in ("a.json", "b.json"))
        assert one == other


# ---- references that cannot be checked, and storing new ones -------------------------


class TestBad:
    """References that cannot be checked."""

    def test_an_input_gone(self, folder):
        """Exit code 2: which file is not there, and what to do."""
        (folder / "imu.yaml").unlink()
        run = call("check", "ref.json", code=2)

        assert run.err.startswith("ref.json: ")
        assert run.err.count("\n") == 1
        assert_says(run.err, "imu.yaml", "not there", "put the file back", "save")

    def test_an_input_broken(self, folder):
        """A device file that is none any more is told with its place."""
        rewrite(folder, DEVICE.replace("37 ppm", "37 apples"))
        run = call("check", "ref.json", code=2)

        assert "imu.yaml:15:33:" in run.err
        assert "apples" in run.err

    def test_the_others_are_checked_all_the_same(self, folder):
        """One bad reference does not hide what another says; exit code 2."""
        rewrite(folder, WORSE)
        (folder / "bad.json").write_text("{")
        run = call("check", "bad.json", "none.json", "ref.json", "hg4930-c", code=2)

        assert "bad.json:1:2: ends too early" in run.err
        assert "none.json: no such file" in run.err
        assert "ref.json  MOVED" in run.out
        assert "4 references: 1 unchanged, 1 moved, 2 cannot be checked" in run.out
        document = call("check", "bad.json", "ref.json", "--json", "-").document
        assert len(document["errors"]) == 1
        assert document["holds"] is False

    def test_a_near_name(self):
        """A misspelt shipped name gets a hint."""
        run = call("check", "hg4930c")
        assert (run.code, "did you mean 'hg4930-c'" in run.err) == (2, True)

    def test_an_empty_folder(self, folder):
        """A folder without references is a bad call."""
        (folder / "empty").mkdir()
        run = call("check", "empty")
        assert (run.code, "has no .json file" in run.err) == (2, True)

    @pytest.mark.parametrize(
        "option",
        [("--seed", "0"), ("--method", "gum"), ("--procedure", "x"), ("--sobol",)],
    )
    @pytest.mark.usefixtures("folder")
    def test_settings_are_for_saving(self, option):
        """A setting beside a check would be passed over: refused."""
        run = call("check", "ref.json", *option)
        assert (run.code, "with --save FILE" in run.err) == (2, True)

    @pytest.mark.usefixtures("folder")
    def test_two_documents_on_stdout(self):
        """--json - and --csv - cannot both be."""
        assert call("check", "ref.json", "--json", "-", "--csv", "-").code == 2

    def test_no_reference_is_overwritten_by_a_result(self, folder):
        """--json REFERENCE is refused, the reference stays."""
        before = (folder / "ref.json").read_bytes()
        assert call("check", "ref.json", "--json", "ref.json").code == 2
        assert (folder / "ref.json").read_bytes() == before


class TestSave:
    """Storing a reference."""

    def test_it_says_what_it_wrote(self, folder):
        """One line on stderr, nothing on stdout; the reference holds."""
        run = call(
            "check", "--save", "new.json", "imu.yaml", "--reference", "as_tested"
        )

        assert (run.code, run.out) == (0, "")
        assert run.err.startswith("new.json: written, analyze, ")
        assert call("check", "new.json").code == 0
        assert stored(folder / "new.json").settings.reference == "as_tested"

    def test_it_accepts_a_change(self, folder):
        """Storing again over a reference that moved makes it hold."""
        rewrite(folder, WORSE)
        assert call("check", "ref.json").code == 1
        assert call("check", "--save", "ref.json", "imu.yaml").code == 0
        assert call("check", "ref.json").code == 0

    def test_without_a_device(self, folder):
        """The built-in device, saying so, found by name wherever the file goes."""
        run = call("check", "--save", "paper.json")
        assert (run.code, "built-in zhao-2019" in run.err) == (0, True)
        assert [one.file for one in stored(folder / "paper.json").inputs] == [
            *("zhao-2019", "zhao-2019"),
        ]

    @pytest.mark.slow
    @pytest.mark.parametrize("kind", ["compare", "allocate"])
    def test_other_kinds(self, folder, kind):
        """A comparison and an allocation are stored, hold, and move with an input."""
        call(
            *("check", "--save", "k.json", "imu.yaml", "--kind", kind),
            *("--requirement", "navigation-grade"),
            code=0,
        )
        assert call("check", "k.json").code == 0
        rewrite(folder, WORSE)
        moved = call("check", "k.json", code=1)
        assert f"{KEY}: 0.04 deg/h -> 0.0404 deg/h" in moved.out

    @pytest.mark.parametrize(
        "args",
        [
            ("--method", "monte-carlo", "--interval", "shortest"),
            ("--method", "simulation", "--trials", "3"),
            ("--method", "monte-carlo", "--trials", "5000", "--only", "bias_stability"),
            ("--sobol", "--samples", "32", "--coverage", "99 %"),
        ],
        ids=" ".join,
    )
    def test_other_methods(self, folder, args):
        """Adaptive trials, simulation, one source alone, indices: stored, and hold."""
        call("check", "--save", "m.json", "imu.yaml", *args, code=0)
        assert any(n.is_sampled for n in stored(folder / "m.json").numbers)
        assert call("check", "m.json").code == 0

    def test_a_variant_that_is_new(self, folder):
        """A comparison of a file takes all its variants: a new one is a move."""
        more = DEVICE + "variants:\n  A: {notes: one}\n"
        rewrite(folder, more)
        args = ("--kind", "compare", "--requirement", "navigation-grade")
        assert call("check", "--save", "v.json", "imu.yaml", *args).code == 0
        rewrite(folder, more + "  B: {gyro: {errors: {bias_stability: 1 deg/h}}}\n")
        run = call("check", "v.json", code=1)

        assert "device: imu.yaml#B: (not there) -> there" in run.out

    @pytest.mark.parametrize(
        ("args", "said"),
        [
            (("imu.yaml", "--kind", "compare"), "needs a requirement"),
            (("imu.yaml", "--kind", "allocate"), "needs a requirement"),
            (("imu.yaml", "--costs", "costs.yaml"), "1 of role costs, a reference of"),
            (("imu.yaml", "--strategy", "equal"), "--strategy: means nothing"),
            (("imu.yaml", "--kind", "compare", "--only", "x"), "--only: means nothing"),
            (("imu.yaml", "imu.yaml"), "both have a gyro"),
            (("no.yaml",), "no such file"),
            (("imu.yaml#Z",), "no variant 'Z'"),
            (("hg4930",), "hg4930:20:1: variants: the base is abstract, choose"),
            (("imu.yaml", "--only", "nothing"), "is no source"),
            (("imu.yaml", "--json", "-"), "are for checks"),
            (
                ("imu.yaml", *("--procedure", "zhao-2019", "--procedure", "hg4930-c")),
                "no such file",
            ),
            (
                (
                    *("imu.yaml", "--procedure", "zhao-2019"),
                    *("--procedure", "zhao-2019-eq4"),
                ),
                "2 procedures were given",
            ),
            (
                (
                    *("imu.yaml", "--requirement", "navigation-grade"),
                    *("--coverage", "0.9"),
                ),
                "differs from the requirement's",
            ),
            (
                (
                    *("imu.yaml", "--kind", "allocate", "--fix", "nothing"),
                    *("--requirement", "navigation-grade"),
                ),
                "--fix: 'nothing' is no source",
            ),
        ],
    )
    def test_bad_calls(self, folder, args, said):
        """Exit code 2, what is wrong, and nothing written."""
        (folder / "costs.yaml").write_text("costs: {gyro.bias_stability: {p: 2}}\n")
        run = call("check", "--save", "new.json", *args)

        assert (run.code, said in run.err) == (2, True), run.err
        assert not (folder / "new.json").exists()

    def test_no_input_is_overwritten(self, folder):
        """--save over a device file is refused, and so is another suffix."""
        before = (folder / "imu.yaml").read_bytes()
        for name, said in (("imu.yaml", "ends in .json"), ("x.txt", "ends in .json")):
            run = call("check", "--save", name, "imu.yaml")
            assert (run.code, said in run.err) == (2, True)
        assert (folder / "imu.yaml").read_bytes() == before
        shutil.copy("imu.yaml", "imu.json")
        run = call("check", "--save", "imu.json", "imu.json")
        assert (run.code, "would be overwritten" in run.err) == (2, True)

    def test_no_path_that_holds_nowhere_else(self, folder):
        """A device in another tree than the reference is refused."""
        with pytest.raises(ReferenceFileError, match="no folder in common"):
            take("device", folder / "imu.yaml", Path("/elsewhere/references"))

    def test_a_shadowed_name(self, folder):
        """A file that is named like a shipped one is stored by its path."""
        (folder / "zhao-2019").write_text(DEVICE)
        assert call("check", "--save", "s.json", "zhao-2019").code == 0
        assert stored(folder / "s.json").inputs[0].file == "./zhao-2019"
        assert call("check", "s.json").code == 0
