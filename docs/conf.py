"""The site of these pages: `python -m sphinx -W docs site`, with the extra [docs].

The pages are Markdown that any viewer shows; what only the site has is made here: the
tree of pages from the lists of index.md, the docstrings behind library.md, the page of
the notebook, and formulas as MathML, which browsers set without a script or a host.
"""  # noqa: INP001 - a script, no package

from __future__ import annotations

import json
import re
from base64 import b64encode
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

import budget

if TYPE_CHECKING:
    from docutils.nodes import Element
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

DOCS = Path(__file__).resolve().parent
project = "sins-budget"
version = release = budget.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"sins-budget {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_copyright = False
html_show_sphinx = False
html_math_renderer = "mathml"
# Formulas between dollar signs, and links to headings, as in the repository.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
# Types are in the docstrings, with shapes and units.
autodoc_typehints = "none"
autodoc_member_order = "bysource"

LINKED = re.compile(r"^- \[.+\]\((.+)\.md\)$", re.MULTILINE)


def add_tree(text: str) -> str:
    """Add the tree of pages: a part for each heading of the index, with its list."""
    parts = []
    for part in text.split("\n## ")[1:]:
        head = part.partition("\n")[0]
        pages = "\n".join(LINKED.findall(part))
        parts.append(f"```{{toctree}}\n:hidden:\n:caption: {head}\n\n{pages}\n```\n")
    return "\n".join([text, *parts])


def add_docstrings(text: str) -> str:
    """Add the docstring of every public name, behind the table of them."""
    parts = []
    for name in sorted(set(budget.__all__) - {"__version__"}, key=str.lower):
        is_class = isinstance(getattr(budget, name), type)
        kind, members = ("class", "   :members:\n") if is_class else ("function", "")
        parts.append(f".. auto{kind}:: budget.{name}\n{members}")
    return "\n".join([text, "```{eval-rst}", *parts, "```", ""])


def add_session(_text: str) -> str:
    """Return the notebook as a page: its words, its code, what the code printed."""
    book = json.loads((DOCS / "notebook.ipynb").read_text(encoding="utf-8"))
    parts = []
    for cell in book["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            found = {kind: "".join(text) for kind, text in output["data"].items()}
            html = found.get("text/html", "")
            if svg := found.get("image/svg+xml"):
                drawn = b64encode(svg.encode()).decode()
                alt = escape(found["text/plain"].strip("<>"))
                html = f'<img alt="{alt}" src="data:image/svg+xml;base64,{drawn}">'
            parts.append(f"```{{raw}} html\n{html}\n```")
    return "\n\n".join([*parts, ""])


BEYOND = re.compile(r"\[([^]]+)\]\(\.\./([^)]+\.md)\)")
ADDED = {"index": add_tree, "library": add_docstrings, "notebook": add_session}


def add(_app: Sphinx, name: str, source: list[str]) -> None:
    """Add to a page what the site has beyond it; what it has not is no link."""
    source[0] = BEYOND.sub(r"\1 (`\2`)", source[0])
    if name in ADDED:
        source[0] = ADDED[name](source[0])


def add_formula(page: HTML5Translator, formula: Element) -> None:
    """Write a formula, in a line or on one of its own."""
    is_block = formula.tagname == "math_block"
    page.body.append(tex2mathml(formula.astext(), as_block=is_block))
    raise SkipNode


def setup(app: Sphinx) -> None:
    """Tell Sphinx."""
    visit = (add_formula, None)
    app.add_html_math_renderer("mathml", visit, visit)
    app.connect("source-read", add)
