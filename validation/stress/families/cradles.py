"""Cradles: a row of balls that is hit at its end, in which an impulse runs from ball to ball."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from ghostball.engine import Ball, Physics, Scene, Table
from ghostball.validation.stress.exact_line import play_line
from ghostball.validation.stress.family import Family
from ghostball.validation.stress.rows import RADIUS, row
from ghostball.validation.stress.sound import Both, Ends, Sound
from ghostball.validation.stress.trial import SceneTrial, Suite, Trial, size

MASS = 0.125
TELLING = 2.0**-46
"""Gap [m] from which doubles tell which of two collisions comes first: 1.4e-14 m.

128 roundings of a coordinate. With losses the gaps of a row get ever smaller; rows in which one
gets smaller than that are not tried here: what they do is a matter of rounding, as at gap 0.
"""

WAY = 2.0**-5
"""How far the first ball runs before it meets the row [m]."""

SPEED = 1.0

T_MAX = 0.125
"""How long a row is followed [s]: several times as long as anything takes to go through it."""

ELASTIC = Physics(rolling_friction=0.0)


def _scene(
    name: str,
    places: list[float],
    speeds: list[float],
    physics: Physics,
    t_max: float,
    masses: list[float] | None = None,
    table: Table | None = None,
    y: float = 0.0,
) -> Scene:
    masses = [MASS] * len(places) if masses is None else masses
    return Scene(
        name=name,
        physics=physics,
        table=table,
        t_max=t_max,
        balls=[
            Ball(id=f"b{k}", radius=RADIUS, mass=m, position=(x, y), velocity=(v, 0.0))
            for k, (x, v, m) in enumerate(zip(places, speeds, masses, strict=True))
        ],
    )


def _gaps(suite: Suite) -> tuple[float, ...]:
    return (0.0, 1e-15, 1e-3) if suite == "quick" else (0.0, *(10.0**-k for k in range(15, 2, -1)))


def _one_in_one_out(suite: Suite) -> Iterator[Trial]:
    """Yield k balls, apart, that meet a row of n: as many leave it, and the others stay."""
    rows = (2, 5) if suite == "quick" else (1, 2, 3, 4, 5, 8, 15)
    for n, k, gap in product(rows, (1, 2, 3), _gaps(suite)):
        if k > n:
            continue
        apart = [-(2.0 * RADIUS + WAY) - i * (2.0 * RADIUS + 2.0**-6) for i in range(k)]
        places = [*reversed(apart), *row(n, gap)]
        name = f"{k}-into-{n}-gap-{size(gap)}"
        scene = _scene(name, places, [SPEED] * k + [0.0] * n, ELASTIC, T_MAX)
        # Equal masses trade velocities: as many collisions as passings of k through n. Each of
        # the ways is the same but for whose it is.
        ends = Ends(((0.0, 0.0),) * n + ((SPEED, 0.0),) * k, collisions=n * k)
        sound = Sound(most_events=n * k, isolated=True, images=tuple(range(n + k)))
        yield SceneTrial(name, scene, Both(sound, ends))


def _lossy(suite: Suite) -> Iterator[Trial]:
    """Yield a ball that meets a row with gaps, with losses or unequal masses: rational numbers."""
    rows = (3,) if suite == "quick" else (2, 3, 5, 8)
    gaps = (
        (2.0**-40, 2.0**-10) if suite == "quick" else tuple(2.0**-k for k in (50, 40, 30, 20, 10))
    )
    for n, gap, restitution in product(rows, gaps, (1.0, 0.75, 0.5)):
        for word, ratio in (("equal", 1.0), ("lighter", 0.5), ("heavier", 2.0)):
            if restitution == ratio == 1.0:
                continue  # above
            places = [-(2.0 * RADIUS + WAY), *row(n, gap)]
            speeds = [SPEED] + [0.0] * n
            masses = [MASS * ratio**i for i in range(n + 1)]
            end = play_line(places, speeds, masses, RADIUS, restitution, T_MAX)
            if end.least_gap < TELLING:
                continue
            name = f"row-of-{n}-{word}-gap-{size(gap)}-restitution-{restitution:g}"
            physics = Physics(rolling_friction=0.0, ball_restitution=restitution)
            scene = _scene(name, places, speeds, physics, T_MAX, masses)
            ends = Ends(
                tuple((float(v), 0.0) for v in end.velocities),
                end.collisions,
                tuple((float(x), 0.0) for x in end.positions),
                # Each impact rounds the speeds, by some parts of the speed of its balls; lighter
                # ones are faster than the first.
                roundings=32.0 * (1.0 + n),
            )
            sound = Sound(most_events=end.collisions, isolated=True, images=tuple(range(n + 1)))
            yield SceneTrial(name, scene, Both(sound, ends))


def _touching_with_losses(suite: Suite) -> Iterator[Trial]:
    """Yield touching rows with losses: which impulses an instant has is a convention.

    README states it: together, (1 + e) times the plastic ones. What no convention may break is
    asked: momentum, energy, no overlap, an end. Impacts then go to and fro through the row until
    no ball approaches the next: speeds even out as heat does, by a factor e in 2 n^2 / pi^2 passes
    of n / 2 impacts, and so down to rounding in n^3 ln(1 / EPS) / pi^2 < 4 n^3 of them.
    """
    rows = (3,) if suite == "quick" else (2, 3, 5, 8, 15)
    for n, restitution, together in product(rows, (0.9, 0.5, 0.0), (True, False)):
        word = "simultaneous" if together else "sequential"
        name = f"row-of-{n}-gap-0-restitution-{restitution:g}-{word}"
        physics = Physics(
            rolling_friction=0.0,
            ball_restitution=restitution,
            impacts="simultaneous" if together else "sequential",
        )
        places = [-(2.0 * RADIUS + WAY), *row(n, 0.0)]
        scene = _scene(name, places, [SPEED] + [0.0] * n, physics, T_MAX)
        most = 4 * (n + 1) ** 3
        sound = Sound(most_events=most, isolated=True, images=tuple(range(n + 1)))
        yield SceneTrial(name, scene, sound)


def _from_both_sides(suite: Suite) -> Iterator[Trial]:
    """Yield a row that is hit at both ends at one instant: both balls come back as they came."""
    rows = (1, 2, 5) if suite == "quick" else range(1, 12)
    for n, gap in product(rows, _gaps(suite)):
        half = 0.5 * (n - 1)
        inner = [(k - half) * (2.0 * RADIUS + gap) for k in range(n)]
        far = half * (2.0 * RADIUS + gap) + 2.0 * RADIUS + WAY
        name = f"both-sides-of-{n}-gap-{size(gap)}"
        scene = _scene(name, [-far, *inner, far], [SPEED, *[0.0] * n, -SPEED], ELASTIC, T_MAX)
        ends = Ends(((-SPEED, 0.0), *[(0.0, 0.0)] * n, (SPEED, 0.0)))
        sound = Sound(most_events=4 * n * n + 8, isolated=True, images=tuple(range(n + 2)))
        yield SceneTrial(name, scene, Both(sound, ends))


def _between_cushions(suite: Suite) -> Iterator[Trial]:
    """Yield a row at a cushion: what runs through it comes back, and the first ball with it."""
    table = Table(length=2.0, width=1.0, cushions=("right",))
    rows = (1, 3) if suite == "quick" else (1, 2, 3, 5, 8)
    for n, gap in product(rows, _gaps(suite)):
        places = [2.0 - RADIUS - gap]
        for _ in range(n - 1):
            places.insert(0, places[0] - (2.0 * RADIUS + gap))
        places.insert(0, places[0] - 2.0 * RADIUS - WAY)
        name = f"at-cushion-{n}-gap-{size(gap)}"
        speeds = [SPEED] + [0.0] * n
        scene = _scene(name, places, speeds, ELASTIC, T_MAX, table=table, y=0.5)
        ends = Ends(((-SPEED, 0.0), *[(0.0, 0.0)] * n), collisions=2 * n + 1)
        yield SceneTrial(name, scene, Both(Sound(most_events=2 * n + 1), ends))


def _trials(suite: Suite) -> Iterator[Trial]:
    yield from _one_in_one_out(suite)
    yield from _lossy(suite)
    yield from _touching_with_losses(suite)
    yield from _from_both_sides(suite)
    yield from _between_cushions(suite)


FAMILY = Family(
    "cradles",
    "Cradles",
    "As many balls leave a row as run into it, whatever its gaps, touching ones too, with one "
    "collision of each ball with each; with losses or unequal masses, rows with gaps end as "
    "rational arithmetic says, and touching ones keep momentum and gain no energy.",
    _trials,
)
