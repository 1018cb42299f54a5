"""How much memory a command needs at the least, where a limit leaves it less."""

from __future__ import annotations

from budget.errors import WorkerError

# Address space with which a command ends: Python and the libraries, which set it aside
# without touching it, and for pages what draws them; each a tenth more [byte].
LEAST_SPACE = 480 * 1024**2
SPACE_OF_PAGES = 800 * 1024**2


def check_space(least: int) -> None:
    """Refuse limits of memory under which matrix libraries wait for ever, or end all.

    They ask for room by themselves when they are loaded, and do not take no for an
    answer: this stands before their import.
    """
    try:
        import resource
    except ImportError:  # a system without such limits
        return
    for name, option in (("RLIMIT_AS", "-v"), ("RLIMIT_DATA", "-d")):
        limit, _ = resource.getrlimit(getattr(resource, name))
        if limit != resource.RLIM_INFINITY and limit < least:
            raise WorkerError(
                f"ulimit {option} leaves this process {limit // 1024} kB of memory, "
                f"expected {least // 1024} kB at the least, which the matrix "
                f"libraries set aside; raise it (ulimit {option} unlimited)"
            )
