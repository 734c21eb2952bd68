"""Time of new processes: a first shot, with and without compiling, and compiling all kernels."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from ghostball import engine
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.runs.interleave import Sampler
from ghostball.validation.scenes.library import FOLDER

FIRST_SHOT_PROGRAM = """\
import time
began = time.perf_counter()
import sys
from ghostball.engine import simulate
imported = time.perf_counter() - began
from ghostball.model import Scene
simulate(Scene.load(sys.argv[1]))
print(imported, flush=True)
"""
"""Program that simulates one shot, and prints the time of importing the engine [s]."""

COMPILE_PROGRAM = """\
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.scenes.library import select
compile_kernels(select(), 2)
print(0.0, flush=True)
"""
"""Program that compiles the kernels for `make validate`, in two processes."""

PROCESS_TIME_LIMIT = 600.0
"""Time limit of a process [s]."""


def prepare_start(_: object) -> Sampler:
    """Prepare a process that finds its kernels in the cache, by running one beforehand."""
    timed(FIRST_SHOT_PROGRAM)
    return lambda: dict(zip(("first_shot", "import"), timed(FIRST_SHOT_PROGRAM), strict=True))


def prepare_cold_start(_: object) -> Sampler:
    """Prepare processes with an empty cache: for one shot, and for all scenes of `validate`."""

    def sample() -> dict[str, float]:
        seconds = []
        for program in (FIRST_SHOT_PROGRAM, COMPILE_PROGRAM):
            with tempfile.TemporaryDirectory() as empty:
                seconds.append(timed(program, GHOSTBALL_CACHE_DIR=empty)[0])
        return {"first_shot": seconds[0], "every_variant": seconds[1]}

    return sample


def timed(program: str, **variables: str) -> tuple[float, float]:
    """Run a program in a new process, and return its wall time [s] and the number it printed.

    `variables`: environment variables to add.

    Raises `MeasurementError` if the program fails, or exceeds the time limit.
    """
    root = str(Path(engine.__file__).resolve().parent.parent)
    paths = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-c", program, str(FOLDER / "half-ball-cut.toml")]
    # The new process caches bytecode, as for an installed package, even if this process doesn't.
    bytecode = {"PYTHONDONTWRITEBYTECODE": ""}
    environment = {**os.environ, "PYTHONPATH": paths, **bytecode, **variables}
    began = time.perf_counter()
    try:
        done = subprocess.run(
            command,
            env=environment,
            capture_output=True,
            text=True,
            timeout=PROCESS_TIME_LIMIT,
            check=False,
        )
        return time.perf_counter() - began, float(done.stdout)
    except subprocess.TimeoutExpired:
        said = f"it took over {PROCESS_TIME_LIMIT:.0f} s"
    except ValueError:
        said = "".join(done.stderr.strip().splitlines()[-1:])
    raise MeasurementError(f"a new process failed: {said}")
