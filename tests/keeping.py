"""What is dear and asked for again: functions and simulations that keep results."""

from __future__ import annotations

import pickle
from contextlib import ExitStack
from functools import cache, partial, wraps
from hashlib import sha256
from unittest.mock import patch

import numpy as np

from budget.calibration import simulation
from budget.inputs import load_catalogue
from budget.methods import execution
from budget.model.scheme import Scheme


def once(function, kept):
    """Return a function that keeps in a dict what a pure one returned for arguments."""

    @wraps(function)
    def asked(*args, **kwargs):
        try:
            content = pickle.dumps((args, kwargs))
        except (AttributeError, TypeError, pickle.PicklingError):
            return function(*args, **kwargs)  # a function in it: nobody can compare it
        key = function.__module__, function.__name__, sha256(content).digest()
        if key not in kept:
            kept[key] = function(*args, **kwargs)
        return kept[key]

    return asked


@cache
def catalogue():
    """Return the devices that ship, read once for all tests of a process."""
    return load_catalogue()


KEPT_VARIATES = 128_000_000  # bytes, in each process


class Variates:
    """What is drawn of each source in each block, drawn once: most of a verdict's time.

    Of what is kept the longest unused goes. That the same is drawn again is asked of
    the drawing itself, where nothing is kept.
    """

    def __init__(self):
        self.kept, self.size = {}, 0
        self.draw_unit, self.stream = execution._draw_unit, execution.stream  # noqa: SLF001

    def patches(self):
        """Return the functions in place of those of the package, by their names."""
        return {"_draw_unit": self._drawn, "stream": partial(_Stream, self.stream)}

    def _drawn(self, group, rng, out):
        """Fill `out` as the package does, of what is kept where it is the same."""
        key = *rng.key, out.shape
        shapes, values = self.kept.pop(key, (None, None))
        if shapes != group.distributions:
            self.size -= 0 if values is None else values.nbytes
            self.draw_unit(group, rng, out)
            shapes, values = group.distributions, out.copy()
            self.size += values.nbytes
        else:
            out[:] = values
        self.kept[key] = shapes, values
        while self.size > KEPT_VARIATES:
            _, oldest = self.kept.pop(next(iter(self.kept)))
            self.size -= oldest.nbytes


class _Stream:
    """A random stream that is made when something is drawn from it."""

    def __init__(self, make, *key):
        self.make, self.key = make, key

    def __getattr__(self, name):
        made = self.make(*self.key)
        self.__dict__.update(
            {n: getattr(made, n) for n in ("standard_normal", "random")}
        )
        return getattr(made, name)


class Pulses:
    """Runs of one simulated test, drawn, counted and calibrated once.

    What the sources of a run are and what its windows count depends on no formula and
    no reference; what is calibrated from it depends on no reference.
    """

    def __init__(self, sensors, procedure, *, seed, only=None):
        self.sensors, self.procedure = sensors, procedure
        self.seed, self.only = seed, only
        self.kept = {}

    def errors(self, runs, *, reference, procedure=None):
        """Return the errors of runs, shape (runs, n_outputs), by any formulas."""
        plan = procedure or self.procedure
        how = pickle.dumps(plan), Scheme.estimate
        keys = {
            "draw_source": lambda owner, line, *_: (run, owner, line.name),
            "_count": lambda sensor, *rest: (run, sensor.kind, rest[-1].window),
            "_calibrate": lambda sensor, *_: (run, sensor.kind, how),
        }
        found = []
        with ExitStack() as stack:
            for name, key_of in keys.items():
                stack.enter_context(self._keep(name, key_of))
            for run in range(runs):
                one = simulation.simulate(
                    self.sensors,
                    plan,
                    run=run,
                    seed=self.seed,
                    reference=reference,
                    only=self.only,
                )
                found.append(one)
        return np.array(found)

    def _keep(self, name, key_of):
        """Return a patch of the simulation: one of its steps keeps what it returned."""
        step = getattr(simulation, name)

        def kept(*args, **kwargs):
            key = name, *key_of(*args)
            if key not in self.kept:
                self.kept[key] = step(*args, **kwargs)
            return self.kept[key]

        return patch.object(simulation, name, kept)
