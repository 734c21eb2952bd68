"""Tables made of the committed board and of errors against time, as Markdown."""

from __future__ import annotations

from statistics import median
from unittest.mock import patch

import numpy as np
import pymunk

from benchmarks.measurements import committed
from benchmarks.pictures.gallery import committed_board
from docs.engine_pages import cell_link
from docs.tables import table
from ghostball import find_scene, simulate
from ghostball.reference_adapters.recipes import pymunk_recipe
from ghostball.reports.board import about, cell_text, columns_of, looks_of, unit_of
from ghostball.reports.style import format_length, format_time
from ghostball.validation.board.board import Board
from ghostball.validation.board.column import FAULTS
from ghostball.validation.parallel.sources import PACKAGE_OF
from ghostball.validation.precision.points import PrecisionMeasurement

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

ASKED = ("cut", "exact-steps", "break", "slide")
"""The columns of the board that decide for billiards."""


def board() -> str:
    """Return the committed board of engines."""
    stored = committed_board()
    if stored is None:
        return "No board was measured yet: `ghostball leaderboard` does so."
    return board_table(stored, reported=False)


def board_table(board: Board, *, reported: bool) -> str:
    """Return a board as a table in Markdown, with what its signs say and its columns ask."""
    columns = columns_of(board, reported=reported)
    rows = (
        (
            f"[`{row}`](engines/{row.partition(':')[0]}.md)",
            *(cell_link(board, row, one) for one in columns),
        )
        for row in board.rows
    )
    lines = [table(("engine", *(column.title for column in columns)), rows)]
    signs = [f"{one.sign} {one.says}" for one in looks_of(board, columns) if one.sign]
    said = f"{'; '.join(signs)}. Lengths are how far off a run ends."
    lines += ["", f"{said} Measured on {about(board, columns)}.", ""]
    if not reported:
        lines += (f"- **{one.title}**{unit_of(one)}: {one.question}." for one in columns)
    return "\n".join(lines)


def reported() -> str:
    """Return what was reported of engines: each thread, its cause, its cure, and the verdicts."""
    parts = []
    for one in FAULTS.values():
        assert one.thread is not None
        where = "/".join(one.thread.split("/")[3:5])
        thread = f"[{where} #{one.thread.rpartition('/')[2]}]({one.thread})"
        parts.append(
            f"- **{one.title}** ({thread}). {one.question}. *Cause:* {one.cause} *Cure:* {one.cure}"
        )
    stored = committed_board()
    if stored is not None and columns_of(stored, reported=True):
        parts += ["", board_table(stored, reported=True)]
    return "\n".join(parts)


def choice() -> str:
    """Return which engine with which settings is how right, and what it costs."""
    measured = committed(PrecisionMeasurement)
    if measured is None:
        return "Nothing was measured yet: `ghostball precision --out DIR` does so."
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
    """Return what the board says of engines that the ladder of steps has not."""
    stored = committed_board()
    if stored is None:
        return "No board was measured yet: `ghostball leaderboard` does so."
    columns = [one for one in columns_of(stored, reported=False) if one.id in ASKED]
    left_out = {label.partition(":")[0] for _, label in USES}
    left_out |= {name for name, package in PACKAGE_OF.items() if package == "ghostball"}
    chosen = [row for row in stored.rows if ":" not in row and row not in left_out]
    rows = ((f"`{row}`", *(cell_text(stored, row, one) for one in columns)) for row in chosen)
    return table(("engine", *(one.title for one in columns)), rows)
