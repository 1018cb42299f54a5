"""Error budgets for the discrete turntable calibration of strapdown IMUs.

Five lines carry a data sheet to the budget of its calibration parameters; see
the README. Everything public is importable from here and loaded when first asked
for, so that importing the package costs nothing.

Sources, cited in the code by their short names:

Zhao 2019
    Zhao X., Zhang L., Li S., "Coupling Effects of SINS Calibration Parameters in
    Discrete Calibration", Metrology & Measurement Technology 39 (3), 2019, 34-40,
    doi 10.11823/j.issn.1674-5795.2019.03.06 (in Chinese).
JCGM 100
    JCGM 100:2008, Evaluation of measurement data - Guide to the expression of
    uncertainty in measurement (GUM).
JCGM 101
    JCGM 101:2008, Supplement 1 to the GUM - Propagation of distributions using a
    Monte Carlo method.
JCGM 102
    JCGM 102:2011, Supplement 2 to the GUM - Extension to any number of output
    quantities.
JCGM 106
    JCGM 106:2012, Evaluation of measurement data - The role of measurement uncertainty
    in conformity assessment.
NIST TN 1900
    Possolo A., Simple Guide for Evaluating and Expressing the Uncertainty of NIST
    Measurement Results, NIST Technical Note 1900, 2015.
IEEE 528
    IEEE Std 528-2019, Standard for Inertial Sensor Terminology.
BDA
    Gelman A., Carlin J., Stern H., Dunson D., Vehtari A., Rubin D., Bayesian Data
    Analysis, third edition, CRC Press, 2013.
Seber, Lee
    Seber G., Lee A., Linear Regression Analysis, second edition, Wiley, 2003.
Smyth 2004
    Smyth G., "Linear models and empirical Bayes methods for assessing differential
    expression in microarray experiments", Statistical Applications in Genetics and
    Molecular Biology 3 (1), 2004, article 3.
Strong, Oakley 2013
    Strong M., Oakley J., "An efficient method for computing single-parameter partial
    expected value of perfect information", Medical Decision Making 33, 2013, 755-766.
WGS 84
    NIMA TR8350.2, Department of Defense World Geodetic System 1984, third edition.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from budget import views
from budget.version import __version__

if TYPE_CHECKING:
    from budget.errors import BudgetError, CallError, ProblemError, SpecError
    from budget.inputs import (
        load_catalogue,
        load_costs,
        load_device,
        load_mission,
        load_procedure,
        load_requirement,
        load_station,
        uncalibrated,
    )
    from budget.inputs.records import Device
    from budget.methods.decisions import acceptance_interval, global_risks
    from budget.methods.gum import propagate
    from budget.methods.monte_carlo import sample
    from budget.methods.trials import first_trials
    from budget.problem import Group, Output, Problem
    from budget.report import report
    from budget.results import Budget
    from budget.studies.allocation.allocate import allocate
    from budget.studies.allocation.cases import Bounds
    from budget.studies.analysis import analyze
    from budget.studies.comparison.compare import compare
    from budget.studies.conformity import assess
    from budget.studies.export.study import export
    from budget.studies.mission import growth
    from budget.studies.stations import qualify
    from budget.studies.sweep import sweep

_HOME = {
    "Bounds": "budget.studies.allocation.cases",
    "Budget": "budget.results",
    "BudgetError": "budget.errors",
    "CallError": "budget.errors",
    "Device": "budget.inputs.records",
    "Group": "budget.problem",
    "Output": "budget.problem",
    "Problem": "budget.problem",
    "ProblemError": "budget.errors",
    "SpecError": "budget.errors",
    "acceptance_interval": "budget.methods.decisions",
    "allocate": "budget.studies.allocation.allocate",
    "analyze": "budget.studies.analysis",
    "assess": "budget.studies.conformity",
    "compare": "budget.studies.comparison.compare",
    "export": "budget.studies.export.study",
    "first_trials": "budget.methods.trials",
    "global_risks": "budget.methods.decisions",
    "growth": "budget.studies.mission",
    "load_catalogue": "budget.inputs",
    "load_costs": "budget.inputs",
    "load_device": "budget.inputs",
    "load_mission": "budget.inputs",
    "load_procedure": "budget.inputs",
    "load_requirement": "budget.inputs",
    "load_station": "budget.inputs",
    "propagate": "budget.methods.gum",
    "qualify": "budget.studies.stations",
    "report": "budget.report",
    "sample": "budget.methods.monte_carlo",
    "sweep": "budget.studies.sweep",
    "uncalibrated": "budget.inputs",
}

# What stood here and no command needs is a package of its own.
MOVED = {
    "box_region",
    "conformance_probability",
    "decide",
    "ellipsoid_region",
    "global_guard_band",
    "normal_region",
    "smallest_region",
    "specific_guard_band",
}

__all__ = [
    "Bounds",
    "Budget",
    "BudgetError",
    "CallError",
    "Device",
    "Group",
    "Output",
    "Problem",
    "ProblemError",
    "SpecError",
    "__version__",
    "acceptance_interval",
    "allocate",
    "analyze",
    "assess",
    "compare",
    "export",
    "first_trials",
    "global_risks",
    "growth",
    "load_catalogue",
    "load_costs",
    "load_device",
    "load_mission",
    "load_procedure",
    "load_requirement",
    "load_station",
    "propagate",
    "qualify",
    "report",
    "sample",
    "sweep",
    "uncalibrated",
]


views.view = lambda: import_module("budget.report.notebook")


def __getattr__(name: str) -> object:
    """Import a public name from its module when it is first used (PEP 562)."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    if name in MOVED:
        from budget.errors import moved

        raise moved(name, __name__)
    raise AttributeError(f"module 'budget' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the public names alone, whatever has been imported below them."""
    return sorted(__all__)
