"""Closed forms for touching balls: a collision with two balls, and balls in resting contact.

Mirror symmetry, or motion along one line, replaces pairwise formulas where these aren't unique.
"""

from __future__ import annotations

from mpmath import mp

from ghostball.validation.truth.closed_forms._motion import (
    BallState,
    cloth_of,
    path_of,
    time_to_rest,
)
from ghostball.validation.truth.closed_forms._setup import FormResult, OrderError, Setup


def collision_with_two(setup: Setup) -> FormResult:
    """Solve ball 0, rolling along +x, that hits balls 1 and 2 at once, which mirror each other.

    With c the cosine between the path and a line of centres, each object ball leaves along its line
    at (1 + e) c v / (1 + 2 c^2), and the velocity of the cue ball decreases by 2 c times this
    speed. If the object balls touch each other, c^2 = 3/4: (sqrt(3)/5)(1 + e) v, and (2 - 3 e) v /
    5.

    Nudging one object ball alone would separate the two impacts. The scene is about symmetry, so
    ball 2 mirrors ball 1, and its own numbers don't count for the conditioning.
    """
    (cue, target, _), (velocity, _, _) = setup.positions, setup.velocities
    if setup.verify:
        _make_sure_symmetric(setup)
    reach = setup.radii[0] + setup.radii[1]
    aside = target[1] - cue[1]
    cosine = mp.sqrt(reach**2 - aside**2) / reach
    zero, deceleration = mp.mpf(0), cloth_of(setup, 0).rolling
    distance = target[0] - reach * cosine - cue[0]
    speed = mp.sqrt(velocity[0] ** 2 - 2 * deceleration * distance)
    push = (1 + setup.ball_restitution) * cosine * speed / (1 + 2 * cosine**2)
    starts = (
        ((cue[0] + distance, cue[1]), (speed - 2 * cosine * push, zero)),
        (target, (cosine * push, aside / reach * push)),
    )
    ends, times = [], []
    for ball, (position, after) in enumerate(starts):
        cloth = cloth_of(setup, ball)
        path = path_of(BallState(position, after, setup.spins[ball], rolls=True), cloth)
        ends.append(path[-1].state.position)
        times.append(time_to_rest(path, cloth))
    mirrored = (ends[1][0], 2 * cue[1] - ends[1][1])
    return FormResult.at_rest(
        (*ends, mirrored),
        2 * distance / (velocity[0] + speed) + max(times),
        (("ball-ball", 0, 1), ("ball-ball", 0, 2)),
    )


def pushed_along(setup: Setup) -> FormResult:
    """Solve a ball with topspin, at rest, that pushes the ball in front of it along +x.

    Its friction mu_s m1 g accelerates both while it slides. The ball in front rolls; its inertia is
    (7/5) m2, and it has its own rolling resistance:

        lambda = (7/5) m2 (a + mu_r g),  m1 a = mu_s m1 g - lambda
        =>  a = (5 mu_s m1 - 7 mu_r m2) g / (5 m1 + 7 m2)

    The slide ends at a t = R w0 - (5/2) mu_s g t. Then both roll at the same speed with the same
    deceleration: they touch without a force until they rest. There is no impact.
    """
    (back, front), (spin, _), (radius, _) = setup.positions, setup.spins, setup.radii
    mass, pushed = setup.masses
    if setup.verify:
        _make_sure_touching(setup)
        if not spin[1] > 0:
            raise OrderError("the first ball must have topspin towards the second")
    slide, roll = cloth_of(setup, 0).sliding, cloth_of(setup, 0).rolling
    together = (5 * slide * mass - 7 * roll * pushed) / (5 * mass + 7 * pushed)
    if not together > 0:
        raise OrderError("the push must be stronger than rolling resistance")
    gripping = radius * spin[1] / (together + 5 * slide / 2)
    speed = together * gripping
    travelled = together * gripping**2 / 2 + speed**2 / (2 * roll)
    return FormResult.at_rest(
        ((back[0] + travelled, back[1]), (front[0] + travelled, front[1])), gripping + speed / roll
    )


def wedged(setup: Setup) -> FormResult:
    """Solve a ball with topspin that pushes the ball in front of it against the left cushion.

    Nothing can move: the cushion and the ball balance the friction mu_s m g until it has ended the
    spin, after R w / ((5/2) mu_s g).
    """
    spin = setup.spins[0][1]
    if setup.verify:
        _make_sure_touching(setup)
        if setup.positions[1][0] != setup.radii[1] or "left" not in setup.cushions:
            raise OrderError("the second ball must lie on the left cushion")
        if not spin < 0:
            raise OrderError("the first ball must have topspin towards the cushion")
    return FormResult.at_rest(
        setup.positions, setup.radii[0] * abs(spin) / (5 * cloth_of(setup, 0).sliding / 2)
    )


def _make_sure_symmetric(setup: Setup) -> None:
    (cue, *targets), (velocity, *others) = setup.positions, setup.velocities
    if setup.slides or setup.cushions or len(targets) != 2:
        raise OrderError("needs three balls that roll on an unbounded cloth")
    if velocity[1] != 0 or velocity[0] <= 0 or any(v != 0 for w in others for v in w):
        raise OrderError("the first ball must move along +x, and two balls must rest")
    if targets[0][0] != targets[1][0] or targets[0][1] + targets[1][1] != 2 * cue[1]:
        raise OrderError("the other balls must be mirror images in the path of the first")
    if len(set(setup.masses)) > 1 or len(set(setup.radii)) > 1:
        raise OrderError("the balls must be equal")
    if len(set(setup.rolling_frictions)) > 1:
        raise OrderError("the balls must have the same rolling friction")


def _make_sure_touching(setup: Setup) -> None:
    """Check that two balls on one cloth rest on a line along x, and touch up to a rounding."""
    if len(setup.positions) != 2 or not setup.slides:
        raise OrderError("needs two balls that may slide")
    (a, b), reach = setup.positions, setup.radii[0] + setup.radii[1]
    touching = abs(abs(b[0] - a[0]) - reach) <= mp.mpf(2) ** -52 * max(abs(a[0]), abs(b[0]))
    if not touching or a[1] != b[1]:
        raise OrderError("the balls must touch on a line along x")
    if any(part != 0 for velocity in setup.velocities for part in velocity):
        raise OrderError("the balls must be at rest")
    if any(setup.spins[0][::2]) or any(setup.spins[1]):
        raise OrderError("only the first ball may spin, and only about y")
    if any(len(set(of)) > 1 for of in (setup.rolling_frictions, setup.sliding_frictions)):
        raise OrderError("the balls must have the same friction with the cloth")
