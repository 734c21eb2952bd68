"""How long a new process takes: for a first shot, compiled before or not; to compile everything."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from benchmarks.running import BenchError
from benchmarks.timing import Clock, Sampler
from ghostball import engine
from ghostball.validation.scenes.library import FOLDER

SHOT = "half-ball-cut"
"""The shipped scene that is shot."""

PROGRAM = """\
import time
began = time.perf_counter()
import sys
from ghostball import engine
imported = time.perf_counter() - began
engine.simulate(engine.Scene.load(sys.argv[1]))
print(imported, flush=True)
"""

COMPILING = """\
from ghostball.engine.compilation import MANY
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.scenes.library import select
compile_kernels(select(), 2, tangents=True, contacts_from=MANY)
print(0.0, flush=True)
"""
"""Compiles what `make validate` needs of the kernels, in two processes."""

LONGEST = 600.0
"""Seconds after which a process is given up."""


def sample_start(_: object) -> Sampler:
    """Prepare a process that finds its kernels in the cache; the first one puts them there."""
    first_shot({}, time.perf_counter)

    def sample(clock: Clock) -> dict[str, float]:
        shot, imported = first_shot({}, clock)
        return {"first_shot": shot, "import": imported}

    return sample


def sample_cold_start(_: object) -> Sampler:
    """Prepare processes that have to compile: for one shot, and for all that `validate` runs."""

    def sample(clock: Clock) -> dict[str, float]:
        with tempfile.TemporaryDirectory() as empty:
            shot, _ = first_shot({"GHOSTBALL_CACHE_DIR": empty}, clock)
        with tempfile.TemporaryDirectory() as empty:
            every, _ = _timed(COMPILING, "compile", {"GHOSTBALL_CACHE_DIR": empty}, clock)
        return {"first_shot": shot, "every_variant": every}

    return sample


def first_shot(environment: Mapping[str, str], clock: Clock) -> tuple[float, float]:
    """Start a process that shoots once.

    Parameters
    ----------
    environment : mapping of str to str
        Variables besides those that this process has.
    clock : callable

    Returns
    -------
    shot, imported : float [s]
        From the start of the process to its end, and what importing the engine took.

    Raises
    ------
    BenchError
        Where it fails, or takes more than `LONGEST`.
    """
    return _timed(PROGRAM, "shoot", environment, clock)


def _timed(
    program: str, purpose: str, environment: Mapping[str, str], clock: Clock
) -> tuple[float, float]:
    """Run a program to its end; return how long that took [s], and the number that it printed."""
    root = str(Path(engine.__file__).resolve().parent.parent)
    paths = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **environment}
    command = [sys.executable, "-c", program, str(FOLDER / f"{SHOT}.toml")]
    began = clock()
    try:
        done = subprocess.run(
            command, env=variables, capture_output=True, text=True, timeout=LONGEST, check=False
        )
        return clock() - began, float(done.stdout)
    except subprocess.TimeoutExpired:
        said = f"it took over {LONGEST:.0f} s"
    except ValueError:
        said = "".join(done.stderr.strip().splitlines()[-1:])
    raise BenchError(f"a new process could not {purpose}: {said}")
