"""Ghostball's engine and external engines with one interface, `Scene` -> `Result`.

    >>> from ghostball.reference_adapters import make_engine
    >>> make_engine("pymunk:dt=1e-3,contact_steps=exact").simulate(scene)

Importing this package imports no engine; `make_engine` and `engine_class` do. The names of this
package, listed in `__init__.pyi`, are imported on first use, so that a process that needs only a
small module, such as `output`, starts quickly.
"""

import lazy_loader

if not __name__.startswith("ghostball."):  # otherwise each class would exist twice
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
