"""Other processors: the same verdicts, ranks and printed digits, numbers to 1e-12."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from copy import deepcopy
from pathlib import Path
from signal import SIGILL

import numpy as np
import pytest
from command_line import call, surroundings
from numpy.testing import assert_allclose
from places import DOCS, TESTS
from threadpoolctl import threadpool_info

from budget.methods.least_cost import GOOD

pytestmark = pytest.mark.skipif(
    platform.machine() not in {"x86_64", "AMD64"}, reason="kernels of x86-64"
)

# Kernels of the linear algebra library by processor type, with numbers of threads. The
# first, SSE3 and no more, chooses the code of numpy and of the C library too.
PROCESSORS = (("Prescott", 1), ("Haswell", 2), ("SkylakeX", 1))
OLD = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"}
WANTED = str(DOCS / "example" / "requirement.yaml")
LEAST_COST = ("allocate", "--requirement", WANTED, "--strategy", "cost")
COMPARED = (
    *("compare", "zhao-2019", "stim300", "--requirement", WANTED),
    *("--method", "gum"),
)
DOCUMENTS = (
    ("analyze",),
    ("analyze", "--method", "simulation", "--trials", "2"),
    (
        *("analyze", "--reference", "next_turn_on", "--method", "monte-carlo"),
        *("--trials", "20000"),
    ),
    (
        *("compare", "zhao-2019", "hg4930#C", "--requirement", "navigation-grade"),
        *("--method", "gum"),
    ),
    COMPARED,
    ("allocate", "--requirement", WANTED),
    (*LEAST_COST, "--no-validate"),
)
PRINTED = (
    ("analyze",),
    ("compare", "zhao-2019", "hg4930", "--requirement", "catalogue-edge"),
    COMPARED,
    ("allocate", "--requirement", WANTED),
    (*LEAST_COST, "--no-validate"),
    ("diff", "zhao-2019", "hg4930#A"),
)
# One that is asked for both is called once.
CALLS = tuple(dict.fromkeys((*DOCUMENTS, *PRINTED)))
DOCUMENT = "document.json"
# Of the least cost: how far at most an answer is from the optimum, and the solver's own
# words, which decide nothing.
PROOFS, SOLVER = ("residual", "gap"), "solver"
CODE = """
import json
from keeping import once
from budget.studies.allocation import allocate
from house.test_processors import outputs
import numpy, scipy.linalg
# As in the tests here: what four of the calls search for is searched for once.
allocate.find_longer_tests = once(allocate.find_longer_tests, {})
print(json.dumps(outputs()))
"""


def outputs():
    """Return the kernels here, and of every call its document and what it prints."""
    found = []
    for words in CALLS:
        wanted = ("--json", DOCUMENT) * (words in DOCUMENTS)
        printed = call(*words, *wanted).out
        document = Path(DOCUMENT).read_text(encoding="utf-8") if wanted else "null"
        found.append((json.loads(document), printed))
    kernels = [[one["architecture"], one["num_threads"]] for one in threadpool_info()]
    return {"kernels": kernels, "found": found}


@contextmanager
def computing_on(kernel, threads, folder):
    """Start the calls as on another processor; give what waits for their outputs."""
    from numpy._core import _multiarray_umath as core

    features = [one for one in core.__cpu_dispatch__ if core.__cpu_features__.get(one)]
    old = OLD | {"NPY_DISABLE_CPU_FEATURES": " ".join(features)}
    folder.mkdir()
    with subprocess.Popen(
        [sys.executable, "-c", CODE],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        env=surroundings()
        | {
            "OPENBLAS_CORETYPE": kernel,
            "OPENBLAS_NUM_THREADS": str(threads),
            "PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path]),
        }
        | (old if kernel == "Prescott" else {}),
    ) as process:

        def wait():
            out, _ = process.communicate()
            if process.returncode == -SIGILL:  # this processor lacks those kernels
                return None
            assert process.returncode == 0
            found = json.loads(out.splitlines()[-1])
            # The library has names of its own for some kernels.
            assert {number for _, number in found["kernels"]} == {threads}
            return found["found"]

        yield wait


def assert_same(here, there, *, where="document"):
    """Assert that two documents agree: words exactly, numbers to 1e-12."""
    assert type(here) is type(there), where
    if isinstance(here, dict):
        assert here.keys() == there.keys(), where
        for key in here.keys() - {SOLVER}:
            if key in PROOFS:
                assert max(here[key], there[key]) <= GOOD, where
            else:
                assert_same(here[key], there[key], where=f"{where}.{key}")
    elif isinstance(here, list):
        assert len(here) == len(there), where
        for place, (a, b) in enumerate(zip(here, there, strict=True)):
            assert_same(a, b, where=f"{where}[{place}]")
    elif isinstance(here, float):
        # Below 1e-15 of a printed unit a number is the rounding of zero.
        assert_allclose(there, here, rtol=1e-12, atol=1e-15, err_msg=where)
    else:
        assert here == there, where


def assert_same_document(mine, theirs, where):
    """Assert that two agree; a covariance is compared beside its two spreads."""
    own, other = (np.array((one or {}).pop("covariance", [])) for one in (mine, theirs))
    if own.size:
        u = np.sqrt(np.diag(own))
        assert_allclose(
            other / np.outer(u, u), own / np.outer(u, u), rtol=0, atol=1e-12
        )
    assert_same(mine, theirs, where=where)


@pytest.mark.slow
def test_documents_and_what_is_printed_agree(tmp_path, monkeypatch):
    """Numbers of a document to 1e-12, its words and what is printed to the letter.

    The processors compute side by side; one that is like this one would say the same.
    """
    own = {(one["architecture"], one["num_threads"]) for one in threadpool_info()}
    others = [one for one in PROCESSORS if own != {one}]
    monkeypatch.chdir(tmp_path)
    with ExitStack() as stack:
        waiting = {
            one: stack.enter_context(computing_on(*one, tmp_path / one[0]))
            for one in others
        }
        here = outputs()["found"]
        told = {one: wait() for one, wait in waiting.items()}
    elsewhere = {one: found for one, found in told.items() if found is not None}
    assert elsewhere
    for one, theirs in elsewhere.items():
        for words, (mine, printed), (other, there) in zip(
            CALLS, deepcopy(here), theirs, strict=True
        ):
            where = f"{' '.join(words)} on {one}"
            assert_same_document(mine, other, where)
            assert printed == there, where  # verdicts, ranks and digits


def test_the_comparison_can_fail():
    """Control: a number that is off by 2e-12, and a word, are seen."""
    with pytest.raises(AssertionError):
        assert_same({"u": [1.0]}, {"u": [1.0 + 2e-12]})
    with pytest.raises(AssertionError):
        assert_same({"verdict": "meets"}, {"verdict": "fails"})
    assert_same({"u": [1.0]}, {"u": [1.0 + 5e-13]})
