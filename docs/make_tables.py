"""Write the tables of pages that are made from data of the package."""  # noqa: INP001 - a script, no package

from __future__ import annotations

from pathlib import Path

from budget.spec.makers import READINGS
from budget.studies.export.targets import LEAVE_OUT, TARGETS, ZERO

DOCS = Path(__file__).resolve().parent
MARKS = {LEAVE_OUT: " (optional)", ZERO: " (0)"}


def words() -> list[str]:
    """Return one row for each line: the words of makers, and how to read them."""
    rows = ["| makers print | line | before it is one |", "|---|---|---|"]
    for one in READINGS:
        for place, (line, names) in enumerate(one.words.items()):
            says = "as above" if place else one.says
            rows.append(f"| {', '.join(names)} | [`{line}`](#{one.anchor}) | {says} |")
    return rows


def targets() -> list[str]:
    """Return one row for each target: keys with their units, and where from."""
    rows = ["| `--to` | target | keys [unit] | read in |", "|---|---|---|---|"]
    for target in TARGETS:
        keys = ", ".join(
            f"`{entry.key}` [{entry.unit}]{MARKS.get(entry.absent, '')}"
            for entry in target.entries
        )
        rate = ", `--rate`" if target.needs_rate else ""
        sources = "; ".join(target.sources)
        rows.append(f"| `{target.name}`{rate} | {target.title} | {keys} | {sources} |")
    return rows


TABLES = {"datasheets.md": ("words", words), "export.md": ("targets", targets)}


def page(name: str) -> str:
    """Return a page with the present table in it."""
    title, rows = TABLES[name]
    begin = f"<!-- {title}: made by docs/make_tables.py -->\n"
    end = f"<!-- end of {title} -->\n"
    head, _, rest = (DOCS / name).read_text(encoding="utf-8").partition(begin)
    _, _, tail = rest.partition(end)
    return head + begin + "\n".join(rows()) + "\n" + end + tail


if __name__ == "__main__":
    for name in TABLES:
        (DOCS / name).write_text(page(name), encoding="utf-8")
