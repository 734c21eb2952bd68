"""A scene that passes the quick check keeps every rule, and most scenes pass the quick check."""

from __future__ import annotations

import math

from hypothesis import HealthCheck, given, settings, strategies as st
from pydantic_core import PydanticCustomError
from shots import R

from ghostball.model import Scene, SceneError
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import LARGEST, MAX_DRAG_RATE, SMALLEST
from ghostball.model.scene.quick_check import certainly_valid
from ghostball.model.scene.rules import check_each_rule, check_scene
from ghostball.validation.scenes.library import shipped_scenes

LENGTH, WIDTH = 2.54, 1.27

# Values of each property of scenes: usual ones, and values on both sides of limits of rules.
USUAL_AND_ODD: dict[str, tuple[list, list]] = {
    # Shift from contact, in units of the distance: roundings and 2^-37 are permitted.
    "shift": (
        [0.0, 1e-3, 0.5, 2.0],
        [-(2.0**-20), *[sign * k * 2.0**-38 for k in (1, 2, 3, 5, 7) for sign in (1.0, -1.0)]],
    ),
    "far": ([0.3, 0.6], [1e6, 1e12, -1.0]),
    "id": (["own"], ["a"]),
    "radius": ([R], [R, 0.03, math.nextafter(R, 1.0), 1e-3, 0.7, 3.0, 1e-15]),
    "mass": ([0.17], [0.2, 1e-40, 1e40]),
    "height": ([None], [1.0, 2.0, 0.5, math.nextafter(1.0, 2.0)]),  # [radii]
    "up": ([0.0], [1.0, -1.0]),
    "speed": ([0.0, 1.0, 7.3], [1e-60, 1e-30, MAX_DRAG_RATE, 1e35, LARGEST / 2.0, LARGEST]),
    "spin": ([None], [0.0, 30.0, MAX_DRAG_RATE, LARGEST]),
    "friction": ([None], [0.2, 0.01, 1.0, 0.0, SMALLEST, 1e-48, 1e-300, 1e3 / LARGEST]),
    "drag": ([None], [0.01, 1.0, 1e6, 1e-30]),
    "gravity": ([9.81], [1e-40, 1e10, 1.62]),
    "motion": (["rolling", "sliding"], ["rolling"]),
    "airborne": ([False], [True]),
    "table_restitution": ([0.5], [1.0]),
    "t_max": ([None], [1.0]),
}
PAIRS = (
    {"speed", "drag"},
    {"drag", "airborne"},
    {"speed", "friction"},
    {"spin", "radius", "t_max"},
    {"spin", "friction"},
    {"shift"},
)
"""Properties that rules combine."""

FRICTIONS = ("rolling_friction", "sliding_friction", "spinning_friction_rate")
TABLES = st.sampled_from(
    [
        None,
        {"length": LENGTH, "width": WIDTH},
        {"length": LENGTH, "width": WIDTH},
        {"length": LENGTH, "width": WIDTH, "cushions": ["left", "top"]},
        {"length": LENGTH, "width": WIDTH, "posts": [{"centre": [1.27, 0.9], "radius": 0.05}]},
        {"vertices": [[0.0, 0.0], [LENGTH, 0.0], [LENGTH, WIDTH], [0.4, WIDTH]]},
        "wpa-9ft",
        "bar-7ft",
        "snooker-12ft",
        # A hole that reaches far over the cloth, and a mouth that takes most of a side.
        {
            "preset": "wpa-9ft",
            "pockets": {
                "side": {
                    "mouth": 0.5,
                    "angle": 1.6,
                    "jaw_radius": 0.01,
                    "depth": 0.0,
                    "radius": 0.25,
                },
                "corner": {
                    "mouth": 0.3,
                    "angle": 2.5,
                    "jaw_radius": 0.05,
                    "depth": 0.01,
                    "radius": 0.3,
                },
            },
        },
    ]
)


@st.composite
def contents(draw: st.DrawFn) -> SceneContents | None:
    """Return a scene with up to three unusual properties; None if a single field is refused."""
    some = st.sets(st.sampled_from(sorted(USUAL_AND_ODD)), max_size=3)
    odd = draw(some | st.sampled_from(PAIRS))

    def one(respect: str):
        return draw(st.sampled_from(USUAL_AND_ODD[respect][respect in odd]))

    places: list[tuple[float, float, float]] = []
    balls = []
    for k in range(draw(st.integers(1, 3))):
        radius, shift = one("radius"), 1.0 + one("shift")
        if places and draw(st.booleans()):  # beside another ball
            x, y, other = places[-1]
            angle = draw(st.sampled_from([0.0, math.pi / 3.0, 1.0, math.pi / 2.0]))
            apart = (radius + other) * shift
            x, y = x + apart * math.cos(angle), y + apart * math.sin(angle)
        else:  # beside a cushion, or elsewhere
            along = [radius * shift, LENGTH - radius * shift, LENGTH / 2.0, one("far")]
            across = [radius * shift, WIDTH - radius * shift, WIDTH / 2.0, 0.9, 0.4]
            x, y = draw(st.sampled_from(along)), draw(st.sampled_from(across))
        places.append((x, y, radius))
        height, spin, name = one("height"), one("spin"), one("id")
        ball = {
            "id": str(k) if name == "own" else name,
            "radius": radius,
            "mass": one("mass"),
            "position": [x, y] if height is None else [x, y, height * radius],
            "velocity": [one("speed"), -one("speed"), one("up")],
            "angular_velocity": None if spin is None else [spin, 0.1, -spin],
        }
        balls.append(ball | {field: one("friction") for field in FRICTIONS})
    physics = {name: one(name) for name in ("motion", "gravity", "airborne")}
    others = {"air_drag": "drag", "rolling_friction_quadratic": "drag"}
    for field, respect in {**others, **dict.fromkeys(FRICTIONS, "friction")}.items():
        value = one(respect)
        physics |= {} if value is None else {field: value}
    if physics["airborne"]:
        physics |= {"table_restitution": one("table_restitution"), "motion": "sliding"}
    table, t_max = draw(TABLES), one("t_max")
    try:
        return SceneContents(name="made", balls=balls, table=table, physics=physics, t_max=t_max)
    except SceneError:
        return None


def refusal_of(check, scene: SceneContents) -> str | None:
    try:
        check(scene)
    except PydanticCustomError as error:
        return error.message()
    return None


@given(contents())
@settings(max_examples=1_000, suppress_health_check=[HealthCheck.too_slow])
def test_what_begins_plainly_keeps_every_rule(scene):
    # Fails if a condition is weaker than its rule.
    if scene is not None:
        assert refusal_of(check_scene, scene) == refusal_of(check_each_rule, scene)


def test_shipped_scenes_begin_plainly():
    # Fails if a condition is so strong that usual scenes need the slow rules.
    slow = {scene.name for scene in map(Scene.load, shipped_scenes()) if not certainly_valid(scene)}
    assert slow == {"gas-80", "polygon-bounce", "polygon-sliding", "post-bounce", "post-sliding"}
