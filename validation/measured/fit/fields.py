"""The coefficients that can be fitted: the events that determine them, and the engine features."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from ghostball.model import Physics
from ghostball.model.features import Feature, has_feature
from ghostball.model.impact_laws import CUSHION_LAWS, LawEntry
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.fit.least_squares import Assumed, Field

ALL_FAMILIES = frozenset({"rolling", "cushion", "hit"})
CUSHION, HIT = frozenset({"cushion"}), frozenset({"hit"})
"""Families of events."""

FIELDS: Final = {
    one.name: one
    for one in (
        Field("rolling_friction", 0.0, 0.2, 1e-4, ALL_FAMILIES),
        Field("rolling_friction_quadratic", 0.0, 0.5, 5e-4, ALL_FAMILIES),
        Field("sliding_friction", 0.02, 1.0, 2e-3, CUSHION | HIT),
        Field("ball_restitution", 0.3, 1.0, 2e-3, HIT),
        Field("ball_friction", 0.0, 1.0, 2e-3, HIT),
        Field("cushion_restitution", 0.2, 1.0, 2e-3, CUSHION),
        Field("cushion_restitution_loss", 0.0, 1.0, 2e-3, CUSHION),
        Field("cushion_friction", 0.0, 1.0, 2e-3, CUSHION),
        Field("cushion_height", 0.02, 0.05, 1e-4, CUSHION),
    )
}
"""Coefficients that can be fitted; limits are those of `Physics`, or far from any real table."""
DEFAULT_FIELDS: Final = tuple(
    name for name in FIELDS if name not in {"ball_friction", "cushion_height"}
)
"""Coefficients that are fitted by default. Trackers don't see the side of a ball, which has the
same effect as the friction between balls; and the nose height can be measured with a ruler."""
_DETERMINED_BY: Final = {
    "rolling_friction": frozenset({"rolling"}),
    "rolling_friction_quadratic": frozenset({"rolling"}),
    "sliding_friction": HIT,
}
"""Fields that are determined by only some of the families that they affect.

In contacts with cushions alone, the sliding friction of the cloth can't be separated from the
friction of the cushion, and the errors of both would be wrong.
"""
SPREAD: Final = {"sliding_friction": 0.05, "rolling_friction": 0.004, "ball_friction": 0.03}
"""Standard deviation between tables of a coefficient that is assumed, not fitted.

It varies with heating and wear of the cloth. Alciatore's values for pool are 0.03 to 0.08 for the
friction between balls, and chalk increases it: this spread around the initial value, 0.06, covers
them.
"""
NOSE_SPREAD: Final = 0.01
"""Standard deviation of the nose height, in ball diameters: the rules of pool allow 62.5 to 64.5 %
(World Pool Association, equipment specifications).
"""
INITIAL_VALUES: Final = {"ball_friction": 0.06, "cushion_restitution_loss": 0.05}
"""Initial values of the search that differ from the preset, whose value may be a law or a limit."""
NEEDED_FEATURES: Final = {
    "rolling_friction_quadratic": Feature.QUADRATIC_ROLLING,
    "cushion_restitution_loss": Feature.FALLING_RESTITUTION,
}
"""Features that an engine needs for a coefficient to be fitted."""


def assumed_of(name: str, physics: Physics, radius: float) -> Assumed | None:
    """Return the assumed value of a field that isn't fitted; None if its value doesn't matter.

    `physics`: of the preset, whose value is the mean; `radius` of the balls [m].
    """
    if name == "cushion_height":
        return Assumed(physics.cushion_height, NOSE_SPREAD * 2.0 * radius)
    if name not in SPREAD:
        return None
    value = getattr(physics, name)
    mean = float(value) if isinstance(value, float | int) else INITIAL_VALUES[name]
    return Assumed(mean, SPREAD[name])


def determined_by(field: Field) -> frozenset[str]:
    """Return the families that determine a field."""
    return _DETERMINED_BY.get(field.name, field.felt_by)


def own_fields(law: LawEntry, fields: Sequence[Field]) -> list[Field]:
    """Return the fields that a cushion law uses and only contacts with cushions determine."""
    return [one for one in fields if determined_by(one) == CUSHION and one.name in law.uses]


def lacking(engine: ReferenceEngine, preset: str) -> dict[str, Any]:
    """Return replacements for features of a preset that an engine lacks."""
    changes: dict[str, Any] = {
        name: 0.0
        for name, feature in NEEDED_FEATURES.items()
        if not has_feature(engine.capabilities, feature)
    }
    if not has_feature(engine.capabilities, Feature.SPEED_DEPENDENT_FRICTION):
        changes["ball_friction"] = INITIAL_VALUES["ball_friction"]
    laws = [law.name for law in cushion_laws(engine)]
    if laws and Physics(preset=preset).cushion not in laws:
        changes["cushion"] = laws[-1]
    return changes


def cushion_laws(engine: ReferenceEngine) -> list[LawEntry]:
    """Return the cushion laws of an engine that can be fitted, the simplest first."""
    return [
        law
        for law in CUSHION_LAWS
        if law.uses and law.fitted and has_feature(engine.capabilities, Feature[law.feature or ""])
    ]
