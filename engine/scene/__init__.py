"""Scenes: what every engine simulates, checked once, read from and written to TOML."""

from ghostball.engine.scene.model import Scene, check_whole, json_schema
from ghostball.engine.scene.parts import (
    CUSHIONS,
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    CushionName,
    Physics,
    Table,
    rolling_angular_velocity,
)

__all__ = [
    "CUSHIONS",
    "POOL_BALL_MASS",
    "POOL_BALL_RADIUS",
    "Ball",
    "CushionName",
    "Physics",
    "Scene",
    "Table",
    "check_whole",
    "json_schema",
    "rolling_angular_velocity",
]
