from .engine import (
    Batch as Batch,
    Strokes as Strokes,
    simulate as simulate,
    simulate_many as simulate_many,
    simulate_starts as simulate_starts,
    simulate_sweep as simulate_sweep,
)
from .model import (
    Ball as Ball,
    EngineFailedError as EngineFailedError,
    EventKind as EventKind,
    ExactTrajectory as ExactTrajectory,
    GhostballError as GhostballError,
    Physics as Physics,
    Rack as Rack,
    Result as Result,
    SampledTrajectory as SampledTrajectory,
    Scene as Scene,
    SceneError as SceneError,
    Status as Status,
    Strike as Strike,
    Table as Table,
    UnsupportedSceneError as UnsupportedSceneError,
    rack as rack,
)
from .model.features import Capability as Capability, Feature as Feature
from .reference_adapters import (
    EngineBase as EngineBase,
    Recorder as Recorder,
    ReferenceEngine as ReferenceEngine,
    make_engine as make_engine,
    plays as plays,
)
from .reports.plot import film as film, plot as plot
from .validation.results.store import Results as Results
from .validation.scenes.library import find_scene as find_scene
from .validation.suite.suite import run_suite as run_suite
