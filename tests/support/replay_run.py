"""A small run of the suite, with the difficult cases for a replay."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ghostball.model import Ball, Scene, Table
from ghostball.validation.results.store import Results, ResultsWriter
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite

ENGINES = ["ghostball", "pymunk", "paper-discrete"]
BROKEN = "pymunk:config=naive"
"""Engine with a motion that the tests make invalid."""

BREAKS_AT = 0.5
"""Time after which the positions of its first ball are NaN [s]."""

SCRIPT = "<img src=x onerror=pwned=1>"
HOSTILE = "</script><script>pwned=1</script>" + SCRIPT


def hostile_scene() -> Scene:
    """Return a scene with a title and names that would run as scripts if they were HTML."""
    return Scene(
        name="hostile",
        title=HOSTILE,
        table=Table(length=2.54, width=1.27),
        balls=[
            Ball(id=SCRIPT, position=(0.5, 0.6), velocity=(1.0, 0.0)),
            Ball(id="&lt;b&gt;", position=(1.0, 0.628)),
        ],
    )


def small_run(within: Path) -> Path:
    """Run five scenes on three engines; the first scene also on an engine that loses a ball."""
    first, folder = within / "first", within / "page"
    names = ("half-ball-cut", "draw-shot", "three-ball-chain", "flight-jump")
    scenes = [*map(find_scene, names), hostile_scene()]
    run_suite(scenes, ENGINES, first)
    ran = Results.open(first)
    writer = ResultsWriter(folder)
    writer.begin(ran.environment | {"engines": [*ENGINES, BROKEN]})
    for case in ran.cases:
        motion = ran.motion(case)
        writer.write((case, motion))
        if case.scene == "half-ball-cut" and case.label == "pymunk":
            assert motion is not None
            positions = motion.positions.copy()
            positions[motion.times >= BREAKS_AT, 0] = np.nan
            rest = np.where([[True], [False]], np.nan, case.rest_positions)
            blown_up = replace(case, label=BROKEN, rest_positions=rest)
            writer.write((blown_up, replace(motion, positions=positions)))
    writer.finish("complete")
    return folder
