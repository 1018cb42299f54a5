"""What recordings cost: reading, Allan deviation, the fit of an axis; time and memory.

Run `python benchmarks/recordings.py`; a minute. Each is the best of three in a process
of its own, whose largest memory is printed (ru_maxrss). Beside the overlapping Allan
deviation stands that of allantools, where it is installed (it is no dependency: LGPL).

A recording of 1e8 rows of seven columns (8.9 GB of CSV, `budget simulate zhao-2019
--static '1000000 s' --rate 100`) is none of these, as it takes minutes: see
docs/recordings.md.
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

ROWS, SAMPLES, BLOCKS = 1_000_000, 10_000_000, 4096
HEADS = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]"
TIMES = 3


def recording(rows: int) -> np.ndarray:
    """Return stamps and three axes of white noise."""
    rng = np.random.default_rng(1)
    values = rng.standard_normal((rows, 3))
    return np.column_stack([0.01 * np.arange(rows), values])


def write(folder: Path) -> dict[str, Path]:
    """Write the recording as each kind of file."""
    values = recording(ROWS)
    paths = {kind: folder / f"a.{kind}" for kind in ("csv", "npy")}
    np.savetxt(
        paths["csv"], values, fmt="%.7g", delimiter=",", header=HEADS, comments=""
    )
    np.save(paths["npy"], values)
    if find_spec("pyarrow"):
        import pyarrow as pa
        from pyarrow import parquet

        paths["parquet"] = folder / "a.parquet"
        columns = dict(zip(HEADS.split(","), values.T, strict=True))
        parquet.write_table(pa.table(columns), paths["parquet"])
    return paths


def read(path: Path) -> Callable[[], object]:
    """Read a recording."""
    from budget.inputs import load_recording
    from budget.inputs.recording import with_columns
    from budget.recordings.log import read_logs

    heads = HEADS if path.suffix == ".npy" else None
    return lambda: read_logs(with_columns(load_recording(path), columns=heads))


def fit(_: Path) -> Callable[[], object]:
    """Fit all models to one axis, with intervals and bounds."""
    from budget.inputs import load_recording
    from budget.inputs.recording import with_columns
    from budget.recordings.log import read_logs
    from budget.recordings.noise import noise_of

    path = _.parent / "fit.npy"
    rng = np.random.default_rng(2)
    steps = np.cumsum(rng.standard_normal(BLOCKS * 100)) * 0.01
    np.save(path, steps + 10.0 * rng.standard_normal(BLOCKS * 100))
    (log,) = read_logs(
        with_columns(load_recording(path), rate=100.0, columns="gyro_x [deg/h]")
    )
    return lambda: noise_of("gyro_x", [log])


def curve(_: Path) -> Callable[[], object]:
    """Return the Allan deviation of 1e7 samples at octaves."""
    from budget.methods.allan import allan_curve

    values = np.random.default_rng(3).standard_normal(SAMPLES)
    return lambda: allan_curve(values, 0.01)


def of_allantools(_: Path) -> Callable[[], object]:
    """Return the same by allantools."""
    import allantools

    values = np.random.default_rng(3).standard_normal(SAMPLES)
    return lambda: allantools.oadev(values, rate=100.0, data_type="freq", taus="octave")


def measured(make: Callable[[Path], Callable[[], object]], path: Path) -> None:
    """Print the best time and the largest memory of a piece of work."""
    work = make(path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    times = []
    for _ in range(TIMES):
        begun = perf_counter()
        work()
        times.append(perf_counter() - begun)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"{min(times):8.2f} s {most / 1e3:8.0f} MB, {before / 1e3:.0f} MB before")


def main() -> None:
    """Print all."""
    start = multiprocessing.get_context("spawn")
    with TemporaryDirectory() as folder:
        paths = write(Path(folder))
        jobs = [(f"read {ROWS:.0e} rows, .{kind}", read, paths[kind]) for kind in paths]
        jobs.append((f"fit {BLOCKS} blocks", fit, paths["csv"]))
        jobs.append((f"Allan deviation, {SAMPLES:.0e}", curve, paths["csv"]))
        if find_spec("allantools"):
            jobs.append(("the same by allantools", of_allantools, paths["csv"]))
        for name, make, path in jobs:
            print(f"{name:32}", end="")
            sys.stdout.flush()
            process = start.Process(target=measured, args=(make, path))
            process.start()
            process.join()


if __name__ == "__main__":
    main()
