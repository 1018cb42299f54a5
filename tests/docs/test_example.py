"""The committed example report: as long as a reviewer reads, every page used."""

from __future__ import annotations

import re
import subprocess

from places import DOCS
from reading import needs_poppler

PAGES = 8  # of the example, with its allocation
HALF = 0.5  # of the height between head and foot


def heights():
    """Return, page by page, how far down words reach between head and foot [1]."""
    command = ("pdftotext", "-bbox", DOCS / "example" / "report.pdf", "-")
    text = subprocess.run(command, capture_output=True, check=True).stdout.decode()
    found = []
    for page in text.split("<page ")[1:]:
        height = float(re.search(r'height="([\d.]+)"', page)[1])
        lows = [float(y) for y in re.findall(r'yMax="([\d.]+)"', page)]
        # Margins of the template: 19 mm with the head above, 18 mm with the foot below.
        top, base = 19.0 / 25.4 * 72.0, height - 18.0 / 25.4 * 72.0
        inside = [y for y in lows if top < y <= base]
        found.append((max(inside) - top) / (base - top))
    return found


@needs_poppler
def test_the_example_is_no_longer_than_a_reviewer_reads():
    """The report of an analysis with its allocation has eight pages at the most."""
    assert len(heights()) <= PAGES


@needs_poppler
def test_no_page_is_half_empty():
    """On every page but the last one words reach below the middle."""
    short = [n for n, part in enumerate(heights()[:-1], start=1) if part < HALF]

    assert short == []
