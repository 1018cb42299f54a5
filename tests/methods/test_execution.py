"""Workers that die: whoever waits for them is told, whatever they leave behind."""

from __future__ import annotations

import os
import signal
import struct
import sys
from concurrent.futures import Future

import pytest

from budget.errors import WorkerError
from budget.methods import execution
from budget.methods.execution import WatchedExecutor, in_order, local_executor

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="kills a process as POSIX does"),
]


def die_in_the_middle_of_a_result(task):
    """Write the head of a result and a part of it, and be killed; other tasks work."""
    if task != 1:
        return task
    frame = sys._getframe()  # noqa: SLF001 - the queue is a variable of the worker's loop
    while "result_queue" not in frame.f_locals:
        frame = frame.f_back
    queue = frame.f_locals["result_queue"]
    with queue._wlock:  # noqa: SLF001
        head = struct.pack("!i", 1000)
        os.write(queue._writer.fileno(), head + b"half of it")  # noqa: SLF001
        os.kill(os.getpid(), signal.SIGKILL)
    return task


def die(task):
    """Be killed at work."""
    os.kill(os.getpid(), signal.SIGKILL)
    return task


@pytest.mark.parametrize("work", [die_in_the_middle_of_a_result, die])
def test_a_worker_that_is_killed_is_an_error_for_people(work):
    """The wait ends, though half a result stands in the pipe; no process is left."""
    with (
        pytest.raises(WorkerError, match="a worker died"),
        local_executor(2) as executor,
    ):
        list(in_order(work, range(8), executor, ahead=4))

    assert not executor._processes  # noqa: SLF001


class Late(WatchedExecutor):
    """Does its work while somebody looks whether anyone is there to do it."""

    def __init__(self):
        self.given = []

    def submit(self, fn, task):
        """Take a task."""
        self.given.append((Future(), fn, task))
        return self.given[-1][0]

    def fault(self):
        """Do what was taken, and find no fault."""
        for future, work, task in self.given:
            try:
                future.set_result(work(task))
            except TimeoutError as error:
                future.set_exception(error)
        self.given.clear()
        return ""


def give_up(_):
    """Do no work, as a model that waits for something."""
    raise TimeoutError("of the model")


def test_a_result_that_comes_during_a_look_is_taken(monkeypatch):
    """It is no loss; a time-out of the work itself is told as what it is."""
    monkeypatch.setattr(execution, "HEARTBEAT", 0.01)

    assert list(in_order(str, range(3), Late(), ahead=2)) == ["0", "1", "2"]
    with pytest.raises(TimeoutError, match="of the model"):
        list(in_order(give_up, range(3), Late(), ahead=2))
