"""How like a real table an engine can be made to play: its best settings, and what was measured."""

from __future__ import annotations

from ghostball.model import Result, Scene
from ghostball.model.features import check_supported
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.ball_families import oblique_hits, throw
from ghostball.validation.measured.cloth_families import pool_rolling
from ghostball.validation.measured.cushion_families import banks, carom_rebounds, snooker_rebounds
from ghostball.validation.measured.family import Family, Likeness, Measured
from ghostball.validation.measured.play import Play

__all__ = ["Family", "Likeness", "Measured", "likeness"]


def likeness(label: str, engine: ReferenceEngine, play: Play) -> Likeness:
    """Return how like a real table an engine can be made to play.

    `play` plays a scene on it, and records the motion; it gets no scene that the engine lacks
    something of, so that no process starts for that.
    """

    def checked(scene: Scene) -> Result:
        check_supported(engine.name, engine.capabilities, scene)
        return play(scene)

    return Likeness(
        label=label,
        families=(
            *carom_rebounds(engine, checked),
            pool_rolling(engine, checked),
            banks(engine, checked),
            snooker_rebounds(engine, checked),
            *oblique_hits(engine, checked),
            throw(engine, checked),
        ),
    )
