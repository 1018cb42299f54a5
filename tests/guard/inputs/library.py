"""Results where they are computed: what a notebook shows of them."""

import os
import sys

import budget

os.environ["COLUMNS"] = "100"  # of the prompt, whoever runs this

result = budget.analyze("imu.yaml", requirement="bench.yaml", validate=False)
shown = (repr(result), result.to_markdown(), result._repr_html_())
sys.stdout.write("\n\n".join(shown))
