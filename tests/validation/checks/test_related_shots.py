"""Relations between two shots: our engine keeps all, and an engine that breaks one is detected."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from biased_engines import RULES, Biased, BiasedSettings

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, SampledTrajectory, Scene, Table
from ghostball.model.features import Capability, Feature
from ghostball.model.scene.pockets import Pockets
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.checks.criteria import CriteriaError, relation_criteria
from ghostball.validation.checks.metrics import CaseMetrics, measure
from ghostball.validation.checks.related_shots import (
    SECOND_SHOTS,
)
from ghostball.validation.checks.relations import ROUNDING_FREE, WORDS, bits_of, factor_of
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import random_scene
from ghostball.validation.truth.scene_truth import Truth

OURS = make_engine("ghostball")
FACTORS = tuple(map(factor_of, WORDS))
BITS = tuple(map(bits_of, ROUNDING_FREE))


def cut(**fields: Any) -> Scene:
    """Return a shot that supports every relation: two balls on ice without a table."""
    given: dict[str, Any] = {"name": "cut", "t_max": 1.0, "physics": Physics(rolling_friction=0.0)}
    balls = [
        Ball(id="a", position=(0.1, 0.2), velocity=(1.0, 0.1)),
        Ball(id="b", position=(0.5, 0.25), velocity=(-0.5, 0.2)),
    ]
    return Scene(**given | {"balls": balls} | fields)


def related(scene: Scene, engine: Any = OURS) -> CaseMetrics:
    result = engine.simulate(scene, record="trajectory")
    return measure(result, Truth(None), (*FACTORS, *BITS), engine=engine)


def broken(found: CaseMetrics) -> set[str]:
    values = {name: found.values[factor_of(name)] for name in WORDS}
    return {name for name, value in values.items() if value is not None and value > 1.0}


# Each displacement grows with the distance that a ball moves, which a boost changes. A wind isn't
# its own mirror image after x and y are swapped, and a clock has a unit.
CAUGHT = {
    "rotate": {"rotate", "mirror", "boost"},
    "translate": {"translate", "rotate", "mirror", "scale", "boost", "split"},
    "mirror": {"mirror", "boost"},
    "renumber": {"renumber", "boost"},
    "scale": {"scale", "boost", "split"},
    "boost": {"boost"},
    "split": {"split", "scale", "boost"},
    "far-ball": {"far-ball", "boost"},
    "none": set(),
}


@pytest.mark.parametrize("way", RULES)
def test_an_engine_that_breaks_a_relation_is_caught_by_it(way: str) -> None:
    found = related(cut(), Biased(BiasedSettings(way=way)))
    assert None not in [found.values[name] for name in FACTORS], found.notes
    assert broken(found) == CAUGHT[way]


TABLES = {
    "rectangle": Table(length=2.0, width=1.0),
    "open": Table(length=2.0, width=1.0, cushions=("right", "top")),
    "pockets": Table(preset="wpa-9ft"),
    "corner pockets": Table(
        length=2.54, width=1.27, pockets=Pockets(corner=Table(preset="wpa-9ft").pockets.corner)
    ),
    "polygon": Table(vertices=((0.0, 0.0), (2.0, 0.0), (2.5, 0.6), (1.2, 1.4), (0.0, 1.0))),
    "post": Table(length=2.0, width=1.0, posts=({"centre": (0.9, 0.4), "radius": 0.05},)),
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES.keys())
def test_our_engine_keeps_every_relation_on_every_kind_of_table(table: Table) -> None:
    balls = [
        Ball(id="a", position=(0.4, 0.2), velocity=(2.0, 0.7), angular_velocity=(5.0, 8.0, 30.0)),
        Ball(id="b", position=(0.9, 0.6), velocity=(-0.5, -1.2), mass=0.2),
        Ball(id="c", position=(1.4, 0.5), radius=0.03),
    ]
    scene = Scene(name="shot", table=table, physics=Physics(preset="pool"), balls=balls)
    found = related(scene)
    kept = [name for name in WORDS if (found.values[factor_of(name)] or 0.0) <= 1.0]
    assert kept == list(WORDS)
    measured = {name for name in WORDS if found.values[factor_of(name)] is not None}
    can = {"rotate", "mirror", "renumber", "scale", "split", "far-ball"}
    assert measured == can | ({"translate"} if table is TABLES["open"] else set())
    assert {found.values[name] for name in BITS} <= {0, None}


@pytest.mark.parametrize(
    "scene", ["draw-shot", "masse", "throw-slip", "flight-lands", "frozen-triangle", "break-7"]
)
def test_our_engine_keeps_every_relation_of_shipped_scenes(scene: str) -> None:
    found = related(find_scene(scene))
    assert broken(found) == set()
    assert {found.values[name] for name in BITS} <= {0, None}


ONCE_BROKEN = (2178, 3153, 3630, 4516)
"""Random scenes in which a relation was once judged as broken."""


@pytest.mark.slow
@pytest.mark.parametrize("number", [*range(3, 5000, 83), *ONCE_BROKEN])
def test_our_engine_keeps_every_relation_of_random_scenes(number: int) -> None:
    found = related(random_scene(number))
    assert broken(found) == set()
    assert {found.values[name] for name in BITS} <= {0, None}


def test_a_difference_in_the_last_bit_is_seen_where_bits_are_promised() -> None:
    class LastBit(type(OURS)):
        def simulate(self, scene, *, record="rest"):
            result = super().simulate(scene, record=record)
            if scene.balls[0].id == "a":
                return result
            return replace(result, rest_time=float(np.nextafter(result.rest_time, 0.0)))

    found = related(cut(), LastBit(OURS.settings))
    assert found.values["renumber_bits"] >= 1
    assert found.values["scale_bits"] == 0


@pytest.mark.parametrize("relation", WORDS)
def test_a_second_shot_is_the_first_seen_from_another_side(relation: str) -> None:
    """Fails if a scene is transformed, but its result isn't transformed back by the inverse."""
    result = simulate(cut(), record="trajectory")
    made = SECOND_SHOTS[relation](result)
    starts = made.expected(np.array([made.start]), made.scene.positions[np.newaxis])
    there = result.sample([made.start]).positions[:, made.kept]
    np.testing.assert_allclose(starts, there, rtol=0.0, atol=1e-15)
    assert made.exact == (relation in (*ROUNDING_FREE, "rotate"))


def sequential(scene: Scene) -> Scene:
    ball = Ball(id="c", position=(2.0, 2.0))
    physics = Physics(rolling_friction=0.0, impacts="sequential")
    return cut(physics=physics, balls=[*scene.balls, ball])


REFUSED = {
    "boost": (cut(physics=Physics()), "cloth or air slows the balls"),
    "translate": (cut(table=Table(length=2.0, width=1.0)), "have a fixed place"),
    "renumber": (sequential(cut()), "depends on the order of the balls"),
    "split": (cut(balls=[Ball(id="a", position=(0.1, 0.2))]), "nothing moves"),
    "far-ball": (
        Scene(
            name="narrow",
            t_max=1.0,
            physics=Physics(rolling_friction=0.0),
            table=Table(length=0.4, width=0.08),
            balls=[Ball(id="a", position=(0.1, 0.04), velocity=(1.0, 0.0))],
        ),
        "no free place",
    ),
}


@pytest.mark.parametrize("relation", REFUSED)
def test_a_relation_that_a_scene_cannot_have_is_named_and_not_passed(relation: str) -> None:
    scene, why = REFUSED[relation]
    found = related(scene)
    assert found.values[factor_of(relation)] is None
    assert why in found.notes[factor_of(relation)]


def lying_on_three(apart: float) -> Scene:
    """Return a ball at rest, `apart` [m] above its place on three others, and a fast ball."""
    radius = 0.03
    edge = 2.0 * radius / np.sqrt(3.0)
    below = [(edge * np.cos(a), edge * np.sin(a)) for a in np.pi * np.array([0.5, 7 / 6, 11 / 6])]
    top = radius + np.sqrt(4.0 * radius**2 - edge**2) + apart
    balls = [
        Ball(id=f"b{k}", position=(*place, radius), radius=radius) for k, place in enumerate(below)
    ]
    balls += [
        Ball(id="top", position=(0.0, 0.0, top), radius=radius),
        Ball(id="fast", position=(1.0, 1.0), velocity=(1.0, 0.0), radius=radius),
    ]
    physics = Physics(preset="pool", airborne=True)
    return Scene(name="heap", t_max=0.3, physics=physics, balls=balls)


def test_a_shot_is_not_cut_while_a_ball_lies_on_others() -> None:
    found = related(lying_on_three(1e-9))
    assert found.values["split_factor"] is None
    assert "a ball lies on another" in found.notes["split_factor"]


def test_a_shot_is_cut_while_a_ball_flies_over_others() -> None:
    assert related(lying_on_three(0.2)).values["split_factor"] <= 1.0


def grazing() -> Scene:
    """Return a ball that passes another at a distance of 0.1 mm."""
    radius = Ball(id="a", position=(0.0, 0.0)).radius
    balls = [
        Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
        Ball(id="b", position=(0.4, 2.0 * radius + 1e-4)),
    ]
    return cut(balls=balls)


@pytest.mark.parametrize(("stated", "breaks"), [(1e-3, False), (0.0, True)])
def test_a_near_miss_within_the_stated_error_breaks_no_relation(
    stated: float, breaks: bool
) -> None:
    class Late(type(OURS)):
        """An engine with larger balls in the second shot, as if its contacts were late."""

        def resolution(self, scene):
            return stated

        def simulate(self, scene, *, record="rest"):
            if scene.name == "cut":
                return super().simulate(scene, record=record)
            radius = scene.balls[0].radius + 8e-5
            balls = [
                ball.model_copy(update={"radius": radius, "position": (*ball.position[:2], radius)})
                for ball in scene.balls
            ]
            played = super().simulate(Scene(**dict(scene) | {"balls": balls}), record=record)
            return replace(played, scene=scene)

    found = related(grazing(), Late(OURS.settings))
    assert ("renumber" in broken(found)) is breaks


@pytest.mark.parametrize("support", ["exact", "approximate"])
def test_an_engine_that_states_no_error_is_judged_only_if_it_claims_to_be_exact(
    support: str,
) -> None:
    class Silent(Biased):
        capabilities = dict.fromkeys(Feature, Capability(support, "in some way"))

        def resolution(self, scene):
            return None

    found = related(cut(), Silent(BiasedSettings(way="mirror")))
    assert ("mirror" in broken(found)) == (support == "exact")
    assert ("states no `resolution`" in found.notes.get("mirror_factor", "")) == (
        support == "approximate"
    )


def test_the_criteria_are_those_of_the_named_relations() -> None:
    metrics = [one.metric for one in relation_criteria(["mirror", "split"]).criteria]
    assert metrics == ["mirror_factor", "split_factor", "mirror_bits"]
    everything = {one.metric for one in relation_criteria().criteria}
    assert everything == {*FACTORS, *BITS}
    with pytest.raises(CriteriaError, match="Did you mean mirror"):
        relation_criteria(["miror"])


@pytest.mark.parametrize("frames", [50, 5000])
def test_positions_between_frames_may_be_off_by_the_interpolation_and_no_more(frames: int) -> None:
    """Fails if a coarse record of a right motion counts as a broken relation."""

    class Recorded(type(OURS)):
        def simulate(self, scene, *, record="rest"):
            result = super().simulate(scene, record="trajectory")
            times = np.linspace(0.0, result.rest_time, frames)
            return replace(result, trajectory=SampledTrajectory(times, *result.sample(times)))

    class Slower(Recorded):
        """An engine whose balls roll 1 % less far in a shot in other units."""

        def simulate(self, scene, *, record="rest"):
            if scene.name.endswith(".scale"):
                friction = 1.01 * scene.physics.rolling_friction
                physics = scene.physics.model_copy(update={"rolling_friction": friction})
                played = super().simulate(scene.model_copy(update={"physics": physics}))
                return replace(played, scene=scene)
            return super().simulate(scene, record=record)

    scene = find_scene("stop")
    assert broken(related(scene, Recorded(OURS.settings))) == set()
    assert "scale" in broken(related(scene, Slower(OURS.settings)))


def test_a_ball_that_balances_on_another_falls_in_no_direction_that_is_judged() -> None:
    """Breaks where a ball that falls off along x, seen from any side, counts as an error."""
    low = Ball(id="low", position=(1.0, 0.5), radius=0.03)
    top = Ball(id="top", position=(1.0, 0.5, 0.083), radius=0.0225)
    rolls = Ball(id="rolls", position=(0.2, 0.2), velocity=(0.5, 0.1))
    scene = cut(
        physics=Physics(preset="pool", airborne=True),
        table=Table(length=2.0, width=1.0),
        balls=[low, top, rolls],
        t_max=0.03,
    )
    found = related(scene)
    assert broken(found) == set()
    assert found.values["mirror_bits"] is None
    first = simulate(scene, record="trajectory").events["t"][0]
    assert f"compared up to t = {first:.4g} s" in found.said["mirror_factor"]
    assert "mirror" in broken(related(scene, Biased(BiasedSettings(way="mirror"))))


def test_contacts_whose_order_is_rounding_end_the_comparison() -> None:
    """Fails if a ball in a corner that another ball hits counts as a broken relation."""
    found = related(random_scene(400))
    assert broken(found) == set()
    assert "compared up to t = 0.08159 s of" in found.said["rotate_factor"]


class Shifted(type(OURS)):
    """Our engine, with `stated` as its error [m], and the balls of second shots `off` [m] aside."""

    stated = off = 0.0

    def resolution(self, scene: Scene) -> float:
        return self.stated

    def simulate(self, scene: Scene, *, record: Any = "rest") -> Any:
        result = super().simulate(scene, record=record)
        if not scene.name.endswith(".renumber"):
            return result
        times = np.union1d(result.events["t"], np.linspace(0.0, result.rest_time, 2000))
        places, *others = result.sample(times)
        aside = np.array([self.off, 0.0, 0.0]) * (times > 0.0)[:, np.newaxis, np.newaxis]
        motion = SampledTrajectory(times, places + aside, *others)
        return replace(result, trajectory=motion, final_state=motion.sample(times[-1:]))


@pytest.mark.parametrize(
    ("scene", "stated", "off"),
    [
        ("half-ball-cut", 0.0, 3e-14),  # rounding
        ("half-ball-cut", 1e-6, 6e-6),
        ("half-ball-cut", 1e-3, 6e-3),
        ("chaos-a", 1e-6, 1e-5),
        ("ball-mathavan", 0.0, 2e-8),  # an integrated impact
        ("push-line", 0.0, 2.5e-6),  # a contact that lasts
    ],
)
def test_a_fault_just_above_the_allowed_distance_is_caught(
    scene: str, stated: float, off: float
) -> None:
    """Breaks where an allowance grows: `off` is at most 1.8 times what is allowed today."""
    engine = Shifted(OURS.settings)
    engine.stated, engine.off = stated, off
    assert "renumber" in broken(related(find_scene(scene), engine))
    engine.off = off / 4.0
    assert "renumber" not in broken(related(find_scene(scene), engine))


def test_a_ball_in_a_corner_promises_no_bits_of_its_mirror_image() -> None:
    """Breaks where the order of two cushions that a ball hits at once counts as an error."""
    found = related(random_scene(1618))
    assert broken(found) == set()
    assert found.values["mirror_bits"] is None


def test_a_shot_that_ends_at_once_has_a_far_ball() -> None:
    """In a corner without restitution, all impacts happen at the start."""
    assert related(random_scene(3569)).values["far_ball_factor"] is None


def test_nothing_is_compared_between_the_last_known_growth_and_the_first_unknown_one() -> None:
    """After a grazing collision without restitution, no derivative exists."""
    found = related(random_scene(64))
    assert broken(found) == set()
    assert "compared up to t = 0.1352 s" in found.said["translate_factor"]
