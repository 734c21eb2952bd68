"""Peers that need no package: they answer what a test tells them to."""

from __future__ import annotations

from benchmarks.peer_engines import PeerRun
from ghostball.engine import Scene


class FakePeer:
    """Takes `seconds` and has `events`, or raises `error`, for scenes of more than `from_balls`."""

    def __init__(self, name="fake", seconds=1.0, events=10, error=None, from_balls=0) -> None:
        self.name, self.version = name, "1.0"
        self.run = PeerRun(seconds, events)
        self.error, self.from_balls = error, from_balls
        self.asked: list[Scene] = []

    def simulate(self, scene: Scene) -> PeerRun:
        self.asked.append(scene)
        if self.error is not None and len(scene.balls) > self.from_balls:
            raise self.error
        return self.run
