"""Recordings: every kind of file gives the same samples; what is unsound is found."""

from __future__ import annotations

import sys

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from pyarrow import parquet
from recorded import HEADS, short_log, write

from budget.errors import BudgetError, SpecError
from budget.inputs import load_recording, validate
from budget.inputs.recording import with_columns
from budget.recordings import tables
from budget.recordings.log import read_logs
from budget.recordings.noise import block_means
from budget.recordings.periodic import (
    periodic_lines,
    residual_spectrum,
    welch_spectrum,
)

DEG_PER_HOUR = np.pi / 180.0 / 3600.0
COLUMNS = ",".join(HEADS)


def read(path, **more):
    """Return the one log of a recording."""
    (log,) = read_logs(with_columns(load_recording(path), **more))
    return log


def as_parquet(path, values, heads=HEADS):
    """Write columns as a Parquet file."""
    columns = {head: values[:, k] for k, head in enumerate(heads)}
    parquet.write_table(pa.table(columns), path)
    return path


def test_all_kinds_of_files_are_one(tmp_path):
    """CSV, semicolons, tabs, blanks, a mark, CRLF, comments, .npy, .npz, Parquet."""
    values = np.round(short_log(), 4)
    wanted = read(write(tmp_path / "a.csv", values))
    blanks = write(tmp_path / "b.txt", values, sep=" ")
    crlf = write(tmp_path / "c.csv", values, end="\r\n")
    mark = tmp_path / "d.csv"
    mark.write_bytes(b"\xef\xbb\xbf" + crlf.read_bytes())
    comment = tmp_path / "e.csv"
    comment.write_bytes(b"# a lab\n# " + (tmp_path / "a.csv").read_bytes())
    np.save(tmp_path / "f.npy", values)
    np.savez(tmp_path / "g.npz", **{one: values[:, k] for k, one in enumerate(HEADS)})
    fields = np.rec.fromarrays(values.T, names=list(HEADS))
    np.save(tmp_path / "h.npy", fields)
    others = [
        read(write(tmp_path / "i.csv", values, sep=";")),
        read(write(tmp_path / "j.tsv", values, sep="\t")),
        read(blanks),
        read(crlf),
        read(mark),
        read(comment),
        read(tmp_path / "f.npy", columns=COLUMNS),
        read(tmp_path / "g.npz"),
        read(tmp_path / "h.npy"),
        read(as_parquet(tmp_path / "k.parquet", values)),
    ]
    for other in others:
        assert (other.rows, other.samples, other.gaps) == (3000, 3000, 0)
        assert_allclose(other.rate, 100.0, rtol=1e-9)
        for name, channel in other.channels.items():
            own = wanted.channels[name]
            assert_allclose(channel.head, own.head, rtol=1e-12)
            assert_allclose(channel.sums, own.sums, rtol=1e-9)
    assert_allclose(
        wanted.channels["gyro_x"].head, values[:, 1] * DEG_PER_HOUR, rtol=1e-12
    )


def test_pieces_are_one_file(tmp_path, monkeypatch):
    """However much is read at once, sums and counts are the same."""
    path = write(tmp_path / "a.csv", short_log())
    whole = read(path)
    monkeypatch.setattr(tables, "PIECE", 5000)
    parts = read(path)
    assert parts.sha256 == whole.sha256
    for name, channel in parts.channels.items():
        assert_allclose(channel.head, whole.channels[name].head, rtol=1e-12)
        assert_allclose(channel.counts, whole.channels[name].counts)


def test_columns_may_be_named_reversed_and_skipped(tmp_path):
    """In any order, of any unit; what is not ours is said to be left."""
    values = short_log()
    path = write(tmp_path / "a.csv", values, heads=())
    log = read(path, columns="time [s],-gyro_y [deg/h],_,gyro_z [rad/s]")
    assert [*log.channels] == ["gyro_y", "gyro_z"]
    assert_allclose(log.channels["gyro_y"].head, -values[:, 1] * DEG_PER_HOUR)
    other = read(path, columns="time [s],gyro_x [deg/h],flux [uT],_")
    assert other.skipped == ("flux [uT]",)


def test_a_recording_file_says_what_counts_are(tmp_path):
    """Gains, increments, a counter that begins again, several files."""
    values = short_log(2000)
    counts = np.round(values[:, 1:] / 3.6)  # 1000 counts/(deg/s)
    number = np.arange(2000) % 256
    gone = np.delete(np.arange(2000), [700, 701])
    write(tmp_path / "a.csv", np.column_stack([number, counts])[gone], heads=())
    (tmp_path / "a.yaml").write_text(
        "format: budget-recording/1\nrecording: a.csv\nrate: 100 Hz\n"
        'columns: ["n", "gyro_x [counts]", "gyro_y [counts]", "gyro_z [counts]"]\n'
        "gain: {gyro: 1000 counts/(deg/s)}\ncounter: {column: n, modulo: 256}\n"
    )
    assert validate(tmp_path / "a.yaml").kind == "recording"
    log = read(tmp_path / "a.yaml")
    assert (log.rows, log.samples, log.gaps, log.missing) == (1998, 2000, 1, 2)
    assert_allclose(log.channels["gyro_x"].head[:5], counts[:5, 0] * 3.6 * DEG_PER_HOUR)
    (tmp_path / "b.yaml").write_text("recording: [b.csv, c.csv]\nincrements: true\n")
    steps = values[:, 1:] / 3600.0 * 0.01
    heads = [one.replace("deg/h", "deg") for one in HEADS]
    both = np.column_stack([values[:, :1], steps])
    write(tmp_path / "b.csv", both[:1000], heads)
    write(tmp_path / "c.csv", both[1000:], heads)
    log = read(tmp_path / "b.yaml")
    assert log.rows == log.samples == 2000
    assert_allclose(log.channels["gyro_x"].head, values[:, 1] * DEG_PER_HOUR, rtol=1e-6)


def test_what_is_unsound_is_kept_out(tmp_path):
    """Gaps, stuck and saturated samples, outliers: found, counted, missing then."""
    values = short_log()
    values[500:560, 1] = values[500, 1]
    values[900:903, 2] = values[:, 2].max() + 400.0
    values[1200, 3] += 5000.0
    gone = np.delete(values, np.s_[2000:2025], axis=0)
    log = read(write(tmp_path / "a.csv", gone))
    assert (log.rows, log.samples, log.gaps, log.missing) == (2975, 3000, 1, 25)
    x, y, z = (one.kept_out for one in log.channels.values())
    assert (x.stuck, x.saturated, x.outliers) == (60, 0, 0)
    assert (y.stuck, y.saturated + y.outliers) == (0, 3)
    assert (z.stuck, z.saturated, z.outliers) == (0, 0, 1)
    assert_allclose(z.first[0][0], 12.0)
    missing = np.isnan(log.channels["gyro_x"].head)
    assert missing.sum() == 60 + 25
    assert log.channels["gyro_x"].counts.sum() == 3000 - 85


def test_sound_noise_is_kept(tmp_path):
    """Of noise in coarse steps nothing is stuck, saturated or outlying."""
    values = short_log(20_000)
    values[:, 1:] = np.round(values[:, 1:] / 100.0) * 100.0
    log = read(write(tmp_path / "a.csv", values))
    for channel in log.channels.values():
        kept = channel.kept_out
        assert (kept.stuck, kept.saturated, kept.outliers) == (0, 0, 0)


def test_periodic_lines_have_frequency_and_amplitude():
    """Two lines to a bin and 10 %; of noise, white or slow, none."""
    rng, n, rate = np.random.default_rng(4), 200_000, 100.0
    t = np.arange(n) / rate
    noise = rng.standard_normal(n)
    lines = 0.3 * np.sin(2.0 * np.pi * 7.3 * t) + 0.2 * np.cos(2.0 * np.pi * 31.0 * t)
    (f, a), (g, b) = periodic_lines(welch_spectrum(noise + lines, rate))
    assert_allclose([f, g], [7.3, 31.0], atol=rate / 4096)
    assert_allclose([a, b], [0.3, 0.2], rtol=0.1)
    assert periodic_lines(welch_spectrum(noise, rate)) == []
    slow = 0.1 * noise + np.cumsum(noise) * 0.01
    assert periodic_lines(welch_spectrum(slow, rate)) == []


BAD = {
    "comma decimals": (
        lambda s: s.replace("0.01,", "0,01,", 1),
        "5 fields, expected 4; a decimal comma",
    ),
    "text": (lambda s: s.replace("0.02,", "x,", 1), ":4:1: time [s]: found 'x'"),
    "nan": (lambda s: s.replace("0.02,", "nan,", 1), ":4:1: time [s]: found 'nan'"),
    "short": (lambda s: s.replace("0.02,", "", 1), ":4:1: has 3 fields, expected 4"),
    "back": (lambda s: s.replace("\n0.05,", "\n0.03,", 1), ":7:1: time goes back"),
    "again": (lambda s: s.replace("\n0.05,", "\n0.04,", 1), ":7:1: time stands"),
    "cut": (lambda s: s[:-4], "the last row has no end of line"),
    "no unit": (lambda s: s.replace(" [deg/h]", "", 1), "without a unit"),
    "a step": (lambda s: s.replace("deg/h", "deg", 1), "increments: true"),
    "alias": (
        lambda s: s.replace("gyro_x", "gyr_x", 1),
        "did you mean 'gyro_x [deg/h]",
    ),
    "none": (lambda s: s.replace("gyro", "rate"), "no column of a gyro"),
    "twice": (lambda s: s.replace("gyro_y", "gyro_x"), "two columns 'gyro_x'"),
    "heads": (lambda s: s.partition("\n")[0] + "\n", "no row of numbers"),
    "few": (lambda s: "\n".join(s.split("\n")[:50]) + "\n", "49 rows, expected 100"),
    "empty": (lambda _: "", "is empty"),
    "zero": (lambda s: s + "\0", "is neither text nor named as an array"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_said_at_its_line(case, tmp_path):
    """File and line, what was found, what is allowed, what to do."""
    change, says = BAD[case]
    text = write(tmp_path / "a.csv", short_log(200)).read_text()
    (tmp_path / "a.csv").write_text(change(text))
    with pytest.raises(BudgetError) as error:
        read(tmp_path / "a.csv")
    assert "a.csv" in str(error.value)
    assert says in str(error.value)


def test_a_rate_is_asked_for_and_held_against_stamps(tmp_path):
    """Without stamps it is needed; beside them it is the same."""
    path = write(tmp_path / "a.csv", short_log(200))
    with pytest.raises(BudgetError, match="200 Hz, and its stamps come at 100 Hz"):
        read(path, rate=200.0)
    bare = "_," + COLUMNS.partition(",")[2]
    with pytest.raises(BudgetError, match="give --rate"):
        read(path, columns=bare)
    assert read(path, columns=bare, rate=200.0).duration == 1.0


def test_stamps_of_arrival_are_refused(tmp_path):
    """Where many steps are long, they are not those of samples."""
    values = short_log(1000)
    values[:, 0] = np.arange(1000) * 0.001 + np.floor(np.arange(1000) / 10) * 0.1
    with pytest.raises(BudgetError, match="not the times of samples"):
        read(write(tmp_path / "a.csv", values))


def test_a_recording_elsewhere_is_not_read(tmp_path):
    """Nobody's file is shown by a recording file of another folder."""
    (tmp_path / "sub").mkdir()
    write(tmp_path / "secret.csv", short_log(200))
    (tmp_path / "sub" / "a.yaml").write_text("recording: ../secret.csv\n")
    with pytest.raises(BudgetError, match="in the folder of this one"):
        load_recording(tmp_path / "sub" / "a.yaml")


def test_a_gap_is_no_temperature(tmp_path):
    """Of a block that lacks some samples the temperature is the mean of the others."""
    n = 4000
    rows = np.column_stack([short_log(n), np.linspace(20.0, 21.0, n)])
    gone = np.concatenate([np.arange(k, k + 10) for k in range(500, n, 1000)])
    path = write(
        tmp_path / "a.csv",
        np.delete(rows, gone, axis=0),
        (*HEADS, "temperature [degC]"),
    )
    log = read(path)
    runs = block_means([(log, log.channels["gyro_x"])], 200)
    warm = runs.records[0].X[:, 1]
    assert np.isfinite(runs.records[0].y).all()
    assert_allclose(np.diff(warm), 0.05, rtol=0.06)


def test_files_of_one_recording_have_the_same_columns(tmp_path):
    """A second file with a temperature more is no part of the first."""
    rows = short_log(600)
    warm = np.column_stack([rows[300:], np.full(300, 25.0)])
    write(tmp_path / "a.csv", rows[:300])
    write(tmp_path / "b.csv", warm, (*HEADS, "temperature [degC]"))
    (tmp_path / "j.yaml").write_text("recording: [a.csv, b.csv]\n")
    with pytest.raises(BudgetError, match="expected the same in each"):
        read(tmp_path / "j.yaml")


def test_a_parquet_file_is_read_in_batches(tmp_path, monkeypatch):
    """Counts in whole numbers, columns that are not read of any kind."""
    values = np.round(short_log())
    names = {head: values[:, k].astype(np.int32) for k, head in enumerate(HEADS[1:], 1)}
    names |= {"time [s]": values[:, 0], "note": ["a"] * len(values)}
    names["time [s]"] = short_log()[:, 0]
    path = tmp_path / "a.parquet"
    parquet.write_table(pa.table(names), path, compression="zstd")
    whole = read(path)
    monkeypatch.setattr(tables, "ROWS", 700)
    parts = read(path)
    assert parts.rows == whole.rows == 3000
    for name, channel in parts.channels.items():
        assert_allclose(channel.head, whole.channels[name].head, rtol=1e-12)
    assert_allclose(
        parts.channels["gyro_x"].head, values[:, 1] * DEG_PER_HOUR, rtol=1e-12
    )
    assert parts.skipped == ("note",)


def test_a_parquet_file_that_is_none_is_refused(tmp_path, monkeypatch):
    """Text, an empty table, words in a column, a null, a machine without pyarrow."""
    path = write(tmp_path / "a.csv", short_log())
    text = path.rename(tmp_path / "a.parquet")
    with pytest.raises(SpecError, match="cannot be read"):
        read(text)
    with pytest.raises(SpecError, match="is empty"):
        read(as_parquet(tmp_path / "b.parquet", short_log()[:0]))
    words = {"time [s]": [0.0, 0.1], "gyro_x [deg/s]": ["1", "2"]}
    parquet.write_table(pa.table(words), tmp_path / "c.parquet")
    with pytest.raises(SpecError, match="found string, expected numbers"):
        read(tmp_path / "c.parquet")
    holed = short_log()
    holed[7, 2] = np.nan
    with pytest.raises(SpecError, match="row 8: found nan, expected a finite number"):
        read(as_parquet(tmp_path / "d.parquet", holed))
    sound = as_parquet(tmp_path / "e.parquet", short_log())
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(SpecError, match=r"pip install 'sins-budget\[parquet\]'"):
        read(sound)


def test_a_spectrum_over_that_of_its_model_is_1():
    """White noise of N beside its density; a line stands out, by its power."""
    rng, rate, N = np.random.default_rng(5), 100.0, 3.0
    n = 400_000
    noise = N * np.sqrt(rate) * rng.standard_normal(n)
    line = 40.0 * np.sin(2.0 * np.pi * 20.0 * np.arange(n) / rate)

    def density(f):
        return np.full(f.shape, 2.0 * N**2)

    sound = residual_spectrum(welch_spectrum(noise, rate), density)
    assert_allclose(sound[-1][1], 1.0, rtol=0.02)
    assert_allclose([ratio for _, ratio in sound], 1.0, rtol=0.6)
    found = residual_spectrum(welch_spectrum(noise + line, rate), density)
    place, ratio = max(found, key=lambda one: one[1])
    assert abs(np.log10(place / 20.0)) < 1.0 / 16.0
    assert ratio > 3.0
    assert welch_spectrum(noise[:200], rate) is None


def test_a_stated_end_is_in_the_unit_of_rates_of_increments_too(tmp_path):
    """Of angle steps the end is that rate times the interval: 1 deg/s at 100 Hz."""
    rng = np.random.default_rng(3)
    steps = np.round(rng.normal(0.0, 1e-3, 2000), 9)  # [deg], 0.1 deg/s
    steps[500] = 0.0101  # 1.01 deg/s
    time = np.arange(2000) / 100.0
    write(tmp_path / "a.csv", np.stack([time, steps], axis=1), heads=("time [s]", "x"))
    for end, number in (("1 deg/s", 1), ("2 deg/s", 0)):
        (tmp_path / "a.yaml").write_text(
            "recording: a.csv\nincrements: true\n"
            f"saturation: {{gyro: {end}}}\ncolumns: ['time [s]', 'gyro_x [deg]']\n",
            encoding="utf-8",
        )
        (log,) = read_logs(load_recording(tmp_path / "a.yaml"))
        assert log.channels["gyro_x"].kept_out.saturated == number


@pytest.mark.parametrize(
    ("interval", "n", "said"),
    [
        (5.0, 500, "ms"),  # of 200 Hz in ms under a head of seconds
        (5e-3, 500, ""),
        (1.0, 500, ""),  # 1 Hz
        (0.5, 500, ""),
        (1.0, 172_801, "ms"),  # of 1 kHz for three minutes, or of 1 Hz for two days
    ],
)
def test_stamps_that_come_seldom_may_be_in_another_unit(tmp_path, interval, n, said):
    """Below 1 Hz, or of days: of a slow recording nothing is said."""
    values = np.resize(short_log()[:500, 1], n)
    rows = np.stack([np.arange(n) * interval, values], axis=1)
    path = write(tmp_path / "a.csv", rows, heads=("time [s]", HEADS[1]))
    assert read(path).likely_unit == said
