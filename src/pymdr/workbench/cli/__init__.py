"""The command line; ``pymdr/workbench/cli/program.py`` puts it together.

Every command body imports what it needs, so that ``pymdr --help`` stays quick.
"""

from pymdr.workbench.cli.program import app, main

__all__ = ["app", "main"]
