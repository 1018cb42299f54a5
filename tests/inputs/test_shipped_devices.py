"""The shipped devices, figure by figure, against a sourced list of what is printed."""

from __future__ import annotations

import copy
import math
from collections import Counter
from functools import cache

import pytest
import yaml
from numpy.testing import assert_allclose
from places import DOCS, ROOT, TESTS

import budget
from budget.inputs import load_device, load_requirement, variants
from budget.model.sources import SENSORS, lines_of
from budget.units import UnitError, parse_quantity

DEVICES = ROOT / "specs" / "devices"
CATALOGUE = DOCS / "catalogue.md"
ELSEWHERE = {"zhao-2019"}  # the paper's device: its numbers are held by other tests

FILES = sorted(p for p in DEVICES.glob("*.yaml") if p.stem not in ELSEWHERE)
REFS = [
    f"{path.stem}#{name}" if name else path.stem
    for path in FILES
    for name in variants(path.stem)
]
# A spelling that the reader does not know, and the one that stands for it.
READ_AS = {"deg/Hr": "deg/hr", "mG": "mg", "µG/√Hz": "µg/√Hz", "G": "g"}
RANGES = {"gyro.range": "gyro.range", "accel.range": "accelerometer.range"}
LIKE = {f"{s}.{line.name}": line.like(s) for s in SENSORS for line in lines_of(s)}
LIKE |= {"gravity_unit": "m/s^2", "gyro.range": "deg/s", "accelerometer.range": "g"}
CONSTANTS = (
    *("repeatability", "nonlinearity", "asymmetry", "quadratic", "g_sensitivity"),
    *("temperature_coefficient", "over_temperature"),
    *("initial_bias", "initial_scale_factor", "initial_mounting"),
)
SIGMA = "\N{GREEK SMALL LETTER SIGMA}"


@cache  # of several variants, and not before a test asks
def read(path):
    """Return the values of a YAML file, numbers as they are written."""
    return yaml.BaseLoader(path.read_text(encoding="utf-8")).get_single_data()


SOURCED = TESTS / "data" / "datasheets.yaml"
COLUMNS = ("parameter", "value", "unit", "words", "source", "place")


def rows_of(ref):
    """Return the sourced rows of one device; a row is a mapping."""
    return [
        dict(zip(COLUMNS, row, strict=True))
        for entry in read(SOURCED)["devices"]
        if ref in entry["files"]
        for row in entry["figures"]
    ]


def laid_over(base, over):
    """Return a mapping with another laid over it; a list replaces a list."""
    if not isinstance(base, dict) or not isinstance(over, dict):
        return over
    return {
        key: laid_over(base[key], over[key])
        if key in base and key in over
        else over.get(key, base.get(key))
        for key in {**base, **over}
    }


@cache
def raw(ref):
    """Return what the file says of one device, variant over base, nothing read."""
    stem, _, variant = ref.partition("#")
    base = dict(read(DEVICES / f"{stem}.yaml"))
    found = base.pop("variants", {})
    return laid_over(base, found[variant]) if variant else base


def measured(place, text):
    """Return a figure of a model line in SI, with the size of its unit."""
    number, _, unit = text.partition(" ")
    quantity = parse_quantity(f"{number} {READ_AS.get(unit, unit)}", LIKE[place])
    return quantity.value, quantity.si_per_unit


def lines_in(device):
    """Yield the model lines that a file gives, each with its place."""
    for sensor in SENSORS:
        for name, figure in device.get(sensor, {}).get("errors", {}).items():
            yield f"{sensor}.{name}", figure


def split(text):
    """Return the numbers of one range or of several that can be chosen, and the unit.

    '250, 500, 1000 dps', '15.625 to 2000 dps'.
    """
    numbers, _, unit = text.rpartition(" ")
    return numbers.replace(" to ", ", ").split(", "), unit


def said_by_file(device):
    """Return every figure of a file: place, figure, words and source."""
    for place, figure in lines_in(device):
        # A maker prints one figure for all axes; the other keys say how to take it.
        assert "axes" not in figure
        si = measured(place, figure["value"])
        yield place, si, figure.get("condition", ""), figure["source"]
    for figure in device.get("figures", ()):
        named = f"{figure['name']} {figure['value']}"
        yield "figures", named, figure.get("condition", ""), figure["source"]
    for key in ("mass", "power", "price"):
        for text in device[key].split("; ") if key in device else ():
            yield key, text
    for sensor, given in device.get("range", {}).items():
        figure = {"value": given} if isinstance(given, str) else given
        numbers, unit = split(figure.get("options", figure["value"]))
        assert figure["value"] in {f"{number} {unit}" for number in numbers}
        place = f"{sensor}.range"
        si = [measured(place, f"{number} {unit}") for number in numbers]
        yield place, *si, figure.get("condition", "")
    if "gravity_unit" in device:
        yield "gravity_unit", measured("gravity_unit", device["gravity_unit"])


def said_by_makers(rows):
    """Return every sourced figure in the form of `said_by_file`."""
    for row in rows:
        figure = f"{row['value']} {row['unit']}"
        title = read(SOURCED)["sources"][row["source"]]["title"]
        for place in row["place"].split(" + "):
            if place == "figures":
                named = f"{row['parameter']} {figure}"
                yield place, named, row["words"], title
            elif place == "range":
                numbers, unit = split(figure)
                where = RANGES[row["parameter"]]
                # Both signs are meant by a range, and options stand by themselves.
                words = row["words"].lstrip("±, ;").removeprefix("options").strip()
                words = words[1:-1] if words.startswith("(") else words
                si = [measured(where, f"{number} {unit}") for number in numbers]
                yield where, *si, words
            elif place == "gravity_unit":
                yield place, measured(place, figure)
            elif place in LIKE:
                words = row["words"]
                if place.endswith("initial_mounting") and row["unit"] == "%":
                    # What crosses an axis is the sine of an angle: 1 % of 10 mrad.
                    words = f"{figure}, {words}" if words else figure
                    figure = f"{10.0 * float(row['value']):g} mrad"
                yield place, measured(place, figure), words, title
            else:
                words = f" ({row['words']})" if row["words"] else ""
                # The words may hold a '; ' of their own, as the text in the file may.
                yield from ((place, part) for part in f"{figure}{words}".split("; "))


def differences(device, rows):
    """Return what only the file says and what only the makers say."""
    file, makers = Counter(said_by_file(device)), Counter(said_by_makers(rows))
    return {"file": file - makers, "makers": makers - file}


def test_a_file_says_what_its_makers_print_and_no_more():
    """Each figure is in the sourced list with its words; each sourced one is here."""
    assert [ref for ref in REFS if not rows_of(ref)] == []
    found = {ref: differences(raw(ref), rows_of(ref)) for ref in REFS}
    assert {ref: both for ref, both in found.items() if any(both.values())} == {}


@pytest.mark.parametrize(
    ("ref", "place", "printed", "changed"),
    [
        ("hg4930#C", "gyro.bias_repeatability", "7 °/hr", "8 °/hr"),
        ("hg4930#C", "gyro.bias_repeatability", "7 °/hr", "7 °/s"),
        ("stim300#30g", "accelerometer.bias_repeatability", "4 mg", "1.9 mg"),
        ("ltm210#S10", "gyro.bias_stability", "0.3 °/h", "0.05 °/h"),
        ("jdsj25tk01#01", "accelerometer.bias_repeatability", "10 µg", "10.001 µg"),
    ],
)
def test_a_changed_line_is_caught(ref, place, printed, changed):
    """Control: one digit or unit of a line changed is one figure too many, one less."""
    device = copy.deepcopy(raw(ref))
    sensor, line = place.split(".")
    assert device[sensor]["errors"][line]["value"] == printed
    device[sensor]["errors"][line]["value"] = changed
    found = differences(device, rows_of(ref))
    assert [entry[0] for entry in found["file"]] == [place]
    assert [entry[0] for entry in found["makers"]] == [place]


def test_a_changed_added_or_lost_figure_is_caught():
    """Control: a printed text changed, a figure invented and one left out all show."""
    rows = rows_of("bjgm25n01")
    device = copy.deepcopy(raw("bjgm25n01"))
    device["figures"][0]["value"] = "5 mg"
    assert len(differences(device, rows)["file"]) == 1
    device = copy.deepcopy(raw("bjgm25n01"))
    del device["figures"][0]
    assert len(differences(device, rows)["makers"]) == 1
    device = copy.deepcopy(raw("bjgm25n01"))
    line = {"value": "10 µg", "source": "GNC-Tech catalogue befaf88"}
    device["accelerometer"]["errors"]["bias_stability"] = line
    assert len(differences(device, rows)["file"]) == 1


def test_a_spelling_is_no_change_and_another_unit_is():
    """Control: urad for μrad is the same figure, 0.75 mrad is not as printed."""
    place = "gyro.mounting_repeatability"
    printed = measured(place, "750 μrad")
    assert measured(place, "750 urad") == printed
    assert measured(place, "0.75 mrad") != printed
    with pytest.raises(UnitError):
        measured(place, "750 ppm")


def test_the_sourced_list_names_the_files_and_no_others():
    """Every device of the list is a file or variant that is there, and the reverse."""
    listed = {ref for entry in read(SOURCED)["devices"] for ref in entry["files"]}
    assert listed == set(REFS)


def test_every_source_is_known_and_used():
    """Each row names a document of the list, and no document is there for nothing."""
    named = {row[4] for entry in read(SOURCED)["devices"] for row in entry["figures"]}
    assert named == set(read(SOURCED)["sources"])
    for source in read(SOURCED)["sources"].values():
        assert source["kind"] in {"primary", "vendor-copy", "derived"}
        assert source["document"]


def test_a_second_hand_source_says_so_in_the_file():
    """What another text quotes of a data sheet is called derived, and only that."""
    kinds = {s["title"]: s["kind"] for s in read(SOURCED)["sources"].values()}
    for ref in REFS:
        device = raw(ref)
        lines = [line for _, line in lines_in(device)]
        used = {kinds[f["source"]] for f in [*lines, *device.get("figures", ())]}
        assert ("(derived)" in device["source"]) == ("derived" in used), ref


def test_the_catalogue_page_counts_its_devices():
    """docs/catalogue.md prints how many files and devices of each kind there are."""
    kinds = {}
    for entry in read(SOURCED)["devices"]:
        kinds.update(dict.fromkeys(entry["files"], entry["kind"]))
    count = Counter(kinds.values())
    assert set(count) == {"gyro", "imu", "accelerometer"}
    assert len(kinds) >= 80
    assert (
        f"{len(FILES)} files, {len(kinds)} devices with their variants: "
        f"{count['imu']} IMUs, {count['gyro']} gyros, "
        f"{count['accelerometer']} accelerometers."
    ) in CATALOGUE.read_text(encoding="utf-8")


def meaning_of(place, words):
    """Return the meaning that docs/catalogue.md gives to the words of a maker."""
    if f"3{SIGMA}" in words:
        return "3 sigma"
    if f"1{SIGMA}" in words or "1-sigma" in words or "runs" in words:
        return "1 sigma"
    if "nominal" in words or "typical" in words:
        return "typical"
    if place.endswith("over_temperature") and "rms" in words.lower():
        return "rms"
    bounds = ("≤", "<", "±", "maximum", "1 %, ±", "DC gravity; contains")
    is_bound = words.startswith(bounds) and words.split(";")[0] != "±1 g condition"
    if is_bound or place.endswith("nonlinearity"):
        return "max"
    return "typical" if place.endswith(CONSTANTS) else "1 sigma"


@cache
def all_lines():
    """Return every line of every device: device, place, what the file says."""
    return [(ref, place, line) for ref in REFS for place, line in lines_in(raw(ref))]


def test_meaning_and_definition_follow_the_rules():
    """A line says how to take its figure exactly as the rules on its words say."""
    assert all_lines()
    for ref, place, figure in all_lines():
        words = figure.get("condition", "")
        assert figure["meaning"] == meaning_of(place, words), (ref, place)
        lowest = "Allan" in words and "DIVIDED" not in words
        if place.endswith("bias_stability"):
            expected = "allan_minimum" if lowest else "sigma"
            assert figure.get("definition", "sigma") == expected, (ref, place)


def test_both_figures_of_a_maker_decide_the_sides_of_a_density():
    """MS1010 prints the rms in 1 Hz too, D sqrt(1 Hz): one-sided, so N is D/sqrt(2)."""
    device = raw("ms1000#MS1010")
    (band,) = [f for f in device["figures"] if f["name"] == "accel.resolution"]
    assert (band["value"], band["condition"]) == ("34 μg rms", "in 1 Hz, typical")
    line = load_device("ms1000#MS1010").accelerometer.line("velocity_random_walk")
    assert line.density == device["accelerometer"]["errors"][line.name]["density"]
    assert line.density == "one-sided"
    assert_allclose(line.u, 34e-6 * 9.80665 / math.sqrt(2.0), rtol=1e-14)


@pytest.mark.parametrize(
    ("ref", "rms", "band"),
    [
        ("bmi088", "0.1", 47.0),
        ("icm-42688-p", "0.028", 100.0),
        ("mpu-6050", "0.05", 100.0),
        ("mpu-6500", "0.1", 92.0),
        ("mpu-9250", "0.1", 92.0),
        ("mpu-9255", "0.1", 92.0),
    ],
)
def test_a_density_and_the_rms_of_a_band_decide_its_sides(ref, rms, band):
    """One-sided rms = D sqrt(B) is what is printed; two-sided, D sqrt(2 B), is not."""
    figures = [one for one in raw(ref)["figures"] if one["value"].startswith(f"{rms} ")]
    assert any(f"{band:g} Hz" in one["condition"] for one in figures)
    line = load_device(ref).gyro.line("angle_random_walk")
    D = float(line.printed.split()[0])  # deg/s/sqrt(Hz)
    printed = float(rms)
    last = 10.0 ** -len(rms.partition(".")[2])
    assert_allclose(D * math.sqrt(band), printed, rtol=0, atol=last / 2)
    assert abs(D * math.sqrt(2.0 * band) - printed) > last / 4
    assert line.density == "one-sided"
    assert not line.readings


def test_nothing_is_invented():
    """No correlation time, no shape and no nominal value: no maker here prints one."""
    printed = {
        *("value", "meaning", "definition", "density", "includes", "horizon"),
        *("condition", "source"),
    }
    sensors = [(ref, raw(ref).get(sensor, {})) for ref in REFS for sensor in SENSORS]
    assert [ref for ref, sensor in sensors if "nominal" in sensor] == []
    assert [where for *where, line in all_lines() if not line.keys() <= printed] == []


def test_what_a_figure_includes_is_no_line_beside_it():
    """A scale-factor repeatability that holds the nonlinearity stands without it."""
    given = {(ref, place) for ref, place, _ in all_lines()}
    holding = [
        (ref, f"{place.split('.', maxsplit=1)[0]}.scale_factor_nonlinearity")
        for ref, place, line in all_lines()
        if "nonlinearity" in line.get("includes", "")
    ]
    assert holding
    assert [one for one in holding if one in given] == []


def test_the_known_contradictions_stand_in_the_files():
    """LTM210S10 prints two bias instabilities; ADXL357 two noise densities."""
    names = {f["name"]: f["value"] for f in raw("ltm210#S10")["figures"]}
    assert names["gyro.bias_instability_comparison_table"] == "0.05 °/h"
    assert "0.3 °/h" in raw("ltm210#S10")["notes"]
    names = {f["name"]: f["value"] for f in raw("adxl357")["figures"]}
    assert names["accel.noise_density"] == "80 µg/√Hz"


@pytest.mark.slow
def test_every_device_loads_and_has_a_budget():
    """Each file and variant is read, and every output of it has a finite spread."""
    for ref in REFS:
        device = load_device(ref)
        assert device.sensors, ref
        assert all(sensor.lines for sensor in device.sensors), ref
        assert device.source, ref
        assert device.vendor, ref
        result = budget.analyze(device, validate=False)
        assert all(math.isfinite(o.standard_uncertainty) for o in result.outputs), ref


def utilisation(ref, requirement, sensor):
    """Return the largest error over its limit among one sensor's outputs [1]."""
    limits = {limit.output: limit.limit for limit in requirement.limits}
    result = budget.analyze(
        load_device(ref),
        validate=False,
        reference=requirement.reference,
        coverage=requirement.coverage,
        environment="none",  # as the requirement says
    )
    return max(
        output.largest_error / limits[output.output.name]
        for output in result.outputs
        if output.sensor == sensor
    )


@pytest.mark.parametrize(
    ("ref", "sensor", "printed"),
    [
        ("hg4930#C", "gyro", "0.95"),
        ("hg4930#B", "gyro", "0.99"),
        ("hg4930#A", "gyro", "1.98"),
        ("hg4930#C", "accelerometer", "0.95"),
        ("stim300#10g", "accelerometer", "0.96"),
        ("hg4930#B", "accelerometer", "1.01"),
        ("dg068#10", "accelerometer", "1.32"),
        ("hg4930#A", "accelerometer", "1.51"),
    ],
)
def test_the_edge_requirement_lies_at_the_edge(ref, sensor, printed):
    """The utilisations that the file's comment prints are those of the linear law."""
    edge = load_requirement("catalogue-edge")
    assert abs(utilisation(ref, edge, sensor) - float(printed)) <= 0.01


def test_the_catalogue_page_has_a_row_for_every_device_file():
    """docs/catalogue.md names each file in its table."""
    text = CATALOGUE.read_text(encoding="utf-8")
    for path in FILES:
        assert f"| `{path.stem}` |" in text


def test_a_changed_range_is_caught():
    """Control: one digit of a range, or of what can be chosen, is not as printed."""
    device = copy.deepcopy(raw("bmi088"))
    device["range"]["gyro"]["options"] = "125, 250, 500, 1000, 2001 °/s"
    device["range"]["gyro"]["value"] = "2001 °/s"
    assert len(differences(device, rows_of("bmi088"))["file"]) == 1
    device["range"]["gyro"]["value"] = "1500 °/s"
    with pytest.raises(AssertionError, match="1500"):
        differences(device, rows_of("bmi088"))


FIRST = "_SEL=0"  # the first of the ranges that can be chosen, as TDK names it


def test_the_range_of_several_is_that_of_the_figures_or_the_largest():
    """Of ranges to choose from it is what the lines name, else the largest."""
    found = {}
    for ref in REFS:
        for sensor, given in raw(ref).get("range", {}).items():
            if "options" not in given:
                continue
            numbers, unit = split(given["options"])
            said = " ".join(
                figure.get("condition", "")
                for place, figure in lines_in(raw(ref))
                if place.startswith(sensor)
            )
            named = {n for n in numbers if f"±{n} {unit}" in said or f"RFS{n}" in said}
            if FIRST in said or "ACCEL_FS=0" in said:
                named.add(numbers[0])
            largest = max(named or numbers, key=float)
            if given["value"] != f"{largest} {unit}":
                found[ref] = given["value"]
    # By the name of the part, and by the mode that the file is of.
    assert found == {"adis16495-1": "125 °/sec", "sca3300-d01": "1.5 g"}
