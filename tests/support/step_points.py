"""Points of a ladder of steps, made by hand."""

from benchmarks.steps import COLUMNS, StepPoint


def points(column: str, engine: str, errors: dict[int, float | None]) -> tuple[StepPoint, ...]:
    """Return the points of an engine in a column, by steps in a second; None is no true shot."""
    kind = "micrometres" if COLUMNS[column].metric == "accuracy" else "fair"
    return tuple(
        StepPoint(
            column=column,
            engine=engine,
            label=engine,
            steps=steps,
            kind="another shot" if error is None else kind,
            error=error,
        )
        for steps, error in errors.items()
    )
