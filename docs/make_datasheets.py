"""Write the table of makers' words into docs/datasheets.md."""  # noqa: INP001 - a script, no package

from __future__ import annotations

from pathlib import Path

from budget.spec.makers import READINGS

PAGE = Path(__file__).resolve().parent / "datasheets.md"
BEGIN = "<!-- words: made by docs/make_datasheets.py -->\n"
END = "<!-- end of words -->\n"


def table() -> str:
    """Return one row for each line: the words of makers, and how to read them."""
    rows = ["| makers print | line | before it is one |", "|---|---|---|"]
    for one in READINGS:
        for place, (line, words) in enumerate(one.words.items()):
            says = "as above" if place else one.says
            rows.append(f"| {', '.join(words)} | [`{line}`](#{one.anchor}) | {says} |")
    return "\n".join(rows) + "\n"


def page(text: str) -> str:
    """Return the page with the present table in it."""
    head, _, rest = text.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return head + BEGIN + table() + END + tail


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
