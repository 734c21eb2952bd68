"""Engines behind one protocol, each `Scene` -> `Result`: ours and the foreign ones.

    >>> from reference_adapters import make_engine
    >>> make_engine("pymunk:dt=1e-3,mode=landed").simulate(scene)

Importing this package imports no engine: that waits for `make_engine` or `engine_class`.
"""

from reference_adapters.base import EngineBase, EngineError, EngineSettings, ReferenceEngine
from reference_adapters.registry import (
    EngineUnavailableError,
    engine_class,
    engine_names,
    make_engine,
    make_engine_of_class,
    names_class,
    parse_spec,
    split_specs,
)

__all__ = [
    "EngineBase",
    "EngineError",
    "EngineSettings",
    "EngineUnavailableError",
    "ReferenceEngine",
    "engine_class",
    "engine_names",
    "make_engine",
    "make_engine_of_class",
    "names_class",
    "parse_spec",
    "split_specs",
]
