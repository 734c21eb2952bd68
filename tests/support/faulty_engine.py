"""An engine that misbehaves as it is asked to: what the harness must survive."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import Record, Result, Samples, Scene, Status
from ghostball.model.features import EXACT, Capability, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings

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
    """What it does in place of a shot."""

    does: Fault = "none"
    slow: float = 0.0
    """Seconds that it sleeps before each shot, so that one can be caught in the midst of it."""


class FaultyEngine(EngineBase):
    """Our engine, until it fails. It isn't among the installed ones: see `planted`."""

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


def fail(does: Fault) -> None:
    """Fail in that way, where it isn't by what is returned; most never return."""
    if does == "raise":
        raise RuntimeError("lost the balls")
    if does == "exit":
        raise SystemExit(0)
    if does == "crash":
        os._exit(7)  # as where C code calls `exit`
    if does == "abort":
        os.kill(os.getpid(), signal.SIGKILL)  # as by the system, where memory runs out
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


def planted(folder: Path) -> Path:
    """Make a folder that, on the path, lets every process find the engine as an installed one."""
    info = folder / "faulty_engine-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: faulty-engine\nVersion: 1.0\n")
    place = f"{FaultyEngine.__module__}:{FaultyEngine.__name__}"
    (info / "entry_points.txt").write_text(f"[ghostball.engines]\nfaulty = {place}\n")
    return folder
