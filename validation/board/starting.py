"""How much processor time an engine needs until a fresh process has played a first shot.

Its own import and its own shot count, and what its worker takes where it has one. Our modules, and
what they need, are loaded before: they are the same for every engine. The compiler counts where our
own engine is measured, which computes with it (as in `board.installed`), and for no other: their
adapters need it, but they don't.
"""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Final

from ghostball.engine import EngineFailedError
from ghostball.reference_adapters.registry import OURS, make_engine, parse_spec
from ghostball.validation.board.shots import board_scene, playable
from ghostball.validation.runs.playing import run_engine

START_LIMIT: Final = 100.0
"""Time after which a process that has not played its first shot is given up [s]."""

_COMPILER: Final = "ghostball.engine.core.kernel"
"""What loads the compiler."""


def start_time(spec: str) -> float:
    """Return the processor time of an engine's import and first shot in a fresh process [s]."""
    code = f"import sys; from {__name__} import play_first; play_first(*sys.argv[1:])"
    with tempfile.TemporaryDirectory() as folder:
        found = Path(folder) / "seconds"
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code, spec, str(found)],
            capture_output=True,
            check=True,
            timeout=START_LIMIT,
        )
        return float(found.read_text("utf-8"))


def play_first(spec: str, found: str) -> None:
    """Play a first shot, and write at the end of this process what that took [s].

    Parameters
    ----------
    spec : str
    found : str
        The file to write. Not the output, to which an engine may print.
    """
    if parse_spec(spec)[0] != OURS:
        import_module(_COMPILER)
    scene = board_scene("straight-1.9")
    before = _processor_time()
    # Functions that are registered later are called sooner: those that end workers, whose time is
    # known then.
    atexit.register(lambda: Path(found).write_text(repr(_processor_time() - before), "utf-8"))
    engine = make_engine(spec)
    result = run_engine(engine, playable(scene, engine), "rest")
    if not result.status.complete:
        raise EngineFailedError(engine.name, f"no end: {result.reason}")


def _processor_time() -> float:
    """Return the processor time of this process and of those that it started and that ended [s]."""
    return sum(os.times()[:4])
