"""The numbers of a scene as multiprecision values, and their nudges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mpmath import mp, mpf

from ghostball.model import Scene

DIGITS = 50
"""Decimal digits of every closed form: a relative nudge of 1e-25 leaves 25 for the difference."""

Vector = tuple[mpf, mpf]
Spin = tuple[mpf, mpf, mpf]
Key = tuple[str, *tuple[int, ...]]
"""The name of a number, then ball and axis if it has them."""

Collision = tuple[str, int, int | str]
"""Kind label, first ball, second ball or name of the cushion: as in `run --format json`."""

_CLOTH_FIELDS = ("rolling_friction", "sliding_friction", "spinning_friction_rate")
"""Coefficients that a ball may override."""

_AIR_FIELDS = ("air_drag", "rolling_friction_quadratic")

_CUSHION_FIELDS = (
    "cushion_restitution",
    "cushion_restitution_loss",
    "cushion_tangential_restitution",
    "cushion_friction",
    "cushion_height",
    "cushion_frequency_ratio",
)


_BALL_FIELDS = (
    *("positions", "velocities", "heights", "rises", "spins", "rolls", "radii", "masses"),
    *("rolling_frictions", "sliding_frictions", "spin_decelerations"),
)
"""Fields of a setup with one value for each ball."""


class OrderError(Exception):
    """The scene's values don't lead to the collisions that a form states."""


@dataclass(frozen=True)
class Setup:
    """The values of one scene, exactly: a double is a binary fraction, which `mpf` can hold.

    `positions`, `velocities` [m] and [m/s].
    `heights`, `rises` [m] and [m/s]: heights of the balls' lowest points above the cloth, and their
    vertical velocities; 0 if no ball may leave the cloth.
    `spins` [rad/s]: angular velocities. For a rolling ball the first two are meaningless: its
        velocity gives them.
    `rolls`: which balls start rolling without slip.
    `radii`, `masses` [m] and [kg].
    `gravity` [m/s^2].
    `spin_decelerations` [rad/s^2].
    `air_drag`, `rolling_friction_quadratic` [1/m].
    `ball_friction`: None: Alciatore's curve.
    `cushion`: name of the law. For a mirror law, or without cushions, the loss [sqrt(s/m)] is 0 and
        the other coefficients are 1.
    `cushion_height` [m].
    `length`, `width` [m].
    `t_max` [s].
    `slides`: whether balls may slide; otherwise they always roll.
    `verify`: whether a form checks that no other collision comes before the stated one.
    """

    positions: tuple[Vector, ...]
    velocities: tuple[Vector, ...]
    heights: tuple[mpf, ...]
    rises: tuple[mpf, ...]
    table_restitution: mpf
    spins: tuple[Spin, ...]
    rolls: tuple[bool, ...]
    radii: tuple[mpf, ...]
    masses: tuple[mpf, ...]
    gravity: mpf
    rolling_frictions: tuple[mpf, ...]
    sliding_frictions: tuple[mpf, ...]
    spin_decelerations: tuple[mpf, ...]
    air_drag: mpf
    rolling_friction_quadratic: mpf
    ball_restitution: mpf
    ball_friction: mpf | None
    cushion: str
    cushion_restitution: mpf
    cushion_restitution_loss: mpf
    cushion_tangential_restitution: mpf
    cushion_friction: mpf
    cushion_height: mpf
    cushion_frequency_ratio: mpf
    length: mpf | None
    width: mpf | None
    cushions: tuple[str, ...]
    t_max: mpf | None
    slides: bool
    verify: bool

    def of(self, balls: slice) -> Setup:
        """Return the setup of some of the balls."""
        return replace(self, **{name: getattr(self, name)[balls] for name in _BALL_FIELDS})


@dataclass(frozen=True)
class FormResult:
    """The end of a scene by a form.

    `positions`, `velocities` [m] and [m/s].
    `time` [s].
    """

    positions: tuple[Vector, ...]
    velocities: tuple[Vector, ...]
    time: mpf
    collisions: tuple[Collision, ...]

    @classmethod
    def at_rest(
        cls, positions: Sequence[Vector], time: mpf, collisions: Sequence[Collision] = ()
    ) -> FormResult:
        """Return the result for a shot in which all balls come to rest."""
        zero = mp.mpf(0)
        return cls(tuple(positions), ((zero, zero),) * len(positions), time, tuple(collisions))


def numbers_of(scene: Scene) -> dict[Key, mpf]:
    """Return every number of the scene on which its result may depend, exactly.

    A number that several balls share is one number; a ball's own coefficient is a separate number.
    The horizontal spin of a rolling ball isn't a number, because its velocity determines it. Nor is
    `t_max`, which doesn't affect the motion.
    """
    physics, table = scene.physics, scene.table
    slides = physics.motion == "sliding"
    found: dict[Key, float] = {("gravity",): physics.gravity}
    for i, (ball, rolls) in enumerate(zip(scene.balls, scene.rolls.tolist(), strict=True)):
        found |= {("position", i, axis): ball.position[axis] for axis in (0, 1)}
        found |= {("velocity", i, axis): ball.velocity[axis] for axis in (0, 1)}
        found |= {("radius", i): ball.radius, ("mass", i): ball.mass}
        if slides and ball.angular_velocity is not None:
            axes = (2,) if rolls else (0, 1, 2)
            found |= {("spin", i, axis): ball.angular_velocity[axis] for axis in axes}
        if physics.airborne:
            found["velocity", i, 2] = ball.velocity[2]
            if ball.position[2] != ball.radius:
                found["position", i, 2] = ball.position[2]
        own = {name: getattr(ball, name) for name in _CLOTH_FIELDS}
        found |= {(name, i): value for name, value in own.items() if value is not None}
    found |= {(name,): getattr(physics, name) for name in _CLOTH_FIELDS + _AIR_FIELDS}
    if len(scene.balls) > 1:
        found["ball_restitution",] = physics.ball_restitution
        if physics.ball_friction != "alciatore":
            found["ball_friction",] = physics.ball_friction
    if physics.airborne:
        found["table_restitution",] = physics.table_restitution
    if table is not None:
        found |= {("length",): table.length, ("width",): table.width}
        found |= {(name,): getattr(physics, name) for name in _CUSHION_FIELDS}
        if physics.cushion_restitution_loss == 0.0:
            # a loss of 0 stands for another law, not for a rounded value
            del found["cushion_restitution_loss",]
    return {key: mp.mpf(value) for key, value in found.items()}


def setup_of(scene: Scene, numbers: Mapping[Key, mpf], *, verify: bool) -> Setup:
    """Return the setup of `scene` with its numbers replaced by `numbers`; see `numbers_of`."""
    zero, one = mp.mpf(0), mp.mpf(1)
    balls = range(len(scene.balls))
    # A mirror cushion conserves all energy, whatever its unused fields are.
    mirror = scene.physics.cushion == "mirror"

    def vectors(name: str) -> tuple[Vector, ...]:
        return tuple((numbers[name, i, 0], numbers[name, i, 1]) for i in balls)

    def spin(i: int) -> Spin:
        x, y, z = (numbers.get(("spin", i, axis), zero) for axis in range(3))
        return x, y, z

    def height(i: int) -> mpf:
        # If the scene gives no height, the height is the radius, even a nudged radius.
        return numbers.get(("position", i, 2), numbers["radius", i]) - numbers["radius", i]

    def of_the_cloth(name: str) -> tuple[mpf, ...]:
        return tuple(numbers.get((name, i), numbers[name,]) for i in balls)

    def of_cushions(name: str) -> mpf:
        return one if mirror else numbers.get((name,), one)

    return Setup(
        positions=vectors("position"),
        velocities=vectors("velocity"),
        heights=tuple(height(i) for i in balls),
        rises=tuple(numbers.get(("velocity", i, 2), zero) for i in balls),
        table_restitution=numbers.get(("table_restitution",), zero),
        spins=tuple(spin(i) for i in balls),
        rolls=tuple(scene.rolls.tolist()),
        radii=tuple(numbers["radius", i] for i in balls),
        masses=tuple(numbers["mass", i] for i in balls),
        gravity=numbers["gravity",],
        rolling_frictions=of_the_cloth("rolling_friction"),
        sliding_frictions=of_the_cloth("sliding_friction"),
        spin_decelerations=of_the_cloth("spinning_friction_rate"),
        air_drag=numbers["air_drag",],
        rolling_friction_quadratic=numbers["rolling_friction_quadratic",],
        ball_restitution=numbers.get(("ball_restitution",), one),
        ball_friction=numbers.get(("ball_friction",)),
        cushion=scene.physics.cushion,
        cushion_restitution=of_cushions("cushion_restitution"),
        cushion_restitution_loss=zero
        if mirror
        else numbers.get(("cushion_restitution_loss",), zero),
        cushion_tangential_restitution=of_cushions("cushion_tangential_restitution"),
        cushion_friction=of_cushions("cushion_friction"),
        cushion_height=of_cushions("cushion_height"),
        cushion_frequency_ratio=of_cushions("cushion_frequency_ratio"),
        length=numbers.get(("length",)),
        width=numbers.get(("width",)),
        cushions=() if scene.table is None else scene.table.cushions,
        t_max=None if scene.t_max is None else mp.mpf(scene.t_max),
        slides=scene.physics.motion == "sliding",
        verify=verify,
    )
