"""The numbers of a scene as multiprecision values, and how each of them may be nudged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mpmath import mp, mpf

from engine import Scene

DIGITS = 50
"""Decimal digits of every closed form: a relative nudge of 1e-25 leaves 25 for the difference."""

Vector = tuple[mpf, mpf]
Collision = tuple[str, int, int | str]
"""Kind label, first ball, second ball or name of the cushion: as in `simulate --json`."""


class OrderError(Exception):
    """The collisions that a form states aren't those that the scene's values lead to."""


@dataclass(frozen=True)
class Setup:
    """The values of one scene, exactly: a double is a binary fraction, and `mpf` holds it.

    Attributes
    ----------
    positions, velocities : tuple of (mpf, mpf) [m], [m/s]
    spins : tuple of (mpf, mpf) [rad/s]
        Horizontal angular velocities; used only where the balls slide.
    radii, masses : tuple of mpf [m], [kg]
    gravity, rolling_friction, sliding_friction : mpf
    ball_restitution, cushion_restitution, cushion_tangential_restitution : mpf
    length, width : mpf [m], or None on an unbounded cloth
    cushions : tuple of str
    t_max : mpf or None [s]
    verify : bool
        Whether a form checks that no other collision comes before the stated one.
    """

    positions: tuple[Vector, ...]
    velocities: tuple[Vector, ...]
    spins: tuple[Vector, ...]
    radii: tuple[mpf, ...]
    masses: tuple[mpf, ...]
    gravity: mpf
    rolling_friction: mpf
    sliding_friction: mpf
    ball_restitution: mpf
    cushion_restitution: mpf
    cushion_tangential_restitution: mpf
    length: mpf | None
    width: mpf | None
    cushions: tuple[str, ...]
    t_max: mpf | None
    verify: bool

    @property
    def deceleration(self) -> mpf:
        """Deceleration of a rolling ball, mu g [m/s^2]."""
        return self.rolling_friction * self.gravity


@dataclass(frozen=True)
class Outcome:
    """How a form says that the scene ends.

    Attributes
    ----------
    positions, velocities : tuple of (mpf, mpf) [m], [m/s]
    time : mpf [s]
    collisions : tuple of Collision, in order of time
    """

    positions: tuple[Vector, ...]
    velocities: tuple[Vector, ...]
    time: mpf
    collisions: tuple[Collision, ...]


def inputs_of(scene: Scene) -> list[float]:
    """Return every number that the outcome may depend on, in the order that `setup_of` reads."""
    physics, table = scene.physics, scene.table
    return [
        *scene.positions[:, :2].ravel().tolist(),
        *scene.velocities[:, :2].ravel().tolist(),
        *scene.angular_velocities[:, :2].ravel().tolist(),
        *scene.radii.tolist(),
        *scene.masses.tolist(),
        physics.gravity,
        physics.rolling_friction,
        physics.sliding_friction,
        physics.ball_restitution,
        physics.cushion_restitution,
        physics.cushion_tangential_restitution,
        *([] if table is None else [table.length, table.width]),
    ]


def setup_of(scene: Scene, inputs: Sequence[mpf], *, verify: bool) -> Setup:
    """Return the setup of `scene` with its numbers replaced by `inputs`.

    `t_max` is no input: it says when to look, not how the balls move.
    """
    n = len(scene.balls)
    values = iter(inputs)

    def vectors() -> tuple[Vector, ...]:
        return tuple((next(values), next(values)) for _ in range(n))

    positions, velocities, spins = vectors(), vectors(), vectors()
    radii = tuple(next(values) for _ in range(n))
    masses = tuple(next(values) for _ in range(n))
    gravity, rolling, sliding, ball_e, cushion_e, cushion_t = (next(values) for _ in range(6))
    bounded = scene.table is not None
    return Setup(
        positions,
        velocities,
        spins,
        radii,
        masses,
        gravity,
        rolling,
        sliding,
        ball_e,
        cushion_e,
        cushion_t,
        length=next(values) if bounded else None,
        width=next(values) if bounded else None,
        cushions=() if scene.table is None else scene.table.cushions,
        t_max=None if scene.t_max is None else mp.mpf(scene.t_max),
        verify=verify,
    )
