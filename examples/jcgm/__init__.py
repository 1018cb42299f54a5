"""What the guides offer beside budgets of sensors, for models of one's own.

Shapes of inputs that no device file names, on top of `budget`: no command needs them.
With examples in docs/problems.md; the sources are those of the package `budget`.
"""

from jcgm.shapes import (
    EXPONENTIAL,
    beta,
    curvilinear_trapezoid,
    from_quantile,
    gamma,
    lognormal,
    samples,
    scaled_student_t,
    student_t,
    trapezoidal,
)

__all__ = [
    "EXPONENTIAL",
    "beta",
    "curvilinear_trapezoid",
    "from_quantile",
    "gamma",
    "lognormal",
    "samples",
    "scaled_student_t",
    "student_t",
    "trapezoidal",
]
