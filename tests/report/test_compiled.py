"""Templates that ship are compiled once, and what they were compiled to is kept."""

from __future__ import annotations

import sys

import pytest

from budget import resources
from budget.language import speaking
from budget.report.pages import _environment
from budget.resources import shipped, template_environment


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Let Python keep what it compiles in a folder of the test's own."""
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    return tmp_path


def made(environment, name="letterhead.html.j2"):
    """Return how often a template was compiled for an environment, which prints it."""
    compiled = []
    own = environment.compile
    environment.compile = lambda *words: compiled.append(words) or own(*words)
    environment.get_template(name)
    return len(compiled)


def test_a_template_is_compiled_once(kept, monkeypatch):
    """Again where the program changes, or its options do; never where none is kept."""
    assert [made(template_environment()) for _ in range(2)] == [1, 0]
    assert [made(template_environment(finalize=str)) for _ in range(2)] == [1, 0]
    assert any(kept.rglob("*letterhead*.pyc"))
    monkeypatch.setattr(resources, "_code", lambda: ("another",))
    assert [made(template_environment()) for _ in range(2)] == [1, 0]
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert [made(template_environment(finalize=repr)) for _ in range(2)] == [1, 1]


def test_what_is_spoiled_is_compiled_again(kept):
    """Half a file, and one that holds something else."""
    made(template_environment())
    for content in (b"", b"no bytecode"):
        (file,) = kept.rglob("*letterhead*.pyc")
        file.write_bytes(content)
        assert made(template_environment()) == 1


@pytest.mark.slow
def test_templates_compile_alike_in_every_language():
    """So that what was compiled in one language serves the others."""
    there = _environment()
    texts = {
        path.name: path.read_text(encoding="utf-8")
        for path in shipped("templates", "pages").rglob("*.j2")
    }
    assert texts
    codes = []
    for language in ("en", "zh"):
        with speaking(language):
            codes.append({name: there.compile(text) for name, text in texts.items()})
    assert codes[0] == codes[1]
