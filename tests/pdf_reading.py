"""What a PDF says, read back by the tools of poppler and qpdf where they can be had."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

needs_poppler = pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="reads PDF by poppler-utils"
)
needs_qpdf = pytest.mark.skipif(
    shutil.which("qpdf") is None, reason="checks the file by qpdf"
)
needs_verapdf = pytest.mark.skipif(
    shutil.which("verapdf") is None, reason="checks PDF/A and PDF/UA by veraPDF"
)


def ask(pdf, folder, *command):
    """Run a tool on a PDF, which comes after its first words; return what it prints."""
    path = folder / "asked.pdf"
    path.write_bytes(pdf)
    words = [str(path) if word == "FILE" else word for word in command]
    return subprocess.run(words, capture_output=True, check=True).stdout.decode()


def pages_of(pdf, folder):
    """Return the text of each page, without blanks and possible breaks."""
    text = ask(pdf, folder, "pdftotext", "-raw", "-enc", "UTF-8", "FILE", "-")
    return [squeeze(page) for page in text.split("\f")[:-1]]


def text_of(pdf, folder):
    """Return the text of the whole file, in the same way."""
    return "".join(pages_of(pdf, folder))


def squeeze(text):
    """Leave out blanks and the marks of a possible break."""
    return re.sub(r"[\s\u00ad\u200b\u2060]", "", text)


def words_beyond(pdf, folder):
    """Return the words that reach over an edge of their page."""
    boxes = ask(pdf, folder, "pdftotext", "-bbox", "FILE", "-")
    width, height = map(
        float, re.search(r'<page width="([\d.]+)" height="([\d.]+)"', boxes).groups()
    )
    words = re.findall(
        r'<word xMin="([-\d.]+)" yMin="([-\d.]+)" xMax="([-\d.]+)" yMax="([-\d.]+)">'
        r"(.*?)</word>",
        boxes,
    )
    assert words
    return [
        text
        for *edges, text in words
        for x0, y0, x1, y1 in [map(float, edges)]
        if x0 < 0.0 or y0 < 0.0 or x1 > width or y1 > height
    ]
