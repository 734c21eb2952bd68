"""What a row of the board is asked in a column: scenes and labels, as its engine can play them."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Any, Final

import numpy as np

from ghostball.model import Scene
from ghostball.model.features import missing_features
from ghostball.reference_adapters.base import EngineError, ReferenceEngine
from ghostball.reference_adapters.registry import make_engine, parse_spec, spec_of
from ghostball.validation.board.column import Column, Settings, scene_path
from ghostball.validation.runs.steps import step_setting

MOST: Final = {"max_steps": 1_000_000, "max_events": 1_000_000}
"""Limits of an engine that is given a step, where it has them."""


def asked(column: Column, row: str) -> list[tuple[str, Scene, str]]:
    """Return what answers a column for a row: runs of scenes on the engine with its settings.

    Of each the name of its file, the scene as the engine can play it, and the label. Nothing where
    the column requires settings that the engine lacks.
    """
    labels = [label for one in column.settings if (label := with_settings(row, one)) is not None]
    if not labels and not column.required:
        labels = [row]
    return [
        (name, playable(board_scene(name), make_engine(label)), label)
        for label, name in product(labels, column.scenes)
    ]


def with_settings(row: str, given: Settings) -> str | None:
    """Return an engine with more settings; None where it lacks one, refuses or says another.

    What the row says stays as it is. An engine that has no choice of steps has the step alone.
    """
    engine = make_engine(row)
    fields = type(engine.settings).model_fields
    settings: dict[str, Any] = {}
    if given.step is not None:
        step = step_setting(engine)
        if step is None:
            return None
        settings = {step: given.step} | {key: most for key, most in MOST.items() if key in fields}
    ends = given.contact_steps
    if ends is not None and ("contact_steps" in fields or given.step is None):
        settings["contact_steps"] = ends
    if not set(settings) <= set(fields):
        return None
    name, said = parse_spec(row)
    label = spec_of(name, said | {key: settings[key] for key in settings if key not in said})
    try:
        made = make_engine(label)
    except EngineError:  # settings that exclude each other
        return None
    asked_for = settings.get("contact_steps")
    has = made.settings.model_dump().get("contact_steps")
    return label if asked_for in (None, has) else None


@cache
def board_scene(name: str) -> Scene:
    """Return a scene of the board."""
    return Scene.load(scene_path(name))


def playable(scene: Scene, engine: ReferenceEngine) -> Scene:
    """Return a scene as an engine can play it: as it is, impact by impact, or with sliding balls.

    Where nothing slows a ball, one that slides goes as one that always rolls; and where no two
    balls are hit at once, nor does the order of impacts matter. As it is where none of that helps.
    """
    sliding: dict[str, Any] = {}
    if scene.physics.motion == "rolling":
        sliding = {"motion": "sliding"}
        if not np.any(scene.rolling_frictions):
            sliding["sliding_friction"] = 0.0
    for more in ({}, sliding):
        for impacts in ({}, {"impacts": "sequential"}):
            changes = {**more, **impacts}
            physics = scene.physics.model_copy(update=changes)
            name = "-".join([scene.name, *(["sliding"] if more else []), *impacts.values()])
            shot = scene.model_copy(update={"physics": physics, "name": name})
            if _can_play(engine, shot):
                return shot
    return scene


def _can_play(engine: ReferenceEngine, scene: Scene) -> bool:
    lacks = getattr(engine, "lacks", None)
    return not missing_features(engine.capabilities, scene) and not (lacks and lacks(scene))
