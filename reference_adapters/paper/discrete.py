"""The paper's first algorithm, section 3.1: fixed time steps, overlaps resolved afterwards.

As printed
----------
Each step moves every ball (semi-implicit Euler, 4.1, with the friction of 5.2). Then, "if a frame
is rendered where two balls intersect, simply pull them apart and perform the collision" (4.2). A
ball that passes through a different ball between two frames isn't detected, and detected balls
already have a large overlap: the clipping of the paper's Figure 2.

Completions, where the paper says nothing
-----------------------------------------
- Distance: each ball of a pair is moved by half of the overlap along the line of centres.
- Order: pairs (0, 1), (0, 2), ... (n - 2, n - 1), once per step; each pair is separated and
  collided before the next pair is checked. Separating a pair may push a ball into a third ball:
  that pair waits for its turn, or for the next step. The paper says that this "becomes overly
  complex and can fail or worse cause collisions that shouldn't have happened"; nothing here
  prevents that.
- Direction of motion: the paper doesn't check it, so by default neither does this engine, and a
  separating pair that is pulled apart is turned to approach. `react="approaching"` checks it.
- Coincident centres have no line of centres: the pair is left for the next step, and counted in
  `work`.
- Cushions, after the pairs: a ball beyond a cushion is moved back to contact and its velocity is
  reversed (4.2), with the same `react`.
- Rest: a ball that friction would reverse within a step is stopped (`stop`, see `paper.model`).
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from ghostball.model import EventKind, Record, Result, Scene
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineBase, EngineSettings, resolution_of_step
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.paper.model import PaperRun, Stop


class PaperDiscreteSettings(EngineSettings):
    """Settings of `PaperDiscreteEngine`.

    `dt`: the time step; the paper's is 20 ms [s].
    `react`: which overlapping pairs collide: all, as printed, or only approaching pairs.
    `stop`: what ends a roll; with "never", as printed, no ball comes to rest.
    `max_time`: simulated time after which the run stops [s].
    """

    dt: Annotated[float, Field(gt=0.0)] = 0.02
    react: Literal["always", "approaching"] = "always"
    stop: Stop = "reversal"
    max_time: Annotated[float, Field(gt=0.0)] = 600.0


class PaperDiscreteEngine(EngineBase):
    """Fixed steps that separate overlapping balls and then collide them (section 3.1)."""

    name: ClassVar[str] = "paper-discrete"
    Settings: ClassVar[type[EngineSettings]] = PaperDiscreteSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "paper-discrete")

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is supported with these settings."""
        return self.CAPABILITIES["always"]

    def resolution(self, scene: Scene) -> float:
        """Return the distance that a ball moves in a step [m]."""
        return resolution_of_step(self.settings.dt, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene.

        Raises `UnsupportedSceneError` if the scene needs a feature that the engine lacks.
        """
        self.check(scene)
        settings: PaperDiscreteSettings = self.settings
        return DiscreteRun(scene, settings, record).result(self.name, settings.model_dump())


class DiscreteRun(PaperRun):
    """One run of the discrete algorithm."""

    def __init__(self, scene: Scene, settings: PaperDiscreteSettings, record: Record) -> None:
        super().__init__(
            scene, record, dt=settings.dt, stop=settings.stop, max_time=settings.max_time
        )
        self._react = settings.react
        self._seen_overlap = False
        self._counts = {"pulls": 0, "put_backs": 0, "coincident_pairs": 0}

    @property
    def work(self) -> dict[str, int]:
        """Counters of operations."""
        return {"steps": self.frames, "pair_checks": self.balls.pair_checks, **self._counts}

    def advance_frame(self, t: float) -> None:
        """Advance by one step, to `t` [s]."""
        balls, recorder = self.balls, self.recorder
        balls.advance(t - self.t)
        self.t = t
        balls.record_rests(recorder, t)
        self._seen_overlap = False
        self._react_to_balls()
        self._react_to_cushions()
        balls.record_rests(recorder, t)
        if recorder.wants_frame(t):
            recorder.frame(t, balls.samples())

    def _react_to_balls(self) -> None:
        balls = self.balls
        for i in range(len(balls) - 1):
            for j in range(i + 1, len(balls)):
                gap = balls.gap(i, j)
                if gap >= 0.0:
                    continue
                self._record_overlap()
                if balls.x[i] == balls.x[j] and balls.y[i] == balls.y[j]:
                    self._counts["coincident_pairs"] += 1
                    continue
                self._separate(i, j, -gap)
                if self._react == "always" or balls.approaching(i, j):
                    balls.collide(i, j)
                    self.recorder.event(self.t, EventKind.BALL_BALL, i, j)

    def _separate(self, i: int, j: int, overlap: float) -> None:
        balls = self.balls
        sx, sy = balls.x[i] - balls.x[j], balls.y[i] - balls.y[j]
        half = 0.5 * overlap / math.hypot(sx, sy)
        balls.x[i] += half * sx
        balls.y[i] += half * sy
        balls.x[j] -= half * sx
        balls.y[j] -= half * sy
        self._counts["pulls"] += 1

    def _react_to_cushions(self) -> None:
        balls = self.balls
        for i in range(len(balls)):
            for cushion, overlap in balls.cushion_overlaps(i):
                if overlap <= 0.0:
                    continue
                self._record_overlap()
                inwards = overlap if cushion % 2 == 0 else -overlap
                if cushion < 2:
                    balls.x[i] += inwards
                else:
                    balls.y[i] += inwards
                self._counts["put_backs"] += 1
                if self._react == "always" or balls.leaving(i, cushion):
                    balls.flip(i, cushion)
                    self.recorder.event(self.t, EventKind.BALL_CUSHION, i, cushion)

    def _record_overlap(self) -> None:
        """Store the frame as the paper renders it, with overlapping balls, once per step."""
        if not self._seen_overlap and self.recorder.record == "trajectory":
            self.recorder.frame(self.t, self.balls.samples(), force=True)
        self._seen_overlap = True
