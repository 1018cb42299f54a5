"""What the guides offer beside budgets of sensors, for models of one's own.

Shapes of inputs that no device file names, correlated inputs of any shape, joint
coverage regions of several outputs, decisions on single items and guard bands, on top
of `budget`: no command needs them.
With examples in docs/problems.md; the sources are those of the package `budget`.
"""

from jcgm.copula import Copula
from jcgm.decisions import (
    conformance_probability,
    decide,
    global_guard_band,
    specific_guard_band,
)
from jcgm.regions import (
    box_region,
    ellipsoid_region,
    normal_region,
    smallest_region,
)
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
    "Copula",
    "beta",
    "box_region",
    "conformance_probability",
    "curvilinear_trapezoid",
    "decide",
    "ellipsoid_region",
    "from_quantile",
    "gamma",
    "global_guard_band",
    "lognormal",
    "normal_region",
    "samples",
    "scaled_student_t",
    "smallest_region",
    "specific_guard_band",
    "student_t",
    "trapezoidal",
]
