"""Trials that hold an engine against a proof of the very shot, or against a shot like it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine import GhostballError, Result, Scene, UnsupportedSceneError
from reference_adapters import ReferenceEngine
from reference_adapters.certified import Certificate, certify
from reference_adapters.registry import OURS
from validation.faults import faults_of
from validation.grading import grade
from validation.our_run import run_ours
from validation.stress.trial import Trial, Verdict, play

PERMITTED = 0.01
"""Error that is permitted to other engines, in units of the longest way that a ball went.

They see contacts up to a step late. This is no grade of how exact they are, which `validate` gives:
it tells a shot that is played from one that is lost.
"""

STILL = 1e-9
"""How far a ball may move that can't, in radii, in other engines."""

LONGEST = 2.0
"""Simulated time [s] beyond which an engine isn't asked that may step through it."""

_QUALITY = 32.0  # the limit of scenes/common.expect.toml: a severity of 1


def refuse_long(engine: ReferenceEngine, scene: Scene, t_end: float) -> None:
    """Refuse for an engine other than ours a shot that would take it too many steps.

    Raises
    ------
    UnsupportedSceneError
    """
    if engine.name != OURS and t_end > LONGEST:
        why = f"{t_end:.3g} s of motion, more than the {LONGEST:g} s that steps are asked for"
        raise UnsupportedSceneError(engine.name, (f"{why} (scene {scene.name!r})",))


@dataclass(frozen=True)
class ProvedTrial(Trial):
    """One shot that is proved: our engine is graded as in the suite, others by where balls are.

    Attributes
    ----------
    name : str
    scene : Scene
    """

    name: str
    scene: Scene

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Prove the shot, run it, compare."""
        proof = certify(self.scene, motion=True)
        if not proof.events and not proof.proved:
            raise GhostballError(f"nothing is proved of scene {self.scene.name!r}: {proof.reason}")
        refuse_long(engine, self.scene, float(proof.t_end))
        result = play(engine, self.scene)
        if isinstance(result, Verdict):
            return result
        return graded(result, proof) if engine.name == OURS else near(result, proof)

    def examples(self) -> Iterable[Scene]:
        """Yield the scene."""
        yield self.scene


def graded(result: Result, proof: Certificate) -> Verdict:
    """Judge a run of our engine: every event, and positions within 32 roundings per event."""
    found = grade(result, proof)
    faults = list(faults_of(found, result.scene))
    quality = found.quality_factor
    if quality is None and not faults and found.extent == "whole":
        lost = float(np.max(found.position_errors))
        if lost > 0.0:
            faults.append(f"a ball that rounding doesn't move is {lost:.3g} m off")
    values = {"quality": quality, "events": found.events, "extent": found.extent}
    return Verdict.of(result.scene, faults, min((quality or 0.0) / _QUALITY, 0.999), values)


def near(result: Result, proof: Certificate) -> Verdict:
    """Judge a run of another engine by where its balls are at the end of the proof."""
    scene = result.scene
    start = scene.positions[:, :2]
    end = np.array([[float(e) for e in position] for position in proof.positions])
    found = result.sample([float(proof.t_end)]).positions[0, :, :2]
    way = float(np.max(np.hypot(*(end - start).T)))
    return judge_places(scene, found, end, max(PERMITTED * way, STILL * float(min(scene.radii))))


def judge_places(
    scene: Scene,
    found: NDArray[np.float64],
    right: NDArray[np.float64],
    permitted: float,
) -> Verdict:
    """Judge where balls are: (n, 2) [m], against where they should be."""
    off = np.hypot(*(found - right).T)
    if not np.all(np.isfinite(off)):
        return Verdict.of(scene, ["a position isn't finite"], 10.0)
    k = int(np.argmax(off))
    worst = float(off[k])
    faults = []
    if worst > permitted:
        faults.append(
            f'ball "{scene.balls[k].id}" is {worst:.3g} m off, more than {permitted:.3g} m'
        )
    return Verdict.of(scene, faults, min(worst / permitted, 1e6), {"error": worst})


@dataclass(frozen=True)
class ScaledTrial(Trial):
    """A shot made larger, faster and heavier by powers of two: the same shot.

    Doubles scale exactly by powers of two, and no constant of ours has a unit: our engine must
    answer the same to the bit. Others, whose steps have a length, are asked for `PERMITTED`.

    Attributes
    ----------
    name : str
    scene : Scene
        The shot in the size of a table.
    length, time, mass : int
        Powers of two that lengths, times and masses are multiplied by.
    """

    name: str
    scene: Scene
    length: int
    time: int
    mass: int

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Run both and compare."""
        larger = scaled(self.scene, self.length, self.time, self.mass)
        right = run_ours(self.scene)
        refuse_long(engine, larger, right.rest_time * 2.0**self.time)
        result = play(engine, larger)
        if isinstance(result, Verdict):
            return result
        if engine.name == OURS:
            return Verdict.of(larger, differences(right, result, self.length, self.time))
        way = right.rest_positions[:, :2] - self.scene.positions[:, :2]
        unit = 2.0**self.length
        return judge_places(
            larger,
            result.rest_positions[:, :2],
            right.rest_positions[:, :2] * unit,
            PERMITTED * unit * float(np.max(np.hypot(*way.T))),
        )

    def examples(self) -> Iterable[Scene]:
        """Yield the scene."""
        yield self.scene


def differences(one: Result, other: Result, length: int, time: int) -> list[str]:
    """Return what of a scaled run isn't the run, scaled; exactly."""
    assert one.events is not None
    assert other.events is not None
    x, t = 2.0**length, 2.0**time
    faults = []
    if len(one.events) != len(other.events) or any(
        not np.array_equal(one.events[name], other.events[name]) for name in ("kind", "a", "b")
    ):
        return [f"{len(other.events)} events, or others, instead of {len(one.events)}"]
    pairs = {
        "instants of events": (one.events["t"] * t, other.events["t"]),
        "the end": (np.array([one.rest_time * t]), np.array([other.rest_time])),
        "positions": (one.final_state.positions * x, other.final_state.positions),
        "velocities": (one.final_state.velocities * (x / t), other.final_state.velocities),
        "spins": (one.final_state.angular_velocities / t, other.final_state.angular_velocities),
    }
    for name, (wanted, found) in pairs.items():
        if not np.array_equal(wanted, found):
            off = float(np.max(np.abs(found - wanted) / np.max(np.abs(wanted))))
            faults.append(f"{name} differ by {off:.3g} of the largest")
    return faults


def scaled(scene: Scene, length: int, time: int, mass: int) -> Scene:
    """Return the scene with lengths, times and masses multiplied by powers of two.

    Everything else follows from its unit: speeds, gravity, spins and their decay, the height of
    cushions. Frictions and restitutions have none.

    Raises
    ------
    GhostballError
        Where a law has a constant with a unit that isn't a field.
    """
    x, t, m = 2.0**length, 2.0**time, 2.0**mass
    physics = scene.physics
    if physics.ball_friction == "alciatore" or physics.air_drag != 0.0:
        raise GhostballError("a law with constants of its own can't be scaled")
    balls = []
    for ball in scene.balls:
        fields = ball.model_dump(exclude_none=True)
        fields["position"] = tuple(x * c for c in ball.position)
        fields["velocity"] = tuple(x / t * c for c in ball.velocity)
        fields["radius"] = x * ball.radius
        fields["mass"] = m * ball.mass
        if ball.angular_velocity is not None:
            fields["angular_velocity"] = tuple(c / t for c in ball.angular_velocity)
        if ball.spinning_friction_rate is not None:
            fields["spinning_friction_rate"] = ball.spinning_friction_rate / t**2
        balls.append(fields)
    table = scene.table
    return Scene.model_validate(
        scene.model_dump(exclude_none=True)
        | {
            "balls": balls,
            "t_max": None if scene.t_max is None else t * scene.t_max,
            "table": table
            and table.model_dump() | {"length": x * table.length, "width": x * table.width},
            "physics": physics.model_dump()
            | {
                "gravity": physics.gravity * x / t**2,
                "spinning_friction_rate": physics.spinning_friction_rate / t**2,
            }
            | (
                {"cushion_height": x * physics.cushion_height}
                if physics.cushion in ("han2005", "mathavan2010")
                else {}
            ),
        }
    )
