"""Tables made of the committed board and of errors against time, as Markdown."""

from __future__ import annotations

from statistics import median
from unittest.mock import patch

import numpy as np
import pymunk

from benchmarks.board import HEADS, BoardMeasurement
from benchmarks.measurements import committed
from docs.recipes import pymunk_recipe
from docs.tables import table
from ghostball import find_scene, simulate
from ghostball.reports.style import format_length, format_time
from ghostball.validation.parallel.sources import PACKAGE_OF
from ghostball.validation.precision.points import PrecisionMeasurement
from ghostball.validation.scenes.library import BOARD, select

UNMEASURED = "Not measured yet: `python -m benchmarks board DIR --store` does so."

USES = (
    ("rules, an AI that tries many shots, a test's truth", "ghostball"),
    ("a game in the plane that may move its balls itself", "pymunk:contact_steps=exact,dt=0.02"),
    ("a game in the plane, in steps of 1 ms", "pymunk:dt=0.001"),
    ("the same, with a newcomer's settings", "pymunk:config=naive,dt=0.016666666666666666"),
    ("a game in space that may move its balls itself", "pybullet:contact_steps=exact,dt=0.02"),
    ("a game in space, in steps of 1 ms", "pybullet:dt=0.001"),
    ("the same, with a newcomer's settings", "pybullet:config=naive,dt=0.004166666666666667"),
)
"""What an engine is wanted for, and the label that was measured for it."""

ASKED = ("half-ball-1", "slide-to-rest", "throw")
"""The scenes of the board that decide for billiards."""


def board() -> str:
    """Return a row for each engine that the last run measured: scenes by class, error and time."""
    stored = committed(BoardMeasurement)
    if stored is None:
        return UNMEASURED
    rows = ((_linked(label), *cells) for label, *cells in stored.rows())
    said = [
        f"{len(select([BOARD]))} scenes, measured on {stored.where}:",
        table(HEADS, rows),
    ]
    if earlier := dict.fromkeys(_linked(one) for one in stored.earlier if ":" not in one):
        said.append(
            "Earlier runs measured other engines, with steps of 1 ms (in `half-ball-1` the worst "
            f"of eight starts); their pages show that: {', '.join(earlier)}."
        )
    return "\n\n".join(said)


def _linked(label: str) -> str:
    return f"[`{label}`](engines/{label.partition(':')[0]}.md)"


def choice() -> str:
    """Return which engine with which settings is how right, and what it costs."""
    measured = committed(PrecisionMeasurement)
    if measured is None:
        return "Nothing was measured yet: `ghostball engines --steps --out DIR` does so."
    rows = []
    for use, label in USES:
        points = [one for one in measured.points if one.label == label]
        errors = [one.error for one in points]
        rows.append(
            (
                use,
                f"`{_shortened(label)}`",
                f"{format_length(median(errors))} ({format_length(max(errors))})",
                format_time(median(one.call_seconds for one in points)),
            )
        )
    heads = ("for", "engine and settings", "error: median (largest)", "time of a shot")
    scenes = ", ".join(f"`{name}`" for name in sorted({one.scene for one in measured.points}))
    place = f"{measured.environment['cpu']}, {str(measured.environment['date'])[:10]}"
    return f"{table(heads, rows)}\n\nOver those of {scenes} that each can play; {place}."


def pymunk_recipe_reaches() -> str:
    """Return the rest error and number of steps of pymunk's recipe, with fixed and exact steps."""
    true = simulate(find_scene("half-ball-cut")).rest_positions[:, :2]
    found, take_step = [], pymunk.Space.step
    for exact in (False, True):
        with (
            patch.object(pymunk.Space, "step", autospec=True, side_effect=take_step) as step,
            patch.object(pymunk_recipe, "advance", side_effect=pymunk_recipe.advance) as frame,
        ):
            balls = pymunk_recipe.play(exact)
        places = np.array([tuple(ball.position) for ball in balls])
        off = float(np.max(np.linalg.norm(places - true, axis=1)))
        found.append((format_length(off), step.call_count, frame.call_count))
    (own, own_steps, _), (exact_off, exact_steps, frames) = found
    return (
        f"As printed, the program takes {own_steps} steps of 1 ms, and the rest error of the cut "
        f"is {own}. With steps that end at contacts, the rest error is {exact_off}, with "
        f"{exact_steps} calls of `space.step` in {frames} frames."
    )


def _shortened(label: str) -> str:
    """Return a label with its step as one writes it."""
    return label.replace("0.016666666666666666", "1/60").replace("0.004166666666666667", "1/240")


def other_engines() -> str:
    """Return what the board says of engines that the precision measurement has not."""
    stored = committed(BoardMeasurement)
    if stored is None:
        return UNMEASURED
    left_out = {label.partition(":")[0] for _, label in USES}
    left_out |= {name for name, package in PACKAGE_OF.items() if package == "ghostball"}
    rows = []
    for engine in (one for one in stored.labels if ":" not in one and one not in left_out):
        found, exact = stored.of(engine), stored.of(f"{engine}:contact_steps=exact")
        cells = [found.get(ASKED[0]), exact.get(ASKED[0]), *map(found.get, ASKED[1:])]
        rows.append((f"`{engine}`", *("–" if one is None else one.text for one in cells)))
    cut = f"`{ASKED[0]}`"
    heads = (cut, f"{cut}, exact steps", *(f"`{name}`" for name in ASKED[1:]))
    return table(("engine", *heads), rows)
