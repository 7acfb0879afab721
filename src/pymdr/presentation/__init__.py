"""Figures, texts and files: they take labelled data and callables, never a result. Modules are imported when they are first used."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submodules=("files", "html", "plot", "report", "tables", "text")
)
