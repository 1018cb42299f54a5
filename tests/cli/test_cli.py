"""The command line: what stands on which stream, exit codes, help, bad calls."""

from __future__ import annotations

import csv
import errno
import io
import json
import os
import re
import signal
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest
from command_line import call, start
from places import PACKAGE, put
from reading import assert_says
from typer.main import get_command

from budget.cli import app
from budget.resources import shipped
from budget.version import __version__

NOTE = "No device given: using the built-in zhao-2019 (Zhao 2019).\n"
COMMANDS = (
    *("analyze", "report", "compare", "allocate", "devices", "paper"),
    *("station", "export", "validate", "schema"),
)
SHARED = (
    *("--procedure", "--method", "--trials", "--max-trials", "--digits", "--seed"),
    *("--workers", "--coverage", "--interval", "--reference", "--no-validate"),
    *("--sobol", "--samples"),
)
BAD_VALUES = [
    ("--method", "linear", "'gum', 'monte-carlo', 'simulation'"),
    ("--trials", "0", "2 or more"),
    ("--trials", "1.5e0", "2 or more"),
    ("--trials", "-5", "2 or more"),
    ("--max-trials", "1", "2"),
    ("--samples", "1", "2"),
    ("--digits", "3", "2"),
    ("--digits", "0", "1"),
    ("--seed", "-1", "0"),
    ("--seed", "now", "integer"),
    ("--workers", "0", "1"),
    ("--coverage", "95", "from 1e-6 to 1 - 1e-12"),
    ("--coverage", "0", "from 1e-6 to 1 - 1e-12"),
    ("--coverage", "100 %", "from 1e-6 to 1 - 1e-12"),
    ("--coverage", "nan", "from 1e-6 to 1 - 1e-12"),
    ("--coverage", "95 % or so", "from 1e-6 to 1 - 1e-12"),
    ("--interval", "widest", "'symmetric', 'shortest'"),
    ("--reference", "as tested", "'nominal', 'as_tested', 'next_turn_on'"),
    ("--only", "gyro.drift", "no source"),
    ("--procedure", "absent.yaml", "no such file"),
]


@pytest.mark.smoke
def test_version_is_that_of_the_package(tmp_path):
    """`--version` prints the name and version alone."""
    run = start("--version", cwd=tmp_path)

    assert (run.code, run.out, run.err) == (0, f"budget {__version__}\n", "")


def test_help_names_every_command():
    """`--help` lists each command with what it is for."""
    run = call("--help")

    assert (run.code, run.err) == (0, "")
    listed = {
        words[0]: words[1:] for line in run.out.splitlines() if (words := line.split())
    }
    for command in COMMANDS:
        assert listed[command], command


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("analyze", (*SHARED, "--only", "--json", "--csv")),
        ("report", (*SHARED, "--requirement", "--output")),
        ("validate", ("FILE",)),
        ("schema", ("KIND", "requirement")),
    ],
)
def test_help_of_a_command_names_its_options(command, options):
    """Every option of a command stands in its help, on stdout, exit 0."""
    run = call(command, "--help")

    assert (run.code, run.err) == (0, "")
    for option in options:
        assert option in run.out


def test_no_command_shows_the_help():
    """`budget` alone is a bad call that tells what could be called."""
    run = call(code=2)

    assert "analyze" in run.out + run.err


def test_unknown_command_is_refused():
    """A command that there is not is named, exit 2."""
    run = call("analyse")

    assert (run.code, run.out) == (2, "")
    assert "analyse" in run.err


def test_built_in_device_is_said_on_stderr():
    """Without a device the note stands on stderr, the table on stdout."""
    run = call("analyze", "--no-validate")

    assert (run.code, run.err) == (0, NOTE)
    assert run.out.startswith("Zhao 2019 optical IMU\n")
    assert "No device given" not in run.out


def test_named_device_needs_no_note():
    """With a device named there is nothing to say on stderr."""
    run = call("analyze", "zhao-2019", "--no-validate")

    assert (run.code, run.err) == (0, "")


@pytest.mark.slow
@pytest.mark.smoke
def test_json_on_stdout_stands_alone(tmp_path):
    """`--json -` puts one JSON document on stdout and nothing else."""
    run = start("analyze", "--no-validate", "--json", "-", cwd=tmp_path)

    assert (run.code, run.err) == (0, NOTE)
    assert run.document["schema"] == "budget/1"
    assert len(run.document["outputs"]) == 24
    assert list(tmp_path.iterdir()) == []


def test_csv_on_stdout_stands_alone():
    """`--csv -` puts the head line and rows of one width on stdout, nothing else."""
    run = call("analyze", "--no-validate", "--csv", "-")

    assert (run.code, run.err) == (0, NOTE)
    rows = list(csv.reader(io.StringIO(run.out)))
    assert rows[0][0] == "sensor"
    assert {len(row) for row in rows} == {len(rows[0])}


def test_two_documents_on_one_stdout_are_refused():
    """`--json - --csv -` is exit 2 before anything is computed or printed."""
    run = call("analyze", "--json", "-", "--csv", "-")

    assert (run.code, run.out) == (2, "")
    assert "--json -" in run.err
    assert "--csv -" in run.err


def test_one_document_to_stdout_and_one_to_a_file(tmp_path):
    """`--json - --csv FILE` keeps stdout for JSON and writes the file."""
    file = tmp_path / "rows.csv"
    run = call("analyze", "--no-validate", "--json", "-", "--csv", file, code=0)

    assert run.document["command"] == "analyze"
    assert file.read_text(encoding="utf-8").startswith("sensor,parameter,axis,unit,")


def test_files_beside_the_table(tmp_path):
    """With both documents in files the table still stands on stdout."""
    names = {"json": tmp_path / "a.json", "csv": tmp_path / "a.csv"}
    run = call(
        *("analyze", "--no-validate", "--json", names["json"], "--csv", names["csv"]),
        code=0,
    )

    assert "Gyro" in run.out
    assert json.loads(names["json"].read_text(encoding="utf-8"))["outputs"]
    assert sorted(tmp_path.iterdir()) == sorted(names.values())


@pytest.mark.slow
@pytest.mark.smoke
def test_same_call_gives_the_same_bytes(tmp_path):
    """Seed alike, files are bit for bit alike, in whatever folder, on two workers."""
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder, workers, name in zip(folders, ("1", "2"), ("a", "b"), strict=True):
        folder.mkdir()
        run = start(
            *("analyze", "--method", "monte-carlo", "--trials", "20000"),
            *("--seed", "7", "--workers", workers),
            *("--json", f"{name}.json", "--csv", f"{name}.csv"),
            cwd=folder,
            SOURCE_DATE_EPOCH="0",
        )
        assert run.code == 0, run.err

    for suffix in ("json", "csv"):
        one, two = (
            (folder / f"{name}.{suffix}").read_bytes()
            for folder, name in zip(folders, "ab", strict=True)
        )
        assert one == two


@pytest.mark.parametrize(("option", "value", "said"), BAD_VALUES)
def test_bad_values_are_refused(tmp_path, option, value, said):
    """A bad value is exit 2 with a message, no traceback, no output file."""
    file = tmp_path / "out.json"
    run = call("analyze", "--no-validate", option, value, "--json", file)

    assert (run.code, run.out) == (2, "")
    assert said in run.err
    assert "Traceback" not in run.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.smoke
def test_bad_input_shows_no_traceback(tmp_path):
    """Seen from outside, a faulty file is exit 2 and one line with its position."""
    (tmp_path / "bad.yaml").write_text("gyro: {errors: {bias_stability: 0.04}}\n")
    run = start("analyze", "bad.yaml", "--json", "out.json", cwd=tmp_path)

    assert (run.code, run.out) == (2, "")
    assert run.err.startswith("bad.yaml:1:")
    assert "gyro.errors.bias_stability" in run.err
    assert "Traceback" not in run.err
    assert [path.name for path in tmp_path.iterdir()] == ["bad.yaml"]


def test_unknown_option_is_named():
    """An option that there is not is named, exit 2."""
    run = call("analyze", "--no-such-option")

    assert (run.code, run.out) == (2, "")
    assert "--no-such-option" in run.err


@pytest.mark.parametrize(
    "words",
    [
        ("compare", "zhao-2019", "--requirement", "a", "--requirement=b"),
        ("mission", "zhao-2019", "--mission", "bench", "--seed", "1", "--mission", "x"),
        ("analyze", "zhao-2019", "--seed", "1", "--seed", "1"),
    ],
)
def test_one_value_is_not_two(words):
    """An option that is given twice is refused: which of them counts, nobody sees."""
    run = call(*words)

    assert (run.code, run.out) == (2, "")
    twice = {"compare": "--requirement", "mission": "--mission", "analyze": "--seed"}
    assert f"{twice[words[0]]} given more than once" in run.err


def test_what_may_be_said_again_may_be(tmp_path):
    """Options that take several values, flags, and values that look like options."""
    path = tmp_path / "--seed"
    run = call(
        *("mission", "zhao-2019", "--mission", "bench", "--at", "10 s", "--at", "60 s"),
        *("--no-validate", "--seed", "3", "--json", path),
        code=0,
    )

    assert "after 1 min" in run.out.lower()


@pytest.mark.parametrize("option", ["--json", "--csv"])
def test_output_path_that_cannot_be_written(tmp_path, option):
    """A missing folder is exit 2, said with its name, and nothing is printed."""
    file = tmp_path / "absent" / "out"
    run = call("analyze", "--no-validate", option, file)

    assert (run.code, run.out) == (2, "")
    assert str(file) in run.err
    assert "does not exist" in run.err
    assert list(tmp_path.iterdir()) == []


def test_one_path_that_cannot_be_written_stops_all(tmp_path):
    """If one of two files cannot be written, the other one is not either."""
    good, bad = tmp_path / "good.json", tmp_path / "absent" / "out.csv"
    call("analyze", "--no-validate", "--json", good, "--csv", bad, code=2)

    assert list(tmp_path.iterdir()) == []


def test_failure_leaves_an_older_file_as_it_was(tmp_path):
    """A call that fails does not touch the file of the call before."""
    file = put(tmp_path / "out.json", "from before")

    assert call("analyze", "absent.yaml", "--json", file).code == 2
    assert file.read_text(encoding="utf-8") == "from before"


def test_interrupt_writes_nothing(tmp_path):
    """Stopped by the user: exit 130, no traceback, nothing on stdout, no file."""
    run = subprocess.Popen(
        [
            *(sys.executable, "-m", "budget", "analyze", "--method", "monte-carlo"),
            *("--trials", "100000000", "--json", "out.json"),
        ],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    note = run.stderr.readline()  # the command is at work now
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=600)

    assert note == NOTE
    assert (run.returncode, out) == (130, "")
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_a_file_name_gives_the_terminal_no_orders(tmp_path):
    """Control characters and changes of direction in a name are shown as escapes."""
    run = call("analyze", tmp_path / "a\x1b[2J\u202eb.yaml", code=2)

    assert "a\\x1b[2J\\u202eb.yaml" in run.err
    assert "\x1b" not in run.err


def device_file(folder, name="e.yaml"):
    """Write a small device."""
    return put(
        folder / name, "name: e\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n"
    )


def test_no_command_overwrites_what_it_reads(tmp_path, monkeypatch):
    """Not a device, not one whose name has a hash sign, not what a reference reads."""
    monkeypatch.chdir(tmp_path)
    limits = put(tmp_path / "limits.yaml", "name: l\nlimits: {gyro: {bias: 5 deg/h}}\n")
    inputs = [device_file(tmp_path), device_file(tmp_path, "x#1.yaml"), limits]
    assert call("check", "e.yaml", "--save", "ref.json").code == 0
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    allocate = ("allocate", "x#1.yaml", "--requirement", "limits.yaml")
    for words in (
        ("devices", "e.yaml", "--json", "e.yaml"),
        (*allocate, "--no-validate", "--write", "x#1.yaml"),
        (*allocate, "--no-validate", "--json", "limits.yaml"),
        ("check", "ref.json", "--json", "e.yaml"),
        ("check", "ref.json", "--json", "ref.json"),
        ("diff", "ref.json", "e.yaml", "--csv", "e.yaml"),
    ):
        run = call(*words)
        assert (run.code, run.out) == (2, ""), words
        assert "would be overwritten" in run.err, words
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    assert len(before) == len(inputs) + 1


def test_an_interrupted_run_says_what_it_wrote(tmp_path, monkeypatch):
    """Stopped between two renames both files stand, and both are named."""
    whole = Path.replace

    def replace(self, target):
        whole(self, target)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(Path, "replace", replace)
    names = [tmp_path / "a.json", tmp_path / "a.csv"]
    run = call(
        "analyze", "--no-validate", "--json", names[0], "--csv", names[1], code=130
    )

    assert f"interrupted; written before: {names[0]}, {names[1]}\n" in run.err
    assert sorted(tmp_path.iterdir()) == sorted(names)


HOSTILE = "a\x1b[2J\u202e\u200eb\x9b"
SHOWN = "a\\x1b[2J\\u202e\\u200eb\\x9b"


def test_no_printed_name_gives_the_terminal_orders(tmp_path, monkeypatch):
    """In tables, results and talk, of every command, names are shown as escapes."""
    monkeypatch.chdir(tmp_path)
    device = device_file(tmp_path, f"{HOSTILE}.yaml").name
    limits = ("--requirement", f"{HOSTILE}l.yaml")
    text = "name: l\nlimits: {gyro: {bias: 5 deg/h}}\n"
    (tmp_path / limits[1]).write_text(text)
    for words in (
        ("validate", device),
        ("devices", device),
        ("check", device_file(tmp_path).name, "--save", f"{HOSTILE}.json"),
        ("check", f"{HOSTILE}.json"),
        ("diff", f"{HOSTILE}.json", "zhao-2019"),
        ("compare", device, *limits, "--method", "gum", "-o", f"{HOSTILE}.html"),
        ("allocate", device, *limits, "--no-validate", "--write", f"{HOSTILE}w.yml"),
        ("report", device, "--no-validate", "-o", f"{HOSTILE}r.html"),
    ):
        run = call(*words)
        said = run.out + run.err
        # A file is not written whose name of a requirement no reader would take.
        assert run.code in {0, 1} or "could not be read back" in said, said
        assert SHOWN[:4] in said.replace("\n", ""), words
        assert not set("\x1b\u202e\u200e\x9b") & set(said), words


def test_a_name_does_not_end_its_line(tmp_path, monkeypatch):
    """What looks like a second file in a name is no line of its own."""
    monkeypatch.chdir(tmp_path)
    run = call("validate", device_file(tmp_path, "a\nb: device, valid.yaml").name)

    assert run.out.splitlines()[0] == "a\\nb: device, valid.yaml: device, valid"


def test_names_are_printed_in_one_place_only():
    """No command writes past the functions that escape; documents alone do."""
    folder = PACKAGE / "cli"
    past = re.compile(r"typer\.echo|\bConsole\(|stderr\.write|(?<![.\w])print\(")
    found = {
        path.name
        for path in folder.glob("*.py")
        if past.search(path.read_text(encoding="utf-8"))
    }
    # A schema is our own text, and the bar of progress names no file.
    assert found == {"streams.py", "check.py", "computing.py"}


@pytest.fixture
def faulty(monkeypatch):
    """Put a fault into the program: what `devices` loads."""

    def load():
        return {}["first\nsecond\x1b[2J"]

    monkeypatch.setattr("budget.inputs.load_catalogue", load)


@pytest.mark.usefixtures("faulty")
def test_a_fault_of_the_program_is_one_line_and_exit_70():
    """Not exit 1, which means that a requirement is not met, and no traceback."""
    run = call("devices")

    assert (run.code, run.out) == (70, "")
    (line,) = run.err.splitlines()
    assert re.match(r"internal error: KeyError in \w+\.py:\d+: ", line)
    assert "report this line" in line
    assert "\x1b" not in line


@pytest.mark.usefixtures("faulty")
def test_a_variable_adds_where_a_fault_arose(monkeypatch):
    """BUDGET_TRACEBACK=1 puts the traceback before the line."""
    monkeypatch.setenv("BUDGET_TRACEBACK", "1")
    run = call("devices", code=70)

    assert run.err.startswith("Traceback")
    assert run.err.splitlines()[-1].startswith("internal error: ")


def test_a_pipe_that_breaks_inside_is_told(monkeypatch):
    """A broken pipe that is no reader of stdout is exit 2 and words, not exit 1."""

    def load():
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")

    monkeypatch.setattr("budget.inputs.load_catalogue", load)
    run = call("devices")

    assert (run.code, run.out) == (2, "")
    assert_says(run.err, "pipe", "process", "broke")


def test_too_many_open_files_are_not_blamed_on_a_stream(monkeypatch):
    """The words name the limit, not standard output, which nobody touched."""

    def load():
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr("budget.inputs.load_catalogue", load)
    run = call("devices")

    assert (run.code, run.out) == (2, "")
    assert_says(run.err, "Too many open files")
    assert "standard output" not in run.err
    assert "ulimit" in run.err


def test_more_workers_than_processors_are_cut_with_a_word(monkeypatch):
    """As many processes as processors, said on stderr; the numbers are the same."""
    monkeypatch.setattr("budget.cli.options.processors", lambda: 1)
    asked = ("analyze", "--method", "monte-carlo", "--trials", "5000", "--json", "-")
    cut = call(*asked, "--workers", "5000", code=0)
    assert_says(cut.err, "--workers 5000", "1 processor")
    one = call(*asked, "--workers", "1")
    assert "--workers" not in one.err
    assert cut.out == one.out


def test_help_has_a_short_name_and_whole_summaries():
    """-h is --help, of commands too; no summary ends in three dots."""
    assert call("-h").out == call("--help").out
    assert call("analyze", "-h").out == call("analyze", "--help").out
    assert "..." not in call("-h").out.partition("Commands:")[2]
    listed = " ".join(call("-h").out.split())
    for command in app.registered_commands:
        summary = command.callback.__doc__.partition("\n\n")[0]
        assert " ".join(summary.split()) in listed


@pytest.mark.parametrize(
    ("text", "number"), [("1e3", 1000), ("2.5e3", 2500), ("0300", 300), ("1e+3", 1000)]
)
def test_a_number_of_trials_in_powers_of_ten(text, number):
    """1e3 is 1000, of every option that takes trials."""
    how = ("--method", "monte-carlo", "--json", "-")
    found = call("analyze", *how, "--trials", text, "--max-trials", "1e8").document
    assert found["settings"]["trials"] == number
    wanted = ("compare", "zhao-2019", "--requirement", "navigation-grade", *how)
    found = call(*wanted, "--trials", text, "--max-trials", "1e4").document
    assert {one["trials"] for one in found["devices"]} <= {number, 4 * number, 10_000}


@pytest.mark.parametrize(
    "text", ["1e-3", "1.5", "1e99", "1e999999999", "1", "nan", "-5", "1.2.3", "1e", ""]
)
@pytest.mark.parametrize("option", ["--trials", "--max-trials"])
@pytest.mark.parametrize("name", ["analyze", "compare"])
def test_what_is_no_number_of_trials_is_refused(name, option, text):
    """A fraction, too many, too few, or no number: said with what is allowed."""
    found = call(name, f"{option}={text}")
    assert (found.code, found.out) == (2, "")
    assert_says(found.err, option, "1e6")


def test_a_shell_completes_what_ships_and_what_is_there(tmp_path, monkeypatch):
    """Commands, shipped devices by name, files and folders; other files are none."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hg-mine.yaml").touch()
    (tmp_path / "hg.txt").touch()
    (tmp_path / "hgs").mkdir()
    (tmp_path / "hgs" / "own.yml").touch()

    def completed(*words):
        found = call(
            _BUDGET_COMPLETE="complete_bash",
            COMP_WORDS=" ".join(("budget", *words)),
            COMP_CWORD=str(len(words)),
        )
        return found.out.split()

    assert completed("comp") == ["compare"]
    ours = ["hg-mine.yaml", "hg1700", "hg4930", "hg9900", "hgs/"]
    for name in ("analyze", "compare", "devices"):
        assert completed(name, "hg") == ours
    assert completed("analyze", "hgs/o") == ["hgs/own.yml"]
    assert completed("analyze", "no/") == []


def test_a_device_may_stand_on_standard_input(tmp_path, monkeypatch):
    """The same numbers as of the file, once or twice named, and a variant of it."""
    text = (shipped("specs") / "devices" / "hg4930.yaml").read_bytes()

    def piped(*words):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text)))
        return call(*words)

    how = ("--no-validate", "--csv", "-")
    assert (
        piped("analyze", *how, "--", "-#A").out == call("analyze", "hg4930#A", *how).out
    )
    found = piped("analyze", "--no-validate", "--json", "-", "--", "-#A").document
    assert found["inputs"]["device"] == {
        "name": "standard input#A",
        "sha256": sha256(text).hexdigest(),
    }
    rest = ("--requirement", "catalogue-edge", "--method", "gum", "--json", "-")
    names = [one["name"] for one in piped("compare", "-", *rest).document["devices"]]
    both = call("compare", "hg4930", *rest).document["devices"]
    assert names == [one["name"] for one in both]
    monkeypatch.chdir(tmp_path)
    refused = piped("check", "--save", "a.json", "--", "-#A")
    assert refused.code == 2
    assert_says(refused.err, "standard input", "a file that stays")
    assert not (tmp_path / "a.json").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"", "the file is empty"),
        (b"\xff", "not UTF-8"),
        (b"{gyro: {errrs: {}}}", "did you mean 'errors'"),
        (b"#" * 70_000, "is larger than"),
    ],
)
def test_bad_standard_input_is_refused_in_place(text, said, monkeypatch):
    """As a file is, under the name 'standard input'."""
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text)))
    found = call("analyze", "-")
    assert (found.code, found.out) == (2, "")
    assert said in found.err
    assert found.err.startswith("standard input:1:")
    monkeypatch.setattr(sys, "stdin", None)
    assert_says(call("analyze", "-").err, "standard input", "is closed")


def test_every_word_of_a_fixed_list_may_stand_in_capitals():
    """Options with a list of words, of every command."""
    lists = [
        (name, option)
        for name, command in get_command(app).commands.items()
        for option in command.params
        if hasattr(option.type, "choices")
    ]
    assert len(lists) > 20
    for name, option in lists:
        assert not option.type.case_sensitive, (name, option.name)
    assert call("schema", "DEVICE").out == call("schema", "device").out


def test_an_argument_that_is_no_name_is_not_repeated():
    """One of 100,000 characters is shortened, whichever option it is of."""
    long = "a" * 100_000
    for words in (["analyze", long], ["export", "--to", long], ["--set", long]):
        run = call(*words, code=2)
        assert "has 100000 characters" in run.err
        assert len(run.err) < 300


def test_what_is_wrong_with_an_option_is_in_words_of_our_own():
    """Nothing of the library that reads them."""
    for words in (
        ["schema", "x"],
        ["analyze", "--seed", "x"],
        ["check", "--seed", "-1"],
    ):
        run = call(*words, code=2)
        assert not re.search("value error|input should|parse", run.err, re.IGNORECASE)
