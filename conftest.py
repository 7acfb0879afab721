"""Doctests of modules that need an optional package are collected where it is installed."""

from importlib.util import find_spec

collect_ignore = (
    []
    if find_spec("panel")
    else [
        f"src/pymdr/explore/{name}.py"
        for name in ("files", "notebook", "page", "pane", "serve", "teaching", "views", "widgets")
    ]
)
