"""Runs that are killed, for processes of their own: they must find what they run by its name.

Not in the module of the tests: some package that is installed may be called `tests`.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ghostball.model import Ball, Scene, Table
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.suite.suite import run_suite

ENGINES = ("ghostball", "paper-discrete")
TABLE = Table(length=2.0, width=1.0)
SCENES = [
    Scene(
        name=f"cut-{k}",
        table=TABLE,
        balls=[
            Ball(id="cue", position=(0.5, 0.5), velocity=(1.0 + 0.01 * k, 0.0)),
            Ball(id="object", position=(1.0, 0.53)),
        ],
    )
    for k in range(12)
]

Key = tuple[str, ...]
Say = Callable[[Key], None]


def suite(out: Path, say: Say) -> None:
    criteria = {scene.name: Criteria(truth="engine") for scene in SCENES}

    def done(_: int, __: int, case: Any) -> None:
        say((case.scene, case.label))

    run_suite(SCENES, ENGINES, out, criteria=criteria, reuse=True, progress=done)


def run_until_killed(
    run: Callable[[Path, Say], None], out: Path, said: Path, variables: dict[str, str]
) -> None:
    """Run in this process, and say what is done by a line of a file each, written at once.

    With these variables of the environment, which are part of what a result is reused for. The
    server of processes has those of whichever test began it.
    """
    os.environ.clear()
    os.environ.update(variables)
    file = os.open(said, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    run(out, lambda key: os.write(file, ("\t".join(key) + "\n").encode()) and None)
