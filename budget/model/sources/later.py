"""What is another one at a later turn-on than in the test: residuals, vibration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Change, Coefficient, Given

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.model.source import Gains

TEST_VIBRATION, MISSION_VIBRATION = "vibration.test", "vibration.mission"


@dataclass(frozen=True)
class OverTemperature(Change):
    """What is left of a parameter's temperature dependence: 0 at the test's.

    Attributes
    ----------
    target : str
        'bias' or 'scale_factor'.
    """

    needs = "a later turn-on at another temperature (error reference next_turn_on)"

    target: str

    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:  # noqa: ARG002
        """Return nothing in the test, all of it later."""
        return {self.target: (np.zeros((3, 3)), np.eye(3))}


@dataclass(frozen=True)
class VibrationRectification(Change):
    """db = VRE a^2, a the rms of the vibration: during the test, and later."""

    needs = "a vibration (of the environment; one at test and mission alike cancels)"

    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:
        """Return the squares of both vibrations."""
        test, mission = (
            known[name].u[0] ** 2 if name in known else 0.0
            for name in (TEST_VIBRATION, MISSION_VIBRATION)
        )
        return {"bias": (test * np.eye(3), mission * np.eye(3))}


@dataclass(frozen=True)
class Vibration(Coefficient):
    """Rms of a vibration, which is known."""

    needs = "a sensor with vibration_rectification"
    partner = "vibration_rectification"
