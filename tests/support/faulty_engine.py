"""Engines that fail in a chosen way; Ghostball must handle each failure."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import (
    Record,
    Result,
    Samples,
    Scene,
    SceneError,
    Status,
    UnsupportedSceneError,
)
from ghostball.model.features import EXACT, Capability, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings
from ghostball.reference_adapters.registry import OURS

Fault = Literal[
    "none",
    "raise",
    "exit",
    "crash",
    "abort",
    "hang",
    "deaf",
    "freeze",
    "garbage",
    "print",
    "give-up",
    "stop",
    "miscount",
    "lose-motion",
    "cut-motion",
]


class FaultySettings(EngineSettings):
    """The fault of the engine."""

    does: Fault = "none"
    slow: float = 0.0
    """Seconds that the engine sleeps before each shot, so that a test can interrupt the shot."""


class FaultyEngine(EngineBase):
    """Ghostball's engine with a fault. It isn't an installed engine: see `planted`."""

    name: ClassVar[str] = "faulty"
    Settings: ClassVar[type[EngineSettings]] = FaultySettings
    capabilities: ClassVar[Mapping[Feature, Capability]] = dict.fromkeys(Feature, EXACT)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Simulate, or fail."""
        self.check(scene)
        settings = self.settings
        assert isinstance(settings, FaultySettings)
        time.sleep(settings.slow)
        fail(settings.does)
        result = replace(simulate(scene, record=record), engine=self.name, settings={})
        if settings.does == "give-up":
            return replace(result, status=Status.FAILED, reason="\x1b[31mlost the cue")
        if settings.does == "stop":
            return replace(result, status=Status.STEP_LIMIT, reason="too many steps")
        if settings.does == "miscount":
            return replace(result, collision_counts={"ball-ball": -3, "ball-cushion": 10**30})
        if settings.does in ("lose-motion", "cut-motion"):
            return replace(result, trajectory=FaultyMotion(settings.does))
        return result


class FaultyMotion:
    """A motion that can't be sampled."""

    t_end = 1.0

    def __init__(self, does: Fault) -> None:
        self.does = does

    def sample(self, times: NDArray[np.float64]) -> Samples:
        """Fail, or return states of one ball with two coordinates."""
        if self.does == "lose-motion":
            raise RuntimeError("lost the motion")
        return Samples(*(np.zeros((len(times), 1, 2)) for _ in range(3)))


def fail(does: str) -> None:
    """Perform a fault that isn't a wrong return value; most faults never return."""
    if does == "raise":
        raise RuntimeError("lost the balls")
    if does == "exit":
        raise SystemExit(0)
    if does == "crash":
        os._exit(7)  # as if C code called `exit`
    if does == "abort":
        os.kill(os.getpid(), signal.SIGKILL)  # as the system does when memory runs out
    if does == "print":
        print("\x1b[31mfrom Python")
        os.write(1, b"\x1b]0;straight to descriptor 1\x07\n")  # as C code does
        os.write(2, b"straight to descriptor 2\n")
    if does == "deaf":
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    if does == "freeze":
        os.kill(os.getpid(), signal.SIGSTOP)
    if does == "garbage":
        raise ValueError("\x1b[31m\r\n\0\u2028 in red")
    while does in ("hang", "deaf", "freeze"):
        time.sleep(1.0)


class FakeSettings(EngineSettings):
    """Fault, shift of the rest positions along x [m], and declared resolution [m]."""

    does: str = "run"
    shift: float = 0.0
    sees: float = 0.0


class OwnError(UnsupportedSceneError):
    """An error that can't be sent to another process."""

    def __init__(self, one: str, two: str, three: str) -> None:
        super().__init__("fake", (one, two, three))


RAISED = {
    "interrupt": KeyboardInterrupt(),
    "raise half a letter": RuntimeError("lost \udcff"),
    "blame the scene": SceneError("it is wrong"),
    "refuse oddly": OwnError("no", "such", "thing"),
}
ENDS = {
    "stop at half a letter": {"status": Status.STEP_LIMIT, "reason": "lost \udcff"},
    "lose time": {"rest_time": np.nan},
    "lie": {"status": "rest"},
}
"""Wrong fields of a result, by fault."""


class Fake(EngineBase):
    """Ghostball's engine with approximate rolling, which raises an error or returns nonsense."""

    name: ClassVar[str] = "fake"
    Settings: ClassVar[type[EngineSettings]] = FakeSettings

    @property
    def capabilities(self) -> Mapping[Feature, Capability]:
        """All features exact, except pure rolling: approximate or unsupported."""
        refuses = self.settings.does == "refuse"
        rolling = Capability("none", "it slips") if refuses else Capability("approximate", "nearly")
        return dict.fromkeys(Feature, EXACT) | {Feature.ROLLING: rolling}

    def resolution(self, scene: Scene) -> float:
        """Return the resolution of the settings."""
        return self.settings.sees

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Any:
        """Simulate with the fault."""
        self.check(scene)
        does, shift = self.settings.does, self.settings.shift
        if does == "say last words":
            print("last words")
            fail("abort")
        fail(does)
        if does in RAISED:
            raise RAISED[does]
        if does == "hand back a dict":
            return {}
        result = simulate(scene, record=record)
        if record == "rest":
            shift += 0.2 * (does == "end elsewhere at rest")
            later = 0.25 * (does == "end later at rest")
            result = replace(result, rest_time=result.rest_time + later)
        if does == "count more at rest" and record == "rest":
            result = replace(result, collision_counts={"ball-ball": 3, "ball-cushion": 0})
        if does == "say other events" and record == "events":
            events = result.events.copy()
            events["t"] *= 0.9
            result = replace(result, events=events)
        if does == "play by chance":
            shift = float(np.random.default_rng().random())
        ended = result.final_state
        ended = ended._replace(positions=ended.positions + np.array([shift, 0.0, 0.0]))
        if does == "lose a ball":
            ended.positions[0, 0, 1] = np.nan
        motion = result.trajectory
        if motion is not None:  # the motion ends at the rest positions of the result
            segments = [rows.copy() for rows in motion.segments]
            for rows in segments:
                rows[-1, 1] += shift
            motion = replace(motion, segments=tuple(segments))
        as_said = {"engine": self.name, "settings": {}, "work": {"steps": np.int64(3)}}
        ended_so = {"final_state": ended, "trajectory": motion, "wall_time": 0.5}
        return replace(result, **as_said, **(ended_so | ENDS.get(does, {})))


class Impostor(Fake):
    """An engine with the name of Ghostball's engine."""

    name = OURS


class Absent(Fake):
    """An engine that is unavailable."""

    name = "absent"

    @classmethod
    def unavailable(cls) -> str:
        """Return the reason."""
        return "not installed here"


def planted(folder: Path, *engines: type[EngineBase]) -> Path:
    """Make a folder; with this folder on the import path, engines count as installed.

    `engines`: classes of engines (default: `FaultyEngine`).
    """
    info = folder / "faulty_engine-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: faulty-engine\nVersion: 1.0\n")
    found = [f"{one.name} = {__name__}:{one.__name__}" for one in engines or (FaultyEngine,)]
    (info / "entry_points.txt").write_text("\n".join(["[ghostball.engines]", *found, ""]))
    return folder
