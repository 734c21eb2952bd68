"""The suite that says which engine is right: scenes, metrics, truth, criteria, stored results.

Its names, listed in `__init__.pyi`, are imported when they are asked for: a process that needs one
part of this package, such as one that does tasks, would else take a second to import all of it.
"""

import lazy_loader

if not __name__.startswith("ghostball."):  # else there were two of each class
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
