from .base import (
    EngineBase as EngineBase,
    EngineError as EngineError,
    EngineSettings as EngineSettings,
    ReferenceEngine as ReferenceEngine,
)
from .registry import (
    EngineUnavailableError as EngineUnavailableError,
    engine_class as engine_class,
    engine_name as engine_name,
    engine_names as engine_names,
    make_engine as make_engine,
    names_class as names_class,
    parse_spec as parse_spec,
)
