"""Engines behind one protocol, each `Scene` -> `Result`: ours and the foreign ones.

    >>> from ghostball.reference_adapters import make_engine
    >>> make_engine("pymunk:dt=1e-3,contact_steps=exact").simulate(scene)

Importing this package imports no engine: that waits for `make_engine` or `engine_class`. Its names,
listed in `__init__.pyi`, are imported when they are asked for: a process that only needs one light
module of it, such as `output`, starts at once.
"""

import lazy_loader

if not __name__.startswith("ghostball."):  # else there were two of each class
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
