"""Write the example report: `python docs/make_example.py [FOLDER]`.

With poppler's pdftoppm on the machine it also draws page one as a picture.
"""  # noqa: INP001 - a script, no package

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent / "example"
DATE = "1767225600"  # 2026-01-01 as SOURCE_DATE_EPOCH
RESOLUTION = "110"  # dots per inch of the picture


def write(folder: Path) -> None:
    """Write report.html, report.pdf and, if it can be drawn, page-one.png."""
    pages = [folder / "report.html", folder / "report.pdf"]
    subprocess.run(  # noqa: S603 - our own command
        [
            *(sys.executable, "-m", "budget", "report"),
            *("--requirement", HERE / "requirement.yaml", "--sobol", "--allocate"),
            *(word for page in pages for word in ("-o", page)),
        ],
        check=True,
        env=os.environ | {"SOURCE_DATE_EPOCH": DATE},
    )
    if shutil.which("pdftoppm"):
        subprocess.run(  # noqa: S603 - likewise
            [
                *("pdftoppm", "-png", "-singlefile", "-f", "1", "-r", RESOLUTION),
                *(pages[1], folder / "page-one"),
            ],
            check=True,
        )


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
