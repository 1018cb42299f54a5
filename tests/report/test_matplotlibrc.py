"""A matplotlibrc, in the current folder or the user's, changes no byte of a page."""

from __future__ import annotations

import ast
import os
from inspect import getsource

import pytest
from failing import run, run_here, run_warm
from matplotlib import rc_params_from_file, rcParamsDefault
from places import SHIPPED, put

from budget.report.figures.tabled import Plot

# `text.usetex` starts a program; the others change what is drawn, and where.
HOSTILE = """\
text.usetex: True
svg.hashsalt: other
font.family: serif
font.size: 31
mathtext.fontset: stix
text.color: red
text.parse_math: False
lines.linewidth: 7
lines.marker: o
patch.edgecolor: red
patch.force_edgecolor: True
hatch.linewidth: 5
hatch.color: red
path.sketch: 3, 100, 2
axes.grid: True
axes.facecolor: black
axes.edgecolor: red
axes.xmargin: 0.4
axes.labelcolor: red
axes.unicode_minus: False
axes.formatter.limits: 0, 1
axes.prop_cycle: cycler('color', ['red', 'lime'])
xtick.color: red
xtick.direction: in
xtick.minor.visible: True
ytick.labelright: True
figure.dpi: 33
figure.facecolor: black
figure.autolayout: True
figure.constrained_layout.use: True
savefig.dpi: 33
savefig.bbox: tight
savefig.pad_inches: 3
"""
DEVICE = "name: One\ngyro: {errors: {bias_repeatability: 0.1 deg/h}}\n"
REPORT = (
    *("report", "one.yaml", "--no-validate", "--requirement", "tactical-grade"),
    *("--allocate", "--compare", "adxrs453", "-o", "out.html"),
)


def reported(folder, make=run_here, **made):
    """Make the report in a folder; return the outcome and the page."""
    (folder / "one.yaml").write_text(DEVICE, encoding="utf-8")
    outcome = make(*REPORT, folder=folder, SOURCE_DATE_EPOCH="0", **made)
    return outcome, (folder / "out.html").read_bytes()


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    """Return the outcome and the page of this process, where no file is obeyed."""
    return reported(tmp_path_factory.mktemp("clean"))


@pytest.mark.slow
def test_a_matplotlibrc_of_the_user_changes_no_byte(tmp_path, clean):
    """The page is that of this process without one; a control in the second test.

    Of one in the current folder that is asked by test_wheel, of other commands.
    """
    config = tmp_path / "config"
    config.mkdir()
    (config / "matplotlibrc").write_text(HOSTILE, encoding="utf-8")
    outcome, page = reported(tmp_path, run_warm, MATPLOTLIBRC=str(config))
    assert outcome.returncode in {0, 1}, outcome
    assert page == clean[1]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX systems")
def test_no_setting_of_the_drawing_library_ends_a_report(tmp_path, clean):
    """A notebook's backend, a file that is none or a pipe: the same page, no word more.

    A pipe in the current folder would be waited for, for ever.
    """
    folder, broken = tmp_path / "here", tmp_path / "broken"
    folder.mkdir()
    broken.write_bytes(b"axes.grid: maybe\nnokey: \xff\n")
    os.mkfifo(folder / "matplotlibrc")
    outcome, page = reported(
        folder,
        run,
        MPLBACKEND="module://matplotlib_inline.backend_inline",
        MATPLOTLIBRC=str(broken),
        MPLCONFIGDIR="/proc/none",
    )
    assert outcome.returncode == clean[0].returncode, outcome
    assert outcome.stderr == b"out.html: written\n"
    assert page == clean[1]


def test_every_line_of_the_hostile_file_is_one_that_the_library_obeys(tmp_path):
    """The control: each is read, and is not what the library would do without."""
    file = put(tmp_path / "matplotlibrc", HOSTILE)
    read = rc_params_from_file(file, use_default_template=False)
    assert len(read) == len(HOSTILE.splitlines())
    for name, value in read.items():
        assert value != rcParamsDefault[name], name


def test_every_function_that_draws_does_so_in_the_house_style():
    """A figure that is added cannot forget it.

    But for those that hand on what another one of these has drawn, and draw nothing,
    and those that a plot has drawn: it does so in the style.
    """
    drawing = {
        (file.name, node.name): node
        for file in SHIPPED
        if "matplotlib" in (text := file.read_text(encoding="utf-8"))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef)
        and node.name != "blank"  # makes a sheet; who calls it draws
        and isinstance(node.returns, ast.Name)
        and node.returns.id == "Figure"
    }
    assert len(drawing) > 5
    assert "with house_style():" in getsource(Plot.figure.fget)
    by_plots = {("tabled.py", "figure")} | {
        (file.name, node.value.body.func.id)
        for file in SHIPPED
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.keyword) and node.arg == "draw"
        if isinstance(getattr(node.value, "body", None), ast.Call)
        if isinstance(node.value.body.func, ast.Name)
    }
    names = {name for _, name in drawing}
    for place in drawing.keys() - by_plots:
        node = drawing[place]
        looks = [ast.unparse(one) for one in node.decorator_list]
        assert "house_style()" in looks or hands_on(node, names), place
    bare = "def f() -> Figure:\n    sheet = blank()\n    return sheet\n"
    assert not hands_on(ast.parse(bare).body[0], names)  # the control


def hands_on(function, names):
    """Say whether all that a function returns is what one of those names returns."""
    found = [node.value for node in ast.walk(function) if isinstance(node, ast.Return)]
    return bool(found) and all(
        (
            isinstance(one, ast.Call)
            and ast.unparse(one.func).removeprefix("self.") in names
        )
        or (isinstance(one, ast.Attribute) and one.attr == "figure")
        for one in found
    )
