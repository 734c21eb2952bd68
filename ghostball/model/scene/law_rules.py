"""The rules that connect the impact laws of a scene with its balls and its table.

Each rule rejects a scene with one sentence. The rules that connect the laws with other fields of
the physics are in `scene.physics`.
"""

from __future__ import annotations

from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS
from ghostball.model.scene.ball import Ball
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import problem
from ghostball.model.scene.physics import Physics, choice, entry_of, from_preset


def check_laws_in_scene(scene: SceneContents) -> None:
    """Check that the impact laws suit the balls and the table.

    `scene` has passed the rules of `scene.physics`. Raises `PydanticCustomError` for the first rule
    that is broken.
    """
    _check_laws_without_spin(scene)
    _check_limits(scene)
    _check_cushion_height(scene)


def _check_laws_without_spin(scene: SceneContents) -> None:
    # The spin of a ball that always rolls is determined by its velocity, but these laws change
    # spin.
    physics, table = scene.physics, scene.table
    if physics.motion != "rolling":
        return
    wrong: dict[str, str] = {}  # field, and what to set it to
    if table is not None and table.has_cushions and entry_of(CUSHION_LAWS, physics.cushion).turns:
        wrong["cushion"] = choice(law.name for law in CUSHION_LAWS if not law.turns)
    if len(scene.balls) > 1:
        if entry_of(BALL_LAWS, physics.ball_impact).turns:
            wrong["ball_impact"] = choice(law.name for law in BALL_LAWS if not law.turns)
        if physics.ball_friction != 0.0:
            wrong["ball_friction"] = "0"
    if not wrong:
        return
    found = []
    for field in wrong:
        value = getattr(physics, field)
        shown = f'"{value}"' if isinstance(value, str) else f"{value}"
        preset = value == from_preset(physics, field)
        source = f' (of preset "{physics.preset}")' if preset else ""
        found.append(f"`{field}` = {shown}{source}")
    mended = " and ".join(f"`{field}` = {value}" for field, value in wrong.items())
    raise problem(
        f'`motion` must be "sliding" with {" and ".join(found)}: with "rolling", spin is fixed by '
        'the velocity, so no impact can change it. Set `motion` = "sliding", or '
        f"{mended}",
        at=("physics", next(iter(wrong))),
    )


def _check_limits(scene: SceneContents) -> None:
    law = entry_of(BALL_LAWS, scene.physics.ball_impact)
    if len(scene.balls) < 2 or not law.limits:
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
                f'`{prefix}{field}` must be at most {most} if `ball_impact` = "{law.name}", got '
                f"{value}: the law applies only to balls that stay on the cloth. Lower it, or set "
                f"`ball_impact` = {choice(other.name for other in BALL_LAWS if not other.limits)}",
                at=(*owner_at, field),
            )


def _check_cushion_height(scene: SceneContents) -> None:
    physics, table = scene.physics, scene.table
    if table is None or not table.has_cushions:
        return
    in_space = physics.airborne
    if not in_space and "cushion_height" not in entry_of(CUSHION_LAWS, physics.cushion).uses:
        return
    height = physics.cushion_height
    for i, ball in enumerate(scene.balls):
        sine = (height - ball.radius) / ball.radius  # of the elevation of the contact
        if -1.0 < sine < 1.0:
            continue
        needed = "less than the height of every ball" if sine > 0.0 else "above the cloth"
        where, mended = "`airborne` = true", "`airborne` = false"
        if not in_space:
            others = (law.name for law in CUSHION_LAWS if "cushion_height" not in law.uses)
            where, mended = f'`cushion` = "{physics.cushion}"', f"`cushion` = {choice(others)}"
        raise problem(
            f"`cushion_height` must be {needed} if {where}, got {height} m, but `balls[{i}]` is "
            f"{2.0 * ball.radius} m high. Change `cushion_height`, or set {mended}",
            at=("physics", "cushion_height"),
        )
