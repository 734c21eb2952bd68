"""Runs of our engine within the harness, where Ctrl-C must end more than the run."""

from __future__ import annotations

from ghostball.engine import simulate
from ghostball.model import Record, Result, Scene, Status


def run_ours(scene: Scene, record: Record = "trajectory") -> Result:
    """Run a scene on our engine.

    Interrupted, it hands back what it has: here the user is leaving, and no part of a shot may be
    taken for the shot.

    Raises `KeyboardInterrupt`; `UnsupportedSceneError` where our engine lacks physics that the
    scene needs.
    """
    result = simulate(scene, record=record)
    if result.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return result
