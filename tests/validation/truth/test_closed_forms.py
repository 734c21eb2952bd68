"""Closed forms against independent checks: a stepping oracle, conservation laws, pi itself."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from numpy.typing import NDArray
from step_rules import limit_of_step

from ghostball.engine import CUSHIONS, Ball, Physics, Scene, Table
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import DIGITS, FORMS, ClosedForm, closed_form

FloatArray = NDArray[np.float64]


def solved(name: str) -> tuple[Scene, ClosedForm]:
    scene = find_scene(name)
    form = closed_form(scene)
    assert form is not None
    return scene, form


def as_array(vectors: Any) -> FloatArray:
    return np.array([[float(value) for value in vector] for vector in vectors])


# --- a naive oracle: step until something overlaps, bisect back to the touch, resolve, go on


class SteppingOracle:
    """Doubles, fixed steps and bisection: shares neither formula nor order with the forms.

    `late` [s] resolves every collision that much after the touch, as a stepping engine does.
    """

    def __init__(self, scene: Scene, step: float = 1e-3, late: float = 0.0) -> None:
        self.scene, self.step, self.late = scene, step, late
        self.x, self.v = scene.positions[:, :2], scene.velocities[:, :2]
        self.a = scene.physics.rolling_friction * scene.physics.gravity
        self.t = 0.0
        self.collisions: list[tuple[str, int, int | str]] = []

    def after(self, dt: float) -> tuple[FloatArray, FloatArray]:
        speed = np.hypot(self.v[:, 0], self.v[:, 1])
        direction = self.v / np.where(speed > 0, speed, 1)[:, None]
        tau = np.minimum(dt, speed / self.a) if self.a > 0 else np.full_like(speed, dt)
        travelled = speed * tau - self.a * tau**2 / 2
        left = np.where(tau < dt, 0.0, speed - self.a * tau)
        return self.x + direction * travelled[:, None], direction * left[:, None]

    def candidates(self, x: FloatArray, v: FloatArray) -> dict[tuple[str, int, int | str], float]:
        """Gap of everything that approaches [m]."""
        radii, gaps = self.scene.radii, {}
        for a, b in itertools.combinations(range(len(x)), 2):
            if (x[b] - x[a]) @ (v[b] - v[a]) < 0:
                gaps["ball-ball", a, b] = np.hypot(*(x[b] - x[a])) - radii[a] - radii[b]
        table = self.scene.table
        for ball, name in itertools.product(range(len(x)), table.cushions if table else ()):
            axis, far = divmod(CUSHIONS.index(name), 2)
            if v[ball, axis] * (1 if far else -1) > 0:
                extent = (table.length, table.width)[axis]
                gap = extent - x[ball, axis] if far else x[ball, axis]
                gaps["ball-cushion", ball, name] = gap - radii[ball]
        return gaps

    def run(self) -> SteppingOracle:
        end = self.scene.t_max or np.inf
        while self.t < end and np.any(self.v):
            dt = min(self.step, end - self.t)
            touching = [k for k, gap in self.candidates(*self.after(dt)).items() if gap < 0]
            if touching:
                dt, what = min((self.touch(what, dt), what) for what in touching)
                dt = min(dt + self.late, end - self.t)
            self.x, self.v = self.after(dt)
            self.t += dt
            if touching:
                self.resolve(*what)
        return self

    def touch(self, what: tuple[str, int, int | str], high: float) -> float:
        low = 0.0
        for _ in range(60):
            middle = (low + high) / 2
            gap = self.candidates(*self.after(middle)).get(what, 1.0)
            low, high = (low, middle) if gap < 0 else (middle, high)
        return low

    def resolve(self, kind: str, a: int, b: int | str) -> None:
        self.collisions.append((kind, a, b))
        physics, masses = self.scene.physics, self.scene.masses
        if isinstance(b, str):
            normal = CUSHIONS.index(b) // 2
            self.v[a, normal] *= -physics.cushion_restitution
            self.v[a, 1 - normal] *= physics.cushion_tangential_restitution
            return
        # Centre of mass frame: the normal relative velocity turns around, times e.
        n = (self.x[b] - self.x[a]) / np.hypot(*(self.x[b] - self.x[a]))
        centre = (masses[a] * self.v[a] + masses[b] * self.v[b]) / (masses[a] + masses[b])
        relative = self.v[b] - self.v[a]
        relative = relative - (1 + physics.ball_restitution) * (relative @ n) * n
        self.v[a] = centre - masses[b] / (masses[a] + masses[b]) * relative
        self.v[b] = centre + masses[a] / (masses[a] + masses[b]) * relative


# The oracle resolves impacts of one instant one after another, which is not symmetric; and in one
# of its steps there are more than one of thousands of collisions.
NOT_STEPPED = ("three-ball-symmetric", "galperin-2", "galperin-3", "galperin-4")

STEPPED = [
    name
    for name, form in FORMS.items()
    if form.motion == "rolling" and not form.air and name not in NOT_STEPPED
]


@pytest.mark.parametrize("name", STEPPED)
def test_agrees_with_stepping_and_bisection(name: str) -> None:
    # Breaks with a wrong formula, order, sign or law in a form; 1e-9 m is far below any of them.
    scene, form = solved(name)
    oracle = SteppingOracle(scene).run()
    assert tuple(oracle.collisions) == form.event_sequence
    np.testing.assert_allclose(oracle.x, as_array(form.rest_positions), rtol=0, atol=1e-9)
    np.testing.assert_allclose(oracle.v, as_array(form.final_velocities), rtol=0, atol=1e-9)
    # The oracle notices rest one step late.
    assert -1e-9 <= oracle.t - float(form.rest_time) <= oracle.step


# --- what is allowed to engines that see contacts late


STEPS = {"pymunk": 1e-3, "paper-discrete": 2e-2}
"""Steps of engines [s]."""

# Two collisions of one instant, or within a step of 20 ms; and more than a radius in such a step.
NO_LIMIT = {
    *(("pymunk", name) for name in ("corner-exact", "frozen-to-cushion")),
    *(
        ("paper-discrete", name)
        for name in ("corner-exact", "frozen-to-cushion", "galperin-1", "three-ball-chain")
    ),
    ("paper-discrete", "unbounded-cut"),
}

LIMITED = [(engine, name) for engine in STEPS for name in STEPPED if (engine, name) not in NO_LIMIT]


@pytest.mark.parametrize("name", STEPPED)
def test_a_step_sets_a_limit_wherever_it_can(name: str) -> None:
    # Breaks where limits are no longer computed: then nothing would judge how shots end.
    for engine in STEPS:
        limit = limit_of_step(find_scene(name), engine)
        assert (limit is None) == ((engine, name) in NO_LIMIT)


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "name"), LIMITED)
def test_limits_are_what_delayed_contacts_cost(engine: str, name: str) -> None:
    # Breaks where the derivative by a delay, or what it leaves out, is wrong: the oracle delays.
    scene, form = solved(name)
    limit, dt = limit_of_step(scene, engine), STEPS[engine]
    assert limit is not None
    rest = as_array(form.rest_positions)
    shift = 0.0
    for eighths in range(1, 9):
        oracle = SteppingOracle(scene, step=5e-3, late=dt * eighths / 8).run()
        shift = max(shift, float(np.max(np.hypot(*(oracle.x - rest).T))))
    stepping = dt * np.max(np.hypot(*scene.velocities[:, :2].T))
    assert shift <= limit
    # Delays that differ from contact to contact move the end by up to 1.6 times as much as equal
    # ones; of Galperin's 31, which take turns, by 6.5 times: that scene states a limit of its own.
    assert limit <= (6.6 if name == "galperin-1" else 1.6) * shift + 10 * stepping


def test_the_limit_of_a_break_is_what_delayed_contacts_cost() -> None:
    # As above, of a certified shot, whose collisions amplify a delay; of a nanosecond, so that they
    # stay the same ones.
    scene, dt = find_scene("break-7"), 1e-9
    limit = limit_of_step(scene, f"pymunk:dt={dt}")
    assert limit is not None
    rest, late = (SteppingOracle(scene, step=5e-3, late=late).run().x for late in (0.0, dt))
    shift = float(np.max(np.hypot(*(late - rest).T)))
    assert shift <= limit <= 1.6 * shift


# --- conservation, from the rest positions alone

ELASTIC_HITS = [
    "head-on",
    "half-ball-cut",
    "thin-cut",
    "unequal-balls",
    "unbounded-cut",
    "figure4-head-on",
    "figure4-skewed",
]


@pytest.mark.parametrize("name", ELASTIC_HITS)
def test_friction_work_equals_the_initial_energy(name: str) -> None:
    # The object ball leaves along the line of centres, so its rest position gives the contact, and
    # friction mu m g over all paths must use up the energy: to 45 digits, not to a tolerance.
    scene, form = solved(name)
    with mp.workdps(DIGITS):
        cue, target = (mp.matrix(ball.position[:2]) for ball in scene.balls)
        rest_cue, rest_target = (mp.matrix(position) for position in form.rest_positions)
        reach = mp.mpf(scene.balls[0].radius) + mp.mpf(scene.balls[1].radius)
        m_cue, m_target = (mp.mpf(ball.mass) for ball in scene.balls)
        normal = (rest_target - target) / mp.norm(rest_target - target)
        contact = target - reach * normal
        path_cue = mp.norm(contact - cue) + mp.norm(rest_cue - contact)
        work = m_cue * path_cue + m_target * mp.norm(rest_target - target)
        work *= mp.mpf(scene.physics.rolling_friction) * mp.mpf(scene.physics.gravity)
        initial = m_cue * mp.norm(mp.matrix(scene.balls[0].velocity[:2])) ** 2 / 2
        assert abs(work / initial - 1) < mp.mpf(10) ** -45


def test_half_ball_cut_shares_the_energy_three_to_one() -> None:
    # sin(cut) = 1/2 up to the rounding of the scene's offset: cos^2 = 3/4 to the object ball, and
    # stopping distances share as energies do. Breaks if the offset isn't half a diameter.
    scene, form = solved("half-ball-cut")
    rest = as_array(form.rest_positions)
    contact = scene.positions[1, :2] - 2 * scene.balls[0].radius * np.array([np.sqrt(3) / 2, 0.5])
    travelled = np.hypot(*(rest - [contact, scene.positions[1, :2]]).T)
    assert travelled[1] / travelled[0] == pytest.approx(3.0, rel=1e-12)


def test_restitution_head_on_leaves_the_textbook_speeds() -> None:
    scene, form = solved("restitution-head-on")
    e, mu_g = 0.9, 0.02 * 9.81
    contact = scene.positions[1, 0] - 2 * scene.balls[0].radius
    v2 = 0.8**2 - 2 * mu_g * (contact - 0.5)
    rest = as_array(form.rest_positions)
    np.testing.assert_allclose(
        rest[:, 0] - [contact, scene.positions[1, 0]],
        [((1 - e) / 2) ** 2 * v2 / (2 * mu_g), ((1 + e) / 2) ** 2 * v2 / (2 * mu_g)],
        rtol=1e-12,
    )


def test_catch_up_happens_at_the_published_time() -> None:
    # pooltool finds a phantom collision at t = 0 here; the truth is 0.8857 s.
    scene, form = solved("catch-up")
    gap = 0.5 - 2 * scene.balls[0].radius
    meeting = gap / 0.5
    after = SteppingOracle(scene).after(meeting)[0]
    assert meeting == pytest.approx(0.8857, abs=5e-5)
    # Equal balls exchange velocities: each ends where the other would have, one diameter off.
    ends = sorted([1.0 + 1.0 / (2 * 0.1962), 1.5 + 0.25 / (2 * 0.1962)])
    diameter = 2 * scene.balls[0].radius
    assert after[1, 1] - after[0, 1] == pytest.approx(diameter, abs=1e-12)
    np.testing.assert_allclose(
        as_array(form.rest_positions)[:, 1],
        [ends[0] - diameter, ends[1] + diameter],
        rtol=1e-12,
    )


# --- sliding


@pytest.mark.parametrize("name", ["sliding-stun", "sliding-swerve"])
def test_sliding_agrees_with_integrated_newton_euler(name: str) -> None:
    # Forces and torques alone: mu_s m g against the slip at the cloth, I = 2/5 m R^2.
    scene, form = solved(name)
    physics, radius = scene.physics, scene.balls[0].radius
    x, v = scene.positions[0, :2], scene.velocities[0, :2]
    w = scene.angular_velocities[0, :2]
    t, dt = 0.0, 2e-5

    def slip() -> FloatArray:
        return v + radius * np.array([-w[1], w[0]])

    while (speed := np.hypot(*slip())) > 3.5 * physics.sliding_friction * physics.gravity * dt:
        force = -physics.sliding_friction * physics.gravity * slip() / speed
        x = x + v * dt + force * dt**2 / 2
        v = v + force * dt
        w = w + 2.5 / radius * np.array([force[1], -force[0]]) * dt
        t += dt
    stop = np.hypot(*v) / (physics.rolling_friction * physics.gravity)
    np.testing.assert_allclose(
        x + v * stop / 2, as_array(form.rest_positions)[0], rtol=0, atol=1e-4
    )
    assert t + stop == pytest.approx(float(form.rest_time), abs=1e-3)


def test_stun_shot_rolls_at_five_sevenths() -> None:
    scene, form = solved("sliding-stun")
    g, mu_s, mu_r = 9.81, 0.2, 0.02
    travelled = float(form.rest_positions[0][0]) - scene.balls[0].position[0]
    assert travelled == pytest.approx(
        12 / (49 * mu_s * g) + (5 / 7) ** 2 / (2 * mu_r * g), rel=1e-13
    )


# --- Galperin


@pytest.mark.parametrize("k", range(5))
def test_galperin_counts_are_the_digits_of_pi(k: int) -> None:
    _, form = solved(f"galperin-{k}")
    with mp.workdps(DIGITS):
        assert sum(form.collision_counts.values()) == int(mp.pi * 10**k)


@pytest.mark.parametrize("k", [0, 1, 2, 3, pytest.param(4, marks=pytest.mark.slow)])
def test_galperin_unfolding_agrees_with_collision_by_collision(k: int) -> None:
    # Without any trigonometry: next contact, exchange of momentum, 10^k pi times over.
    scene, form = solved(f"galperin-{k}")
    with mp.workdps(DIGITS):
        m, big = (mp.mpf(ball.mass) for ball in scene.balls)
        x, y = (mp.mpf(ball.position[0]) for ball in scene.balls)
        u, v = (mp.mpf(ball.velocity[0]) for ball in scene.balls)
        r, s = (mp.mpf(ball.radius) for ball in scene.balls)
        left = mp.mpf(scene.t_max)
        sequence = []
        while True:
            to_ball = (y - x - r - s) / (u - v) if u > v and sequence[-1:] != ["ball"] else mp.inf
            to_cushion = (r - x) / u if u < 0 else mp.inf
            dt = min(to_ball, to_cushion, left)
            x, y, left = x + u * dt, y + v * dt, left - dt
            if left == 0:
                break
            if to_ball < to_cushion:
                u, v = (
                    ((m - big) * u + 2 * big * v) / (m + big),
                    ((big - m) * v + 2 * m * u) / (m + big),
                )
            else:
                u = -u
            sequence.append("ball" if to_ball < to_cushion else "cushion")
        assert [kind == "ball-ball" for kind, _, _ in form.event_sequence] == [
            kind == "ball" for kind in sequence
        ]
        found = [form.rest_positions[0][0], form.rest_positions[1][0]]
        found += [form.final_velocities[0][0], form.final_velocities[1][0]]
        for value, expected in zip(found, (x, y, u, v), strict=True):
            assert abs(value - expected) < mp.mpf(10) ** -40


# --- conditioning, and what has no closed form


def test_conditioning_of_a_straight_roll_is_that_of_the_formula() -> None:
    # x + v^2 / (2 mu g): |x| once, |y| once, the distance twice for v and once each for mu and g.
    scene = Scene(name="stop", balls=(Ball(id="cue", position=(0.5, 0.25), velocity=(0.8, 0.0)),))
    form = closed_form(scene)
    assert form is not None
    distance = 0.8**2 / (2 * 0.02 * 9.81)
    assert form.conditioning[0] == pytest.approx(0.5 + 0.25 + 4 * distance, rel=1e-12)
    # v / (mu g): once for each.
    assert form.rest_time_conditioning == pytest.approx(3 * 0.8 / (0.02 * 9.81), rel=1e-12)


@pytest.mark.parametrize("name", ["thin-cut", "around-the-table", "moving-moving", "galperin-2"])
def test_conditioning_bounds_what_rounding_the_inputs_does(name: str) -> None:
    # Nudge x, v and m of the first ball by a relative 1e-9 at once: the end moves by no more than
    # 1e-9 times the conditioning, and not by nothing.
    scene, form = solved(name)
    relative = 1e-9
    ball = scene.balls[0]
    nudged_ball = Ball(
        id=ball.id,
        position=(ball.position[0] * (1 + relative), ball.position[1]),
        velocity=(ball.velocity[0] * (1 + relative), ball.velocity[1]),
        radius=ball.radius,
        mass=ball.mass * (1 + relative),
    )
    moved = closed_form(scene.model_copy(update={"balls": (nudged_ball, *scene.balls[1:])}))
    assert moved is not None
    shift = np.hypot(*(as_array(moved.rest_positions) - as_array(form.rest_positions)).T)
    assert np.all(shift <= relative * form.conditioning * (1 + 1e-3))
    assert shift.max() > 0.01 * relative * form.conditioning.max()


def test_a_scene_without_a_form_has_none() -> None:
    assert closed_form(find_scene("break-7")) is None


@pytest.mark.parametrize(
    ("change", "shape"),
    [
        ({"physics": Physics(motion="sliding")}, True),
        ({"physics": Physics(ball_friction=0.05)}, False),
        ({"physics": Physics(air_drag=0.004)}, False),
        # The object ball now meets the right cushion, the cue ball misses, or it bounces first.
        ({"table": Table(length=1.5, width=1.27)}, True),
        (
            {
                "balls": (
                    Ball(id="a", position=(0.5, 0.5), velocity=(0.8, 0)),
                    Ball(id="b", position=(1.2, 0.635)),
                )
            },
            True,
        ),
        (
            {
                "balls": (
                    Ball(id="a", position=(0.5, 0.635), velocity=(-3.0, 0)),
                    Ball(id="b", position=(1.2, 0.635)),
                )
            },
            False,
        ),
    ],
)
def test_a_namesake_with_other_physics_or_collisions_is_not_judged_by_the_name(
    change: dict[str, Any], shape: bool
) -> None:
    # A user's own scene called "head-on" must not be judged by the form of ours.
    scene = find_scene("head-on").model_copy(update=change)
    found, unnamed = closed_form(scene), closed_form(scene.model_copy(update={"name": "mine"}))
    assert (found is not None) == (unnamed is not None) == shape
    if found is not None and unnamed is not None:
        assert found.rest_positions == unnamed.rest_positions
        assert found.event_sequence == unnamed.event_sequence


# --- a scene of one's own ----------------------------------------------------------------------

SOLVED_BY_NAME_ALONE = {
    *("cradle", "three-ball-symmetric", "frozen-to-cushion"),  # at one instant
    *("push", "wedged", "corner-exact", "rail-into"),  # in contact, or two cushions at once
    *("flight-throw", "flight-bounces"),  # off the cloth
    "around-the-table",  # too many collisions
    *("thirty-degree-rule", "throw-by-angle", "throw-by-spin"),  # many shots in one
    *("air-rolls", "air-paper", "air-slides"),
}


@pytest.mark.parametrize("name", [name for name in FORMS if not name.startswith("galperin")])
def test_a_shot_is_solved_by_its_shape_whatever_it_is_called(name: str) -> None:
    scene, form = solved(name)
    renamed = closed_form(scene.model_copy(update={"name": "mine"}))
    assert (renamed is None) == (name in SOLVED_BY_NAME_ALONE)
    if renamed is None:
        return
    assert renamed.event_sequence == form.event_sequence
    with mp.workdps(DIGITS):
        for ours, theirs in zip(renamed.rest_positions, form.rest_positions, strict=True):
            assert all(abs(a - b) <= 1e-30 for a, b in zip(ours, theirs, strict=True))
        assert abs(renamed.rest_time - form.rest_time) <= 1e-30
    assert renamed.conditioning == pytest.approx(form.conditioning, rel=1e-6)


def test_a_shot_that_is_not_of_collisions_of_two_alone_has_no_form() -> None:
    for name in ("three-ball-symmetric", "frozen-break", "break-7"):
        assert closed_form(find_scene(name).model_copy(update={"name": "mine"})) is None
