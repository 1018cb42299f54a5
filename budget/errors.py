"""Errors that a person reads: where, what was found, what is allowed, what to do."""

from __future__ import annotations

from dataclasses import dataclass


class BudgetError(Exception):
    """Base of every error this package raises on purpose; exit code 2."""


@dataclass(frozen=True, kw_only=True)
class Issue:
    """One thing wrong in one file, at the place where a person must look."""

    file: str
    line: int  # from 1
    column: int  # from 1
    field: str  # dotted path in the file, "" for the file as a whole
    message: str  # what was found, what is allowed, what to do

    def __str__(self) -> str:
        """Format as `file:line:column: field: message`."""
        field = f"{self.field}: " if self.field else ""
        file = self.file.replace("\n", "\\n")  # an issue is one line
        return f"{file}:{self.line}:{self.column}: {field}{self.message}"


class SpecError(BudgetError):
    """One or more things wrong in the files a user wrote, all found at once."""

    def __init__(self, issues: tuple[Issue, ...]) -> None:
        """Keep the issues; the text is one of them a line."""
        super().__init__("\n".join(str(issue) for issue in issues))
        self.issues = issues


class UnitError(BudgetError):
    """A text is no quantity, or has not the unit that is needed here."""


class CallError(BudgetError):
    """The call itself is wrong: options or names that do not fit together."""


class NotThereError(CallError, KeyError):
    """A result has nothing of that name."""

    def __str__(self) -> str:
        """Return the message, which KeyError would quote."""
        return str(self.args[0])


class ProblemError(BudgetError):
    """A Problem contradicts itself: shapes, names or distributions do not fit."""


class WorkerError(BudgetError):
    """Work was given to another process or machine and did not come back."""


class OutputError(BudgetError):
    """A result cannot be written where it should go."""


class ReferenceFileError(BudgetError):
    """A stored reference budget cannot be read or be computed again."""


def moved(name: str, module: str) -> ImportError:
    """Return what says where a name of a module is, of those that jcgm has now."""
    return ImportError(
        f"{module}.{name} is jcgm.{name} now: `import jcgm`, which is installed with "
        "budget (docs/problems.md)",
        name=name,
    )
