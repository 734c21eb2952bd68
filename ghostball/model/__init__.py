"""The data types that all engines share: scenes, and the results of simulating them.

    >>> from ghostball.model import Ball, Scene
    >>> scene = Scene(name="roll", balls=[Ball(id="cue", position=(0, 0), velocity=(1, 0))])
    >>> scene.save("roll.toml")

This package needs no compiler and imports no engine.
"""

from ghostball.model.errors import (
    EngineFailedError,
    GhostballError,
    SceneError,
    UnsupportedSceneError,
)
from ghostball.model.events import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    OBSTACLE_KINDS,
    RECORDS,
    EventKind,
    Events,
    Record,
    Status,
)
from ghostball.model.result import Result, event_dict, first_energy, initial_state
from ghostball.model.scene import (
    CUSHIONS,
    INWARD,
    POCKETS,
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    CushionName,
    Disc,
    Hole,
    Obstacle,
    Physics,
    Rack,
    Scene,
    Segment,
    Side,
    Strike,
    Table,
    partner_index,
    partner_name,
    rack,
    rolling_angular_velocity,
)
from ghostball.model.trajectory import (
    Energy,
    ExactTrajectory,
    Phase,
    SampledTrajectory,
    Samples,
    Trajectory,
    energy_of,
)

__all__ = [
    "COLLISION_KINDS",
    "CUSHIONS",
    "EVENT_DTYPE",
    "INWARD",
    "OBSTACLE_KINDS",
    "POCKETS",
    "POOL_BALL_MASS",
    "POOL_BALL_RADIUS",
    "RECORDS",
    "Ball",
    "CushionName",
    "Disc",
    "Energy",
    "EngineFailedError",
    "EventKind",
    "Events",
    "ExactTrajectory",
    "GhostballError",
    "Hole",
    "Obstacle",
    "Phase",
    "Physics",
    "Rack",
    "Record",
    "Result",
    "SampledTrajectory",
    "Samples",
    "Scene",
    "SceneError",
    "Segment",
    "Side",
    "Status",
    "Strike",
    "Table",
    "Trajectory",
    "UnsupportedSceneError",
    "energy_of",
    "event_dict",
    "first_energy",
    "initial_state",
    "partner_index",
    "partner_name",
    "rack",
    "rolling_angular_velocity",
]
