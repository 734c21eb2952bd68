"""A Gymnasium environment of many tables: pocket the object ball, and not the cue ball."""

import time
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space

from ghostball import Ball, Physics, Scene, Strokes, Table, simulate_starts

TABLE = Table.model_validate("wpa-9ft")
SCENE = Scene(
    name="gym",
    table=TABLE,
    physics=Physics(preset="pool"),
    balls=[Ball(id="cue", position=(0.6, 0.6)), Ball(id="object", position=(1.8, 0.6))],
)


class PocketEnv(gymnasium.vector.VectorEnv):
    """Tables with a cue ball and an object ball; an action is a stroke at each table.

    Action: speed [m/s], direction [rad], offset to the left, offset upwards [radii].
    Observation: x and y of the cue ball and of the object ball [m].
    Reward: 1 if only the object ball is pocketed, -1 if the cue ball is, 0 otherwise.

    An episode ends when a ball is pocketed, or after `shots` shots; the next step of this table
    ignores the action and puts both balls on the table again.
    """

    def __init__(
        self, num_envs: int, *, shots: int = 10, noise: dict[str, float] | None = None
    ) -> None:
        self.num_envs, self._most, self._noise = num_envs, shots, noise or {}
        self.metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}
        self.single_action_space = gymnasium.spaces.Box(
            np.array([0.3, -np.pi, -0.36, -0.36], np.float32),
            np.array([6.0, np.pi, 0.36, 0.36], np.float32),
        )
        self.single_observation_space = gymnasium.spaces.Box(
            np.zeros(4, np.float32), np.array([TABLE.length, TABLE.width] * 2, np.float32)
        )
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._places = np.zeros((num_envs, 2, 2))  # the states of all tables
        self._shots = np.zeros(num_envs, dtype=int)
        self._over = np.zeros(num_envs, dtype=bool)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode at every table."""
        super().reset(seed=seed, options=options)
        self._put_balls(np.ones(self.num_envs, dtype=bool))
        return self._observation(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Play a shot at every table."""
        plays = ~self._over
        self._put_balls(self._over)
        low, high = self.single_action_space.low, self.single_action_space.high
        speed, direction, left, up = np.clip(np.float64(actions), low, high)[plays].T
        strokes = Strokes(
            speed,
            direction,
            offset_left=left,
            offset_up=up,
            noise=self._noise,
            seed=int(self.np_random.integers(2**31)),
        )
        batch = simulate_starts(SCENE, self._places[plays], strokes=strokes)
        self._places[plays] = batch.rest_positions[:, :, :2]
        self._shots[plays] += 1
        rewards, ended = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=bool)
        cue_gone, object_gone = batch.gone.T
        rewards[plays] = np.where(cue_gone, -1.0, np.where(object_gone, 1.0, 0.0))
        ended[plays] = cue_gone | object_gone
        stopped = (self._shots >= self._most) & ~ended
        self._over = ended | stopped
        return self._observation(), rewards, ended, stopped, {}

    def _put_balls(self, where: np.ndarray) -> None:
        """Put both balls at random places on some tables: the cue ball in the left half."""
        low, high = np.array([[0.1, 0.1], [1.4, 0.1]]), np.array([[1.1, 1.1], [2.4, 1.1]])
        self._places[where] = self.np_random.uniform(low, high, (int(where.sum()), 2, 2))
        self._shots[where] = 0

    def _observation(self) -> np.ndarray:
        space = self.single_observation_space
        return np.clip(self._places.reshape(-1, 4), space.low, space.high).astype(np.float32)


def main(num_envs: int = 4096, steps: int = 50) -> None:
    """Measure the number of shots per second, with random strokes."""
    env = PocketEnv(num_envs, noise={"direction": 0.002})
    env.reset(seed=1)
    env.action_space.seed(1)
    actions = [env.action_space.sample() for _ in range(steps)]
    env.step(actions[0])  # the first step compiles, or loads, the engine
    began, made = time.perf_counter(), 0
    for action in actions:
        made += int((env.step(action)[1] > 0).sum())
    rate = num_envs * steps / (time.perf_counter() - began)
    print(f"{num_envs} tables: {rate:.0f} steps per second, {made} balls made")


if __name__ == "__main__":
    main()
