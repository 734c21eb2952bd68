"""Touching starts: balls that touch each other, cushions and corners, or almost touch."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.stress.common_limits import (
    ISOLATED,
    POSSIBLE,
    SKEW_OF_CONTACTS,
    bounded,
    symmetric,
)
from ghostball.validation.stress.reversal import back_within
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
    size_of,
)

RADIUS = 2.0**-5
"""Radius [m]: a power of two, so contacts along an axis are exactly closed, and gaps are exact."""

ROOT3 = math.sqrt(3.0)

Plane = tuple[float, float]

KINDS = {
    "elastic": Physics(rolling_friction=0.0),
    "rolling": Physics(rolling_friction=0.02, ball_restitution=0.95),
    "sliding": Physics(
        motion="sliding",
        ball_restitution=0.95,
        ball_friction=0.06,
        cushion="frictional",
        cushion_restitution=0.85,
    ),
}

DIRECTIONS = {
    "into": (1.0, 0.0),
    "slanting": (0.8, 0.6),
    "along": (0.0, 1.0),
    "away": (-1.0, 0.0),
}
"""Velocities at a contact whose normal is (1, 0)."""

SKEW_OF_RACK = 1e-2
"""Asymmetry of a broken rack, in diameters: the order of contacts amplifies rounding to this size.
"""

EVENTS_PER_BALL = 36
"""Largest number of events per ball: three times that of any row, rack or wedge, 12 in a row of 15.
A test checks this for all of them; a stuck ball needs thousands."""

STEPS_PER_BALL = 51
"""Largest number of contact steps per ball: three times that of any shot, 17 in a row of 8.
Without friction, no force keeps balls in contact, and no contact step is allowed."""

SQUARE = Table(length=1.0, width=1.0)
WALL = Table(length=1.0, width=1.0, cushions=("left",))

T_MAX = 0.02
"""Simulated time of the certified shots [s]."""


def ball(name: str, place: Plane, velocity: Plane = (0.0, 0.0)) -> Ball:
    """Return a ball of radius `RADIUS` with a position [m] and a velocity [m/s]."""
    return Ball(id=name, radius=RADIUS, position=place, velocity=velocity)


def resting_row(count: int, gap: float) -> list[Ball]:
    """Return balls "b0", "b1", ... at rest in a row along y = 0, with gaps [m]."""
    places = [0.0]
    for _ in range(count - 1):
        places.append(places[-1] + (2.0 * RADIUS + gap))
    return [ball(f"b{k}", (x, 0.0)) for k, x in enumerate(places)]


def _gaps(size: StressSize) -> tuple[float, ...]:
    return (0.0, *(10.0**-k for k in range(15, 2, -1))) if size.full else (0.0, 1e-9)


def _few_gaps(size: StressSize) -> tuple[float, ...]:
    return (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3) if size.full else (0.0,)


def _pairs(size: StressSize) -> Iterator[StressShot]:
    """Yield two balls, one of them moving, in contact along an axis or at an angle; certified."""
    turns = (0.0, 0.7, 0.5 * math.pi, 2.0, 4.0) if size.full else (0.0, 0.7)
    for (kind, physics), gap, (word, direction), turn in product(
        KINDS.items(), _gaps(size), DIRECTIONS.items(), turns
    ):
        c, s = math.cos(turn), math.sin(turn)
        x, y = direction
        reach = 2.0 * RADIUS + gap
        name = f"pair-{kind}-{word}-gap-{size_of(gap)}-turned-{turn:.1f}"
        moves = ball("a", (0.0, 0.0), (c * x - s * y, s * x + c * y))
        rests = ball("b", (c * reach, s * reach))
        scene = scene_of(moves, rests, physics=physics, t_max=T_MAX)
        isolated = ISOLATED if kind == "elastic" else ()
        yield shot(name, scene, *POSSIBLE, *bounded(4, 200), *isolated, gap=gap)


def _on_cushions(size: StressSize) -> Iterator[StressShot]:
    """Yield a ball at a cushion, and in a corner; certified."""
    for (kind, physics), gap, (word, direction) in product(
        KINDS.items(), _gaps(size), DIRECTIONS.items()
    ):
        for place, where in (
            ((RADIUS + gap, 0.5), "cushion"),
            ((RADIUS + gap, RADIUS + gap), "corner"),
        ):
            velocity = (-direction[0], -direction[1])
            name = f"{where}-{kind}-{word}-gap-{size_of(gap)}"
            moves = ball("a", place, velocity)
            scene = scene_of(moves, physics=physics, table=SQUARE, t_max=T_MAX)
            limits = (*POSSIBLE, *bounded(6, 200))
            if where == "corner" and word == "slanting" and gap == 0.0 and kind != "sliding":
                # The certified result doesn't determine the order of the cushions. The ball returns
                # in either case.
                limits += _off_both()
            yield shot(name, scene, *limits, gap=gap)


def _off_both() -> tuple[Criterion, ...]:
    """Return the limits for a ball that rolls into a corner with mirror cushions."""
    both = limit("ball_cushion_count", "The ball hits each of the two cushions once.", equals=2)
    return (both, ends(1), *symmetric(0.0))


def ends(late: int) -> Criterion:
    """Return the limit on the end of a shot in which `late` contacts may be a step late."""
    why = "The engine may detect each contact of the chain one time step late."
    return limit("rest_error_max", why, at_most=float(late), of="step")


def _into_corners(size: StressSize) -> Iterator[StressShot]:
    """Yield a ball that rolls into a corner along its bisector, and returns the same way."""
    ways = (0.0, 1e-15, 1e-6, 0.01, 0.1, 0.25, 0.37) if size.full else (0.0, 0.25)
    for corner, far in product(((0, 0), (1, 0), (0, 1), (1, 1)), ways):
        start = RADIUS + far
        x, y = (start if end == 0 else 1.0 - start for end in corner)
        to_x, to_y = (-1.0 if end == 0 else 1.0 for end in corner)
        name = f"bisector-to-{corner[0]}-{corner[1]}-from-{size_of(far)}"
        moves = ball("a", (x, y), (to_x, to_y))
        scene = scene_of(moves, physics=KINDS["elastic"], table=SQUARE, t_max=0.5)
        yield shot(name, scene, *POSSIBLE, *_off_both(), back_within(RADIUS))


def _limits(scene: Scene, kind: str, skew: float | None) -> tuple[Criterion, ...]:
    """Return the limits for a row, a rack or a wedge; `skew` [diameters]: see `symmetric`."""
    n, elastic = len(scene.balls), kind == "elastic"
    alone = ISOLATED if elastic and scene.table is None else ()
    return (
        *POSSIBLE,
        *bounded(EVENTS_PER_BALL * n, 0 if elastic else STEPS_PER_BALL * n),
        *(() if skew is None else symmetric(0.0 if elastic else 2.0 * RADIUS * skew)),
        *alone,
    )


def _cradles(size: StressSize) -> Iterator[StressShot]:
    """Yield balls that roll into a row: equally many balls leave the row, and the rest stays.

    Equal masses exchange velocities, so `k` balls pass through `n` balls in n k collisions.
    """
    rows = (1, 2, 3, 4, 5, 8, 15) if size.full else (2, 5)
    for n, k, gap in product(rows, (1, 2, 3), _few_gaps(size)):
        if k > n:
            continue
        first = -(2.0 * RADIUS + 2.0**-5)
        places = [first - i * (2.0 * RADIUS + 2.0**-6) for i in range(k)]
        coming = [ball(f"in{i}", (x, 0.0), (1.0, 0.0)) for i, x in enumerate(places)]
        name = f"cradle-{k}-into-{n}-gap-{size_of(gap)}"
        balls = [*reversed(coming), *resting_row(n, gap)]
        scene = scene_of(*balls, physics=KINDS["elastic"], t_max=0.125)
        count = limit(
            "collision_count",
            "Equal balls exchange velocities, so k balls pass through n balls: n k collisions.",
            equals=n * k,
        )
        asked = (count, ends(n), *bounded(n * k, 0), *symmetric(0.0))
        yield shot(name, scene, *POSSIBLE, *ISOLATED, *asked, gap=gap)


def _lines(size: StressSize) -> Iterator[StressShot]:
    """Yield a ball that hits a line of frozen balls off centre."""
    numbers = range(2, 16) if size.full else (5,)
    for (kind, physics), n, gap in product(KINDS.items(), numbers, _few_gaps(size)):
        cue = ball("cue", (-0.125, 0.25 * RADIUS), (1.5, 0.0))
        name = f"line-of-{n}-{kind}-gap-{size_of(gap)}"
        scene = scene_of(cue, *resting_row(n, gap), physics=physics, t_max=0.1)
        yield shot(name, scene, *_limits(scene, kind, None), gap=gap)


def triangle(rows: int, gap: float) -> list[Plane]:
    """Return the positions of frozen balls in rows of 1, 2, 3, ..., symmetric about y = 0."""
    spacing = 2.0 * RADIUS + gap
    return [
        (row * spacing * (0.5 * ROOT3), (k - 0.5 * row) * spacing)
        for row in range(rows)
        for k in range(row + 1)
    ]


def _triangles(size: StressSize) -> Iterator[StressShot]:
    """Yield a straight break of a frozen triangle, and a triangle that nothing hits."""
    numbers = range(3, 16) if size.full else (3,)
    for (kind, physics), rows, gap in product(KINDS.items(), numbers, _few_gaps(size)):
        places = [(-0.125, 0.0), *triangle(rows, gap)]
        balls = [ball(f"b{k}", place) for k, place in enumerate(places)]
        name = f"triangle-of-{rows}-rows-{kind}-gap-{size_of(gap)}"
        cue = ball("cue", places[0], (4.0, 0.0))
        scene = scene_of(cue, *balls[1:], physics=physics, t_max=0.05)
        yield shot(name, scene, *_limits(scene, kind, SKEW_OF_RACK), gap=gap)
        still = scene_of(*balls, physics=physics, t_max=0.01)
        calm = limit("event_count", "No ball moves.", equals=0)
        yield shot(f"still-{name}", still, *POSSIBLE, calm, *symmetric(0.0), gap=gap)


def _wedged(size: StressSize) -> Iterator[StressShot]:
    """Yield balls pushed against a cushion, or into a corner, that they touch."""
    for (kind, physics), gap in product(KINDS.items(), _few_gaps(size)):
        spacing = 2.0 * RADIUS + gap
        places = {
            "pair": [
                (RADIUS, 0.5 * spacing),
                (RADIUS, -0.5 * spacing),
                (RADIUS + 0.5 * ROOT3 * spacing, 0.0),
            ],
            "column": [(RADIUS + gap, 0.0), (RADIUS + gap + spacing, 0.0)],
        }
        for word, still in places.items():
            ahead = max(x for x, _ in still) + 2.0 * RADIUS
            for start, how in ((ahead, "pushed"), (ahead + 0.0625, "hit")):
                name = f"wedged-{word}-{how}-{kind}-gap-{size_of(gap)}"
                cue = ball("cue", (start, 0.0), (-1.0, 0.0))
                balls = [ball(f"b{k}", place) for k, place in enumerate(still, start=1)]
                scene = scene_of(cue, *balls, physics=physics, table=WALL, t_max=0.125)
                yield shot(name, scene, *_limits(scene, kind, SKEW_OF_CONTACTS), gap=gap)
        name = f"wedged-corner-{kind}-gap-{size_of(gap)}"
        cue = ball("cue", (0.25, 0.25), (-1.0, -1.0))
        frozen = ball("b", (RADIUS + gap, RADIUS + gap))
        scene = scene_of(cue, frozen, physics=physics, table=SQUARE, t_max=0.25)
        yield shot(name, scene, *_limits(scene, kind, SKEW_OF_CONTACTS), gap=gap)


def _shots(size: StressSize) -> Iterator[StressShot]:
    yield from _pairs(size)
    yield from _on_cushions(size)
    yield from _into_corners(size)
    yield from _cradles(size)
    yield from _lines(size)
    yield from _triangles(size)
    yield from _wedged(size)


FAMILY = StressFamily(
    "touching",
    "Touching starts",
    "Balls that touch each other, a cushion or a corner at the start, or are 1e-15 to 1e-3 m away, "
    "have the certified collisions. As many balls leave a cradle as run into it. Racks and lines "
    "separate without overlap or energy gain. Straight shots keep their mirror symmetry. Balls "
    "that nothing hits stay at rest.",
    _shots,
)
