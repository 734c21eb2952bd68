"""The in-house continuous-collision engine, and the types that every engine of the harness speaks.

    >>> from engine import Ball, Scene, simulate
    >>> scene = Scene(name="roll", balls=[Ball(id="cue", position=(0, 0), velocity=(1, 0))])
    >>> simulate(scene).rest_time
    5.098...

Geometry
--------
The table lies in the plane z = 0, from (0, 0) to (length, width). Balls move in the plane of their
centres: two touch where their centres are the sum of their radii apart in that plane, also when the
radii differ, as in the paper; a ball touches a cushion where its centre is a radius away from it.

Importing this package compiles nothing and loads no compiler: that waits for the first `simulate`.
"""

from engine.errors import GhostballError, SceneError, UnsupportedSceneError
from engine.result import EVENT_DTYPE, EventKind, Record, Result, Status
from engine.scene import CUSHIONS, Ball, Physics, Scene, Table
from engine.simulate import simulate, warm_up
from engine.trajectory import Energy, ExactTrajectory, SampledTrajectory, Samples, Trajectory

__all__ = [
    "CUSHIONS",
    "EVENT_DTYPE",
    "Ball",
    "Energy",
    "EventKind",
    "ExactTrajectory",
    "GhostballError",
    "Physics",
    "Record",
    "Result",
    "SampledTrajectory",
    "Samples",
    "Scene",
    "SceneError",
    "Status",
    "Table",
    "Trajectory",
    "UnsupportedSceneError",
    "simulate",
    "warm_up",
]
