"""The rules between a scene's impact laws and its other fields.

Each refuses what breaks it with one sentence.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ghostball.engine.impacts.laws.registry import BALL_LAWS, CUSHION_LAWS, LawEntry
from ghostball.engine.scene.fields import problem

if TYPE_CHECKING:
    from ghostball.engine.scene.model import Scene
    from ghostball.engine.scene.parts import Ball, Physics


def check_laws(physics: Physics) -> None:
    """Refuse a field that the chosen impact law, or balls that stay on the cloth, would ignore.

    Whoever set one wants another law. What the preset or the default gives is allowed, so that a
    law can be swapped for another with nothing else changed.

    Raises
    ------
    PydanticCustomError
        For the first field that differs from the preset's value and has no effect.
    """
    for chooser, laws in (("cushion", CUSHION_LAWS), ("ball_impact", BALL_LAWS)):
        chosen = _entry(laws, getattr(physics, chooser))
        for field in dict.fromkeys(field for law in laws for field in law.uses):
            value = getattr(physics, field)
            given = value in _given(physics, field)
            if field in chosen.uses or field == "sliding_friction" or given:
                continue  # sliding friction is the cloth's, whatever the law
            if field == "cushion_height" and physics.airborne:
                continue  # where balls meet cushions in space, whatever the law
            raise problem(
                "no_effect",
                '`{field}` = {value} has no effect with `{chooser}` = "{law}". Set `{chooser}` = '
                "{others}, or leave the field out",
                at=(field,),
                field=field,
                value=value,
                chooser=chooser,
                law=chosen.name,
                others=_choice(law.name for law in laws if field in law.uses),
            )
    _check_airborne(physics)
    landing = physics.table_restitution
    if not physics.airborne and landing not in _given(physics, "table_restitution"):
        raise problem(
            "no_effect",
            "`table_restitution` = {value} has no effect with `airborne` = false: no ball lands. "
            "Set `airborne` = true, or leave the field out",
            at=("table_restitution",),
            value=landing,
        )


def _check_airborne(physics: Physics) -> None:
    """Refuse what can't be where balls may leave the cloth: rolling only, and laws on the cloth."""
    if not physics.airborne:
        return
    wrong: dict[str, str] = {}  # field, and what to set it to
    if physics.motion == "rolling":
        wrong["motion"] = '"sliding"'
    for field, laws in (("ball_impact", BALL_LAWS), ("cushion", CUSHION_LAWS)):
        if _entry(laws, getattr(physics, field)).integrated:
            wrong[field] = _choice(law.name for law in laws if not law.integrated)
    for field, instead in wrong.items():
        raise problem(
            "not_airborne",
            '`{field}` must be {instead} where `airborne` = true, got "{value}": it holds balls on '
            "the cloth. Set `{field}` = {instead}, or `airborne` = false",
            at=(field,),
            field=field,
            value=getattr(physics, field),
            instead=instead,
        )


def check_laws_in_scene(scene: Scene) -> None:
    """Check that the laws of impacts, which are in order themselves, suit the balls and the table.

    Raises
    ------
    PydanticCustomError
        For the first rule that is broken.
    """
    _check_laws_without_spin(scene)
    _check_limits(scene)
    _check_cushion_height(scene)


def _entry(laws: tuple[LawEntry, ...], name: str) -> LawEntry:
    return next(law for law in laws if law.name == name)


def _from_preset(physics: Physics, field: str) -> Any:
    return physics.PRESETS[physics.preset].get(field)


def _given(physics: Physics, field: str) -> tuple[Any, Any]:
    """Return what a field is where nobody sets it: by default, and by the preset."""
    return type(physics).model_fields[field].default, _from_preset(physics, field)


def _choice(names: Iterable[str]) -> str:
    *others, last = (f'"{name}"' for name in names)
    return f"{', '.join(others)} or {last}" if others else last


def _check_laws_without_spin(scene: Scene) -> None:
    # A ball that always rolls has its velocity's spin and no other: these laws would be cut short.
    physics, table = scene.physics, scene.table
    if physics.motion != "rolling":
        return
    wrong: dict[str, str] = {}  # field, and what to set it to
    if table is not None and table.cushions and _entry(CUSHION_LAWS, physics.cushion).turns:
        wrong["cushion"] = _choice(law.name for law in CUSHION_LAWS if not law.turns)
    if len(scene.balls) > 1:
        if _entry(BALL_LAWS, physics.ball_impact).turns:
            wrong["ball_impact"] = _choice(law.name for law in BALL_LAWS if not law.turns)
        if physics.ball_friction != 0.0:
            wrong["ball_friction"] = "0"
    if not wrong:
        return
    found = []
    for field in wrong:
        value = getattr(physics, field)
        shown = f'"{value}"' if isinstance(value, str) else f"{value}"
        preset = value == _from_preset(physics, field)
        source = f' (of preset "{physics.preset}")' if preset else ""
        found.append(f"`{field}` = {shown}{source}")
    raise problem(
        "needs_spin",
        '`motion` must be "sliding" with {found}: where it is "rolling", a ball has the spin of '
        'its velocity, and no impact can turn it. Set `motion` = "sliding", or {mended}',
        at=("physics", next(iter(wrong))),
        found=" and ".join(found),
        mended=" and ".join(f"`{field}` = {value}" for field, value in wrong.items()),
    )


def _check_limits(scene: Scene) -> None:
    law = _entry(BALL_LAWS, scene.physics.ball_impact)
    if len(scene.balls) < 2:
        return
    owners: list[tuple[str, tuple[str | int, ...], Physics | Ball]]
    owners = [("", ("physics",), scene.physics)]
    owners += [(f"balls[{i}].", ("balls", i), ball) for i, ball in enumerate(scene.balls)]
    for field, most in law.limits:
        for prefix, owner_at, owner in owners:
            value = getattr(owner, field, None)
            if not isinstance(value, float) or value <= most:
                continue
            raise problem(
                "beyond_law",
                '`{name}` must be at most {most} where `ball_impact` = "{law}", got {value}: the '
                "law describes balls that stay on the cloth. Set a smaller one, or `ball_impact` = "
                "{others}",
                at=(*owner_at, field),
                name=prefix + field,
                most=most,
                law=law.name,
                value=value,
                others=_choice(other.name for other in BALL_LAWS if not other.limits),
            )


def _check_cushion_height(scene: Scene) -> None:
    physics, table = scene.physics, scene.table
    if table is None or not table.cushions:
        return
    in_space = physics.airborne
    if not in_space and "cushion_height" not in _entry(CUSHION_LAWS, physics.cushion).uses:
        return
    height = physics.cushion_height
    for i, ball in enumerate(scene.balls):
        sine = (height - ball.radius) / ball.radius  # of the contact's elevation seen from the ball
        if -1.0 < sine < 1.0:
            continue
        needed = "less than the height of every ball" if sine > 0.0 else "distinct from the cloth's"
        if in_space:
            raise problem(
                "cushion_height",
                "`cushion_height` must be {needed} where `airborne` = true, got {height} m, but "
                "`balls[{i}]` is {top} m high. Set `cushion_height`, or `airborne` = false",
                at=("physics", "cushion_height"),
                needed=needed,
                i=i,
                top=2.0 * ball.radius,
                height=height,
            )
        raise problem(
            "cushion_height",
            '`cushion_height` must be {needed} where `cushion` = "{law}", got {height} m, but '
            "`balls[{i}]` is {top} m high. Set `cushion_height`, or `cushion` = {others}",
            at=("physics", "cushion_height"),
            needed=needed,
            i=i,
            top=2.0 * ball.radius,
            height=height,
            law=physics.cushion,
            others=_choice(law.name for law in CUSHION_LAWS if "cushion_height" not in law.uses),
        )
