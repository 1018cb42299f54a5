"""Standard streams: closed, full, or of few characters."""

from __future__ import annotations

import codecs
import io
import os
import re
import sys
from typing import TYPE_CHECKING, Any, TextIO

from budget.errors import OutputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from _typeshed import ReadableBuffer
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.segment import Segment

EXIT_BROKEN_PIPE = 141  # SIGPIPE
# C0 without tab and line feed, DEL and C1, line separators, marks and changes of
# direction.
CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f"
    "\u2028\u2029\u202a-\u202e\u2066-\u2069]"
)
ESCAPE = "budget-escape"  # name of our way with characters that a stream cannot take


def prepare_streams() -> None:
    """Give a closed stream a place, and every character a way out.

    A stream that the caller closed is not wanted: what goes there is dropped. Its
    number must be taken all the same, or the next file that is opened would get it,
    and with it whatever a library prints.

    What goes into a pipe or a file is UTF-8 with LF, as the documents are that we write
    ourselves; only PYTHONIOENCODING says otherwise. What an encoding lacks is written
    as JSON escapes it, so that a document stays one. A width of the terminal that is
    none is forgotten.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number: this one
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()
    codecs.register_error(ESCAPE, _escape)
    if os.name == "posix":
        if sys.stdout is sys.__stdout__:
            sys.stdout = _over(_Results(1, "w", closefd=False), sys.stdout)
        if sys.stderr is sys.__stderr__:
            sys.stderr = _over(_Talk(2, "w", closefd=False), sys.stderr)
    columns = os.environ.get("COLUMNS", "80")
    if not columns.isascii() or not columns.isdigit() or int(columns) < 1:
        del os.environ["COLUMNS"]  # rich takes any digits for a width
    if isinstance(sys.stdout, io.TextIOWrapper):
        if sys.stdout.isatty() or "PYTHONIOENCODING" in os.environ:
            sys.stdout.reconfigure(errors=ESCAPE)
        else:
            sys.stdout.reconfigure(encoding="utf-8", errors=ESCAPE, newline="\n")


class _Results(io.FileIO):
    """The end of stdout below all buffers: what cannot arrive ends the run."""

    def write(self, data: ReadableBuffer, /) -> int:
        """Write; a reader that has enough, such as `head`, ends the run in silence."""
        try:
            return super().write(data)
        except BrokenPipeError:
            _drop(self.fileno())
            raise SystemExit(EXIT_BROKEN_PIPE) from None
        except OSError as error:
            _drop(self.fileno())
            raise OutputError(
                f"standard output: the system refused: {error.strerror or error}; "
                "expected a stream that takes what is printed; free the disk or send "
                "it elsewhere"
            ) from None


class _Talk(io.FileIO):
    """The end of stderr below all buffers: talk that cannot arrive changes nothing."""

    def write(self, data: ReadableBuffer, /) -> int:
        """Write, or drop this and all that follows."""
        try:
            return super().write(data)
        except OSError:
            _drop(self.fileno())
            return memoryview(data).nbytes


def _over(end: io.FileIO, stream: TextIO | Any) -> TextIO | Any:  # noqa: ANN401 - as sys has them
    """Return a text stream like the present one over another end."""
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    return io.TextIOWrapper(
        io.BufferedWriter(end),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


def without_controls(text: str) -> str:
    """Write control characters and changes of direction as escapes.

    The name of a file can hold them; a terminal would obey.
    """
    return CONTROL.sub(lambda found: ascii(found[0])[1:-1], text)


def in_line(name: object) -> str:
    """Write a name so that it cannot end its line either."""
    return without_controls(str(name)).replace("\n", "\\n").replace("\t", "\\t")


def talk(text: str, *, end: str = "\n") -> None:
    """Talk on stderr; stdout is for results."""
    sys.stderr.write(f"{without_controls(text)}{end}")
    sys.stderr.flush()  # before the work that it is about


def say_written(paths: Iterable[Path]) -> None:
    """Say which files were written."""
    for path in paths:
        talk(f"{in_line(path)}: written")


def tell(text: str) -> None:
    """Print a result for people on stdout."""
    sys.stdout.write(without_controls(text))


def console() -> Console:
    """Return the console that tables for people are printed on.

    What gives a terminal orders is escaped in their text; the console's own colours
    come after that.
    """
    from rich.console import Console

    class Escaped(Console):
        """A console whose texts give no orders."""

        def render(
            self, renderable: RenderableType, options: ConsoleOptions | None = None
        ) -> Iterator[Segment]:
            """Render, and escape what is text."""
            for part in super().render(renderable, options):
                yield (
                    part
                    if part.control
                    else part._replace(text=without_controls(part.text))
                )

    return Escaped(force_terminal=sys.stdout.isatty())  # whatever FORCE_COLOR says


def _nowhere() -> TextIO:
    """Return a stream that drops what it gets."""
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 - it stays


def _drop(number: int) -> None:
    """Send what a full or broken stream has not taken to nowhere.

    Else Python tries once more at its end, and fails with words of its own.
    """
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, number)
    os.close(nowhere)


def _escape(error: UnicodeError) -> tuple[str, int]:
    r"""Write what cannot be encoded as \uXXXX, in pairs beyond 16 bit."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass")
    pairs = (units[place : place + 2].hex() for place in range(0, len(units), 2))
    return "".join(f"\\u{pair}" for pair in pairs), error.end
