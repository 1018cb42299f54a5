"""Draw the figures of the README: `python docs/make_figures.py [FOLDER]`."""  # noqa: INP001 - a script, no package

from __future__ import annotations

import re
import sys
from pathlib import Path

import budget
from budget.report.figures.rows import draw as draw_rows
from budget.report.figures.sources import share_chart
from budget.report.figures.style import PAPER, to_svg
from budget.report.tables import group_tables

HERE = Path(__file__).resolve().parent


def draw(folder: Path) -> Path:
    """Draw what causes the variance of the paper's gyro bias; return the file."""
    result = budget.analyze(budget.load_device("zhao-2019"), validate=False)
    (group,) = (g for g in group_tables(result) if g.title == "gyro bias")
    svg = to_svg(draw_rows(share_chart(group)), name="share-gyro-bias")
    # A page may be dark, the labels are too: the picture brings its own paper.
    paper = f'<rect width="100%" height="100%" fill="{PAPER}"/>'
    path = folder / "share-gyro-bias.svg"
    path.write_text(re.sub(r"(<svg\b[^>]*>)", rf"\1{paper}", svg), encoding="utf-8")
    return path


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
