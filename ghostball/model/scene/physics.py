"""The physics of a scene: constants, names of laws, and the rules between its fields.

Rules that also involve the balls or the table are in `scene.law_rules`.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS, LawEntry
from ghostball.model.scene.ball import CAROM_BALL, SNOOKER_BALL
from ghostball.model.scene.fields import (
    BallLaw,
    CushionLaw,
    Flag,
    Fraction,
    FrequencyRatio,
    NonNegative,
    Positive,
    problem,
)
from ghostball.model.scene.part import ScenePart, with_preset

YOUNGS_MODULUS = 5.84e9
POISSONS_RATIO = 0.34
"""Elastic constants [Pa, 1] of phenolic balls: Marlow (1995), in Alciatore's technical proof
B.29."""

LEAST_RESTITUTION = 0.5
"""Least `ball_restitution` with impacts that last: below 0.485 the force of a contact would have to
pull, see `engine/impacts/hertz.py`."""

_ADDED_FIELDS = (
    "rolling_friction_quadratic",
    "cushion_restitution_loss",
    "cushion_frequency_ratio",
    "ball_youngs_modulus",
    "ball_poissons_ratio",
)


class Physics(ScenePart):
    """Constants and laws of a scene; a `preset` sets defaults, which any field overrides.

    `ghostball/model/impact_laws.py` lists the fields and the source of each impact law. A field
    that the chosen law ignores is rejected, unless it has the value of the preset or the default.

    Sources: the model of the paper in docs/paper.md ("paper": sections 4.2 and 5.2, mu = 0.02,
    elastic collisions); Alciatore's table of pool constants ("pool"); the same with constant
    restitution and friction coefficients, as in game engines ("pool-coulomb"); a heated table for
    three-cushion billiards ("carom") and a snooker table ("snooker"), both mostly from measurements
    and with balls of their own, see `docs/real-tables.md`.
    """

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "paper": {},
        "pool": {
            "motion": "sliding",
            "rolling_friction": 0.01,
            "ball_restitution": 0.95,
            "ball_friction": "alciatore",
            "cushion": "han2005",
            "cushion_restitution": 0.85,
            "cushion_height": 0.0357,
        },
        "pool-coulomb": {
            "motion": "sliding",
            "rolling_friction": 0.01,
            "ball_restitution": 0.95,
            "ball_friction": 0.06,
            "cushion": "frictional",
            "cushion_restitution": 0.85,
        },
        "carom": {
            "motion": "sliding",
            "rolling_friction": 0.0043,
            "rolling_friction_quadratic": 0.0133,
            "sliding_friction": 0.13,
            "ball_restitution": 0.944,
            "ball_friction": "alciatore",
            "cushion": "han2005",
            "cushion_restitution": 0.976,
            "cushion_restitution_loss": 0.11,
            "cushion_friction": 0.254,
            "cushion_height": 0.037,
        },
        "snooker": {
            "motion": "sliding",
            "rolling_friction": 0.0128,
            "sliding_friction": 0.21,
            "spinning_friction_rate": 22.0,
            "ball_restitution": 0.89,
            "ball_friction": 0.05,
            "cushion": "mathavan2010",
            "cushion_restitution": 1.0,
            "cushion_restitution_loss": 0.065,
            "cushion_friction": 0.14,
            "cushion_height": 0.03675,
        },
    }

    BALLS: ClassVar[dict[str, dict[str, float]]] = {"carom": CAROM_BALL, "snooker": SNOOKER_BALL}
    """Radius [m] and mass [kg] of the balls of presets that describe one game."""

    preset: Literal["paper", "pool", "pool-coulomb", "carom", "snooker"] = "paper"
    gravity: Positive = Field(default=9.81, description="acceleration of free fall [m/s^2]")
    motion: Literal["rolling", "sliding"] = Field(
        default="rolling",
        description='"rolling": always without slip (the paper), no friction between balls or with '
        'cushions; "sliding": balls slide until they roll, with independent spin',
    )
    rolling_friction: NonNegative = Field(
        default=0.02, description="coefficient of rolling friction, ball on cloth [1]"
    )
    sliding_friction: NonNegative = Field(
        default=0.2, description="coefficient of sliding friction, ball on cloth [1]"
    )
    spinning_friction_rate: NonNegative = Field(
        default=10.0, description="deceleration of vertical spin [rad/s^2]"
    )
    impacts: Literal["simultaneous", "sequential", "compliant"] = Field(
        default="simultaneous",
        description='how impacts of several balls are resolved: "simultaneous" (independent of '
        'ball order) or "sequential", both at one instant, or "compliant": contacts last, and '
        "balls that are near each other push each other at the same time",
    )
    ball_youngs_modulus: Annotated[Positive, Field(ge=1e6, le=1e13)] = Field(
        default=YOUNGS_MODULUS,
        description="Young's modulus of the balls' material (`impacts` = \"compliant\") [Pa]",
    )
    ball_poissons_ratio: Annotated[NonNegative, Field(le=0.5)] = Field(
        default=POISSONS_RATIO,
        description="Poisson's ratio of the balls' material (`impacts` = \"compliant\") [1]",
    )
    ball_impact: BallLaw = Field(
        default="frictional", description="impact law for two balls, see impacts/laws/"
    )
    ball_restitution: Fraction = Field(default=1.0, description="ball-ball restitution [1]")
    ball_friction: NonNegative | Literal["alciatore"] = Field(
        default=0.0,
        description='coefficient of friction between balls [1], or "alciatore": decreases with the '
        "slip speed",
    )
    cushion: CushionLaw = Field(
        default="mirror", description="impact law for ball and cushion, see impacts/laws/"
    )
    cushion_restitution: Fraction = Field(
        default=1.0, description='normal restitution of the cushion (all laws except "mirror") [1]'
    )
    cushion_restitution_loss: NonNegative = Field(
        default=0.0,
        description="c in the normal restitution e / (1 + c sqrt(v)), which decreases with the "
        'approach speed v; e is `cushion_restitution` (all laws except "mirror") [sqrt(s/m)]',
    )
    cushion_tangential_restitution: Fraction = Field(
        default=1.0, description='factor on the velocity along the cushion (law "restitution") [1]'
    )
    cushion_friction: NonNegative = Field(
        default=0.2,
        description="coefficient of friction between ball and cushion "
        '("frictional", "han2005", "mathavan2010", "stronge2000") [1]',
    )
    cushion_height: Positive = Field(
        default=0.0357,
        description="height of the cushion's nose above the cloth, less than every ball's "
        '("han2005", "mathavan2010", "stronge2000") [m]',
    )
    cushion_frequency_ratio: FrequencyRatio = Field(
        default=1.8,
        description="frequency of the cushion's spring along the slip, over that of its normal "
        'spring ("stronge2000"), between 1 and 2 [1]',
    )
    air_drag: NonNegative = Field(default=0.0, description="k in a = -k |v| v [1/m]")
    rolling_friction_quadratic: NonNegative = Field(
        default=0.0,
        description="b in the rolling deceleration mu g + b v^2, without air drag [1/m]",
    )
    airborne: Flag = Field(default=False, description="whether a ball may leave the cloth")
    table_restitution: Fraction = Field(
        default=0.5, description="restitution of a ball landing on the table [1]"
    )

    @model_serializer(mode="wrap")
    def _without_added_fields(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Omit fields that were added later and have no effect, so older stored scenes stay equal.

        A field stays if the preset gives a different value, or if it is a field of the chosen
        cushion law alone.
        """
        fields: dict[str, Any] = dump(self)
        own = fields.get("cushion") == "stronge2000"
        for name in _ADDED_FIELDS:
            default = type(self).model_fields[name].default
            kept = own and name == "cushion_frequency_ratio"
            if fields.get(name) == default and not from_preset(self, name) and not kept:
                del fields[name]
        return fields

    @model_validator(mode="before")
    @classmethod
    def _apply_preset(cls, data: Any) -> Any:
        return with_preset(data, cls.PRESETS, "paper")

    @model_validator(mode="after")
    def _no_field_without_effect(self) -> Self:
        _check_laws(self)
        return self


@cache
def usual_physics() -> Physics:
    """Return the physics of a scene that gives none, made once: physics is frozen."""
    return Physics()


def _check_laws(physics: Physics) -> None:
    """Reject a field that has no effect with the chosen impact law, or without airborne balls.

    Someone who sets such a field expects a different law. The values of the preset and the default
    are allowed, so that a law can be changed without changing anything else.

    Raises `PydanticCustomError` for the first field that differs from these values and has no
    effect.
    """
    for chooser, laws in (("cushion", CUSHION_LAWS), ("ball_impact", BALL_LAWS)):
        chosen = entry_of(laws, getattr(physics, chooser))
        for field in dict.fromkeys(field for law in laws for field in law.uses):
            if field in chosen.uses or field == "sliding_friction" or not _is_set(physics, field):
                continue  # the cloth uses sliding friction with every law
            if field == "cushion_height" and physics.airborne:
                continue  # airborne balls hit cushions at this height with every law
            needed = choice(law.name for law in laws if field in law.uses)
            without = f'`{chooser}` = "{chosen.name}"'
            raise _no_effect(physics, field, without, f"`{chooser}` = {needed}")
    _check_compliant(physics)
    _check_airborne(physics)
    if not physics.airborne and _is_set(physics, "table_restitution"):
        without = "`airborne` = false: balls never land"
        raise _no_effect(physics, "table_restitution", without, "`airborne` = true")


def _is_set(physics: Physics, field: str) -> bool:
    """Return whether a field has neither its default nor the value of the preset."""
    default = type(physics).model_fields[field].default
    return getattr(physics, field) not in (default, from_preset(physics, field))


def _no_effect(physics: Physics, field: str, without: str, needed: str) -> PydanticCustomError:
    """Return the error of a field without effect: `without` is why, `needed` what to set."""
    value = getattr(physics, field)
    return problem(
        f"`{field}` = {value} has no effect with {without}. Set {needed}, or remove the field",
        at=(field,),
    )


def _check_compliant(physics: Physics) -> None:
    """Check the fields of impacts that last, and that no other choice excludes these impacts."""
    if physics.impacts != "compliant":
        for field in ("ball_youngs_modulus", "ball_poissons_ratio"):
            if _is_set(physics, field):
                without = f'`impacts` = "{physics.impacts}"'
                raise _no_effect(physics, field, without, '`impacts` = "compliant"')
        return
    if physics.ball_restitution < LEAST_RESTITUTION:
        raise problem(
            f"`ball_restitution` must be at least {LEAST_RESTITUTION} if `impacts` = "
            f'"compliant", got {physics.ball_restitution}: a contact that lasts can\'t lose more '
            'without pulling. Raise it, or set `impacts` = "simultaneous"',
            at=("ball_restitution",),
        )
    if physics.airborne:
        raise problem(
            '`impacts` must be "simultaneous" or "sequential" if `airborne` = true, got '
            '"compliant": impacts that last keep balls on the cloth. Set `impacts` = '
            '"simultaneous", or `airborne` = false',
            at=("impacts",),
        )
    if entry_of(BALL_LAWS, physics.ball_impact).integrated:
        raise problem(
            f"`ball_impact` must be {choice(law.name for law in BALL_LAWS if not law.integrated)} "
            f'if `impacts` = "compliant", got "{physics.ball_impact}": impacts that last have no '
            'friction of the cloth. Set another law, or `impacts` = "simultaneous"',
            at=("ball_impact",),
        )


def _check_airborne(physics: Physics) -> None:
    """Reject choices that exclude flying balls: pure rolling, and laws with cloth friction."""
    if not physics.airborne:
        return
    wrong: dict[str, str] = {}  # field, and what to set it to
    if physics.motion == "rolling":
        wrong["motion"] = '"sliding"'
    for field, laws in (("ball_impact", BALL_LAWS), ("cushion", CUSHION_LAWS)):
        if entry_of(laws, getattr(physics, field)).integrated:
            wrong[field] = choice(law.name for law in laws if not law.integrated)
    for field, instead in wrong.items():
        raise problem(
            f"`{field}` must be {instead} if `airborne` = true, got "
            f'"{getattr(physics, field)}": it keeps balls on the cloth. Set `{field}` = {instead}, '
            "or `airborne` = false",
            at=(field,),
        )


def entry_of(laws: tuple[LawEntry, ...], name: str) -> LawEntry:
    """Return the law with a name."""
    return next(law for law in laws if law.name == name)


def from_preset(physics: Physics, field: str) -> Any:
    """Return the value that the preset of `physics` sets for a field; None if it sets none."""
    return physics.PRESETS[physics.preset].get(field)


def choice(names: Iterable[str]) -> str:
    """Return quoted names as a list for a sentence: "a", "b" or "c"."""
    *others, last = (f'"{name}"' for name in names)
    return f"{', '.join(others)} or {last}" if others else last
