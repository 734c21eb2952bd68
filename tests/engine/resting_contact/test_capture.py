"""Tests of a ball that topspin holds at a cushion, against the limit of the impact law."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Physics, Scene, Table

R, G = 0.028575, 9.81
SLIDING, SPINNING = 0.2, 10.0
"""Friction of the cloth, and its deceleration of the spin about the vertical [rad/s^2]."""

RESTITUTION, FRICTION = 0.85, 0.2
"""Constants of the cushion."""

PERMITTED = 5e-7
"""Permitted errors of the velocity along the cushion and of the vertical spin.

The error of the velocity is relative to the initial velocity, that of the spin to the largest
component of the initial spin. Relative to the final values, errors may be ten times as large,
because friction may take nine tenths of a velocity.
"""

HELD_BELOW = 1e-7
"""Speed of a rebound [m/s] below which the rebounds are replaced by a force."""

Numbers = NDArray[np.float64]
Spin = tuple[float, float, float]

SHOTS = (
    (0.05, 0.3, (0.0, 80.0, 40.0), 0.0357),
    (0.02, 0.1, (0.0, 60.0, 0.0), 0.0357),
    (0.1, 0.2, (10.0, 100.0, -30.0), 0.0357),
    (0.05, 0.3, (0.0, 80.0, 40.0), R),
    (0.02, 0.1, (0.0, 60.0, 0.0), R),
)
"""Shots that once left the cushion up to 13 % too fast: speeds into the cushion and along it [m/s],
spins [rad/s], heights of the nose [m].
"""


class HeldToCushion:
    """A ball that its topspin drives into a cushion: Han's impacts, then their limit.

    Rebounds whose duration decreases without limit act as a force, with the friction of their
    impulses. n points into the cushion, t along it; a state is vt, wn, wt, wz. The model shares no
    formula with the engine, and is integrated by the classical Runge-Kutta method.
    """

    def __init__(self, height: float) -> None:
        self.sine = (height - R) / R
        self.cosine = math.sqrt(1.0 - self.sine**2)
        self.sense = 0.0

    def velocities_when_it_rolls(self, vn: float, vt: float, spin: Spin) -> tuple[float, float]:
        """Return vt [m/s] and wz [rad/s] at the time when the slip on the cloth ends."""
        state = np.array([vt, *spin], dtype=float)
        while True:
            vn, state = self._bounce(vn, state)
            if -vn < HELD_BELOW:
                break
            an, at, _ = self._cloth(vn, state)
            dt = -2.0 * vn / an
            wz = math.copysign(max(abs(state[3]) - SPINNING * dt, 0.0), state[3])
            state += dt * np.array([at, 2.5 * at / R, -2.5 * an / R, 0.0])
            state[3], vn = wz, vn + an * dt
        self._choose_sense(state)
        while True:
            size = self._rates(state)[2]
            if size < 1e-11:
                return float(state[0]), float(state[3])
            dt = min(2e-4, 0.02 * size / (3.5 * SLIDING * G))
            after = self._step(state, dt)
            if self.sense and after[3] * self.sense < 0.0:
                while abs(after[3]) > 1e-13:
                    dt *= state[3] / (state[3] - after[3])
                    after = self._step(state, dt)
                after[3] = 0.0
            if after[3] == 0.0:
                self._choose_sense(after)
            state = after

    def _cloth(self, vn: float, state: Numbers) -> tuple[float, float, float]:
        """Return the acceleration by the cloth along n and t [m/s^2], and the slip [m/s]."""
        vt, wn, wt, _ = state.tolist()
        un, ut = vn - R * wt, vt + R * wn
        size = math.hypot(un, ut)
        return -SLIDING * G * un / size, -SLIDING * G * ut / size, size

    def _bounce(self, vn: float, state: Numbers) -> tuple[float, Numbers]:
        vt, wn, wt, wz = state.tolist()
        down = vn * self.sine + R * wt
        along = vt + R * (wz * self.cosine - wn * self.sine)
        most = FRICTION * (1.0 + RESTITUTION) * self.cosine * vn
        share = min(2.0 / 7.0, most / math.hypot(down, along))
        down, along = -share * down, -share * along
        turn = 2.5 / R
        vn = vn * (self.sine**2 - RESTITUTION * self.cosine**2) + down * self.sine
        wn, wt = wn - turn * along * self.sine, wt + turn * down
        return vn, np.array([vt + along, wn, wt, wz + turn * along * self.cosine])

    def _rates(self, state: Numbers) -> tuple[Numbers, float, float]:
        """Return the rates of change of the state, the turning by the cushion, and the slip."""
        vt, wn, wt, wz = state.tolist()
        an, at, size = self._cloth(0.0, state)
        down, along = R * wt, vt + R * (wz * self.cosine - wn * self.sine)
        slip = math.hypot(down, along)
        push = an / (self.cosine + FRICTION * self.sine * down / slip)
        down, along = -FRICTION * push * down / slip, -FRICTION * push * along / slip
        turn = 2.5 / R
        twist = turn * along * self.cosine
        change = [
            at + along,
            2.5 * at / R - turn * along * self.sine,
            -2.5 * an / R + turn * down,
            twist - SPINNING * self.sense if self.sense else 0.0,
        ]
        return np.array(change), twist, size

    def _step(self, state: Numbers, dt: float) -> Numbers:
        k1 = self._rates(state)[0]
        k2 = self._rates(state + 0.5 * dt * k1)[0]
        k3 = self._rates(state + 0.5 * dt * k2)[0]
        k4 = self._rates(state + dt * k3)[0]
        return state + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def _choose_sense(self, state: Numbers) -> None:
        self.sense = float(np.sign(state[3]))
        twist = self._rates(state)[1]
        if state[3] == 0.0:
            self.sense = float(np.sign(twist)) if abs(twist) > SPINNING else 0.0


def shot(vn: float, vt: float, spin: Spin, height: float) -> Scene:
    """Return a ball that hits the cushion with these velocities."""
    return Scene(
        name="held",
        table=Table(length=2.0, width=20.0, cushions=("right",)),
        physics=Physics(
            motion="sliding",
            rolling_friction=0.01,
            sliding_friction=SLIDING,
            spinning_friction_rate=SPINNING,
            cushion="han2005",
            cushion_restitution=RESTITUTION,
            cushion_friction=FRICTION,
            cushion_height=height,
        ),
        balls=[
            Ball(
                id="b", position=(2.0 - R, 5.0), velocity=(vn, vt), angular_velocity=spin, radius=R
            )
        ],
        t_max=1.0,
    )


@pytest.mark.parametrize(("vn", "vt", "spin", "height"), SHOTS)
def test_a_captured_ball_leaves_the_cushion_like_the_limit_of_small_rebounds(vn, vt, spin, height):
    """Compare the velocities at the time when the ball starts to roll for the last time."""
    result = simulate(shot(vn, vt, spin, height), record="events")
    rolls = result.events["t"][result.events["kind"] == EventKind.SLIDE_TO_ROLL]
    state = result.sample(rolls[-1:])
    speed, turn = HeldToCushion(height).velocities_when_it_rolls(vn, vt, spin)
    assert abs(state.velocities[0, 0, 1] - speed) <= PERMITTED * vt
    assert abs(state.angular_velocities[0, 0, 2] - turn) <= PERMITTED * max(map(abs, spin))
    assert result.work["unsolved_contact_steps"] == 0
