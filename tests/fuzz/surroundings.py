"""Every command in every odd environment: no fault, no traceback, no warning.

    python tests/fuzz/surroundings.py [SEED [RUNS]]

Hostile rounds by hand or at night: all of them, or as many as are asked for, drawn by
the seed. It prints how many were run, with the seed, and each run that is not as it
should be: its code, a traceback, a warning, another library's words. It ends with 1
where there is one.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from failing import BUDGET, NOT_MET, PRINTING, WRITING

TARGETS = (
    *("kalibr", "openvins", "vins", "gtsam", "kf-gins", "psins", "gazebo", "ros"),
    *("matlab", "nav-toolkit"),
)
ENVIRONMENTS = {
    "a notebook": {"MPLBACKEND": "module://matplotlib_inline.backend_inline"},
    "no such locale": {"LANG": "xx_XX.KOI8-R", "LC_ALL": "nonsense"},
    "a bare terminal": {"TERM": "dumb", "NO_COLOR": "1", "FORCE_COLOR": "1"},
    "a narrow terminal": {"COLUMNS": "20", "LINES": "1"},
    "no home": {"HOME": None, "USER": None, "XDG_CONFIG_HOME": "/proc/none"},
    "no temporary files": {"TMPDIR": "/proc/none", "TEMP": "/proc/none"},
    "warnings are errors": {"PYTHONWARNINGS": "error"},
    "optimized": {"PYTHONOPTIMIZE": "2", "PYTHONDONTWRITEBYTECODE": "1"},
    "another hash": {"PYTHONHASHSEED": "7", "PYTHONDEVMODE": "0"},
    "threads": {"OMP_NUM_THREADS": "none", "OPENBLAS_NUM_THREADS": "-1"},
    "a folder to read": {},
    "caches": {"MPLCONFIGDIR": "/proc/none", "MATPLOTLIBRC": "/proc/self/mem"},
}
READ_ONLY = "a folder to read"
FAULT = re.compile(rb"Traceback|Warning:|internal error|Error:.*Errno", re.IGNORECASE)
PATIENCE = 600.0  # [s]
UNWRITABLE = "/proc"  # where root may not write either


def commands():
    """Return every command by a name: those that print, that write, each export."""
    written = {f"{name}, written": words for name, words in WRITING.items()}
    exports = {
        f"export {to}": ("export", "hg4930#A", "--to", to, "--rate", "200")
        for to in TARGETS
    }
    return {**PRINTING, **written, **exports}


def fault_of(command, surroundings):
    """Run a command in a folder of its own; return what is wrong, '' where nothing."""
    changed = os.environ | ENVIRONMENTS[surroundings]
    with TemporaryDirectory() as folder:
        run = subprocess.run(
            [*BUDGET, *map(str, commands()[command])],
            cwd=UNWRITABLE if surroundings == READ_ONLY else folder,
            env={name: text for name, text in changed.items() if text is not None},
            capture_output=True,
            check=False,
            timeout=PATIENCE,
        )
    refused = surroundings == READ_ONLY and "written" in command
    allowed = {2} if refused else {0, 1} if command.split(",")[0] in NOT_MET else {0}
    said = run.stderr.splitlines()
    odd = [line.decode(errors="replace") for line in said if FAULT.search(line)]
    if run.returncode not in allowed or odd:
        last = odd[:1] or [run.stderr[-300:].decode(errors="replace")]
        return f"{surroundings}: budget {command}: code {run.returncode}: {last[0]}"
    return ""


def main():
    """Run all, in an order of its own, and print what was found."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 0
    runs = [(one, place) for one in commands() for place in ENVIRONMENTS]
    most = int(sys.argv[2]) if len(sys.argv) > 2 else len(runs)
    order = np.random.default_rng(seed).permutation(len(runs))[:most]
    faults = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(lambda place: fault_of(*runs[place]), order)
        for done, fault in enumerate(found, start=1):
            faults += bool(fault)
            sys.stdout.write(fault and f"{fault}\n")
            sys.stdout.write("" if done % 50 else f"{done} runs, {faults} faults\n")
            sys.stdout.flush()
    sys.stdout.write(
        f"{len(order)} of {len(runs)} runs ({len(commands())} commands, "
        f"{len(ENVIRONMENTS)} environments), seed {seed}: {faults} faults\n"
    )
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
