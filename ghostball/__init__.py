"""Ghostball: a comparative physics-validation harness for billiards, and the engine inside it.

    >>> from ghostball import Scene, simulate
    >>> simulate(Scene.load("break.toml")).rest_positions

What a user needs is named here; `__init__.pyi` says where each name comes from. They are imported
when they are asked for: `ghostball --help` must not wait for numpy and the engines, and its
commands import what they call inside functions.

In a notebook the reports are imported at once, because they draw scenes and results there.

`ghostball.engine`, `ghostball.reference_adapters`, `ghostball.validation` and `ghostball.reports`
lie beside this package in the repository, and are linked into it. Installed, they are parts of it.
"""

import os
import sys
from importlib import import_module

import lazy_loader

_HERE = os.path.dirname(__file__)
if not os.path.isdir(os.path.join(_HERE, "engine")):
    # A clone without symbolic links, as is usual on Windows, has a line of text in their place, and
    # an unpacked source archive has nothing: the folders are found where they lie.
    __path__.append(os.path.dirname(_HERE))

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

if "IPython" in sys.modules:
    import_module("ghostball.reports")  # looked up like all names above: nothing here imports them
