"""Where results go: standard output, files and pages, and what they say of the call."""

from __future__ import annotations

import os
import shlex
import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from typing import TYPE_CHECKING

from budget.cli.options import STDOUT
from budget.cli.streams import console, in_line, say_written, talk
from budget.errors import CallError
from budget.journal import note_read
from budget.language import ENGLISH, speaking
from budget.names import time_text

if TYPE_CHECKING:
    from collections.abc import (
        Callable,
        Collection,
        Iterable,
        Iterator,
        Mapping,
        Sequence,
    )

    import typer

    from budget.cli.options import OutputFiles
    from budget.report.blocks import Document, Section
    from budget.results import Budget
    from budget.settings import Inputs


def check_destinations(
    json: Path | None,
    csv: Path | None,
    *others: Path,
    inputs: Iterable[str | Path | None] = (),
) -> None:
    """Refuse outputs that cannot be, before anything is computed; '-' is stdout.

    None of the files to be read (FILE#VARIANT among them) may be overwritten.

    Raises
    ------
    CallError
        Two documents would go to stdout.
    OutputError
        A file cannot be written, or is an input.
    """
    from budget.inputs.files import find
    from budget.report.files import check_targets

    if json == STDOUT and csv == STDOUT:
        raise CallError(
            "--json - and --csv - would both write to stdout; "
            "send one of them to a file"
        )
    for name in inputs:
        if name is not None:
            note_read(find(name).path)
    check_targets(path for path in (json, csv, *others) if path and path != STDOUT)


def check_files(
    out: OutputFiles,
    inputs: Inputs,
    devices: Iterable[str] | None = None,
    *others: Path | None,
    more: Iterable[str | Path | None] = (),
) -> None:
    """Refuse outputs that cannot be; as check_destinations, with pages.

    `others` are written besides, `more` are read.

    Raises
    ------
    CallError
        A page has another suffix.
    """
    if out.output:
        from budget.report.rendering import check_suffixes

        check_suffixes(out.output, out.paper)
    written = [one for one in (*out.output, *others) if one is not None]
    read = [*(devices or ()), *more, *inputs.files]
    check_destinations(out.json, out.csv, *written, inputs=read)


@contextmanager
def printing() -> Iterator[None]:
    """Let a reader that stops reading, such as `head`, end the program in silence.

    Only while results are printed: elsewhere a broken pipe is an error to be told.
    """
    if not hasattr(signal, "SIGPIPE") or current_thread() is not main_thread():
        yield
        return
    before = signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    try:
        yield
        sys.stdout.flush()
    finally:
        signal.signal(signal.SIGPIPE, before)


def hand_out(
    documents: Sequence[tuple[Path | None, Callable[[], str | Iterable[str]]]],
    sections: Callable[[], Iterable[Section]] | None = None,
    *,
    title: str = "",
    pages: Mapping[Path, str | bytes] | None = None,
    language: str = ENGLISH,
) -> None:
    """Write the documents asked for; print the one for stdout, or the sections.

    Of each document where it goes, None for nowhere, and what makes its text, whole or
    in pieces. `pages` are further files, which a person is told of. Sections are made
    and printed in that language; documents are for programs, and English.
    """
    from budget.report.files import write_all

    wanted = {path: text for path, text in documents if path is not None}
    on_stdout = wanted.pop(STDOUT, None)
    pages = pages or {}
    write_all({**{path: text() for path, text in wanted.items()}, **pages})
    say_written(pages)
    with printing():
        if on_stdout is not None:
            text = on_stdout()
            sys.stdout.writelines([text] if isinstance(text, str) else text)
        elif sections is not None:
            with speaking(language):
                print_page(sections(), title=title)


def print_page(sections: Iterable[Section], *, title: str = "") -> None:
    """Print sections for people, under a title if there is one."""
    from budget.report.terminal import TerminalPage, print_sections

    page = TerminalPage(console())
    page.heading(title, style="bold")
    print_sections(sections, page)


def deliver(
    budget: Budget, out: OutputFiles, *, pages: Mapping[Path, str | bytes] | None = None
) -> None:
    """Print the budget for people, or the document asked for; write the files."""
    from budget.report.document import to_csv, to_json

    def sections() -> Iterable[Section]:
        from budget.report.analysis.groups import budget_answer
        from budget.report.analysis.mission import mission_answer

        answer = budget_answer if budget.mission is None else mission_answer
        return answer(budget, full=out.full)

    if out.csv == STDOUT:  # the only output that has no room for them
        for text in budget.warnings:
            talk(f"warning: {text}")
    documents = [(out.json, lambda: to_json(budget)), (out.csv, lambda: to_csv(budget))]
    hand_out(
        documents, sections, title=budget.title, pages=pages, language=out.language
    )


def check_yaml(write: Path | None, kind: str) -> None:
    """Refuse a file of that kind that would not be read back.

    Raises
    ------
    CallError
        Its name does not end as those of such files do.
    """
    if write is not None and write.suffix.lower() not in {".yaml", ".yml"}:
        raise CallError(
            f"--write {write}: a {kind} file ends in .yaml or .yml; give it that name"
        )


def pages_of(
    document: Document, paths: Sequence[Path], paper: str
) -> dict[Path, str | bytes]:
    """Return the contents of the files; what no font has is named on stderr."""
    from budget.report.rendering import render_pages

    return render_pages(
        document,
        paths,
        paper=paper,
        warn=lambda path, text: talk(f"warning: {in_line(path)}: {text}"),
    )


def pages_asked(
    context: typer.Context, out: OutputFiles, make: Callable[..., Document]
) -> dict[Path, str | bytes]:
    """Return the contents of the files that were asked for, none where there are none.

    `make` takes `date` and `command_line`, and returns what is in them.
    """
    from budget.report.rendering import document_date

    if not out.output:
        return {}
    with speaking(out.language):
        made = make(date=document_date(), command_line=command_line(context))
    return pages_of(made, out.output, out.paper)


# Where results go, on what sheets, and who computes them changes no number.
WITHOUT_EFFECT = frozenset(
    {"output", "paper", "json", "csv", "workers", "cluster", "accept", "exit_code"}
    | {"full", "write"}
)
# Of these a slash is that of a unit, not of a folder.
LITERAL = frozenset({"changes", "only", "outputs", "number"})


def command_line(
    context: typer.Context,
    *,
    command: str = "",
    devices: Sequence[str] | None = None,
    without: Collection[str] = (),
) -> str:
    """Return the present call, files by base name, without what changes no number.

    'budget report hg4930.yaml --requirement navigation-grade.yaml', or that of another
    command, of other devices, without some of its parameters.
    """
    parts = command_parts(context, command=command, devices=devices, without=without)
    return "".join(parts)


def command_parts(
    context: typer.Context,
    *,
    command: str = "",
    devices: Sequence[str] | None = None,
    without: Collection[str] = (),
) -> tuple[str, str]:
    """Return a command line in two parts, between which options can be put.

    The second is empty but for names that begin with a dash, which stand after `--`.
    """
    words = ["budget", command or context.info_name or ""]
    arguments: list[str] = []
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        given = source is not None and source.name == "COMMANDLINE"
        replaced = devices is not None and name == "devices"
        if replaced:
            arguments += devices or ()
        if not given or replaced or name in WITHOUT_EFFECT or name in without:
            continue
        value = context.params[name]
        values = value if isinstance(value, (list, tuple)) else [value]
        if parameter.param_type_name == "argument":
            arguments += [_base_name(one) for one in values]
        elif isinstance(value, bool):
            words += [parameter.opts[0]] if value else []
        else:
            for one in values:
                words += [parameter.opts[0], _spelled(name, one)]
    if any(one.startswith("-") and one != "-" for one in arguments):
        return shlex.join(words), f" -- {shlex.join(arguments)}"
    return shlex.join([*words[:2], *arguments, *words[2:]]), ""


def _spelled(name: str, value: object) -> str:
    """Write a value as one types it; a time in its unit."""
    if name == "at" and isinstance(value, float):
        return time_text(value)
    return str(value) if name in LITERAL else _base_name(value)


def _base_name(value: object) -> str:
    """Write a value; of a file its name, with the variant after it."""
    # In any locale the characters of a name, not what stands for its bytes.
    text = os.fsencode(str(value)).decode("utf-8", errors="replace")
    file, hash_sign, variant = text.partition("#")
    is_file = isinstance(value, Path) or "/" in file or "\\" in file
    return Path(file).name + hash_sign + variant if is_file else text
