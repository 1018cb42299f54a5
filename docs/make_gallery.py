"""Draw the gallery's figures and write its page: [FOLDER]."""  # noqa: INP001 - a script, no package

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import budget
from budget.report.figures.style import PAPER, to_svg

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.figure import Figure

HERE = Path(__file__).resolve().parent
DEVICE, REQUIREMENT = "zhao-2019", "tactical-grade"
UNIT, FLIGHT, NEED = "hg4930#C", "outage-60-s-after-gnss", "survey-drone"
CALL = (
    "result = budget.analyze(\n"
    f'    "{DEVICE}", requirement="{REQUIREMENT}", trials=20_000, samples=256\n)\n'
)
FLOWN = (
    "flight = budget.analyze(\n"
    f'    "{UNIT}", mission="{FLIGHT}", requirement="{NEED}"\n)\n'
)
# What each shows, and the call that draws it.
FIGURES = {
    "limits": ("How much of its limit each required output uses", "limits()"),
    "overview": ("Expanded uncertainty of every output", "overview()"),
    "contributions": (
        "Contributions to the gyro bias, axis by axis",
        'contributions("gyro.bias")',
    ),
    "shares": ("What the variance of each group is made of", "shares()"),
    "tornado": ("Each source alone, of the critical gyro bias", 'tornado("gyro.bias")'),
    "waterfall": ("From the sources to U", 'waterfall("gyro.bias")'),
    "coupling": ("Which source reaches which parameter of the gyro", "coupling()"),
    "validation": ("GUM propagation against Monte Carlo", "validation()"),
    "density": (
        "Distribution of an output, trials and normal law",
        'density("gyro.bias.x")',
    ),
    "schedule": ("The test, to scale", "schedule()"),
    "positions": ("Its positions: which axis is up, and which turns", "positions()"),
    "allan": ("Noise of the gyro, and what the windows average", "allan()"),
    "indices": ("Sobol' indices of the gyro, with intervals", "indices()"),
}
OF_MISSION = {
    "growth": (
        "An error over time against its limit, and what it is made of",
        "growth()",
    ),
    "track": ("Planned track, with error ellipses", "track()"),
}
HEAD = """# Gallery of reports and figures

## Reports

Page one of a report, a [PDF](example/report.pdf) to file and a
[page](example/report.html) that computes again with sliders; both are of the paper's
device, with `--requirement docs/example/requirement.yaml --sobol --allocate`.

[![Page one of a report](example/page-one.png)](example/report.pdf)

[Test schemes](schemes.md) are drawn to scale.

## Figures

Each is a figure of the report and a matplotlib Figure of the library. They are of

"""


def draw(folder: Path) -> None:
    """Draw all figures, and write the page."""
    found = dict(figures())
    (folder / "gallery").mkdir(exist_ok=True)
    for name, figure in found.items():
        write(figure, folder / "gallery" / f"{name}.svg")
    page = f"{HEAD}```python\nimport budget\n\n{CALL}{FLOWN}```\n\n" + "\n".join(
        f"### {says}\n\n`{of}.plot.{how}`\n\n![{says}](gallery/{name}.svg)\n"
        for of, kinds in (("result", FIGURES), ("flight", OF_MISSION))
        for name, (says, how) in kinds.items()
    )
    (folder / "gallery.md").write_text(
        page + "\nWritten by `docs/make_gallery.py`.\n", encoding="utf-8"
    )


def figures() -> Iterator[tuple[str, Figure]]:
    """Yield each figure of the paper's device, and of a mission."""
    result = budget.analyze(DEVICE, requirement=REQUIREMENT, trials=20_000, samples=256)
    for name, (_, how) in FIGURES.items():
        of = re.findall(r'"(.+)"', how)
        yield name, getattr(result.plot, name)(*of)
    flight = budget.analyze(UNIT, mission=FLIGHT, requirement=NEED)
    for name in OF_MISSION:
        yield name, getattr(flight.plot, name)()


def write(figure: Figure, path: Path) -> None:
    """Write a picture on its own paper: a page may be dark, the labels are too."""
    svg = to_svg(figure, name=path.stem)
    paper = f'<rect width="100%" height="100%" fill="{PAPER}"/>'
    path.write_text(re.sub(r"(<svg\b[^>]*>)", rf"\1{paper}", svg), encoding="utf-8")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
