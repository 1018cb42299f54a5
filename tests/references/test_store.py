"""The file of a reference: what it keeps, what it refuses, that it is read for ever."""

from __future__ import annotations

import json
from dataclasses import replace
from hashlib import sha256

import jsonschema
import numpy as np
import pytest
from command_line import analyze, call
from places import TESTS
from reading import assert_says
from reference_examples import DEVICE, computing_once, copied, store, stored

from budget.errors import ReferenceFileError
from budget.references.files import shipped_references, stored_documents
from budget.references.jobs import compute
from budget.references.records import Stored
from budget.references.store import (
    MOST_BYTES,
    NEWEST,
    read_reference,
    reference_schema,
    reference_text,
)

# Written by the first version that could. NEVER store it again: it proves that a later
# reader still reads what the first one wrote. A new format gets a file of its own.
FIRST = TESTS / "data" / "reference-1.json"
# That the schema is one is asked of it once.
JUDGE = jsonschema.Draft202012Validator(reference_schema())
FIRST_SHA256 = "7676d2b7ba7d97741a6c1f2247f81fd572dd61ae0589c5f6898d63ba9c03d3e2"


computed_once = pytest.fixture(scope="module", autouse=True)(computing_once)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Provide a reference beside its device, for all to copy."""
    return store(tmp_path_factory.mktemp("made"))


@pytest.fixture
def path(tmp_path, made):
    """Provide a reference beside its device."""
    return copied(made, tmp_path)


def signed(content):
    """Return the text of a content with the checksum that belongs to it."""
    rest = {key: value for key, value in content.items() if key != "checksum"}
    canonical = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return json.dumps(rest | {"checksum": sha256(canonical.encode()).hexdigest()})


def refused(path, text):
    """Return what is said of a file with that content."""
    data = text if isinstance(text, bytes) else text.encode()
    path.write_bytes(data)
    with pytest.raises(ReferenceFileError) as caught:
        read_reference(path, path.name)
    return str(caught.value)


class TestFirstVersion:
    """The stored file of format 1."""

    def test_it_is_the_first_one(self):
        """The file is the one that was written then, byte for byte."""
        assert sha256(FIRST.read_bytes()).hexdigest() == FIRST_SHA256

    def test_it_is_read(self):
        """Inputs, settings, numbers with their uncertainties, words: all are there."""
        first = stored(FIRST)

        assert (first.job, first.settings.method) == ("analyze", "monte-carlo")
        assert (first.settings.trials, first.settings.samples, first.settings.seed) == (
            *(2000, 64, 5),
        )
        assert [one.role for one in first.inputs] == [
            *("device", "procedure", "requirement"),
        ]
        numbers = first.by_item
        assert (len(first.numbers), len(numbers)) == (355, 357)  # and two words
        (u,) = (
            number
            for key, number in numbers.items()
            if (key.subject, key.quantity) == ("gyro.bias.x", "standard_uncertainty")
        )
        assert 0.07 < u.value < 0.08
        assert 0.001 < u.standard_error < 0.002
        assert [w.text for w in first.words if w.item.quantity == "verdict"] == [
            "meets"
        ]
        assert dict(first.versions)["budget"] == "0.1.0"

    def test_its_content_can_be_computed_with(self):
        """The stored texts are sound files, and give the quantities stored then."""
        first = stored(FIRST)
        parts = stored_documents(first.inputs, reference="first", job=first.job)
        again = compute(first.job, parts, first.settings)

        assert set(first.by_item) <= set(again.by_item)

    def test_the_schema_passes_it(self):
        """What was valid by the schema stays so."""
        JUDGE.validate(json.loads(FIRST.read_bytes()))


class TestText:
    """What is written."""

    def test_read_back(self, path):
        """A reference read back is the one that was written, number for number."""
        reference = stored(path)
        assert reference_text(reference) == path.read_text(encoding="utf-8")
        path.write_text(reference_text(reference), encoding="utf-8")
        assert stored(path) == reference

    def test_the_same_bytes(self, tmp_path):
        """Stored twice, and in two folders, it has the same bytes."""
        for name in ("a", "b"):
            (tmp_path / name).mkdir()
        one, other = (store(tmp_path / name) for name in ("a", "b"))
        assert one.read_bytes() == other.read_bytes()

    def test_one_number_a_line(self, path):
        """A change of one number is a change of one line."""
        lines = path.read_text(encoding="utf-8").splitlines()
        reference = stored(path)
        assert sum('"quantity"' in line for line in lines) == len(
            (*reference.numbers, *reference.words)
        )

    def test_it_names_no_place_and_no_time(self, path, tmp_path):
        """No absolute path, no host, no date: inputs stand by their path from here."""
        text = path.read_text(encoding="utf-8")
        assert str(tmp_path) not in text
        assert [one.file for one in stored(path).inputs] == ["imu.yaml", "zhao-2019"]
        assert set(json.loads(text)) == {
            *("checksum", "format", "inputs", "job", "known", "numbers"),
            *("settings", "versions", "words"),
        }

    @pytest.mark.parametrize("text", [DEVICE.replace("\n", "\r\n"), "\ufeff" + DEVICE])
    def test_odd_line_ends_are_kept(self, tmp_path, text):
        """Windows line ends and a byte order mark are kept, byte for byte."""
        (tmp_path / "imu.yaml").write_bytes(text.encode())
        outcome = call(
            *("check", "--save", tmp_path / "r.json", tmp_path / "imu.yaml"),
        )
        assert outcome.code == 0, outcome.err
        assert stored(tmp_path / "r.json").inputs[0].text == text
        assert call("check", tmp_path / "r.json").code == 0

    def test_no_infinite_number_is_written(self, path):
        """JSON has none."""
        reference = stored(path)
        first, *rest = reference.numbers
        broken = (replace(first, value=float("inf")), *rest)
        with pytest.raises(ValueError, match="JSON compliant"):
            reference_text(replace(reference, numbers=broken))

    def test_lower_bounds_are_stored(self, path):
        """Of the same outputs that analyze calls lower bounds, and of no others."""
        said = analyze(path.with_name("imu.yaml"))
        wanted = {
            f"{one['sensor']}.{one['parameter']}.{one['axis']}"
            for one in said["outputs"]
            if one["lower_bound"]
        }
        found = {
            one.subject
            for one in stored(path).numbers
            if one.lower_bound and one.quantity == "standard_uncertainty"
        }
        assert 0 < len(wanted) < len(said["outputs"])
        assert found == wanted
        assert '"lower_bound": false' not in path.read_text(encoding="utf-8")

    def test_what_is_not_given_is_absent(self, path):
        """No null stands in a file."""
        assert "null" not in path.read_text(encoding="utf-8")


class TestSchema:
    """The published schema."""

    def test_it_is_sound(self):
        """A schema of draft 2020-12, printed by `budget schema reference`."""
        schema = call("schema", "reference").document
        assert schema == reference_schema()
        jsonschema.Draft202012Validator.check_schema(schema)

    @pytest.mark.parametrize("one", shipped_references(), ids=lambda one: one.shown)
    def test_shipped_references_pass(self, one):
        """Every shipped reference is valid by the schema."""
        JUDGE.validate(json.loads(one.path.read_bytes()))

    def test_it_can_fail(self, path):
        """Control: a number that is a text is marked."""
        content = json.loads(path.read_bytes())
        content["numbers"][0]["value"] = "1"
        with pytest.raises(jsonschema.ValidationError):
            JUDGE.validate(content)


class TestRefused:
    """What is no reference, or one no longer."""

    def test_edited_by_hand(self, path):
        """A digit changed by hand is seen, and what to do is said."""
        text = path.read_text(encoding="utf-8")
        said = refused(path, text.replace('"value": 0.0', '"value": 0.5', 1))
        assert said.startswith("ref.json: ")
        assert_says(said, "checksum differs", "`budget check --save`", "by hand")
        assert_says(said, "restore it from version control", "save it again")

    @pytest.mark.parametrize("part", [0.2, 0.9, 0.9999])
    def test_cut_short(self, path, part):
        """Wherever it ends too early, the place and what to do are said."""
        text = path.read_text(encoding="utf-8")
        said = refused(path, text[: int(part * len(text))])
        assert said.startswith("ref.json:")
        assert "cut short" in said or "no JSON here" in said
        assert_says(said, "restore it from version control", "save it again")

    def test_newer(self, path):
        """A later format says which version it needs."""
        content = json.loads(path.read_bytes()) | {"format": "budget-reference/7"}
        said = refused(path, signed(content))
        assert_says(said, "'budget-reference/7'", "budget >= 7", "update it")
        assert NEWEST == 1

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"format": "budget-device/1"}, "expected 'budget-reference/1'"),
            ({"format": 1}, "expected 'budget-reference/1'"),
            ({"job": "paint"}, "job: found 'paint', expected 'analyze'"),
            ({"numbers": 3}, "numbers: found 3, expected a list in brackets"),
            ({"numbers": [{"value": 1.0}]}, "numbers.0.subject: 'subject' is missing"),
            ({"surprise": 1}, "surprise: unknown key 'surprise', allowed: job,"),
            ({"inputs": []}, "inputs: found a list, has 0 items, expected 1 or more"),
            ({"settings": {"seed": -1}}, "settings.seed: found -1, expected 0 or more"),
            (
                {"settings": {"method": "guess"}},
                "settings.method: found 'guess', expected 'gum'",
            ),
        ],
    )
    def test_wrong_values(self, path, change, said):
        """A sound checksum over wrong values: which value, and what to do."""
        content = json.loads(path.read_bytes()) | change
        found = refused(path, signed(content))
        assert said in found
        assert found.startswith("ref.json: ")

    def test_stored_text_and_its_hash(self, path):
        """A stored input whose SHA-256 is another one is refused."""
        content = json.loads(path.read_bytes())
        content["inputs"][0]["sha256"] = "0" * 64
        assert "imu.yaml has not the SHA-256" in refused(path, signed(content))

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            ("", "cut short"),
            ("[]", "has no `format` key"),
            ("3", "has no `format` key"),
            ("name: x", "no JSON here"),
            ('{"format": NaN}', "found NaN"),
            ('{"format": ' + "[" * 100_000 + "]" * 100_000 + "}", "nested too deeply"),
            ("[" * 100_000, "nested too deeply"),
            ('{"format": ' + "1" * 10_000 + "}", "no JSON of a reference budget"),
            ('{"format": "\\ud800"}', "no JSON of a reference budget"),
            (b'{"format": "\xff"}', "is not UTF-8"),
            (b"\x00" * 10, "no JSON here"),
        ],
    )
    def test_nonsense(self, path, text, said):
        """Nothing that is no reference makes a traceback."""
        assert said in refused(path, text)

    def test_infinite_numbers(self, path):
        """1e999 is JSON and no number: refused with its place."""
        content = json.loads(path.read_bytes())
        content["numbers"][0]["value"] = float("inf")
        text = signed(content).replace("Infinity", "1e999")
        assert_says(refused(path, text), "numbers.0.value:", "finite number")

    def test_too_large(self, path):
        """A file of more than 8 MiB is refused before it is parsed."""
        said = refused(path, b"[" * (MOST_BYTES + 1))
        assert f"larger than {MOST_BYTES} bytes" in said

    def test_folder_and_nothing(self, tmp_path):
        """A folder, and a name that is no file."""
        for name, said in ((".", "is a folder"), ("no.json", "cannot be read")):
            with pytest.raises(ReferenceFileError, match=said):
                read_reference(tmp_path / name, name)

    @pytest.mark.parametrize("position", range(0, 3000, 97))
    def test_no_flipped_byte_passes(self, path, position):
        """A byte changed anywhere is refused by the reader, or changes only layout."""
        data = bytearray(path.read_bytes())
        place = position * len(data) // 3000
        data[place] ^= 0x15
        before = stored(path)
        path.write_bytes(bytes(data))
        try:
            after = stored(path)
        except ReferenceFileError:
            return
        assert after == before

    def test_a_stored_text_too_large(self, path):
        """A stored input is no larger than an input file may be."""
        content = json.loads(path.read_bytes())
        text = "#" * 70_000
        content["inputs"][0] |= {
            "text": [text],
            "sha256": sha256(text.encode()).hexdigest(),
        }
        assert "is larger than 65536 bytes" in refused(path, signed(content))

    @pytest.mark.parametrize("text", ["", "name: [", "limits: {}", "gyro: {}", "- 1"])
    def test_a_stored_text_that_cannot_be_read(self, path, text):
        """It only explains: the check goes on, and says that nothing explains."""
        content = json.loads(path.read_bytes())
        content["inputs"][0] |= {
            "text": text.split("\n"),
            "sha256": sha256(text.encode()).hexdigest(),
        }
        path.write_text(signed(content), encoding="utf-8")
        run = call("check", path)
        assert run.code == 0
        assert_says(run.out, "stored inputs", "-> not read")
        device = path.with_name("imu.yaml")
        device.write_text(DEVICE.replace("0.05 deg/h", "0.06 deg/h"))
        run = call("check", path)
        assert run.code == 1
        assert_says(run.out, "tool: stored inputs", "-> not read")
        run = call("diff", path, device)
        assert run.code == 2
        assert "stored imu.yaml:1:" in run.err

    @pytest.mark.parametrize("seed", range(60))
    def test_no_junk_makes_a_traceback(self, path, seed):
        """Any value of the file replaced by any other: an error, or a check."""
        rng = np.random.default_rng(seed)
        content = json.loads(path.read_bytes())
        junk = [None, True, -1, 0, 1e300, 10**30, "", "\ud800", "x" * 500, [], {}, [[]]]
        junk += ["../imu.yaml", "/", "\x00", {"value": 1.0}, ["a"], "nan"]
        at = content
        while True:
            keys = list(at) if isinstance(at, dict) else list(range(len(at)))
            key = keys[rng.integers(len(keys))]
            deeper = isinstance(at[key], dict | list) and at[key] and rng.random() < 0.8
            if not deeper:
                at[key] = junk[rng.integers(len(junk))]
                break
            at = at[key]
        path.write_text(signed(content), encoding="utf-8")
        run = call("check", path)
        assert run.code in {0, 1, 2}
        assert run.code != 2 or run.err

    @pytest.mark.parametrize(
        ("job", "keep", "said"),
        [
            ("analyze", [0], "0 of role procedure, a reference of kind analyze has 1"),
            ("analyze", [1], "0 of role device, a reference of kind analyze has 1 or"),
            ("analyze", [0, 1, 1], "2 of role procedure"),
            ("compare", [0, 1], "0 of role requirement, a reference of kind compare"),
            ("allocate", [0, 1], "0 of role requirement"),
        ],
    )
    def test_inputs_that_no_job_has(self, path, job, keep, said):
        """Every file that a job needs is there, and none too many."""
        content = json.loads(path.read_bytes()) | {"job": job}
        content["inputs"] = [content["inputs"][k] for k in keep]
        assert f"inputs: {said}" in refused(path, signed(content))
        for args in (("check", path), ("diff", path, path.with_name("imu.yaml"))):
            run = call(*args)
            assert (run.code, said in run.err) == (2, True)

    @pytest.mark.parametrize("field", ["value", "floor", "standard_error"])
    @pytest.mark.parametrize("number", [1e308, -1e308])
    def test_numbers_that_no_budget_has(self, path, field, number):
        """What is computed of two numbers of a reference cannot overflow."""
        content = json.loads(path.read_bytes())
        content["numbers"][3][field] = number
        assert f"numbers.3.{field}: found {number}, expected " in refused(
            path, signed(content)
        )
        run = call("diff", path, path.with_name("imu.yaml"))
        assert (run.code, run.out) == (2, "")

    @pytest.mark.parametrize("value", [-1e100, 1e-308, 0.0, 1e100])
    def test_the_largest_numbers_are_compared(self, path, value):
        """Whatever numbers are allowed, check and diff print how far they moved."""
        content = json.loads(path.read_bytes())
        for number in content["numbers"]:
            number["value"] = value
        path.write_text(signed(content), encoding="utf-8")
        device = path.with_name("imu.yaml")
        device.write_text(DEVICE.replace("0.05 deg/h", "0.06 deg/h"))
        for args in (("check", path), ("diff", path, device), ("diff", device, path)):
            for more in ((), ("--json", "-"), ("--csv", "-")):
                run = call(*args, *more)
                assert run.code == (1 if args[0] == "check" else 0), run.err
                assert run.out

    @pytest.mark.parametrize("kind", ["numbers", "words"])
    def test_a_number_that_stands_twice(self, path, kind):
        """A result says each number and each word once."""
        content = json.loads(path.read_bytes())
        content[kind].append(content[kind][0])
        assert "stands there 2 times, expected once" in refused(path, signed(content))

    @pytest.mark.parametrize("end", ["", ".yaml"])
    def test_a_file_name_that_can_be_none(self, path, end):
        """A name longer than a file system has is a file that is not there."""
        content = json.loads(path.read_bytes())
        content["inputs"][0]["file"] = "x" * 300 + end
        path.write_text(signed(content), encoding="utf-8")
        run = call("check", path)
        assert run.code == 2
        assert "ref.json: its device xxx" in run.err

    def test_more_points_than_a_scramble_has(self, path):
        """Sobol' points have 30 bits."""
        content = json.loads(path.read_bytes()) | {"settings": {"samples": 2**62}}
        assert "expected 1048576 or less; save" in refused(path, signed(content))

    def test_settings_of_another_kind(self, path):
        """Settings that mean nothing to the job are refused when it is checked."""
        content = json.loads(path.read_bytes()) | {"settings": {"strategy": "equal"}}
        path.write_text(signed(content), encoding="utf-8")
        assert stored(path).settings == Stored(strategy="equal")
        run = call("check", path)
        assert (run.code, "--strategy: means nothing" in run.err) == (2, True)
