"""Scenes: what every engine simulates, checked once, read from and written to TOML."""

from ghostball.model.scene.parts import (
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    Table,
    rolling_angular_velocity,
)
from ghostball.model.scene.physics import Physics
from ghostball.model.scene.scene import Scene, check_whole, json_schema
from ghostball.model.scene.sides import CUSHIONS, INWARD, CushionName, Side
from ghostball.model.scene.strike import Strike, Stroke, stroke_of

__all__ = [
    "CUSHIONS",
    "INWARD",
    "POOL_BALL_MASS",
    "POOL_BALL_RADIUS",
    "Ball",
    "CushionName",
    "Physics",
    "Scene",
    "Side",
    "Strike",
    "Stroke",
    "Table",
    "check_whole",
    "json_schema",
    "rolling_angular_velocity",
    "stroke_of",
]
