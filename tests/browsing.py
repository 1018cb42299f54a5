"""A real Chromium for the tests of pages, with a record of what a page asks for."""

from __future__ import annotations

import os
import shutil
import subprocess
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from places import ROOT

from budget.report.page import render_page

CONTRAST = (Path(__file__).parent / "contrast.js").read_text(encoding="utf-8")
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@dataclass
class Record:
    """What happened while a page was open."""

    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)


@contextmanager
def chromium():
    """Start the machine's browser, or skip and say why."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed (extra `test`)"
    )
    executable = next(filter(None, map(shutil.which, NAMES)), None)
    if executable is None:
        pytest.skip(f"no Chromium on this machine (looked for {', '.join(NAMES)})")
    with playwright.sync_playwright() as driver:
        # Pages are our own files; root has no sandbox to start in.
        browser = driver.chromium.launch(
            executable_path=executable, args=["--no-sandbox"]
        )
        browser.new_context()  # the one that pages without options are opened in
        yield browser
        browser.close()


@contextmanager
def opened(browser, path, *, width=1280, **options):
    """Open a file; give the page and the record of its requests and complaints.

    One tab shows file after file, each as a document of its own: cookies and stores,
    of which they have none, are all that they have in common. A tab a file takes twice
    as long as what most tests do in it. After a failure it is closed, as it is with
    options, which need a context of their own.
    """
    record = Record()
    listeners = {
        "request": lambda request: record.requests.append(request.url),
        "console": lambda message: record.complaints.append(message.text),
        "pageerror": lambda error: record.complaints.append(str(error)),
        "dialog": lambda dialog: record.complaints.append(dialog.message),
    }
    own = browser.new_context(**options) if options else None
    page = own.new_page() if own else _tab(browser.contexts[0])
    page.set_viewport_size({"width": width, "height": 900})
    for event, listener in listeners.items():
        page.on(event, listener)
    try:
        page.goto(path.as_uri())
        yield page, record
    except BaseException:
        (own or page).close()
        raise
    if own:
        own.close()
        return
    for event, listener in listeners.items():
        page.remove_listener(event, listener)


def _tab(context):
    """Return the tab of a context as it was when it was new."""
    page = context.pages[0] if context.pages else context.new_page()
    page.set_default_timeout(300_000.0)
    page.emulate_media(media="null", color_scheme="light")
    page.mouse.move(-9, -9)  # over nothing
    return page


def axe_core():
    """Return the script of axe-core, or skip and say why.

    It is where AXE_CORE says, or where npm has put it: here, or for everybody.
    """
    folders = [ROOT / "node_modules"]
    if npm := shutil.which("npm"):
        root = subprocess.run([npm, "root", "-g"], capture_output=True, check=False)
        folders.append(Path(root.stdout.decode().strip()))
    paths = [folder / "axe-core" / "axe.min.js" for folder in folders]
    named = os.environ.get("AXE_CORE")
    for path in [Path(named)] if named else paths:
        if path.is_file():
            return path.read_text(encoding="utf-8")
    pytest.skip("no axe-core: AXE_CORE names no file, and npm has not installed it")


def written(folder, document):
    """Write the page of a document to a file."""
    path = folder / "page.html"
    path.write_text(render_page(document), encoding="utf-8")
    return path
