"""How many examples the fuzz tests try: always the same ones, or fresh ones."""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

# FUZZ_EXAMPLES=20000 pytest tests/fuzz/test_files.py searches on, anew each time.
FRESH = int(os.environ.get("FUZZ_EXAMPLES", "0"))


def examples(number):
    """Return settings with that many fixed examples, or FRESH random ones.

    No deadline: on a busy machine it fails at random; test_cost.py counts steps.
    """
    return settings(
        max_examples=FRESH or number,
        derandomize=not FRESH,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )
