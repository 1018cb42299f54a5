"""Another processor: the same verdicts, ranks and printed digits, numbers to 1e-12."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys

import numpy as np
import pytest
from command_line import call, surroundings
from numpy.testing import assert_allclose
from places import TESTS
from threadpoolctl import threadpool_info

pytestmark = pytest.mark.skipif(
    platform.machine() not in {"x86_64", "AMD64"}, reason="kernels of x86-64"
)

OLD = "Prescott"  # SSE3 and no more
CALLS = (
    ("analyze", "--json", "-"),
    ("analyze", "--method", "simulation", "--trials", "5", "--json", "-"),
    (
        *("analyze", "--reference", "next_turn_on", "--method", "monte-carlo"),
        *("--trials", "20000", "--json", "-"),
    ),
    (
        *("compare", "zhao-2019", "hg4930#C", "--requirement", "navigation-grade"),
        *("--method", "gum", "--json", "-"),
    ),
    ("analyze",),
    ("compare", "zhao-2019", "hg4930", "--requirement", "catalogue-edge"),
    ("allocate", "--requirement", "navigation-grade", "--no-validate"),
    ("diff", "zhao-2019", "hg4930#A"),
)
CODE = """
import json, sys
from threadpoolctl import threadpool_info
from command_line import call
import numpy, scipy.linalg
print(json.dumps({
    "kernels": [one["architecture"] for one in threadpool_info()],
    "outs": [call(*words).out for words in json.loads(sys.argv[1])],
}))
"""


@pytest.fixture(scope="module")
def elsewhere():
    """Return the kernels and the outputs of the calls as on an old processor."""
    from numpy._core import _multiarray_umath as core

    features = [one for one in core.__cpu_dispatch__ if core.__cpu_features__.get(one)]
    run = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps(CALLS)],
        capture_output=True,
        text=True,
        check=True,
        env=surroundings()
        | {
            "OPENBLAS_CORETYPE": OLD,
            "OPENBLAS_NUM_THREADS": "1",
            "NPY_DISABLE_CPU_FEATURES": " ".join(features),
            "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F",
            "PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path]),
        },
    )
    found = json.loads(run.stdout.splitlines()[-1])
    here = [one["architecture"] for one in threadpool_info() if "architecture" in one]
    if not found["kernels"] or set(found["kernels"]) & set(here):
        pytest.skip(f"this machine computes with {here}, elsewhere {found['kernels']}")
    return dict(zip(CALLS, found["outs"], strict=True))


def assert_same(here, there, *, where="document"):
    """Assert that two documents agree: words exactly, numbers to 1e-12."""
    assert type(here) is type(there), where
    if isinstance(here, dict):
        assert here.keys() == there.keys(), where
        for key in here:
            assert_same(here[key], there[key], where=f"{where}.{key}")
    elif isinstance(here, list):
        assert len(here) == len(there), where
        for place, (a, b) in enumerate(zip(here, there, strict=True)):
            assert_same(a, b, where=f"{where}[{place}]")
    elif isinstance(here, float):
        assert_allclose(there, here, rtol=1e-12, err_msg=where)
    else:
        assert here == there, where


@pytest.mark.parametrize("words", [c for c in CALLS if "--json" in c], ids=" ".join)
def test_documents_agree(words, elsewhere):
    """Every number of a document is the same to 1e-12, every word exactly.

    A covariance is compared beside its two spreads.
    """
    here, there = call(*words).document, json.loads(elsewhere[words])
    mine, theirs = (np.array(one.pop("covariance", [])) for one in (here, there))
    if mine.size:
        u = np.sqrt(np.diag(mine))
        assert_allclose(
            theirs / np.outer(u, u), mine / np.outer(u, u), rtol=0, atol=1e-12
        )
    assert_same(here, there)


@pytest.mark.parametrize("words", [c for c in CALLS if "--json" not in c], ids=" ".join)
def test_what_is_printed_is_the_same(words, elsewhere):
    """Verdicts, ranks and digits of the terminal are the same characters."""
    assert call(*words).out == elsewhere[words]


def test_the_comparison_can_fail():
    """Control: a number that is off by 2e-12, and a word, are seen."""
    with pytest.raises(AssertionError):
        assert_same({"u": [1.0]}, {"u": [1.0 + 2e-12]})
    with pytest.raises(AssertionError):
        assert_same({"verdict": "meets"}, {"verdict": "fails"})
    assert_same({"u": [1.0]}, {"u": [1.0 + 5e-13]})
