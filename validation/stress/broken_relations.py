"""Mistakes between fields that are right each for itself."""

from __future__ import annotations

from hypothesis import strategies as st

from validation.stress.plain_scenes import Fields, Malformed, Mistake


def _overlap(draw: st.DrawFn, scene: Fields) -> Malformed:
    first, last = scene["balls"][0], scene["balls"][-1]
    reach = first.get("radius", 0.028575) + last.get("radius", 0.028575)
    depth = draw(st.sampled_from([1e-9, 1e-3, 0.01, reach]))
    x, y = first["position"]
    last["position"] = [x + reach - depth, y]
    at = ("balls", len(scene["balls"]) - 1, "position")
    tells = ("must not overlap", '"ball 0"', f'"{last["id"]}"', "`balls[0]`")
    return Malformed(scene, at, tells)


def _outside(draw: st.DrawFn, scene: Fields) -> Malformed:
    scene["table"] = {"length": 2.0, "width": 1.0}
    i = draw(st.integers(0, len(scene["balls"]) - 1))
    radius = scene["balls"][i].get("radius", 0.028575)
    beyond = draw(st.sampled_from([1e-9, 0.01, 5.0, 1e6]))
    place, side = draw(
        st.sampled_from(
            [
                ([radius - beyond, 0.9], "left"),
                ([2.0 - radius + beyond, 0.9], "right"),
                ([1.9, radius - beyond], "bottom"),
                ([1.9, 1.0 - radius + beyond], "top"),
            ]
        )
    )
    scene["balls"][i]["position"] = place
    tells = (f"`balls[{i}].position` must be inside the table", f"{side} cushion")
    return Malformed(scene, ("balls", i, "position"), tells)


def _twice(draw: st.DrawFn, scene: Fields) -> Malformed:
    i = draw(st.integers(1, len(scene["balls"]) - 1))
    scene["balls"][i]["id"] = "ball 0"
    return Malformed(
        scene, ("balls", i, "id"), (f"`balls[{i}].id` must be unique", '"ball 0"', "`balls[0]`")
    )


def _off_cloth(draw: st.DrawFn, scene: Fields) -> Malformed:
    one = scene["balls"][0]
    if draw(st.booleans()):
        one["position"] = [*one["position"], 0.5]
        return Malformed(
            scene, ("balls", 0, "position"), ("`balls[0].position` z must be", "got 0.5 m")
        )
    one["velocity"] = [0.0, 0.0, -1.0]
    return Malformed(
        scene, ("balls", 0, "velocity"), ("`balls[0].velocity` z must be 0", "got -1.0 m/s")
    )


def _rolls(scene: Fields) -> None:
    scene["physics"] = {}
    for one in scene["balls"]:
        one.pop("angular_velocity", None)


def _slips(_: st.DrawFn, scene: Fields) -> Malformed:
    _rolls(scene)
    scene["balls"][0]["angular_velocity"] = [0.0, 0.0, 1.0]
    at = ("balls", 0, "angular_velocity")
    return Malformed(scene, at, ("`balls[0].angular_velocity` must be that of rolling",))


def _endless(draw: st.DrawFn, scene: Fields) -> Malformed:
    _rolls(scene)
    del scene["t_max"]
    for one in scene["balls"]:
        one.pop("velocity", None)
    scene["balls"][0]["velocity"] = [1.0, 0.0]
    field = draw(st.sampled_from(["balls", "physics"]))
    (scene["physics"] if field == "physics" else scene["balls"][1])["rolling_friction"] = 0
    return Malformed(scene, ("balls", 0), ("`t_max` must be given", "`rolling_friction` = 0.0"))


def _ignored(_: st.DrawFn, scene: Fields) -> Malformed:
    scene["physics"] = {"motion": "sliding", "cushion_height": 0.02}
    at = ("physics", "cushion_height")
    return Malformed(scene, at, ("`cushion_height` = 0.02 has no effect", '`cushion` = "mirror"'))


def _needs_spin(_: st.DrawFn, scene: Fields) -> Malformed:
    _rolls(scene)
    scene["physics"] = {"ball_friction": 0.06}
    at = ("physics", "ball_friction")
    return Malformed(scene, at, ('`motion` must be "sliding"', "`ball_friction` = 0.06"))


def _low_ball(_: st.DrawFn, scene: Fields) -> Malformed:
    scene["table"] = {"length": 2.0, "width": 1.0}
    scene["physics"] = {"preset": "pool"}
    scene["balls"][1]["radius"] = 0.01
    return Malformed(scene, ("physics",), ("`cushion_height` must be less", "`balls[1]`"))


def _unresolved(draw: st.DrawFn, scene: Fields) -> Malformed:
    scene.pop("table", None)
    far = draw(st.sampled_from([1e15, -1e20, 1e50]))
    scene["balls"][1]["position"] = [0.0, far]
    at = ("balls", 1, "position")
    return Malformed(scene, at, ("`balls[1].position` must be known", "double precision"))


RELATIONS: tuple[Mistake, ...] = (
    _overlap,
    _outside,
    _twice,
    _off_cloth,
    _slips,
    _endless,
    _ignored,
    _needs_spin,
    _low_ball,
    _unresolved,
)


def broken_relation(draw: st.DrawFn, scene: Fields) -> Malformed:
    """Break a rule between fields."""
    mistake = draw(st.sampled_from(RELATIONS))
    return mistake(draw, scene)
