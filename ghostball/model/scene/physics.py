"""The physics of a scene: constants, laws by name, and the rules between its own fields.

Rules that ask about balls or the table too are in `scene.law_rules`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar, Literal, Self

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS, LawEntry
from ghostball.model.scene.fields import (
    BallLaw,
    CushionLaw,
    Flag,
    Fraction,
    NonNegative,
    Positive,
    problem,
)
from ghostball.model.scene.part import Part

_LATER_FIELDS = ("rolling_friction_quadratic", "cushion_restitution_loss")


class Physics(Part):
    """Constants and laws of one scene; a `preset` gives the defaults, any field overrides it.

    `ghostball/model/impact_laws.py` says what each law of impacts uses, and where it comes from. A
    field that the chosen law would ignore is refused, unless it has the preset's value or the
    default.

    Sources: the paper's own model ("paper": section 4.2 and 5.2, mu = 0.02, everything elastic);
    Alciatore's table of pool constants ("pool"); the same with a restitution and a coefficient of
    friction at each contact, as engines of games have them ("pool-coulomb"); a heated table of
    three-cushion ("carom") and a table of snooker ("snooker"), both mostly from measurements, as
    `docs/real-tables.md` says.
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

    preset: Literal["paper", "pool", "pool-coulomb", "carom", "snooker"] = "paper"
    gravity: Positive = Field(default=9.81, description="acceleration of free fall [m/s^2]")
    motion: Literal["rolling", "sliding"] = Field(
        default="rolling",
        description='"rolling": always without slip (the paper), no friction between balls or with '
        'cushions; "sliding": slides until it rolls, and spin is a state of its own',
    )
    rolling_friction: NonNegative = Field(
        default=0.02, description="coefficient of rolling resistance, ball on cloth [1]"
    )
    sliding_friction: NonNegative = Field(
        default=0.2, description="coefficient of sliding friction, ball on cloth [1]"
    )
    spinning_friction_rate: NonNegative = Field(
        default=10.0, description="deceleration of vertical spin [rad/s^2]"
    )
    impacts: Literal["simultaneous", "sequential"] = Field(
        default="simultaneous",
        description="how impacts at one instant are resolved: together, whatever the order of the "
        "balls, or one after another",
    )
    ball_impact: BallLaw = Field(
        default="frictional", description="law of the ball-ball impact, see impacts/laws/"
    )
    ball_restitution: Fraction = Field(default=1.0, description="ball-ball restitution [1]")
    ball_friction: NonNegative | Literal["alciatore"] = Field(
        default=0.0,
        description='coefficient of friction between balls [1], or "alciatore": falls with the '
        "speed of slip",
    )
    cushion: CushionLaw = Field(
        default="mirror", description="law of the ball-cushion impact, see impacts/laws/"
    )
    cushion_restitution: Fraction = Field(
        default=1.0, description='normal restitution of the cushion (all laws but "mirror") [1]'
    )
    cushion_restitution_loss: NonNegative = Field(
        default=0.0,
        description="c of a normal restitution that falls with the speed v of the approach, "
        'e / (1 + c sqrt(v)), e being `cushion_restitution` (all laws but "mirror") [sqrt(s/m)]',
    )
    cushion_tangential_restitution: Fraction = Field(
        default=1.0, description='factor on the velocity along the cushion (law "restitution") [1]'
    )
    cushion_friction: NonNegative = Field(
        default=0.2,
        description="coefficient of friction between ball and cushion "
        '("frictional", "han2005", "mathavan2010") [1]',
    )
    cushion_height: Positive = Field(
        default=0.0357,
        description="height of the cushion's nose above the cloth, less than every ball's "
        '("han2005", "mathavan2010") [m]',
    )
    air_drag: NonNegative = Field(default=0.0, description="k in a = -k |v| v [1/m]")
    rolling_friction_quadratic: NonNegative = Field(
        default=0.0,
        description="b in a = mu g + b v^2 of a ball that rolls, beside what air takes [1/m]",
    )
    airborne: Flag = Field(default=False, description="whether a ball may leave the cloth")
    table_restitution: Fraction = Field(
        default=0.5, description="restitution of a ball that lands on the table [1]"
    )

    @model_serializer(mode="wrap")
    def _without_later_fields(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out fields that came later, where they are 0: scenes stored before stay the same.

        But not where the preset gives another number.
        """
        fields: dict[str, Any] = dump(self)
        for name in _LATER_FIELDS:
            if fields.get(name) == 0.0 and not from_preset(self, name):
                del fields[name]
        return fields

    @model_validator(mode="before")
    @classmethod
    def _apply_preset(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        preset = data.get("preset", "paper")
        defaults = cls.PRESETS.get(preset, {}) if isinstance(preset, str) else {}
        return {**defaults, **data}

    @model_validator(mode="after")
    def _no_field_without_effect(self) -> Self:
        _check_laws(self)
        return self


def _check_laws(physics: Physics) -> None:
    """Refuse a field that the chosen impact law, or balls that stay on the cloth, would ignore.

    Whoever set one wants another law. What the preset or the default gives is allowed, so that a
    law can be swapped for another with nothing else changed.

    Raises `PydanticCustomError` for the first field that differs from the preset's value and has no
    effect.
    """
    for chooser, laws in (("cushion", CUSHION_LAWS), ("ball_impact", BALL_LAWS)):
        chosen = entry_of(laws, getattr(physics, chooser))
        for field in dict.fromkeys(field for law in laws for field in law.uses):
            value = getattr(physics, field)
            given = value in _given(physics, field)
            if field in chosen.uses or field == "sliding_friction" or given:
                continue  # sliding friction is the cloth's, whatever the law
            if field == "cushion_height" and physics.airborne:
                continue  # where balls meet cushions in space, whatever the law
            raise problem(
                "no_effect",
                f'`{field}` = {value} has no effect with `{chooser}` = "{chosen.name}". Set '
                f"`{chooser}` = {choice(law.name for law in laws if field in law.uses)}, or leave "
                "the field out",
                at=(field,),
            )
    _check_airborne(physics)
    landing = physics.table_restitution
    if not physics.airborne and landing not in _given(physics, "table_restitution"):
        raise problem(
            "no_effect",
            f"`table_restitution` = {landing} has no effect with `airborne` = false: no ball "
            "lands. Set `airborne` = true, or leave the field out",
            at=("table_restitution",),
        )


def _check_airborne(physics: Physics) -> None:
    """Refuse what can't be where balls may leave the cloth: rolling only, and laws on the cloth."""
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
            "not_airborne",
            f"`{field}` must be {instead} where `airborne` = true, got "
            f'"{getattr(physics, field)}": it holds balls on the cloth. Set `{field}` = {instead}, '
            "or `airborne` = false",
            at=(field,),
        )


def entry_of(laws: tuple[LawEntry, ...], name: str) -> LawEntry:
    """Return the law of a name."""
    return next(law for law in laws if law.name == name)


def from_preset(physics: Physics, field: str) -> Any:
    """Return what the preset of some physics gives for a field; None: nothing."""
    return physics.PRESETS[physics.preset].get(field)


def _given(physics: Physics, field: str) -> tuple[Any, Any]:
    """Return what a field is where nobody sets it: by default, and by the preset."""
    return type(physics).model_fields[field].default, from_preset(physics, field)


def choice(names: Iterable[str]) -> str:
    """Return names in quotes, as a sentence lists what can be chosen."""
    *others, last = (f'"{name}"' for name in names)
    return f"{', '.join(others)} or {last}" if others else last
