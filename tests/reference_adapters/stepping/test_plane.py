"""Pockets, polygons and posts on time-stepping engines, compared with Ghostball's engine."""

from __future__ import annotations

import math
from itertools import islice
from typing import Any

import numpy as np
import pymunk
import pytest
from shots import R, ball, random_cloth_shot, scene_of
from side_pocket import into_side_pocket

from ghostball.engine import simulate
from ghostball.model import EventKind, Record, Result, Scene, Status, Table, event_dict
from ghostball.model.features import missing_features
from ghostball.reference_adapters import engine_class, make_engine, parse_spec
from ghostball.reference_adapters.pymunk.engine import PymunkEngine, PymunkSettings
from ghostball.reference_adapters.pymunk.world import PymunkWorld
from ghostball.reference_adapters.stepping import closed_form, plane
from ghostball.reference_adapters.stepping.cloth import ClosedFormCloth
from ghostball.validation.scenes.library import find_scene

POOL = Table.model_validate("wpa-9ft")
FREE: dict[str, Any] = {"rolling_friction": 0.0}
L_SHAPE = Table.model_validate(
    {"vertices": [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]}
)

ENGINES = ("pymunk", "box2d", "pybullet", "mujoco", "box2d3", "rapier", "dart", "physx", "newton")
SPECS = [*ENGINES, *(f"{name}:contact_steps=exact" for name in ENGINES)]

EXACT = {
    "pymunk": 1e-7,
    "pybullet": 1e-7,
    "mujoco": 1e-5,
    "box2d": 1e-4,
    "box2d3": 1e-4,
    "newton": 1e-4,
    "rapier": 1e-4,
    "physx": 1e-4,
    "dart": 1e-3,
}
"""Limits on rest position errors with steps that end at contacts [m], by the engine's precision.

DART takes 1e-5 of each impulse.
"""


def play(spec: str, scene: Scene, record: Record = "trajectory") -> Result:
    reason = engine_class(parse_spec(spec)[0]).unavailable()
    if reason is not None:
        pytest.skip(reason)
    return make_engine(spec).simulate(scene, record=record)


def met(result: Result) -> list[tuple[str, int, Any]]:
    assert result.events is not None
    events = [event_dict(event) for event in result.events]
    kinds = {EventKind.BALL_BALL.label, EventKind.BALL_CUSHION.label, EventKind.POCKETED.label}
    return [(e["kind"], e["a"], e["b"]) for e in events if e["kind"] in kinds]


@pytest.mark.parametrize("spec", SPECS)
def test_a_ball_is_pocketed_where_and_when_its_centre_enters_the_hole(spec: str) -> None:
    """A fall isn't detected at the end of the step, but within 1e-7 m and s (single precision)."""
    hole = next(hole for hole in POOL.holes if hole.centre[1] < 0.0 and hole.centre[0] == 1.27)
    edge, slowing = hole.centre[1] + hole.radius, 0.02 * 9.81
    result = play(spec, scene_of(ball((1.27, 0.6), (0.0, -1.5)), table=POOL))
    assert met(result) == [("pocketed", 0, "bottom")]
    assert result.rest_positions[0] == pytest.approx([1.27, edge, 0.028575], abs=1e-7)
    way = 0.6 - edge
    t = 2.0 * way / (1.5 + math.sqrt(1.5**2 - 2.0 * slowing * way))
    assert result.events is not None
    assert result.events["t"] == pytest.approx([t], abs=2e-7)
    assert result.status is Status.REST
    assert t <= result.rest_time <= t + 1e-3
    assert result.energy([result.rest_time]).total[0] == 0.0


@pytest.mark.parametrize("spec", ["pymunk", "pymunk:contact_steps=exact", "pybullet"])
def test_a_run_ends_with_the_spin_of_a_ball_that_stopped_before(spec: str) -> None:
    """The end of a spin is no event, so the run once continued to its time limit."""
    spins = ball((0.5, 0.5), (0.1, 0.0), angular_velocity=(0.0, 0.1 / R, 20.0))
    physics = {"preset": "pool", "rolling_friction": 0.02, "spinning_friction_rate": 10.0}
    result = play(spec, scene_of(spins, t_max=4.0, **physics))
    assert result.status is Status.REST
    assert 2.0 <= result.rest_time <= 2.0 + 2e-3


@pytest.mark.parametrize("engine", ["pymunk", "pybullet", "mujoco"])
@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-7])
def test_the_cloth_takes_all_its_energy_in_the_short_steps_of_a_contact(
    engine: str, depth: float
) -> None:
    """A frame must have the motion at its own time, also during a long grazing contact."""
    aside = 2.0 * R * (1.0 - depth)
    balls = ball((0.0, 0.0), (1.0, 0.0)), ball((0.1, aside))
    scene = scene_of(*balls, t_max=0.2, rolling_friction=0.02)
    frames = play(f"{engine}:contact_steps=exact", scene).trajectory
    assert frames is not None
    speeds = np.linalg.norm(frames.velocities, axis=2)
    energies = 0.7 * (speeds**2 @ scene.masses)
    powers = 1.4 * 0.02 * 9.81 * (speeds @ scene.masses)
    durations = np.diff(frames.times)
    short = (durations > 0.0) & (durations < 1e-5)
    taken = durations * np.minimum(powers[:-1], powers[1:])
    rounding = 1e-15 * energies[0]
    assert np.any(short)
    assert np.all((energies[:-1] - energies[1:] - taken)[short] > -rounding - 0.01 * taken[short])


@pytest.mark.parametrize("spec", SPECS)
def test_nothing_meets_a_ball_that_is_gone(spec: str) -> None:
    """A second ball on the same line falls at the same position."""
    scene = scene_of(
        ball((1.27, 0.4), (0.0, -1.0)),
        ball((1.27, 0.6), (0.0, -1.0)),
        ball((1.2, 0.9), (0.3, 0.5)),
        table=POOL,
        t_max=1.2,
        **FREE,
    )
    result = play(spec, scene)
    assert [kind for kind, _, _ in met(result)][:2] == ["pocketed"] * 2
    assert result.collision_counts["ball-ball"] == 0
    places = result.rest_positions
    assert places[0] == pytest.approx(places[1], abs=1e-7)
    energy = result.energy(np.unique(result.trajectory.times)).total  # type: ignore[union-attr]
    assert np.max(np.diff(energy)) <= 1e-7  # the rounding of an impact in single precision


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize(
    ("place", "velocity", "events"),
    [
        ((1.1, 0.5), (0.18, -0.9), ["bottom"]),  # a jaw of the side pocket
        ((0.6, 0.63), (-1.0, -0.99), ["left", "bottom-left"]),  # a facing, then the pocket
    ],
)
def test_jaws_and_facings_are_met_as_by_our_engine(
    spec: str, place: tuple[float, float], velocity: tuple[float, float], events: list[str]
) -> None:
    scene = scene_of(ball(place, velocity), table=POOL, t_max=1.0, **FREE)
    result, ours = play(spec, scene), simulate(scene, record="events")
    assert met(result) == met(ours)
    assert [partner for _, _, partner in met(result)] == events
    name, settings = parse_spec(spec)
    limit = EXACT[name] if settings else 4e-3
    assert result.rest_positions == pytest.approx(ours.rest_positions, abs=limit)


@pytest.mark.parametrize("spec", SPECS)
def test_a_corner_that_points_into_the_table_is_one_contact(spec: str) -> None:
    aside = 0.01
    along, across = np.array([1.0, 1.0]) / math.sqrt(2.0), np.array([1.0, -1.0]) / math.sqrt(2.0)
    place = np.array([1.0, 1.0]) - 0.3 * along + aside * across
    scene = scene_of(ball(tuple(place), tuple(along)), table=L_SHAPE, t_max=0.5, **FREE)
    result = play(spec, scene)
    assert met(result) == [("ball-cushion", 0, "side-3")]
    radius = scene.balls[0].radius
    normal = (aside * across - math.sqrt(radius**2 - aside**2) * along) / radius
    want = along - 2.0 * (along @ normal) * normal
    name, settings = parse_spec(spec)
    limit = {"dart": 1e-3, "box2d": 1e-3, "box2d3": 1e-3}.get(name, 3e-4) if settings else 0.03
    assert result.final_state.velocities[0, 0, :2] == pytest.approx(want, abs=limit)


@pytest.mark.parametrize("spec", SPECS)
def test_a_post_is_met_by_name(spec: str) -> None:
    table = Table.model_validate(
        {"length": 1.0, "width": 1.0, "posts": [{"centre": (0.5, 0.5), "radius": 0.1}]}
    )
    scene = scene_of(ball((0.2, 0.45), (1.0, 0.1)), table=table, t_max=0.4, **FREE)
    result, ours = play(spec, scene), simulate(scene)
    assert met(result) == [("ball-cushion", 0, "post-1")]
    name, settings = parse_spec(spec)
    limit = EXACT[name] if settings else 4e-3
    assert result.rest_positions == pytest.approx(ours.rest_positions, abs=limit)


@pytest.mark.parametrize(
    "physics",
    [
        {"cushion": "restitution", "cushion_restitution": 0.8, "cushion_restitution_loss": 0.15},
        {"cushion": "restitution", "cushion_tangential_restitution": 0.7},
        {"cushion": "frictional", "cushion_restitution": 0.8, "cushion_friction": 0.2},
    ],
    ids=["falling", "tangential", "frictional"],
)
@pytest.mark.parametrize("spec", ["pymunk:contact_steps=exact", "box2d:contact_steps=exact"])
def test_laws_that_the_adapter_applies_take_the_normal_of_the_jaw(
    spec: str, physics: dict[str, Any]
) -> None:
    scene = scene_of(
        ball((1.1, 0.5), (0.18, -0.9), angular_velocity=(5.0, 0.0, 20.0)),
        table=POOL,
        motion="sliding",
        **physics,
    )
    result, ours = play(spec, scene), simulate(scene, record="events")
    assert met(result) == met(ours) == [("ball-cushion", 0, "bottom")]
    limit = EXACT[parse_spec(spec)[0]]
    assert result.rest_positions == pytest.approx(ours.rest_positions, abs=limit)


@pytest.mark.parametrize(
    ("spec", "limit"),
    [("pymunk", 1e-9), ("pybullet", 1e-3), ("physx:cloth=own", 5e-3), ("dart:cloth=own", 5e-3)],
)
def test_a_ball_that_slides_falls_with_all_its_spin(spec: str, limit: float) -> None:
    scene = scene_of(
        ball((1.1, 0.5), (0.18, -0.9), angular_velocity=(10.0, 20.0, 30.0)),
        table=POOL,
        motion="sliding",
        rolling_friction=0.01,
    )
    result, ours = play(spec, scene), simulate(scene, record="events")
    assert met(result) == met(ours) == [("pocketed", 0, "bottom")]
    assert result.rest_positions == pytest.approx(ours.rest_positions, abs=limit)
    assert result.energy([result.rest_time]).total[0] == pytest.approx(0.0, abs=1e-9)
    assert result.status is Status.REST


# --- Alciatore's technical proof 3.5: a side pocket whose jaws are points


def goes_in(spec: str, degrees: float, aims: tuple[float, float, int]) -> bool:
    """Return True if some ball at an angle to the pocket's axis falls in, for any offset."""
    for aim in np.linspace(*aims):
        shot = into_side_pocket(degrees, float(aim), away=0.15, t_max=0.35)
        if ("pocketed", 0, "bottom") in met(play(spec, shot)):
            return True
    return False


@pytest.mark.parametrize("spec", ["pymunk:contact_steps=exact", "box2d:contact_steps=exact"])
def test_the_critical_angle_of_a_side_pocket(spec: str) -> None:
    """The largest angle is 68.292 degrees, for mirror cushions."""
    aims = (0.01294, 0.01300, 21)
    assert goes_in(spec, 68.2905, aims)
    assert not goes_in(spec, 68.2935, aims)


@pytest.mark.slow
@pytest.mark.parametrize(("dt", "widest"), [("1e-3", 68.40), ("1e-4", 68.288)])
def test_the_critical_angle_in_fixed_steps_comes_near_to_it(dt: str, widest: float) -> None:
    aims = (0.0124, 0.0136, 25)
    assert goes_in(f"pymunk:dt={dt}", widest - 0.02, aims)
    assert not goes_in(f"pymunk:dt={dt}", widest + 0.02, aims)


class WholeKicks(ClosedFormCloth):
    """A cloth without the shortcut for steps without collisions."""

    early = 0

    def kick(self, changes, turns, dt):
        WholeKicks.early += not changes.any() and (turns is None or not turns.any())
        self._kick_all(changes, turns, dt)

    def keep(self, *, rubs):
        WholeKicks.early += 1
        turns = np.zeros((len(self.rolling), 3)) if rubs else None
        self._kick_all(np.zeros_like(self.velocities), turns, 1.0)


def bits(scene: Scene, steps: str, **settings: object) -> list[bytes]:
    run = PymunkEngine(PymunkSettings(contact_steps=steps, **settings)).simulate(
        scene, record="trajectory"
    )
    moments = np.linspace(0.0, run.trajectory.t_end, 1000)
    arrays = [run.events, *run.final_state, *run.trajectory.sample(moments)]
    return [array.tobytes() for array in arrays]


SLIDES_WITH_A_SPIN_OF_MINUS_ZERO = scene_of(
    ball((0, 0), (2.0, 0.5), angular_velocity=(-0.0, -0.0, -0.0)),
    ball((0.5, 0.14), (-0.0, -0.1)),
    ball((0.2, 0.5), angular_velocity=(-0.0, 40.0, -0.0)),
    motion="sliding",
    ball_friction=0.06,
)


@pytest.mark.parametrize("steps", ["fixed", "exact"])
def test_a_kick_without_a_collision_may_skip_the_spin(steps, monkeypatch):
    """The results are bit-identical in shots whose balls slide, roll, collide and spin.

    Fails if code reads the spin that a rolling ball had before its velocity last changed.
    """
    able = PymunkEngine(PymunkSettings(contact_steps=steps)).capabilities
    scenes = map(random_cloth_shot, range(60))
    shots = list(islice((one for one in scenes if not missing_features(able, one)), 4))
    shots = [one.model_copy(update={"t_max": 1.0}) for one in shots]
    shots += [SLIDES_WITH_A_SPIN_OF_MINUS_ZERO, find_scene("draw-shot")]
    found = [bits(shot, steps) for shot in shots]
    monkeypatch.setattr(closed_form, "ClosedFormCloth", WholeKicks)
    monkeypatch.setattr(WholeKicks, "early", 0)
    assert [bits(shot, steps) for shot in shots] == found
    assert WholeKicks.early > 100


@pytest.mark.parametrize("spec", SPECS)
def test_steps_without_contacts_that_are_not_read_change_no_bit(
    spec: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fails if a world misses a contact, so that its effect is dropped."""
    found = find_scene("cradle")
    quick = play(spec, found)
    world: Any = engine_class(parse_spec(spec)[0])
    always = property(lambda _: True, lambda _, __: None)
    monkeypatch.setattr(world.world_class(), "touched", always, raising=False)
    slow = play(spec, found)
    assert quick.work == slow.work
    assert quick.rest_time == slow.rest_time
    assert quick.events is not None
    assert slow.events is not None
    assert np.array_equal(quick.events, slow.events)
    times = np.linspace(0.0, slow.rest_time, 97)
    assert all(map(np.array_equal, quick.sample(times), slow.sample(times)))


def test_only_the_steps_of_the_engine_count_as_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails if the time of the adapter counts, or if the untimed steps are left out."""
    now = 0.0

    def slower(owner: Any, name: str, seconds: float) -> None:
        call = getattr(owner, name)

        def timed(*arguments: Any) -> Any:
            nonlocal now
            now += seconds
            return call(*arguments)

        monkeypatch.setattr(owner, name, timed)

    slower(pymunk.Space, "step", 3.0)
    slower(PymunkWorld, "read_contacts", 50.0)
    slower(PymunkWorld, "positions_and_velocities", 70.0)
    monkeypatch.setattr(plane, "perf_counter", lambda: now)
    engine, scene = PymunkEngine(), find_scene("half-ball-cut")
    stepper = engine.stepper(scene, engine.world(scene))
    for _ in range(100):
        stepper.step()
    assert stepper.engine_time(100) == 300.0


@pytest.mark.parametrize("spec", SPECS)
def test_an_engine_s_own_time_is_a_part_of_the_run_time(spec: str) -> None:
    result = play(spec, find_scene("frozen-line"))
    assert result.engine_time is not None
    assert 0.0 < result.engine_time <= result.wall_time


PLANNING = [name for name in ENGINES if name != "newton"]
"""Engines whose steps are planned; Newton's world doesn't say which steps have no contact."""


@pytest.mark.parametrize("spec", PLANNING)
@pytest.mark.parametrize("record", ["trajectory", "events"])
def test_planned_steps_change_no_bit_of_a_result(spec, record, monkeypatch) -> None:
    """Slides, rolls, cushions, and several collisions; the plan ends at each contact.

    With a tangential restitution, each step needs the positions before it.
    """
    follow, followed = closed_form.ClosedFormStepper._follow, 0

    def counted(*arguments: Any) -> int:
        nonlocal followed
        followed += 1
        return follow(*arguments)

    monkeypatch.setattr(closed_form.ClosedFormStepper, "_follow", counted)
    bounces = ball((1.5, 0.2), (0.3, -0.6))
    moving = ball((0.3, 0.5), (1.5, 0.1)), ball((1.6, 0.9), (-1.0, -0.4)), bounces
    resting = ball((0.9, 0.55)), ball((0.9 + 2.0 * R, 0.55))
    slides = ball((0.3, 0.9), (0.5, 0.8), angular_velocity=(0.0, 60.0, 20.0))
    table = Table(length=2.0, width=1.2)
    mirror: dict[str, Any] = {"cushion": "mirror"}
    along = {"cushion": "restitution", "cushion_tangential_restitution": 0.5}
    for balls, motion, cushion in (
        ((*moving, *resting), "rolling", mirror),
        ((*moving, *resting), "rolling", along),
        ((*moving, *resting, slides), "sliding", mirror),
        ((*moving, *resting, slides), "sliding", along),
    ):
        scene = scene_of(*balls, table=table, motion=motion, t_max=1.2, **cushion)
        if spec == "pymunk" and motion == "rolling":  # with Pymunk's joints
            continue
        if spec == "pybullet" and (motion == "sliding" or cushion is along):
            continue  # on Bullet's own cloth, or unsupported
        followed = 0
        planned = play(spec, scene, record=record)
        assert followed > 0
        assert planned.collision_counts["ball-ball"] >= 2
        assert planned.collision_counts["ball-cushion"] >= 1
        with monkeypatch.context() as patch:
            patch.setattr(closed_form._Plan, "extend", lambda *_: False)
            followed = 0
            stepped = play(spec, scene, record=record)
        assert followed == 0
        assert planned.work == stepped.work
        assert planned.rest_time == stepped.rest_time
        for one, other in zip(planned.final_state, stepped.final_state, strict=True):
            assert one.tobytes() == other.tobytes()
        assert planned.events is not None
        assert stepped.events is not None
        assert planned.events.tobytes() == stepped.events.tobytes()
        if planned.trajectory is not None and stepped.trajectory is not None:
            for name in ("times", "positions", "velocities", "angular_velocities"):
                one, other = (getattr(run.trajectory, name) for run in (planned, stepped))
                assert one.tobytes() == other.tobytes()
