"""Coupling table: which source reaches which parameter, and how far."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.documents import written
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.model.sources import SENSORS, source_of
from budget.names import IMU

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.methods.gum import Propagation
    from budget.names import Name
    from budget.problem import Problem

METHODS = ("gum", "monte-carlo", "simulation")
TRIALS = 4096  # of Monte Carlo for each source: one block
RUNS = 4  # of the simulation for each source: enough to tell a spread from none

# The simulation subtracts pulses and divides them again, which costs two digits of
# those that the closed forms keep.
PULSE_ROUNDING = 100.0  # [1]


@written(
    "coupling",
    """
    source
    group: outputs of one name, on all axes
    reaches: whether any of them spreads more than by rounding
    size [1]: standard uncertainty over that of all sources together, the largest of
      them
    """,
)
@dataclass(frozen=True, kw_only=True)
class Coupling:
    """What one source alone does to one group of parameters."""

    source: Name  # 'gyro.bias_stability'
    group: Name  # 'gyro.scale_factor': the outputs of that name on all axes
    u: float  # largest standard uncertainty over the group [SI unit of the outputs]
    # Standard uncertainty over that from all sources together, largest over the group
    # [1]; 0 where nothing reaches it.
    size: float
    # Whether any output of the group has more spread than the rounding of the
    # computation (Output.resolution).
    reaches: bool

    @property
    def is_own(self) -> bool:
        """Whether the source is a spread of the parameter itself."""
        own = source_of(self.source.owner, self.source.quantity).own
        return own == self.group.quantity


@dataclass(frozen=True, kw_only=True)
class CouplingTable:
    """All sources of some sensors against their own groups of parameters."""

    method: str
    formulas: str
    sources: tuple[Name, ...]
    groups: tuple[Name, ...]
    cells: tuple[Coupling, ...]  # a sensor's sources reach its own groups only

    def cell(self, source: str, group: str) -> Coupling:
        """Return one cell; KeyError where source and group are of two sensors."""
        for cell in self.cells:
            if (cell.source, cell.group) == (source, group):
                return cell
        raise KeyError(f"{source}, {group}")


def coupling(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    method: str = "gum",
    reference: str = "nominal",
) -> CouplingTable:
    """Find which source reaches which parameters, one source at a time.

    Zhao 2019, sections 2 and 4. Products of two sources are no source: asymmetry, for
    one, reaches a scale factor only as a product with the bias, so that it counts here
    for a nominal bias and not for a nominal bias of zero. The method is 'gum',
    'monte-carlo' (4096 trials a source) or 'simulation' (4 runs a source).
    """
    problem = calibration_problem(sensors, procedure, reference=reference)
    if method == "gum":
        return coupling_by_law(problem, propagate(problem), procedure.formulas)
    u = np.stack(
        [
            _draw_alone(
                sensors, procedure, group.name, method=method, reference=reference
            )
            for group in problem.groups
        ]
    )
    return _tabulate(problem, u, method=method, formulas=procedure.formulas)


def coupling_by_law(problem: Problem, law: Propagation, formulas: str) -> CouplingTable:
    """Return the coupling table of a calibration whose law is there already."""
    u = np.sqrt(law.source_variance)
    return _tabulate(problem, u, method="gum", formulas=formulas)


def _draw_alone(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    source: str,
    *,
    method: str,
    reference: str,
) -> Array:
    """Return the spread of all outputs from one source alone, shape (n_out,) [SI]."""
    only = frozenset({source})
    if method == "monte-carlo":
        problem = calibration_problem(
            sensors, procedure, reference=reference, only=only
        )
        return sample(problem, trials=TRIALS).standard_uncertainty
    runs = [
        simulate(sensors, procedure, run=run, reference=reference, only=only)
        for run in range(RUNS)
    ]
    return np.asarray(np.std(runs, axis=0, ddof=1))


def _tabulate(
    problem: Problem, u: Array, *, method: str, formulas: str
) -> CouplingTable:
    """Gather spreads, shape (n_sources, n_out), by groups of outputs."""
    names = [output.name.group for output in problem.outputs]
    zero = np.array([output.resolution for output in problem.outputs])
    if method == "simulation":
        zero = zero * PULSE_ROUNDING
    u = np.where(u > zero, u, 0.0)
    total = np.sqrt((u**2).sum(axis=0))
    part = u / np.where(total > 0.0, total, np.inf)
    sources = tuple(group.name for group in problem.groups)
    groups = tuple(dict.fromkeys(names))
    cells = []
    for place, source in enumerate(sources):
        for group in groups:
            if source.owner in SENSORS and group.owner not in {source.owner, IMU}:
                continue
            of_group = np.array([name == group for name in names])
            largest = float(u[place, of_group].max())
            cells.append(
                Coupling(
                    source=source,
                    group=group,
                    u=largest,
                    size=float(part[place, of_group].max()),
                    reaches=largest > 0.0,
                )
            )
    return CouplingTable(
        method=method,
        formulas=formulas,
        sources=sources,
        groups=groups,
        cells=tuple(cells),
    )
