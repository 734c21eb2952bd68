"""What engines make of measured hits of two balls: their speeds, their ways, and throw."""

from __future__ import annotations

from typing import Any

from ghostball.model import Physics
from ghostball.model.features import Feature, has_feature
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.best import best_cushion
from ghostball.validation.measured.facts import Row, facts_of
from ghostball.validation.measured.family import Family, Measured, family_of
from ghostball.validation.measured.oblique_hits import ObliqueHit, oblique_hit, throw_angle
from ghostball.validation.measured.play import Play

_HIT_SETTINGS = ("ball_restitution", "ball_friction")


def oblique_hits(engine: ReferenceEngine, play: Play) -> tuple[Family, Family]:
    """Return the speeds after five hits of snooker balls, and where the cue ball went."""
    facts = facts_of("hits-snooker")
    speeds = family_of(
        facts,
        "hit-speeds",
        "hit: speeds",
        title=f"{facts.title}: speeds",
        quantity="speed of each ball once it rolls, over that of the cue ball right before",
        unit="1",
    )
    angle = family_of(
        facts,
        "hit-angle",
        "hit: cue ball",
        title=f"{facts.title}: where the cue ball goes",
        quantity=facts.also["cue_angle"].quantity,
        unit=facts.also["cue_angle"].unit,
    )
    physics = Physics(preset="snooker", **_any_cushion("cushion-snooker", engine))
    settings = {name: getattr(physics, name) for name in _HIT_SETTINGS}
    found: list[tuple[Row, ObliqueHit]] = []

    def hits() -> tuple[Measured, ...]:
        found.extend(
            (row, oblique_hit(play, physics, row.given["speed"], row.place)) for row in facts.rows
        )
        return tuple(one for row, hit in found for one in _speeds(row, hit))

    speeds = speeds.played(settings, hits)
    if speeds.lacks:
        return speeds, angle.lacking(speeds.lacks)
    return speeds, angle.played(settings, lambda: tuple(_angle(*one) for one in found))


def _speeds(row: Row, hit: ObliqueHit) -> tuple[Measured, Measured]:
    """Return both balls' speeds, over that before, so that hits of all speeds can be compared."""
    before = row.given["speed"]

    def over_it(what: str, value: float, played: float) -> Measured:
        value, played = value / before, played / before
        return Measured(at=row.place, value=value, error=None, played=played, what=what)

    return (
        over_it("cue ball", row.value, hit.cue_speed),
        over_it("object ball", row.also["object_speed"], hit.object_speed),
    )


def _angle(row: Row, hit: ObliqueHit) -> Measured:
    return Measured(at=row.place, value=row.also["cue_angle"], error=None, played=hit.cue_angle)


def throw(engine: ReferenceEngine, play: Play) -> Family:
    """Return the throw of stunned cuts, with the friction between balls of the preset for pool.

    That is the preset `pool`, or `pool-coulomb` for engines whose friction is one number.
    """
    facts = facts_of("throw-pool")
    family = family_of(facts, "throw-pool", "throw", quantity="throw of the object ball")
    falls = has_feature(engine.capabilities, Feature.SPEED_DEPENDENT_FRICTION)
    balls = Physics(preset="pool" if falls else "pool-coulomb")
    settings = {name: getattr(balls, name) for name in _HIT_SETTINGS}

    def figures() -> tuple[Measured, ...]:
        physics = Physics(motion="sliding", **settings, **_any_cushion("banks-pool", engine))
        return tuple(
            Measured(
                at=row.place,
                value=value,
                error=None,
                played=throw_angle(play, physics, row.place, cut),
                what=f"cut of {cut:g} degrees",
            )
            for row in facts.rows
            for cut, value in ((30.0, row.value), (45.0, row.also["at_45_degrees"]))
        )

    return family.played(settings, figures)


def _any_cushion(facts: str, engine: ReferenceEngine) -> dict[str, Any]:
    """Return a law of cushions that an engine has: no ball comes there, but a scene needs one."""
    return best_cushion(facts, engine.name, engine.capabilities) or {"cushion": "mirror"}
