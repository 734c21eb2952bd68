"""A shot that follows a given order of collisions, each step by formula, in `mpf`."""

from __future__ import annotations

from itertools import combinations, pairwise

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._impacts import NORMALS, ball_impact, cushion_impact
from ghostball.validation.truth.closed_forms._motion import (
    PathSegment,
    along,
    cloth_of,
    dot,
    moved,
    path_of,
    starting_state,
    state_at,
    time_to_rest,
)
from ghostball.validation.truth.closed_forms._polynomials import Polynomial, first_fall_below_zero
from ghostball.validation.truth.closed_forms._setup import (
    Collision,
    FormResult,
    OrderError,
    Setup,
    Vector,
)

TOUCHING_OVERLAP = mp.mpf(2) ** -46
"""Overlap of touching balls that is allowed, in radii, because positions are given in doubles.

Such balls touch as soon as they approach.
"""

LEAST_DIFFERENCE = mp.mpf(10) ** -30
"""Collisions closer in time than this [s] count as simultaneous."""


class OrderedShot:
    """Balls that slide, roll and spin, moved from one given collision to the next.

    With `setup.verify`, each step checks that nothing else happens first, and otherwise raises
    `OrderError`: then the given order isn't that of these values.

    `time` [s]: reached so far.
    `collisions`: so far.
    `hull` [m]: points with a convex hull that contains the paths of all centres so far; only with
        `setup.verify`.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.time = mp.mpf(0)
        self.collisions: list[Collision] = []
        self.hull: list[Vector] = []
        balls = range(len(setup.positions))
        self._cloths = [cloth_of(setup, i) for i in balls]
        self._states = [starting_state(setup, i) for i in balls]
        self._paths = [path_of(self._states[i], self._cloths[i]) for i in balls]

    def play(self, collision: Collision) -> None:
        """Move the balls to a collision, and apply the scene's law."""
        kind, ball, other = collision
        if kind == "ball-ball":
            a, b = ball, int(other)
            self._advance(self._time_of_contact(a, b), collision)
            states = self._states[a], self._states[b]
            self._states[a], self._states[b] = ball_impact(self.setup, a, b, *states)
            self._replan(a, b)
        else:
            cushion = str(other)
            self._advance(self._time_of_bounce(ball, cushion), collision)
            self._states[ball] = cushion_impact(self.setup, ball, cushion, self._states[ball])
            self._replan(ball)

    def next_collision(self) -> Collision | None:
        """Return the next collision, or None if the shot ends before any.

        Raises `OrderError` if the collision comes immediately, or together with another one: a form
        needs collisions between two bodies.
        """
        found = [(when, one) for one, when in self._possible() if when is not None]
        found = [(when, one) for when, one in found if when < self._time_left()]
        if not found:
            return None
        found.sort(key=lambda pair: pair[0])
        instants = [mp.mpf(0), *(when for when, _ in found[:2])]
        if any(b - a <= LEAST_DIFFERENCE for a, b in pairwise(instants)):
            raise OrderError(f"{found[0][1]} comes immediately, or together with another collision")
        return found[0][1]

    def end(self) -> FormResult:
        """Move until every ball rests and none spins, or to `t_max`."""
        self._advance(self._time_left(), None)
        return FormResult(
            tuple(state.position for state in self._states),
            tuple(state.velocity for state in self._states),
            self.time,
            tuple(self.collisions),
        )

    def _time_left(self) -> mpf:
        """Return the time until every ball rests and none spins, or until `t_max`."""
        stops = (time_to_rest(p, c) for p, c in zip(self._paths, self._cloths, strict=True))
        dt = max(stops)
        return dt if self.setup.t_max is None else min(dt, self.setup.t_max - self.time)

    def _replan(self, *balls: int) -> None:
        for i in balls:
            self._paths[i] = path_of(self._states[i], self._cloths[i])

    def _advance(self, dt: mpf | None, collision: Collision | None) -> None:
        if dt is None:
            raise OrderError(f"{collision} never happens")
        if self.setup.verify:
            self._make_sure_nothing_precedes(dt, collision)
            self._note_hull(dt)
        for i, (path, cloth) in enumerate(zip(self._paths, self._cloths, strict=True)):
            self._states[i] = state_at(path, cloth, dt)
        self._replan(*range(len(self._states)))
        self.time += dt
        if collision is not None:
            self.collisions.append(collision)

    def _possible(self) -> list[tuple[Collision, mpf | None]]:
        """Return each possible next collision, and the time until it; None: never."""
        balls = range(len(self._states))
        found: list[tuple[Collision, mpf | None]] = [
            (("ball-ball", a, b), self._time_of_contact(a, b)) for a, b in combinations(balls, 2)
        ]
        return found + [
            (("ball-cushion", ball, cushion), self._time_of_bounce(ball, cushion))
            for ball in balls
            for cushion in self.setup.cushions
        ]

    def _make_sure_nothing_precedes(self, dt: mpf, collision: Collision | None) -> None:
        for other, when in self._possible():
            if other != collision and when is not None and when <= dt:
                raise OrderError(f"{other} comes before {collision}")

    def _note_hull(self, dt: mpf) -> None:
        """Add the corners of each parabola's triangle: its ends, and where its tangents meet."""
        for path, cloth in zip(self._paths, self._cloths, strict=True):
            for segment, end in _with_ends(path):
                duration = min(end, dt) - segment.start
                if duration >= 0:
                    start = segment.state.position
                    tangents = along(start, duration / 2, segment.state.velocity)
                    self.hull += [start, tangents, moved(segment, cloth, duration).position]

    def _time_of_bounce(self, ball: int, cushion: str) -> mpf | None:
        """Return the time at which the ball reaches the cushion's line, or None."""
        axis = 0 if cushion in ("left", "right") else 1
        sign = NORMALS[cushion][axis]
        extent = self.setup.length if axis == 0 else self.setup.width
        radius, path = self.setup.radii[ball], self._paths[ball]
        target = radius if sign < 0 else extent - radius
        for segment, end in _with_ends(path):
            position, velocity = segment.state.position, segment.state.velocity
            gap = (
                sign * (target - position[axis]),
                -sign * velocity[axis],
                -sign * segment.acceleration[axis] / 2,
            )
            if end == mp.inf:  # at rest, or at constant velocity
                if gap[1] < 0 and gap[0] > -TOUCHING_OVERLAP * radius:
                    return segment.start + max(-gap[0] / gap[1], mp.mpf(0))
                continue
            dt = first_fall_below_zero(gap, end - segment.start, TOUCHING_OVERLAP * radius)
            if dt is not None:
                return segment.start + dt
        return None

    def _time_of_contact(self, a: int, b: int) -> mpf | None:
        """Return the time at which two balls touch, or None."""
        reach = self.setup.radii[a] + self.setup.radii[b]
        starts = sorted({s.start for ball in (a, b) for s in self._paths[ball]})
        for start, end in zip(starts, [*starts[1:], mp.inf], strict=True):
            gap = self._gap_from(start, a, b, reach)
            duration = end - start
            # constant relative velocity: until they have passed each other
            if duration == mp.inf:
                duration = max(-gap[1] / gap[2] / 2, mp.mpf(0)) if gap[2] else mp.mpf(0)
            dt = first_fall_below_zero(gap, duration, TOUCHING_OVERLAP * reach**2)
            if dt is not None:
                return start + dt
        return None

    def _gap_from(self, start: mpf, a: int, b: int, reach: mpf) -> Polynomial:
        """Return |r + v t + A t^2 / 2|^2 - reach^2 as a polynomial of the time since `start`."""
        ends = []
        for ball in (a, b):
            segment = next(s for s in reversed(self._paths[ball]) if s.start <= start)
            ends.append((moved(segment, self._cloths[ball], start - segment.start), segment))
        (state_a, segment_a), (state_b, segment_b) = ends
        r = along(state_b.position, mp.mpf(-1), state_a.position)
        v = along(state_b.velocity, mp.mpf(-1), state_a.velocity)
        acceleration = along(segment_b.acceleration, mp.mpf(-1), segment_a.acceleration)
        return (
            dot(r, r) - reach**2,
            2 * dot(r, v),
            dot(v, v) + dot(r, acceleration),
            dot(v, acceleration),
            dot(acceleration, acceleration) / 4,
        )


def _with_ends(path: list[PathSegment]) -> list[tuple[PathSegment, mpf]]:
    """Return each segment with its end time."""
    ends = [segment.start for segment in path[1:]]
    return list(zip(path, [*ends, mp.inf], strict=True))
