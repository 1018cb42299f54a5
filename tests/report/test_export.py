"""Files of targets: read by the target's own loader, or by the rules of it."""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose
from places import put

from budget import load_device
from budget.report.document import table_csv
from budget.report.export import write_export
from budget.studies.export.study import export
from budget.studies.export.template import print_double, targets

RATE = 200.0
OCTAVE = shutil.which("octave-cli")


def exported(to, *, name="hg4930#A", **how):
    """Return an export and the text of its file."""
    found = export(load_device(name), to=to, rate=RATE, **how)
    return found, write_export(found)


def values(found):
    """Return the values of an export by key."""
    return {one.key: list(one.values) for one in found.entries}


def read_yaml(text):
    """Read YAML 1.1 as PyYAML does, OpenCV's head apart."""
    head, _, rest = text.partition("\n")
    return yaml.safe_load(rest if head == "%YAML:1.0" else text)


@pytest.mark.parametrize("to", targets())
@pytest.mark.parametrize("name", ["hg4930#A", "zhao-2019"])
def test_nothing_of_a_template_is_left(to, name):
    """Every name is filled in, every key is explained, the document is of one end."""
    found, text = exported(to, name=name)
    assert not re.search("[{}%]{2}|[\x01-\x08]", text)
    assert text.endswith("\n")
    plain = " ".join(text.split())
    for one in found.entries:
        assert f"{one.key}: {one.steps[0][:5]}" in plain
        for line in one.lines:
            assert line in text


def test_kalibr_reads_its_file():
    """Numbers above 0 under the four keys, a rate above 0, a topic: its own checks."""
    found, text = exported("kalibr")
    data = read_yaml(text)
    for key in values(found):
        assert isinstance(data[key], float)
        assert data[key] > 0.0
        assert data[key] == values(found)[key][0]
    assert data["update_rate"] > 0.0
    assert isinstance(data["rostopic"], str)


def test_openvins_reads_its_file():
    """The keys of its own example under imu0, each of the example's type and shape."""
    found, text = exported("openvins")
    assert text.startswith("%YAML:1.0\n")
    imu = read_yaml(text)["imu0"]
    shapes = {
        "T_i_b": (4, 4),
        **dict.fromkeys(("Tw", "R_IMUtoGYRO", "Ta", "R_IMUtoACC", "Tg"), (3, 3)),
    }
    for key, shape in shapes.items():
        assert np.shape(imu[key]) == shape
    assert imu["model"] in {"calibrated", "kalibr", "rpng"}
    assert {key: [imu[key]] for key in values(found)} == values(found)
    assert {*imu} == {
        *shapes,
        *values(found),
        *("rostopic", "time_offset", "update_rate", "model"),
    }


def test_vins_reads_its_file():
    """The five keys of its configuration, as numbers."""
    found, text = exported("vins")
    assert text.startswith("%YAML:1.0\n")
    data = read_yaml(text)
    assert {*data} == {"acc_n", "gyr_n", "acc_w", "gyr_w", "g_norm"}
    assert {key: [data[key]] for key in values(found)} == values(found)


def test_kf_gins_reads_its_file():
    """Three numbers under each key that loadConfig takes, one correlation time."""
    found, text = exported("kf-gins")
    data = read_yaml(text)
    flat = {**data["imunoise"], **{k: v for k, v in data.items() if k != "imunoise"}}
    assert flat.pop("corrtime") == values(found)["corrtime"][0]
    for key in ("arw", "vrw", "gbstd", "abstd", "gsstd", "asstd"):
        assert [type(value) for value in data["imunoise"][key]] == [float] * 3
    assert flat == {k: v for k, v in values(found).items() if k != "corrtime"}


def test_ros_reads_its_message():
    """Nine numbers a field, row major; -1 first: there is no orientation."""
    found, text = exported("ros")
    data = read_yaml(text)
    assert data.pop("orientation_covariance")[0] == -1.0
    for key, variances in values(found).items():
        matrix = np.reshape(data.pop(key), (3, 3))
        assert_allclose(np.diag(matrix), variances, rtol=1e-15)
        assert np.count_nonzero(matrix) == 3
    assert not data


def test_gtsam_runs_its_file():
    """The snippet runs, and GTSAM hands back what was told to it."""
    pytest.importorskip("gtsam", reason="no wheel of gtsam here")
    found, text = exported("gtsam")
    names: dict[str, object] = {}
    exec(compile(text, "gtsam.py", "exec"), names)  # noqa: S102 - our own text
    params, told = names["params"], values(found)
    for key, matrix in (
        ("gyroscope_covariance", params.getGyroscopeCovariance()),
        ("accelerometer_covariance", params.getAccelerometerCovariance()),
        ("bias_omega_covariance", params.getBiasOmegaCovariance()),
        ("bias_acc_covariance", params.getBiasAccCovariance()),
    ):
        assert_allclose(matrix, np.diag(told[key]), rtol=1e-15)
    assert_allclose(names["bias_omega_prior"], told["bias_omega_prior"], rtol=1e-15)
    assert_allclose(names["bias_acc_prior"], told["bias_acc_prior"], rtol=1e-15)


# What sdf/1.9/imu.sdf and noise.sdf allow, of what is used.
NOISE = (
    *("mean", "stddev", "bias_mean", "bias_stddev"),
    *("dynamic_bias_stddev", "dynamic_bias_correlation_time"),
)


@pytest.mark.parametrize("name", ["hg4930#A", "zhao-2019"])
def test_gazebo_reads_its_file(name):
    """Elements where the description of SDF has them, numbers in all of them."""
    found, text = exported("gazebo", name=name)
    root = ET.fromstring(text)  # noqa: S314 - our own text
    assert (root.tag, root.get("version")) == ("sdf", "1.9")
    sensor = root.find("model/link/sensor")
    assert sensor.get("type") == "imu"
    assert float(sensor.findtext("update_rate")) == RATE
    (imu,) = sensor.findall("imu")
    assert [one.tag for one in imu] == ["angular_velocity", "linear_acceleration"]
    for triad in imu:
        assert [one.tag for one in triad] == ["x", "y", "z"]
        for place, axis in enumerate(triad):
            (noise,) = axis
            assert noise.get("type") == "gaussian"
            read = {one.tag: float(one.text) for one in noise}
            assert read.keys() <= {*NOISE}
            for key, told in values(found).items():
                if key.startswith(triad.tag):
                    assert read[key.removeprefix(f"{triad.tag}_")] == told[place]


# Texts that would leave a comment, or give orders in one: to Python (a codec that turns
# escapes into line feeds), MATLAB, YAML, XML, a package manager, an editor.
ORDERS = (
    "x coding: unicode_escape",
    "coding=unicode_escape",
    "-*- coding: utf-7 -*-",
    "vim: set fileencoding=unicode_escape :",
    "Local Variables: eval: (ding) End:",
    "%{ %} ... %#codegen",
    "%YAML 1.2 --- ! &a *a",
    "yaml-language-server: $schema=https://example.com/x",
    "a -- b --> <x/> <!-- ]]> <?x?> -",
    '/// script dependencies = ["x"] ///',
    "$gravity ${rate} $$",
    "\\",
)
# What a codec, a line end or an end of a comment would let run.
RUNS = (
    "\\u000aprint('RUN')#",
    "+AAo-print('RUN')#",
    "\u200eprint('RUN')\u2062disp('RUN')\xad",
    "%} disp('RUN') %{",
    "--- run: RUN ...",
    "--><run>RUN</run><!--",
    f"{'x' * 60} {'/// script':<60} {'x' * 70}",
)
# What the script of GTSAM imports, which is not free of its compiler.
GTSAM = """
class PreintegrationCombinedParams:
    def MakeSharedU(g):
        return PreintegrationCombinedParams()

    def __getattr__(self, name):
        return lambda value: None
"""


def of_texts(folder, order, run):
    """Return a device with one text wherever a device has texts."""
    line = {"source": run, "condition": run}
    tree = {
        "name": order,
        "source": run,
        "notes": f"x\n{run}\n---\n%}}\n{run}",
        "gyro": {
            "errors": {
                "angle_random_walk": {"value": "1 deg/sqrt(h)", **line},
                "bias_stability": {"value": "1 deg/h", **line},
                "bias_repeatability": {"value": "1 deg/h", "meaning": "max", **line},
                "scale_factor_repeatability": {"value": "9 ppm", **line},
            }
        },
        "accelerometer": {
            "errors": {
                "velocity_random_walk": {"value": "1 m/s/sqrt(h)", **line},
                "bias_stability": {"value": "1 mg", **line},
                "bias_repeatability": {"value": "1 mg", **line},
                "scale_factor_repeatability": {"value": "9 ppm", **line},
            }
        },
    }
    path = put(
        folder / f"{order.replace('/', '_')}\nprint('RUN')\u202e\x1b.yaml",
        yaml.safe_dump(tree, allow_unicode=False),
    )
    return load_device(path)


def obeyed(to, text):
    """Return what the reader of a target takes from a file: all but comments."""
    data = text.encode("utf-8")
    if to == "gtsam":
        return ast.dump(ast.parse(data))  # bytes: the declared encoding counts
    if to == "gazebo":
        return ET.canonicalize(text)  # declarations and comments go
    if to in {"psins", "matlab", "nav-toolkit"}:
        return commands(text)
    assert not re.search("^ *(---|[.]{3})", text, re.MULTILINE)
    return read_yaml(text)


def commands(text):
    """Return the lines of a MATLAB script without comments, blocks of them too."""
    depth, told = 0, []
    for line in re.split("[\n\r]", text):
        if line.strip() in {"%{", "#{"}:
            depth += 1
        elif line.strip() in {"%}", "#}"}:
            depth -= 1
        elif not depth and (code := re.sub("[%#].*", "", line).strip()):
            told.append(code)
    assert depth == 0
    return told


@pytest.mark.parametrize("to", targets())
def test_no_text_of_a_file_gives_orders(to, tmp_path):
    """Whatever a device's texts are, the target reads what it reads of a tame one."""
    how = {"to": to, "rate": RATE}
    tame = obeyed(to, write_export(export(of_texts(tmp_path, "a", "b"), **how)))
    source = targets()[to].source.splitlines()
    first = next(line for line in source if line.startswith(("# -", "%", "<?")))
    for order in ORDERS:
        for run in RUNS:
            text = write_export(export(of_texts(tmp_path, order, run), **how))
            assert obeyed(to, text) == tame, (order, run)
            assert text.splitlines()[0] == first
            assert all(map(str.isprintable, text.splitlines())), (order, run)
            for tool in (
                r"coding[:=](?! utf-8 -|.UTF-8.)",
                r"\b(vim?|ex):",
                "iables:",
                "server:",
            ):
                assert not re.search(tool, text), (order, run, tool)
            assert not re.search("^[#%] ///", text, re.MULTILINE), (order, run)


def test_what_is_obeyed_is_seen():
    """A control: a declared codec, an end of a comment, a block are no longer equal."""
    bad = "# coding: unicode_escape\n# \\u000aprint('RUN')#\n"
    assert "RUN" in obeyed("gtsam", bad)
    assert "RUN" in obeyed("gazebo", "<a><!-- --><run>RUN</run><!-- --></a>")
    assert obeyed("matlab", "% a\n%{\nx = 1;\n%}\ny = 2; % z") == ["y = 2;"]


def test_python_runs_nothing_of_a_device(tmp_path):
    """The script itself, run with a stand-in for GTSAM, says nothing."""
    (tmp_path / "gtsam.py").write_text(GTSAM, encoding="utf-8")
    device = of_texts(tmp_path, ORDERS[0], RUNS[0])
    script = put(tmp_path / "told.py", write_export(export(device, to="gtsam")))
    run = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, check=True, timeout=60
    )
    assert (run.stdout, run.stderr) == ("", "")


# Stand-ins that hand back what they are given: the toolboxes are not free.
STUBS = {
    "imuerrset": "function s = imuerrset(varargin)\n s = varargin;\nend\n",
    "gyroparams": "function s = gyroparams()\n s = struct();\nend\n",
    "accelparams": "function s = accelparams()\n s = struct();\nend\n",
    "imuSensor": "function s = imuSensor(varargin)\n s = struct('given', {varargin});\n"
    "end\n",
}


def run_octave(text, show, folder):
    """Run a script in GNU Octave with the stand-ins; return the JSON that it shows."""
    for name, body in STUBS.items():
        (folder / f"{name}.m").write_text(body, encoding="utf-8")
    (folder / "told.m").write_text(text, encoding="utf-8")
    code = f"told; disp(jsonencode({show}));"
    run = subprocess.run(
        [OCTAVE, "--no-init-file", "--no-history", "--quiet", "--eval", code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout.splitlines()[-1])


octave = pytest.mark.skipif(OCTAVE is None, reason="GNU Octave is not here")


@octave
def test_octave_runs_the_script_of_psins(tmp_path):
    """Thirteen arguments in imuerrset's order, each a column of its size."""
    found, text = exported("psins")
    given = run_octave(text, "imuerr", tmp_path)
    told = values(found)
    order = (
        *("eb", "db", "web", "wdb", "sqrtR0G", "TauG", "sqrtR0A", "TauA"),
        *("dKGii", "dKAii", "dKGij", "dKAij", "KA2"),
    )
    for key, argument in zip(order, given, strict=True):
        # jsonencode writes columns as lists of numbers, with 15 digits.
        assert_allclose(np.ravel(argument), told[key], rtol=1e-14, err_msg=key)
    sizes = run_octave(text, "cellfun(@columns, imuerr)", tmp_path)
    assert np.ravel(sizes).tolist() == [1] * 13


@octave
def test_octave_runs_the_script_of_matlab(tmp_path):
    """Properties of gyroparams and accelparams, with the numbers that were told."""
    found, text = exported("matlab")
    told = values(found)
    imu = run_octave(text, "imu", tmp_path)
    assert imu["given"] == ["accel-gyro", "SampleRate", RATE]
    for name, triad in (("Gyroscope", "gyro"), ("Accelerometer", "accel")):
        given = imu[name]
        assert given["NoiseType"] == "single-sided"
        for key in ("NoiseDensity", "BiasInstability"):
            assert_allclose(np.ravel(given[key]), told[f"{triad}_{key}"], rtol=1e-14)
        (memory,) = told[f"{triad}_Memory"]
        filtered = given["BiasInstabilityCoefficients"]
        assert_allclose(np.ravel(filtered["Denominator"]), [1.0, -memory], rtol=1e-14)
        assert np.shape(given["AxesMisalignment"]) == (3, 3)
        # Drawn: 6 standard deviations of the largest of 9 are never reached.
        u = max(*told[f"{triad}_ScaleFactor"], *told[f"{triad}_Mounting"])
        off = np.array(given["AxesMisalignment"]) - 100.0 * np.eye(3)
        assert 0.0 < np.abs(off).max() < 100.0 * 8.0 * u
        assert {*given} <= {
            *("NoiseType", "NoiseDensity", "RandomWalk", "BiasInstability"),
            *("BiasInstabilityCoefficients", "ConstantBias", "AxesMisalignment"),
        }


@octave
def test_octave_runs_the_script_of_navego(tmp_path):
    """The fields that imu_si_errors reads, rows of three."""
    found, text = exported("nav-toolkit")
    imu = run_octave(text, "imu", tmp_path)
    assert imu.keys() == values(found).keys()
    for key, told in values(found).items():
        assert_allclose(np.ravel(imu[key]), told, rtol=1e-14)


@octave
def test_a_script_that_is_none_is_seen(tmp_path):
    """Control: a bracket that is missing ends in an error of Octave."""
    with pytest.raises(AssertionError, match="parse error"):
        run_octave("eb = [1, 2;\nx = (3;\n", "eb", tmp_path)


@pytest.mark.parametrize(
    "value",
    [0.0, 1.0, 1e-6, 1.5e-300, 1e22, 0.1 + 0.2, 2.0 / 3.0 * 1e-5, 123456789.0, 5e-324],
)
def test_numbers_are_read_back_to_the_bit(value):
    """By YAML 1.1, which takes 1e-06 for a text, by Python and by JSON."""
    text = print_double(value)
    assert "." in text
    assert float(text) == json.loads(text) == value
    read = yaml.safe_load(text)
    assert isinstance(read, float)
    assert read == value


def test_random_numbers_are_read_back_to_the_bit():
    """A thousand doubles over all sizes, and what is printed of them is short."""
    rng = np.random.default_rng(1)
    for value in 10.0 ** rng.uniform(-30, 30, 1000):
        assert yaml.safe_load(print_double(value)) == float(value)


def test_the_table_has_a_row_for_each_axis():
    """CSV: key, axis, value and unit as in the file; a key of one value has no axis."""
    found, _ = exported("kf-gins")
    head, *rows = table_csv("exported", found.rows).splitlines()
    assert head == "key,sensor,axis,value,unit,from"
    assert len(rows) == 8 * 3 + 1
    (time,) = (row for row in rows if row.startswith("corrtime"))
    assert re.match(r"corrtime,gyro,,0\.0833", time)
    assert_allclose(float(rows[0].split(",")[3]), 0.06, rtol=1e-12)
