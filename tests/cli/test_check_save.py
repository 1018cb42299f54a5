"""`budget check`: references that cannot be checked, and storing new ones."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from command_line import call
from reference_examples import DEVICE, store, stored

from budget.errors import ReferenceFileError
from budget.references.files import take_in

WORSE = DEVICE.replace("value: 0.04 deg/h", "value: 0.0404 deg/h")
KEY = "gyro.errors.bias_stability"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with a device and its reference, and work there."""
    monkeypatch.chdir(tmp_path)
    store(tmp_path)
    return tmp_path


def rewrite(folder, text):
    """Change the device file."""
    (folder / "imu.yaml").write_text(text, encoding="utf-8")


class TestBad:
    """References that cannot be checked."""

    def test_an_input_gone(self, folder):
        """Exit code 2: which file is not there, and what to do."""
        (folder / "imu.yaml").unlink()
        run = call("check", "ref.json")

        assert run.code == 2
        assert run.err == (
            "ref.json: its device imu.yaml is not there; a reference is computed again "
            "from its files: put the file back, or save the reference again from where "
            "it is now\n"
        )

    def test_an_input_broken(self, folder):
        """A device file that is none any more is told with its place."""
        rewrite(folder, DEVICE.replace("37 ppm", "37 apples"))
        run = call("check", "ref.json")

        assert run.code == 2
        assert "imu.yaml:15:33:" in run.err
        assert "apples" in run.err

    def test_the_others_are_checked_all_the_same(self, folder):
        """One bad reference does not hide what another says; exit code 2."""
        rewrite(folder, WORSE)
        (folder / "bad.json").write_text("{")
        run = call("check", "bad.json", "none.json", "ref.json", "hg4930-c")

        assert run.code == 2
        assert "bad.json:1:2: ends too early" in run.err
        assert "none.json: no such file" in run.err
        assert "ref.json  MOVED" in run.out
        assert "4 references: 1 hold, 1 moved, 2 cannot be checked" in run.out
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

    @pytest.mark.parametrize("kind", ["compare", "allocate"])
    def test_other_kinds(self, folder, kind):
        """A comparison and an allocation are stored, hold, and move with an input."""
        run = call(
            *("check", "--save", "k.json", "imu.yaml", "--kind", kind),
            *("--requirement", "navigation-grade"),
        )
        assert run.code == 0, run.err
        assert call("check", "k.json").code == 0
        rewrite(folder, WORSE)
        moved = call("check", "k.json")
        assert moved.code == 1
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
        run = call("check", "--save", "m.json", "imu.yaml", *args)
        assert run.code == 0, run.err
        assert any(n.is_sampled for n in stored(folder / "m.json").numbers)
        assert call("check", "m.json").code == 0

    def test_a_variant_that_is_new(self, folder):
        """A comparison of a file takes all its variants: a new one is a move."""
        more = DEVICE + "variants:\n  A: {notes: one}\n"
        rewrite(folder, more)
        args = ("--kind", "compare", "--requirement", "navigation-grade")
        assert call("check", "--save", "v.json", "imu.yaml", *args).code == 0
        rewrite(folder, more + "  B: {gyro: {errors: {bias_stability: 1 deg/h}}}\n")
        run = call("check", "v.json")

        assert run.code == 1
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
            take_in("device", folder / "imu.yaml", Path("/elsewhere/references"))

    def test_a_shadowed_name(self, folder):
        """A file that is named like a shipped one is stored by its path."""
        (folder / "zhao-2019").write_text(DEVICE)
        assert call("check", "--save", "s.json", "zhao-2019").code == 0
        assert stored(folder / "s.json").inputs[0].file == "./zhao-2019"
        assert call("check", "s.json").code == 0
