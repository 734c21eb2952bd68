"""Ties: impacts of one ball with two at one instant, against closed forms.

No proof covers them, since an engine chooses: in either order, or together.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ghostball.engine import Ball, Physics, Result, Scene
from ghostball.validation.stress.trial import SceneTrial, Suite, Trial, Verdict

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
            if not error <= _TURNED_BACK
        ]
        worst = float(np.max(errors))  # NaN where one is
        near = worst / _TURNED_BACK
        return Verdict.of(result.scene, faults, near, {"velocity_error": worst})


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


def ties(suite: Suite) -> Iterator[Trial]:
    """Yield a ball that hits two, evenly and unevenly, by each rule and with each restitution."""
    for restitution in (1.0, 0.5) if suite == "quick" else (1.0, 0.95, 0.8, 0.5, 0.2):
        for impacts in ("sequential", "simultaneous"):
            for kind, normals in _TIES.items():
                yield _tie(f"tie-{kind}-{impacts}-{restitution:g}", normals, restitution, impacts)
