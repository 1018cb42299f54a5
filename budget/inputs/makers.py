"""What makers call the lines of a device file: the words, and where a page reads them.

Error messages, the JSON Schema, `budget new` and docs/datasheets.md read this.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.units import ONE_SIDED

if TYPE_CHECKING:
    from collections.abc import Mapping

PAGE = "docs/datasheets.md"
MEANINGS = f"{PAGE}#what-a-value-means"
UNITS = f"{PAGE}#units"


@dataclass(frozen=True, kw_only=True)
class Density:
    """Sides of the noise density that a maker prints, where a sheet of theirs shows it.

    A sheet shows it that prints density and random walk of one noise, or a density and
    the rms of a band.
    """

    vendors: tuple[str, ...]  # as files name them
    sides: str
    source: str  # the sheet, and what it prints


DENSITIES = (
    Density(
        vendors=("Analog Devices", "ADI"),
        sides=ONE_SIDED,
        # 0.008 x 60 / sqrt(2) is 0.339.
        source="ADIS16470: 0.008 deg/s/sqrt(Hz) beside 0.34 deg/sqrt(h)",
    ),
)


def density_of(vendor: str) -> Density | None:
    """Return how a vendor means a density; None where nobody knows."""
    named = bare(vendor)
    return next((x for x in DENSITIES if named in map(bare, x.vendors)), None)


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Lines of one idea: each with the words of makers, and how to read them."""

    anchor: str  # of the heading in PAGE
    words: Mapping[str, tuple[str, ...]]  # by line
    says: str  # what to look at before a value becomes the line

    @property
    def link(self) -> str:
        """Where the page tells it."""
        return f"{PAGE}#{self.anchor}"


READINGS = (
    Reading(
        anchor="bias-repeatability",
        words={
            "bias_repeatability": (
                *("bias repeatability", "turn-on to turn-on bias", "run-to-run bias"),
                *("day-to-day bias", "turn-on bias", "bias one-year repeatability"),
                *("long-term bias repeatability", "bias 1 year stability"),
            )
        },
        says="what is new at a turn-on; of several values the one of the shortest "
        "horizon with a turn-on in it; say in `includes` what else is in it",
    ),
    Reading(
        anchor="bias-stability",
        words={
            "bias_stability": (
                *("bias stability", "bias instability", "in-run bias stability"),
                *("in-run bias instability", "bias drift", "Allan deviation floor"),
            ),
            "flicker": (
                *("bias instability", "in-run bias stability"),
                *("in-run bias instability", "flicker noise", "1/f noise"),
            ),
        },
        says="an Allan minimum says `definition: allan_minimum`, unless the maker has "
        "divided it by 0.664; one printed value is one line, of the two",
    ),
    Reading(
        anchor="noise",
        words={
            "angle_random_walk": (
                *("ARW", "angular random walk", "angle random walk", "random walk"),
                *("noise density", "rate noise density", "noise spectral density"),
                *("rate noise spectral density", "power spectral density"),
            ),
            "velocity_random_walk": (
                *("VRW", "velocity random walk", "random walk", "noise density"),
                *("acceleration noise density", "noise spectral density"),
                *("power spectral density", "spectral noise"),
            ),
            "sample_noise": (
                *("output noise", "total rms noise", "rms noise", "total noise"),
                *("control data noise", "peak-to-peak noise"),
            ),
        },
        says="a value per root of hour or second is the random walk N, one per root of "
        "hertz a density D, N = D/√2 if one-sided, else D; one in a band or per sample "
        "needs its bandwidth",
    ),
    Reading(
        anchor="rate-random-walk",
        words={
            "rate_random_walk": ("RRW", "rate random walk", "bias random walk"),
            "acceleration_random_walk": (
                "acceleration random walk",
                "bias random walk",
            ),
        },
        says="the slope +1/2 of the Allan curve, K; rarely printed",
    ),
    Reading(
        anchor="quantization",
        words={
            "quantization": (
                *("LSB", "resolution", "quantisation", "quantization noise"),
                *("angle per pulse", "least significant bit"),
            )
        },
        says="the step of an increment of angle or velocity; a step of a rate in "
        "counts, LSB/(deg/s), is a scale factor",
    ),
    Reading(
        anchor="scale-factor-repeatability",
        words={
            "scale_factor_repeatability": (
                *("scale factor repeatability", "scale factor stability"),
                *("scale factor 1 year stability", "SF repeatability"),
                *("sensitivity repeatability", "sensitivity stability"),
            )
        },
        says="accuracy, initial tolerance and nominal value are no repeatability: a "
        "calibration takes them out",
    ),
    Reading(
        anchor="nonlinearity",
        words={
            "scale_factor_nonlinearity": (
                *("linearity", "nonlinearity", "scale factor linearity"),
                *("linearity error", "SF nonlinearity"),
            )
        },
        says="of the output, in ppm or %: as printed; of full scale: with "
        "`full_scale`, `line` and `shape`",
    ),
    Reading(
        anchor="asymmetry",
        words={
            "scale_factor_asymmetry": (
                *("asymmetry", "symmetry", "scale factor symmetry"),
                "plus-minus scale factor difference",
            )
        },
        says="K(+) minus K(-) over their mean; half of it is half of it",
    ),
    Reading(
        anchor="mounting-repeatability",
        words={
            "mounting_repeatability": (
                *("alignment stability", "misalignment repeatability"),
                *("axis alignment stability", "orthogonality stability"),
            )
        },
        says="misalignment, orthogonality and cross-axis sensitivity are the angles "
        "that a calibration finds, and no stability of them",
    ),
    Reading(
        anchor="g-sensitivity",
        words={
            "g_sensitivity": (
                *("g sensitivity", "linear acceleration effect on bias"),
                *("linear acceleration sensitivity", "acceleration sensitivity"),
                "bias g-sensitivity",
            )
        },
        says="per g of a steady force; with or without the maker's compensation, and "
        "without the earth's rate",
    ),
    Reading(
        anchor="k2-and-k3",
        words={
            "scale_factor_quadratic": ("K2", "second-order nonlinearity"),
            "scale_factor_cubic": ("K3", "third-order nonlinearity"),
        },
        says="coefficients of the square and the cube of the input, not shares of a "
        "full scale",
    ),
    Reading(
        anchor="temperature-coefficients",
        words={
            "bias_temperature_coefficient": (
                *("tempco", "temperature coefficient", "TCO", "offset drift"),
                *("zero-rate level change vs. temperature", "bias temperature drift"),
                *("ZRO variation vs. temperature", "zero-g offset temperature drift"),
                *("zero-g level change vs. temperature", "offset vs. temperature"),
            ),
            "scale_factor_temperature_coefficient": (
                *("tempco", "temperature coefficient", "TCS"),
                *("sensitivity change vs. temperature", "sensitivity drift"),
                "sensitivity temperature coefficient",
            ),
            "bias_temperature_rate_coefficient": (
                *("temperature ramp sensitivity", "temperature gradient effect"),
                "bias sensitivity to temperature rate",
            ),
        },
        says="per kelvin of the environment; a value over a whole range is no "
        "coefficient",
    ),
    Reading(
        anchor="over-temperature",
        words={
            "bias_over_temperature": (
                *("bias over temperature", "bias residual modelling error"),
                *("bias variation over temperature", "bias error over temperature"),
                "residual bias modeling error",
            ),
            "scale_factor_over_temperature": (
                *("scale factor over temperature", "SF residual modelling error"),
                *("sensitivity variation over temperature", "residual SF error"),
            ),
        },
        says="what the maker's compensation leaves, of a range; not the bias itself "
        "over that range, and not beside the coefficient",
    ),
    Reading(
        anchor="ageing",
        words={
            "ageing": (
                *("aging", "bias ageing", "bias aging", "long-term stability"),
                *("bias long-term stability", "bias drift over lifetime"),
            ),
            "scale_factor_ageing": (
                *("scale factor aging", "scale factor long-term stability"),
                "sensitivity drift over lifetime",
            ),
        },
        says="what goes on between calibration and use, with its time as `horizon`; "
        "the same value is not a repeatability as well",
    ),
    Reading(
        anchor="vibration-rectification",
        words={
            "vibration_rectification": (
                *("VRE", "vibration rectification error", "VRC"),
                "vibration rectification coefficient",
            )
        },
        says="per square of an rms vibration; a shift under one vibration, or one of a "
        "band, is not",
    ),
    Reading(
        anchor="initial-tolerances",
        words={
            "initial_bias": (
                *("zero-rate output tolerance", "ZRO tolerance", "initial ZRO"),
                *("zero-rate offset", "zero-rate level", "initial bias", "bias offset"),
                *("zero-g tolerance", "zero-g offset", "zero-g level"),
            ),
            "initial_scale_factor": (
                *("sensitivity tolerance", "sensitivity scale factor tolerance"),
                *("scale factor tolerance", "initial sensitivity error"),
            ),
            "initial_mounting": (
                *("cross-axis sensitivity", "cross-axis", "misalignment"),
                *("alignment error", "axis misalignment"),
            ),
        },
        says="what a new unit has before any calibration, at room temperature; of a "
        "part that is calibrated it counts nothing, and 1 % across an axis is 10 mrad",
    ),
)


def bare(word: str) -> str:
    """Return a word without what joins it: one spelling of many."""
    return re.sub("[^a-z0-9]", "", word.lower())


_BY_LINE = {line: one for one in READINGS for line in one.words}


def reading_of(line: str) -> Reading | None:
    """Return how makers print a line of a device; None of what is no line."""
    return _BY_LINE.get(line)


def printed_as(line: str) -> str:
    """Return what makers call a line, and where the page reads it."""
    one = _BY_LINE[line]
    return f"printed as {', '.join(one.words[line])}: {one.link}"


def _lines_by_word() -> dict[str, tuple[str, ...]]:
    """Return the lines that each word may stand for; a line's own name is no word."""
    found: dict[str, tuple[str, ...]] = {}
    for one in READINGS:
        for line, words in one.words.items():
            for word in dict.fromkeys(map(bare, words)):
                found[word] = (*found.get(word, ()), line)
    return found | {bare(line): (line,) for line in _BY_LINE}


LINES_BY_WORD = _lines_by_word()
