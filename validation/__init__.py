"""Validation of engines: scenes, metrics, reference results, criteria, stored results.

Names in `__init__.pyi` are imported on first use, because importing the whole package takes a
second, and worker processes need only a part of it.
"""

import lazy_loader

if not __name__.startswith("ghostball."):  # otherwise each class would exist twice
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
