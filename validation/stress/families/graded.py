"""Graded: shots of all physics that can be proved, and how a run of each compares with its proof.

And what no proof covers since an engine chooses it: impacts of one ball with two at one instant,
which have closed forms, in either order or together.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from engine import Ball, Physics, Result, Scene, Table
from reference_adapters import ReferenceEngine
from reference_adapters.certified import CertifiedSettings, certify
from validation.closed_forms import closed_form
from validation.faults import faults_of
from validation.grading import grade
from validation.library import find_scene
from validation.random_shots import random_shot
from validation.stress.family import Family
from validation.stress.sound import Sound
from validation.stress.trial import SceneTrial, Suite, Trial, Verdict, play

PROOF = CertifiedSettings(max_events=5_000)
"""How far a shot is proved: a few elastic ones have thousands of events."""

SHIPPED = (
    "stop",
    "head-on",
    "half-ball-cut",
    "three-ball-chain",
    "wall-bounce",
    "restitution-cut",
    "unequal-balls",
    "corner-double-bounce",
    "corner-exact",
    "cradle",
    "galperin-1",
    "three-ball-symmetric",
    "sliding-swerve",
    "draw-shot",
    "masse",
    "english-check",
    "han-running",
    "throw-slip",
    "throw-stick",
    "throw-alciatore",
    "gearing",
    "frozen-to-cushion",
    "frozen-triangle",
    "break-7",
    "chaos-a",
    "pool-break-9",
)
"""The shipped scenes that are graded here: each law and way of moving, from one ball to breaks."""

BATCH = 10
"""Random shots in a trial."""

QUICK_SHOTS, FULL_SHOTS = 100, 4_000

CALM = range(10, 90)
"""Random shots none of which has thousands of steps of sustained contact: quick, interpreted too.

Of the first hundred, shots 1 and 97 do have them.
"""

_HARDEST = 32.0
"""Quality factor at which our engine breaks; see `scenes/common.expect.toml`."""


@dataclass(frozen=True)
class Proved:
    """Whether a run keeps the limits of every shipped scene, graded against the proof of its shot.

    No event missing, none invented, and positions within 32 roundings of the state per event.

    Attributes
    ----------
    cached : bool
        Whether the proof is kept on the disk.
    """

    cached: bool = True

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded with its trajectory."""
        scene = result.scene
        grade_of = grade(result, certify(scene, PROOF, motion=True, cached=self.cached))
        quality = grade_of.quality_factor
        values = {"quality_factor": quality, "events": grade_of.events, "extent": grade_of.extent}
        near = min((quality or 0.0) / _HARDEST, 0.999)
        return Verdict.of(scene, faults_of(grade_of, scene), near, values)


@dataclass(frozen=True)
class ProvedShot(SceneTrial):
    """A shot of a name, graded against its proof."""

    limit: ClassVar[float] = 300.0  # the first one compiles the tangent map


@dataclass(frozen=True)
class ProvedShots(Trial):
    """Random shots from one number on, each graded against its proof.

    Attributes
    ----------
    name : str
    first, count : int
        See `random_shot`.
    """

    name: str
    first: int
    count: int
    small: ClassVar[bool] = False
    limit: ClassVar[float] = 300.0
    cached: ClassVar[bool] = False  # there are more than are kept

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play and judge them; the verdict shows the shot that came off worst."""
        verdicts = [self._judge(engine, random_shot(n)) for n in self._numbers()]
        worst = max(verdicts, key=lambda verdict: (verdict.broken, verdict.severity))
        faults = [
            f"{verdict.scene.name}: {fault}"
            for verdict in verdicts
            for fault in verdict.faults
            if verdict.scene is not None
        ]
        broken = sum(verdict.broken for verdict in verdicts)
        values = dict(worst.values)
        return Verdict(tuple(faults), worst.scene, worst.severity, len(verdicts), broken, values)

    def examples(self) -> Iterable[Scene]:
        """Yield the shots."""
        return map(random_shot, self._numbers())

    def _numbers(self) -> range:
        return range(self.first, self.first + self.count)

    def _judge(self, engine: ReferenceEngine, scene: Scene) -> Verdict:
        result = play(engine, scene)
        return result if isinstance(result, Verdict) else Proved(self.cached)(result)


@dataclass(frozen=True)
class CalmShots(ProvedShots):
    """The same, where all of them are in `CALM`."""

    small: ClassVar[bool] = True
    cached: ClassVar[bool] = True


def crowd(name: str, physics: Physics, number: int) -> Scene:
    """Return a fifth of a second of 110 balls, so many that only neighbours are looked at.

    In rows, but for chance; every tenth or so moves.
    """
    chance = random.Random(f"ghostball crowd {number}")
    balls = []
    for k in range(110):
        place = tuple(0.09 * row + 0.08 + chance.uniform(-0.015, 0.015) for row in divmod(k, 10))
        moves = k % 11 == 3
        velocity = (chance.uniform(-2.0, 2.0), chance.uniform(-2.0, 2.0)) if moves else (0.0, 0.0)
        balls.append(Ball(id=f"b{k}", position=place, velocity=velocity))
    table = Table(length=1.06, width=0.97)
    return Scene(name=name, table=table, physics=physics, balls=balls, t_max=0.2)


_TURNED_BACK = 1e-14
"""What rounding may do to a velocity over one instant's impacts, in units of the speed."""


@dataclass(frozen=True)
class Velocities:
    """Whether the balls leave with the velocities that a closed form gives.

    Attributes
    ----------
    velocities : tuple of (float, float) [m/s]
        Of each ball.
    speed : float [m/s]
        What errors are measured in.
    """

    velocities: tuple[tuple[float, float], ...]
    speed: float = 1.0

    def __call__(self, result: Result) -> Verdict:
        """Judge a run by its end."""
        found = result.final_state.velocities[0, :, :2].tolist()
        errors = [
            math.dist(here, there) / self.speed
            for here, there in zip(found, self.velocities, strict=True)
        ]
        faults = [
            f'ball "{ball.id}" leaves at ({here[0]:.6g}, {here[1]:.6g}) m/s instead of '
            f"({there[0]:.6g}, {there[1]:.6g}) m/s"
            for ball, here, there, error in zip(
                result.scene.balls, found, self.velocities, errors, strict=True
            )
            if error > _TURNED_BACK
        ]
        worst = max(errors)
        near = min(worst / _TURNED_BACK, 0.999)
        return Verdict.of(result.scene, faults, near, {"velocity_error": worst})


class End(NamedTuple):
    """How a shot ends: places [m], the instant [s], collisions by kind."""

    places: tuple[tuple[float, float], ...]
    time: float
    collisions: dict[str, int]


def shipped_end(scene: Scene) -> End:
    """Return how a shipped scene that has a closed form ends."""
    form = closed_form(scene)
    assert form is not None
    places = tuple((float(x), float(y)) for x, y in form.rest_positions)
    return End(places, float(form.rest_time), form.collision_counts)


def parting() -> Scene:
    """Return the shot of a ball that pushes another until it rolls, and then is slowed more.

    So a contact that was pressed opens.
    """
    scene = find_scene("push")
    rear, front = scene.balls
    braked = rear.model_copy(update={"rolling_friction": 0.04})
    return scene.model_copy(update={"name": "parting", "title": "", "balls": (braked, front)})


def parted_end(scene: Scene) -> End:
    """Return how `parting` ends.

    While the rear ball slides, both go with (5 mu_s - 7 mu_f) g / 12, mu_f the rolling friction of
    the front ball, as in the shipped scene `push`; the slide ends where a t = R w - (5/2) mu_s g t.
    From there each rolls out alone.
    """
    g, slide = scene.physics.gravity, float(scene.sliding_frictions[0])
    of_rear, of_front = scene.rolling_frictions.tolist()
    rear, front = scene.balls
    together = (5.0 * slide - 7.0 * of_front) * g / 12.0
    gripping = rear.radius * float(scene.angular_velocities[0, 1]) / (together + 2.5 * slide * g)
    speed = together * gripping
    pushed = 0.5 * speed * gripping
    rolled = [speed * speed / (2.0 * friction * g) for friction in (of_rear, of_front)]
    places = tuple(
        (ball.position[0] + pushed + way, ball.position[1])
        for ball, way in zip((rear, front), rolled, strict=True)
    )
    return End(places, gripping + speed / (of_front * g), {"ball-ball": 0, "ball-cushion": 0})


@dataclass(frozen=True)
class ClosedEnd:
    """Whether a shot ends where and when its closed form says, after as many collisions.

    Attributes
    ----------
    truth : callable
        Given the scene, returns its end.
    distance : float [m]
    duration : float [s]
        How far off the end may be: what its scene's own criteria say, and why.
    """

    truth: Callable[[Scene], End]
    distance: float
    duration: float

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        scene = result.scene
        places, time, collisions = self.truth(scene)
        off = max(
            math.dist(here, there)
            for here, there in zip(result.rest_positions[:, :2].tolist(), places, strict=True)
        )
        late = abs(result.rest_time - time)
        faults = []
        if not off <= self.distance:
            faults.append(f"a ball ends {off:.3g} m off, at most {self.distance:g} m")
        if not late <= self.duration:
            faults.append(f"the end is {late:.3g} s off, at most {self.duration:g} s")
        if dict(result.collision_counts) != collisions:
            faults.append(f"{dict(result.collision_counts)} collisions instead of {collisions}")
        near = min(max(off / self.distance, late / self.duration), 0.999)
        return Verdict.of(scene, faults, near, {"rest_error": off, "rest_time_error": late})


CLOSED_ENDS = {
    "corner-exact": ClosedEnd(shipped_end, 1e-14, 1e-14),
    "frozen-to-cushion": ClosedEnd(shipped_end, 1e-14, 1e-14),
    "push": ClosedEnd(shipped_end, 1e-6, 5e-6),
    "wedged": ClosedEnd(shipped_end, 1e-12, 1e-5),
}
"""Where a proof ends too early: at two collisions of one instant, or where contact is sustained."""

PARTED = ClosedEnd(parted_end, 1e-5, 5e-6)
"""Of `parting`: our engine ends a slip at once that the cloth would end within `STOP_WAY`.

That is one of up to sqrt(2 mu_s g 2e-10 m) = 3e-5 m/s, of which 2/7 come off the rear ball alone
instead of off both: 8e-6 m/s, worth v dv / (mu_r g) = 8 um in its roll out.
"""

PRESSED = Sound(most_events=50, most_steps=500)
"""Of `push-line`: no closed form, but nothing may overlap and no energy come in."""

Normal = tuple[float, float]

_TIES: dict[str, tuple[Normal, Normal]] = {
    "uneven": ((24.0 / 25.0, 7.0 / 25.0), (3.0 / 5.0, -4.0 / 5.0)),
    "symmetric": ((4.0 / 5.0, 3.0 / 5.0), (4.0 / 5.0, -3.0 / 5.0)),
}
"""Directions in which a ball that moves along x touches two others, which don't touch each other.

So that all places are exact: whole numbers of 25ths of the distance.
"""

_UNIT = 2.0**-9
"""A 25th of the distance [m]."""


def _tie(name: str, normals: tuple[Normal, Normal], restitution: float, impacts: str) -> Trial:
    """Return the trial of a ball that hits two at the very beginning of a shot.

    Sequential impacts come in the order of their speeds, and, of equal ones, of their places. The
    first impact gives its ball (1 + e) / 2 of the speed of approach; after both, the cue ball may
    approach the first one again. Simultaneous ones are (1 + e) times the impulses that just end
    both approaches: 2 p + c q = a, c p + 2 q = b, with c the cosine between the normals.
    """
    first, second = normals
    cue, others = [1.0, 0.0], [[0.0, 0.0], [0.0, 0.0]]
    if impacts == "sequential":
        order = (0, 1) if first[0] >= second[0] else (1, 0)
        _hit(cue, others, normals, order, restitution)
    else:
        c = first[0] * second[0] + first[1] * second[1]
        p = (2.0 * first[0] - c * second[0]) / (4.0 - c * c)
        q = (2.0 * second[0] - c * first[0]) / (4.0 - c * c)
        for other, ends, (nx, ny) in zip(others, (p, q), normals, strict=True):
            push = (1.0 + restitution) * ends
            other[0], other[1] = push * nx, push * ny
            cue[0] -= push * nx
            cue[1] -= push * ny
    reach = 25.0 * _UNIT
    places = [(0.0, 0.0), *((_UNIT * round(25 * nx), _UNIT * round(25 * ny)) for nx, ny in normals)]
    velocities = ((1.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    scene = Scene(
        name=name,
        physics=Physics(rolling_friction=0.0, ball_restitution=restitution, impacts=impacts),
        t_max=0.01,
        balls=[
            Ball(id=word, position=place, velocity=velocity, radius=0.5 * reach)
            for word, place, velocity in zip(
                ("cue", "first", "second"), places, velocities, strict=True
            )
        ],
    )
    expected = tuple((vx, vy) for vx, vy in (cue, *others))
    return SceneTrial(name, scene, Velocities(expected))


def _hit(
    cue: list[float],
    others: list[list[float]],
    normals: tuple[Normal, Normal],
    order: tuple[int, int],
    restitution: float,
) -> None:
    """Let the cue ball hit both in turn, until it approaches neither."""
    for k in order * 20:
        (nx, ny), other = normals[k], others[k]
        approach = nx * (cue[0] - other[0]) + ny * (cue[1] - other[1])
        if approach > _TURNED_BACK:
            push = 0.5 * (1.0 + restitution) * approach
            cue[0] -= push * nx
            cue[1] -= push * ny
            other[0] += push * nx
            other[1] += push * ny


def _ties(suite: Suite) -> Iterator[Trial]:
    for restitution in (1.0, 0.5) if suite == "quick" else (1.0, 0.95, 0.8, 0.5, 0.2):
        for impacts in ("sequential", "simultaneous"):
            for kind, normals in _TIES.items():
                yield _tie(f"tie-{kind}-{impacts}-{restitution:g}", normals, restitution, impacts)


def _odd_shots() -> Iterator[Scene]:
    """Yield shots in which the cloth does what it seldom does."""
    table = Table(length=2.54, width=1.27)
    thrown_back = Ball(
        id="cue", position=(0.06, 0.3), velocity=(0.3, 0.05), angular_velocity=(0.0, -250.0, 0.0)
    )
    # With so much backspin that it comes back, still sliding, to the cushion that it left.
    yield Scene(
        name="thrown-back",
        table=table,
        physics=Physics(motion="sliding", sliding_friction=0.2),
        balls=[thrown_back],
    )
    # A ball whose spin the cloth still changes rubs against another one.
    yield Scene(
        name="hit-while-sliding",
        physics=Physics(preset="pool"),
        balls=[
            Ball(
                id="cue",
                position=(0.6, 0.4),
                velocity=(1.2, 0.9),
                angular_velocity=(60.0, -40.0, 30.0),
            ),
            Ball(id="1", position=(0.86, 0.6)),
        ],
    )


def _trials(suite: Suite) -> Iterator[Trial]:
    for name in SHIPPED:
        yield ProvedShot(name, find_scene(name), Proved())
    for name, judge in CLOSED_ENDS.items():
        yield SceneTrial(f"{name}-end", find_scene(name), judge)
    yield SceneTrial("parting-end", parting(), PARTED)
    yield SceneTrial("push-line-sound", find_scene("push-line"), PRESSED)
    for scene in _odd_shots():
        yield ProvedShot(scene.name, scene, Proved())
    yield from _ties(suite)
    for kind, physics in (
        ("elastic", Physics(rolling_friction=0.0)),
        ("sliding", Physics(preset="pool")),
    ):
        for number in range(1 if suite == "quick" else 10):
            name = f"crowd-{kind}-{number}"
            yield ProvedShot(name, crowd(name, physics, number), Proved())
    for first in range(0, QUICK_SHOTS if suite == "quick" else FULL_SHOTS, BATCH):
        calm = first in CALM and first + BATCH - 1 in CALM
        batch = CalmShots if calm else ProvedShots
        yield batch(f"shots-{first:04d}+{BATCH}", first, BATCH)


FAMILY = Family(
    "graded",
    "Shots against their proofs",
    "Every event that interval arithmetic proves happens, in that order, no other does, and the "
    "balls end within 32 roundings of the state per event; as far as the proof goes, and the shot "
    "can be predicted in double precision. Impacts at one instant come out as the scene says: "
    "together, or the fastest first.",
    _trials,
    ours_alone=True,
)
