"""What each engine's own step buys in each column of the board, as Markdown: see `steps.md`."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.measurements import committed
from benchmarks.steps import COLUMNS, StepPoint, StepsMeasurement, error_text, knee
from docs.tables import table
from ghostball.validation.board.column import Column

STEPPED = ", with steps of 1 ms"
"""What a question of the board says of steps, which are others here."""


def page() -> str:
    """Return a picture and a table for each column."""
    measured = committed(StepsMeasurement)
    if measured is None:
        return "Nothing was measured yet: `python -m benchmarks steps --store` does so."
    parts = [f"Measured on {measured.where}; a machine's speed changes neither errors nor steps."]
    for name, column in COLUMNS.items():
        found = measured.of(name)
        played = {row: points for row, points in found.items() if _plays(points)}
        rows = [_row(column, row, points) for row, points in played.items()]
        heads = ("engine", "worth it: dt", "error there", "at 60 steps/s", "at the most steps")
        lacking = ", ".join(f"`{row}`" for row in found if row not in played)
        parts += [
            f"## {column.title}",
            f"{column.question.partition(STEPPED)[0]}.",
            f"![{column.title}: error against steps](pictures/steps-{name}.png)",
            table(heads, rows),
            *([f"Lack what is asked: {lacking}."] if lacking else []),
        ]
    return "\n\n".join(parts)


def _plays(points: Sequence[StepPoint]) -> bool:
    return any(one.kind != "none" for one in points)


def _row(column: Column, row: str, points: Sequence[StepPoint]) -> tuple[str, ...]:
    worth = knee(column, points)
    ends = (points[0], points[-1])
    cells = [error_text(column, one) for one in ends]
    if worth is None:
        return f"`{row}`", "no step", "–", *cells
    finer = worth is points[-1] and len(points) > 1 and bool(worth.error)
    said = f"1/{worth.steps}" + " or finer" * finer
    return f"`{row}`", said, error_text(column, worth), *cells
