"""Run all benchmarks, or those named: ``python -m benchmarks normal_contact``."""

import importlib
import sys

ALL = (
    "normal_contact",
    "measured",
    "adhesion",
    "friction",
    "memory",
    "first_use",
    "impact",
    "rough",
    "layers",
    "engines",
    "law",
    "stepping",
    "stress",
    "nanoindentation",
)

for name in sys.argv[1:] or ALL:
    for ratio in importlib.import_module(f"benchmarks.{name}").ratios():
        print(ratio, flush=True)
