"""Where shipped specs, templates and examples are: in the checkout, or in the wheel."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def shipped(name: str) -> Path:
    """Return the folder `specs`, `templates` or `examples`.

    In a checkout, an editable install included, they stand beside the package, where
    people edit them; a wheel carries them inside. The copy that an editable install
    leaves in site-packages goes stale and is never read: this looks only around the
    file that is running.
    """
    if (PACKAGE.parent / "pyproject.toml").is_file():
        return PACKAGE.parent / name
    return PACKAGE / "_shipped" / name
