"""Run all benchmarks, or those named: ``python -m benchmarks normal_contact``.

The ratios, medians of calls that take turns, go into the tables of ``benchmarks/results``, a row for each version; what fell by a third since the version
before is listed at the end. ``--no-record`` only prints.
"""

import argparse
import importlib

import pymdr
from benchmarks.history import record
from benchmarks.timing import Ratio

ALL = (
    "normal_contact",
    "measured",
    "adhesion",
    "friction",
    "memory",
    "soft_adhesion",
    "first_use",
    "impact",
    "rough",
    "layers",
    "engines",
    "law",
    "machines",
    "stepping",
    "stress",
    "nanoindentation",
    "fits",
)

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("names", nargs="*", default=ALL)
parser.add_argument("--no-record", action="store_true")
given = parser.parse_args()

fallen: list[str] = []
for name in given.names:
    ratios = []
    for ratio in importlib.import_module(f"benchmarks.{name}").ratios():
        print(ratio, flush=True)
        if isinstance(ratio, Ratio):
            ratios.append(ratio)
    if ratios and not given.no_record:
        # all commits before a release have one name, that of the release that they prepare
        release, dev, _ = pymdr.__version__.partition(".dev")
        fallen += record(name, ratios, release + dev)
for sentence in fallen:
    print(f"FELL BY A THIRD: {sentence}")
