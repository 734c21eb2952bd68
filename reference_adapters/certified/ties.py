"""Simultaneous events: proof that they are simultaneous, their order, and whether they commute.

Intervals never prove that two times are equal. But two gaps that are the same function of time
close at the same time: the gaps of a ball on the symmetry axis of two other balls or of two jaws,
or on the bisector of a corner.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from ghostball.model import COLLISION_KINDS, EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import Vector, dot
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.reference_adapters.certified.gaps import PairGap
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacle_gaps import Gap, RoundGap, StraightGap
from ghostball.reference_adapters.certified.problem import ExactProblem


def are_at_once(first: Candidate, other: Candidate) -> bool:
    """Return True if two impacts, both known to happen, are proved to be simultaneous."""
    if not (first.choice.kind in COLLISION_KINDS and other.choice.kind in COLLISION_KINDS):
        return False
    if other.instant is first.instant:
        return True
    a, b = first.gap, other.gap
    if a is None or b is None or a.t is not b.t or a.curved or b.curved:
        return False
    if not _are_one_function(a, b, first, other):
        return False
    # The function is monotonic there, so both are the same root.
    return bool(a.slope(first.age.union(other.age)) < 0)


def _are_one_function(a: Gap, b: Gap, first: Candidate, other: Candidate) -> bool:
    if isinstance(a, StraightGap) and isinstance(b, StraightGap):
        distances, rates, pulls = zip(a.coefficients(), b.coefficients(), strict=True)
        return all(map(_are_one, (distances, rates))) and (
            _are_one(pulls) or _are_one((a.slowing, b.slowing))
        )
    pair = _pair_beside(first, other)
    if pair is None:
        return False
    body, (ax, ay), (bx, by) = pair
    # |a - p|^2 - |b - p|^2 = (a - b) . (a + b - 2 p) is 0, and stays 0 as p moves.
    beside = (ax + bx - 2 * body.x, ay + by - 2 * body.y)
    motion: tuple[Vector, ...] = (beside, (body.vx, body.vy), (body.ax, body.ay))
    return all(dot((ax - bx, ay - by), part).is_zero() for part in motion)


def _are_one(pair: tuple[arb, arb]) -> bool:
    return bool(pair[0].is_exact() and pair[1].is_exact() and pair[0] == pair[1])


def _pair_beside(first: Candidate, other: Candidate) -> tuple[Body, Vector, Vector] | None:
    """Return the ball of two impacts and the positions of the two equally near bodies; or None."""
    shared = set(first.bodies) & set(other.bodies)
    if len(shared) != 1:
        return None
    (body,) = shared
    a, b = (_place_beside(one, body) for one in (first, other))
    return None if a is None or b is None or not (a[1] - b[1]).is_zero() else (body, a[0], b[0])


def _place_beside(one: Candidate, body: Body) -> tuple[Vector, arb] | None:
    """Return the position and the distance of the body that a ball hits; None if it moves."""
    if isinstance(one.gap, RoundGap):
        return one.gap.piece.centre, one.gap.reach
    if not isinstance(one.gap, PairGap) or one.gap.free:
        return None
    (other,) = (its for its in one.bodies if its is not body)
    return ((other.x, other.y), one.gap.reach) if other.resting else None


def axis_of_mirror(first: Candidate, other: Candidate) -> int | None:
    """Return the axis along which two impacts are mirror images: 0 for x, 1 for y, or None.

    The ball moves straight, without side spin, between two equal bodies at rest. However the law
    divides the impulse between them, it doesn't move the ball along this axis.
    """
    pair = _pair_beside(first, other)
    if pair is None:
        return None
    body, a, b = pair
    partners = {its for one in (first, other) for its in one.bodies} - {body}
    masses = [its.constants.mass for its in partners]
    if any(its.phase is not Phase.RESTING or not its.wz.is_zero() for its in partners):
        return None
    if not all((mass - masses[0]).is_zero() for mass in masses):
        return None
    middle = ((a[0] + b[0]) / 2 - body.x, (a[1] + b[1]) / 2 - body.y)
    for axis in range(2):
        across = 1 - axis
        ways = (middle, (body.vx, body.vy), (body.ax, body.ay), (body.ux, body.uy))
        if (a[across] - b[across]).is_zero() and all(way[axis].is_zero() for way in ways):
            return axis if body.wz.is_zero() else None
    return None


def first_of_instant(tied: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return the simultaneous impacts that come first: those with cushions, or else all.

    By the model in `docs/physics.md`, an impact with a cushion comes before impacts of balls.
    """
    ranked = sorted(tied, key=lambda one: one.rank)
    bounces = [one for one in ranked if one.choice.kind is EventKind.BALL_CUSHION]
    if not bounces:
        return tuple(ranked)
    return tuple(one for one in bounces if one.choice.a == bounces[0].choice.a)


def sharing_balls(chosen: Sequence[Candidate]) -> list[list[Candidate]]:
    """Return impacts in groups; impacts of different groups share no ball."""
    groups: list[list[Candidate]] = []
    for one in chosen:
        apart = [group for group in groups if not _share(group, one)]
        joined = [its for group in groups if _share(group, one) for its in group]
        groups = [*apart, [*joined, one]]
    return groups


def _share(group: Sequence[Candidate], one: Candidate) -> bool:
    return any(not set(its.balls).isdisjoint(one.balls) for its in group)


def commute(problem: ExactProblem, first: Candidate, other: Candidate) -> bool:
    """Return True if two impacts of a ball have the same outcome in either order.

    True for two straight sides at right angles, without friction: each impact changes only the
    motion normal to its own side, or changes the motion by a factor independent of the other side.
    """
    a, b = first.gap, other.gap
    if not (isinstance(a, StraightGap) and isinstance(b, StraightGap)):
        return False
    if problem.airborne or problem.cushion not in ("mirror", "restitution"):
        return False
    if problem.cushion_loss > 0.0 and problem.cushion_tangential != 1.0:
        return False  # the restitution of a side would depend on the outcome at the other
    return bool(dot(a.piece.inward, b.piece.inward).is_zero())
