"""The texts of a drawn figure, for tests that ask what it says and whether it fits."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from matplotlib.text import Text

from budget.report.figures.style import to_svg

SLACK = 2.0  # for the font of whoever shows the figure [pt]


def texts(figure):
    """Return all texts that stand in the SVG of a figure."""
    root = ET.fromstring(to_svg(figure, name="f"))  # noqa: S314 - our own
    return [
        "".join(e.itertext()) for e in root.iter("{http://www.w3.org/2000/svg}text")
    ]


def cut_texts(figure):
    """Return the texts that do not lie within the figure."""
    figure.draw_without_rendering()  # labels of axes have their place only then
    width, height = (72.0 * inches for inches in figure.get_size_inches())
    found = [t for t in figure.findobj(Text) if t.get_text() and t.get_visible()]
    assert found
    cut = []
    for text in found:
        box = text.get_window_extent()
        x0, y0, x1, y1 = (72.0 / figure.dpi * float(x) for x in box.extents)
        beyond = max(-x0, -y0, x1 - width, y1 - height)
        if beyond > SLACK:
            cut.append((text.get_text(), beyond))
    return cut
