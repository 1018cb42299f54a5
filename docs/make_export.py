"""Write the table of targets into docs/export.md."""  # noqa: INP001 - a script, no package

from __future__ import annotations

from pathlib import Path

from budget.studies.export.targets import LEAVE_OUT, TARGETS, ZERO

PAGE = Path(__file__).resolve().parent / "export.md"
BEGIN = "<!-- targets: made by docs/make_export.py -->\n"
END = "<!-- end of targets -->\n"
MARKS = {LEAVE_OUT: " (optional)", ZERO: " (0)"}


def table() -> str:
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
    return "\n".join(rows) + "\n"


def page(text: str) -> str:
    """Return the page with the present table in it."""
    head, _, rest = text.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return head + BEGIN + table() + END + tail


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
