"""Draw figures of README and aided.md, write the page of test schemes: [FOLDER]."""  # noqa: INP001 - a script, no package

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

import budget
from budget.calibration.schemes import calibrates, schedule_of
from budget.question import question_of
from budget.recordings.characterise import characterise
from budget.recordings.printed import beside_data_sheet
from budget.report.figures.growth import growth_pictures
from budget.report.figures.rows import Bar, Chart, ChartGroup, ChartPanel, ChartRow
from budget.report.figures.rows import draw as draw_rows
from budget.report.figures.sources import share_chart
from budget.report.figures.style import BLUE, HATCH, MUTED, PAPER, Scale, to_svg
from budget.report.figures.timeline import schedule_chart
from budget.report.measured import ratio_chart
from budget.report.recording import measured_device
from budget.report.tables import group_tables
from budget.resources import shipped
from budget.studies.mission import curve, drawn_times

if TYPE_CHECKING:
    from collections.abc import Sequence

HERE = Path(__file__).resolve().parent
RECORDED = HERE.parent / "tests" / "data" / "mpu-9150"
# In the order of what they need: nothing, a plate, a table.
SCHEMES = (
    *("norm-nine-positions", "norm-eighteen-positions", "norm-icosahedron"),
    "norm-and-turns-by-hand",
    *("hand-turns", "six-positions", "twelve-positions"),
    *("one-axis-rate-table", "six-positions-and-turns", "twenty-four-positions"),
    *("dividing-head", "zhao-2019", "zhao-2019-eq4"),
)
HEAD = """# Test schemes that ship

What each sees, and how large the errors are that it adds to what the unit truly is
(`--reference as_tested`): the optical unit of the paper, largest axis, U at 95 %. A
dash: not estimated. Each is a file in `specs/procedures/`, to be copied and changed
([files.md](files.md), Procedure). Plate, cube, axes and table are ideal here, but for
the angle of a turn by hand: their errors come on top (`station`), where a norm of
gravity needs none of them. By hand nobody knows north: `hand-turns` has a new heading
at each stop (`azimuth: unknown`), whose horizontal earth rate is nearly all of its gyro
bias and angle; with `estimator: weighted` they are 0.091 deg/h and 0.29 arcsec.
`norm-and-turns-by-hand` has one heading (`azimuth: zero_unknown`), which it finds.

"""
HEADS = (
    *("scheme", "lasts [min]"),
    *("gyro scale factor [ppm]", "gyro angle [arcsec]", "gyro bias [deg/h]"),
    *("accelerometer scale factor [ppm]", "accelerometer angle [arcsec]"),
    "accelerometer bias [ug]",
)
FOOT = """
Written by `docs/make_figures.py`.
"""
OUTAGES = {
    "straight": "outage-60-s-after-straight-gnss",
    "turning": "outage-60-s-turning-after-straight-gnss",
}
# The question at the head of README, and how many of its answers are drawn.
NEED, MISSION = "survey-drone", "outage-60-s-after-gnss"
DRAWN, WIDEST = 11, 150.0  # [1], [% of the limit]
WIDE_ENOUGH = 460.0  # for the names of devices [pt]
GROUPS = tuple(
    f"{sensor} {quantity}"
    for sensor in ("gyro", "accelerometer")
    for quantity in ("scale factor", "mounting angle", "bias")
)


def measured() -> Chart:
    """Show a recorded unit beside its data sheet."""
    found = characterise(RECORDED / "unit-0.csv", rate=100.0)
    unit, sheet = measured_device(found), budget.load_device("mpu-9150")
    chart = ratio_chart(beside_data_sheet(sheet, unit, sample_rate=100.0))
    if chart is None:
        raise ValueError("the recording and the data sheet have no line in common")
    return chart


def draw(folder: Path) -> None:
    """Draw all figures, and write the page of schemes."""
    result = budget.analyze(budget.load_device("zhao-2019"), validate=False)
    (group,) = (g for g in group_tables(result) if g.title == "gyro bias")
    share = to_svg(draw_rows(share_chart(group)), name="share-gyro-bias")
    write(share, folder / "share-gyro-bias.svg")
    write(to_svg(draw_rows(choice()), name="which-imu"), folder / "which-imu.svg")
    write(
        to_svg(draw_rows(measured()), name="measured-mpu-9150"),
        folder / "measured-mpu-9150.svg",
    )
    (folder / "schemes").mkdir(exist_ok=True)
    rows, sections = [line(HEADS), line(["---"] * len(HEADS))], []
    for name in SCHEMES:
        plan = budget.load_procedure(name)
        there = [kind for kind in ("gyro", "accelerometer") if calibrates(kind, plan)]
        chart = schedule_chart(plan, there)
        svg = to_svg(draw_rows(chart), name=name)
        write(svg, folder / "schemes" / f"{name}.svg")
        rows.append(row(name, plan))
        sections.append(
            f"## {plan.name}\n\n`{name}`: {source_of(name)}\n\n"
            f"![Windows of {plan.name} in time](schemes/{name}.svg)\n"
        )
    draw_outages(folder / "aided")
    page = HEAD + "\n".join(rows) + "\n\n" + "\n".join(sections) + FOOT
    (folder / "schemes.md").write_text(page, encoding="utf-8")


def choice() -> Chart:
    """Return how much of the limit each unit uses, as its maker calibrated it."""
    found = budget.compare(
        budget.load_catalogue(),
        NEED,
        mission=MISSION,
        calibration="factory",
        method="gum",
    ).to_frame()
    rows = tuple(
        ChartRow(
            label=one.name,
            marks=(
                Bar(
                    start=0.0,
                    end=100.0 * one.utilisation,
                    colour=BLUE if one.verdict == "meets" else MUTED,
                    hatch=HATCH if one.lower_bound else "",
                ),
            ),
            beside=(
                f"{'≥ ' if one.lower_bound else ''}{100.0 * one.utilisation:.3g}",
                one.verdict,
            ),
            strong=one.verdict == "meets",
        )
        for one in found.head(DRAWN).itertuples()
    )
    scale = Scale(
        low=0.0, high=WIDEST, lines=((100.0, "limit"),), label="% of the limit"
    )
    return Chart(
        name="which-imu",
        title="",
        panels=(ChartPanel(scale=scale, groups=(ChartGroup(rows=rows),)),),
        beside=("% of limit", "verdict"),
        legend=((MUTED, HATCH, "at least: a specification is not given"),),
        width=WIDE_ENOUGH,
    )


def draw_outages(folder: Path) -> None:
    """Draw how errors grow in an outage straight on, and in one that turns."""
    folder.mkdir(exist_ok=True)
    (sheet,) = re.findall(
        r"(?ms)^# imu.yaml\n(.*?)^```$", (HERE / "aided.md").read_text("utf-8")
    )
    for name, mission in OUTAGES.items():
        found = budget.analyze(
            yaml.safe_load(sheet),
            mission=mission,
            calibration="factory",
            validate=False,
        )
        taken = budget.load_mission(mission)
        grown = curve(question_of(found), drawn_times(taken, taken.at))
        write(growth_pictures(grown)[0].svg, folder / f"{name}.svg")


def row(name: str, plan: budget.Procedure) -> str:
    """Return what a scheme adds to the paper's unit, a row of the table."""
    result = budget.analyze(
        budget.load_device("zhao-2019"),
        procedure=plan,
        reference="as_tested",
        validate=False,
    )
    found = {group.title: group.widest.expanded.text for group in group_tables(result)}
    cells = [found.get(title, "-") for title in GROUPS]
    lasts = max(
        end_of(plan, kind)
        for kind in ("gyro", "accelerometer")
        if calibrates(kind, plan)
    )
    return line([f"[`{name}`](schemes/{name}.svg)", f"{lasts / 60.0:.3g}", *cells])


def line(cells: Sequence[str]) -> str:
    """Return a row of a table."""
    return f"| {' | '.join(cells)} |"


def end_of(plan: budget.Procedure, kind: str) -> float:
    """Return when the last window of a triad ends [s]."""
    return max(window.end for window in schedule_of(kind, plan).windows)


def source_of(name: str) -> str:
    """Return what the comment at the head of a shipped file says."""
    text = (shipped("specs") / "procedures" / f"{name}.yaml").read_text("utf-8")
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines)


def write(svg: str, path: Path) -> None:
    """Write a picture on its own paper: a page may be dark, the labels are too."""
    paper = f'<rect width="100%" height="100%" fill="{PAPER}"/>'
    path.write_text(re.sub(r"(<svg\b[^>]*>)", rf"\1{paper}", svg), encoding="utf-8")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
