"""Closed forms of balls that touch: two collide at once, and balls stay in contact for a while.

Mirror symmetry, or motion along one line, settles what pairwise formulas leave open.
"""

from __future__ import annotations

from mpmath import mp

from ghostball.validation.truth.closed_forms._motion import State, cloth_of, path_of, time_to_rest
from ghostball.validation.truth.closed_forms._setup import OrderError, Outcome, Setup


def collision_with_two(setup: Setup) -> Outcome:
    """Let ball 0 roll along +x and hit balls 1 and 2 at once, mirror images in its path.

    With c the cosine between the path and a line of centres, each object ball leaves along its line
    at (1 + e) c v / (1 + 2 c^2), and the cue ball keeps v less 2 c times that. Where the object
    balls touch each other, c^2 = 3/4: (sqrt(3)/5)(1 + e) v, and (2 - 3 e) v / 5.

    Nudging one object ball alone would part the two impacts. Symmetry is what the scene is about,
    so ball 2 follows ball 1, and its own numbers are no part of the conditioning.
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
        path = path_of(State(position, after, setup.spins[ball], rolls=True), cloth)
        ends.append(path[-1].state.position)
        times.append(time_to_rest(path, cloth))
    mirrored = (ends[1][0], 2 * cue[1] - ends[1][1])
    return Outcome.at_rest(
        (*ends, mirrored),
        2 * distance / (velocity[0] + speed) + max(times),
        (("ball-ball", 0, 1), ("ball-ball", 0, 2)),
    )


def pushed_along(setup: Setup) -> Outcome:
    """Let a ball with topspin, at rest, push the ball in front of it along +x.

    Its friction mu_s m1 g moves both as long as it slides, and the ball in front, which rolls,
    answers with (7/5) m2 and its own resistance:

        lambda = (7/5) m2 (a + mu_r g),  m1 a = mu_s m1 g - lambda
        =>  a = (5 mu_s m1 - 7 mu_r m2) g / (5 m1 + 7 m2)

    The slide ends where a t = R w0 - (5/2) mu_s g t. From there both roll at one speed and slow at
    one rate: they touch, and push no more, until they rest. There is no impact.
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
    return Outcome.at_rest(
        ((back[0] + travelled, back[1]), (front[0] + travelled, front[1])), gripping + speed / roll
    )


def wedged(setup: Setup) -> Outcome:
    """Let a ball with topspin push the ball in front of it against the left cushion.

    Nothing can move: cushion and ball answer the friction mu_s m g until it has used up the spin,
    which takes R w / ((5/2) mu_s g).
    """
    spin = setup.spins[0][1]
    if setup.verify:
        _make_sure_touching(setup)
        if setup.positions[1][0] != setup.radii[1] or "left" not in setup.cushions:
            raise OrderError("the second ball must lie on the left cushion")
        if not spin < 0:
            raise OrderError("the first ball must have topspin towards the cushion")
    return Outcome.at_rest(
        setup.positions, setup.radii[0] * abs(spin) / (5 * cloth_of(setup, 0).sliding / 2)
    )


def _make_sure_symmetric(setup: Setup) -> None:
    (cue, *targets), (velocity, *others) = setup.positions, setup.velocities
    if setup.slides or setup.cushions or len(targets) != 2:
        raise OrderError("needs three balls that roll on an unbounded cloth")
    if velocity[1] != 0 or velocity[0] <= 0 or any(v != 0 for w in others for v in w):
        raise OrderError("the first ball must come along +x, at two that rest")
    if targets[0][0] != targets[1][0] or targets[0][1] + targets[1][1] != 2 * cue[1]:
        raise OrderError("the balls that it hits must be mirror images in its path")
    if len(set(setup.masses)) > 1 or len(set(setup.radii)) > 1:
        raise OrderError("the balls must be equal")
    if len(set(setup.rolling_frictions)) > 1:
        raise OrderError("the balls must roll alike")


def _make_sure_touching(setup: Setup) -> None:
    """Make sure that two balls on one cloth rest on a line along x, and touch up to a rounding."""
    if len(setup.positions) != 2 or not setup.slides:
        raise OrderError("needs two balls that may slide")
    (a, b), reach = setup.positions, setup.radii[0] + setup.radii[1]
    touching = abs(abs(b[0] - a[0]) - reach) <= mp.mpf(2) ** -52 * max(abs(a[0]), abs(b[0]))
    if not touching or a[1] != b[1]:
        raise OrderError("the balls must touch on a line along x")
    if any(part != 0 for velocity in setup.velocities for part in velocity):
        raise OrderError("the balls must be at rest")
    if any(setup.spins[0][::2]) or any(setup.spins[1]):
        raise OrderError("the first ball must spin about y, and nothing else spin")
    if any(len(set(of)) > 1 for of in (setup.rolling_frictions, setup.sliding_frictions)):
        raise OrderError("the cloth must slow both balls alike")
