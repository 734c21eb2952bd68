"""Engines that misbehave, and short shots, for the tests of the suite."""

from __future__ import annotations

from ghostball.model import Ball, Scene
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.criterion import Criterion

ENGINES = '''
"""Engines that misbehave, one setting for each way."""

import os
import time
from dataclasses import replace

import numpy as np

from ghostball.model import Result, Status
from ghostball.engine import simulate
from ghostball.model.features import EXACT, Capability, Feature
from ghostball.reference_adapters.base import EngineBase, EngineSettings


class Settings(EngineSettings):
    does: str = "run"
    shift: float = 0.0
    sees: float = 0.0


class Fake(EngineBase):
    name = "fake"
    Settings = Settings

    @property
    def capabilities(self):
        able = dict.fromkeys(Feature, EXACT)
        able[Feature.ROLLING] = Capability("approximate", "nearly")
        if self.settings.does == "refuse":
            able[Feature.ROLLING] = Capability("none", "it slips")
        return able

    def resolution(self, scene):
        return self.settings.sees

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        does = self.settings.does
        if does == "raise":
            raise RuntimeError("lost the \\x1b[31mballs")
        if does == "raise half a letter":
            raise RuntimeError("lost \\udcff")
        if does == "crash":
            os._exit(7)
        if does == "hang":
            time.sleep(600)
        if does == "interrupt":
            raise KeyboardInterrupt
        if does == "exit":
            raise SystemExit(0)
        if does == "hand back a dict":
            return {}
        if does == "print":
            print("hello")
        truth = simulate(scene, record=record)
        if does == "end elsewhere at rest" and record == "rest":
            there = truth.final_state.positions + [0.2, 0.0, 0.0]
            truth = replace(truth, final_state=truth.final_state._replace(positions=there))
        if does == "end later at rest" and record == "rest":
            truth = replace(truth, rest_time=truth.rest_time + 0.25)
        if does == "count more at rest" and record == "rest":
            truth = replace(truth, collision_counts={"ball-ball": 3, "ball-cushion": 0})
        if does == "say other events" and record == "events":
            events = truth.events.copy()
            events["t"] *= 0.9
            truth = replace(truth, events=events)
        shift = self.settings.shift
        if does == "play by chance":
            shift = float(np.random.default_rng().random())
        motion = truth.trajectory
        if motion is not None:  # the balls rest where the result says it
            ends = [rows.copy() for rows in motion.segments]
            for rows in ends:
                rows[-1, 1] += shift
            motion = replace(motion, segments=tuple(ends))
        shifted = truth.final_state._replace(
            positions=truth.final_state.positions + [shift, 0.0, 0.0]
        )
        if does == "lose a ball":
            shifted.positions[0, 0, 1] = np.nan
        return Result(
            engine="fake",
            settings={},
            scene=scene,
            status={
                "give up": Status.FAILED,
                "stop": Status.STEP_LIMIT,
                "stop at half a letter": Status.STEP_LIMIT,
            }.get(does, truth.status),
            reason={
                "give up": "lost the cue",
                "stop": "too many steps",
                "stop at half a letter": "lost \\udcff",
            }.get(does, ""),
            final_state=shifted,
            rest_time=np.nan if does == "lose time" else truth.rest_time,
            collision_counts=truth.collision_counts,
            work={"steps": np.int64(3)},
            wall_time=0.5,
            events=truth.events,
            trajectory=motion,
        )


class Absent(Fake):
    name = "absent"

    @classmethod
    def unavailable(cls):
        return "not installed here"
'''


ENTRY_POINTS = """
[ghostball.engines]
fake = fake_engines:Fake
absent = fake_engines:Absent
"""


def scene(name: str = "roll") -> Scene:
    return Scene(name=name, balls=[Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))])


def limits(*engines: str, metric: str = "rest_error_max", at_most: float = 1e-6) -> Criteria:
    criterion = Criterion.model_validate(
        {"engines": engines, "metric": metric, "at_most": at_most, "reason": "by hand"}
    )
    return Criteria(criteria=(criterion,))
