"""Touching starts: balls that touch each other, cushions and corners, or all but touch."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.stress.judges import Both, Ends, Invariants
from ghostball.validation.stress.proved import ProvedTrial
from ghostball.validation.stress.trial import Family, SceneTrial, Suite, Trial, size

RADIUS = 2.0**-5
"""Radius [m]: with it, contacts along an axis are closed to the bit, and gaps what they say."""

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
"""Asymmetry of a rack that is broken, in diameters: order of contacts makes that of rounding."""

EVENTS_PER_BALL = 36
"""Three times the most that any row, rack or wedge of the full suite needs: 12, of a row of 15.

A test holds that against all of them; a ball that is stuck takes thousands."""

STEPS_PER_BALL = 51
"""The same of contact steps: 17, of a row of 8.

Where balls neither rub nor slow down, nothing pushes them, and none is permitted."""

T_MAX = 0.02
"""How long what is proved is followed [s]."""


def ball(name: str, place: Plane, velocity: Plane = (0.0, 0.0)) -> Ball:
    """Return a ball of radius `RADIUS` at a place [m], with a velocity [m/s]."""
    return Ball(id=name, radius=RADIUS, position=place, velocity=velocity)


def resting_row(count: int, gap: float) -> list[Ball]:
    """Return balls "b0", "b1" ... at rest in a row along y = 0, with these gaps [m]."""
    places = [0.0]
    for _ in range(count - 1):
        places.append(places[-1] + (2.0 * RADIUS + gap))
    return [ball(f"b{k}", (x, 0.0)) for k, x in enumerate(places)]


def _gaps(suite: Suite) -> tuple[float, ...]:
    return (0.0, 1e-9) if suite == "quick" else (0.0, *(10.0**-k for k in range(15, 2, -1)))


def _few_gaps(suite: Suite) -> tuple[float, ...]:
    return (0.0,) if suite == "quick" else (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3)


def _pairs(suite: Suite) -> Iterator[Trial]:
    """Yield two balls, one of which moves, in contact along an axis or at an angle; proved."""
    turns = (0.0, 0.7) if suite == "quick" else (0.0, 0.7, 0.5 * math.pi, 2.0, 4.0)
    for (kind, physics), gap, (word, direction), turn in product(
        KINDS.items(), _gaps(suite), DIRECTIONS.items(), turns
    ):
        c, s = math.cos(turn), math.sin(turn)
        x, y = direction
        reach = 2.0 * RADIUS + gap
        name = f"pair-{kind}-{word}-gap-{size(gap)}-turned-{turn:.1f}"
        scene = Scene(
            name=name,
            physics=physics,
            t_max=T_MAX,
            balls=[
                ball("a", (0.0, 0.0), (c * x - s * y, s * x + c * y)),
                ball("b", (c * reach, s * reach)),
            ],
        )
        bounds = Invariants(most_events=4, most_steps=200, isolated=kind == "elastic")
        if kind == "elastic" and word == "into" and gap == 0.0 and turn != 0.0:
            # The first ball ends at rest or moves by a rounding: which, no proof says, so that it
            # says nothing of the shot. Equal masses trade velocities.
            there = (c * (reach + T_MAX), s * (reach + T_MAX))
            traded = Ends(((0.0, 0.0), (c, s)), 1, ((0.0, 0.0), there))
            yield SceneTrial(name, scene, Both(bounds, traded))
        else:
            yield ProvedTrial(name, scene, also=bounds, cached=False)


def _on_cushions(suite: Suite) -> Iterator[Trial]:
    """Yield a ball at a cushion, and in a corner; proved."""
    table = Table(length=1.0, width=1.0)
    for (kind, physics), gap, (word, direction) in product(
        KINDS.items(), _gaps(suite), DIRECTIONS.items()
    ):
        for place, where in (
            ((RADIUS + gap, 0.5), "cushion"),
            ((RADIUS + gap, RADIUS + gap), "corner"),
        ):
            velocity = (-direction[0], -direction[1])
            name = f"{where}-{kind}-{word}-gap-{size(gap)}"
            scene = Scene(
                name=name,
                physics=physics,
                table=table,
                t_max=T_MAX,
                balls=[ball("a", place, velocity)],
            )
            bounds = Invariants(most_events=6, most_steps=200)
            if where == "corner" and word == "slanting" and gap == 0.0:
                yield SceneTrial(name, scene, _from_corner(kind, place, direction, bounds))
            else:
                yield ProvedTrial(name, scene, also=bounds, cached=False)


def _from_corner(
    kind: str, place: Plane, direction: Plane, bounds: Invariants
) -> Invariants | Both:
    """Return the judge of a ball that leaves a corner, into which it is pushed at the start.

    Which of both cushions comes first no proof says, and so it says nothing of the shot. Mirrors
    send the ball back either way, and it rolls on. What friction on the first one leaves for the
    second depends on that order: then nothing is asked but that both are met, or it would be
    beyond one of them.
    """
    if kind == "sliding":
        return bounds
    lost = KINDS[kind].rolling_friction * KINDS[kind].gravity * T_MAX
    way = T_MAX * (1.0 - 0.5 * lost)  # at 1 m/s at first
    velocity = (direction[0] * (1.0 - lost), direction[1] * (1.0 - lost))
    there = (place[0] + direction[0] * way, place[1] + direction[1] * way)
    return Both(bounds, Ends((velocity,), 2, (there,)))


def _into_corners(suite: Suite) -> Iterator[Trial]:
    """Yield a ball that runs into a corner along its bisector: it comes back as it came."""
    ways = (0.0, 0.25) if suite == "quick" else (0.0, 1e-15, 1e-6, 0.01, 0.1, 0.25, 0.37)
    for corner, far in product(((0, 0), (1, 0), (0, 1), (1, 1)), ways):
        start = RADIUS + far
        x, y = (start if end == 0 else 1.0 - start for end in corner)
        velocity = tuple(-1.0 if end == 0 else 1.0 for end in corner)
        name = f"bisector-to-{corner[0]}-{corner[1]}-from-{size(far)}"
        scene = Scene(
            name=name,
            physics=KINDS["elastic"],
            table=Table(length=1.0, width=1.0),
            t_max=0.5,
            balls=[ball("a", (x, y), (velocity[0], velocity[1]))],
        )
        back = tuple(-v for v in velocity)
        beyond = 0.5 - 2.0 * far  # to the corner and back, and then that much
        place = tuple(p + b * beyond for p, b in zip((x, y), back, strict=True))
        ends = Ends(((back[0], back[1]),), collisions=2, positions=((place[0], place[1]),))
        yield SceneTrial(name, scene, Both(Invariants(most_events=2), ends))


def _bounds(scene: Scene, kind: str) -> Invariants:
    """Return what is asked of a row, a rack or a wedge."""
    n, elastic = len(scene.balls), kind == "elastic"
    return Invariants(
        most_events=EVENTS_PER_BALL * n,
        most_steps=0 if elastic else STEPS_PER_BALL * n,
        isolated=elastic and scene.table is None,
    )


def _cradles(suite: Suite) -> Iterator[Trial]:
    """Yield balls that run into a row: as many leave it, and the others stay.

    Equal masses trade velocities: as many collisions as passings of `k` balls through `n`.
    """
    rows = (2, 5) if suite == "quick" else (1, 2, 3, 4, 5, 8, 15)
    for n, k, gap in product(rows, (1, 2, 3), _few_gaps(suite)):
        if k > n:
            continue
        first = -(2.0 * RADIUS + 2.0**-5)
        places = [first - i * (2.0 * RADIUS + 2.0**-6) for i in range(k)]
        coming = [ball(f"in{i}", (x, 0.0), (1.0, 0.0)) for i, x in enumerate(places)]
        name = f"cradle-{k}-into-{n}-gap-{size(gap)}"
        balls = [*reversed(coming), *resting_row(n, gap)]
        scene = Scene(name=name, physics=KINDS["elastic"], t_max=0.125, balls=balls)
        ends = Ends(((0.0, 0.0),) * n + ((1.0, 0.0),) * k, collisions=n * k)
        bounds = Invariants(most_events=n * k, isolated=True, images=tuple(range(n + k)))
        yield SceneTrial(name, scene, Both(bounds, ends))


def _lines(suite: Suite) -> Iterator[Trial]:
    """Yield a ball that hits a line of frozen ones off its middle, and lines that nothing hits."""
    numbers = (5,) if suite == "quick" else range(2, 16)
    for (kind, physics), n, gap in product(KINDS.items(), numbers, _few_gaps(suite)):
        cue = ball("cue", (-0.125, 0.25 * RADIUS), (1.5, 0.0))
        name = f"line-of-{n}-{kind}-gap-{size(gap)}"
        scene = Scene(name=name, physics=physics, t_max=0.1, balls=[cue, *resting_row(n, gap)])
        yield SceneTrial(name, scene, _bounds(scene, kind))


def triangle(rows: int, gap: float) -> list[Plane]:
    """Return the places of frozen balls in rows of 1, 2, 3 ..., their own mirror image in y = 0."""
    spacing = 2.0 * RADIUS + gap
    return [
        (row * spacing * (0.5 * ROOT3), (k - 0.5 * row) * spacing)
        for row in range(rows)
        for k in range(row + 1)
    ]


def images_of(places: list[Plane], *, swapped: bool = False) -> tuple[int, ...]:
    """Return each ball's mirror image in y = 0, or in x = y."""
    return tuple(places.index((y, x) if swapped else (x, -y)) for x, y in places)


def _triangles(suite: Suite) -> Iterator[Trial]:
    """Yield a straight break of a frozen triangle, and one that nothing hits."""
    numbers = (3,) if suite == "quick" else range(3, 16)
    for (kind, physics), rows, gap in product(KINDS.items(), numbers, _few_gaps(suite)):
        places = [(-0.125, 0.0), *triangle(rows, gap)]
        balls = [ball(f"b{k}", place) for k, place in enumerate(places)]
        name = f"triangle-of-{rows}-rows-{kind}-gap-{size(gap)}"
        cue = ball("cue", places[0], (4.0, 0.0))
        scene = Scene(name=name, physics=physics, t_max=0.05, balls=[cue, *balls[1:]])
        n = len(balls)
        yield SceneTrial(
            name,
            scene,
            replace(_bounds(scene, kind), images=images_of(places), skew=SKEW_OF_RACK),
        )
        still = Scene(name=f"still-{name}", physics=physics, t_max=0.01, balls=balls)
        calm = Invariants(most_events=0, still=tuple(range(n)), images=images_of(places))
        yield SceneTrial(still.name, still, calm)


def _wedged(suite: Suite) -> Iterator[Trial]:
    """Yield balls that touch each other and a cushion, or lie in a corner, and are pushed there."""
    for (kind, physics), gap in product(KINDS.items(), _few_gaps(suite)):
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
                every = [(start, 0.0), *still]
                name = f"wedged-{word}-{how}-{kind}-gap-{size(gap)}"
                balls = [ball(f"b{k}", place) for k, place in enumerate(every)]
                scene = Scene(
                    name=name,
                    physics=physics,
                    table=Table(length=1.0, width=1.0, cushions=("left",)),
                    t_max=0.125,
                    balls=[ball("cue", every[0], (-1.0, 0.0)), *balls[1:]],
                )
                bounds = _bounds(scene, kind)
                yield SceneTrial(name, scene, replace(bounds, images=images_of(every)))
        corner = [(0.25, 0.25), (RADIUS + gap, RADIUS + gap)]
        name = f"wedged-corner-{kind}-gap-{size(gap)}"
        scene = Scene(
            name=name,
            physics=physics,
            table=Table(length=1.0, width=1.0),
            t_max=0.25,
            balls=[ball("cue", corner[0], (-1.0, -1.0)), ball("b", corner[1])],
        )
        yield SceneTrial(
            name,
            scene,
            replace(_bounds(scene, kind), images=images_of(corner, swapped=True), swapped=True),
        )


def _trials(suite: Suite) -> Iterator[Trial]:
    yield from _pairs(suite)
    yield from _on_cushions(suite)
    yield from _into_corners(suite)
    yield from _cradles(suite)
    yield from _lines(suite)
    yield from _triangles(suite)
    yield from _wedged(suite)


FAMILY = Family(
    "touching",
    "Touching starts",
    "Balls that touch each other, a cushion or a corner at the start, or are 1e-15 to 1e-3 m from "
    "it, collide as is proved; as many balls leave a cradle as run into it; racks and lines come "
    "apart without overlap or gain of energy, "
    "straight shots stay their own mirror image, and what nothing hits stays where it is.",
    _trials,
)
