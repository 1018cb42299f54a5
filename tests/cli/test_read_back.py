"""What is written can be read: else nothing is written, and the reason is said."""

from __future__ import annotations

import pytest
from command_line import call

DEVICE = "name: One\ngyro: {errors: {bias_repeatability: 0.1 deg/h}}\n"
REQUIREMENT = "name: r\nlimits: {{gyro: {{bias: {} deg/h}}}}\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder with a device."""
    (tmp_path / "one.yaml").write_text(DEVICE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["C:x.yaml", "a b.yaml", "x#1.yaml", "µ.yaml"])
def test_a_reference_of_an_odd_name_is_stored_and_checked(name, folder):
    """The name is one of a file here, whatever it means elsewhere."""
    (folder / name).write_text(DEVICE, encoding="utf-8")
    call("check", name, "--save", "ref.json", code=0)
    call("check", "ref.json", code=0)


def test_a_path_that_no_reference_may_hold_is_refused_where_it_is_saved(folder):
    """More than 400 characters: exit code 2, and no file."""
    deep = folder
    for _ in range(5):
        deep /= "d" * 100
        deep.mkdir()
    (deep / "one.yaml").write_text(DEVICE, encoding="utf-8")
    run = call("check", deep / "one.yaml", "--save", "ref.json", code=2)
    assert "nothing was written" in run.err
    assert not (folder / "ref.json").exists()


def test_a_tab_in_a_path_is_refused_where_it_is_saved(folder):
    """A reference holds no control character."""
    (folder / "a\tb.yaml").write_text(DEVICE, encoding="utf-8")
    run = call("check", "a\tb.yaml", "--save", "ref.json", code=2)
    assert "nothing was written" in run.err
    assert not (folder / "ref.json").exists()


@pytest.mark.parametrize("limit", ["3e-25", "1e-9", "1"])
def test_an_allocated_device_can_be_read_or_is_not_written(limit, folder):
    """A line below what a file may say is refused where it would be written."""
    (folder / "r.yaml").write_text(REQUIREMENT.format(limit), encoding="utf-8")
    how = ("--requirement", "r.yaml", "--no-validate", "--write", "new.yaml")
    run = call("allocate", "one.yaml", *how)
    if run.code == 2:
        assert "nothing was written" in run.err
        assert not (folder / "new.yaml").exists()
    else:
        assert call("validate", "new.yaml").code == 0
    assert (run.code == 2) == (limit == "3e-25"), run
