"""Start of the command line: `budget`, and `python -m budget`.

Nothing is loaded here that takes time: from the first lines on a signal ends the run
in words, also where it comes while the rest is loaded.
"""

from __future__ import annotations

import os
import signal

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType
    from typing import NoReturn

SIGNALS = {"SIGINT": "interrupted", "SIGTERM": "ended on request", "SIGHUP": "hung up"}


def main() -> None:
    """Load the command line and run it.

    A signal that is ignored stays so, as under `nohup`.
    """
    usual = (signal.SIG_DFL, signal.default_int_handler)
    known = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    before = {one: signal.getsignal(one) for one in known}
    ours = [number for number in known if before[number] in usual]
    for number in ours:
        signal.signal(number, _end)
    from budget.cli import main as run

    for number in ours:
        signal.signal(number, before[number])
    try:
        run()
    finally:
        for number in ours:  # all has been said: from here on they end it in silence
            signal.signal(number, signal.SIG_DFL)


def _end(number: int, _: FrameType | None) -> NoReturn:
    """End before anything was begun, with the code that shells give to a signal."""
    os.write(
        2, f"{SIGNALS[signal.Signals(number).name]}; nothing was written\n".encode()
    )
    os._exit(128 + number)


if __name__ == "__main__":
    main()
