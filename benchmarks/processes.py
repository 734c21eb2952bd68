"""How long a new process takes: for a first shot, compiled before or not; to compile everything."""

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

SHOOT = """\
import time
began = time.perf_counter()
import sys
from ghostball.engine import simulate
imported = time.perf_counter() - began
from ghostball.model import Scene
simulate(Scene.load(sys.argv[1]))
print(imported, flush=True)
"""
"""Prints how long importing the engine took [s], and shoots once."""

COMPILE = """\
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.scenes.library import select
compile_kernels(select(), 2)
print(0.0, flush=True)
"""
"""Compiles what `make validate` needs of the kernels, in two processes."""

LONGEST = 600.0
"""Seconds after which a process is given up."""


def prepare_start(_: object) -> Sampler:
    """Prepare a process that finds its kernels in the cache; the first one puts them there."""
    timed(SHOOT)
    return lambda: dict(zip(("first_shot", "import"), timed(SHOOT), strict=True))


def prepare_cold_start(_: object) -> Sampler:
    """Prepare processes that have to compile: for one shot, and for all that `validate` runs."""

    def sample() -> dict[str, float]:
        seconds = []
        for program in (SHOOT, COMPILE):
            with tempfile.TemporaryDirectory() as empty:
                seconds.append(timed(program, GHOSTBALL_CACHE_DIR=empty)[0])
        return {"first_shot": seconds[0], "every_variant": seconds[1]}

    return sample


def timed(program: str, **variables: str) -> tuple[float, float]:
    """Run a program to its end, with more variables of the environment than this process has.

    Returns `taken, printed`: from the start of the process to its end [s], and the number that it
    printed.
    """
    root = str(Path(engine.__file__).resolve().parent.parent)
    paths = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-c", program, str(FOLDER / "half-ball-cut.toml")]
    # An installed package is compiled to bytecode, whatever this process does with its own.
    bytecode = {"PYTHONDONTWRITEBYTECODE": ""}
    environment = {**os.environ, "PYTHONPATH": paths, **bytecode, **variables}
    began = time.perf_counter()
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
        )
        return time.perf_counter() - began, float(done.stdout)
    except subprocess.TimeoutExpired:
        said = f"it took over {LONGEST:.0f} s"
    except ValueError:
        said = "".join(done.stderr.strip().splitlines()[-1:])
    raise MeasurementError(f"a new process failed: {said}")
