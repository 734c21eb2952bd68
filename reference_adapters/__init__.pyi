from .base import (
    EngineBase as EngineBase,
    EngineError as EngineError,
    EngineSettings as EngineSettings,
    ReferenceEngine as ReferenceEngine,
    resolution_of_step as resolution_of_step,
)
from .function import plays as plays
from .recording import Recorder as Recorder
from .registry import (
    EngineUnavailableError as EngineUnavailableError,
    engine_class as engine_class,
    engine_name as engine_name,
    engine_names as engine_names,
    make_engine as make_engine,
    names_class as names_class,
    parse_spec as parse_spec,
)
