"""Ghostball: a comparative physics-validation harness for billiards, and the engine inside it.

    >>> from ghostball import Scene, simulate
    >>> simulate(Scene.load("break.toml")).rest_positions

This module exports the public names; `__init__.pyi` lists the module that defines each name. A name
is imported on first use, so that `import ghostball` and `ghostball --help` don't wait for numpy and
the engines.

In a notebook the package `reports` is imported at once, because it draws scenes and results there.

In the repository, the folders `engine`, `reference_adapters`, `validation` and `reports` lie beside
this package, and symbolic links make them subpackages. A wheel contains them as subpackages.
"""

import os
import sys
from importlib import import_module

try:
    import lazy_loader
except ModuleNotFoundError:
    if sys.argv[:1] != ["-m"]:  # not `python -m ghostball`
        raise
    sys.stderr.write(
        f"ghostball: {sys.executable} doesn't have the packages that Ghostball needs. In a clone, "
        "`make smoke` installs them into .venv: then run .venv/bin/ghostball. Or install them with "
        "`python -m pip install '.[compiler]'`\n"
    )
    raise SystemExit(2) from None

_HERE = os.path.dirname(__file__)
if not os.path.isdir(os.path.join(_HERE, "engine")):
    # A clone on Windows usually has text files in place of the symbolic links, and a source archive
    # has neither. Then the subpackages are found in the parent folder.
    __path__.append(os.path.dirname(_HERE))

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

if "IPython" in sys.modules:
    # By name, like the public names: this module has no import statement for a subpackage.
    import_module("ghostball.reports")
