"""Functions for runs that tests kill; other processes import this module by its name.

They aren't in a module of `tests`, because an installed package may also have the name `tests`.
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
    """Run in this process, and write each finished key at once as a line of the file `said`.

    `variables`: environment variables to set here, because reuse of results depends on them, and
    the server of processes has those of the test that started it.
    """
    os.environ.clear()
    os.environ.update(variables)
    file = os.open(said, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    run(out, lambda key: os.write(file, ("\t".join(key) + "\n").encode()) and None)
