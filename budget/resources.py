"""Where shipped specs and templates are, in the checkout or the wheel; their reader."""

from __future__ import annotations

import os
import sys
import traceback
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path
from typing import TYPE_CHECKING

from budget.errors import OutputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from jinja2 import Environment
    from jinja2.bccache import Bucket
    from jinja2.sandbox import SandboxedEnvironment
    from markupsafe import Markup

_own: ContextVar[Path | None] = ContextVar("own templates", default=None)
PACKAGE = Path(__file__).resolve().parent
TEMPLATES = "templates"
SHIPPED = "shipped/"  # before the name of a template that shall not be one's own
LONGEST_SAID = 300  # characters of what is wrong with a template
LARGEST_PICTURE = 1_000_000  # bytes
PICTURES = {
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
}


def shipped(name: str, *under: str) -> Path:
    """Return the folder `specs` or `templates`, or what is under it.

    In a checkout, an editable install included, they stand beside the package, where
    people edit them; a wheel carries them inside. The copy that an editable install
    leaves in site-packages goes stale and is never read: this looks only around the
    file that is running.
    """
    if (PACKAGE.parent / "pyproject.toml").is_file():
        return PACKAGE.parent.joinpath(name, *under)
    return PACKAGE.joinpath("_shipped", name, *under)


def first_stem(file: str) -> str:
    """Return the name of a file up to its first dot: 'x' of 'y/x.yaml.j2'."""
    name = Path(file)
    while name.suffix:
        name = name.with_suffix("")
    return name.name


def names_in(folder: str, *under: str) -> list[str]:
    """Return the names of what ships in a folder, up to the first dot of each.

    With those of templates of one's own.
    """
    own = _own.get() if folder == TEMPLATES else None
    folders = [shipped(folder, *under), *([own.joinpath(*under)] if own else ())]
    files = (file for one in folders if one.is_dir() for file in one.iterdir())
    return sorted({first_stem(file.name) for file in files})


@contextmanager
def templates_of(folder: str | Path | None) -> Iterator[None]:
    """Let the templates of a folder go before those that ship, while it lasts.

    They stand under the names of the shipped ones, which they may extend or include
    as `shipped/NAME`.

    Raises
    ------
    OutputError
        There is no such folder, or it has no file in the place of a template.
    """
    path = None if folder is None else Path(folder)
    if path is not None and not path.is_dir():
        raise OutputError(
            f"{folder}: no folder of templates is there; give one that has files under "
            "the names of those of the program, as page.css or pages/limits.md.j2"
        )
    token = _own.set(path)
    try:
        yield
    finally:
        _own.reset(token)


def own_templates() -> Path | None:
    """Return the folder whose templates go before those that ship, if there is one."""
    return _own.get()


def template_file(name: str) -> Path:
    """Return the file of a template: one's own, else that which ships."""
    own = _own.get()
    if own is not None and (own / name).is_file():
        return own / name
    return shipped(TEMPLATES, name)


@contextmanager
def telling(name: str) -> Iterator[None]:
    """Tell what is wrong with a template of one's own, with its file and line.

    Raises
    ------
    OutputError
        What was done with the template failed, or it is missing.
    """
    from jinja2 import TemplateError, TemplateSyntaxError

    own = _own.get()
    try:
        yield
    except OutputError:
        raise
    except TemplateSyntaxError as error:
        if own is None:
            raise
        place = error.filename or str(own / name)
        raise _broken(f"{place}:{error.lineno}", error) from error
    except Exception as error:
        steps = [] if own is None else traceback.extract_tb(error.__traceback__)
        inside = [f for f in steps if own and Path(f.filename).is_relative_to(own)]
        if inside:
            place = f"{inside[-1].filename}:{inside[-1].lineno}"
            raise _broken(place, error) from error
        is_shown = isinstance(
            error, TemplateError | LookupError | TypeError | ValueError
        )
        if own is None or not is_shown:
            raise
        # Where a page that ships asks one's own for what it lacks, the error names it.
        is_own = (own / name).is_file()
        if not is_own and not isinstance(error, TemplateError):
            raise
        raise _broken(str(own / name if is_own else own), error) from error


def _broken(place: str, error: Exception) -> OutputError:
    """Say where a template is broken, and what the program says of it."""
    said = " ".join(str(error).split()) or type(error).__name__
    return OutputError(
        f"{place}: {said[:LONGEST_SAID]}; mend this template (docs/templates.md), or "
        "leave --templates out"
    )


def template_environment(**options: object) -> SandboxedEnvironment:
    """Return a jinja2 environment of the templates, with further options.

    A value that is not there is an error, and so is one that is no attribute of what a
    template is given; a line of a tag alone is no line of what is written. Templates of
    one's own go before those that ship.

    Raises
    ------
    OutputError
        By what asks it for a template that is missing.
    """
    from hashlib import sha256

    from jinja2 import (
        BytecodeCache,
        FileSystemLoader,
        StrictUndefined,
        TemplateNotFound,
    )
    from jinja2 import __version__ as jinja_version
    from jinja2.sandbox import SandboxedEnvironment

    own = _own.get()
    ships = shipped(TEMPLATES)
    maker = repr((jinja_version, sorted(map(_called, options.items())), _code()))

    class Kept(BytecodeCache):
        """What templates that ship were compiled to, where Python keeps its own."""

        def get_cache_key(self, name: str, filename: str | None = None) -> str:
            if filename is None or not Path(filename).is_relative_to(ships):
                return ""
            flat = "-".join((TEMPLATES, *Path(name).parts, "compiled"))
            return cache_from_source(str(PACKAGE / f"{flat}.py"))

        def get_source_checksum(self, source: str) -> str:
            return sha256(f"{maker}\n{source}".encode()).hexdigest()

        def load_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError), Path(bucket.key).open("rb") as file:
                bucket.load_bytecode(file)

        def dump_bytecode(self, bucket: Bucket) -> None:
            if not bucket.key or sys.dont_write_bytecode:
                return
            own = Path(f"{bucket.key}-{os.getpid()}")
            with suppress(OSError):
                own.parent.mkdir(parents=True, exist_ok=True)
                own.write_bytes(bucket.bytecode_to_string())
                own.replace(bucket.key)

    folders = [ships] if own is None else [own, ships]

    class Loader(FileSystemLoader):
        """Templates of one's own, and of the program."""

        def get_source(
            self, environment: Environment, template: str
        ) -> tuple[str, str, Callable[[], bool]]:
            name = template.removeprefix(SHIPPED)
            of = self if name == template else FileSystemLoader(ships)
            try:
                return FileSystemLoader.get_source(of, environment, name)
            except UnicodeDecodeError as error:
                raise OutputError(
                    f"{template_file(name)}: found a byte that is not UTF-8, expected "
                    "a text file; write the template in UTF-8"
                ) from error
            except TemplateNotFound as error:
                raise OutputError(
                    f"{shipped('templates', name)}: this template is missing; it "
                    "comes with the program: install that again"
                    if own is None
                    else f"{own / name}: no template is called so, here or in the "
                    "program; name one that there is"
                ) from error

    environment = SandboxedEnvironment(
        loader=Loader(folders),
        bytecode_cache=Kept(),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        **options,
    )
    environment.filters["embedded"] = embedded
    return environment


def _called(option: tuple[str, object]) -> tuple[str, str]:
    """Return an option of an environment with what it is called, not where it is."""
    name, value = option
    each = value if isinstance(value, list | tuple) else (value,)
    return name, " ".join(getattr(one, "__qualname__", str(one)) for one in each)


@cache
def _code() -> tuple[tuple[str, int], ...]:
    """Return what tells one state of the program from another: filters are compiled."""
    files = sorted(PACKAGE.rglob("*.py"))
    return tuple((str(one), one.stat().st_mtime_ns) for one in files)


def embedded(name: str) -> Markup:
    """Return a picture of one's own folder as an address that a page carries.

    Raises
    ------
    OutputError
        It is not there, of another kind than PICTURES, or larger than LARGEST_PICTURE.
    """
    from base64 import b64encode

    from markupsafe import Markup

    suffix = Path(name).suffix.lower()
    content = own_pictures().get(name)
    if content is None:
        raise OutputError(
            f"{(_own.get() or Path()) / name}: no such picture is there; put it into "
            f"the folder of the templates as {', '.join(PICTURES)}"
        )
    address = f"data:{PICTURES[suffix]};base64,{b64encode(content).decode()}"
    return Markup(address)  # noqa: S704 - of letters and digits


def own_pictures() -> dict[str, bytes]:
    """Return the pictures in the folder of one's own templates by their names.

    Raises
    ------
    OutputError
        One is larger than LARGEST_PICTURE, or cannot be read.
    """
    own = _own.get()
    found: dict[str, bytes] = {}
    for path in sorted(own.iterdir()) if own else ():
        if path.suffix.lower() not in PICTURES or not path.is_file():
            continue
        if path.stat().st_size > LARGEST_PICTURE:
            raise OutputError(
                f"{path}: found a picture of {path.stat().st_size} bytes, allowed are "
                f"{LARGEST_PICTURE}; make it smaller"
            )
        try:
            found[path.name] = path.read_bytes()
        except OSError as error:
            raise OutputError(f"{path}: cannot read it ({error.strerror})") from error
    return found
