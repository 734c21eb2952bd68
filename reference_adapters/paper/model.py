"""The paper's model of billiards, as printed, for both of its algorithms.

Kinematics (section 4.1), ball-ball and ball-cushion collisions (4.2) and friction (5.2) are exactly
as printed. Where the paper says nothing or can't be executed, the choice made here is marked
"Completion". The order of the operations is that of the algorithms, `paper.discrete` and
`paper.continuous`.

Numbers are plain Python floats: the paper visits one pair after another, and each may move the
next, so vectorisation is impossible, and floats are several times faster than numpy scalars.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np

from ghostball.model import (
    CUSHIONS,
    EventKind,
    Record,
    Result,
    Samples,
    Scene,
    Status,
    rolling_angular_velocity,
)
from ghostball.reference_adapters.recording import Recorder

Stop = Literal["reversal", "never"]
"""What ends a roll: "reversal" stops a ball that friction would reverse; "never" is as printed."""


class PaperBalls:
    """The state of every ball, and the operations of the paper that change it.

    `x`, `y`: centres [m]. The height never changes: the paper has no z (section 6.4).
    `vx`, `vy`: velocities [m/s].
    `radii`, `masses`: [m] and [kg].
    `pair_checks`: number of computed distances of pairs, for `Result.work`.
    """

    def __init__(self, scene: Scene, stop: Stop) -> None:
        positions, velocities = scene.positions, scene.velocities
        self.x: list[float] = positions[:, 0].tolist()
        self.y: list[float] = positions[:, 1].tolist()
        self.vx: list[float] = velocities[:, 0].tolist()
        self.vy: list[float] = velocities[:, 1].tolist()
        self.radii: list[float] = scene.radii.tolist()
        self.masses: list[float] = scene.masses.tolist()
        self.pair_checks = 0
        self._moved = [ball.speed > 0.0 for ball in scene.balls]
        self._height = positions[:, 2]
        self._stop = stop
        # 5.2 sets the acceleration to the friction *force* mu m g, because its masses are 1 (4.2).
        self._deceleration = scene.physics.rolling_friction * scene.physics.gravity
        self._cushions = _cushion_planes(scene)

    def __len__(self) -> int:
        return len(self.x)

    @property
    def moving(self) -> bool:
        """Whether a ball has a velocity other than exactly 0."""
        return any(self.vx) or any(self.vy)

    def samples(self) -> Samples:
        """Return the state, arrays (1, n, 3); the spin is v / R about the rolling axis (5.3)."""
        positions = np.column_stack((self.x, self.y, self._height))
        velocities = np.column_stack((self.vx, self.vy, np.zeros(len(self))))
        spin = rolling_angular_velocity(velocities, np.array(self.radii))
        return Samples(positions[np.newaxis], velocities[np.newaxis], spin[np.newaxis])

    def record_rests(self, recorder: Recorder, t: float) -> None:
        """Record at `t` [s] each ball that moved at the previous call and is at rest now.

        Call after friction and again after the collisions at the same time: either may stop a ball,
        and a ball that passes on an impulse at once never moved.
        """
        for i, moved in enumerate(self._moved):
            moves = self.vx[i] != 0.0 or self.vy[i] != 0.0
            if moved and not moves:
                recorder.event(t, EventKind.ROLL_TO_REST, i)
            self._moved[i] = moves

    def advance(self, dt: float) -> None:
        """Move every ball by `dt` [s].

        4.1: v(t) = v0 + a dt, then s(t) = s0 + v(t) dt with the new v (semi-implicit Euler), with a
        = -mu g v/|v| if |v| > 0 (5.2). A ball that slows is mu g dt^2 / 2 short after each step: v0
        dt / 2 over a whole roll.

        Completion: as printed, no ball comes to rest. Once |v| < mu g dt, friction reverses the
        ball in each step: its speed alternates between |v| and mu g dt - |v|, and it continues
        forever at up to mu g dt / 2 (2 mm/s at 20 ms). With stop="reversal", a step that would
        reverse the ball stops it.
        """
        x, y, vx, vy = self.x, self.y, self.vx, self.vy
        loss = self._deceleration * dt
        for i in range(len(x)):
            speed = math.hypot(vx[i], vy[i])
            if speed > 0.0:
                if loss >= speed and self._stop == "reversal":
                    vx[i] = vy[i] = 0.0
                    continue
                vx[i] -= loss * vx[i] / speed
                vy[i] -= loss * vy[i] / speed
                x[i] += vx[i] * dt
                y[i] += vy[i] * dt

    def approaching(self, i: int, j: int) -> bool:
        """Return whether s.v < 0; the paper treats 0 and above as separating (section 2)."""
        sx, sy = self.x[i] - self.x[j], self.y[i] - self.y[j]
        return sx * (self.vx[i] - self.vx[j]) + sy * (self.vy[i] - self.vy[j]) < 0.0

    def gap(self, i: int, j: int) -> float:
        """Return the distance between two surfaces [m]; negative if the balls overlap."""
        self.pair_checks += 1
        distance = math.hypot(self.x[i] - self.x[j], self.y[i] - self.y[j])
        return distance - (self.radii[i] + self.radii[j])

    def collide(self, i: int, j: int) -> None:
        """Exchange momentum by the angle-free elastic formula of section 4.2.

        v1' = v1 - 2 m2/(m1 + m2) ((v1 - v2).(x1 - x2)) / |x1 - x2|^2 (x1 - x2), and the same with 1
        and 2 swapped. Nothing is checked: separating balls are turned to approach. The centres must
        differ.
        """
        sx, sy = self.x[i] - self.x[j], self.y[i] - self.y[j]
        dot = sx * (self.vx[i] - self.vx[j]) + sy * (self.vy[i] - self.vy[j])
        scale = 2.0 * dot / (sx * sx + sy * sy)
        total = self.masses[i] + self.masses[j]
        share_i, share_j = self.masses[j] / total, self.masses[i] / total
        self.vx[i] -= share_i * scale * sx
        self.vy[i] -= share_i * scale * sy
        self.vx[j] += share_j * scale * sx
        self.vy[j] += share_j * scale * sy

    def cushion_overlaps(self, i: int) -> Iterator[tuple[int, float]]:
        """Yield the index of each cushion and the distance of ball `i` beyond it [m]."""
        for cushion, place in self._cushions:
            centre = self.x[i] if cushion < 2 else self.y[i]
            if cushion % 2 == 0:
                yield cushion, self.radii[i] - centre
            else:
                yield cushion, centre + self.radii[i] - place

    def leaving(self, i: int, cushion: int) -> bool:
        """Return whether ball `i` moves outwards through `cushion`."""
        velocity = self.vx[i] if cushion < 2 else self.vy[i]
        return velocity < 0.0 if cushion % 2 == 0 else velocity > 0.0

    def time_to_cushion(self, i: int) -> float:
        """Return the time until ball `i` meets a cushion, at constant velocity [s], or inf."""
        times = (
            -overlap / abs(self.vx[i] if cushion < 2 else self.vy[i])
            for cushion, overlap in self.cushion_overlaps(i)
            if overlap <= 0.0 and self.leaving(i, cushion)
        )
        return min(times, default=math.inf)

    def flip(self, i: int, cushion: int) -> None:
        """Reverse the component of the velocity normal to `cushion` (section 4.2, Figure 3)."""
        if cushion < 2:
            self.vx[i] = -self.vx[i]
        else:
            self.vy[i] = -self.vy[i]


def _cushion_planes(scene: Scene) -> list[tuple[int, float]]:
    if scene.table is None:
        return []
    places = (0.0, scene.table.length, 0.0, scene.table.width)
    return [(CUSHIONS.index(name), places[CUSHIONS.index(name)]) for name in scene.table.cushions]


class PaperRun(ABC):
    """One run of either algorithm: its balls, its clock, and its end.

    `dt`: length of a frame [s].
    `stop`: what ends a roll.
    `max_time`: simulated time after which the run stops [s].

    `t`: present time [s].
    `frames`: number of frames started so far.
    """

    def __init__(
        self, scene: Scene, record: Record, *, dt: float, stop: Stop, max_time: float
    ) -> None:
        self.balls = PaperBalls(scene, stop)
        self.recorder = Recorder(scene, record)
        self.t = 0.0
        self.frames = 0
        self._dt = dt
        self._t_max = math.inf if scene.t_max is None else scene.t_max
        self._max_time = max_time

    @property
    @abstractmethod
    def work(self) -> dict[str, int]:
        """Counters of operations, for `Result.work`."""

    @property
    def limit_reached(self) -> str:
        """The limit that the run has reached, except a time limit; "" if none."""
        return ""

    @abstractmethod
    def advance_frame(self, t: float) -> None:
        """Advance all balls to `t` [s], the end of a frame."""

    def result(self, engine: str, settings: dict[str, Any]) -> Result:
        """Run until all balls rest, to `t_max` or to a limit, and return the result.

        Completion: a shorter last frame ends exactly at `t_max`.
        """
        balls, recorder = self.balls, self.recorder
        t_end = min(self._t_max, self._max_time)
        recorder.start()
        recorder.frame(0.0, balls.samples())
        while balls.moving and self.t < t_end and not self.limit_reached:
            # Not t + dt, because the clock would accumulate rounding and miss t_end by an ulp.
            self.frames += 1
            self.advance_frame(min(self.frames * self._dt, t_end))
        status, reason = self._ending()
        return recorder.result(
            engine=engine,
            settings=settings,
            status=status,
            final_state=balls.samples(),
            rest_time=self.t,
            work=self.work,
            reason=reason,
        )

    def _ending(self) -> tuple[Status, str]:
        if not self.balls.moving:
            return Status.REST, ""
        if self.t == self._t_max:
            return Status.T_MAX, ""
        if self.limit_reached:
            return Status.EVENT_LIMIT, self.limit_reached
        return Status.STEP_LIMIT, f"not all balls are at rest at `max_time` = {self._max_time} s"
