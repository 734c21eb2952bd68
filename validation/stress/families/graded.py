"""Graded: shots of all physics that can be proved, and how a run compares with the proof."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.validation.scenes.gases import FRICTIONLESS, FULL_CLOTH, packed_gas
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import PROVABLE
from ghostball.validation.stress.proved import MatchesProof, ProvedTrial
from ghostball.validation.stress.random_trials import RandomScenes
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict

PROOF = CertifiedSettings(max_events=500, max_precision=848)
"""How far a random shot is proved: a few have thousands of events, or bits."""

SHIPPED = (
    "stop",
    "head-on",
    "half-ball-cut",
    "three-ball-chain",
    "wall-bounce",
    "restitution-cut",
    "unequal-balls",
    "corner-double-bounce",
    "cradle",
    "galperin-1",
    "sliding-swerve",
    "draw-shot",
    "masse",
    "cue-masse",
    "english-check",
    "han-running",
    "three-cushions",
    "throw-slip",
    "throw-stick",
    "throw-alciatore",
    "gearing",
    "frozen-to-cushion",
    "frozen-triangle",
    "break-7",
    "chaos-a",
    "pool-break-9",
    "flight-jump",
    "cue-jump",
    "flight-leaves",
    "pocket-jump",
)
"""The shipped scenes that are graded here: each law and way of moving, from one ball to breaks."""

BATCH = 10
"""Random shots in a trial."""

QUICK_SHOTS, FULL_SHOTS = 100, 3_000

LEAST_PROVED = 5
"""Of the random shots in a trial, how many must be proved to their ends.

Others are proved up to a contact that lasts, a tie, or bounces that no precision follows.
"""

PARTLY_PROVED = {"frozen-triangle": 1}
"""Events that are proved of the shipped scenes here whose proof ends early, in a tie."""


@dataclass(frozen=True)
class ProvedScenes(RandomScenes):
    """Random shots, each graded against its proof, of which `LEAST_PROVED` must go to the end."""

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play and judge them; the verdict shows the shot that came off worst."""
        found = [self._judged(engine, scene) for scene in self.examples()]
        verdict = Verdict.of_all(found)
        whole = sum(bool(one.values.get("proved")) for one in found)
        if whole >= LEAST_PROVED or verdict.broken:
            return verdict
        few = f"only {whole} of these shots are proved to their ends, {LEAST_PROVED} must be"
        return replace(verdict, faults=(few,), severity=1.0, broken=1)


def _odd_shots() -> Iterator[Scene]:
    """Yield shots in which the cloth does what it seldom does."""
    table = Table(length=2.54, width=1.27)
    thrown_back = Ball(
        id="cue", position=(0.06, 0.3), velocity=(0.3, 0.05), angular_velocity=(0.0, -250.0, 0.0)
    )
    # With so much backspin that it comes back, still sliding, to the cushion that it left.
    yield Scene(
        name="thrown-back",
        table=table,
        physics=Physics(motion="sliding", sliding_friction=0.2),
        balls=[thrown_back],
    )
    # A ball whose spin the cloth still changes rubs against another one.
    yield Scene(
        name="hit-while-sliding",
        physics=Physics(preset="pool"),
        balls=[
            Ball(
                id="cue",
                position=(0.6, 0.4),
                velocity=(1.2, 0.9),
                angular_velocity=(60.0, -40.0, 30.0),
            ),
            Ball(id="1", position=(0.86, 0.6)),
        ],
    )


def _trials(suite: Suite) -> Iterator[Trial]:
    for name in SHIPPED:
        yield ProvedTrial(name, find_scene(name), PARTLY_PROVED.get(name))
    for scene in _odd_shots():
        yield ProvedTrial(scene.name, scene)
    for kind, physics in (("elastic", FRICTIONLESS), ("sliding", FULL_CLOTH)):
        for number in range(1 if suite == "quick" else 10):
            # So many that only neighbours are looked at.
            scene = packed_gas(110, 0.3, physics, t_max=0.03, seed=number)
            yield ProvedTrial(f"many-balls-{kind}-{number}", scene)
    for first in range(0, QUICK_SHOTS if suite == "quick" else FULL_SHOTS, BATCH):
        judge = MatchesProof(PROOF, least=0, cached=first < QUICK_SHOTS)
        yield ProvedScenes(
            f"shots-{first:04d}+{BATCH}", judge, first, BATCH, tuple(PROVABLE.items())
        )
    shaped = tuple({**PROVABLE, "table": ("polygon", "pockets", "posts")}.items())
    over = (*shaped, ("flight", ("low", "jump", "drop", "on-top")))
    for first in range(0, BATCH if suite == "quick" else FULL_SHOTS // 4, BATCH):
        judge = MatchesProof(PROOF, least=0, cached=first < BATCH)
        yield ProvedScenes(f"shapes-{first:04d}+{BATCH}", judge, first, BATCH, shaped)
        yield ProvedScenes(f"over-shapes-{first:04d}+{BATCH}", judge, first, BATCH, over)


FAMILY = Family(
    "graded",
    "Shots against their proofs",
    "Every event that interval arithmetic proves happens, in that order, no other does, and the "
    "balls end within 32 roundings of the state per event; as far as the proof goes, and the shot "
    "can be predicted in double precision.",
    _trials,
    ours_alone=True,
)
