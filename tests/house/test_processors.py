"""Words and printed digits are the same on every type of processor."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from itertools import pairwise

import pytest
from numpy.testing import assert_allclose
from places import DOCS

from budget.methods.least_cost import GOOD

WANTED = DOCS / "example" / "requirement.yaml"
# Kernels of the linear algebra library by processor type, with numbers of threads.
PROCESSORS = (("Nehalem", "1"), ("Haswell", "2"), ("SKYLAKEX", "1"))
AGREES = 1e-12  # relative, of numbers in documents
COMMANDS = {
    "analyze": ("analyze", "--no-validate"),
    "allocate": ("allocate", "--requirement", WANTED),
    "least cost": (
        *("allocate", "--requirement", WANTED),
        *("--strategy", "cost", "--no-validate"),
    ),
    "compare": (
        *("compare", "zhao-2019", "stim300", "--requirement", WANTED),
        *("--method", "gum"),
    ),
}
# How far at most an answer is from the optimum: rounding, once it is sharpened.
PROOFS = ("residual", "gap")


def leaves(document, path=""):
    """Yield every value of a document with the way to it."""
    if isinstance(document, dict):
        for key, value in document.items():
            yield from leaves(value, f"{path}.{key}")
    elif isinstance(document, list):
        for place, value in enumerate(document):
            yield from leaves(value, f"{path}[{place}]")
    else:
        yield path, document


@pytest.mark.parametrize("command", COMMANDS)
def test_no_word_and_no_digit_hangs_on_the_processor(command, tmp_path):
    """Three kernels, one and two threads: what is printed is one text."""
    said, documents = [], []
    for kernel, threads in PROCESSORS:
        path = tmp_path / f"{kernel}.json"
        done = subprocess.run(
            [
                *(sys.executable, "-m", "budget", *COMMANDS[command]),
                *("--json", path),
            ],
            env=os.environ
            | {"OPENBLAS_CORETYPE": kernel, "OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode in {0, 1}, done.stderr
        said.append(done.stdout)
        documents.append(dict(leaves(json.loads(path.read_text(encoding="utf-8")))))

    assert len(set(said)) == 1  # every word and digit
    for one, other in pairwise(documents):
        assert one.keys() == other.keys()
        for key, value in one.items():
            if key.endswith(PROOFS):  # of the least cost: bounds hold everywhere
                assert max(value, other[key]) <= GOOD, key
                continue
            if key.endswith("solver"):  # its own words, which decide nothing
                continue
            if isinstance(value, float) and "covariance" not in key:
                # Below 1e-15 of a printed unit a number is the rounding of zero.
                assert_allclose(other[key], value, rtol=AGREES, atol=1e-15)
            elif not isinstance(value, float):
                assert other[key] == value, key
