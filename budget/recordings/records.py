"""What a recording says of noise: figures with intervals, models, curve, health."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from budget.documents import Documented, written
from budget.inputs.records import RunConditions

if TYPE_CHECKING:
    from budget.inputs.records import Recording
    from budget.results import InputFile


@written(
    "noise_line",
    """
    sensor: 'gyro' or 'accelerometer'
    axis: 'x', 'y' or 'z'
    line: as in a device file, bias_stability.correlation_time apart
    value / unit [unit]: 1 sigma; of an upper bound the bound
    unit: 'counts' and the like where no gain is given
    standard_uncertainty / unit [unit]: null of what is not told
    interval_low = interval.0 / unit [unit]: at 95 %
    interval_high = interval.1 / unit or null [unit]: null: it has no end
    bound: 'two-sided', 'upper', or 'refused' of what the recording is too short to tell
    degrees_of_freedom [1]: of the value; null of what is not told
    why: it is no value; empty of what is told
    """,
)
@dataclass(frozen=True, kw_only=True)
class NoiseLine(Documented):
    """One figure of one axis, as a device file would say it.

    Attributes
    ----------
    parameter : str
        N, K, sigma, tau, B, Q, of the model of noise; R of a repeatability, C of a
        change with temperature.
    value, interval, standard_uncertainty : float
        [SI, or counts].
    """

    sensor: str
    axis: str
    line: str
    parameter: str
    value: float
    unit: str
    si_per_unit: float
    standard_uncertainty: float | None
    interval: tuple[float, float]
    bound: str
    degrees_of_freedom: float | None
    why: str = ""

    @property
    def is_told(self) -> bool:
        """Whether it is a value."""
        return self.bound == "two-sided"


@written(
    "noise_candidate",
    """
    name: 'white', 'rw' random walk, 'gm' Gauss-Markov, 'flicker', sums of them
    log_likelihood: restricted, of means of blocks
    bic: Bayesian information criterion
    delta: over the least; below 6 the recording does not tell the two apart
    """,
)
@dataclass(frozen=True, kw_only=True)
class NoiseCandidate(Documented):
    """A model of noise that was fitted."""

    name: str
    log_likelihood: float
    bic: float
    delta: float


@written(
    "noise_models",
    """
    sensor
    axis
    chosen: whose values are told
    not_told_apart: other models that the recording allows too
    block [s]: length of the blocks that were fitted
    candidates
    """,
)
@dataclass(frozen=True, kw_only=True)
class NoiseModels(Documented):
    """Models of the noise of one axis, the best first."""

    sensor: str
    axis: str
    chosen: str
    not_told_apart: tuple[str, ...]
    block: float
    candidates: tuple[NoiseCandidate, ...]


@written(
    "allan_row",
    """
    sensor
    axis
    tau [s]: averaging time
    deviation / unit [unit]: overlapping Allan deviation
    unit
    edf [1]: equivalent degrees of freedom
    interval_low / unit [unit]: at 95 %
    interval_high / unit [unit]
    model / unit [unit]: of the chosen model
    white / unit [unit]: of its white noise alone
    slow / unit [unit]: of what is slow in it
    """,
)
@dataclass(frozen=True, kw_only=True)
class AllanRow(Documented):
    """The Allan deviation of one axis over one averaging time."""

    sensor: str
    axis: str
    tau: float
    deviation: float
    unit: str
    si_per_unit: float
    edf: float
    interval_low: float
    interval_high: float
    model: float
    white: float
    slow: float


@written(
    "spectrum_row",
    """
    sensor
    axis
    frequency [Hz]
    ratio [1]: power density of the first recording over that of the chosen model
    """,
)
@dataclass(frozen=True, kw_only=True)
class SpectrumRow(Documented):
    """The spectrum of one axis over that of its model, mean of part of a decade."""

    sensor: str
    axis: str
    frequency: float
    ratio: float


@written(
    "periodic_line",
    """
    sensor
    axis
    frequency [Hz]
    amplitude / unit [unit]
    unit
    """,
)
@dataclass(frozen=True, kw_only=True)
class PeriodicLine(Documented):
    """A line in the spectrum of a channel."""

    sensor: str
    axis: str
    frequency: float
    amplitude: float
    unit: str
    si_per_unit: float


@written(
    "recorded_channel",
    """
    sensor
    axis
    mean / unit [unit]
    mean_uncertainty / unit [unit]: standard, by the chosen model
    unit
    stuck: samples that are kept out
    saturated: likewise
    outliers: likewise
    level [1]: white noise over that of the median run
    """,
)
@dataclass(frozen=True, kw_only=True)
class RecordedChannel(Documented):
    """One axis in one recording: its mean, and what of it is kept out."""

    sensor: str
    axis: str
    mean: float
    mean_uncertainty: float
    unit: str
    si_per_unit: float
    stuck: int
    saturated: int
    outliers: int
    level: float


@written(
    "recorded",
    """
    name: of its file
    rows
    duration [s]
    rate [Hz]
    gaps: steps over more than one sample
    missing: samples that the gaps leave out
    temperature? (list[float]) [degC]: the lowest and the highest mean of a block
    channels
    periodic
    skipped: columns that are not read
    """,
)
@dataclass(frozen=True, kw_only=True)
class RecordHealth(Documented):
    """The health of one recording."""

    name: str
    rows: int
    duration: float
    rate: float
    gaps: int
    missing: int
    temperature: tuple[float, ...]
    channels: tuple[RecordedChannel, ...]
    periodic: tuple[PeriodicLine, ...]
    skipped: tuple[str, ...]


@written(
    "run_environment",
    """
    recording: name of it
    date: of it, as its recording file says; empty where it does not
    temperature [degC]: of the air; this and what follows null where nobody said it
    humidity * percent [%]: relative
    pressure / hectopascal [hPa]
    text: what else was said
    """,
    percent=lambda _: 100.0,
    hectopascal=lambda _: 100.0,
)
@dataclass(frozen=True, kw_only=True)
class RecordedConditions(Documented):
    """When and in what a recording was made, as its file says."""

    recording: str
    date: str
    temperature: float | None
    humidity: float | None
    pressure: float | None
    text: str

    @classmethod
    def of(cls, recording: Recording) -> RecordedConditions:
        """Take them from a recording."""
        said = recording.environment or RunConditions()
        return cls(recording=recording.name, date=recording.date, **vars(said))


@written(
    "characterisation",
    """
    title: names of the recordings
    environment: of each recording, when and in what it was made
    inputs by role as file
    lines
    models
    allan
    spectrum
    records
    assumptions
    warnings
    """,
    commands="characterise",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class Characterisation(Documented):
    """What recordings of a device at rest say of its noise.

    Attributes
    ----------
    lines : tuple of NoiseLine
    models : tuple of NoiseModels
    allan : tuple of AllanRow
    records : tuple of RecordHealth
    """

    title: str
    environment: tuple[RecordedConditions, ...]
    inputs: tuple[InputFile, ...]
    lines: tuple[NoiseLine, ...]
    models: tuple[NoiseModels, ...]
    allan: tuple[AllanRow, ...] = field(repr=False)
    spectrum: tuple[SpectrumRow, ...] = field(repr=False)
    records: tuple[RecordHealth, ...]
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors that were recorded, gyro first."""
        return tuple(dict.fromkeys(one.sensor for one in self.models))

    @property
    def is_short(self) -> bool:
        """Whether it is too short to tell more than white noise."""
        return all(len(one.candidates) == 1 for one in self.models)

    @property
    def has_counts(self) -> bool:
        """Whether some figures are in counts, of which no device file can be."""
        return any(one.unit.startswith("counts") for one in self.lines)
