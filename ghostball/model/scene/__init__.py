"""Scenes, the input of every engine: validated once, read from and written to TOML."""

from ghostball.model.scene.ball import (
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    rolling_angular_velocity,
)
from ghostball.model.scene.obstacles import (
    POCKETS,
    Disc,
    Hole,
    Obstacle,
    Segment,
    partner_index,
    partner_name,
)
from ghostball.model.scene.physics import Physics
from ghostball.model.scene.rack import Rack, rack
from ghostball.model.scene.scene import Scene, check_whole, json_schema
from ghostball.model.scene.sides import CUSHIONS, INWARD, CushionName, Side
from ghostball.model.scene.strike import Strike, Stroke, stroke_of
from ghostball.model.scene.table import Table

__all__ = [
    "CUSHIONS",
    "INWARD",
    "POCKETS",
    "POOL_BALL_MASS",
    "POOL_BALL_RADIUS",
    "Ball",
    "CushionName",
    "Disc",
    "Hole",
    "Obstacle",
    "Physics",
    "Rack",
    "Scene",
    "Segment",
    "Side",
    "Strike",
    "Stroke",
    "Table",
    "check_whole",
    "json_schema",
    "partner_index",
    "partner_name",
    "rack",
    "rolling_angular_velocity",
    "stroke_of",
]
