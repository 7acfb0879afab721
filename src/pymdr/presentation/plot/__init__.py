"""Figures: the contact above its line of springs, curves and loops, and fields.

Everything is drawn on :class:`matplotlib.figure.Figure` objects, without pyplot and its global state; the axes can
be restyled afterwards. Names stand in ``__init__.pyi`` and are imported when they are first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
