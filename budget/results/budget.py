"""The error budget: every output, and how they go together."""

from __future__ import annotations

from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from budget import views
from budget.documents import document, written
from budget.errors import NotThereError
from budget.names import Name, braced, spellings, with_parts
from budget.results.matrices import CONVENTION, Compensation, in_units
from budget.results.outputs import (
    AT_A_TIME,
    COLUMNS,
    KEY,
    OF_A_LENGTH,
    TIME_COLUMN,
    TOTAL,
    InputQuantity,
    OutputBudget,
)
from budget.results.study import Study
from budget.settings import fills

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    import pandas as pd

    from budget.arrays import Array
    from budget.inputs.records import (
        Mission,
    )
    from budget.results.doubts import FilledLine, ReadingEffect
    from budget.results.mission import Calibrated, Filtered
    from budget.results.verdicts import Assessment

NEAR = 3  # names that are like one that there is not


@written(
    "budget",
    """
    title: names of the devices
    inputs by role as file: files that it depends on
    settings: what it depends on besides
    mission = self if mission as mission_of_budget: that it is of; in a report all that
      `budget mission` says
    outputs
    quantities by source: the lines that contributions are of
    covariance = printed (list[list[float | None]]) [products of units]: of all outputs;
      null between a horizontal length and another output, of which no covariance is
      known
    not_given: lines of the data sheet that are absent
    missing = self if fills as missing: where lines stand for those that are not given
    assumptions
    warnings
    assessment: against the requirement; null where there is none
    readings?: other readings of lines whose meaning is open, one by one
    matrices = self if matrices as matrices_of_triads: where they were asked for
    one_at_a_time? = None (tuple[SourceSteps, ...]): of a report
    mission? = None (Budget)
    allocation? = None (Allocation): of a report with --allocate
    comparison? = None (Comparison): of a report with --compare
    """,
    commands="analyze report mission",
    fills=lambda budget: fills(budget.settings),
    printed=lambda budget: budget.printed_covariance,
)
@written(
    "matrices_of_triads",
    """
    convention (str): how they are used
    gyro? = matrices.gyro
    accelerometer? = matrices.accelerometer
    """,
    said="Compensation matrices, by triad.",
    convention=lambda _: CONVENTION,
)
@written(
    "mission_of_budget",
    """
    name = mission.name (str)
    duration = mission.route.duration (float) [s]
    route = mission.route.outline (Outline)
    alignment = mission.alignment (float) [s]: how long it finds level and north by
      itself; 0 where it knows them
    aided = mission.aided (bool): whether height and vertical velocity are known all the
      time
    calibrations = bought: how far off it is after none, the maker's, and this one
    filter?: where it has aids
    """,
    said="Where a calibrated unit goes by itself, and what it knows when it begins.",
)
@written(
    "missing",
    """
    mode = settings.missing: 'worst', 'typical' or 'predict'
    filled: what stands for expected lines
    left: expected lines that nothing stands for
    """,
    said="A line in the place of an expected one that is not given.",
)
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Budget(Study):
    """The error budget of a calibration: every output, and how they go together.

    Or of a mission after it, whose outputs are errors of navigation at some times.

    Attributes
    ----------
    outputs : tuple of OutputBudget
        One for each calibration parameter [SI].
    covariance : ndarray, shape (n_out, n_out)
        Joint covariance of all outputs in their order [products of SI units].
    could_widen : mapping of Name to tuple of Name
        The outputs that each line that is not given would reach.
    matrices : mapping of str to Compensation
        By triad, where they were asked for.
    """

    command: str
    outputs: tuple[OutputBudget, ...]
    covariance: Array = field(repr=False)
    could_widen: Mapping[Name, tuple[Name, ...]]
    assessment: Assessment | None = None  # against the requirement, where there is one
    matrices: Mapping[str, Compensation] = field(default_factory=dict)
    quantities: tuple[InputQuantity, ...] = ()  # what its contributions are of
    # What stands for expected lines that are not given, and those without a stand-in.
    filled: tuple[FilledLine, ...] = ()
    left: tuple[Name, ...] = ()
    readings: tuple[ReadingEffect, ...] = ()  # other ones than are taken, one by one
    mission: Mission | None = None  # that it is of; None: of a calibration
    # The same mission after no calibration, the maker's, and the one it is of.
    bought: tuple[Calibrated, ...] = ()
    filter: Filtered | None = None  # of that mission, where it has one

    @property
    def correlation(self) -> Array:
        """Correlation matrix, shape (n_out, n_out) [1]; 0 beside a constant output."""
        u = np.sqrt(np.diag(self.covariance))
        safe = np.where(u > 0.0, u, np.inf)
        return np.asarray(self.covariance / np.outer(safe, safe))

    @cached_property
    def _by_name(self) -> dict[str, OutputBudget]:
        """Outputs by all that each may be called."""
        return {
            name: row for row in self.outputs for name in spellings(row.output.name)
        }

    def output(self, name: str) -> OutputBudget:
        """Return the budget of one output by its dotted name, as `budget[name]` does.

        Of a mission the time may have its unit, 'mission.position.north.1 min', and the
        length of the horizontal vector no axis: 'mission.position.60 s'.

        Raises
        ------
        CallError
            There is none; it is a KeyError as well.
        """
        if name not in self._by_name:
            text = str(name)
            near = with_parts(text, self) or get_close_matches(text, self._by_name)
            meant = " or ".join(repr(str(one)) for one in near[:NEAR])
            raise NotThereError(
                f"found {name!r}, no output of this budget"
                f"{f'; did you mean {meant}?' if meant else '.'} It has {braced(self)}"
            )
        return self._by_name[name]

    def __getitem__(self, name: str) -> OutputBudget:
        """Return the budget of one output. Raises as `output`."""
        return self.output(name)

    def __contains__(self, name: object) -> bool:
        """Whether there is an output of that name."""
        return name in self._by_name

    def __iter__(self) -> Iterator[Name]:
        """Yield the names of the outputs, as a mapping does."""
        return (row.output.name for row in self.outputs)

    def __len__(self) -> int:
        """Count the outputs."""
        return len(self.outputs)

    def _ipython_key_completions_(self) -> list[str]:
        """Return what may stand in brackets: what a notebook completes."""
        return [*map(str, self)]

    @property
    def columns(self) -> tuple[str, ...]:
        """Heads of the flat records: of a mission with the time, and what it adds."""
        if self.mission is None:
            return COLUMNS
        place = COLUMNS.index("unit")
        return (
            *COLUMNS[:place],
            AT_A_TIME,
            *COLUMNS[place:],
            *("coverage", *OF_A_LENGTH),
        )

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield one flat record for each output and source, and one `total` each.

        In printed units. Mean and interval belong to the total; on the rows of single
        sources they are None.
        """
        for row in self.outputs:
            total = document(row)
            key = {name: total[name] for name in (*KEY, AT_A_TIME) if name in total}
            low, high = total["interval"]
            parts = total["contributions"]
            total |= {"source": TOTAL, "share": sum(part["share"] for part in parts)}
            total |= {"interval_low": low, "interval_high": high}
            for record in (*({**key, **part} for part in parts), total):
                yield {name: record.get(name) for name in self.columns}

    @property
    def widening(self) -> tuple[Name, ...]:
        """Lines not given that could widen outputs, first those that reach most."""
        reached = self.could_widen
        return tuple(
            name
            for name in sorted(reached, key=lambda one: -len(reached[one]))
            if reached[name]
        )

    @property
    def printed_covariance(self) -> list[list[float | None]]:
        """Covariance in printed units: of a length with other outputs none is known."""
        found: list[list[float | None]] = in_units(
            self.covariance, [row.output for row in self.outputs]
        ).tolist()
        for k in [k for k, one in enumerate(self.outputs) if one.output.length_of]:
            for other in range(len(found)):
                if other != k:
                    found[k][other] = found[other][k] = None
        return found

    def to_frame(self) -> pd.DataFrame:
        """Return `rows()` as a tidy pandas frame, in the units of its column `unit`."""
        import pandas as pd

        table = pd.DataFrame.from_records(list(self.rows()))
        return table.rename(columns={AT_A_TIME: TIME_COLUMN})

    @cached_property  # which a notebook completes, unlike a property
    def plot(self) -> Any:  # noqa: ANN401 - Plots, of a floor above this one
        """The figures of the report, `plot.contributions()`: matplotlib Figures."""
        return views.view().Plots(self)

    def to_markdown(self) -> str:
        """Return a table with a row for each output, rounded as in a report."""
        table: str = views.view().budget_markdown(self)
        return table

    def to_latex(self) -> str:
        """Return the same as a LaTeX tabular."""
        table: str = views.view().budget_latex(self)
        return table

    def to_xlsx(self, file: str | Path) -> Path:
        """Write a workbook: that table, contributions, notes (extra `xlsx`).

        Raises
        ------
        CallError
            The extra is not installed, or the file has another suffix than .xlsx.
        OutputError
            It cannot be written.
        """
        path: Path = views.view().write_xlsx(self, file)
        return path
