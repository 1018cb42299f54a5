"""Store the references that ship: `make_references.py [FOLDER]`."""  # noqa: INP001 - a script, no package

# Only after a change that is meant to move numbers: `budget check` says what it moved.

from __future__ import annotations

import sys
from itertools import product
from pathlib import Path

from typer.testing import CliRunner

from budget.cli import app

SPECS = Path(__file__).resolve().parent.parent / "specs"
PAPER = {"corrected": "zhao-2019", "eq4": "zhao-2019-eq4"}
ORIGINS = ("nominal", "as_tested", "next_turn_on")

# Name: devices, procedure, further options. One by trials, one with Sobol' indices of a
# gyro with asymmetry, whose errors are products.
REFERENCES: dict[str, tuple[list[str], str, list[str]]] = {
    **{
        f"zhao-2019-{formulas}-{origin}": (
            ["zhao-2019"],
            PAPER[formulas],
            ["--reference", origin],
        )
        for formulas, origin in product(PAPER, ORIGINS)
    },
    "hg4930-c": (["hg4930#C"], "zhao-2019", ["--requirement", "catalogue-edge"]),
    "stim300-5g-monte-carlo": (
        ["stim300#5g"],
        "zhao-2019",
        [
            "--method",
            "monte-carlo",
            "--trials",
            "100000",
            "--reference",
            "next_turn_on",
        ],
    ),
    "ltys11cj1x-sobol": (["ltys11cj1x"], "zhao-2019", ["--samples", "512"]),
    "compare-catalogue-edge": (
        ["hg4930", "dg068", "zhao-2019"],
        "zhao-2019",
        [
            *("--kind", "compare", "--requirement", "catalogue-edge"),
            *("--method", "monte-carlo", "--trials", "20000", "--max-trials", "20000"),
        ],
    ),
    "allocate-navigation-grade": (
        ["zhao-2019"],
        "zhao-2019",
        ["--kind", "allocate", "--requirement", "navigation-grade"],
    ),
}


def main(folder: Path) -> None:
    """Store every reference in a folder, its inputs by their paths from there."""
    for name, (devices, procedure, options) in REFERENCES.items():
        words = [
            str(_file(word)) if word in _requirements() else word for word in options
        ]
        call = [
            *("check", "--save", str(folder / f"{name}.json")),
            *(_device(one) for one in devices),
            *("--procedure", str(SPECS / "procedures" / f"{procedure}.yaml")),
            *words,
        ]
        outcome = CliRunner().invoke(app, call)
        if outcome.exit_code:
            raise SystemExit(f"{name}: {outcome.exception or outcome.output}")


def _device(name: str) -> str:
    """Return the path of a shipped device, with its variant."""
    stem, mark, variant = name.partition("#")
    return f"{SPECS / 'devices' / stem}.yaml{mark}{variant}"


def _requirements() -> set[str]:
    """Return the names of the shipped requirements."""
    return {path.stem for path in (SPECS / "requirements").glob("*.yaml")}


def _file(name: str) -> Path:
    """Return the path of a shipped requirement."""
    return SPECS / "requirements" / f"{name}.yaml"


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else SPECS / "references")
