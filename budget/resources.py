"""Where shipped specs and templates are: in the checkout, or in the wheel."""

from __future__ import annotations

from pathlib import Path

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
