"""Roots of correlation matrices: right, and the same on every processor."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.arrays import root_of_correlation

pytestmark = pytest.mark.kernels

HALF = np.full((3, 3), 0.5) + 0.5 * np.eye(3)
PAIRS = np.kron(np.eye(3), np.array([[1.0, 0.5], [0.5, 1.0]]))
CASES = {
    "regular": PAIRS,
    "equal": np.ones((4, 4)),
    "opposite": np.array([[1.0, -1.0], [-1.0, 1.0]]),
    "two of the same among others": np.kron(np.ones((2, 2)), HALF),
    "planes of equal eigenvalues": np.kron(np.ones((2, 2)), np.kron(np.eye(2), HALF)),
    "nearly equal": np.array([[1.0, 1.0 - 1e-13], [1.0 - 1e-13, 1.0]]),
    "one that does not vary": np.diag([1.0, 0.0, 1.0]),
    "far apart in one direction": np.array(
        [[1.0, 1.0, 0.0], [1.0, 1.0, 1e-8], [0.0, 1e-8, 1.0]]
    ),
    "none": np.zeros((2, 2)),
    "empty": np.zeros((0, 0)),
}
SINGULAR = [
    "equal",
    "opposite",
    "two of the same among others",
    "planes of equal eigenvalues",
]


@pytest.mark.parametrize("case", CASES)
def test_a_root_gives_its_matrix_back(case):
    """F F^T is R within rounding, singular or not."""
    R = CASES[case]
    F = root_of_correlation(R)
    assert_allclose(F @ F.T, R, rtol=0, atol=1e-13)


def shaken(R, seed):
    """Return a matrix as another processor might have rounded it."""
    noise = np.random.default_rng(seed).uniform(-1e-16, 1e-16, R.shape)
    return R + noise + noise.T


@pytest.mark.parametrize("case", [*SINGULAR, "regular"])
def test_rounding_does_not_turn_a_root(case):
    """Twenty roundings of one matrix have one root, within 1e-10."""
    R = CASES[case]
    F = root_of_correlation(R)
    for seed in range(20):
        assert_allclose(root_of_correlation(shaken(R, seed)), F, rtol=0, atol=1e-10)


def test_rounding_turns_eigenvectors():
    """Control: the root by eigenvectors of the same matrices is another each time."""
    R = CASES["planes of equal eigenvalues"]

    def by_eigenvectors(matrix):
        values, vectors = np.linalg.eigh(matrix)
        return vectors * np.sqrt(np.maximum(values, 0.0))

    first = by_eigenvectors(R)
    turned = [np.abs(by_eigenvectors(shaken(R, s)) - first).max() for s in range(20)]
    assert max(turned) > 0.1
