"""``python -m pymdr``."""

from pymdr.workbench.cli import main

main()
