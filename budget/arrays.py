"""Float64 arrays, whose shapes are said in the docstrings, and roots of matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

REGULAR = 1e-3  # [1], Cholesky's least pivot in a correlation matrix that is regular
CUT = 1e-14  # [1], variance that is left to rounding
EQUAL = 1e-6  # [1], pivots are equal whose difference rounding may have made


def root_of_correlation(R: Array) -> Array:
    """Return a square root F of a correlation matrix, F F^T = R; it may be singular.

    JCGM 101:2008, C.5. Cholesky's factor where R is regular. Else Cholesky's with
    pivots, the largest first and of equal ones the first, until what is left is
    rounding. Eigenvectors will not do: those of equal eigenvalues are any basis of
    their space, and which one depends on the processor.

    Parameters
    ----------
    R : ndarray, shape (n, n)
        Symmetric, positive semidefinite to rounding, with 1 (or 0: what does not vary)
        on the diagonal [1].

    Returns
    -------
    ndarray, shape (n, n)
        The rows in the order of R. Where R is not semidefinite, F F^T is not R.
    """
    try:
        regular = np.linalg.cholesky(R)
    except np.linalg.LinAlgError:
        pass
    else:
        if np.diag(regular).min(initial=1.0) > REGULAR:
            return np.asarray(regular)
    rest = np.array(R, dtype=float)
    root = np.zeros_like(rest)
    for column in range(len(rest)):
        left = np.diag(rest)
        largest = left.max()
        if largest <= CUT * len(rest):
            break
        pivot = int(np.argmax(left >= largest * (1.0 - EQUAL)))
        root[:, column] = rest[:, pivot] / np.sqrt(rest[pivot, pivot])
        rest -= np.outer(root[:, column], root[:, column])
        rest[pivot, :] = rest[:, pivot] = 0.0
    return root
