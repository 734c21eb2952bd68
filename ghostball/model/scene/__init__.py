"""Scenes: what every engine simulates, checked once, read from and written to TOML."""

from ghostball.model.scene.parts import (
    CUSHIONS,
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    CushionName,
    Table,
    rolling_angular_velocity,
)
from ghostball.model.scene.physics import Physics
from ghostball.model.scene.scene import Scene, check_whole, json_schema

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
