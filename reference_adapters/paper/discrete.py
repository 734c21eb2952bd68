"""The paper's first attempt, section 3.1: fixed steps that react to overlaps after the fact.

As printed
----------
Each step moves every ball (semi-implicit Euler, 4.1, with the friction of 5.2). Then, "if a frame
is rendered where two balls intersect, simply pull them apart and perform the collision" (4.2). A
ball that passes through another between two frames is never seen, and one that is seen already
overlaps by much: the clipping of the paper's Figure 2.

Completions, where the print is silent
--------------------------------------
- How far and which: each ball of a pair is moved half of the overlap along the line of centres.
- Order: pairs (0, 1), (0, 2), ... (n - 2, n - 1), once a step, each pulled and collided before the
  next is looked at. A pull may push a ball into a third: that pair waits for its turn, or for the
  next step. The paper says of this that it "becomes overly complex and can fail or worse cause
  collisions that shouldn't have happened"; nothing here prevents that.
- Which way they move: nothing in the print asks, so by default neither does the engine, and a pair
  pulled apart while already separating is turned to approach. `react="approaching"` asks.
- Centres that coincide have no line to be pulled along: the pair is left for the next step, and
  counted in `work`.
- Cushions, after the pairs: a ball that reaches beyond one is put back to touch it and its velocity
  flips (4.2), by the same `react`.
- Rest: a ball that friction would turn round within a step is stopped (`stop`, see `paper.model`).
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

    `dt` [s]: the time step; the paper's is 20 ms.
    `react`: which intersecting pairs collide: all, as printed, or only those that approach.
    `stop`: what ends a roll; "never" is as printed: no ball ever rests.
    `max_time` [s]: simulated time after which the run gives up.
    """

    dt: Annotated[float, Field(gt=0.0)] = 0.02
    react: Literal["always", "approaching"] = "always"
    stop: Stop = "reversal"
    max_time: Annotated[float, Field(gt=0.0)] = 600.0


class PaperDiscreteEngine(EngineBase):
    """Fixed steps; pull overlapping balls apart, then collide them (the paper, section 3.1)."""

    name: ClassVar[str] = "paper-discrete"
    Settings: ClassVar[type[EngineSettings]] = PaperDiscreteSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "paper-discrete")

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented with these settings."""
        return self.CAPABILITIES["always"]

    def resolution(self, scene: Scene) -> float:
        """Return how far a ball goes in a step [m]."""
        return resolution_of_step(self.settings.dt, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene.

        Raises `UnsupportedSceneError` where the scene needs a feature that the engine lacks.
        """
        self.check(scene)
        settings: PaperDiscreteSettings = self.settings
        return _Run(scene, settings, record).result(self.name, settings.model_dump())


class _Run(PaperRun):
    """One run: what a step does to the balls."""

    def __init__(self, scene: Scene, settings: PaperDiscreteSettings, record: Record) -> None:
        super().__init__(
            scene, record, dt=settings.dt, stop=settings.stop, max_time=settings.max_time
        )
        self._react = settings.react
        self._seen_overlap = False
        self._counts = {"pulls": 0, "put_backs": 0, "coincident_pairs": 0}

    @property
    def work(self) -> dict[str, int]:
        """Counters of what was done."""
        return {"steps": self.frames, "pair_checks": self.balls.pair_checks, **self._counts}

    def advance_frame(self, t: float) -> None:
        """Make one step, to `t` [s]."""
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
        """Keep the frame as the paper renders it, balls inside each other, once a step."""
        if not self._seen_overlap and self.recorder.record == "trajectory":
            self.recorder.frame(self.t, self.balls.samples(), force=True)
        self._seen_overlap = True
