"""The paper's final algorithm, section 3.2: frames advanced from collision to collision.

As printed (Algorithm 1)
------------------------
In a frame of 20 ms, until its time has elapsed: find the shortest time to a collision over all
pairs, advance the simulation by this time, solve the collisions "at this instant" for all pairs,
add the time.

- The search skips separating pairs, s.v >= 0 (section 2), and assumes straight lines:
  t = (s.v - sqrt(D)) / v^2 with the relative position s and the relative velocity v.
- "Advance" is the kinematics of 4.1 with the friction of 5.2; "solve" is the formula of 4.2.

Completions, where the paper says nothing or can't be executed
--------------------------------------------------------------
- The search requires s.v < 0 for approaching balls, but then the printed t is never positive. Its
  first term lacks the minus sign of Kent's article, the paper's source. Here both use the same sign
  of s.v, and D = (s.v)^2 - v^2 (s^2 - r^2) with the sum r of the radii.
- As printed, a frame without a collision never advances. Here the shortest time is initially the
  rest of the frame, so such a frame is one plain step.
- A time in the past is no "time to next collision" and is ignored. Two overlapping balls are
  therefore never found again: they pass through each other. Kent returns the time 0 for overlapping
  balls, but the paper prints no such rule; `overlaps="collide"` adds it, for comparison.
- The pairs that collide "at this instant" are approaching pairs with a gap of at most `tolerance`,
  of either sign. The default is a few roundings of single-precision coordinates on a table, because
  the paper uses `float`.
- Algorithm 1 doesn't search for cushions. By default, a ball beyond a cushion is detected at the
  next step, up to v times a frame late, and its velocity is reversed (4.2) if it still moves
  outwards; its position isn't corrected. `cushions="searched"` adds the cushions to the search, for
  comparison.
- Ball i meets its cushions, then balls 0 .. n - 1, so each pair is solved twice; the second time it
  is found to separate.
- Rest: a ball that friction would reverse within a step is stopped (`stop`, see `paper.model`).
- Balls that push each other within rounding can stop the clock forever; `max_events` ends such
  runs.

Why collisions are missed
-------------------------
The paper "tends to miss a collision here or there" with 16 balls, and found "very little issues"
with 8. The search ignores friction, but the advance doesn't. Usually the balls then arrive short of
contact by up to mu g t^2, and the next search corrects this. If the ball in front loses more speed
along the line of centres than the ball behind (both move, the latter at an angle), they arrive with
an overlap of a few micrometres: too large for "this instant", and in the past for every later
search. Without cloth friction no collision is missed. In 40 random breaks at 6 m/s, 1.5 collisions
are missed in a break of 16 balls and 0.8 in a break of 8; at 3 m/s, 0.2 and 0.03.

`work["overlaps"]` counts how often a pair starts to overlap by more than `tolerance`: with the
printed algorithm, these are the missed collisions. The search computes every distance anyway, so
counting doesn't change the results.
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

    `frame`: the paper's `deltaTime`, 20 ms [s].
    `tolerance`: gap, of either sign, up to which balls touch "at this instant" [m]. It can't be 0:
        rounding would leave balls just short of contact, with no time left to advance.
    `overlaps`: balls with a larger overlap pass through each other, as printed ("ignored"), or
        collide if they approach, as in the paper's source ("collide").
    `cushions`: whether the search includes cushions; as printed it doesn't ("late").
    `stop`: what ends a roll; with "never", as printed, no ball comes to rest.
    `max_time`: simulated time after which the run stops [s].
    `max_events`: number of steps after which the run stops.
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
        """How each feature of a scene is supported with these settings."""
        searched = self.settings.cushions == "searched"
        return self.CAPABILITIES["searched" if searched else "late"]

    def resolution(self, scene: Scene) -> float:
        """Return the largest position error at a detected contact [m].

        For balls, this is the effect of friction in a frame, which the search ignores; for
        cushions, the distance that a ball moves in a frame, unless cushions are searched.
        """
        settings: PaperContinuousSettings = self.settings
        braked = float(np.max(scene.rolling_frictions)) * scene.physics.gravity * settings.frame**2
        if settings.cushions == "searched" or scene.table is None or not scene.table.cushions:
            return settings.tolerance + braked
        return resolution_of_step(settings.frame, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate the scene.

        Raises `UnsupportedSceneError` if the scene needs a feature that the engine lacks.
        """
        self.check(scene)
        settings: PaperContinuousSettings = self.settings
        return ContinuousRun(scene, settings, record).result(self.name, settings.model_dump())


class ContinuousRun(PaperRun):
    """One run of the continuous algorithm."""

    def __init__(self, scene: Scene, settings: PaperContinuousSettings, record: Record) -> None:
        super().__init__(
            scene, record, dt=settings.frame, stop=settings.stop, max_time=settings.max_time
        )
        self._settings = settings
        self._counts = {"steps": 0, "early_outs": 0, "square_roots": 0, "overlaps": 0}
        self._overlapping: set[tuple[int, int]] = set()

    @property
    def work(self) -> dict[str, int]:
        """Counters of operations."""
        return {"frames": self.frames, "pair_checks": self.balls.pair_checks, **self._counts}

    @property
    def limit_reached(self) -> str:
        """The limit that the run has reached, except a time limit; "" if none."""
        if self._counts["steps"] < self._settings.max_events:
            return ""
        return f"{self._settings.max_events} steps (`max_events`) by t = {self.t} s"

    def advance_frame(self, t: float) -> None:
        """Run Algorithm 1 from the present time, the start of the frame, to its end at `t` [s]."""
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
        """Return the shortest time to a collision [s]; inf if there is none."""
        balls = self.balls
        shortest = math.inf
        # The printed loops visit each pair twice; the second visit doesn't change the minimum.
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
        """Count a pair once each time that it starts to overlap."""
        if not overlap:
            self._overlapping.discard((i, j))
        elif (i, j) not in self._overlapping:
            self._overlapping.add((i, j))
            self._counts["overlaps"] += 1

    def _solve_collisions(self) -> bool:
        """Solve the present collisions; return whether there was one."""
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
        # Always stored: frames are few, and the states before and after collisions are important.
        if self.recorder.record == "trajectory":
            self.recorder.frame(self.t, self.balls.samples(), force=True)
