"""The command that makes a document again, as provenance quotes it."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import typer

# Where results go and who computes them changes no number.
WITHOUT_EFFECT = frozenset({"output", "json", "csv", "workers", "cluster"})


def command_line(context: typer.Context) -> str:
    """Return the present call, files by base name, without what changes no number.

    Parameters
    ----------
    context : typer.Context
        Of the command that runs.

    Returns
    -------
    str
        'budget report hg4930.yaml --requirement navigation-grade.yaml'.
    """
    words = ["budget", context.info_name or ""]
    arguments: list[str] = []
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        given = source is not None and source.name == "COMMANDLINE"
        if not given or name in WITHOUT_EFFECT:
            continue
        value = context.params[name]
        values = value if isinstance(value, (list, tuple)) else [value]
        if parameter.param_type_name == "argument":
            arguments += [_base_name(one) for one in values]
        elif isinstance(value, bool):
            words += [parameter.opts[0]] if value else []
        else:
            for one in values:
                words += [parameter.opts[0], _base_name(one)]
    return shlex.join([*words[:2], *arguments, *words[2:]])


def _base_name(value: object) -> str:
    """Write a value; of a file its name, with the variant after it."""
    # In any locale the characters of a name, not what stands for its bytes.
    text = os.fsencode(str(value)).decode("utf-8", errors="replace")
    file, hash_sign, variant = text.partition("#")
    is_file = isinstance(value, Path) or "/" in file or "\\" in file
    return Path(file).name + hash_sign + variant if is_file else text
