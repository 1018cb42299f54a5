"""Examples in docs/ run as printed and say what they say."""

from __future__ import annotations

import re
from pathlib import Path

from numpy.testing import assert_allclose

DOCS = Path(__file__).parent.parent / "docs"


def test_the_problem_of_ones_own_runs_as_printed(capsys):
    """The example of docs/problems.md gives Table H.4 of JCGM 100:2008."""
    text = (DOCS / "problems.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict[str, object] = {}
    exec(compile(code, "problems.md", "exec"), names)  # noqa: S102 - our own text

    first = capsys.readouterr().out.splitlines()[0]
    u = [float(number) for number in first.strip("[]").split()]
    assert_allclose(u, [0.071, 0.2956, 0.236], rtol=0, atol=1e-3)
    assert_allclose(names["law"].standard_uncertainty, u, rtol=1e-6)


def test_the_library_example_runs_as_printed(capsys):
    """The Python block of docs/results.md runs and gives a verdict for each sensor."""
    text = (DOCS / "results.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(code, "results.md", "exec"), {})  # noqa: S102 - our own text

    out = capsys.readouterr().out
    assert "gyro.bias_repeatability" in out
    assert "('gyro', 'fails'" in out
    assert "('accelerometer', 'fails'" in out
