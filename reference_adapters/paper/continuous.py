"""The paper's final system, section 3.2: Algorithm 1, frames advanced from collision to collision.

As printed
----------
A frame of 20 ms: until its time has elapsed, find the shortest time to collision over all pairs,
advance the simulation by it, solve the collisions "at this instant" for all pairs, add the time.

- The search skips pairs with s.v >= 0, which separate (section 2), and takes straight lines:
  t = (s.v - sqrt(D)) / v^2 of the relative position s and velocity v.
- "Advance" is the kinematics of 4.1 with the friction of 5.2; "solve" is the formula of 4.2.

Completions, where the print is silent or can't run
---------------------------------------------------
- The early-out wants s.v < 0 where balls approach, and then the printed t is never positive: its
  first term lost a minus sign, which Kent's article, the paper's source, has. Here s.v has one sign
  in both, and D = (s.v)^2 - v^2 (s^2 - r^2), r the sum of the radii.
- As printed a frame without a collision never advances. The shortest time starts at what is left of
  the frame, so that such a frame is one plain step.
- A time in the past is no "time to next collision" and is passed over. So two balls that overlap
  are never found again: they go through each other. Kent returns time 0 for balls that overlap, but
  the paper prints no such rule; `overlaps="collide"` adds it, for comparison.
- "At this instant" collide the pairs that approach with a gap of at most `tolerance` either way.
  Its default is a few single-precision roundings of a table's coordinates: the print has `float`.
- Algorithm 1 searches no cushions. By default a ball is found beyond one at the next instant, up to
  v times a frame late, and its velocity flips (4.2) where it still moves outwards; nothing puts it
  back. `cushions="searched"` adds the times of impact to the search, for comparison.
- Ball i meets its cushions, then balls 0 .. n - 1, so each pair is solved twice; the second time
  finds it separating.
- Rest: a ball that friction would turn round within a step is stopped (`stop`, see `paper.model`).
- Balls that push each other at the limit of rounding can hold the clock for ever; `max_events`
  ends such a run.

Why it misses collisions ------------------------ The paper "tends to miss a collision here or
there" with 16 balls, and found "very little issues" with 8. The search is blind to friction, the
advance is not. Mostly the balls then arrive short of each other by up to mu g t^2, and the next
search makes up for it. But where the ball in front loses more speed along the line of centres than
the one behind (both move, the one behind at a slant), they arrive overlapping by some micrometres:
by too much for "this instant", and in the past for every later search. On a cloth without friction
none is missed. Over 40 random breaks at 6 m/s it misses 1.5 collisions in a break of 16 balls and
0.8 in one of 8; at 3 m/s, 0.2 and 0.03.

`work["overlaps"]` counts how often a pair came to overlap by more than `tolerance`: as printed, the
collisions missed. The search looks at every distance in any case, so counting alters nothing.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from ghostball.model import EventKind, Record, Result, Scene
from ghostball.model.features import Capabilities
from ghostball.reference_adapters.base import EngineBase, EngineSettings, resolution_of_step
from ghostball.reference_adapters.capabilities import ByConfiguration, capabilities_beside
from ghostball.reference_adapters.paper.model import PaperRun, Stop


class PaperContinuousSettings(EngineSettings):
    """Settings of `PaperContinuousEngine`.

    `frame` [s]: the paper's `deltaTime`: 20 ms.
    `tolerance` [m]: gap, of either sign, up to which balls touch "at this instant". Never 0:
        rounding would leave balls just short of touching, with no time left to advance by.
    `overlaps`: what balls that overlap by more do: continue through each other, as printed, or
        collide where they approach, as in the paper's source.
    `cushions`: whether the search looks at cushions too; as printed it doesn't.
    `stop`: what ends a roll; "never" is as printed: no ball ever rests.
    `max_time` [s]: simulated time after which the run gives up.
    `max_events`: steps after which the run gives up.
    """

    frame: Annotated[float, Field(gt=0.0)] = 0.02
    tolerance: Annotated[float, Field(gt=0.0)] = 1e-6
    overlaps: Literal["ignored", "collide"] = "ignored"
    cushions: Literal["late", "searched"] = "late"
    stop: Stop = "reversal"
    max_time: Annotated[float, Field(gt=0.0)] = 600.0
    max_events: Annotated[int, Field(gt=0)] = 100_000


class PaperContinuousEngine(EngineBase):
    """Frames advanced from collision to collision (the paper, Algorithm 1)."""

    name: ClassVar[str] = "paper-continuous"
    Settings: ClassVar[type[EngineSettings]] = PaperContinuousSettings
    CAPABILITIES: ClassVar[ByConfiguration] = capabilities_beside(__file__, "paper-continuous")

    @property
    def capabilities(self) -> Capabilities:
        """How each feature of a scene is represented with these settings."""
        searched = self.settings.cushions == "searched"
        return self.CAPABILITIES["searched" if searched else "late"]

    def resolution(self, scene: Scene) -> float:
        """Return how far off a contact is seen [m].

        Of balls, by what friction brakes in a frame, which the search leaves out; of cushions, by
        how far a ball goes in one, unless they are searched.
        """
        settings: PaperContinuousSettings = self.settings
        braked = float(np.max(scene.rolling_frictions)) * scene.physics.gravity * settings.frame**2
        if settings.cushions == "searched" or scene.table is None or not scene.table.cushions:
            return settings.tolerance + braked
        return resolution_of_step(settings.frame, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene.

        Raises `UnsupportedSceneError` where the scene needs a feature that the engine lacks.
        """
        self.check(scene)
        settings: PaperContinuousSettings = self.settings
        return _Run(scene, settings, record).result(self.name, settings.model_dump())


class _Run(PaperRun):
    """One run: what a frame does to the balls."""

    def __init__(self, scene: Scene, settings: PaperContinuousSettings, record: Record) -> None:
        super().__init__(
            scene, record, dt=settings.frame, stop=settings.stop, max_time=settings.max_time
        )
        self._settings = settings
        self._counts = {"steps": 0, "early_outs": 0, "square_roots": 0, "overlaps": 0}
        self._overlapping: set[tuple[int, int]] = set()

    @property
    def work(self) -> dict[str, int]:
        """Counters of what was done."""
        return {"frames": self.frames, "pair_checks": self.balls.pair_checks, **self._counts}

    @property
    def limit_reached(self) -> str:
        """Which limit other than of time the run has reached, or nothing."""
        if self._counts["steps"] < self._settings.max_events:
            return ""
        return f"{self._settings.max_events} steps (`max_events`) by t = {self.t} s"

    def advance_frame(self, t: float) -> None:
        """Algorithm 1, from the frame's start, now, to its end at `t` [s]."""
        t_start, t_end = self.t, t
        delta_time = t_end - t_start
        elapsed = 0.0
        while elapsed < delta_time and self.balls.moving and not self.limit_reached:
            self._counts["steps"] += 1
            remaining = delta_time - elapsed
            shortest = min(remaining, self._shortest_time())
            self.balls.advance(shortest)
            elapsed += shortest
            self.t = t_end if shortest == remaining else t_start + elapsed
            self.balls.record_rests(self.recorder, self.t)
            self._keep_frame()
            if self._solve_collisions():
                self.balls.record_rests(self.recorder, self.t)
                self._keep_frame()

    def _shortest_time(self) -> float:
        """Return the shortest time to a collision [s]; infinite where there is none."""
        balls = self.balls
        shortest = math.inf
        # The printed loops visit each pair twice; the second visit can't change the minimum.
        for i in range(len(balls) - 1):
            for j in range(i + 1, len(balls)):
                shortest = min(shortest, self._time_to_collision(i, j))
        if self._settings.cushions == "searched":
            for i in range(len(balls)):
                shortest = min(shortest, balls.time_to_cushion(i))
        return shortest

    def _time_to_collision(self, i: int, j: int) -> float:
        balls, settings = self.balls, self._settings
        balls.pair_checks += 1
        sx, sy = balls.x[i] - balls.x[j], balls.y[i] - balls.y[j]
        vx, vy = balls.vx[i] - balls.vx[j], balls.vy[i] - balls.vy[j]
        r = balls.radii[i] + balls.radii[j]
        outside = sx * sx + sy * sy - r * r
        self._count_overlap(i, j, outside < 0.0 and balls.gap(i, j) < -settings.tolerance)
        closing = sx * vx + sy * vy
        if closing >= 0.0:
            self._counts["early_outs"] += 1
            return math.inf
        if outside < 0.0 and settings.overlaps == "collide":
            return 0.0
        speed2 = vx * vx + vy * vy
        discriminant = closing * closing - speed2 * outside
        if discriminant < 0.0:
            return math.inf
        self._counts["square_roots"] += 1
        t = (-closing - math.sqrt(discriminant)) / speed2
        return t if t >= 0.0 else math.inf

    def _count_overlap(self, i: int, j: int, overlap: bool) -> None:
        """Count a pair once each time that it comes to overlap."""
        if not overlap:
            self._overlapping.discard((i, j))
        elif (i, j) not in self._overlapping:
            self._overlapping.add((i, j))
            self._counts["overlaps"] += 1

    def _solve_collisions(self) -> bool:
        """Solve the collisions at this instant, and say whether there was one."""
        balls, recorder, tolerance = self.balls, self.recorder, self._settings.tolerance
        most = tolerance if self._settings.overlaps == "ignored" else math.inf
        solved = False
        for i in range(len(balls)):
            for cushion, overlap in balls.cushion_overlaps(i):
                if overlap >= -tolerance and balls.leaving(i, cushion):
                    balls.flip(i, cushion)
                    recorder.event(self.t, EventKind.BALL_CUSHION, i, cushion)
                    solved = True
            for j in range(len(balls)):
                if j != i and -most <= balls.gap(i, j) <= tolerance and balls.approaching(i, j):
                    balls.collide(i, j)
                    recorder.event(self.t, EventKind.BALL_BALL, i, j)
                    solved = True
        return solved

    def _keep_frame(self) -> None:
        # Always: frames are few, and the instants before and after a collision are what matters.
        if self.recorder.record == "trajectory":
            self.recorder.frame(self.t, self.balls.samples(), force=True)
