"""Where shipped specs and templates are, in the checkout or the wheel; their reader."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from budget.errors import OutputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from jinja2 import Environment
    from jinja2.sandbox import SandboxedEnvironment

PACKAGE = Path(__file__).resolve().parent


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
    """Return the names of what ships in a folder, up to the first dot of each."""
    return sorted(first_stem(file.name) for file in shipped(folder, *under).iterdir())


def template_environment(**options: object) -> SandboxedEnvironment:
    """Return a jinja2 environment of the shipped templates, with further options.

    A value that is not there is an error, and so is one that is no attribute of what a
    template is given; a line of a tag alone is no line of what is written.

    Raises
    ------
    OutputError
        By what asks it for a template that is missing.
    """
    from jinja2 import FileSystemLoader, StrictUndefined, TemplateNotFound
    from jinja2.sandbox import SandboxedEnvironment

    class ShippedLoader(FileSystemLoader):
        """Templates of the program."""

        def get_source(
            self, environment: Environment, template: str
        ) -> tuple[str, str, Callable[[], bool]]:
            try:
                return super().get_source(environment, template)
            except TemplateNotFound as error:
                raise OutputError(
                    f"{shipped('templates', template)}: this template is missing; it "
                    "comes with the program: install that again"
                ) from error

    return SandboxedEnvironment(
        loader=ShippedLoader(shipped("templates")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        **options,
    )
