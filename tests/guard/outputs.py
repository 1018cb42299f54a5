"""What the shipped commands write, word for word: kept, compared, accepted.

For a change that shall leave every word as it was, from the top of the checkout:

    python tests/guard/outputs.py diff HEAD           what this tree says otherwise
    python tests/guard/outputs.py store FOLDER        keep what it says in a folder,
    python tests/guard/outputs.py diff FOLDER         and hold it against that later
    python tests/guard/outputs.py accept              store the digests anew: intended

Names of calls behind these choose some of those in calls.yaml; `--revision REVISION`
has `store` run another tree. Each call is made in a folder of its own with the files
of inputs/. Kept are, in a folder of each call, what the terminal shows (exit code,
stdout, stderr) and every file that is written. What no reader sees, or what machines
differ in, is taken out:

- the folder, the version of the package; the date is SOURCE_DATE_EPOCH;
- of a number with more than DIGITS significant digits the others; in documents (JSON,
  CSV, exact numbers of HTML) what is NOTHING or, of a covariance, UNCORRELATED is 0;
  the checksum of a stored reference, which is of all digits;
- of HTML all but tags, attributes and text: scripts and styles are digests, documents
  inside are JSON; of a drawing its words and how many there are of each element, its
  geometry is a digest in a file beside it, compared under the same matplotlib alone;
- of PDF all but the text that pdftotext reads: without that it is not compared.
"""

from __future__ import annotations

import argparse
import difflib
import io
import json
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from contextlib import chdir, redirect_stdout
from hashlib import sha256
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
INPUTS, DIGESTS = HERE / "inputs", HERE / "digests.json"
# Processors agree in 12; the more are kept, the more often a number stands on the edge
# between two last digits. Of this processor all are seen by DIGITS=17 before a command.
DIGITS = int(os.environ.get("DIGITS", "6"))
NOTHING = 1e-10  # what rounding makes of zero, in printed units and in shares
UNCORRELATED = 1e-9  # what it makes of a covariance, over both standard uncertainties
EXACT = {"title", "data-exact"}  # attributes of a page with all digits of a number
FLOAT = re.compile(r"(?<![\w.])-?\d+(?:\.\d+(?:[eE][+-]?\d+)?|[eE][+-]?\d+)(?![\w.])")
VARIABLE = re.compile(r"[A-Z_]+=")
SURROUNDINGS = {"SOURCE_DATE_EPOCH": "1767225600"}  # 1 January 2026
TERMINAL, DRAWINGS = "terminal", ".drawings"
INLINE = re.compile(
    r"[abi]|br|code|em|kbd|math|m(frac|i|n|o|over|row|space|sub|subsup|sup|text)"
    r"|output|small|span|strong|su[bp]|tspan"
)


def calls() -> dict[str, list[str]]:
    """Return the lines of every call by its name."""
    text = (HERE / "calls.yaml").read_text(encoding="utf-8")
    found = yaml.safe_load(text).items()
    return {name: [one] if isinstance(one, str) else one for name, one in found}


def outputs(name: str, folder: Path) -> dict[str, str]:
    """Make a call in a folder that is not there; return its texts by medium."""
    shutil.copytree(INPUTS, folder)
    before = {path.name for path in folder.iterdir()}
    with chdir(folder):
        said = "".join(run(line) for line in calls()[name])
    found = {TERMINAL: plain(said, folder)}
    written = sorted(set(folder.iterdir()) - {folder / one for one in before})
    for path in written:
        kind = path.suffix if path.is_file() else None
        if kind == ".html":
            page = Page(path.read_text(encoding="utf-8"))
            found |= {path.name: plain(page.text, folder)}
            found |= {path.name + DRAWINGS: plain(page.drawings, folder)}
        elif kind == ".pdf" and shutil.which("pdftotext"):
            words = ["pdftotext", "-raw", "-enc", "UTF-8", str(path), "-"]
            read = subprocess.run(words, capture_output=True, check=True).stdout
            found[path.name] = plain(read.decode(), folder)
        elif kind not in {".pdf", None}:
            text = path.read_text(encoding="utf-8")
            change = {".json": document, ".csv": data}.get(kind, str)
            found[path.name] = plain(change(text), folder)
    # What is written has all digits, in which processors differ, and so its checksum.
    for path in filter(Path.is_file, written):
        own = r"\s?".join(sha256(path.read_bytes()).hexdigest())
        found = {key: re.sub(own, "SHA-256", text) for key, text in found.items()}
    return found


def run(line: str) -> str:
    """Run one line; return it, its exit code and what it says."""
    from command_line import call

    words = shlex.split(line)
    given = dict(w.split("=", 1) for w in words if VARIABLE.match(w))
    program, *words = words[len(given) :]
    if program == "python":
        with redirect_stdout(io.StringIO()) as out:
            runpy.run_path(*words)
        return f"$ {line}\n{out.getvalue()}"
    found = call(*words, **SURROUNDINGS | given)
    return f"$ {line}\nexit code {found.code}\n{found.out}--- stderr\n{found.err}"


def plain(text: str, folder: Path) -> str:
    """Take out of a text what machines differ in."""
    from budget.version import __version__

    text = text.replace(str(folder), "FOLDER").replace(str(ROOT), "ROOT")
    text = re.sub(rf"\b(budget|sins-budget) {re.escape(__version__)}\b", r"\1 0", text)
    return FLOAT.sub(lambda found: shorter(found[0]), text)


def shorter(number: str) -> str:
    """Return a number with as many digits as are compared."""
    digits = re.sub(r"[eE].*|[.-]", "", number).lstrip("0")
    return (
        number if len(digits) <= DIGITS else repr(float(f"{float(number):.{DIGITS}g}"))
    )


def data(text: str) -> str:
    """Write 0 for what is nothing."""
    return FLOAT.sub(lambda at: "0.0" if abs(float(at[0])) < NOTHING else at[0], text)


def document(text: str) -> str:
    """Write 0 for what is nothing in a JSON document, or in a covariance of it."""

    def settle(found: dict) -> dict:
        if "checksum" in found:  # of a reference, over all digits
            found["checksum"] = "CHECKSUM"
        rows = found.get("covariance")
        if isinstance(rows, list):
            # What is not estimated has none.
            u = [abs(row[place] or 0.0) ** 0.5 for place, row in enumerate(rows)]
            found["covariance"] = [
                [
                    x and x * (abs(x) > UNCORRELATED * u_x * u_y)
                    for x, u_x in zip(row, u, strict=True)
                ]
                for row, u_y in zip(rows, u, strict=True)
            ]
        return found

    found = json.loads(text, object_hook=settle)
    return data(json.dumps(found, indent=1, ensure_ascii=False))


class Page(HTMLParser):
    """A page as lines: a tag with its attributes and the text behind it."""

    def __init__(self, text: str) -> None:
        """Read it."""
        super().__init__()
        self.lines: list[str] = [""]
        self.kept: list[str] = []  # of the script, style or drawing that is open
        self.inside = ""
        self.elements: Counter[str] = Counter()
        self.geometries: list[str] = []
        self.feed(text)
        self.close()
        self.text = "\n".join(filter(None, (" ".join(x.split()) for x in self.lines)))
        self.drawings = "\n".join(self.geometries)

    def handle_starttag(self, tag, attrs) -> None:
        """Begin a line, or note an element of a drawing."""
        attributes = "".join(
            f' {key}="{data(value or "") if key in EXACT else value or ""}"'
            for key, value in attrs
        )
        if self.inside == "svg":
            self.elements[tag] += 1
            self.kept.append(f"<{tag}{attributes}>")
            return
        if not INLINE.fullmatch(tag):
            self.lines.append("")
        self.lines[-1] += f"<{tag}{attributes}>"
        if tag in {"script", "style", "svg"}:
            self.inside, self.kept, self.elements = tag, [attributes], Counter()

    def handle_data(self, data) -> None:
        """Add words to the line."""
        if self.inside:
            self.kept.append(data)
        if self.inside in {"", "svg"}:
            self.lines[-1] += data

    def handle_endtag(self, tag) -> None:
        """Close what is open; of scripts, styles and geometry stays a digest."""
        if tag != self.inside:
            is_inline = not self.inside and INLINE.fullmatch(tag)
            self.lines[-1] += "</>" if is_inline else ""
            return
        text, self.inside = "".join(self.kept[1:]), ""
        if tag == "svg":
            self.lines += [f"{one} {n}" for one, n in sorted(self.elements.items())]
            self.geometries.append(digest(text) + self.kept[0])
        elif "json" in self.kept[0]:
            self.lines += document(text or "null").splitlines()
        else:
            self.lines.append(digest(text))
        self.lines.append("")


def digest(text: str) -> str:
    """Return what tells one text from another."""
    return sha256(text.encode()).hexdigest()[:16]


def digests(found: dict[str, str]) -> dict[str, str]:
    """Return the digests of the texts of a call."""
    return {medium: digest(text) for medium, text in found.items()}


def store(folder: Path, names: list[str]) -> None:
    """Keep the outputs of calls in a folder."""
    for name in names:
        with tempfile.TemporaryDirectory() as work:
            found = outputs(name, Path(work).resolve() / name)
        shutil.rmtree(folder / name, ignore_errors=True)
        (folder / name).mkdir(parents=True)
        for medium, text in found.items():
            (folder / name / medium).write_text(text, encoding="utf-8")


def store_of(revision: str, folder: Path, names: list[str]) -> None:
    """Keep in a folder what the tree of a git revision says."""
    with tempfile.TemporaryDirectory() as work:
        tree = Path(work).resolve() / "tree"
        git = ("git", "-C", str(ROOT), "worktree")
        subprocess.run([*git, "add", "-q", "--detach", tree, revision], check=True)
        try:
            there = os.pathsep.join(map(str, (tree, tree / "tests", tree / "examples")))
            subprocess.run(
                [sys.executable, __file__, "store", folder, *names],
                env=os.environ | {"PYTHONPATH": there},
                check=True,
            )
        finally:
            subprocess.run([*git, "remove", "--force", tree], check=True)


def differences(before: Path, now: Path, names: list[str]) -> str:
    """Return what moved between two folders, as one unified diff."""
    media = {
        path.relative_to(folder)
        for folder in (before, now)
        for name in names
        for path in (folder / name).glob("*")
    }
    return "".join(
        line + "\n"
        for medium in sorted(media)
        for line in difflib.unified_diff(
            *(
                path.read_text(encoding="utf-8").splitlines() if path.is_file() else ()
                for path in (before / medium, now / medium)
            ),
            f"before/{medium}",
            f"now/{medium}",
            lineterm="",
        )
    )


def accept(names: list[str]) -> None:
    """Store the digests of calls anew, those of calls that are gone no longer."""
    kept = json.loads(DIGESTS.read_text("utf-8"))["calls"] if DIGESTS.exists() else {}
    for name in names:
        with tempfile.TemporaryDirectory() as work:
            kept[name] = digests(outputs(name, Path(work).resolve() / name))
    found = {
        "matplotlib": version("matplotlib"),
        "calls": {name: kept[name] for name in calls() if name in kept},
    }
    DIGESTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Do what the command line asks for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("what", choices=("store", "diff", "accept"))
    parser.add_argument("rest", nargs="*", help="folder or revision, names of calls")
    parser.add_argument("--revision", help="of the tree whose outputs are stored")
    asked = parser.parse_args()
    place = None if asked.what == "accept" else asked.rest.pop(0)
    names = asked.rest or list(calls())
    if asked.what == "accept":
        accept(names)
    elif asked.what == "store" and asked.revision:
        store_of(asked.revision, Path(place).resolve(), names)
    elif asked.what == "store":
        store(Path(place).resolve(), names)
    else:
        with tempfile.TemporaryDirectory() as work:
            before, now = Path(place).resolve(), Path(work) / "now"
            if not before.is_dir():
                before = Path(work) / "before"
                store_of(place, before, names)
            store(now, names)
            moved = differences(before, now, names)
        sys.stdout.write(moved)
        return int(bool(moved))
    return 0


if __name__ == "__main__":
    sys.path += [str(HERE.parent), str(ROOT), str(ROOT / "examples")]
    sys.exit(main())
