"""The command line, assembled in ``pymdr/workbench/cli/program.py``.

Commands import what they need in their bodies, so that ``pymdr --help`` stays quick.
"""

from pymdr.workbench.cli.program import app, main

__all__ = ["app", "main"]
