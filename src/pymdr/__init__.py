"""The Method of Dimensionality Reduction (MDR) in contact mechanics.

Public names stand in ``__init__.pyi`` and are imported when they are first used, so that importing pymdr does no work.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
