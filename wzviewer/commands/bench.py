"""``wzviewer bench``: the figures of one machine, as one flat object.

Every figure is measured here and now; keys are stable.  Times are medians of several runs in one
process, so compare ratios within a run rather than figures across machines.
"""

import argparse
import importlib
import json
import platform
import sys
from typing import Any

BENCHES = {
    "render": "bench_render",
    "generate": "bench_generate",
    "optimize": "bench_optimize",
    "precision": "bench_precision",
    "transition": "bench_transition",
}


def run(options: argparse.Namespace) -> None:
    """Runs one bench and prints a table, or one JSON object."""
    module = importlib.import_module(f"wzviewer.commands.{BENCHES[options.what]}")
    record: dict[str, Any] = {"bench": options.what, "machine": machine(), **module.measure(options)}
    if options.json:
        sys.stdout.write(json.dumps(record) + "\n")
        return
    width = max(len(key) for key in record)
    for key, value in record.items():
        shown = f"{value:.6g}" if isinstance(value, float) else str(value)
        sys.stdout.write(f"{key:{width}}  {shown}\n")


def machine() -> str:
    """Processor and number of usable cores."""
    import os

    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores"
