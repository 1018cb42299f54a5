"""Estimators that a procedure finds parameters by from its windows, one row each.

The file of a procedure reads its words here, checks and studies what holds for each;
budget.calibration.schemes has the weights that each makes of windows.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Estimator:
    """How parameters are found from any windows.

    Attributes
    ----------
    name : str
        As a procedure has it.
    says : str
        What it goes by, for the schema; '' of the usual one.
    weighs_noise : bool
        Whether it weighs windows by all that varies, which is the device's.
    knows_attitudes : bool
        Whether the table's angles are known to it; else three angles are held.
    """

    name: str
    says: str = ""
    weighs_noise: bool = False
    knows_attitudes: bool = True

    @property
    def is_of_device(self) -> bool:
        """Whether its weights are another one's for another device."""
        return self.weighs_noise or not self.knows_attitudes


PLAIN, WEIGHTED, NORM = "least_squares", "weighted", "norm"
ESTIMATORS = (
    Estimator(name=PLAIN),
    Estimator(name=WEIGHTED, says="by all that varies", weighs_noise=True),
    Estimator(
        name=NORM,
        says="by the norm of gravity in dwells at attitudes that nobody knows",
        knows_attitudes=False,
    ),
)
# Of tests that have formulas of their own, and of none.
FORMULAS = Estimator(name="")


def estimator_of(name: str) -> Estimator:
    """Return the estimator of that name; FORMULAS of what is none of windows."""
    return next((one for one in ESTIMATORS if one.name == name), FORMULAS)
